//! `[log]`: the files of a log and the meaning of its columns.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::columns::{Column, ColumnName, Columns};
use super::covariates::CovariateColumns;
use super::delays::DelaysOfLog;
use super::factor::Factor;
use super::known_words::choose;
use super::robot::Side;
use super::torque_hold::TorqueReading;
use super::window::{FilePart, OneOrManyFiles, files};

/// A log and the meaning of its columns. A list has one column per joint; with `_rad` or `_deg` one
/// per revolute joint, with `_m` or `_n` one per prismatic joint. Only flexible joints have a link
/// position and a joint torque.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub struct Log {
    /// The log, or several logs of one robot; relative to the experiment file. The first bytes of a
    /// file determine its format. A table gives a window of a file:
    /// `{ path = "run.csv", from_s = 12.0, to_s = 60.0 }`, or `from_index` and `to_index`.
    #[serde(default, deserialize_with = "files")]
    #[schemars(with = "Option<OneOrManyFiles>")]
    pub file: Option<Vec<FilePart>>,
    /// Form of CSV files, if sprung does not determine it correctly.
    pub csv: Option<CsvForm>,
    /// Column of the time, s.
    pub time_s: Option<ColumnName>,
    /// Column of the time, ms.
    pub time_ms: Option<ColumnName>,
    /// Column of the time, µs.
    pub time_us: Option<ColumnName>,
    /// Column of the time, ns.
    pub time_ns: Option<ColumnName>,
    /// Column of the time, with its unit, or the `time` of a topic.
    #[serde(default, deserialize_with = "one_column")]
    #[schemars(with = "Option<Columns>")]
    pub time: Option<Column>,
    /// Period of the sampling clock, s. Without a time column the log has one sample each period.
    /// With a time column, samples were taken at the multiples of the period nearest to their time
    /// stamps.
    pub period_s: Option<f64>,
    /// Sampling times of the log: `"auto"` (the default) determines them from the positions, `"even"`
    /// takes one sample each period, `"as-stamped"` takes the time stamps.
    pub sampling: Option<SamplingTimes>,
    /// Treatment of samples in which a column has no value (`NaN`, a null, an empty cell of CSV):
    /// `"refuse"` (the default) refuses the log, `"gap"` leaves these samples out, as if they had not
    /// been recorded.
    pub nan: Option<MissingValues>,
    /// Treatment of samples that contradict their neighbours: `"mend"` (the default) interpolates a single position or
    /// torque far from its neighbours and leaves out samples in which a column stands still although its joint moves,
    /// `"keep"` uses them.
    pub wrong_samples: Option<WrongSamples>,
    /// Columns of the link positions, rad.
    pub link_position_rad: Option<Columns>,
    /// Columns of the link positions, degrees.
    pub link_position_deg: Option<Columns>,
    /// Columns of the link positions of prismatic joints, m.
    pub link_position_m: Option<Columns>,
    /// Columns of the link positions, each with its unit.
    pub link_position: Option<Columns>,
    /// Columns of the joint deflections `q - phi`, rad.
    pub link_deflection_rad: Option<Columns>,
    /// Columns of the joint deflections `q - phi`, degrees.
    pub link_deflection_deg: Option<Columns>,
    /// Columns of the joint deflections `q - phi`, each with its unit.
    pub link_deflection: Option<Columns>,
    /// Columns of the motor positions after the gearbox, rad.
    pub motor_position_rad: Option<Columns>,
    /// Columns of the motor positions after the gearbox, degrees.
    pub motor_position_deg: Option<Columns>,
    /// Columns of the motor positions of prismatic joints, m.
    pub motor_position_m: Option<Columns>,
    /// Columns of the motor positions, each with its unit.
    pub motor_position: Option<Columns>,
    /// Side of the gearbox on which the motor positions were recorded.
    pub motor_position_side: Option<Side>,
    /// Columns of the motor torques after the gearbox, N·m.
    pub motor_torque_nm: Option<Columns>,
    /// Columns of the motor forces of prismatic joints, N.
    pub motor_force_n: Option<Columns>,
    /// Whether the logged torques are the torques that acted, as the commands of a drive are;
    /// otherwise they are measurements with noise.
    #[serde(default)]
    pub motor_torque_exact: bool,
    /// Meaning of a logged torque. `"held"`: it acts from its time stamp on, for one period of the controller.
    /// `"mean"`: the mean over one period about the time stamp. `"instantaneous"`: the torque at the time stamp. If
    /// absent, sprung finds when the torques act.
    pub torque: Option<TorqueReading>,
    /// Period of the controller that holds the torques, s: a multiple or a fraction 1/n of the period of the log,
    /// which is its value if absent.
    pub controller_period_s: Option<f64>,
    /// Columns of the motor torques or forces, each with its unit.
    pub motor_torque: Option<Columns>,
    /// Side of the gearbox on which the motor torques were recorded.
    pub motor_torque_side: Option<Side>,
    /// Columns of the motor currents, A.
    pub motor_current_a: Option<Columns>,
    /// Columns of the motor currents, each with its unit.
    pub motor_current: Option<Columns>,
    /// Columns of the amplifiers' command voltages, V.
    pub drive_voltage_v: Option<Columns>,
    /// Columns of the amplifiers' command voltages, each with its unit.
    pub drive_voltage: Option<Columns>,
    /// Columns of the targets of position servos, rad.
    pub motor_target_rad: Option<Columns>,
    /// Columns of the targets of position servos, degrees.
    pub motor_target_deg: Option<Columns>,
    /// Columns of the targets of position servos, each with its unit.
    pub motor_target: Option<Columns>,
    /// Columns that are 1 while the drive of a position servo is on and 0 while it is off; on if
    /// absent.
    pub drive_on: Option<Columns>,
    /// Columns of the torque sensors of flexible joints, N·m: the torque of the spring on the link.
    pub joint_torque_nm: Option<Columns>,
    /// Columns of the force sensors of flexible prismatic joints, N: the force of the spring on the
    /// link.
    pub joint_force_n: Option<Columns>,
    /// Columns of the torque or force sensors of flexible joints, each with its unit.
    pub joint_torque: Option<Columns>,
    /// Columns of the gyroscopes on the links of flexible joints that turn, rad/s. A gyroscope has one axis, along that
    /// of the joint, or three.
    #[serde(default)]
    pub gyroscope_rad_per_s: AxisColumns,
    /// Columns of the gyroscopes, degrees per second.
    #[serde(default)]
    pub gyroscope_deg_per_s: AxisColumns,
    /// Corner of the high-pass filter of the deflections from gyroscopes, Hz; 0.2 if absent. It should
    /// be below the frequencies of the motion.
    pub gyroscope_corner_hz: Option<f64>,
    /// Columns of the accelerometers on the links of flexible joints, m/s²: acceleration minus that of free fall, so
    /// +9.81 along an axis that points up. An accelerometer has one axis or three.
    #[serde(default)]
    pub accelerometer_m_per_s2: AxisColumns,
    /// Columns of the accelerometers, in multiples of 9.80665 m/s².
    #[serde(default)]
    pub accelerometer_g: AxisColumns,
    /// Corner of the high-pass filter of the deflections from accelerometers, Hz; 0.3 if absent. It should
    /// be below the frequencies of the motion. Gravity across the axes needs a higher one.
    pub accelerometer_corner_hz: Option<f64>,
    /// Columns of covariates of friction.
    #[serde(flatten)]
    pub covariates: CovariateColumns,
    /// Delay of a column against the others, s, by column: `{ q1 = "estimate", tau2 = 0.002 }`; or `"estimate"` for
    /// all link positions and torques. Delays that the log shows are used without this key; a number, also 0, keeps a
    /// delay fixed.
    #[serde(default)]
    pub delay_s: DelaysOfLog,
    /// Sign by column, 1 or -1; or `"estimate"`.
    #[serde(default)]
    pub sign: BTreeMap<String, Factor>,
    /// Gain by column, multiplied with the `gain` of the column's own table; or `"estimate"`.
    #[serde(default)]
    pub gain: BTreeMap<String, Factor>,
}

