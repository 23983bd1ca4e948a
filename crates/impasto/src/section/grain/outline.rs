//! The curve that a plane cuts out of a particle's body.
//!
//! Of balls, ellipsoids, cylinders and capsules the curves are known: circles, ellipses, and ellipses between two lines
//! (for a cylinder about D with c = D . n, s^2 = 1 - c^2 and the centre h above the plane: the points with
//! (x c + h s)^2 + y^2 <= R^2 and |x s - h c| <= H / 2, x along D in the plane). Flat faces give polygons; what has no such
//! form is followed by a polygon.

use super::block::{Block, Facets};
use super::curve::{Curve, Ellipse, Part, clip};
use super::ellipsoid::Ellipsoid;
use super::rod::{Capsule, Rod};
use super::shape::{Body, Convex};
use crate::math::{DVec2, DVec3, Frame, Vec3, exact};

/// A plane as a particle's centre sees it: unit vectors along the lattice's axes, and the centre's height above the plane
/// along `n`, in spacings.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) u: DVec3,
    pub(super) v: DVec3,
    pub(super) n: DVec3,
    pub(super) height: f64,
}

/// Below this, directions count as along the plane or its normal.
const FLAT: f64 = 1e-5;

/// Corners along a rounded rim that the plane just cuts: a half circle of so many is followed to a thousandth of its radius.
const N_CUT_RIM: usize = 40;

impl View {
    /// From the centre to the plane's point at (x, y).
    fn point(&self, at: DVec2) -> DVec3 {
        self.u * at.x + self.v * at.y - self.n * self.height
    }

    fn flat(&self, p: DVec3) -> DVec2 {
        DVec2::new(p.dot(self.u), p.dot(self.v))
    }
}

/// Outline of a body's section, seen from the centre moved onto the plane, spacings; none if the plane misses it.
pub(super) fn section_curve(body: &Body, view: &View) -> Option<Curve> {
    match body {
        Body::Ball(ball) => disc(DVec2::ZERO, ball.radius as f64, view.height),
        Body::Ellipsoid(ellipsoid) => of_ellipsoid(ellipsoid, view),
        Body::Rod(rod) => of_rod(rod, view),
        Body::Capsule(capsule) => of_capsule(capsule, view),
        Body::Block(block) if block.rounding == 0.0 => of_block(block, view),
        Body::Facets(facets) => of_facets(facets, view),
        Body::Block(_) | Body::Superquadric(_) => followed(body, view),
    }
}

/// A ball's disc, of this height above the plane.
fn disc(middle: DVec2, radius: f64, height: f64) -> Option<Curve> {
    let squared = radius * radius - height * height;
    (squared > 0.0).then(|| Curve::Circle { middle, radius: squared.sqrt() })
}

fn of_ellipsoid(ellipsoid: &Ellipsoid, view: &View) -> Option<Curve> {
    let semi = ellipsoid.semi.as_dvec3();
    let unit = |v: DVec3| ellipsoid.frame.as_dmat3().transpose() * v / semi;
    // |f + x a + y b| = 1.
    let (a, b, f) = (unit(view.u), unit(view.v), unit(-view.n * view.height));
    let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
    let (fa, fb) = (f.dot(a), f.dot(b));
    let det = aa * bb - ab * ab;
    let middle = DVec2::new(ab * fb - bb * fa, ab * fa - aa * fb) / det;
    let left = 1.0 - (f + a * middle.x + b * middle.y).length_squared();
    if left.is_nan() || left <= 0.0 {
        return None;
    }
    let angle = 0.5 * exact::atan2(2.0 * ab, aa - bb);
    let first = DVec2::new(exact::cos(angle), exact::sin(angle));
    let along = |d: DVec2| d * (left / (aa * d.x * d.x + 2.0 * ab * d.x * d.y + bb * d.y * d.y)).sqrt();
    Some(Curve::Ellipse(Ellipse { middle, semi: [along(first), along(first.perp())] }))
}

/// What a round bar's section is drawn in: x along the axis, moved into the plane; y across.
struct Across {
    /// D . n, and the axis' length in the plane.
    c: f64,
    s: f64,
    h: f64,
    e1: DVec2,
}

