// What the cut shows at a point p of it; see the top.
fn grain(p: vec3<f32>, n: vec3<f32>, offset: f32, side: i32[[sited|, site: Site]]) -> Hit {
    let across: vec3<f32> = to_lattice(n);
    let hit: Hit = section(place_of(p), across, offset / SPACING, side[[sited|, site]]); //? sided
    let hit: Hit = section(place_of(p), across * -side_sign(f32(side))[[sited|, site]]); //? !sided
    return Hit(hit.height * SPACING, to_model(hit.normal), hit.kind, hit.particle, hit.openness);
}
