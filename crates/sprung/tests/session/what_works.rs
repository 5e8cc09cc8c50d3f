//! Tries every cell of the page of what works with what: the library agrees with the table.

use std::collections::BTreeMap;
use std::path::Path;

use sprung::session::{ExportRequest, Parameters, Session, SessionError, read_identification};
use sprung_base::progress::Unheard;
use sprung_export::{Form, Format};
use sprung_method::compare::{Compared, compare};
use sprung_method::estimate::Identification;
use sprung_robot::what_works;

use crate::support::{opener, recorded};

/// An arm in a horizontal plane, by bodies.
pub(crate) const ARM: &str = r#"
format = 1
[robot]
name = "arm"
dh_modified = [{}, { a_m = 0.343 }]
[robot.nominal]
"link1.m" = 1.5
"link1.mx" = 0.25
"link1.my" = 0.0
"link1.mz" = 0.0
"link1.ixx" = 0.01
"link1.ixy" = 0.0
"link1.iyy" = 0.06
"link1.ixz" = 0.0
"link1.iyz" = 0.0
"link1.izz" = 0.06
"link2.m" = 0.5
"link2.mx" = 0.06
"link2.my" = 0.0
"link2.mz" = 0.0
"link2.ixx" = 0.002
"link2.ixy" = 0.0
"link2.iyy" = 0.012
"link2.ixz" = 0.0
"link2.iyz" = 0.0
"link2.izz" = 0.012
[[robot.joint]]
name = "joint1"
nominal = { stiffness = 9.4, rotor_inertia = 0.22, link_viscous = 0.04, link_coulomb = 0.016, motor_viscous = 8.4, motor_coulomb = 1.36 }
[[robot.joint]]
name = "joint2"
nominal = { stiffness = 4.2, rotor_inertia = 0.007, link_viscous = 0.003, link_coulomb = 0.005, motor_viscous = 0.14, motor_coulomb = 0.16 }
[log]
file = "0.csv"
time_s = "t"
link_position_rad = ["q1", "q2"]
motor_position_rad = ["phi1", "phi2"]
motor_torque_nm = ["tau1", "tau2"]
[identify]
estimator = "least-squares"
[controller]
kind = "pd"
kp_nm_per_rad = [50.0, 5.0]
kd_nms_per_rad = [0.05, 0.01]
[controller.reference]
sines = [
  { joint = "joint1", amplitude_deg = 20.0, frequency_hz = 1.0 },
  { joint = "joint1", amplitude_deg = 20.0, frequency_hz = 0.4, phase_deg = 30.0 },
  { joint = "joint2", amplitude_deg = 20.0, frequency_hz = 1.3, phase_deg = 36.0 },
  { joint = "joint2", amplitude_deg = 20.0, frequency_hz = 0.5, phase_deg = 90.0 },
]
[[validate]]
name = "again"
log = { file = "0.csv" }
[simulate]
duration_s = 4.0
period_s = 0.001
link_encoder_counts_per_turn = [65536, 65536]
motor_encoder_counts_per_turn = [65536, 65536]
torque_noise_nm = [0.02, 0.005]
"#;

const SERVO: &str = include_str!("../../../../examples/servo-pendulum/experiment.toml");
const SERVO_TRUTH: &str = include_str!("../../../../examples/servo-pendulum/truth.toml");

const LINKS: &str = "link_position_rad = [\"q1\", \"q2\"]";

