//! The parts of the figures, and the programs that measure them.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::plots::CURVES;
use crate::install::hdf5;
use crate::outside::python::Python;
use crate::outside::wheel::{self, For};
use crate::steps::succeeds;
use crate::{root, target};

/// The parts in the order of the documentation: name, packages that pip installs, and programs, one after another. With
/// maturin, the wheel is installed, too.
///
/// A program is `bench` or `test` of a package, a script of `benches`, `sprung` or `xtask`. `{sprung}` is the program,
/// `{out}` a folder for the part, `{data}` the logs of real machines, `{curves}` the curves of the gallery, and `{foreign}` the
/// logs that `foreign` simulates.
/// A new part is a line here and its notes in a benchmark.
const PARTS: &str = "
twins | numpy mujoco | peers/two_joints_mujoco.py {out}; bench sprung accuracy --mujoco {out}
intervals | | bench sprung accuracy --lengths 10,60,300 --seeds 20
verdicts | | bench sprung verdicts --cases 30
machines | | machines/run.py --data {data} --binary {sprung}
gallery | numpy scipy | gallery/run.py --data {data} --binary {sprung} --curves {curves}
examples | | examples/run.py --data {data} --binary {sprung}; \
    test sprung twin exact_positions encoders_and refined_drives offset_that
foreign | numpy numba pin example-robot-data | foreign/run.py --arms ur5,panda --seeds 1-1 --rates 1000,250 \
    --sharpness 100 --held-out --jobs 2 --binary {sprung} --out {foreign}
diagnoses | numpy scipy | diagnoses/run.py --binary {sprung} --out {out} --logs demo-1 --seeds 1,2,3
arms | numpy scipy pyarrow mcap mcap-ros2-support example-robot-data | arms/known_arms.py {sprung} {out}
servo | --ignore-requires-python numpy better-actuator-models optuna cmaes | bench sprung servo --seeds 20; \
    peers/servo_bam.py {sprung} {out} 400
springs | | bench sprung springs; bench sprung stiff
design | | bench sprung excite two-joints rounds seven-joints arms --runs 50 --robots 2 --random 50 --count 10
sensors | | test sprung twin stiffnesses_and_inertias they_follow_from motion_gives_stiffnesses
clocks | | test sprung-log formats resampling
bodies | | bench sprung physical --only bodies --seeds 5; bench sprung physical --only bounds --seeds 5; \
    bench sprung physical --only payload --seeds 2
checks | | bench sprung faults --seeds 4; bench sprung delays --seeds 1 --sizes 0,2,20
control | numpy mujoco | sprung demo --quiet --out {out}/demo; control/poses.py {sprung} {out}/demo; \
    export/controlled.py {sprung} {out}/controlled
drift | | drift/run.py --binary {sprung} --out {out}
arm | | xtask test outside arm
fleet | maturin numpy scipy pyarrow fsspec | fleet/statistics.py --fleets 50
speed | | peers/run.py {out}; bench sprung-cli size
beside | maturin numpy scipy pandas pin figaroh mujoco[sysid] | beside/run.py
python | maturin numpy | python/overhead.py
";

/// A group of figures that one run measures, and one table of the documentation.
pub(super) struct Part {
    pub(super) name: &'static str,
    /// What pip installs for it.
    packages: &'static str,
    programs: Vec<&'static str>,
}

/// Returns all parts.
pub(super) fn parts() -> Vec<Part> {
    let lines = PARTS
        .lines()
        .map(|line| line.split('|').map(str::trim).collect::<Vec<_>>());
    lines
        .filter_map(|fields| match fields[..] {
            [name, packages, programs] => Some(Part {
                name,
                packages,
                programs: programs.split("; ").collect(),
            }),
            _ => None,
        })
        .collect()
}

/// What a person gives instead of the usual paths.
#[derive(Default)]
pub(super) struct Given {
    /// The folder with the logs of real machines.
    pub(super) data: Option<PathBuf>,
    /// The program, built from this commit.
    pub(super) sprung: Option<PathBuf>,
}

