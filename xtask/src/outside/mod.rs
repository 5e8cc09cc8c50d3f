//! `cargo xtask test outside`: sprung against foreign programs, which it installs itself.
//!
//! A step that cannot install its programs fails: no step is skipped here.

mod arm;
mod benches;
mod export;
mod foreign;
mod formats;
mod mujoco;
mod new;
pub(crate) mod python;
mod pythons;
mod servo;
mod vectors;
pub(crate) mod wheel;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use python::Python;

use crate::run::{Outcome, two_at_a_time};
use crate::steps::{Steps, task};
use crate::{fuzz, summary, target};

/// A comparison with a foreign program.
struct Step {
    name: &'static str,
    what: &'static str,
    /// What pip installs for it; empty if it needs no Python.
    packages: &'static [&'static str],
    /// Returns `None`, and prints why, if the comparison fails.
    run: fn(&Python) -> Option<()>,
}

/// A step that ran in a separate process.
struct Ended {
    step: &'static str,
    elapsed: Duration,
    succeeded: bool,
}

/// What pip did.
struct Installed {
    /// Steps that have their packages.
    ready: Vec<&'static Step>,
    without: Vec<&'static Step>,
    elapsed: Duration,
}

/// All steps: those without packages, then the long ones first. A new comparison is a line here and a file beside this one.
static STEPS: [Step; 14] = [
    Step {
        name: "benches",
        what: "every benchmark of cargo, once and with little work",
        packages: &[],
        run: |_| benches::check(),
    },
    Step {
        name: "fuzz",
        what: "the fuzz targets compile",
        packages: &[],
        run: |_| fuzz::compiles(),
    },
    Step {
        name: "arm",
        what: "exported C on Cortex-M4F and M7, in QEMU",
        packages: &[],
        run: arm::check,
    },
    Step {
        name: "python",
        what: "the wheel: types, examples, tests, notebooks, the cost of a call",
        packages: PYTHON,
        run: wheel::check,
    },
    Step {
        name: "new",
        what: "a hundred logs of ten known arms, begun by sprung new",
        packages: &[
            "numpy==2.4.6",
            "scipy==1.17.1",
            "pyarrow==26.0.1",
            "mcap==1.6.0",
            "mcap-ros2-support==0.6.0",
            "example-robot-data==6.0.0",
        ],
        run: new::check,
    },
    Step {
        name: "export",
        what: "exported robots in Pinocchio, MuJoCo and Drake",
        packages: &[
            "numpy==2.4.6",
            "pin==4.1.0",
            "mujoco==4.0.0",
            "drake==1.51.1",
            "example-robot-data==6.0.0",
            "cmeel-eigen==3.4.1",
        ],
        run: export::check,
    },
    Step {
        name: "foreign",
        what: "logs of an arm that Pinocchio describes, as other recorders write them",
        packages: &[
            "numpy==2.4.6",
            "numba==0.68.1",
            "pin==4.1.0",
            "example-robot-data==6.0.0",
        ],
        run: foreign::check,
    },
    Step {
        name: "servo",
        what: "a servo without torque, beside BAM's CMA-ES",
        // The package requires Python 3.12, and its models run on 3.11.
        packages: &[
            "--ignore-requires-python",
            "numpy==2.4.6",
            "better-actuator-models==1.0.2",
            "optuna==5.0.0",
            "cmaes==0.13.1",
        ],
        run: servo::check,
    },
    Step {
        name: "formats",
        what: "logs as their usual writers write them",
        packages: &[
            "numpy==2.4.6",
            "scipy==1.17.1",
            "h5py==3.16.0",
            "pandas==3.1.1",
            "pyarrow==26.0.1",
            "zstandard==0.25.0",
            "mcap==1.6.0",
            "mcap-ros2-support==0.6.0",
            "rosbags==0.11.9",
        ],
        run: formats::check,
    },
    Step {
        name: "mujoco",
        what: "an arm simulated by MuJoCo, identified",
        packages: &["numpy==2.4.6", "mujoco==4.0.0"],
        run: mujoco::check,
    },
    Step {
        name: "mat73-static",
        what: "the formats with a libhdf5 of their own, which CMake compiles",
        packages: &["cmake==3.31.6"],
        run: formats::with_own_libhdf5,
    },
    Step {
        name: "pinocchio",
        what: "torques and momenta of Pinocchio",
        packages: &["numpy==2.4.6", "pin==4.1.0"],
        run: vectors::pinocchio,
    },
    Step {
        name: "benchmark",
        what: "the scorer of the benchmark, its simulator and an adapter",
        packages: &["numpy==2.4.6", "scipy==1.17.1"],
        run: |python| python.run("benchmark/test_benchmark.py", &[]),
    },
    Step {
        name: "scipy",
        what: "the zero-phase filter of SciPy",
        packages: &["numpy==2.4.6", "scipy==1.17.1"],
        run: vectors::scipy,
    },
];

