//! Any bytes as an image: an image or one line, never a panic. The first byte picks the name's extension.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    let name = ["a.png", "a.jpg", "a.webp", "a.tif", "a.hdr", "a.exr", "a.pnm", "a.tga"][*first as usize % 8];
    if let Err(e) = impasto::assets::image_files::read(rest, Path::new(name)) {
        assert!(!e.to_string().contains('\n'));
    }
});
