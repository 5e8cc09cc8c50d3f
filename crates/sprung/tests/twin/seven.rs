//! An arm with seven flexible joints: the twin of `examples/seven-joint-twin`.

use std::collections::BTreeMap;
use std::path::Path;

use sprung_base::progress::Unheard;
use sprung_core::parameters::JointParameter;
use sprung_core::spatial::BODY_NAMES;
use sprung_log::{Channels, Input, LogSource};
use sprung_method::estimate::{Decided, EstimateResult, Identified, ParameterEstimate, identify};
use sprung_method::simulate::{TwinSetup, record};
use sprung_model::{Model, Theta};
use sprung_robot::{
    self as description, Constraints, Cutoff, EncoderOffset, Estimator, Experiment, Payload,
    Simulate, no_files,
};

use sprung_testing::Figure;

use crate::logs::identify_log;

pub(crate) const EXPERIMENT: &str =
    include_str!("../../../../examples/seven-joint-twin/experiment.toml");
const TRUTH: &str = include_str!("../../../../examples/seven-joint-twin/truth.toml");

/// Share of the largest torque of a row. A parameter with a larger share counts.
const MATTERS: f64 = 0.01;

pub(crate) struct Arm {
    pub(crate) experiment: Experiment,
    pub(crate) model: Model,
    pub(crate) truth: Theta,
    offsets: Vec<f64>,
}

/// The error of a parameter.
pub(crate) struct OffBy {
    pub(crate) name: String,
    /// Share of the torque.
    pub(crate) share: f64,
    /// Percent.
    pub(crate) error: f64,
}

impl Arm {
    fn new(change: impl FnOnce(&mut Experiment)) -> Self {
        Self::of(EXPERIMENT, change)
    }

    pub(crate) fn of(text: &str, change: impl FnOnce(&mut Experiment)) -> Self {
        let mut experiment = description::read("arm", text, &[], &mut no_files).unwrap();
        change(&mut experiment);
        let model = Model::new(&experiment).unwrap();
        let values: BTreeMap<String, f64> = toml::from_str(TRUTH).unwrap();
        let mut truth = model.theta(&known(&model, &values)).unwrap();
        // The preload is the spring torque at equal encoder readings, which the encoder offset causes.
        let offsets = experiment
            .simulate
            .as_ref()
            .unwrap()
            .motor_encoder_offset_rad
            .clone();
        for (joint, offset) in offsets.iter().enumerate() {
            let stiffness = truth[model.index(JointParameter::Stiffness, joint).unwrap()];
            if let Some(preload) = model.index(JointParameter::Preload, joint) {
                truth[preload] = stiffness * offset;
            }
        }
        Self {
            experiment,
            model,
            truth,
            offsets,
        }
    }

    pub(crate) fn log(&self, change: impl FnOnce(&mut Simulate)) -> Vec<u8> {
        self.log_of(&toml::from_str(TRUTH).unwrap(), change)
    }

    /// Returns a log of a robot with other parameters.
    fn log_of(
        &self,
        values: &BTreeMap<String, f64>,
        change: impl FnOnce(&mut Simulate),
    ) -> Vec<u8> {
        let mut settings = self.experiment.simulate.clone().unwrap();
        change(&mut settings);
        let setup = TwinSetup {
            model: &self.model,
            theta: &self.model.theta(&known(&self.model, values)).unwrap(),
            controller: self.experiment.controller.as_ref().unwrap(),
            settings: &settings,
        };
        let columns = self.experiment.log.as_ref().unwrap();
        let channels = Channels::new(&self.experiment.robot, columns).unwrap();
        let mut log = Vec::new();
        record(&setup, &channels, &mut log, &mut Unheard).unwrap();
        log
    }

    pub(crate) fn identify(&self, log: &[u8]) -> Identified {
        identify_log(&self.experiment, &self.model, log).unwrap()
    }

