//! Compares the frequency response of a log with that of a model.

use std::ops::Range;

use faer::{Mat, c64};
use sprung_core::parameters::JointParameter;

use super::linear::{Linear, OperatingPoint};
use super::modes::{Mode, assigned};
use super::pole::{Pole, Window, fewest_lines};
use super::record::Record;
use super::response::{Estimate, estimates};
use super::result::{
    Feature, FeatureKind, FrequencyResponse, JointResponse, ResponseCurves, Unseen,
};
use super::spectra::{Spectra, imaginary};
use crate::model::Model;

/// Half width of the window about a vibration, relative to its frequency: default, and maximum if it has too few lines.
const WINDOW: f64 = 0.2;
const WIDEST_WINDOW: f64 = 0.35;

/// Most lines of a window.
const MOST_LINES: usize = 400;

/// Least power of a position in a window, relative to that of its noise. The local model takes its inputs
/// as exact.
const LEAST_SIGNAL_TO_NOISE: f64 = 300.0;

/// Largest power of dry friction relative to that of the motor torque. Feedback responds to friction with torque, and
/// the response of the log is then that of the inverse controller.
const LARGEST_FRICTION: f64 = 0.1;

/// Half the number of lines over which a power is averaged for the curves.
const POWER_LINES: usize = 8;

/// Frequencies of the curves: in all, about each feature, and their range about a feature.
const CURVE_POINTS: usize = 80;
const FEATURE_POINTS: usize = 16;
const FEATURE_RANGE: f64 = 0.1;

/// Highest frequency of the curves relative to the highest feature.
const HIGHEST_OVER_FEATURES: f64 = 2.5;

/// Values of the log are shown if their relative standard error is below this.
const LARGEST_RELATIVE_ERROR: f64 = 1.0;

/// Centres of the windows, relative to the frequency of the model.
const CENTRES: [f64; 3] = [1.0, 0.5 * (2.0 - WINDOW), 0.5 * (2.0 + WINDOW)];

/// Largest standard error of a frequency by the log, relative to the frequency.
const LARGEST_FREQUENCY_ERROR: f64 = 0.01;

/// An identified model with the errors of its parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Identified<'a> {
    /// The model.
    pub(crate) model: &'a Model,
    /// Parameters, \[p\].
    pub(crate) theta: &'a [f64],
    /// Changes of each parameter whose squares add up to its variance, \[p\]\[changes\]. Moves of several parameters at
    /// the same place occur together.
    pub(crate) moves: &'a [Vec<f64>],
}

/// A flexible joint in the equations.
struct Spring {
    joint: usize,
    motor: usize,
    stiffness: f64,
}

/// A vibration of the model that belongs to a joint.
struct Expected {
    kind: FeatureKind,
    mode: Mode,
    /// Coordinates that move.
    free: Vec<usize>,
}

/// Compares the frequency response of the log with that of the model; `None` if the robot has no
/// flexible joint, the record is too short, or the model has no positive mass matrix.
#[must_use]
pub(crate) fn frequency_response(
    record: &Record,
    identified: &Identified<'_>,
) -> Option<FrequencyResponse> {
    let Identified { model, theta, .. } = *identified;
    let springs = springs(model, theta);
    if springs.is_empty() {
        return None;
    }
    let segment = record.longest();
    let spectra = Spectra::of(segment)?;
    let point = OperatingPoint::of(model, segment);
    let at_poses: Vec<Linear> = (point.poses.iter())
        .map(|pose| Linear::new(model, theta, &point.friction, pose))
        .collect::<Option<_>>()?;
    let linear = Linear::mean(&at_poses)?;
    let expected = expected(&linear, &springs);
    let moved = Moved::new(identified, &point)?;
    let log = OfLog {
        friction: &spectra.of_columns(&point.distortion(model, theta, segment)),
        spectra: &spectra,
    };
    let joints = (springs.iter().zip(&expected))
        .map(|(spring, of_spring)| {
            let features = (of_spring.iter())
                .map(|expected| {
                    let frequency = ModelFrequency::new(expected, &linear, &at_poses, &moved);
                    frequency.feature(expected, log.pole(spring.joint, expected))
                })
                .collect();
            curves(model, &log, &linear, spring, features)
        })
        .collect::<Vec<JointResponse>>();
    Some(FrequencyResponse {
        duration_s: spectra.duration,
        periods: spectra.periods,
        joints,
    })
}

