//! A layer, written down: where its coordinate comes from, which texture it reads, and what the answer does.

use crate::error::{Error, Result};
use crate::recipe::text::one_line;
use serde::{Deserialize, Serialize};

/// One layer of a recipe. Also written in one line, `SOURCE key=value ...`: see [`LayerRecipe::parse_inline`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LayerRecipe {
    // What it reads: one of the next seven.
    /// An image: a file beside the recipe, `sample:NAME`, or `lights`: a ball in the picture's own light, for the coordinate
    /// `view-normal` (its default) on an unlit surface.
    pub image: Option<String>,
    /// A formula: `stripes`, `checker`, `noise`, `cells`, `wood`, `marble`.
    pub procedural: Option<String>,
    /// A colour table over a field: a name like `viridis`, `batlow`, `vik` (`_r` behind it turns it round), or a file.
    pub table: Option<String>,
    /// A field that holds colours - three or four numbers a value, linear light - and shows them as they are.
    pub carried: Option<String>,
    /// Lines of equal value of a field: the step from line to line; 0: only the `levels`.
    pub isolines: Option<f64>,
    /// Hides by the values of a field: `above`, `below` or `within` say which are kept.
    pub filter: Option<String>,
    /// Six faces of a cube (+X, -X, +Y, -Y, +Z, -Z), one picture of all six, or `sample:NAME`; a volume's slices, front to
    /// back.
    pub images: Option<Vec<String>>,
    /// Of a cube in one picture: `vertical-strip`, `horizontal-strip`, `vertical-cross`, `horizontal-cross`; absent: by its
    /// proportions.
    pub layout: Option<String>,
    /// Of samples: texels along an edge.
    pub texels: Option<u32>,
    /// Of `images`: `cube` or `volume`.
    pub shape: Option<String>,

    // Of procedural textures.
    /// Colours of 0 and of 1, `#rrggbb` or `#rrggbbaa`.
    pub colors: Option<[String; 2]>,
    /// Features in one unit of the coordinate.
    pub frequency: Option<f32>,
    /// Share of a stripe, bend of wood and marble, number of octaves of noise.
    pub shape_factor: Option<f32>,
    /// Another seed is another texture of the same kind.
    pub seed: Option<u32>,

    // Of colour tables, isolines and filters.
    /// The field: `NAME`, with `.x` `.y` `.z` or `.0` `.1` ... for a component, `.mag` for the vector's length, and `@vertices`,
    /// `@faces` or `@corners` where two fields share a name.
    pub field: Option<String>,
    /// Which of its components, from 0; absent: the only one, or the vector's length.
    pub component: Option<u32>,
    /// `nearest`: a missing value leaves the part of its triangles out that is nearest to it; `fan`: all of them; `hatch`: as
    /// `nearest`, filled with lines.
    pub missing_mode: Option<String>,

    /// In place of a field: a file of values on a 3-D grid (cube, dx, mrc, nrrd), read at every pixel's surface point.
    pub grid: Option<String>,
    /// Of `grid`: how far outside of the surface it is read, along the normal, model units.
    pub grid_offset: Option<f64>,

    // Of colour tables.
    /// The values at the table's ends, in either order; absent: those of the table's file, or the field's least and
    /// greatest.
    pub range: Option<[f64; 2]>,
    /// In place of a range: these percentiles of the field's values.
    pub percentiles: Option<[f64; 2]>,
    /// Widen the range so that this value is in its middle.
    pub center: Option<f64>,
    /// `linear`, `log`, or `symlog`, which is linear up to `linear_up_to` (absent: a hundredth of the range).
    pub value_scale: Option<String>,
    /// Of `symlog`.
    pub linear_up_to: Option<f64>,
    /// As many colours, each over an equal part of the scale.
    pub bands: Option<u32>,
    /// The table from its end.
    pub reversed: Option<bool>,
    /// Colour of values before the range; absent: the table's first.
    pub below: Option<String>,
    /// Colour of values beyond the range; absent: the table's last.
    pub above: Option<String>,
    /// Colour of missing values.
    pub missing: Option<String>,
    /// Shade so that every colour is still read as its value. For unlit surfaces.
    pub shades: Option<bool>,
    /// Colours are looked up at the vertices and interpolated, as Gouraud had it: for comparison.
    pub gouraud: Option<bool>,
    /// What the legend calls it; absent: the field's name.
    pub label: Option<String>,
    /// Its unit; absent: what the file says.
    pub unit_label: Option<String>,

    // Of isolines.
    /// Values that have a line, in place of even steps.
    pub levels: Option<Vec<f64>>,
    /// One of the even levels; absent: 0.
    pub level: Option<f64>,
    /// In pixels.
    pub width: Option<f32>,
    /// Each n-th line is a major one, 0: none; absent: each fifth.
    pub major: Option<u32>,

    // Of filters.
    /// The value to be reached, or for `within` the two ends.
    pub threshold: Option<Numbers>,
    /// From where on nothing is left: values fade away over this distance.
    pub softness: Option<f64>,

    // Of images.
    /// `repeat`, `mirrored-repeat`, `clamp-to-edge`, `clamp-to-border`: for all coordinates, or a list for s, t, r.
    pub wrap: Option<Words>,
    /// Where a texel covers more than a pixel: `nearest` or `linear`.
    pub mag: Option<String>,
    /// Where a pixel covers more than a texel: `nearest`, `linear`, `nearest-mipmap-nearest`, `linear-mipmap-nearest`,
    /// `nearest-mipmap-linear`, `linear-mipmap-linear`.
    pub min: Option<String>,
    /// Most taps along the footprint's longer axis, 1 to 16.
    pub anisotropy: Option<u8>,
    /// Which components the texture means to have: `alpha`, `luminance`, `luminance-alpha`, `intensity`, `rgb`, `rgba`.
    pub format: Option<String>,
    /// What the texels mean: `color`, `data`, `normal`, `slope`, `label`; absent: what the target asks for.
    pub usage: Option<String>,

    // Where the coordinate comes from.
    /// `uv`, `object-linear`, `eye-linear`, `world-linear`, `sphere-map`, `reflection-map`, `normal-map`, `view-normal`,
    /// `panorama`, `planar`, `cylindrical`, `spherical`, `box`, `camera`, `two-part`, `field`, `position`.
    pub coordinate: Option<String>,
    /// Of `uv`: a set's name or number.
    pub uv_set: Option<String>,
    /// Of the linear ones: planes `[a, b, c, d]` for s, t, r.
    pub planes: Option<Vec<[f32; 4]>>,
    /// Of `reflection-map`, `normal-map`, `panorama`: `world` or `eye`.
    pub space: Option<String>,
    /// Of `panorama`: `reflection`, `normal` or `position`.
    pub direction: Option<String>,
    /// Of projections: the way their front looks, world space.
    pub front: Option<[f32; 3]>,
    /// Of projections: roughly upward.
    pub up: Option<[f32; 3]>,
    /// Of projections: their middle; absent: that of the object.
    pub origin: Option<[f32; 3]>,
    /// Of projections: width, height and depth of the picture, model units; absent: those of the object.
    pub extent: Option<[f32; 3]>,
    /// Of `camera`: where the projector stands.
    pub eye: Option<[f32; 3]>,
    /// Of `camera`: what the projector points at.
    pub aim: Option<[f32; 3]>,
    /// Of `camera`: full vertical field of view, degrees.
    pub fov: Option<f32>,
    /// Of `two-part`: `plane`, `cylinder`, `sphere` or `box`.
    pub surface: Option<String>,
    /// Of `two-part`: `reflected-ray`, `object-normal`, `centroid` or `surface-normal`.
    pub ray: Option<String>,
    /// Of `position`: `model` units or `bounds` (the longest edge of the object is 1).
    pub unit: Option<String>,

    /// Coordinates worked out at the vertices and interpolated, as old machines did it, for comparison; of a cube by
    /// `reflection-map` or `normal-map`: each triangle on one of the six pictures, subdivided until it is.
    pub per_vertex: Option<bool>,

    // Its matrix, applied in this order: scale, rotate, offset; or the 16 numbers themselves.
    /// Multiplies s and t (and r).
    pub scale: Option<Numbers>,
    /// Degrees, counter-clockwise as seen on the image, about its middle.
    pub rotate: Option<f32>,
    /// Added to s and t (and r).
    pub offset: Option<Numbers>,
    /// Rows of a 4x4 matrix.
    pub matrix: Option<[[f32; 4]; 4]>,

    // What the answer does.
    /// `replace`, `modulate` (the default), `decal`, `blend`, `add`, `over`, or `alpha-test`.
    pub operator: Option<String>,
    /// Of `blend`: the environment's colour; of isolines: the lines'; of filters: what hides.
    pub color: Option<String>,
    /// Of `alpha-test`: `less`, `equal`, `less-or-equal`, `greater`, `not-equal`, `greater-or-equal` (the default) ...
    pub compare: Option<String>,
    /// Of `alpha-test`.
    pub reference: Option<f32>,
    /// `color` (the default), `alpha`, `normal`, `bump`, `roughness`, `metalness`, `occlusion`, `emission`, `coat`,
    /// `coat-roughness`, `coat-normal`, `height`, `info`.
    pub target: Option<String>,
    /// Of `normal`, `bump`, `height`: how much.
    pub amount: Option<f32>,
    /// Which channels count as red, green, blue and alpha, as four letters of `rgba01`.
    pub channels: Option<String>,
    /// 0: no effect, 1: the whole.
    pub strength: Option<f32>,
    /// Only parts whose name or material contains this.
    pub part: Option<String>,
}

