//! Windows of logs: the same samples as in the whole log, in every format.

use sprung_log::{Arrays, Channels, LogSource};
use sprung_robot::Window;

use crate::clocks::{csv, truth as motion};
use crate::keys::{TOPICS, USUAL};
use crate::same::cases;
use crate::support::{
    Files, Found, difference, experiment, messages, read_source, read_window, says, truth,
};

fn between(from_s: f64, to_s: f64) -> Window {
    Window {
        from_s: Some(from_s),
        to_s: Some(to_s),
        ..Window::default()
    }
}

fn samples(from: u64, to: u64) -> Window {
    Window {
        from_index: Some(from),
        to_index: Some(to),
        ..Window::default()
    }
}

fn channels(log: &str) -> Channels {
    let experiment = experiment(log).unwrap();
    Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap()
}

fn part(columns: &[Vec<f64>], range: std::ops::Range<usize>) -> Vec<Vec<f64>> {
    let column = |column: &Vec<f64>| column[range.clone()].to_vec();
    columns.iter().map(column).collect()
}

/// Reads a window of a CSV text.
fn of_text(text: &[u8], keys: &str, window: Window) -> Result<Found, String> {
    let files = Files::Memory(vec![("log.csv", text.to_vec())]);
    let channels = channels(&format!("{keys}{USUAL}"));
    read_window(&files, "log.csv", &channels, window).map_err(|error| error.to_string())
}

/// A log of 8 s at 1 kHz, in lines of CSV.
fn lines(count: u32) -> Vec<String> {
    let samples: Vec<(f64, f64)> = (0..count)
        .map(|k| (1e-3 * f64::from(k), 1e-3 * f64::from(k)))
        .collect();
    let text = String::from_utf8(csv(&samples, motion)).unwrap();
    text.lines().map(str::to_owned).collect()
}

#[test]
fn every_format_gives_the_samples_of_a_window() {
    let truth = part(&truth(), 50..150);
    let mut logs = cases();
    // Times since 1970 count from the first sample, or as in the file.
    logs.push(("epoch.mcap", TOPICS.to_owned()));
    for (file, log) in logs {
        for window in [between(0.0495, 0.1495), samples(50, 150)] {
            let found = read_window(&Files::Fixtures, file, &channels(&log), window)
                .unwrap_or_else(|error| panic!("{file}: {error}"));
            let worst = difference(&found.columns, &truth);
            assert!(worst <= 1e-12, "{file}: {worst}");
            assert_eq!((found.timing.recorded, found.timing.window), (100, window));
        }
    }
}

#[test]
fn arrays_in_memory_have_windows() {
    let columns = [
        "t_s", "q1_rad", "q2_rad", "phi1_rad", "phi2_rad", "tau1_nm", "tau2_nm",
    ];
    let arrays = Arrays::new(columns.into_iter().zip(truth())).unwrap();
    let mut source = LogSource::arrays("run 7", arrays).within(samples(50, 150));
    assert_eq!(source.label(), "run 7 (from sample 50 to sample 150)");
    let found = read_source(&mut source, &channels(USUAL)).unwrap();
    assert!(difference(&found.columns, &part(&truth(), 50..150)) <= 0.0);
}

#[test]
fn samples_outside_are_not_judged() {
    let mut all = lines(8000);
    let whole = of_text(all.join("\n").as_bytes(), "", Window::default()).unwrap();
    // Line k + 1 holds sample k: no numbers, too few cells, time that runs back, and an end within a line.
    all[101] = all[101]
        .replace("0.1,", "0.1,overrun,")
        .replacen(',', ";", 2);
    all[201] = "0.2,nan,0,0,0,0,0".to_owned();
    all[301] = "0.3,1".to_owned();
    all[401] = "0.1,1,1,1,1,1,1".to_owned();
    all[6101] = "6.1,1,1,1,1,inf,1".to_owned();
    all[7001] = "-".to_owned();
    let text = all.join("\n");
    let bytes = &text.as_bytes()[..text.len() - 30];
    let window = between(1.9995, 5.9995);
    let found = of_text(bytes, "", window).unwrap();
    assert!(difference(&found.columns, &part(&whole.columns, 2000..6000)) <= 0.0);
    let error = of_text(bytes, "", between(1.9995, 6.5)).err().unwrap();
    says(&error, &["line 6102", "tau1_nm", "inf"]);
    let error = of_text(bytes, "", between(0.1995, 1.0)).err().unwrap();
    says(&error, &["line 202", "NaN"]);
    let error = of_text(bytes, "", between(6.5, 7.5)).err().unwrap();
    says(&error, &["line 7002"]);
}

