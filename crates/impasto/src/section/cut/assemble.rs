//! One half of a mesh: what is whole, what is left of split triangles, and the cap. All attributes are kept.

use super::crossing::{Crossing, Fate, Map};
use super::fill::Fill;
use super::{CAP_NAME, Half, UV_NAME};
use crate::assets::{Element, Field, Part, RawMesh, UvSet, Values};
use crate::math::{DVec3, Vec2, Vec3, Vec4};
use crate::section::grain::Side;

/// A vertex between two others.
#[derive(Clone, Copy)]
struct Made {
    a: Source,
    b: Source,
    /// 0 at `a`, 1 at `b`.
    t: f64,
    position: Vec3,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Source {
    /// A vertex of the mesh.
    Old(u32),
    /// An index into `made`.
    Made(u32),
}

/// A corner of a split triangle's part.
#[derive(Clone, Copy)]
struct Corner {
    source: Source,
    /// Weights of the triangle's own corners.
    weights: [f64; 3],
    on_plane: bool,
}

/// The half being put together.
struct Work<'a, 'b> {
    crossing: &'b Crossing<'a>,
    /// For each vertex its index in the half, or none yet.
    index_of: Vec<u32>,
    /// The mesh's vertices that the half keeps, rising.
    kept: Vec<u32>,
    made: Vec<Made>,
    made_of: Map<(Source, Source, [u32; 3]), u32>,
    /// Corners as sources; indices come when `kept` is complete.
    triangles: Vec<[Source; 3]>,
    /// Which of the mesh's triangles each comes from.
    faces: Vec<u32>,
    /// Weights of the corners of split triangles, by their place in `triangles`.
    weights: Map<u32, [[f64; 3]; 3]>,
    parts: Vec<Part>,
}

const NONE: u32 = u32::MAX;

/// What all halves share.
pub(super) struct Pieces<'b> {
    pub(super) fill: &'b Fill,
    /// For each triangle, the segments with nodes put into them: both ends, and the nodes between.
    pub(super) inner: &'b Map<u32, Vec<PutIn>>,
    /// Where a node of the cap stands in relief, and its normal; none for those that stay.
    pub(super) lift: &'b dyn Fn(u32, Side) -> Option<[Vec3; 2]>,
}

/// Nodes put into a segment.
pub(super) struct PutIn {
    pub(super) ends: [Vec3; 2],
    pub(super) nodes: Vec<u32>,
}

pub(super) fn half(crossing: &Crossing, pieces: &Pieces, side: Side) -> Half {
    let mut work = Work {
        crossing,
        index_of: vec![NONE; crossing.soup.positions.len()],
        kept: Vec::new(),
        made: Vec::new(),
        made_of: Map::default(),
        triangles: Vec::new(),
        faces: Vec::new(),
        weights: Map::default(),
        parts: Vec::new(),
    };
    work.walk(side, pieces);
    work.number();
    work.finish(side, pieces)
}

impl Work<'_, '_> {
    /// Takes the triangles in order, part by part.
    fn walk(&mut self, side: Side, pieces: &Pieces) {
        let soup = self.crossing.soup;
        self.triangles.reserve(soup.triangles.len());
        self.faces.reserve(soup.triangles.len());
        let whole = if side == Side::Below { Fate::Below } else { Fate::Above };
        for part in soup.parts {
            let start = self.triangles.len() as u32;
            for t in part.triangles.clone() {
                let fate = self.crossing.fate(t as usize);
                let inner = if pieces.inner.is_empty() { None } else { pieces.inner.get(&t) };
                if fate == whole && inner.is_none() {
                    self.triangles.push(soup.triangles[t as usize].map(Source::Old));
                    self.faces.push(t);
                } else if fate == whole || fate == Fate::Split {
                    self.split(t, side, inner.map_or(&[][..], |put_in| put_in));
                }
            }
            let end = self.triangles.len() as u32;
            if start < end {
                self.parts.push(Part { triangles: start..end, ..part.clone() });
            }
        }
    }

