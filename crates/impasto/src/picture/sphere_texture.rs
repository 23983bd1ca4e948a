//! A ball, lit once and well, as a texture: Phong's quality at the price of a look-up, and what it costs in truth.
//!
//! After Teschner and Henn, "Texture Mapping in Technical, Scientific and Engineering Visualization", 1994: where light and
//! eye are far away, the light of a surface depends on its normal alone; so a sphere that was shaded well is a table of it,
//! and the normal is the coordinate ([`Placement::ViewNormal`](crate::placement::Placement::ViewNormal)). For comparison:
//! light worked out at the vertices, after Gouraud, "Continuous Shading of Curved Surfaces", 1971.

use crate::assets::{Image, Mesh, Texels, TextureImage};
use crate::color::{Encoding, LinearRgb};
use crate::lookup::{Shading, Surfaces};
use crate::math::{BATCH, Lane, Mat3, Size, Vec3, Vec4, unit_or, vec3};
use crate::picture::{self, Lighting};
use crate::placement::{Surfels, Viewpoint};

/// What is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// How light and surface meet.
    pub shading: Shading,
    /// Linear.
    pub color: LinearRgb,
    /// Of metal-roughness shading.
    pub roughness: f32,
    /// Of metal-roughness shading.
    pub metalness: f32,
}

/// A unit sphere seen from far away, as float texels in linear light: its normals fill the picture's disc. Lights turn with
/// the eye as they stand in `view`; those with a place shine as onto the point `view` looks from. Beside the disc the rim
/// goes on, so that filters find nothing foreign.
pub fn sphere_texture(lighting: &Lighting, view: &Viewpoint, material: &Material, size: Size) -> TextureImage {
    let size = Size::new(size.width.max(1), size.height.max(1));
    let world_from_eye = Mat3::from_mat4(view.eye_from_world).transpose();
    let normal = |i: usize| {
        let (x, y) = (i as u32 % size.width, i as u32 / size.width);
        let place = |t: u32, n: u32| (t as f32 + 0.5) / n as f32 * 2.0 - 1.0;
        let (mut x, mut y) = (place(x, size.width), -place(y, size.height));
        let squared = x * x + y * y;
        if squared > 1.0 {
            let inward = 1.0 / squared.sqrt();
            (x, y) = (x * inward, y * inward);
        }
        unit_or(world_from_eye * vec3(x, y, (1.0 - x * x - y * y).max(0.0).sqrt()), Vec3::Z)
    };
    let points: Vec<Lit> = (0..size.n_cells())
        .map(|i| Lit { position: Vec3::ZERO, normal: normal(i), toward_eye: world_from_eye * Vec3::Z })
        .collect();
    let texels = lit(lighting, material, &points).into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect();
    TextureImage {
        name: "lights".into(),
        texels: Texels::F32(Image { size, texels }),
        encoding: Encoding::Linear,
        n_channels: 3,
    }
}

/// The light of each vertex as a colour, for [`Shading::Unlit`]: what is between the vertices is interpolated.
pub fn gouraud(mesh: &Mesh, lighting: &Lighting, view: &Viewpoint, material: &Material) -> Vec<Vec4> {
    let point = |(position, normal): (&Vec3, &Vec3)| Lit {
        position: *position,
        normal: *normal,
        toward_eye: view.parallel.unwrap_or_else(|| unit_or(view.eye - *position, Vec3::Z)),
    };
    let points: Vec<Lit> = mesh.positions().iter().zip(mesh.normals()).map(point).collect();
    lit(lighting, material, &points).into_iter().map(|[r, g, b]| Vec4::new(r, g, b, 1.0)).collect()
}

/// A point that waits for light; world space.
struct Lit {
    position: Vec3,
    normal: Vec3,
    toward_eye: Vec3,
}

fn lit(lighting: &Lighting, material: &Material, points: &[Lit]) -> Vec<LinearRgb> {
    let mut surfels = Surfels::new(0);
    let mut surfaces = Surfaces::new();
    surfaces.occlusion = [1.0; BATCH];
    surfaces.alpha = [1.0; BATCH];
    surfaces.roughness = [material.roughness; BATCH];
    surfaces.metalness = [material.metalness; BATCH];
    surfaces.color = material.color.map(|c| [c; BATCH]);
    let mut light: Box<[Lane; 3]> = Box::new([[0.0; BATCH]; 3]);
    let mut out = Vec::with_capacity(points.len());
    for batch in points.chunks(BATCH) {
        (surfels.n, surfaces.n) = (batch.len(), batch.len());
        for (i, p) in batch.iter().enumerate() {
            for k in 0..3 {
                surfels.position[k][i] = p.position[k];
                surfels.view[k][i] = p.toward_eye[k];
                surfaces.normal[k][i] = p.normal[k];
                surfaces.coat_normal[k][i] = p.normal[k];
            }
        }
        // The same bits at every level; this is no inner loop.
        fearless_simd::dispatch!(fearless_simd::Level::baseline(), simd => {
            picture::shade(simd, material.shading, lighting, &surfels, &surfaces, &mut light);
        });
        out.extend((0..batch.len()).map(|i| [light[0][i], light[1][i], light[2][i]]));
    }
    out
}

