//! Halves side by side, like the pages of a book: their sections look at the reader, a little towards each other.

use crate::assets::{Field, RawMesh, Scene, UvSet, Values};
use crate::math::{DVec3, Vec3, exact, vec3};
use crate::recipe::cut::Halves;

/// How far a page is turned towards the other, degrees.
const TURN: f64 = 20.0;

/// Between the halves, as a part of the wider one's width.
const GAP: f32 = 0.08;

/// The halves that are `shown`: the one below on the left, the one above on the right. Sections stand upright, with as much of
/// the model's own +Y upward as they can.
pub(super) fn laid_open(halves: Halves, shown: [bool; 2]) -> Scene {
    let n = halves.plane.normal;
    let upward = if n.y.abs() < 0.95 { DVec3::Y } else { -DVec3::Z };
    let up = (upward - n * upward.dot(n)).normalize();
    let [below, above] = halves.scenes;
    let pages: Vec<(Scene, DVec3, f64)> = [(below, n, TURN), (above, -n, -TURN)]
        .into_iter()
        .zip(shown)
        .filter(|((scene, ..), is_shown)| *is_shown && !scene.mesh.triangles().is_empty())
        .map(|(page, _)| page)
        .collect();
    let is_pair = pages.len() == 2;
    let turned: Vec<(Scene, Vec3)> = pages
        .into_iter()
        .map(|(scene, out, turn)| {
            let (s, c) = (exact::sin(turn.to_radians()), exact::cos(turn.to_radians()));
            let right = up.cross(out);
            // Rows: where the page's right, up and outward go, then a turn about the vertical.
            let rows = [right * c + out * s, up, out * c - right * s];
            let direction = |v: Vec3| {
                let v = v.as_dvec3();
                DVec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v)).as_vec3()
            };
            (page(scene, halves.origin, direction), vec3(turn.signum() as f32, 0.0, 0.0))
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
    placed.reduce(beside).unwrap_or_else(|| Scene::of("", Default::default()))
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

/// Two halves of one scene as one.
fn beside(a: Scene, b: Scene) -> Scene {
    let Scene { mesh, materials, .. } = b;
    let (mut all, b) = (a.mesh.into_raw(), mesh.into_raw());
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
        part
    }));
    all.source_points.extend(b.source_points);
    all.source_faces.extend(b.source_faces);
    let mesh = RawMesh { uv_sets, fields, ..all }.trusted();
    // Both have the same materials, but for a half without a cap.
    let materials = if materials.len() > a.materials.len() { materials } else { a.materials };
    Scene { mesh, materials, ..a }
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
