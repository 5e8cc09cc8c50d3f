//! C code of robots on two microcontrollers, which QEMU emulates.

mod output;

use std::path::{Path, PathBuf};
use std::process::Command;

use output::{Number, Output, Row};

use super::mujoco::{build, sprung};
use super::python::Python;
use crate::install::arm;
use crate::root;
use crate::steps::{cargo, succeeds};

/// A microcontroller.
struct Core {
    name: &'static str,
    /// Machine of QEMU.
    machine: &'static str,
    flags: &'static [&'static str],
}

const CORES: [Core; 2] = [
    Core {
        name: "Cortex-M4F",
        machine: "mps2-an386",
        flags: &["-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"],
    },
    Core {
        name: "Cortex-M7",
        machine: "mps2-an500",
        flags: &["-mcpu=cortex-m7", "-mfpu=fpv5-d16"],
    },
];

/// What all compilers get.
const STRICT: [&str; 6] = [
    "-std=c99",
    "-O2",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-Wconversion",
];

/// Flash that the functions of a robot may need with the library of mathematics, bytes.
const FLASH: usize = 128 * 1024;

/// Code of a robot.
struct Robot {
    name: &'static str,
    folder: PathBuf,
    /// Flags that define its name and its sizes.
    defined: Vec<String>,
}

/// Exports two robots, runs their functions on the host and on the microcontrollers, and prints what they need.
/// Fails if numbers differ, or if the flash is too small.
pub(super) fn check(python: &Python) -> Option<()> {
    if !arm() {
        return None;
    }
    build()?;
    // Compilers and programs run in the folders of the robots.
    let outside = std::path::absolute(&python.folder).ok()?;
    let (demo, folder) = (outside.join("demo"), outside.join("arm"));
    sprung(&["demo", "--quiet", "--out", &demo.to_string_lossy()])?;
    let robots = [
        Robot::export("demo with 2 joints", &demo, &folder.join("demo"))?,
        Robot::export(
            "twin with 7 joints",
            &root().join("examples/seven-joint-twin"),
            &folder.join("seven"),
        )?,
    ];
    let controlled = Robot::controlled(
        "controller of 7 joints",
        &root().join("examples/seven-joint-twin"),
        &folder.join("controlled"),
    )?;
    let mut is_good = true;
    for robots in [&robots[..], &[controlled]] {
        let rows = rows(robots)?;
        for row in &rows {
            println!("{}", row.shown());
            row.note();
        }
        is_good &= rows.iter().all(|row| row.problems.is_empty());
    }
    is_good.then_some(())
}

/// Runs robots with both types of numbers on both microcontrollers.
fn rows(robots: &[Robot]) -> Option<Vec<Row>> {
    let mut rows = Vec::new();
    for robot in robots {
        for number in [Number::Double, Number::Single] {
            let host = robot.on_host(number)?;
            for core in &CORES {
                rows.push(robot.compare(core, number, &host)?);
            }
        }
    }
    Some(rows)
}

impl Robot {
    /// Exports a robot with the true parameters of its twin.
    fn export(name: &'static str, experiment: &Path, folder: &Path) -> Option<Self> {
        let words = |path: &Path| path.to_string_lossy().into_owned();
        let truth = words(&experiment.join("truth.toml"));
        let (experiment, out) = (words(experiment), words(folder));
        let given = ["export", &experiment, "--parameters", &truth];
        let more = ["--format", "c", "--out", &out, "--force", "--quiet"];
        sprung(&[&given[..], &more].concat())?;
        Self::of(name, folder)
    }

    /// Exports a robot with a controller. Its programs run the controller only.
    fn controlled(name: &'static str, experiment: &Path, folder: &Path) -> Option<Self> {
        let example = ["--package", "sprung-export", "--example", "controlled"];
        let mut write = cargo();
        write.args(["run", "--quiet"]).args(example).arg("--");
        write.args(["experiment.toml", "truth.toml"].map(|file| experiment.join(file)));
        succeeds(write.arg(folder))?;
        let mut robot = Self::of(name, folder)?;
        robot.defined.push("-DCONTROL".to_owned());
        Some(robot)
    }

