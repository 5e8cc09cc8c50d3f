//! Experiments and parameter files on disk.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use sprung::description::{self, DescriptionError, Experiment, Log};
use sprung::estimate::Identification;
use sprung::log::{Input, LogFile, LogSource, Opener};
use sprung::model::Model;
use sprung::validate::ParameterSet;

use crate::exit_code::{ExitCode, Failure};
use crate::switch::finish_beside;

/// An experiment that was read from disk.
pub(crate) struct Loaded {
    pub(crate) experiment: Experiment,
    pub(crate) model: Model,
    /// The folder that paths in the file are relative to.
    pub(crate) folder: PathBuf,
    pub(crate) text: String,
    file: PathBuf,
}

/// What logs are called.
const LOGS: [&str; 10] = [
    "csv", "gz", "zst", "parquet", "arrow", "npy", "npz", "mat", "mcap", "db3",
];

/// Reads an experiment file, or `experiment.toml` of a folder.
pub(crate) fn load(path: &Path, overrides: &[String]) -> Result<Loaded, Failure> {
    let file = if path.is_dir() {
        path.join("experiment.toml")
    } else {
        path.to_owned()
    };
    let name = file.display().to_string();
    let is_log = |extension: &std::ffi::OsStr| LOGS.iter().any(|known| extension == *known);
    if file.extension().is_some_and(is_log) {
        return Err(Failure::new(
            ExitCode::Usage,
            format!("{name} is a log; give the experiment file that names it, or its folder"),
        ));
    }
    let text = read_text(&file)?;
    let folder = file.parent().map_or_else(PathBuf::new, Path::to_owned);
    let mut open = |path: &Path| std::fs::read_to_string(folder.join(path));
    let experiment = description::read(&name, &text, overrides, &mut open).map_err(|error| {
        let code = match error {
            DescriptionError::Unreadable { .. } => ExitCode::File,
            _ => ExitCode::Usage,
        };
        Failure::new(code, error)
    })?;
    let model = Model::new(&experiment)
        .map_err(|error| Failure::new(ExitCode::Usage, format!("{name}: {error}")))?;
    Ok(Loaded {
        experiment,
        model,
        folder,
        text,
        file,
    })
}

impl Loaded {
    /// Returns the folder for results.
    pub(crate) fn out(&self, chosen: Option<&PathBuf>) -> PathBuf {
        chosen.map_or_else(|| self.folder.join("sprung-out"), Clone::clone)
    }

    /// Returns all files that the experiment names, and itself.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        let experiment = &self.experiment;
        let logs = (experiment.validate.iter())
            .filter_map(|run| run.log.as_ref())
            .chain(&experiment.log)
            .flat_map(Log::files);
        let robot = experiment.robot.urdf.iter();
        let twin = experiment
            .simulate
            .iter()
            .filter_map(|twin| twin.parameters.as_ref());
        (logs
            .chain(robot)
            .chain(twin)
            .map(|file| self.folder.join(file)))
        .chain([self.file.clone()])
        .collect()
    }

    /// Returns the log of the experiment, or of one of its validation runs.
    pub(crate) fn log(&self, overlay: Option<&Log>) -> Result<Log, Failure> {
        let log = self.experiment.log.as_ref().ok_or_else(|| {
            Failure::new(
                ExitCode::Usage,
                "the experiment has no [log]; say which columns hold what",
            )
        })?;
        Ok(overlay.map_or_else(|| log.clone(), |over| log.overlaid(over)))
    }

    /// Returns where the files of a log are.
    pub(crate) fn log_paths(&self, overlay: Option<&Log>) -> Result<Vec<PathBuf>, Failure> {
        let files = self.log(overlay)?.file.ok_or_else(|| {
            Failure::new(
                ExitCode::Usage,
                "the experiment does not say which log to read; give file in [log], or --set \
                 log.file=FILE",
            )
        })?;
        Ok(files.iter().map(|file| self.folder.join(file)).collect())
    }
}

/// A function that opens the files of a log as often as it is called.
pub(crate) type Files = Box<Opener<'static>>;

/// Returns functions that open logs, and other files in a folder.
pub(crate) fn openers(folder: &Path, paths: &[PathBuf]) -> Vec<Files> {
    let opener = |own: &PathBuf| {
        let (own, folder) = (own.clone(), folder.to_owned());
        let opener = move |other: Option<&Path>| match other {
            None => open(&own),
            Some(other) => open(&folder.join(other)),
        };
        Box::new(opener) as Files
    };
    paths.iter().map(opener).collect()
}

/// Returns logs that can be read any number of times.
pub(crate) fn sources<'a>(paths: &[PathBuf], openers: &'a mut [Files]) -> Vec<LogSource<'a>> {
    (paths.iter().zip(openers))
        .map(|(path, reader)| LogSource {
            name: path.display().to_string(),
            reader: &mut **reader,
        })
        .collect()
}

/// Opens a log for reading; a folder is a bag of ROS 2.
fn open(path: &Path) -> std::io::Result<Box<dyn Input>> {
    if path.is_dir() {
        return Ok(Box::new(File::open(of_bag(path)?)?));
    }
    Ok(Box::new(LogFile::new(File::open(path)?, path)))
}

/// Returns the one file of messages in a folder.
fn of_bag(folder: &Path) -> std::io::Result<PathBuf> {
    let entries = std::fs::read_dir(folder)?;
    let mut files: Vec<PathBuf> = (entries.filter_map(Result::ok))
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "mcap" || e == "db3"))
        .collect();
    files.sort();
    let what = match &files[..] {
        [one] => return Ok(one.clone()),
        [] => "it is a folder without .mcap or .db3 file".to_owned(),
        [first, ..] => format!(
            "it is a folder with {} bags; name them one by one, as file = [\"{}\", …]",
            files.len(),
            first.display()
        ),
    };
    Err(std::io::Error::new(std::io::ErrorKind::IsADirectory, what))
}

/// A parameter file.
pub(crate) struct Parameters {
    pub(crate) sets: Vec<ParameterSet>,
    pub(crate) identification: Option<Identification>,
}

/// Reads `identification.json`, or a TOML table of values by name.
pub(crate) fn read_parameters(path: &Path) -> Result<Parameters, Failure> {
    finish_beside(path)?;
    let text = read_text(path)?;
    let name = path.display();
    let wrong = |error: &dyn std::fmt::Display| {
        Failure::new(
            ExitCode::Usage,
            format!("{name} is not a file of parameters: {error}"),
        )
    };
    if path
        .extension()
        .is_some_and(|extension| extension == "json")
    {
        let identification: Identification =
            serde_json::from_str(&text).map_err(|error| wrong(&error))?;
        if identification.format != 1 {
            return Err(wrong(&format!(
                "format {} is not known; this version reads format 1",
                identification.format
            )));
        }
        if identification.results.is_empty() {
            return Err(wrong(&"it holds no results"));
        }
        return Ok(Parameters {
            sets: ParameterSet::of(&identification),
            identification: Some(identification),
        });
    }
    let values: BTreeMap<String, f64> =
        toml::from_str(&text).map_err(|error| wrong(&error.message()))?;
    let label = path
        .file_stem()
        .map_or_else(|| "given".to_owned(), |stem| stem.display().to_string());
    Ok(Parameters {
        sets: vec![ParameterSet { label, values }],
        identification: None,
    })
}

/// Reads a text file.
pub(crate) fn read_text(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|error| {
        Failure::new(
            ExitCode::File,
            format!("cannot read {}: {error}", path.display()),
        )
    })
}
