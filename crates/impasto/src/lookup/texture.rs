//! Image textures prepared for reading: every mip level in one slice, rows padded so that two neighbours are one load.
//!
//! A level of w x h texels is stored as h + 1 rows of w + 1 texels; the extra texel repeats the first one of its row where
//! the coordinate repeats, and the last one elsewhere, the extra row likewise. Wrapping thus happens once, on the
//! coordinate, and never between the texels of one look-up. A face of a cube has one texel more on all four sides, taken
//! from its neighbours, so that no seam shows.

use crate::assets::{Image, MinFilter, Sampler, Texels, TextureImage, Wrap};
use crate::color::{Encoding, linear_from_srgb};
use crate::error::{Error, Result};
use crate::lookup::mip::{self, Grid};
use crate::math::{Size, unit_or, vec3};

/// An image, prepared to be read in one way.
#[derive(Clone, Debug)]
pub struct ImageTexture {
    /// For messages: the image's name.
    pub name: String,
    pub(super) sampler: Sampler,
    pub(super) format: BaseFormat,
    pub(super) shape: Shape,
    pub(super) store: Store,
    /// From the full image to one texel, or the full image alone where the sampler needs no more.
    pub(super) levels: Vec<Level>,
}

/// Which components a texture means to have: OpenGL's base internal formats. Operators depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BaseFormat {
    /// Opacity alone.
    Alpha,
    /// Grey.
    Luminance,
    /// Grey and opacity.
    LuminanceAlpha,
    /// One number for grey and opacity.
    Intensity,
    /// Colour.
    Rgb,
    /// Colour and opacity.
    Rgba,
}

/// What the texels mean: decides how they are decoded, and how levels are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Usage {
    /// Light: levels are averages of linear light, in sRGB images with alpha weighted by it, so that the hidden colour of
    /// transparent texels does not bleed. Images with the linear encoding get the plain average of their numbers.
    Color,
    /// Any numbers: taken as they are, levels are plain averages.
    Data,
    /// Tangent-space normals. Kept in 16 bits; levels are averages that are not made unit again, and alpha holds the
    /// average's length, 1 at the full image: what is missing widens the roughness (Toksvig, "Mipmapping normal maps", 2005).
    Normal,
    /// Grey heights, kept as slopes: red and green are the change of height to the right and down, in texture widths over
    /// texture widths; blue is the mean of their squares' sum, whose excess over the squared means is the roughness that
    /// a level hides (Olano, Baker, "LEAN mapping", 2010); alpha is the height.
    Slope,
    /// Names of things: a level's texel is the most frequent of its four, the first among equals. Read it by nearest filters.
    Label,
}

/// How an image is to be prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prepare {
    /// What the texels mean.
    pub usage: Usage,
    /// How it will be read.
    pub sampler: Sampler,
    /// None: by the image's number of channels (luminance, luminance and alpha, RGB, RGBA). A single number is taken from
    /// red, or from alpha if there is one and [`BaseFormat::Alpha`] is asked for.
    pub format: Option<BaseFormat>,
    /// Keep float texels in 16 bits (half the memory, 11 significant bits, at most 65504).
    pub half: bool,
}

impl Prepare {
    /// For that usage and sampler, with the image's own format, floats kept whole.
    pub fn new(usage: Usage, sampler: Sampler) -> Self {
        Self { usage, sampler, format: None, half: false }
    }
}

/// How many coordinates address a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// s: an image of one row.
    Line,
    /// s and t.
    Plane,
    /// s, t and r.
    Volume,
    /// A direction (s, t, r); six faces in the order +X, -X, +Y, -Y, +Z, -Z, oriented as in OpenGL.
    Cube,
}

/// Texels of all levels.
#[derive(Clone, Debug)]
pub(super) enum Store {
    Srgb8(Vec<[u8; 4]>),
    Unorm8(Vec<[u8; 4]>),
    Unorm16(Vec<[u16; 4]>),
    Half(Vec<[u16; 4]>),
    Float(Vec<[f32; 4]>),
}

/// Where one level lies in the store.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    /// Index of the texel (0, 0, 0).
    pub(super) offset: usize,
    /// Texels across, down and deep; of a cube: of a face, and 1.
    pub(super) size: [u32; 3],
    /// From a texel to the one below.
    pub(super) row: usize,
    /// From a texel to the one behind; of a cube: to the same texel of the next face.
    pub(super) slice: usize,
}

