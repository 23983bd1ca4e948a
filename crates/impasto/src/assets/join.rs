//! Values from outside: columns of tables, arrays and other files become fields of a mesh, by row or by id.
//!
//! A row belongs to a point or a face as the mesh's own file counts them (`Mesh::source_points`, `Mesh::source_faces`),
//! however the mesh was split, cut or thinned since.

use crate::assets::files::{self, kind_of};
use crate::assets::text::format_error;
use crate::assets::{Element, Field, Mesh, RawMesh, Values, gifti, npy, ply, table, vtk, vtk_xml};
use crate::error::{Error, Mended, Report, Result, note};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Named numbers, row after row, that do not belong to a mesh yet.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// As the file names it.
    pub name: String,
    /// Unit as text; empty when unknown.
    pub unit: String,
    /// Numbers a row: 1 scalar, 3 vector ...
    pub n_components: usize,
    /// `n_components` numbers for each row; NaN is missing.
    pub values: Values,
    /// What its numbers stand for, if they are keys.
    pub labels: Vec<Label>,
}

/// What a key of a column stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The number in the column.
    pub key: i32,
    /// What it stands for.
    pub name: String,
    /// Linear colour and alpha.
    pub color: [f32; 4],
}

/// The columns of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// The file, for messages.
    pub path: PathBuf,
    /// In the order of the file; they need not have the same number of rows.
    pub columns: Vec<Column>,
    /// Whether the file names them; if not, they can be asked for by their number, from 1.
    pub has_names: bool,
}

/// Which columns are joined, and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JoinOptions {
    /// The column; absent: all that fit.
    pub column: Option<String>,
    /// What its rows belong to; absent: whichever has as many.
    pub element: Option<Element>,
    /// Only these rows, counted from 0: half of a table of two hemispheres.
    pub rows: Option<Range<usize>>,
    /// The column that holds, for each row, the number of its point or face (from 0), or the value that the mesh's field of
    /// this name has there. Absent: row after row.
    pub id: Option<String>,
    /// Another name for the field; of one column only.
    pub name: Option<String>,
    /// The unit, where the file does not say it.
    pub unit: Option<String>,
}

/// What `read` can read, for messages.
pub const COLUMN_FORMATS: &str = "csv, tsv, txt, npy, npz, gii, vtk, vtp, vtu, vts, vtr, vti, ply";

impl Column {
    /// One number a row.
    pub fn of(name: impl Into<String>, values: Values) -> Self {
        Self { name: name.into(), unit: String::new(), n_components: 1, values, labels: Vec::new() }
    }

    /// How many rows it has.
    pub fn n_rows(&self) -> usize {
        self.values.len() / self.n_components.max(1)
    }
}

/// Reads the columns of a table (csv, tsv, txt), arrays (npy, npz), or the data of a mesh's file.
pub fn read(path: &Path) -> Result<Report<Columns>> {
    let (bytes, name) = files::read_unpacked(path)?;
    read_bytes(&bytes, path, &name)
}

/// The same from bytes; the extension of `name` decides, then the first bytes.
pub fn read_bytes(bytes: &[u8], path: &Path, name: &Path) -> Result<Report<Columns>> {
    let extension = files::extension(name);
    let starts = |magic: &[u8]| bytes.starts_with(magic);
    let head = &bytes[..bytes.len().min(1024)];
    let holds = |word: &[u8]| head.windows(word.len()).any(|w| w == word);
    let columns = |columns| Columns { path: path.into(), columns, has_names: true };
    let stem = || name.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(match extension.as_str() {
        "csv" | "tsv" | "txt" | "dat" => table::read(bytes, path, &stem())?,
        _ if extension == "npz" || starts(b"PK\x03\x04") => {
            Report::clean(columns(npy::read_all(bytes, path)?.into_iter().filter_map(|(n, a)| array(n, a)).collect()))
        }
        _ if starts(b"\x93NUMPY") => {
            let array = array(stem(), npy::read(bytes, path)?);
            let column = array.ok_or_else(|| format_error(path, "an array of one or two dimensions is needed"))?;
            Report::clean(Columns { has_names: false, ..columns(vec![column]) })
        }
        _ if starts(b"ply\n") || starts(b"ply\r") => {
            let none = |_: &str| Err(std::io::Error::from(std::io::ErrorKind::NotFound));
            let loose = ply::read_loose(bytes, path, &none)?;
            Report { value: columns(columns_of(&loose.mesh)), mended: loose.mended }
        }
        _ if starts(b"# vtk") => {
            let (dataset, mended) = vtk::read_dataset(bytes, path)?;
            Report { value: columns(dataset.into_columns()), mended }
        }
        _ if holds(b"<VTKFile") => {
            let mut pieces = vtk_xml::read_pieces(bytes, path)?.into_iter();
            let (mut whole, mut mended) = pieces.next().unwrap_or_default();
            for (piece, told) in pieces {
                mended.extend(told);
                whole.append(piece);
            }
            Report { value: columns(whole.into_columns()), mended }
        }
        _ if extension == "gii" || holds(b"<GIFTI") => gifti::read_columns(bytes, path)?,
        other => {
            let kind = kind_of(other);
            return Err(Error::UnknownFormat { path: path.into(), kind, verb: "joins", known: COLUMN_FORMATS });
        }
    })
}

