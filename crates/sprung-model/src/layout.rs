//! The parameters of a robot, and their entries in its regressor.

use sprung_core::drives::Term;
use sprung_core::friction::Scale;
use sprung_core::parameters::{JointParameter, Side};
use sprung_core::robot::Share;

use super::deflection_entry::DeflectionEntry;
use super::inertial::Inertial;
use super::links::TreeLinks;
use crate::description::{
    EncoderOffset, Experiment, Instrument, Instrumentation, Joint, LinkPosition, RightHandSide,
    Row, SpringTerm, SpringTorque,
};

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
    /// Joint of each row.
    pub(super) row_joints: Vec<usize>,
    /// Right-hand side of each row.
    pub(super) right_hand_sides: Vec<RightHandSide>,
    /// Entries of stiffnesses in link rows.
    pub(super) deflections: Vec<DeflectionEntry>,
    /// Instrument of each joint.
    instruments: Vec<Instrument>,
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
    /// Returns the rows of the equations of motion.
    pub(super) fn new(
        experiment: &Experiment,
        inertial: &Inertial,
        (links, coupling): (Option<&TreeLinks>, Option<&[f64]>),
        instruments: &Instrumentation,
    ) -> Self {
        let joints = &experiment.robot.joint;
        let n = joints.len();
        let offset = match experiment.identify.encoder_offset {
            Some(choice) => choice == EncoderOffset::Estimate,
            None => links.is_some(),
        };
        let has = |kind: JointParameter, i: usize| match kind {
            JointParameter::RotorInertia => {
                let is_separate = || links.is_none_or(|links| links.has_rotor(i));
                !joints[i].is_on_link_side() && (joints[i].is_flexible() || is_separate())
            }
            JointParameter::TorqueOffset => {
                instruments.at(i).spring_torque() == SpringTorque::Measured
            }
            JointParameter::Stiffness
            | JointParameter::CubicStiffness
            | JointParameter::Damping
            | JointParameter::Hysteresis(_)
            | JointParameter::Preload
            | JointParameter::Friction(..)
            | JointParameter::Change(..)
            | JointParameter::BackEmf => has(
                &joints[i],
                kind,
                offset && instruments.at(i).shows_constant_deflections(),
            ),
        };
        let drives = (JointParameter::ALL.into_iter())
            .flat_map(|kind| (0..n).map(move |i| (kind, i)))
            .filter(|&(kind, i)| has(kind, i))
            .collect();
        let flexible: Vec<bool> = joints.iter().map(Joint::is_flexible).collect();
        Self::of_drives(
            drives,
            (inertial, coupling),
            &flexible,
            joints.iter().map(Instrument::without_log).collect(),
        )
    }

    /// Returns the rows of the regression of the same robot with instruments: the measured torque
    /// of a spring is on the right-hand side of the rows of its link and its motor, and rows of the
    /// springs follow.
    pub(super) fn with_instruments(
        &self,
        inertial: &Inertial,
        coupling: Option<&[f64]>,
        instruments: &Instrumentation,
    ) -> Self {
        let flexible: Vec<bool> = self.motor_rows.iter().map(Option::is_some).collect();
        let drives = self.drives.clone();
        let instruments = instruments.iter().collect();
        Self::of_drives(drives, (inertial, coupling), &flexible, instruments)
    }

    fn of_drives(
        drives: Vec<(JointParameter, usize)>,
        (inertial, coupling): (&Inertial, Option<&[f64]>),
        flexible: &[bool],
        instruments: Vec<Instrument>,
    ) -> Self {
        let n = flexible.len();
        let mut layout = Self {
            drives,
            link_entries: vec![0; n * n],
            instruments,
            ..Self::default()
        };
        let mut next = n;
        for &flexible in flexible {
            layout.motor_rows.push(flexible.then(|| {
                next += 1;
                next - 1
            }));
        }
        for (joint, &flexible) in flexible.iter().enumerate() {
            let columns = layout.link_row(inertial, joint);
            let kind = if flexible { Row::Link } else { Row::Motor };
            layout.drive_row((kind, joint), inertial.len(), coupling, columns);
        }
        for joint in (0..n).filter(|&joint| flexible[joint]) {
            layout.drive_row((Row::Motor, joint), inertial.len(), coupling, Vec::new());
        }
        for joint in 0..n {
            if layout.instruments[joint].rows().contains(&Row::Spring) {
                layout.drive_row((Row::Spring, joint), inertial.len(), coupling, Vec::new());
            }
        }
        layout.row_entries.push(layout.entries);
        // The motion of a joint is read once for all of its terms.
        layout.terms.sort_by_key(|term| term.joint);
        layout
    }

    /// Returns the range of entries of a row.
    pub(super) fn entries_of(&self, row: usize) -> std::ops::Range<usize> {
        self.row_entries[row]..self.row_entries[row + 1]
    }

    /// Returns the joints with friction laws of a scale on either side.
    pub(super) fn joints_with(&self, scale: Scale) -> Vec<usize> {
        let has_scale = |kind: &JointParameter| matches!(kind, JointParameter::Friction(_, law) if law.scale() == scale);
        let has = |joint: &usize| {
            (self.drives.iter()).any(|(kind, other)| other == joint && has_scale(kind))
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

    /// Adds a row: the columns of its links, and the terms of the drives.
    fn drive_row(
        &mut self,
        (kind, joint): (Row, usize),
        inertial: usize,
        coupling: Option<&[f64]>,
        mut columns: Vec<usize>,
    ) {
        let n = self.motor_rows.len();
        let row = self.row_columns.len();
        self.row_entries.push(self.entries - columns.len());
        let instrument = self.instruments[joint];
        let is_measured = instrument.spring_torque() == SpringTorque::Measured;
        (self.right_hand_sides).push(instrument.right_hand_side(kind, joint));
        let flexible = self.motor_rows[joint].is_some();
        for (at, &(what, owner)) in self.drives.iter().enumerate() {
            let ratio = match coupling {
                Some(ratios) => ratios[owner * n + joint],
                None => f64::from(u8::from(owner == joint)),
            };
            let factor = f64::from(u8::from(owner == joint));
            let gain = match (what, kind) {
                (
                    JointParameter::RotorInertia
                    | JointParameter::BackEmf
                    | JointParameter::Friction(Side::Motor, _)
                    | JointParameter::Change(Side::Motor, ..),
                    Row::Motor,
                ) => ratio,
                (
                    JointParameter::Friction(Side::Link, _)
                    | JointParameter::Change(Side::Link, ..),
                    Row::Link,
                ) => factor,
                (
                    JointParameter::Friction(Side::Link, _)
                    | JointParameter::Change(Side::Link, ..),
                    Row::Motor,
                ) if !flexible => factor,
                (
                    JointParameter::RotorInertia
                    | JointParameter::BackEmf
                    | JointParameter::Friction(..)
                    | JointParameter::Change(..),
                    _,
                ) => 0.0,
                // The reading of the sensor is the torque of the spring plus the offset.
                (JointParameter::TorqueOffset, _) if !is_measured => 0.0,
                (JointParameter::TorqueOffset, Row::Motor) => -factor,
                // Terms of the spring.
                (JointParameter::TorqueOffset, _) | (_, Row::Spring) => factor,
                _ if is_measured => 0.0,
                (_, Row::Motor) => factor,
                (_, Row::Link) => -factor,
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
        if row < n {
            self.deflection_entries(row, inertial, &mut columns);
        }
        self.row_columns.push(columns);
        self.row_joints.push(joint);
    }
}

impl Layout {
    /// Adds the stiffnesses that move the links without encoders to the row of a joint.
    fn deflection_entries(&mut self, row: usize, inertial: usize, columns: &mut Vec<usize>) {
        for (at, &(what, joint)) in self.drives.iter().enumerate() {
            let source = self.instruments[joint].link_position();
            if what == JointParameter::Stiffness && source == LinkPosition::ByTorque {
                let column = inertial + at;
                columns.push(column);
                self.deflections.push(DeflectionEntry {
                    row,
                    entry: self.entries,
                    joint,
                    column,
                });
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
        JointParameter::Hysteresis(_) => spring(SpringTerm::Hysteresis),
        JointParameter::Preload => flexible && offset,
        JointParameter::TorqueOffset => false,
        JointParameter::BackEmf => joint.back_emf_vs_per_rad.is_some(),
        JointParameter::Friction(side, law) => {
            let laws = match side {
                Side::Link => joint.link_laws(),
                Side::Motor => joint.motor_laws(),
            };
            laws.iter().any(|chosen| chosen.columns().contains(&law))
        }
        JointParameter::Change(side, law, with) => {
            let friction = JointParameter::Friction(side, law);
            has(joint, friction, offset) && joint.changes(friction, with)
        }
    }
}