    /// What is left of a triangle on one side, with the nodes that were put into its segment.
    fn split(&mut self, t: u32, side: Side, inner: &[PutIn]) {
        let corners = self.crossing.soup.triangles[t as usize];
        let sign = if side == Side::Below { -1.0 } else { 1.0 };
        let d = corners.map(|v| self.crossing.distances[v as usize] * sign);
        let mut polygon: Vec<Corner> = Vec::with_capacity(4);
        for k in 0..3 {
            let next = (k + 1) % 3;
            let unit = |k: usize| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
            if d[k] >= 0.0 {
                polygon.push(Corner { source: Source::Old(corners[k]), weights: unit(k), on_plane: d[k] == 0.0 });
            }
            if d[k] * d[next] < 0.0 {
                let (position, t) = self.crossing.point(corners[k], corners[next]);
                let source = self.make(Source::Old(corners[k]), Source::Old(corners[next]), t, position);
                let (a, b): ([f64; 3], [f64; 3]) = (unit(k), unit(next));
                let weights = std::array::from_fn(|i| a[i] * (1.0 - t) + b[i] * t);
                polygon.push(Corner { source, weights, on_plane: true });
            }
        }
        inner.iter().for_each(|put_in| self.put_in(&mut polygon, put_in));
        // A fan about a corner off the plane: no triangle of it lies along the segment.
        let Some(apex) = polygon.iter().position(|c| !c.on_plane) else {
            self.fan_in_plane(t, &polygon);
            return;
        };
        polygon.rotate_left(apex);
        for pair in polygon[1..].windows(2) {
            self.push(t, [polygon[0], pair[0], pair[1]]);
        }
    }

    /// A triangle in the plane with nodes on its edges: a fan about its middle.
    fn fan_in_plane(&mut self, t: u32, polygon: &[Corner]) {
        let corners = self.crossing.soup.triangles[t as usize];
        let [a, b, c] = corners.map(|v| self.crossing.soup.positions[v as usize].as_dvec3());
        let half = self.make(Source::Old(corners[1]), Source::Old(corners[2]), 0.5, ((b + c) * 0.5).as_vec3());
        let source = self.make(Source::Old(corners[0]), half, 2.0 / 3.0, ((a + b + c) / 3.0).as_vec3());
        let middle = Corner { source, weights: [1.0 / 3.0; 3], on_plane: true };
        for k in 0..polygon.len() {
            self.push(t, [middle, polygon[k], polygon[(k + 1) % polygon.len()]]);
        }
    }

    /// Puts nodes into the edge of the polygon that is their segment, in whichever direction they fit.
    fn put_in(&mut self, polygon: &mut Vec<Corner>, put_in: &PutIn) {
        let n = polygon.len();
        let [p, q] = put_in.ends;
        let is_edge = |k: &usize| {
            let (from, to) = (self.position(polygon[*k].source), self.position(polygon[(*k + 1) % n].source));
            (from == p && to == q) || (from == q && to == p)
        };
        let Some(k) = (0..n).find(is_edge) else { return };
        let (from, to) = (polygon[k], polygon[(k + 1) % n]);
        let (a, b) = (self.position(from.source).as_dvec3(), self.position(to.source).as_dvec3());
        let length = (b - a).length_squared().max(f64::MIN_POSITIVE);
        let is_turned = self.position(from.source) == q;
        let corner = |work: &mut Self, node: u32| {
            let position = work.crossing.nodes[node as usize].position;
            let t = ((position.as_dvec3() - a).dot(b - a) / length).clamp(0.0, 1.0);
            let source = work.make(from.source, to.source, t, position);
            let weights = std::array::from_fn(|i| from.weights[i] * (1.0 - t) + to.weights[i] * t);
            Corner { source, weights, on_plane: true }
        };
        let mut nodes = put_in.nodes.clone();
        if is_turned {
            nodes.reverse();
        }
        for (i, node) in nodes.into_iter().enumerate() {
            let corner = corner(self, node);
            polygon.insert(k + 1 + i, corner);
        }
    }

    fn push(&mut self, t: u32, corners: [Corner; 3]) {
        let [a, b, c] = corners.map(|c| self.position(c.source));
        // Rounded to a line: its neighbours meet without it.
        if a == b || b == c || c == a {
            return;
        }
        if !self.crossing.soup.fields.is_empty() {
            self.weights.insert(self.triangles.len() as u32, corners.map(|c| c.weights));
        }
        self.triangles.push(corners.map(|c| c.source));
        self.faces.push(t);
    }

    fn position(&self, source: Source) -> Vec3 {
        match source {
            Source::Old(v) => self.crossing.soup.positions[v as usize],
            Source::Made(i) => self.made[i as usize].position,
        }
    }

    /// The vertex between two others; the same for the same two in either order.
    fn make(&mut self, a: Source, b: Source, t: f64, position: Vec3) -> Source {
        let rank = |s: Source| match s {
            Source::Old(v) => (0, v),
            Source::Made(i) => (1, i),
        };
        let (a, b, t) = if rank(a) <= rank(b) { (a, b, t) } else { (b, a, 1.0 - t) };
        let key = (a, b, super::crossing::bits(position));
        let made = &mut self.made;
        Source::Made(*self.made_of.entry(key).or_insert_with(|| {
            made.push(Made { a, b, t, position });
            made.len() as u32 - 1
        }))
    }

