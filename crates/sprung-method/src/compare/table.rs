//! Makes the table of a comparison from identifications.

use super::agreement::runs_disagree;
use super::combined::combined;
use super::drift::{drift_findings, drifts};
use super::labels::labels;
use super::promises::{ComparedPromise, promises, sentence};
use super::result::{ComparedParameter, ComparedResult, ComparedValue, Comparison};
use crate::estimate::{EstimateResult, GENERATOR, Identification, ParameterEstimate};
use crate::finding::{Finding, Severity};
use crate::model::short;
use crate::validate::Validation;

/// One file with the results of an identification.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// Identification in the file.
    pub identification: &'a Identification,
}

/// One file with the results of a validation.
#[derive(Clone, Copy, Debug)]
pub struct ComparedValidation<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// Validation in the file.
    pub validation: &'a Validation,
}

/// Errors of a comparison.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// There are fewer than two results.
    #[error("{found} in {}; give another file to compare it with", files.join(", "))]
    TooFew {
        /// The number of results, in words.
        found: String,
        /// The files.
        files: Vec<String>,
    },
    /// Two files are of different robots.
    #[error(
        "{file} is of the robot \"{robot}\", but {other_file} is of the robot \"{other_robot}\"; compare results of one \
         robot, or give the robot one name in both experiment files and identify again"
    )]
    DifferentRobots {
        /// The first file.
        file: String,
        /// Its robot.
        robot: String,
        /// The first file of another robot.
        other_file: String,
        /// The other robot.
        other_robot: String,
    },
    /// A file has no parameter in common with any other file.
    #[error(
        "{file} has no parameter in common with {other}; compare results whose joints have the same names"
    )]
    NothingInCommon {
        /// The file, its robot and its first parameters.
        file: String,
        /// The same of the first other file.
        other: String,
    },
}

/// Compares the results of several files of one robot; differences refer to the first result of the first
/// file. If the logs of all files have dates, the files are put into their order.
///
/// - `files`: identifications, with at least two results in total unless there are validations.
/// - `validations`: their promises are compared, not their parameters.
///
/// # Errors
///
/// [`CompareError`] if there are fewer than two results and no validation, if two files are of different
/// robots, or if a file has no parameter (name and unit) in common with any other file.
pub fn compare(
    files: &[Compared<'_>],
    validations: &[ComparedValidation<'_>],
) -> Result<Comparison, CompareError> {
    let files = &by_date(files)[..];
    let results: Vec<(&Compared<'_>, &EstimateResult)> = (files.iter())
        .flat_map(|file| file.identification.results.iter().map(move |r| (file, r)))
        .collect();
    if results.len() < 2 && validations.is_empty() {
        return Err(CompareError::TooFew {
            found: match results.len() {
                0 => "there is no result".to_owned(),
                _ => "there is only one result".to_owned(),
            },
            files: files.iter().map(|file| file.file.to_owned()).collect(),
        });
    }
    check_robots(files, validations)?;
    check_common(files)?;
    let names: Vec<(&str, &str)> = (results.iter())
        .map(|(file, result)| (file.file, result.estimator.as_str()))
        .collect();
    let compared: Vec<ComparedResult> = (results.iter().zip(labels(&names)))
        .map(|((file, result), label)| describe(file, result, label))
        .collect();
    let parameters = parameters(&results);
    let of_identifications: Vec<_> = (results.iter())
        .map(|(file, result)| (file.identification, *result))
        .collect();
    let combined = combined(&compared, &of_identifications);
    let drift = drifts(&compared, &of_identifications, &parameters);
    let mut findings = Vec::from_iter(missing(&compared, &parameters));
    findings.extend(different_laws(&compared));
    findings.extend(drift_findings(&drift));
    let (tested, disagreements) = runs_disagree(&compared, &parameters);
    findings.extend(disagreements);
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let promises: Vec<ComparedPromise> = (validations.iter())
        .flat_map(|one| promises(one.file, one.validation))
        .collect();
    Ok(Comparison {
        promises_kept: sentence(&promises),
        promises,
        format: 1,
        generator: GENERATOR.to_owned(),
        compared,
        parameters,
        combined,
        drift,
        tested,
        findings,
    })
}

fn all<'a>(file: &Compared<'a>) -> impl Iterator<Item = &'a ParameterEstimate> {
    let results = file.identification.results.iter();
    results.flat_map(|result| &result.parameters)
}

/// Returns the files in the order of the dates of their logs, or unchanged if a log has no date.
fn by_date<'a>(files: &[Compared<'a>]) -> Vec<Compared<'a>> {
    let dated = files
        .iter()
        .map(|file| Some((file.identification.date_s()?, *file)));
    let Some(mut dated) = dated.collect::<Option<Vec<_>>>() else {
        return files.to_vec();
    };
    dated.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    dated.into_iter().map(|(_, file)| file).collect()
}

