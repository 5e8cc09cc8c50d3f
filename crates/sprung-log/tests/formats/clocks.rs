//! Samples that are missing, written twice, late, or on another clock.

use std::f64::consts::TAU;

use sprung_log::{Channels, Sampling};

use super::keys::USUAL;
use super::support::{Files, Found, experiment, read_timed};

/// Positions and torques of two joints that never stand still at the same time.
pub(crate) fn truth(t: f64) -> [f64; 6] {
    let q1 = 0.5 * (TAU * 1.1 * t).sin() + 0.1 * (TAU * 4.3 * t).sin();
    let q2 = 0.7 * (TAU * 0.7 * t).cos();
    let spring = 0.01 * (TAU * 3.1 * t).sin();
    [q1, q2, q1 + spring, q2 - spring, 40.0 * spring, 3.0 * q2]
}

/// A log of samples that were taken at some times and stamped with others.
pub(crate) fn csv(samples: &[(f64, f64)], value: impl Fn(f64) -> [f64; 6]) -> Vec<u8> {
    let header = "t_s,q1_rad,q2_rad,phi1_rad,phi2_rad,tau1_nm,tau2_nm".to_owned();
    let row = |&(sampled, stamp): &(f64, f64)| {
        let cells: Vec<String> = value(sampled).iter().map(ToString::to_string).collect();
        format!("{stamp},{}", cells.join(","))
    };
    let lines: Vec<String> = std::iter::once(header)
        .chain(samples.iter().map(row))
        .collect();
    lines.join("\n").into_bytes()
}

pub(crate) fn found(csv: Vec<u8>, keys: &str) -> Result<Found, String> {
    let experiment = experiment(&format!("{keys}{USUAL}"))?;
    let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap();
    let files = Files::Memory(vec![("log.csv", csv)]);
    read_timed(&files, "log.csv", &channels).map_err(|error| error.to_string())
}

/// Numbers from 0 to 1.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }
}

/// Largest error of the positions at the times of the samples.
fn worst(found: &Found) -> f64 {
    let mut worst = 0.0_f64;
    for (k, &t) in found.columns[0].iter().enumerate() {
        for (column, value) in found.columns[1..5].iter().zip(truth(t)) {
            worst = worst.max((column[k] - value).abs());
        }
    }
    worst
}

/// Largest derivative of a position of [`truth`], rad/s to the power of `order`.
fn largest_derivative(order: i32) -> f64 {
    let wave = |size: f64, hz: f64| size * (TAU * hz).powi(order);
    wave(0.5, 1.1) + wave(0.1, 4.3) + wave(0.01, 3.1)
}

/// Largest error between samples at the ends of a segment, where the cubic lacks its outer sample and is a parabola:
/// `h³ x‴ / (9 √3)`.
///
/// - `step`: the longest step, s.
fn parabola_error(step: f64) -> f64 {
    step.powi(3) * largest_derivative(3) / (9.0 * 3_f64.sqrt())
}

fn even(count: u32, period: f64) -> Vec<f64> {
    (0..count).map(|k| 10.0 + period * f64::from(k)).collect()
}

fn stamped(times: impl IntoIterator<Item = f64>) -> Vec<(f64, f64)> {
    times.into_iter().map(|t| (t, t)).collect()
}

#[test]
fn even_logs_stay_as_they_are() {
    let times = even(5000, 1e-3);
    let found = found(csv(&stamped(times.clone()), truth), "").unwrap();
    let bits = |values: &[f64]| -> Vec<u64> { values.iter().map(|x| x.to_bits()).collect() };
    assert_eq!(bits(&found.columns[0]), bits(&times));
    for (i, column) in found.columns[1..].iter().enumerate() {
        let expected: Vec<f64> = times.iter().map(|&t| truth(t)[i]).collect();
        assert_eq!(bits(column), bits(&expected));
    }
    let timing = found.timing;
    assert!((timing.period - 1e-3).abs() < 1e-12, "{timing:?}");
    assert_eq!((timing.interpolated, timing.evidence), (0, None));
    assert_eq!(timing.sampling, Some(Sampling::Even));
}

#[test]
fn times_with_few_digits_are_those_of_an_even_clock() {
    // 960 Hz printed with four decimals: steps of 1.0 and 1.1 ms.
    let times: Vec<f64> = (0..5000).map(|k| f64::from(k) / 960.0).collect();
    let rounded: Vec<(f64, f64)> = (times.iter())
        .map(|&t| (t, (1e4 * t).round() / 1e4))
        .collect();
    let found = found(csv(&rounded, truth), "").unwrap();
    assert_eq!(found.columns[0].len(), 5000);
    assert_eq!(found.timing.interpolated, 0);
    // The period is the mean of 256 steps. The first and the last stamp are rounded by up to 0.05 ms each.
    let limit = 2.0 * 0.05e-3 / (256.0 / 960.0);
    assert!((found.timing.period * 960.0 - 1.0).abs() < limit);
    for (k, &t) in times.iter().enumerate() {
        assert_eq!(found.columns[1][k].to_bits(), truth(t)[0].to_bits());
    }
}

