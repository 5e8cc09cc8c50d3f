//! `sprung demo`: the paper's experiment on a digital twin.

use std::collections::BTreeMap;
use std::path::Path;

use sprung::demo;
use sprung::report::Contents;
use sprung::simulate::TwinSetup;
use sprung::validate::ParameterSet;

use super::simulate::{parameters, write_log};
use super::{identify, validate};
use crate::args::Demo;
use crate::exit_code::{ExitCode, Failure};
use crate::experiment::{Parameters, load};
use crate::output::Output;
use crate::terminal::Terminal;

pub(crate) fn run(args: &Demo) -> Result<ExitCode, Failure> {
    let terminal = Terminal::new(args.voice, false);
    let text = with_seed(args.seed);
    let present = std::fs::read_to_string(args.out.join("experiment.toml")).ok();
    if present.is_some_and(|present| without_seed(&present) != without_seed(&text)) {
        return Err(Failure::new(
            ExitCode::Usage,
            format!(
                "{} holds another experiment.toml, which would be overwritten; choose a folder with \
                 --out",
                args.out.display()
            ),
        ));
    }
    let mut output = Output::new(&args.out)?;
    let file = output.text("experiment.toml", &text)?;
    output.text("truth.toml", demo::TRUTH)?;
    output.commit()?;

    let loaded = load(&file, &[])?;
    let experiment = &loaded.experiment;
    let incomplete = || Failure::new(ExitCode::Usage, "the experiment of the demo is incomplete");
    let settings = experiment.simulate.as_ref().ok_or_else(incomplete)?;
    let prediction = experiment.validate.last().ok_or_else(incomplete)?;
    let theta = parameters(&loaded, settings, None)?;
    let mut second = settings.clone();
    second.seed = settings.seed.wrapping_add(1);
    let mut output = Output::new(&args.out)?;
    for (name, controller, settings) in [
        (
            "identification.csv",
            experiment.controller.as_ref(),
            settings,
        ),
        ("validation.csv", prediction.controller.as_ref(), &second),
    ] {
        let twin = TwinSetup {
            model: &loaded.model,
            theta: &theta,
            controller: controller.ok_or_else(incomplete)?,
            settings,
        };
        write_log(&loaded, &twin, None, &mut output, Path::new(name), terminal)?;
    }
    output.commit()?;

    let found = identify::from_disk(&loaded, terminal)?;
    let identified = Parameters {
        sets: ParameterSet::of(&found.identification),
        identification: Some(found.identification.clone()),
    };
    let validated = validate::from_disk(&loaded, &identified, terminal)?;

    let truth: BTreeMap<String, f64> = (loaded.model.parameters().iter())
        .zip(theta)
        .map(|(parameter, value)| (parameter.name.clone(), value))
        .collect();
    let mut output = Output::new(&loaded.out(None))?;
    identify::write_results(&mut output, &found)?;
    validate::write_results(&mut output, &validated)?;
    let contents = Contents {
        identification: Some(&found.identification),
        trace: Some(&found.trace),
        fit: Some(&found.fit),
        validation: Some((&validated.validation, &validated.curves)),
        truth: Some(&truth),
        command: &super::command_line(),
        experiment: &loaded.text,
    };
    let report = identify::write_report(&mut output, &contents)?;
    output.commit()?;

    terminal.parameters(&found.identification, Some(&truth));
    terminal.validation(&validated.validation);
    terminal.say(format!(
        "\nexperiment: {}\nreport: {}",
        file.display(),
        report.display()
    ));
    Ok(ExitCode::Done)
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

/// Returns the lines of an experiment but that of the seed.
fn without_seed(text: &str) -> Vec<&str> {
    text.lines()
        .filter(|line| !line.starts_with("seed "))
        .collect()
}
