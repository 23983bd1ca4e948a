//! Matter as a grain file describes it, made into a filling.

use super::Body;
use super::matter::{AxisRecipe, Colors, Matter, PatternRecipe, SkeletonRecipe, WoodRecipe};
use super::paint::Leaf;
use crate::error::Result;
use crate::math::{Vec3, vec3};
use crate::recipe::layer::Words;
use crate::recipe::words::{choose, impossible};
use crate::section::grain::{
    Axis, Bands, BandsSpec, Cells, CellsSpec, Chambers, ChambersSpec, Contact, Druse, DruseSpec, Fibres, FibresSpec,
    Field, Filling, Grain, GrainSpec, Knots, LatticeAxes, Mixing, Mottle, Mottled, Nucleus, Pattern, Polyhedron, Pores,
    Rings, RingsSpec, Rooms, Scales, Shape, Size, Skeleton, Trabeculae, TrabeculaeSpec, Waves, Wavy, Wedges,
};

/// What lengths are measured by, and where they are.
pub(super) struct Scale {
    /// Model units of a spacing of the grain.
    pub(super) unit: f32,
    pub(super) body: Body,
    pub(super) seed: u32,
}

/// Matter in a model.
pub(super) struct Made {
    pub(super) filling: Filling,
    pub(super) leaves: Vec<Leaf>,
    /// Half of the least extent of its particles, model units; infinite if it has none.
    pub(super) finest: f32,
}

/// What matter may be.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    Plain,
    Cells,
    Fibres,
    Chambers,
    Rings,
    Trabeculae,
    Bands,
    Druse,
    Particles(Body3),
}

/// The shape of a particle.
#[derive(Clone, Copy, PartialEq)]
enum Body3 {
    Sphere,
    Ellipsoid,
    Cylinder,
    Capsule,
    Box,
    Superquadric,
    /// A regular polyhedron with so many faces.
    Regular(u32),
}

const OF: [(&str, Of); 19] = [
    ("sphere", Of::Particles(Body3::Sphere)),
    ("ellipsoid", Of::Particles(Body3::Ellipsoid)),
    ("cylinder", Of::Particles(Body3::Cylinder)),
    ("capsule", Of::Particles(Body3::Capsule)),
    ("box", Of::Particles(Body3::Box)),
    ("superquadric", Of::Particles(Body3::Superquadric)),
    ("tetrahedron", Of::Particles(Body3::Regular(4))),
    ("cube", Of::Particles(Body3::Regular(6))),
    ("octahedron", Of::Particles(Body3::Regular(8))),
    ("dodecahedron", Of::Particles(Body3::Regular(12))),
    ("icosahedron", Of::Particles(Body3::Regular(20))),
    ("cells", Of::Cells),
    ("fibres", Of::Fibres),
    ("chambers", Of::Chambers),
    ("rings", Of::Rings),
    ("trabeculae", Of::Trabeculae),
    ("bands", Of::Bands),
    ("druse", Of::Druse),
    ("plain", Of::Plain),
];

/// What can fill a model by its bare name: particles of a shape, cells, fibres.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    OF[..13].iter().map(|(name, _)| *name)
}

impl Matter {
    /// The filling, its waves and tones included.
    pub(super) fn make(&self, scale: &Scale) -> Result<Made> {
        let mut made = self.bare(scale)?;
        if let Some(mottle) = &self.mottle {
            let pattern = match mottle.pattern {
                None | Some(PatternRecipe::Clouds) => Pattern::Clouds,
                Some(PatternRecipe::Veins) => Pattern::Veins,
                Some(PatternRecipe::Depth) => Pattern::Depth,
            };
            let usual = Mottle::of(mottle.scale * scale.unit);
            let mottle = Mottle {
                stretch: mottle.stretch.map_or(usual.stretch, Vec3::from),
                n_octaves: mottle.octaves.unwrap_or(usual.n_octaves),
                contrast: mottle.contrast.unwrap_or(usual.contrast),
                level: mottle.level.unwrap_or(usual.level),
                pattern,
                is_everywhere: mottle.everywhere,
                seed: self.seed(scale),
                ..usual
            };
            made.filling = Filling::Mottled(Box::new(Mottled::new(mottle, made.filling)?));
        }
        if let Some(waves) = &self.waves {
            let (height, length) = (waves.height * scale.unit, waves.length * scale.unit);
            let waves = Waves { height, length, n_octaves: 3, seed: self.seed(scale) };
            made.filling = Filling::Wavy(Box::new(Wavy::new(waves, made.filling)?));
        }
        Ok(made)
    }

