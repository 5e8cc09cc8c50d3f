//! Composes the tables of a validation. For many joints, each joint has its own row.

use super::document::{Row, Table, Tone};
use super::numbers::{or_dash, significant};
use super::tables::{number, text};
use crate::validate::{JointProof, QuantityProof, RunResult, SetResult};

/// Maximum number of joints that share a row.
const MAX_JOINTS_PER_ROW: usize = 3;

/// Returns a table of the root mean square differences between measured and simulated signals.
pub(super) fn errors(run: &RunResult) -> Table {
    let joints = run.joints();
    if joints.len() > MAX_JOINTS_PER_ROW {
        return errors_by_joint(run);
    }
    let mut columns = vec![text("Parameters")];
    for (symbol, unit) in [("τ", "N·m"), ("q", "rad"), ("φ", "rad")] {
        columns.extend(
            joints
                .iter()
                .map(|joint| number(format!("{symbol} {joint} [{unit}]"))),
        );
    }
    let rows = run
        .sets
        .iter()
        .map(|set| {
            let mut cells = vec![set.parameters.clone()];
            for group in 0..3 {
                for joint in &joints {
                    let value = set
                        .e_rms
                        .as_ref()
                        .and_then(|e| [&e.tau_nm, &e.q_rad, &e.phi_rad][group].get(joint));
                    cells.push(
                        value.map_or_else(|| set.outcome.words().to_owned(), |v| significant(v, 3)),
                    );
                }
            }
            Row {
                cells,
                tone: if set.e_rms.is_none() {
                    Tone::Bad
                } else {
                    Tone::Neutral
                },
            }
        })
        .collect();
    Table {
        caption: format!(
            "{}: root mean square of measured minus simulated over {} ({} samples).",
            run.name, run.log, run.samples
        ),
        columns,
        rows,
        ..Table::default()
    }
}

/// Returns a table of the prediction errors along the measured motion beside the promised errors,
/// with one row per parameter set and joint.
pub(super) fn predictions(run: &RunResult) -> Table {
    let has = |of: fn(&JointProof) -> Option<f64>| {
        let mut all = run.sets.iter().flat_map(|set| &set.predictions);
        all.any(|joint| of(joint).is_some())
    };
    let has_promise = has(|joint| joint.torque_promised_nm);
    let has_springs = has(|joint| joint.deflection_error_rad);
    let mut columns = vec![text("Parameters"), text("Joint")];
    for (quantity, unit, shown) in [("torque", "N·m", true), ("deflection", "rad", has_springs)] {
        if !shown {
            continue;
        }
        columns.push(number(format!("{quantity} error [{unit}]")));
        columns.push(number("%"));
        if has_promise {
            columns.push(number("promised"));
            columns.push(number("times"));
        }
    }
    let rows = run.sets.iter().flat_map(|set| {
        set.predictions.iter().map(move |joint| {
            let mut quantities = joint.quantities();
            let shown = [
                Some(quantities.next()),
                has_springs.then(|| quantities.next()),
            ];
            let cells = shown.into_iter().flatten().flat_map(|quantity| {
                let of = |of: fn(&QuantityProof<'_>) -> Option<f64>| quantity.as_ref().and_then(of);
                let share = of(|q| Some(100.0 * q.error / q.value).filter(|s| s.is_finite()));
                let mut cells = vec![or_dash(of(|q| Some(q.error)), 3), or_dash(share, 2)];
                if has_promise {
                    cells.push(or_dash(of(|q| q.promised), 3));
                    let ratio = of(|q| q.ratio);
                    cells.push(ratio.map_or_else(|| "–".to_owned(), |r| format!("{r:.1}")));
                }
                cells
            });
            Row {
                cells: [set.parameters.clone(), joint.joint.clone()]
                    .into_iter()
                    .chain(cells)
                    .collect(),
                tone: if joint.quantities().any(|quantity| quantity.is_broken()) {
                    Tone::Doubtful
                } else {
                    Tone::Neutral
                },
            }
        })
    });
    Table {
        caption: caption_of_predictions(run),
        rows: rows.collect(),
        columns,
        ..Table::default()
    }
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

/// Returns one row per parameter set and joint.
fn by_joint(run: &RunResult, cells: impl Fn(&SetResult, &str) -> Vec<String>) -> Vec<Row> {
    let joints = run.joints();
    let of_set = |set: &SetResult| -> Vec<Row> {
        let row = |joint: &&str| Row {
            cells: [set.parameters.clone(), (*joint).to_owned()]
                .into_iter()
                .chain(cells(set, joint))
                .collect(),
            tone: Tone::Neutral,
        };
        joints.iter().map(row).collect()
    };
    run.sets.iter().flat_map(of_set).collect()
}

fn errors_by_joint(run: &RunResult) -> Table {
    Table {
        caption: format!(
            "{}: root mean square of measured minus simulated over {} ({} samples).",
            run.name, run.log, run.samples
        ),
        columns: vec![
            text("Parameters"),
            text("Joint"),
            number("τ [N·m]"),
            number("q [rad]"),
            number("φ [rad]"),
        ],
        rows: by_joint(run, |set, joint| match &set.e_rms {
            Some(e) => [&e.tau_nm, &e.q_rad, &e.phi_rad]
                .map(|values| or_dash(values.get(joint), 3))
                .to_vec(),
            None => vec![set.outcome.words().to_owned(); 3],
        }),
        ..Table::default()
    }
}