fn check_robots(
    files: &[Compared<'_>],
    validations: &[ComparedValidation<'_>],
) -> Result<(), CompareError> {
    let identified = (files.iter()).map(|one| (one.file, one.identification.robot.as_str()));
    let validated = (validations.iter()).map(|one| (one.file, one.validation.robot.as_str()));
    let mut all = identified.chain(validated);
    let Some((file, robot)) = all.next() else {
        return Ok(());
    };
    match all.find(|(_, other)| *other != robot) {
        None => Ok(()),
        Some((other_file, other_robot)) => Err(CompareError::DifferentRobots {
            file: file.to_owned(),
            robot: robot.to_owned(),
            other_file: other_file.to_owned(),
            other_robot: other_robot.to_owned(),
        }),
    }
}

fn check_common(files: &[Compared<'_>]) -> Result<(), CompareError> {
    let common = |a: &Compared<'_>, b: &Compared<'_>| {
        all(a).any(|p| all(b).any(|q| q.name == p.name && q.unit == p.unit))
    };
    let described = |file: &Compared<'_>| {
        let names: Vec<_> = all(file).take(3).map(|p| short(&p.name)).collect();
        format!(
            "{} (robot \"{}\", parameters {}, …)",
            file.file,
            file.identification.robot,
            names.join(", ")
        )
    };
    for (i, file) in files.iter().enumerate() {
        let mut others = (files.iter().enumerate()).filter(|(j, _)| *j != i);
        if files.len() == 1 || others.clone().any(|(_, other)| common(file, other)) {
            continue;
        }
        if let Some((_, other)) = others.next() {
            return Err(CompareError::NothingInCommon {
                file: described(file),
                other: described(other),
            });
        }
    }
    Ok(())
}

fn describe(file: &Compared<'_>, result: &EstimateResult, label: String) -> ComparedResult {
    let identification = file.identification;
    let findings = identification.findings.iter().chain(&result.warnings);
    let mut codes: Vec<String> = findings
        .filter(|finding| finding.severity != Severity::Info)
        .map(|finding| finding.code.clone())
        .collect();
    codes.sort_unstable();
    codes.dedup();
    ComparedResult {
        label,
        file: file.file.to_owned(),
        robot: identification.robot.clone(),
        log: identification.files(),
        date_s: identification.date_s(),
        samples: identification.logs().map(|log| log.samples).sum(),
        duration_s: identification.logs().map(|log| log.duration_s).sum(),
        generator: identification.generator.clone(),
        settings: identification.settings.clone(),
        laws: laws(identification),
        estimator: result.estimator.clone(),
        verdict: result.verdict,
        condition_number_scaled: result.condition_number_scaled,
        residual_rms: result.residual_rms.clone(),
        relative_residual: result.relative_residual.clone(),
        findings: codes,
        elapsed_s: result.elapsed_s,
    }
}

/// Returns the laws that an identification added.
fn laws(identification: &Identification) -> Vec<String> {
    let used = identification.unknowns.iter();
    let mut laws: Vec<String> = used
        .filter_map(|unknown| {
            Some(format!(
                "{}: {}",
                unknown.place,
                unknown.used_law()?.words()
            ))
        })
        .collect();
    laws.sort_unstable();
    laws
}

/// Reports that the results have different models, with the way to one model.
fn different_laws(compared: &[ComparedResult]) -> Option<Finding> {
    let first = compared.first()?;
    if compared.iter().all(|result| result.laws == first.laws) {
        return None;
    }
    let mut union: Vec<&str> = (compared.iter())
        .flat_map(|result| result.laws.iter().map(String::as_str))
        .collect();
    union.sort_unstable();
    union.dedup();
    let mut files: Vec<String> = (compared.iter())
        .map(|result| format!("--laws-from {}", result.file))
        .collect();
    files.dedup();
    Some(Finding::new(
        Severity::Warning,
        "laws-differ",
        format!(
            "the logs asked for different laws beyond the experiment file, so the results have different models and their \
             friction does not compare; the union is {}",
            union.join("; ")
        ),
        &format!(
            "identify every log again with one model, that of the union: sprung identify {}",
            files.join(" ")
        ),
    ))
}

fn parameters(results: &[(&Compared<'_>, &EstimateResult)]) -> Vec<ComparedParameter> {
    let mut rows: Vec<ComparedParameter> = Vec::new();
    for (column, (_, result)) in results.iter().enumerate() {
        for p in &result.parameters {
            let at = (rows.iter()).position(|row| row.name == p.name && row.unit == p.unit);
            let at = at.unwrap_or_else(|| {
                rows.push(ComparedParameter {
                    name: p.name.clone(),
                    symbol: p.symbol.clone(),
                    unit: p.unit.clone(),
                    values: vec![None; results.len()],
                });
                rows.len() - 1
            });
            let first = rows[at].values[0].filter(|_| column > 0);
            rows[at].values[column] = Some(value(p, first));
        }
    }
    rows
}

fn value(p: &ParameterEstimate, first: Option<ComparedValue>) -> ComparedValue {
    let difference = p.value.zip(first.and_then(|f| f.value)).map(|(v, f)| v - f);
    let reference = first.and_then(|f| f.value);
    // A given value has no error.
    let error = |fixed: bool, error: Option<f64>| if fixed { Some(0.0) } else { error };
    let errors =
        first.and_then(|f| error(f.fixed, f.standard_error).zip(error(p.fixed, p.standard_error)));
    let finite = |x: &f64| x.is_finite();
    ComparedValue {
        value: p.value,
        standard_error: p.standard_error,
        ci95: p.ci95,
        fixed: p.fixed,
        difference_percent: (difference.zip(reference))
            .map(|(d, r)| 100.0 * d / r.abs())
            .filter(finite),
        difference_standard_errors: (difference.zip(errors))
            .map(|(d, (a, b))| d / a.hypot(b))
            .filter(finite),
    }
}

fn missing(compared: &[ComparedResult], parameters: &[ComparedParameter]) -> Option<Finding> {
    let lacking: Vec<&ComparedParameter> = (parameters.iter())
        .filter(|row| row.values.iter().any(Option::is_none))
        .collect();
    let row = lacking.first()?;
    let label = |has: bool| {
        let at = row.values.iter().position(|value| value.is_some() == has);
        at.map_or("", |at| compared[at].label.as_str())
    };
    Some(
        Finding::new(
            Severity::Info,
            "different-parameters",
            format!(
                "{} of {} parameters are not in all results: for example, {} is in {}, but not in {}",
                lacking.len(),
                parameters.len(),
                short(&row.name),
                label(true),
                label(false)
            ),
            "compare models with the same friction laws and springs if a difference matters",
        )
        .about(lacking.iter().map(|row| row.name.clone())),
    )
}
