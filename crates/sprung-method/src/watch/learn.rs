//! Learns from healthy logs how far the residuals of a robot scatter.

use super::blind::Runs;
use super::monitor::{Instant, Tail, Variance, peaks};
use super::residual::{Now, Residuals};
use super::walk::{Next, Walk};
use crate::estimate::CovarianceOfErrors;
use crate::log::{LogBlock, LogSource, Measures};
use crate::model::{Model, Scratch, Theta};
use crate::prepare::{Excerpt, noise};
use crate::progress::{Listener, Phase};
use crate::regression::{PassError, Reading};
use sprung_core::filter::FilterState;
use sprung_core::observer::{Chain3, ObserverFilters};
use sprung_core::parameters::JointParameter;

/// Instants per time constant of the residual.
const INSTANTS: f64 = 2.0;

/// Longest healthy motion from which the scatter is learned, s.
const LONGEST_S: f64 = 600.0;

/// Instants per one at which the error of the parameters is computed.
const PER_COVARIANCE: usize = 20;

/// Level of peaks, in standard deviations.
const LEVEL: f64 = 1.0;

/// A robot with its values, and the settings for reading its logs.
#[derive(Clone, Copy)]
pub(super) struct Robot<'a> {
    pub(super) reading: &'a Reading,
    pub(super) model: &'a Model,
    pub(super) theta: &'a Theta,
    pub(super) covariance: Option<&'a CovarianceOfErrors>,
    /// Deviation of the torque of each spring by another zero of an incremental encoder, N·m (N).
    pub(super) zeros: &'a [f64],
    pub(super) bandwidth: Bandwidth,
}

/// Cut-offs of the filters of an observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bandwidth {
    /// ω of the signals, rad/s.
    pub(super) cutoff: f64,
    /// λ of the residual, rad/s.
    pub(super) last: f64,
}

impl Bandwidth {
    /// Returns the filters for a period T, s.
    fn filters(&self, period: f64) -> Result<ObserverFilters, PassError> {
        ObserverFilters::new(self.cutoff, self.last, period).map_err(PassError::FilterPair)
    }

    /// Returns the part of a sudden torque that the residual shows after a time, s.
    fn reached(&self, after: f64, period: f64) -> Result<f64, PassError> {
        let filters = self.filters(period)?;
        let mut chain = Chain3::settled_held(&filters, 0.0);
        let mut last = FilterState::default();
        let samples = (after / period).round().clamp(1.0, 1e6) as usize;
        let mut shown = 0.0;
        for torque in std::iter::once(0.0).chain(std::iter::repeat_n(1.0, samples)) {
            let torque = filters.held(&mut chain, torque);
            shown = filters.last(&mut last, torque);
        }
        Ok(shown)
    }

    /// Returns the sum of the logarithms of the smallest sudden torques that are seen in time.
    fn smallest(&self, joints: &[JointMonitor], period: f64) -> Result<f64, PassError> {
        let reached = self.reached(PROMPT_S.max(self.last.recip()), period)?;
        let of_joint = |joint: &JointMonitor| {
            let torque = joint.threshold(CHOICE_RATE, self.last) * joint.typical / reached;
            torque.max(1e-12).ln()
        };
        Ok(joints.iter().map(of_joint).sum())
    }
}

/// How the residual of a joint is formed and how far it scatters.
#[derive(Clone, Debug)]
pub(super) struct JointMonitor {
    /// Share of the residual of the motor's equation in the torque from outside.
    pub(super) of_motor: f64,
    pub(super) variance: Variance,
    /// Variances of the residuals of both equations, of the link, or of the only one, and of the motor; and the mean squared
    /// residuals of the healthy robot over them, which lack the errors of the parameters.
    of_rows: [Option<(Variance, f64)>; 2],
    /// Deviation by another zero of an encoder while it is not known, N·m (N).
    pub(super) zero: f64,
    /// `None` if the healthy motion is too short.
    pub(super) tail: Option<Tail>,
    /// Root mean square of the standard deviation in the healthy motion, N·m (N).
    pub(super) typical: f64,
}

