//! The contents of `identification.json` and `parameters.csv`.

use crate::description::Constraints;
use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::applied::Applied;
use super::log_info::LogInfo;
use super::payload::PayloadResult;
use super::physical::{CovarianceOfErrors, PhysicalResult, StandardParameter};
use super::promise::JointPrediction;
use super::refinement::Refinement;
use super::springs::{RigidJoint, SensedSpring};
use super::verdict::{Decision, Verdict};
use crate::finding::Finding;
use crate::frequency::SpringFromMotor;
use crate::model::{
    hysteresis_name, play_centre_name, play_name, presliding_name, sharpness_name, stribeck_name,
};
use crate::named::Named;
use crate::unknowns::UnknownResult;

pub(crate) use crate::finding::GENERATOR;

/// Complete result of an identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Identification {
    /// Version of the file format, [`IDENTIFICATION_FORMAT`].
    pub format: u32,
    /// Program and version that wrote the file.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// The only log, or the first of several.
    pub log: LogInfo,
    /// Further logs in their order. In curves each log follows the previous one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub further_logs: Vec<LogInfo>,
    /// The settings that were used.
    pub settings: SettingsUsed,
    /// Changes beyond the description that the log requires and that all results use.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub applied: Vec<Applied>,
    /// Springs of rigid joints by the vibrations of their motors; empty unless
    /// `identify.springs_from_motor` requests them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub springs_from_motor: Vec<SpringFromMotor>,
    /// Springs by deflections and joint torques; empty if the log has motor torques.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensed_springs: Vec<SensedSpring>,
    /// Joints whose spring the logs do not determine; they are taken as rigid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid_joints: Vec<RigidJoint>,
    /// What differs from the description by a size that the log shows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unknowns: Vec<UnknownResult>,
    /// Payloads that some logs carried.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub payloads: Vec<PayloadResult>,
    /// Findings about the logs.
    pub findings: Vec<Finding>,
    /// One result per estimator.
    pub results: Vec<EstimateResult>,
}

impl Identification {
    /// Returns the logs, in their order.
    pub fn logs(&self) -> impl Iterator<Item = &LogInfo> {
        std::iter::once(&self.log).chain(&self.further_logs)
    }

    /// Returns the bound of a stiffness that the logs do not determine, in the form of tables; `None` for other
    /// parameters.
    ///
    /// - `parameter`: its name.
    #[must_use]
    pub fn bound(&self, parameter: &str) -> Option<String> {
        let mut rigid = self.rigid_joints.iter();
        Some(rigid.find(|joint| joint.stiffness() == parameter)?.bound())
    }

    /// Returns the time of the first sample of the earliest log, s since 1970; `None` if the times of a log are not
    /// dates.
    #[must_use]
    pub fn date_s(&self) -> Option<f64> {
        let dates: Option<Vec<f64>> = self.logs().map(|log| log.date_s).collect();
        dates?.into_iter().reduce(f64::min)
    }

    /// Returns the file names of the logs with their windows, separated by commas.
    #[must_use]
    pub fn files(&self) -> String {
        let files: Vec<String> = self.logs().map(LogInfo::name).collect();
        files.join(", ")
    }
}

/// Settings of an identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SettingsUsed {
    /// λ of the filter pair, rad/s.
    pub filter_cutoff_rad_per_s: f64,
    /// Discretisation of the filter pair.
    pub discretization: String,
    /// Kind of sample weights.
    #[serde(default)]
    pub weights: String,
    /// Robots among which least squares and the refinement searched: `possible` or `none`. Results of format 1 do not
    /// contain it; theirs are `none`.
    #[serde(default = "unconstrained")]
    pub constraints: String,
    /// Cut-off of the zero-phase filter, Hz.
    pub position_cutoff_hz: f64,
    /// Reason and sweep of the cut-off, if it was chosen from the data.
    #[serde(default)]
    pub position_cutoff_choice: Option<CutoffChoice>,
    /// Order of the zero-phase filter.
    pub position_filter_order: usize,
}

fn unconstrained() -> String {
    Constraints::None.name().to_owned()
}

impl SettingsUsed {
    /// Returns whether two identifications used the same settings. Estimates with other cut-offs do
    /// not count.
    pub(crate) fn agree(&self, other: &Self) -> bool {
        let without = |settings: &Self| Self {
            position_cutoff_choice: None,
            ..settings.clone()
        };
        without(self) == without(other)
    }
}

