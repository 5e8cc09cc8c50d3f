//! Independent draws, of which those that can exist are kept.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

use super::density::Density;
use super::normal::coordinates;
use crate::model::Block;

/// Number of draws for the share of possible robots, and the least share of these.
const TRIALS: u64 = 400;
const LEAST_SHARE: f64 = 0.05;

/// Draws until one can exist. With the least share, the probability that none of so many is
/// possible is 1e-44.
const MOST_DRAWS: usize = 2000;

/// Normal draws over all unknowns.
pub(super) struct Plain<'a> {
    density: &'a Density,
    directions: Vec<Vec<f64>>,
}

impl<'a> Plain<'a> {
    pub(super) fn new(density: &'a Density) -> Option<Self> {
        Some(Self {
            directions: coordinates(&density.precision)?,
            density,
        })
    }

    /// Returns the unknowns of robots, \[count\], and the share of draws that can exist; `None` if they are too few.
    pub(super) fn draw(&self, count: usize, seed: u64) -> Option<(Vec<Vec<f64>>, f64)> {
        let inside = (0..TRIALS).into_par_iter().filter(|trial| {
            let draw = self.one(&mut stream(seed, u64::MAX - trial));
            self.can_exist(&draw)
        });
        let share = inside.count() as f64 / TRIALS as f64;
        if share < LEAST_SHARE {
            return None;
        }
        let robots = (0..count as u64).into_par_iter().map(|robot| {
            let mut rng = stream(seed, robot);
            (0..MOST_DRAWS)
                .map(|_| self.one(&mut rng))
                .find(|draw| self.can_exist(draw))
        });
        Some((robots.collect::<Option<_>>()?, share))
    }

    fn one(&self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let mut draw = self.density.mean.clone();
        for direction in &self.directions {
            let z: f64 = rng.sample(StandardNormal);
            for (value, by) in draw.iter_mut().zip(direction) {
                *value += z * by;
            }
        }
        draw
    }

    fn can_exist(&self, x: &[f64]) -> bool {
        let is_positive = |block: &Block| block.inverse(x).is_some();
        self.density.blocks.iter().all(is_positive)
    }
}

/// Returns one of many independent streams of random numbers of a seed.
pub(super) fn stream(seed: u64, index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(index);
    rng
}
