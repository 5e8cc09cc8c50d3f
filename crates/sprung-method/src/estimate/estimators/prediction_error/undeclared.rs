//! Effects that the model lacks: laws, delays, saturations, encoders that are not centred, ripples of the torque, errors
//! of gears, friction that drifts. One further run of the filter takes the derivatives by all of them, at zero.

use super::competition::{Entrant, Evidence, Winner, winners};
use super::effects::TorquesTiming;
use super::effects::{Effect, of_delays, of_drives, of_sensors};
use super::findings::largest_move;
use super::finish::last_run;
use super::measurements::{Measurements, with_laws};
use super::parts::folds;
use super::problem::{Problem, add_prior};
use super::refine::{End, Refinery};
use super::refined::Refined;
use super::rung::Rung;
use super::start_levels::Searches;
use super::unknowns::Unknowns;
use crate::description::Experiment;
use crate::estimate::laws::{Tested, with_tested_laws};
use crate::estimate::statistics::NORMAL_95;
use crate::model::Model;
use crate::prepare::rms_speeds;
use crate::regression::PassError;
use sprung_core::friction::Law;
use sprung_core::parameters::JointParameter;

/// Error of the correction for noise of the logged torques, relative to the correction. Errors in tests of the
/// correction: up to 10 % for single parameters.
const ERROR_OF_NOISE_CORRECTION: f64 = 0.05;

/// Least practical sizes: of a torque relative to the standard deviation of the joint's torque, of a delay in samples,
/// of an angle in counts of an encoder.
pub(super) const LEAST_TORQUE_SHARE: f64 = 0.01;
const LEAST_DELAY_SAMPLES: f64 = 0.1;
const LEAST_COUNTS: f64 = 0.2;

/// An effect that the model lacks.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cause {
    Law(Tested),
    /// Channel, and the effect.
    Effect(usize, Effect),
}

/// An effect that the log shows, beside those that explain more.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Undeclared {
    pub(super) cause: Cause,
    /// Value, of a wave the amplitude.
    pub(super) value: f64,
    pub(super) standard_error: f64,
    /// Value over the least practical size.
    pub(super) size: f64,
    /// Moves of the refined parameters with it, \[free\].
    pub(super) moves: Vec<f64>,
    /// Gain of the log-likelihood of held-out folds.
    pub(super) gain: f64,
    /// Of the value; empty for ratios.
    pub(super) unit: &'static str,
}

impl Undeclared {
    /// Returns the value in standard errors.
    pub(super) fn significance(&self) -> f64 {
        self.value.abs() / self.standard_error
    }

    /// Returns whether the effect has a practical size or moves a parameter out of its interval.
    pub(super) fn matters(&self, refined: &Refined) -> bool {
        self.size >= 1.0
            || self
                .largest_move(refined)
                .is_some_and(|(_, moved)| moved > NORMAL_95)
    }

    /// Returns the refined parameter with the largest change: index in theta and change in standard
    /// errors.
    pub(super) fn largest_move(&self, refined: &Refined) -> Option<(usize, f64)> {
        largest_move(refined, &self.moves)
    }
}

/// Returns the possible error of each parameter by undeclared effects: its largest change with one of them, \[p\]. The
/// error of the correction for noise counts as such a change.
pub(super) fn bias(refined: &Refined, undeclared: &[Undeclared]) -> Vec<f64> {
    let moves = undeclared.iter().map(|undeclared| &undeclared.moves[..]);
    let mut largest = largest_moves(refined.theta.len(), &refined.free, moves);
    for (&index, moved) in refined.free.iter().zip(&refined.by_noise) {
        largest[index] = largest[index].max(ERROR_OF_NOISE_CORRECTION * moved.abs());
    }
    largest
}

/// Returns the largest change of each parameter by one of several effects, \[p\].
///
/// - `free`: indices of the parameters that move; `moves`: with each effect, \[free\].
fn largest_moves<'m>(
    parameters: usize,
    free: &[usize],
    moves: impl Iterator<Item = &'m [f64]>,
) -> Vec<f64> {
    let mut largest = vec![0.0_f64; parameters];
    for moves in moves {
        for (&index, movement) in free.iter().zip(moves) {
            if movement.is_finite() {
                largest[index] = largest[index].max(movement.abs());
            }
        }
    }
    largest
}

/// Change of a parameter, in standard errors, from which a smaller effect is relevant on a lower rung, and the least
/// size of such an effect relative to a practical size.
const FAR_MOVE: f64 = 10.0;
const LEAST_FAR_SIZE: f64 = 0.5;

