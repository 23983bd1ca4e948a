//! What a section must hold to, as a list; the items that no other file of tests has.
//!
//! | | claim | where |
//! |---|---|---|
//! | 1 | the quadratic of the paper is the closed form | `balls_agree_with_equations_5_to_7` |
//! | 2 | normals are those of the height field | `normals_are_those_of_the_height_field`, `normals_of_all_fillings_are_those_of_their_heights` |
//! | 3 | torn sides are exact negatives, ties included | `torn_sides_are_exact_negatives_at_a_million_points`, `.._for_all_shapes`, `a_centre_on_the_cut_belongs_to_one_half_only`, `torn_sides_of_all_fillings_are_exact_negatives` |
//! | 4 | exits agree with bisection | `exits_agree_with_bisection` |
//! | 5 | bevels have 45 degrees, and their width in the plane | `bevels_slope_by_45_degrees_down_to_the_matrix`, `gaps_are_distances_to_the_outline`, here |
//! | 6 | no particle is missed | `more_rings_of_cells_change_nothing` |
//! | 7 | particles are apart | `particles_are_apart_by_their_supports_and_by_points` |
//! | 8 | Delesse, 3/4 and Wicksell | `statistics_of_balls_are_as_stereology_has_them`, `lists_hold_circles_with_the_mean_radius_of_wicksell` |
//! | 9 | openness | `openness_agrees_with_shooting_rays_at_the_sky`, `openness_in_cells_agrees_with_shooting_rays_at_the_sky` |
//! | 10 | no window | `the_same_point_in_the_neighbours_coordinates_has_the_same_owner` |
//! | 12 | to the letter, the captions | here, `to_the_letter_cylinders_look_away_and_spheres_do_not`, `to_the_letter_sections_of_cylinders_have_the_captions_outlines` |
//! | 13 | errors with and without the far model | here |
//! | 14 | displaced halves make the model | `halves_in_relief_are_closed_and_torn_ones_fit_to_the_bit` |

use super::curve::{Curve, is_inside};
use super::figures::figures;
use super::shape_tests::random;
use super::*;
use crate::math::{DVec2, vec2, vec3};
use crate::section::Plane;

fn plane(normal: Vec3) -> Plane {
    Plane::through(vec3(0.31, 0.17, 0.73), normal).unwrap()
}

fn look(kind: SectionKind, side: Side) -> Look {
    Look { kind, side }
}

/// From a point to a polygon's border.
fn distance(polygon: &[DVec2], p: DVec2) -> f64 {
    let n = polygon.len();
    let to_edge = |i: usize| {
        let (a, b) = (polygon[i], polygon[(i + 1) % n]);
        let t = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
        p.distance(a + (b - a) * t)
    };
    (0..n).map(to_edge).fold(f64::INFINITY, f64::min)
}

#[test]
fn bevels_are_as_wide_in_the_plane_as_they_are_deep() {
    let rods = Shape::Cylinder { radius: 0.2, height: 0.4, ends: Ends::Flat };
    for shape in [Shape::Sphere { radius: 0.25 }, Shape::Ellipsoid { radii: vec3(0.15, 0.2, 0.3) }, rods] {
        let is_mitred = matches!(shape, Shape::Cylinder { .. });
        let grain = Grain::new(GrainSpec::of(shape, 0.7)).unwrap();
        let t = 0.07 * 0.7;
        let filling = Filling::Particles(Box::new(grain.clone()));
        let plane = plane(vec3(0.2, -0.6, 0.7));
        let window = Window::around(&plane, DVec3::ZERO, vec2(3.0, 3.0));
        let list = outlines(&filling, &plane, &window, &|_| 1.0).unwrap();
        let polygons: Vec<Vec<DVec2>> = list.iter().map(|o| o.curve.polygon(1e-5)).collect();
        let (mut n, mut good) = (0, 0);
        for i in 0..1_500 {
            let at = vec2(random(i, 0) * 3.0, random(i, 1) * 3.0);
            let hit = grain.eval(window.point(at), &plane, look(SectionKind::Solid, Side::Below));
            let p = at.as_dvec2();
            let is_near = |k: &usize| p.distance(list[*k].middle) < list[*k].reach + t;
            let near: Vec<usize> = (0..list.len()).filter(is_near).collect();
            if near.iter().any(|&k| is_inside(&polygons[k], p)) {
                continue;
            }
            let gap = near.iter().map(|&k| distance(&polygons[k], p)).fold(t, f64::min);
            n += 1;
            good += ((-hit.height as f64 - gap).abs() < 0.05 * t) as i32;
        }
        // Mitred corners reach farther than the corner itself is near.
        let least = if is_mitred { 0.95 } else { 0.99 };
        assert!(n > 500 && good as f64 > least * n as f64, "{good} of {n}");
    }
}

