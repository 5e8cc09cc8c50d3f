use std::collections::BTreeMap;

use serde_json::{Value, json};
use sprung_core::linear::factor;

use super::*;
use crate::demo;
use crate::description::{self, Physical, no_files};
use crate::estimate::result::EstimateResult;
use crate::model::Model;

/// Two revolute joints with a gear, in three dimensions.
const TREE: &str = r#"
    format = 1
    [robot]
    dh_modified = [{ d_m = 0.3 }, { alpha_deg = -90.0, a_m = 0.2 }]
    gravity_m_per_s2 = [0.0, 0.0, -9.81]
    [[robot.joint]]
    name = "shoulder"
    transmission = "rigid"
    [[robot.joint]]
    name = "elbow"
    transmission = "rigid"
"#;

fn model_of(text: &str) -> Model {
    Model::new(&description::read("arm", text, &[], &mut no_files).unwrap()).unwrap()
}

/// An estimate of each parameter: value, and standard error without constraints.
/// The estimate of a parameter.
#[derive(Clone)]
struct Estimate {
    name: String,
    value: f64,
    error: Option<f64>,
}

/// The tree with an estimate, and the parameters of its bodies.
struct TreeEstimates {
    model: Model,
    estimates: Vec<Estimate>,
    bodies: Vec<Value>,
}

/// Returns a result with errors of which neighbours have a correlation.
fn result_of(estimates: &[Estimate], correlation: f64) -> EstimateResult {
    let parameters: Vec<Value> = (estimates.iter())
        .map(|Estimate { name, value, error }| {
            json!({
                "name": name, "symbol": "", "unit": "", "value": value.max(0.0), "unconstrained": value,
                "standard_error": error, "ci95": null, "nominal": null, "identifiable": error.is_some(),
            })
        })
        .collect();
    let known: Vec<(&String, f64)> = (estimates.iter())
        .filter_map(|estimate| Some((&estimate.name, estimate.error?)))
        .collect();
    let rows: Vec<Vec<f64>> = (0..known.len())
        .map(|i| {
            let entry = |j: usize| {
                let power = i32::try_from(i - j).unwrap();
                known[i].1 * known[j].1 * correlation.powi(power)
            };
            (0..=i).map(entry).collect()
        })
        .collect();
    let names: Vec<&String> = known.iter().map(|(name, _)| *name).collect();
    serde_json::from_value(json!({
        "estimator": "least-squares", "verdict": "good", "rank": 0, "condition_number": null,
        "condition_number_scaled": null, "parameters": parameters,
        "covariance": { "parameters": names, "values": rows },
        "residual_rms": {}, "relative_residual": {}, "warnings": [], "elapsed_s": 0.0,
    }))
    .unwrap()
}

/// Returns the demo's robot, and an estimate at its true values with relative errors.
fn demo_estimates(error: f64) -> (Model, Vec<Estimate>) {
    let model = model_of(demo::EXPERIMENT);
    let truth: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).unwrap();
    let theta = model.theta(&truth).unwrap();
    let estimates = (model.parameters().iter().zip(theta))
        .filter(|(parameter, _)| parameter.fixed.is_none())
        .map(|(parameter, value)| {
            let size = if value.abs() > 0.0 { value.abs() } else { 1.0 };
            Estimate {
                name: parameter.name.clone(),
                value,
                error: Some(error * size),
            }
        })
        .collect();
    (model, estimates)
}

/// Returns the tree, and an estimate at the values of two thick bodies.
fn tree_estimates(error: f64) -> TreeEstimates {
    let model = model_of(TREE);
    let body = [3.0, 0.3, 0.1, -0.2, 0.2, 0.01, 0.25, -0.02, 0.01, 0.15];
    let names = [
        "m", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz",
    ];
    let mut truth = BTreeMap::new();
    for link in ["link1", "link2"] {
        let pairs = names.iter().zip(body);
        truth.extend(pairs.map(|(name, value)| (format!("{link}.{name}"), value)));
    }
    for joint in ["shoulder", "elbow"] {
        for (name, value) in [
            ("rotor_inertia", 0.2),
            ("motor_viscous", 1.0),
            ("motor_coulomb", 2.0),
            ("motor_offset", 0.5),
        ] {
            truth.insert(format!("{joint}.{name}"), value);
        }
    }
    let known = |name: &String| {
        model
            .check_names(&BTreeMap::from([(name.clone(), 0.0)]))
            .is_ok()
    };
    truth.retain(|name, _| known(name));
    let theta = model.theta(&truth).unwrap();
    let estimates = (model.parameters().iter().zip(theta))
        .map(|(parameter, value)| Estimate {
            name: parameter.name.clone(),
            value,
            error: Some(error * value.abs().max(0.1)),
        })
        .collect();
    let links = model.links().unwrap();
    let bodies = (0..links.standard())
        .map(|index| {
            let name = links.name(index);
            json!({ "name": name, "unit": "", "value": truth[name], "nominal": null, "decided": "log" })
        })
        .collect();
    TreeEstimates {
        model,
        estimates,
        bodies,
    }
}