impl Across {
    /// None where the axis is along the normal.
    fn of(axis: Vec3, view: &View) -> Result<Self, f64> {
        let axis = axis.as_dvec3().normalize();
        let c = axis.dot(view.n);
        let flat = view.flat(axis);
        let s = flat.length();
        if s < FLAT { Err(c) } else { Ok(Self { c, s, h: view.height, e1: flat / s }) }
    }

    fn place(&self, x: f64, y: f64) -> DVec2 {
        self.e1 * x + self.e1.perp() * y
    }

    /// x of the points so far along the axis.
    fn x_at(&self, along: f64) -> f64 {
        (along + self.h * self.c) / self.s
    }

    /// Squared distance from the x axis of the points with this x on a cylinder of that radius.
    fn y_squared(&self, x: f64, radius: f64) -> f64 {
        let across = x * self.c + self.h * self.s;
        radius * radius - across * across
    }

    /// The section of the endless cylinder; none if that is two lines.
    fn ellipse(&self, radius: f64) -> Option<Ellipse> {
        let middle = self.place(-self.h * self.s / self.c, 0.0);
        let long = self.e1 * (radius / self.c.abs());
        (self.c.abs() > FLAT).then(|| Ellipse { middle, semi: [long, self.e1.perp() * radius] })
    }

    /// From one point of the cylinder's section to another.
    fn side(&self, to: DVec2, radius: f64) -> Part {
        self.ellipse(radius).map_or(Part::Line(to), |of| Part::Arc { to, of })
    }
}

fn of_rod(rod: &Rod, view: &View) -> Option<Curve> {
    let (radius, half, e) = (rod.radius as f64, rod.half as f64, rod.rounding as f64);
    let across = match Across::of(rod.axis, view) {
        Ok(across) => across,
        Err(_) => {
            let beyond = (view.height.abs() - (half - e)).max(0.0);
            let radius = radius - e + (e * e - beyond * beyond).max(0.0).sqrt();
            let meets = view.height.abs() < half;
            return meets.then_some(Curve::Circle { middle: DVec2::ZERO, radius });
        }
    };
    // The side's part from right to left: what the straight side has of it.
    let (left, right) = (across.x_at(-(half - e)), across.x_at(half - e));
    let (mut x0, mut x1) = (left, right);
    if let Some(ellipse) = across.ellipse(radius) {
        let (middle, long) = (ellipse.middle.dot(across.e1), ellipse.semi[0].length());
        if middle - long >= left && middle + long <= right {
            return Some(Curve::Ellipse(ellipse));
        }
        (x0, x1) = (x0.max(middle - long), x1.min(middle + long));
    } else if across.y_squared(0.0, radius) <= 0.0 {
        // Two lines that are none; what the rims might add is thinner than can be seen.
        return None;
    }
    // A rim's points by their angle: 0 at the side, a quarter at the end.
    let rim = |sign: f64, angle: f64| {
        let x = across.x_at(sign * (half - e + e * exact::sin(angle)));
        (x, across.y_squared(x, radius - e + e * exact::cos(angle)))
    };
    let rim_points = |sign: f64| -> Vec<DVec2> {
        if e == 0.0 {
            let x = across.x_at(sign * half);
            let squared = across.y_squared(x, radius);
            return if squared > 0.0 { vec![DVec2::new(x, squared.sqrt())] } else { Vec::new() };
        }
        let squared = |angle: f64| rim(sign, angle).1;
        let Some([first, last]) = positive_range(squared, std::f64::consts::FRAC_PI_2) else { return Vec::new() };
        // Even steps; closer where the outline meets the x axis, as it is round there.
        let is_cut = first > 0.0 || last < std::f64::consts::FRAC_PI_2;
        let n = ((last - first) / (2e-3 * radius / e).sqrt()).ceil() as usize;
        let n = if is_cut { N_CUT_RIM } else { n.clamp(4, N_CUT_RIM) };
        let points = (0..=n).map(|k| {
            let even = k as f64 / n as f64;
            let part = if is_cut { 0.5 - 0.5 * exact::cos(even * std::f64::consts::PI) } else { even };
            let (x, squared) = rim(sign, first + (last - first) * part);
            DVec2::new(x, squared.max(0.0).sqrt())
        });
        points.collect()
    };
    // The upper half from right to left; the side's part is between `n_right` points and the rest.
    let mut upper: Vec<DVec2> = rim_points(1.0).into_iter().rev().collect();
    let has_side = x0 < x1;
    if has_side && upper.is_empty() {
        upper.push(DVec2::new(x1, across.y_squared(x1, radius).max(0.0).sqrt()));
    }
    let n_right = upper.len();
    upper.extend(rim_points(-1.0));
    if has_side && upper.len() == n_right {
        upper.push(DVec2::new(x0, across.y_squared(x0, radius).max(0.0).sqrt()));
    }
    if upper.len() < 2 {
        return None;
    }
    let above = |p: DVec2| across.place(p.x, p.y);
    let below = |p: DVec2| across.place(p.x, -p.y);
    let mut parts = Vec::new();
    for (k, &p) in upper.iter().enumerate().skip(1) {
        parts.push(if k == n_right && has_side { across.side(above(p), radius) } else { Part::Line(above(p)) });
    }
    for (k, &p) in upper.iter().enumerate().rev() {
        let is_side = k + 1 == n_right && has_side;
        // The end's line, where there is one.
        if k + 1 < upper.len() || p.y > 0.0 {
            parts.push(if is_side { across.side(below(p), radius) } else { Part::Line(below(p)) });
        }
    }
    Some(Curve::Path { start: above(upper[0]), parts })
}