#[test]
fn other_files_are_judged_within_the_window() {
    let log = lines(8000).join("\n");
    let other = |k: u32| {
        let t = 1e-3 * f64::from(k);
        let reading = match k {
            100 | 7500 => "nan".to_owned(),
            _ => motion(t)[2].to_string(),
        };
        format!("{t},{reading}\n")
    };
    let other: Vec<String> = (0..8000).map(other).collect();
    let files = Files::Memory(vec![
        ("log.csv", log.into_bytes()),
        (
            "other.csv",
            format!("t,phi\n{}", other.concat()).into_bytes(),
        ),
    ]);
    let keys = USUAL.replace(
        "\"phi1_rad\"",
        "{ file = \"other.csv\", column = \"phi\", time = \"t\" }",
    );
    let read = |window| read_window(&files, "log.csv", &channels(&keys), window);
    let found = read(between(1.9995, 6.9995)).unwrap();
    let worst = (found.columns[0].iter().zip(&found.columns[3])).fold(0.0_f64, |worst, (&t, x)| {
        worst.max((x - motion(t)[2]).abs())
    });
    assert!(found.columns[0].len() == 5000 && worst < 1e-12, "{worst}");
    let error = read(between(1.9995, 7.9)).err().unwrap().to_string();
    says(&error, &["other.csv", "line 7502", "NaN"]);
    let error = read(Window::default()).err().unwrap().to_string();
    says(&error, &["other.csv", "line 102"]);
}

#[test]
fn counters_are_unwrapped_from_the_beginning_of_the_file() {
    let rows: Vec<String> = (0..1000_u32)
        .map(|k| format!("{},{},0,0,0,0,0\n", 1e-3 * f64::from(k), (7 * k) % 100))
        .collect();
    let header = "t_s,q1_rad,q2_rad,phi1_rad,phi2_rad,tau1_nm,tau2_nm\n";
    let keys = USUAL.replace(
        "link_position_rad = \"q*_rad\"",
        "link_position_rad = [{ column = \"q1_rad\", wrap = 100 }, \"q2_rad\"]",
    );
    let files = Files::Memory(vec![(
        "log.csv",
        format!("{header}{}", rows.concat()).into_bytes(),
    )]);
    let found = read_window(&files, "log.csv", &channels(&keys), samples(500, 600)).unwrap();
    assert!(
        (found.columns[1][0] - 3500.0).abs() < 1e-9,
        "{}",
        found.columns[1][0]
    );
}

#[test]
fn a_gap_in_the_window_stays_a_gap() {
    let mut all = lines(4000);
    all.drain(1501..1701);
    let found = of_text(all.join("\n").as_bytes(), "", between(1.0, 2.0)).unwrap();
    assert_eq!((found.gaps.len(), found.timing.gaps.count), (1, 1));
    // A window that ends in the gap has no gap.
    let found = of_text(all.join("\n").as_bytes(), "", between(1.0, 1.6)).unwrap();
    assert_eq!(found.timing.gaps.count, 0);
}

#[test]
fn windows_without_samples_are_refused() {
    let mut messages = messages("windows_without_samples_are_refused");
    let mut all = lines(4000);
    all.drain(1501..1701);
    let text = all.join("\n");
    for (name, window) in [
        ("behind the end", between(12.0, 60.0)),
        ("before the beginning", between(-5.0, -1.0)),
        ("in a gap", between(1.55, 1.6)),
        ("samples behind the end", samples(5000, 6000)),
        ("one sample", samples(10, 11)),
    ] {
        let error = of_text(text.as_bytes(), "", window).err().unwrap();
        messages.note(name, &error);
    }
    messages.compare();
}

#[test]
fn windows_that_contradict_themselves_are_refused() {
    let mut messages = messages("windows_that_contradict_themselves_are_refused");
    for file in [
        "{ path = \"a.csv\", from_s = 60, to_s = 12 }",
        "{ path = \"a.csv\", from_index = 5, to_index = 5 }",
        "{ path = \"a.csv\", from_s = 1.0, from_index = 5 }",
        "{ path = \"a.csv\", to_s = inf }",
        "{ from_s = 1.0 }",
        "{ path = \"a.csv\", from = 1.0 }",
        "[{ path = \"a.csv\", to_s = 10 }, { path = \"a.csv\", from_s = 9 }]",
    ] {
        let error = experiment(&format!("file = {file}\n{USUAL}"))
            .err()
            .unwrap();
        messages.note(file, &error);
    }
    messages.compare();
    let touching =
        "file = [{ path = \"a.csv\", to_s = 9 }, { path = \"a.csv\", from_s = 9 }, \"b.csv\"]";
    let log = experiment(&format!("{touching}\n{USUAL}"))
        .unwrap()
        .log
        .unwrap();
    assert_eq!(log.name(""), "a.csv (to 9 s), a.csv (from 9 s), b.csv");
}
