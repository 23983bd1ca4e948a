//! Small files and broken ones.

use super::*;
use crate::assets::{Element, Mesh, broken};
use std::io::Write;

fn mesh(bytes: &[u8]) -> (Mesh, String) {
    let report = read_loose(bytes, Path::new("a.vtu")).unwrap().mend();
    let told: Vec<String> = report.mended.iter().map(|m| m.to_string()).collect();
    (report.value.mesh, told.join("; "))
}

fn base64_of(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for group in bytes.chunks(3) {
        let b = [group[0], *group.get(1).unwrap_or(&0), *group.get(2).unwrap_or(&0)];
        let n = u32::from_be_bytes([0, b[0], b[1], b[2]]);
        for k in 0..4 {
            let digit = DIGITS[(n >> (18 - 6 * k) & 63) as usize] as char;
            out.push(if k <= group.len() { digit } else { '=' });
        }
    }
    out
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), Default::default());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

/// How arrays are written.
#[derive(Clone, Copy, Debug)]
struct Way {
    is_appended: bool,
    is_base64: bool,
    is_packed: bool,
    is_big: bool,
    is_long: bool,
}

/// A tetrahedron and a triangle in two pieces, with data, written in a way; `None` is text.
fn file(way: Option<Way>) -> Vec<u8> {
    let mut block: Vec<u8> = Vec::new();
    let mut array = |kind: &str, name: &str, n: usize, numbers: &[f64]| {
        let head = format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{n}\" ");
        let Some(way) = way else {
            let words: Vec<String> = numbers.iter().map(|x| x.to_string()).collect();
            return format!("{head} format=\"ascii\">{}</DataArray>", words.join(" "));
        };
        let put = |mut bytes: Vec<u8>| {
            if way.is_big {
                bytes.reverse();
            }
            bytes
        };
        let data: Vec<u8> = numbers
            .iter()
            .flat_map(|x| match kind {
                "Float32" => put((*x as f32).to_le_bytes().to_vec()),
                "Int64" => put((*x as i64).to_le_bytes().to_vec()),
                "UInt8" => vec![*x as u8],
                _ => put(x.to_le_bytes().to_vec()),
            })
            .collect();
        let word = |n: usize| {
            if way.is_long { put((n as u64).to_le_bytes().to_vec()) } else { put((n as u32).to_le_bytes().to_vec()) }
        };
        // Packed in two blocks.
        let (head_words, body) = match way.is_packed {
            false => (vec![data.len()], data),
            true => {
                let (a, b) = data.split_at(data.len() / 2);
                let (a, b) = (zlib(a), zlib(b));
                (vec![2, data.len(), 0, a.len(), b.len()], [a, b].concat())
            }
        };
        let words: Vec<u8> = head_words.into_iter().flat_map(word).collect();
        let written = match (way.is_base64, way.is_packed) {
            (false, _) => [words, body].concat(),
            (true, true) => (base64_of(&words) + &base64_of(&body)).into_bytes(),
            (true, false) => base64_of(&[words, body].concat()).into_bytes(),
        };
        if way.is_appended {
            let offset = block.len();
            block.extend(written);
            return format!("{head} format=\"appended\" offset=\"{offset}\"/>");
        }
        format!("{head} format=\"binary\">\n{}\n</DataArray>", String::from_utf8(written).unwrap())
    };
    let attribute = |is: bool, text: &'static str| if is { text } else { "" };
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\"{}{}>\n<UnstructuredGrid>\n",
        if way.is_some_and(|w| w.is_big) { "BigEndian" } else { "LittleEndian" },
        attribute(way.is_some_and(|w| w.is_long), " header_type=\"UInt64\""),
        attribute(way.is_some_and(|w| w.is_packed), " compressor=\"vtkZLibDataCompressor\""),
    );
    for (points, cells, ends, kinds) in [
        (&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0][..], &[0.0, 1.0, 2.0, 3.0][..], 4.0, 10.0),
        (&[5.0, 0.0, 0.0, 6.0, 0.0, 0.0, 5.0, 1.0, 0.0], &[0.0, 1.0, 2.0], 3.0, 5.0),
    ] {
        let n = points.len() / 3;
        text += &format!("<Piece NumberOfPoints=\"{n}\" NumberOfCells=\"1\">\n<PointData Normals=\"n\">\n");
        let height: Vec<f64> = points.chunks(3).map(|p| p[2] + 0.1).collect();
        text += &array("Float64", "height", 1, &height);
        if n == 4 {
            text += &array("Float32", "only here", 3, points);
        }
        text += "\n</PointData>\n<CellData>\n";
        text += &array("UInt8", "kind", 1, &[kinds]);
        text += "\n</CellData>\n<Points>\n";
        text += &array("Float32", "Points", 3, points);
        text += "\n</Points>\n<Cells>\n";
        text += &array("Int64", "connectivity", 1, cells);
        text += &array("Int64", "offsets", 1, &[ends]);
        text += &array("UInt8", "types", 1, &[kinds]);
        text += "\n</Cells>\n</Piece>\n";
    }
    text += "</UnstructuredGrid>\n";
    let mut bytes = text.into_bytes();
    if let Some(way) = way.filter(|w| w.is_appended) {
        bytes.extend(
            format!("<AppendedData encoding=\"{}\">\n _", if way.is_base64 { "base64" } else { "raw" }).bytes(),
        );
        bytes.extend(block);
        bytes.extend(b"\n</AppendedData>\n");
    }
    bytes.extend(b"</VTKFile>\n");
    bytes
}

