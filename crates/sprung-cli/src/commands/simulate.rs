//! `sprung simulate`: a log of the digital twin.

use std::path::{Path, PathBuf};

use sprung::description::{Log, Simulate as Settings};
use sprung::log::Channels;
use sprung::model::Theta;
use sprung::progress::Progress;
use sprung::simulate::{RecordError, TwinSetup, record};

use crate::args::Simulate;
use crate::exit_code::{ExitCode, Failure};
use crate::experiment::{Loaded, load, read_parameters};
use crate::output::Output;
use crate::terminal::{Terminal, show};

pub(crate) fn run(args: &Simulate) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let loaded = load(&args.experiment, &common.overrides)?;
    let experiment = &loaded.experiment;
    let usage = |message: &str| Failure::new(ExitCode::Usage, message);
    let settings = experiment
        .simulate
        .as_ref()
        .ok_or_else(|| usage("the experiment has no [simulate] block; add one"))?;
    let (overlay, controller) = match &args.run {
        None => (None, experiment.controller.as_ref()),
        Some(name) => {
            let run =
                (experiment.validate.iter().find(|run| run.name == *name)).ok_or_else(|| {
                    let names: Vec<&str> = experiment
                        .validate
                        .iter()
                        .map(|run| run.name.as_str())
                        .collect();
                    usage(&format!(
                        "no [[validate]] block is called \"{name}\"; there are: {}",
                        names.join(", ")
                    ))
                })?;
            (
                run.log.as_ref(),
                run.controller.as_ref().or(experiment.controller.as_ref()),
            )
        }
    };
    let controller = controller
        .ok_or_else(|| usage("the experiment has no [controller]; a twin needs one to move"))?;
    let theta = parameters(&loaded, settings, args.parameters.as_deref())?;

    let mut output = Output::new(&loaded.out(common.out.as_ref()))?.keeping(loaded.inputs());
    let paths = loaded.log_paths(overlay)?;
    let name = (paths.first())
        .and_then(|path| path.file_name())
        .map_or_else(
            || PathBuf::from("simulated.csv"),
            |name| PathBuf::from(name).with_extension("csv"),
        );
    let twin = TwinSetup {
        model: &loaded.model,
        theta: &theta,
        controller,
        settings,
    };
    let path = write_log(&loaded, &twin, overlay, &mut output, &name, terminal)?;
    output.commit()?;
    terminal.json(&serde_json::json!({ "log": path }));
    terminal.say(format!("log: {}", path.display()));
    Ok(ExitCode::Done)
}

/// Writes a twin's log in the columns of the experiment, and returns where it
/// will be.
pub(super) fn write_log(
    loaded: &Loaded,
    twin: &TwinSetup<'_>,
    overlay: Option<&Log>,
    output: &mut Output,
    name: &Path,
    terminal: Terminal,
) -> Result<PathBuf, Failure> {
    let channels = Channels::new(&loaded.experiment.robot, &loaded.log(overlay)?)
        .map_err(|error| Failure::new(ExitCode::Usage, error))?;
    let total = (twin.settings.duration_s / twin.settings.period_s).round() as u64;
    let bar = terminal.progress("simulating", Some(total));
    let mut failure = None;
    let written = output.write(name, |write| {
        let mut progress = |progress: Progress| show(&bar, progress);
        match record(twin, &channels, &mut *write, &mut progress) {
            Ok(_) => Ok(()),
            Err(RecordError::Write(error)) => Err(error),
            Err(other) => {
                failure = Some(Failure::new(ExitCode::Usage, &other));
                Err(std::io::Error::other(other))
            }
        }
    });
    bar.finish_and_clear();
    match failure {
        Some(failure) => Err(failure),
        None => written,
    }
}

/// Returns the twin's true parameters: from `file`, from the experiment's
/// parameter file, or the nominal values.
pub(super) fn parameters(
    loaded: &Loaded,
    settings: &Settings,
    file: Option<&Path>,
) -> Result<Theta, Failure> {
    let given = settings
        .parameters
        .as_ref()
        .map(|file| loaded.folder.join(file));
    let theta = match file.map(Path::to_owned).or(given) {
        None => loaded.model.nominal(),
        Some(file) => match read_parameters(&file)?.sets.first() {
            Some(set) => loaded.model.theta(&set.values),
            None => loaded.model.nominal(),
        },
    };
    theta.map_err(|error| Failure::new(ExitCode::Usage, error))
}
