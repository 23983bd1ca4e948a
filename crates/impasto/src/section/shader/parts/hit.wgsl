// What a cut shows at a point.
struct Hit {
    height: f32, // above the section, along the outward normal of the half looked at; model units
    normal: vec3<f32>, // unit normal, model space
    kind: u32, // what is there: one of the five kinds above
    particle: u32, // the particle there, or whose bevel it is: the same number on both halves; 0 for none
    openness: f32, // how much of a uniform sky lights the point, 0 to 1
}

const MATRIX: u32 = 0u; // what is between the particles
const BUMP: u32 = 1u; // a particle that stands out of the section
const CAVITY: u32 = 2u; // where a particle was
const DISC: u32 = 3u; // a particle cut flat
const BEVEL: u32 = 4u; // the slope from a disc down to the matrix

// Where a ray leaves a particle: how far, and its outward unit normal there.
struct Exit {
    way: f32,
    normal: vec3<f32>,
}

// How far, within the section, a point is outside of a particle's outline (negative: inside), and which way that is.
struct Gap {
    outside: f32,
    away: vec3<f32>,
}

// A function whose zero is the surface, negative inside, with its gradient.
struct Level {
    value: f32,
    gradient: vec3<f32>,
}

fn matrix_hit(n: vec3<f32>, height: f32) -> Hit {
    return Hit(height, n, MATRIX, 0u, 1.0);
}
