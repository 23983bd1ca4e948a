// A polyhedron: its axes as columns, and how much larger it is than given.
struct Body {
    frame: mat3x3<f32>,
    size: f32,
}

const SHAPE_REACH: f32 = CORNER_REACH / SPACING * SIZE_MOST;
const MARGIN: f32 = 2e-6;

// The particle of a cell as it would be alone.
fn free_body(cell: vec3<i32>) -> Body {
    return Body(frame_of(cell), size_of(cell) / SPACING);
}

fn scaled(b: Body, s: f32) -> Body {
    return Body(b.frame, b.size * s);
}

fn body_reach(b: Body) -> f32 {
    return CORNER_REACH * b.size;
}

fn holds(b: Body, m: vec3<f32>) -> bool {
    return most_above(m * b.frame, b.size) <= 0.0;
}

// A point that is farthest along n.
fn support(b: Body, n: vec3<f32>) -> vec3<f32> {
    return b.frame * (farthest_corner(n * b.frame) * b.size);
}

// How far it reaches along n.
fn extent(b: Body, n: vec3<f32>) -> f32 {
    return dot(support(b, n), n);
}

fn body_exit(b: Body, m: vec3<f32>, t: vec3<f32>) -> Exit {
    let first: Exit = first_face(m * b.frame, t * b.frame, b.size);
    return Exit(max(first.way, 0.0), b.frame * first.normal);
}

// Takes in one face, given by its normal and distance.
fn passed(first: Exit, face: vec4<f32>, p: vec3<f32>, d: vec3<f32>, size: f32) -> Exit {
    let slope: f32 = dot(face.xyz, d);
    if (slope > 0.0) {
        let way: f32 = (face.w * size - dot(face.xyz, p)) / slope;
        if (way < first.way) {
            return Exit(way, face.xyz);
        }
    }
    return first;
}

fn farther(best: vec3<f32>, corner: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    if (dot(corner, n) > dot(best, n)) {
        return corner;
    }
    return best;
}

fn face_gap(gap: Gap, face: vec4<f32>, b: Body, m: vec3<f32>, n: vec3<f32>) -> Gap {
    return widened(gap, dot(face.xyz, m * b.frame) - face.w * b.size, b.frame * face.xyz, n);
}
