//! Height maps to terrain meshes: ESRI ASCII grids, USGS DEM, NumPy arrays, grey images.
//!
//! East is +X, north is -Z, up is +Y; the map's middle is the origin. Texture coordinates run over the map, the first row
//! (the northernmost) at v = 0. Each cell with a value becomes a vertex that also keeps it as the field `elevation`; cells
//! without one leave holes.

use crate::assets::dem;
use crate::assets::files;
use crate::assets::mend::MendOptions;
use crate::assets::npy;
use crate::assets::text::{self, Words, format_error, parse_error};
use crate::assets::{Element, Field, RawMesh, Scene, Texels, TextureImage, UvSet, Values, image_files};
use crate::error::{Mended, Report, Result, note};
use crate::math::{Size, Vec3, exact, vec2, vec3};
use std::path::Path;

/// How cells and numbers become lengths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Distance between neighbouring cells in the unit of the elevations. None: as the file says; if it says nothing, so
    /// that the relief is a fifth of the map's longer side.
    pub cell: Option<f64>,
    /// Multiplies heights (not the field); none: 1.
    pub exaggeration: Option<f64>,
    /// Which array of an .npz archive; none: the first with two dimensions.
    pub key: Option<String>,
}

/// Which kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// ESRI ASCII grid.
    Asc,
    /// USGS digital elevation model, text.
    Dem,
    /// A NumPy array.
    Npy,
    /// A zip archive of NumPy arrays.
    Npz,
    /// PNG, TIFF or any other image; red or grey is the height.
    Image,
}

/// Elevations on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Cells from west to east and from north to south.
    pub size: Size,
    /// Rows from the north; NaN where there is no value.
    pub elevation: Vec<f32>,
    /// Distance between cells' middles to the east and to the south.
    pub cell: Cell,
    /// Of the elevations; empty when unknown.
    pub unit: String,
}

/// How far apart cells are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// The file does not say.
    Unknown,
    /// In a unit of length.
    Length([f64; 2]),
    /// In degrees of longitude and latitude, about this latitude.
    Degrees([f64; 2], f64),
}

/// Maps with more cells are thinned: a mesh takes some 100 bytes a cell.
const MAX_CELLS: usize = 1 << 23;

/// Images and arrays with more cells are refused.
pub(super) const MAX_READ: u64 = 1 << 28;

/// Reads a height map of a kind.
pub fn read_as(kind: Kind, bytes: &[u8], path: &Path, options: &Options) -> Result<Report<Scene>> {
    let mut mended = Vec::new();
    let map = match kind {
        Kind::Asc => read_asc(bytes, path, &mut mended)?,
        Kind::Dem => dem::read(bytes, path, &mut mended)?,
        Kind::Npy => npy::height_map(&npy::read(bytes, path)?, &[], path)?,
        Kind::Npz => npy::read_npz(bytes, path, options.key.as_deref())?,
        Kind::Image => {
            let report = image_files::read(bytes, path)?;
            mended.extend(report.mended);
            from_image(&report.value)
        }
    };
    let mut report = to_scene(map, files::name_of(path), options)?;
    mended.append(&mut report.mended);
    Ok(Report { value: report.value, mended })
}

/// Reads an image's first channel as whole numbers (8 and 16 bits) or as they are (floats).
pub fn from_image(image: &TextureImage) -> HeightMap {
    let elevation = match &image.texels {
        Texels::U8(i) => i.texels.iter().map(|t| t[0] as f32).collect(),
        Texels::U16(i) => i.texels.iter().map(|t| t[0] as f32).collect(),
        Texels::F32(i) => i.texels.iter().map(|t| t[0]).collect(),
    };
    HeightMap { size: image.texels.size(), elevation, cell: Cell::Unknown, unit: String::new() }
}

/// The terrain as a scene of one mesh.
pub fn to_scene(map: HeightMap, name: String, options: &Options) -> Result<Report<Scene>> {
    let mut mended = Vec::new();
    let path = Path::new(&name);
    let map = map.thinned(&mut mended);
    let values = || map.elevation.iter().copied().filter(|e| e.is_finite());
    let (low, high) = values().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), e| (l.min(e), h.max(e)));
    if low > high {
        return Err(format_error(path, "the height map holds no value"));
    }
    if map.size.width < 2 || map.size.height < 2 {
        return Err(format_error(path, format!("a height map of {} cells is no surface", map.size)));
    }
    let n_missing = map.elevation.iter().filter(|e| !e.is_finite()).count();
    note(&mut mended, n_missing, "cells without a value left as holes");
    let (cell, cell_note) = map.cell_lengths(low, high, options);
    let exaggeration = options.exaggeration.unwrap_or(1.0);
    let mesh = map.mesh(cell, exaggeration);
    // A landscape has no creases.
    let smooth = MendOptions { crease: std::f32::consts::PI, ..Default::default() };
    let report = mesh.mend_with(smooth);
    mended.extend(report.mended);
    let mut scene = Scene::of(name, report.value);
    scene.up_note = format!("height map: elevation is +Y, north is -Z; {cell_note}");
    Ok(Report { value: scene, mended })
}

