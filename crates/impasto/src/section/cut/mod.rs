//! Cut a mesh by a plane or along a curved surface into two capped halves that fit.
//!
//! Both halves have the same border, to the bit, and all attributes of the mesh, interpolated where it was cut. Of a
//! closed mesh each half is closed again, its volumes add up, and shells in shells are cavities. What does not close in the
//! section is reported as a [`Gap`] and treated by a [`Policy`].

mod assemble;
mod crossing;
mod fill;
#[cfg(test)]
mod hard_tests;
mod loops;
mod refine;
mod rim;
pub mod skin;
mod soup;
mod split;
#[cfg(test)]
mod tests;

pub use loops::Gap;
pub use rim::Rim;
pub use soup::{Soup, volume};

use crate::assets::RawMesh;
use crate::math::{DVec2, DVec3, Vec3};
use crate::section::grain::{Hit, Side};
use crate::section::{Plane, Sheet};
use assemble::{Pieces, PutIn};
use crossing::{Crossing, Knife, Segment};
use std::ops::Range;

/// The name of the part that a cap is.
pub const CAP_NAME: &str = "section";

/// The name of the layout that holds plane coordinates of caps: model units along [`Section::axes`], v up. Zero elsewhere.
pub const UV_NAME: &str = "section";

/// What to do where the outline of the section does not close: at holes of the surface, or where it is torn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Policy {
    /// Refuse, with the list of gaps.
    Strict,
    /// Draw straight lines over gaps up to this length, model units; what is left is as `Open`.
    Bridge(f32),
    /// Fill what is more inside than outside, by the generalized winding number.
    #[default]
    Winding,
    /// No cap there.
    Open,
}

/// One half of a mesh.
#[derive(Clone, Debug)]
pub struct Half {
    /// Valid as it is: see [`Mesh`](crate::assets::Mesh) for what that means. Empty if the plane misses this side.
    pub raw: RawMesh,
    /// Triangles of the cap: the last ones.
    pub cap: Range<u32>,
    /// Vertices of the cap: the last ones. Each stands where one or more of the outer surface stand.
    pub cap_vertices: Range<u32>,
}

/// What is common to both halves. Coordinates are those of the plane, or of the [`Sheet`] that cut.
#[derive(Clone, Debug)]
pub struct Section {
    /// The plane, if it was one that cut.
    pub plane: Option<Plane>,
    /// Where plane coordinates are zero, model space; zero for sheets.
    pub origin: DVec3,
    /// +u and +v in the plane; with the plane's normal a right-handed frame. Zero for sheets.
    pub axes: [DVec3; 2],
    /// Closed outlines in plane coordinates: counter-clockwise around what is inside, clockwise around cavities.
    pub contours: Vec<Vec<DVec2>>,
    /// Outlines that do not close.
    pub open_contours: Vec<Vec<DVec2>>,
    /// Triangles of the cap as plane coordinates, counter-clockwise.
    pub triangles: Vec<[DVec2; 3]>,
}

/// A mesh cut in two.
#[derive(Clone, Debug)]
pub struct Cut {
    /// What is below the plane: its cap looks along the plane's normal.
    pub below: Half,
    /// What is above.
    pub above: Half,
    /// What both share.
    pub section: Section,
    /// Where the outline did not close.
    pub gaps: Vec<Gap>,
    /// Whether bodies overlap in the section, so that their caps do.
    pub overlaps: bool,
    /// Pieces of the outline without a cap, because no triangulation could hold them.
    pub n_lost: usize,
}

/// A section that does not close, under [`Policy::Strict`].
#[derive(Clone, Debug, thiserror::Error)]
#[error("the section does not close: {} gaps, the widest {} long at {}; mend the mesh or choose another policy", .gaps.len(), widest(.gaps).length, widest(.gaps).from)]
pub struct Refused {
    /// All of them.
    pub gaps: Vec<Gap>,
}

fn widest(gaps: &[Gap]) -> Gap {
    let none = Gap { from: Vec3::ZERO, to: Vec3::ZERO, length: 0.0, bridged: false };
    gaps.iter().copied().fold(none, |a, b| if b.length > a.length { b } else { a })
}

