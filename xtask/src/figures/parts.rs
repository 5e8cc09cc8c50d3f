//! The parts of the figures: their commands, and the code that they measure.

use std::fs;
use std::path::Path;

use super::run::{Run, data, foreign_logs};
use crate::outside::python::Python;
use crate::outside::wheel::{self, For};
use crate::steps::succeeds;
use crate::{root, target};

/// A group of figures that one run measures, and one table of the documentation.
pub(super) struct Part {
    pub(super) name: &'static str,
    /// Folders whose code the figures measure, as path specifications of git.
    pub(super) code: &'static [&'static [&'static str]],
    /// What pip installs for it.
    packages: &'static [&'static str],
    run: fn(&Run) -> Option<()>,
}

const METHOD: &str = "crates/sprung-method/src";
const LOG: &str = "crates/sprung-log/src";
/// Leaves out the readers of Arrow and Parquet, for parts whose logs are text.
const NO_ARROW: &str = ":(exclude)crates/sprung-log/src/formats/arrow*";
const CORE: &str = "crates/sprung-core/src";
const MODEL: &str = "crates/sprung-model/src";
const ROBOT: &str = "crates/sprung-robot/src";

/// Code of identifications; they design no motion.
const IDENTIFICATION: &[&str] = &[
    METHOD,
    ":(exclude)crates/sprung-method/src/excite",
    CORE,
    MODEL,
];
/// Code that reads logs of text.
const TEXT_LOGS: &[&str] = &[LOG, NO_ARROW];

