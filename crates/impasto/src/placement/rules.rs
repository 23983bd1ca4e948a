//! The coordinate functions themselves: from a surface point to (s, t, r), each written once over [`Number`].

use crate::assets::Mesh;
use crate::math::{DMat4, Mat4, Vec3, Vec4};
use crate::placement::number::{Number, Vector, affine, cross, dot, minus, pick, scaled, select, stretched, unit};
use crate::placement::{Direction, Placement, PositionUnit, Projector, Space, Viewpoint, two_part::TwoPartRule};
use std::f32::consts::FRAC_1_PI;

/// What a coordinate function may look at.
pub(super) struct Point<N> {
    /// World space.
    pub(super) position: Vector<N>,
    /// World space, unit, away from the front side.
    pub(super) normal: Vector<N>,
    /// 1 where the front is seen, -1 where the back is.
    pub(super) side: f32,
}

impl<N: Number> Point<N> {
    /// The normal towards the side that is seen.
    #[inline(always)]
    fn seen_normal(&self) -> Vector<N> {
        self.normal.map(|n| n.times(self.side))
    }
}

/// A coordinate function with all that is constant over a batch worked out.
pub(super) trait Rule {
    /// (s, t, r) at a point.
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N>;
}

/// What is done with a rule; lets each kind have its own tight loop.
pub(super) trait Visitor {
    /// The answer.
    type Output;
    /// Does it.
    fn visit(self, rule: &impl Rule) -> Self::Output;
}

/// Works out what is constant over a batch, and hands the rule to `visitor`. None for UV sets and fields, which are no
/// functions of place and normal.
pub(super) fn resolve<V: Visitor>(
    placement: &Placement,
    view: &Viewpoint,
    mesh: &Mesh,
    visitor: V,
) -> Option<V::Output> {
    let sight = Sight::of(view);
    let local = |projector: &Option<Projector>| Local::of(&projector.unwrap_or(Projector::around(&mesh.bounds())));
    Some(match placement {
        Placement::Uv(_) | Placement::Property { .. } | Placement::PropertyInLight { .. } => {
            return None;
        }
        Placement::ObjectLinear { planes, world_from_object } => {
            visitor.visit(&Linear { planes: planes_in_world(planes, world_from_object.as_ref()) })
        }
        Placement::WorldLinear { planes } => visitor.visit(&Linear { planes: planes_in_world(planes, None) }),
        Placement::EyeLinear { planes } => {
            let world_from_eye = inverse(&view.eye_from_world);
            visitor.visit(&Linear { planes: planes_in_world(planes, world_from_eye.as_ref()) })
        }
        Placement::SphereMap => visitor.visit(&SphereMap { sight }),
        Placement::ReflectionMap { space } => {
            visitor.visit(&Towards { sight, direction: Direction::Reflection, space: *space })
        }
        Placement::NormalMap { space } => {
            visitor.visit(&Towards { sight, direction: Direction::Normal, space: *space })
        }
        Placement::ViewNormal => visitor.visit(&ViewNormal { sight }),
        Placement::Equirectangular { direction, space } => {
            visitor.visit(&Panorama(Towards { sight, direction: *direction, space: *space }))
        }
        Placement::Planar { projector } => visitor.visit(&Planar(local(projector))),
        Placement::Cylindrical { projector } => visitor.visit(&Cylindrical(local(projector))),
        Placement::Spherical { projector } => visitor.visit(&Spherical(local(projector))),
        Placement::Box { projector } => {
            let projector = projector.unwrap_or(Projector::around(&mesh.bounds()).cubic());
            visitor.visit(&SixSides(Local::of(&projector)))
        }
        Placement::Camera { clip_from_world } => visitor.visit(&Slide { rows: rows(clip_from_world) }),
        Placement::TwoPart(two_part) => visitor.visit(&TwoPartRule::new(two_part, local(&two_part.projector), sight)),
        Placement::Position { unit } => visitor.visit(&Place::of(*unit, mesh)),
    })
}

/// The four rows of a matrix.
pub(super) fn rows(m: &Mat4) -> [[f32; 4]; 4] {
    let c = m.to_cols_array_2d();
    std::array::from_fn(|row| std::array::from_fn(|column| c[column][row]))
}

/// Worked out in f64, as plain arithmetic; none when it has no inverse.
fn inverse(m: &Mat4) -> Option<Mat4> {
    let inverse = DMat4::from_cols_array(&m.to_cols_array().map(f64::from)).inverse();
    inverse.is_finite().then(|| Mat4::from_cols_array(&inverse.to_cols_array().map(|x| x as f32)))
}

