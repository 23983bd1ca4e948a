//! A scene cut open: where the knife goes, what the grain is, and the pieces with their caps.

mod blade;
mod caps;
mod drawing;
mod layout;

pub use blade::Blade;
pub use caps::Dress;
pub use drawing::drawing;

use crate::assets::{Material, RawMesh, Scene};
use crate::error::{Error, Mended, Report, Result, note};
use crate::math::{DVec2, DVec3, Frame, Vec2, Vec3, Vec4};
use crate::par::Workers;
use crate::recipe::CutRecipe;
use crate::recipe::grain::{AxisRecipe, Body, GrainRecipe, KINDS, Leaf, Matter, Substance, library, scaled};
use crate::recipe::layer::Words;
use crate::recipe::words::{choose, choose_or, impossible};
use crate::section::cut::skin::{Depths, Skin};
use crate::section::cut::{self, CAP_NAME, Cut, Gap, Half, Policy, Relief, UV_NAME};
use crate::section::grain::figures::{Figure, figures};
use crate::section::grain::{Filling, GrainSpec, SectionKind, Side};
use crate::section::maps::CapMaps;
use blade::Ground;
use caps::{Cap, Has};
use std::path::Path;

/// A scene in pieces.
#[derive(Clone, Debug)]
pub struct Pieces {
    /// Those that have a surface, by their letters: below each cut before above it.
    pub pieces: Vec<Piece>,
    /// Where the knife went.
    pub blades: Vec<Blade>,
    /// What they are made of inside; none for plain caps.
    pub substance: Option<Substance>,
    /// What particles do.
    pub kind: SectionKind,
    /// The middle of the first section, model space; zero for curved cuts.
    pub middle: DVec3,
    /// Where the outline of a section does not close.
    pub gaps: Vec<Gap>,
    /// What became of the gaps, and other things to know.
    pub mended: Vec<Mended>,
    /// How many materials and images of the whole all pieces share; those after them are their caps'.
    n_shared: [usize; 2],
}

/// One of the pieces. Closed where the scene was.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Its surface, with a part of its own for each cap.
    pub scene: Scene,
    /// For each cut, the side it is on.
    pub sides: Vec<Side>,
    /// Maps of its caps, one for each cut that it has a cap of, if maps were asked for.
    pub maps: Vec<(usize, CapMaps)>,
}

impl Piece {
    /// `a` for below, `b` for above, one letter for each cut.
    pub fn letters(&self) -> String {
        self.sides.iter().map(|s| if *s == Side::Below { 'a' } else { 'b' }).collect()
    }
}

/// Cuts a scene as a recipe says. `seed` is the grain's where the recipe has none; grain files lie beside `base`.
///
/// # Errors
/// `Parameter` for numbers and names that cannot be, among them a plane that misses the scene; `Format` for a section that
/// does not close under the policy `strict`; what the grain file's reader says.
pub fn pieces(
    recipe: &CutRecipe,
    scene: &Scene,
    (base, seed): (&Path, u32),
    dress: Dress,
    workers: &Workers,
) -> Result<Pieces> {
    let mesh = &scene.mesh;
    if mesh.triangles().is_empty() {
        return Err(Error::Format { path: scene.name.clone().into(), fault: "it has no surface to cut".into() });
    }
    let is_flat = choose_or("relief", &recipe.relief, &[("footprint", false), ("none", true)], false)?;
    let policy = blade::policy(recipe)?;
    let blades = blade::blades(recipe, normal(recipe)?, scene)?;
    let (substance, kind) = substance(recipe, scene, (base, seed))?;
    let plain = leaf(recipe)?;

    let mut raw = mesh.clone().into_raw();
    if matches!(dress, Dress::Picture(_)) && raw.tangents.is_empty() {
        // The caps need some; maps on the outside that need good ones have brought them.
        raw.tangents = raw.normals.iter().map(|&n| Frame::about(n).tangent.extend(1.0)).collect();
    }
    let skin = Skin::of(&raw);
    let asks_depth = substance.as_ref().filter(|s| s.asks_depth());
    let depths = |blade: &Blade| match (asks_depth, blade.plane()) {
        (Some(substance), Some(plane)) => {
            let window = Ground::of(blade, &raw).window(&raw.positions);
            let size = (window.max - window.min).max_element() as f64;
            let spacing = substance.spacing as f64;
            let near = |reach, pitch| skin.near_plane(plane, &window, reach, pitch, workers);
            vec![near(3.0 * spacing, 0.25 * spacing), near(0.5 * size, size / 40.0)]
        }
        _ => Vec::new(),
    };
    let depths = blades.iter().map(depths).collect();
    let origins: Vec<DVec3> = blades.iter().map(|blade| Ground::of(blade, &raw).origin).collect();
    let middle = origins[0];
    let mut knife = Knife {
        depths,
        origins,
        name: &scene.name,
        skin,
        is_flat,
        policy,
        kind,
        dress,
        substance: substance.as_ref(),
        plain: &plain,
        n_materials: scene.materials.len() as u32,
        workers,
        gaps: Vec::new(),
        mended: Vec::new(),
    };
    let mut parts = vec![(raw, Vec::new())];
    for (k, blade) in blades.iter().enumerate() {
        let mut finer = Vec::new();
        for (raw, sides) in parts {
            let halves = knife.cut(&raw, blade, k)?;
            for (half, side) in halves.into_iter().zip([Side::Below, Side::Above]) {
                if !half.triangles.is_empty() {
                    finer.push((half, sides.iter().copied().chain([side]).collect::<Vec<_>>()));
                }
            }
        }
        parts = finer;
    }
    let pieces =
        parts.into_iter().map(|(raw, sides)| knife.finish(raw, sides, &blades, scene)).collect::<Result<Vec<_>>>()?;
    let Knife { gaps, mended, .. } = knife;
    let n_shared = [scene.materials.len(), scene.images.len()];
    Ok(Pieces { pieces, blades, substance, kind, middle, gaps, mended, n_shared })
}

