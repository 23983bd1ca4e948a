//! Bodies that are worth cutting open: a loaf, a log, fruit, a bone, a nodule and a block.
//!
//! All are closed, of about unit size about the origin, with +Y up; `n` is about the number of edges around.

use crate::assets::{Mesh, RawMesh};
use crate::math::exact::{cos, exp, pow, sin};
use crate::math::{DVec2, DVec3, Vec3};
use crate::noise::{Lattice, fbm_3d};
use crate::samples::sheet::{self, Point};
use std::f64::consts::PI;

/// A loaf of tin bread, 3 long (x), 1.6 wide: straight sides, a waist where the tin ended, and a risen top.
pub fn loaf(n: u32) -> Mesh {
    closed(n, &|turn, t| {
        let d = direction(turn, t);
        let half = DVec3::new(1.5, 0.62, 0.72);
        let p = d * box_radius(d / half, 5.0);
        let up = smooth((p.y + 0.05) / 0.3);
        // The top bulges over the tin's rim and sinks towards its ends.
        let arch =
            1.0 - 0.55 * pow((p.z / half.z).abs().min(1.0), 2.0) - 0.25 * pow((p.x / half.x).abs().min(1.0), 4.0);
        let waist = exp(-pow((p.y - 0.12) / 0.1, 2.0));
        let wide = 1.0 + 0.13 * up - 0.05 * waist;
        let rough = noise(p * 1.4, 3) * 0.03 + noise(p * 5.0, 2) * 0.008;
        let q = DVec3::new(p.x * (1.0 + 0.04 * up), p.y * (1.0 + 0.42 * up * arch.max(0.0)), p.z * wide);
        q * (1.0 + rough)
    })
}

/// A length of trunk along y, 3.2 long, radius about 0.7: rough bark, slightly bent, sawn off flat.
pub fn log(n: u32) -> Mesh {
    let n = n.max(12);
    let n_up = (n / 2).max(4);
    let half = 1.6;
    let rim = |i: u32, y: f64, share: f64| {
        let turn = 2.0 * PI * (i % n) as f64 / n as f64;
        let d = DVec3::new(sin(turn), 0.0, cos(turn));
        // Furrows of the bark run along the trunk; the trunk itself is not quite round.
        let furrow = noise(d * 5.0 + DVec3::Y * (y * 0.9), 3).abs();
        let shape = noise(d * 0.8 + DVec3::Y * (y * 0.3 + 7.0), 1);
        let radius = 0.7 * (1.0 + 0.09 * shape) - 0.09 * (0.45 - furrow).max(0.0);
        DVec3::new(0.05 * sin(1.2 * y), y, 0.03 * sin(1.7 * y + 1.0)) + d * (radius * share)
    };
    let mut raw = sheet::empty();
    let row = |j: u32| half * (2.0 * j as f64 / n_up as f64 - 1.0);
    sheet::grid(&mut raw, [n, n_up], |i, j| {
        let y = row(j);
        let step = 1e-3;
        let turn = |i: u32| rim((i + 1) % n, y, 1.0) - rim((i + n - 1) % n, y, 1.0);
        let normal = turn(i).cross(rim(i, y + step, 1.0) - rim(i, y - step, 1.0));
        let uv = DVec2::new(0.01 + 0.98 * i as f64 / n as f64, 0.01 + 0.65 * (1.0 - j as f64 / n_up as f64));
        Point { position: rim(i, y, 1.0), normal, uv }
    });
    for (y, middle) in [(-half, 0.25), (half, 0.75)] {
        let rows = (n / 8).clamp(2, 64);
        sheet::grid(&mut raw, [n, rows], |i, j| {
            // Rows run outwards below and inwards above, so that both lids face away from the trunk.
            let share = if y < 0.0 { j } else { rows - j } as f64 / rows as f64;
            let turn = 2.0 * PI * i as f64 / n as f64;
            let flat = DVec2::new(-sin(turn), cos(turn) * y.signum()) * (0.15 * share);
            Point { position: rim(i, y, share), normal: DVec3::Y * y, uv: DVec2::new(middle, 0.83) + flat }
        });
    }
    sheet::finish(raw)
}

/// A ball of radius 1 with a dimple at either pole: an orange.
pub fn fruit(n: u32) -> Mesh {
    closed(n, &|turn, t| {
        let d = direction(turn, t);
        let dimple = |pole: f64| exp(-pow((1.0 - pole) / 0.035, 1.0));
        let r = 1.0 - 0.09 * dimple(d.y) - 0.05 * dimple(-d.y) + 0.012 * noise(d * 1.7, 2) + 0.004 * noise(d * 24.0, 1);
        DVec3::new(d.x, d.y * 0.95, d.z) * r
    })
}

