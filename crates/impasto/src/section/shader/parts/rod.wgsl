// A cylinder.
struct Body {
    axis: vec3<f32>,
    radius: f32,
    semi: f32, // half the height
    rounding: f32, // radius of the rims //? rounded
}

fn scaled(b: Body, s: f32) -> Body {
    return Body(b.axis, b.radius * s, b.semi * s[[rounded|, b.rounding * s]]);
}

fn body_reach(b: Body) -> f32 {
    return sqrt(b.semi * b.semi + b.radius * b.radius);
}

// Whether a point of the surface, so far along the axis and at that squared distance from it, is off the rounded rims.
fn is_sharp_at(b: Body, along: f32, squared: f32) -> bool {
    let inner: f32 = b.radius - b.rounding;
    return abs(along) <= b.semi - b.rounding || squared <= inner * inner;
}

fn holds(b: Body, m: vec3<f32>) -> bool {
    let along: f32 = dot(m, b.axis);
    let squared: f32 = dot(m, m) - along * along;
    let inside: bool = abs(along) <= b.semi && squared <= b.radius * b.radius;
    if (inside && !is_sharp_at(b, along, squared)) { //? rounded
        return level_of(b, m).value <= 0.0; //? rounded
    } //? rounded
    return inside;
}

// A point that is farthest along n.
fn support(b: Body, n: vec3<f32>) -> vec3<f32> {
    let along: f32 = dot(n, b.axis);
    let across: vec3<f32> = unit_or(n - b.axis * along, vec3<f32>(0.0));
    return b.axis * (b.semi * side_sign(along)) + across * b.radius; //? !rounded
    let e: f32 = b.rounding; //? rounded
    return b.axis * ((b.semi - e) * side_sign(along)) + across * (b.radius - e) + n * e; //? rounded
}

// How far it reaches along n.
fn extent(b: Body, n: vec3<f32>) -> f32 {
    return dot(support(b, n), n);
}

fn body_exit(b: Body, m: vec3<f32>, t: vec3<f32>) -> Exit {
    let along: f32 = dot(m, b.axis);
    let slope: f32 = dot(t, b.axis);
    let a: f32 = 1.0 - slope * slope;
    var way: f32 = 1e30;
    var through_end: bool = false;
    if (a > 1e-7) {
        let c: f32 = dot(m, m) - along * along - b.radius * b.radius;
        way = max(far_root(a, dot(m, t) - along * slope, min(c, 0.0)), 0.0);
    }
    if (slope != 0.0) {
        let end: f32 = (b.semi * side_sign(slope) - along) / slope;
        if (end < way) {
            way = max(end, 0.0);
            through_end = true;
        }
    }
    let q: vec3<f32> = m + t * way;
    let foot: f32 = dot(q, b.axis);
    if (!is_sharp_at(b, foot, dot(q, q) - foot * foot)) { //? rounded
        return newton_exit(b, m, t, way); //? rounded
    } //? rounded
    if (through_end) {
        // Flat, but shaded as a dome. //? domed
        return Exit(way, unit_or(q - b.axis * along, t)); //? domed
        return Exit(way, b.axis * side_sign(slope)); //? !domed
    }
    return Exit(way, unit_or(q - b.axis * foot, t));
}

// Distance to the surface, rims rounded.
fn level_of(b: Body, m: vec3<f32>) -> Level {
    let along: f32 = dot(m, b.axis);
    let across: vec3<f32> = m - b.axis * along;
    let far: f32 = length(across);
    let out_way: vec3<f32> = across / max(far, 1e-20);
    let end_way: vec3<f32> = b.axis * side_sign(along);
    let x: f32 = far - (b.radius - b.rounding);
    let y: f32 = abs(along) - (b.semi - b.rounding);
    if (x > 0.0 && y > 0.0) {
        let corner: f32 = sqrt(x * x + y * y);
        return Level(corner - b.rounding, (out_way * x + end_way * y) / corner);
    }
    if (x > y) {
        return Level(x - b.rounding, out_way);
    }
    return Level(y - b.rounding, end_way);
}

// To the ellipse in which the section cuts the side, to first order. //? !rounded
fn side_gap(b: Body, at: vec3<f32>, n: vec3<f32>) -> Gap { //? !rounded
    let across: vec3<f32> = at - b.axis * dot(at, b.axis); //? !rounded
    let far: f32 = length(across); //? !rounded
    let slope: vec3<f32> = (across - n * dot(across, n)) / max(far, 1e-12); //? !rounded
    let steep: f32 = length(slope); //? !rounded
    if (steep > 1e-6) { //? !rounded
        return Gap((far - b.radius) / steep, slope / steep); //? !rounded
    } //? !rounded
    return Gap(-b.radius, vec3<f32>(0.0)); //? !rounded
} //? !rounded

// To the outline, an ellipse cut by two lines.
fn body_gap(b: Body, m: vec3<f32>, n: vec3<f32>) -> Gap {
    return first_order_gap(b, m, n); //? rounded
    var gap: Gap = side_gap(b, m, n); //? !rounded
    if (gap.outside > 0.0) { //? !rounded
        let foot: Gap = side_gap(b, m - gap.away * gap.outside, n); //? !rounded
        gap = Gap(gap.outside + foot.outside, foot.away); //? !rounded
    } //? !rounded
    let along: f32 = dot(m, b.axis); //? !rounded
    let slope: vec3<f32> = b.axis - n * dot(b.axis, n); //? !rounded
    let steep: f32 = length(slope); //? !rounded
    if (steep > 1e-6 && abs(along) - b.semi > gap.outside * steep) { //? !rounded
        gap = Gap((abs(along) - b.semi) / steep, slope * (side_sign(along) / steep)); //? !rounded
    } //? !rounded
    return gap; //? !rounded
}
