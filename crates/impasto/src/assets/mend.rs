//! Defects of meshes: mended and reported, or refused.
//!
//! In the order of work: lengths that disagree, numbers that are none, triangles that are none or come twice, winding,
//! normals. Everything is linear in time (but for sorting of what is broken) and single-threaded, with results that
//! depend on nothing but the input. A mesh without defects is not copied.

use crate::assets::mesh::n_sources;
use crate::assets::normals::{self, Creases};
use crate::assets::weld::Weld;
use crate::assets::winding;
use crate::assets::{Element, Field, Mesh, Part, RawMesh, Values};
use crate::error::{Mended, Report, note};
use crate::math::{Bounds, Vec2, Vec3, Vec4, exact};

/// How a mesh is mended.
#[derive(Clone, Debug)]
pub struct MendOptions {
    /// Meshes without normals: faces that meet at a greater angle (radians) have an edge between them.
    pub crease: f32,
    /// Meshes without normals: for each triangle its smoothing group, in place of the angle. Faces of one group are
    /// smooth, of different groups not; 0 is flat. Empty: the angle decides.
    pub smooth_groups: Vec<u32>,
}

impl Default for MendOptions {
    /// Creases from 40 degrees.
    fn default() -> Self {
        Self { crease: 40f32.to_radians(), smooth_groups: Vec::new() }
    }
}

/// Coordinates beyond this have no finite squares and are taken as not finite.
const MAX_COORDINATE: f32 = 1e18;

/// Normals whose squared length is this near to one count as unit and keep their bits.
const UNIT_TOLERANCE: f32 = 1e-4;

impl RawMesh {
    /// A mesh that later stages can trust, and what had to be mended.
    pub fn mend(self) -> Report<Mesh> {
        self.mend_with(MendOptions::default())
    }

    /// The same with a choice.
    ///
    /// Takes about 20 bytes a triangle for its work when the mesh brings normals, 30 when it does not.
    pub fn mend_with(self, options: MendOptions) -> Report<Mesh> {
        let mut work = Work { mesh: self, groups: options.smooth_groups, mended: Vec::new() };
        work.mend_lengths();
        work.mend_numbers();
        work.drop_bad_triangles();
        let weld = Weld::of(&work.mesh.positions);
        work.mend_winding(&weld);
        if work.mesh.normals.is_empty() {
            work.make_normals(&weld, options.crease);
        } else {
            drop(weld);
            work.mend_normals();
        }
        work.mend_parts();
        let bounds = Some(Bounds::of(work.mesh.positions.iter().copied()));
        Report { value: Mesh { raw: work.mesh, bounds }, mended: work.mended }
    }
}

/// A mesh being mended.
struct Work {
    mesh: RawMesh,
    groups: Vec<u32>,
    mended: Vec<Mended>,
}

impl Work {
    fn note(&mut self, count: usize, what: impl Into<String>) {
        note(&mut self.mended, count, what);
    }

    /// Attributes that do not have one entry an element are dropped.
    fn mend_lengths(&mut self) {
        let (n_vertices, n_triangles) = (self.mesh.positions.len(), self.mesh.triangles.len());
        let m = &mut self.mesh;
        let mut dropped = Vec::new();
        fn check<T>(v: &mut Vec<T>, n: usize, name: &str, dropped: &mut Vec<String>) {
            if !v.is_empty() && v.len() != n {
                dropped.push(name.into());
                *v = Vec::new();
            }
        }
        check(&mut m.normals, n_vertices, "normals", &mut dropped);
        check(&mut m.tangents, n_vertices, "tangents", &mut dropped);
        check(&mut m.colors, n_vertices, "colours", &mut dropped);
        check(&mut m.source_points, n_vertices, "source points", &mut dropped);
        check(&mut m.source_faces, n_triangles, "source faces", &mut dropped);
        check(&mut self.groups, n_triangles, "smoothing groups", &mut dropped);
        m.uv_sets.retain(|set| keep_if(set.uv.len() == n_vertices, &set.name, &mut dropped));
        m.fields.retain(|f| {
            let n = n_elements(f.element, n_vertices, n_triangles);
            keep_if(f.n_components > 0 && f.values.len() == n * f.n_components, &f.name, &mut dropped)
        });
        if !dropped.is_empty() {
            let names = dropped.join(", ");
            self.note(dropped.len(), format!("attributes of the wrong length dropped: {names}"));
        }
    }