/// An array as a column: its first axis counts rows.
fn array(name: String, array: npy::Array) -> Option<Column> {
    let n_components = match &array.shape[..] {
        [_] => 1,
        [_, n] if *n > 0 => *n,
        _ => return None,
    };
    Some(Column { n_components, ..Column::of(name, Values::F64(array.values)) })
}

/// The fields of a mesh as the file's rows.
fn columns_of(mesh: &RawMesh) -> Vec<Column> {
    let column = |f: &Field| {
        let source = match f.element {
            Element::Vertex => &mesh.source_points,
            Element::Face => &mesh.source_faces,
            Element::Corner => return None,
        };
        let n_elements = f.n_elements() as u32;
        let values = match source.is_empty() {
            true => f.values.clone(),
            false => {
                // A point may have become several vertices; the first has its numbers.
                let mut rows = vec![u32::MAX; source.iter().max().map_or(0, |m| *m as usize + 1)];
                for i in (0..n_elements.min(source.len() as u32)).rev() {
                    rows[source[i as usize] as usize] = i;
                }
                f.values.picked(&rows, f.n_components)
            }
        };
        let (name, unit) = (f.name.clone(), f.unit.clone());
        Some(Column { name, unit, n_components: f.n_components, values, labels: Vec::new() })
    };
    mesh.fields.iter().filter_map(column).collect()
}

impl Values {
    /// Groups of `n` numbers by row; a row that is not there gives NaN.
    fn picked(&self, rows: &[u32], n: usize) -> Self {
        fn go<T: Copy>(values: &[T], rows: &[u32], n: usize, nan: T) -> Vec<T> {
            let mut out = Vec::with_capacity(rows.len() * n);
            for row in rows {
                let start = (*row as usize).saturating_mul(n);
                match values.get(start..start.saturating_add(n)) {
                    Some(group) => out.extend_from_slice(group),
                    None => out.extend(std::iter::repeat_n(nan, n)),
                }
            }
            out
        }
        match self {
            Self::F32(v) => Self::F32(go(v, rows, n, f32::NAN)),
            Self::F64(v) => Self::F64(go(v, rows, n, f64::NAN)),
        }
    }
}

