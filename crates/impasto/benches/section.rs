//! Sections with grain over a window of 1280 x 720 places, 30 a spacing; cuts of large meshes; a frame of a cut body.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use impasto::math::{BATCH, DVec3, Vec3, vec2, vec3};
use impasto::par::{Level, Workers};
use impasto::recipe::render::Stage;
use impasto::recipe::{prepare, text};
use impasto::samples;
use impasto::section::Plane;
use impasto::section::cut::{self, Policy, Relief};
use impasto::section::grain::{
    Cells, CellsSpec, Fibres, FibresSpec, Filling, Grain, GrainSpec, Hit, Hits, Look, SectionKind, Sections, Side,
    Window,
};
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

const SIZE: [usize; 2] = [1280, 720];
const SPACING: f32 = 1.0;
const PITCH: f32 = SPACING / 30.0;
const KINDS: [SectionKind; 3] = [SectionKind::Tear, SectionKind::Hollow, SectionKind::Solid];

fn plane() -> Plane {
    Plane::through(vec3(0.3, 0.2, 0.7), vec3(1.0, 1.0, 1.0)).expect("a plane")
}

fn window(plane: &Plane) -> Window {
    let half = vec2(SIZE[0] as f32, SIZE[1] as f32) * (0.5 * PITCH);
    Window::around(plane, DVec3::new(5.0, 3.0, 1.0), half)
}

fn place(window: &Window, i: usize, k: usize) -> f32 {
    [window.min.x, window.min.y][k] + (i as f32 + 0.5) * PITCH
}

/// Balls by the list of discs, as caps of spheres are drawn: list and all places.
fn discs(grain: &Grain, look: Look, workers: &Workers) -> f32 {
    let plane = plane();
    let window = window(&plane);
    let list = grain.discs(&plane, window).expect("few enough");
    let mut sums = vec![0.0f32; SIZE[1]];
    let scratch = || (Vec::new(), Hits::new());
    workers.for_each_with(&mut sums, scratch, |(near, hits), row, sum| {
        let ys = [place(&window, row, 1); BATCH];
        for first in (0..SIZE[0]).step_by(BATCH) {
            let xs = std::array::from_fn(|i| place(&window, first + i, 0));
            list.eval_batch(workers.level(), [&xs, &ys], BATCH, look, (near, hits));
            *sum += hits.height[0];
        }
    });
    sums.iter().sum()
}

/// Any filling by rows: list and all places, on one thread.
fn rows(filling: &Filling, look: Look) -> f32 {
    let plane = plane();
    let window = window(&plane);
    let depth = |_: DVec3| 1.0;
    let sections = Sections::new(filling, &plane, window, look, &depth);
    let xs: Vec<f32> = (0..SIZE[0]).map(|i| place(&window, i, 0)).collect();
    let nothing = Filling::Plain.eval(DVec3::ZERO, &plane, look, &depth);
    let mut hits: Vec<Hit> = vec![nothing; SIZE[0]];
    let level = Level::new();
    let row = |row| {
        sections.row(level, place(&window, row, 1), &xs, &mut hits);
        hits[SIZE[0] / 2].height
    };
    (0..SIZE[1]).map(row).sum()
}

fn sections(c: &mut Criterion) {
    let mut group = c.benchmark_group("section");
    group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(600));
    let balls = GrainSpec::spheres(SPACING, SPACING * 0.5);
    let grain = Grain::new(balls.clone()).expect("a grain");
    let particles = |spec| Filling::Particles(Box::new(Grain::new(spec).expect("a grain")));
    let cells = |wall| Filling::Cells(Box::new(Cells::new(CellsSpec::of(SPACING, wall)).expect("cells")));
    let fibres = FibresSpec::of(SPACING, SPACING * 0.45, vec3(0.2, 0.3, 1.0));
    let fillings = [
        ("balls", particles(balls)),
        ("rods", particles(GrainSpec::cylinders(SPACING, SPACING * 0.5, SPACING * 0.8, Vec3::Z))),
        ("cells", cells(0.0)),
        ("cells with walls", cells(SPACING * 0.1)),
        ("fibres", Filling::Fibres(Box::new(Fibres::new(fibres).expect("fibres")))),
    ];
    for kind in KINDS {
        let look = Look { kind, side: Side::Below };
        for n_threads in [1, 2] {
            let workers = Workers::new(n_threads);
            let label = format!("{kind:?}, discs of balls, {n_threads} thread(s)");
            group.bench_function(label, |b| b.iter(|| black_box(discs(&grain, look, &workers))));
        }
        for (name, filling) in &fillings {
            // Openings of walled cells are worked out place by place: too slow to be measured ten times.
            if *name == "cells with walls" && kind != SectionKind::Solid {
                continue;
            }
            group.bench_function(format!("{kind:?}, {name}"), |b| b.iter(|| black_box(rows(filling, look))));
        }
    }
    group.finish();
}

fn cuts(c: &mut Criterion) {
    let mut group = c.benchmark_group("cut");
    group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(600));
    let plane = Plane::through(vec3(0.03, 0.02, 0.01), vec3(1.0, 0.2, 1.0)).expect("a plane");
    let large = samples::plain::displaced_sphere(708, 708);
    let n = large.triangles().len() / 1000;
    group.bench_function(format!("{n} k triangles"), |b| {
        b.iter_batched(|| (), |()| cut::cut(&large, &plane, Policy::Winding), BatchSize::PerIteration);
    });
    let middling = samples::plain::displaced_sphere(188, 188);
    let n = middling.triangles().len() / 1000;
    let grain = Grain::new(GrainSpec::spheres(0.06, 0.03)).expect("a grain");
    let shows = |p: DVec3, side| grain.eval(p, &plane, Look { kind: SectionKind::Tear, side });
    let relief = Relief { pitch: 0.0075, points: &[], shows: &shows };
    group.bench_function(format!("{n} k triangles, with relief"), |b| {
        let cut = || cut::cut_with_relief(&middling, &plane, Policy::Winding, &relief);
        b.iter_batched(|| (), |()| cut(), BatchSize::PerIteration);
    });
    group.finish();
}

/// A frame of a body cut open, both halves with maps and true relief, 1280 x 720, one sample. The bunny where it is found.
fn frame(c: &mut Criterion) {
    let bunny = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/1_meshes/bunny/bun_zipper.ply");
    let (name, file, figure) = match Path::new(bunny).exists() {
        true => ("bunny", bunny, "figure = 6"),
        false => ("nodule", "sample:nodule", "spacing = 0.06"),
    };
    let text = format!(
        "[input]\nfile = {file:?}\n[cut]\n{figure}\nkind = \"tear\"\n[picture]\nsize = [1280, 720]\nsamples = 1\n"
    );
    let recipe = text::parse(&text, Path::new("frame.toml")).expect("a recipe");
    let mut group = c.benchmark_group("frame");
    group.sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_millis(1500));
    let workers = Workers::new(2);
    let prepared = prepare(&recipe, Path::new(""), &workers).expect("a picture").value;
    let mut stage = Stage::default();
    group.bench_function(name, |b| b.iter(|| black_box(prepared.render_on(&mut stage, &workers, &|_| ()))));
}

criterion_group!(benches, sections, cuts, frame);
criterion_main!(benches);
