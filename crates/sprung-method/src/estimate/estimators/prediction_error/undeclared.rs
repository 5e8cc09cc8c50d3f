//! Unknowns that the model lacks. One further run of the filter takes the derivatives by all of them, at zero, and the selection of
//! the catalogue judges them by the innovations.

use faer::Mat;

use super::effects::{Effect, Filtered, TorquesTiming, of_delays};
use super::filter::NormalEquations;
use super::findings::largest_move;
use super::finish::last_run;
use super::measurements::{Measurements, with_laws};
use super::parts::equal_parts;
use super::problem::Problem;
use super::refine::{End, Refinery};
use super::refined::Refined;
use super::rung::Rung;
use super::start_levels::Searches;
use super::unknowns::{Prior, Unknowns};
use crate::description::Experiment;
use crate::estimate::statistics::NORMAL_95;
use crate::log::{Channels, Signal};
use crate::model::Model;
use crate::regression::PassError;
use crate::unknowns::{
    Effect as OfUnknown, Found, Innovations, Kind, LawColumn, OfLikelihood, PARTS_OF_INNOVATIONS,
    Place, Pull, Shown, Unknown, changed,
};
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

/// Error of the correction for noise of the logged torques, relative to the correction. Errors in tests of the
/// correction: up to 10 % for single parameters.
const ERROR_OF_NOISE_CORRECTION: f64 = 0.05;

/// Least practical sizes: of a delay in samples, of an angle in counts of an encoder.
const LEAST_DELAY_SAMPLES: f64 = 0.1;
const LEAST_COUNTS: f64 = 0.2;

/// An unknown that the log shows beside the model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Undeclared {
    pub(super) found: Found,
    /// Value over the least practical size.
    pub(super) size: f64,
    /// Moves of the refined parameters with it, \[free\].
    pub(super) moves: Vec<f64>,
}

impl Undeclared {
    /// Returns the value in standard errors.
    pub(super) fn significance(&self) -> f64 {
        self.found.value.abs() / self.found.standard_error
    }

