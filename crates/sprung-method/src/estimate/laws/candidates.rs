//! Laws that a joint can have beyond those of the description, and their columns.

use sprung_core::drives::Term;
use sprung_core::friction::{Family, Law, Shape};
use sprung_core::parameters::{JointParameter, Side};

use crate::description::{Experiment, FrictionLaw, Joint, Quantity, SpringTerm};
use crate::estimate::nuisances::{BLUNTER, SHARPER, sharpness_columns};
use crate::estimate::statistics::SATURATED_ARGUMENT;
use crate::log::{Channel, Channels};
use crate::model::{Model, ModelError};
use crate::regression::Probe;

/// Stribeck velocities that are tried, relative to the root mean square of the joint's velocity.
const STRIBECK_VELOCITIES: [f64; 8] = [0.04, 0.063, 0.1, 0.16, 0.25, 0.4, 0.63, 1.0];

/// A change of a joint's laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// A friction law on one side.
    Friction(Side, Family),
    /// A term of the spring.
    Spring(SpringTerm),
    /// Friction proportional to the measured torque of a rigid joint. No model has this law.
    TorqueLoad,
}

/// Order in which changes are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Tier {
    /// Offset, viscous and Coulomb friction.
    Essential,
    /// Laws with one parameter and a name.
    Named,
    /// Laws for friction that no named law explains.
    Residual,
}

/// A change that a log can require.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Candidate {
    pub(super) joint: usize,
    pub(super) change: Change,
    /// Stribeck velocity of its column, if it has one, rad/s (m/s).
    pub(super) stribeck_velocity: Option<f64>,
    /// Indices of its unknowns.
    pub(super) unknowns: Vec<usize>,
}

impl Candidate {
    pub(super) fn tier(&self) -> Tier {
        match self.change {
            Change::Friction(_, family) => match family {
                Family::Offset | Family::Viscous | Family::Coulomb => Tier::Essential,
                Family::Residual => Tier::Residual,
                Family::ViscousAsymmetric
                | Family::CoulombAsymmetric
                | Family::Stribeck
                | Family::Quadratic
                | Family::Load => Tier::Named,
            },
            Change::Spring(_) | Change::TorqueLoad => Tier::Named,
        }
    }

    /// Returns whether another candidate changes the same law.
    pub(super) fn is_variant_of(&self, other: &Self) -> bool {
        self.joint == other.joint && self.change == other.change
    }
}

/// All candidates of a robot, and their columns.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates {
    pub(super) all: Vec<Candidate>,
    /// Columns, each with the index of its unknown.
    pub(super) probes: Vec<(Probe, usize)>,
    /// Unknowns of no law: a torque that acts later or earlier than logged or saturates, and Coulomb friction of
    /// another sharpness. A law has to explain more than they do.
    pub(super) nuisances: Vec<usize>,
    unknowns: usize,
}

impl Candidates {
    /// - `speeds`: root mean square of each joint's velocity, rad/s (m/s).
    ///
    /// # Errors
    ///
    /// [`ModelError`] if the robot with all laws has no model.
    pub(super) fn new(
        experiment: &Experiment,
        model: &Model,
        channels: &Channels,
        speeds: &[f64],
    ) -> Result<Self, ModelError> {
        let everything = Model::new(&with_all_laws(experiment))?;
        let terms = everything.robot().terms.to_vec();
        let mut found = Self::default();
        for (joint, described) in experiment.robot.joint.iter().enumerate() {
            if speeds[joint] > 0.0 {
                found.of_joint(joint, described, model, &terms, speeds[joint]);
                found.of_torque(experiment, joint, described, model);
                found.of_measured_torque(experiment, joint, model, channels);
                found.of_sharpness(joint, model, &terms);
            }
        }
        Ok(found)
    }

