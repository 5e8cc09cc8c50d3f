//! Errors of interpolating uneven samples onto a grid, by method: a table.

use std::f64::consts::TAU;

use sprung_testing::Figure;

use super::clocks::{Random, csv, found, truth};

const PERIOD: f64 = 4e-3;
const SAMPLES: u32 = 5000;

/// Size of an encoder count, rad: 2^14 counts per turn on the output side.
const COUNT: f64 = TAU / 16384.0;

/// Errors of positions and velocities on a grid.
struct Errors {
    position: f64,
    velocity: f64,
    // Slope of the velocities over the true ones, less 1.
    gain: f64,
}

/// Compares positions at some times with the truth. Velocities are central differences; they are compared with
/// differences of the truth on the same grid.
fn errors(time: &[f64], position: &[f64], at: impl Fn(f64) -> f64) -> Errors {
    let (mut position_2, mut velocity_2, mut both, mut square) = (0.0, 0.0, 0.0, 0.0);
    let inner = 10..time.len() - 10;
    let count = inner.len() as f64;
    for k in inner {
        let step = time[k + 1] - time[k - 1];
        let velocity = (position[k + 1] - position[k - 1]) / step;
        let of_truth = (at(time[k + 1]) - at(time[k - 1])) / step;
        position_2 += (position[k] - at(time[k])).powi(2) / count;
        velocity_2 += (velocity - of_truth).powi(2) / count;
        both += velocity * of_truth;
        square += of_truth * of_truth;
    }
    Errors {
        position: position_2.sqrt(),
        velocity: velocity_2.sqrt(),
        gain: both / square - 1.0,
    }
}

/// Returns the value at `at` of the polynomial that fits samples by least squares. If there is one sample more than
/// the degree, the polynomial passes through all of them.
fn fitted(times: &[f64], values: &[f64], degree: usize, at: f64) -> f64 {
    let size = degree + 1;
    let mut normal = vec![vec![0.0; size + 1]; size];
    for (t, value) in times.iter().zip(values) {
        let powers: Vec<f64> = (0..size)
            .map(|i| ((t - at) / PERIOD).powi(i as i32))
            .collect();
        for i in 0..size {
            for j in 0..size {
                normal[i][j] += powers[i] * powers[j];
            }
            normal[i][size] += powers[i] * value;
        }
    }
    for i in 0..size {
        let most = (i..size).max_by(|&a, &b| normal[a][i].abs().total_cmp(&normal[b][i].abs()));
        normal.swap(i, most.unwrap());
        let pivot = normal[i].clone();
        for row in &mut normal[i + 1..] {
            let factor = row[i] / pivot[i];
            for (value, above) in row.iter_mut().zip(&pivot) {
                *value -= factor * above;
            }
        }
    }
    let mut solution = vec![0.0; size];
    for i in (0..size).rev() {
        let rest: f64 = (i + 1..size).map(|j| normal[i][j] * solution[j]).sum();
        solution[i] = (normal[i][size] - rest) / normal[i][i];
    }
    solution[0]
}

/// Cubic between two samples with slopes from the neighbours of each.
fn hermite(t: &[f64], x: &[f64], at: f64) -> f64 {
    let step = t[2] - t[1];
    let (before, after) = ((x[2] - x[0]) / (t[2] - t[0]), (x[3] - x[1]) / (t[3] - t[1]));
    let s = (at - t[1]) / step;
    let (r, q) = (1.0 - s, s * s);
    r * r * (1.0 + 2.0 * s) * x[1]
        + q * (3.0 - 2.0 * s) * x[2]
        + step * s * r * (r * before - s * after)
}

