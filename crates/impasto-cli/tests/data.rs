//! Pictures of data as a user asks for them: notes, errors and edges; and many pictures in one go.

use std::path::Path;
use std::process::{Command, Output};

fn impasto(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_impasto")).current_dir(folder).args(args).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs and demands success; answers with standard error.
fn notes(folder: &Path, args: &[&str]) -> String {
    let out = impasto(folder, args);
    assert!(out.status.success(), "{args:?}: {}", text(&out.stderr));
    text(&out.stderr)
}

/// Runs and demands exit code 1; answers with its lines.
fn fails(folder: &Path, args: &[&str]) -> Vec<String> {
    let out = impasto(folder, args);
    let error = text(&out.stderr);
    assert_eq!(out.status.code(), Some(1), "{args:?}: {error}");
    error.lines().map(str::to_owned).collect()
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Two triangles with a value at each of four corners, and one at each face.
fn write_quad(path: &Path, corners: [&str; 4]) {
    let [a, b, c, d] = corners;
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         property double v\nelement face 2\nproperty list uchar int vertex_indices\nproperty double f\nend_header\n\
         -1 -1 0 {a}\n1 -1 0 {b}\n1 1 0 {c}\n-1 1 0 {d}\n3 0 1 2 5\n3 0 2 3 7\n"
    );
    std::fs::write(path, text).unwrap();
}

const VIEW: [&str; 12] = [
    "--camera",
    "front",
    "--orthographic",
    "--fill",
    "1",
    "--size",
    "40x40",
    "--samples",
    "1",
    "--background",
    "white",
    "--unlit",
];

/// A picture of a quad with these values; its bytes, and what was said about it.
fn picture(corners: [&str; 4], rest: &[&str]) -> (Vec<[u8; 4]>, String) {
    let dir = tempfile::tempdir().unwrap();
    write_quad(&dir.path().join("a.ply"), corners);
    let mut args = vec!["render", "a.ply", "-o", "a.png", "--legend", "none"];
    args.extend(VIEW);
    args.extend(rest);
    let said = notes(dir.path(), &args);
    let png = std::fs::read(dir.path().join("a.png")).unwrap();
    let image = impasto::assets::image_files::read(&png, Path::new("a.png")).unwrap().value;
    match image.texels {
        impasto::assets::Texels::U8(image) => (image.texels, said),
        _ => panic!("8 bits"),
    }
}

/// The only colour of a picture.
fn only(pixels: &[[u8; 4]]) -> [u8; 3] {
    assert!(pixels.iter().all(|p| *p == pixels[0]), "one colour");
    [pixels[0][0], pixels[0][1], pixels[0][2]]
}

const BY_V: [&str; 2] = ["--color-by", "v"];

fn with<'a>(rest: &[&'a str]) -> Vec<&'a str> {
    BY_V.into_iter().chain(rest.iter().copied()).collect()
}

#[test]
fn fields_without_values_are_shown_as_missing() {
    let (pixels, said) = picture(["nan"; 4], &with(&["--outside", ",,#ff0000"]));
    assert_eq!(only(&pixels), [255, 0, 0]);
    assert!(said.contains("field \"v\" has no value to show") && said.lines().count() == 1, "{said}");
    let (_, said) = picture(["-1", "-2", "-3", "-4"], &with(&["--scale", "log"]));
    assert!(said.contains("has no value to show") && said.contains("no logarithm"), "{said}");
}

#[test]
fn infinities_are_missing_and_leave_the_range_alone() {
    let (pixels, said) = picture(["inf", "1", "2", "-inf"], &with(&["--outside", ",,#ff0000", "--table", "grey"]));
    assert!(said.contains("2 values of \"v\" are infinite, shown as missing"), "{said}");
    let n_red = pixels.iter().filter(|p| p[..3] == [255, 0, 0]).count();
    // Each of the two is the nearest corner of a quarter of the picture.
    assert!((0.35..0.65).contains(&(n_red as f64 / pixels.len() as f64)), "{n_red} pixels are missing");
    let darkest = pixels.iter().filter(|p| p[0] == p[1]).map(|p| p[0]).min();
    assert!(darkest < Some(20), "the range begins at 1: {darkest:?}");
}

#[test]
fn constant_fields_have_the_middle_colour_and_a_note() {
    let (pixels, said) = picture(["3"; 4], &with(&["--table", "grey"]));
    assert!(only(&pixels)[0].abs_diff(128) <= 1 && said.contains("are all 3"), "{said}");
    let (pixels, _) = picture(["0"; 4], &with(&["--table", "grey"]));
    assert!(only(&pixels)[0].abs_diff(128) <= 1);
    // Lines of a plateau: none, and no flood.
    let (pixels, _) = picture(["3"; 4], &with(&["--table", "grey", "--isolines", "1"]));
    only(&pixels);
}

