//! Rows of cells to rows of pixels: what light left, what was developed before, and the background.

use crate::color::LinearRgb;
use crate::math::Size;
use crate::par::Workers;
use crate::picture::render::Cells;
use crate::picture::{Background, Develop};
use fearless_simd::{dispatch, prelude::*, u32x8};

/// Develops the rows of a picture before a background.
pub struct Film<'a> {
    develop: &'a Develop,
    workers: &'a Workers,
    /// The background's colour behind each row, and the pixel where nothing is.
    rows: Vec<(Option<LinearRgb>, [u8; 4])>,
}

/// Pixels that are chosen together.
const LANES: usize = 8;

impl<'a> Film<'a> {
    /// For a picture of `size`.
    pub fn new(develop: &'a Develop, background: &Background, size: Size, workers: &'a Workers) -> Self {
        let mut last: Option<(Option<LinearRgb>, [u8; 4])> = None;
        let row = |y| {
            let under = background.row(y, size);
            // Rows alike have one pixel, but for the dither pattern.
            let row = last.filter(|last| last.0 == under && !develop.dither).unwrap_or_else(|| {
                let mut pixel = [[0; 4]];
                super::develop_row(develop, workers, &[[0.0; 4]], under, y, &mut pixel);
                (under, pixel[0])
            });
            last = Some(row);
            row
        };
        Self { develop, workers, rows: (0..size.height).map(row).collect() }
    }

    /// Pixels of a run of cells in row `y`.
    pub fn row(&self, y: u32, cells: Cells, out: &mut [[u8; 4]]) {
        let Cells { light, is_dark, developed } = cells;
        let (under, nothing) = self.rows[y as usize];
        if !is_dark || self.develop.dither {
            dispatch!(self.workers.level(), simd => {
                self.develop.rgba8(simd, light, under, y, out);
                lay_over(simd, developed, None, out);
            });
        } else if developed.is_empty() {
            out.fill(nothing);
        } else {
            dispatch!(self.workers.level(), simd => lay_over(simd, developed, Some(nothing), out));
        }
    }
}

/// Puts developed pixels where there are any; elsewhere `out` gets one pixel, or stays.
#[inline(always)]
fn lay_over<S: Simd>(simd: S, developed: &[u32], nothing: Option<[u8; 4]>, out: &mut [[u8; 4]]) {
    let n = out.len().min(developed.len());
    let n_eights = n / LANES;
    for k in 0..n_eights {
        let out = &mut out[k * LANES..(k + 1) * LANES];
        let pixels = u32x8::from_slice(simd, &developed[k * LANES..(k + 1) * LANES]);
        let under = match nothing {
            Some(nothing) => u32x8::splat(simd, u32::from_le_bytes(nothing)),
            None => {
                let mut under = [0; LANES];
                (0..LANES).for_each(|i| under[i] = u32::from_le_bytes(out[i]));
                u32x8::load_array(simd, under)
            }
        };
        let mut chosen = [0; LANES];
        pixels.simd_eq(0).select(under, pixels).store_array(&mut chosen);
        (0..LANES).for_each(|i| out[i] = chosen[i].to_le_bytes());
    }
    for i in n_eights * LANES..n {
        out[i] = if developed[i] != 0 { developed[i].to_le_bytes() } else { nothing.unwrap_or(out[i]) };
    }
}
