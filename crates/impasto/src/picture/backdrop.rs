//! The surroundings behind everything, along each pixel's line of sight: sharp as their picture, or blurred.

use crate::assets::{Image, TextureImage};
use crate::color::{LinearRgb, LinearRgba};
use crate::math::{Vec3, acos, atan2, log2};
use crate::par::Workers;
use crate::picture::environment::{Unfolded, cube_face, halved, linear, mixed_four, within};
use crate::visibility::Domain;
use std::f32::consts::PI;

/// What is seen where nothing else is.
#[derive(Clone, Debug)]
pub struct Backdrop {
    source: Source,
}

#[derive(Clone, Debug)]
enum Source {
    /// Longitude and latitude, from the whole picture to a few texels.
    Panorama(Vec<Image<[f32; 4]>>),
    /// Six faces, from whole pictures to one texel each.
    Cube(Vec<[Image<[f32; 4]>; 6]>),
    /// Seen through a lobe.
    Blurred(Unfolded),
}

impl Backdrop {
    /// An equirectangular panorama: row 0 is straight up, the middle is at -Z, +X lies to the right of it. `blur` goes from
    /// 0, sharp, to 1, a wash of light.
    pub fn of_panorama(image: &TextureImage, blur: f32, workers: &Workers) -> Self {
        let mut levels = vec![linear(image)];
        while levels[levels.len() - 1].size.height >= 8 && levels[levels.len() - 1].size.width >= 8 {
            levels.push(halved(&levels[levels.len() - 1]));
        }
        Self { source: Source::Panorama(levels) }.blurred(blur, workers)
    }

    /// Six faces in the order +X -X +Y -Y +Z -Z, oriented as in OpenGL.
    pub fn of_cube(faces: &[TextureImage; 6], blur: f32, workers: &Workers) -> Self {
        let mut levels = vec![faces.each_ref().map(linear)];
        while levels[levels.len() - 1][0].size.width >= 2 {
            levels.push(levels[levels.len() - 1].each_ref().map(halved));
        }
        Self { source: Source::Cube(levels) }.blurred(blur, workers)
    }

    fn blurred(self, blur: f32, workers: &Workers) -> Self {
        match blur > 0.0 {
            true => Self { source: Source::Blurred(Unfolded::blurred(|d| self.at(d, 0.0), blur, workers)) },
            false => self,
        }
    }

    /// Linear light from a unit direction, over a pixel that is `width` radians wide.
    pub fn at(&self, toward: Vec3, width: f32) -> LinearRgb {
        match &self.source {
            Source::Blurred(sphere) => sphere.toward(toward),
            Source::Panorama(levels) => {
                let u = 0.5 + atan2(toward.x, -toward.z) * (0.5 / PI);
                let v = acos(toward.y.clamp(-1.0, 1.0)) * (1.0 / PI);
                let texel = 2.0 * PI / levels[0].size.width as f32;
                between(levels, width / texel, |image| around(image, u, v))
            }
            Source::Cube(levels) => {
                let (face, [u, v]) = cube_face(toward);
                // The middle of a face, where texels look widest.
                let texel = 2.0 / levels[0][0].size.width as f32;
                between(levels, width / texel, |faces| within(&faces[face], u, v))
            }
        }
    }

    /// Fills what a run of cells lets through, given from their first column and row: premultiplied light, alpha 1 after.
    pub fn fill(&self, domain: &Domain, [column, row]: [u32; 2], cells: &mut [LinearRgba]) {
        let [corner, right, down] = domain.sight;
        for (i, cell) in cells.iter_mut().enumerate().filter(|(_, cell)| cell[3] < 1.0) {
            let sight = corner + right * (column as f32 + i as f32 + 0.5) + down * (row as f32 + 0.5);
            let per_length = 1.0 / sight.length_squared().max(f32::MIN_POSITIVE).sqrt();
            let behind = self.at(sight * per_length, right.length_squared().sqrt() * per_length);
            let through = 1.0 - cell[3];
            (0..3).for_each(|c| cell[c] += through * behind[c]);
            cell[3] = 1.0;
        }
    }
}

