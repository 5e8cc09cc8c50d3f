//! Mountings and biases of sensors on links from the motion of the motors.
//!
//! The motors predict the motion of each link up to the deflections of the joints, so means over
//! windows are compared. For gyroscopes:
//!
//! ```text
//! R y - omega = R bias        R: the rotation with the least sum of squares (Wahba's problem)
//! ```
//!
//! Of accelerometers rotation R and place r are found by Gauss-Newton steps from 24 rotations:
//!
//! ```text
//! y - R^T (a - g + alpha x r + omega x (omega x r)) = bias
//! ```

use faer::Mat;
use sprung_core::spatial::{Vector, difference, dot, product, rotation, times, transposed};

use super::excerpt::Excerpt;
use crate::description::{Inertial, Measures};
use crate::log::{Channels, InertialSensor, InertialSensors, LinkMotion, LogBlock, Mix};

/// Length of the windows, s. Mean velocities over them hardly contain vibrations of the springs.
const WINDOW_S: f64 = 0.1;

/// Least number of windows for a statement about a sensor.
const MIN_WINDOWS: usize = 20;

/// Least variance of the predicted angular velocity along a second axis over that along the first one, with
/// which the handedness of the sensor shows.
const MIN_SPREAD: f64 = 1e-3;

/// Means of the reading of a sensor, and of the reading in the axes of the link that the motors predict, over
/// windows.
pub(super) struct Compared {
    pub(super) readings: Vec<Vector>,
    predicted: Vec<Vector>,
}

/// Returns the channels with mountings and biases of sensors; the same channels without sensors.
#[must_use]
pub(super) fn mounted(channels: &Channels, excerpt: &Excerpt) -> Channels {
    let mut mounted = channels.clone();
    let Some(sensors) = &mut mounted.inertial else {
        return mounted;
    };
    match sensors.kind {
        Inertial::Gyroscope => mount_gyroscopes(channels, &mut sensors.all, excerpt),
        Inertial::Accelerometer => mount_accelerometers(channels, sensors, excerpt),
    }
    mounted
}

fn mount_gyroscopes(channels: &Channels, sensors: &mut [InertialSensor], excerpt: &Excerpt) {
    for sensor in sensors {
        let Some(compared) = compare(channels, sensor, excerpt) else {
            continue;
        };
        if !sensor.is_mounted
            && let Some(best) = compared.best_rotation()
        {
            sensor.mounting = best.rotation;
        }
        sensor.bias = compared.bias(sensor);
    }
}

/// Compares a sensor with the motors; `None` if the excerpt is too short.
pub(super) fn compare(
    channels: &Channels,
    sensor: &InertialSensor,
    excerpt: &Excerpt,
) -> Option<Compared> {
    match channels.inertial.as_ref()?.kind {
        Inertial::Gyroscope => compare_gyroscope(channels, sensor, excerpt),
        Inertial::Accelerometer => compare_accelerometer(channels, sensor, excerpt),
    }
}

fn compare_gyroscope(
    channels: &Channels,
    sensor: &InertialSensor,
    excerpt: &Excerpt,
) -> Option<Compared> {
    let sensors = channels.inertial.as_ref()?;
    let window = ((WINDOW_S / excerpt.period()).round() as usize).max(1);
    let duration = window as f64 * excerpt.period();
    // No acceleration is needed.
    let still = vec![0.0; channels.instruments.joint_count()];
    let mut compared = Compared {
        readings: Vec::new(),
        predicted: Vec::new(),
    };
    for (block, range) in excerpt.blocks().iter().flat_map(|block| {
        let bounds = [0].into_iter().chain(block.gaps.iter().copied());
        let ends = block.gaps.iter().copied().chain([block.len()]);
        bounds.zip(ends).map(move |range| (block, range))
    }) {
        let (mut at, end) = range;
        while at + window < end {
            let [before, after] = [at, at + window].map(|k| positions(channels, block, k));
            let middle: Vec<f64> = (before.iter().zip(&after))
                .map(|(a, b)| 0.5 * (a + b))
                .collect();
            let rates: Vec<f64> = (before.iter().zip(&after))
                .map(|(a, b)| (b - a) / duration)
                .collect();
            compared.predicted.push(sensors.in_link(
                sensor,
                &sensors.motions([&middle, &rates, &still])[sensor.joint],
            ));
            compared.readings.push(sensor.channels.map(|channel| {
                let values = channel.map_or(&[][..], |i| &block.values[i][at..=at + window]);
                // The trapezoidal mean over the window.
                let ends = values.first().zip(values.last());
                let ends = ends.map_or(0.0, |(first, last)| 0.5 * (first + last));
                (values.iter().sum::<f64>() - ends) / window as f64
            }));
            at += window;
        }
    }
    (compared.readings.len() >= MIN_WINDOWS).then_some(compared)
}

