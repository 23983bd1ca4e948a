//! VTK's older files (.vtk), as text and binary (big-endian), up to version 5.1: the outer surface with all arrays.
//!
//! Lines and single points are passed over and told of. Volumes are seen from outside: faces that belong to one cell only.
//! `NORMALS`, `TEXTURE_COORDINATES` (v up in the file) and `COLOR_SCALARS` of points become the mesh's own, all other
//! arrays fields of vertices or faces. Colour tables and `METADATA` are skipped, but for units.

use crate::assets::cells::{Cells, POLY_LINE, POLY_VERTEX, POLYGON, STRIP};
use crate::assets::dataset::{Array, Dataset, Form, Places, Role};
use crate::assets::files::Loose;
use crate::assets::join::Column;
use crate::assets::numbers::{Kind, index};
use crate::assets::text::{Words, format_error, integer, number, parse_error, string};
use crate::assets::{Neighbours, Scene, Values};
use crate::error::{Error, Mended, Report, Result, note};
use crate::math::{DVec3, Vec3, dvec3, vec3};
use std::path::Path;

/// Reads a file of VTK's older form.
pub fn read(bytes: &[u8], path: &Path, _neighbours: &Neighbours) -> Result<Report<Scene>> {
    Ok(read_loose(bytes, path)?.mend())
}

/// The same before mending.
pub(super) fn read_loose(bytes: &[u8], path: &Path) -> Result<Loose> {
    let (dataset, mended) = read_dataset(bytes, path)?;
    dataset.into_loose(path, bytes.len(), mended)
}

/// Everything in the file.
pub(super) fn read_dataset(bytes: &[u8], path: &Path) -> Result<(Dataset, Vec<Mended>)> {
    let mut file = File { bytes, at: 0, is_binary: false, path };
    let kind = file.head()?;
    let mut parts = Parts::default();
    let mut mended = Vec::new();
    let mut into = Into::Nothing;
    while let Some((keyword, at)) = file.keyword() {
        let has_geometry = !matches!(into, Into::Nothing);
        let done = match keyword.as_str() {
            "POINT_DATA" | "CELL_DATA" => file.line_numbers::<1>("a number of values").map(|[n]| {
                into = if keyword == "POINT_DATA" { Into::Points(n) } else { Into::Cells(n) };
            }),
            "METADATA" => {
                let unit = file.metadata();
                let arrays =
                    if matches!(into, Into::Cells(_)) { &mut parts.cell_arrays } else { &mut parts.point_arrays };
                if let (Some(unit), Some(last), true) = (unit, arrays.last_mut(), has_geometry) {
                    last.column.unit = unit;
                }
                Ok(())
            }
            _ => match into {
                Into::Nothing => parts.geometry(&keyword, at, &mut file),
                Into::Points(n) => file.attribute(&keyword, at, n, true, &mut parts.point_arrays),
                Into::Cells(n) => file.attribute(&keyword, at, n, false, &mut parts.cell_arrays),
            },
        };
        match done {
            Ok(()) => {}
            // The surface is there; what follows a broken array cannot be found.
            Err(why) if has_geometry => {
                note(&mut mended, 1, format!("array and all after it not read: {why}"));
                break;
            }
            Err(why) => return Err(why),
        }
    }
    let dataset = parts.dataset(&kind, path, &mut mended)?;
    Ok((dataset, mended))
}

/// What the arrays that follow belong to.
enum Into {
    Nothing,
    Points(usize),
    Cells(usize),
}

/// A file and where reading stands.
struct File<'a> {
    bytes: &'a [u8],
    at: usize,
    is_binary: bool,
    path: &'a Path,
}

