//! The log of a validation run over `[log]`.
//!
//! Delays, signs and gains belong to the channel of a signal and a joint. If a run gives the channel another column,
//! they apply to that column.

use std::collections::BTreeMap;

use super::delays::DelaysOfLog;
use super::log::Log;
use super::quantities::{Joints, Key, Signal};
use super::robot::Robot;

/// The column of one joint.
#[derive(Clone, Debug)]
pub(super) struct Labelled {
    /// Key of `[log]` that names it.
    pub(super) key: &'static Key,
    /// Index of the joint.
    pub(super) joint: usize,
    /// Name of the column as a key of `delay_s`, `sign` and `gain`.
    pub(super) label: String,
    /// Name that all columns of one entry share.
    pub(super) common: String,
}

impl Labelled {
    fn is_named(&self, name: &str) -> bool {
        self.label == name || self.common == name
    }

    /// Returns whether two columns are of the same signal and joint.
    fn is_channel_of(&self, other: &Self) -> bool {
        self.key.signal() == other.key.signal() && self.joint == other.joint
    }
}

/// A value of `[log]` that cannot apply to the column of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Ambiguous {
    /// `delay_s`, `sign` or `gain`.
    pub(super) table: &'static str,
    /// Name of the column in `[log]`.
    pub(super) name: String,
    /// Name of the column of the run.
    pub(super) label: String,
    /// Reason, as a clause.
    pub(super) reason: String,
}

impl Log {
    /// Returns the names of its columns, joint by joint.
    pub fn labels(&self, robot: &Robot) -> impl Iterator<Item = String> {
        (self.labelled(robot).into_iter()).map(|column| column.label)
    }

    /// Returns its columns, joint by joint.
    pub(super) fn labelled(&self, robot: &Robot) -> Vec<Labelled> {
        let mut all = Vec::new();
        for (key, columns) in self.given() {
            let mut joints = key.joints_in(self, Joints::ThatHaveIt, robot);
            if joints.is_empty() {
                joints = key.joints_in(self, Joints::Rigid, robot);
            }
            for (k, joint) in joints.into_iter().enumerate() {
                let name = &robot.joint[joint].name;
                let (label, common) = columns.labels(k, name, key.default_field());
                all.push(Labelled {
                    key,
                    joint,
                    label,
                    common,
                });
            }
        }
        all
    }

    /// Returns this log with the entries of `over` in place of its own; a signal in `over` replaces
    /// all columns of this signal. Delays, signs and gains of replaced columns apply to the columns
    /// of the same signals and joints, unless `over` gives them.
    #[must_use]
    pub fn overlaid(&self, over: &Self, robot: &Robot) -> Self {
        let mut log = self.clone();
        macro_rules! replace {
            ($($key:ident),+) => {
                if false $(|| over.$key.is_some())+ {
                    $(log.$key.clone_from(&over.$key);)+
                }
            };
        }
        for signal in Signal::all().chain([Signal::Target, Signal::Switch]) {
            if Key::of(signal).any(|key| key.is_given(over)) {
                for key in Key::of(signal) {
                    *key.columns_mut(&mut log) = key.columns(over).cloned();
                }
            }
        }
        replace!(time_s, time_ms, time_us, time_ns, time, period_s, sampling);
        replace!(torque, controller_period_s);
        log.file = over.file.clone().or(log.file);
        log.csv = over.csv.clone().or(log.csv);
        log.nan = over.nan.or(log.nan);
        log.motor_position_side = over.motor_position_side.or(log.motor_position_side);
        log.motor_torque_side = over.motor_torque_side.or(log.motor_torque_side);
        log.motor_torque_exact |= over.motor_torque_exact;
        let columns = (self.labelled(robot), over.labelled(robot));
        let estimates_all = self.delay_s.estimates_all() || over.delay_s.estimates_all();
        let delays = moved(&self.delay_s, &over.delay_s, &columns);
        log.delay_s = DelaysOfLog::new(delays, estimates_all);
        log.sign = moved(&self.sign, &over.sign, &columns);
        log.gain = moved(&self.gain, &over.gain, &columns);
        log
    }

