//! C99.

use std::fmt::Write;

use super::control::{Control, FAR, about_control};
use super::emit::{Language, comment, element, identifier, is_zero, unused};
use super::graph::Function;
use super::observer::Observed;
use super::proof::Vector;
use super::trace::{Array, Shape, Traced};
use crate::description::ControllerKind;
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

/// Templates of the observer.
const OBSERVER_HEADER: &str = include_str!("templates/observer.h");
const OBSERVER: &str = include_str!("templates/observer.c");
const SLIDE: &str = include_str!("templates/slide.c");
const OBSERVER_TEST: &str = include_str!("templates/observer_test.c");

const C: Language = Language {
    declare: "const @real",
    number: |digits| format!("R({digits})"),
    call,
    row_of: |numbers| format!("    {{{numbers}}},\n"),
    move_elements: |first, joint, is_of_spring, widths| {
        let position = if is_of_spring {
            format!("motion[1][0][{joint}] - motion[0][0][{joint}]")
        } else {
            format!("motion[1][0][{joint}]")
        };
        format!(
            "    {{\n        const @real widths[6] = {{{widths}}};\n        slide(own, {first}, {position}, widths);\n    }}\n"
        )
    },
    observed: |name, has_elements| {
        let elements = if has_elements { " own->elements," } else { "" };
        format!(
            "@{name}(motion[0][0], motion[0][1], motion[0][2],\n        motion[1][0], motion[1][1], motion[1][2],{elements} link_nm, motor_nm);"
        )
    },
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
    let mut parts = controller(program.control);
    for (part, more) in parts.iter_mut().zip(observer(program.observer)) {
        part.push_str(&more);
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
    if program.observer.is_some() {
        check.push_str("    check_observer();\n");
        measure.push_str("    measure_observer();\n");
    }
    let header = filled(HEADER)
        .replace("%CONTROLLER%", &filled(&of_header))
        .replace("%JOINTS%", &joints)
        .replace("%N%", &n.to_string())
        .replace("%ROWS%", &program.rows.to_string())
        .replace("%PARAMETERS%", &program.parameters.len().to_string())
        .replace("%NAMES%", &program.parameter_lines(" *   "))
        .replace("%FUNCTIONS%", &filled(&declarations))
        .replace("%HEADER%", &about_control(program.control, " * "));
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
        .replace("%VECTORS%", &vectors(program.vectors));
    [header, loops, test].map(|text| format!("{head}{text}"))
}

/// Returns the parts of the header, of the code and of the self-test for a controller.
fn controller(control: Option<&Control<'_>>) -> [String; 3] {
    let Some(control) = control else {
        return <[String; 3]>::default();
    };
    let controller = control.controller();
    let command = match controller.kind {
        ControllerKind::StateFeedback => {
            let row = |row: &Vec<f64>| format!("    {{{}}},\n", C.constants(row));
            let rows: String = controller.gain.iter().map(row).collect();
            COMMAND_OF_STATE.replace("%GAIN%", &rows)
        }
        ControllerKind::Pd => COMMAND_OF_PD
            .replace("%KP%", &C.constants(&controller.kp_nm_per_rad))
            .replace("%KD%", &C.constants(&controller.kd_nms_per_rad)),
    };
    let (delays, weights): (Vec<String>, Vec<f64>) = (control.taps.iter())
        .map(|tap| (tap.delay.to_string(), tap.weight))
        .unzip();
    let [positions, rates] = control.windows();
    let header = CONTROLLER_HEADER
        .replace("%PERIOD%", &format!("{:?}", control.code.period_s))
        .replace("%WHOSE%", control.whose())
        .replace("%MEASURED%", &(positions + rates).to_string())
        .replace("%SHAPED%", &control.shaped().to_string());
    let code = CONTROLLER
        .replace("%TAPS%", &delays.len().to_string())
        .replace("%DELAYS%", &delays.join(", "))
        .replace("%WEIGHTS%", &C.constants(&weights))
        .replace("%LIMITS%", &C.constants(&control.limits()))
        .replace("%POSITIONS%", &positions.to_string())
        .replace("%RATES%", &rates.to_string())
        .replace("%SCALE%", &C.constant(control.velocity_scale()))
        .replace("%COMMAND%", &command);
    let samples = control.samples.iter();
    let samples: String = samples
        .map(|sample| element_of_struct(&sample.all()))
        .collect();
    let motions = control.motions.iter();
    let motions: String = motions
        .map(|motion| element_of_struct(&motion.all()))
        .collect();
    let of_feedforward = if control.motions.is_empty() {
        String::new()
    } else {
        FEEDFORWARD_TEST
            .replace("%COUNT%", &control.motions.len().to_string())
            .replace("%MOTIONS%", &motions)
    };
    let test = CONTROLLER_TEST
        .replace("%COUNT%", &control.samples.len().to_string())
        .replace("%FAR%", &FAR.to_string())
        .replace("%SAMPLES%", &samples)
        .replace("%FEEDFORWARD%", &of_feedforward);
    [header, code, test]
}

/// Returns the parts of the header, of the code and of the self-test for an observer.
fn observer(observer: Option<&Observed<'_>>) -> [String; 3] {
    let Some(observer) = observer else {
        return <[String; 3]>::default();
    };
    let header = observer
        .with_sensors(&C, OBSERVER_HEADER)
        .replace("%PERIOD%", &format!("{:?}", observer.settings.period_s))
        .replace("%SETTLE%", &observer.settle().to_string())
        .replace("%HEADER%", &observer.header(" * "));
    let (update, call) = observer.memory(&C);
    let code = observer
        .numbers(&C, OBSERVER)
        .replace("%SLIDE%", if update.is_empty() { "" } else { SLIDE })
        .replace("%UPDATE%", &update)
        .replace("%DYNAMICS%", &call);
    let samples = observer.samples.iter();
    let samples: String = samples
        .map(|sample| element_of_struct(&sample.all()))
        .collect();
    let test = observer
        .with_sensors(&C, OBSERVER_TEST)
        .replace("%COUNT%", &observer.samples.len().to_string())
        .replace("%TIMES%", &observer.times().to_string())
        .replace("%SAMPLES%", &samples);
    [header, code, test]
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

fn vectors(vectors: &[Vector]) -> String {
    let vectors = vectors.iter();
    vectors
        .map(|vector| element_of_struct(&vector.all()))
        .collect()
}

/// Returns a structure of arrays as an element of an array.
fn element_of_struct(arrays: &[&[f64]]) -> String {
    let mut text = "    {\n".to_owned();
    for values in arrays {
        let _ = writeln!(text, "        {{{}}},", C.constants(values));
    }
    text.push_str("    },\n");
    text
}
