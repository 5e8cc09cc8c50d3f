//! The runs of sprung that are profiled.

use std::path::Path;
use std::process::Command;

use crate::root;
use crate::steps::succeeds;

const LEAST_SQUARES: &str = "identify.estimator=[\"least-squares\"]";
const REFINEMENT: &str = "identify.estimator=[\"prediction-error\"]";
const DEMO: &str = "crates/sprung-base/src/demo";
const SEVEN: &str = "examples/seven-joint-twin";

/// A log that sprung simulates.
struct Log {
    experiment: &'static str,
    seconds: &'static str,
}

const DEMO_10_S: Log = Log {
    experiment: DEMO,
    seconds: "10",
};
const DEMO_1000_S: Log = Log {
    experiment: DEMO,
    seconds: "1000",
};
const SEVEN_15_S: Log = Log {
    experiment: SEVEN,
    seconds: "15",
};
const SEVEN_20_S: Log = Log {
    experiment: SEVEN,
    seconds: "20",
};

/// A run of sprung.
pub(super) struct Case {
    pub(super) name: &'static str,
    pub(super) what: &'static str,
    command: &'static str,
    log: Log,
    set: &'static [&'static str],
    /// Samples of the profile per second of processor time.
    pub(super) per_second: u32,
    /// Runs without a profile whose times are averaged.
    pub(super) timed_runs: u32,
}

pub(super) const CASES: &[Case] = &[
    Case {
        name: "demo",
        what: "identify by least squares, 10 s of two joints",
        command: "identify",
        log: DEMO_10_S,
        set: &[LEAST_SQUARES],
        per_second: 1999,
        timed_runs: 3,
    },
    Case {
        name: "million",
        what: "identify by least squares, 1 million samples of two joints",
        command: "identify",
        log: DEMO_1000_S,
        set: &[LEAST_SQUARES],
        per_second: 499,
        timed_runs: 3,
    },
    Case {
        name: "seven",
        what: "identify by least squares, 15 s of seven joints",
        command: "identify",
        log: SEVEN_15_S,
        set: &[LEAST_SQUARES],
        per_second: 999,
        timed_runs: 3,
    },
    Case {
        name: "demo-refined",
        what: "refine, 10 s of two joints",
        command: "identify",
        log: DEMO_10_S,
        set: &[REFINEMENT],
        per_second: 199,
        timed_runs: 3,
    },
    Case {
        name: "seven-refined",
        what: "refine, 15 s of seven joints",
        command: "identify",
        log: SEVEN_15_S,
        set: &[REFINEMENT],
        per_second: 49,
        timed_runs: 1,
    },
    Case {
        name: "check",
        what: "check, 20 s of seven joints",
        command: "check",
        log: SEVEN_20_S,
        set: &[],
        per_second: 499,
        timed_runs: 3,
    },
];

impl Case {
    /// Simulates the log unless it is there; returns the arguments of sprung, or `None` if a program
    /// fails.
    ///
    /// - `folder`: of the logs and the results.
    pub(super) fn arguments(&self, sprung: &Path, folder: &Path) -> Option<Vec<String>> {
        let Log {
            experiment,
            seconds,
        } = self.log;
        let experiment = root().join(experiment).display().to_string();
        let name = Path::new(self.log.experiment).file_name()?.to_str()?;
        let logs = folder.join(format!("{name}-{seconds}-s"));
        let log = logs.join("identification.csv");
        if !log.exists() {
            eprintln!("── simulates {}", log.display());
            let mut simulate = Command::new(sprung);
            let duration = format!("simulate.duration_s={seconds}");
            simulate
                .args(["simulate", &experiment, "--quiet", "--set", &duration])
                .arg("--out");
            succeeds(simulate.arg(&logs))?;
        }
        let mut arguments = vec![self.command.to_owned(), experiment, "--quiet".to_owned()];
        arguments.extend(["--threads", "1", "--set"].map(str::to_owned));
        arguments.push(format!("log.file={}", log.display()));
        for set in self.set {
            arguments.extend(["--set", set].map(str::to_owned));
        }
        let results = folder.join(self.name).display().to_string();
        arguments.extend(["--out".to_owned(), results]);
        Some(arguments)
    }
}
