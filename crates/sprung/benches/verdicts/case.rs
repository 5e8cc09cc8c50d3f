//! A case: an arm, its fault, and logs of the same kind of experiment.

use std::collections::BTreeMap;
use std::fmt::Write;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use sprung::description::{self, Controller, Experiment, Simulate, no_files};
use sprung::model::{Model, Theta};
use sprung::simulate::{Twin, TwinSetup};

use crate::arm::{Arm, MAX_JOINTS};
use crate::kind::{Fault, Kind, Misfit, Weak, WrongUnit};

/// Velocity at which Stribeck friction has fallen to 1/e, rad/s.
const STRIBECK_RAD_PER_S: f64 = 0.05;

/// Velocity below which the friction of an effect that the model lacks changes its direction, rad/s.
const REVERSAL_RAD_PER_S: f64 = 0.01;

/// Numbers of joints, each with the same probability. Small arms are more frequent, because large
/// ones take long.
const JOINTS: [usize; 20] = [
    1, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 5, 5, 6, MAX_JOINTS,
];

/// Number of sines of each joint.
const SINES: usize = 4;

/// A case.
pub(crate) struct Case {
    pub(crate) kind: Kind,
    pub(crate) seed: u64,
    pub(crate) fault: Fault,
    pub(crate) joints: usize,
    /// The experiment that a user writes.
    pub(crate) experiment: Experiment,
    /// True values of the parameters of its model, \[p\]; `None` for the description of another
    /// robot.
    pub(crate) truth: Option<Theta>,
    pub(crate) model: Model,
    /// The robot that makes the logs: its experiment, its model, and its parameters with the
    /// preloads of the encoders' zeros, \[p\].
    pub(crate) robot: Experiment,
    pub(crate) plant: Model,
    pub(crate) of_robot: Theta,
    // The parameters of the simulation, whose encoders have no zeros.
    theta: Theta,
    arm: Arm,
    controller: Controller,
    settings: Simulate,
    sensors: Sensors,
}

/// The sensors of an arm. The zeros of its encoders are the same in all logs.
struct Sensors {
    /// Smallest step of each encoder, rad, and its zero in steps: links, then motors.
    encoders: Vec<(f64, f64)>,
    /// Standard deviations of the logged torques, N·m.
    torque_noise: Vec<f64>,
}

/// A log as columns: link positions, motor positions and motor torques.
struct Table {
    time: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl Case {
    /// Returns the case of a kind and a seed.
    pub(crate) fn new(kind: Kind, seed: u64) -> Self {
        let stream = Kind::ALL.iter().position(|own| *own == kind);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream.unwrap_or_default() as u64);
        let joints = JOINTS[rng.random_range(0..JOINTS.len())];
        let arm = Arm::random(joints, &mut rng);
        let fault = Fault::random(kind, joints, &mut rng);
        let other = Arm::random(joints, &mut rng);
        let tail = arm.log_and_controller();
        let mut robot = read(&format!(
            "format = 1\n{}{tail}\n[[validate]]\nname = \"held-out\"\n",
            arm.robot(&plant_laws(&arm, fault))
        ));
        let described = match fault {
            Fault::WrongUnit(WrongUnit::Foreign) => &other,
            _ => &arm,
        };
        let mut experiment = read(&format!(
            "format = 1\n{}{tail}\n[[validate]]\nname = \"held-out\"\n",
            described.robot(&[])
        ));
        let controller = robot.controller.take().expect("it has one");
        experiment.controller = None;
        let model = Model::new(&experiment).expect("the arm has a model");
        let plant = Model::new(&robot).expect("the arm has a model");
        let sensors = Sensors::random(&arm, fault, &mut rng);
        let preloads = sensors.preloads(&arm);
        let mut case = Self {
            settings: settings(&arm, kind, fault, &mut rng),
            theta: theta(&plant, &plant_truth(&arm, fault, &vec![0.0; joints])),
            of_robot: theta(&plant, &plant_truth(&arm, fault, &preloads)),
            truth: Some(theta(&model, &model_truth(&arm, fault, &preloads))),
            sensors,
            kind,
            seed,
            fault,
            joints,
            experiment,
            model,
            robot,
            arm,
            plant,
            controller,
        };
        if fault == Fault::WrongUnit(WrongUnit::Foreign) {
            case.truth = None;
        }
        if let Fault::Misfit(Misfit::Cubic(_)) = fault {
            case.straighten();
        }
        case
    }