/// Name of a method, and its value at a time between samples `k` and `k + 1`.
type Method = (&'static str, fn(&[f64], &[f64], usize, f64) -> f64);

const OTHERS: [Method; 5] = [
    ("nearest", |t, x, k, at| {
        if at - t[k] < t[k + 1] - at {
            x[k]
        } else {
            x[k + 1]
        }
    }),
    ("line", |t, x, k, at| {
        fitted(&t[k..k + 2], &x[k..k + 2], 1, at)
    }),
    ("Hermite's cubic", |t, x, k, at| {
        hermite(&t[k - 1..k + 3], &x[k - 1..k + 3], at)
    }),
    ("cubic of the nearest four", |t, x, k, at| {
        fitted(&t[k - 1..k + 3], &x[k - 1..k + 3], 3, at)
    }),
    ("cubic fitted to six", |t, x, k, at| {
        fitted(&t[k - 2..k + 4], &x[k - 2..k + 4], 3, at)
    }),
];

/// Times at which samples were taken.
fn clocks() -> [(&'static str, Vec<f64>); 4] {
    let jittering = |part: f64| {
        let mut random = Random::new(5);
        (0..SAMPLES)
            .map(|k| PERIOD * (f64::from(k) + part * (2.0 * random.next() - 1.0)))
            .collect()
    };
    // A poll every 4 ms of a controller that runs at 2 ms; some polls are late by up to 11 ms.
    let mut random = Random::new(6);
    let mut polled: Vec<f64> = Vec::new();
    for k in 0..SAMPLES {
        let late = match random.next() {
            x if x < 0.004 => 8e-3,
            x if x < 0.04 => 2e-3,
            _ => 0.0,
        };
        let after = polled.last().map_or(0.0, |last| last + 2e-3);
        polled.push((PERIOD * f64::from(k) + late).max(after));
    }
    [
        ("jitter 0.1 %", jittering(1e-3)),
        ("jitter 1 %", jittering(1e-2)),
        ("jitter 10 %", jittering(0.1)),
        ("2 to 12 ms", polled),
    ]
}

/// Notes the errors of a clock for the documentation.
fn note(clock: &str, ours: &Errors, line: &Errors, even: &Errors) {
    let velocity = format!(
        "{clock}: velocity (taken as even {:.1e} rad/s)",
        even.velocity
    );
    let figure = Figure::lower(
        &format!("{clock}, velocity"),
        &velocity,
        ours.velocity,
        "rad/s",
    );
    figure.beside("straight line", line.velocity).note();
    let (name, text) = (format!("{clock}, position"), format!("{clock}: position"));
    let figure = Figure::lower(&name, &text, ours.position, "rad");
    figure.beside("straight line", line.position).note();
}

#[test]
fn positions_and_velocities_by_method() {
    println!("position, 1e-6 rad; velocity, 1e-3 rad/s; gain of the velocity less 1, 1e-6");
    for (resolution, step) in [("fine", 0.0), ("16384 counts", COUNT)] {
        let cells = |t: f64| {
            truth(t).map(|x| {
                if step > 0.0 {
                    step * (x / step).round()
                } else {
                    x
                }
            })
        };
        for (clock, times) in clocks() {
            let samples: Vec<(f64, f64)> = times.iter().map(|&t| (t, t)).collect();
            let as_stamped = found(csv(&samples, cells), "sampling = \"as-stamped\"\n").unwrap();
            let ours = errors(&as_stamped.columns[0], &as_stamped.columns[1], |t| {
                truth(t)[0]
            });
            let values: Vec<f64> = times.iter().map(|&t| cells(t)[0]).collect();
            let even: Vec<f64> = (0..SAMPLES).map(|k| PERIOD * f64::from(k)).collect();
            let mut rows = vec![("taken as even", errors(&even, &values, |t| truth(t)[0]))];
            for (name, method) in OTHERS {
                let mut k = 2;
                let mut put = Vec::new();
                for &at in &even[5..even.len() - 5] {
                    while times[k + 1] <= at {
                        k += 1;
                    }
                    put.push(method(&times, &values, k, at));
                }
                rows.push((
                    name,
                    errors(&even[5..even.len() - 5], &put, |t| truth(t)[0]),
                ));
            }
            println!("{clock}, {resolution}");
            for (name, of) in rows
                .iter()
                .map(|(name, of)| (*name, of))
                .chain([("sprung", &ours)])
            {
                println!(
                    "  {name:26} {:9.3} {:9.3} {:9.1}",
                    1e6 * of.position,
                    1e3 * of.velocity,
                    1e6 * of.gain
                );
            }
            let line = &rows[2].1;
            if step == 0.0 {
                note(clock, &ours, line, &rows[0].1);
            }
            // Rounding to counts adds white noise of a count over √12 to the positions. Summed by parts, the gain's
            // standard error is this noise times |acceleration| over velocity² √n, root mean squares.
            let [velocity, acceleration] = [1, 2].map(|order| {
                let wave = |size: f64, hz: f64| size * (TAU * hz).powi(order) / 2_f64.sqrt();
                wave(0.5, 1.1).hypot(wave(0.1, 4.3))
            });
            let noise = COUNT / 12_f64.sqrt();
            let standard_error =
                noise * acceleration / (velocity * velocity * f64::from(SAMPLES).sqrt());
            assert!(ours.gain.abs() < 4.0 * standard_error, "{}", ours.gain);
            if step > 0.0 {
                // The method does not amplify quantisation noise, whose standard deviation is a count over √12.
                assert!(
                    ours.position < 1.15 * step / 12.0_f64.sqrt(),
                    "{}",
                    ours.position
                );
            } else {
                // The errors of a cubic and of a line differ by (ω h)²; this is for the fastest wave and the longest
                // step.
                let orders = (TAU * 4.3 * 12e-3).powi(2);
                assert!(ours.position < orders * line.position);
                assert!(ours.velocity < orders * line.velocity);
            }
        }
    }
}

#[test]
fn held_torques_keep_their_mean() {
    println!("mean of a held torque over a period, RMS error, N·m");
    let torque = |t: f64| truth(t)[5] + 0.5 * (311.0 * t).sin();
    for (clock, times) in clocks() {
        let samples: Vec<(f64, f64)> = times.iter().map(|&t| (t, t)).collect();
        let of = |t: f64| {
            let mut all = truth(t);
            all[5] = torque(t);
            all
        };
        let as_stamped = found(csv(&samples, of), "sampling = \"as-stamped\"\n").unwrap();
        let period = as_stamped.timing.period;
        let held = |at: f64| torque(times[times.partition_point(|t| *t <= at).max(1) - 1]);
        let mean = |at: f64| {
            (0..200)
                .map(|i| held(at + period * (f64::from(i) + 0.5) / 200.0))
                .sum::<f64>()
                / 200.0
        };
        let mut squares = [0.0_f64; 2];
        let inner = 10..as_stamped.columns[0].len() - 10;
        for k in inner.clone() {
            let (at, found) = (as_stamped.columns[0][k], as_stamped.columns[6][k]);
            squares[0] += (held(at) - mean(at)).powi(2);
            squares[1] += (found - mean(at)).powi(2);
        }
        let [last, ours] = squares.map(|square| (square / inner.len() as f64).sqrt());
        println!("  {clock:14} last value {last:.2e}, sprung's line {ours:.2e}");
        // Between even samples the line is exact. Between uneven ones a part of the error stays.
        assert!(ours < last, "{ours} {last}");
    }
}
