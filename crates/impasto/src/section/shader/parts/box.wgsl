// A box: its axes as columns, and half edges.
struct Body {
    frame: mat3x3<f32>,
    semi: vec3<f32>,
    rounding: f32, // radius of its edges //? rounded
}

const SHAPE_REACH: f32 = length(EDGES) * 0.5 / SPACING * SIZE_MOST;
const MARGIN: f32 = 2e-6;

// The particle of a cell as it would be alone.
fn free_body(cell: vec3<i32>) -> Body {
    let size: f32 = size_of(cell) / SPACING;
    return Body(frame_of(cell), EDGES * (0.5 * size)[[rounded|, ROUNDING * size]]);
}

fn scaled(b: Body, s: f32) -> Body {
    return Body(b.frame, b.semi * s[[rounded|, b.rounding * s]]);
}

fn body_reach(b: Body) -> f32 {
    return length(b.semi);
}

fn side_signs(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(side_sign(v.x), side_sign(v.y), side_sign(v.z));
}

fn holds(b: Body, m: vec3<f32>) -> bool {
    return level_of(b, m).value <= 0.0; //? rounded
    let p: vec3<f32> = abs(m * b.frame); //? !rounded
    return p.x <= b.semi.x && p.y <= b.semi.y && p.z <= b.semi.z; //? !rounded
}

// A point that is farthest along n.
fn support(b: Body, n: vec3<f32>) -> vec3<f32> {
    let signs: vec3<f32> = side_signs(n * b.frame);
    return b.frame * (b.semi * signs); //? !rounded
    return b.frame * ((b.semi - vec3<f32>(b.rounding)) * signs) + n * b.rounding; //? rounded
}

// How far it reaches along n.
fn extent(b: Body, n: vec3<f32>) -> f32 {
    return dot(support(b, n), n);
}

// How far along one axis a ray goes to its end; never, if it does not move along it.
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
    let z: f32 = slab_way(p.z, d.z, b.semi.z);
    let way: f32 = max(min(min(x, y), z), 0.0);
    // On a face, away from its rounded edges, the body is the sharp box. //? rounded
    let q: vec3<f32> = abs(p + d * way) - (b.semi - vec3<f32>(b.rounding)); //? rounded
    // Two of the three are beyond: so is the middle one. //? rounded
    if (max(min(q.x, q.y), min(max(q.x, q.y), q.z)) > 0.0) { //? rounded
        return newton_exit(b, m, t, way); //? rounded
    } //? rounded
    if (x <= y && x <= z) {
        return Exit(way, b.frame[0] * side_sign(d.x));
    }
    if (y <= z) {
        return Exit(way, b.frame[1] * side_sign(d.y));
    }
    return Exit(way, b.frame[2] * side_sign(d.z));
}

// Distance to the surface, edges rounded.
fn level_of(b: Body, m: vec3<f32>) -> Level {
    let p: vec3<f32> = m * b.frame;
    let signs: vec3<f32> = side_signs(p);
    let q: vec3<f32> = abs(p) - (b.semi - vec3<f32>(b.rounding));
    let beyond: vec3<f32> = max(q, vec3<f32>(0.0));
    let far: f32 = length(beyond);
    if (far > 0.0) {
        return Level(far - b.rounding, b.frame * (beyond * signs / far));
    }
    if (q.x >= q.y && q.x >= q.z) {
        return Level(q.x - b.rounding, b.frame[0] * signs.x);
    }
    if (q.y >= q.z) {
        return Level(q.y - b.rounding, b.frame[1] * signs.y);
    }
    return Level(q.z - b.rounding, b.frame[2] * signs.z);
}

fn body_gap(b: Body, m: vec3<f32>, n: vec3<f32>) -> Gap {
    return first_order_gap(b, m, n); //? rounded
    let p: vec3<f32> = m * b.frame; //? !rounded
    let above: vec3<f32> = abs(p) - b.semi; //? !rounded
    var gap: Gap = Gap(-1e30, vec3<f32>(0.0)); //? !rounded
    gap = widened(gap, above.x, b.frame[0] * side_sign(p.x), n); //? !rounded
    gap = widened(gap, above.y, b.frame[1] * side_sign(p.y), n); //? !rounded
    return widened(gap, above.z, b.frame[2] * side_sign(p.z), n); //? !rounded
}
