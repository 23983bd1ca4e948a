// An ellipsoid: its axes as columns, and half lengths along them.
struct Body {
    frame: mat3x3<f32>,
    semi: vec3<f32>,
}

const SHAPE_REACH: f32 = max(RADII.x, max(RADII.y, RADII.z)) / SPACING * SIZE_MOST;
const MARGIN: f32 = 2e-6;

// The particle of a cell as it would be alone.
fn free_body(cell: vec3<i32>) -> Body {
    return Body(frame_of(cell), RADII / SPACING * size_of(cell));
}

fn scaled(b: Body, s: f32) -> Body {
    return Body(b.frame, b.semi * s);
}

fn body_reach(b: Body) -> f32 {
    return max(max(b.semi.x, b.semi.y), b.semi.z);
}

// To the space in which it is the unit ball.
fn unit_place(b: Body, v: vec3<f32>) -> vec3<f32> {
    return (v * b.frame) / b.semi;
}

fn holds(b: Body, m: vec3<f32>) -> bool {
    let p: vec3<f32> = unit_place(b, m);
    return dot(p, p) <= 1.0;
}

// A point that is farthest along n.
fn support(b: Body, n: vec3<f32>) -> vec3<f32> {
    return b.frame * (b.semi * unit_or(b.semi * (n * b.frame), vec3<f32>(0.0)));
}

// How far it reaches along n.
fn extent(b: Body, n: vec3<f32>) -> f32 {
    return length(b.semi * (n * b.frame));
}

fn body_exit(b: Body, m: vec3<f32>, t: vec3<f32>) -> Exit {
    let p: vec3<f32> = unit_place(b, m);
    let d: vec3<f32> = unit_place(b, t);
    let way: f32 = max(far_root(dot(d, d), dot(p, d), min(dot(p, p) - 1.0, 0.0)), 0.0);
    return Exit(way, unit_or(b.frame * ((p + d * way) / b.semi), t));
}

fn level_of(b: Body, m: vec3<f32>) -> Level {
    let p: vec3<f32> = unit_place(b, m);
    let far: f32 = length(p);
    return Level(far - 1.0, b.frame * (p / (b.semi * max(far, 1e-20))));
}

fn body_gap(b: Body, m: vec3<f32>, n: vec3<f32>) -> Gap {
    return first_order_gap(b, m, n);
}
