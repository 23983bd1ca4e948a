//! Properties of a surface - fields of its mesh, grids around it - as coordinates: what data layers are read at.
//!
//! A batch's values are measured once, before any scale, and kept with the batch: layers that show the same property share
//! them, and a picture that stands still can be shown again with another range without looking at the mesh.

use crate::assets::{Element, Field, Grid, Mesh, Values};
use crate::math::{BATCH, Lane, Vec3};
use crate::placement::evaluate::Motion;
use crate::placement::number::Number;
use crate::placement::{Needs, Surfels};
use std::sync::Arc;

/// What is measured on a surface: one number at each of its points.
#[derive(Clone, Debug)]
pub enum Property {
    /// A field of the mesh, or one of its numbers.
    Field {
        /// Index into the mesh's fields.
        field: usize,
        /// Which number of the value; none: its length as a vector.
        component: Option<usize>,
        /// What a missing value does to its triangles.
        missing: Missing,
    },
    /// Values on a grid, read at every point of the surface or outside of it.
    Grid {
        /// In the mesh's space.
        grid: Arc<Grid>,
        /// How far outside, along the normal; model units.
        distance: f32,
    },
}

/// What a missing value does to the triangles that share it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Missing {
    /// Points nearest to it are missing; the rest of the triangle goes by the corners that are there.
    #[default]
    Nearest,
    /// All of the triangle is missing: nothing is said that was not measured.
    Fan,
}

impl PartialEq for Property {
    /// Two grids are the same when they are one.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::Field { field, component, missing },
                Self::Field { field: other_field, component: other_component, missing: other_missing },
            ) => (field, component, missing) == (other_field, other_component, other_missing),
            (Self::Grid { grid, distance }, Self::Grid { grid: other, distance: other_distance }) => {
                Arc::ptr_eq(grid, other) && distance == other_distance
            }
            _ => false,
        }
    }
}

impl Property {
    /// Which lanes of the surfels it is measured by.
    pub fn needs(&self) -> Needs {
        let needs = Needs { derivatives: true, ..Needs::default() };
        match self {
            Self::Field { .. } => needs,
            Self::Grid { distance, .. } => Needs { position: true, normal: *distance != 0.0, ..needs },
        }
    }

    /// Whether the mesh has it.
    pub fn fits(&self, mesh: &Mesh) -> bool {
        match self {
            Self::Field { field, component, .. } => {
                mesh.fields().get(*field).is_some_and(|f| component.unwrap_or(0) < f.n_components)
            }
            Self::Grid { .. } => true,
        }
    }
}

/// A property as a coordinate: `value * scale + offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct PropertyAxis {
    /// What is measured.
    pub property: Property,
    /// Texture widths a unit.
    pub scale: f64,
    /// Where the value 0 falls.
    pub offset: f64,
}

impl PropertyAxis {
    /// `from` falls on 0 and `to` on 1; all on 0 when they are equal.
    pub fn over(property: Property, [from, to]: [f64; 2]) -> Self {
        let scale = if to != from { 1.0 / (to - from) } else { 0.0 };
        Self { property, scale, offset: -from * scale }
    }
}

/// A property's values at a batch's points. Missing ones are NaN.
#[derive(Clone)]
pub struct Measure {
    /// As the property has them, before any scale.
    pub value: [f64; BATCH],
    /// How they change for one cell to the right, and for one cell down.
    pub d: [[f64; BATCH]; 2],
}

/// What has been measured at the points of one batch.
#[derive(Clone, Default)]
pub struct Measures {
    /// The first `n` are of this batch; the others are room for more.
    held: Vec<(Property, Box<Measure>)>,
    n: usize,
}

impl Measures {
    /// Forgets all values: another batch comes.
    pub fn clear(&mut self) {
        self.n = 0;
    }

    /// What is held of this batch.
    pub fn held(&self) -> &[(Property, Box<Measure>)] {
        &self.held[..self.n]
    }

    /// Holds one more property, whose values the caller fills in.
    pub fn push(&mut self, property: Property) -> &mut Measure {
        match self.held.get_mut(self.n) {
            Some((held, _)) => *held = property,
            None => self.held.push((property, Box::new(Measure { value: [0.0; BATCH], d: [[0.0; BATCH]; 2] }))),
        }
        self.n += 1;
        &mut self.held[self.n - 1].1
    }

    /// The property at the batch's points, measured now unless that was done before.
    pub fn of(&mut self, property: &Property, mesh: &Mesh, surfels: &Surfels) -> &Measure {
        let known = self.held().iter().position(|(held, _)| held == property);
        let index = known.unwrap_or_else(|| {
            let measure = self.push(property.clone());
            match property {
                Property::Field { field, component, missing } => match mesh.fields().get(*field) {
                    Some(field) => measure.read_field(field, (*component, *missing), mesh, surfels),
                    None => measure.read_nothing(surfels.n),
                },
                Property::Grid { grid, distance } => measure.read_grid(grid, *distance, mesh, surfels),
            }
            self.n - 1
        });
        &self.held[index].1
    }
}

