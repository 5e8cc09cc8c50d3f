//! Designed experiments beside the paper's reference and random series, and on random arms.
//!
//! `cargo bench -p sprung --bench excite -- two-joints [--runs 200] | rounds [--robots 6] | seven-joints [--random 200] [--write FOLDER] | arms [--count 100]`
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

mod arms;
mod rounds;
mod seven;
mod two;

use std::io::Cursor;
use std::path::{Path, PathBuf};

use sprung::session::{
    ExciteMethod, ExciteRequest, Parameters, Session, SessionError, excitation_files,
};
use sprung_base::progress::Unheard;
use sprung_log::Input;
use sprung_method::excite::Excited;

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let has = |word: &str| words.iter().any(|other| other == word);
    if !has("--bench") {
        println!("cargo bench -p sprung --bench excite -- two-joints prints a table");
        return;
    }
    if has("two-joints") {
        two::run(number(&words, "--runs", 200));
    }
    if has("rounds") {
        rounds::run(number(&words, "--robots", 6));
    }
    if has("seven-joints") {
        match after(&words, "--write") {
            Some(folder) => seven::arm().write(Path::new(folder)).expect("a folder"),
            None => seven::run(number(&words, "--random", 200)),
        }
    }
    if has("arms") {
        arms::run(number(&words, "--first", 1), number(&words, "--count", 100));
    }
}

/// Returns the word after a word.
fn after<'a>(words: &'a [String], word: &str) -> Option<&'a String> {
    words.iter().skip_while(|other| *other != word).nth(1)
}

/// Returns the number after a word.
fn number(words: &[String], word: &str, usual: u64) -> u64 {
    let given = after(words, word).map(|text| text.parse().expect("a number follows"));
    given.unwrap_or(usual)
}

/// Name of the file with a motion that is judged.
pub(crate) const REFERENCE: &str = "reference.toml";

/// Reads an experiment whose files all have one text.
pub(crate) fn session(text: &str, set: &[String], file: &str) -> Session {
    session_with(text, set, file, "")
}

/// Reads an experiment with a motion that is judged; all other files have one text.
pub(crate) fn session_with(text: &str, set: &[String], file: &str, reference: &str) -> Session {
    let (file, reference) = (file.to_owned(), reference.to_owned());
    let open = move |path: &Path| {
        let content = if path.ends_with(REFERENCE) {
            &reference
        } else {
            &file
        };
        Ok(Box::new(Cursor::new(content.clone().into_bytes())) as Box<dyn Input>)
    };
    Session::read("bench", text, set, open).expect("the experiment is right")
}

/// Judges the motion of a session's reference.
pub(crate) fn judged(session: &Session) -> Result<Excited, SessionError> {
    let request = ExciteRequest {
        reference: Some(PathBuf::from(REFERENCE)),
        ..ExciteRequest::default()
    };
    session.excite(&request, None, &mut Unheard)
}

/// Returns a motion as the reference of a controller.
pub(crate) fn reference(session: &Session, found: &Excited) -> String {
    let files = excitation_files(session, found);
    let mut files = files.into_iter();
    let found = files.find(|(name, _)| *name == REFERENCE);
    found.expect("a reference").1
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
    all.map(|promised| promised.standard_error).collect()
}

/// Returns the geometric mean of ratios.
pub(crate) fn mean_ratio(of: &[f64], to: &[f64]) -> f64 {
    let logs: f64 = of.iter().zip(to).map(|(a, b)| (a / b).ln()).sum();
    (logs / of.len() as f64).exp()
}