/// All parts, in the order of the documentation. A new part is a line here and its notes in a benchmark.
pub(super) const PARTS: [Part; 23] = [
    Part {
        name: "twins",
        code: &[
            IDENTIFICATION,
            TEXT_LOGS,
            &["crates/sprung/benches/accuracy"],
        ],
        packages: &["numpy==2.4.6", "mujoco==4.0.0"],
        run: |run| {
            let logs = target().join("mujoco");
            if !logs.join("009.csv").exists() {
                run.python("benches/peers/two_joints_mujoco.py", &[&logs])?;
            }
            let arguments = ["--mujoco", &logs.to_string_lossy()];
            run.bench("sprung", "accuracy", &arguments)
        },
    },
    Part {
        name: "intervals",
        code: &[
            IDENTIFICATION,
            TEXT_LOGS,
            &["crates/sprung/benches/accuracy"],
        ],
        packages: &[],
        run: |run| {
            let lengths = ["--lengths", "10,60,300", "--seeds", "20"];
            run.bench("sprung", "accuracy", &lengths)
        },
    },
    Part {
        name: "verdicts",
        code: &[
            IDENTIFICATION,
            TEXT_LOGS,
            &["crates/sprung/benches/verdicts"],
        ],
        packages: &[],
        run: |run| run.bench("sprung", "verdicts", &["--cases", "30"]),
    },
    Part {
        name: "machines",
        code: &[IDENTIFICATION, TEXT_LOGS, &[ROBOT, "benches/machines"]],
        packages: &[],
        run: |run| {
            let sprung = run.sprung()?;
            run.python(
                "benches/machines/run.py",
                &[
                    Path::new("--data"),
                    &data()?,
                    Path::new("--binary"),
                    &sprung,
                ],
            )
        },
    },
    Part {
        name: "examples",
        code: &[
            IDENTIFICATION,
            TEXT_LOGS,
            &[
                ROBOT,
                "benches/examples",
                "crates/sprung/tests/twin/seven.rs",
            ],
        ],
        packages: &[],
        run: |run| {
            let sprung = run.sprung()?;
            let words = [
                Path::new("--data"),
                &data()?,
                Path::new("--binary"),
                &sprung,
            ];
            run.python("benches/examples/run.py", &words)?;
            let names = [
                "exact_positions",
                "encoders_and",
                "refined_drives",
                "offset_that",
            ];
            run.test("sprung", "twin", &names)
        },
    },
    Part {
        name: "foreign",
        code: &[IDENTIFICATION, TEXT_LOGS, &["benches/foreign"]],
        packages: &[
            "numpy==2.4.6",
            "numba==0.68.1",
            "pin==4.1.0",
            "example-robot-data==6.0.0",
        ],
        run: |run| {
            let (sprung, logs) = (run.sprung()?, foreign_logs());
            let words = [
                "--arms",
                "ur5,panda",
                "--seeds",
                "1-1",
                "--rates",
                "1000,250",
                "--sharpness",
                "100",
                "--held-out",
                "--jobs",
                "2",
            ];
            let mut arguments: Vec<&Path> = words.iter().map(Path::new).collect();
            arguments.extend([Path::new("--binary"), &sprung, Path::new("--out"), &logs]);
            run.python("benches/foreign/run.py", &arguments)
        },
    },
    Part {
        name: "diagnoses",
        code: &[IDENTIFICATION, TEXT_LOGS, &["benches/diagnoses"]],
        packages: &[
            "numpy==2.4.6",
            "numba==0.68.1",
            "pin==4.1.0",
            "example-robot-data==6.0.0",
        ],
        run: |run| {
            let (sprung, logs) = (run.sprung()?, foreign_logs());
            let damaged = target().join("figures/diagnoses");
            run.python(
                "benches/diagnoses/run.py",
                &[
                    Path::new("--binary"),
                    &sprung,
                    Path::new("--foreign"),
                    &logs,
                    Path::new("--out"),
                    &damaged,
                ],
            )
        },
    },
    Part {
        name: "arms",
        code: &[
            IDENTIFICATION,
            &[LOG, ROBOT, "benches/arms"],
            &[
                "crates/sprung/src",
                ":(exclude)crates/sprung/src/session/excite",
            ],
        ],
        packages: &[
            "numpy==2.4.6",
            "scipy==1.17.1",
            "pyarrow==26.0.1",
            "mcap==1.6.0",
            "mcap-ros2-support==0.6.0",
            "example-robot-data==6.0.0",
        ],
        run: |run| {
            let logs = target().join("figures/arms");
            run.python("benches/arms/known_arms.py", &[&run.sprung()?, &logs])
        },
    },
    Part {
        name: "servo",
        code: &[&[
            "crates/sprung-servo/src",
            "crates/sprung/benches/servo",
            "benches/peers/servo_bam.py",
        ]],
        packages: &[
            // The package requires Python 3.12, and its models run on 3.11.
            "--ignore-requires-python",
            "numpy==2.4.6",
            "better-actuator-models==1.0.2",
            "optuna==5.0.0",
            "cmaes==0.13.1",
        ],
        run: |run| {
            run.bench("sprung", "servo", &["--seeds", "20"])?;
            let folder = target().join("figures/servo");
            run.python(
                "benches/peers/servo_bam.py",
                &[&run.sprung()?, &folder, Path::new("400")],
            )
        },
    },
    Part {
        name: "springs",
        code: &[
            IDENTIFICATION,
            &[
                "crates/sprung/benches/springs",
                "crates/sprung/benches/stiff",
            ],
        ],
        packages: &[],
        run: |run| {
            run.bench("sprung", "springs", &[])?;
            run.bench("sprung", "stiff", &[])
        },
    },
    Part {
        name: "design",
        code: &[&[
            METHOD,
            CORE,
            MODEL,
            "crates/sprung/src",
            "crates/sprung/benches/excite",
        ]],
        packages: &[],
        run: |run| {
            let cases = ["two-joints", "rounds", "seven-joints", "arms"];
            let extent = [
                "--runs", "50", "--robots", "2", "--random", "50", "--count", "10",
            ];
            run.bench("sprung", "excite", &[&cases[..], &extent].concat())
        },
    },
    Part {
        name: "sensors",
        code: &[IDENTIFICATION, TEXT_LOGS, &["crates/sprung/tests/twin"]],
        packages: &[],
        run: |run| {
            let names = [
                "stiffnesses_and_inertias",
                "they_follow_from",
                "motion_gives_stiffnesses",
            ];
            run.test("sprung", "twin", &names)
        },
    },
    Part {
        name: "clocks",
        code: &[TEXT_LOGS, &["crates/sprung-log/tests/formats"]],
        packages: &[],
        run: |run| run.test("sprung-log", "formats", &["resampling"]),
    },
    Part {
        name: "bodies",
        code: &[IDENTIFICATION, &["crates/sprung/benches/physical"]],
        packages: &[],
        run: |run| {
            for (only, seeds) in [("bodies", "5"), ("bounds", "5"), ("payload", "2")] {
                let extent = ["--only", only, "--seeds", seeds];
                run.bench("sprung", "physical", &extent)?;
            }
            Some(())
        },
    },
    Part {
        name: "checks",
        code: &[
            IDENTIFICATION,
            TEXT_LOGS,
            &[
                "crates/sprung/benches/faults",
                "crates/sprung/benches/delays",
            ],
        ],
        packages: &[],
        run: |run| {
            let faults = ["--seeds", "4"];
            run.bench("sprung", "faults", &faults)?;
            let delays = ["--seeds", "1", "--sizes", "0,2,20"];
            run.bench("sprung", "delays", &delays)
        },
    },
    Part {
        name: "control",
        code: &[
            IDENTIFICATION,
            &[
                "crates/sprung-export/src",
                "benches/control",
                "benches/export",
            ],
        ],
        packages: &["numpy==2.4.6", "mujoco==4.0.0"],
        run: |run| {
            let sprung = run.sprung()?;
            let demo = target().join("figures/control");
            succeeds(
                run.command(&sprung)
                    .args(["demo", "--quiet", "--out"])
                    .arg(&demo),
            )?;
            run.python("benches/control/poses.py", &[&sprung, &demo])?;
            let folder = target().join("figures/controlled");
            run.python("benches/export/controlled.py", &[&sprung, &folder])
        },
    },
    Part {
        name: "drift",
        code: &[IDENTIFICATION, &["benches/drift"]],
        packages: &[],
        run: |run| {
            let (sprung, runs) = (run.sprung()?, target().join("figures/drift"));
            run.python(
                "benches/drift/run.py",
                &[Path::new("--binary"), &sprung, Path::new("--out"), &runs],
            )
        },
    },
    Part {
        name: "arm",
        code: &[&["crates/sprung-export/src", CORE, "benches/arm"]],
        packages: &[],
        run: |run| {
            let program = std::env::current_exe().ok()?;
            succeeds(run.command(program).args(["test", "outside", "arm"]))
        },
    },
    Part {
        name: "fleet",
        code: &[&["crates/sprung-python/python/sprung/fleet", "benches/fleet"]],
        packages: &[
            wheel::MATURIN,
            "numpy==2.4.6",
            "scipy==1.17.1",
            "pyarrow==26.0.1",
            "fsspec==2026.9.0",
        ],
        run: |run| {
            wheel::install(&run.python, For::Figures)?;
            run.python(
                "benches/fleet/statistics.py",
                &[Path::new("--fleets"), Path::new("50")],
            )
        },
    },
    Part {
        name: "speed",
        code: &[
            IDENTIFICATION,
            TEXT_LOGS,
            &["crates/sprung-cli/src", "benches/peers"],
        ],
        packages: &[],
        run: |run| {
            let sprung = run.sprung()?;
            let folder = target().join("figures/peers");
            succeeds(
                run.command("python3")
                    .arg(root().join("benches/peers/run.py"))
                    .arg(folder)
                    .env("SPRUNG", sprung),
            )?;
            run.bench("sprung-cli", "size", &[])
        },
    },
    Part {
        name: "beside",
        code: &[IDENTIFICATION, &["benches/beside", "benches/peers"]],
        packages: &[
            wheel::MATURIN,
            "numpy==2.4.6",
            "scipy==1.17.1",
            "pandas==3.1.1",
            "pin==4.1.0",
            "figaroh==1.0.2",
            "mujoco[sysid]==4.0.0",
        ],
        run: |run| {
            wheel::install(&run.python, For::Figures)?;
            run.python("benches/beside/run.py", &[])
        },
    },
    Part {
        name: "python",
        code: &[&["crates/sprung-python/src", "benches/python"]],
        packages: &[wheel::MATURIN, "numpy==2.4.6"],
        run: |run| {
            wheel::install(&run.python, For::Figures)?;
            run.python("benches/python/overhead.py", &[])
        },
    },
    Part {
        name: "sizes",
        code: &[&["crates", "Cargo.lock"]],
        packages: &[],
        run: |run| {
            let sprung = run.sprung()?;
            run.python("benches/sizes/run.py", &[Path::new("--binary"), &sprung])
        },
    },
];

impl Part {
    /// Runs the part; returns `None`, and prints why, if a program fails. Its notes are in a new file.
    pub(super) fn run(&self, notes: &Path) -> Option<()> {
        let folder = notes.parent()?;
        fs::create_dir_all(folder)
            .inspect_err(|error| eprintln!("── cannot create {}: {error}", folder.display()))
            .ok()?;
        fs::write(notes, "")
            .inspect_err(|error| eprintln!("── cannot write {}: {error}", notes.display()))
            .ok()?;
        let run = Run {
            python: Python::with(&target().join("outside"), self.packages)?,
            notes: notes.canonicalize().ok()?,
        };
        (self.run)(&run)
    }
}
