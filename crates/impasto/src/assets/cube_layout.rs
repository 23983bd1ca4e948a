//! Six faces of a cube from one picture: strips and crosses, told by their proportions.
//!
//! Files show the world from inside with +Z ahead and +X to the right: that world is left-handed, as in RenderMan,
//! OpenGL and Direct3D. Ours is right-handed and looks along -Z; [`in_our_world`] mirrors z, so that lettering in the
//! surroundings stays readable and what is ahead in the file is ahead.

use crate::assets::{Image, Texels, TextureImage};
use crate::error::{Error, Result};
use crate::math::Size;

/// How a picture holds the surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CubeLayout {
    /// One face below the other, +X -X +Y -Y +Z -Z.
    VerticalStrip,
    /// The same from left to right.
    HorizontalStrip,
    /// -X +Z +X in the second row, +Y above and -Y and -Z below the middle; -Z is turned by 180 degrees.
    VerticalCross,
    /// -X +Z +X -Z in the second row, +Y above and -Y below +Z.
    HorizontalCross,
    /// No cube: longitude across, latitude down.
    Panorama,
}

/// Six square faces of equal size: +X, -X, +Y, -Y, +Z, -Z.
pub type Faces = [TextureImage; 6];

impl CubeLayout {
    /// All layouts and what people call them.
    pub const NAMES: [(&str, Self); 5] = [
        ("vertical-strip", Self::VerticalStrip),
        ("horizontal-strip", Self::HorizontalStrip),
        ("vertical-cross", Self::VerticalCross),
        ("horizontal-cross", Self::HorizontalCross),
        ("panorama", Self::Panorama),
    ];

    /// The layout a picture of this size has: six squares in a row or column, or a cross of 4:3 or 3:4; else a panorama.
    pub fn of(size: Size) -> Self {
        let [w, h] = [size.width as u64, size.height as u64];
        let layouts = [Self::VerticalStrip, Self::HorizontalStrip, Self::HorizontalCross, Self::VerticalCross];
        let fits = |layout: &Self| layout.grid().is_some_and(|[columns, rows]| w * rows == h * columns && w >= columns);
        layouts.into_iter().find(fits).unwrap_or(Self::Panorama)
    }

    /// Squares across and down.
    fn grid(self) -> Option<[u64; 2]> {
        match self {
            Self::VerticalStrip => Some([1, 6]),
            Self::HorizontalStrip => Some([6, 1]),
            Self::VerticalCross => Some([3, 4]),
            Self::HorizontalCross => Some([4, 3]),
            Self::Panorama => None,
        }
    }

    /// Column and row of each face's square, and whether it stands on its head.
    fn squares(self) -> [(u32, u32, bool); 6] {
        let at = |x, y| (x, y, false);
        match self {
            Self::HorizontalStrip => std::array::from_fn(|i| at(i as u32, 0)),
            Self::VerticalCross => [at(2, 1), at(0, 1), at(1, 0), at(1, 2), at(1, 1), (1, 3, true)],
            Self::HorizontalCross => [at(2, 1), at(0, 1), at(1, 0), at(1, 2), at(1, 1), at(3, 1)],
            Self::VerticalStrip | Self::Panorama => std::array::from_fn(|i| at(0, i as u32)),
        }
    }

    /// Cuts a picture to its six faces, as the file has them.
    ///
    /// # Errors
    /// `Parameter` when the picture cannot be of this layout.
    pub fn cut(self, image: &TextureImage) -> Result<Faces> {
        let size = image.texels.size();
        let fault = |why: String| Error::Parameter { what: "cube layout of".into(), given: image.name.clone(), why };
        let Some([columns, rows]) = self.grid() else {
            return Err(fault(format!("{size} is neither a strip of six squares nor a cross of 4:3 or 3:4")));
        };
        let n = size.width / columns as u32;
        if n == 0 || size.width as u64 != n as u64 * columns || size.height as u64 != n as u64 * rows {
            return Err(fault(format!("{size} is no grid of {columns}x{rows} squares")));
        }
        let face = |(x, y, turned): (u32, u32, bool)| {
            rearranged(image, Size::new(n, n), |i, j| {
                let (i, j) = if turned { (n - 1 - i, n - 1 - j) } else { (i, j) };
                [x * n + i, y * n + j]
            })
        };
        Ok(self.squares().map(face))
    }
}

