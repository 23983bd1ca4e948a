//! Text to calls: a picture written down, so that it can be made again.
//!
//! A [`Recipe`] is the one form of everything the program can be asked for: its flags fill one, `impasto run` reads one,
//! the gallery is a folder of them. [`prepare()`] turns it into the engine's nouns, [`Prepared::render`] into a picture.
//! All keys are optional and have the program's defaults. This module alone knows `serde`.

pub mod ball;
mod change;
pub mod check;
pub mod cut;
pub mod data;
pub mod grain;
pub mod layer;
pub mod legend;
pub mod output;
mod outside;
mod stack;
pub mod render;
pub mod prepare;
pub mod source;
pub mod text;
pub mod turntable;
pub mod view;
mod words;

pub use layer::LayerRecipe;
pub use prepare::{Prepared, prepare, prepare_scene};
pub use render::Picture;
pub use view::View;
pub use words::color;

use layer::Words;
use serde::{Deserialize, Serialize};

/// A picture, written down. [`text::parse`] reads it from TOML, [`text::to_toml`] writes it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Recipe {
    /// The picture's name, at most 60 characters; the gallery shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// One sentence about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub about: Option<String>,
    /// What is shown.
    #[serde(skip_serializing_if = "is_default")]
    pub input: Input,
    /// Where it is cut open, and what that shows: both halves are seen side by side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut: Option<CutRecipe>,
    /// From where.
    #[serde(skip_serializing_if = "is_default")]
    pub camera: CameraRecipe,
    /// How large, in which light, before what.
    #[serde(skip_serializing_if = "is_default")]
    pub picture: PictureRecipe,
    /// What surfaces are like before the layers; keys that are absent leave the file's materials as they are.
    #[serde(skip_serializing_if = "is_default")]
    pub surface: SurfaceRecipe,
    /// Lights in place of `picture.light`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<LightRecipe>,
    /// Laid over the materials' own, the first first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<LayerRecipe>,
    /// What says what the colours stand for.
    #[serde(skip_serializing_if = "is_default")]
    pub legend: LegendRecipe,
    /// What is written.
    #[serde(skip_serializing_if = "is_default")]
    pub output: Output,
    /// How the camera walks around and what else moves, for a moving picture.
    #[serde(skip_serializing_if = "is_default")]
    pub turntable: TurntableRecipe,
    /// Where the gallery's page puts it.
    #[serde(skip_serializing_if = "is_default")]
    pub gallery: GalleryPlace,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// What is shown: a file, or a surface made by formula.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Input {
    /// A file beside the recipe, or `sample:NAME`.
    pub file: Option<String>,
    /// Of samples: how fine the surface is; each has its own default.
    pub resolution: Option<u32>,
    /// Of samples, noise and scattered things: another seed is another one of the same kind.
    pub seed: Option<u32>,
    /// The file's axis that points up: `auto` (by format), `y` or `z`.
    pub up: Option<String>,
    /// Of grids: the value whose isosurface is shown; without it one that suits the values.
    pub isolevel: Option<f64>,
    /// An image in place of the base colour: a file, or `sample:NAME`.
    pub texture: Option<String>,
    /// Lay the surface out anew (UV set `unwrapped`, which layers then use).
    pub unwrap: Option<bool>,
    /// Values of other files that become fields: `FILE`, `FILE:COLUMN`, and after it `@rows=0..100`, `@id=COLUMN`,
    /// `@on=vertices` or `@on=faces`, `@as=NAME`, `@unit=TEXT`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<String>,
}

