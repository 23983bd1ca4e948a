//! Rows of places on a plane against the bodies that it goes through: each place asks the few bodies of its block.
//!
//! The answers are those of [`Grain::eval`], to the bit: the same operations on the same numbers, only that no body is
//! asked which cannot matter, and that what is the same for all places of a body is worked out once.

use super::blocks::Blocks;
use super::discs::Window;
use super::eval::{Candidate, Hit, HitKind, Look, Raw, SectionKind, Side};
use super::openness::{LANES, form_factors, stepped};
use super::shape::{Body, Convex, Exit, N_OPENING};
use super::spec::{Contact, Profile};
use super::{Grain, Place};
use crate::math::{BATCH, DVec2, DVec3, Lane, Vec3, vec2};
use crate::par::Level;
use crate::section::Plane;
use fearless_simd::{Simd, dispatch};

/// A body that the plane goes through.
#[derive(Clone, Debug)]
struct Listed<'a> {
    cell: [i32; 3],
    id: u32,
    offset: Vec3,
    is_below: bool,
    body: Body<'a>,
    /// The same at the greatest size, which is asked first about bevels.
    grown: Body<'a>,
    /// How far body and grown body reach along the outward normal, and against it.
    tips: [[f32; 2]; 2],
    /// A cylinder about this axis holds the body: half its height, its squared radius.
    axis: Vec3,
    half: f32,
    squared: f32,
    /// Its opening, and for what offset of the plane.
    opening: Option<(f32, [Vec3; N_OPENING])>,
}

/// The bodies of a grain in a window of a plane, for one look.
#[derive(Clone, Debug)]
pub(super) struct Bodies<'a> {
    grain: &'a Grain,
    window: Window,
    look: Look,
    /// The plane's normal and the outward one, lattice.
    outward: Vec3,
    bodies: Vec<Listed<'a>>,
    blocks: Blocks,
}

/// Places of a batch on the lattice.
struct Places {
    cell: [[i32; BATCH]; 3],
    local: [Lane; 3],
}

/// Places of one body: which, how many, their lanes, and seen from its centre.
type Group = (u32, usize, [usize; LANES], [Vec3; LANES]);

/// Rounding must not keep a place from a body that holds it.
const SLACK: f32 = 1.000_1;

impl<'a> Bodies<'a> {
    /// None where particles overlap or follow the paper, and for millions of them.
    pub(super) fn of(
        grain: &'a Grain,
        (plane, window): (&Plane, &Window),
        look: Look,
        keep: &dyn Fn(&Candidate) -> bool,
    ) -> Option<Self> {
        if grain.spec.profile != Profile::Fixed || grain.spec.contact == Contact::Overlapping {
            return None;
        }
        let n = grain.to_lattice(plane.normal);
        let outward = if look.side == Side::Below { n } else { -n };
        let spacing = grain.spec.spacing as f64;
        let axes = window.axes.map(|a| grain.to_lattice(a));
        let (mut bodies, mut boxes) = (Vec::new(), Vec::new());
        for slice in grain.slices(plane, window, keep)? {
            let free = grain.free_body(slice.particle.cell);
            let body = slice.body;
            let grown = grain.grown(free);
            let tips = [body, grown].map(|b| [b.support(outward).dot(outward), b.support(-outward).dot(-outward)]);
            let bevel = if look.kind == SectionKind::Solid { grain.spec.bevel } else { 0.0 };
            let (axis, half, radius) = with_bevel(&body, bevel);
            let foot = outward * -((slice.height / spacing) as f32 * if look.side == Side::Below { 1.0 } else { -1.0 });
            let is_open = look.kind != SectionKind::Solid && !matches!(body, Body::Ball(_));
            let key = stepped(foot.dot(outward));
            boxes.push(grain.bounds(&body, (slice.at, slice.height), axes, look));
            bodies.push(Listed {
                cell: slice.particle.cell,
                id: slice.particle.id,
                offset: slice.offset,
                is_below: slice.height <= 0.0,
                body,
                grown,
                tips,
                axis,
                half: half * SLACK,
                squared: radius * radius * SLACK,
                opening: is_open.then(|| (key, body.opening(key, outward))),
            });
        }
        let blocks = Blocks::of(window, grain.spec.spacing * 0.25, &boxes);
        Some(Self { grain, window: *window, look, outward, bodies, blocks })
    }

