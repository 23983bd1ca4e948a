//! The surface that a knife leaves: a plane, or anything with a signed distance.

use crate::math::{DVec2, DVec3, Vec3};
use crate::{Error, Result};

/// A surface that cuts space into the half below (negative) and the half above.
pub trait CutSurface {
    /// Signed distance of a point in model units. Near the surface it must be a distance; farther away its sign is enough.
    fn distance(&self, p: DVec3) -> f64;
    /// Unit normal at a point of the surface: away from the half below.
    fn normal(&self, p: DVec3) -> DVec3;
}

impl<T: CutSurface + ?Sized> CutSurface for &T {
    fn distance(&self, p: DVec3) -> f64 {
        (**self).distance(p)
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        (**self).normal(p)
    }
}

/// A cut surface with coordinates of its own, one to one near the mesh: so that its cap can be laid out flat.
pub trait Sheet: CutSurface {
    /// The coordinates of a point of the surface; of other points, those of one nearby. Along the surface they are lengths
    /// in model units, at least nearly; seen against the normal, counter-clockwise from the first to the second.
    fn coordinates(&self, p: DVec3) -> DVec2;
    /// The point of the surface at coordinates.
    fn point(&self, at: DVec2) -> DVec3;
}

/// A plane. Its normal points out of the half below; this half is the canonical one, which holds what lies on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit vector.
    pub normal: DVec3,
    /// Distance of the origin, along the normal, model units: `normal . p = offset` on the plane.
    pub offset: f64,
}

impl Plane {
    /// Through a point, model units; the normal need not be a unit vector.
    ///
    /// # Errors
    /// A normal without length; numbers that are not finite.
    pub fn through(point: Vec3, normal: Vec3) -> Result<Self> {
        let fault = |what: &str, given: Vec3, why: &str| Error::Parameter {
            what: what.into(),
            given: format!("{},{},{}", given.x, given.y, given.z),
            why: why.into(),
        };
        if !normal.is_finite() {
            return Err(fault("cut normal", normal, "it needs three finite numbers"));
        }
        if !point.is_finite() {
            return Err(fault("point of the cut", point, "it needs three finite numbers"));
        }
        let n = normal.as_dvec3();
        // Scaled first, so that neither tiny nor huge numbers lose their squares.
        let size = n.abs().max_element();
        if size == 0.0 {
            return Err(fault("cut normal", normal, "it has no length, so it points nowhere"));
        }
        let n = n / size;
        let n = n / (n.x * n.x + n.y * n.y + n.z * n.z).sqrt();
        Ok(Self { normal: n, offset: n.dot(point.as_dvec3()) })
    }

    /// The same plane with below and above exchanged.
    pub fn flipped(self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }

    /// Two unit vectors in the plane that make a right-handed frame with its normal: +u, +v and the normal.
    pub fn axes(&self) -> [DVec3; 2] {
        let n = self.normal;
        // The coordinate axis that the plane shows least foreshortened: flat cuts get straight axes.
        let a = n.abs();
        let along = if a.x <= a.y && a.x <= a.z {
            DVec3::X
        } else if a.z <= a.y {
            DVec3::Z
        } else {
            DVec3::Y
        };
        let u = along - n * along.dot(n);
        let u = u / (u.x * u.x + u.y * u.y + u.z * u.z).sqrt();
        [u, n.cross(u)]
    }
}

impl CutSurface for Plane {
    fn distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    fn normal(&self, _: DVec3) -> DVec3 {
        self.normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;

    #[test]
    fn planes_have_unit_normals_and_frames_or_one_clear_line() {
        for normal in [vec3(1.0, 0.0, 1.0), vec3(0.0, -3.0, 0.0), vec3(1e-30, 2e-30, 0.0), vec3(1e30, 1e30, 1e30)] {
            let plane = Plane::through(vec3(1.0, 2.0, 3.0), normal).unwrap();
            assert!((plane.normal.length() - 1.0).abs() < 1e-15);
            assert!(plane.distance(vec3(1.0, 2.0, 3.0).as_dvec3()).abs() < 1e-14);
            let [u, v] = plane.axes();
            assert!((u.cross(v) - plane.normal).length() < 1e-14 && u.dot(plane.normal).abs() < 1e-15);
            assert_eq!(plane.flipped().flipped(), plane);
        }
        let bad = |n: Vec3| Plane::through(Vec3::ZERO, n).unwrap_err().to_string();
        assert_eq!(bad(Vec3::ZERO), "cut normal \"0,0,0\" is not possible: it has no length, so it points nowhere");
        assert!(bad(vec3(f32::NAN, 0.0, 1.0)).contains("finite"));
        assert!(Plane::through(Vec3::INFINITY, Vec3::X).is_err());
    }
}
