//! A window of a plane in square blocks, each with the list of what may be in it.

use super::Window;
use crate::math::{DVec2, Vec2};

/// Lists of indices, one a block.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    min: Vec2,
    max: Vec2,
    per_pitch: f32,
    n: [usize; 2],
    starts: Vec<u32>,
    order: Vec<u32>,
}

/// Rounding must not put a place into the next block; parts of a block's width.
const MARGIN: f64 = 1e-3;

impl Blocks {
    /// Blocks about as wide as `pitch`, and in each, in their order, the boxes (least and greatest plane coordinates) that
    /// reach into it.
    pub(super) fn of(window: &Window, pitch: f32, boxes: &[[DVec2; 2]]) -> Self {
        let size = window.max - window.min;
        let pitch = pitch.max(size.max_element() / 1024.0).max(f32::MIN_POSITIVE);
        let n = [size.x, size.y].map(|x| ((x / pitch).floor() as usize + 1).min(2048));
        let mut blocks = Self {
            min: window.min,
            max: window.max,
            per_pitch: 1.0 / pitch,
            n,
            starts: vec![0; n[0] * n[1] + 1],
            order: Vec::new(),
        };
        let ranges: Vec<[usize; 4]> = boxes.iter().map(|b| blocks.range(*b)).collect();
        let for_each = |visit: &mut dyn FnMut(usize, usize)| {
            for (i, [x0, x1, y0, y1]) in ranges.iter().enumerate() {
                for y in *y0..*y1 {
                    (*x0..*x1).for_each(|x| visit(y * n[0] + x, i));
                }
            }
        };
        for_each(&mut |block, _| blocks.starts[block + 1] += 1);
        for k in 1..blocks.starts.len() {
            blocks.starts[k] += blocks.starts[k - 1];
        }
        let mut next = blocks.starts.clone();
        blocks.order = vec![0; next[next.len() - 1] as usize];
        for_each(&mut |block, i| {
            blocks.order[next[block] as usize] = i as u32;
            next[block] += 1;
        });
        blocks
    }

    /// Columns and rows that a box reaches into: first and past the last.
    fn range(&self, [low, high]: [DVec2; 2]) -> [usize; 4] {
        let per = self.per_pitch as f64;
        let of = |k: usize| {
            let from = ((low[k] - self.min[k] as f64) * per - MARGIN).floor().max(0.0);
            let to = ((high[k] - self.min[k] as f64) * per + MARGIN).floor();
            if to < 0.0 { [0, 0] } else { [from as usize, (to as usize + 1).min(self.n[k])] }
        };
        let ([x0, x1], [y0, y1]) = (of(0), of(1));
        [x0, x1.max(x0), y0, y1.max(y0)]
    }

    /// The block of a place; none outside of the window.
    pub(super) fn index(&self, at: Vec2) -> Option<usize> {
        let is_in = at.x >= self.min.x && at.y >= self.min.y && at.x <= self.max.x && at.y <= self.max.y;
        let from = (at - self.min) * self.per_pitch;
        let [x, y] = [0, 1].map(|k| (from[k] as usize).min(self.n[k] - 1));
        is_in.then_some(y * self.n[0] + x)
    }

    /// How many blocks there are.
    pub(super) fn len(&self) -> usize {
        self.n[0] * self.n[1]
    }

    /// What may be in a block.
    pub(super) fn list(&self, block: usize) -> &[u32] {
        &self.order[self.starts[block] as usize..self.starts[block + 1] as usize]
    }

    /// Least and greatest plane coordinates of a block, a little grown.
    pub(super) fn bounds(&self, block: usize) -> [DVec2; 2] {
        let pitch = 1.0 / self.per_pitch as f64;
        let at = DVec2::new((block % self.n[0]) as f64, (block / self.n[0]) as f64);
        [at - MARGIN, at + 1.0 + MARGIN].map(|p| self.min.as_dvec2() + p * pitch)
    }
}
