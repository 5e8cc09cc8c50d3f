//! The part of the results that describes a refinement.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Figures of a prediction-error refinement besides the parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Refinement {
    /// Whether the values are those of the refinement. If not, they are those of least squares, and
    /// a finding gives the reason.
    #[serde(default)]
    pub used: bool,
    /// Rung of the ladder that these figures belong to: `free`, `cap10`, `cap3` or `flat`. It is
    /// the one that is used, or else the one that predicts held-out blocks best.
    #[serde(default)]
    pub rung: String,
    /// The rungs that were tried, in their order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rungs: Vec<RungResult>,
    /// Refined value and standard error of each parameter, in the order of `parameters`, whether
    /// they are used or not; `None` for a parameter that was not refined.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<Option<(f64, f64)>>,
    /// Whether the search converged.
    pub converged: bool,
    /// Number of runs of the filter.
    pub runs: usize,
    /// Number of samples used.
    pub samples: usize,
    /// Time spanned by the samples, s.
    pub duration_s: f64,
    /// Number of position measurements used. An incremental encoder gives one at each edge.
    pub measurements: u64,
    /// Minus the logarithm of the likelihood, without its constant.
    pub minus_log_likelihood: f64,
    /// Noise and disturbance of each row of the regressor.
    pub disturbances: Vec<RowDisturbance>,
    /// Corner frequency of the disturbances' spectrum, Hz.
    pub disturbance_corner_hz: f64,
    /// Mean squared whitened innovation. It is well below 1 for encoders, whose edges lie within
    /// their bounds, and above 2 if the model does not follow the log.
    #[serde(default)]
    pub cost_per_measurement: f64,
    /// Residual on held-out blocks of the logs.
    #[serde(default)]
    pub held_out_residual: Option<HeldOutResidual>,
    /// Noise of sensors beyond the noise that their samples show, where it was estimated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensor_noise: Vec<SensorNoise>,
    /// Constant offsets of sensors.
    pub encoder_offsets: Vec<RefinedOffset>,
    /// Delays estimated by likelihood.
    pub delays: Vec<RefinedDelay>,
    /// Common delay of all motor torques, s, and its standard error, if it is an unknown of the refinement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torques_delay_s: Option<(f64, f64)>,
    /// Prior levels of presliding friction.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub presliding_levels: Vec<PreslidingPrior>,
    /// Stribeck velocities that the description leaves open, estimated with the parameters.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stribeck_velocities: Vec<RefinedVelocity>,
    /// Sharpness of the Coulomb friction of joints whose description gives none, estimated with the parameters.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sharpnesses: Vec<RefinedSharpness>,
    /// Pairs of parameters with the most strongly correlated errors, and their correlation.
    pub correlations: Vec<(String, String, f64)>,
    /// Estimate from each of several logs alone: value and standard error, in the order of
    /// `parameters`; `None` for a parameter that was not refined.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub each_log: Vec<Vec<Option<(f64, f64)>>>,
}

/// A rung of the ladder: a refinement that allows slow disturbances up to some level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Rung")]
pub struct RungResult {
    /// Name: `free`, `cap10`, `cap3` or `flat`.
    pub name: String,
    /// Whether its values are used.
    pub used: bool,
    /// Residual on blocks that the estimates had not used; absent if the search failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out_residual: Option<HeldOutResidual>,
    /// Reason why it is used or not.
    pub outcome: String,
}

/// Residual of estimates without a block of the logs in the filtered torque of this block, relative
/// to that torque: root mean square over the torque rows and over all blocks, which are eighths of
/// the logs (quarters of short logs).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeldOutResidual {
    /// Residual of the refinement.
    pub refined: f64,
    /// Residual of least squares.
    pub linear: f64,
}

/// Noise and disturbance of a row of the regressor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Disturbance")]
pub struct RowDisturbance {
    /// Name of the row, for example `joint1.motor_nm`.
    pub row: String,
    /// Standard deviation of the torque's white noise, N·m (N).
    pub torque_noise_nm: f64,
    /// Standard deviation of further white noise while Coulomb friction reverses, N·m (N).
    #[serde(default)]
    pub reversal_noise_nm: f64,
    /// Standard deviation of the disturbance, N·m (N).
    pub disturbance_nm: f64,
    /// Standard deviation of the joint's motor torque, N·m (N).
    pub torque_nm: f64,
    /// Whether the disturbance ended at its upper bound.
    pub at_bound: bool,
}

/// Noise of a position sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SensorNoise {
    /// The column.
    pub column: String,
    /// Standard deviation of white noise, rad (m).
    pub noise_rad: f64,
    /// Standard deviation of the sensor's readings, rad (m).
    pub deviation_rad: f64,
}

/// Offset of a position sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "EncoderOffset")]
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

/// Delay of a column relative to the other columns, by likelihood.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RefinedDelay {
    /// The column.
    pub column: String,
    /// Time from the event to its record, s.
    pub delay_s: f64,
    /// Its standard error, s; absent if the log does not determine the delay.
    pub standard_error_s: Option<f64>,
    /// Delay that the parameter values assume, s.
    pub used_s: f64,
}

/// Stribeck velocity of a joint, by likelihood.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RefinedVelocity {
    /// Name of the joint.
    pub joint: String,
    /// Velocity at which the friction has fallen to 1/e, rad/s (m/s).
    pub velocity: f64,
    /// Its standard error, rad/s (m/s).
    pub standard_error: f64,
}

/// Sharpness of the Coulomb friction of a joint, by likelihood.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RefinedSharpness {
    /// Name of the joint.
    pub joint: String,
    /// Beta of `tanh(beta * velocity)`, s/rad (s/m).
    pub sharpness: f64,
    /// Its standard error, s/rad (s/m).
    pub standard_error: f64,
}

/// Prior of presliding friction on one side of a joint, or of the hysteresis of its spring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PreslidingPrior {
    /// Name of the joint.
    pub joint: String,
    /// `link`, `motor` or `spring`.
    pub side: String,
    /// Standard deviation of the coefficients, N·m (N).
    pub level_nm: f64,
}
