//! Windows of a log: the distance of the simulated from the logged positions, with derivatives.
//!
//! Each window starts at its own position and velocity. Disturbances that the model lacks then act
//! only within a window, and the simulation of a short window depends smoothly on the parameters.

use sprung_core::scalar::{Dual, Scalar};
use sprung_core::servo::{Servo, ServoParameter, ServoParameters, ServoState};

use super::bench::Bench;
use super::record::Record;

/// Number of parameters.
pub(super) const P: usize = ServoParameter::COUNT;

/// Parameters and the start of a window.
const N: usize = P + 2;

/// A part of a record, with the correction of its start.
#[derive(Clone, Debug)]
pub(super) struct Window {
    record: usize,
    from: usize,
    to: usize,
    /// Correction of the smoothed position and velocity at its start, rad and rad/s.
    pub(super) start: [f64; 2],
}

/// How windows are simulated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setting<'a> {
    pub(super) bench: &'a Bench,
    pub(super) records: &'a [Record],
    /// Longest step of the integration, s.
    pub(super) step_s: f64,
    /// Whether the starts of the windows are estimated.
    pub(super) free_start: bool,
}

/// Sum of squares of a window, and its derivatives.
#[derive(Clone, Debug)]
pub(super) struct Normal {
    /// Sum of squared residuals relative to the noise, with the prior of the start.
    pub(super) cost: f64,
    /// Its descent direction, half the negative gradient; the start is eliminated, \[P\].
    pub(super) descent: [f64; P],
    /// Information of the parameters; the start is eliminated, \[P × P\].
    pub(super) information: Box<[[f64; P]; P]>,
    // Information of start and parameters, \[2 × P\], and of the start: xx, xv, vv.
    cross: [[f64; P]; 2],
    start_information: [f64; 3],
    start_descent: [f64; 2],
}

/// Divides records into windows.
///
/// - `length`: length of a window, s.
pub(super) fn windows(records: &[Record], length: f64) -> Vec<Window> {
    let mut all = Vec::new();
    for (index, record) in records.iter().enumerate() {
        let n = record.position.len();
        let parts = ((record.duration() / length).round() as usize).clamp(1, n);
        all.extend((0..parts).map(|k| Window {
            record: index,
            from: k * n / parts,
            to: (k + 1) * n / parts,
            start: [0.0; 2],
        }));
    }
    all
}

/// Steps of the integration of a record.
struct Steps {
    /// Steps per sample.
    count: usize,
    /// Steps per period of the position loop; `None` for a continuous loop.
    hold: Option<usize>,
}

impl Steps {
    fn new(record: &Record, setting: &Setting<'_>) -> Self {
        let period = record.period;
        match setting.bench.loop_period {
            None => Self {
                count: (period / setting.step_s).ceil().max(1.0) as usize,
                hold: None,
            },
            Some(of_loop) => {
                let loops = (period / of_loop).round().max(1.0);
                let per_loop = (period / loops / setting.step_s).ceil().max(1.0);
                let count = (loops * per_loop) as usize;
                let step = period / count as f64;
                Self {
                    count,
                    hold: Some((of_loop / step).round().max(1.0) as usize),
                }
            }
        }
    }
}

impl Window {
    /// Returns the number of samples.
    pub(super) fn len(&self) -> usize {
        self.to - self.from
    }

    /// Returns the index of its record.
    pub(super) fn record(&self) -> usize {
        self.record
    }

    /// Simulates the window.
    ///
    /// - `start`: position, rad, and velocity, rad/s.
    /// - `each`: receives residual and simulated position of each sample, rad.
    fn simulate<S: Scalar>(
        &self,
        parameters: ServoParameters<S>,
        start: [S; 2],
        setting: &Setting<'_>,
        mut each: impl FnMut(f64, S),
    ) {
        let record = &setting.records[self.record];
        let law = setting.bench.law;
        let servo = Servo::new(parameters, record.load);
        let steps = Steps::new(record, setting);
        let step = record.period / steps.count as f64;
        let [position, velocity] = start;
        let mut state = ServoState { position, velocity };
        let mut command = S::ZERO;
        let mut done = 0;
        for k in self.from..self.to {
            each(record.position[k] - state.position.value(), state.position);
            for _ in 0..steps.count {
                match steps.hold {
                    Some(hold) if done % hold == 0 => {
                        command = law.command(record.target[k], state.position, state.velocity);
                    }
                    Some(_) => {}
                    None => {
                        let middle = state.position + state.velocity * (0.5 * step);
                        command = law.command(record.target[k], middle, state.velocity);
                    }
                }
                done += 1;
                state = servo.step(state, record.on[k].then_some(command), 0.0, step);
            }
        }
    }

