//! Truths about wood, spongy bone, agate, geodes, chambers, rounded cells and bubbles that join.

use super::shape_tests::{direction, random};
use super::*;
use crate::math::{dvec3, vec3};
use crate::section::Plane;

const KINDS: [SectionKind; 3] = [SectionKind::Tear, SectionKind::Hollow, SectionKind::Solid];

fn on_plane(i: i32) -> (DVec3, Plane) {
    let plane = Plane::through(vec3(random(i / 97, 20), random(i / 97, 21), 0.3), direction(i / 97, 22)).unwrap();
    let [u, v] = plane.axes();
    let p = plane.normal * plane.offset + u * (random(i, 0) as f64 * 9.0) + v * (random(i, 1) as f64 * 9.0);
    (p, plane)
}

/// How deep below a ball of radius 12 a point is.
fn in_ball(p: DVec3) -> f32 {
    (12.0 - p.length()) as f32
}

fn cells(spec: CellsSpec) -> Filling {
    Filling::Cells(Box::new(Cells::new(spec).unwrap()))
}

fn soft() -> CellsSpec {
    CellsSpec { rounding: 0.2, ..CellsSpec::of(0.9, 0.06) }
}

fn rings(spec: RingsSpec) -> Filling {
    Filling::Rings(Box::new(Rings::new(spec).unwrap()))
}

fn wedges(inner: Filling) -> Filling {
    let wedges = Wedges {
        n: 9,
        center: vec3(0.3, 0.1, -0.2),
        axis: vec3(0.1, 1.0, 0.2),
        spread: 0.4,
        wall: 0.2,
        core: 0.5,
        seed: 3,
    };
    let rooms = Rooms::Wedges(wedges);
    let spec = ChambersSpec { rooms, rind: 1.0, rounding: 0.3, clear: 0.1, inner };
    Filling::Chambers(Box::new(Chambers::new(spec).unwrap()))
}

fn trabeculae(field: Field, skeleton: Skeleton) -> Filling {
    let spec = TrabeculaeSpec { field, skeleton, solid: [0.3; 2], ..TrabeculaeSpec::of(0.8) };
    Filling::Trabeculae(Box::new(Trabeculae::new(spec).unwrap()))
}

fn fillings() -> Vec<(&'static str, Filling)> {
    let ball = |spacing, radius| {
        let contact = Contact::Overlapping;
        let grain = Grain::new(GrainSpec { contact, jitter: 0.5, ..GrainSpec::spheres(spacing, radius) }).unwrap();
        Size::Grain(Box::new(grain))
    };
    let joined = Scales::new(vec![ball(1.1, 0.5), ball(0.5, 0.2), ball(0.3, 0.1)], Mixing::Joined).unwrap();
    let knots = Some(Knots { distance: 12.0, thickness: 0.3, rise: 0.5 });
    let mottle = Mottle { is_everywhere: true, ..Mottle::of(0.7) };
    let bundles = Cells::new(CellsSpec { stretch: vec3(8.0, 1.0, 1.0), ..CellsSpec::of(2.0, 0.1) }).unwrap();
    let fibres = Filling::Fibres(Box::new(Fibres::new(FibresSpec::of(0.3, 0.16, Vec3::X)).unwrap()));
    let rooms = Rooms::Cells(Box::new(bundles));
    let muscle = ChambersSpec { rooms, rind: 0.5, rounding: 0.2, clear: 0.0, inner: fibres };
    vec![
        ("rounded cells", cells(soft())),
        ("nuclei", cells(CellsSpec { nucleus: Some(Nucleus { radius: 0.2, offset: 0.1 }), ..soft() })),
        ("bubbles that join", Filling::Scales(Box::new(joined))),
        ("wood", rings(RingsSpec { knots, ..RingsSpec::of(0.7, vec3(0.2, 1.0, 0.1)) })),
        ("wedges", wedges(cells(CellsSpec { stretch: vec3(2.5, 1.0, 1.0), ..soft() }))),
        ("muscle", Filling::Chambers(Box::new(Chambers::new(muscle).unwrap()))),
        ("mottled", Filling::Mottled(Box::new(Mottled::new(mottle, cells(soft())).unwrap()))),
        ("walls", trabeculae(Field::Waves, Skeleton::Walls)),
        ("network", trabeculae(Field::Waves, Skeleton::Network)),
        ("gyroid", trabeculae(Field::Gyroid, Skeleton::Walls)),
        ("agate", Filling::Bands(Box::new(Bands::new(BandsSpec::of(0.5)).unwrap()))),
        ("geode", Filling::Druse(Box::new(Druse::new(DruseSpec::of(0.8, 2.5)).unwrap()))),
    ]
}

