//! How much a layout distorts the surface.
//!
//! Sander, Snyder, Gortler, Hoppe, "Texture Mapping Progressive Meshes", 2001: the singular values of the map from the
//! texture plane to the surface say how far a texel is stretched.

use crate::math::{Vec2, Vec3};

/// How much a layout distorts. 1 is an even layout: every texel covers as much of the surface, in every direction.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Stretch {
    /// Root mean square over surface and directions.
    pub l2: f64,
    /// The largest stretch of any triangle in any direction.
    pub max: f64,
    /// Triangles with area on the surface and none in the layout; they count in neither number.
    pub n_collapsed: usize,
    /// The share of the texture that triangles cover, when they do not overlap.
    pub coverage: f64,
}

/// Measures the layout `uv` of triangles.
pub fn stretch(positions: &[Vec3], triangles: &[[u32; 3]], uv: &[Vec2]) -> Stretch {
    let (mut area_surface, mut area_uv, mut sum, mut max, mut n_collapsed) = (0.0, 0.0, 0.0, 0.0f64, 0);
    for t in triangles {
        let [p, q, r] = t.map(|v| positions[v as usize].as_dvec3());
        let [a, b, c] = t.map(|v| uv[v as usize].as_dvec2());
        let area = 0.5 * (q - p).cross(r - p).length();
        let det = (b - a).perp_dot(c - a);
        area_uv += 0.5 * det.abs();
        if area == 0.0 {
            continue;
        }
        if det == 0.0 {
            n_collapsed += 1;
            continue;
        }
        // Columns of the Jacobian from the texture plane to the surface.
        let ds = ((q - p) * (c - a).y - (r - p) * (b - a).y) / det;
        let dt = ((r - p) * (b - a).x - (q - p) * (c - a).x) / det;
        let (e, f, g) = (ds.dot(ds), ds.dot(dt), dt.dot(dt));
        let major_squared = 0.5 * (e + g + ((e - g) * (e - g) + 4.0 * f * f).sqrt());
        sum += 0.5 * (e + g) * area;
        area_surface += area;
        max = max.max(major_squared.sqrt());
    }
    let per_texel = if area_surface > 0.0 { (area_uv / area_surface).sqrt() } else { 0.0 };
    let l2 = if area_surface > 0.0 { (sum / area_surface).sqrt() * per_texel } else { 0.0 };
    Stretch { l2, max: max * per_texel, n_collapsed, coverage: area_uv }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{vec2, vec3};

    #[track_caller]
    fn check(scale: [f32; 2], l2: f64, max: f64) {
        let positions = [Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0), Vec3::Y];
        let uv = positions.map(|p| vec2(p.x * scale[0], p.y * scale[1]));
        let got = stretch(&positions, &[[0, 1, 2], [0, 2, 3]], &uv);
        assert!((got.l2 - l2).abs() < 1e-6 && (got.max - max).abs() < 1e-6, "{got:?} not {l2}, {max}");
        assert!((got.coverage - (scale[0] * scale[1]) as f64).abs() < 1e-6);
    }

    #[test]
    fn an_even_layout_has_stretch_one_at_any_scale() {
        check([1.0, 1.0], 1.0, 1.0);
        check([0.25, 0.25], 1.0, 1.0);
        // Texels four times as long as wide: singular values 2 and 1/2 at equal area.
        check([1.0, 0.25], ((4.0f64 + 0.25) / 2.0).sqrt(), 2.0);
    }
}
