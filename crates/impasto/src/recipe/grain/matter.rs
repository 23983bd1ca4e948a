//! What a grain file can say of one kind of matter.

use crate::recipe::layer::Words;
use serde::{Deserialize, Serialize};

/// What a layer of a grain is made of. Lengths are in spacings of the grain.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Matter {
    /// `plain` (nothing but matrix), a shape of particles (`sphere`, `ellipsoid`, `cylinder`, `capsule`, `box`,
    /// `superquadric`, `tetrahedron`, `cube`, `octahedron`, `dodecahedron`, `icosahedron`), `cells`, `fibres`, `chambers`
    /// (rooms and what is in them), `rings` (of wood), `trabeculae` (of bone), `bands` (of agate) or `druse` (a hollow
    /// lined with crystals).
    pub of: String,
    /// Depth below the skin where the layer ends; absent: it goes on to the middle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until: Option<f32>,
    /// Particles that reach over the layer's border are left out; else those stay whose centre is in it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strict: Option<bool>,
    /// Between particles; absent: 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<f32>,
    /// Of particles and fibres; absent: half their spacing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f32>,
    /// From end to end, of particles that have one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f32>,
    /// Of ellipsoids, superquadrics and boxes: half of each extent, the third along the axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radii: Option<[f32; 3]>,
    /// Of superquadrics: 1.1 to 32, from octahedron by ellipsoid (2) to box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<f32>,
    /// Radius of the edges of boxes, cells and chambers; of fibres' rims, as a share of the radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rounding: Option<f32>,
    /// Where particles point: three numbers, `radial` (away from the model's middle), or `anywhere`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<AxisRecipe>,
    /// They point up to so many degrees away from the axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cone: Option<f32>,
    /// How far centres move off their lattice, 0 to 0.5 of their spacing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jitter: Option<f32>,
    /// How much sizes differ: 0.35 is between 65 % and 135 %.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_spread: Option<f32>,
    /// Particles may grow by this factor where there is room; absent: 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grow: Option<f32>,
    /// Particles go through each other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overlap: Option<bool>,
    /// The lattice stands along the model's axes; else it is turned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub upright: Option<bool>,
    /// Depth and width of a solid cut's bevel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bevel: Option<f32>,
    /// Of cells: width of the walls between them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall: Option<f32>,
    /// Of cells: how much longer they are along the model's axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stretch: Option<[f32; 3]>,
    /// Of cells: the part of them that is there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f32>,
    /// Of fibres: mean length of their pieces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f32>,
    /// Of fibres: between the ends of pieces. Of `fine` matter: how far it keeps away from the coarse.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<f32>,
    /// Other numbers for chance, so that layers differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u32>,
    /// Colour between particles; several make a ramp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matrix: Option<Words>,
    /// Colours of particles; each has one of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub particles: Option<Words>,
    /// The particles' colours are a ramp along what the matter has from place to place, such as the rings of wood.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_tone: Option<bool>,
    /// How much lighter or darker than these a particle may be; absent: 0.15.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vary: Option<f32>,
    /// Of the matrix and of the particles: 0 mirror to 1 chalk.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<[f32; 2]>,
    /// Colours of the second leaf: of nuclei, pores, marrow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second: Option<Colors>,
    /// Smaller particles or cells between these, the coarsest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub finer: Vec<Matter>,
    /// Finer particles stay where they are, so that bubbles run into each other; else those are left out that a coarser
    /// one has no room for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joined: Option<bool>,
    /// Of cells: a ball at the seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nucleus: Option<NucleusRecipe>,
    /// Of chambers: how the rooms are laid out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wedges: Option<WedgesRecipe>,
    /// Of chambers: what is in the rooms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inner: Option<Box<Matter>>,
    /// Of chambers: depth below the skin where they begin. Of a druse: where its wall is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rind: Option<f32>,
    /// Of chambers: particles are left out that are nearer to a wall than this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clear: Option<f32>,
    /// Of wood: its rings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wood: Option<WoodRecipe>,
    /// Of spongy bone: its skeleton.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<SkeletonRecipe>,
    /// Tones by noise, along the ramp of the colours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mottle: Option<MottleRecipe>,
    /// What follows the skin has waves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waves: Option<WavesRecipe>,
}

/// Colours of one leaf of a filling.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Colors {
    /// Of what is between particles; several make a ramp.
    pub matrix: Option<Words>,
    /// Of particles.
    pub particles: Option<Words>,
    /// The particles' colours are a ramp.
    pub by_tone: Option<bool>,
    /// How much lighter or darker a particle may be.
    pub vary: Option<f32>,
    /// Of the matrix and of the particles.
    pub roughness: Option<[f32; 2]>,
}

/// A ball in each cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NucleusRecipe {
    /// Its radius.
    pub radius: f32,
    /// How far it may be off the cell's seed.
    pub offset: f32,
}

/// Segments of a fruit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WedgesRecipe {
    /// How many.
    pub n: u32,
    /// How much their angles differ, 0 to 0.7.
    pub spread: f32,
    /// Radius of the core.
    pub core: f32,
}

/// Rings, branches and vessels of wood; a ring is as wide as the spacing, and all lengths are in widths of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WoodRecipe {
    /// The pith, off the model's middle.
    pub pith: [f32; 3],
    /// How far it wanders.
    pub bend: Option<f32>,
    /// How far rings leave the circle.
    pub waviness: Option<f32>,
    /// How late and steep the rise to late wood is: 1 even, 6 steep.
    pub lateness: Option<f32>,
    /// How much higher late wood stands in a solid cut.
    pub relief: Option<f32>,
    /// How strong streaks along the fibres are, 0 to 1.
    pub streaks: Option<f32>,
    /// How bright rays are, 0 to 1.
    pub rays: Option<f32>,
    /// Width of splinters in a tear.
    pub splinters: Option<f32>,
    /// Vessels: distance, radius, length, and the part of the year in which they grow.
    pub pores: Option<[f32; 4]>,
    /// Branches: distance along the trunk, thickness as a share of the trunk's, degrees above the level.
    pub knots: Option<[f32; 3]>,
}

/// The skeleton of spongy bone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SkeletonRecipe {
    /// Which part is solid at the skin, and in the middle.
    pub solid: Option<[f32; 2]>,
    /// Depth where the middle's share is reached.
    pub until: Option<f32>,
    /// Beams and plates in one void, in place of walls that part two.
    pub network: bool,
    /// The regular gyroid in place of random waves.
    pub gyroid: bool,
}

/// Tones by noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MottleRecipe {
    /// Width of the largest features.
    pub scale: f32,
    /// `clouds` (absent), `veins`, or `depth`: from the skin inward.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pattern: Option<PatternRecipe>,
    /// How much of the ramp is used; 1 for its whole length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contrast: Option<f32>,
    /// The mean tone of clouds; of veins their width.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<f32>,
    /// Each adds features of half the width.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub octaves: Option<u32>,
    /// How much longer features are along the model's axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stretch: Option<[f32; 3]>,
    /// Particles get tones, too.
    #[serde(default)]
    pub everywhere: bool,
}

/// What noise draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PatternRecipe {
    /// Spots.
    Clouds,
    /// Thin veins.
    Veins,
    /// From the skin inward.
    Depth,
}

/// Waves of what follows the skin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WavesRecipe {
    /// How high.
    pub height: f32,
    /// How wide the largest are.
    pub length: f32,
}

/// Where particles point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum AxisRecipe {
    /// Along a direction of the model.
    Along([f32; 3]),
    /// `radial` or `anywhere`.
    Named(String),
}
