// Numbers: chance by hashing, directions.

// Mixes an integer thoroughly: all bits that come out depend on all that go in (Wellons' lowbias32).
fn hash(key: u32) -> u32 {
    var x: u32 = key;
    x = (x ^ (x >> 16u)) * 0x7feb352du;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    return x ^ (x >> 16u);
}

fn hash_cell(cell: vec3<i32>, seed: u32) -> u32 {
    let c: vec3<u32> = vec3<u32>(cell);
    return hash(c.x ^ hash(c.y ^ hash(c.z ^ hash(seed))));
}

// The upper 24 bits of a hash: a number in [0, 1), exact.
fn unit_float(h: u32) -> f32 {
    return f32(h >> 8u) * 5.9604644775390625e-8;
}

// The k-th number of a cell, in [-1, 1).
fn signed_float(h: u32, k: u32) -> f32 {
    return unit_float(hash(h + k)) * 2.0 - 1.0;
}

fn unit_or(v: vec3<f32>, fallback: vec3<f32>) -> vec3<f32> {
    let squared: f32 = dot(v, v);
    if (squared > 1e-30) {
        return v / sqrt(squared);
    }
    return fallback;
}

// -1 below zero, else 1.
fn side_sign(x: f32) -> f32 {
    if (x < 0.0) {
        return -1.0;
    }
    return 1.0;
}

// Two unit vectors across a unit vector, as the first two columns (Duff et al. 2017).
fn frame_about(n: vec3<f32>) -> mat3x3<f32> {
    let s: f32 = side_sign(n.z);
    let a: f32 = -1.0 / (s + n.z);
    let b: f32 = n.x * n.y * a;
    return mat3x3<f32>(
        vec3<f32>(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        vec3<f32>(b, s + n.y * n.y * a, -n.y),
        n
    );
}

// Sine and cosine of an angle, given in turns from 0 to 1: to 2e-7, where a card's own may be wrong by 5e-4.
fn sin_cos(turns: f32) -> vec2<f32> {
    let quarter: f32 = floor(turns * 4.0 + 0.5);
    let r: f32 = (turns * 4.0 - quarter) * 1.57079637;
    let z: f32 = r * r;
    let s: f32 = r + r * z * (-0.16666667 + z * (8.333332e-3 + z * (-1.9840087e-4 + z * 2.72499e-6)));
    let c: f32 = 1.0 - 0.5 * z + z * z * (4.1666664e-2 + z * (-1.3888302e-3 + z * 2.4547917e-5));
    let k: i32 = i32(quarter) & 3;
    if (k == 0) {
        return vec2<f32>(s, c);
    }
    if (k == 1) {
        return vec2<f32>(c, -s);
    }
    if (k == 2) {
        return vec2<f32>(-s, -c);
    }
    return vec2<f32>(-c, s);
}

// The greater root of a x^2 + 2 b x + c, without cancellation.
fn far_root(a: f32, b: f32, c: f32) -> f32 {
    let root: f32 = sqrt(max(b * b - a * c, 0.0));
    if (b > 0.0) {
        return -c / (b + root);
    }
    return (root - b) / a;
}

// The i-th step to a cell of a cube of so many cells, which has its middle at 0.
fn cell_step(i: i32, width: i32) -> vec3<i32> {
    return vec3<i32>(i / (width * width), i / width % width, i % width) - vec3<i32>(width / 2);
}

// What an edge of a polygon adds to its form factor (Lambert 1760).
fn edge_form(a: vec3<f32>, b: vec3<f32>, normal: vec3<f32>) -> f32 {
    return acos(clamp(dot(a, b), -1.0, 1.0)) * dot(unit_or(cross(a, b), vec3<f32>(0.0)), normal);
}
