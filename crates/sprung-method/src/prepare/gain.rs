//! Gains of columns that a known quantity determines.

use sprung_core::parameters::JointParameter;

use super::estimated_columns::FoundGain;
use super::excerpt::Excerpt;
use super::row::{BesideFixed, fit_rows, independent};
use crate::description::{EncoderOffset, Experiment};
use crate::log::Quantity;
use crate::model::Model;
use crate::regression::Reading;

/// Gains in the first scan about the ratio of both standard deviations: their number on each side
/// and the ratio of neighbours. The range is wide because a soft spring lets one encoder move twice
/// as far as the other.
const GAINS_EACH_SIDE: i32 = 16;
const GAIN_RATIO: f64 = 1.06;

/// Newton steps to the minimum of the residual: their number, the distance for the differences as a
/// fraction of the gain, and the longest step in these distances.
const NEWTON_STEPS: usize = 12;
const CURVATURE_STEP_SHARE: f64 = 0.01;
const LONGEST_NEWTON_STEP: f64 = 4.0;

/// Largest accepted standard error, as a fraction of the gain.
const LARGEST_ERROR_SHARE: f64 = 0.1;

/// Finds the gain of a channel; the error gives the reason why the log does not determine the gain,
/// and a remedy.
pub(super) fn gain(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
    channel: usize,
) -> Result<FoundGain, String> {
    match reading.channels().all[channel].quantity {
        Quantity::MotorTorque => of_torque(reading, excerpt, channel),
        Quantity::LinkPosition
        | Quantity::LinkDeflection
        | Quantity::MotorPosition
        | Quantity::MotorTarget
        | Quantity::DriveOn
        | Quantity::JointTorque
        | Quantity::Inertial(..)
        | Quantity::Covariate(_) => of_position(experiment, reading, excerpt, channel),
    }
}

/// Finds the gain of a position relative to the joint's other position: the gain at which the
/// spring torque explains most of the motor torque.
///
/// The slope of one position over the other would be biased by the spring's deflection, which
/// follows the motion.
fn of_position(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
    channel: usize,
) -> Result<FoundGain, String> {
    let channels = reading.channels();
    let source = &channels.all[channel];
    let name = &reading.model().joints()[source.joint];
    let undetermined = |why: String| {
        format!(
            "the gain of \"{}\" cannot be estimated: {why}; give it as a number in gain",
            source.column
        )
    };
    let other = match source.quantity {
        Quantity::LinkPosition => Quantity::MotorPosition,
        Quantity::MotorPosition => Quantity::LinkPosition,
        Quantity::JointTorque => {
            return Err(undetermined(
                "sprung check compares the torque sensor with the motor torque, and a weight of known mass \
                 tells which of them is right"
                    .to_owned(),
            ));
        }
        Quantity::LinkDeflection
        | Quantity::MotorTorque
        | Quantity::MotorTarget
        | Quantity::DriveOn
        | Quantity::Inertial(..)
        | Quantity::Covariate(_) => {
            return Err(undetermined(format!(
                "it is the gain of a deflection of {name}, and the stiffness scales with it"
            )));
        }
    };
    let Some(other) = channels.index(other, source.joint) else {
        return Err(undetermined(format!(
            "{name} has no other position to compare with, and all parameters scale with the gain"
        )));
    };
    let beside = &channels.all[other];
    if beside.open_gain {
        return Err(undetermined(format!(
            "the gain of \"{}\" is to be estimated as well, but one of the two must be known",
            beside.column
        )));
    }
    // An arbitrary zero of an encoder causes a constant that a gain would absorb.
    let with_offset = {
        let mut experiment = experiment.clone();
        experiment.identify.encoder_offset = Some(EncoderOffset::Estimate);
        Model::new(&experiment).ok()
    };
    let with_offset = with_offset.map(|model| reading.with_model(model));
    let search = GainSearch {
        reading: with_offset.as_ref().unwrap_or(reading),
        excerpt,
        channel,
        joint: source.joint,
    };
    let about = spread(excerpt, other) / spread(excerpt, channel);
    if !(about.is_finite() && about > 0.0) {
        return Err(undetermined(format!("{name} does not move")));
    }
    let found = search.minimum(about);
    let Some((value, standard_error)) =
        found.filter(|(gain, error)| *error < LARGEST_ERROR_SHARE * gain)
    else {
        return Err(undetermined(format!(
            "the equation of {name} fits about equally well with gains that differ by 10 % or more"
        )));
    };
    Ok(FoundGain {
        column: source.column.clone(),
        value,
        standard_error,
        because: format!(
            "with this gain the spring between it and \"{}\" explains most of the motor torque; counts per \
             turn, a gear ratio or a unit is wrong by {:+.2} %",
            beside.column,
            100.0 * (value - 1.0)
        ),
    })
}

