//! A walk around the object, or the wandering of a range or of isolines, as a moving picture.

use crate::assets::animation::{self, Clip, Timing};
use crate::assets::{RawMesh, Scene};
use crate::error::{Mended, Result};
use crate::math::{Mat4, Vec3, exact};
use crate::par::Workers;
use crate::picture::render::Shortfall;
use crate::recipe::prepare::prepare_from;
use crate::recipe::render::Stage;
use crate::recipe::view::Frame;
use crate::recipe::words::impossible;
use crate::recipe::{Prepared, Recipe, TurntableRecipe, View, output, prepare, view};
use crate::visibility::Camera;
use std::path::{Path, PathBuf};

/// Pictures of one walk, unless the recipe says otherwise: 10 degrees apart.
pub const FRAMES: u32 = 36;

/// Pictures a second, unless the recipe says otherwise: three seconds for a walk.
pub const FPS: f32 = 12.0;

/// A walk around a scene that is ready to be drawn.
pub struct Turntable {
    /// The scene, looked at from where the walk begins.
    pub prepared: Prepared,
    /// How it runs.
    pub timing: Timing,
    /// The whole way, radians.
    turn: f64,
    start: Camera,
    /// On the vertical line that the camera walks around.
    middle: Vec3,
    base: PathBuf,
}

impl Turntable {
    /// Loads what a recipe names, and places the camera so that nothing is cropped on the whole way.
    ///
    /// # Errors
    /// As [`prepare`]; `Parameter` for numbers that cannot be.
    pub fn new(recipe: &Recipe, base: &Path, workers: &Workers) -> Result<(Self, Vec<Mended>)> {
        let walk = &recipe.turntable;
        let watches = walk.watches();
        let turn = walk.turn.unwrap_or(if watches { 0.0 } else { 360.0 }) as f64;
        if !(turn.abs() <= 36_000.0 && (turn != 0.0 || watches)) {
            return Err(impossible("turn", turn, "degrees, up to a hundred times around"));
        }
        let timing = Timing { n_frames: walk.frames.unwrap_or(FRAMES), fps: walk.fps.unwrap_or(FPS) };
        let report = prepare(&recipe.at(0.0)?, base, workers)?;
        let mut prepared = report.value;
        if watches && !recipe.is_made_anew() {
            // The legend's numbers change, and their width with them: it gets the room of the widest.
            for share in [0.25, 0.5, 0.75, 1.0, 0.0] {
                prepared.change(&recipe.at(share)?)?;
                let legend = prepared.legend.as_ref().map(|(_, layout)| layout);
                prepared.frame = prepared.frame.and(Frame::beside(legend, prepared.size));
            }
        }
        let (start, middle) = match walk.watch_cut {
            None => view::turning_view(&recipe.seen_from(), &prepared.scene, prepared.frame.size)?,
            Some(_) => {
                // The first frame may show next to nothing: the camera has all of them in view.
                let scenes =
                    [0.0, 0.5, 1.0].map(|share| prepare(&recipe.at(share)?, base, workers).map(|p| p.value.scene));
                let [first, second, third] = scenes;
                let all = together([first?, second?, third?]);
                view::turning_view(&recipe.at(0.0)?.seen_from(), &all, prepared.frame.size)?
            }
        };
        prepared.view = View::Camera(start);
        Ok((Self { prepared, timing, turn: turn.to_radians(), start, middle, base: base.into() }, report.mended))
    }

