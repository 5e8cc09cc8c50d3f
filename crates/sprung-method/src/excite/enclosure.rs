//! Numbers that enclose all values of a function of time on an interval, and all values of its derivative.
//!
//! Interval arithmetic with the mean value form: the width of an enclosure falls with the square of the interval. Errors
//! of rounding, some 1e-13 of a value, are not enclosed; the margins of a design are far larger.

use std::f64::consts::{PI, TAU};
use std::ops::{Add, Mul, Neg, Sub};

use sprung_core::scalar::Scalar;

/// Slope of a jump.
const STEEP: f64 = 1e150;

/// The values of a function on a time interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Enclosure {
    /// The value in the middle of the interval.
    middle: f64,
    /// All values.
    range: [f64; 2],
    /// All derivatives by time.
    rate: [f64; 2],
    /// Half the length of the time interval; zero for constants.
    half: f64,
}

impl Enclosure {
    /// - `middle`: value in the middle; `rate`: all derivatives by time; `half`: half the length of the interval, s.
    pub(super) fn new(middle: f64, rate: [f64; 2], half: f64) -> Self {
        let enclosure = Self {
            middle,
            range: [f64::NEG_INFINITY, f64::INFINITY],
            rate,
            half,
        };
        enclosure.tightened()
    }

    /// Returns the largest absolute value.
    pub(super) fn largest(&self) -> f64 {
        self.range[0].abs().max(self.range[1].abs())
    }

    /// Returns all values.
    pub(super) fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Returns the largest absolute derivative.
    pub(super) fn fastest(&self) -> f64 {
        self.rate[0].abs().max(self.rate[1].abs())
    }

    /// Returns the value in the middle.
    pub(super) fn middle(&self) -> f64 {
        self.middle
    }

    /// Uses the mean value theorem.
    fn tightened(mut self) -> Self {
        let most = self.fastest() * self.half;
        let by_rate = if self.rate[0] >= 0.0 || self.rate[1] <= 0.0 {
            let ends = [self.rate[0] * self.half, self.rate[1] * self.half];
            let far = ends[0].abs().max(ends[1].abs());
            [self.middle - far, self.middle + far]
        } else {
            [self.middle - most, self.middle + most]
        };
        self.range = [self.range[0].max(by_rate[0]), self.range[1].min(by_rate[1])];
        self
    }

    /// Returns a function of the values: monotone on the range, with this slope.
    fn monotone(self, f: impl Fn(f64) -> f64, slope: [f64; 2]) -> Self {
        let ends = self.range.map(&f);
        Self {
            middle: f(self.middle),
            range: [ends[0].min(ends[1]), ends[0].max(ends[1])],
            rate: times(self.rate, slope),
            half: self.half,
        }
        .tightened()
    }
}

fn times(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let all = [a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]];
    [
        all.into_iter().fold(f64::INFINITY, f64::min),
        all.into_iter().fold(f64::NEG_INFINITY, f64::max),
    ]
}

fn plus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Returns all sines on a range.
fn sines([low, high]: [f64; 2]) -> [f64; 2] {
    if high - low >= TAU {
        return [-1.0, 1.0];
    }
    // Whether the range holds an angle of this remainder.
    let holds = |angle: f64| angle + TAU * ((low - angle) / TAU).ceil() <= high;
    let ends = [low.sin(), high.sin()];
    [
        if holds(-0.5 * PI) {
            -1.0
        } else {
            ends[0].min(ends[1])
        },
        if holds(0.5 * PI) {
            1.0
        } else {
            ends[0].max(ends[1])
        },
    ]
}

impl Add for Enclosure {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            middle: self.middle + other.middle,
            range: plus(self.range, other.range),
            rate: plus(self.rate, other.rate),
            half: self.half.max(other.half),
        }
        .tightened()
    }
}

impl Neg for Enclosure {
    type Output = Self;

    fn neg(self) -> Self {
        let turned = |[low, high]: [f64; 2]| [-high, -low];
        Self {
            middle: -self.middle,
            range: turned(self.range),
            rate: turned(self.rate),
            half: self.half,
        }
    }
}

impl Sub for Enclosure {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Enclosure {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            middle: self.middle * other.middle,
            range: times(self.range, other.range),
            rate: plus(times(self.rate, other.range), times(self.range, other.rate)),
            half: self.half.max(other.half),
        }
        .tightened()
    }
}

impl Mul<f64> for Enclosure {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            middle: self.middle * factor,
            range: times(self.range, [factor; 2]),
            rate: times(self.rate, [factor; 2]),
            half: self.half,
        }
    }
}

impl Scalar for Enclosure {
    const ZERO: Self = Self {
        middle: 0.0,
        range: [0.0; 2],
        rate: [0.0; 2],
        half: 0.0,
    };