impl HeightMap {
    /// Every n-th row and column, if there are too many.
    fn thinned(self, mended: &mut Vec<Mended>) -> Self {
        let n = self.size.n_cells();
        let step = (1..).find(|s: &u32| {
            self.size.width.div_ceil(*s) as usize * self.size.height.div_ceil(*s) as usize <= MAX_CELLS
        });
        let Some(step) = step.filter(|s| *s > 1) else { return self };
        let columns = || (0..self.size.width).step_by(step as usize);
        let rows = (0..self.size.height).step_by(step as usize);
        let size = Size::new(columns().count() as u32, rows.clone().count() as u32);
        let at = |x: u32, y: u32| self.elevation[y as usize * self.size.width as usize + x as usize];
        let elevation: Vec<f32> = rows.flat_map(|y| columns().map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect();
        note(mended, n - elevation.len(), format!("cells left out: every {step}. row and column kept"));
        let wider = |c: [f64; 2]| c.map(|x| x * step as f64);
        let cell = match self.cell {
            Cell::Unknown => Cell::Unknown,
            Cell::Length(c) => Cell::Length(wider(c)),
            Cell::Degrees(c, latitude) => Cell::Degrees(wider(c), latitude),
        };
        Self { size, elevation, cell, unit: self.unit }
    }

    /// Distances between cells in the unit of the elevations, and how they were found.
    fn cell_lengths(&self, low: f32, high: f32, options: &Options) -> ([f64; 2], String) {
        if let Some(cell) = options.cell {
            return ([cell; 2], format!("cells of {cell}, as asked"));
        }
        match self.cell {
            Cell::Length([x, y]) => ([x, y], format!("cells of {x} x {y}")),
            Cell::Degrees([lon, lat], latitude) => {
                let (x, y) =
                    (lon * metres_per_degree_of_longitude(latitude), lat * metres_per_degree_of_latitude(latitude));
                let per = if self.unit == "ft" { 0.3048 } else { 1.0 };
                (
                    [x / per, y / per],
                    format!("cells of {lon} x {lat} degrees at latitude {latitude:.2} taken as {x:.1} x {y:.1} m"),
                )
            }
            Cell::Unknown => {
                let longer = (self.size.width.max(self.size.height) - 1) as f64;
                let relief = (high - low) as f64;
                let cell = if relief > 0.0 { relief / (0.2 * longer) } else { 1.0 };
                (
                    [cell; 2],
                    format!("the file names no cell size: {cell:.4} makes the relief a fifth of the map's side"),
                )
            }
        }
    }

    fn mesh(&self, cell: [f64; 2], exaggeration: f64) -> RawMesh {
        let (w, h) = (self.size.width as usize, self.size.height as usize);
        const HOLE: u32 = u32::MAX;
        let n = self.elevation.iter().filter(|e| e.is_finite()).count();
        let mut mesh = RawMesh { positions: Vec::with_capacity(n), n_source_points: w * h, ..Default::default() };
        let (mut uv, mut elevation, mut index) = (Vec::with_capacity(n), Vec::with_capacity(n), vec![HOLE; w * h]);
        let middle = [(w - 1) as f64 / 2.0, (h - 1) as f64 / 2.0];
        for (i, &e) in self.elevation.iter().enumerate().filter(|(_, e)| e.is_finite()) {
            let (x, y) = (i % w, i / w);
            index[i] = mesh.positions.len() as u32;
            mesh.positions.push(vec3(
                ((x as f64 - middle[0]) * cell[0]) as f32,
                (e as f64 * exaggeration) as f32,
                ((y as f64 - middle[1]) * cell[1]) as f32,
            ));
            uv.push(vec2(x as f32 / (w - 1) as f32, y as f32 / (h - 1) as f32));
            elevation.push(e);
            if n < w * h {
                mesh.source_points.push(i as u32);
            }
        }
        mesh.triangles.reserve_exact(if n == w * h { 2 * (w - 1) * (h - 1) } else { 0 });
        for y in 0..h - 1 {
            for x in 0..w - 1 {
                // North-west, south-west, south-east, north-east: counter-clockwise from above.
                let corners = [y * w + x, (y + 1) * w + x, (y + 1) * w + x + 1, y * w + x + 1].map(|i| index[i]);
                let height = |k: usize| mesh.positions[corners[k] as usize];
                match corners.map(|c| c != HOLE) {
                    [true, true, true, true] => {
                        // The flatter diagonal follows ridges and valleys.
                        let [a, b, c, d] = corners;
                        let rise = |p: Vec3, q: Vec3| (p.y - q.y).abs();
                        if rise(height(0), height(2)) <= rise(height(1), height(3)) {
                            mesh.triangles.extend([[a, b, c], [a, c, d]]);
                        } else {
                            mesh.triangles.extend([[a, b, d], [b, c, d]]);
                        }
                    }
                    there if there.iter().filter(|t| **t).count() == 3 => {
                        let mut rest = corners.iter().copied().filter(|c| *c != HOLE);
                        mesh.triangles.extend((|| Some([rest.next()?, rest.next()?, rest.next()?]))());
                    }
                    _ => {}
                }
            }
        }
        mesh.uv_sets.push(UvSet { name: "uv0".into(), uv });
        let (name, unit, values) = ("elevation".to_string(), self.unit.clone(), Values::F32(elevation));
        mesh.fields.push(Field { name, unit, element: Element::Vertex, n_components: 1, values });
        mesh
    }
}

/// Length of a degree on the WGS 84 ellipsoid (series of NIMA TR8350.2), latitude in degrees.
fn metres_per_degree_of_latitude(latitude: f64) -> f64 {
    let l = latitude.to_radians();
    111132.954 - 559.822 * exact::cos(2.0 * l) + 1.175 * exact::cos(4.0 * l)
}

fn metres_per_degree_of_longitude(latitude: f64) -> f64 {
    let l = latitude.to_radians();
    111412.84 * exact::cos(l) - 93.5 * exact::cos(3.0 * l) + 0.118 * exact::cos(5.0 * l)
}

/// Whether a grid that begins at `x`, `y` with such cells must be in degrees: numbers in a globe's range, cells of less
/// than a degree, which would be small for lengths.
pub(super) fn looks_like_degrees([x, y]: [f64; 2], cell: [f64; 2]) -> bool {
    (-180.0..=360.0).contains(&x) && (-90.0..=90.0).contains(&y) && cell.iter().all(|c| *c > 0.0 && *c < 0.5)
}

/// ESRI ASCII grid: a head of words and numbers, then rows from the north.
fn read_asc(bytes: &[u8], path: &Path, mended: &mut Vec<Mended>) -> Result<HeightMap> {
    let text = text::utf8(bytes);
    let mut head = AscHead::default();
    let mut words = Words(&text);
    let line_of = |rest: &[u8]| 1 + text[..text.len() - rest.len()].iter().filter(|b| **b == b'\n').count();
    loop {
        let mut ahead = words.clone();
        let Some(word) = ahead.next() else { break };
        // `nan` may begin the data; no key is a number.
        if text::number(word).is_some() {
            break;
        }
        let value = ahead.next().and_then(text::number);
        let known = value.is_some_and(|value| head.set(&word.to_ascii_lowercase(), value));
        if !known {
            let expected = "ncols, nrows, xllcorner, yllcorner, cellsize or NODATA_value and a number";
            return Err(parse_error(path, line_of(ahead.0), expected, word));
        }
        words = ahead;
    }
    let (Some(w), Some(h)) = (head.n_columns, head.n_rows) else {
        return Err(format_error(path, "the head does not say ncols and nrows"));
    };
    let n = (w * h) as usize;
    if w < 1.0 || h < 1.0 || w * h > words.0.len() as f64 {
        return Err(format_error(
            path,
            format!("{w} x {h} cells are claimed, the file has room for at most {}", words.0.len() / 2),
        ));
    }
    let mut elevation = Vec::with_capacity(n);
    while elevation.len() < n {
        let Some(word) = words.next() else { break };
        let x = text::number(word).ok_or_else(|| parse_error(path, line_of(words.0), "an elevation", word))?;
        elevation.push(if Some(x) == head.missing { f32::NAN } else { x as f32 });
    }
    note(mended, n - elevation.len(), "cells that the head claims are not in the file");
    elevation.resize(n, f32::NAN);
    let size = Size::new(w as u32, h as u32);
    let cell = match head.cell {
        [Some(x), Some(y)] if x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite() => match head.corner {
            [Some(lon), Some(lat)] if looks_like_degrees([lon, lat], [x, y]) => {
                Cell::Degrees([x, y], lat + y * h / 2.0)
            }
            _ => Cell::Length([x, y]),
        },
        _ => Cell::Unknown,
    };
    // Degrees come with metres as good as always; other grids leave open what their unit is.
    let unit = if matches!(cell, Cell::Degrees(..)) { "m" } else { "" };
    Ok(HeightMap { size, elevation, cell, unit: unit.into() })
}

#[derive(Default)]
struct AscHead {
    n_columns: Option<f64>,
    n_rows: Option<f64>,
    corner: [Option<f64>; 2],
    cell: [Option<f64>; 2],
    missing: Option<f64>,
}

impl AscHead {
    fn set(&mut self, key: &[u8], value: f64) -> bool {
        match key {
            b"ncols" => self.n_columns = Some(value.trunc()),
            b"nrows" => self.n_rows = Some(value.trunc()),
            b"xllcorner" | b"xllcenter" => self.corner[0] = Some(value),
            b"yllcorner" | b"yllcenter" => self.corner[1] = Some(value),
            b"cellsize" => self.cell = [Some(value); 2],
            b"dx" => self.cell[0] = Some(value),
            b"dy" => self.cell[1] = Some(value),
            b"nodata_value" | b"nodata" => self.missing = Some(value),
            _ => return false,
        }
        true
    }
}

#[cfg(test)]
#[path = "height_map_tests.rs"]
mod tests;
