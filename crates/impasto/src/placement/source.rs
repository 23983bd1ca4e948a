//! Where texture coordinates come from: the closed set of sources, and what each needs to know about a surface point.
//!
//! The generating functions are OpenGL's (object linear, eye linear, sphere, reflection and normal map; "The OpenGL
//! Graphics System", version 1.3, 2.10.4) and the usual projections; the two-part mappings are in [`super::two_part`].
//! Pictures stand upright: t runs down, as in every image, so where OpenGL adds a height we subtract it.

use crate::assets::Mesh;
use crate::math::{Bounds, Mat4, Vec3, Vec4, unit_or};
use crate::placement::{Needs, Property, PropertyAxis, two_part::TwoPart};

/// Where on the texture a surface point is. [`super::place`] evaluates it.
#[derive(Clone, Debug, PartialEq)]
pub enum Placement {
    /// The mesh's UV set of this index.
    Uv(usize),
    /// s, t, r are the signed distances (times the planes' lengths) from three planes in the object's own space.
    ObjectLinear {
        /// `(a, b, c, d)`: a x + b y + c z + d.
        planes: [Vec4; 3],
        /// Object to world space; none while scenes are flattened: both are the same.
        world_from_object: Option<Mat4>,
    },
    /// The same from planes that stay with the eye: the texture stands still while the surface moves through it.
    EyeLinear {
        /// In eye space.
        planes: [Vec4; 3],
    },
    /// The same from planes in the world.
    WorldLinear {
        /// In world space.
        planes: [Vec4; 3],
    },
    /// OpenGL's `SPHERE_MAP`: the reflection vector picks a point of a picture of a mirror ball.
    SphereMap,
    /// The reflection vector as (s, t, r), for cube maps.
    ReflectionMap {
        /// In which space it is given.
        space: Space,
    },
    /// The unit normal towards the side that is seen as (s, t, r), for cube maps.
    NormalMap {
        /// In which space it is given.
        space: Space,
    },
    /// The normal as seen along the line of sight picks a point of a picture of a lit ball ("matcap"): the middle faces
    /// the eye and the rim is the silhouette, also off the axis of a perspective view. After the sphere textures of
    /// Teschner and Henn, 1994.
    ViewNormal,
    /// A direction picks a point of a panorama (longitude across, latitude down), seen from inside: its middle looks along
    /// -Z, its right half holds +X, its first row is +Y.
    Equirectangular {
        /// Which direction.
        direction: Direction,
        /// In which space the panorama stands still.
        space: Space,
    },
    /// Parallel projection along the projector's third axis: one picture over the box's front, r from back (0) to front.
    Planar {
        /// None: fitted to the mesh's bounds.
        projector: Option<Projector>,
    },
    /// Around the projector's second axis: s goes once around, from behind over the left, with 1/2 in front; t runs down
    /// its height; r is the distance from the axis in half widths.
    Cylindrical {
        /// None: fitted to the mesh's bounds.
        projector: Option<Projector>,
    },
    /// Longitude and latitude about the projector's origin as on a globe seen from outside, 1/2 in front; r is the
    /// distance from the origin in half widths.
    Spherical {
        /// None: fitted to the mesh's bounds.
        projector: Option<Projector>,
    },
    /// Six pictures, one a side of the box, chosen by the largest part of the normal.
    Box {
        /// None: a cube around the mesh's bounds, so that no side is stretched.
        projector: Option<Projector>,
    },
    /// A slide projector or camera: its picture falls on all that stands before it. Points behind it get (-1, -1).
    Camera {
        /// World to clip space of that camera: the picture is -1 to 1 in x and y (up) after division by w; r is z/w.
        clip_from_world: Mat4,
    },
    /// Through an intermediate surface (Bier and Sloan 1986).
    TwoPart(TwoPart),
    /// Data on the surface: what a colour table is read at. Missing values give NaN.
    Property {
        /// What s, t and r show; none: 1/2, the middle of a table with a single row.
        axes: [Option<PropertyAxis>; 3],
    },
    /// Data as s, and as t how a surface that matt light falls on would look: 0 turned away to 1 turned to it, with 1/2 for
    /// what faces the eye. For tables with shades.
    PropertyInLight {
        /// The data.
        axis: PropertyAxis,
        /// Towards the light, a unit vector in eye space.
        toward: Vec3,
    },
    /// The place itself, for 3-D textures.
    Position {
        /// Measured how.
        unit: PositionUnit,
    },
}

/// A space a direction can be given in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Space {
    /// Stands still when the camera moves.
    #[default]
    World,
    /// Moves with the camera: +X right, +Y up, looking along -Z.
    Eye,
}

/// A direction at a surface point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Direction {
    /// Where a mirror shows the eye to: the line of sight reflected at the normal.
    #[default]
    Reflection,
    /// The normal, towards the side that is seen.
    Normal,
    /// From the space's origin to the point.
    Position,
}