/// Returns the arm with one feature of the page.
fn text(feature: &str) -> String {
    let columns = |lines: &str| ARM.replace(LINKS, lines);
    let files = |lines: &str| ARM.replacen("file = \"0.csv\"", lines, 1);
    match feature {
        "link encoder" => ARM.to_owned(),
        "deflection sensor" => columns("link_deflection_rad = [\"q1\", \"q2\"]"),
        "joint torque sensor and link position" => {
            columns(&format!("{LINKS}\njoint_torque_nm = [\"s1\", \"s2\"]"))
        }
        "joint torque sensor alone" => columns("joint_torque_nm = [\"s1\", \"s2\"]"),
        // The high-pass filter of a gyroscope needs several of its periods of 5 s.
        "gyroscope on the link" => columns("gyroscope_rad_per_s.z = [\"w1\", \"w2\"]")
            .replace("duration_s = 4.0", "duration_s = 15.0"),
        "accelerometer on the link" => columns("accelerometer_m_per_s2.y = [\"a1\", \"a2\"]")
            .replace(
                "name = \"joint1\"\n",
                "name = \"joint1\"\naccelerometer_rpy_deg = [0, 0, 0]\naccelerometer_xyz_m = [0.25, 0, 0]\n",
            )
            .replace(
                "name = \"joint2\"\n",
                "name = \"joint2\"\naccelerometer_rpy_deg = [0, 0, 0]\naccelerometer_xyz_m = [0.2, 0, 0]\n",
            )
            .replace("duration_s = 4.0", "duration_s = 15.0"),
        "motor encoder alone (rigid joint)" => columns("")
            .replace("name = \"joint1\"\n", "name = \"joint1\"\ntransmission = \"rigid\"\n")
            .replace("name = \"joint2\"\n", "name = \"joint2\"\ntransmission = \"rigid\"\n")
            .replace("motor_coulomb = 1.36", "motor_coulomb = 1.36, motor_offset = 0.0")
            .replace("motor_coulomb = 0.16", "motor_coulomb = 0.16, motor_offset = 0.0"),
        "position servo" => SERVO.replace("duration_s = 40.0", "duration_s = 12.0"),
        "friction with covariates" => columns(&format!("{LINKS}\ntemperature_c = \"warm\""))
            .replace(
                "name = \"joint1\"\n",
                "name = \"joint1\"\n\
                 friction_covariates = { temperature = [\"motor_viscous\"], reference_c = 30.0 }\n",
            )
            .replace(
                "duration_s = 4.0",
                "duration_s = 4.0\ntemperature_start_c = [25.0, 25.0]\ntemperature_end_c = [35.0, 35.0]",
            ),
        "known payload" => {
            files("file = { path = \"0.csv\", payload = { mass_kg = 0.1, com_m = [0.1, 0, 0] } }")
        }
        "payload to be estimated" => {
            files("file = [\"0.csv\", { path = \"1.csv\", payload = { name = \"tool\" } }]")
        }
        "coupled transmission" => ARM.replace(
            "name = \"arm\"\n",
            "name = \"arm\"\ntransmission_matrix = [[1.0, 0.0], [0.3, 1.0]]\n",
        ),
        other => panic!("{other} has no experiment here; add one"),
    }
}

/// Returns the settings that the twin of a feature needs besides.
fn of_twin(feature: &str) -> Vec<String> {
    let change = "robot.fixed={ \"joint1.motor_viscous_per_k\" = -0.05 }";
    let needs = feature == "friction with covariates";
    needs.then(|| change.to_owned()).into_iter().collect()
}

pub(crate) type Files = BTreeMap<String, Vec<u8>>;

pub(crate) fn session(
    files: &Files,
    text: &str,
    overrides: &[String],
) -> Result<Session, SessionError> {
    let open = opener(files.clone());
    Session::read("experiment.toml", text, overrides, open)
}

/// What came of a task.
#[derive(Debug, PartialEq)]
enum Outcome {
    Works,
    Refused,
}

/// An arm or a servo with its logs.
struct Case {
    feature: String,
    text: String,
    files: Files,
    found: Option<Identification>,
}

impl Case {
    fn new(feature: &str) -> Self {
        let text = text(feature);
        let mut files = Files::from([("truth.toml".to_owned(), SERVO_TRUTH.as_bytes().to_vec())]);
        let first = session(&files, &text, &of_twin(feature)).unwrap();
        let mut found = None;
        if first.is_servo() {
            let twin = first.servo_twin(None).unwrap();
            let names: Vec<_> = twin.files().to_vec();
            for (i, name) in names.iter().enumerate() {
                let mut log = Vec::new();
                twin.write(i, &mut log, &mut Unheard).unwrap();
                files.insert(name.display().to_string(), log);
            }
        } else {
            let log = recorded(&first);
            files.insert("0.csv".to_owned(), log.clone());
            files.insert("1.csv".to_owned(), log);
            let session = session(&files, &text, &[]).unwrap();
            found = Some(session.identify(&mut Unheard).unwrap().identification);
        }
        Self {
            feature: feature.to_owned(),
            text,
            files,
            found,
        }
    }

    fn parameters(&self) -> Parameters {
        // The task of a servo is refused before its robot is read.
        let found = self.found.clone();
        Parameters::from(found.unwrap_or_else(|| Self::new("link encoder").found.unwrap()))
    }

