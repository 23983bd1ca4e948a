//! A layout for surfaces that have none: cut into charts, laid flat, packed into one square without overlap.
//!
//! The charts of [`UnwrapMethod::Conformal`] are crate `uvunwrap`'s: grown within a cone of normals, flattened by least
//! squares conformal maps (Lévy et al. 2002) and as-rigid-as-possible steps (Liu et al. 2008), packed by their shapes.
//! It sits behind [`conformal`] alone, so that another can take its place. Same bytes on every machine.

use crate::assets::{Mesh, UvSet};
use crate::error::{Error, Report, Result, note};
use crate::math::{Vec2, vec2};
use crate::placement::Stretch;
use crate::placement::box_charts::{Layout, box_charts};
use crate::placement::split::split_corners;
use crate::placement::stretch::stretch;

/// The name of the UV set that [`unwrap()`] adds.
pub const UNWRAPPED: &str = "unwrapped";

/// From this many triangles on charts are packed by their outlines' extents: packing their shapes takes too long.
const MOST_SHAPED: usize = 30_000;

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
    let positions: &[[f32; 3]] = bytemuck::cast_slice(mesh.positions());
    let indices: &[u32] = bytemuck::cast_slice(mesh.triangles());
    let packing = match mesh.triangles().len() {
        n if n > MOST_SHAPED => uvunwrap::Packing::Fast,
        _ => uvunwrap::Packing::Shape,
    };
    let options = uvunwrap::Options {
        density: uvunwrap::Density::Auto { page_size: size },
        padding: gutter,
        packing,
        ..uvunwrap::Options::default()
    };
    let run = |instance_scales: &[f32]| {
        let input = uvunwrap::MeshInput { instance_scales, ..uvunwrap::MeshInput::new(positions, indices) };
        uvunwrap::generate(&[input], &options).map_err(|e| e.to_string())
    };
    let mut atlas = run(&[])?;
    if atlas.page_count > 1 {
        // More charts than one page holds at a bearable density: as a single instance they must share it.
        atlas = run(&[1.0])?;
    }
    let [made] = &atlas.meshes[..] else { return Err("no mesh came back".into()) };
    if atlas.chart_count == 0 || made.indices.len() != indices.len() {
        return Ok(None);
    }
    let (low, high) = made.instances.first().map_or(([0.0; 2], [1.0; 2]), |r| (r.min, r.max));
    // The page is cropped to what it uses; ours is square.
    let edge = size.max(atlas.width).max(atlas.height) as f32;
    let scale = [atlas.width as f32 / edge, atlas.height as f32 / edge];
    let place = |uv: [f32; 2]| {
        let [u, v] = [0, 1].map(|k: usize| (low[k] + uv[k] * (high[k] - low[k])) * scale[k]);
        // Their triangles run the other way around: turn v, or pictures would be mirrored.
        vec2(u, 1.0 - v).clamp(Vec2::ZERO, Vec2::ONE)
    };
    let uv = made.indices.iter().map(|&v| place(made.vertices[v as usize].uv)).collect();
    let gutter_texels = gutter as f64 * size as f64 / edge as f64;
    Ok(Some(Layout { uv, n_charts: atlas.chart_count as usize, gutter_texels }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::RawMesh;
    use crate::math::vec3;
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
}