/// Faces of a file, which are left-handed with +Z ahead, as faces of our world: z is mirrored.
pub fn in_our_world(faces: Faces) -> Faces {
    let flipped = |face: &TextureImage, [across, down]: [bool; 2]| {
        let size = face.texels.size();
        let turn = |i: u32, n: u32, flip: bool| if flip { n - 1 - i } else { i };
        rearranged(face, size, |i, j| [turn(i, size.width, across), turn(j, size.height, down)])
    };
    let [right, left, up, down, ahead, behind] = &faces;
    let (across, upside) = ([true, false], [false, true]);
    [
        flipped(right, across),
        flipped(left, across),
        flipped(up, upside),
        flipped(down, upside),
        flipped(behind, across),
        flipped(ahead, across),
    ]
}

/// Six faces as one picture, one below the other. Panics unless all have the same kind of numbers, as [`check`] and
/// [`CubeLayout::cut`] make sure.
pub fn strip(faces: &Faces) -> TextureImage {
    fn pile<T: Clone>(faces: &Faces, pick: impl Fn(&Texels) -> Option<&Image<T>>) -> Option<Image<T>> {
        let images: Option<Vec<&Image<T>>> = faces.iter().map(|f| pick(&f.texels)).collect();
        let images = images?;
        let Size { width, height } = images[0].size;
        let texels = images.iter().flat_map(|i| i.texels.iter().cloned()).collect();
        Some(Image { size: Size::new(width, height * 6), texels })
    }
    let bytes = pile(faces, |t| if let Texels::U8(i) = t { Some(i) } else { None }).map(Texels::U8);
    let words = || pile(faces, |t| if let Texels::U16(i) = t { Some(i) } else { None }).map(Texels::U16);
    let floats = || pile(faces, |t| if let Texels::F32(i) = t { Some(i) } else { None }).map(Texels::F32);
    let texels = bytes.or_else(words).or_else(floats).expect("faces have one kind of numbers");
    TextureImage { texels, ..faces[0].clone() }
}

/// Whether six images are equal squares.
///
/// # Errors
/// `Parameter` with what is wrong.
pub fn check(images: Vec<TextureImage>) -> Result<Faces> {
    let fault = |given: &str, why: String| Error::Parameter { what: "cube of".into(), given: given.into(), why };
    let first = images.first().map_or(Size::default(), |i| i.texels.size());
    if let Some(odd) = images.iter().find(|i| i.texels.size() != first || first.width != first.height) {
        let why = format!("it is {}; the six faces of a cube are squares of one size", odd.texels.size());
        return Err(fault(&odd.name, why));
    }
    let depth = |i: &TextureImage| std::mem::discriminant(&i.texels);
    if let Some(odd) = images.iter().find(|i| depth(i) != depth(&images[0])) {
        return Err(fault(&odd.name, "it has other numbers (8 bits, 16 bits, floats) than the first face".into()));
    }
    let n = images.len();
    images.try_into().map_err(|_| fault("", format!("a cube has six faces, here are {n}")))
}

