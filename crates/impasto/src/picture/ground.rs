//! A soft contact shadow on an endless floor, as a dark layer behind the object.
//!
//! The floor is lit by an even sky; the object takes from each point of it what its underside covers of that sky: the
//! form factors of the underside's patches (Goral et al., "Modeling the Interaction of Light Between Diffuse Surfaces",
//! 1984, with patches as discs, so that contact stays finite). The underside is seen by an information buffer that looks
//! up from below; light that comes in between two parts one above the other is not counted.

use crate::assets::Mesh;
use crate::color::LinearRgba;
use crate::math::{Bounds, Mat3, Mat4, Projection, Size, Vec3, Vec4, vec3};
use crate::par::Workers;
use crate::visibility::{Camera, Domain, Draw, Faces, Hit, InfoBuffer, Kind, Samples};

/// Patches along the longer side of the object's underside.
const N_PATCHES: u32 = 72;
/// Points of the shadow map along a side.
const N_POINTS: usize = 144;
/// How far the shadow map reaches beyond the object, in the object's longest side.
const REACH: f32 = 1.2;
/// Darkness where the whole sky is covered: floors are never quite black.
const DEPTH: f32 = 0.82;

/// The floor under an object, and how much of the sky the object covers there.
pub struct Ground {
    /// Height of the floor.
    floor: f32,
    /// Smallest x and z of the map, and its side.
    origin: [f32; 2],
    side: f32,
    /// 0 open to 1 covered, rows along z.
    covered: Vec<f32>,
}

impl Ground {
    /// The floor that touches the lowest point of a mesh.
    pub fn under(mesh: &Mesh, workers: &Workers) -> Self {
        let bounds = mesh.bounds();
        let (center, extent) = (bounds.center(), bounds.extent());
        let longest = extent.max_element().max(f32::MIN_POSITIVE);
        let side = (extent.x.max(extent.z) + 2.0 * REACH * longest).max(f32::MIN_POSITIVE);
        let origin = [center.x - 0.5 * side, center.z - 0.5 * side];
        let (patches, area) = underside(mesh, bounds, workers);
        let step = side / N_POINTS as f32;
        let rows = workers.map(N_POINTS, |row| {
            let z = origin[1] + (row as f32 + 0.5) * step;
            let at = |column: usize| {
                let x = origin[0] + (column as f32 + 0.5) * step;
                let sum: f32 = patches.iter().map(|p| form_factor(p.x - x, p.y, p.z - z, area)).sum();
                let edge = |t: usize| (t as f32 + 0.5).min(N_POINTS as f32 - t as f32 - 0.5) / (0.25 * N_POINTS as f32);
                // Fades out before the map ends.
                sum.min(1.0) * smooth(edge(row)) * smooth(edge(column))
            };
            (0..N_POINTS).map(at).collect::<Vec<f32>>()
        });
        Self { floor: bounds.min.y, origin, side, covered: rows.concat() }
    }

    /// Lays the shadow behind a run of cells, given from their first column and row: premultiplied black.
    pub fn darken(&self, lens: &Lens, [column, row]: [u32; 2], cells: &mut [LinearRgba]) {
        for (i, cell) in cells.iter_mut().enumerate() {
            if cell[3] < 1.0
                && let Some([x, z]) = lens.floor_point(column as f32 + i as f32 + 0.5, row as f32 + 0.5)
            {
                cell[3] += (1.0 - cell[3]) * DEPTH * self.at(x, z);
            }
        }
    }

    /// Which points of the floor a view's cells see; none from below.
    pub fn lens(&self, domain: &Domain) -> Option<Lens> {
        let m = domain.cells_from_world()?;
        let above = match domain.view.parallel {
            Some(toward_eye) => toward_eye.y > 1e-3,
            None => domain.view.eye.y > self.floor,
        };
        above.then(|| Lens::new(&m, self.floor)).flatten()
    }

    /// How much of the sky is covered at a point of the floor.
    fn at(&self, x: f32, z: f32) -> f32 {
        let place = |v: f32, k: usize| (v - self.origin[k]) / self.side * N_POINTS as f32 - 0.5;
        let (u, v) = (place(x, 0), place(z, 1));
        let last = (N_POINTS - 1) as f32;
        if !(u >= 0.0 && v >= 0.0 && u < last && v < last) {
            return 0.0;
        }
        let (i, j) = (u as usize, v as usize);
        let (s, t) = (u - i as f32, v - j as f32);
        let c = |i: usize, j: usize| self.covered[j * N_POINTS + i];
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        mix(mix(c(i, j), c(i + 1, j), s), mix(c(i, j + 1), c(i + 1, j + 1), s), t)
    }
}

/// From a view's cells to points of the floor: the inverse of the floor's homography.
pub struct Lens {
    floor_from_cell: Mat3,
    /// Row of the homography that gives w.
    w: Vec3,
}

impl Lens {
    fn new(cells_from_world: &Mat4, floor: f32) -> Option<Self> {
        let m = cells_from_world;
        // Columns for x, z and 1; rows for x, y and w of a cell.
        let column = |c: Vec4| vec3(c.x, c.y, c.w);
        let homography = Mat3::from_cols(column(m.x_axis), column(m.z_axis), column(m.y_axis * floor + m.w_axis));
        let d = homography.as_dmat3();
        let is_regular = d.determinant().abs() > 1e-30;
        let row = homography.transpose().z_axis;
        is_regular.then(|| Self { floor_from_cell: d.inverse().as_mat3(), w: row })
    }

