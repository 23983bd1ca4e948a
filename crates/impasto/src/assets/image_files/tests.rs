//! Every real image of the shared data, what we write ourselves, and files cut short.

use super::*;
use crate::assets::image_write::{Numbers, exr, npy, npz, png8, png16};
use crate::math::hash_cell;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

fn load(file: &str) -> Option<Result<Report<TextureImage>>> {
    if !Path::new(DATA).exists() {
        println!("skipped: no {DATA}");
        return None;
    }
    let bytes = std::fs::read(Path::new(DATA).join(file)).unwrap();
    Some(read(&bytes, Path::new(file)))
}

fn noise8(n: usize) -> Vec<u8> {
    (0..n).map(|i| hash_cell(i as i32, 0, 0, 3) as u8).collect()
}

fn noise16(n: usize) -> Vec<u16> {
    (0..n).map(|i| hash_cell(i as i32, 0, 0, 4) as u16).collect()
}

fn value(bytes: &[u8], name: &str) -> TextureImage {
    let report = read(bytes, Path::new(name)).unwrap();
    assert!(report.mended.is_empty(), "{:?}", report.mended);
    report.value
}

#[test]
fn png_gives_back_what_was_written() {
    let size = Size::new(37, 21);
    for n in 1..=4usize {
        for encoding in [Encoding::Srgb, Encoding::Linear] {
            let samples = noise8(size.n_cells() * n);
            let image = value(&png8(size, &samples, encoding, &[("Title", "hair\u{e9}".into())]), "a.png");
            assert_eq!((image.n_channels as usize, image.encoding), (n, encoding));
            assert_eq!(image.texels, Texels::U8(Image { size, texels: widen(&samples, n, 255) }));

            let samples = noise16(size.n_cells() * n);
            let image = value(&png16(size, &samples, encoding, &[]), "a.png");
            assert_eq!((image.n_channels as usize, image.encoding), (n, encoding));
            assert_eq!(image.texels, Texels::U16(Image { size, texels: widen(&samples, n, 65535) }));
        }
    }
}

#[test]
fn exr_gives_back_what_was_written() {
    let size = Size::new(19, 23);
    let wave =
        |k: u32| -> Vec<f32> { (0..size.n_cells()).map(|i| hash_cell(i as i32, 1, 1, k) as f32 / 1e6).collect() };
    let [r, g, b, a] = [1, 2, 3, 4].map(wave);
    let channels = [("R", Numbers::F32(&r)), ("G", Numbers::F32(&g)), ("B", Numbers::F32(&b)), ("A", Numbers::F32(&a))];
    let image = value(&exr(size, &channels, &[("recipe", "x = 1".into())]), "a.exr");
    let texels = (0..size.n_cells()).map(|i| [r[i], g[i], b[i], a[i]]).collect();
    assert_eq!(image.texels, Texels::F32(Image { size, texels }));
    assert_eq!((image.encoding, image.n_channels), (Encoding::Linear, 4));

    let ids: Vec<u32> = (0..size.n_cells() as u32).collect();
    let report = read(&exr(size, &[("id", Numbers::U32(&ids))], &[]), Path::new("a.exr")).unwrap();
    let Texels::F32(image) = &report.value.texels else { panic!("floats") };
    assert_eq!((report.value.n_channels, image.texels[7]), (1, [7.0, 7.0, 7.0, 1.0]));
    assert!(report.mended[0].what.contains("id read as grey"), "{:?}", report.mended);
}

