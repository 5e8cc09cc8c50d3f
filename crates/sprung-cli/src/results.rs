//! Writes and reads the files of results.

use std::path::{Path, PathBuf};

use serde::Serialize;
use sprung::curves::Curves;
use sprung::estimate::{Identification, Identified, parameters_csv};
use sprung::report::{Contents, Document, compose, render};
use sprung::session::{Disk, Files, IDENTIFICATION_FILE};
use sprung::validate::{Validated, Validation};

use crate::exit_code::Failure;
use crate::output::Output;

/// Names of the other files of an identification.
pub(crate) const PARAMETERS_FILE: &str = "parameters.csv";
const TRACE_FILE: &str = "trace.csv";
const FIT_FILE: &str = "fit.csv";

/// Names of the files of a validation, except the report.
const VALIDATION_FILE: &str = "validation.json";
const SIGNALS_FILE: &str = "signals.csv";

/// Name of the report of an identification, of a validation and of a comparison.
pub(crate) const REPORT_FILE: &str = "report.html";

/// Files that an identification writes.
pub(crate) const IDENTIFIED_FILES: [&str; 5] = [
    IDENTIFICATION_FILE,
    PARAMETERS_FILE,
    TRACE_FILE,
    FIT_FILE,
    REPORT_FILE,
];

/// Files that a validation writes.
pub(crate) const VALIDATED_FILES: [&str; 3] = [VALIDATION_FILE, SIGNALS_FILE, REPORT_FILE];

/// Heading of the first column of the signals.
const SIGNALS_LABEL: &str = "run/parameters";

/// Writes a value as JSON.
pub(crate) fn write_json(
    output: &mut Output<'_>,
    name: &str,
    value: &impl Serialize,
) -> Result<(), Failure> {
    output.write(name, |write| {
        serde_json::to_writer_pretty(&mut *write, value)?;
        writeln!(write)
    })?;
    Ok(())
}

/// Status in the files of a result that is still being refined. Other results have none.
const REFINING: &str = "refining";

/// Returns whether a result is that of least squares, written before its refinement.
pub(crate) fn is_refining(identification: &Identification) -> bool {
    let mut findings = identification.findings.iter();
    findings.any(|finding| finding.code == "refinement-pending")
}

/// Writes all files of an identification except the report.
pub(crate) fn write_identified(output: &mut Output<'_>, found: &Identified) -> Result<(), Failure> {
    let mut tables = [
        (PARAMETERS_FILE, parameters_csv(&found.identification)),
        (TRACE_FILE, found.trace.to_csv("estimator")),
        (FIT_FILE, found.fit.to_csv("source")),
    ];
    if is_refining(&found.identification) {
        let mut json = serde_json::to_value(&found.identification)
            .map_err(|error| Failure::file(error.to_string()))?;
        json["status"] = REFINING.into();
        write_json(output, IDENTIFICATION_FILE, &json)?;
        for (_, table) in &mut tables {
            let lines = (table.lines().enumerate()).map(|(k, line)| {
                let status = if k == 0 {
                    Curves::STATUS_COLUMN
                } else {
                    REFINING
                };
                format!("{line},{status}\n")
            });
            *table = lines.collect();
        }
    } else {
        write_json(output, IDENTIFICATION_FILE, &found.identification)?;
    }
    for (name, table) in tables {
        output.text(name, &table)?;
    }
    Ok(())
}

/// Writes all files of a validation except the report.
pub(crate) fn write_validated(output: &mut Output<'_>, found: &Validated) -> Result<(), Failure> {
    write_json(output, VALIDATION_FILE, &found.validation)?;
    output.text(SIGNALS_FILE, &found.curves.to_csv(SIGNALS_LABEL))?;
    Ok(())
}

/// Writes the report and returns its future path.
pub(crate) fn write_report(
    output: &mut Output<'_>,
    contents: &Contents<'_>,
) -> Result<PathBuf, Failure> {
    write_html(output, REPORT_FILE, &compose(contents))
}

/// Writes a document and returns its future path.
pub(crate) fn write_html(
    output: &mut Output<'_>,
    name: &str,
    document: &Document,
) -> Result<PathBuf, Failure> {
    let html = render(document)
        .map_err(|error| Failure::file(format!("cannot make the report: {error}")))?;
    output.text(name, &html)
}

/// Marks the files of an earlier validation for removal. Returns whether they exist.
pub(crate) fn outdate_validation(output: &mut Output<'_>) -> bool {
    let folder = output.folder().to_owned();
    let text = |name: &str| Disk.text(&folder.join(name)).ok();
    // A file with this name is removed only if a validation of sprung wrote it.
    let is_ours =
        text(VALIDATION_FILE).is_some_and(|text| serde_json::from_str::<Validation>(&text).is_ok());
    if !is_ours || !output.outdates(VALIDATION_FILE) {
        return false;
    }
    if text(SIGNALS_FILE).is_some_and(|text| text.starts_with(SIGNALS_LABEL)) {
        output.outdates(SIGNALS_FILE);
    }
    true
}

/// Returns the curves stored with an identification, trace and fit, if they exist.
pub(crate) fn curves_beside(identification: &Path) -> (Option<Curves>, Option<Curves>) {
    let read = |name: &str| {
        let text = Disk.text(&identification.with_file_name(name)).ok()?;
        Curves::from_csv(&text).ok()
    };
    (read(TRACE_FILE), read(FIT_FILE))
}
