//! Two-part texture mapping: wrap the picture about a simple surface around the object, then carry it to the object.
//!
//! Bier, Sloan, "Two-Part Texture Mappings", IEEE Computer Graphics and Applications 6(9), 1986. The intermediate surface
//! stands around the projector's box; from a point of the object a ray goes out, and what it meets there is the texture.
//!
//! Not all sixteen pairs are of equal use. Geometry says which ([`TwoPart::remark`] has it as text):
//!
//! | | reflected ray | object normal | centroid | surface normal |
//! |---|---|---|---|---|
//! | **plane** | a lit window in front; one half only | one half only | a slide seen from the centre; one half only | planar projection |
//! | **cylinder** | moves with the eye | runs off at level parts | runs off above and below the centre | shrink wrap = cylindrical projection |
//! | **sphere** | environment with parallax | smooth | = spherical projection | = centroid |
//! | **box** | a mirrored room | good on boxy things | good on boxy things | six planar projections, by nearness |

use crate::placement::Projector;
use crate::placement::number::{Number, Vector, dot, pick, scaled, select, stretched};
use crate::placement::rules::{Local, Point, Rule, Sight, around, box_side, from_pole, largest};

/// An intermediate surface, and how its picture gets from there to the object.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct TwoPart {
    /// What the picture is wrapped about first.
    pub surface: Intermediate,
    /// Along which ray a point of the object looks at it.
    pub ray: ObjectRay,
    /// The box that the surface stands around; none: the mesh's bounds.
    pub projector: Option<Projector>,
}

/// The surface a picture is wrapped about before it is carried to the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Intermediate {
    /// The front of the box; the picture covers it. What looks away from it gets (-1, -1).
    Plane,
    /// The upright cylinder through the box's vertical edges: s once around, t down its height.
    #[default]
    Cylinder,
    /// The sphere through the box's corners: longitude and latitude.
    Sphere,
    /// The box itself; each side has the whole picture, upright.
    Box,
}

/// Along which ray a point of the object looks at the intermediate surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum ObjectRay {
    /// The line of sight, reflected: an environment that has a place.
    ReflectedRay,
    /// The object's normal.
    ObjectNormal,
    /// From the middle of the box through the point.
    Centroid,
    /// The intermediate surface's normal through the point: to its nearest point ("shrink wrap" for a cylinder).
    #[default]
    SurfaceNormal,
}

impl TwoPart {
    /// What to know about a pair that is a special case or does not cover every object; none: nothing.
    pub fn remark(&self) -> Option<&'static str> {
        use Intermediate as I;
        use ObjectRay as R;
        match (self.surface, self.ray) {
            (I::Plane, R::SurfaceNormal) => Some("the same as the planar projection"),
            (I::Plane, _) => Some("only rays towards the front meet the plane; the rest of the object gets no texture"),
            (I::Cylinder, R::SurfaceNormal) => Some("the same as the cylindrical projection"),
            (I::Cylinder, _) => Some("rays along the axis never meet the cylinder; the texture runs off there"),
            (I::Sphere, R::Centroid | R::SurfaceNormal) => Some("the same as the spherical projection"),
            (I::Box, R::SurfaceNormal) => Some("jumps where two sides of the box are equally near"),
            (I::Sphere | I::Box, _) => None,
        }
    }

    /// Whether it changes when the eye moves.
    pub fn depends_on_view(&self) -> bool {
        self.ray == ObjectRay::ReflectedRay
    }

    /// Whether it reads the object's normal.
    pub(super) fn reads_normal(&self) -> bool {
        matches!(self.ray, ObjectRay::ReflectedRay | ObjectRay::ObjectNormal)
    }
}

/// A [`TwoPart`] with its constants.
pub(super) struct TwoPartRule {
    surface: Intermediate,
    ray: ObjectRay,
    local: Local,
    half: [f32; 3],
    /// Of the sphere or cylinder, squared.
    radius_squared: f32,
    sight: Sight,
}

impl TwoPartRule {
    pub(super) fn new(two_part: &TwoPart, local: Local, sight: Sight) -> Self {
        let half = local.size.map(|s| 0.5 * s);
        let flat = half[0] * half[0] + half[2] * half[2];
        let height = if two_part.surface == Intermediate::Sphere { half[1] * half[1] } else { 0.0 };
        Self { surface: two_part.surface, ray: two_part.ray, local, half, radius_squared: flat + height, sight }
    }

