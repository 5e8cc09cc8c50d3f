//! The frequency response of a log beside that of a model, as results.

use serde::{Deserialize, Serialize};

/// Frequency responses of a log and of the identified model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrequencyResponse {
    /// Duration of the samples, s.
    pub duration_s: f64,
    /// Number of periods if the motion repeats itself; the response is then that of their mean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub periods: Option<usize>,
    /// The flexible joints.
    pub joints: Vec<JointResponse>,
}

/// Response of a flexible joint to the torque of its own motor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointResponse {
    /// Name of the joint.
    pub joint: String,
    /// The resonance and the antiresonance that belong to the joint's spring, if they are not
    /// overdamped.
    pub features: Vec<Feature>,
    /// Frequencies of the curves, Hz; empty if the log determines no response.
    pub frequency_hz: Vec<f64>,
    /// Motor position per motor torque.
    pub motor: ResponseCurves,
    /// Link position per motor torque.
    pub link: ResponseCurves,
}

/// Curves of the log and of the model, one value per frequency. Values of the log are absent where the
/// log does not determine them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResponseCurves {
    /// Magnitude by the log, rad/(N·m) (m/N).
    pub log_magnitude: Vec<Option<f64>>,
    /// Its standard error, relative to the magnitude.
    pub log_relative_error: Vec<Option<f64>>,
    /// Phase by the log, degrees.
    pub log_phase_deg: Vec<Option<f64>>,
    /// Part of the position's power that the torques explain, 0 to 1.
    pub log_coherence: Vec<Option<f64>>,
    /// Magnitude by the model, rad/(N·m) (m/N).
    pub model_magnitude: Vec<f64>,
    /// Phase by the model, degrees.
    pub model_phase_deg: Vec<f64>,
}

/// Kind of a feature of a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureKind {
    /// Natural frequency of a vibration with free motors.
    Resonance,
    /// Natural frequency of a vibration while all motors stand still.
    Antiresonance,
}

impl FeatureKind {
    /// Returns the word in texts.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Resonance => "resonance",
            Self::Antiresonance => "antiresonance",
        }
    }
}

/// Why a log does not show a vibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unseen {
    /// The log is too short to resolve it.
    TooShort,
    /// A position hardly exceeds its noise at this frequency.
    NoExcitation,
    /// Dry friction has more than a tenth of the power of the motor torque at this frequency, and no
    /// torque of the log contains it.
    DryFriction,
    /// The response has no clear peak.
    NoPeak,
}

impl Unseen {
    /// Returns the reason in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::TooShort => "the log is too short",
            Self::NoExcitation => "hardly any motion at this frequency",
            Self::DryFriction => "dry friction disturbs it",
            Self::NoPeak => "no clear peak",
        }
    }
}

/// A resonance or an antiresonance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Feature {
    /// Its kind.
    pub kind: FeatureKind,
    /// Frequency of the model in the mean pose of the log, Hz.
    pub model_hz: f64,
    /// Its standard error by those of the parameters, Hz.
    pub model_standard_error_hz: f64,
    /// Lowest and highest frequency of the model in the poses of the log, Hz.
    pub model_over_poses_hz: [f64; 2],
    /// Damping ratio of the model, with friction replaced by the viscous friction nearest to it along
    /// the log.
    pub model_damping: f64,
    /// Why the log does not show it; absent if it does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unseen: Option<Unseen>,
    /// Frequency by the log, Hz; absent if the log does not show it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log_hz: Option<f64>,
    /// Its standard error, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log_standard_error_hz: Option<f64>,
    /// Damping ratio by the log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log_damping: Option<f64>,
}
