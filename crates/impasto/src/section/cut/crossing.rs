//! Which triangles does the knife cross, and in which segments?
//!
//! A point of an edge is always worked out from the edge's lower place to the higher, so that both of its triangles get
//! the same bits; equal bits are one node. A crossing that rounds to a corner moves the corner onto the plane, and the
//! question is asked again.

use super::rim::Rim;
use super::soup::Soup;
use crate::math::{DVec2, DVec3, Vec3};
use crate::section::{Plane, Sheet};
use std::collections::{HashMap, hash_map::DefaultHasher};
use std::hash::BuildHasherDefault;

/// A map whose order is never used, the same on every run.
pub(super) type Map<K, V> = HashMap<K, V, BuildHasherDefault<DefaultHasher>>;

/// Where the section's outline has a corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// As in both halves, to the bit.
    pub(super) position: Vec3,
    /// Coordinates on the cut surface, model units.
    pub(super) at: DVec2,
    /// A vertex of the mesh that is near.
    pub(super) vertex: u32,
}

/// A piece of the outline: the half below is filled on its left, seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    pub(super) from: u32,
    pub(super) to: u32,
    /// The triangle that it lies in.
    pub(super) triangle: u32,
}

/// Where a triangle goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    Below,
    Above,
    Split,
}

/// What cuts.
#[derive(Clone, Copy)]
pub(super) enum Knife<'a> {
    /// With its axes and a point of it near the mesh, from which coordinates are small.
    Plane {
        plane: Plane,
        axes: [DVec3; 2],
        origin: DVec3,
    },
    Sheet(&'a dyn Sheet),
}

impl Knife<'_> {
    fn distance(&self, p: DVec3) -> f64 {
        match self {
            Self::Plane { plane, .. } => {
                plane.normal.x * p.x + plane.normal.y * p.y + plane.normal.z * p.z - plane.offset
            }
            Self::Sheet(sheet) => sheet.distance(p),
        }
    }

    /// Unit normal, and a unit vector along the first coordinate.
    pub(super) fn frame(&self, p: DVec3) -> [DVec3; 2] {
        match self {
            Self::Plane { plane, axes, .. } => [plane.normal, axes[0]],
            Self::Sheet(sheet) => {
                let normal = sheet.normal(p);
                [normal, Plane { normal, offset: 0.0 }.axes()[0]]
            }
        }
    }

    /// The point at coordinates.
    pub(super) fn point(&self, at: DVec2) -> DVec3 {
        match self {
            Self::Plane { axes, origin, .. } => *origin + axes[0] * at.x + axes[1] * at.y,
            Self::Sheet(sheet) => sheet.point(at),
        }
    }

    fn coordinates(&self, p: DVec3) -> DVec2 {
        match self {
            Self::Plane { axes, origin, .. } => DVec2::new((p - origin).dot(axes[0]), (p - origin).dot(axes[1])),
            Self::Sheet(sheet) => sheet.coordinates(p),
        }
    }

    /// How far along an edge, whose ends lie at these distances on different sides, it is crossed.
    fn crossing(&self, a: DVec3, b: DVec3, [da, db]: [f64; 2]) -> f64 {
        let straight = da / (da - db);
        let Self::Sheet(sheet) = self else { return straight };
        // Regula falsi, in the Illinois way, that halves the weight of an end which stays.
        let (mut low, mut high) = ([0.0, da], [1.0, db]);
        let mut t = straight;
        for _ in 0..60 {
            let d = sheet.distance(a + (b - a) * t);
            if d == 0.0 || high[0] - low[0] < 1e-14 {
                break;
            }
            if (d < 0.0) == (low[1] < 0.0) {
                low = [t, d];
                high[1] *= 0.5;
            } else {
                high = [t, d];
                low[1] *= 0.5;
            }
            t = low[0] + (high[0] - low[0]) * (low[1] / (low[1] - high[1]));
        }
        t.clamp(0.0, 1.0)
    }
}

/// A mesh and what cuts it.
pub(super) struct Crossing<'a> {
    pub(super) soup: Soup<'a>,
    pub(super) knife: Knife<'a>,
    /// Half of the last place of the largest coordinate: nearer than this is the same.
    pub(super) rounding: f64,
    /// Signed distances of the vertices; 0 within rounding.
    pub(super) distances: Vec<f64>,
    pub(super) nodes: Vec<Node>,
    node_of: Map<[u32; 3], u32>,
    /// The vertex that stands for a position.
    place_of: Map<[u32; 3], u32>,
}