/// One word, or a list of words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Words {
    /// For all.
    One(String),
    /// One each.
    Each(Vec<String>),
}

impl Words {
    /// As a list.
    pub fn list(&self) -> &[String] {
        match self {
            Self::One(word) => std::slice::from_ref(word),
            Self::Each(words) => words,
        }
    }
}

/// One number, or a list of numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Numbers {
    /// For all.
    One(f32),
    /// One each.
    Each(Vec<f32>),
}

impl Numbers {
    /// The first three, `rest` for those that are not said.
    pub(super) fn three(&self, rest: f32) -> [f32; 3] {
        match self {
            Self::One(x) => [*x; 3],
            Self::Each(v) => std::array::from_fn(|i| v.get(i).copied().unwrap_or(rest)),
        }
    }
}

impl LayerRecipe {
    /// Reads the form in one line: a source, then `key=value` words with the keys of the long form.
    ///
    /// The source is an image file, `sample:NAME`, `table:NAME` or the name of a procedural texture; lists are written with
    /// commas: `sample:bricks coordinate=cylindrical scale=4,2 operator=modulate`.
    ///
    /// # Errors
    /// `Parameter` with a guess at what was meant.
    pub fn parse_inline(text: &str) -> Result<Self> {
        let fault = |given: &str, why: String| Error::Parameter { what: "layer".into(), given: given.into(), why };
        let mut table = toml::Table::new();
        for (i, word) in words(text).into_iter().enumerate() {
            let (key, value) = match word.split_once('=') {
                Some((key, value)) => (key.replace('-', "_"), typed(value, key)),
                None if i == 0 => source(&word),
                None => return Err(fault(&word, "after the texture, words are key=value".into())),
            };
            if table.insert(key.clone(), value).is_some() {
                return Err(fault(&word, format!("{key} is said twice")));
            }
        }
        Self::deserialize(table).map_err(|e| fault(text, one_line(e.message())))
    }
}

