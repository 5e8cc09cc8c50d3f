//! `sprung validate`: validates parameters on other logs.

use sprung::report::Contents;
use sprung::session::{Session, Usability};

use super::begin::Opened;
use crate::args::Validate;
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::results::{VALIDATED_FILES, curves_beside, write_report, write_validated};

pub(crate) fn run(args: &Validate) -> Result<ExitCode, Failure> {
    let opened = Opened::new(
        &args.experiment,
        &args.common,
        (args.parameters.as_deref(), args.accept_refining),
        Session::allow_validation,
    )?;
    let folder = Folder::new(&opened.path, opened.inputs(), &VALIDATED_FILES)?;
    let Opened {
        session,
        terminal,
        file,
        parameters,
        ..
    } = opened;
    let found = terminal.follow("validating", |progress| {
        session.validate(&parameters, progress)
    })?;

    let mut output = folder.output()?;
    write_validated(&mut output, &found)?;
    // The curves of the identification are in the same folder, unless they were removed.
    let (trace, fit) = match parameters.identification {
        Some(_) => curves_beside(&file),
        None => (None, None),
    };
    let contents = Contents {
        identification: parameters.identification.as_ref(),
        trace: trace.as_ref(),
        fit: fit.as_ref(),
        validation: Some((&found.validation, &found.curves)),
        truth: None,
        command: &command_line(),
        experiment: session.text(),
    };
    let report = write_report(&mut output, &contents)?;
    output.commit()?;

    terminal.json(&found.validation);
    terminal.validation(&found.validation);
    terminal.say(format!("\nreport: {}", report.display()));
    terminal.say(found.validation.sentence());
    Ok(Usability::from(&found.validation).into())
}
