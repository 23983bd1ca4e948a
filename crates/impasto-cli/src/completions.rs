//! `impasto completions`: lines that teach a shell the program's words.

use crate::report::out;
use anyhow::Result;

/// Print completions for a shell.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  impasto completions bash > ~/.local/share/bash-completion/completions/impasto
  impasto completions zsh  > ~/.zfunc/_impasto
  impasto completions fish > ~/.config/fish/completions/impasto.fish")]
pub(crate) struct Args {
    /// Which shell.
    shell: clap_complete::Shell,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut crate::command(), "impasto", &mut script);
    out(&String::from_utf8_lossy(&script))
}
