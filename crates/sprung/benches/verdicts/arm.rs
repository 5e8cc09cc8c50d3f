//! Arms of random size: kinematics, bodies, drives, sensors and a controller.

use std::collections::BTreeMap;
use std::fmt::Write;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Largest number of joints.
pub(crate) const MAX_JOINTS: usize = 7;

/// Acceleration of gravity, m/s².
const GRAVITY: f64 = 9.81;

/// β of the friction of all joints, s/rad.
const SHARPNESS: f64 = 100.0;

/// A link with its joint.
#[derive(Clone)]
struct Link {
    // Craig: α of the previous axis, rad; a and d, m.
    alpha: f64,
    a: f64,
    d: f64,
    /// Mass, kg, centre of mass and edges of a box, m.
    mass: f64,
    com: [f64; 3],
    size: [f64; 3],
}

/// The drive of a joint, on the output side of its gearbox.
#[derive(Clone)]
pub(crate) struct Drive {
    /// Usual torque, N·m.
    pub(crate) effort: f64,
    /// Motor turns per output turn.
    pub(crate) gear_ratio: f64,
    pub(crate) stiffness: f64,
    pub(crate) motor_coulomb: f64,
    rotor_inertia: f64,
    motor_viscous: f64,
    link_viscous: f64,
    link_coulomb: f64,
}

/// An arm.
#[derive(Clone)]
pub(crate) struct Arm {
    links: Vec<Link>,
    nominal: Vec<Link>,
    pub(crate) drives: Vec<Drive>,
}

impl Arm {
    /// Draws an arm with a number of joints.
    pub(crate) fn random(joints: usize, rng: &mut ChaCha8Rng) -> Self {
        let links: Vec<Link> = (0..joints).map(|i| Link::random(i, joints, rng)).collect();
        let nominal = links.iter().map(|link| link.on_datasheet(rng)).collect();
        let drives = (0..joints).map(|i| Drive::random(&links[i..], rng));
        Self {
            drives: drives.collect(),
            links,
            nominal,
        }
    }

    pub(crate) fn joints(&self) -> usize {
        self.links.len()
    }

    /// Returns the tables `[robot]` and `[[robot.joint]]`.
    ///
    /// - `laws`: further keys of each joint.
    pub(crate) fn robot(&self, laws: &[String]) -> String {
        let mut text = "[robot]\nname = \"arm\"\ndh_modified = [\n".to_owned();
        for link in &self.links {
            let (alpha, a, d) = (link.alpha.to_degrees(), link.a, link.d);
            line(
                &mut text,
                format_args!("  {{ alpha_deg = {alpha:.1}, a_m = {a:.4}, d_m = {d:.4} }},"),
            );
        }
        line(
            &mut text,
            format_args!("]\ngravity_m_per_s2 = [0.0, 0.0, -{GRAVITY}]\n\n[robot.nominal]"),
        );
        for (i, link) in self.nominal.iter().enumerate() {
            for (name, value) in link.standard_parameters(i + 1) {
                line(&mut text, format_args!("\"{name}\" = {value:e}"));
            }
        }
        for (i, drive) in self.drives.iter().enumerate() {
            line(
                &mut text,
                format_args!(
                    "\n[[robot.joint]]\nname = \"joint{}\"\ngear_ratio = {:.1}\n\
                     coulomb_sharpness_s_per_rad = {SHARPNESS:.1}\n{}",
                    i + 1,
                    drive.gear_ratio,
                    laws.get(i).map_or("", String::as_str)
                ),
            );
        }
        text
    }

    /// Returns the tables `[log]` and `[controller]`, with the gains of the motors' feedback.
    pub(crate) fn log_and_controller(&self) -> String {
        let columns = |name: &str, unit: &str| {
            let all: Vec<String> = (1..=self.joints())
                .map(|i| format!("\"{name}{i}_{unit}\""))
                .collect();
            all.join(", ")
        };
        let gains = |of: &dyn Fn(&Drive) -> f64| {
            let all: Vec<String> = self
                .drives
                .iter()
                .map(|d| format!("{:.4}", of(d)))
                .collect();
            all.join(", ")
        };
        format!(
            "\n[log]\nfile = \"log.csv\"\ntime_s = \"t_s\"\nlink_position_rad = [{}]\n\
             motor_position_rad = [{}]\nmotor_torque_nm = [{}]\n\n[controller]\nkind = \"pd\"\n\
             kp_nm_per_rad = [{}]\nkd_nms_per_rad = [{}]\nvelocity_window = [2, 2]\n",
            columns("q", "rad"),
            columns("phi", "rad"),
            columns("tau", "nm"),
            gains(&|drive| drive.gains().0),
            gains(&|drive| drive.gains().1),
        )
    }

