//! Which isosurface shows a grid, when nobody says.

use crate::assets::Grid;
use crate::assets::isosurface::Side;
use crate::assets::volume::Kind;

/// Isosurfaces, and why these.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// One, or one of the greater values and one of the lesser ones.
    pub levels: Vec<(f64, Side)>,
    /// Words for `info`.
    pub why: &'static str,
}

impl Levels {
    /// One that somebody asked for. A negative level below the mean bounds the values below it, as the negative part of a
    /// potential; all others the values above.
    pub fn asked(grid: &Grid, level: f64) -> Self {
        let is_below = level < 0.0 && level < Moments::of(grid).mean;
        let side = if is_below { Side::Below } else { Side::Above };
        Self { levels: vec![(level, side)], why: "as asked" }
    }

    /// By the kind of file and the values. Nothing for a grid without two different values.
    ///
    /// - Electron densities: 0.002 e/bohr^3, the outline of molecules after Bader et al. (1987).
    /// - Potentials in kT/e: +1 and -1.
    /// - Cubes and OpenDX with values of both signs: +x and -x, such that a twentieth of the points lies inside, and at most
    ///   half of either extreme.
    /// - MRC and CCP4 maps: three standard deviations above the mean.
    /// - All else: Otsu's threshold ("A Threshold Selection Method from Gray-Level Histograms", 1979).
    pub fn automatic(grid: &Grid, kind: Kind) -> Option<Self> {
        let range = grid.range();
        let (min, max) = (range.min, range.max);
        if min >= max {
            return None;
        }
        let one = |level: f64, why| Some(Self { levels: vec![(level, Side::Above)], why });
        let both = |x: f64, why| Some(Self { levels: vec![(x, Side::Above), (-x, Side::Below)], why });
        let may_be_signed = matches!(kind, Kind::Cube | Kind::Dx) && min < 0.0 && max > 0.0;
        match grid.unit.as_str() {
            "e/bohr^3" if min > -1e-3 && max > 0.002 => {
                return one(0.002, "the outline of a molecule by its electron density");
            }
            "kT/e" if min < -1.0 && max > 1.0 => return both(1.0, "one thermal energy either way"),
            _ => {}
        }
        if may_be_signed {
            let x = quantile_of_size(grid, 0.95).min(0.5 * max).min(-0.5 * min);
            if x > 0.0 {
                return both(x, "both signs, a twentieth of the points at most");
            }
        }
        if kind == Kind::Mrc {
            let m = Moments::of(grid);
            let level = m.mean + 3.0 * m.deviation;
            if level < max {
                return one(level, "three standard deviations above the mean");
            }
        }
        one(otsu(grid, min, max), "Otsu's threshold")
    }
}

struct Moments {
    mean: f64,
    deviation: f64,
}

impl Moments {
    fn of(grid: &Grid) -> Self {
        let values = || grid.values().iter().filter(|v| !v.is_nan()).map(|v| *v as f64);
        let n = values().count().max(1) as f64;
        let mean = values().sum::<f64>() / n;
        let deviation = (values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n).sqrt();
        Self { mean, deviation }
    }
}

/// The absolute value that this share of the points does not exceed.
fn quantile_of_size(grid: &Grid, share: f64) -> f64 {
    let mut sizes: Vec<f32> = grid.values().iter().filter(|v| !v.is_nan()).map(|v| v.abs()).collect();
    let n = ((sizes.len() - 1) as f64 * share) as usize;
    *sizes.select_nth_unstable_by(n, f32::total_cmp).1 as f64
}

/// The threshold that best parts the values into two classes: the greatest variance between them.
fn otsu(grid: &Grid, min: f64, max: f64) -> f64 {
    const N: usize = 256;
    let mut counts = [0u64; N];
    for v in grid.values().iter().filter(|v| !v.is_nan()) {
        counts[(((*v as f64 - min) / (max - min)) * N as f64).min((N - 1) as f64) as usize] += 1;
    }
    let n = counts.iter().sum::<u64>() as f64;
    let total = counts.iter().enumerate().map(|(i, c)| i as f64 * *c as f64).sum::<f64>();
    let (mut below, mut sum, mut best) = (0.0, 0.0, (0.0, 0, 0));
    for (i, c) in counts.iter().enumerate().take(N - 1) {
        below += *c as f64;
        sum += i as f64 * *c as f64;
        let apart = sum / below.max(1.0) - (total - sum) / (n - below).max(1.0);
        let variance = below * (n - below) * apart * apart;
        // Between classes that lie apart all thresholds are as good: the middle one.
        if variance > best.0 {
            best = (variance, i, i);
        } else if variance == best.0 && best.0 > 0.0 {
            best.2 = i;
        }
    }
    min + (max - min) * ((best.1 + best.2) as f64 / 2.0 + 1.0) / N as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::Lattice;
    use crate::math::DVec3;

    fn grid(values: Vec<f32>, unit: &str) -> Grid {
        let size = [values.len() as u32, 1, 1];
        let lattice = Lattice { size, origin: DVec3::ZERO, axes: [DVec3::X, DVec3::Y, DVec3::Z] };
        Grid::new(lattice, values).unwrap().named("f", unit)
    }

    #[test]
    fn levels_suit_the_numbers() {
        let ramp = |low: f32, high: f32| (0..1001).map(|i| low + (high - low) * i as f32 / 1000.0).collect::<Vec<_>>();
        let levels = |g: &Grid, kind| Levels::automatic(g, kind).unwrap().levels;
        assert_eq!(levels(&grid(ramp(0.0, 9.0), "e/bohr^3"), Kind::Cube), [(0.002, Side::Above)]);
        let both = [(1.0, Side::Above), (-1.0, Side::Below)];
        assert_eq!(levels(&grid(ramp(-3.0, 9.0), "kT/e"), Kind::Dx), both);
        let orbital = levels(&grid(ramp(-1.0, 1.0), ""), Kind::Cube);
        assert_eq!(orbital, [(0.5, Side::Above), (-0.5, Side::Below)]);
        let mut map = vec![0.0; 999];
        map.push(100.0);
        let [(level, _)] = levels(&grid(map, ""), Kind::Mrc)[..] else { panic!() };
        assert!((level - (0.1 + 3.0 * 3.1607)).abs() < 0.01, "{level}");
        let two = (0..100).map(|i| if i % 3 == 0 { 10.0 } else { -6.0 }).collect();
        let [(level, _)] = levels(&grid(two, ""), Kind::Nrrd)[..] else { panic!() };
        assert!((level - 2.0).abs() < 0.1, "{level}");
        assert_eq!(Levels::automatic(&grid(vec![2.0; 9], ""), Kind::Cube), None);
        assert_eq!(Levels::automatic(&grid(vec![f32::NAN; 9], ""), Kind::Cube), None);
        let asked = |level| Levels::asked(&grid(ramp(-1.0, 1.0), ""), level).levels[0].1;
        assert_eq!([asked(0.2), asked(-0.2)], [Side::Above, Side::Below]);
    }
}
