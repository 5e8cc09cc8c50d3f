//! The page of what works with what, written from the table in the code.

use super::experiment::same_or_written;

#[test]
fn the_page_is_that_of_the_table() {
    same_or_written(
        "docs/reference/what-works.md",
        sprung::description::what_works(),
    );
}