/// How far a picture is from the true one, in steps of 8 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Over all channels of the pixels compared.
    pub mean: f64,
    /// The largest of any channel.
    pub max: u8,
    /// How many pixels were compared.
    pub n_pixels: usize,
}

/// Compares two pictures of one view where `is_meant` says so (none: everywhere), red, green and blue alike.
pub fn difference(truth: &[[u8; 4]], other: &[[u8; 4]], is_meant: Option<&[bool]>) -> Difference {
    assert_eq!(truth.len(), other.len(), "two pictures of one size");
    let (mut sum, mut max, mut n) = (0u64, 0, 0);
    for (i, (a, b)) in truth.iter().zip(other).enumerate() {
        if is_meant.is_none_or(|m| m[i]) {
            n += 1;
            for c in 0..3 {
                let step = a[c].abs_diff(b[c]);
                sum += step as u64;
                max = step.max(max);
            }
        }
    }
    Difference { mean: sum as f64 / (3 * n).max(1) as f64, max, n_pixels: n }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat4;
    use crate::picture::Light;

    const VIEW: Viewpoint = Viewpoint { eye_from_world: Mat4::IDENTITY, eye: Vec3::ZERO, parallel: Some(Vec3::Z) };

    fn two_lights() -> Lighting {
        let lights = vec![Light::directional(vec3(-0.4, 0.6, 0.7), 0.8), Light::directional(vec3(0.9, -0.1, 0.3), 0.2)];
        Lighting { lights, ..Lighting::flat(0.15) }
    }

    const PHONG: Material = Material {
        shading: Shading::BlinnPhong { specular: 0.5, exponent: 40.0 },
        color: [0.5, 0.3, 0.2],
        roughness: 0.5,
        metalness: 0.0,
    };

    #[test]
    fn the_ball_is_lit_as_its_normals_are() {
        let image = sphere_texture(&two_lights(), &VIEW, &PHONG, Size::new(64, 64));
        let Texels::F32(texels) = &image.texels else { panic!("float texels") };
        // By the textbook, at the place that looks at the first light.
        let l = unit_or(vec3(-0.4, 0.6, 0.7), Vec3::Z);
        let place = |t: f32| ((t * 0.5 + 0.5) * 64.0) as u32;
        let (x, y) = (place(l.x), place(-l.y));
        let n = {
            let (a, b) = ((x as f32 + 0.5) / 32.0 - 1.0, 1.0 - (y as f32 + 0.5) / 32.0);
            vec3(a, b, (1.0 - a * a - b * b).sqrt())
        };
        let m = unit_or(vec3(0.9, -0.1, 0.3), Vec3::Z);
        let highlight = |l: Vec3| {
            let h = unit_or(l + Vec3::Z, Vec3::Z);
            crate::math::exact::pow(n.dot(h).max(0.0) as f64, 40.0) as f32
        };
        let matte = 0.15 + 0.8 * n.dot(l).max(0.0) + 0.2 * n.dot(m).max(0.0);
        let wanted = 0.5 * matte + 0.5 * (0.8 * highlight(l) + 0.2 * highlight(m));
        assert!((texels.at(x, y)[0] - wanted).abs() < 1e-3, "{} not {wanted}", texels.at(x, y)[0]);
        assert!(texels.texels.iter().flatten().all(|c| c.is_finite()));
    }

    #[test]
    fn vertices_get_the_light_of_their_normals() {
        let mesh = crate::samples::scene("icosphere", 8, 1).expect("a sample").mesh;
        let colors = gouraud(&mesh, &two_lights(), &VIEW, &PHONG);
        assert_eq!(colors.len(), mesh.positions().len());
        let brightest = (0..colors.len()).max_by(|a, b| colors[*a].x.total_cmp(&colors[*b].x)).expect("vertices");
        let half = unit_or(unit_or(vec3(-0.4, 0.6, 0.7), Vec3::Z) + Vec3::Z, Vec3::Z);
        assert!(mesh.normals()[brightest].dot(half) > 0.9);
    }

    #[test]
    fn differences_are_counted_where_meant() {
        let (a, b) = ([[10, 20, 30, 255], [0; 4]], [[13, 20, 30, 255], [90, 0, 0, 0]]);
        let only = difference(&a, &b, Some(&[true, false]));
        assert_eq!((only.mean, only.max, only.n_pixels), (1.0, 3, 1));
        assert_eq!(difference(&a, &b, None).max, 90);
    }
}
