//! Possible bodies: nominal values and limits that no body obeys.

use serde_json::Value;

use crate::arm::recorded;
use crate::common::{Case, contains, f64_of, finding, list_of, messages};

fn limits(lines: &str) -> Case {
    recorded().replace(
        "[controller]\n",
        &format!("[identify.physical]\n{lines}\n[controller]\n"),
    )
}

fn results(case: &Case) -> Value {
    case.results(&[]).1
}

#[test]
fn limits_that_are_no_limits_are_refused() {
    let mut messages = messages("limits_that_are_no_limits_are_refused");
    for lines in [
        "prior_error = -0.3",
        "total_mass_kg = [5.0, 4.0]",
        "mass_kg = { hand = [1.0, 2.0] }",
        "prior = \"cad\"",
    ] {
        messages.note(lines, &limits(lines).refused(2, &[]));
    }
    messages.compare();
}

#[test]
fn limits_that_exclude_each_other_are_named() {
    let lines = "total_mass_kg = [1.0, 2.0]\nmass_kg = { upper = [5.0, 6.0] }";
    limits(lines).fails(
        2,
        &[
            "no robot can exist",
            "mass",
            "kg cannot be",
            "total_mass_kg",
        ],
    );
    let case = limits(lines).replace("[identify]\n", "[identify]\nconstraints = \"none\"\n");
    let json = results(&case);
    contains(finding(&json, "no-possible-bodies").unwrap(), &["mass"]);
    assert!(json["results"][0]["standard_parameters"].is_null());
}

#[test]
fn limits_that_the_gravity_torques_contradict_are_named() {
    let json = results(&limits("total_mass_kg = [0.05, 0.1]"));
    contains(
        finding(&json, "mass-limits-contradicted").unwrap(),
        &["0.05 to 0.1 kg"],
    );
    assert_eq!(json["results"][0]["verdict"], "unusable");
}

#[test]
fn a_given_friction_that_feeds_energy_in_is_refused() {
    recorded()
        .replace(
            "[controller]\n",
            "[robot.fixed]\n\"shoulder.motor_coulomb\" = -0.2\n\n[controller]\n",
        )
        .fails(2, &["motor_coulomb", "must not be negative"]);
}

#[test]
fn a_limit_of_the_total_mass_holds() {
    let json = results(&limits("total_mass_kg = [6.0, 7.0]"));
    let standard = list_of(&json["results"][0]["standard_parameters"]);
    let masses = standard
        .iter()
        .filter(|parameter| parameter["unit"] == "kg");
    let total: f64 = masses.map(|mass| f64_of(&mass["value"])).sum();
    assert!((6.0..7.0).contains(&total), "{total}");
}

#[test]
fn a_nominal_body_that_cannot_exist_is_named() {
    let case = recorded().replace_in("arm.urdf", "iyy=\"0.015\"", "iyy=\"0.5\"");
    let json = results(&case);
    let text = finding(&json, "impossible-nominal-bodies").unwrap();
    assert!(text.contains("fore") && !text.contains("upper"), "{text}");
}
