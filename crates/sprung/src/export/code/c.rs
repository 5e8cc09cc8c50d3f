//! C99.

use std::fmt::Write;

use super::emit::{Language, comment, identifier, unused};
use super::graph::Function;
use super::proof::Vector;
use super::trace::{Array, Traced};

/// The template of functions that loop over joints. `@` stands for the prefix, `§` for the prefix of
/// macros.
const LOOPS: &str = include_str!("templates/loops.c");

/// The template of the header.
const HEADER: &str = include_str!("templates/header.h");

/// The template of the self-test.
const TEST: &str = include_str!("templates/test.c");

const C: Language = Language {
    declare: "const @real",
    number: |digits| format!("R({digits})"),
    call,
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
    pub(super) traced: &'a [Traced],
    /// Reciprocal of the inertia of the rotor of each flexible joint; zero at rigid joints.
    pub(super) inverse_rotors: &'a [f64],
    pub(super) vectors: &'a [Vector],
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
        for (at, result) in results.iter().enumerate() {
            let element = super::emit::element(&traced.outputs, at);
            let _ = writeln!(code, "    {element} = {result};");
        }
        code.push_str("}\n\n");
    }
    let mut joints = String::new();
    for (i, name) in program.joints.iter().enumerate() {
        let _ = writeln!(joints, " *   {i}: {}", comment(name));
    }
    let header = filled(HEADER)
        .replace("%JOINTS%", &joints)
        .replace("%N%", &n.to_string())
        .replace("%FUNCTIONS%", &filled(&declarations));
    let loops = filled(LOOPS)
        .replace("%INVERSE_ROTORS%", &C.constants(program.inverse_rotors))
        .replace("%FUNCTIONS%", &filled(&code));
    let test = filled(TEST)
        .replace("%COUNT%", &program.vectors.len().to_string())
        .replace("%VECTORS%", &vectors(program.vectors));
    [header, loops, test].map(|text| format!("{head}{text}"))
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
        let length = if array.name == super::trace::MASS {
            "§JOINTS * §JOINTS"
        } else {
            "§JOINTS"
        };
        format!("{constant}@real {}[{length}]", array.name)
    };
    let inputs = traced.inputs.iter().map(|own| array(own, "const "));
    let outputs = traced.outputs.iter().map(|own| array(own, ""));
    let all: Vec<String> = inputs.chain(outputs).collect();
    format!("void @{}({})", traced.name, all.join(",\n    "))
}

fn vectors(vectors: &[Vector]) -> String {
    let mut text = String::new();
    for vector in vectors {
        text.push_str("    {\n");
        for values in vector.all() {
            let _ = writeln!(text, "        {{{}}},", C.constants(values));
        }
        text.push_str("    },\n");
    }
    text
}
