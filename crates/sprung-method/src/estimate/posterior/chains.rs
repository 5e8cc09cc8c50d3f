//! Chains of Gibbs steps over the robots that can exist.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use sprung_core::linear::dot;

use super::borders::{Borders, Place};
use super::centre::program;
use super::density::Density;
use super::normal::coordinates;
use super::plain::stream;
use super::samples::DrawMethod;
use super::truncated::draw;

/// Number of chains, whatever the number of threads.
const CHAINS: usize = 8;

/// Sweeps before the first robot: burn-in, and draws that measure the correlation of a chain.
const FORGET: usize = 16;
const LISTEN: usize = 48;

/// Largest correlation of neighbours after thinning: half of the robots then count as independent.
const LEFT: f64 = 1.0 / 3.0;

/// Normal draws of a coordinate before its borders are computed.
const TRIES: usize = 3;

/// Most sweeps from one robot to the next.
const MOST_SWEEPS: usize = 32;

/// The posterior in coordinates along which its spread is near one.
pub(super) struct Chains<'a> {
    density: &'a Density,
    /// Change of the unknowns by each coordinate from the centre.
    directions: Vec<Vec<f64>>,
    borders: Borders,
    /// Second derivatives of minus the logarithm of the density, \[n\]\[n\], and first ones at the centre, \[n\].
    curvature: Vec<Vec<f64>>,
    slope: Vec<f64>,
}

/// Robots that were drawn.
pub(super) struct Drawn {
    /// Unknowns of each robot.
    pub(super) unknowns: Vec<Vec<f64>>,
    pub(super) method: DrawMethod,
    /// How many independent robots they are worth.
    pub(super) effective: f64,
}

/// A robot on its way.
struct Walker<'a> {
    chains: &'a Chains<'a>,
    rng: ChaCha8Rng,
    coordinates: Vec<f64>,
    slope: Vec<f64>,
    place: Place,
}

impl<'a> Chains<'a> {
    pub(super) fn new(density: &'a Density) -> Self {
        let n = density.mean.len();
        let directions = metric(density).and_then(|metric| coordinates(&metric));
        // Without a metric the unknowns themselves are the coordinates.
        let directions = directions.unwrap_or_else(|| {
            let unit = |k: usize| (0..n).map(|i| f64::from(u8::from(i == k))).collect();
            (0..n).map(unit).collect()
        });
        let product = |of: &[f64]| -> Vec<f64> {
            (0..n)
                .map(|i| (0..n).map(|j| density.precision[(i, j)] * of[j]).sum())
                .collect()
        };
        let moved: Vec<Vec<f64>> = directions
            .iter()
            .map(|direction| product(direction))
            .collect();
        let from_mean: Vec<f64> = (density.centre.iter().zip(&density.mean))
            .map(|(centre, mean)| centre - mean)
            .collect();
        Self {
            borders: Borders::new(&density.blocks, &density.centre, &directions),
            curvature: (moved.iter())
                .map(|image| directions.iter().map(|other| dot(image, other)).collect())
                .collect(),
            slope: moved.iter().map(|image| dot(image, &from_mean)).collect(),
            density,
            directions,
        }
    }

    /// Draws robots.
    pub(super) fn draw(&self, count: usize, seed: u64) -> Drawn {
        let chains = CHAINS.min(count);
        let mut walkers: Vec<(Walker<'_>, Correlation)> = (0..chains)
            .into_par_iter()
            .map(|chain| {
                let mut walker = self.walker(stream(seed, chain as u64));
                for _ in 0..FORGET {
                    walker.sweep();
                }
                let heard: Vec<Vec<f64>> = (0..LISTEN)
                    .map(|_| {
                        walker.sweep();
                        self.seen(&walker.unknowns())
                    })
                    .collect();
                (walker, Correlation::of(&heard))
            })
            .collect();
        let heard: Vec<&Correlation> = walkers.iter().map(|(_, correlation)| correlation).collect();
        let correlation = Correlation::largest(&heard);
        let sweeps = sweeps(correlation);
        let robots: Vec<Vec<Vec<f64>>> = (walkers.par_iter_mut().enumerate())
            .map(|(chain, (walker, _))| {
                let draw_count = (chain + 1) * count / chains - chain * count / chains;
                (0..draw_count)
                    .map(|_| {
                        for _ in 0..sweeps {
                            walker.sweep();
                        }
                        walker.unknowns()
                    })
                    .collect()
            })
            .collect();
        let seen: Vec<Correlation> = (robots.par_iter())
            .map(|chain| {
                let seen: Vec<Vec<f64>> = chain.iter().map(|x| self.seen(x)).collect();
                Correlation::of(&seen)
            })
            .collect();
        let left = Correlation::largest(&seen.iter().collect::<Vec<_>>());
        let share = (1.0 - left) / (1.0 + left);
        let method = DrawMethod::Gibbs { chains, sweeps };
        let robots = robots.into_iter().flatten().collect();
        Drawn {
            unknowns: robots,
            method,
            effective: count as f64 * share.min(1.0),
        }
    }

    fn walker(&self, rng: ChaCha8Rng) -> Walker<'_> {
        let coordinates = vec![0.0; self.directions.len()];
        Walker {
            place: self.borders.at(&coordinates),
            slope: self.slope.clone(),
            coordinates,
            rng,
            chains: self,
        }
    }

