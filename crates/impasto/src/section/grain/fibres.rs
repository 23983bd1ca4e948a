//! Fibres: long round bars on a hexagonal lattice across one direction, for muscle, wood and meat.
//!
//! A place is looked up in the plane across the fibres, so that their length costs nothing. Along each fibre, breaks part
//! it into pieces; a piece is the particle, and goes with the half that holds its centre: torn, pieces stick out or leave
//! holes. Radii shrink until neighbours fit, as those of other particles do.

use super::check::{positive, within};
use super::eval::{Candidate, Hit, HitKind, Look, SectionKind, Side};
use super::rod::Rod;
use super::shape::{Body, Convex};
use super::slices::Breaks;
use super::spec::parameter;
use super::{MARGIN, place_of};
use crate::Result;
use crate::math::{DMat3, DVec2, DVec3, Vec2, Vec3, exact, hash, hash_cell, unit_float};
use crate::section::CutSurface;

/// Fibres as a person describes them.
#[derive(Clone, Debug, PartialEq)]
pub struct FibresSpec {
    /// Between neighbouring fibres' middles, model units.
    pub spacing: f32,
    /// Their radius before it is perturbed, model units.
    pub radius: f32,
    /// Where they run, model space.
    pub axis: Vec3,
    /// Mean length of pieces, model units.
    pub length: f32,
    /// Between the ends of two pieces, model units.
    pub gap: f32,
    /// How far fibres move off the lattice, in spacings: 0 to 0.4.
    pub jitter: f32,
    /// How much radii differ.
    pub size_spread: f32,
    /// Radius of the rounded rims, as a part of the radius.
    pub rounding: f32,
    /// Depth and width of a solid cut's bevel, in spacings.
    pub bevel: f32,
    /// Another seed, other fibres.
    pub seed: u32,
}

impl FibresSpec {
    /// Fibres with the usual irregularity, in pieces of 12 spacings.
    pub fn of(spacing: f32, radius: f32, axis: Vec3) -> Self {
        let (length, gap) = (spacing * 12.0, spacing * 0.1);
        let (jitter, size_spread, rounding, bevel) = (0.12, 0.25, 0.3, 0.07);
        Self { spacing, radius, axis, length, gap, jitter, size_spread, rounding, bevel, seed: 0 }
    }
}

/// Checked fibres, ready to be asked.
#[derive(Clone, Debug)]
pub struct Fibres {
    pub(super) spec: FibresSpec,
    /// A rotation whose third column is the fibres' direction.
    pub(super) model_from_fibres: DMat3,
    pub(super) radius: f32,
    pub(super) length: f32,
    pub(super) gap: f32,
}

/// Pieces by their keys, and which of them to ask.
#[derive(Clone, Copy)]
pub(super) struct PieceList<'a> {
    pub(super) pieces: &'a [([i32; 3], Breaks)],
    pub(super) indices: &'a [u32],
}

/// A piece of a fibre, in spacings, seen from the place asked for.
struct Piece {
    key: [i32; 3],
    /// The place seen from its centre.
    m: Vec3,
    body: Body<'static>,
}

impl Fibres {
    /// Fibres from their description.
    ///
    /// # Errors
    /// A number that makes no sense.
    pub fn new(spec: FibresSpec) -> Result<Self> {
        positive("spacing", spec.spacing)?;
        positive("radius", spec.radius)?;
        positive("length", spec.length)?;
        within("jitter", spec.jitter, 0.0..=0.4, "from 0 to 0.4 spacings")?;
        within("size spread", spec.size_spread, 0.0..=0.95, "from 0 to 0.95")?;
        within("rounding", spec.rounding, 0.0..=1.0, "from 0 to 1 radius")?;
        within("bevel", spec.bevel, 0.0..=0.5, "from 0 to 0.5 spacings")?;
        within("radius", spec.radius, 0.0..=spec.spacing, "at most a spacing")?;
        within("length", spec.length, spec.spacing * 0.5..=spec.spacing * 1e4, "from half a spacing to 10000")?;
        within("gap", spec.gap, 0.0..=spec.length * 0.25, "from 0 to a quarter of the length")?;
        let axis = spec.axis.as_dvec3();
        if !axis.is_finite() || axis.length() < 1e-30 {
            let given = format!("{},{},{}", spec.axis.x, spec.axis.y, spec.axis.z);
            return Err(parameter("axis", given, "it needs three finite numbers that are not all zero"));
        }
        let plane = crate::section::Plane { normal: axis.normalize(), offset: 0.0 };
        let [u, v] = plane.axes();
        // Turned about the axis by an angle that is no part of a circle, so that no section runs along its rows.
        let (sin, cos) = (exact::sin(0.3), exact::cos(0.3));
        let [u, v] = [u * cos + v * sin, v * cos - u * sin];
        let per = 1.0 / spec.spacing;
        Ok(Self {
            model_from_fibres: DMat3::from_cols(u, v, plane.normal),
            radius: spec.radius * per,
            length: spec.length * per,
            gap: spec.gap * per,
            spec,
        })
    }

