//! Curved cuts: a plane torn roughly, and a stroke of the knife drawn over the picture.

use super::surface::{CutSurface, Plane, Sheet};
use crate::math::{DVec2, DVec3, vec2};
use crate::noise::{Lattice, fbm_2d};
use crate::{Error, Result};

/// A plane with hills and dales of fractal noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rough {
    /// What it is without them.
    pub plane: Plane,
    /// Where its coordinates are zero; a point of the plane.
    pub origin: DVec3,
    /// Greatest height of the hills, model units; below half a particle's spacing the grain still looks right.
    pub amplitude: f64,
    /// Width of the largest hills, model units.
    pub size: f64,
    /// Another seed, other hills.
    pub seed: u32,
}

impl Rough {
    /// Height above the plane, and its slope, at coordinates of the plane.
    fn height(&self, at: DVec2) -> (f64, DVec2) {
        let q = at / self.size;
        let noise = fbm_2d(vec2(q.x as f32, q.y as f32), 4, 0.5, Lattice::seeded(self.seed));
        (noise.value as f64 * self.amplitude, noise.gradient.as_dvec2() * (self.amplitude / self.size))
    }

    /// How much longer than the height above it a way to the surface can be.
    fn steepness(&self) -> f64 {
        // The noise's slope is at most about 4 for each unit of height and width.
        let slope = 4.0 * self.amplitude / self.size;
        (1.0 + slope * slope).sqrt()
    }
}

impl CutSurface for Rough {
    /// To first order: the height above the surface, seen square to it where it is steepest.
    fn distance(&self, p: DVec3) -> f64 {
        let at = self.coordinates(p);
        (self.plane.distance(p) - self.height(at).0) / self.steepness()
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        let [u, v] = self.plane.axes();
        let (_, slope) = self.height(self.coordinates(p));
        (self.plane.normal - u * slope.x - v * slope.y).normalize()
    }
}

impl Sheet for Rough {
    fn coordinates(&self, p: DVec3) -> DVec2 {
        let [u, v] = self.plane.axes();
        DVec2::new((p - self.origin).dot(u), (p - self.origin).dot(v))
    }

    fn point(&self, at: DVec2) -> DVec3 {
        let [u, v] = self.plane.axes();
        self.origin + u * at.x + v * at.y + self.plane.normal * self.height(at).0
    }
}

/// A line drawn in a plane and pushed through the model square to it, as a knife follows the hand. Its ends go on straight.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Where the drawing plane's coordinates are zero.
    origin: DVec3,
    /// Right and up in the drawing plane, and towards the viewer.
    axes: [DVec3; 3],
    /// Corners in the drawing plane.
    points: Vec<DVec2>,
    /// Length of the line up to each corner.
    lengths: Vec<f64>,
}

impl Stroke {
    /// From corners in the plane's own axes (see [`Plane::axes`]) about `origin`, model units. The half below is on the
    /// right of the line, seen from the tip of the plane's normal.
    ///
    /// # Errors
    /// Less than two different corners, or numbers that are not finite.
    pub fn through(plane: &Plane, origin: DVec3, corners: &[DVec2]) -> Result<Self> {
        let fault = |why: &str| Error::Parameter {
            what: "stroke".into(),
            given: format!("{} corners", corners.len()),
            why: why.into(),
        };
        if !corners.iter().all(|c| c.is_finite()) || !origin.is_finite() {
            return Err(fault("it needs finite numbers"));
        }
        let mut points = corners.to_vec();
        points.dedup();
        if points.len() < 2 {
            return Err(fault("it needs two different corners"));
        }
        let mut lengths = vec![0.0];
        for w in points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + (w[1] - w[0]).length());
        }
        let [u, v] = plane.axes();
        Ok(Self { origin, axes: [u, v, plane.normal], points, lengths })
    }

    fn flat(&self, p: DVec3) -> DVec2 {
        DVec2::new((p - self.origin).dot(self.axes[0]), (p - self.origin).dot(self.axes[1]))
    }

    /// The nearest point of the line: which piece, how far along it in lengths of it (beyond 0 and 1 at the ends only).
    fn nearest(&self, p: DVec2) -> (usize, f64) {
        let last = self.points.len() - 2;
        let mut best = (f64::INFINITY, 0, 0.0);
        for k in 0..=last {
            let (a, b) = (self.points[k], self.points[k + 1]);
            let t = (p - a).dot(b - a) / (b - a).length_squared();
            let t = if k > 0 { t.max(0.0) } else { t };
            let t = if k < last { t.min(1.0) } else { t };
            let squared = (p - a - (b - a) * t).length_squared();
            if squared < best.0 {
                best = (squared, k, t);
            }
        }
        (best.1, best.2)
    }

    fn direction(&self, k: usize) -> DVec2 {
        (self.points[k + 1] - self.points[k]).normalize()
    }
}

