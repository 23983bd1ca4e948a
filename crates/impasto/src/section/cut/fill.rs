//! Outline to cap: which places of the plane are inside, in triangles that use the outline's nodes and no others.
//!
//! A constrained Delaunay triangulation (crate `spade`) holds every segment; a flood from outside counts how often each
//! triangle is surrounded. Counts of 0 and 1 are solids with their cavities, and all is done at once. Else bodies overlap,
//! and each is filled alone with its cavities: the caps overlap as the bodies do, and each body stays closed.

use super::crossing::{Map, Node, Segment};
use super::loops::{doubled_area, surrounds};
use super::refine::parts;
use super::split::{between, split_crossings};
use crate::math::DVec2;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};
use std::ops::Range;

/// Triangles of a cap, counter-clockwise seen from above, as indices of nodes.
pub(super) type Triangles = Vec<[u32; 3]>;

/// What a cap became.
#[derive(Default)]
pub(super) struct Fill {
    pub(super) triangles: Triangles,
    /// Where bodies or a surface cross themselves: for each segment the nodes that were put into it, in its direction.
    pub(super) inner: Map<u32, Vec<u32>>,
    /// Segments that no triangulation could hold.
    pub(super) n_lost: usize,
    /// Whether bodies overlap in the section.
    pub(super) overlaps: bool,
}

struct Vertex {
    at: Point2<f64>,
    node: u32,
    /// Where it stood in the list of vertices.
    index: usize,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

type Mesh = ConstrainedDelaunayTriangulation<Vertex>;

/// A triangulation that holds segments, and where.
struct Planar {
    mesh: Mesh,
    handle_of: Map<u32, FixedVertexHandle>,
}

impl Planar {
    /// None when segments cross or touch but at common nodes.
    fn of(nodes: &[Node], segments: &[Segment], inner: Range<u32>) -> Option<Self> {
        // Coordinates of about one: the crate refuses very small numbers.
        let size = segments.iter().map(|s| nodes[s.from as usize].at.abs().max_element()).fold(0.0, f64::max);
        let scale = if size > 0.0 { 1.0 / size } else { 1.0 };
        let tidy = |x: f64| if x.abs() < 1e-60 { 0.0 } else { x };
        let point = |p: DVec2| Point2::new(tidy(p.x * scale), tidy(p.y * scale));
        let mut index_of: Map<u32, usize> = Map::default();
        let mut at_point: Map<[u64; 2], usize> = Map::default();
        let mut vertices = Vec::new();
        for node in segments.iter().flat_map(|s| [s.from, s.to]).chain(inner) {
            index_of.entry(node).or_insert_with(|| {
                let at = point(nodes[node as usize].at);
                let key = [at.x + 0.0, at.y + 0.0].map(f64::to_bits);
                *at_point.entry(key).or_insert_with(|| {
                    vertices.push(Vertex { at, node, index: vertices.len() });
                    vertices.len() - 1
                })
            });
        }
        let pair = |s: &Segment| [index_of[&s.from], index_of[&s.to]];
        let mut edges: Vec<[usize; 2]> = segments.iter().map(pair).filter(|[a, b]| a != b).collect();
        // Each once, in either direction.
        edges.iter_mut().for_each(|e| e.sort_unstable());
        edges.sort_unstable();
        edges.dedup();
        let mut conflicts = 0;
        let mesh = Mesh::try_bulk_load_cdt(vertices, edges, |_| conflicts += 1).ok()?;
        if conflicts > 0 {
            return None;
        }
        let mut handle_at = vec![None; index_of.len()];
        mesh.vertices().for_each(|v| handle_at[v.data().index] = Some(v.fix()));
        // Nodes of equal places share a vertex.
        let handle_of = index_of.iter().filter_map(|(&node, &i)| handle_at[i].map(|h| (node, h))).collect();
        Some(Self { mesh, handle_of })
    }

    /// For each directed edge how often its left is more inside than its right; None if a segment is not an edge.
    fn steps(&self, segments: &[Segment]) -> Option<Vec<i32>> {
        let mut steps = vec![0; self.mesh.num_directed_edges()];
        for s in segments {
            let (a, b) = (*self.handle_of.get(&s.from)?, *self.handle_of.get(&s.to)?);
            if a == b {
                continue;
            }
            let edge = self.mesh.get_edge_from_neighbors(a, b)?;
            steps[edge.fix().index()] += 1;
            steps[edge.rev().fix().index()] -= 1;
        }
        Some(steps)
    }

