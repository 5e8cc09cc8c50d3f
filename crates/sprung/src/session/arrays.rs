//! Arrays in memory that are named by their quantity instead of the columns of a file.

use super::error::SessionError;
use super::load::Session;
use sprung_log::{Array, Arrays};
use sprung_robot::{Column, ColumnName, Columns, Joints, Key, Log, Quantity};

/// Short names: of the time, and of quantities in SI units, for all joints.
const TIME: &str = "t";
const SHORT: [(&str, Quantity); 4] = [
    ("q", Quantity::LinkPosition),
    ("phi", Quantity::MotorPosition),
    ("tau", Quantity::MotorTorque),
    ("tau_joint", Quantity::JointTorque),
];

/// Keys of `[log]` for the time.
const TIMES: [&str; 4] = ["time_s", "time_ms", "time_us", "time_ns"];

/// The arrays of one quantity: one array per joint.
#[derive(Clone, Debug)]
pub struct QuantityArrays {
    /// `t`, `q`, `phi`, `tau` or `tau_joint`, in SI units; or a key of `[log]`, such as
    /// `motor_current_a`.
    pub name: String,
    /// One array for each joint, or for each joint that has the quantity.
    pub arrays: Vec<Array>,
}

impl Session {
    /// Returns whether arrays of these names are given by quantity: they are not all columns of
    /// `[log]`, and one of them has the name of a quantity.
    #[must_use]
    pub fn is_by_quantity<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> bool {
        let columns = self.log_columns();
        (names.into_iter())
            .any(|name| !columns.iter().any(|column| column == name) && is_quantity(name))
    }

    /// Returns the names of the columns that `[log]` names, the time first.
    #[must_use]
    pub fn log_columns(&self) -> Vec<String> {
        let Some(log) = &self.experiment().log else {
            return Vec::new();
        };
        let times = [&log.time_s, &log.time_ms, &log.time_us, &log.time_ns];
        (times.into_iter().flatten())
            .map(ToString::to_string)
            .chain(log.labels(&self.experiment().robot))
            .collect()
    }

    /// Returns this session with a log of arrays, and that log.
    ///
    /// Delays, signs and gains of `[log]` apply to the arrays of the same quantities and joints.
    ///
    /// # Errors
    ///
    /// [`SessionError`] if a name is no quantity, or if arrays do not fit each other, the joints or
    /// the rest of `[log]`.
    pub fn with_quantities(
        &self,
        quantities: Vec<QuantityArrays>,
    ) -> Result<(Self, Arrays), SessionError> {
        let mut log = Log::default();
        let mut columns = Vec::new();
        for quantity in quantities {
            self.place(quantity, &mut log, &mut columns)?;
        }
        Ok((self.with_log(&log)?, Arrays::new(columns)?))
    }

    fn place(
        &self,
        quantity: QuantityArrays,
        log: &mut Log,
        columns: &mut Vec<(String, Array)>,
    ) -> Result<(), SessionError> {
        let robot = &self.experiment().robot;
        let QuantityArrays { name, arrays } = quantity;
        let misfit = |joints: &[usize]| SessionError::QuantityColumns {
            name: name.clone(),
            found: arrays.len(),
            joints: (joints.iter())
                .map(|joint| robot.joint[*joint].name.clone())
                .collect(),
        };
        let time = match name.as_str() {
            TIME | "time_s" => Some(&mut log.time_s),
            "time_ms" => Some(&mut log.time_ms),
            "time_us" => Some(&mut log.time_us),
            "time_ns" => Some(&mut log.time_ns),
            _ => None,
        };
        if let Some(time) = time {
            let found = arrays.len();
            let [array] =
                <[Array; 1]>::try_from(arrays).map_err(|_| SessionError::QuantityColumns {
                    name: name.clone(),
                    found,
                    joints: vec!["one time".to_owned()],
                })?;
            *time = Some(ColumnName::Name(name.clone()));
            columns.push((name, array));
            return Ok(());
        }
        let keys = keys(&name);
        if keys.is_empty() {
            return Err(SessionError::NotAQuantity { name });
        }
        let all: Vec<usize> = (0..robot.joint.len()).collect();
        let mut joints: Vec<usize> = (keys.iter())
            .flat_map(|key| key.joints(Joints::ThatHaveIt, robot))
            .collect();
        joints.sort_unstable();
        if joints.is_empty() {
            joints.clone_from(&all);
        }
        let given = match arrays.len() {
            found if found == joints.len() => &joints,
            found if found == all.len() => &all,
            _ => return Err(misfit(&joints)),
        };
        for key in keys {
            let mut of_key = key.joints(Joints::ThatHaveIt, robot);
            if of_key.is_empty() {
                of_key = key.joints(Joints::Rigid, robot);
            }
            let mut named = Vec::new();
            for joint in of_key {
                let Some(place) = given.iter().position(|other| *other == joint) else {
                    return Err(misfit(&joints));
                };
                let column = format!("{name}.{}", robot.joint[joint].name);
                named.push(Column::named(ColumnName::Name(column.clone())));
                columns.push((column, arrays[place].clone()));
            }
            if !named.is_empty() {
                *key.columns_mut(log) = Some(Columns(named));
            }
        }
        Ok(())
    }
}

/// Returns whether a name is that of a quantity.
fn is_quantity(name: &str) -> bool {
    name == TIME || TIMES.contains(&name) || !keys(name).is_empty()
}

/// Returns the keys of `[log]` that a name means: for turning and for sliding joints.
fn keys(name: &str) -> Vec<&'static Key> {
    match SHORT.iter().find(|(short, _)| *short == name) {
        Some((_, quantity)) => Key::in_si_units(*quantity).collect(),
        None => Key::named(name).into_iter().collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sprung_base::demo;
    use sprung_log::Input;
    use std::io::ErrorKind;
    use std::path::Path;

    fn demo_session() -> Session {
        let files =
            |_: &Path| -> std::io::Result<Box<dyn Input>> { Err(ErrorKind::NotFound.into()) };
        Session::read("demo", demo::EXPERIMENT, &[], files).unwrap()
    }

    fn some(name: &str, columns: usize) -> QuantityArrays {
        QuantityArrays {
            name: name.to_owned(),
            arrays: Array::columns(vec![0.5; 10 * columns], columns),
        }
    }

    #[test]
    fn quantities_become_columns_of_the_log() {
        let session = demo_session();
        assert!(session.is_by_quantity(["t", "q", "phi", "tau"]));
        let columns = session.log_columns();
        assert!(!session.is_by_quantity(columns.iter().map(String::as_str)));
        let given = vec![some("t", 1), some("q", 2), some("phi", 2), some("tau", 2)];
        let (session, arrays) = session.with_quantities(given).unwrap();
        assert_eq!(
            arrays.names(),
            [
                "t",
                "q.joint1",
                "q.joint2",
                "phi.joint1",
                "phi.joint2",
                "tau.joint1",
                "tau.joint2"
            ]
        );
        assert_eq!(session.log_columns(), arrays.names());
        assert_eq!(arrays.len(), 10);
    }

    #[test]
    fn arrays_that_do_not_fit_are_named() {
        let session = demo_session();
        let error = |given| session.with_quantities(given).unwrap_err().to_string();
        assert_eq!(
            error(vec![some("t", 1), some("q", 3)]),
            "\"q\" has 3 columns; give one for each of these: joint1, joint2"
        );
        assert!(error(vec![some("torque", 2)]).starts_with("\"torque\" is neither a column"));
        assert!(error(vec![some("t", 2)]).contains("has 2 columns"));
    }
}
