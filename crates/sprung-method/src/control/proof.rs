//! Simulations of the designed loop with robots from the posterior.

use rayon::prelude::*;
use sprung_base::progress::{Listener, Phase};

use super::motions::{Designed, Plan, RESTS, Robot, Run, SETTLES};
use super::pictures::{Banded, ControlPictures, LinkCurves, Timed};
use super::refusal::ControlRefusal;
use super::result::{Moves, Proof, Tracking, WithDraws};
use super::task::ControlTask;

/// Most points of a curve.
const POINTS: usize = 1200;

/// Returns one motion of a robot.
type Pick<'p> = &'p dyn Fn(&Robot) -> Option<&Run>;

/// Simulates the loop with the identified robot and robots of the posterior.
///
/// # Errors
///
/// [`ControlRefusal`] if a torque reaches its limit or a loop runs away.
pub(super) fn prove(
    task: &ControlTask<'_>,
    designed: Designed<'_>,
    pictures: &mut ControlPictures,
    progress: &mut dyn Listener,
) -> Result<Proof, ControlRefusal> {
    let n = task.model.joint_count();
    let plan = Plan::new(task, designed);
    let count = 1 + task.settings.simulations.min(task.draws.len());
    let mut robots = Vec::with_capacity(count);
    // In blocks, for progress and stops.
    for first in (0..count).step_by(8) {
        progress.tell(Phase::Simulating, first as u64, Some(count as u64))?;
        let block: Vec<Result<Robot, ControlRefusal>> = (first..count.min(first + 8))
            .into_par_iter()
            .map(|robot| plan.of(robot))
            .collect();
        for robot in block {
            robots.push(robot?);
        }
    }
    let worst = |value: &dyn Fn(&Robot) -> f64| WithDraws {
        identified: value(&robots[0]),
        worst: robots.iter().map(value).fold(0.0, f64::max),
    };
    let tracking = match robots[0].designed {
        None => Vec::new(),
        Some(_) => (0..n)
            .map(|joint| {
                let of = |run: &Option<Run>| run.as_ref().map(|run| rms(task, run, joint));
                Tracking {
                    joint: task.model.joints()[joint].clone(),
                    declared_rad: of(&robots[0].declared),
                    designed_rad: worst(&|robot| of(&robot.designed).unwrap_or(0.0)),
                }
            })
            .collect(),
    };
    let vibration = |run: &Run| plan.vibration(run);
    let shortest = plan.way.iter().copied().fold(f64::INFINITY, f64::min);
    let percent = |robot: &Robot| {
        let [shaped, unshaped] = [&robot.shaped, &robot.unshaped].map(vibration);
        (unshaped > RESTS * shortest).then(|| 100.0 * shaped / unshaped)
    };
    let moves = Moves {
        duration_s: plan.duration,
        way_rad: plan.way.clone(),
        unshaped_rad: worst(&|robot| vibration(&robot.unshaped)),
        shaped_rad: worst(&|robot| vibration(&robot.shaped)),
        largest_percent: robots.iter().filter_map(percent).max_by(f64::total_cmp),
        limit_cycles: robots
            .iter()
            .filter(|robot| plan.goes_on(&robot.shaped))
            .count(),
    };
    let has_limit = task.torque_limits.iter().any(|limit| limit.is_finite());
    let torques = robots.iter().flat_map(|robot| {
        let runs = robot
            .designed
            .iter()
            .chain([&robot.unshaped, &robot.shaped]);
        runs.flat_map(|run| run.torque.iter().copied())
    });
    let torque_percent = has_limit.then(|| 100.0 * torques.fold(0.0, f64::max));
    draw(task, &plan, &robots, pictures);
    Ok(Proof {
        robots: count,
        tracking,
        moves,
        torque_percent,
    })
}

/// Returns the first sample of a run along the reference that counts.
fn settled(task: &ControlTask<'_>, run: &Run) -> usize {
    ((SETTLES / task.period) as usize).min(run.links.len() / 2)
}

fn rms(task: &ControlTask<'_>, run: &Run, joint: usize) -> f64 {
    let errors = (run.links.iter().zip(&run.wanted)).skip(settled(task, run));
    let (mut sum, mut count) = (0.0, 0.0);
    for (link, wanted) in errors {
        sum += (link[joint] - wanted[joint]).powi(2);
        count += 1.0;
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Writes the curves of the simulated motions.
fn draw(
    task: &ControlTask<'_>,
    plan: &Plan<'_, '_>,
    robots: &[Robot],
    pictures: &mut ControlPictures,
) {
    let steps = |run: &Run| run.links.len().div_ceil(POINTS).max(1);
    let timed = |run: &Run, first: usize, joints: Vec<LinkCurves>| Timed {
        time_s: (first..run.links.len())
            .step_by(steps(run))
            .map(|k| k as f64 * task.period)
            .collect(),
        joints,
    };
    let curves =
        |labels: &[(&str, Pick<'_>)], first: usize, value: &dyn Fn(&Run, usize, usize) -> f64| {
            (task.model.joints().iter().enumerate())
                .map(|(joint, name)| {
                    let of_label = |(label, of): &(&str, Pick<'_>)| {
                        let all: Vec<Vec<f64>> = (robots.iter())
                            .filter_map(|robot| {
                                let run = of(robot)?;
                                let all = (first..run.links.len()).step_by(steps(run));
                                Some(all.map(|k| value(run, k, joint)).collect())
                            })
                            .collect();
                        let all: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
                        ((*label).to_owned(), Banded::of(&all))
                    };
                    LinkCurves {
                        joint: name.clone(),
                        curves: labels.iter().map(of_label).collect(),
                    }
                })
                .collect::<Vec<_>>()
        };
    // Distances from the end along the path, because robots start in different poses.
    let from_end = |run: &Run, k: usize, joint: usize| {
        let at = |sample: Option<&Vec<f64>>| sample.map_or(0.0, |sample| sample[joint]);
        let (start, rest) = (at(run.links.first()), at(run.links.last()));
        (run.links[k][joint] - rest) * (rest - start).signum()
    };
    let is_shaped = !plan.designed.shaper.is_empty();
    pictures.moves = timed(
        &robots[0].shaped,
        0,
        curves(
            &[
                ("without shaper", &|robot| Some(&robot.unshaped)),
                ("with shaper", &|robot| {
                    Some(&robot.shaped).filter(|_| is_shaped)
                }),
            ],
            0,
            &from_end,
        ),
    );
    pictures.step = timed(
        &robots[0].steps[1],
        0,
        curves(
            &[
                ("without shaper", &|robot| Some(&robot.steps[0])),
                ("with shaper", &|robot| {
                    Some(&robot.steps[1]).filter(|_| is_shaped)
                }),
            ],
            0,
            &from_end,
        ),
    );
    if let Some(run) = &robots[0].designed {
        let skipped = settled(task, run);
        let error = |run: &Run, k: usize, joint: usize| run.links[k][joint] - run.wanted[k][joint];
        pictures.tracking = timed(
            run,
            skipped,
            curves(
                &[
                    ("designed", &|robot| robot.designed.as_ref()),
                    ("[controller]", &|robot| robot.declared.as_ref()),
                ],
                skipped,
                &error,
            ),
        );
    }
}
