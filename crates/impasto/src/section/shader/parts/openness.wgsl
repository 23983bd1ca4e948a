// How much sky a point in a cavity sees: the form factor of the cavity's opening, for which a polygon of 16 corners stands.
fn cavity_openness(b: Body, m: vec3<f32>, n: vec3<f32>, exit: Exit) -> f32 {
    // In steps, so that all points of a section have the same opening.
    let offset: f32 = floor(dot(m, n) * 65536.0 + 0.5) / 65536.0;
    // A point inside the opening: between the centre and the farthest point on that side.
    let tip: vec3<f32> = support(b, n * side_sign(offset));
    let height: f32 = abs(dot(tip, n));
    var middle: vec3<f32> = vec3<f32>(0.0);
    if (height > 0.0) {
        middle = tip * min(abs(offset) / height, 1.0);
    }
    let axes: mat3x3<f32> = frame_about(n);
    let q: vec3<f32> = m - n * exit.way;
    var c: f32 = 1.0;
    var s: f32 = 0.0;
    var last: vec3<f32> = vec3<f32>(0.0);
    var sum: f32 = 0.0;
    for (var k: i32 = 0; k <= 16; k++) {
        let t: vec3<f32> = axes[0] * c + axes[1] * s;
        // As large as a smooth outline of these corners.
        let corner: vec3<f32> = middle + t * (body_exit(b, middle, t).way * 1.0130016);
        let ray: vec3<f32> = unit_or(corner - q, vec3<f32>(0.0));
        if (k > 0) {
            sum += edge_form(last, ray, exit.normal);
        }
        last = ray;
        let turned: f32 = c * 0.9238795325 - s * 0.3826834324;
        s = s * 0.9238795325 + c * 0.3826834324;
        c = turned;
    }
    return min(abs(sum) * 0.15915494, 1.0);
}
