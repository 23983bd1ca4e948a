//! A machine part as a designer would draw it: a flange with four counterbored bolt holes, a filleted boss, and a bore with
//! a keyway. Closed; planes are triangulated by Delaunay's rule, walls and fillets are strips; every edge that is sharp on
//! the drawing is sharp in the normals.

use crate::assets::{Element, Field, Material, Mesh, RawMesh, Scene, Values};
use crate::math::exact::{asin, cos, exp, sin};
use crate::math::{DVec2, DVec3};
use crate::samples::atlas;
use crate::samples::sheet::{self, Point};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

// Measures in units of 25 mm; y is up, the bore's axis is x = z = 0.
const HALF: f64 = 1.6;
const CORNER: f64 = 0.5;
const THICK: f64 = 0.38;
const EDGE: f64 = 0.09;
const CHAMFER: f64 = 0.035;
const BOLT: f64 = 1.07;
const BOLT_HOLE: f64 = 0.17;
const COUNTERBORE: f64 = 0.30;
const LEDGE: f64 = 0.21;
const BOSS: f64 = 0.80;
const FILLET: f64 = 0.14;
const TOP: f64 = 1.30;
const BORE: f64 = 0.44;
const KEY_HALF: f64 = 0.11;
const KEY_DEPTH: f64 = 0.60;
const BORE_CHAMFER: f64 = 0.05;

/// The part, 80 mm square, with materials `cast` (painted) and `machined`, one UV set without overlap, and a field `stress`
/// in MPa (made up: it peaks at the fillet and around the bolts). `n_around` is the number of edges of each circle.
pub fn scene(n_around: u32) -> Scene {
    let cast =
        Material { name: "cast".into(), base_color: [0.11, 0.24, 0.33, 1.0], roughness: 0.5, ..Material::default() };
    let machined = Material {
        name: "machined".into(),
        base_color: [0.62, 0.61, 0.59, 1.0],
        metalness: 1.0,
        roughness: 0.32,
        ..Material::default()
    };
    Scene { materials: vec![cast, machined], ..Scene::of("flange", mesh(n_around)) }
}

/// The part alone; material 0 is what is cast, 1 what is machined.
pub fn mesh(n_around: u32) -> Mesh {
    let n = (n_around.max(16) / 4 * 4) as usize;
    let pieces = pieces(n);
    let sizes: Vec<DVec2> = pieces.iter().map(|p| p.chart).collect();
    let atlas = atlas::shelves(&sizes, 5.0 / 1024.0);
    let mut raw = sheet::empty();
    for (part, name) in ["cast", "machined"].into_iter().enumerate() {
        for (piece, corner) in pieces.iter().zip(&atlas.corners).filter(|(p, _)| p.part == part) {
            let base = raw.positions.len() as u32;
            for p in &piece.points {
                sheet::push(&mut raw, Point { uv: *corner + p.uv * atlas.scale, ..*p });
            }
            raw.triangles.extend(piece.triangles.iter().map(|t| t.map(|i| i + base)));
        }
        sheet::part(&mut raw, name, Some(part as u32));
    }
    raw.fields = vec![stress(&raw)];
    sheet::finish(raw)
}

fn stress(raw: &RawMesh) -> Field {
    let at = |p: DVec3| {
        let r = (p.x * p.x + p.z * p.z).sqrt();
        let near = |d: f64, reach: f64| exp(-(d / reach) * (d / reach));
        let fillet = near(r - BOSS - 0.04, 0.16) * near(p.y - THICK - 0.05, 0.22);
        let (bx, bz) = (p.x.abs() - BOLT, p.z.abs() - BOLT);
        let bolt = near((bx * bx + bz * bz).sqrt() - COUNTERBORE, 0.22);
        let key = near(r - KEY_DEPTH, 0.14) * near(p.z.abs() - KEY_HALF, 0.12) * if p.x > 0.0 { 1.0 } else { 0.0 };
        // The load comes from +X: that side bears more.
        (28.0 + 14.0 * p.x + 150.0 * fillet * (1.0 + 0.35 * p.x) + 90.0 * bolt * (1.0 + 0.25 * p.x) + 120.0 * key)
            as f32
    };
    let values = raw.positions.iter().map(|p| at(p.as_dvec3())).collect();
    Field {
        name: "stress".into(),
        unit: "MPa".into(),
        element: Element::Vertex,
        n_components: 1,
        values: Values::F32(values),
    }
}