/// A ball of about radius 1 with blunt edges and a crown: a pomegranate.
pub fn pomegranate(n: u32) -> Mesh {
    // Parts of the way from pole to pole: the ball, the outside of the crown, and its inside down to the bottom of the cup.
    const BALL: f64 = 0.8;
    const CROWN: f64 = 0.9;
    closed(n, &|turn, t| {
        let blunt = 1.0 + 0.025 * cos(6.0 * turn);
        let round = |part: f64| {
            let theta = (PI - 0.28) * part;
            let d = direction(turn, theta / PI);
            let out = 1.0 + (blunt - 1.0) * sin(theta);
            DVec3::new(d.x * out, d.y * 0.92, d.z * out)
        };
        let neck = round(1.0);
        let flat = DVec3::new(neck.x, 0.0, neck.z);
        let tooth = 0.2 + 0.12 * cos(6.0 * turn);
        let edge = flat * 1.25 + DVec3::Y * (neck.y + tooth);
        if t < BALL {
            round(t / BALL)
        } else if t < CROWN {
            let s = (t - BALL) / (CROWN - BALL);
            // Drawn in a little before it opens.
            neck + (edge - neck) * s - flat * (0.3 * s * (1.0 - s))
        } else {
            let s = (t - CROWN) / (1.0 - CROWN);
            let cup = DVec3::Y * (neck.y - 0.02);
            let wall = flat * 0.72 + DVec3::Y * (neck.y + 0.02);
            let (a, b) = (edge + (wall - edge) * s, wall + (cup - wall) * s);
            a + (b - a) * s
        }
    })
}

/// A long bone along y, 3.4 long: a shaft with a ball of a head above and two knuckles below.
pub fn bone(n: u32) -> Mesh {
    closed(n, &|turn, t| {
        let half = 1.7;
        // As many rows near the ends as where the shaft is.
        let y = -half * cos(PI * t);
        let s = y / half;
        let close = (1.0 - pow(s.abs(), 14.0)).max(0.0).sqrt();
        let (below, above) = (smooth((-s - 0.42) / 0.42), smooth((s - 0.5) / 0.36));
        let c = cos(2.0 * turn);
        let knuckles = below * (0.26 - 0.14 * c);
        let head = above * 0.17;
        let r = close * (0.27 + knuckles + head - 0.02 * c * (1.0 - below - above).max(0.0));
        let p = DVec3::new(r * sin(turn), y, r * cos(turn));
        // A groove between the knuckles; the head stands off to a side.
        let groove = 0.3 * below * close * exp(-pow(p.x / 0.17, 2.0)) * smooth((-s - 0.8) / 0.2);
        let bow = 0.08 * cos(0.5 * PI * s);
        p + DVec3::new(0.16 * above * smooth((s - 0.6) / 0.4), groove, bow) + DVec3::ONE * (0.008 * noise(p * 3.0, 2))
    })
}

/// A rounded stone of about radius 1, a little longer along x.
pub fn nodule(n: u32, seed: u32) -> Mesh {
    closed(n, &|turn, t| {
        let d = direction(turn, t);
        let shift = DVec3::splat((seed % 64) as f64 * 3.7);
        let r = 1.0 + 0.17 * noise(d * 1.1 + shift, 2) + 0.025 * noise(d * 4.5 + shift, 3);
        DVec3::new(d.x * 1.12, d.y * 0.86, d.z) * r
    })
}

/// A block of 2.4 x 1.6 x 1.6 with rounded edges, `n` x `n` cells a side.
pub fn block(n: u32) -> Mesh {
    let n = n.max(4);
    let half = DVec3::new(1.2, 0.8, 0.8);
    let rounding = 0.09;
    let inner = half - DVec3::splat(rounding);
    // Rows stand close together at the edges, where the surface turns.
    let place = |k: u32| {
        let x = 2.0 * k as f64 / n as f64 - 1.0;
        if k == 0 || k == n { x.signum() } else { x * (1.6 - 0.6 * x * x) }
    };
    let mut raw = sheet::empty();
    for out in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z] {
        let up = if out.y != 0.0 { DVec3::Z * -out.y } else { DVec3::Y };
        let right = up.cross(out);
        sheet::grid(&mut raw, [n, n], |i, j| {
            let at = (out + right * place(i) + up * place(j)) * half;
            let core = at.clamp(-inner, inner);
            let normal = (at - core).normalize();
            let uv = DVec2::new(i as f64 / n as f64, 1.0 - j as f64 / n as f64);
            Point { position: core + normal * rounding, normal, uv }
        });
    }
    sheet::finish(raw)
}

