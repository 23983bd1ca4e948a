//! Truths about marks.

use super::*;

const TALL: Room = Room { length: 430.0, text_size: 16.0, is_horizontal: false };
const SMALL: Room = Room { length: 100.0, text_size: 10.0, is_horizontal: false };

fn labels(ticks: &Ticks) -> String {
    ticks.major.iter().map(|t| t.label.as_str()).collect::<Vec<_>>().join(" ")
}

fn check(scale: LegendScale, range: [f64; 2], room: Room, expected: &str) {
    let ticks = ticks(scale, range, Notation::Auto, room);
    assert_eq!(labels(&ticks), expected, "{scale:?} {range:?}");
}

#[test]
fn linear_ticks_are_round() {
    use LegendScale::Linear;
    check(Linear, [0.0, 1.0], TALL, "0.0 0.2 0.4 0.6 0.8 1.0");
    check(Linear, [0.0, 1.0], SMALL, "0.0 0.5 1.0");
    check(Linear, [0.0, 10.0], TALL, "0 2 4 6 8 10");
    check(Linear, [-1.26, 1.75], TALL, "−1.0 −0.5 0.0 0.5 1.0 1.5");
    check(Linear, [-3.0, 50.0], TALL, "0 10 20 30 40 50");
    check(Linear, [0.31, 0.39], SMALL, "0.325 0.350 0.375");
    check(Linear, [270.2, 301.9], TALL, "275 280 285 290 295 300");
    check(Linear, [0.0, 250_000.0], SMALL, "0 100 200");
    check(Linear, [1.0, 0.0], SMALL, "0.0 0.5 1.0");
}

#[test]
fn zero_is_a_tick_of_every_range_that_holds_it() {
    for (i, scale) in [LegendScale::Linear, LegendScale::SymLog { linear_up_to: 0.1 }].iter().enumerate() {
        for k in 0..200 {
            let (low, high) = (-0.37 * (k as f64 + 1.0), 0.013 * (k * k + 1) as f64);
            for room in [TALL, SMALL] {
                let ticks = ticks(*scale, [low, high], Notation::Auto, room);
                let n_zeros = ticks.major.iter().filter(|t| t.value == 0.0).count();
                assert_eq!(n_zeros, 1, "{i} {low} {high}: {}", labels(&ticks));
            }
        }
    }
}

#[test]
fn log_ticks_are_decades() {
    use LegendScale::Log;
    check(Log, [1.0, 1000.0], TALL, "1 10 100 1000");
    check(Log, [1e-3, 10.0], TALL, "0.001 0.01 0.1 1 10");
    check(Log, [1.0, 100.0], TALL, "1 2 5 10 20 50 100");
    check(Log, [1e-9, 1e-3], TALL, "10⁻⁹ 10⁻⁸ 10⁻⁷ 10⁻⁶ 10⁻⁵ 10⁻⁴ 10⁻³");
    check(Log, [1e-9, 1e-3], SMALL, "10⁻⁹ 10⁻⁷ 10⁻⁵ 10⁻³");
    check(Log, [3e-7, 8e-6], TALL, "5×10⁻⁷ 10⁻⁶ 2×10⁻⁶ 5×10⁻⁶");
    check(Log, [2.1, 2.9], TALL, "2.2 2.4 2.6 2.8");
    check(Log, [-1000.0, -1.0], TALL, "−1000 −100 −10 −1");
    // No logarithm holds zero.
    check(Log, [0.0, 1.0], SMALL, "0.0 0.5 1.0");
}

#[test]
fn symmetric_log_ticks_are_symmetric() {
    let scale = LegendScale::SymLog { linear_up_to: 1.0 };
    check(scale, [-1000.0, 1000.0], TALL, "−1000 −100 −10 −1 0 1 10 100 1000");
    for k in 1..40 {
        let greatest = exact::pow(1.6, k as f64);
        let ticks = ticks(scale, [-greatest, greatest], Notation::Auto, SMALL);
        let values: Vec<f64> = ticks.major.iter().map(|t| t.value).collect();
        let mirrored: Vec<f64> = values.iter().rev().map(|v| if *v == 0.0 { 0.0 } else { -v }).collect();
        assert_eq!(values, mirrored, "{greatest}");
    }
}

