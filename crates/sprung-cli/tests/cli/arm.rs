//! A small arm with a flexible shoulder, a rigid elbow and gravity, described by URDF.

use std::path::Path;
use std::sync::OnceLock;

use crate::common::Case;

pub(crate) const URDF: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial><origin xyz="0.2 0 0"/><mass value="3"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.04"/></inertial>
  </link>
  <link name="fore">
    <inertial><origin xyz="0.15 0 0"/><mass value="1.5"/>
    <inertia ixx="0.004" ixy="0" ixz="0" iyy="0.015" iyz="0" izz="0.015"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
  </joint>
</robot>
"#;

pub(crate) const EXPERIMENT: &str = r#"format = 1
[robot]
name = "arm"
urdf = "arm.urdf"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
[[robot.joint]]
name = "shoulder"
link_friction = ["viscous"]
motor_friction = ["viscous", "coulomb"]
nominal = { stiffness = 400.0, rotor_inertia = 0.3, link_viscous = 0.3, motor_viscous = 2.0, motor_coulomb = 1.0 }
[[robot.joint]]
name = "elbow"
transmission = "rigid"
nominal = { rotor_inertia = 0.05, motor_viscous = 1.0, motor_coulomb = 0.5, motor_offset = 0.1 }
[log]
file = "run.csv"
time_s = "t"
link_position_rad = ["q1"]
motor_position_rad = ["phi1", "phi2"]
motor_torque_nm = ["tau1", "tau2"]
[identify]
estimator = "least-squares"
position_cutoff_hz = 20.0
[controller]
kind = "pd"
kp_nm_per_rad = [300.0, 100.0]
kd_nms_per_rad = [10.0, 5.0]
[controller.reference] # begins at rest
sines = [
  { joint = "shoulder", amplitude_deg = 15.0, frequency_hz = 0.5, phase_deg = 90.0 },
  { joint = "shoulder", amplitude_deg = 15.0, frequency_hz = 1.3, phase_deg = -90.0 },
  { joint = "elbow", amplitude_deg = 20.0, frequency_hz = 0.7, phase_deg = 90.0 },
  { joint = "elbow", amplitude_deg = 20.0, frequency_hz = 1.7, phase_deg = -90.0 },
]
[simulate]
duration_s = 6.0
period_s = 0.002
torque_noise_nm = [0.02, 0.01]
"#;

/// The arm without a log.
pub(crate) fn described() -> Case {
    Case::of(&[("experiment.toml", EXPERIMENT), ("arm.urdf", URDF)])
}

/// The arm with replaced text in its URDF file.
pub(crate) fn urdf(from: &str, to: &str) -> Case {
    described().replace_in("arm.urdf", from, to)
}

/// The arm with more keys in `[robot]`.
pub(crate) fn robot(keys: &str) -> Case {
    described().replace("gravity_m_per_s2", &format!("{keys}\ngravity_m_per_s2"))
}

/// The arm with a log of its twin.
pub(crate) fn recorded() -> Case {
    static LOG: OnceLock<String> = OnceLock::new();
    let log = LOG.get_or_init(|| {
        let case = described();
        case.record("run.csv", &[]);
        case.read("run.csv")
    });
    Case::of(&[
        ("experiment.toml", EXPERIMENT),
        ("arm.urdf", URDF),
        ("run.csv", log),
    ])
}

pub(crate) fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}
