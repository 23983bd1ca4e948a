// Li 2022 to the letter: the first of 27 particles that holds the place wins, and particles overlap.
fn section(at: Place, n: vec3<f32>[[sited|, site: Site]]) -> Hit {
    var least: Gap = Gap(1e30, n); //? solid
    var nearest: vec3<i32> = at.cell; //? solid
    for (var i: i32 = 0; i < 27; i++) {
        let ring: vec3<i32> = cell_step(i, 3);
        let cell: vec3<i32> = at.cell + ring;
        let center: vec3<f32> = center_of(cell);
        let m: vec3<f32> = at.rest - (vec3<f32>(ring) + center);
        let body: Body = free_body(cell);
        if (!keep(model_point(cell, center), body_reach(body) * SPACING[[sited|, site]])) { //? keep
            continue; //? keep
        } //? keep
        if (holds(body, m)) {
            return Hit(0.0, n, DISC, name_of(cell), 1.0); //? solid
            // (2): a centre below the section stands out, in both halves. //? tear
            var s: f32 = 1.0; //? tear
            if (-dot(m, n) > 0.0) { //? tear
                s = -1.0; //? tear
            } //? tear
            let s: f32 = -1.0; //? hollow
            let exit: Exit = body_exit(body, m, n * s); //? !solid
            if (exit.way * s > 0.0) { //? !solid
                return Hit(exit.way, exit.normal, BUMP, name_of(cell), 1.0); //? !solid
            } //? !solid
            return Hit(exit.way * s, exit.normal * s, CAVITY, name_of(cell), 1.0); //? !solid
        }
        if (meets(body, m, n)) { //? solid
            let gap: Gap = body_gap(body, m, n); //? solid
            if (gap.outside < least.outside) { //? solid
                least = gap; //? solid
                nearest = cell; //? solid
            } //? solid
        } //? solid
    }
    // (9), (10). //? solid
    if (least.outside <= BEVEL_WIDTH) { //? solid
        return Hit(-least.outside, unit_or(n + least.away, n), BEVEL, name_of(nearest), 1.0); //? solid
    } //? solid
    return matrix_hit(n, -BEVEL_WIDTH); //? solid
    return matrix_hit(n, 0.0); //? !solid
}