/// A cut-off that was chosen from the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CutoffChoice {
    /// Reason of the choice.
    pub reason: String,
    /// Estimates with other cut-offs, from the beginning of the log.
    pub sweep: Vec<CutoffPoint>,
}

/// Estimates with one cut-off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CutoffPoint {
    /// Cut-off, Hz.
    pub cutoff_hz: f64,
    /// Parameter values in the order of theta.
    pub values: Vec<f64>,
    /// Residual of the filtered torque of each eighth of the samples with the parameters of the
    /// other eighths, relative to the torque (root mean square over the joints).
    #[serde(default)]
    pub held_out_residual: Option<f64>,
}

/// Constant difference of the two encoders of a joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EncoderOffsetResult {
    /// Name of the joint.
    pub joint: String,
    /// Reading of the link encoder minus that of the motor encoder without deflection, rad (m).
    pub offset_rad: f64,
    /// Its standard error, rad (m).
    pub standard_error_rad: Option<f64>,
}

/// Result of one estimator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EstimateResult {
    /// Name of the estimator.
    pub estimator: String,
    /// Verdict on the result.
    pub verdict: Verdict,
    /// The decision of the verdict, with the verdict in words.
    #[serde(default)]
    pub decision: Decision,
    /// Errors that the result promises for a new experiment of the same kind: those on held-out
    /// parts of the logs. Joints without a finite promise are absent.
    #[serde(default)]
    pub promise: Vec<JointPrediction>,
    /// Numerical rank of the stacked regressor.
    pub rank: usize,
    /// Number of parameters without a given value.
    #[serde(default)]
    pub unknowns: usize,
    /// Condition number of the stacked regressor; absent if infinite.
    pub condition_number: Option<f64>,
    /// Condition number with columns scaled to unit length; absent if infinite.
    pub condition_number_scaled: Option<f64>,
    /// The parameters, in the order of theta.
    pub parameters: Vec<ParameterEstimate>,
    /// Covariance of the errors of the determined parameters; absent if the log gives none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<CovarianceOfErrors>,
    /// Constant differences of the encoders, if they were estimated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub encoder_offsets: Vec<EncoderOffsetResult>,
    /// Velocities at which Stribeck friction has fallen to 1/e, rad/s (m/s), by joint.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub stribeck_velocity: Named,
    /// Sharpness of Coulomb friction that was estimated, s/rad (s/m), by joint.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub coulomb_sharpness: Named,
    /// Width of the widest element of presliding friction, rad (m), by joint.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub presliding_width: Named,
    /// Width of the widest element of the hysteresis of a spring, rad (m), by joint.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub hysteresis_width: Named,
    /// Half of the play in series with a spring, rad (m), by joint.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub play_half_width: Named,
    /// Deflection in the middle of the play, rad (m), by joint.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub play_centre: Named,
    /// Speeds up to which friction takes energy where only the sum of its laws does, rad/s (m/s), by joint: the largest
    /// ones of the log. Joints without such laws are absent.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub friction_speed: Named,
    /// Friction parameters beside further laws: raw, projected, and their difference.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dependence: Vec<ModelDependence>,
    /// The program that found possible bodies; absent if it found none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physical: Option<PhysicalResult>,
    /// Inertial parameters of single links and inertias of rotors, of possible bodies near the estimate
    /// and the nominal values; trees only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub standard_parameters: Vec<StandardParameter>,
    /// Fits of the motor rows alone; least squares and prediction error only.
    #[serde(default)]
    pub motor_rows: Vec<MotorRowResult>,
    /// Fit of the filter; prediction error only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refinement: Option<Refinement>,
    /// Parameters by other routes; least squares and prediction error only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cross_checks: Vec<CrossCheckResult>,
    /// Estimates by least squares from each of several logs, or from the quarters or halves of one
    /// log; least squares and prediction error only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartResult>,
    /// Root mean square residual of each row, N·m.
    pub residual_rms: Named,
    /// Residual of each torque row relative to its torque.
    pub relative_residual: Named,
    /// Part of the relative residual that the noise of the velocities causes through Coulomb
    /// transitions, for each torque row; absent without weights.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub resolution_share: Named,
    /// Findings about the result.
    pub warnings: Vec<Finding>,
    /// Computing time, s.
    pub elapsed_s: f64,
}