    /// Returns whether it has a practical size or moves a parameter out of its interval.
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

/// Returns the possible error of each parameter by undeclared unknowns: its largest change with one of them, \[p\]. The
/// error of the correction for noise counts as such a change.
pub(super) fn bias(refined: &Refined, undeclared: &[Undeclared]) -> Vec<f64> {
    let moves = undeclared.iter().map(|undeclared| &undeclared.moves[..]);
    let mut largest = largest_moves(refined.theta.len(), &refined.free, moves);
    for (&index, moved) in refined.free.iter().zip(&refined.by_noise) {
        largest[index] = largest[index].max(ERROR_OF_NOISE_CORRECTION * moved.abs());
    }
    largest
}

/// Returns the largest change of each parameter by one of several unknowns, \[p\].
///
/// - `free`: indices of the parameters that move; `moves`: with each unknown, \[free\].
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

/// Change of a parameter, in standard errors, from which a smaller unknown is relevant on a lower rung, and the least
/// size of such an unknown relative to a practical size.
const FAR_MOVE: f64 = 10.0;
const LEAST_FAR_SIZE: f64 = 0.5;

/// Where the derivative by an unknown stands.
#[derive(Clone, Copy)]
enum Column {
    /// Among the parameters.
    Law(usize),
    /// Among the effects, behind all values.
    Effect(usize),
}

/// The columns of a last run.
struct Columns {
    /// Parameters: those that were refined, then those of laws.
    free: Vec<usize>,
    /// Delays to be estimated, then effects of unknowns.
    effects: Vec<Effect>,
    /// Number of delays to be estimated.
    open: usize,
    /// Column of each unknown.
    places: Vec<Column>,
}

impl Refinery<'_> {
    /// Tests the unknowns that the model lacks at the end of a rung.
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
        let Some(measurements) = self.measurements(&end.delays)? else {
            return Ok(Vec::new());
        };
        let theta = &end.refined.theta;
        let mut catalogue = OfLikelihood::new(experiment, self.reading, self.excerpt, theta);
        catalogue.retain(|unknown| !self.is_estimated(unknown));
        let channels = self.reading.channels();
        let richer = with_laws_of(experiment, self.reading.model(), &catalogue.unknowns);
        let measurements = with_laws(&measurements, &richer, channels);
        let found = self.found((rung, end), &richer, (&mut catalogue, &measurements));
        Ok(found.unwrap_or_default())
    }

    /// Returns whether the refinement estimates an unknown anyway.
    fn is_estimated(&self, unknown: &Unknown) -> bool {
        let is_estimated = |i: &usize| self.start.delays.contains(i);
        let is_timing = unknown.place == Place::All(Signal::Torque)
            && self.start.torques == TorquesTiming::Estimated;
        unknown.kind == Kind::Delay && (is_timing || unknown.channels().iter().all(is_estimated))
    }

    fn found(
        &self,
        (rung, end): (Rung, &End),
        richer: &Model,
        (catalogue, measurements): (&mut OfLikelihood, &Measurements),
    ) -> Option<Vec<Undeclared>> {
        let (theta, free) = self.in_model(end, richer)?;
        let before = free.len();
        let channels = self.reading.channels();
        let joints = catalogue.joints.clone();
        let filtered = Filtered {
            model: richer,
            channels,
            measurements,
            theta: &theta,
            joints: &joints,
        };
        let columns = self.columns(catalogue, free, &filtered);
        let (open, laws) = (columns.open, columns.free.len() - before);
        let unknowns = Unknowns::new(richer, channels, measurements, &theta, columns.free)
            .with_presliding_levels(end.presliding.clone())
            .with_bends_of(&end.scales())
            .with_effects(columns.effects);
        let mut z = end.z.clone();
        z.splice(before..before, vec![0.0; laws]);
        let values = unknowns.values();
        if z.len() != values {
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
        let follows: Vec<usize> = (0..values + open)
            .filter(|place| !(before..before + laws).contains(place))
            .collect();
        let tested = (columns.places.iter()).map(|place| match *place {
            Column::Law(at) => at,
            Column::Effect(at) => values + at,
        });
        let order: Vec<usize> = follows.iter().copied().chain(tested).collect();
        let cost = sums.cost / PARTS_OF_INNOVATIONS as f64;
        let parts = equal_parts(&problem, &sums, PARTS_OF_INNOVATIONS);
        let place = |at: usize| follows.iter().position(|follows| *follows == at);
        let pull = |prior: Prior| {
            Some(Pull {
                at: place(prior.at)?,
                weight: prior.deviation.powi(-2),
                away: z[prior.at] - prior.mean,
            })
        };
        let innovations = Innovations {
            parts: (parts.iter())
                .map(|part| products(&part.normal, &order, cost))
                .collect(),
            priors: unknowns.priors().filter_map(pull).collect(),
        };
        let joint_of = |channel: usize| channels.all[channel].joint;
        let shown = catalogue.shown(innovations, &joint_of).into_iter();
        let scales = Scales {
            model: richer,
            channels,
            measurements,
            free: &unknowns.free[..before],
            period: self.excerpt.period(),
        };
        Some(
            shown
                .map(|shown| scales.undeclared(catalogue, shown))
                // On a lower rung the model error is larger than an unknown without a practical size, unless it moves a parameter
                // far out of its interval.
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

    /// Returns the columns of everything that the filter sees, and drops the other unknowns.
    ///
    /// - `free`: refined parameters.
    fn columns(
        &self,
        catalogue: &mut OfLikelihood,
        mut free: Vec<usize>,
        filtered: &Filtered<'_>,
    ) -> Columns {
        let timing = self.start.torques;
        let mut effects = of_delays(filtered, (&self.start.delays, timing));
        let open = self.start.delays.len() + usize::from(timing == TorquesTiming::Estimated);
        effects.truncate(open);
        let mut places = Vec::new();
        catalogue.retain(|unknown| {
            let place = match parameter_of(unknown, filtered.model) {
                Some(index) => {
                    free.push(index);
                    Some(Column::Law(free.len() - 1))
                }
                None => Effect::of(unknown, filtered).map(|effect| {
                    effects.push(effect);
                    Column::Effect(effects.len() - 1)
                }),
            };
            places.extend(place);
            place.is_some()
        });
        Columns {
            free,
            effects,
            open,
            places,
        }
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

/// Returns the parameter of a law that the richer model has.
fn parameter_of(unknown: &Unknown, richer: &Model) -> Option<usize> {
    match (&unknown.effect, unknown.place) {
        (
            OfUnknown::Law {
                column: LawColumn::Terms(terms),
                ..
            },
            Place::Joint(joint),
        ) => richer.index(terms.first()?.0.what, joint),
        _ => None,
    }
}

/// Returns the model with the laws of some unknowns.
fn with_laws_of(experiment: &Experiment, model: &Model, unknowns: &[Unknown]) -> Model {
    let mut richer = experiment.clone();
    for unknown in unknowns {
        if let (Some(law), Place::Joint(joint)) = (unknown.added(), unknown.place) {
            let described = &mut richer.robot.joint[joint];
            *described = changed(described.clone(), law);
        }
    }
    let richer = Model::new(&richer).map(|richer| richer.with_velocities_of(model));
    richer.unwrap_or_else(|_| model.clone())
}

/// Returns the products of some columns and of the innovations of a part.
fn products(normal: &NormalEquations, order: &[usize], cost: f64) -> Mat<f64> {
    let last = order.len();
    Mat::from_fn(last + 1, last + 1, |i, j| {
        match (order.get(i), order.get(j)) {
            (Some(&i), Some(&j)) => normal.information[i.max(j) * normal.count + i.min(j)],
            (Some(&at), None) | (None, Some(&at)) => -normal.gradient[at],
            (None, None) => cost,
        }
    })
}

/// The scales of practical sizes.
struct Scales<'a> {
    model: &'a Model,
    channels: &'a Channels,
    measurements: &'a Measurements,
    /// Indices of the refined parameters.
    free: &'a [usize],
    period: f64,
}

impl Scales<'_> {
    fn undeclared(&self, catalogue: &OfLikelihood, shown: Shown) -> Undeclared {
        let (found, mut moves) = (shown.found, shown.moves);
        moves.truncate(self.free.len());
        let viscous = JointParameter::Friction(Side::Motor, Law::Viscous);
        if let (Kind::WarmUp, Place::Joint(joint)) = (found.kind, found.place)
            && let Some(index) = self.model.index(viscous, joint)
            && let Some(place) = self.free.iter().position(|free| *free == index)
        {
            // The value at the beginning and that at the end differ from the mean by half the change.
            moves[place] = moves[place].abs().max(0.5 * found.value.abs());
        }
        let unknown = &catalogue.unknowns[shown.unknown];
        let least = match unknown.kind {
            Kind::Delay => LEAST_DELAY_SAMPLES * self.period,
            Kind::Eccentricity | Kind::TransmissionError => LEAST_COUNTS * self.count(found.place),
            _ => unknown.least_size(catalogue.scales[shown.unknown]),
        };
        Undeclared {
            size: found.value.abs() / least,
            found,
            moves,
        }
    }

    /// Returns the count of the encoder of a channel, or of a joint's link, rad (m).
    fn count(&self, place: Place) -> f64 {
        let is_of_place = |channel: usize| match place {
            Place::Joint(joint) => {
                let of = &self.channels.all[channel];
                of.joint == joint && of.quantity.signal() == Signal::Link
            }
            Place::Channel(_) | Place::All(_) | Place::Robot => {
                place.contains(channel, self.channels)
            }
        };
        let sensors = self.measurements.sensors.iter();
        let of_place = sensors.filter(|sensor| is_of_place(sensor.channel));
        of_place.fold(0.0, |most, sensor| {
            most.max((12.0 * sensor.noise.variance()).sqrt())
        })
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
