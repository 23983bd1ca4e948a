//! `impasto check`: how well a data picture can be read.

use crate::report;
use anyhow::{Context, Result};
use impasto::assets::png_text;
use impasto::par::Workers;
use impasto::recipe::check::{Reading, check};
use impasto::recipe::{self, text};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Read a data picture by its colours alone, and tell how far that is from the true values.
///
/// The picture's own recipe, which is written into it, says what it shows; its files must be where they were. Each pixel is
/// read as the nearest colour of the legend (in CIE Lab).
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto check stress.png
  impasto check stress.png --json --at-most 2         exit code 1 when more than 5 of 100 pixels are off by over 2 %")]
pub(crate) struct Args {
    /// A PNG picture made by impasto with --color-by.
    #[arg(value_name = "PICTURE")]
    picture: PathBuf,
    /// Where the names in the picture's recipe count from; absent: here.
    #[arg(long, value_name = "DIR", default_value = ".")]
    base: PathBuf,
    /// Fail when the 95th percentile of misreadings is above this share of the range, in %.
    #[arg(long, value_name = "PERCENT")]
    at_most: Option<f64>,
    /// As JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args, workers: &Workers) -> Result<()> {
    let path = &args.picture;
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {path:?}"))?;
    let png = png_text::read(&bytes, path)?;
    let written = png.text("Recipe").with_context(|| format!("{path:?} tells no recipe; was it made by impasto?"))?;
    let recipe = text::parse(written, Path::new("recipe in the picture"))?;
    let prepared = recipe::prepare(&recipe, &args.base, workers)?.value;
    let reading = check(&png.pixels, png.size, &prepared, workers).with_context(|| format!("{path:?}"))?;
    if args.json {
        report::out(&to_json(&reading).to_string())?;
    } else {
        report::out(&to_text(&reading))?;
    }
    match args.at_most {
        Some(limit) if reading.p95.is_nan() || reading.p95 * 100.0 > limit => {
            anyhow::bail!(
                "misread by {:.2} % of the range at the 95th percentile, more than {limit} %",
                reading.p95 * 100.0
            )
        }
        _ => Ok(()),
    }
}

fn to_text(r: &Reading) -> String {
    let unit = if r.unit.is_empty() { String::new() } else { format!(" {}", r.unit) };
    let percent = |x: f64| format!("{:.2} %", x * 100.0);
    let lost = r.n_unreadable as f64 / r.n_values.max(1) as f64;
    format!(
        "values        {}, {} to {}{unit}\n\
         pixels        {} with a value; {} under lines, edges and highlights\n\
         misread by    {} of the range in the middle, {} at the 95th percentile, {} at worst",
        r.title,
        r.range[0],
        r.range[1],
        crate::render::info_count(r.n_values),
        percent(lost),
        percent(r.median),
        percent(r.p95),
        percent(r.worst),
    )
}

fn to_json(r: &Reading) -> serde_json::Value {
    json!({
        "field": r.title, "unit": r.unit, "range": r.range, "values": r.n_values, "unreadable": r.n_unreadable,
        "median": r.median, "p95": r.p95, "worst": r.worst,
    })
}