    /// What the section shows at places of a row within the window.
    pub(super) fn row(&self, level: Level, y: f32, xs: &[f32], out: &mut [Hit]) {
        let mut places = Places { cell: [[0; BATCH]; 3], local: [[0.0; BATCH]; 3] };
        for (xs, out) in xs.chunks(BATCH).zip(out.chunks_mut(BATCH)) {
            dispatch!(level, simd => self.place(simd, y, xs, &mut places));
            let mut start = 0;
            while start < xs.len() {
                let block = self.blocks.index(vec2(xs[start], y));
                let mut end = start + 1;
                while end < xs.len() && self.blocks.index(vec2(xs[end], y)) == block {
                    end += 1;
                }
                match block {
                    None => {}
                    Some(block) if self.look.kind == SectionKind::Solid => {
                        (start..end).for_each(|i| out[i] = self.solid(self.blocks.list(block), &places.at(i)));
                    }
                    Some(block) => dispatch!(level, simd => self.open(simd, block, start..end, &places, out)),
                }
                start = end;
            }
        }
    }

    /// Where the places of a row are: as [`Grain::place`] has it.
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, y: f32, xs: &[f32], out: &mut Places) {
        let turn = self.grain.model_from_lattice.transpose();
        let spacing = self.grain.spec.spacing as f64;
        let (origin, [u, v]) = (self.window.origin, self.window.axes);
        simd.vectorize(
            #[inline(always)]
            || {
                for i in 0..xs.len().min(BATCH) {
                    let p = origin + u * xs[i] as f64 + v * y as f64;
                    let q = turn * p / spacing;
                    let node = (q + DVec3::splat(0.5)).floor();
                    let local = q - node;
                    out.cell[0][i] = node.x as i32;
                    out.cell[1][i] = node.y as i32;
                    out.cell[2][i] = node.z as i32;
                    out.local[0][i] = local.x as f32;
                    out.local[1][i] = local.y as f32;
                    out.local[2][i] = local.z as f32;
                }
            },
        );
    }

    /// Torn and hollow: at most one body holds a place.
    #[inline(always)]
    fn open<S: Simd>(&self, simd: S, block: usize, lanes: std::ops::Range<usize>, places: &Places, out: &mut [Hit]) {
        let mut near = [false; BATCH];
        let mut found: [Option<(u32, Vec3)>; BATCH] = [None; BATCH];
        for &k in self.blocks.list(block) {
            let b = &self.bodies[k as usize];
            simd.vectorize(
                #[inline(always)]
                || {
                    for i in lanes.clone() {
                        let m = b.seen(places, i);
                        let along = m.dot(b.axis);
                        near[i] = (along.abs() <= b.half) & (m.dot(m) - along * along <= b.squared);
                    }
                },
            );
            for i in lanes.clone() {
                if near[i] {
                    let m = b.seen(places, i);
                    if b.body.holds(m) && found[i].is_none_or(|other| self.is_before(b, m, other)) {
                        found[i] = Some((k, m));
                    }
                }
            }
        }
        let rest = self.hit(Raw::matrix(self.outward, 0.0));
        // Places of one body side by side.
        let mut group: Group = (0, 0, [0; LANES], [Vec3::ZERO; LANES]);
        for i in lanes {
            let Some((k, m)) = found[i] else {
                out[i] = rest;
                continue;
            };
            if group.1 == LANES || group.0 != k {
                simd.vectorize(
                    #[inline(always)]
                    || self.shown(&group, out),
                );
                (group.0, group.1) = (k, 0);
            }
            (group.2[group.1], group.3[group.1]) = (i, m);
            group.1 += 1;
        }
        simd.vectorize(
            #[inline(always)]
            || self.shown(&group, out),
        );
    }

    /// Which way a ray leaves a body, and whether that is a bump.
    fn way(&self, b: &Listed) -> (Vec3, bool) {
        let is_bump = self.look.kind == SectionKind::Tear && b.is_below == (self.look.side == Side::Below);
        (if is_bump { self.outward } else { -self.outward }, is_bump)
    }

    /// By rounding two bodies may hold a place: those below come first in a tear, then the one that reaches farther.
    fn is_before(&self, b: &Listed, m: Vec3, (other, at): (u32, Vec3)) -> bool {
        let other = &self.bodies[other as usize];
        if self.look.kind == SectionKind::Tear && b.is_below != other.is_below {
            return b.is_below;
        }
        b.body.exit(m, self.way(b).0).distance > other.body.exit(at, self.way(other).0).distance
    }

    /// What places of one body show.
    #[inline(always)]
    fn shown(&self, (k, n, lanes, places): &Group, out: &mut [Hit]) {
        if *n == 0 {
            return;
        }
        let b = &self.bodies[*k as usize];
        let (t, is_bump) = self.way(b);
        let mut exits = [Exit { distance: 0.0, normal: t }; LANES];
        match &b.body {
            Body::Rod(rod) => rod.exits(places, t, *n, &mut exits),
            body => (0..*n).for_each(|i| exits[i] = body.exit(places[i], t)),
        }
        let mut openness = [0.0f32; LANES];
        if is_bump {
            for i in 0..*n {
                openness[i] = 0.5 + 0.5 * exits[i].normal.dot(self.outward);
            }
        } else {
            self.openness(b, (*n, places, &exits), &mut openness);
        }
        for i in 0..*n {
            let exit = exits[i];
            let sign = if is_bump { 1.0 } else { -1.0 };
            out[lanes[i]] = self.hit(Raw {
                height: exit.distance * sign,
                normal: exit.normal * sign,
                kind: if is_bump { HitKind::Bump } else { HitKind::Cavity },
                particle: b.id,
                openness: openness[i],
            });
        }
    }

    #[inline(always)]
    fn openness(&self, b: &Listed, (n, m, exits): (usize, &[Vec3; LANES], &[Exit; LANES]), out: &mut [f32; LANES]) {
        let up = self.outward;
        if let Some((key, opening)) = &b.opening
            && (0..n).all(|i| stepped(m[i].dot(up)) == *key)
        {
            let (mut q, mut normal) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
            for i in 0..LANES {
                let (at, inward) = (m[i] - up * exits[i].distance, -exits[i].normal);
                for c in 0..3 {
                    (q[c][i], normal[c][i]) = (at[c], inward[c]);
                }
            }
            *out = form_factors(opening, &q, &normal);
            return;
        }
        for i in 0..n {
            out[i] = b.body.cavity_openness(m[i], up, &exits[i]);
        }
    }

    fn hit(&self, raw: Raw) -> Hit {
        Hit {
            height: raw.height * self.grain.spec.spacing,
            normal: self.grain.to_model(raw.normal),
            kind: raw.kind,
            particle: raw.particle,
            openness: raw.openness,
            leaf: 0,
            tone: 0.0,
        }
    }

    /// Flat discs and their bevels.
    fn solid(&self, list: &[u32], place: &Place) -> Hit {
        let n = self.outward;
        let full = self.grain.spec.bevel;
        let wide = self.grain.reach + full;
        let mut best = Raw::matrix(n, -full);
        for &k in list {
            let b = &self.bodies[k as usize];
            let m = b.seen_from(place);
            let offset = m.dot(n);
            let meets =
                |body: &Body, [up, down]: [f32; 2]| offset.abs() < body.reach() && offset < up && -offset < down;
            let along = m.dot(b.axis);
            let is_far = along.abs() > b.half || m.dot(m) - along * along > b.squared;
            if is_far || m.dot(m) > wide * wide || !meets(&b.body, b.tips[0]) || !meets(&b.grown, b.tips[1]) {
                continue;
            }
            let gap = b.body.gap(m, n);
            let is_narrow = self.grain.spec.bevel_within_particle;
            let bevel = if is_narrow { full.min(b.body.reach() * 0.5) } else { full };
            if gap.distance >= bevel || -gap.distance.max(0.0) <= best.height {
                continue;
            }
            // A distance of first order need not grow as the body shrinks.
            if b.grown.gap(m, n).distance >= full {
                continue;
            }
            best = if gap.distance <= 0.0 {
                Raw { height: 0.0, normal: n, kind: HitKind::Disc, particle: b.id, openness: 1.0 }
            } else {
                let normal = (n + gap.away).normalize_or(n);
                let openness = 0.5 + 0.5 * normal.dot(n);
                Raw { height: -gap.distance, normal, kind: HitKind::Bevel, particle: b.id, openness }
            };
        }
        self.hit(best)
    }
}

