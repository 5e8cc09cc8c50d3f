//! The filter compared with a dense textbook filter, for a carriage on a spring.

use std::sync::Arc;

use super::run::{Keep, run};
use super::state::Filter;
use crate::description::{self, no_files};
use crate::estimate::estimators::prediction_error::dynamics::Dynamics;
use crate::estimate::estimators::prediction_error::levels::Levels;
use crate::estimate::estimators::prediction_error::measurements::{
    Measurement, Measurements, Noise, Segment, Sensor,
};
use crate::estimate::estimators::prediction_error::reversals::Reversals;
use crate::estimate::estimators::prediction_error::unknowns::Unknowns;
use crate::log::Channels;
use crate::model::Model;

/// A carriage without gravity, so its equations are linear.
const CARRIAGE: &str = r#"
format = 1
[robot]
name = "carriage"
dh_modified = [{ prismatic = true }]
gravity_m_per_s2 = [0.0, -9.81, 0.0]
[[robot.joint]]
name = "carriage"
link_friction = ["viscous"]
motor_friction = ["viscous", "coulomb"]
coulomb_sharpness_s_per_rad = 20.0
[log]
file = "log.csv"
time_s = "t"
motor_position_m = ["motor"]
link_position_m = ["link"]
motor_force_n = ["force"]
[identify]
encoder_offset = "none"
"#;

/// Masses of carriage and rotor, kg; viscous friction of both, N s/m; stiffness, N/m; Coulomb
/// friction of the motor, N; in the order of the model. Without Coulomb friction the equations are
/// linear, and the law alone gives the motor noise at reversals.
const TRUTH: [f64; 6] = [2.0, 0.5, 0.3, 0.7, 900.0, 0.0];
const SHARPNESS: f64 = 20.0;
/// Number of parameters that are not zero.
const FREE: usize = 5;
const PERIOD: f64 = 2e-3;
const SAMPLES: usize = 40;
const STATES: usize = 6;

type Matrix = Vec<Vec<f64>>;

/// K = P Hᵀ / S, the innovation e and its variance S.
struct Correction {
    gain: Matrix,
    e: f64,
    s: f64,
}

fn zeros(rows: usize, columns: usize) -> Matrix {
    vec![vec![0.0; columns]; rows]
}

fn identity(count: usize) -> Matrix {
    let mut matrix = zeros(count, count);
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    matrix
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c = zeros(a.len(), b[0].len());
    for (i, row) in a.iter().enumerate() {
        for (k, a) in row.iter().enumerate() {
            for (j, b) in b[k].iter().enumerate() {
                c[i][j] += a * b;
            }
        }
    }
    c
}

fn transposed(a: &Matrix) -> Matrix {
    (0..a[0].len())
        .map(|j| a.iter().map(|row| row[j]).collect())
        .collect()
}

/// Returns `a + factor · b`.
fn plus(a: &Matrix, factor: f64, b: &Matrix) -> Matrix {
    let sum = |(a, b): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
        a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
    };
    a.iter().zip(b).map(sum).collect()
}

/// The dense textbook filter: x = (q, ϕ, q̇, ϕ̇, d₁, d₂) and P.
struct Textbook {
    theta: Vec<f64>,
    levels: Levels,
    x: Matrix,
    p: Matrix,
}

impl Textbook {
    fn new(theta: &[f64], levels: &Levels, segment: &Segment, offset: f64) -> Self {
        let mut x = zeros(STATES, 1);
        let mut p = zeros(STATES, STATES);
        for i in 0..4 {
            x[i][0] = segment.start[i];
            p[i][i] = segment.start_deviation[i].powi(2);
        }
        x[1][0] -= offset;
        for i in 0..2 {
            p[4 + i][4 + i] = levels.disturbance[i].powi(2);
        }
        Self {
            theta: theta.to_vec(),
            levels: levels.clone(),
            x,
            p,
        }
    }

