//! Cameras: where they stand, what they see, and how they find an object by themselves.

use crate::math::{Bounds, Mat4, Projection, Size, Vec3, exact, unit_or, vec3, vec4};
use crate::placement::Viewpoint;

/// An eye in the world. Right-handed: +X right, +Y up, looking along -Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Camera to world space, a rigid motion.
    pub world_from_camera: Mat4,
    /// Shape of the view volume.
    pub projection: Projection,
    /// What is nearer is not seen, model units. Perspective only.
    pub near: f32,
}

/// A direction to look from, radians: azimuth from +Z towards +X, elevation towards +Y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// 0 sees the front (+Z side), a quarter turn the right (+X) side.
    pub azimuth: f32,
    /// 0 at eye level, a quarter turn straight from above.
    pub elevation: f32,
}

impl Direction {
    /// The three-quarter view of product pictures.
    pub const THREE_QUARTER: Self = Self::degrees(35.0, 20.0);

    /// From degrees.
    pub const fn degrees(azimuth: f32, elevation: f32) -> Self {
        const RADIANS: f32 = std::f32::consts::PI / 180.0;
        Self { azimuth: azimuth * RADIANS, elevation: elevation * RADIANS }
    }

    /// A view by its customary name.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "front" => Self::degrees(0.0, 0.0),
            "back" => Self::degrees(180.0, 0.0),
            "right" => Self::degrees(90.0, 0.0),
            "left" => Self::degrees(-90.0, 0.0),
            "top" => Self::degrees(0.0, 90.0),
            "bottom" => Self::degrees(0.0, -90.0),
            "three-quarter" => Self::THREE_QUARTER,
            _ => return None,
        })
    }

    /// Right, up and backward axes of a camera that looks at its target from here.
    fn axes(self) -> [Vec3; 3] {
        let (sa, ca) = (exact::sin(self.azimuth as f64), exact::cos(self.azimuth as f64));
        let (se, ce) = (exact::sin(self.elevation as f64), exact::cos(self.elevation as f64));
        let v = |x: f64, y: f64, z: f64| vec3(x as f32, y as f32, z as f32);
        [v(ca, 0.0, -sa), v(-sa * se, ce, -ca * se), v(sa * ce, se, ca * ce)]
    }
}

/// The field of view of pictures that look natural, radians.
pub const FOV_Y: f32 = 35.0 * std::f32::consts::PI / 180.0;

impl Camera {
    /// A camera at `eye` that looks at `target`; `up` only needs to be roughly up.
    pub fn looking(eye: Vec3, target: Vec3, up: Vec3, projection: Projection, near: f32) -> Self {
        let back = unit_or(eye - target, Vec3::Z);
        let side = if back.cross(up).length_squared() > 1e-12 { up } else { vec3(0.0, 0.0, -1.0) };
        let right = unit_or(side.cross(back), Vec3::X);
        Self::with_axes([right, back.cross(right), back], eye, projection, near)
    }

