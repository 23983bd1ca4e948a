//! Cells of a volume mesh to its outer surface: faces that belong to one cell only, and cells that are flat themselves.
//!
//! Cells and the order of their corners are VTK's (Schroeder, Martin, Lorensen, "The Visualization Toolkit", file formats).
//! Cells of higher order are taken by their corners. A cell whose corners are given inside out is turned.

use crate::assets::polygon::Triangulator;
use crate::math::Vec3;

/// Cells, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    /// VTK's numbers of cell types.
    kinds: Vec<u8>,
    /// Where each cell's points end.
    ends: Vec<usize>,
    /// Points; of polyhedra: the number of faces, then for each its number of corners and its corners.
    points: Vec<u32>,
}

/// VTK's number for a polygon.
pub(super) const POLYGON: u8 = 7;
/// VTK's number for a strip of triangles.
pub(super) const STRIP: u8 = 6;
/// VTK's number for a line of several points.
pub(super) const POLY_LINE: u8 = 4;
/// VTK's number for several single points.
pub(super) const POLY_VERTEX: u8 = 2;
/// VTK's number for a cell with faces of any kind.
pub(super) const POLYHEDRON: u8 = 42;

impl Cells {
    pub(super) fn push(&mut self, kind: u8, points: impl IntoIterator<Item = u32>) {
        self.kinds.push(kind);
        self.points.extend(points);
        self.ends.push(self.points.len());
    }

    pub(super) fn len(&self) -> usize {
        self.kinds.len()
    }

    /// Takes the place of a cell by nothing, so that others keep their numbers.
    pub(super) fn blank(&mut self, i: usize) {
        if let Some(kind) = self.kinds.get_mut(i) {
            *kind = 0;
        }
    }

    /// Appends others, whose points count from `first`.
    pub(super) fn append(&mut self, other: &Self, first: usize) {
        let moved = |i: &u32| i.saturating_add(u32::try_from(first).unwrap_or(u32::MAX));
        for i in 0..other.len() {
            let (kind, points) = other.at(i);
            if kind != POLYHEDRON {
                self.push(kind, points.iter().map(moved));
                continue;
            }
            // Counts stay as they are.
            let (mut left, mut out) = (0, points.first().copied().into_iter().collect::<Vec<u32>>());
            for p in points.iter().skip(1) {
                out.push(if left == 0 { *p } else { moved(p) });
                left = if left == 0 { *p } else { left - 1 };
            }
            self.push(kind, out);
        }
    }

    fn at(&self, i: usize) -> (u8, &[u32]) {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        (self.kinds[i], &self.points[start..self.ends[i]])
    }
}

/// What is seen of cells from outside.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each triangle, its cell.
    pub(super) source_faces: Vec<u32>,
    /// Points and lines, which have no surface.
    pub(super) n_thin: usize,
    /// Cells with fewer points than their kind has.
    pub(super) n_short: usize,
    /// Cells of a kind that is not known.
    pub(super) n_unknown: usize,
    /// Whether points need not lie on the surface: cells have an inside, or points between their corners.
    pub(super) has_inner_points: bool,
}

/// What a kind of cell is.
enum Form {
    Empty,
    Thin,
    Strip,
    /// A polygon of these corners.
    Flat(&'static [u8]),
    /// All its points; or, being quadratic, the first half of them.
    Polygon {
        is_quadratic: bool,
    },
    Solid(Solid),
    Polyhedron,
    Unknown,
}

/// Corners, and faces that look outwards.
#[derive(Clone, Copy)]
struct Solid {
    corners: &'static [u8],
    faces: &'static [&'static [u8]],
}

const TETRA: Solid = Solid { corners: &[0, 1, 2, 3], faces: &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]] };
const HEXA_FACES: &[&[u8]] =
    &[&[0, 4, 7, 3], &[1, 2, 6, 5], &[0, 1, 5, 4], &[3, 7, 6, 2], &[0, 3, 2, 1], &[4, 5, 6, 7]];
