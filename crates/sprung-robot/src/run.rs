//! `[controller]`, `[[validate]]` and `[simulate]`: controllers, validation runs, the digital twin.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use super::covariates::Drifts;
use super::known_words::choose;
use super::log::Log;

/// The controller that closes the loop.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Controller {
    /// `pd` on the motor positions, or `state-feedback` with feedforward.
    pub kind: ControllerKind,
    /// Position gains of `pd`, one per joint.
    #[serde(default)]
    pub kp_nm_per_rad: Vec<f64>,
    /// Velocity gains of `pd`, one per joint.
    #[serde(default)]
    pub kd_nms_per_rad: Vec<f64>,
    /// Gains of `state-feedback`, one row per joint: on the errors of all link positions, motor
    /// positions, link velocities and motor velocities.
    #[serde(default)]
    pub gain: Vec<Vec<f64>>,
    /// The model behind the feedforward of `state-feedback`.
    #[serde(default)]
    pub feedforward: Feedforward,
    /// Speed below which the torques of `state-feedback` against friction fade, so that they do not jump
    /// when a joint turns round; friction is not compensated if absent.
    pub friction_compensation_speed_rad_per_s: Option<f64>,
    /// Windows `p1`, `p2` of the averaging velocity estimator, samples.
    #[serde(default = "default_window")]
    pub velocity_window: [usize; 2],
    /// Impulses of an input shaper that the reference passes: the time in s and the part of the reference, in the order of
    /// time; the parts have the sum 1.
    #[serde(default)]
    pub shaper: Vec<[f64; 2]>,
    /// Motor reference of `pd`, link reference of `state-feedback`; its time is that of the log.
    #[serde(default)]
    pub reference: Reference,
}

fn default_window() -> [usize; 2] {
    [4, 4]
}

/// The law of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["pd", "state-feedback"]))]
pub enum ControllerKind {
    /// Proportional and derivative feedback of the motor positions, Eq. (24).
    Pd,
    /// State feedback with feedforward, Eqs. (32) and (33).
    StateFeedback,
}

impl TryFrom<String> for ControllerKind {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("controller", &word, &["pd", "state-feedback"])?;
        Ok([Self::Pd, Self::StateFeedback][index])
    }
}

/// The model behind a feedforward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["nominal", "identified"]))]
pub enum Feedforward {
    /// The nominal values of the file.
    #[default]
    Nominal,
    /// The parameters of the simulation or validation.
    Identified,
}

impl TryFrom<String> for Feedforward {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("feedforward", &word, &["nominal", "identified"])?;
        Ok([Self::Nominal, Self::Identified][index])
    }
}

/// A reference trajectory: for each joint the sum of its sines.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub struct Reference {
    /// The sines.
    #[serde(default)]
    pub sines: Vec<Sine>,
    /// Centre of the motion of revolute joints, degrees, one per joint.
    #[serde(default)]
    pub centre_deg: Vec<f64>,
    /// Centre of the motion of prismatic joints, m, one per joint.
    #[serde(default)]
    pub centre_m: Vec<f64>,
}

/// One sine of a reference.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Sine {
    /// Name of the joint.
    pub joint: String,
    /// Amplitude of a revolute joint, degrees.
    #[serde(default)]
    pub amplitude_deg: f64,
    /// Amplitude of a prismatic joint, m.
    #[serde(default)]
    pub amplitude_m: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Phase, degrees.
    #[serde(default)]
    pub phase_deg: f64,
}

/// One experiment to validate the model on.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Validate {
    /// Name for tables.
    pub name: String,
    /// Log; `[log]` gives the keys that it leaves out.
    pub log: Option<Log>,
    /// Controller; `[controller]` if absent.
    pub controller: Option<Controller>,
}

