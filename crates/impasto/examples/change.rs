//! One surface, its data shown in ten ranges: the view is found once, each picture costs a look-up.

use impasto::par::Workers;
use impasto::recipe::render::Stage;
use impasto::recipe::{prepare, text};
use std::path::Path;

const RECIPE: &str = r#"
[input]
file = "sample:flange"

[surface]
shading = "unlit"

[[layers]]
table = "batlow"
field = "stress"
shades = true
operator = "replace"
"#;

fn main() -> impasto::Result<()> {
    let workers = Workers::new(0);
    let mut recipe = text::parse(RECIPE, Path::new("change.toml"))?;
    let mut prepared = prepare(&recipe, Path::new(""), &workers)?.value;
    let mut stage = Stage::standing_still();
    for step in 1..=10 {
        recipe.layers[0].range = Some([0.0, 20.0 * step as f64]);
        prepared.change(&recipe)?;
        let picture = prepared.render_on(&mut stage, &workers, &|_| ());
        let path = std::env::temp_dir().join(format!("change-{step}.png"));
        std::fs::write(&path, picture.png(&[])).map_err(|source| impasto::Error::Write { path, source })?;
    }
    Ok(())
}
