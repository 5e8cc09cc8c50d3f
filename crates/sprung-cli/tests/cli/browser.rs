//! The report in a real browser draws every plot, and the console stays empty.

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

use crate::common::{Ran, demo, str_of};

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

/// Opens a page, with all sections unfolded if the fragment is `#all`. Returns its document and the messages of the
/// console; `None` without a browser.
fn open(page: &Path, fragment: &str, more: &[&str]) -> Option<(String, String)> {
    let profile = TempDir::new().unwrap();
    let output = Ran::of(
        Command::new(browser()?)
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
            .arg(format!("file://{}{fragment}", page.display())),
    );
    Some((output.out, output.err))
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
        let Some((document, log)) = open(&report, "#all", &[size]) else {
            return;
        };
        let console: Vec<&str> = log
            .lines()
            .filter(|line| line.contains("CONSOLE"))
            .collect();
        assert!(console.is_empty(), "{console:?}");
        let (drawn, expected) = drawn(&document);
        // 4 of the overview with their differences, 4 per joint, 15 traces, 8 fits, and for each
        // of the two runs 8 positions and 4 torques.
        assert_eq!(expected, 8 + 2 * 4 + 15 + 8 + 2 * 12);
        assert_eq!(drawn, expected);
        // The scripts and the data of the curves follow the page.
        let (page, _) = document.split_once("<script").unwrap();
        assert!(!page.contains("NaN"));
    }
}

#[test]
fn the_report_of_a_check_is_drawn() {
    let case = crate::common::Case::new().column(1, |q| if q > 0.04 { q + 0.3 } else { q });
    let experiment = case.at("experiment.toml");
    let output = crate::common::sprung(&["check", "-q", &experiment]);
    assert!(output.code.is_some());
    let page = case.path("sprung-out/check.html");
    let Some((document, log)) = open(&page, "#all", &["--window-size=1280,1024"]) else {
        return;
    };
    assert!(!log.contains("CONSOLE"), "{log}");
    let (drawn, expected) = drawn(&document);
    // Six plots of columns, and one of at least one finding.
    assert!(expected > 6, "{expected}");
    assert_eq!(drawn, expected);
}

/// Runs a script on a page in a frame of the given size. Returns the text that the script, an
/// `async` function of the frame, returns; `None` without a browser.
pub(crate) fn measured(
    page: &Path,
    fragment: &str,
    (width, height): (u32, u32),
    script: &str,
) -> Option<String> {
    let folder = TempDir::new().unwrap();
    let host = folder.path().join("host.html");
    let text = format!(
        "<!DOCTYPE html><meta charset=\"utf-8\"><body><pre id=\"result\"></pre><script>
const settled = () => new Promise((done) => setTimeout(done, 100));
const open = (width, height) => new Promise((done) => {{
  const frame = document.createElement('iframe');
  frame.style.cssText = 'border:0;width:' + width + 'px;height:' + height + 'px';
  frame.src = 'file://{}{fragment}';
  frame.onload = async () => {{ await settled(); done(frame); }};
  document.body.append(frame);
}});
const measure = async () => {{
  const frame = await open({width}, {height});
  {script}
}};
const show = (text) => document.getElementById('result').textContent = text;
measure().then(show, (error) => show('failed: ' + error));
</script>",
        page.display()
    );
    std::fs::write(&host, text).unwrap();
    let more = [
        "--allow-file-access-from-files",
        "--window-size=2700,1400",
        "--virtual-time-budget=100000",
    ];
    let (document, log) = open(&host, "", &more)?;
    assert!(!log.contains("CONSOLE"), "{log}");
    let (_, rest) = document.split_once("id=\"result\">").unwrap();
    let (result, _) = rest.split_once("</pre>").unwrap();
    Some(result.to_owned())
}

/// From phones to wide screens, and both sides of the widths where the page changes.
const WIDTHS: [u32; 13] = [
    360, 390, 480, 599, 600, 768, 1024, 1280, 1320, 1400, 1440, 1920, 2560,
];

/// Returns, for each width of the page, the elements outside of it or cut off by a box.
pub(crate) fn overflows(page: &Path, fragment: &str, widths: &[u32]) -> Option<String> {
    let script = OVERFLOWS.replace("WIDTHS", &format!("{widths:?}"));
    measured(page, fragment, (1320, 1000), &script)
}

