//! Composes the tables of a validation. For many joints, each joint has its own row.

use super::document::{Row, Table, Tone};
use super::numbers::{or_dash, significant};
use super::tables::{number, text};
use crate::validate::{RunResult, SetResult};

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
    }
}

/// Returns a table of the residuals of the filtered torque along the measured motion.
pub(super) fn torque(run: &RunResult) -> Table {
    let joints = run.joints();
    if joints.len() > MAX_JOINTS_PER_ROW {
        return torque_by_joint(run);
    }
    let mut columns = vec![text("Parameters")];
    for joint in &joints {
        columns.push(number(format!("{joint} [N·m]")));
        columns.push(number(format!("{joint} [% of torque]")));
    }
    let rows = run
        .sets
        .iter()
        .map(|set| {
            let mut cells = vec![set.parameters.clone()];
            for joint in &joints {
                let relative = set.torque_relative_residual.get(joint);
                cells.push(or_dash(set.torque_residual_nm.get(joint), 3));
                cells
                    .push(relative.map_or_else(|| "–".to_owned(), |r| format!("{:.1}", 100.0 * r)));
            }
            Row {
                cells,
                tone: Tone::Neutral,
            }
        })
        .collect();
    Table {
        caption: caption_of_torque(run),
        columns,
        rows,
    }
}

fn caption_of_torque(run: &RunResult) -> String {
    let cutoff = run.position_cutoff_hz.map_or_else(String::new, |cutoff| {
        format!(", cut-off of the positions {} Hz", significant(cutoff, 3))
    });
    format!(
        "{}: root mean square error of the filtered motor torque that the model computes from the \
         measured motion in {} ({} samples{cutoff}).",
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
    }
}

fn torque_by_joint(run: &RunResult) -> Table {
    Table {
        caption: caption_of_torque(run),
        columns: vec![
            text("Parameters"),
            text("Joint"),
            number("error [N·m]"),
            number("% of torque"),
        ],
        rows: by_joint(run, |set, joint| {
            let relative = set.torque_relative_residual.get(joint);
            vec![
                or_dash(set.torque_residual_nm.get(joint), 3),
                relative.map_or_else(|| "–".to_owned(), |r| format!("{:.1}", 100.0 * r)),
            ]
        }),
    }
}
