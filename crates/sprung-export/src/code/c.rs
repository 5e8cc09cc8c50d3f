//! C99.

use std::fmt::Write;

use super::control::Control;
use super::emit::{Language, comment, element, identifier, is_zero, unused};
use super::graph::Function;
use super::memory::Memory;
use super::observer::Observed;
use super::proof::Vector;
use super::trace::{Array, Shape, Traced};
use crate::model::Parameter;

/// The template of functions that loop over joints. `@` stands for the prefix, `§` for the prefix of
/// macros.
const LOOPS: &str = include_str!("templates/loops.c");

/// The template of the header.
const HEADER: &str = include_str!("templates/header.h");

/// The template of the self-test.
const TEST: &str = include_str!("templates/test.c");

/// Templates of the controller.
const CONTROLLER_HEADER: &str = include_str!("templates/controller.h");
const CONTROLLER: &str = include_str!("templates/controller.c");
const CONTROLLER_TEST: &str = include_str!("templates/controller_test.c");
const COMMAND_OF_STATE: &str = include_str!("templates/command_state.c");
const COMMAND_OF_PD: &str = include_str!("templates/command_pd.c");
const FEEDFORWARD_TEST: &str = include_str!("templates/feedforward_test.c");

/// Templates of the memory.
const MEMORY_HEADER: &str = include_str!("templates/memory.h");
const MEMORY: &str = include_str!("templates/memory.c");
const MEMORY_TEST: &str = include_str!("templates/memory_test.c");

/// Templates of the observer.
const OBSERVER_HEADER: &str = include_str!("templates/observer.h");
const OBSERVER: &str = include_str!("templates/observer.c");
const OBSERVER_TEST: &str = include_str!("templates/observer_test.c");

const C: Language = Language {
    declare: "const @real",
    number: |digits| format!("R({digits})"),
    call,
    row_of: |numbers| format!("    {{{numbers}}},\n"),
    move_elements: |first, position, widths| {
        format!(
            "    {{\n        const @real widths[6] = {{{widths}}};\n        slide(own, {first}, {position}, widths);\n    }}\n"
        )
    },
    observed: |name, has_elements| {
        let elements = if has_elements {
            " own->memory.elements,"
        } else {
            ""
        };
        format!(
            "@{name}(motion[0][0], motion[0][1], motion[0][2],\n        motion[1][0], motion[1][1], motion[1][2],{elements} link_nm, motor_nm);"
        )
    },
    memory: &[
        ("%MEMORY_FIELD%", "    struct @memory memory;\n"),
        (
            "%REMEMBER%",
            "    @remember(&own->memory, motion[0][0], motion[1][0]);\n",
        ),
        (
            "%FORGET%",
            "        for (i = 0; i < 12 * §JOINTS; i++) {\n            own->memory.elements[i] = R(0.0);\n        }\n        own->memory.has_begun = 0;\n",
        ),
    ],
    memory_of_control: &[
        ("%MEMORY_FIELD%", "    struct @memory memory;\n"),
        (
            "%FORGET%",
            "    for (i = 0; i < 12 * §JOINTS; i++) {\n        own->memory.elements[i] = R(0.0);\n    }\n    own->memory.has_begun = 0;\n",
        ),
        ("%MEMORY_PARAMETER%", "struct @memory *memory, "),
        ("%MEMORY_ARGUMENT%", "&own->memory, "),
        ("%ELEMENTS_ARGUMENT%", " memory->elements,"),
        ("%REMEMBER%", "    @remember(memory, shaped, phi_d);\n"),
        ("%ELEMENTS_SIZE%", " + 12 * §JOINTS"),
        ("%TESTED_ELEMENTS%", " desired + §DESIRED,"),
    ],
    sensors: &[
        (
            "%SENSOR_NOTE%",
            " sensor_nm has the readings\n * of the torque sensors; those of other joints are not read.",
        ),
        (
            "%SENSOR_PARAMETER%",
            "\n    const @real sensor_nm[§JOINTS],",
        ),
        ("%SENSOR_ARGUMENT%", " at->sensor_nm,"),
        ("%SENSOR_CHAIN%", ", sensor[§JOINTS]"),
        (
            "%SENSOR_CONSTANTS%",
            "\n/* Torque sensors, and their readings without torque. */\nstatic const int has_sensor[§JOINTS] = {%HAS_SENSOR%};\nstatic const @real sensor_offset_nm[§JOINTS] = {%SENSOR_OFFSET%};\n",
        ),
        (
            "%SENSOR_FILTER%",
            "        if (has_sensor[i]) {\n            filter(&own->sensor[i], continuous, sensor_nm[i], begins);\n        }\n",
        ),
    ],
    spring: "has_sensor[i] ? own->sensor[i].output[2] - sensor_offset_nm[i] : R(0.0)",
    truths: ["0", "1"],
    comment: " * ",
    element_of: |rows| {
        let rows: Vec<String> = rows
            .iter()
            .map(|row| format!("        {{{row}}},"))
            .collect();
        format!("    {{\n{}\n    }},\n", rows.join("\n"))
    },
    commands: [COMMAND_OF_STATE, COMMAND_OF_PD],
    tests: [CONTROLLER_TEST, FEEDFORWARD_TEST],
};