    /// A camera that looks from `direction` so that all `points` fill `fill` (0.8: 80 %) of the shorter side, centred, never cropped.
    pub fn framing(points: &[Vec3], direction: Direction, projection: Projection, size: Size, fill: f32) -> Self {
        let axes @ [right, up, back] = direction.axes();
        let bounds = Bounds::of(points.iter().copied());
        let center = bounds.center();
        let radius = bounds.radius().max(1e-20);
        let aspect = size.aspect();
        // Half extents of the view at unit distance (perspective) or relative to each other (parallel), less the margin.
        let half_y = match projection {
            Projection::Perspective { fov_y } => exact::tan(fov_y as f64 * 0.5) as f32,
            Projection::Orthographic { .. } => 1.0,
        };
        let margin = (1.0 - fill) * half_y.min(half_y * aspect);
        let t = [half_y * aspect - margin, half_y - margin];
        let perspective = matches!(projection, Projection::Perspective { .. });
        let lean = if perspective { t } else { [0.0; 2] };
        // How far the object reaches beyond the plane through the centre that each side of the view volume is parallel to.
        let mut reach = [[f32::NEG_INFINITY; 2]; 2];
        for &p in points {
            let q = p - center;
            let (x, y, z) = (q.dot(right), q.dot(up), q.dot(back));
            for (axis, c) in [x, y].into_iter().enumerate() {
                reach[axis][0] = reach[axis][0].max(c + lean[axis] * z);
                reach[axis][1] = reach[axis][1].max(-c + lean[axis] * z);
            }
        }
        if points.is_empty() {
            reach = [[1.0; 2]; 2];
        }
        let offset = (right * (reach[0][0] - reach[0][1]) + up * (reach[1][0] - reach[1][1])) * 0.5;
        let distance = (0..2).map(|i| (reach[i][0] + reach[i][1]) / (2.0 * t[i])).fold(radius * 1e-4, f32::max);
        if perspective {
            let eye = center + offset + back * distance;
            let nearest = distance - points.iter().map(|&p| (p - center).dot(back)).fold(f32::NEG_INFINITY, f32::max);
            // Never so near that depth suffers, never so far that something in view is cut.
            Self::with_axes(axes, eye, projection, (nearest * 0.5).max(distance * 1e-4))
        } else {
            let eye = center + offset + back * (2.0 * radius);
            Self::with_axes(axes, eye, Projection::Orthographic { height: 2.0 * distance }, 0.0)
        }
    }