    /// Returns the number of logs from which the coverage of the intervals is counted: a small arm
    /// has few parameters.
    pub(crate) fn logs(&self) -> u64 {
        match self.joints {
            1 => 4,
            2 => 2,
            _ => 1,
        }
    }

    /// Returns a log as CSV. Each number gives another motion of the same kind with other noise.
    /// `None` if the loop runs away.
    pub(crate) fn log(&self, number: u64) -> Option<Vec<u8>> {
        self.record(number, self.fault)
    }

    /// Returns the log with the same number as the true robot explains it: without delays, wrong
    /// units and torques beyond its model.
    pub(crate) fn explained_log(&self, number: u64) -> Option<Vec<u8>> {
        self.record(number, Fault::None)
    }

    fn record(&self, number: u64, fault: Fault) -> Option<Vec<u8>> {
        Some(self.table(number, fault)?.csv(&self.header()))
    }

    fn table(&self, number: u64, fault: Fault) -> Option<Table> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(100 + number);
        let controller = self.with_reference(&mut rng);
        let settings = Simulate {
            seed: rng.random(),
            ..self.settings.clone()
        };
        let setup = TwinSetup {
            model: &self.plant,
            theta: &self.theta,
            controller: &controller,
            settings: &settings,
        };
        let mut twin = Twin::new(&setup).ok()?;
        let samples = (settings.duration_s / settings.period_s).round() as usize;
        let mut table = Table {
            time: Vec::new(),
            columns: vec![Vec::new(); 3 * self.joints],
        };
        for k in 0..samples {
            let velocity = twin.plant().state().dphi;
            let sample = twin.sample().ok()?;
            let part = k as f64 / samples as f64;
            let (mut q, mut phi, mut tau) = (sample.q, sample.phi, sample.tau);
            if let Fault::Misfit(misfit) = fault {
                for joint in 0..self.joints {
                    let motion = [q[joint], phi[joint], velocity[joint]];
                    tau[joint] = self.logged_torque(misfit, joint, tau[joint], motion, part);
                    if let Misfit::Eccentric(size) = misfit {
                        q[joint] += size * q[joint].sin();
                    }
                }
            }
            let encoders = self.sensors.encoders.iter();
            for ((step, phase), value) in encoders.zip(q.iter_mut().chain(&mut phi)) {
                *value = step * (*value / step + phase).floor();
            }
            for (value, noise) in tau.iter_mut().zip(&self.sensors.torque_noise) {
                *value += noise * rng.sample::<f64, _>(StandardNormal);
            }
            table.time.push(sample.time);
            let values = q.iter().chain(&phi).chain(&tau);
            for (column, value) in table.columns.iter_mut().zip(values) {
                column.push(*value);
            }
        }
        self.damage(&mut table, fault);
        Some(table)
    }

    /// Replaces stiffness and preload of stiffening springs by those of the straight line nearest to
    /// the torque of the spring along the first log, because the user's model has such a line.
    fn straighten(&mut self) -> Option<()> {
        let table = self.table(0, Fault::None)?;
        let truth = self.truth.as_mut()?;
        let joints = self.joints;
        for joint in 0..joints {
            let of = |model: &Model, theta: &Theta, name: &str| {
                let index = model.index_of(&format!("joint{}.{name}", joint + 1));
                index.ok().map(|index| theta[index])
            };
            let stiffness = of(&self.plant, &self.of_robot, "stiffness")?;
            let cubic = of(&self.plant, &self.of_robot, "cubic_stiffness")?;
            let zero = of(&self.plant, &self.of_robot, "spring_preload")? / stiffness;
            let readings = table.columns[joint]
                .iter()
                .zip(&table.columns[joints + joint]);
            let (mut n, mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for (q, phi) in readings {
                let reading = phi - q;
                let deflection = reading - zero;
                let torque = stiffness * deflection + cubic * deflection.powi(3);
                n += 1.0;
                x += reading;
                y += torque;
                xx += reading * reading;
                xy += reading * torque;
            }
            let slope = (n * xy - x * y) / (n * xx - x * x);
            let preload = slope * x / n - y / n;
            for (name, value) in [("stiffness", slope), ("spring_preload", preload)] {
                let index = self
                    .model
                    .index_of(&format!("joint{}.{name}", joint + 1))
                    .ok()?;
                truth[index] = value;
            }
        }
        Some(())
    }

    /// Returns the controller with a random reference.
    fn with_reference(&self, rng: &mut ChaCha8Rng) -> Controller {
        let (mut amplitude, mut pace) = (1.0, 1.0);
        match self.fault {
            Fault::Weak(Weak::Small(by)) => amplitude = by,
            Fault::Weak(Weak::Slow(by)) => pace = by,
            _ => {}
        }
        let mut text = "[reference]\ncentre_deg = [".to_owned();
        for joint in 0..self.joints {
            let centre = [20.0, -35.0, 30.0, -60.0, 15.0, 45.0, -25.0][joint];
            write!(text, "{centre:.1}, ").expect("a string takes any text");
        }
        text.push_str("]\nsines = [\n");
        // Each sine has its band.
        let draw = |sine: usize, rng: &mut ChaCha8Rng| {
            pace * (0.1 + 0.275 * (sine as f64 + rng.random::<f64>()))
        };
        let common: Vec<f64> = (0..SINES).map(|sine| draw(sine, rng)).collect();
        let directions: Vec<f64> = (0..self.joints)
            .map(|_| if rng.random::<bool>() { 90.0 } else { -90.0 })
            .collect();
        for (joint, direction) in directions.into_iter().enumerate() {
            let mut part = amplitude;
            if let Fault::Weak(Weak::OneStill(by)) = self.fault
                && joint == self.seed as usize % self.joints
            {
                part = by;
            }
            let phase = match self.fault {
                Fault::Weak(Weak::InPhase) => 90.0,
                _ => direction,
            };
            // The sum of the reference and of its velocity is zero at the start.
            let (one, two) = (rng.random_range(4.0..12.0), rng.random_range(4.0..12.0));
            let share = rng.random_range(0.4..0.6);
            let sizes = [one, two, share * (one + two), (1.0 - share) * (one + two)];
            for sine in 0..SINES {
                let frequency = match self.fault {
                    Fault::Weak(Weak::OneFrequency) if sine < 2 => 0.4 * pace,
                    Fault::Weak(Weak::OneFrequency) => 0.8 * pace,
                    Fault::Weak(Weak::InPhase) => common[sine],
                    _ => draw(sine, rng),
                };
                let (size, phase) = (part * sizes[sine], if sine < 2 { phase } else { -phase });
                writeln!(
                    text,
                    "  {{ joint = \"joint{}\", amplitude_deg = {size:e}, frequency_hz = \
                     {frequency:e}, phase_deg = {phase:.1} }},",
                    joint + 1
                )
                .expect("a string takes any text");
            }
        }
        text.push_str("]\n");
        let mut controller = self.controller.clone();
        let parsed: WithReference = toml::from_str(&text).expect("the reference is right");
        controller.reference = parsed.reference;
        controller
    }

    /// Returns the torque that a log contains if the robot has an effect that the model lacks.
    ///
    /// - `motion`: link position, motor position and its velocity; `part`: time over duration.
    fn logged_torque(
        &self,
        misfit: Misfit,
        joint: usize,
        torque: f64,
        [q, phi, velocity]: [f64; 3],
        part: f64,
    ) -> f64 {
        let drive = &self.arm.drives[joint];
        let direction = (velocity / REVERSAL_RAD_PER_S).tanh();
        match misfit {
            Misfit::Ripple(size, periods) => torque + size * drive.effort * (periods * phi).sin(),
            Misfit::Warming(change) => torque + change * part * drive.motor_coulomb * direction,
            Misfit::LoadFriction(factor) => {
                torque + factor * (drive.stiffness * (phi - q)).abs() * direction
            }
            Misfit::Saturation(change) => {
                torque / (1.0 + change * (torque / drive.effort).powi(2)).max(0.5)
            }
            Misfit::Stribeck(_)
            | Misfit::Cubic(_)
            | Misfit::TorqueDelay(_)
            | Misfit::Eccentric(_)
            | Misfit::LateLinks(_) => torque,
        }
    }

    /// Applies delays and wrong units to a log.
    fn damage(&self, table: &mut Table, fault: Fault) {
        let n = self.joints;
        let (one, two) = (self.seed as usize % n, (self.seed as usize + 1) % n);
        let (links, motors, torques) = (0..n, n..2 * n, 2 * n..3 * n);
        let wrong = match fault {
            Fault::Misfit(Misfit::TorqueDelay(samples)) => {
                // The record precedes the action: the positions belong to earlier rows.
                table.shift(0..2 * n, samples);
                return;
            }
            Fault::Misfit(Misfit::LateLinks(samples)) => {
                table.shift(links, samples);
                return;
            }
            Fault::WrongUnit(wrong) => wrong,
            Fault::None | Fault::Misfit(_) | Fault::Weak(_) => return,
        };
        match wrong {
            WrongUnit::MotorSide { one: single } => {
                for (joint, drive) in self.arm.drives.iter().enumerate() {
                    if !single || joint == one {
                        table.scale(2 * n + joint, 1.0 / drive.gear_ratio);
                    }
                }
            }
            WrongUnit::Millinewton => torques.for_each(|column| table.scale(column, 1e3)),
            WrongUnit::Current(constant) => {
                torques.for_each(|column| table.scale(column, 1.0 / constant));
            }
            WrongUnit::Degrees { all } => {
                let first = if all { 0 } else { n };
                (first..2 * n).for_each(|column| table.scale(column, 1_f64.to_degrees()));
            }
            WrongUnit::LinkDegrees => table.scale(one, 1_f64.to_degrees()),
            WrongUnit::MotorTurns => {
                for (column, drive) in motors.zip(&self.arm.drives) {
                    table.scale(column, drive.gear_ratio);
                }
            }
            WrongUnit::Gear(by) => table.scale(n + one, by),
            WrongUnit::Sign(which) => table.scale([2 * n, n, 0][which] + one, -1.0),
            WrongUnit::Swapped(which) => {
                let first = [2 * n, n, 0][which];
                table.columns.swap(first + one, first + two);
            }
            WrongUnit::Exchanged => table.columns.swap(one, n + one),
            WrongUnit::Milliseconds => table.time.iter_mut().for_each(|time| *time *= 1e3),
            WrongUnit::Foreign => {}
        }
    }

    fn header(&self) -> String {
        let names = [("q", "rad"), ("phi", "rad"), ("tau", "nm")];
        let columns = names.iter().flat_map(|(name, unit)| {
            (1..=self.joints).map(move |joint| format!("{name}{joint}_{unit}"))
        });
        std::iter::once("t_s".to_owned())
            .chain(columns)
            .collect::<Vec<_>>()
            .join(",")
    }
}

