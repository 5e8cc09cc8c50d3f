//! Number types of the physics: plain values, Taylor series in time, and values with partial
//! derivatives.
//!
//! A formula is written once over [`Scalar`]. It gives its value with `f64`, its exact time
//! derivatives with [`Jet`], and its exact partial derivatives with [`Dual`].

use core::ops::{Add, Mul, Neg, Sub};

/// A type of number with which the physics can be evaluated.
pub trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
{
    /// The number zero.
    const ZERO: Self;

    /// Returns a number whose derivatives are zero.
    #[must_use]
    fn constant(value: f64) -> Self;

    /// Returns the value, without derivatives.
    #[must_use]
    fn value(self) -> f64;

    /// Returns the absolute value.
    #[must_use]
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }

    /// Returns 1 if the value is zero or positive, otherwise 0.
    #[must_use]
    fn is_forward(self) -> Self {
        Self::constant(if self.value() >= 0.0 { 1.0 } else { 0.0 })
    }

    /// Returns the quotient by a constant.
    #[must_use]
    fn over(self, divisor: f64) -> Self {
        self * (1.0 / divisor)
    }

    /// Returns the sine and the cosine.
    #[must_use]
    fn sin_cos(self) -> (Self, Self);

    /// Returns the exponential.
    #[must_use]
    fn exp(self) -> Self;

    /// Returns the hyperbolic tangent.
    #[must_use]
    fn tanh(self) -> Self;

    /// Returns the natural logarithm.
    #[must_use]
    fn ln(self) -> Self;

    /// Returns the reciprocal.
    #[must_use]
    fn recip(self) -> Self;
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;

    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn over(self, divisor: f64) -> Self {
        self / divisor
    }

    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }

    fn exp(self) -> Self {
        libm::exp(self)
    }

    fn tanh(self) -> Self {
        libm::tanh(self)
    }

    fn ln(self) -> Self {
        libm::log(self)
    }

    fn recip(self) -> Self {
        1.0 / self
    }
}

/// A Taylor series in time, truncated after `N` coefficients.
///
/// `coefficients[k]` is the k-th time derivative divided by `k!`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<const N: usize, S = f64> {
    /// Taylor coefficients, lowest order first.
    pub coefficients: [S; N],
}

impl<const N: usize, S: Scalar> Jet<N, S> {
    /// Returns the series of a signal from its value and its time derivatives, lowest order first.
    #[must_use]
    pub fn from_derivatives(derivatives: [S; N]) -> Self {
        let mut coefficients = derivatives;
        let mut factorial = 1.0;
        for (k, c) in coefficients.iter_mut().enumerate().skip(1) {
            factorial *= k as f64;
            *c = c.over(factorial);
        }
        Self { coefficients }
    }

    /// Returns the `order`-th time derivative; `order` must be below `N`.
    #[must_use]
    pub fn derivative(&self, order: usize) -> S {
        let factorial: f64 = (1..=order).map(|k| k as f64).product();
        self.coefficients[order] * factorial
    }

    /// Returns the time derivative, whose last coefficient is unknown and set to zero.
    #[must_use]
    pub fn rate(&self) -> Self {
        let mut coefficients = [S::ZERO; N];
        for (k, (rate, c)) in (coefficients.iter_mut())
            .zip(self.coefficients.iter().skip(1))
            .enumerate()
        {
            *rate = *c * (k + 1) as f64;
        }
        Self { coefficients }
    }
}

impl<const N: usize, S: Scalar> Add for Jet<N, S> {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        for (a, b) in self.coefficients.iter_mut().zip(other.coefficients) {
            *a = *a + b;
        }
        self
    }
}

impl<const N: usize, S: Scalar> Sub for Jet<N, S> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + (-other)
    }
}

impl<const N: usize, S: Scalar> Neg for Jet<N, S> {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize, S: Scalar> Mul<f64> for Jet<N, S> {
    type Output = Self;

    fn mul(mut self, factor: f64) -> Self {
        for a in &mut self.coefficients {
            *a = *a * factor;
        }
        self
    }
}

impl<const N: usize, S: Scalar> Mul for Jet<N, S> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let mut coefficients = [S::ZERO; N];
        for i in 0..N {
            for j in 0..N - i {
                coefficients[i + j] =
                    coefficients[i + j] + self.coefficients[i] * other.coefficients[j];
            }
        }
        Self { coefficients }
    }
}