    /// Returns the errors of the parameters that matter.
    pub(crate) fn errors(&self, result: &EstimateResult) -> Vec<OffBy> {
        (result.parameters.iter().zip(&self.truth))
            // A preload also contains the encoder positions at the start.
            .filter(|(p, _)| !p.name.ends_with("spring_preload"))
            .filter(|(p, _)| p.torque_share.unwrap() >= MATTERS)
            .map(|(p, truth)| OffBy {
                name: p.name.clone(),
                share: p.torque_share.unwrap(),
                error: 100.0 * (p.value.unwrap() / truth - 1.0).abs(),
            })
            .collect()
    }
}

/// The values of parameters that a model has.
fn known(model: &Model, values: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let mut values = values.clone();
    values.retain(|name, _| {
        model
            .check_names(&BTreeMap::from([(name.clone(), 0.0)]))
            .is_ok()
    });
    values
}

fn note(key: &str, text: &str, percent: f64) {
    Figure::lower(&format!("seven joints/{key}"), text, percent, "%").note();
}

fn exact(settings: &mut Simulate) {
    settings.link_encoder_counts_per_turn.clear();
    settings.motor_encoder_counts_per_turn.clear();
    settings.torque_noise_nm.clear();
}

#[test]
fn exact_positions_give_every_parameter_that_matters() {
    // A cut-off of 499 Hz at 1 kHz leaves the positions unfiltered.
    let arm = Arm::new(|e| e.identify.position_cutoff_hz = Cutoff::Fixed(499.0));
    let found = arm.identify(&arm.log(exact));
    let errors = arm.errors(&found.identification.results[0]);
    let worst = errors.iter().map(|e| e.error).fold(0.0, f64::max);
    println!(
        "{} parameters matter, worst error {worst:.3} %",
        errors.len()
    );
    note("exact", "exact positions: largest error", worst);
    assert!(errors.len() > 55 && worst < 0.5, "{worst}");
}

#[test]
fn encoders_and_noise_leave_most_of_it() {
    let arm = Arm::new(|_| ());
    let found = arm.identify(&arm.log(|_| ()));
    let result = &found.identification.results[0];
    let mut errors = arm.errors(result);
    errors.sort_by(|a, b| a.error.total_cmp(&b.error));
    let median = errors[errors.len() / 2].error;
    println!("median of {}: {median:.3} %", errors.len());
    note("median", "encoders and noise: median error", median);
    note(
        "largest",
        "encoders and noise: largest error",
        errors.last().unwrap().error,
    );
    assert!(median < 0.5, "{median}");
    for (joint, name) in arm.model.joints().iter().enumerate() {
        let stiffness = format!("{name}.stiffness");
        let error = errors.iter().find(|e| e.name == stiffness).unwrap().error;
        println!("{stiffness}: {error:.2} %");
        // The table of the page has the stiffness with the largest error.
        let text = match joint {
            6 => format!("encoders and noise: error of `{stiffness}`"),
            _ => String::new(),
        };
        note(&stiffness, &text, error);
        assert!(
            error < if joint == 6 { 4.0 } else { 1.0 },
            "{stiffness}: {error}"
        );
        // The offset of the link encoder has the opposite sign of the motor encoder's. It is found to one count of
        // 2^17, 4.8e-5 rad.
        let offset = &result.encoder_offsets[joint];
        let gap = offset.offset_rad + arm.offsets[joint];
        assert!(gap.abs() < 5e-5, "{name}: {:e}", offset.offset_rad);
    }
    // Each parameter that is wrong by more than 10 % is named as weak.
    let codes = ["weakly-excited", "little-torque"];
    let warnings = result
        .warnings
        .iter()
        .filter(|w| codes.contains(&w.code.as_str()));
    let weak: Vec<&String> = warnings.flat_map(|w| &w.parameters).collect();
    println!("{} parameters are named as weak", weak.len());
    for OffBy { name, share, error } in &errors {
        if *error > 10.0 {
            println!("{name}: {error:.0} % at a share of {share:.3}");
            assert!(weak.contains(&name), "{name}: {error}");
        }
    }
}