    fn bare(&self, scale: &Scale) -> Result<Made> {
        let of = choose("grain", &self.of, &OF)?;
        if !self.finer.is_empty() {
            return self.sizes(scale);
        }
        let leaf = self.colors().leaf()?;
        // Leaves of what has two.
        let two = || Ok::<_, crate::Error>(vec![leaf.clone(), self.second.clone().unwrap_or_default().leaf()?]);
        let spacing = self.spacing.unwrap_or(1.0) * scale.unit;
        let solid = |filling: Filling, leaves: Vec<Leaf>| Made { filling, leaves, finest: 0.5 * spacing };
        Ok(match of {
            Of::Plain => Made { filling: Filling::Plain, leaves: vec![leaf], finest: f32::INFINITY },
            Of::Cells => {
                let cells = self.cells(scale)?;
                let finest = 0.4 * spacing * cells.spec().stretch.min_element();
                let leaves = if self.nucleus.is_some() { two()? } else { vec![leaf] };
                Made { filling: Filling::Cells(Box::new(cells)), leaves, finest }
            }
            Of::Fibres => {
                let fibres = self.fibres(scale)?;
                let finest = fibres.spec().radius;
                Made { filling: Filling::Fibres(Box::new(fibres)), leaves: vec![leaf], finest }
            }
            Of::Chambers => self.chambers(scale, leaf)?,
            Of::Rings => solid(Filling::Rings(Box::new(self.rings(scale)?)), two()?),
            Of::Trabeculae => solid(Filling::Trabeculae(Box::new(self.trabeculae(scale)?)), two()?),
            Of::Bands => {
                let usual = BandsSpec::of(spacing);
                let width_spread = self.size_spread.unwrap_or(usual.width_spread);
                let bands = Bands::new(BandsSpec { width_spread, seed: self.seed(scale), ..usual })?;
                Made { filling: Filling::Bands(Box::new(bands)), leaves: vec![leaf], finest: f32::INFINITY }
            }
            Of::Druse => {
                let spec = DruseSpec::of(spacing, self.rind.unwrap_or(3.0) * scale.unit);
                let druse = Druse::new(DruseSpec { seed: self.seed(scale), ..spec })?;
                solid(Filling::Druse(Box::new(druse)), vec![leaf])
            }
            Of::Particles(shape) => {
                let (spec, finest) = self.particle_of(shape, scale)?;
                Made { filling: Filling::Particles(Box::new(Grain::new(spec)?)), leaves: vec![leaf], finest }
            }
        })
    }

    fn seed(&self, scale: &Scale) -> u32 {
        scale.seed.wrapping_add(self.seed.unwrap_or(0))
    }

    fn colors(&self) -> Colors {
        Colors {
            matrix: self.matrix.clone(),
            particles: self.particles.clone(),
            by_tone: self.by_tone,
            vary: self.vary,
            roughness: self.roughness,
        }
    }

    fn lattice(&self) -> LatticeAxes {
        if self.upright == Some(true) { LatticeAxes::Model } else { LatticeAxes::Turned }
    }

    /// None if nothing is said.
    fn axis(&self, scale: &Scale) -> Result<Option<Axis>> {
        let along = match &self.axis {
            None if self.cone.is_none() => return Ok(None),
            None => Vec3::Y,
            Some(AxisRecipe::Along(axis)) => Vec3::from(*axis),
            Some(AxisRecipe::Named(name)) => {
                let named = [("radial", Axis::Radial(scale.body.center)), ("anywhere", Axis::Isotropic)];
                return choose("axis", name, &named).map(Some);
            }
        };
        Ok(Some(match self.cone {
            None => Axis::Along(along),
            Some(degrees) => Axis::Cone(along, degrees.to_radians()),
        }))
    }

    /// The axis of what has one direction.
    fn direction(&self, scale: &Scale) -> Result<Vec3> {
        match self.axis(scale)? {
            Some(Axis::Along(axis)) => Ok(axis),
            None => Ok(Vec3::Y),
            Some(_) => Err(impossible("axis", &self.of, "it has one direction: write three numbers")),
        }
    }

    fn cells(&self, scale: &Scale) -> Result<Cells> {
        let given = |x: Option<f32>| x.map(|x| x * scale.unit);
        let usual = CellsSpec::of(self.spacing.unwrap_or(1.0) * scale.unit, given(self.wall).unwrap_or(0.0));
        let nucleus = self.nucleus.map(|n| Nucleus { radius: n.radius * scale.unit, offset: n.offset * scale.unit });
        Cells::new(CellsSpec {
            jitter: self.jitter.unwrap_or(usual.jitter),
            weight_spread: self.size_spread.unwrap_or(usual.weight_spread),
            stretch: self.stretch.map_or(usual.stretch, Vec3::from),
            lattice: self.lattice(),
            bevel: self.bevel.unwrap_or(usual.bevel),
            rounding: given(self.rounding).unwrap_or(usual.rounding),
            nucleus,
            share: self.share.unwrap_or(usual.share),
            seed: self.seed(scale),
            ..usual
        })
    }

