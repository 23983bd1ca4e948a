// From a cell's node to its particle's centre.
fn center_of(cell: vec3<i32>) -> vec3<f32> {
    return vec3<f32>(texel(cell, 0u), texel(cell, 1u), texel(cell, 2u)) * JITTER;
}

// How a particle's radius and height differ, each in [-1, 1]: one channel for both.
fn size_chance(cell: vec3<i32>) -> vec2<f32> {
    return vec2<f32>(texel(cell, 3u));
}

// A vector that perturbs an axis, each in [-1, 1].
fn tilt_of(cell: vec3<i32>) -> vec3<f32> {
    return vec3<f32>(texel(cell, 4u), texel(cell, 5u), texel(cell, 6u));
}

// A channel of the paper's noise texture of 256 x 256 x 256 texels, worked out instead of stored.
fn texel(cell: vec3<i32>, channel: u32) -> f32 {
    let wrapped: vec3<i32> = cell & vec3<i32>(255);
    return perlin(vec3<f32>(wrapped) * NOISE_FREQUENCY + vec3<f32>(0.31, 0.47, 0.73), SEED * 8u + channel);
}

// Gradient noise in [-1, 1] (Perlin 2002), zero on the lattice; the lattice is hashed.
fn perlin(p: vec3<f32>, seed: u32) -> f32 {
    let base: vec3<f32> = floor(p);
    let f: vec3<f32> = p - base;
    let fade: vec3<f32> = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    var sum: f32 = 0.0;
    for (var i: i32 = 0; i < 8; i++) {
        let corner: vec3<i32> = vec3<i32>(i & 1, (i >> 1u) & 1, i >> 2u);
        let d: vec3<f32> = vec3<f32>(corner);
        let g: vec3<f32> = edge_direction(hash_cell(vec3<i32>(base) + corner, seed));
        let weight: vec3<f32> = fade * d + (1.0 - fade) * (1.0 - d);
        sum += weight.x * weight.y * weight.z * dot(g, f - d);
    }
    return sum * 0.96492;
}

// One of the twelve directions to a cube's edges.
fn edge_direction(h: u32) -> vec3<f32> {
    let a: f32 = 1.0 - 2.0 * f32((h >> 30u) & 1u);
    let b: f32 = 1.0 - 2.0 * f32(h >> 31u);
    let plane: u32 = (h & 0x0fffffffu) / 89478486u;
    if (plane == 0u) {
        return vec3<f32>(a, b, 0.0);
    }
    if (plane == 1u) {
        return vec3<f32>(a, 0.0, b);
    }
    return vec3<f32>(0.0, a, b);
}
