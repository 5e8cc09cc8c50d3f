//! Runs that the caller stops, in each of their phases.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sprung::session::{
    ErrorKind, Parameters, Session, SessionError, compare_files, read_identification,
};
use sprung_base::progress::{Answer, Listener, Phase, Progress, Stopped, Unheard};

use crate::support::{SHORT, folder, owned, session, told};

/// Stops at the nth report of a phase, and counts the reports after that.
struct StopAt {
    phase: Phase,
    // Reports of the phase before the stop.
    left: u64,
    stopped: bool,
    after: u64,
}

impl Listener for StopAt {
    fn hear(&mut self, progress: Progress) -> Answer {
        self.after += u64::from(self.stopped);
        if progress.phase == self.phase && !self.stopped {
            self.stopped = self.left == 0;
            self.left = self.left.saturating_sub(1);
        }
        if self.stopped {
            Answer::Stop
        } else {
            Answer::GoOn
        }
    }
}

/// Checks that a run that is stopped at the nth report of a phase ends with `Stopped` and without further reports.
fn stops<T>(
    phase: Phase,
    after: u64,
    run: impl FnOnce(&mut dyn Listener) -> Result<T, SessionError>,
) {
    let mut listener = StopAt {
        phase,
        left: after,
        stopped: false,
        after: 0,
    };
    let outcome = run(&mut listener);
    assert!(listener.stopped, "nothing was said of {phase:?}");
    assert_eq!(listener.after, 0, "{phase:?} went on");
    let error = outcome.err().unwrap();
    assert_eq!(error.kind(), ErrorKind::Stopped, "{phase:?}: {error}");
    assert_eq!(error.to_string(), Stopped.to_string());
}

#[test]
fn a_check_stops() {
    let session = session(&[]);
    stops(Phase::Reading, 0, |p| session.check(p));
    stops(Phase::Reading, 1, |p| session.check(p));
}

#[test]
fn an_identification_stops_in_each_phase_and_leaves_the_one_before() {
    let session = session(&[]);
    let before = session.identify(&mut Unheard).unwrap();
    let kept = told(&before);
    for (phase, after) in [
        (Phase::Preparing, 0),
        (Phase::Preparing, 2),
        (Phase::Reading, 0),
        (Phase::Reading, 1),
        (Phase::Examining, 0),
    ] {
        stops(phase, after, |p| session.identify(p));
    }
    assert_eq!(kept, told(&before));
    assert_eq!(kept, told(&session.identify(&mut Unheard).unwrap()));
}

#[test]
fn a_refinement_stops() {
    let session = session(&["identify.estimator=[\"prediction-error\"]"]);
    for after in [0, 2] {
        stops(Phase::Refining, after, |p| session.identify(p));
    }
}

#[test]
fn a_search_of_velocities_stops() {
    let session = session(&[
        "identify.estimator=[\"prediction-error\"]",
        "robot.joint.1.motor_friction=[\"viscous\", \"coulomb\", \"stribeck\"]",
    ]);
    for after in [0, 1] {
        stops(Phase::FindingVelocities, after, |p| session.identify(p));
    }
}

#[test]
fn a_validation_stops() {
    let session = session(&[]);
    let found = session.identify(&mut Unheard).unwrap();
    let parameters = Parameters::from(found.identification);
    for after in [0, 1, 2] {
        stops(Phase::Validating, after, |p| {
            session.validate(&parameters, p)
        });
    }
}

#[test]
fn a_twin_stops() {
    let session = session(&[]);
    let twin = session.twin(None, None).unwrap();
    let mut log = Vec::new();
    stops(Phase::Simulating, 1, |p| twin.write(&mut log, p));
    let lines = log.split(|byte| *byte == b'\n').count();
    // The header, two parts of 1024 samples between calls, and nothing behind the last line.
    assert_eq!(lines, 1 + 2 * 1024 + 1, "of 3001 lines");
}

/// Bytes of all files in a folder and those inside.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(bytes(&path));
        } else {
            all.insert(path.clone(), std::fs::read(path).unwrap());
        }
    }
    all
}

#[test]
fn results_on_disk_are_whole_after_a_stop() {
    let folder = folder("stopped");
    let session = Session::open(&folder, &owned(&SHORT)).unwrap();
    let found = session.identify(&mut Unheard).unwrap();
    let file = folder.join("sprung-out/identification.json");
    let other = folder.join("other.json");
    for file in [&file, &other] {
        let text = serde_json::to_string(&found.identification).unwrap();
        std::fs::write(file, text).unwrap();
    }
    let before = bytes(&folder);
    let parameters = Parameters::open(&file).unwrap();
    stops(Phase::Reading, 1, |p| session.check(p));
    stops(Phase::Preparing, 1, |p| session.identify(p));
    stops(Phase::Reading, 1, |p| session.identify(p));
    stops(Phase::Examining, 1, |p| session.identify(p));
    stops(Phase::Validating, 1, |p| session.validate(&parameters, p));
    stops(Phase::Comparing, 1, |p| compare_files(&[&file, &other], p));
    assert_eq!(before, bytes(&folder));
    let read = read_identification(&folder).unwrap().identification;
    assert_eq!(read.results.len(), found.identification.results.len());
}
