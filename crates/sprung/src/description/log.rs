//! `[log]`: which columns hold what.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use super::choice::choose;
use super::columns::{Column, ColumnName, Columns};
use super::factor::{Delay, Factor};
use super::robot::Side;

/// A log and what its columns mean; each list has one column per joint that
/// turns, or slides. Only flexible joints have a link position of their own.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub struct Log {
    /// The log, or several of one robot; relative to the experiment file. What
    /// a file is shows in its first bytes.
    #[serde(default, deserialize_with = "files")]
    #[schemars(with = "Option<OneOrManyFiles>")]
    pub file: Option<Vec<PathBuf>>,
    /// How CSV is written, where it does not show.
    pub csv: Option<CsvForm>,
    /// Column of the time, s.
    pub time_s: Option<ColumnName>,
    /// Column of the time, ms.
    pub time_ms: Option<ColumnName>,
    /// Column of the time, µs.
    pub time_us: Option<ColumnName>,
    /// Column of the time, ns.
    pub time_ns: Option<ColumnName>,
    /// Column of the time, in the unit that it says, or the `time` of a topic.
    #[serde(default, deserialize_with = "one_column")]
    #[schemars(with = "Option<Columns>")]
    pub time: Option<Column>,
    /// Period of the clock that samples, s. Without a column of the time there is a
    /// sample each period; with one, samples are at whole multiples of it, and time
    /// stamps say at which to the nearest.
    pub period_s: Option<f64>,
    /// Whether samples were taken when their time stamps say.
    pub sampling: Option<SamplingTimes>,
    /// Columns of the link positions, rad.
    pub link_position_rad: Option<Columns>,
    /// Columns of the link positions, degrees.
    pub link_position_deg: Option<Columns>,
    /// Columns of the link positions of joints that slide, m.
    pub link_position_m: Option<Columns>,
    /// Columns of the link positions, in the unit that each says.
    pub link_position: Option<Columns>,
    /// Columns of the joint deflections `q - phi`, rad.
    pub link_deflection_rad: Option<Columns>,
    /// Columns of the joint deflections `q - phi`, degrees.
    pub link_deflection_deg: Option<Columns>,
    /// Columns of the joint deflections, in the unit that each says.
    pub link_deflection: Option<Columns>,
    /// Columns of the motor positions after the gearbox, rad.
    pub motor_position_rad: Option<Columns>,
    /// Columns of the motor positions after the gearbox, degrees.
    pub motor_position_deg: Option<Columns>,
    /// Columns of the motor positions of joints that slide, m.
    pub motor_position_m: Option<Columns>,
    /// Columns of the motor positions, in the unit that each says.
    pub motor_position: Option<Columns>,
    /// Side of the gearbox on which the motor positions were recorded.
    pub motor_position_side: Option<Side>,
    /// Columns of the motor torques after the gearbox, N·m.
    pub motor_torque_nm: Option<Columns>,
    /// Columns of the motor forces of joints that slide, N.
    pub motor_force_n: Option<Columns>,
    /// Whether the torques are those that acted, as the commands of a drive are,
    /// and not measured ones with noise of their own.
    #[serde(default)]
    pub motor_torque_exact: bool,
    /// Columns of the motor torques or forces, in the unit that each says.
    pub motor_torque: Option<Columns>,
    /// Side of the gearbox on which the motor torques were recorded.
    pub motor_torque_side: Option<Side>,
    /// Columns of the motor currents, A.
    pub motor_current_a: Option<Columns>,
    /// Columns of the motor currents, in the unit that each says.
    pub motor_current: Option<Columns>,
    /// Columns of the amplifiers' command voltages, V.
    pub drive_voltage_v: Option<Columns>,
    /// Columns of the amplifiers' command voltages, in the unit that each says.
    pub drive_voltage: Option<Columns>,
    /// How much later than the others a column was recorded, s, by column.
    #[serde(default)]
    pub delay_s: BTreeMap<String, Delay>,
    /// 1 or -1 by column, for channels that count the other way; or `"estimate"`.
    #[serde(default)]
    pub sign: BTreeMap<String, Factor>,
    /// What a column is multiplied with, beside what its own entry says; or
    /// `"estimate"`.
    #[serde(default)]
    pub gain: BTreeMap<String, Factor>,
}

impl Log {
    /// Returns whether it names a column of the time.
    #[must_use]
    pub fn has_time(&self) -> bool {
        let columns = [&self.time_s, &self.time_ms, &self.time_us, &self.time_ns];
        self.time.is_some() || columns.into_iter().any(Option::is_some)
    }

    /// Returns the name of its file, or `other` if it names none.
    #[must_use]
    pub fn name(&self, other: &str) -> String {
        match &self.file {
            None => other.to_owned(),
            Some(files) => {
                let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
                names.join(", ")
            }
        }
    }

    /// Puts signs and gains that were found, by column, in the place of those that are
    /// to be estimated.
    pub fn settle(&mut self, signs: &BTreeMap<String, f64>, gains: &BTreeMap<String, f64>) {
        let known = |(column, value): (&String, &f64)| (column.clone(), Factor::Known(*value));
        self.sign.extend(signs.iter().map(known));
        self.gain.extend(gains.iter().map(known));
    }
}

/// Whether samples were taken when their time stamps say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["auto", "even", "as-stamped"]))]
pub enum SamplingTimes {
    /// What the positions say.
    #[default]
    Auto,
    /// One sample each period; stamps are rounded or late.
    Even,
    /// When stamped.
    AsStamped,
}

impl TryFrom<String> for SamplingTimes {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("sampling", &word, &["auto", "even", "as-stamped"])?;
        Ok([Self::Auto, Self::Even, Self::AsStamped][index])
    }
}

/// How a CSV file is written.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CsvForm {
    /// What stands between cells: one character, or `"space"` for any number of
    /// blanks.
    pub delimiter: Option<String>,
    /// What stands before the decimals: `"."` or `","`.
    pub decimal: Option<String>,
    /// Whether there is a line of names.
    pub header: Option<bool>,
    /// Character that begins lines without data; `#` and `%` if absent.
    pub comment: Option<String>,
    /// Lines before the names, or before the data where there are no names.
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

#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "describes the schema of one file or several")]
enum OneOrManyFiles {
    One(PathBuf),
    Many(Vec<PathBuf>),
}

fn files<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Vec<PathBuf>>, D::Error> {
    struct Visitor;
    impl<'de> serde::de::Visitor<'de> for Visitor {
        type Value = Option<Vec<PathBuf>>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("the name of a file or a list of names")
        }

        fn visit_str<E>(self, word: &str) -> Result<Self::Value, E> {
            Ok(Some(vec![PathBuf::from(word)]))
        }

        fn visit_seq<A: serde::de::SeqAccess<'de>>(
            self,
            mut list: A,
        ) -> Result<Self::Value, A::Error> {
            let mut all = Vec::new();
            while let Some(one) = list.next_element::<PathBuf>()? {
                all.push(one);
            }
            if all.is_empty() {
                return Err(serde::de::Error::custom("the list of files is empty"));
            }
            Ok(Some(all))
        }
    }
    deserializer.deserialize_any(Visitor)
}
