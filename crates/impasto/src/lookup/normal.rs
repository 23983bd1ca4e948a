//! Normals from maps: tangent-space normals and slopes of heights, in the mesh's tangent frames (MikkTSpace's convention).
//!
//! What a level of a map averages away comes back as roughness: the variance of slopes is added to GGX's squared width
//! (Toksvig 2005; Kaplanyan et al., "Filtering distributions of normals", 2016).

use crate::lookup::evaluate::Points;
use crate::lookup::layer::{Layer, Look, Target, Texture};
use crate::lookup::operator::Gate;
use crate::lookup::{Reading, Surfaces, Usage};
use crate::math::{BATCH, Frame, Lane, Vec3, unit_or, vec3};
use crate::placement::{Placement, Surfels, TexCoords};
use fearless_simd::Simd;

/// What bump layers leave for the end.
pub(super) struct Bumps {
    /// Variance of slopes below a texel, of the surface and of the coat; only valid if there is any.
    variance: [Lane; 2],
    is_rough: [bool; 2],
}

impl Bumps {
    pub(super) const ZERO: Self = Self { variance: [[0.0; BATCH]; 2], is_rough: [false; 2] };

    pub(super) fn clear(&mut self) {
        self.is_rough = [false; 2];
    }
}

impl Texture {
    /// Whether its red and green are slopes already.
    pub(super) fn holds_slopes(&self) -> bool {
        matches!(self, Self::Image(image) if image.usage == Usage::Slope)
    }
}

/// Bends normals by a reading: of normals, or of slopes for `Target::Bump`.
#[inline(always)]
pub(super) fn bump<S: Simd>(
    simd: S,
    layer: &Layer,
    (points, coords): (Points, &TexCoords),
    reading: &Reading,
    bumps: &mut Bumps,
    out: &mut Surfaces,
) {
    let (which, scale, is_slope) = match layer.target {
        Target::Normal { scale } => (0, scale, false),
        Target::Bump { scale } => (0, scale, true),
        Target::CoatNormal { scale } => (1, scale, false),
        _ => return,
    };
    let n = points.surfels.n;
    if !bumps.is_rough[which] {
        bumps.is_rough[which] = true;
        bumps.variance[which][..n].fill(0.0);
    }
    let has_tangents = !points.mesh.tangents().is_empty() && matches!(layer.placement, Placement::Uv(_));
    let gate = Gate::new(1.0, reading);
    let scale = scale * layer.strength;
    let normals = if which == 0 { &mut out.normal } else { &mut out.coat_normal };
    simd.vectorize(
        #[inline(always)]
        || {
            for i in 0..n {
                if gate.applied.is_some_and(|a| a[i] == 0.0) {
                    continue;
                }
                let normal = vec3(normals[0][i], normals[1][i], normals[2][i]);
                let frame = match has_tangents {
                    true => mesh_frame(normal, points.surfels, i),
                    false => coordinate_frame(normal, points, coords, i),
                };
                let [x, y, z, a] = [0, 1, 2, 3].map(|c| reading.rgba[c][i]);
                let (x, y, z, variance) = match is_slope {
                    // Downwards is against the bitangent.
                    true => (-x * scale, y * scale, 1.0, (z - x * x - y * y) * scale * scale),
                    false => {
                        let length = if a > 0.05 { a } else { 0.05 };
                        let variance = (1.0 - length) / length * scale * scale;
                        ((2.0 * x - 1.0) * scale, (2.0 * y - 1.0) * scale, 2.0 * z - 1.0, variance)
                    }
                };
                let bent = frame.tangent * x + frame.bitangent * y + frame.normal * z;
                let bent = unit_or(bent, normal);
                (normals[0][i], normals[1][i], normals[2][i]) = (bent.x, bent.y, bent.z);
                let variance = if variance > 0.0 { variance } else { 0.0 };
                bumps.variance[which][i] += variance;
            }
        },
    );
}

