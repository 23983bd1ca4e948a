//! Values that several commands take.

use anyhow::{Context, Result, bail};
use impasto::math::Size;
use impasto::recipe::layer::{Numbers, Words};
use impasto::recipe::{LayerRecipe, Recipe};

/// WIDTHxHEIGHT.
pub(crate) fn size(text: &str) -> Result<Size, String> {
    let (w, h) = text.split_once(['x', 'X']).ok_or("write it as WIDTHxHEIGHT, such as 1280x720")?;
    let n = |s: &str| s.trim().parse::<u32>().ok().filter(|n| (1..=32768).contains(n));
    let pair = n(w).zip(n(h)).ok_or("both numbers must be between 1 and 32768")?;
    Ok(Size::new(pair.0, pair.1))
}

/// X,Y,Z.
fn triple(text: &str) -> Result<[f32; 3], String> {
    let numbers: Vec<f32> =
        text.split(',').filter_map(|s| s.trim().parse().ok()).filter(|x: &f32| x.is_finite()).collect();
    numbers.try_into().map_err(|_| "write three numbers, such as 1,2.5,-3".into())
}

fn layer(text: &str) -> Result<LayerRecipe, String> {
    LayerRecipe::parse_inline(text).map_err(|e| e.to_string())
}

/// What is shown, from where, in which light: the same for every command that looks at something.
#[derive(clap::Args)]
pub(crate) struct Look {
    /// A mesh (obj, ply, stl, off, gltf, glb, vtk, vtp, vtu, gii, three.js json), a height map (asc, dem, npy, npz, 16-bit
    /// png or tif), each also as .gz, or sample:NAME.
    #[arg(value_name = "FILE", required = true)]
    pub(crate) files: Vec<String>,

    /// three-quarter, front, back, left, right, top, bottom; AZIMUTH,ELEVATION in degrees; atlas (the surface laid flat);
    /// or a camera of the file, by name or number.
    #[arg(long, value_name = "VIEW", allow_hyphen_values = true, help_heading = "View")]
    camera: Option<String>,
    /// Where the eye stands.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, help_heading = "View")]
    eye: Option<[f32; 3]>,
    /// What it looks at; absent: the middle of the object.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, help_heading = "View")]
    target: Option<[f32; 3]>,
    /// Vertical field of view, degrees.
    #[arg(long, value_name = "DEGREES", help_heading = "View")]
    fov: Option<f32>,
    /// Parallel lines of sight.
    #[arg(long, help_heading = "View")]
    orthographic: bool,
    /// Share of the picture's shorter side that the object fills.
    #[arg(long, value_name = "SHARE", help_heading = "View")]
    fill: Option<f32>,
    /// Of the view `atlas`: which UV set.
    #[arg(long, value_name = "N", help_heading = "View")]
    uv_set: Option<u32>,

