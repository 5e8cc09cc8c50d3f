//! `sprung compare`: compares results.

use sprung::compare::{CombinedResult, ComparedParameter, Comparison, Drift};
use sprung::model::short;
use sprung::progress::Unheard;
use sprung::report::{compose_comparison, significant};
use sprung::session::compare_files;
use sprung::validate::QuantityProof;

use crate::args::Compare;
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::results::{REPORT_FILE, write_html, write_json};
use crate::terminal::{Grid, Terminal, dash};

/// Name of the file of a comparison.
const COMPARISON_FILE: &str = "comparison.json";

pub(crate) fn run(args: &Compare) -> Result<ExitCode, Failure> {
    let terminal = Terminal::new(args.voice, args.json);
    let found = compare_files(&args.files, &mut Unheard)?;
    let comparison = found.comparison;

    let folder = Folder::new(&args.out, found.files, &[COMPARISON_FILE, REPORT_FILE])?;
    let mut output = folder.output()?;
    write_json(&mut output, COMPARISON_FILE, &comparison)?;
    let document = compose_comparison(&comparison, &command_line());
    let report = write_html(&mut output, REPORT_FILE, &document)?;
    output.commit()?;

    terminal.json(&comparison);
    say(terminal, &comparison);
    terminal.say(format!("\nreport: {}", report.display()));
    let promises = comparison.promises_kept.as_ref();
    let drifts = comparison.drift.iter().map(Drift::conclusion);
    let conclusions = comparison.conclusion().into_iter().chain(drifts);
    for sentence in conclusions.chain(promises.cloned()) {
        terminal.say(sentence);
    }
    Ok(ExitCode::Done)
}

fn say(terminal: Terminal, comparison: &Comparison) {
    if !comparison.compared.is_empty() {
        terminal.table(&header_table(comparison));
        terminal.say("");
        terminal.table(&residual_table(comparison));
        terminal.say("");
        terminal.table(&parameter_table(comparison));
    }
    for combined in &comparison.combined {
        terminal.say("");
        terminal.table(&combined_table(combined));
    }
    for drift in &comparison.drift {
        terminal.say("");
        terminal.table(&drift_table(drift));
    }
    if !comparison.promises.is_empty() {
        terminal.table(&promise_table(comparison));
    }
    for finding in &comparison.findings {
        terminal.finding("comparison", finding);
    }
}

