//! `sprung new`: writes an experiment file to start from.

use std::path::Path;

use sprung::description::Start;
use sprung::session::{
    EXPERIMENT_FILE, NewExperiment, SessionError, joints_of_log, start_from_urdf,
};

use crate::args::New;
use crate::command_line::quoted;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::terminal::Terminal;

/// Number of joints without `--joints`.
const DEFAULT_JOINTS: usize = 2;

pub(crate) fn run(args: &New) -> Result<ExitCode, Failure> {
    let terminal = Terminal::new(args.voice, false);
    let folder = &args.folder;
    refuse_what_is_there(folder)?;
    let start = if let Some(file) = &args.urdf {
        start_from_urdf(file, folder)?
    } else {
        let joints = match (args.joints, args.log.first()) {
            (None, Some(log)) => joints_of_log(log)?,
            (joints, _) => joints,
        };
        Start::table(joints.unwrap_or(DEFAULT_JOINTS)).map_err(SessionError::from)?
    };
    let new = if args.log.is_empty() {
        NewExperiment::without_log(&start)
    } else {
        terminal.follow("reading the log", |progress| {
            NewExperiment::from_logs(&start, &args.log, folder, progress)
        })?
    };

    let place = Folder::new(folder, [], &[EXPERIMENT_FILE])?;
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

/// Prints what the log decided, what the user must fill in, and what the check found.
fn say(terminal: Terminal, new: &NewExperiment) {
    if !new.lines.is_empty() {
        let left_out = match new.left_out {
            0 => String::new(),
            count => format!(" ({count} more are not in the log)"),
        };
        terminal.say(format!("joints: {}{left_out}", new.joints.join(", ")));
        for sentence in &new.about_joints {
            terminal.say(format!("  {sentence}"));
        }
        for line in &new.lines {
            terminal.say(format!("  {line}"));
        }
    }
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
    let refuse = |message| Err(Failure::new(ExitCode::Usage, message));
    let toml = (folder.extension()).is_some_and(|extension| extension == "toml");
    if folder.is_file() || (toml && !folder.is_dir()) {
        return refuse(format!(
            "{} is a file; give the folder for experiment.toml",
            folder.display()
        ));
    }
    let file = folder.join(EXPERIMENT_FILE);
    // A link without target also counts as an existing file.
    if file.symlink_metadata().is_ok() {
        return refuse(format!(
            "{} exists already and is not overwritten; choose another folder, or move the file away",
            file.display()
        ));
    }
    Ok(())
}