    /// Pixels across and down.
    #[arg(long, value_name = "WxH", value_parser = size, help_heading = "Picture")]
    size: Option<Size>,
    /// Samples a pixel, for smooth edges: 1, 4 or 16.
    #[arg(long, value_name = "N", help_heading = "Picture")]
    samples: Option<u32>,
    /// studio, headlight, outdoor, flat, or file (the file's own lights).
    #[arg(long, value_name = "NAME", help_heading = "Picture")]
    light: Option<String>,
    /// What lights the scene: a panorama, a cube in one picture (strip or cross), or its six faces with commas between.
    #[arg(long, value_name = "IMAGE", help_heading = "Picture")]
    environment: Option<String>,
    /// How that picture holds the surroundings, if its proportions do not tell: panorama, vertical-strip, horizontal-strip,
    /// vertical-cross, horizontal-cross.
    #[arg(long, value_name = "NAME", requires = "environment", help_heading = "Picture")]
    environment_layout: Option<String>,
    /// Of the background `environment`: 0 sharp to 1 a wash of light.
    #[arg(long, value_name = "SHARE", requires = "environment", help_heading = "Picture")]
    environment_blur: Option<f32>,
    /// light, studio, white, dark, transparent, environment, or a colour like #f4f3f0.
    #[arg(long, value_name = "NAME", help_heading = "Picture")]
    background: Option<String>,
    /// A soft contact shadow on a floor.
    #[arg(long, help_heading = "Picture")]
    ground: bool,
    /// filmic or plain.
    #[arg(long, value_name = "CURVE", help_heading = "Picture")]
    develop: Option<String>,
    /// Stops brighter (or darker); each doubles the light.
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, help_heading = "Picture")]
    exposure: Option<f32>,
    /// Colours as they are, under no light.
    #[arg(long, help_heading = "Picture")]
    unlit: bool,

    /// An image in place of the base colour; sample:NAME for a built-in one.
    #[arg(long, value_name = "IMAGE", help_heading = "Surface")]
    texture: Option<String>,
    /// A layer over the materials: "SOURCE key=value ...", see the examples. May be repeated.
    #[arg(long = "layer", value_name = "LAYER", value_parser = layer, help_heading = "Surface")]
    layers: Vec<LayerRecipe>,
    /// A picture of a lit ball that gives colour and light at once.
    #[arg(long, value_name = "IMAGE", help_heading = "Surface")]
    matcap: Option<String>,
    /// Colours for the values of a field: NAME, NAME.x, NAME.mag, NAME@faces; `impasto info FILE` names them. Or of a file of
    /// values on a 3-D grid (cube, dx, mrc, nrrd), read at every pixel's surface point.
    #[arg(long, value_name = "FIELD", group = "coloring", help_heading = "Data")]
    pub(crate) color_by: Option<String>,
    /// Read grids this far outside of the surface, model units.
    #[arg(long, value_name = "DISTANCE", allow_hyphen_values = true, help_heading = "Data")]
    grid_offset: Option<f64>,
    /// The colour table: viridis, batlow, vik, cividis and more (docs/tables.md), _r behind it turns it round; or a file.
    #[arg(long, value_name = "NAME", requires = "coloring", help_heading = "Data")]
    table: Option<String>,
    /// The values at the table's ends, LEAST,GREATEST, or percentiles like 2%,98%; absent: the field's own.
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true, requires = "coloring", help_heading = "Data")]
    range: Option<String>,
    /// Widen the range so that this value is in its middle.
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true, requires = "coloring", help_heading = "Data")]
    center: Option<f64>,
    /// linear, log or symlog.
    #[arg(long, value_name = "SCALE", requires = "coloring", help_heading = "Data")]
    scale: Option<String>,
    /// As many colours, each over an equal part of the scale.
    #[arg(long, value_name = "N", requires = "coloring", help_heading = "Data")]
    bands: Option<u32>,
    /// The table from its end.
    #[arg(long, requires = "coloring", help_heading = "Data")]
    reverse: bool,
    /// Colours of values below the range, above it, and of missing values.
    #[arg(long, value_name = "BELOW,ABOVE,MISSING", requires = "coloring", help_heading = "Data")]
    outside: Option<String>,
    /// What a missing value takes from its triangles: nearest (the part next to it), fan (all), or hatch: the nearest part,
    /// filled with lines.
    #[arg(long, value_name = "MODE", requires = "coloring", help_heading = "Data")]
    missing_as: Option<String>,
    /// Colours looked up at the vertices and interpolated, as Gouraud had it: for comparison.
    #[arg(long, requires = "coloring", help_heading = "Data")]
    gouraud: bool,
    /// What the legend calls the values.
    #[arg(long, value_name = "TEXT", requires = "coloring", help_heading = "Data")]
    label: Option<String>,
    /// Their unit.
    #[arg(long, value_name = "TEXT", requires = "coloring", help_heading = "Data")]
    unit: Option<String>,
    /// Lines of equal value: the step between them, several values with commas, or auto.
    #[arg(long, value_name = "STEP|V1,V2,...", allow_hyphen_values = true, help_heading = "Data")]
    isolines: Option<String>,
    /// The field whose lines they are; absent: that of --color-by.
    #[arg(long, value_name = "FIELD", requires = "isolines", help_heading = "Data")]
    isolines_of: Option<String>,
    /// Do not write their values on them.
    #[arg(long, requires = "isolines", help_heading = "Data")]
    isolines_bare: bool,
    /// Their width, pixels; major ones are twice as wide.
    #[arg(long, value_name = "PIXELS", requires = "isolines", help_heading = "Data")]
    isolines_width: Option<f32>,
    /// Their colour.
    #[arg(long, value_name = "COLOR", requires = "isolines", help_heading = "Data")]
    isolines_color: Option<String>,
    /// Lay a colour over values that do not reach a threshold: "FIELD>VALUE", "FIELD<VALUE" or "FIELD=LEAST..MOST" says what
    /// is kept; "~DISTANCE" after it makes the edge soft.
    #[arg(long, value_name = "TEST", help_heading = "Data")]
    filter: Option<String>,
    /// What --filter lays over.
    #[arg(long, value_name = "COLOR", requires = "filter", help_heading = "Data")]
    filter_color: Option<String>,
    /// Cut away what a test like that of --filter does not keep.
    #[arg(long, value_name = "TEST", help_heading = "Data")]
    cut: Option<String>,
    /// See through low values: "FIELD=FROM..TO" is clear at FROM, opaque at TO.
    #[arg(long, value_name = "TEST", help_heading = "Data")]
    opacity: Option<String>,
    /// Where the legend stands: right (the default with --color-by), left, bottom or none.
    #[arg(long, value_name = "PLACE", help_heading = "Data")]
    legend: Option<String>,
    /// A chart in place of the textures, to see the layout.
    #[arg(long, help_heading = "Surface")]
    uv_check: bool,
    /// Leave the file's materials out: clay.
    #[arg(long, help_heading = "Surface")]
    clay: bool,
    /// One base colour, like #c06040.
    #[arg(long, value_name = "COLOR", help_heading = "Surface")]
    color: Option<String>,
    /// 0 mirror to 1 chalk.
    #[arg(long, value_name = "0..1", help_heading = "Surface")]
    roughness: Option<f32>,
    /// 0 dielectric to 1 metal.
    #[arg(long, value_name = "0..1", help_heading = "Surface")]
    metalness: Option<f32>,
    /// metal-rough, blinn-phong, lambert, unlit, or safe: data are lit so that their colours can still be read (the default
    /// with --color-by).
    #[arg(long, value_name = "MODEL", help_heading = "Surface")]
    shading: Option<String>,

    /// The file's axis that points up: auto, y or z.
    #[arg(long, value_name = "AXIS", help_heading = "Input")]
    up: Option<String>,
    /// Values of another file as fields: a column of a table or array (csv, tsv, txt, npy, npz), or data of gii, vtk, vtp,
    /// vtu, ply; row by row, of rows A to B alone with @rows=A..B, or by @id=COLUMN. May be repeated.
    #[arg(long = "field", value_name = "FILE[:COLUMN]", help_heading = "Input")]
    fields: Vec<String>,
    /// Of grids: the value whose isosurface is shown; without it one that suits the values.
    #[arg(long, value_name = "VALUE", help_heading = "Input", allow_negative_numbers = true)]
    isolevel: Option<f64>,
    /// Lay the surface out anew, for a mesh without texture coordinates.
    #[arg(long, help_heading = "Input")]
    unwrap: bool,
    /// Of samples: how fine the surface is.
    #[arg(long, value_name = "N", help_heading = "Input")]
    resolution: Option<u32>,
    /// Of samples and noise: another seed is another one of the same kind.
    #[arg(long, value_name = "N", help_heading = "Input")]
    seed: Option<u32>,
}