/// What was learned of all joints.
#[derive(Clone, Debug)]
pub(super) struct Monitor {
    pub(super) joints: Vec<JointMonitor>,
    /// Duration of the healthy motion, s.
    pub(super) duration: f64,
    /// Samples per instant, and the sampling period T, s.
    pub(super) stride: usize,
    pub(super) period: f64,
    /// Longest time for which each channel keeps one value, s.
    pub(super) runs: Vec<f64>,
}

/// Residuals of both equations of a joint at one time, as an instant of that of the link.
#[derive(Clone, Copy, Debug)]
struct Both {
    motor: f64,
    /// Constant residual of the motor by another zero of an encoder, N·m (N).
    zero: f64,
    instant: Instant,
    /// Variances of both by the errors of the parameters and their covariance, (N·m)² (N²): link, both, motor.
    of_parameters: [f64; 3],
}

/// Returns the instants of a log: every so many samples.
fn stride(bandwidth: f64, period: f64) -> usize {
    ((1.0 / (INSTANTS * bandwidth * period)) as usize).max(1)
}

/// Residuals of a log at instants, with what they need.
pub(super) struct Instants<'a> {
    residuals: Residuals<'a>,
    stride: usize,
    since: usize,
    begins: bool,
}

impl<'a> Instants<'a> {
    /// - `period`: T, s.
    pub(super) fn new(robot: &Robot<'a>, period: f64) -> Result<Self, PassError> {
        let bandwidth = robot.bandwidth.last;
        Ok(Self {
            residuals: Residuals::new((robot.model, robot.theta), robot.bandwidth.filters(period)?),
            stride: stride(bandwidth, period),
            since: 0,
            begins: true,
        })
    }

    /// Takes what comes next; calls back at each instant with its time, and whether the filters have begun just before.
    pub(super) fn take(&mut self, next: &Next<'_>, each: &mut dyn FnMut(f64, &Now, bool)) {
        match next {
            Next::Restart => {
                self.residuals.restart();
                (self.since, self.begins) = (0, true);
            }
            Next::Samples(raw) => {
                for k in 0..raw.len() {
                    self.residuals.take(raw, k);
                    self.since += 1;
                    if self.residuals.is_settled() && self.since.is_multiple_of(self.stride) {
                        each(
                            raw.time[k],
                            &self.residuals.now,
                            std::mem::take(&mut self.begins),
                        );
                    }
                }
            }
        }
    }
}

/// Returns the deviation of the torque of each spring by another zero of an incremental encoder, N·m (N): an encoder begins with a
/// whole count, so the zeros of two logs differ by the difference of two numbers between -1/2 and 1/2 count. The equations of a joint
/// with a torque sensor do not contain the spring.
pub(super) fn zero_deviations(reading: &Reading, theta: &Theta, excerpt: &Excerpt) -> Vec<f64> {
    let model = reading.model();
    let of_joint = |joint: usize| {
        let stiffness = model
            .index(JointParameter::Stiffness, joint)
            .filter(|_| !model.has_torque_sensor(joint));
        let encoders = reading
            .channels()
            .all
            .iter()
            .enumerate()
            .filter(|(_, channel)| {
                channel.joint == joint
                    && matches!(channel.quantity.measures(), Measures::Position { .. })
            });
        let steps = encoders.filter_map(|(at, _)| noise(excerpt, at)?.1);
        let variance: f64 = steps.map(|step| step * step / 6.0).sum();
        stiffness.map_or(0.0, |at| theta[at].abs()) * variance.sqrt()
    };
    (0..model.joint_count()).map(of_joint).collect()
}

/// What one observer shows along healthy logs.
struct Learner<'a> {
    robot: Robot<'a>,
    /// Joint by joint.
    all: Vec<Vec<Both>>,
    errors: Errors<'a>,
    count: usize,
}

impl<'a> Learner<'a> {
    fn new(robot: Robot<'a>) -> Self {
        Self {
            all: vec![Vec::new(); robot.model.joint_count()],
            errors: Errors::new(&robot),
            count: 0,
            robot,
        }
    }