    /// The description they were made from.
    pub fn spec(&self) -> &FibresSpec {
        &self.spec
    }

    /// A rotation whose third column is the fibres' direction.
    pub(in crate::section) fn model_from_fibres(&self) -> DMat3 {
        self.model_from_fibres
    }

    /// What a cut shows at a point of it, in model space; see [`Grain::eval`](super::Grain::eval).
    pub fn eval(&self, p: DVec3, surface: &impl CutSurface, look: Look) -> Hit {
        self.eval_where(p, surface, look, |_| true)
    }

    /// The same without the pieces that `keep` refuses.
    pub fn eval_where(
        &self,
        p: DVec3,
        surface: &impl CutSurface,
        look: Look,
        keep: impl Fn(&Candidate) -> bool,
    ) -> Hit {
        self.eval_among(p, surface, look, keep, None)
    }

    /// The same, asking only these pieces, if there is a list.
    pub(super) fn eval_among(
        &self,
        p: DVec3,
        surface: &impl CutSurface,
        look: Look,
        keep: impl Fn(&Candidate) -> bool,
        list: Option<PieceList>,
    ) -> Hit {
        let spacing = self.spec.spacing;
        let turn = self.model_from_fibres.transpose();
        let q = turn * p / spacing as f64;
        let outward = if look.side == Side::Below { surface.normal(p) } else { -surface.normal(p) };
        let n = (turn * outward).as_vec3();
        let t = self.spec.bevel;
        let solid = look.kind == SectionKind::Solid;
        let rest = if solid { -t } else { 0.0 };
        let mut best = Hit::matrix(n, rest);
        self.for_pieces(q, if solid { t } else { 0.0 }, list, |piece| {
            let Piece { key, m, body } = piece;
            let center = self.model_from_fibres * ((q - m.as_dvec3()) * spacing as f64);
            let id = self.hash(key).max(1);
            let candidate = Candidate { cell: key, id, center, reach: body.reach() * spacing };
            if solid {
                if !body.meets(m, n) || !keep(&candidate) {
                    return;
                }
                let gap = body.gap(m, n);
                if gap.distance < t && -gap.distance.max(0.0) > best.height {
                    let (kind, normal) = match gap.distance > 0.0 {
                        true => (HitKind::Bevel, (n + gap.away).normalize_or(n)),
                        false => (HitKind::Disc, n),
                    };
                    let openness = 0.5 + 0.5 * normal.dot(n);
                    best = Hit { height: -gap.distance.max(0.0), normal, kind, particle: id, openness, ..best };
                }
            } else if body.holds(m) && keep(&candidate) {
                let is_below = surface.distance(center) <= 0.0;
                let is_bump = look.kind == SectionKind::Tear && is_below == (look.side == Side::Below);
                let exit = body.exit(m, if is_bump { n } else { -n });
                let sign = if is_bump { 1.0 } else { -1.0 };
                let openness = match is_bump {
                    true => 0.5 + 0.5 * exit.normal.dot(n),
                    false => body.cavity_openness(m, n, &exit),
                };
                let kind = if is_bump { HitKind::Bump } else { HitKind::Cavity };
                best = Hit {
                    height: exit.distance * sign,
                    normal: exit.normal * sign,
                    kind,
                    particle: id,
                    openness,
                    ..best
                };
            }
        });
        let normal = (self.model_from_fibres * best.normal.as_dvec3()).as_vec3();
        Hit { height: best.height * spacing, normal, ..best }
    }

