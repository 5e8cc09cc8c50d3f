//! Frequency responses of twins with known parameters.

use std::fmt::Write;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sprung_testing::{largest_of_normals, least_inside};

use super::compare::{Identified, frequency_response};
use super::findings::resonances_disagree;
use super::record::Record;
use super::result::{Feature, FrequencyResponse};
use crate::description::{self, no_files};
use crate::model::{Model, Theta};
use crate::preprocess::RawBlock;
use crate::regression::Observer;
use crate::simulate::{Twin, TwinSetup};

const ROBOT: &str = r#"
[robot]
kinematics = "planar-2r"
[[robot.joint]]
name = "joint1"
motor_friction = ["viscous"]
link_friction = ["viscous"]
[[robot.joint]]
name = "joint2"
motor_friction = ["viscous"]
link_friction = ["viscous"]
[controller]
kind = "pd"
kp_nm_per_rad = [50.0, 5.0]
kd_nms_per_rad = [0.5, 0.05]
[simulate]
period_s = 0.001
link_encoder_counts_per_turn = [16384, 16384]
motor_encoder_counts_per_turn = [16384, 16384]
torque_noise_nm = [0.02, 0.005]
"#;

const TRUTH: &str = r#"
"link1.inertia_total" = 0.207184
"link2.coupling" = 0.017580
"link2.inertia" = 0.013163
"joint1.rotor_inertia" = 0.216776
"joint2.rotor_inertia" = 0.006842
"joint1.link_viscous" = 0.037675
"joint2.link_viscous" = 0.002959
"joint1.motor_viscous" = 0.2
"joint2.motor_viscous" = 0.02
"joint1.stiffness" = 9.358730
"joint2.stiffness" = 4.212811
"#;

/// A multisine of one minute: all multiples of a frequency, with random phases.
struct Multisine {
    duration: f64,
    /// Spacing of the sines, Hz.
    spacing: f64,
    highest_hz: f64,
    amplitude_deg: f64,
}

impl Multisine {
    fn sines(&self, seed: u64) -> String {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut text = String::from("format = 1\n[controller.reference]\nsines = [\n");
        for joint in ["joint1", "joint2"] {
            let count = (self.highest_hz / self.spacing) as u32;
            for k in 1..=count {
                let hz = self.spacing * f64::from(k);
                let phase = rng.random_range(0.0..360.0);
                let amplitude = self.amplitude_deg;
                let _ = writeln!(
                    text,
                    "{{ joint = \"{joint}\", amplitude_deg = {amplitude}, frequency_hz = {hz}, phase_deg = {phase} }},"
                );
            }
        }
        text + "]\n"
    }
}

/// A robot, its true parameters and a log.
struct Recorded {
    model: Model,
    theta: Theta,
    record: Record,
}

