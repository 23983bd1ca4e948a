//! A section as a drawing: outlines of the model and of its particles as SVG, exact curves as such.
//!
//! One user unit is one model unit, and the viewBox begins where the section does, y turned so that +v is up. The text is
//! a function of its input: numbers have as many digits as tell a millionth of the drawing's size.

use crate::math::DVec2;
use crate::section::cut::{Rim, Section};
use crate::section::grain::Outline;
use crate::section::grain::curve::{Curve, Ellipse, Part, is_inside};
use std::fmt::Write;

/// How a section is drawn.
pub struct Drawing<'a> {
    /// Millimetres of a model unit: the size of the page.
    pub unit_mm: f64,
    /// Free space around the section, model units.
    pub margin: f64,
    /// Width of lines, model units.
    pub line: f64,
    /// What happens to particles that the model's outline crosses.
    pub crossing: Crossing,
    /// Colour of what is between particles, sRGB.
    pub matrix: [u8; 3],
    /// Colour of a particle, sRGB.
    pub color: &'a dyn Fn(&Outline) -> [u8; 3],
}

/// What happens to particles that the model's outline crosses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Crossing {
    /// They end there, by a clip path: for looking at.
    #[default]
    Clipped,
    /// They are left out: for cutting out.
    LeftOut,
}

impl Default for Drawing<'_> {
    fn default() -> Self {
        Self {
            unit_mm: 10.0,
            margin: 0.0,
            line: 0.0,
            crossing: Crossing::Clipped,
            matrix: [232, 222, 205],
            color: &|_| [178, 82, 60],
        }
    }
}

/// The drawing of a section and of the particles in it, whose plane coordinates are the section's.
pub fn svg(section: &Section, outlines: &[Outline], drawing: &Drawing) -> String {
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let contours = || section.contours.iter().chain(&section.open_contours);
    contours().flatten().for_each(|p| (min, max) = (min.min(*p), max.max(*p)));
    if min.x > max.x {
        (min, max) = (DVec2::ZERO, DVec2::ZERO);
    }
    let (min, max) = (min - drawing.margin.max(0.0), max + drawing.margin.max(0.0));
    let page = Page::of(min, max);
    let size = max - min;
    let mut text = String::new();
    let [width, height] = [size.x, size.y].map(|x| page.number(x));
    let [width_mm, height_mm] = [size.x, size.y].map(|x| page.number(x * drawing.unit_mm));
    let _ = writeln!(
        text,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width_mm}mm\" height=\"{height_mm}mm\" \
         viewBox=\"0 0 {width} {height}\">"
    );
    let unit = page.number(drawing.unit_mm);
    let _ = writeln!(text, "<desc>One user unit is one model unit, drawn as {unit} mm.</desc>");
    let outline: String = section.contours.iter().map(|c| page.polygon(c)).collect();
    let _ = writeln!(text, "<clipPath id=\"section\"><path clip-rule=\"evenodd\" d=\"{outline}\"/></clipPath>");
    let stroke = match drawing.line > 0.0 {
        true => format!(" stroke=\"#000\" stroke-width=\"{}\"", page.number(drawing.line)),
        false => String::new(),
    };
    let matrix = hex(drawing.matrix);
    let _ = writeln!(
        text,
        "<g class=\"section\"><path fill=\"{matrix}\" fill-rule=\"evenodd\"{stroke} d=\"{outline}\"/></g>"
    );
    if !section.open_contours.is_empty() {
        let lines: String = section.open_contours.iter().map(|c| page.line(c)).collect();
        let stroke = if stroke.is_empty() { " stroke=\"#000\" stroke-width=\"0.1%\"" } else { &stroke };
        let _ = writeln!(text, "<g class=\"open\"><path fill=\"none\"{stroke} d=\"{lines}\"/></g>");
    }
    let shown = shown(section, outlines, drawing.crossing);
    let mut classes: Vec<&str> = Vec::new();
    for outline in &shown {
        if !classes.contains(&outline.class.as_str()) {
            classes.push(&outline.class);
        }
    }
    for class in classes {
        let _ = writeln!(text, "<g class=\"particles {class}\" clip-path=\"url(#section)\"{stroke}>");
        for outline in shown.iter().filter(|o| o.class == class) {
            let side = if outline.is_below { "below" } else { "above" };
            let fill = hex((drawing.color)(outline));
            let id = outline.particle;
            let shape = page.shape(&outline.curve);
            let _ = writeln!(text, "<{shape} class=\"{side}\" data-particle=\"{id}\" fill=\"{fill}\"/>");
        }
        text.push_str("</g>\n");
    }
    text.push_str("</svg>\n");
    text
}