const OVERFLOWS: &str = "
  const found = [];
  frame.remove();
  for (const width of WIDTHS) {
    // The browser draws no frames here, so a page does not learn that its width has changed.
    const frame = await open(width, 1000);
    const page = frame.contentDocument;
    const root = page.documentElement;
    if (root.scrollWidth > root.clientWidth) found.push(width + ': page ' + root.scrollWidth);
    for (const box of page.querySelectorAll('.scroll:not(pre), figure, .verdict, .interval-row')) {
      if (box.scrollWidth > box.clientWidth + 1) found.push(width + ': ' + box.className + ' ' + box.scrollWidth + ' in ' + box.clientWidth);
    }
    for (const cell of page.querySelectorAll('td')) {
      const { right, width: occupied } = cell.getBoundingClientRect();
      if (occupied > 0 && right > width) found.push(width + ': cell ' + cell.textContent);
    }
    frame.remove();
  }
  return found.length ? found.slice(0, 9).join('; ') : 'fits';";

#[test]
fn no_part_of_a_report_is_cut_off() {
    let report = demo().join("sprung-out/report.html");
    if let Some(found) = overflows(&report, "", &WIDTHS) {
        assert_eq!(found, "fits");
    }
}

#[test]
fn no_part_of_an_unfolded_report_is_cut_off() {
    let report = demo().join("sprung-out/report.html");
    if let Some(found) = overflows(&report, "#all", &WIDTHS) {
        assert_eq!(found, "fits");
    }
}

#[test]
fn a_paragraph_that_is_too_wide_is_found() {
    let folder = TempDir::new().unwrap();
    let text = std::fs::read_to_string(demo().join("sprung-out/report.html")).unwrap();
    let wide = folder.path().join("wide.html");
    let (head, tail) = text.split_once("<main>").unwrap();
    let paragraph = "<main><p style=\"width:700px;max-width:none\">wide</p>";
    std::fs::write(&wide, format!("{head}{paragraph}{tail}")).unwrap();
    let Some(found) = overflows(&wide, "", &[360, 768]) else {
        return;
    };
    assert!(found.starts_with("360: page 7"), "{found}");
    assert!(!found.contains("768:"), "{found}");
}

#[test]
fn no_part_of_other_reports_is_cut_off() {
    let case = crate::common::Case::new();
    let folder = case.path("sprung-out");
    let experiment = &*case.at("experiment.toml");
    let of_demo = demo().join("sprung-out");
    let comparison = case.path("comparison");
    let results = of_demo.to_str().unwrap();
    let commands: [(&[&str], PathBuf); 3] = [
        (&["check", "-q", experiment], folder.join("check.html")),
        (&["identify", "-q", experiment], folder.join("report.html")),
        (
            &[
                "compare",
                "-q",
                results,
                folder.to_str().unwrap(),
                "--out",
                comparison.to_str().unwrap(),
            ],
            comparison.join("report.html"),
        ),
    ];
    for (command, page) in commands {
        let output = crate::common::sprung(command);
        assert!(page.exists(), "{}", output.err);
        let Some(found) = overflows(&page, "#all", &WIDTHS) else {
            return;
        };
        assert_eq!(found, "fits", "{command:?}");
    }
}

#[test]
fn the_first_screen_has_verdict_joints_and_motion() {
    let report = demo().join("sprung-out/report.html");
    let script = "
      const page = frame.contentDocument;
      const parts = ['.verdict', '#joints table', '.overview .panel canvas'];
      const bottom = (part) => Math.max(...[...page.querySelectorAll(part)].map((one) => one.getBoundingClientRect().bottom));
      const low = parts.filter((part) => !(bottom(part) > 0 && bottom(part) <= frame.clientHeight));
      const drawn = page.documentElement.dataset.plotsDrawn;
      const notes = [...page.querySelectorAll('.overview .note')].map((note) => note.textContent);
      const ticks = [...page.querySelectorAll('.overview [role=img]')].map((box) => Number(box.dataset.ticks));
      if (!(Math.min(...ticks) >= 2)) low.push('an axis with fewer than two numbers');
      const heads = [...page.querySelectorAll('.overview h3')];
      low.push(...heads.filter((head) => head.scrollWidth > head.clientWidth + 1).map((head) => head.textContent));
      return [low.join(), drawn, ...notes].join('|');";
    for size in [(1280, 800), (1320, 800), (1920, 1000)] {
        let Some(found) = measured(&report, "", size, script) else {
            return;
        };
        let parts: Vec<&str> = found.split('|').collect();
        let [low, drawn, notes @ ..] = &parts[..] else {
            panic!("{found}")
        };
        assert_eq!(*low, "", "{size:?}");
        // Figures in folded sections are drawn when the reader opens them.
        assert_eq!(*drawn, "8/63");
        assert_eq!(notes.len(), 4, "{found}");
        assert!(
            notes.iter().all(|note| note.ends_with(" % explained")),
            "{found}"
        );
    }
}

