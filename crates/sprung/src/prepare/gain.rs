//! Gains of columns, where something known pins them.

use sprung_core::parameters::JointParameter;

use super::excerpt::Excerpt;
use super::found::FoundGain;
use super::row::{fit_rows, independent};
use crate::description::{EncoderOffset, Experiment};
use crate::log::Quantity;
use crate::model::Model;
use crate::regression::Reading;

/// Gains that are tried about the ratio of both spreads, on each side, and the ratio of
/// neighbours: a soft spring lets one encoder move twice as far as the other.
const GAINS_EACH_SIDE: i32 = 16;
const GAIN_RATIO: f64 = 1.06;

/// Steps to the minimum of the residual, the part of the gain at which its curvature is
/// taken, and how far a step may go in these parts.
const NEWTON_STEPS: usize = 12;
const CURVATURE_STEP_SHARE: f64 = 0.01;
const LONGEST_NEWTON_STEP: f64 = 4.0;

/// The largest standard error, as a part of the gain, with which one is told.
const LARGEST_ERROR_SHARE: f64 = 0.1;

/// Finds the gain of a channel; or says why it cannot be told, and what to do.
pub(super) fn gain(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
    channel: usize,
) -> Result<FoundGain, String> {
    match reading.channels().all[channel].quantity {
        Quantity::MotorTorque => of_torque(reading, excerpt, channel),
        _ => of_position(experiment, reading, excerpt, channel),
    }
}

/// The gain of a position against the other one of its joint: that with which the spring's
/// torque explains most of the motor's.
///
/// The slope of both alone would hold the spring's deflection, which follows the motion.
fn of_position(
    experiment: &Experiment,
    reading: &Reading,
    excerpt: &Excerpt,
    channel: usize,
) -> Result<FoundGain, String> {
    let channels = reading.channels();
    let own = &channels.all[channel];
    let name = &reading.model().joints()[own.joint];
    let untold = |why: String| {
        format!(
            "the gain of \"{}\" cannot be told: {why}; give it as a number in gain",
            own.column
        )
    };
    let other = match own.quantity {
        Quantity::LinkPosition => Quantity::MotorPosition,
        Quantity::MotorPosition => Quantity::LinkPosition,
        _ => {
            return Err(untold(format!(
                "it is the deflection of {name}, and the stiffness would change with it"
            )));
        }
    };
    let Some(other) = channels.index(other, own.joint) else {
        return Err(untold(format!(
            "{name} has no other position to compare it with, and all parameters would change with it"
        )));
    };
    let beside = &channels.all[other];
    if beside.open_gain {
        return Err(untold(format!(
            "that of \"{}\" is to be estimated as well, and one of both must be right",
            beside.column
        )));
    }
    // Encoders that begin anywhere leave a constant, which a gain would take up.
    let with_offset = {
        let mut experiment = experiment.clone();
        experiment.identify.encoder_offset = Some(EncoderOffset::Estimate);
        Model::new(&experiment).ok()
    };
    let with_offset = with_offset.map(|model| reading.with_model(model));
    let search = Search {
        reading: with_offset.as_ref().unwrap_or(reading),
        excerpt,
        channel,
        joint: own.joint,
    };
    let about = spread(excerpt, other) / spread(excerpt, channel);
    if !(about.is_finite() && about > 0.0) {
        return Err(untold(format!("{name} does not move")));
    }
    let found = search.minimum(about);
    let Some((value, standard_error)) =
        found.filter(|(gain, error)| *error < LARGEST_ERROR_SHARE * gain)
    else {
        return Err(untold(format!(
            "the equation of {name} fits about as well with gains that differ by 10 % and more"
        )));
    };
    Ok(FoundGain {
        column: own.column.clone(),
        value,
        standard_error,
        because: format!(
            "so the spring between it and \"{}\" explains most of the motor torque; counts per turn, a gear \
             ratio or a unit is off by {:+.2} %",
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

struct Search<'a> {
    reading: &'a Reading,
    excerpt: &'a Excerpt,
    channel: usize,
    joint: usize,
}

impl Search<'_> {
    /// Squared residual of the torque's row as a part of the torque, with the channel times
    /// a number; infinite where the spring would push.
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

    /// The gain of the least residual, and its standard error.
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

/// The gain of a torque: known parameters over those that the torque as logged gives.
fn of_torque(reading: &Reading, excerpt: &Excerpt, channel: usize) -> Result<FoundGain, String> {
    let (own, model) = (&reading.channels().all[channel], reading.model());
    let name = &model.joints()[own.joint];
    let fits = fit_rows(excerpt, reading, &[own.joint]);
    let fit = fits.as_ref().and_then(|fits| fits.first());
    let number = independent(excerpt, reading);
    let known = fit.map_or_else(Vec::new, |fit| fit.beside_fixed(model, number));
    if known.is_empty() {
        let parameter = model.index(JointParameter::RotorInertia, own.joint);
        let example = parameter.map_or_else(
            || format!("{name}.rotor_inertia"),
            |index| model.parameters()[index].name.clone(),
        );
        return Err(format!(
            "the gain of \"{}\" cannot be told: all parameters of {name} scale with it, and none in the \
             equation of its torque is known; give one as a number, as in fixed = {{ \"{example}\" = \
             0.02 }} under [robot], or the gain",
            own.column
        ));
    }
    let gains: Vec<(f64, f64)> = (known.iter())
        .map(|(_, fixed, value, error)| (fixed / value, (fixed * error / (value * value)).abs()))
        .collect();
    let weights: f64 = gains.iter().map(|(_, error)| error.powi(-2)).sum();
    let value = gains.iter().map(|(g, e)| g * e.powi(-2)).sum::<f64>() / weights;
    let standard_error = weights.sqrt().recip();
    let names: Vec<&str> = known.iter().map(|(name, ..)| name.as_str()).collect();
    if !(value > 0.0 && standard_error < LARGEST_ERROR_SHARE * value) {
        return Err(format!(
            "the gain of \"{}\" cannot be told: {} would make it {value:.3} (standard error \
             {standard_error:.3}); see that the known value and the sign are right, log a motion with more \
             of its torque, or give the gain as a number",
            own.column,
            names.join(" and ")
        ));
    }
    Ok(FoundGain {
        column: own.column.clone(),
        value,
        standard_error,
        because: format!(
            "so {} comes out of the equation of {name} as it is known",
            names.join(" and ")
        ),
    })
}
