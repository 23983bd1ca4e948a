//! NRRD, nearly raw raster data (Kindlmann, teem.sourceforge.net/nrrd): values with an attached header.
//!
//! Encodings raw, text and gzip; all integers and floats, both byte orders. The first axis runs fastest. Axes that have no
//! direction in space (components, colours, times) count as lists, of which the first entry is read.

use crate::assets::Lattice;
use crate::assets::molecule::Molecule;
use crate::assets::numbers::Kind;
use crate::assets::packed;
use crate::assets::text::{Lines, Words, format_error, integer, number, parse_error, string, trimmed};
use crate::assets::volume::{self, Volume};
use crate::error::{Report, Result, note};
use crate::math::DVec3;
use std::borrow::Cow;
use std::path::Path;

/// Reads the grid of an NRRD file with an attached header.
pub fn read(bytes: &[u8], path: &Path) -> Result<Report<Volume>> {
    if !bytes.starts_with(b"NRRD") {
        return Err(format_error(path, "not an NRRD file"));
    }
    let mut mended = Vec::new();
    let mut lines = Lines::new(bytes);
    lines.next();
    let mut head = Head::default();
    loop {
        let Some((number, line)) = lines.next() else {
            return Err(format_error(path, "the file ends in its header"));
        };
        match trimmed(&line) {
            [] => break,
            [b'#', ..] => {}
            line => head.line(number, line, path)?,
        }
    }
    let axes = head.axes(path)?;
    let kind = head.kind.ok_or_else(|| format_error(path, "the header tells no type that is read"))?;

    // The values: how many the header claims is checked against what is there, packed or not.
    let rest = lines.rest();
    let data: Cow<[u8]> = match head.encoding.as_str() {
        "raw" | "txt" | "text" | "ascii" => Cow::Borrowed(rest),
        "gz" | "gzip" => {
            let unpacked = packed::gunzip(skipped_lines(rest, head.line_skip), packed::MAX_UNPACKED);
            Cow::Owned(unpacked.map_err(|fault| format_error(path, fault))?)
        }
        other => return Err(format_error(path, format!("encoding {other:?} is not read (raw, text, gzip)"))),
    };
    let is_packed = matches!(data, Cow::Owned(_));
    let data = if is_packed { &data[..] } else { skipped_lines(&data, head.line_skip) };
    let is_text = !is_packed && head.encoding != "raw";
    let size = head.sizes.clone();
    let n_each = size.iter().try_fold(1u64, |n, s| n.checked_mul(*s)).unwrap_or(u64::MAX);
    let data = match head.byte_skip {
        // The values are what the file ends with.
        -1 if !is_text => {
            let n = n_each.saturating_mul(kind.size() as u64);
            &data[(data.len() as u64).saturating_sub(n) as usize..]
        }
        n => data.get(n.max(0) as usize..).unwrap_or_default(),
    };
    let bits = if is_text { 16 } else { 8 * kind.size() as u64 };
    let n = volume::room_for([n_each, 1, 1], 1, bits, data.len() + is_text as usize, path);
    let n = n.map_err(|_| {
        let claimed = size.iter().map(|s| s.to_string()).collect::<Vec<_>>().join(" x ");
        format_error(path, format!("{claimed} values are claimed, the file has {} bytes of them", data.len()))
    })?;
    let all: Vec<f32> = if is_text {
        let mut values = Vec::with_capacity(n);
        for word in data.split(|b| *b <= b' ' || *b == b',').filter(|w| !w.is_empty()).take(n) {
            let x = number(word).ok_or_else(|| {
                format_error(path, format!("expected a value, found {:?}", string(&word[..word.len().min(40)])))
            })?;
            values.push(x as f32);
        }
        note(&mut mended, n - values.len(), "values that the header claims are not in the file");
        values.resize(n, f32::NAN);
        values
    } else {
        let item = kind.size();
        data[..n * item].chunks_exact(item).map(|b| kind.number(b, !head.is_big) as f32).collect()
    };

    // Of lists the first entry.
    let stride = |axis: usize| size[..axis].iter().product::<u64>() as usize;
    let strides = axes.map(stride);
    let [nx, ny, nz] = axes.map(|a| size[a] as usize);
    let n_lists = all.len() / (nx * ny * nz);
    note(&mut mended, n_lists - 1, "further values of each point left out");
    let values = if n_lists == 1 {
        all
    } else {
        let mut values = Vec::with_capacity(nx * ny * nz);
        for k in 0..nz {
            for j in 0..ny {
                values.extend((0..nx).map(|i| all[i * strides[0] + j * strides[1] + k * strides[2]]));
            }
        }
        values
    };
    let lattice = head.lattice(axes);
    let name = if head.content.is_empty() { "value".to_string() } else { head.content };
    let grid = volume::checked(lattice, values, path)?.named(name, head.unit);
    Ok(Report { value: Volume { grids: vec![grid], molecule: Molecule::default(), length_unit: "" }, mended })
}