const HEXA: Solid = Solid { corners: &[0, 1, 2, 3, 4, 5, 6, 7], faces: HEXA_FACES };
const VOXEL: Solid = Solid { corners: &[0, 1, 3, 2, 4, 5, 7, 6], faces: HEXA_FACES };
const WEDGE: Solid = Solid {
    corners: &[0, 1, 2, 3, 4, 5],
    faces: &[&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]],
};
const PYRAMID: Solid =
    Solid { corners: &[0, 1, 2, 3, 4], faces: &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]] };
const PENTAGONAL_PRISM: Solid = Solid {
    corners: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9],
    faces: &[
        &[4, 3, 2, 1, 0],
        &[5, 6, 7, 8, 9],
        &[0, 1, 6, 5],
        &[1, 2, 7, 6],
        &[2, 3, 8, 7],
        &[3, 4, 9, 8],
        &[4, 0, 5, 9],
    ],
};
const HEXAGONAL_PRISM: Solid = Solid {
    corners: &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11],
    faces: &[
        &[5, 4, 3, 2, 1, 0],
        &[6, 7, 8, 9, 10, 11],
        &[0, 1, 7, 6],
        &[1, 2, 8, 7],
        &[2, 3, 9, 8],
        &[3, 4, 10, 9],
        &[4, 5, 11, 10],
        &[5, 0, 6, 11],
    ],
};

impl Form {
    fn of(kind: u8) -> Self {
        match kind {
            0 => Self::Empty,
            1..=4 | 21 | 35 | 68 | 75 => Self::Thin,
            STRIP => Self::Strip,
            5 | 22 | 34 | 69 | 76 => Self::Flat(&[0, 1, 2]),
            8 => Self::Flat(&[0, 1, 3, 2]),
            9 | 23 | 28 | 30 | 70 | 77 => Self::Flat(&[0, 1, 2, 3]),
            POLYGON => Self::Polygon { is_quadratic: false },
            36 => Self::Polygon { is_quadratic: true },
            10 | 24 | 71 | 78 => Self::Solid(TETRA),
            11 => Self::Solid(VOXEL),
            12 | 25 | 29 | 33 | 72 | 79 => Self::Solid(HEXA),
            13 | 26 | 31 | 32 | 73 | 80 => Self::Solid(WEDGE),
            14 | 27 | 37 | 74 | 81 => Self::Solid(PYRAMID),
            15 => Self::Solid(PENTAGONAL_PRISM),
            16 => Self::Solid(HEXAGONAL_PRISM),
            POLYHEDRON => Self::Polyhedron,
            _ => Self::Unknown,
        }
    }
}

/// A face of a solid cell.
struct Face {
    /// Names the face, whichever cell it is seen from.
    key: [u32; 4],
    /// Which of all faces.
    number: u32,
}

/// The outer surface. `at` gives a point's place, NaN when there is none.
pub(super) fn surface(cells: &Cells, at: impl Fn(u32) -> Vec3) -> Surface {
    let mut out = Surface::default();
    let is_outer = outer_faces(cells, &mut out);
    let mut cut = Triangulator::default();
    let (mut corners, mut n_faces) = (Vec::new(), 0);
    for i in 0..cells.len() {
        let (kind, points) = cells.at(i);
        let before = out.triangles.len();
        let mut add = |corners: &[u32], triangles: &mut Vec<[u32; 3]>| {
            let place = |k: usize| at(corners[k]);
            cut.cut(corners.len(), place, |t| triangles.push(t.map(|k| corners[k as usize])));
        };
        match Form::of(kind) {
            Form::Strip => strip(points, &mut out.triangles),
            Form::Flat(pick) if points.len() >= pick.len() => {
                corners.clear();
                corners.extend(pick.iter().map(|&k| points[k as usize]));
                out.has_inner_points |= points.len() > pick.len();
                add(&corners, &mut out.triangles);
            }
            Form::Polygon { is_quadratic } => {
                out.has_inner_points |= is_quadratic;
                add(&points[..if is_quadratic { points.len() / 2 } else { points.len() }], &mut out.triangles);
            }
            Form::Solid(_) | Form::Polyhedron => {
                let is_turned = is_inside_out(kind, points, &at);
                for_each_face(kind, points, |face| {
                    if is_outer[n_faces] {
                        corners.clear();
                        corners.extend_from_slice(face);
                        if is_turned {
                            corners.reverse();
                        }
                        add(&corners, &mut out.triangles);
                    }
                    n_faces += 1;
                });
            }
            _ => {}
        }
        out.source_faces.extend(std::iter::repeat_n(i as u32, out.triangles.len() - before));
    }
    out
}