impl Look {
    /// The same as a recipe, of a command that looks at one thing.
    pub(crate) fn recipe(&self) -> Result<Recipe> {
        match self.files.as_slice() {
            [file] => self.recipe_of(file, self.color_by.as_deref()),
            files => bail!("{} files are too many here: name one", files.len()),
        }
    }

    /// The same as a recipe that shows one of the files, coloured by a field.
    pub(crate) fn recipe_of(&self, file: &str, color_by: Option<&str>) -> Result<Recipe> {
        let mut recipe = Recipe::default();
        let yes = |flag: bool| flag.then_some(true);

        let input = &mut recipe.input;
        input.file = Some(file.to_owned());
        input.resolution = self.resolution;
        input.seed = self.seed;
        input.up.clone_from(&self.up);
        input.isolevel = self.isolevel;
        input.texture.clone_from(&self.texture);
        input.unwrap = yes(self.unwrap);
        input.fields.clone_from(&self.fields);

        let camera = &mut recipe.camera;
        match self.camera.as_deref().map(|c| (c, c.split_once(','))) {
            None => {}
            Some((_, Some((azimuth, elevation)))) => match (azimuth.trim().parse(), elevation.trim().parse()) {
                (Ok(a), Ok(e)) => (camera.azimuth, camera.elevation) = (Some(a), Some(e)),
                _ => {
                    bail!("camera {azimuth},{elevation} is not possible: azimuth and elevation are degrees, like 35,20")
                }
            },
            Some((name, None)) => camera.view = Some(name.into()),
        }
        camera.eye = self.eye;
        camera.target = self.target;
        camera.fov = self.fov;
        camera.orthographic = yes(self.orthographic);
        camera.fill = self.fill;
        camera.uv_set = self.uv_set;

        let picture = &mut recipe.picture;
        picture.size = self.size.map(|s| [s.width, s.height]);
        picture.samples = self.samples;
        picture.light.clone_from(&self.light);
        picture.environment = self.environment.as_deref().map(|given| match given.split(',').collect::<Vec<_>>() {
            faces if faces.len() == 6 => Words::Each(faces.into_iter().map(|f| f.trim().to_owned()).collect()),
            _ => Words::One(given.to_owned()),
        });
        picture.environment_layout.clone_from(&self.environment_layout);
        picture.environment_blur = self.environment_blur;
        picture.background.clone_from(&self.background);
        picture.ground = yes(self.ground);
        picture.develop.clone_from(&self.develop);
        picture.exposure = self.exposure;
        picture.unlit = yes(self.unlit);

        let surface = &mut recipe.surface;
        surface.plain = yes(self.clay);
        surface.color.clone_from(&self.color);
        surface.roughness = self.roughness;
        surface.metalness = self.metalness;
        surface.shading = self.shading.clone().filter(|s| s != "safe");

        self.short_forms(&mut recipe, color_by)?;
        recipe.layers.extend(self.layers.iter().cloned());
        Ok(recipe)
    }

