//! What C and Rust share: statements of operations, and names.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::graph::{Function, Operand, Operation};
use super::trace::{Array, Traced};

/// How a language writes numbers and calls.
pub(super) struct Language {
    /// Before the name of an intermediate value.
    pub(super) declare: &'static str,
    /// A number that is not negative, with all its digits.
    pub(super) number: fn(&str) -> String,
    /// A function of an operand.
    pub(super) call: fn(Function, &str) -> String,
    /// A row of a table.
    pub(super) row_of: fn(&str) -> String,
    /// The statement that moves a set of elements: first element, position that moves it, widths.
    pub(super) move_elements: fn(usize, &str, &str) -> String,
    /// The call of the dynamics in an observer: name, and whether it has elements.
    pub(super) observed: fn(&str, bool) -> String,
    /// Parts of an observer with memory, with their places in its templates.
    pub(super) memory: &'static [(&'static str, &'static str)],
    /// The same of a controller and its self-test.
    pub(super) memory_of_control: &'static [(&'static str, &'static str)],
    /// Parts of an observer with torque sensors, with their places in its templates.
    pub(super) sensors: &'static [(&'static str, &'static str)],
    /// The torque that the sensor of joint `i` measures.
    pub(super) spring: &'static str,
    /// False and true.
    pub(super) truths: [&'static str; 2],
    /// Before a line of a comment about a function.
    pub(super) comment: &'static str,
    /// Rows of numbers as an element of an array in the self-test.
    pub(super) element_of: fn(&[String]) -> String,
    /// Templates of the controller's law: state feedback, and PD.
    pub(super) commands: [&'static str; 2],
    /// Templates of the self-tests of a controller and of its feedforward.
    pub(super) tests: [&'static str; 2],
}

impl Language {
    /// Returns a number.
    pub(super) fn constant(&self, value: f64) -> String {
        let number = (self.number)(&format!("{:?}", value.abs()));
        if value < 0.0 {
            format!("(-{number})")
        } else {
            number
        }
    }

    /// Returns numbers with commas between them.
    pub(super) fn constants(&self, values: &[f64]) -> String {
        let constants: Vec<String> = values.iter().map(|value| self.constant(*value)).collect();
        constants.join(", ")
    }

    /// Returns a row of a table on a line.
    pub(super) fn row(&self, values: &[f64]) -> String {
        (self.row_of)(&self.constants(values))
    }

    /// Returns numbers on separate lines.
    pub(super) fn lines(&self, values: &[f64]) -> String {
        let line = |value: &f64| format!("    {},\n", self.constant(*value));
        values.iter().map(line).collect()
    }

    /// Returns elements of an array of the self-test, each of several arrays.
    pub(super) fn elements<'a, const N: usize>(
        &self,
        all: impl Iterator<Item = [&'a [f64]; N]>,
    ) -> String {
        let element =
            |arrays: [&[f64]; N]| (self.element_of)(&arrays.map(|values| self.constants(values)));
        all.map(element).collect()
    }

    /// Returns lines of the caller for a comment.
    pub(super) fn comments(&self, lines: &[String]) -> String {
        let mut text = String::new();
        for line in lines {
            let _ = writeln!(text, "{}{}", self.comment, comment(line));
        }
        text
    }

    /// Returns the statements of the intermediate values, and the results.
    pub(super) fn body(&self, traced: &Traced) -> (Vec<String>, Vec<String>) {
        let inputs: BTreeMap<u32, String> = (traced.operations.iter())
            .filter_map(|(id, operation)| match operation {
                Operation::Input(index) => Some((*id, element(&traced.inputs, *index))),
                Operation::Of(..)
                | Operation::Add(..)
                | Operation::Sub(..)
                | Operation::Mul(..) => None,
            })
            .collect();
        let of = |operand: Operand| match operand {
            Operand::Constant(bits) => self.constant(f64::from_bits(bits)),
            Operand::Node(id) => inputs.get(&id).cloned().unwrap_or_else(|| format!("t{id}")),
        };
        let mut statements = Vec::with_capacity(traced.operations.len());
        for (id, operation) in &traced.operations {
            let value = match *operation {
                Operation::Input(_) => continue,
                Operation::Of(function, x) => (self.call)(function, &of(x)),
                Operation::Add(x, y) => format!("{} + {}", of(x), of(y)),
                Operation::Sub(x, y) => format!("{} - {}", of(x), of(y)),
                Operation::Mul(x, y) => format!("{} * {}", of(x), of(y)),
            };
            statements.push(format!("{} t{id} = {value};", self.declare));
        }
        (
            statements,
            traced.results.iter().map(|result| of(*result)).collect(),
        )
    }
}

/// Returns an element of arrays that stand one after the other.
pub(super) fn element(arrays: &[Array], index: usize) -> String {
    let mut at = index;
    for array in arrays {
        if at < array.length {
            return format!("{}[{at}]", array.name);
        }
        at -= array.length;
    }
    String::new()
}

/// Returns whether a result is the constant zero.
pub(super) fn is_zero(result: Operand) -> bool {
    matches!(result, Operand::Constant(bits) if f64::from_bits(bits) == 0.0)
}

/// Returns the inputs of which a function uses no element.
pub(super) fn unused(traced: &Traced) -> Vec<&'static str> {
    let used: Vec<String> = (traced.operations.iter())
        .filter_map(|(_, operation)| match operation {
            Operation::Input(index) => Some(element(&traced.inputs, *index)),
            Operation::Of(..) | Operation::Add(..) | Operation::Sub(..) | Operation::Mul(..) => {
                None
            }
        })
        .collect();
    let is_used = |name: &str| {
        (used.iter()).any(|variable| {
            variable
                .split_once('[')
                .is_some_and(|(array, _)| array == name)
        })
    };
    let names = traced.inputs.iter().map(|array| array.name);
    names.filter(|name| !is_used(name)).collect()
}

/// Returns the functions of one number that any function uses.
pub(super) fn calls(all: &[Traced]) -> Vec<Function> {
    let mut calls = vec![Function::Sin, Function::Cos];
    for (_, operation) in all.iter().flat_map(|traced| &traced.operations) {
        if let Operation::Of(function, _) = operation
            && !calls.contains(function)
        {
            calls.push(*function);
        }
    }
    calls
}

/// Returns a name as the beginning of identifiers: lower case letters, digits and underscores.
pub(super) fn identifier(name: &str) -> String {
    let letters: String = (name.chars())
        .map(|c| {
            if c.is_ascii_alphanumeric() {
                c.to_ascii_lowercase()
            } else {
                '_'
            }
        })
        .collect();
    let words: Vec<&str> = letters.split('_').filter(|word| !word.is_empty()).collect();
    let joined = words.join("_");
    match joined.chars().next() {
        None => "robot".to_owned(),
        Some(first) if first.is_ascii_digit() => format!("robot_{joined}"),
        Some(_) => joined,
    }
}

/// Returns a line for a comment. It cannot end the comment, begin another one or change the direction
/// of the text.
pub(super) fn comment(line: &str) -> String {
    let plain = |c: char| {
        let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if c.is_control() || turns { ' ' } else { c }
    };
    let line: String = line.chars().map(plain).collect();
    let line = line.replace("*/", "* /").replace("/*", "/ *");
    line.replace("??", "? ?").trim_end_matches('\\').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_identifiers_and_comments_stay_comments() {
        for (name, expected) in [
            ("My arm-7", "my_arm_7"),
            ("2R", "robot_2r"),
            ("__", "robot"),
            ("int", "int"),
            ("Größe", "gr_e"),
        ] {
            assert_eq!(identifier(name), expected);
        }
        assert_eq!(comment("a */ b /* c\nd\\"), "a * / b / * c d");
    }
}