#[test]
fn a_phone_shows_the_values() {
    let report = demo().join("sprung-out/report.html");
    let script = "
      const cells = [...frame.contentDocument.querySelectorAll('#parameters tr:not(.heading) td:nth-child(2)')];
      const shown = cells.filter((cell) => {
        const { left, right, height } = cell.getBoundingClientRect();
        return cell.textContent.includes('±') && left >= 0 && right <= frame.clientWidth && height > 0;
      });
      return shown.length + ' of ' + cells.length;";
    if let Some(found) = measured(&report, "", (360, 740), script) {
        assert_eq!(found, "15 of 15");
    }
}

#[test]
fn figures_and_tables_can_be_saved() {
    let report = demo().join("sprung-out/report.html");
    let script = "
      // The clock of the browser does not wait for pictures and blobs, so texts are caught before.
      const { URL, HTMLAnchorElement, document: page } = frame.contentWindow;
      const saved = [];
      let last = '';
      frame.contentWindow.Blob = function (parts) { last = parts.join(''); };
      URL.createObjectURL = () => 'blob:none';
      HTMLAnchorElement.prototype.click = function () { saved.push([this.download, last]); };
      const buttons = [...page.querySelectorAll('.downloads button')];
      for (const button of buttons) if (button.textContent !== 'PNG') button.click();
      const wrong = [];
      const quoted = /\"[^\"]*\"/g;
      const counts = { svg: 0, png: 0, csv: 0 };
      counts.png = buttons.filter((button) => button.textContent === 'PNG').length;
      for (const [name, text] of saved) {
        const kind = name.split('.').pop();
        counts[kind] += 1;
        if (kind === 'svg') {
          const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
          const marks = parsed.querySelectorAll('path, circle, rect:not(:first-child)').length;
          if (parsed.querySelector('parsererror') || marks < 1) wrong.push(name);
        }
        if (kind === 'csv') {
          const lines = text.trim().split('\\r\\n');
          if (name.endsWith('-parameters.csv')) counts.lines = lines.slice(0, 3).join('\\n');
          if (new Set(lines.map((line) => line.replaceAll(quoted, 'text').split(',').length)).size !== 1) wrong.push(name);
        }
      }
      const distinct = new Set(saved.map(([name]) => name)).size === saved.length;
      return JSON.stringify({ wrong, distinct, ...counts });";
    let Some(found) = measured(&report, "#all", (1320, 1000), script) else {
        return;
    };
    let found: serde_json::Value = serde_json::from_str(&found).expect(&found);
    assert_eq!(found["wrong"], serde_json::json!([]), "{found}");
    assert_eq!(found["distinct"], true, "{found}");
    assert!(found["svg"].as_u64() >= Some(9), "{found}");
    assert_eq!(found["png"], found["svg"], "{found}");
    assert!(found["csv"].as_u64() >= Some(8), "{found}");
    let lines: Vec<&str> = str_of(&found["lines"]).lines().collect();
    assert!(
        lines[0].starts_with("Group,Parameter,prediction-error,s.e.,Unit,"),
        "{lines:?}"
    );
    assert!(
        lines[1].starts_with("joint1,link1.inertia_total,0.207"),
        "{lines:?}"
    );
}

#[test]
fn the_report_of_the_demo_is_small() {
    let report = demo().join("sprung-out/report.html");
    let bytes = std::fs::metadata(report).unwrap().len();
    assert!(bytes < 1_200_000, "{bytes}");
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
    let Some((document, _)) = open(&page, "", &[]) else {
        return;
    };
    let (drawn, expected) = drawn(&document);
    assert!(drawn < expected, "a broken page looks whole");
}
