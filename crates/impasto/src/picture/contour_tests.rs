//! Truths about isolines and their labels, on fields one can write down.

use super::*;

const SIZE: Size = Size::new(300, 240);
const CENTER: Vec2 = Vec2::new(150.0, 120.0);

fn field(f: impl Fn(Vec2) -> f32) -> Vec<f32> {
    (0..SIZE.n_cells()).map(|i| f(vec2((i % 300) as f32 + 0.5, (i / 300) as f32 + 0.5))).collect()
}

fn style() -> LabelStyle {
    LabelStyle::new(12.0, [0.0, 0.0, 0.0, 1.0], [1.0; 4])
}

fn texts(items: &[Item]) -> Vec<&Text> {
    items.iter().map(|i| if let Item::Text(t) = i { t } else { panic!("labels are text") }).collect()
}

#[test]
fn circles_are_closed_and_round() {
    let values = field(|p| (p - CENTER).length());
    let levels = [30.0, 60.0, 90.0, 500.0];
    let contours = trace(&values, SIZE, &levels);
    assert_eq!(
        contours.iter().map(|c| (c.level_idx, c.is_closed)).collect::<Vec<_>>(),
        [(0, true), (1, true), (2, true)]
    );
    for c in &contours {
        let radius = levels[c.level_idx];
        assert!(c.points.iter().all(|p| ((*p - CENTER).length() - radius).abs() < 0.02));
        let length = c.lengths().last().copied().expect("points");
        assert!((length - std::f32::consts::TAU * radius).abs() < 0.01 * length, "{length}");
        // Greater values lie on the right: with y down, the turn is that of a clock the other way.
        let turn: f32 = c.points.windows(2).map(|w| (w[0] - CENTER).perp_dot(w[1] - CENTER)).sum();
        assert!(turn < 0.0, "{turn}");
    }
}

#[test]
fn labels_lie_on_circles_along_them() {
    let values = field(|p| (p - CENTER).length());
    let levels = [45.0, 70.0, 100.0];
    let contours = trace(&values, SIZE, &levels);
    let items = labels(&contours, &level_texts(&levels, Notation::Auto), (&values, SIZE), &style(), &[]);
    assert!(items.len() >= 3, "{}", items.len());
    for text in texts(&items) {
        let radius: f32 = text.content.parse().expect("a number");
        let from = text.at - CENTER;
        assert!((from.length() - radius).abs() < 1.0, "{text:?}");
        // The tangent is across the radius.
        let off = (text.angle.cos() * from.x + text.angle.sin() * from.y) / from.length();
        assert!(off.abs() < 3.0f32.to_radians().sin(), "{off}");
        assert!(text.angle.abs() <= 90.1f32.to_radians());
    }
}

#[test]
fn labels_keep_off_each_other_edges_and_what_is_taken() {
    // Slanted stripes on a disk with a hole.
    let values = field(|p| {
        let r = (p - CENTER).length();
        if !(25.0..=110.0).contains(&r) { f32::NAN } else { 0.3 * p.x + 0.8 * p.y }
    });
    let levels: Vec<f32> = (0..30).map(|i| i as f32 * 10.0).collect();
    let contours = trace(&values, SIZE, &levels);
    assert!(contours.iter().all(|c| !c.is_closed));
    let taken = Rect::new(160.0, 60.0, 60.0, 30.0);
    let short = LabelStyle { spacing: 60.0, ..style() };
    let items = labels(&contours, &level_texts(&levels, Notation::Auto), (&values, SIZE), &short, &[taken]);
    let texts = texts(&items);
    assert!(texts.len() > 8, "{}", texts.len());
    let boxed = |t: &Text| Tilted {
        center: t.at,
        along: vec2(t.angle.cos(), t.angle.sin()),
        half: vec2(0.5 * t.width(), 0.5 * font::CAP_HEIGHT * t.size),
    };
    for (i, a) in texts.iter().enumerate() {
        assert!(!boxed(a).overlaps(&Tilted::of(&taken)));
        assert!(boxed(a).is_over_values(&values, SIZE));
        assert!(texts[..i].iter().all(|b| !boxed(a).overlaps(&boxed(b))));
        let slope = (a.angle.sin() / a.angle.cos() + 0.3 / 0.8).abs();
        assert!(slope < 0.03, "{slope}");
    }
}

#[test]
fn saddles_are_parted_by_their_middle() {
    // One cell with greater corners on a diagonal; the middle is the mean.
    let size = Size::new(2, 2);
    let values = [1.0, 0.0, 0.0, 1.0];
    for (level, is_joined) in [(0.4, true), (0.6, false)] {
        let contours = trace(&values, size, &[level]);
        assert_eq!(contours.len(), 2);
        for c in &contours {
            // Each line cuts off one corner: a lesser one where the greater are joined.
            let middle = (c.points[0] + c.points[1]) * 0.5;
            let is_near_lesser = (middle.x > 1.0) != (middle.y > 1.0);
            assert_eq!(is_near_lesser, is_joined, "{c:?}");
        }
    }
}

#[test]
fn lines_of_a_random_field_never_branch() {
    let size = Size::new(60, 50);
    let random = |i: u32| crate::math::unit_float(crate::math::hash(i));
    let values: Vec<f32> = (0..size.n_cells() as u32).map(|i| if i % 97 == 5 { f32::NAN } else { random(i) }).collect();
    let levels = [0.25, 0.5, 0.75];
    let contours = trace(&values, size, &levels);
    assert!(contours.len() > 100);
    let steps = |c: &Contour| c.points.windows(2).all(|w| (w[1] - w[0]).length() < 1.5);
    assert!(contours.iter().all(steps));
    // Open lines end at the rim or beside a missing value.
    for c in contours.iter().filter(|c| !c.is_closed) {
        for p in [c.points[0], c.points[c.points.len() - 1]] {
            let is_at_rim = p.x < 0.51 || p.y < 0.51 || p.x > 59.49 || p.y > 49.49;
            let near = |dx: i32, dy: i32| {
                let (x, y) = ((p.x - 0.5).round() as i32 + dx, (p.y - 0.5).round() as i32 + dy);
                x >= 0 && y >= 0 && x < 60 && y < 50 && values[(y * 60 + x) as usize].is_nan()
            };
            let is_at_hole = (-2..=2).any(|dy| (-2..=2).any(|dx| near(dx, dy)));
            assert!(is_at_rim || is_at_hole, "{p}");
        }
    }
    assert_eq!(contours, trace(&values, size, &levels));
}

#[test]
fn flat_and_empty_fields_have_no_lines() {
    assert!(trace(&field(|_| 3.0), SIZE, &[3.0, f32::NAN]).is_empty());
    assert!(trace(&field(|_| f32::NAN), SIZE, &[0.0]).is_empty());
    assert!(trace(&[], Size::new(0, 0), &[0.0]).is_empty());
    assert!(trace(&[1.0, 2.0], Size::new(2, 1), &[1.5]).is_empty());
}

#[test]
fn level_texts_tell_levels_apart() {
    let texts = |levels: &[f32]| level_texts(levels, Notation::Auto).join(" ");
    assert_eq!(texts(&[0.0, 0.1, 0.2, 0.3]), "0.0 0.1 0.2 0.3");
    assert_eq!(texts(&[-20.0, 5.0]), "−20 5");
    assert_eq!(texts(&[2.5e6, 5e6]), "2.5×10⁶ 5×10⁶");
    assert_eq!(texts(&[7.0]), "7");
    assert_eq!(texts(&[]), "");
}
