//! The page of `experiment.toml`, written from the JSON schema of `sprung schema`.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use serde_json::{Map, Value};

use super::{blocks, of_repository, path_in_repository};
use crate::common::sprung;

const PAGE: &str = "docs/reference/experiment.md";

/// If this variable of the environment is set, the test writes the page instead of comparing it.
/// `cargo xtask docs` sets it.
const WRITE: &str = "SPRUNG_WRITE_DOCS";

const INTRODUCTION: &str = "\
<!-- `cargo xtask docs` writes this page from the JSON schema; a test fails if it is stale. -->
# experiment.toml

One file describes the robot, the columns of the log, the identification and the validation. The name of each key ends
in its unit. sprung refuses an unknown key and names the nearest known key. `sprung schema` prints the JSON schema of the
file, for completion in editors. A key takes one number, or the values in parentheses.

The robot is described by one of `urdf`, `dh_modified`, `dh_classic` and `kinematics`.
[Logs](logs.md) describes formats, names of columns, units and clocks.

`sprung new` writes the keys that most users need; all others have values that suit most robots:
";

/// The keys that most users need, with the headings of their tables.
const FIRST_KEYS: [(&str, &str); 10] = [
    ("robot", "urdf"),
    ("robot.joint", "name"),
    ("robot.joint", "gear_ratio"),
    ("log", "file"),
    ("log", "time_s"),
    ("log", "link_position_rad"),
    ("log", "motor_position_rad"),
    ("log", "motor_torque_nm"),
    ("identify", "estimator"),
    ("validate", "log"),
];

/// Headings of the page and the definitions of the schema below them.
const SECTIONS: [(&str, &str); 23] = [
    ("robot", "Robot"),
    ("robot.joint", "Joint"),
    ("robot.joint.limits", "Limits"),
    ("robot.joint.nominal", "Nominal"),
    ("robot.joint.friction_covariates", "FrictionCovariates"),
    ("robot.joint.servo", "ServoDrive"),
    ("Row of a Denavit-Hartenberg table", "DhJoint"),
    ("log", "Log"),
    ("Table of a column", "Column"),
    ("Axes of a sensor", "AxisColumns"),
    ("Window of a file", "FileWindow"),
    ("Payload of a file", "Payload"),
    ("log.csv", "CsvForm"),
    ("identify", "Identify"),
    ("identify.physical", "Physical"),
    ("controller", "Controller"),
    ("controller.reference", "Reference"),
    ("Sine of a reference", "Sine"),
    ("validate", "Validate"),
    ("simulate", "Simulate"),
    ("excite", "Excite"),
    ("control", "Control"),
    ("The whole file", ""),
];

/// The definitions of a schema.
struct Schema {
    root: Value,
}

impl Schema {
    fn of_program() -> Self {
        let text = sprung(&["schema"]).out;
        Self {
            root: serde_json::from_str(&text).unwrap(),
        }
    }

    /// Returns a definition; the empty name is that of the whole file.
    fn definition(&self, name: &str) -> &Value {
        match name {
            "" => &self.root,
            name => &self.root["$defs"][name],
        }
    }

    fn properties(&self, name: &str) -> &Map<String, Value> {
        self.definition(name)["properties"].as_object().unwrap()
    }

    /// Describes the values that a schema allows, in words.
    fn values(&self, schema: &Value) -> Vec<String> {
        if let Some(name) = schema["$ref"].as_str() {
            let name = name.rsplit('/').next().unwrap();
            if let Some((heading, _)) = SECTIONS.iter().find(|(_, table)| *table == name) {
                return vec![format!("[table](#{})", anchor(heading))];
            }
            return self.values(self.definition(name));
        }
        if let Some(words) = schema["enum"].as_array() {
            return words.iter().map(code).collect();
        }
        if let Some(word) = schema.get("const") {
            return vec![code(word)];
        }
        if let Some(choices) = schema["anyOf"].as_array() {
            let mut all = Vec::new();
            for choice in choices {
                for value in self.values(choice) {
                    if !all.contains(&value) {
                        all.push(value);
                    }
                }
            }
            return all;
        }
        let types = match &schema["type"] {
            Value::Array(types) => types.clone(),
            one => vec![one.clone()],
        };
        let words = types.iter().filter_map(|kind| match kind.as_str() {
            Some("null") => None,
            Some("array") => {
                let items = joined(&self.values(&schema["items"]));
                Some(match items.as_str() {
                    "number" | "integer" | "text" => format!("{items}s"),
                    "numbers" => "rows of numbers".to_owned(),
                    _ => format!("list of {items}"),
                })
            }
            Some("object") if schema["additionalProperties"].is_null() => Some("table".to_owned()),
            Some("object") => {
                let values = self.values(&schema["additionalProperties"]);
                Some(format!("table of {}", joined(&values)))
            }
            Some("string") => Some("text".to_owned()),
            Some("boolean") => Some("boolean".to_owned()),
            Some("integer") => Some("integer".to_owned()),
            Some("number") => Some("number".to_owned()),
            other => panic!("unknown type {other:?} in {schema}"),
        });
        words.collect()
    }