fn skipped_lines(bytes: &[u8], n: usize) -> &[u8] {
    let mut rest = bytes;
    for _ in 0..n {
        let Some(end) = rest.iter().position(|b| *b == b'\n') else { break };
        rest = &rest[end + 1..];
    }
    rest
}

/// How numbers of a named type are stored.
fn kind_by_name(name: &str) -> Option<Kind> {
    Some(match name {
        "signed char" | "int8" | "int8_t" => Kind::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Kind::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Kind::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Kind::U16,
        "int" | "signed int" | "int32" | "int32_t" => Kind::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Kind::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Kind::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Kind::U64,
        "float" => Kind::F32,
        "double" => Kind::F64,
        _ => return None,
    })
}

#[derive(Default)]
struct Head {
    kind: Option<Kind>,
    sizes: Vec<u64>,
    encoding: String,
    is_big: bool,
    spacings: Vec<f64>,
    mins: Vec<f64>,
    maxs: Vec<f64>,
    /// For each axis its step; none for lists.
    directions: Vec<Option<DVec3>>,
    kinds: Vec<String>,
    origin: Option<DVec3>,
    line_skip: usize,
    byte_skip: i64,
    content: String,
    unit: String,
}

/// More axes are no grid's.
const MOST_AXES: usize = 16;

impl Head {
    fn line(&mut self, line_number: usize, line: &[u8], path: &Path) -> Result<()> {
        let text = string(line);
        // A key and its value; `key:=value` is for whoever wrote it.
        let Some((key, value)) = text.split_once(':').filter(|(_, v)| !v.starts_with('=')) else { return Ok(()) };
        let value = value.trim();
        let wrong = |expected: &str| parse_error(path, line_number, expected, value.as_bytes());
        let numbers = || Words(value.as_bytes()).map(|w| number(w).unwrap_or(f64::NAN)).take(MOST_AXES).collect();
        match key.trim().to_ascii_lowercase().as_str() {
            "type" => {
                let name = value.split_whitespace().collect::<Vec<_>>().join(" ").to_ascii_lowercase();
                self.kind = Some(kind_by_name(&name).ok_or_else(|| wrong("a type of numbers"))?);
            }
            "sizes" => {
                let count = |w| integer(w).and_then(|n| u64::try_from(n).ok()).filter(|n| *n > 0);
                let sizes: Option<Vec<u64>> = Words(value.as_bytes()).map(count).collect();
                self.sizes = sizes.filter(|s| s.len() <= MOST_AXES).ok_or_else(|| wrong("counts along the axes"))?;
            }
            "encoding" => self.encoding = value.to_ascii_lowercase(),
            "endian" => self.is_big = value.eq_ignore_ascii_case("big"),
            "spacings" => self.spacings = numbers(),
            "axis mins" | "axismins" => self.mins = numbers(),
            "axis maxs" | "axismaxs" => self.maxs = numbers(),
            "kinds" => self.kinds = value.split_whitespace().map(str::to_lowercase).collect(),
            "space directions" => {
                self.directions = places(value).ok_or_else(|| wrong("a direction for each axis, (x,y,z) or none"))?;
            }
            "space origin" => {
                let origin = places(value).and_then(|p| *p.first()?);
                self.origin = Some(origin.ok_or_else(|| wrong("a place, (x,y,z)"))?);
            }
            "line skip" | "lineskip" => {
                let n = integer(value.as_bytes()).and_then(|n| usize::try_from(n).ok());
                self.line_skip = n.ok_or_else(|| wrong("a count of lines"))?;
            }
            "byte skip" | "byteskip" => {
                self.byte_skip = integer(value.as_bytes()).ok_or_else(|| wrong("a count of bytes"))?;
            }
            "data file" | "datafile" => {
                return Err(format_error(path, format!("line {line_number}: values in another file are not read")));
            }
            "content" => self.content = value.trim_matches('"').into(),
            "sample units" | "sampleunits" => self.unit = value.trim_matches('"').into(),
            _ => {}
        }
        Ok(())
    }

