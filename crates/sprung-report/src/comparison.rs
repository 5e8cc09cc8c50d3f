//! Composes the report of a comparison.

use super::document::{Badge, Block, Document, Fold, IntervalRow, Intervals, Section, Table, Tone};
use super::drift::drift;
use super::groups::Joints;
use super::intervals::{self, Ranged};
use super::numbers::{dash_if_none, or_dash, percent_or_dash, significant, with_error};
use super::rows::rows;
use super::section::{findings, folded, origin, section};
use super::tables::{row_name, symbol_and_name};
use super::verdict;
use crate::compare::{
    CombinedResult, ComparedParameter, ComparedPromise, ComparedResult, ComparedValue, Comparison,
    PARAMETER_DRIFTS, RUNS_DISAGREE, SIGNIFICANCE,
};
use crate::finding::{Finding, Severity};
use crate::validate::{JointProof, QuantityProof};

/// Composes the report of a comparison.
///
/// - `command`: the command that made the report.
#[must_use]
pub fn compose_comparison(comparison: &Comparison, command: &str) -> Document {
    let compared = &comparison.compared;
    let mut robots: Vec<&str> = compared.iter().map(|r| r.robot.as_str()).collect();
    robots.dedup();
    let mut sections = Vec::new();
    if !compared.is_empty() {
        sections.extend(of_results(comparison));
    }
    if !comparison.promises.is_empty() {
        sections.push(section(
            "promises",
            "Promises",
            "Prediction errors on logs of validations beside those that the identifications promise.",
            vec![Block::Table(promises(&comparison.promises))],
        ));
    }
    if let Some(found) = findings(&comparison.findings) {
        sections.insert(
            sections.len().min(1),
            section(
                "findings",
                "Findings",
                &format!(
                    "Repeated results of one estimator disagree if chance alone would cause such \
                     differences in less than {} % of all comparisons.",
                    100.0 * SIGNIFICANCE
                ),
                vec![found],
            ),
        );
    }
    if !compared.is_empty() {
        sections.push(folded(
            Fold::Screen,
            "residuals",
            "Residuals",
            "The part of its own log that each result does not explain.",
            vec![Block::Table(residuals(compared))],
        ));
    }
    sections.push(origin(Fold::Screen, command, None));
    let above_notes = |finding: &&Finding| finding.severity > Severity::Info;
    let deciding = comparison.findings.iter().find(above_notes);
    Document {
        title: if robots.is_empty() {
            "Validations".to_owned()
        } else {
            robots.join(" and ")
        },
        subtitle: match (compared.len(), comparison.promises.len()) {
            (0, promises) => format!("Comparison of {promises} validated parameter sets"),
            (results, 0) => format!("Comparison of {results} results"),
            (results, promises) => {
                format!("Comparison of {results} results and {promises} validated parameter sets")
            }
        },
        generator: comparison.generator.clone(),
        verdict: badge(comparison),
        summary: comparison.promises_kept.clone().unwrap_or_default(),
        reason: deciding.map_or_else(String::new, |finding| {
            verdict::first_sentence(&finding.text)
        }),
        what_to_do: deciding
            .map_or_else(String::new, |finding| verdict::as_sentence(&finding.remedy)),
        sections,
        ..Document::default()
    }
}

/// Composes the sections about the results of identifications.
fn of_results(comparison: &Comparison) -> Vec<Section> {
    let mut sections = vec![section(
        "results",
        "Compared results",
        "",
        vec![Block::Table(headers(&comparison.compared))],
    )];
    sections.extend(drift(comparison));
    sections.extend([
        section(
            "agreement",
            "Agreement",
            "Values with their 95 % intervals, as differences from the first result. Each row has \
             its own scale. Results agree if their intervals overlap.",
            vec![Block::Intervals(intervals(comparison))],
        ),
        section(
            "parameters",
            "Parameters",
            "Differences from the first result, in percent and in combined standard errors. The \
             combined standard error is the root of the sum of both squares. It assumes independent \
             errors, but results from the same log share errors.",
            vec![Block::Table(parameters(comparison))],
        ),
    ]);
    if !comparison.combined.is_empty() {
        sections.push(section(
            "combined",
            "Combined",
            "Means of the results of one estimator from different logs, weighted by 1/s². The standard \
             error contains the deviation between the results beyond their errors, and the bias that all \
             results share. I² is the part of the scatter that the errors do not explain.",
            (comparison.combined.iter())
                .map(|result| Block::Table(combined(result)))
                .collect(),
        ));
    }
    sections
}