/// Some surface with its chart, model units.
struct Piece {
    part: usize,
    points: Vec<Point>,
    triangles: Vec<[u32; 3]>,
    chart: DVec2,
}

/// A closed outline in the plane, counter-clockwise seen from above: place and outward direction of its points, for an
/// offset outwards. In a sharp corner two points share a place.
type Outline<'a> = &'a dyn Fn(usize, f64) -> [DVec2; 2];

/// A point of a wall's profile: offset outwards, height, and the normal's shares outwards and up.
type Profile = [f64; 4];

fn pieces(n: usize) -> Vec<Piece> {
    let plate = |k: usize, offset: f64| {
        // A quarter circle in each corner; the straight sides have no points of their own.
        let quarter = n / 4 + 1;
        let (side, i) = ((k / quarter) % 4, k % quarter);
        let out = match i {
            0 => DVec2::X,
            i if i == quarter - 1 => DVec2::Y,
            i => {
                let angle = FRAC_PI_2 * i as f64 / (quarter - 1) as f64;
                DVec2::new(cos(angle), sin(angle))
            }
        };
        let place = DVec2::splat(HALF - CORNER) + out * (CORNER + offset);
        [quarter_turn(place, side), quarter_turn(out, side)]
    };
    let n_plate = 4 * (n / 4 + 1);
    let circle = |center: DVec2, radius: f64| {
        move |k: usize, offset: f64| {
            let side = 4 * (k % n) / n;
            let angle = 2.0 * PI * (k % n - side * n / 4) as f64 / n as f64;
            let out = quarter_turn(DVec2::new(cos(angle), sin(angle)), side);
            [center + out * (radius + offset), out]
        }
    };
    let (boss, bore) = (circle(DVec2::ZERO, BOSS), |k: usize, offset: f64| keyed(k, n, offset));
    let n_bore = n + 7;

    let arc = |center: [f64; 2], radius: f64, from: f64, to: f64, steps: usize| -> Vec<Profile> {
        (0..=steps)
            .map(|i| {
                let a = from + (to - from) * i as f64 / steps as f64;
                [center[0] + radius * cos(a), center[1] + radius * sin(a), cos(a), sin(a)]
            })
            .collect()
    };
    let line = |a: [f64; 2], b: [f64; 2]| -> Vec<Profile> {
        // The surface lies to the left of its way up, so the normal is to the right.
        let d = DVec2::new(b[0] - a[0], b[1] - a[1]).normalize();
        vec![[a[0], a[1], d.y, -d.x], [b[0], b[1], d.y, -d.x]]
    };
    let round = (n / 12).clamp(2, 16);

    let mut pieces = Vec::new();
    // The plate's rim, a quarter a chart: chamfer below, wall, rounded edge above.
    let rim = [
        line([-CHAMFER, 0.0], [0.0, CHAMFER]),
        line([0.0, CHAMFER], [0.0, THICK - EDGE]),
        arc([-EDGE, THICK - EDGE], EDGE, 0.0, FRAC_PI_2, round),
    ];
    for side in 0..4 {
        let quarter = n_plate / 4;
        pieces.push(wall(0, &plate, side * quarter..(side + 1) * quarter, n_plate, &rim));
    }
    // The boss: fillet, wall with a groove for a circlip, rounded edge. The fillet is hollow: its normals point inwards to
    // the centre of its circle.
    let mut foot = arc([FILLET, THICK + FILLET], FILLET, -FRAC_PI_2, -PI, round);
    foot.iter_mut().for_each(|p| (p[2], p[3]) = (-p[2], -p[3]));
    let (groove, depth) = ([1.02, 1.09], 0.045);
    let boss_wall = [
        foot,
        line([0.0, THICK + FILLET], [0.0, groove[0]]),
        line([0.0, groove[0]], [-depth, groove[0]]),
        line([-depth, groove[0]], [-depth, groove[1]]),
        line([-depth, groove[1]], [0.0, groove[1]]),
        line([0.0, groove[1]], [0.0, TOP - 0.07]),
        arc([-0.07, TOP - 0.07], 0.07, 0.0, FRAC_PI_2, round),
    ];
    pieces.push(wall(0, &boss, 0..n, n, &boss_wall));
    // The bore, downwards: chamfer, wall, chamfer.
    let c = BORE_CHAMFER;
    let bore_wall = [line([c, TOP], [0.0, TOP - c]), line([0.0, TOP - c], [0.0, c]), line([0.0, c], [c, 0.0])];
    pieces.push(wall(1, &bore, 0..n_bore, n_bore, &bore_wall));
    // Bolt holes, downwards: counterbore with its chamfer, ledge, hole, chamfer.
    let bolts: Vec<DVec2> = [[BOLT, BOLT], [-BOLT, BOLT], [-BOLT, -BOLT], [BOLT, -BOLT]].map(DVec2::from).to_vec();
    let step = BOLT_HOLE - COUNTERBORE;
    let c = CHAMFER;
    let bolt_wall = [
        line([c, THICK], [0.0, THICK - c]),
        line([0.0, THICK - c], [0.0, LEDGE]),
        line([0.0, LEDGE], [step, LEDGE]),
        line([step, LEDGE], [step, c]),
        line([step, c], [step + c, 0.0]),
    ];
    for center in &bolts {
        pieces.push(wall(1, &circle(*center, COUNTERBORE), 0..n, n, &bolt_wall));
    }
    // The three planes between the outlines.
    let ring =
        |outline: Outline, n: usize, offset: f64| -> Vec<DVec2> { (0..n).map(|k| outline(k, offset)[0]).collect() };
    let bolt_rings = |offset: f64| bolts.iter().map(move |b| ring(&circle(*b, COUNTERBORE), n, offset));
    let mut above = vec![ring(&plate, n_plate, -EDGE)];
    above.extend(bolt_rings(c));
    above.push(ring(&boss, n, FILLET));
    pieces.push(plane(0, above, THICK, true));
    let top = vec![ring(&boss, n, -0.07), ring(&bore, n_bore, BORE_CHAMFER)];
    pieces.push(plane(1, top, TOP, true));
    let mut below = vec![ring(&plate, n_plate, -CHAMFER)];
    below.extend(bolt_rings(step + c));
    below.push(ring(&bore, n_bore, BORE_CHAMFER));
    pieces.push(plane(1, below, 0.0, false));
    pieces
}

