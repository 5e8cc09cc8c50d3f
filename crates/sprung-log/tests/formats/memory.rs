//! Columns in memory give the same values as a file with the same numbers.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use sprung_log::{Array, Arrays, Channels, Input, LogBlock, LogSource};

use crate::support::{experiment, fixture, read_source, read_text};

const LOG: &str = "
time_s = \"t_s\"
link_position_deg = [\"q1_rad\", \"q2_rad\"]
motor_position_rad = [\"phi1_rad\", \"phi2_rad\"]
motor_torque_nm = [\"tau1_nm\", \"tau2_nm\"]
sign = { phi1_rad = -1 }
";

/// Names and columns of a CSV file.
fn columns(text: &str) -> Vec<(String, Vec<f64>)> {
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',');
    let mut all: Vec<(String, Vec<f64>)> = names.map(|name| (name.into(), Vec::new())).collect();
    for line in lines {
        for ((_, column), cell) in all.iter_mut().zip(line.split(',')) {
            column.push(cell.parse().unwrap());
        }
    }
    all
}

fn plain() -> String {
    std::fs::read_to_string(fixture("plain.csv")).unwrap()
}

fn read_arrays(arrays: &Arrays, log: &str) -> Result<Vec<Vec<f64>>, String> {
    let experiment = experiment(log)?;
    let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap())
        .map_err(|error| error.to_string())?;
    let mut source = LogSource::arrays("the arrays", arrays.clone());
    let first = read_source(&mut source, &channels).map_err(|error| error.to_string())?;
    // A source may be read again.
    let second = read_source(&mut source, &channels).map_err(|error| error.to_string())?;
    assert_eq!(first.columns, second.columns);
    Ok(first.columns)
}

#[test]
fn arrays_are_read_as_a_file_to_the_bit() {
    let text = plain();
    let from_file = read_text(&text, LOG).unwrap();
    let arrays = Arrays::new(columns(&text)).unwrap();
    assert_eq!(read_arrays(&arrays, LOG), Ok(from_file.clone()));
    let lent = columns(&text).into_iter().map(|(name, numbers)| {
        let numbers: Arc<[f64]> = Arc::from(numbers);
        (name, Array::float(numbers))
    });
    let lent = Arrays::new(lent).unwrap();
    assert_eq!(read_arrays(&lent, LOG), Ok(from_file));
}

#[test]
fn large_integers_are_times_to_the_nanosecond() {
    let text = plain();
    let log = LOG.replace("time_s = \"t_s\"", "time_ns = \"t_ns\"");
    let begin = 1_700_000_000_000_000_000;
    let with_times = |begin: i64| {
        let mut times = Vec::new();
        let mut all = Vec::new();
        for (name, numbers) in columns(&text) {
            if name == "t_s" {
                times = (numbers.iter())
                    .map(|t| begin + (t * 1e9).round() as i64)
                    .collect();
            } else {
                all.push((name, Array::from(numbers)));
            }
        }
        all.push(("t_ns".to_owned(), Array::from(times)));
        read_arrays(&Arrays::new(all).unwrap(), &log).unwrap()
    };
    let (late, early) = (with_times(begin), with_times(0));
    let from_first = |times: &[f64]| -> Vec<f64> { times.iter().map(|t| t - times[0]).collect() };
    let (late, early) = (from_first(&late[0]), from_first(&early[0]));
    for (late, early) in late.iter().zip(&early) {
        assert!((late - early).abs() < 1e-9, "{late} {early}");
    }
}

#[test]
fn a_number_that_is_none_is_named_with_its_row() {
    let mut all = columns(&plain());
    all[2].1[6] = f64::NAN;
    let name = all[2].0.clone();
    let error = read_arrays(&Arrays::new(all).unwrap(), LOG).unwrap_err();
    assert!(
        error.contains("row 7") && error.contains(&format!("\"{name}\"")) && error.contains("NaN"),
        "{error}"
    );
}

#[test]
fn the_nearest_name_is_offered() {
    let mut all = columns(&plain());
    all[1].0 = "q1_rd".to_owned();
    let error = read_arrays(&Arrays::new(all).unwrap(), LOG).unwrap_err();
    let expected = "the arrays has no column \"q1_rad\"; did you mean \"q1_rd\"?";
    assert_eq!(error, expected);
}

#[test]
fn memory_holds_all_columns_or_none() {
    let arrays = Arrays::new(columns(&plain())).unwrap();
    let other = LOG.replace(
        "[\"tau1_nm\", \"tau2_nm\"]",
        "[{ file = \"b.csv\", column = \"a\" }, \"tau2_nm\"]",
    );
    let error = read_arrays(&arrays, &other).unwrap_err();
    let expected = "the arrays is in memory, but b.csv contains some of its columns; give these columns in \
         memory, too";
    assert_eq!(error, expected);
    let topic = LOG
        .replace(
            "[\"tau1_nm\", \"tau2_nm\"]",
            "{ topic = \"/joint_states\" }",
        )
        .replace("motor_torque_nm", "motor_torque")
        .replace(" }\nsign", ", unit = \"N·m\" }\nsign");
    let error = read_arrays(&arrays, &topic).unwrap_err();
    assert!(error.contains("holds arrays and no topics"), "{error}");
}

#[test]
fn empty_arrays_are_no_log() {
    let empty = columns(&plain())
        .into_iter()
        .map(|(name, _)| (name, Vec::<f64>::new()));
    let arrays = Arrays::new(empty).unwrap();
    assert!(arrays.is_empty());
    let found = read_arrays(&arrays, LOG);
    let of_file = read_text(plain().lines().next().unwrap(), LOG);
    assert_eq!(
        found.map_err(|error| error.replace("the arrays", "log.csv")),
        of_file
    );
}

#[test]
fn a_log_that_was_kept_is_read_once_more_without_its_file() {
    let channels = |log: &str| {
        let experiment = experiment(log).unwrap();
        Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap()
    };
    let (same, other) = (channels(LOG), channels(&LOG.replace("= -1", "= 1")));
    let opened = AtomicUsize::new(0);
    let mut opener = |_: Option<&Path>| -> std::io::Result<Box<dyn Input>> {
        opened.fetch_add(1, Ordering::Relaxed);
        Ok(Box::new(Cursor::new(plain().into_bytes())))
    };
    let mut source = LogSource::files("log.csv", &mut opener);
    let first = read_source(&mut source, &same).unwrap();
    for (next, is_kept) in [(&same, true), (&other, false)] {
        let mut log = source.open(&same).unwrap();
        let mut blocks = Vec::new();
        let mut block = LogBlock::new(same.all.len());
        while log.read(&mut block).unwrap() {
            blocks.push(block.clone());
        }
        let names = log.names().to_vec();
        source.keep(&same, log, Arc::new(blocks));
        let before = opened.load(Ordering::Relaxed);
        let found = read_source(&mut source, next).unwrap();
        assert_eq!(opened.load(Ordering::Relaxed) == before, is_kept);
        assert_eq!(found.columns == first.columns, is_kept);
        assert_eq!(found.gaps, first.gaps);
        assert_eq!(found.timing, first.timing);
        assert_eq!(source.open(&same).unwrap().names(), names);
    }
}
