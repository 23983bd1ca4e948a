// Whether a particle belongs to this layer: by the depth of its centre.
fn within(center: vec3<f32>, reach: f32, site: Site) -> bool {
    let depth: f32 = site.depth + dot(site.inward, center - site.p);
    if (!outer_keep(center, reach, site)) { //? keep
        return false; //? keep
    } //? keep
    return depth[[strict| - reach]] >= FROM && depth[[strict| + reach]] <= UNTIL; //? !first & !last
    return depth[[strict| + reach]] <= UNTIL; //? first & !last
    return depth[[strict| - reach]] >= FROM; //? !first & last
    return true; //? first & last
}
