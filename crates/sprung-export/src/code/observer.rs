//! The observer of torques from outside in the code: its constants, and a run of the library's observer for the self-test.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sprung_core::drives::State;
use sprung_core::filter::{Discretization, FilterError, FilterPair};
use sprung_core::links::LengthError;
use sprung_core::observer::{ObserverFilters, ZERO_KNOWN_S, ZERO_MEMORY_S};
use sprung_core::parameters::JointParameter;
use sprung_core::presliding::ALL_ELEMENTS;
use sprung_core::robot::Values;
use sprung_method::watch::{ObserverSettings, TorqueObserver};

use super::emit::Language;
use super::graph::values;
use super::trace::{Source, Traced};
use crate::model::{Scratch, Theta};
use crate::reload::worst;

/// Samples of the motion of the self-test, which repeats behind those in which the robot rests and the observer settles.
const SAMPLES: usize = 40;

/// Duration of the repeated motion over the motion in each direction from which the zeros of encoders are known.
const LONG_ENOUGH: f64 = 6.0;

/// Most samples of a self-test.
const MOST_SAMPLES: usize = 100_000;

/// Number of random states.
const STATES: usize = 1000;

/// A sample of the observer.
#[derive(Clone, Debug)]
struct Sample {
    q: Vec<f64>,
    phi: Vec<f64>,
    tau: Vec<f64>,
    /// Readings of the torque sensors.
    sensor: Vec<f64>,
    /// Torques from outside and their thresholds, as the motion is seen the first and the last time.
    outside: [Vec<f64>; 2],
    threshold: [Vec<f64>; 2],
}

impl Sample {
    /// Returns all arrays, in the order of the self-tests.
    pub(super) fn all(&self) -> [&[f64]; 8] {
        let [[first, last], [first_limit, last_limit]] = [&self.outside, &self.threshold];
        [
            &self.q,
            &self.phi,
            &self.tau,
            &self.sensor,
            first,
            last,
            first_limit,
            last_limit,
        ]
    }
}

/// An observer as code.
pub(super) struct Observed<'a> {
    pub(super) settings: &'a ObserverSettings,
    sharpness: Vec<f64>,
    has_memory: bool,
    /// Name of its dynamics.
    dynamics: &'static str,
    about: &'a [String],
    /// Reading of the torque sensor of each joint without torque, N·m (N); `None` without a sensor.
    sensors: Vec<Option<f64>>,
    samples: Vec<Sample>,
    settle: usize,
}

/// Returns why code cannot have an observer of a robot; `None` if it can.
pub(super) fn refused(source: &Source<'_>, settings: &ObserverSettings) -> Option<String> {
    let (model, n) = (source.model, source.robot.joints());
    if !model.joints_without_link().is_empty() {
        return Some(
            "a flexible joint has no link position, and code does not compute one".to_owned(),
        );
    }
    let is_coupled = source.robot.coupling.is_some();
    if is_coupled && model.elements().sets().next().is_some() {
        return Some("code has no presliding friction behind a coupled transmission".to_owned());
    }
    if is_coupled && source.has_sensor().contains(&true) {
        return Some("code has no torque sensors behind a coupled transmission".to_owned());
    }
    let mut numbers = settings.joints.iter().flat_map(|joint| {
        let more = [joint.motor_share, joint.zero_nm, joint.threshold_sigma];
        joint.variance.into_iter().chain(more)
    });
    let is_number = |x: f64| x.is_finite() && x >= 0.0;
    let positive = [
        settings.period_s,
        settings.cutoff_rad_per_s,
        settings.bandwidth_rad_per_s,
    ];
    if !positive.iter().all(|x| x.is_finite() && *x > 0.0) || !numbers.all(is_number) {
        return Some(
            "a period, a cut-off, a variance or a threshold is not a positive number".to_owned(),
        );
    }
    let moved = times(settings).saturating_mul(SAMPLES);
    if filters(settings).is_none_or(|of| of.settle().saturating_add(moved) > MOST_SAMPLES) {
        return Some(format!(
            "its filters settle in more than {MOST_SAMPLES} samples"
        ));
    }
    let joints = settings.joints.len();
    (joints != n).then(|| format!("it has {joints} joints, and the robot has {n}"))
}