/// Where a function of one hump is above zero between 0 and `end`; none where it is not.
fn positive_range(f: impl Fn(f64) -> f64, end: f64) -> Option<[f64; 2]> {
    let (mut a, mut b) = (0.0, end);
    if f(0.0) > 0.0 && f(end) > 0.0 {
        return Some([0.0, end]);
    }
    let n_steps = if f(0.0) > 0.0 || f(end) > 0.0 { 0 } else { 60 };
    for _ in 0..n_steps {
        let (x, y) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if f(x) < f(y) { a = x } else { b = y }
    }
    let top = [0.0, 0.5 * (a + b), end].into_iter().fold(0.0, |best, x| if f(x) > f(best) { x } else { best });
    let border = |mut outside: f64| {
        let mut inside = top;
        for _ in 0..50 {
            let middle = 0.5 * (inside + outside);
            if f(middle) > 0.0 { inside = middle } else { outside = middle }
        }
        inside
    };
    let first = if f(0.0) > 0.0 { 0.0 } else { border(0.0) };
    let last = if f(end) > 0.0 { end } else { border(end) };
    (f(top) > 0.0).then_some([first, last])
}

fn of_capsule(capsule: &Capsule, view: &View) -> Option<Curve> {
    let (radius, half) = (capsule.radius as f64, capsule.half as f64);
    let across = match Across::of(capsule.axis, view) {
        Ok(across) => across,
        Err(_) => return disc(DVec2::ZERO, radius, (view.height.abs() - half).max(0.0)),
    };
    // The end balls' discs: x of the middle.
    let ball = |sign: f64| (sign * half * across.s, disc(DVec2::ZERO, radius, view.height + sign * half * across.c));
    let end = |sign: f64, to: DVec2| match ball(sign) {
        (x, Some(Curve::Circle { radius, .. })) => {
            let of = Ellipse { middle: across.place(x, 0.0), semi: [DVec2::X * radius, DVec2::Y * radius] };
            Part::Arc { to, of }
        }
        _ => Part::Line(to),
    };
    let corner = |sign: f64| {
        let x = across.x_at(sign * half);
        let squared = across.y_squared(x, radius);
        (squared > 0.0).then(|| [1.0, -1.0].map(|up| across.place(x, up * squared.sqrt())))
    };
    let path = |start, parts| Some(Curve::Path { start, parts });
    match (corner(-1.0), corner(1.0)) {
        (Some([a, b]), Some([c, d])) => {
            path(d, vec![end(1.0, c), across.side(a, radius), end(-1.0, b), across.side(d, radius)])
        }
        (None, Some([c, d])) => path(d, vec![end(1.0, c), across.side(d, radius)]),
        (Some([a, b]), None) => path(a, vec![end(-1.0, b), across.side(a, radius)]),
        (None, None) => {
            let of_side = across.ellipse(radius).filter(|of| {
                let x = of.middle.dot(across.e1);
                x > across.x_at(-half) && x < across.x_at(half)
            });
            let of_ball = |sign: f64| {
                let (x, disc) = ball(sign);
                let is_beyond = sign * (x - across.x_at(sign * half)) >= 0.0;
                disc.filter(|_| is_beyond).map(|disc| disc.moved(across.place(x, 0.0), 1.0))
            };
            of_side.map(Curve::Ellipse).or_else(|| of_ball(1.0)).or_else(|| of_ball(-1.0))
        }
    }
}

