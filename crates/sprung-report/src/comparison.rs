//! Composes the report of a comparison.

use super::document::{
    Badge, Block, Document, Fold, IntervalRow, Intervals, Row, Section, Table, Tone,
};
use super::drift::drift;
use super::groups::Joints;
use super::intervals::{self, Ranged};
use super::numbers::{or_dash, significant};
use super::section::{folded, section, shown};
use super::tables::{number, text};
use super::verdict;
use crate::compare::{
    CombinedParameter, CombinedResult, ComparedParameter, ComparedPromise, ComparedResult,
    ComparedValue, Comparison, PARAMETER_DRIFTS, RUNS_DISAGREE, SIGNIFICANCE,
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
    if !comparison.findings.is_empty() {
        let findings = comparison.findings.iter().map(shown).collect();
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
                vec![Block::Findings(findings)],
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
    sections.push(folded(
        Fold::Screen,
        "settings",
        "Settings",
        "The command that made this report.",
        vec![Block::Code(command.to_owned())],
    ));
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
    let row = |parameter: &CombinedParameter| Row {
        cells: vec![
            parameter.name.clone(),
            parameter.unit.clone(),
            format!(
                "{} ± {}",
                significant(parameter.value, 5),
                significant(parameter.standard_error, 2)
            ),
            parameter.results.to_string(),
            significant(parameter.chi_square, 3),
            significant(parameter.probability, 2),
            format!("{:.0}", parameter.i_squared_percent),
        ],
        tone: Tone::Neutral,
    };
    Table {
        caption: format!("{}: {}", combined.estimator, combined.results.join(", ")),
        columns: vec![
            text("Parameter"),
            text("Unit"),
            number("Mean ± s.e."),
            number("Results"),
            number("χ²"),
            number("p"),
            number("I² [%]"),
        ],
        rows: combined.parameters.iter().map(row).collect(),
        ..Table::default()
    }
}

/// Returns a table with one row per run, parameter set and joint.
fn promises(promises: &[ComparedPromise]) -> Table {
    let row = |promise: &ComparedPromise, quantity: &QuantityProof<'_>| Row {
        cells: vec![
            promise.run.clone(),
            promise.parameters.clone(),
            format!("{} {}", quantity.joint, quantity.name),
            or_dash(quantity.promised, 3),
            significant(quantity.error, 3),
            quantity
                .ratio
                .map_or_else(|| "–".to_owned(), |ratio| format!("{ratio:.1}")),
            if promise.same_log {
                format!("{} (of the identification)", promise.log)
            } else {
                promise.log.clone()
            },
            promise.file.clone(),
        ],
        tone: if quantity.is_broken() {
            Tone::Doubtful
        } else {
            Tone::Neutral
        },
    };
    let rows = promises.iter().flat_map(|promise| {
        let quantities = promise.predictions.iter().flat_map(JointProof::quantities);
        quantities.map(move |quantity| row(promise, &quantity))
    });
    Table {
        caption:
            "Root mean square errors of filtered torques [N·m or N] and of deflections [rad or \
                  m]. Marked rows break the promise."
                .to_owned(),
        rows: rows.collect(),
        columns: vec![
            text("Run"),
            text("Parameters"),
            text("Quantity"),
            number("promised"),
            number("measured"),
            number("times"),
            text("Log"),
            text("File"),
        ],
        ..Table::default()
    }
}

fn badge(comparison: &Comparison) -> Option<Badge> {
    if (comparison.findings.iter()).any(|finding| finding.code == PARAMETER_DRIFTS) {
        return Some(Badge {
            tone: Tone::Doubtful,
            text: "parameters drift".to_owned(),
        });
    }
    let disagree = (comparison.findings.iter()).any(|f| f.code == RUNS_DISAGREE);
    (comparison.tested > 0).then(|| Badge {
        tone: if disagree { Tone::Doubtful } else { Tone::Good },
        text: if disagree {
            "repeated results disagree".to_owned()
        } else {
            "repeated results agree".to_owned()
        },
    })
}