    /// Gives the vertices that are used their indices, in the mesh's order.
    fn number(&mut self) {
        const USED: u32 = 0;
        for source in self.triangles.iter().flatten() {
            if let Source::Old(v) = source {
                self.index_of[*v as usize] = USED;
            }
        }
        for (v, index) in self.index_of.iter_mut().enumerate() {
            if *index == USED {
                *index = self.kept.len() as u32;
                self.kept.push(v as u32);
            }
        }
    }

    /// All arrays of the half.
    fn finish(self, side: Side, pieces: &Pieces) -> Half {
        let crossing = self.crossing;
        let soup = crossing.soup;
        let n_kept = self.kept.len() as u32;
        let index = |s: Source| match s {
            Source::Old(v) => self.index_of[v as usize],
            Source::Made(i) => n_kept + i,
        };
        let mut triangles: Vec<[u32; 3]> = self.triangles.iter().map(|t| t.map(index)).collect();
        let n_own = triangles.len() as u32;
        let first_of_cap = n_kept + self.made.len() as u32;

        // The cap has vertices of its own, as its normals differ; half without a body has no cap either.
        let mut cap_index = vec![NONE; crossing.nodes.len()];
        let mut cap_nodes = Vec::new();
        if n_own > 0 {
            for corners in &pieces.fill.triangles {
                let mut t = corners.map(|node| {
                    let slot = &mut cap_index[node as usize];
                    if *slot == NONE {
                        *slot = first_of_cap + cap_nodes.len() as u32;
                        cap_nodes.push(node);
                    }
                    *slot
                });
                if side == Side::Above {
                    t.swap(1, 2);
                }
                triangles.push(t);
            }
        }
        let n_caps = cap_nodes.len();
        let n_cap_triangles = triangles.len() - n_own as usize;
        let sign = if side == Side::Below { -1.0f32 } else { 1.0 };
        let lists = Lists { kept: &self.kept, made: &self.made, n_caps };

        let mut raw = RawMesh {
            positions: lists.fill(soup.positions, |_, _, _| Vec3::ZERO, Vec3::ZERO),
            normals: lists.fill(soup.normals, |a, b, t| mix3(a, b, t).normalize_or(a), Vec3::Y),
            tangents: lists.fill(
                soup.tangents,
                |a, b, t| mix3(a.truncate(), b.truncate(), t).normalize_or(a.truncate()).extend(a.w),
                Vec3::X.extend(sign),
            ),
            colors: lists.fill(soup.colors, mix4, Vec4::ONE),
            ..RawMesh::default()
        };
        for (i, made) in self.made.iter().enumerate() {
            raw.positions[n_kept as usize + i] = made.position;
        }
        for (i, &node) in cap_nodes.iter().enumerate() {
            let (v, position) = (first_of_cap as usize + i, crossing.nodes[node as usize].position);
            let [normal, along] = crossing.knife.frame(position.as_dvec3());
            let [position, normal] = (pieces.lift)(node, side).unwrap_or([position, (normal * -sign as f64).as_vec3()]);
            (raw.positions[v], raw.normals[v]) = (position, normal);
            if let Some(tangent) = raw.tangents.get_mut(v) {
                *tangent = along.as_vec3().extend(sign);
            }
        }
        for set in soup.uv_sets.iter().filter(|s| s.name != UV_NAME) {
            let uv = lists.fill(&set.uv, mix2, Vec2::ZERO);
            raw.uv_sets.push(UvSet { name: set.name.clone(), uv });
        }
        let mut flat = lists.earlier_caps(soup.uv_sets);
        for (i, &node) in cap_nodes.iter().enumerate() {
            flat[first_of_cap as usize + i] = crossing.nodes[node as usize].at.as_vec2();
        }
        raw.uv_sets.push(UvSet { name: UV_NAME.into(), uv: flat });
        raw.fields = soup.fields.iter().map(|f| self.field(f, &lists, n_cap_triangles)).collect();

        let point = |v: u32| if soup.source_points.is_empty() { v } else { soup.source_points[v as usize] };
        let near = |made: &Made| -> u32 {
            let mut at = *made;
            loop {
                match at.a {
                    Source::Old(v) => return v,
                    Source::Made(i) => at = self.made[i as usize],
                }
            }
        };
        raw.source_points = self.kept.iter().map(|&v| point(v)).collect();
        raw.source_points.extend(self.made.iter().map(|m| point(near(m))));
        raw.source_points.extend(cap_nodes.iter().map(|&n| point(crossing.nodes[n as usize].vertex)));
        let face = |t: u32| if soup.source_faces.is_empty() { t } else { soup.source_faces[t as usize] };
        raw.source_faces = self.faces.iter().map(|&t| face(t)).collect();
        raw.source_faces.resize(triangles.len(), soup.n_source_faces as u32);
        (raw.n_source_points, raw.n_source_faces) = (soup.n_source_points, soup.n_source_faces + 1);

        let cap = n_own..triangles.len() as u32;
        raw.parts = self.parts;
        if !cap.is_empty() {
            raw.parts.push(Part { name: CAP_NAME.into(), triangles: cap.clone(), material: None });
        }
        raw.triangles = triangles;
        Half { raw, cap, cap_vertices: first_of_cap..first_of_cap + n_caps as u32 }
    }