/// Where a scene is cut open, and what its grain is. Lengths in model units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CutRecipe {
    /// Normal of the cut, any length: out of half a. Absent: +X, or the figure's.
    pub normal: Option<[f32; 3]>,
    /// Where along the normal, as a share of the way through; absent: 0.5.
    pub at: Option<f32>,
    /// A point that the cut goes through, in place of `at`.
    pub through: Option<[f32; 3]>,
    /// The first cut rough: height and width of its hills, as shares of the model's size. Its caps are flat.
    pub rough: Option<[f32; 2]>,
    /// The first cut along a line: corners in the plane of `normal`, as shares of the model's size from its middle; pushed
    /// through along the normal. Its caps are flat.
    pub stroke: Option<Vec<[f32; 2]>>,
    /// More cuts, each through all pieces so far: `X,Y,Z` (a normal) or `X,Y,Z@FRACTION`.
    pub then: Vec<String>,
    /// What becomes of particles: `tear` (they stay whole), `hollow`, `solid`, or `each` for a row of each; absent: what
    /// suits the grain, of particles `tear`.
    pub kind: Option<String>,
    /// What fills the model: particles of a shape (`sphere`, the default, `ellipsoid`, `cylinder`, `capsule`, `box`,
    /// `superquadric`, `tetrahedron`, `cube`, `octahedron`, `dodecahedron`, `icosahedron`), `cells`, `fibres`, a grain by
    /// name (`granite`, `wood`, ...), a grain file `NAME.toml`, or `none` for a plain cut.
    pub grain: Option<String>,
    /// Between particles; absent: 3 % of the scene's largest extent.
    pub spacing: Option<f32>,
    /// Of particles; absent: half the spacing.
    pub radius: Option<f32>,
    /// Of particles that have one, from end to end; absent: 0.8 times their width, of capsules 1.4 times.
    pub height: Option<f32>,
    /// Where particles point; absent: anywhere.
    pub axis: Option<[f32; 3]>,
    /// They point up to so many degrees away from the axis.
    pub cone: Option<f32>,
    /// How far centres move off their lattice, in spacings, 0 to 0.5.
    pub jitter: Option<f32>,
    /// How much sizes differ: 0.35 is between 65 % and 135 %.
    pub size_spread: Option<f32>,
    /// Another seed, another grain of the same kind; absent: that of `input`.
    pub seed: Option<u32>,
    /// Particles and normal of Li 2022, Fig. 6 to 12, as large as its model would have them.
    pub figure: Option<u32>,
    /// `fixed` (the default), or `paper`: the formulas of Li 2022 with their slips.
    pub profile: Option<String>,
    /// Where the outline does not close: `winding` (the default), `strict`, `bridge:LENGTH` or `open`.
    pub policy: Option<String>,
    /// `footprint` (the default): the caps are true relief; `none`: they are flat and only shaded.
    pub relief: Option<String>,
    /// `a` (below the cut, on the left), `b`, or `both` (the default).
    pub half: Option<String>,
    /// How a picture shows the pieces: `open` (side by side, sections to the front) or `apart` (drawn apart where they
    /// were; the default after more than one cut).
    pub layout: Option<String>,
    /// How far apart, as a share of the model's size; absent: 0.35.
    pub apart: Option<f32>,
    /// Colour between the particles.
    pub matrix: Option<String>,
    /// Colour of the particles; absent: some colours, by particle.
    pub particles: Option<String>,
}

/// From where a surface is seen.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraRecipe {
    /// `three-quarter` (the default), `front`, `back`, `left`, `right`, `top`, `bottom`; `atlas`: the surface laid flat by
    /// a UV set, cells are texels; or the name or number of a camera in the file.
    pub view: Option<String>,
    /// Degrees from the front towards the right.
    pub azimuth: Option<f32>,
    /// Degrees upward.
    pub elevation: Option<f32>,
    /// Where the eye stands, world space. Without it the camera frames the object.
    pub eye: Option<[f32; 3]>,
    /// What it looks at; absent: the middle of the object.
    pub target: Option<[f32; 3]>,
    /// Roughly upward.
    pub up: Option<[f32; 3]>,
    /// Full vertical field of view, degrees.
    pub fov: Option<f32>,
    /// Parallel lines of sight.
    pub orthographic: Option<bool>,
    /// The share of the shorter side that the object fills; above 1 crops.
    pub fill: Option<f32>,
    /// Of the view `atlas`: which UV set.
    pub uv_set: Option<u32>,
}

/// How large, in which light, before what.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PictureRecipe {
    /// Pixels across and down.
    pub size: Option<[u32; 2]>,
    /// Places looked at in each pixel: 1, 4 or 16.
    pub samples: Option<u32>,
    /// `studio`, `headlight`, `outdoor`, `flat`, or `file` for the file's own lights.
    pub light: Option<String>,
    /// The surroundings that light the scene: a panorama (equirectangular image), a cube in one picture (strip or cross,
    /// told by its proportions), a list of six faces (+X, -X, +Y, -Y, +Z, -Z), or `sample:NAME`.
    pub environment: Option<Words>,
    /// How one picture holds the surroundings: `panorama`, `vertical-strip`, `horizontal-strip`, `vertical-cross`,
    /// `horizontal-cross`.
    pub environment_layout: Option<String>,
    /// Of the background `environment`: 0 sharp to 1 a wash of light.
    pub environment_blur: Option<f32>,
    /// `light`, `studio`, `white`, `dark`, `transparent`, `environment` (what lights the scene), or a colour `#rrggbb`.
    pub background: Option<String>,
    /// A soft contact shadow on an endless floor.
    pub ground: Option<bool>,
    /// `filmic` or `plain`.
    pub develop: Option<String>,
    /// Stops; each doubles the light.
    pub exposure: Option<f32>,
    /// Colours as they are, whatever the light.
    pub unlit: Option<bool>,
    /// Light from everywhere beside `lights`: 1 shows a matte colour as it is.
    pub ambient: Option<f32>,
}