#[test]
fn numbers_are_where_numpy_looks_for_them() {
    let bytes = npy(&[2, 3], Numbers::F32(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    assert_eq!(&bytes[10..10 + header.len()], header.as_bytes());
    let start = bytes.len() - 24;
    assert_eq!((start % 64, bytes[start - 1]), (0, b'\n'));
    assert_eq!(&bytes[start..start + 4], 1.0f32.to_le_bytes());
    assert!(npy(&[], Numbers::F64(&[1.0])).windows(13).any(|w| w == b"'shape': (), "));
    assert!(npy(&[1], Numbers::U32(&[1])).windows(15).any(|w| w == b"'shape': (1,), "));
    let zip = npz(&[("a", &[1], Numbers::U32(&[7])), ("a", &[1], Numbers::U32(&[8]))]);
    let archive = zip::ZipArchive::new(Cursor::new(&zip)).unwrap();
    let names: Vec<String> = archive.file_names().map(|n| n.unwrap().into_owned()).collect();
    assert_eq!(names, ["a.npy", "a_2.npy"]);
    assert_eq!(zip, npz(&[("a", &[1], Numbers::U32(&[7])), ("a", &[1], Numbers::U32(&[8]))]));
}

#[test]
fn every_shared_image_is_read_and_every_broken_one_refused() {
    if !Path::new(DATA).exists() {
        return println!("skipped: no {DATA}");
    }
    let (mut n_read, mut n_refused) = (0, 0);
    let mut folders: Vec<_> = ["4_textures", "6_environment", "7_bad_input/pngsuite", "7_bad_input/png_crashers"]
        .map(|f| Path::new(DATA).join(f))
        .into();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
            if path.is_dir() {
                folders.push(path);
            } else if ["png", "jpg", "webp", "hdr", "exr", "pgm"].contains(&extension) {
                let is_bad = path.to_str().unwrap().contains("png_crashers");
                match read(&std::fs::read(&path).unwrap(), &path) {
                    Ok(_) => n_read += 1,
                    Err(e) => {
                        assert!(is_bad && !e.to_string().contains('\n'), "{e}");
                        n_refused += 1;
                    }
                }
            }
        }
    }
    println!("{n_read} images read, {n_refused} refused");
    assert_eq!(n_refused, 6);
}

#[test]
fn kinds_of_real_files_are_kept() {
    // File, size, is it 16 bit, channels, encoding.
    let cases = [
        ("7_bad_input/pngsuite/basn0g01.png", [32, 32], "8", 1, Encoding::Linear),
        ("7_bad_input/pngsuite/basn2c16.png", [32, 32], "16", 3, Encoding::Linear),
        ("7_bad_input/pngsuite/basn4a16.png", [32, 32], "16", 2, Encoding::Linear),
        ("7_bad_input/pngsuite/ftbwn3p08.png", [32, 32], "8", 4, Encoding::Linear),
        ("7_bad_input/pngsuite/ibasn6a08.png", [32, 32], "8", 4, Encoding::Srgb),
        ("6_environment/spiaggia_di_mondello_1k.hdr", [1024, 512], "f", 3, Encoding::Linear),
        ("6_environment/exr_dwab/clay_brown.exr", [512, 512], "f", 3, Encoding::Linear),
        ("6_environment/matcaps/0010.webp", [512, 512], "8", 3, Encoding::Srgb),
        ("4_textures/ufoai_pd/ice001.jpg", [256, 256], "8", 3, Encoding::Srgb),
        ("4_textures/samples_gray/reptile_skin.pgm", [256, 256], "8", 1, Encoding::Srgb),
        ("3_terrain/jacksboro_128_u16.png", [128, 128], "16", 1, Encoding::Linear),
    ];
    for (file, [width, height], kind, n_channels, encoding) in cases {
        let Some(report) = load(file) else { return };
        let image = report.unwrap().value;
        assert_eq!(image.texels.size(), Size::new(width, height), "{file}");
        let found = match image.texels {
            Texels::U8(_) => "8",
            Texels::U16(_) => "16",
            Texels::F32(_) => "f",
        };
        assert_eq!((found, image.n_channels, image.encoding), (kind, n_channels, encoding), "{file}");
    }
}

#[test]
fn files_cut_short_are_refused() {
    let files = [
        "7_bad_input/pngsuite/ibasn6a16.png",
        "4_textures/ufoai_pd/ice001.jpg",
        "6_environment/matcaps/0010.webp",
        "4_textures/samples_gray/reptile_skin.pgm",
        "6_environment/exr_dwab/clay_brown.exr",
    ];
    for file in files {
        let Ok(bytes) = std::fs::read(Path::new(DATA).join(file)) else { return println!("skipped: no {file}") };
        for k in 0..60 {
            let cut = bytes.len() * k / 61;
            let result = read(&bytes[..cut], Path::new(file));
            // A PNG without its last marks is whole as a picture.
            assert!(result.is_err() || bytes.len() - cut < 32, "{file} cut at {cut} of {}", bytes.len());
        }
    }
}