fn compare_accelerometer(
    channels: &Channels,
    sensor: &InertialSensor,
    excerpt: &Excerpt,
) -> Option<Compared> {
    let sensors = channels.inertial.as_ref()?;
    let windows = windows(channels, sensor, excerpt);
    let predicted = windows.iter().map(|window| {
        // Only what its axes feel.
        let exact = masked(sensor, sensors.reading(sensor, &window.motion));
        times(&sensor.mounting, &exact)
    });
    Some(Compared {
        predicted: predicted.collect(),
        readings: windows.iter().map(|window| window.reading).collect(),
    })
    .filter(|compared| compared.readings.len() >= MIN_WINDOWS)
}

/// Returns a reading with zeros for the axes that a sensor does not have.
fn masked(sensor: &InertialSensor, reading: Vector) -> Vector {
    std::array::from_fn(|i| sensor.channels[i].map_or(0.0, |_| reading[i]))
}

/// Mean reading of an accelerometer over two windows, and the motion of its link by the motors.
struct Window {
    reading: Vector,
    motion: LinkMotion,
}

/// Returns the means over pairs of neighbouring windows. Their weights rise and fall linearly, so the second
/// difference of positions is the mean acceleration.
fn windows(channels: &Channels, sensor: &InertialSensor, excerpt: &Excerpt) -> Vec<Window> {
    let Some(sensors) = &channels.inertial else {
        return Vec::new();
    };
    let window = ((WINDOW_S / excerpt.period()).round() as usize).max(1);
    let duration = window as f64 * excerpt.period();
    let weight = |k: usize| (1.0 - (k as f64 / window as f64 - 1.0).abs()) / window as f64;
    let weights: Vec<f64> = (0..=2 * window).map(weight).collect();
    let mut all = Vec::new();
    for block in excerpt.blocks() {
        let bounds = [0].into_iter().chain(block.gaps.iter().copied());
        let ends = block.gaps.iter().copied().chain([block.len()]);
        for (mut at, end) in bounds.zip(ends) {
            while at + 2 * window < end {
                let [p0, p1, p2] =
                    [0, window, 2 * window].map(|k| positions(channels, block, at + k));
                let mut links: Vec<LinkMotion> = Vec::new();
                for i in 0..=sensor.joint {
                    let rate = (p2[i] - p0[i]) / (2.0 * duration);
                    let acceleration = (p2[i] - 2.0 * p1[i] + p0[i]) / (duration * duration);
                    links.push(sensors.next(&links, [p1[i], rate, acceleration]));
                }
                let reading = sensor.channels.map(|channel| {
                    channel.map_or(0.0, |i| {
                        let values = &block.values[i][at..=at + 2 * window];
                        values.iter().zip(&weights).map(|(y, w)| y * w).sum()
                    })
                });
                all.push(Window {
                    reading,
                    motion: links[sensor.joint],
                });
                at += window;
            }
        }
    }
    all
}

fn mount_accelerometers(channels: &Channels, sensors: &mut InertialSensors, excerpt: &Excerpt) {
    for i in 0..sensors.all.len() {
        let windows = windows(channels, &sensors.all[i], excerpt);
        if windows.len() < MIN_WINDOWS {
            continue;
        }
        if !sensors.all[i].is_mounted {
            fit_windows(sensors, i, &windows);
        }
        sensors.all[i].bias = mean_residual(sensors, &sensors.all[i], &windows);
    }
}

/// Gives a sensor the mounting with the least sum of squares.
fn fit_windows(sensors: &mut InertialSensors, i: usize, windows: &[Window]) {
    let starts = rotations().into_iter().map(|mounting| {
        let start = InertialSensor {
            mounting,
            position: [0.0; 3],
            ..sensors.all[i].clone()
        };
        placed(sensors, start, windows)
    });
    let best = starts.min_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((best, _)) = best {
        sensors.all[i] = best;
    }
    let sensor = &mut sensors.all[i];
    let mut axes = (0..3).filter(|&axis| sensor.channels[axis].is_some());
    if let (Some(axis), None) = (axes.next(), axes.next()) {
        // Along the only axis, the place acts only by the squared velocity, so noise dominates its
        // estimate.
        let axis: Vector = std::array::from_fn(|row| sensor.mounting[row][axis]);
        let along = dot(&axis, &sensor.position);
        sensor.position = std::array::from_fn(|k| sensor.position[k] - along * axis[k]);
    }
}

