use std::path::Path;

use sprung_core::parameters::JointParameter;
use sprung_testing::Messages;

use super::*;
use crate::{Columns, DescriptionError, Experiment, read, schema};

const MIXED: &str = r#"<robot name="gantry &quot;A&quot; \ 2">
<link name="base"/><link name="sled"/><link name="arm"/><link name="tip"/><link name="finger"/>
<joint name="slide" type="prismatic"><parent link="base"/><child link="sled"/>
  <limit lower="-0.5" upper="1.25" effort="800" velocity="0"/></joint>
<joint name="elbow.1" type="revolute"><parent link="sled"/><child link="arm"/>
  <limit lower="-3.14159265" upper="3.14159265" effort="1e30" velocity="2.5"/></joint>
<joint name="roll" type="continuous"><parent link="arm"/><child link="tip"/></joint>
<joint name="grip" type="revolute"><parent link="tip"/><child link="finger"/>
  <mimic joint="roll"/></joint>
</robot>"#;

fn mixed() -> Start {
    let urdf = Urdf::parse("gantry.urdf", MIXED).unwrap();
    Start::urdf(&urdf, "../a folder/gantry.urdf").unwrap()
}

/// Returns a template with a log, and with the example of the table in place of the table.
fn filled(text: &str) -> String {
    let text = text.replace("file = \"FILL IN\"", "file = \"log.csv\"");
    let Some((head, table)) = text.split_once("dh_modified = \"FILL IN\"\n") else {
        return text;
    };
    let (table, rest) = table.split_once("#]\n").unwrap();
    let table: Vec<&str> = table.lines().map(|line| &line[1..]).collect();
    format!("{head}{}\n]\n{rest}", table.join("\n"))
}

fn accept(text: &str) -> Result<Experiment, DescriptionError> {
    let text = &filled(text);
    read("experiment.toml", text, &[], &mut |path: &Path| {
        assert_eq!(path, Path::new("../a folder/gantry.urdf"));
        Ok(MIXED.to_owned())
    })
}

/// Whether a line is a commented example, and not an explanation.
fn is_example(line: &str) -> bool {
    line.starts_with("#  ") || (line.len() > 1 && line.starts_with('#') && !line.starts_with("# "))
}

