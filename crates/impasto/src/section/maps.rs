//! Maps of a cap: what the section shows, texel by texel, laid out in its own coordinates.
//!
//! A texel holds what [`Grain::eval`](super::grain::Grain::eval) and its kin say of the place under its middle. Height,
//! normal, openness and particle make images of their own; colour and roughness are whatever the caller makes of a hit.

use crate::assets::{Image, Texels, TextureImage, UvTransform, image_write};
use crate::color::{Encoding, LinearRgb, srgb8_from_linear, unorm8};
use crate::error::{Error, Result};
use crate::math::{Size, Vec2, Vec3, vec2};
use crate::par::Workers;
use crate::section::grain::Hit;

/// Which part of a section is laid out, and how finely. Rows go from the greatest v to the least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Coordinates of the section at the lower left corner, model units.
    pub min: Vec2,
    /// At the upper right corner.
    pub max: Vec2,
    /// Texels across and down; as good as square.
    pub size: Size,
}

/// What a map holds of a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texel {
    /// Above the section, model units.
    pub height: f32,
    /// Unit normal along +u, +v and out of the section, in 32767ths.
    pub normal: [i16; 3],
    /// The part of a uniform sky that it sees, in 65535ths.
    pub openness: u16,
    /// The particle there, or [`Hit::MATRIX`].
    pub particle: u32,
    /// Red, green and blue as sRGB bytes.
    pub color: [u8; 3],
    /// In 255ths.
    pub roughness: u8,
}

/// What a section shows, texel by texel.
#[derive(Clone, Debug)]
pub struct CapMaps {
    /// Where the texels lie.
    pub layout: Layout,
    /// Rows from the top.
    pub texels: Image<Texel>,
}

/// Maps are at most this long.
pub const MOST_TEXELS: u32 = 8192;

impl Layout {
    /// Around coordinates, with so many texels along the longer side, and a texel to spare at each border.
    ///
    /// # Errors
    /// Less than 4 texels, or more than [`MOST_TEXELS`].
    pub fn around(min: Vec2, max: Vec2, n_longer: u32) -> Result<Self> {
        if !(4..=MOST_TEXELS).contains(&n_longer) {
            let why = format!("4 to {MOST_TEXELS} texels along the longer side");
            return Err(Error::Parameter { what: "maps".into(), given: n_longer.to_string(), why });
        }
        let extent = (max - min).max(Vec2::splat(f32::MIN_POSITIVE));
        let pitch = extent.max_element() / (n_longer - 2) as f32;
        let n = |length: f32| ((length / pitch).ceil() as u32 + 2).clamp(4, n_longer);
        let size = Size::new(n(extent.x), n(extent.y));
        let half = vec2(size.width as f32, size.height as f32) * (0.5 * pitch);
        let middle = (min + max) * 0.5;
        Ok(Self { min: middle - half, max: middle + half, size })
    }

    /// The coordinates under a texel's middle.
    pub fn at(&self, x: u32, y: u32) -> Vec2 {
        let share = vec2(
            (x as f32 + 0.5) / self.size.width as f32,
            ((self.size.height - y) as f32 - 0.5) / self.size.height as f32,
        );
        self.min + (self.max - self.min) * share
    }

    /// From coordinates of the section to those of a texture, 0 to 1 with t down.
    pub fn uv_transform(&self) -> UvTransform {
        let scale = vec2(1.0, 1.0) / (self.max - self.min);
        UvTransform {
            matrix: [[scale.x, 0.0], [0.0, -scale.y]],
            offset: [-self.min.x * scale.x, 1.0 + self.min.y * scale.y],
        }
    }
}

impl CapMaps {
    /// Looks at every texel, row by row: `hits` tells what is at some places of one v and many u, with normals along +u, +v
    /// and out of the section; `dress` the colour of a hit in linear light, and its roughness. A texel is the mean of
    /// `n_places` x `n_places` places in it; height and particle are those of one of them.
    pub fn bake(
        layout: Layout,
        n_places: u32,
        workers: &Workers,
        hits: &(dyn Fn(&[f32], f32) -> Vec<Hit> + Sync),
        dress: &(dyn Fn(&Hit) -> (LinearRgb, f32) + Sync),
    ) -> Self {
        let (Size { width, height }, n) = (layout.size, n_places.max(1));
        let fine = Layout { size: Size::new(width * n, height * n), ..layout };
        let across: Vec<f32> = (0..width * n).map(|x| fine.at(x, 0).x).collect();
        let rows = workers.map(height as usize, |y| {
            let mut means = vec![Mean::default(); width as usize];
            for k in 0..n {
                let row = hits(&across, fine.at(0, y as u32 * n + k).y);
                for (mean, hits) in means.iter_mut().zip(row.chunks(n as usize)) {
                    hits.iter().for_each(|hit| mean.add(hit, dress(hit)));
                }
            }
            means.into_iter().map(|mean| mean.texel((n * n) as f32)).collect::<Vec<_>>()
        });
        Self { layout, texels: Image { size: layout.size, texels: rows.concat() } }
    }

