//! `sprung check`, `identify` and `simulate` for a position servo, whose log has targets and no torque.

use std::path::{Path, PathBuf};

use serde::Serialize;
use sprung::finding::Finding;
use sprung::report::compose_servo;
use sprung::servo::{ServoExpectation, ServoIdentification, servo_parameters_csv};
use sprung::session::{Parameters, Session};

use crate::args::{Common, Simulate};
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::{Folder, results_folder};
use crate::record::{folder_of_logs, write_log};
use crate::results::{PARAMETERS_FILE, REPORT_FILE, write_html, write_json};
use crate::terminal::{Grid, Terminal, dash};

/// Names of the files that this module alone writes.
const SERVO_FILE: &str = "servo.json";
const CHECK_FILE: &str = "servo-check.json";

/// Parameters that the logs determine, as a file.
#[derive(Serialize)]
struct Expected {
    format: u32,
    parameters: Vec<ServoExpectation>,
    findings: Vec<Finding>,
}

/// Prints the parameters that the logs determine, before any fit.
pub(super) fn check(session: &Session, common: &Common) -> Result<ExitCode, Failure> {
    let terminal = Terminal::new(common.voice, common.json);
    let folder = Folder::new(
        &results_folder(session, common),
        session.inputs(),
        &[CHECK_FILE],
    )?;
    let (parameters, findings) =
        terminal.follow("checking", |progress| session.check_servo(progress))?;
    let expected = Expected {
        format: 1,
        parameters,
        findings,
    };
    let mut output = folder.output()?;
    write_json(&mut output, CHECK_FILE, &expected)?;
    output.commit()?;
    terminal.json(&expected);
    let header = ["parameter", "unit", "first value", "least s.e."];
    let mut table = Grid::new(header, 2);
    for parameter in &expected.parameters {
        table.add_row([
            parameter.name.clone(),
            parameter.unit.clone(),
            dash(Some(parameter.first), 3),
            match parameter.least_error {
                _ if parameter.fixed => "given".to_owned(),
                Some(error) => dash(Some(error), 2),
                None => "cannot be told".to_owned(),
            },
        ]);
    }
    terminal.table(&table);
    terminal.say(
        "first value: by linear least squares, only a start; least s.e.: the smallest standard error that \
         these logs allow about the first values",
    );
    for finding in &expected.findings {
        terminal.finding("servo", finding);
    }
    Ok(ExitCode::Done)
}

/// Identifies the servo and writes all results.
pub(super) fn identify(session: &Session, common: &Common) -> Result<ExitCode, Failure> {
    let terminal = Terminal::new(common.voice, common.json);
    let folder = Folder::new(
        &results_folder(session, common),
        session.inputs(),
        &[SERVO_FILE, PARAMETERS_FILE, REPORT_FILE],
    )?;
    let found = terminal.follow("identifying", |progress| session.identify_servo(progress))?;
    let mut output = folder.output()?;
    write_json(&mut output, SERVO_FILE, &found)?;
    output.text(PARAMETERS_FILE, &servo_parameters_csv(&found))?;
    let document = compose_servo(&found, &command_line(), session.text());
    let report = write_html(&mut output, REPORT_FILE, &document)?;
    output.commit()?;

    terminal.json(&found);
    terminal.table(&table(&found));
    terminal.say(format!(
        "simulated minus logged position: {} mrad, {} times the noise of the sensor",
        dash(Some(1e3 * found.fit.position_rms_rad), 3),
        dash(Some(found.fit.position_rms_over_noise), 3),
    ));
    for finding in &found.findings {
        terminal.finding("servo", finding);
    }
    terminal.say(format!("\nreport: {}", report.display()));
    Ok(if found.is_usable() {
        ExitCode::Done
    } else {
        ExitCode::Unusable
    })
}

fn table(found: &ServoIdentification) -> Grid {
    let header = ["parameter", "unit", "value", "± s.e."];
    let mut table = Grid::new(header, 2);
    for parameter in found.parameters.iter().chain([&found.braking]) {
        table.add_row([
            parameter.name.clone(),
            parameter.unit.clone(),
            dash(Some(parameter.value), 5),
            if parameter.fixed {
                "given".to_owned()
            } else {
                dash(parameter.standard_error, 2)
            },
        ]);
    }
    table
}

/// Simulates the logs that the experiment names.
pub(super) fn simulate(session: &Session, args: &Simulate) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let parameters = (args.parameters.as_deref())
        .map(Parameters::open)
        .transpose()?;
    let twin = session.servo_twin(parameters.as_ref())?;
    let names: Vec<PathBuf> = (twin.files().iter())
        .map(|path| {
            Path::new(path.file_name().unwrap_or("simulated".as_ref())).with_extension("csv")
        })
        .collect();
    let paths = twin.files().iter().map(PathBuf::as_path);
    let files = paths.zip(names.iter().map(PathBuf::as_path));
    let folder = folder_of_logs(files, common.out.as_deref(), "")?;
    let folder = Folder::new(&folder, session.inputs(), &names)?;
    let mut output = folder.output()?;
    let mut logs = Vec::new();
    for (index, name) in names.iter().enumerate() {
        logs.push(write_log(
            name,
            &mut output,
            terminal,
            |write, progress| twin.write(index, write, progress),
        )?);
    }
    output.commit()?;
    terminal.json(&serde_json::json!({ "logs": logs }));
    for log in logs {
        terminal.say(format!("log: {}", log.display()));
    }
    Ok(ExitCode::Done)
}
