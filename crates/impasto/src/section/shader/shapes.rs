//! What a particle's shape needs of a shader: its parts and its numbers.

use super::parameters::{Constants, vector, vector4};
use super::template::{Item, items};
use crate::math::{Vec3, exact};
use crate::section::grain::{Axis, Chance, Contact, Ends, GrainSpec, Polyhedron, Shape, lattice_rotation};

/// The numbers of a shape, the parts that know it, and what these ask for.
pub(super) fn shape(shape: &Shape, constants: &mut Constants, parts: &mut Vec<&str>, flags: &mut Vec<&str>) {
    match shape {
        Shape::Sphere { radius } => {
            constants.float("RADIUS", *radius, "of the balls before it is perturbed, model units");
            parts.push(include_str!("parts/ball.wgsl"));
            return;
        }
        Shape::Ellipsoid { radii } => {
            constants.vector(
                "RADII",
                *radii,
                "half lengths of the ellipsoids; the third is along the axis; model units",
            );
            parts.push(include_str!("parts/ellipsoid.wgsl"));
        }
        Shape::Cylinder { radius, height, ends } => {
            let rounding = match ends {
                Ends::Flat | Ends::Domed => 0.0,
                Ends::Rounded(e) => *e,
                Ends::Soft => 0.15,
            };
            constants.float("RADIUS", *radius, "of the cylinders before it is perturbed, model units");
            constants.float("HEIGHT", *height, "from end to end, model units");
            constants.float(
                "ROUNDING",
                rounding,
                "radius of the rounded rims, as a part of the radius: 0, or above it",
            );
            flags.extend((rounding > 0.0).then_some("rounded"));
            flags.extend((*ends == Ends::Domed).then_some("domed"));
            parts.extend([include_str!("parts/rod.wgsl"), include_str!("parts/rod_free.wgsl")]);
        }
        Shape::Capsule { radius, height } => {
            constants.float("RADIUS", *radius, "of the capsules before it is perturbed, model units");
            constants.float("HEIGHT", *height, "from end to end, half balls included, model units");
            parts.push(include_str!("parts/capsule.wgsl"));
        }
        Shape::Box { edges, rounding } => {
            constants.vector("EDGES", *edges, "edges of the boxes; the third is along the axis; model units");
            constants.float("ROUNDING", *rounding, "radius of the rounded edges, model units: 0, or above it");
            flags.extend((*rounding > 0.0).then_some("rounded"));
            parts.extend([include_str!("parts/box.wgsl"), include_str!("parts/faces.wgsl")]);
        }
        Shape::Polyhedron(_) => {
            parts.extend([include_str!("parts/facets.wgsl"), include_str!("parts/faces.wgsl")]);
        }
        Shape::Superquadric { radii, power } => {
            constants.vector("RADII", *radii, "half lengths of the bodies; the third is along the axis; model units");
            constants.float(
                "POWER",
                *power,
                "their exponent, up to 2 or above it: 2 is an ellipsoid, more is closer to a box",
            );
            flags.extend((*power <= 2.0).then_some("tipped"));
            parts.push(include_str!("parts/superquadric.wgsl"));
        }
    }
    parts.extend([include_str!("parts/implicit.wgsl"), include_str!("parts/openness.wgsl")]);
}

/// The numbers that do not depend on the shape.
pub(super) fn numbers(spec: &GrainSpec, constants: &mut Constants, flags: &mut Vec<&str>) {
    let least = |spread: f32| 1.0 - spread;
    let most = |spread: f32| if spec.shrink_only { 1.0 } else { 1.0 + spread };
    constants.float(
        "SIZE_LEAST",
        least(spec.size_spread),
        "sizes are between this and the next factor of the given one",
    );
    constants.float("SIZE_MOST", most(spec.size_spread), "the greatest factor");
    constants.float("HEIGHT_LEAST", least(spec.height_spread), "heights are between this and the next factor");
    constants.float("HEIGHT_MOST", most(spec.height_spread), "the greatest factor");
    let (axis, word) = match spec.axis {
        Axis::Along(v) => (v, "along"),
        Axis::Perturbed(v, amount) => {
            constants.float("AXIS_AMOUNT", amount, "how long a vector of chance is added to the axis");
            (v, "perturbed")
        }
        Axis::Cone(v, angle) => {
            let cosine = exact::cos(angle as f64) as f32;
            constants.float("CONE_COSINE", cosine, "cosine of the angle within which axes lie about the main one");
            (v, "cone")
        }
        Axis::Isotropic => {
            constants.float("CONE_COSINE", -1.0, "cosine of the angle within which axes lie about the main one: all");
            (lattice_rotation(spec.lattice).col(2).as_vec3(), "cone")
        }
        Axis::Radial(from) => {
            constants.vector("FOCUS", from, "axes point away from here, model space");
            (Vec3::Z, "radial")
        }
    };
    flags.push(word);
    let axis = axis.as_dvec3().normalize().as_vec3();
    constants.vector("AXIS", axis, "where particles' axes point, a unit vector in model space");
    constants.float("JITTER", spec.jitter, "how far centres move off the nodes along each axis, spacings: 0 to 0.5");
    let grow = if let Contact::Apart { grow } = spec.contact { grow } else { 1.0 };
    constants.float(
        "GROW",
        grow,
        "1, or above it: particles may grow by this factor before they shrink for their neighbours",
    );
    constants.float("BEVEL_WIDTH", spec.bevel, "depth and width of a solid cut's bevel, spacings");
    if let Chance::Noise { frequency } = spec.chance {
        constants.float("NOISE_FREQUENCY", frequency, "lattice units of the noise from one particle to the next");
    }
    constants.unsigned("SEED", spec.seed, "another seed, another grain");
}

/// The functions that go over a polyhedron's faces or corners, one line each: no array is read where a ray is traced.
pub(super) fn unrolled(polyhedron: &Polyhedron) -> Vec<Item> {
    let faces: Vec<String> = polyhedron.faces.iter().map(|f| vector4(f.truncate(), f.w)).collect();
    let over = |head: &str, start: &str, lines: Vec<String>, end: &str| {
        let lines: String = lines.iter().map(|l| format!("    {l}\n")).collect();
        items(&format!("{head} {{\n    {start}\n{lines}    {end}\n}}\n"))
    };
    let value = |f: &String| format!("value = max(value, dot(vec4<f32>(p, -size), {f}));");
    let corner = |c: &Vec3| format!("best = farther(best, {}, n);", vector(*c));
    let mut all = over(
        "// How far a point is above the faces' planes at most.\nfn most_above(p: vec3<f32>, size: f32) -> f32",
        "var value: f32 = -1e30;",
        faces.iter().map(value).collect(),
        "return value;",
    );
    all.extend(over(
        "// The first face that a ray goes out through.\nfn first_face(p: vec3<f32>, d: vec3<f32>, size: f32) -> Exit",
        "var first: Exit = Exit(1e30, d);",
        faces.iter().map(|f| format!("first = passed(first, {f}, p, d, size);")).collect(),
        "return first;",
    ));
    all.extend(over(
        "fn farthest_corner(n: vec3<f32>) -> vec3<f32>",
        "var best: vec3<f32> = vec3<f32>(0.0);",
        polyhedron.corners.iter().map(corner).collect(),
        "return best;",
    ));
    all.extend(over(
        "fn body_gap(b: Body, m: vec3<f32>, n: vec3<f32>) -> Gap",
        "var gap: Gap = Gap(-1e30, vec3<f32>(0.0));",
        faces.iter().map(|f| format!("gap = face_gap(gap, {f}, b, m, n);")).collect(),
        "return gap;",
    ));
    all
}