/// The pieces that a recipe asks for, laid out to be seen.
///
/// # Errors
/// As [`pieces`].
pub(super) fn open(
    recipe: &CutRecipe,
    scene: Report<Scene>,
    on: (&Path, u32),
    longer_side: u32,
    workers: &Workers,
) -> Result<Report<Scene>> {
    let shown = shown(recipe)?;
    let way = layout::Way::of(recipe)?;
    let mut mended = scene.mended;
    let mut columns = Vec::new();
    let kinds: Vec<Option<String>> = match recipe.shows_each_kind() {
        true => KINDS.iter().map(|(name, _)| Some((*name).to_owned())).collect(),
        false => vec![recipe.kind.clone()],
    };
    for kind in kinds {
        let recipe = CutRecipe { kind, ..recipe.clone() };
        // About two texels for a pixel, as a section fills less than half of the picture.
        let share = if recipe.shows_each_kind() { 2 } else { 3 };
        let n_texels = (longer_side / 4 * share).clamp(64, 4096);
        let mut cut = pieces(&recipe, &scene.value, on, Dress::Picture(n_texels), workers)?;
        if columns.is_empty() {
            mended.append(&mut cut.mended);
        }
        columns.push(layout::laid_out(cut, shown, way));
    }
    Ok(Report { value: layout::beside_each_other(columns), mended })
}

/// Which pieces a recipe asks for: those below the first cut, those above.
///
/// # Errors
/// A name that is not known.
pub fn shown(recipe: &CutRecipe) -> Result<[bool; 2]> {
    let known = [("both", [true, true]), ("a", [true, false]), ("b", [false, true])];
    choose_or("half", &recipe.half, &known, [true, true])
}

/// Relief goes so far of the way to the skin: something is left between them.
const WITHIN_SKIN: f32 = 0.9;

/// Distance of a cap's corners, in radii of the smallest particle.
const PITCH: f32 = 0.2;

/// Corners along the outline of each particle.
const EDGE_CORNERS: usize = 32;

/// More corners of a cap would not fit the memory of a usual machine.
const MOST_CORNERS: f32 = 4e6;

/// All that stays the same from cut to cut.
struct Knife<'a> {
    /// For each cut, what was sampled of depths below the skin: finely near it, and coarsely everywhere.
    depths: Vec<Vec<Depths>>,
    /// Where the coordinates of each section are zero; pieces have maps in these, whichever piece was cut.
    origins: Vec<DVec3>,
    /// The scene's, for messages.
    name: &'a str,
    skin: Skin,
    is_flat: bool,
    policy: Policy,
    kind: SectionKind,
    dress: Dress,
    substance: Option<&'a Substance>,
    /// The colours of a cap without a grain.
    plain: &'a Leaf,
    /// Materials of the scene; cap `c` has the one with the number `n_materials + c`.
    n_materials: u32,
    workers: &'a Workers,
    gaps: Vec<Gap>,
    mended: Vec<Mended>,
}

