//! The command line of sprung, for its binary and for programs that contain it.

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

pub use commands::run;

/// Keeps panics that the readers of logs catch off the terminal. The readers turn them into errors
/// about a damaged log.
pub fn hide_caught_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !sprung::log::panics_are_caught() {
            usual(panic);
        }
    }));
}