fn call(function: Function, x: &str) -> String {
    match function {
        Function::Neg => format!("-{x}"),
        Function::Sin => format!("SIN({x})"),
        Function::Cos => format!("COS({x})"),
        Function::Exp => format!("EXP({x})"),
        Function::Tanh => format!("TANH({x})"),
        Function::Ln => format!("LOG({x})"),
        Function::Recip => format!("inverse_of({x})"),
        Function::Abs => format!("FABS({x})"),
        Function::IsForward => format!("({x} >= R(0.0) ? R(1.0) : R(0.0))"),
    }
}

/// A robot as code.
pub(super) struct Program<'a> {
    pub(super) name: &'a str,
    /// Lines of the origin.
    pub(super) origin: &'a [String],
    pub(super) joints: &'a [String],
    /// Parameters of the regressor, and their values.
    pub(super) parameters: &'a [Parameter],
    pub(super) theta: &'a [f64],
    /// Number of rows of the regressor.
    pub(super) rows: usize,
    pub(super) traced: &'a [Traced],
    /// Reciprocal of the inertia of the rotor of each flexible joint; zero at rigid joints.
    pub(super) inverse_rotors: &'a [f64],
    pub(super) vectors: &'a [Vector],
    pub(super) memory: Option<&'a Memory>,
    pub(super) control: Option<&'a Control<'a>>,
    pub(super) observer: Option<&'a Observed<'a>>,
}

impl Program<'_> {
    /// Returns a line for each parameter.
    pub(super) fn parameter_lines(&self, begin: &str) -> String {
        let mut text = String::new();
        for (i, parameter) in self.parameters.iter().enumerate() {
            let _ = writeln!(
                text,
                "{begin}{i}: {}, {}",
                comment(&parameter.name),
                parameter.unit
            );
        }
        text
    }
}

