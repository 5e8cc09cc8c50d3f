//! Confidence intervals of parameters of robots that can exist: profile likelihood.

use faer::Mat;
use faer::linalg::solvers::Solve;
use rayon::prelude::*;

use super::information::inverse;
use super::robots::{Robots, must_be_positive};
use super::search::{Search, product, squared_distance};
use crate::estimate::statistics::{MAX_ROUNDS, NEGLIGIBLE_SHARE, SMALL_SHARE};
use crate::model::Theta;

/// μ at which the searches for the ends start and end. The function is half a squared distance in standard errors, so
/// the first one is far from every boundary, and the last one moves an end by a hundredth of a standard error.
const PATH: [f64; 2] = [0.3, 3e-4];

/// Largest factor of a multiplier from one search to the next.
const LARGEST_FACTOR: f64 = 5.0;

/// Parameters by equations without constraints, and by the robots that can exist.
pub(in crate::estimate) struct Estimated<'a> {
    /// Information of the equations that both minimise, \[p × p\].
    pub(in crate::estimate) information: &'a Mat<f64>,
    /// Parameters without constraints, \[p\].
    pub(in crate::estimate) unconstrained: &'a [f64],
    /// Parameters of a robot that can exist, \[p\].
    pub(in crate::estimate) theta: &'a [f64],
    /// Standard errors without constraints, \[p\]; they contain more than the information of the
    /// equations.
    pub(in crate::estimate) errors: &'a [f64],
}

/// Interval of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::estimate) struct Limits {
    pub(in crate::estimate) ends: [f64; 2],
    /// Whether the lower end is the bound of the parameter itself, zero.
    pub(in crate::estimate) is_one_sided: bool,
}

impl Limits {
    /// Returns half the interval over its quantile.
    pub(in crate::estimate) fn standard_error(&self, quantile: f64) -> f64 {
        (self.ends[1] - self.ends[0]) / (2.0 * quantile)
    }
}

impl Robots<'_> {
    /// Returns the 95 % interval of each of some parameters; `None` for a parameter without one.
    ///
    /// An interval contains the values of all robots that can exist whose squared distance from the equations exceeds
    /// the least one by at most the square of `width`. Where no constraint is active, its ends are the value minus and
    /// plus `width` standard errors. All parameters have this one rule.
    ///
    /// - `known`: parameters with a standard error, by index.
    /// - `width`: half the width of an interval without constraints, in standard errors.
    ///
    /// # Source
    ///
    /// Meeker and Escobar, "Teaching about approximate confidence regions based on maximum likelihood estimation", The
    /// American Statistician, 1995, for intervals by profile likelihood.
    pub(in crate::estimate) fn limits(
        &self,
        estimated: &Estimated<'_>,
        known: &[usize],
        width: f64,
    ) -> Option<Vec<Option<Limits>>> {
        let gradient = product(estimated.information, estimated.unconstrained);
        let search = self.search(estimated.information, &gradient, estimated.theta);
        let rows = search.program.rows().max(1) as f64;
        let mut middle = search
            .program
            .minimise(&search.start, rows * PATH[0])
            .ok()?;
        let mut best = middle.clone();
        search.program.follow(&mut best, PATH).ok()?;
        let part = Mat::from_fn(known.len(), known.len(), |i, j| {
            estimated.information[(known[i], known[j])]
        });
        let covariance = inverse(&part)?;
        let distance =
            |theta: &[f64]| squared_distance(estimated.information, theta, estimated.unconstrained);
        let least = distance(&self.theta(&best)).max(distance(estimated.theta));
        search.program.follow(&mut middle, [PATH[0]; 2]).ok()?;
        let profile = Profile {
            robots: self,
            estimated,
            search: &search,
            middle,
            least,
            rays: Rays::new(&search, &best),
            best,
        };
        let limits = (known.par_iter().enumerate()).map(|(at, &index)| {
            let of_joint = self.model.parameters()[index].joint;
            if of_joint.is_some_and(|(kind, _)| kind.is_of_curve()) {
                return Some(cut_at_zero(
                    estimated.theta[index],
                    width * estimated.errors[index],
                ));
            }
            let by_equations = covariance[(at, at)].sqrt();
            profile.limits(
                index,
                by_equations,
                width * estimated.errors[index] / by_equations,
            )
        });
        Some(limits.collect())
    }
}

/// Returns the interval of a coefficient of a curve. It means little by itself, so no search finds its ends.
fn cut_at_zero(value: f64, half: f64) -> Limits {
    Limits {
        ends: [(value - half).max(0.0), value.max(0.0) + half],
        is_one_sided: value <= half,
    }
}

/// The profile likelihood of the parameters.
struct Profile<'a> {
    robots: &'a Robots<'a>,
    estimated: &'a Estimated<'a>,
    search: &'a Search,
    /// Unknowns at the beginning of the central path.
    middle: Vec<f64>,
    /// Unknowns of the best robot.
    best: Vec<f64>,
    /// Squared distance of the best robot from the equations.
    least: f64,
    rays: Option<Rays>,
}