    fn fibres(&self, scale: &Scale) -> Result<Fibres> {
        let given = |x: Option<f32>| x.map(|x| x * scale.unit);
        let spacing = self.spacing.unwrap_or(1.0) * scale.unit;
        let radius = given(self.radius).unwrap_or(0.5 * spacing);
        let usual = FibresSpec::of(spacing, radius, self.direction(scale)?);
        Fibres::new(FibresSpec {
            length: given(self.length).unwrap_or(usual.length),
            gap: given(self.gap).unwrap_or(usual.gap),
            jitter: self.jitter.unwrap_or(usual.jitter),
            size_spread: self.size_spread.unwrap_or(usual.size_spread),
            rounding: self.rounding.unwrap_or(usual.rounding),
            bevel: self.bevel.unwrap_or(usual.bevel),
            seed: self.seed(scale),
            ..usual
        })
    }

    fn chambers(&self, scale: &Scale, leaf: Leaf) -> Result<Made> {
        let given = |x: Option<f32>| x.unwrap_or(0.0) * scale.unit;
        let Some(inner) = &self.inner else {
            return Err(impossible("inner", "nothing", "chambers need something that is in them"));
        };
        let inner = inner.make(scale)?;
        let rooms = match self.wedges {
            Some(wedges) => Rooms::Wedges(Wedges {
                n: wedges.n,
                center: scale.body.center,
                axis: self.direction(scale)?,
                spread: wedges.spread,
                wall: given(self.wall),
                core: wedges.core * scale.unit,
                seed: self.seed(scale),
            }),
            // Rounded by the chambers, not by the cells.
            None => Rooms::Cells(Box::new(Self { rounding: None, ..self.clone() }.cells(scale)?)),
        };
        let chambers = Chambers::new(ChambersSpec {
            rooms,
            rind: given(self.rind),
            rounding: given(self.rounding),
            clear: given(self.clear),
            inner: inner.filling,
        })?;
        let leaves = [leaf].into_iter().chain(inner.leaves).collect();
        Ok(Made { filling: Filling::Chambers(Box::new(chambers)), leaves, finest: inner.finest })
    }

    fn rings(&self, scale: &Scale) -> Result<Rings> {
        let WoodRecipe { pith, bend, waviness, lateness, relief, streaks, rays, splinters, pores, knots } =
            self.wood.unwrap_or_default();
        let spacing = self.spacing.unwrap_or(1.0) * scale.unit;
        let usual = RingsSpec::of(spacing, self.direction(scale)?);
        Rings::new(RingsSpec {
            pith: scale.body.center + Vec3::from(pith) * spacing,
            bend: bend.unwrap_or(usual.bend),
            waviness: waviness.unwrap_or(usual.waviness),
            width_spread: self.size_spread.unwrap_or(usual.width_spread),
            lateness: lateness.unwrap_or(usual.lateness),
            relief: relief.unwrap_or(usual.relief),
            streaks: streaks.unwrap_or(usual.streaks),
            rays: rays.unwrap_or(usual.rays),
            pores: match pores {
                Some([spacing, radius, length, until]) => Some(Pores { spacing, radius, length, until }),
                None => usual.pores,
            },
            knots: knots.map(|[distance, thickness, rise]| Knots { distance, thickness, rise: rise.to_radians() }),
            splinters: splinters.unwrap_or(usual.splinters),
            seed: self.seed(scale),
            ..usual
        })
    }

    fn trabeculae(&self, scale: &Scale) -> Result<Trabeculae> {
        let SkeletonRecipe { solid, until, network, gyroid } = self.skeleton.unwrap_or_default();
        let usual = TrabeculaeSpec::of(self.spacing.unwrap_or(1.0) * scale.unit);
        Trabeculae::new(TrabeculaeSpec {
            field: if gyroid { Field::Gyroid } else { Field::Waves },
            skeleton: if network { Skeleton::Network } else { Skeleton::Walls },
            solid: solid.unwrap_or(usual.solid),
            until: until.map_or(usual.until, |u| u * scale.unit),
            load: self.direction(scale)?,
            stretch: self.stretch.map_or(usual.stretch, |s| s[0]),
            bevel: self.bevel.unwrap_or(usual.bevel),
            seed: self.seed(scale),
            ..usual
        })
    }

