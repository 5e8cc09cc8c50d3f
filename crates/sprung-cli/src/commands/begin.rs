//! Begins an experiment from a robot and its logs, for `sprung new` and `sprung identify --urdf --log`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use sprung::finding::{Finding, Severity};
use sprung::session::{
    Disk, EXPERIMENT_FILE, Files, NewExperiment, Parameters, Session, SessionError,
    find_identification, start_from_logs, start_from_urdf,
};

use crate::args::{Common, Identify};
use crate::command_line::quoted;
use crate::exit_code::Failure;
use crate::output::{Folder, results_folder};
use crate::results::is_refining;
use crate::terminal::Terminal;

/// Number of joints without `--joints`.
const DEFAULT_JOINTS: usize = 2;

/// Begins the name of the folder of an experiment that `identify` writes; the name of the log follows.
const FOLDER_PREFIX: &str = "sprung-";

/// Returns the experiment of a robot and its logs; without logs one to fill in.
///
/// - `folder`: future folder of the experiment.
pub(super) fn begun(
    terminal: Terminal,
    urdf: Option<&Path>,
    joints: Option<usize>,
    (logs, topics): (&[PathBuf], Option<&str>),
    folder: &Path,
) -> Result<NewExperiment, Failure> {
    let start = if let Some(file) = urdf {
        start_from_urdf(file, folder)?
    } else {
        start_from_logs(logs, joints, DEFAULT_JOINTS)?
    };
    if logs.is_empty() {
        return Ok(NewExperiment::without_log(&start));
    }
    let new = terminal.follow("reading the log", |progress| {
        NewExperiment::from_logs(&start, (logs, topics), folder, progress)
    })?;
    Ok(new)
}

/// Prints the choices by the log.
pub(super) fn say_choice(terminal: Terminal, new: &NewExperiment) {
    if new.lines.is_empty() {
        for sentence in &new.about_joints {
            terminal.say(format!("  {sentence}"));
        }
        return;
    }
    let left_out = match new.left_out {
        0 => String::new(),
        count => format!(" ({count} more are not in the log)"),
    };
    terminal.say(format!("joints: {}{left_out}", new.joints.join(", ")));
    for sentence in &new.about_joints {
        terminal.say(format!("  {sentence}"));
    }
    for sentence in &new.corrected {
        terminal.say(format!("  corrected: {sentence}"));
    }
    for line in &new.lines {
        terminal.say(format!("  {line}"));
    }
}

/// Returns an error if a file is given in place of a folder.
pub(super) fn refuse_file(folder: &Path) -> Result<(), Failure> {
    let toml = (folder.extension()).is_some_and(|extension| extension == "toml");
    if folder.is_file() || (toml && !folder.is_dir()) {
        return Err(Failure::usage(format!(
            "{} is a file; give the folder for experiment.toml",
            folder.display()
        )));
    }
    Ok(())
}

/// Returns the experiment file that `identify` reads: the given one, or that of `--urdf` and `--log`, which it writes
/// before.
pub(super) fn experiment_of(args: &Identify, terminal: Terminal) -> Result<PathBuf, Failure> {
    let wrong = |message: String| Err(Failure::usage(message));
    match (&args.experiment, &args.urdf, args.log.first()) {
        (Some(experiment), None, None) => Ok(experiment.clone()),
        (Some(experiment), Some(_), _) => wrong(format!(
            "give either {} or --urdf and --log: an experiment names its robot and its log itself",
            experiment.display()
        )),
        (Some(experiment), None, Some(log)) => wrong(format!(
            "{} names its log itself; for another log with the same columns give --set log.file={} in place of \
             --log",
            experiment.display(),
            // A relative path would begin at the folder of the experiment.
            quoted(
                &std::path::absolute(log)
                    .unwrap_or_else(|_| log.clone())
                    .to_string_lossy()
            )
        )),
        (None, Some(urdf), Some(log)) => written(args, urdf, log, terminal),
        (None, Some(urdf), None) => wrong(format!(
            "--urdf needs a log of the robot: add --log FILE; without a log, sprung new DIR --urdf {} writes an \
             experiment to fill in",
            quoted(&urdf.to_string_lossy())
        )),
        (None, None, log) => wrong(format!(
            "--log needs the robot: add --urdf FILE; for a robot without URDF, sprung new DIR --log {} writes an \
             experiment to fill in",
            log.map_or_else(|| "FILE".into(), |log| quoted(&log.to_string_lossy()))
        )),
    }
}