/// Standard deviation of a channel.
fn spread(excerpt: &Excerpt, channel: usize) -> f64 {
    let n = excerpt.samples().max(1) as f64;
    let mean = excerpt.channel(channel).sum::<f64>() / n;
    let squares: f64 = excerpt.channel(channel).map(|x| (x - mean).powi(2)).sum();
    (squares / n).sqrt()
}

struct GainSearch<'a> {
    reading: &'a Reading,
    excerpt: &'a Excerpt,
    channel: usize,
    joint: usize,
}

impl GainSearch<'_> {
    /// Squared ratio of the torque row's residual to the torque, with the channel multiplied by
    /// `gain`; infinite where the stiffness is not positive.
    fn cost(&self, gain: f64) -> f64 {
        let scaled = self.excerpt.scaled(self.channel, gain);
        let fits = fit_rows(&scaled, self.reading, &[self.joint]);
        let Some(fit) = fits.as_ref().and_then(|fits| fits.first()) else {
            return f64::INFINITY;
        };
        let stiffness = fit.short(self.reading.model()).stiffness;
        if stiffness.is_none_or(|stiffness| stiffness > 0.0) {
            fit.relative_residual().powi(2)
        } else {
            f64::INFINITY
        }
    }

    /// Returns the gain with the smallest residual, and its standard error.
    fn minimum(&self, about: f64) -> Option<(f64, f64)> {
        let tried = (-GAINS_EACH_SIDE..=GAINS_EACH_SIDE).map(|k| {
            let gain = about * GAIN_RATIO.powi(k);
            (gain, self.cost(gain))
        });
        let (mut gain, least) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
        if !least.is_finite() {
            return None;
        }
        let number = independent(self.excerpt, self.reading);
        for _ in 0..NEWTON_STEPS {
            let h = CURVATURE_STEP_SHARE * gain;
            let [left, centre, right] = [-h, 0.0, h].map(|by| self.cost(gain + by));
            let slope = (right - left) / (2.0 * h);
            let curvature = (right - 2.0 * centre + left) / (2.0 * h * h);
            if !(curvature.is_finite() && curvature > 0.0) {
                return None;
            }
            let step = (-slope / (2.0 * curvature))
                .clamp(-LONGEST_NEWTON_STEP * h, LONGEST_NEWTON_STEP * h);
            gain += step;
            let error = (centre.max(1e-12) / (number * curvature)).sqrt();
            if step.abs() < 0.01 * error.min(h) {
                return Some((gain, error));
            }
        }
        None
    }
}

/// Finds the gain of a torque: known parameters over the values that the logged torque gives.
fn of_torque(reading: &Reading, excerpt: &Excerpt, channel: usize) -> Result<FoundGain, String> {
    let (source, model) = (&reading.channels().all[channel], reading.model());
    let name = &model.joints()[source.joint];
    let fits = fit_rows(excerpt, reading, &[source.joint]);
    let fit = fits.as_ref().and_then(|fits| fits.first());
    let number = independent(excerpt, reading);
    let known = fit.map_or_else(Vec::new, |fit| fit.beside_fixed(model, number));
    if known.is_empty() {
        let parameter = model.index(JointParameter::RotorInertia, source.joint);
        let example = parameter.map_or_else(
            || format!("{name}.rotor_inertia"),
            |index| model.parameters()[index].name.clone(),
        );
        return Err(format!(
            "the gain of \"{}\" cannot be estimated: all parameters of {name} scale with it, and no \
             parameter in the equation of its torque is known; give a parameter as a number, as in \
             fixed = {{ \"{example}\" = 0.02 }} under [robot], or give the gain",
            source.column
        ));
    }
    let gains: Vec<(f64, f64)> = (known.iter())
        .map(|known| {
            let BesideFixed {
                fixed,
                value,
                error,
                ..
            } = known;
            (fixed / value, (fixed * error / (value * value)).abs())
        })
        .collect();
    let weights: f64 = gains.iter().map(|(_, error)| error.powi(-2)).sum();
    let value = gains.iter().map(|(g, e)| g * e.powi(-2)).sum::<f64>() / weights;
    let standard_error = weights.sqrt().recip();
    let names: Vec<&str> = known.iter().map(|known| known.name.as_str()).collect();
    if !(value > 0.0 && standard_error < LARGEST_ERROR_SHARE * value) {
        return Err(format!(
            "the gain of \"{}\" cannot be estimated: {} would make it {value:.3} (standard error \
             {standard_error:.3}); check that the known value and the sign are right, log a motion with more \
             of its torque, or give the gain as a number",
            source.column,
            names.join(" and ")
        ));
    }
    Ok(FoundGain {
        column: source.column.clone(),
        value,
        standard_error,
        because: format!(
            "with this gain the equation of {name} gives the known value of {}",
            names.join(" and ")
        ),
    })
}