    /// Returns the robot whose code is in a folder.
    fn of(name: &'static str, folder: &Path) -> Option<Self> {
        let header = std::fs::read_to_string(folder.join("robot.h")).ok()?;
        let Some(defined) = output::defined(&header) else {
            eprintln!("── {}/robot.h has no name of the robot", folder.display());
            return None;
        };
        Some(Self {
            name,
            folder: folder.to_owned(),
            defined,
        })
    }

    /// Returns the options of all compilers for the driver.
    fn flags(&self, number: Number) -> Vec<String> {
        let mut flags: Vec<String> = STRICT.iter().map(ToString::to_string).collect();
        flags.extend(number.flag().map(str::to_owned));
        flags.extend(self.defined.iter().cloned());
        flags.push("-I.".to_owned());
        flags.push(format!("-I{}", source("").display()));
        flags
    }

    /// Returns the results of this machine.
    fn on_host(&self, number: Number) -> Option<Output> {
        let mut compiler = Command::new("cc");
        compiler
            .current_dir(&self.folder)
            .args(self.flags(number))
            .arg(source("driver.c"))
            .args(["robot.c", "-lm", "-o", "host"]);
        succeeds(&mut compiler)?;
        Output::of(&mut Command::new(self.folder.join("host")), number)
    }

    /// Compiles a program for a microcontroller.
    fn compile(&self, core: &Core, number: Number, more: &[&str]) -> Option<()> {
        let mut compiler = Command::new("arm-none-eabi-gcc");
        compiler
            .current_dir(&self.folder)
            .args(self.flags(number))
            .args(core.flags)
            .args(["-mthumb", "-mfloat-abi=hard", "-nostartfiles", "-T"])
            .args([source("mps2.ld"), source("startup.c")])
            .args(["-ffunction-sections", "-Wl,--gc-sections", "robot.c"])
            .args(more)
            .args(["-lm", "-o", "program.elf"]);
        succeeds(&mut compiler)
    }

    /// Returns the command that runs a program on a microcontroller.
    fn emulated(&self, core: &Core) -> Command {
        let mut command = Command::new("timeout");
        command
            .current_dir(&self.folder)
            .args(["300", "qemu-system-arm", "-machine", core.machine])
            .args(["-kernel", "program.elf", "-icount", "shift=0"])
            .args(["-display", "none", "-monitor", "none", "-serial", "none"])
            .args(["-chardev", "stdio,id=out", "-semihosting-config"])
            .arg("enable=on,target=native,chardev=out");
        command
    }

    /// Runs the self-test and all functions on a microcontroller.
    fn compare(&self, core: &Core, number: Number, host: &Output) -> Option<Row> {
        let test = ["robot_test.c", "--specs=rdimon.specs"];
        let defined = ["-DSPRUNG_STDIO", "-DSPRUNG_NO_CLOCK"];
        self.compile(core, number, &[&test[..], &defined].concat())?;
        let passes = Output::text(&mut self.emulated(core))?.contains("PASS");

        let driver = source("driver.c");
        self.compile(core, number, &[driver.to_str()?])?;
        let found = Output::of(&mut self.emulated(core), number)?;
        let mut size = Command::new("arm-none-eabi-size");
        let sizes = Output::text(size.current_dir(&self.folder).arg("program.elf"))?;
        let flash = output::flash(&sizes)?;
        let difference = found.difference(host)?;
        let problems = [
            (!passes, "the self-test fails"),
            (difference > number.tolerance(), "the numbers differ"),
            (flash >= FLASH, "the code needs too much flash"),
            (!found.counts_well(), "the count of instructions is wrong"),
        ];
        let problems = problems.iter().filter(|(is_there, _)| *is_there);
        Some(Row {
            what: format!("{}, {}, {}", self.name, core.name, number.name()),
            flash,
            difference,
            problems: problems.map(|(_, problem)| *problem).collect(),
            found,
        })
    }
}

/// Returns the path of a source of the programs.
fn source(name: &str) -> PathBuf {
    let folder = root().join("benches/arm");
    folder.canonicalize().unwrap_or(folder).join(name)
}
