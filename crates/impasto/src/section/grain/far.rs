//! Grain from afar: what is left of it when a pixel covers many particles.
//!
//! The mean normal shortens with the area that particles cover; its lost length is roughness (Toksvig, "Mipmapping Normal
//! Maps", 2005; Olano and Baker, "LEAN Mapping", 2010). For balls all is known: the covered area is the volume fraction
//! (Delesse), and the mean of Np . N on them is 3/4. Others are measured at a fixed set of places.

use super::eval::{Hit, HitKind};
use crate::math::{DVec3, Vec3, hash_cell, unit_float};

/// What a section looks like when its particles cannot be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Far {
    /// Which part of the area is particles: their colour's share.
    pub covered: f32,
    /// Length of the mean normal, 0 to 1.
    pub mean_length: f32,
    /// Mean openness: what is left of the sky's light.
    pub openness: f32,
    /// Mean height, model units.
    pub height: f32,
}

impl Far {
    /// Of balls that cover this part of the area, torn or hollow, by formula; heights are left at 0.
    pub fn of_balls(covered: f32) -> Self {
        Self { covered, mean_length: 1.0 - covered * 0.25, openness: 1.0 - covered * 0.25, height: 0.0 }
    }

    /// Measured at `n_samples` places in a cube of this size about the origin, model units; 4096 leave an error of about
    /// 0.01. `hit` tells what the section through a place shows, all of them with one normal.
    pub fn measured(size: f64, n_samples: u32, hit: &dyn Fn(DVec3) -> Hit) -> Self {
        let mut sum = (0.0f64, DVec3::ZERO, 0.0f64, 0.0f64);
        for i in 0..n_samples {
            let r = |k| (unit_float(hash_cell(i as i32, k, 0, 77)) as f64 - 0.5) * size;
            let hit = hit(DVec3::new(r(0), r(1), r(2)));
            sum.0 += is_particle(&hit) as u32 as f64;
            sum.1 += hit.normal.as_dvec3();
            sum.2 += hit.openness as f64;
            sum.3 += hit.height as f64;
        }
        let n = n_samples.max(1) as f64;
        Self {
            covered: (sum.0 / n) as f32,
            mean_length: (sum.1.length() / n) as f32,
            openness: (sum.2 / n) as f32,
            height: (sum.3 / n) as f32,
        }
    }

    /// How tightly normals gather about their mean (von Mises-Fisher's kappa); infinite where all are alike.
    pub fn kappa(&self) -> f32 {
        let l = self.mean_length;
        if l < 1.0 { l * (3.0 - l * l) / (1.0 - l * l) } else { f32::INFINITY }
    }

    /// A Beckmann roughness m that the lost relief makes of `m`.
    pub fn roughness(&self, m: f32) -> f32 {
        let kappa = self.kappa();
        if kappa > 0.0 { (m * m + 2.0 / kappa).sqrt().min(1.0) } else { 1.0 }
    }
}

/// How far the far model has taken over: 0 is detail only, 1 the far model only. Both in model units.
pub fn fade(footprint: f32, diameter: f32) -> f32 {
    let x = ((footprint / diameter - 0.5) / 1.5).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// The mean over a pixel's footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered {
    /// Mean height, model units.
    pub height: f32,
    /// Mean normal: shorter than 1 where normals differ. Not to be made unit before its length was used.
    pub normal: Vec3,
    /// Which part is particles.
    pub covered: f32,
    /// Mean openness.
    pub openness: f32,
}

/// A pixel's footprint on the section: a parallelogram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Its middle, model space.
    pub middle: DVec3,
    /// From one pixel to the next to the right.
    pub dx: DVec3,
    /// And to the next below.
    pub dy: DVec3,
    /// Unit normal of the section, out of the half that is looked at.
    pub normal: DVec3,
}

/// The mean over a footprint: `n` x `n` jittered places, and the far model as far as particles of this diameter are too small
/// for that. The jitter depends on the footprint's middle only.
pub fn filtered(footprint: &Footprint, (far, diameter): (&Far, f32), n: u32, hit: &dyn Fn(DVec3) -> Hit) -> Filtered {
    let Footprint { middle, dx, dy, normal: outward } = *footprint;
    let share = fade(dx.length().max(dy.length()) as f32, diameter);
    let flat = outward.as_vec3() * far.mean_length;
    let all_far = Filtered { height: far.height, normal: flat, covered: far.covered, openness: far.openness };
    if share >= 1.0 {
        return all_far;
    }
    let bits = middle.to_array().map(f64::to_bits);
    let seed = bits.iter().fold(0, |h, b| hash_cell(*b as i32, (b >> 32) as i32, 0, h));
    let n = n.max(1);
    let weight = 1.0 / (n * n) as f32;
    let mut near = Filtered { height: 0.0, normal: Vec3::ZERO, covered: 0.0, openness: 0.0 };
    for j in 0..n {
        for i in 0..n {
            let off = |k: i32, at: u32| {
                let jitter = if n > 1 { unit_float(hash_cell((j * n + i) as i32, k, 0, seed)) } else { 0.5 };
                ((at as f32 + jitter) / n as f32 - 0.5) as f64
            };
            let hit = hit(middle + dx * off(0, i) + dy * off(1, j));
            near.height += hit.height * weight;
            near.normal += hit.normal * weight;
            near.covered += if is_particle(&hit) { weight } else { 0.0 };
            near.openness += hit.openness * weight;
        }
    }
    let mix = |near: f32, far: f32| near + (far - near) * share;
    Filtered {
        height: mix(near.height, all_far.height),
        normal: near.normal + (flat - near.normal) * share,
        covered: mix(near.covered, all_far.covered),
        openness: mix(near.openness, all_far.openness),
    }
}

fn is_particle(hit: &Hit) -> bool {
    !matches!(hit.kind, HitKind::Matrix | HitKind::Bevel)
}
