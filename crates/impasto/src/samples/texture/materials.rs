//! Materials by formula: bricks, wood, marble, scales, a leaf. All but the leaf tile.

use crate::assets::TextureImage;
use crate::math::{Size, Vec2, hash, unit_float, vec2, vec3};
use crate::noise::{Lattice, cellular_2d, fbm_2d, fbm_3d};
use crate::samples::texture::{Rgb, edge, fract, heights, mix, opaque, painted, rgb, shade, smooth};

/// A wall in running bond, four bricks wide and eight courses high.
pub fn bricks(size: Size, seed: u32) -> TextureImage {
    opaque("bricks", size, |t| {
        let b = Brick::at(t.uv, seed);
        let grain = fbm_2d(t.uv * 48.0, 3, 0.6, Lattice::tiled(seed, 48)).value;
        let patch = fbm_2d(t.uv * 8.0, 3, 0.5, Lattice::tiled(seed ^ 5, 8)).value;
        let mut clay = mix(rgb(0xa8452f), rgb(0xc9693f), b.own);
        if b.own > 0.86 {
            clay = mix(clay, rgb(0x6d3a34), 0.8);
        }
        clay = shade(clay, 1.0 + 0.16 * grain + 0.20 * patch);
        let mortar = shade(rgb(0xcfc6b6), 0.92 + 0.16 * grain);
        mix(mortar, clay, smooth(0.0, 0.10, b.inside))
    })
}

/// The wall's relief: 1 a brick's face, 0 the bottom of a joint.
pub fn brick_heights(size: Size, seed: u32) -> TextureImage {
    heights("brick heights", size, |t| {
        let b = Brick::at(t.uv, seed);
        let grain = fbm_2d(t.uv * 48.0, 3, 0.6, Lattice::tiled(seed, 48)).value;
        let face = 0.80 + 0.12 * (b.own - 0.5) + 0.08 * grain;
        0.22 + 0.06 * grain + (face - 0.22) * smooth(-0.02, 0.16, b.inside)
    })
}

/// Where a place lies in its brick.
struct Brick {
    /// Distance from the joint's edge in brick heights, negative in the joint.
    inside: f32,
    /// The brick's own random number.
    own: f32,
}

impl Brick {
    fn at(uv: Vec2, seed: u32) -> Self {
        const N: [f32; 2] = [4.0, 8.0];
        // Edges wander a little, as in a real wall.
        let wander = fbm_2d(uv * 16.0, 2, 0.5, Lattice::tiled(seed ^ 9, 16));
        let p = uv + vec2(wander.value, wander.value) * 0.003;
        let row = crate::math::floor(p.y * N[1]);
        let shift = if row as i32 & 1 == 0 { 0.0 } else { 0.5 };
        let x = p.x * N[0] + shift;
        let column = crate::math::floor(x);
        let (fx, fy) = (x - column, p.y * N[1] - row);
        // A brick is twice as wide as high.
        let q = vec2(0.96 - (fx - 0.5).abs() * 2.0 * 1.0, 0.92 - (fy - 0.5).abs() * 2.0) * vec2(1.0, 0.5);
        // Rounded corners: the distance to a box that is smaller by the radius.
        const RADIUS: f32 = 0.10;
        let corner = vec2((RADIUS - q.x).max(0.0), (RADIUS - q.y).max(0.0));
        let inside = if q.min_element() > RADIUS { q.min_element() } else { RADIUS - corner.length() };
        let id = (column as i32).rem_euclid(N[0] as i32) as u32 + 64 * (row as i32).rem_euclid(N[1] as i32) as u32;
        Self { inside, own: unit_float(hash(id ^ hash(seed))) }
    }
}