impl Knife<'_> {
    /// One piece in two, each with a cap as its last part.
    fn cut(&mut self, raw: &RawMesh, blade: &Blade, k: usize) -> Result<[RawMesh; 2]> {
        let ground = Ground::of(blade, raw);
        let depth = |p: DVec3| self.depth(k, p);
        let room = |p: DVec3| WITHIN_SKIN * self.skin.distance(p) as f32;
        let cap = |side| Cap {
            ground,
            look: caps::look(self.kind, side),
            substance: self.substance,
            depth: &depth,
            room: &room,
        };
        let sides = [cap(Side::Below), cap(Side::Above)];
        let mut relief = None;
        if let Some(substance) = self.substance.filter(|_| !self.is_flat) {
            let pitch = self.pitch(&ground, raw, substance.finest * PITCH);
            self.check_room(&ground, raw, substance, pitch)?;
            relief = Some(pitch);
        }
        let cut = match (blade, relief) {
            (Blade::Plane(plane), Some(pitch)) => {
                let edges = self.edges(&ground, raw);
                let shows = |p: DVec3, side: Side| {
                    let cap = &sides[(side == Side::Above) as usize];
                    cap.within_skin(p, cap.hit(p).expect("relief is a grain's"))
                };
                cut::cut_with_relief(raw, plane, self.policy, &Relief { pitch, points: &edges, shows: &shows })
            }
            (Blade::Plane(plane), _) => cut::cut(raw, plane, self.policy),
            (_, _) => {
                let sheet = blade.sheet().expect("what is no plane is a sheet");
                let size = self.size(raw);
                cut::cut_along(raw, sheet, size * SHEET_PITCH, self.policy)
            }
        };
        let cut = cut.map_err(|e| Error::Format { path: self.name.into(), fault: e.to_string() })?;
        let mut told = Vec::new();
        remarks(&cut, self.policy, &mut told);
        let halves = {
            let Cut { below, above, .. } = &cut;
            [(below, &sides[0]), (above, &sides[1])].map(|(half, cap)| self.dressed(half, cap, k))
        };
        self.mended.extend(told);
        self.gaps.extend(cut.gaps);
        Ok(halves)
    }

    /// A half whose cap knows its material, and its colours where corners hold them.
    fn dressed(&self, half: &Half, cap: &Cap, n_blade: usize) -> RawMesh {
        let Half { raw, cap: triangles, cap_vertices } = half;
        let mut raw = raw.clone();
        let number = 2 * n_blade as u32 + (cap.look.side == Side::Above) as u32;
        if let Some(part) = raw.parts.last_mut().filter(|_| !triangles.is_empty()) {
            part.material = Some(self.n_materials + number);
        }
        let flat = self.coordinates(&raw);
        let vertices = cap_vertices.start as usize..cap_vertices.end as usize;
        match self.dress {
            Dress::Corners => {
                if self.substance.is_some() && raw.colors.is_empty() {
                    raw.colors = vec![Vec4::ONE; raw.positions.len()];
                }
                if !raw.colors.is_empty() {
                    let color = |v: usize| cap.color(self.plain, cap.ground.point(flat[v]));
                    let colors: Vec<Vec4> = self.workers.map(vertices.len(), |i| color(vertices.start + i));
                    raw.colors[vertices].copy_from_slice(&colors);
                }
            }
            Dress::Picture(_) => {
                let places: Vec<(usize, Vec2)> = vertices.map(|v| (v, flat[v])).collect();
                cap.flatten(&mut raw, &places);
            }
            Dress::Maps(_) => {}
        }
        // The cut counts from the middle of the piece it was given.
        let from = cap.ground.origin - self.origins[n_blade];
        let shift = Vec2::new(from.dot(cap.ground.axes[0]) as f32, from.dot(cap.ground.axes[1]) as f32);
        if let Some(set) = raw.uv_sets.iter_mut().find(|s| s.name == UV_NAME) {
            set.uv[cap_vertices.start as usize..cap_vertices.end as usize].iter_mut().for_each(|uv| *uv += shift);
        }
        raw
    }

    /// The piece as a scene, with materials for its caps.
    fn finish(&self, mut raw: RawMesh, sides: Vec<Side>, blades: &[Blade], scene: &Scene) -> Result<Piece> {
        let uv_set = raw.uv_sets.iter().position(|s| s.name == UV_NAME).unwrap_or(0);
        let mut scene = scene.clone_without_mesh();
        let mut maps = Vec::new();
        if self.dress == Dress::Corners {
            self.plain_materials(&mut raw, &mut scene);
        }
        for k in 0..raw.parts.len() {
            let Some(number) = raw.parts[k].material.and_then(|m| m.checked_sub(self.n_materials)) else { continue };
            if self.dress == Dress::Corners {
                continue;
            }
            let (n_blade, side) = (number as usize / 2, [Side::Below, Side::Above][number as usize % 2]);
            raw.parts[k].material = Some(scene.materials.len() as u32);
            let made = self.map(&mut raw, k, (n_blade, &blades[n_blade], side), uv_set)?;
            // True relief has its own normals, but a picture shows those of the grain.
            let is_picture = matches!(self.dress, Dress::Picture(_));
            let normals = self.substance.is_some() && (self.is_flat || is_picture);
            let has = Has { normals, openness: !is_picture };
            caps::add_material(&mut scene, &made, &format!("section-{}", maps.len()), uv_set as u32, has);
            maps.push((n_blade, made));
        }
        scene.mesh = raw.trusted();
        Ok(Piece { scene, sides, maps })
    }

    /// Bakes the maps of a cap, and turns its coordinates into those of the maps.
    fn map(
        &self,
        raw: &mut RawMesh,
        part: usize,
        (n_blade, blade, side): (usize, &Blade, Side),
        uv_set: usize,
    ) -> Result<CapMaps> {
        let ground = Ground { origin: self.origins[n_blade], ..Ground::of(blade, raw) };
        let range = raw.parts[part].triangles.clone();
        let mut used: Vec<u32> =
            raw.triangles[range.start as usize..range.end as usize].iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let at: Vec<Vec2> = used.iter().map(|&v| raw.uv_sets[uv_set].uv[v as usize]).collect();
        let depth = |p: DVec3| self.depth(n_blade, p);
        let room = |p: DVec3| WITHIN_SKIN * self.skin.distance(p) as f32;
        let look = caps::look(self.kind, side);
        let cap = Cap { ground, look, substance: self.substance, depth: &depth, room: &room };
        let maps = cap.maps(self.plain, self.dress, &at, self.workers)?;
        let to = maps.layout.uv_transform();
        for (&v, at) in used.iter().zip(at) {
            let [x, y] = [0, 1].map(|k| to.matrix[k][0] * at.x + to.matrix[k][1] * at.y + to.offset[k]);
            raw.uv_sets[uv_set].uv[v as usize] = Vec2::new(x, y);
        }
        Ok(maps)
    }

    /// Materials where corners hold colours.
    fn plain_materials(&self, raw: &mut RawMesh, scene: &mut Scene) {
        let is_cap = |m: Option<u32>| m.is_some_and(|m| m >= self.n_materials);
        let clay = self.n_materials;
        if self.substance.is_some() {
            // Colours must not turn clay white.
            scene.materials.push(Material { name: "clay".into(), ..Material::default() });
        }
        let cap = scene.materials.len() as u32;
        let color = if self.substance.is_some() || !raw.colors.is_empty() { Vec3::ONE } else { self.plain.matrix[0] };
        for part in &mut raw.parts {
            part.material = match part.material {
                m if is_cap(m) => Some(cap),
                None if self.substance.is_some() => Some(clay),
                m => m,
            };
        }
        let base_color = color.extend(1.0).to_array();
        scene.materials.push(Material { name: CAP_NAME.into(), base_color, roughness: 0.6, ..Material::default() });
    }

    fn coordinates(&self, raw: &RawMesh) -> Vec<Vec2> {
        raw.uv_sets.iter().find(|s| s.name == UV_NAME).map_or(Vec::new(), |s| s.uv.clone())
    }

    fn size(&self, raw: &RawMesh) -> f32 {
        let (low, high) =
            raw.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), &p| (a.min(p), b.max(p)));
        (high - low).max_element()
    }

    /// Distance of a cap's corners: for a picture no finer than its pixels.
    fn pitch(&self, ground: &Ground, raw: &RawMesh, wanted: f32) -> f32 {
        let Dress::Picture(n_texels) = self.dress else { return wanted };
        let window = ground.window(&raw.positions);
        wanted.max((window.max - window.min).max_element() * 1.5 / n_texels as f32)
    }

    /// That a cap's corners are not too many, or its particles too small to be seen.
    fn check_room(&self, ground: &Ground, raw: &RawMesh, substance: &Substance, pitch: f32) -> Result<()> {
        let window = ground.window(&raw.positions);
        let size = window.max - window.min;
        let why = match self.dress {
            Dress::Picture(n_texels) => {
                let n_wide = 2.0 * substance.finest / (size.max_element() / n_texels as f32);
                (n_wide < 0.06).then(|| format!("particles {n_wide:.0e} texels wide are too small for this picture"))
            }
            _ => {
                let n = size.x / pitch * (size.y / pitch);
                (n > MOST_CORNERS).then(|| {
                    format!("the particles are too small for this section: at most 4 million corners, not {n:.1e}")
                })
            }
        };
        why.map_or(Ok(()), |why| Err(impossible("spacing", substance.spacing, why)))
    }

    /// Corners along the outlines of particles, where heights jump.
    fn edges(&self, ground: &Ground, raw: &RawMesh) -> Vec<DVec2> {
        let (Some(plane), Some(Substance { filling: Filling::Particles(grain), .. })) =
            (ground.blade.plane(), self.substance)
        else {
            return Vec::new();
        };
        grain.discs(plane, ground.window(&raw.positions)).map_or(Vec::new(), |discs| discs.edges(EDGE_CORNERS))
    }

    fn depth(&self, n_blade: usize, p: DVec3) -> f32 {
        let sampled = self.depths[n_blade].iter().find_map(|depths| depths.at(p));
        sampled.unwrap_or_else(|| self.skin.distance(p) as f32)
    }
}