fn twin(multisine: &Multisine, seed: u64) -> Recorded {
    let sines = multisine.sines(seed);
    let (head, reference) = sines.split_once('\n').unwrap();
    let simulate = ROBOT.find("[simulate]").unwrap();
    let text = format!(
        "{head}\n{}{reference}{}",
        &ROBOT[..simulate],
        &ROBOT[simulate..]
    );
    let experiment = description::read("experiment.toml", &text, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    let theta = model.theta(&toml::from_str(TRUTH).unwrap()).unwrap();
    let mut settings = experiment.simulate.clone().unwrap();
    settings.seed = seed;
    let mut twin = Twin::new(&TwinSetup {
        model: &model,
        theta: &theta,
        controller: experiment.controller.as_ref().unwrap(),
        settings: &settings,
    })
    .unwrap();
    let mut record = Record::new(2);
    let mut block = RawBlock::new(2);
    for _ in 0..(multisine.duration / settings.period_s) as usize {
        let sample = twin.sample().unwrap();
        block.time.push(sample.time);
        for joint in 0..2 {
            block.q[joint].push(sample.q[joint]);
            block.phi[joint].push(sample.phi[joint]);
            block.tau[joint].push(sample.tau[joint]);
        }
    }
    record.raw(settings.period_s, &block);
    Recorded {
        model,
        theta,
        record,
    }
}

fn response(model: &Model, theta: &[f64], record: &Record) -> FrequencyResponse {
    let moves = vec![Vec::new(); theta.len()];
    let identified = Identified {
        model,
        theta,
        moves: &moves,
    };
    frequency_response(record, &identified).unwrap()
}

/// Returns the features of both joints, by logs of one minute with different seeds.
fn features(multisine: &Multisine, seeds: u64) -> Vec<(FrequencyResponse, Vec<Feature>)> {
    (0..seeds)
        .into_par_iter()
        .map(|seed| {
            let Recorded {
                model,
                theta,
                record,
            } = twin(multisine, seed);
            let found = response(&model, &theta, &record);
            let joints = found.joints.iter();
            let features = joints.flat_map(|joint| joint.features.clone()).collect();
            (found, features)
        })
        .collect()
}

/// Error of a frequency by the log against the model of the true parameters: relative, and in standard
/// errors.
fn errors(feature: &Feature) -> Option<(f64, f64)> {
    let (hz, error) = feature.log_hz.zip(feature.log_standard_error_hz)?;
    let off = hz - feature.model_hz;
    Some((off / feature.model_hz, off / error))
}

#[test]
fn a_minute_of_multisine_gives_vibrations_within_half_a_percent_and_intervals_that_hold() {
    let multisine = Multisine {
        duration: 60.0,
        spacing: 1.0 / 60.0,
        highest_hz: 8.0,
        amplitude_deg: 0.05,
    };
    let errors: Vec<(f64, f64)> = (features(&multisine, 4).iter())
        .flat_map(|(_, features)| features.iter().map(|feature| errors(feature).unwrap()))
        .collect();
    assert_eq!(errors.len(), 16);
    let worst = errors.iter().map(|(off, _)| off.abs()).fold(0.0, f64::max);
    // The promise.
    assert!(worst < 5e-3, "{worst}");
    let inside = errors.iter().filter(|(_, z)| z.abs() < 1.96).count();
    assert!(inside >= least_inside(16, 0.95), "{inside} of 16");
    let farthest = errors.iter().map(|(_, z)| z.abs()).fold(0.0, f64::max);
    assert!(farthest < largest_of_normals(16), "{farthest}");
}

#[test]
fn periods_of_a_multisine_are_averaged() {
    let multisine = Multisine {
        duration: 60.0,
        spacing: 0.05,
        highest_hz: 8.0,
        amplitude_deg: 0.05,
    };
    let all = features(&multisine, 4);
    let mut inside = 0;
    let mut count = 0;
    for (response, features) in &all {
        // The first of three periods contains the start from rest.
        assert_eq!(response.periods, Some(2));
        assert!((response.duration_s - 40.0).abs() < 1e-9);
        // Harmonics are 0.05 Hz apart: too few for the lowest vibration.
        assert_eq!(features[0].log_hz, None);
        for (off, z) in features.iter().filter_map(errors) {
            assert!(off.abs() < 6e-3, "{off}");
            inside += usize::from(z.abs() < 1.96);
            count += 1;
        }
    }
    assert!(count >= 10 && inside + 2 >= count, "{inside} of {count}");
}

#[test]
fn a_wrong_stiffness_is_found_and_the_true_one_is_not() {
    let multisine = Multisine {
        duration: 60.0,
        spacing: 1.0 / 60.0,
        highest_hz: 8.0,
        amplitude_deg: 0.05,
    };
    let Recorded {
        model,
        mut theta,
        record,
    } = twin(&multisine, 1);
    assert_eq!(
        resonances_disagree(&response(&model, &theta, &record), "log"),
        None
    );
    theta[model.index_of("joint2.stiffness").unwrap()] *= 1.5;
    let finding = resonances_disagree(&response(&model, &theta, &record), "log").unwrap();
    assert_eq!(finding.code, "resonance-disagrees");
    assert!(finding.parameters.contains(&"joint2.stiffness".to_owned()));
}

#[test]
fn a_slow_motion_shows_no_vibration() {
    let multisine = Multisine {
        duration: 60.0,
        spacing: 0.1,
        highest_hz: 0.4,
        amplitude_deg: 3.0,
    };
    let Recorded {
        model,
        theta,
        record,
    } = twin(&multisine, 1);
    let identified = Identified {
        model: &model,
        theta: &theta,
        moves: &vec![Vec::new(); theta.len()],
    };
    let found = frequency_response(&record, &identified);
    let joints = found.iter().flat_map(|found| &found.joints);
    let mut features = joints.flat_map(|joint| &joint.features);
    assert!(
        features.all(|feature| feature.log_hz.is_none()),
        "{found:?}"
    );
}
