//! Writes C code of a twin with an observer, a state feedback, a shaper and the friction of its feedforward, for the
//! check of code on microcontrollers (`cargo xtask test outside arm`).
//!
//! Arguments: the experiment file, the true parameters, and the folder of the code.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use sprung_core::shaper::Tap;
use sprung_export::{ControlCode, Form, Format, ObserverCode, Origin, Request, export};
use sprung_method::watch::{ObservedJoint, ObserverSettings};
use sprung_model::Model;
use sprung_robot::{Controller, ControllerKind, Feedforward, Reference, no_files, read};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [experiment, truth, out] = arguments.as_slice() else {
        return Err("give the experiment file, the true parameters and a folder".into());
    };
    let text = std::fs::read_to_string(experiment)?;
    let mut values = BTreeMap::new();
    for line in std::fs::read_to_string(truth)?.lines() {
        if let Some((name, value)) = line.split_once('=') {
            let name = name.trim().trim_matches('"').to_owned();
            values.insert(name, value.trim().parse::<f64>()?);
        }
    }
    let experiment = read("experiment.toml", &text, &[], &mut no_files)?;
    let model = Model::new(&experiment)?;
    let exported = export(&Request {
        format: Format::C,
        form: Form::Flexible,
        experiment: &experiment,
        model: &model.shaped(&values),
        values: &values,
        urdf: None,
        is_there: &|_| false,
        evidence: &[],
        origin: Origin {
            experiment: "experiment.toml".to_owned(),
            parameters: "truth.toml".to_owned(),
            estimator: None,
            verdict: None,
            draw: None,
            logs: Vec::new(),
            values: Vec::new(),
        },
        control: Some(control(model.joint_count())),
        observer: Some(observer(model.joint_count())),
    })?;
    std::fs::create_dir_all(out)?;
    for (file, text) in Format::C.files().iter().zip(exported.texts) {
        std::fs::write(Path::new(out).join(file), text)?;
    }
    Ok(())
}

/// An observer that settles within the states of the check.
fn observer(n: usize) -> ObserverCode {
    let joint = ObservedJoint {
        motor_share: 0.5,
        variance: [1.0, 0.1, 0.01, 1e-4, 0.5],
        zero_nm: 0.2,
        threshold_sigma: 5.0,
    };
    ObserverCode {
        settings: ObserverSettings {
            period_s: 1e-3,
            cutoff_rad_per_s: 200.0,
            bandwidth_rad_per_s: 800.0,
            joints: vec![joint; n],
        },
        header: Vec::new(),
    }
}

fn control(n: usize) -> ControlCode {
    let gain = |i: usize, k: usize| 5.0 * ((3 * i + k) as f64).sin();
    ControlCode {
        controller: Controller {
            kind: ControllerKind::StateFeedback,
            kp_nm_per_rad: Vec::new(),
            kd_nms_per_rad: Vec::new(),
            gain: (0..n)
                .map(|i| (0..4 * n).map(|k| gain(i, k)).collect())
                .collect(),
            feedforward: Feedforward::Identified,
            friction_compensation_speed_rad_per_s: Some(0.05),
            velocity_window: [4, 4],
            shaper: Vec::new(),
            reference: Reference::default(),
        },
        period_s: 1e-3,
        torque_limits: vec![10_000.0; n],
        taps: [(0, 0.5), (15, 0.3), (30, 0.2)]
            .map(|(delay, weight)| Tap { delay, weight })
            .to_vec(),
        header: Vec::new(),
    }
}
