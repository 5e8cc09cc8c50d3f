//! `cargo xtask test outside`: sprung against foreign programs, which it installs itself.
//!
//! A step that cannot install its programs fails: no step is skipped here.

mod arm;
mod formats;
mod mujoco;
pub(crate) mod python;
mod pythons;
mod vectors;
pub(crate) mod wheel;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use python::Python;

use crate::binaries::build;
use crate::install::hdf5;
use crate::run::{Outcome, two_at_a_time};
use crate::steps::{Steps, cargo, exit_code, task};
use crate::test::features;
use crate::{fuzz, summary, target};

/// A comparison with a foreign program.
struct Step {
    name: &'static str,
    what: &'static str,
    /// What pip installs for it; empty if it needs no Python.
    packages: &'static str,
    /// Returns `None`, and prints why, if the comparison fails.
    run: Run,
}

/// How a comparison runs.
#[derive(Clone, Copy)]
enum Run {
    Code(fn(&Python) -> Option<()>),
    /// Scripts with their arguments: `{sprung}` is the program, `{out}` a folder for the step. They print tables and fail above
    /// their limits.
    Scripts(&'static [&'static str]),
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

/// All steps: those without packages, then the long ones first. A new comparison is an entry here.
static STEPS: [Step; 14] = [
    Step {
        name: "benches",
        what: "every benchmark of cargo, once and with little work",
        packages: "",
        run: Run::Code(|_| benches()),
    },
    Step {
        name: "fuzz",
        what: "the fuzz targets compile",
        packages: "",
        run: Run::Code(|_| fuzz::compiles()),
    },
    Step {
        name: "arm",
        what: "exported C on Cortex-M4F and M7, in QEMU",
        packages: "",
        run: Run::Code(arm::check),
    },
    Step {
        name: "python",
        what: "the wheel: types, examples, tests, notebooks, the cost of a call",
        // What users of the wheel have.
        packages: "maturin numpy scipy scipy-stubs pandas pandas-stubs polars pyarrow pyarrow-stubs matplotlib tqdm types-tqdm \
                   nbclient nbconvert ipykernel mujoco mypy pytest pytest-xdist fsspec s3fs dask[distributed] ray[data] \
                   moto[server] duckdb",
        run: Run::Code(wheel::check),
    },
    Step {
        name: "new",
        what: "a hundred logs of ten known arms, begun by sprung new and identified without an edit",
        packages: "numpy scipy pyarrow mcap mcap-ros2-support example-robot-data",
        run: Run::Scripts(&["benches/arms/known_arms.py {sprung} {out}"]),
    },
    Step {
        name: "export",
        what: "exported robots in Pinocchio, MuJoCo and Drake",
        packages: "numpy pin mujoco drake example-robot-data cmeel-eigen",
        run: Run::Scripts(&[
            "benches/export/tools.py {sprung} {out}",
            "benches/export/controlled.py {sprung} {out}",
            "benches/export/rnea.py {sprung} {out}",
        ]),
    },
    Step {
        name: "foreign",
        what: "logs of an arm that Pinocchio describes, as other recorders write them",
        packages: "numpy numba pin example-robot-data",
        // Two logs of a minute each, whose torques do not act when they are recorded, of friction that is sharper than usual.
        run: Run::Scripts(&[
            "benches/foreign/run.py --strict --binary {sprung} --out {out} --jobs 2 --arms ur5 --seeds 1-1 --sharpness 200 \
             --records held,late --rates 500",
        ]),
    },
    Step {
        name: "servo",
        what: "a servo without torque, beside BAM's CMA-ES",
        packages: "--ignore-requires-python numpy better-actuator-models optuna cmaes",
        // So many trials of CMA-ES are enough for a comparison, not for convergence.
        run: Run::Scripts(&["benches/peers/servo_bam.py {sprung} {out} 50"]),
    },
    Step {
        name: "formats",
        what: "logs as their usual writers write them",
        packages: "numpy scipy h5py pandas pyarrow zstandard mcap mcap-ros2-support rosbags",
        run: Run::Code(formats::check),
    },
    Step {
        name: "mujoco",
        what: "an arm simulated by MuJoCo, identified",
        packages: "numpy mujoco",
        run: Run::Code(mujoco::check),
    },
    Step {
        name: "mat73-static",
        what: "the formats with a libhdf5 of their own, which CMake compiles",
        packages: "cmake",
        run: Run::Code(formats::with_own_libhdf5),
    },
    Step {
        name: "pinocchio",
        what: "torques and momenta of Pinocchio",
        packages: "numpy pin",
        run: Run::Code(vectors::pinocchio),
    },
    Step {
        name: "benchmark",
        what: "the scorer of the benchmark, its simulator and an adapter",
        packages: "numpy scipy",
        run: Run::Scripts(&["benchmark/test_benchmark.py"]),
    },
    Step {
        name: "scipy",
        what: "the zero-phase filter of SciPy",
        packages: "numpy scipy",
        run: Run::Code(vectors::scipy),
    },
];

impl Step {
    fn run(&self, python: &Python) -> Option<()> {
        let scripts = match self.run {
            Run::Code(run) => return run(python),
            Run::Scripts(scripts) => scripts,
        };
        if scripts.iter().any(|script| script.contains("{sprung}")) {
            mujoco::build()?;
        }
        let [sprung, out] = [target().join("debug/sprung"), python.folder.join(self.name)]
            .map(|path| path.to_string_lossy().into_owned());
        scripts.iter().try_for_each(|script| {
            let words: Vec<String> = (script.split_whitespace())
                .map(|word| word.replace("{sprung}", &sprung).replace("{out}", &out))
                .collect();
            python.run(&words[0], &words[1..])
        })
    }
}

/// Builds the benchmarks as the tests are built, and runs each as a test: once and with little work.
fn benches() -> Option<()> {
    let benches = build(cargo(), &["--workspace", "--bench", "*", features(hdf5())])?;
    let outcome = Outcome::of(&benches);
    outcome.failed.is_empty().then_some(())
}

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
            let packages = if is_installed { "" } else { step.packages };
            step.run(&Python::with(packages)?)
        });
    } else {
        side_by_side(&mut steps, chosen);
    }
    exit_code(summary::print(&steps, &Outcome::default()))
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
        let has_packages = |step: &&Step| Python::with(step.packages).is_some();
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
