//! A layout for surfaces that have none: cut into charts, laid flat, packed into one square without overlap.
//!
//! The charts of [`UnwrapMethod::Conformal`] are crate `uvunwrap`'s: grown within a cone of normals, flattened by least
//! squares conformal maps (Lévy et al. 2002) and as-rigid-as-possible steps (Liu et al. 2008), packed by their shapes.
//! It sits behind [`conformal`] alone, so that another can take its place. Same bytes on every machine.

use crate::assets::{Mesh, UvSet};
use crate::error::{Error, Report, Result, note};
use crate::math::{Vec2, vec2};
use crate::placement::Stretch;
use crate::placement::box_charts::{Layout, box_charts, n_pieces};
use crate::placement::split::split_corners;
use crate::placement::stretch::stretch;

/// The name of the UV set that [`unwrap()`] adds.
pub const UNWRAPPED: &str = "unwrapped";

/// From this many triangles on, speed counts more than few seams: smaller charts, packed by their extents, not shapes.
const LARGE: usize = 30_000;

/// Triangles a chart of an average density may have, in small and in large meshes: the solver's time grows faster than the
/// chart (75,000 triangles: 17 s without a limit, 6 s with charts of 1,000).
const MOST_IN_CHART: [f64; 2] = [4000.0, 1000.0];

/// How a surface is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnwrapOptions {
    /// Edge of the square texture the layout is made for, texels.
    pub size: u32,
    /// Texels kept free around each chart, at that size: charts are twice as far apart.
    pub gutter: u32,
    /// How charts are made.
    pub method: UnwrapMethod,
}

impl Default for UnwrapOptions {
    fn default() -> Self {
        Self { size: 2048, gutter: 2, method: UnwrapMethod::Conformal }
    }
}

/// How charts are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum UnwrapMethod {
    /// Few charts with little distortion.
    #[default]
    Conformal,
    /// By the main direction that triangles face: quick, at most a factor of 1.73 of stretch, many charts.
    Box,
}

/// A mesh with a layout, and how good it is.
#[derive(Clone, Debug)]
pub struct Unwrapped {
    /// With the UV set [`UNWRAPPED`]; vertices at seams are split, triangles keep their order.
    pub mesh: Mesh,
    /// That set's index.
    pub uv_set: usize,
    /// How many charts.
    pub n_charts: usize,
    /// How much it distorts, and the share of the square in use.
    pub stretch: Stretch,
    /// What made the charts: the one asked for, or the fallback.
    pub method: UnwrapMethod,
}

/// So many charts are packed by extents: nesting their shapes takes the square of their number.
const MANY: usize = 200;

/// Trials after which the search for a scale is not going to end soon; a dozen or two are usual.
const MOST_TRIALS: usize = 100;

/// Adds a UV set without overlaps, in place of an earlier one of that name. Pictures on it are upright and not mirrored.
///
/// # Errors
/// `Parameter` when the gutter leaves no room in a texture of that size.
pub fn unwrap(mesh: Mesh, options: UnwrapOptions) -> Result<Report<Unwrapped>> {
    let UnwrapOptions { size, gutter, method } = options;
    if size == 0 || size > 1 << 16 || gutter.saturating_mul(4) >= size {
        let why = "the size is 1 to 65536 texels, and more than four times the gutter".into();
        return Err(Error::Parameter { what: "texture size".into(), given: format!("{size}, gutter {gutter}"), why });
    }
    let mut mended = Vec::new();
    let conformal = match method {
        UnwrapMethod::Conformal => conformal(&mesh, size, gutter),
        UnwrapMethod::Box => Ok(None),
    };
    let (layout, method) = match conformal {
        Ok(Some(layout)) => (layout, UnwrapMethod::Conformal),
        failed => {
            if let Err(reason) = failed {
                note(&mut mended, 1, format!("layout made of box charts, as no other was found: {reason}"));
            }
            (box_charts(mesh.positions(), mesh.triangles(), size, gutter), UnwrapMethod::Box)
        }
    };
    let narrow = (layout.gutter_texels < gutter as f64) as usize;
    note(&mut mended, narrow, format!("gutter narrowed to {:.2} texels to fit all charts", layout.gutter_texels));

    let mut raw = mesh.into_raw();
    raw.uv_sets.retain(|set| set.name != UNWRAPPED);
    // Tangents stay with the layout they were made for: splitting keeps each vertex's own.
    let (uv, _) = split_corners(&mut raw, &layout.uv, Vec2::ZERO);
    let stretch = stretch(&raw.positions, &raw.triangles, &uv);
    note(&mut mended, stretch.n_collapsed, "triangles too thin for the layout have no area in it");
    let uv_set = raw.uv_sets.len();
    raw.uv_sets.push(UvSet { name: UNWRAPPED.into(), uv });
    let mended_mesh = raw.mend();
    mended.extend(mended_mesh.mended);
    let value = Unwrapped { mesh: mended_mesh.value, uv_set, n_charts: layout.n_charts, stretch, method };
    Ok(Report { value, mended })
}