    /// Returns the quantities by which the correlation of successive robots is measured: its unknowns and parameters.
    fn seen(&self, x: &[f64]) -> Vec<f64> {
        let mut all = self.density.theta(x);
        all.extend_from_slice(x);
        all
    }
}

impl Walker<'_> {
    /// Draws all coordinates anew, one after the other.
    fn sweep(&mut self) {
        let before = self.coordinates.clone();
        for coordinate in 0..before.len() {
            self.step(coordinate);
        }
        // Sums of many steps would lose digits.
        let place = self.chains.borders.at(&self.coordinates);
        if self.chains.borders.contain(&place) {
            self.place = place;
        } else {
            self.place = self.chains.borders.at(&before);
            self.coordinates = before;
        }
        for ((slope, row), at_centre) in (self.slope.iter_mut())
            .zip(&self.chains.curvature)
            .zip(&self.chains.slope)
        {
            *slope = at_centre + dot(row, &self.coordinates);
        }
    }

    /// Draws one coordinate from its distribution with all others given: a normal one between two borders.
    fn step(&mut self, coordinate: usize) {
        let row = &self.chains.curvature[coordinate];
        let spread = row[coordinate].sqrt().recip();
        let middle = -self.slope[coordinate] / row[coordinate];
        let Some(by) = self
            .by(coordinate, middle, spread)
            .filter(|by| by.is_finite())
        else {
            return;
        };
        self.coordinates[coordinate] += by;
        for (slope, entry) in self.slope.iter_mut().zip(row) {
            *slope += by * entry;
        }
    }

    /// Moves along a coordinate to a draw from the normal distribution between the borders. Normal draws are tried
    /// first: the first one between the borders has this distribution too, and computing the borders takes longer.
    fn by(&mut self, coordinate: usize, middle: f64, spread: f64) -> Option<f64> {
        let borders = &self.chains.borders;
        for _ in 0..TRIES {
            let z: f64 = self.rng.sample(StandardNormal);
            let by = middle + spread * z;
            if borders.may_go(&mut self.place, coordinate, by) {
                return Some(by);
            }
        }
        let ends = borders.ends(&self.place, coordinate)?;
        let z = draw(ends.map(|end| (end - middle) / spread), &mut self.rng);
        let by = (middle + spread * z).max(ends[0]).min(ends[1]);
        borders.go(&mut self.place, coordinate, by);
        Some(by)
    }

    fn unknowns(&self) -> Vec<f64> {
        let mut x = self.chains.density.centre.clone();
        for (by, direction) in self.coordinates.iter().zip(&self.chains.directions) {
            for (value, change) in x.iter_mut().zip(direction) {
                *value += by * change;
            }
        }
        x
    }
}

/// Sums over neighbours of a chain, by quantity.
struct Correlation(Vec<[f64; 2]>);

impl Correlation {
    /// - `values`: values of each robot, \[robots\]\[quantities\].
    fn of(values: &[Vec<f64>]) -> Self {
        let count = values.first().map_or(0, Vec::len);
        let of = |quantity: usize| {
            let of_quantity = || values.iter().map(move |robot| robot[quantity]);
            let mean = of_quantity().sum::<f64>() / values.len() as f64;
            let both = of_quantity().zip(of_quantity().skip(1));
            let product: f64 = both.map(|(a, b)| (a - mean) * (b - mean)).sum();
            let square: f64 = of_quantity().map(|a| (a - mean).powi(2)).sum();
            [product, square]
        };
        Self((0..count).map(of).collect())
    }

    /// Returns the largest correlation of neighbours among all quantities, 0 to 1.
    fn largest(chains: &[&Self]) -> f64 {
        let count = chains.first().map_or(0, |chain| chain.0.len());
        let of = |quantity: usize| {
            let sum = |k: usize| chains.iter().map(|chain| chain.0[quantity][k]).sum::<f64>();
            let (product, square) = (sum(0), sum(1));
            if square > 0.0 { product / square } else { 0.0 }
        };
        (0..count).map(of).fold(0.0, f64::max).min(1.0)
    }
}

/// Returns the sweeps from one robot to the next that leave a small correlation.
///
/// - `correlation`: after one sweep.
fn sweeps(correlation: f64) -> usize {
    let wanted = LEFT.ln() / correlation.max(f64::MIN_POSITIVE).ln();
    (wanted.ceil() as usize).clamp(1, MOST_SWEEPS)
}

/// Returns the second derivatives of minus the logarithm of the density with the barrier at the centre.
fn metric(density: &Density) -> Option<faer::Mat<f64>> {
    let n = density.mean.len();
    let program = program(&density.precision, density.blocks.clone());
    let hessian = program.hessian_with_barrier(&density.centre, 1.0)?;
    Some(faer::Mat::from_fn(n, n, |i, j| hessian[i * n + j]))
}