impl<const N: usize, S: Scalar> Scalar for Jet<N, S> {
    const ZERO: Self = Self {
        coefficients: [S::ZERO; N],
    };

    fn constant(value: f64) -> Self {
        let mut coefficients = [S::ZERO; N];
        coefficients[0] = S::constant(value);
        Self { coefficients }
    }

    fn value(self) -> f64 {
        self.coefficients[0].value()
    }

    fn abs(self) -> Self {
        // The numbers of a traced function have no value to compare.
        let sign = self.coefficients[0].is_forward() * 2.0 - S::constant(1.0);
        Self {
            coefficients: self.coefficients.map(|c| c * sign),
        }
    }

    fn is_forward(self) -> Self {
        let mut forward = Self::ZERO;
        forward.coefficients[0] = self.coefficients[0].is_forward();
        forward
    }

    fn over(mut self, divisor: f64) -> Self {
        for a in &mut self.coefficients {
            *a = a.over(divisor);
        }
        self
    }

    fn sin_cos(self) -> (Self, Self) {
        let mut sin = [S::ZERO; N];
        let mut cos = [S::ZERO; N];
        (sin[0], cos[0]) = self.coefficients[0].sin_cos();
        for k in 1..N {
            for i in 1..=k {
                let rate = (self.coefficients[i] * i as f64).over(k as f64);
                sin[k] = sin[k] + rate * cos[k - i];
                cos[k] = cos[k] - rate * sin[k - i];
            }
        }
        (Self { coefficients: sin }, Self { coefficients: cos })
    }

    fn exp(self) -> Self {
        let mut exp = [S::ZERO; N];
        exp[0] = self.coefficients[0].exp();
        for k in 1..N {
            for i in 1..=k {
                let part = self.coefficients[i] * i as f64 * exp[k - i];
                exp[k] = exp[k] + part.over(k as f64);
            }
        }
        Self { coefficients: exp }
    }

    fn tanh(self) -> Self {
        let mut tanh = Self::ZERO;
        tanh.coefficients[0] = self.coefficients[0].tanh();
        for k in 1..N {
            // The derivative of tanh is 1 - tanh²; the coefficients below order k are known.
            let slope = Self::constant(1.0) - tanh * tanh;
            for i in 1..=k {
                let rate = (self.coefficients[i] * i as f64).over(k as f64);
                tanh.coefficients[k] = tanh.coefficients[k] + rate * slope.coefficients[k - i];
            }
        }
        tanh
    }

    fn ln(self) -> Self {
        let x = self.coefficients;
        let inverse = x[0].recip();
        let mut ln = [S::ZERO; N];
        ln[0] = x[0].ln();
        for k in 1..N {
            let known = (1..k).fold(S::ZERO, |sum, i| sum + ln[i] * i as f64 * x[k - i]);
            ln[k] = (x[k] - known.over(k as f64)) * inverse;
        }
        Self { coefficients: ln }
    }

    fn recip(self) -> Self {
        let x = self.coefficients;
        let mut recip = [S::ZERO; N];
        recip[0] = x[0].recip();
        for k in 1..N {
            let known = (1..=k).fold(S::ZERO, |sum, i| sum + x[i] * recip[k - i]);
            recip[k] = -known * recip[0];
        }
        Self {
            coefficients: recip,
        }
    }
}

