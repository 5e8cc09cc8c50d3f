//! `sprung demo`: runs the paper's experiment on a digital twin.

use std::collections::BTreeMap;

use sprung::demo;
use sprung::estimate::Identification;
use sprung::model::short;
use sprung::report::Contents;
use sprung::session::{Disk, EXPERIMENT_FILE, Files, Parameters, Session};

use crate::args::Demo;
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::record::write_log;
use crate::results::{
    IDENTIFIED_FILES, VALIDATED_FILES, write_identified, write_report, write_validated,
};
use crate::terminal::Terminal;

pub(crate) fn run(args: &Demo) -> Result<ExitCode, Failure> {
    let terminal = Terminal::new(args.voice, false);
    let text = with_seed(args.seed);
    let present = Disk.text(&args.out.join(EXPERIMENT_FILE)).ok();
    if present.is_some_and(|present| without_seed(&present) != without_seed(&text)) {
        return Err(Failure::usage(format!(
            "{} holds another experiment.toml, which would be overwritten; choose a folder with \
                 --out",
            args.out.display()
        )));
    }
    let folder = Folder::new(&args.out, [], &[EXPERIMENT_FILE])?;
    let mut output = folder.output()?;
    let file = output.text(EXPERIMENT_FILE, &text)?;
    output.text("truth.toml", demo::TRUTH)?;
    output.commit()?;

    let session = Session::open(&file, &[])?;
    let names = [&IDENTIFIED_FILES[..], &VALIDATED_FILES].concat();
    let results = Folder::new(&session.results_folder(), session.inputs(), &names)?;
    let prediction = session.experiment().validate.last();
    let identified = session.twin(None, None)?;
    let predicted = session.twin(prediction.map(|run| run.name.as_str()), None)?;
    let seed = identified.seed().wrapping_add(1);
    let mut output = folder.output()?;
    for twin in [&identified, &predicted.with_seed(seed)] {
        write_log(twin.name(), &mut output, terminal, |write, progress| {
            twin.write(write, progress)
        })?;
    }
    output.commit()?;

    let found = terminal.follow("identifying", |progress| session.identify(progress))?;
    let parameters = Parameters::from(found.identification.clone());
    let validated = terminal.follow("validating", |progress| {
        session.validate(&parameters, progress)
    })?;

    let truth = identified.truth();
    let mut output = results.output()?;
    write_identified(&mut output, &found)?;
    write_validated(&mut output, &validated)?;
    let contents = Contents {
        identification: Some(&found.identification),
        trace: Some(&found.trace),
        fit: Some(&found.fit),
        validation: Some((&validated.validation, &validated.curves)),
        truth: Some(&truth),
        command: &command_line(),
        experiment: session.text(),
    };
    let report = write_report(&mut output, &contents)?;
    output.commit()?;

    terminal.parameters(&found.identification, Some(&truth));
    terminal.validation(&validated.validation);
    if let Some(sentence) = against_truth(&found.identification, &truth) {
        terminal.say(format!("\n{sentence}"));
    }
    terminal.say(format!(
        "experiment: {}\nreport: {}",
        file.display(),
        report.display()
    ));
    terminal.say(validated.validation.sentence());
    terminal.decision(&found.identification);
    Ok(ExitCode::Done)
}

/// Returns the distance of the first result from the true parameters.
fn against_truth(identification: &Identification, truth: &BTreeMap<String, f64>) -> Option<String> {
    let result = identification.results.first()?;
    let all = result.parameters.len();
    let errors: Vec<(&str, f64)> = (result.parameters.iter())
        .filter(|parameter| parameter.identifiable)
        .filter_map(|parameter| {
            let truth = truth.get(&parameter.name).filter(|truth| **truth != 0.0)?;
            Some((&*parameter.name, parameter.value? / truth - 1.0))
        })
        .collect();
    let (name, largest) = (errors.iter()).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    Some(format!(
        "{} found {} of {all} parameters; the largest error is {:+.1} % ({}).",
        result.estimator,
        errors.len(),
        100.0 * largest,
        short(name)
    ))
}

/// Returns the experiment with another seed.
fn with_seed(seed: u64) -> String {
    let lines = demo::EXPERIMENT.lines().map(|line| {
        if line.starts_with("seed ") {
            format!("seed       = {seed}\n")
        } else {
            format!("{line}\n")
        }
    });
    lines.collect()
}

/// Returns the lines of an experiment file without the line of the seed.
fn without_seed(text: &str) -> Vec<&str> {
    text.lines()
        .filter(|line| !line.starts_with("seed "))
        .collect()
}
