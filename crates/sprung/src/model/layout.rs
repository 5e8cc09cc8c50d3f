//! The parameters of a robot, and their entries in its regressor.

use sprung_core::drives::Term;
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::robot::Share;

use super::inertial::Inertial;
use super::links::TreeLinks;
use crate::description::{EncoderOffset, Experiment, Joint, SpringTerm};

/// Rows and entries of a robot's regressor.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    /// Kind and joint of each parameter after those of the links.
    pub(super) drives: Vec<(JointParameter, usize)>,
    pub(super) terms: Vec<Term>,
    pub(super) motor_rows: Vec<Option<usize>>,
    /// First link entry of joint `i` and link `j`, \[n × n\].
    pub(super) link_entries: Vec<usize>,
    pub(super) shares: Vec<Share>,
    pub(super) entries: usize,
    /// Columns of theta in each row.
    pub(super) row_columns: Vec<Vec<usize>>,
    /// Index of each row's first entry, then the number of all entries.
    pub(super) row_entries: Vec<usize>,
}

/// Returns the normalised ratios of a coupled transmission, motor positions after their own gear
/// per joint position, \[n × n\] by rows; `None` without coupling.
pub(super) fn coupling(experiment: &Experiment) -> Option<Vec<f64>> {
    let matrix = experiment.robot.transmission_matrix.as_ref()?;
    let rows = matrix.iter().enumerate();
    Some(
        rows.flat_map(|(i, row)| row.iter().map(move |ratio| ratio / row[i]))
            .collect(),
    )
}

impl Layout {
    pub(super) fn new(
        experiment: &Experiment,
        inertial: &Inertial,
        links: Option<&TreeLinks>,
        coupling: Option<&[f64]>,
    ) -> Self {
        let joints = &experiment.robot.joint;
        let n = joints.len();
        let offset = match experiment.identify.encoder_offset {
            Some(choice) => choice == EncoderOffset::Estimate,
            None => links.is_some(),
        };
        let has = |kind: JointParameter, i: usize| match kind {
            JointParameter::RotorInertia => {
                joints[i].is_flexible() || links.is_none_or(|links| links.has_rotor(i))
            }
            _ => has(&joints[i], kind, offset),
        };
        let mut layout = Self {
            drives: (JointParameter::ALL.into_iter())
                .flat_map(|kind| (0..n).map(move |i| (kind, i)))
                .filter(|&(kind, i)| has(kind, i))
                .collect(),
            link_entries: vec![0; n * n],
            ..Self::default()
        };
        let mut next = n;
        for joint in joints {
            layout.motor_rows.push(joint.is_flexible().then(|| {
                next += 1;
                next - 1
            }));
        }
        for row in 0..n {
            layout.row_entries.push(layout.entries);
            let mut columns = layout.link_row(inertial, row);
            layout.drive_row(row, row, inertial.len(), coupling, &mut columns);
            layout.row_columns.push(columns);
        }
        for joint in 0..n {
            if let Some(row) = layout.motor_rows[joint] {
                layout.row_entries.push(layout.entries);
                let mut columns = Vec::new();
                layout.drive_row(row, joint, inertial.len(), coupling, &mut columns);
                layout.row_columns.push(columns);
            }
        }
        layout.row_entries.push(layout.entries);
        layout
    }

    /// Returns the joints with a friction law on either side.
    pub(super) fn joints_with(&self, law: Law) -> Vec<usize> {
        let sides = [Side::Link, Side::Motor].map(|side| JointParameter::Friction(side, law));
        let has = |joint: &usize| {
            (self.drives.iter()).any(|(kind, own)| own == joint && sides.contains(kind))
        };
        (0..self.motor_rows.len()).filter(has).collect()
    }

    /// Returns the link columns of a joint's row: those of all links that the joint moves.
    fn link_row(&mut self, inertial: &Inertial, row: usize) -> Vec<usize> {
        let n = inertial.first.len() - 1;
        let mut columns = Vec::new();
        for link in (row..n).filter(|link| inertial.carries(row, *link)) {
            self.link_entries[row * n + link] = self.entries + columns.len();
            columns.extend(inertial.first[link]..inertial.first[link + 1]);
        }
        let entry = |parameter: usize| {
            let place = columns.iter().position(|column| *column == parameter)?;
            Some(self.entries + place)
        };
        self.shares
            .extend(inertial.shared.iter().filter_map(|shared| {
                Some(Share {
                    entry: entry(shared.parameter)?,
                    of: entry(shared.of)?,
                    factor: shared.factor,
                })
            }));
        self.entries += columns.len();
        columns
    }

    /// Adds the terms of the drives to a row.
    fn drive_row(
        &mut self,
        row: usize,
        joint: usize,
        inertial: usize,
        coupling: Option<&[f64]>,
        columns: &mut Vec<usize>,
    ) {
        let n = self.motor_rows.len();
        let flexible = self.motor_rows[joint].is_some();
        let of_motor = row >= n;
        for (at, &(what, owner)) in self.drives.iter().enumerate() {
            let ratio = match coupling {
                Some(ratios) => ratios[owner * n + joint],
                None => f64::from(u8::from(owner == joint)),
            };
            let own = f64::from(u8::from(owner == joint));
            let gain = match what {
                JointParameter::RotorInertia
                | JointParameter::BackEmf
                | JointParameter::Friction(Side::Motor, _) => {
                    if of_motor || !flexible {
                        ratio
                    } else {
                        0.0
                    }
                }
                JointParameter::Friction(Side::Link, _) => {
                    if of_motor {
                        0.0
                    } else {
                        own
                    }
                }
                // Terms of the spring.
                _ if of_motor => own,
                _ => -own,
            };
            if gain != 0.0 {
                self.terms.push(Term {
                    row,
                    entry: self.entries,
                    column: inertial + at,
                    what,
                    joint: owner,
                    gain,
                });
                columns.push(inertial + at);
                self.entries += 1;
            }
        }
    }
}

/// Returns whether a joint has a given parameter; rotor inertias are decided elsewhere.
fn has(joint: &Joint, kind: JointParameter, offset: bool) -> bool {
    let flexible = joint.is_flexible();
    let spring = |term| flexible && joint.spring_terms().contains(&term);
    match kind {
        JointParameter::RotorInertia => true,
        JointParameter::Stiffness => flexible,
        JointParameter::CubicStiffness => spring(SpringTerm::Cubic),
        JointParameter::Damping => spring(SpringTerm::Damping),
        JointParameter::Preload => flexible && offset,
        JointParameter::BackEmf => joint.back_emf_vs_per_rad.is_some(),
        JointParameter::Friction(side, law) => {
            let laws = match side {
                Side::Link => joint.link_laws(),
                Side::Motor => joint.motor_laws(),
            };
            laws.iter().any(|chosen| chosen.columns().contains(&law))
        }
    }
}
