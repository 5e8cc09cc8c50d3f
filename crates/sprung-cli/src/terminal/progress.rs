//! The progress bar.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sprung::progress::{Phase, Progress};

/// Templates of the progress bar: samples with unknown total, samples with known total, and filter
/// runs.
const SAMPLES_OF_UNKNOWN_TOTAL: &str = "{msg} {spinner} {human_pos} samples";
const SAMPLES_OF_TOTAL: &str = "{msg} [{bar:30}] {percent} %, {human_pos} samples, {eta} left";
const FILTER_RUNS: &str =
    "{msg} {spinner} filter run {human_pos} of at most {human_len}, {elapsed}";

/// Interval between two drawings of a bar without reports.
const TICK_INTERVAL: Duration = Duration::from_millis(200);

/// Returns a bar that is drawn on stderr.
///
/// - `what`: text until the run reports its first phase.
pub(super) fn bar(what: &str, is_hidden: bool) -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    bar.set_draw_target(if is_hidden {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    });
    set_template(&bar, SAMPLES_OF_UNKNOWN_TOTAL);
    bar.set_message(what.to_owned());
    bar
}

fn set_template(bar: &ProgressBar, template: &str) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
}

/// Shows progress on a bar.
pub(super) fn show(bar: &ProgressBar, progress: Progress) {
    match (progress.phase, progress.total) {
        (Phase::FindingVelocities | Phase::Refining, Some(most)) => {
            set_template(bar, FILTER_RUNS);
            bar.set_message(progress.phase.word());
            bar.set_length(most);
            bar.set_position(progress.done);
            // A filter run may take seconds without a report.
            bar.enable_steady_tick(TICK_INTERVAL);
        }
        (Phase::Simulating | Phase::Reading | Phase::Validating, Some(total)) => {
            // Samples are counted anew in each phase, and the total of a log that is read is an estimate.
            if bar.position() > progress.done || bar.length().is_none() {
                bar.disable_steady_tick();
                set_template(bar, SAMPLES_OF_TOTAL);
                bar.set_message(progress.phase.word());
                bar.reset_eta();
            }
            bar.set_length(total.max(progress.done));
            bar.set_position(progress.done);
        }
        (Phase::Reading | Phase::Validating, None) => {
            if bar.length().is_some() {
                bar.disable_steady_tick();
                set_template(bar, SAMPLES_OF_UNKNOWN_TOTAL);
                bar.set_message(progress.phase.word());
                bar.unset_length();
            }
            bar.set_position(progress.done);
        }
        _ => bar.tick(),
    }
}

/// Expected duration of a phase from which the terminal announces it, s.
pub(super) const LONG_S: f64 = 60.0;

/// Returns the announcement of a long phase.
pub(super) fn long(phase: Phase, seconds: f64) -> String {
    let minutes = (seconds / 60.0).ceil();
    format!(
        "{} takes about {minutes:.0} min; Ctrl-C ends it and keeps the result of least squares",
        phase.word()
    )
}
