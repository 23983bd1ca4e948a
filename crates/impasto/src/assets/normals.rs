//! Normals for meshes that bring none: smooth over gentle edges, split at creases.
//!
//! Faces are weighted by their angle at the vertex (Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal
//! Facets", 1998).

use crate::assets::weld::Weld;
use crate::math::{Vec3, exact, unit_or};

/// Which edges stay sharp.
pub(super) struct Creases<'a> {
    /// Cosine of the angle between face normals above which an edge is a crease.
    pub(super) cos_angle: f32,
    /// For each triangle its smoothing group, 0 for flat; empty: the angle decides.
    pub(super) groups: &'a [u32],
}

/// Normals, and the vertices that had to be split to have them.
pub(super) struct Creased {
    /// One for each old vertex, then one for each copy.
    pub(super) normals: Vec<Vec3>,
    /// The old vertices of which copies are needed, in order; the first copy's index is the number of old vertices.
    pub(super) copies: Vec<u32>,
    /// Corners (three times the triangle plus 0, 1, 2) that move to another vertex.
    pub(super) moved: Vec<(u32, u32)>,
}

/// One corner of the triangles around a place.
#[derive(Clone, Copy)]
struct Corner {
    corner: u32,
    vertex: u32,
    normal: Vec3,
    /// The normal times the angle.
    weighted: Vec3,
    /// Index in the fan of the first corner it is smooth with, as in disjoint sets.
    leader: u32,
}

/// Angle-weighted normals, smooth within each fan of triangles that meet in edges which are no creases.
///
/// Takes 12 bytes a triangle and 4 a vertex while it works.
pub(super) fn creased(positions: &[Vec3], triangles: &[[u32; 3]], weld: &Weld, creases: &Creases) -> Creased {
    let (start, corners) = corners_by_place(positions.len(), triangles, weld);
    let mut out = Creased { normals: vec![Vec3::Y; positions.len()], copies: Vec::new(), moved: Vec::new() };
    let mut copy_normals = Vec::new();
    let (mut fan, mut spokes) = (Vec::new(), Vec::new());
    let mut uses: Vec<(u32, u32, u32)> = Vec::new();
    for ends in start.windows(2) {
        gather(&corners[ends[0] as usize..ends[1] as usize], positions, triangles, weld, &mut fan, &mut spokes);
        link(&mut fan, &mut spokes, creases);
        // The sums end up at the leaders.
        for i in 0..fan.len() {
            let leader = find(&mut fan, i as u32);
            if leader != i as u32 {
                let weighted = fan[i].weighted;
                fan[leader as usize].weighted += weighted;
            }
        }
        // The first smooth run that uses a vertex keeps it, the others get copies.
        uses.clear();
        for i in 0..fan.len() as u32 {
            uses.push((fan[i as usize].vertex, find(&mut fan, i), i));
        }
        uses.sort_unstable();
        for same_vertex in uses.chunk_by(|a, b| a.0 == b.0) {
            for (nth, same_run) in same_vertex.chunk_by(|a, b| a.1 == b.1).enumerate() {
                let (vertex, leader, i) = same_run[0];
                let normal = unit_or_some(fan[leader as usize].weighted, fan[i as usize].normal);
                if nth == 0 {
                    out.normals[vertex as usize] = normal;
                } else {
                    let copy = (positions.len() + out.copies.len()) as u32;
                    out.copies.push(vertex);
                    copy_normals.push(normal);
                    out.moved.extend(same_run.iter().map(|u| (fan[u.2 as usize].corner, copy)));
                }
            }
        }
    }
    out.normals.reserve_exact(copy_normals.len());
    out.normals.extend(copy_normals);
    out
}

/// Angle-weighted normals of all triangles at each vertex, no splitting; zero where there are none.
pub(super) fn smooth(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for t in triangles {
        let p = t.map(|v| positions[v as usize]);
        let normal = face_normal(p);
        for k in 0..3 {
            normals[t[k] as usize] += normal * angle(p, k);
        }
    }
    normals
}

/// Unit normal of a triangle; zero if it has no area. In f64, so that slivers and huge models keep theirs.
pub(super) fn face_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
    let n = (b - a).cross(c - a);
    let length = n.length_squared().sqrt();
    if length > 0.0 { (n / length).as_vec3() } else { Vec3::ZERO }
}

/// Angle at a corner, radians.
fn angle(p: [Vec3; 3], k: usize) -> f32 {
    let [a, b, c] = [p[k], p[(k + 1) % 3], p[(k + 2) % 3]].map(|p| p.as_dvec3());
    let (u, v) = (b - a, c - a);
    exact::atan2(u.cross(v).length_squared().sqrt(), u.dot(v)) as f32
}

/// A sum of weighted unit normals made unit; `fallback` when they cancel.
fn unit_or_some(sum: Vec3, fallback: Vec3) -> Vec3 {
    unit_or(sum, if fallback == Vec3::ZERO { Vec3::Y } else { fallback })
}

/// Counting sort of all corners by the place they stand at; within a place, in rising order.
fn corners_by_place(n_vertices: usize, triangles: &[[u32; 3]], weld: &Weld) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; n_vertices + 1];
    triangles.iter().flatten().for_each(|&v| start[weld.at(v) as usize] += 1);
    let mut sum = 0;
    for s in &mut start {
        sum += *s;
        *s = sum;
    }
    let mut corners = vec![0; sum as usize];
    for (corner, &v) in triangles.as_flattened().iter().enumerate().rev() {
        let s = &mut start[weld.at(v) as usize];
        *s -= 1;
        corners[*s as usize] = corner as u32;
    }
    (start, corners)
}

/// Fills `fan` with the corners at a place, and `spokes` with (other end, index in the fan) of their two sides.
fn gather(
    corners: &[u32],
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    weld: &Weld,
    fan: &mut Vec<Corner>,
    spokes: &mut Vec<(u32, u32)>,
) {
    fan.clear();
    spokes.clear();
    for (i, &corner) in corners.iter().enumerate() {
        let (triangle, k) = (triangles[corner as usize / 3], corner as usize % 3);
        let p = triangle.map(|v| positions[v as usize]);
        let normal = face_normal(p);
        let weighted = normal * angle(p, k);
        fan.push(Corner { corner, vertex: triangle[k], normal, weighted, leader: i as u32 });
        spokes.push((weld.at(triangle[(k + 1) % 3]), i as u32));
        spokes.push((weld.at(triangle[(k + 2) % 3]), i as u32));
    }
}

/// Joins corners that share a spoke which is no crease.
fn link(fan: &mut [Corner], spokes: &mut [(u32, u32)], creases: &Creases) {
    spokes.sort_unstable();
    for pair in spokes.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (i, j) = (pair[0].1, pair[1].1);
        let (a, b) = (&fan[i as usize], &fan[j as usize]);
        let is_smooth = match creases.groups {
            [] => a.normal.dot(b.normal) >= creases.cos_angle,
            groups => {
                let [g, h] = [a, b].map(|c| groups[c.corner as usize / 3]);
                g == h && g != 0
            }
        };
        if is_smooth {
            let (i, j) = (find(fan, i), find(fan, j));
            fan[i.max(j) as usize].leader = i.min(j);
        }
    }
}

fn find(fan: &mut [Corner], mut i: u32) -> u32 {
    while fan[i as usize].leader != i {
        let up = fan[i as usize].leader;
        fan[i as usize].leader = fan[up as usize].leader;
        i = up;
    }
    i
}
