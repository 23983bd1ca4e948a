//! Which parts a filling needs, and its numbers for them.

use super::parameters::Constants;
use super::shapes::{numbers, shape, unrolled};
use super::template::{Item, Key, Scope, items, wanted};
use crate::math::DMat3;
use crate::section::grain::{
    Cells, Chance, Contact, Fibres, Filling, Grain, LatticeAxes, Layer, Mixing, Profile, SectionKind, Shape, Size,
    lattice_rotation,
};
use crate::{Error, Result};

/// The scopes of one shader.
pub(super) struct Scopes {
    pub(super) all: Vec<Scope>,
    /// How many items of each scope are parameters: its first.
    n_parameters: Vec<usize>,
    is_sited: bool,
}

impl Default for Scopes {
    fn default() -> Self {
        let mut scopes = Self { all: Vec::new(), n_parameters: Vec::new(), is_sited: false };
        let parts =
            [include_str!("parts/numbers.wgsl"), include_str!("parts/hit.wgsl"), include_str!("parts/site.wgsl")];
        scopes.put("", Contents { parts: &parts, ..Contents::default() });
        scopes
    }
}

/// The scope and name of a function that says whether a particle counts.
type Keep = Option<(usize, &'static str)>;

/// How a filling is written.
#[derive(Clone, Copy)]
struct Manner<'a> {
    kind: SectionKind,
    /// Names begin with it: words with an underscore after each.
    prefix: &'a str,
    keep: Keep,
}

/// What makes a scope.
#[derive(Default)]
struct Contents<'a> {
    constants: Constants,
    parts: &'a [&'a str],
    flags: &'a [&'a str],
    links: Vec<(String, usize, String)>,
}

impl Scopes {
    /// Takes in a filling; gives the scope whose `grain` is the function to call.
    pub(super) fn add(&mut self, filling: &Filling, kind: SectionKind) -> Result<usize> {
        let Filling::Layers(_) = filling else {
            return self.fill(filling, Manner { kind, prefix: "", keep: None });
        };
        self.is_sited = true;
        let layers = self.fill(filling, Manner { kind, prefix: "layer_", keep: None })?;
        let links = vec![("layers".to_owned(), layers, "grain".to_owned())];
        let parts = &[include_str!("parts/layered.wgsl")];
        Ok(self.put("", Contents { parts, links, ..Contents::default() }))
    }

    /// Whether the function wants a depth.
    pub(super) fn is_sited(&self) -> bool {
        self.is_sited
    }

    pub(super) fn is_parameter(&self, (scope, item): Key) -> bool {
        item < self.n_parameters[scope]
    }

    fn put(&mut self, prefix: &str, contents: Contents) -> usize {
        let Contents { constants, parts, flags, links } = contents;
        let n_parameters = constants.0.len();
        let mut all = constants.0;
        all.extend(parts.iter().flat_map(|part| items(&wanted(part, flags))));
        self.all.push(Scope { prefix: prefix.into(), items: all, links });
        self.n_parameters.push(n_parameters);
        self.all.len() - 1
    }

