//! The test bench of an experiment: the drive law, the known loads, and the unknown parameters.

use sprung_core::chain::Chain;
use sprung_core::dynamics::inverse_dynamics;
use sprung_core::links::Step;
use sprung_core::servo::{DriveLaw, Load, ServoParameter};
use sprung_core::spatial::BODY_NAMES;

use super::result::Scale;
use crate::description::{Experiment, FilePart, Payload, Robot, ServoDrive};

/// A servo with its drive law and known values.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Name of the robot.
    pub(crate) robot: String,
    /// Name of the joint.
    pub(crate) joint: String,
    /// The drive law.
    pub(crate) law: DriveLaw,
    /// Whether the command is a voltage; otherwise it is a current.
    pub(crate) is_voltage: bool,
    /// Period of the position loop, s; `None` for a continuous loop.
    pub(crate) loop_period: Option<f64>,
    /// The known load of each file.
    pub loads: Vec<Load>,
    /// Known values of parameters, by the experiment.
    known: [Option<f64>; ServoParameter::COUNT],
    /// Source of the scale of all torques.
    pub(crate) scale: Scale,
}

/// Torque of gravity below which a load counts as weightless, N·m.
const WEIGHTLESS: f64 = 1e-9;

impl Bench {
    /// Returns the bench of an experiment, or `None` if the experiment has no servo.
    ///
    /// - `files`: the files of the log.
    pub fn new(experiment: &Experiment, files: &[FilePart]) -> Option<Self> {
        let robot = &experiment.robot;
        let joint = robot.joint.first()?;
        let drive = joint.servo.as_ref()?;
        let loads: Vec<Load> = (files.iter())
            .map(|file| load(robot, file.payload.as_ref()))
            .collect();
        let mut known = [None; ServoParameter::COUNT];
        known[ServoParameter::TorquePerCommand as usize] = drive.torque_per_command();
        known[ServoParameter::BackEmf as usize] = if drive.applies_voltage() {
            drive.back_emf_vs_per_rad
        } else {
            Some(0.0)
        };
        let falls = loads.iter().any(weighs);
        let scale = if drive.torque_per_command().is_some() {
            Scale::Given
        } else if loads.iter().any(|load| weighs(load) || load.inertia > 0.0) {
            Scale::KnownLoad
        } else {
            // Only ratios of torques follow from the log.
            known[ServoParameter::TorquePerCommand as usize] = Some(1.0);
            Scale::None
        };
        if !falls {
            use ServoParameter as P;
            for parameter in [
                P::LoadExternal,
                P::LoadExternalStribeck,
                P::LoadExternalQuadratic,
                P::LoadMotorQuadratic,
                P::ZeroOffset,
            ] {
                known[parameter as usize] = Some(0.0);
            }
        }
        Some(Self {
            robot: robot.name.clone(),
            joint: joint.name.clone(),
            law: law(drive),
            is_voltage: drive.applies_voltage(),
            loop_period: drive.loop_period_s,
            loads,
            known,
            scale,
        })
    }

    /// Returns the known value of a parameter.
    pub(crate) fn known(&self, parameter: ServoParameter) -> Option<f64> {
        self.known[parameter as usize]
    }

    /// Returns the indices of the parameters that are estimated, in their order.
    pub(crate) fn unknown(&self) -> Vec<usize> {
        (0..ServoParameter::COUNT)
            .filter(|&i| self.known[i].is_none())
            .collect()
    }

    /// Returns the name of a parameter, without that of the joint, and its unit.
    pub(crate) fn name(&self, parameter: ServoParameter) -> (&'static str, &'static str) {
        use ServoParameter as P;
        let (name, unit, relative) = match parameter {
            P::TorquePerCommand if self.is_voltage => ("torque_per_volt", "N·m/V", "1"),
            P::TorquePerCommand => ("torque_per_ampere", "N·m/A", "1"),
            P::BackEmf => ("back_emf", "V·s/rad", "V·s/rad"),
            P::Armature => ("armature", "kg·m²", "s²/rad"),
            P::Viscous => ("viscous", "N·m·s/rad", "s/rad"),
            P::Coulomb => ("coulomb", "N·m", "1"),
            P::Stribeck => ("stribeck", "N·m", "1"),
            P::LoadMotor => ("load_motor", "1", "1"),
            P::LoadExternal => ("load_external", "1", "1"),
            P::LoadMotorStribeck => ("load_motor_stribeck", "1", "1"),
            P::LoadExternalStribeck => ("load_external_stribeck", "1", "1"),
            P::LoadMotorQuadratic => ("load_motor_quadratic", "1/(N·m)", "1"),
            P::LoadExternalQuadratic => ("load_external_quadratic", "1/(N·m)", "1"),
            P::LogStribeckVelocity => ("stribeck_velocity", "rad/s", "rad/s"),
            P::StribeckExponent => ("stribeck_exponent", "1", "1"),
            P::ZeroOffset => ("zero_offset", "rad", "rad"),
        };
        let is_torque = matches!(
            parameter,
            P::TorquePerCommand | P::Armature | P::Viscous | P::Coulomb | P::Stribeck
        );
        match (self.scale, self.is_voltage) {
            (Scale::None, true) if is_torque => (name, relative_to_volt(relative)),
            (Scale::None, false) if is_torque => (name, relative_to_ampere(relative)),
            _ => (name, unit),
        }
    }
}

