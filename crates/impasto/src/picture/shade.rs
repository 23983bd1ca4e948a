//! Surfaces to light: what a batch sends towards the eye.
//!
//! Each model is one pass over the batch, a register's width of cells at a time. Cells do not know each other, so the
//! bits depend neither on the SIMD level nor on how cells are grouped.

use crate::lookup::{Shading, Surfaces};
use crate::math::{Lane, Vec3, unit_or};
use crate::picture::lanes::{
    V, V3, add, at_least, at_most, clamp01, dot, inverse_length, load, load3, per_channel, pow, power_floor, registers,
    scale, splat3, store3, whole_pow,
};
use crate::picture::light::{Light, LightKind, Lighting};
use crate::picture::{Ambient, metal_rough};
use crate::placement::{Needs, Surfels};
use fearless_simd::Simd;

/// Lights a batch of surfaces and writes what the eye receives, linear, one lane a channel.
///
/// Reads of `surfaces`: `color` (Unlit needs no more), `normal`, `occlusion`, `emission`, and for metal-roughness all
/// others but `alpha` and `height`; of `surfels` what [`needs`] says. `out` past the batch's count is overwritten with
/// meaningless numbers.
#[inline(always)]
pub fn shade<S: Simd>(
    simd: S,
    shading: Shading,
    lighting: &Lighting,
    surfels: &Surfels,
    surfaces: &Surfaces,
    out: &mut [Lane; 3],
) {
    match shading {
        Shading::Unlit => {
            for (out, color) in out.iter_mut().zip(&surfaces.color) {
                out[..surfaces.n].copy_from_slice(&color[..surfaces.n]);
            }
        }
        Shading::Lambert => simd.vectorize(
            #[inline(always)]
            || phong::<S, false>(simd, [0.0, 1.0], lighting, surfels, surfaces, out),
        ),
        Shading::BlinnPhong { specular, exponent } => simd.vectorize(
            #[inline(always)]
            || phong::<S, true>(simd, [specular, exponent], lighting, surfels, surfaces, out),
        ),
        Shading::MetalRough => simd.vectorize(
            #[inline(always)]
            || metal_rough::shade(simd, lighting, surfels, surfaces, out),
        ),
    }
}

/// Which lanes of [`Surfels`] light itself reads.
pub fn needs(shading: Shading, lighting: &Lighting) -> Needs {
    let lit = shading != Shading::Unlit;
    let from = |test: fn(&LightKind) -> bool| lighting.lights.iter().any(|l| test(&l.kind));
    let gloss = matches!(shading, Shading::BlinnPhong { .. } | Shading::MetalRough);
    Needs {
        position: lit && from(|k| matches!(k, LightKind::Point(_) | LightKind::Spot { .. })),
        view: lit && (gloss || from(|k| matches!(k, LightKind::Headlight))),
        ..Needs::default()
    }
}

/// Lambert's matte surface and, if `HIGHLIGHT`, Blinn's lobe about the half vector ("Models of Light Reflection for
/// Computer Synthesized Pictures", 1977): `color * (ambient + sum of lights * (n.l)) + specular * lights * (n.h)^exponent`.
#[inline(always)]
fn phong<S: Simd, const HIGHLIGHT: bool>(
    simd: S,
    [specular, exponent]: [f32; 2],
    lighting: &Lighting,
    surfels: &Surfels,
    surfaces: &Surfaces,
    out: &mut [Lane; 3],
) {
    let constant = lighting.ambient.is_constant();
    // Lights of one size share it.
    let mut lobe = Lobe::new(exponent);
    for at in registers::<S>(surfaces.n) {
        let color = load3(simd, &surfaces.color, at);
        let normal = load3(simd, &surfaces.normal, at);
        let view = load3(simd, &surfels.view, at);
        let ambient = ambient_at(simd, &lighting.ambient, constant, normal);
        let mut received = scale::<S>(ambient, load(simd, &surfaces.occlusion, at));
        let mut shine = load3(simd, &surfaces.emission, at);
        for light in &lighting.lights {
            let Arriving { toward, strength } = arriving(simd, light, surfels, view, at);
            let facing = dot::<S>(normal, toward);
            received = add::<S>(received, scale::<S>(strength, softened(simd, facing, light.size)));
            if HIGHLIGHT {
                let [specular, exponent] = widened(specular, exponent, light.size);
                if lobe.exponent != exponent {
                    lobe = Lobe::new(exponent);
                }
                let half = add::<S>(toward, view);
                let cosine = dot::<S>(normal, half) * inverse_length(simd, dot::<S>(half, half));
                shine = add::<S>(shine, scale::<S>(strength, lobe.at(simd, cosine) * specular));
            }
        }
        let lit = per_channel!(c => color[c] * received[c] + shine[c]);
        store3::<S>(lit, out, at);
    }
}

