//! Laws of the joints, judged on held-out parts of the log with the filters of the description.

use std::borrow::Cow;
use std::ops::Range;

use sprung_core::chain::JointKind;
use sprung_core::friction::{Family, Scale};
use sprung_core::parameters::{JointParameter, Side};

use super::added_law::{laws_of, may_add_laws};
use super::evidence::{PARTS, mean_and_error};
use super::found::Found;
use super::law_columns::{Judged, LawColumns};
use super::result::AddedLaw;
use super::unknown::{Kind, Place};
use crate::description::{FrictionLaw, Weights};
use crate::log::Channels;
use crate::model::Model;
use crate::prepare::{Prepared, rms_speeds};
use crate::regression::Reading;

/// Least fall of the error of a joint's torques (root mean square) by its laws. The smearing of the filters fakes 4 %.
const LEAST_FALL: f64 = 0.05;

/// Least fall of the errors of all joints (mean of their logarithms) by presliding friction, and the same over its standard error.
/// Twins without it show up to 0.09, because encoders of 4096 counts and disturbances of the torques resemble it; robots with it
/// show 0.13 to 0.2. Between motor and link encoder drifts and lost counts resemble it more, up to 0.47; flexible joints with it
/// show 0.7 to 3.
const LEAST_FALL_BY_PRESLIDING: f64 = 0.12;
const LEAST_FALL_OF_FLEXIBLE: f64 = 0.5;
const LEAST_SIGNIFICANCE: f64 = 2.0;

/// Least standard error of the sum of its coefficients, relative to the sum and absolute, N·m (N): coefficients that are not negative
/// may be zero without each part.
const LEAST_ERROR: f64 = 1e-3;
const LEAST_TORQUE: f64 = 1e-6;

/// Returns the reading with delays and sharpness that were found, in which all samples count alike.
fn reading_with(found: &[Found], prepared: &Prepared) -> Reading {
    let reading = prepared.reading().without_weights();
    let reading = reading.with_delays(&with_found(&reading, found));
    let model = sharpened(reading.model().clone(), found, reading.channels());
    reading.with_model(model)
}

fn added(one: &Found, prepared: &Prepared) -> Option<(usize, AddedLaw)> {
    let law = one.law.clone().filter(|law| !law.law.is_empty())?;
    Some((joint(one.place, prepared.reading().channels())?, law))
}

/// Returns the unknowns with the fall of the error by the laws of each joint, and without laws that the log does not show. The
/// search gives samples near reversals little weight.
pub(super) fn with_confirmed_laws(mut found: Vec<Found>, prepared: &Prepared) -> Vec<Found> {
    let laws: Vec<(usize, AddedLaw)> = (found.iter())
        .filter_map(|one| added(one, prepared))
        .collect();
    if laws.is_empty() {
        return found;
    }
    let reading = reading_with(&found, prepared);
    let Some([without, with]) = LawColumns::new(prepared, &reading, &laws)
        .and_then(|columns| Some([columns.judged(&[])?, columns.judged(&laws)?]))
    else {
        return found;
    };
    let left = |of: &Judged, joint: usize| of.left(joint).iter().sum::<f64>();
    for one in &mut found {
        if let Some((joint, _)) = added(one, prepared) {
            one.fall = 1.0 - (left(&with, joint) / left(&without, joint)).sqrt();
        }
    }
    found.retain(|one| added(one, prepared).is_none() || one.fall >= LEAST_FALL);
    found
}

/// Returns presliding friction of the motors, for each joint that may have it.
pub(super) fn of_presliding(prepared: &Prepared) -> Vec<(usize, AddedLaw)> {
    let experiment = prepared.experiment();
    // Without weights the smearing of reversals looks like this friction.
    if prepared.reading().settings().weights == Weights::None {
        return Vec::new();
    }
    let speeds = rms_speeds(prepared.reading(), prepared.excerpt());
    let family = FrictionLaw(Family::Presliding);
    let may_have = |joint: usize| {
        let laws = laws_of(&experiment.robot.joint[joint], Side::Motor);
        may_add_laws(experiment, joint)
            && speeds[joint] > 0.0
            && laws.contains(&FrictionLaw(Family::Coulomb))
            && !laws.contains(&family)
    };
    let law = AddedLaw {
        of: "motor_friction".to_owned(),
        law: family.name().to_owned(),
        ..AddedLaw::default()
    };
    (0..experiment.robot.joint.len())
        .filter(|&joint| may_have(joint))
        .map(|joint| (joint, law.clone()))
        .collect()
}