/// A surface from pole to pole: `place` of an angle about y, from +z towards +x, and a part of the way up, 0 to 1; at both
/// ends all angles meet. u runs once around, v from the upper pole to the lower.
fn closed(n: u32, place: &dyn Fn(f64, f64) -> DVec3) -> Mesh {
    let n = n.max(6);
    let n_up = (n / 2).max(4);
    let turn = |i: u32| 2.0 * PI * (i % n) as f64 / n as f64;
    let mut raw: RawMesh = sheet::empty();
    sheet::grid(&mut raw, [n, n_up], |i, j| {
        let t = j as f64 / n_up as f64;
        let is_pole = j == 0 || j == n_up;
        // At a pole each triangle has a corner of its own, in its middle; `sheet` keeps one of the two beside it.
        let beside = if is_pole { if j == 0 { 0.5 } else { -0.5 } } else { 0.0 };
        let uv = DVec2::new(((i as f64 + beside) / n as f64).clamp(0.0, 1.0), 1.0 - t);
        if is_pole {
            let near = if j == 0 { 1e-3 } else { 1.0 - 1e-3 };
            let normal = (0..8).map(|k| slope(place, k as f64 * PI * 0.25, near)).sum();
            return Point { position: place(0.0, t), normal, uv };
        }
        Point { position: place(turn(i), t), normal: slope(place, turn(i), t), uv }
    });
    sheet::finish(raw)
}

/// The outward normal of a surface from pole to pole.
fn slope(place: &dyn Fn(f64, f64) -> DVec3, turn: f64, t: f64) -> DVec3 {
    const STEP: f64 = 5e-4;
    let around = place(turn + STEP, t) - place(turn - STEP, t);
    let up = place(turn, (t + STEP).min(1.0)) - place(turn, (t - STEP).max(0.0));
    around.cross(up).normalize_or_zero()
}

/// The unit vector at an angle about y and a part of the way from the lower pole to the upper.
fn direction(turn: f64, t: f64) -> DVec3 {
    let out = if t <= 0.0 || t >= 1.0 { 0.0 } else { sin(PI * t) };
    DVec3::new(out * sin(turn), -cos(PI * t), out * cos(turn))
}

/// How far the surface |x|^p + |y|^p + |z|^p = 1 is from its middle along `d`.
fn box_radius(d: DVec3, p: f64) -> f64 {
    let sum: f64 = d.to_array().iter().map(|x| pow(x.abs(), p)).sum();
    pow(sum, -1.0 / p)
}

/// From 0 to 1 with vanishing slope at both ends.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

fn noise(p: DVec3, n_octaves: u32) -> f64 {
    let p = p.as_vec3() + Vec3::new(0.31, 0.77, 0.53);
    fbm_3d(p, n_octaves, 0.5, Lattice::seeded(0x50_11d5)).value as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::solid::measure;

    #[test]
    fn bodies_are_closed_balls_that_face_outwards() {
        let cases = [
            ("loaf", loaf(96), 3.0..7.0),
            ("log", log(96), 3.5..6.0),
            ("fruit", fruit(96), 3.4..4.2),
            ("pomegranate", pomegranate(96), 3.2..4.4),
            ("bone", bone(96), 0.8..3.0),
            ("nodule", nodule(96, 0), 2.5..5.5),
            ("other nodule", nodule(48, 9), 2.5..5.5),
            ("block", block(12), 5.6..6.2),
            ("coarsest", nodule(0, 0), 1.0..5.0),
        ];
        for (name, mesh, volume) in cases {
            let solid = measure(&mesh);
            assert!(solid.is_closed && solid.euler == 2, "{name}: {solid:?}");
            assert!(volume.contains(&solid.volume), "{name}: {solid:?}");
            // Along the edge of a crown a normal stands between two sides.
            assert!(solid.share_of_right_normals > 0.97, "{name}: {solid:?}");
            let uv = &mesh.uv_sets()[0].uv;
            assert!(uv.iter().all(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0), "{name}");
        }
    }
}