impl Columns {
    /// Gives the mesh the columns that the options ask for, as fields; tells what did not fit.
    ///
    /// # Errors
    /// A column that is not there, or no column with a row for each point or face: the message tells what there is.
    pub fn join(&self, mesh: &mut Mesh, options: &JoinOptions) -> Result<Vec<Mended>> {
        let mut mended = Vec::new();
        let ids = options.id.as_ref().map(|id| self.named(id)).transpose()?;
        let wanted: Vec<&Column> = match &options.column {
            Some(name) => vec![self.named(name)?],
            None => self.columns.iter().filter(|c| ids.is_none_or(|id| !std::ptr::eq(id, *c))).collect(),
        };
        if options.name.is_some() && wanted.len() != 1 {
            return Err(self.fault(format!("one name is not enough for {} columns: say which", wanted.len())));
        }
        let (mut fields, mut left_out, mut first_fault) = (Vec::new(), Vec::new(), None);
        for column in wanted {
            let rows = match ids {
                Some(ids) => self.rows_by_id(column, ids, mesh, options, &mut mended),
                None => self.rows_in_order(column, mesh, options),
            };
            match rows {
                Ok((element, rows)) => fields.extend(self.fields(column, element, &rows, options)),
                Err(why) => {
                    left_out.push(format!("{:?}", column.name));
                    first_fault = first_fault.or(Some(why));
                }
            }
        }
        match first_fault {
            Some(why) if fields.is_empty() => return Err(why),
            _ if fields.is_empty() => return Err(self.fault("there is no column in it".into())),
            _ => {}
        }
        let names = left_out.join(", ");
        note(&mut mended, left_out.len(), format!("columns that do not fit the mesh left out: {names}"));
        for field in fields {
            let same = |f: &Field| f.name == field.name && f.element == field.element;
            match mesh.raw.fields.iter().position(same) {
                Some(i) => {
                    note(&mut mended, 1, format!("field {:?} of the mesh replaced", field.name));
                    mesh.raw.fields[i] = field;
                }
                None => mesh.raw.fields.push(field),
            }
        }
        Ok(mended)
    }

    /// A column by its name, in any case if that is not ambiguous, or by its number if the file has no names.
    pub fn named(&self, name: &str) -> Result<&Column> {
        let is_like = |c: &&Column| c.name.eq_ignore_ascii_case(name);
        let mut like = self.columns.iter().filter(is_like);
        let found = self.columns.iter().find(|c| c.name == name).or_else(|| match (like.next(), like.next()) {
            (Some(one), None) => Some(one),
            _ => None,
        });
        let numbered = || name.parse::<usize>().ok().and_then(|n| self.columns.get(n.checked_sub(1)?));
        let nameless = || match &self.columns[..] {
            // A name that nobody has given can be chosen.
            [one] if name.parse::<usize>().is_err() => Some(one),
            _ => numbered(),
        };
        found.or_else(|| if self.has_names { None } else { nameless() }).ok_or_else(|| {
            let what = if self.has_names { "columns" } else { "columns, without names," };
            self.fault(format!("no column {name:?} in it; it has {} {what} {}", self.columns.len(), self.list()))
        })
    }

    /// The first names, for messages.
    fn list(&self) -> String {
        const MOST: usize = 12;
        let names: Vec<String> = self.columns.iter().take(MOST).map(|c| format!("{:?}", c.name)).collect();
        let dots = if self.columns.len() > MOST { ", ..." } else { "" };
        format!("{}{dots}", names.join(", "))
    }

    fn fault(&self, fault: String) -> Error {
        format_error(&self.path, fault)
    }

    /// The rows that count.
    fn range(&self, column: &Column, options: &JoinOptions) -> Result<Range<usize>> {
        let n = column.n_rows();
        match &options.rows {
            None => Ok(0..n),
            Some(r) if r.start < r.end && r.end <= n => Ok(r.clone()),
            Some(r) => {
                Err(self.fault(format!("rows {}..{} are not in {:?}, which has {n}", r.start, r.end, column.name)))
            }
        }
    }

    /// For each vertex or face its row, row after row.
    fn rows_in_order(&self, column: &Column, mesh: &Mesh, options: &JoinOptions) -> Result<(Element, Vec<u32>)> {
        let range = self.range(column, options)?;
        let counts = [mesh.n_source_points(), mesh.n_source_faces()];
        let element = match options.element {
            Some(Element::Corner) => return Err(self.fault("values at corners cannot be joined".into())),
            Some(element) if range.len() == counts[(element == Element::Face) as usize] => Some(element),
            None if range.len() == counts[0] => Some(Element::Vertex),
            None if range.len() == counts[1] => Some(Element::Face),
            _ => None,
        };
        let Some(element) = element else {
            let (n, [points, faces]) = (range.len(), counts);
            let hint = match points.checked_mul(2) {
                Some(both) if both == n && options.rows.is_none() && n > 0 => {
                    format!("; if it is one table for two halves, ask for rows=0..{points} or rows={points}..{n}")
                }
                _ => String::new(),
            };
            let fault = format!(
                "{:?} has {n} rows, but the mesh's file has {points} points and {faces} faces{hint}",
                column.name
            );
            return Err(self.fault(fault));
        };
        let moved = |i: u32| i.saturating_add(range.start as u32);
        Ok((element, sources(mesh, element).map(moved).collect()))
    }