    /// F by the states and the torque. For a linear system the Runge-Kutta method of order 4 is a
    /// Taylor series of the matrix exponential.
    fn transition(&self, steps: usize) -> Matrix {
        let [m, rotor, b1, b2, k, _] = self.theta[..] else {
            panic!("six parameters")
        };
        let mut a = zeros(STATES, STATES);
        (a[0][2], a[1][3]) = (1.0, 1.0);
        a[2] = vec![-k / m, k / m, -b1 / m, 0.0, 1.0 / m, 0.0];
        a[3] = vec![k / rotor, -k / rotor, 0.0, -b2 / rotor, 0.0, 1.0 / rotor];
        let h = PERIOD / steps as f64;
        let (mut step, mut power) = (identity(STATES), identity(STATES));
        let mut factor = 1.0;
        for order in 1..=4 {
            power = product(&power, &a);
            factor *= h / f64::from(order);
            step = plus(&step, factor, &power);
        }
        (0..steps).fold(identity(STATES), |all, _| product(&step, &all))
    }

    fn gain(&self, measurement: &Measurement, offset: f64) -> Correction {
        let mut h = zeros(1, STATES);
        h[0][measurement.sensor] = 1.0;
        h[0][2 + measurement.sensor] = -measurement.age;
        let cross = product(&self.p, &transposed(&h));
        let r = measurement.variance + self.levels.sensor_noise[measurement.sensor].powi(2);
        let s = product(&h, &cross)[0][0] + r;
        let offset = if measurement.sensor == 1 { offset } else { 0.0 };
        let e = measurement.value - offset - product(&h, &self.x)[0][0];
        Correction {
            gain: plus(&zeros(STATES, 1), 1.0 / s, &cross),
            e,
            s,
        }
    }

    fn measure(&mut self, gain: &Matrix, e: f64, s: f64) {
        self.x = plus(&self.x, e, gain);
        self.p = plus(&self.p, -s, &product(gain, &transposed(gain)));
    }

    fn predict(&mut self, force: f64, steps: usize) {
        let mut f = self.transition(steps);
        let by_torque = f.clone();
        let decay = (-std::f64::consts::TAU * self.levels.corner * PERIOD).exp();
        (f[4][4], f[5][5]) = (decay, decay);
        let before = self.x[3][0];
        self.x = product(&f, &self.x);
        self.p = product(&product(&f, &self.p), &transposed(&f));
        for (x, by_torque) in self.x.iter_mut().zip(&by_torque).take(4) {
            x[0] += by_torque[5] * force;
        }
        let velocity = 0.5 * (before + self.x[3][0]);
        let reversal = (-(velocity * SHARPNESS / 2.0).powi(2)).exp();
        let white = [
            self.levels.torque_noise[0].powi(2),
            self.levels.torque_noise[1].powi(2) + reversal * self.levels.reversal_noise[1].powi(2),
        ];
        for (row, variance) in white.iter().enumerate() {
            for i in 0..4 {
                for j in 0..4 {
                    self.p[i][j] += variance * by_torque[i][4 + row] * by_torque[j][4 + row];
                }
            }
        }
        for i in 0..2 {
            self.p[4 + i][4 + i] += self.levels.disturbance[i].powi(2) * (1.0 - decay * decay);
        }
    }
}

struct Case {
    model: Model,
    channels: Channels,
    measurements: Measurements,
    levels: Levels,
}

impl Case {
    fn new() -> Self {
        let read = description::read("experiment.toml", CARRIAGE, &[], &mut no_files);
        let experiment = read.unwrap();
        let model = Model::new(&experiment).unwrap();
        let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap();
        let sensors = (0..2).map(|row| {
            let column = ["link", "motor"][row];
            let index = channels.all.iter().position(|c| c.column == column);
            Sensor {
                spring: None,
                channel: index.unwrap(),
                coordinates: vec![(row, 1.0)],
                offset: 0.0,
                noise: Noise::White(1e-4),
                scale: 0.1,
            }
        });
        let (mut taken, mut first, mut torque) = (Vec::new(), vec![0], Vec::new());
        for k in 0..SAMPLES {
            for sensor in 0..2 {
                if (k + sensor) % 2 == 0 {
                    taken.push(Measurement {
                        sensor,
                        value: 0.01 * ((3 * k + sensor) as f64).sin(),
                        variance: 1e-6,
                        age: if k % 3 == 0 { 0.4 * PERIOD } else { 0.0 },
                    });
                }
            }
            first.push(taken.len());
            torque.extend([0.0, 5.0 * (0.3 * k as f64).cos()]);
        }
        Self {
            measurements: Measurements {
                sensors: sensors.collect(),
                segments: Arc::new(vec![Segment {
                    burn_in: 0,
                    span: [0.0, 1.0],
                    log: 0,
                    period: PERIOD,
                    torque_rate: vec![0.0; torque.len()],
                    moving: Arc::from([]),
                    excess: Vec::new(),
                    elements: Vec::new(),
                    carried: None,
                    torque,
                    measurements: taken,
                    first,
                    start: vec![0.0, 1e-3, 0.1, 0.2],
                    start_deviation: vec![1e-3, 2e-3, 0.1, 0.2],
                    speeds: Vec::new(),
                }]),
                torque_scale: vec![5.0, 5.0],
                fast_noise: vec![0.0; 2],
                reversals: Reversals::new(&model, &[0.0]),
                left_out: false,
            },
            model,
            channels,
            levels: Levels {
                torque_noise: vec![0.1, 0.3],
                reversal_noise: vec![0.0, 0.8],
                disturbance: vec![0.2, 0.4],
                corner: 3.0,
                sensor_noise: vec![0.0, 5e-4],
            },
        }
    }

