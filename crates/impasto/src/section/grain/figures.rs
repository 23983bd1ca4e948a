//! The experiments of Li 2022, Fig. 6-12, as grains.

use super::spec::{Axis, GrainSpec};
use crate::math::{Vec3, vec3};

/// One of the paper's figures: particles for a model of this height, in centimetres, and the section it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its number in the paper.
    pub number: u32,
    /// The paper's model; deer and bunny are 13 and 20 cm tall there.
    pub model: &'static str,
    /// How tall the model is, cm.
    pub height_cm: f32,
    /// Its particles; [`GrainSpec::to_the_letter`] makes the paper's own of them.
    pub grain: GrainSpec,
    /// Normal of the section.
    pub normal: Vec3,
}

/// All of them. Figures 6-8 show each kind; 9, 10 and 11 show tear, hollow and solid with three normals, here told apart by
/// the normal; 12 has its cylinders in all directions.
pub fn figures() -> Vec<Figure> {
    let bunny = |number, grain, normal| Figure { number, model: "bunny", height_cm: 20.0, grain, normal };
    let rods = || GrainSpec::cylinders(1.0, 0.5, 0.8, Vec3::Z);
    // "Three-dimensional noise perturbs the direction": by how much the paper does not say.
    let mixed = GrainSpec { axis: Axis::Perturbed(Vec3::Z, 0.9), ..GrainSpec::cylinders(0.8, 0.4, 0.7, Vec3::Z) };
    let deer = GrainSpec::spheres(0.3, 0.15);
    vec![
        bunny(6, GrainSpec::spheres(0.6, 0.3), vec3(1.0, 0.0, 1.0)),
        bunny(7, GrainSpec::spheres(0.5, 0.25), vec3(1.0, 1.0, 1.0)),
        Figure { number: 8, model: "deer", height_cm: 13.0, grain: deer, normal: Vec3::Z },
        bunny(9, rods(), Vec3::Z),
        bunny(10, rods(), Vec3::Y),
        bunny(11, rods(), vec3(1.0, 1.0, 1.0)),
        bunny(12, mixed, Vec3::Y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::grain::Grain;

    #[test]
    fn all_figures_are_possible_in_both_profiles() {
        for figure in figures() {
            assert!(figure.normal.length() > 0.0 && figure.height_cm > 0.0);
            for spec in [figure.grain.clone(), figure.grain.to_the_letter()] {
                assert!(Grain::new(spec).is_ok(), "Fig. {}", figure.number);
            }
        }
    }
}
