// A ball.
struct Body {
    radius: f32,
}

const MOST_RADIUS: f32 = max(RADIUS / SPACING, 0.5);
const SHAPE_REACH: f32 = min(RADIUS / SPACING * SIZE_MOST, MOST_RADIUS);
const MARGIN: f32 = 2e-6;

// The particle of a cell as it would be alone.
fn free_body(cell: vec3<i32>) -> Body {
    let size: f32 = mix(SIZE_LEAST, SIZE_MOST, 0.5 + 0.5 * size_chance(cell).x);
    return Body(min(RADIUS / SPACING * size, MOST_RADIUS));
}

fn scaled(b: Body, s: f32) -> Body {
    return Body(b.radius * s);
}

fn body_reach(b: Body) -> f32 {
    return b.radius;
}

fn holds(b: Body, m: vec3<f32>) -> bool {
    return dot(m, m) <= b.radius * b.radius;
}

// How far it reaches along n.
fn extent(b: Body, n: vec3<f32>) -> f32 {
    return b.radius;
}

fn body_exit(b: Body, m: vec3<f32>, t: vec3<f32>) -> Exit {
    let along: f32 = dot(m, t);
    let across: vec3<f32> = m - t * along;
    let chord: f32 = sqrt(max(b.radius * b.radius - dot(across, across), 0.0));
    return Exit(max(chord - along, 0.0), unit_or(across + t * chord, t));
}

// To the disc that the section through m cuts out.
fn body_gap(b: Body, m: vec3<f32>, n: vec3<f32>) -> Gap {
    let height: f32 = dot(m, n);
    let across: vec3<f32> = m - n * height;
    let disc: f32 = sqrt(max(b.radius * b.radius - height * height, 0.0));
    return Gap(length(across) - disc, unit_or(across, vec3<f32>(0.0)));
}

// How much sky the walls of its cavity see: the same everywhere in it.
fn cavity_openness(b: Body, m: vec3<f32>, n: vec3<f32>, exit: Exit) -> f32 {
    return clamp((b.radius - dot(m, n)) / (2.0 * b.radius), 0.0, 1.0);
}