/// Planes of a space as planes of the world. A plane is a row vector: it goes the other way, through the inverse.
fn planes_in_world(planes: &[Vec4; 3], world_from_space: Option<&Mat4>) -> [[f32; 4]; 3] {
    let plain = planes.map(|p| [p.x, p.y, p.z, p.w]);
    let Some(space_from_world) = world_from_space.and_then(inverse) else { return plain };
    let rows = rows(&space_from_world);
    plain
        .map(|p| std::array::from_fn(|k| p[0] * rows[0][k] + p[1] * rows[1][k] + p[2] * rows[2][k] + p[3] * rows[3][k]))
}

/// Who looks, as rows of numbers.
#[derive(Clone, Copy)]
pub(super) struct Sight {
    eye_from_world: [[f32; 4]; 4],
    eye: [f32; 3],
    parallel: Option<[f32; 3]>,
}

impl Sight {
    fn of(view: &Viewpoint) -> Self {
        Self {
            eye_from_world: rows(&view.eye_from_world),
            eye: view.eye.to_array(),
            parallel: view.parallel.map(|v| v.to_array()),
        }
    }

    /// Unit vector towards the eye, world space.
    #[inline(always)]
    fn towards_eye<N: Number>(&self, position: Vector<N>) -> Vector<N> {
        match self.parallel {
            Some(direction) => direction.map(N::constant),
            None => unit(minus(self.eye.map(N::constant), position)),
        }
    }

    /// Where a mirror at the point shows the eye to; unit, world space. The same for both sides of the surface.
    #[inline(always)]
    pub(super) fn reflection<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let v = self.towards_eye(point.position);
        minus(scaled(point.normal, dot(point.normal, v).times(2.0)), v)
    }

    #[inline(always)]
    fn direction_in<N: Number>(&self, space: Space, v: Vector<N>) -> Vector<N> {
        match space {
            Space::World => v,
            Space::Eye => [0, 1, 2].map(|k| {
                let m = self.eye_from_world[k];
                affine([m[0], m[1], m[2]], 0.0, v)
            }),
        }
    }

    #[inline(always)]
    fn position_in<N: Number>(&self, space: Space, p: Vector<N>) -> Vector<N> {
        match space {
            Space::World => p,
            Space::Eye => [0, 1, 2].map(|k| {
                let m = self.eye_from_world[k];
                affine([m[0], m[1], m[2]], m[3], p)
            }),
        }
    }
}

/// A projector, as rows of numbers.
#[derive(Clone, Copy)]
pub(super) struct Local {
    origin: [f32; 3],
    axes: [[f32; 3]; 3],
    /// Edges of the box.
    pub(super) size: [f32; 3],
    /// One over the edges; 0 for an edge without length, so that flat things map to the middle.
    pub(super) per_size: [f32; 3],
}

impl Local {
    pub(super) fn of(projector: &Projector) -> Self {
        let size = projector.size.to_array();
        Self {
            origin: projector.origin.to_array(),
            axes: projector.axes.map(|a: Vec3| a.to_array()),
            size,
            per_size: size.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 }),
        }
    }

    /// A place, from the middle of the box along its axes.
    #[inline(always)]
    pub(super) fn place<N: Number>(&self, p: Vector<N>) -> Vector<N> {
        let [x, y, z] = self.origin;
        self.direction([p[0].plus(-x), p[1].plus(-y), p[2].plus(-z)])
    }

    /// A direction along its axes.
    #[inline(always)]
    pub(super) fn direction<N: Number>(&self, v: Vector<N>) -> Vector<N> {
        self.axes.map(|axis| affine(axis, 0.0, v))
    }
}

struct Linear {
    planes: [[f32; 4]; 3],
}

impl Rule for Linear {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        self.planes.map(|[a, b, c, d]| affine([a, b, c], d, point.position))
    }
}

struct SphereMap {
    sight: Sight,
}

impl Rule for SphereMap {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let r = self.sight.direction_in(Space::Eye, self.sight.reflection(point));
        let front = r[2].plus(1.0);
        let m = (r[0] * r[0] + r[1] * r[1] + front * front).sqrt().times(2.0);
        [(r[0] / m).plus(0.5), (-r[1] / m).plus(0.5), N::constant(0.0)]
    }
}

/// A direction as it is.
struct Towards {
    sight: Sight,
    direction: Direction,
    space: Space,
}

impl Rule for Towards {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        match self.direction {
            Direction::Reflection => self.sight.direction_in(self.space, self.sight.reflection(point)),
            Direction::Normal => self.sight.direction_in(self.space, point.seen_normal()),
            Direction::Position => self.sight.position_in(self.space, point.position),
        }
    }
}

struct ViewNormal {
    sight: Sight,
}

