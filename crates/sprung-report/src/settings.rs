//! Composes the sections about settings: figures of the log, the command and the experiment file.

use super::contents::Contents;
use super::document::{Block, Fold, Section};
use super::numbers::{given, significant, with_error};
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
        let mut add = |name: &str, text: String| pairs.push((name.to_owned(), text));
        add(
            "Sampling period",
            format!("{} s", given(Some(log.period_s))),
        );
        add(
            "Largest jitter",
            format!("{} % of the period", significant(log.jitter_percent, 2)),
        );
        add("Samples", samples(log));
        let cutoff = given(Some(used.filter_cutoff_rad_per_s));
        add(
            "Filter pair",
            format!("λ = {cutoff} rad/s, {}", used.discretization),
        );
        let (order, hz) = (
            used.position_filter_order,
            given(Some(used.position_cutoff_hz)),
        );
        add(
            "Zero-phase position filter",
            format!("Butterworth, order {order}, {hz} Hz"),
        );
        for (column, delay) in &log.delay_s {
            let text = match delay.standard_error {
                Some(error) => with_error(delay.value, 4, error),
                None => significant(delay.value, 4),
            };
            add(&format!("Delay of {column}"), format!("{text} s"));
        }
        for (column, sign) in &log.sign {
            let better = significant(sign.log_likelihood, 3);
            let text = format!("{}, log-likelihood +{better} against the other", sign.value);
            add(&format!("Sign of {column}"), text);
        }
        for (column, gain) in &log.gain {
            let text = with_error(gain.value, 5, gain.standard_error);
            add(&format!("Gain of {column}"), text);
        }
        for result in &identification.results {
            let text = format!("{} s", significant(result.elapsed_s, 2));
            add(&format!("Time for {}", result.estimator), text);
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