/// Writes the experiment of a robot and its logs, if no line is to be filled in. Returns its path.
fn written(
    args: &Identify,
    urdf: &Path,
    log: &Path,
    terminal: Terminal,
) -> Result<PathBuf, Failure> {
    let folder = (args.common.out.clone()).unwrap_or_else(|| folder_of(log));
    refuse_file(&folder)?;
    let inputs = args.log.iter().cloned().chain([urdf.to_owned()]);
    let place = Folder::new(&folder, inputs, &[EXPERIMENT_FILE])?;
    let new = begun(
        terminal,
        Some(urdf),
        None,
        (&args.log, args.topics.as_deref()),
        &folder,
    )?;
    let file = folder.join(EXPERIMENT_FILE);
    // A link without target also counts as an existing file.
    let exists = file.symlink_metadata().is_ok();
    let is_same = Disk.text(&file).is_ok_and(|text| text == new.text);
    if exists && !is_same && !args.force {
        let folder = quoted(&folder.to_string_lossy());
        return Err(Failure::usage(format!(
            "{} exists already and is not what this robot and log give; sprung identify {folder} identifies with \
                 it, --out DIR chooses another folder, and --force replaces it",
            file.display()
        )));
    }
    refuse_incomplete(args, urdf, &folder, &new)?;
    if !is_same {
        let mut output = place.output()?;
        output.text(EXPERIMENT_FILE, &new.text)?;
        output.commit()?;
    }
    terminal.say(format!(
        "experiment: {}; from now on sprung check, identify, validate and export take the folder {}",
        file.display(),
        quoted(&folder.to_string_lossy())
    ));
    say_choice(terminal, &new);
    terminal.say("");
    Ok(file)
}

/// Returns the folder of the experiment of a log, in the working folder.
fn folder_of(log: &Path) -> PathBuf {
    let mut name = OsString::from(FOLDER_PREFIX);
    let stem = if log.is_dir() {
        log.file_name()
    } else {
        log.file_stem()
    };
    name.push(stem.unwrap_or("log".as_ref()));
    PathBuf::from(name)
}

/// Returns an error if the user must fill in a line, or if the log contradicts the choice.
fn refuse_incomplete(
    args: &Identify,
    urdf: &Path,
    folder: &Path,
    new: &NewExperiment,
) -> Result<(), Failure> {
    if new.open.is_empty() && !new.is_refused() {
        return Ok(());
    }
    let logs: Vec<String> = (args.log.iter())
        .map(|log| log.display().to_string())
        .collect();
    let logs = logs.join(", ");
    let options: Vec<String> = (args.log.iter())
        .map(|log| format!("--log {}", quoted(&log.to_string_lossy())))
        .collect();
    let command = format!(
        "sprung new {} --urdf {} {}",
        quoted(&folder.to_string_lossy()),
        quoted(&urdf.to_string_lossy()),
        options.join(" ")
    );
    if !new.open.is_empty() {
        let lines: Vec<String> = (new.open.iter())
            .map(|(line, key)| format!("line {line} ({key})"))
            .collect();
        return Err(Failure::log(format!(
            "{} and {logs} do not tell everything; {command} writes the experiment file: fill in {}, whose comments \
                 say what is missing",
            urdf.display(),
            lines.join(", ")
        )));
    }
    let errors = new
        .findings
        .iter()
        .filter(|finding| finding.severity == Severity::Error);
    let errors: Vec<Finding> = errors.cloned().collect();
    let why = match &new.unchecked {
        Some(why) => why.clone(),
        None => (errors.iter().map(|finding| finding.text.as_str()))
            .collect::<Vec<_>>()
            .join(" "),
    };
    let message = format!(
        "{logs} contradicts what its names and values say: {why}; {command} writes the experiment file for you to correct"
    );
    Err(Failure::log(message).with_findings(errors))
}

/// What a command on identified parameters begins with.
pub(super) struct Opened {
    pub(super) session: Session,
    pub(super) terminal: Terminal,
    /// Folder for results.
    pub(super) path: PathBuf,
    /// File of the parameters.
    pub(super) file: PathBuf,
    pub(super) parameters: Parameters,
}

impl Opened {
    /// Opens an experiment and its identified parameters. Values that are still being refined are an error unless the user
    /// accepts them.
    ///
    /// - `given`: file of the parameters; `None` for the identification in the results folder.
    /// - `allow`: refuses a task that does not work with the experiment, before its parameters are read.
    pub(super) fn new(
        experiment: &Path,
        common: &Common,
        (given, accept_refining): (Option<&Path>, bool),
        allow: impl FnOnce(&Session) -> Result<(), SessionError>,
    ) -> Result<Self, Failure> {
        let terminal = Terminal::new(common.voice, common.json);
        let session = Session::open(experiment, &common.overrides)?;
        allow(&session)?;
        let path = results_folder(&session, common);
        let file = match given {
            Some(file) => file.to_owned(),
            None => find_identification(&path, &session.results_folder())?,
        };
        let parameters = Parameters::open(&file)?;
        let found = parameters.identification.as_ref();
        if found.is_some_and(is_refining) && !accept_refining {
            return Err(Failure::usage(format!(
                "{} has the values of least squares before their refinement, which has not ended or was stopped; let \
                 sprung identify end, or take them with --accept-refining",
                file.display()
            )));
        }
        Ok(Self {
            session,
            terminal,
            path,
            file,
            parameters,
        })
    }

    /// Returns the files of the experiment and of the parameters.
    pub(super) fn inputs(&self) -> impl Iterator<Item = PathBuf> {
        let inputs = self.session.inputs().into_iter();
        inputs.chain([self.file.clone()])
    }
}
