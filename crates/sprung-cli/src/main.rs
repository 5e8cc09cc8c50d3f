//! The command line of sprung.

mod args;
mod commands;
mod exit_code;
mod experiment;
mod output;
mod results;
mod terminal;

fn main() -> std::process::ExitCode {
    commands::run()
}
