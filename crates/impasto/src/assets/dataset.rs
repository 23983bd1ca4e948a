//! What VTK's files hold, in either of their forms: points or a lattice, cells, arrays for both.

use crate::assets::cells::{self, Cells, Surface};
use crate::assets::files::{self, Loose};
use crate::assets::join::Column;
use crate::assets::mend::MendOptions;
use crate::assets::numbers::Kind;
use crate::assets::polygon::Triangulator;
use crate::assets::text::format_error;
use crate::assets::{Element, Field, RawMesh, UvSet, Values, ply};
use crate::error::{Mended, Result, note};
use crate::math::{DVec3, Vec2, Vec3, Vec4, dvec3, vec2, vec4};
use std::path::Path;

/// Points, cells and arrays.
#[derive(Debug, Default)]
pub(super) struct Dataset {
    pub(super) form: Form,
    pub(super) point_arrays: Vec<Array>,
    pub(super) cell_arrays: Vec<Array>,
}

/// Where the points are, and what joins them.
#[derive(Debug)]
pub(super) enum Form {
    /// Cells between any points. `keeps_points`: those without a cell belong to the surface, too.
    Cells { points: Vec<Vec3>, cells: Cells, keeps_points: bool },
    /// Boxes between neighbours; the first count runs fastest.
    Lattice { n: [u32; 3], places: Places },
}

impl Default for Form {
    fn default() -> Self {
        Self::Cells { points: Vec::new(), cells: Cells::default(), keeps_points: true }
    }
}

/// Where a lattice's points are.
#[derive(Debug)]
pub(super) enum Places {
    /// One by one.
    Each(Vec<Vec3>),
    /// Along three axes.
    Axes([Vec<f64>; 3]),
    /// In equal steps.
    Even { origin: DVec3, steps: [DVec3; 3] },
}

/// Numbers with a name, and what they are for.
#[derive(Debug)]
pub(super) struct Array {
    pub(super) column: Column,
    pub(super) role: Role,
}

/// What an array is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Data,
    Normals,
    TextureCoordinates,
    Tangents,
    /// Display values; bytes, or 0..1.
    Colors {
        is_bytes: bool,
    },
}

impl Role {
    /// The role of an array of points that nothing but its name and form tell.
    pub(super) fn of(name: &str, kind: Kind, n_components: usize) -> Self {
        let name: String = name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
        let is_uv = name.strip_prefix("uv").is_some_and(|n| n.is_empty() || n.parse::<u8>().is_ok());
        match (name.as_str(), n_components) {
            ("normals", 3) if kind.is_float() => Self::Normals,
            ("tangents", 4) if kind.is_float() => Self::Tangents,
            ("texturecoordinates" | "tcoords" | "texcoords", 2) => Self::TextureCoordinates,
            (_, 2) if is_uv && kind.is_float() => Self::TextureCoordinates,
            ("rgb" | "rgba" | "color" | "colors" | "colour" | "colours", 3 | 4) if kind == Kind::U8 => {
                Self::Colors { is_bytes: true }
            }
            ("rgba", 4) if kind.is_float() => Self::Colors { is_bytes: false },
            _ => Self::Data,
        }
    }
}

impl Dataset {
    /// How many points there are.
    pub(super) fn n_points(&self) -> u64 {
        match &self.form {
            Form::Cells { points, .. } => points.len() as u64,
            Form::Lattice { n, .. } => n.iter().fold(1, |product: u64, n| product.saturating_mul(*n as u64)),
        }
    }

    /// How many cells there are.
    pub(super) fn n_cells(&self) -> u64 {
        match &self.form {
            Form::Cells { cells, .. } => cells.len() as u64,
            Form::Lattice { n, .. } => {
                n.iter().fold(1, |product: u64, n| product.saturating_mul(n.saturating_sub(1).max(1) as u64))
            }
        }
    }

