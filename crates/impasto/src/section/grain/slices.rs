//! The bodies that a plane goes through near a window of it, each found once.

use super::curve::Curve;
use super::discs::MAX_CELLS;
use super::eval::Candidate;
use super::outline::{View, section_curve};
use super::rod::Rod;
use super::shape::{Body, Convex};
use super::spec::Profile;
use super::{Fibres, Grain, Window};
use crate::math::{DVec2, DVec3, Vec3, hash, unit_float, vec2};
use crate::section::{CutSurface, Plane};

/// A particle whose body a plane goes through, or nearly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slice<'a> {
    /// Its name, its cell (a fibre's piece: its key), centre and reach.
    pub(super) particle: Candidate,
    /// From the cell's node to the centre, spacings.
    pub(super) offset: Vec3,
    /// The centre, moved onto the plane; plane coordinates, model units.
    pub(super) at: DVec2,
    /// The centre's height above the plane along its normal, model units.
    pub(super) height: f64,
    pub(super) body: Body<'a>,
}

/// Rounding may take a particle to the plane that just misses it; spacings.
const NEARLY: f32 = 1e-5;

impl Slice<'_> {
    /// Its outline, plane coordinates in model units: `to_own` turns model directions to the body's space.
    pub(super) fn outline(
        &self,
        plane: &Plane,
        window: &Window,
        spacing: f64,
        to_own: impl Fn(DVec3) -> DVec3,
    ) -> Option<Curve> {
        let [u, v] = window.axes.map(&to_own);
        let view = View { u, v, n: to_own(plane.normal), height: self.height / spacing };
        section_curve(&self.body, &view).map(|curve| curve.moved(self.at, spacing))
    }
}

/// Whether the plane through `foot`, the point nearest to the centre, goes through the body, or nearly.
fn nearly_meets(body: &Body, foot: Vec3, n: Vec3) -> bool {
    let offset = foot.dot(n);
    offset < body.support(n).dot(n) + NEARLY && -offset < body.support(-n).dot(-n) + NEARLY
}

/// Plane coordinates of a point moved onto the plane.
pub(super) fn on_plane(window: &Window, p: DVec3) -> DVec2 {
    let from = p - window.origin;
    DVec2::new(from.dot(window.axes[0]), from.dot(window.axes[1]))
}

impl Grain {
    /// The particles that a plane goes through in a window of it and a little beyond, in the lattice's order. None if
    /// there are millions.
    pub(super) fn slices(
        &self,
        plane: &Plane,
        window: &Window,
        keep: &dyn Fn(&Candidate) -> bool,
    ) -> Option<Vec<Slice<'_>>> {
        let spacing = self.spec.spacing as f64;
        let size = (window.max - window.min).as_dvec2() / spacing;
        let n_cells = (size.x + 4.0) * (size.y + 4.0);
        if n_cells.is_nan() || n_cells > MAX_CELLS {
            return None;
        }
        // The paper's cylinders hang by their base.
        let is_hung = self.spec.profile == Profile::Paper;
        let reach = if is_hung { 2.0 * self.reach } else { self.reach };
        let pad = (reach + self.spec.bevel) * self.spec.spacing;
        let (min, max) = ((window.min - pad).as_dvec2(), (window.max + pad).as_dvec2());
        let n = self.to_lattice(plane.normal);
        let mut slices = Vec::new();
        self.for_cells_at(plane, window, reach, |cell| {
            let node_to_anchor = self.offset(cell);
            let free = self.free_body(cell);
            let offset = match free {
                Body::Rod(rod) if is_hung => node_to_anchor + rod.axis * rod.half,
                _ => node_to_anchor,
            };
            let center = self.model_point(cell, offset);
            let at = on_plane(window, center);
            let height = plane.distance(center);
            let foot = n * -((height / spacing) as f32);
            let is_near = at.cmpge(min).all() && at.cmple(max).all();
            if !is_near || !nearly_meets(&self.grown(free), foot, n) {
                return;
            }
            let body = free.scaled(self.scale(cell, offset, &free));
            let particle =
                Candidate { cell, id: self.source.id(cell), center, reach: body.reach() * self.spec.spacing };
            if nearly_meets(&body, foot, n) && keep(&particle) {
                slices.push(Slice { particle, offset, at, height, body });
            }
        });
        slices.sort_by_key(|s| s.particle.cell);
        Some(slices)
    }
}

/// Where the breaks of a fibre's piece are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Breaks {
    /// The fibre's middle in the plane across, spacings.
    pub(super) middle: DVec2,
    pub(super) free_radius: f32,
    pub(super) radius: f32,
    /// How far the fibre is shifted along itself, lengths.
    pub(super) phase: f64,
    /// How far the two breaks are off their places, lengths.
    pub(super) shifts: [f32; 2],
}