    /// Flags that stand for a layer.
    fn short_forms(&self, recipe: &mut Recipe, color_by: Option<&str>) -> Result<()> {
        let text = |s: &str| Some(s.to_owned());
        if let Some(image) = &self.matcap {
            recipe.surface.shading = text("unlit");
            recipe.layers.push(LayerRecipe {
                image: Some(image.clone()),
                coordinate: text("view-normal"),
                operator: text("replace"),
                wrap: Some(Words::One("clamp-to-edge".into())),
                ..LayerRecipe::default()
            });
        }
        if self.uv_check {
            recipe.layers.push(LayerRecipe {
                image: text("sample:uv-grid"),
                operator: text("replace"),
                ..LayerRecipe::default()
            });
        }
        self.data(recipe, color_by)
    }

    /// Flags that show fields.
    fn data(&self, recipe: &mut Recipe, color_by: Option<&str>) -> Result<()> {
        let text = |s: &str| Some(s.to_owned());
        let yes = |flag: bool| flag.then_some(true);
        // Labels carry their own colours.
        if let Some(field) = color_by.filter(|f| f.ends_with(".color")) {
            recipe.layers.push(LayerRecipe {
                carried: text(field),
                operator: text("replace"),
                ..LayerRecipe::default()
            });
        }
        let color_by = color_by.filter(|f| !f.ends_with(".color"));
        let is_safe =
            color_by.is_some() && self.shading.as_deref().is_none_or(|s| s == "safe") && !self.unlit && !self.gouraud;
        if let Some(field) = color_by {
            if is_safe {
                recipe.surface.shading = text("unlit");
            } else {
                recipe.surface.shading = recipe.surface.shading.take().or(text("lambert"));
            }
            let (range, percentiles) = match self.range.as_deref() {
                None => (None, None),
                Some(given) => match given.contains('%') {
                    true => (None, Some(two(&given.replace('%', ""), ",").context("a range is 0,10 or 2%,98%")?)),
                    false => (Some(two(given, ",").context("a range is 0,10 or 2%,98%")?), None),
                },
            };
            let mut outside = self.outside.iter().flat_map(|o| o.split(',')).map(|c| text(c).filter(|c| !c.is_empty()));
            recipe.layers.push(LayerRecipe {
                table: self.table.clone().or(text("viridis")),
                field: text(field),
                range,
                percentiles,
                center: self.center,
                value_scale: self.scale.clone(),
                bands: self.bands,
                reversed: yes(self.reverse),
                below: outside.next().flatten(),
                above: outside.next().flatten(),
                missing: outside.next().flatten(),
                missing_mode: self.missing_as.clone(),
                shades: yes(is_safe),
                gouraud: yes(self.gouraud),
                label: self.label.clone(),
                unit_label: self.unit.clone(),
                ..LayerRecipe::default()
            });
        } else if self.shading.as_deref() == Some("safe") {
            bail!("shading safe is for the colours of --color-by");
        }
        if let Some(test) = &self.filter {
            recipe.layers.push(LayerRecipe { color: self.filter_color.clone(), shades: yes(is_safe), ..kept(test)? });
        }
        if let Some(given) = &self.isolines {
            let field = self.isolines_of.clone().or_else(|| color_by.map(str::to_owned));
            let field = field.context("isolines of what? --isolines-of FIELD says so")?;
            let numbers: Vec<f64> = match given.as_str() {
                "auto" => Vec::new(),
                _ => given.split(',').map(|v| v.trim().parse()).collect::<Result<_, _>>().with_context(|| {
                    format!("isolines {given:?} are not possible: a step, several values with commas, or auto")
                })?,
            };
            recipe.layers.push(LayerRecipe {
                isolines: Some(if numbers.len() == 1 { numbers[0] } else { 0.0 }),
                levels: (numbers.len() > 1).then_some(numbers),
                field: Some(field),
                width: self.isolines_width,
                color: self.isolines_color.clone(),
                ..LayerRecipe::default()
            });
        }
        if let Some(test) = &self.cut {
            recipe.layers.push(LayerRecipe { target: text("alpha"), ..kept(test)? });
        }
        if let Some(test) = &self.opacity {
            let (field, ends) = test.split_once('=').context("opacity is FIELD=FROM..TO")?;
            let [from, to] = two(ends, "..").context("opacity is FIELD=FROM..TO")?;
            recipe.layers.push(LayerRecipe {
                filter: text(if from < to { "above" } else { "below" }),
                field: text(field.trim()),
                threshold: Some(Numbers::One(to as f32)),
                softness: Some((to - from).abs()),
                target: text("alpha"),
                ..LayerRecipe::default()
            });
        }
        for layer in recipe.layers.iter_mut().filter(|l| l.is_data()) {
            if let Some(file) = layer.field.take_if(|f| is_grid(f)) {
                (layer.grid, layer.grid_offset) = (Some(file), self.grid_offset);
            }
        }
        recipe.legend.place.clone_from(&self.legend);
        recipe.legend.line_labels = (self.isolines.is_some() && !self.isolines_bare).then_some(true);
        Ok(())
    }
}

