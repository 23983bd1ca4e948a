//! The program `impasto`.

mod bench;
mod options;

use clap::Parser;

#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[arg(long, global = true, default_value_t = 0)]
    threads: usize,
    #[arg(long, global = true, hide = true)]
    simd: Option<String>,
}

#[derive(clap::Subcommand)]
enum Command {
    Bench(bench::Args),
}

fn main() -> anyhow::Result<()> {
    let cli = Cli::parse();
    let workers = match cli.simd {
        Some(name) => impasto::par::Workers::with_level(cli.threads, impasto::par::level_by_name(&name).unwrap()),
        None => impasto::par::Workers::new(cli.threads),
    };
    match cli.command {
        Command::Bench(args) => bench::run(&args, &workers),
    }
}