/// Returns the mean reading that the motion does not explain.
fn mean_residual(sensors: &InertialSensors, sensor: &InertialSensor, windows: &[Window]) -> Vector {
    let rest: Vec<Vector> = windows
        .iter()
        .map(|w| residual(sensors, sensor, w))
        .collect();
    mean(&rest)
}

/// Returns the reading that an accelerometer's mounting leaves.
fn residual(sensors: &InertialSensors, sensor: &InertialSensor, window: &Window) -> Vector {
    let exact = sensors.reading(sensor, &window.motion);
    masked(sensor, difference(&window.reading, &exact))
}

/// Number of unknowns of a mounting: rotation vector, then place.
const UNKNOWNS: usize = 6;

/// Gauss-Newton steps from each start; most starts end after ten.
const MAX_STEPS: usize = 30;

/// Step of the differences of the residual, rad and m.
const DIFFERENCE: f64 = 1e-5;

/// Returns the mounting that leaves the least sum of squares near a start, and this sum.
fn placed(
    sensors: &InertialSensors,
    start: InertialSensor,
    windows: &[Window],
) -> (InertialSensor, f64) {
    let residuals = |sensor: &InertialSensor| -> Vec<f64> {
        let all: Vec<Vector> = windows
            .iter()
            .map(|w| residual(sensors, sensor, w))
            .collect();
        let mean = mean(&all);
        all.iter().flat_map(|r| difference(r, &mean)).collect()
    };
    let squares = |all: &[f64]| all.iter().map(|r| r * r).sum::<f64>();
    let (mut sensor, mut damping) = (start, 1e-3);
    let mut before = residuals(&sensor);
    let mut cost = squares(&before);
    for _ in 0..MAX_STEPS {
        let columns: Vec<Vec<f64>> = (0..UNKNOWNS)
            .map(|unknown| {
                let mut step = [0.0; UNKNOWNS];
                step[unknown] = DIFFERENCE;
                let after = residuals(&moved(&sensor, &step));
                let pairs = after.iter().zip(&before);
                pairs.map(|(a, b)| (a - b) / DIFFERENCE).collect()
            })
            .collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let matrix = Mat::from_fn(UNKNOWNS, UNKNOWNS, |i, j| product(&columns[i], &columns[j]));
        let gradient = Mat::from_fn(UNKNOWNS, 1, |i, _| -product(&columns[i], &before));
        let size = (0..UNKNOWNS).map(|i| matrix[(i, i)]).fold(0.0, f64::max);
        let mut is_better = false;
        for _ in 0..8 {
            // Directions that the motion does not show are unchanged.
            let damped = Mat::from_fn(UNKNOWNS, UNKNOWNS, |i, j| {
                let ridge = if i == j {
                    damping * size + f64::MIN_POSITIVE
                } else {
                    0.0
                };
                matrix[(i, j)] + ridge
            });
            let step = {
                use faer::linalg::solvers::Solve;
                damped.partial_piv_lu().solve(&gradient)
            };
            let step: [f64; UNKNOWNS] = std::array::from_fn(|i| step[(i, 0)]);
            let next = moved(&sensor, &step);
            let after = residuals(&next);
            let sum = squares(&after);
            if sum < cost {
                is_better = (cost - sum) > 1e-9 * cost;
                (sensor, before, cost) = (next, after, sum);
                damping = (0.1 * damping).max(1e-12);
                break;
            }
            damping *= 10.0;
        }
        if !is_better {
            break;
        }
    }
    (sensor, cost)
}

/// Returns a sensor turned by a rotation vector and moved, rad and m.
fn moved(sensor: &InertialSensor, step: &[f64; UNKNOWNS]) -> InertialSensor {
    let turn = [step[0], step[1], step[2]];
    let angle = dot(&turn, &turn).sqrt();
    let mounting = if angle > 0.0 {
        product(&sensor.mounting, &rotation(&turn.map(|x| x / angle), angle))
    } else {
        sensor.mounting
    };
    InertialSensor {
        mounting,
        position: std::array::from_fn(|i| sensor.position[i] + step[3 + i]),
        ..sensor.clone()
    }
}

