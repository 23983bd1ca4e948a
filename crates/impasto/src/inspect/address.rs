//! Texel addresses as colours: the information texture map of the founding method.
//!
//! Tao, Cai, Yan 2001: each texel stores its own address, coded into visual values, so that ordinary texture mapping
//! carries it to the screen, where every pixel can be decoded to the texel it shows. The decoding printed there returns U
//! and V exchanged; ours does not.

use crate::assets::Wrap;
use crate::error::{Error, Result};
use crate::inspect::channels::texels_of;
use crate::math::Size;
use crate::par::Workers;
use crate::picture::render::Shot;
use crate::visibility::{Domain, InfoBuffer};

/// How an address becomes a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Coding {
    /// As printed in the paper: 10 bits an axis in 24-bit colour.
    /// `B = U & 0xFF; G = V & 0xFF; R = ((U & 0x300) >> 8) + ((V & 0x300) >> 6)`.
    Paper10,
    /// 12 bits an axis in 24-bit colour: low bytes in blue and green, high nibbles in red.
    #[default]
    Rgb12,
    /// 24 bits an axis in 48-bit colour: low halves in red and green, high bytes together in blue.
    Wide,
}

/// Column and row of a texel, from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TexelAddress {
    /// Column.
    pub u: u32,
    /// Row.
    pub v: u32,
}

impl Coding {
    /// How many texels an axis can have.
    pub const fn n_texels(self) -> u32 {
        match self {
            Self::Paper10 => 1 << 10,
            Self::Rgb12 => 1 << 12,
            Self::Wide => 1 << 24,
        }
    }

    /// An address as red, green and blue: 8 bits each, 16 bits for [`Coding::Wide`].
    pub const fn encode(self, at: TexelAddress) -> [u16; 3] {
        let TexelAddress { u, v } = at;
        match self {
            Self::Paper10 => [(((u & 0x300) >> 8) + ((v & 0x300) >> 6)) as u16, (v & 0xff) as u16, (u & 0xff) as u16],
            Self::Rgb12 => [((u >> 8 & 0xf) + (v >> 4 & 0xf0)) as u16, (v & 0xff) as u16, (u & 0xff) as u16],
            Self::Wide => [(u & 0xffff) as u16, (v & 0xffff) as u16, ((u >> 16 & 0xff) + (v >> 8 & 0xff00)) as u16],
        }
    }

    /// The address that a colour stands for.
    pub const fn decode(self, [r, g, b]: [u16; 3]) -> TexelAddress {
        let (r, g, b) = (r as u32, g as u32, b as u32);
        match self {
            Self::Paper10 => TexelAddress { u: ((r & 0x3) << 8) + b, v: ((r & 0xc) << 6) + g },
            Self::Rgb12 => TexelAddress { u: ((r & 0xf) << 8) + b, v: ((r & 0xf0) << 4) + g },
            Self::Wide => TexelAddress { u: ((b & 0xff) << 16) + r, v: ((b & 0xff00) << 8) + g },
        }
    }
}

/// Which texel each cell shows, as colours; alpha is full where one is shown, 0 elsewhere. Values of 8 bits, or 16 for
/// [`Coding::Wide`].
///
/// Addresses count texels of the image that gives a look its colour, or of a picture of `size` if one is given.
///
/// # Errors
/// `Parameter` when an image is too large for the coding.
pub fn addresses(
    buffer: &InfoBuffer,
    domain: &Domain,
    shot: &Shot,
    (coding, size): (Coding, Option<Size>),
    workers: &Workers,
) -> Result<Vec<[u16; 4]>> {
    let full = if coding == Coding::Wide { u16::MAX } else { 255 };
    let texels = texels_of(buffer, domain, shot, size, workers);
    let limit = coding.n_texels();
    let too_large = texels.iter().flatten().find(|t| t.u >= limit || t.v >= limit);
    if let Some(texel) = too_large {
        return Err(Error::Parameter {
            what: "coding".into(),
            given: format!("{coding:?}").to_lowercase(),
            why: format!("it counts to {limit} texels a side, and texel {}, {} is seen", texel.u, texel.v),
        });
    }
    let colour = |texel: &Option<TexelAddress>| match texel {
        None => [0; 4],
        Some(texel) => {
            let [r, g, b] = coding.encode(*texel);
            [r, g, b, full]
        }
    };
    Ok(texels.iter().map(colour).collect())
}

/// The texel that a coordinate falls in; none outside of a texture that is applied once.
pub(super) fn texel(coordinate: f32, wrap: Wrap, n: u32) -> Option<u32> {
    let x = coordinate as f64;
    if !x.is_finite() || n == 0 {
        return None;
    }
    let folded = match wrap {
        Wrap::Repeat => x - x.floor(),
        Wrap::MirroredRepeat => {
            let period = x - 2.0 * (x * 0.5).floor();
            if period > 1.0 { 2.0 - period } else { period }
        }
        Wrap::ClampToEdge => x.clamp(0.0, 1.0),
        Wrap::ClampToBorder if (0.0..=1.0).contains(&x) => x,
        Wrap::ClampToBorder => return None,
    };
    Some(((folded * n as f64) as u32).min(n - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_address_survives_the_round_trip() {
        for (coding, step) in [(Coding::Paper10, 1), (Coding::Rgb12, 7), (Coding::Wide, 65_521)] {
            let n = coding.n_texels();
            for u in (0..n).step_by(step) {
                for v in (0..n).step_by(step) {
                    let at = TexelAddress { u, v };
                    assert_eq!(coding.decode(coding.encode(at)), at, "{coding:?}");
                }
            }
            let last = TexelAddress { u: n - 1, v: n - 1 };
            assert_eq!(coding.decode(coding.encode(last)), last);
        }
    }

    #[test]
    fn codes_of_24_bits_fit_bytes_and_are_the_papers() {
        for at in [TexelAddress { u: 0x2a5, v: 0x13c }, TexelAddress { u: 0x3ff, v: 0x3ff }] {
            assert!(Coding::Paper10.encode(at).iter().chain(&Coding::Rgb12.encode(at)).all(|x| *x < 256));
        }
        assert_eq!(Coding::Paper10.encode(TexelAddress { u: 0x2a5, v: 0x13c }), [0x2 + 0x4, 0x3c, 0xa5]);
    }

    #[test]
    fn coordinates_fall_in_texels_as_wrap_modes_say() {
        use Wrap::*;
        for (x, wrap, wanted) in [
            (0.0, Repeat, Some(0)),
            (1.0, Repeat, Some(0)),
            (-0.05, Repeat, Some(9)),
            (1.0, ClampToEdge, Some(9)),
            (7.0, ClampToEdge, Some(9)),
            (1.25, MirroredRepeat, Some(7)),
            (-0.25, MirroredRepeat, Some(2)),
            (1.25, ClampToBorder, None),
            (0.55, ClampToBorder, Some(5)),
            (f32::NAN, Repeat, None),
        ] {
            assert_eq!(texel(x, wrap, 10), wanted, "{x} {wrap:?}");
        }
    }
}
