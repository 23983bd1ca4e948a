// Even numbers in [0, 1) for directions and turns.
fn even_chance(cell: vec3<i32>) -> vec3<f32> {
    let h: u32 = hash_cell(cell, SEED);
    let hashes: vec3<u32> = vec3<u32>(hash(h + 9u), hash(h + 10u), hash(h + 11u));
    return vec3<f32>(unit_float(hashes.x), unit_float(hashes.y), unit_float(hashes.z));
}

// Where a particle's axis points.
fn axis_of(cell: vec3<i32>) -> vec3<f32> {
    return to_lattice(AXIS); //? along
    let v: vec3<f32> = to_lattice(AXIS); //? !radial & !along
    return unit_or(v + tilt_of(cell) * AXIS_AMOUNT, v); //? perturbed
    // Evenly within a cone. //? cone
    let even: vec3<f32> = even_chance(cell); //? cone
    let z: f32 = 1.0 - even.x * (1.0 - CONE_COSINE); //? cone
    let turn: vec2<f32> = sin_cos(even.y) * sqrt(max(1.0 - z * z, 0.0)); //? cone
    let across: mat3x3<f32> = frame_about(v); //? cone
    return unit_or(across[0] * turn.y + across[1] * turn.x + v * z, v); //? cone
    let away: vec3<f32> = vec3<f32>(cell) + center_of(cell) - to_lattice(FOCUS / SPACING); //? radial
    return unit_or(away, vec3<f32>(0.0, 0.0, 1.0)); //? radial
}

// A particle's own axes as columns; the third is its axis, about which it is turned by chance.
fn frame_of(cell: vec3<i32>) -> mat3x3<f32> {
    let axis: vec3<f32> = axis_of(cell);
    let about: mat3x3<f32> = frame_about(axis);
    let turn: vec2<f32> = sin_cos(even_chance(cell).z);
    let x: vec3<f32> = about[0] * turn.y + about[1] * turn.x;
    return mat3x3<f32>(x, cross(axis, x), axis);
}

// The factor of a particle's radii.
fn size_of(cell: vec3<i32>) -> f32 {
    return mix(SIZE_LEAST, SIZE_MOST, 0.5 + 0.5 * size_chance(cell).x);
}

// The factor of its height.
fn height_of(cell: vec3<i32>) -> f32 {
    return mix(HEIGHT_LEAST, HEIGHT_MOST, 0.5 + 0.5 * size_chance(cell).y);
}
