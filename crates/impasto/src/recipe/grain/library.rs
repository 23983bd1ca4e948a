//! Grains that people name, and where to find those of their own.

use super::{GrainRecipe, make};
use crate::error::{Error, Result};
use std::path::Path;

/// The built-in grains: their names, and their files.
const LIBRARY: [(&str, &str); 14] = [
    ("bone", include_str!("../../../grains/bone.toml")),
    ("bread", include_str!("../../../grains/bread.toml")),
    ("citrus", include_str!("../../../grains/citrus.toml")),
    ("concrete", include_str!("../../../grains/concrete.toml")),
    ("geode", include_str!("../../../grains/geode.toml")),
    ("granite", include_str!("../../../grains/granite.toml")),
    ("ice", include_str!("../../../grains/ice.toml")),
    ("muscle", include_str!("../../../grains/muscle.toml")),
    ("pomegranate", include_str!("../../../grains/pomegranate.toml")),
    ("pumice", include_str!("../../../grains/pumice.toml")),
    ("salt", include_str!("../../../grains/salt.toml")),
    ("sponge", include_str!("../../../grains/sponge.toml")),
    ("tissue", include_str!("../../../grains/tissue.toml")),
    ("wood", include_str!("../../../grains/wood.toml")),
];

/// The name and the file of each built-in grain, in the order of the alphabet.
pub fn grains() -> impl Iterator<Item = (&'static str, GrainRecipe)> {
    LIBRARY.iter().map(|(name, text)| {
        let path = format!("{name}.toml");
        (*name, GrainRecipe::parse(text, Path::new(&path)).expect("built-in grains are right"))
    })
}

/// All that a grain can be called: shapes of particles first, then the built-in ones.
pub(in crate::recipe) fn all_names() -> impl Iterator<Item = &'static str> {
    make::names().chain(["none"]).chain(LIBRARY.iter().map(|(name, _)| *name))
}

/// The text of a built-in grain, as a start for one's own.
pub fn text(name: &str) -> Option<&'static str> {
    LIBRARY.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The grain of a name: a built-in one, or a file `NAME.toml` beside `base`. None if it can only be a shape of particles.
///
/// # Errors
/// What the file's reader says.
pub fn find(name: &str, base: &Path) -> Result<Option<GrainRecipe>> {
    if let Some(text) = text(name) {
        return GrainRecipe::parse(text, Path::new(name)).map(Some);
    }
    if !name.ends_with(".toml") {
        return Ok(None);
    }
    let path = base.join(name);
    let text = std::fs::read_to_string(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
    GrainRecipe::parse(&text, &path).map(Some)
}