/// Returns the springs with a positive stiffness.
fn springs(model: &Model, theta: &[f64]) -> Vec<Spring> {
    let robot = model.robot();
    (0..model.joint_count())
        .filter(|&joint| model.is_flexible(joint))
        .filter_map(|joint| {
            let column = model.index(JointParameter::Stiffness, joint)?;
            Some(Spring {
                joint,
                motor: robot.motor_coordinate(joint),
                stiffness: theta[column],
            })
        })
        .filter(|spring| spring.stiffness > 0.0)
        .collect()
}

/// Returns the resonance and the antiresonance of each spring, if they exist.
fn expected(linear: &Linear, springs: &[Spring]) -> Vec<Vec<Expected>> {
    let everything: Vec<usize> = (0..linear.mass.nrows()).collect();
    let links: Vec<usize> = springs.iter().map(|spring| spring.joint).collect();
    let mut all: Vec<Vec<Expected>> = springs.iter().map(|_| Vec::new()).collect();
    for (kind, free) in [
        (FeatureKind::Antiresonance, links),
        (FeatureKind::Resonance, everything),
    ] {
        let view = linear.of(&free);
        let modes = Mode::all(&view);
        let place = |coordinate: usize| free.iter().position(|other| *other == coordinate);
        let shares: Vec<Vec<f64>> = (springs.iter())
            .map(|spring| {
                let ends = (place(spring.motor), place(spring.joint).unwrap_or(0));
                (modes.iter())
                    .map(|mode| mode.spring_share(&view, spring.stiffness, ends))
                    .collect()
            })
            .collect();
        for (of_spring, mode) in all.iter_mut().zip(assigned(&shares)) {
            of_spring.extend(mode.map(|mode| Expected {
                kind,
                mode: modes[mode].clone(),
                free: free.clone(),
            }));
        }
    }
    all
}

/// The equations in the mean pose, before and after each change of the parameters.
struct Moved {
    before: Linear,
    after: Vec<Option<Linear>>,
}

impl Moved {
    fn new(identified: &Identified<'_>, point: &OperatingPoint) -> Option<Self> {
        let Identified {
            model,
            theta,
            moves,
        } = *identified;
        let count = moves.iter().map(Vec::len).max().unwrap_or(0);
        let after = |k: usize| {
            let step = (theta.iter().zip(moves))
                .map(|(value, movement)| value + movement.get(k).copied().unwrap_or_default())
                .collect::<Vec<f64>>();
            Linear::new(model, &step, &point.friction, &point.mean)
        };
        Some(Self {
            before: Linear::new(model, theta, &point.friction, &point.mean)?,
            after: (0..count).map(after).collect(),
        })
    }
}

struct ModelFrequency {
    error_hz: f64,
    over_poses: [f64; 2],
}

impl ModelFrequency {
    fn new(expected: &Expected, linear: &Linear, at_poses: &[Linear], moved: &Moved) -> Self {
        let view = |linear: &Linear| linear.of(&expected.free);
        let reference = view(linear);
        let hz = expected.mode.hz();
        let before = view(&moved.before);
        let change = |from: &Linear, to: &Linear| expected.mode.change(from, &view(to));
        let over_poses = (at_poses.iter().map(|other| hz + change(&reference, other)))
            .fold([hz, hz], |[low, high], hz| [low.min(hz), high.max(hz)]);
        // The sum of no numbers is -0.
        let squares = (moved.after.iter())
            .map(|after| (after.as_ref()).map_or(hz, |after| change(&before, after)))
            .fold(0.0, |sum, change| sum + change * change);
        Self {
            error_hz: squares.sqrt(),
            over_poses,
        }
    }

    fn feature(self, expected: &Expected, found: Result<Pole, Unseen>) -> Feature {
        let pole = found.ok();
        Feature {
            unseen: found.err(),
            kind: expected.kind,
            model_hz: expected.mode.hz(),
            model_standard_error_hz: self.error_hz,
            model_over_poses_hz: self.over_poses,
            model_damping: expected.mode.damping(),
            log_hz: pole.map(|pole| pole.hz),
            log_standard_error_hz: pole.map(|pole| pole.error_hz),
            log_damping: pole.map(|pole| pole.damping),
        }
    }
}

