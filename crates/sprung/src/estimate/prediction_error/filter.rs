//! The extended Kalman filter of a robot whose torques are disturbed, and the
//! derivatives of its innovations.
//!
//! State: coordinates, their velocities, and one disturbance per row, \[3 rows\]. A
//! disturbance is a torque with a first-order spectrum; motor torques are noisy
//! besides. Measurements are taken one by one, which needs no matrix to be
//! inverted.

use super::covariance::{disturb, propagate, start_covariance, update};
use super::dynamics::{Dynamics, Tangent, add, scale};
use super::measurements::{Event, Record, Sensor, Stretch};
use super::unknowns::Unknowns;

/// Levels of the disturbances.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Levels {
    /// White noise of the torque, held for a period: standard deviation, N·m (N),
    /// \[rows\].
    pub(super) white: Vec<f64>,
    /// Disturbance with a first-order spectrum, likewise.
    pub(super) drift: Vec<f64>,
    /// Corner of that spectrum, Hz.
    pub(super) corner: f64,
    /// Noise of each sensor beyond what its samples show, standard deviation, rad
    /// (m).
    pub(super) sensor: Vec<f64>,
}

impl Levels {
    /// Returns the variance of a measurement.
    pub(super) fn variance(&self, event: &Event) -> f64 {
        event.variance + self.sensor[event.sensor].powi(2)
    }

    /// Returns what is left of a disturbance after a period, s.
    pub(super) fn left_after(&self, period: f64) -> f64 {
        Self::left(self.corner, period)
    }

    /// - `corner`: Hz.
    pub(super) fn left(corner: f64, period: f64) -> f64 {
        (-std::f64::consts::TAU * corner * period).exp()
    }
}

/// What a filter run leaves for others that follow its gains.
#[derive(Clone, Debug, Default)]
pub(super) struct Schedule {
    /// Gains of each measurement, \[measurements × 3 rows\], stretch after stretch.
    gains: Vec<f64>,
    /// One over the standard deviation of each innovation.
    whitening: Vec<f64>,
    /// Steps of the integration in each period.
    steps: Vec<u8>,
    /// Corner of the disturbances, Hz.
    pub(super) corner: f64,
    pub(super) path: Path,
    /// Derivatives of the state at the end of each period, of the first stretches:
    /// \[samples × 2 rows × 3 rows\], and the coordinates at its beginning,
    /// \[samples × rows\].
    pub(super) transitions: Vec<f64>,
    pub(super) positions: Vec<f64>,
}

/// Where gains led.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    innovations: Vec<f64>,
    /// Disturbances after each sample's measurements, \[samples × rows\], of the
    /// samples whose transitions are kept.
    pub(super) drift: Vec<f64>,
}

impl Schedule {
    /// Returns gains and innovation of each measurement.
    ///
    /// - `states`: \[3 rows\].
    pub(super) fn measured(&self, states: usize) -> impl Iterator<Item = (&[f64], f64)> {
        self.gains
            .chunks(states)
            .zip(self.path.innovations.iter().copied())
    }

    /// Returns what a run of other data would leave: innovations and disturbances
    /// times a factor.
    #[cfg(test)]
    pub(super) fn scaled(&self, factor: f64) -> Self {
        let mut other = self.clone();
        scale(&mut other.path.innovations, factor);
        scale(&mut other.path.drift, factor);
        other
    }
}

/// Normal equations of the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Normal {
    /// Number of unknowns.
    pub(super) count: usize,
    /// Information, \[count × count\]; the lower triangle is filled.
    pub(super) information: Vec<f64>,
    /// Gradient of half the cost, \[count\].
    pub(super) gradient: Vec<f64>,
}

impl Normal {
    pub(super) fn new(count: usize) -> Self {
        Self {
            count,
            information: vec![0.0; count * count],
            gradient: vec![0.0; count],
        }
    }

    /// Returns what came since others.
    fn without(&self, before: &Self) -> Self {
        let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
        Self {
            count: self.count,
            information: minus(&self.information, &before.information),
            gradient: minus(&self.gradient, &before.gradient),
        }
    }

    /// Returns those of the first unknowns.
    pub(super) fn first(&self, count: usize) -> Self {
        let rows = self.information.chunks(self.count.max(1)).take(count);
        Self {
            count,
            information: rows.flat_map(|row| &row[..count]).copied().collect(),
            gradient: self.gradient[..count].to_vec(),
        }
    }

