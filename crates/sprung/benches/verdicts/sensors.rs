//! The sensors of an arm.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::arm::Arm;
use crate::kind::{Fault, Weak};

/// The sensors of an arm. The zeros of its encoders are the same in all logs.
pub(crate) struct Sensors {
    /// Smallest step of each encoder, rad, and its zero in steps: links, then motors.
    pub(crate) encoders: Vec<(f64, f64)>,
    /// Standard deviations of the logged torques, N·m.
    pub(crate) torque_noise: Vec<f64>,
}

impl Sensors {
    pub(crate) fn random(arm: &Arm, fault: Fault, rng: &mut ChaCha8Rng) -> Self {
        let link = 1_u32 << rng.random_range(14..20);
        let motor = 1_u32 << rng.random_range(10..13);
        let noise = rng.random_range(0.0005..0.01);
        let before_gears = (arm.drives.iter()).map(|drive| motor * drive.gear_ratio as u32);
        let counts: Vec<u32> = match fault {
            Fault::Weak(Weak::Coarse(counts)) => vec![counts; 2 * arm.joints()],
            _ => std::iter::repeat_n(link, arm.joints())
                .chain(before_gears)
                .collect(),
        };
        Self {
            encoders: (counts.into_iter())
                .map(|counts| {
                    let step = std::f64::consts::TAU / f64::from(counts);
                    (
                        step,
                        rng.random::<f64>() + rng.random_range(-3e-4..3e-4) / step,
                    )
                })
                .collect(),
            torque_noise: (arm.drives.iter())
                .map(|drive| noise * drive.effort)
                .collect(),
        }
    }

    /// Returns the torque of each spring at equal readings of its encoders, N·m.
    pub(crate) fn preloads(&self, arm: &Arm) -> Vec<f64> {
        // A count represents the middle of its step.
        let zero = |(step, phase): (f64, f64)| step * (phase - 0.5);
        (arm.drives.iter().enumerate())
            .map(|(joint, drive)| {
                let [link, motor] = [joint, arm.joints() + joint].map(|i| zero(self.encoders[i]));
                drive.stiffness * (motor - link)
            })
            .collect()
    }
}
