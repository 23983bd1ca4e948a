//! A grain as shader source: one self-contained WGSL or GLSL function that shows what [`Filling::eval`] shows at plane cuts.
//!
//! For games and simulators that cut while they run. The parts are written once, in WGSL (`template.rs`), and become GLSL by
//! exchanging words (`dialect.rs`); only what the grain at hand needs comes out, with its numbers as constants at the top.
//!
//! What agrees with Rust: the chance of each cell bit for bit, so which particle is where, its side and its name; heights
//! within 1e-4 spacings, normals and openness within 1e-4, as far as a shader keeps to f32 (`tests/shader/` runs what comes
//! out in f32: 3e-5 at most within 100 spacings of the origin, openness 1e-4). On an outline the last bit decides, here as
//! there. A point is taken apart into whole cells, in integers, and a rest, so that up to 4096 spacings from the origin no
//! more is lost than its own f32 lack; a compiler that reorders sums loses a few bits of that, not the agreement of pixels
//! or halves: side and name are functions of the cell.

mod dialect;
mod fillings;
mod parameters;
mod shapes;
mod template;

use crate::Result;
use crate::section::grain::{Filling, SectionKind};
use template::Item;

/// What a shader is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Language {
    /// WebGPU's.
    Wgsl,
    /// OpenGL's and WebGL's: as ES 3.00 and as 4.50.
    Glsl,
}

/// Source of a function `impasto_grain(p, n, offset, side)` that gives height, normal, kind, particle and openness at a
/// point of a plane cut; layers take the depth below the skin as well. Lengths are those of the grain's description.
///
/// # Errors
/// A filling that no shader is written for, in one line.
pub fn source(filling: &Filling, kind: SectionKind, language: Language) -> Result<String> {
    let mut scopes = fillings::Scopes::default();
    let root = scopes.add(filling, kind)?;
    // The kinds always come, as whoever calls must know them all.
    let linked = template::linked(&scopes.all, root, &["MATRIX", "BUMP", "CAVITY", "DISC", "BEVEL", "Hit", "grain"]);
    let mut text = head(kind, language, scopes.is_sited());
    let (mut turned, others): (Vec<_>, Vec<_>) = linked.into_iter().partition(|(key, _)| scopes.is_parameter(*key));
    let (constants, items): (Vec<_>, Vec<_>) = others.into_iter().partition(|(_, item)| item.text.starts_with("const"));
    turned.sort_by_key(|(key, _)| *key);
    let mut push = |title: &str, items: &[(template::Key, Item)]| {
        text += title;
        let mut was_line = true;
        for (_, item) in items {
            let item = match language {
                Language::Wgsl => laid_out(&item.text),
                Language::Glsl => laid_out(&dialect::glsl(&item.text)),
            };
            // What takes one line stands close to what also does.
            let is_line = item.lines().count() == 1 || item.contains("const");
            if !(is_line && was_line) {
                text.push('\n');
            }
            was_line = is_line;
            text += &item;
        }
    };
    push("\n// What may be turned; where it says \"or\", not from one to the other:\n", &turned);
    push("\n// What follows from it:\n", &constants);
    push("", &items);
    Ok(text)
}

/// No line of code with its comment is longer.
const LONGEST: usize = 120;

/// Braces around one short statement in one line; comments that make a line too long above it.
fn laid_out(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let mut out = String::new();
    let mut i = 0;
    while i < lines.len() {
        let (line, n_lines) = match lines[i..] {
            [open, inner, close, ..] if is_short(open, inner, close) => {
                (format!("{open} {} }}", inner.trim_start()), 3)
            }
            _ => (lines[i].to_owned(), 1),
        };
        match line.split_once(" // ").filter(|_| line.len() > LONGEST) {
            Some((code, comment)) => {
                let indent = &code[..code.len() - code.trim_start().len()];
                out += &format!("{indent}// {comment}\n{code}\n");
            }
            None => out += &format!("{line}\n"),
        }
        i += n_lines;
    }
    out
}

/// Whether three lines are a brace, a statement and a brace that fit in one.
fn is_short(open: &str, inner: &str, close: &str) -> bool {
    let is_whole = open.ends_with('{') && inner.ends_with(';') && close.trim_start() == "}";
    let is_alone = !open.starts_with("struct") && !open.contains("} else");
    is_whole && is_alone && open.len() + inner.trim_start().len() + 3 <= LONGEST
}

/// What it is, what it wants and how to call it.
fn head(kind: SectionKind, language: Language, is_sited: bool) -> String {
    let kind = match kind {
        SectionKind::Tear => "torn: particles stay whole and go with one half",
        SectionKind::Hollow => "hollow: particles run out and leave cavities in both halves",
        SectionKind::Solid => "solid: particles are cut flat, what is between them is recessed",
    };
    let depth = if is_sited { ", depth, inward" } else { "" };
    let call = match language {
        Language::Wgsl => "let hit: ImpastoHit",
        Language::Glsl => "ImpastoHit hit",
    };
    let mut text = format!(
        "\
// The grain of a cut, {kind}.
// Made by Impasto after Li 2022; free to use for any purpose, without conditions. In a fragment or compute shader:
//   {call} = impasto_grain(p, n, offset, side{depth});
//   p       point of the cut, in the model's REST space: a moved or bent piece carries it as a vertex attribute
//   n       unit normal of the cut's plane, rest space, out of the half below
//   offset  of the plane: n . x = offset for all its points x; one number for a whole cut, so that no particle is split
//           between two pixels (of a curved cut: dot(n, p))
//   side    -1 for the half below, where n . x < offset; 1 for the half above
"
    );
    if is_sited {
        text.push_str(
            "\
//   depth   of p below the model's skin, model units
//   inward  how depth grows, per model unit: a unit vector away from the skin; zero if not known
",
        );
    }
    text.push_str(
        "\
// Shade with the normal it gives, displace by the height along the outward normal of that half, colour by the particle.
// Lengths are in model units where a comment says so, else in spacings. Good up to 4096 spacings from the origin.
",
    );
    if language == Language::Glsl {
        text.push_str(
            "\
// Put it below #version 300 es or #version 450.
#ifdef GL_ES
precision highp float;
precision highp int;
#endif
",
        );
    }
    text
}
