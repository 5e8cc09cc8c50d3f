//! `sprung new`: an experiment file to start from.

use std::path::{Path, PathBuf};

use sprung::description::{Start, StartError, Urdf, template};

use super::quoted;
use crate::args::New;
use crate::exit_code::{ExitCode, Failure};
use crate::experiment::read_text;
use crate::output::Output;
use crate::terminal::Terminal;

/// Joints of a table if nobody says how many.
const JOINTS: usize = 2;

pub(crate) fn run(args: &New) -> Result<ExitCode, Failure> {
    let terminal = Terminal::new(args.voice, false);
    let folder = &args.folder;
    refuse_what_is_there(folder)?;
    let (start, table) = match &args.urdf {
        Some(file) => (from_urdf(file, folder)?, ""),
        None => (
            Start::table(args.joints.unwrap_or(JOINTS)).map_err(wrong)?,
            "the table, ",
        ),
    };

    std::fs::create_dir_all(folder).map_err(|error| {
        let folder = folder.display();
        Failure::new(
            ExitCode::File,
            format!("cannot create the folder {folder}: {error}"),
        )
    })?;
    let mut output = Output::new(folder)?;
    let path = output.text("experiment.toml", &template(&start))?;
    output.commit()?;

    terminal.say(format!(
        "experiment: {}\n\nnext:\n  fill in what is marked FILL IN: {table}the log and its columns\n  \
         sprung identify {}",
        path.display(),
        quoted(&folder.to_string_lossy()),
    ));
    Ok(ExitCode::Done)
}

/// Checks that nothing would be overwritten.
fn refuse_what_is_there(folder: &Path) -> Result<(), Failure> {
    let refuse = |message| Err(Failure::new(ExitCode::Usage, message));
    let toml = (folder.extension()).is_some_and(|extension| extension == "toml");
    if folder.is_file() || (toml && !folder.is_dir()) {
        return refuse(format!(
            "{} names a file; give the folder that experiment.toml shall be written to",
            folder.display()
        ));
    }
    let file = folder.join("experiment.toml");
    // A link that leads nowhere is there, too.
    if file.symlink_metadata().is_ok() {
        return refuse(format!(
            "{} is there already and is not overwritten; choose another folder, or move the file away",
            file.display()
        ));
    }
    Ok(())
}

fn from_urdf(file: &Path, folder: &Path) -> Result<Start, Failure> {
    let text = read_text(file)?;
    let urdf = Urdf::parse(&file.display().to_string(), &text)
        .map_err(|error| Failure::new(ExitCode::Usage, error))?;
    let path = reference(file, folder).map_err(|error| {
        Failure::new(
            ExitCode::File,
            format!("cannot find the folder of {}: {error}", file.display()),
        )
    })?;
    let path = path.to_str().ok_or_else(|| {
        Failure::new(
            ExitCode::Usage,
            format!(
                "the path {} is not Unicode and cannot stand in experiment.toml; rename it",
                path.display()
            ),
        )
    })?;
    Start::urdf(&urdf, path).map_err(wrong)
}

fn wrong(error: StartError) -> Failure {
    Failure::new(ExitCode::Usage, error)
}

/// Returns the path of a file as an experiment in `folder` names it: relative
/// if it lies below the folder or beside it, otherwise absolute.
fn reference(file: &Path, folder: &Path) -> std::io::Result<PathBuf> {
    // The file keeps its name, be it that of a link.
    let file = std::path::absolute(file)?;
    let (Some(parent), Some(name)) = (file.parent(), file.file_name()) else {
        return Ok(file);
    };
    let file = parent.canonicalize()?.join(name);
    let relative = resolved(folder).and_then(|folder| {
        let below = |root: &Path| file.strip_prefix(root).ok().map(Path::to_owned);
        below(&folder).or_else(|| Some(Path::new("..").join(below(folder.parent()?)?)))
    });
    Ok(relative.unwrap_or(file))
}

/// Returns the absolute path of a folder, which need not be there yet.
fn resolved(folder: &Path) -> Option<PathBuf> {
    let folder = std::path::absolute(folder).ok()?;
    folder.ancestors().find_map(|known| {
        let rest = folder.strip_prefix(known).ok()?;
        Some(known.canonicalize().ok()?.join(rest))
    })
}
