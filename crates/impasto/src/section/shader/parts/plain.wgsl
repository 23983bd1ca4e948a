// Nothing but matrix.
fn grain(p: vec3<f32>, n: vec3<f32>, offset: f32, side: i32[[sited|, site: Site]]) -> Hit {
    return matrix_hit(n * -side_sign(f32(side)), 0.0);
}