    /// No NaN or infinity in positions, texture coordinates, colours and tangents.
    fn mend_numbers(&mut self) {
        let is_good = |p: &Vec3| p.abs().max_element() <= MAX_COORDINATE && !p.is_nan();
        let bad: Vec<u32> = indices(&self.mesh.positions, |p| !is_good(p));
        if !bad.is_empty() {
            let in_use = self.drop_triangles_of(&bad);
            // They stay, as fields count them; they move to a place that does not change the bounds.
            let place = self.mesh.positions.iter().copied().find(is_good).unwrap_or(Vec3::ZERO);
            bad.iter().for_each(|&i| self.mesh.positions[i as usize] = place);
            self.note(bad.len(), "vertices without a finite position moved to the first good one");
            self.note(in_use, "triangles with such vertices dropped");
        }
        let mut n = 0;
        for uv in self.mesh.uv_sets.iter_mut().flat_map(|set| &mut set.uv).filter(|uv| !uv.is_finite()) {
            *uv = Vec2::ZERO;
            n += 1;
        }
        self.note(n, "texture coordinates that are not finite set to zero");
        let mut n = 0;
        for c in self.mesh.colors.iter_mut().filter(|c| !c.is_finite()) {
            *c = Vec4::ONE;
            n += 1;
        }
        self.note(n, "vertex colours that are not finite set to white");
        let is_tangent = |t: &Vec4| (t.truncate().length_squared() - 1.0).abs() < 0.01 && t.w.abs() == 1.0;
        let n = self.mesh.tangents.iter().filter(|t| !is_tangent(t)).count();
        if n > 0 {
            self.mesh.tangents = Vec::new();
            self.note(n, "tangents that are no unit vectors; all tangents dropped");
        }
    }

    /// Drops the triangles that use one of `vertices` (rising); tells how many.
    fn drop_triangles_of(&mut self, vertices: &[u32]) -> usize {
        let mut is_bad = vec![false; self.mesh.positions.len()];
        vertices.iter().for_each(|&v| is_bad[v as usize] = true);
        let bad = indices(&self.mesh.triangles, |t| t.iter().any(|&v| is_bad.get(v as usize) == Some(&true)));
        self.drop_triangles(&bad);
        bad.len()
    }

    /// Corners out of range or repeated, and no area at all.
    fn drop_bad_triangles(&mut self) {
        let (positions, n) = (&self.mesh.positions, self.mesh.positions.len() as u64);
        let mut counts = [0; 3];
        let bad = indices(&self.mesh.triangles, |t| {
            let fault = match t.map(|v| v as u64) {
                [a, b, c] if a >= n || b >= n || c >= n => 0,
                [a, b, c] if a == b || b == c || c == a => 1,
                _ if !has_area(t.map(|v| positions[v as usize])) => 2,
                _ => return false,
            };
            counts[fault] += 1;
            true
        });
        self.drop_triangles(&bad);
        self.note(counts[0], "triangles with vertices that do not exist dropped");
        self.note(counts[1], "triangles that repeat a corner dropped");
        self.note(counts[2], "triangles without area dropped");
    }

    /// Triangles that come twice are dropped, those wound against their neighbours turned.
    fn mend_winding(&mut self, weld: &Weld) {
        let mut survey = winding::survey(self.mesh.positions.len(), &self.mesh.triangles, weld);
        if !survey.duplicates.is_empty() {
            let duplicates = std::mem::take(&mut survey.duplicates);
            drop(survey);
            self.drop_triangles(&duplicates);
            self.note(duplicates.len(), "triangles that come twice dropped");
            survey = winding::survey(self.mesh.positions.len(), &self.mesh.triangles, weld);
        }
        let n_non_manifold = survey.n_non_manifold;
        let m = &mut self.mesh;
        let mut turned = Vec::new();
        let count = survey.turn(&m.positions, &m.triangles, |t| turned.push(t as u32));
        for &t in &turned {
            m.triangles[t as usize].swap(1, 2);
        }
        for field in m.fields.iter_mut().filter(|f| f.element == Element::Corner) {
            turned.iter().for_each(|&t| field.swap_corners(t as usize));
        }
        self.turn_normals(&turned);
        self.note(count.n_triangles, "triangles wound against their neighbours turned");
        self.note(count.n_inside_out, "closed pieces that were inside out turned");
        self.note(count.n_one_sided, "one-sided pieces (as a Moebius strip) left as they are");
        self.note(n_non_manifold, "edges of more than two triangles left as they are");
    }