fn draw(model: &Model, result: &EstimateResult, count: usize) -> Samples {
    let posterior = Posterior::new(model, &Physical::default(), result).unwrap();
    posterior.sample(count, 7).unwrap()
}

/// Returns mean and standard deviation of a parameter.
fn moments(samples: &Samples, parameter: usize) -> [f64; 2] {
    let count = samples.theta.len() as f64;
    let values = || samples.theta.iter().map(|theta| theta[parameter]);
    let mean = values().sum::<f64>() / count;
    let variance = values().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
    [mean, variance.sqrt()]
}

/// Checks that the draws have the stated covariance within a share of the standard errors.
fn has_covariance(samples: &Samples, result: &EstimateResult, share: f64) {
    let stated = result.covariance.as_ref().unwrap();
    let count = samples.theta.len() as f64;
    let places: Vec<usize> = (stated.parameters.iter())
        .map(|name| {
            samples
                .parameters
                .iter()
                .position(|parameter| parameter == name)
                .unwrap()
        })
        .collect();
    let sample_moments: Vec<[f64; 2]> = places.iter().map(|at| moments(samples, *at)).collect();
    for (i, row) in stated.values.iter().enumerate() {
        let error = row[i].sqrt();
        assert!(
            (sample_moments[i][1] / error - 1.0).abs() < share,
            "{}: {} instead of {error}",
            stated.parameters[i],
            sample_moments[i][1]
        );
        for (j, entry) in row.iter().enumerate() {
            let product = |theta: &Vec<f64>| {
                (theta[places[i]] - sample_moments[i][0])
                    * (theta[places[j]] - sample_moments[j][0])
            };
            let found = samples.theta.iter().map(product).sum::<f64>() / count;
            let size = error * stated.values[j][j].sqrt() * if i == j { 2.0 } else { 1.0 };
            assert!(
                (found - entry).abs() < share * size,
                "{i} {j}: {found} {entry}"
            );
        }
    }
}

/// Checks the second moments of a body about the origin, without code of the library: mass, first moments, moments of
/// inertia.
fn is_possible(body: &[f64]) -> bool {
    let [m, x, y, z, xx, xy, yy, xz, yz, zz] = body.try_into().unwrap();
    let half = 0.5 * (xx + yy + zz);
    #[rustfmt::skip]
    let mut moments = [
        half - xx, -xy, -xz, x,
        -xy, half - yy, -yz, y,
        -xz, -yz, half - zz, z,
        x, y, z, m,
    ];
    m > 0.0 && factor(&mut moments, 4)
}

#[test]
fn where_no_bound_binds_draws_have_the_stated_covariance() {
    let (model, estimates) = demo_estimates(0.01);
    let result = result_of(&estimates, 0.5);
    let samples = draw(&model, &result, 20_000);
    let DrawMethod::Rejection { accepted } = samples.method else {
        panic!("{:?}", samples.method)
    };
    assert!(accepted > 0.4, "{accepted}");
    let free = |name: &str| !name.contains("coulomb");
    assert!(samples.undetermined.iter().all(|name| free(name)));
    has_covariance(&samples, &result, 0.1);
    for Estimate { name, value, error } in &estimates {
        let at = samples
            .parameters
            .iter()
            .position(|parameter| parameter == name)
            .unwrap();
        let [mean, _] = moments(&samples, at);
        assert!(
            (mean - value).abs() < 0.05 * error.unwrap(),
            "{name}: {mean} {value}"
        );
    }
}

#[test]
fn robots_of_a_tree_can_exist_and_have_the_stated_covariance() {
    let TreeEstimates {
        model,
        estimates,
        bodies,
    } = tree_estimates(0.02);
    let mut result = result_of(&estimates, 0.3);
    result.standard_parameters = serde_json::from_value(Value::Array(bodies)).unwrap();
    let samples = draw(&model, &result, 4000);
    assert!(samples.undetermined.is_empty());
    assert!(
        samples
            .undetermined_standard
            .contains(&"link1.m".to_owned())
    );
    assert!(
        !samples
            .undetermined_standard
            .contains(&"link2.mx".to_owned())
    );
    for (robot, standard) in samples.standard.iter().enumerate() {
        assert!(standard[..20].chunks(10).all(is_possible), "{standard:?}");
        assert!(standard[20..].iter().all(|rotor| *rotor > 0.0));
        for body in samples.bodies(robot).unwrap() {
            assert!(body.mass > 0.0 && body.inertia[0][0] > 0.0);
        }
        // The parameters are the combinations of the bodies, and the drives.
        let names = samples.standard_parameters.iter().cloned();
        let mut values: BTreeMap<String, f64> = names.zip(standard.iter().copied()).collect();
        let draw = &samples.theta[robot];
        for (parameter, value) in model.parameters().iter().zip(draw) {
            if parameter.joint.is_some_and(|(kind, _)| kind.is_friction()) {
                assert!(*value >= 0.0 || parameter.name.contains("offset"));
            }
            if parameter.name.contains("motor_") {
                values.insert(parameter.name.clone(), *value);
            }
        }
        let theta = model.theta(&values).unwrap();
        for (a, b) in theta.iter().zip(draw) {
            assert!((a - b).abs() < 1e-9 * (1.0 + a.abs()));
        }
    }
    has_covariance(&samples, &result, 0.1);
}