    fn constant(value: f64) -> Self {
        Self {
            middle: value,
            range: [value; 2],
            ..Self::ZERO
        }
    }

    fn value(self) -> f64 {
        self.middle
    }

    fn abs(self) -> Self {
        let [low, high] = self.range;
        if low >= 0.0 {
            self
        } else if high <= 0.0 {
            -self
        } else {
            let rate = self.fastest();
            Self {
                middle: self.middle.abs(),
                range: [0.0, self.largest()],
                rate: [-rate, rate],
                half: self.half,
            }
        }
    }

    fn is_forward(self) -> Self {
        let [low, high] = self.range;
        if low >= 0.0 {
            Self::constant(1.0)
        } else if high < 0.0 {
            Self::ZERO
        } else {
            Self {
                middle: if self.middle >= 0.0 { 1.0 } else { 0.0 },
                range: [0.0, 1.0],
                rate: [-STEEP, STEEP],
                half: self.half,
            }
        }
    }

    fn sin_cos(self) -> (Self, Self) {
        let sin = sines(self.range);
        let cos = sines(self.range.map(|angle| angle + 0.5 * PI));
        let (of_middle, along) = self.middle.sin_cos();
        let of = |middle, range, slope| {
            Self {
                middle,
                range,
                rate: times(self.rate, slope),
                half: self.half,
            }
            .tightened()
        };
        let minus = [-sin[1], -sin[0]];
        (of(of_middle, sin, cos), of(along, cos, minus))
    }

    fn exp(self) -> Self {
        self.monotone(f64::exp, self.range.map(f64::exp))
    }

    fn tanh(self) -> Self {
        let [low, high] = self.range;
        let slope = |x: f64| 1.0 - x.tanh().powi(2);
        let steepest = if low <= 0.0 && high >= 0.0 {
            1.0
        } else {
            slope(low).max(slope(high))
        };
        self.monotone(f64::tanh, [slope(low).min(slope(high)), steepest])
    }

    fn ln(self) -> Self {
        let [low, high] = self.range;
        self.monotone(f64::ln, [1.0 / high, 1.0 / low])
    }

    fn recip(self) -> Self {
        let [low, high] = self.range;
        if low <= 0.0 && high >= 0.0 {
            return Self {
                middle: 1.0 / self.middle,
                range: [f64::NEG_INFINITY, f64::INFINITY],
                rate: [-STEEP, STEEP],
                half: self.half,
            };
        }
        let slopes = self.range.map(|x| -1.0 / (x * x));
        let slope = [slopes[0].min(slopes[1]), slopes[0].max(slopes[1])];
        self.monotone(|x| 1.0 / x, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that an enclosure holds all values of a function, and that it is not much wider.
    fn check(f: impl Fn(Enclosure) -> Enclosure, g: impl Fn(f64) -> f64, width: f64) {
        // x(t) = 0.3 + t over ±half.
        for half in [0.4, 0.01] {
            let found = f(Enclosure::new(0.3, [1.0, 1.0], half));
            let values = (-50..=50).map(|k| g(0.3 + half * f64::from(k) / 50.0));
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for value in values {
                least = least.min(value);
                most = most.max(value);
            }
            let [low, high] = found.range();
            assert!(
                low <= least + 1e-12 && most <= high + 1e-12,
                "{found:?} {least} {most}"
            );
            assert!(
                high - low <= (most - least) + width * half,
                "{found:?} {least} {most}"
            );
        }
    }

    #[test]
    fn enclosures_hold_all_values() {
        check(|x| x.sin_cos().0, f64::sin, 0.1);
        check(|x| x.sin_cos().1, f64::cos, 0.3);
        check(|x| (x * 20.0).tanh(), |x| (20.0 * x).tanh(), 1.0);
        check(|x| x * x - x, |x| x * x - x, 3.0);
        check(|x| x.exp() * x, |x| x.exp() * x, 2.0);
        check(
            |x| (x + Enclosure::constant(2.0)).recip(),
            |x| 1.0 / (x + 2.0),
            0.1,
        );
        check(
            |x| (x - Enclosure::constant(0.3)).abs(),
            |x| (x - 0.3).abs(),
            1.0,
        );
        check(
            |x| (x - Enclosure::constant(0.3)).is_forward(),
            |x| if x >= 0.3 { 1.0 } else { 0.0 },
            0.0,
        );
    }

    #[test]
    fn a_sine_over_its_top_reaches_one() {
        let top = Enclosure::new(1.5, [1.0, 1.0], 0.2).sin_cos().0;
        assert!((top.range()[1] - 1.0).abs() < 1e-12, "{top:?}");
        let [low, high] = sines([0.0, 7.0]);
        assert!(low <= -1.0 && high >= 1.0);
    }
}
