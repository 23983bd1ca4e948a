// A particle that holds a place, and where it ends.
struct Found {
    side: i32, // -1: its centre is below the cut; 1: above, or this does not matter; 0: there is none
    cell: vec3<i32>,
    m: vec3<f32>, // the place seen from its centre
    body: Body,
    exit: Exit,
}

// Of the particles that hold a place: those below the cut come first, then the one that ends farthest from the cut.
fn search(at: Place, n: vec3<f32>, offset: f32, wanted: i32[[sited|, site: Site]]) -> Found { //? !apart
fn search(at: Place, n: vec3<f32>, offset: f32[[sited|, site: Site]]) -> Found { //? apart
    var best: Found;
    best.side = 0;
    best.exit = Exit(-1.0, n);
    for (var i: i32 = 0; i < WIDTH * WIDTH * WIDTH; i++) {
        let ring: vec3<i32> = cell_step(i, WIDTH);
        let cell: vec3<i32> = at.cell + ring;
        let center: vec3<f32> = center_of(cell);
        let m: vec3<f32> = at.rest - (vec3<f32>(ring) + center);
        if (dot(m, m) > REACH * REACH) {
            continue;
        }
        let free: Body = free_body(cell);
        // Most places are outside even at the greatest size; only the others need the neighbours. //? apart
        if (!holds([[grows|scaled(free, GROW)]][[!grows|free]], m)) { //? apart
            continue; //? apart
        } //? apart
        let body: Body = [[apart|scaled(free, scale_of(cell, center, free))]][[!apart|free]];
        if (!holds(body, m)) {
            continue;
        }
        if (!keep(model_point(cell, center), body_reach(body) * SPACING[[sited|, site]])) { //? keep
            continue; //? keep
        } //? keep
        let side: i32 = side_of(cell, center, n, offset); //? tear
        let side: i32 = 1; //? hollow
        if (side > 0 && best.side < 0) { //? tear
            continue; //? tear
        } //? tear
        if (wanted * side < 0) { //? !apart
            continue; //? !apart
        } //? !apart
        let exit: Exit = body_exit(body, m, n * -f32(side));
        if (side != best.side || exit.way > best.exit.way) {
            best = Found(side, cell, m, body, exit);
        }
    }
    return best;
}

// Where particles overlap, the way goes on through those it comes out in; more than eight in a row are not seen as relief.
fn farthest(at: Place, n: vec3<f32>, offset: f32[[sited|, site: Site]]) -> Found {
    var best: Found = search(at, n, offset, 0[[sited|, site]]);
    for (var k: i32 = 0; k < 8 && best.side != 0; k++) {
        let way: f32 = best.exit.way + 1e-5;
        let next: Found = search(moved(at, n * (-f32(best.side) * way)), n, offset, best.side[[sited|, site]]);
        if (next.side == 0) {
            break;
        }
        best = Found(best.side, next.cell, best.m, next.body, Exit(way + next.exit.way, next.exit.normal));
    }
    return best;
}

// Particles stay whole: each goes with the half that holds its centre, the other half shows a cavity. //? tear
fn section(at: Place, n: vec3<f32>, offset: f32, side: i32[[sited|, site: Site]]) -> Hit { //? tear
    let outward: vec3<f32> = n * side_sign(-f32(side)); //? tear
// Particles run out: both halves show cavities. //? hollow
fn section(at: Place, outward: vec3<f32>[[sited|, site: Site]]) -> Hit { //? hollow
    let found: Found = search(at, n, offset[[sited|, site]]); //? tear & apart
    let found: Found = farthest(at, n, offset[[sited|, site]]); //? tear & !apart
    let found: Found = search(at, outward, 0.0[[sited|, site]]); //? hollow & apart
    let found: Found = farthest(at, outward, 0.0[[sited|, site]]); //? hollow & !apart
    if (found.side == 0) {
        return matrix_hit(outward, 0.0);
    }
    let name: u32 = name_of(found.cell);
    if (found.side * side > 0) { //? tear
        let openness: f32 = 0.5 + 0.5 * dot(found.exit.normal, outward); //? tear
        return Hit(found.exit.way, found.exit.normal, BUMP, name, openness); //? tear
    } //? tear
    let openness: f32 = cavity_openness(found.body, found.m, outward, found.exit);
    return Hit(-found.exit.way, -found.exit.normal, CAVITY, name, openness);
}