/// Spectra of the log.
struct OfLog<'s> {
    spectra: &'s Spectra,
    /// Spectra of the friction on each motor beyond its linear part, \[n\]\[lines\].
    friction: &'s [Vec<c64>],
}

impl OfLog<'_> {
    /// Returns the pole of the log near that of the model, or the reason for its absence. If the window about the
    /// vibration of the model shows no peak, neighbouring windows are tried.
    fn pole(&self, joint: usize, expected: &Expected) -> Result<Pole, Unseen> {
        let [centre, beside @ ..] = CENTRES;
        self.pole_about(joint, expected, centre).or_else(|unseen| {
            let mut others = beside.into_iter().filter(|_| unseen == Unseen::NoPeak);
            (others.find_map(|by| self.pole_about(joint, expected, by).ok())).ok_or(unseen)
        })
    }

    /// Returns the pole of the log in the window about a multiple of the frequency of the model's.
    ///
    /// A resonance is a pole from the torques of all motors to a position of the joint, an
    /// antiresonance a pole from the positions of all motors to the link position. Friction of the
    /// motors does not disturb the latter.
    fn pole_about(&self, joint: usize, expected: &Expected, by: f64) -> Result<Pole, Unseen> {
        let spectra = self.spectra;
        let hz = by * expected.mode.hz();
        let spacing = spectra
            .hz
            .get(1)
            .map_or(hz, |second| second - spectra.hz[0]);
        let fewest = fewest_lines(spectra.torque.len());
        let half = (0.5 * spacing * fewest as f64).clamp(WINDOW * hz, WIDEST_WINDOW * hz);
        let lines = spectra.window(hz, half, MOST_LINES);
        if lines.len() < fewest {
            return Err(Unseen::TooShort);
        }
        if !self.moves(joint, &lines) {
            return Err(Unseen::NoExcitation);
        }
        let frequencies = &spectra.hz[lines.clone()];
        // Accelerations: without the factor 1/ω² the response beside a pole is nearly constant.
        let acceleration = |position: &Vec<c64>| -> Vec<c64> {
            let pairs = position[lines.clone()].iter().zip(frequencies);
            pairs
                .map(|(x, hz)| *x * imaginary(*hz) * imaginary(*hz))
                .collect()
        };
        let motors: Vec<Vec<c64>> = spectra.motor.iter().map(acceleration).collect();
        let link = acceleration(&spectra.link[joint]);
        let pole = |output: &[c64], inputs: Vec<&[c64]>| {
            Window {
                output,
                inputs,
                hz: frequencies,
                transient: spectra.periods.is_none(),
            }
            .pole((hz, expected.mode.damping()))
        };
        let found = match expected.kind {
            FeatureKind::Resonance => {
                if self.is_disturbed(joint, &lines) {
                    return Err(Unseen::DryFriction);
                }
                let torques = spectra.torque.iter();
                let inputs: Vec<&[c64]> = torques.map(|torque| &torque[lines.clone()]).collect();
                [pole(&motors[joint], inputs.clone()), pole(&link, inputs)]
                    .into_iter()
                    .flatten()
                    .min_by(|a, b| a.error_hz.total_cmp(&b.error_hz))
            }
            FeatureKind::Antiresonance => pole(&link, motors.iter().map(Vec::as_slice).collect()),
        };
        found
            .filter(|pole| pole.error_hz < LARGEST_FREQUENCY_ERROR * pole.hz)
            .ok_or(Unseen::NoPeak)
    }

    /// Returns whether both positions of a joint are above their noise.
    fn moves(&self, joint: usize, lines: &Range<usize>) -> bool {
        [&self.spectra.motor[joint], &self.spectra.link[joint]]
            .into_iter()
            .all(|position| {
                power(&position[lines.clone()]) > LEAST_SIGNAL_TO_NOISE * noise(position)
            })
    }

    /// Returns whether dry friction of a motor is a large part of its torque.
    fn is_disturbed(&self, joint: usize, lines: &Range<usize>) -> bool {
        let of = |all: &[Vec<c64>]| power(&all[joint][lines.clone()]);
        of(self.friction) > LARGEST_FRICTION * of(&self.spectra.torque)
    }

    /// Returns the estimates of a joint's motor and link at a line, unless noise or dry friction is too
    /// large there.
    fn response(&self, joint: usize, line: usize) -> Option<[Estimate; 2]> {
        let count = self.spectra.hz.len();
        let near = line.saturating_sub(POWER_LINES)..(line + POWER_LINES + 1).min(count);
        (self.moves(joint, &near) && !self.is_disturbed(joint, &near)).then_some(())?;
        estimates(self.spectra, joint, line)
    }
}

