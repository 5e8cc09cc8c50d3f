//! The motion of a log: its reference, its duration and the disturbances that act.

use std::fmt::Write;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sprung_robot::{self as description, Simulate};

use crate::arm::Arm;
use crate::kind::{Fault, Kind, Weak};

/// Number of sines of each joint.
const SINES: usize = 4;

/// Returns a random reference.
pub(crate) fn reference(
    fault: Fault,
    joints: usize,
    seed: u64,
    rng: &mut ChaCha8Rng,
) -> description::Reference {
    let (mut amplitude, mut pace) = (1.0, 1.0);
    match fault {
        Fault::Weak(Weak::Small(by)) => amplitude = by,
        Fault::Weak(Weak::Slow(by)) => pace = by,
        _ => {}
    }
    let mut text = "[reference]\ncentre_deg = [".to_owned();
    for joint in 0..joints {
        let centre = [20.0, -35.0, 30.0, -60.0, 15.0, 45.0, -25.0][joint];
        write!(text, "{centre:.1}, ").expect("a string takes any text");
    }
    text.push_str("]\nsines = [\n");
    // Each sine has its band.
    let draw = |sine: usize, rng: &mut ChaCha8Rng| {
        pace * (0.1 + 0.275 * (sine as f64 + rng.random::<f64>()))
    };
    let common: Vec<f64> = (0..SINES).map(|sine| draw(sine, rng)).collect();
    let directions: Vec<f64> = (0..joints)
        .map(|_| if rng.random::<bool>() { 90.0 } else { -90.0 })
        .collect();
    for (joint, direction) in directions.into_iter().enumerate() {
        let mut part = amplitude;
        if let Fault::Weak(Weak::OneStill(by)) = fault
            && joint == seed as usize % joints
        {
            part = by;
        }
        let phase = match fault {
            Fault::Weak(Weak::InPhase) => 90.0,
            _ => direction,
        };
        // The sum of the reference and of its velocity is zero at the start.
        let (one, two) = (rng.random_range(4.0..12.0), rng.random_range(4.0..12.0));
        let share = rng.random_range(0.4..0.6);
        let sizes = [one, two, share * (one + two), (1.0 - share) * (one + two)];
        for sine in 0..SINES {
            let frequency = match fault {
                Fault::Weak(Weak::OneFrequency) if sine < 2 => 0.4 * pace,
                Fault::Weak(Weak::OneFrequency) => 0.8 * pace,
                Fault::Weak(Weak::InPhase) => common[sine],
                _ => draw(sine, rng),
            };
            let (size, phase) = (part * sizes[sine], if sine < 2 { phase } else { -phase });
            writeln!(
                text,
                "  {{ joint = \"joint{}\", amplitude_deg = {size:e}, frequency_hz = \
                 {frequency:e}, phase_deg = {phase:.1} }},",
                joint + 1
            )
            .expect("a string takes any text");
        }
    }
    text.push_str("]\n");
    let parsed: WithReference = toml::from_str(&text).expect("the reference is right");
    parsed.reference
}

/// A controller's reference alone.
#[derive(serde::Deserialize)]
struct WithReference {
    reference: description::Reference,
}

/// Draws duration, rate and disturbances.
pub(crate) fn settings(arm: &Arm, kind: Kind, fault: Fault, rng: &mut ChaCha8Rng) -> Simulate {
    let joints = arm.joints();
    let duration = match fault {
        Fault::Weak(Weak::Short(duration)) => duration,
        _ if joints <= 3 => 10.0,
        _ => 6.0,
    };
    let period = if joints == 1 && rng.random::<bool>() {
        2e-3
    } else {
        1e-3
    };
    // Slow torques that the motion does not explain act on some robots.
    let disturbed = kind == Kind::Matched && rng.random_range(0..10) < 4;
    let disturbance = if disturbed {
        rng.random_range(0.001..0.01)
    } else {
        0.0
    };
    let disturbances: Vec<String> = (arm.drives.iter())
        .map(|drive| format!("{:e}", disturbance * drive.effort))
        .collect();
    toml::from_str(&format!(
        "duration_s = {duration:.3}\nperiod_s = {period}\nseed = 1\n\
         torque_disturbance_nm = [{}]\n",
        disturbances.join(", ")
    ))
    .expect("the settings are right")
}