impl<'a> File<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// The rest of the line.
    fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.at += (end + 1).min(rest.len());
        rest[..end].trim_ascii()
    }

    /// The next word, wherever it stands, and where that is.
    fn word(&mut self) -> Option<(&'a [u8], usize)> {
        let mut words = Words(self.rest());
        let word = words.next()?;
        let end = self.bytes.len() - words.0.len();
        self.at = end;
        Some((word, end - word.len()))
    }

    fn keyword(&mut self) -> Option<(String, usize)> {
        let (word, at) = self.word()?;
        Some((string(&word[..word.len().min(64)]).to_ascii_uppercase(), at))
    }

    /// Whether this word comes next; if so, it is read.
    fn next_is(&mut self, wanted: &str) -> bool {
        let start = self.at;
        let is_it = self.word().is_some_and(|(word, _)| word.eq_ignore_ascii_case(wanted.as_bytes()));
        if !is_it {
            self.at = start;
        }
        is_it
    }

    fn line_number(&self, at: usize) -> usize {
        1 + self.bytes[..at].iter().filter(|b| **b == b'\n').count()
    }

    /// "Expected this, found that" at a place.
    fn expected(&self, expected: &str, found: &[u8], at: usize) -> Error {
        match self.is_binary {
            true => format_error(self.path, format!("byte {at}: expected {expected}")),
            false => parse_error(self.path, self.line_number(at), expected, found),
        }
    }

    fn need(&mut self, expected: &str) -> Result<(&'a [u8], usize)> {
        self.word().ok_or_else(|| format_error(self.path, format!("the file ends where {expected} should be")))
    }

    /// N counts; in binary files the line ends with them.
    fn line_numbers<const N: usize>(&mut self, expected: &str) -> Result<[usize; N]> {
        let mut numbers = [0; N];
        for n in &mut numbers {
            let (word, at) = self.need(expected)?;
            let x = integer(word).and_then(|x| usize::try_from(x).ok());
            *n = x.ok_or_else(|| self.expected(expected, word, at))?;
        }
        Ok(numbers)
    }

    fn floats<const N: usize>(&mut self, expected: &str) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for n in &mut numbers {
            let (word, at) = self.need(expected)?;
            *n = number(word).ok_or_else(|| self.expected(expected, word, at))?;
        }
        Ok(numbers)
    }

    /// The name of a type of number.
    fn kind(&mut self) -> Result<Type> {
        let (word, at) = self.need("a type of number")?;
        Type::of(word).ok_or_else(|| self.expected("a type of number", word, at))
    }

    /// What stands before the data; the kind of data set.
    fn head(&mut self) -> Result<String> {
        if !self.line().to_ascii_lowercase().starts_with(b"# vtk datafile") {
            return Err(format_error(self.path, "not a VTK file: it does not begin with `# vtk DataFile Version`"));
        }
        self.line();
        let (word, at) = self.need("ASCII or BINARY")?;
        match word.to_ascii_uppercase().as_slice() {
            b"ASCII" => {}
            b"BINARY" => self.is_binary = true,
            _ => return Err(self.expected("ASCII or BINARY", word, at)),
        }
        // Field data may stand before the data set, too.
        let (word, at) = self.need("DATASET")?;
        if !word.eq_ignore_ascii_case(b"DATASET") {
            return Err(self.expected("DATASET", word, at));
        }
        let (word, at) = self.need("a kind of data set")?;
        let kind = string(&word[..word.len().min(64)]).to_ascii_uppercase();
        const KINDS: [&str; 6] =
            ["POLYDATA", "UNSTRUCTURED_GRID", "STRUCTURED_GRID", "RECTILINEAR_GRID", "STRUCTURED_POINTS", "FIELD"];
        match KINDS.contains(&kind.as_str()) {
            true => Ok(kind),
            false => Err(self.expected(&format!("one of {}", KINDS.join(", ")), word, at)),
        }
    }

    /// Binary numbers start on a new line.
    fn skip_line_end(&mut self) {
        let is_at_start = self.at > 0 && self.bytes[self.at - 1] == b'\n';
        if self.is_binary && !is_at_start {
            let rest = self.rest();
            let end = rest.iter().take(64).position(|b| *b == b'\n' || *b > b' ');
            if let Some(end) = end.filter(|&e| rest[e] == b'\n') {
                self.at += end + 1;
            }
        }
    }

    /// Fails unless the file may hold `n` values of this type.
    fn check_room(&self, n: Option<usize>, of: Type) -> Result<usize> {
        let room = self.rest().len();
        let least = match (self.is_binary, of) {
            (true, Type::Number(kind)) => kind.size(),
            (_, Type::Text) => 1,
            (true, Type::Bit) => 0,
            // A digit and a blank; the last blank may be missing.
            (false, _) => 2,
        };
        let fits = |n: &usize| match of {
            Type::Bit if self.is_binary => n.div_ceil(8) <= room,
            _ if self.is_binary => n.checked_mul(least.max(1)).is_some_and(|size| size <= room),
            _ => n.checked_mul(least).is_some_and(|size| size <= room + 1),
        };
        n.filter(fits).ok_or_else(|| {
            let place =
                if self.is_binary { format!("byte {}", self.at) } else { self.line_number(self.at).to_string() };
            let place = if self.is_binary { place } else { format!("line {place}") };
            let n = n.map_or("too many".into(), |n| n.to_string());
            format_error(self.path, format!("{place}: {n} values do not fit into the {room} bytes that are left"))
        })
    }

    /// `n` numbers.
    fn numbers(&mut self, of: Type, n: Option<usize>) -> Result<Values> {
        self.skip_line_end();
        let n = self.check_room(n, of)?;
        let Type::Number(kind) = of else { return self.bits(n) };
        if self.is_binary {
            let values = kind.values(&self.rest()[..n * kind.size()], false);
            self.at += n * kind.size();
            return Ok(values);
        }
        let mut values = kind.no_values();
        for _ in 0..n {
            let (word, at) = self.need("a number")?;
            values.push(number(word).ok_or_else(|| self.expected("a number", word, at))?);
        }
        Ok(values)
    }

    fn bits(&mut self, n: usize) -> Result<Values> {
        if !self.is_binary {
            return self.numbers(Type::Number(Kind::U8), Some(n));
        }
        let bytes = &self.rest()[..n.div_ceil(8)];
        self.at += bytes.len();
        Ok(Values::F32((0..n).map(|i| (bytes[i / 8] >> (7 - i % 8) & 1) as f32).collect()))
    }

    /// Passes over `n` strings.
    fn skip_strings(&mut self, n: Option<usize>) -> Result<()> {
        self.skip_line_end();
        let n = self.check_room(n, Type::Text)?;
        if !self.is_binary {
            self.line();
        }
        for _ in 0..n {
            if !self.is_binary {
                if self.rest().is_empty() {
                    return Err(format_error(self.path, "the file ends in an array of strings"));
                }
                self.line();
                continue;
            }
            // The first two bits tell how long the length is.
            let first = *self.rest().first().ok_or_else(|| format_error(self.path, "the file ends in a string"))?;
            let n_bytes = [8, 4, 2, 1][(first >> 6) as usize];
            let Some(length) = self.rest().get(..n_bytes) else {
                return Err(format_error(self.path, "the file ends in a string"));
            };
            let length = length[1..].iter().fold((first & 63) as u64, |x, b| x << 8 | *b as u64);
            self.at =
                (self.at as u64).saturating_add(n_bytes as u64).saturating_add(length).min(self.bytes.len() as u64)
                    as usize;
        }
        Ok(())
    }

    /// Points, one by one.
    fn points(&mut self) -> Result<Vec<Vec3>> {
        let [n] = self.line_numbers("a number of points")?;
        let kind = self.kind()?;
        let values = self.numbers(kind, n.checked_mul(3))?;
        let x = |i: usize| values.at(i) as f32;
        Ok((0..n).map(|i| vec3(x(3 * i), x(3 * i + 1), x(3 * i + 2))).collect())
    }

    /// Lists of points: where each ends, and all of them. Both of the ways that files have.
    fn lists(&mut self) -> Result<Lists> {
        let [n, size] = self.line_numbers("a number of cells and of numbers")?;
        if self.next_is("OFFSETS") {
            let kind = self.kind()?;
            let offsets = self.numbers(kind, Some(n))?;
            if !self.next_is("CONNECTIVITY") {
                let at = self.at;
                return Err(self.expected("CONNECTIVITY", b"", at));
            }
            let kind = self.kind()?;
            let points = self.numbers(kind, Some(size))?;
            return Ok(Lists::Offsets(offsets, points));
        }
        let list = self.numbers(Type::Number(Kind::I32), Some(size))?;
        Ok(Lists::Counted(n, list))
    }

    /// What follows an array; tells its unit. It ends with an empty line.
    fn metadata(&mut self) -> Option<String> {
        self.line();
        let (mut unit, mut is_unit) = (None, false);
        while !self.rest().is_empty() {
            let line = self.line();
            if line.is_empty() {
                break;
            }
            match line.strip_prefix(b"DATA ") {
                Some(text) if is_unit => unit = Some(percent_decoded(text)),
                _ => is_unit = line.starts_with(b"NAME UNITS_LABEL "),
            }
        }
        unit
    }

    /// One array, or a field of several.
    fn attribute(&mut self, keyword: &str, at: usize, n: usize, is_points: bool, out: &mut Vec<Array>) -> Result<()> {
        let name = |file: &mut Self| file.need("a name").map(|(name, _)| percent_decoded(name));
        match keyword {
            "SCALARS" => {
                let name = name(self)?;
                let kind = self.kind()?;
                let line = Words(self.line()).next().map(integer);
                let n_components = match line {
                    None => 1,
                    Some(n) => n.filter(|n| (1..=1000).contains(n)).unwrap_or(1) as usize,
                };
                if self.next_is("LOOKUP_TABLE") {
                    self.line();
                }
                self.array(name, kind, n_components, n, Role::Data, out)
            }
            "COLOR_SCALARS" => {
                let name = name(self)?;
                let [n_components] = self.line_numbers("a number of components")?;
                let kind = if self.is_binary { Kind::U8 } else { Kind::F32 };
                let role = Role::Colors { is_bytes: self.is_binary };
                let role = if is_points { role } else { Role::Data };
                self.array(name, Type::Number(kind), n_components, n, role, out)
            }
            "LOOKUP_TABLE" => {
                name(self)?;
                let [n] = self.line_numbers("a number of colours")?;
                let kind = if self.is_binary { Kind::U8 } else { Kind::F32 };
                self.numbers(Type::Number(kind), n.checked_mul(4)).map(drop)
            }
            "VECTORS" | "NORMALS" | "TENSORS" | "TENSORS6" | "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => {
                let name = name(self)?;
                let kind = self.kind()?;
                let n_components = match keyword {
                    "TENSORS" => 9,
                    "TENSORS6" => 6,
                    "VECTORS" | "NORMALS" => 3,
                    _ => 1,
                };
                let role = if keyword == "NORMALS" && is_points { Role::Normals } else { Role::Data };
                self.array(name, kind, n_components, n, role, out)
            }
            "TEXTURE_COORDINATES" => {
                let name = name(self)?;
                let [n_components] = self.line_numbers("a number of components")?;
                let kind = self.kind()?;
                let role = if is_points { Role::TextureCoordinates } else { Role::Data };
                self.array(name, kind, n_components, n, role, out)
            }
            "FIELD" => self.field(Some((n, is_points)), out),
            _ => Err(self.expected("the name of a kind of array", keyword.as_bytes(), at)),
        }
    }

    fn array(
        &mut self,
        name: String,
        of: Type,
        n_components: usize,
        n: usize,
        role: Role,
        out: &mut Vec<Array>,
    ) -> Result<()> {
        if n_components == 0 {
            return Ok(());
        }
        if matches!(of, Type::Text) {
            return self.skip_strings(n.checked_mul(n_components));
        }
        let values = self.numbers(of, n.checked_mul(n_components))?;
        out.push(Array { column: Column { n_components, ..Column::of(name, values) }, role });
        Ok(())
    }

    /// Arrays with their own counts; those that have not one value an element (`n`) are skipped.
    fn field(&mut self, of: Option<(usize, bool)>, out: &mut Vec<Array>) -> Result<()> {
        self.need("the name of a field")?;
        let [n_arrays] = self.line_numbers("a number of arrays")?;
        for _ in 0..n_arrays {
            // It stands between the arrays and is not counted.
            while self.next_is("METADATA") {
                if let (Some(unit), Some(last)) = (self.metadata(), out.last_mut()) {
                    last.column.unit = unit;
                }
            }
            let (word, _) = self.need("the name of an array")?;
            self.field_array(word, of, out)?;
        }
        Ok(())
    }

    fn field_array(&mut self, name: &[u8], of: Option<(usize, bool)>, out: &mut Vec<Array>) -> Result<()> {
        let [n_components, n] = self.line_numbers("numbers of components and of values")?;
        let kind = self.kind()?;
        let name = percent_decoded(name);
        let mut read = Vec::new();
        let role = match (of, kind) {
            (Some((_, true)), Type::Number(kind)) => Role::of(&name, kind, n_components),
            _ => Role::Data,
        };
        self.array(name, kind, n_components, n, role, &mut read)?;
        if of.is_some_and(|(wanted, _)| wanted == n) {
            out.append(&mut read);
        }
        Ok(())
    }
}