/// Longest edges of caps along curved cuts, as a share of the model's size.
const SHEET_PITCH: f32 = 0.012;

/// What has to be known of a cut that did not go smoothly.
fn remarks(cut: &Cut, policy: Policy, mended: &mut Vec<Mended>) {
    let (bridged, open): (Vec<&Gap>, Vec<&Gap>) = cut.gaps.iter().partition(|g| g.bridged);
    let widest = |gaps: &[&Gap]| gaps.iter().map(|g| g.length).fold(0.0, f32::max);
    note(mended, bridged.len(), format!("gaps of the outline bridged, the widest {} long", widest(&bridged)));
    let treated = match policy {
        Policy::Winding => "filled where more is inside than outside",
        _ => "left open",
    };
    note(mended, open.len(), format!("gaps of the outline, the widest {} long, {treated}", widest(&open)));
    note(mended, cut.overlaps as usize, "section in which bodies overlap, and their caps with them");
    note(mended, cut.n_lost, "pieces of the outline without a cap");
}

fn figure(recipe: &CutRecipe) -> Result<Option<Figure>> {
    let Some(number) = recipe.figure else { return Ok(None) };
    let found = figures().into_iter().find(|f| f.number == number);
    let numbers: Vec<String> = figures().iter().map(|f| f.number.to_string()).collect();
    found.map(Some).ok_or_else(|| impossible("figure", number, format!("one of {}", numbers.join(", "))))
}