/// Returns the header, the code and the self-test.
pub(super) fn write(program: &Program<'_>) -> [String; 3] {
    let prefix = identifier(program.name);
    let n = program.joints.len();
    let filled = |template: &str| {
        let macros = prefix.to_ascii_uppercase();
        template
            .replace('@', &format!("{prefix}_"))
            .replace('§', &format!("{macros}_"))
    };
    let head = origin(program.origin);
    let mut declarations = String::new();
    let mut code = String::new();
    for traced in program.traced {
        let signature = signature(traced);
        let _ = writeln!(declarations, "/* {} */\n{signature};\n", traced.about);
        let _ = writeln!(code, "{signature}\n{{");
        for name in unused(traced) {
            let _ = writeln!(code, "    (void){name};");
        }
        let (statements, results) = C.body(traced);
        for statement in statements {
            let _ = writeln!(code, "    {statement}");
        }
        let sparse = (traced.outputs.iter()).find(|array| array.shape == Shape::Regressor);
        if let Some(Array { name, .. }) = sparse {
            let length = length(Shape::Regressor);
            let _ = write!(
                code,
                "    for (int i = 0; i < {length}; i++) {{\n        {name}[i] = R(0.0);\n    }}\n"
            );
        }
        for (at, result) in results.iter().enumerate() {
            if sparse.is_none() || !is_zero(traced.results[at]) {
                let _ = writeln!(code, "    {} = {result};", element(&traced.outputs, at));
            }
        }
        code.push_str("}\n\n");
    }
    let mut joints = String::new();
    for (i, name) in program.joints.iter().enumerate() {
        let _ = writeln!(joints, " *   {i}: {}", comment(name));
    }
    let mut parts = memory(program.memory);
    for more in [controller(program.control), observer(program.observer)] {
        for (part, more) in parts.iter_mut().zip(more) {
            part.push_str(&more);
        }
    }
    let [of_header, of_code, of_test] = parts;
    let [mut check, mut measure] = match program.control {
        Some(control) if control.motions.is_empty() => {
            ["    check_controller();\n", "    measure_controller();\n"]
        }
        Some(_) => [
            "    check_feedforward();\n    check_controller();\n",
            "    measure_controller();\n",
        ],
        None => [""; 2],
    }
    .map(str::to_owned);
    if program.memory.is_some() {
        check.push_str("    check_memory();\n");
    }
    if program.observer.is_some() {
        check.push_str("    check_observer();\n");
        measure.push_str("    measure_observer();\n");
    }
    let header_lines = (program.control).map_or_else(String::new, |control| control.header(&C));
    let header = filled(HEADER)
        .replace("%CONTROLLER%", &filled(&of_header))
        .replace("%JOINTS%", &joints)
        .replace("%N%", &n.to_string())
        .replace("%ROWS%", &program.rows.to_string())
        .replace("%PARAMETERS%", &program.parameters.len().to_string())
        .replace("%NAMES%", &program.parameter_lines(" *   "))
        .replace("%FUNCTIONS%", &filled(&declarations))
        .replace("%HEADER%", &header_lines);
    let loops = filled(LOOPS)
        .replace("%INVERSE_ROTORS%", &C.constants(program.inverse_rotors))
        .replace("%THETA%", &C.lines(program.theta))
        .replace("%CONTROLLER%", &filled(&of_code))
        .replace("%FUNCTIONS%", &filled(&code));
    let test = filled(TEST)
        .replace("%CONTROLLER%", &filled(&of_test))
        .replace("%CHECK%", &check)
        .replace("%MEASURE%", &measure)
        .replace("%COUNT%", &program.vectors.len().to_string())
        .replace(
            "%VECTORS%",
            &C.elements(program.vectors.iter().map(Vector::all)),
        );
    [header, loops, test].map(|text| format!("{head}{text}"))
}

/// Returns the parts of the header, of the code and of the self-test for a controller.
fn controller(control: Option<&Control<'_>>) -> [String; 3] {
    let Some(control) = control else {
        return <[String; 3]>::default();
    };
    let [test, of_feedforward] = control.tests(&C);
    let [header, code] = [CONTROLLER_HEADER, CONTROLLER].map(|part| control.filled(&C, part));
    [header, code, test.replace("%FEEDFORWARD%", &of_feedforward)]
}

/// Returns the parts of the header, of the code and of the self-test for a memory.
fn memory(memory: Option<&Memory>) -> [String; 3] {
    memory.map_or_else(Default::default, |memory| {
        [MEMORY_HEADER, MEMORY, MEMORY_TEST].map(|part| memory.filled(&C, part))
    })
}

/// Returns the parts of the header, of the code and of the self-test for an observer.
fn observer(observer: Option<&Observed<'_>>) -> [String; 3] {
    let Some(observer) = observer else {
        return <[String; 3]>::default();
    };
    let period = format!("{:?}", observer.settings.period_s);
    let header = OBSERVER_HEADER.replace("%PERIOD%", &period);
    [&header, OBSERVER, OBSERVER_TEST].map(|part| observer.filled(&C, part))
}

fn origin(lines: &[String]) -> String {
    let mut text = "/*\n".to_owned();
    for line in lines {
        let _ = writeln!(text, " * {}", comment(line));
    }
    text.push_str(" */\n");
    text
}

fn signature(traced: &Traced) -> String {
    let array = |array: &Array, constant: &str| {
        format!("{constant}@real {}[{}]", array.name, length(array.shape))
    };
    let inputs = traced.inputs.iter().map(|input| array(input, "const "));
    let outputs = traced.outputs.iter().map(|output| array(output, ""));
    let all: Vec<String> = inputs.chain(outputs).collect();
    format!("void @{}({})", traced.name, all.join(",\n    "))
}

fn length(shape: Shape) -> &'static str {
    match shape {
        Shape::Vector => "§JOINTS",
        Shape::Matrix => "§JOINTS * §JOINTS",
        Shape::Elements => "12 * §JOINTS",
        Shape::Regressor => "§ROWS * §PARAMETERS",
    }
}
