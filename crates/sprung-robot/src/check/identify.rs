//! Checks of the settings of an identification.

use super::fault::{Fault, fault, refused};
use crate::capabilities::{Feature, NotSupported, together};
use crate::identify::Cutoff;
use crate::numbers::Shown;
use crate::physical::Physical;
use crate::types::ExperimentFile;

/// Limits of the memory of the refinement, MiB.
const MEMORY_MIB: std::ops::RangeInclusive<usize> = 128..=1_048_576;

/// Checks that the motors are the only measured coordinates if springs are to be found from them.
fn springs_from_motor(file: &ExperimentFile) -> Result<(), Fault> {
    if !file.identify.springs_from_motor {
        return Ok(());
    }
    let refused = |reason: NotSupported| refused(&["identify", "springs_from_motor"], &reason);
    let excluded = Feature::SpringsFromMotor;
    if let Some(joint) = file.robot.joint.iter().find(|joint| joint.is_flexible()) {
        together(Feature::FlexibleJoint, &joint.name, excluded).map_err(refused)?;
    }
    if file.robot.transmission_matrix.is_some() {
        together(Feature::CoupledTransmission, "the robot", excluded).map_err(refused)?;
    }
    Ok(())
}

pub(super) fn identify(file: &ExperimentFile) -> Result<(), Fault> {
    let settings = &file.identify;
    for (i, one) in settings.estimator.iter().enumerate() {
        if settings.estimator[..i].contains(one) {
            return Err(fault(
                &["identify", "estimator"],
                format!("estimator \"{}\" is listed twice", one.name()),
            ));
        }
    }
    for (key, value) in [
        (
            "filter_cutoff_rad_per_s",
            settings.filter_cutoff_rad_per_s.unwrap_or(1.0),
        ),
        (
            "position_cutoff_hz",
            match settings.position_cutoff_hz {
                Cutoff::Fixed(cutoff) => cutoff,
                Cutoff::Auto => 1.0,
            },
        ),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(fault(
                &["identify", key],
                format!("{key} = {} must be positive", Shown(value)),
            ));
        }
    }
    if !(1..=10).contains(&settings.position_filter_order) {
        return Err(fault(
            &["identify", "position_filter_order"],
            format!(
                "position_filter_order = {} must be between 1 and 10",
                settings.position_filter_order
            ),
        ));
    }
    springs_from_motor(file)?;
    if !MEMORY_MIB.contains(&settings.refinement_memory_mib) {
        return Err(fault(
            &["identify", "refinement_memory_mib"],
            format!(
                "refinement_memory_mib = {} must be between {} and {}",
                settings.refinement_memory_mib,
                MEMORY_MIB.start(),
                MEMORY_MIB.end()
            ),
        ));
    }
    physical(&settings.physical)
}

fn physical(settings: &Physical) -> Result<(), Fault> {
    if !(settings.prior_error.is_finite() && settings.prior_error > 0.0) {
        return Err(fault(
            &["identify", "physical", "prior_error"],
            format!(
                "prior_error = {} must be positive; 0.3 means 30 %",
                Shown(settings.prior_error)
            ),
        ));
    }
    let total = settings.total_mass_kg.iter();
    let total = total.map(|limit| (vec!["total_mass_kg"], limit));
    let single = settings.mass_kg.iter();
    for (keys, [least, largest]) in total.chain(single.map(|(k, v)| (vec!["mass_kg", &**k], v))) {
        if !(0.0 <= *least && least < largest && largest.is_finite()) {
            let key = keys.join(".");
            return Err(fault(
                &[&["identify", "physical"], &keys[..]].concat(),
                format!(
                    "{key} = [{}, {}] must be two masses, the least one first",
                    Shown(*least),
                    Shown(*largest)
                ),
            ));
        }
    }
    Ok(())
}
