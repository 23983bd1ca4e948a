//! The program `impasto`: textures as information, on the command line. One subcommand a file, no algorithm in it.

mod bench;
mod check;
mod completions;
mod cut;
mod cut_out;
mod gallery;
mod gallery_page;
mod info;
mod inputs;
mod options;
mod probe;
mod render;
mod report;
mod run;
mod turntable;

use anyhow::{Context, Result};
use clap::Parser;
use impasto::par::{LEVEL_NAMES, Workers, level_by_name};

/// Textures as information: paint a surface, grow its skin, cut it open, read data off it. No GPU needed.
#[derive(Parser)]
#[command(name = "impasto", version, max_term_width = 110, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Threads to use; 0 is one a core. Pictures do not depend on it.
    #[arg(long, global = true, default_value_t = 0, value_name = "N")]
    threads: usize,
    /// SIMD level to use: scalar, sse2, avx2, avx512. Pictures do not depend on it.
    #[arg(long, global = true, hide = true, value_name = "LEVEL")]
    simd: Option<String>,
}

const EXAMPLES: &str = "Examples:
  impasto gallery                               every picture from built-in samples, and a page to look at
  impasto render model.glb -o picture.png       a picture, with the materials of the file
  impasto render sample:chameleon -o a.png      no file at hand? samples are made by formula
  impasto info scan.ply                         what is in a file, and what had to be mended
  impasto probe scan.ply --at 640,360           what is at a pixel: triangle, texel, position, data
  impasto cut scan.ply -o cut.png               cut open: both halves, with the grain of their sections
  impasto render scan.ply -o a.png --color-by t data as colours, with a legend; impasto check a.png reads it back
Each command has its own examples: impasto render --help";

/// What the program can do.
#[derive(clap::Subcommand)]
enum Command {
    Info(info::Args),
    Render(render::Args),
    Probe(probe::Args),
    Check(check::Args),
    Turntable(turntable::Args),
    Cut(Box<cut::Args>),
    Run(run::Args),
    Gallery(gallery::Args),
    Bench(bench::Args),
    Completions(completions::Args),
}

fn main() {
    std::panic::set_hook(Box::new(bug));
    let cli = Cli::parse();
    if let Err(error) = run_command(cli) {
        // A reader that has seen enough is no failure.
        if error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe) {
            return;
        }
        if !error.is::<report::Told>() {
            report::failed(&error);
        }
        std::process::exit(1);
    }
}

fn run_command(cli: Cli) -> Result<()> {
    let workers = match &cli.simd {
        None => Workers::new(cli.threads),
        Some(name) => {
            let level = level_by_name(name).with_context(|| {
                format!("no SIMD level {name:?} on this machine; known are {}", LEVEL_NAMES.join(", "))
            })?;
            Workers::with_level(cli.threads, level)
        }
    };
    match cli.command {
        Command::Info(args) => info::run(&args),
        Command::Render(args) => render::run(&args, &workers),
        Command::Probe(args) => probe::run(&args, &workers),
        Command::Check(args) => check::run(&args, &workers),
        Command::Turntable(args) => turntable::run(&args, &workers),
        Command::Cut(args) => cut::run(&args, &workers),
        Command::Run(args) => run::run(&args, &workers),
        Command::Gallery(args) => gallery::run(&args, &workers),
        Command::Bench(args) => bench::run(&args, &workers),
        Command::Completions(args) => completions::run(&args),
    }
}

/// A bug of ours in one line, with where it is; more for those who ask by RUST_BACKTRACE.
fn bug(panic: &std::panic::PanicHookInfo) {
    let words = panic.payload_as_str().unwrap_or("something impossible happened");
    let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
    let place = panic.location().map(|l| format!(" ({}, line {})", l.file(), l.line())).unwrap_or_default();
    eprintln!("impasto: a bug, please report it: {words}{place}");
    let trace = std::backtrace::Backtrace::capture();
    if trace.status() == std::backtrace::BacktraceStatus::Captured {
        eprintln!("{trace}");
    }
}

/// The whole command line, for completions and tests.
fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}