/// Four boards with year rings, knots and fibres.
pub fn wood(size: Size, seed: u32) -> TextureImage {
    opaque("wood", size, |t| {
        const BOARDS: f32 = 4.0;
        let board = crate::math::floor(t.uv.y * BOARDS);
        let k = (board as i32).rem_euclid(BOARDS as i32) as u32;
        let own = unit_float(hash(k ^ hash(seed)));
        let y = t.uv.y * BOARDS - board;
        // Rings: distance from a heart that lies beside the board and wanders along it.
        let l = Lattice { seed: seed.wrapping_add(31 * k), period: [2, 0, 0] };
        let bend = fbm_2d(vec2(t.uv.x * 2.0, y * 0.6), 3, 0.45, l).value;
        let ring = (y - 0.5 + 1.6 * (own - 0.5)).abs() * 6.0 + 2.2 * bend;
        let r = fract(ring);
        let late = smooth(0.25, 0.92, r) * (1.0 - smooth(0.92, 1.0, r));
        let fibre =
            fbm_2d(vec2(t.uv.x * 16.0, t.uv.y * 256.0), 2, 0.6, Lattice { seed: seed ^ 3, period: [16, 256, 0] }).value;
        let light = mix(rgb(0xdcb27c), rgb(0xc8935a), own);
        let mut c = mix(light, rgb(0x95602f), 0.62 * late);
        c = shade(c, 1.0 + 0.12 * fibre + 0.10 * (own - 0.5));
        let gap = y.min(1.0 - y);
        mix(rgb(0x4a2e18), c, smooth(0.004, 0.022, gap))
    })
}

/// White marble with grey veins.
pub fn marble(size: Size, seed: u32) -> TextureImage {
    opaque("marble", size, |t| {
        let l = Lattice::tiled(seed, 3);
        let warp = fbm_2d(t.uv * 3.0, 5, 0.55, l).value;
        let other = fbm_2d(t.uv * 3.0, 5, 0.55, Lattice::tiled(seed ^ 13, 3)).value;
        let cloud = fbm_2d(t.uv * 3.0, 3, 0.5, Lattice::tiled(seed ^ 77, 3)).value;
        stone(warp, other, cloud)
    })
}

/// Marble as a solid: `n` slices of `n` x `n` texels, from front to back; tiles in all three directions.
pub fn marble_volume(n: u32, seed: u32) -> Vec<TextureImage> {
    let n = n.max(1);
    (0..n)
        .map(|z| {
            let depth = (z as f32 + 0.5) / n as f32;
            opaque(&format!("marble {z}"), Size::new(n, n), |t| {
                let p = vec3(t.uv.x, t.uv.y, depth) * 3.0;
                let warp = fbm_3d(p, 4, 0.55, Lattice::tiled(seed, 3)).value;
                let other = fbm_3d(p, 4, 0.55, Lattice::tiled(seed ^ 13, 3)).value;
                let cloud = fbm_3d(p, 2, 0.5, Lattice::tiled(seed ^ 77, 3)).value;
                stone(warp * 1.15, other * 1.15, cloud)
            })
        })
        .collect()
}

/// Veins run where a noise is zero: sharp in the middle, soft beside.
fn stone(warp: f32, other: f32, cloud: f32) -> Rgb {
    let vein = |x: f32, width: f32| {
        let s = x / width;
        1.0 / (1.0 + s * s)
    };
    let mut c = mix(rgb(0xf3f0ea), rgb(0xd9d8d6), smooth(-0.2, 0.5, cloud));
    c = mix(c, rgb(0x8b8f96), 0.55 * vein(warp + 0.3 * cloud, 0.035));
    c = mix(c, rgb(0x4d5058), 0.65 * vein(warp + 0.3 * cloud, 0.010));
    mix(c, rgb(0xb79a6b), 0.45 * vein(other - 0.12, 0.014))
}

/// Overlapping scales like a fish's or a roof's, green to teal.
pub fn scales(size: Size, seed: u32) -> TextureImage {
    opaque("scales", size, |t| {
        let s = Scale::at(t.uv, seed);
        let c = mix(rgb(0x1f9d8b), rgb(0x7cc95a), s.own);
        let c = mix(shade(c, 0.52), c, smooth(0.0, 0.55, s.lift));
        let rim = smooth(0.16, 0.05, s.from_rim);
        let c = mix(c, rgb(0xf4e8a0), 0.55 * rim * smooth(0.0, 0.02, s.from_rim));
        let streak = fbm_2d(vec2(t.uv.x * 64.0, t.uv.y * 16.0), 2, 0.5, Lattice { seed, period: [64, 16, 0] }).value;
        shade(c, 1.0 + 0.10 * streak)
    })
}

