//! Several logs of one robot, read at the same time and reduced together.

use sprung_base::progress::{Answer, Progress, Unheard};
use sprung_log::Channels;
use sprung_method::estimate::{Identified, fit, identify};
use sprung_method::prepare::excerpt;
use sprung_method::regression::{Reading, Reduction, signals};
use sprung_robot::{Constraints, Cutoff, Estimator, Laws, Simulate, Weights};

use crate::support::{Twin, with_sources};

const CUTOFF_HZ: f64 = 20.0;

/// Durations of the logs, s.
const DURATIONS: [f64; 4] = [6.0, 2.5, 4.0, 3.0];

fn twin(weights: Weights) -> Twin {
    let mut twin = Twin::new();
    let settings = &mut twin.experiment.identify;
    settings.estimator = vec![Estimator::LeastSquares];
    settings.position_cutoff_hz = Cutoff::Fixed(CUTOFF_HZ);
    settings.weights = weights;
    twin
}

fn logs(twin: &Twin) -> Vec<Vec<u8>> {
    let settings = twin.experiment.simulate.clone().unwrap();
    let log = |(duration_s, seed): (f64, u64)| {
        twin.log(&Simulate {
            duration_s,
            seed,
            ..settings.clone()
        })
    };
    DURATIONS.into_iter().zip(1..).map(log).collect()
}

fn identified(twin: &Twin, logs: &[Vec<u8>], threads: usize) -> Identified {
    let logs: Vec<&[u8]> = logs.iter().map(Vec::as_slice).collect();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        with_sources(&logs, |sources| {
            identify(&twin.experiment, &twin.model, sources, &mut Unheard).unwrap()
        })
    })
}

fn values(found: &Identified) -> Vec<f64> {
    let parameters = found.identification.results[0].parameters.iter();
    parameters
        .map(|parameter| parameter.value.unwrap())
        .collect()
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let twin = twin(Weights::Transition);
    let logs = logs(&twin);
    let without_time = |threads: usize| {
        let mut found = identified(&twin, &logs, threads);
        for result in &mut found.identification.results {
            result.elapsed_s = 0.0;
        }
        found
    };
    let one = without_time(1);
    for threads in [2, 3, 5] {
        let other = without_time(threads);
        assert_eq!(
            one.identification, other.identification,
            "{threads} threads"
        );
        assert_eq!(one.fit, other.fit, "{threads} threads");
        assert_eq!(one.trace, other.trace, "{threads} threads");
    }
}

/// All samples pass through one reduction here.
#[test]
fn logs_give_the_parameters_of_one_pass() {
    let mut twin = twin(Weights::None);
    twin.experiment.identify.constraints = Constraints::None;
    twin.experiment.identify.laws = Laws::Declared;
    let logs = logs(&twin);
    let settings = &twin.experiment.identify;
    let channels = Channels::new(
        &twin.experiment.robot,
        twin.experiment.log.as_ref().unwrap(),
    )
    .unwrap();
    let reading = Reading::new(&twin.model, settings, &channels, CUTOFF_HZ);
    let mut reduction = Reduction::new(&twin.model);
    let slices: Vec<&[u8]> = logs.iter().map(Vec::as_slice).collect();
    with_sources(&slices, |sources| {
        for source in sources {
            let log = excerpt(&channels, source).unwrap();
            for segment in signals(&reading, log.period(), log.blocks()).unwrap() {
                let (cutoff, period) = (reading.filter_cutoff(), log.period());
                reduction.restart();
                (reduction.push(&segment, cutoff, period, settings.discretization)).unwrap();
            }
        }
    });
    let expected = fit(&twin.model, &reduction.finish(), 0.1).unwrap().theta;
    let found = values(&identified(&twin, &logs, 2));
    let apart = |(found, expected): (&f64, &f64)| (found / expected - 1.0).abs();
    let worst = found.iter().zip(&expected).map(apart).fold(0.0, f64::max);
    println!("largest relative difference from one pass: {worst:.1e}");
    assert!(worst < 1e-10, "{worst:.1e}");
}

#[test]
fn each_log_is_a_part_on_a_common_time_axis() {
    let twin = twin(Weights::None);
    let found = identified(&twin, &logs(&twin), 2);
    let parts = &found.identification.results[0].parts;
    assert_eq!(parts.len(), DURATIONS.len());
    for (parts, duration) in parts.windows(2).zip(DURATIONS) {
        assert!((parts[0].to_s - parts[0].from_s - (duration - 1e-3)).abs() < 1e-9);
        assert!((parts[1].from_s - parts[0].to_s - 1e-3).abs() < 1e-9);
    }
    let time = &found.fit.sets[0].time;
    assert!(time.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(time.last().unwrap() > &parts[3].from_s);
    let growing = &found.trace.sets[0].time;
    assert!(growing.windows(2).all(|pair| pair[0] < pair[1]));
}

/// A log that cannot be read after one that stops early: the error names the first faulty one.
#[test]
fn the_first_faulty_log_is_named() {
    let twin = twin(Weights::None);
    let mut logs = logs(&twin);
    let middle = logs[1].len() / 2;
    logs[1].splice(middle..middle, *b"\n1.0,not,a,log\n");
    logs[3].truncate(200);
    for threads in [1, 4] {
        let slices: Vec<&[u8]> = logs.iter().map(Vec::as_slice).collect();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let error = pool.install(|| {
            with_sources(&slices, |sources| {
                let found = identify(&twin.experiment, &twin.model, sources, &mut Unheard);
                found.unwrap_err().to_string()
            })
        });
        assert!(error.contains("twin 1"), "{threads} threads: {error}");
    }
}

#[test]
fn progress_counts_all_logs_and_a_listener_stops_them() {
    let twin = twin(Weights::None);
    let logs = logs(&twin);
    let slices: Vec<&[u8]> = logs.iter().map(Vec::as_slice).collect();
    let mut last = 0;
    let mut listener = |progress: Progress| {
        if progress.phase == sprung_base::progress::Phase::Reading {
            assert!(progress.done >= last);
            last = progress.done;
        }
        Answer::GoOn
    };
    with_sources(&slices, |sources| {
        identify(&twin.experiment, &twin.model, sources, &mut listener).unwrap()
    });
    // 15.5 s at 1 kHz.
    assert_eq!(last, 15_500);
    let mut stopper = |progress: Progress| {
        if progress.phase == sprung_base::progress::Phase::Reading && progress.done > 4000 {
            Answer::Stop
        } else {
            Answer::GoOn
        }
    };
    let stopped = with_sources(&slices, |sources| {
        identify(&twin.experiment, &twin.model, sources, &mut stopper).unwrap_err()
    });
    assert!(stopped.to_string().contains("stopped"), "{stopped}");
}
