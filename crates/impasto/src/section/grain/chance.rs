//! What each cell draws: a pure function of its integer coordinates and the seed.
//!
//! Integers are mixed as u32 and become floats of 24 bits, so that a graphics card has the same numbers.

use super::spec::Chance;
use crate::math::{Vec3, hash, hash_cell, unit_float, vec3};
use crate::noise::{Lattice, gradient_3d};

/// Texels a side of the paper's noise texture.
const N_TEXELS: i32 = 256;

/// Where the numbers come from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    pub(super) chance: Chance,
    pub(super) seed: u32,
}

impl Source {
    /// Names a cell's particle; never 0.
    pub(super) fn id(self, cell: [i32; 3]) -> u32 {
        self.hash(cell).max(1)
    }

    fn hash(self, cell: [i32; 3]) -> u32 {
        hash_cell(cell[0], cell[1], cell[2], self.seed)
    }

    /// Which way the centre moves: each in [-1, 1].
    pub(super) fn center(self, cell: [i32; 3]) -> Vec3 {
        match self.chance {
            Chance::Hash => {
                let h = self.hash(cell);
                vec3(signed(h, 1), signed(h, 2), signed(h, 3))
            }
            Chance::Noise { frequency } => self.texel(cell, frequency, 0),
        }
    }

    /// How radius and height differ: each in [-1, 1].
    pub(super) fn sizes(self, cell: [i32; 3]) -> [f32; 2] {
        match self.chance {
            Chance::Hash => {
                let h = self.hash(cell);
                [signed(h, 4), signed(h, 5)]
            }
            Chance::Noise { frequency } => [self.channel(cell, frequency, 3); 2],
        }
    }

    /// A vector that perturbs an axis: each in [-1, 1].
    pub(super) fn tilt(self, cell: [i32; 3]) -> Vec3 {
        match self.chance {
            Chance::Hash => {
                let h = self.hash(cell);
                vec3(signed(h, 6), signed(h, 7), signed(h, 8))
            }
            Chance::Noise { frequency } => self.texel(cell, frequency, 4),
        }
    }

    /// Even numbers in [0, 1) for directions and turns; from the hash in any case, as noise is not even.
    pub(super) fn even(self, cell: [i32; 3]) -> [f32; 3] {
        let h = self.hash(cell);
        [9, 10, 11].map(|k| unit_float(hash(h.wrapping_add(k))))
    }

    /// Three channels of the noise texture from `first` on.
    fn texel(self, cell: [i32; 3], frequency: f32, first: u32) -> Vec3 {
        vec3(
            self.channel(cell, frequency, first),
            self.channel(cell, frequency, first + 1),
            self.channel(cell, frequency, first + 2),
        )
    }

    /// A channel of the noise texture at a cell's texel, made when asked for: 2q - 1 in the paper's words.
    fn channel(self, cell: [i32; 3], frequency: f32, channel: u32) -> f32 {
        let at = cell.map(|x| x.rem_euclid(N_TEXELS) as f32 * frequency);
        // Off the lattice in all axes, where the noise is zero.
        let p = Vec3::from_array(at) + vec3(0.31, 0.47, 0.73);
        gradient_3d(p, Lattice::seeded(self.seed.wrapping_mul(8).wrapping_add(channel))).value
    }
}

/// The `k`th number of a cell, in [-1, 1).
fn signed(h: u32, k: u32) -> f32 {
    unit_float(hash(h.wrapping_add(k))) * 2.0 - 1.0
}
