//! Truths about development: bytes come back, curves rise, edges have no fringe, levels agree.

use super::*;
use crate::color::{LINEAR_FROM_SRGB8, srgb_from_linear};
use crate::math::{hash, unit_float};
use crate::picture::lanes::tests::at_every_level;
use fearless_simd::dispatch;

fn bytes(develop: Develop, cells: &[LinearRgba], under: Option<LinearRgb>) -> Vec<[u8; 4]> {
    let mut out = vec![[0; 4]; cells.len()];
    let level = fearless_simd::Level::new();
    dispatch!(level, simd => develop.rgba8(simd, cells, under, 3, &mut out));
    out
}

#[test]
fn plain_gives_back_every_srgb_byte() {
    let cells: Vec<LinearRgba> = LINEAR_FROM_SRGB8.iter().map(|v| [*v, *v, *v, 1.0]).collect();
    for under in [None, Some([0.3, 0.2, 0.1])] {
        let got = bytes(Develop::PLAIN, &cells, under);
        assert!(got.iter().enumerate().all(|(i, b)| *b == [i as u8, i as u8, i as u8, 255]));
    }
    let linear = Develop { encoding: Encoding::Linear, ..Develop::PLAIN };
    let cells: Vec<LinearRgba> = (0..256).map(|i| [i as f32 / 255.0, 0.0, 1.0, 1.0]).collect();
    assert!(bytes(linear, &cells, None).iter().enumerate().all(|(i, b)| *b == [i as u8, 0, 255, 255]));
}

#[test]
fn filmic_is_the_identity_below_the_knee_and_rises_to_white() {
    let develop = Develop::default();
    let mut last = [0.0; 3];
    for i in 0..=7000 {
        let x = i as f32 * 1e-3;
        let got = develop.color([x; 3]);
        assert!(got[0] >= last[0] && got[0] <= 1.0, "{x} gives {got:?} after {last:?}");
        assert!(got[0] - last[0] < 1.001e-3 + 1e-6, "the curve is nowhere steeper than 1");
        if x <= KNEE {
            assert_eq!(got, [x; 3]);
        }
        last = got;
    }
    assert!(develop.color([WHITE; 3])[0] > 0.99999);
    // Saturated light keeps the order of its channels and fades to white.
    let lamp = |k: f32| develop.color([k, 0.5 * k, 0.1 * k]);
    for k in [0.5, 1.0, 2.0, 4.0, 5.9] {
        let [r, g, b] = lamp(k);
        assert!(r > g && g > b, "{k}");
    }
    assert!(lamp(4.0)[2] / lamp(4.0)[0] > 3.0 * 0.1, "bright light fades to white");
}

#[test]
fn exposure_counts_in_stops() {
    let develop = Develop { exposure: -2.0, ..Develop::PLAIN };
    assert_eq!(develop.color([0.8, 0.4, 0.2]), [0.2, 0.1, 0.05]);
}

#[test]
fn half_covered_edges_have_no_dark_fringe() {
    // A red surface over a quarter of the pixel; premultiplied.
    let red = [LINEAR_FROM_SRGB8[200], LINEAR_FROM_SRGB8[40], LINEAR_FROM_SRGB8[30]];
    let edge = [[red[0] * 0.25, red[1] * 0.25, red[2] * 0.25, 0.25]];
    for curve in [Curve::Plain, Curve::Filmic] {
        let got = bytes(Develop { curve, ..Develop::PLAIN }, &edge, None)[0];
        assert_eq!(got, [200, 40, 30, 64]);
    }
    assert_eq!(bytes(Develop::default(), &[[0.0; 4]], None)[0], [0, 0, 0, 0]);
    // The curve leaves the background alone.
    let paper = LINEAR_FROM_SRGB8[244];
    assert_eq!(bytes(Develop::default(), &[[0.0; 4]], Some([paper; 3]))[0], [244, 244, 244, 255]);
}

#[test]
fn broken_numbers_are_black_or_white() {
    let cells = [[f32::NAN, f32::INFINITY, -1.0, 1.0], [f32::NEG_INFINITY, 1e30, 0.0, f32::NAN]];
    let got = bytes(Develop::PLAIN, &cells, None);
    assert_eq!(got[0], [0, 255, 0, 255]);
    assert_eq!(got[1][3], 0);
}

#[test]
fn sixteen_bits_are_within_one_step_of_the_exact_curve() {
    let cells: Vec<LinearRgba> = (0..20_000).map(|i| [i as f32 / 19_999.0, 0.0, 1.0, 1.0]).collect();
    let mut out = vec![[0; 4]; cells.len()];
    dispatch!(fearless_simd::Level::new(), simd => Develop::PLAIN.rgba16(simd, &cells, None, &mut out));
    for (cell, out) in cells.iter().zip(out) {
        let truth = srgb_from_linear(cell[0] as f64) * 65535.0;
        assert!((out[0] as f64 - truth).abs() < 1.0 && out[1..] == [0, 65535, 65535], "{cell:?} gives {out:?}");
    }
}

#[test]
fn dither_keeps_the_mean() {
    let develop = Develop { dither: true, encoding: Encoding::Linear, ..Develop::PLAIN };
    let value = 100.3 / 255.0;
    let mut sum = 0;
    for y in 0..8 {
        let mut out = [[0; 4]; 8];
        let cells = [[value, value, value, 1.0]; 8];
        dispatch!(fearless_simd::Level::new(), simd => develop.rgba8(simd, &cells, None, y, &mut out));
        sum += out.iter().map(|p| p[0] as u32).sum::<u32>();
    }
    assert!((sum as f32 / 64.0 - 100.3).abs() < 0.02, "{sum}");
}

#[test]
fn every_level_gives_the_same_bytes() {
    let f = |i: u32, s: u32| unit_float(hash(i ^ hash(s)));
    let cells: Vec<LinearRgba> =
        (0..1003).map(|i| [f(i, 1) * 3.0, f(i, 2), f(i, 3) * 8.0, if i % 3 == 0 { f(i, 4) } else { 1.0 }]).collect();
    for develop in [
        Develop { exposure: 0.3, ..Develop::default() },
        Develop { dither: true, ..Develop::default() },
        Develop { encoding: Encoding::Linear, ..Develop::PLAIN },
    ] {
        for under in [None, Some([0.9, 0.8, 0.7])] {
            let mut wanted: Option<Vec<[u8; 4]>> = None;
            at_every_level(|name, level| {
                let mut out = vec![[0; 4]; cells.len()];
                dispatch!(level, simd => develop.rgba8(simd, &cells, under, 5, &mut out));
                let wanted = wanted.get_or_insert_with(|| out.clone());
                assert!(*wanted == out, "{name} differs from scalar");
                // A cell alone gives what it gives in its row; the dither pattern belongs to the place.
                for (i, cell) in cells.iter().enumerate().take(if develop.dither { 1 } else { 40 }) {
                    let mut one = [[0; 4]];
                    dispatch!(level, simd => develop.rgba8(simd, &[*cell], under, 5, &mut one));
                    assert_eq!(one[0], out[i], "{name}, cell {i}");
                }
            });
        }
    }
}