    /// Takes in another piece; false if either is a lattice. Arrays that one of them lacks are missing there.
    pub(super) fn append(&mut self, other: Self) -> bool {
        let counts = [(self.n_points(), other.n_points()), (self.n_cells(), other.n_cells())];
        let (Form::Cells { points, cells, .. }, Form::Cells { points: more, cells: more_cells, .. }) =
            (&mut self.form, other.form)
        else {
            return false;
        };
        cells.append(&more_cells, points.len());
        points.extend(more);
        append_arrays(&mut self.point_arrays, other.point_arrays, counts[0]);
        append_arrays(&mut self.cell_arrays, other.cell_arrays, counts[1]);
        true
    }

    /// All arrays, those of points first.
    pub(super) fn into_columns(self) -> Vec<Column> {
        self.point_arrays.into_iter().chain(self.cell_arrays).map(|a| a.column).collect()
    }

    /// The surface with its data, before mending. `n_bytes` is the file's length: a lattice may have no more points outside.
    pub(super) fn into_loose(mut self, path: &Path, n_bytes: usize, mut mended: Vec<Mended>) -> Result<Loose> {
        let (n_points, n_cells) = (self.n_points(), self.n_cells());
        if n_points >= u32::MAX as u64 || n_cells >= u32::MAX as u64 {
            return Err(format_error(path, format!("{n_points} points and {n_cells} cells are too many")));
        }
        self.drop_ghosts(&mut mended);
        let mut mesh =
            RawMesh { n_source_points: n_points as usize, n_source_faces: n_cells as usize, ..Default::default() };
        match self.form {
            Form::Cells { points, cells, keeps_points } => {
                let at = |i: u32| points.get(i as usize).copied().unwrap_or(Vec3::NAN);
                let surface = cells::surface(&cells, at);
                tell(&surface, &mut mended);
                mesh.triangles = surface.triangles;
                mesh.source_faces = surface.source_faces;
                if mesh.triangles.is_empty() {
                    note(&mut mended, points.len(), "points without any face: there is no surface");
                } else if surface.has_inner_points || !keeps_points {
                    keep_used(&mut mesh, points.len());
                }
                mesh.positions = match mesh.source_points.is_empty() {
                    true => points,
                    false => mesh.source_points.iter().map(|i| points[*i as usize]).collect(),
                };
            }
            Form::Lattice { n, places } => {
                let most = n_bytes.max(1 << 20) as u64;
                let quads = sides(n, most).ok_or_else(|| {
                    let [x, y, z] = n;
                    format_error(path, format!("a lattice of {x} x {y} x {z} points is too large for this file"))
                })?;
                lattice(&mut mesh, n, &places, &quads);
                if mesh.triangles.is_empty() {
                    note(&mut mended, n_points as usize, "points without any face: there is no surface");
                }
            }
        }
        for array in self.point_arrays {
            give_points(&mut mesh, array, n_points as usize, &mut mended);
        }
        for array in self.cell_arrays {
            give_cells(&mut mesh, array, n_cells as usize, &mut mended);
        }
        Ok(Loose::new(files::name_of(path), mesh, mended, MendOptions::default()))
    }

    /// Cells that another piece has, too, or that are hidden, as the array `vtkGhostType` says.
    fn drop_ghosts(&mut self, mended: &mut Vec<Mended>) {
        const DUPLICATE_OR_HIDDEN: u32 = 1 | 32;
        let Form::Cells { cells, .. } = &mut self.form else { return };
        let Some(ghost) = self.cell_arrays.iter().find(|a| a.column.name == "vtkGhostType") else { return };
        let mut n = 0;
        for (i, x) in ghost.column.values.numbers().enumerate().take(cells.len()) {
            if x as u32 & DUPLICATE_OR_HIDDEN != 0 {
                cells.blank(i);
                n += 1;
            }
        }
        note(mended, n, "ghost cells left out");
    }
}

