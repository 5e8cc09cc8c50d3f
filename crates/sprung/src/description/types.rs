//! The keys of `experiment.toml`, as they stand in the file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use super::choice::choose;

/// The whole file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(title = "sprung experiment")]
pub(super) struct ExperimentFile {
    /// Version of the file format; 1.
    pub(super) format: u32,
    /// The robot.
    pub(super) robot: Robot,
    /// The measured log, and what its columns mean.
    pub(super) log: Option<Log>,
    /// How to identify.
    #[serde(default)]
    pub(super) identify: Identify,
    /// The controller that ran during the log.
    pub(super) controller: Option<Controller>,
    /// Experiments to validate the model on.
    #[serde(default)]
    pub(super) validate: Vec<Validate>,
    /// The digital twin that `sprung simulate` runs.
    pub(super) simulate: Option<Simulate>,
}

/// The robot.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Robot {
    /// Name for reports.
    #[serde(default = "unnamed")]
    pub name: String,
    /// Kinematics: `planar-2r`, the paper's arm with two joints in a
    /// horizontal plane.
    pub kinematics: Kinematics,
    /// Joints, base first.
    #[serde(default)]
    pub joint: Vec<Joint>,
    /// Nominal values of link inertial parameters, by name.
    #[serde(default)]
    pub nominal: BTreeMap<String, f64>,
}

fn unnamed() -> String {
    "unnamed robot".to_owned()
}

/// How the links are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["planar-2r"]))]
pub enum Kinematics {
    /// Two revolute joints with parallel vertical axes.
    Planar2R,
}

impl TryFrom<String> for Kinematics {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        choose("kinematics", &word, &["planar-2r"], &[]).map(|_| Self::Planar2R)
    }
}

/// One joint.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Joint {
    /// Name, unique.
    pub name: String,
    /// Torque of the motor per current, on the side that
    /// `torque_constant_side` says.
    pub torque_constant_nm_per_a: Option<f64>,
    /// Side of the gearbox on which the torque constant holds; `output` when
    /// it already contains the gear ratio.
    #[serde(default)]
    pub torque_constant_side: Side,
    /// Motor turns per output turn.
    #[serde(default = "one")]
    pub gear_ratio: f64,
    /// Current of the amplifier per command voltage.
    pub amplifier_gain_a_per_v: Option<f64>,
    /// Largest command voltage that the amplifier takes; no limit if absent.
    pub amplifier_limit_v: Option<f64>,
    /// beta of the Coulomb friction `tanh(beta * velocity)`.
    #[serde(default = "default_sharpness")]
    pub coulomb_sharpness_s_per_rad: f64,
    /// Values that the maker gives.
    #[serde(default)]
    pub nominal: Nominal,
}

impl Joint {
    /// Returns the motor torque per current on the output side, N·m/A, if the
    /// torque constant is given.
    ///
    /// # Source
    ///
    /// Eq. (3); the paper does not say on which side of the gearbox its `K_m`
    /// holds.
    #[must_use]
    pub fn torque_per_ampere(&self) -> Option<f64> {
        let ratio = match self.torque_constant_side {
            Side::Output => 1.0,
            Side::Motor => self.gear_ratio,
        };
        Some(ratio * self.torque_constant_nm_per_a?)
    }

    /// Returns the motor torque per command voltage on the output side, N·m/V,
    /// if both constants are given.
    ///
    /// # Source
    ///
    /// Eq. (5).
    #[must_use]
    pub fn torque_per_volt(&self) -> Option<f64> {
        Some(self.torque_per_ampere()? * self.amplifier_gain_a_per_v?)
    }
}

fn one() -> f64 {
    1.0
}

fn default_sharpness() -> f64 {
    100.0
}

/// A side of the gearbox.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["output", "motor"]))]
pub enum Side {
    /// After the gearbox.
    #[default]
    Output,
    /// Before the gearbox.
    Motor,
}

impl TryFrom<String> for Side {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("side", &word, &["output", "motor"], &[])?;
        Ok([Self::Output, Self::Motor][index])
    }
}