impl Fibres {
    /// The pieces that a plane goes through in a window of it and a little beyond, row by row. None if there are millions.
    pub(super) fn slices(
        &self,
        plane: &Plane,
        window: &Window,
        keep: &dyn Fn(&Candidate) -> bool,
    ) -> Option<Vec<(Slice<'_>, Breaks)>> {
        let spacing = self.spec.spacing as f64;
        let turn = self.model_from_fibres.transpose();
        let n = turn * plane.normal;
        let most = self.radius * (1.0 + self.spec.size_spread) + self.spec.bevel;
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| {
            let at = vec2([window.min.x, window.max.x][i], [window.min.y, window.max.y][j]);
            turn * window.point(at) / spacing
        });
        let pad = (most + 2.0 * self.spec.jitter) as f64 + 1.0;
        let low = corners.iter().fold(DVec3::INFINITY, |a, &b| a.min(b)) - pad;
        let high = corners.iter().fold(DVec3::NEG_INFINITY, |a, &b| a.max(b)) + pad;
        let row = 0.75f64.sqrt();
        let n_keys = (high.x - low.x) * (high.y - low.y) / row;
        let n_pieces = n_keys * (1.0 + (high.z - low.z) * n.z.abs().min(1.0) / self.length as f64);
        if n_pieces.is_nan() || n_pieces > MAX_CELLS {
            return None;
        }
        let mut slices = Vec::new();
        for y in (low.y / row).floor() as i32..=(high.y / row).ceil() as i32 {
            for x in low.x.floor() as i32..=high.x.ceil() as i32 {
                self.pieces_of([x, y], (plane, window), (n, [low, high]), |s, b| {
                    if keep(&s.particle) {
                        slices.push((s, b));
                    }
                });
            }
        }
        Some(slices)
    }

    /// The pieces of one fibre.
    fn pieces_of(
        &self,
        key: [i32; 2],
        (plane, window): (&Plane, &Window),
        (n, [low, high]): (DVec3, [DVec3; 2]),
        mut visit: impl FnMut(Slice<'static>, Breaks),
    ) {
        let spacing = self.spec.spacing as f64;
        let middle = self.middle(key);
        let free_radius = self.free_radius(key);
        // Where the fibre's axis, and then its side, goes through the plane.
        let offset = plane.offset / spacing;
        let spread = (free_radius + self.spec.bevel) as f64;
        let (mut from, mut to) = (low.z, high.z);
        let across = (1.0 - n.z * n.z).max(0.0).sqrt();
        if n.z.abs() > 1e-3 {
            let z = (offset - n.x * middle.x - n.y * middle.y) / n.z;
            let reach = (spread * across + NEARLY as f64) / n.z.abs();
            (from, to) = (from.max(z - reach), to.min(z + reach));
        } else if (offset - n.x * middle.x - n.y * middle.y).abs()
            > spread + (to - from) * n.z.abs() + high.z.abs().max(low.z.abs()) * n.z.abs()
        {
            return;
        }
        // The point of the plane nearest to the axis must be near the window.
        let at_z = |z: f64| self.model_from_fibres * (middle.extend(z) * spacing);
        let ends = [from, to].map(|z| on_plane(window, at_z(z)));
        let pad = (spread * spacing) as f32;
        let (a, b) = (ends[0].min(ends[1]).as_vec2(), ends[0].max(ends[1]).as_vec2());
        if from > to || b.cmplt(window.min - pad).any() || a.cmpgt(window.max + pad).any() {
            return;
        }
        let radius = self.radius_of(key);
        let phase = unit_float(hash(self.hash([key[0], key[1], 0]) ^ 7)) as f64;
        let length = self.length as f64;
        for k in ((from / length + phase).floor() as i32 - 1)..=((to / length + phase).ceil() as i32 + 1) {
            let shifts = [k, k.wrapping_add(1)].map(|j| self.shift_of_break(key, j));
            let z = |j: i32, shift: f32| (j as f64 + shift as f64 - phase) * length;
            let (low, high) = (z(k, shifts[0]), z(k.wrapping_add(1), shifts[1]));
            let half = self.half(shifts);
            if half <= 0.0 {
                continue;
            }
            let rounding = (self.spec.rounding * radius).min(half);
            let body = Body::Rod(Rod { axis: Vec3::Z, radius, half, rounding, domed: false });
            let center = at_z(0.5 * (low + high));
            let height = plane.distance(center);
            let foot = n.as_vec3() * -((height / spacing) as f32);
            if !nearly_meets(&body, foot, n.as_vec3()) {
                continue;
            }
            let cell = [key[0], key[1], k];
            let particle =
                Candidate { cell, id: self.hash(cell).max(1), center, reach: body.reach() * self.spec.spacing };
            let slice = Slice { particle, offset: Vec3::ZERO, at: on_plane(window, center), height, body };
            visit(slice, Breaks { middle, free_radius, radius, phase, shifts });
        }
    }
}