#[test]
fn cuts_and_filters_that_leave_nothing_say_so() {
    let (pixels, said) = picture(["1", "2", "3", "4"], &["--cut", "v>9"]);
    assert_eq!(only(&pixels), [255; 3]);
    assert!(said.contains("values of \"v\" do not pass the filter, all of them"), "{said}");
    let (pixels, said) = picture(["1", "2", "3", "4"], &with(&["--filter", "v<0", "--filter-color", "#00ff00"]));
    assert_eq!(only(&pixels), [0, 255, 0]);
    assert!(said.contains("do not pass"), "{said}");
    let (_, said) = picture(["1", "2", "3", "4"], &["--cut", "v>2"]);
    assert!(said.is_empty(), "{said}");
}

#[test]
fn ranges_and_tables_can_be_reversed() {
    let values = ["1", "2", "4", "3"];
    let (plain, _) = picture(values, &with(&["--range", "1,4", "--bands", "7"]));
    let (both, _) = picture(values, &with(&["--range", "4,1", "--bands", "7", "--reverse"]));
    let (once, _) = picture(values, &with(&["--range", "4,1", "--bands", "7"]));
    let differ = plain.iter().zip(&both).filter(|(a, b)| a != b).count();
    assert!(differ <= 40, "but for the borders of bands, reversed twice is not reversed: {differ}");
    assert_ne!(plain, once);
}

#[test]
fn negative_values_on_a_log_scale_lie_below_it() {
    let (pixels, said) =
        picture(["-1", "10", "100", "-50"], &with(&["--scale", "log", "--range", "1,100", "--outside", "#0000ff,,"]));
    assert!(said.contains("2 values of \"v\" are 0 or less"), "{said}");
    assert_eq!(pixels[0][..3], [0, 0, 255], "top left is -50");
    assert_eq!(pixels[39 * 40][..3], [0, 0, 255], "bottom left is -1");
}

#[test]
fn what_cannot_be_shown_says_what_can() {
    let dir = tempfile::tempdir().unwrap();
    write_quad(&dir.path().join("a.ply"), ["1", "2", "3", "4"]);
    for (rest, wanted) in [
        (vec!["--color-by", "w"], "the surface carries v, f@faces"),
        (vec!["--color-by", "v@faces"], "the surface carries v, f@faces"),
        (vec!["--color-by", "v.y"], "the field has 1"),
        (vec!["--color-by", "v.q"], "x, y, z, w, mag"),
        (vec!["--color-by", "v", "--table", "virdis"], "did you mean `viridis`?"),
        (vec!["--color-by", "v", "--range", "2,2"], "two finite numbers that differ"),
        (vec!["--color-by", "v", "--scale", "log", "--range", "-1,1"], "symlog"),
        (vec!["--color-by", "v", "--bands", "0"], "1 to 256"),
        (vec!["--color-by", "none.dx.gz"], "none.dx.gz"),
        (vec!["--color-by", "a.cube"], "a.cube"),
    ] {
        let args: Vec<&str> = ["render", "a.ply", "-o", "a.png"].into_iter().chain(rest).collect();
        let said = fails(dir.path(), &args);
        assert!(said.len() == 1 && said[0].contains(wanted), "{args:?}: {said:?}");
    }
    assert_eq!(files(dir.path()), ["a.ply"]);
}

#[test]
fn many_files_are_drawn_in_one_go() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["b.ply", "a.ply", "c.ply"] {
        write_quad(&dir.path().join(name), ["1", "2", "3", "4"]);
    }
    std::fs::create_dir(dir.path().join("out")).unwrap();
    let out = dir.path().join("out");
    let many = |rest: &[&str]| -> Output {
        let args: Vec<&str> =
            ["render"].iter().chain(rest).chain(&["--size", "32x24", "--samples", "1"]).copied().collect();
        impasto(dir.path(), &args)
    };
    let said = many(&["*.ply", "sample:cube", "-o", "out/{n}-{name}.png"]);
    assert!(said.status.success(), "{}", text(&said.stderr));
    assert_eq!(text(&said.stdout).lines().count(), 4);
    assert_eq!(files(&out), ["1-a.png", "2-b.png", "3-c.png", "4-cube.png"]);
    // The same picture as one by one.
    assert!(many(&["a.ply", "-o", "out/one.png"]).status.success());
    let data = |name: &str| {
        let png = std::fs::read(out.join(name)).unwrap();
        png.windows(4).position(|w| w == b"IDAT").map(|i| png[i..].to_vec())
    };
    assert_eq!(data("one.png"), data("1-a.png"));
    assert!(many(&["b.ply", "-o", "out/{name}.png", "--save-recipe", "out/{name}.toml"]).status.success());
    assert!(out.join("b.toml").is_file());

    for (rest, wanted) in [
        (vec!["a.ply", "b.ply", "-o", "out/x.png"], "write {name} or {n}"),
        (vec!["a.ply", "out/../a.ply", "-o", "out/{name}-x.png"], "write {n}"),
        (vec!["*.stl", "-o", "out/{name}.png"], "*.stl"),
        (vec!["a.ply", "-o", "out/x.png", "--each-field"], "write {field}"),
    ] {
        let said = many(&rest);
        let error = text(&said.stderr);
        assert!(
            said.status.code() == Some(1) && error.lines().count() == 1 && error.contains(wanted),
            "{rest:?}: {error}"
        );
    }
    assert!(!out.join("x.png").exists());
}

