//! Findings about a refinement.

use super::channel_updates::ChannelUpdate;
use super::refined::Refined;
use crate::estimate::statistics::between_parts;
use crate::estimate::statistics::kind_of_change;
use crate::estimate::statistics::{FALSE_ALARM_PROBABILITY, SMALL_SHARE};
use crate::finding::{Finding, Severity};
use crate::log::Channels;
use crate::model::Model;
use crate::numbers::in_percent;
use crate::regression::Reading;

/// Maximum number of listed pairs of parameters, and minimum correlation of a listed pair.
const MAX_LISTED_PAIRS: usize = 5;

/// Least correlation of a listed pair.
const LISTED_CORRELATION: f64 = 0.5;

/// Correlation above which the log determines only a combination of two parameters.
const KNOWN_TOGETHER_CORRELATION: f64 = 0.98;

/// Share above which the disturbance is a warning.
const LARGE_DISTURBANCE_SHARE: f64 = 0.15;

/// Returns the refined parameter with the largest change: index in theta and change in standard
/// errors.
pub(super) fn largest_move(refined: &Refined, moves: &[f64]) -> Option<(usize, f64)> {
    (refined.free.iter().zip(moves))
        .map(|(&index, movement)| (index, movement.abs() / refined.standard_error[index]))
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns the findings about a refinement.
pub(super) fn about(reading: &Reading, refined: &Refined) -> Vec<Finding> {
    let model = reading.model();
    let mut findings = Vec::new();
    if refined.read.left_out {
        findings.push(Finding::new(
            Severity::Info,
            "refined-on-part",
            format!(
                "the refinement used {:.1} s ({} samples) in pieces that are spread evenly over the \
                 logs; more samples need more memory and time",
                refined.read.duration, refined.read.samples
            ),
            "set identify.refinement_memory_mib higher, or cut the logs to their exciting parts",
        ));
    }
    findings.extend(estimated_delays(reading.channels(), refined));
    findings.extend(together(model, refined));
    findings.extend(disagree(model, refined));
    let unexplained: Vec<String> = (refined.noise.rows.iter().enumerate())
        .filter(|(_, level)| level.disturbance > SMALL_SHARE * level.torque)
        .map(|(row, level)| {
            let part = in_percent(level.disturbance / level.torque);
            // The row's name ends in the unit.
            format!(
                "{} {:.3} ({part:.0} %)",
                model.row_name(row),
                level.disturbance
            )
        })
        .collect();
    if !unexplained.is_empty() {
        let is_large = (refined.noise.rows.iter())
            .any(|level| level.disturbance > LARGE_DISTURBANCE_SHARE * level.torque);
        findings.push(Finding::new(
            if is_large {
                Severity::Warning
            } else {
                Severity::Info
            },
            "unexplained-torque",
            format!(
                "the model leaves slow torques unexplained; their standard deviations, and the \
                 same relative to the motor torque: {}. The intervals assume random disturbances, \
                 but an effect that repeats with the motion, for example a missing friction law, \
                 may be part of them",
                unexplained.join(", ")
            ),
            "look at the fit over time; try further friction laws, and a second experiment with \
             another motion",
        ));
    }
    findings
}

/// Reports the delays whose estimate the description requests.
fn estimated_delays(channels: &Channels, refined: &Refined) -> Vec<Finding> {
    let estimated = refined
        .channels
        .delays
        .iter()
        .filter(|delay| delay.estimated);
    let finding = |delay: &ChannelUpdate| {
        Finding::new(
            Severity::Info,
            "delay-estimated",
            format!(
                "\"{}\" was recorded {:.5} s late, by likelihood (standard error {:.5} s)",
                channels.all[delay.channel].column,
                delay.value(),
                delay.standard_error
            ),
            "give the delay as a number to keep it fixed",
        )
    };
    estimated.map(finding).collect()
}

/// Reports pairs of parameters of which the log determines only a combination.
fn together(model: &Model, refined: &Refined) -> Vec<Finding> {
    let mut findings = Vec::new();
    for Correlated {
        first: a,
        second: b,
        correlation,
    } in correlations(refined)
    {
        if correlation.abs() < KNOWN_TOGETHER_CORRELATION {
            continue;
        }
        let (first, second) = (&model.parameters()[a], &model.parameters()[b]);
        let (known, sign) = if correlation < 0.0 {
            ("sum", '+')
        } else {
            ("difference", '-')
        };
        let (error, other) = (refined.standard_error[a], refined.standard_error[b]);
        let both = (2.0 * error * error * (1.0 - correlation.abs())).sqrt();
        findings.push(
            Finding::new(
                Severity::Info,
                "known-together",
                format!(
                    "the log determines only a {known} of {a} and {b} well (correlation \
                     {correlation:.3}): the standard error of {a} {sign} {:.3} times {b} is {both:.2e} \
                     {}, that of {a} alone {error:.2e}",
                    error / other,
                    first.unit,
                    a = first.short(),
                    b = second.short(),
                ),
                "use both together, or record a motion that excites them separately",
            )
            .about([first.name.clone(), second.name.clone()]),
        );
    }
    findings
}

/// Two parameters with correlated errors, by their indices in theta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Correlated {
    pub(super) first: usize,
    pub(super) second: usize,
    pub(super) correlation: f64,
}

/// Returns the pairs of parameters with the most strongly correlated errors.
pub(super) fn correlations(refined: &Refined) -> Vec<Correlated> {
    let width = refined.free.len();
    let at = |i: usize, j: usize| refined.covariance[i * width + j];
    let mut pairs: Vec<Correlated> = (0..width)
        .flat_map(|i| (0..i).map(move |j| (j, i)))
        .map(|(i, j)| Correlated {
            first: refined.free[i],
            second: refined.free[j],
            correlation: at(i, j) / (at(i, i) * at(j, j)).sqrt(),
        })
        .filter(|pair| pair.correlation.abs() > LISTED_CORRELATION)
        .collect();
    pairs.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
    pairs.truncate(MAX_LISTED_PAIRS);
    pairs
}

/// Reports the parameters on which several logs disagree.
fn disagree(model: &Model, refined: &Refined) -> Option<Finding> {
    if refined.parts.logs.len() < 2 {
        return None;
    }
    let mut disagreeing = Vec::new();
    let mut names = Vec::new();
    let mut indices = Vec::new();
    for (place, &index) in refined.free.iter().enumerate() {
        let values: Vec<(f64, f64)> = refined.parts.logs.iter().map(|log| log[place]).collect();
        let found = between_parts(&values);
        if found.is_some_and(|found| {
            found.probability < FALSE_ALARM_PROBABILITY / refined.free.len() as f64
        }) {
            let parameter = &model.parameters()[index];
            let each: Vec<String> = (values.iter())
                .map(|(x, e)| format!("{x:.4} ± {e:.4}"))
                .collect();
            disagreeing.push(format!("{} ({})", parameter.short(), each.join(", ")));
            names.push(parameter.name.clone());
            indices.push(index);
        }
    }
    (!disagreeing.is_empty()).then(|| {
        Finding::new(
            Severity::Warning,
            "logs-disagree",
            format!(
                "the logs disagree by more than their intervals allow about {}: one model with one \
                 set of parameters does not describe all of them.{}",
                disagreeing.join("; "),
                kind_of_change(model, &indices)
            ),
            "make sure that all logs are of one robot in one state; parameters that change with \
             the motion or with the controller's gains mean that the model lacks an effect",
        )
        .about(names)
    })
}
