//! Whether a robot with the estimated parameters can exist, and the price of the constraints otherwise.

use sprung_core::parameters::JointParameter;

use super::of_joint::{motor_row, of};
use super::parameters::{list, listed};
use crate::check::reversed_torque;
use crate::estimate::estimators::least_squares::{Contradicted, Linear, Price};
use crate::estimate::possible::MassLimit;
use crate::estimate::result::{EstimateResult, ParameterEstimate};
use crate::estimate::statistics::{CERTAIN_SIGMAS, SIGNIFICANT_SIGMAS};
use crate::finding::{Finding, Severity};
use crate::log::{Channels, Signal};
use crate::model::{Model, ModelError};
use crate::numbers::in_percent;

/// Code of all findings about robots that cannot exist.
const IMPOSSIBLE: &str = "impossible-robot";

/// Standard errors above which negative friction is significant.
const SIGNIFICANCE_SIGMAS: f64 = 2.0;

/// Reports that the equations give a robot that cannot exist.
///
/// - `channels`: the columns, for their names.
pub(super) fn impossible_robot(
    model: &Model,
    result: &EstimateResult,
    linear: &Linear<'_>,
    channels: &Channels,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (joint, name) in model.joints().iter().enumerate() {
        findings.extend(of_joint(model, result, (joint, name), channels));
    }
    findings.extend(linear.contradicted.as_ref().map(contradicted_limits));
    if result.is_constrained() {
        findings.extend(price(model, result, linear));
    } else {
        findings.extend(negative_links(model, result));
        findings.extend(impossible_bodies(model, result));
        findings.extend(negative_friction(model, result));
    }
    findings
}

fn contradicted_limits(contradicted: &Contradicted) -> Finding {
    let limit = |(limit, mass): &(MassLimit, f64)| {
        let [least, largest] = limit.range;
        format!(
            "{} is limited to {least} to {largest} kg, and the robot that fits best without limits has {mass:.1} kg",
            limit.subject
        )
    };
    let limits = contradicted.limits.iter().map(limit);
    Finding::new(
        Severity::Serious,
        "mass-limits-contradicted",
        format!(
            "the torques of the log contradict the limits of masses by {:.0} standard errors: {}",
            contradicted.standard_errors,
            listed(limits)
        ),
        "correct total_mass_kg and mass_kg in [identify.physical], or the units of the torques and gravity_m_per_s2",
    )
}

/// Returns whether the equations give a negative value.
fn negative(estimate: &ParameterEstimate) -> bool {
    estimate.by_equations().is_some_and(|value| value < 0.0)
}

/// Returns the finding about a joint whose torque, spring or rotor has the wrong sign.
fn of_joint(
    model: &Model,
    result: &EstimateResult,
    (joint, name): (usize, &str),
    channels: &Channels,
) -> Vec<Finding> {
    if let Some(row) = motor_row(model, result, joint)
        && (row.parameters.iter())
            .filter(|p| {
                !p.name.ends_with("rotor_inertia") && p.unit != "N·m" || p.name.ends_with("coulomb")
            })
            .all(negative)
    {
        let names = row.parameters.iter().map(|p| p.name.clone());
        let torque = columns(channels, joint, &[Signal::Torque]).join("");
        return vec![reversed_torque(name, &torque).about(names)];
    }
    let wrong = |kind: JointParameter| {
        let estimate = of(model, result, kind, joint)?;
        let value = estimate.by_equations().filter(|value| *value < 0.0)?;
        let is_sure = !result.is_constrained()
            || estimate
                .error_by_equations()
                .is_some_and(|error| -value > SIGNIFICANT_SIGMAS * error);
        is_sure.then_some((estimate, value))
    };
    let mut findings = Vec::new();
    if let Some((stiffness, value)) = wrong(JointParameter::Stiffness) {
        let text = format!(
            "{name}: the stiffness by the equations is negative ({value:.4} {}), which no spring has: a channel is \
             delayed against the others, or a sign is wrong",
            stiffness.unit
        );
        let finding = Finding::new(
            Severity::Serious,
            IMPOSSIBLE,
            text,
            &remedy_of_spring(channels, joint),
        );
        findings.push(finding.about([stiffness.name.clone()]));
    }
    if let Some((rotor, value)) = wrong(JointParameter::RotorInertia) {
        let text = format!(
            "{name}: the rotor inertia by the equations is negative ({value:.4e} {}): the torque is delayed against the \
             motor position, or its sign is wrong, or the friction is much larger than the inertia's torque",
            rotor.unit
        );
        let remedy =
            "check sign and delay of the torque; excite the joint with higher accelerations";
        let finding = Finding::new(Severity::Serious, IMPOSSIBLE, text, remedy);
        findings.push(finding.about([rotor.name.clone()]));
    }
    findings
}