/// Returns the unit of a torque parameter in units of the torque per volt.
fn relative_to_volt(unit: &'static str) -> &'static str {
    match unit {
        "s²/rad" => "V·s²/rad",
        "s/rad" => "V·s/rad",
        _ => "V",
    }
}

/// Returns the unit of a torque parameter in units of the torque per ampere.
fn relative_to_ampere(unit: &'static str) -> &'static str {
    match unit {
        "s²/rad" => "A·s²/rad",
        "s/rad" => "A·s/rad",
        _ => "A",
    }
}

/// Returns the drive law of a servo.
fn law(drive: &ServoDrive) -> DriveLaw {
    let size = if drive.applies_voltage() {
        drive.supply_v.unwrap_or(1.0)
    } else {
        1.0
    };
    let gain = drive.gain_duty_per_rad.or(drive.gain_a_per_rad);
    let damping = drive.damping_duty_s_per_rad.or(drive.damping_as_per_rad);
    let limit = if drive.applies_voltage() {
        drive.duty_limit.unwrap_or(1.0)
    } else {
        drive.current_limit_a.unwrap_or(f64::INFINITY)
    };
    DriveLaw {
        gain: size * gain.unwrap_or(0.0),
        damping: size * damping.unwrap_or(0.0),
        limit: size * limit,
    }
}

/// Returns whether gravity acts on a load.
pub(super) fn weighs(load: &Load) -> bool {
    load.sine.hypot(load.cosine) > WEIGHTLESS
}

/// Returns the known load of a robot with one joint: its link, and a payload.
fn load(robot: &Robot, payload: Option<&Payload>) -> Load {
    let Some(tree) = &robot.tree else {
        return Load::default();
    };
    let link = tree.links.first().map_or("link1", String::as_str);
    let mut body = tree.inertial.first().copied().flatten().unwrap_or_default();
    for (value, name) in body.iter_mut().zip(BODY_NAMES) {
        let name = format!("{link}.{name}");
        let given = robot.fixed.get(&name).or_else(|| robot.nominal.get(&name));
        *value = given.copied().unwrap_or(*value);
    }
    if let Some(payload) = payload.and_then(Payload::known) {
        for (value, more) in body.iter_mut().zip(payload) {
            *value += more;
        }
    }
    // The torque that moves the link, without gravity and without motion.
    let torque = |gravity: [f64; 3], angle: f64, acceleration: f64| {
        let mut tau = [0.0];
        let moved = Chain::new(&tree.joints, gravity).ok().and_then(|chain| {
            let mut steps = [Step::default()];
            let motion = ([angle], [0.0], [acceleration]);
            let (q, dq, ddq) = (&motion.0, &motion.1, &motion.2);
            inverse_dynamics(&chain, &[body], q, dq, ddq, &mut steps, &mut tau).ok()
        });
        moved.map_or(0.0, |()| tau[0])
    };
    let gravity = robot.gravity();
    Load {
        inertia: torque([0.0; 3], 0.0, 1.0),
        sine: -torque(gravity, std::f64::consts::FRAC_PI_2, 0.0),
        cosine: -torque(gravity, 0.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{no_files, read};

    #[test]
    fn a_mass_on_an_arm_is_a_pendulum() {
        let text = r#"
format = 1
[robot]
dh_modified = [{ alpha_deg = 90, theta_deg = -90 }]
nominal = { "link1.izz" = 0.001, "link1.mx" = 0.02 }
[[robot.joint]]
name = "servo"
transmission = "rigid"
servo = { gain_duty_per_rad = 5.0, supply_v = 12.0, duty_limit = 0.9 }
[log]
period_s = 0.005
file = [{ path = "a.csv", payload = { mass_kg = 0.5, com_m = [0.2, 0.0, 0.01] } }, "b.csv"]
motor_target_rad = ["target"]
motor_position_rad = ["position"]
"#;
        let experiment = read("experiment.toml", text, &[], &mut no_files).unwrap();
        let files = experiment.log.as_ref().unwrap().file.clone().unwrap();
        let bench = Bench::new(&experiment, &files).unwrap();
        assert!((bench.law.gain - 60.0).abs() < 1e-12 && (bench.law.limit - 10.8).abs() < 1e-12);
        let [loaded, empty] = &bench.loads[..] else {
            panic!("two files")
        };
        for (load, mass_times_arm, inertia) in [(loaded, 0.12, 0.021), (empty, 0.02, 0.001)] {
            assert!(
                (load.sine + 9.81 * mass_times_arm).abs() < 1e-12,
                "{load:?}"
            );
            assert!(load.cosine.abs() < 1e-12);
            assert!((load.inertia - inertia).abs() < 1e-12);
        }
        assert_eq!(bench.scale, Scale::KnownLoad);
        assert_eq!(bench.unknown().len(), ServoParameter::COUNT);
    }
}