/// Types as files name them.
#[derive(Clone, Copy, Debug)]
enum Type {
    Number(Kind),
    Bit,
    Text,
}

impl Type {
    fn of(name: &[u8]) -> Option<Self> {
        Some(Self::Number(match name.to_ascii_lowercase().as_slice() {
            b"bit" => return Some(Self::Bit),
            b"string" | b"utf8_string" => return Some(Self::Text),
            b"char" | b"signed_char" => Kind::I8,
            b"unsigned_char" => Kind::U8,
            b"short" => Kind::I16,
            b"unsigned_short" => Kind::U16,
            b"int" | b"vtkidtype" => Kind::I32,
            b"unsigned_int" => Kind::U32,
            b"long" | b"vtktypeint64" | b"long_long" => Kind::I64,
            b"unsigned_long" | b"vtktypeuint64" | b"unsigned_long_long" => Kind::U64,
            b"vtktypeint32" => Kind::I32,
            b"vtktypeuint32" => Kind::U32,
            b"float" => Kind::F32,
            b"double" => Kind::F64,
            _ => return None,
        }))
    }
}

/// Cells' points as they stand in the file.
enum Lists {
    /// How many, and for each its number of points and its points.
    Counted(usize, Values),
    /// Where each starts, with the end; and all points.
    Offsets(Values, Values),
}