    /// The three axes in space.
    fn axes(&self, path: &Path) -> Result<[usize; 3]> {
        let n = self.sizes.len();
        let is_list = |axis: usize| {
            let kind = self.kinds.get(axis).map(String::as_str).unwrap_or("");
            let is_component = kind.contains("vector") || kind.contains("matrix") || kind.contains("color");
            match self.directions.get(axis) {
                Some(direction) => direction.is_none(),
                None => is_component || kind == "list" || kind == "time" || kind == "point" || kind == "complex",
            }
        };
        let in_space: Vec<usize> = (0..n).filter(|a| !is_list(*a)).collect();
        // Axes of one entry say nothing where there are too many.
        let in_space = match in_space.len() {
            4.. => in_space.into_iter().filter(|a| self.sizes[*a] > 1).collect(),
            _ => in_space,
        };
        in_space[..].try_into().map_err(|_| {
            let sizes = self.sizes.iter().map(|s| s.to_string()).collect::<Vec<_>>().join(" x ");
            format_error(path, format!("{} axes in space ({sizes}), where a grid has 3", in_space.len()))
        })
    }

    fn lattice(&self, axes: [usize; 3]) -> Lattice {
        let unit = [DVec3::X, DVec3::Y, DVec3::Z];
        let at = |list: &[f64], axis: usize| list.get(axis).copied().filter(|x| x.is_finite());
        let mut origin = DVec3::ZERO;
        let mut steps = unit;
        for (k, &axis) in axes.iter().enumerate() {
            let n = self.sizes[axis].max(2) - 1;
            let (low, high) = (at(&self.mins, axis), at(&self.maxs, axis));
            let spread = low.zip(high).map(|(low, high)| (high - low) / n as f64);
            let spacing = at(&self.spacings, axis).or(spread).filter(|s| *s != 0.0).unwrap_or(1.0);
            steps[k] = self.directions.get(axis).copied().flatten().unwrap_or(unit[k] * spacing);
            origin[k] = low.unwrap_or(0.0);
        }
        let size = axes.map(|a| self.sizes[a] as u32);
        Lattice { size, origin: self.origin.unwrap_or(origin), axes: steps }
    }
}

