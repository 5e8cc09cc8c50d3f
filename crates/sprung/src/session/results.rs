//! Reads identifications and validations from disk.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::earlier_formats::identification_from;
use super::error::SessionError;
use super::files::open_file;
use super::switch::finish;
use sprung_base::limits::{check_json, read_text_bytes};
use sprung_method::estimate::{IDENTIFICATION_FORMAT, Identification};
use sprung_method::validate::Validation;
use sprung_robot::{Feature, Task, refuse};

/// Folder of results beside `experiment.toml`; that of another file has a longer name.
pub(super) const RESULTS_FOLDER: &str = "sprung-out";

/// File name of an identification in a folder of results.
pub const IDENTIFICATION_FILE: &str = "identification.json";

/// File name of a validation in a folder of results.
const VALIDATION_FILE: &str = "validation.json";

/// The newest versions of `identification.json` and `validation.json` that sprung reads.
const NEWEST: u64 = IDENTIFICATION_FORMAT as u64;
const NEWEST_VALIDATION: u64 = 1;

/// An identification and its path.
#[derive(Clone, Debug)]
pub struct ReadIdentification {
    /// The file.
    pub path: PathBuf,
    /// The identification in it.
    pub identification: Identification,
}

/// A validation and its path.
#[derive(Clone, Debug)]
pub struct ReadValidation {
    /// The file.
    pub path: PathBuf,
    /// The validation in it.
    pub validation: Validation,
}

/// Returns the path of the last identification, in one of two folders of results.
///
/// # Errors
///
/// [`SessionError::NothingIdentified`] if neither folder contains an identification.
pub fn find_identification(chosen: &Path, usual: &Path) -> Result<PathBuf, SessionError> {
    for folder in [chosen, usual] {
        finish(folder)?;
    }
    [chosen, usual]
        .iter()
        .map(|folder| folder.join(IDENTIFICATION_FILE))
        .find(|file| file.exists())
        .ok_or_else(|| SessionError::NothingIdentified {
            folder: chosen.to_owned(),
        })
}

/// Reads an identification from `identification.json`, from a folder of results, or from the folder
/// of an experiment.
///
/// # Errors
///
/// [`SessionError`] if there is no identification or the file has other contents.
pub fn read_identification(path: &Path) -> Result<ReadIdentification, SessionError> {
    let path = found(path)?;
    let json = read_json(&path)?;
    identification(path, json)
}

/// Reads the identification and the validation that a path means: a file with one of them, a folder
/// of results, or the folder of an experiment.
///
/// # Errors
///
/// [`SessionError`] if there is neither, or a file has other contents.
pub fn read_results(
    path: &Path,
) -> Result<(Option<ReadIdentification>, Option<ReadValidation>), SessionError> {
    if path.is_dir() {
        let file = |name: &str| in_folder(path, name);
        let (identified, validated) = (file(IDENTIFICATION_FILE)?, file(VALIDATION_FILE)?);
        if identified.is_none() && validated.is_none() {
            return Err(SessionError::NoIdentification {
                folder: path.to_owned(),
            });
        }
        let identified = identified.map(|path| {
            let json = read_json(&path)?;
            identification(path, json)
        });
        let validated = validated.map(|path| {
            let json = read_json(&path)?;
            validation(path, json)
        });
        return Ok((identified.transpose()?, validated.transpose()?));
    }
    let json = read_json(path)?;
    if json.get("runs").is_some() {
        return Ok((None, Some(validation(path.to_owned(), json)?)));
    }
    Ok((Some(identification(path.to_owned(), json)?), None))
}

fn wrong(path: &Path, why: &str) -> SessionError {
    SessionError::NotAnIdentification {
        file: path.display().to_string(),
        why: why.to_owned(),
    }
}

/// Reads a file of JSON.
fn read_json(path: &Path) -> Result<Value, SessionError> {
    if let Some(folder) = path.parent() {
        finish(folder)?;
    }
    let bytes = open_file(path).and_then(read_text_bytes);
    let bytes = bytes.map_err(|source| SessionError::Unreadable {
        file: path.display().to_string(),
        source,
    })?;
    let Ok(text) = String::from_utf8(bytes) else {
        return Err(wrong(path, "it is not text; give an identification.json"));
    };
    check_json(&text).map_err(|why| wrong(path, &why))?;
    serde_json::from_str(&text).map_err(|error| wrong(path, &looks_like_text(path, &text, &error)))
}

/// Checks the version of a file of results.
///
/// - `known`: the newest version that sprung reads; it reads all before it.
fn check_format(path: &Path, json: &Value, known: u64) -> Result<(), SessionError> {
    match json.get("format").map(Value::as_u64) {
        Some(Some(format)) if (1..=known).contains(&format) => Ok(()),
        Some(Some(newer)) if newer > known => {
            let by = json.get("generator").and_then(Value::as_str);
            Err(SessionError::NewerFormat {
                file: path.display().to_string(),
                format: newer,
                generator: by.unwrap_or("another program").to_owned(),
                known,
            })
        }
        Some(_) => {
            let format = &json["format"];
            let why = format!("its format is {format}; this version reads format {known}");
            Err(wrong(path, &why))
        }
        None => Err(wrong(path, "it has no format; give an identification.json")),
    }
}