/// Values that the maker gives for a joint, SI units.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub struct Nominal {
    /// Rotor inertia at the output side, kg·m².
    pub rotor_inertia: Option<f64>,
    /// Viscous friction on the link side, N·m·s/rad.
    pub link_viscous: Option<f64>,
    /// Viscous friction on the motor side, N·m·s/rad.
    pub motor_viscous: Option<f64>,
    /// Stiffness, N·m/rad.
    pub stiffness: Option<f64>,
    /// Coulomb friction on the link side, N·m.
    pub link_coulomb: Option<f64>,
    /// Coulomb friction on the motor side, N·m.
    pub motor_coulomb: Option<f64>,
}

/// A log and what its columns mean; each list has one column per joint.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub struct Log {
    /// CSV file with a header line; relative to the experiment file.
    pub file: Option<PathBuf>,
    /// Column of the time, s.
    pub time_s: Option<String>,
    /// Columns of the link positions, rad.
    pub link_position_rad: Option<Vec<String>>,
    /// Columns of the link positions, degrees.
    pub link_position_deg: Option<Vec<String>>,
    /// Columns of the joint deflections `q - phi`, rad.
    pub link_deflection_rad: Option<Vec<String>>,
    /// Columns of the joint deflections `q - phi`, degrees.
    pub link_deflection_deg: Option<Vec<String>>,
    /// Columns of the motor positions after the gearbox, rad.
    pub motor_position_rad: Option<Vec<String>>,
    /// Columns of the motor positions after the gearbox, degrees.
    pub motor_position_deg: Option<Vec<String>>,
    /// Side of the gearbox on which the motor positions were recorded.
    pub motor_position_side: Option<Side>,
    /// Columns of the motor torques after the gearbox, N·m.
    pub motor_torque_nm: Option<Vec<String>>,
    /// Columns of the motor currents, A.
    pub motor_current_a: Option<Vec<String>>,
    /// Columns of the amplifiers' command voltages, V.
    pub drive_voltage_v: Option<Vec<String>>,
    /// How much later than the others a column was recorded, s, by column.
    #[serde(default)]
    pub delay_s: BTreeMap<String, Delay>,
    /// 1 or -1 by column, for channels that count the other way.
    #[serde(default)]
    pub sign: BTreeMap<String, f64>,
}

impl Log {
    /// Returns this log with what `over` says of the same things replaced.
    #[must_use]
    pub fn overlaid(&self, over: &Self) -> Self {
        let mut log = self.clone();
        let says_link = over.link_position_rad.is_some()
            || over.link_position_deg.is_some()
            || over.link_deflection_rad.is_some()
            || over.link_deflection_deg.is_some();
        if says_link {
            log.link_position_rad.clone_from(&over.link_position_rad);
            log.link_position_deg.clone_from(&over.link_position_deg);
            log.link_deflection_rad
                .clone_from(&over.link_deflection_rad);
            log.link_deflection_deg
                .clone_from(&over.link_deflection_deg);
        }
        if over.motor_position_rad.is_some() || over.motor_position_deg.is_some() {
            log.motor_position_rad.clone_from(&over.motor_position_rad);
            log.motor_position_deg.clone_from(&over.motor_position_deg);
        }
        let says_torque = over.motor_torque_nm.is_some()
            || over.motor_current_a.is_some()
            || over.drive_voltage_v.is_some();
        if says_torque {
            log.motor_torque_nm.clone_from(&over.motor_torque_nm);
            log.motor_current_a.clone_from(&over.motor_current_a);
            log.drive_voltage_v.clone_from(&over.drive_voltage_v);
        }
        log.file = over.file.clone().or(log.file);
        log.time_s = over.time_s.clone().or(log.time_s);
        log.motor_position_side = over.motor_position_side.or(log.motor_position_side);
        log.delay_s.extend(over.delay_s.clone());
        log.sign.extend(over.sign.clone());
        log
    }
}

/// A delay: a number, or `"estimate"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delay {
    /// Known, s.
    Known(f64),
    /// To be found from the log.
    Estimate,
}

