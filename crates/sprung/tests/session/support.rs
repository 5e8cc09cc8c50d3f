//! The demo's experiment with short logs.

use std::borrow::Borrow;
use std::collections::BTreeMap;
use std::io::{Cursor, Error, ErrorKind, Result as IoResult};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use sprung::session::Session;
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_log::Input;
use sprung_method::estimate::Identified;
use sprung_testing::Messages;

/// Files by name.
pub(crate) type Memory = BTreeMap<&'static str, Vec<u8>>;

/// Overrides that make runs short: a log of 3 s, and least squares only.
pub(crate) const SHORT: [&str; 2] = [
    "simulate.duration_s=3.0",
    "identify.estimator=[\"least-squares\"]",
];

/// Returns the files of the demo, logs included; they are recorded once.
pub(crate) fn files() -> &'static Memory {
    static FILES: OnceLock<Memory> = OnceLock::new();
    FILES.get_or_init(|| {
        let mut files = Memory::new();
        files.insert("truth.toml", demo::TRUTH.as_bytes().to_vec());
        let session = of_memory(files.clone(), &[]);
        let mut record = |name: &'static str, run: Option<&str>, seed: u64| {
            let twin = session.twin(run, None).unwrap().with_seed(seed);
            assert_eq!(twin.named(), Path::new(name));
            let mut log = Vec::new();
            twin.write(&mut log, &mut Unheard).unwrap();
            files.insert(name, log);
        };
        record("identification.csv", None, 1);
        record("validation.csv", Some("prediction"), 2);
        files
    })
}

/// Returns a session with files in memory.
pub(crate) fn of_memory(files: Memory, more: &[&str]) -> Session {
    in_memory(files, &[&SHORT[..], more].concat())
}

/// Opens files in memory.
pub(crate) fn opener<K: Borrow<str> + Ord>(
    files: BTreeMap<K, Vec<u8>>,
) -> impl Fn(&Path) -> IoResult<Box<dyn Input>> {
    move |path| match path.to_str().and_then(|name| files.get(name)) {
        Some(bytes) => Ok(Box::new(Cursor::new(bytes.clone()))),
        None => Err(Error::from(ErrorKind::NotFound)),
    }
}

/// Records the log of a session's twin.
pub(crate) fn recorded(session: &Session) -> Vec<u8> {
    let mut log = Vec::new();
    let twin = session.twin(None, None).unwrap();
    twin.write(&mut log, &mut Unheard).unwrap();
    log
}

/// Returns a session of the demo with files in memory.
pub(crate) fn in_memory(files: Memory, overrides: &[&str]) -> Session {
    let open = opener(files);
    Session::read("experiment.toml", demo::EXPERIMENT, &owned(overrides), open).unwrap()
}

/// Returns a session of the demo.
pub(crate) fn session(more: &[&str]) -> Session {
    of_memory(files().clone(), more)
}

/// Messages of a test, whose file is in `tests/messages`.
pub(crate) fn messages(test: &str) -> Messages {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/messages");
    Messages::new(format!("{folder}/{test}.txt"))
}

/// Writes the demo into a folder of the tests, and returns it.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("session")
        .join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    std::fs::create_dir_all(folder.join("sprung-out")).unwrap();
    std::fs::write(folder.join("experiment.toml"), demo::EXPERIMENT).unwrap();
    for (name, bytes) in files() {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
    folder
}

/// Returns an identification as text, without its elapsed times.
pub(crate) fn told(found: &Identified) -> String {
    let mut identification = found.identification.clone();
    for result in &mut identification.results {
        result.elapsed_s = 0.0;
    }
    serde_json::to_string_pretty(&identification).unwrap()
}

/// Returns overrides as owned strings.
pub(crate) fn owned(overrides: &[&str]) -> Vec<String> {
    overrides.iter().map(|text| (*text).to_owned()).collect()
}