impl Refinery<'_> {
    /// Tests the effects that the model lacks at the end of a rung.
    ///
    /// # Errors
    ///
    /// [`PassError`] if the filter of positions does not fit a log.
    pub(super) fn undeclared(
        &self,
        rung: Rung,
        end: &End,
        experiment: &Experiment,
    ) -> Result<Vec<Undeclared>, PassError> {
        let speeds = rms_speeds(self.reading, self.excerpt);
        let tested = with_tested_laws(experiment, self.reading.model(), &speeds);
        let (Some(measurements), Ok((richer, tested))) = (self.measurements(&end.delays)?, tested)
        else {
            return Ok(Vec::new());
        };
        let (richer, tested) = (&richer, &*tested);
        let channels = self.reading.channels();
        let measurements = with_laws(&measurements, richer, channels);
        Ok(self
            .found((rung, end), experiment, (richer, tested), &measurements)
            .unwrap_or_default())
    }

    fn found(
        &self,
        (rung, end): (Rung, &End),
        experiment: &Experiment,
        (richer, tested): (&Model, &[Tested]),
        measurements: &Measurements,
    ) -> Option<Vec<Undeclared>> {
        let (theta, free) = self.in_model(end, richer)?;
        let before = free.len();
        let free = (free.into_iter())
            .chain(tested.iter().map(|law| law.parameter))
            .collect();
        let channels = self.reading.channels();
        let estimated = (&*self.start.delays, self.start.torques);
        let mut effects = of_delays(richer, channels, measurements, estimated);
        effects.extend(of_sensors(richer, channels, measurements));
        effects.extend(of_drives(
            experiment,
            richer,
            (channels, measurements),
            &theta,
        ));
        let unknowns = Unknowns::new(richer, channels, measurements, &theta, free)
            .with_presliding_levels(end.presliding.clone())
            .with_bends_of(&end.scales())
            .with_effects(effects.clone());
        let mut z = end.z.clone();
        z.splice(before..before, vec![0.0; tested.len()]);
        if z.len() != unknowns.values() {
            return None;
        }
        let noise = self.start.torque_noise;
        let searches = Searches::new(richer, measurements, noise, rung, &end.levels);
        let problem = Problem {
            model: richer,
            measurements,
            unknowns: &unknowns,
            levels: &searches.shown,
            noisy_rows: &noise.rows(richer),
            guard: None,
            robots: None,
        };
        let (sums, _) = last_run(&problem, &unknowns, (&z, &end.levels))?;
        let folds = folds(&problem, &sums);
        let mut normal = sums.normal.clone();
        add_prior(&unknowns, &z, &mut normal);
        let evidence = Evidence {
            normal: &normal,
            gradients: &sums.gradients,
            folds: &folds.iter().map(|fold| &fold.normal).collect::<Vec<_>>(),
            duration: measurements.duration(),
        };
        let values = unknowns.values();
        let is_law = |place: &usize| (before..before + tested.len()).contains(place);
        let open = estimated.0.len() + usize::from(estimated.1 == TorquesTiming::Estimated);
        let active = (0..values + open).filter(|place| !is_law(place)).collect();
        let laws = tested.iter().enumerate();
        let (mut causes, mut entrants): (Vec<Cause>, Vec<Entrant>) = laws
            .map(|(i, law)| {
                let entrant = Entrant {
                    joint: Some(law.joint),
                    columns: vec![before + i],
                };
                (Cause::Law(law.clone()), entrant)
            })
            .unzip();
        for (i, &(channel, effect)) in effects.iter().enumerate().skip(open) {
            match entrants.last_mut() {
                Some(entrant) if effect.is_cosine() => entrant.columns.push(values + i),
                _ => {
                    let of_all = effect == Effect::TorquesDelay;
                    causes.push(Cause::Effect(channel, effect));
                    entrants.push(Entrant {
                        joint: (!of_all).then_some(channels.all[channel].joint),
                        columns: vec![values + i],
                    });
                }
            }
        }
        let scales = Scales {
            model: richer,
            measurements,
            theta: &theta,
            free: &unknowns.free[..before],
            period: self.excerpt.period(),
        };
        let found = winners(&evidence, active, &entrants).into_iter();
        Some(
            found
                .map(|winner| scales.undeclared(causes[winner.effect].clone(), &winner))
                // On a lower rung the model error is larger than an effect without a practical size, unless the effect
                // moves a parameter far out of its interval.
                .filter(|undeclared| {
                    let is_far = || {
                        undeclared
                            .largest_move(&end.refined)
                            .is_some_and(|(_, moved)| moved > FAR_MOVE)
                    };
                    rung == Rung::Free
                        || undeclared.size >= 1.0
                        || undeclared.size >= LEAST_FAR_SIZE && is_far()
                })
                .collect(),
        )
    }

    /// Returns the parameters of a richer model at an end, and the indices of those that were refined.
    fn in_model(&self, end: &End, richer: &Model) -> Option<(Vec<f64>, Vec<usize>)> {
        let parameters = self.reading.model().parameters();
        let place = |name: &str| richer.parameters().iter().position(|p| p.name == name);
        let mut theta = vec![0.0; richer.parameters().len()];
        for (parameter, value) in parameters.iter().zip(&end.refined.theta) {
            if let Some(at) = place(&parameter.name) {
                theta[at] = *value;
            }
        }
        let free = (end.refined.free.iter()).map(|&index| place(&parameters[index].name));
        Some((theta, free.collect::<Option<Vec<usize>>>()?))
    }
}

