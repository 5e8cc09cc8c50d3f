//! Measures the report of the demo: its size, and the time until a browser shows its first screen.
//!
//! `cargo bench -p sprung-cli --bench report` runs the demo, opens its report ten times in headless
//! Chromium (`cargo xtask browser` installs it) and prints the size, the median and the longest time
//! from the start of loading until the first screen is drawn. `-- --page FILE` measures another
//! report.
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]
#![expect(clippy::unwrap_used, reason = "a benchmark may panic")]

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// Goals: size in bytes, and time in ms.
const GOALS: (u64, f64) = (1_200_000, 300.0);

/// Number of times that the page is opened.
const RUNS: usize = 10;

/// Size of the window.
const WINDOW: (u32, u32) = (1320, 1000);

fn main() {
    // `cargo test --all-targets` starts benchmarks too.
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("cargo bench -p sprung-cli --bench report measures the report of the demo");
        return;
    }
    let folder = TempDir::new().unwrap();
    let page = named_page().unwrap_or_else(|| demo(folder.path()));
    let bytes = std::fs::metadata(&page).unwrap().len();
    println!(
        "size          {:>7.3} MB  goal {:.1} MB",
        megabytes(bytes),
        megabytes(GOALS.0)
    );
    let mut times: Vec<f64> = (0..RUNS)
        .map_while(|_| first_screen(&page, folder.path()))
        .collect();
    times.sort_by(f64::total_cmp);
    let Some(longest) = times.last() else {
        println!("first screen  no Chromium on this machine");
        return;
    };
    let median = times[times.len() / 2];
    println!(
        "first screen  {median:>7.0} ms  goal {:.0} ms  (longest of {RUNS}: {longest:.0} ms)",
        GOALS.1
    );
}

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}

/// Returns the page that the arguments name.
fn named_page() -> Option<PathBuf> {
    let mut words = std::env::args().skip_while(|word| word != "--page").skip(1);
    let page = PathBuf::from(words.next()?);
    Some(page.canonicalize().unwrap())
}

/// Runs the demo in a folder and returns its report.
fn demo(folder: &Path) -> PathBuf {
    let status = Command::new(env!("CARGO_BIN_EXE_sprung"))
        .args(["demo", "--quiet", "--out"])
        .arg(folder)
        .status();
    assert!(status.unwrap().success(), "the demo failed");
    folder.join("sprung-out/report.html")
}

/// Returns the time from the start of loading until the first frame after the plots of the first
/// screen, ms; `None` without a browser.
fn first_screen(page: &Path, folder: &Path) -> Option<f64> {
    let browser = ["chromium", "chromium-browser", "google-chrome"]
        .iter()
        .map(|name| Path::new("/usr/bin").join(name))
        .find(|path| path.exists())?;
    let host = folder.join("host.html");
    let (width, height) = WINDOW;
    // The page loads in a frame, so that a script beside it can wait for its first frame.
    let text = format!(
        "<!DOCTYPE html><body style=\"margin:0\"><script>
const frame = document.createElement('iframe');
frame.style.cssText = 'border:0;width:{width}px;height:{height}px';
frame.src = 'file://{}';
frame.onload = () => {{
  const view = frame.contentWindow;
  view.requestAnimationFrame(() => setTimeout(() => {{
    const drawn = view.document.documentElement.dataset.plotsDrawn;
    console.log('FIRST ' + view.performance.now() + ' ' + drawn + ' END');
  }}));
}};
document.body.append(frame);
</script>",
        page.display()
    );
    std::fs::write(&host, text).unwrap();
    let profile = TempDir::new().unwrap();
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
            "--allow-file-access-from-files",
            "--enable-logging=stderr",
        ])
        .arg(format!("--window-size={width},{height}"))
        .arg(format!(
            "--screenshot={}",
            folder.join("screen.png").display()
        ))
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", host.display()))
        .output()
        .unwrap();
    let log = String::from_utf8_lossy(&output.stderr);
    let (_, rest) = log.split_once("FIRST ").expect("the page told no time");
    let mut words = rest.split(' ');
    let time = words.next().unwrap().parse().unwrap();
    let drawn = words.next().unwrap();
    assert!(!drawn.starts_with("0/"), "no plot was drawn: {drawn}");
    Some(time)
}
