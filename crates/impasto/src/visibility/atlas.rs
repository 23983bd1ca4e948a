//! Over an atlas: who owns each texel?
//!
//! A texel belongs to the triangle that covers its centre. Where none does, it may belong to one that touches it
//! (conservative), or, in the gutter around charts, to the owner of the nearest texel that has one: look-ups clamp
//! barycentrics to the triangle, so such texels continue the chart's border.

use super::tile::{Draw, Faces, Kind, Samples, TILE};
use super::{Domain, Hit, InfoBuffer};
use crate::assets::Mesh;
use crate::math::{Size, Vec2};
use crate::par::Workers;

/// Which texels have an owner besides those whose centre is covered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Atlas {
    /// Those that a triangle touches at all: no triangle is lost, however thin.
    pub conservative: bool,
    /// Those at most this many texels away from one with an owner.
    pub gutter: u32,
}

impl InfoBuffer {
    /// What the texels of a layout see. `uv_set` must exist. Where charts overlap, the first triangle owns.
    pub fn over_atlas(mesh: &Mesh, uv_set: usize, size: Size, atlas: Atlas, workers: &Workers) -> Self {
        let domain = Domain::over_atlas(mesh, uv_set, size);
        let all = Draw { triangles: 0..mesh.triangles().len() as u32, faces: Faces::Both, kind: Kind::Solid };
        let mut buffer = Self::build(&domain, &[all], Samples::One, None, workers);
        if atlas.conservative {
            buffer.touch(mesh, &mesh.uv_sets()[uv_set].uv);
        }
        for _ in 0..atlas.gutter {
            if !buffer.widen() {
                break;
            }
        }
        buffer
    }

    /// Gives texels without an owner to the first triangle that touches them.
    fn touch(&mut self, mesh: &Mesh, uv: &[Vec2]) {
        let (w, h) = (self.size.width as f64, self.size.height as f64);
        for (id, corners) in mesh.triangles().iter().enumerate() {
            let v = corners.map(|i| [uv[i as usize].x as f64 * w, uv[i as usize].y as f64 * h]);
            if v.iter().flatten().any(|x| !x.is_finite()) {
                continue;
            }
            let range = |k: usize, n: u32| {
                let lo = v.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
                let hi = v.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
                lo.floor().clamp(0.0, n as f64) as u32..hi.ceil().clamp(0.0, n as f64) as u32
            };
            for y in range(1, self.size.height) {
                for x in range(0, self.size.width) {
                    if self.at(x, y).0 == Hit::NOTHING && touches(&v, [x as f64, y as f64]) {
                        self.own(x, y, id as u32);
                    }
                }
            }
        }
    }

    /// One texel more around everything owned; whether there was any.
    fn widen(&mut self) -> bool {
        // Straight neighbours before diagonal ones, which are farther away.
        const AROUND: [[i64; 2]; 8] = [[0, -1], [-1, 0], [1, 0], [0, 1], [-1, -1], [1, -1], [-1, 1], [1, 1]];
        let (w, h) = (self.size.width as i64, self.size.height as i64);
        let ids = self.ids();
        let mut any = false;
        for y in 0..h {
            for x in 0..w {
                if ids[(y * w + x) as usize] != Hit::NOTHING {
                    continue;
                }
                let neighbour = |d: &[i64; 2]| {
                    let (nx, ny) = (x + d[0], y + d[1]);
                    let inside = (0..w).contains(&nx) && (0..h).contains(&ny);
                    inside.then(|| ids[(ny * w + nx) as usize]).filter(|&id| id != Hit::NOTHING)
                };
                if let Some(id) = AROUND.iter().find_map(neighbour) {
                    self.own(x as u32, y as u32, id);
                    any = true;
                }
            }
        }
        any
    }

    fn own(&mut self, column: u32, row: u32, id: u32) {
        let n_x = self.size.width.div_ceil(TILE as u32) as usize;
        let tile = &mut self.tiles[row as usize / TILE * n_x + column as usize / TILE];
        if tile.solid.ids.is_empty() {
            return;
        }
        tile.touched = true;
        let cell = row as usize % TILE * TILE + column as usize % TILE;
        tile.solid.ids[cell] = id;
        tile.solid.depths[cell] = 1.0;
    }
}

/// Whether a triangle and the texel at `cell` share a point: no edge separates them. (Their boxes overlap.)
fn touches(v: &[[f64; 2]; 3], cell: [f64; 2]) -> bool {
    let center = [cell[0] + 0.5, cell[1] + 0.5];
    let area = (v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) - (v[2][0] - v[0][0]) * (v[1][1] - v[0][1]);
    let sign = if area < 0.0 { -1.0 } else { 1.0 };
    (0..3).all(|i| {
        let (a, b) = (v[i], v[(i + 1) % 3]);
        let (dx, dy) = ((b[0] - a[0]) * sign, (b[1] - a[1]) * sign);
        let e = dx * (center[1] - a[1]) - dy * (center[0] - a[0]);
        e + 0.5 * (dx.abs() + dy.abs()) >= 0.0
    })
}
