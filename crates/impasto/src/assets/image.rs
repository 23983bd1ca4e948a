//! Grids of texels in memory, their colour encoding always named.

use crate::color::Encoding;
use crate::math::Size;

/// A grid of texels, rows from the top, no padding.
#[derive(Clone, Debug, PartialEq)]
pub struct Image<T> {
    /// Texels across and down.
    pub size: Size,
    /// `size.n_cells()` texels.
    pub texels: Vec<T>,
}

impl<T: Clone> Image<T> {
    /// A grid of equal texels.
    pub fn filled(size: Size, texel: T) -> Self {
        Self { size, texels: vec![texel; size.n_cells()] }
    }

    /// A grid computed texel by texel from its column and row.
    pub fn from_fn(size: Size, mut f: impl FnMut(u32, u32) -> T) -> Self {
        let texels =
            (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))).map(|(x, y)| f(x, y)).collect();
        Self { size, texels }
    }
}

impl<T> Image<T> {
    /// The texel at column `x` of row `y`.
    pub fn at(&self, x: u32, y: u32) -> &T {
        &self.texels[y as usize * self.size.width as usize + x as usize]
    }

    /// Row `y`.
    pub fn row(&self, y: u32) -> &[T] {
        let w = self.size.width as usize;
        &self.texels[y as usize * w..][..w]
    }
}

/// The texels of an image file, widened to four channels: grey is repeated in red, green and blue; absent alpha is full.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 8 bits a channel.
    U8(Image<[u8; 4]>),
    /// 16 bits a channel.
    U16(Image<[u16; 4]>),
    /// Floats; linear light or data.
    F32(Image<[f32; 4]>),
}

impl Texels {
    /// Texels across and down.
    pub fn size(&self) -> Size {
        match self {
            Self::U8(i) => i.size,
            Self::U16(i) => i.size,
            Self::F32(i) => i.size,
        }
    }
}

/// An image as a file gave it, for use as a texture or a height map. Alpha is straight and always linear.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureImage {
    /// For messages and export: the file's name, or one made up.
    pub name: String,
    /// The numbers.
    pub texels: Texels,
    /// How the colour channels are to be understood. The one who uses the image may know better (a normal map is
    /// linear whatever the file says).
    pub encoding: Encoding,
    /// Channels in the file: 1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha.
    pub n_channels: u8,
}
