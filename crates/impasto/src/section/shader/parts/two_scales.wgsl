// Fine particles stand in the matrix between coarse ones.
fn grain(p: vec3<f32>, n: vec3<f32>, offset: f32, side: i32[[sited|, site: Site]]) -> Hit {
    let hit: Hit = coarse_grain(p, n, offset, side[[sited|, site]]);
    if (hit.kind == MATRIX[[solid| || hit.kind == BEVEL]]) {
        let inner: Hit = fine_grain(p, n, offset, side[[sited|, site]]);
        // Between particles of both scales the matrix lies as deep as the coarse ones have it.
        if (inner.kind != MATRIX[[solid| && (hit.kind == MATRIX || inner.height > hit.height)]]) {
            return inner;
        }
    }
    return hit;
}

// Whether a fine particle keeps its distance from the coarse ones.
fn clear(center: vec3<f32>, reach: f32[[sited|, site: Site]]) -> bool {
    if (!outer_keep(center, reach[[sited|, site]])) { //? keep
        return false; //? keep
    } //? keep
    return coarse_clearance(center, reach) >= reach + GAP;
}
