//! Values on a regular 3-D grid, and what lies between its points.
//!
//! The grid's axes may be skew and of either hand. Between points values are trilinear; a missing corner (NaN) makes a
//! value missing only where it has weight. Outside of the grid all is missing.

use crate::assets::field::Range;
use crate::assets::{Element, Field, Mesh, Values};
use crate::math::{DMat3, DVec3, Vec3};

/// Where a grid's points lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Points along each axis.
    pub size: [u32; 3],
    /// The first point, model units.
    pub origin: DVec3,
    /// Steps from a point to the next along each axis, model units.
    pub axes: [DVec3; 3],
}

/// One number a point of a lattice. Immutable; made by [`Grid::new`].
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// As the file names it.
    pub name: String,
    /// Unit of the values as text; empty when unknown.
    pub unit: String,
    lattice: Lattice,
    values: Vec<f32>,
    index_from_world: IndexFromWorld,
}

/// The affine map from places to (fractional) indices, in f32 so that it can run per pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
struct IndexFromWorld {
    origin: Vec3,
    /// Gradients of the three indices.
    rows: [Vec3; 3],
    /// Greatest indices.
    last: [f32; 3],
}

/// Places this far outside, in steps, count as on the border: room for the rounding of surfaces that end there.
const BORDER: f32 = 1e-3;

impl Lattice {
    /// How many points; none when they cannot be counted.
    pub fn n_points(&self) -> Option<usize> {
        self.size.iter().try_fold(1usize, |n, &s| n.checked_mul(s as usize))
    }

    /// The place of a point with fractional indices.
    pub fn place(&self, index: DVec3) -> DVec3 {
        self.origin + self.axes[0] * index.x + self.axes[1] * index.y + self.axes[2] * index.z
    }

    /// The volume of a cell; negative when the axes are left-handed.
    pub fn cell_volume(&self) -> f64 {
        self.axes[0].dot(self.axes[1].cross(self.axes[2]))
    }
}

impl Grid {
    /// A grid of `values`, the first index fastest; infinite ones become missing.
    ///
    /// # Errors
    /// One clause that tells what is wrong: counts that disagree, or axes that span no volume.
    pub fn new(lattice: Lattice, mut values: Vec<f32>) -> Result<Self, String> {
        let Lattice { size, origin, axes } = lattice;
        let [x, y, z] = size;
        if size.contains(&0) || lattice.n_points() != Some(values.len()) {
            return Err(format!("a grid of {x} x {y} x {z} points with {} values", values.len()));
        }
        let steps = DMat3::from_cols_array_2d(&axes.map(|a| a.to_array()));
        let inverse = steps.inverse();
        let rows = [0, 1, 2].map(|i| inverse.row(i).as_vec3());
        let is_sound = lattice.cell_volume() != 0.0
            && origin.as_vec3().is_finite()
            && rows.iter().chain(&axes.map(|a| a.as_vec3())).all(|v| v.is_finite());
        if !is_sound {
            return Err(format!("the grid's steps {}, {} and {} span no volume", axes[0], axes[1], axes[2]));
        }
        values.iter_mut().filter(|v| v.is_infinite()).for_each(|v| *v = f32::NAN);
        let index_from_world = IndexFromWorld { origin: origin.as_vec3(), rows, last: size.map(|n| (n - 1) as f32) };
        Ok(Self { name: String::new(), unit: String::new(), lattice, values, index_from_world })
    }