impl<'a> Observed<'a> {
    /// Runs the observer of the library on a motion by chance.
    pub(super) fn new(
        source: &Source<'_>,
        settings: &'a ObserverSettings,
        about: &'a [String],
    ) -> Result<Self, String> {
        let (model, theta): (_, Theta) = (source.model, source.theta.to_vec());
        let n = source.robot.joints();
        let mut observer =
            TorqueObserver::new((model, &theta), settings).map_err(|error| error.to_string())?;
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let turn = std::f64::consts::TAU / SAMPLES as f64;
        // Amplitude of one of a quantity whose fastest wave has a rate of one.
        let slow = 2.0 * settings.period_s / turn;
        let mut waves = |middle: f64, size: f64| -> Vec<[f64; 4]> {
            let wave = |_| {
                [
                    middle * random.random_range(-1.0..1.0),
                    size * random.random_range(0.2..1.0),
                    turn * f64::from(random.random_range(1..=2_u8)),
                    random.random_range(-3.0..3.0),
                ]
            };
            (0..n).map(wave).collect()
        };
        let (links, motors) = (waves(1.0, slow), waves(0.05, slow));
        let (torques, sensors) = (waves(5.0, 10.0), waves(5.0, 10.0));
        let at = |waves: &[[f64; 4]], k: usize| -> Vec<f64> {
            let of = waves.iter();
            of.map(|[middle, size, rate, phase]| middle + size * (rate * k as f64 + phase).sin())
                .collect()
        };
        let mut samples: Vec<Sample> = (0..SAMPLES)
            .map(|k| {
                let (q, more) = (at(&links, k), at(&motors, k));
                let is_flexible = |i: usize| source.robot.motor_rows[i].is_some();
                Sample {
                    phi: (0..n)
                        .map(|i| if is_flexible(i) { q[i] + more[i] } else { q[i] })
                        .collect(),
                    tau: at(&torques, k),
                    sensor: at(&sensors, k),
                    q,
                    outside: Default::default(),
                    threshold: Default::default(),
                }
            })
            .collect();
        let (settle, times) = (observer.settle(), times(settings));
        for k in 0..settle + times * SAMPLES {
            let moved = k.saturating_sub(settle);
            let sample = &mut samples[moved % SAMPLES];
            let found = observer.step(&sample.q, &sample.phi, [&sample.tau, &sample.sensor]);
            let which = match moved / SAMPLES {
                0 => 0,
                time if time == times - 1 => 1,
                _ => continue,
            };
            sample.outside[which] = found.iter().map(|[torque, _]| *torque).collect();
            sample.threshold[which] = found.iter().map(|[_, threshold]| *threshold).collect();
        }
        Ok(Self {
            samples,
            settle,
            settings,
            sharpness: (0..n).map(|joint| model.sharpness(joint)).collect(),
            has_memory: source.has_memory(),
            dynamics: source.observer_dynamics(),
            sensors: sensor_offsets(source).map_err(|error| error.to_string())?,
            about,
        })
    }

