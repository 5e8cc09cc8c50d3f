//! Composes the tables of a validation. For many joints, each joint has its own row.

use super::document::{Table, Tone};
use super::numbers::{dash_if_none, or_dash, significant};
use super::rows::rows;
use crate::validate::{JointProof, QuantityProof, RunResult, SetResult};

/// Maximum number of joints that share a row.
const MAX_JOINTS_PER_ROW: usize = 3;

/// Symbols and units of the compared signals.
const SIGNALS: [(&str, &str); 3] = [("τ", "N·m"), ("q", "rad"), ("φ", "rad")];

/// Returns a table of the root mean square differences between measured and simulated signals.
pub(super) fn errors(run: &RunResult) -> Table {
    let joints = run.joints();
    let signals = || SIGNALS.into_iter().enumerate();
    let caption = format!(
        "{}: root mean square of measured minus simulated over {} ({} samples).",
        run.name, run.log, run.samples
    );
    if joints.len() > MAX_JOINTS_PER_ROW {
        let pairs = run
            .sets
            .iter()
            .flat_map(|set| joints.iter().map(move |joint| (set, *joint)));
        let mut table = rows(pairs)
            .text("Parameters", |(set, _)| &set.parameters)
            .text("Joint", |(_, joint)| joint);
        for (at, (symbol, unit)) in signals() {
            table = table.number(format!("{symbol} [{unit}]"), |(set, joint)| {
                error(set, at, joint)
            });
        }
        return table.table(caption);
    }
    let mut table = rows(&run.sets)
        .text("Parameters", |set| &set.parameters)
        .toned(|set| match set.e_rms {
            None => Tone::Bad,
            Some(_) => Tone::Neutral,
        });
    for (at, (symbol, unit)) in signals() {
        for joint in &joints {
            let heading = format!("{symbol} {joint} [{unit}]");
            table = table.number(heading, |set| error(set, at, joint));
        }
    }
    table.table(caption)
}

/// Returns the error of a signal, or why there is none.
///
/// - `signal`: its place in [`SIGNALS`].
fn error(set: &SetResult, signal: usize, joint: &str) -> String {
    match &set.e_rms {
        Some(e) => or_dash([&e.tau_nm, &e.q_rad, &e.phi_rad][signal].get(joint), 3),
        None => set.outcome.words().to_owned(),
    }
}

/// Returns a table of the prediction errors along the measured motion beside the promised errors,
/// with one row per parameter set and joint.
pub(super) fn predictions(run: &RunResult) -> Table {
    let proofs = || {
        run.sets
            .iter()
            .flat_map(|set| set.predictions.iter().map(move |joint| (set, joint)))
    };
    let has = |of: fn(&JointProof) -> Option<f64>| proofs().any(|(_, joint)| of(joint).is_some());
    let has_promise = has(|joint| joint.torque_promised_nm);
    let has_springs = has(|joint| joint.deflection_error_rad);
    let mut table = rows(proofs())
        .text("Parameters", |(set, _)| &set.parameters)
        .text("Joint", |(_, joint)| &joint.joint)
        .marked(|(_, joint)| joint.quantities().any(|quantity| quantity.is_broken()));
    let quantities = [("torque", "N·m"), ("deflection", "rad")];
    let shown = if has_springs { 2 } else { 1 };
    for (at, (name, unit)) in quantities.into_iter().enumerate().take(shown) {
        let of = |joint: &JointProof, of: fn(&QuantityProof<'_>) -> Option<f64>| {
            joint.quantities().nth(at).as_ref().and_then(of)
        };
        table = table
            .number(format!("{name} error [{unit}]"), |(_, joint)| {
                or_dash(of(joint, |q| Some(q.error)), 3)
            })
            .number("%", |(_, joint)| {
                let share = of(joint, |q| Some(100.0 * q.error / q.value));
                or_dash(share.filter(|share| share.is_finite()), 2)
            });
        if has_promise {
            table = table
                .number("promised", |(_, joint)| {
                    or_dash(of(joint, |q| q.promised), 3)
                })
                .number("times", |(_, joint)| {
                    dash_if_none(of(joint, |q| q.ratio).map(|ratio| format!("{ratio:.1}")))
                });
        }
    }
    table.table(caption_of_predictions(run))
}

fn caption_of_predictions(run: &RunResult) -> String {
    let cutoff = run.position_cutoff_hz.map_or_else(String::new, |cutoff| {
        format!(", cut-off of the positions {} Hz", significant(cutoff, 3))
    });
    let same = if run.same_log {
        " The parameters come from this log."
    } else {
        ""
    };
    format!(
        "{}: root mean square errors, also in percent of the quantity, of the filtered motor torque and \
         of the deflection that the model computes from the measured motion in {} ({} \
         samples{cutoff}).{same}",
        run.name, run.log, run.samples
    )
}