fn eval(filling: &Filling, p: DVec3, plane: &Plane, kind: SectionKind, side: Side) -> Hit {
    filling.eval(p, plane, Look { kind, side }, &in_ball)
}

#[test]
fn torn_sides_of_what_has_pieces_are_exact_negatives() {
    for (name, filling) in fillings() {
        let mut on_particles = 0;
        for i in 0..700 {
            let (p, plane) = on_plane(i);
            let a = eval(&filling, p, &plane, SectionKind::Tear, Side::Below);
            let b = eval(&filling, p, &plane, SectionKind::Tear, Side::Above);
            if filling.has_pieces() {
                assert_eq!((a.height, a.normal), (-b.height, -b.normal), "{name} at {p}");
                assert_eq!((a.particle, a.leaf, a.tone), (b.particle, b.leaf, b.tone), "{name} at {p}");
                on_particles += (a.kind == HitKind::Bump || a.kind == HitKind::Cavity) as i32;
            } else {
                let hollow = eval(&filling, p, &plane, SectionKind::Hollow, Side::Below);
                assert_eq!(a, hollow, "{name}: torn, it is hollow");
            }
        }
        assert!(!filling.has_pieces() || on_particles > 100, "{name}: {on_particles}");
    }
}

#[test]
fn normals_are_those_of_the_heights() {
    const STEP: f64 = 1e-4;
    for (name, filling) in fillings() {
        // Crystals turn a little with the place of the wall from which they are seen, which their normals leave out.
        let (least, share) = if name == "geode" { (0.96, 0.88) } else { (0.99, 0.96) };
        for kind in KINDS {
            let (mut n, mut good) = (0, 0);
            for i in 0..300 {
                let (p, plane) = on_plane(i);
                let at = |q| eval(&filling, q, &plane, kind, Side::Below);
                let hit = at(p);
                let [u, v] = plane.axes();
                if hit.normal.as_dvec3().dot(plane.normal) < 0.3 {
                    continue;
                }
                let near = [u, -u, v, -v].map(|d| at(p + d * STEP));
                let is_smooth = |h: &Hit| {
                    h.kind == hit.kind
                        && h.particle == hit.particle
                        && h.leaf == hit.leaf
                        && h.normal.dot(hit.normal) > 0.995
                };
                // At the end of a year the height falls so fast that these steps are too long.
                let (low, high) = (near.iter().map(|h| h.height).fold(f32::INFINITY, f32::min), near.map(|h| h.height));
                let is_jump = high.iter().any(|h| h - low > 20.0 * STEP as f32);
                if is_jump || !near.iter().all(is_smooth) {
                    continue;
                }
                let slope = |a: Hit, b: Hit| (a.height - b.height) as f64 / (2.0 * STEP);
                let truth = plane.normal - u * slope(near[0], near[1]) - v * slope(near[2], near[3]);
                n += 1;
                good += (hit.normal.as_dvec3().dot(truth.normalize()) > least) as i32;
            }
            assert!(n > 20 && good as f64 > share * n as f64, "{name} {kind:?}: {good} of {n}");
        }
    }
}

#[test]
fn hits_are_sane_at_extreme_numbers() {
    let far = dvec3(1e7, -3e6, 2e5);
    let mut all = fillings();
    all.push((
        "thin wood",
        rings(RingsSpec {
            bend: 50.0,
            waviness: 5.0,
            width_spread: 1.0,
            lateness: 12.0,
            ..RingsSpec::of(1e-3, Vec3::X)
        }),
    ));
    all.push((
        "sharp and flat",
        cells(CellsSpec { rounding: 0.9, stretch: vec3(20.0, 0.05, 1.0), jitter: 0.5, ..CellsSpec::of(0.9, 0.9) }),
    ));
    let druse = DruseSpec { lean: 1.0, radius: 0.8, length: 1.1, ..DruseSpec::of(5.0, 0.0) };
    all.push(("all hollow", Filling::Druse(Box::new(Druse::new(druse).unwrap()))));
    for (name, filling) in all {
        for i in 0..24 {
            let (p, plane) = on_plane(i);
            let p = if i % 4 == 0 { p + far } else { p };
            for (kind, side) in KINDS.iter().flat_map(|&k| [(k, Side::Below), (k, Side::Above)]) {
                // Even where the depth is not known.
                for depth in [&in_ball as &dyn Fn(DVec3) -> f32, &|_| 0.0, &|_| f32::INFINITY] {
                    let hit = filling.eval(p, &plane, Look { kind, side }, depth);
                    assert!(hit.height.is_finite() && (hit.normal.length() - 1.0).abs() < 1e-3, "{name}: {hit:?}");
                    assert!(
                        (0.0..=1.0).contains(&hit.tone) && (0.0..=1.001).contains(&hit.openness),
                        "{name}: {hit:?}"
                    );
                    assert!(hit.leaf < filling.n_leaves(), "{name}: {hit:?}");
                }
            }
        }
    }
}