/// What surfaces are like before the layers. Each key replaces what the file says.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SurfaceRecipe {
    /// Leave the file's materials and their textures out: clay.
    pub plain: Option<bool>,
    /// Base colour `#rrggbb`; takes the place of the file's colour texture, too.
    pub color: Option<String>,
    /// Opacity, 0 to 1; below 1 the surface is seen through.
    pub alpha: Option<f32>,
    /// 0 mirror to 1 chalk.
    pub roughness: Option<f32>,
    /// 0 dielectric to 1 metal.
    pub metalness: Option<f32>,
    /// `metal-rough`, `blinn-phong`, `lambert`, `unlit`, or `gouraud`: Blinn-Phong at the vertices, for comparison.
    pub shading: Option<String>,
    /// Strength of Blinn-Phong's highlight.
    pub specular: Option<f32>,
    /// Its sharpness.
    pub exponent: Option<f32>,
    /// What alpha means: `opaque`, `blend`, or `mask` (there where it is at least `cutoff`).
    pub alpha_mode: Option<String>,
    /// Of `mask`.
    pub cutoff: Option<f32>,
    /// Whether back faces are seen.
    pub double_sided: Option<bool>,
    /// Whether vertex colours count.
    pub vertex_colors: Option<bool>,
}

/// A light.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LightRecipe {
    /// `directional`, `point`, `spot` or `headlight`.
    pub kind: Option<String>,
    /// Towards the light (directional), or the way a spot points; world space, any length.
    pub direction: Option<[f32; 3]>,
    /// Where a point or spot light stands, world space.
    pub position: Option<[f32; 3]>,
    /// `#rrggbb`.
    pub color: Option<String>,
    /// Multiplies the colour; of lights with a position, brightness at one model unit.
    pub intensity: Option<f32>,
    /// Sine of its angular radius: 0 a point, 1 half the sky.
    pub size: Option<f32>,
    /// Inner and outer half angle of a spot, degrees.
    pub cone: Option<[f32; 2]>,
}

/// What says what the colours stand for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LegendRecipe {
    /// `right` (the default where a layer has a table), `left`, `bottom` or `none`.
    pub place: Option<String>,
    /// In place of the field's name.
    pub title: Option<String>,
    /// `auto`, `plain`, `si` (k, M, µ) or `engineering` (powers of a thousand).
    pub notation: Option<String>,
    /// Write the values on the major isolines.
    pub line_labels: Option<bool>,
}

/// What is written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Output {
    /// The picture: `.png` (8 bits) or `.exr` (linear light with alpha).
    pub picture: Option<String>,
    /// The legend alone: `.png` or `.svg`.
    pub legend: Option<String>,
    /// The information buffer: `.exr`, `.npz`, or `.npy` (triangle ids alone).
    pub info_buffer: Option<String>,
    /// Each pixel's texel address, coded as colour: `.png`.
    pub info_texture: Option<String>,
    /// How addresses are coded: `paper10`, `rgb12` or `wide`.
    pub coding: Option<String>,
    /// Texels across and down that addresses count; absent: those of the base colour texture.
    pub info_size: Option<[u32; 2]>,
}

/// How the camera walks around the object, and what else moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TurntableRecipe {
    /// How many pictures; absent: 36.
    pub frames: Option<u32>,
    /// Pictures a second; absent: 12.
    pub fps: Option<f32>,
    /// How far, degrees; absent: once around, 360, or 0 when something else moves. Below zero the other way.
    pub turn: Option<f32>,
    /// The first table's range moves from the one to the other.
    pub watch_range: Option<[[f64; 2]; 2]>,
    /// The `level` of the first isolines moves from the one to the other: all lines wander.
    pub watch_level: Option<[f64; 2]>,
    /// The cut's `at` moves from the one to the other.
    pub watch_cut: Option<[f64; 2]>,
}

/// Where the gallery's page puts a picture, and what it stands beside.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GalleryPlace {
    /// Place within its topic; smaller is earlier.
    pub order: Option<i64>,
    /// Pictures that share this name stand in one strip, for comparison.
    pub strip: Option<String>,
    /// The label under the panel of a strip.
    pub label: Option<String>,
    /// A well-known file that `impasto gallery --models` shows in place of the input, if it finds it.
    pub model: Option<String>,
    /// At the head of the page.
    pub hero: Option<bool>,
    /// Show it as small as it is, each pixel a square: for what happens between pixels.
    pub pixels: Option<bool>,
    /// How much larger than it is the page shows it; absent: 3.
    pub enlarge: Option<u32>,
    /// What the page shows instead of the picture: `info-texture`.
    pub show: Option<String>,
}
