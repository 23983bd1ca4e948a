//! The particles that a plane meets, found once: then a point needs to look at a few discs, not at 27 cells.

use super::Grain;
use super::eval::{Candidate, Look, SectionKind, Side};
use super::shape::{Body, Convex, N_OPENING};
use super::spec::{Contact, Profile};
use crate::math::{BATCH, DVec2, DVec3, Vec2, Vec3, vec2};
use crate::par::Level;
use crate::section::{CutSurface, Plane};

/// A part of a plane: where its coordinates are zero, their axes, and how far they go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// A point of the plane, model space; best in the middle of what is asked for.
    pub origin: DVec3,
    /// +u and +v: orthogonal unit vectors; with the plane's normal a right-handed frame.
    pub axes: [DVec3; 2],
    /// Least plane coordinates, model units.
    pub min: Vec2,
    /// Greatest.
    pub max: Vec2,
}

/// A particle that the plane meets.
#[derive(Clone, Copy, Debug)]
pub struct Disc<'a> {
    /// Its name, cell, centre and reach.
    pub particle: Candidate,
    /// The centre, moved onto the plane; plane coordinates, model units.
    pub at: Vec2,
    /// The centre's height above the plane along its normal, model units.
    pub height: f32,
    /// The section lies within this distance of `at`, model units; for balls this is its radius.
    pub radius: f32,
    /// Whether the particle goes with the half below.
    pub is_below: bool,
    pub(super) body: Body<'a>,
}

/// The particles that a plane meets in a window, sorted into squares.
#[derive(Clone, Debug)]
pub struct Discs<'a> {
    pub(super) grain: &'a Grain,
    pub(super) plane: Plane,
    pub(super) window: Window,
    pub(super) discs: Vec<Disc<'a>>,
    /// For each disc that is not of a ball, the polygon that stands for its opening, seen from its centre, in spacings.
    pub(super) openings: Vec<[Vec3; N_OPENING]>,
    /// Width of a square.
    pitch: f32,
    n_squares: [usize; 2],
    /// Where each square's discs start in `order`.
    starts: Vec<u32>,
    order: Vec<u32>,
    /// The greatest radius.
    pub(super) max_radius: f32,
}

/// More cells are not listed: each would be smaller than what can be seen.
pub(super) const MAX_CELLS: f64 = 4e6;

impl Grain {
    /// The particles that a plane meets in a window of it.
    ///
    /// None if there are millions, as whoever asks sees nothing but the far model; and for the paper's profile and
    /// overlapping particles, where one point may have several.
    pub fn discs(&self, plane: &Plane, window: Window) -> Option<Discs<'_>> {
        let is_simple = self.spec.profile == Profile::Fixed && self.spec.contact != Contact::Overlapping;
        let spacing = self.spec.spacing as f64;
        let size = (window.max - window.min).as_dvec2() / spacing;
        let n_cells = (size.x + 4.0) * (size.y + 4.0);
        if !is_simple || n_cells.is_nan() || n_cells > MAX_CELLS {
            return None;
        }
        let mut list = Vec::new();
        let n = self.to_lattice(plane.normal);
        let pad = self.reach() + self.spec.bevel * self.spec.spacing;
        self.for_cells_at(plane, &window, self.reach, |cell| {
            let offset = self.offset(cell);
            let center = self.model_point(cell, offset);
            let height = plane.distance(center);
            let h = (height / spacing) as f32;
            if h.abs() >= self.reach {
                return;
            }
            let from = center - window.origin;
            let at = vec2(from.dot(window.axes[0]) as f32, from.dot(window.axes[1]) as f32);
            let is_near = at.cmpge(window.min - pad).all() && at.cmple(window.max + pad).all();
            let free = self.free_body(cell);
            // The plane's nearest point, seen from the centre.
            let foot = n * -h;
            if !is_near || !self.grown(free).meets(foot, n) {
                return;
            }
            let body = free.scaled(self.scale(cell, offset, &free));
            if !body.meets(foot, n) {
                return;
            }
            let reach = body.reach();
            list.push(Disc {
                particle: Candidate { cell, id: self.source.id(cell), center, reach: reach * self.spec.spacing },
                at,
                height: height as f32,
                radius: (reach * reach - h * h).max(0.0).sqrt() * self.spec.spacing,
                is_below: height <= 0.0,
                body,
            });
        });
        Some(Discs::sorted(self, *plane, window, list))
    }

    /// Calls `visit` with every cell whose particle may reach the plane near the window, in a fixed order; none reaches
    /// farther than `reach` spacings from where it hangs.
    pub(super) fn for_cells_at(&self, plane: &Plane, window: &Window, reach: f32, mut visit: impl FnMut([i32; 3])) {
        let spacing = self.spec.spacing as f64;
        let to_lattice = |p: DVec3| self.model_from_lattice.transpose() * p / spacing;
        let n = self.model_from_lattice.transpose() * plane.normal;
        let offset = plane.offset / spacing;
        let pad = reach as f64 + self.spec.bevel as f64 + self.spec.jitter as f64 * 3f64.sqrt();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (x, y) in [
            (window.min.x, window.min.y),
            (window.max.x, window.min.y),
            (window.min.x, window.max.y),
            (window.max.x, window.max.y),
        ] {
            let corner = to_lattice(window.origin + window.axes[0] * x as f64 + window.axes[1] * y as f64);
            (low, high) = (low.min(corner), high.max(corner));
        }
        let (low, high) = ((low - pad).floor().as_ivec3(), (high + pad).ceil().as_ivec3());
        // Columns along the axis that the plane crosses most steeply.
        let a = n.abs();
        let k = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let jitter = self.spec.jitter as f64 * (a.x + a.y + a.z);
        let thick = (reach as f64 + jitter) / a[k];
        let axes = window.axes.map(|v| self.model_from_lattice.transpose() * v);
        let origin = to_lattice(window.origin);
        let pad = pad as f32;
        let (least, most) = (window.min / self.spec.spacing - pad, window.max / self.spec.spacing + pad);
        for x in low[i]..=high[i] {
            for y in low[j]..=high[j] {
                let middle = (offset - n[i] * x as f64 - n[j] * y as f64) / n[k];
                for z in (middle - thick).ceil() as i32..=(middle + thick).floor() as i32 {
                    let mut cell = [0; 3];
                    (cell[i], cell[j], cell[k]) = (x, y, z);
                    let from = DVec3::new(cell[0] as f64, cell[1] as f64, cell[2] as f64) - origin;
                    let at = vec2(from.dot(axes[0]) as f32, from.dot(axes[1]) as f32);
                    if at.cmpge(least).all() && at.cmple(most).all() {
                        visit(cell);
                    }
                }
            }
        }
    }
}

