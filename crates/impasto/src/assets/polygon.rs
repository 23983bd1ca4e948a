//! Polygons to triangles, concave ones included.
//!
//! Ear clipping by the crate `earcut`, or where it leaves out corners on straight edges by our own, in the plane that the polygon fits best (its normal after Newell: Sutherland,
//! Sproull, Schumacker, "A Characterization of Ten Hidden-Surface Algorithms", 1974).

use crate::math::{DVec3, Vec3};
use earcut::Earcut;

/// Polygons with more corners are cut like a fan: ear clipping may take quadratic time.
const MAX_EARS: usize = 20_000;

/// Polygons up to this many corners that have no ears, being warped, become a fan about their best corner.
const MAX_FAN: usize = 8;

/// The same for our own ear clipping, which may take cubic time.
const MAX_OWN_EARS: usize = 200;

/// Cuts polygons; keeps its scratch memory between calls.
#[derive(Default)]
pub(super) struct Triangulator {
    earcut: Option<Earcut<f64>>,
    plane: Vec<[f64; 2]>,
    ears: Vec<u32>,
}

impl Triangulator {
    /// Triangles of a polygon as indices into its `n` corners, wound as the polygon is. None below three corners.
    pub(super) fn cut(&mut self, n: usize, at: impl Fn(usize) -> Vec3, mut triangle: impl FnMut([u32; 3])) {
        match n {
            0..3 => {}
            3 => triangle([0, 1, 2]),
            4 => self.cut_quad(at, triangle),
            _ => {
                if n <= MAX_EARS && self.clip(n, at) {
                    self.ears.chunks_exact(3).for_each(|t| triangle([t[0], t[1], t[2]]));
                } else {
                    (1..n as u32 - 1).for_each(|i| triangle([0, i, i + 1]));
                }
            }
        }
    }

    /// Along the first diagonal, unless only the second lies inside.
    fn cut_quad(&mut self, at: impl Fn(usize) -> Vec3, mut triangle: impl FnMut([u32; 3])) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| at(i).as_dvec3());
        let agree = |p: DVec3, q: DVec3| p.dot(q) >= 0.0;
        let first = agree((b - a).cross(c - a), (c - a).cross(d - a));
        let second = agree((b - a).cross(d - a), (c - b).cross(d - b));
        if first || !second {
            triangle([0, 1, 2]);
            triangle([0, 2, 3]);
        } else {
            triangle([0, 1, 3]);
            triangle([1, 2, 3]);
        }
    }

    /// Fills `ears`; false when the polygon has no area or bad numbers.
    fn clip(&mut self, n: usize, at: impl Fn(usize) -> Vec3) -> bool {
        let origin = at(0).as_dvec3();
        let corner = |i: usize| at(i % n).as_dvec3() - origin;
        let newell: DVec3 = (0..n).map(|i| corner(i).cross(corner(i + 1))).sum();
        if !newell.is_finite() || newell == DVec3::ZERO || !(0..n).all(|i| corner(i).is_finite()) {
            return false;
        }
        // The plane of the two axes that see most of the polygon, oriented so that it turns counter-clockwise.
        let m = newell.abs();
        let (u, v, sign) = if m.x >= m.y && m.x >= m.z {
            (1, 2, newell.x)
        } else if m.y >= m.z {
            (2, 0, newell.y)
        } else {
            (0, 1, newell.z)
        };
        self.plane.clear();
        self.plane.extend((0..n).map(|i| {
            let p = corner(i);
            [p[u] * sign.signum(), p[v]]
        }));
        let earcut = self.earcut.get_or_insert_with(Earcut::new);
        earcut.earcut(self.plane.iter().copied(), &[], &mut self.ears);
        for t in self.ears.chunks_exact_mut(3) {
            if doubled_area(&self.plane, [t[0], t[1], t[2]]) < 0.0 {
                t.swap(1, 2);
            }
        }
        // A corner that is left out, as its edge is straight, would tear the polygon from its neighbour.
        if self.ears.len() < 3 * (n - 2) && n <= MAX_OWN_EARS {
            let own = clip_every_corner(&self.plane);
            if own.len() == 3 * (n - 2) {
                self.ears = own;
            } else if n <= MAX_FAN {
                self.ears = best_fan(&self.plane);
            }
        }
        !self.ears.is_empty()
    }
}