    /// Base colour.
    pub fn color(&self, name: &str) -> TextureImage {
        let texels = Texels::U8(self.image(|t| [t.color[0], t.color[1], t.color[2], 255]));
        TextureImage { name: name.into(), texels, encoding: Encoding::Srgb, n_channels: 3 }
    }

    /// Tangent-space normals, green upward; the tangent is +u.
    pub fn normals(&self, name: &str) -> TextureImage {
        let byte = |c: i16| unorm8(c as f32 / 65534.0 + 0.5);
        let texels = Texels::U8(self.image(|t| [byte(t.normal[0]), byte(t.normal[1]), byte(t.normal[2]), 255]));
        TextureImage { name: name.into(), texels, encoding: Encoding::Linear, n_channels: 3 }
    }

    /// Red: openness, as ambient occlusion; green: roughness; blue: metalness, none.
    pub fn openness_and_roughness(&self, name: &str) -> TextureImage {
        let texels = Texels::U8(self.image(|t| [(t.openness >> 8) as u8, t.roughness, 0, 255]));
        TextureImage { name: name.into(), texels, encoding: Encoding::Linear, n_channels: 3 }
    }

    /// Heights in 16 bits, and the model units of 0 and of 65535: the least and the greatest height, the section's own
    /// height 0 between them.
    pub fn heights(&self) -> (Image<u16>, [f32; 2]) {
        let all = self.texels.texels.iter().map(|t| t.height);
        let [low, high] = all.fold([0.0f32, 0.0], |[low, high], h| [low.min(h), high.max(h)]);
        let scale = 65535.0 / (high - low).max(f32::MIN_POSITIVE);
        (self.image(|t| ((t.height - low) * scale + 0.5) as u16), [low, high])
    }

    /// Openness in 16 bits.
    pub fn openness(&self) -> Image<u16> {
        self.image(|t| t.openness)
    }

    /// Particles, numbered from 1 in the order in which rows show them; 0 is what is between them. How many there are; the
    /// numbers start over after 65535.
    pub fn particles(&self) -> (Image<u16>, usize) {
        let mut numbers = std::collections::HashMap::new();
        let image = self.image(|t| match t.particle {
            Hit::MATRIX => 0,
            particle => {
                let next = numbers.len();
                (*numbers.entry(particle).or_insert(next) % 65535) as u16 + 1
            }
        });
        (image, numbers.len())
    }

    fn image<T>(&self, texel: impl FnMut(&Texel) -> T) -> Image<T> {
        Image { size: self.layout.size, texels: self.texels.texels.iter().map(texel).collect() }
    }
}

impl CapMaps {
    /// All maps as PNG files: what they are, and their bytes.
    pub fn files(&self) -> [(&'static str, Vec<u8>); 5] {
        let size = self.layout.size;
        let rgb = |image: TextureImage| {
            let Texels::U8(texels) = image.texels else { unreachable!("maps have 8 bits") };
            let bytes: Vec<u8> = texels.texels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
            image_write::png8(size, &bytes, image.encoding, &[])
        };
        let grey = |image: Image<u16>, told: &[(&str, String)]| {
            image_write::png16(size, &image.texels, Encoding::Linear, told)
        };
        let (heights, [low, high]) = self.heights();
        let (particles, n) = self.particles();
        [
            ("color", rgb(self.color(""))),
            ("normal", rgb(self.normals(""))),
            ("height", grey(heights, &[("Heights", format!("0 is {low}, 65535 is {high} model units"))])),
            ("openness", grey(self.openness(), &[])),
            ("particles", grey(particles, &[("Particles", format!("{n}, counted from 1; 0 is between them"))])),
        ]
    }
}

/// What the places of a texel have in sum.
#[derive(Clone, Copy, Default)]
struct Mean {
    color: Vec3,
    normal: Vec3,
    openness: f32,
    roughness: f32,
    height: f32,
    particle: u32,
}

impl Mean {
    fn add(&mut self, hit: &Hit, (color, roughness): (LinearRgb, f32)) {
        self.color += Vec3::from_array(color);
        self.normal += hit.normal;
        self.openness += hit.openness.clamp(0.0, 1.0);
        self.roughness += roughness;
        (self.height, self.particle) = (hit.height, hit.particle);
    }

