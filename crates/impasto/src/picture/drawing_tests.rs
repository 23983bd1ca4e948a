//! Truths about drawings.

use super::*;

const WHITE: LinearRgba = [1.0; 4];
const BLACK: LinearRgba = [0.0, 0.0, 0.0, 1.0];

fn drawn(size: Size, items: Vec<Item>, ground: Option<[u8; 3]>) -> Vec<[u8; 4]> {
    Drawing { size, items }.picture(ground)
}

#[test]
fn half_a_pixel_is_half_the_light() {
    let item = Item::Rect { rect: Rect::new(0.5, 0.0, 1.5, 1.0), color: WHITE };
    let picture = drawn(Size::new(3, 1), vec![item], Some([0; 3]));
    // Half of white is sRGB 188, not 128.
    assert_eq!(picture, [[188, 188, 188, 255], [255; 4], [0, 0, 0, 255]]);
}

#[test]
fn transparent_ground_keeps_straight_alpha() {
    let color = [1.0, 0.0, 0.0, 1.0];
    let picture = drawn(Size::new(2, 1), vec![Item::Rect { rect: Rect::new(0.0, 0.0, 1.5, 1.0), color }], None);
    assert_eq!(picture, [[255, 0, 0, 255], [255, 0, 0, 128]]);
}

#[test]
fn a_strip_starts_where_its_direction_says() {
    let colors = vec![BLACK, WHITE];
    let rect = Rect::new(0.0, 0.0, 2.0, 2.0);
    let first = |direction| drawn(Size::new(2, 2), vec![Item::Strip { rect, direction, colors: colors.clone() }], None);
    let (b, w) = ([0, 0, 0, 255], [255; 4]);
    assert_eq!(first(Direction::Up), [w, w, b, b]);
    assert_eq!(first(Direction::Right), [b, w, b, w]);
    let block = Item::Block { rect, n_columns: 2, colors: vec![WHITE, BLACK, BLACK, WHITE] };
    assert_eq!(drawn(Size::new(2, 2), vec![block], None), [w, b, b, w]);
}

#[test]
fn cells_leave_no_seams() {
    let rect = Rect::new(0.0, 0.0, 40.0, 33.0);
    let block = Item::Block { rect, n_columns: 23, colors: vec![[0.5, 0.5, 0.5, 1.0]; 23 * 17] };
    assert!(drawn(Size::new(40, 33), vec![block], None).iter().all(|p| *p == [188, 188, 188, 255]));
    let strip = Item::Strip { rect, direction: Direction::Up, colors: vec![[1.0, 0.0, 0.0, 0.5]; 50] };
    assert!(drawn(Size::new(40, 33), vec![strip], None).iter().all(|p| *p == [255, 0, 0, 128]));
    // A pixel over two cells has their mean.
    let strip =
        Item::Strip { rect: Rect::new(0.0, 0.0, 3.0, 1.0), direction: Direction::Right, colors: vec![BLACK, WHITE] };
    let reds: Vec<u8> = drawn(Size::new(3, 1), vec![strip], None).iter().map(|p| p[0]).collect();
    assert_eq!(reds, [0, 188, 255]);
}

#[test]
fn a_frame_lies_outside_its_rectangle() {
    let frame = Item::Frame { rect: Rect::new(2.0, 2.0, 3.0, 2.0), width: 1.0, color: WHITE };
    let picture = drawn(Size::new(7, 6), vec![frame], None);
    let text: Vec<String> = picture
        .chunks(7)
        .map(|row| {
            row.iter()
                .map(|p| {
                    if p[3] == 255 {
                        '#'
                    } else if p[3] == 0 {
                        '.'
                    } else {
                        '?'
                    }
                })
                .collect()
        })
        .collect();
    assert_eq!(text, [".......", ".#####.", ".#...#.", ".#...#.", ".#####.", "......."]);
}

