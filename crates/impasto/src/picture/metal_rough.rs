//! Metal and roughness: the material model of glTF 2.0, appendix B, with clear coat.
//!
//! Microfacets after Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007 (GGX), with the
//! height-correlated shadowing of Heitz, "Understanding the Masking-Shadowing Function", 2014, and Schlick's Fresnel.
//! Light from all around: the split sum of Karis, "Real Shading in Unreal Engine 4", 2013, its second factor by his
//! formula for mobile devices (after Lazarov), and light that bounces between facets as in Fdez-Aguera, "A
//! Multiple-Scattering Microfacet Model for Real-Time Image-based Lighting", 2019, so that a rough white metal stays white.

use crate::lookup::Surfaces;
use crate::math::Lane;
use crate::picture::lanes::{
    V, V3, add, at_least, at_most, clamp01, dot, exp2, inverse_length, load, load3, mix, per_channel, reflect,
    registers, scale, smaller, splat, store3,
};
use crate::picture::light::Lighting;
use crate::picture::shade::{Arriving, ambient_at, arriving, softened};
use crate::picture::surroundings::{Reflection, dominant, mirrored};
use crate::placement::Surfels;
use fearless_simd::{Simd, prelude::*};

/// What a dielectric mirrors head on: refractive index 1.5.
const DIELECTRIC: f32 = 0.04;

/// Least GGX alpha for lights without size: a sharper highlight would fall between the pixels.
const LEAST_ALPHA: f32 = 0.002;

#[inline(always)]
pub(super) fn shade<S: Simd>(
    simd: S,
    lighting: &Lighting,
    surfels: &Surfels,
    surfaces: &Surfaces,
    out: &mut [Lane; 3],
) {
    let constant = lighting.ambient.is_constant();
    for at in registers::<S>(surfaces.n) {
        let view = load3(simd, &surfels.view, at);
        let base = Facets::new(simd, load3(simd, &surfaces.normal, at), view, load(simd, &surfaces.roughness, at));
        let metal = clamp01(simd, load(simd, &surfaces.metalness, at));
        let color = load3(simd, &surfaces.color, at);
        let occlusion = load(simd, &surfaces.occlusion, at);
        let matte = scale::<S>(color, splat(simd, 1.0) - metal);
        let f0: V3<S> = per_channel!(c => mix::<S>(splat(simd, DIELECTRIC), color[c], metal));

        // Light from all around.
        let received = scale::<S>(ambient_at(simd, &lighting.ambient, constant, base.normal), occlusion);
        let seen = scale::<S>(around(simd, &lighting.reflection, &base), occlusion);
        let split = SplitSum::new(simd, &base);
        let mut sum: V3<S> = per_channel!(c => {
            let [once, more, rest] = split.shares(simd, f0[c]);
            once * seen[c] + (more + matte[c] * rest) * received[c]
        });

        // Light from lights.
        let coat_strength = clamp01(simd, load(simd, &surfaces.coat, at));
        let coated = coat_strength.simd_gt(splat(simd, 0.0)).any_true();
        let mut gloss = [splat(simd, 0.0); 3];
        let coat =
            Facets::new(simd, load3(simd, &surfaces.coat_normal, at), view, load(simd, &surfaces.coat_roughness, at));
        for light in &lighting.lights {
            let Arriving { toward, strength } = arriving(simd, light, surfels, view, at);
            let facing = softened(simd, dot::<S>(base.normal, toward), light.size);
            let half = Half::new(simd, toward, view);
            let shows = if light.in_reflection { 0.0 } else { 1.0 };
            let lobe = base.lobe(simd, toward, &half, light.size) * facing * shows;
            let once = splat(simd, 1.0) - half.fresnel(simd, splat(simd, DIELECTRIC));
            for c in 0..3 {
                let specular = lobe * half.fresnel(simd, f0[c]);
                sum[c] += (matte[c] * once * facing + specular) * strength[c];
            }
            if coated && !light.in_reflection {
                let facing = softened(simd, dot::<S>(coat.normal, toward), light.size);
                let lobe = coat.lobe(simd, toward, &half, light.size) * facing;
                let specular = lobe * half.fresnel(simd, splat(simd, DIELECTRIC));
                gloss = add::<S>(gloss, scale::<S>(strength, specular));
            }
        }
        sum = add::<S>(sum, load3(simd, &surfaces.emission, at));

        // What the coat mirrors does not reach the base, and is not seen of it.
        if coated {
            let seen = scale::<S>(around(simd, &lighting.reflection, &coat), occlusion);
            let split = SplitSum::new(simd, &coat);
            let [once, ..] = split.shares(simd, splat(simd, DIELECTRIC));
            let grazing = splat(simd, 1.0) - coat.n_dot_v;
            let squared = grazing * grazing;
            let mirrored = (squared * squared * grazing * (1.0 - DIELECTRIC) + DIELECTRIC) * coat_strength;
            let passed = splat(simd, 1.0) - mirrored;
            for c in 0..3 {
                sum[c] = sum[c] * passed + (gloss[c] + seen[c] * once) * coat_strength;
            }
        }
        store3::<S>(sum, out, at);
    }
}