    /// How often each face is surrounded.
    fn windings(&self, steps: &[i32]) -> Vec<i32> {
        let mut windings = vec![i32::MAX; self.mesh.num_all_faces()];
        let outer = self.mesh.outer_face().fix();
        windings[outer.index()] = 0;
        // From the hull inwards.
        let mut todo = Vec::new();
        let visit = |edge: spade::handles::DirectedEdgeHandle<'_, Vertex, (), spade::CdtEdge<()>, ()>,
                     windings: &mut Vec<i32>,
                     todo: &mut Vec<_>| {
            let (left, right) = (edge.face().fix().index(), edge.rev().face().fix().index());
            if windings[left] == i32::MAX {
                windings[left] = windings[right] + steps[edge.fix().index()];
                todo.push(edge.face().fix());
            }
        };
        for edge in self.mesh.convex_hull() {
            // The hull's edges have the outer face on one side.
            for edge in [edge, edge.rev()] {
                if edge.rev().face().is_outer() && !edge.face().is_outer() {
                    visit(edge, &mut windings, &mut todo);
                }
            }
        }
        while let Some(face) = todo.pop() {
            if let Some(face) = self.mesh.face(face).as_inner() {
                for edge in face.adjacent_edges() {
                    visit(edge.rev(), &mut windings, &mut todo);
                }
            }
        }
        windings
    }

    /// The triangles of faces that `is_inside` takes.
    fn emit(&self, is_inside: impl Fn(usize, [DVec2; 3]) -> bool, out: &mut Triangles) {
        for face in self.mesh.inner_faces() {
            let corners = face.vertices();
            if is_inside(face.fix().index(), corners.map(|v| DVec2::new(v.position().x, v.position().y))) {
                out.push(corners.map(|v| v.data().node));
            }
        }
    }