    fn floor_point(&self, x: f32, y: f32) -> Option<[f32; 2]> {
        let p = self.floor_from_cell * vec3(x, y, 1.0);
        let (px, pz) = (p.x / p.z, p.y / p.z);
        // Behind the eye, and beyond the horizon, there is no floor.
        (self.w.dot(vec3(px, pz, 1.0)) > 0.0).then_some([px, pz])
    }
}

/// Patches of what is seen from below: position with the height above the floor in y; and a patch's area.
fn underside(mesh: &Mesh, bounds: Bounds, workers: &Workers) -> (Vec<Vec3>, f32) {
    let extent = bounds.extent();
    let cell = (extent.x.max(extent.z) / N_PATCHES as f32).max(f32::MIN_POSITIVE);
    let count = |length: f32| ((length / cell).ceil() as u32).clamp(1, N_PATCHES + 1);
    let size = Size::new(count(extent.x), count(extent.z));
    // Looks up: +X to the right, +Z up in the picture.
    let eye = bounds.center() - Vec3::Y * (extent.y + cell);
    let world_from_camera =
        Mat4::from_cols(Vec3::X.extend(0.0), Vec3::Z.extend(0.0), (-Vec3::Y).extend(0.0), eye.extend(1.0));
    let height = size.height as f32 * cell;
    let camera = Camera { world_from_camera, projection: Projection::Orthographic { height }, near: 0.0 };
    let domain = Domain::through_camera(mesh, &camera, size);
    let all = Draw { triangles: 0..mesh.triangles().len() as u32, faces: Faces::Both, kind: Kind::Solid };
    let buffer = InfoBuffer::build(&domain, &[all], Samples::One, None, workers);
    let mut patches = Vec::new();
    for row in 0..size.height {
        for column in 0..size.width {
            let (id, depth) = buffer.at(column, row);
            if id != Hit::NOTHING {
                let x = bounds.center().x + (column as f32 + 0.5 - 0.5 * size.width as f32) * cell;
                let z = bounds.center().z - (row as f32 + 0.5 - 0.5 * size.height as f32) * cell;
                // Depth runs from 1 at the top of the bounds to 2 at their bottom.
                patches.push(vec3(x, (2.0 - depth) * extent.y, z));
            }
        }
    }
    (patches, cell * cell)
}

/// What a horizontal disc of an area covers of the sky over a point, from their offset.
fn form_factor(dx: f32, height: f32, dz: f32, area: f32) -> f32 {
    let h2 = height * height;
    let d2 = dx * dx + dz * dz + h2;
    if d2 > 0.0 { area * (h2 / d2) / (std::f32::consts::PI * d2 + area) } else { 1.0 }
}

/// 0 to 1 without a kink.
fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::RawMesh;

    /// A square sheet of side 2 at a height over the floor, which a tiny triangle touches far below.
    fn sheet(height: f32) -> Mesh {
        let mut positions: Vec<Vec3> =
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| vec3(x, height, z)).to_vec();
        positions.extend([vec3(0.9, 0.0, 0.9), vec3(0.9, 1e-3, 0.9), vec3(0.901, 0.0, 0.9)]);
        let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]];
        let normals = vec![Vec3::Y; positions.len()];
        RawMesh { positions, triangles, normals, ..Default::default() }.trusted()
    }

    #[test]
    fn a_sheet_covers_the_sky_as_its_form_factor_says() {
        for height in [0.25, 0.5, 1.0] {
            let ground = Ground::under(&sheet(height), &Workers::new(1));
            // From a point under the middle: four corners of a rectangle (Howell, A Catalog of Radiation Configuration
            // Factors, B-3), in units of the height.
            let a = 1.0 / height as f64;
            let r = (1.0 + a * a).sqrt();
            let corner = (a / r * crate::math::exact::atan(a / r)) / std::f64::consts::PI;
            let truth = (4.0 * corner) as f32;
            let got = ground.at(0.0, 0.0);
            assert!((got - truth).abs() < 0.02, "height {height}: {got} not {truth}");
            assert!(ground.at(3.0, 3.0) < 0.05 && ground.at(100.0, 0.0) == 0.0);
        }
    }

    #[test]
    fn cells_see_the_floor_points_that_project_to_them() {
        let mesh = sheet(0.5);
        let ground = Ground::under(&mesh, &Workers::new(1));
        let size = Size::new(100, 80);
        for projection in [Projection::Perspective { fov_y: 0.7 }, Projection::Orthographic { height: 5.0 }] {
            let camera = Camera::looking(vec3(1.0, 3.0, 4.0), vec3(0.1, 0.2, 0.0), Vec3::Y, projection, 0.1);
            let domain = Domain::through_camera(&mesh, &camera, size);
            let lens = ground.lens(&domain).expect("a floor from above");
            let cell = domain.cells_from_world().unwrap() * vec3(0.3, 0.0, -0.4).extend(1.0);
            let [x, z] = lens.floor_point(cell.x / cell.w, cell.y / cell.w).unwrap();
            assert!((x - 0.3).abs() < 1e-3 && (z + 0.4).abs() < 1e-3, "{x} {z}");
            let below = Camera::looking(vec3(1.0, -3.0, 4.0), Vec3::ZERO, Vec3::Y, projection, 0.1);
            assert!(ground.lens(&Domain::through_camera(&mesh, &below, size)).is_none());
        }
    }
}
