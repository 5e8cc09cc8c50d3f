//! Possible bodies: nominal values and limits that no body obeys.

use serde_json::Value;

use crate::arm::recorded;
use crate::common::{Case, finding};

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
    for (lines, fragments) in [
        (
            "prior_error = -0.3",
            &["line", "prior_error = -0.3 must be positive"][..],
        ),
        (
            "total_mass_kg = [5.0, 4.0]",
            &["line", "total_mass_kg", "the least one first"],
        ),
        ("mass_kg = { hand = [1.0, 2.0] }", &["hand"]),
        ("prior = \"cad\"", &["line", "cad"]),
    ] {
        limits(lines).fails(2, fragments);
    }
}

#[test]
fn limits_that_exclude_each_other_are_named() {
    let case = limits("total_mass_kg = [1.0, 2.0]\nmass_kg = { upper = [5.0, 6.0] }");
    let json = results(&case);
    let text = finding(&json, "no-possible-bodies").unwrap();
    assert!(
        text.contains("contradict each other") && text.contains("mass"),
        "{text}"
    );
    assert!(json["results"][0]["standard_parameters"].is_null());
}

#[test]
fn a_limit_of_the_total_mass_holds() {
    let json = results(&limits("total_mass_kg = [6.0, 7.0]"));
    let standard = json["results"][0]["standard_parameters"]
        .as_array()
        .unwrap();
    let masses = standard.iter().filter(|own| own["unit"] == "kg");
    let total: f64 = masses.map(|own| own["value"].as_f64().unwrap()).sum();
    assert!((6.0..7.0).contains(&total), "{total}");
}

#[test]
fn a_nominal_body_that_cannot_exist_is_named() {
    let case = recorded().replace_in("arm.urdf", "iyy=\"0.015\"", "iyy=\"0.5\"");
    let json = results(&case);
    let text = finding(&json, "impossible-nominal-bodies").unwrap();
    assert!(text.contains("fore") && !text.contains("upper"), "{text}");
}
