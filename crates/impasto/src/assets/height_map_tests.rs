//! Height maps of all kinds.

use super::*;
use crate::assets::image::Image;
use crate::color::Encoding;

fn asc(text: &str) -> Result<Report<Scene>> {
    read_as(Kind::Asc, text.as_bytes(), Path::new("a.asc"), &Options::default())
}

#[test]
fn a_grid_has_north_at_the_back_and_fronts_upwards() {
    let report =
        asc("ncols 3\nnrows 2\nxllcorner 1000\nyllcorner 0\ncellsize 10\nNODATA_value -1\n1 2 3 4 5 -1").unwrap();
    let mesh = &report.value.mesh;
    assert_eq!(report.mended[0].to_string(), "1 cells without a value left as holes");
    assert_eq!((mesh.positions().len(), mesh.triangles().len()), (5, 3));
    assert_eq!(mesh.positions()[0], vec3(-10.0, 1.0, -5.0));
    assert_eq!(mesh.positions()[3], vec3(-10.0, 4.0, 5.0));
    assert_eq!(mesh.uv_sets()[0].uv[2], vec2(1.0, 0.0));
    assert_eq!(mesh.fields()[0].values, Values::F32(vec![1.0, 2.0, 3.0, 4.0, 5.0]));
    assert!(mesh.normals().iter().all(|n| n.y > 0.5));
    assert_eq!(mesh.source_points(), [0, 1, 2, 3, 4]);
}

#[test]
fn bad_grids_are_refused_in_one_line() {
    for (text, wanted) in [
        ("ncols 3\n1 2 3", "does not say ncols and nrows"),
        ("ncols 3000000\nnrows 2000000000\n1 2 3", "are claimed"),
        ("ncols 2\nnrows 2\ncellsize 1\n1 2 x 4", "line 4: expected an elevation, found \"x\""),
        ("ncols 2\nnrows 2\nwhat 1\n1 2 3 4", "found \"what\""),
        ("ncols 2\nnrows 1\n1 2", "2x1 cells is no surface"),
        ("ncols 2\nnrows 2\nnodata_value 1\n1 1 1 1", "holds no value"),
        ("", "does not say ncols and nrows"),
    ] {
        let error = asc(text).unwrap_err().to_string();
        assert!(error.contains(wanted), "{text}: {error}");
    }
}

#[test]
fn arrays_of_any_type_and_order_are_read() {
    let array = |descr: &str, fortran: &str, data: &[u8]| {
        let head = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': (2, 3), }}\n");
        let bytes = [b"\x93NUMPY\x01\0".as_slice(), &(head.len() as u16).to_le_bytes(), head.as_bytes(), data].concat();
        for end in 0..bytes.len() {
            assert!(npy::read(&bytes[..end], Path::new("a.npy")).is_err());
        }
        npy::read(&bytes, Path::new("a.npy")).unwrap().values
    };
    let wanted = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let bytes = |f: fn(u8) -> Vec<u8>, order: [u8; 6]| order.iter().flat_map(|x| f(*x)).collect::<Vec<u8>>();
    let (c, f) = ([1, 2, 3, 4, 5, 6], [1, 4, 2, 5, 3, 6]);
    assert_eq!(array("|u1", "False", &c), wanted);
    assert_eq!(array("<i2", "False", &bytes(|x| (x as i16).to_le_bytes().into(), c)), wanted);
    assert_eq!(array(">f4", "True", &bytes(|x| (x as f32).to_be_bytes().into(), f)), wanted);
    assert_eq!(array("<f8", "True", &bytes(|x| (x as f64).to_le_bytes().into(), f)), wanted);
    assert_eq!(array(">u8", "False", &bytes(|x| (x as u64).to_be_bytes().into(), c)), wanted);
    let halves: Vec<u8> =
        [0x3c00u16, 0x4000, 0x4200, 0x4400, 0x4500, 0x4600].iter().flat_map(|h| h.to_le_bytes()).collect();
    assert_eq!(array("<f2", "False", &halves), wanted);
}

#[test]
fn large_maps_are_thinned_and_told() {
    let size = Size::new(4096, 2049);
    let map =
        HeightMap { size, elevation: vec![1.0; size.n_cells()], cell: Cell::Length([1.0; 2]), unit: String::new() };
    let mut mended = Vec::new();
    let thin = map.thinned(&mut mended);
    assert_eq!((thin.size, thin.cell), (Size::new(2048, 1025), Cell::Length([2.0; 2])));
    assert_eq!(mended.len(), 1);
}

#[test]
fn an_image_is_a_height_map() {
    let texels = Texels::U16(Image::from_fn(Size::new(5, 5), |x, _| [x as u16 * 100; 4]));
    let image = TextureImage { name: String::new(), texels, encoding: Encoding::Srgb, n_channels: 1 };
    let scene = to_scene(from_image(&image), "a.png".into(), &Options::default()).unwrap().value;
    let extent = scene.mesh.bounds().extent();
    assert_eq!((extent.y, extent.x), (400.0, 2000.0));
    assert!(scene.up_note.contains("names no cell size"));
}

#[test]
fn a_dem_cut_anywhere_is_no_panic() {
    let real = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/3_terrain/example.dem");
    let Ok(bytes) = std::fs::read(real) else { return println!("skipped: no shared data") };
    for end in (0..bytes.len()).step_by(97) {
        _ = read_as(Kind::Dem, &bytes[..end], Path::new("a.dem"), &Options::default())
            .map(|r| assert!(r.value.mesh.positions().len() < 10_000));
    }
}
