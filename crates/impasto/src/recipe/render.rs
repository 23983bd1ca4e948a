//! A prepared recipe to a picture, and to what the picture knows about itself.

use crate::assets::image_write::{self, Numbers};
use crate::color::LinearRgba;
use crate::math::Size;
use crate::par::Workers;
use crate::picture::contour::{self, LabelStyle};
use crate::picture::numbers::Notation;
use crate::picture::render::{Cells, Renderer, Shortfall, Shot, Still};
use crate::picture::{Develop, Drawing, Film, Ground};
use crate::recipe::legend::Labelled;
use crate::recipe::{Prepared, check};
use crate::visibility::{Domain, Samples};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A finished picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across and down.
    pub size: Size,
    /// sRGB bytes and straight alpha, rows from the top.
    pub pixels: Vec<[u8; 4]>,
    /// What it could not show.
    pub shortfall: Shortfall,
}

/// What is kept from picture to picture of one scene: the renderer's rooms, and the shadow on the ground.
#[derive(Default)]
pub struct Stage {
    renderer: Renderer,
    ground: Option<Ground>,
    stands_still: bool,
    still: Option<Still>,
}

impl Stage {
    /// A stage that keeps what is seen, too: pictures from one view cost no more than their look-up, whatever the number of
    /// triangles, as long as tables, ranges, isolines and lights are all that changes. For opaque surfaces.
    pub fn standing_still() -> Self {
        Self { stands_still: true, ..Self::default() }
    }
}

/// A picture's light before it is developed.
#[derive(Clone, Debug, PartialEq)]
pub struct LightPicture {
    /// Pixels across and down.
    pub size: Size,
    /// Premultiplied linear light and coverage, rows from the top, no background.
    pub light: Vec<LinearRgba>,
    /// What it could not show.
    pub shortfall: Shortfall,
}