impl CutSurface for Stroke {
    fn distance(&self, p: DVec3) -> f64 {
        let q = self.flat(p);
        let (k, t) = self.nearest(q);
        let (a, b) = (self.points[k], self.points[k + 1]);
        let from = q - a - (b - a) * t;
        // At a corner the side is that of the corner's mean direction.
        let mut way = self.direction(k);
        if t <= 0.0 && k > 0 {
            way += self.direction(k - 1);
        } else if t >= 1.0 && k + 2 < self.points.len() {
            way += self.direction(k + 1);
        }
        from.length() * if way.perp_dot(from) < 0.0 { -1.0 } else { 1.0 }
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        let way = self.direction(self.nearest(self.flat(p)).0);
        self.axes[1] * way.x - self.axes[0] * way.y
    }
}

impl Sheet for Stroke {
    fn coordinates(&self, p: DVec3) -> DVec2 {
        let (k, t) = self.nearest(self.flat(p));
        let along = self.lengths[k] + (self.lengths[k + 1] - self.lengths[k]) * t;
        // Along, towards the viewer and the normal (left of the line) are left-handed: the second axis is turned over.
        DVec2::new(along, -(p - self.origin).dot(self.axes[2]))
    }

    fn point(&self, at: DVec2) -> DVec3 {
        let last = self.points.len() - 2;
        let k = self.lengths[1..=last].partition_point(|&l| l <= at.x);
        let q = self.points[k] + self.direction(k) * (at.x - self.lengths[k]);
        self.origin + self.axes[0] * q.x + self.axes[1] * q.y - self.axes[2] * at.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::Topology;
    use crate::math::{Vec3, vec3};
    use crate::section::cut::{Policy, Soup, cut_along};
    use crate::section::grain::{Grain, GrainSpec, HitKind, Look, SectionKind, Side};

    fn sheets() -> Vec<Box<dyn Sheet>> {
        let plane = Plane::through(vec3(0.05, 0.02, 0.03), vec3(0.3, 1.0, 0.2)).unwrap();
        let origin = plane.normal * plane.offset;
        let corners: Vec<DVec2> = (-8..=8)
            .map(|i| {
                let x = i as f32 * 0.25;
                DVec2::new(x as f64, 0.25 * crate::math::sin_cos(x * 2.5).0 as f64)
            })
            .collect();
        vec![
            Box::new(Rough { plane, origin, amplitude: 0.12, size: 0.8, seed: 3 }),
            Box::new(Stroke::through(&plane, origin, &corners).unwrap()),
        ]
    }

    #[test]
    fn coordinates_and_points_go_there_and_back_along_a_right_handed_frame() {
        for sheet in sheets() {
            for i in 0..200 {
                let r = |k: i32| (crate::math::unit_float(crate::math::hash_cell(i, k, 0, 1)) as f64 - 0.5) * 3.0;
                let at = DVec2::new(r(0), r(1));
                let p = sheet.point(at);
                assert!(sheet.distance(p).abs() < 1e-6 && (sheet.coordinates(p) - at).length() < 1e-6);
                let step = 1e-3;
                let (u, v) = (sheet.point(at + DVec2::X * step) - p, sheet.point(at + DVec2::Y * step) - p);
                let normal = sheet.normal(p);
                assert!(u.cross(v).normalize().dot(normal) > 0.95);
                assert!(sheet.distance(p + normal * 0.01) > 0.0 && sheet.distance(p - normal * 0.01) < 0.0);
            }
        }
    }

    #[test]
    fn curved_cuts_leave_closed_halves_whose_volumes_add_up() {
        for name in ["icosphere", "knot", "flange"] {
            let mesh = crate::samples::scene(name, 24, 0).unwrap().mesh;
            let whole = Soup::from(&mesh).volume();
            for sheet in sheets() {
                let cut = cut_along(&mesh, &*sheet, 0.06, Policy::Strict).unwrap();
                for half in [&cut.below, &cut.above] {
                    let t = Topology::of_triangles(&half.raw.positions, &half.raw.triangles);
                    assert!(t.is_solid() || t.n_triangles == 0, "{name}: {t:?}");
                    for v in half.cap_vertices.clone().map(|v| v as usize) {
                        let d = sheet.distance(half.raw.positions[v].as_dvec3());
                        assert!(d.abs() < 1e-5, "{name}: {d} off the cut");
                    }
                }
                let sum = Soup::from(&cut.below.raw).volume() + Soup::from(&cut.above.raw).volume();
                assert!((sum - whole).abs() < 1e-6 * whole, "{name}: {sum} not {whole}");
                assert!(cut.below.cap.len() > 20);
            }
        }
    }

    #[test]
    fn edges_that_are_none_are_as_the_finest() {
        let mesh = crate::samples::plain::cube(1);
        let plane = Plane::through(Vec3::ZERO, Vec3::Y).unwrap();
        let corners = [DVec2::new(-3.0, 0.1), DVec2::new(0.0, 0.0), DVec2::new(3.0, 0.1)];
        let stroke = Stroke::through(&plane, DVec3::ZERO, &corners).unwrap();
        // Far away: nothing is divided.
        let far = Stroke::through(&plane, DVec3::new(0.0, 0.0, 99.0), &corners).unwrap();
        for edge in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let cut = cut_along(&mesh, &far, edge, Policy::Strict).unwrap();
            assert_eq!(cut.below.raw.triangles.len() + cut.above.raw.triangles.len(), mesh.triangles().len());
        }
        let cut = cut_along(&mesh, &stroke, f32::INFINITY, Policy::Strict).unwrap();
        assert!(!cut.below.cap.is_empty());
    }