    /// Normals at turned triangles that now look to the back follow them to the front.
    fn turn_normals(&mut self, turned: &[u32]) {
        let m = &mut self.mesh;
        if turned.is_empty() || m.normals.is_empty() {
            return;
        }
        let sums = normals::smooth(&m.positions, &m.triangles);
        let mut touched: Vec<u32> = turned.iter().flat_map(|&t| m.triangles[t as usize]).collect();
        touched.sort_unstable();
        touched.dedup();
        for v in touched.into_iter().map(|v| v as usize) {
            if m.normals[v].dot(sums[v]) < 0.0 {
                m.normals[v] = -m.normals[v];
                // The bitangent keeps its direction.
                m.tangents.get_mut(v).into_iter().for_each(|t| t.w = -t.w);
            }
        }
    }

    /// Normals for a mesh that has none, vertices split at creases.
    fn make_normals(&mut self, weld: &Weld, crease: f32) {
        let creases = Creases { cos_angle: exact::cos(crease as f64) as f32, groups: &self.groups };
        let made = normals::creased(&self.mesh.positions, &self.mesh.triangles, weld, &creases);
        for (corner, vertex) in made.moved {
            self.mesh.triangles[corner as usize / 3][corner as usize % 3] = vertex;
        }
        self.mesh.copy_vertices(&made.copies);
        self.mesh.normals = made.normals;
    }

    /// Normals that are none are made from the triangles, others made unit.
    fn mend_normals(&mut self) {
        let m = &mut self.mesh;
        let mut bad = Vec::new();
        for (i, n) in m.normals.iter_mut().enumerate() {
            let squared = n.length_squared();
            if (squared - 1.0).abs() <= UNIT_TOLERANCE {
                continue;
            }
            let [x, y, z] = [n.x, n.y, n.z].map(f64::from);
            let length = (x * x + y * y + z * z).sqrt();
            if length > 0.0 && length < f64::INFINITY {
                *n = (n.as_dvec3() / length).as_vec3();
            } else {
                bad.push(i);
            }
        }
        if bad.is_empty() {
            return;
        }
        let smooth = normals::smooth(&m.positions, &m.triangles);
        let mut used = vec![false; m.positions.len()];
        m.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let n_used = bad.iter().filter(|&&i| used[i]).count();
        bad.iter().for_each(|&i| m.normals[i] = crate::math::unit_or(smooth[i], Vec3::Y));
        self.note(n_used, "missing normals made from the triangles");
    }

    /// Parts cover all triangles in order.
    fn mend_parts(&mut self) {
        let n = self.mesh.triangles.len() as u32;
        let mut end = 0;
        let is_good = self.mesh.parts.iter().all(|p| {
            let follows = p.triangles.start == end && p.triangles.end >= end;
            end = p.triangles.end;
            follows
        }) && end == n;
        let one = || vec![Part { name: String::new(), triangles: 0..n, material: None }];
        if self.mesh.parts.is_empty() {
            self.mesh.parts = one();
        } else if !is_good {
            let n_parts = self.mesh.parts.len();
            self.mesh.parts = one();
            self.note(n_parts, "parts that do not cover the triangles in order joined to one");
        }
    }