    fn fill(&mut self, filling: &Filling, manner: Manner) -> Result<usize> {
        match filling {
            Filling::Plain => {
                let (parts, flags) = (&[include_str!("parts/plain.wgsl")], &self.flags(manner));
                Ok(self.put(manner.prefix, Contents { parts, flags, ..Contents::default() }))
            }
            Filling::Particles(grain) => self.particles(grain, manner),
            Filling::Scales(scales) => match (scales.sizes(), scales.mixing()) {
                ([Size::Grain(coarse), Size::Grain(fine)], Mixing::Apart(gap)) => {
                    self.two_scales([coarse, fine], gap, manner)
                }
                (_, Mixing::Joined) => Err(not_covered("bubbles that join")),
                _ => Err(not_covered("more than two sizes, or cells of several")),
            },
            Filling::Layers(layers) => self.layers(layers, manner),
            Filling::Cells(cells) if cells.spec().nucleus.is_some() => Err(not_covered("cells with nuclei")),
            Filling::Cells(cells) if cells.spec().share < 1.0 => Err(not_covered("cells with gaps")),
            Filling::Cells(cells) if cells.spec().rounding > 0.0 => Err(not_covered("rounded cells")),
            Filling::Cells(cells) => Ok(self.cells(cells, manner)),
            Filling::Fibres(fibres) => Ok(self.fibres(fibres, manner)),
            // It changes colours only, of which a shader gives none.
            Filling::Mottled(mottled) => self.fill(mottled.filling(), manner),
            Filling::Wavy(_) => Err(not_covered("waves of the skin")),
            Filling::Rings(_) => Err(not_covered("rings of wood")),
            Filling::Trabeculae(_) => Err(not_covered("trabeculae")),
            Filling::Bands(_) => Err(not_covered("bands")),
            Filling::Druse(_) => Err(not_covered("a druse")),
            Filling::Chambers(_) => Err(not_covered("chambers")),
        }
    }