/// The bore with its keyway towards +X: `n` arc points more or less, then the slot's corners, each twice.
fn keyed(k: usize, n: usize, offset: f64) -> [DVec2; 2] {
    let (radius, half, depth) = (BORE + offset, KEY_HALF + offset, KEY_DEPTH + offset);
    let first = asin(half / radius);
    // The arc from one side of the slot to the other, n points; then four sharp corners.
    if k < n {
        let t = k as f64 / (n - 1) as f64;
        let angle = first + (2.0 * PI - 2.0 * first) * t;
        let out = DVec2::new(cos(angle), sin(angle));
        // The ends lie on the slot's sides to the last bit.
        let place = match k {
            0 => DVec2::new((radius * radius - half * half).sqrt(), half),
            k if k == n - 1 => DVec2::new((radius * radius - half * half).sqrt(), -half),
            _ => out * radius,
        };
        return [place, out];
    }
    let near = (radius * radius - half * half).sqrt();
    match k - n {
        0 => [DVec2::new(near, -half), -DVec2::Y],
        1 => [DVec2::new(depth, -half), -DVec2::Y],
        2 => [DVec2::new(depth, -half), DVec2::X],
        3 => [DVec2::new(depth, half), DVec2::X],
        4 => [DVec2::new(depth, half), DVec2::Y],
        5 => [DVec2::new(near, half), DVec2::Y],
        // Closes the loop with the arc's own normal.
        _ => [DVec2::new(near, half), DVec2::new(cos(first), sin(first))],
    }
}

/// A place in the plane (x to the right, y away from the viewer above) in space.
fn lifted(p: DVec2, y: f64) -> DVec3 {
    DVec3::new(p.x, y, -p.y)
}

