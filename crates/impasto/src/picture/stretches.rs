//! Stretches of a tile's rows, put in order by the triangle that shows in them: what is the same all over a triangle is
//! then worked out once, and its cells fill whole vectors.

use crate::visibility::{Hit, TILE};

/// Cells of a row that show one triangle.
#[derive(Clone, Copy, Default)]
struct Stretch {
    cell: u16,
    n: u16,
    /// The triangle's next stretch; the last refers to itself.
    next: u16,
}

/// A triangle and its stretches.
#[derive(Clone, Copy)]
struct Chain {
    triangle: u32,
    of: Of,
}

impl Chain {
    const NONE: Self = Self { triangle: Hit::NOTHING, of: Of { first: 0, last: 0 } };
}

/// Where a triangle's stretches are.
#[derive(Clone, Copy)]
pub(super) struct Of {
    first: u16,
    last: u16,
}

/// A power of two, so that a remainder keeps any index within.
const CELLS: usize = TILE * TILE;

/// The stretches of a tile. No more than it has cells.
pub(super) struct Stretches {
    n: usize,
    stretches: [Stretch; CELLS],
    n_chains: usize,
    chains: [Chain; CELLS],
    /// The chain that a triangle with these last bits had. Another one's makes for a second chain, nothing worse.
    seen: [u16; 256],
}

impl Default for Stretches {
    fn default() -> Self {
        Self { n: 0, stretches: [Stretch::default(); CELLS], n_chains: 0, chains: [Chain::NONE; CELLS], seen: [0; 256] }
    }
}

impl Stretches {
    pub(super) fn clear(&mut self) {
        (self.n, self.n_chains) = (0, 0);
        // What has not been seen has the first chain, whoever that is.
        self.chains[0] = Chain::NONE;
        self.seen.fill(0);
    }

    #[inline(always)]
    pub(super) fn push(&mut self, triangle: u32, cell: usize, n: usize) {
        let new = self.n as u16;
        self.stretches[self.n % CELLS] = Stretch { cell: cell as u16, n: n as u16, next: new };
        self.n += 1;
        let seen = &mut self.seen[triangle as usize % 256];
        let chain = &mut self.chains[*seen as usize % CELLS];
        if chain.triangle == triangle {
            self.stretches[chain.of.last as usize % CELLS].next = new;
            chain.of.last = new;
        } else {
            *seen = self.n_chains as u16;
            self.chains[self.n_chains % CELLS] = Chain { triangle, of: Of { first: new, last: new } };
            self.n_chains += 1;
        }
    }

    /// The triangles that show, and where to find their stretches; one may come again.
    pub(super) fn triangles(&self) -> impl Iterator<Item = (u32, Of)> {
        self.chains[..self.n_chains].iter().map(|chain| (chain.triangle, chain.of))
    }

    /// Calls `take(first cell, cells)` for a triangle's stretches.
    #[inline(always)]
    pub(super) fn each(&self, of: Of, mut take: impl FnMut(usize, usize)) {
        let mut at = of.first;
        loop {
            let Stretch { cell, n, next } = self.stretches[at as usize % CELLS];
            take(cell as usize, n as usize);
            if at == of.last {
                break;
            }
            at = next;
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
            for (triangle, of) in stretches.triangles() {
                stretches.each(of, |cell, n| {
                    assert_eq!((triangle, n), (crate::math::hash(cell as u32 / 3 + round) % 700, 1));
                    cells.push(cell);
                });
            }
            let n_chains = stretches.triangles().count();
            assert!(n_chains < 4096 / 3, "{n_chains} chains");
            cells.sort_unstable();
            assert!(cells.into_iter().eq(0..4096));
        }
    }
}