#[test]
fn trabeculae_fill_the_share_that_is_asked_for() {
    for (field, skeleton) in
        [(Field::Waves, Skeleton::Walls), (Field::Waves, Skeleton::Network), (Field::Gyroid, Skeleton::Walls)]
    {
        let filling = trabeculae(field, skeleton);
        let n = 3_000;
        let solid = (0..n).filter(|&i| {
            let (p, plane) = on_plane(i * 31);
            eval(&filling, p, &plane, SectionKind::Solid, Side::Below).kind == HitKind::Disc
        });
        let share = solid.count() as f64 / n as f64;
        assert!((share - 0.3).abs() < 0.04, "{field:?} {skeleton:?}: {share}");
    }
}

#[test]
fn voids_end_at_the_wall_that_many_small_steps_find() {
    let filling = trabeculae(Field::Waves, Skeleton::Walls);
    let (mut n, mut good) = (0, 0);
    for i in 0..400 {
        let (p, plane) = on_plane(i);
        let hit = eval(&filling, p, &plane, SectionKind::Hollow, Side::Below);
        if hit.kind != HitKind::Cavity || hit.leaf == 1 {
            continue;
        }
        let is_solid = |way: f64| {
            let q = p - plane.normal * way;
            let below = Plane { offset: plane.normal.dot(q), ..plane };
            eval(&filling, q, &below, SectionKind::Hollow, Side::Below).kind == HitKind::Disc
        };
        let way = -hit.height as f64;
        n += 1;
        good += (is_solid(way + 2e-3) && !(1..40).any(|k| is_solid(way * k as f64 / 40.0 - 2e-3))) as i32;
    }
    assert!(n > 150 && good as f64 > 0.97 * n as f64, "{good} of {n}");
}

#[test]
fn what_is_in_a_wedge_stays_in_it() {
    let inner = Grain::new(GrainSpec::spheres(0.5, 0.2)).unwrap();
    let filling = wedges(Filling::Particles(Box::new(inner)));
    let plane = Plane::through(vec3(0.3, 0.1, -0.2), vec3(0.1, 1.0, 0.2)).unwrap();
    let [u, v] = plane.axes();
    let (mut walls, mut rooms) = (0, std::collections::BTreeSet::new());
    let mut room_of = std::collections::BTreeMap::new();
    for i in 0..2_500 {
        let p = plane.normal * plane.offset + u * (random(i, 0) as f64 * 10.0) + v * (random(i, 1) as f64 * 10.0);
        let hit = eval(&filling, p, &plane, SectionKind::Solid, Side::Below);
        walls += (hit.leaf == 0) as i32;
        if hit.kind == HitKind::Matrix && hit.leaf == 1 {
            rooms.insert(hit.particle);
        }
        if hit.kind == HitKind::Disc {
            // A particle's places are all near the first: in no other room is one of its name.
            let first = *room_of.entry(hit.particle).or_insert(p);
            assert!(p.distance(first) < 0.45, "{p} {first}");
        }
    }
    assert!(walls > 100 && rooms.len() >= 8, "{walls} {rooms:?}");
}

#[test]
fn a_log_has_as_many_rings_as_its_radius_has_widths() {
    let even = RingsSpec {
        bend: 0.0,
        waviness: 0.0,
        width_spread: 0.0,
        streaks: 0.0,
        rays: 0.0,
        pores: None,
        ..RingsSpec::of(0.1, Vec3::Y)
    };
    let filling = rings(even);
    let plane = Plane::through(Vec3::ZERO, Vec3::Y).unwrap();
    let at = |r: f64| eval(&filling, dvec3(r, 0.0, 0.0), &plane, SectionKind::Solid, Side::Below);
    let ends = (1..20_000).filter(|&k| {
        let (before, after) = (at((k - 1) as f64 * 1e-4), at(k as f64 * 1e-4));
        // Late wood, and the next year's early wood after it.
        before.tone > 0.3 && after.tone <= 0.3
    });
    assert_eq!(ends.count(), 20);
    assert!(at(0.093).height > at(0.05).height, "late wood stands higher");
}

