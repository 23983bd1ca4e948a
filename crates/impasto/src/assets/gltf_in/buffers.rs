//! Buffers, their views, and accessors: bytes to numbers, every range checked before it is touched.

use super::json::{Fault, Json};
use crate::assets::Neighbours;
use crate::assets::numbers::Kind;
use crate::assets::packed;
use std::cell::RefCell;
use std::rc::Rc;

/// Most numbers that an accessor without bytes of its own may claim (sparse ones, filled with zeros).
const MAX_ZEROS: usize = 1 << 24;

/// All buffers of a file, fetched when first needed.
pub(super) struct Buffers<'a> {
    pub(super) root: Json<'a>,
    /// The GLB's binary chunk: the first buffer, if that names no file.
    pub(super) chunk: Option<&'a [u8]>,
    pub(super) neighbours: &'a Neighbours<'a>,
    pub(super) loaded: RefCell<Vec<Option<Fetched>>>,
}

/// A buffer's bytes, or why there are none.
type Fetched = Result<Rc<[u8]>, Fault>;

impl<'a> Buffers<'a> {
    pub(super) fn new(root: Json<'a>, chunk: Option<&'a [u8]>, neighbours: &'a Neighbours<'a>) -> Self {
        let loaded = RefCell::new(vec![None; root.n_items("buffers")]);
        Self { root, chunk, neighbours, loaded }
    }

    /// How many bytes have been fetched.
    pub(super) fn n_bytes(&self) -> usize {
        self.loaded.borrow().iter().flatten().flatten().map(|b| b.len()).sum()
    }

    fn buffer(&self, i: usize) -> Fetched {
        let json = self.root.item("buffers", i)?;
        if let Some(known) = &self.loaded.borrow()[i] {
            return known.clone();
        }
        let bytes = self.fetch(i, &json);
        self.loaded.borrow_mut()[i] = Some(bytes.clone());
        bytes
    }

    fn fetch(&self, i: usize, json: &Json) -> Fetched {
        match json.text("uri")? {
            Some(uri) => self.resource(uri).map(Rc::from).map_err(|e| json.fault(e)),
            None if i == 0 && self.chunk.is_some() => Ok(Rc::from(self.chunk.unwrap_or_default())),
            None => Err(json.fault("it names no file and the GLB has no binary chunk for it")),
        }
    }

    /// The bytes behind a URI: data in the text itself, or a file beside the glTF.
    pub(super) fn resource(&self, uri: &str) -> Result<Vec<u8>, Fault> {
        if let Some(data) = uri.strip_prefix("data:") {
            let (kind, text) = data.split_once(',').ok_or("a data URI without a comma")?;
            return match kind.ends_with(";base64") {
                true => packed::base64(text.as_bytes(), usize::MAX)
                    .map_err(|fault| format!("a data URI with broken base64: {fault}")),
                false => Ok(percent_decoded(text)),
            };
        }
        if uri.contains("://") {
            return Err(format!("{uri:?} is on the network; only files beside the glTF are read"));
        }
        let name = String::from_utf8(percent_decoded(uri)).unwrap_or_else(|_| uri.into());
        // Exporters that forget to encode a % have it taken literally when the decoded name is not there.
        let fetched = (self.neighbours)(&name).or_else(|e| if name == uri { Err(e) } else { (self.neighbours)(uri) });
        fetched.map_err(|e| format!("cannot read {name:?}: {e}"))
    }

    /// The bytes of a view, its stride (0: packed), and where it is.
    pub(super) fn view(&self, i: usize) -> Result<View, Fault> {
        let json = self.root.item("bufferViews", i)?;
        if json.extension("EXT_meshopt_compression").is_ok_and(|e| e.is_some())
            || json.extension("KHR_meshopt_compression").is_ok_and(|e| e.is_some())
        {
            return Err(json.fault("meshopt compression is not read"));
        }
        let buffer = self.buffer(json.need("buffer")?.as_index()?)?;
        let offset = json.index("byteOffset")?.unwrap_or(0);
        let length = json.need("byteLength")?.as_index()?;
        let stride = json.index("byteStride")?.unwrap_or(0);
        let end = offset.checked_add(length).filter(|&end| end <= buffer.len()).ok_or_else(|| {
            json.fault(format_args!("bytes {offset} + {length} lie beyond the buffer's {}", buffer.len()))
        })?;
        Ok(View { buffer, start: offset, end, stride, place: json.place })
    }

