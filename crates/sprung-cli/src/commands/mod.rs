//! The commands, one file each.

mod begin;
mod check;
mod compare;
mod control;
mod demo;
mod excite;
mod explain;
mod export;
mod generated;
mod identify;
mod new;
mod servo;
mod simulate;
mod validate;
mod watch;

use std::ffi::OsString;
#[cfg(unix)]
use std::sync::Arc;

use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::args::{Cli, Verb, Work};
use crate::command_line::{remember, words};
use crate::exit_code::{ExitCode, Failure};
use crate::hide_caught_panics;
use crate::terminal::{self, complain, complain_json};

/// Flags of earlier versions: verb, flag, and what replaces it.
const REMOVED: [(&str, &str, &str); 1] = [(
    "check",
    "--thorough",
    "the check now tries every channel by default; remove the flag",
)];

/// Runs a command and returns its exit code.
///
/// - `words`: the words that were typed, the name of the program first.
pub fn run(words: impl IntoIterator<Item = OsString>) -> u8 {
    hide_caught_panics();
    report_full_files();
    let words: Vec<OsString> = words.into_iter().collect();
    remember(words.clone());
    let cli = match Cli::try_parse_from(words) {
        Ok(cli) => cli,
        Err(error) => return refused(error) as u8,
    };
    let json = cli.verb.wants_json();
    let outcome = match cli.verb {
        Verb::Demo(args) => with_threads(args.work, || demo::run(&args)),
        Verb::New(args) => new::run(&args),
        Verb::Check(args) => with_threads(args.common.work, || check::run(&args)),
        Verb::Identify(args) => with_threads(args.common.work, || identify::run(&args)),
        Verb::Validate(args) => with_threads(args.common.work, || validate::run(&args)),
        Verb::Watch(args) => with_threads(args.common.work, || watch::run(&args)),
        Verb::Compare(args) => compare::run(&args),
        Verb::Simulate(args) => with_threads(args.common.work, || simulate::run(&args)),
        Verb::Excite(args) => with_threads(args.common.work, || excite::run(&args)),
        Verb::Control(args) => with_threads(args.common.work, || control::run(&args)),
        Verb::Export(args) => with_threads(args.common.work, || export::run(&args)),
        Verb::Explain(args) => explain::run(&args),
        Verb::Completions(args) => Ok(generated::completions(&args)),
        Verb::Man(args) => generated::man(&args),
        Verb::Schema => {
            terminal::print_json(&sprung::description::schema());
            Ok(ExitCode::Done)
        }
    };
    match outcome {
        Ok(_) if terminal::output_lost() => ExitCode::File as u8,
        Ok(code) => code as u8,
        Err(failure) if json => {
            complain_json(&failure.described());
            failure.code as u8
        }
        Err(failure) => {
            complain(&format!("error: {}", failure.message));
            failure.code as u8
        }
    }
}

/// Lets a write beyond the largest size of a file fail like any other. Without a handler the signal ends the program,
/// which then leaves its temporary files.
fn report_full_files() {
    #[cfg(unix)]
    {
        use signal_hook::consts::SIGXFSZ;
        // The flag is not read: the write returns the error.
        let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
    }
}

/// Prints help or the error of a command line.
fn refused(mut error: clap::Error) -> ExitCode {
    let is_help = matches!(
        error.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion
    );
    if !is_help && words().iter().any(|word| word == "--json") {
        let message = error.to_string();
        let cause = message.split("\n\n").next().unwrap_or_default();
        let cause = cause.trim_start_matches("error: ").replace('\n', " ");
        let remedy = successor(&error).unwrap_or("try sprung --help");
        let message = format!("{}; {remedy}", cause.trim());
        complain_json(&Failure::usage(message).described());
    } else {
        if let Some(successor) = successor(&error) {
            error.remove(ContextKind::SuggestedArg);
            let tip = ContextValue::StyledStrs(vec![successor.into()]);
            error.insert(ContextKind::Suggested, tip);
        }
        let text = error.render().to_string();
        // Words of the command line may be names of files.
        if !is_help && text.contains(|c: char| c.is_control() && c != '\n') {
            complain(text.trim_end());
        } else if let Err(lost) = error.print()
            && is_help
            && lost.kind() != std::io::ErrorKind::BrokenPipe
        {
            complain(&format!("error: cannot write to stdout: {lost}"));
            return ExitCode::File;
        }
    }
    if is_help {
        ExitCode::Done
    } else {
        ExitCode::Usage
    }
}

/// Returns what replaces the flag of an earlier version that an error names.
fn successor(error: &clap::Error) -> Option<&'static str> {
    let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let typed = words();
    let removed = (REMOVED.iter())
        .find(|(verb, flag, _)| typed.get(1).is_some_and(|word| word == verb) && unknown == flag);
    removed.map(|(.., instead)| *instead)
}

/// Runs a command with the requested number of threads.
fn with_threads(
    work: Work,
    run: impl FnOnce() -> Result<ExitCode, Failure> + Send,
) -> Result<ExitCode, Failure> {
    let threads = work.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    match pool.build() {
        Ok(pool) => pool.install(run),
        Err(error) => Err(Failure::usage(format!(
            "cannot start threads: {error}; give --threads 1"
        ))),
    }
}
