//! The table of claims: its cheap commands show what it says.

use super::{beside_the_demo, of_repository};
use crate::common::{Ran, program};

/// Returns the cells of each row of the table.
fn rows(page: &str) -> Vec<Vec<&str>> {
    let lines = page.lines().filter(|line| line.starts_with("| "));
    lines
        .skip(1)
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

#[test]
fn cheap_claims_are_shown() {
    let page = of_repository("CLAIMS.md");
    assert!(page.split_whitespace().count() <= 800);
    let folder = beside_the_demo();
    let mut count = 0;
    for row in rows(&page) {
        let [claim, command, shows] = row[..] else {
            panic!("{row:?}");
        };
        let Some(words) = command.trim_matches('`').strip_prefix("sprung ") else {
            continue;
        };
        let output = Ran::of(program().args(words.split(' ')).current_dir(folder.path()));
        let text = &output.out;
        assert!(output.code == Some(0), "{claim}: {output:?}");
        assert!(text.contains(shows.trim_matches('`')), "{claim}: {text}");
        count += 1;
    }
    assert!(count >= 12, "{count}");
}
