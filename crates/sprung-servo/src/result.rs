//! The contents of `servo.json` and `parameters.csv`.

use schemars::JsonSchema;
use serde::Serialize;

use crate::finding::{Finding, Severity};

/// Source of the scale of all torques.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// A load of known mass or inertia.
    KnownLoad,
    /// The torque per volt or ampere, which the experiment gives.
    Given,
    /// Nothing: only ratios of torques follow from the log.
    None,
}

/// A log of a servo.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ServoLog {
    /// Name, with its window.
    pub log: String,
    /// Number of samples that were used.
    pub samples: usize,
    /// Duration of these samples, s.
    pub duration_s: f64,
    /// Inertia of the known load about the axis, kg·m².
    pub load_inertia_kgm2: f64,
    /// Largest torque of gravity on the known load, N·m.
    pub load_torque_nm: f64,
}

/// One parameter of a servo.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ServoEstimate {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Estimate, or the given value.
    pub value: f64,
    /// Standard error; absent if the value is given.
    pub standard_error: Option<f64>,
    /// 95 % confidence interval.
    pub ci95: Option<[f64; 2]>,
    /// Whether the experiment gives the value.
    pub fixed: bool,
}

/// Distance of the simulated from the logged positions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "ServoErrors")]
pub struct ServoFit {
    /// Root mean square over the windows that the model follows, rad.
    pub position_rms_rad: f64,
    /// The same relative to the noise of the sensor.
    pub position_rms_over_noise: f64,
    /// Part of the windows that the model does not follow.
    pub windows_not_followed: f64,
}

/// Complete result of a servo; format 1.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ServoIdentification {
    /// Version of the file format; 1.
    pub format: u32,
    /// Program and version that wrote the file.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// Name of the joint.
    pub joint: String,
    /// The logs.
    pub logs: Vec<ServoLog>,
    /// Source of the scale of all torques.
    pub scale: Scale,
    /// The parameters.
    pub parameters: Vec<ServoEstimate>,
    /// Viscous friction and back-EMF together: the torque per velocity that brakes the output while
    /// the drive is on.
    pub braking: ServoEstimate,
    /// Distance of the simulation from the logs.
    pub fit: ServoFit,
    /// Findings.
    pub findings: Vec<Finding>,
    /// Computing time, s.
    pub elapsed_s: f64,
}

/// A parameter before the fit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ServoExpectation {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// First value.
    pub first: f64,
    /// Smallest standard error that the logs allow about the first values; absent if the value is
    /// given or the logs do not determine it.
    pub least_error: Option<f64>,
    /// Whether the experiment gives the value.
    pub fixed: bool,
}

impl ServoIdentification {
    /// Returns a parameter by its name without that of the joint.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&ServoEstimate> {
        let name = format!("{}.{name}", self.joint);
        (self.parameters.iter()).find(|parameter| parameter.name == name)
    }

    /// Returns whether no finding is serious.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        (self.findings.iter()).all(|finding| finding.severity < Severity::Serious)
    }
}

/// Returns the table of parameters as CSV, one row per parameter.
#[must_use]
pub fn servo_parameters_csv(found: &ServoIdentification) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let cell = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    let header = [
        "name",
        "unit",
        "value",
        "standard_error",
        "ci95_low",
        "ci95_high",
        "fixed",
    ];
    // A write to a vector does not fail.
    let _ = writer.write_record(header);
    for parameter in found.parameters.iter().chain([&found.braking]) {
        let _ = writer.write_record([
            &parameter.name,
            &parameter.unit,
            &parameter.value.to_string(),
            &cell(parameter.standard_error),
            &cell(parameter.ci95.map(|c| c[0])),
            &cell(parameter.ci95.map(|c| c[1])),
            &parameter.fixed.to_string(),
        ]);
    }
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}