    /// Returns the true values by name: of single links, and of the joints.
    pub(crate) fn truth(&self) -> BTreeMap<String, f64> {
        let mut values = BTreeMap::new();
        for (i, link) in self.links.iter().enumerate() {
            values.extend(link.standard_parameters(i + 1));
        }
        for (i, drive) in self.drives.iter().enumerate() {
            for (name, value) in [
                ("rotor_inertia", drive.rotor_inertia),
                ("stiffness", drive.stiffness),
                ("motor_viscous", drive.motor_viscous),
                ("motor_coulomb", drive.motor_coulomb),
                ("link_viscous", drive.link_viscous),
                ("link_coulomb", drive.link_coulomb),
            ] {
                values.insert(format!("joint{}.{name}", i + 1), value);
            }
        }
        values
    }
}

/// Writes a line; a string takes any text.
fn line(text: &mut String, words: std::fmt::Arguments<'_>) {
    writeln!(text, "{words}").expect("a string takes any text");
}

impl Link {
    fn random(index: usize, joints: usize, rng: &mut ChaCha8Rng) -> Self {
        let quarter = std::f64::consts::FRAC_PI_2;
        let alpha = match (index, rng.random_range(0..3)) {
            (_, 0) => 0.0,
            // The first axis is horizontal or vertical.
            (0, _) | (_, 1) => quarter,
            _ => -quarter,
        };
        let reach = rng.random_range(0.15..0.45);
        let (a, d) = if rng.random::<bool>() {
            (reach, 0.0)
        } else {
            (0.05, reach)
        };
        let mass = rng.random_range(1.0..4.0) * (joints - index) as f64 / joints as f64 + 0.6;
        let size = [
            reach,
            rng.random_range(0.05..0.15),
            rng.random_range(0.05..0.15),
        ];
        let mut com = [0.0; 3];
        com[0] = 0.5 * reach * rng.random_range(0.5..1.2);
        com[1] = rng.random_range(-0.04..0.04);
        com[2] = rng.random_range(-0.08..0.08);
        Self {
            alpha,
            a: if index == 0 { 0.0 } else { a },
            d: if index == 0 { 0.0 } else { d },
            mass,
            com,
            size,
        }
    }

    /// Returns the link of a datasheet: mass, centre of mass and size are roughly right.
    fn on_datasheet(&self, rng: &mut ChaCha8Rng) -> Self {
        let mut link = self.clone();
        link.mass *= rng.random_range(0.75..1.3);
        for x in &mut link.com {
            *x += rng.random_range(-0.01..0.01);
        }
        for edge in &mut link.size {
            *edge *= rng.random_range(0.85..1.15);
        }
        link
    }

    /// Returns mass, first moments and inertias about the origin of the joint's frame.
    fn standard_parameters(&self, number: usize) -> Vec<(String, f64)> {
        let (m, c) = (self.mass, self.com);
        let squares: f64 = c.iter().map(|x| x * x).sum();
        let edges: f64 = self.size.iter().map(|x| x * x).sum();
        let diagonal =
            |i: usize| m * ((edges - self.size[i].powi(2)) / 12.0 + squares - c[i] * c[i]);
        let product = |i: usize, j: usize| -m * c[i] * c[j];
        [
            ("m", m),
            ("mx", m * c[0]),
            ("my", m * c[1]),
            ("mz", m * c[2]),
            ("ixx", diagonal(0)),
            ("ixy", product(0, 1)),
            ("iyy", diagonal(1)),
            ("ixz", product(0, 2)),
            ("iyz", product(1, 2)),
            ("izz", diagonal(2)),
        ]
        .map(|(name, value)| (format!("link{number}.{name}"), value))
        .into()
    }
}

impl Drive {
    /// Draws a drive that can carry its link and all further links.
    fn random(carried: &[Link], rng: &mut ChaCha8Rng) -> Self {
        let (mut lever, mut inertia, mut torque) = (0.0, 0.0, 0.0);
        for link in carried {
            let arm = lever + link.com[0].abs();
            inertia += link.mass * (arm * arm + 0.01);
            torque += link.mass * GRAVITY * arm;
            lever += link.a + link.d;
        }
        let effort: f64 = 1.3 * torque + 3.0;
        let rotor_inertia = (inertia * rng.random_range(0.3..1.0)).max(0.02);
        Self {
            effort,
            gear_ratio: rng.random_range(50..161).into(),
            stiffness: (effort * rng.random_range(80.0..300.0)).clamp(300.0, 3e4),
            rotor_inertia,
            motor_viscous: effort * rng.random_range(0.03..0.15),
            motor_coulomb: effort * rng.random_range(0.02..0.08),
            link_viscous: effort * rng.random_range(0.002..0.02),
            link_coulomb: effort * rng.random_range(0.002..0.01),
        }
    }

    /// Returns the gains of the feedback of the motor position, N·m/rad, and of its velocity,
    /// N·m·s/rad.
    fn gains(&self) -> (f64, f64) {
        const BANDWIDTH_RAD_PER_S: f64 = 25.0;
        let moved = 2.5 * self.rotor_inertia;
        let kp = (moved * BANDWIDTH_RAD_PER_S.powi(2)).max(10.0 * self.effort);
        (kp, moved * BANDWIDTH_RAD_PER_S)
    }
}