/// Returns the mean power of lines.
fn power(lines: &[c64]) -> f64 {
    lines.iter().map(c64::norm_sqr).sum::<f64>() / lines.len().max(1) as f64
}

/// Returns the power of the noise of a position: that of its highest lines, without motion.
fn noise(position: &[c64]) -> f64 {
    power(&position[position.len() - position.len() / 4..])
}

/// Returns the curves of a joint.
fn curves(
    model: &Model,
    log: &OfLog<'_>,
    linear: &Linear,
    spring: &Spring,
    features: Vec<Feature>,
) -> JointResponse {
    let spectra = log.spectra;
    let mut response = JointResponse {
        joint: model.joints()[spring.joint].clone(),
        frequency_hz: Vec::new(),
        motor: ResponseCurves::default(),
        link: ResponseCurves::default(),
        features,
    };
    let lines = lines(spectra, &response.features);
    let of_log: Vec<_> = (lines.iter())
        .map(|&line| log.response(spring.joint, line))
        .collect();
    if of_log.iter().all(Option::is_none) {
        return response;
    }
    for (line, of_log) in lines.into_iter().zip(of_log) {
        let hz = spectra.hz[line];
        let responses: Mat<c64> = linear.response(imaginary(hz), &[spring.motor]);
        response.frequency_hz.push(rounded(hz));
        for (curves, coordinate, k) in [
            (&mut response.motor, spring.motor, 0),
            (&mut response.link, spring.joint, 1),
        ] {
            let value = responses[(coordinate, 0)];
            curves.model_magnitude.push(rounded(value.norm()));
            curves
                .model_phase_deg
                .push(rounded(value.arg().to_degrees()));
            let known = of_log
                .map(|both| both[k])
                .filter(|estimate| estimate.error < LARGEST_RELATIVE_ERROR * estimate.value.norm());
            let of =
                |value: &dyn Fn(Estimate) -> f64| known.map(|estimate| rounded(value(estimate)));
            curves
                .log_magnitude
                .push(of(&|estimate| estimate.value.norm()));
            (curves.log_relative_error)
                .push(of(&|estimate| estimate.error / estimate.value.norm()));
            (curves.log_phase_deg).push(of(&|estimate| estimate.value.arg().to_degrees()));
            curves
                .log_coherence
                .push(of(&|estimate| estimate.coherence));
        }
    }
    response
}

/// Returns the lines of the curves: evenly on a logarithmic scale, and denser about the features.
fn lines(spectra: &Spectra, features: &[Feature]) -> Vec<usize> {
    let (Some(first), Some(last)) = (spectra.hz.first(), spectra.hz.last()) else {
        return Vec::new();
    };
    let highest = features
        .iter()
        .map(|feature| feature.model_hz)
        .fold(0.0, f64::max);
    let to = if highest > 0.0 {
        last.min(HIGHEST_OVER_FEATURES * highest)
    } else {
        *last
    };
    let spread = |from: f64, to: f64, count: usize| {
        (0..count).map(move |k| from * (to / from).powf(k as f64 / (count - 1) as f64))
    };
    let mut wanted: Vec<f64> = spread(*first, to, CURVE_POINTS).collect();
    for feature in features {
        let hz = feature.model_hz;
        wanted.extend(spread(
            (1.0 - FEATURE_RANGE) * hz,
            (1.0 + FEATURE_RANGE) * hz,
            FEATURE_POINTS,
        ));
    }
    let mut lines: Vec<usize> = (wanted.into_iter())
        .map(|hz| spectra.hz.partition_point(|line| *line < hz))
        .filter(|line| *line < spectra.hz.len())
        .collect();
    lines.sort_unstable();
    lines.dedup();
    lines
}

/// Returns a number with four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
