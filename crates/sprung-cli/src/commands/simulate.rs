//! `sprung simulate`: simulates a log with the digital twin.

use sprung::model::short;
use sprung::report::significant;
use sprung::session::{ExpectedError, Parameters, Session};

use super::servo;
use crate::args::Simulate;
use crate::command_line::quoted;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::record::{folder_of_logs, write_log};
use crate::terminal::{Grid, Terminal, dash};

pub(crate) fn run(args: &Simulate) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let session = Session::open(&args.experiment, &common.overrides)?;
    if session.is_servo() {
        if args.expected_errors {
            let message =
                "--expected-errors needs a log with torques; that of a position servo has none";
            return Err(Failure::usage(message));
        }
        return servo::simulate(&session, args);
    }
    let parameters = (args.parameters.as_deref())
        .map(Parameters::open)
        .transpose()?;
    let twin = session.twin(args.run.as_deref(), parameters.as_ref())?;

    let name = twin.name();
    let path = folder_of_logs(
        std::iter::once((twin.named(), name.as_path())),
        common.out.as_deref(),
        ", or another file with --set log.file=FILE",
    )?;
    let folder = Folder::new(&path, session.inputs(), &[&name])?;
    let mut output = folder.output()?;
    let path = write_log(&name, &mut output, terminal, |write, progress| {
        twin.write(write, progress)
    })?;
    let expected = (args.expected_errors)
        .then(|| {
            terminal.follow("standard errors", |progress| {
                session.expected_errors(&twin, progress)
            })
        })
        .transpose()?;
    output.commit()?;
    match &expected {
        Some(errors) => {
            terminal.json(&serde_json::json!({ "log": path, "expected_errors": errors }));
        }
        None => terminal.json(&serde_json::json!({ "log": path })),
    }
    terminal.say(format!("log: {}", path.display()));
    if let Some(errors) = &expected {
        say_errors(terminal, errors);
    }
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

/// Prints the standard errors of the experiment, and the parameters that it does not determine.
fn say_errors(terminal: Terminal, errors: &[ExpectedError]) {
    let header = ["parameter", "unit", "true", "± s.e.", "%"];
    let mut table = Grid::new(header, 2).divided(3, 2);
    for expected in errors {
        let error = expected.is_determined.then_some(expected.standard_error);
        let share = error.filter(|_| expected.value != 0.0);
        table.add_row(vec![
            short(&expected.name).into_owned(),
            expected.unit.clone(),
            significant(expected.value, 5),
            dash(error, 2),
            dash(share.map(|error| 100.0 * error / expected.value.abs()), 2),
        ]);
    }
    terminal.table(&table);
    let open: Vec<&str> = (errors.iter().filter(|expected| !expected.is_determined))
        .map(|expected| &*expected.name)
        .collect();
    if !open.is_empty() {
        terminal.say(format!(
            "not determined, because the standard error exceeds the value: {}",
            open.join(", ")
        ));
    }
}
