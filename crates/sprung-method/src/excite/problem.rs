//! The search for a motion as a problem without constraints: an objective, and barriers at the limits.

use faer::Mat;
use sprung_core::scalar::{Dual, Scalar};

use super::bounds::{Bounds, FREE_HEIGHT, Interval, Limited, height_used};
use super::follows::Follows;
use super::fourier::{Basis, Series};
use super::information::Weighting;
use super::kinematics::Kinematics;
use super::motion::{ByMotion, Moved, waves};
use super::objective::Aim;
use super::physics::MotionAt;
use crate::model::Model;

/// One set of values that the robot may have.
#[derive(Clone, Debug)]
pub(super) struct Scenario {
    pub(super) theta: Vec<f64>,
    pub(super) follows: Follows,
    pub(super) weighting: Weighting,
}

/// A search for a motion within limits.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub(super) model: Model,
    pub(super) rate: f64,
    pub(super) harmonics: Vec<usize>,
    pub(super) bases: Vec<Basis>,
    pub(super) bounds: Bounds,
    pub(super) scenarios: Vec<Scenario>,
    pub(super) kinematics: Option<Kinematics>,
    pub(super) aim: Aim,
    /// Time between samples of the motion, s.
    pub(super) sample: f64,
    /// Derivatives of the reference by the free numbers, of each joint and order, \[samples × free\].
    reference: Vec<[Mat<f64>; 4]>,
}

/// The largest place of a limited quantity; between -1 and 1 inside the limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak {
    pub(super) what: Limited,
    pub(super) joint: usize,
    pub(super) place: f64,
    pub(super) time: f64,
}

/// The part of the robot on which a limited quantity is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RobotPart {
    Link,
    Motor,
    /// Origin of a joint's frame, or the tool after the last joint.
    Point(usize),
}

/// A limited quantity at one sample.
#[derive(Clone, Copy, Debug)]
struct Seen {
    what: Limited,
    joint: usize,
    on: RobotPart,
    t: usize,
    place: f64,
    interval: Interval,
}

/// Two samples, and the time between them, s.
struct Neighbours {
    before: usize,
    after: usize,
    time: f64,
}

/// Quantities of the reference by their order.
pub(super) const ORDERS: [Limited; 4] = [
    Limited::Position,
    Limited::Velocity,
    Limited::Acceleration,
    Limited::Jerk,
];

/// Samples of the reference for each wave of its highest frequency.
const SAMPLES_PER_WAVE: usize = 24;

/// Number of variables by which one evaluation differentiates.
const DIRECTIONS: usize = 4;

/// The value of a problem at a point.
#[derive(Clone, Debug)]
pub(super) struct Value {
    /// The objective alone.
    pub(super) objective: f64,
    /// Objective and barriers.
    pub(super) total: f64,
    /// Gradient of the objective and the barriers of the simulated motion.
    pub(super) by_motion: Vec<f64>,
    /// Gradient of the barriers of the reference.
    pub(super) by_reference: Vec<f64>,
    /// Second derivatives of these barriers, block by block, row by row.
    pub(super) bend: Vec<Vec<f64>>,
}

impl Problem {
    #[expect(clippy::too_many_arguments, reason = "the parts of a problem")]
    pub(super) fn new(
        model: &Model,
        (rate, harmonics): (f64, Vec<usize>),
        bases: Vec<Basis>,
        bounds: Bounds,
        scenarios: Vec<Scenario>,
        kinematics: Option<Kinematics>,
        aim: Aim,
        (samples, sample): (usize, f64),
    ) -> Self {
        let period = std::f64::consts::TAU / rate;
        // The reference is periodic, so one period suffices, and the samples are finer than those of the motion.
        let most = harmonics.last().copied().unwrap_or(1);
        let count = samples.max(SAMPLES_PER_WAVE * most);
        let times: Vec<f64> = (0..count)
            .map(|t| period * t as f64 / count as f64)
            .collect();
        let functions = waves(rate, &harmonics, 4, &times);
        let reference = (bases.iter())
            .map(|basis| {
                let map = Mat::from_fn(functions[0].ncols(), basis.count(), |i, k| {
                    let mut unit = vec![0.0; basis.count()];
                    unit[k] = 1.0;
                    basis.coefficients(&unit)[i]
                });
                [0, 1, 2, 3].map(|order: usize| &functions[order] * &map)
            })
            .collect();
        Self {
            model: model.clone(),
            rate,
            harmonics,
            bases,
            bounds,
            scenarios,
            kinematics,
            aim,
            sample,
            reference,
        }
    }

    /// Returns the number of free numbers.
    pub(super) fn count(&self) -> usize {
        self.bases.iter().map(Basis::count).sum()
    }