/// A controller's reference alone.
#[derive(serde::Deserialize)]
struct WithReference {
    reference: description::Reference,
}

impl Table {
    fn scale(&mut self, column: usize, by: f64) {
        self.columns[column]
            .iter_mut()
            .for_each(|value| *value *= by);
    }

    /// Moves columns later by a number of samples.
    fn shift(&mut self, columns: std::ops::Range<usize>, samples: usize) {
        let left = self.time.len() - samples;
        for (i, values) in self.columns.iter_mut().enumerate() {
            if columns.contains(&i) {
                values.truncate(left);
            } else {
                values.drain(..samples);
            }
        }
        self.time.truncate(left);
    }

    fn csv(&self, header: &str) -> Vec<u8> {
        let mut text = format!("{header}\n");
        for (k, time) in self.time.iter().enumerate() {
            write!(text, "{time}").expect("a string takes any text");
            for column in &self.columns {
                write!(text, ",{}", column[k]).expect("a string takes any text");
            }
            text.push('\n');
        }
        text.into_bytes()
    }
}

fn read(text: &str) -> Experiment {
    description::read("experiment.toml", text, &[], &mut no_files).expect("the arm is right")
}

/// Returns the further keys of the joints of the robot that makes the logs.
fn plant_laws(arm: &Arm, fault: Fault) -> Vec<String> {
    let keys = match fault {
        Fault::Misfit(Misfit::Stribeck(_)) => format!(
            "motor_friction = [\"viscous\", \"coulomb\", \"stribeck\"]\n\
             stribeck_velocity_rad_per_s = {STRIBECK_RAD_PER_S}\n"
        ),
        Fault::Misfit(Misfit::Cubic(_)) => "spring = [\"linear\", \"cubic\"]\n".to_owned(),
        _ => String::new(),
    };
    vec![keys; arm.joints()]
}

