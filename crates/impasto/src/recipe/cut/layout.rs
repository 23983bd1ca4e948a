//! Pieces laid out to be seen: side by side like the pages of a book, or apart where they were.

use super::Pieces;
use crate::assets::{Field, RawMesh, Scene, UvSet, Values};
use crate::error::Result;
use crate::math::{Bounds, DVec3, Vec3, exact, vec3};
use crate::recipe::CutRecipe;
use crate::recipe::words::{choose_or, impossible};
use crate::section::grain::Side;

/// How pieces are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Way {
    /// Side by side; their sections look at the reader.
    Open,
    /// The same, one above the other.
    Upright,
    /// Drawn apart, by this share of the whole's size.
    Apart(f32),
}

/// How far a page is turned towards the other, degrees.
const TURN: f64 = 8.0;

/// Between pages and rows of pages, as a part of the wider one's size.
const GAP: f32 = 0.08;

/// How far pieces are drawn apart, unless a recipe says otherwise.
const APART: f32 = 0.35;

impl Way {
    /// As a recipe has it; of more than two pieces only `apart` shows each.
    pub(super) fn of(recipe: &CutRecipe) -> Result<Self> {
        let apart = recipe.apart.unwrap_or(APART);
        if !(0.0..=10.0).contains(&apart) {
            return Err(impossible("apart", apart, "a share of the model's size, 0 to 10"));
        }
        let usual = if recipe.is_laid_open() { Self::Open } else { Self::Apart(apart) };
        let way = choose_or("layout", &recipe.layout, &[("open", Self::Open), ("apart", Self::Apart(apart))], usual)?;
        // Beside those of other kinds, halves stand one above the other.
        Ok(if way == Self::Open && recipe.shows_each_kind() { Self::Upright } else { way })
    }
}

impl CutRecipe {
    /// Whether the sections look at the reader; else the pieces stand where they were.
    pub(in crate::recipe) fn is_laid_open(&self) -> bool {
        match &self.layout {
            Some(layout) => layout == "open",
            None => self.apart.is_none() && self.then.is_empty(),
        }
    }

    /// Whether all kinds of sections are shown beside each other.
    pub(in crate::recipe) fn shows_each_kind(&self) -> bool {
        self.kind.as_deref() == Some("each")
    }

    /// The normal of the first cut.
    pub(in crate::recipe) fn direction(&self) -> [f32; 3] {
        self.normal.unwrap_or([1.0, 0.0, 0.0])
    }
}

/// The pieces that are `shown` (below the first cut, above it) as one scene.
pub(super) fn laid_out(pieces: Pieces, shown: [bool; 2], way: Way) -> Scene {
    match way {
        Way::Open => laid_open(pieces, shown, false),
        Way::Upright => laid_open(pieces, shown, true),
        Way::Apart(gap) => apart(pieces, shown, gap),
    }
}

/// Whether pieces on a side of the first cut are shown.
fn is_shown(sides: &[Side], shown: [bool; 2]) -> bool {
    shown[(sides.first() == Some(&Side::Above)) as usize]
}

/// Each piece where it was, moved away from the others; if all that is shown lies on one side, it stays.
fn apart(cut: Pieces, shown: [bool; 2], gap: f32) -> Scene {
    let middle = cut.middle;
    let directions: Vec<DVec3> = cut.blades.iter().map(|b| b.direction(middle)).collect();
    let corners = cut.pieces.iter().flat_map(|p| p.scene.mesh.bounds().corners());
    let way = Bounds::of(corners).extent().max_element() * 0.5 * gap;
    let both = shown == [true, true];
    let moved = cut.pieces.into_iter().filter(|p| is_shown(&p.sides, shown)).map(|piece| {
        let away = directions.iter().zip(&piece.sides).enumerate().map(|(k, (n, side))| match side {
            _ if k == 0 && !both => DVec3::ZERO,
            Side::Below => -*n,
            Side::Above => *n,
        });
        let shift = away.sum::<DVec3>().as_vec3() * way;
        moved(piece.scene, |p| p + shift)
    });
    let n_shared = cut.n_shared;
    moved.reduce(|a, b| beside(a, b, n_shared)).unwrap_or_else(|| Scene::of("", Default::default()))
}

/// Halves side by side: the one below on the left, the one above on the right; or, in a column, the one below on top.
/// Sections stand upright, with as much of the model's own +Y upward as they can.
fn laid_open(cut: Pieces, shown: [bool; 2], is_column: bool) -> Scene {
    let origin = cut.middle;
    let n = cut.blades[0].direction(origin);
    let upward = if n.y.abs() < 0.95 { DVec3::Y } else { -DVec3::Z };
    let up = (upward - n * upward.dot(n)).normalize();
    let n_shared = cut.n_shared;
    let pages: Vec<(Scene, bool)> = cut
        .pieces
        .into_iter()
        .filter(|p| is_shown(&p.sides, shown))
        .map(|p| (p.scene, p.sides[0] == Side::Below))
        .collect();
    let is_pair = pages.len() == 2 && !is_column;
    let turned: Vec<(Scene, Vec3)> = pages
        .into_iter()
        .map(|(scene, is_below)| {
            let (out, turn) = if is_below { (n, TURN) } else { (-n, -TURN) };
            let turn = if is_column { 0.0 } else { turn };
            let (s, c) = (exact::sin(turn.to_radians()), exact::cos(turn.to_radians()));
            let right = up.cross(out);
            // Rows: where the page's right, up and outward go, then a turn about the vertical.
            let rows = [right * c + out * s, up, out * c - right * s];
            let direction = |v: Vec3| {
                let v = v.as_dvec3();
                DVec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v)).as_vec3()
            };
            (page(scene, origin, direction), vec3(turn.signum() as f32, 0.0, 0.0))
        })
        .collect();
    let width = turned.iter().map(|(s, _)| s.mesh.bounds().extent().x).fold(0.0, f32::max);
    let placed = turned.into_iter().map(|(scene, side)| {
        if !is_pair {
            return scene;
        }
        let bounds = scene.mesh.bounds();
        let inner = if side.x > 0.0 { -bounds.max.x } else { -bounds.min.x };
        let shift = vec3(inner, 0.0, 0.0) - side * (0.5 * GAP * width);
        moved(scene, |p| p + shift)
    });
    match is_column {
        true => in_line(placed.collect(), vec3(0.0, -1.0, 0.0), n_shared),
        false => placed.reduce(|a, b| beside(a, b, n_shared)).unwrap_or_else(|| Scene::of("", Default::default())),
    }
}