    /// Returns the series of free numbers.
    pub(super) fn series(&self, x: &[f64]) -> Series {
        Series {
            rate: self.rate,
            harmonics: self.harmonics.clone(),
            joints: self.coefficients(x),
        }
    }

    fn coefficients(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let mut first = 0;
        (self.bases.iter())
            .map(|basis| {
                let coefficients = basis.coefficients(&x[first..first + basis.count()]);
                first += basis.count();
                coefficients
            })
            .collect()
    }

    /// Returns the free numbers of a series.
    pub(super) fn free(&self, series: &Series) -> Vec<f64> {
        let pairs = self.bases.iter().zip(&series.joints);
        pairs
            .flat_map(|(basis, coefficients)| basis.free(coefficients))
            .collect()
    }

    /// Returns the largest place of each limited quantity of each joint; `None` if the loop runs away.
    pub(super) fn peaks(&mut self, x: &[f64]) -> Option<Vec<Peak>> {
        let mut peaks: Vec<Peak> = Vec::new();
        let mut note = |what, joint, place: f64, time| {
            let peak = peaks
                .iter_mut()
                .find(|peak| peak.what == what && peak.joint == joint);
            match peak {
                Some(peak) if peak.place.abs() < place.abs() => {
                    (peak.place, peak.time) = (place, time);
                }
                Some(_) => {}
                None => peaks.push(Peak {
                    what,
                    joint,
                    place,
                    time,
                }),
            }
        };
        let period = std::f64::consts::TAU / self.rate;
        let mut first = 0;
        for (joint, rows) in self.reference.iter().enumerate() {
            let count = self.bases[joint].count();
            let coefficients = &x[first..first + count];
            first += count;
            for (order, (rows, what)) in rows.iter().zip(ORDERS).enumerate() {
                let interval = self.bounds.joints[joint].orders[order];
                if interval.is_limited() {
                    for t in 0..rows.nrows() {
                        let value: f64 = (0..count).map(|k| rows[(t, k)] * coefficients[k]).sum();
                        let time = period * t as f64 / rows.nrows() as f64;
                        note(what, joint, interval.place(value), time);
                    }
                }
            }
        }
        let coefficients = self.coefficients(x);
        let mut scenarios = std::mem::take(&mut self.scenarios);
        let mut all_run = true;
        for scenario in &mut scenarios {
            match scenario.follows.run(&coefficients) {
                Some(moved) => self.visit(scenario, &moved, |seen| {
                    note(
                        seen.what,
                        seen.joint,
                        seen.place,
                        seen.t as f64 * self.sample,
                    );
                }),
                None => all_run = false,
            }
        }
        self.scenarios = scenarios;
        all_run.then_some(peaks)
    }

    /// Visits all limited quantities of a motion.
    fn visit(&self, scenario: &Scenario, moved: &Moved, mut visit: impl FnMut(Seen)) {
        let samples = moved.at.len();
        for (joint, bounds) in self.bounds.joints.iter().enumerate() {
            let row = self.model.torque_row(joint);
            for t in 0..samples {
                let at = &moved.at[t];
                let mut see = |what, on, value: f64| {
                    let interval = bounds.of(what);
                    if interval.is_limited() {
                        visit(Seen {
                            what,
                            joint,
                            on,
                            t,
                            interval,
                            place: interval.place(value),
                        });
                    }
                };
                see(Limited::Torque, RobotPart::Motor, moved.torque[(t, row)]);
                see(
                    Limited::TorqueRate,
                    RobotPart::Motor,
                    self.torque_rate(scenario, moved, t, row),
                );
                if self.has_motion(scenario, joint) {
                    see(Limited::Position, RobotPart::Motor, at.motor[0][joint]);
                    see(Limited::Velocity, RobotPart::Motor, at.motor[1][joint]);
                }
                if self.model.is_flexible(joint) {
                    see(Limited::Position, RobotPart::Link, at.link[0][joint]);
                    see(Limited::Velocity, RobotPart::Link, at.link[1][joint]);
                    see(
                        Limited::Deflection,
                        RobotPart::Motor,
                        at.motor[0][joint] - at.link[0][joint],
                    );
                }
            }
        }
        if let Some(kinematics) = &self.kinematics {
            self.visit_places(kinematics, moved, visit);
        }
    }

