//! What it costs to show data another way while the view stands: 1920x1080, one sample, one thread, so that the times are CPU
//! times. The picture is finished to its bytes, legend included.

use criterion::{Criterion, criterion_group, criterion_main};
use impasto::Report;
use impasto::assets::{Element, Field, Scene, Values};
use impasto::math::Vec3;
use impasto::par::Workers;
use impasto::recipe::render::Stage;
use impasto::recipe::{Recipe, prepare_scene, text};
use impasto::samples::bench;
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

/// A displaced sphere with a smooth field.
fn scene(name: &str) -> Scene {
    let mut raw = bench::mesh(name).expect("a scene of the baseline");
    let wave = |p: Vec3| 0.5 + 0.5 * (3.0 * p.x * p.y - 2.0 * p.z);
    let values = Values::F32(raw.positions.iter().map(|p| wave(*p)).collect());
    let (name, unit) = ("t".into(), "K".into());
    raw.fields.push(Field { name, unit, element: Element::Vertex, n_components: 1, values });
    Scene::of("a sphere", raw.mend().value)
}

/// Colours and lines of the field; in `light`, or shaded so that they are read as they are.
fn recipe(table: &str, range: [f64; 2], step: f64, light: Option<&str>) -> Recipe {
    let (shading, shades) = if light.is_some() { ("lambert", false) } else { ("unlit", true) };
    let light = light.unwrap_or("studio");
    let text = format!(
        "[picture]\nsize = [1920, 1080]\nsamples = 1\nlight = \"{light}\"\n[surface]\nshading = \"{shading}\"\n\
         [[layers]]\ntable = \"{table}\"\nfield = \"t\"\nrange = {range:?}\nshades = {shades}\noperator = \"replace\"\n\
         [[layers]]\nisolines = {step:?}\nfield = \"t\"\noperator = \"decal\"\n"
    );
    text::parse(&text, Path::new("change.toml")).expect("a recipe")
}

fn change(c: &mut Criterion) {
    let workers = Workers::new(1);
    let mut group = c.benchmark_group("change");
    group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_millis(1000));
    let first = || recipe("viridis", [0.0, 1.0], 0.1, None);
    let ways = [
        ("range", [first(), recipe("viridis", [0.2, 0.7], 0.1, None)]),
        ("table", [first(), recipe("batlow", [0.0, 1.0], 0.1, None)]),
        ("isolines", [first(), recipe("viridis", [0.0, 1.0], 0.07, None)]),
        ("light", ["studio", "headlight"].map(|light| recipe("viridis", [0.0, 1.0], 0.1, Some(light)))),
    ];
    for name in ["sphere10k", "sphere100k", "sphere1m"] {
        for (what, states) in &ways {
            let report = Report { value: scene(name), mended: Vec::new() };
            let mut prepared = prepare_scene(&states[0], report, Path::new(""), &workers).expect("a picture").value;
            let mut stage = Stage::standing_still();
            prepared.render_on(&mut stage, &workers, &|_| ());
            let mut turn = 0;
            group.bench_function(format!("{name}, {what}"), |b| {
                b.iter(|| {
                    turn = 1 - turn;
                    prepared.change(&states[turn]).expect("a change");
                    black_box(prepared.render_on(&mut stage, &workers, &|_| ()))
                });
            });
        }
        let report = Report { value: scene(name), mended: Vec::new() };
        let prepared = prepare_scene(&first(), report, Path::new(""), &workers).expect("a picture").value;
        let mut stage = Stage::default();
        group.bench_function(format!("{name}, whole frame"), |b| {
            b.iter(|| black_box(prepared.render_on(&mut stage, &workers, &|_| ())));
        });
    }
    group.finish();
}

criterion_group!(benches, change);
criterion_main!(benches);
