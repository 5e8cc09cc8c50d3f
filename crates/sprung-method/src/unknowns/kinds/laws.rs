//! Laws with one coefficient that a joint may have beyond those of its description. They compete with the other causes.

use sprung_core::drives::Term;
use sprung_core::friction::{Family, Law, Shape};
use sprung_core::parameters::{JointParameter, Side};

use super::catalogued::Catalogued;
use super::words::{falls, or_else};
use crate::description::{Experiment, FrictionLaw, Joint, SpringTerm};
use crate::finding::{Finding, Severity};
use crate::model::Model;
use crate::unknowns::added_law::laws_of;
use crate::unknowns::found::Telling;
use crate::unknowns::result::{AddedLaw, UnknownStatus};
use crate::unknowns::unknown::{
    Effect, Kind, LawColumn, MotorSample, OfMotor, Place, ShownBy, Unknown,
};

/// Code of the finding that laws would predict the log better.
pub(crate) const LAWS_MISSING: &str = "laws-missing";

/// Part of a joint's torque below which a law matters to nobody, and a constant torque.
const LEAST_SHARE: f64 = 0.01;
const LEAST_CONSTANT: f64 = 0.02;

/// Stribeck velocities that are tried, relative to the root mean square of the joint's velocity.
const STRIBECK_VELOCITIES: [f64; 5] = [0.06, 0.12, 0.25, 0.5, 1.0];

/// Least argument of `tanh(beta v)` at a Stribeck velocity: the Coulomb transition masks Stribeck friction of a lower one.
const SATURATED_ARGUMENT: f64 = 2.0;

/// Fall of the error of the torques (root mean square) from which on a law that is not applied is a warning.
const LARGE_FALL: f64 = 0.08;

/// Usual part of the torque that this friction takes. The torque of a joint that only overcomes friction is its own column, with a part of
/// nearly one.
const USUAL_LOAD: f64 = 0.05;

/// Part of the motion in which the torque must brake it, or else this friction is a gain of the torque.
const LEAST_BRAKING: f64 = 0.02;

/// Key without a law of the description.
const TORQUE_LOAD: &str = "friction proportional to the torque";

/// Friction of a gear that transmits a load, with the measured torque as the load.
fn load(sample: &MotorSample<'_>) -> f64 {
    sample.torque.abs() * (sample.scales.sharpness * sample.velocity).tanh()
}

/// Lists laws of one joint.
struct OfJoint<'a> {
    model: &'a Model,
    /// The model with every law in every joint.
    everything: &'a Model,
    joint: usize,
    name: &'a str,
    described: &'a Joint,
    /// Root mean square of the velocity, rad/s (m/s).
    speed: f64,
    /// Part of the motion in which the torque brakes it.
    braking: f64,
    /// Part of the torque that a count of an encoder makes.
    count_share: f64,
}

impl OfJoint<'_> {
    fn law(&self, of: &str, law: &str, column: LawColumn) -> Unknown {
        let id = format!("law {}.{of}.{law}", self.name);
        Unknown {
            least: LEAST_SHARE,
            ..Unknown::new(
                id.trim_end_matches('.').to_owned(),
                Kind::Law,
                Place::Joint(self.joint),
                "",
                Effect::Law {
                    column,
                    added: Some(AddedLaw {
                        of: of.to_owned(),
                        law: law.to_owned(),
                        ..AddedLaw::default()
                    }),
                },
            )
        }
    }

    /// Returns the law of one parameter, with its terms in all rows.
    fn of_parameter(&self, of: &str, law: &str, kind: JointParameter, shape: Shape) -> Unknown {
        let of_joint = |term: &&Term| term.joint == self.joint && term.what == kind;
        let terms = self.everything.robot().terms.iter().filter(of_joint);
        let column = LawColumn::Terms(terms.map(|term| (*term, shape)).collect());
        let parameter = self.everything.index(kind, self.joint);
        Unknown {
            is_positive: kind.is_friction() || kind == JointParameter::Damping,
            unit: parameter.map_or("", |at| self.everything.parameters()[at].unit),
            ..self.law(of, law, column)
        }
    }

    fn friction(&self, side: Side, family: Family, law: Law) -> Vec<Unknown> {
        let of = match side {
            Side::Link => "link_friction",
            Side::Motor => "motor_friction",
        };
        let shape = *self.model.shape(self.joint);
        let is_of_spring_motor = side == Side::Motor && self.described.is_flexible();
        let is_certain = matches!(law, Law::Offset | Law::Stribeck | Law::Load);
        let with_shape = |shape: Shape| {
            let kind = JointParameter::Friction(side, law);
            Unknown {
                shown_by: if is_of_spring_motor && is_certain {
                    ShownBy::Both
                } else {
                    ShownBy::Rows
                },
                ..self.of_parameter(of, FrictionLaw(family).name(), kind, shape)
            }
        };
        match law {
            Law::Offset => vec![Unknown {
                least: LEAST_CONSTANT.max(self.count_share),
                ..with_shape(shape)
            }],
            Law::Stribeck => (STRIBECK_VELOCITIES.iter())
                .map(|share| share * self.speed)
                .filter(|velocity| velocity * shape.sharpness >= SATURATED_ARGUMENT)
                .map(|stribeck_velocity| {
                    let shape = Shape {
                        stribeck_velocity,
                        ..shape
                    };
                    with_shape(shape).with_stribeck_velocity(stribeck_velocity)
                })
                .collect(),
            // Beside the viscous law its coefficient is the difference of both directions.
            Law::ViscousPositive => vec![Unknown {
                is_positive: false,
                ..with_shape(shape)
            }],
            _ => vec![with_shape(shape)],
        }
    }

    fn all(&self) -> Vec<Unknown> {
        let (mut all, shape) = (Vec::new(), *self.model.shape(self.joint));
        let is_flexible = self.described.is_flexible();
        let has = |term| self.described.spring_terms().contains(&term);
        if is_flexible && !has(SpringTerm::Damping) {
            all.push(self.of_parameter("spring", "damping", JointParameter::Damping, shape));
        }
        if is_flexible && !has(SpringTerm::Cubic) {
            all.push(Unknown {
                shown_by: ShownBy::Both,
                ..self.of_parameter("spring", "cubic", JointParameter::CubicStiffness, shape)
            });
        }
        for side in [Side::Motor, Side::Link] {
            let has_side = match side {
                Side::Motor => !self.described.is_on_link_side(),
                Side::Link => is_flexible || self.described.is_on_link_side(),
            };
            if has_side {
                let missing = missing_friction(self.described, side).into_iter();
                all.extend(missing.flat_map(|(family, law)| self.friction(side, family, law)));
            }
        }
        let brakes = self.braking >= LEAST_BRAKING;
        if brakes && !is_flexible && self.model.robot().coupling.is_none() {
            all.push(Unknown {
                scale: USUAL_LOAD,
                is_positive: true,
                ..self.law(TORQUE_LOAD, "", LawColumn::Motor(OfMotor::new(load)))
            });
        }
        all
    }
}

