//! `sprung identify`: identifies the parameters from a log.

use std::path::PathBuf;

use sprung::estimate::Identified;
use sprung::report::Contents;
use sprung::session::{Session, Usability, read_identification};

use super::begin::experiment_of;
use super::servo;
use crate::args::Identify;
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::{Folder, results_folder};
use crate::results::{IDENTIFIED_FILES, outdate_validation, write_identified, write_report};
use crate::terminal::Terminal;

pub(crate) fn run(args: &Identify) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let experiment = experiment_of(args, terminal)?;
    let session = Session::open(&experiment, &common.overrides)?;
    let earlier = args.laws_from.iter().map(|path| read_identification(path));
    let earlier = earlier.collect::<Result<Vec<_>, _>>()?;
    let session = match &earlier[..] {
        [] => session,
        all => session.with_laws_from(all)?,
    };
    if session.is_servo() {
        return servo::identify(&session, common);
    }
    // With --urdf, --out is the folder of the experiment.
    let results = match args.urdf {
        Some(_) => session.results_folder(),
        None => results_folder(&session, common),
    };
    let folder = Folder::new(&results, session.inputs(), &IDENTIFIED_FILES)?;
    // A refinement may take minutes. If the program is killed then, the folder holds the result of
    // least squares. If it cannot be written, the result of the refinement cannot either.
    let mut outdated = false;
    let mut first = |found: &Identified| {
        if let Ok((_, removed)) = write(&folder, &session, found) {
            outdated = removed;
        }
    };
    let found = terminal.follow("identifying", |progress| {
        session.identify_and_tell(progress, &mut first)
    })?;
    let (report, removed) = write(&folder, &session, &found)?;
    outdated |= removed;

    terminal.json(&found.identification);
    terminal.parameters(&found.identification, None);
    terminal.springs(&found.identification);
    terminal.unknowns(&found.identification.unknowns);
    if outdated {
        terminal.say(
            "\nthe validation in that folder belonged to earlier parameters and was removed; run \
             sprung validate again",
        );
    }
    terminal.say("");
    terminal.applied(&found.identification);
    terminal.say(format!("report: {}", report.display()));
    terminal.decision(&found.identification);
    Ok(Usability::from(&found.identification).into())
}

/// Writes all files of an identification. Returns the path of the report, and whether an outdated
/// validation was removed.
fn write(
    folder: &Folder,
    session: &Session,
    found: &Identified,
) -> Result<(PathBuf, bool), Failure> {
    let mut output = folder.output()?;
    write_identified(&mut output, found)?;
    let outdated = outdate_validation(&mut output);
    let contents = Contents {
        identification: Some(&found.identification),
        trace: Some(&found.trace),
        fit: Some(&found.fit),
        command: &command_line(),
        experiment: session.text(),
        ..Contents::default()
    };
    let report = write_report(&mut output, &contents)?;
    output.commit()?;
    Ok((report, outdated))
}