#[test]
fn where_bounds_bind_draws_have_the_truncated_distribution_and_move() {
    // Six frictions and stiffnesses 1.5 standard errors below zero: one normal draw in ten million can exist.
    let (model, mut estimates) = demo_estimates(0.01);
    let bound: Vec<String> = (model.parameters().iter())
        .filter(|parameter| parameter.joint.is_some_and(|(kind, _)| kind.is_friction()))
        .map(|parameter| parameter.name.clone())
        .filter(|name| !name.contains("offset"))
        .collect();
    assert!(bound.len() >= 4, "{bound:?}");
    for Estimate { name, value, error } in &mut estimates {
        if bound.contains(name) {
            (*value, *error) = (-1.5, Some(1.0));
        }
    }
    let result = result_of(&estimates, 0.0);
    let samples = draw(&model, &result, 8000);
    assert!(matches!(samples.method, DrawMethod::Gibbs { .. }));
    assert!(samples.effective > 0.3 * 8000.0, "{}", samples.effective);
    for name in &bound {
        let at = samples
            .parameters
            .iter()
            .position(|parameter| parameter == name)
            .unwrap();
        assert!(samples.theta.iter().all(|theta| theta[at] > 0.0));
        // Mean and standard deviation of a normal distribution above 1.5 standard deviations, minus 1.5.
        let [mean, spread] = moments(&samples, at);
        assert!(
            (mean - 0.438_9).abs() < 0.03 && (spread - 0.387_8).abs() < 0.03,
            "{name}: {mean} {spread}"
        );
    }
}

#[test]
fn a_seed_gives_the_same_bits_on_any_number_of_threads() {
    let tree = tree_estimates(0.2);
    for (model, estimates) in [demo_estimates(0.01), (tree.model, tree.estimates)] {
        let result = result_of(&estimates, 0.0);
        let posterior = Posterior::new(&model, &Physical::default(), &result).unwrap();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| posterior.sample(50, 3).unwrap())
        };
        assert_eq!(on(1), on(3));
        assert_ne!(on(1).theta, posterior.sample(50, 4).unwrap().theta);
    }
}

#[test]
fn parameters_that_the_log_does_not_determine_are_named_and_come_from_the_prior() {
    let (model, mut estimates) = demo_estimates(0.01);
    let at = (estimates
        .iter()
        .position(|estimate| estimate.name.contains("viscous")))
    .unwrap();
    let Estimate { name, value, .. } = estimates[at].clone();
    estimates[at].error = None;
    let samples = draw(&model, &result_of(&estimates, 0.0), 4000);
    assert_eq!(samples.undetermined, std::slice::from_ref(&name));
    let place = samples
        .parameters
        .iter()
        .position(|parameter| *parameter == name)
        .unwrap();
    let [mean, spread] = moments(&samples, place);
    // The relative error of nominal values is 30 %.
    assert!(
        (mean / value - 1.0).abs() < 0.03 && (spread / value - 0.3).abs() < 0.03,
        "{mean} {spread} {value}"
    );
}

#[test]
fn results_that_tell_no_distribution_are_refused() {
    let (model, estimates) = demo_estimates(0.01);
    let good = result_of(&estimates, 0.0);
    let error =
        |result: &EstimateResult| Posterior::new(&model, &Physical::default(), result).unwrap_err();
    let without = EstimateResult {
        covariance: None,
        ..good.clone()
    };
    assert!(matches!(
        error(&without),
        PosteriorError::NoCovariance { .. }
    ));
    let mut wrong = good.clone();
    if let Some(covariance) = &mut wrong.covariance {
        covariance.values[1][1] = -1.0;
    }
    assert!(matches!(error(&wrong), PosteriorError::Covariance { .. }));
    let mut other = good.clone();
    if let Some(covariance) = &mut other.covariance {
        covariance.parameters[0] = "wrist.stiffness".to_owned();
    }
    assert!(error(&other).to_string().contains("wrist.stiffness"));
    let mut lacking = estimates;
    let stiffness = (lacking
        .iter()
        .position(|estimate| estimate.name.contains("stiffness")))
    .unwrap();
    let Estimate { name, .. } = lacking.remove(stiffness);
    let refused = Posterior::new(&model, &Physical::default(), &result_of(&lacking, 0.0));
    if let Err(error) = refused {
        assert_eq!(error, PosteriorError::NoValue { names: vec![name] });
    } else {
        assert!(
            model
                .parameters()
                .iter()
                .any(|parameter| parameter.name == name && parameter.nominal.is_some())
        );
    }
    let posterior = Posterior::new(&model, &Physical::default(), &good).unwrap();
    for count in [0, 100_001] {
        assert!(matches!(
            posterior.sample(count, 1),
            Err(PosteriorError::Count { .. })
        ));
    }
}
