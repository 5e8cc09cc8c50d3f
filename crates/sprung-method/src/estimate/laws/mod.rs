//! Laws of friction and springs: cross-validation of laws beyond those of the description.

mod by_likelihood;
mod candidates;
mod dependence;
mod ladder;
mod law_set;
mod normal;
mod tested;

use crate::estimate::statistics::{LARGE_SHARE, NEGLIGIBLE_SHARE, SMALL_SHARE};
use crate::numbers::in_percent;
use candidates::{Candidate, Candidates, Change, Tier, changed};
use ladder::{Ladder, Rung};
use law_set::{laws_of, names, words};
use normal::Normal;

pub(super) use by_likelihood::FoundVelocity;
pub(super) use dependence::dependence;
pub(super) use law_set::Chosen;
pub(super) use tested::{Tested, with_tested_laws};

use crate::description::{Experiment, Laws, SpringTerm};
use crate::estimate::result::{LawRung, LawsByHoldOut};
use crate::finding::{Finding, Severity};
use crate::prepare::{Prepared, rms_speeds};
use crate::regression::Reduction;
use crate::unknowns::LAWS_MISSING;

/// Gain of one law, as a fraction of the held-out residual of its joint's rows, above which missing laws are a warning
/// although the whole torque gains less than [`LARGE_SHARE`].
const LARGE_GAIN_OF_JOINT: f64 = 0.08;

/// Climbs the ladder of laws on the beginning of the first log.
///
/// The regression is formed once, with a column for each law that a joint can have. Each step adds the law whose column
/// decreases the held-out residual of its joint's rows most, as long as the gain is 3 times its standard deviation over
/// the parts of the log and at least 5 % for a law that is added, 1 % for one that is named. Offset, viscous and
/// Coulomb friction come first. Residual laws come last and only with the setting `"auto"`.
///
/// Returns `None` if the log is too short for parts.
pub(super) fn choose_laws(prepared: &Prepared) -> Option<Chosen> {
    let (experiment, reading) = (prepared.experiment(), prepared.reading());
    let (model, channels) = (reading.model(), reading.channels());
    let speeds = rms_speeds(reading, prepared.excerpt());
    let found = Candidates::new(experiment, model, channels, &speeds).ok()?;
    let probes: Vec<_> = found.probes.iter().map(|(probe, _)| *probe).collect();
    let rows: Vec<usize> = (0..model.rows()).collect();
    let empty = Reduction::with_probes(model, &rows, &probes).without_samples();
    let signals = prepared.excerpt().smoothed(reading)?;
    let system = signals.reduce_by(empty, reading)?;
    let normal = Normal::new(model, &system, &found.probes)?;
    let rows: Vec<[usize; 2]> = (0..model.joint_count())
        .map(|joint| [joint, model.torque_row(joint)])
        .collect();
    let mut ladder = Ladder::new(&normal, (&found.all, &found.nuisances), &rows)?;
    let auto = |candidate: &Candidate| {
        // Damping of a spring has the same column as a delay of its deflection.
        let is_told = match candidate.change {
            Change::TorqueLoad | Change::Spring(SpringTerm::Damping) => false,
            Change::Friction(..) | Change::Spring(_) => true,
        };
        // Link positions by accelerometers have errors that resemble laws.
        let is_direct = channels.inertial.is_none();
        is_told && is_direct && laws_of(experiment, candidate.joint) == Laws::Auto
    };
    ladder.climb(
        (&[Tier::Essential, Tier::Named, Tier::Residual], SMALL_SHARE),
        auto,
    );
    let made = ladder.rungs.len();
    ladder.climb((&[Tier::Essential, Tier::Named], NEGLIGIBLE_SHARE), |_| {
        true
    });
    Some(describe(prepared, &found, &ladder, made))
}

fn describe(prepared: &Prepared, found: &Candidates, ladder: &Ladder<'_>, made: usize) -> Chosen {
    let experiment = prepared.experiment();
    let joints = prepared.reading().model().joints();
    let rung = |(index, rung): (usize, &Rung)| {
        let candidate = &found.all[rung.candidate];
        let (of, law) = names(candidate.change);
        let mut alike: Vec<String> = (rung.alike.iter())
            .map(|&other| words(found.all[other].change))
            .collect();
        alike.dedup();
        LawRung {
            joint: joints[candidate.joint].clone(),
            of: of.to_owned(),
            law: law.to_owned(),
            gain: rung.gain,
            gain_scatter: rung.scatter,
            held_out: rung.held_out,
            stribeck_velocity: rung.stribeck_velocity,
            stribeck_velocity_error: None,
            not_told_apart_from: alike,
            made: index < made,
            earlier: false,
        }
    };
    let result = LawsByHoldOut {
        held_out: ladder.before,
        rungs: ladder.rungs.iter().enumerate().map(rung).collect(),
        ended: "no other law decreases the held-out residual of its joint by 1 % and by 3 times \
                the scatter over the parts of the log"
            .to_owned(),
    };
    Chosen {
        finding: finding(&result, experiment.identify.laws),
        open_velocities: open_velocities(experiment, &result),
        experiment: (result.rungs.iter().any(|rung| rung.made))
            .then(|| with_found_laws(experiment, &result)),
        result,
    }
}

