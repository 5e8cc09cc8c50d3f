//! Composes the figures of stability: residuals over the cut-offs, and estimates from parts of the
//! logs.

use super::document::{Bar, BarRow, Bars, Block, Fold, Intervals, Section, Tone};
use super::intervals;
use super::numbers::{percent, significant};
use super::section::folded;
use crate::estimate::{CutoffChoice, EstimateResult, Identification, LogInfo};

/// Codes of findings about parts of the logs.
const ABOUT_PARTS: [&str; 2] = ["parts-disagree", "logs-disagree"];

/// A cut-off is marked if its held-out residual exceeds the least one by more than this fraction.
const MARKED_EXCESS: f64 = 0.05;

/// Returns bars of the residual in held-out parts of the log, one row per cut-off; `None` if no
/// cut-off has a residual.
pub(super) fn held_out(choice: &CutoffChoice) -> Option<Bars> {
    let residuals = || choice.sweep.iter().filter_map(|p| p.held_out_residual);
    let least = residuals().fold(f64::INFINITY, f64::min);
    let most = residuals().fold(0.0, f64::max);
    (most > 0.0 && most.is_finite()).then(|| Bars {
        caption: "Residual of the filtered torque in each eighth of the beginning of the log, with \
                  the parameters of the other eighths, relative to the torque. The highest rows lie \
                  above the cut-off that the noise allows. A row is marked if it exceeds the least \
                  residual by more than 5 %."
            .to_owned(),
        names: vec!["held-out residual".to_owned()],
        ticks: vec![
            (0.0, "0".to_owned()),
            (1.0, percent(most, 2)),
        ],
        rows: (choice.sweep.iter().rev())
            .map(|point| BarRow {
                label: format!("{} Hz", significant(point.cutoff_hz, 3)),
                bars: vec![point.held_out_residual.map(|residual| Bar {
                    length: residual / most,
                    text: percent(residual, 3),
                })],
                tone: match point.held_out_residual {
                    Some(residual) if residual > (1.0 + MARKED_EXCESS) * least => Tone::Doubtful,
                    _ => Tone::Neutral,
                },
            })
            .collect(),
    })
}

/// Composes the section about parameters that change between parts of the logs; `None` if no
/// finding names one.
pub(super) fn parts(identification: &Identification) -> Option<Section> {
    let (result, moved) = (identification.results.iter()).find_map(|result| {
        let mut findings = result.warnings.iter();
        let found = findings.find(|finding| ABOUT_PARTS.contains(&finding.code.as_str()))?;
        (result.parts.len() > 1).then_some((result, &found.parameters))
    })?;
    let rows = (result.parameters.iter().enumerate())
        .filter(|(_, parameter)| moved.contains(&parameter.name))
        .filter_map(|(i, parameter)| {
            let alone = result.parts.iter().map(|part| *part.values.get(i)?);
            intervals::around(parameter, alone.collect())
        });
    let figure = Intervals {
        caption:
            "Estimates by least squares from each part alone, with 95 % intervals, relative to \
                  the result. The number at the right is half the width of the row."
                .to_owned(),
        names: names(identification, result),
        rows: rows.collect(),
        ..Intervals::default()
    };
    Some(folded(
        Fold::Screen,
        "parts",
        "Parts of the logs",
        "These parameters change between parts of the logs by more than their standard errors \
         allow. The robot changed, or the model lacks an effect. Intervals of least squares contain \
         the deviation between the parts.",
        vec![Block::Intervals(figure)],
    ))
}

/// Returns the names of the result and of the parts.
fn names(identification: &Identification, result: &EstimateResult) -> Vec<String> {
    let files: Vec<String> = identification.logs().map(LogInfo::name).collect();
    let mut names = vec![result.estimator.clone()];
    if files.len() == result.parts.len() {
        names.extend(files);
    } else {
        names.extend((result.parts.iter()).map(|part| {
            format!(
                "{} to {} s",
                significant(part.from_s, 3),
                significant(part.to_s, 3)
            )
        }));
    }
    names
}
