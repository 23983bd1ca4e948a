//! NumPy's array files (.npy, NEP 1) and archives of them (.npz).

use crate::assets::height_map::{Cell, HeightMap, MAX_READ, looks_like_degrees};
use crate::assets::text::format_error;
use crate::error::Result;
use crate::math::Size;
use std::io::{Cursor, Read};
use std::path::Path;

/// An array of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Lengths along the axes; empty for one number.
    pub shape: Vec<usize>,
    /// The last axis runs fastest.
    pub values: Vec<f64>,
}

/// How numbers are stored.
#[derive(Clone, Copy, Debug)]
struct Head<'a> {
    /// `f4`, `i2` ...
    kind: &'a str,
    is_big: bool,
}

/// Reads an array of integers, floats or truth values in either byte order, the first or the last axis fastest.
pub fn read(bytes: &[u8], path: &Path) -> Result<Array> {
    let bad = |fault: &str| format_error(path, fault);
    if !bytes.starts_with(b"\x93NUMPY") || bytes.len() < 10 {
        return Err(bad("not a NumPy array"));
    }
    let (len, start) = match bytes[6] {
        1 => (u16::from_le_bytes([bytes[8], bytes[9]]) as usize, 10),
        2 | 3 if bytes.len() >= 12 => (u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize, 12),
        _ => return Err(bad("not a version of NumPy's format that is known")),
    };
    let head = bytes[start..].get(..len).ok_or_else(|| bad("the file ends in its head"))?;
    let head = std::str::from_utf8(head).map_err(|_| bad("the head is no text"))?;
    let data = &bytes[start + len..];

    let value = |key: &str| Some(head.split_once(&format!("'{key}'"))?.1.trim_start().strip_prefix(':')?.trim_start());
    let descr = value("descr").and_then(|v| v.strip_prefix('\'')?.split('\'').next());
    let descr = descr.ok_or_else(|| bad("an array of records is no grid of numbers"))?;
    let (order, kind) = descr.split_at_checked(1).unwrap_or_default();
    let shape = value("shape").and_then(|v| v.strip_prefix('(')?.split(')').next());
    let shape = shape.and_then(|s| {
        let lengths = s.split(',').map(str::trim).filter(|s| !s.is_empty());
        lengths.map(|s| s.parse::<usize>().ok()).collect::<Option<Vec<usize>>>()
    });
    let shape = shape.ok_or_else(|| bad("the head names no shape"))?;
    let is_fortran = value("fortran_order").is_some_and(|v| v.starts_with("True"));
    let size = item_size(kind).ok_or_else(|| bad(&format!("numbers of type {descr:?} are not read")))?;
    let n = shape.iter().try_fold(1usize, |n, l| n.checked_mul(*l)).filter(|n| *n as u64 <= MAX_READ);
    let n = n.ok_or_else(|| bad(&format!("an array of shape {shape:?} is too large")))?;
    let data = data.get(..n * size).ok_or_else(|| {
        bad(&format!("an array of shape {shape:?} needs {} bytes, the file has {}", n * size, data.len()))
    })?;
    let mut values = Vec::with_capacity(n);
    let head = Head { kind, is_big: order == ">" };
    values.extend(data.chunks_exact(size).map(|item| head.number(item)));
    if is_fortran && shape.len() == 2 {
        let [rows, columns] = [shape[0], shape[1]];
        values = (0..n).map(|i| values[i % columns * rows + i / columns]).collect();
    }
    Ok(Array { shape, values })
}

fn item_size(kind: &str) -> Option<usize> {
    Some(match kind {
        "b1" | "i1" | "u1" => 1,
        "i2" | "u2" | "f2" => 2,
        "i4" | "u4" | "f4" => 4,
        "i8" | "u8" | "f8" => 8,
        _ => return None,
    })
}

impl Head<'_> {
    fn number(&self, item: &[u8]) -> f64 {
        let mut b = [0; 8];
        b[..item.len()].copy_from_slice(item);
        if self.is_big {
            b[..item.len()].reverse();
        }
        let two = [b[0], b[1]];
        let four = [b[0], b[1], b[2], b[3]];
        match self.kind {
            "i1" => b[0] as i8 as f64,
            "i2" => i16::from_le_bytes(two) as f64,
            "u2" => u16::from_le_bytes(two) as f64,
            "f2" => half(u16::from_le_bytes(two)),
            "i4" => i32::from_le_bytes(four) as f64,
            "u4" => u32::from_le_bytes(four) as f64,
            "f4" => f32::from_le_bytes(four) as f64,
            "i8" => i64::from_le_bytes(b) as f64,
            "u8" => u64::from_le_bytes(b) as f64,
            "f8" => f64::from_le_bytes(b),
            _ => b[0] as f64,
        }
    }
}

/// IEEE 754 half precision.
pub(super) fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = ((bits >> 10 & 31) as i32, (bits & 1023) as f64);
    sign * match exponent {
        0 => fraction / (1 << 24) as f64,
        31 => {
            if fraction == 0.0 {
                f64::INFINITY
            } else {
                f64::NAN
            }
        }
        e => (1024.0 + fraction) * (2f64).powi(e - 25),
    }
}