/// Between the two levels whose texels are about as wide as a pixel of `n_texels` of the whole picture.
fn between<T>(levels: &[T], n_texels: f32, read: impl Fn(&T) -> LinearRgb) -> LinearRgb {
    let last = levels.len() - 1;
    let level = if n_texels > 1.0 { log2(n_texels).min(last as f32) } else { 0.0 };
    let low = (level as usize).min(last);
    let a = read(&levels[low]);
    if level == low as f32 {
        return a;
    }
    let (b, t) = (read(&levels[(low + 1).min(last)]), level - low as f32);
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
}

/// Four texels of a panorama, which goes on over its sides.
fn around(image: &Image<[f32; 4]>, u: f32, v: f32) -> LinearRgb {
    let (width, height) = (image.size.width as i64, image.size.height as i64);
    let (x, y) = (u as f64 * width as f64 - 0.5, v as f64 * height as f64 - 0.5);
    let (i, j) = (x.floor(), y.floor());
    let texel = |dx: i64, dy: i64| {
        image.at((i as i64 + dx).rem_euclid(width) as u32, (j as i64 + dy).clamp(0, height - 1) as u32)
    };
    mixed_four([texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)], (x - i) as f32, (y - j) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::Mesh;
    use crate::math::{Projection, Size, vec3};
    use crate::picture::ambient::spiral;
    use crate::samples::texture::environment::{sky_cube, sky_map};
    use crate::visibility::Camera;

    #[test]
    fn panorama_and_cube_show_the_same_sky_in_the_same_place() {
        let workers = Workers::new(1);
        let panorama = Backdrop::of_panorama(&sky_map(Size::new(512, 256)), 0.0, &workers);
        let cube = Backdrop::of_cube(&sky_cube(128), 0.0, &workers);
        let differs = |d: &Vec3| {
            let (a, b) = (panorama.at(*d, 0.0), cube.at(*d, 0.0));
            (0..3).any(|c| (a[c] - b[c]).abs() > 0.1 * (1.0 + a[c]))
        };
        // Edges of softboxes and of the sun may differ by a texel.
        let n = spiral(1000).filter(differs).count();
        assert!(n < 20, "{n} of 1000 directions differ");
        // A wide pixel sees a mean, and a blur of 1 hardly any difference between two neighbouring directions.
        let wash = Backdrop::of_panorama(&sky_map(Size::new(512, 256)), 1.0, &workers);
        let (a, b) = (wash.at(vec3(0.0, 0.0, -1.0), 0.0), wash.at(vec3(0.0998, 0.0, -0.995), 0.0));
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 0.1), "{a:?} {b:?}");
    }

    #[test]
    fn cells_get_what_they_let_through() {
        let workers = Workers::new(1);
        let backdrop = Backdrop::of_panorama(&sky_map(Size::new(64, 32)), 0.0, &workers);
        let projection = Projection::Perspective { fov_y: 0.6 };
        let camera = Camera::looking(Vec3::ZERO, vec3(0.3, 0.2, -1.0), Vec3::Y, projection, 0.1);
        let mesh = Mesh::default();
        let domain = Domain::through_camera(&mesh, &camera, Size::new(9, 9));
        let mut cells = [[0.0, 0.0, 0.0, 0.0], [0.2, 0.3, 0.4, 1.0], [0.1, 0.1, 0.1, 0.5]];
        backdrop.fill(&domain, [3, 4], &mut cells);
        let middle = (vec3(0.3, 0.2, -1.0)).normalize();
        let half = backdrop.at(middle, 0.05);
        assert_eq!((cells[1], cells[0][3], cells[2][3]), ([0.2, 0.3, 0.4, 1.0], 1.0, 1.0));
        assert!((0..3).all(|c| (cells[0][c] - half[c]).abs() < 0.1), "{cells:?} {half:?}");
        assert!((0..3).all(|c| (cells[2][c] - 0.1 - 0.5 * half[c]).abs() < 0.1), "{cells:?} {half:?}");
    }
}
