//! Measures errors, intervals and time of the servo in `examples/servo-pendulum`.
//!
//! `cargo bench -p sprung --bench servo -- --seeds 20` simulates both logs with each seed and identifies the servo.
//! `--set KEY.PATH=VALUE` changes the experiment, as on the command line.
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]
#![expect(clippy::expect_used, reason = "a benchmark may panic")]

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;
use std::time::Instant;

use sprung::session::Session;
use sprung_base::progress::Unheard;
use sprung_log::Input;
use sprung_servo::ServoIdentification;
use sprung_testing::Figure;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/servo-pendulum");

/// Files by name, in memory.
type Stored = BTreeMap<String, Vec<u8>>;

struct Arguments {
    seeds: u64,
    set: Vec<String>,
}

impl Arguments {
    /// Reads the command line. Returns `None` if `cargo bench` did not start the program.
    fn new() -> Option<Self> {
        let mut found = Self {
            seeds: 20,
            set: Vec::new(),
        };
        let mut bench = false;
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            match word.as_str() {
                "--bench" => bench = true,
                "--seeds" => {
                    let seeds = words.next().expect("a number behind --seeds");
                    found.seeds = seeds.parse().expect("a number behind --seeds");
                }
                "--set" => found
                    .set
                    .push(words.next().expect("an assignment behind --set")),
                other => panic!("unknown argument {other}"),
            }
        }
        bench.then_some(found)
    }
}

fn main() {
    let Some(arguments) = Arguments::new() else {
        return;
    };
    let truth = std::fs::read_to_string(Path::new(FOLDER).join("truth.toml")).expect("truth.toml");
    let true_values: BTreeMap<String, f64> = toml::from_str(&truth).expect("values by name");
    let mut errors: BTreeMap<String, Vec<[f64; 2]>> = BTreeMap::new();
    let mut longest = 0.0_f64;
    for seed in 1..=arguments.seeds {
        let mut set = arguments.set.clone();
        set.push(format!("simulate.seed={seed}"));
        let (found, seconds) = identified(&set, &truth);
        longest = longest.max(seconds);
        println!(
            "seed {seed}: {seconds:.2} s, residual {:.2} times the noise",
            found.fit.position_rms_over_noise
        );
        for parameter in &found.parameters {
            if let (Some(error), Some(truth)) =
                (parameter.standard_error, true_values.get(&parameter.name))
            {
                let difference = parameter.value - truth;
                let pairs = errors.entry(parameter.name.clone()).or_default();
                pairs.push([difference / truth, difference / error]);
            }
        }
    }
    println!("longest time {longest:.2} s");
    println!(
        "parameter                        largest error %   mean error %   intervals with the truth"
    );
    for (name, pairs) in &errors {
        let largest = pairs
            .iter()
            .map(|[error, _]| error.abs())
            .fold(0.0, f64::max);
        let mean = pairs.iter().map(|[error, _]| error).sum::<f64>() / pairs.len() as f64;
        let kept = pairs.iter().filter(|[_, ratio]| ratio.abs() < 1.96).count();
        println!(
            "{name:32} {:15.1} {:14.2}   {kept} of {}",
            100.0 * largest,
            100.0 * mean,
            pairs.len()
        );
        Figure::lower(
            name,
            &format!("`{name}`: largest error"),
            100.0 * largest,
            "%",
        )
        .note();
    }
    let all = || errors.values().flatten();
    let kept = all().filter(|[_, ratio]| ratio.abs() < 1.96).count();
    let inside = 100.0 * kept as f64 / all().count() as f64;
    let text = format!(
        "95 % intervals that contain the truth, {} logs",
        arguments.seeds
    );
    Figure::neutral("inside", &text, inside, "%").note();
}

/// Simulates the logs with some settings and identifies the servo. Returns the result and its time, s.
fn identified(set: &[String], truth: &str) -> (ServoIdentification, f64) {
    let path = Path::new(FOLDER).join("experiment.toml");
    let text = std::fs::read_to_string(path).expect("experiment.toml");
    let mut stored = Stored::from([("truth.toml".to_owned(), truth.as_bytes().to_vec())]);
    let twin = open(&text, set, &stored);
    let recording = twin.servo_twin(None).expect("a twin");
    for (index, file) in recording.files().iter().enumerate() {
        let mut csv = Vec::new();
        let written = recording.write(index, &mut csv, &mut Unheard);
        written.expect("a log");
        stored.insert(file.display().to_string(), csv);
    }
    let session = open(&text, set, &stored);
    let start = Instant::now();
    let found = session.identify_servo(&mut Unheard).expect("a result");
    (found, start.elapsed().as_secs_f64())
}

/// Opens the experiment with its files in memory.
fn open(text: &str, set: &[String], stored: &Stored) -> Session {
    let stored = stored.clone();
    let files = move |path: &Path| {
        let bytes = stored.get(&path.display().to_string()).cloned();
        let bytes = bytes.ok_or(std::io::ErrorKind::NotFound)?;
        Ok(Box::new(Cursor::new(bytes)) as Box<dyn Input>)
    };
    Session::read("experiment.toml", text, set, files).expect("an experiment")
}
