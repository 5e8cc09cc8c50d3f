//! `[log]`: which columns hold what.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use super::choice::choose;
use super::robot::Side;

/// A log and what its columns mean; each list has one column per joint that
/// turns, or slides. Only flexible joints have a link position of their own.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub struct Log {
    /// CSV file with a header line, or several of one robot; relative to the
    /// experiment file.
    #[serde(default, deserialize_with = "files")]
    #[schemars(with = "Option<OneOrManyFiles>")]
    pub file: Option<Vec<PathBuf>>,
    /// Column of the time, s.
    pub time_s: Option<String>,
    /// Column of the time, ms.
    pub time_ms: Option<String>,
    /// Columns of the link positions, rad.
    pub link_position_rad: Option<Vec<String>>,
    /// Columns of the link positions, degrees.
    pub link_position_deg: Option<Vec<String>>,
    /// Columns of the link positions of joints that slide, m.
    pub link_position_m: Option<Vec<String>>,
    /// Columns of the joint deflections `q - phi`, rad.
    pub link_deflection_rad: Option<Vec<String>>,
    /// Columns of the joint deflections `q - phi`, degrees.
    pub link_deflection_deg: Option<Vec<String>>,
    /// Columns of the motor positions after the gearbox, rad.
    pub motor_position_rad: Option<Vec<String>>,
    /// Columns of the motor positions after the gearbox, degrees.
    pub motor_position_deg: Option<Vec<String>>,
    /// Columns of the motor positions of joints that slide, m.
    pub motor_position_m: Option<Vec<String>>,
    /// Side of the gearbox on which the motor positions were recorded.
    pub motor_position_side: Option<Side>,
    /// Columns of the motor torques after the gearbox, N·m.
    pub motor_torque_nm: Option<Vec<String>>,
    /// Columns of the motor forces of joints that slide, N.
    pub motor_force_n: Option<Vec<String>>,
    /// Whether the torques are those that acted, as the commands of a drive are,
    /// and not measured ones with noise of their own.
    #[serde(default)]
    pub motor_torque_exact: bool,
    /// Side of the gearbox on which the motor torques were recorded.
    pub motor_torque_side: Option<Side>,
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

    /// Returns this log with what `over` says of the same things replaced.
    #[must_use]
    pub fn overlaid(&self, over: &Self) -> Self {
        let mut log = self.clone();
        let says_link = over.link_position_rad.is_some()
            || over.link_position_deg.is_some()
            || over.link_position_m.is_some()
            || over.link_deflection_rad.is_some()
            || over.link_deflection_deg.is_some();
        if says_link {
            log.link_position_rad.clone_from(&over.link_position_rad);
            log.link_position_deg.clone_from(&over.link_position_deg);
            log.link_position_m.clone_from(&over.link_position_m);
            log.link_deflection_rad
                .clone_from(&over.link_deflection_rad);
            log.link_deflection_deg
                .clone_from(&over.link_deflection_deg);
        }
        let says_motor = over.motor_position_rad.is_some()
            || over.motor_position_deg.is_some()
            || over.motor_position_m.is_some();
        if says_motor {
            log.motor_position_rad.clone_from(&over.motor_position_rad);
            log.motor_position_m.clone_from(&over.motor_position_m);
            log.motor_position_deg.clone_from(&over.motor_position_deg);
        }
        let says_torque = over.motor_torque_nm.is_some()
            || over.motor_force_n.is_some()
            || over.motor_current_a.is_some()
            || over.drive_voltage_v.is_some();
        if says_torque {
            log.motor_torque_nm.clone_from(&over.motor_torque_nm);
            log.motor_force_n.clone_from(&over.motor_force_n);
            log.motor_current_a.clone_from(&over.motor_current_a);
            log.drive_voltage_v.clone_from(&over.drive_voltage_v);
        }
        log.file = over.file.clone().or(log.file);
        if over.time_s.is_some() || over.time_ms.is_some() {
            log.time_s.clone_from(&over.time_s);
            log.time_ms.clone_from(&over.time_ms);
        }
        log.motor_position_side = over.motor_position_side.or(log.motor_position_side);
        log.motor_torque_side = over.motor_torque_side.or(log.motor_torque_side);
        log.motor_torque_exact |= over.motor_torque_exact;
        log.delay_s.extend(over.delay_s.clone());
        log.sign.extend(over.sign.clone());
        log
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
                choose("delay", word, &["estimate"])
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