    fn see(&mut self, now: &Now, begins: bool) {
        if self.count.is_multiple_of(PER_COVARIANCE) {
            self.errors.see(now);
        }
        self.count += 1;
        for (joint, all) in self.all.iter_mut().enumerate() {
            let row = self.robot.model.regressor().motor_coordinate(joint);
            all.push(Both {
                motor: if row == joint { 0.0 } else { now.residual[row] },
                zero: now.zeros[joint].unwrap_or_default(),
                instant: Instant {
                    value: now.residual[joint],
                    features: now.features[joint],
                    of_parameters: 0.0,
                    begins,
                },
                of_parameters: self.errors.now[joint],
            });
        }
    }

    /// Returns what was learned of all joints.
    ///
    /// - `duration`: of the logs, s.
    fn joints(&self, duration: f64) -> Vec<JointMonitor> {
        let of_joints = self.all.iter().zip(self.robot.zeros);
        let (mut joints, peaks): (Vec<JointMonitor>, Vec<Vec<f64>>) = of_joints
            .map(|(all, zero)| JointMonitor::of(all, *zero))
            .unzip();
        for (joint, tail) in joints.iter_mut().zip(Tail::all(&peaks, duration)) {
            joint.tail = tail;
        }
        joints
    }
}

/// Learns from healthy logs with several cut-offs of the signals, and returns the robot with those that show the smallest sudden
/// torques.
///
/// # Errors
///
/// [`PassError`] if a log cannot be read.
pub(super) fn learn<'a>(
    robot: Robot<'a>,
    sources: &mut [LogSource<'_>],
    progress: &mut dyn Listener,
) -> Result<(Robot<'a>, Monitor), PassError> {
    let (reading, model) = (robot.reading, robot.model);
    let mut learners = CUTOFFS.map(|share| {
        let cutoff = share * robot.bandwidth.last;
        let bandwidth = Bandwidth {
            cutoff,
            ..robot.bandwidth
        };
        Learner::new(Robot { bandwidth, ..robot })
    });
    let mut runs = Runs::new(reading.channels());
    let mut monitor = Monitor {
        joints: Vec::new(),
        duration: 0.0,
        stride: 1,
        period: f64::NAN,
        runs: Vec::new(),
    };
    let known = |source: &&mut LogSource<'_>| !source.has_unknown_payload();
    for source in sources.iter_mut().filter(known) {
        let mut log = source.open(reading.channels())?;
        let mut block = LogBlock::new(reading.channels().all.len());
        let mut more = log.read(&mut block)?;
        let period = log.timing().period;
        if monitor.period.is_nan() {
            monitor.period = period;
            monitor.stride = stride(robot.bandwidth.last, period);
        }
        let carried = source
            .payload()
            .and_then(|payload| model.change_by_payload(payload));
        let carried = carried.unwrap_or_else(|| vec![0.0; robot.theta.len()]);
        let theta = robot
            .theta
            .iter()
            .zip(carried)
            .map(|(value, by)| value + by)
            .collect();
        let mut instants = Vec::new();
        for learner in &learners {
            let robot = Robot {
                theta: &theta,
                ..learner.robot
            };
            instants.push(Instants::new(&robot, period)?);
        }
        let mut walk = Walk::new(reading, period);
        let first = block.time.first().copied().unwrap_or_default();
        let before = monitor.duration;
        while more && monitor.duration < LONGEST_S {
            runs.take(&block, &mut |_, _| ());
            walk.push(&block, &mut |next| {
                for (learner, instants) in learners.iter_mut().zip(&mut instants) {
                    instants.take(&next, &mut |_, now, begins| learner.see(now, begins));
                }
            });
            progress.tell(Phase::Reading, log.timing().recorded, log.expected())?;
            monitor.duration = before + block.time.last().map_or(0.0, |last| last - first);
            monitor.runs = runs.longest(&block);
            more = log.read(&mut block)?;
        }
    }
    let mut best: Option<(f64, Robot<'a>, Vec<JointMonitor>)> = None;
    for learner in learners {
        let joints = learner.joints(monitor.duration);
        let smallest = learner.robot.bandwidth.smallest(&joints, monitor.period)?;
        if best.as_ref().is_none_or(|(least, ..)| smallest < *least) {
            best = Some((smallest, learner.robot, joints));
        }
    }
    let (_, robot, joints) = best.unwrap_or((0.0, robot, Vec::new()));
    Ok((robot, Monitor { joints, ..monitor }))
}

/// Time within which a contact is to be seen, s.
const PROMPT_S: f64 = 0.05;

/// Cut-offs of the signals that are tried, over that of the residual.
const CUTOFFS: [f64; 3] = [2.0, 4.0, 8.0];

/// Rate of false alarms for the choice of a cut-off, 1/s.
const CHOICE_RATE: f64 = 1.0 / 3600.0;

impl JointMonitor {
    /// Returns the threshold in standard deviations that healthy motion exceeds at a rate, 1/s; infinite if it is not known.
    ///
    /// - `bandwidth`: of the residual, rad/s.
    pub(super) fn threshold(&self, rate: f64, bandwidth: f64) -> f64 {
        let tail = self.tail.as_ref();
        tail.map_or(f64::INFINITY, |tail| tail.threshold(rate, bandwidth))
    }

    /// Returns what was learned but for the tail, and the peaks.
    ///
    /// - `zero`: deviation of the spring's torque by another zero of an encoder, N·m (N).
    fn of(all: &[Both], zero: f64) -> (Self, Vec<f64>) {
        let product = |of: fn(&Both) -> f64| all.iter().map(of).sum::<f64>();
        let squares = product(|x| x.motor * x.motor);
        let of_motor = if squares > 0.0 {
            (-product(|x| x.motor * x.instant.value) / squares).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let instants: Vec<Instant> = (all.iter())
            .map(|x| Instant {
                value: -(x.instant.value + of_motor * x.motor + (1.0 - of_motor) * x.zero),
                of_parameters: x.of_parameters[0]
                    + of_motor * (2.0 * x.of_parameters[1] + of_motor * x.of_parameters[2]),
                ..x.instant
            })
            .collect();
        let variance = Variance::fit(&instants);
        // Peaks with the variance of the other half: the logs to come are not those of the fit.
        let (first, second) = instants.split_at(instants.len() / 2);
        let halves = [(first, second), (second, first)];
        let peaks = halves
            .map(|(of, other)| peaks(of, &Variance::fit(other), LEVEL))
            .concat();
        let whole: f64 = instants.iter().map(|x| variance.at(&x.features)).sum();
        let of_row = |of: fn(&Both) -> (f64, f64)| {
            let all = all.iter().map(|x| {
                let (value, of_parameters) = of(x);
                Instant {
                    value,
                    of_parameters,
                    ..x.instant
                }
            });
            let all: Vec<Instant> = all.collect();
            let variance = Variance::fit(&all);
            let squares = all
                .iter()
                .map(|x| x.value.powi(2) / variance.at(&x.features));
            (variance, squares.sum::<f64>() / all.len().max(1) as f64)
        };
        let monitor = Self {
            of_motor,
            of_rows: [
                Some(of_row(|x| (x.instant.value, x.of_parameters[0]))),
                (squares > 0.0).then(|| of_row(|x| (x.motor, x.of_parameters[2]))),
            ],
            variance,
            zero: (1.0 - of_motor) * zero,
            tail: None,
            typical: (whole / instants.len().max(1) as f64).sqrt(),
        };
        (monitor, peaks)
    }

    /// Returns the residual of each equation of the joint, N·m (N), and its variance in healthy motion; `None` without an equation of
    /// the motor.
    pub(super) fn rows(&self, model: &Model, joint: usize, now: &Now) -> [Option<(f64, f64)>; 2] {
        let rows = [joint, model.regressor().motor_coordinate(joint)];
        std::array::from_fn(|at| {
            let (variance, usual) = self.of_rows[at]?;
            Some((
                now.residual[rows[at]],
                variance.at(&now.features[joint]) * usual,
            ))
        })
    }

    /// Returns the torque from outside and its standard deviation, N·m (N).
    pub(super) fn outside(&self, model: &Model, joint: usize, now: &Now) -> [f64; 2] {
        let value = of_joint(model, joint, now, self.of_motor);
        let deviation = deviation(now, joint, (&self.variance, self.zero));
        [value, deviation]
    }
}

/// Returns the torque from outside on a joint, N·m (N).
///
/// - `of_motor`: share of the residual of the motor's equation. That of the constant by another zero is one.
pub(super) fn of_joint(model: &Model, joint: usize, now: &Now, of_motor: f64) -> f64 {
    let row = model.regressor().motor_coordinate(joint);
    let motor = if row == joint { 0.0 } else { now.residual[row] };
    let zero = now.zeros[joint].unwrap_or_default();
    -(now.residual[joint] + of_motor * motor + (1.0 - of_motor) * zero)
}

/// Returns the standard deviation of the torque from outside on a joint, N·m (N).
///
/// - `zero`: deviation by another zero of an encoder while it is not known, N·m (N).
pub(super) fn deviation(now: &Now, joint: usize, (variance, zero): (&Variance, f64)) -> f64 {
    let unknown = now.zeros[joint].map_or(zero, |_| 0.0);
    (variance.at(&now.features[joint]) + unknown * unknown).sqrt()
}

/// Errors of residuals by those of the parameters.
struct Errors<'a> {
    model: &'a Model,
    scratch: Scratch,
    entries: Vec<f64>,
    /// Place in theta of each parameter with a covariance, and the covariance, row by row.
    places: Vec<usize>,
    covariance: Vec<f64>,
    /// Of each joint: variance of the residual of the link, covariance of both, variance of that of the motor.
    now: Vec<[f64; 3]>,
}

impl<'a> Errors<'a> {
    fn new(robot: &Robot<'a>) -> Self {
        let model = robot.model;
        let named: Vec<(usize, usize)> = (robot.covariance.iter())
            .flat_map(|of| of.parameters.iter().enumerate())
            .filter_map(|(at, name)| Some((at, model.index_of(name).ok()?)))
            .collect();
        let entry = |i: usize, j: usize| {
            robot
                .covariance
                .map_or(0.0, |of| of.values[i.max(j)][i.min(j)])
        };
        Self {
            model,
            scratch: Scratch::new(model.joint_count()),
            entries: vec![0.0; model.entries()],
            covariance: (named.iter())
                .flat_map(|(i, _)| named.iter().map(move |(j, _)| entry(*i, *j)))
                .collect(),
            places: named.iter().map(|(_, place)| *place).collect(),
            now: vec![[0.0; 3]; model.joint_count()],
        }
    }

    /// Computes the errors at a state, as if it lasted.
    fn see(&mut self, now: &Now) {
        let robot = self.model.regressor();
        let mut workspace = self.scratch.workspace();
        let computed = robot.torque_entries(
            &now.state(),
            &now.acceleration,
            &mut workspace,
            &mut self.entries,
        );
        if computed.is_err() || self.places.is_empty() {
            return;
        }
        for joint in 0..self.model.joint_count() {
            let rows = [joint, robot.motor_coordinate(joint)];
            let [link, motor] = rows.map(|row| {
                let columns = self.model.row_columns(row);
                let entries = &self.entries[self.model.row_entries(row)];
                let mut of_all = vec![0.0; self.model.parameters().len()];
                for (column, entry) in columns.iter().zip(entries) {
                    of_all[*column] += entry;
                }
                self.places
                    .iter()
                    .map(|place| of_all[*place])
                    .collect::<Vec<f64>>()
            });
            let product = |a: &[f64], b: &[f64]| -> f64 {
                let rows = self.covariance.chunks(a.len()).zip(a);
                rows.map(|(row, a)| a * row.iter().zip(b).map(|(c, b)| c * b).sum::<f64>())
                    .sum()
            };
            let of_motor = if rows[0] == rows[1] {
                [0.0; 2]
            } else {
                [product(&link, &motor), product(&motor, &motor)]
            };
            self.now[joint] = [product(&link, &link).max(0.0), of_motor[0], of_motor[1]];
        }
    }
}
