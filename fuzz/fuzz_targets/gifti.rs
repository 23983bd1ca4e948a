//! Any bytes as GIfTI: an error or a valid mesh, never a panic.
#![no_main]

impasto_fuzz::mesh_target!(impasto::assets::gifti::read);
