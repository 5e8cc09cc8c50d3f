//! Rust without a standard library.

use std::fmt::Write;

use super::c::Program;
use super::control::Control;
use super::emit::{Language, calls, comment, is_zero, unused};
use super::graph::Function;
use super::memory::Memory;
use super::observer::Observed;
use super::proof::Vector;
use super::trace::{Array, Shape, Traced};

/// The template of the file.
const FILE: &str = include_str!("templates/robot.rs.txt");

/// Templates of the controller.
const CONTROLLER: &str = include_str!("templates/controller.rs.txt");
const CONTROLLER_TEST: &str = include_str!("templates/controller_test.rs.txt");
const COMMAND_OF_STATE: &str = include_str!("templates/command_state.rs.txt");
const COMMAND_OF_PD: &str = include_str!("templates/command_pd.rs.txt");
const FEEDFORWARD_TEST: &str = include_str!("templates/feedforward_test.rs.txt");

/// Templates of the memory.
const MEMORY: &str = include_str!("templates/memory.rs.txt");
const MEMORY_TEST: &str = include_str!("templates/memory_test.rs.txt");

/// Templates of the observer.
const OBSERVER: &str = include_str!("templates/observer.rs.txt");
const OBSERVER_TEST: &str = include_str!("templates/observer_test.rs.txt");

const RUST: Language = Language {
    declare: "let",
    number: str::to_owned,
    call,
    row_of: |numbers| format!("    [{numbers}],\n"),
    move_elements: |first, position, widths| {
        format!("        self.slide({first}, {position}, &[{widths}]);\n")
    },
    observed: |name, has_elements| {
        let elements = if has_elements {
            ", &self.memory.elements"
        } else {
            ""
        };
        format!("{name}::<F>(q, dq, ddq, phi, dphi, ddphi{elements})")
    },
    memory: &[
        ("%MEMORY_FIELD%", "\n    memory: Memory,"),
        ("%MEMORY_EMPTY%", "\n            memory: Memory::new(),"),
        (
            "%REMEMBER%",
            "        self.memory.remember(&motion[0][0], &motion[1][0]);\n",
        ),
        ("%FORGET%", "        own.memory = Memory::new();\n"),
    ],
    memory_of_control: &[
        ("%MEMORY_FIELD%", "    memory: Memory,\n"),
        ("%MEMORY_EMPTY%", "            memory: Memory::new(),\n"),
        ("%FORGET%", "    own.memory = Memory::new();\n"),
        ("%MEMORY_PARAMETER%", "memory: &mut Memory, "),
        ("%MEMORY_ARGUMENT%", "&mut own.memory, "),
        ("%ELEMENTS_ARGUMENT%", ", &memory.elements"),
        ("%REMEMBER%", "    memory.remember(q_d, &phi_d);\n"),
        (
            "%TESTED_ELEMENTS%",
            ", core::convert::TryFrom::try_from(&wanted[5 * JOINTS..]).unwrap()",
        ),
    ],
    sensors: &[
        (
            "%SENSOR_NOTE%",
            "\n///\n/// - `sensor_nm`: readings of the torque sensors; those of other joints are not read.",
        ),
        ("%SENSOR_PARAMETER%", "\n    sensor_nm: &Vector,"),
        ("%SENSOR_ARGUMENT%", ", &vector(sample[3])"),
        ("%SENSOR_FIELD%", "\n    sensor: [Chain; JOINTS],"),
        (
            "%SENSOR_EMPTY%",
            "\n            sensor: [Chain::EMPTY; JOINTS],",
        ),
        (
            "%SENSOR_CONSTANTS%",
            "\n/// Torque sensors, and their readings without torque.\nconst HAS_SENSOR: [bool; JOINTS] = [%HAS_SENSOR%];\nconst SENSOR_OFFSET_NM: Vector = [%SENSOR_OFFSET%];\n",
        ),
        (
            "%SENSOR_FILTER%",
            "        if HAS_SENSOR[i] {\n            own.sensor[i].filter(&CONTINUOUS, sensor_nm[i], begins);\n        }\n",
        ),
    ],
    spring: "if HAS_SENSOR[i] { own.sensor[i].output[2] - SENSOR_OFFSET_NM[i] } else { 0.0 }",
    truths: ["false", "true"],
    comment: "/// ",
    element_of: |rows| {
        let rows: Vec<String> = rows.iter().map(|row| format!("&[{row}]")).collect();
        let rows = rows.join(",\n            ");
        format!("        [\n            {rows},\n        ],\n")
    },
    commands: [COMMAND_OF_STATE, COMMAND_OF_PD],
    tests: [CONTROLLER_TEST, FEEDFORWARD_TEST],
};

fn call(function: Function, x: &str) -> String {
    match function {
        Function::Neg => format!("-{x}"),
        Function::Sin | Function::Cos | Function::Exp | Function::Tanh | Function::Ln => {
            format!("F::{}({x})", name(function))
        }
        Function::Recip => format!("inverse_of({x})"),
        Function::Abs => format!("if {x} < 0.0 {{ -{x} }} else {{ {x} }}"),
        Function::IsForward => format!("if {x} >= 0.0 {{ 1.0 }} else {{ 0.0 }}"),
    }
}

/// Returns the name of a function that the caller gives, as the standard library has it; empty for
/// others.
fn name(function: Function) -> &'static str {
    match function {
        Function::Sin => "sin",
        Function::Cos => "cos",
        Function::Exp => "exp",
        Function::Tanh => "tanh",
        Function::Ln => "ln",
        Function::Neg | Function::Recip | Function::Abs | Function::IsForward => "",
    }
}

