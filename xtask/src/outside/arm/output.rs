//! What the programs print.

use std::process::Command;

use sprung_testing::Figure;

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Double,
    Single,
}

impl Number {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Double => "double",
            Self::Single => "float",
        }
    }

    /// Returns what the compiler gets.
    pub(super) fn flag(self) -> Option<&'static str> {
        (self == Self::Single).then_some("-DSPRUNG_FLOAT")
    }

    /// Returns the largest difference from the host, relative to the largest number of an array. The
    /// libraries round sines differently, and the solution for accelerations amplifies this.
    pub(super) fn tolerance(self) -> f64 {
        match self {
            Self::Double => 1e-13,
            Self::Single => 1e-5,
        }
    }

    fn value(self, bits: &str) -> Option<f64> {
        match self {
            Self::Double => Some(f64::from_bits(u64::from_str_radix(bits, 16).ok()?)),
            Self::Single => Some(f32::from_bits(u32::from_str_radix(bits, 16).ok()?).into()),
        }
    }
}

/// Instructions of a known loop.
const LOOP: u64 = 2_000_000;

/// Largest error of the count of instructions: one tick of the timer, and the call.
const COUNT_ERROR: u64 = 100;

/// Functions in the documentation.
const SHOWN: [&str; 2] = ["inverse_dynamics", "control_step"];

/// Cost of a call of a function.
#[derive(Clone, Debug, PartialEq)]
struct Cost {
    function: String,
    /// Instructions of a call.
    instructions: u64,
    /// Bytes of stack.
    stack: u64,
}

/// Numbers of a program.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Output {
    /// Function and results, for each state.
    results: Vec<(String, Vec<f64>)>,
    costs: Vec<Cost>,
    /// Counted instructions of the known loop.
    counted: Option<u64>,
}

impl Output {
    /// Runs a program; returns what it printed. Returns `None`, and prints why, if it fails.
    pub(super) fn text(command: &mut Command) -> Option<String> {
        let program = command.get_program().to_string_lossy().into_owned();
        let output = command
            .output()
            .inspect_err(|error| eprintln!("── cannot run {program}: {error}"))
            .ok()?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        if !output.status.success() {
            let errors = String::from_utf8_lossy(&output.stderr);
            eprintln!("{text}{errors}── {program}: {}", output.status);
            return None;
        }
        Some(text)
    }

    /// Runs a program that prints results and costs.
    pub(super) fn of(command: &mut Command, number: Number) -> Option<Self> {
        let text = Self::text(command)?;
        let read = Self::read(&text, number);
        if read.is_none() {
            eprintln!("{text}── these are no results");
        }
        read
    }

    fn read(text: &str, number: Number) -> Option<Self> {
        let mut output = Self {
            results: Vec::new(),
            costs: Vec::new(),
            counted: None,
        };
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                ["result", function, bits @ ..] => {
                    let values: Option<Vec<f64>> =
                        bits.iter().map(|bits| number.value(bits)).collect();
                    output.results.push(((*function).to_owned(), values?));
                }
                ["cost", function, instructions, stack] => output.costs.push(Cost {
                    function: (*function).to_owned(),
                    instructions: instructions.parse().ok()?,
                    stack: stack.parse().ok()?,
                }),
                ["loop", counted] => output.counted = Some(counted.parse().ok()?),
                _ => return None,
            }
        }
        (!output.results.is_empty()).then_some(output)
    }

    /// Returns the largest difference of any function, relative to the largest number of its array; `None`
    /// if the functions are not the same.
    pub(super) fn difference(&self, known: &Self) -> Option<f64> {
        let mut worst = 0.0_f64;
        if self.results.len() != known.results.len() {
            return None;
        }
        for ((name, values), (other, known)) in self.results.iter().zip(&known.results) {
            if name != other || values.len() != known.len() {
                return None;
            }
            let largest = known.iter().fold(0.0_f64, |sum, x| sum.max(x.abs()));
            for (a, b) in values.iter().zip(known) {
                let difference = (a - b).abs();
                if difference.is_nan() {
                    return Some(f64::INFINITY);
                }
                if difference > 0.0 {
                    worst = worst.max(difference / largest);
                }
            }
        }
        Some(worst)
    }

    /// Returns whether the count of a known number of instructions is right.
    pub(super) fn counts_well(&self) -> bool {
        self.counted
            .is_some_and(|counted| counted.abs_diff(LOOP) <= COUNT_ERROR)
    }

    /// Returns the largest stack of any function, bytes.
    pub(super) fn stack(&self) -> u64 {
        self.costs.iter().map(|cost| cost.stack).max().unwrap_or(0)
    }
}

/// A robot on a microcontroller.
pub(super) struct Row {
    /// Robot, microcontroller and type of numbers.
    pub(super) what: String,
    /// Bytes.
    pub(super) flash: usize,
    /// Largest relative difference from the host.
    pub(super) difference: f64,
    pub(super) found: Output,
    pub(super) problems: Vec<&'static str>,
}

