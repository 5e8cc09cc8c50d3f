//! Validation on a log with a known payload.

use sprung::progress::Unheard;
use sprung::session::Parameters;
use sprung::validate::RunResult;

use crate::what_works::{ARM, Files, session};

/// 0.3 kg at 0.2 m on the second link, as a body of the twin.
const LOADED: [&str; 4] = [
    "robot.nominal.\"link2.m\"=0.8",
    "robot.nominal.\"link2.mx\"=0.12",
    "robot.nominal.\"link2.iyy\"=0.024",
    "robot.nominal.\"link2.izz\"=0.024",
];

/// Validates the arm without payload on a log with it.
fn validated(file: &str) -> RunResult {
    let loaded = LOADED.map(str::to_owned);
    let mut files = Files::new();
    for (name, overrides) in [("0.csv", &[][..]), ("1.csv", &loaded)] {
        let own = session(&files, ARM, overrides).unwrap();
        let mut log = Vec::new();
        let twin = own.twin(None, None).unwrap();
        twin.write(&mut log, &mut Unheard).unwrap();
        files.insert(name.to_owned(), log);
    }
    let text = ARM.replace(
        "log = { file = \"0.csv\" }",
        &format!("log = {{ file = {file} }}"),
    );
    let own = session(&files, &text, &[]).unwrap();
    let found = own.identify(&mut Unheard).unwrap().identification;
    let parameters = Parameters::from(found);
    let validated = own.validate(&parameters, &mut Unheard).unwrap();
    validated.validation.runs.into_iter().next().unwrap()
}

#[test]
fn a_known_payload_is_part_of_the_predicted_robot() {
    let known = validated("{ path = \"1.csv\", payload = { mass_kg = 0.3, com_m = [0.2, 0, 0] } }");
    let unknown = validated("\"1.csv\"");
    let largest = |run: &RunResult| {
        let set = &run.sets[0];
        let errors = &set.e_rms.as_ref().unwrap().q_rad;
        (errors.iter()).fold(0.0_f64, |worst, (_, error)| worst.max(error))
    };
    let (with, without) = (largest(&known), largest(&unknown));
    println!("largest error of a link: {with:.2e} rad with the payload, {without:.2e} rad without");
    assert!(with < 0.2 * without, "{with} {without}");
    assert!(
        !known.sets[0]
            .findings
            .iter()
            .any(|own| own.code == "payload-changed")
    );
}