/// The normal of the first cut.
fn normal(recipe: &CutRecipe) -> Result<Vec3> {
    let figure = figure(recipe)?;
    Ok(recipe.normal.map(Vec3::from).or(figure.map(|f| f.normal)).unwrap_or(Vec3::X))
}

/// The colours that a recipe gives, or the usual.
fn leaf(recipe: &CutRecipe) -> Result<Leaf> {
    Leaf::new(recipe.matrix.as_slice(), recipe.particles.as_slice())
}

/// What a recipe has the model made of, if anything, and the kind of section: its own, or the one that suits the grain best.
///
/// # Errors
/// As [`pieces`].
pub fn substance(recipe: &CutRecipe, scene: &Scene, on: (&Path, u32)) -> Result<(Option<Substance>, SectionKind)> {
    let (substance, suited) = suited(recipe, scene, on)?;
    let kind = choose_or("kind", &recipe.kind, &KINDS, suited)?;
    match &substance {
        Some(s) if kind == SectionKind::Tear && !s.filling.has_pieces() => {
            Err(impossible("kind", "tear", "this grain has no pieces that could stay whole: hollow or solid"))
        }
        _ => Ok((substance, kind)),
    }
}

fn suited(recipe: &CutRecipe, scene: &Scene, (base, seed): (&Path, u32)) -> Result<(Option<Substance>, SectionKind)> {
    let bounds = scene.mesh.bounds();
    let body = Body { center: bounds.center(), extent: bounds.extent() };
    let seed = recipe.seed.unwrap_or(seed);
    if let Some(figure) = figure(recipe)? {
        let scale = body.extent.y / figure.height_cm;
        let spec = GrainSpec {
            spacing: figure.grain.spacing * scale,
            shape: scaled(figure.grain.shape.clone(), scale),
            seed,
            ..figure.grain
        };
        let spec = if is_to_the_letter(recipe)? { spec.to_the_letter() } else { spec };
        return Ok((Some(Substance::of_spec(spec, leaf(recipe)?)?), SectionKind::Tear));
    }
    let name = recipe.grain.as_deref().unwrap_or("sphere");
    if name == "none" {
        return Ok((None, SectionKind::Tear));
    }
    let named = library::find(name, base)?;
    let Some(mut grain) = named else {
        return Ok((Some(of_shape(recipe, name, body, seed)?), SectionKind::Tear));
    };
    let own = [
        ("radius", recipe.radius.is_some()),
        ("height", recipe.height.is_some()),
        ("axis", recipe.axis.is_some()),
        ("cone", recipe.cone.is_some()),
        ("jitter", recipe.jitter.is_some()),
        ("size_spread", recipe.size_spread.is_some()),
        ("profile", recipe.profile.is_some()),
    ];
    if let Some((what, _)) = own.iter().find(|(_, is_given)| *is_given) {
        return Err(impossible(what, name, "this grain has its own: write a grain file to change it"));
    }
    let layer = grain.layers.last_mut().expect("a grain has layers");
    let given = |color: &Option<String>| color.clone().map(Words::One);
    layer.matrix = given(&recipe.matrix).or(layer.matrix.take());
    layer.particles = given(&recipe.particles).or(layer.particles.take());
    let kind = grain.kinds()?.first().copied().unwrap_or(SectionKind::Tear);
    Ok((Some(grain.fill(body, recipe.spacing, seed)?), kind))
}