    /// The same with a name and a unit.
    pub fn named(self, name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), ..self }
    }

    /// Where its points lie.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Points along each axis.
    pub fn size(&self) -> [u32; 3] {
        self.lattice.size
    }

    /// The first point, model units.
    pub fn origin(&self) -> DVec3 {
        self.lattice.origin
    }

    /// Steps between neighbouring points, model units.
    pub fn axes(&self) -> [DVec3; 3] {
        self.lattice.axes
    }

    /// All values, the first index fastest; NaN is missing.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Where in [`values`](Self::values) a point is.
    #[inline(always)]
    fn offset(&self, [i, j, k]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.lattice.size.map(|n| n as usize);
        (k * ny + j) * nx + i
    }

    /// The value at a point.
    #[inline(always)]
    pub fn at(&self, i: usize, j: usize, k: usize) -> f32 {
        self.values[self.offset([i, j, k])]
    }

    /// The least and the greatest value, and how many are missing.
    pub fn range(&self) -> Range {
        let mut range = Range { min: f64::INFINITY, max: f64::NEG_INFINITY, n_missing: 0 };
        for v in self.values.iter().map(|v| *v as f64) {
            if v.is_nan() {
                range.n_missing += 1;
            } else {
                range.min = range.min.min(v);
                range.max = range.max.max(v);
            }
        }
        range
    }

    /// The value at a place; NaN outside, and where a missing corner has weight.
    #[inline(always)]
    pub fn sample(&self, p: Vec3) -> f32 {
        let Some(cell) = self.cell_at(p) else { return f32::NAN };
        cell.sum(|corner| self.values[self.offset(corner)])
    }

    /// The value at a place, and how fast it changes there per model unit: the slope of the values in between, which jumps
    /// from cell to cell. Missing as [`sample`](Self::sample) is, without a slope; where only the slope is missing it is 0.
    #[inline(always)]
    pub fn sample_with_slope(&self, p: Vec3) -> (f32, Vec3) {
        let Some(cell) = self.cell_at(p) else { return (f32::NAN, Vec3::ZERO) };
        let value = cell.sum(|corner| self.values[self.offset(corner)]);
        let slope = self.world_slope([0, 1, 2].map(|axis| cell.slope(axis, |corner| self.values[self.offset(corner)])));
        (value, if slope.is_finite() && !value.is_nan() { slope } else { Vec3::ZERO })
    }

    /// [`sample`](Self::sample) at many places, coordinates in lanes; all slices have one length.
    #[inline(always)]
    pub fn sample_lanes(&self, p: [&[f32]; 3], out: &mut [f32]) {
        let [x, y, z] = p.map(|lane| &lane[..out.len()]);
        for i in 0..out.len() {
            out[i] = self.sample(Vec3::new(x[i], y[i], z[i]));
        }
    }

    /// How fast the values change at a place, per model unit; missing as [`sample`](Self::sample) is.
    ///
    /// Central differences at the points, trilinear between them: continuous, and smoother than the slope of the values
    /// in between.
    pub fn gradient(&self, p: Vec3) -> Vec3 {
        let Some(cell) = self.cell_at(p) else { return Vec3::NAN };
        if cell.sum(|corner| self.values[self.offset(corner)]).is_nan() {
            return Vec3::NAN;
        }
        let by_index = [0, 1, 2].map(|axis| cell.sum(|corner| self.difference(corner, axis)));
        self.world_slope(by_index)
    }

    /// A slope by indices as a slope by model units.
    pub(super) fn world_slope(&self, by_index: [f32; 3]) -> Vec3 {
        let [a, b, c] = self.index_from_world.rows;
        a * by_index[0] + b * by_index[1] + c * by_index[2]
    }

    /// Change a step along an axis: central, one-sided beside what is missing, 0 where both sides are.
    pub(super) fn difference(&self, point: [usize; 3], axis: usize) -> f32 {
        let here = self.values[self.offset(point)];
        let beside = |is_next: bool| {
            let mut p = point;
            p[axis] = if is_next { p[axis] + 1 } else { p[axis].wrapping_sub(1) };
            if p[axis] < self.lattice.size[axis] as usize { self.values[self.offset(p)] } else { f32::NAN }
        };
        let (before, after) = (beside(false), beside(true));
        match (before.is_nan(), after.is_nan()) {
            (false, false) => (after - before) * 0.5,
            (true, false) if !here.is_nan() => after - here,
            (false, true) if !here.is_nan() => here - before,
            _ => 0.0,
        }
    }

    /// The cell of points around a place.
    #[inline(always)]
    fn cell_at(&self, p: Vec3) -> Option<Cell> {
        let map = &self.index_from_world;
        let d = p - map.origin;
        let along = |axis: usize| {
            let row = map.rows[axis];
            (d.x * row.x + d.y * row.y) + d.z * row.z
        };
        let (x, y, z) = (along(0), along(1), along(2));
        let [lx, ly, lz] = map.last;
        // Not a number is not inside.
        let is_inside = |x: f32, last: f32| x >= -BORDER && x <= last + BORDER;
        if !(is_inside(x, lx) && is_inside(y, ly) && is_inside(z, lz)) {
            return None;
        }
        let between = |x: f32, last: f32| {
            let x = if x > 0.0 { x } else { 0.0 };
            let x = if x < last { x } else { last };
            let low = x as usize;
            (low, (low + 1).min(last as usize), x - low as f32)
        };
        Some(Cell { axes: [between(x, lx), between(y, ly), between(z, lz)] })
    }

    /// The values at the vertices of a surface, as a field with the grid's name and unit; NaN outside of the grid.
    pub fn at_vertices(&self, mesh: &Mesh) -> Field {
        self.off_vertices(mesh, 0.0)
    }

    /// The same a distance outside of the surface, along its normals.
    pub fn off_vertices(&self, mesh: &Mesh, distance: f32) -> Field {
        let places = mesh.positions().iter().zip(mesh.normals()).map(|(p, n)| *p + *n * distance);
        Field {
            name: self.name.clone(),
            unit: self.unit.clone(),
            element: Element::Vertex,
            n_components: 1,
            values: Values::F32(places.map(|p| self.sample(p)).collect()),
        }
    }

    /// The means of blocks of points, if there are more than `most`; how many points a block has along each axis.
    pub(super) fn thinned(self, most: usize) -> (Self, u32) {
        let n_with = |step: u32| self.lattice.size.iter().map(|n| (*n).div_ceil(step) as usize).product::<usize>();
        let step = (1..).find(|s| n_with(*s) <= most).unwrap_or(1);
        if step == 1 {
            return (self, 1);
        }
        let size = self.lattice.size.map(|n| n.div_ceil(step));
        let mut values = Vec::with_capacity(n_with(step));
        let block = |i: u32, axis: usize| i * step..((i + 1) * step).min(self.lattice.size[axis]);
        for k in 0..size[2] {
            for j in 0..size[1] {
                for i in 0..size[0] {
                    let (mut sum, mut n) = (0.0, 0);
                    for z in block(k, 2) {
                        for y in block(j, 1) {
                            let start = self.offset([(i * step) as usize, y as usize, z as usize]);
                            let row = &self.values[start..start + block(i, 0).len()];
                            sum += row.iter().map(|v| *v as f64).sum::<f64>();
                            n += row.len();
                        }
                    }
                    values.push((sum / n as f64) as f32);
                }
            }
        }
        let middle = (step - 1) as f64 / 2.0;
        let lattice = Lattice {
            size,
            origin: self.lattice.place(DVec3::splat(middle)),
            axes: self.lattice.axes.map(|a| a * step as f64),
        };
        match Self::new(lattice, values) {
            Ok(thin) => (thin.named(self.name, self.unit), step),
            Err(_) => (self, 1),
        }
    }
}