    fn segment(&self) -> &Segment {
        &self.measurements.segments[0]
    }

    fn unknowns(&self) -> Unknowns {
        let free = (0..FREE).collect();
        Unknowns::new(
            &self.model,
            &self.channels,
            &self.measurements,
            &TRUTH,
            free,
        )
    }

    /// Unknowns away from the true values. The last one is the offset of the motor's sensor.
    fn z(&self) -> Vec<f64> {
        let unknowns = self.unknowns();
        assert_eq!(unknowns.values(), FREE + 1);
        let mut z = unknowns.point(&TRUTH);
        z[FREE] = 3e-4;
        z
    }

    fn textbook(&self, z: &[f64]) -> Textbook {
        let (theta, offset) = z.split_at(FREE);
        let theta = [theta, &TRUTH[FREE..]].concat();
        Textbook::new(&theta, &self.levels, self.segment(), offset[0])
    }
}

/// Compares numbers that depend on the gains, which are short.
fn agree(found: f64, expected: f64, scale: f64, what: &str) {
    agree_to(2e-5, found, expected, scale, what);
}

fn agree_to(relative: f64, found: f64, expected: f64, scale: f64, what: &str) {
    let tolerance = relative * scale.max(expected.abs());
    let far = (found - expected).abs();
    assert!(far < tolerance, "{what}: {found} against {expected}");
}

fn agree_all(filter: &Filter<'_>, textbook: &Textbook, what: &str) {
    let p = &textbook.p;
    for (i, row) in p.iter().enumerate() {
        let scale = row[i].sqrt();
        let (found, expected) = (filter.x[i], textbook.x[i][0]);
        agree(found, expected, scale, &format!("{what}, x {i}"));
        for (j, expected) in row.iter().enumerate() {
            let found = filter.covariance[i * STATES + j];
            let both = scale * p[j][j].sqrt();
            agree_to(1e-9, found, *expected, both, &format!("{what}, P {i} {j}"));
        }
    }
}

#[test]
fn the_carriage_is_ordered_as_the_textbook_has_it() {
    let case = Case::new();
    let names: Vec<&str> = (case.model.parameters().iter())
        .map(|parameter| parameter.name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "link1.m",
            "carriage.rotor_inertia",
            "carriage.link_viscous",
            "carriage.motor_viscous",
            "carriage.stiffness",
            "carriage.motor_coulomb"
        ]
    );
}

#[test]
fn a_measurement_moves_state_and_covariance_as_in_the_textbook() {
    let case = Case::new();
    let (unknowns, z) = (case.unknowns(), case.z());
    let mut dynamics = Dynamics::new(&case.model, &TRUTH);
    let mut filter = Filter::new(
        &mut dynamics,
        &unknowns,
        &z,
        &case.levels,
        &case.measurements.reversals,
    );
    filter.start(case.segment());
    let mut textbook = case.textbook(&z);
    for measurement in [case.segment().at(0)[0], case.segment().at(3)[0]] {
        let Correction { gain, e, s } = textbook.gain(&measurement, z[FREE]);
        let sensor = &case.measurements.sensors[measurement.sensor];
        let innovation = filter.measure(sensor, &measurement);
        agree(innovation.value, e, s.sqrt(), "e");
        agree_to(1e-9, innovation.deviation, s.sqrt(), 0.0, "root of S");
        for (i, found) in innovation.gains.iter().enumerate() {
            agree(*found, gain[i][0], 1.0, &format!("K {i}"));
        }
        filter.correct();
        textbook.measure(&gain, e, s);
        agree_all(&filter, &textbook, "measured");
    }
}

