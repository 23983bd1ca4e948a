//! Bring outside data in, clean, once; put results out. One file a format.
//!
//! Readers work on bytes. What a file refers to (materials, buffers, images) comes through a [`Neighbours`] function, so
//! that the engine also runs where there is no file system. The first valid form of everything is [`Mesh`], [`Image`],
//! [`Field`], [`Grid`], [`Molecule`], [`Scene`]; no format's quirk gets past its reader.

pub mod animation;
#[cfg(test)]
mod broken;
mod cells;
mod dataset;
pub mod cube;
pub mod cube_layout;
mod dem;
pub mod dx;
mod edges;
pub mod elements;
pub mod field;
pub mod files;
pub mod gifti;
pub mod glb;
pub mod gltf_in;
pub mod grid;
pub mod height_map;
pub mod image;
pub mod image_files;
pub mod image_write;
pub mod join;
pub mod isolevel;
pub mod isosurface;
mod lipophilicity;
pub mod material;
pub mod mend;
pub mod mesh;
pub mod molecular_surface;
pub mod molecule;
pub mod mrc;
mod mtl;
mod nearby;
mod normals;
pub mod npy;
pub mod nrrd;
mod numbers;
pub mod obj;
mod obj_write;
pub mod off;
mod packed;
mod pieces;
pub mod pdb;
pub mod ply;
mod ply_header;
pub mod ply_write;
pub mod png_text;
mod polygon;
pub mod pqr;
pub mod scene;
mod split;
pub mod stl;
mod table;
mod text;
pub mod three_json;
pub mod topology;
pub mod vtk;
pub mod vtk_xml;
pub mod vtp_write;
pub mod volume;
pub mod volume_scene;
mod weld;
mod winding;

pub use cube_layout::CubeLayout;
pub use field::{Element, Field, Values};
pub use grid::{Grid, Lattice};
pub use image::{Image, Texels, TextureImage};
pub use material::{AlphaMode, Filter, Material, MinFilter, Sampler, TextureRef, UvTransform, Wrap};
pub use mend::MendOptions;
pub use mesh::{Mesh, Part, RawMesh, UvSet};
pub use molecule::{Atom, Molecule};
pub use scene::{Scene, SceneCamera, SceneLight, SceneLightKind};
pub use topology::Topology;

/// Fetches a file that another file names, by the name as written there (percent-decoded, forward slashes).
pub type Neighbours<'a> = dyn Fn(&str) -> std::io::Result<Vec<u8>> + 'a;
