//! Do neighbouring triangles agree on which side is the front? If not, the fewer are turned.
//!
//! One pass over all edges joins triangles with a parity (disjoint sets), which is the flood over the surface without its
//! queue. Edges of more than two triangles join nothing: a piece ends there.

use crate::assets::edges::{Edges, HalfEdge};
use crate::assets::pieces::{Joined, Numbered, Pieces};
use crate::assets::weld::Weld;
use crate::math::{Bounds, Vec3};

/// What an edge's pass found.
pub(super) struct Survey {
    /// Triangles that repeat an earlier one's corners in the same order, rising. When there are any, the rest is void.
    pub(super) duplicates: Vec<u32>,
    /// Edges of more than two triangles.
    pub(super) n_non_manifold: usize,
    pieces: Pieces,
    /// Edges whose triangles are wound against each other.
    n_against: usize,
    /// Bit per triangle: it has an edge that ends its piece.
    at_border: Vec<u64>,
    /// Triangles at which a piece closes on itself turned over.
    one_sided: Vec<u32>,
}

/// How many were turned, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Turned {
    /// Triangles against the majority of their piece.
    pub(super) n_triangles: usize,
    /// Closed pieces that were inside out.
    pub(super) n_inside_out: usize,
    /// Pieces that cannot be wound one way, left as they are.
    pub(super) n_one_sided: usize,
}

/// Looks at every edge once.
pub(super) fn survey(n_vertices: usize, triangles: &[[u32; 3]], weld: &Weld) -> Survey {
    let edges = Edges::of(n_vertices, triangles, weld);
    let mut s = Survey {
        duplicates: Vec::new(),
        n_non_manifold: 0,
        pieces: Pieces::new(triangles.len()),
        n_against: 0,
        at_border: vec![0; triangles.len().div_ceil(64)],
        one_sided: Vec::new(),
    };
    let mut crowd = Vec::new();
    edges.for_each(triangles, weld, |_, sides| match *sides {
        [a, b] => {
            let against = a.forward == b.forward;
            if against {
                s.n_against += 1;
                find_duplicates(triangles, sides, &mut crowd, &mut s.duplicates);
            }
            if s.pieces.join(a.triangle(), b.triangle(), against) == Joined::Contradict {
                s.one_sided.push(a.triangle() as u32);
            }
        }
        _ => {
            if sides.len() > 2 {
                s.n_non_manifold += 1;
                find_duplicates(triangles, sides, &mut crowd, &mut s.duplicates);
            }
            sides.iter().for_each(|h| s.at_border[h.triangle() / 64] |= 1 << (h.triangle() % 64));
        }
    });
    s.duplicates.sort_unstable();
    s.duplicates.dedup();
    s
}

/// Of triangles at one edge, those that repeat another's corners and front.
fn find_duplicates(
    triangles: &[[u32; 3]],
    sides: &[HalfEdge],
    crowd: &mut Vec<([u32; 3], u32)>,
    duplicates: &mut Vec<u32>,
) {
    crowd.clear();
    crowd.extend(sides.iter().map(|h| (least_first(triangles[h.triangle()]), h.triangle() as u32)));
    crowd.sort_unstable();
    duplicates.extend(crowd.windows(2).filter(|w| w[0].0 == w[1].0 && w[0].1 != w[1].1).map(|w| w[1].1));
}

/// The same triangle, beginning with its least corner.
fn least_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// A piece that bounds a volume.
#[derive(Clone, Copy)]
struct Closed {
    /// Six times the signed volume.
    volume: f64,
    /// The sum of its terms' magnitudes: what rounding errors are measured by.
    magnitude: f64,
    bounds: Bounds,
    inside_out: bool,
}

#[derive(Clone, Copy)]
struct Piece {
    n: u32,
    n_turned: u32,
    /// Index of its `Closed`, or one of the two below.
    closed: u32,
    one_sided: bool,
}
const OPEN: u32 = u32::MAX;
const UNKNOWN: u32 = u32::MAX - 1;

/// Closed pieces are compared with this many of the largest to tell cavities; more would take quadratic time.
const N_HULLS: usize = 64;

