//! What is seen where no surface is.

use crate::color::{LinearRgb, linear_from_srgb};
use crate::math::Size;

/// What is seen where no surface is. Colours are those of the finished picture: the develop curve does not touch them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// One linear colour.
    Plain(LinearRgb),
    /// From the picture's top row to its bottom row, mixed as the eye sees it.
    Gradient {
        /// Linear.
        top: LinearRgb,
        /// Linear.
        bottom: LinearRgb,
    },
    /// Nothing; the picture gets an alpha channel.
    Transparent,
    /// The panorama or cube that also lights the scene, drawn by a [`Backdrop`](crate::picture::Backdrop) along each line
    /// of sight: part of the scene, written into the cells with alpha 1 and bent by the curve like everything else.
    Environment {
        /// 0 sharp to 1 a wash of light.
        blur: f32,
    },
}

/// The backgrounds that have names.
pub const NAMES: [&str; 6] = ["light", "studio", "white", "dark", "transparent", "environment"];

impl Background {
    /// Very light warm grey, sRGB 244, 243, 240.
    pub fn light() -> Self {
        Self::Plain(from_bytes([244, 243, 240]))
    }

    /// The same with a barely visible fall of light.
    pub fn studio() -> Self {
        Self::Gradient { top: from_bytes([248, 247, 245]), bottom: from_bytes([236, 234, 230]) }
    }

    /// Nearly black, sRGB 24, 25, 28.
    pub fn dark() -> Self {
        Self::Plain(from_bytes([24, 25, 28]))
    }

    /// One of [`NAMES`].
    pub fn by_name(name: &str) -> Option<Self> {
        match name {
            "light" => Some(Self::light()),
            "studio" => Some(Self::studio()),
            "white" => Some(Self::Plain([1.0; 3])),
            "dark" => Some(Self::dark()),
            "transparent" => Some(Self::Transparent),
            "environment" => Some(Self::Environment { blur: 0.0 }),
            _ => None,
        }
    }

    /// The linear colour of a row of the picture, counted from the top; none where the picture
    /// is transparent or the cells hold the environment.
    pub fn row(&self, y: u32, size: Size) -> Option<LinearRgb> {
        match *self {
            Self::Plain(color) => Some(color),
            Self::Transparent | Self::Environment { .. } => None,
            Self::Gradient { top, bottom } => {
                let t = (y as f32 + 0.5) / size.height.max(1) as f32;
                // Mixing square roots is near enough to even steps for the eye, and exact at both ends.
                Some(std::array::from_fn(|c| {
                    let (a, b) = (top[c].max(0.0).sqrt(), bottom[c].max(0.0).sqrt());
                    let root = a + (b - a) * t;
                    root * root
                }))
            }
        }
    }
}

fn from_bytes(srgb: [u8; 3]) -> LinearRgb {
    srgb.map(|b| linear_from_srgb(b as f64 / 255.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::srgb8_from_linear;

    #[test]
    fn named_backgrounds_are_those_of_the_house_style() {
        let size = Size::new(4, 100);
        let bytes = |name: &str, y| Background::by_name(name).unwrap().row(y, size).map(|c| c.map(srgb8_from_linear));
        assert_eq!(bytes("light", 50), Some([244, 243, 240]));
        assert_eq!(bytes("white", 0), Some([255, 255, 255]));
        assert_eq!(bytes("dark", 99), Some([24, 25, 28]));
        assert_eq!(bytes("transparent", 99), None);
        assert!(NAMES.iter().all(|name| Background::by_name(name).is_some()) && Background::by_name("pink").is_none());
        let (top, bottom) = (bytes("studio", 0).unwrap(), bytes("studio", 99).unwrap());
        assert!(top[0] > bottom[0] && top[0] - bottom[0] <= 12);
    }
}
