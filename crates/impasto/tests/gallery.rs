//! Every recipe of the gallery gives the bytes of its picture.
//!
//! `UPDATE_GALLERY=1` rewrites the pictures that differ, and the run still fails, so that somebody looks at them.
//! A failure leaves `wanted | difference | got` in the folder `gallery` of cargo's own folder for test output.

use impasto::assets::{Image, Texels, image_files};
use impasto::math::Size;
use impasto::par::Workers;
use impasto::recipe::{self, Prepared, Recipe, output, text};
use std::path::{Path, PathBuf};

type Pixels = Image<[u8; 4]>;

fn gallery() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gallery")
}

/// All recipes, in order.
fn recipes() -> Vec<PathBuf> {
    let entries = |folder: &Path| -> Vec<PathBuf> {
        let mut found: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
        found.sort();
        found
    };
    let topics = entries(&gallery()).into_iter().filter(|p| p.is_dir());
    topics.flat_map(|t| entries(&t)).filter(|p| p.extension().is_some_and(|e| e == "toml")).collect()
}

/// A recipe ready to be drawn, by any workers.
struct Ready {
    path: PathBuf,
    recipe: Recipe,
    prepared: Prepared,
}

impl Ready {
    fn new(path: &Path) -> Self {
        let mut recipe: Recipe = text::parse(&std::fs::read_to_string(path).unwrap(), path).unwrap();
        match recipe.gallery.show.as_deref() {
            Some("info-texture") => recipe.output.info_texture = Some("a.png".into()),
            _ => recipe.output.picture = Some("a.png".into()),
        }
        let prepared = recipe::prepare(&recipe, path.parent().unwrap(), &Workers::new(1));
        let prepared = prepared.unwrap_or_else(|e| panic!("{path:?}: {e}")).value;
        Self { path: path.into(), recipe, prepared }
    }

    /// The picture as `impasto run` would write it, decoded again.
    fn draw(&self, workers: &Workers) -> Pixels {
        let base = self.path.parent().unwrap();
        let (made, _) = output::make(&self.recipe, &self.prepared, (base, &[]), workers, &|_| ()).unwrap();
        decode(&made[0].bytes, &self.path)
    }
}

fn decode(png: &[u8], path: &Path) -> Pixels {
    match image_files::read(png, path).unwrap().value.texels {
        Texels::U8(image) => image,
        other => panic!("{path:?} has 8 bits, not {:?}", other.size()),
    }
}

/// As small as a PNG gets: these lie in the repository.
fn encode(image: &Pixels) -> Vec<u8> {
    let is_opaque = image.texels.iter().all(|p| p[3] == 255);
    let bytes: Vec<u8> = match is_opaque {
        true => image.texels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect(),
        false => image.texels.as_flattened().to_vec(),
    };
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, image.size.width, image.size.height);
    encoder.set_color(if is_opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&bytes).unwrap();
    writer.finish().unwrap();
    out
}

/// `wanted | difference | got`, the difference eight times as strong.
fn report(wanted: &Pixels, got: &Pixels) -> Pixels {
    let at = |i: &Pixels, x: u32, y: u32| if x < i.size.width && y < i.size.height { *i.at(x, y) } else { [0; 4] };
    let (w, h) = (wanted.size.width.max(got.size.width), wanted.size.height.max(got.size.height));
    Image::from_fn(Size::new(3 * w, h), |x, y| {
        let (a, b) = (at(wanted, x % w, y), at(got, x % w, y));
        match x / w {
            0 => a,
            1 => {
                let [r, g, b, alpha] = [0, 1, 2, 3].map(|c| a[c].abs_diff(b[c]).saturating_mul(8));
                [r.max(alpha), g.max(alpha), b.max(alpha), 255]
            }
            _ => b,
        }
    })
}

#[test]
fn every_recipe_gives_its_picture_to_the_byte() {
    let update = std::env::var_os("UPDATE_GALLERY").is_some();
    let only = std::env::var("GALLERY").unwrap_or_default();
    let failures = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gallery");
    let mut failed = Vec::new();
    let recipes: Vec<PathBuf> = recipes().into_iter().filter(|p| p.to_string_lossy().contains(&only)).collect();
    assert!(!recipes.is_empty(), "the gallery has recipes");
    let pictures = Workers::new(0).map(recipes.len(), |i| Ready::new(&recipes[i]).draw(&Workers::new(1)));
    for (path, got) in recipes.iter().zip(pictures) {
        let picture = path.with_extension("png");
        let wanted = std::fs::read(&picture).ok().map(|bytes| decode(&bytes, &picture));
        if wanted.as_ref() == Some(&got) {
            continue;
        }
        let name = path.strip_prefix(gallery()).unwrap().with_extension("").display().to_string();
        if let Some(wanted) = &wanted {
            std::fs::create_dir_all(&failures).unwrap();
            std::fs::write(failures.join(format!("{}.png", name.replace('/', "-"))), encode(&report(wanted, &got)))
                .unwrap();
        }
        if update {
            std::fs::write(&picture, encode(&got)).unwrap();
        }
        failed.push(name);
    }
    let hint = if update { "rewritten; look at them" } else { "UPDATE_GALLERY=1 rewrites them" };
    assert!(failed.is_empty(), "{} of {} pictures differ ({hint}): {}", failed.len(), recipes.len(), failed.join(", "));
}

#[test]
fn every_recipe_has_its_picture_and_a_title() {
    for path in recipes() {
        let recipe = text::parse(&std::fs::read_to_string(&path).unwrap(), &path).unwrap();
        let title = recipe.title.unwrap_or_default();
        assert!((1..=60).contains(&title.chars().count()), "{path:?} has a title of at most 60 characters");
        assert!(path.with_extension("png").is_file(), "{path:?} has its picture");
    }
}

/// One thread or five, any SIMD level: the same bytes.
#[test]
fn threads_and_simd_levels_do_not_change_a_byte() {
    let names = [
        "hero/front.toml",
        "operators/stack.toml",
        "filters/anisotropic-16.toml",
        "coordinates/two-part-sphere-centroid.toml",
        "edges/blend.toml",
        "edges/mask.toml",
        "light/model-metal.toml",
        "light/spot.toml",
    ];
    for name in names {
        let ready = Ready::new(&gallery().join(name));
        let wanted = ready.draw(&Workers::new(1));
        for n_threads in [2, 5] {
            assert_eq!(ready.draw(&Workers::new(n_threads)), wanted, "{name} by {n_threads} threads");
        }
        for level in impasto::par::LEVEL_NAMES {
            if let Some(level) = impasto::par::level_by_name(level) {
                assert_eq!(ready.draw(&Workers::with_level(1, level)), wanted, "{name} by {level:?}");
            }
        }
    }
}