/// Splits at blanks that are not in quotes, and takes the quotes away.
fn words(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quote = None;
    for c in text.chars() {
        match (quote, c) {
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if c == q => quote = None,
            (None, c) if c.is_whitespace() => words.push(String::new()),
            (_, c) => words.last_mut().expect("there is always one").push(c),
        }
    }
    words.retain(|w| !w.is_empty());
    words
}

fn source(word: &str) -> (String, toml::Value) {
    const PROCEDURAL: [&str; 6] = ["stripes", "checker", "noise", "cells", "wood", "marble"];
    let text = |s: &str| toml::Value::String(s.into());
    match word.strip_prefix("table:") {
        Some(name) => ("table".into(), text(name)),
        None if PROCEDURAL.contains(&word) => ("procedural".into(), text(word)),
        None if word == "isolines" => ("isolines".into(), toml::Value::Float(0.0)),
        None => ("image".into(), text(word)),
    }
}

/// A value of the type it looks like; keys that are words stay words.
fn typed(value: &str, key: &str) -> toml::Value {
    use toml::Value;
    const WORDS: [&str; 14] = [
        "image",
        "field",
        "color",
        "colors",
        "uv-set",
        "uv_set",
        "part",
        "channels",
        "label",
        "unit_label",
        "unit-label",
        "below",
        "above",
        "missing",
    ];
    let one = |v: &str| match (v.parse::<i64>(), v.parse::<f64>()) {
        _ if WORDS.contains(&key) => Value::String(v.into()),
        (Ok(i), _) => Value::Integer(i),
        (_, Ok(x)) => Value::Float(x),
        _ => Value::String(v.into()),
    };
    if key == "planes" {
        let planes = value.split('/').map(|p| Value::Array(p.split(',').map(one).collect()));
        return Value::Array(planes.collect());
    }
    match value.contains(',')
        && !matches!(key, "image" | "field" | "color" | "part" | "label" | "below" | "above" | "missing")
    {
        true => Value::Array(value.split(',').map(|v| one(v.trim())).collect()),
        false => one(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_written_in_one_line() {
        let layer =
            LayerRecipe::parse_inline("sample:bricks coordinate=cylindrical scale=4,2 operator=blend color=#ff0000");
        let wanted = LayerRecipe {
            image: Some("sample:bricks".into()),
            coordinate: Some("cylindrical".into()),
            scale: Some(Numbers::Each(vec![4.0, 2.0])),
            operator: Some("blend".into()),
            color: Some("#ff0000".into()),
            ..LayerRecipe::default()
        };
        assert_eq!(layer.unwrap(), wanted);
        let layer = LayerRecipe::parse_inline("'my file.png' scale=3 wrap=repeat,clamp-to-edge uv-set=1").unwrap();
        assert_eq!(layer.image.as_deref(), Some("my file.png"));
        assert_eq!(layer.scale, Some(Numbers::One(3.0)));
        assert_eq!(layer.wrap, Some(Words::Each(vec!["repeat".into(), "clamp-to-edge".into()])));
        assert_eq!(layer.uv_set.as_deref(), Some("1"));
        assert_eq!(LayerRecipe::parse_inline("noise frequency=3").unwrap().procedural.as_deref(), Some("noise"));
        assert_eq!(LayerRecipe::parse_inline("table:viridis field=t").unwrap().table.as_deref(), Some("viridis"));
    }

    #[test]
    fn faults_in_one_line_are_told_in_one_line() {
        let fault = |text: &str| LayerRecipe::parse_inline(text).expect_err(text).to_string();
        assert!(fault("a.png oprator=add").contains("did you mean `operator`?"), "{}", fault("a.png oprator=add"));
        assert!(fault("a.png b.png").contains("key=value"));
        assert!(fault("a.png scale=2 scale=3").contains("twice"));
        assert!(!fault("a.png anisotropy=900").contains('\n'));
    }
}
