//! Laws of friction and springs that a description gets from a log.

use sprung_core::friction::Family;
use sprung_core::parameters::Side;

use super::result::{AddedLaw, UnknownResult};
use crate::description::{Experiment, FrictionLaw, Joint, Laws, SpringTerm};

/// Returns an experiment with the laws of unknowns that are used. Laws that it has already stay single.
#[must_use]
pub fn with_added_laws(experiment: &Experiment, unknowns: &[UnknownResult]) -> Experiment {
    let used = unknowns.iter();
    let used = used.filter_map(|unknown| Some((unknown.place.as_str(), unknown.used_law()?)));
    with_laws(experiment, used)
}

/// Returns an experiment with further laws, each with the name of its joint.
pub(super) fn with_laws<'a>(
    experiment: &Experiment,
    laws: impl Iterator<Item = (&'a str, &'a AddedLaw)>,
) -> Experiment {
    let mut with = experiment.clone();
    for (name, law) in laws {
        let mut joints = with.robot.joint.iter_mut();
        if let Some(joint) = joints.find(|joint| joint.name == name) {
            *joint = changed(joint.clone(), law);
        }
    }
    with
}

/// Returns whether laws beyond the declared ones may be added to a joint.
pub(super) fn may_add_laws(experiment: &Experiment, joint: usize) -> bool {
    let of_joint = experiment.robot.joint[joint].laws;
    of_joint.unwrap_or(experiment.identify.laws) == Laws::Auto
}

/// Returns the friction laws of a side of a joint.
pub(super) fn laws_of(joint: &Joint, side: Side) -> &[FrictionLaw] {
    match side {
        Side::Link => joint.link_laws(),
        Side::Motor => joint.motor_laws(),
    }
}

/// Returns a joint with a further law; the same joint if the words name none.
///
/// - `of`: `link_friction`, `motor_friction` or `spring`; `law`: name of the law or term.
pub(crate) fn changed(mut joint: Joint, added: &AddedLaw) -> Joint {
    let (of, law) = (added.of.as_str(), added.law.as_str());
    let given = joint.stribeck_velocity_rad_per_s;
    joint.stribeck_velocity_rad_per_s = given.or(added.stribeck_velocity);
    if joint.play_half_width_rad.is_none() {
        joint.play_half_width_rad = added.play_half_width;
        joint.play_centre_rad = joint.play_centre_rad.or(added.play_centre);
    }
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

#[cfg(test)]
mod tests {
    use super::super::result::UnknownStatus;
    use super::*;
    use crate::demo;
    use crate::description::{self, no_files};

    #[test]
    fn used_laws_enter_the_description_once() {
        let experiment =
            description::read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let unknown = |of: &str, law: &str, status| UnknownResult {
            id: format!("law joint1.{of}.{law}"),
            kind: "law".to_owned(),
            place: "joint1".to_owned(),
            value: 0.1,
            standard_error: 0.01,
            unit: "N·m".to_owned(),
            begins_s: None,
            competing: Vec::new(),
            effect: 0.2,
            law: Some(AddedLaw {
                of: of.to_owned(),
                law: law.to_owned(),
                stribeck_velocity: (law == "stribeck").then_some(0.04),
                ..AddedLaw::default()
            }),
            status,
        };
        let found = [
            unknown("motor_friction", "stribeck", UnknownStatus::Applied),
            unknown("link_friction", "viscous-asymmetric", UnknownStatus::Given),
            unknown("spring", "cubic", UnknownStatus::Applied),
            unknown("motor_friction", "quadratic", UnknownStatus::Found),
        ];
        let once = with_added_laws(&experiment, &found);
        let twice = with_added_laws(&once, &found);
        for with in [&once, &twice] {
            let joint = &with.robot.joint[0];
            let names =
                |laws: &[FrictionLaw]| -> Vec<&str> { laws.iter().map(|law| law.name()).collect() };
            assert_eq!(
                names(joint.motor_laws()),
                ["viscous", "coulomb", "stribeck"]
            );
            assert_eq!(names(joint.link_laws()), ["coulomb", "viscous-asymmetric"]);
            assert_eq!(
                joint.spring_terms(),
                [SpringTerm::Linear, SpringTerm::Cubic]
            );
            assert_eq!(joint.stribeck_velocity_rad_per_s, Some(0.04));
            assert!(crate::model::Model::new(with).is_ok());
        }
    }
}