/// Strips along an outline over a profile that runs with the solid on its left: upwards outside, downwards inside.
fn wall(part: usize, outline: Outline, range: std::ops::Range<usize>, n: usize, profile: &[Vec<Profile>]) -> Piece {
    let mut raw = sheet::empty();
    let columns = range.len() as u32;
    let mut lengths = vec![0.0];
    for k in range.clone() {
        let (a, b) = (outline(k % n, 0.0)[0], outline((k + 1) % n, 0.0)[0]);
        lengths.push(lengths[lengths.len() - 1] + a.distance(b));
    }
    let mut start = 0.0;
    for strip in profile {
        let mut heights = vec![start];
        for w in strip.windows(2) {
            let (dx, dy) = (w[1][0] - w[0][0], w[1][1] - w[0][1]);
            heights.push(heights[heights.len() - 1] + (dx * dx + dy * dy).sqrt());
        }
        start = heights[heights.len() - 1];
        sheet::grid(&mut raw, [columns, strip.len() as u32 - 1], |i, j| {
            let [offset, y, out, up] = strip[j as usize];
            let k = (range.start + i as usize) % n;
            let [place, direction] = outline(k, offset);
            Point {
                position: lifted(place, y),
                normal: lifted(direction * out, up),
                uv: DVec2::new(lengths[i as usize], heights[j as usize]),
            }
        });
    }
    // v runs down: turn the chart over.
    let chart = DVec2::new(lengths[lengths.len() - 1], start);
    piece(part, raw, chart, |uv| DVec2::new(uv.x, chart.y - uv.y))
}

fn piece(part: usize, raw: RawMesh, chart: DVec2, uv: impl Fn(DVec2) -> DVec2) -> Piece {
    let points = (0..raw.positions.len())
        .map(|i| Point {
            position: raw.positions[i].as_dvec3(),
            normal: raw.normals[i].as_dvec3(),
            uv: uv(raw.uv_sets[0].uv[i].as_dvec2()),
        })
        .collect();
    Piece { part, points, triangles: raw.triangles, chart }
}

