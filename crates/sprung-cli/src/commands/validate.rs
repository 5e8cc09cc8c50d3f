//! `sprung validate`: parameters against other logs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sprung::curves::Curves;
use sprung::finding::Severity;
use sprung::log::LogSource;
use sprung::progress::Progress;
use sprung::report::Contents;
use sprung::validate::{ValidateError, Validated, Validation, validate};

use super::identify::{code_of_pass, write_report};
use crate::args::Validate;
use crate::exit_code::{ExitCode, Failure};
use crate::experiment::{Files, Loaded, Parameters, load, openers, read_parameters, sources};
use crate::output::Output;
use crate::switch::finish;
use crate::terminal::{Terminal, show};

pub(crate) fn run(args: &Validate) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let loaded = load(&args.experiment, &common.overrides)?;
    let folder = loaded.out(common.out.as_ref());
    let file = match &args.parameters {
        Some(file) => file.clone(),
        None => identified(&folder, &loaded.out(None))?,
    };
    let parameters = read_parameters(&file)?;
    let found = from_disk(&loaded, &parameters, terminal)?;

    let mut output = Output::new(&folder)?
        .keeping(loaded.inputs())
        .keeping([file.clone()]);
    write_results(&mut output, &found)?;
    // The curves of the identification lie beside it, if it was kept whole.
    let beside = |name: &str| read_curves(&file.with_file_name(name));
    let (trace, fit) = match parameters.identification {
        Some(_) => (beside("trace.csv"), beside("fit.csv")),
        None => (None, None),
    };
    let contents = Contents {
        identification: parameters.identification.as_ref(),
        trace: trace.as_ref(),
        fit: fit.as_ref(),
        validation: Some((&found.validation, &found.curves)),
        truth: None,
        command: &super::command_line(),
        experiment: &loaded.text,
    };
    let report = write_report(&mut output, &contents)?;
    output.commit()?;

    terminal.json(&found.validation);
    terminal.validation(&found.validation);
    terminal.say(format!("\nreport: {}", report.display()));
    Ok(code_of(&found))
}

/// Returns the results of the last identification, in one of two folders.
fn identified(chosen: &Path, usual: &Path) -> Result<PathBuf, Failure> {
    for folder in [chosen, usual] {
        finish(folder)?;
    }
    [chosen, usual]
        .iter()
        .map(|folder| folder.join("identification.json"))
        .find(|file| file.exists())
        .ok_or_else(|| {
            Failure::new(
                ExitCode::File,
                format!(
                    "there is no identification.json in {}; run sprung identify first, or give \
                     --parameters FILE",
                    chosen.display()
                ),
            )
        })
}

/// Validates parameters on the logs that an experiment names.
pub(super) fn from_disk(
    loaded: &Loaded,
    parameters: &Parameters,
    terminal: Terminal,
) -> Result<Validated, Failure> {
    let paths = (loaded.experiment.validate.iter())
        .map(|run| loaded.log_paths(run.log.as_ref()))
        .collect::<Result<Vec<Vec<PathBuf>>, Failure>>()?;
    let delays: BTreeMap<String, f64> = (parameters.identification.iter())
        .flat_map(|identification| &identification.log.delay_s)
        .map(|(column, delay)| (column.clone(), delay.value))
        .collect();
    let mut openers: Vec<Vec<Files>> = (paths.iter())
        .map(|paths| openers(&loaded.folder, paths))
        .collect();
    let bar = terminal.progress("validating", None);
    let mut sources: Vec<Vec<LogSource<'_>>> = (paths.iter().zip(&mut openers))
        .map(|(paths, openers)| sources(paths, openers))
        .collect();
    let mut experiment = loaded.experiment.clone();
    if let (Some(log), Some(found)) = (&mut experiment.log, &parameters.identification) {
        log.settle(&found.log.signs(), &found.log.gains());
    }
    let found = validate(
        &experiment,
        &loaded.model,
        &parameters.sets,
        &delays,
        &mut sources,
        &mut |progress: Progress| show(&bar, progress),
    );
    bar.finish_and_clear();
    found.map_err(|error| {
        let code = match &error {
            ValidateError::Pass(pass) => code_of_pass(pass),
            _ => ExitCode::Usage,
        };
        Failure::new(code, error)
    })
}

/// The files of a validation but the report.
const RESULTS: [&str; 2] = ["validation.json", "signals.csv"];

/// The first column of the signals.
const LABELS: &str = "run/parameters";

/// Writes all files of a validation but the report.
pub(super) fn write_results(output: &mut Output, found: &Validated) -> Result<(), Failure> {
    output.write(RESULTS[0], |write| {
        serde_json::to_writer_pretty(&mut *write, &found.validation)?;
        writeln!(write)
    })?;
    output.text(RESULTS[1], &found.curves.to_csv(LABELS))?;
    Ok(())
}

/// Lets go of the files of an earlier validation; returns whether there are any.
pub(super) fn outdate(output: &mut Output, folder: &Path) -> bool {
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).ok();
    // Of files with these names only what such a validation wrote.
    let is_ours =
        text(RESULTS[0]).is_some_and(|text| serde_json::from_str::<Validation>(&text).is_ok());
    if !is_ours || !output.outdates(RESULTS[0]) {
        return false;
    }
    if text(RESULTS[1]).is_some_and(|text| text.starts_with(LABELS)) {
        output.outdates(RESULTS[1]);
    }
    true
}

fn read_curves(path: &Path) -> Option<Curves> {
    Curves::from_csv(&std::fs::read_to_string(path).ok()?).ok()
}

/// A first parameter set that cannot be simulated is of no use.
fn code_of(found: &Validated) -> ExitCode {
    let serious = found.validation.runs.iter().any(|run| {
        run.sets.first().is_some_and(|set| {
            set.findings
                .iter()
                .any(|finding| finding.severity == Severity::Serious)
        })
    });
    if serious {
        ExitCode::Unusable
    } else {
        ExitCode::Done
    }
}