#[test]
fn a_geode_is_hollow_in_the_middle_and_lined_with_facets() {
    let filling = Filling::Druse(Box::new(Druse::new(DruseSpec::of(0.8, 2.5)).unwrap()));
    let plane = Plane::through(Vec3::ZERO, Vec3::Z).unwrap();
    let at = |x: f64, y: f64| eval(&filling, dvec3(x, y, 0.0), &plane, SectionKind::Solid, Side::Below);
    assert_eq!(at(11.0, 0.0).kind, HitKind::Disc);
    let middle = at(0.1, 0.2);
    // The far wall is 9.5 away; crystals stand on it.
    assert!(middle.kind == HitKind::Cavity && (-9.6..-8.4).contains(&middle.height), "{middle:?}");
    let (mut names, mut n, mut flat) = (std::collections::BTreeSet::new(), 0, 0);
    for i in 0..300 {
        let (x, y) = (random(i, 0) as f64 * 4.0, random(i, 1) as f64 * 4.0);
        let (hit, beside) = (at(x, y), at(x + 0.02, y));
        if hit.particle != Hit::MATRIX && hit.particle == beside.particle {
            names.insert(hit.particle);
            n += 1;
            flat += (hit.normal.dot(beside.normal) > 0.9995) as i32;
        }
    }
    assert!(
        names.len() > 30 && n > 100 && flat * 5 > n * 4,
        "{} crystals, {flat} of {n} places on facets",
        names.len()
    );
}

#[test]
fn bad_numbers_give_one_clear_line() {
    let rings = |spec: RingsSpec| Rings::new(spec).unwrap_err().to_string();
    let wood = || RingsSpec::of(1.0, Vec3::Y);
    assert!(rings(RingsSpec { axis: Vec3::ZERO, ..wood() }).starts_with("axis \"0,0,0\""));
    assert!(rings(RingsSpec { lateness: f32::NAN, ..wood() }).starts_with("lateness"));
    assert!(
        rings(RingsSpec { knots: Some(Knots { distance: 0.0, thickness: 0.2, rise: 0.0 }), ..wood() })
            .starts_with("knot")
    );
    let bone = |spec: TrabeculaeSpec| Trabeculae::new(spec).unwrap_err().to_string();
    assert!(bone(TrabeculaeSpec { solid: [0.0, 0.2], ..TrabeculaeSpec::of(1.0) }).starts_with("solid share"));
    assert!(bone(TrabeculaeSpec { load: Vec3::NAN, ..TrabeculaeSpec::of(1.0) }).starts_with("load"));
    assert!(Bands::new(BandsSpec::of(-1.0)).unwrap_err().to_string().starts_with("spacing"));
    assert!(
        Druse::new(DruseSpec { length: 3.0, ..DruseSpec::of(1.0, 1.0) })
            .unwrap_err()
            .to_string()
            .starts_with("crystal")
    );
    assert!(Scales::new(Vec::new(), Mixing::Joined).unwrap_err().to_string().starts_with("sizes"));
    let mottle = Mottle { n_octaves: 0, ..Mottle::of(1.0) };
    assert!(Mottled::new(mottle, Filling::Plain).unwrap_err().to_string().starts_with("octaves"));
    let waves = Waves { height: 2.0, length: 1.0, n_octaves: 1, seed: 0 };
    assert!(Wavy::new(waves, Filling::Plain).unwrap_err().to_string().starts_with("wave height"));
    let n = Wedges { n: 1, center: Vec3::ZERO, axis: Vec3::Y, spread: 0.0, wall: 0.0, core: 0.0, seed: 0 };
    let rooms = Rooms::Wedges(n);
    let spec = ChambersSpec { rooms, rind: 0.0, rounding: 0.0, clear: 0.0, inner: Filling::Plain };
    assert!(Chambers::new(spec).unwrap_err().to_string().starts_with("wedges"));
    assert!(
        Cells::new(CellsSpec { rounding: 2.0, ..CellsSpec::of(1.0, 0.0) })
            .unwrap_err()
            .to_string()
            .starts_with("rounding")
    );
    let nucleus = Some(Nucleus { radius: -1.0, offset: 0.0 });
    assert!(
        Cells::new(CellsSpec { nucleus, ..CellsSpec::of(1.0, 0.0) }).unwrap_err().to_string().starts_with("nucleus")
    );
}