fn identification(path: PathBuf, json: Value) -> Result<ReadIdentification, SessionError> {
    if let (Some(joint), Some(_)) = (json["joint"].as_str(), json.get("braking")) {
        refuse(Feature::Servo, joint, Task::Compare)?;
    }
    if let Some(other) = looks_like_json(&json) {
        let why =
            format!("it looks like {other}; give the identification.json of a results folder");
        return Err(wrong(&path, &why));
    }
    check_format(&path, &json, NEWEST)?;
    let identification: Identification =
        identification_from(json).map_err(|error| wrong(&path, &error.to_string()))?;
    if identification.results.is_empty() {
        return Err(wrong(
            &path,
            "it holds no results; run sprung identify again",
        ));
    }
    Ok(ReadIdentification {
        path,
        identification,
    })
}

fn validation(path: PathBuf, json: Value) -> Result<ReadValidation, SessionError> {
    check_format(&path, &json, NEWEST_VALIDATION)?;
    let validation = serde_json::from_value(json).map_err(|error| {
        wrong(
            &path,
            &format!("it looks like a validation.json, but {error}; run sprung validate again"),
        )
    })?;
    Ok(ReadValidation { path, validation })
}

/// Returns the file in a folder of results, or in the only folder of results of the experiments in a folder, if it
/// exists.
fn in_folder(path: &Path, name: &str) -> Result<Option<PathBuf>, SessionError> {
    finish(path)?;
    let candidate = path.join(name);
    if candidate.exists() {
        return Ok(Some(candidate));
    }
    let mut files = Vec::new();
    for folder in results_of_experiments(path) {
        finish(&folder)?;
        files.push(folder.join(name));
    }
    files.retain(|file| file.exists());
    match &files[..] {
        [] | [_] => Ok(files.pop()),
        several => Err(SessionError::SeveralResults {
            folder: path.to_owned(),
            found: (several.iter().filter_map(|file| file.parent()))
                .map(|folder| folder.display().to_string())
                .collect(),
        }),
    }
}

/// Returns the folders of results in the folder of one or several experiments.
fn results_of_experiments(folder: &Path) -> Vec<PathBuf> {
    let of_results = |name: &std::ffi::OsStr| {
        (name
            .to_str()
            .and_then(|name| name.strip_prefix(RESULTS_FOLDER)))
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    };
    let mut folders: Vec<PathBuf> = (std::fs::read_dir(folder).into_iter().flatten())
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.is_dir() && path.file_name().is_some_and(of_results))
        .collect();
    folders.sort();
    folders
}

/// Returns the path of the identification that `path` means.
fn found(path: &Path) -> Result<PathBuf, SessionError> {
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    in_folder(path, IDENTIFICATION_FILE)?.ok_or_else(|| SessionError::NoIdentification {
        folder: path.to_owned(),
    })
}

/// Returns the likely kind of JSON that is not an identification; `None` if it may be an
/// identification.
fn looks_like_json(json: &Value) -> Option<&'static str> {
    let has = |key: &str| json.get(key).is_some();
    if !json.is_object() {
        Some("JSON of another program")
    } else if has("results") && has("log") {
        None
    } else if has("runs") {
        Some("a validation.json")
    } else if has("compared") {
        Some("a comparison.json")
    } else if has("$schema") || has("$defs") {
        Some("a JSON schema")
    } else {
        Some("JSON of another program")
    }
}

/// Returns the likely kind of a text that is not JSON, and the remedy.
fn looks_like_text(path: &Path, text: &str, error: &serde_json::Error) -> String {
    let ends = |extension: &str| path.extension().is_some_and(|ending| ending == extension);
    let line = |start: &str| {
        text.lines()
            .any(|line| line.trim_start().starts_with(start))
    };
    let first = text.lines().next().unwrap_or_default();
    if text.trim().is_empty() {
        "it is empty; run sprung identify again".to_owned()
    } else if ends("html") || first.starts_with("<!DOCTYPE") {
        "it looks like a report; give the identification.json beside it".to_owned()
    } else if line("[robot]") || line("[[robot.joint]]") {
        "it looks like an experiment file; give the identification.json in its results folder"
            .to_owned()
    } else if first.starts_with("estimator,name,") {
        "it looks like a parameters.csv; give the identification.json beside it".to_owned()
    } else if ends("csv") || first.split(',').count() > 2 && !first.starts_with('{') {
        "it looks like a log or a table in CSV; give the identification.json made from it"
            .to_owned()
    } else if ends("toml") {
        "it looks like a file of parameter values, which has no standard errors; give an \
         identification.json"
            .to_owned()
    } else {
        format!("{error}; if it was cut off, run sprung identify again")
    }
}