/// Archives can claim anything: no array may take more memory.
const MAX_UNPACKED: u64 = 256 << 20;

/// All arrays of numbers in an archive, with their names; what is none is passed over.
pub(super) fn read_all(bytes: &[u8], path: &Path) -> Result<Vec<(String, Array)>> {
    let mut archive =
        zip::ZipArchive::new(Cursor::new(bytes)).map_err(|e| format_error(path, format!("not a zip archive: {e}")))?;
    let (mut arrays, mut room) = (Vec::new(), MAX_UNPACKED);
    for i in 0..archive.len().min(4096) {
        let mut data = Vec::new();
        let entry = archive.by_index(i).map_err(|e| format_error(path, e.to_string()))?;
        let Ok(full_name) = entry.name().map(|n| n.into_owned()) else { continue };
        let Some(name) = full_name.strip_suffix(".npy") else { continue };
        let unpacked = entry.take(room).read_to_end(&mut data);
        unpacked.map_err(|e| format_error(path, format!("array {name:?}: {e}")))?;
        room -= data.len() as u64;
        if room == 0 {
            return Err(format_error(path, format!("its arrays unpack to more than {} MiB", MAX_UNPACKED >> 20)));
        }
        if let Ok(array) = read(&data, path) {
            arrays.push((name.to_string(), array));
        }
    }
    Ok(arrays)
}

/// The grid of an archive, with what its other arrays say about the size of cells (`dx`, `dy`, `xmin`, `ymin` ...).
pub(super) fn read_npz(bytes: &[u8], path: &Path, key: Option<&str>) -> Result<HeightMap> {
    let mut archive =
        zip::ZipArchive::new(Cursor::new(bytes)).map_err(|e| format_error(path, format!("not a zip archive: {e}")))?;
    let (mut grid, mut numbers, mut names) = (None, Vec::new(), Vec::new());
    for i in 0..archive.len().min(4096) {
        let mut data = Vec::new();
        let entry = archive.by_index(i).map_err(|e| format_error(path, e.to_string()))?;
        let Ok(full_name) = entry.name().map(|n| n.into_owned()) else { continue };
        let Some(name) = full_name.strip_suffix(".npy") else { continue };
        names.push(name.to_string());
        let is_wanted = key.is_none_or(|k| k == name);
        // A number alone is short; what is long is only unpacked if it may be the grid.
        let most = if is_wanted && grid.is_none() { MAX_UNPACKED } else { 256 };
        let unpacked = entry.take(most).read_to_end(&mut data);
        unpacked.map_err(|e| format_error(path, format!("array {name:?}: {e}")))?;
        if data.len() as u64 == MAX_UNPACKED {
            let fault = format!("array {name:?} unpacks to more than {} MiB", MAX_UNPACKED >> 20);
            return Err(format_error(path, fault));
        }
        match read(&data, path) {
            Ok(array) if is_wanted && array.shape.len() == 2 && grid.is_none() => grid = Some(array),
            Ok(array) if array.values.len() == 1 => numbers.push((name.to_string(), array.values[0])),
            Ok(_) => {}
            Err(why) if key == Some(name) => return Err(why),
            // Cut short on purpose, or no numbers.
            Err(_) => {}
        }
    }
    let Some(grid) = grid else {
        let names = names.join(", ");
        let fault = match key {
            Some(key) => format!("no two-dimensional array {key:?} in it; it holds {names}"),
            None => format!("no two-dimensional array of numbers in it; it holds {names}"),
        };
        return Err(format_error(path, fault));
    };
    height_map(&grid, &numbers, path)
}

/// An array as a height map; `numbers` are what lay beside it.
pub(super) fn height_map(array: &Array, numbers: &[(String, f64)], path: &Path) -> Result<HeightMap> {
    let &[rows, columns] = &array.shape[..] else {
        let fault = format!("an array of shape {:?} is no height map, which has two dimensions", array.shape);
        return Err(format_error(path, fault));
    };
    let [Ok(width), Ok(height)] = [columns, rows].map(u32::try_from) else {
        return Err(format_error(path, "too many cells"));
    };
    let named = |names: &[&str]| numbers.iter().find(|(n, _)| names.contains(&n.as_str())).map(|(_, x)| *x);
    let x = named(&["dx", "cellsize", "cell_size"]).map(f64::abs);
    let y = named(&["dy", "cellsize", "cell_size"]).map(f64::abs);
    let corner = [named(&["xmin"]), named(&["ymin"])];
    let cell = match (x, y, corner) {
        (Some(x), Some(y), [Some(lon), Some(lat)]) if looks_like_degrees([lon, lat], [x, y]) => {
            Cell::Degrees([x, y], lat + y * rows as f64 / 2.0)
        }
        (Some(x), Some(y), _) if x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite() => Cell::Length([x, y]),
        _ => Cell::Unknown,
    };
    let unit = if matches!(cell, Cell::Degrees(..)) { "m" } else { "" };
    let elevation = array.values.iter().map(|x| *x as f32).collect();
    Ok(HeightMap { size: Size::new(width, height), elevation, cell, unit: unit.into() })
}