#[test]
fn refined_drives_are_as_sure_as_they_say() {
    let arm = Arm::new(|e| e.identify.estimator = vec![Estimator::PredictionError]);
    let found = arm.identify(&arm.log(|settings| settings.duration_s = 4.0));
    let result = &found.identification.results[0];
    let refinement = result.refinement.as_ref().unwrap();
    assert!(
        refinement.used && refinement.runs < 15,
        "{} runs",
        refinement.runs
    );
    let (mut squares, mut largest) = (0.0, 0.0_f64);
    for (parameter, truth) in result.parameters.iter().zip(&arm.truth) {
        let vital =
            parameter.name.ends_with("rotor_inertia") || parameter.name.ends_with("stiffness");
        if !vital {
            continue;
        }
        let away = (parameter.value.unwrap() - truth) / parameter.standard_error.unwrap();
        let error = 100.0 * (parameter.value.unwrap() / truth - 1.0);
        println!(
            "{}: {error:+.3} %, {away:+.1} standard errors",
            parameter.name
        );
        squares += away * away / 14.0;
        largest = error.abs().max(largest);
        assert!(away.abs() < 4.0, "{}: {away}", parameter.name);
    }
    let text = "prediction error, 4 s: largest error of rotor inertias and stiffnesses";
    note("refined", text, largest);
    assert!(squares.sqrt() < 1.6, "{}", squares.sqrt());
}

#[test]
fn an_offset_that_is_not_estimated_ruins_stiffnesses() {
    let arm = Arm::new(|e| e.identify.encoder_offset = Some(EncoderOffset::None));
    let found = arm.identify(&arm.log(|_| ()));
    let errors = arm.errors(&found.identification.results[0]);
    let stiffness = errors.iter().filter(|e| e.name.ends_with(".stiffness"));
    let worst = stiffness.map(|e| e.error).fold(0.0, f64::max);
    println!("worst stiffness without preload columns: {worst:.0} %");
    let text = "`encoder_offset = \"none\"`: largest error of a stiffness";
    Figure::neutral("seven joints/no offset", text, worst, "%").note();
    assert!(worst > 10.0, "{worst}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let arm = Arm::new(|e| e.identify.position_cutoff_hz = Cutoff::Fixed(40.0));
    let log = arm.log(|settings| settings.duration_s = 6.0);
    let bits = |threads: usize| -> Vec<u64> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let found = pool.install(|| arm.identify(&log));
        let result = &found.identification.results[0];
        (result.parameters.iter())
            .flat_map(|p| [p.value.unwrap(), p.standard_error.unwrap()])
            .map(f64::to_bits)
            .collect()
    };
    let one = bits(1);
    assert_eq!(one, bits(2));
    assert_eq!(one, bits(5));
}

/// Returns logs of 8 s: without payload, and with 2 kg at the last link.
fn empty_and_loaded(arm: &Arm) -> [Vec<u8>; 2] {
    let empty = arm.log(|settings| settings.duration_s = 8.0);
    let payload = two_kilograms().known().unwrap();
    let mut values: BTreeMap<String, f64> = toml::from_str(TRUTH).unwrap();
    for (name, value) in BODY_NAMES.iter().zip(payload) {
        *values.get_mut(&format!("link7.{name}")).unwrap() += value;
    }
    let loaded = arm.log_of(&values, |settings| {
        settings.duration_s = 8.0;
        settings.seed = 5;
    });
    [empty, loaded]
}

fn two_kilograms() -> Payload {
    Payload {
        mass_kg: Some(2.0),
        com_m: Some([0.02, -0.03, 0.08]),
        inertia_kg_m2: Some([0.0044, 0.0002, -0.0004, 0.0036, 0.0002, 0.003]),
        ..Payload::default()
    }
}

fn identify_both(arm: &Arm, logs: &[Vec<u8>; 2], payload: Payload) -> Identified {
    let opener = |log: &Vec<u8>| {
        let log = log.clone();
        move |_: Option<&Path>| Ok(Box::new(std::io::Cursor::new(log.clone())) as Box<dyn Input>)
    };
    let (mut empty, mut loaded) = (opener(&logs[0]), opener(&logs[1]));
    let mut logs = [
        LogSource::files("loaded", &mut loaded).carrying(Some(payload)),
        LogSource::files("empty", &mut empty),
    ];
    identify(&arm.experiment, &arm.model, &mut logs, &mut Unheard).unwrap()
}