/// Returns the true values of the robot that makes the logs.
///
/// - `preloads`: torque of each spring at equal readings of its encoders, N·m.
fn plant_truth(arm: &Arm, fault: Fault, preloads: &[f64]) -> BTreeMap<String, f64> {
    let mut values = arm.truth();
    for (i, preload) in preloads.iter().enumerate() {
        values.insert(format!("joint{}.spring_preload", i + 1), *preload);
    }
    for (i, drive) in arm.drives.iter().enumerate() {
        let joint = i + 1;
        if let Fault::Misfit(Misfit::Stribeck(part)) = fault {
            values.insert(
                format!("joint{joint}.motor_stribeck"),
                part * drive.motor_coulomb,
            );
        }
        if let Fault::Misfit(Misfit::Cubic(part)) = fault {
            let cubic = part * drive.stiffness.powi(3) / drive.effort.powi(2);
            values.insert(format!("joint{joint}.cubic_stiffness"), cubic);
        }
    }
    values
}

/// Returns the true values of the parameters that the user's model has, too. Friction that changes
/// has its mean.
fn model_truth(arm: &Arm, fault: Fault, preloads: &[f64]) -> BTreeMap<String, f64> {
    let mut values = plant_truth(arm, Fault::None, preloads);
    if let Fault::Misfit(Misfit::Warming(change)) = fault {
        for (name, value) in &mut values {
            if name.ends_with(".motor_coulomb") {
                *value *= 1.0 + 0.5 * change;
            }
        }
    }
    values
}