impl Lists {
    /// Gives each list's points; fewer lists than claimed when the numbers run out.
    fn each(&self, mended: &mut Vec<Mended>, mut give: impl FnMut(&mut dyn Iterator<Item = u32>)) {
        match self {
            Self::Counted(n, list) => {
                let mut at = 0;
                for i in 0..*n {
                    let count = if at < list.len() { index(list.at(at)) as usize } else { usize::MAX };
                    let end = (at + 1).saturating_add(count);
                    if end > list.len() {
                        note(mended, n - i, "cells that the file claims are not in it");
                        break;
                    }
                    give(&mut (at + 1..end).map(|i| index(list.at(i))));
                    at = end;
                }
            }
            Self::Offsets(offsets, points) => {
                for i in 1..offsets.len() {
                    let [start, end] = [offsets.at(i - 1), offsets.at(i)].map(|x| index(x) as usize);
                    // A broken offset gives a cell without points.
                    let range = if start <= end && end <= points.len() { start..end } else { 0..0 };
                    give(&mut range.map(|i| index(points.at(i))));
                }
            }
        }
    }
}

/// What was found of the geometry, and the arrays.
#[derive(Default)]
struct Parts {
    points: Vec<Vec3>,
    /// By keyword.
    lists: Vec<(String, Lists)>,
    kinds: Option<Values>,
    dimensions: Option<[u32; 3]>,
    axes: [Vec<f64>; 3],
    origin: DVec3,
    spacing: Option<DVec3>,
    point_arrays: Vec<Array>,
    cell_arrays: Vec<Array>,
}

