//! Values that several commands take.

use anyhow::{Result, bail};
use impasto::math::Size;
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

/// A,B.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> =
        text.split(',').filter_map(|s| s.trim().parse().ok()).filter(|x: &f64| x.is_finite()).collect();
    numbers.try_into().map_err(|_| "write two numbers, such as 0,100".into())
}

fn layer(text: &str) -> Result<LayerRecipe, String> {
    LayerRecipe::parse_inline(text).map_err(|e| e.to_string())
}

/// What is shown, from where, in which light: the same for every command that looks at something.
#[derive(clap::Args)]
pub(crate) struct Look {
    /// A mesh (obj, ply, stl, off, gltf, glb), a height map (asc, dem, npy, npz, 16-bit png or tif), or sample:NAME.
    #[arg(value_name = "FILE")]
    file: String,

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
    /// A panorama image that lights the scene.
    #[arg(long, value_name = "IMAGE", help_heading = "Picture")]
    environment: Option<String>,
    /// light, studio, white, dark, transparent, or a colour like #f4f3f0.
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
    /// Colours for the values of a field; `impasto info FILE` names them.
    #[arg(long, value_name = "FIELD", help_heading = "Surface")]
    color_by: Option<String>,
    /// The colour table: viridis, grey or coolwarm.
    #[arg(long, value_name = "NAME", requires = "color_by", help_heading = "Surface")]
    table: Option<String>,
    /// The values at the table's ends; absent: the field's own.
    #[arg(long, value_name = "LEAST,GREATEST", value_parser = pair, allow_hyphen_values = true, requires = "color_by", help_heading = "Surface")]
    range: Option<[f64; 2]>,
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
    /// metal-rough, blinn-phong, lambert or unlit.
    #[arg(long, value_name = "MODEL", help_heading = "Surface")]
    shading: Option<String>,

    /// The file's axis that points up: auto, y or z.
    #[arg(long, value_name = "AXIS", help_heading = "Input")]
    up: Option<String>,
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
    /// The same as a recipe.
    pub(crate) fn recipe(&self) -> Result<Recipe> {
        let mut recipe = Recipe::default();
        let yes = |flag: bool| flag.then_some(true);

        let input = &mut recipe.input;
        input.file = Some(self.file.clone());
        input.resolution = self.resolution;
        input.seed = self.seed;
        input.up.clone_from(&self.up);
        input.texture.clone_from(&self.texture);
        input.unwrap = yes(self.unwrap);

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
        picture.environment.clone_from(&self.environment);
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
        surface.shading.clone_from(&self.shading);

        self.short_forms(&mut recipe);
        recipe.layers.extend(self.layers.iter().cloned());
        Ok(recipe)
    }

    /// Flags that stand for a layer.
    fn short_forms(&self, recipe: &mut Recipe) {
        let text = |s: &str| Some(s.to_owned());
        if let Some(image) = &self.matcap {
            recipe.surface.shading = text("unlit");
            recipe.layers.push(LayerRecipe {
                image: Some(image.clone()),
                coordinate: text("view-normal"),
                operator: text("replace"),
                wrap: Some(impasto::recipe::layer::Words::One("clamp-to-edge".into())),
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
        if let Some(field) = &self.color_by {
            recipe.surface.shading = recipe.surface.shading.take().or(text("lambert"));
            recipe.layers.push(LayerRecipe {
                table: self.table.clone().or(text("viridis")),
                field: Some(field.clone()),
                range: self.range,
                ..LayerRecipe::default()
            });
        }
    }
}