    /// Does a task to its end.
    fn run(&self, task: &str) -> Result<(), SessionError> {
        let mut overrides = if task == "`simulate`" {
            of_twin(&self.feature)
        } else {
            Vec::new()
        };
        if let Some(name) = task
            .strip_prefix('`')
            .and_then(|rest| rest.strip_suffix('`'))
            && ["least-squares", "lsff", "prediction-error"].contains(&name)
        {
            overrides.push(format!("identify.estimator=\"{name}\""));
        }
        let text = if task == "`validate`" && self.feature.contains("payload") {
            // A validation of logs with this payload.
            let of_run = self
                .text
                .lines()
                .find(|line| line.starts_with("file = "))
                .unwrap();
            let of_run = of_run.replace("[\"0.csv\", ", "").replace("}]", "}");
            self.text.replace(
                "log = { file = \"0.csv\" }",
                &format!("log = {{ {of_run} }}"),
            )
        } else {
            self.text.clone()
        };
        let session = session(&self.files, &text, &overrides)?;
        match task {
            "`check`" if session.is_servo() => {
                session.check_servo(&mut Unheard)?;
            }
            "`check`" => {
                session.check(&mut Unheard)?;
            }
            "`least-squares`" | "`lsff`" | "`prediction-error`" => {
                if session.is_servo() {
                    // Its estimator is that of servos; one name shows that the task is allowed.
                    if task == "`least-squares`" {
                        session.identify_servo(&mut Unheard)?;
                    }
                } else {
                    session.identify(&mut Unheard)?;
                }
            }
            "`validate`" => {
                session.validate(&self.parameters(), &mut Unheard)?;
            }
            "`simulate`" if session.is_servo() => {
                session.servo_twin(None)?;
            }
            "`simulate`" => {
                let twin = session.twin(None, None)?;
                twin.write(std::io::sink(), &mut Unheard)?;
            }
            "`compare`" => match &self.found {
                None => {
                    let found = r#"{ "joint": "servo", "braking": {}, "parameters": [] }"#;
                    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("servo.json");
                    std::fs::write(&file, found).unwrap();
                    read_identification(&file)?;
                }
                Some(found) => {
                    let compared = |file| Compared {
                        file,
                        identification: found,
                    };
                    compare(&[compared("one"), compared("other")], &[])?;
                }
            },
            "export of robots" | "export of code" => {
                let format = if task.ends_with("code") {
                    Format::C
                } else {
                    Format::Json
                };
                let file = Path::new("identification.json");
                let request = ExportRequest {
                    file,
                    format,
                    form: Form::Flexible,
                    set: 0,
                    control: None,
                    watch: None,
                };
                session.export(&self.parameters(), &request)?;
            }
            "dynamics" => {
                session.dynamics(&self.parameters(), 0)?;
            }
            other => panic!("{other} is not tried here; add it"),
        }
        Ok(())
    }

    fn outcome(&self, task: &str, codes: &[String]) -> Outcome {
        match self.run(task) {
            Ok(()) => Outcome::Works,
            Err(error) => {
                let described = error.described();
                assert!(
                    codes.contains(&described.code),
                    "{} and {task}: {error} ({})",
                    self.feature,
                    described.code
                );
                assert!(described.remedy.is_some(), "{error}");
                Outcome::Refused
            }
        }
    }
}

/// Returns the cells of the rows of the first table below a heading.
fn rows(page: &str, heading: &str) -> Vec<Vec<String>> {
    let below = page.split(heading).nth(1).unwrap();
    let lines = below.lines().skip_while(|line| !line.starts_with('|'));
    lines
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let cells = line.trim_matches('|').split('|');
            cells.map(|cell| cell.trim().to_owned()).collect()
        })
        .collect()
}

/// Tries all tasks with the features whose index has this remainder.
fn try_features(rest: usize) {
    let page = what_works();
    let table = rows(&page, "## Sensors, logs and tasks");
    let codes: Vec<String> = rows(&page, "## Tasks that do not work")
        .iter()
        .map(|row| row[0].trim_matches('`').to_owned())
        .collect();
    let tasks = &table[0][1..];
    for row in table[2..].iter().skip(rest).step_by(PARTS) {
        let case = Case::new(&row[0]);
        for (task, said) in tasks.iter().zip(&row[1..]) {
            let expected = match &**said {
                "" => Outcome::Works,
                "no" => Outcome::Refused,
                other => panic!("{other}"),
            };
            assert_eq!(
                case.outcome(task, &codes),
                expected,
                "{} and {task}",
                row[0]
            );
        }
    }
}

/// Parts of the table, tried at the same time.
const PARTS: usize = 3;

#[test]
fn the_library_does_what_the_first_third_of_the_table_says() {
    try_features(0);
}

#[test]
fn the_library_does_what_the_second_third_of_the_table_says() {
    try_features(1);
}

#[test]
fn the_library_does_what_the_last_third_of_the_table_says() {
    try_features(2);
}
