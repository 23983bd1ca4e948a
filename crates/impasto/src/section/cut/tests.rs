//! Truths about cuts.

use super::*;
use crate::assets::{Element, Field, Mesh, Part, RawMesh, Topology, UvSet, Values};
use crate::math::{DVec2, Vec2, Vec3, hash_cell, unit_float, vec2, vec3};
use crate::section::CutSurface;

pub(super) fn random(i: i32, k: i32) -> f32 {
    unit_float(hash_cell(i, k, 7, 11)) * 2.0 - 1.0
}

/// Planes through the middle half of a box, in all directions.
pub(super) fn random_plane(mesh: &Mesh, i: i32) -> Plane {
    let bounds = mesh.bounds();
    let point = bounds.center() + bounds.extent() * 0.4 * vec3(random(i, 0), random(i, 1), random(i, 2));
    Plane::through(point, vec3(random(i, 3), random(i, 4), random(i, 5) + 1e-3)).unwrap()
}

pub(super) fn topology(raw: &RawMesh) -> Topology {
    Topology::of_triangles(&raw.positions, &raw.triangles)
}

fn raw(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    RawMesh { positions, triangles, ..RawMesh::default() }.mend().value
}

/// Both halves closed, volumes add up, borders the same.
#[track_caller]
fn check_cut(mesh: &Mesh, plane: &Plane) -> Cut {
    let cut = cut(mesh, plane, Policy::Strict).unwrap();
    for half in [&cut.below, &cut.above] {
        let t = topology(&half.raw);
        let empty = half.raw.triangles.is_empty();
        assert!(empty || t.is_solid(), "{t:?}");
        let n = half.raw.positions.len();
        assert!(half.raw.triangles.iter().flatten().all(|&v| (v as usize) < n));
        assert!(half.raw.normals.len() == n && half.raw.normals.iter().all(|v| (v.length() - 1.0).abs() < 1e-3));
    }
    let whole = Soup::from(mesh).volume();
    let sum = Soup::from(&cut.below.raw).volume() + Soup::from(&cut.above.raw).volume();
    assert!((sum - whole).abs() <= 1e-6 * whole.abs(), "{sum} not {whole}");
    cut
}

#[test]
fn a_cube_is_cut_anywhere_along_its_edges_corners_and_faces() {
    let mesh = crate::samples::plain::cube(1);
    let b = mesh.bounds();
    for point in [b.min, b.max, b.center(), (b.min + b.center()) * 0.5] {
        for x in -1..=1 {
            for y in -1..=1 {
                for z in -1..=1 {
                    if [x, y, z] != [0; 3] {
                        check_cut(&mesh, &Plane::through(point, vec3(x as f32, y as f32, z as f32)).unwrap());
                    }
                }
            }
        }
    }
}

#[test]
fn closed_samples_stay_closed() {
    for name in ["knot", "flange", "icosphere", "cylinder", "cone", "displaced"] {
        let mesh = crate::samples::scene(name, 24, 1).unwrap().mesh;
        for i in 0..20 {
            let plane = random_plane(&mesh, i);
            let cut = check_cut(&mesh, &plane);
            assert!(!cut.section.contours.is_empty(), "{name}");
        }
    }
}

/// A ball at a place; with a negative radius it is inside out: a cavity.
fn ball(center: Vec3, radius: f32) -> RawMesh {
    let mut raw = crate::samples::plain::icosphere(8).into_raw();
    raw.positions.iter_mut().for_each(|p| *p = center + *p * radius.abs());
    if radius < 0.0 {
        raw.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        raw.normals.iter_mut().for_each(|n| *n = -*n);
    }
    RawMesh { positions: raw.positions, triangles: raw.triangles, normals: raw.normals, ..RawMesh::default() }
}