/// Returns the text with the selected examples uncommented.
fn with(text: &str, wanted: impl Fn(&str) -> bool) -> String {
    let lines = text.lines().map(|line| {
        if is_example(line) && wanted(line) {
            &line[1..]
        } else {
            line
        }
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn key(line: &str) -> &str {
    line.trim_start_matches('#')
        .split([' ', '='])
        .next()
        .unwrap_or(line)
}

/// Examples that replace other lines.
const ALTERNATIVES: [(&str, &[&str]); 5] = [
    ("link_position_deg", &["link_position_rad"]),
    ("link_deflection_rad", &["link_position_rad"]),
    ("motor_position_deg", &["motor_position_rad"]),
    ("motor_current_a", &["motor_torque_nm", "motor_force_n"]),
    ("transmission_matrix", &["gear_ratio"]),
];

fn replaces(line: &str) -> bool {
    ALTERNATIVES
        .iter()
        .any(|(instead, _)| *instead == key(line))
}

#[test]
fn an_unfilled_place_is_an_error_with_its_line() {
    let mut messages = Messages::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/messages/unfilled_places.txt"
    ));
    let table = Start::table(2).unwrap();
    for (case, start, key) in [
        ("a robot by URDF", mixed(), "file = "),
        ("a table", table, "dh_modified = "),
    ] {
        let text = template(&start);
        let line = text.lines().position(|line| line.starts_with(key));
        let error = read("experiment.toml", &text, &[], &mut |_: &Path| {
            Ok(MIXED.to_owned())
        });
        let error = error.unwrap_err().to_string();
        // The number of the line changes with every line of the template.
        let place = format!("line {} of ", 1 + line.unwrap());
        let rest = error.strip_prefix(&place);
        messages.note(case, rest.unwrap_or_else(|| panic!("{error}")));
    }
    messages.compare();
}

#[test]
fn tables_are_accepted_with_their_example() {
    for joints in [1, 2, 7, MAX_TABLE_ROWS] {
        let experiment = accept(&template(&Start::table(joints).unwrap())).unwrap();
        let robot = &experiment.robot;
        assert_eq!(robot.joint.len(), joints);
        assert_eq!(robot.joint[joints - 1].name, format!("joint{joints}"));
        assert_eq!(robot.dh_modified.as_ref().unwrap().len(), joints);
        assert_eq!(experiment.validate[0].name, "same log");
        assert!(experiment.controller.is_none() && experiment.simulate.is_none());
    }
}

#[test]
fn joints_keep_the_order_of_the_urdf_and_columns_are_split_by_kind() {
    let experiment = accept(&template(&mixed())).unwrap();
    let robot = &experiment.robot;
    assert_eq!(robot.name, "gantry \"A\" \\ 2");
    let names: Vec<&str> = robot.joint.iter().map(|joint| &*joint.name).collect();
    assert_eq!(names, ["slide", "elbow.1", "roll"]);
    let log = experiment.log.unwrap();
    let list = |list: Option<Columns>| {
        let list = list.unwrap();
        let names: Vec<String> = (0..list.0.len()).map(|i| list.label(i, "")).collect();
        names.join(" ")
    };
    assert_eq!(list(log.link_position_m), "q1_m");
    assert_eq!(list(log.link_position_rad), "q2_rad q3_rad");
    assert_eq!(list(log.motor_position_m), "phi1_m");
    assert_eq!(list(log.motor_position_rad), "phi2_rad phi3_rad");
    assert_eq!(list(log.motor_force_n), "f1_n");
    assert_eq!(list(log.motor_torque_nm), "tau2_nm tau3_nm");
}

#[test]
fn limits_in_the_urdf_become_comments() {
    let text = template(&mixed());
    assert!(
        text.contains("# The URDF allows -0.5 to 1.25 m, 800 N.\n"),
        "{text}"
    );
    assert!(
        text.contains("# The URDF allows -3.1416 to 3.1416 rad, 2.5 rad/s.\n"),
        "{text}"
    );
    assert_eq!(text.matches("The URDF allows").count(), 2);
}

#[test]
fn all_examples_are_accepted_together() {
    for start in [Start::table(1), Start::table(2), Ok(mixed())] {
        let text = filled(&template(&start.unwrap()));
        let all = with(&text, |line| !replaces(line));
        let experiment = accept(&all).unwrap_or_else(|error| panic!("{error} in\n{all}"));
        assert!(experiment.controller.is_some() && experiment.simulate.is_some());
        assert_eq!(experiment.validate.len(), 2);
        assert_eq!(experiment.robot.assume_zero.len(), 1);
        assert!(
            experiment.robot.joint[0]
                .nominal
                .get(JointParameter::Stiffness)
                .is_some()
        );
    }
}

#[test]
fn examples_of_other_columns_take_the_place_of_a_line() {
    let text = filled(&template(&Start::table(2).unwrap()));
    for (instead, replaced) in ALTERNATIVES {
        let all = with(&text, |line| !replaces(line) || key(line) == instead);
        let kept = all.lines().filter(|line| !replaced.contains(&key(line)));
        let changed = kept.collect::<Vec<_>>().join("\n");
        // Both lines together are refused, so the example is a true alternative.
        assert!(accept(&all).is_err(), "{instead}");
        // The columns of these two keys no longer exist.
        let changed = changed
            .replace("sign = {", "#sign = {")
            .replace("delay_s = {", "#delay_s = {");
        assert!(
            changed
                .lines()
                .any(|line| key(line) == instead && !line.starts_with('#'))
        );
        accept(&changed).unwrap_or_else(|error| panic!("{error} in\n{changed}"));
    }
}

#[test]
fn every_key_is_in_the_schema() {
    let schema = schema().to_string();
    for line in template(&mixed()).lines() {
        let key = key(line);
        if line.starts_with(|c: char| c.is_alphabetic()) || line.starts_with(&format!("#{key} =")) {
            assert!(schema.contains(&format!("\"{key}\":")), "{line}");
        }
    }
}

#[test]
fn lines_fit_a_terminal() {
    for start in [Start::table(2).unwrap(), mixed()] {
        for line in template(&start).lines() {
            assert!(line.chars().count() <= 100, "{line}");
        }
    }
}

#[test]
fn special_characters_in_names_are_escaped_or_refused() {
    let named = |robot: &str, joint: &str| {
        let text = MIXED
            .replace("gantry &quot;A&quot; \\ 2", robot)
            .replace("elbow.1", joint);
        Urdf::parse("gantry.urdf", &text).unwrap()
    };
    let urdf = named("a&#10;b&#x7f;c'\u{e9}", "elbow.1");
    let start = Start::urdf(&urdf, "../a folder/gantry.urdf").unwrap();
    let text = template(&start);
    assert_eq!(accept(&text).unwrap().robot.name, "a\nb\u{7f}c'\u{e9}");
    let error = Start::urdf(&named("r", "arm/elbow"), "gantry.urdf").unwrap_err();
    assert_eq!(
        error.to_string(),
        "the name \"arm/elbow\" must consist of letters, digits, spaces, \"_\", \"-\" and \".\"; \
         rename the joint in gantry.urdf"
    );
}

#[test]
fn a_table_has_between_1_and_32_rows() {
    for joints in [0, MAX_TABLE_ROWS + 1] {
        let error = Start::table(joints).unwrap_err().to_string();
        assert_eq!(
            error,
            format!("a table can be written for 1 to 32 joints, not for {joints}")
        );
    }
}
