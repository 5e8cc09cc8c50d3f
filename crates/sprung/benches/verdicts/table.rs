//! The table of all cases.

use std::collections::BTreeMap;

use sprung_testing::Figure;

use crate::kind::Kind;
use crate::outcome::Outcome;

/// Prints the table of an estimator.
pub(crate) fn print(estimator: &str, outcomes: &[Outcome]) {
    println!(
        "\n{estimator}: cases, of which refused, unusable, doubtful, good; good and wrong; truly good, of which not good"
    );
    let of_kind = |kind: Option<Kind>| -> Vec<&Outcome> {
        (outcomes.iter())
            .filter(|outcome| outcome.estimator == estimator)
            .filter(|outcome| kind.is_none_or(|kind| outcome.kind == kind))
            .collect()
    };
    for kind in Kind::ALL {
        row(estimator, kind.name(), &of_kind(Some(kind)));
    }
    row(estimator, "all", &of_kind(None));
    let missed = of_kind(None);
    let missed = missed
        .into_iter()
        .filter(|o| o.is_truly_good() && o.verdict != "good");
    let mut codes: BTreeMap<&str, usize> = BTreeMap::new();
    for code in missed.flat_map(|outcome| &outcome.codes) {
        *codes.entry(code).or_default() += 1;
    }
    println!("  findings of truly good cases that are not good: {codes:?}");
}

fn row(estimator: &str, name: &str, outcomes: &[&Outcome]) {
    if outcomes.is_empty() {
        return;
    }
    let count = |of: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|o| of(o)).count();
    let with = |verdict: &str| count(&|outcome: &Outcome| outcome.verdict == verdict);
    let share = |part: usize, all: usize| 100.0 * part as f64 / all.max(1) as f64;
    let wrong = count(&|o| o.verdict == "good" && o.is_wrong_if_good());
    let (truly, missed) = (
        count(&Outcome::is_truly_good),
        count(&|o| o.is_truly_good() && o.verdict != "good"),
    );
    println!(
        "  {name:16} {:4} | {:4} {:4} {:4} {:4} | {wrong:3} ({:.1} %) | {truly:4}, {missed:3} ({:.1} %)",
        outcomes.len(),
        with("refused"),
        with("unusable"),
        with("doubtful"),
        with("good"),
        share(wrong, with("good")),
        share(missed, truly),
    );
    let figure = |what: &str, text: &str, value: f64| {
        let text = format!("{name}, {estimator}, {} cases: {text}", outcomes.len());
        Figure::lower(&format!("{name}, {estimator}, {what}"), &text, value, "%").note();
    };
    let refuted = "*good* verdicts that held-out data refute";
    figure("wrong", refuted, share(wrong, with("good")));
    let text = "truly good results that are not called *good*";
    figure("missed", text, share(missed, truly));
}