/// The square root, for the thresholds of an observer.
const SQRT: &str = "sqrt";

/// Returns the file.
pub(super) fn write(program: &Program<'_>) -> String {
    let mut text = String::new();
    for line in program.origin {
        let _ = writeln!(text, "// {}", comment(line));
    }
    let mut joints = String::new();
    for (i, name) in program.joints.iter().enumerate() {
        let _ = writeln!(joints, "//!   {i}: {}", comment(name));
    }
    let mut names: Vec<&str> = (calls(program.traced).into_iter())
        .map(name)
        .filter(|name| !name.is_empty())
        .collect();
    let of_observer = [name(Function::Tanh), SQRT].into_iter();
    for more in of_observer.filter(|_| program.observer.is_some()) {
        if !names.contains(&more) {
            names.push(more);
        }
    }
    let functions =
        |line: fn(&str) -> String| -> String { names.iter().map(|name| line(name)).collect() };
    let declared = functions(|name| format!("    fn {name}(x: Real) -> Real;\n"));
    let given = functions(|name| {
        format!("        fn {name}(x: Real) -> Real {{\n            x.{name}()\n        }}\n")
    });
    let code: String = program.traced.iter().map(function).collect();
    let vectors = RUST.elements(program.vectors.iter().map(Vector::all));
    let mut parts = memory(program.memory);
    for more in [controller(program.control), observer(program.observer)] {
        for (part, more) in parts.iter_mut().zip(more) {
            part.push_str(&more);
        }
    }
    let [controller, check] = parts;
    let header = (program.control).map_or_else(String::new, |control| control.header(&RUST));
    text += &FILE
        .replace("%CONTROLLER%", &controller)
        .replace("%CHECK%", &check)
        .replace("%JOINTS%", &joints)
        .replace("%N%", &program.joints.len().to_string())
        .replace("%ROWS%", &program.rows.to_string())
        .replace("%PARAMETERS%", &program.parameters.len().to_string())
        .replace("%NAMES%", &program.parameter_lines("/// - "))
        .replace("%THETA%", &RUST.lines(program.theta))
        .replace("%DECLARED%", &declared)
        .replace("%INVERSE_ROTORS%", &RUST.constants(program.inverse_rotors))
        .replace("%FUNCTIONS%", &code)
        .replace("%GIVEN%", &given)
        .replace("%COUNT%", &program.vectors.len().to_string())
        .replace("%VECTORS%", &vectors)
        .replace("%HEADER%", &header);
    text
}

/// Returns the code and the test of a controller.
fn controller(control: Option<&Control<'_>>) -> [String; 2] {
    control.map_or_else(Default::default, |control| {
        [
            control.filled(&RUST, CONTROLLER),
            control.tests(&RUST).concat(),
        ]
    })
}

/// Returns the code and the test of a memory.
fn memory(memory: Option<&Memory>) -> [String; 2] {
    memory.map_or_else(Default::default, |memory| {
        [MEMORY, MEMORY_TEST].map(|part| memory.filled(&RUST, part))
    })
}

/// Returns the code and the test of an observer.
fn observer(observer: Option<&Observed<'_>>) -> [String; 2] {
    observer.map_or_else(Default::default, |observer| {
        [OBSERVER, OBSERVER_TEST].map(|part| observer.filled(&RUST, part))
    })
}

fn function(traced: &Traced) -> String {
    let kind = |array: &Array| match array.shape {
        Shape::Vector => "Vector",
        Shape::Matrix => "Matrix",
        Shape::Elements => "Elements",
        Shape::Regressor => "Regressor",
    };
    let inputs: Vec<String> = (traced.inputs.iter())
        .map(|array| format!("{}: &{}", array.name, kind(array)))
        .collect();
    let joined = |values: Vec<String>| match values.as_slice() {
        [one] => one.clone(),
        _ => format!("({})", values.join(", ")),
    };
    let outputs = traced.outputs.iter();
    let kinds = outputs
        .clone()
        .map(|array| kind(array).to_owned())
        .collect();
    let names: Vec<&str> = outputs.clone().map(|array| array.name).collect();
    let (statements, results) = RUST.body(traced);
    let mut text = format!(
        "/// {}\n///\n/// Returns {}.\npub fn {}<F: Functions>({}) -> {} {{\n",
        traced.about,
        names.join(" and "),
        traced.name,
        inputs.join(", "),
        joined(kinds),
    );
    for name in unused(traced) {
        let _ = writeln!(text, "    let _ = {name};");
    }
    for statement in statements {
        let _ = writeln!(text, "    {statement}");
    }
    let mut at = 0;
    let arrays = outputs
        .map(|array| {
            let range = at..at + array.length;
            at += array.length;
            if array.shape != Shape::Regressor {
                return format!("[{}]", results[range].join(", "));
            }
            let name = array.name;
            let _ = writeln!(text, "    let mut {name} = [0.0; ROWS * PARAMETERS];");
            for i in range.filter(|i| !is_zero(traced.results[*i])) {
                let result = results[i].trim_matches(['(', ')']);
                let _ = writeln!(text, "    {name}[{i}] = {result};");
            }
            name.to_owned()
        })
        .collect();
    let _ = writeln!(text, "    {}\n}}\n", joined(arrays));
    text
}
