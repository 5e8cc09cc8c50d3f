//! Logs whose recorder lost power: read up to there, and said.

use crate::common::{Case, each};

#[test]
fn a_log_is_read_up_to_the_place_where_it_was_cut_off() {
    // Samples of the demo's log: a header and 10 000 rows of which the last ones are damaged.
    let whole = std::fs::read_to_string(Case::new().path("identification.csv")).unwrap();
    let rows: Vec<&str> = whole.lines().take(6002).collect();
    let complete = rows[..6001].join("\n") + "\n";
    let last = rows[6001];
    let half = &last[..last.len() / 2];
    let nul = "\0".repeat(100_000);
    #[rustfmt::skip]
    let rows = [
        ("in a row", format!("{complete}{half}"), Some("line 6002")),
        ("in a number", format!("{complete}{}-", last.rsplit_once(',').unwrap().0.to_owned() + ","), Some("line 6002")),
        ("before NUL bytes", format!("{complete}{nul}"), Some("line 6002")),
        ("in a row before NUL bytes", format!("{complete}{half}{nul}"), Some("line 6002")),
        ("in the last number before NUL bytes", format!("{complete}{}{nul}", &last[..last.len() - 1]), Some("line 6002")),
        ("no end of the last line", complete.trim_end().to_owned(), None),
    ];
    each(rows, |(name, text, cut)| {
        let case = Case::new();
        case.write("identification.csv", text);
        let output = case.run("check", &[]);
        let told = &output.out;
        assert_eq!(output.code, Some(0), "{name}: {told} {}", output.err);
        assert!(told.contains("6000 samples"), "{name}: {told}");
        assert_eq!(
            told.contains("log-cut-off"),
            cut.is_some(),
            "{name}: {told}"
        );
        assert!(told.contains(cut.unwrap_or_default()), "{name}: {told}");
    });
}

#[test]
fn a_row_that_is_too_short_in_the_middle_is_an_error() {
    let case = Case::new();
    let whole = case.read("identification.csv");
    let mut rows: Vec<&str> = whole.lines().collect();
    rows[3000] = "0.1,0.2";
    case.write("identification.csv", rows.join("\n"));
    case.identify(&[]).ends(3).tells(&["line 3001 of"]);
}