/// Returns a parameter vector. Parameters of joints without a value are zero.
fn theta(model: &Model, values: &BTreeMap<String, f64>) -> Theta {
    let mut values = values.clone();
    for parameter in model.parameters().iter().filter(|p| p.joint.is_some()) {
        values.entry(parameter.name.clone()).or_insert(0.0);
    }
    model.theta(&values).expect("the arm has its parameters")
}

impl Sensors {
    fn random(arm: &Arm, fault: Fault, rng: &mut ChaCha8Rng) -> Self {
        let link = 1_u32 << rng.random_range(14..20);
        let motor = 1_u32 << rng.random_range(10..13);
        let noise = rng.random_range(0.0005..0.01);
        let before_gears = (arm.drives.iter()).map(|drive| motor * drive.gear_ratio as u32);
        let counts: Vec<u32> = match fault {
            Fault::Weak(Weak::Coarse(counts)) => vec![counts; 2 * arm.joints()],
            _ => std::iter::repeat_n(link, arm.joints())
                .chain(before_gears)
                .collect(),
        };
        Self {
            encoders: (counts.into_iter())
                .map(|counts| {
                    let step = std::f64::consts::TAU / f64::from(counts);
                    (
                        step,
                        rng.random::<f64>() + rng.random_range(-3e-4..3e-4) / step,
                    )
                })
                .collect(),
            torque_noise: (arm.drives.iter())
                .map(|drive| noise * drive.effort)
                .collect(),
        }
    }

    /// Returns the torque of each spring at equal readings of its encoders, N·m.
    fn preloads(&self, arm: &Arm) -> Vec<f64> {
        // A count stands for the middle of its step.
        let zero = |(step, phase): (f64, f64)| step * (phase - 0.5);
        (arm.drives.iter().enumerate())
            .map(|(joint, drive)| {
                let [link, motor] = [joint, arm.joints() + joint].map(|i| zero(self.encoders[i]));
                drive.stiffness * (motor - link)
            })
            .collect()
    }
}

/// Draws duration, rate and disturbances.
fn settings(arm: &Arm, kind: Kind, fault: Fault, rng: &mut ChaCha8Rng) -> Simulate {
    let joints = arm.joints();
    let duration = match fault {
        Fault::Weak(Weak::Short(duration)) => duration,
        _ if joints <= 3 => 10.0,
        _ => 6.0,
    };
    let period = if joints == 1 && rng.random::<bool>() {
        2e-3
    } else {
        1e-3
    };
    // Slow torques that the motion does not explain act on some robots.
    let disturbed = kind == Kind::Matched && rng.random_range(0..10) < 4;
    let disturbance = if disturbed {
        rng.random_range(0.001..0.01)
    } else {
        0.0
    };
    let disturbances: Vec<String> = (arm.drives.iter())
        .map(|drive| format!("{:e}", disturbance * drive.effort))
        .collect();
    toml::from_str(&format!(
        "duration_s = {duration:.3}\nperiod_s = {period}\nseed = 1\n\
         torque_disturbance_nm = [{}]\n",
        disturbances.join(", ")
    ))
    .expect("the settings are right")
}