/// Arrays of one name follow each other; what is not there is NaN. `n`: elements before, and elements added.
fn append_arrays(arrays: &mut Vec<Array>, more: Vec<Array>, n: (u64, u64)) {
    let missing = |n: u64, n_components: usize| Values::F32(vec![f32::NAN; n as usize * n_components]);
    let mut fresh = Vec::new();
    let mut is_met = vec![false; arrays.len()];
    for mut array in more {
        let n_components = array.column.n_components;
        let same = |a: &Array| a.column.name == array.column.name && a.column.n_components == n_components;
        match arrays.iter().position(same) {
            Some(i) => {
                arrays[i].column.values.append(array.column.values);
                is_met[i] = true;
            }
            None => {
                let mut values = missing(n.0, n_components);
                values.append(array.column.values);
                array.column.values = values;
                fresh.push(array);
            }
        }
    }
    for (array, _) in arrays.iter_mut().zip(is_met).filter(|(_, is_met)| !is_met) {
        array.column.values.append(missing(n.1, array.column.n_components));
    }
    arrays.append(&mut fresh);
}

fn tell(surface: &Surface, mended: &mut Vec<Mended>) {
    note(mended, surface.n_thin, "cells that are points or lines passed over");
    note(mended, surface.n_short, "cells with fewer points than their kind has dropped");
    note(mended, surface.n_unknown, "cells of a kind that is not known passed over");
}

/// Drops the points that no triangle uses.
fn keep_used(mesh: &mut RawMesh, n_points: usize) {
    // Triangles of points that are not there are told of when the mesh is mended.
    let mut vertex = vec![u32::MAX; n_points];
    for &i in mesh.triangles.as_flattened() {
        if let Some(v) = vertex.get_mut(i as usize) {
            *v = 0;
        }
    }
    let mut n = 0;
    for (i, v) in vertex.iter_mut().enumerate().filter(|(_, v)| **v == 0) {
        *v = n;
        n += 1;
        mesh.source_points.push(i as u32);
    }
    for i in mesh.triangles.as_flattened_mut() {
        *i = vertex.get(*i as usize).copied().unwrap_or(u32::MAX);
    }
    if n as usize == n_points {
        mesh.source_points = Vec::new();
    }
}

/// Corners of the quads on a lattice's outside, each with its cell; none if there are more than `most`.
fn sides(n: [u32; 3], most: u64) -> Option<Vec<([u32; 4], u32)>> {
    let cells = n.map(|n| n.saturating_sub(1) as u64);
    let stride = [1, n[0] as u64, n[0] as u64 * n[1] as u64];
    let n_sides = |axis: usize| {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        // A lattice of one layer is a sheet; one side of it is enough.
        let both = if cells[axis] > 0 { 2 } else { 1 };
        let is_flat_elsewhere = cells[u] == 0 || cells[v] == 0;
        if is_flat_elsewhere { 0 } else { (cells[u]).saturating_mul(cells[v]).saturating_mul(both) }
    };
    if n.contains(&0) || (0..3).map(n_sides).fold(0, u64::saturating_add) > most {
        return None;
    }
    let cell_stride = [1, cells[0].max(1), cells[0].max(1) * cells[1].max(1)];
    let mut quads = Vec::new();
    for axis in 0..3 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let n_layers = (n_sides(axis) > 0) as u64 * if cells[axis] > 0 { 2 } else { 1 };
        for layer in 0..n_layers {
            // The far side is wound forward, the near one backward, a sheet forward.
            let is_far = layer == 1 || cells[axis] == 0;
            let (point_at, cell_at) = match layer {
                1 => (cells[axis] * stride[axis], (cells[axis] - 1) * cell_stride[axis]),
                _ => (0, 0),
            };
            for j in 0..cells[v] {
                for i in 0..cells[u] {
                    let corner = |di, dj| (point_at + (i + di) * stride[u] + (j + dj) * stride[v]) as u32;
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    let cell = (cell_at + i * cell_stride[u] + j * cell_stride[v]) as u32;
                    quads.push((if is_far { [a, b, c, d] } else { [a, d, c, b] }, cell));
                }
            }
        }
    }
    Some(quads)
}

