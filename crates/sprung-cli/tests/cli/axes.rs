//! Reports of arms with six and seven axes in a real browser.

use std::fmt::Write as _;

use crate::browser::{measured, overflows};
use crate::common::Case;

/// Names of the joints, as drivers of robots give them.
const NAMES: [&str; 7] = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "forearm_roll_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
];

/// A URDF with the first joints, each at a right angle to the next.
fn urdf(joints: usize) -> String {
    let mut text = "<robot name=\"arm\"><link name=\"base\"/>".to_owned();
    let mut parent = "base";
    for (k, name) in NAMES[..joints].iter().enumerate() {
        let (mass, axis) = (5.0 / (1.0 + k as f64), ["0 0 1", "0 1 0"][k % 2]);
        write!(
            text,
            "<link name=\"{name}_link\"><inertial><origin xyz=\"0.02 0 0.1\"/><mass value=\"{mass}\"/><inertia \
             ixx=\"{0}\" ixy=\"0\" ixz=\"0\" iyy=\"{0}\" iyz=\"0\" izz=\"{0}\"/></inertial></link><joint name=\"{name}\" \
             type=\"revolute\"><parent link=\"{parent}{1}\"/><child link=\"{name}_link\"/><origin xyz=\"0.03 0 0.2\"/>\
             <axis xyz=\"{axis}\"/><limit lower=\"-3\" upper=\"3\" effort=\"100\" velocity=\"3\"/></joint>",
            0.01 * mass,
            if k == 0 { "" } else { "_link" }
        )
        .unwrap();
        parent = name;
    }
    text + "</robot>"
}

fn experiment(joints: usize) -> String {
    let mut text =
        "format = 1\n[robot]\nurdf = \"arm.urdf\"\ngravity_m_per_s2 = [0.0, 0.0, -9.81]\n"
            .to_owned();
    let list = |of: &dyn Fn(usize) -> String| {
        let all: Vec<String> = (0..joints).map(of).collect();
        all.join(", ")
    };
    for (k, name) in NAMES[..joints].iter().enumerate() {
        let size = 1.0 / (1.0 + k as f64);
        writeln!(
            text,
            "[[robot.joint]]\nname = \"{name}\"\nnominal = {{ stiffness = {}, rotor_inertia = {}, motor_viscous = {}, \
             motor_coulomb = {}, link_viscous = 0.2, link_coulomb = 0.1 }}",
            9000.0 * size,
            0.6 * size,
            8.0 * size,
            3.0 * size
        )
        .unwrap();
    }
    let columns = |name: &str| list(&|k| format!("\"{name}{}\"", k + 1));
    let values = |value: f64| list(&|k| format!("{:?}", value / (1.0 + k as f64)));
    writeln!(
        text,
        "[log]\nfile = \"run.csv\"\ntime_s = \"t\"\nlink_position_rad = [{}]\nmotor_position_rad = [{}]\n\
         motor_torque_nm = [{}]\n[identify]\nestimator = \"least-squares\"\nlaws = \"declared\"\n[controller]\nkind = \
         \"pd\"\nkp_nm_per_rad = [{}]\nkd_nms_per_rad = [{}]\n[controller.reference]\nsines = [",
        columns("q"),
        columns("phi"),
        columns("tau"),
        values(800.0),
        values(20.0)
    )
    .unwrap();
    for (k, name) in NAMES[..joints].iter().enumerate() {
        for (amplitude, frequency) in [(25.0, 0.21 + 0.04 * k as f64), (8.0, 0.9 + 0.13 * k as f64)]
        {
            writeln!(
                text,
                "{{ joint = \"{name}\", amplitude_deg = {amplitude:?}, frequency_hz = {frequency:?} }},"
            )
            .unwrap();
        }
    }
    let counts = list(&|_| "262144".to_owned());
    writeln!(
        text,
        "]\n[simulate]\nduration_s = 6.0\nperiod_s = 0.002\nlink_encoder_counts_per_turn = [{counts}]\n\
         motor_encoder_counts_per_turn = [{counts}]\ntorque_noise_nm = [{}]",
        values(0.1)
    )
    .unwrap();
    text
}

/// Checks the plots of the page as it opens: a curve for each joint, at least two numbers on each axis, whole headings.
const PLOTS: &str = "
  const page = frame.contentDocument;
  const found = [];
  const plots = [...page.querySelectorAll('.overview [role=img]')];
  if (plots.length < NAMES.length) found.push('plots: ' + plots.length);
  for (const box of plots) if (!(Number(box.dataset.ticks) >= 2)) found.push('numbers: ' + box.dataset.ticks);
  const heads = [...page.querySelectorAll('.overview h3, #joints td')];
  found.push(...heads.filter((head) => head.scrollWidth > head.clientWidth + 1).map((head) => head.textContent));
  const text = page.querySelector('main').textContent;
  found.push(...NAMES.filter((name) => !text.includes(name)));
  return found.length ? found.slice(0, 9).join('; ') : 'whole';";

fn fits(joints: usize) {
    let case = Case::of(&[
        ("experiment.toml", &experiment(joints)),
        ("arm.urdf", &urdf(joints)),
    ]);
    case.record("run.csv", &[]);
    case.identify(&["-q"]).has_a_result();
    let page = case.path("sprung-out/report.html");
    assert!(std::fs::metadata(&page).unwrap().len() < 1 << 20);
    let widths = [360, 1024, 1440];
    let Some(found) = overflows(&page, "", &widths) else {
        return;
    };
    assert_eq!(found, "fits");
    let script = PLOTS.replace("NAMES", &format!("{:?}", &NAMES[..joints]));
    for width in widths {
        let found = measured(&page, "#all", (width, 1000), &script).unwrap();
        assert_eq!(found, "whole", "{width} px");
    }
}

#[test]
fn the_first_screen_of_six_axes_fits() {
    fits(6);
}

#[test]
fn the_first_screen_of_seven_axes_fits() {
    fits(7);
}