    fn of_joint(
        &mut self,
        joint: usize,
        described: &Joint,
        model: &Model,
        terms: &[Term],
        speed: f64,
    ) {
        let shape = Shape {
            residual_velocity: 2.0 * speed,
            ..*model.shape(joint)
        };
        for side in [Side::Motor, Side::Link] {
            if side == Side::Link && !described.is_flexible() {
                continue;
            }
            for (family, laws) in missing_friction(described, side) {
                let change = Change::Friction(side, family);
                let kinds = laws.iter().map(|law| JointParameter::Friction(side, *law));
                let kinds: Vec<JointParameter> = kinds.collect();
                if family != Family::Stribeck {
                    self.add(joint, change, &kinds, terms, &shape, None);
                    continue;
                }
                for share in STRIBECK_VELOCITIES {
                    // The Coulomb transition masks Stribeck friction of a lower velocity.
                    let velocity = share * speed;
                    if velocity * shape.sharpness < SATURATED_ARGUMENT {
                        continue;
                    }
                    let shape = Shape {
                        stribeck_velocity: velocity,
                        ..shape
                    };
                    self.add(joint, change, &kinds, terms, &shape, Some(velocity));
                }
            }
        }
        for (term, kind) in [
            (SpringTerm::Cubic, JointParameter::CubicStiffness),
            (SpringTerm::Damping, JointParameter::Damping),
        ] {
            if described.is_flexible() && !described.spring_terms().contains(&term) {
                self.add(joint, Change::Spring(term), &[kind], terms, &shape, None);
            }
        }
    }

    /// Adds a candidate with one unknown for each kind of parameter.
    fn add(
        &mut self,
        joint: usize,
        change: Change,
        kinds: &[JointParameter],
        terms: &[Term],
        shape: &Shape,
        stribeck_velocity: Option<f64>,
    ) {
        let mut unknowns = Vec::new();
        for &kind in kinds {
            let of_joint = terms
                .iter()
                .filter(|term| term.joint == joint && term.what == kind);
            self.probes
                .extend(of_joint.map(|term| (Probe::Term(*term, *shape), self.unknowns)));
            unknowns.push(self.unknowns);
            self.unknowns += 1;
        }
        self.all.push(Candidate {
            joint,
            change,
            stribeck_velocity,
            unknowns,
        });
    }

    /// Adds the candidate that uses the measured torque of a rigid joint.
    fn of_torque(
        &mut self,
        experiment: &Experiment,
        joint: usize,
        described: &Joint,
        model: &Model,
    ) {
        if experiment.robot.transmission_matrix.is_some() || described.is_flexible() {
            return;
        }
        let probe = Probe::TorqueLoad {
            row: model.torque_row(joint),
            joint,
            sharpness: model.sharpness(joint),
        };
        self.probes.push((probe, self.unknowns));
        self.all.push(Candidate {
            joint,
            change: Change::TorqueLoad,
            stribeck_velocity: None,
            unknowns: vec![self.unknowns],
        });
        self.unknowns += 1;
    }

    fn of_measured_torque(
        &mut self,
        experiment: &Experiment,
        joint: usize,
        model: &Model,
        channels: &Channels,
    ) {
        if experiment.robot.transmission_matrix.is_some() || !has_torque(channels, joint) {
            return;
        }
        let row = model.torque_row(joint);
        for probe in [Probe::TorqueRate { row }, Probe::TorqueCube { row, joint }] {
            self.probes.push((probe, self.unknowns));
            self.nuisances.push(self.unknowns);
            self.unknowns += 1;
        }
    }

    fn of_sharpness(&mut self, joint: usize, model: &Model, terms: &[Term]) {
        if !model.open_sharpness().contains(&joint) {
            return;
        }
        let of = |ratio: f64| sharpness_columns(model, joint, terms, ratio);
        for column in [SHARPER, BLUNTER].into_iter().flat_map(of) {
            let probes = column.probes.into_iter();
            self.probes
                .extend(probes.map(|probe| (probe, self.unknowns)));
            self.nuisances.push(self.unknowns);
            self.unknowns += 1;
        }
    }
}

