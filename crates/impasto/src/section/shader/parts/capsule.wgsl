// A cylinder with half balls on its ends.
struct Body {
    axis: vec3<f32>,
    radius: f32,
    semi: f32, // half the distance between the balls' centres
}

const LINE_SEMI: f32 = (HEIGHT * 0.5 - RADIUS) / SPACING; // half the distance between the balls' centres
const SHAPE_REACH: f32 = LINE_SEMI * HEIGHT_MOST + RADIUS / SPACING * SIZE_MOST;
const MARGIN: f32 = 2e-6;

// The particle of a cell as it would be alone.
fn free_body(cell: vec3<i32>) -> Body {
    return Body(axis_of(cell), RADIUS / SPACING * size_of(cell), LINE_SEMI * height_of(cell));
}

fn scaled(b: Body, s: f32) -> Body {
    return Body(b.axis, b.radius * s, b.semi * s);
}

fn body_reach(b: Body) -> f32 {
    return b.semi + b.radius;
}

// From the nearest point of its middle line.
fn from_line(b: Body, m: vec3<f32>) -> vec3<f32> {
    return m - b.axis * clamp(dot(m, b.axis), -b.semi, b.semi);
}

fn holds(b: Body, m: vec3<f32>) -> bool {
    let out_way: vec3<f32> = from_line(b, m);
    return dot(out_way, out_way) <= b.radius * b.radius;
}

// A point that is farthest along n.
fn support(b: Body, n: vec3<f32>) -> vec3<f32> {
    return b.axis * (b.semi * side_sign(dot(n, b.axis))) + n * b.radius;
}

// How far it reaches along n.
fn extent(b: Body, n: vec3<f32>) -> f32 {
    return b.semi * abs(dot(n, b.axis)) + b.radius;
}

fn body_exit(b: Body, m: vec3<f32>, t: vec3<f32>) -> Exit {
    let along: f32 = dot(m, b.axis);
    let slope: f32 = dot(t, b.axis);
    let a: f32 = 1.0 - slope * slope;
    let squared: f32 = b.radius * b.radius;
    // Through the side, or through the end that the ray, or its way out of the side, points to.
    var leaning: f32 = slope;
    if (a > 1e-7) {
        let side: f32 = far_root(a, dot(m, t) - along * slope, dot(m, m) - along * along - squared);
        let q: vec3<f32> = m + t * side;
        leaning = dot(q, b.axis);
        if (abs(leaning) <= b.semi) {
            return Exit(max(side, 0.0), unit_or(q - b.axis * leaning, t));
        }
    }
    let end: vec3<f32> = m - b.axis * (b.semi * side_sign(leaning));
    let way: f32 = far_root(1.0, dot(end, t), dot(end, end) - squared);
    return Exit(max(way, 0.0), unit_or(end + t * way, t));
}

fn level_of(b: Body, m: vec3<f32>) -> Level {
    let out_way: vec3<f32> = from_line(b, m);
    let far: f32 = length(out_way);
    return Level(far - b.radius, out_way / max(far, 1e-20));
}

fn body_gap(b: Body, m: vec3<f32>, n: vec3<f32>) -> Gap {
    return first_order_gap(b, m, n);
}