    /// Takes an innovation with its derivatives.
    ///
    /// - `weight`: one over its variance.
    fn take(&mut self, innovation: f64, row: &[f64], weight: f64) {
        for (i, x) in row.iter().enumerate() {
            let x = weight * x;
            if x != 0.0 {
                self.gradient[i] += x * innovation;
                let own = &mut self.information[i * self.count..=i * self.count + i];
                add(own, x, &row[..=i]);
            }
        }
    }
}

/// What a run of the filter says.
#[derive(Clone, Debug)]
pub(super) struct Outcome {
    /// Sum of the squared whitened innovations.
    pub(super) cost: f64,
    /// Minus the logarithm of the likelihood, without its constant.
    pub(super) loss: f64,
    /// Number of measurements.
    pub(super) measurements: u64,
    pub(super) normal: Normal,
    /// The normal equations after parts of the samples: time, s, and sums so far.
    pub(super) growing: Vec<(f64, Normal)>,
    /// Those of each log alone, if there are several.
    pub(super) logs: Vec<Normal>,
}

/// What a run is to leave besides its cost.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wanted {
    /// Samples whose transitions are kept.
    pub(super) transitions: usize,
    /// Copies of the normal equations over time.
    pub(super) growing: usize,
}

/// Innovations whose whitened size is beyond this are as this: one bad sample
/// shall not decide.
const OUTLIER: f64 = 1e4;

/// Runs the filter over a record, with derivatives.
///
/// Derivatives are those of the filter with its gains held, so that they are exact
/// for [`replay`].
///
/// Returns nothing if a number is not finite.
pub(super) fn run(
    record: &Record,
    dynamics: &mut Dynamics<'_>,
    unknowns: &Unknowns,
    z: &[f64],
    levels: &Levels,
    wanted: Wanted,
) -> Option<(Outcome, Schedule)> {
    let rows = dynamics.rows();
    let count = unknowns.columns();
    dynamics.set(&unknowns.theta(z));
    let mut outcome = Outcome {
        cost: 0.0,
        loss: 0.0,
        measurements: 0,
        normal: Normal::new(count),
        growing: Vec::new(),
        logs: Vec::new(),
    };
    let logs = record.stretches.last().map_or(0, |stretch| stretch.log + 1);
    let mut before_log = Normal::new(count);
    let mut schedule = Schedule {
        corner: levels.corner,
        ..Schedule::default()
    };
    let every = record.samples().div_ceil(wanted.growing.max(1)).max(1);
    let mut tangent = Tangent::new(rows, 3 * rows + count, unknowns.places(3 * rows));
    let mut before = 0;
    let mut time = 0.0;
    for (part, stretch) in record.stretches.iter().enumerate() {
        let mut filter = Filter::new(rows, stretch, unknowns, z, levels);
        let mut sensitivity = unknowns.start(rows);
        for k in 0..stretch.samples() {
            for event in &stretch.events[stretch.first[k]..stretch.first[k + 1]] {
                let sensor = &record.sensors[event.sensor];
                let of = seen(sensor, event, rows);
                let expected = unknowns.offset(z, event.sensor) + measured(&filter.x, of.clone());
                let innovation = event.value - expected;
                filter.gain(of.clone(), levels.variance(event));
                let whitened = (innovation / filter.deviation).clamp(-OUTLIER, OUTLIER);
                outcome.cost += whitened * whitened;
                outcome.loss += 0.5 * whitened * whitened + filter.deviation.ln();
                outcome.measurements += 1;
                filter.row.fill(0.0);
                for (state, weight) in of {
                    let own = &sensitivity[state * count..(state + 1) * count];
                    add(&mut filter.row, -weight, own);
                }
                let velocity = &filter.x[rows..2 * rows];
                unknowns.innovation(&mut filter.row, event.sensor, &sensor.of, velocity);
                let row = &filter.row;
                let variance = filter.deviation * filter.deviation;
                outcome.normal.take(innovation, row, 1.0 / variance);
                schedule.gains.extend_from_slice(&filter.gains);
                schedule.path.innovations.push(innovation);
                schedule.whitening.push(1.0 / filter.deviation);
                let by_state = sensitivity.chunks_mut(count.max(1));
                for (gain, own) in filter.gains.iter().zip(by_state) {
                    if *gain != 0.0 {
                        add(own, *gain, row);
                    }
                }
                filter.correct(innovation);
            }
            if !filter.x.iter().all(|x| x.is_finite()) || !outcome.loss.is_finite() {
                return None;
            }
            let keep = before + k < wanted.transitions;
            if keep {
                schedule.path.drift.extend_from_slice(&filter.x[2 * rows..]);
                schedule.positions.extend_from_slice(&filter.x[..rows]);
            }
            let stored = keep.then_some(&mut schedule.transitions);
            let steps = filter.predict(
                dynamics,
                stretch,
                k,
                (&mut tangent, &mut sensitivity),
                unknowns,
                stored,
            );
            schedule.steps.push(steps as u8);
            if (before + k + 1).is_multiple_of(every) {
                let at = time + (k + 1) as f64 * stretch.period;
                outcome.growing.push((at, outcome.normal.clone()));
            }
        }
        let next = record.stretches.get(part + 1);
        if logs > 1 && next.is_none_or(|next| next.log != stretch.log) {
            outcome.logs.push(outcome.normal.without(&before_log));
            before_log = outcome.normal.clone();
        }
        before += stretch.samples();
        time += stretch.period * stretch.samples() as f64;
    }
    Some((outcome, schedule))
}

