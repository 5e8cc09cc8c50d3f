//! Findings about a result of output error.

use super::controller::TorqueMatch;
use super::levenberg::{Ending, FAILED_FIT_COST};
use super::record::Record;
use crate::estimate::result::SimulationFit;
use crate::estimate::statistics::{CERTAIN_SIGMAS, LARGE_SHARE};
use crate::finding::{Finding, Severity};
use crate::model::{Model, short};
use crate::numbers::in_percent;

/// Minimum difference of the logged torque's scale that is reported, and its significance in
/// standard errors.
const TORQUE_SCALE_SHARE: f64 = 0.005;
/// Cost per sample above which the real loop differs from the simulated one. Above
/// [`FAILED_FIT_COST`] the intervals are meaningless. Measured on the paper's twin: 0.97 to 1.02
/// for the exact loop, 1.02 with a velocity gain 10 % wrong, 1.6 with a delay of one sample, 125
/// with a disturbance of 2 % of the torque, 1300 with a torque that saturates at 70 % of its peak.
const OTHER_LOOP_COST: f64 = 1.3;

/// Returns the findings that hold for every result.
pub(super) fn standing() -> Vec<Finding> {
    vec![
        Finding::new(
            Severity::Info,
            "controller-taken-as-exact",
            "output error assumes that the controller and its reference are exactly known: with \
             gains that are 2 % wrong every parameter is 2 % wrong, but the motion still fits and \
             the standard errors do not show the error"
                .to_owned(),
            "take the gains from the code that ran, and compare with least-squares, which uses the \
             logged torque instead",
        ),
        Finding::new(
            Severity::Info,
            "disturbances-not-modelled",
            "output error models no torque except the controller's. A disturbance of 2 % of the \
             motor torque makes the parameters 3 to 4 % wrong and the friction of links much more, \
             and the intervals do not contain the true values. The cost per sample shows this"
                .to_owned(),
            "use output error for simulation studies and for loops that are known exactly",
        ),
    ]
}

pub(super) fn no_record() -> Finding {
    failed("the beginning of the log has too few samples without a gap, or nothing moves in it")
}

/// The search cannot start.
pub(super) fn no_start(why: &str) -> Finding {
    failed(&format!("the linear result cannot be simulated: {why}"))
}

fn failed(why: &str) -> Finding {
    Finding::new(
        Severity::Serious,
        "output-error-failed",
        format!("output error found nothing: {why}. The values here are those of least squares"),
        "look at the warnings of least-squares and at the gains of [controller]; use the result of \
         least-squares",
    )
}

pub(super) fn not_converged(ending: Ending, last: &str, simulation: &SimulationFit) -> Finding {
    let how = match ending {
        Ending::Stuck => "no further step lowered the cost, although a decrease was predicted",
        Ending::Converged | Ending::Limit => "the limit of iterations was reached",
    };
    Finding::new(
        Severity::Serious,
        "output-error-not-converged",
        format!(
            "output error did not converge: after {} iterations {how} (cost per sample {:.3}); {} \
             moved most in the last step. The values here are those of least squares",
            simulation.iterations,
            simulation.cost_per_sample,
            short(last)
        ),
        "leave out what the log does not determine (assume_zero, fixed), or use the result of \
         least-squares",
    )
    .about([last.to_owned()])
}

/// Reports the part of the log that was used.
pub(super) fn samples(record: &Record) -> Finding {
    let end = if record.at_gap {
        "up to its first gap"
    } else {
        "or all of them, if it has no more"
    };
    Finding::new(
        Severity::Info,
        "output-error-samples",
        format!(
            "output error simulates the first {} samples ({:.3} s) of the first log, {end}, from \
             rest",
            record.len(),
            record.len() as f64 * record.period
        ),
        "cut the log so that it begins at rest and holds the motion first",
    )
}

