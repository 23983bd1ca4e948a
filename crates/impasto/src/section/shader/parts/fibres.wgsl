const ROW: f32 = 0.8660254; // between the rows of the hexagonal lattice
const ROW_WHOLE: i32 = 3547; // the same in whole 4096ths
const ROW_REST: f32 = 5.8606910e-5; // and what is left
const PIECE: f32 = LENGTH / SPACING; // mean length of pieces
const PIECE_UNIT: f32 = exp2(floor(log2(PIECE)) - 11.0);
const PIECE_HIGH: f32 = floor(PIECE / PIECE_UNIT) * PIECE_UNIT;
const MARGIN: f32 = 2e-6;

fn fibre_hash(key: vec2<i32>) -> u32 {
    return hash_cell(vec3<i32>(key.x, key.y, 0), SEED);
}

// How far a fibre's middle is off its node, every other row being shifted by half.
fn off_node(key: vec2<i32>) -> vec2<f32> {
    let h: u32 = fibre_hash(key);
    return vec2<f32>(0.5 * f32(key.y & 1), 0.0) + vec2<f32>(signed_float(h, 1u), signed_float(h, 2u)) * JITTER;
}

fn free_radius(key: vec2<i32>) -> f32 {
    return RADIUS / SPACING * (1.0 + SIZE_SPREAD * signed_float(fibre_hash(key), 4u));
}

// Shrunk until neighbours fit.
fn radius_of(key: vec2<i32>) -> f32 {
    let own: f32 = free_radius(key);
    let off: vec2<f32> = off_node(key);
    var scale: f32 = 1.0;
    for (var i: i32 = 0; i < 49; i++) {
        let to: vec2<i32> = vec2<i32>(i % 7 - 3, i / 7 - 3);
        if (to.x != 0 || to.y != 0) {
            let way: vec2<f32> = vec2<f32>(f32(to.x), f32(to.y) * ROW) + (off_node(key + to) - off);
            scale = min(scale, length(way) / (own + free_radius(key + to)));
        }
    }
    return own * scale * (1.0 - MARGIN);
}

// Where along a fibre the k-th break is, in lengths from the fibre's start: pieces are between 0.3 and 1.7 lengths long.
fn off_break(key: vec2<i32>, k: i32) -> f32 {
    return 0.7 * (unit_float(hash(hash_cell(vec3<i32>(key.x, key.y, k), SEED) ^ 3u)) - 0.5);
}

// What the cut shows at a point p of it; see the top.
fn grain(p: vec3<f32>, n: vec3<f32>, offset: f32, side: i32[[sited|, site: Site]]) -> Hit {
    let at: Place = place_of(p);
    let across: vec3<f32> = to_lattice(n);
    let outward: vec3<f32> = across * -side_sign(f32(side));
    let row: i32 = i32(floor((f32(at.cell.y) + at.rest.y) / ROW + 0.5));
    let column: i32 = at.cell.x + i32(floor(at.rest.x - 0.5 * f32(row & 1) + 0.5));
    // Whole pieces up to the place, and the rest in pieces.
    let pieces: f32 = floor(f32(at.cell.z) / PIECE);
    let left: f32 = (f32(at.cell.z) - pieces * PIECE_HIGH) - pieces * (PIECE - PIECE_HIGH);
    let rest: f32 = (left + at.rest.z) / PIECE;
    var best: Hit = matrix_hit(outward, 0.0); //? !solid
    var best: Hit = matrix_hit(outward, -BEVEL_WIDTH); //? solid
    for (var i: i32 = 0; i < 25; i++) {
        let key: vec2<i32> = vec2<i32>(column + i % 5 - 2, row + i / 5 - 2);
        let off: vec2<f32> = off_node(key);
        let x: f32 = f32(at.cell.x - key.x) + (at.rest.x - off.x);
        let y: f32 = f32(at.cell.y * 4096 - key.y * ROW_WHOLE) / 4096.0 - f32(key.y) * ROW_REST + (at.rest.y - off.y);
        let free: f32 = free_radius(key); //? !solid
        let free: f32 = free_radius(key) + BEVEL_WIDTH; //? solid
        if (x * x + y * y > free * free) {
            continue;
        }
        let radius: f32 = radius_of(key);
        // The piece at this height, and its neighbours where the place is between two.
        let phase: f32 = unit_float(hash(fibre_hash(key) ^ 7u));
        let nearest: f32 = floor(rest + phase + 0.5);
        for (var j: i32 = -1; j <= 1; j++) {
            let k: i32 = i32(pieces) + i32(nearest) + j;
            let ends: vec2<f32> = vec2<f32>(off_break(key, k), off_break(key, k + 1) + 1.0);
            let semi: f32 = ((ends.y - ends.x) * PIECE - BREAK_GAP / SPACING) * 0.5;
            let z: f32 = (rest + phase - nearest - f32(j) - (ends.x + ends.y) * 0.5) * PIECE;
            if (semi <= 0.0 || abs(z) > semi) { //? !solid
            if (semi <= 0.0 || abs(z) > semi + BEVEL_WIDTH) { //? solid
                continue;
            }
            let body: Body = Body(vec3<f32>(0.0, 0.0, 1.0), radius, semi[[rounded|, min(ROUNDING * radius, semi)]]);
            let m: vec3<f32> = vec3<f32>(x, y, z);
            let cell: vec3<i32> = vec3<i32>(key.x, key.y, k);
            let middle: f32 = (f32(k) + (ends.x + ends.y) * 0.5 - phase) * PIECE; //? tear | keep
            let center: vec3<f32> = vec3<f32>(f32(key.x) + off.x, f32(key.y) * ROW + off.y, middle); //? tear | keep
            if (!keep(model_point(vec3<i32>(0), center), body_reach(body) * SPACING[[sited|, site]])) { //? keep
                continue; //? keep
            } //? keep
            if (!meets(body, m, outward)) { //? solid
                continue; //? solid
            } //? solid
            let gap: Gap = body_gap(body, m, outward); //? solid
            if (gap.outside >= BEVEL_WIDTH || -max(gap.outside, 0.0) <= best.height) { //? solid
                continue; //? solid
            } //? solid
            if (gap.outside > 0.0) { //? solid
                let normal: vec3<f32> = unit_or(outward + gap.away, outward); //? solid
                best = Hit(-gap.outside, normal, BEVEL, name_of(cell), 0.5 + 0.5 * dot(normal, outward)); //? solid
            } else { //? solid
                best = Hit(0.0, outward, DISC, name_of(cell), 1.0); //? solid
            } //? solid
            if (!holds(body, m)) { //? !solid
                continue; //? !solid
            } //? !solid
            if (side_of(vec3<i32>(0), center, across, offset / SPACING) * side > 0) { //? tear
                let exit: Exit = body_exit(body, m, outward); //? tear
                best = Hit(exit.way, exit.normal, BUMP, name_of(cell), 0.5 + 0.5 * dot(exit.normal, outward)); //? tear
            } else { //? tear
[[tear|    ]]            let exit: Exit = body_exit(body, m, -outward); //? !solid
[[tear|    ]]            best = Hit(-exit.way, -exit.normal, CAVITY, name_of(cell), cavity_openness(body, m, outward, exit)); //? !solid
            } //? tear
        }
    }
    return Hit(best.height * SPACING, to_model(best.normal), best.kind, best.particle, best.openness);
}