    /// The ray's direction at the local place `p`.
    #[inline(always)]
    fn direction<N: Number>(&self, point: &Point<N>, p: Vector<N>) -> Vector<N> {
        let zero = N::constant(0.0);
        match self.ray {
            ObjectRay::ReflectedRay => self.local.direction(self.sight.reflection(point)),
            ObjectRay::ObjectNormal => self.local.direction(point.normal),
            ObjectRay::Centroid => p,
            ObjectRay::SurfaceNormal => match self.surface {
                Intermediate::Plane | Intermediate::Box => [zero, zero, N::constant(1.0)],
                Intermediate::Cylinder => [p[0], zero, p[2]],
                Intermediate::Sphere => p,
            },
        }
    }

    /// Where the ray meets the front's plane, or that it never does.
    #[inline(always)]
    fn on_plane<N: Number>(&self, p: Vector<N>, d: Vector<N>) -> Vector<N> {
        let far = (-p[2]).plus(self.half[2]) / d[2];
        let hit = along(p, d, far);
        let meets = N::constant(0.0).is_below(d[2]);
        let outside = N::constant(-1.0);
        let s = hit[0].times(self.local.per_size[0]).plus(0.5);
        let t = hit[1].times(-self.local.per_size[1]).plus(0.5);
        [select(meets, s, outside), select(meets, t, outside), N::constant(0.0)]
    }

    /// Where the ray leaves the sphere, or the cylinder when `p` and `d` are given without height. A ray that passes by
    /// outside takes the point of nearest approach.
    #[inline(always)]
    fn far_on_round<N: Number>(&self, p: Vector<N>, d: Vector<N>) -> N {
        let a = dot(d, d);
        let b = dot(p, d);
        let c = dot(p, p).plus(-self.radius_squared);
        ((b * b - a * c).sqrt() - b) / a
    }

    /// Where the ray leaves the box.
    #[inline(always)]
    fn on_box<N: Number>(&self, p: Vector<N>, d: Vector<N>) -> Vector<N> {
        let zero = N::constant(0.0);
        // How far it is to the side ahead on each axis, and how fast the ray goes there.
        let race = [0, 1, 2].map(|k| {
            let way = select(d[k].is_below(zero), p[k], -p[k]).plus(self.half[k]);
            (select(way.is_below(zero), zero, way), d[k].abs())
        });
        // way / speed compared without dividing by 0; a ray along a side never gets there.
        let is_first =
            |a: (N, N), b: (N, N)| (a.0 * b.1).is_below(b.0 * a.1) || (zero.is_below(a.1) && !zero.is_below(b.1));
        let x_or_z = select(is_first(race[0], race[2]), 0, 2);
        let axis = select(is_first(race[1], pick(race, x_or_z)), 1, x_or_z);
        let (way, speed) = pick(race, axis);
        let hit = along(p, d, way / speed);
        box_side(stretched(hit, self.local.per_size), axis, zero.is_below(pick(d, axis)))
    }

    /// The nearest side of the box, straight out.
    #[inline(always)]
    fn on_nearest_side<N: Number>(&self, p: Vector<N>) -> Vector<N> {
        let axis = largest([0, 1, 2].map(|k| p[k].abs().plus(-self.half[k])));
        let positive = N::constant(0.0).is_below(pick(p, axis));
        box_side(stretched(p, self.local.per_size), axis, positive)
    }
}

impl Rule for TwoPartRule {
    #[inline(always)]
    fn at<N: Number>(&self, point: &Point<N>) -> Vector<N> {
        let zero = N::constant(0.0);
        let p = self.local.place(point.position);
        let d = self.direction(point, p);
        match self.surface {
            Intermediate::Plane => self.on_plane(p, d),
            Intermediate::Cylinder => {
                let hit = along(p, d, self.far_on_round([p[0], zero, p[2]], [d[0], zero, d[2]]));
                [around(hit[0], hit[2]), hit[1].times(-self.local.per_size[1]).plus(0.5), zero]
            }
            Intermediate::Sphere => {
                let hit = along(p, d, self.far_on_round(p, d));
                [around(hit[0], hit[2]), from_pole(hit), zero]
            }
            Intermediate::Box if self.ray == ObjectRay::SurfaceNormal => self.on_nearest_side(p),
            Intermediate::Box => self.on_box(p, d),
        }
    }
}

/// The point `far` steps of `d` from `p`.
#[inline(always)]
fn along<N: Number>(p: Vector<N>, d: Vector<N>, far: N) -> Vector<N> {
    let step = scaled(d, far);
    [p[0] + step[0], p[1] + step[1], p[2] + step[2]]
}