/// Returns a table with one row per run and parameter set: the largest error in proportion to its
/// promise.
fn promise_table(comparison: &Comparison) -> Grid {
    let header = [
        "run",
        "parameters",
        "promise",
        "largest",
        "promised",
        "measured",
        "times",
        "log",
        "file",
    ];
    let mut table = Grid::new(header, 4).divided(1, 8).without(&[8, 7, 5, 4]);
    for promise in &comparison.promises {
        let worst = promise.worst();
        let number =
            |of: fn(&QuantityProof<'_>) -> Option<f64>| dash(worst.as_ref().and_then(of), 3);
        table.add_row([
            promise.run.clone(),
            promise.parameters.clone(),
            match promise.promise_kept {
                _ if promise.same_log => "own log".to_owned(),
                None => "-".to_owned(),
                Some(true) => "kept".to_owned(),
                Some(false) => "broken".to_owned(),
            },
            worst.map_or_else(
                || "-".to_owned(),
                |worst| format!("{} {}", worst.joint, worst.name),
            ),
            number(|worst| worst.promised),
            number(|worst| Some(worst.error)),
            dash(worst.and_then(|worst| worst.ratio), 2),
            promise.log.clone(),
            promise.file.clone(),
        ]);
    }
    table
}

fn header_table(comparison: &Comparison) -> Grid {
    let header = ["result", "verdict", "estimator", "settings", "log", "file"];
    let mut table = Grid::new(header, header.len())
        .divided(1, 5)
        .without(&[3, 5]);
    for result in &comparison.compared {
        let settings = &result.settings;
        table.add_row([
            result.label.clone(),
            result.verdict.word().to_owned(),
            result.estimator.clone(),
            format!(
                "λ {} rad/s {} {} Hz",
                significant(settings.filter_cutoff_rad_per_s, 3),
                settings.discretization,
                significant(settings.position_cutoff_hz, 3)
            ),
            format!(
                "{}{}, {} s",
                result.log,
                result
                    .date()
                    .map_or_else(String::new, |date| format!(", {date}")),
                significant(result.duration_s, 3)
            ),
            result.file.clone(),
        ]);
    }
    table
}

/// Returns a table of the root mean square residuals, absolute and relative to the torque.
fn residual_table(comparison: &Comparison) -> Grid {
    let compared = &comparison.compared;
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in compared
        .iter()
        .flat_map(|result| result.residual_rms.iter())
    {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut header = vec!["residual".to_owned()];
    for result in compared {
        header.push(result.label.clone());
        header.push("% of torque".to_owned());
    }
    let mut table = Grid::new(header, 1).divided(1, 2);
    for name in names {
        let mut row = vec![name.to_owned()];
        for result in compared {
            row.push(dash(result.residual_rms.get(name), 3));
            let share = result.relative_residual.get(name);
            row.push(share.map_or_else(|| "-".to_owned(), |r| format!("{:.1}", 100.0 * r)));
        }
        table.add_row(row);
    }
    table
}

fn parameter_table(comparison: &Comparison) -> Grid {
    let mut header = vec!["parameter".to_owned(), "unit".to_owned()];
    for (i, result) in comparison.compared.iter().enumerate() {
        header.push(result.label.clone());
        header.push("± s.e.".to_owned());
        if i > 0 {
            header.push("diff. %".to_owned());
            header.push("in s.e.".to_owned());
        }
    }
    // All parts repeat the first result, to which the differences refer.
    let mut table = Grid::new(header, 2).divided(4, 4).without(&[1, 3]);
    for parameter in &comparison.parameters {
        table.add_row(parameter_row(parameter));
    }
    table
}

/// Returns a table of the combined results of one estimator.
fn combined_table(combined: &CombinedResult) -> Grid {
    let header = [
        format!("{} results combined", combined.results.len()),
        "unit".to_owned(),
        combined.estimator.clone(),
        "± s.e.".to_owned(),
        "results".to_owned(),
        "chi²".to_owned(),
        "p".to_owned(),
        "I² %".to_owned(),
    ];
    let mut table = Grid::new(header, 2).divided(2, 6).without(&[5, 4]);
    for parameter in &combined.parameters {
        table.add_row([
            short(&parameter.name).into_owned(),
            parameter.unit.clone(),
            significant(parameter.value, 5),
            significant(parameter.standard_error, 2),
            parameter.results.to_string(),
            significant(parameter.chi_square, 3),
            significant(parameter.probability, 2),
            format!("{:.0}", parameter.i_squared_percent),
        ]);
    }
    table
}

/// Returns a table of the changes of all parameters over the runs.
fn drift_table(drift: &Drift) -> Grid {
    let header = [
        format!("drift over {} runs", drift.results.len()),
        "unit".to_owned(),
        drift.estimator.clone(),
        "change".to_owned(),
        "± s.e.".to_owned(),
        "%".to_owned(),
        "± %".to_owned(),
        "per day".to_owned(),
        "p adjusted".to_owned(),
        "drifts".to_owned(),
    ];
    let mut table = Grid::new(header, 2).divided(2, 8).without(&[7, 4, 3]);
    for parameter in &drift.parameters {
        table.add_row([
            short(&parameter.name).into_owned(),
            parameter.unit.clone(),
            significant(parameter.first, 5),
            significant(parameter.change, 3),
            significant(parameter.standard_error, 2),
            dash(parameter.change_percent, 3),
            dash(parameter.standard_error_percent, 2),
            dash(parameter.change_per_day, 3),
            significant(parameter.adjusted_probability, 2),
            if parameter.drifts { "yes" } else { "no" }.to_owned(),
        ]);
    }
    table
}

fn parameter_row(parameter: &ComparedParameter) -> Vec<String> {
    let mut row = vec![short(&parameter.name).into_owned(), parameter.unit.clone()];
    for (i, value) in parameter.values.iter().enumerate() {
        let Some(value) = value else {
            row.extend(["absent".to_owned(), "-".to_owned()]);
            if i > 0 {
                row.extend(["-".to_owned(), "-".to_owned()]);
            }
            continue;
        };
        row.push(dash(value.value, 5));
        row.push(if value.fixed {
            "given".to_owned()
        } else {
            dash(value.standard_error, 2)
        });
        if i > 0 {
            let signed = |x: Option<f64>, digits: usize| {
                x.map_or_else(|| "-".to_owned(), |x| format!("{x:+.digits$}"))
            };
            row.push(signed(value.difference_percent, 2));
            row.push(signed(value.difference_standard_errors, 1));
        }
    }
    row
}