impl ImageTexture {
    /// A picture; one of a single row becomes a line, addressed by s alone.
    pub fn new(image: &TextureImage, how: &Prepare) -> Self {
        let shape = if image.texels.size().height == 1 { Shape::Line } else { Shape::Plane };
        Self::stacked(&[image], shape, how)
    }

    /// A solid from its slices, front (r = 0) to back. Errors when there is none or sizes differ.
    pub fn volume(slices: &[TextureImage], how: &Prepare) -> Result<Self> {
        check_sizes("volume texture", slices, 1, false)?;
        Ok(Self::stacked(&slices.iter().collect::<Vec<_>>(), Shape::Volume, how))
    }

    /// Six faces in the order +X, -X, +Y, -Y, +Z, -Z. Errors when they are not equal squares.
    pub fn cube(faces: &[TextureImage], how: &Prepare) -> Result<Self> {
        check_sizes("cube texture", faces, 6, true)?;
        Ok(Self::stacked(&faces.iter().collect::<Vec<_>>(), Shape::Cube, how))
    }

    /// Which components it means to have.
    pub fn format(&self) -> BaseFormat {
        self.format
    }

    /// How it is read.
    pub fn sampler(&self) -> &Sampler {
        &self.sampler
    }

    /// How many coordinates address a texel.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Texels across and down of the full image.
    pub fn size(&self) -> Size {
        Size::new(self.levels[0].size[0], self.levels[0].size[1])
    }

    /// How many levels there are.
    pub fn n_levels(&self) -> usize {
        self.levels.len()
    }

    /// Memory of the texels.
    pub fn n_bytes(&self) -> usize {
        match &self.store {
            Store::Srgb8(v) | Store::Unorm8(v) => v.len() * 4,
            Store::Unorm16(v) | Store::Half(v) => v.len() * 8,
            Store::Float(v) => v.len() * 16,
        }
    }

    fn stacked(images: &[&TextureImage], shape: Shape, how: &Prepare) -> Self {
        let first = images[0];
        let format = how.format.unwrap_or(match first.n_channels {
            1 => BaseFormat::Luminance,
            2 => BaseFormat::LuminanceAlpha,
            3 => BaseFormat::Rgb,
            _ => BaseFormat::Rgba,
        });
        let has_alpha = matches!(first.n_channels, 2 | 4);
        let sampler = how.sampler;
        let pack = Packing { shape, wrap: sampler.wrap, has_mips: has_mips(sampler.min) };
        let is_srgb = how.usage == Usage::Color && first.encoding == Encoding::Srgb;
        let texels = arranged(gathered(images), format, has_alpha, how.usage);
        let (store, levels) = match (how.usage, texels) {
            (Usage::Normal, texels) => pack.map(Store::Unorm16, normals(texels), mip::NORMAL),
            (Usage::Slope, texels) => pack.map(Store::Float, slopes(texels, sampler.wrap), mip::FLOAT),
            (Usage::Label, Stack::U8(grid)) => pack.map(Store::Unorm8, grid, mip::LABEL8),
            (Usage::Label, Stack::U16(grid)) => pack.map(Store::Unorm16, grid, mip::LABEL16),
            (Usage::Label, Stack::F32(grid)) => pack.map(Store::Float, grid, mip::LABEL32),
            (_, Stack::U8(grid)) if is_srgb && has_alpha => pack.map(Store::Srgb8, grid, mip::SRGB8_ALPHA),
            (_, Stack::U8(grid)) if is_srgb => pack.map(Store::Srgb8, grid, mip::SRGB8),
            (_, Stack::U8(grid)) => pack.map(Store::Unorm8, grid, mip::UNORM8),
            (_, Stack::U16(grid)) if is_srgb => pack.map(Store::Unorm16, decoded16(grid), mip::UNORM16),
            (_, Stack::U16(grid)) => pack.map(Store::Unorm16, grid, mip::UNORM16),
            (_, Stack::F32(grid)) if how.half => pack.map(Store::Half, grid.map(half_texel), mip::HALF),
            (_, Stack::F32(grid)) => pack.map(Store::Float, grid, mip::FLOAT),
        };
        Self { name: first.name.clone(), sampler, format, shape, store, levels }
    }
}

/// Whether a filter reads more than the full image.
pub(super) fn has_mips(min: MinFilter) -> bool {
    !matches!(min, MinFilter::Nearest | MinFilter::Linear)
}