#[test]
fn one_bad_file_does_not_stop_the_others() {
    let dir = tempfile::tempdir().unwrap();
    write_quad(&dir.path().join("a.ply"), ["1", "2", "3", "4"]);
    write_quad(&dir.path().join("c.ply"), ["1", "2", "3", "4"]);
    std::fs::write(dir.path().join("b.ply"), "ply\nno such thing").unwrap();
    let said =
        fails(dir.path(), &["render", "a.ply", "b.ply", "d.ply", "c.ply", "-o", "{name}.png", "--size", "32x24"]);
    assert!(said.len() == 2 && said[0].contains("b.ply") && said[1].contains("d.ply"), "{said:?}");
    assert_eq!(files(dir.path()), ["a.ply", "a.png", "b.ply", "c.ply", "c.png"]);
    // A field that one file has not.
    std::fs::copy(dir.path().join("a.ply"), dir.path().join("e.ply")).unwrap();
    let said = fails(
        dir.path(),
        &["render", "sample:cube", "e.ply", "-o", "{name}.png", "--color-by", "v", "--size", "32x24"],
    );
    assert!(said.len() == 1 && said[0].contains("sample:cube"), "{said:?}");
    assert!(dir.path().join("e.png").exists());
}

#[test]
fn each_field_gets_its_picture() {
    let dir = tempfile::tempdir().unwrap();
    write_quad(&dir.path().join("a.ply"), ["1", "2", "3", "4"]);
    let args = ["render", "a.ply", "-o", "{name}-{field}.png", "--each-field", "--table", "grey", "--size", "32x24"];
    assert!(notes(dir.path(), &args).is_empty());
    assert_eq!(files(dir.path()), ["a-f.png", "a-v.png", "a.ply"]);
    let said = fails(dir.path(), &["render", "sample:cube", "-o", "{field}.png", "--each-field"]);
    assert!(said.len() == 1 && said[0].contains("carries no data"), "{said:?}");
    let both = ["render", "a.ply", "-o", "{field}.png", "--each-field", "--color-by", "v"];
    assert_eq!(impasto(dir.path(), &both).status.code(), Some(2));
}

#[test]
fn grids_colour_surfaces() {
    let dir = tempfile::tempdir().unwrap();
    write_quad(&dir.path().join("a.ply"), ["1", "2", "3", "4"]);
    let mut grid =
        "object 1 class gridpositions counts 2 2 2\norigin -1 -1 -1\ndelta 2 0 0\ndelta 0 2 0\ndelta 0 0 2\n\
                    object 2 class gridconnections counts 2 2 2\n\
                    object 3 class array type double rank 0 items 8 data follows\n"
            .to_owned();
    grid += "0 0 0 0 1 1 1 1\n";
    std::fs::write(dir.path().join("g.dx"), grid).unwrap();
    let args = ["render", "a.ply", "-o", "a.png", "--color-by", "g.dx", "--isolines", "0.25", "--cut", "g.dx>0.1"];
    assert!(notes(dir.path(), &[&args[..], &VIEW[..], &["--save-recipe", "a.toml"]].concat()).is_empty());
    let first = std::fs::read(dir.path().join("a.png")).unwrap();
    let recipe = std::fs::read_to_string(dir.path().join("a.toml")).unwrap();
    assert_eq!(recipe.matches("grid = \"g.dx\"").count(), 3, "{recipe}");
    notes(dir.path(), &["run", "a.toml"]);
    let again = std::fs::read(dir.path().join("a.png")).unwrap();
    let data = |png: &[u8]| png.windows(4).position(|w| w == b"IDAT").map(|i| png[i..].to_vec());
    assert_eq!(data(&first), data(&again));
    let off = ["render", "a.ply", "-o", "a.png", "--color-by", "g.dx", "--grid-offset", "5"];
    assert!(notes(dir.path(), &off).contains("no value to show"), "so far out the grid says nothing");
}