/// Cuts a valid mesh.
///
/// Vertices nearer to the plane than rounding of their coordinates count as on it. Triangles in the plane go to the half
/// whose solid they close. A plane that misses the mesh gives one empty half.
///
/// # Errors
/// Gaps, under [`Policy::Strict`] only.
pub fn cut<'a>(mesh: impl Into<Soup<'a>>, plane: &Plane, policy: Policy) -> Result<Cut, Refused> {
    let soup = mesh.into();
    // The middle of the mesh, moved onto the plane.
    let (origin, axes) = section_frame(soup, plane);
    let knife = Knife::Plane { plane: *plane, axes, origin };
    cut_with(soup, knife, policy, &Inner::None)
}

/// Relief on the caps of a plane cut.
pub struct Relief<'a> {
    /// Distance of the caps' inner corners, model units; a quarter of a particle's radius shows its shape.
    pub pitch: f32,
    /// More inner corners, in coordinates of the section: such as particles' edges, where heights
    /// jump ([`Discs::edges`](crate::section::grain::Discs::edges)).
    pub points: &'a [DVec2],
    /// What the section shows at a point of it for a half: its height is where the cap goes.
    pub shows: &'a dyn Fn(DVec3, Side) -> Hit,
}

/// Cuts a valid mesh by a plane and gives the caps true relief: halves that can be printed. The outline stays where it is,
/// and no height is greater than the distance to it. Torn halves fit into each other to the bit.
///
/// Each cap stays a height field: what overhangs is drawn straight.
///
/// # Errors
/// Gaps, under [`Policy::Strict`] only.
pub fn cut_with_relief<'a>(
    mesh: impl Into<Soup<'a>>,
    plane: &Plane,
    policy: Policy,
    relief: &Relief,
) -> Result<Cut, Refused> {
    let soup = mesh.into();
    let (origin, axes) = section_frame(soup, plane);
    let knife = Knife::Plane { plane: *plane, axes, origin };
    cut_with(soup, knife, policy, &Inner::Relief(relief))
}

/// The coordinates that [`cut`] and [`cut_with_relief`] will use: origin and axes of the section.
pub fn section_frame<'a>(mesh: impl Into<Soup<'a>>, plane: &Plane) -> (DVec3, [DVec3; 2]) {
    let (low, high) = bounds(&mesh.into());
    let middle = (low + high).as_dvec3() * 0.5;
    (middle - plane.normal * (plane.normal.dot(middle) - plane.offset), plane.axes())
}

/// What stands within a cap.
enum Inner<'a> {
    None,
    /// Corners at this distance.
    Grid(f64),
    Relief(&'a Relief<'a>),
}

/// Cuts a valid mesh along a curved surface. Triangles near the cut are first divided until no edge is longer than `edge`,
/// model units, so that both the outer surface and the caps follow the cut; the caps have inner corners at that distance. It
/// counts as between a thousandth of the mesh's largest extent (finer would take millions of triangles) and all of it.
///
/// # Errors
/// Gaps, under [`Policy::Strict`] only.
pub fn cut_along<'a>(mesh: impl Into<Soup<'a>>, sheet: &dyn Sheet, edge: f32, policy: Policy) -> Result<Cut, Refused> {
    let soup = mesh.into();
    let (low, high) = bounds(&soup);
    let size = (high - low).max_element();
    let edge = edge.max(size * 1e-3).min(size);
    let fine = refine::refine(soup, &|p| sheet.distance(p), edge);
    cut_with(Soup::from(&fine), Knife::Sheet(sheet), policy, &Inner::Grid(edge as f64))
}

/// Least and greatest coordinates; zero without a vertex.
fn bounds(soup: &Soup) -> (Vec3, Vec3) {
    let Some(&first) = soup.positions.first() else { return (Vec3::ZERO, Vec3::ZERO) };
    soup.positions.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)))
}