#[test]
fn a_payload_follows_from_logs_without_and_with_it() {
    let arm = Arm::new(|_| ());
    let logs = empty_and_loaded(&arm);
    let found = identify_both(&arm, &logs, Payload::default());
    // The parameters of the robot come from the log without payload.
    let alone = arm.identify(&logs[0]);
    for (parameter, alone) in (found.identification.results[0].parameters.iter())
        .zip(&alone.identification.results[0].parameters)
    {
        assert_eq!(parameter.value, alone.value);
    }
    let [payload] = &found.identification.payloads[..] else {
        panic!("one payload");
    };
    assert_eq!(
        (payload.link.as_str(), &payload.logs[..]),
        ("link7", &["loaded".to_owned()][..])
    );
    for (parameter, truth) in (payload.parameters.iter()).zip(two_kilograms().known().unwrap()) {
        let (value, error) = (parameter.value.unwrap(), parameter.standard_error.unwrap());
        println!(
            "{}: {value:.4} ± {error:.4}, true {truth:.4}",
            parameter.name
        );
        assert!((value - truth).abs() < 4.0 * error, "{}", parameter.name);
    }
    let mass = &payload.parameters[0];
    assert!((mass.value.unwrap() / 2.0 - 1.0).abs() < 0.02 && mass.standard_error.unwrap() < 0.04);
    assert!(mass.physical.is_some_and(|value| value > 0.0));
}

#[test]
fn a_known_payload_does_not_change_the_robot() {
    let arm = Arm::new(|_| ());
    let logs = empty_and_loaded(&arm);
    let far = |found: &Identified| -> f64 {
        let result = &found.identification.results[0];
        let parameters = result
            .parameters
            .iter()
            .zip(&arm.truth)
            .zip(arm.model.parameters());
        let links = parameters.filter(|(_, parameter)| parameter.joint.is_none());
        links
            .map(|((parameter, truth), _)| (parameter.value.unwrap() - truth).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let known = far(&identify_both(&arm, &logs, two_kilograms()));
    let mut wrong = two_kilograms();
    wrong.mass_kg = Some(0.001);
    let ignored = far(&identify_both(&arm, &logs, wrong));
    println!("distance of the link parameters: {known:.4}, without the payload {ignored:.4}");
    assert!(known < 0.2 * ignored, "{known} {ignored}");
}

/// True standard parameters with errors like those of CAD: masses, centres of mass and radii.
fn wrong_cad(values: &BTreeMap<String, f64>, seed: u64) -> BTreeMap<String, f64> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1;
    let mut wrong = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        1.0 + 0.6 * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 1.732
    };
    let mut all = BTreeMap::new();
    for link in 1..=7 {
        let (mass, radius) = (wrong(), wrong());
        for name in BODY_NAMES {
            let name = format!("link{link}.{name}");
            let length = match name.rsplit('.').next().unwrap().len() {
                1 => 1.0,
                2 => radius,
                _ => radius * radius,
            };
            all.insert(
                name.clone(),
                mass * length * values.get(&name).copied().unwrap_or(0.0),
            );
        }
    }
    all
}

