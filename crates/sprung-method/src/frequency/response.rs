//! The frequency response of a log at given frequencies, by local polynomials.

use faer::c64;

use super::spectra::Spectra;
use super::weighted::Regression;

/// Degree of the polynomials.
const DEGREE: usize = 2;

/// Rows of a local regression beyond its unknowns: at least, and per unknown.
const MORE_ROWS: usize = 6;
const MORE_ROWS_PER_UNKNOWN: f64 = 0.5;

/// The response of one position to one torque at a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    /// Position per torque, rad/(N·m) (m/N).
    pub(super) value: c64,
    /// Standard error of the complex value.
    pub(super) error: f64,
    /// Part of the position's power that all torques explain, 0 to 1.
    pub(super) coherence: f64,
}

/// Estimates the response of a joint's motor and link to the torque of its own motor; the torques of
/// the other motors are further inputs. `None` if the torques do not excite the robot independently
/// about this line.
///
/// - `line`: index of the line.
///
/// # Source
///
/// Pintelon and Schoukens, "System Identification: A Frequency Domain Approach", 2nd edition, 2012,
/// Section 7.2: the local polynomial method.
#[must_use]
pub(super) fn estimates(spectra: &Spectra, joint: usize, line: usize) -> Option<[Estimate; 2]> {
    let n = spectra.torque.len();
    let transient = usize::from(spectra.periods.is_none());
    let unknowns = (n + transient) * (DEGREE + 1);
    let more = MORE_ROWS.max((MORE_ROWS_PER_UNKNOWN * unknowns as f64) as usize);
    let rows = unknowns + more;
    let lines = spectra.hz.len();
    if lines < rows {
        return None;
    }
    let from = line.saturating_sub(rows / 2).min(lines - rows);
    let mut regressors = Vec::with_capacity(rows * unknowns);
    for k in from..from + rows {
        let r = (k as f64 - line as f64) / rows as f64;
        let powers = [1.0, r, r * r];
        for torque in &spectra.torque {
            regressors.extend(powers.map(|power| torque[k] * power));
        }
        if transient > 0 {
            regressors.extend(powers.map(|power| c64::new(power, 0.0)));
        }
    }
    let regression = Regression {
        unknowns,
        regressors,
        weights: vec![1.0; rows],
    };
    let factored = regression.factored()?;
    let freedom = (rows - unknowns) as f64;
    let estimate = |position: &Vec<c64>| {
        let output = &position[from..from + rows];
        let solution = factored.solve(output);
        let unknown = joint * (DEGREE + 1);
        let noise: f64 = solution.residuals.iter().map(c64::norm_sqr).sum::<f64>() / freedom;
        let power: f64 = output.iter().map(c64::norm_sqr).sum::<f64>() / rows as f64;
        Estimate {
            value: solution.values[unknown],
            error: (factored.variance(unknown, &solution.residuals)).sqrt(),
            coherence: (1.0 - noise / power).clamp(0.0, 1.0),
        }
    };
    Some([&spectra.motor[joint], &spectra.link[joint]].map(estimate))
}