    /// A field of the half; missing on the cap.
    fn field(&self, field: &Field, lists: &Lists, n_cap_triangles: usize) -> Field {
        let n = field.n_components;
        let at = |i: usize, k: usize| field.values.at(i * n + k);
        let mut out: Vec<f64> = Vec::new();
        match field.element {
            Element::Vertex => {
                for &v in lists.kept {
                    out.extend((0..n).map(|k| at(v as usize, k)));
                }
                for made in lists.made {
                    for k in 0..n {
                        let [a, b] = [made.a, made.b].map(|s| match s {
                            Source::Old(v) => at(v as usize, k),
                            Source::Made(i) => out[(lists.kept.len() + i as usize) * n + k],
                        });
                        out.push(mix(a, b, made.t));
                    }
                }
                out.resize(out.len() + lists.n_caps * n, f64::NAN);
            }
            Element::Face => {
                for &t in &self.faces {
                    out.extend((0..n).map(|k| at(t as usize, k)));
                }
                out.resize(out.len() + n_cap_triangles * n, f64::NAN);
            }
            Element::Corner => {
                for (i, &t) in self.faces.iter().enumerate() {
                    let own = |c: usize, k: usize| at(t as usize * 3 + c, k);
                    match self.weights.get(&(i as u32)) {
                        None => out.extend((0..3).flat_map(|c| (0..n).map(move |k| (c, k))).map(|(c, k)| own(c, k))),
                        Some(weights) => {
                            for w in weights {
                                // A weight of zero must not let a missing value in.
                                let part = |c: usize, k: usize| if w[c] == 0.0 { 0.0 } else { w[c] * own(c, k) };
                                out.extend((0..n).map(|k| part(0, k) + part(1, k) + part(2, k)));
                            }
                        }
                    }
                }
                out.resize(out.len() + n_cap_triangles * 3 * n, f64::NAN);
            }
        }
        let values = match field.values {
            Values::F32(_) => Values::F32(out.into_iter().map(|x| x as f32).collect()),
            Values::F64(_) => Values::F64(out),
        };
        Field { values, ..field.clone() }
    }
}

/// What vertex arrays are gathered by.
struct Lists<'a> {
    kept: &'a [u32],
    made: &'a [Made],
    n_caps: usize,
}

impl Lists<'_> {
    /// A vertex array of the half; empty stays empty.
    fn fill<T: Copy>(&self, old: &[T], mix: impl Fn(T, T, f64) -> T, on_cap: T) -> Vec<T> {
        if old.is_empty() {
            return Vec::new();
        }
        let mut out: Vec<T> = Vec::with_capacity(self.kept.len() + self.made.len() + self.n_caps);
        out.extend(self.kept.iter().map(|&v| old[v as usize]));
        for made in self.made {
            // The far end of a crossed edge is not part of this half.
            let [a, b] = [made.a, made.b].map(|s| match s {
                Source::Old(v) => old[v as usize],
                Source::Made(i) => out[self.kept.len() + i as usize],
            });
            out.push(mix(a, b, made.t));
        }
        out.resize(out.len() + self.n_caps, on_cap);
        out
    }

    /// Plane coordinates of the caps of earlier cuts, zero elsewhere.
    fn earlier_caps(&self, sets: &[UvSet]) -> Vec<Vec2> {
        match sets.iter().find(|s| s.name == UV_NAME) {
            Some(set) => self.fill(&set.uv, mix2, Vec2::ZERO),
            None => vec![Vec2::ZERO; self.kept.len() + self.made.len() + self.n_caps],
        }
    }
}

/// Exactly the end at either end.
fn mix(a: f64, b: f64, t: f64) -> f64 {
    if t == 0.0 {
        a
    } else if t == 1.0 {
        b
    } else {
        a + (b - a) * t
    }
}

fn mix2(a: Vec2, b: Vec2, t: f64) -> Vec2 {
    (a.as_dvec2() + (b.as_dvec2() - a.as_dvec2()) * t).as_vec2()
}

fn mix3(a: Vec3, b: Vec3, t: f64) -> Vec3 {
    let (a, b): (DVec3, DVec3) = (a.as_dvec3(), b.as_dvec3());
    (a + (b - a) * t).as_vec3()
}

fn mix4(a: Vec4, b: Vec4, t: f64) -> Vec4 {
    (a.as_dvec4() + (b.as_dvec4() - a.as_dvec4()) * t).as_vec4()
}