/// Columns of pages as one scene, from the left.
pub(super) fn beside_each_other(columns: Vec<Scene>) -> Scene {
    // What they share is not worth the search.
    in_line(columns, vec3(1.0, 0.0, 0.0), [0, 0])
}

/// Scenes one after the other along a direction of the picture, their boxes in line.
fn in_line(scenes: Vec<Scene>, way: Vec3, n_shared: [usize; 2]) -> Scene {
    let mut end = 0.0;
    let placed = scenes.into_iter().map(|scene| {
        let bounds = scene.mesh.bounds();
        let across = Vec3::ONE - way.abs();
        let start = if way.x + way.y > 0.0 { bounds.min } else { bounds.max };
        let shift = way * end - start * way.abs() - bounds.center() * across * vec3(1.0, 1.0, 0.0);
        end += (bounds.extent() * way.abs()).element_sum() * (1.0 + GAP);
        moved(scene, |p| p + shift)
    });
    placed.reduce(|a, b| beside(a, b, n_shared)).unwrap_or_else(|| Scene::of("", Default::default()))
}

/// A half turned about a point; what the file says of cameras and lights holds no more.
fn page(scene: Scene, origin: DVec3, direction: impl Fn(Vec3) -> Vec3) -> Scene {
    let mut scene = moved(scene, |p| direction((p.as_dvec3() - origin).as_vec3()));
    let mut raw = scene.mesh.into_raw();
    raw.normals.iter_mut().for_each(|n| *n = direction(*n));
    raw.tangents.iter_mut().for_each(|t| *t = direction(t.truncate()).extend(t.w));
    scene.cameras.clear();
    scene.lights.clear();
    Scene { mesh: raw.trusted(), ..scene }
}

fn moved(mut scene: Scene, to: impl Fn(Vec3) -> Vec3) -> Scene {
    let mut raw = std::mem::take(&mut scene.mesh).into_raw();
    raw.positions.iter_mut().for_each(|p| *p = to(*p));
    Scene { mesh: raw.trusted(), ..scene }
}

/// Two pieces of one scene as one; their first materials and images are the same ones, as many as `n_shared` says.
fn beside(a: Scene, b: Scene, [n_materials, n_images]: [usize; 2]) -> Scene {
    let (mut materials, mut images) = (a.materials, a.images);
    let more = [materials.len() - n_materials, images.len() - n_images].map(|n| n as u32);
    let later = |i: u32, n: usize, by: u32| if (i as usize) < n { i } else { i + by };
    materials.extend(b.materials.into_iter().skip(n_materials).map(|mut material| {
        let slots = material.texture_slots_mut().into_iter().flatten();
        slots.for_each(|t| t.image = later(t.image, n_images, more[1]));
        material
    }));
    images.extend(b.images.into_iter().skip(n_images));
    let (mut all, b) = (a.mesh.into_raw(), b.mesh.into_raw());
    let (n_vertices, n_triangles) = (all.positions.len() as u32, all.triangles.len() as u32);
    all.positions.extend(b.positions);
    all.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + n_vertices)));
    all.normals.extend(b.normals);
    all.tangents.extend(b.tangents);
    all.colors.extend(b.colors);
    let sets = all.uv_sets.into_iter().zip(b.uv_sets);
    let uv_sets = sets.map(|(a, b)| UvSet { uv: [a.uv, b.uv].concat(), name: a.name }).collect();
    let fields = all.fields.into_iter().zip(b.fields).map(|(a, b)| joined(a, b)).collect();
    all.parts.extend(b.parts.into_iter().map(|mut part| {
        part.triangles = part.triangles.start + n_triangles..part.triangles.end + n_triangles;
        part.material = part.material.map(|m| later(m, n_materials, more[0]));
        part
    }));
    all.source_points.extend(b.source_points);
    all.source_faces.extend(b.source_faces);
    let mesh = RawMesh { uv_sets, fields, ..all }.trusted();
    Scene { mesh, materials, images, ..a }
}

fn joined(a: Field, b: Field) -> Field {
    let values = match (a.values, b.values) {
        (Values::F32(a), Values::F32(b)) => Values::F32([a, b].concat()),
        (Values::F64(a), Values::F64(b)) => Values::F64([a, b].concat()),
        (Values::F32(a), Values::F64(b)) => Values::F64(a.into_iter().map(f64::from).chain(b).collect()),
        (Values::F64(a), Values::F32(b)) => Values::F64(a.into_iter().chain(b.into_iter().map(f64::from)).collect()),
    };
    Field { values, ..a }
}