impl<'a> Discs<'a> {
    /// Sorts discs into squares of about a spacing.
    fn sorted(grain: &'a Grain, plane: Plane, window: Window, discs: Vec<Disc<'a>>) -> Self {
        let size = window.max - window.min;
        let pitch = grain.spec.spacing.max(size.max_element() / 2048.0);
        let n_squares = [size.x, size.y].map(|x| (x / pitch).ceil().max(1.0) as usize);
        let n = grain.to_lattice(plane.normal);
        let is_balls = discs.first().is_none_or(|d| matches!(d.body, Body::Ball(_)));
        let openings = match is_balls {
            true => Vec::new(),
            false => discs.iter().map(|d| d.body.opening(-d.height / grain.spec.spacing, n)).collect(),
        };
        let mut sorted = Self {
            grain,
            plane,
            window,
            openings,
            max_radius: discs.iter().map(|d| d.radius).fold(0.0, f32::max),
            discs,
            pitch,
            n_squares,
            starts: vec![0; n_squares[0] * n_squares[1] + 1],
            order: Vec::new(),
        };
        let squares: Vec<usize> = sorted.discs.iter().map(|d| sorted.square(d.at)).collect();
        squares.iter().for_each(|&s| sorted.starts[s + 1] += 1);
        for s in 1..sorted.starts.len() {
            sorted.starts[s] += sorted.starts[s - 1];
        }
        let mut next = sorted.starts.clone();
        sorted.order = vec![0; squares.len()];
        for (i, &s) in squares.iter().enumerate() {
            sorted.order[next[s] as usize] = i as u32;
            next[s] += 1;
        }
        sorted
    }

    /// Column and row of the square a place is in; what is outside counts to the nearest.
    fn column_row(&self, at: Vec2) -> [usize; 2] {
        let from = (at - self.window.min) / self.pitch;
        [0, 1].map(|k| (from[k].max(0.0) as usize).min(self.n_squares[k] - 1))
    }

    fn square(&self, at: Vec2) -> usize {
        let [x, y] = self.column_row(at);
        y * self.n_squares[0] + x
    }