#[test]
fn a_range_without_extent_has_one_tick() {
    check(LegendScale::Linear, [3.25, 3.25], TALL, "3.25");
    check(LegendScale::Log, [3.25, 3.25], TALL, "3.25");
    for range in [[f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        check(LegendScale::Linear, range, TALL, "");
    }
    check(LegendScale::Linear, [0.0, 0.0], TALL, "0");
}

#[test]
fn a_far_range_is_told_from_its_offset() {
    let ticks = ticks(LegendScale::Linear, [1e6, 1e6 + 1.0], Notation::Auto, TALL);
    assert_eq!((labels(&ticks).as_str(), ticks.offset, ticks.exponent), ("0.0 0.2 0.4 0.6 0.8 1.0", 1e6, 0));
}

#[test]
fn ticks_lie_in_the_range_and_never_touch() {
    let scales = [LegendScale::Linear, LegendScale::Log, LegendScale::SymLog { linear_up_to: 0.01 }];
    let mut state = 1u32;
    let mut random = || {
        state = crate::math::hash(state.wrapping_add(0x9e37_79b9));
        crate::math::unit_float(state) as f64
    };
    for i in 0..6000 {
        let size = exact::pow(10.0, random() * 16.0 - 8.0);
        let mut range = match i % 4 {
            0 => [-random() * size, random() * size],
            1 => [random() * size, random() * size],
            2 => [size, size * (1.0 + random() * 1e-4)],
            _ => [size, size * exact::pow(10.0, random() * 12.0)],
        };
        if i % 5 == 0 {
            range.reverse();
        }
        let room = Room {
            length: 40.0 + 600.0 * random() as f32,
            text_size: 9.0 + 10.0 * random() as f32,
            is_horizontal: i % 2 == 0,
        };
        let notation = [Notation::Auto, Notation::Si, Notation::Engineering, Notation::Plain][i / 7 % 4];
        for scale in scales {
            let ticks = ticks(scale, range, notation, room);
            assert!(!ticks.major.is_empty(), "{scale:?} {range:?} {room:?}");
            assert!(room.holds(&ticks.major), "{scale:?} {range:?} {room:?}: {}", labels(&ticks));
            let all = ticks.major.iter().map(|t| t.position).chain(ticks.minor.iter().copied());
            for position in all {
                assert!((-1e-5..=1.00001).contains(&position), "{scale:?} {range:?}: {position}");
            }
            let texts: std::collections::HashSet<&str> = ticks.major.iter().map(|t| t.label.as_str()).collect();
            assert_eq!(texts.len(), ticks.major.len(), "{scale:?} {range:?} {notation:?}: {}", labels(&ticks));
        }
    }
}

#[test]
fn positions_and_values_are_each_others_inverse() {
    for scale in [LegendScale::Linear, LegendScale::Log, LegendScale::SymLog { linear_up_to: 0.5 }] {
        for range in [[1.0, 1000.0], [1000.0, 1.0], [-8.0, -2.0], [-20.0, 300.0]] {
            for i in 0..=10 {
                let t = i as f64 / 10.0;
                let back = scale.position(scale.value_at(t, range), range);
                assert!((back - t).abs() < 1e-9, "{scale:?} {range:?}: {back} not {t}");
            }
        }
    }
    assert_eq!(LegendScale::Log.position(10.0, [1.0, 100.0]), 0.5);
    assert_eq!(LegendScale::SymLog { linear_up_to: 1.0 }.position(0.0, [-100.0, 100.0]), 0.5);
}

#[test]
fn bands_are_labelled_at_their_edges() {
    let edges = |range, n, room| labels(&band_edges(LegendScale::Linear, range, n, Notation::Auto, room));
    assert_eq!(edges([0.0, 1.0], 5, TALL), "0.0 0.2 0.4 0.6 0.8 1.0");
    assert_eq!(edges([0.0, 1.0], 7, TALL), "0.00 0.14 0.29 0.43 0.57 0.71 0.86 1.00");
    assert_eq!(edges([0.0, 12.0], 12, SMALL), "0 2 4 6 8 10 12");
    assert_eq!(edges([1.0, 0.0], 2, SMALL), "0.0 0.5 1.0");
    let log = band_edges(LegendScale::Log, [1.0, 1000.0], 6, Notation::Auto, TALL);
    assert_eq!(labels(&log), "1 3.16 10 31.6 100 316 1000");
}
