//! Shaders of grain: naga takes them, and what they give when they run is what Rust gives.

mod fillings;
mod machine;

use fillings::{FILLINGS, filling, random_grain};
use impasto::math::{DVec3, Vec3, hash_cell, unit_float, vec3};
use impasto::section::Plane;
use impasto::section::grain::{Chance, Filling, Grain, Hit, HitKind, Look, SectionKind, Side};
use impasto::section::shader::{Language, source};
use machine::Machine;
use naga::front::{glsl, wgsl};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

const KINDS: [SectionKind; 3] = [SectionKind::Tear, SectionKind::Hollow, SectionKind::Solid];
const LANGUAGES: [Language; 2] = [Language::Wgsl, Language::Glsl];

/// What naga makes of a source, validated.
#[track_caller]
fn parsed(text: &str, language: Language) -> (naga::Module, ModuleInfo) {
    let module = match language {
        Language::Wgsl => wgsl::parse_str(text).map_err(|e| e.emit_to_string(text)),
        Language::Glsl => {
            let text = format!("#version 450\n{text}\nvoid main() {{}}\n");
            let options = glsl::Options::from(naga::ShaderStage::Fragment);
            glsl::Frontend::default().parse(&options, &text).map_err(|e| e.emit_to_string(&text))
        }
    };
    let module = module.unwrap_or_else(|e| panic!("{e}\n{text}"));
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    let info = info.unwrap_or_else(|e| panic!("{}\n{text}", e.emit_to_string(text)));
    (module, info)
}

/// Even in [-1, 1).
fn random(i: i32, k: i32) -> f32 {
    unit_float(hash_cell(i, k, 0, 9)) * 2.0 - 1.0
}

/// What is asked of a shader.
#[derive(Clone, Copy, Debug)]
struct Question {
    p: Vec3,
    n: Vec3,
    offset: f32,
    side: Side,
}

impl Question {
    /// A plane in numbers of f32, and a point of it as near as f32 comes, up to about `far` from the origin.
    fn random(i: i32, far: f32) -> Self {
        let n = vec3(random(i / 20, 1), random(i / 20, 2), random(i / 20, 3)).normalize();
        let offset = random(i / 20, 4) * far * 0.5;
        let [u, v] = Plane { normal: n.as_dvec3(), offset: 0.0 }.axes();
        let p = (n * offset).as_dvec3() + (u * random(i, 5) as f64 + v * random(i, 6) as f64) * far as f64;
        Self { p: p.as_vec3(), n, offset, side: if i % 2 == 0 { Side::Below } else { Side::Above } }
    }

    fn plane(self) -> Plane {
        Plane { normal: self.n.as_dvec3(), offset: self.offset as f64 }
    }

    /// What Rust says; the skin is the plane y = 0.
    fn answered(self, filling: &Filling, kind: SectionKind) -> Hit {
        filling.eval(self.p.as_dvec3(), &self.plane(), Look { kind, side: self.side }, &|p: DVec3| p.y as f32)
    }

    /// What a shader says.
    fn run(self, machine: &mut Machine, is_layered: bool) -> Hit {
        let Self { p, n, offset, side } = self;
        let mut words: Vec<u32> = [p.x, p.y, p.z, n.x, n.y, n.z, offset].map(f32::to_bits).to_vec();
        words.push(if side == Side::Below { -1i32 as u32 } else { 1 });
        if is_layered {
            words.extend([p.y, 0.0, 1.0, 0.0].map(f32::to_bits));
        }
        let out = machine.call("impasto_grain", &words);
        let float = |k: usize| f32::from_bits(out[k]);
        let kinds = [HitKind::Matrix, HitKind::Bump, HitKind::Cavity, HitKind::Disc, HitKind::Bevel];
        let (kind, particle) = (kinds[out[4] as usize], out[5]);
        Hit {
            height: float(0),
            normal: vec3(float(1), float(2), float(3)),
            kind,
            particle,
            openness: float(6),
            leaf: 0,
            tone: 0.0,
        }
    }

    /// Whether something else is within 1e-4 spacings.
    fn is_near_outline(self, filling: &Filling, kind: SectionKind, spacing: f32) -> bool {
        let hit = self.answered(filling, kind);
        let [u, v] = self.plane().axes();
        [u, -u, v, -v].iter().any(|d| {
            let p = self.p.as_dvec3() + *d * (1e-4 * spacing as f64);
            let look = Look { kind, side: self.side };
            let near = filling.eval(p, &self.plane(), look, &|p: DVec3| p.y as f32);
            (near.kind, near.particle) != (hit.kind, hit.particle)
        })
    }
}