fn check_sizes(what: &str, images: &[TextureImage], n: usize, square: bool) -> Result<()> {
    let fault = |why: String| {
        let given = images.first().map_or(String::new(), |i| i.name.clone());
        Err(Error::Parameter { what: what.into(), given, why })
    };
    let Some(first) = images.first().map(|i| i.texels.size()) else { return fault("it needs images".into()) };
    if n == 6 && images.len() != 6 {
        return fault(format!("it needs six images, not {}", images.len()));
    }
    if square && first.width != first.height {
        return fault(format!("its faces must be squares, not {first}"));
    }
    match images.iter().find(|i| i.texels.size() != first) {
        Some(odd) => fault(format!("{:?} is {} where the first is {first}", odd.name, odd.texels.size())),
        None => Ok(()),
    }
}

/// Texels of one or more equal images, one behind the other.
enum Stack {
    U8(Grid<[u8; 4]>),
    U16(Grid<[u16; 4]>),
    F32(Grid<[f32; 4]>),
}

fn gathered(images: &[&TextureImage]) -> Stack {
    let size = images[0].texels.size();
    // An image without texels is read as one black texel.
    if size.n_cells() == 0 {
        return Stack::U8(Grid { size: [1, 1, images.len()], texels: vec![[0; 4]; images.len()] });
    }
    let size = [size.width as usize, size.height as usize, images.len()];
    fn all<T: Copy>(images: &[&TextureImage], pick: impl Fn(&Texels) -> Option<&Image<T>>) -> Option<Vec<T>> {
        let parts: Option<Vec<_>> = images.iter().map(|i| pick(&i.texels).map(|p| p.texels.as_slice())).collect();
        parts.map(|p| p.concat())
    }
    if let Some(texels) = all(images, |t| if let Texels::U8(i) = t { Some(i) } else { None }) {
        return Stack::U8(Grid { size, texels });
    }
    if let Some(texels) = all(images, |t| if let Texels::U16(i) = t { Some(i) } else { None }) {
        return Stack::U16(Grid { size, texels });
    }
    let texels = images.iter().flat_map(|i| floats(&i.texels)).collect();
    Stack::F32(Grid { size, texels })
}

fn floats(texels: &Texels) -> Vec<[f32; 4]> {
    match texels {
        Texels::U8(i) => i.texels.iter().map(|t| t.map(|x| x as f32 / 255.0)).collect(),
        Texels::U16(i) => i.texels.iter().map(|t| t.map(|x| x as f32 / 65535.0)).collect(),
        Texels::F32(i) => i.texels.clone(),
    }
}

/// Moves the single number of one-component formats to where it is meant.
fn arranged(stack: Stack, format: BaseFormat, has_alpha: bool, usage: Usage) -> Stack {
    fn go<T: Copy>(grid: Grid<T4<T>>, zero: T, one: T, format: BaseFormat, has_alpha: bool) -> Grid<T4<T>> {
        match format {
            BaseFormat::Alpha if has_alpha => grid.map(|t| [zero, zero, zero, t[3]]),
            BaseFormat::Alpha => grid.map(|t| [zero, zero, zero, t[0]]),
            BaseFormat::Intensity => grid.map(|t| [t[0]; 4]),
            BaseFormat::Luminance => grid.map(|t| [t[0], t[0], t[0], one]),
            BaseFormat::LuminanceAlpha => grid.map(|t| [t[0], t[0], t[0], t[3]]),
            BaseFormat::Rgb => grid.map(|t| [t[0], t[1], t[2], one]),
            BaseFormat::Rgba => grid,
        }
    }
    if matches!(usage, Usage::Normal | Usage::Slope) {
        return stack;
    }
    match stack {
        Stack::U8(grid) => Stack::U8(go(grid, 0, 255, format, has_alpha)),
        Stack::U16(grid) => Stack::U16(go(grid, 0, 65535, format, has_alpha)),
        Stack::F32(grid) => Stack::F32(go(grid, 0.0, 1.0, format, has_alpha)),
    }
}

type T4<T> = [T; 4];

impl Stack {
    fn into_floats(self) -> Grid<[f32; 4]> {
        match self {
            Self::U8(grid) => grid.map(|t| t.map(|x| x as f32 / 255.0)),
            Self::U16(grid) => grid.map(|t| t.map(|x| x as f32 / 65535.0)),
            Self::F32(grid) => grid,
        }
    }
}

/// Unit normals in 16 bits, alpha full.
fn normals(stack: Stack) -> Grid<[u16; 4]> {
    stack.into_floats().map(|t| {
        let n = unit_or(vec3(t[0], t[1], t[2]) * 2.0 - 1.0, vec3(0.0, 0.0, 1.0));
        mip::normal_texel(n, 1.0)
    })
}