    /// Drops triangles by index (rising), with all that belongs to them.
    fn drop_triangles(&mut self, dropped: &[u32]) {
        if dropped.is_empty() {
            return;
        }
        let m = &mut self.mesh;
        m.n_source_faces = n_sources(m.n_source_faces, &m.source_faces, m.triangles.len());
        if m.source_faces.is_empty() {
            m.source_faces = (0..m.triangles.len() as u32).collect();
        }
        remove(&mut m.triangles, 1, dropped);
        remove(&mut m.source_faces, 1, dropped);
        if !self.groups.is_empty() {
            remove(&mut self.groups, 1, dropped);
        }
        for field in &mut m.fields {
            let n = match field.element {
                Element::Vertex => continue,
                Element::Face => field.n_components,
                Element::Corner => field.n_components * 3,
            };
            match &mut field.values {
                Values::F32(v) => remove(v, n, dropped),
                Values::F64(v) => remove(v, n, dropped),
            }
        }
        let now = |t: u32| t - dropped.partition_point(|&d| d < t) as u32;
        m.parts.iter_mut().for_each(|p| p.triangles = now(p.triangles.start)..now(p.triangles.end));
        m.parts.retain(|p| !p.triangles.is_empty());
    }
}

impl RawMesh {
    /// Appends copies of vertices, with all their attributes.
    pub(super) fn copy_vertices(&mut self, sources: &[u32]) {
        if sources.is_empty() {
            return;
        }
        if self.source_points.is_empty() {
            self.source_points = (0..self.positions.len() as u32).collect();
        }
        fn copy<T: Copy>(v: &mut Vec<T>, n: usize, sources: &[u32]) {
            if !v.is_empty() {
                v.reserve_exact(sources.len() * n);
                for &s in sources {
                    v.extend_from_within(s as usize * n..(s as usize + 1) * n);
                }
            }
        }
        copy(&mut self.positions, 1, sources);
        copy(&mut self.normals, 1, sources);
        copy(&mut self.tangents, 1, sources);
        copy(&mut self.colors, 1, sources);
        copy(&mut self.source_points, 1, sources);
        self.uv_sets.iter_mut().for_each(|set| copy(&mut set.uv, 1, sources));
        for field in self.fields.iter_mut().filter(|f| f.element == Element::Vertex) {
            match &mut field.values {
                Values::F32(v) => copy(v, field.n_components, sources),
                Values::F64(v) => copy(v, field.n_components, sources),
            }
        }
    }
}

impl Field {
    /// Swaps the values of a triangle's second and third corner.
    fn swap_corners(&mut self, triangle: usize) {
        let n = self.n_components;
        let second = (triangle * 3 + 1) * n;
        for i in second..second + n {
            match &mut self.values {
                Values::F32(v) => v.swap(i, i + n),
                Values::F64(v) => v.swap(i, i + n),
            }
        }
    }
}

fn n_elements(element: Element, n_vertices: usize, n_triangles: usize) -> usize {
    match element {
        Element::Vertex => n_vertices,
        Element::Face => n_triangles,
        Element::Corner => n_triangles * 3,
    }
}

fn keep_if(keep: bool, name: &str, dropped: &mut Vec<String>) -> bool {
    if !keep {
        dropped.push(name.into());
    }
    keep
}

/// Exactly zero area is none; slivers are kept. In f64, where differences and products of f32 hardly round.
#[inline]
fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    // Most triangles show their area in f32 well above its rounding.
    let (u, v) = (b - a, c - a);
    let n = u.cross(v);
    if n.length_squared() > 1e-6 * u.length_squared() * v.length_squared() && n.length_squared() > 1e-20 {
        return true;
    }
    let [a, b, c] = [a, b, c].map(|p| p.as_dvec3());
    (b - a).cross(c - a).abs().max_element() > 0.0
}

/// Indices of the items for which `is_it`.
fn indices<T>(items: &[T], mut is_it: impl FnMut(&T) -> bool) -> Vec<u32> {
    items.iter().enumerate().filter(|(_, item)| is_it(item)).map(|(i, _)| i as u32).collect()
}

/// Removes groups of `n` items by the group's index (rising), in place.
fn remove<T: Copy>(items: &mut Vec<T>, n: usize, removed: &[u32]) {
    let mut to = removed.first().map_or(0, |&r| r as usize * n);
    for (i, &r) in removed.iter().enumerate() {
        let from = (r as usize + 1) * n;
        let end = removed.get(i + 1).map_or(items.len(), |&next| next as usize * n);
        items.copy_within(from..end, to);
        to += end - from;
    }
    if !removed.is_empty() {
        items.truncate(to);
    }
}

#[cfg(test)]
#[path = "mend_tests.rs"]
mod tests;