    fn with_axes([right, up, back]: [Vec3; 3], eye: Vec3, projection: Projection, near: f32) -> Self {
        let world_from_camera = Mat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), eye.extend(1.0));
        Self { world_from_camera, projection, near }
    }

    /// Where the eye is.
    pub fn eye(&self) -> Vec3 {
        self.world_from_camera.w_axis.truncate()
    }

    /// Unit vectors to the right, up, and back from what is seen.
    pub fn axes(&self) -> [Vec3; 3] {
        let m = &self.world_from_camera;
        [m.x_axis, m.y_axis, m.z_axis].map(|a| a.truncate())
    }

    /// World to camera space: the inverse of a rigid motion, by its transpose.
    pub fn camera_from_world(&self) -> Mat4 {
        let [r, u, b] = self.axes();
        let e = self.eye();
        Mat4::from_cols(
            vec4(r.x, u.x, b.x, 0.0),
            vec4(r.y, u.y, b.y, 0.0),
            vec4(r.z, u.z, b.z, 0.0),
            vec4(-r.dot(e), -u.dot(e), -b.dot(e), 1.0),
        )
    }

    /// What eye-dependent coordinates need to know.
    pub fn viewpoint(&self) -> Viewpoint {
        Viewpoint {
            eye_from_world: self.camera_from_world(),
            eye: self.eye(),
            parallel: match self.projection {
                Projection::Perspective { .. } => None,
                Projection::Orthographic { .. } => Some(self.axes()[2]),
            },
        }
    }

    /// World space to homogeneous cells of a grid: `x/w` and `y/w` count cells from the top left corner, `z/w` is the depth
    /// (larger is nearer; 1/w in perspective). `bounds` settle the depth scale of parallel projections.
    pub(crate) fn cells_from_world(&self, size: Size, bounds: Bounds) -> Mat4 {
        let (half_w, half_h) = (size.width as f32 * 0.5, size.height as f32 * 0.5);
        let cells_from_camera = match self.projection {
            Projection::Perspective { fov_y } => {
                let scale = half_h / exact::tan(fov_y as f64 * 0.5) as f32;
                // w = -z; x = scale * x + half_w * w; y = -scale * y + half_h * w; depth numerator 1.
                Mat4::from_cols(
                    vec4(scale, 0.0, 0.0, 0.0),
                    vec4(0.0, -scale, 0.0, 0.0),
                    vec4(-half_w, -half_h, 0.0, -1.0),
                    vec4(0.0, 0.0, 1.0, 0.0),
                )
            }
            Projection::Orthographic { height } => {
                let scale = size.height as f32 / height;
                // Depth runs from 1 behind everything to 2 before everything.
                let back = self.axes()[2];
                let z = bounds.corners().map(|c| (c - self.eye()).dot(back));
                let (lo, hi) = z.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(a, b), &z| (a.min(z), b.max(z)));
                // A flat object seen face on has no depth of its own; its distance must not swamp the scale.
                let k = 1.0 / (hi - lo).max((hi.abs() + lo.abs()) * 1e-3).max(1e-20);
                Mat4::from_cols(
                    vec4(scale, 0.0, 0.0, 0.0),
                    vec4(0.0, -scale, 0.0, 0.0),
                    vec4(0.0, 0.0, k, 0.0),
                    vec4(half_w, half_h, 1.0 - lo * k, 1.0),
                )
            }
        };
        cells_from_camera * self.camera_from_world()
    }

    /// The line of sight through a point of the grid: direction at cell (0, 0)'s corner and its change per cell right and down.
    /// Not unit vectors; for parallel projections the change is zero.
    pub(crate) fn sight(&self, size: Size) -> [Vec3; 3] {
        let [right, up, back] = self.axes();
        match self.projection {
            Projection::Perspective { fov_y } => {
                let step = 2.0 * exact::tan(fov_y as f64 * 0.5) as f32 / size.height as f32;
                let corner = right * (-0.5 * step * size.width as f32) + up * (0.5 * step * size.height as f32) - back;
                [corner, right * step, up * -step]
            }
            Projection::Orthographic { .. } => [-back, Vec3::ZERO, Vec3::ZERO],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn framing_touches_the_margin_and_never_crops() {
        let points: Vec<Vec3> = (0..200)
            .map(|i| {
                let f = |s| crate::math::unit_float(crate::math::hash_cell(i, 0, 0, s)) - 0.5;
                vec3(f(1) * 3.0, f(2), f(3) * 0.5) + vec3(10.0, 20.0, -5.0)
            })
            .collect();
        for projection in [Projection::Perspective { fov_y: FOV_Y }, Projection::Orthographic { height: 1.0 }] {
            for (w, h) in [(1280, 720), (300, 900), (512, 512)] {
                for direction in
                    [Direction::THREE_QUARTER, Direction::degrees(120.0, -60.0), Direction::named("top").unwrap()]
                {
                    let size = Size::new(w, h);
                    let camera = Camera::framing(&points, direction, projection, size, 0.8);
                    let m = camera.cells_from_world(size, Bounds::of(points.iter().copied()));
                    let margin = 0.1 * w.min(h) as f32;
                    let mut slack = f32::INFINITY;
                    for p in &points {
                        let c = m * p.extend(1.0);
                        let (x, y) = (c.x / c.w, c.y / c.w);
                        slack =
                            slack.min(x - margin).min(w as f32 - margin - x).min(y - margin).min(h as f32 - margin - y);
                    }
                    assert!(slack.abs() < 0.05, "{projection:?} {w}x{h} {direction:?}: slack {slack}");
                }
            }
        }
    }

    #[test]
    fn sight_goes_through_what_the_cell_shows() {
        let projection = Projection::Perspective { fov_y: 0.7 };
        let camera = Camera::looking(vec3(1.0, 2.0, 3.0), vec3(0.1, 0.2, 0.0), Vec3::Y, projection, 0.1);
        let size = Size::new(640, 480);
        let m = camera.cells_from_world(size, Bounds::EMPTY);
        let [d, dx, dy] = camera.sight(size);
        let p = camera.eye() + (d + dx * 123.5 + dy * 45.5) * 3.0;
        let c = m * p.extend(1.0);
        assert!((c.x / c.w - 123.5).abs() < 1e-3 && (c.y / c.w - 45.5).abs() < 1e-3);
    }
}