/// A friction parameter beside further laws, which explain a part of the same friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelDependence {
    /// Name of the parameter.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value beside the further laws; it holds only together with them.
    pub raw: f64,
    /// Value of the model without further laws that is nearest to all friction of this side, by
    /// least squares along the motion.
    pub projected: f64,
    /// Projected value minus raw value: the dependence on the model.
    pub difference: f64,
    /// Change of the difference per unit of each of the other laws, by name; absent in results of earlier versions.
    #[serde(default, skip_serializing_if = "Named::is_empty")]
    pub weights: Named,
}

impl ModelDependence {
    /// Returns the value of the model without the other laws for other values than those of the estimate.
    ///
    /// - `raw`: the parameter; `value`: the parameters of the other laws by name, all that have a weight.
    #[must_use]
    pub fn projected_with(&self, raw: f64, value: impl Fn(&str) -> Option<f64>) -> f64 {
        if self.weights.is_empty() {
            return raw + self.difference;
        }
        let weights = self.weights.iter();
        let terms = weights.map(|(name, weight)| weight * value(name).unwrap_or(0.0));
        raw + terms.sum::<f64>()
    }
}

/// Estimate from one part of the logs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PartResult {
    /// Beginning of the part on the time axis of all logs, s.
    pub from_s: f64,
    /// End of the part, s.
    pub to_s: f64,
    /// Value and standard error, in the order of `parameters`; absent for given parameters and for
    /// those that the part does not determine.
    pub values: Vec<Option<(f64, f64)>>,
}

/// Contributions to the standard error of a parameter by least squares or by the refinement; the
/// standard error is the root of the sum of their squares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ErrorParts {
    /// Disagreement of segments of the logs. That of the refinement is at least the standard error
    /// by the information.
    pub sampling: f64,
    /// Deviation between parts of the logs beyond their sampling errors.
    pub between_parts: f64,
    /// Size of the bias that all segments share. Least squares: from cross-checks and from other cut-offs. Refinement:
    /// the largest change by a missing law, delay or saturation of a torque that the likelihood shows; on a lower rung
    /// at least the difference from least squares beyond both standard errors.
    pub bias: f64,
}

/// Version of the form of `identification.json`.
pub const IDENTIFICATION_FORMAT: u32 = 3;

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Parameter")]
pub struct ParameterEstimate {
    /// Name.
    pub name: String,
    /// The paper's symbol.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Estimate; absent if the data do not determine it.
    pub value: Option<f64>,
    /// Standard error; absent if the value is given or the data do not determine it.
    pub standard_error: Option<f64>,
    /// Contributions to the standard error without constraints; least squares and the refinement only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_parts: Option<ErrorParts>,
    /// 95 % confidence interval. Over robots that can exist it is that by profile likelihood, and the standard error is
    /// half of it over its quantile.
    pub ci95: Option<[f64; 2]>,
    /// Whether the interval ends at zero, the bound of the parameter: the log gives only an upper bound of its size.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub one_sided: bool,
    /// Estimate without constraints, as diagnosis; absent with `constraints = "none"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unconstrained: Option<f64>,
    /// Value with possible bodies and possible drives beside an estimate without constraints; absent if the value itself
    /// is that of a robot that can exist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub physical: Option<f64>,
    /// The other parameter of the sum that the value is, with its sign, as in `+ joint1.motor_offset`; absent for a
    /// value of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sum_with: Option<String>,
    /// Nominal value from the description.
    pub nominal: Option<f64>,
    /// Whether the data determine it.
    pub identifiable: bool,
    /// Whether the experiment gives the value.
    #[serde(default)]
    pub fixed: bool,
    /// Torque of the parameter in the log, N·m: the root mean square of its column times its value,
    /// in the row where this is largest.
    #[serde(default)]
    pub torque_rms_nm: Option<f64>,
    /// The same torque relative to the largest torque of a parameter in that row.
    #[serde(default)]
    pub torque_share: Option<f64>,
    /// The same torque relative to the residual of the row, in the row where this ratio is largest.
    #[serde(default)]
    pub torque_over_residual: Option<f64>,
}