fn has_torque(channels: &Channels, joint: usize) -> bool {
    let is_motor_torque =
        |channel: &Channel| channel.quantity == Quantity::MotorTorque && channel.joint == joint;
    channels.all.iter().any(is_motor_torque)
}

fn laws_of(joint: &Joint, side: Side) -> &[FrictionLaw] {
    match side {
        Side::Link => joint.link_laws(),
        Side::Motor => joint.motor_laws(),
    }
}

/// Returns the friction laws that a side of a joint lacks, each with the columns that it adds.
fn missing_friction(joint: &Joint, side: Side) -> Vec<(Family, &'static [Law])> {
    let laws = laws_of(joint, side);
    let has = |family: Family| laws.contains(&FrictionLaw(family));
    let added = |family: Family| -> Option<&'static [Law]> {
        let (excluded, laws) = match family {
            Family::Offset | Family::Coulomb => (has(Family::CoulombAsymmetric), family.laws()),
            Family::Viscous => (has(Family::ViscousAsymmetric), family.laws()),
            Family::ViscousAsymmetric => (
                has(Family::Residual) || !has(Family::Viscous),
                // With the viscous law it spans both directions.
                &[Law::ViscousPositive][..],
            ),
            // Coulomb friction and an offset span it.
            Family::CoulombAsymmetric => (true, family.laws()),
            Family::Stribeck => (false, family.laws()),
            Family::Quadratic => (has(Family::Residual), family.laws()),
            Family::Load => (!joint.is_flexible(), family.laws()),
            Family::Residual => (
                has(Family::Quadratic) || has(Family::ViscousAsymmetric),
                family.laws(),
            ),
        };
        (!has(family) && !excluded).then_some(laws)
    };
    (Family::ALL.iter())
        .filter_map(|&family| Some((family, added(family)?)))
        .collect()
}

/// Returns the experiment with every law in every joint; only its equations are used.
fn with_all_laws(experiment: &Experiment) -> Experiment {
    let mut all = experiment.clone();
    for joint in &mut all.robot.joint {
        let friction: Vec<FrictionLaw> = Family::ALL.iter().copied().map(FrictionLaw).collect();
        if joint.is_flexible() {
            joint.link_friction = Some(friction.clone());
            joint.spring = Some(vec![
                SpringTerm::Linear,
                SpringTerm::Cubic,
                SpringTerm::Damping,
            ]);
        }
        joint.motor_friction = Some(friction);
    }
    all
}

/// Returns a joint with a further law; the same joint if the words name none.
///
/// - `of`: `link_friction`, `motor_friction` or `spring`; `law`: name of the law or term.
/// - `velocity`: velocity of Stribeck friction, rad/s (m/s).
pub(super) fn changed(mut joint: Joint, of: &str, law: &str, velocity: Option<f64>) -> Joint {
    joint.stribeck_velocity_rad_per_s = joint.stribeck_velocity_rad_per_s.or(velocity);
    if of == "spring" {
        let mut terms = joint.spring_terms().to_vec();
        let term = SpringTerm::try_from(law.to_owned());
        terms.extend(
            term.into_iter()
                .filter(|term| !joint.spring_terms().contains(term)),
        );
        joint.spring = Some(terms);
        return joint;
    }
    let side = match of {
        "link_friction" => Side::Link,
        "motor_friction" => Side::Motor,
        _ => return joint,
    };
    let mut laws = laws_of(&joint, side).to_vec();
    if law == Family::ViscousAsymmetric.word() {
        laws.retain(|law| law.0 != Family::Viscous);
    }
    let law = FrictionLaw::try_from(law.to_owned());
    laws.extend(
        law.into_iter()
            .filter(|law| !laws_of(&joint, side).contains(law)),
    );
    match side {
        Side::Link => joint.link_friction = Some(laws),
        Side::Motor => joint.motor_friction = Some(laws),
    }
    joint
}