#[test]
fn damaged_files_never_panic() {
    let size = Size::new(9, 7);
    let floats: Vec<f32> = (0..63).map(|i| i as f32).collect();
    let pnm = [&b"P6 9 7 255\n"[..], &noise8(189)].concat();
    let files = [
        ("a.png", png8(size, &noise8(189), Encoding::Srgb, &[])),
        ("a.exr", exr(size, &[("Y", Numbers::F32(&floats))], &[])),
        ("a.pnm", pnm),
        ("a.tif", tiff_of(9, 7)),
    ];
    for (name, bytes) in &files {
        assert!(read(bytes, Path::new(name)).is_ok(), "{name}: {:?}", read(bytes, Path::new(name)));
        for i in 0..bytes.len() {
            let _ = read(&bytes[..i], Path::new(name));
            for flip in [1u8, 0x80, 0xff] {
                let mut broken = bytes.clone();
                broken[i] ^= flip;
                let _ = read(&broken, Path::new(name));
            }
        }
    }
}

/// A little-endian TIFF of f32 elevations, one strip.
fn tiff_of(width: u32, height: u32) -> Vec<u8> {
    let n = width * height;
    let entries: [(u16, u16, u32); 10] = [
        (256, 4, width),
        (257, 4, height),
        (258, 3, 32),
        (259, 3, 1),
        (262, 3, 1),
        (273, 4, 8),
        (277, 3, 1),
        (278, 4, height),
        (279, 4, n * 4),
        (339, 3, 3),
    ];
    let mut bytes = [&b"II*\0"[..], &(8 + n * 4).to_le_bytes()].concat();
    (0..n).for_each(|i| bytes.extend((i as f32 * 0.5 - 3.0).to_le_bytes()));
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, value) in entries {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(1u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend(0u32.to_le_bytes());
    bytes
}

#[test]
fn elevations_in_tiff_stay_floats() {
    let image = value(&tiff_of(5, 4), "a.tif");
    let Texels::F32(texels) = &image.texels else { panic!("floats") };
    assert_eq!((image.n_channels, image.encoding, texels.at(2, 1)), (1, Encoding::Linear, &[0.5, 0.5, 0.5, 1.0]));
}

#[test]
fn huge_claims_are_refused_at_once() {
    let pnm = b"P5 30000 30000 255\nabc".to_vec();
    let mut png = png8(Size::new(1, 1), &[1, 2, 3], Encoding::Srgb, &[]);
    png[16..24].copy_from_slice(&[0, 0, 0x70, 0, 0, 0, 0x70, 0]);
    for (name, bytes) in [("a.pgm", pnm), ("a.png", png), ("a.tif", tiff_claiming(20000))] {
        assert!(read(&bytes, Path::new(name)).is_err(), "{name}");
    }
}

fn tiff_claiming(side: u32) -> Vec<u8> {
    let mut bytes = tiff_of(1, 1);
    let at = 8 + 4 + 2 + 8;
    bytes[at..at + 4].copy_from_slice(&side.to_le_bytes());
    bytes[at + 12..at + 16].copy_from_slice(&side.to_le_bytes());
    bytes
}

#[test]
fn blocks_that_claim_more_than_their_layer_are_refused() {
    let file = "6_environment/exr_dwab/clay_brown.exr";
    let Ok(bytes) = std::fs::read(Path::new(DATA).join(file)) else { return println!("skipped: no {file}") };
    // The offsets of the two blocks of 256 rows stand right before the first block: row number, length, eleven counters.
    let block = (0..bytes.len() - 24)
        .find(|&i| {
            let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
            word(i) == i as u64 + 16 && word(i + 8) > word(i) && word(i + 8) < bytes.len() as u64
        })
        .unwrap()
        + 16;
    for counter in 1..10 {
        let mut broken = bytes.clone();
        broken[block + 8 + counter * 8 + 6] = 2;
        assert!(read(&broken, Path::new(file)).is_err(), "counter {counter}");
    }
}

#[test]
fn unknown_formats_are_named() {
    let cases: [(&[u8], &str, &str); 5] = [
        (b"\xabKTX 20\xbb", "a.ktx2", "KTX2"),
        (b"DDS |", "a.dds", "DDS"),
        (b"\0\0\0\x20ftypavif", "a.avif", "AVIF"),
        (b"", "a.png", "an empty file"),
        (b"hello", "a.xyz", "xyz"),
    ];
    for (bytes, name, what) in cases {
        let line = read(bytes, Path::new(name)).unwrap_err().to_string();
        assert!(line.contains(what) && line.contains("EXR"), "{line}");
    }
}