    /// What all parts may ask for.
    fn flags(&self, manner: Manner) -> Vec<&'static str> {
        let mut flags = vec![match manner.kind {
            SectionKind::Tear => "tear",
            SectionKind::Hollow => "hollow",
            SectionKind::Solid => "solid",
        }];
        flags.extend(manner.keep.map(|_| "keep"));
        flags.extend(self.is_sited.then_some("sited"));
        flags
    }

    fn particles(&mut self, grain: &Grain, manner: Manner) -> Result<usize> {
        let spec = grain.spec();
        let kind = manner.kind;
        let mut flags = self.flags(manner);
        let is_letter = spec.profile == Profile::Paper;
        if is_letter && !matches!(spec.shape, Shape::Sphere { .. }) {
            return Err(not_covered("cylinders of profile paper"));
        }
        flags.extend((kind == SectionKind::Tear && !is_letter).then_some("sided"));
        flags.extend(matches!(spec.contact, Contact::Apart { .. }).then_some("apart"));
        flags.extend((spec.lattice == LatticeAxes::Turned).then_some("turned"));
        flags.extend(spec.bevel_within_particle.then_some("bevel_within"));
        flags.extend(matches!(spec.contact, Contact::Apart { grow } if grow > 1.0).then_some("grows"));
        let mut parts = vec![
            include_str!("parts/particles.wgsl"),
            include_str!("parts/lattice.wgsl"),
            include_str!("parts/contact.wgsl"),
            include_str!("parts/axis.wgsl"),
            include_str!("parts/clearance.wgsl"),
            match spec.chance {
                Chance::Hash => include_str!("parts/chance_hash.wgsl"),
                Chance::Noise { .. } => include_str!("parts/chance_noise.wgsl"),
            },
            match (is_letter, kind) {
                (true, _) => include_str!("parts/letter.wgsl"),
                (_, SectionKind::Solid) => include_str!("parts/solid.wgsl"),
                _ => include_str!("parts/whole.wgsl"),
            },
        ];
        let mut constants = Constants::default();
        constants.float("SPACING", spec.spacing, "between neighbouring nodes of the lattice, model units");
        shape(&spec.shape, &mut constants, &mut parts, &mut flags);
        numbers(spec, &mut constants, &mut flags);
        let links = links_to(manner.keep, "keep");
        let scope = self.put(manner.prefix, Contents { constants, parts: &parts, flags: &flags, links });
        self.turn(scope, lattice_rotation(spec.lattice));
        if let Shape::Polyhedron(polyhedron) = &spec.shape {
            let reach = polyhedron.corners.iter().map(|c| c.length()).fold(0.0, f32::max);
            let mut further = Constants::default();
            further.float("CORNER_REACH", reach, "from the polyhedron's centre to its farthest corner, model units");
            self.all[scope].items.extend(further.0.into_iter().chain(unrolled(polyhedron)));
        }
        Ok(scope)
    }

    /// A rotation is nothing to be turned by hand: it stands below the parameters.
    fn turn(&mut self, scope: usize, model_from_lattice: DMat3) {
        let mut further = Constants::default();
        further.turn(model_from_lattice);
        self.all[scope].items.extend(further.0);
    }

    fn cells(&mut self, cells: &Cells, manner: Manner) -> usize {
        let spec = cells.spec();
        let mut flags = self.flags(manner);
        flags.push("stretched");
        flags.extend((spec.lattice == LatticeAxes::Turned).then_some("turned"));
        flags.push(match (spec.wall > 0.0, manner.kind) {
            (true, _) => "walls",
            (_, SectionKind::Tear) => "onward",
            _ => "cells",
        });
        let mut constants = Constants::default();
        constants.float(
            "SPACING",
            spec.spacing,
            "mean distance of neighbouring cells' seeds, model units, before stretching",
        );
        constants.vector("STRETCH", spec.stretch, "how much longer cells are along the model's axes");
        constants.float("WALL", spec.wall, "width of the walls between cells, model units: 0, or above it");
        constants.float("WEIGHT_SPREAD", spec.weight_spread, "how much cells differ in size: 0 to 0.5");
        constants.float(
            "JITTER",
            spec.jitter,
            "how far seeds move off the lattice's nodes along each axis, spacings: 0 to 0.5",
        );
        constants.float("BEVEL_WIDTH", spec.bevel, "depth and width of a solid cut's bevel, spacings");
        constants.unsigned("SEED", spec.seed, "another seed, other cells");
        let parts = [
            include_str!("parts/cells.wgsl"),
            include_str!("parts/lattice.wgsl"),
            include_str!("parts/chance_hash.wgsl"),
            include_str!("parts/faces.wgsl"),
        ];
        let links = links_to(manner.keep, "keep");
        let scope = self.put(manner.prefix, Contents { constants, parts: &parts, flags: &flags, links });
        self.turn(scope, lattice_rotation(spec.lattice));
        scope
    }

    fn fibres(&mut self, fibres: &Fibres, manner: Manner) -> usize {
        let spec = fibres.spec();
        let mut flags = self.flags(manner);
        flags.push("turned");
        flags.extend((spec.rounding > 0.0).then_some("rounded"));
        let mut constants = Constants::default();
        constants.float("SPACING", spec.spacing, "between neighbouring fibres' middles, model units");
        constants.float("RADIUS", spec.radius, "of the fibres before it is perturbed, model units");
        constants.float("LENGTH", spec.length, "mean length of a fibre's pieces, model units");
        constants.float("BREAK_GAP", spec.gap, "between the ends of two pieces, model units");
        constants.float(
            "ROUNDING",
            spec.rounding,
            "radius of the rounded rims, as a part of the radius: 0, or above it",
        );
        constants.float("SIZE_SPREAD", spec.size_spread, "how much radii differ: 0 to 0.95");
        constants.float("JITTER", spec.jitter, "how far fibres move off the lattice, spacings: 0 to 0.4");
        constants.float("BEVEL_WIDTH", spec.bevel, "depth and width of a solid cut's bevel, spacings");
        constants.unsigned("SEED", spec.seed, "another seed, other fibres");
        let parts = [
            include_str!("parts/fibres.wgsl"),
            include_str!("parts/lattice.wgsl"),
            include_str!("parts/rod.wgsl"),
            include_str!("parts/contact.wgsl"),
            include_str!("parts/implicit.wgsl"),
            include_str!("parts/openness.wgsl"),
        ];
        let links = links_to(manner.keep, "keep");
        let scope = self.put(manner.prefix, Contents { constants, parts: &parts, flags: &flags, links });
        self.turn(scope, fibres.model_from_fibres());
        scope
    }

    fn two_scales(&mut self, [coarse, fine]: [&Grain; 2], gap: f32, manner: Manner) -> Result<usize> {
        let parts: &[&str] = &[include_str!("parts/two_scales.wgsl")];
        let (coarse_prefix, fine_prefix) = (format!("{}coarse_", manner.prefix), format!("{}fine_", manner.prefix));
        let coarse = self.particles(coarse, Manner { prefix: &coarse_prefix, ..manner })?;
        let mut constants = Constants::default();
        let gap = finite("gap between two scales", gap)?;
        constants.float("GAP", gap, "fine particles nearer than this to a coarse one are left out, model units");
        let flags: &[&str] = &self.flags(manner);
        let mut links = links_to(manner.keep, "outer_keep");
        links.push(("coarse_clearance".to_owned(), coarse, "clearance".to_owned()));
        let between = self.put(&fine_prefix, Contents { constants, parts, flags, links });
        let keep = Some((between, "clear"));
        let fine = self.particles(fine, Manner { prefix: &fine_prefix, keep, ..manner })?;
        let link = |word: &str, scope| (word.to_owned(), scope, "grain".to_owned());
        let links = vec![link("coarse_grain", coarse), link("fine_grain", fine)];
        Ok(self.put(manner.prefix, Contents { parts, flags, links, ..Contents::default() }))
    }

    fn layers(&mut self, layers: &[Layer], manner: Manner) -> Result<usize> {
        if layers.is_empty() {
            return self.fill(&Filling::Plain, manner);
        }
        let mut links = Vec::new();
        let mut choice = String::from(
            "// Layer by layer from the skin.\n\
             fn grain(p: vec3<f32>, n: vec3<f32>, offset: f32, side: i32, site: Site) -> Hit {\n",
        );
        for (k, layer) in layers.iter().enumerate() {
            let prefix = &format!("{}{}_", manner.prefix, k + 1);
            let (is_first, is_last) = (k == 0, k + 1 == layers.len());
            let mut constants = Constants::default();
            if !is_first {
                let from = finite("end of a layer", layers[k - 1].until)?;
                constants.float("FROM", from, "where this layer begins: where the one before ends");
            }
            if !is_last {
                let until = finite("end of a layer", layer.until)?;
                constants.float("UNTIL", until, "where this layer ends, depth below the skin in model units");
            }
            let mut flags = self.flags(manner);
            let more = [(is_first, "first"), (is_last, "last"), (layer.strict, "strict")];
            flags.extend(more.iter().filter(|(holds, _)| *holds).map(|(_, word)| *word));
            let (parts, outer) = (&[include_str!("parts/within.wgsl")], links_to(manner.keep, "outer_keep"));
            let border = self.put(prefix, Contents { constants, parts, flags: &flags, links: outer });
            let keep = Some((border, "within"));
            let inner = self.fill(&layer.filling, Manner { prefix, keep, ..manner })?;
            links.push((format!("grain_{k}"), inner, "grain".to_owned()));
            links.push((format!("until_{k}"), border, "UNTIL".to_owned()));
            choice += &match is_last {
                true => format!("    return grain_{k}(p, n, offset, side, site);\n}}\n"),
                false => format!(
                    "    if (site.depth < until_{k}) {{\n        return grain_{k}(p, n, offset, side, site);\n    }}\n"
                ),
            };
        }
        let scope = self.put(manner.prefix, Contents { links, ..Contents::default() });
        self.all[scope].items.push(Item { name: "grain".into(), text: choice });
        Ok(scope)
    }
}

/// A word that means the function which keeps particles, if there is one.
fn links_to(keep: Keep, word: &str) -> Vec<(String, usize, String)> {
    keep.iter().map(|(scope, name)| (word.to_owned(), *scope, (*name).to_owned())).collect()
}

/// Numbers of mixtures are not checked before.
fn finite(what: &str, x: f32) -> Result<f32> {
    let fault =
        || Error::Parameter { what: what.into(), given: x.to_string(), why: "a shader needs a finite number".into() };
    if x.is_finite() { Ok(x) } else { Err(fault()) }
}

fn not_covered(what: &str) -> Error {
    Error::Parameter { what: "shader".into(), given: what.into(), why: "no shader is written for it".into() }
}
