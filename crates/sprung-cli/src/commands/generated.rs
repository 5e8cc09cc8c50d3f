//! `sprung completions` and `sprung man`: texts that are generated from the arguments.

use clap::CommandFactory;
use clap_complete::generate;
use clap_mangen::Man;

use crate::args::{Cli, Completions, ManPage};
use crate::exit_code::{ExitCode, Failure};
use crate::terminal::print;

/// Name of the program in shells and manuals.
const PROGRAM: &str = "sprung";

pub(crate) fn completions(args: &Completions) -> ExitCode {
    let mut text = Vec::new();
    generate(args.shell, &mut Cli::command(), PROGRAM, &mut text);
    said(&text)
}

pub(crate) fn man(args: &ManPage) -> Result<ExitCode, Failure> {
    let mut command = Cli::command();
    command.build();
    let command = match &args.verb {
        None => command,
        Some(verb) => {
            let verbs: Vec<&str> = command
                .get_subcommands()
                .map(clap::Command::get_name)
                .collect();
            let known = verbs.join(", ");
            (command.find_subcommand(verb))
                .cloned()
                .ok_or_else(|| {
                    Failure::usage(format!(
                        "there is no verb \"{verb}\"; the verbs are {known}"
                    ))
                })?
                .version(env!("CARGO_PKG_VERSION"))
        }
    };
    let mut text = Vec::new();
    (Man::new(command).render(&mut text))
        .map_err(|error| Failure::file(format!("cannot write the page: {error}")))?;
    Ok(said(&text))
}

fn said(text: &[u8]) -> ExitCode {
    print(&String::from_utf8_lossy(text).trim_end());
    ExitCode::Done
}