/// Particles of a shape that the recipe itself describes.
fn of_shape(recipe: &CutRecipe, name: &str, body: Body, seed: u32) -> Result<Substance> {
    // As many particles as the bunny of Fig. 6 has.
    let spacing = recipe.spacing.unwrap_or(body.extent.max_element() * 0.03);
    let in_spacings = |x: Option<f32>| x.map(|x| x / spacing);
    let color = |color: &Option<String>| color.clone().map(Words::One);
    let known: Vec<(&str, &str)> = library::all_names().map(|n| (n, n)).collect();
    let matter = Matter {
        of: choose("grain", name, &known)?.to_owned(),
        radius: in_spacings(recipe.radius),
        height: in_spacings(recipe.height),
        axis: recipe.axis.map(AxisRecipe::Along),
        cone: recipe.cone,
        jitter: recipe.jitter,
        size_spread: recipe.size_spread,
        matrix: color(&recipe.matrix),
        particles: color(&recipe.particles),
        ..Matter::default()
    };
    let grain = GrainRecipe { spacing: 1.0, layers: vec![matter], ..GrainRecipe::default() };
    let substance = grain.fill(body, Some(spacing), seed)?;
    if !is_to_the_letter(recipe)? {
        return Ok(substance);
    }
    let Filling::Particles(particles) = &substance.filling else {
        return Err(impossible("profile", "paper", "it has spheres and cylinders only"));
    };
    Substance::of_spec(particles.spec().clone().to_the_letter(), substance.leaves[0].clone())
}

fn is_to_the_letter(recipe: &CutRecipe) -> Result<bool> {
    choose_or("profile", &recipe.profile, &[("fixed", false), ("paper", true)], false)
}

