//! The contents of `identification.json` and `parameters.csv`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::about_logs::LogInfo;
use super::verdict::Verdict;
use crate::finding::{Finding, Severity};
use crate::model::stribeck_name;
use crate::named::Named;

pub(crate) use crate::finding::GENERATOR;

/// Everything that an identification found; format 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// Version of the file format; 1.
    pub format: u32,
    /// Program and version that wrote it.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// The log, or the first of several.
    pub log: LogInfo,
    /// Further logs, in their order; in curves each follows the one before.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further_logs: Vec<LogInfo>,
    /// The settings that were used.
    pub settings: SettingsUsed,
    /// What was noticed about the log.
    pub findings: Vec<Finding>,
    /// One result per estimator.
    pub results: Vec<EstimateResult>,
}

impl Identification {
    /// Returns the logs, in their order.
    pub fn logs(&self) -> impl Iterator<Item = &LogInfo> {
        std::iter::once(&self.log).chain(&self.further_logs)
    }

    /// Returns the names of the logs in words.
    #[must_use]
    pub fn files(&self) -> String {
        let files: Vec<&str> = self.logs().map(|log| log.file.as_str()).collect();
        files.join(", ")
    }

    /// Returns what decided the verdict of a result, in words: the codes of the
    /// serious findings about it and about the log, or those of the warnings if none
    /// is serious, with their number where there are several of one.
    #[must_use]
    pub fn reasons(&self, result: &EstimateResult) -> String {
        let findings = || self.findings.iter().chain(&result.warnings);
        let Some(worst) = findings().map(|finding| finding.severity).max() else {
            return "no findings".to_owned();
        };
        if worst == Severity::Info {
            return "no warnings".to_owned();
        }
        let mut codes: Vec<(&str, usize)> = Vec::new();
        for finding in findings().filter(|finding| finding.severity == worst) {
            match codes.iter_mut().find(|(code, _)| *code == finding.code) {
                Some((_, count)) => *count += 1,
                None => codes.push((&finding.code, 1)),
            }
        }
        let words = codes.iter().map(|(code, count)| match count {
            1 => (*code).to_owned(),
            _ => format!("{code} ({count})"),
        });
        words.collect::<Vec<_>>().join(", ")
    }
}

/// Settings of an identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SettingsUsed {
    /// λ of the filter pair.
    pub filter_cutoff_rad_per_s: f64,
    /// How the filter pair is made discrete.
    pub discretization: String,
    /// Weights of the samples.
    #[serde(default)]
    pub weights: String,
    /// Cut-off of the zero-phase filter.
    pub position_cutoff_hz: f64,
    /// How that was chosen, if it was.
    #[serde(default)]
    pub position_cutoff_choice: Option<CutoffChoice>,
    /// Order of the zero-phase filter.
    pub position_filter_order: usize,
}

/// A cut-off that was chosen from the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CutoffChoice {
    /// Why this one.
    pub reason: String,
    /// What other cut-offs give, from the beginning of the log.
    pub sweep: Vec<CutoffPoint>,
}

/// Estimates at one cut-off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CutoffPoint {
    /// Cut-off, Hz.
    pub cutoff_hz: f64,
    /// Values, in the order of theta.
    pub values: Vec<f64>,
}

/// Constant difference of the two encoders of a joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EncoderOffsetResult {
    /// Name of the joint.
    pub joint: String,
    /// What the link's reads too much against the motor's, rad (m).
    pub offset_rad: f64,
    /// Its standard error, rad (m).
    pub standard_error_rad: Option<f64>,
}

/// One inertial parameter of a single link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StandardParameter {
    /// Name, as in `link1.izz`.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value: the nominal one, changed as little as the estimate asks for.
    pub value: f64,
    /// Nominal value.
    pub nominal: Option<f64>,
    /// What the log says of it.
    pub determined: Determined,
}

/// What a log says of a standard parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Determined {
    /// Its value.
    Alone,
    /// Only a combination with others.
    InCombination,
    /// Nothing: no motion shows it.
    Not,
    /// It was given.
    Known,
}