/// Heights in red to slopes by central differences, in texture widths over texture widths.
fn slopes(stack: Stack, wrap: [Wrap; 3]) -> Grid<[f32; 4]> {
    let grid = stack.into_floats();
    let [w, h, d] = grid.size;
    let neighbour = |i: usize, step: isize, n: usize, wrap: Wrap| -> usize {
        let j = i as isize + step;
        match wrap {
            Wrap::Repeat => j.rem_euclid(n as isize) as usize,
            _ => j.clamp(0, n as isize - 1) as usize,
        }
    };
    let height = |x: usize, y: usize, z: usize| grid.texels[(z * h + y) * w + x][0];
    // Half the distance between the two neighbours is one texel; a texel is 1/w of the texture's width both ways.
    let scale = 0.5 * w as f32;
    let texels = (0..d)
        .flat_map(|z| (0..h).flat_map(move |y| (0..w).map(move |x| (x, y, z))))
        .map(|(x, y, z)| {
            let at_x = |step| height(neighbour(x, step, w, wrap[0]), y, z);
            let at_y = |step| height(x, neighbour(y, step, h, wrap[1]), z);
            let slope = [(at_x(1) - at_x(-1)) * scale, (at_y(1) - at_y(-1)) * scale];
            [slope[0], slope[1], slope[0] * slope[0] + slope[1] * slope[1], height(x, y, z)]
        })
        .collect();
    Grid { size: [w, h, d], texels }
}

/// sRGB-coded 16 bits to linear 16 bits; alpha stays.
fn decoded16(grid: Grid<[u16; 4]>) -> Grid<[u16; 4]> {
    let table: Vec<u16> = (0..65536).map(|i| (linear_from_srgb(i as f64 / 65535.0) * 65535.0 + 0.5) as u16).collect();
    grid.map(|t| [table[t[0] as usize], table[t[1] as usize], table[t[2] as usize], t[3]])
}

fn half_texel(texel: [f32; 4]) -> [u16; 4] {
    texel.map(half_from_float)
}

/// The nearest half float, ties to even; NaN becomes 0, magnitudes saturate at 65504.
pub(super) fn half_from_float(x: f32) -> u16 {
    let magnitude = if x.abs() < 65504.0 {
        x.abs()
    } else if x.is_nan() {
        0.0
    } else {
        65504.0
    };
    let sign = (x.is_sign_negative() && !x.is_nan()) as u16;
    // 2^-14 is the least normal half; below it the spacing stays 2^-24.
    let bits = if magnitude < 6.103_515_6e-5 {
        // Adding 0.5 leaves the spacing 2^-24 in the sum, so that the addition itself rounds.
        (magnitude + 0.5).to_bits() - 0.5_f32.to_bits()
    } else {
        let bits = magnitude.to_bits();
        let rounded = bits + 0xfff + (bits >> 13 & 1);
        (rounded - (112 << 23)) >> 13
    };
    sign << 15 | bits as u16
}

/// A half float's value; every finite half is exact.
#[inline(always)]
pub(super) fn float_from_half(half: u16) -> f32 {
    // Exponents differ by 112; the product also makes normal numbers of subnormal ones.
    let magnitude = f32::from_bits(((half & 0x7fff) as u32) << 13) * f32::from_bits((127 + 112) << 23);
    f32::from_bits(magnitude.to_bits() | ((half & 0x8000) as u32) << 16)
}

/// How levels are laid out.
struct Packing {
    shape: Shape,
    wrap: [Wrap; 3],
    has_mips: bool,
}

impl Packing {
    /// Makes all levels from the full image and lays them out.
    fn map<T: Copy>(&self, store: impl Fn(Vec<T>) -> Store, base: Grid<T>, mean: mip::Means<T>) -> (Store, Vec<Level>) {
        let (mut texels, mut levels) = (Vec::new(), Vec::new());
        let mut grid = base;
        loop {
            levels.push(self.append(&grid, &mut texels));
            let has_next = grid.size[0] > 1 || grid.size[1] > 1 || (self.shape == Shape::Volume && grid.size[2] > 1);
            if !self.has_mips || !has_next {
                return (store(texels), levels);
            }
            grid = mip::halved(&grid, self.shape == Shape::Volume, mean);
        }
    }

