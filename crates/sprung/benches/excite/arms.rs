//! Random arms with random limits: each motion is certified, or refused with the reason.

use std::fmt::Write as _;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sprung::session::{ExciteMethod, Session};
use sprung_method::excite::Excited;
use sprung_testing::Figure;

use super::excite;

/// Time of a design that is named, s.
const SLOW_S: f64 = 10.0;

/// Period of the controllers, s.
const PERIOD_S: f64 = 1e-3;

/// A link and its joint.
pub(crate) struct Link {
    pub(crate) xyz: [f64; 3],
    pub(crate) rpy: [f64; 3],
    pub(crate) axis: [f64; 3],
    pub(crate) mass: f64,
    pub(crate) centre: [f64; 3],
    pub(crate) radius: f64,
    pub(crate) range: [f64; 2],
    pub(crate) torque: f64,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
    pub(crate) rotor: f64,
    pub(crate) viscous: f64,
    pub(crate) coulomb: f64,
    pub(crate) stiffness: Option<f64>,
}

/// A serial arm.
pub(crate) struct Arm {
    pub(crate) links: Vec<Link>,
}

impl Arm {
    fn urdf(&self) -> String {
        let list = |v: &[f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
        let mut text = "<robot name='arm'><link name='base'/>".to_owned();
        for (k, link) in self.links.iter().enumerate() {
            let inertia = 0.4 * link.mass * link.radius * link.radius;
            write!(text, "<link name='l{k}'><inertial><origin xyz='{}'/><mass value='{}'/><inertia ixx='{inertia}' iyy='{inertia}' \
                 izz='{inertia}' ixy='0' ixz='0' iyz='0'/></inertial></link>\
                 <joint name='j{k}' type='revolute'><parent link='{}'/><child link='l{k}'/><origin xyz='{}' rpy='{}'/>\
                 <axis xyz='{}'/><limit lower='{}' upper='{}' effort='{}' velocity='{}'/></joint>",
                list(&link.centre),
                link.mass,
                if k == 0 { "base".to_owned() } else { format!("l{}", k - 1) },
                list(&link.xyz),
                list(&link.rpy),
                list(&link.axis),
                link.range[0],
                link.range[1],
                link.torque,
                link.velocity
            ).expect("text");
        }
        text.push_str("</robot>");
        text
    }

    /// Returns the session of the arm.
    pub(crate) fn session(&self, set: &[String]) -> Session {
        self.session_with(set, "")
    }

    fn session_with(&self, set: &[String], reference: &str) -> Session {
        super::session_with(&self.experiment(), set, &self.urdf(), reference)
    }

    /// Writes the experiment and the URDF into a folder.
    pub(crate) fn write(&self, folder: &Path) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join("experiment.toml"), self.experiment())?;
        std::fs::write(folder.join("arm.urdf"), self.urdf())
    }

    fn experiment(&self) -> String {
        let mut text = "format = 1\n[robot]\nname = \"arm\"\nurdf = \"arm.urdf\"\n".to_owned();
        for (k, link) in self.links.iter().enumerate() {
            let (transmission, spring) = match link.stiffness {
                None => ("rigid", String::new()),
                Some(stiffness) => ("flexible", format!(", stiffness = {stiffness}")),
            };
            write!(text, "[[robot.joint]]\nname = \"j{k}\"\ntransmission = \"{transmission}\"\nlimits = {{ acceleration_rad_per_s2 = {}, \
                 jerk_rad_per_s3 = {} }}\nnominal = {{ rotor_inertia = {}, motor_viscous = {}, motor_coulomb = {}{spring} }}\n",
                link.acceleration, link.jerk, link.rotor, link.viscous, link.coulomb
            ).expect("text");
        }
        text
    }

    /// Returns a random arm of two to seven joints.
    fn random(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let n = rng.random_range(2..=7);
        let is_flexible = rng.random_bool(0.3);
        // Some arms are too weak for their weight.
        let strength = if rng.random_bool(0.15) { 0.1 } else { 1.0 };
        let mut links: Vec<Link> = Vec::new();
        for k in 0..n {
            let size = 0.4 * 0.8_f64.powi(k);
            let mut within = |most: f64| rng.random_range(-most..most);
            let xyz = [within(size), within(size), within(size)];
            let centre = [within(0.5 * size), within(0.5 * size), within(0.5 * size)];
            let middle = within(1.0);
            let axis = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]][rng.random_range(0..3)];
            let half = rng.random_range(0.5..2.5);
            let mass = 4.0 * 0.75_f64.powi(k) * rng.random_range(0.5..1.5);
            let weight = 9.81 * 8.0 * 0.75_f64.powi(k) * size;
            let torque = strength * weight * rng.random_range(1.0..3.0);
            let acceleration = rng.random_range(2.0..20.0);
            links.push(Link {
                xyz,
                rpy: [0.0; 3],
                axis,
                mass,
                centre,
                radius: 0.05,
                range: [middle - half, middle + half],
                torque,
                velocity: rng.random_range(0.5..4.0),
                acceleration,
                jerk: acceleration * rng.random_range(10.0..500.0),
                rotor: 0.02 * torque / 9.81,
                viscous: 0.01 * torque,
                coulomb: 0.02 * torque,
                stiffness: is_flexible.then_some(20.0 * torque),
            });
        }
        Self { links }
    }
}