/// Which points of which cut are compared.
#[derive(Clone, Copy)]
struct Check {
    kind: SectionKind,
    language: Language,
    n_points: i32,
    /// Model units.
    spacing: f32,
    /// No farther from the origin than about this, spacings.
    far: f32,
}

impl Check {
    /// Compares a source with a filling; gives how many points are on particles.
    #[track_caller]
    fn run(self, filling: &Filling, text: &str) -> usize {
        let Self { kind, language, n_points, spacing, far } = self;
        let (module, info) = parsed(text, language);
        let mut machine = Machine::new(&module, &info);
        let is_layered = matches!(filling, Filling::Layers(_));
        let (mut on_particles, mut on_outlines) = (0, 0);
        for i in 0..n_points {
            let question = Question::random(i, far * spacing);
            let ours = question.answered(filling, kind);
            let theirs = question.run(&mut machine, is_layered);
            on_particles += (ours.particle != Hit::MATRIX) as usize;
            let told = || format!("{kind:?} {language:?} {question:?}\n{ours:?}\n{theirs:?}");
            if (ours.kind, ours.particle) != (theirs.kind, theirs.particle) {
                assert!(question.is_near_outline(filling, kind, spacing), "{}", told());
                on_outlines += 1;
                continue;
            }
            assert!((ours.height - theirs.height).abs() < 1e-4 * spacing, "{}", told());
            assert!((ours.normal - theirs.normal).length() < 1e-4, "{}", told());
            assert!((ours.openness - theirs.openness).abs() < 1e-4, "{}", told());
        }
        assert!(on_outlines <= n_points / 100, "{on_outlines} of {n_points} points on outlines");
        on_particles
    }
}

/// All kinds in both languages; a quarter of the points in the second, as its functions are the same.
#[track_caller]
fn check_all(name: &str, n: i32) {
    let filling = filling(name);
    for kind in KINDS {
        for (language, n_points) in [(Language::Wgsl, n), (Language::Glsl, n / 4)] {
            let text = source(&filling, kind, language).unwrap();
            let check = Check { kind, language, n_points, spacing: 0.6, far: 100.0 };
            let on_particles = check.run(&filling, &text);
            assert!(name == "plain" || on_particles * 20 > n_points as usize, "{on_particles} of {n_points}");
        }
    }
}

macro_rules! agreements {
    ($($name:ident: $n:literal,)*) => {
        /// Shader and Rust at random points of random planes, up to 100 spacings from the origin.
        mod agree {
            $(#[test]
            fn $name() {
                super::check_all(stringify!($name), $n);
            })*
        }

        #[test]
        fn all_fillings_are_compared() {
            assert_eq!([$(stringify!($name)),*], FILLINGS);
        }
    };
}

agreements! {
    balls: 320,
    upright: 240,
    grown: 60,
    overlapping: 240,
    noise: 20,
    letter: 40,
    rods: 160,
    domed_rods: 160,
    soft_rods: 160,
    ellipsoids: 80,
    capsules: 120,
    boxes: 80,
    soft_boxes: 80,
    dodecahedra: 120,
    superquadrics: 40,
    stars: 100,
    plain: 100,
    two_scales: 120,
    voronoi: 24,
    walls: 4,
    laguerre: 24,
    fibres: 120,
    sharp_fibres: 120,
    layers: 40,
}

#[test]
fn every_source_is_valid_and_says_no_reserved_word() {
    // Of GLSL ES 3.00 and 4.50, those that are not keywords of our own subset.
    let reserved = "active asm attribute buffer cast centroid class coherent common enum extern external filter fixed \
        flat goto half highp hvec2 inline input interface invariant layout long lowp mediump namespace noinline output \
        partition patch precise public resource restrict row_major sample shared short sizeof smooth static \
        subroutine superp template this typedef uniform union unsigned using varying volatile writeonly";
    let reserved: Vec<&str> = reserved.split_whitespace().collect();
    for name in FILLINGS {
        for kind in KINDS {
            for language in LANGUAGES {
                let text = source(&filling(name), kind, language).unwrap();
                let (module, _) = parsed(&text, language);
                assert!(module.functions.iter().any(|(_, f)| f.name.as_deref() == Some("impasto_grain")));
                let code = text.lines().map(|l| l.split("//").next().unwrap()).filter(|l| !l.starts_with("precision"));
                for word in code.flat_map(|l| l.split(|c: char| !(c.is_alphanumeric() || c == '_'))) {
                    assert!(!reserved.contains(&word), "{word} in {name}");
                }
                let mut prose = text.lines().filter(|l| l.trim_start().starts_with("//") || l.contains(" // "));
                assert!(prose.all(|l| l.len() <= 125), "{name}: a comment too long to read");
            }
        }
    }
}