/// Returns the joints whose Stribeck velocity the ladder found and the description does not give.
fn open_velocities(experiment: &Experiment, result: &LawsByHoldOut) -> Vec<usize> {
    let has_found = |name: &str| {
        let mut rungs = result.rungs.iter().filter(|rung| rung.made);
        rungs.any(|rung| rung.joint == name && rung.stribeck_velocity.is_some())
    };
    (experiment.robot.joint.iter().enumerate())
        .filter(|(_, joint)| joint.stribeck_velocity_rad_per_s.is_none() && has_found(&joint.name))
        .map(|(index, _)| index)
        .collect()
}

/// Returns an experiment with the laws that a ladder added. Laws that it has already
/// stay single.
#[must_use]
pub fn with_found_laws(experiment: &Experiment, found: &LawsByHoldOut) -> Experiment {
    let mut with = experiment.clone();
    for rung in found.rungs.iter().filter(|rung| rung.made) {
        let joints = &mut with.robot.joint;
        if let Some(joint) = joints.iter_mut().find(|joint| joint.name == rung.joint) {
            let velocity = rung.stribeck_velocity;
            *joint = changed(joint.clone(), &rung.of, &rung.law, velocity);
        }
    }
    with
}

/// Returns the finding about laws that cross-validation selects and that were not added.
fn finding(result: &LawsByHoldOut, laws: Laws) -> Option<Finding> {
    let missing: Vec<&LawRung> = result.rungs.iter().filter(|rung| !rung.made).collect();
    let last = missing.last()?;
    let made = result.rungs.iter().rfind(|rung| rung.made);
    let before = made.map_or(result.held_out, |rung| rung.held_out);
    let all: Vec<String> = (missing.iter())
        .map(|rung| {
            let alike = match &rung.not_told_apart_from[..] {
                [] => String::new(),
                others => format!(", or {}", others.join(" or ")),
            };
            format!(
                "{}: {}{alike} ({:.0} % less in its rows)",
                rung.joint,
                rung.words(),
                in_percent(rung.gain)
            )
        })
        .collect();
    let large = last.held_out < (1.0 - LARGE_SHARE) * before
        || last.held_out <= before && missing.iter().any(|rung| rung.gain > LARGE_GAIN_OF_JOINT);
    let severity = if large {
        Severity::Warning
    } else {
        Severity::Info
    };
    let text = format!(
        "parts of the log that the fit has not seen are predicted better with laws that the model lacks: {}; together \
         they change the held-out residual of the torque from {:.2} % to {:.2} %",
        all.join("; "),
        in_percent(before),
        in_percent(last.held_out)
    );
    Some(match laws {
        Laws::Declared => Finding::new(
            severity,
            LAWS_MISSING,
            text,
            "set laws = \"auto\", or add the laws to the joints",
        )
        .mended_by("[identify]", "laws = \"auto\""),
        Laws::Auto => Finding::new(
            severity,
            LAWS_MISSING,
            text,
            "add a law to its joint if the robot has it; a delay of a position looks like damping of a spring",
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::description::{self, FrictionLaw, no_files};

    fn rung(of: &str, law: &str, made: bool) -> LawRung {
        LawRung {
            joint: "joint1".to_owned(),
            of: of.to_owned(),
            law: law.to_owned(),
            gain: 0.3,
            gain_scatter: 0.02,
            held_out: 0.03,
            not_told_apart_from: Vec::new(),
            stribeck_velocity: (law == "stribeck").then_some(0.04),
            stribeck_velocity_error: None,
            made,
            earlier: false,
        }
    }

    fn found(rungs: Vec<LawRung>) -> LawsByHoldOut {
        LawsByHoldOut {
            held_out: 0.08,
            rungs,
            ended: String::new(),
        }
    }

    #[test]
    fn laws_that_were_made_enter_the_description_once() {
        let experiment =
            description::read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let found = found(vec![
            rung("motor_friction", "stribeck", true),
            rung("link_friction", "viscous-asymmetric", true),
            rung("spring", "cubic", true),
            rung("motor_friction", "quadratic", false),
        ]);
        let once = with_found_laws(&experiment, &found);
        let twice = with_found_laws(&once, &found);
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

    #[test]
    fn only_laws_that_were_not_made_are_missing() {
        assert!(finding(&found(Vec::new()), Laws::Declared).is_none());
        assert!(finding(&found(vec![rung("spring", "cubic", true)]), Laws::Declared).is_none());
        let small = LawRung {
            gain: 0.03,
            ..rung("motor_friction", "quadratic", false)
        };
        let missing = finding(
            &found(vec![rung("spring", "cubic", true), small.clone()]),
            Laws::Declared,
        );
        let missing = missing.unwrap();
        assert_eq!(missing.code, "laws-missing");
        assert!(
            missing
                .text
                .contains("joint1: motor_friction \"quadratic\"")
        );
        assert_eq!(missing.severity, Severity::Info);
        let large = LawRung {
            gain: 0.09,
            ..small
        };
        let missing = finding(
            &found(vec![rung("spring", "cubic", true), large]),
            Laws::Declared,
        )
        .unwrap();
        assert_eq!(missing.severity, Severity::Warning);
        let no_torque = LawRung {
            held_out: 0.081,
            ..rung("link_friction", "offset", false)
        };
        let missing = finding(&found(vec![no_torque]), Laws::Declared).unwrap();
        assert_eq!(missing.severity, Severity::Info);
        let all = finding(&found(vec![rung("spring", "cubic", false)]), Laws::Declared).unwrap();
        assert_eq!(all.severity, Severity::Warning);
    }
}