    fn texel(self, n: f32) -> Texel {
        let normal = self.normal.normalize_or(Vec3::Z);
        Texel {
            height: self.height,
            normal: normal.to_array().map(|c| (c.clamp(-1.0, 1.0) * 32767.0).round() as i16),
            openness: (self.openness / n * 65535.0 + 0.5) as u16,
            particle: self.particle,
            color: (self.color / n).to_array().map(srgb8_from_linear),
            roughness: unorm8(self.roughness / n),
        }
    }
}

/// A direction along the model's axes as +u, +v and out of a section.
pub fn in_section(direction: Vec3, axes: [Vec3; 3]) -> Vec3 {
    Vec3::from_array(axes.map(|a| a.dot(direction)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;
    use crate::section::grain::HitKind;

    fn maps() -> CapMaps {
        let layout = Layout::around(vec2(-2.0, 1.0), vec2(2.0, 3.0), 34).unwrap();
        let hit = |at: Vec2| {
            let is_in = (at - vec2(1.0, 2.5)).length() < 0.4;
            Hit {
                height: if is_in { at.y } else { -0.5 },
                normal: vec3(0.0, 0.6, 0.8),
                kind: if is_in { HitKind::Bump } else { HitKind::Matrix },
                particle: if is_in { 77 } else { Hit::MATRIX },
                openness: 0.5,
                ..Hit::matrix(Vec3::Z, 0.0)
            }
        };
        let row = |xs: &[f32], y: f32| xs.iter().map(|&x| hit(vec2(x, y))).collect();
        CapMaps::bake(layout, 1, &Workers::new(2), &row, &|h| ([1.0, 0.0, h.openness], 0.25))
    }

    #[test]
    fn texels_lie_where_the_layout_says_and_textures_find_them() {
        let maps = maps();
        let layout = maps.layout;
        assert_eq!(layout.size, Size::new(34, 18));
        for (x, y) in [(0, 0), (33, 17), (20, 4)] {
            let at = layout.at(x, y);
            let UvTransform { matrix, offset } = layout.uv_transform();
            let st = vec2(matrix[0][0] * at.x + offset[0], matrix[1][1] * at.y + offset[1]);
            let cell = vec2(st.x * 34.0 - 0.5, st.y * 18.0 - 0.5);
            assert!((cell - vec2(x as f32, y as f32)).length() < 1e-4, "{cell}");
        }
        assert!(layout.at(20, 0).y > layout.at(20, 1).y && layout.at(1, 3).x > layout.at(0, 3).x);
        assert!(Layout::around(Vec2::ZERO, Vec2::ONE, 3).is_err());
        assert!(Layout::around(Vec2::ZERO, Vec2::ONE, MOST_TEXELS + 1).is_err());
    }

    #[test]
    fn images_hold_what_hits_say() {
        let maps = maps();
        let (x, y) = (25, 5);
        let (heights, [low, high]) = maps.heights();
        assert!(low == -0.5 && high > 2.5 && high < 3.0);
        let height = low + (high - low) * *heights.at(x, y) as f32 / 65535.0;
        assert!((height - maps.layout.at(x, y).y).abs() < 1e-4);
        let (particles, n) = maps.particles();
        assert_eq!((*particles.at(x, y), *particles.at(0, 0), n), (1, 0, 1));
        assert_eq!(*maps.openness().at(0, 0), 32768);
        let Texels::U8(normals) = maps.normals("n").texels else { panic!("bytes") };
        assert_eq!(*normals.at(3, 3), [128, 204, 230, 255]);
        let Texels::U8(colors) = maps.color("c").texels else { panic!("bytes") };
        assert_eq!(*colors.at(3, 3), [255, 0, 188, 255]);
        let Texels::U8(both) = maps.openness_and_roughness("o").texels else { panic!("bytes") };
        assert_eq!(*both.at(3, 3), [128, 64, 0, 255]);
    }
}