/// The scales' relief.
pub fn scale_heights(size: Size, seed: u32) -> TextureImage {
    heights("scale heights", size, |t| {
        let s = Scale::at(t.uv, seed);
        0.15 + 0.8 * s.lift * smooth(0.0, 0.10, s.from_rim)
    })
}

/// Where a place lies on its scale.
struct Scale {
    /// Rises from 0 under the scale above to 1 at the free rim.
    lift: f32,
    /// Distance from the free rim, scale widths.
    from_rim: f32,
    /// The scale's own random number.
    own: f32,
}

impl Scale {
    fn at(uv: Vec2, seed: u32) -> Self {
        // Rows half a scale apart, each second one shifted; a scale hangs from its row as a half disc.
        const N: f32 = 8.0;
        let p = vec2(uv.x * N, uv.y * N * 2.0);
        let base = crate::math::floor(p.y);
        // The upper rows lie on top: take the first whose disc reaches here.
        for back in [0.0, 1.0, 2.0] {
            let row = base - (2.0 - back) + 1.0;
            let shift = if row as i32 & 1 == 0 { 0.0 } else { 0.5 };
            let x = p.x + shift;
            let column = crate::math::floor(x);
            let q = vec2(x - column - 0.5, (p.y - row) * 0.5);
            let from_rim = 0.58 - (q.x * q.x * 1.15 + q.y * q.y).sqrt();
            if from_rim > 0.0 && (q.y >= 0.0 || back == 2.0) {
                let id =
                    (column as i32).rem_euclid(N as i32) as u32 + 64 * (row as i32).rem_euclid(2 * N as i32) as u32;
                let lift = (q.y / 0.58).clamp(0.0, 1.0);
                return Self { lift, from_rim, own: unit_float(hash(id ^ hash(seed))) };
            }
        }
        Self { lift: 0.0, from_rim: 0.5, own: 0.5 }
    }
}

/// One leaf, cut out by alpha: stem at the bottom, tip at the top, with midrib, veins and cells.
pub fn leaf(size: Size) -> TextureImage {
    painted("leaf", size, 4, |t| {
        let (x, y) = ((t.uv.x - 0.5) * 2.0, 1.0 - t.uv.y);
        // Half width at a height: an ovate blade with a drawn-out tip, from 0.12 to 0.97, on a stem.
        let s = ((y - 0.12) / 0.85).clamp(0.0, 1.0);
        let tooth = 0.014 * (fract(s * 24.0) - 0.5) * smooth(0.02, 0.2, s) * smooth(1.0, 0.85, s);
        let half = 2.15 * s.sqrt() * (1.0 - s) * (1.0 - 0.35 * s) * 0.78 + tooth;
        let blade = if s > 0.0 && s < 1.0 { half - x.abs() } else { -1.0 };
        let stem = (0.022 - x.abs()).min(y - 0.02).min(0.5 - y);
        let alpha = edge(blade.max(stem) * 0.5, t.size);
        let mut c = mix(rgb(0x3f8a34), rgb(0x86bf4a), smooth(0.0, 0.8, x.abs() + 0.3 * s));
        let cells = cellular_2d(vec2(x * 20.0, y * 20.0), 0.9, Lattice::seeded(4));
        c = shade(c, 0.93 + 0.16 * smooth(0.0, 0.35, cells.second - cells.nearest));
        // Side veins leave the midrib upwards.
        let v = fract((y - 0.55 * x.abs()) * 11.0 + if x > 0.0 { 0.0 } else { 0.45 });
        let vein = (v - 0.5).abs();
        c = mix(c, rgb(0xd4e79a), 0.75 * smooth(0.10, 0.02, vein) * smooth(0.0, 0.05, blade));
        let rib = 0.026 * (1.0 - 0.75 * s) - x.abs();
        c = mix(c, rgb(0xe0edb0), edge(rib * 0.5, t.size));
        c = mix(c, rgb(0xc7a04a), 0.6 * smooth(0.05, 0.0, blade) * edge(blade, t.size));
        let [r, g, b] = c;
        [r, g, b, alpha]
    })
}
