//! The header of a PLY file: which elements, with which properties, in which encoding.

use crate::assets::numbers::Kind;
use crate::assets::text::{Lines, Words, format_error, integer, parse_error, string, trimmed};
use crate::error::Result;
use std::path::Path;

/// No scan has as many; a file that has is broken.
const MAX_PROPERTIES: usize = 1000;

/// What stands before the numbers.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<ElementHeader>,
    /// Names of texture files (`comment TextureFile`, as MeshLab writes it).
    pub(super) textures: Vec<String>,
    /// Names of properties and their units (`comment unit NAME UNIT`, as our writer writes it).
    pub(super) units: Vec<(String, String)>,
    /// Bytes up to the first number.
    pub(super) len: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Debug)]
pub(super) struct ElementHeader {
    pub(super) name: String,
    /// As claimed.
    pub(super) n: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// Of a number, or of a list's entries.
    pub(super) kind: Kind,
    /// Lists: the kind of their length.
    pub(super) list: Option<Kind>,
}

/// The kind of number that PLY calls by this name.
fn kind_of(name: &[u8]) -> Option<Kind> {
    Some(match name {
        b"char" | b"int8" => Kind::I8,
        b"uchar" | b"uint8" => Kind::U8,
        b"short" | b"int16" => Kind::I16,
        b"ushort" | b"uint16" => Kind::U16,
        b"int" | b"int32" => Kind::I32,
        b"uint" | b"uint32" => Kind::U32,
        b"float" | b"float32" => Kind::F32,
        b"double" | b"float64" => Kind::F64,
        _ => return None,
    })
}

impl ElementHeader {
    /// Bytes of a binary row if no list makes it vary.
    pub(super) fn fixed_size(&self) -> Option<usize> {
        self.properties.iter().all(|p| p.list.is_none()).then(|| self.least_size())
    }

    /// Bytes of a binary row whose lists are empty.
    pub(super) fn least_size(&self) -> usize {
        self.properties.iter().map(|p| p.list.unwrap_or(p.kind).size()).sum()
    }
}

impl Header {
    pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Self> {
        let mut lines = Lines::new(bytes);
        if lines.next().is_none_or(|(_, line)| trimmed(&line) != b"ply") {
            return Err(format_error(path, "not a PLY file: it does not begin with the line `ply`"));
        }
        let mut header =
            Self { encoding: Encoding::Ascii, elements: Vec::new(), textures: Vec::new(), units: Vec::new(), len: 0 };
        let mut has_format = false;
        while let Some((number, line)) = lines.next() {
            let bad = |expected: &str| parse_error(path, number, expected, &line);
            let mut words = Words(&line);
            match words.next() {
                None | Some(b"obj_info") => {}
                Some(b"comment") => header.comment(words),
                Some(b"format") => {
                    has_format = true;
                    header.encoding = match words.next() {
                        Some(b"ascii") => Encoding::Ascii,
                        Some(b"binary_little_endian") => Encoding::Little,
                        Some(b"binary_big_endian") => Encoding::Big,
                        _ => return Err(bad("ascii, binary_little_endian or binary_big_endian")),
                    };
                }
                Some(b"element") => {
                    let (Some(name), Some(n)) = (words.next(), words.next().and_then(integer)) else {
                        return Err(bad("an element's name and number"));
                    };
                    let n = u64::try_from(n).map_err(|_| bad("a number of elements"))?;
                    header.elements.push(ElementHeader { name: string(name), n, properties: Vec::new() });
                }
                Some(b"property") => {
                    let Some(element) = header.elements.last_mut() else {
                        return Err(bad("an element before its properties"));
                    };
                    if element.properties.len() >= MAX_PROPERTIES {
                        return Err(format_error(
                            path,
                            format!("an element with more than {MAX_PROPERTIES} properties"),
                        ));
                    }
                    let property = property(words).ok_or_else(|| bad("a property's type and name"))?;
                    element.properties.push(property);
                }
                Some(b"end_header") => {
                    if !has_format {
                        return Err(format_error(path, "the header has no format line"));
                    }
                    header.len = bytes.len() - lines.rest().len();
                    return Ok(header);
                }
                Some(_) => return Err(bad("a PLY header line")),
            }
        }
        Err(format_error(path, "the header does not end: no line `end_header`"))
    }

    fn comment(&mut self, mut words: Words) {
        match words.next() {
            Some(b"TextureFile") if self.textures.len() < MAX_PROPERTIES => {
                self.textures.push(string(trimmed(words.0)));
            }
            Some(b"unit") if self.units.len() < MAX_PROPERTIES => {
                if let Some(name) = words.next() {
                    self.units.push((string(name), string(trimmed(words.0))));
                }
            }
            _ => {}
        }
    }
}

fn property(mut words: Words) -> Option<Property> {
    let mut kind = words.next()?;
    let mut list = None;
    if kind == b"list" {
        list = Some(kind_of(words.next()?)?);
        kind = words.next()?;
    }
    Some(Property { kind: kind_of(kind)?, list, name: string(words.next()?) })
}
