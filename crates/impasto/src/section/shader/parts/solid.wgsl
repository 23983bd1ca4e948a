// Particles are hard: flat discs, and a bevel of 45 degrees down to the matrix.
fn section(at: Place, outward: vec3<f32>[[sited|, site: Site]]) -> Hit {
    var best: Hit = matrix_hit(outward, -BEVEL_WIDTH);
    for (var i: i32 = 0; i < SOLID_WIDTH * SOLID_WIDTH * SOLID_WIDTH; i++) {
        let ring: vec3<i32> = cell_step(i, SOLID_WIDTH);
        let cell: vec3<i32> = at.cell + ring;
        let center: vec3<f32> = center_of(cell);
        let m: vec3<f32> = at.rest - (vec3<f32>(ring) + center);
        let wide: f32 = REACH + BEVEL_WIDTH;
        if (dot(m, m) > wide * wide) {
            continue;
        }
        let free: Body = free_body(cell);
        let grown: Body = [[grows|scaled(free, GROW)]][[!grows|free]]; //? apart
        if (!meets(grown, m, outward) || body_gap(grown, m, outward).outside >= BEVEL_WIDTH) { //? apart
            continue; //? apart
        } //? apart
        let body: Body = [[apart|scaled(free, scale_of(cell, center, free))]][[!apart|free]];
        if (!meets(body, m, outward)) {
            continue;
        }
        if (!keep(model_point(cell, center), body_reach(body) * SPACING[[sited|, site]])) { //? keep
            continue; //? keep
        } //? keep
        let gap: Gap = body_gap(body, m, outward);
        let bevel: f32 = min(BEVEL_WIDTH, body_reach(body) * 0.5); //? bevel_within
        let bevel: f32 = BEVEL_WIDTH; //? !bevel_within
        // Where the bevel is narrower than the recess it is as much less deep.
        if (gap.outside >= bevel || -max(gap.outside, 0.0) <= best.height) {
            continue;
        }
        let name: u32 = name_of(cell);
        if (gap.outside <= 0.0) {
            best = Hit(0.0, outward, DISC, name, 1.0);
        } else {
            let normal: vec3<f32> = unit_or(outward + gap.away, outward);
            best = Hit(-gap.outside, normal, BEVEL, name, 0.5 + 0.5 * dot(normal, outward));
        }
    }
    return best;
}