impl Prepared {
    /// How the surface maps to the picture's cells.
    pub fn domain(&self) -> Domain<'_> {
        self.view.domain(&self.scene, self.frame, self.size)
    }

    /// What is looked up and what lights it, with `samples` places a pixel.
    pub fn shot(&self, samples: Samples) -> Shot<'_> {
        Shot { looks: &self.looks, lighting: &self.lighting, unlit: self.unlit, samples, develop: None }
    }

    /// The picture in bytes. `progress` hears shares from 0 to 1, from any thread.
    pub fn render(&self, workers: &Workers, progress: &(dyn Fn(f32) + Sync)) -> Picture {
        self.render_on(&mut Stage::default(), workers, progress)
    }

    /// The same on a stage that is kept from picture to picture of one scene.
    pub fn render_on(&self, stage: &mut Stage, workers: &Workers, progress: &(dyn Fn(f32) + Sync)) -> Picture {
        let mut pixels = vec![[0u8; 4]; self.size.n_cells()];
        let film = Film::new(&self.develop, &self.background, self.size, workers);
        let develop = Some(self.develop);
        let shortfall = self.draw(stage, (workers, progress), &mut pixels, develop, |[_, y], cells, row| {
            film.row(y, cells, row);
        });
        if let Some((_, legend)) = &self.legend {
            legend.drawing.paint(&mut pixels, self.size);
        }
        for lines in &self.labelled {
            self.labels(lines, workers).paint(&mut pixels, self.size);
        }
        Picture { size: self.size, pixels, shortfall }
    }

    /// The values of some isolines, written on them.
    fn labels(&self, lines: &Labelled, workers: &Workers) -> Drawing {
        let mut drawing = Drawing::new(self.size);
        let values = check::values(self, &lines.property, workers);
        let contours = contour::trace(&values, self.size, &lines.levels);
        let texts = contour::level_texts(&lines.levels, Notation::Auto);
        let [r, g, b, _] = lines.color;
        let is_dark = 0.2126 * r + 0.7152 * g + 0.0722 * b < 0.18;
        let halo = if is_dark { [1.0, 1.0, 1.0, 0.75] } else { [0.0, 0.0, 0.0, 0.6] };
        let em = (self.size.height as f32 / 48.0).max(9.0).round();
        let style = LabelStyle::new(em, lines.color, halo);
        let style = LabelStyle { spacing: 60.0 * em, ..style };
        drawing.items = contour::labels(&contours, &texts, (&values, self.size), &style, &[]);
        drawing
    }

    /// The picture in linear light.
    pub fn light(&self, workers: &Workers, progress: &(dyn Fn(f32) + Sync)) -> LightPicture {
        let mut light = vec![[0.0; 4]; self.size.n_cells()];
        let stage = &mut Stage::default();
        let shortfall = self.draw(stage, (workers, progress), &mut light, None, |_, cells, row| {
            row.copy_from_slice(cells.light);
        });
        LightPicture { size: self.size, light, shortfall }
    }

    fn draw<T: Copy + Send>(
        &self,
        Stage { renderer, ground, stands_still, still }: &mut Stage,
        (workers, progress): (&Workers, &(dyn Fn(f32) + Sync)),
        picture: &mut [T],
        develop: Option<Develop>,
        finish: impl Fn([u32; 2], Cells, &mut [T]) + Sync + Send,
    ) -> Shortfall {
        let domain = self.domain();
        // What else is laid into the cells' light must be there before they are developed.
        let develop = develop.filter(|_| !self.ground && self.backdrop.is_none());
        let shot = Shot { develop, ..self.shot(self.samples) };
        let n_done = AtomicUsize::new(0);
        let n_cells = self.size.n_cells();
        if self.ground && ground.is_none() {
            *ground = Some(Ground::under(&self.scene.mesh, workers));
        }
        let ground = ground.as_ref().filter(|_| self.ground);
        let floor = ground.and_then(|g| g.lens(&domain).map(|lens| (g, lens)));
        let finish = |place: [u32; 2], cells: Cells, row: &mut [T]| {
            if floor.is_none() && self.backdrop.is_none() {
                finish(place, cells, row);
            } else {
                let mut cells = cells.light.to_vec();
                if let Some((ground, lens)) = &floor {
                    ground.darken(lens, place, &mut cells);
                }
                if let Some(backdrop) = &self.backdrop {
                    backdrop.fill(&domain, place, &mut cells);
                }
                finish(place, Cells::of_light(&cells), row);
            }
            let n = row.len();
            let done = n_done.fetch_add(n, Ordering::Relaxed) + n;
            // One call for some thousand cells: often enough for the eye.
            if done / PROGRESS_STEP != (done - n) / PROGRESS_STEP || done == n_cells {
                progress(done as f32 / n_cells as f32);
            }
        };
        if let Some(still) = still.as_ref().filter(|s| s.serves(&domain, &shot)) {
            return renderer.shade_still(still, &domain, &shot, workers, picture, finish);
        }
        renderer.sort(&domain, &shot, workers);
        // Where something can be seen through, each picture is made anew: nothing is kept for it.
        if *stands_still && self.looks.is_opaque() {
            let (seen, shortfall) = renderer.record(&domain, &shot, workers, picture, finish);
            *still = Some(seen);
            return shortfall;
        }
        renderer.shade(&domain, &shot, workers, picture, finish)
    }
}

/// Cells between two words about progress.
const PROGRESS_STEP: usize = 1 << 14;

impl Picture {
    /// Whether a pixel lets the background through.
    pub fn has_alpha(&self) -> bool {
        self.pixels.iter().any(|p| p[3] != 255)
    }

    /// As a PNG file: three channels when it is opaque, four otherwise.
    pub fn png(&self, metadata: &[(&str, String)]) -> Vec<u8> {
        image_write::png_picture(self.size, &self.pixels, metadata)
    }
}

impl LightPicture {
    /// As an OpenEXR file: `R`, `G`, `B` premultiplied as the format wants it, `A` coverage.
    pub fn exr(&self, metadata: &[(&str, String)]) -> Vec<u8> {
        let channel = |c: usize| -> Vec<f32> { self.light.iter().map(|p| p[c]).collect() };
        let [r, g, b, a] = [0, 1, 2, 3].map(channel);
        let channels =
            [("R", Numbers::F32(&r)), ("G", Numbers::F32(&g)), ("B", Numbers::F32(&b)), ("A", Numbers::F32(&a))];
        image_write::exr(self.size, &channels, metadata)
    }
}
