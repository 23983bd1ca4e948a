//! Outlines of the particles that a plane goes through: for drawings, laser cutters and measurements.

use super::curve::Curve;
use super::eval::Candidate;
use super::filling::Layer;
use super::scales::Size;
use super::spec::Shape;
use super::{Cells, Fibres, Filling, Grain, Window};
use crate::math::{DVec2, DVec3};
use crate::section::Plane;

/// A particle's section.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Its name, as [`Hit::particle`](super::Hit::particle) has it.
    pub particle: u32,
    /// Which leaf of the filling it is of, as [`Hit::leaf`](super::Hit::leaf) has it.
    pub leaf: u16,
    /// What it is, in words that a style sheet can use: `ball`, `coarse box`, `layer-1 fibre`.
    pub class: String,
    /// Whether it goes with the half below when the section is a tear.
    pub is_below: bool,
    /// No point of the outline is farther than `reach` from here: plane coordinates, model units.
    pub middle: DVec2,
    /// See `middle`.
    pub reach: f64,
    /// The outline, in plane coordinates and model units.
    pub curve: Curve,
}

/// The outlines of all particles of a filling that a plane goes through in a window of it and a little beyond, in the
/// order of the lattice; none if there are millions. `depth` tells how deep below the skin a point lies, model units.
///
/// Curves are exact for balls, ellipsoids, cylinders, capsules, boxes, polyhedra, cells and fibres - but for rounded rims,
/// which polygons follow, as they do boxes with rounded edges and superquadrics - within a thousandth of the particle's
/// reach. Where particles overlap, each has its own outline. Particles of a layer that is not strict are whole.
/// Cells count as sharp ones, without nuclei; rings, bands, trabeculae, a druse and chambers have no outlines.
pub fn outlines(
    filling: &Filling,
    plane: &Plane,
    window: &Window,
    depth: &dyn Fn(DVec3) -> f32,
) -> Option<Vec<Outline>> {
    let mut list = Vec::new();
    let asked = Asked { plane, window, depth };
    asked.add(filling, "", &|_| true, &mut list)?;
    Some(list)
}

struct Asked<'a> {
    plane: &'a Plane,
    window: &'a Window,
    depth: &'a dyn Fn(DVec3) -> f32,
}

impl Asked<'_> {
    fn add(
        &self,
        filling: &Filling,
        prefix: &str,
        keep: &dyn Fn(&Candidate) -> bool,
        out: &mut Vec<Outline>,
    ) -> Option<()> {
        match filling {
            Filling::Plain => Some(()),
            Filling::Particles(grain) => self.add_grain(grain, prefix, keep, out),
            Filling::Cells(cells) => self.add_cells(cells, prefix, keep, out),
            Filling::Fibres(fibres) => self.add_fibres(fibres, prefix, keep, out),
            Filling::Scales(scales) => {
                for (k, size) in scales.sizes().iter().enumerate() {
                    let has_room = |c: &Candidate| scales.has_room(k, c) && keep(c);
                    let prefix = format!("{prefix}size-{} ", k + 1);
                    let first = out.len();
                    match size {
                        Size::Grain(grain) => self.add_grain(grain, &prefix, &has_room, out)?,
                        Size::Cells(cells) => self.add_cells(cells, &prefix, &has_room, out)?,
                    }
                    out[first..].iter_mut().for_each(|o| o.leaf += k as u16);
                }
                Some(())
            }
            Filling::Mottled(mottled) => self.add(mottled.filling(), prefix, keep, out),
            Filling::Wavy(wavy) => {
                let depth = |p: DVec3| wavy.depth(p, (self.depth)(p));
                Asked { depth: &depth, ..*self }.add(wavy.filling(), prefix, keep, out)
            }
            // These have no outlines but the section's own.
            Filling::Rings(_)
            | Filling::Trabeculae(_)
            | Filling::Bands(_)
            | Filling::Druse(_)
            | Filling::Chambers(_) => Some(()),
            Filling::Layers(layers) => {
                for (k, layer) in layers.iter().enumerate() {
                    let is_in = |c: &Candidate| Layer::holds(layers, k, c, self.depth) && keep(c);
                    let first = out.len();
                    self.add(&layer.filling, &format!("{prefix}layer-{k} "), &is_in, out)?;
                    out[first..].iter_mut().for_each(|o| o.leaf += Layer::first_leaf(layers, k));
                }
                Some(())
            }
        }
    }

    fn add_grain(
        &self,
        grain: &Grain,
        prefix: &str,
        keep: &dyn Fn(&Candidate) -> bool,
        out: &mut Vec<Outline>,
    ) -> Option<()> {
        let spacing = grain.spec().spacing as f64;
        let class = format!("{prefix}{}", shape_name(&grain.spec().shape));
        for slice in grain.slices(self.plane, self.window, keep)? {
            let to_lattice = |d: DVec3| grain.model_from_lattice.transpose() * d;
            let Some(curve) = slice.outline(self.plane, self.window, spacing, to_lattice) else { continue };
            let reach = slice.particle.reach as f64;
            let reach = (reach * reach - slice.height * slice.height).max(0.0).sqrt();
            out.push(Outline {
                particle: slice.particle.id,
                leaf: 0,
                class: class.clone(),
                is_below: slice.height <= 0.0,
                middle: slice.at,
                reach,
                curve,
            });
        }
        Some(())
    }

    fn add_cells(
        &self,
        cells: &Cells,
        prefix: &str,
        keep: &dyn Fn(&Candidate) -> bool,
        out: &mut Vec<Outline>,
    ) -> Option<()> {
        for slice in cells.slices(self.plane, self.window, keep)? {
            let Some(curve) = cells.outline(&slice, self.window) else { continue };
            let n = slice.polygon.len() as f64;
            let middle = slice.polygon.iter().sum::<DVec2>() / n;
            let reach = slice.polygon.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
            let class = format!("{prefix}cell");
            out.push(Outline {
                particle: slice.particle.id,
                leaf: 0,
                class,
                is_below: slice.is_below,
                middle,
                reach,
                curve,
            });
        }
        Some(())
    }

    fn add_fibres(
        &self,
        fibres: &Fibres,
        prefix: &str,
        keep: &dyn Fn(&Candidate) -> bool,
        out: &mut Vec<Outline>,
    ) -> Option<()> {
        let spacing = fibres.spec.spacing as f64;
        for (slice, _) in fibres.slices(self.plane, self.window, keep)? {
            let to_fibres = |d: DVec3| fibres.model_from_fibres.transpose() * d;
            let Some(curve) = slice.outline(self.plane, self.window, spacing, to_fibres) else { continue };
            let reach = slice.particle.reach as f64;
            out.push(Outline {
                particle: slice.particle.id,
                leaf: 0,
                class: format!("{prefix}fibre"),
                is_below: slice.height <= 0.0,
                middle: slice.at,
                reach: (reach * reach - slice.height * slice.height).max(0.0).sqrt(),
                curve,
            });
        }
        Some(())
    }
}

fn shape_name(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "ball",
        Shape::Ellipsoid { .. } => "ellipsoid",
        Shape::Cylinder { .. } => "rod",
        Shape::Capsule { .. } => "capsule",
        Shape::Box { .. } => "box",
        Shape::Polyhedron(_) => "polyhedron",
        Shape::Superquadric { .. } => "superquadric",
    }
}