/// The digital twin.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Simulate {
    /// TOML file with a table of parameter values by name; the nominal values if absent.
    pub parameters: Option<PathBuf>,
    /// Length of the log, s.
    #[serde(default = "default_duration")]
    pub duration_s: f64,
    /// Sampling period of controller and log, s.
    #[serde(default = "default_period")]
    pub period_s: f64,
    /// Seed of encoder phases and noise.
    #[serde(default)]
    pub seed: u64,
    /// Offset of the motor encoders, rad (m), one per joint; it is added to the reading.
    #[serde(default)]
    pub motor_encoder_offset_rad: Vec<f64>,
    /// Counts per turn (per m) of the link encoders, one per joint; 0: no quantisation.
    #[serde(default)]
    pub link_encoder_counts_per_turn: Vec<u32>,
    /// Counts of the motor encoders per turn of the gearbox output, one per joint; 0: no
    /// quantisation.
    #[serde(default)]
    pub motor_encoder_counts_per_turn: Vec<u32>,
    /// Temperature of each joint at the start, °C; that of `friction_covariates` if absent.
    #[serde(default)]
    pub temperature_start_c: Vec<f64>,
    /// Temperature of each joint at the end, °C, which it reaches at a constant rate; that at the start
    /// if absent.
    #[serde(default)]
    pub temperature_end_c: Vec<f64>,
    /// Covariates of friction at the start and at the end.
    #[serde(flatten)]
    pub drifts: Drifts,
    /// Standard deviation of the noise on the logged torque, N·m.
    #[serde(default)]
    pub torque_noise_nm: Vec<f64>,
    /// Standard deviation of a disturbance torque that acts on the motor, N·m.
    #[serde(default)]
    pub torque_disturbance_nm: Vec<f64>,
    /// Standard deviation of a disturbance torque that acts on the link, N·m (N).
    #[serde(default)]
    pub link_torque_disturbance_nm: Vec<f64>,
    /// Torque of a contact on each link, N·m (N), one per joint.
    #[serde(default)]
    pub contact_torque_nm: Vec<f64>,
    /// Times from and to which the contact lasts, s: `[[4.0, 4.5]]`.
    #[serde(default)]
    pub contact_s: Vec<[f64; 2]>,
    /// Target of a servo's twin.
    pub target: Option<Reference>,
    /// Times from and to which the drive of a servo is off, s: `[[4.0, 6.0]]`.
    #[serde(default)]
    pub drive_off_s: Vec<[f64; 2]>,
    /// Standard deviation of the noise of the gyroscopes on the links, rad/s, one per joint.
    #[serde(default)]
    pub gyroscope_noise_rad_per_s: Vec<f64>,
    /// Reading of each axis of the gyroscopes without motion, rad/s, one per joint.
    #[serde(default)]
    pub gyroscope_bias_rad_per_s: Vec<f64>,
    /// Largest angular velocity that the gyroscopes read, rad/s, one per joint.
    #[serde(default)]
    pub gyroscope_limit_rad_per_s: Vec<f64>,
    /// Standard deviation of the noise of the accelerometers on the links, m/s², one per joint.
    #[serde(default)]
    pub accelerometer_noise_m_per_s2: Vec<f64>,
    /// Reading of each axis of the accelerometers without acceleration, m/s², one per joint.
    #[serde(default)]
    pub accelerometer_bias_m_per_s2: Vec<f64>,
    /// Largest acceleration that the accelerometers read, m/s², one per joint.
    #[serde(default)]
    pub accelerometer_limit_m_per_s2: Vec<f64>,
    /// Standard deviation of the noise of the joint torque sensors, N·m, one per joint.
    #[serde(default)]
    pub joint_torque_noise_nm: Vec<f64>,
    /// Largest torque that the joint torque sensors read, N·m, one per joint.
    #[serde(default)]
    pub joint_torque_limit_nm: Vec<f64>,
    /// Readings of the joint torque sensors per torque of the springs, one row per joint: gains on
    /// the diagonal, cross-talk beside it. The identity matrix if absent.
    #[serde(default)]
    pub joint_torque_matrix: Vec<Vec<f64>>,
}

fn default_duration() -> f64 {
    10.0
}

fn default_period() -> f64 {
    1e-3
}

/// The meaning of a list of `[simulate]` with one entry per joint.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TwinList<'a> {
    /// Any finite numbers.
    Numbers(&'a [f64]),
    /// Standard deviations, zero or positive.
    Deviations(&'a [f64]),
    /// Limits, positive.
    Limits(&'a [f64]),
    /// Counts of encoders.
    Counts(&'a [u32]),
    /// Rows of a matrix.
    Rows(&'a [Vec<f64>]),
}

impl TwinList<'_> {
    /// Returns the number of entries.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Numbers(list) | Self::Deviations(list) | Self::Limits(list) => list.len(),
            Self::Counts(list) => list.len(),
            Self::Rows(list) => list.len(),
        }
    }
}

impl Simulate {
    /// Returns the lists with one entry per joint, with their keys.
    pub(crate) fn lists(&self) -> Vec<(&'static str, TwinList<'_>)> {
        use TwinList::{Counts, Deviations, Limits, Numbers, Rows};
        macro_rules! lists {
            ($($name:ident: $meaning:ident),* $(,)?) => {
                vec![$((stringify!($name), $meaning(&self.$name))),*]
            };
        }
        lists!(
            motor_encoder_offset_rad: Numbers,
            contact_torque_nm: Numbers,
            link_encoder_counts_per_turn: Counts,
            motor_encoder_counts_per_turn: Counts,
            gyroscope_bias_rad_per_s: Numbers,
            accelerometer_bias_m_per_s2: Numbers,
            temperature_start_c: Numbers,
            temperature_end_c: Numbers,
            torque_noise_nm: Deviations,
            torque_disturbance_nm: Deviations,
            link_torque_disturbance_nm: Deviations,
            joint_torque_noise_nm: Deviations,
            gyroscope_noise_rad_per_s: Deviations,
            accelerometer_noise_m_per_s2: Deviations,
            joint_torque_limit_nm: Limits,
            gyroscope_limit_rad_per_s: Limits,
            accelerometer_limit_m_per_s2: Limits,
            joint_torque_matrix: Rows,
        )
    }
}