    /// Returns the first delay, sign or gain that [`overlaid`](Self::overlaid) cannot assign: its
    /// name is that of another channel in `over`, or the column of the channel measures another
    /// quantity.
    pub(super) fn ambiguous(&self, over: &Self, robot: &Robot) -> Option<Ambiguous> {
        let columns = (self.labelled(robot), over.labelled(robot));
        let joints: Vec<&str> = robot.joint.iter().map(|joint| &*joint.name).collect();
        let find = |table, given: Vec<&String>, of_run: Vec<&String>| {
            ambiguous(table, &given, &of_run, &columns, &joints)
        };
        find(
            "delay_s",
            self.delay_s.keys().collect(),
            over.delay_s.keys().collect(),
        )
        .or_else(|| {
            let given = self.sign.keys().collect();
            find("sign", given, over.sign.keys().collect())
        })
        .or_else(|| {
            let given = self.gain.keys().collect();
            find("gain", given, over.gain.keys().collect())
        })
    }
}

/// Returns the values of `[log]` under the names of the run's columns, and those of the run.
///
/// - `columns`: columns of `[log]`, and columns that replace them.
fn moved<T: Clone>(
    of_log: &BTreeMap<String, T>,
    of_run: &BTreeMap<String, T>,
    (old, new): &(Vec<Labelled>, Vec<Labelled>),
) -> BTreeMap<String, T> {
    let is_replaced =
        |column: &&Labelled| (new.iter()).any(|other| other.key.signal() == column.key.signal());
    let mut all = BTreeMap::new();
    // Names of whole entries come first, so that values of single joints replace theirs.
    let whole = |name: &String| old.iter().any(|column| column.common == *name);
    let (of_entries, of_joints): (Vec<_>, Vec<_>) =
        of_log.iter().partition(|(name, _)| whole(name));
    for (name, value) in of_entries.into_iter().chain(of_joints) {
        let replaced: Vec<&Labelled> = (old.iter())
            .filter(|column| column.is_named(name))
            .filter(is_replaced)
            .collect();
        if replaced.is_empty() {
            all.insert(name.clone(), value.clone());
        }
        for column in replaced {
            let Some(channel) = new.iter().find(|other| other.is_channel_of(column)) else {
                continue;
            };
            if !of_run.keys().any(|key| channel.is_named(key)) {
                all.insert(channel.label.clone(), value.clone());
            }
        }
    }
    all.extend(
        of_run
            .iter()
            .map(|(name, value)| (name.clone(), value.clone())),
    );
    all
}