/// The plane region at a height inside the first outline and outside the others.
fn plane(part: usize, outlines: Vec<Vec<DVec2>>, y: f64, faces_up: bool) -> Piece {
    let mut places: Vec<DVec2> = Vec::new();
    let mut holes: Vec<u32> = Vec::new();
    for (k, mut outline) in outlines.into_iter().enumerate() {
        outline.dedup();
        if outline.first() == outline.last() {
            outline.pop();
        }
        if k > 0 {
            holes.push(places.len() as u32);
        }
        places.extend(outline);
    }
    let mut flat = Vec::new();
    earcut::Earcut::new().earcut(places.iter().map(|p| p.to_array()), &holes, &mut flat);
    let mut triangles: Vec<[u32; 3]> = flat.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    for t in &mut triangles {
        let [a, b, c] = t.map(|i| places[i as usize]);
        if (b - a).perp_dot(c - a) < 0.0 {
            t.swap(1, 2);
        }
    }
    delaunay(&places, &mut triangles);
    let (low, high) = places.iter().fold((places[0], places[0]), |(l, h), p| (l.min(*p), h.max(*p)));
    if !faces_up {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let up = if faces_up { 1.0 } else { -1.0 };
    let points = places
        .iter()
        .map(|p| Point {
            position: lifted(*p, y),
            normal: DVec3::Y * up,
            // Seen from its front, the chart is not mirrored.
            uv: if faces_up { DVec2::new(p.x - low.x, high.y - p.y) } else { *p - low },
        })
        .collect();
    Piece { part, points, triangles, chart: high - low }
}

/// Flips edges inside a triangulation until no corner lies in a neighbour's circle (Lawson 1977). Border edges stay.
fn delaunay(places: &[DVec2], triangles: &mut [[u32; 3]]) {
    let key = |a: u32, b: u32| (a.min(b), a.max(b));
    let mut beside: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for (i, t) in triangles.iter().enumerate() {
        (0..3).for_each(|k| beside.entry(key(t[k], t[(k + 1) % 3])).or_default().push(i));
    }
    let mut queue: Vec<(u32, u32)> = beside.keys().copied().collect();
    // Each flip makes the triangulation strictly better, so that it ends; the bound only guards against rounding.
    let mut n_left = 50 * triangles.len() + 1000;
    while let Some(edge) = queue.pop() {
        let Some(&[s, t]) = beside.get(&edge).map(Vec::as_slice).and_then(|v| v.first_chunk::<2>()) else { continue };
        // The edge from a to b as triangle s runs along it, and the corners opposite.
        let (Some(k), Some(m)) = (
            (0..3).find(|&k| key(triangles[s][k], triangles[s][(k + 1) % 3]) == edge),
            (0..3).find(|&k| key(triangles[t][k], triangles[t][(k + 1) % 3]) == edge),
        ) else {
            continue;
        };
        let (a, b, c) = (triangles[s][k], triangles[s][(k + 1) % 3], triangles[s][(k + 2) % 3]);
        let d = triangles[t][(m + 2) % 3];
        let p = |i: u32| places[i as usize];
        let is_convex = (p(d) - p(c)).perp_dot(p(a) - p(c)) < -1e-9 && (p(d) - p(c)).perp_dot(p(b) - p(c)) > 1e-9;
        if n_left == 0 || !is_convex || !is_in_circle([p(a), p(b), p(c)], p(d)) {
            continue;
        }
        n_left -= 1;
        triangles[s] = [c, a, d];
        triangles[t] = [d, b, c];
        beside.remove(&edge);
        beside.insert(key(c, d), vec![s, t]);
        let swap = |list: Option<&mut Vec<usize>>, from: usize, to: usize| {
            list.into_iter().flatten().for_each(|i| *i = if *i == from { to } else { *i });
        };
        swap(beside.get_mut(&key(b, c)), s, t);
        swap(beside.get_mut(&key(a, d)), t, s);
        queue.extend([key(a, c), key(b, c), key(a, d), key(b, d)]);
    }
}

/// Whether `d` lies clearly inside the circle through three counter-clockwise points.
fn is_in_circle([a, b, c]: [DVec2; 3], d: DVec2) -> bool {
    let (a, b, c) = (a - d, b - d, c - d);
    let (aa, bb, cc) = (a.length_squared(), b.length_squared(), c.length_squared());
    a.x * (b.y * cc - c.y * bb) - a.y * (b.x * cc - c.x * bb) + aa * b.perp_dot(c) > 1e-9
}

/// Turned by right angles without any rounding.
fn quarter_turn(p: DVec2, n: usize) -> DVec2 {
    (0..n % 4).fold(p, |p, _| DVec2::new(-p.y, p.x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::solid::measure;

    #[test]
    fn it_is_closed_with_five_holes_at_any_resolution() {
        for n in [16, 24, 60, 128] {
            let solid = measure(&mesh(n));
            assert!(solid.is_closed && solid.euler == 2 - 2 * 5, "{n}: {solid:?}");
            assert!(solid.share_of_right_normals > 0.999, "{n}: {solid:?}");
        }
    }

    /// The volume by integrating the sections' areas over the height.
    #[test]
    fn its_volume_is_that_of_the_drawing() {
        let disc = |r: f64| PI * r * r;
        let below = |limit: f64, y: f64| if y < limit { 1.0 } else { 0.0 };
        let section = |y: f64| {
            let chamfer = |c: f64, d: f64| (c - d).max(0.0);
            let round = |r: f64, d: f64| if d < r { r - (r * r - (r - d) * (r - d)).sqrt() } else { 0.0 };
            let mut area = 0.0;
            if y < THICK {
                let inset = chamfer(CHAMFER, y) + round(EDGE, THICK - y);
                let (side, corner) = (2.0 * (HALF - inset), CORNER - inset);
                area += side * side - (4.0 - PI) * corner * corner;
                let low = BOLT_HOLE + chamfer(CHAMFER, y);
                let high = COUNTERBORE + chamfer(CHAMFER, THICK - y);
                area -= 4.0 * disc(if y < LEDGE { low } else { high });
            } else {
                let grooved = below(1.09, y) - below(1.02, y);
                area += disc(BOSS + round(FILLET, y - THICK) - round(0.07, TOP - y) - 0.045 * grooved);
            }
            let c = chamfer(BORE_CHAMFER, y) + chamfer(BORE_CHAMFER, TOP - y);
            let (r, half, depth) = (BORE + c, KEY_HALF + c, KEY_DEPTH + c);
            // Circle and slot, less what they share.
            let first = asin(half / r);
            area - disc(r) - (2.0 * half * depth - r * r * first - half * (r * r - half * half).sqrt())
        };
        const N: usize = 100_000;
        let truth: f64 = (0..N).map(|i| section(TOP * (i as f64 + 0.5) / N as f64) * TOP / N as f64).sum();
        for (n, tolerance) in [(32, 0.01), (128, 1e-3), (512, 1e-4)] {
            let volume = measure(&mesh(n)).volume;
            assert!((volume / truth - 1.0).abs() < tolerance, "{n}: {volume}, not {truth}");
        }
    }
}
