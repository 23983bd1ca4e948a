//! Real files and the file system.

use super::*;
use crate::assets::topology::Topology;

/// A file of the shared data, if it is there.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no shared data {name}");
    None
}

fn load_shared(name: &str) -> Option<Report<Scene>> {
    Some(load(&shared(name)?, &LoadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}")))
}

fn told(report: &Report<Scene>) -> String {
    report.mended.iter().map(|m| m.to_string()).collect::<Vec<_>>().join("; ")
}

/// Points as the file counts them.
fn n_points(mesh: &Mesh) -> usize {
    mesh.source_points().iter().max().map_or(mesh.positions().len(), |m| *m as usize + 1)
}

#[test]
fn real_meshes_have_the_counts_of_their_catalogue() {
    // Points, triangles, border edges, non-manifold edges, handles (closed ones), bodies.
    type Row = (&'static str, usize, usize, usize, usize, Option<i64>, Option<usize>);
    const ROWS: [Row; 24] = [
        ("bunny/bunny00.off", 37706, 75408, 0, 0, Some(0), None),
        ("bunny/bun_zipper.ply", 35947, 69451, 223, 0, None, Some(1)),
        ("bunny/bunny_npm.obj", 1839, 3674, 0, 0, Some(0), Some(1)),
        ("closed_and_cad/camel.off", 9770, 19536, 0, 0, Some(0), Some(1)),
        ("closed_and_cad/couplingdown.off", 1841, 3714, 0, 0, Some(9), Some(1)),
        ("closed_and_cad/anchor_dense.off", 3793, 7598, 0, 0, Some(4), Some(1)),
        ("closed_and_cad/cheese.off", 8629, 17786, 0, 0, Some(133), Some(1)),
        ("closed_and_cad/femur.off", 3897, 7798, 0, 0, Some(2), Some(1)),
        ("closed_and_cad/elk.off", 1645, 3290, 0, 0, Some(1), Some(1)),
        ("closed_and_cad/blobby.off", 2027, 4050, 0, 0, Some(0), Some(1)),
        ("open/mushroom.off", 2337, 4608, 64, 0, None, None),
        ("spot/spot_control_mesh.obj", 188, 372, 0, 0, Some(0), Some(1)),
        ("spot/spot_quadrangulated.obj", 2930, 5856, 0, 0, Some(0), Some(1)),
        ("spot/spot_triangulated.obj", 2930, 5856, 0, 0, Some(0), Some(1)),
        ("teapot/teapot.stl", 0, 894, 64, 0, None, Some(3)),
        ("suzanne/suzanne.ply", 1966, 968, 42, 0, None, None),
        ("fuze/fuze.obj", 502, 1000, 0, 0, Some(0), Some(1)),
        ("closed_and_cad/featuretype.STL", 0, 3476, 0, 0, Some(9), None),
        ("closed_and_cad/angle_block.STL", 0, 704, 0, 0, None, None),
        ("closed_and_cad/cycloidal.ply", 21384, 43368, 0, 242, None, None),
        ("closed_and_cad/quadknot.obj", 1440, 2880, 0, 0, None, Some(1)),
        ("closed_and_cad/nut.ply", 523, 1046, 0, 0, Some(1), Some(1)),
        ("closed_and_cad/ant.ply", 486, 912, 0, 0, None, Some(15)),
        ("face_james/james.obj", 6393, 12228, 552, 0, None, Some(6)),
    ];
    let mut faults = Vec::new();
    for (name, points, triangles, border, non_manifold, genus, bodies) in ROWS {
        let Some(report) = load_shared(&format!("1_meshes/{name}")) else { return };
        let mesh = &report.value.mesh;
        let t = Topology::of(mesh);
        let got = (
            if points == 0 { 0 } else { n_points(mesh) },
            mesh.triangles().len(),
            t.n_border_edges,
            t.n_non_manifold_edges,
            genus.and(t.genus()),
            bodies.map(|_| t.n_pieces),
        );
        println!("{name}: {t:?} {}", told(&report));
        if got != (points, triangles, border, non_manifold, genus, bodies) {
            faults.push(format!("{name}: {got:?} {}", told(&report)));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn real_meshes_bring_their_textures_and_colours() {
    for (name, size) in
        [("fuze/fuze.obj", 1024), ("face_james/james.obj", 2400), ("face_cyberhead_josie/cyberhead_josie.obj", 128)]
    {
        let Some(report) = load_shared(&format!("1_meshes/{name}")) else { return };
        let scene = &report.value;
        let part = &scene.mesh.parts()[0];
        let material = &scene.materials[part.material.unwrap() as usize];
        let texture = material.base_color_texture.unwrap();
        assert_eq!(scene.images[texture.image as usize].texels.size().width, size, "{name}");
        assert_eq!((scene.mesh.uv_sets().len(), material.base_color[3]), (1, 1.0), "{name}");
    }
    let scene = load_shared("1_meshes/closed_and_cad/cycloidal.ply").unwrap().value;
    assert_eq!(scene.mesh.colors().len(), scene.mesh.positions().len());
    assert_eq!(scene.mesh.fields().len(), 4, "the faces' colours are kept as fields");
}

#[test]
fn real_terrain_has_the_counts_of_its_catalogue() {
    for (name, n, low, high) in [
        ("jacksboro_fault_dem.npz", 344 * 403, 236.0, 1076.0),
        ("jacksboro_128.asc", 128 * 128, 310.0, 996.0),
        ("jacksboro_128_u16.png", 128 * 128, 310.0, 996.0),
    ] {
        let Some(report) = load_shared(&format!("3_terrain/{name}")) else { return };
        let mesh = &report.value.mesh;
        let range = mesh.fields()[0].range(0);
        println!("{name}: {} {} {:?}", told(&report), report.value.up_note, mesh.bounds());
        assert_eq!((mesh.positions().len(), range.min, range.max), (n, low, high), "{name}");
        assert_eq!(told(&report), "", "{name}");
    }
    let Some(report) = load_shared("3_terrain/example.dem") else { return };
    let mesh = &report.value.mesh;
    println!("example.dem: {} {} {:?}", told(&report), report.value.up_note, mesh.bounds());
    assert!(told(&report).contains("profiles of 327 are not in the file"));
    assert!(mesh.bounds().min.y > 600.0 && mesh.bounds().max.y < 2600.0);
    assert_eq!(mesh.fields()[0].unit, "m");
}

#[test]
fn bad_files_give_a_report_or_one_line() {
    for folder in ["assimp", "tinyobj", "draco", "openscad"] {
        let Some(folder) = shared(&format!("7_bad_input/{folder}")) else { return };
        let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
        paths.sort();
        for path in paths.iter().filter(|p| p.extension().is_some_and(|e| e != "mtl")) {
            let name = name_of(path);
            let line = match load(path, &LoadOptions::default()) {
                Ok(r) => {
                    let m = &r.value.mesh;
                    assert!(m.positions().iter().chain(m.normals()).all(|p| p.is_finite()));
                    assert!(m.triangles().as_flattened().iter().all(|v| (*v as usize) < m.positions().len()));
                    format!("{name}: {} V {} T | {}", m.positions().len(), m.triangles().len(), told(&r))
                }
                Err(e) => format!("{name}: error: {}", e.to_string().rsplit("/data/").next().unwrap()),
            };
            println!("{line}");
            assert!(!line.contains('\n'));
        }
    }
}

#[test]
fn stl_is_turned_up_unless_told_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.stl");
    std::fs::write(&path, "solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendfacet\nendsolid").unwrap();
    let up = |up| load(&path, &LoadOptions { up, ..Default::default() }).unwrap().value;
    assert_eq!(up(Up::Auto).mesh.bounds().max, vec3(1.0, 1.0, 0.0));
    assert_eq!(up(Up::Z).mesh.bounds().max, vec3(1.0, 1.0, 0.0));
    assert_eq!(up(Up::Y).mesh.bounds().max, vec3(1.0, 0.0, 1.0));
    assert!(!up(Up::Auto).up_note.is_empty());
}

#[test]
fn stl_and_obj_come_back_as_they_were_saved() {
    let folder = tempfile::tempdir().unwrap();
    let Some(scene) = load_shared("1_meshes/fuze/fuze.obj") else { return };
    let scene = scene.value;
    let path = folder.path().join("out.obj");
    save_mesh(&path, &scene).unwrap();
    let again = load(&path, &LoadOptions::default()).unwrap();
    assert_eq!(told(&again), "");
    assert_eq!(again.value.mesh.positions(), scene.mesh.positions());
    assert_eq!(again.value.mesh.uv_sets(), scene.mesh.uv_sets());
    assert_eq!(again.value.images[0].texels, scene.images[0].texels);
    let (was, is) = (&scene.materials[0], &again.value.materials[0]);
    assert_eq!((was.roughness, was.base_color_texture.is_some()), (is.roughness, is.base_color_texture.is_some()));
    assert!((was.base_color[0] - is.base_color[0]).abs() < 1e-6);

    let path = folder.path().join("out.stl");
    save_mesh(&path, &scene).unwrap();
    let again = load(&path, &LoadOptions { up: Up::Y, ..Default::default() }).unwrap().value.mesh;
    let corners =
        |m: &Mesh| m.triangles().iter().flat_map(|t| t.map(|v| m.positions()[v as usize])).collect::<Vec<_>>();
    assert_eq!(corners(&again), corners(&scene.mesh));
}

#[test]
fn nothing_is_left_behind_when_writing_fails() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    let failed = write_atomically(&path, |w| {
        w.write_all(b"half")?;
        Err(io::Error::other("no more"))
    });
    assert!(failed.unwrap_err().to_string().contains("no more"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    write_atomically(&path, |w| w.write_all(b"whole")).unwrap();
    write_atomically(&path, |w| w.write_all(b"again")).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"again");
    assert!(write_atomically(folder.path(), |_| Ok(())).is_err());
    assert!(write_atomically(&folder.path().join("no/such/a.txt"), |_| Ok(())).is_err());
}

#[test]
fn neighbours_are_found_as_exporters_write_them() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("maps/in")).unwrap();
    std::fs::write(folder.path().join("maps/a b.png"), b"x").unwrap();
    std::fs::write(folder.path().join("c.png"), b"y").unwrap();
    let beside = folder.path().join("model.obj");
    let find = |name: &str| neighbour(&beside, name).ok();
    for name in ["maps/a b.png", "./maps/a b.png", r"maps\a b.png", "maps/a%20b.png", "maps/in/../a b.png"] {
        assert_eq!(find(name), Some(b"x".to_vec()), "{name}");
    }
    for name in ["c.png", r"C:\Users\me\c.png", "/home/me/c.png"] {
        assert_eq!(find(name), Some(b"y".to_vec()), "{name}");
    }
    for name in ["", ".", "/", "maps", "d.png", "%", "%2", "/etc/passwd"] {
        assert_eq!(find(name), None, "{name}");
    }
}

#[test]
fn files_that_are_none_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, wanted) in [
        ("a.obj", &b""[..], "the file is empty"),
        ("a.xyz", b"1 2 3", ".xyz is not a format Impasto reads"),
        ("a", b"\x1f\x8b\x08", "packed bytes cannot be unpacked"),
        ("b", b"what", "a name without extension"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let error = load(&path, &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(wanted) && !error.contains('\n'), "{error}");
    }
    assert!(load(folder.path(), &LoadOptions::default()).unwrap_err().to_string().contains("it is a folder"));
    assert!(load(&folder.path().join("no.obj"), &LoadOptions::default()).is_err());
    let path = folder.path().join("c");
    std::fs::write(&path, "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
    assert_eq!(load(&path, &LoadOptions::default()).unwrap().value.mesh.triangles().len(), 1);
    let scene = Scene::of("a", Mesh::default());
    assert!(
        save_mesh(Path::new("a.fbx"), &scene).unwrap_err().to_string().contains(".fbx is not a format Impasto writes")
    );
}

#[test]
fn real_data_have_the_counts_of_their_catalogue() {
    // Triangles, points and faces of the file, fields.
    for (name, triangles, points, faces, fields) in [
        ("vtk/hexbeam.vtk", 176, 99, 40, 3),
        ("vtk/uGridEx.vtk", 40, 27, 12, 2),
        ("vtk/rbc_001.vtk", 996, 500, 996, 0),
        ("vtk/SampleStructGrid.vtk", 9692, 24000, 21489, 2),
        ("vtk/pyramid_ug.vtu", 6, 5, 1, 3),
        ("fem/calculix_thermomech.vtu", 288, 162, 64, 6),
        ("fem/pressure.json", 8352, 25110, 8370, 1),
        ("brain_conte69/conte69_32k_lh.gii", 64980, 32492, 64980, 0),
        ("brain_conte69/conte69_32k_rh.gii", 64980, 32492, 64980, 0),
    ] {
        let Some(report) = load_shared(&format!("5_science/{name}")) else { return };
        let mesh = &report.value.mesh;
        println!("{name}: {} {}", told(&report), report.value.up_note);
        let got = (mesh.triangles().len(), mesh.n_source_points(), mesh.n_source_faces(), mesh.fields().len());
        assert_eq!(got, (triangles, points, faces, fields), "{name}");
    }
}

#[test]
fn real_tables_join_real_surfaces() {
    use crate::assets::join::{self, JoinOptions};
    let Some(mut report) = load_shared("5_science/brain_conte69/conte69_32k_rh.gii") else { return };
    let columns = join::read(&shared("5_science/brain_conte69/conte69_32k_thickness.csv").unwrap()).unwrap().value;
    assert!(columns.join(&mut report.value.mesh, &JoinOptions::default()).is_err());
    let half = JoinOptions { rows: Some(32492..64984), name: Some("thickness".into()), ..Default::default() };
    assert!(columns.join(&mut report.value.mesh, &half).unwrap().is_empty());
    let mesh = &report.value.mesh;
    let field = &mesh.fields()[0];
    let source = mesh.source_points().get(77).map_or(77, |s| *s as usize);
    assert_eq!((field.name.as_str(), field.n_elements()), ("thickness", mesh.positions().len()));
    assert_eq!(field.values.at(77), columns.columns[0].values.at(32492 + source));
    assert!(field.range(0).n_missing > 3000 && field.range(0).min > 1.0);
}

#[test]
fn gzip_archives_are_read_as_what_they_hold() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.off.gz");
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), Default::default());
    packed.write_all(b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
    std::fs::write(&path, packed.finish().unwrap()).unwrap();
    assert_eq!(load(&path, &LoadOptions::default()).unwrap().value.mesh.triangles().len(), 1);
    let vtp = folder.path().join("b.vtp");
    let scene = load(&path, &LoadOptions::default()).unwrap().value;
    assert_eq!(save_mesh(&vtp, &scene).unwrap(), []);
    assert_eq!(load(&vtp, &LoadOptions::default()).unwrap().value.mesh.positions(), scene.mesh.positions());
}

#[test]
fn real_data_with_broken_bytes_give_an_error_or_a_mesh() {
    use crate::assets::broken;
    type Read = fn(&[u8], &Path) -> Result<Loose>;
    const ROWS: [(&str, u32, Read); 7] = [
        ("vtk/hexbeam.vtk", 300, vtk::read_loose),
        ("vtk/uGridEx.vtk", 300, vtk::read_loose),
        ("vtk/SampleStructGrid.vtk", 6, vtk::read_loose),
        ("vtk/pyramid_ug.vtu", 500, vtk_xml::read_loose),
        ("fem/calculix_thermomech.vtu", 200, vtk_xml::read_loose),
        ("fem/pressure.json", 6, three_json::read_loose),
        ("brain_conte69/conte69_32k_lh.gii", 6, gifti::read_loose),
    ];
    for (name, n, read) in ROWS {
        let Some(path) = shared(&format!("5_science/{name}")) else { return };
        let bytes = std::fs::read(&path).unwrap();
        broken::check(&bytes, n, |b| Ok(read(b, &path)?.mend().map(|scene| scene.mesh)));
    }
}