/// Returns a table of combined results.
fn combined(combined: &CombinedResult) -> Table {
    rows(&combined.parameters)
        .text("Parameter", |parameter| &parameter.name)
        .text("Unit", |parameter| &parameter.unit)
        .number("Mean ± s.e.", |parameter| {
            with_error(parameter.value, 5, parameter.standard_error)
        })
        .number("Results", |parameter| parameter.results)
        .number("χ²", |parameter| significant(parameter.chi_square, 3))
        .number("p", |parameter| significant(parameter.probability, 2))
        .number("I² [%]", |parameter| {
            format!("{:.0}", parameter.i_squared_percent)
        })
        .table(format!(
            "{}: {}",
            combined.estimator,
            combined.results.join(", ")
        ))
}

/// Returns a table with one row per run, parameter set and joint.
fn promises(promises: &[ComparedPromise]) -> Table {
    let proofs: Vec<(&ComparedPromise, QuantityProof<'_>)> = (promises.iter())
        .flat_map(|promise| {
            let quantities = promise.predictions.iter().flat_map(JointProof::quantities);
            quantities.map(move |quantity| (promise, quantity))
        })
        .collect();
    rows(&proofs)
        .text("Run", |(promise, _)| &promise.run)
        .text("Parameters", |(promise, _)| &promise.parameters)
        .text("Quantity", |(_, of)| format!("{} {}", of.joint, of.name))
        .number("promised", |(_, of)| or_dash(of.promised, 3))
        .number("measured", |(_, of)| significant(of.error, 3))
        .number("times", |(_, of)| {
            dash_if_none(of.ratio.map(|ratio| format!("{ratio:.1}")))
        })
        .text("Log", |(promise, _)| {
            let of = if promise.same_log {
                " (of the identification)"
            } else {
                ""
            };
            format!("{}{of}", promise.log)
        })
        .text("File", |(promise, _)| &promise.file)
        .marked(|(_, of)| of.is_broken())
        .table(
            "Root mean square errors of filtered torques [N·m or N] and of deflections [rad or m]. Marked rows break the \
             promise.",
        )
}

fn badge(comparison: &Comparison) -> Option<Badge> {
    let has = |code: &str| (comparison.findings.iter()).any(|finding| finding.code == code);
    if has(PARAMETER_DRIFTS) {
        return Some(Badge::new(Tone::Doubtful, "parameters drift"));
    }
    (comparison.tested > 0).then(|| {
        if has(RUNS_DISAGREE) {
            Badge::new(Tone::Doubtful, "repeated results disagree")
        } else {
            Badge::new(Tone::Good, "repeated results agree")
        }
    })
}

fn headers(compared: &[ComparedResult]) -> Table {
    rows(compared)
        .text("Result", |result| &result.label)
        .text("Estimator", |result| &result.estimator)
        .text("Verdict", |result| result.verdict.word())
        .text("File", |result| &result.file)
        .text("Log", |result| {
            let date = result.date();
            let date = date.map_or_else(String::new, |date| format!(", {date}"));
            format!(
                "{}{date} ({} samples, {} s)",
                result.log,
                result.samples,
                significant(result.duration_s, 4)
            )
        })
        .text("Settings", |result| {
            let settings = &result.settings;
            format!(
                "λ = {} rad/s, {}, {} Hz",
                significant(settings.filter_cutoff_rad_per_s, 3),
                settings.discretization,
                significant(settings.position_cutoff_hz, 3)
            )
        })
        .number("Condition, scaled", |result| {
            or_dash(result.condition_number_scaled, 3)
        })
        .text("Warnings", |result| match result.findings.as_slice() {
            [] => "none".to_owned(),
            findings => findings.join(", "),
        })
        .toned(|result| verdict::tone(result.verdict))
        .table("")
}

fn cell(value: Option<&ComparedValue>) -> String {
    let Some(value) = value else {
        return "not in the model".to_owned();
    };
    match (value.value, value.standard_error) {
        (None, _) => "not determined".to_owned(),
        (Some(v), _) if value.fixed => format!("{} given", significant(v, 5)),
        (Some(v), None) => significant(v, 5),
        (Some(v), Some(error)) => with_error(v, 5, error),
    }
}

fn parameters(comparison: &Comparison) -> Table {
    let disagreeing = |name: &String| {
        (comparison.findings.iter())
            .any(|f| f.severity != Severity::Info && f.parameters.contains(name))
    };
    let mut table = rows(&comparison.parameters)
        .text("Parameter", |parameter| {
            symbol_and_name(&parameter.symbol, &parameter.name)
        })
        .text("Unit", |parameter| &parameter.unit)
        .marked(|parameter| disagreeing(&parameter.name));
    for (i, result) in comparison.compared.iter().enumerate() {
        table = table.number(format!("{} ± s.e.", result.label), |parameter| {
            cell(parameter.values.get(i).and_then(Option::as_ref))
        });
        if i > 0 {
            let of = |parameter: &ComparedParameter,
                      of: fn(&ComparedValue) -> Option<f64>,
                      digits: usize| {
                let value = parameter
                    .values
                    .get(i)
                    .and_then(Option::as_ref)
                    .and_then(of);
                dash_if_none(value.map(|x| format!("{x:+.digits$}")))
            };
            table = table
                .number("%", |parameter| of(parameter, |v| v.difference_percent, 2))
                .number("in s.e.", |parameter| {
                    of(parameter, |v| v.difference_standard_errors, 1)
                });
        }
    }
    table.table("Marked rows disagree.")
}

/// Returns the values of each parameter relative to the first value, scaled by the largest
/// distance.
fn intervals(comparison: &Comparison) -> Intervals {
    let first = comparison.compared.first();
    let joints = first.map_or_else(Joints::default, |first| {
        Joints::of_rows(&first.residual_rms)
    });
    let sorted = joints.sorted(&comparison.parameters, |parameter| &parameter.name);
    let rows = sorted
        .into_iter()
        .filter_map(|parameter| row(parameter, &joints));
    Intervals {
        caption: "Differences from the first result that has a value. The number at the right is \
                  half the width of the row."
            .to_owned(),
        names: comparison
            .compared
            .iter()
            .map(|result| result.label.clone())
            .collect(),
        rows: rows.collect(),
        ..Intervals::default()
    }
}

fn row(parameter: &ComparedParameter, joints: &Joints) -> Option<IntervalRow> {
    let centre = (parameter.values.iter().flatten()).find_map(|value| value.value)?;
    let values: Vec<Option<Ranged>> = (parameter.values.iter())
        .map(|value| {
            let value = value.as_ref()?;
            Some((value.value?, value.ci95))
        })
        .collect();
    let named = (joints.within(&parameter.name), parameter.unit.as_str());
    Some(IntervalRow {
        group: joints.group(&parameter.name).to_owned(),
        ..intervals::of_parameter(named, centre, &values)
    })
}

fn residuals(compared: &[ComparedResult]) -> Table {
    let mut names: Vec<&str> = Vec::new();
    for result in compared {
        for (name, _) in result.residual_rms.iter() {
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    let mut table = rows(names).text("Row", row_name);
    for result in compared {
        table = table
            .number(format!("{} [N·m or N]", result.label), |name| {
                or_dash(result.residual_rms.get(name), 3)
            })
            .number("% of torque", |name| {
                percent_or_dash(result.relative_residual.get(name))
            });
    }
    table.table("Root mean square residuals of the filtered regression.")
}