    /// Particles or stones of several sizes.
    fn sizes(&self, scale: &Scale) -> Result<Made> {
        let (mut sizes, mut leaves, mut finest) = (Vec::new(), Vec::new(), f32::INFINITY);
        for matter in [self].into_iter().chain(&self.finer) {
            let (size, least) = match choose("grain", &matter.of, &OF)? {
                Of::Particles(shape) => {
                    let (spec, least) = matter.particle_of(shape, scale)?;
                    (Size::Grain(Box::new(Grain::new(spec)?)), least)
                }
                Of::Cells => {
                    let cells = matter.cells(scale)?;
                    let least = 0.4 * cells.spec().spacing;
                    (Size::Cells(Box::new(cells)), least)
                }
                _ => return Err(impossible("finer", &matter.of, "only particles and cells come in several sizes")),
            };
            sizes.push(size);
            leaves.push(matter.colors().leaf()?);
            finest = finest.min(least);
        }
        let mixing = match self.joined {
            Some(true) => Mixing::Joined,
            _ => Mixing::Apart(self.gap.unwrap_or(0.0) * scale.unit),
        };
        Ok(Made { filling: Filling::Scales(Box::new(Scales::new(sizes, mixing)?)), leaves, finest })
    }

    fn particle_of(&self, shape: Body3, scale: &Scale) -> Result<(GrainSpec, f32)> {
        let spacing = self.spacing.unwrap_or(1.0) * scale.unit;
        let radius = self.radius.map_or(0.5 * spacing, |r| r * scale.unit);
        // Too short for a capsule would be a stump; too long for a cylinder has no room.
        let usual_height = radius * if shape == Body3::Capsule { 2.8 } else { 1.6 };
        let height = self.height.map_or(usual_height, |h| h * scale.unit);
        let positive = |what: &str, x: f32| match x > 0.0 && x.is_finite() {
            true => Ok(()),
            false => Err(impossible(what, x, "it is a length above zero")),
        };
        positive("spacing", spacing)?;
        positive("radius", radius)?;
        positive("height", height)?;
        let radii = self.radii.map_or(vec3(radius, radius, 0.5 * height), |r| Vec3::from(r) * scale.unit);
        let rounding = self.rounding.unwrap_or(0.0) * scale.unit;
        let shape = match shape {
            Body3::Ellipsoid => Shape::Ellipsoid { radii },
            Body3::Cylinder => Shape::Cylinder { radius, height, ends: Default::default() },
            Body3::Capsule => Shape::Capsule { radius, height },
            Body3::Box => Shape::Box { edges: radii * 2.0, rounding },
            Body3::Superquadric => Shape::Superquadric { radii, power: self.power.unwrap_or(4.0) },
            Body3::Regular(n_faces) => Shape::Polyhedron(Polyhedron::regular(n_faces, radius)?),
            Body3::Sphere => Shape::Sphere { radius },
        };
        let usual = GrainSpec::of(shape, spacing);
        let contact = match self.overlap {
            Some(true) => Contact::Overlapping,
            _ => Contact::Apart { grow: self.grow.unwrap_or(1.0) },
        };
        let finest = least_half_extent(&usual.shape);
        let spec = GrainSpec {
            axis: self.axis(scale)?.unwrap_or(usual.axis),
            jitter: self.jitter.unwrap_or(usual.jitter),
            size_spread: self.size_spread.unwrap_or(usual.size_spread),
            bevel: self.bevel.unwrap_or(usual.bevel),
            lattice: self.lattice(),
            contact,
            seed: self.seed(scale),
            ..usual
        };
        Ok((spec, finest))
    }
}

impl Colors {
    fn leaf(&self) -> Result<Leaf> {
        fn list(words: &Option<Words>) -> &[String] {
            words.as_ref().map_or(&[], Words::list)
        }
        let leaf = Leaf::new(list(&self.matrix), list(&self.particles))?.with_roughness(self.roughness)?;
        let vary = self.vary.unwrap_or(leaf.vary);
        if !(0.0..=1.0).contains(&vary) {
            return Err(impossible("vary", vary, "0 to 1"));
        }
        Ok(Leaf { vary, by_tone: self.by_tone.unwrap_or(false), ..leaf })
    }
}

/// Half of a particle's least extent, before it is perturbed.
pub(super) fn least_half_extent(shape: &Shape) -> f32 {
    match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Ellipsoid { radii } | Shape::Superquadric { radii, .. } => radii.min_element(),
        Shape::Cylinder { radius, height, .. } | Shape::Capsule { radius, height } => radius.min(0.5 * height),
        Shape::Box { edges, .. } => 0.5 * edges.min_element(),
        Shape::Polyhedron(polyhedron) => polyhedron.inradius(),
    }
}