/// Columns of the axes of a sensor: one axis, or all three.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(expecting = "columns of each axis, as in gyroscope_rad_per_s.x = [\"gx1\", \"gx2\"]")]
pub struct AxisColumns {
    /// Columns of the first axis.
    pub x: Option<Columns>,
    /// Columns of the second axis.
    pub y: Option<Columns>,
    /// Columns of the third axis.
    pub z: Option<Columns>,
}

impl Log {
    /// Returns whether the log has a time column.
    #[must_use]
    pub fn has_time(&self) -> bool {
        let columns = [&self.time_s, &self.time_ms, &self.time_us, &self.time_ns];
        self.time.is_some() || columns.into_iter().any(Option::is_some)
    }

    /// Returns the names of its files with their windows, or `other` if it has no file.
    #[must_use]
    pub fn name(&self, other: &str) -> String {
        match &self.file {
            None => other.to_owned(),
            Some(files) => {
                let names: Vec<String> = files.iter().map(ToString::to_string).collect();
                names.join(", ")
            }
        }
    }

    /// Replaces signs and gains by their estimates.
    ///
    /// - `signs`, `gains`: estimates by column.
    pub fn settle(&mut self, signs: &BTreeMap<String, f64>, gains: &BTreeMap<String, f64>) {
        let known = |(column, value): (&String, &f64)| (column.clone(), Factor::Known(*value));
        self.sign.extend(signs.iter().map(known));
        self.gain.extend(gains.iter().map(known));
    }
}