impl Listed<'_> {
    /// A place seen from the centre.
    #[inline(always)]
    fn seen(&self, places: &Places, i: usize) -> Vec3 {
        let step = |k: usize| self.cell[k].wrapping_sub(places.cell[k][i]) as f32;
        Vec3::new(
            places.local[0][i] - (step(0) + self.offset.x),
            places.local[1][i] - (step(1) + self.offset.y),
            places.local[2][i] - (step(2) + self.offset.z),
        )
    }

    fn seen_from(&self, place: &Place) -> Vec3 {
        let step = |k: usize| self.cell[k].wrapping_sub(place.cell[k]) as f32;
        place.local - (Vec3::new(step(0), step(1), step(2)) + self.offset)
    }
}

impl Places {
    fn at(&self, i: usize) -> Place {
        let local = Vec3::new(self.local[0][i], self.local[1][i], self.local[2][i]);
        Place { cell: [self.cell[0][i], self.cell[1][i], self.cell[2][i]], local }
    }
}

/// A cylinder that holds a body: axis, half height, radius.
fn enclosing(body: &Body) -> (Vec3, f32, f32) {
    match body {
        Body::Ball(b) => (Vec3::Z, b.radius, b.radius),
        Body::Ellipsoid(b) => (b.frame.z_axis, b.semi.z, b.semi.x.max(b.semi.y)),
        Body::Rod(b) => (b.axis, b.half, b.radius),
        Body::Capsule(b) => (b.axis, b.half + b.radius, b.radius),
        Body::Block(b) => (b.frame.z_axis, b.half.z, (b.half.x * b.half.x + b.half.y * b.half.y).sqrt()),
        Body::Facets(_) => (Vec3::Z, body.reach(), body.reach()),
        Body::Superquadric(b) => (b.frame.z_axis, b.semi.z, (b.semi.x * b.semi.x + b.semi.y * b.semi.y).sqrt()),
    }
}