/// The interpolated tangent, made perpendicular to the normal. Tangents that vanish get some frame.
#[inline(always)]
fn mesh_frame(normal: Vec3, surfels: &Surfels, i: usize) -> Frame {
    let t = vec3(surfels.tangent[0][i], surfels.tangent[1][i], surfels.tangent[2][i]);
    let sign = if surfels.tangent[3][i] < 0.0 { -1.0 } else { 1.0 };
    framed(normal, t, sign)
}

#[inline(always)]
fn framed(normal: Vec3, tangent: Vec3, sign: f32) -> Frame {
    let t = unit_or(tangent - normal * normal.dot(tangent), Vec3::ZERO);
    if t == Vec3::ZERO {
        return Frame::about(normal);
    }
    Frame { tangent: t, bitangent: normal.cross(t) * sign, normal }
}

/// The frame along growing s and falling t, from the change of position and coordinate over the cell
/// (Mikkelsen, "Bump mapping unparametrized surfaces on the GPU", 2010).
fn coordinate_frame(normal: Vec3, points: Points, coords: &TexCoords, i: usize) -> Frame {
    let triangles = points.mesh.triangles();
    let Some(corners) = triangles.get(points.surfels.triangle[i] as usize) else { return Frame::about(normal) };
    let [a, b, c] = corners.map(|v| points.mesh.positions()[v as usize]);
    let d = &points.surfels.d_barycentric;
    let along = |axis: usize| (b - a) * d[axis][0][i] + (c - a) * d[axis][1][i];
    let (p_dx, p_dy) = (along(0), along(1));
    let [s_dx, t_dx, s_dy, t_dy] = [coords.d_dx[0][i], coords.d_dx[1][i], coords.d_dy[0][i], coords.d_dy[1][i]];
    // Cramer's rule up to the determinant's size: lengths do not matter, directions do.
    let determinant = s_dx * t_dy - t_dx * s_dy;
    let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
    let p_ds = (p_dx * t_dy - p_dy * t_dx) * sign;
    let p_dt = (p_dy * s_dx - p_dx * s_dy) * sign;
    // Lengths are squares of pixels; without this they may be too small for `unit_or`.
    let size = p_ds.abs().max_element();
    let p_ds = if size > 0.0 { p_ds * (1.0 / size) } else { p_ds };
    let side = if normal.cross(p_ds).dot(p_dt) <= 0.0 { 1.0 } else { -1.0 };
    framed(normal, p_ds, side)
}

/// Widens roughness by what maps hide, and turns normals to the side that is seen.
#[inline(always)]
pub(super) fn finish(look: &Look, points: Points, bumps: &Bumps, out: &mut Surfaces) {
    let surfels = points.surfels;
    let n = surfels.n.min(BATCH);
    for (which, lane) in [&mut out.roughness, &mut out.coat_roughness].into_iter().enumerate() {
        if bumps.is_rough[which] {
            (0..n).for_each(|i| lane[i] = widened(lane[i], bumps.variance[which][i]));
        }
    }
    if look.is_double_sided {
        for lane in out.normal.iter_mut().chain(&mut out.coat_normal) {
            (0..n).for_each(|i| lane[i] *= surfels.side[i]);
        }
    }
}

/// Perceptual roughness whose GGX width (its square) has twice the variance added to its own square.
#[inline(always)]
fn widened(roughness: f32, variance: f32) -> f32 {
    let squared = roughness * roughness;
    let wide = squared * squared + 2.0 * variance;
    let wide = if wide < 1.0 { wide } else { 1.0 };
    if variance > 0.0 { wide.sqrt().sqrt() } else { roughness }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roughness_is_widened_and_stays_in_range() {
        assert_eq!(widened(0.3, 0.0), 0.3);
        assert!((widened(0.5, 0.05) - (0.0625_f32 + 0.1).sqrt().sqrt()).abs() < 1e-6);
        assert_eq!(widened(0.9, 10.0), 1.0);
    }
}
