//! What a texture's answer does to what lies under it: OpenGL's texture environment, and a mix by alpha.
//!
//! With *p* the colour and alpha under the layer, *s* those of the texture, *c* the environment's constant
//! (OpenGL 2.1, tables 3.22 and 3.23; results of ADD end at 1):
//!
//! | format          | REPLACE    | MODULATE     | DECAL               | BLEND                                  | ADD          |
//! |-----------------|------------|--------------|---------------------|----------------------------------------|--------------|
//! | ALPHA           | Cp, As     | Cp, Ap As    | (Cp, Ap)            | Cp, Ap As                              | Cp, Ap As    |
//! | LUMINANCE       | Cs, Ap     | Cp Cs, Ap    | (Cs, Ap)            | Cp (1-Cs) + Cc Cs, Ap                  | Cp + Cs, Ap  |
//! | LUMINANCE_ALPHA | Cs, As     | Cp Cs, Ap As | (Cp (1-As) + Cs As, Ap) | Cp (1-Cs) + Cc Cs, Ap As           | Cp + Cs, Ap As |
//! | INTENSITY       | Cs, As     | Cp Cs, Ap As | (Cp (1-As) + Cs As, Ap) | Cp (1-Cs) + Cc Cs, Ap (1-As) + Ac As | Cp + Cs, Ap + As |
//! | RGB             | Cs, Ap     | Cp Cs, Ap    | Cs, Ap              | Cp (1-Cs) + Cc Cs, Ap                  | Cp + Cs, Ap  |
//! | RGBA            | Cs, As     | Cp Cs, Ap As | Cp (1-As) + Cs As, Ap | Cp (1-Cs) + Cc Cs, Ap As             | Cp + Cs, Ap As |
//!
//! OpenGL leaves the four entries in brackets undefined; these are ours.

use crate::color::LinearRgba;
use crate::lookup::{BaseFormat, Reading};
use crate::math::{BATCH, Lane};

/// What a layer does with what it reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operator {
    /// The texture takes the place of what was there.
    Replace,
    /// The product.
    Modulate,
    /// Mixed by the texture's alpha; what was there keeps its alpha.
    Decal,
    /// The texture mixes what was there with this colour, channel by channel.
    Blend(LinearRgba),
    /// The sum, at most 1.
    Add,
    /// Laid over by the texture's alpha; alphas add up as coverages do (Porter, Duff 1984, "over").
    Over,
    /// Nothing is there where the texture's alpha fails the comparison with the reference.
    AlphaTest(Compare, f32),
}

/// A comparison of alpha with a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Compare {
    /// Fails always.
    Never,
    /// Passes if less.
    Less,
    /// Passes if equal.
    Equal,
    /// Passes if less or equal.
    LessOrEqual,
    /// Passes if greater.
    Greater,
    /// Passes unless equal.
    NotEqual,
    /// Passes if greater or equal.
    GreaterOrEqual,
    /// Passes always.
    Always,
}

impl Compare {
    /// Whether `alpha` passes.
    #[inline(always)]
    pub fn passes(self, alpha: f32, reference: f32) -> bool {
        match self {
            Self::Never => false,
            Self::Less => alpha < reference,
            Self::Equal => alpha == reference,
            Self::LessOrEqual => alpha <= reference,
            Self::Greater => alpha > reference,
            Self::NotEqual => alpha != reference,
            Self::GreaterOrEqual => alpha >= reference,
            Self::Always => true,
        }
    }
}

/// What becomes of colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorRule {
    Keep,
    Take,
    Times,
    MixByAlpha,
    Blend,
    Plus,
}

/// What becomes of alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AlphaRule {
    Keep,
    Take,
    Times,
    Blend,
    Plus,
    Cover,
}

/// The table above.
pub(super) fn rules(operator: Operator, format: BaseFormat) -> (ColorRule, AlphaRule) {
    use BaseFormat as F;
    let has_color = format != F::Alpha;
    let has_alpha = !matches!(format, F::Luminance | F::Rgb);
    let color = |rule| if has_color { rule } else { ColorRule::Keep };
    let alpha = |rule| if has_alpha { rule } else { AlphaRule::Keep };
    match operator {
        Operator::Replace => (color(ColorRule::Take), alpha(AlphaRule::Take)),
        Operator::Modulate => (color(ColorRule::Times), alpha(AlphaRule::Times)),
        Operator::Decal if has_alpha => (color(ColorRule::MixByAlpha), AlphaRule::Keep),
        Operator::Decal => (ColorRule::Take, AlphaRule::Keep),
        Operator::Blend(_) if format == F::Intensity => (ColorRule::Blend, AlphaRule::Blend),
        Operator::Blend(_) => (color(ColorRule::Blend), alpha(AlphaRule::Times)),
        Operator::Add if format == F::Intensity => (ColorRule::Plus, AlphaRule::Plus),
        Operator::Add => (color(ColorRule::Plus), alpha(AlphaRule::Times)),
        Operator::Over if has_alpha => (color(ColorRule::MixByAlpha), AlphaRule::Cover),
        Operator::Over => (ColorRule::Take, AlphaRule::Cover),
        Operator::AlphaTest(..) => (ColorRule::Keep, AlphaRule::Keep),
    }
}

