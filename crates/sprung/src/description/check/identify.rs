//! Checks of the settings of an identification.

use super::fault::{Fault, fault};
use super::window::check_window;
use crate::description::identify::Cutoff;
use crate::description::types::ExperimentFile;

pub(super) fn identify(file: &ExperimentFile) -> Result<(), Fault> {
    let settings = &file.identify;
    if settings.estimator.is_empty() {
        return Err(fault(
            &["identify", "estimator"],
            "the list of estimators is empty",
        ));
    }
    for (i, one) in settings.estimator.iter().enumerate() {
        if settings.estimator[..i].contains(one) {
            return Err(fault(
                &["identify", "estimator"],
                format!("estimator \"{}\" is listed twice", one.name()),
            ));
        }
    }
    for (key, value) in [
        ("filter_cutoff_rad_per_s", settings.filter_cutoff_rad_per_s),
        (
            "position_cutoff_hz",
            match settings.position_cutoff_hz {
                Cutoff::Fixed(cutoff) => cutoff,
                Cutoff::Auto => 1.0,
            },
        ),
        ("lsff_forgetting_per_s", settings.lsff_forgetting_per_s),
        ("lsff_initial_gain", settings.lsff_initial_gain),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(fault(
                &["identify", key],
                format!("{key} = {value} must be positive"),
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
    check_window(
        settings.lsff_velocity_window,
        &["identify", "lsff_velocity_window"],
    )
}