fn ambiguous(
    table: &'static str,
    given: &[&String],
    of_run: &[&String],
    (old, new): &(Vec<Labelled>, Vec<Labelled>),
    joints: &[&str],
) -> Option<Ambiguous> {
    for name in given {
        for column in old.iter().filter(|column| column.is_named(name)) {
            let Some(channel) = new.iter().find(|other| other.is_channel_of(column)) else {
                continue;
            };
            if of_run.iter().any(|other| channel.is_named(other)) {
                continue;
            }
            let joint = joints[column.joint];
            let elsewhere =
                (new.iter()).find(|other| other.is_named(name) && !channel.is_named(name));
            let reason = if let Some(other) = elsewhere {
                format!(
                    "in [log] this column is the {} of {joint}, in this log it is the {} of {}",
                    column.key.quantity.words(),
                    other.key.quantity.words(),
                    joints[other.joint]
                )
            } else if column.key.quantity != channel.key.quantity
                || column.key.scaling != channel.key.scaling
            {
                format!(
                    "in [log] {} measures {joint}, in this log {} does",
                    column.key.name, channel.key.name
                )
            } else {
                continue;
            };
            return Some(Ambiguous {
                table,
                name: (*name).clone(),
                label: channel.label.clone(),
                reason,
            });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use crate::{Delay, Experiment, Factor, Log, no_files, read};

    const ROBOT: &str = r#"
format = 1
[robot]
name = "two joints"
kinematics = "planar-2r"
[[robot.joint]]
name = "joint1"
torque_constant_nm_per_a = 2.0
[[robot.joint]]
name = "joint2"
torque_constant_nm_per_a = 2.0
[log]
period_s = 0.001
link_position_rad = "q*"
motor_position_rad = ["p1", "p2"]
motor_torque_nm = ["tau1", "tau2"]
"#;

    fn experiment(of_log: &str, of_run: &str) -> Result<Experiment, String> {
        let text =
            format!("{ROBOT}{of_log}\n[[validate]]\nname = \"other\"\nlog = {{ {of_run} }}\n");
        read("experiment.toml", &text, &[], &mut no_files).map_err(|error| error.to_string())
    }

    fn overlaid(of_log: &str, of_run: &str) -> Log {
        let experiment = experiment(of_log, of_run).unwrap();
        let over = experiment.validate[0].log.as_ref().unwrap();
        experiment.log.unwrap().overlaid(over, &experiment.robot)
    }

    #[test]
    fn delays_and_signs_go_over_to_other_columns() {
        let of_log = "delay_s = { \"q*\" = 0.001, \"q*[joint2]\" = 0.002, p1 = \"estimate\", tau1 = 0.003 }\n\
                      sign = { p1 = -1 }";
        let of_run = "link_position_rad = [\"l1\", \"l2\"], motor_position_rad = [\"m1\", \"m2\"]";
        let log = overlaid(of_log, of_run);
        let delays: Vec<(&str, Delay)> = (log.delay_s.iter())
            .map(|(name, delay)| (name.as_str(), *delay))
            .collect();
        let expected = [
            ("l1", Delay::Known(0.001)),
            ("l2", Delay::Known(0.002)),
            ("m1", Delay::Estimate),
            ("tau1", Delay::Known(0.003)),
        ];
        assert_eq!(delays, expected);
        assert_eq!(log.sign["m1"], Factor::Known(-1.0));
    }

    #[test]
    fn values_of_the_run_replace_those_of_the_log() {
        let log = overlaid(
            "delay_s = { p1 = 0.002 }",
            "motor_position_rad = [\"m1\", \"m2\"], delay_s = { m1 = 0.0 }",
        );
        assert_eq!(log.delay_s.len(), 1);
        assert_eq!(log.delay_s["m1"], Delay::Known(0.0));
    }

    #[test]
    fn ambiguous_columns_are_refused_with_the_reason() {
        let exchanged = "motor_position_rad = [\"p2\", \"p1\"]";
        let error = experiment("delay_s = { p1 = 0.002 }", exchanged).unwrap_err();
        let reason = "in [log] this column is the motor position of joint1, in this log it is the \
                      motor position of joint2";
        assert!(error.contains(reason), "{error}");
        assert!(error.contains("give delay_s = { \"p2\" = … }"), "{error}");
        let current = "motor_current_a = [\"i1\", \"i2\"]";
        let error = experiment("sign = { tau1 = -1 }", current).unwrap_err();
        let reason = "in [log] motor_torque_nm measures joint1, in this log motor_current_a does";
        assert!(error.contains(reason), "{error}");
        let given = "motor_current_a = [\"i1\", \"i2\"], sign = { i1 = 1 }";
        assert!(experiment("sign = { tau1 = -1 }", given).is_ok());
    }

    #[test]
    fn a_name_that_is_no_column_stays_an_error() {
        let of_run = "motor_position_rad = [\"m1\", \"m2\"], delay_s = { p1 = 0.002 }";
        let error = experiment("", of_run).unwrap_err();
        assert!(error.contains("not a column of this log"), "{error}");
    }
}