/// The outside of a lattice as triangles.
fn lattice(mesh: &mut RawMesh, n: [u32; 3], places: &Places, quads: &[([u32; 4], u32)]) {
    let at = |i: u32| {
        let (x, y, z) = (i % n[0], i / n[0] % n[1], i / n[0] / n[1]);
        match places {
            Places::Each(points) => points.get(i as usize).copied().unwrap_or(Vec3::NAN),
            Places::Axes(axes) => {
                let along = |axis: usize, i: u32| axes[axis].get(i as usize).copied().unwrap_or(f64::NAN);
                dvec3(along(0, x), along(1, y), along(2, z)).as_vec3()
            }
            Places::Even { origin, steps } => {
                (*origin + steps[0] * x as f64 + steps[1] * y as f64 + steps[2] * z as f64).as_vec3()
            }
        }
    };
    let mut used: Vec<u32> = quads.iter().flat_map(|(corners, _)| *corners).collect();
    used.sort_unstable();
    used.dedup();
    mesh.positions = used.iter().map(|i| at(*i)).collect();
    let mut cut = Triangulator::default();
    for (corners, cell) in quads {
        let corners = corners.map(|i| used.partition_point(|u| *u < i) as u32);
        let place = |k: usize| mesh.positions[corners[k] as usize];
        cut.cut(4, place, |t| mesh.triangles.push(t.map(|k| corners[k as usize])));
        mesh.source_faces.resize(mesh.triangles.len(), *cell);
    }
    // Axes that turn left make the surface look inwards.
    let is_solid = n.iter().all(|n| *n > 1);
    if is_solid && volume(&mesh.positions, &mesh.triangles) < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh.source_points = used;
}

/// Six times the volume that triangles enclose.
fn volume(positions: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let origin = positions.first().copied().unwrap_or_default().as_dvec3();
    let place = |i: u32| positions[i as usize].as_dvec3() - origin;
    triangles.iter().map(|t| t.map(place)).map(|[a, b, c]| a.dot(b.cross(c))).filter(|v| v.is_finite()).sum()
}

/// An array of the file's points becomes what it is for.
fn give_points(mesh: &mut RawMesh, array: Array, n_points: usize, mended: &mut Vec<Mended>) {
    let Array { column, role } = array;
    let n = column.n_components;
    if n == 0 || column.values.len() != n * n_points {
        note(mended, 1, format!("array {:?} dropped: it has not one value for each of the points", column.name));
        return;
    }
    let values = match mesh.source_points.is_empty() {
        true => column.values,
        false => column.values.gathered(&mesh.source_points, n),
    };
    let x = |i: usize| values.at(i) as f32;
    match role {
        Role::Normals if n == 3 && mesh.normals.is_empty() => {
            mesh.normals =
                (0..mesh.positions.len()).map(|i| Vec3::from_array([0, 1, 2].map(|k| x(3 * i + k)))).collect();
        }
        Role::Tangents if n == 4 && mesh.tangents.is_empty() => {
            mesh.tangents =
                (0..mesh.positions.len()).map(|i| Vec4::from_array([0, 1, 2, 3].map(|k| x(4 * i + k)))).collect();
        }
        Role::TextureCoordinates if n == 2 => {
            // v counts upwards in the file.
            let uv: Vec<Vec2> =
                (0..mesh.positions.len()).map(|i| vec2(x(2 * i), (1.0 - values.at(2 * i + 1)) as f32)).collect();
            mesh.uv_sets.push(UvSet { name: column.name, uv });
        }
        Role::Colors { is_bytes } if (n == 3 || n == 4) && mesh.colors.is_empty() => {
            mesh.colors = (0..mesh.positions.len()).map(|i| light(&values, i, n, is_bytes)).collect();
        }
        _ => mesh.fields.push(Field {
            name: column.name,
            unit: column.unit,
            element: Element::Vertex,
            n_components: n,
            values,
        }),
    }
}