fn headers(compared: &[ComparedResult]) -> Table {
    let row = |result: &ComparedResult| {
        let settings = &result.settings;
        Row {
            cells: vec![
                result.label.clone(),
                result.estimator.clone(),
                result.verdict.word().to_owned(),
                result.file.clone(),
                format!(
                    "{}{} ({} samples, {} s)",
                    result.log,
                    result
                        .date()
                        .map_or_else(String::new, |date| format!(", {date}")),
                    result.samples,
                    significant(result.duration_s, 4)
                ),
                format!(
                    "λ = {} rad/s, {}, {} Hz",
                    significant(settings.filter_cutoff_rad_per_s, 3),
                    settings.discretization,
                    significant(settings.position_cutoff_hz, 3)
                ),
                or_dash(result.condition_number_scaled, 3),
                if result.findings.is_empty() {
                    "none".to_owned()
                } else {
                    result.findings.join(", ")
                },
            ],
            tone: verdict::tone(result.verdict),
        }
    };
    Table {
        caption: String::new(),
        columns: vec![
            text("Result"),
            text("Estimator"),
            text("Verdict"),
            text("File"),
            text("Log"),
            text("Settings"),
            number("Condition, scaled"),
            text("Warnings"),
        ],
        rows: compared.iter().map(row).collect(),
        ..Table::default()
    }
}

fn cell(value: Option<&ComparedValue>) -> String {
    let Some(value) = value else {
        return "not in the model".to_owned();
    };
    match (value.value, value.standard_error) {
        (None, _) => "not determined".to_owned(),
        (Some(v), _) if value.fixed => format!("{} given", significant(v, 5)),
        (Some(v), None) => significant(v, 5),
        (Some(v), Some(error)) => format!("{} ± {}", significant(v, 5), significant(error, 2)),
    }
}

fn parameters(comparison: &Comparison) -> Table {
    let mut columns = vec![text("Parameter"), text("Unit")];
    for (i, result) in comparison.compared.iter().enumerate() {
        columns.push(number(format!("{} ± s.e.", result.label)));
        if i > 0 {
            columns.push(number("%"));
            columns.push(number("in s.e."));
        }
    }
    let disagreeing = |name: &String| {
        (comparison.findings.iter())
            .any(|f| f.severity != Severity::Info && f.parameters.contains(name))
    };
    let rows = comparison.parameters.iter().map(|parameter| {
        let symbol = parameter.symbol.replace("theta", "θ");
        let mut cells = vec![
            format!("{symbol}\u{a0}{}", parameter.name),
            parameter.unit.clone(),
        ];
        for (i, value) in parameter.values.iter().enumerate() {
            cells.push(cell(value.as_ref()));
            if i > 0 {
                let of = |of: fn(&ComparedValue) -> Option<f64>, digits: usize| {
                    let value = value.as_ref().and_then(of);
                    value.map_or_else(|| "–".to_owned(), |x| format!("{x:+.digits$}"))
                };
                cells.push(of(|v| v.difference_percent, 2));
                cells.push(of(|v| v.difference_standard_errors, 1));
            }
        }
        Row {
            cells,
            tone: if disagreeing(&parameter.name) {
                Tone::Doubtful
            } else {
                Tone::Neutral
            },
        }
    });
    Table {
        caption: "Marked rows disagree.".to_owned(),
        rows: rows.collect(),
        columns,
        ..Table::default()
    }
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
        ticks: Vec::new(),
        rows: rows.collect(),
        folded: false,
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
    let mut columns = vec![text("Row")];
    for result in compared {
        columns.push(number(format!("{} [N·m or N]", result.label)));
        columns.push(number("% of torque"));
    }
    let rows = names.iter().map(|name| {
        let mut cells = vec![(name.trim_end_matches("_nm").trim_end_matches("_n")).to_owned()];
        for result in compared {
            cells.push(or_dash(result.residual_rms.get(name), 3));
            let share = result.relative_residual.get(name);
            cells.push(share.map_or_else(|| "–".to_owned(), |r| format!("{:.1}", 100.0 * r)));
        }
        Row {
            cells,
            tone: Tone::Neutral,
        }
    });
    Table {
        caption: "Root mean square residuals of the filtered regression.".to_owned(),
        rows: rows.collect(),
        columns,
        ..Table::default()
    }
}