/// Returns the columns of some signals of a joint, as far as the log has them.
fn columns<'a>(channels: &'a Channels, joint: usize, signals: &[Signal]) -> Vec<&'a str> {
    (signals.iter())
        .filter_map(|&signal| channels.telling(signal, joint))
        .map(|i| channels.all[i].column.as_str())
        .collect()
}

/// Returns the remedy for a spring that cannot exist. A joint with a torque sensor may have no link encoder.
fn remedy_of_spring(channels: &Channels, joint: usize) -> String {
    let signals = [Signal::Link, Signal::Spring, Signal::Motor, Signal::Torque];
    let columns = columns(channels, joint, &signals);
    let all: Vec<String> = (columns.iter())
        .map(|column| format!("\"{column}\""))
        .collect();
    let estimate = all.first().map_or_else(String::new, |first| {
        format!("; set delay_s = {{ {first} = \"estimate\" }} in [log]")
    });
    format!("check signs and delays of {}{estimate}", all.join(", "))
}

/// Reports parameters that are impossible without the constraints, with the price on held-out parts of the logs.
fn price(model: &Model, result: &EstimateResult, linear: &Linear<'_>) -> Option<Finding> {
    let held: Vec<&ParameterEstimate> = (result.parameters.iter().zip(model.parameters()))
        .filter(|(p, known)| {
            negative(p)
                && known.joint.is_some_and(|(kind, _)| {
                    (kind.is_vital() || kind.is_friction()) && !kind.is_of_curve()
                })
        })
        .map(|(p, _)| p)
        .collect();
    let prices = || {
        (0..model.joint_count()).filter_map(|joint| {
            let price = linear.held_out.price(model.torque_row(joint))?;
            Some((joint, price))
        })
    };
    let said = |(joint, price): (usize, Price)| {
        let band = linear.bands[joint];
        format!(
            "{} {:+.1} ± {:.1} %{}",
            model.joints()[joint],
            in_percent(price.ratio - 1.0),
            in_percent(price.standard_error),
            band.map_or_else(String::new, |below| format!(
                " (half of it below {below:.1} Hz)"
            ))
        )
    };
    let dear: Vec<String> = prices()
        .filter(|(_, price)| price.is_dear())
        .map(said)
        .collect();
    if held.is_empty() && dear.is_empty() {
        return None;
    }
    let would = if held.is_empty() {
        "links that no bodies have".to_owned()
    } else {
        let value =
            |p: &ParameterEstimate| format!("{:.3} {}", p.by_equations().unwrap_or(0.0), p.unit);
        list(&held, value)
    };
    let names = held.iter().map(|p| p.name.clone());
    let is_vital = |name: &str| name.ends_with(".stiffness") || name.ends_with(".rotor_inertia");
    let cause = if held.iter().any(|p| is_vital(&p.name)) {
        ". A negative stiffness or rotor inertia can mean that a channel is delayed against the others, or a sign is wrong"
    } else {
        ""
    };
    if dear.is_empty() {
        let all: Vec<String> = prices().map(said).collect();
        let cost = if all.is_empty() {
            String::new()
        } else {
            format!(
                ", and the error of the torque on held-out parts changes by: {}",
                all.join(", ")
            )
        };
        return Some(
            Finding::new(
                Severity::Info,
                IMPOSSIBLE,
                format!(
                    "the equations alone would give a robot that cannot exist ({would}); the values are those of one that \
                     can{cost}{cause}"
                ),
                "excite these parameters more, with higher accelerations and slower and faster motion",
            )
            .about(names),
        );
    }
    Some(
        Finding::new(
            Severity::Warning,
            IMPOSSIBLE,
            format!(
                "the equations alone would give a robot that cannot exist ({would}), and one that can exist predicts the \
                 torque on held-out parts worse: {}. The model lacks an effect in these joints{cause}",
                listed(dear.into_iter())
            ),
            "look at delays and at the friction of these joints, at the kinematics, and at the sweep of cut-offs in the \
             report",
        )
        .about(names),
    )
}

