//! Mountings and biases of gyroscopes from the motion of the motors.
//!
//! The motors predict the angular velocity of each link up to the deflections of the joints, so means over
//! windows are compared:
//!
//! ```text
//! R y - omega = R bias        R: the rotation with the least sum of squares (Wahba's problem)
//! ```

use faer::Mat;
use sprung_core::spatial::Vector;

use super::excerpt::Excerpt;
use crate::description::Measures;
use crate::log::{Channels, Gyroscope, Gyroscopes, LogBlock, Mix};

/// Length of the windows, s. Mean velocities over them hardly contain vibrations of the springs.
const WINDOW_S: f64 = 0.1;

/// Least number of windows for a statement about a sensor.
const MIN_WINDOWS: usize = 20;

/// Least variance of the predicted angular velocity along a second axis over that along the first one, with
/// which the handedness of the sensor shows.
const MIN_SPREAD: f64 = 1e-3;

/// Means of the reading of a sensor and of the predicted angular velocity of its link over windows.
pub(super) struct Compared {
    pub(super) readings: Vec<Vector>,
    predicted: Vec<Vector>,
}

/// Returns the channels with mountings and biases of gyroscopes; the same channels without gyroscopes.
#[must_use]
pub(super) fn mounted(channels: &Channels, excerpt: &Excerpt) -> Channels {
    let mut mounted = channels.clone();
    let Some(own) = &mut mounted.gyroscopes else {
        return mounted;
    };
    for sensor in &mut own.all {
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
    mounted
}

/// Compares a sensor with the motors; `None` if the excerpt is too short.
pub(super) fn compare(
    channels: &Channels,
    sensor: &Gyroscope,
    excerpt: &Excerpt,
) -> Option<Compared> {
    let own = channels.gyroscopes.as_ref()?;
    let window = ((WINDOW_S / excerpt.period()).round() as usize).max(1);
    let duration = window as f64 * excerpt.period();
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
            compared
                .predicted
                .push(own.angular_velocities(&middle, &rates)[sensor.joint]);
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

/// Returns the motor positions of a sample, \[n\], rad (m).
fn positions(channels: &Channels, block: &LogBlock, k: usize) -> Vec<f64> {
    let mut all = vec![0.0; channels.rigid.len()];
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

fn minus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(super) fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn times(matrix: &[Vector; 3], v: &Vector) -> Vector {
    matrix.map(|row| dot(&row, v))
}

impl Compared {
    /// Returns readings and predicted velocities minus their means.
    pub(super) fn centred(&self) -> impl Iterator<Item = (Vector, Vector)> {
        let (reading, predicted) = (mean(&self.readings), mean(&self.predicted));
        (self.readings.iter().zip(&self.predicted))
            .map(move |(y, w)| (minus(y, &reading), minus(w, &predicted)))
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
        let (mut both, mut own, mut all) = (0.0, 0.0, 0.0);
        for (y, w) in self.centred() {
            let turned = times(mounting, &y);
            both += dot(&turned, &w);
            own += dot(&turned, &turned);
            all += dot(&w, &w);
        }
        let scale = both / all;
        // Of the reading over its scale.
        let left = 1.0 - both * both / (own * all);
        (scale, left)
    }

    /// Returns the mean reading that the motion does not explain.
    fn bias(&self, sensor: &Gyroscope) -> Vector {
        let (y, w) = (mean(&self.readings), mean(&self.predicted));
        let expected = Gyroscopes::reading(sensor, &w);
        minus(&y, &expected)
    }
}