impl<'de> Deserialize<'de> for Delay {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Delay;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number of seconds or \"estimate\"")
            }

            fn visit_f64<E>(self, value: f64) -> Result<Delay, E> {
                Ok(Delay::Known(value))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Delay, E> {
                Ok(Delay::Known(value as f64))
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Delay, E> {
                choose("delay", word, &["estimate"], &[])
                    .map(|_| Delay::Estimate)
                    .map_err(E::custom)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

impl JsonSchema for Delay {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Delay".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "seconds, or \"estimate\"",
            "anyOf": [{ "type": "number" }, { "const": "estimate" }],
        })
    }
}

/// How to identify.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Identify {
    /// One estimator or several.
    #[serde(deserialize_with = "one_or_many")]
    #[schemars(with = "OneOrManyEstimators")]
    pub estimator: Vec<Estimator>,
    /// λ of the filter pair.
    pub filter_cutoff_rad_per_s: f64,
    /// How the filter pair is made discrete.
    pub discretization: DiscretizationName,
    /// Cut-off of the zero-phase Butterworth filter of the positions.
    #[serde(deserialize_with = "cutoff")]
    pub position_cutoff_hz: f64,
    /// Order of that filter.
    pub position_filter_order: usize,
    /// Weights of the samples; least squares only.
    pub(super) weights: Weights,
    /// Constant offset between the two encoders.
    pub(super) encoder_offset: EncoderOffset,
    /// Forgetting rate δ of LSFF, 1/s.
    pub lsff_forgetting_per_s: f64,
    /// Diagonal of the initial gain matrix of LSFF.
    pub lsff_initial_gain: f64,
    /// Windows `p1`, `p2` of the velocities that LSFF uses.
    pub lsff_velocity_window: [usize; 2],
}

impl Default for Identify {
    fn default() -> Self {
        Self {
            estimator: vec![Estimator::LeastSquares],
            filter_cutoff_rad_per_s: 30.0,
            discretization: DiscretizationName::Matched,
            position_cutoff_hz: 10.0,
            position_filter_order: 2,
            weights: Weights::None,
            encoder_offset: EncoderOffset::None,
            lsff_forgetting_per_s: 1.0,
            lsff_initial_gain: 10.0,
            lsff_velocity_window: [4, 4],
        }
    }
}

/// An estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["least-squares", "lsff"]))]
pub enum Estimator {
    /// Least squares on the filtered regression.
    LeastSquares,
    /// Recursive least squares with forgetting factor, sample by sample.
    Lsff,
}

impl Estimator {
    /// Returns the name in files and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::LeastSquares => "least-squares",
            Self::Lsff => "lsff",
        }
    }
}

impl TryFrom<String> for Estimator {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let available = ["least-squares", "lsff"];
        let later = ["prediction-error", "output-error"];
        let index = choose("estimator", &word, &available, &later)?;
        Ok([Self::LeastSquares, Self::Lsff][index])
    }
}

#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "describes the schema of one estimator or several")]
enum OneOrManyEstimators {
    One(Estimator),
    Many(Vec<Estimator>),
}

fn one_or_many<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<Estimator>, D::Error> {
    struct Visitor;
    impl<'de> serde::de::Visitor<'de> for Visitor {
        type Value = Vec<Estimator>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("the name of an estimator or a list of names")
        }

        fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Self::Value, E> {
            Estimator::try_from(word.to_owned())
                .map(|one| vec![one])
                .map_err(E::custom)
        }

        fn visit_seq<A: serde::de::SeqAccess<'de>>(
            self,
            mut list: A,
        ) -> Result<Self::Value, A::Error> {
            let mut all = Vec::new();
            while let Some(one) = list.next_element()? {
                all.push(one);
            }
            Ok(all)
        }
    }
    deserializer.deserialize_any(Visitor)
}

fn cutoff<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    struct Visitor;
    impl serde::de::Visitor<'_> for Visitor {
        type Value = f64;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("a frequency in Hz")
        }

        fn visit_f64<E>(self, value: f64) -> Result<f64, E> {
            Ok(value)
        }

        fn visit_i64<E>(self, value: i64) -> Result<f64, E> {
            Ok(value as f64)
        }

        fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<f64, E> {
            Err(E::custom(if word == "auto" {
                "position cut-off \"auto\" is not available in this version of sprung; \
                 give a frequency in Hz, 10 to 20 suits most encoders"
                    .to_owned()
            } else {
                format!("position cut-off \"{word}\" is not a frequency in Hz")
            }))
        }
    }
    deserializer.deserialize_any(Visitor)
}