/// Returns the rotations that map axes to axes.
fn rotations() -> Vec<[Vector; 3]> {
    let mut all = Vec::new();
    for first in 0..3 {
        for second in (0..3).filter(|second| *second != first) {
            for signs in 0..4 {
                let sign = |bit: i32| if signs & bit == 0 { 1.0 } else { -1.0 };
                let unit = |axis: usize, sign: f64| -> Vector {
                    std::array::from_fn(|i| if i == axis { sign } else { 0.0 })
                };
                let (a, b) = (unit(first, sign(1)), unit(second, sign(2)));
                let c = [
                    a[1] * b[2] - a[2] * b[1],
                    a[2] * b[0] - a[0] * b[2],
                    a[0] * b[1] - a[1] * b[0],
                ];
                all.push([a, b, c]);
            }
        }
    }
    all
}

/// Returns the motor positions of a sample, \[n\], rad (m).
fn positions(channels: &Channels, block: &LogBlock, k: usize) -> Vec<f64> {
    let mut all = vec![0.0; channels.instruments.joint_count()];
    for (channel, values) in channels.all.iter().zip(&block.values) {
        let is_motor =
            |link: f64, motor: f64| link.abs() <= f64::EPSILON && motor.abs() > f64::EPSILON;
        if let Measures::Position { link, motor } = channel.quantity.measures()
            && is_motor(link, motor)
        {
            all[channel.joint] = values[k];
        }
    }
    if let Some(mix) = &channels.position_mix {
        all = Mix::apply(&mix.forward, &all);
    }
    for (position, offset) in all.iter_mut().zip(&channels.offsets) {
        *position += offset;
    }
    all
}

/// The rotation that maps readings to angular velocities best.
pub(super) struct Best {
    pub(super) rotation: [Vector; 3],
    /// The reflection that maps them better, if there is one and the motion shows it.
    pub(super) reflection: Option<[Vector; 3]>,
}

fn mean(all: &[Vector]) -> Vector {
    std::array::from_fn(|i| all.iter().map(|v| v[i]).sum::<f64>() / all.len().max(1) as f64)
}

impl Compared {
    /// Returns readings and predicted velocities minus their means.
    pub(super) fn centred(&self) -> impl Iterator<Item = (Vector, Vector)> {
        let (reading, predicted) = (mean(&self.readings), mean(&self.predicted));
        (self.readings.iter().zip(&self.predicted))
            .map(move |(y, w)| (difference(y, &reading), difference(w, &predicted)))
    }

    pub(super) fn best_rotation(&self) -> Option<Best> {
        let mut product = Mat::<f64>::zeros(3, 3);
        let mut spread = Mat::<f64>::zeros(3, 3);
        for (y, w) in self.centred() {
            for i in 0..3 {
                for j in 0..3 {
                    product[(i, j)] += w[i] * y[j];
                    spread[(i, j)] += w[i] * w[j];
                }
            }
        }
        let svd = product.svd().ok()?;
        let variances = spread.svd().ok()?;
        let variances = variances.S().column_vector();
        let signed = svd.U() * svd.V().transpose();
        let determinant = signed.determinant();
        let mut flip = Mat::<f64>::identity(3, 3);
        flip[(2, 2)] = determinant.signum();
        let rotation = svd.U() * flip * svd.V().transpose();
        let rows = |matrix: &Mat<f64>| -> [Vector; 3] {
            std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
        };
        let is_reflected = determinant < 0.0 && variances[2] > MIN_SPREAD * variances[0];
        Some(Best {
            rotation: rows(&rotation),
            reflection: is_reflected.then(|| rows(&signed)),
        })
    }

    /// Returns scale and bias of the reading, and the part of the squared velocity that it leaves.
    ///
    /// - `mounting`: of the sensor.
    pub(super) fn fit(&self, mounting: &[Vector; 3]) -> (f64, f64) {
        let (mut both, mut predicted, mut all) = (0.0, 0.0, 0.0);
        for (y, w) in self.centred() {
            let turned = times(mounting, &y);
            both += dot(&turned, &w);
            predicted += dot(&turned, &turned);
            all += dot(&w, &w);
        }
        let scale = both / all;
        // Of the reading over its scale.
        let left = 1.0 - both * both / (predicted * all);
        (scale, left)
    }

    /// Returns the mean reading that the motion does not explain.
    fn bias(&self, sensor: &InertialSensor) -> Vector {
        let (y, w) = (mean(&self.readings), mean(&self.predicted));
        let expected = times(&transposed(&sensor.mounting), &w);
        difference(&y, &expected)
    }
}
