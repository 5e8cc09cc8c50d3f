//! Checks of friction laws and spring terms.

use sprung_core::covariate::Covariate;
use sprung_core::friction::Family;
use sprung_core::parameters::{JointParameter, Side};

use super::fault::{Fault, fault};
use crate::friction::FrictionLaw;
use crate::robot::{Joint, SpringTerm};

/// Checks that the covariates of a joint act on friction that it has.
fn covariates(joint: &Joint, at: &str) -> Result<(), Fault> {
    let Some(covariates) = &joint.friction_covariates else {
        return Ok(());
    };
    let path = ["robot", "joint", at, "friction_covariates"];
    let name = &joint.name;
    let of_side = |side: Side, laws: &[FrictionLaw]| -> Vec<&'static str> {
        let laws = laws.iter().flat_map(|law| law.columns());
        laws.map(|law| JointParameter::Friction(side, *law).name())
            .collect()
    };
    let known = [
        of_side(Side::Link, joint.link_laws()),
        of_side(Side::Motor, joint.motor_laws()),
    ]
    .concat();
    if Covariate::ALL.into_iter().all(|one| !joint.depends_on(one)) {
        return Err(fault(
            &path,
            format!(
                "{name}: friction_covariates lists no friction parameter; write for example temperature =                  [\"{}\"], or remove friction_covariates",
                known.first().unwrap_or(&"motor_viscous")
            ),
        ));
    }
    for covariate in Covariate::ALL {
        covariate_of(covariate, covariates.of(covariate), (name, &known), &path)?;
    }
    Ok(())
}

/// Checks the friction parameters that depend on a covariate, and its reference.
///
/// - `known`: the friction parameters of the joint.
fn covariate_of(
    covariate: Covariate,
    (parameters, reference): (&[String], Option<f64>),
    (name, known): (&str, &[&str]),
    path: &[&str],
) -> Result<(), Fault> {
    let (word, key) = (covariate.word(), covariate.key_of_reference());
    let at_reference = [path, &[key]].concat();
    match reference {
        Some(value) if !value.is_finite() => {
            return Err(fault(
                &at_reference,
                format!("{name}: {key} must be finite, in {}", covariate.unit()),
            ));
        }
        Some(_) if parameters.is_empty() => {
            return Err(fault(
                &at_reference,
                format!("{name}: {key} has no effect without {word} = […]; remove it"),
            ));
        }
        None if !parameters.is_empty() => {
            return Err(fault(
                path,
                format!(
                    "{name}: {word} needs {key}, the value at which the friction parameters hold; the mean \
                     of the log is best"
                ),
            ));
        }
        _ => {}
    }
    let path = [path, &[word]].concat();
    for (i, parameter) in parameters.iter().enumerate() {
        if !known.contains(&parameter.as_str()) {
            return Err(fault(
                &path,
                format!(
                    "{name} has no friction parameter \"{parameter}\"; it has {}",
                    known.join(", ")
                ),
            ));
        }
        if parameters[..i].contains(parameter) {
            return Err(fault(
                &path,
                format!("{name}: {word} lists \"{parameter}\" twice"),
            ));
        }
    }
    Ok(())
}

/// Returns the laws that a law already includes, and why if it is not plain.
fn included(law: Family) -> (&'static [Family], &'static str) {
    use Family::{
        Coulomb, CoulombAsymmetric, Load, Offset, Presliding, Quadratic, Stribeck, Viscous,
        ViscousAsymmetric,
    };
    const EQUAL: &str = ": they are equal at every velocity except zero";
    match law {
        ViscousAsymmetric => (&[Viscous], EQUAL),
        CoulombAsymmetric => (&[Coulomb, Offset], EQUAL),
        Viscous | Coulomb | Offset | Stribeck | Quadratic | Load | Presliding => (&[], ""),
    }
}

/// Checks that the friction laws and spring terms of a joint are independent.
pub(super) fn laws(joint: &Joint, at: &str) -> Result<(), Fault> {
    let name = &joint.name;
    let sides = [
        ("link_friction", joint.link_laws()),
        ("motor_friction", joint.motor_laws()),
    ];
    for (key, laws) in sides {
        let path = ["robot", "joint", at, key];
        if let Some(i) = (1..laws.len()).find(|&i| laws[..i].contains(&laws[i])) {
            return Err(fault(
                &path,
                format!("{name}: {key} lists \"{}\" twice", laws[i].name()),
            ));
        }
        if laws.contains(&FrictionLaw(Family::Load)) && !joint.is_flexible() {
            return Err(fault(
                &path,
                format!(
                    "{name} is rigid, so no deflection measures the load of its gear; remove \"load\" \
                     from {key} or set transmission = \"flexible\""
                ),
            ));
        }
        let has = |family| laws.contains(&FrictionLaw(family));
        if has(Family::Presliding) && key == "link_friction" {
            return Err(fault(
                &path,
                format!(
                    "{name}: \"presliding\" is friction of motor and gear; list it in motor_friction"
                ),
            ));
        }
        for &other in Family::ALL.iter().filter(|&&family| has(family)) {
            let (inside, why) = included(other);
            if let Some(one) = inside.iter().find(|one| has(**one)) {
                return Err(fault(
                    &path,
                    format!(
                        "{name}: in {key} \"{}\" already includes \"{}\"{why}; keep one",
                        other.word(),
                        one.word()
                    ),
                ));
            }
        }
    }
    covariates(joint, at)?;
    let spring = joint.spring_terms();
    if joint.spring.is_some() && !joint.is_flexible() {
        return Err(fault(
            &["robot", "joint", at, "spring"],
            format!(
                "{name} is rigid, it has no spring; remove spring or set transmission = \"flexible\""
            ),
        ));
    }
    if !spring.contains(&SpringTerm::Linear) {
        return Err(fault(
            &["robot", "joint", at, "spring"],
            format!("{name}: spring must contain \"linear\""),
        ));
    }
    match (1..spring.len()).find(|&i| spring[..i].contains(&spring[i])) {
        Some(_) => Err(fault(
            &["robot", "joint", at, "spring"],
            format!("{name}: spring lists a term twice"),
        )),
        None => Ok(()),
    }
}