    fn visit_places(&self, kinematics: &Kinematics, moved: &Moved, mut visit: impl FnMut(Seen)) {
        let n = self.bases.len();
        let moving = kinematics.moving();
        for (t, at) in moved.at.iter().enumerate() {
            let places = kinematics.places(&at.link[0], &at.link[1]);
            let interval = self.bounds.tool_speed;
            if interval.is_limited() {
                let speed = places.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
                let (what, place) = (Limited::ToolSpeed, interval.place(speed));
                visit(Seen {
                    what,
                    joint: n - 1,
                    on: RobotPart::Point(n),
                    t,
                    interval,
                    place,
                });
            }
            if let Some(floor) = self.bounds.floor {
                for &(point, joint) in &moving {
                    let interval = above(floor);
                    let height = kinematics.height(&places.points[point]);
                    let place = -height_used(height, floor);
                    visit(Seen {
                        what: Limited::Height,
                        joint,
                        on: RobotPart::Point(point),
                        t,
                        interval,
                        place,
                    });
                }
            }
        }
    }

    /// Returns whether the motion of a motor differs from the reference.
    fn has_motion(&self, scenario: &Scenario, joint: usize) -> bool {
        self.model.is_flexible(joint) || matches!(scenario.follows, Follows::Loop(_))
    }

    /// Returns the samples about one whose difference is the rate of a torque.
    fn neighbours(&self, scenario: &Scenario, samples: usize, t: usize) -> Neighbours {
        if matches!(scenario.follows, Follows::Exactly(_)) {
            let (before, after) = ((t + samples - 1) % samples, (t + 1) % samples);
            Neighbours {
                before,
                after,
                time: 2.0 * self.sample,
            }
        } else {
            let (before, after) = (t.saturating_sub(1), (t + 1).min(samples - 1));
            Neighbours {
                before,
                after,
                time: (after - before) as f64 * self.sample,
            }
        }
    }

    fn torque_rate(&self, scenario: &Scenario, moved: &Moved, t: usize, row: usize) -> f64 {
        let Neighbours {
            before,
            after,
            time,
        } = self.neighbours(scenario, moved.at.len(), t);
        (moved.torque[(after, row)] - moved.torque[(before, row)]) / time
    }

    /// Returns objective and barriers with their derivatives; `None` outside of the limits.
    ///
    /// - `barrier`: weight of the barriers.
    pub(super) fn value(&mut self, x: &[f64], barrier: f64) -> Option<Value> {
        let mut value = self.of_reference(x, barrier)?;
        let coefficients = self.coefficients(x);
        let mut scenarios = std::mem::take(&mut self.scenarios);
        let share = 1.0 / scenarios.len() as f64;
        let mut all_inside = true;
        for scenario in &mut scenarios {
            let inside = self.of_scenario(scenario, &coefficients, barrier, share, &mut value);
            if inside.is_none() {
                all_inside = false;
                break;
            }
        }
        self.scenarios = scenarios;
        (all_inside && value.total.is_finite() && value.by_motion.iter().all(|g| g.is_finite()))
            .then_some(value)
    }

    fn of_scenario(
        &self,
        scenario: &mut Scenario,
        coefficients: &[Vec<f64>],
        barrier: f64,
        share: f64,
        value: &mut Value,
    ) -> Option<()> {
        let moved = scenario.follows.run(coefficients)?;
        let (samples, n) = (moved.at.len(), self.bases.len());
        let columns = scenario.weighting.columns(&moved.entries);
        let judged = self.aim.judge(&columns.matrix)?;
        value.objective += share * judged.value;
        value.total += share * judged.value;
        let weight = barrier * share / samples as f64;
        let mut outside = false;
        let mut slopes = Vec::new();
        self.visit(scenario, &moved, |seen| {
            let left = 1.0 - seen.place * seen.place;
            if left <= 0.0 || left.is_nan() {
                outside = true;
                return;
            }
            value.total -= weight * left.ln();
            if seen.place != 0.0 {
                slopes.push((seen, weight * 2.0 * seen.place / left / seen.interval.half));
            }
        });
        if outside {
            return None;
        }
        let by_entries = scenario.weighting.pull(&columns, &judged.by_matrix) * faer::Scale(share);
        let mut by = ByMotion {
            at: vec![MotionAt::zero(n); samples],
            entries: by_entries,
        };
        for (seen, slope) in slopes {
            self.add_slope(scenario, &moved, &seen, slope, &mut by);
        }
        let pulled = scenario.follows.pull(&moved, by);
        let mut first = 0;
        for (basis, gradient) in self.bases.iter().zip(&pulled) {
            for (sum, by) in value.by_motion[first..]
                .iter_mut()
                .zip(basis.pull(gradient))
            {
                *sum += by;
            }
            first += basis.count();
        }
        Some(())
    }