/// Sampling times of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["auto", "even", "as-stamped"]))]
pub enum SamplingTimes {
    /// Determined from the positions.
    #[default]
    Auto,
    /// One sample each period; time stamps are rounded or late.
    Even,
    /// At the time stamps.
    AsStamped,
}

impl TryFrom<String> for SamplingTimes {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("sampling", &word, &["auto", "even", "as-stamped"])?;
        Ok([Self::Auto, Self::Even, Self::AsStamped][index])
    }
}

/// Treatment of samples without a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["refuse", "gap"]))]
pub enum MissingValues {
    /// The log is refused.
    #[default]
    Refuse,
    /// The samples are left out.
    Gap,
}

impl TryFrom<String> for MissingValues {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("nan", &word, &["refuse", "gap"])?;
        Ok([Self::Refuse, Self::Gap][index])
    }
}

/// Treatment of samples that contradict their neighbours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["mend", "keep"]))]
pub enum WrongSamples {
    /// They are interpolated or left out.
    #[default]
    Mend,
    /// They are used.
    Keep,
}

impl TryFrom<String> for WrongSamples {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("wrong_samples", &word, &["mend", "keep"])?;
        Ok([Self::Mend, Self::Keep][index])
    }
}

/// Form of a CSV file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CsvForm {
    /// Delimiter of cells: one character, `"tab"`, or `"space"` for any number of blanks.
    pub delimiter: Option<String>,
    /// Decimal point: `"."` or `","`.
    pub decimal: Option<String>,
    /// Whether the file has a line of column names.
    pub header: Option<bool>,
    /// Character that begins a comment line; `#` and `%` if absent.
    pub comment: Option<String>,
    /// Number of lines before the column names, or before the data if there are no names.
    pub skip_lines: usize,
}

fn one_column<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Column>, D::Error> {
    let Columns(mut columns) = Columns::deserialize(deserializer)?;
    match columns.len() {
        1 => Ok(columns.pop()),
        _ => Err(serde::de::Error::custom("time is one column, not a list")),
    }
}