/// Checks the samples of a motion, and the torques of the loop at ten times their rate; returns the first broken limit.
fn broken(arm: &Arm, session: &Session, found: &Excited) -> Option<String> {
    let dense = [format!("excite.period_s={}", 0.1 * PERIOD_S)];
    let dense = arm.session_with(&dense, &super::reference(session, found));
    let dense = match super::judged(&dense) {
        Ok(judged) => judged,
        Err(error) => return Some(error.to_string()),
    };
    let trajectory = &found.trajectory;
    for (joint, link) in arm.links.iter().enumerate() {
        let most = |list: &[f64]| list.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let position = &trajectory.position[joint];
        if position
            .iter()
            .any(|q| !(link.range[0]..=link.range[1]).contains(q))
        {
            return Some(format!("position of j{joint}"));
        }
        if most(&trajectory.velocity[joint]) > link.velocity {
            return Some(format!("velocity of j{joint}"));
        }
        if most(&trajectory.acceleration[joint]) > link.acceleration {
            return Some(format!("acceleration of j{joint}"));
        }
        let steps = trajectory.acceleration[joint]
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs());
        let jerk = steps.fold(0.0, f64::max) / (trajectory.time_s[1] - trajectory.time_s[0]);
        if jerk > 1.001 * link.jerk {
            return Some(format!("jerk of j{joint}: {jerk} {}", link.jerk));
        }
        let torque = most(&dense.simulation.torque[joint]);
        if torque > link.torque {
            return Some(format!("torque of j{joint}: {torque} {}", link.torque));
        }
    }
    None
}

pub(crate) fn run(first: u64, count: u64) {
    let (mut certified, mut refused, mut wrong) = (0, 0, 0);
    let started = std::time::Instant::now();
    for seed in first..first + count {
        let arm = Arm::random(seed);
        let session = arm.session(&["excite.steps=20".to_owned(), "excite.starts=2".to_owned()]);
        let before = started.elapsed().as_secs_f64();
        let outcome = excite(&session, ExciteMethod::Optimal, None);
        let time = started.elapsed().as_secs_f64() - before;
        if time > SLOW_S {
            let flexible = arm.links[0].stiffness.is_some();
            println!(
                "{seed}: {time:.0} s, {} joints, springs: {flexible}",
                arm.links.len()
            );
        }
        match outcome {
            Ok(found) => match broken(&arm, &session, &found) {
                None => certified += 1,
                Some(what) => {
                    wrong += 1;
                    println!("{seed}: {what} is broken");
                }
            },
            Err(error) => {
                let feasible = (0..200).into_par_iter().any(|k| {
                    let session = arm.session(&[format!("excite.seed={}", 7000 + k)]);
                    excite(&session, ExciteMethod::Random, None)
                        .is_ok_and(|excited| excited.excitation.is_certified)
                });
                if feasible {
                    wrong += 1;
                    println!("{seed}: refused, but a random series is feasible: {error}");
                } else {
                    refused += 1;
                    println!("{seed}: {error}");
                }
            }
        }
    }
    println!(
        "{count} arms: {certified} certified, {refused} refused where no random series is feasible, {wrong} wrong; {:.0} s",
        started.elapsed().as_secs_f64()
    );
    let note = |name: &str, text: &str, value: usize| {
        let text = format!("{count} random arms with random limits: {text}");
        Figure::neutral(name, &text, value as f64, "").note();
    };
    note("certified", "certified motions", certified);
    note(
        "refused",
        "refused, as no random series is feasible",
        refused,
    );
    note("wrong", "a limit broken, or refused without need", wrong);
}
