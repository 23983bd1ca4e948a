//! Bring outside data in, clean, once; put results out. One file a format.
//!
//! Readers work on bytes. What a file refers to (materials, buffers, images) comes through a [`Neighbours`] function, so
//! that the engine also runs where there is no file system. The first valid form of everything is [`Mesh`], [`Image`],
//! [`Field`], [`Scene`]; no format's quirk gets past its reader.

pub mod field;
pub mod glb;
pub mod gltf_in;
pub mod image;
pub mod image_files;
pub mod image_write;
pub mod material;
pub mod mend;
pub mod mesh;
pub mod scene;

pub use field::{Element, Field, Values};
pub use image::{Image, Texels, TextureImage};
pub use material::{AlphaMode, Filter, Material, MinFilter, Sampler, TextureRef, UvTransform, Wrap};
pub use mesh::{Mesh, Part, RawMesh, UvSet};
pub use scene::{Scene, SceneCamera, SceneLight, SceneLightKind};

/// Fetches a file that another file names, by the name as written there (percent-decoded, forward slashes).
pub type Neighbours<'a> = dyn Fn(&str) -> std::io::Result<Vec<u8>> + 'a;