/// Charts by `uvunwrap`; none for a mesh without a triangle that has area, or why it could not.
fn conformal(mesh: &Mesh, size: u32, gutter: u32) -> std::result::Result<Option<Layout>, String> {
    let area = area(mesh);
    if area == 0.0 {
        return Ok(None);
    }
    // Pieces that hang together nowhere are charts at least.
    let n_pieces = n_pieces(mesh.positions(), mesh.triangles());
    let is_large = mesh.triangles().len() > LARGE;
    let max_chart_area = (area / mesh.triangles().len() as f64 * MOST_IN_CHART[is_large as usize]) as f32;
    let mut options = uvunwrap::Options {
        density: uvunwrap::Density::Auto { page_size: size },
        padding: affordable_gutter(n_pieces, size, gutter)?,
        packing: if is_large || n_pieces > MANY { uvunwrap::Packing::Fast } else { uvunwrap::Packing::Shape },
        // 0 is no limit, and so is what f32 does not hold.
        max_chart_area: if max_chart_area.is_finite() { max_chart_area } else { 0.0 },
        ..uvunwrap::Options::default()
    };
    let mut atlas = charts(mesh, &options)?;
    if atlas.page_count > 1 {
        // More charts than fit one page with that gutter. Now their number is known.
        options.padding = affordable_gutter(atlas.chart_count as usize, size, gutter)?;
        options.packing = uvunwrap::Packing::Fast;
        atlas = charts(mesh, &options)?;
    }
    let [made] = &atlas.meshes[..] else { return Err("no mesh came back".into()) };
    if atlas.page_count != 1 || made.indices.len() != mesh.triangles().len() * 3 {
        return Err(format!("{} charts do not fit one texture", atlas.chart_count));
    }
    // The page is cropped to what it uses; ours is square.
    let edge = size.max(atlas.width).max(atlas.height) as f32;
    let scale = vec2(atlas.width as f32, atlas.height as f32) / edge;
    let place = |uv: [f32; 2]| {
        let p = Vec2::from(uv) * scale;
        // Their triangles run the other way around: turn v, or pictures would be mirrored.
        vec2(p.x, 1.0 - p.y).clamp(Vec2::ZERO, Vec2::ONE)
    };
    let uv = made.indices.iter().map(|&v| place(made.vertices[v as usize].uv)).collect();
    let gutter_texels = options.padding as f64 * size as f64 / edge as f64;
    Ok(Some(Layout { uv, n_charts: atlas.chart_count as usize, gutter_texels }))
}

/// The crate's call; gives up when packing goes on and on.
fn charts(mesh: &Mesh, options: &uvunwrap::Options) -> std::result::Result<uvunwrap::Atlas, String> {
    let input =
        uvunwrap::MeshInput::new(bytemuck::cast_slice(mesh.positions()), bytemuck::cast_slice(mesh.triangles()));
    uvunwrap::generate_with_progress(&[input], options, |progress| {
        progress.stage != uvunwrap::Stage::Packing || progress.done <= MOST_TRIALS
    })
    .map_err(|e| e.to_string())
}

/// The gutter, or the next smaller halves of it, with which `n_charts` take no more than half of the texture for nothing.
fn affordable_gutter(n_charts: usize, size: u32, gutter: u32) -> std::result::Result<u32, String> {
    let half = size as u64 * size as u64 / 2;
    let fits = |gutter: u32| (2 * gutter as u64 + 2).pow(2) * n_charts as u64 <= half;
    std::iter::successors(Some(gutter), |&g| (g > 0).then_some(g / 2))
        .find(|&g| fits(g))
        .ok_or_else(|| format!("{n_charts} charts are too many for {size} x {size} texels"))
}