#[test]
fn grains_of_any_numbers_agree() {
    let mut on_particles = 0;
    for i in 0..90 {
        let spec = random_grain(i);
        let (kind, language) = (KINDS[(i / 9) as usize % 3], LANGUAGES[(i / 27) as usize % 2]);
        let filling =
            Filling::Particles(Box::new(Grain::new(spec.clone()).unwrap_or_else(|e| panic!("{e}: {spec:?}"))));
        let text = source(&filling, kind, language).unwrap();
        let n_points = if spec.chance == Chance::Hash { 8 } else { 2 };
        on_particles += Check { kind, language, n_points, spacing: spec.spacing, far: 100.0 }.run(&filling, &text);
    }
    assert!(on_particles > 80, "{on_particles}");
}

#[test]
fn positions_are_kept_to_four_thousand_spacings() {
    let balls = filling("balls");
    let text = source(&balls, SectionKind::Tear, Language::Wgsl).unwrap();
    let (kind, language) = (SectionKind::Tear, Language::Wgsl);
    let on_particles = Check { kind, language, n_points: 200, spacing: 0.6, far: 2500.0 }.run(&balls, &text);
    assert!(on_particles > 30);
}

#[test]
fn parameters_may_be_turned_in_the_source() {
    let text = source(&filling("balls"), SectionKind::Solid, Language::Glsl).unwrap();
    let turns = [
        ("SPACING = 0.6;", "SPACING = 0.85;"),
        ("JITTER = 0.25;", "JITTER = 0.4;"),
        ("RADIUS = 0.3;", "RADIUS = 0.8;"),
        ("SIZE_LEAST = 0.65;", "SIZE_LEAST = 0.9;"),
        ("SIZE_MOST = 1.35;", "SIZE_MOST = 1.1;"),
        ("BEVEL_WIDTH = 0.07;", "BEVEL_WIDTH = 0.12;"),
        ("SEED = 0u;", "SEED = 12345u;"),
    ];
    let turned = turns.iter().fold(text, |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text.replace(from, to)
    });
    let filling = filling("turned balls");
    let (kind, language) = (SectionKind::Solid, Language::Glsl);
    assert!(Check { kind, language, n_points: 30, spacing: 0.85, far: 50.0 }.run(&filling, &turned) > 5);
}

#[test]
fn torn_sides_are_exact_negatives() {
    for name in ["balls", "overlapping", "rods", "fibres"] {
        let text = source(&filling(name), SectionKind::Tear, Language::Wgsl).unwrap();
        let (module, info) = parsed(&text, Language::Wgsl);
        let mut machine = Machine::new(&module, &info);
        for i in 0..60 {
            let question = Question::random(i, 50.0);
            let [a, b] = [Side::Below, Side::Above].map(|side| Question { side, ..question }.run(&mut machine, false));
            assert_eq!((a.height, a.normal, a.particle), (-b.height, -b.normal, b.particle), "{name} {question:?}");
        }
    }
}

#[test]
fn what_no_shader_is_written_for_gives_one_line() {
    let error = |name| source(&filling(name), SectionKind::Tear, Language::Wgsl).unwrap_err().to_string();
    assert_eq!(
        error("paper rods"),
        "shader \"cylinders of profile paper\" is not possible: no shader is written for it"
    );
    assert_eq!(error("endless layers"), "end of a layer \"NaN\" is not possible: a shader needs a finite number");
}

#[test]
fn only_what_is_needed_comes_out() {
    for language in LANGUAGES {
        let lines = |name, kind| source(&filling(name), kind, language).unwrap().lines().count();
        assert!(KINDS.iter().all(|kind| lines("balls", *kind) < 260), "balls");
        assert!(KINDS.iter().all(|kind| lines("plain", *kind) < 70), "plain");
        assert!(lines("boxes", SectionKind::Solid) < lines("soft_boxes", SectionKind::Solid));
    }
}