fn ways() -> Vec<Option<Way>> {
    let mut ways = vec![None];
    for bits in 0..32 {
        let bit = |i: u32| bits >> i & 1 == 1;
        let way = Way { is_appended: bit(0), is_base64: bit(1), is_packed: bit(2), is_big: bit(3), is_long: bit(4) };
        if way.is_appended || way.is_base64 {
            ways.push(Some(way));
        }
    }
    ways
}

#[test]
fn all_ways_to_write_arrays_give_the_same() {
    for way in ways() {
        let (mesh, told) = mesh(&file(way));
        assert_eq!((mesh.triangles().len(), told.as_str()), (5, ""), "{way:?}");
        assert_eq!((mesh.n_source_points(), mesh.n_source_faces()), (7, 2));
        let [height, here, kind] = mesh.fields() else { panic!("{:?}", mesh.fields()) };
        assert_eq!((height.element, height.range(0).max, height.range(0).min), (Element::Vertex, 1.1, 0.1));
        assert_eq!((here.n_components, here.range(1).max, here.range(1).n_missing), (3, 1.0, 3));
        assert_eq!(kind.values, Values::F32(vec![10.0, 10.0, 10.0, 10.0, 5.0]));
    }
}

#[test]
fn polyhedra_and_lattices_are_read() {
    let polyhedron = "<VTKFile type='UnstructuredGrid'><UnstructuredGrid><Piece><Points>
        <DataArray type='Float32' format='ascii'>0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells>
        <DataArray type='Int32' Name='connectivity'>0 1 2 3</DataArray><DataArray type='Int32' Name='offsets'>4</DataArray>
        <DataArray type='UInt8' Name='types'>42</DataArray>
        <DataArray type='Int32' Name='faces'>4 3 0 1 2 3 0 1 3 3 1 2 3 3 0 2 3</DataArray>
        <DataArray type='Int32' Name='faceoffsets'>17</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>";
    assert_eq!(mesh(polyhedron.as_bytes()).0.triangles().len(), 4);
    let image = "<VTKFile type='ImageData'><ImageData WholeExtent='0 2 0 1 3 4' Origin='1 0 0' Spacing='1 1 2'>
        <Piece Extent='0 2 0 1 3 4'><CellData><DataArray type='Int8' Name='c'>1 2</DataArray></CellData></Piece>
        </ImageData></VTKFile>";
    let (mesh, told) = mesh(image.as_bytes());
    assert_eq!((mesh.triangles().len(), told.as_str()), (20, ""));
    assert_eq!((mesh.bounds().min.to_array(), mesh.bounds().max.to_array()), ([1.0, 0.0, 6.0], [3.0, 1.0, 8.0]));
}

#[test]
fn faults_are_told_in_one_line() {
    let text = String::from_utf8(file(None)).unwrap();
    for (from, to, wanted) in [
        ("<VTKFile", "<Other", "not valid XML"),
        ("UnstructuredGrid\" v", "PUnstructuredGrid\" v", "it names other files"),
        ("byte_order", "compressor=\"vtkLZ4DataCompressor\" b", "vtkLZ4DataCompressor is not read"),
        ("Name=\"offsets\"", "Name=\"starts\"", "has no array \"offsets\""),
        ("1 0 0 0 1 0", "1 0 x 0 1 0", "\"x\" is no number"),
    ] {
        let text = if from == "<VTKFile" {
            text.replace("VTKFile version", "").replace(from, to)
        } else {
            text.replace(from, to)
        };
        match read_loose(text.as_bytes(), Path::new("a")) {
            Err(e) => assert!(e.to_string().contains(wanted) && !e.to_string().contains('\n'), "{e}"),
            Ok(loose) => assert!(loose.mended.iter().any(|m| m.what.contains(wanted)), "{from}"),
        }
    }
    let deep = "<a>".repeat(100_000);
    assert!(read_loose(deep.as_bytes(), Path::new("a")).is_err());
}

#[test]
fn broken_files_give_an_error_or_a_mesh() {
    for way in ways().into_iter().step_by(3) {
        broken::check(&file(way), 60, |b| Ok(read_loose(b, Path::new("a"))?.mend().map(|s| s.mesh)));
    }
}