/// Powers of cosines.
struct Lobe {
    exponent: f32,
    /// The exponent, if multiplications do; else 0.
    whole: u32,
    floor: f32,
}

impl Lobe {
    #[inline(always)]
    fn new(exponent: f32) -> Self {
        let whole = exponent as u32;
        let is_whole = whole as f32 == exponent && (1..=256).contains(&whole);
        Self { exponent, whole: if is_whole { whole } else { 0 }, floor: power_floor(exponent) }
    }

    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, cosine: V<S>) -> V<S> {
        match self.whole {
            0 => pow(simd, cosine, self.exponent),
            whole => whole_pow(simd, cosine, whole, self.floor),
        }
    }
}

/// A highlight's strength and exponent for a light of some size: variances of the lobe and of the light's image in the
/// half vectors add, the energy stays.
#[inline(always)]
fn widened(specular: f32, exponent: f32, size: f32) -> [f32; 2] {
    if size <= 0.0 {
        return [specular, exponent];
    }
    let wide = exponent / (1.0 + exponent * size * size * 0.125);
    [specular * (wide + 8.0) / (exponent + 8.0), wide]
}

/// Light from one source on its way to a register of cells.
pub(super) struct Arriving<S: Simd> {
    /// Unit, towards the light.
    pub(super) toward: V3<S>,
    /// Colour on a surface that faces it.
    pub(super) strength: V3<S>,
}

#[inline(always)]
pub(super) fn arriving<S: Simd>(simd: S, light: &Light, surfels: &Surfels, view: V3<S>, at: usize) -> Arriving<S> {
    let strength = splat3(simd, light.strength());
    match light.kind {
        LightKind::Directional(toward) => Arriving { toward: splat3(simd, toward.to_array()), strength },
        LightKind::Headlight => Arriving { toward: view, strength },
        LightKind::Point(place) => {
            let (toward, falloff) = from_point(simd, place, surfels, at);
            Arriving { toward, strength: scale::<S>(strength, falloff) }
        }
        LightKind::Spot { position, axis, cone: [inner, outer] } => {
            let (toward, falloff) = from_point(simd, position, surfels, at);
            let axis = unit_or(-axis, Vec3::Y);
            // The recommended falloff of KHR_lights_punctual.
            let narrow = if inner - outer > 1e-3 { inner - outer } else { 1e-3 };
            let inside = (dot::<S>(toward, splat3(simd, axis.to_array())) - outer) * (1.0 / narrow);
            let inside = clamp01(simd, inside);
            Arriving { toward, strength: scale::<S>(strength, falloff * inside * inside) }
        }
    }
}

/// Unit direction to a place, and one over its squared distance.
#[inline(always)]
fn from_point<S: Simd>(simd: S, place: Vec3, surfels: &Surfels, at: usize) -> (V3<S>, V<S>) {
    let position = load3(simd, &surfels.position, at);
    let place = splat3(simd, place.to_array());
    let way: V3<S> = per_channel!(c => place[c] - position[c]);
    let inverse = inverse_length(simd, dot::<S>(way, way));
    (scale::<S>(way, inverse), inverse * inverse)
}

/// The cosine law for a round light of a given size (the sine w of its angular radius): exact while all of it is above
/// the surface's horizon, then a parabola that runs out when all of it is below.
///
/// `facing` above w gives `facing`, below -w zero, and `(facing + w)^2 / 4w` between; value and slope fit at both ends.
/// Not normalised on purpose: a surface that faces the light keeps its brightness whatever the size.
#[inline(always)]
pub(super) fn softened<S: Simd>(simd: S, facing: V<S>, size: f32) -> V<S> {
    if size <= 0.0 {
        return at_least(simd, facing, 0.0);
    }
    let within = at_most(simd, at_least(simd, facing + size, 0.0), 2.0 * size);
    within * within * (0.25 / size) + at_least(simd, facing - size, 0.0)
}

/// [`Ambient::at`] for a register of normals.
#[inline(always)]
pub(super) fn ambient_at<S: Simd>(simd: S, ambient: &Ambient, constant: bool, n: V3<S>) -> V3<S> {
    let t = &ambient.terms;
    if constant {
        return splat3(simd, t[0]);
    }
    let [x, y, z] = n;
    let (xy, yz, xz) = (x * y, y * z, x * z);
    let (zz, xx) = (z * z * 3.0 - 1.0, x * x - y * y);
    per_channel!(c => {
        let sum = y * t[1][c] + t[0][c] + z * t[2][c] + x * t[3][c];
        let sum = sum + xy * t[4][c] + yz * t[5][c] + zz * t[6][c] + xz * t[7][c] + xx * t[8][c];
        at_least(simd, sum, 0.0)
    })
}

#[cfg(test)]
#[path = "shade_tests.rs"]
mod tests;
