// Where the point asked for lies below the skin.
struct Site {
    p: vec3<f32>,
    depth: f32,
    inward: vec3<f32>,
}