    /// For each vertex or face the row with its id.
    fn rows_by_id(
        &self,
        column: &Column,
        ids: &Column,
        mesh: &Mesh,
        options: &JoinOptions,
        mended: &mut Vec<Mended>,
    ) -> Result<(Element, Vec<u32>)> {
        let range = self.range(column, options)?;
        if ids.n_rows() != column.n_rows() {
            let (a, b) = (ids.n_rows(), column.n_rows());
            return Err(self.fault(format!("{:?} has {a} rows, {:?} has {b}", ids.name, column.name)));
        }
        let own = mesh.fields().iter().find(|f| f.name == ids.name && f.element != Element::Corner);
        let element = options.element.or(own.map(|f| f.element)).unwrap_or(Element::Vertex);
        let own = own.filter(|f| f.element == element);
        let key = |x: f64| (x + 0.0).to_bits();
        let mut known: Vec<(u64, u32)> = range
            .filter(|i| !ids.values.at(i * ids.n_components).is_nan())
            .map(|i| (key(ids.values.at(i * ids.n_components)), i as u32))
            .collect();
        known.sort_unstable();
        let n = known.len();
        known.dedup_by_key(|k| k.0);
        note(mended, n - known.len(), format!("rows whose {:?} came before left out", ids.name));
        let mut is_met = vec![false; known.len()];
        let mut n_missing = 0;
        let rows: Vec<u32> = (0u32..)
            .zip(sources(mesh, element))
            .map(|(i, source)| {
                let id = own.map_or(source as f64, |f| f.values.at(i as usize * f.n_components));
                match known.binary_search_by_key(&key(id), |k| k.0) {
                    Ok(k) => {
                        is_met[k] = true;
                        known[k].1
                    }
                    Err(_) => {
                        n_missing += 1;
                        u32::MAX
                    }
                }
            })
            .collect();
        let what = if element == Element::Face { "faces" } else { "vertices" };
        if n_missing == rows.len() && !rows.is_empty() {
            return Err(self.fault(format!("no {:?} in it is that of one of the mesh's {what}", ids.name)));
        }
        note(mended, n_missing, format!("{what} without a row of their {:?}: their values are missing", ids.name));
        let n_unmet = is_met.iter().filter(|m| !**m).count();
        note(mended, n_unmet, format!("rows whose {:?} is that of none of the {what} left out", ids.name));
        Ok((element, rows))
    }

    /// The column as a field, and the colours of its labels as another.
    fn fields(&self, column: &Column, element: Element, rows: &[u32], options: &JoinOptions) -> Vec<Field> {
        let n_components = column.n_components;
        let chosen = options.column.as_ref().filter(|c| !self.has_names && c.parse::<usize>().is_err());
        let name = options.name.as_ref().or(chosen).unwrap_or(&column.name).clone();
        let unit = options.unit.as_ref().unwrap_or(&column.unit).clone();
        let values = column.values.picked(rows, n_components);
        let mut fields = Vec::new();
        if !column.labels.is_empty() && n_components == 1 {
            let color = |key: f64| {
                let found = column.labels.iter().find(|l| l.key as f64 == key);
                found.map_or([f32::NAN; 4], |l| l.color)
            };
            let colors = Values::F32(values.numbers().flat_map(color).collect());
            let name = format!("{name}.color");
            fields.push(Field { name, unit: String::new(), element, n_components: 4, values: colors });
        }
        fields.insert(0, Field { name, unit, element, n_components, values });
        fields
    }
}

/// For each vertex or triangle its point or face in the file.
fn sources(mesh: &Mesh, element: Element) -> impl Iterator<Item = u32> + '_ {
    let source = match element {
        Element::Vertex => mesh.source_points(),
        _ => mesh.source_faces(),
    };
    (0..mesh.n_elements(element)).map(|i| source.get(i).copied().unwrap_or(i as u32))
}

#[cfg(test)]
#[path = "join_tests.rs"]
mod tests;
