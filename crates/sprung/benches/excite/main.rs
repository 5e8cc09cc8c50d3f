//! Designed experiments beside the paper's reference and random series, and on random arms.
//!
//! `cargo bench -p sprung --bench excite -- two-joints [--runs 200] | seven-joints [--random 200] | arms [--count 100]`
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

mod arms;
mod seven;
mod two;

use std::io::Cursor;
use std::path::Path;

use sprung::excite::Excited;
use sprung::log::Input;
use sprung::progress::Unheard;
use sprung::session::{ExciteMethod, ExciteRequest, Parameters, Session, SessionError};

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let has = |word: &str| words.iter().any(|own| own == word);
    if !has("--bench") {
        println!("cargo bench -p sprung --bench excite -- two-joints prints a table");
        return;
    }
    if has("two-joints") {
        two::run(number(&words, "--runs", 200));
    }
    if has("seven-joints") {
        seven::run(number(&words, "--random", 200));
    }
    if has("arms") {
        arms::run(number(&words, "--first", 1), number(&words, "--count", 100));
    }
}

/// Returns the number after a word.
fn number(words: &[String], word: &str, usual: u64) -> u64 {
    let mut words = words.iter().skip_while(|own| *own != word);
    let given = words
        .nth(1)
        .map(|own| own.parse().expect("a number follows"));
    given.unwrap_or(usual)
}

/// Reads an experiment whose files all have one text.
pub(crate) fn session(text: &str, set: &[String], file: &str) -> Session {
    let file = file.to_owned();
    let open =
        move |_: &Path| Ok(Box::new(Cursor::new(file.clone().into_bytes())) as Box<dyn Input>);
    Session::read("bench", text, set, open).expect("the experiment is right")
}

/// Designs or judges a motion.
pub(crate) fn excite(
    session: &Session,
    method: ExciteMethod,
    parameters: Option<&Parameters>,
) -> Result<Excited, SessionError> {
    let request = ExciteRequest {
        method,
        ..ExciteRequest::default()
    };
    session.excite(&request, parameters, &mut Unheard)
}

/// Returns the standard errors of a promise.
pub(crate) fn errors(excited: &Excited) -> Vec<f64> {
    let all = excited.excitation.promise.iter();
    all.map(|own| own.standard_error).collect()
}

/// Returns the geometric mean of ratios.
pub(crate) fn mean_ratio(of: &[f64], to: &[f64]) -> f64 {
    let logs: f64 = of.iter().zip(to).map(|(a, b)| (a / b).ln()).sum();
    (logs / of.len() as f64).exp()
}