fn area(mesh: &Mesh) -> f64 {
    let corners = mesh.triangles().iter().map(|t| t.map(|v| mesh.positions()[v as usize].as_dvec3()));
    corners.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::RawMesh;
    use crate::math::{Vec3, hash_cell, unit_float, vec3};
    use std::time::Instant;

    /// Just enough of OFF and binary little-endian PLY for the shared models.
    fn shared_mesh(name: &str) -> Option<Mesh> {
        let path = format!("{}/../../../shared/data/1_meshes/{name}", env!("CARGO_MANIFEST_DIR"));
        let Ok(bytes) = std::fs::read(&path) else {
            eprintln!("skipped: {path} is not there");
            return None;
        };
        let mut raw = RawMesh::default();
        if name.ends_with(".off") {
            let text = String::from_utf8(bytes).unwrap();
            let mut numbers =
                text.lines().map(|l| l.split('#').next().unwrap()).flat_map(str::split_whitespace).skip(1);
            let mut next = || numbers.next().unwrap().parse::<f64>().unwrap();
            let (n_vertices, n_faces) = (next() as usize, next() as usize);
            next();
            raw.positions = (0..n_vertices).map(|_| vec3(next() as f32, next() as f32, next() as f32)).collect();
            for _ in 0..n_faces {
                let corners: Vec<u32> = (0..next() as usize).map(|_| next() as u32).collect();
                raw.triangles.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
            }
        } else {
            let body = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
            let header = std::str::from_utf8(&bytes[..body]).unwrap();
            let count = |element: &str| {
                header.split(&format!("element {element} ")).nth(1).unwrap().split_whitespace().next().unwrap().parse()
            };
            let (n_vertices, n_faces): (usize, usize) = (count("vertex").unwrap(), count("face").unwrap());
            let vertex_part = header.split("element face").next().unwrap();
            let stride =
                vertex_part.matches("property float").count() * 4 + vertex_part.matches("property uchar").count();
            let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
            raw.positions = (0..n_vertices)
                .map(|i| body + i * stride)
                .map(|at| vec3(float(at), float(at + 4), float(at + 8)))
                .collect();
            let index = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
            let faces = body + n_vertices * stride;
            let face_stride = 13 + header.split("vertex_indices").nth(1).unwrap().matches("property uchar").count();
            raw.triangles =
                (0..n_faces).map(|f| faces + f * face_stride + 1).map(|at| [0, 4, 8].map(|o| index(at + o))).collect();
        }
        raw.triangles.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        Some(raw.mend().value)
    }

    /// Cells of a grid whose centre lies well inside of two triangles.
    fn n_overlaps(mesh: &Mesh, uv_set: usize, edge: usize) -> usize {
        let mut count = vec![0u8; edge * edge];
        for t in mesh.triangles() {
            let p = t.map(|v| mesh.uv_sets()[uv_set].uv[v as usize].as_dvec2() * edge as f64);
            let area = (p[1] - p[0]).perp_dot(p[2] - p[0]);
            let low = p[0].min(p[1]).min(p[2]);
            let high = p[0].max(p[1]).max(p[2]);
            for y in low.y as usize..=(high.y as usize).min(edge - 1) {
                for x in low.x as usize..=(high.x as usize).min(edge - 1) {
                    let c = crate::math::DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let inside = (0..3).all(|k| {
                        let side = p[(k + 1) % 3] - p[k];
                        side.perp_dot(c - p[k]) * area.signum() > 1e-3 * side.length()
                    });
                    count[y * edge + x] = count[y * edge + x].saturating_add((inside && area != 0.0) as u8);
                }
            }
        }
        count.iter().filter(|&&n| n > 1).count()
    }

    /// Unwraps, and holds the result to what every layout must be.
    fn check(name: &str, mesh: Mesh, method: UnwrapMethod) -> Unwrapped {
        let options = UnwrapOptions { size: 1024, method, ..UnwrapOptions::default() };
        let before = mesh.clone();
        let start = Instant::now();
        let report = unwrap(mesh, options).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        let made = report.value;
        println!(
            "{name}: {} triangles, {:?}, {} charts, stretch {:.3}, most {:.2}, coverage {:.2}, {seconds:.2} s {:?}",
            before.triangles().len(),
            made.method,
            made.n_charts,
            made.stretch.l2,
            made.stretch.max,
            made.stretch.coverage,
            report.mended,
        );
        let uv = &made.mesh.uv_sets()[made.uv_set].uv;
        assert!(uv.iter().all(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0), "{name}");
        assert_eq!(n_overlaps(&made.mesh, made.uv_set, 1024), 0, "{name}, {method:?}: overlaps");
        assert_eq!(made.mesh.triangles().len(), before.triangles().len());
        for (a, b) in made.mesh.triangles().iter().zip(before.triangles()) {
            assert_eq!(a.map(|v| made.mesh.positions()[v as usize]), b.map(|v| before.positions()[v as usize]));
        }
        // Upright, not mirrored: with v down, triangles seen from the front run clockwise in (u, v).
        for t in made.mesh.triangles() {
            let [a, b, c] = t.map(|v| uv[v as usize]);
            assert!((b - a).perp_dot(c - a) <= 1e-9, "{name}: mirrored");
        }
        made
    }

    #[test]
    fn real_models_unwrap_without_overlaps() {
        for name in ["bunny/bunny00.off", "closed_and_cad/femur.off", "closed_and_cad/cycloidal.ply"] {
            let Some(mesh) = shared_mesh(name) else { continue };
            check(name, mesh.clone(), UnwrapMethod::Conformal);
            check(name, mesh, UnwrapMethod::Box);
        }
        for name in ["closed_and_cad/ant.ply", "closed_and_cad/cheese.off", "open/mushroom.off"] {
            let Some(mesh) = shared_mesh(name) else { continue };
            check(name, mesh.clone(), UnwrapMethod::Conformal);
            check(name, mesh, UnwrapMethod::Box);
        }
    }

    fn soup(n: usize, corner: impl Fn(usize, usize) -> crate::math::Vec3) -> Mesh {
        let positions = (0..n).flat_map(|t| [0, 1, 2].map(|k| corner(t, k))).collect();
        let triangles = (0..n as u32).map(|t| [t * 3, t * 3 + 1, t * 3 + 2]).collect();
        RawMesh { positions, triangles, ..RawMesh::default() }.mend().value
    }

    #[test]
    fn nothing_is_too_broken_to_unwrap() {
        let random = |t: usize, k: usize, salt| unit_float(hash_cell(t as i32, k as i32, 0, salt)) - 0.5;
        let scattered = |t: usize, k: usize| vec3(random(t, k, 1), random(t, k, 2), random(t, k, 3));
        // A fan of blades around one edge: as far from a manifold as it gets, and all cover each other.
        let blade = |t: usize, k: usize| [Vec3::ZERO, Vec3::Y, vec3(1.0, 0.5, t as f32 * 1e-3)][k];
        let meshes = [
            ("empty", Mesh::default()),
            ("soup", soup(400, scattered)),
            ("blades", soup(200, blade)),
            ("without area", soup(10, |t, k| Vec3::X * (t * 3 + k) as f32)),
            ("one point", soup(4, |_, _| Vec3::ONE)),
            ("huge", soup(40, |t, k| scattered(t, k) * 1e17)),
            ("tiny", soup(40, |t, k| scattered(t, k) * 1e-17)),
            ("far away", soup(40, |t, k| scattered(t, k) + Vec3::splat(1e6))),
        ];
        for (name, mesh) in meshes {
            for method in [UnwrapMethod::Conformal, UnwrapMethod::Box] {
                check(name, mesh.clone(), method);
            }
        }
    }

    #[test]
    fn too_many_charts_for_the_texture_narrow_the_gutter_and_say_so() {
        let mesh = soup(3000, |t, k| {
            let at = vec3((t % 50) as f32, (t / 50) as f32, 0.0) * 3.0;
            at + [Vec3::ZERO, Vec3::X, Vec3::Y][k]
        });
        for method in [UnwrapMethod::Conformal, UnwrapMethod::Box] {
            let options = UnwrapOptions { size: 64, gutter: 4, method };
            let report = unwrap(mesh.clone(), options).unwrap();
            assert!(report.mended.iter().any(|m| m.what.contains("gutter narrowed")), "{method:?} {:?}", report.mended);
            assert_eq!(n_overlaps(&report.value.mesh, report.value.uv_set, 2048), 0);
        }
        assert!(unwrap(mesh, UnwrapOptions { size: 8, gutter: 2, ..UnwrapOptions::default() }).is_err());
    }

    #[test]
    fn a_second_layout_takes_the_place_of_the_first() {
        let mesh = soup(2, |t, k| [Vec3::ZERO, Vec3::X, Vec3::Y][k] + Vec3::Z * t as f32);
        let once = check("two", mesh, UnwrapMethod::Box);
        let twice = check("two", once.mesh.clone(), UnwrapMethod::Conformal);
        assert_eq!((twice.uv_set, twice.mesh.uv_sets().len()), (0, 1));
    }
}