    pub(super) fn accessor(&self, i: usize) -> Result<Accessor<'a>, Fault> {
        let json = self.root.item("accessors", i)?;
        let component = component(&json.need("componentType")?)?;
        let kind = json.text("type")?.unwrap_or("");
        let [n_columns, n_rows] = match kind {
            "SCALAR" => [1, 1],
            "VEC2" => [1, 2],
            "VEC3" => [1, 3],
            "VEC4" => [1, 4],
            "MAT2" => [2, 2],
            "MAT3" => [3, 3],
            "MAT4" => [4, 4],
            _ => return Err(json.fault(format_args!("{kind:?} is no accessor type"))),
        };
        let count = json.need("count")?.as_index()?;
        let normalized = json.flag("normalized")?;
        Ok(Accessor { json, component, n_columns, n_rows, count, normalized })
    }

    /// Whether the bytes of all its elements are there; before anything is made as large as an accessor claims to be.
    pub(super) fn check(&self, a: &Accessor) -> Result<(), Fault> {
        match a.json.member("bufferView") {
            Some(view) => {
                let view = self.view(view.as_index()?)?;
                let offset = a.json.index("byteOffset")?.unwrap_or(0);
                self.elements(a, &view, offset, a.count).map(drop)
            }
            None if a.count.saturating_mul(a.n_components()) > MAX_ZEROS => {
                Err(a.json.fault(format_args!("claims {} elements without any bytes", a.count)))
            }
            None => Ok(()),
        }
    }

    /// All numbers of an accessor, components together, sparse ones put in place. Normalized integers become fractions.
    pub(super) fn numbers(&self, accessor: &Accessor, normalized: bool) -> Result<Vec<f64>, Fault> {
        let a = accessor;
        let n = a.n_components();
        let step = if normalized { scale(a.component) } else { None };
        let number = |x: f64| match step {
            Some(step) => (x * step).max(-1.0),
            None => x,
        };
        self.check(a)?;
        let mut numbers = match a.json.member("bufferView") {
            Some(view) => {
                let view = self.view(view.as_index()?)?;
                let offset = a.json.index("byteOffset")?.unwrap_or(0);
                let mut numbers = Vec::with_capacity(a.count * n);
                for element in self.elements(a, &view, offset, a.count)? {
                    numbers.extend(a.offsets().map(|o| number(a.component.number(&element[o..], true))));
                }
                numbers
            }
            None => vec![0.0; a.count * n],
        };
        if let Some(sparse) = a.json.object("sparse")? {
            let count = sparse.need("count")?.as_index()?;
            let indices = sparse.need("indices")?;
            let index_type = component(&indices.need("componentType")?)?;
            let index_accessor = Accessor {
                json: indices.clone(),
                component: index_type,
                n_columns: 1,
                n_rows: 1,
                count,
                normalized: false,
            };
            let view = self.view(indices.need("bufferView")?.as_index()?)?;
            let offset = indices.index("byteOffset")?.unwrap_or(0);
            let places: Vec<usize> = self
                .elements(&index_accessor, &view, offset, count)?
                .map(|bytes| index_type.number(bytes, true) as usize)
                .collect();
            let values = sparse.need("values")?;
            let view = self.view(values.need("bufferView")?.as_index()?)?;
            let offset = values.index("byteOffset")?.unwrap_or(0);
            for (element, place) in self.elements(a, &view, offset, count)?.zip(places) {
                if place >= a.count {
                    return Err(sparse.fault(format_args!("element {place} of {} is replaced", a.count)));
                }
                for (i, o) in a.offsets().enumerate() {
                    numbers[place * n + i] = number(a.component.number(&element[o..], true));
                }
            }
        }
        Ok(numbers)
    }

    /// The bytes of each element, none of them beyond the view.
    fn elements<'v>(
        &self,
        a: &Accessor,
        view: &'v View,
        offset: usize,
        count: usize,
    ) -> Result<impl Iterator<Item = &'v [u8]> + use<'v>, Fault> {
        let size = a.element_size();
        let stride = if view.stride == 0 { size } else { view.stride };
        let bytes = &view.buffer[view.start..view.end];
        let beyond = || {
            let n = bytes.len();
            a.json.fault(format_args!(
                "{count} elements of {size} bytes at {offset} lie beyond the {n} of {}",
                view.place
            ))
        };
        let needed = match count {
            0 => 0,
            _ => (count - 1).checked_mul(stride).and_then(|x| x.checked_add(size)).ok_or_else(beyond)?,
        };
        let end = offset.checked_add(needed).filter(|&end| end <= bytes.len()).ok_or_else(beyond)?;
        if stride < size && count > 1 {
            return Err(a.json.fault(format_args!("a stride of {stride} bytes for elements of {size}")));
        }
        let bytes = &bytes[offset.min(end)..end];
        Ok((0..count).map(move |i| &bytes[i * stride..i * stride + size]))
    }
}

