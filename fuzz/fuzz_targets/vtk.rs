//! Any bytes as VTK's older form: an error or a valid mesh, never a panic.
#![no_main]

impasto_fuzz::mesh_target!(impasto::assets::vtk::read);