#[test]
fn positions_tell_when_samples_were_taken() {
    let mut random = Random::new(1);
    let period = 2e-3;
    let mut late = |part: f64| part * period * random.next();
    // The stamps are right: the loop sleeps after each sample, so its lateness accumulates.
    let mut time = 10.0;
    let slept: Vec<f64> = (0..5000)
        .map(|_| {
            time += period + late(0.6);
            time
        })
        .collect();
    let as_stamped = found(csv(&stamped(slept), truth), "").unwrap();
    // The samples are even; their stamps are late by up to half a period.
    let evenly: Vec<(f64, f64)> = (even(5000, period).into_iter())
        .map(|t| (t, t + late(0.5)))
        .collect();
    let even_clock = found(csv(&evenly, truth), "").unwrap();
    // Samples are taken at ticks of 1 ms, some of them one tick later, and stamped late.
    let mut ticks: Vec<(f64, f64)> = Vec::new();
    for (k, t) in even(5000, period).into_iter().enumerate() {
        let tick = if k % 23 == 7 { t + 1e-3 } else { t };
        ticks.push((tick, tick + late(0.3)));
    }
    let on_cycle = found(csv(&ticks, truth), "").unwrap();
    for (found, sampling) in [
        (&as_stamped, "as-stamped"),
        (&even_clock, "even"),
        (&on_cycle, "on-cycle"),
    ] {
        let timing = found.timing;
        println!("{sampling}: {:?}, {:?}", timing.sampling, timing.evidence);
        assert_eq!(timing.sampling.unwrap().name(), sampling);
        assert!(timing.evidence.unwrap().decisive);
    }
    let cycle = on_cycle.timing.sampling.and_then(Sampling::cycle).unwrap();
    // Least squares find a period from n stamps that are late by up to a part of it with this standard error.
    let standard_error = |part: f64| part / 5000_f64.powf(1.5);
    assert!(
        (cycle / 1e-3 - 1.0).abs() < 4.0 * standard_error(0.3),
        "{cycle}"
    );
    let error = (even_clock.timing.period / period - 1.0).abs();
    assert!(error < 4.0 * standard_error(0.5), "{error}");
    let limit = parabola_error(1.6 * period);
    assert!(worst(&as_stamped) < limit, "{}", worst(&as_stamped));
    // The mean lateness cannot be known, so it is subtracted. The rest is at most 5 % of a period at 6.4 rad/s, the
    // largest velocity.
    for (found, late) in [(&even_clock, 0.25 * period), (&on_cycle, 0.15 * period)] {
        let shifted = Found {
            columns: std::iter::once(found.columns[0].iter().map(|t| t - late).collect())
                .chain(found.columns[1..].iter().cloned())
                .collect(),
            gaps: Vec::new(),
            timing: found.timing,
        };
        assert!(worst(&shifted) < 6.4 * 0.05 * period, "{}", worst(&shifted));
    }
}

#[test]
fn a_log_may_become_uneven_later() {
    let mut random = Random::new(7);
    let period = 1e-3;
    let later = |k: usize| k > 3000;
    // Samples are late from sample 3000 on, and their stamps are right; after 6000 samples follows a pause.
    let slept: Vec<(f64, f64)> = (even(9000, period).into_iter().enumerate())
        .map(|(k, t)| {
            t + if later(k) {
                0.4 * period * random.next()
            } else {
                0.0
            }
        })
        .enumerate()
        .map(|(k, t)| t + if k > 6000 { 0.1234 } else { 0.0 })
        .map(|t| (t, t))
        .collect();
    let as_stamped = found(csv(&slept, truth), "").unwrap();
    assert_eq!(as_stamped.timing.sampling, Some(Sampling::AsStamped));
    assert_eq!(as_stamped.gaps.len(), 1);
    assert_eq!(
        as_stamped.columns[0][2500].to_bits(),
        slept[2500].1.to_bits()
    );
    let limit = parabola_error(1.4 * period);
    assert!(worst(&as_stamped) < limit, "{}", worst(&as_stamped));
    // The samples are even, but their stamps are late, so no sample is interpolated.
    let late: Vec<(f64, f64)> = (even(9000, period).into_iter().enumerate())
        .map(|(k, t)| {
            (
                t,
                t + if later(k) {
                    0.4 * period * random.next()
                } else {
                    0.0
                },
            )
        })
        .collect();
    let even_clock = found(csv(&late, truth), "").unwrap();
    assert_eq!(even_clock.timing.sampling, Some(Sampling::Even));
    assert_eq!(
        (even_clock.timing.interpolated, even_clock.columns[0].len()),
        (0, 9000)
    );
    for (k, (t, _)) in late.iter().enumerate() {
        assert_eq!(even_clock.columns[1][k].to_bits(), truth(*t)[0].to_bits());
    }
}

