//! Distribution of sizes, in bounded memory.

/// Biased exponent of the smallest size with its own bin. Smaller sizes share the first bin.
const LOWEST_EXPONENT: u64 = 1023 - 80;

/// Number of bins: four per octave over 160 octaves.
const SIZE_BINS: usize = 640;

/// Counts of sizes in bins a quarter of an octave wide. Zeros are counted separately.
#[derive(Clone, Debug)]
pub struct Sizes {
    counts: Vec<u64>,
    zeros: u64,
    total: u64,
}

impl Default for Sizes {
    fn default() -> Self {
        Self {
            counts: vec![0; SIZE_BINS],
            zeros: 0,
            total: 0,
        }
    }
}

impl Sizes {
    /// Adds a nonnegative size.
    pub(crate) fn take(&mut self, size: f64) {
        if size > 0.0 {
            self.counts[bin(size)] += 1;
            self.total += 1;
        } else {
            self.zeros += 1;
        }
    }

    /// Returns the number of nonzero sizes.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.total
    }

    /// Returns the number of zeros.
    #[must_use]
    pub fn zeros(&self) -> u64 {
        self.zeros
    }

    /// Returns the number of sizes in the bins above the bin of `size`.
    #[must_use]
    pub fn above(&self, size: f64) -> u64 {
        self.counts[bin(size) + 1..].iter().sum()
    }

    /// Returns the quantile `part` of the nonzero sizes, as the upper end of its bin; zero if all
    /// sizes are zero.
    #[must_use]
    pub fn quantile(&self, part: f64) -> f64 {
        let wanted = (part * self.total as f64).ceil() as u64;
        let mut below = 0;
        for (at, count) in self.counts.iter().enumerate() {
            below += count;
            if below >= wanted && *count > 0 {
                return upper_end(at);
            }
        }
        0.0
    }
}

/// Returns the bin of a size: its exponent and the first two bits of its fraction.
fn bin(size: f64) -> usize {
    let place = (size.abs().to_bits() >> 50).saturating_sub(LOWEST_EXPONENT << 2);
    (place as usize).min(SIZE_BINS - 1)
}

fn upper_end(bin: usize) -> f64 {
    f64::from_bits((bin as u64 + 1 + (LOWEST_EXPONENT << 2)) << 50)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_sizes() {
        let mut sizes = Sizes::default();
        for k in 1..=1000 {
            sizes.take(f64::from(k) * 1e-5);
            sizes.take(0.0);
        }
        for part in [0.1, 0.5, 0.99] {
            let found = sizes.quantile(part) / (part * 1e-2);
            // A quantile is the upper end of its bin, and an upper end is at most 1.25 times the
            // lower end; the margin is 1 %.
            assert!((0.99..1.26).contains(&found), "{part}: {found}");
        }
        assert_eq!((sizes.count(), sizes.zeros()), (1000, 1000));
        // 300 sizes are above 0.007. The bin of 0.007 ends at 2^-7 and contains 81 of them, so 219
        // remain.
        assert!((195..=310).contains(&sizes.above(0.7e-2)));
        sizes.take(f64::MAX);
        sizes.take(5e-324);
        assert_eq!(sizes.above(1e10), 1);
    }
}
