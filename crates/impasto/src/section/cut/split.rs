//! Where polylines in the plane cross or touch, both get a node.

use super::crossing::Node;
use crate::math::{DVec2, DVec3};
use robust::{Coord, orient2d};

/// Puts nodes into polylines where their pieces cross, or where a node of one lies on another. Whether there were any.
///
/// Sweeps along x; takes quadratic time only where many pieces lie side by side.
pub(super) fn split_crossings(nodes: &mut Vec<Node>, lines: &mut [Vec<u32>]) -> bool {
    let mut pieces: Vec<(usize, usize)> =
        lines.iter().enumerate().flat_map(|(l, p)| (0..p.len() - 1).map(move |k| (l, k))).collect();
    let ends = |nodes: &[Node], (l, k): (usize, usize), lines: &[Vec<u32>]| {
        [lines[l][k], lines[l][k + 1]].map(|n| (n, nodes[n as usize].at))
    };
    let left = |nodes: &[Node], lines: &[Vec<u32>], p: (usize, usize)| {
        let [(_, a), (_, b)] = ends(nodes, p, lines);
        a.x.min(b.x)
    };
    pieces.sort_by(|&a, &b| left(nodes, lines, a).total_cmp(&left(nodes, lines, b)).then(a.cmp(&b)));
    // Where each piece is to be split, by how far along it is.
    let mut splits: Vec<((usize, usize), f64, u32)> = Vec::new();
    for (i, &p) in pieces.iter().enumerate() {
        let [(a, pa), (b, pb)] = ends(nodes, p, lines);
        let right = pa.x.max(pb.x);
        for &q in &pieces[i + 1..] {
            let [(c, pc), (d, pd)] = ends(nodes, q, lines);
            if pc.x.min(pd.x) > right {
                break;
            }
            if pc.y.min(pd.y) > pa.y.max(pb.y) || pc.y.max(pd.y) < pa.y.min(pb.y) {
                continue;
            }
            let (sc, sd) = (side(pa, pb, pc), side(pa, pb, pd));
            let (sa, sb) = (side(pc, pd, pa), side(pc, pd, pb));
            if sc * sd < 0.0 && sa * sb < 0.0 {
                let t = sa / (sa - sb);
                nodes.push(between(nodes, [a, b], t));
                let node = nodes.len() as u32 - 1;
                splits.push((p, t, node));
                splits.push((q, sc / (sc - sd), node));
                continue;
            }
            for (s, n, at) in [(sc, c, pc), (sd, d, pd)] {
                if s == 0.0 && n != a && n != b && is_between(pa, pb, at) {
                    splits.push((p, along(pa, pb, at), n));
                }
            }
            for (s, n, at) in [(sa, a, pa), (sb, b, pb)] {
                if s == 0.0 && n != c && n != d && is_between(pc, pd, at) {
                    splits.push((q, along(pc, pd, at), n));
                }
            }
        }
    }
    if splits.is_empty() {
        return false;
    }
    // From the back, so that the indices in front stay right.
    splits.sort_by(|a, b| b.0.cmp(&a.0).then(b.1.total_cmp(&a.1)).then(b.2.cmp(&a.2)));
    splits.dedup_by(|a, b| a.0 == b.0 && a.2 == b.2);
    for ((l, k), _, node) in splits {
        if lines[l][k] != node && lines[l].get(k + 1) != Some(&node) {
            lines[l].insert(k + 1, node);
        }
    }
    true
}

fn side(a: DVec2, b: DVec2, p: DVec2) -> f64 {
    let [a, b, p] = [a, b, p].map(|v| Coord { x: v.x, y: v.y });
    orient2d(a, b, p)
}

fn along(a: DVec2, b: DVec2, p: DVec2) -> f64 {
    (p - a).dot(b - a) / (b - a).length_squared()
}

fn is_between(a: DVec2, b: DVec2, p: DVec2) -> bool {
    (p - a).dot(b - a) > 0.0 && (p - b).dot(a - b) > 0.0
}

/// A node on the line between two others.
pub(super) fn between(nodes: &[Node], [a, b]: [u32; 2], t: f64) -> Node {
    let (na, nb) = (nodes[a as usize], nodes[b as usize]);
    let (pa, pb): (DVec3, DVec3) = (na.position.as_dvec3(), nb.position.as_dvec3());
    let position = (pa + (pb - pa) * t).as_vec3();
    Node { position, at: na.at + (nb.at - na.at) * t, vertex: na.vertex }
}
