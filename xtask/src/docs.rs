//! `cargo xtask docs`: pages of the documentation that come from the program.

use std::process::{Command, ExitCode};

use crate::figures;
use crate::install::hdf5;
use crate::publication;
use crate::root;
use crate::steps::{exit_code, succeeds};
use crate::test::features;

/// Writes `docs/reference/experiment.md` from the JSON schema, `docs/reference/what-works.md` from the table of what
/// works with what, `docs/reference/findings.md` from the explanations of findings, the figures into all pages and drawings, and the values
/// of `publication.toml` into all files that name them.
///
/// Tests compare the pages with the program; with `SPRUNG_WRITE_DOCS` they write them.
pub(crate) fn write() -> ExitCode {
    let mut command = Command::new(env!("CARGO"));
    command
        .args(["test", "--workspace", "--test", "cli", features(hdf5())])
        .args([
            "--",
            "pages::experiment",
            "pages::findings",
            "pages::what_works",
        ])
        .env("SPRUNG_WRITE_DOCS", "1")
        .current_dir(root());
    let written = succeeds(&mut command);
    let pages = publication::write().and(figures::write_pages());
    exit_code(pages.and(written).is_some())
}