    /// Returns the keys of a table that its schema does not contain, with their places.
    fn unknown_keys(&self, value: &toml::Value, schema: &Value, place: &str) -> Vec<String> {
        match value {
            toml::Value::Array(all) => (all.iter())
                .flat_map(|one| self.unknown_keys(one, schema, place))
                .collect(),
            toml::Value::Table(table) => {
                let Some(properties) = self.keys(schema) else {
                    return Vec::new();
                };
                let below = table.iter().flat_map(|(key, value)| {
                    let place = format!("{place}.{key}");
                    match properties.get(key) {
                        Some(schema) => self.unknown_keys(value, schema, &place),
                        None => vec![place],
                    }
                });
                below.collect()
            }
            _ => Vec::new(),
        }
    }

    /// Returns the keys of a schema that may be a table, a list of tables or nothing.
    fn keys<'a>(&'a self, schema: &'a Value) -> Option<Map<String, Value>> {
        if let Some(name) = schema["$ref"].as_str() {
            return self.keys(self.definition(name.rsplit('/').next().unwrap()));
        }
        if let Some(choices) = schema["anyOf"].as_array() {
            let all = choices.iter().filter_map(|choice| self.keys(choice));
            return all.reduce(|mut one, other| {
                one.extend(other);
                one
            });
        }
        let properties = schema["properties"].as_object().cloned();
        properties.or_else(|| schema.get("items").and_then(|items| self.keys(items)))
    }

    /// Returns the rows of a definition's keys.
    fn table(&self, name: &str) -> String {
        let required: BTreeSet<&str> = (self.definition(name)["required"].as_array().into_iter())
            .flatten()
            .filter_map(Value::as_str)
            .collect();
        let mut text = String::from("| key | meaning |\n|---|---|\n");
        for (key, schema) in self.properties(name) {
            let is_required = required.contains(key.as_str());
            text += &self.row(key, schema, is_required);
        }
        text
    }

    fn row(&self, key: &str, schema: &Value, is_required: bool) -> String {
        let mut values = self.values(schema);
        if let Some((last, others)) = values.split_last()
            && !others.is_empty()
            && *last == format!("list of {}", joined(others))
        {
            values = vec![joined(others), "list".to_owned()];
        }
        let column = "text, integer or [table](#table-of-a-column)";
        let mut values = joined(&values).replace(column, "[column](#table-of-a-column)");
        if is_required {
            values += "; required";
        } else if let Some(default) = default_of(schema) {
            write!(values, "; default {default}").unwrap();
        }
        let meaning = schema["description"].as_str().unwrap();
        let meaning = in_a_cell(meaning);
        match values.as_str() {
            "number" => format!("| `{key}` | {meaning} |\n"),
            _ => format!("| `{key}` | {meaning} ({values}) |\n"),
        }
    }

    /// Returns the whole page.
    fn page(&self) -> String {
        let mut page = INTRODUCTION.to_owned();
        let keys = FIRST_KEYS
            .map(|(heading, key)| format!("`{key}` of [{}](#{})", title(heading), anchor(heading)));
        writeln!(page, "{}.", joined(&keys).replace(" or ", " and ")).unwrap();
        for (heading, name) in SECTIONS {
            let meaning = in_a_cell(self.definition(name)["description"].as_str().unwrap());
            let (title, table) = (title(heading), self.table(name));
            write!(page, "\n## {title}\n\n{meaning}\n\n{table}").unwrap();
        }
        page
    }
}