/// A value with its partial derivatives by `N` variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// Its partial derivatives.
    pub partials: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// Applies the chain rule to a function of `self` with a given value and slope.
    fn chain(self, value: f64, slope: f64) -> Self {
        Self {
            value,
            partials: self.partials.map(|p| p * slope),
        }
    }

    /// Returns the `i`-th variable with a given value.
    #[must_use]
    pub fn variable(value: f64, i: usize) -> Self {
        let mut dual = Self::constant(value);
        dual.partials[i] = 1.0;
        dual
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        self.value += other.value;
        for (a, b) in self.partials.iter_mut().zip(other.partials) {
            *a += b;
        }
        self
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;

    fn sub(mut self, other: Self) -> Self {
        self.value -= other.value;
        for (a, b) in self.partials.iter_mut().zip(other.partials) {
            *a -= b;
        }
        self
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;

    fn mul(mut self, factor: f64) -> Self {
        self.value *= factor;
        for a in &mut self.partials {
            *a *= factor;
        }
        self
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;

    fn mul(mut self, other: Self) -> Self {
        for (a, b) in self.partials.iter_mut().zip(other.partials) {
            *a = *a * other.value + b * self.value;
        }
        self.value *= other.value;
        self
    }
}

impl<const N: usize> Scalar for Dual<N> {
    const ZERO: Self = Self {
        value: 0.0,
        partials: [0.0; N],
    };

    fn constant(value: f64) -> Self {
        Self {
            value,
            partials: [0.0; N],
        }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = libm::sincos(self.value);
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    fn exp(self) -> Self {
        let exp = libm::exp(self.value);
        self.chain(exp, exp)
    }

    fn tanh(self) -> Self {
        let tanh = libm::tanh(self.value);
        self.chain(tanh, 1.0 - tanh * tanh)
    }

    fn ln(self) -> Self {
        self.chain(libm::log(self.value), 1.0 / self.value)
    }

    fn recip(self) -> Self {
        let recip = 1.0 / self.value;
        self.chain(recip, -recip * recip)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partial_derivatives_match_the_written_out_ones() {
        // f = x sin(y) - 2 x²: df/dx = sin y - 4 x, df/dy = x cos y.
        let (x, y) = (1.3, 0.4);
        let [dx, dy] = [Dual::<2>::variable(x, 0), Dual::variable(y, 1)];
        let f = dx * dy.sin_cos().0 - dx * dx * 2.0;
        let (s, c) = libm::sincos(y);
        for (found, expected) in [
            (f.value, x * s - 2.0 * x * x),
            (f.partials[0], s - 4.0 * x),
            (f.partials[1], x * c),
            ((-dy.sin_cos().1).partials[1], s),
        ] {
            assert!((found - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn functions_of_series_have_the_derivatives_of_their_differential_equations() {
        // y = exp(x): y' = y x'. y = tanh(x): y' = (1 - y²) x'.
        let x = Jet::<4>::from_derivatives([0.3, -0.7, 0.2, 1.1]);
        let x_rate = Jet::<3>::from_derivatives([-0.7, 0.2, 1.1]);
        let cut = |y: Jet<4>| Jet::from_derivatives([0, 1, 2].map(|k| y.derivative(k)));
        let rate = |y: Jet<4>| Jet::<3>::from_derivatives([1, 2, 3].map(|k| y.derivative(k)));
        let (exp, tanh) = (x.exp(), x.tanh());
        for zero in [exp.ln() - x, x * x.recip() - Jet::constant(1.0)] {
            for order in 0..4 {
                assert!(zero.derivative(order).abs() < 1e-13);
            }
        }
        let of_tanh = cut(tanh);
        for (found, expected) in [
            (rate(exp), cut(exp) * x_rate),
            (
                rate(tanh),
                (Jet::constant(1.0) - of_tanh * of_tanh) * x_rate,
            ),
        ] {
            for order in 0..3 {
                assert!((found.derivative(order) - expected.derivative(order)).abs() < 1e-13);
            }
        }
        assert!((exp.value() - libm::exp(0.3)).abs() < 1e-15);
        assert!((tanh.value() - libm::tanh(0.3)).abs() < 1e-15);
    }

    #[test]
    fn jet_of_sine_matches_its_derivatives() {
        // x(t) = sin(w t + a): x' = w cos, x'' = -w² sin, x''' = -w³ cos.
        let (w, a) = (3.0, 0.7);
        let (s, c) = libm::sincos(a);
        let phase = Jet::<4>::from_derivatives([a, w, 0.0, 0.0]);
        let (sin, _) = phase.sin_cos();
        for (order, expected) in [s, w * c, -w * w * s, -w * w * w * c].iter().enumerate() {
            assert!((sin.derivative(order) - expected).abs() < 1e-13);
        }
    }

    #[test]
    fn product_rule_holds() {
        let x = Jet::<3>::from_derivatives([2.0, 3.0, 5.0]);
        let y = Jet::<3>::from_derivatives([7.0, 11.0, 13.0]);
        let z = x * y;
        assert!((z.derivative(0) - 14.0).abs() < 1e-13);
        assert!((z.derivative(1) - (3.0 * 7.0 + 2.0 * 11.0)).abs() < 1e-13);
        assert!((z.derivative(2) - (5.0 * 7.0 + 2.0 * 3.0 * 11.0 + 2.0 * 13.0)).abs() < 1e-12);
    }
}
