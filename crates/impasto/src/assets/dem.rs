//! USGS digital elevation models as text (National Mapping Program Technical Instructions, "Standards for Digital
//! Elevation Models", 1998): blocks of 1024 characters with numbers at fixed places.
//!
//! A file has a head (record A) and one record B a profile, which runs from south to north; profiles follow each other to
//! the east. A file cut short gives the profiles that are there.

use crate::assets::height_map::{Cell, HeightMap};
use crate::assets::text::{self, format_error};
use crate::error::{Mended, Result, note};
use crate::math::Size;
use std::path::Path;

const BLOCK: usize = 1024;
/// In the file's numbers.
const MISSING: f64 = -32767.0;
/// Elevations in a profile's first block, and in each that follows.
const IN_FIRST: usize = 146;
const IN_OTHERS: usize = 170;
const MAX_SIDE: f64 = 30_000.0;

/// A column of elevations from south to north.
struct Profile {
    x: f64,
    y: f64,
    elevation: Vec<f32>,
}

/// Reads a DEM; reports what is missing.
pub(super) fn read(bytes: &[u8], path: &Path, mended: &mut Vec<Mended>) -> Result<HeightMap> {
    // Some copies have line ends between blocks.
    let text: Vec<u8> = bytes.iter().copied().filter(|b| *b != b'\n' && *b != b'\r').collect();
    let bad = |fault: &str| format_error(path, format!("not a USGS DEM: {fault}"));
    if text.len() < 864 || !text[144..864].iter().all(|b| b.is_ascii_graphic() || *b == b' ') {
        return Err(bad("no head of 864 characters"));
    }
    let [ground_unit, elevation_unit] = [(528, 6), (534, 6)].map(|(at, n)| number(&text, at, n).unwrap_or(0.0));
    let [Some(dx), Some(dy), Some(dz)] = [816, 828, 840].map(|at| number(&text, at, 12)) else {
        return Err(bad("no spatial resolution"));
    };
    if !(dx > 0.0 && dy > 0.0 && dz > 0.0) {
        return Err(bad("the spatial resolution is not positive"));
    }
    let n_claimed = number(&text, 858, 6).unwrap_or(0.0).clamp(0.0, 1e9) as usize;

    let mut profiles = Vec::new();
    let mut at = BLOCK;
    while let Some((profile, end)) = read_profile(&text, at, dz) {
        at = end;
        // Record C, the statistics of accuracy, has no profile.
        if !profile.elevation.is_empty() && (profile.x, profile.y) != (0.0, 0.0) {
            profiles.push(profile);
        }
    }
    if profiles.is_empty() {
        return Err(bad("no profile of elevations"));
    }
    note(mended, n_claimed.saturating_sub(profiles.len()), format!("profiles of {n_claimed} are not in the file"));
    grid(&profiles, [dx, dy], path, mended).map(|(size, elevation)| {
        let unit = if elevation_unit == 1.0 { "ft" } else { "m" };
        // Distances are brought to the unit of the elevations.
        let metres = if elevation_unit == 1.0 { 0.3048 } else { 1.0 };
        let cell = match ground_unit {
            3.0 => Cell::Degrees([dx / 3600.0, dy / 3600.0], profiles[0].y / 3600.0),
            1.0 => Cell::Length([dx * 0.3048 / metres, dy * 0.3048 / metres]),
            _ => Cell::Length([dx / metres, dy / metres]),
        };
        HeightMap { size, elevation, cell, unit: unit.into() }
    })
}

/// A number in `n` characters at `at`, with Fortran's exponents.
fn number(text: &[u8], at: usize, n: usize) -> Option<f64> {
    let field: Vec<u8> =
        text.get(at..(at + n).min(text.len()))?.iter().map(|b| if *b == b'D' { b'E' } else { *b }).collect();
    text::number(text::trimmed(&field)).filter(|x| x.is_finite())
}

/// The profile at `at`, and where the next begins. None at the file's end.
fn read_profile(text: &[u8], at: usize, dz: f64) -> Option<(Profile, usize)> {
    let n = number(text, at + 12, 6)?;
    let [x, y, datum] = [24, 48, 72].map(|i| number(text, at + i, 24));
    let (x, y, datum) = (x?, y?, datum?);
    if !(1.0..=MAX_SIDE).contains(&n) {
        return None;
    }
    let n = n as usize;
    let mut elevation = Vec::new();
    let mut fields = (0..n).map(|i| match i.checked_sub(IN_FIRST) {
        None => at + 144 + 6 * i,
        Some(i) => at + BLOCK * (1 + i / IN_OTHERS) + 6 * (i % IN_OTHERS),
    });
    // A file cut short ends within a profile; its last number may have lost digits.
    while let Some(field) = fields.next().filter(|f| f + 6 <= text.len()) {
        let value = number(text, field, 6).filter(|v| *v != MISSING);
        elevation.push(value.map_or(f32::NAN, |v| (v * dz + datum) as f32));
    }
    let n_blocks = 1 + n.saturating_sub(IN_FIRST).div_ceil(IN_OTHERS);
    Some((Profile { x, y, elevation }, at + n_blocks * BLOCK))
}

/// Lays profiles, which begin at different latitudes, side by side.
fn grid(profiles: &[Profile], [dx, dy]: [f64; 2], path: &Path, mended: &mut Vec<Mended>) -> Result<(Size, Vec<f32>)> {
    let least = |f: fn(&Profile) -> f64| profiles.iter().map(f).fold(f64::INFINITY, f64::min);
    let (west, south) = (least(|p| p.x), least(|p| p.y));
    let column = |p: &Profile| ((p.x - west) / dx).round();
    let row = |p: &Profile| ((p.y - south) / dy).round();
    let width = 1.0 + profiles.iter().map(column).fold(0.0, f64::max);
    let height = profiles.iter().map(|p| row(p) + p.elevation.len() as f64).fold(0.0, f64::max);
    let n_values: usize = profiles.iter().map(|p| p.elevation.len()).sum();
    // Profiles lie side by side: a grid far larger than its values has misplaced ones.
    if width > MAX_SIDE || height > MAX_SIDE || width * height > 64.0 * n_values as f64 + 4096.0 {
        return Err(format_error(path, format!("profiles are scattered over {width} x {height} cells")));
    }
    let (w, h) = (width as usize, height as usize);
    let mut elevation = vec![f32::NAN; w * h];
    let mut n_twice = 0;
    for p in profiles {
        for (i, &e) in p.elevation.iter().enumerate() {
            let cell = &mut elevation[(h - 1 - row(p) as usize - i) * w + column(p) as usize];
            n_twice += (!cell.is_nan()) as usize;
            *cell = e;
        }
    }
    note(mended, n_twice, "cells given twice; the last counts");
    Ok((Size::new(w as u32, h as u32), elevation))
}
