//! An arm with the kinematics and limits of the Franka Panda: the designed motion beside random series.

use rayon::prelude::*;
use sprung::session::ExciteMethod;
use sprung_testing::Figure;

use super::arms::{Arm, Link};
use super::{errors, excite, mean_ratio};

/// Accelerations, rad/s²; the jerks are 500 times as large.
const ACCELERATIONS: [f64; 7] = [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0];

pub(crate) fn arm() -> Arm {
    use std::f64::consts::FRAC_PI_2 as Q;
    // Place, roll, mass, half length, range, torque, velocity.
    let links = [
        ([0.0, 0.0, 0.333], 0.0, 3.0, [-2.8973, 2.8973], 87.0, 2.175),
        ([0.0, 0.0, 0.0], -Q, 3.0, [-1.7628, 1.7628], 87.0, 2.175),
        ([0.0, -0.316, 0.0], Q, 2.9, [-2.8973, 2.8973], 87.0, 2.175),
        ([0.0825, 0.0, 0.0], Q, 2.6, [-3.0718, -0.0698], 87.0, 2.175),
        (
            [-0.0825, 0.384, 0.0],
            -Q,
            2.7,
            [-2.8973, 2.8973],
            12.0,
            2.61,
        ),
        ([0.0, 0.0, 0.0], Q, 1.6, [-0.0175, 3.7525], 12.0, 2.61),
        ([0.088, 0.0, 0.0], Q, 1.2, [-2.8973, 2.8973], 12.0, 2.61),
    ];
    let centres = [
        [0.0, -0.03, -0.07],
        [0.0, -0.12, 0.03],
        [0.04, 0.02, -0.05],
        [-0.04, 0.09, 0.02],
        [0.0, 0.04, -0.11],
        [0.06, -0.02, 0.0],
        [0.01, 0.01, 0.08],
    ];
    Arm {
        links: (links.into_iter().zip(centres).zip(ACCELERATIONS))
            .map(
                |(((xyz, roll, mass, range, torque, velocity), centre), acceleration)| Link {
                    xyz,
                    rpy: [roll, 0.0, 0.0],
                    axis: [0.0, 0.0, 1.0],
                    mass,
                    centre,
                    radius: 0.06,
                    range,
                    torque,
                    velocity,
                    acceleration,
                    jerk: 500.0 * acceleration,
                    rotor: 0.1,
                    viscous: 1.0,
                    coulomb: 0.5,
                    stiffness: None,
                },
            )
            .collect(),
    }
}

pub(crate) fn run(random: u64) {
    let arm = arm();
    for steps in [1, 100, 400] {
        let session = arm.session(&[format!("excite.steps={steps}")]);
        let started = std::time::Instant::now();
        let found = excite(&session, ExciteMethod::Optimal, None).expect("a motion");
        let time = started.elapsed().as_secs_f64();
        println!(
            "{steps} steps: objective {:.4}, condition number of the links {:.1}, {time:.1} s",
            found.excitation.search.objective,
            found.excitation.links_condition_number.unwrap_or(f64::NAN)
        );
        if steps < 400 {
            continue;
        }
        let text = "limits of a Franka Panda, 10 s: condition number of the links";
        let condition = found.excitation.links_condition_number.unwrap_or(f64::NAN);
        Figure::lower("condition", text, condition, "").note();
        Figure::lower("search", "the same: the whole search", time, "s").note();
        let reference_errors = errors(&found);
        let all: Vec<(f64, f64)> = (0..random)
            .into_par_iter()
            .map(|seed| {
                let session = arm.session(&[format!("excite.seed={}", 1000 + seed)]);
                let found = excite(&session, ExciteMethod::Random, None).expect("a series");
                (
                    found.excitation.search.objective,
                    mean_ratio(&errors(&found), &reference_errors),
                )
            })
            .collect();
        let best = all.iter().min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((objective, ratio)) = best {
            println!(
                "best of {random} random series: determinant to the power 1/p smaller by {:.2} (surrogate), standard errors larger \
                 by {ratio:.2} (bound)",
                (2.0 * (objective - found.excitation.search.objective)).exp()
            );
            let text = format!(
                "the same: standard errors of the best of {random} random series over those of the designed motion"
            );
            Figure::higher("random", &text, *ratio, "times").note();
        }
        for seed in [2, 3] {
            let session = arm.session(&[
                format!("excite.steps={steps}"),
                format!("excite.seed={seed}"),
            ]);
            let other = excite(&session, ExciteMethod::Optimal, None).expect("a motion");
            println!(
                "seed {seed}: objective {:+.1} %",
                100.0 * (other.excitation.search.objective - found.excitation.search.objective)
            );
        }
    }
}
