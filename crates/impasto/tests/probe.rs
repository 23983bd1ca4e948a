//! What is read off a picture is what was drawn: probed values give the unlit picture's bytes at every pixel.

use impasto::inspect;
use impasto::par::Workers;
use impasto::picture::develop_row;
use impasto::recipe::{self, Recipe, text};
use impasto::visibility::Samples;
use std::path::Path;

fn check(toml: &str) {
    let mut recipe: Recipe = text::parse(toml, Path::new("inline")).unwrap();
    recipe.picture.size = Some([48, 36]);
    recipe.picture.samples = Some(1);
    recipe.picture.unlit = Some(true);
    let workers = Workers::new(1);
    let prepared = recipe::prepare(&recipe, Path::new(""), &workers).unwrap().value;
    let picture = prepared.render(&workers, &|_| ());
    let (domain, shot) = (prepared.domain(), prepared.shot(Samples::One));
    let mut n_covered = 0;
    for y in 0..36 {
        for x in 0..48 {
            let probe = inspect::probe(&domain, &shot, [x, y], &workers);
            let mut pixel = [[0; 4]];
            develop_row(
                &prepared.develop,
                &workers,
                &[probe.unlit],
                prepared.background.row(y, prepared.size),
                y,
                &mut pixel,
            );
            let drawn = picture.pixels[(y * 48 + x) as usize];
            assert_eq!(pixel[0], drawn, "pixel {x},{y} of {toml}");
            n_covered += !probe.found.is_empty() as usize;
            for f in &probe.found {
                assert!((f.barycentric.iter().sum::<f32>() - 1.0).abs() < 1e-5);
                let corners = f.vertices.map(|v| prepared.scene.mesh.positions()[v as usize]);
                let p = corners[0] * f.barycentric[0] + corners[1] * f.barycentric[1] + corners[2] * f.barycentric[2];
                assert!((p - f.position).length() < 1e-4 * prepared.scene.mesh.bounds().radius());
            }
        }
    }
    assert!(n_covered > 200, "{n_covered} pixels are covered in {toml}");
}

#[test]
fn probed_values_give_the_unlit_picture() {
    check("[input]\nfile = 'sample:displaced'\nresolution = 24");
    check("[input]\nfile = 'sample:cube'\nresolution = 8\n[camera]\northographic = true");
}

#[test]
fn probed_values_give_the_unlit_picture_of_masks_and_layers() {
    let dots = "[[layers]]\nimage = 'sample:alpha-dots'\ntexels = 64\nscale = [4.0, 2.0]";
    check(&format!(
        "[input]\nfile = 'sample:displaced'\nresolution = 24\n[surface]\nplain = true\nalpha_mode = 'mask'\n{dots}"
    ));
    check("[input]\nfile = 'sample:knot'\nresolution = 16\n[surface]\nalpha = 0.4\ncolor = '#3070c0'");
}

#[test]
fn the_atlas_is_probed_as_it_is_drawn() {
    check("[input]\nfile = 'sample:cube'\nresolution = 8\n[camera]\nview = 'atlas'");
}

/// Channels say what the probe says.
#[test]
fn channels_agree_with_probes() {
    let workers = Workers::new(2);
    let recipe =
        text::parse("[input]\nfile = 'sample:flange'\nresolution = 24\n[picture]\nsize = [32, 24]", Path::new("a"));
    let prepared = recipe::prepare(&recipe.unwrap(), Path::new(""), &workers).unwrap().value;
    let (domain, shot) = (prepared.domain(), prepared.shot(Samples::One));
    let buffer = inspect::probe::buffer(&domain, &shot, &workers);
    let quantities = inspect::quantities(&buffer, &domain, &shot, &workers);
    let named = |name: &str| quantities.iter().find(|q| q.name == name).unwrap_or_else(|| panic!("there is {name}"));
    let inspect::Values::U32(triangles) = &named("triangle").values else { panic!("ids are whole") };
    let inspect::Values::F32(positions) = &named("position").values else { panic!("positions are not") };
    for cell in 0..32 * 24 {
        let probe = inspect::probe(&domain, &shot, [cell % 32, cell / 32], &workers);
        match probe.found.first() {
            None => assert_eq!(triangles[cell as usize], u32::MAX),
            Some(f) => {
                assert_eq!(triangles[cell as usize], f.triangle);
                assert_eq!(positions[cell as usize * 3..][..3], f.position.to_array());
            }
        }
    }
}
