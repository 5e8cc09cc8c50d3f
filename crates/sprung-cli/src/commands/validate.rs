//! `sprung validate`: validates parameters on other logs.

use sprung::report::Contents;
use sprung::session::{Parameters, Session, Usability, find_identification};

use super::begin::refuse_refining;
use crate::args::Validate;
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::{Folder, results_folder};
use crate::results::{VALIDATED_FILES, curves_beside, write_report, write_validated};
use crate::terminal::Terminal;

pub(crate) fn run(args: &Validate) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let session = Session::open(&args.experiment, &common.overrides)?;
    session.allow_validation()?;
    let path = results_folder(&session, common);
    let file = match &args.parameters {
        Some(file) => file.clone(),
        None => find_identification(&path, &session.results_folder())?,
    };
    let parameters = Parameters::open(&file)?;
    refuse_refining(&parameters, &file, args.accept_refining)?;
    let inputs = session.inputs().into_iter().chain([file.clone()]);
    let folder = Folder::new(&path, inputs, &VALIDATED_FILES)?;
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
