// From a cell's node to its particle's centre.
fn center_of(cell: vec3<i32>) -> vec3<f32> {
    let h: u32 = hash_cell(cell, SEED);
    return JITTER * vec3<f32>(signed_float(h, 1u), signed_float(h, 2u), signed_float(h, 3u));
}

// How a particle's radius and height differ, each in [-1, 1).
fn size_chance(cell: vec3<i32>) -> vec2<f32> {
    let h: u32 = hash_cell(cell, SEED);
    return vec2<f32>(signed_float(h, 4u), signed_float(h, 5u));
}

// A vector that perturbs an axis, each in [-1, 1).
fn tilt_of(cell: vec3<i32>) -> vec3<f32> {
    let h: u32 = hash_cell(cell, SEED);
    return vec3<f32>(signed_float(h, 6u), signed_float(h, 7u), signed_float(h, 8u));
}
