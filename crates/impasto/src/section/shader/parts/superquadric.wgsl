// A superquadric (Barr 1981): its axes as columns, and half lengths along them.
struct Body {
    frame: mat3x3<f32>,
    semi: vec3<f32>,
}

const SHAPE_REACH: f32 = max(RADII.x, max(RADII.y, RADII.z)) / SPACING * SIZE_MOST; // up to exponent 2 //? tipped
const SHAPE_REACH: f32 = length(RADII) / SPACING * SIZE_MOST; // above exponent 2 //? !tipped
const MARGIN: f32 = 2e-4;

// The particle of a cell as it would be alone.
fn free_body(cell: vec3<i32>) -> Body {
    return Body(frame_of(cell), RADII / SPACING * size_of(cell));
}

fn scaled(b: Body, s: f32) -> Body {
    return Body(b.frame, b.semi * s);
}

fn body_reach(b: Body) -> f32 {
    return max(max(b.semi.x, b.semi.y), b.semi.z); //? tipped
    return length(b.semi); //? !tipped
}

// A power of numbers that are not negative.
fn power3(v: vec3<f32>, p: f32) -> vec3<f32> {
    return pow(max(v, vec3<f32>(1e-30)), vec3<f32>(p));
}

// The p-norm of numbers that are not negative.
fn norm3(v: vec3<f32>, p: f32) -> f32 {
    let most: f32 = max(max(v.x, v.y), v.z);
    if (most <= 0.0) {
        return 0.0;
    }
    let powers: vec3<f32> = power3(v / most, p);
    return most * pow(powers.x + powers.y + powers.z, 1.0 / p);
}

fn side_signs(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(side_sign(v.x), side_sign(v.y), side_sign(v.z));
}

fn holds(b: Body, m: vec3<f32>) -> bool {
    return level_of(b, m).value <= 0.0;
}

// A point that is farthest along n.
fn support(b: Body, n: vec3<f32>) -> vec3<f32> {
    let local: vec3<f32> = b.semi * (n * b.frame);
    let dual: f32 = POWER / (POWER - 1.0);
    let norm: f32 = norm3(abs(local), dual);
    if (norm <= 0.0) {
        return vec3<f32>(0.0);
    }
    return b.frame * (b.semi * power3(abs(local) / norm, dual - 1.0) * side_signs(local));
}

// How far it reaches along n: the dual norm.
fn extent(b: Body, n: vec3<f32>) -> f32 {
    return norm3(abs(b.semi * (n * b.frame)), POWER / (POWER - 1.0));
}

fn slab_way(p: f32, d: f32, semi: f32) -> f32 {
    if (d == 0.0) {
        return 1e30;
    }
    return (semi * side_sign(d) - p) / d;
}

fn body_exit(b: Body, m: vec3<f32>, t: vec3<f32>) -> Exit {
    let p: vec3<f32> = m * b.frame;
    let d: vec3<f32> = t * b.frame;
    let x: f32 = slab_way(p.x, d.x, b.semi.x);
    let y: f32 = slab_way(p.y, d.y, b.semi.y);
    return newton_exit(b, m, t, max(min(min(x, y), slab_way(p.z, d.z, b.semi.z)), 0.0));
}

fn level_of(b: Body, m: vec3<f32>) -> Level {
    let p: vec3<f32> = (m * b.frame) / b.semi;
    let norm: f32 = norm3(abs(p), POWER);
    let least: f32 = min(min(b.semi.x, b.semi.y), b.semi.z);
    let slope: vec3<f32> = power3(abs(p) / max(norm, 1e-20), POWER - 1.0) * side_signs(p);
    return Level((norm - 1.0) * least, b.frame * (slope * (vec3<f32>(least) / b.semi)));
}

fn body_gap(b: Body, m: vec3<f32>, n: vec3<f32>) -> Gap {
    return first_order_gap(b, m, n);
}
