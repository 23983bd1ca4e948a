// What the cut shows at a point p of it, this deep below the skin.
fn grain(p: vec3<f32>, n: vec3<f32>, offset: f32, side: i32, depth: f32, inward: vec3<f32>) -> Hit {
    return layers(p, n, offset, side, Site(p, depth, inward));
}