/// Packages that users of the wheel have.
const PYTHON: &[&str] = &[
    wheel::MATURIN,
    "numpy==2.4.6",
    "scipy==1.17.1",
    "scipy-stubs",
    "pandas==3.1.1",
    "pandas-stubs==3.1.0.261029",
    "polars==2.1.0",
    "pyarrow==26.0.1",
    "pyarrow-stubs==20.0.0.20260819",
    "matplotlib==3.11.2",
    "tqdm==4.70.1",
    "types-tqdm==4.70.0.20261106",
    "nbclient==0.11.0",
    "nbconvert==7.17.2",
    "ipykernel==7.4.0",
    "mujoco==4.0.0",
    "mypy==2.4.1",
    "pytest==9.2.0",
    "pytest-xdist==3.8.0",
    "fsspec==2026.9.0",
    "s3fs==2026.9.0",
    "dask[distributed]==2026.8.0",
    "ray[data]==2.60.0",
    "moto[server]==5.2.5",
    "duckdb==2.0.0",
];

/// Returns the names of all steps.
pub(crate) fn names() -> Vec<&'static str> {
    STEPS.iter().map(|step| step.name).collect()
}

/// Word before the name of a step whose packages are installed.
const INSTALLED: &str = "installed";

/// Runs steps, two at a time, also after one that fails; succeeds if none failed.
///
/// - `chosen`: their names; all if empty.
pub(crate) fn run(chosen: &[&str]) -> ExitCode {
    let (is_installed, chosen) = match chosen {
        [INSTALLED, step] => (true, std::slice::from_ref(step)),
        chosen => (false, chosen),
    };
    if let Some(unknown) = chosen.iter().find(|name| !names().contains(*name)) {
        eprintln!(
            "there is no step {unknown}; there are {}",
            names().join(", ")
        );
        return ExitCode::from(2);
    }
    let mut steps = Steps::default();
    let chosen: Vec<&'static Step> = (STEPS.iter())
        .filter(|step| chosen.is_empty() || chosen.contains(&step.name))
        .collect();
    if let [step] = chosen[..] {
        steps.step(step.name, step.what, || {
            let packages = if is_installed { &[] } else { step.packages };
            (step.run)(&Python::with(&folder(), packages)?)
        });
    } else {
        side_by_side(&mut steps, chosen);
    }
    if summary::print(&steps, &Outcome::default()) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn folder() -> PathBuf {
    target().join("outside")
}

/// Runs steps in separate processes, two at a time, and shows the output of each when it ends.
///
/// The packages of all steps are installed beside the steps that need none, because pip must not change packages in use.
fn side_by_side(steps: &mut Steps, chosen: Vec<&'static Step>) {
    let (later, first): (Vec<&'static Step>, Vec<&Step>) =
        (chosen.into_iter()).partition(|step| !step.packages.is_empty());
    let install = || {
        eprintln!("── packages: pip installs those of {} steps", later.len());
        let begin = Instant::now();
        let has_packages = |step: &&Step| Python::with(&folder(), step.packages).is_some();
        let (ready, without) = later.into_iter().partition(has_packages);
        Installed {
            ready,
            without,
            elapsed: begin.elapsed(),
        }
    };
    let (mut ended, installed) = two_at_a_time(first, install, in_process);
    ended.extend(two_at_a_time(installed.ready, || (), in_process).0);
    steps.add("packages", installed.elapsed, installed.without.is_empty());
    for step in ended {
        steps.add(step.step, step.elapsed, step.succeeded);
    }
    let names = (installed.without.iter()).map(|step| step.name.to_owned());
    steps.failed.extend(names);
}

/// Runs a step in a separate process; returns its name, its time, and whether it succeeded.
fn in_process(step: &Step) -> Ended {
    eprintln!("── {} begins: {}", step.name, step.what);
    let begin = Instant::now();
    let succeeded = task(&["test", "outside", INSTALLED, step.name]).is_some();
    Ended {
        step: step.name,
        elapsed: begin.elapsed(),
        succeeded,
    }
}