/// A motor row fitted alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotorRowResult {
    /// Name of the joint.
    pub joint: String,
    /// Parameters of the row.
    pub parameters: Vec<ParameterEstimate>,
    /// Condition number; absent if infinite.
    pub condition_number: Option<f64>,
    /// Residual relative to the torque; absent if there was no torque.
    pub relative_residual: Option<f64>,
    /// Squared ratio of the spring torque that only the spring explains to the residual; absent if
    /// the stiffness was given.
    #[serde(default)]
    pub scale_number: Option<f64>,
    /// Standard error of the stacked stiffness minus the motor row's stiffness, N·m/rad (N/m).
    #[serde(default)]
    pub stiffness_difference_standard_error: Option<f64>,
}

/// The parameters by another route.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CrossCheckResult {
    /// `two-stage` or `scale-invariant`.
    pub method: String,
    /// Values by name of the parameter.
    pub values: Named,
}

impl ParameterEstimate {
    /// Returns the name, with the other parameter of the sum that the value is.
    #[must_use]
    pub fn label(&self) -> Cow<'_, str> {
        match &self.sum_with {
            Some(other) => Cow::Owned(format!("{} {other}", self.name)),
            None => Cow::Borrowed(&self.name),
        }
    }

    /// Returns the value that the equations give without constraints.
    #[must_use]
    pub fn by_equations(&self) -> Option<f64> {
        self.unconstrained.or(self.value)
    }

    /// Returns the upper end of an interval that ends at zero, the bound of the parameter.
    #[must_use]
    pub fn at_most(&self) -> Option<f64> {
        self.ci95.filter(|_| self.one_sided).map(|[_, most]| most)
    }

    /// Returns the standard error of the value that the equations give without constraints.
    #[must_use]
    pub fn error_by_equations(&self) -> Option<f64> {
        let parts = self
            .error_parts
            .map(|parts| parts.sampling.hypot(parts.between_parts).hypot(parts.bias));
        parts.or(self.standard_error)
    }

    /// Removes the value of a parameter that the log does not determine. The value for simulations stays.
    pub(crate) fn forget(&mut self) {
        *self = Self {
            value: None,
            standard_error: None,
            error_parts: None,
            ci95: None,
            one_sided: false,
            unconstrained: None,
            physical: self.physical.or(self.value),
            identifiable: false,
            fixed: false,
            torque_rms_nm: None,
            torque_share: None,
            torque_over_residual: None,
            ..self.clone()
        };
    }
}

impl EstimateResult {
    /// Returns the refinement if the values come from it.
    #[must_use]
    pub fn refined(&self) -> Option<&Refinement> {
        self.refinement
            .as_ref()
            .filter(|refinement| refinement.used)
    }

    /// Returns whether the values are those of least squares.
    #[must_use]
    pub fn has_linear_values(&self) -> bool {
        self.refined().is_none()
            && (self.parameters.iter()).any(|parameter| parameter.error_parts.is_some())
    }

    /// Returns the values by name, without parameters that are not determined.
    #[must_use]
    pub fn values(&self) -> BTreeMap<String, f64> {
        let named = |values: &Named, name: fn(&str) -> String| -> Vec<(String, f64)> {
            (values.iter())
                .map(|(joint, value)| (name(joint), value))
                .collect()
        };
        (self.parameters.iter())
            .filter_map(|p| Some((p.name.clone(), p.value?)))
            .chain(named(&self.stribeck_velocity, stribeck_name))
            .chain(named(&self.presliding_width, presliding_name))
            .chain(named(&self.hysteresis_width, hysteresis_name))
            .chain(named(&self.play_half_width, play_name))
            .chain(named(&self.play_centre, play_centre_name))
            .chain(named(&self.coulomb_sharpness, sharpness_name))
            .collect()
    }

    /// Returns whether the values are those of a robot that can exist.
    #[must_use]
    pub fn is_constrained(&self) -> bool {
        self.parameters
            .iter()
            .any(|parameter| parameter.unconstrained.is_some())
    }

    /// Returns whether a parameter of the robot has no value.
    #[must_use]
    pub fn lacks(&self, name: &str) -> bool {
        self.parameter(name)
            .is_some_and(|parameter| parameter.value.is_none())
    }

    /// Returns a parameter by its name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<&ParameterEstimate> {
        self.parameters.iter().find(|p| p.name == name)
    }
}

/// Returns the table of parameters as CSV, one row per parameter and estimator.
#[must_use]
pub fn parameters_csv(identification: &Identification) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut write = |row: &[&str]| {
        // A write to a vector does not fail.
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
