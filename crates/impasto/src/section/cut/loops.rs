//! Segments to closed loops; what does not close is a gap.

use super::crossing::{Node, Segment};
use crate::math::{DVec2, Vec3};

/// A place where the outline of the section does not close.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Where the outline ends, model space.
    pub from: Vec3,
    /// Where it goes on; the end of the same piece if nothing is nearer.
    pub to: Vec3,
    /// Between the two, model units.
    pub length: f32,
    /// Whether a straight line was drawn over it.
    pub bridged: bool,
}

/// Runs of segments.
pub(super) struct Chains {
    /// Indices of segments, each run closed.
    pub(super) closed: Vec<Vec<u32>>,
    /// Runs that start and end somewhere.
    pub(super) open: Vec<Vec<u32>>,
}

/// Follows segments from node to node. At nodes of several loops it turns as far left as it can, so that loops that touch
/// stay apart.
pub(super) fn chains(nodes: &[Node], segments: &[Segment]) -> Chains {
    let mut walk = Walk { nodes, segments, leaving: vec![Vec::new(); nodes.len()], used: vec![false; segments.len()] };
    let mut balance = vec![0i32; nodes.len()];
    for (i, s) in segments.iter().enumerate() {
        walk.leaving[s.from as usize].push(i as u32);
        balance[s.from as usize] += 1;
        balance[s.to as usize] -= 1;
    }
    let mut chains = Chains { closed: Vec::new(), open: Vec::new() };
    // From where more goes out than comes in, to where more comes in.
    for node in 0..nodes.len() {
        while balance[node] > 0 {
            let Some(start) = walk.free(node as u32).next() else { break };
            let run = walk.from(start, |at| balance[at as usize] < 0);
            let end = segments[run[run.len() - 1] as usize].to;
            balance[node] -= 1;
            balance[end as usize] += 1;
            chains.open.push(run);
        }
    }
    for start in 0..segments.len() {
        if !walk.used[start] {
            let first = segments[start].from;
            chains.closed.push(walk.from(start as u32, |at| at == first));
        }
    }
    chains
}

struct Walk<'a> {
    nodes: &'a [Node],
    segments: &'a [Segment],
    /// For each node, its outgoing segments.
    leaving: Vec<Vec<u32>>,
    used: Vec<bool>,
}

impl Walk<'_> {
    fn free(&self, node: u32) -> impl Iterator<Item = u32> {
        self.leaving[node as usize].iter().copied().filter(|&i| !self.used[i as usize])
    }

    /// A run from a segment to the first node at which it is over.
    fn from(&mut self, start: u32, is_over: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut run = vec![start];
        self.used[start as usize] = true;
        let mut at = self.segments[start as usize];
        while !is_over(at.to) {
            let way = self.direction(at);
            let turn = |i: u32| turn(way, self.direction(self.segments[i as usize]));
            let Some(next) = self.free(at.to).max_by(|&a, &b| turn(a).total_cmp(&turn(b)).then(b.cmp(&a))) else {
                break;
            };
            self.used[next as usize] = true;
            run.push(next);
            at = self.segments[next as usize];
        }
        run
    }

    fn direction(&self, s: Segment) -> DVec2 {
        (self.nodes[s.to as usize].at - self.nodes[s.from as usize].at).normalize_or_zero()
    }
}

/// How far a way turns left: from -2 (back to the right) over 0 (straight on) to 2, rising with the angle.
fn turn(way: DVec2, next: DVec2) -> f64 {
    let (cos, sin) = (way.dot(next), way.perp_dot(next));
    if sin >= 0.0 { 1.0 - cos } else { cos - 1.0 }
}

/// The gaps of open runs: from each end to the nearest start that is still free, nearest pairs first.
pub(super) fn gaps(nodes: &[Node], segments: &[Segment], open: &[Vec<u32>]) -> Vec<(Gap, [u32; 2])> {
    let ends: Vec<u32> = open.iter().map(|run| segments[run[run.len() - 1] as usize].to).collect();
    let starts: Vec<u32> = open.iter().map(|run| segments[run[0] as usize].from).collect();
    let distance = |e: u32, s: u32| (nodes[e as usize].at - nodes[s as usize].at).length();
    let mut pairs = Vec::new();
    // Beyond so many only the own start is offered: all pairs would take quadratic memory.
    const MANY: usize = 2_000;
    for (i, &e) in ends.iter().enumerate() {
        if ends.len() > MANY {
            pairs.push((distance(e, starts[i]), i, i));
        } else {
            pairs.extend(starts.iter().enumerate().map(|(k, &s)| (distance(e, s), i, k)));
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let (mut end_used, mut start_used) = (vec![false; ends.len()], vec![false; starts.len()]);
    let mut gaps = Vec::new();
    for (length, e, s) in pairs {
        if !end_used[e] && !start_used[s] {
            (end_used[e], start_used[s]) = (true, true);
            let [from, to] = [ends[e], starts[s]];
            let [a, b] = [from, to].map(|n| nodes[n as usize].position);
            gaps.push((Gap { from: a, to: b, length: length as f32, bridged: false }, [from, to]));
        }
    }
    gaps
}

/// Twice the signed area of a closed run.
pub(super) fn doubled_area(nodes: &[Node], segments: &[Segment], run: &[u32]) -> f64 {
    let origin = nodes[segments[run[0] as usize].from as usize].at;
    let at = |n: u32| nodes[n as usize].at - origin;
    run.iter().map(|&i| at(segments[i as usize].from).perp_dot(at(segments[i as usize].to))).sum()
}

/// Whether a closed run goes around a point an odd number of times.
pub(super) fn surrounds(nodes: &[Node], segments: &[Segment], run: &[u32], p: DVec2) -> bool {
    run.iter().fold(false, |inside, &i| {
        let [a, b] = [segments[i as usize].from, segments[i as usize].to].map(|n| nodes[n as usize].at);
        let crosses = (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x);
        inside != crosses
    })
}
