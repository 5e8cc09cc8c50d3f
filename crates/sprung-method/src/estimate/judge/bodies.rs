//! Whether bodies with the estimated inertial parameters exist.

use crate::estimate::result::{EstimateResult, ParameterEstimate};
use crate::estimate::statistics::{CERTAIN_SIGMAS, SIGNIFICANT_SIGMAS};
use crate::finding::{Finding, Severity};
use crate::model::{Model, ModelError};

/// Reports inertial parameters of a tree that no bodies have. Base parameters may have any sign, but
/// the mass matrix must be positive definite, and every body needs a mass that is nowhere negative.
pub(super) fn impossible_bodies(model: &Model, result: &EstimateResult) -> Option<Finding> {
    model.tree()?;
    let theta: Vec<f64> = (result.parameters.iter())
        .map(|p| p.value)
        .collect::<Option<_>>()?;
    let errors: Vec<f64> = result.parameters.iter().map(error).collect();
    let distance = model.distance_from_bodies(&theta, &errors);
    match (model.check_inertias(&theta), distance) {
        (Err(error @ ModelError::MassMatrix { .. }), distance) => {
            let least = model.least_inertia(&theta, &errors);
            Some(mass_matrix(&error, distance, least))
        }
        (_, Some(distance)) if distance > CERTAIN_SIGMAS => Some(Finding::new(
            Severity::Warning,
            "impossible-bodies",
            format!(
                "no bodies have these inertial parameters: the nearest possible bodies are {distance:.0} \
                 standard errors away. Some values are wrong by more than their intervals show"
            ),
            "compare the values with nominal ones; record a motion with more frequencies and higher \
             accelerations; look for effects that the model lacks",
        )),
        _ => None,
    }
}

/// Returns the standard error of a parameter: zero if it is known, infinite if nothing tells its error.
fn error(parameter: &ParameterEstimate) -> f64 {
    if parameter.fixed {
        return 0.0;
    }
    parameter.standard_error.unwrap_or(f64::INFINITY)
}

/// Returns the finding about a mass matrix that is not positive. Its severity follows from the
/// distance of possible bodies: the errors of weakly excited parameters may contain them.
///
/// - `least`: least inertia and its standard error, kg·m² (kg).
fn mass_matrix(error: &ModelError, distance: Option<f64>, least: Option<(f64, f64)>) -> Finding {
    let severity = match distance {
        Some(distance) if distance <= SIGNIFICANT_SIGMAS => Severity::Info,
        Some(distance) if distance <= CERTAIN_SIGMAS => Severity::Warning,
        _ => Severity::Serious,
    };
    let value = match least {
        Some((value, error)) if error.is_finite() => {
            format!(". The least inertia is {value:.2e} ± {error:.1e} kg·m²")
        }
        Some((value, _)) => format!(
            ". The least inertia is {value:.2e} kg·m²; the log does not determine all parameters of this \
             inertia, so its error is unknown"
        ),
        None => String::new(),
    };
    let nearest = match distance {
        Some(distance) if distance <= SIGNIFICANT_SIGMAS => {
            format!(". Bodies within the errors are possible ({distance:.1} standard errors away)")
        }
        Some(distance) => {
            format!(". The nearest possible bodies are {distance:.1} standard errors away")
        }
        None => String::new(),
    };
    Finding::new(
        severity,
        "mass-matrix-not-positive",
        format!("no bodies have these inertial parameters: {error}{value}{nearest}"),
        "check the description of the kinematics, and signs and units of the columns; if the \
         parameters are weakly excited, record a log with higher accelerations. Until then the \
         model cannot be simulated at that pose",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_that_contain_possible_bodies_make_a_note() {
        let error = || ModelError::MassMatrix {
            values: "m".to_owned(),
            pose: String::new(),
        };
        let severity = |distance| mass_matrix(&error(), distance, None).severity;
        assert_eq!(severity(Some(2.9)), Severity::Info);
        assert_eq!(severity(Some(4.0)), Severity::Warning);
        assert_eq!(severity(Some(5.1)), Severity::Serious);
        assert_eq!(severity(None), Severity::Serious);
        let text = mass_matrix(&error(), Some(1.0), Some((-0.02, 0.03))).text;
        assert!(text.contains("-2.00e-2 ± 3.0e-2 kg·m²"), "{text}");
        let text = mass_matrix(&error(), Some(1.0), Some((-0.02, f64::INFINITY))).text;
        assert!(
            text.contains("its error is unknown") && !text.contains("inf"),
            "{text}"
        );
    }
}
