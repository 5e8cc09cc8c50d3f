//! A log of an arm's twin, with columns under other names and in other units.

use std::fmt::Write as _;

use crate::new::{ARM, Desk};

pub(crate) const LEAST_SQUARES: &str = "identify.estimator=[\"least-squares\"]";

/// Motion of the arm, with exact encoders.
const TWIN: &str = r#"format = 1
[robot]
urdf = "arm.urdf"
[[robot.joint]]
name = "shoulder"
nominal = { stiffness = 900.0, rotor_inertia = 0.12, motor_viscous = 2.5, motor_coulomb = 1.4, link_viscous = 0.2, link_coulomb = 0.15 }
[[robot.joint]]
name = "elbow"
nominal = { stiffness = 250.0, rotor_inertia = 0.03, motor_viscous = 0.8, motor_coulomb = 0.5, link_viscous = 0.06, link_coulomb = 0.05 }
[log]
file = "run.csv"
time_s = "t"
link_position_rad = ["q1", "q2"]
motor_position_rad = ["phi1", "phi2"]
motor_torque_nm = ["tau1", "tau2"]
[controller]
kind = "pd"
kp_nm_per_rad = [400.0, 100.0]
kd_nms_per_rad = [10.0, 2.5]
[controller.reference]
sines = [
  { joint = "shoulder", amplitude_deg = 25.0, frequency_hz = 0.2 },
  { joint = "shoulder", amplitude_deg = 8.0, frequency_hz = 0.7 },
  { joint = "shoulder", amplitude_deg = 2.0, frequency_hz = 2.3 },
  { joint = "elbow", amplitude_deg = 30.0, frequency_hz = 0.3 },
  { joint = "elbow", amplitude_deg = 8.0, frequency_hz = 0.9 },
  { joint = "elbow", amplitude_deg = 2.0, frequency_hz = 3.1 },
]
[simulate]
duration_s = 6.0
period_s = 0.002
link_encoder_counts_per_turn = [262144, 262144]
motor_encoder_counts_per_turn = [262144, 262144]
torque_noise_nm = [0.05, 0.02]
"#;

/// Columns by name.
pub(crate) type Columns = Vec<(String, Vec<f64>)>;

/// A desk with the arm, and the log of its twin: t, q1, q2, phi1, phi2, tau1, tau2.
pub(crate) fn recorded() -> (Desk, Vec<Vec<f64>>) {
    let desk = Desk::new();
    desk.write("arm.urdf", ARM);
    desk.write("twin.toml", TWIN);
    desk.succeeds(&["simulate", "twin.toml", "--out", "twin"]);
    let log = desk.read("twin/run.csv");
    let mut columns = vec![Vec::new(); 7];
    for line in log.lines().skip(1) {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            column.push(cell.parse().unwrap());
        }
    }
    (desk, columns)
}

/// A column of the twin under another name, multiplied by a factor.
#[derive(Clone, Copy)]
pub(crate) struct Renamed<'n> {
    pub(crate) name: &'n str,
    pub(crate) column: usize,
    pub(crate) factor: f64,
}

pub(crate) const fn column(name: &str, column: usize, factor: f64) -> Renamed<'_> {
    Renamed {
        name,
        column,
        factor,
    }
}

/// Columns of the twin under other names, as `t=0, q1=3`.
pub(crate) fn plain(names: &str) -> Vec<Renamed<'_>> {
    (names.split(", "))
        .map(|one| one.split_once('=').unwrap())
        .map(|(name, place)| column(name, place.parse().unwrap(), 1.0))
        .collect()
}

/// Returns columns of the twin under other names, multiplied by factors.
pub(crate) fn named(log: &[Vec<f64>], names: &[Renamed<'_>]) -> Columns {
    (names.iter())
        .map(|renamed| {
            let values = log[renamed.column].iter();
            let scaled = values.map(|value| value * renamed.factor).collect();
            (renamed.name.to_owned(), scaled)
        })
        .collect()
}

impl Desk {
    /// Writes `log.csv`.
    pub(crate) fn log(&self, columns: &Columns) {
        self.write("log.csv", csv(columns));
    }
}

pub(crate) fn csv(columns: &Columns) -> String {
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let mut text = names.join(",") + "\n";
    for k in 0..columns[0].1.len() {
        let cells: Vec<String> = columns
            .iter()
            .map(|(_, values)| values[k].to_string())
            .collect();
        writeln!(text, "{}", cells.join(",")).unwrap();
    }
    text
}

/// Runs `new` on a log; returns its file.
pub(crate) fn begun(desk: &Desk, log: &str) -> String {
    let said = desk.succeeds(&["new", "exp", "--urdf", "arm.urdf", "--log", log]);
    println!("{said}");
    let text = desk.read("exp/experiment.toml");
    assert!(!text.contains("\nestimator ="), "{text}");
    text
}

/// Checks that an experiment runs without an edit, and that a stiffness of the shoulder is near 900.
pub(crate) fn is_identified(desk: &Desk) {
    let output = desk.run(&["identify", "exp", "--set", LEAST_SQUARES]);
    let code = output.code;
    assert!(matches!(code, Some(0 | 1)), "{}", output.err);
    let text = desk.read("exp/sprung-out/parameters.csv");
    let row = text
        .lines()
        .find(|line| line.contains("shoulder.stiffness"));
    let near = row
        .unwrap()
        .split(',')
        .filter_map(|cell| cell.parse::<f64>().ok());
    assert!(
        near.into_iter().any(|x| (x / 900.0 - 1.0).abs() < 0.05),
        "{row:?}"
    );
}