/// What one estimator found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EstimateResult {
    /// Name of the estimator.
    pub estimator: String,
    /// How far to trust it.
    pub verdict: Verdict,
    /// Numerical rank of the stacked regressor.
    pub rank: usize,
    /// Number of parameters that were not known before.
    #[serde(default)]
    pub unknowns: usize,
    /// Condition number of the stacked regressor; absent if infinite.
    pub condition_number: Option<f64>,
    /// The same after scaling columns to unit length.
    pub condition_number_scaled: Option<f64>,
    /// The parameters, in the order of theta.
    pub parameters: Vec<ParameterEstimate>,
    /// Constant differences of the encoders, if they were estimated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub encoder_offsets: Vec<EncoderOffsetResult>,
    /// Velocities at which Stribeck friction has fallen to 1/e, rad/s (m/s), by
    /// joint.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub stribeck_velocity: Named,
    /// Inertial parameters of single links, as near to the nominal ones as the
    /// estimate allows; trees only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub standard_parameters: Vec<StandardParameter>,
    /// What the motor rows say by themselves; least squares only.
    #[serde(default)]
    pub motor_rows: Vec<MotorRowResult>,
    /// How the simulated loop fits; output error only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulation: Option<SimulationFit>,
    /// How the filter fits; the prediction error only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refinement: Option<Refinement>,
    /// The parameters by other routes; least squares and prediction error only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cross_checks: Vec<CrossCheckResult>,
    /// Residual of each row, root mean square, N·m.
    pub residual_rms: Named,
    /// Residual over torque of each motor row.
    pub relative_residual: Named,
    /// What the resolution of the positions leaves of each torque through Coulomb
    /// transitions, likewise; absent without weights.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub resolution_share: Named,
    /// What to know before using the numbers.
    pub warnings: Vec<Finding>,
    /// Time that the estimate took, s.
    pub elapsed_s: f64,
}

/// How a simulated closed loop fits the positions of a log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimulationFit {
    /// Samples that were simulated, from the beginning of the first log.
    pub samples: u64,
    /// Squared error of a position over the variance of its sensor, mean over
    /// all; about 1 where the loop is exactly known.
    pub cost_per_sample: f64,
    /// Iterations of the search.
    pub iterations: usize,
    /// Root mean square error over the noise of the sensor, by column.
    pub position_rms_over_noise: Named,
    /// What each position reads too much, rad (m), by column.
    pub offset_rad: Named,
    /// Difference of the controller's torque from the logged one beyond white
    /// noise, over the torque, by joint.
    pub torque_mismatch: Named,
}

/// What a prediction-error refinement says besides the parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refinement {
    /// Whether the values are those of the refinement; if not, they are those of least
    /// squares, and a finding says why.
    #[serde(default)]
    pub used: bool,
    /// Whether the search ended by itself.
    pub converged: bool,
    /// Runs of the filter.
    pub runs: usize,
    /// Samples that were used.
    pub samples: usize,
    /// Time that they span, s.
    pub duration_s: f64,
    /// Measurements of positions that were used: of a counter, its edges.
    pub measurements: u64,
    /// Minus the logarithm of the likelihood, without its constant.
    pub minus_log_likelihood: f64,
    /// Noise and disturbances, by row of the regressor.
    pub disturbances: Vec<RowDisturbance>,
    /// Corner of the disturbances' spectrum, Hz.
    pub disturbance_corner_hz: f64,
    /// Whitened innovations squared, mean; well below 1 for counters, whose edges
    /// lie within their bounds, and above 2 where the model does not follow.
    #[serde(default)]
    pub cost_per_measurement: f64,
    /// How well it predicts what it has not seen.
    #[serde(default)]
    pub held_out_residual: Option<HeldOutResidual>,
    /// Noise of sensors beyond what their samples show, where it was looked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensor_noise: Vec<SensorNoise>,
    /// Constants that sensors read too much.
    pub encoder_offsets: Vec<RefinedOffset>,
    /// What the likelihood says of delays.
    pub delays: Vec<RefinedDelay>,
    /// Pairs of parameters whose errors are most alike, with their correlation.
    pub correlations: Vec<(String, String, f64)>,
    /// What each of several logs says alone: value and standard error, in the
    /// order of `parameters`; nothing for one that was not refined.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub each_log: Vec<Vec<Option<(f64, f64)>>>,
}

/// What estimates from the first three quarters of the logs leave of the filtered
/// torque of the last, as a part of it, root mean square over the rows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOutResidual {
    /// Of the refinement.
    pub refined: f64,
    /// Of least squares.
    pub linear: f64,
}

/// Noise and disturbance of a row of the regressor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RowDisturbance {
    /// Name of the row, as in `joint1.motor_nm`.
    pub row: String,
    /// White noise of the torque, standard deviation, N·m (N).
    pub torque_noise_nm: f64,
    /// Disturbance, standard deviation, N·m (N).
    pub disturbance_nm: f64,
    /// Standard deviation of the joint's motor torque, N·m (N).
    pub torque_nm: f64,
    /// Whether a level ended at its upper bound.
    pub at_bound: bool,
}