/// Returns the laws that joints which move may lack.
pub(super) fn list(of: &Catalogued<'_>) -> Vec<Unknown> {
    // A law that a robot lacks, it lacked before.
    if of.is_known {
        return Vec::new();
    }
    let Ok(everything) = Model::new(&with_all_laws(of.experiment)) else {
        return Vec::new();
    };
    let of_joint = |(joint, described): (usize, &Joint)| {
        let of_joint = OfJoint {
            model: of.model,
            everything: &everything,
            joint,
            name: &of.names[joint],
            described,
            speed: of.speeds[joint],
            braking: of.braking(joint),
            count_share: of.count_share(joint),
        };
        if of_joint.speed > 0.0 {
            of_joint.all()
        } else {
            Vec::new()
        }
    };
    let joints = of.experiment.robot.joint.iter().enumerate();
    joints.flat_map(of_joint).collect()
}

/// Returns the friction laws with one coefficient that a side of a joint lacks.
fn missing_friction(joint: &Joint, side: Side) -> Vec<(Family, Law)> {
    let laws = laws_of(joint, side);
    let has = |family: Family| laws.contains(&FrictionLaw(family));
    let added = |family: Family| {
        let (excluded, law) = match family {
            Family::Offset => (has(Family::CoulombAsymmetric), Law::Offset),
            Family::Coulomb => (has(Family::CoulombAsymmetric), Law::Coulomb),
            Family::Viscous => (has(Family::ViscousAsymmetric), Law::Viscous),
            // With the viscous law it spans both directions.
            Family::ViscousAsymmetric => (!has(Family::Viscous), Law::ViscousPositive),
            Family::Stribeck => (false, Law::Stribeck),
            Family::Quadratic => (false, Law::Quadratic),
            Family::Load => (!joint.is_flexible(), Law::Load),
            // Coulomb friction and an offset span the first; the second has several coefficients, which are judged together.
            Family::CoulombAsymmetric | Family::Presliding => return None,
        };
        (!has(family) && !excluded).then_some((family, law))
    };
    (Family::ALL.iter())
        .filter_map(|&family| added(family))
        .collect()
}

/// Returns the experiment with every law in every joint; only its equations are used.
fn with_all_laws(experiment: &Experiment) -> Experiment {
    let mut all = experiment.clone();
    for joint in &mut all.robot.joint {
        let friction: Vec<FrictionLaw> = Family::ALL.iter().copied().map(FrictionLaw).collect();
        if joint.is_flexible() || joint.is_on_link_side() {
            joint.link_friction = Some(friction.clone());
        }
        if joint.is_flexible() {
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

/// Finding: the description lacks a law, and sprung does not add it.
pub(super) fn finding(of: &Telling<'_>) -> Option<Finding> {
    let law = of
        .found
        .law
        .as_ref()
        .filter(|_| of.status == UnknownStatus::Found)?;
    let column = of.columns.first().copied().unwrap_or_default();
    if of.moves.is_some() {
        let text = format!(
            "{}: the likelihood asks for {}, which the model lacks ({:.1} standard errors from zero): {}",
            of.joint,
            law.words(),
            of.found.value.abs() / of.found.standard_error,
            falls(of)
        );
        let remedy = "add the law to the joint; the parameters of this joint contain the effect";
        let finding = Finding::new(Severity::Warning, "law-by-likelihood", text, remedy);
        return Some(finding.seen(of.file, column, of.found.value, of.found.unit));
    }
    let text = format!(
        "{}: the description lacks a law that looks like {}: with it {}{}",
        of.joint,
        law.words(),
        falls(of),
        or_else(of)
    );
    let severity = if of.found.fall > LARGE_FALL {
        Severity::Warning
    } else {
        Severity::Info
    };
    let finding = if of.is_addable {
        Finding::new(
            severity,
            LAWS_MISSING,
            text,
            "set laws = \"auto\", or add the law to the joint",
        )
        .mended_by("[identify]", "laws = \"auto\"")
    } else {
        Finding::new(
            severity,
            LAWS_MISSING,
            text,
            "add the law to its joint if the robot has it; a delay of a position looks like damping of a spring",
        )
    };
    Some(finding.seen(of.file, column, of.found.value, of.found.unit))
}
