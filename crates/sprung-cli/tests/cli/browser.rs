//! The report in a real browser draws every plot and logs nothing on the console.

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

use crate::common::demo;

/// The browser, or `None` and a report that the test is skipped.
fn browser() -> Option<PathBuf> {
    let found = ["chromium", "chromium-browser", "google-chrome"]
        .iter()
        .flat_map(|name| {
            ["/usr/bin", "/usr/local/bin", "/snap/bin"].map(|folder| Path::new(folder).join(name))
        })
        .find(|path| path.exists());
    if found.is_none() {
        let reason = "no Chromium on this machine; `cargo xtask browser` installs it on Debian";
        sprung_testing::skipped("browser", reason);
    }
    found
}

/// Opens a page. Returns its document and what the browser logged; `None` without a browser.
fn open(page: &Path, more: &[&str]) -> Option<(String, String)> {
    let profile = TempDir::new().unwrap();
    let output = Command::new(browser()?)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--enable-logging=stderr",
            "--virtual-time-budget=10000",
            "--dump-dom",
        ])
        .args(more)
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    Some((
        String::from_utf8_lossy(&output.stdout).into_owned(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    ))
}

/// Returns the numbers of drawn and of expected plots, from the attribute `data-plots-drawn` that the page sets.
fn drawn(document: &str) -> (usize, usize) {
    let (_, rest) = document
        .split_once("data-plots-drawn=\"")
        .expect("the page did not say that it has drawn");
    let (count, _) = rest.split_once('"').unwrap();
    let (drawn, expected) = count.split_once('/').unwrap();
    (drawn.parse().unwrap(), expected.parse().unwrap())
}

#[test]
fn every_plot_is_drawn_without_a_word_on_the_console() {
    let report = demo().join("sprung-out/report.html");
    for size in ["--window-size=1280,1024", "--window-size=500,850"] {
        let Some((document, log)) = open(&report, &[size]) else {
            return;
        };
        let console: Vec<&str> = log
            .lines()
            .filter(|line| line.contains("CONSOLE"))
            .collect();
        assert!(console.is_empty(), "{console:?}");
        let (drawn, expected) = drawn(&document);
        // 15 traces, 4 fits, and for each of the two runs 8 positions and 4 torques.
        assert_eq!(expected, 15 + 4 + 2 * 12);
        assert_eq!(drawn, expected);
        assert!(!document.contains("NaN"));
    }
}

#[test]
fn the_report_of_a_check_is_drawn() {
    let case = crate::common::Case::new().column(1, |q| if q > 0.04 { q + 0.3 } else { q });
    let experiment = case.path("experiment.toml");
    let output = crate::common::sprung(&["check", "-q", experiment.to_str().unwrap()]);
    assert!(output.status.code().is_some());
    let page = case.path("sprung-out/check.html");
    let Some((document, log)) = open(&page, &["--window-size=1280,1024"]) else {
        return;
    };
    assert!(!log.contains("CONSOLE"), "{log}");
    let (drawn, expected) = drawn(&document);
    // Six plots of columns, and one of at least one finding.
    assert!(expected > 6, "{expected}");
    assert_eq!(drawn, expected);
}

#[test]
fn the_check_would_see_a_plot_that_fails() {
    let folder = TempDir::new().unwrap();
    let text = std::fs::read_to_string(demo().join("sprung-out/report.html")).unwrap();
    // Figure data that are not JSON cannot be drawn.
    let tag = text.find("application/json").unwrap();
    let data = tag + text[tag..].find('>').unwrap() + 1;
    let broken = format!("{}!{}", &text[..data], &text[data..]);
    let page = folder.path().join("broken.html");
    std::fs::write(&page, broken).unwrap();
    let Some((document, _)) = open(&page, &[]) else {
        return;
    };
    let (drawn, expected) = drawn(&document);
    assert!(drawn < expected, "a broken page looks whole");
}