/// How far a layer counts: everywhere by its strength, and nowhere outside of its texture.
#[derive(Clone, Copy)]
pub(super) struct Gate<'a> {
    pub(super) strength: f32,
    pub(super) applied: Option<&'a Lane>,
}

impl<'a> Gate<'a> {
    pub(super) fn new(strength: f32, reading: &'a Reading) -> Self {
        Self { strength, applied: (!reading.is_whole).then_some(&reading.applied) }
    }

    /// `lane[i] = f(i, lane[i])` as far as the layer counts.
    #[inline(always)]
    pub(super) fn each(self, n: usize, lane: &mut Lane, f: impl Fn(usize, f32) -> f32) {
        // Never more; said so that the loops need no bounds checks and become vectors.
        let n = n.min(BATCH);
        if self.strength == 1.0 && self.applied.is_none() {
            for i in 0..n {
                lane[i] = f(i, lane[i]);
            }
            return;
        }
        let strength = self.strength;
        for i in 0..n {
            let (under, over) = (lane[i], f(i, lane[i]));
            let mixed = if strength == 1.0 { over } else { under + (over - under) * strength };
            let is_applied = self.applied.is_none_or(|a| a[i] != 0.0);
            lane[i] = if is_applied { mixed } else { under };
        }
    }
}

/// Applies a rule to three channels. `limit` is 1 for reflected light, infinite for light given off.
#[inline(always)]
pub(super) fn combine_color(
    (rule, operator, limit): (ColorRule, Operator, f32),
    gate: Gate,
    n: usize,
    rgba: &[Lane; 4],
    color: &mut [Lane; 3],
) {
    let alpha = &rgba[3];
    for (c, lane) in color.iter_mut().enumerate() {
        let s = &rgba[c];
        match rule {
            ColorRule::Keep => {}
            ColorRule::Take => gate.each(n, lane, |i, _| s[i]),
            ColorRule::Times => gate.each(n, lane, |i, p| p * s[i]),
            ColorRule::MixByAlpha => gate.each(n, lane, |i, p| p * (1.0 - alpha[i]) + s[i] * alpha[i]),
            ColorRule::Blend => {
                let constant = constant(operator)[c];
                gate.each(n, lane, |i, p| p * (1.0 - s[i]) + constant * s[i]);
            }
            ColorRule::Plus => gate.each(n, lane, |i, p| at_most(p + s[i], limit)),
        }
    }
}

/// Applies a rule to alpha.
#[inline(always)]
pub(super) fn combine_alpha(
    (rule, operator): (AlphaRule, Operator),
    gate: Gate,
    n: usize,
    source: &Lane,
    alpha: &mut Lane,
) {
    match rule {
        AlphaRule::Keep => {}
        AlphaRule::Take => gate.each(n, alpha, |i, _| source[i]),
        AlphaRule::Times => gate.each(n, alpha, |i, p| p * source[i]),
        AlphaRule::Blend => {
            let constant = constant(operator)[3];
            gate.each(n, alpha, |i, p| p * (1.0 - source[i]) + constant * source[i]);
        }
        AlphaRule::Plus => gate.each(n, alpha, |i, p| at_most(p + source[i], 1.0)),
        AlphaRule::Cover => gate.each(n, alpha, |i, p| p + source[i] - p * source[i]),
    }
}

/// Applies an operator to a single number, such as roughness; `source` is the chosen channel.
#[inline(always)]
pub(super) fn combine_number(
    operator: Operator,
    gate: Gate,
    n: usize,
    (source, alpha): (&Lane, &Lane),
    number: &mut Lane,
) {
    match operator {
        Operator::Replace => gate.each(n, number, |i, _| source[i]),
        Operator::Modulate => gate.each(n, number, |i, p| p * source[i]),
        Operator::Decal | Operator::Over => {
            gate.each(n, number, |i, p| p * (1.0 - alpha[i]) + source[i] * alpha[i]);
        }
        Operator::Blend(constant) => gate.each(n, number, |i, p| p * (1.0 - source[i]) + constant[0] * source[i]),
        Operator::Add => gate.each(n, number, |i, p| p + source[i]),
        Operator::AlphaTest(..) => {}
    }
}