fn cut_with(soup: Soup, knife: Knife, policy: Policy, within: &Inner) -> Result<Cut, Refused> {
    let mut crossing = Crossing::of(soup, knife);
    let (segments, n_bridges, runs, gaps) = outline(&mut crossing, policy);
    if policy == Policy::Strict && !runs.open.is_empty() {
        return Err(Refused { gaps: gaps.into_iter().filter(|g| !g.bridged).collect() });
    }
    let at = |n: u32, nodes: &[crossing::Node]| nodes[n as usize].at;
    let contour = |run: &Vec<u32>| -> Vec<DVec2> {
        run.iter().map(|&i| at(segments[i as usize].from, &crossing.nodes)).collect()
    };
    let contours: Vec<Vec<DVec2>> = runs.closed.iter().map(contour).collect();
    let last = |run: &Vec<u32>| at(segments[run[run.len() - 1] as usize].to, &crossing.nodes);
    let with_end = |run: &Vec<u32>| contour(run).into_iter().chain([last(run)]).collect();
    let open_contours: Vec<Vec<DVec2>> = runs.open.iter().map(with_end).collect();
    let rim = Rim::of_outlines(&contours, &open_contours);
    let n_outer = crossing.nodes.len();
    crossing.part_touching_edges(&segments, &rim);
    match within {
        Inner::None => {}
        Inner::Grid(pitch) => add_inner(&mut crossing, &rim, *pitch, &[]),
        Inner::Relief(relief) => add_inner(&mut crossing, &rim, relief.pitch as f64, relief.points),
    }
    let inner = n_outer as u32..crossing.nodes.len() as u32;
    let mut fill = match policy {
        Policy::Winding if !runs.open.is_empty() => fill::fill_by_winding(&crossing.nodes, &segments, inner.clone()),
        _ => fill::fill(&mut crossing.nodes, &segments, &runs.closed, inner.clone()),
    };
    if fill.n_lost == segments.len() {
        // What is open crosses something: what is closed can still be filled.
        fill = fill::fill(&mut crossing.nodes, &segments, &runs.closed, inner.clone());
    }
    // Bridges belong to no triangle.
    fill.inner.retain(|&i, _| (i as usize) < segments.len() - n_bridges);
    let put_in = put_in(&crossing, &segments, &fill);
    let lift = |node: u32, side: Side| {
        let (Inner::Relief(relief), Knife::Plane { plane, .. }) = (within, knife) else { return None };
        let place = inner.contains(&node).then(|| crossing.nodes[node as usize])?;
        let outward = if side == Side::Below { plane.normal } else { -plane.normal };
        let p = knife.point(place.at);
        let hit = (relief.shows)(p, side);
        let most = rim.distance(place.at);
        let height = (hit.height as f64).clamp(-most, most);
        Some([(p + outward * height).as_vec3(), hit.normal])
    };
    let pieces = Pieces { fill: &fill, inner: &put_in, lift: &lift };
    let (plane, origin, axes) = match knife {
        Knife::Plane { plane, axes, origin } => (Some(plane), origin, axes),
        Knife::Sheet(_) => (None, DVec3::ZERO, [DVec3::ZERO; 2]),
    };
    let triangles = fill.triangles.iter().map(|t| t.map(|n| at(n, &crossing.nodes))).collect();
    Ok(Cut {
        below: assemble::half(&crossing, &pieces, Side::Below),
        above: assemble::half(&crossing, &pieces, Side::Above),
        section: Section { plane, origin, axes, contours, open_contours, triangles },
        gaps,
        overlaps: fill.overlaps,
        n_lost: fill.n_lost,
    })
}

/// For each triangle, the segments of its own that got nodes. A segment along an edge in the plane belongs to all triangles
/// there.
fn put_in(crossing: &Crossing, segments: &[Segment], fill: &fill::Fill) -> crossing::Map<u32, Vec<PutIn>> {
    let mut put_in: crossing::Map<u32, Vec<PutIn>> = crossing::Map::default();
    if fill.inner.is_empty() {
        return put_in;
    }
    let mut in_plane: crossing::Map<[[u32; 3]; 2], u32> = crossing::Map::default();
    // In the order of segments, not of the map.
    let mut with_nodes: Vec<u32> = fill.inner.keys().copied().collect();
    with_nodes.sort_unstable();
    for s in with_nodes {
        let Segment { from, to, triangle } = segments[s as usize];
        let ends = [from, to].map(|n| crossing.nodes[n as usize].position);
        put_in.entry(triangle).or_default().push(PutIn { ends, nodes: fill.inner[&s].clone() });
        in_plane.insert(ends.map(crossing::bits), s);
    }
    for (t, corners) in crossing.soup.triangles.iter().enumerate() {
        for k in 0..3 {
            let edge = [corners[k], corners[(k + 1) % 3]];
            if edge.iter().any(|&v| crossing.distances[v as usize] != 0.0) {
                continue;
            }
            let ends = edge.map(|v| crossing::bits(crossing.soup.positions[v as usize]));
            for ends in [ends, [ends[1], ends[0]]] {
                if let Some(&s) = in_plane.get(&ends)
                    && segments[s as usize].triangle != t as u32
                {
                    let Segment { from, to, .. } = segments[s as usize];
                    let ends = [from, to].map(|n| crossing.nodes[n as usize].position);
                    put_in.entry(t as u32).or_default().push(PutIn { ends, nodes: fill.inner[&s].clone() });
                }
            }
        }
    }
    put_in
}