/// A position's bits, with -0 as 0.
pub(super) fn bits(p: Vec3) -> [u32; 3] {
    (p + Vec3::ZERO).to_array().map(f32::to_bits)
}

impl<'a> Crossing<'a> {
    pub(super) fn of(soup: Soup<'a>, knife: Knife<'a>) -> Self {
        let far = soup.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max) as f64;
        let rounding = far / 16_777_216.0;
        let distance = |p: &Vec3| {
            let d = knife.distance(p.as_dvec3());
            if d.abs() <= rounding { 0.0 } else { d }
        };
        let mut crossing = Self {
            distances: soup.positions.iter().map(distance).collect(),
            soup,
            knife,
            rounding,
            nodes: Vec::new(),
            node_of: Map::default(),
            place_of: Map::default(),
        };
        crossing.find_places();
        crossing.snap();
        crossing
    }

    pub(super) fn fate(&self, triangle: usize) -> Fate {
        let corners = self.soup.triangles[triangle];
        let d = corners.map(|v| self.distances[v as usize]);
        let (any_below, any_above) = (d.iter().any(|&d| d < 0.0), d.iter().any(|&d| d > 0.0));
        match (any_below, any_above) {
            (true, true) => Fate::Split,
            (true, false) => Fate::Below,
            (false, true) => Fate::Above,
            (false, false) => {
                // In the plane: it closes the solid from above or from below.
                let [a, b, c] = corners.map(|v| self.soup.positions[v as usize].as_dvec3());
                let [normal, _] = self.knife.frame((a + b + c) / 3.0);
                if (b - a).cross(c - a).dot(normal) > 0.0 { Fate::Below } else { Fate::Above }
            }
        }
    }

    fn find_places(&mut self) {
        for (t, corners) in self.soup.triangles.iter().enumerate() {
            if self.fate(t) == Fate::Split {
                for &v in corners {
                    self.place_of.entry(bits(self.soup.positions[v as usize])).or_insert(v);
                }
            }
        }
    }

    /// Corners that a crossing rounds to come to lie on the plane. Each round settles at least one, and few need a second.
    fn snap(&mut self) {
        loop {
            let mut settled: Map<[u32; 3], ()> = Map::default();
            for t in 0..self.soup.triangles.len() {
                if self.fate(t) != Fate::Split {
                    continue;
                }
                let corners = self.soup.triangles[t];
                for k in 0..3 {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    if self.is_crossed(a, b) {
                        let p = bits(self.point(a, b).0);
                        for end in [a, b].map(|v| bits(self.soup.positions[v as usize])) {
                            if p == end {
                                settled.insert(p, ());
                            }
                        }
                    }
                }
            }
            if settled.is_empty() {
                break;
            }
            for (d, p) in self.distances.iter_mut().zip(self.soup.positions) {
                if *d != 0.0 && settled.contains_key(&bits(*p)) {
                    *d = 0.0;
                }
            }
        }
    }

    pub(super) fn is_crossed(&self, a: u32, b: u32) -> bool {
        let (da, db) = (self.distances[a as usize], self.distances[b as usize]);
        (da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)
    }

    /// Where the plane crosses an edge, and how far along it from `a` to `b`.
    pub(super) fn point(&self, a: u32, b: u32) -> (Vec3, f64) {
        let place = |v: u32| self.place_of.get(&bits(self.soup.positions[v as usize])).copied().unwrap_or(v);
        let turned = place(a) > place(b);
        let (low, high) = if turned { (b, a) } else { (a, b) };
        let (dl, dh) = (self.distances[low as usize], self.distances[high as usize]);
        let [pl, ph] = [low, high].map(|v| self.soup.positions[v as usize].as_dvec3());
        let t = self.knife.crossing(pl, ph, [dl, dh]);
        ((pl + (ph - pl) * t).as_vec3(), if turned { 1.0 - t } else { t })
    }

    /// The node at a position.
    pub(super) fn node(&mut self, position: Vec3, vertex: u32) -> u32 {
        let (nodes, knife) = (&mut self.nodes, self.knife);
        *self.node_of.entry(bits(position)).or_insert_with(|| {
            nodes.push(Node { position, at: knife.coordinates(position.as_dvec3()), vertex });
            nodes.len() as u32 - 1
        })
    }

    /// All segments: those across triangles, and edges in the plane that part what is below from what is above.
    pub(super) fn segments(&mut self) -> Vec<Segment> {
        let mut segments = Vec::new();
        let mut along_edges = Vec::new();
        for t in 0..self.soup.triangles.len() {
            let corners = self.soup.triangles[t];
            let d = corners.map(|v| self.distances[v as usize]);
            match self.fate(t) {
                Fate::Split => {
                    if let Some([from, to]) = self.across(corners)
                        && from != to
                    {
                        segments.push(Segment { from, to, triangle: t as u32 });
                    }
                }
                Fate::Below if d.iter().filter(|d| **d == 0.0).count() >= 2 => {
                    for k in 0..3 {
                        let (a, b) = (k, (k + 1) % 3);
                        if d[a] == 0.0 && d[b] == 0.0 {
                            let [from, to] = [b, a].map(|k| {
                                let v = corners[k];
                                self.node(self.soup.positions[v as usize], v)
                            });
                            if from != to {
                                along_edges.push(Segment { from, to, triangle: t as u32 });
                            }
                        }
                    }
                }
                _ => {}
            }
        }
        segments.extend(without_pairs(along_edges));
        segments
    }

    /// Adds a node in the middle of each edge in the plane that is no segment but ends on the outline: a ridge or a groove
    /// whose two triangles are on one side. The cap must not have this edge too, or four triangles would share it.
    pub(super) fn part_touching_edges(&mut self, segments: &[Segment], rim: &Rim) {
        let mut taken: Map<[u32; 2], ()> = Map::default();
        segments.iter().for_each(|s| _ = taken.insert([s.from.min(s.to), s.from.max(s.to)], ()));
        for t in 0..self.soup.triangles.len() {
            let corners = self.soup.triangles[t];
            let on_plane = corners.map(|v| self.distances[v as usize] == 0.0);
            if on_plane.iter().filter(|z| **z).count() < 2 {
                continue;
            }
            for k in 0..3 {
                let (a, b) = (k, (k + 1) % 3);
                let [pa, pb] = [a, b].map(|k| self.soup.positions[corners[k] as usize]);
                let nodes = [pa, pb].map(|p| self.node_of.get(&bits(p)).copied());
                if let ([Some(na), Some(nb)], true, true) = (nodes, on_plane[a], on_plane[b])
                    && na != nb
                    && taken.insert([na.min(nb), na.max(nb)], ()).is_none()
                {
                    let middle = (pa.as_dvec3() + pb.as_dvec3()) * 0.5;
                    let at = (self.nodes[na as usize].at + self.nodes[nb as usize].at) * 0.5;
                    // On the outline itself it would part a segment, which no triangle knows of.
                    if rim.distance(at) > 1e-3 * (pb - pa).length() as f64 {
                        self.nodes.push(Node { position: middle.as_vec3(), at, vertex: corners[k] });
                    }
                }
            }
        }
    }

    /// The segment across a split triangle.
    fn across(&mut self, corners: [u32; 3]) -> Option<[u32; 2]> {
        let (mut leaves, mut enters) = (None, None);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (da, db) = (self.distances[a as usize], self.distances[b as usize]);
            if da < 0.0 && db >= 0.0 {
                leaves = Some(self.end(a, b));
            } else if da >= 0.0 && db < 0.0 {
                enters = Some(self.end(b, a));
            }
        }
        // The triangle's own border runs from where it leaves to where it enters; the cap's the other way.
        Some([enters?, leaves?])
    }

    /// The node on an edge from `below` to a vertex above or on the plane.
    fn end(&mut self, below: u32, other: u32) -> u32 {
        if self.distances[other as usize] == 0.0 {
            self.node(self.soup.positions[other as usize], other)
        } else {
            let (position, _) = self.point(below, other);
            self.node(position, below)
        }
    }
}

/// Without edges that come in both directions: there both sides are below.
fn without_pairs(segments: Vec<Segment>) -> Vec<Segment> {
    let mut open: Map<(u32, u32), i32> = Map::default();
    for s in &segments {
        let (key, sign) = if s.from < s.to { ((s.from, s.to), 1) } else { ((s.to, s.from), -1) };
        *open.entry(key).or_insert(0) += sign;
    }
    let mut left = Vec::new();
    for s in segments {
        let (key, sign) = if s.from < s.to { ((s.from, s.to), 1) } else { ((s.to, s.from), -1) };
        if let Some(n) = open.get_mut(&key)
            && *n * sign > 0
        {
            *n -= sign;
            left.push(s);
        }
    }
    left
}