#[test]
fn a_joint_that_rests_tells_nothing() {
    let mut random = Random::new(8);
    let late: Vec<(f64, f64)> = (even(2000, 1e-3).into_iter())
        .map(|t| (0.0, t + 0.4e-3 * random.next()))
        .collect();
    let found = found(csv(&late, truth), "").unwrap();
    assert!(!found.timing.evidence.unwrap().decisive);
    assert_eq!(found.timing.sampling, Some(Sampling::AsStamped));
}

#[test]
fn what_is_said_is_done() {
    let mut random = Random::new(2);
    let late: Vec<(f64, f64)> = (even(3000, 2e-3).into_iter())
        .map(|t| (t, t + 0.6e-3 * random.next()))
        .collect();
    for (keys, sampling, interpolated) in [
        ("sampling = \"as-stamped\"\n", Sampling::AsStamped, true),
        ("sampling = \"even\"\n", Sampling::Even, false),
        ("period_s = 0.002\n", Sampling::OnCycle(2e-3), false),
        ("period_s = 0.001\n", Sampling::OnCycle(1e-3), false),
    ] {
        let found = found(csv(&late, truth), keys).unwrap();
        assert_eq!(found.timing.sampling, Some(sampling));
        assert_eq!(found.timing.interpolated > 0, interpolated, "{keys}");
        assert!(found.timing.evidence.is_none());
    }
    let error = found(csv(&late, truth), "period_s = 1.0\n")
        .map(|_| ())
        .unwrap_err();
    assert!(error.contains("period_s = 1 is longer"), "{error}");
    let error = found(Vec::new(), "period_s = 0.002\nsampling = \"even\"\n");
    assert!(
        error
            .map(|_| ())
            .unwrap_err()
            .contains("remove period_s or sampling")
    );
    let error = found(Vec::new(), "sampling = \"evn\"\n")
        .map(|_| ())
        .unwrap_err();
    assert!(error.contains("did you mean \"even\""), "{error}");
}

#[test]
fn missing_samples_are_interpolated_or_gaps() {
    let missing =
        |k: usize| [500, 700, 701, 900, 901, 902].contains(&k) || (2500..2504).contains(&k);
    let times = (even(5000, 1e-3).into_iter().enumerate()).filter(|&(k, _)| !missing(k));
    let found = found(csv(&stamped(times.map(|(_, t)| t)), truth), "").unwrap();
    assert_eq!(found.gaps, [2500]);
    assert_eq!(found.columns[0].len(), 4996);
    let timing = found.timing;
    assert_eq!((timing.dropped.count, timing.interpolated), (6, 6));
    assert_eq!(timing.dropped.first.unwrap().to_string(), "line 502");
    assert_eq!(timing.gaps.count, 1);
    assert!((timing.gaps.duration - 4e-3).abs() < 1e-9);
    // The error of a cubic in the middle of a step of 4 ms, with outer samples 2 ms away, is (4 · 2 · 2 · 4 ms⁴) x⁗ /
    // 24.
    let limit = 64e-12 / 24.0 * largest_derivative(4);
    assert!(worst(&found) < limit, "{}", worst(&found));
}

#[test]
fn samples_written_twice_are_counted() {
    let times = even(4000, 1e-3);
    // Two lines are written twice, and the recorder misses five updates.
    let mut samples: Vec<(f64, f64)> = Vec::new();
    for (k, &t) in times.iter().enumerate() {
        let frozen = k % 700 == 699;
        samples.push((if frozen { times[k - 1] } else { t }, t));
        if k == 100 || k == 3000 {
            samples.push((t, t));
        }
    }
    let found = found(csv(&samples, truth), "").unwrap();
    assert_eq!(found.columns[0].len(), 4000);
    let timing = found.timing;
    assert_eq!(timing.repeated.count, 2);
    assert_eq!(timing.repeated.first.unwrap().to_string(), "line 103");
    assert_eq!(timing.frozen.count, 5);
    assert_eq!(timing.frozen.first.unwrap().to_string(), "line 702");
    // A joint that rests, and encoder counts that rarely change, are not frozen.
    let counts = |t: f64| truth((t - 10.0).min(1.0)).map(|x| (x * 650.0).round() / 650.0);
    let resting = super::clocks::found(csv(&stamped(times), counts), "").unwrap();
    assert_eq!(resting.timing.frozen.count, 0);
}

