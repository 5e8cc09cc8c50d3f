//! `sprung new`: writes an experiment file to start from.

use std::path::Path;

use sprung::description::{Start, template};
use sprung::session::{EXPERIMENT_FILE, SessionError, start_from_urdf};

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
    let (start, table) = match &args.urdf {
        Some(file) => (start_from_urdf(file, folder)?, ""),
        None => (
            Start::table(args.joints.unwrap_or(DEFAULT_JOINTS)).map_err(SessionError::from)?,
            "the table, ",
        ),
    };

    let place = Folder::new(folder, [], &[EXPERIMENT_FILE])?;
    let mut output = place.output()?;
    let path = output.text(EXPERIMENT_FILE, &template(&start))?;
    output.commit()?;

    terminal.say(format!(
        "experiment: {}\n\nnext:\n  fill in what is marked FILL IN: {table}the log and its columns\n  \
         sprung identify {}",
        path.display(),
        quoted(&folder.to_string_lossy()),
    ));
    Ok(ExitCode::Done)
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
