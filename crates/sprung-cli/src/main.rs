//! The command line of sprung.

mod args;
mod command_line;
mod commands;
mod exit_code;
mod halt;
mod output;
mod record;
mod results;
mod switch;
mod terminal;

fn main() -> std::process::ExitCode {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // The readers of logs turn some panics into errors about a damaged log.
        if !sprung::log::panics_are_caught() {
            usual(panic);
        }
    }));
    commands::run()
}
