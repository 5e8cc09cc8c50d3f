//! A designed motion with its files and curves: coefficients, used limits, the moving arm.

use std::f64::consts::TAU;

use sprung_method::excite::{
    Approach, Frequencies, JointMotion, Kept, LimitUsed, Limited, MotionResult, Plan, Series,
    Skeleton,
};

use super::task::Setup;
use crate::session::excite_error::unit;

/// Frames of the moving arm.
const FRAMES: usize = 300;

impl Setup {
    /// Returns a motion with its coefficients.
    pub(super) fn motion(
        &self,
        series: &Series,
        frequencies: &Frequencies,
        approach: Option<&Approach>,
    ) -> MotionResult {
        let joints = self.model.joints().iter().zip(&series.joints).enumerate();
        let side = |coefficients: &[f64], side: usize| {
            coefficients[1..]
                .iter()
                .skip(side)
                .step_by(2)
                .copied()
                .collect()
        };
        MotionResult {
            duration_s: frequencies.duration(),
            approach_s: approach.map_or(0.0, |approach| approach.duration),
            base_frequency_hz: frequencies.rate / TAU,
            harmonics: frequencies.harmonics.clone(),
            periods: frequencies.periods,
            joints: joints
                .map(|(joint, (name, coefficients))| JointMotion {
                    joint: name.clone(),
                    centre_rad: coefficients[0],
                    start_rad: series.at(joint, 0.0)[0],
                    sine_rad: side(coefficients, 0),
                    cosine_rad: side(coefficients, 1),
                })
                .collect(),
        }
    }

    /// Returns the used part of each limit, the largest first.
    pub(super) fn limits(&self, certified: &[Kept], simulated: &[Kept]) -> Vec<LimitUsed> {
        let all = [(certified, "between samples"), (simulated, "simulated")];
        let mut rows: Vec<LimitUsed> = Vec::new();
        for (kept, shown) in all {
            for limit in kept {
                let row = self.limit(limit, shown);
                let same = |other: &&mut LimitUsed| {
                    other.joint == row.joint && other.quantity == row.quantity
                };
                match rows.iter_mut().find(same) {
                    Some(known) if known.used_percent >= row.used_percent => {}
                    Some(known) => *known = row,
                    None => rows.push(row),
                }
            }
        }
        rows.sort_by(|a, b| b.used_percent.total_cmp(&a.used_percent));
        rows
    }

    fn limit(&self, kept: &Kept, shown: &str) -> LimitUsed {
        let is_tool = kept.what == Limited::ToolSpeed;
        let interval = if is_tool {
            self.bounds.tool_speed
        } else {
            self.bounds.joints[kept.joint].of(kept.what)
        };
        let is_height = kept.what == Limited::Height;
        LimitUsed {
            joint: (!is_tool).then(|| self.model.joints()[kept.joint].clone()),
            quantity: kept.what.word().to_owned(),
            unit: unit(kept.what, &self.model, kept.joint),
            lowest: if is_height {
                self.bounds.floor
            } else {
                Some(interval.middle - interval.half)
            },
            highest: (!is_height).then_some(interval.middle + interval.half),
            used_percent: 100.0 * kept.part,
            time_s: kept.time_s,
            shown: shown.to_owned(),
        }
    }

    /// Returns the moving arm; `None` without lengths.
    pub(super) fn skeleton(&self, plan: &Plan) -> Option<Skeleton> {
        let kinematics = self.kinematics.as_ref()?;
        let simulation = &plan.certificate.simulation;
        let every = simulation.time_s.len().div_ceil(FRAMES).max(1);
        let n = self.model.joint_count();
        let mut skeleton = Skeleton {
            parents: kinematics.parents(),
            ..Skeleton::default()
        };
        skeleton.parents.push(Some(n - 1));
        let upright = upright(kinematics.up);
        for t in (0..simulation.time_s.len()).step_by(every) {
            let q: Vec<f64> = (0..n).map(|joint| simulation.link[joint][t]).collect();
            let places = kinematics.places(&q, &vec![0.0; n]);
            skeleton.time_s.push(simulation.time_s[t]);
            let turned = |point: &[f64; 3]| {
                upright.map(|axis| axis.iter().zip(point).map(|(a, x)| a * x).sum())
            };
            skeleton
                .points
                .push(places.points.iter().map(turned).collect());
        }
        Some(skeleton)
    }
}

/// Returns axes of a frame whose z axis is `up`, one per row.
fn upright(up: [f64; 3]) -> [[f64; 3]; 3] {
    let other = if up[0].abs() < 0.9 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let along: f64 = other.iter().zip(up).map(|(a, b)| a * b).sum();
    let x = [0, 1, 2].map(|i| other[i] - along * up[i]);
    let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let x = x.map(|x| x / length);
    let y = [
        up[1] * x[2] - up[2] * x[1],
        up[2] * x[0] - up[0] * x[2],
        up[0] * x[1] - up[1] * x[0],
    ];
    [x, y, up]
}