/// Noise of a sensor of positions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorNoise {
    /// The column.
    pub column: String,
    /// Standard deviation of white noise, rad (m).
    pub noise_rad: f64,
    /// Standard deviation of what it shows, rad (m).
    pub deviation_rad: f64,
}

/// What a sensor of positions reads too much.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RefinedOffset {
    /// Name of the joint.
    pub joint: String,
    /// The column.
    pub column: String,
    /// Value, rad (m).
    pub offset_rad: f64,
    /// Its standard error, rad (m).
    pub standard_error_rad: f64,
}

/// What the likelihood says of the delay of a column against the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RefinedDelay {
    /// The column.
    pub column: String,
    /// How much later than its event it was recorded, s.
    pub delay_s: f64,
    /// Its standard error, s; absent if the log says nothing.
    pub standard_error_s: Option<f64>,
    /// Part of it that the values of the parameters take into account, s.
    pub used_s: f64,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterEstimate {
    /// Name.
    pub name: String,
    /// The paper's symbol.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Estimate; absent if the data do not determine it.
    pub value: Option<f64>,
    /// Standard error.
    pub standard_error: Option<f64>,
    /// 95 % confidence interval.
    pub ci95: Option<[f64; 2]>,
    /// Value that the maker gives.
    pub nominal: Option<f64>,
    /// Whether the data determine it.
    pub identifiable: bool,
    /// Whether it was given.
    #[serde(default)]
    pub fixed: bool,
    /// Torque that it stands for in the log, root mean square of its column
    /// times its value, in the row where that is most, N·m.
    #[serde(default)]
    pub torque_rms_nm: Option<f64>,
    /// The same over the largest of that row.
    #[serde(default)]
    pub torque_share: Option<f64>,
    /// The same over what the model leaves unexplained of a row, in the row
    /// where that is most.
    #[serde(default)]
    pub torque_over_residual: Option<f64>,
}

/// A motor row fitted alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotorRowResult {
    /// Name of the joint.
    pub joint: String,
    /// Its parameters.
    pub parameters: Vec<ParameterEstimate>,
    /// Condition number; absent if infinite.
    pub condition_number: Option<f64>,
    /// Residual over torque; absent if there was no torque.
    pub relative_residual: Option<f64>,
    /// Square of the spring torque that only the spring explains over that of
    /// the residual; absent if the stiffness was given.
    #[serde(default)]
    pub scale_number: Option<f64>,
    /// Standard error of what the stacked stiffness has more, N·m/rad (N/m).
    #[serde(default)]
    pub stiffness_difference_standard_error: Option<f64>,
}

/// The parameters by another route.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrossCheckResult {
    /// `two-stage`, `scale-invariant` or `instrumental-variables`.
    pub method: String,
    /// Values by name.
    pub values: Named,
}

impl EstimateResult {
    /// Returns the refinement that made the values, if one did.
    #[must_use]
    pub fn refined(&self) -> Option<&Refinement> {
        self.refinement
            .as_ref()
            .filter(|refinement| refinement.used)
    }

    /// Returns the values by name, without those that are not determined.
    #[must_use]
    pub fn values(&self) -> BTreeMap<String, f64> {
        let shapes = self.stribeck_velocity.iter();
        (self.parameters.iter())
            .filter_map(|p| Some((p.name.clone(), p.value?)))
            .chain(shapes.map(|(joint, velocity)| (stribeck_name(joint), velocity)))
            .collect()
    }

    /// Returns a parameter by name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&ParameterEstimate> {
        self.parameters.iter().find(|p| p.name == name)
    }
}

/// Returns the table of parameters as CSV, one row per parameter and
/// estimator.
#[must_use]
pub fn parameters_csv(identification: &Identification) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut write = |row: &[&str]| {
        // A vector takes every write.
        let _ = writer.write_record(row);
    };
    write(&[
        "estimator",
        "name",
        "symbol",
        "unit",
        "value",
        "standard_error",
        "ci95_low",
        "ci95_high",
        "nominal",
        "identifiable",
        "torque_rms_nm",
    ]);
    let cell = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
    for result in &identification.results {
        for p in &result.parameters {
            write(&[
                &result.estimator,
                &p.name,
                &p.symbol,
                &p.unit,
                &cell(p.value),
                &cell(p.standard_error),
                &cell(p.ci95.map(|c| c[0])),
                &cell(p.ci95.map(|c| c[1])),
                &cell(p.nominal),
                &p.identifiable.to_string(),
                &cell(p.torque_rms_nm),
            ]);
        }
    }
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}