pub(super) fn start_changed(model: &Model, changed: &[usize]) -> Option<Finding> {
    if changed.is_empty() {
        return None;
    }
    let names = || changed.iter().map(|&i| &model.parameters()[i]);
    let shown: Vec<_> = names().map(|p| p.short()).collect();
    Some(
        Finding::new(
            Severity::Info,
            "output-error-start-changed",
            format!(
                "the linear values of {} are impossible for a robot; the search started from other \
                 values",
                shown.join(", ")
            ),
            "compare with the result of least-squares",
        )
        .about(names().map(|p| p.name.clone())),
    )
}

/// Reports the joints whose described controller differs from the real one.
pub(super) fn controller(model: &Model, torques: &[Option<TorqueMatch>]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (name, torque) in model.joints().iter().zip(torques) {
        let Some(torque) = torque else {
            findings.push(Finding::new(
                Severity::Serious,
                "controller-does-not-match",
                format!(
                    "{name}: replayed on the logged positions, the controller gives no torque to \
                     compare with the logged one. No loop was simulated; the values here are those \
                     of least squares"
                ),
                "check the gains and the reference of [controller]",
            ));
            continue;
        };
        findings.extend(late(name, torque));
        if torque.relative > LARGE_SHARE {
            findings.push(Finding::new(
                Severity::Serious,
                "controller-does-not-match",
                format!(
                    "{name}: replayed on the logged positions, the controller's torque differs \
                     from the logged torque by {:.0} % beyond its noise (root mean squares): \
                     another controller ran, or its torque was limited (saturation). No loop was \
                     simulated; the values here are those of least squares",
                    in_percent(torque.relative)
                ),
                "give gains, velocity window, reference and limits in [controller] as they were \
                 during the log, and let time start with the reference; or use least-squares, \
                 which needs no controller",
            ));
        } else if (torque.gain - 1.0).abs()
            > TORQUE_SCALE_SHARE.max(CERTAIN_SIGMAS * torque.gain_error)
        {
            findings.push(Finding::new(
                Severity::Warning,
                "controller-torque-scale",
                format!(
                    "{name}: the logged torque is {:.4} ± {:.4} times the torque of the controller \
                     for the logged positions. Output error uses the controller's torque, so every \
                     parameter contains this factor, and the motion still fits",
                    torque.gain, torque.gain_error
                ),
                "check the gains of [controller] against the code that ran, and the torque constant",
            ));
        }
    }
    findings
}

fn late(name: &str, torque: &TorqueMatch) -> Option<Finding> {
    (torque.late != 0).then(|| {
        Finding::new(
            Severity::Warning,
            "controller-torque-late",
            format!(
                "{name}: the logged torque is that of the controller {} sample(s) {}: the loop has \
                 a delay that is not simulated, or the log has a delay",
                torque.late.abs(),
                if torque.late > 0 { "later" } else { "earlier" }
            ),
            "log position and torque of one sample in one line. A true delay of the loop makes \
             rotor inertias wrong by several percent, so use least-squares then",
        )
    })
}

/// Reports a cost per sample that is well above 1.
pub(super) fn cost(simulation: &SimulationFit) -> Option<Finding> {
    let cost = simulation.cost_per_sample;
    if cost <= OTHER_LOOP_COST {
        return None;
    }
    let worst = (simulation.position_rms_over_noise.iter()).max_by(|a, b| a.1.total_cmp(&b.1));
    let worst = worst.map_or_else(String::new, |(column, rms)| {
        format!(", most in \"{column}\" ({rms:.1} times its noise)")
    });
    Some(Finding::new(
        if cost > FAILED_FIT_COST {
            Severity::Serious
        } else {
            Severity::Warning
        },
        "simulated-loop-differs",
        format!(
            "the simulated positions differ from the measured ones by {:.2} times the noise of the \
             sensors (root mean squares; cost per sample {cost:.2}, 1 where the loop is exactly \
             known){worst}: a disturbance, a delay or a limit of the loop, a start in motion, or \
             an effect that the model lacks. This biases the parameters by several percent, and \
             the intervals do not show it",
            cost.sqrt()
        ),
        "use least-squares, which needs no controller, or find the disturbance of the loop",
    ))
}