    /// Returns a template with the constants.
    fn numbers(&self, language: &Language, template: &str) -> String {
        let settings = self.settings;
        let pair = |cutoff: f64, kind: Discretization| -> Result<String, FilterError> {
            let pair = FilterPair::new(cutoff, settings.period_s, kind)?;
            let [now, last] = pair.low_pass();
            Ok(language.constants(&[pair.pole(), now, last]))
        };
        let (cutoff, last) = (settings.cutoff_rad_per_s, settings.bandwidth_rad_per_s);
        let pairs = [
            ("%CONTINUOUS%", pair(cutoff, Discretization::Tustin)),
            ("%HELD%", pair(cutoff, Discretization::ZeroOrderHold)),
            ("%LAST%", pair(last, Discretization::Tustin)),
        ];
        let joints = &settings.joints;
        let column = |of: &dyn Fn(usize) -> f64| {
            language.constants(&(0..joints.len()).map(of).collect::<Vec<f64>>())
        };
        let mut text = self.with_sensors(language, template);
        for (name, pair) in pairs {
            // The observer of the library has the same filters.
            text = text.replace(name, &pair.unwrap_or_default());
        }
        text.replace("%CUTOFF%", &language.constant(cutoff))
            .replace("%PERIOD%", &language.constant(settings.period_s))
            .replace("%ZERO_MEMORY%", &language.constant(ZERO_MEMORY_S))
            .replace("%ZERO_KNOWN%", &language.constant(ZERO_KNOWN_S))
            .replace("%ZERO%", &column(&|i| joints[i].zero_nm))
            .replace("%SHARE%", &column(&|i| joints[i].motor_share))
            .replace("%SIGMA%", &column(&|i| joints[i].threshold_sigma))
            .replace("%SHARPNESS%", &column(&|i| self.sharpness[i]))
            .replace(
                "%VARIANCE%",
                &(joints.iter())
                    .map(|joint| language.row(&joint.variance))
                    .collect::<String>(),
            )
    }

    /// Returns a template with what torque sensors need.
    fn with_sensors(&self, language: &Language, template: &str) -> String {
        let has_sensors = self.sensors.iter().any(Option::is_some);
        let mut text = template.to_owned();
        for (name, code) in language.sensors {
            text = text.replace(name, if has_sensors { code } else { "" });
        }
        let spring = if has_sensors {
            language.spring.to_owned()
        } else {
            language.constant(0.0)
        };
        let offsets: Vec<f64> = (self.sensors.iter())
            .map(|of| of.unwrap_or_default())
            .collect();
        let truths: Vec<&str> = (self.sensors.iter())
            .map(|of| language.truths[usize::from(of.is_some())])
            .collect();
        text.replace("%SPRING%", &spring)
            .replace("%HAS_SENSOR%", &truths.join(", "))
            .replace("%SENSOR_OFFSET%", &language.constants(&offsets))
    }

    /// Returns a template of the observer or of its self-test with all that it contains.
    pub(super) fn filled(&self, language: &Language, template: &str) -> String {
        let call = (language.observed)(self.dynamics, self.has_memory);
        let samples = self.samples.iter().map(Sample::all);
        let mut text = self.numbers(language, template);
        for (name, code) in language.memory {
            text = text.replace(name, if self.has_memory { code } else { "" });
        }
        text.replace("%DYNAMICS%", &call)
            .replace("%SETTLE%", &self.settle.to_string())
            .replace("%COUNT%", &self.samples.len().to_string())
            .replace("%TIMES%", &times(self.settings).to_string())
            .replace("%SAMPLES%", &language.elements(samples))
            .replace("%HEADER%", &language.comments(self.about))
    }
}

/// Returns how often the motion of the self-test repeats: the zeros of the encoders are known at the last time.
fn times(settings: &ObserverSettings) -> usize {
    let motions = LONG_ENOUGH * ZERO_KNOWN_S / (SAMPLES as f64 * settings.period_s);
    (motions.ceil() as usize).saturating_add(2)
}

fn filters(settings: &ObserverSettings) -> Option<ObserverFilters> {
    ObserverFilters::new(
        settings.cutoff_rad_per_s,
        settings.bandwidth_rad_per_s,
        settings.period_s,
    )
    .ok()
}