#[test]
fn hatching_stays_inside_and_covers_its_share() {
    let rect = Rect::new(10.0, 5.0, 60.0, 23.0);
    for (spacing, width) in [(6.0, 1.5), (3.0, 1.0), (40.0, 10.0), (200.0, 90.0)] {
        let picture = drawn(Size::new(80, 40), vec![Item::Hatch { rect, spacing, width, color: WHITE }], None);
        let mut sum = 0.0;
        for (i, p) in picture.iter().enumerate() {
            let (x, y) = ((i % 80) as f32 + 0.5, (i / 80) as f32 + 0.5);
            let is_inside = x > rect.min.x && x < rect.max.x && y > rect.min.y && y < rect.max.y;
            assert!(is_inside || p[3] == 0, "{x} {y}");
            sum += p[3] as f32 / 255.0;
        }
        if spacing < 10.0 {
            let share = sum / (60.0 * 23.0);
            assert!((share - width / spacing).abs() < 0.02, "{share} of {spacing}/{width}");
        }
    }
}

#[test]
fn text_stays_within_its_bounds_and_sits_on_its_baseline() {
    let size = Size::new(200, 120);
    for (align, angle, is_centered) in [
        (Align::Start, 0.0, false),
        (Align::Middle, 0.7, true),
        (Align::End, -1.2, false),
        (Align::Middle, -1.570_796_4, true),
    ] {
        let mut text = Text::new("Ågpy 12−3", vec2(100.0, 60.0), 17.0, BLACK);
        (text.align, text.angle, text.is_centered) = (align, angle, is_centered);
        text.halo = Some((WHITE, 3.0));
        // Fitting may move a line by half a pixel; the ring of Å is above letters without accents.
        let bounds = text.bounds().grown(4.0);
        let picture = drawn(size, vec![Item::Text(text)], None);
        let mut n_inked = 0;
        for (i, p) in picture.iter().enumerate().filter(|(_, p)| p[3] > 0) {
            let at = vec2((i % 200) as f32 + 0.5, (i / 200) as f32 + 0.5);
            assert!(at.cmpge(bounds.min).all() && at.cmple(bounds.max).all(), "{at} {p:?} outside {bounds:?}");
            n_inked += 1;
        }
        assert!(n_inked > 500, "{n_inked}");
    }
    // A stem ends at the baseline, sharply.
    let text = Text::new("H", vec2(3.0, 20.3), 16.0, BLACK);
    let picture = drawn(Size::new(20, 30), vec![Item::Text(text)], Some([255; 3]));
    let row = |y: usize| picture[y * 20..y * 20 + 20].iter().map(|p| p[0]).min();
    assert!(row(19) < Some(80) && row(20) == Some(255));
}

#[test]
fn a_halo_surrounds_its_text() {
    let mut text = Text::new("8", vec2(20.0, 30.0), 30.0, BLACK);
    text.halo = Some((WHITE, 3.0));
    let picture = drawn(Size::new(60, 60), vec![Item::Text(text.clone())], Some([90, 90, 90]));
    text.halo = None;
    let alone = drawn(Size::new(60, 60), vec![Item::Text(text)], Some([255; 3]));
    // Wherever there is ink, there is none of the ground two pixels around it.
    for y in 3..57 {
        for x in 3..57 {
            if alone[y * 60 + x][0] < 100 {
                for (dx, dy) in [(0, 2), (2, 0), (0, -2), (-2, 0)] {
                    let i = (y as i32 + dy) * 60 + x as i32 + dx;
                    let (with, without) = (picture[i as usize][0], alone[i as usize][0]);
                    assert!(with.abs_diff(without) <= 2, "{x} {y}: {with} {without}");
                }
            }
        }
    }
}

#[test]
fn absurd_items_draw_nothing() {
    let nan = vec2(f32::NAN, 0.0);
    let far = Rect { min: Vec2::splat(-f32::MAX), max: Vec2::splat(f32::MAX) };
    let items = vec![
        Item::Line { from: nan, to: nan, width: 1.0, color: WHITE },
        Item::Rect { rect: far, color: WHITE },
        Item::Strip { rect: Rect::new(0.0, 0.0, 2.0, 2.0), direction: Direction::Up, colors: vec![] },
        Item::Block { rect: Rect::new(0.0, 0.0, 2.0, 2.0), n_columns: 0, colors: vec![] },
        Item::Polygon { points: vec![], color: WHITE },
        Item::Hatch { rect: far, spacing: 0.0, width: 1.0, color: WHITE },
        Item::Text(Text::new("", Vec2::ZERO, 10.0, WHITE)),
        Item::Text(Text::new("x", nan, f32::INFINITY, WHITE)),
    ];
    assert!(drawn(Size::new(4, 4), items, None).iter().all(|p| *p == [0; 4]));
}
