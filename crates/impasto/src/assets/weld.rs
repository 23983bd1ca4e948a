//! Which vertices stand at the same place? Equal positions are welded exactly: same numbers, -0 equals 0.

use crate::math::Vec3;

/// An open-addressing table of indices: tells whether an equal item was seen before. What is equal the caller decides.
///
/// Nothing is ever enumerated in the table's order, so its hash has no influence on results.
pub(super) struct Seen {
    slots: Vec<u32>,
    n: usize,
}

const FREE: u32 = u32::MAX;

impl Seen {
    /// With room for about `n` items.
    pub(super) fn with_capacity(n: usize) -> Self {
        Self { slots: vec![FREE; (n * 3 / 2 + 8).next_power_of_two()], n: 0 }
    }

    /// The index of the item seen before that `equals` this one; else `new` is remembered under `hash`.
    #[inline]
    pub(super) fn find_or_insert(
        &mut self,
        hash: u64,
        new: u32,
        equals: impl Fn(u32) -> bool,
        hash_of: impl Fn(u32) -> u64,
    ) -> Option<u32> {
        if self.n * 8 >= self.slots.len() * 7 {
            self.grow(hash_of);
        }
        let mask = self.slots.len() - 1;
        let mut i = spread(hash) & mask;
        loop {
            match self.slots[i] {
                FREE => {
                    self.slots[i] = new;
                    self.n += 1;
                    return None;
                }
                old if equals(old) => return Some(old),
                _ => i = (i + 1) & mask,
            }
        }
    }

    #[cold]
    fn grow(&mut self, hash_of: impl Fn(u32) -> u64) {
        let mut slots = vec![FREE; self.slots.len() * 2];
        let mask = slots.len() - 1;
        for &item in self.slots.iter().filter(|s| **s != FREE) {
            let mut i = spread(hash_of(item)) & mask;
            while slots[i] != FREE {
                i = (i + 1) & mask;
            }
            slots[i] = item;
        }
        self.slots = slots;
    }
}

#[inline]
fn spread(hash: u64) -> usize {
    (hash ^ (hash >> 32)) as usize
}

/// A hash of three numbers: equal numbers, equal hash.
#[inline]
pub(super) fn hash3(a: u32, b: u32, c: u32) -> u64 {
    let h = (a as u64 | (b as u64) << 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let h = (h ^ (h >> 29) ^ c as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h ^ (h >> 31)
}

/// A hash of a position in which -0 equals 0.
#[inline]
pub(super) fn hash_position(p: Vec3) -> u64 {
    let [x, y, z] = (p + Vec3::ZERO).to_array().map(f32::to_bits);
    hash3(x, y, z)
}

/// For each vertex, the first one at the same place.
pub(super) struct Weld {
    /// Empty when all places differ.
    first: Vec<u32>,
}

impl Weld {
    /// Welds finite positions. Linear in time.
    pub(super) fn of(positions: &[Vec3]) -> Self {
        let mut seen = Seen::with_capacity(positions.len());
        let mut first: Vec<u32> = Vec::new();
        for (i, &p) in positions.iter().enumerate() {
            let found = seen.find_or_insert(
                hash_position(p),
                i as u32,
                |old| positions[old as usize] == p,
                |old| hash_position(positions[old as usize]),
            );
            match found {
                Some(old) => {
                    // Most meshes have no equal positions: the list is made at the first.
                    if first.is_empty() {
                        first.reserve_exact(positions.len());
                        first.extend(0..i as u32);
                    }
                    first.push(old);
                }
                None if first.is_empty() => {}
                None => first.push(i as u32),
            }
        }
        Self { first }
    }

    /// The vertex that stands for `vertex`'s place.
    #[inline(always)]
    pub(super) fn at(&self, vertex: u32) -> u32 {
        if self.first.is_empty() { vertex } else { self.first[vertex as usize] }
    }

    /// The places of a triangle's corners.
    #[inline(always)]
    pub(super) fn corners(&self, triangle: [u32; 3]) -> [u32; 3] {
        triangle.map(|v| self.at(v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{hash_cell, vec3};

    #[test]
    fn equal_positions_are_welded_as_a_slow_search_does_it() {
        let f = |i, k| (hash_cell(i, k, 0, 1) % 7) as f32 * if k == 0 { -0.0 } else { 1.5 };
        let positions: Vec<Vec3> = (0..500).map(|i| vec3(f(i, 0) * 0.0, f(i, 1), f(i, 2))).collect();
        let weld = Weld::of(&positions);
        let slow = |p: Vec3| positions.iter().position(|q| *q == p).unwrap() as u32;
        assert!((0..500).all(|i| weld.at(i) == slow(positions[i as usize])));
        assert_eq!((0..500).filter(|&i| weld.at(i) == i).count(), 49);
    }
}