fn joined(raws: impl IntoIterator<Item = RawMesh>) -> Mesh {
    let mut all = RawMesh::default();
    for raw in raws {
        let first = all.positions.len() as u32;
        all.positions.extend(&raw.positions);
        all.normals.extend(&raw.normals);
        all.triangles.extend(raw.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all.mend().value
}

#[test]
fn shells_in_shells_are_cavities_and_bodies_may_overlap() {
    let plane = Plane::through(vec3(0.0, 0.07, 0.0), vec3(0.1, 1.0, 0.2)).unwrap();
    let hollow = joined([ball(Vec3::ZERO, 2.0), ball(vec3(0.3, 0.0, 0.0), -1.0), ball(vec3(0.3, 0.0, 0.1), 0.5)]);
    let cut = check_cut(&hollow, &plane);
    assert!(!cut.overlaps && cut.section.contours.len() == 3);
    let disc = |r: f64| std::f64::consts::PI * r * r;
    let ring = disc(2.0) - disc(1.0) + disc(0.5);
    assert!((cut.section.area() - ring).abs() < 0.05 * ring, "{} not {ring}", cut.section.area());

    let beside = joined([ball(Vec3::ZERO, 1.0), ball(vec3(3.0, 0.0, 0.0), 1.0)]);
    assert!(!check_cut(&beside, &plane).overlaps);
    // Each of overlapping bodies is closed for itself, with its own cap.
    let lens = joined([ball(Vec3::ZERO, 1.0), ball(vec3(1.1, 0.0, 0.3), 1.0), ball(vec3(0.5, 0.0, 0.0), 0.2)]);
    assert!(check_cut(&lens, &plane).overlaps);
}

/// A bent ribbon that crosses itself: an extruded figure of eight.
pub(super) fn eight() -> Mesh {
    let n = 64;
    let at = |i: usize, y: f32| {
        let a = i as f32 * std::f32::consts::TAU / n as f32;
        let (s, c) = crate::math::sin_cos(a);
        vec3(2.0 * s, y, 1.3 * s * c)
    };
    let mut raw = RawMesh::default();
    for i in 0..n {
        let next = (i + 1) % n;
        let [a, b, c, d] = [at(i, -1.0), at(next, -1.0), at(next, 1.0), at(i, 1.0)];
        let first = raw.positions.len() as u32;
        raw.positions.extend([a, b, c, d, vec3(0.0, 1.0, 0.0), vec3(0.0, -1.0, 0.0)]);
        raw.triangles.extend([[0, 2, 1], [0, 3, 2], [3, 4, 2], [1, 5, 0]].map(|t| t.map(|v| first + v)));
    }
    raw.mend().value
}

#[test]
fn a_surface_that_crosses_itself_gets_nodes_there_and_stays_closed() {
    let mesh = eight();
    let plane = Plane::through(vec3(0.0, 0.1, 0.0), vec3(0.05, 1.0, 0.02)).unwrap();
    let cut = cut(&mesh, &plane, Policy::Strict).unwrap();
    assert!(cut.overlaps && cut.n_lost == 0);
    for half in [&cut.below, &cut.above] {
        let t = topology(&half.raw);
        assert!(t.n_border_edges == 0 && t.n_inconsistent_edges == 0, "{t:?}");
    }
    let whole = Soup::from(&mesh).volume();
    let sum = Soup::from(&cut.below.raw).volume() + Soup::from(&cut.above.raw).volume();
    assert!((sum - whole).abs() < 1e-5, "{sum} not {whole}");
}

#[test]
fn both_halves_share_their_border_to_the_bit() {
    let mesh = crate::samples::scene("flange", 32, 0).unwrap().mesh;
    let cut = check_cut(&mesh, &random_plane(&mesh, 3));
    let caps = |half: &Half| -> std::collections::BTreeSet<[u32; 3]> {
        let range = half.cap_vertices.start as usize..half.cap_vertices.end as usize;
        half.raw.positions[range].iter().map(|p| p.to_array().map(f32::to_bits)).collect()
    };
    let (a, b) = (caps(&cut.below), caps(&cut.above));
    assert!(a == b && a.len() > 20);
    for half in [&cut.below, &cut.above] {
        let outer: std::collections::BTreeSet<_> = half.raw.positions[..half.cap_vertices.start as usize]
            .iter()
            .map(|p| p.to_array().map(f32::to_bits))
            .collect();
        assert!(a.iter().all(|p| outer.contains(p)), "every corner of the cap is one of the surface");
        let uv = &half.raw.uv_sets.iter().find(|s| s.name == UV_NAME).unwrap().uv;
        for v in half.cap_vertices.clone().map(|v| v as usize) {
            let p = cut.section.origin + cut.section.axes[0] * uv[v].x as f64 + cut.section.axes[1] * uv[v].y as f64;
            assert!((p.as_vec3() - half.raw.positions[v]).length() < 1e-5);
        }
    }
}

/// A mesh with every kind of attribute, each a linear function of the position.
fn dressed() -> Mesh {
    let mut raw = crate::samples::plain::torus_knot(2, 3, 0.3, [60, 12]).into_raw();
    let p = raw.positions.clone();
    let corner = |f: fn(Vec3) -> f64| raw.triangles.iter().flatten().map(|&v| f(p[v as usize])).collect::<Vec<_>>();
    let numbers = corner(|p| p.y as f64);
    raw.uv_sets = vec![UvSet { name: "a".into(), uv: p.iter().map(|p| vec2(p.x, p.y)).collect() }];
    raw.colors = p.iter().map(|p| p.extend(1.0)).collect();
    let field = |name: &str, element, n_components, values| Field {
        name: name.into(),
        unit: "m".into(),
        element,
        n_components,
        values,
    };
    let faces = (0..raw.triangles.len()).map(|i| i as f32).collect();
    raw.fields = vec![
        field("v", Element::Vertex, 2, Values::F64(p.iter().flat_map(|p| [p.z as f64, f64::NAN]).collect())),
        field("f", Element::Face, 1, Values::F32(faces)),
        field("c", Element::Corner, 1, Values::F64(numbers)),
    ];
    let n = raw.triangles.len() as u32;
    let part = |name: &str, range, material| Part { name: name.into(), triangles: range, material };
    raw.parts = vec![part("first", 0..n / 3, Some(4)), part("second", n / 3..n, None)];
    raw.tangents = vec![];
    raw.mend().value
}

#[test]
fn all_attributes_are_kept_and_interpolated() {
    let mesh = dressed();
    let n_triangles = mesh.triangles().len() as u32;
    let cut = check_cut(&mesh, &random_plane(&mesh, 5));
    for half in [&cut.below, &cut.above] {
        let raw = &half.raw;
        let n_outer = half.cap_vertices.start as usize;
        for (v, p) in raw.positions[..n_outer].iter().enumerate() {
            assert!((raw.uv_sets[0].uv[v] - vec2(p.x, p.y)).length() < 1e-5);
            assert!((raw.colors[v].truncate() - *p).length() < 1e-5 && raw.colors[v].w == 1.0);
            assert!((raw.fields[0].values.at(v * 2) - p.z as f64).abs() < 1e-5);
            assert!(raw.fields[0].values.at(v * 2 + 1).is_nan());
        }
        for (t, corners) in raw.triangles.iter().enumerate() {
            let of_cap = half.cap.contains(&(t as u32));
            let face = raw.fields[1].values.at(t);
            assert_eq!(face.is_nan(), of_cap);
            assert!(of_cap || face as u32 == raw.source_faces[t] && raw.source_faces[t] < n_triangles);
            for (k, &v) in corners.iter().enumerate() {
                let number = raw.fields[2].values.at(t * 3 + k);
                let y = raw.positions[v as usize].y as f64;
                assert!(if of_cap { number.is_nan() } else { (number - y).abs() < 1e-5 });
            }
        }
        let names: Vec<&str> = raw.parts.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["first", "second", CAP_NAME]);
        assert_eq!(raw.parts[0].material, Some(4));
        assert_eq!(raw.parts.last().unwrap().triangles, half.cap);
        assert!(raw.parts.windows(2).all(|w| w[0].triangles.end == w[1].triangles.start));
        assert!(Soup::from(raw).volume() > 0.0);
        let again = raw.clone().mend();
        assert!(again.mended.iter().all(|m| m.what.contains("without area")), "{:?}", again.mended);
    }
}

/// A ball without some of its triangles.
fn torn_ball() -> Mesh {
    let mut raw = ball(Vec3::ZERO, 1.0);
    let keep = |p: Vec3| !(p.y.abs() < 0.25 && p.x > 0.6);
    let p = raw.positions.clone();
    raw.triangles.retain(|t| t.iter().all(|&v| keep(p[v as usize])));
    raw.mend().value
}

#[test]
fn gaps_are_reported_and_treated_as_told() {
    let mesh = torn_ball();
    let plane = Plane::through(vec3(0.0, 0.03, 0.0), Vec3::Y).unwrap();
    let refused = cut(&mesh, &plane, Policy::Strict).unwrap_err();
    assert_eq!(refused.gaps.len(), 1);
    assert!(refused.to_string().starts_with("the section does not close: 1 gaps, the widest "), "{refused}");
    let whole = std::f64::consts::PI;
    for (policy, least, bridged) in [
        (Policy::Open, -0.01, false),
        (Policy::Bridge(0.1), -0.01, false),
        (Policy::Bridge(3.0), 0.8 * whole, true),
        (Policy::Winding, 0.8 * whole, false),
    ] {
        let cut = cut(&mesh, &plane, policy).unwrap();
        assert_eq!(cut.gaps.iter().map(|g| g.bridged).collect::<Vec<_>>(), [bridged], "{policy:?}");
        let area = cut.section.area();
        assert!(area > least && area < if least > 0.0 { whole } else { 0.01 }, "{policy:?}: {area}");
        assert_eq!(cut.section.contours.len() + cut.section.open_contours.len(), 1);
    }
}

#[test]
fn winding_numbers_of_open_outlines_are_sums_of_angles() {
    // A ball with a large hole: the cap by winding is what a slow sum of angles over the outline says.
    let mesh = torn_ball();
    let plane = Plane::through(vec3(0.0, 0.03, 0.0), vec3(0.05, 1.0, 0.1)).unwrap();
    let section = cut(&mesh, &plane, Policy::Winding).unwrap().section;
    let slow = |p: DVec2| -> f64 {
        let open = section.open_contours.iter().flat_map(|c| c.windows(2).map(|w| (w[0] - p, w[1] - p)));
        open.map(|(a, b)| crate::math::exact::atan2(a.perp_dot(b), a.dot(b))).sum::<f64>() / std::f64::consts::TAU
    };
    let filled = |p: DVec2| {
        section.triangles.iter().any(|[a, b, c]| {
            let side = |u: DVec2, v: DVec2| (v - u).perp_dot(p - u) >= 0.0;
            side(*a, *b) && side(*b, *c) && side(*c, *a)
        })
    };
    let mut agree = 0;
    for i in 0..2_000 {
        let p = DVec2::new(random(i, 0) as f64, random(i, 1) as f64) * 1.1;
        agree += (filled(p) == (slow(p) > 0.5)) as i32;
    }
    // The cap's border in the gap is that of triangles, not of the winding number.
    assert!(agree > 1_850, "{agree} of 2000");
}

#[test]
fn several_cuts_make_closed_pieces_that_add_up() {
    let mesh = crate::samples::plain::cube(2);
    let planes = [Vec3::X, Vec3::Y, Vec3::Z].map(|n| Plane::through(mesh.bounds().center(), n).unwrap());
    let pieces = cut_in_order(&mesh, &planes, Policy::Strict).unwrap();
    let whole = Soup::from(&mesh).volume();
    assert_eq!(pieces.len(), 8);
    for (raw, sides) in &pieces {
        assert!(topology(raw).is_solid() && sides.len() == 3);
        assert!((Soup::from(raw).volume() - whole / 8.0).abs() < 1e-6 * whole);
        assert_eq!(raw.parts.iter().filter(|p| p.name == CAP_NAME).count(), 3);
    }
    let knot = crate::samples::scene("knot", 16, 0).unwrap().mesh;
    let planes: Vec<Plane> = (0..5).map(|i| random_plane(&knot, i)).collect();
    let pieces = cut_in_order(&knot, &planes, Policy::Strict).unwrap();
    let sum: f64 = pieces.iter().map(|(raw, _)| Soup::from(raw).volume()).sum();
    assert!(pieces.len() > 8 && (sum / Soup::from(&knot).volume() - 1.0).abs() < 1e-6);
    assert!(pieces.iter().all(|(raw, _)| topology(raw).is_solid()));
    assert!(cut_in_order(&knot, &[], Policy::Strict).unwrap().is_empty());
}

#[test]
fn planes_that_miss_leave_one_half_empty() {
    let mesh = crate::samples::plain::cube(1);
    let cut = check_cut(&mesh, &Plane::through(vec3(0.0, 99.0, 0.0), Vec3::Y).unwrap());
    assert!(cut.above.raw.triangles.is_empty() && cut.above.cap.is_empty() && cut.section.contours.is_empty());
    assert_eq!(cut.below.raw.triangles.len(), mesh.triangles().len());
    let none = super::cut(&Mesh::default(), &Plane::through(Vec3::ZERO, Vec3::Y).unwrap(), Policy::Strict).unwrap();
    assert!(none.below.raw.positions.is_empty() && none.above.raw.positions.is_empty());
}

#[test]
fn dirty_soups_never_panic() {
    // The environment may ask for many more.
    let n_rounds = std::env::var("ALL_PLANES").map_or(120, |_| 6_000);
    for round in 0..n_rounds {
        let n = 4 + round as usize % 40;
        // Coarse coordinates: many corners and edges lie on each other and on the plane.
        let p = |i: i32, k: i32| (random(i + round * 1000, k) * 3.0).floor() * if round % 3 == 0 { 1.0 } else { 0.37 };
        let positions: Vec<Vec3> = (0..n as i32).map(|i| vec3(p(i, 0), p(i, 1), p(i, 2))).collect();
        let index = |i: i32, k: i32| hash_cell(i, k, round, 3) % n as u32;
        let triangles = (0..3 * n as i32).map(|i| [index(i, 0), index(i, 1), index(i, 2)]).collect();
        let mesh = raw(positions, triangles);
        let planes = [
            Plane::through(Vec3::ZERO, Vec3::Y).unwrap(),
            Plane::through(Vec3::ZERO, vec3(1.0, 1.0, 0.0)).unwrap(),
            Plane::through(vec3(0.1, 0.0, 0.2), vec3(0.3, 0.5, 0.2)).unwrap(),
            Plane { normal: crate::math::DVec3::NAN, offset: f64::NAN },
        ];
        for plane in &planes {
            for policy in [Policy::Strict, Policy::Open, Policy::Winding, Policy::Bridge(1.0)] {
                if let Ok(cut) = cut(&mesh, plane, policy) {
                    for half in [&cut.below, &cut.above] {
                        let n = half.raw.positions.len() as u32;
                        assert!(half.raw.triangles.iter().flatten().all(|&v| v < n));
                    }
                }
            }
        }
    }
}

#[test]
fn rims_are_as_far_as_a_slow_search_finds_them() {
    let mesh = crate::samples::scene("flange", 32, 0).unwrap().mesh;
    let section = check_cut(&mesh, &random_plane(&mesh, 8)).section;
    let rim = Rim::of(&section);
    let window = section.window(0.3);
    let size = (window.max - window.min).as_dvec2();
    for i in 0..500 {
        let p = window.min.as_dvec2() + size * DVec2::new(random(i, 0) as f64, random(i, 1) as f64);
        let mut slow = f64::INFINITY;
        for c in &section.contours {
            for k in 0..c.len() {
                let (a, b) = (c[k], c[(k + 1) % c.len()]);
                let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                slow = slow.min((p - a - (b - a) * t).length());
            }
        }
        assert!((rim.distance(p) - slow).abs() < 1e-12, "{} not {slow}", rim.distance(p));
    }
    assert!(window.min.cmplt(window.max).all() && Vec2::ZERO.is_finite());
}

#[test]
fn particles_that_would_stick_out_of_the_skin_can_be_left_out() {
    use crate::section::grain::{Grain, GrainSpec};
    let mesh = crate::samples::scene("flange", 32, 0).unwrap().mesh;
    let plane = random_plane(&mesh, 8);
    let section = check_cut(&mesh, &plane).section;
    let rim = Rim::of(&section);
    let spacing = mesh.bounds().radius() * 0.08;
    let grain = Grain::new(GrainSpec::spheres(spacing, spacing * 0.5)).unwrap();
    let discs = grain.discs(&plane, section.window(spacing)).unwrap();
    let n = discs.iter().count();
    let whole = discs.retain(|d| rim.distance(d.at.as_dvec2()) > d.radius as f64);
    assert!(whole.iter().count() > 10 && whole.iter().count() < n);
    for disc in whole.iter() {
        let outline = whole.outline(disc, 12);
        assert!(outline.iter().all(|p| rim.distance(*p) > 0.0));
    }
}

#[test]
fn halves_in_relief_are_closed_and_torn_ones_fit_to_the_bit() {
    use crate::section::grain::{Grain, GrainSpec, Look, SectionKind, Window};
    let mesh = joined([ball(Vec3::ZERO, 1.0)]);
    let plane = Plane::through(vec3(0.0, 0.1, 0.05), vec3(1.0, 0.3, 0.5)).unwrap();
    let grain = Grain::new(GrainSpec::spheres(0.3, 0.15)).unwrap();
    let whole = Soup::from(&mesh).volume();
    let (origin, axes) = section_frame(&mesh, &plane);
    let window = Window { origin, axes, min: Vec2::splat(-1.0), max: Vec2::splat(1.0) };
    let discs = grain.discs(&plane, window).unwrap();
    let points = discs.edges(24);
    for kind in [SectionKind::Tear, SectionKind::Hollow, SectionKind::Solid] {
        let shows = |p, side| grain.eval(p, &plane, Look { kind, side });
        let relief = Relief { pitch: 0.04, points: &points, shows: &shows };
        let cut = cut_with_relief(&mesh, &plane, Policy::Strict, &relief).unwrap();
        let mut sum = 0.0;
        for half in [&cut.below, &cut.above] {
            let t = topology(&half.raw);
            assert!(t.is_solid(), "{kind:?}: {t:?}");
            sum += Soup::from(&half.raw).volume();
        }
        let caps = [&cut.below, &cut.above].map(|half| {
            let range = half.cap_vertices.start as usize..half.cap_vertices.end as usize;
            half.raw.positions[range].to_vec()
        });
        assert!(caps[0].len() > 1_000);
        let high = caps[0].iter().map(|p| plane.distance(p.as_dvec3())).fold(0.0, f64::max);
        match kind {
            SectionKind::Tear => {
                assert!(caps[0] == caps[1] && (sum - whole).abs() < 1e-6 * whole && high > 0.05, "{sum} of {whole}");
            }
            // Both halves lose what the particles or the recess take.
            _ => assert!(sum < 0.999 * whole && sum > 0.9 * whole && high < 1e-6, "{kind:?}: {sum} of {whole}, {high}"),
        }
    }
}
