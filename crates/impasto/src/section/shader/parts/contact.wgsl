const REACH: f32 = SHAPE_REACH * GROW * 1.000001; // no particle reaches farther from its centre
const WIDTH: i32 = 2 * max(i32(ceil(REACH + JITTER - 0.5)), 0) + 1; // of the cube of cells that may hold a point
const CONTACT_WIDTH: i32 = 2 * max(i32(ceil(2.0 * REACH + 2.0 * JITTER - 1.0)), 1) + 1; // of that which may touch
const SOLID_WIDTH: i32 = 2 * max(i32(ceil(REACH + BEVEL_WIDTH + JITTER - 0.5)), 0) + 1; // of that whose bevels reach

// How much the particle of a cell shrinks (or grows) so that a plane parts it from each neighbour, whatever their shapes.
fn scale_of(cell: vec3<i32>, center: vec3<f32>, body: Body) -> f32 {
    var scale: f32 = GROW;
    // A neighbour farther than both can reach cannot matter.
    let far: f32 = GROW * body_reach(body) + REACH;
    let n_cells: i32 = CONTACT_WIDTH * CONTACT_WIDTH * CONTACT_WIDTH;
    for (var i: i32 = 0; i < n_cells; i++) {
        let ring: vec3<i32> = cell_step(i, CONTACT_WIDTH);
        let to: vec3<f32> = vec3<f32>(ring) + (center_of(cell + ring) - center);
        let squared: f32 = dot(to, to);
        if (2 * i + 1 != n_cells && squared < far * far) {
            if (squared <= 0.0) {
                return 0.0;
            }
            let n: vec3<f32> = to / sqrt(squared);
            let both: f32 = extent(body, n) + extent(free_body(cell + ring), -n);
            scale = min(scale, sqrt(squared) / both);
        }
    }
    return max(scale * (1.0 - MARGIN), 0.0);
}

// Whether a section through m goes through the particle.
fn meets(b: Body, m: vec3<f32>, n: vec3<f32>) -> bool {
    let offset: f32 = dot(m, n);
    return abs(offset) < body_reach(b) && offset < extent(b, n) && -offset < extent(b, -n);
}