/// Returns the cost at other values of the unknowns, with gains and steps held, and
/// where they lead; nothing if a number is not finite.
pub(super) fn replay(
    record: &Record,
    dynamics: &mut Dynamics<'_>,
    unknowns: &Unknowns,
    z: &[f64],
    schedule: &Schedule,
) -> Option<(f64, Path)> {
    let rows = dynamics.rows();
    dynamics.set(&unknowns.theta(z));
    let mut gains = schedule.gains.chunks(3 * rows);
    let mut whitening = schedule.whitening.iter();
    let mut steps = schedule.steps.iter();
    let mut cost = 0.0;
    let mut torque = vec![0.0; rows];
    let mut path = Path::default();
    let kept = schedule.path.drift.len();
    for stretch in &record.stretches {
        let left = Levels::left(schedule.corner, stretch.period);
        let mut x = start(rows, stretch, unknowns, z);
        for k in 0..stretch.samples() {
            for event in &stretch.events[stretch.first[k]..stretch.first[k + 1]] {
                let (gains, whitening) = (gains.next()?, whitening.next()?);
                let sensor = &record.sensors[event.sensor];
                let of = seen(sensor, event, rows);
                let innovation = event.value - unknowns.offset(z, event.sensor) - measured(&x, of);
                let whitened = (innovation * whitening).clamp(-OUTLIER, OUTLIER);
                cost += whitened * whitened;
                path.innovations.push(innovation);
                add(&mut x, innovation, gains);
            }
            if !cost.is_finite() || !x.iter().all(|x| x.is_finite()) {
                return None;
            }
            let (state, drift) = x.split_at_mut(2 * rows);
            if path.drift.len() < kept {
                path.drift.extend_from_slice(drift);
            }
            disturbed(stretch, k, drift, &mut torque);
            let steps = steps.next().copied().unwrap_or(1);
            dynamics.advance(state, &torque, stretch.period, usize::from(steps));
            scale(drift, left);
        }
    }
    Some((cost, path))
}

/// Returns the state at the start of a stretch, \[3 rows\].
fn start(rows: usize, stretch: &Stretch, unknowns: &Unknowns, z: &[f64]) -> Vec<f64> {
    let mut x = stretch.start.clone();
    unknowns.shift_start(z, &mut x);
    x.resize(3 * rows, 0.0);
    x
}

/// Returns the states that a measurement sees, and how much of each: coordinates,
/// and their velocities since it was taken.
pub(super) fn seen(
    sensor: &Sensor,
    event: &Event,
    rows: usize,
) -> impl Iterator<Item = (usize, f64)> + Clone {
    let before = event.before;
    let moved = move |&(coordinate, weight): &(usize, f64)| (rows + coordinate, -weight * before);
    let velocities = sensor.of.iter().filter(move |_| before > 0.0).map(moved);
    sensor.of.iter().copied().chain(velocities)
}

/// Returns the sum that a measurement sees.
pub(super) fn measured(x: &[f64], of: impl Iterator<Item = (usize, f64)>) -> f64 {
    of.map(|(state, weight)| weight * x[state]).sum()
}