impl Survey {
    /// Calls `turn` with each triangle that should be turned, in order.
    ///
    /// Within each piece the fewer are turned. Then a closed piece with negative volume is turned as a whole, unless its
    /// box lies inside that of another (large) closed piece: it is a cavity, and meant to look inwards.
    pub(super) fn turn(self, positions: &[Vec3], triangles: &[[u32; 3]], mut turn: impl FnMut(usize)) -> Turned {
        let pieces = self.pieces.numbered();
        let mut piece = vec![Piece { n: 0, n_turned: 0, closed: UNKNOWN, one_sided: false }; pieces.n];
        for t in 0..triangles.len() {
            let (i, turned) = pieces.at(t);
            piece[i].n += 1;
            piece[i].n_turned += turned as u32;
            if self.at_border[t / 64] >> (t % 64) & 1 == 1 {
                piece[i].closed = OPEN;
            }
        }
        for &t in &self.one_sided {
            let i = pieces.at(t as usize).0;
            piece[i].one_sided = true;
            piece[i].closed = OPEN;
        }
        let closed = inside_out(positions, triangles, &pieces, &mut piece);

        let mut count = Turned {
            n_triangles: 0,
            n_inside_out: closed.iter().filter(|c| c.inside_out).count(),
            n_one_sided: piece.iter().filter(|p| p.one_sided).count(),
        };
        if self.n_against == 0 && count.n_inside_out == 0 {
            return count;
        }
        for t in 0..triangles.len() {
            let (i, turned) = pieces.at(t);
            let against = piece[i].is_against(turned);
            count.n_triangles += against as usize;
            if against != closed.get(piece[i].closed as usize).is_some_and(|c| c.inside_out) {
                turn(t);
            }
        }
        count
    }
}

impl Piece {
    /// Whether a triangle is wound against the majority; when they are equal, against the first triangle.
    fn is_against(&self, turned: bool) -> bool {
        !self.one_sided && turned != (self.n_turned > self.n - self.n_turned)
    }
}

/// All closed pieces, with those marked that are inside out.
fn inside_out(positions: &[Vec3], triangles: &[[u32; 3]], pieces: &Numbered, piece: &mut [Piece]) -> Vec<Closed> {
    let mut closed: Vec<Closed> = Vec::new();
    for (t, corners) in triangles.iter().enumerate() {
        let (i, turned) = pieces.at(t);
        let p = &mut piece[i];
        if p.closed == OPEN {
            continue;
        }
        if p.closed == UNKNOWN {
            p.closed = closed.len() as u32;
            closed.push(Closed { volume: 0.0, magnitude: 0.0, bounds: Bounds::EMPTY, inside_out: false });
        }
        let c = &mut closed[p.closed as usize];
        let corners = corners.map(|v| positions[v as usize]);
        let [a, b, d] = corners.map(|p| p.as_dvec3());
        let part = a.dot(b.cross(d));
        c.volume += if p.is_against(turned) { -part } else { part };
        c.magnitude += part.abs();
        c.bounds = corners.iter().fold(c.bounds, |b, p| Bounds { min: b.min.min(*p), max: b.max.max(*p) });
    }
    // Volumes below rounding (2^-40 of the terms) are no volumes: sheets with two sides.
    let has_volume = |c: &Closed| c.volume.abs() > c.magnitude * (-40f64).exp2();
    let mut hulls: Vec<(usize, Closed)> =
        closed.iter().copied().enumerate().filter(|(_, c)| has_volume(c) && c.volume > 0.0).collect();
    hulls.sort_by(|(i, a), (j, b)| b.volume.total_cmp(&a.volume).then(i.cmp(j)));
    hulls.truncate(N_HULLS);
    for c in closed.iter_mut() {
        let is_cavity = || {
            hulls.iter().any(|(_, h)| c.bounds.min.cmpgt(h.bounds.min).all() && c.bounds.max.cmplt(h.bounds.max).all())
        };
        c.inside_out = has_volume(c) && c.volume < 0.0 && !is_cavity();
    }
    closed
}
