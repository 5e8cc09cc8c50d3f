//! A case: an arm, its fault, and logs of the same kind of experiment.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use sprung_method::simulate::{Twin, TwinSetup};
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, Controller, Experiment, Simulate, no_files};

use crate::arm::{Arm, MAX_JOINTS};
use crate::columns::Table;
use crate::faults::{damage, logged_torque};
use crate::kind::{Fault, Kind, Misfit, WrongUnit};
use crate::motion::{reference, settings};
use crate::sensors::Sensors;
use crate::truth::{model_truth, plant_laws, plant_truth, theta};

/// Numbers of joints, each with the same probability. Small arms are more frequent, because large
/// ones take long.
const JOINTS: [usize; 20] = [
    1, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 5, 5, 6, MAX_JOINTS,
];

/// A case.
pub(crate) struct Case {
    pub(crate) kind: Kind,
    pub(crate) seed: u64,
    pub(crate) fault: Fault,
    pub(crate) joints: usize,
    /// The experiment that a user writes, and its text.
    pub(crate) experiment: Experiment,
    pub(crate) text: String,
    /// True values of the parameters of its model, \[p\]; `None` for the description of another
    /// robot.
    pub(crate) truth: Option<Theta>,
    pub(crate) model: Model,
    /// The robot that makes the logs: its experiment, its model, and its parameters with the
    /// preloads of the encoders' zeros, \[p\].
    pub(crate) robot: Experiment,
    pub(crate) plant: Model,
    pub(crate) of_robot: Theta,
    recorder: Recorder,
}

/// What makes the logs.
struct Recorder {
    arm: Arm,
    /// The parameters of the simulation, whose encoders have no zeros.
    theta: Theta,
    controller: Controller,
    settings: Simulate,
    sensors: Sensors,
}

impl Case {
    /// Returns the case of a kind and a seed.
    pub(crate) fn new(kind: Kind, seed: u64) -> Self {
        let stream = Kind::ALL.iter().position(|other| *other == kind);
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
        let of_user = tail.split("[controller]").next().unwrap_or_default();
        let text = format!(
            "format = 1\n{}{of_user}\n[[validate]]\nname = \"held-out\"\n",
            described.robot(&[])
        );
        let experiment = read(&text);
        let controller = robot.controller.take().expect("it has one");
        let model = Model::new(&experiment).expect("the arm has a model");
        let plant = Model::new(&robot).expect("the arm has a model");
        let sensors = Sensors::random(&arm, fault, &mut rng);
        let preloads = sensors.preloads(&arm);
        let mut case = Self {
            of_robot: theta(&plant, &plant_truth(&arm, fault, &preloads)),
            truth: Some(theta(&model, &model_truth(&arm, fault, &preloads))),
            recorder: Recorder {
                settings: settings(&arm, kind, fault, &mut rng),
                theta: theta(&plant, &plant_truth(&arm, fault, &vec![0.0; joints])),
                arm,
                controller,
                sensors,
            },
            kind,
            seed,
            fault,
            joints,
            experiment,
            text,
            model,
            robot,
            plant,
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
        let controller = Controller {
            reference: reference(self.fault, self.joints, self.seed, &mut rng),
            ..self.recorder.controller.clone()
        };
        let settings = Simulate {
            seed: rng.random(),
            ..self.recorder.settings.clone()
        };
        let setup = TwinSetup {
            model: &self.plant,
            theta: &self.recorder.theta,
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
                    let drive = &self.recorder.arm.drives[joint];
                    tau[joint] = logged_torque(drive, misfit, tau[joint], motion, part);
                    if let Misfit::Eccentric(size) = misfit {
                        q[joint] += size * q[joint].sin();
                    }
                }
            }
            let encoders = self.recorder.sensors.encoders.iter();
            for ((step, phase), value) in encoders.zip(q.iter_mut().chain(&mut phi)) {
                *value = step * (*value / step + phase).floor();
            }
            for (value, noise) in tau.iter_mut().zip(&self.recorder.sensors.torque_noise) {
                *value += noise * rng.sample::<f64, _>(StandardNormal);
            }
            table.time.push(sample.time);
            let values = q.iter().chain(&phi).chain(&tau);
            for (column, value) in table.columns.iter_mut().zip(values) {
                column.push(*value);
            }
        }
        damage(&self.recorder.arm, self.seed, &mut table, fault);
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

fn read(text: &str) -> Experiment {
    description::read("experiment.toml", text, &[], &mut no_files).expect("the arm is right")
}