    /// Adds the slope of one barrier to the derivatives by the motion.
    fn add_slope(
        &self,
        scenario: &Scenario,
        moved: &Moved,
        seen: &Seen,
        slope: f64,
        by: &mut ByMotion,
    ) {
        let Seen { joint, t, .. } = *seen;
        let row = self.model.torque_row(joint);
        let mut on_torque = |t: usize, slope: f64| {
            let columns = self.model.equation_columns(row).iter();
            for (entry, &column) in self.model.equation_entries(row).zip(columns) {
                by.entries[(t, entry)] += slope * scenario.theta[column];
            }
        };
        match seen.what {
            Limited::Torque => on_torque(t, slope),
            Limited::TorqueRate => {
                let Neighbours {
                    before,
                    after,
                    time,
                } = self.neighbours(scenario, moved.at.len(), t);
                on_torque(after, slope / time);
                on_torque(before, -slope / time);
            }
            Limited::Deflection => {
                by.at[t].motor[0][joint] += slope;
                by.at[t].link[0][joint] -= slope;
            }
            Limited::Position | Limited::Velocity => {
                let order = usize::from(seen.what == Limited::Velocity);
                let motion = &mut by.at[t];
                let side = if seen.on == RobotPart::Link {
                    &mut motion.link
                } else {
                    &mut motion.motor
                };
                side[order][joint] += slope;
            }
            Limited::ToolSpeed | Limited::Height => self.add_place(moved, seen, slope, by),
            Limited::Acceleration | Limited::Jerk => {}
        }
    }

    /// Adds the slope of a barrier of the tool's speed or of a height.
    fn add_place(&self, moved: &Moved, seen: &Seen, slope: f64, by: &mut ByMotion) {
        let (Some(kinematics), RobotPart::Point(point)) = (&self.kinematics, seen.on) else {
            return;
        };
        let at = &moved.at[seen.t];
        let n = at.link[0].len();
        for first in (0..2 * n).step_by(DIRECTIONS) {
            let number = |order: usize, joint: usize| {
                let (value, variable) = (at.link[order][joint], order * n + joint);
                match variable.checked_sub(first) {
                    Some(i) if i < DIRECTIONS => Dual::<DIRECTIONS>::variable(value, i),
                    _ => Dual::constant(value),
                }
            };
            let [q, dq] = [0, 1].map(|order| (0..n).map(|j| number(order, j)).collect::<Vec<_>>());
            let places = kinematics.places(&q, &dq);
            let partials = if seen.what == Limited::Height {
                kinematics.height(&places.points[point]).partials
            } else {
                let [x, y, z] = places.velocity;
                let square = x * x + y * y + z * z;
                let speed = square.value.sqrt().max(f64::MIN_POSITIVE);
                square.partials.map(|p| 0.5 * p / speed)
            };
            for (i, partial) in partials.into_iter().enumerate() {
                let variable = first + i;
                if variable < 2 * n {
                    by.at[seen.t].link[variable / n][variable % n] += slope * partial;
                }
            }
        }
    }

    /// Returns the barriers of the reference with their derivatives; `None` outside of the limits.
    fn of_reference(&self, x: &[f64], barrier: f64) -> Option<Value> {
        let mut value = Value {
            objective: 0.0,
            total: 0.0,
            by_motion: vec![0.0; x.len()],
            by_reference: Vec::with_capacity(x.len()),
            bend: Vec::new(),
        };
        let mut first = 0;
        for (joint, rows) in self.reference.iter().enumerate() {
            let count = self.bases[joint].count();
            let coefficients = faer::ColRef::from_slice(&x[first..first + count]);
            first += count;
            let mut gradient = faer::Col::<f64>::zeros(count);
            let mut bend = Mat::<f64>::zeros(count, count);
            for (order, rows) in rows.iter().enumerate() {
                let interval = self.bounds.joints[joint].orders[order];
                if !interval.is_limited() {
                    continue;
                }
                let samples = rows.nrows();
                let weight = barrier / samples as f64;
                let signal = rows * coefficients;
                let mut slopes = faer::Col::zeros(samples);
                let mut roots = rows.clone();
                for t in 0..samples {
                    let place = interval.place(signal[t]);
                    let left = 1.0 - place * place;
                    if left <= 0.0 || left.is_nan() {
                        return None;
                    }
                    value.total -= weight * left.ln();
                    slopes[t] = weight * 2.0 * place / left / interval.half;
                    let second = weight * 2.0 * (1.0 + place * place) / (left * left);
                    let root = second.sqrt() / interval.half;
                    for k in 0..count {
                        roots[(t, k)] *= root;
                    }
                }
                gradient += rows.transpose() * slopes;
                bend += roots.transpose() * &roots;
            }
            value.by_reference.extend((0..count).map(|k| gradient[k]));
            let rows = (0..count).flat_map(|i| (0..count).map(move |k| (i, k)));
            value.bend.push(rows.map(|at| bend[at]).collect());
        }
        Some(value)
    }
}

/// Returns the heights above a floor. Only their lower end limits.
fn above(floor: f64) -> Interval {
    Interval {
        middle: floor + FREE_HEIGHT,
        half: FREE_HEIGHT,
    }
}