/// A display colour as linear light.
fn light(values: &Values, i: usize, n: usize, is_bytes: bool) -> Vec4 {
    let scale = if is_bytes { 255.0 } else { 1.0 };
    let c = |k: usize| match is_bytes {
        true => ply::linear(values.at(i * n + k) as f32, scale),
        false => crate::color::linear_from_srgb(values.at(i * n + k)) as f32,
    };
    vec4(c(0), c(1), c(2), if n == 4 { values.at(i * n + 3) as f32 / scale } else { 1.0 })
}

/// An array of the file's cells becomes a field of faces.
fn give_cells(mesh: &mut RawMesh, array: Array, n_cells: usize, mended: &mut Vec<Mended>) {
    let Array { column, .. } = array;
    let n = column.n_components;
    if n == 0 || column.values.len() != n * n_cells {
        note(mended, 1, format!("array {:?} dropped: it has not one value for each of the cells", column.name));
        return;
    }
    let values = column.values.gathered(&mesh.source_faces, n);
    // Points and cells may have arrays of one name; fields are asked for by name.
    let is_taken = mesh.fields.iter().any(|f| f.name == column.name);
    let name = if is_taken { format!("{} (cells)", column.name) } else { column.name };
    mesh.fields.push(Field { name, unit: column.unit, element: Element::Face, n_components: n, values });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(n: [u32; 3], step: f64) -> Dataset {
        let steps = [DVec3::X * step, DVec3::Y, DVec3::Z];
        let places = Places::Even { origin: DVec3::ZERO, steps };
        Dataset { form: Form::Lattice { n, places }, ..Default::default() }
    }

    #[test]
    fn lattices_have_their_outside_only() {
        for step in [1.0, -1.0] {
            let mut data = even([4, 3, 3], step);
            let column = Column::of("cell", Values::F64((0..12).map(f64::from).collect()));
            data.cell_arrays.push(Array { column, role: Role::Data });
            let column = Column::of("point", Values::F64((0..36).map(f64::from).collect()));
            data.point_arrays.push(Array { column, role: Role::Data });
            let mesh = data.into_loose(Path::new("a"), 0, Vec::new()).unwrap().mesh;
            assert_eq!(mesh.triangles.len(), 2 * 2 * (6 + 6 + 4));
            assert_eq!(mesh.positions.len(), 36 - 2);
            assert_eq!(volume(&mesh.positions, &mesh.triangles), 6.0 * 12.0);
            for (t, cell) in mesh.source_faces.iter().enumerate() {
                // The cell's first corner is the least of the cell's.
                let least = mesh.triangles[t].iter().map(|v| mesh.source_points[*v as usize]).min().unwrap();
                let [x, y, z] = [least % 4, least / 4 % 3, least / 12];
                let [cx, cy, cz] = [cell % 3, cell / 3 % 2, cell / 6];
                assert!(x - cx <= 1 && y - cy <= 1 && z - cz <= 1);
                assert_eq!(mesh.fields[1].values.at(t), *cell as f64);
            }
            assert_eq!(mesh.fields[0].values.at(33), 35.0);
        }
    }

    #[test]
    fn lattices_may_be_sheets_or_less_but_not_too_large() {
        let triangles = |n| even(n, 1.0).into_loose(Path::new("a"), 0, Vec::new()).map(|l| l.mesh.triangles.len());
        assert_eq!(triangles([3, 3, 1]).unwrap(), 8);
        assert_eq!(triangles([1, 3, 2]).unwrap(), 4);
        assert_eq!(triangles([3, 1, 1]).unwrap(), 0);
        assert!(triangles([5000, 5000, 2]).is_err());
        assert!(triangles([0, 2, 2]).is_err());
        assert!(triangles([u32::MAX; 3]).is_err());
    }
}
