//! `sprung simulate`: simulates a log with the digital twin.

use std::path::{Path, PathBuf};

use sprung::session::{Parameters, Recording, Session};

use super::servo;
use crate::args::Simulate;
use crate::command_line::quoted;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::record::write_log;
use crate::terminal::Terminal;

pub(crate) fn run(args: &Simulate) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let session = Session::open(&args.experiment, &common.overrides)?;
    if session.is_servo() {
        return servo::simulate(&session, args);
    }
    let parameters = (args.parameters.as_deref())
        .map(Parameters::open)
        .transpose()?;
    let twin = session.twin(args.run.as_deref(), parameters.as_ref())?;

    let path = folder_of(&twin, common.out.as_deref())?;
    let folder = Folder::new(&path, session.inputs(), &[twin.name()])?;
    let mut output = folder.output()?;
    let path = write_log(&twin, &mut output, terminal)?;
    output.commit()?;
    terminal.json(&serde_json::json!({ "log": path }));
    terminal.say(format!("log: {}", path.display()));
    if args.run.is_none() && path != twin.named() {
        let log = std::path::absolute(&path).unwrap_or(path);
        terminal.say(format!(
            "identify it with: sprung identify {} --set {}",
            quoted(&args.experiment.to_string_lossy()),
            quoted(&format!("log.file={}", log.display())),
        ));
    }
    Ok(ExitCode::Done)
}

/// Returns the folder for the log: that of `--out`, or else the folder in which the experiment names the log. There, no
/// file is overwritten, because it may be a measured log.
fn folder_of(twin: &Recording<'_>, out: Option<&Path>) -> Result<PathBuf, Failure> {
    if let Some(out) = out {
        return Ok(out.to_owned());
    }
    let file = twin.named().with_file_name(twin.name());
    if file.symlink_metadata().is_ok() {
        return Err(Failure::new(
            ExitCode::Usage,
            format!(
                "{} exists and is not overwritten; give another folder with --out, or another file with \
                 --set log.file=FILE",
                file.display()
            ),
        ));
    }
    Ok(file.parent().map_or_else(PathBuf::new, Path::to_owned))
}