/// How a place is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum PositionUnit {
    /// Model units, from the world's origin.
    #[default]
    Model,
    /// The longest edge of the mesh's bounds is 1, their middle is (1/2, 1/2, 1/2).
    Bounds,
}

/// Where a projection stands in the world, and how large its picture is: an oriented box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projector {
    /// The middle of the box, world space.
    pub origin: Vec3,
    /// To the right, up, and towards the onlooker: unit vectors, orthogonal, right-handed.
    pub axes: [Vec3; 3],
    /// The box's edges along these axes, model units.
    pub size: Vec3,
}

impl Projector {
    /// The box around `bounds`, looked at along -Z.
    pub fn around(bounds: &Bounds) -> Self {
        Self::facing(bounds, Vec3::Z, Vec3::Y)
    }

    /// The box around `bounds` whose front looks to `front`, with `up` upward as far as possible.
    pub fn facing(bounds: &Bounds, front: Vec3, up: Vec3) -> Self {
        let z = unit_or(front, Vec3::Z);
        let spare = if z.y.abs() < 0.9 { Vec3::Y } else { Vec3::NEG_Z * z.y };
        let x = unit_or(up.cross(z), unit_or(spare.cross(z), Vec3::X));
        let axes = [x, z.cross(x), z];
        // The span of a box along an axis is the sum of its edges' shadows on it.
        let extent = bounds.extent();
        let span = |a: Vec3| extent.x * a.x.abs() + extent.y * a.y.abs() + extent.z * a.z.abs();
        Self { origin: bounds.center(), axes, size: Vec3::from(axes.map(span)) }
    }

    /// The same with all edges as long as the longest.
    pub fn cubic(self) -> Self {
        Self { size: Vec3::splat(self.size.x.max(self.size.y).max(self.size.z)), ..self }
    }
}

impl Placement {
    /// Which lanes of the surfels [`super::place`] reads for this source.
    pub fn needs(&self) -> Needs {
        let none = Needs { derivatives: true, ..Needs::default() };
        match self {
            Self::Uv(set) => Needs { uv_sets: 1u32.checked_shl(*set as u32).unwrap_or(0), ..Needs::default() },
            Self::Property { .. } => self.properties().fold(none, |needs, property| needs.or(property.needs())),
            Self::PropertyInLight { axis, .. } => Needs { normal: true, view: true, ..axis.property.needs() },
            _ => Needs { position: self.reads_position(), normal: self.reads_normal(), ..none },
        }
    }

    /// The properties that it shows.
    pub fn properties(&self) -> impl Iterator<Item = &Property> {
        let axes = match self {
            Self::Property { axes } => axes.each_ref().map(Option::as_ref),
            Self::PropertyInLight { axis, .. } => [Some(axis), None, None],
            _ => [None; 3],
        };
        axes.into_iter().flatten().map(|axis| &axis.property)
    }

    /// The UV set whose coordinates and footprints are the answer as they are: no need to place anything.
    pub fn as_uv(&self, matrix: &Mat4) -> Option<usize> {
        match self {
            Self::Uv(set) if *matrix == Mat4::IDENTITY => Some(*set),
            _ => None,
        }
    }

    /// Whether it changes when the eye moves.
    pub fn depends_on_view(&self) -> bool {
        match self {
            Self::EyeLinear { .. } | Self::SphereMap | Self::ReflectionMap { .. } | Self::ViewNormal => true,
            Self::NormalMap { space } => *space == Space::Eye,
            Self::Equirectangular { direction, space } => *direction == Direction::Reflection || *space == Space::Eye,
            Self::TwoPart(two_part) => two_part.depends_on_view(),
            Self::PropertyInLight { .. } => true,
            _ => false,
        }
    }

    /// Whether the mesh has what it asks for: the UV set, the fields and their components.
    pub fn fits(&self, mesh: &Mesh) -> bool {
        match self {
            Self::Uv(set) => *set < mesh.uv_sets().len().min(32),
            _ => self.properties().all(|property| property.fits(mesh)),
        }
    }

    fn reads_position(&self) -> bool {
        !matches!(self, Self::NormalMap { .. } | Self::Equirectangular { direction: Direction::Normal, .. })
    }

    fn reads_normal(&self) -> bool {
        match self {
            Self::SphereMap | Self::ReflectionMap { .. } | Self::NormalMap { .. } | Self::ViewNormal => true,
            Self::Equirectangular { direction, .. } => *direction != Direction::Position,
            Self::Box { .. } => true,
            Self::TwoPart(two_part) => two_part.reads_normal(),
            _ => false,
        }
    }
}

/// Which lanes of the surfels a placement reads.
pub fn needs(placement: &Placement) -> Needs {
    placement.needs()
}

/// The UV set that a placement under a matrix simply is, if any; look-up then reads `surfels.uv[set]` directly.
pub fn as_uv(placement: &Placement, matrix: &Mat4) -> Option<usize> {
    placement.as_uv(matrix)
}
