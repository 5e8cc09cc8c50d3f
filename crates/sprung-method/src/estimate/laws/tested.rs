//! Laws that the likelihood tests after a refinement.

use sprung_core::friction::{Family, Law};
use sprung_core::parameters::{JointParameter, Side};

use crate::description::Experiment;
use crate::estimate::statistics::SATURATED_ARGUMENT;
use crate::model::{Model, ModelError};
use crate::unknowns::{AddedLaw, changed};

/// Stribeck velocity of the tested law, relative to the root mean square of the joint's velocity,
/// and least argument of `tanh(beta v)` at this velocity.
const STRIBECK_OVER_SPEED: f64 = 0.15;

/// Word of the cubic term of a spring.
const CUBIC: &str = "cubic";

/// A law that the model lacks.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::estimate) struct Tested {
    /// Joint, from 0.
    pub(in crate::estimate) joint: usize,
    /// Key of the joint in the description, and the word of the law.
    pub(in crate::estimate) of: &'static str,
    pub(in crate::estimate) law: &'static str,
    /// Index of its parameter in the model with all tested laws.
    pub(in crate::estimate) parameter: usize,
}

/// Returns the friction laws of motors that are tested, each with its family.
fn tested_friction() -> impl Iterator<Item = (Family, Law)> {
    (Family::ALL.iter()).filter_map(|&family| match family {
        Family::Offset | Family::Stribeck | Family::Load => Some((family, family.laws()[0])),
        // Viscous and Coulomb friction are part of every model that the refinement runs; the others
        // have several parameters, or replace a law of the model.
        Family::Viscous
        | Family::Coulomb
        | Family::ViscousAsymmetric
        | Family::CoulombAsymmetric
        | Family::Quadratic
        | Family::Presliding => None,
    })
}

/// Returns the model with further laws of all flexible joints, and these laws: cubic springs, and
/// offset, Stribeck and load-dependent friction of the motors.
///
/// - `model`: the model without them; `speeds`: root mean square of each joint's velocity, rad/s
///   (m/s).
///
/// # Errors
///
/// [`ModelError`] if the robot with these laws has no model.
pub(in crate::estimate) fn with_tested_laws(
    experiment: &Experiment,
    model: &Model,
    speeds: &[f64],
) -> Result<(Model, Vec<Tested>), ModelError> {
    let mut richer = experiment.clone();
    let mut kinds: Vec<(usize, &'static str, &'static str, JointParameter)> = Vec::new();
    for (joint, described) in richer.robot.joint.iter_mut().enumerate() {
        if !described.is_flexible() || speeds[joint] <= 0.0 {
            continue;
        }
        let mut add = |of: &'static str, law: &'static str, kind| {
            let velocity = (STRIBECK_OVER_SPEED * speeds[joint])
                .max(SATURATED_ARGUMENT / model.sharpness(joint));
            let is_stribeck = law == Family::Stribeck.word();
            let added = AddedLaw {
                of: str::to_owned(of),
                law: str::to_owned(law),
                stribeck_velocity: is_stribeck.then_some(velocity),
                ..AddedLaw::default()
            };
            *described = changed(described.clone(), &added);
            kinds.push((joint, of, law, kind));
        };
        let lacks = |kind: JointParameter| model.index(kind, joint).is_none();
        if lacks(JointParameter::CubicStiffness) {
            add("spring", CUBIC, JointParameter::CubicStiffness);
        }
        for (family, law) in tested_friction() {
            let kind = JointParameter::Friction(Side::Motor, law);
            if lacks(kind) {
                add("motor_friction", family.word(), kind);
            }
        }
    }
    let richer = Model::new(&richer)?.with_velocities_of(model);
    let tested = (kinds.into_iter())
        .filter_map(|(joint, of, law, kind)| {
            let parameter = richer.index(kind, joint)?;
            Some(Tested {
                joint,
                of,
                law,
                parameter,
            })
        })
        .collect();
    Ok((richer, tested))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{self, FrictionLaw, SpringTerm, no_files};

    #[test]
    fn the_words_of_tested_laws_are_those_of_the_description() {
        assert_eq!(
            SpringTerm::try_from(CUBIC.to_owned()),
            Ok(SpringTerm::Cubic)
        );
        for (family, _) in tested_friction() {
            assert_eq!(
                FrictionLaw::try_from(family.word().to_owned()),
                Ok(FrictionLaw(family))
            );
        }
        let experiment =
            description::read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let (richer, tested) = with_tested_laws(&experiment, &model, &[0.2, 0.3]).unwrap();
        assert_eq!(tested.len(), 8);
        for law in &tested {
            let name = &richer.parameters()[law.parameter].name;
            assert!(model.index_of(name).is_err(), "{name}");
        }
        // A joint that stands still has no tested law.
        let (_, tested) = with_tested_laws(&experiment, &model, &[0.0, 0.3]).unwrap();
        assert!(tested.len() == 4 && tested.iter().all(|law| law.joint == 1));
    }
}