/// Writes the torque of a sample with its disturbance.
fn disturbed(stretch: &Stretch, k: usize, drift: &[f64], torque: &mut [f64]) {
    let rows = drift.len();
    let own = &stretch.torque[k * rows..(k + 1) * rows];
    for (sum, (tau, drift)) in torque.iter_mut().zip(own.iter().zip(drift)) {
        *sum = tau + drift;
    }
}

/// State and covariance on their way.
struct Filter<'a> {
    rows: usize,
    levels: &'a Levels,
    x: Vec<f64>,
    // Covariance, [3 rows × 3 rows], symmetric.
    covariance: Vec<f64>,
    // Of the last measurement.
    column: Vec<f64>,
    gains: Vec<f64>,
    deviation: f64,
    row: Vec<f64>,
    transition: Vec<f64>,
    product: Vec<f64>,
    torque: Vec<f64>,
}

impl<'a> Filter<'a> {
    fn new(
        rows: usize,
        stretch: &Stretch,
        unknowns: &Unknowns,
        z: &[f64],
        levels: &'a Levels,
    ) -> Self {
        let states = 3 * rows;
        Self {
            rows,
            x: start(rows, stretch, unknowns, z),
            covariance: start_covariance(rows, stretch, levels),
            levels,
            column: vec![0.0; states],
            gains: vec![0.0; states],
            deviation: 1.0,
            row: vec![0.0; unknowns.columns()],
            transition: vec![0.0; 2 * rows * states],
            product: vec![0.0; 2 * rows * states],
            torque: vec![0.0; rows],
        }
    }

    /// Writes the gains of a measurement and takes it into the covariance.
    fn gain(&mut self, of: impl Iterator<Item = (usize, f64)> + Clone, variance: f64) {
        let variance = update(&mut self.covariance, of, variance, &mut self.column);
        self.deviation = variance.sqrt();
        for (gain, column) in self.gains.iter_mut().zip(&self.column) {
            *gain = column / variance;
        }
    }

    fn correct(&mut self, innovation: f64) {
        add(&mut self.x, innovation, &self.gains);
    }

    /// Moves on by a period; returns the steps of the integration.
    fn predict(
        &mut self,
        dynamics: &mut Dynamics<'_>,
        stretch: &Stretch,
        k: usize,
        (tangent, sensitivity): (&mut Tangent, &mut [f64]),
        unknowns: &Unknowns,
        stored: Option<&mut Vec<f64>>,
    ) -> usize {
        let (rows, count) = (self.rows, unknowns.columns());
        let (period, left) = (stretch.period, self.levels.left_after(stretch.period));
        let (state, drift) = self.x.split_at_mut(2 * rows);
        disturbed(stretch, k, drift, &mut self.torque);
        let steps = dynamics.steps(state, &self.torque, period);
        let width = tangent.columns;
        let own = 3 * rows;
        for (i, row) in tangent.state.chunks_mut(width).enumerate() {
            row[..own].fill(0.0);
            row[i] = 1.0;
            row[own..].copy_from_slice(&sensitivity[i * count..(i + 1) * count]);
        }
        for (i, row) in tangent.torque.chunks_mut(width).enumerate() {
            row[..own].fill(0.0);
            row[2 * rows + i] = 1.0;
            let at = (2 * rows + i) * count;
            row[own..].copy_from_slice(&sensitivity[at..at + count]);
            unknowns.torque(&mut row[own..], stretch, k, i);
        }
        dynamics.advance_tangent(state, &self.torque, period, steps, tangent);
        scale(drift, left);
        for (i, row) in tangent.state.chunks(width).enumerate() {
            sensitivity[i * count..(i + 1) * count].copy_from_slice(&row[own..]);
        }
        sensitivity[2 * rows * count..]
            .iter_mut()
            .for_each(|s| *s *= left);
        for (out, row) in self
            .transition
            .chunks_mut(own)
            .zip(tangent.state.chunks(width))
        {
            out.copy_from_slice(&row[..own]);
        }
        propagate(
            &mut self.covariance,
            &self.transition,
            &mut self.product,
            left,
        );
        disturb(&mut self.covariance, &self.transition, self.levels, left);
        if let Some(stored) = stored {
            stored.extend_from_slice(&self.transition);
        }
        steps
    }
}