    fn append<T: Copy>(&self, grid: &Grid<T>, texels: &mut Vec<T>) -> Level {
        let [w, h, d] = grid.size;
        let start = texels.len();
        if self.shape == Shape::Cube {
            let row = w + 2;
            texels.reserve(row * row * 6);
            for face in 0..6 {
                for y in 0..row {
                    texels.extend((0..row).map(|x| grid.texels[cube_source(face, [x, y], w)]));
                }
            }
            return Level { offset: start + row + 1, size: [w as u32, w as u32, 1], row, slice: row * row };
        }
        let (row, slice) = (w + 1, (w + 1) * (h + 1));
        let extra = |n: usize, axis: usize| if self.wrap[axis] == Wrap::Repeat { 0 } else { n - 1 };
        let n_slices = if self.shape == Shape::Volume { d + 1 } else { d };
        texels.reserve(slice * n_slices);
        for z in 0..n_slices {
            let z = if z < d { z } else { extra(d, 2) };
            for y in 0..=h {
                let y = if y < h { y } else { extra(h, 1) };
                let source = &grid.texels[(z * h + y) * w..][..w];
                texels.extend_from_slice(source);
                texels.push(source[extra(w, 0)]);
            }
        }
        Level { offset: start, size: [w as u32, h as u32, d as u32], row, slice }
    }
}

/// Which texel of six n x n faces belongs at a place of a face with one texel more on all sides.
fn cube_source(face: usize, place: [usize; 2], n: usize) -> usize {
    let inside = |i: usize| i >= 1 && i <= n;
    if inside(place[0]) && inside(place[1]) {
        return (face * n + place[1] - 1) * n + place[0] - 1;
    }
    let st = place.map(|i| (i as f32 - 0.5) / n as f32);
    let (face, st) = cube_face(cube_direction(face, st));
    let [x, y] = st.map(|c| ((c * n as f32) as usize).min(n - 1));
    (face * n + y) * n + x
}

/// The direction in which a place on a face lies, its largest component 1.
pub(super) fn cube_direction(face: usize, st: [f32; 2]) -> [f32; 3] {
    let [sc, tc] = st.map(|c| 2.0 * c - 1.0);
    match face {
        0 => [1.0, -tc, -sc],
        1 => [-1.0, -tc, sc],
        2 => [sc, 1.0, tc],
        3 => [sc, -1.0, -tc],
        4 => [sc, -tc, 1.0],
        _ => [-sc, -tc, -1.0],
    }
}

/// The face a direction points to, and the place on it (OpenGL 4.6, table 8.19); the first face for no direction.
#[inline(always)]
pub(super) fn cube_face(d: [f32; 3]) -> (usize, [f32; 2]) {
    let (face, sc, tc, ma) = cube_axes(d);
    let ma = if ma > 1e-30 { ma } else { 1.0 };
    let place = |c: f32| {
        let x = 0.5 * (c / ma) + 0.5;
        let x = if x > 0.0 { x } else { 0.0 };
        if x < 1.0 { x } else { 1.0 }
    };
    (face, [place(sc), place(tc)])
}

/// Face, coordinates across and down it, and the magnitude they are relative to.
#[inline(always)]
pub(super) fn cube_axes([x, y, z]: [f32; 3]) -> (usize, f32, f32, f32) {
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if ax >= ay && ax >= az {
        if x >= 0.0 { (0, -z, -y, ax) } else { (1, z, -y, ax) }
    } else if ay >= az {
        if y >= 0.0 { (2, x, z, ay) } else { (3, x, -z, ay) }
    } else if z >= 0.0 {
        (4, x, -y, az)
    } else {
        (5, -x, -y, az)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_survive_the_round_trip() {
        for half in 0..=u16::MAX {
            let is_finite = half >> 10 & 31 != 31;
            if is_finite {
                assert_eq!(half_from_float(float_from_half(half)), half);
            }
        }
        for (x, half) in [(1.0, 0x3c00), (-2.0, 0xc000), (65504.0, 0x7bff), (1e9, 0x7bff), (f32::NAN, 0), (6e-8, 1)] {
            assert_eq!(half_from_float(x), half, "{x}");
        }
    }

    #[test]
    fn cube_directions_and_faces_are_inverse() {
        for face in 0..6 {
            for i in 0..25 {
                let st = [(i % 5) as f32 * 0.2 + 0.1, (i / 5) as f32 * 0.2 + 0.1];
                let (back, got) = cube_face(cube_direction(face, st));
                assert!(back == face && (0..2).all(|k| (got[k] - st[k]).abs() < 1e-6));
            }
        }
    }
}
