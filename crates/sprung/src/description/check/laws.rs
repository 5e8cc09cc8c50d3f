//! Checks of friction laws and spring terms.

use sprung_core::friction::Family;

use super::fault::{Fault, fault};
use crate::description::friction::FrictionLaw;
use crate::description::robot::{Joint, SpringTerm};

/// Checks that the friction laws and spring terms of a joint are independent.
pub(super) fn laws(joint: &Joint, at: &str) -> Result<(), Fault> {
    use Family::{
        Coulomb, CoulombAsymmetric, Load, Offset, Quadratic, Residual, Viscous, ViscousAsymmetric,
    };
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
        if laws.contains(&FrictionLaw(Load)) && !joint.is_flexible() {
            return Err(fault(
                &path,
                format!(
                    "{name} is rigid, so no deflection measures the load of its gear; remove \"load\" \
                     from {key} or set transmission = \"flexible\""
                ),
            ));
        }
        let has = |family| laws.contains(&FrictionLaw(family));
        for (one, other) in [(Quadratic, Residual), (ViscousAsymmetric, Residual)] {
            if has(one) && has(other) {
                return Err(fault(
                    &path,
                    format!(
                        "{name}: in {key} \"{}\" already includes \"{}\"; keep one",
                        other.word(),
                        one.word()
                    ),
                ));
            }
        }
        for (one, other) in [
            (Viscous, ViscousAsymmetric),
            (Coulomb, CoulombAsymmetric),
            (Offset, CoulombAsymmetric),
        ] {
            if has(one) && has(other) {
                return Err(fault(
                    &path,
                    format!(
                        "{name}: in {key} \"{}\" already includes \"{}\": they are equal at every \
                         velocity except zero; keep one",
                        other.word(),
                        one.word()
                    ),
                ));
            }
        }
    }
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