impl Measure {
    fn read_nothing(&mut self, n: usize) {
        self.value[..n].fill(0.0);
        self.d.iter_mut().for_each(|lane| lane[..n].fill(0.0));
    }

    fn read_field(
        &mut self,
        field: &Field,
        (component, missing): (Option<usize>, Missing),
        mesh: &Mesh,
        surfels: &Surfels,
    ) {
        let n = field.n_components;
        // The usual kinds get loops of their own.
        match (&field.values, component) {
            (_, Some(c)) if c >= n => self.mix(|_| f64::NAN, (field.element, missing), mesh, surfels),
            (Values::F32(v), Some(c)) => self.mix(|e| v[e * n + c] as f64, (field.element, missing), mesh, surfels),
            (Values::F64(v), Some(c)) => self.mix(|e| v[e * n + c], (field.element, missing), mesh, surfels),
            (values, None) => {
                let squared = |e: usize| (0..n).map(|k| values.at(e * n + k)).fold(0.0, |sum, x| sum + x * x);
                self.mix(|e| squared(e).sqrt(), (field.element, missing), mesh, surfels);
            }
        }
    }

    /// Numbers of vertices, corners or faces, interpolated.
    #[inline(always)]
    fn mix(
        &mut self,
        number: impl Fn(usize) -> f64,
        (element, missing): (Element, Missing),
        mesh: &Mesh,
        surfels: &Surfels,
    ) {
        // Nothing can be told of what lies between a number and infinity: it counts as missing.
        let number = |element: usize| {
            let x = number(element);
            if x.is_finite() { x } else { f64::NAN }
        };
        for i in 0..surfels.n.min(BATCH) {
            let triangle = surfels.triangle[i] as usize;
            let corners = match element {
                Element::Face => [number(triangle); 3],
                Element::Vertex => mesh.triangles()[triangle].map(|v| number(v as usize)),
                Element::Corner => [0, 1, 2].map(|c| number(triangle * 3 + c)),
            };
            let b = surfels.barycentric.each_ref().map(|lane| lane[i] as f64);
            let [value, along1, along2] = mixed(corners, b, missing);
            let change = |d: &[Lane; 2]| d[0][i] as f64 * along1 + d[1][i] as f64 * along2;
            self.value[i] = value;
            self.d[0][i] = change(&surfels.d_barycentric[0]);
            self.d[1][i] = change(&surfels.d_barycentric[1]);
        }
    }

    /// The grid at each cell's point, with the slope of its values along the way to the next cell.
    fn read_grid(&mut self, grid: &Grid, distance: f32, mesh: &Mesh, surfels: &Surfels) {
        let mut motion = Motion::STILL;
        let is_off = distance != 0.0;
        motion.gather(Needs { position: true, normal: is_off, ..Needs::default() }, mesh, surfels);
        for i in 0..surfels.n.min(BATCH) {
            let mut place = motion.position_at(surfels, i);
            if is_off {
                let normal = motion.normal_at(surfels, i);
                place = [0, 1, 2].map(|k: usize| place[k] + normal[k].times(distance));
            }
            let [x, y, z] = place;
            let (value, slope) = grid.sample_with_slope(Vec3::new(x.value, y.value, z.value));
            let change = |dx: f32, dy: f32, dz: f32| {
                dx as f64 * slope.x as f64 + dy as f64 * slope.y as f64 + dz as f64 * slope.z as f64
            };
            self.value[i] = value as f64;
            self.d[0][i] = change(x.dx, y.dx, z.dx);
            self.d[1][i] = change(x.dy, y.dy, z.dy);
        }
    }
}

/// A value between three corners, given the second and third one's weights, and how it changes with each weight.
#[inline(always)]
pub fn mixed(corners: [f64; 3], [b1, b2]: [f64; 2], missing: Missing) -> [f64; 3] {
    let [a, b, c] = corners;
    let value = a + (b1 * (b - a) + b2 * (c - a));
    if missing == Missing::Fan || !(a.is_nan() || b.is_nan() || c.is_nan()) {
        return [value, b - a, c - a];
    }
    let weights = [1.0 - b1 - b2, b1, b2];
    let nearest = (1..3).fold(0, |best, k| if weights[k] > weights[best] { k } else { best });
    if corners[nearest].is_nan() {
        return [f64::NAN; 3];
    }
    // The corners that are there share the weight; near the nearest of them there is always some.
    let there = |k: usize| if corners[k].is_nan() { 0.0 } else { weights[k] };
    let total = there(0) + there(1) + there(2);
    let sum = (0..3).filter(|&k| !corners[k].is_nan()).fold(0.0, |sum, k| sum + weights[k] * corners[k]);
    let value = sum / total;
    // The quotient rule; the first weight falls as either of the others grows.
    let slope = |k: usize| if corners[k].is_nan() { 0.0 } else { (corners[k] - value) / total };
    [value, slope(1) - slope(0), slope(2) - slope(0)]
}
