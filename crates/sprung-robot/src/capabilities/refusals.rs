//! The refusals of the table as explanations.

use sprung_base::explanation::Explanation;

use super::NotSupported;
use super::feature::Feature;
use super::table::{PAIRS, refuse, together};
use super::task::Task;

/// Section of the explanations: the title of the page.
const SECTION: &str = "What works with what";

/// Returns the meaning of every refusal, one for each code, in the order of the page.
#[must_use]
pub fn refusals() -> Vec<Explanation> {
    let mut all: Vec<Meaning> = Vec::new();
    for feature in Feature::ALL {
        for task in Task::ALL {
            if let Err(refusal) = refuse(feature, bearer(feature), task) {
                add(&mut all, feature, task.name(), &refusal);
            }
        }
    }
    for pair in &PAIRS {
        if let Err(refusal) = together(pair.one, bearer(pair.one), pair.other) {
            add(&mut all, pair.one, pair.other.noun().to_owned(), &refusal);
        }
    }
    all.into_iter().map(Meaning::explanation).collect()
}

/// The refusals with one code.
struct Meaning {
    code: &'static str,
    why: &'static str,
    /// Features, and what each of them does not go with.
    combinations: Vec<(Feature, Vec<String>)>,
    instead: Vec<&'static str>,
    example: String,
}

impl Meaning {
    fn explanation(self) -> Explanation {
        let combinations: Vec<String> = (self.combinations.iter())
            .map(|(feature, others)| format!("{} with {}", feature.noun(), listed(others)))
            .collect();
        Explanation {
            codes: vec![self.code.to_owned()],
            aliases: Vec::new(),
            section: SECTION,
            severities: vec!["refusal".to_owned()],
            cause: self.why.to_owned(),
            condition: Some(combinations.join("; ")),
            remedy: self.instead.join("; or "),
            ignore: "never; sprung stops".to_owned(),
            example: Some(self.example),
        }
    }
}

fn add(all: &mut Vec<Meaning>, feature: Feature, other: String, refusal: &NotSupported) {
    let code = refusal.code();
    let at = (all.iter().position(|known| known.code == code)).unwrap_or_else(|| {
        all.push(Meaning {
            code,
            why: refusal.0.why,
            combinations: Vec::new(),
            instead: Vec::new(),
            example: refusal.to_string(),
        });
        all.len() - 1
    });
    let meaning = &mut all[at];
    match (meaning.combinations.iter_mut()).find(|(known, _)| *known == feature) {
        Some((_, others)) => others.push(other),
        None => meaning.combinations.push((feature, vec![other])),
    }
    if !meaning.instead.contains(&refusal.instead()) {
        meaning.instead.push(refusal.instead());
    }
}

/// Returns alternatives with "or" before the last one.
fn listed(all: &[String]) -> String {
    match all.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} or {last}", before.join(", ")),
        _ => all.concat(),
    }
}

/// Returns a name of what has a feature, for an example.
const fn bearer(feature: Feature) -> &'static str {
    match feature {
        Feature::LinkEncoder
        | Feature::DeflectionSensor
        | Feature::TorqueSensor
        | Feature::TorqueSensorAlone
        | Feature::Gyroscope
        | Feature::Accelerometer
        | Feature::MotorOnly
        | Feature::Servo
        | Feature::Covariates
        | Feature::FlexibleJoint
        | Feature::SlidingJoint
        | Feature::CubicSpring
        | Feature::LoadFriction => "joint1",
        Feature::KnownPayload | Feature::UnknownPayload => "log.csv",
        Feature::CoupledTransmission
        | Feature::ClosedForm
        | Feature::SpringsFromMotor
        | Feature::SeveralJoints
        | Feature::OpenColumns => "the robot",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_refusal_has_one_explanation() {
        let all = refusals();
        for pair in &PAIRS {
            let code = pair.reason.code;
            let found: Vec<_> = all.iter().filter(|one| one.has(code)).collect();
            let [one] = found[..] else {
                panic!("{code}: {found:?}");
            };
            assert!(one.cause.contains(pair.reason.why), "{one:?}");
            assert!(one.remedy.contains(pair.reason.instead), "{one:?}");
            let condition = one.condition.as_deref().unwrap_or_default();
            assert!(condition.contains(pair.other.noun()), "{one:?}");
            assert!(Explanation::of(code).is_none(), "{code} is a finding, too");
        }
        let [of_task] = &all
            .iter()
            .filter(|one| one.has("coupling-not-exported"))
            .collect::<Vec<_>>()[..]
        else {
            panic!("{all:?}");
        };
        assert_eq!(
            of_task.condition.as_deref(),
            Some("a coupled transmission with export to URDF, MJCF, SDF or JSON or export of code")
        );
        assert!(
            of_task
                .example
                .as_deref()
                .is_some_and(|text| text.starts_with("the robot has"))
        );
    }
}
