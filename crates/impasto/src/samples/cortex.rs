//! A folded surface like half of a brain, with a thickness that is missing where the halves are joined.
//!
//! Sulci run where smooth noise is zero: lines of one width that branch, end and never cross. Not anatomy, but as hard to
//! show as anatomy is.

use crate::assets::{Element, Field, Material, Scene, Values};
use crate::math::exact::exp;
use crate::math::{DVec3, Vec3};
use crate::noise::{Lattice, fbm_3d, gradient_3d};
use crate::samples::{plain, sheet};

/// Millimetres from the middle to the front.
const LENGTH: f64 = 84.0;

/// How deep sulci are, as a share of that.
const DEPTH: f64 = 0.085;

/// Half a brain with its front to +Z and its outer side to +X; millimetres. The field `thickness` is missing on the medial
/// wall.
pub fn scene(n: u32, seed: u32) -> Scene {
    let mut raw = plain::icosphere(n / 2).into_raw();
    let mut thickness = Vec::with_capacity(raw.positions.len());
    for (position, normal) in raw.positions.iter_mut().zip(&mut raw.normals) {
        let d = position.as_dvec3().normalize();
        let (x, y) = d.any_orthonormal_pair();
        let step = 2e-3;
        let along =
            |way: DVec3| folded((d + way * step).normalize(), seed) - folded((d - way * step).normalize(), seed);
        *position = (folded(d, seed) * LENGTH).as_vec3();
        *normal = along(x).cross(along(y)).normalize_or(d).as_vec3();
        thickness.push(thickness_at(d, seed) as f32);
    }
    let values = Values::F32(thickness);
    let (name, unit) = ("thickness".into(), "mm".into());
    raw.fields = vec![Field { name, unit, element: Element::Vertex, n_components: 1, values }];
    raw.uv_sets.clear();
    raw.parts.clear();
    sheet::part(&mut raw, "cortex", Some(0));
    let material =
        Material { name: "cortex".into(), base_color: [0.62, 0.45, 0.40, 1.0], roughness: 0.5, ..Material::default() };
    Scene { materials: vec![material], ..Scene::of("cortex", raw.mend().value) }
}

/// The hull without folds: flat towards the other half, and a little below.
fn hull(d: DVec3) -> DVec3 {
    let x = 0.35 * d.x + 0.25 * (d.x * d.x + 0.04).sqrt();
    let y = 0.62 * d.y + 0.1 * (d.y * d.y + 0.05).sqrt();
    // Narrower at the front than at the back.
    DVec3::new(x * (1.0 - 0.18 * d.z), y * (1.0 - 0.1 * d.z), d.z)
}

/// How much of a sulcus is at a direction: 1 at its ground, 0 on the gyri.
fn sulcus(d: DVec3, seed: u32) -> f64 {
    let p: Vec3 = hull(d).as_vec3();
    let lattice = Lattice::seeded(seed.wrapping_mul(31));
    let bend = gradient_3d(p * 2.1, lattice.octave()).gradient * 0.04;
    let noise = fbm_3d((p + bend) * 5.8, 2, 0.3, lattice).value as f64;
    exp(-(noise / 0.12) * (noise / 0.12))
}

fn folded(d: DVec3, seed: u32) -> DVec3 {
    let (x, y) = d.any_orthonormal_pair();
    let along = |way: DVec3| hull(d + way * 1e-3) - hull(d - way * 1e-3);
    hull(d) - along(x).cross(along(y)).normalize() * (DEPTH * sulcus(d, seed))
}

/// Millimetres; NaN on the medial wall.
fn thickness_at(d: DVec3, seed: u32) -> f64 {
    let p = hull(d);
    let across = (p.y / 0.2) * (p.y / 0.2) + (p.z / 0.36) * (p.z / 0.36);
    if d.x < 0.0 && across < 1.0 {
        return f64::NAN;
    }
    let wide = gradient_3d((p * 1.7).as_vec3(), Lattice::seeded(seed ^ 0x51)).value as f64;
    3.1 - 1.1 * sulcus(d, seed) + 0.9 * wide
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::topology::Topology;

    #[test]
    fn it_is_closed_and_lacks_values_on_its_inner_side_alone() {
        let scene = scene(48, 1);
        let mesh = &scene.mesh;
        assert_eq!(Topology::of(mesh).n_border_edges, 0);
        let values = &mesh.fields()[0].values;
        let missing: Vec<usize> = (0..values.len()).filter(|i| values.at(*i).is_nan()).collect();
        assert!(missing.len() > 100 && missing.len() * 5 < values.len());
        assert!(missing.iter().all(|i| mesh.positions()[*i].x < 12.0));
        assert!((0..values.len()).map(|i| values.at(i)).filter(|x| !x.is_nan()).all(|x| (1.0..=4.6).contains(&x)));
    }
}
