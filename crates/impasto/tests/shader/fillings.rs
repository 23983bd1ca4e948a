//! One of each filling, by name.

use impasto::math::{Vec3, hash_cell, unit_float, vec3};
use impasto::section::grain::*;

/// The names of those that are compared.
pub(crate) const FILLINGS: [&str; 24] = [
    "balls",
    "upright",
    "grown",
    "overlapping",
    "noise",
    "letter",
    "rods",
    "domed_rods",
    "soft_rods",
    "ellipsoids",
    "capsules",
    "boxes",
    "soft_boxes",
    "dodecahedra",
    "superquadrics",
    "stars",
    "plain",
    "two_scales",
    "voronoi",
    "walls",
    "laguerre",
    "fibres",
    "sharp_fibres",
    "layers",
];

/// Spacings are about 0.6.
pub(crate) fn filling(name: &str) -> Filling {
    let balls = GrainSpec::spheres(0.6, 0.3);
    let of = |shape| GrainSpec::of(shape, 0.6);
    let rod = |ends| of(Shape::Cylinder { radius: 0.25, height: 0.5, ends });
    let soft_box = Shape::Box { edges: vec3(0.3, 0.4, 0.6), rounding: 0.05 };
    let superquadric = |power| of(Shape::Superquadric { radii: vec3(0.25, 0.25, 0.35), power });
    let stretched = CellsSpec { stretch: vec3(1.0, 3.0, 0.7), weight_spread: 0.3, ..CellsSpec::of(0.7, 0.0) };
    let fibre = FibresSpec::of(0.5, 0.22, vec3(0.2, 1.0, 0.1));
    match name {
        "balls" => particles(balls),
        "upright" => particles(GrainSpec { lattice: LatticeAxes::Model, seed: 7, ..balls }),
        "grown" => particles(GrainSpec { contact: Contact::Apart { grow: 1.5 }, bevel_within_particle: true, ..balls }),
        "overlapping" => particles(GrainSpec { contact: Contact::Overlapping, jitter: 0.45, ..balls }),
        "noise" => particles(GrainSpec { chance: Chance::Noise { frequency: 0.37 }, shrink_only: true, ..balls }),
        "letter" => particles(balls.to_the_letter()),
        "turned balls" => {
            let (jitter, size_spread, bevel, seed) = (0.4, 0.1, 0.12, 12345);
            particles(GrainSpec { jitter, size_spread, bevel, seed, ..GrainSpec::spheres(0.85, 0.8) })
        }
        "endless layers" => {
            Filling::Layers(vec![layer(f32::NAN, particles(balls), false), layer(1.0, Filling::Plain, false)])
        }
        "paper rods" => particles(GrainSpec::cylinders(1.0, 0.5, 0.8, Vec3::Z).to_the_letter()),
        "rods" => particles(rod(Ends::Flat)),
        "domed_rods" => particles(GrainSpec { axis: Axis::Along(vec3(1.0, 2.0, 0.5)), ..rod(Ends::Domed) }),
        "soft_rods" => particles(GrainSpec { axis: Axis::Perturbed(Vec3::Y, 0.8), ..rod(Ends::Soft) }),
        "ellipsoids" => particles(of(Shape::Ellipsoid { radii: vec3(0.15, 0.2, 0.5) })),
        "capsules" => {
            let shape = Shape::Capsule { radius: 0.15, height: 0.8 };
            particles(GrainSpec { axis: Axis::Cone(vec3(0.0, 1.0, 1.0), 0.5), ..of(shape) })
        }
        "boxes" => particles(of(Shape::Box { edges: vec3(0.3, 0.4, 0.6), rounding: 0.0 })),
        "soft_boxes" => particles(GrainSpec { axis: Axis::Radial(vec3(1.0, 0.5, 0.2)), ..of(soft_box) }),
        "dodecahedra" => particles(of(Shape::Polyhedron(Polyhedron::regular(12, 0.25).unwrap()))),
        "superquadrics" => particles(superquadric(4.0)),
        "stars" => particles(superquadric(1.5)),
        "plain" => Filling::Plain,
        "two_scales" => two_scales(),
        "voronoi" => cells(CellsSpec::of(0.7, 0.0)),
        "walls" => cells(CellsSpec::of(0.7, 0.1)),
        "laguerre" => cells(CellsSpec { lattice: LatticeAxes::Model, ..stretched }),
        "fibres" => fibres(fibre),
        "sharp_fibres" => fibres(FibresSpec { rounding: 0.0, length: 2.0, ..fibre }),
        "layers" => Filling::Layers(vec![
            layer(-20.0, Filling::Plain, false),
            layer(-10.0, particles(balls), true),
            layer(0.0, two_scales(), false),
            layer(10.0, cells(CellsSpec::of(0.7, 0.1)), false),
            layer(20.0, fibres(fibre), true),
            layer(
                40.0,
                Filling::Layers(vec![layer(30.0, particles(rod(Ends::Soft)), false), layer(0.0, two_scales(), true)]),
                true,
            ),
            layer(f32::INFINITY, cells(CellsSpec::of(0.5, 0.0)), false),
        ]),
        other => panic!("no filling is called {other}"),
    }
}