/// Some of a buffer's bytes.
pub(super) struct View {
    buffer: Rc<[u8]>,
    start: usize,
    end: usize,
    stride: usize,
    place: String,
}

impl View {
    pub(super) fn bytes(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }
}

/// How numbers lie in a view.
pub(super) struct Accessor<'a> {
    pub(super) json: Json<'a>,
    pub(super) component: Kind,
    n_columns: usize,
    n_rows: usize,
    pub(super) count: usize,
    pub(super) normalized: bool,
}

impl Accessor<'_> {
    pub(super) fn n_components(&self) -> usize {
        self.n_columns * self.n_rows
    }

    /// Bytes from column to column: those of matrices start at multiples of four.
    fn column_size(&self) -> usize {
        let size = self.n_rows * self.component.size();
        if self.n_columns > 1 { size.next_multiple_of(4) } else { size }
    }

    fn element_size(&self) -> usize {
        self.n_columns * self.column_size()
    }

    /// Where the components are in an element.
    fn offsets(&self) -> impl Iterator<Item = usize> {
        let (column, rows, n_bytes) = (self.column_size(), self.n_rows, self.component.size());
        (0..self.n_columns).flat_map(move |c| (0..rows).map(move |r| c * column + r * n_bytes))
    }
}

/// How numbers of a component type are stored.
fn component(json: &Json) -> Result<Kind, Fault> {
    Ok(match json.as_index()? {
        5120 => Kind::I8,
        5121 => Kind::U8,
        5122 => Kind::I16,
        5123 => Kind::U16,
        5125 => Kind::U32,
        5126 => Kind::F32,
        other => return Err(json.fault(format_args!("{other} is no component type"))),
    })
}

/// What a step is worth when the whole range means 1.
fn scale(kind: Kind) -> Option<f64> {
    match kind {
        Kind::I8 => Some(1.0 / 127.0),
        Kind::U8 => Some(1.0 / 255.0),
        Kind::I16 => Some(1.0 / 32767.0),
        Kind::U16 => Some(1.0 / 65535.0),
        _ => None,
    }
}

/// `%20` and the like to bytes; a % that is none stays.
fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let hex = |k: usize| bytes.get(i + k).and_then(|&c| (c as char).to_digit(16));
        match (bytes[i], hex(1), hex(2)) {
            (b'%', Some(high), Some(low)) => {
                out.push((high * 16 + low) as u8);
                i += 3;
            }
            (other, ..) => {
                out.push(other);
                i += 1;
            }
        }
    }
    out
}