/// Nodes within the cap: a grid of this pitch, not nearer to the outline than half of it, and these points.
fn add_inner(crossing: &mut Crossing, rim: &Rim, pitch: f64, points: &[DVec2]) {
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    crossing.nodes.iter().for_each(|n| (min, max) = (min.min(n.at), max.max(n.at)));
    let size = (max - min) / pitch;
    // More inner corners than this are a slip of the finger.
    const MOST: f64 = 4e6;
    if !size.is_finite() || size.x * size.y > MOST || size.min_element() < 0.0 {
        return;
    }
    let vertex = crossing.nodes.first().map_or(0, |n| n.vertex);
    let mut add = |at: DVec2, gap: f64| {
        if rim.distance(at) >= gap {
            let position = crossing.knife.point(at).as_vec3();
            crossing.nodes.push(crossing::Node { position, at, vertex });
        }
    };
    for &at in points.iter().filter(|p| p.is_finite()) {
        add(at, 0.1 * pitch);
    }
    for j in 0..=size.y as i64 {
        for i in 0..=size.x as i64 {
            // Rows shifted against each other: triangles nearly equal in all directions.
            let shift = if j & 1 == 0 { 0.25 } else { 0.75 };
            add(min + DVec2::new(i as f64 + shift, j as f64 + 0.5) * pitch, 0.5 * pitch);
        }
    }
}

/// All segments, the last of which are bridges over gaps, how many these are, and the runs they make.
///
/// Gaps that are not longer than rounding of the coordinates are always bridged.
fn outline(crossing: &mut Crossing, policy: Policy) -> (Vec<Segment>, usize, loops::Chains, Vec<Gap>) {
    let mut segments = crossing.segments();
    let runs = loops::chains(&crossing.nodes, &segments);
    let found = loops::gaps(&crossing.nodes, &segments, &runs.open);
    let rounding = 4.0 * crossing.rounding as f32;
    let longest = match policy {
        Policy::Bridge(longest) => longest.max(rounding),
        _ => rounding,
    };
    let n_own = segments.len();
    let mut gaps = Vec::new();
    for (gap, [from, to]) in found {
        let bridged = gap.length <= longest;
        if bridged {
            segments.push(Segment { from, to, triangle: u32::MAX });
        }
        gaps.push(Gap { bridged, ..gap });
    }
    let n_bridges = segments.len() - n_own;
    let runs = if n_bridges > 0 { loops::chains(&crossing.nodes, &segments) } else { runs };
    (segments, n_bridges, runs, gaps)
}

/// Cuts a mesh by several planes in order: every piece by each plane. Pieces that a plane misses stay whole; empty ones
/// are left out. With each piece, for each plane, the side it is on.
///
/// # Errors
/// Gaps, under [`Policy::Strict`] only.
pub fn cut_in_order<'a>(
    mesh: impl Into<Soup<'a>>,
    planes: &[Plane],
    policy: Policy,
) -> Result<Vec<(RawMesh, Vec<Side>)>, Refused> {
    let Some((first, rest)) = planes.split_first() else { return Ok(Vec::new()) };
    let Cut { below, above, .. } = cut(mesh, first, policy)?;
    let mut pieces = vec![(below.raw, vec![Side::Below]), (above.raw, vec![Side::Above])];
    pieces.retain(|(raw, _)| !raw.triangles.is_empty());
    for plane in rest {
        let mut finer = Vec::new();
        for (raw, sides) in pieces {
            let Cut { below, above, .. } = cut(&raw, plane, policy)?;
            for (half, side) in [(below, Side::Below), (above, Side::Above)] {
                if !half.raw.triangles.is_empty() {
                    finer.push((half.raw, sides.iter().copied().chain([side]).collect()));
                }
            }
        }
        pieces = finer;
    }
    Ok(pieces)
}