    /// All of them, in a fixed order.
    pub fn iter(&self) -> impl Iterator<Item = &Disc<'a>> {
        self.discs.iter()
    }

    /// Where plane coordinates are counted from.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// The same without the discs that `keep` refuses: such as those that stick out of the model's skin.
    pub fn retain(self, keep: impl Fn(&Disc) -> bool) -> Self {
        let Self { grain, plane, window, mut discs, .. } = self;
        discs.retain(keep);
        Self::sorted(grain, plane, window, discs)
    }

    /// Indices of the discs that may matter within a rectangle, in their order.
    pub(super) fn near(&self, min: Vec2, max: Vec2, out: &mut Vec<u32>) {
        out.clear();
        let pad = Vec2::splat(self.max_radius + self.bevel());
        let ([x0, y0], [x1, y1]) = (self.column_row(min - pad), self.column_row(max + pad));
        for y in y0..=y1 {
            let row = y * self.n_squares[0];
            let range = self.starts[row + x0] as usize..self.starts[row + x1 + 1] as usize;
            for &i in &self.order[range] {
                let d = &self.discs[i as usize];
                let reach = d.radius + self.bevel();
                // Nearest point of the rectangle.
                if (d.at - d.at.clamp(min, max)).length_squared() <= reach * reach {
                    out.push(i);
                }
            }
        }
        out.sort_unstable();
    }

    /// Width and depth of bevels, model units.
    pub(super) fn bevel(&self) -> f32 {
        self.grain.spec.bevel * self.grain.spec.spacing
    }

    /// The outline of a disc, as a polygon of so many corners: plane coordinates in model units, counter-clockwise.
    pub fn outline(&self, disc: &Disc, n_corners: usize) -> Vec<DVec2> {
        let spacing = self.grain.spec.spacing;
        let n = self.grain.to_lattice(self.plane.normal);
        let [u, v] = self.window.axes.map(|a| self.grain.to_lattice(a));
        let place = |p: Vec3| vec2(p.dot(u), p.dot(v)) * spacing + disc.at;
        disc.body.outline(-disc.height / spacing, n, n_corners).map(|p| place(p).as_dvec2()).collect()
    }

    /// Places just inside and just outside of all outlines, for caps in relief: there heights may jump.
    pub fn edges(&self, n_corners: usize) -> Vec<DVec2> {
        let mut edges = Vec::new();
        for disc in &self.discs {
            let outline = self.outline(disc, n_corners);
            let middle = outline.iter().sum::<DVec2>() / n_corners.max(1) as f64;
            for part in [0.98, 1.02] {
                edges.extend(outline.iter().map(|&p| middle + (p - middle) * part));
            }
        }
        edges
    }

    /// The disc's radius if it is one of a ball, model units: then its outline is a circle.
    pub fn circle(&self, disc: &Disc) -> Option<f32> {
        matches!(disc.body, Body::Ball(_)).then_some(disc.radius)
    }

    /// What the section shows at one place: as [`Grain::eval`], from the list.
    pub fn eval(&self, at: Vec2, look: Look) -> super::Hit {
        let mut hits = super::Hits::new();
        let mut scratch = Vec::new();
        let (mut xs, mut ys) = ([0.0; BATCH], [0.0; BATCH]);
        (xs[0], ys[0]) = (at.x, at.y);
        self.eval_batch(Level::baseline(), [&xs, &ys], 1, look, (&mut scratch, &mut hits));
        hits.hit(0)
    }

    /// Along the model's axes: +u, +v and the normal out of the half that is looked at.
    pub(super) fn frame(&self, look: Look) -> [Vec3; 3] {
        let n = if look.side == Side::Below { self.plane.normal } else { -self.plane.normal };
        [self.window.axes[0].as_vec3(), self.window.axes[1].as_vec3(), n.as_vec3()]
    }

    /// Whether a disc is a bump, seen from a side.
    pub(super) fn is_bump(disc: &Disc, look: Look) -> bool {
        look.kind == SectionKind::Tear && disc.is_below == (look.side == Side::Below)
    }

    /// A place seen from a particle's centre, as its body counts.
    pub(super) fn seen_from(&self, disc: &Disc, [u, v, n]: [Vec3; 3], at: Vec2) -> Vec3 {
        let d = (at - disc.at) / self.grain.spec.spacing;
        u * d.x + v * d.y - n * (disc.height / self.grain.spec.spacing)
    }
}

impl Window {
    /// Plane coordinates of a point of the plane, model units.
    pub fn coordinates(&self, p: DVec3) -> Vec2 {
        let from = p - self.origin;
        vec2(from.dot(self.axes[0]) as f32, from.dot(self.axes[1]) as f32)
    }

    /// The point of the model at plane coordinates.
    pub fn point(&self, at: Vec2) -> DVec3 {
        self.origin + self.axes[0] * at.x as f64 + self.axes[1] * at.y as f64
    }

    /// Around a plane's point, so far in each direction.
    pub fn around(plane: &Plane, center: DVec3, half: Vec2) -> Self {
        let origin = center - plane.normal * plane.distance(center);
        Self { origin, axes: plane.axes(), min: -half, max: half }
    }
}
