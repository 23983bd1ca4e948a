// Newton's steps from outside along a ray approach the exit of a convex body from one side.
fn newton_exit(b: Body, m: vec3<f32>, t: vec3<f32>, start: f32) -> Exit {
    var way: f32 = start;
    var level: Level = level_of(b, m + t * way);
    for (var i: i32 = 0; i < 16; i++) {
        let slope: f32 = dot(level.gradient, t);
        if (level.value <= 1e-7 || slope <= 1e-6) {
            break;
        }
        way -= level.value / slope;
        level = level_of(b, m + t * way);
    }
    return Exit(max(way, 0.0), unit_or(level.gradient, t));
}

// The distance to an outline to first order; no outline where the slope is lost.
fn slope_step(b: Body, at: vec3<f32>, n: vec3<f32>) -> Gap {
    let level: Level = level_of(b, at);
    let across: vec3<f32> = level.gradient - n * dot(level.gradient, n);
    let slope: f32 = length(across);
    if (slope > 1e-6) {
        return Gap(level.value / slope, across / slope);
    }
    return Gap(0.0, vec3<f32>(0.0));
}

// The same, twice.
fn first_order_gap(b: Body, m: vec3<f32>, n: vec3<f32>) -> Gap {
    let first: Gap = slope_step(b, m, n);
    if (dot(first.away, first.away) == 0.0) {
        return Gap(-body_reach(b), first.away);
    }
    let second: Gap = slope_step(b, m - first.away * first.outside, n);
    if (first.outside > 0.0 && dot(second.away, second.away) > 0.0) {
        return Gap(first.outside + second.outside, second.away);
    }
    return first;
}