#[test]
fn possible_bodies_are_no_farther_from_the_truth() {
    let values: BTreeMap<String, f64> = toml::from_str(TRUTH).unwrap();
    let mut sums = [0.0; 2];
    for seed in 1..=2 {
        let arm = Arm::new(|e| e.robot.nominal = wrong_cad(&values, seed));
        let log = arm.log(|settings| {
            settings.duration_s = 6.0;
            settings.seed = seed;
            settings.torque_noise_nm = vec![2.0; 7];
        });
        let found = arm.identify(&log);
        let result = &found.identification.results[0];
        let mut squares = [0.0; 3];
        for ((p, truth), parameter) in result
            .parameters
            .iter()
            .zip(&arm.truth)
            .zip(arm.model.parameters())
        {
            if parameter.joint.is_none() {
                squares[0] += (p.unconstrained.unwrap() - truth).powi(2);
                squares[1] += (p.value.unwrap() - truth).powi(2);
                squares[2] += truth.powi(2);
            }
        }
        let errors = [0, 1].map(|i| 100.0 * (squares[i] / squares[2]).sqrt());
        println!("{seed}: {errors:?} {:?}", result.physical);
        for i in 0..2 {
            sums[i] += errors[i] / 2.0;
        }
    }
    println!("{sums:?}");
    assert!(sums[1] <= sums[0], "{sums:?}");
}

#[test]
fn constrained_least_squares_gives_a_robot_that_can_exist() {
    let arm = Arm::new(|experiment| {
        experiment.robot.nominal.clear();
        experiment.identify.constraints = Constraints::Possible;
    });
    let log = Arm::new(|_| ()).log(|settings| {
        settings.duration_s = 6.0;
        settings.torque_noise_nm = vec![2.0; 7];
    });
    let found = arm.identify(&log);
    let result = &found.identification.results[0];
    let of = |value: &dyn Fn(&ParameterEstimate) -> Option<f64>| -> Vec<f64> {
        result
            .parameters
            .iter()
            .map(|p| value(p).unwrap())
            .collect()
    };
    let (value, before) = (of(&|p| p.value), of(&|p| p.unconstrained));
    let errors: Vec<f64> = (result.parameters.iter())
        .map(|p| p.standard_error.unwrap_or(f64::INFINITY))
        .collect();
    let far = |theta: &[f64]| arm.model.distance_from_bodies(theta, &errors).unwrap();
    let distances = [far(&before), far(&value)];
    println!("standard errors from possible bodies: {distances:?}");
    // The search for the distance ends at half a standard error.
    assert!(distances[0] > 1.0 && distances[1] < 0.5, "{distances:?}");
    arm.model.check_inertias(&value).unwrap();
    for (value, parameter) in value.iter().zip(arm.model.parameters()) {
        let is_friction = parameter.is_friction();
        assert!(!is_friction || *value >= 0.0, "{}", parameter.name);
    }
    let error = |theta: &[f64]| -> f64 {
        let of_links = (theta.iter().zip(&arm.truth).zip(arm.model.parameters()))
            .filter(|(_, parameter)| parameter.joint.is_none());
        of_links
            .map(|((value, truth), _)| (value - truth).powi(2))
            .sum()
    };
    let ratio = (error(&value) / error(&before)).sqrt();
    println!("error of the links over that without constraints: {ratio:.3}");
    assert!(ratio < 1.0, "{ratio}");
}

#[test]
fn standard_parameters_make_the_base_parameters() {
    let arm = Arm::new(|_| ());
    let found = arm.identify(&arm.log(|settings| settings.duration_s = 6.0));
    let result = &found.identification.results[0];
    let standard = &result.standard_parameters;
    assert_eq!(standard.len(), 77);
    let mut values: BTreeMap<String, f64> = (standard.iter())
        .map(|p| (p.name.clone(), p.value))
        .collect();
    for (p, parameter) in result.parameters.iter().zip(arm.model.parameters()) {
        if parameter.joint.is_some() {
            values.insert(p.name.clone(), p.value.unwrap());
        }
    }
    let theta = arm.model.theta(&values).unwrap();
    for (p, value) in result.parameters.iter().zip(theta) {
        let found = p.value.unwrap();
        assert!(
            (value - found).abs() < 1e-9 * (1.0 + found.abs()),
            "{}",
            p.name
        );
    }
    // The first link turns about a fixed vertical axis, so only its izz has an effect.
    let of = |name: &str| standard.iter().find(|p| p.name == name).unwrap();
    assert_eq!(of("link1.ixx").decided, Decided::Nominal);
    assert_eq!(of("link2.ixx").decided, Decided::Both);
    assert_eq!(of("link7.mx").decided, Decided::Log);
}