impl Part {
    /// Runs the programs of the part; returns `None`, and prints why, if one fails.
    ///
    /// - `notes`: the file where benchmarks note their figures.
    pub(super) fn run(&self, notes: &Path, given: &Given) -> Option<()> {
        let python = Python::with(self.packages)?;
        if self.packages.contains("maturin") {
            wheel::install(&python, For::Figures)?;
        }
        let uses = |word: &str| self.programs.iter().any(|program| program.contains(word));
        let sprung = if uses("sprung ") || uses("{sprung}") || uses("peers/run") {
            given.sprung.clone().or_else(sprung)?
        } else {
            PathBuf::new()
        };
        let data = if uses("{data}") {
            given.data.clone().or_else(data)?
        } else {
            PathBuf::new()
        };
        let folder = target().join("figures");
        let paths = [
            ("{sprung}", sprung.clone()),
            ("{data}", data),
            ("{out}", folder.join(self.name)),
            ("{foreign}", folder.join("foreign")),
            ("{curves}", root().join(CURVES)),
        ];
        for program in &self.programs {
            let words: Vec<String> = (program.split_whitespace())
                .map(|word| {
                    let put = |word: String, (mark, path): &(&str, PathBuf)| {
                        word.replace(mark, &path.to_string_lossy())
                    };
                    paths.iter().fold(word.to_owned(), put)
                })
                .collect();
            let mut command = command(&words, &python, &sprung)?;
            command.env("SPRUNG_FIGURES", notes).env("SPRUNG", &sprung);
            succeeds(command.current_dir(root()))?;
        }
        Some(())
    }
}

/// Returns the command of a program of [`PARTS`].
fn command(words: &[String], python: &Python, sprung: &Path) -> Option<Command> {
    let (first, rest) = words.split_first()?;
    let cargo = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO"));
        // One test at a time, so that the figures have one order.
        command.args(words).env("RUST_TEST_THREADS", "1");
        command
    };
    let mut command = match (first.as_str(), rest) {
        ("bench", [package, name, arguments @ ..]) => {
            let mut command = cargo(&["bench", "--quiet", "-p", package, "--bench", name, "--"]);
            command.args(arguments);
            return Some(command);
        }
        ("test", [package, name, arguments @ ..]) => {
            let release = [
                "test",
                "--quiet",
                "--release",
                "-p",
                package,
                "--test",
                name,
            ];
            let mut command = cargo(&[&release[..], &["--"]].concat());
            command.args(arguments);
            return Some(command);
        }
        ("sprung", _) => Command::new(sprung),
        ("xtask", _) => Command::new(std::env::current_exe().ok()?),
        (script, _) => {
            let environment = python.program();
            let program = if environment.exists() {
                environment
            } else {
                Path::new("python3")
            };
            let mut command = Command::new(program);
            command.arg(root().join("benches").join(script));
            command
        }
    };
    command.args(rest);
    Some(command)
}

/// Builds the program as a release, and returns its path.
fn sprung() -> Option<PathBuf> {
    let mut command = Command::new(env!("CARGO"));
    command.args(["build", "--quiet", "--release", "-p", "sprung-cli"]);
    if hdf5() {
        command.arg("--features=mat73");
    }
    succeeds(command.current_dir(root()))?;
    target().join("release/sprung").canonicalize().ok()
}

/// Returns the folder with the logs of real machines; `None`, and prints why, if it is absent.
fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("SPRUNG_TEST_DATA")
        .map_or_else(|| root().join("../shared"), PathBuf::from);
    let data = folder.join("data");
    if !data.is_dir() {
        let data = data.display();
        eprintln!("── {data} is absent: SPRUNG_TEST_DATA names the folder that holds `data`");
        return None;
    }
    Some(data)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outside::python::with_version;

    #[test]
    fn every_part_names_known_packages_and_present_programs() {
        let parts = parts();
        assert_eq!(parts.len(), PARTS.lines().count() - 1);
        for part in &parts {
            for package in part.packages.split_whitespace() {
                let is_known = package.starts_with("--") || with_version(package).contains("==");
                assert!(is_known, "{}: {package}", part.name);
            }
            for program in &part.programs {
                let words: Vec<&str> = program.split_whitespace().collect();
                let file = match words[..] {
                    ["bench", package, name, ..] => format!("crates/{package}/benches/{name}"),
                    ["test", package, name, ..] => format!("crates/{package}/tests/{name}"),
                    ["sprung" | "xtask", ..] => "Cargo.toml".to_owned(),
                    [script, ..] => format!("benches/{script}"),
                    [] => unreachable!("{}", part.name),
                };
                let file = root().join(file);
                let is_there = file.exists() || file.with_extension("rs").exists();
                assert!(is_there, "{}: {}", part.name, file.display());
            }
        }
    }
}
