//! The reduced logs of one robot, as a value that programs can store, send and merge.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::choices::{Choices, FORMAT};
use crate::check::OfLog;
use crate::description::Experiment;
use crate::estimate::errors::FactorsError;
use crate::estimate::result::LogInfo;
use crate::estimate::steps::ReadLogs;
use crate::frequency::Record;
use crate::model::Model;
use crate::regression::{Joined, StoredSystem};

/// Factors of least squares of some logs of one robot, with the figures of each log.
///
/// [`merge`](Self::merge) joins factors of different logs in any order and any grouping, with the same
/// result bit by bit. `serde` stores them without loss; a log takes about 0.1 MB of JSON for two joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogFactors {
    format: u64,
    choices: Choices,
    /// In the order of their numbers.
    logs: Vec<OneLog>,
}

/// One log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct OneLog {
    /// Number of the log in the order of all logs.
    order: usize,
    info: LogInfo,
    examined: OfLog,
    /// First and last time, s.
    span: [f64; 2],
    system: StoredSystem,
}

impl OneLog {
    /// Returns the log that a pass reduced; `None` if the pass reduced none.
    pub(super) fn new(order: usize, read: ReadLogs) -> Option<Self> {
        Some(Self {
            order,
            info: read.infos.into_iter().next()?,
            examined: read.examined.into_iter().next()?,
            span: read.spans.into_iter().next()?,
            system: StoredSystem::new(read.system),
        })
    }
}

impl LogFactors {
    pub(super) fn new(choices: &Choices, log: OneLog) -> Self {
        Self {
            format: FORMAT,
            choices: choices.clone(),
            logs: vec![log],
        }
    }

    /// Returns number and name of each log, in the order of the numbers.
    pub fn logs(&self) -> impl Iterator<Item = (usize, String)> {
        self.logs.iter().map(|log| (log.order, log.info.name()))
    }

    /// Returns the choices with which the logs were reduced.
    #[must_use]
    pub fn choices(&self) -> &Choices {
        &self.choices
    }

    /// Returns the factors of the logs of both.
    ///
    /// # Errors
    ///
    /// [`FactorsError`] if both are not of one robot, one experiment, one version and one first log, or if
    /// a log is in both.
    pub fn merge(mut self, other: Self) -> Result<Self, FactorsError> {
        self.choices
            .check_same(&other.choices, &|| other.of_logs())?;
        self.logs.extend(other.logs);
        self.logs.sort_by_key(|log| log.order);
        let twice = self
            .logs
            .windows(2)
            .find(|two| two[0].order == two[1].order);
        if let Some([first, second]) = twice {
            return Err(FactorsError::Twice {
                first: first.info.name(),
                second: second.info.name(),
                order: first.order,
            });
        }
        Ok(self)
    }

    /// Returns the value as JSON.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Names of keys are texts, and lists have no infinite numbers, so nothing can fail.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Reads the value from JSON.
    ///
    /// # Errors
    ///
    /// [`FactorsError`] if the text is not such a value, or if another version wrote it.
    pub fn from_json(text: &str) -> Result<Self, FactorsError> {
        let not_readable = |error: serde_json::Error| FactorsError::NotReadable {
            what: "the factors",
            why: error.to_string(),
        };
        let json: Value = serde_json::from_str(text).map_err(not_readable)?;
        let format = json.get("format").and_then(Value::as_u64);
        if let Some(format) = format.filter(|format| *format != FORMAT) {
            let by = json.pointer("/choices/generator").and_then(Value::as_str);
            return Err(FactorsError::OtherVersion {
                what: "the factors".to_owned(),
                generator: by.unwrap_or("another program").to_owned(),
                format,
                known: FORMAT,
            });
        }
        serde_json::from_value(json).map_err(not_readable)
    }

    /// Returns the name of the value for messages.
    fn of_logs(&self) -> String {
        let names: Vec<String> = self.logs().map(|(_, name)| name).collect();
        format!("the factors of {}", names.join(", "))
    }

    /// Checks that the factors are those of this version, this experiment and these choices.
    pub(super) fn check(
        &self,
        experiment: &Experiment,
        choices: &Choices,
    ) -> Result<(), FactorsError> {
        if self.logs.is_empty() {
            return Err(FactorsError::None);
        }
        let what = || self.of_logs();
        self.choices.check(experiment, &what)?;
        choices.check_same(&self.choices, &what)
    }

    /// Returns all logs as a pass over them returns them.
    pub(super) fn read(&self, model: &Model) -> Result<ReadLogs, FactorsError> {
        let mut joined: Option<Joined> = None;
        for log in &self.logs {
            let system = log.system.restored(model);
            let system = system.ok_or_else(|| FactorsError::OtherShape {
                log: log.info.name(),
            })?;
            match &mut joined {
                Some(joined) => joined.append(system, log.span, log.info.period_s),
                None => joined = Some(Joined::new(system, log.span)),
            }
        }
        let joined = joined.ok_or(FactorsError::None)?;
        Ok(ReadLogs {
            system: joined.system,
            spans: joined.spans,
            infos: self.logs.iter().map(|log| log.info.clone()).collect(),
            examined: self.logs.iter().map(|log| log.examined.clone()).collect(),
            lsff: None,
            record: Record::new(model.joint_count()),
        })
    }
}
