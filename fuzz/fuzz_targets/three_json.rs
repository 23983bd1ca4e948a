//! Any bytes as three.js' JSON: an error or a valid mesh, never a panic.
#![no_main]

impasto_fuzz::mesh_target!(impasto::assets::three_json::read);