/// Pages with parts of an experiment file.
const PAGES_WITH_PARTS: [&str; 11] = [
    "docs/gallery/README.md",
    "docs/reference/logs.md",
    "docs/how-to/no-link-encoder.md",
    "docs/how-to/current-and-gears.md",
    "docs/how-to/raw-counts.md",
    "docs/how-to/ros2-bag.md",
    "docs/how-to/several-logs.md",
    "docs/how-to/servos.md",
    "docs/how-to/covariates.md",
    "docs/how-to/inertial-sensors.md",
    "docs/how-to/torque-sensor.md",
];

/// Returns a heading as it is printed: tables of the file are code.
fn title(heading: &str) -> String {
    match heading {
        "validate" | "robot.joint" => format!("`[[{heading}]]`"),
        _ if heading.starts_with(char::is_lowercase) => format!("`[{heading}]`"),
        _ => heading.to_owned(),
    }
}

/// Returns the anchor that a heading gets.
fn anchor(heading: &str) -> String {
    let letters = heading.to_lowercase().replace('.', "");
    letters.replace(' ', "-")
}

fn code(value: &Value) -> String {
    format!("`{value}`")
}

fn joined(values: &[String]) -> String {
    match values {
        [one] => one.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
        [] => String::new(),
    }
}

/// Returns the default of a key, unless it is empty.
fn default_of(schema: &Value) -> Option<String> {
    let default = schema.get("default")?;
    let is_empty = default.is_null()
        || default.as_array().is_some_and(Vec::is_empty)
        || default.as_object().is_some_and(Map::is_empty);
    (!is_empty).then(|| code(default))
}

/// Joins the lines of a description, without characters that end a cell.
fn in_a_cell(text: &str) -> String {
    text.replace('\n', " ").replace('|', "\\|")
}

#[test]
fn every_table_of_the_schema_has_a_section() {
    let schema = Schema::of_program();
    for (name, definition) in schema.root["$defs"].as_object().unwrap() {
        let has_keys = definition.get("properties").is_some();
        let has_section = SECTIONS.iter().any(|(_, table)| table == name);
        assert_eq!(has_keys, has_section, "{name}");
    }
}

/// Compares a page with the program, or writes it.
pub(super) fn same_or_written(file: &str, page: String) {
    let path = path_in_repository(file);
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(path, page).unwrap();
        return;
    }
    let present = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        present == page,
        "{file} is stale: run cargo xtask docs.\n{}",
        page.lines()
            .zip(present.lines())
            .find(|(one, other)| one != other)
            .map_or_else(String::new, |(new, old)| format!("new: {new}\nold: {old}"))
    );
}

#[test]
fn the_page_is_that_of_the_schema() {
    same_or_written(PAGE, Schema::of_program().page());
}

#[test]
fn parts_of_the_file_on_other_pages_have_known_keys() {
    let schema = Schema::of_program();
    let faults = |text: &str| {
        let table: toml::Table = text.parse().unwrap_or_else(|e| panic!("{e}: {text}"));
        let is_whole = table
            .keys()
            .any(|key| schema.properties("").contains_key(key));
        // A part without the name of a table is one of the log.
        let definition = schema.definition(if is_whole { "" } else { "Log" });
        schema.unknown_keys(&toml::Value::Table(table), definition, "")
    };
    for page in PAGES_WITH_PARTS {
        let text = of_repository(page);
        // A block in a list is indented.
        let text: Vec<&str> = text.lines().map(str::trim_start).collect();
        let parts = blocks(&text.join("\n"), "toml");
        assert!(!parts.is_empty(), "{page}");
        for part in parts {
            assert_eq!(faults(&part), Vec::<String>::new(), "{page}: {part}");
        }
    }
    assert_eq!(faults("[log]\nfile = { pth = \"a\" }"), [".log.file.pth"]);
    assert_eq!(faults("motor_positon = \"a\""), [".motor_positon"]);
    assert_eq!(faults("[[robot.joint]]\ngear = 1"), [".robot.joint.gear"]);
}