/// A rough interface seen from somewhere.
struct Facets<S: Simd> {
    normal: V3<S>,
    /// Where the eye's ray goes after a mirror reflection.
    reflected: V3<S>,
    /// Not quite zero where bumps turn the normal away from the eye.
    n_dot_v: V<S>,
    /// Perceptual.
    roughness: V<S>,
    /// GGX alpha, the square of it.
    alpha: V<S>,
}

impl<S: Simd> Facets<S> {
    #[inline(always)]
    fn new(simd: S, normal: V3<S>, view: V3<S>, roughness: V<S>) -> Self {
        let roughness = clamp01(simd, roughness);
        Self {
            normal,
            reflected: reflect::<S>(view, normal),
            n_dot_v: at_most(simd, at_least(simd, dot::<S>(normal, view), 1e-3), 1.0),
            roughness,
            alpha: roughness * roughness,
        }
    }

    /// Distribution times visibility times pi: reflected share of light, before Fresnel and cosine.
    ///
    /// A light of some size widens the lobe: half vectors spread half as far as the directions to the light's points.
    #[inline(always)]
    fn lobe(&self, simd: S, toward: V3<S>, half: &Half<S>, size: f32) -> V<S> {
        let alpha = at_most(simd, at_least(simd, self.alpha + 0.5 * size, LEAST_ALPHA), 1.0);
        let squared = alpha * alpha;
        let n_dot_l = at_most(simd, at_least(simd, dot::<S>(self.normal, toward), 1e-3), 1.0);
        let n_dot_h = dot::<S>(self.normal, half.direction);
        // 1 - (n.h)^2 by the cross product: exact where the highlight is brightest and the difference cancels.
        let c = cross::<S>(self.normal, half.direction);
        let slope = dot::<S>(c, c) + n_dot_h * n_dot_h * squared;
        let distribution = squared / at_least(simd, slope * slope, 1e-20);
        let visibility = splat(simd, 0.5)
            / (masked(simd, n_dot_l, self.n_dot_v, squared) + masked(simd, self.n_dot_v, n_dot_l, squared));
        // The other side of the half vectors' plane carries no facets.
        n_dot_h.simd_gt(splat(simd, 0.0)).select(distribution * visibility, splat(simd, 0.0))
    }
}

/// One of the two halves of Smith's height-correlated masking, for a squared alpha.
#[inline(always)]
fn masked<S: Simd>(simd: S, a: V<S>, b: V<S>, squared: V<S>) -> V<S> {
    a * (b * b * (splat(simd, 1.0) - squared) + squared).sqrt()
}

/// The half vector between a light and the eye.
struct Half<S: Simd> {
    direction: V3<S>,
    /// (1 - v.h)^5: how grazing the mirror reflection is.
    grazing: V<S>,
}

impl<S: Simd> Half<S> {
    #[inline(always)]
    fn new(simd: S, toward: V3<S>, view: V3<S>) -> Self {
        let sum = add::<S>(toward, view);
        let direction = scale::<S>(sum, inverse_length(simd, dot::<S>(sum, sum)));
        let away = clamp01(simd, splat(simd, 1.0) - dot::<S>(view, direction));
        let squared = away * away;
        Self { direction, grazing: squared * squared * away }
    }

    /// Schlick's Fresnel term.
    #[inline(always)]
    fn fresnel(&self, simd: S, f0: V<S>) -> V<S> {
        f0 + (splat(simd, 1.0) - f0) * self.grazing
    }
}

#[inline(always)]
fn cross<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// How much a rough interface reflects of even surroundings: `f0 * scale + bias` at the first bounce.
struct SplitSum<S: Simd> {
    scale: V<S>,
    bias: V<S>,
}

impl<S: Simd> SplitSum<S> {
    #[inline(always)]
    fn new(simd: S, facets: &Facets<S>) -> Self {
        let r = facets.roughness;
        let rx = splat(simd, 1.0) - r;
        let ry = r * 0.0275 + 0.0425;
        let rz = r * -0.572 + 1.04;
        let rw = r * 0.022 - 0.04;
        let a004 = smaller::<S>(rx * rx, exp2(simd, facets.n_dot_v * -9.28)) * rx + ry;
        Self { scale: a004 * -1.04 + rz, bias: at_least(simd, a004 * 1.04 + rw, 0.0) }
    }

    /// Of even surroundings: the share reflected once, the share reflected after more bounces, and the rest, which
    /// enters the surface. They sum to 1 for a surface that absorbs nothing.
    #[inline(always)]
    fn shares(&self, simd: S, f0: V<S>) -> [V<S>; 3] {
        let one = splat(simd, 1.0);
        let once = f0 * self.scale + self.bias;
        let lost = clamp01(simd, one - (self.scale + self.bias));
        let mean = f0 + (one - f0) * (1.0 / 21.0);
        let more = once * mean * lost / (one - mean * lost);
        [once, more, at_least(simd, one - once - more, 0.0)]
    }
}

/// What an interface mirrors of its surroundings.
#[inline(always)]
fn around<S: Simd>(simd: S, reflection: &Reflection, facets: &Facets<S>) -> V3<S> {
    let toward = dominant(simd, facets.normal, facets.reflected, facets.alpha);
    match reflection {
        Reflection::Surroundings(around) => mirrored(simd, around, toward, facets.alpha),
        Reflection::Environment(environment) => environment.mirrored(simd, toward, facets.roughness),
    }
}