    /// Returns standard deviations of the prior of its start, rad and rad/s, and of its samples,
    /// rad. The prior only bounds starts that the window does not determine.
    fn deviations(&self, setting: &Setting<'_>) -> ([f64; 2], f64) {
        let record = &setting.records[self.record];
        let noise = record.noise;
        let of_velocity = 0.3 * noise / record.period;
        (
            [
                7.0 * noise,
                0.07 * record.rms_velocity() + 3.0 * of_velocity,
            ],
            noise,
        )
    }

    fn smoothed_start(&self, setting: &Setting<'_>) -> [f64; 2] {
        setting.records[self.record].smooth[self.from]
    }

    /// Returns the sum of squares.
    pub(super) fn cost(&self, values: &[f64; P], setting: &Setting<'_>) -> f64 {
        let (prior, noise) = self.deviations(setting);
        let smooth = self.smoothed_start(setting);
        let start = [0, 1].map(|i| smooth[i] + self.start[i]);
        let mut cost: f64 = (0..2).map(|i| (self.start[i] / prior[i]).powi(2)).sum();
        self.simulate(ServoParameters(*values), start, setting, |residual, _| {
            cost += (residual / noise).powi(2);
        });
        if cost.is_finite() {
            cost
        } else {
            f64::INFINITY
        }
    }

    /// Returns the sum of squares with its derivatives.
    pub(super) fn normal(&self, values: &[f64; P], setting: &Setting<'_>) -> Normal {
        let (prior, noise) = self.deviations(setting);
        let smooth = self.smoothed_start(setting);
        let variables = std::array::from_fn(|i| Dual::<N>::variable(values[i], i));
        let start = [0, 1].map(|i| Dual::<N>::variable(smooth[i] + self.start[i], P + i));
        let mut information = [[0.0; N]; N];
        let mut descent = [0.0; N];
        let mut cost = 0.0;
        for i in 0..2 {
            let weight = 1.0 / (prior[i] * prior[i]);
            information[P + i][P + i] = weight;
            descent[P + i] = -self.start[i] * weight;
            cost += self.start[i] * self.start[i] * weight;
        }
        let weight = 1.0 / (noise * noise);
        let parameters = ServoParameters(variables);
        self.simulate(parameters, start, setting, |residual, position| {
            cost += residual * residual * weight;
            for i in 0..N {
                let weighted = position.partials[i] * weight;
                descent[i] += weighted * residual;
                for (entry, other) in information[i][..=i].iter_mut().zip(position.partials) {
                    *entry += weighted * other;
                }
            }
        });
        Normal::new(cost, descent, &information, setting.free_start)
    }
}

impl Normal {
    /// - `information`: only the lower triangle is read.
    fn new(cost: f64, descent: [f64; N], information: &[[f64; N]; N], free_start: bool) -> Self {
        let mut normal = Self {
            cost,
            descent: std::array::from_fn(|i| descent[i]),
            information: Box::new([[0.0; P]; P]),
            cross: [information[P], information[P + 1]].map(|row| std::array::from_fn(|i| row[i])),
            start_information: [
                information[P][P],
                information[P + 1][P],
                information[P + 1][P + 1],
            ],
            start_descent: [descent[P], descent[P + 1]],
        };
        for i in 0..P {
            for j in 0..P {
                let (row, column) = (i.max(j), i.min(j));
                normal.information[i][j] = information[row][column];
            }
        }
        if free_start {
            for i in 0..P {
                let by_start = normal.by_start([normal.cross[0][i], normal.cross[1][i]], 0.0);
                let of_start = by_start.iter().zip(normal.start_descent).zip(normal.cross);
                for ((by_start, descent), cross) in of_start {
                    normal.descent[i] -= by_start * descent;
                    for (entry, cross) in normal.information[i].iter_mut().zip(cross) {
                        *entry -= by_start * cross;
                    }
                }
            }
        }
        normal
    }

    /// Returns the solution of the equations of the start.
    fn by_start(&self, [x, v]: [f64; 2], damping: f64) -> [f64; 2] {
        let [xx, xv, vv] = self.start_information;
        let (xx, vv) = (xx * (1.0 + damping), vv * (1.0 + damping));
        let determinant = xx * vv - xv * xv;
        [
            (vv * x - xv * v) / determinant,
            (xx * v - xv * x) / determinant,
        ]
    }

    /// Returns the step of the start that belongs to a step of the parameters.
    pub(super) fn start_step(&self, step: &[f64; P], damping: f64) -> [f64; 2] {
        let mut rest = self.start_descent;
        for (rest, cross) in rest.iter_mut().zip(&self.cross) {
            *rest -= cross.iter().zip(step).map(|(a, b)| a * b).sum::<f64>();
        }
        self.by_start(rest, damping)
    }
}
