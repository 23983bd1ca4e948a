// A cell's seed, seen from the node nearest to the place asked for.
struct Seed {
    cell: vec3<i32>,
    at: vec3<f32>,
    weight: f32, // greater ones have greater cells
}

fn seed_of(node: vec3<i32>, ring: vec3<i32>) -> Seed {
    let cell: vec3<i32> = node + ring;
    return Seed(cell, vec3<f32>(ring) + center_of(cell), size_chance(cell).x * WEIGHT_SPREAD);
}

fn is_same(a: vec3<i32>, b: vec3<i32>) -> bool {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

// The seed whose cell a place is in: that of the least power.
fn owner_of(at: Place) -> Seed {
    var best: Seed = seed_of(at.cell, vec3<i32>(0));
    var least: f32 = 1e30;
    for (var i: i32 = 0; i < 125; i++) {
        let s: Seed = seed_of(at.cell, cell_step(i, 5));
        let d: vec3<f32> = at.rest - s.at;
        let power: f32 = dot(d, d) - s.weight;
        if (power < least) {
            least = power;
            best = s;
        }
    }
    return best;
}

// The border between two cells as a function that is positive in the first, and its gradient in model space.
fn border(a: Seed, b: Seed, x: vec3<f32>) -> Level {
    let to_a: vec3<f32> = x - a.at;
    let to_b: vec3<f32> = x - b.at;
    let value: f32 = (dot(to_b, to_b) - b.weight) - (dot(to_a, to_a) - a.weight);
    return Level(value, to_model((a.at - b.at) * 2.0) / STEP);
}

// Where a ray leaves a cell, and which it comes into.
struct Way {
    way: f32,
    to: Seed,
}

// The end of a cell along t, no nearer than `least`. Asked of the seeds around the ray's start, then of those around the
// end found, until no other is nearer.
fn way_out(at: Place, seed: Seed, t: vec3<f32>, least: f32) -> Way {
    let along: vec3<f32> = to_lattice(t / STEP);
    var best: Way = Way(1e30, seed);
    var around: vec3<f32> = at.rest + along * least;
    for (var k: i32 = 0; k < 8; k++) {
        let before: f32 = best.way;
        let middle: vec3<i32> = vec3<i32>(floor(around + vec3<f32>(0.5)));
        for (var i: i32 = 0; i < 125; i++) {
            let s: Seed = seed_of(at.cell, middle + cell_step(i, 5));
            // How fast the border function falls along the ray.
            let fall: f32 = 2.0 * dot(s.at - seed.at, along);
            if (fall > 0.0 && !is_same(s.cell, seed.cell)) {
                let level: Level = border(seed, s, at.rest);
                let way: f32 = max((level.value[[walls| - WALL * 0.5 * length(level.gradient)]]) / fall, least);
                if (way < best.way) {
                    best = Way(way, s);
                }
            }
        }
        if (best.way == before) {
            break;
        }
        around = at.rest + along * best.way;
    }
    return best;
}

// From the place to the nearest border of its cell, model units. //? walls
fn wall_distance(at: Place, seed: Seed) -> f32 { //? walls
    var least: f32 = 1e30; //? walls
    for (var i: i32 = 0; i < 125; i++) { //? walls
        let s: Seed = seed_of(at.cell, cell_step(i, 5)); //? walls
        if (!is_same(s.cell, seed.cell)) { //? walls
            let level: Level = border(seed, s, at.rest); //? walls
            least = min(least, level.value / length(level.gradient)); //? walls
        } //? walls
    } //? walls
    return least; //? walls
} //? walls

// How far, within the section, the place is outside of its cell without its share of the walls.
fn cell_gap(at: Place, seed: Seed, n: vec3<f32>) -> Gap {
    var gap: Gap = Gap(-1e30, vec3<f32>(0.0));
    for (var i: i32 = 0; i < 125; i++) {
        let s: Seed = seed_of(at.cell, cell_step(i, 5));
        if (!is_same(s.cell, seed.cell)) {
            let level: Level = border(seed, s, at.rest);
            let steep: f32 = length(level.gradient);
            gap = widened(gap, WALL * 0.5 - level.value / steep, -level.gradient / steep, n);
        }
    }
    return gap;
}

// From the place along t to the end of its cell, or of the last of the same side; a run of more than 32 ends there.
fn walk(at: Place, seed: Seed, t: vec3<f32>[[onward|, across: vec3<f32>, offset: f32, side: i32]]) -> Exit {
    var here: Seed = seed; //? onward
    var done: f32 = 0.0; //? onward
    for (var k: i32 = 0; k < 32; k++) { //? onward
        let way: Way = way_out(at, here, t, done); //? onward
        if (way.way >= 1e30) { //? onward
            break; //? onward
        } //? onward
        done = way.way; //? onward
        if (k == 31 || side_of(way.to.cell, center_of(way.to.cell), across, offset) != side) { //? onward
            return Exit(done, unit_or(-border(here, way.to, at.rest).gradient, t)); //? onward
        } //? onward
        here = way.to; //? onward
    } //? onward
    return Exit(done, t); //? onward
    let way: Way = way_out(at, seed, t, 0.0); //? !onward
    return Exit(way.way, unit_or(-border(seed, way.to, at.rest).gradient, t)); //? !onward
}

// How much sky the wall of a cavity sees through the cell's section, for which a polygon of 16 corners stands. //? walls
fn cell_openness(at: Place, seed: Seed, n: vec3<f32>, exit: Exit) -> f32 { //? walls
    let axes: mat3x3<f32> = frame_about(n); //? walls
    var turn: vec2<f32> = vec2<f32>(1.0, 0.0); //? walls
    var last: vec3<f32> = vec3<f32>(0.0); //? walls
    var sum: f32 = 0.0; //? walls
    for (var k: i32 = 0; k <= 16; k++) { //? walls
        let t: vec3<f32> = axes[0] * turn.x + axes[1] * turn.y; //? walls
        var way: f32 = way_out(at, seed, t, 0.0).way; //? walls
        if (way >= 1e30) { //? walls
            way = FAR; //? walls
        } //? walls
        let ray: vec3<f32> = unit_or(t * way + n * exit.way, vec3<f32>(0.0)); //? walls
        if (k > 0) { //? walls
            sum += edge_form(last, ray, exit.normal); //? walls
        } //? walls
        last = ray; //? walls
        turn = turn * 0.9238795325 + vec2<f32>(-turn.y, turn.x) * 0.3826834324; //? walls
    } //? walls
    return min(abs(sum) * 0.15915494, 1.0); //? walls
} //? walls

const CELL_BEVEL: f32 = min(BEVEL_WIDTH * SPACING, WALL * 0.5); // so that neighbours' bevels do not meet, model units
const FAR: f32 = SPACING * max(max(STRETCH.x, STRETCH.y), STRETCH.z); // how far an opening without an end is taken to reach

// What the cut shows at a point p of it; see the top.
fn grain(p: vec3<f32>, n: vec3<f32>, offset: f32, side: i32[[sited|, site: Site]]) -> Hit {
    let at: Place = place_of(p);
    let outward: vec3<f32> = n * -side_sign(f32(side));
    let seed: Seed = owner_of(at);
    let center: vec3<f32> = center_of(seed.cell); //? tear | keep
    if (!keep(model_point(seed.cell, center), 2.0 * FAR[[sited|, site]])) { //? keep
        return matrix_hit(outward, 0.0); //? keep & !solid
        return matrix_hit(outward, -CELL_BEVEL); //? keep & solid
    } //? keep
    let gap: Gap = cell_gap(at, seed, outward); //? solid
    if (gap.outside <= 0.0) { //? solid
        return Hit(0.0, outward, DISC, name_of(seed.cell), 1.0); //? solid
    } //? solid
    if (gap.outside < CELL_BEVEL) { //? solid
        let normal: vec3<f32> = unit_or(outward + gap.away, outward); //? solid
        return Hit(-gap.outside, normal, BEVEL, name_of(seed.cell), 0.5 + 0.5 * dot(normal, outward)); //? solid
    } //? solid
    return matrix_hit(outward, -CELL_BEVEL); //? solid
    if (wall_distance(at, seed) < WALL * 0.5) { //? walls & !solid
        return matrix_hit(outward, 0.0); //? walls & !solid
    } //? walls & !solid
    // Out of the half that holds the cell, or into the half that has its cavity. //? tear
    let across: vec3<f32> = to_lattice(n * STEP); //? tear
    let home: i32 = side_of(seed.cell, center, across, offset); //? tear
    let exit: Exit = walk(at, seed, n * -f32(home)[[onward|, across, offset, home]]); //? tear
    if (home * side > 0) { //? tear
        return Hit(exit.way, exit.normal, BUMP, name_of(seed.cell), 0.5 + 0.5 * dot(exit.normal, outward)); //? tear
    } //? tear
    let exit: Exit = walk(at, seed, -outward); //? hollow
    let openness: f32 = cell_openness(at, seed, outward, exit); //? walls & !solid
    let openness: f32 = 0.5 - 0.5 * dot(exit.normal, outward); //? !walls & !solid
    return Hit(-exit.way, -exit.normal, CAVITY, name_of(seed.cell), openness); //? !solid
}
