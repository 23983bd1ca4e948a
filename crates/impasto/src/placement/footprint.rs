//! How much of the texture one cell covers: what level of detail and anisotropy are chosen by.

use crate::math::{Size, Vec2, vec2};
use crate::placement::TexCoords;

/// How far the texture coordinate moves from one cell to the next.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Footprint {
    /// Change of `uv` for one cell to the right, in texture widths and heights.
    pub duv_dx: Vec2,
    /// Change of `uv` for one cell down.
    pub duv_dy: Vec2,
}

impl Footprint {
    /// The footprint of cell `i` of a batch.
    pub fn of(coords: &TexCoords, i: usize) -> Self {
        Self { duv_dx: vec2(coords.d_dx[0][i], coords.d_dx[1][i]), duv_dy: vec2(coords.d_dy[0][i], coords.d_dy[1][i]) }
    }

    /// Lengths of the longer and the shorter half axis, in texels, of the ellipse that a circle of one cell's radius
    /// becomes on a texture of `size` (Heckbert, "Fundamentals of Texture Mapping and Image Warping", 1989: the singular
    /// values of the Jacobian). The longer over the shorter is the anisotropy; log2 of the shorter the level of detail.
    pub fn axes_texels(&self, size: Size) -> [f32; 2] {
        let scale = vec2(size.width as f32, size.height as f32);
        let (dx, dy) = (self.duv_dx * scale, self.duv_dy * scale);
        // Squared singular values are the roots of z^2 - (|dx|^2 + |dy|^2) z + det^2.
        let half_trace = 0.5 * (dx.length_squared() + dy.length_squared());
        let det = dx.perp_dot(dy).abs();
        let squared = (half_trace - det) * (half_trace + det);
        let major = (half_trace + if squared > 0.0 { squared.sqrt() } else { 0.0 }).sqrt();
        [major, if major > 0.0 { det / major } else { 0.0 }]
    }

    /// Texels under one cell on a texture of `size`.
    pub fn area_texels(&self, size: Size) -> f32 {
        self.duv_dx.perp_dot(self.duv_dy).abs() * size.n_cells() as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(dx: [f32; 2], dy: [f32; 2], axes: [f32; 2]) {
        let footprint = Footprint { duv_dx: dx.into(), duv_dy: dy.into() };
        let size = Size::new(200, 100);
        let got = footprint.axes_texels(size);
        assert!((got[0] - axes[0]).abs() < 1e-4 && (got[1] - axes[1]).abs() < 1e-4, "{got:?} not {axes:?}");
        assert!((footprint.area_texels(size) - axes[0] * axes[1]).abs() < 1e-3);
    }

    #[test]
    fn axes_are_the_singular_values() {
        check([0.01, 0.0], [0.0, 0.02], [2.0, 2.0]);
        check([0.04, 0.0], [0.0, 0.02], [8.0, 2.0]);
        check([0.0, 0.03], [0.005, 0.0], [3.0, 1.0]);
        check([0.02, 0.04], [0.0, 0.0], [(16.0f32 + 16.0).sqrt(), 0.0]);
        check([0.01, 0.02], [-0.02, 0.04], [32f32.sqrt(), 8f32.sqrt()]);
        check([0.0, 0.0], [0.0, 0.0], [0.0, 0.0]);
    }
}
