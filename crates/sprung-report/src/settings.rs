//! Composes the sections about settings: figures of the log, the command and the experiment file.

use super::contents::Contents;
use super::document::{Block, Fold, Section};
use super::numbers::{given, significant};
use super::section::folded;
use crate::estimate::LogInfo;

/// Returns the number of samples and the treatment of their times, as text.
fn samples(log: &LogInfo) -> String {
    let taken = match (log.sampling.as_str(), log.cycle_s) {
        ("on-cycle", Some(cycle)) => format!(
            "{}, taken at multiples of {} s",
            log.samples,
            significant(cycle, 4)
        ),
        ("as-stamped", _) => format!("{}, taken when stamped", log.samples),
        _ => format!("{}, even", log.samples),
    };
    let counts = [
        (log.interpolated, "interpolated"),
        (log.dropped, "missing, at most three in a row"),
        (log.repeated, "written twice"),
        (log.without_value, "without a value, left out"),
        (log.frozen, "that repeat the preceding sample"),
        (log.gaps, "gaps"),
    ];
    let counted = (counts.into_iter())
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"));
    let all: Vec<String> = std::iter::once(taken).chain(counted).collect();
    all.join("; ")
}

/// Composes the settings, and the experiment file as a separate section.
pub(super) fn settings(contents: &Contents<'_>) -> [Section; 2] {
    let mut pairs = Vec::new();
    if let Some(identification) = contents.identification {
        let used = &identification.settings;
        let log = &identification.log;
        pairs.extend([
            (
                "Sampling period".to_owned(),
                format!("{} s", given(Some(log.period_s))),
            ),
            (
                "Largest jitter".to_owned(),
                format!("{} % of the period", significant(log.jitter_percent, 2)),
            ),
            ("Samples".to_owned(), samples(log)),
            (
                "Filter pair".to_owned(),
                format!(
                    "λ = {} rad/s, {}",
                    given(Some(used.filter_cutoff_rad_per_s)),
                    used.discretization
                ),
            ),
            (
                "Zero-phase position filter".to_owned(),
                format!(
                    "Butterworth, order {}, {} Hz",
                    used.position_filter_order,
                    given(Some(used.position_cutoff_hz))
                ),
            ),
        ]);
        for (column, delay) in &log.delay_s {
            let error = delay
                .standard_error
                .map_or_else(String::new, |error| format!(" ± {}", significant(error, 2)));
            pairs.push((
                format!("Delay of {column}"),
                format!("{}{error} s", significant(delay.value, 4)),
            ));
        }
        for (column, sign) in &log.sign {
            pairs.push((
                format!("Sign of {column}"),
                format!(
                    "{}, log-likelihood +{} against the other",
                    sign.value,
                    significant(sign.log_likelihood, 3)
                ),
            ));
        }
        for (column, gain) in &log.gain {
            pairs.push((
                format!("Gain of {column}"),
                format!(
                    "{} ± {}",
                    significant(gain.value, 5),
                    significant(gain.standard_error, 2)
                ),
            ));
        }
        for result in &identification.results {
            pairs.push((
                format!("Time for {}", result.estimator),
                format!("{} s", significant(result.elapsed_s, 2)),
            ));
        }
    }
    [
        folded(
            Fold::Screen,
            "settings",
            "Settings",
            "How the log was read and filtered, and the command that made this report.",
            vec![
                Block::KeyValues(pairs),
                Block::Code(contents.command.to_owned()),
            ],
        ),
        folded(
            Fold::Detail,
            "experiment",
            "Experiment file",
            "With this file and the log, the command makes the same report again.",
            vec![Block::Code(contents.experiment.to_owned())],
        ),
    ]
}