    #[test]
    fn particles_on_a_curved_cut_keep_to_one_side() {
        let grain = Grain::new(GrainSpec::spheres(0.1, 0.05)).unwrap();
        for sheet in sheets() {
            let sheet: &dyn Sheet = &*sheet;
            let mut sides = std::collections::BTreeMap::new();
            for i in 0..60 {
                for j in 0..60 {
                    let p = sheet.point(DVec2::new(i as f64, j as f64) * 0.02 - 0.6);
                    let below = grain.eval(p, &sheet, Look { kind: SectionKind::Tear, side: Side::Below });
                    let above = grain.eval(p, &sheet, Look { kind: SectionKind::Tear, side: Side::Above });
                    assert_eq!((below.height, below.normal), (-above.height, -above.normal));
                    if below.kind != HitKind::Matrix {
                        let first = *sides.entry(below.particle).or_insert(below.kind);
                        assert_eq!(first, below.kind, "a particle is on both sides");
                    }
                }
            }
            assert!(sides.len() > 30);
        }
    }

    #[test]
    fn strokes_that_are_none_give_one_clear_line() {
        let plane = Plane::through(Vec3::ZERO, Vec3::Z).unwrap();
        let line = |c: &[DVec2]| Stroke::through(&plane, DVec3::ZERO, c).unwrap_err().to_string();
        assert_eq!(line(&[DVec2::ONE; 3]), "stroke \"3 corners\" is not possible: it needs two different corners");
        assert!(line(&[DVec2::ONE, DVec2::NAN]).contains("finite"));
    }
}
