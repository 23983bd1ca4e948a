//! Numbers in binary files: kinds, byte orders, and arrays of them.

use crate::assets::Values;

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    /// Bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Whether f32 holds all its values exactly.
    pub(super) fn fits_f32(self) -> bool {
        matches!(self, Self::I8 | Self::U8 | Self::I16 | Self::U16 | Self::F32)
    }

    /// Whether it is a kind for measures rather than counts.
    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// The number in the first `size` bytes.
    #[inline]
    pub(super) fn number(self, bytes: &[u8], little: bool) -> f64 {
        match self {
            Self::I8 => bytes[0] as i8 as f64,
            Self::U8 => bytes[0] as f64,
            Self::I16 => i16::from_le_bytes(ordered(bytes, little)) as f64,
            Self::U16 => u16::from_le_bytes(ordered(bytes, little)) as f64,
            Self::I32 => i32::from_le_bytes(ordered(bytes, little)) as f64,
            Self::U32 => u32::from_le_bytes(ordered(bytes, little)) as f64,
            Self::I64 => i64::from_le_bytes(ordered(bytes, little)) as f64,
            Self::U64 => u64::from_le_bytes(ordered(bytes, little)) as f64,
            Self::F32 => f32::from_le_bytes(ordered(bytes, little)) as f64,
            Self::F64 => f64::from_le_bytes(ordered(bytes, little)),
        }
    }

    /// All whole numbers in the bytes, in the least type of a field that holds them.
    pub(super) fn values(self, bytes: &[u8], little: bool) -> Values {
        let items = bytes.chunks_exact(self.size());
        match self.fits_f32() {
            true => Values::F32(items.map(|b| self.number(b, little) as f32).collect()),
            false => Values::F64(items.map(|b| self.number(b, little)).collect()),
        }
    }

    /// No numbers yet, of the type that `values` gives.
    pub(super) fn no_values(self) -> Values {
        if self.fits_f32() { Values::F32(Vec::new()) } else { Values::F64(Vec::new()) }
    }
}

/// The first bytes, the least significant one first.
#[inline(always)]
fn ordered<const N: usize>(bytes: &[u8], little: bool) -> [u8; N] {
    let mut b = [0; N];
    b.copy_from_slice(&bytes[..N]);
    if !little {
        b.reverse();
    }
    b
}

impl Values {
    /// Appends a number.
    pub(super) fn push(&mut self, x: f64) {
        match self {
            Self::F32(v) => v.push(x as f32),
            Self::F64(v) => v.push(x),
        }
    }

    /// Appends all of another's numbers; f32 becomes f64 where it must.
    pub(super) fn append(&mut self, other: Self) {
        match (&mut *self, other) {
            (Self::F32(a), Self::F32(b)) => a.extend(b),
            (Self::F32(a), Self::F64(b)) => {
                let mut wide: Vec<f64> = a.iter().map(|x| *x as f64).collect();
                wide.extend(b);
                *self = Self::F64(wide);
            }
            (Self::F64(a), b) => a.extend((0..b.len()).map(|i| b.at(i))),
        }
    }

    /// All numbers.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.len()).map(|i| self.at(i))
    }
}

/// A number as an index; one that is none becomes an index out of range.
pub(super) fn index(x: f64) -> u32 {
    if x >= 0.0 && x < u32::MAX as f64 { x as u32 } else { u32::MAX }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_come_in_both_byte_orders() {
        assert_eq!(Kind::I16.values(&[1, 0, 255, 255, 7], true), Values::F32(vec![1.0, -1.0]));
        assert_eq!(Kind::I64.values(&[0, 0, 0, 0, 0, 0, 1, 2], false), Values::F64(vec![258.0]));
        let mut values = Kind::U8.values(&[1], true);
        values.append(Kind::F64.values(&2.5f64.to_be_bytes(), false));
        assert_eq!(values, Values::F64(vec![1.0, 2.5]));
        assert_eq!((index(3.0), index(-1.0), index(f64::NAN)), (3, u32::MAX, u32::MAX));
    }
}
