// At least how far a point is from all particles, as far as that is less than twice `far`; model units.
fn clearance(p: vec3<f32>, far: f32) -> f32 {
    let at: Place = place_of(p);
    var least: f32 = 2.0 * far / SPACING;
    let width: i32 = 2 * max(i32(ceil(REACH + least + JITTER - 0.5)), 0) + 1;
    for (var i: i32 = 0; i < width * width * width; i++) {
        let ring: vec3<i32> = cell_step(i, width);
        let cell: vec3<i32> = at.cell + ring;
        let center: vec3<f32> = center_of(cell);
        let m: vec3<f32> = at.rest - (vec3<f32>(ring) + center);
        if (length(m) - REACH < least) {
            let free: Body = free_body(cell);
            let body: Body = [[apart|scaled(free, scale_of(cell, center, free))]][[!apart|free]];
            least = min(least, length(m) - extent(body, unit_or(m, vec3<f32>(0.0, 0.0, 1.0))));
        }
    }
    return least * SPACING;
}