/// The cylinder that holds a body and all places whose gap is below a bevel.
fn with_bevel(body: &Body, bevel: f32) -> (Vec3, f32, f32) {
    let (axis, half, radius) = enclosing(body);
    // A cylinder's gap is never below the distances to its side and its ends.
    if let Body::Rod(_) = body {
        return (axis, half + bevel * 1.01, radius + bevel * 1.01);
    }
    let grow = 1.0 + 2.0 * bevel / inner_radius(body).max(1e-6);
    (axis, half * grow, radius * grow)
}

/// A ball of this radius about the centre is in the body, or nearly: bodies grow by a bevel at most as this ball does.
fn inner_radius(body: &Body) -> f32 {
    match body {
        Body::Ball(b) => b.radius,
        Body::Ellipsoid(b) => b.semi.min_element(),
        Body::Rod(b) => b.radius.min(b.half),
        Body::Capsule(b) => b.radius,
        Body::Block(b) => b.half.min_element(),
        Body::Facets(b) => b.faces.iter().map(|f| f.w).fold(f32::INFINITY, f32::min) * b.scale,
        Body::Superquadric(b) => b.semi.min_element(),
    }
}

impl Grain {
    /// Where in the plane a body's outline, and for solid cuts its bevel, may be: least and greatest coordinates.
    ///
    /// No function that tells the gap is below the body's own level, and where that is below a bevel lies within the body
    /// grown by twice as much.
    fn bounds(&self, body: &Body, (at, height): (DVec2, f64), axes: [Vec3; 2], look: Look) -> [DVec2; 2] {
        let spacing = self.spec.spacing as f64;
        let bevel = if look.kind == SectionKind::Solid { self.spec.bevel } else { 0.0 };
        let h = height / spacing;
        let wide = (body.reach() + bevel) as f64 * 1.001;
        // As far as any place is asked; with a bevel, what limits it is the grain's greatest reach.
        let wide = if bevel > 0.0 { (self.reach + bevel) as f64 * 1.001 } else { wide };
        let round = (wide * wide - h * h).max(0.0).sqrt();
        let grow = 1.001 + 2.0 * bevel / inner_radius(body).max(1e-6);
        let reach = |a: Vec3| (body.support(a).dot(a) * grow) as f64 + 1e-4;
        let low = DVec2::new(reach(-axes[0]).min(round), reach(-axes[1]).min(round));
        let high = DVec2::new(reach(axes[0]).min(round), reach(axes[1]).min(round));
        [at - low * spacing, at + high * spacing]
    }
}