fn of_block(block: &Block, view: &View) -> Option<Curve> {
    let faces = (0..6).map(|k| {
        let sign = if k < 3 { 1.0 } else { -1.0 };
        (block.frame.col(k % 3).as_dvec3() * sign, block.half[k % 3] as f64)
    });
    clipped(faces, block.reach() as f64, view)
}

fn of_facets(facets: &Facets, view: &View) -> Option<Curve> {
    let frame = facets.frame.as_dmat3();
    let faces = facets.faces.iter().map(|f| (frame * f.truncate().as_dvec3(), (f.w * facets.scale) as f64));
    clipped(faces, facets.reach() as f64, view)
}

/// The polygon below all faces: normals and distances from the centre.
fn clipped(faces: impl Iterator<Item = (DVec3, f64)>, reach: f64, view: &View) -> Option<Curve> {
    let far = reach * 1.5;
    let mut polygon = [(-far, -far), (far, -far), (far, far), (-far, far)].map(|(x, y)| DVec2::new(x, y)).to_vec();
    let mut room = Vec::new();
    for (normal, distance) in faces {
        clip(&mut polygon, &mut room, |p| view.point(p).dot(normal) - distance);
    }
    Curve::polygon_of(&polygon)
}

/// Rays from a point inside, more of them until the chords are nearer to the outline than 1/4000 of the body's reach.
fn followed(body: &Body, view: &View) -> Option<Curve> {
    let n = view.n.as_vec3();
    let foot = n * -view.height as f32;
    if !body.meets(foot, n) {
        return None;
    }
    let middle = body.section_point(-view.height as f32, n);
    let frame = Frame::about(n);
    let at = |angle: f64| {
        let t = frame.tangent * exact::cos(angle) as f32 + frame.bitangent * exact::sin(angle) as f32;
        view.flat((middle + t * body.exit(middle, t).distance).as_dvec3())
    };
    const N_FIRST: usize = 32;
    let first: Vec<(f64, DVec2)> = (0..N_FIRST)
        .map(|k| k as f64 * (std::f64::consts::TAU / N_FIRST as f64))
        .map(|angle| (angle, at(angle)))
        .collect();
    let mut corners = Vec::new();
    for k in 0..N_FIRST {
        let mut next = first[(k + 1) % N_FIRST];
        next.0 = (k + 1) as f64 * (std::f64::consts::TAU / N_FIRST as f64);
        corners.push(first[k].1);
        divide(&at, (first[k], next), body.reach() as f64 / 4000.0, 8, &mut corners);
    }
    Curve::polygon_of(&corners)
}

fn divide(
    at: &impl Fn(f64) -> DVec2,
    (a, b): ((f64, DVec2), (f64, DVec2)),
    tolerance: f64,
    depth: u32,
    out: &mut Vec<DVec2>,
) {
    let angle = 0.5 * (a.0 + b.0);
    let middle = (angle, at(angle));
    let chord = b.1 - a.1;
    let off = (middle.1 - a.1).perp_dot(chord).abs();
    if depth == 0 || off <= tolerance * chord.length() {
        return;
    }
    divide(at, (a, middle), tolerance, depth - 1, out);
    out.push(middle.1);
    divide(at, (middle, b), tolerance, depth - 1, out);
}