    /// The camera of a frame. A whole turn closes: the frame after the last would be the first.
    pub fn camera(&self, frame: u32) -> Camera {
        let whole = 2.0 * std::f64::consts::PI;
        let is_closed = ((self.turn / whole).round() * whole - self.turn).abs() < 1e-9;
        let n_steps = if is_closed { self.timing.n_frames } else { (self.timing.n_frames - 1).max(1) };
        let angle = self.turn * frame as f64 / n_steps as f64;
        let (s, c) = (exact::sin(angle) as f32, exact::cos(angle) as f32);
        let turn = Mat4::from_cols_array_2d(&[
            [c, 0.0, -s, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [s, 0.0, c, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]);
        let world_from_camera = Mat4::from_translation(self.middle)
            * turn
            * Mat4::from_translation(-self.middle)
            * self.start.world_from_camera;
        Camera { world_from_camera, ..self.start }
    }

    /// Draws all frames and writes them to `path`: a GIF, an animated PNG, or a folder. `about` is written into the file,
    /// beside the recipe. `progress` hears shares from 0 to 1, from any thread.
    ///
    /// # Errors
    /// What the lights of the recipe cannot be; `Write`. Nothing is left behind then.
    pub fn write(
        &mut self,
        recipe: &Recipe,
        (path, about): (&Path, &[(&str, String)]),
        workers: &Workers,
        progress: &(dyn Fn(f32) + Sync),
    ) -> Result<Shortfall> {
        let metadata = output::metadata(recipe, &self.prepared.view, about);
        let mut stage = if self.turn == 0.0 { Stage::standing_still() } else { Stage::default() };
        let mut shortfall = Shortfall::default();
        let clip = Clip { size: self.prepared.size, timing: self.timing, metadata: &metadata };
        animation::write(path, clip, |i| {
            let share = i as f64 / (clip.timing.n_frames - 1).max(1) as f64;
            self.look_from(&recipe.at(share)?, self.camera(i), workers)?;
            let share = |s: f32| progress((i as f32 + s) / clip.timing.n_frames as f32);
            let picture = self.prepared.render_on(&mut stage, workers, &share);
            shortfall.n_truncated_tiles = shortfall.n_truncated_tiles.max(picture.shortfall.n_truncated_tiles);
            Ok(picture.pixels)
        })?;
        Ok(shortfall)
    }

    /// Moves the camera, and with it the lights that stand by the camera.
    fn look_from(&mut self, recipe: &Recipe, camera: Camera, workers: &Workers) -> Result<()> {
        if recipe.is_made_anew() {
            self.prepared = prepare_from(recipe, &self.base, Some(camera), workers)?.value;
            return Ok(());
        }
        let prepared = &mut self.prepared;
        prepared.view = View::Camera(camera);
        if recipe.turntable.watches() {
            prepared.change(recipe)?;
        } else {
            prepared.lighting = prepared.lighting_by(recipe)?;
        }
        Ok(())
    }
}

impl TurntableRecipe {
    /// Whether more moves than the camera.
    fn watches(&self) -> bool {
        self.watch_range.is_some() || self.watch_level.is_some() || self.watch_cut.is_some()
    }
}

/// What several scenes cover, as points.
fn together(scenes: [Scene; 3]) -> Scene {
    let mut raw = RawMesh::default();
    for scene in &scenes {
        let first = raw.positions.len() as u32;
        raw.positions.extend(scene.mesh.positions());
        raw.normals.extend(scene.mesh.normals());
        raw.triangles.extend(scene.mesh.triangles().iter().map(|t| t.map(|v| v + first)));
    }
    Scene::of("all frames", raw.mend().value)
}

impl Recipe {
    /// Whether each frame is prepared from the start, as more than light, camera and colours change.
    fn is_made_anew(&self) -> bool {
        self.is_made_for_one_view() || self.turntable.watch_cut.is_some()
    }

    /// As it stands at a share of the film, 0 its first frame, 1 its last.
    fn at(&self, share: f64) -> Result<Self> {
        let mut now = self.clone();
        let between = |[from, to]: [f64; 2]| from + (to - from) * share;
        let none = |what: &str| impossible("watch", what, "no layer of the picture has one");
        if let Some([from, to]) = self.turntable.watch_range {
            let table = now.layers.iter_mut().find(|l| l.table.is_some()).ok_or_else(|| none("range"))?;
            table.range = Some([between([from[0], to[0]]), between([from[1], to[1]])]);
            table.percentiles = None;
        }
        if let Some(levels) = self.turntable.watch_level {
            let lines = now.layers.iter_mut().find(|l| l.isolines.is_some()).ok_or_else(|| none("level"))?;
            lines.level = Some(between(levels));
        }
        if let Some(places) = self.turntable.watch_cut {
            let cut = now.cut.as_mut().ok_or_else(|| impossible("watch", "cut", "the picture has none"))?;
            cut.at = Some(between(places) as f32);
            // Pages that are laid out anew would jump from frame to frame.
            cut.layout.get_or_insert_with(|| "apart".into());
            cut.half.get_or_insert_with(|| "a".into());
        }
        Ok(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::{Texels, image_files};
    use crate::recipe::text;

    fn recipe(more: &str) -> Recipe {
        let text = format!("[input]\nfile = \"sample:knot\"\nresolution = 16\n[picture]\nsize = [48, 40]\n{more}");
        text::parse(&text, Path::new("a.toml")).expect("a recipe")
    }

    fn turntable(more: &str) -> Result<Turntable> {
        Turntable::new(&recipe(more), Path::new(""), &Workers::new(1)).map(|(t, _)| t)
    }

    #[test]
    fn the_camera_walks_around_once_at_one_distance() {
        let table = turntable("[turntable]\nframes = 8").expect("a walk");
        let eyes: Vec<Vec3> = (0..9).map(|i| table.camera(i).eye() - table.middle).collect();
        assert!((eyes[8] - eyes[0]).length() < 1e-5 * eyes[0].length(), "a whole turn closes");
        for eye in &eyes {
            assert!((eye.length() - eyes[0].length()).abs() < 1e-5 * eye.length() && (eye.y - eyes[0].y).abs() < 1e-6);
        }
        assert!((eyes[4] + eyes[0]).length() < 2.001 * eyes[0].y.abs(), "half-way it stands on the other side");
        let half = turntable("[turntable]\nframes = 5\nturn = 180").expect("a walk");
        let opposite = half.camera(4).eye() - half.middle + (half.camera(0).eye() - half.middle);
        assert!(opposite.length() < 2.001 * eyes[0].y.abs(), "a part of a turn ends where it says");
    }

    #[test]
    fn nothing_is_cropped_on_the_way() {
        let mut table = turntable("[turntable]\nframes = 6").expect("a walk");
        let recipe = recipe("");
        for i in 0..6 {
            table.look_from(&recipe, table.camera(i), &Workers::new(1)).expect("lights");
            let picture = table.prepared.light(&Workers::new(1), &|_| ());
            let at = |x: usize, y: usize| picture.light[y * 48 + x][3];
            let edge = (0..48).map(|x| at(x, 0).max(at(x, 39))).chain((0..40).map(|y| at(0, y).max(at(47, y))));
            assert_eq!(edge.fold(0.0, f32::max), 0.0, "frame {i}");
            assert!(at(24, 20) > 0.0 || at(20, 20) > 0.0 || at(28, 20) > 0.0);
        }
    }

    #[test]
    fn frames_are_the_pictures_of_their_cameras() {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let path = folder.path().join("frames");
        let recipe = recipe("ground = true\n[turntable]\nframes = 3");
        let workers = Workers::new(2);
        let mut table = turntable("ground = true\n[turntable]\nframes = 3").expect("a walk");
        table.write(&recipe, (&path, &[]), &workers, &|_| ()).expect("frames");
        for i in 0..3 {
            table.look_from(&recipe, table.camera(i), &Workers::new(1)).expect("lights");
            let alone = table.prepared.render(&workers, &|_| ());
            let file = path.join(format!("frame-{:04}.png", i + 1));
            let read = image_files::read(&std::fs::read(&file).expect("a frame"), &file).expect("a PNG").value;
            let Texels::U8(image) = read.texels else { panic!("8 bits") };
            assert!(image.texels == alone.pixels, "frame {i}");
        }
    }

    #[test]
    fn ranges_and_lines_wander_while_the_camera_stands() {
        let text = "[input]\nfile = \"sample:flange\"\nresolution = 24\n[picture]\nsize = [48, 40]\n\
                    [[layers]]\ntable = \"viridis\"\nfield = \"stress\"\noperator = \"replace\"\n\
                    [[layers]]\nisolines = 50\nfield = \"stress\"\noperator = \"decal\"\n\
                    [turntable]\nframes = 3\nwatch_range = [[0, 1], [0, 199]]\nwatch_level = [0, 50]";
        let recipe = text::parse(text, Path::new("a.toml")).expect("a recipe");
        let film = || Turntable::new(&recipe, Path::new(""), &Workers::new(1)).expect("a film").0;
        let mut table = film();
        assert_eq!(table.camera(0), table.camera(2));
        let folder = tempfile::tempdir().expect("a folder for the test");
        table.write(&recipe, (&folder.path().join("frames"), &[]), &Workers::new(1), &|_| ()).expect("frames");
        let seen = |share| {
            let now = recipe.at(share).expect("a moment");
            let level = now.layers[1].level;
            let mut table = film();
            table.prepared.change(&now).expect("a change");
            (table.prepared.keys[0].range, level, table.prepared.render(&Workers::new(1), &|_| ()).pixels)
        };
        let (first, middle) = (seen(0.0), seen(0.5));
        assert_eq!((first.0, first.1, middle.0, middle.1), ([0.0, 1.0], Some(0.0), [0.0, 100.0], Some(25.0)));
        let file = folder.path().join("frames/frame-0002.png");
        let read = image_files::read(&std::fs::read(&file).expect("a frame"), &file).expect("a PNG").value;
        let Texels::U8(image) = read.texels else { panic!("8 bits") };
        assert!(image.texels == middle.2 && image.texels != first.2);
        assert!(turntable("[turntable]\nwatch_level = [0, 1]").is_err(), "there are no lines");
    }

    #[test]
    fn walks_that_cannot_be_are_refused() {
        for more in ["[turntable]\nturn = 0", "[turntable]\nturn = nan", "[camera]\nview = \"atlas\""] {
            assert!(turntable(more).is_err(), "{more}");
        }
    }
}
