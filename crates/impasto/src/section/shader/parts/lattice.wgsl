// The lattice that particles stand on. Inside, lengths are in spacings and directions along its axes; a point is a whole
// cell and a rest, so that nothing is lost far from the origin.
struct Place {
    cell: vec3<i32>, // the nearest node
    rest: vec3<f32>, // from this node to the point, each in [-0.5, 0.5]
}

const STEP: vec3<f32> = [[stretched|STRETCH * SPACING]][[!stretched|vec3<f32>(SPACING)]]; // along the model's axes
const STEP_UNIT: vec3<f32> = exp2(floor(log2(STEP)) - 11.0); // so that 4096 times the high part is exact
const STEP_HIGH: vec3<f32> = floor(STEP / STEP_UNIT) * STEP_UNIT;
const STEP_LOW: vec3<f32> = STEP - STEP_HIGH;

// Whole steps along the model's axes are led to the lattice in integers, only the rest in floats.
fn place_of(p: vec3<f32>) -> Place {
    let whole: vec3<f32> = floor(p / STEP);
    let rest: vec3<f32> = ((p - whole * STEP_HIGH) - whole * STEP_LOW) / STEP;
    let k: vec3<i32> = vec3<i32>(whole);
    let turned: vec3<i32> = TURN_X * k.x + TURN_Y * k.y + TURN_Z * k.z; //? turned
    let part: vec3<f32> = vec3<f32>(turned & vec3<i32>(4095)) / 4096.0; //? turned
    let at: vec3<f32> = part + whole * TURN_REST + rest * TURN; //? turned
    let node: vec3<f32> = floor(at + vec3<f32>(0.5)); //? turned
    return Place((turned >> vec3<u32>(12u)) + vec3<i32>(node), at - node); //? turned
    let node: vec3<f32> = floor(rest + vec3<f32>(0.5)); //? !turned
    return Place(k + vec3<i32>(node), rest - node); //? !turned
}

fn to_lattice(v: vec3<f32>) -> vec3<f32> {
    return v * TURN; //? turned
    return v; //? !turned
}

fn to_model(v: vec3<f32>) -> vec3<f32> {
    return TURN * v; //? turned
    return v; //? !turned
}

// The model's point that is `center` from a cell's node.
fn model_point(cell: vec3<i32>, center: vec3<f32>) -> vec3<f32> {
    return to_model(vec3<f32>(cell) + center) * STEP;
}

// Which half the particle of a cell goes with: -1 below, 1 above. By its centre, so that all pixels agree.
fn side_of(cell: vec3<i32>, center: vec3<f32>, n: vec3<f32>, offset: f32) -> i32 {
    if (dot(n, vec3<f32>(cell)) + dot(n, center) <= offset) {
        return -1;
    }
    return 1;
}

// The same place, a way on.
fn moved(at: Place, way: vec3<f32>) -> Place {
    let to: vec3<f32> = at.rest + way;
    let node: vec3<f32> = floor(to + vec3<f32>(0.5));
    return Place(at.cell + vec3<i32>(node), to - node);
}

// Names a cell's particle; never 0.
fn name_of(cell: vec3<i32>) -> u32 {
    return max(hash_cell(cell, SEED), 1u);
}