/// For each face of each solid cell, whether no other cell has it. Counts what has no faces.
fn outer_faces(cells: &Cells, out: &mut Surface) -> Vec<bool> {
    let mut faces = Vec::new();
    for i in 0..cells.len() {
        let (kind, points) = cells.at(i);
        let is_short = match Form::of(kind) {
            Form::Thin => {
                out.n_thin += 1;
                false
            }
            Form::Unknown => {
                out.n_unknown += 1;
                false
            }
            Form::Flat(corners) => points.len() < corners.len(),
            Form::Polygon { is_quadratic } => points.len() < if is_quadratic { 6 } else { 3 },
            Form::Strip => points.len() < 3,
            Form::Solid(solid) => points.len() < solid.corners.len(),
            Form::Polyhedron | Form::Empty => false,
        };
        out.n_short += is_short as usize;
        let before = faces.len();
        for_each_face(kind, points, |corners| {
            faces.push(Face { key: key(corners), number: faces.len() as u32 });
        });
        out.has_inner_points |= faces.len() > before;
    }
    let mut is_outer = vec![false; faces.len()];
    faces.sort_unstable_by_key(|f| (f.key, f.number));
    for same in faces.chunk_by(|a, b| a.key == b.key) {
        if let [one] = same {
            is_outer[one.number as usize] = true;
        }
    }
    is_outer
}

/// The faces of a solid cell, corners that come twice in a row left out; none for other cells and for broken ones.
fn for_each_face(kind: u8, points: &[u32], mut face: impl FnMut(&[u32])) {
    let mut corners = Vec::with_capacity(8);
    let mut give = |each: &mut dyn Iterator<Item = u32>| {
        corners.clear();
        corners.extend(each);
        corners.dedup();
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() >= 3 {
            face(&corners);
        }
    };
    match Form::of(kind) {
        Form::Solid(solid) if points.len() >= solid.corners.len() => {
            for pick in solid.faces {
                give(&mut pick.iter().map(|&k| points[solid.corners[k as usize] as usize]));
            }
        }
        Form::Polyhedron => {
            let Some((_, mut rest)) = points.split_first() else { return };
            while let Some((&n, after)) = rest.split_first() {
                let Some(one) = after.get(..n as usize) else { return };
                give(&mut one.iter().copied());
                rest = &after[n as usize..];
            }
        }
        _ => {}
    }
}

/// The least corners, sorted; those beyond three mixed into one number.
fn key(corners: &[u32]) -> [u32; 4] {
    let mut sorted = [u32::MAX; 8];
    let mut many;
    let sorted = match sorted.get_mut(..corners.len()) {
        Some(few) => {
            few.copy_from_slice(corners);
            few
        }
        None => {
            many = corners.to_vec();
            &mut many[..]
        }
    };
    sorted.sort_unstable();
    let rest = match &sorted[3..] {
        [] => u32::MAX,
        [one] => *one,
        more => more.iter().fold(0x811c_9dc5, |h: u32, c| (h ^ c).wrapping_mul(0x0100_0193)),
    };
    [sorted[0], sorted[1], sorted[2], rest]
}

/// Whether a cell's faces look inwards: its volume is negative.
fn is_inside_out(kind: u8, points: &[u32], at: impl Fn(u32) -> Vec3) -> bool {
    let mut origin = None;
    let mut volume = 0.0;
    for_each_face(kind, points, |face| {
        let origin = *origin.get_or_insert_with(|| at(face[0]).as_dvec3());
        let place = |k: usize| at(face[k]).as_dvec3() - origin;
        volume += (1..face.len() - 1).map(|k| place(0).dot(place(k).cross(place(k + 1)))).sum::<f64>();
    });
    volume < 0.0
}

