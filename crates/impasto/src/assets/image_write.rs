//! Texels and numbers to files: PNG, OpenEXR, NPY.
