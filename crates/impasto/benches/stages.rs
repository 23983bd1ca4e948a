//! The stages of a frame, and whole frames, on the baseline's scenes at 1280x720.

use criterion::{Criterion, criterion_group, criterion_main};
use impasto::math::Size;
use impasto::par::Workers;
use impasto::picture::Film;
use impasto::picture::baseline::Baseline;
use impasto::picture::render::{self, Cells, Renderer};
use impasto::samples::bench::NAMES;
use impasto::visibility::{Domain, Samples, Tile};
use std::hint::black_box;
use std::time::Duration;

fn stages(c: &mut Criterion) {
    let size = Size::new(1280, 720);
    let workers = Workers::new(0);
    for name in NAMES {
        let baseline = Baseline::new(name).expect("a scene of the baseline");
        let mut group = c.benchmark_group(name);
        group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(600));
        for samples in [Samples::One, Samples::Four] {
            let shot = baseline.shot(samples);
            let camera = baseline.camera(0);
            let domain = Domain::through_camera(&baseline.mesh, &camera, size);
            let draws = render::draws(&baseline.mesh, shot.looks);
            let mut renderer = Renderer::default();
            renderer.sort(&domain, &shot, &workers);
            let [n_x, n_y] = renderer.tiles.n_tiles();
            let mut picture = vec![[0u8; 4]; size.n_cells()];
            let label = |stage: &str| format!("{stage}, {} sample(s)", samples.n());

            group.bench_function(label("vertex"), |b| b.iter(|| renderer.tiles.snap(&domain, &workers)));
            group.bench_function(label("bin"), |b| b.iter(|| renderer.tiles.sort(&domain, &draws, samples, &workers)));
            group.bench_function(label("raster"), |b| {
                b.iter(|| {
                    let tiles = &renderer.tiles;
                    workers.for_each_with(&mut vec![(); n_x * n_y], Tile::default, |tile, i, ()| {
                        tiles.rasterize(i, None, &workers, tile);
                    });
                });
            });
            let film = Film::new(&Baseline::DEVELOP, &Baseline::BACKGROUND, size, &workers);
            let finish = |[_, y]: [u32; 2], cells: Cells, row: &mut [[u8; 4]]| {
                film.row(y, cells, row);
            };
            let buffer = render::info_buffer(&domain, &shot, &workers);
            group.bench_function(label("shade again from the buffer"), |b| {
                b.iter(|| renderer.shade_buffer(&buffer, &domain, &shot, &workers, &mut picture, finish));
            });
            group.bench_function(label("frame"), |b| {
                b.iter(|| {
                    renderer.sort(&domain, &shot, &workers);
                    black_box(renderer.shade(&domain, &shot, &workers, &mut picture, finish))
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, stages);
criterion_main!(benches);
