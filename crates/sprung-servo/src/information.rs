//! Parameters that the logs of a servo determine, before the fit.

use sprung_core::servo::ServoParameter;

use super::bench::Bench;
use super::error::ServoError;
use super::findings::of_scale;
use super::fit::sums;
use super::matrix::inverse;
use super::record::Records;
use super::result::ServoExpectation;
use super::start::start;
use super::window::{Setting, windows};
use crate::finding::Finding;

/// Length of the windows, s.
const WINDOW_S: f64 = 0.5;

/// Returns the parameters that the logs can determine, with their smallest possible errors about the
/// first values, and findings.
///
/// # Errors
///
/// [`ServoError`] if the targets do not drive the positions.
pub fn expect(
    bench: &Bench,
    records: &Records,
) -> Result<(Vec<ServoExpectation>, Vec<Finding>), ServoError> {
    let values = start(bench, &records.all).ok_or(ServoError::NotDriven)?;
    let setting = Setting {
        bench,
        records: &records.all,
        step_s: 1e-3,
        free_start: true,
    };
    let unknown = bench.unknown();
    let n = unknown.len();
    // The first values do not follow every window, so all windows count fully.
    let normals: Vec<_> = (windows(&records.all, WINDOW_S).iter())
        .map(|window| (window.normal(&values, &setting), 1.0))
        .collect();
    let (information, _) = sums(&normals, &unknown);
    let covariance = inverse(&information, n);
    let expected = (ServoParameter::ALL.into_iter().enumerate()).map(|(i, parameter)| {
        let (name, unit) = bench.name(parameter);
        let is_logarithm = parameter == ServoParameter::LogStribeckVelocity;
        let first = if is_logarithm {
            values[i].exp()
        } else {
            values[i]
        };
        // The error of a logarithm is relative.
        let size = if is_logarithm { first } else { 1.0 };
        let error = (unknown.iter().position(|other| *other == i))
            .zip(covariance.as_ref())
            .map(|(k, covariance)| size * covariance[k * n + k].max(0.0).sqrt());
        ServoExpectation {
            name: format!("{}.{name}", bench.joint),
            unit: unit.to_owned(),
            first,
            least_error: error.filter(|error| error.is_finite()),
            fixed: bench.known(parameter).is_some(),
        }
    });
    Ok((expected.collect(), of_scale(bench).into_iter().collect()))
}