/// Whether a name is that of a file of values on a grid.
fn is_grid(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let bare = name.strip_suffix(".gz").unwrap_or(&name);
    ["cube", "dx", "mrc", "map", "ccp4", "nrrd"].iter().any(|kind| bare.ends_with(&format!(".{kind}")))
}

/// Two numbers with a sign between them.
pub(crate) fn two(text: &str, sign: &str) -> Result<[f64; 2]> {
    match text.split(sign).collect::<Vec<_>>()[..] {
        [a, b] => Ok([a.trim().parse()?, b.trim().parse()?]),
        _ => bail!("{text:?} are not two numbers"),
    }
}

/// The filter layer of a test like `FIELD>3`, `FIELD<3`, `FIELD=1..2`, with `~DISTANCE` after it.
fn kept(test: &str) -> Result<LayerRecipe> {
    let why = || format!("{test:?} is no test: FIELD>VALUE, FIELD<VALUE or FIELD=LEAST..MOST, and ~DISTANCE after it");
    let (test, softness) = match test.rsplit_once('~') {
        Some((test, soft)) => (test, Some(soft.trim().parse().with_context(why)?)),
        None => (test, None),
    };
    let sign = test.rfind(['>', '<', '=']).with_context(why)?;
    let (field, value) = (test[..sign].trim(), test[sign + 1..].trim());
    let number = |v: &str| v.trim().parse::<f32>().with_context(why);
    let (filter, threshold) = match &test[sign..=sign] {
        ">" => ("above", Numbers::One(number(value)?)),
        "<" => ("below", Numbers::One(number(value)?)),
        _ => {
            let (least, most) = value.split_once("..").with_context(why)?;
            ("within", Numbers::Each(vec![number(least)?, number(most)?]))
        }
    };
    Ok(LayerRecipe {
        filter: Some(filter.into()),
        field: Some(field.into()),
        threshold: Some(threshold),
        softness,
        ..LayerRecipe::default()
    })
}
