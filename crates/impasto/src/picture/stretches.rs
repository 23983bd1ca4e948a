//! Stretches of a tile's rows, put in order by the triangle that shows in them: what is the same all over a triangle is
//! then worked out once, and its cells fill whole vectors.

/// Cells of a row that show one triangle.
#[derive(Clone, Copy)]
struct Stretch {
    cell: u16,
    n: u16,
    /// The triangle's next stretch; the last refers to itself.
    next: u16,
}

/// A triangle's first and last stretch.
#[derive(Clone, Copy)]
struct Chain {
    triangle: u32,
    first: u16,
    last: u16,
}

/// The stretches of a tile. No more than it has cells.
pub(super) struct Stretches {
    stretches: Vec<Stretch>,
    chains: Vec<Chain>,
    /// Which chain, plus one, a triangle with these last bits had. Another one's makes for a second chain, nothing worse.
    seen: [u16; 256],
}

impl Default for Stretches {
    fn default() -> Self {
        Self { stretches: Vec::new(), chains: Vec::new(), seen: [0; 256] }
    }
}

impl Stretches {
    pub(super) fn clear(&mut self) {
        self.stretches.clear();
        self.chains.clear();
        self.seen.fill(0);
    }

    #[inline(always)]
    pub(super) fn push(&mut self, triangle: u32, cell: usize, n: usize) {
        let new = self.stretches.len() as u16;
        self.stretches.push(Stretch { cell: cell as u16, n: n as u16, next: new });
        let seen = &mut self.seen[triangle as usize % 256];
        match self.chains.get_mut((*seen as usize).wrapping_sub(1)) {
            Some(chain) if chain.triangle == triangle => {
                self.stretches[chain.last as usize].next = new;
                chain.last = new;
            }
            _ => {
                self.chains.push(Chain { triangle, first: new, last: new });
                *seen = self.chains.len() as u16;
            }
        }
    }

    /// Calls `take(triangle, first cell, cells)` for all stretches, a triangle's one after the other.
    #[inline(always)]
    pub(super) fn each(&self, mut take: impl FnMut(u32, usize, usize)) {
        for chain in &self.chains {
            let mut at = chain.first;
            loop {
                let Stretch { cell, n, next } = self.stretches[at as usize];
                take(chain.triangle, cell as usize, n as usize);
                if at == chain.last {
                    break;
                }
                at = next;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangles_stretches_follow_each_other_and_none_is_lost() {
        let mut stretches = Stretches::default();
        for round in 0..2 {
            stretches.clear();
            for cell in 0..4096 {
                stretches.push(crate::math::hash(cell / 3 + round) % 700, cell as usize, 1);
            }
            let mut cells = Vec::new();
            let mut n_changes = 0;
            let mut last = None;
            stretches.each(|triangle, cell, n| {
                assert_eq!((triangle, n), (crate::math::hash(cell as u32 / 3 + round) % 700, 1));
                n_changes += (last.replace(triangle) != Some(triangle)) as usize;
                cells.push(cell);
            });
            assert!(n_changes < 4096 / 3, "{n_changes} changes of triangle");
            cells.sort_unstable();
            assert!(cells.into_iter().eq(0..4096));
        }
    }
}