/// The particles that are in the section, or at least partly so.
fn shown<'a>(section: &Section, outlines: &'a [Outline], crossing: Crossing) -> Vec<&'a Outline> {
    let rim = Rim::of(section);
    let is_in = |p: DVec2| section.contours.iter().fold(false, |inside, c| inside != is_inside(c, p));
    let is_shown = |outline: &&Outline| {
        if rim.distance(outline.middle) > outline.reach {
            return is_in(outline.middle);
        }
        let polygon = outline.curve.polygon(outline.reach * 1e-3);
        let mut edges = (0..polygon.len()).map(|i| [polygon[i], polygon[(i + 1) % polygon.len()]]);
        let is_crossed = edges.any(|edge| crosses(section, edge));
        match crossing {
            // A small hole of the model may lie wholly in the particle.
            Crossing::LeftOut => {
                let holds_some = section.contours.iter().any(|c| c.first().is_some_and(|&p| is_inside(&polygon, p)));
                !is_crossed && !holds_some && polygon.first().is_some_and(|&p| is_in(p))
            }
            Crossing::Clipped => is_crossed || polygon.iter().any(|&p| is_in(p)),
        }
    };
    outlines.iter().filter(is_shown).collect()
}

/// Whether an edge meets an outline of the section.
fn crosses(section: &Section, [a, b]: [DVec2; 2]) -> bool {
    let (low, high) = (a.min(b), a.max(b));
    section.contours.iter().any(|contour| {
        (0..contour.len()).any(|i| {
            let (c, d) = (contour[i], contour[if i + 1 < contour.len() { i + 1 } else { 0 }]);
            if c.max(d).cmplt(low).any() || c.min(d).cmpgt(high).any() {
                return false;
            }
            let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p) > 0.0;
            side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)
        })
    })
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Where the drawing is in the plane, and how fine its numbers are.
struct Page {
    left: f64,
    top: f64,
    /// Digits after the point.
    n_digits: usize,
}

impl Page {
    fn of(min: DVec2, max: DVec2) -> Self {
        let size = (max - min).max_element();
        // A millionth of the size: counted by comparison, as a logarithm may differ.
        let (mut n_digits, mut step) = (0, 1.0);
        while n_digits < 15 && step > size * 1e-6 {
            (n_digits, step) = (n_digits + 1, step * 0.1);
        }
        Self { left: min.x, top: max.y, n_digits }
    }

    /// Rounded, without zeros at the end.
    fn number(&self, x: f64) -> String {
        let text = format!("{x:.*}", self.n_digits);
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        if text == "-0" { "0".into() } else { text.into() }
    }

    fn point(&self, p: DVec2) -> String {
        format!("{} {}", self.number(p.x - self.left), self.number(self.top - p.y))
    }

    fn line(&self, points: &[DVec2]) -> String {
        let mut text = String::new();
        for (i, &p) in points.iter().enumerate() {
            text.push(if i == 0 { 'M' } else { 'L' });
            text.push_str(&self.point(p));
        }
        text
    }

    fn polygon(&self, corners: &[DVec2]) -> String {
        if corners.is_empty() { String::new() } else { self.line(corners) + "Z" }
    }

    /// Radii of an ellipse, and its turn in degrees; clockwise is positive where y goes down.
    fn axes(&self, ellipse: &Ellipse) -> [String; 3] {
        let [a, b] = ellipse.semi;
        let turn = -crate::math::exact::atan2(a.y, a.x).to_degrees();
        [self.number(a.length()), self.number(b.length()), format!("{turn:.3}")]
    }

