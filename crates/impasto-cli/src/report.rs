//! How the program talks: results on standard output, everything else in single lines on standard error.

use anyhow::Result;
use impasto::error::Mended;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::time::Duration;

/// Writes to standard output; a pipe that was closed is an error of its own kind, which `main` knows.
pub(crate) fn out(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    if !text.ends_with('\n') {
        stdout.write_all(b"\n")?;
    }
    Ok(stdout.flush()?)
}

/// Writes bytes to standard output.
pub(crate) fn out_bytes(bytes: &[u8]) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(bytes)?;
    Ok(stdout.flush()?)
}

/// Errors that were told already, each in its line.
#[derive(Debug)]
pub(crate) struct Told;

impl std::fmt::Display for Told {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("see above")
    }
}

impl std::error::Error for Told {}

/// Says in one line what went wrong, the cause last. Errors that name their cause themselves say it once.
pub(crate) fn failed(error: &anyhow::Error) {
    let mut told = String::new();
    for cause in error.chain().map(|cause| cause.to_string()).filter(|cause| !cause.is_empty()) {
        if !told.contains(&cause) {
            told += if told.is_empty() { "" } else { ": " };
            told += &cause;
        }
    }
    eprintln!("impasto: {}", told.split_whitespace().collect::<Vec<_>>().join(" "));
}

/// Says in one line what had to be mended.
pub(crate) fn mended(mended: &[Mended]) {
    if !mended.is_empty() {
        let list: Vec<String> = mended.iter().map(|m| m.to_string()).collect();
        eprintln!("mended: {}", list.join("; "));
    }
}

/// A time as people say it.
pub(crate) fn seconds(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s < 0.9995 => format!("{:.0} ms", s * 1e3),
        s if s < 59.95 => format!("{s:.1} s"),
        s => format!("{} min {:.0} s", (s / 60.0) as u64, s % 60.0),
    }
}

/// A bar on a terminal, nothing in a pipe: `name  [====    ]  37 %  12 s left`.
pub(crate) fn bar(name: &str, length: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr_with_hz(10));
    let style = ProgressStyle::with_template("{prefix}  [{bar:24}]  {percent:>3} %  {eta} left  {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("== "));
    bar.set_prefix(name.to_owned());
    bar
}