fn doubled_area(plane: &[[f64; 2]], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|i| plane[i as usize]);
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The fan whose least triangle is greatest.
fn best_fan(plane: &[[f64; 2]]) -> Vec<u32> {
    let n = plane.len() as u32;
    let fan = |start: u32| (1..n - 1).map(move |i| [start, (start + i) % n, (start + i + 1) % n]);
    let least = |start: u32| fan(start).map(|t| doubled_area(plane, t)).fold(f64::INFINITY, f64::min);
    let best = (0..n).max_by(|a, b| least(*a).total_cmp(&least(*b))).unwrap_or(0);
    fan(best).flatten().collect()
}

/// Ears of a counter-clockwise polygon, one a corner but two, none without area; fewer if that cannot be.
fn clip_every_corner(plane: &[[f64; 2]]) -> Vec<u32> {
    let turn = |a: u32, b: u32, c: u32| doubled_area(plane, [a, b, c]);
    let mut rest: Vec<u32> = (0..plane.len() as u32).collect();
    let mut ears = Vec::new();
    while rest.len() > 3 {
        let n = rest.len();
        let ear = (0..n).find(|&i| {
            let [a, b, c] = [rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]];
            let is_outside = |p: u32| turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0;
            let others = || (0..n - 3).map(|k| rest[(i + 2 + k) % n]);
            // What remains must not be a line.
            let remains = n > 4 || turn(a, c, rest[(i + 2) % n]) > 0.0;
            turn(a, b, c) > 0.0 && remains && others().all(is_outside)
        });
        let Some(i) = ear else { return Vec::new() };
        ears.extend([rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]]);
        rest.remove(i);
    }
    ears.extend(rest);
    ears
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;

    /// Area vector of the triangles, and their number.
    fn cut(corners: &[Vec3]) -> (Vec3, usize) {
        let (mut area, mut n) = (Vec3::ZERO, 0);
        Triangulator::default().cut(
            corners.len(),
            |i| corners[i],
            |t| {
                let [a, b, c] = t.map(|i| corners[i as usize]);
                let part = (b - a).cross(c - a) * 0.5;
                assert!(part.is_nan() || part.dot(area) >= 0.0, "a triangle is turned over");
                area += part;
                n += 1;
            },
        );
        (area, n)
    }

    #[test]
    fn concave_polygons_keep_their_area_and_side() {
        let quad = [vec3(0.0, 0.0, 1.0), vec3(4.0, 0.0, 1.0), vec3(1.0, 1.0, 1.0), vec3(0.0, 4.0, 1.0)];
        assert_eq!(cut(&quad), (vec3(0.0, 0.0, 4.0), 2));
        let turned = [quad[1], quad[2], quad[3], quad[0]];
        assert_eq!(cut(&turned), (vec3(0.0, 0.0, 4.0), 2));
        let l = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        assert_eq!(cut(&l.map(|[x, y]| vec3(x, y, 0.0))), (vec3(0.0, 0.0, 5.0), 4));
        assert_eq!(cut(&l.map(|[x, y]| vec3(y, x, 0.0))), (vec3(0.0, 0.0, -5.0), 4));
        assert_eq!(cut(&l.map(|[x, y]| vec3(7.0, x, y))), (vec3(5.0, 0.0, 0.0), 4));
        assert_eq!(cut(&l.map(|[x, y]| vec3(x, 7.0, y))), (vec3(0.0, -5.0, 0.0), 4));
    }

    #[test]
    fn corners_on_straight_edges_are_kept() {
        let at = |c: &[[f32; 2]]| c.iter().map(|[x, y]| vec3(*x, *y, 0.0)).collect::<Vec<_>>();
        let square = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        for turn in 0..5 {
            let mut turned = square;
            turned.rotate_left(turn);
            assert_eq!(cut(&at(&turned)), (vec3(0.0, 0.0, 4.0), 3), "{turn}");
        }
        let l = [[0.0, 0.0], [1.5, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [1.0, 3.0], [0.0, 3.0]];
        assert_eq!(cut(&at(&l)), (vec3(0.0, 0.0, 5.0), 6));
    }

    #[test]
    fn hopeless_polygons_end() {
        assert_eq!(cut(&[Vec3::NAN; 6]).1, 4);
        assert_eq!(cut(&[Vec3::ONE; 6]).1, 4);
        assert_eq!(cut(&[Vec3::ONE; 2]).1, 0);
    }
}