/// Returns the parameters with torque sensors that read zero without torque.
fn without_offsets(source: &Source<'_>) -> Theta {
    let mut theta = source.theta.to_vec();
    for joint in 0..source.robot.joints() {
        if let Some(offset) = source.model.index(JointParameter::TorqueOffset, joint) {
            theta[offset] = 0.0;
        }
    }
    theta
}

/// Returns the reading of the torque sensor of each joint without torque, N·m (N); `None` without a sensor.
fn sensor_offsets(source: &Source<'_>) -> Result<Vec<Option<f64>>, LengthError> {
    let (n, theta) = (source.robot.joints(), without_offsets(source));
    let at_rest = |theta: &[f64]| -> Result<Vec<f64>, LengthError> {
        let zeros = vec![0.0; n];
        let elements = vec![0.0; n * ALL_ELEMENTS];
        let state = State {
            q: &zeros,
            dq: &zeros,
            phi: &zeros,
            dphi: &zeros,
            excess: &[],
            elements: &elements,
        };
        required(
            source,
            theta,
            &state,
            &vec![0.0; source.model.coordinates()],
        )
    };
    let (with, without) = (at_rest(source.theta)?, at_rest(&theta)?);
    let has_sensor = source.has_sensor().into_iter().enumerate();
    Ok(has_sensor
        .map(|(joint, has_sensor)| has_sensor.then(|| with[joint] - without[joint]))
        .collect())
}

/// Returns the torques that a motion requires beside those that torque sensors measure.
fn required(
    source: &Source<'_>,
    theta: &[f64],
    state: &State<'_>,
    acceleration: &[f64],
) -> Result<Vec<f64>, LengthError> {
    let mut scratch = Scratch::new(source.robot.joints());
    let mut required = vec![0.0; source.model.coordinates()];
    let values = Values {
        theta,
        bodies: source.bodies,
    };
    source.model.regressor().required_torques(
        &values,
        state,
        acceleration,
        &mut scratch.workspace(),
        &mut required,
    )?;
    Ok(required)
}

/// Returns the largest difference of the dynamics of an observer from the library at random states, relative to the largest torque.
///
/// # Errors
///
/// [`LengthError`] if arrays do not fit the robot.
pub(super) fn prove(source: &Source<'_>, traced: &Traced) -> Result<f64, LengthError> {
    let (robot, n) = (&source.robot, source.robot.joints());
    let theta = without_offsets(source);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut difference = 0.0;
    for _ in 0..STATES {
        let mut some = |count: usize, size: f64| -> Vec<f64> {
            (0..count)
                .map(|_| random.random_range(-size..size))
                .collect()
        };
        let mut motion = [1.0, 2.0, 10.0, 1.0, 2.0, 10.0].map(|size| some(n, size));
        let elements = some(n * ALL_ELEMENTS, 1.0);
        for joint in (0..n).filter(|joint| robot.motor_rows[*joint].is_none()) {
            for order in 0..3 {
                motion[3 + order][joint] = motion[order][joint];
            }
        }
        let [q, dq, ddq, phi, dphi, ddphi] = &motion;
        let state = State {
            q,
            dq,
            phi,
            dphi,
            excess: &[],
            elements: &elements,
        };
        let mut acceleration = vec![0.0; robot.rows()];
        for joint in 0..n {
            acceleration[joint] = ddq[joint];
            acceleration[robot.motor_coordinate(joint)] = ddphi[joint];
        }
        let required = required(source, &theta, &state, &acceleration)?;
        let (mut link, mut motor) = (required[..n].to_vec(), vec![0.0; n]);
        for joint in 0..n {
            motor[joint] = required[robot.motor_coordinate(joint)];
            if robot.motor_rows[joint].is_none() {
                link[joint] = 0.0;
            }
        }
        let mut inputs = motion.concat();
        if !source.model.elements().is_empty() {
            inputs.extend(&elements);
        }
        let found = values(&traced.operations, &traced.results, &inputs);
        worst(&mut difference, &[link, motor].concat(), &found);
    }
    Ok(difference)
}
