//! Keys that all joints share: `[robot.joint_defaults]`.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::robot::Joint;

const KEY: &str = "joint_defaults";

/// Returns the schema of the defaults: that of a joint without its name.
pub(super) fn schema(generator: &mut SchemaGenerator) -> Schema {
    let mut schema = Joint::json_schema(generator);
    schema.remove("required");
    schema.remove("title");
    let properties = schema.get_mut("properties");
    if let Some(properties) = properties.and_then(serde_json::Value::as_object_mut) {
        properties.remove("name");
    }
    schema
}

/// Moves the defaults into the joints: a joint keeps the values that it gives.
pub(super) fn spread(file: &mut DeTable<'_>) {
    let Some(DeValue::Table(robot)) = file.get_mut("robot").map(Spanned::get_mut) else {
        return;
    };
    // Another value than a table stays, and the reader refuses it.
    let Some(DeValue::Table(defaults)) = robot.get(KEY).map(Spanned::get_ref) else {
        return;
    };
    let defaults = defaults.clone();
    robot.remove(KEY);
    let Some(DeValue::Array(joints)) = robot.get_mut("joint").map(Spanned::get_mut) else {
        return;
    };
    for joint in joints.iter_mut() {
        if let DeValue::Table(joint) = joint.get_mut() {
            complete(joint, &defaults);
        }
    }
}

/// Adds the keys that a table lacks.
fn complete<'i>(table: &mut DeTable<'i>, defaults: &DeTable<'i>) {
    for (key, value) in defaults {
        match (table.get_mut(key).map(Spanned::get_mut), value.get_ref()) {
            (None, _) => {
                table.insert(key.clone(), value.clone());
            }
            (Some(DeValue::Table(given)), DeValue::Table(defaults)) => complete(given, defaults),
            (Some(_), _) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{no_files, read};
    use sprung_base::demo;

    fn with_defaults(defaults: &str) -> String {
        demo::EXPERIMENT.replacen(
            "[[robot.joint]]",
            &format!("[robot.joint_defaults]\n{defaults}\n[[robot.joint]]"),
            1,
        )
    }

    #[test]
    fn joints_keep_their_own_values() {
        let text =
            with_defaults("gear_ratio = 70.0\nnominal = { stiffness = 1.0, motor_coulomb = 0.25 }");
        let over = [
            "robot.joint.joint2.gear_ratio=14.0",
            "robot.joint_defaults.position_offset_deg=90.0",
        ];
        let over = over.map(str::to_owned);
        let robot = read("experiment.toml", &text, &over, &mut no_files)
            .unwrap()
            .robot;
        let gears: Vec<Option<f64>> = robot.joint.iter().map(|joint| joint.gear_ratio).collect();
        assert_eq!(gears, [Some(70.0), Some(14.0)]);
        let without = read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files)
            .unwrap()
            .robot;
        for (joint, alone) in robot.joint.iter().zip(&without.joint) {
            let [completed, alone] =
                [joint, alone].map(|joint| joint.nominal.all().collect::<Vec<_>>());
            assert!(alone.iter().all(|given| completed.contains(given)));
            assert!(
                completed.contains(&("motor_coulomb", 0.25)) && completed.len() == alone.len() + 1
            );
            assert!(joint.position_offset_deg.to_bits() == 90.0_f64.to_bits());
        }
    }

    #[test]
    fn another_value_than_a_table_is_refused() {
        let text = demo::EXPERIMENT.replacen("[robot]", "[robot]\njoint_defaults = 3", 1);
        let error = read("experiment.toml", &text, &[], &mut no_files).unwrap_err();
        let error = error.to_string();
        let line = 1 + text
            .lines()
            .position(|line| line == "joint_defaults = 3")
            .unwrap();
        assert!(
            error.starts_with(&format!("line {line} of experiment.toml")),
            "{error}"
        );
    }

    #[test]
    fn faults_have_their_lines() {
        for (line, part) in [
            (
                "name = \"all\"",
                "unknown key \"name\" in [robot.joint_defaults]",
            ),
            ("gear_ration = 3.0", "did you mean \"gear_ratio\"?"),
            ("gear_ratio = \"fast\"", "expected"),
            ("gear_ratio = \"FILL IN\"", "FILL IN gear_ratio"),
        ] {
            let text = with_defaults(line);
            let error = read("experiment.toml", &text, &[], &mut no_files).unwrap_err();
            let number = 1 + text.lines().position(|other| other == line).unwrap();
            let error = error.to_string();
            assert!(
                error.starts_with(&format!("line {number} of experiment.toml")),
                "{error}"
            );
            assert!(error.contains(part), "{error}");
        }
    }
}