/// `(1,0,0) none (0,1.5,0)`: vectors of three, or none.
fn places(text: &str) -> Option<Vec<Option<DVec3>>> {
    let mut places = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() && places.len() < MOST_AXES {
        if let Some(after) = rest.strip_prefix("none") {
            places.push(None);
            rest = after.trim_start();
            continue;
        }
        let (inside, after) = rest.strip_prefix('(')?.split_once(')')?;
        let mut x = inside.split(',').map(|w| number(w.trim().as_bytes()));
        places.push(Some(DVec3::new(x.next()??, x.next()??, x.next()??)));
        if x.next().is_some() {
            return None;
        }
        rest = after.trim_start();
    }
    Some(places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::volume;
    use crate::assets::volume::tests::survives_damage;
    use std::io::Write;

    fn file(head: &str, data: &[u8]) -> Vec<u8> {
        [format!("NRRD0004\n# by hand\ndimension: 3\nsizes: 2 3 4\n{head}\n\n").as_bytes(), data].concat()
    }

    fn grid(bytes: &[u8]) -> crate::assets::Grid {
        read(bytes, Path::new("a.nrrd")).unwrap_or_else(|e| panic!("{e}")).value.grids.remove(0)
    }

    fn gzipped(data: &[u8]) -> Vec<u8> {
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), Default::default());
        gz.write_all(data).unwrap();
        gz.finish().unwrap()
    }

    #[test]
    fn all_types_encodings_and_byte_orders_are_read() {
        type Bytes = fn(u8) -> Vec<u8>;
        let types: [(&str, Bytes); 10] = [
            ("int8", |i| vec![i]),
            ("unsigned char", |i| vec![i]),
            ("short", |i| (i as i16).to_le_bytes().into()),
            ("uint16_t", |i| (i as u16).to_le_bytes().into()),
            ("int", |i| (i as i32).to_le_bytes().into()),
            ("unsigned int", |i| (i as u32).to_le_bytes().into()),
            ("long long", |i| (i as i64).to_le_bytes().into()),
            ("uint64", |i| (i as u64).to_le_bytes().into()),
            ("float", |i| (i as f32).to_le_bytes().into()),
            ("double", |i| (i as f64).to_le_bytes().into()),
        ];
        for (name, bytes) in types {
            for is_big in [false, true] {
                let item = |i: u8| if is_big { bytes(i).into_iter().rev().collect() } else { bytes(i) };
                let data: Vec<u8> = (0..24).flat_map(item).collect();
                let endian = if is_big { "big" } else { "little" };
                for (encoding, data) in [("raw", data.clone()), ("gzip", gzipped(&data))] {
                    let g = grid(&file(&format!("type: {name}\nencoding: {encoding}\nendian: {endian}"), &data));
                    assert_eq!((g.size(), g.at(1, 0, 0), g.at(1, 2, 3)), ([2, 3, 4], 1.0, 23.0), "{name} {encoding}");
                }
            }
        }
        let text: Vec<String> = (0..24).map(|i| format!("{i}{}", if i % 2 == 0 { " " } else { "\n" })).collect();
        let head = "type: float\nencoding: ascii\ncontent: \"heat\"\nsample units: \"K\"";
        let g = grid(&file(head, text.concat().as_bytes()));
        assert_eq!((g.at(0, 1, 0), g.name.as_str(), g.unit.as_str()), (2.0, "heat", "K"));
    }

    #[test]
    fn places_are_told_in_three_ways() {
        let raw = "type: uchar\nencoding: raw\n";
        let g = grid(&file(&format!("{raw}spacings: 0.5 2 NaN\naxis mins: 1 nan 3"), &[0; 24]));
        assert_eq!((g.axes(), g.origin()), ([DVec3::X * 0.5, DVec3::Y * 2.0, DVec3::Z], DVec3::new(1.0, 0.0, 3.0)));
        let g = grid(&file(&format!("{raw}axis mins: 0 0 0\naxis maxs: 1 4 6"), &[0; 24]));
        assert_eq!(g.axes(), [DVec3::X, DVec3::Y * 2.0, DVec3::Z * 2.0]);
        let directions =
            "space: left-posterior-superior\nspace directions: (0,2,0) (-1,0,0) (0,0,1.5)\nspace origin: (1,2,3)";
        let g = grid(&file(&format!("{raw}{directions}"), &[0; 24]));
        assert_eq!(g.axes(), [DVec3::Y * 2.0, -DVec3::X, DVec3::Z * 1.5]);
        assert_eq!(g.origin(), DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(grid(&file(&format!("{raw}byte skip: 5"), &[7; 29])).at(0, 0, 0), 7.0);
        assert_eq!(
            grid(&file(&format!("{raw}byte skip: -1\nline skip: 1"), &[&b"a\nb"[..], &[7; 24]].concat())).at(0, 0, 0),
            7.0
        );
    }

    #[test]
    fn of_lists_the_first_entry_is_read() {
        let bytes = b"NRRD0004\nsizes: 2 2 3 2\ntype: uchar\nencoding: raw\nkinds: vector domain domain domain\n\n";
        let data: Vec<u8> = (0..24).collect();
        let report = read(&[bytes, &data[..]].concat(), Path::new("a.nrrd")).unwrap();
        let g = &report.value.grids[0];
        assert_eq!((g.size(), g.at(1, 0, 0), g.at(0, 1, 0), g.at(1, 2, 1)), ([2, 3, 2], 2.0, 4.0, 22.0));
        assert_eq!(report.mended[0].to_string(), "1 further values of each point left out");
    }

    #[test]
    fn faults_are_told_in_one_line() {
        let fault = |head: &str, n: usize| read(&file(head, &vec![0; n]), Path::new("a.nrrd")).unwrap_err().to_string();
        let raw = "type: uchar\nencoding: raw";
        assert!(fault(raw, 23).contains("2 x 3 x 4 values are claimed, the file has 23 bytes"));
        assert!(fault("type: block\nencoding: raw", 24).contains("line 5: expected a type of numbers"));
        assert!(fault("type: uchar\nencoding: bzip2", 24).contains("\"bzip2\" is not read"));
        assert!(fault("type: uchar\nencoding: gzip", 24).contains("a.nrrd"));
        assert!(fault(&format!("{raw}\ndata file: a.raw"), 24).contains("another file"));
        assert!(fault(&format!("{raw}\nsizes: 2 3"), 24).contains("2 axes in space"));
        assert!(fault(&format!("{raw}\nsizes: 4000000000 4000000000 4000000000"), 24).contains("are claimed"));
        assert!(
            fault(&format!("{raw}\nspace directions: (1,0) (0,1) (1,1)"), 24).contains("a direction for each axis")
        );
    }

    #[test]
    fn damage_gives_a_grid_or_one_line() {
        let data: Vec<u8> = (0..24).collect();
        survives_damage(volume::Kind::Nrrd, &file("type: uchar\nencoding: raw\nspacings: 1 2 3", &data));
        survives_damage(volume::Kind::Nrrd, &file("type: uchar\nencoding: gzip", &gzipped(&data)));
        let text = "1 2 3 4 5 6 7 8 9 0 1 2 3 4 5 6 7 8 9 0 1 2 3 4\n";
        let head = "type: float\nencoding: ascii\nspace directions: (0,2,0) (-1,0,0) (0,0,1.5)\nspace origin: (1,2,3)";
        survives_damage(volume::Kind::Nrrd, &file(head, text.as_bytes()));
    }
}