#[test]
fn one_time_with_two_values_is_an_error() {
    let mut samples = stamped(even(400, 1e-3));
    samples[200].1 = samples[199].1;
    let error = found(csv(&samples, truth), "").map(|_| ()).unwrap_err();
    assert!(
        error.starts_with("line 202 of log.csv: time goes from 10.199 s"),
        "{error}"
    );
    assert!(error.contains("sampling = \"even\""), "{error}");
    let even = found(csv(&samples, truth), "sampling = \"even\"\n").unwrap();
    assert_eq!(even.columns[0].len(), 400);
    samples[200].1 = 9.0;
    for keys in ["", "sampling = \"even\"\n", "period_s = 0.001\n"] {
        let error = found(csv(&samples, truth), keys).map(|_| ()).unwrap_err();
        assert!(error.contains("samples must be in order"), "{error}");
    }
}

#[test]
fn any_times_end_well() {
    let mut random = Random::new(3);
    for case in 0..60 {
        let mut time = 0.0;
        let samples: Vec<(f64, f64)> = (0..700)
            .map(|_| {
                let size = [0.0, 1e-300, 1e-9, 1e-3, 1.0, 1e6, 1e300];
                let pick = random.next() * random.next() * f64::from(1 + case % 7);
                time += size[(pick as usize).min(6)] * (random.next() + 1e-3);
                (random.next(), time)
            })
            .collect();
        for keys in [
            "",
            "sampling = \"even\"\n",
            "sampling = \"as-stamped\"\n",
            "period_s = 1e-9\n",
        ] {
            if let Ok(found) = found(csv(&samples, truth), keys) {
                assert!(found.columns.iter().flatten().all(|x| x.is_finite()));
                // At most as many samples are added as were recorded.
                assert!(found.columns[0].len() < 2 * 700);
            }
        }
    }
}

#[test]
fn channels_on_other_clocks_meet_uneven_ones() {
    let mut random = Random::new(4);
    let main: Vec<(f64, f64)> = (even(3000, 4e-3).iter())
        .map(|t| t + 2e-3 * random.next())
        .map(|t| (t, t))
        .collect();
    let header = |text: &str, at: fn(f64) -> f64, times: &[f64]| {
        let rows: Vec<String> = times.iter().map(|&t| format!("{t},{}\n", at(t))).collect();
        format!("t,{text}\n{}", rows.concat()).into_bytes()
    };
    // The slow file begins later, the fast file ends earlier.
    let slow: Vec<f64> = even(500, 20e-3).iter().map(|t| t + 1.234).collect();
    let fast: Vec<f64> = even(40_000, 0.25e-3).iter().map(|t| t - 0.5).collect();
    let files = Files::Memory(vec![
        ("log.csv", csv(&main, truth)),
        ("slow.csv", header("phi", |t| truth(t)[2], &slow)),
        ("fast.csv", header("phi", |t| truth(t)[3], &fast)),
    ]);
    let keys = "time_s = \"t_s\"\nlink_position_rad = \"q*_rad\"\nmotor_torque_nm = \"tau*_nm\"\n\
                motor_position_rad = [{ file = \"slow.csv\", column = \"phi\", time = \"t\" }, \
                { file = \"fast.csv\", column = \"phi\", time = \"t\" }]\n";
    let experiment = experiment(keys).unwrap();
    let channels = Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap();
    let found = read_timed(&files, "log.csv", &channels).unwrap();
    assert_eq!(found.timing.sampling, Some(Sampling::AsStamped));
    let time = &found.columns[0];
    let (first, last) = (time[0], time[time.len() - 1]);
    // The slow file begins at 11.234 s and the fast file ends at 19.5 s; the grid begins and ends within one period of
    // 4 ms of these times.
    assert!(
        (first - 11.234).abs() < 4e-3 && (last - 19.5).abs() < 4e-3,
        "{first} {last}"
    );
    assert!(found.gaps.is_empty());
    let even = time
        .windows(2)
        .all(|pair| (pair[1] - pair[0] - found.timing.period).abs() < 1e-9);
    assert!(even);
    // A cubic over the 20 ms of the slow file, at 4.3 Hz, and a parabola at its ends, have an error of up to 1.5e-3
    // rad.
    let worst = worst(&found);
    assert!(worst < 1.5e-3, "{worst}");
    let of_fast = (time.iter().zip(&found.columns[4]))
        .fold(0.0_f64, |worst, (&t, x)| worst.max((x - truth(t)[3]).abs()));
    assert!(of_fast < 1e-9, "{of_fast}");
}