/// A grain with numbers by chance: any shape, axis, contact, lattice and chance.
pub(crate) fn random_grain(i: i32) -> GrainSpec {
    let even = |k: i32| unit_float(hash_cell(i, k, 0, 31));
    let one_of = |k: i32, n: usize| (even(k) * n as f32) as usize;
    let spacing = 0.4 + 0.4 * even(22);
    let length = |k: i32| spacing * (0.15 + 0.25 * even(k));
    let radii = vec3(length(1), length(2), length(3));
    let direction = vec3(even(4) - 0.5, even(5) - 0.5, even(6) - 0.5);
    let shapes = [
        Shape::Sphere { radius: radii.x },
        Shape::Ellipsoid { radii },
        Shape::Cylinder { radius: radii.x, height: radii.y * 2.0, ends: Ends::Rounded(even(7) * 0.9 + 0.05) },
        Shape::Cylinder { radius: radii.x, height: radii.y * 2.0, ends: Ends::Flat },
        Shape::Capsule { radius: radii.x, height: radii.x * 2.0 + radii.y },
        Shape::Box { edges: radii * 1.6, rounding: 0.0 },
        Shape::Box { edges: radii * 1.6, rounding: radii.min_element() * 0.7 },
        Shape::Polyhedron(Polyhedron::regular([4, 6, 8, 20][one_of(8, 4)], radii.x).unwrap()),
        Shape::Superquadric { radii, power: 1.2 + 5.0 * even(9) },
    ];
    let axes = [
        Axis::Along(direction),
        Axis::Perturbed(direction, 2.0 * even(10)),
        Axis::Cone(direction, 3.0 * even(10)),
        Axis::Isotropic,
        Axis::Radial(direction * 10.0),
    ];
    let apart = |grow| Contact::Apart { grow };
    let noise = Chance::Noise { frequency: 0.1 + even(11) };
    GrainSpec {
        axis: axes[one_of(12, 5)],
        jitter: 0.5 * even(13),
        size_spread: 0.6 * even(14),
        height_spread: 0.6 * even(15),
        shrink_only: even(16) < 0.3,
        chance: if even(17) < 0.15 { noise } else { Chance::Hash },
        lattice: [LatticeAxes::Turned, LatticeAxes::Model][one_of(18, 2)],
        contact: [apart(1.0), apart(1.0), apart(1.2), Contact::Overlapping][one_of(19, 4)],
        bevel: 0.2 * even(20),
        bevel_within_particle: even(21) < 0.5,
        seed: i as u32 * 77,
        ..GrainSpec::of(shapes[i as usize % shapes.len()].clone(), spacing)
    }
}

fn particles(spec: GrainSpec) -> Filling {
    Filling::Particles(Box::new(Grain::new(spec).unwrap()))
}

fn cells(spec: CellsSpec) -> Filling {
    Filling::Cells(Box::new(Cells::new(spec).unwrap()))
}

fn fibres(spec: FibresSpec) -> Filling {
    Filling::Fibres(Box::new(Fibres::new(spec).unwrap()))
}

fn two_scales() -> Filling {
    let grain = |spacing, radius| Size::Grain(Box::new(Grain::new(GrainSpec::spheres(spacing, radius)).unwrap()));
    Filling::Scales(Box::new(Scales::new(vec![grain(1.2, 0.5), grain(0.25, 0.1)], Mixing::Apart(0.02)).unwrap()))
}

fn layer(until: f32, filling: Filling, strict: bool) -> Layer {
    Layer { until, filling, strict }
}