    /// Faces as often as they are surrounded; turned over where that is negative. Layers get nodes of their own
    /// on inner edges that others have too, so that no edge has triangles of two layers.
    fn emit_layers(&self, windings: &[i32], nodes: &mut Vec<Node>, out: &mut Triangles) {
        let known = |f: usize| if windings[f] == i32::MAX { 0 } else { windings[f] };
        let most = (0..windings.len()).map(|f| known(f).abs()).max().unwrap_or(0);
        for layer in 1..=most {
            let mut middles: Map<(u32, u32), u32> = Map::default();
            for face in self.mesh.inner_faces() {
                let winding = known(face.fix().index());
                if winding.abs() < layer {
                    continue;
                }
                let corners = face.vertices().map(|v| v.data().node);
                let edges = face.adjacent_edges();
                let middle = [0, 1, 2].map(|k| {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    let edge = edges.iter().find(|e| e.from().data().node == a && e.to().data().node == b)?;
                    let other = known(edge.rev().face().fix().index());
                    let is_inner = other.abs() >= layer && (other > 0) == (winding > 0);
                    // The first layer shares its inner edges with nobody, but those that are another's border.
                    let is_shared = is_inner && (layer > 1 || other != winding);
                    is_shared.then(|| {
                        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                            nodes.push(between(nodes, [a.min(b), a.max(b)], 1.0 / (layer + 1) as f64));
                            nodes.len() as u32 - 1
                        })
                    })
                });
                for part in parts(middle.map(|m| m.is_some())) {
                    let [a, b, c] =
                        part.map(|k| if k < 3 { corners[k] } else { middle[k - 3].unwrap_or(corners[k - 3]) });
                    out.push(if winding > 0 { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
}

/// Fills closed runs of segments, with these nodes inside.
pub(super) fn fill(nodes: &mut Vec<Node>, segments: &[Segment], closed: &[Vec<u32>], inner: Range<u32>) -> Fill {
    let mut done = Fill::default();
    let all: Vec<u32> = closed.iter().flatten().copied().collect();
    if all.is_empty() {
        return done;
    }
    let used: Vec<Segment> = all.iter().map(|&i| segments[i as usize]).collect();
    if let Some(planar) = Planar::of(nodes, &used, inner.clone())
        && let Some(steps) = planar.steps(&used)
    {
        let windings = planar.windings(&steps);
        if windings.iter().all(|w| (0..=1).contains(w) || *w == i32::MAX) {
            planar.emit(|f, _| windings[f] == 1, &mut done.triangles);
            return done;
        }
    }
    done.overlaps = true;
    for group in bodies(nodes, segments, closed) {
        fill_body(nodes, segments, (&group, inner.clone()), &mut done);
    }
    done
}

/// One body with its cavities, whatever its outline does.
fn fill_body(nodes: &mut Vec<Node>, segments: &[Segment], (group, inner): (&[u32], Range<u32>), done: &mut Fill) {
    let used: Vec<Segment> = group.iter().map(|&i| segments[i as usize]).collect();
    // Split where it crosses itself; rounding may make new crossings, but hardly ever more than once.
    const ROUNDS: usize = 8;
    let mut pieces: Vec<Vec<u32>> = used.iter().map(|s| vec![s.from, s.to]).collect();
    for _ in 0..ROUNDS {
        let parts: Vec<Segment> = pieces
            .iter()
            .zip(&used)
            .flat_map(|(p, s)| p.windows(2).map(|w| Segment { from: w[0], to: w[1], triangle: s.triangle }))
            .collect();
        if let Some(planar) = Planar::of(nodes, &parts, inner.clone())
            && let Some(steps) = planar.steps(&parts)
        {
            let windings = planar.windings(&steps);
            planar.emit_layers(&windings, nodes, &mut done.triangles);
            for (&i, piece) in group.iter().zip(&pieces) {
                if piece.len() > 2 {
                    done.inner.insert(i, piece[1..piece.len() - 1].to_vec());
                }
            }
            return;
        }
        if !split_crossings(nodes, &mut pieces) {
            break;
        }
    }
    done.n_lost += group.len();
}

/// Runs grouped to bodies: each outer one with the cavities that lie in it and in no smaller one.
fn bodies(nodes: &[Node], segments: &[Segment], closed: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let areas: Vec<f64> = closed.iter().map(|run| doubled_area(nodes, segments, run)).collect();
    let mut groups: Vec<Vec<u32>> = Vec::new();
    let mut group_of = vec![usize::MAX; closed.len()];
    for (i, run) in closed.iter().enumerate() {
        if areas[i] > 0.0 {
            group_of[i] = groups.len();
            groups.push(run.clone());
        }
    }
    for (i, run) in closed.iter().enumerate() {
        if areas[i] > 0.0 {
            continue;
        }
        let s = segments[run[0] as usize];
        let p = (nodes[s.from as usize].at + nodes[s.to as usize].at) * 0.5;
        let around = (0..closed.len())
            .filter(|&k| areas[k] > -areas[i] && surrounds(nodes, segments, &closed[k], p))
            .min_by(|&a, &b| areas[a].total_cmp(&areas[b]));
        match around {
            Some(k) => groups[group_of[k]].extend(run),
            None => groups.push(run.clone()),
        }
    }
    groups
}

/// Fills open runs by the winding number, which is a fraction there: inside is where it is above one half (Jacobson, Kavan,
/// Sorkine-Hornung, "Robust Inside-Outside Segmentation using Generalized Winding Numbers", 2013).
pub(super) fn fill_by_winding(nodes: &[Node], segments: &[Segment], inner: Range<u32>) -> Fill {
    let mut done = Fill::default();
    let Some(planar) = Planar::of(nodes, segments, inner) else {
        done.n_lost = segments.len();
        return done;
    };
    let size = segments.iter().map(|s| nodes[s.from as usize].at.abs().max_element()).fold(0.0, f64::max);
    let ends: Vec<[DVec2; 2]> = segments.iter().map(|s| [s.from, s.to].map(|n| nodes[n as usize].at / size)).collect();
    // Angles from segment to segment cancel, but at the ends of runs and where the angle jumps: at the ray to the left.
    let mut balance = vec![0i32; nodes.len()];
    for s in segments {
        balance[s.to as usize] += 1;
        balance[s.from as usize] -= 1;
    }
    let loose: Vec<(DVec2, f64)> =
        nodes.iter().zip(&balance).map(|(n, &b)| (n.at / size, b as f64)).filter(|l| l.1 != 0.0).collect();
    let winding = |p: DVec2| -> f64 {
        let mut turns = 0;
        for [a, b] in &ends {
            if (a.y >= p.y) != (b.y >= p.y) && a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) < p.x {
                turns += if a.y >= p.y { 1 } else { -1 };
            }
        }
        let angle = |d: DVec2| crate::math::exact::atan2(d.y, d.x);
        turns as f64 + loose.iter().map(|(at, b)| b * angle(*at - p)).sum::<f64>() / std::f64::consts::TAU
    };
    planar.emit(|_, [a, b, c]| winding((a + b + c) / 3.0) > 0.5, &mut done.triangles);
    done
}