#[test]
fn a_period_moves_state_and_covariance_as_in_the_textbook() {
    let case = Case::new();
    let (unknowns, z) = (case.unknowns(), case.z());
    let mut dynamics = Dynamics::new(&case.model, &TRUTH);
    let mut filter = Filter::new(
        &mut dynamics,
        &unknowns,
        &z,
        &case.levels,
        &case.measurements.reversals,
    );
    filter.start(case.segment());
    let mut textbook = case.textbook(&z);
    for k in 0..3 {
        let steps = filter.predict(case.segment(), k);
        textbook.predict(case.segment().torque[2 * k + 1], steps);
        agree_all(&filter, &textbook, &format!("period {k}"));
    }
}

/// Gains, innovations and S of the textbook filter over the segment. `held` gives gains and S of
/// another run.
fn textbook_run(
    case: &Case,
    z: &[f64],
    steps: &[u8],
    held: Option<&[(Matrix, f64)]>,
) -> Vec<Correction> {
    let mut textbook = case.textbook(z);
    let mut all = Vec::new();
    for (k, steps) in steps.iter().enumerate() {
        for measurement in case.segment().at(k) {
            let optimal = textbook.gain(measurement, z[FREE]);
            let e = optimal.e;
            let (gain, s) = held.map_or((optimal.gain, optimal.s), |held| held[all.len()].clone());
            textbook.measure(&gain, e, s);
            all.push(Correction { gain, e, s });
        }
        textbook.predict(case.segment().torque[2 * k + 1], usize::from(*steps));
    }
    all
}

#[test]
fn sums_are_those_of_the_textbook_and_its_differences() {
    let case = Case::new();
    let (unknowns, z) = (case.unknowns(), case.z());
    let dynamics = Dynamics::new(&case.model, &TRUTH);
    let keep = Keep::default();
    let (run, _) = run(
        &case.measurements,
        &dynamics,
        &unknowns,
        (&z, &case.levels),
        keep,
        |_, _| (),
    )
    .unwrap();
    let steps = &run.segments[0].schedule.steps;
    let here = textbook_run(&case, &z, steps, None);
    let cost: f64 = here.iter().map(|of| of.e * of.e / of.s).sum();
    let loss: f64 = here
        .iter()
        .map(|of| 0.5 * (of.e * of.e / of.s + of.s.ln()))
        .sum();
    agree(run.sums.cost, cost, 0.0, "V");
    agree(run.sums.loss, loss, cost, "L");
    assert_eq!(run.sums.measurements, here.len() as u64);
    // Derivatives of the innovations by differences, with the gains held.
    let held: Vec<(Matrix, f64)> = here.iter().map(|of| (of.gain.clone(), of.s)).collect();
    let derivatives: Vec<Vec<f64>> = (0..z.len())
        .map(|i| {
            let by = 1e-4 * z[i].abs();
            let at = |by: f64| {
                let mut there = z.clone();
                there[i] += by;
                textbook_run(&case, &there, steps, Some(&held))
            };
            let difference =
                |(after, before): (&Correction, &Correction)| (after.e - before.e) / (2.0 * by);
            at(by).iter().zip(&at(-by)).map(difference).collect()
        })
        .collect();
    let normal = &run.sums.normal;
    for (i, derivative) in derivatives.iter().enumerate() {
        let sum = |other: &dyn Fn(usize) -> f64| -> f64 {
            (here.iter().enumerate())
                .map(|(k, of)| derivative[k] * other(k) / of.s)
                .sum()
        };
        let size = sum(&|k| derivative[k]).sqrt();
        let close = |found: f64, expected: f64, scale: f64, what: String| {
            let far = (found - expected).abs();
            // The derivatives are those of steps linearised in their middles. An error of 2 % of the information is 1 %
            // of a standard error.
            assert!(far < 2e-2 * scale, "{what}: {found} against {expected}");
        };
        let gradient = sum(&|k| here[k].e);
        close(
            normal.gradient[i],
            gradient,
            size * cost.sqrt(),
            format!("gradient {i}"),
        );
        for (j, other) in derivatives.iter().enumerate().take(i + 1) {
            let expected = sum(&|k| other[k]);
            let found = normal.information[i * normal.count + j];
            let both = normal.information[j * (normal.count + 1)].sqrt() * size;
            close(found, expected, both, format!("information {i} {j}"));
        }
    }
}