impl Profile<'_> {
    /// - `error`: standard error of the parameter by the equations; `width`: half the width of its interval without
    ///   constraints in such standard errors.
    fn limits(&self, index: usize, error: f64, width: f64) -> Option<Limits> {
        let value = self.estimated.theta[index];
        let is_free = self.least < SMALL_SHARE * width * width;
        let ends = [-1.0, 1.0].map(|side| {
            if is_free && self.is_inside(index, side * width) {
                Some((value + side * width * error, false))
            } else {
                self.end(index, error, side * width)
            }
        });
        let [Some((low, low_is_bound)), Some((high, _))] = ends else {
            return None;
        };
        let (low, high) = (low.min(value), high.max(value));
        let is_positive = must_be_positive(&self.robots.model.parameters()[index]);
        let is_one_sided = is_positive && (low_is_bound || low < NEGLIGIBLE_SHARE * (high - low));
        Some(Limits {
            ends: [if is_one_sided { 0.0 } else { low }, high],
            is_one_sided,
        })
    }

    /// Returns whether the end of an interval without constraints is a robot that can exist.
    ///
    /// - `width`: standard errors from the value.
    fn is_inside(&self, index: usize, width: f64) -> bool {
        let ray = self
            .rays
            .as_ref()
            .and_then(|rays| rays.towards(self.robots, index));
        ray.is_some_and(|ray| {
            let end: Vec<f64> = (self.best.iter().zip(&ray))
                .map(|(x, by)| x + width * by)
                .collect();
            self.search.program.is_inside(&end)
        })
    }

    /// Returns the end of an interval, and whether the end is a bound: the robot that minimises half the squared
    /// distance minus a multiple of the parameter, with the multiple at which the distance is at its limit.
    ///
    /// - `width`: half the width of the interval, in standard errors; negative for the lower end.
    fn end(&self, index: usize, error: f64, width: f64) -> Option<(f64, bool)> {
        let mut multiplier = width / error;
        let limit = self.least + width * width;
        let mut before = (f64::NAN, 0);
        let mut found = None;
        for _ in 0..MAX_ROUNDS {
            let theta = self.at(index, multiplier)?;
            let value = theta[index];
            let squares = squared_distance(
                self.estimated.information,
                &theta,
                self.estimated.unconstrained,
            );
            let reached = (squares - self.least).max(0.0).sqrt() / width.abs();
            if (value - before.0).abs() < NEGLIGIBLE_SHARE * error {
                before.1 += 1;
            }
            if reached < 1.0 && before.1 > 1 {
                return Some((value, true));
            }
            before.0 = value;
            // At the optimum half the square grows by the multiplier times the parameter.
            let rest = (limit - squares) / (2.0 * multiplier);
            found = Some((value + rest.clamp(-0.5 * error, 0.5 * error), false));
            if (reached - 1.0).abs() < 3.0 * SMALL_SHARE {
                break;
            }
            let factor = reached.max(LARGEST_FACTOR.recip()).recip();
            multiplier *= factor.max(LARGEST_FACTOR.recip());
        }
        found
    }

    /// Returns the robot that minimises half the squared distance minus a multiple of a parameter, \[p\].
    fn at(&self, index: usize, multiplier: f64) -> Option<Theta> {
        let mut program = self.search.program.clone();
        for (entry, column) in program.linear.iter_mut().zip(&self.robots.columns) {
            *entry += multiplier * column[index];
        }
        let mut x = self.middle.clone();
        program.follow(&mut x, PATH).ok()?;
        Some(self.robots.theta(&x))
    }
}

/// Directions in which single parameters change without constraints.
struct Rays {
    factor: faer::linalg::solvers::Llt<f64>,
    scale: Vec<f64>,
}

impl Rays {
    fn new(search: &Search, at: &[f64]) -> Option<Self> {
        let n = at.len();
        let hessian = search.program.hessian(at)?;
        let scale: Vec<f64> = (0..n)
            .map(|i| hessian[i * (n + 1)].sqrt().recip())
            .collect();
        let scaled = Mat::from_fn(n, n, |i, j| hessian[i * n + j] * scale[i] * scale[j]);
        let factor = scaled.llt(faer::Side::Lower).ok()?;
        Some(Self { factor, scale })
    }

    /// Returns the change of the unknowns by which a parameter grows by a standard error and the distance least.
    fn towards(&self, robots: &Robots<'_>, index: usize) -> Option<Vec<f64>> {
        let n = self.scale.len();
        let right = Mat::from_fn(n, 1, |i, _| self.scale[i] * robots.columns[i][index]);
        let moved = self.factor.solve(&right);
        let variance: f64 = (0..n).map(|i| moved[(i, 0)] * right[(i, 0)]).sum();
        let error = variance.sqrt();
        (error > 0.0 && error.is_finite()).then(|| {
            (0..n)
                .map(|i| self.scale[i] * moved[(i, 0)] / error)
                .collect()
        })
    }
}