impl Parts {
    fn geometry(&mut self, keyword: &str, at: usize, file: &mut File) -> Result<()> {
        match keyword {
            "POINTS" => self.points = file.points()?,
            "VERTICES" | "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" | "CELLS" => {
                self.lists.push((keyword.into(), file.lists()?));
            }
            "CELL_TYPES" => {
                let [n] = file.line_numbers("a number of cells")?;
                self.kinds = Some(file.numbers(Type::Number(Kind::I32), Some(n))?);
            }
            "DIMENSIONS" => {
                let n = file.line_numbers::<3>("three numbers of points")?;
                self.dimensions = Some(n.map(|n| u32::try_from(n).unwrap_or(u32::MAX)));
            }
            "X_COORDINATES" | "Y_COORDINATES" | "Z_COORDINATES" => {
                let [n] = file.line_numbers("a number of coordinates")?;
                let kind = file.kind()?;
                let axis = (keyword.as_bytes()[0] - b'X') as usize;
                self.axes[axis] = file.numbers(kind, Some(n))?.numbers().collect();
            }
            "ORIGIN" => self.origin = DVec3::from_array(file.floats("three coordinates")?),
            "SPACING" | "ASPECT_RATIO" => self.spacing = Some(DVec3::from_array(file.floats("three lengths")?)),
            "FIELD" => file.field(None, &mut Vec::new())?,
            "BLANKING" => {
                let [n] = file.line_numbers("a number of points")?;
                let kind = file.kind()?;
                file.numbers(kind, Some(n))?;
            }
            _ => return Err(file.expected("a part of a data set, POINT_DATA or CELL_DATA", keyword.as_bytes(), at)),
        }
        Ok(())
    }