fn constant(operator: Operator) -> LinearRgba {
    if let Operator::Blend(constant) = operator { constant } else { [0.0; 4] }
}

#[inline(always)]
fn at_most(x: f32, limit: f32) -> f32 {
    if x < limit { x } else { limit }
}

#[cfg(test)]
mod tests {
    use super::*;

    const P: [f32; 4] = [0.5, 0.25, 0.75, 0.5];
    const C: [f32; 4] = [0.125, 1.0, 0.0, 0.75];

    /// What the texture of a format holds when its numbers are l and a.
    fn texel(format: BaseFormat) -> [f32; 4] {
        match format {
            BaseFormat::Alpha => [0.0, 0.0, 0.0, 0.625],
            BaseFormat::Luminance => [0.375, 0.375, 0.375, 1.0],
            BaseFormat::LuminanceAlpha => [0.375, 0.375, 0.375, 0.625],
            BaseFormat::Intensity => [0.375; 4],
            BaseFormat::Rgb => [0.875, 0.375, 0.125, 1.0],
            BaseFormat::Rgba => [0.875, 0.375, 0.125, 0.625],
        }
    }

    fn combined(operator: Operator, format: BaseFormat) -> [f32; 4] {
        let rgba = texel(format).map(|x| [x; BATCH]);
        let (mut color, mut alpha) = ([[P[0]; BATCH], [P[1]; BATCH], [P[2]; BATCH]], [P[3]; BATCH]);
        let (color_rule, alpha_rule) = rules(operator, format);
        let gate = Gate { strength: 1.0, applied: None };
        combine_color((color_rule, operator, 1.0), gate, 3, &rgba, &mut color);
        combine_alpha((alpha_rule, operator), gate, 3, &rgba[3], &mut alpha);
        [color[0][2], color[1][2], color[2][2], alpha[2]]
    }

    #[test]
    fn every_entry_of_opengls_table_holds() {
        use BaseFormat::*;
        use Operator::*;
        type Entry = fn(p: f32, s: f32, a: f32, c: f32) -> f32;
        let keep: Entry = |p, _, _, _| p;
        let take: Entry = |_, s, _, _| s;
        let times: Entry = |p, s, _, _| p * s;
        let blend: Entry = |p, s, _, c| p * (1.0 - s) + c * s;
        let plus: Entry = |p, s, _, _| if p + s < 1.0 { p + s } else { 1.0 };
        let decal: Entry = |p, s, a, _| p * (1.0 - a) + s * a;
        // Colour's entry and alpha's entry; for alpha, s is the texture's alpha.
        let table: [(BaseFormat, [(Entry, Entry); 5]); 6] = [
            (Alpha, [(keep, take), (keep, times), (keep, keep), (keep, times), (keep, times)]),
            (Luminance, [(take, keep), (times, keep), (take, keep), (blend, keep), (plus, keep)]),
            (LuminanceAlpha, [(take, take), (times, times), (decal, keep), (blend, times), (plus, times)]),
            (Intensity, [(take, take), (times, times), (decal, keep), (blend, blend), (plus, plus)]),
            (Rgb, [(take, keep), (times, keep), (take, keep), (blend, keep), (plus, keep)]),
            (Rgba, [(take, take), (times, times), (decal, keep), (blend, times), (plus, times)]),
        ];
        for (format, entries) in table {
            for (operator, (color, alpha)) in [Replace, Modulate, Decal, Blend(C), Add].into_iter().zip(entries) {
                let s = texel(format);
                let want = [0, 1, 2, 3].map(|c| if c < 3 { color } else { alpha }(P[c], s[c], s[3], C[c]));
                assert_eq!(combined(operator, format), want, "{operator:?} of {format:?}");
            }
        }
    }

    #[test]
    fn layers_count_by_strength_and_only_where_applied() {
        let mut lane = [0.25; BATCH];
        let mut applied = [1.0; BATCH];
        applied[1] = 0.0;
        Gate { strength: 0.5, applied: Some(&applied) }.each(3, &mut lane, |_, _| 0.75);
        assert_eq!(lane[..4], [0.5, 0.25, 0.5, 0.25]);
    }

    #[test]
    fn comparisons_are_opengls() {
        use Compare::*;
        let all = [Never, Less, Equal, LessOrEqual, Greater, NotEqual, GreaterOrEqual, Always];
        let passes = |alpha| all.map(|c| c.passes(alpha, 0.5) as u8);
        assert_eq!(passes(0.25), [0, 1, 0, 1, 0, 1, 0, 1]);
        assert_eq!(passes(0.5), [0, 0, 1, 1, 0, 0, 1, 1]);
        assert_eq!(passes(0.75), [0, 0, 0, 0, 1, 1, 1, 1]);
    }
}