/// Returns presliding friction of the motors that the log shows, judged beside what is applied: for all motors of a rigid robot
/// together, for each joint of a flexible one.
///
/// - `columns`: of another preparation, which may be the same.
pub(super) fn presliding(prepared: &Prepared, columns: Option<&LawColumns>) -> Vec<Found> {
    let experiment = prepared.experiment();
    let candidates = of_presliding(prepared);
    if candidates.is_empty() {
        return Vec::new();
    }
    // Filters smear reversals, so samples near them count as in the estimate.
    let reading = prepared.weighted_reading();
    let same = columns.filter(|columns| columns.are_of(&reading));
    let columns = match same {
        Some(same) => Some(Cow::Borrowed(same)),
        None => LawColumns::new(prepared, &reading, &candidates).map(Cow::Owned),
    };
    let Some([without, with]) =
        columns.and_then(|columns| Some([columns.judged(&[])?, columns.judged(&candidates)?]))
    else {
        return Vec::new();
    };
    let of_joints: Vec<[Vec<f64>; 2]> = (candidates.iter())
        .map(|(joint, _)| [without.left(*joint), with.left(*joint)])
        .collect();
    let is_shown: Vec<bool> = if experiment.robot.has_springs() {
        let each = of_joints.iter().map(std::slice::from_ref);
        each.map(|one| falls(one, LEAST_FALL_OF_FLEXIBLE)).collect()
    } else {
        vec![falls(&of_joints, LEAST_FALL_BY_PRESLIDING); of_joints.len()]
    };
    let of_joint = |(at, (joint, law)): (usize, &(usize, AddedLaw))| {
        let kinds = Family::Presliding.laws().iter();
        let parameters: Vec<usize> = kinds
            .filter_map(|&law| with.index(JointParameter::Friction(Side::Motor, law), *joint))
            .collect();
        let sum = with.sum(&parameters);
        found_law(prepared, (*joint, law.clone()), sum, &of_joints[at])
    };
    (candidates.iter().enumerate())
        .filter(|(at, _)| is_shown[*at])
        .map(of_joint)
        .collect()
}

/// Returns a law that a joint has.
///
/// - `value`: its size and the standard error.
/// - `errors`: of the joint without and with it, in each part.
pub(super) fn found_law(
    prepared: &Prepared,
    (joint, law): (usize, AddedLaw),
    (value, error): (f64, f64),
    errors: &[Vec<f64>; 2],
) -> Found {
    let name = &prepared.experiment().robot.joint[joint].name;
    let kind = prepared.reading().model().kind(joint);
    let ratio = ratio_of(errors, 0..PARTS);
    Found {
        id: format!("law {name}.{}.{}", law.of, law.law),
        kind: Kind::Law,
        place: Place::Joint(joint),
        value,
        standard_error: error.max(LEAST_ERROR * value.abs()).max(LEAST_TORQUE),
        unit: match (law.play_half_width, kind) {
            (None, JointKind::Revolute) => "N·m",
            (None, JointKind::Prismatic) => "N",
            (Some(_), JointKind::Revolute) => "rad",
            (Some(_), JointKind::Prismatic) => "m",
        },
        begins: None,
        law: Some(law),
        gain: (1.0 - ratio * ratio).max(0.0),
        own: 1.0,
        mimic: None,
        fall: 1.0 - ratio,
        competing: Vec::new(),
    }
}

/// Returns whether the errors of joints fall by a law: the mean logarithm over the joints by a least fall, and by two standard errors
/// over the parts.
///
/// - `joints`: errors of each joint without and with the law, in each part.
pub(super) fn falls(joints: &[[Vec<f64>; 2]], least: f64) -> bool {
    let mean = |parts: Range<usize>| -> f64 {
        let logs = joints.iter().map(|both| ratio_of(both, parts.clone()).ln());
        -logs.sum::<f64>() / joints.len() as f64
    };
    // A short log has fewer parts.
    if (joints.iter().flatten()).any(|of_parts| of_parts.len() < PARTS) {
        return false;
    }
    let of_parts: Vec<f64> = (0..PARTS).map(|part| mean(part..part + 1)).collect();
    let (of_part, error) = mean_and_error(&of_parts);
    // The jackknife error is that of values without each part; of the parts themselves it is smaller.
    let error = error / (PARTS as f64 - 1.0);
    mean(0..PARTS) >= least && of_part >= LEAST_SIGNIFICANCE * error
}

/// Returns the error with a law over that without (root mean squares) in some parts.
fn ratio_of([before, after]: &[Vec<f64>; 2], parts: Range<usize>) -> f64 {
    let sum = |of: &[f64]| of[parts.clone()].iter().sum::<f64>().max(f64::MIN_POSITIVE);
    (sum(after) / sum(before)).sqrt()
}

/// Returns the delay of each channel with those that were found.
pub(super) fn with_found(reading: &Reading, found: &[Found]) -> Vec<f64> {
    let mut delays = reading.delays().to_vec();
    for one in found {
        if matches!(one.kind, Kind::Delay | Kind::Timing) {
            for (i, delay) in delays.iter_mut().enumerate() {
                if one.place.contains(i, reading.channels()) {
                    *delay += one.value;
                }
            }
        }
    }
    delays
}

/// Returns the joint of a place, if it has one.
pub(super) fn joint(place: Place, channels: &Channels) -> Option<usize> {
    match place {
        Place::Channel(at) => Some(channels.all[at].joint),
        Place::Joint(joint) => Some(joint),
        Place::All(_) | Place::Robot => None,
    }
}

/// Returns a model with the sharpness that was found.
pub(super) fn sharpened(mut model: Model, found: &[Found], channels: &Channels) -> Model {
    for one in found.iter().filter(|one| one.kind == Kind::Sharpness) {
        if let Some(joint) = joint(one.place, channels) {
            model.set_scale(joint, Scale::Sharpness, one.value);
        }
    }
    model
}
