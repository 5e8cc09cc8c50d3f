//! Columns in memory give the result of a file with the same numbers.

use sprung_base::progress::Unheard;
use sprung_log::{Arrays, LogSource};
use sprung_method::check::check;
use sprung_method::estimate::identify;
use sprung_robot::Estimator;

use crate::in_memory::with_source;
use crate::support::Twin;

/// Names and columns of a log.
fn columns(csv: &[u8]) -> Arrays {
    let text = std::str::from_utf8(csv).unwrap();
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',');
    let mut all: Vec<(&str, Vec<f64>)> = names.map(|name| (name, Vec::new())).collect();
    for line in lines {
        for ((_, column), cell) in all.iter_mut().zip(line.split(',')) {
            column.push(cell.parse().unwrap());
        }
    }
    Arrays::new(all).unwrap()
}

#[test]
fn arrays_are_checked_and_identified_like_a_file_to_the_bit() {
    let mut twin = Twin::new();
    twin.experiment.identify.estimator = vec![Estimator::LeastSquares];
    let mut settings = twin.experiment.simulate.clone().unwrap();
    settings.duration_s = 3.0;
    let csv = twin.log(&settings);
    let results = |source: LogSource<'_>| {
        let found = identify(&twin.experiment, &twin.model, &mut [source], &mut Unheard);
        let mut results = found.unwrap().identification.results;
        for result in &mut results {
            result.elapsed_s = 0.0;
        }
        serde_json::to_string(&results).unwrap()
    };
    let findings = |source: LogSource<'_>| {
        let checked = check(&twin.experiment, &twin.model, &mut [source], &mut Unheard);
        serde_json::to_string(&checked.unwrap().report.findings).unwrap()
    };
    let in_arrays = || LogSource::arrays("log", columns(&csv));
    assert_eq!(results(in_arrays()), with_source(&csv, results));
    assert_eq!(findings(in_arrays()), with_source(&csv, findings));
}
