//! The gallery's page: one file, no network; pictures beside it.

use impasto::recipe::Recipe;
use std::fmt::Write;

/// A picture on the page.
pub(crate) struct Panel<'a> {
    /// Of its recipe, `topic/name.toml`.
    pub(crate) path: &'a str,
    /// As drawn.
    pub(crate) recipe: Recipe,
    /// The recipe's text.
    pub(crate) source: &'a str,
    /// File name of the picture.
    pub(crate) picture: String,
}

impl Panel<'_> {
    fn topic(&self) -> &str {
        self.path.split('/').next().unwrap_or("")
    }
}

/// Topics in the page's order: folder, heading, and a sentence about them.
const TOPICS: [(&str, &str, &str); 13] = [
    ("hero", "Impasto", ""),
    ("samples", "Surfaces by formula", "Everything here is drawn from these; no file is read."),
    (
        "coordinates",
        "Where the picture falls",
        "Each coordinate source on the same figure: layouts, projections, directions, data.",
    ),
    ("wrap", "Beyond the edge", "The four ways a texture goes on where it ends."),
    (
        "filters",
        "Near and far",
        "Two ways to enlarge, six classic ways to reduce, and more taps along a slanted footprint.",
    ),
    ("operators", "What a layer does", "OpenGL's table for each texel format, and a few of our own."),
    ("light", "In which light", "Lights, shading models and environments, on the same clay."),
    (
        "edges",
        "Edges and openings",
        "Antialiasing close up, surfaces that are there in places, surfaces that are seen through.",
    ),
    ("backgrounds", "Before what", "Backgrounds by name, and transparent pictures."),
    ("data", "Data on surfaces", "Colour codes, isolines, filters and cuts: numbers one can read off the picture."),
    ("section", "Cut open", "Both halves of a body filled with particles, after Li 2022: torn, hollow, solid."),
    ("grains", "What is inside", "Grains by name, in bodies made by formula. Each is a text file of a page."),
    ("information", "Textures as information", "The buffer behind a picture: every pixel knows its texel."),
];

/// The whole page.
pub(crate) fn page(panels: &[Panel]) -> String {
    let mut body = String::new();
    for (topic, heading, about) in TOPICS {
        let mut members: Vec<&Panel> = panels.iter().filter(|p| p.topic() == topic).collect();
        members.sort_by_key(|p| (p.recipe.gallery.order.unwrap_or(1000), p.path));
        if members.is_empty() {
            continue;
        }
        if topic == "hero" {
            hero(&mut body, &members);
        } else {
            section(&mut body, (topic, heading, about), &members);
        }
    }
    PAGE.replace("<!--nav-->", &nav(panels)).replace("<!--body-->", &body)
}

fn nav(panels: &[Panel]) -> String {
    let there = TOPICS.iter().skip(1).filter(|(t, ..)| panels.iter().any(|p| p.topic() == *t));
    there.map(|(topic, heading, _)| format!("<a href=\"#{topic}\">{heading}</a>")).collect()
}

fn hero(body: &mut String, members: &[&Panel]) {
    let (first, rest) = members.split_first().expect("a topic has members");
    let _ = write!(
        body,
        "<header class=\"hero\"><div><h1>Impasto</h1><p class=\"lead\">Textures as information. Paint a surface, grow its skin, \
         cut it open, read data off it: one library, one program, no GPU, and the same bytes on every machine.</p>{}</div>{}</header>",
        command(first),
        image(first)
    );
    if !rest.is_empty() {
        strip(body, rest);
    }
}

fn section(body: &mut String, (topic, heading, about): (&str, &str, &str), members: &[&Panel]) {
    let _ = write!(body, "<section id=\"{topic}\"><h2>{heading}</h2><p class=\"about\">{about}</p>");
    let mut i = 0;
    let mut cards = String::new();
    while i < members.len() {
        let name = members[i].recipe.gallery.strip.as_deref();
        let n = members[i..].iter().take_while(|p| p.recipe.gallery.strip.as_deref() == name).count();
        if name.is_some() && n > 1 {
            flush(body, &mut cards);
            strip(body, &members[i..i + n]);
            i += n;
        } else {
            card(&mut cards, members[i]);
            i += 1;
        }
    }
    flush(body, &mut cards);
    body.push_str("</section>");
}

fn flush(body: &mut String, cards: &mut String) {
    if !cards.is_empty() {
        let _ = write!(body, "<div class=\"cards\">{cards}</div>");
        cards.clear();
    }
}

/// Panels that share camera, light and scale, side by side, labels under them.
fn strip(body: &mut String, members: &[&Panel]) {
    let name = members[0].recipe.gallery.strip.as_deref().unwrap_or("");
    if !name.is_empty() {
        let _ = write!(body, "<h3>{}</h3>", escape(name));
    }
    body.push_str("<div class=\"strip\">");
    for panel in members {
        let label = panel.recipe.gallery.label.as_deref().or(panel.recipe.title.as_deref()).unwrap_or(panel.path);
        let about = panel.recipe.about.as_deref().unwrap_or("");
        let _ = write!(
            body,
            "<figure>{}<figcaption><b>{}</b> <span>{}</span>{}</figcaption></figure>",
            image(panel),
            escape(label),
            escape(about),
            command(panel)
        );
    }
    body.push_str("</div>");
}

fn card(body: &mut String, panel: &Panel) {
    let _ = write!(
        body,
        "<figure>{}<figcaption><b>{}</b> <span>{}</span>{}</figcaption></figure>",
        image(panel),
        escape(panel.recipe.title.as_deref().unwrap_or(panel.path)),
        escape(panel.recipe.about.as_deref().unwrap_or("")),
        command(panel)
    );
}

fn image(panel: &Panel) -> String {
    let title = escape(panel.recipe.title.as_deref().unwrap_or(panel.path));
    let [w, h] = panel.recipe.picture.size.unwrap_or([960, 720]);
    let class = if panel.recipe.gallery.pixels == Some(true) { "shot pixels" } else { "shot" };
    format!(
        "<a class=\"{class}\" href=\"{p}\"><img src=\"{p}\" alt=\"{title}\" width=\"{w}\" height=\"{h}\" loading=\"lazy\"></a>",
        p = escape(&panel.picture)
    )
}

/// The command that makes the picture, to be copied by a click, and the recipe behind it.
fn command(panel: &Panel) -> String {
    let name = panel.path.rsplit('/').next().unwrap_or(panel.path).trim_end_matches(".toml");
    format!(
        "<button class=\"copy\" data-text=\"impasto run gallery/{path} -o {name}.png\" title=\"copy\">impasto run gallery/{path}</button>\
         <details><summary>recipe</summary><pre>{source}</pre></details>",
        path = escape(panel.path),
        source = escape(panel.source.trim())
    )
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

const PAGE: &str = include_str!("gallery_page.html");