    fn dataset(mut self, kind: &str, path: &Path, mended: &mut Vec<Mended>) -> Result<Dataset> {
        let missing = |what: &str| format_error(path, format!("the data set has no {what}"));
        let form = match kind {
            "POLYDATA" => {
                // Arrays count the cells in this order, whatever the file's.
                const ORDER: [(&str, u8); 4] = [
                    ("VERTICES", POLY_VERTEX),
                    ("LINES", POLY_LINE),
                    ("POLYGONS", POLYGON),
                    ("TRIANGLE_STRIPS", STRIP),
                ];
                let mut cells = Cells::default();
                for (keyword, kind) in ORDER {
                    for (_, lists) in self.lists.iter().filter(|(k, _)| k == keyword) {
                        lists.each(mended, |points| cells.push(kind, points));
                    }
                }
                Form::Cells { points: self.points, cells, keeps_points: true }
            }
            "UNSTRUCTURED_GRID" => {
                let kinds = self.kinds.take().ok_or_else(|| missing("CELL_TYPES"))?;
                let mut cells = Cells::default();
                for (_, lists) in self.lists.iter().filter(|(k, _)| k == "CELLS") {
                    lists.each(mended, |points| {
                        let i = cells.len();
                        let kind = if i < kinds.len() { kinds.at(i) } else { 0.0 };
                        cells.push(kind as u8, points);
                    });
                }
                Form::Cells { points: self.points, cells, keeps_points: false }
            }
            "FIELD" => return Err(format_error(path, "it holds a field alone: there is no surface")),
            _ => {
                let n = self.dimensions.ok_or_else(|| missing("DIMENSIONS"))?;
                let places = match kind {
                    "STRUCTURED_GRID" => Places::Each(self.points),
                    "RECTILINEAR_GRID" => Places::Axes(self.axes),
                    _ => {
                        let d = self.spacing.unwrap_or(DVec3::ONE);
                        let steps = [dvec3(d.x, 0.0, 0.0), dvec3(0.0, d.y, 0.0), dvec3(0.0, 0.0, d.z)];
                        Places::Even { origin: self.origin, steps }
                    }
                };
                Form::Lattice { n, places }
            }
        };
        Ok(Dataset { form, point_arrays: self.point_arrays, cell_arrays: self.cell_arrays })
    }
}

/// Names are written with `%20` for a blank.
fn percent_decoded(name: &[u8]) -> String {
    crate::assets::files::percent_decoded(&string(name))
}

#[cfg(test)]
#[path = "vtk_tests.rs"]
mod tests;