impl Row {
    /// Returns what the robot needs, and its problems, on separate lines.
    pub(super) fn shown(&self) -> String {
        let costs = self.found.costs.iter();
        let costs: Vec<String> = costs
            .map(|cost| format!("{} {}", cost.function, cost.instructions))
            .collect();
        let mut text = format!(
            "{}: flash {} B, stack {} B, difference {:.1e}; instructions of a call: {}",
            self.what,
            self.flash,
            self.found.stack(),
            self.difference,
            costs.join(", ")
        );
        for problem in &self.problems {
            text += "\n  FAILED: ";
            text += problem;
        }
        text
    }

    /// Notes size, stack and the instructions of one function for the documentation.
    pub(super) fn note(&self) {
        let what = &self.what;
        let note = |name: &str, text: &str, value: f64, unit: &str| {
            Figure::lower(
                &format!("{what}{name}"),
                &format!("{what}: {text}"),
                value,
                unit,
            )
            .note();
        };
        note("", "flash", self.flash as f64 / 1e3, "kB");
        note(", stack", "stack", self.found.stack() as f64, "B");
        let mut costs = self.found.costs.iter();
        if let Some(cost) = costs.find(|cost| SHOWN.contains(&cost.function.as_str())) {
            let text = "instructions of `inverse_dynamics` or `control_step`";
            note(", instructions", text, cost.instructions as f64, "");
        }
    }
}

/// Returns the definitions of the prefix of the functions and of the sizes in a header for the
/// driver.
pub(super) fn defined(header: &str) -> Option<Vec<String>> {
    let prefix = header.lines().find_map(|line| {
        let rest = line.strip_prefix("void ")?;
        Some(&rest[..rest.find("gravity(")?])
    })?;
    let mut definitions = vec![format!("-DPREFIX={prefix}")];
    for size in ["JOINTS", "ROWS", "PARAMETERS"] {
        let define = format!("#define {}{size} ", prefix.to_ascii_uppercase());
        let mut lines = header.lines();
        let value: usize =
            lines.find_map(|line| line.strip_prefix(&define)?.trim().parse().ok())?;
        definitions.push(format!("-D{size}={value}"));
    }
    Some(definitions)
}

/// Returns the flash of a program by the table of `size`: code, constants and initial values, bytes.
pub(super) fn flash(sizes: &str) -> Option<usize> {
    let mut words = sizes.lines().nth(1)?.split_whitespace();
    let mut next = || -> Option<usize> { words.next()?.parse().ok() };
    Some(next()? + next()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_read_and_compared() {
        let text =
            "result gravity 3ff0000000000000 c000000000000000\nresult spring 0000000000000000\n";
        let read = |text: &str| Output::read(text, Number::Double);
        let host = read(text).unwrap();
        assert_eq!(host.results[0].1, [1.0, -2.0]);
        let costs = "loop 2000040\ncost gravity 28238 472\ncost spring 1020 96\n";
        let output = read(&format!("{text}{costs}")).unwrap();
        assert_eq!(output.difference(&host), Some(0.0));
        assert!(output.counts_well() && !host.counts_well());
        assert_eq!(output.stack(), 472);
        let other = read(&text.replace("3ff0", "3ff8")).unwrap();
        assert_eq!(other.difference(&host), Some(0.25));
        let broken = read(&text.replace("3ff0", "7ff8")).unwrap();
        assert_eq!(broken.difference(&host), Some(f64::INFINITY));
        assert!(
            host.difference(&read("result gravity 3ff0000000000000").unwrap())
                .is_none()
        );
        assert!(
            read("").is_none() && read("fault").is_none() && read("result gravity x").is_none()
        );
        assert_eq!(Number::Single.value("3f800000"), Some(1.0));
        let row = Row {
            what: "arm".to_owned(),
            flash: 10_240,
            difference: 1e-15,
            found: output,
            problems: vec!["the numbers differ"],
        };
        let shown = row.shown();
        let lines: Vec<&str> = shown.lines().collect();
        let needs = "arm: flash 10240 B, stack 472 B, difference 1.0e-15; instructions of a call: gravity 28238, spring 1020";
        assert_eq!(lines, [needs, "  FAILED: the numbers differ"]);
    }

    #[test]
    fn headers_and_sizes_are_read() {
        let header = "#define MY_ARM_JOINTS 7\n#define MY_ARM_ROWS 14\n#define MY_ARM_PARAMETERS 86\n\
                      /* */\nvoid my_arm_gravity(const my_arm_real q_rad[MY_ARM_JOINTS],\n";
        let flags = [
            "-DPREFIX=my_arm_",
            "-DJOINTS=7",
            "-DROWS=14",
            "-DPARAMETERS=86",
        ];
        assert_eq!(defined(header).unwrap(), flags);
        assert_eq!(defined("void f(void);"), None);
        let sizes = "   text\t   data\t    bss\n  66448\t   1080\t   1288\n";
        assert_eq!(flash(sizes), Some(67528));
        assert_eq!(flash("   text"), None);
    }
}
