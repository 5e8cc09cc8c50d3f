//! `sprung identify`: a log in, parameters out.

use std::path::Path;

use sprung::estimate::{Identified, IdentifyError, Verdict, identify, parameters_csv};
use sprung::log::LogError;
use sprung::progress::Progress;
use sprung::regression::PassError;
use sprung::report::{Contents, compose, render};

use super::validate;
use crate::args::Identify;
use crate::exit_code::{ExitCode, Failure};
use crate::experiment::{Loaded, load, openers, sources};
use crate::output::Output;
use crate::terminal::{Terminal, show};

pub(crate) fn run(args: &Identify) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let loaded = load(&args.experiment, &common.overrides)?;
    let found = from_disk(&loaded, terminal)?;

    let folder = loaded.out(common.out.as_ref());
    let mut output = Output::new(&folder)?.keeping(loaded.inputs());
    write_results(&mut output, &found)?;
    let outdated = validate::outdate(&mut output, &folder);
    let contents = Contents {
        identification: Some(&found.identification),
        trace: Some(&found.trace),
        fit: Some(&found.fit),
        command: &super::command_line(),
        experiment: &loaded.text,
        ..Contents::default()
    };
    let report = write_report(&mut output, &contents)?;
    output.commit()?;

    terminal.json(&found.identification);
    terminal.parameters(&found.identification, None);
    if outdated {
        terminal.say(
            "\nthe validation in that folder was of earlier parameters and is gone; run sprung validate \
             again",
        );
    }
    terminal.say(format!("\nreport: {}", report.display()));
    Ok(code_of(&found))
}

/// Identifies from the log that an experiment names.
pub(super) fn from_disk(loaded: &Loaded, terminal: Terminal) -> Result<Identified, Failure> {
    let paths = loaded.log_paths(None)?;
    let bar = terminal.progress("identifying", None);
    let mut openers = openers(&loaded.folder, &paths);
    let mut sources = sources(&paths, &mut openers);
    let mut progress = |progress: Progress| show(&bar, progress);
    let found = identify(
        &loaded.experiment,
        &loaded.model,
        &mut sources,
        &mut progress,
    );
    bar.finish_and_clear();
    found.map_err(|error| failure(&error))
}

/// Returns how an identification that failed ends the program.
pub(super) fn failure(error: &IdentifyError) -> Failure {
    let code = match error {
        IdentifyError::Pass(pass) => code_of_pass(pass),
        IdentifyError::NotFinite { .. } | IdentifyError::Refused(_) => ExitCode::Log,
        _ => ExitCode::Usage,
    };
    Failure::new(code, error)
}

/// Returns how an error of reading a log ends the program.
pub(super) fn code_of_pass(error: &PassError) -> ExitCode {
    match error {
        PassError::Log(LogError::Io { .. }) => ExitCode::File,
        PassError::Log(_) => ExitCode::Log,
        _ => ExitCode::Usage,
    }
}

/// Writes all files of an identification but the report.
pub(super) fn write_results(output: &mut Output, found: &Identified) -> Result<(), Failure> {
    output.write("identification.json", |write| {
        serde_json::to_writer_pretty(&mut *write, &found.identification)?;
        writeln!(write)
    })?;
    output.text("parameters.csv", &parameters_csv(&found.identification))?;
    output.text("trace.csv", &found.trace.to_csv("estimator"))?;
    output.text("fit.csv", &found.fit.to_csv("source"))?;
    Ok(())
}

/// Writes the report and returns where it will be.
pub(super) fn write_report(
    output: &mut Output,
    contents: &Contents<'_>,
) -> Result<std::path::PathBuf, Failure> {
    let html = render(&compose(contents)).map_err(|error| {
        Failure::new(ExitCode::File, format!("cannot make the report: {error}"))
    })?;
    output.text(Path::new("report.html"), &html)
}

fn code_of(found: &Identified) -> ExitCode {
    match found.identification.results.first() {
        Some(result) if result.verdict == Verdict::Unusable => ExitCode::Unusable,
        _ => ExitCode::Done,
    }
}