/// The points around a place: along each axis the two indices and the second one's weight.
struct Cell {
    axes: [(usize, usize, f32); 3],
}

impl Cell {
    /// How fast the weighted sum changes from one point to the next along an axis; 0 where there is but one.
    #[inline(always)]
    fn slope(&self, axis: usize, value: impl Fn([usize; 3]) -> f32) -> f32 {
        let (low, high, _) = self.axes[axis];
        if low == high {
            return 0.0;
        }
        let at = |index: usize| {
            let mut flat = Self { axes: self.axes };
            flat.axes[axis] = (index, index, 0.0);
            flat.sum(&value)
        };
        at(high) - at(low)
    }

    /// The weighted sum over the corners, in a fixed order. Corners without weight do not matter, whatever they hold.
    #[inline(always)]
    fn sum(&self, value: impl Fn([usize; 3]) -> f32) -> f32 {
        let [x, y, z] = self.axes;
        let mut sum = 0.0;
        for (k, wz) in [(z.0, 1.0 - z.2), (z.1, z.2)] {
            for (j, wy) in [(y.0, 1.0 - y.2), (y.1, y.2)] {
                for (i, wx) in [(x.0, 1.0 - x.2), (x.1, x.2)] {
                    let weight = wx * wy * wz;
                    if weight != 0.0 {
                        sum += weight * value([i, j, k]);
                    }
                }
            }
        }
        sum
    }
}

#[cfg(test)]
#[path = "grid_tests.rs"]
mod tests;