/// Link parameters of a robot in closed form are inertias and belong to no joint.
fn negative_links(model: &Model, result: &EstimateResult) -> Option<Finding> {
    if model.tree().is_some() {
        return None;
    }
    let names: Vec<String> = (result.parameters.iter())
        .zip(model.parameters())
        .filter(|(_, p)| p.joint.is_none() && !p.name.ends_with(".coupling"))
        .filter(|(estimate, _)| negative(estimate))
        .map(|(estimate, _)| estimate.name.clone())
        .collect();
    (!names.is_empty()).then(|| {
        Finding::new(
            Severity::Serious,
            IMPOSSIBLE,
            format!(
                "negative inertia of {}: a link position has the wrong sign or a delay, or the links hardly accelerate",
                names.join(", ")
            ),
            "check signs and delays of the link columns",
        )
        .about(names)
    })
}

fn negative_friction(model: &Model, result: &EstimateResult) -> Vec<Finding> {
    let (lost, wrong): (Vec<_>, Vec<_>) = (model.parameters().iter())
        .zip(&result.parameters)
        .filter(|(parameter, estimate)| parameter.is_friction() && negative(estimate))
        .map(|(_, estimate)| estimate)
        .partition(|p| {
            -p.value.unwrap_or(0.0) < SIGNIFICANCE_SIGMAS * p.standard_error.unwrap_or(0.0)
        });
    let groups = [
        (
            wrong,
            "friction that feeds energy in makes a simulation unstable. Possible causes are quantised positions and \
             smoothing through the Coulomb transition",
        ),
        (lost, "the value is within two standard errors of zero"),
    ];
    (groups.into_iter().filter(|(group, _)| !group.is_empty()))
        .map(|(group, meaning)| {
            let list = list(&group, |p| {
                format!("{:.4} {}", p.value.unwrap_or(0.0), p.unit)
            });
            Finding::new(
                Severity::Warning,
                IMPOSSIBLE,
                format!("estimated friction is negative, {list}: {meaning}"),
                "excite the joint at low and at high speed; until then simulate with zero",
            )
            .about(group.iter().map(|p| p.name.clone()))
        })
        .collect()
}

/// Reports inertial parameters of a tree that no bodies have. Base parameters may have any sign, but
/// the mass matrix must be positive definite, and every body needs a mass that is nowhere negative.
fn impossible_bodies(model: &Model, result: &EstimateResult) -> Option<Finding> {
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
            IMPOSSIBLE,
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

/// Returns the standard error of a parameter: zero if the parameter is known, infinite if its error is unknown.
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
        IMPOSSIBLE,
        format!("no bodies have these inertial parameters: {error}{value}{nearest}"),
        "check the description of the kinematics, and signs and units of the columns; if the \
         parameters are weakly excited, record a log with higher accelerations. Until then the \
         model cannot be simulated at that pose",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{no_files, read};

    #[test]
    fn the_remedy_of_a_spring_names_columns_that_the_log_has() {
        let robot = "format = 1\n[robot]\nname = \"arm\"\nkinematics = \"planar-2r\"\n[[robot.joint]]\nname = \"joint1\"\n\
                     [[robot.joint]]\nname = \"joint2\"\n[log]\nperiod_s = 0.001\nmotor_position_rad = [\"p1\", \"p2\"]\n\
                     motor_torque_nm = [\"tau1\", \"tau2\"]\n";
        let remedy = |lines: &str| {
            let text = format!("{robot}{lines}\n");
            let experiment = read("experiment.toml", &text, &[], &mut no_files).unwrap();
            let log = experiment.log.as_ref().unwrap();
            remedy_of_spring(&Channels::new(&experiment.robot, log).unwrap(), 1)
        };
        assert_eq!(
            remedy("joint_torque_nm = [\"s1\", \"s2\"]"),
            "check signs and delays of \"s2\", \"p2\", \"tau2\"; set delay_s = { \"s2\" = \"estimate\" } in [log]"
        );
        assert_eq!(
            remedy("link_position_rad = [\"q1\", \"q2\"]"),
            "check signs and delays of \"q2\", \"p2\", \"tau2\"; set delay_s = { \"q2\" = \"estimate\" } in [log]"
        );
    }

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