/// How often each kind of hit is seen in the letter's sections of a figure.
fn census(grain: &Grain, normal: Vec3, look: Look) -> [usize; 5] {
    let kinds = [HitKind::Matrix, HitKind::Bump, HitKind::Cavity, HitKind::Disc, HitKind::Bevel];
    let mut counts = [0; 5];
    // Several planes: along the lattice's layers one may miss all centres on a side.
    for k in 0..5 {
        let spacing = grain.spec().spacing;
        let plane = Plane { offset: (0.2 * k as f32 * spacing) as f64, ..plane(normal) };
        let window = Window::around(&plane, DVec3::ZERO, vec2(1.0, 1.0) * (6.0 * spacing));
        for i in 0..160 {
            let at = vec2(random(i, 0), random(i, 1)) * window.max;
            let hit = grain.eval(window.point(at), &plane, look);
            counts[kinds.iter().position(|k| *k == hit.kind).unwrap()] += 1;
        }
    }
    counts
}

#[test]
fn to_the_letter_all_figures_show_the_kinds_of_their_captions() {
    for figure in figures() {
        let grain = Grain::new(figure.grain.clone().to_the_letter()).unwrap();
        for side in [Side::Below, Side::Above] {
            let of = |kind| census(&grain, figure.normal, look(kind, side));
            let number = figure.number;
            let [_, bumps, cavities, discs, bevels] = of(SectionKind::Tear);
            assert!(bumps > 40 && cavities > 40 && discs + bevels == 0, "Fig. {number}, tear");
            let [_, bumps, cavities, discs, bevels] = of(SectionKind::Hollow);
            assert!(cavities > 100 && bumps + discs + bevels == 0, "Fig. {number}, hollow");
            let [_, bumps, cavities, discs, bevels] = of(SectionKind::Solid);
            assert!(discs > 100 && bevels > 20 && bumps + cavities == 0, "Fig. {number}, solid");
        }
    }
}

#[test]
fn to_the_letter_all_figures_show_the_outlines_of_their_captions() {
    for figure in figures() {
        let grain = Grain::new(figure.grain.clone().to_the_letter()).unwrap();
        let half = 8.0 * grain.spec().spacing;
        let filling = Filling::Particles(Box::new(grain));
        let plane = plane(figure.normal);
        let window = Window::around(&plane, DVec3::ZERO, vec2(half, half));
        let list = outlines(&filling, &plane, &window, &|_| 1.0).unwrap();
        // Circles, whole ellipses, rectangles, and ellipses cut by the ends: drums.
        let mut counts = [0; 4];
        for outline in &list {
            counts[match &outline.curve {
                Curve::Circle { .. } => 0,
                Curve::Ellipse(_) => 1,
                curve if curve.polygon(1.0).len() == 4 && curve.polygon(1e-6).len() == 4 => 2,
                Curve::Path { .. } => 3,
            }] += 1;
        }
        let [circles, ellipses, rectangles, drums] = counts;
        let n = list.len();
        assert!(n > 60, "Fig. {}", figure.number);
        let is_right = match figure.number {
            6..=9 => circles == n,
            10 => rectangles == n,
            // H = 0.8 S cuts nearly all; whole ellipses need a longer cylinder than that.
            11 => drums + ellipses == n && drums > n / 2,
            _ => drums > n / 4 && circles + rectangles < n / 4,
        };
        assert!(is_right, "Fig. {}: {counts:?} of {n}", figure.number);
    }
}

#[test]
fn the_far_model_makes_a_third_of_the_error_of_bare_points() {
    // A pixel a spacing; 8 x 8 places are the truth.
    let spec = GrainSpec { jitter: 0.1, ..GrainSpec::spheres(1.0, 0.5) };
    let grain = Grain::new(spec).unwrap();
    let plane = plane(vec3(0.3, 0.2, 0.9));
    let [u, v] = plane.axes();
    let look = look(SectionKind::Tear, Side::Below);
    let light = (plane.normal * 0.69 + u * (1.0f64 - 0.69 * 0.69).sqrt()).as_vec3();
    let lit = |p: DVec3| grain.eval(p, &plane, look).normal.dot(light).max(0.0) as f64;
    let (mut truths, mut bare) = (Vec::new(), 0.0);
    const N: usize = 26;
    for k in 0..N * N {
        let p = plane.normal * plane.offset + u * (k % N) as f64 + v * (k / N) as f64;
        let mut truth = 0.0;
        for j in 0..64 {
            let at = |k: usize| (k as f64 + 0.5) / 8.0 - 0.5;
            truth += lit(p + u * at(j % 8) + v * at(j / 8)) / 64.0;
        }
        bare += (lit(p) - truth).powi(2) / (N * N) as f64;
        truths.push(truth);
    }
    let mean = truths.iter().sum::<f64>() / truths.len() as f64;
    let far = Far::measured(1000.0, 4096, &|p| grain.eval_at(p, plane.normal, look));
    // What the far model shows: the mean normal's light.
    let shown = (far.mean_length * plane.normal.as_vec3().dot(light)) as f64;
    let error = (truths.iter().map(|t| (t - shown).powi(2)).sum::<f64>() / truths.len() as f64).sqrt();
    let bare = bare.sqrt();
    // 0.625 for 0.626, 0.181 and 0.056 are the numbers of a grain that covers 0.353 of the area.
    assert!((far.covered - 0.353).abs() < 0.04, "{} covered", far.covered);
    assert!((shown - mean).abs() < 0.02 && (mean - 0.626).abs() < 0.02, "{shown} shown, {mean} in the mean");
    assert!((bare - 0.181).abs() < 0.02 && (error - 0.056).abs() < 0.02, "{bare} bare, {error} with the far model");
    assert!(error < bare / 3.0);
}