    /// Calls `visit` with the pieces that are nearer than `margin` to a place, in a fixed order.
    fn for_pieces(&self, q: DVec3, margin: f32, list: Option<PieceList>, mut visit: impl FnMut(Piece)) {
        if let Some(PieceList { pieces, indices }) = list {
            for &i in indices {
                let (key, breaks) = &pieces[i as usize];
                let flat = (DVec2::new(q.x, q.y) - breaks.middle).as_vec2();
                let free = breaks.free_radius + margin;
                if flat.length_squared() <= free * free {
                    let (k, part) = place_of(DVec3::new(q.z / self.length as f64 + breaks.phase, 0.0, 0.0));
                    let steps = key[2].wrapping_sub(k[0]) as f32;
                    if steps.abs() <= 1.0
                        && let Some(piece) =
                            self.piece(*key, (steps, part.x), breaks.radius, breaks.shifts, flat, margin)
                    {
                        visit(piece);
                    }
                }
            }
            return;
        }
        let rows = 0.75f64.sqrt();
        let row = (q.y / rows + 0.5).floor();
        let column = (q.x - shift(row as i32) + 0.5).floor();
        for y in -2..=2 {
            for x in -2..=2 {
                let key = [(column as i32).wrapping_add(x), (row as i32).wrapping_add(y)];
                let middle = self.middle(key);
                let flat = (DVec2::new(q.x, q.y) - middle).as_vec2();
                let free = self.free_radius(key) + margin;
                if flat.length_squared() > free * free {
                    continue;
                }
                let radius = self.radius_of(key);
                // The piece at this height, and its neighbours where the place is between two.
                let along = q.z / self.length as f64 + unit_float(hash(self.hash([key[0], key[1], 0]) ^ 7)) as f64;
                let (k, part) = place_of(DVec3::new(along, 0.0, 0.0));
                for piece in k[0].wrapping_sub(1)..=k[0].wrapping_add(1) {
                    let shifts = [piece, piece.wrapping_add(1)].map(|j| self.shift_of_break(key, j));
                    let steps = piece.wrapping_sub(k[0]) as f32;
                    let key = [key[0], key[1], piece];
                    self.piece(key, (steps, part.x), radius, shifts, flat, margin).into_iter().for_each(&mut visit);
                }
            }
        }
    }

    /// A piece so many lengths before or behind the place's own, of which `part` is behind it; none if it is farther away
    /// than `margin`.
    fn piece(
        &self,
        key: [i32; 3],
        (steps, part): (f32, f32),
        radius: f32,
        shifts: [f32; 2],
        flat: Vec2,
        margin: f32,
    ) -> Option<Piece> {
        let half = self.half(shifts);
        // From the place, in spacings.
        let center = (steps + (0.5 * (1.0 + shifts[0] + shifts[1]) - part)) * self.length;
        if half <= 0.0 || center.abs() > half + margin {
            return None;
        }
        let rounding = (self.spec.rounding * radius).min(half);
        let body = Body::Rod(Rod { axis: Vec3::Z, radius, half, rounding, domed: false });
        Some(Piece { key, m: flat.extend(-center), body })
    }

    /// Half the length of a piece between breaks that are so far off their places.
    pub(super) fn half(&self, shifts: [f32; 2]) -> f32 {
        ((1.0 + (shifts[1] - shifts[0])) * self.length - self.gap) * 0.5
    }

    /// How far a break lies off its place, in lengths: pieces are between 0.3 and 1.7 lengths long.
    pub(super) fn shift_of_break(&self, key: [i32; 2], k: i32) -> f32 {
        0.7 * (unit_float(hash(self.hash([key[0], key[1], k]) ^ 3)) - 0.5)
    }

    /// A fibre's middle in the plane across.
    pub(super) fn middle(&self, [x, y]: [i32; 2]) -> DVec2 {
        let h = self.hash([x, y, 0]);
        let off = |k: u32| (unit_float(hash(h.wrapping_add(k))) * 2.0 - 1.0) as f64 * self.spec.jitter as f64;
        DVec2::new(x as f64 + shift(y) + off(1), y as f64 * 0.75f64.sqrt() + off(2))
    }

    pub(super) fn free_radius(&self, [x, y]: [i32; 2]) -> f32 {
        let a = unit_float(hash(self.hash([x, y, 0]).wrapping_add(4))) * 2.0 - 1.0;
        self.radius * (1.0 + self.spec.size_spread * a)
    }

    /// The weighted split among the neighbours that can be near.
    pub(super) fn radius_of(&self, key: [i32; 2]) -> f32 {
        let own = self.free_radius(key);
        let middle = self.middle(key);
        let mut scale = 1.0f32;
        for y in -3..=3 {
            for x in -3..=3 {
                if [x, y] != [0, 0] {
                    let other = [key[0].wrapping_add(x), key[1].wrapping_add(y)];
                    let length = (self.middle(other) - middle).as_vec2().length();
                    scale = scale.min(length / (own + self.free_radius(other)));
                }
            }
        }
        own * scale * (1.0 - MARGIN)
    }

    pub(super) fn hash(&self, key: [i32; 3]) -> u32 {
        hash_cell(key[0], key[1], key[2], self.spec.seed)
    }
}

/// Every other row of a hexagonal lattice is shifted by half.
pub(super) fn shift(row: i32) -> f64 {
    if row & 1 == 0 { 0.0 } else { 0.5 }
}