impl Scene {
    /// All but the surface.
    fn clone_without_mesh(&self) -> Self {
        Self {
            materials: self.materials.clone(),
            images: self.images.clone(),
            cameras: self.cameras.clone(),
            lights: self.lights.clone(),
            up_note: self.up_note.clone(),
            ..Self::of(self.name.clone(), Default::default())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::Texels;
    use crate::assets::topology::Topology;
    use crate::samples;
    use crate::section::cut::volume;

    fn recipe(text: &str) -> CutRecipe {
        crate::recipe::text::parse_as(text, Path::new("a.toml")).expect("a cut")
    }

    fn cut(text: &str, scene: &Scene, dress: Dress) -> Result<Pieces> {
        pieces(&recipe(text), scene, (Path::new(""), 1), dress, &Workers::new(2))
    }

    fn stone() -> Scene {
        samples::scene("nodule", 24, 1).expect("a sample")
    }

    fn volume_of(scene: &Scene) -> f64 {
        volume(scene.mesh.positions(), scene.mesh.triangles())
    }

    fn is_closed(scene: &Scene) -> bool {
        Topology::of(&scene.mesh).n_border_edges == 0
    }

    #[test]
    fn every_grain_of_the_library_fills_a_body_and_is_cut_in_its_kinds() {
        let scene = samples::scene("block", 16, 1).expect("a sample");
        for (name, grain) in library::grains() {
            assert!(!grain.title.is_empty() && !grain.about.is_empty() && !grain.kinds.is_empty(), "{name}");
            for kind in &grain.kinds {
                let text = format!("grain = \"{name}\"\nkind = \"{kind}\"\nrelief = \"none\"");
                let made = cut(&text, &scene, Dress::Picture(24)).unwrap_or_else(|e| panic!("{name}: {e}"));
                let substance = made.substance.expect("a substance");
                assert_eq!(substance.leaves.len(), substance.filling.n_leaves() as usize, "{name}");
                for piece in &made.pieces {
                    let (_, maps) = &piece.maps[0];
                    let first = maps.texels.texels[0].color;
                    assert!(maps.texels.texels.iter().any(|t| t.color != first), "{name} {kind} is of one colour");
                }
            }
        }
        assert_eq!(library::grains().count(), 14);
    }

    #[test]
    fn pieces_are_closed_and_their_volumes_add_up() {
        let scene = stone();
        let whole = volume_of(&scene);
        for (text, n) in [
            ("spacing = 0.3", 2),
            ("normal = [1, 1, 0]\nthen = [\"0,0,1\", \"0,1,0@0.3\"]\nspacing = 0.4", 8),
            ("rough = [0.05, 0.5]\nspacing = 0.3", 2),
            ("stroke = [[-1, 0.1], [0, -0.1], [1, 0.1]]\nnormal = [0, 0, 1]\ngrain = \"none\"", 2),
        ] {
            let made = cut(text, &scene, Dress::Corners).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!(made.pieces.len(), n, "{text}");
            let sum: f64 = made.pieces.iter().map(|p| volume_of(&p.scene)).sum();
            assert!((sum - whole).abs() < 1e-5 * whole, "{text}: {sum} of {whole}");
            assert!(made.pieces.iter().all(|p| is_closed(&p.scene)), "{text}");
            let mut letters: Vec<String> = made.pieces.iter().map(Piece::letters).collect();
            letters.dedup();
            assert_eq!(letters.len(), n, "{text}");
        }
    }

    #[test]
    fn maps_hold_what_corners_hold() {
        let scene = stone();
        let text = "kind = \"solid\"\nspacing = 0.3\nparticles = \"#ff0000\"\nmatrix = \"#0000ff\"\nrelief = \"none\"";
        let made = cut(text, &scene, Dress::Maps(200)).expect("halves");
        for piece in &made.pieces {
            let material = piece.scene.materials.last().expect("of the cap");
            let color = material.base_color_texture.expect("a map");
            assert!(material.normal_texture.is_some() && material.occlusion_texture.is_some());
            let Texels::U8(image) = &piece.scene.images[color.image as usize].texels else { panic!("bytes") };
            let n = |is: fn(&[u8; 4]) -> bool| image.texels.iter().filter(|t| is(t)).count();
            let (red, blue) = (n(|t| t[0] > 180 && t[2] < 20), n(|t| t[2] > 180 && t[0] < 20));
            assert!(red > 1000 && blue > 1000 && red + blue == image.texels.len(), "{red} {blue}");
            // The cap's corners lie within its maps.
            let part = piece.scene.mesh.parts().last().expect("the cap");
            let uv = &piece.scene.mesh.uv_sets()[color.uv_set as usize].uv;
            let range = part.triangles.start as usize..part.triangles.end as usize;
            let used = piece.scene.mesh.triangles()[range].iter().flatten().map(|&v| uv[v as usize]);
            assert!(used.into_iter().all(|uv| uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::ONE).all()));
        }
    }

    #[test]
    fn maps_lie_where_the_particles_are() {
        let scene = stone();
        let text = "kind = \"solid\"\nspacing = 0.4\nparticles = \"#ff0000\"\nmatrix = \"#0000ff\"\nat = 0.3\n\
                    normal = [1, 0.4, 0.2]\nthen = [\"0.3,1,0@0.6\"]";
        let corners = cut(text, &scene, Dress::Corners).expect("pieces");
        let maps = cut(text, &scene, Dress::Maps(256)).expect("pieces");
        let (mut n_seen, mut n_wrong, mut n_caps) = (0, 0, 0);
        for (colored, mapped) in corners.pieces.iter().zip(&maps.pieces) {
            let mesh = &mapped.scene.mesh;
            assert_eq!(colored.scene.mesh.positions(), mesh.positions());
            for part in mesh.parts().iter().filter(|p| p.name == CAP_NAME) {
                n_caps += 1;
                let material = &mapped.scene.materials[part.material.expect("a cap has one") as usize];
                let texture = material.base_color_texture.expect("a map");
                let Texels::U8(image) = &mapped.scene.images[texture.image as usize].texels else { panic!("bytes") };
                for &v in mesh.triangles()[part.triangles.start as usize..part.triangles.end as usize].as_flattened() {
                    let uv = mesh.uv_sets()[texture.uv_set as usize].uv[v as usize];
                    let at = [uv.x * image.size.width as f32, uv.y * image.size.height as f32];
                    let last = [image.size.width - 1, image.size.height - 1];
                    let near = |dx: f32, dy: f32| {
                        let (x, y) = ((at[0] + dx).max(0.0) as u32, (at[1] + dy).max(0.0) as u32);
                        image.at(x.min(last[0]), y.min(last[1]))[0] > 100
                    };
                    let all = [near(-1.5, 0.0), near(1.5, 0.0), near(0.0, -1.5), near(0.0, 1.5)];
                    if all.iter().all(|a| *a == all[0]) {
                        n_seen += 1;
                        let is_red = colored.scene.mesh.colors()[v as usize].x > 0.2;
                        n_wrong += (is_red != all[0]) as usize;
                    }
                }
            }
        }
        // Colours are mixed where the second cut parts edges of the first one's cap.
        assert!(n_caps == 8 && n_seen > 2000 && n_wrong * 50 < n_seen, "{n_caps} caps, {n_wrong} of {n_seen}");
    }

    #[test]
    fn what_cannot_be_cut_gives_one_clear_line() {
        let scene = stone();
        let check = |text: &str, wanted: &str| {
            let error = cut(text, &scene, Dress::Corners).expect_err(text).to_string();
            assert!(error.contains(wanted) && !error.contains('\n'), "{text}: {error}");
        };
        check("spacing = 0.0", "above zero");
        check("spacing = -1.0", "above zero");
        check("spacing = nan", "above zero");
        check("radius = 0.0", "above zero");
        check("normal = [0, 0, 0]", "points nowhere");
        check("through = [9, 0, 0]", "misses the mesh");
        check("at = 1.5", "between 0 and 1");
        check("grain = \"granit\"", "did you mean `granite`?");
        check("grain = \"granite\"\nradius = 0.1", "this grain has its own");
        check("grain = \"missing.toml\"", "missing.toml");
        check("grain = \"bone\"\nkind = \"tear\"", "no pieces");
        check("then = [\"0,1\"]", "X,Y,Z");
        check("rough = [0.0, 1.0]", "hills");
        check("rough = [0.1, 1.0]\nstroke = [[0, 0], [1, 0]]", "leave one of them out");
        check("stroke = [[0, 0]]", "corners");
        check("kind = \"torn\"", "tear");
        check("spacing = 0.0001", "too small for this section");
        check("apart = -1.0\nlayout = \"aport\"\nkind = \"x\"", "kind");
    }
}