/// The scales of practical sizes.
struct Scales<'a> {
    model: &'a Model,
    measurements: &'a Measurements,
    theta: &'a [f64],
    /// Indices of the refined parameters.
    free: &'a [usize],
    period: f64,
}

impl Scales<'_> {
    fn undeclared(&self, cause: Cause, winner: &Winner) -> Undeclared {
        let mut moves = winner.moves[..self.free.len()].to_vec();
        if let Cause::Effect(
            _,
            Effect::Drift {
                parameter, viscous, ..
            },
        ) = cause
            && let Some(place) = self.free.iter().position(|index| *index == parameter)
        {
            // The value at the beginning and that at the end differ from the mean by half the change.
            moves[place] = moves[place].abs().max((0.5 * winner.value * viscous).abs());
        }
        Undeclared {
            size: self.size(&cause, winner.value.abs()),
            unit: match &cause {
                Cause::Law(law) => self.model.parameters()[law.parameter].unit,
                Cause::Effect(_, effect) => effect.unit(),
            },
            cause,
            value: winner.value,
            standard_error: winner.standard_error,
            moves,
            gain: winner.gain,
        }
    }

    /// Returns a value over the least practical size of its effect.
    fn size(&self, cause: &Cause, value: f64) -> f64 {
        let counts = |sensor: usize| {
            let variance = self.measurements.sensors[sensor].noise.variance();
            value / (LEAST_COUNTS * (12.0 * variance).sqrt())
        };
        match cause {
            Cause::Law(law) => self.torque_of_law(law, value) / LEAST_TORQUE_SHARE,
            Cause::Effect(_, effect) => match *effect {
                Effect::SensorDelay(_) | Effect::TorqueDelay(_) | Effect::TorquesDelay => {
                    value / (LEAST_DELAY_SAMPLES * self.period)
                }
                Effect::Saturation { .. } | Effect::Ripple { .. } => value / LEAST_TORQUE_SHARE,
                Effect::Eccentricity { sensor, .. } => counts(sensor),
                Effect::TransmissionError { link, .. } => {
                    let sensors = self.measurements.sensors.iter();
                    let of_link = |coordinates: &[(usize, f64)]| coordinates == [(link, 1.0)];
                    let sensor = sensors
                        .clone()
                        .position(|sensor| of_link(&sensor.coordinates));
                    sensor.map_or(f64::INFINITY, counts)
                }
                Effect::Drift { row, viscous, .. } => {
                    let speed = self.speed(row);
                    let share = viscous.abs() * speed / self.measurements.torque_scale[row];
                    // Half of the change to each side of the mean.
                    0.5 * value * share / LEAST_TORQUE_SHARE
                }
            },
        }
    }

    /// Returns the root mean square velocity of a coordinate with a separate sensor, rad/s (m/s).
    fn speed(&self, coordinate: usize) -> f64 {
        let sensors = self.measurements.sensors.iter();
        let index = sensors
            .clone()
            .position(|sensor| sensor.coordinates == [(coordinate, 1.0)]);
        let segments = self.measurements.segments.iter();
        index.map_or(0.0, |sensor| {
            segments.fold(0.0, |most, segment| most.max(segment.speeds[sensor]))
        })
    }

    /// Returns the torque of a law relative to the standard deviation of the joint's torque.
    fn torque_of_law(&self, law: &Tested, value: f64) -> f64 {
        let torque = self.measurements.torque_scale[self.model.torque_row(law.joint)];
        let stiffness = self.model.index(JointParameter::Stiffness, law.joint);
        let stiffness = stiffness.map_or(f64::INFINITY, |index| self.theta[index].abs());
        match self.model.parameters()[law.parameter].joint {
            Some((JointParameter::CubicStiffness, _)) => {
                value * (torque / stiffness).powi(3) / torque
            }
            Some((JointParameter::Friction(_, Law::Load), _)) => value / stiffness,
            _ => value / torque,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_move_by_an_effect_counts() {
        let moves = [[-0.5, f64::NAN], [0.2, 0.3]];
        let moves = moves.iter().map(|movement| &movement[..]);
        assert_eq!(largest_moves(4, &[1, 3], moves), [0.0, 0.5, 0.0, 0.3]);
    }
}