/// How the filter pair is made discrete.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["matched", "paper"]))]
pub enum DiscretizationName {
    /// Tustin for the regressor, zero-order hold for the held torque.
    Matched,
    /// Zero-order hold for both, as printed.
    Paper,
}

impl DiscretizationName {
    /// Returns the name in files and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Matched => "matched",
            Self::Paper => "paper",
        }
    }
}

impl TryFrom<String> for DiscretizationName {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("discretization", &word, &["matched", "paper"], &[])?;
        Ok([Self::Matched, Self::Paper][index])
    }
}

/// Weights of the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["none"]))]
pub(super) enum Weights {
    /// All samples alike.
    None,
}

impl TryFrom<String> for Weights {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        choose("weights", &word, &["none"], &["transition"]).map(|_| Self::None)
    }
}

/// Constant offset between the two encoders of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["none"]))]
pub(super) enum EncoderOffset {
    /// Taken to be zero.
    None,
}

impl TryFrom<String> for EncoderOffset {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        choose("encoder_offset", &word, &["none"], &["estimate"]).map(|_| Self::None)
    }
}

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
    /// Gains of `state-feedback`: one row per joint on the errors of link
    /// positions, motor positions, link velocities and motor velocities.
    #[serde(default)]
    pub gain: Vec<Vec<f64>>,
    /// The model behind the feedforward of `state-feedback`.
    #[serde(default)]
    pub feedforward: Feedforward,
    /// `p1`, `p2` of the averaging velocity estimator.
    #[serde(default = "default_window")]
    pub velocity_window: [usize; 2],
    /// Motor reference of `pd`, link reference of `state-feedback`.
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
    /// Eq. (24).
    Pd,
    /// Eqs. (32) and (33).
    StateFeedback,
}

impl TryFrom<String> for ControllerKind {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("controller", &word, &["pd", "state-feedback"], &[])?;
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
    /// The parameters that are simulated or validated.
    Identified,
}

impl TryFrom<String> for Feedforward {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("feedforward", &word, &["nominal", "identified"], &[])?;
        Ok([Self::Nominal, Self::Identified][index])
    }
}

/// A reference trajectory: for each joint the sum of its sines.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub struct Reference {
    /// The sines.
    #[serde(default)]
    pub sines: Vec<Sine>,
}

/// One sine of a reference.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Sine {
    /// Name of the joint.
    pub joint: String,
    /// Amplitude, degrees.
    pub amplitude_deg: f64,
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
    /// Log; what it does not say is taken from `[log]`.
    pub log: Option<Log>,
    /// Controller; that of the experiment if absent.
    pub controller: Option<Controller>,
}

/// The digital twin.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Simulate {
    /// TOML file with a table of parameter values by name; the nominal values
    /// if absent.
    pub parameters: Option<PathBuf>,
    /// Length of the log, s.
    #[serde(default = "default_duration")]
    pub duration_s: f64,
    /// Period of controller and log, s.
    #[serde(default = "default_period")]
    pub period_s: f64,
    /// Seed of encoder phases and noise.
    #[serde(default)]
    pub seed: u64,
    /// Counts per turn of the link encoders, one per joint; 0 is exact.
    #[serde(default)]
    pub link_encoder_counts_per_turn: Vec<u32>,
    /// Counts per turn of the motor encoders after the gearbox; 0 is exact.
    #[serde(default)]
    pub motor_encoder_counts_per_turn: Vec<u32>,
    /// Standard deviation of the noise on the logged torque, N·m.
    #[serde(default)]
    pub torque_noise_nm: Vec<f64>,
    /// Standard deviation of a real disturbance on the motor, N·m.
    #[serde(default)]
    pub torque_disturbance_nm: Vec<f64>,
    /// Corner of that disturbance's spectrum, Hz.
    #[serde(default = "default_disturbance_corner")]
    pub torque_disturbance_hz: f64,
}

fn default_duration() -> f64 {
    10.0
}

fn default_period() -> f64 {
    1e-3
}

fn default_disturbance_corner() -> f64 {
    3.0
}