    /// An element without its closing.
    fn shape(&self, curve: &Curve) -> String {
        let middle = |p: DVec2| [self.number(p.x - self.left), self.number(self.top - p.y)];
        match curve {
            Curve::Circle { middle: at, radius } => {
                let [x, y] = middle(*at);
                format!("circle cx=\"{x}\" cy=\"{y}\" r=\"{}\"", self.number(*radius))
            }
            Curve::Ellipse(ellipse) => {
                let [x, y] = middle(ellipse.middle);
                let [a, b, turn] = self.axes(ellipse);
                format!("ellipse cx=\"{x}\" cy=\"{y}\" rx=\"{a}\" ry=\"{b}\" transform=\"rotate({turn} {x} {y})\"")
            }
            Curve::Path { start, parts } => {
                let mut d = format!("M{}", self.point(*start));
                let mut from = *start;
                for part in parts {
                    match part {
                        Part::Line(to) => {
                            let _ = write!(d, "L{}", self.point(*to));
                            from = *to;
                        }
                        Part::Arc { to, of } => {
                            let [a, b, turn] = self.axes(of);
                            let is_large = of.sweep(from, *to) > std::f64::consts::PI;
                            // Counter-clockwise with y up is the negative direction with y down.
                            let _ = write!(d, "A{a} {b} {turn} {} 0 {}", is_large as u8, self.point(*to));
                            from = *to;
                        }
                    }
                }
                format!("path d=\"{d}Z\"")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, Vec3, vec3};
    use crate::samples;
    use crate::section::Plane;
    use crate::section::cut::{Policy, cut};
    use crate::section::grain::{Axis, Ends, Filling, Grain, GrainSpec, Shape, outlines};

    fn section(normal: Vec3) -> (Section, Plane) {
        let plane = Plane::through(vec3(0.05, 0.02, 0.03), normal).unwrap();
        (cut(&samples::plain::icosphere(4), &plane, Policy::Winding).unwrap().section, plane)
    }

    fn drawn(spec: GrainSpec, normal: Vec3, drawing: &Drawing) -> (String, Vec<Outline>) {
        let (section, plane) = section(normal);
        let filling = Filling::Particles(Box::new(Grain::new(spec).unwrap()));
        let list = outlines(&filling, &plane, &section.window(0.0), &|_: DVec3| 1.0).unwrap();
        (svg(&section, &list, drawing), list)
    }

    #[test]
    fn drawings_have_model_units_classes_and_circles() {
        let drawing = Drawing { color: &|o| if o.is_below { [255, 0, 0] } else { [0, 0, 255] }, ..Drawing::default() };
        let (text, list) = drawn(GrainSpec::spheres(0.2, 0.1), vec3(1.0, 0.0, 1.0), &drawing);
        assert!(text.starts_with("<svg xmlns") && text.ends_with("</svg>\n"));
        // A unit ball, nearly through its middle, 10 mm a unit.
        let value = |key: &str| {
            let from = text.find(key).unwrap() + key.len();
            text[from..].split(['"', 'm', ' ']).next().unwrap().parse::<f64>().unwrap()
        };
        assert!((value("width=\"") - 20.0).abs() < 0.2 && (value("viewBox=\"0 0 ") - 2.0).abs() < 0.02);
        assert_eq!(text.matches("<g class=\"particles ball\"").count(), 1);
        let n = text.matches("<circle").count();
        assert!(n > 30 && n <= list.len() && text.matches("data-particle").count() == n);
        assert!(text.contains("class=\"below\"") && text.contains("#ff0000") && text.contains("#0000ff"));
        assert_eq!(drawn(GrainSpec::spheres(0.2, 0.1), vec3(1.0, 0.0, 1.0), &drawing).0, text);
    }

    #[test]
    fn particles_that_cross_the_outline_are_clipped_or_left_out() {
        let clipped = drawn(GrainSpec::spheres(0.2, 0.1), Vec3::Y, &Drawing::default()).0;
        let drawing = Drawing { crossing: Crossing::LeftOut, ..Drawing::default() };
        let (left_out, _) = drawn(GrainSpec::spheres(0.2, 0.1), Vec3::Y, &drawing);
        let [more, fewer] = [&clipped, &left_out].map(|text| text.matches("<circle").count());
        assert!(fewer > 20 && fewer + 5 < more, "{fewer} of {more}");
        // All of them lie within the ball's disc.
        let (section, _) = section(Vec3::Y);
        let far = section.contours[0].iter().map(|p| p.length()).fold(0.0, f64::max);
        for line in left_out.lines().filter(|l| l.starts_with("<circle")) {
            let value = |key: &str| line.split(key).nth(1).unwrap().split('"').next().unwrap().parse::<f64>().unwrap();
            let middle = DVec2::new(value("cx=\""), value("cy=\"")) - far;
            assert!(middle.length() + value(" r=\"") < far * 1.02, "{line}");
        }
    }

    #[test]
    fn arcs_turn_the_way_that_svg_has_them() {
        // A half disc above the x axis: from the right, counter-clockwise with y up, so over the top of the page.
        let of = Ellipse { middle: DVec2::ZERO, semi: [DVec2::X * 2.0, DVec2::Y] };
        let half = Curve::Path { start: DVec2::X * 2.0, parts: vec![Part::Arc { to: DVec2::X * -2.0, of }] };
        let page = Page::of(DVec2::splat(-2.0), DVec2::splat(2.0));
        assert_eq!(page.shape(&half), "path d=\"M4 2A2 1 -0.000 0 0 0 2Z\"");
        let rods = Shape::Cylinder { radius: 0.08, height: 0.16, ends: Ends::Flat };
        let spec = GrainSpec { axis: Axis::Along(Vec3::Z), ..GrainSpec::of(rods, 0.2) };
        let (text, _) = drawn(spec, vec3(1.0, 1.0, 1.0), &Drawing { line: 0.002, ..Drawing::default() });
        assert!(text.matches('A').count() > 30 && text.contains("stroke-width=\"0.002\""));
    }

    #[test]
    fn a_plane_that_misses_gives_an_empty_drawing() {
        let plane = Plane::through(vec3(0.0, 9.0, 0.0), Vec3::Y).unwrap();
        let section = cut(&samples::plain::icosphere(2), &plane, Policy::Winding).unwrap().section;
        let text = svg(&section, &[], &Drawing::default());
        assert!(text.contains("viewBox=\"0 0 0 0\"") && !text.contains("NaN"));
    }
}