/// Triangles of a strip, all wound as the first.
fn strip(points: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let turned = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
    triangles.extend(points.windows(3).enumerate().map(turned));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;

    /// Twice the corners of a lattice of 3 x 2 x 2 points.
    fn at(i: u32) -> Vec3 {
        if i < 12 { vec3((i % 3) as f32, (i / 3 % 2) as f32, (i / 6) as f32) } else { Vec3::NAN }
    }

    /// Triangles, six times their volume, and twice their area.
    fn measure(cells: &Cells) -> (usize, f32, f32) {
        let s = surface(cells, at);
        let corners = s.triangles.iter().map(|t| t.map(at));
        let volume = corners.clone().map(|[a, b, c]| a.dot(b.cross(c))).sum();
        let area = corners.map(|[a, b, c]| (b - a).cross(c - a).length()).sum();
        (s.triangles.len(), volume, area)
    }

    #[test]
    fn cells_that_touch_have_one_skin() {
        let mut two = Cells::default();
        two.push(12, [0, 1, 4, 3, 6, 7, 10, 9]);
        // Inside out.
        two.push(12, [7, 8, 11, 10, 1, 2, 5, 4]);
        assert_eq!(measure(&two), (20, 12.0, 20.0));
        let mut mixed = Cells::default();
        mixed.push(11, [0, 1, 3, 4, 6, 7, 9, 10]);
        mixed.push(13, [1, 2, 4, 7, 8, 10]);
        assert_eq!(measure(&mixed).0, 16);
        assert_eq!(measure(&mixed).1, 9.0);
        let s = surface(&mixed, at);
        assert_eq!(s.source_faces.iter().filter(|c| **c == 1).count(), 6);
    }

    #[test]
    fn every_solid_is_closed_and_looks_outwards() {
        // Six times the volume: a tetrahedron 1, a pyramid 2, a wedge 3, a box 6.
        for (kind, points, volume) in [
            (10, &[0, 1, 3, 6][..], 1.0),
            (10, &[0, 3, 1, 6], 1.0),
            (24, &[0, 1, 3, 6, 9, 9, 9, 9, 9, 9], 1.0),
            (12, &[0, 1, 4, 3, 6, 7, 10, 9], 6.0),
            (13, &[0, 1, 3, 6, 7, 9], 3.0),
            (14, &[0, 1, 4, 3, 6], 2.0),
            // A wedge as a collapsed box.
            (12, &[0, 1, 3, 3, 6, 7, 9, 9], 3.0),
            (42, &[4, 3, 0, 1, 3, 3, 0, 6, 1, 3, 1, 6, 3, 3, 3, 6, 0], 1.0),
        ] {
            let mut cells = Cells::default();
            cells.push(kind, points.iter().copied());
            assert_eq!(measure(&cells).1, volume, "{kind} {points:?}");
        }
    }

    #[test]
    fn prisms_have_all_their_faces() {
        for (kind, n) in [(15, 5), (16, 6)] {
            let mut cells = Cells::default();
            cells.push(kind, 0..2 * n);
            let s = surface(&cells, at);
            assert_eq!(s.triangles.len() as u32, 2 * (n - 2) + 2 * n);
        }
    }

    #[test]
    fn flat_thin_and_broken_cells_are_told_apart() {
        let mut cells = Cells::default();
        for (kind, points) in [
            (9, &[0, 1, 4, 3][..]),
            (8, &[0, 1, 3, 4]),
            (6, &[0, 1, 3, 4]),
            (7, &[0, 1, 2, 5, 4, 3]),
            (3, &[0, 1]),
            (12, &[0, 1]),
            (99, &[0]),
            (42, &[2, 3, 0, 1]),
            (42, &[]),
            (12, &[90, 91, 92, 93, 94, 95, 96, 97]),
        ] {
            cells.push(kind, points.iter().copied());
        }
        let s = surface(&cells, at);
        assert_eq!((s.n_thin, s.n_short, s.n_unknown), (1, 1, 1));
        assert_eq!(s.triangles.len(), 2 + 2 + 2 + 4 + 12);
        assert!(s.triangles[..10].iter().all(|t| {
            let [a, b, c] = t.map(at);
            (b - a).cross(c - a).z > 0.0
        }));
    }
}
