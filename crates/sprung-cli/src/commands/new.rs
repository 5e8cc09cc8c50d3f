//! `sprung new`: writes an experiment file to start from.

use std::path::Path;

use sprung::session::{EXPERIMENT_FILE, NewExperiment};

use super::begin::{begun, refuse_file, say_choice};
use crate::args::New;
use crate::command_line::quoted;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::terminal::Terminal;

pub(crate) fn run(args: &New) -> Result<ExitCode, Failure> {
    let terminal = Terminal::new(args.voice, false);
    let folder = &args.folder;
    refuse_what_is_there(folder)?;
    let place = Folder::new(folder, [], &[EXPERIMENT_FILE])?;
    let new = begun(
        terminal,
        args.urdf.as_deref(),
        args.joints,
        (&args.log, args.topics.as_deref()),
        folder,
    )?;

    let mut output = place.output()?;
    let path = output.text(EXPERIMENT_FILE, &new.text)?;
    output.commit()?;

    terminal.say(format!("experiment: {}", path.display()));
    say(terminal, &new);
    if new.is_refused() {
        return Ok(ExitCode::Log);
    }
    let folder = quoted(&folder.to_string_lossy());
    let next = if new.open.is_empty() {
        ""
    } else {
        "  fill in these lines\n"
    };
    terminal.say(format!("\nnext:\n{next}  sprung identify {folder}"));
    Ok(ExitCode::Done)
}

/// Prints the choices by the log, the lines to fill in, and the findings of the check.
fn say(terminal: Terminal, new: &NewExperiment) {
    say_choice(terminal, new);
    if !new.open.is_empty() {
        terminal.say("\nFILL IN, because only you know it:");
        for (line, key) in &new.open {
            terminal.say(format!("  line {line}: {key}"));
        }
    }
    if let Some(why) = &new.unchecked {
        terminal.say(format!("\nthe log could not be checked: {why}"));
    }
    for finding in &new.findings {
        terminal.finding_with_line(finding);
    }
}

/// Returns an error if a file would be overwritten.
fn refuse_what_is_there(folder: &Path) -> Result<(), Failure> {
    refuse_file(folder)?;
    let file = folder.join(EXPERIMENT_FILE);
    // A link without target also counts as an existing file.
    if file.symlink_metadata().is_ok() {
        return Err(Failure::usage(format!(
            "{} exists already and is not overwritten; choose another folder, or move the file away",
            file.display()
        )));
    }
    Ok(())
}