impl Rule for ViewNormal {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let view = self.sight.direction_in(Space::Eye, self.sight.towards_eye(point.position));
        let normal = self.sight.direction_in(Space::Eye, point.seen_normal());
        // A frame about the line of sight whose first axis is level.
        let right = unit([view[2], N::constant(0.0), -view[0]]);
        let up = cross(view, right);
        [dot(normal, right).times(0.5).plus(0.5), dot(normal, up).times(-0.5).plus(0.5), N::constant(0.0)]
    }
}

struct Panorama(Towards);

impl Rule for Panorama {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let d = self.0.at(point);
        [around(d[0], -d[2]), from_pole(d), N::constant(0.0)]
    }
}

/// The angle from `front` towards `right` in turns, 1/2 in front.
#[inline(always)]
pub(super) fn around<N: Number>(right: N, front: N) -> N {
    right.atan2(front).times(0.5 * FRAC_1_PI).plus(0.5)
}

/// The angle from the second axis in half turns: 0 up, 1 down.
#[inline(always)]
pub(super) fn from_pole<N: Number>(d: Vector<N>) -> N {
    (d[0] * d[0] + d[2] * d[2]).sqrt().atan2(d[1]).times(FRAC_1_PI)
}

struct Planar(Local);

impl Rule for Planar {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let p = stretched(self.0.place(point.position), self.0.per_size);
        [p[0].plus(0.5), (-p[1]).plus(0.5), p[2].plus(0.5)]
    }
}

struct Cylindrical(Local);

impl Rule for Cylindrical {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let p = self.0.place(point.position);
        let radius = (p[0] * p[0] + p[2] * p[2]).sqrt();
        let t = p[1].times(-self.0.per_size[1]).plus(0.5);
        [around(p[0], p[2]), t, radius.times(2.0 * self.0.per_size[0])]
    }
}

struct Spherical(Local);

impl Rule for Spherical {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let p = self.0.place(point.position);
        [around(p[0], p[2]), from_pole(p), dot(p, p).sqrt().times(2.0 * self.0.per_size[0])]
    }
}

struct SixSides(Local);

impl Rule for SixSides {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let n = self.0.direction(point.normal);
        let p = stretched(self.0.place(point.position), self.0.per_size);
        let axis = largest([n[0].abs(), n[1].abs(), n[2].abs()]);
        let positive = N::constant(0.0).is_below(pick(n, axis));
        box_side(p, axis, positive)
    }
}

/// Which of three is largest; ties go to the third, then the first.
#[inline(always)]
pub(super) fn largest<N: Number>(v: Vector<N>) -> u32 {
    let x_or_z = select(v[2].is_below(v[0]), 0, 2);
    select(pick(v, x_or_z).is_below(v[1]), 1, x_or_z)
}

/// The picture on one side of a box, upright and unmirrored from outside, the top's lower edge in front. `p` from the
/// middle of the box in units of its edges.
#[inline(always)]
pub(super) fn box_side<N: Number>(p: Vector<N>, axis: u32, positive: bool) -> Vector<N> {
    let sign = select(positive, 1.0, -1.0);
    let s = select(axis == 0, p[2].times(-sign), select(axis == 1, p[0], p[0].times(sign)));
    let t = select(axis == 1, p[2].times(sign), -p[1]);
    [s.plus(0.5), t.plus(0.5), N::constant(0.0)]
}

struct Slide {
    rows: [[f32; 4]; 4],
}

impl Rule for Slide {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let [x, y, z, w] = self.rows.map(|[a, b, c, d]| affine([a, b, c], d, point.position));
        let seen = N::constant(0.0).is_below(w);
        let outside = N::constant(-1.0);
        let s = (x / w).times(0.5).plus(0.5);
        let t = (y / w).times(-0.5).plus(0.5);
        [select(seen, s, outside), select(seen, t, outside), select(seen, z / w, outside)]
    }
}

struct Place {
    origin: [f32; 3],
    scale: f32,
    offset: f32,
}

impl Place {
    fn of(unit: PositionUnit, mesh: &Mesh) -> Self {
        let extent = mesh.bounds().extent();
        let longest = extent.x.max(extent.y).max(extent.z);
        match unit {
            PositionUnit::Model => Self { origin: [0.0; 3], scale: 1.0, offset: 0.0 },
            PositionUnit::Bounds => Self {
                origin: mesh.bounds().center().to_array(),
                scale: if longest > 0.0 { 1.0 / longest } else { 0.0 },
                offset: 0.5,
            },
        }
    }
}

impl Rule for Place {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        [0, 1, 2].map(|k| point.position[k].plus(-self.origin[k]).times(self.scale).plus(self.offset))
    }
}