/// A picture of texels from elsewhere in another.
fn rearranged(image: &TextureImage, size: Size, from: impl Fn(u32, u32) -> [u32; 2]) -> TextureImage {
    fn pick<T: Clone>(image: &Image<T>, size: Size, from: impl Fn(u32, u32) -> [u32; 2]) -> Image<T> {
        Image::from_fn(size, |x, y| {
            let [x, y] = from(x, y);
            image.at(x, y).clone()
        })
    }
    let texels = match &image.texels {
        Texels::U8(i) => Texels::U8(pick(i, size, from)),
        Texels::U16(i) => Texels::U16(pick(i, size, from)),
        Texels::F32(i) => Texels::F32(pick(i, size, from)),
    };
    TextureImage { name: image.name.clone(), texels, encoding: image.encoding, n_channels: image.n_channels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Encoding;

    /// A picture whose texels say where they are.
    fn numbered(width: u32, height: u32) -> TextureImage {
        let texels = Texels::U8(Image::from_fn(Size::new(width, height), |x, y| [x as u8, y as u8, 0, 255]));
        TextureImage { name: "a".into(), texels, encoding: Encoding::Srgb, n_channels: 3 }
    }

    fn at(image: &TextureImage, x: u32, y: u32) -> [u8; 2] {
        let Texels::U8(i) = &image.texels else { panic!("bytes stay bytes") };
        let [a, b, ..] = *i.at(x, y);
        [a, b]
    }

    #[test]
    fn layouts_are_told_by_their_proportions() {
        for (w, h, wanted) in [
            (256, 1536, CubeLayout::VerticalStrip),
            (1536, 256, CubeLayout::HorizontalStrip),
            (1024, 768, CubeLayout::HorizontalCross),
            (768, 1024, CubeLayout::VerticalCross),
            (1024, 512, CubeLayout::Panorama),
            (1000, 700, CubeLayout::Panorama),
            (0, 0, CubeLayout::Panorama),
            (1, 6, CubeLayout::VerticalStrip),
        ] {
            assert_eq!(CubeLayout::of(Size::new(w, h)), wanted, "{w}x{h}");
        }
    }

    #[test]
    fn faces_are_cut_in_the_usual_order() {
        let first = |layout: CubeLayout, w, h| layout.cut(&numbered(w, h)).unwrap().each_ref().map(|f| at(f, 0, 0));
        let strip = [[0, 0], [0, 2], [0, 4], [0, 6], [0, 8], [0, 10]];
        assert_eq!(first(CubeLayout::VerticalStrip, 2, 12), strip);
        assert_eq!(first(CubeLayout::HorizontalStrip, 12, 2), strip.map(|[x, y]| [y, x]));
        let cross = [[4, 2], [0, 2], [2, 0], [2, 4], [2, 2]];
        assert_eq!(first(CubeLayout::HorizontalCross, 8, 6)[..5], cross);
        assert_eq!(first(CubeLayout::HorizontalCross, 8, 6)[5], [6, 2]);
        assert_eq!(first(CubeLayout::VerticalCross, 6, 8)[..5], cross);
        // The lowest square stands on its head: its last texel comes first.
        assert_eq!(first(CubeLayout::VerticalCross, 6, 8)[5], [3, 7]);
        for (layout, w, h) in
            [(CubeLayout::VerticalCross, 8, 6), (CubeLayout::Panorama, 8, 4), (CubeLayout::VerticalStrip, 0, 0)]
        {
            let fault = layout.cut(&numbered(w, h)).unwrap_err().to_string();
            assert!(!fault.contains('\n') && fault.contains(&format!("{w}x{h}")), "{fault}");
        }
    }

    /// Around the sides a cross is one picture: the right edge of each square meets the left edge of the next. After
    /// mirroring the same holds from +Z over -X, -Z and +X, as seen from inside our world: right of -Z lies +X.
    #[test]
    fn what_is_ahead_in_the_file_is_ahead_in_our_world() {
        let faces = in_our_world(CubeLayout::HorizontalCross.cut(&numbered(8, 6)).unwrap());
        // -Z, whose s runs to -x: its right edge in the picture (s = 0) is the file's column 5 of +Z, next to +X's 4.
        assert_eq!((at(&faces[5], 0, 0), at(&faces[5], 1, 1)), ([3, 2], [2, 3]));
        // +X: s runs to -z; its last column touches -Z and is the file's first, beside +Z.
        assert_eq!((at(&faces[0], 1, 0), at(&faces[0], 0, 0)), ([4, 2], [5, 2]));
        // +Y: t runs to +z; its first row touches -Z and is the file's last, beside +Z.
        assert_eq!((at(&faces[2], 0, 0), at(&faces[3], 0, 1)), ([2, 1], [2, 4]));
    }

    #[test]
    fn strips_are_cut_and_joined_again() {
        let image = numbered(2, 12);
        assert_eq!(strip(&CubeLayout::VerticalStrip.cut(&image).unwrap()), image);
    }

    #[test]
    fn faces_must_be_equal_squares() {
        let fault = |sizes: &[(u32, u32)]| check(sizes.iter().map(|(w, h)| numbered(*w, *h)).collect()).unwrap_err();
        assert!(fault(&[(2, 2); 5]).to_string().contains("here are 5"));
        assert!(fault(&[(2, 3); 6]).to_string().contains("2x3"));
        assert!(fault(&[(2, 2), (2, 2), (2, 2), (4, 4), (2, 2), (2, 2)]).to_string().contains("4x4"));
        assert!(check(vec![numbered(3, 3); 6]).is_ok());
    }
}
