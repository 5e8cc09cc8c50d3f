//! The arm of the paper: the designed motion beside its reference, Eq. (29), at equal and at twice the peak torque, and the
//! spread of refined estimates beside the promise.

use std::fmt::Write as _;

use rayon::prelude::*;
use sprung::session::{ExciteMethod, Session};
use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_method::estimate::Identified;
use sprung_method::excite::{Excited, Promised};
use sprung_testing::Figure;

use super::{errors, excite, mean_ratio, reference, session};

/// Sets the true values as those of the design.
fn demo_session(set: &[String]) -> Session {
    let mut all = nominal(&truth());
    all.extend(set.iter().cloned());
    session(demo::EXPERIMENT, &all, demo::TRUTH)
}

/// Returns the true values by name.
pub(crate) fn truth() -> Vec<(String, f64)> {
    let truth: toml::Table = demo::TRUTH.parse().expect("the truth is a table");
    let number = |value: toml::Value| value.as_float().expect("a number");
    truth
        .into_iter()
        .map(|(name, value)| (name, number(value)))
        .collect()
}

/// Returns settings that give the robot nominal values.
pub(crate) fn nominal(values: &[(String, f64)]) -> Vec<String> {
    let mut nominal = String::from("robot.nominal={");
    let mut of_joints = [String::new(), String::new()];
    for (name, value) in values {
        match name.split_once('.') {
            Some(("joint1", quantity)) => {
                write!(of_joints[0], "{quantity}={value},").expect("text");
            }
            Some(("joint2", quantity)) => {
                write!(of_joints[1], "{quantity}={value},").expect("text");
            }
            _ => write!(nominal, "\"{name}\"={value},").expect("text"),
        }
    }
    let mut all = vec![format!("{}}}", nominal.trim_end_matches(','))];
    for (joint, values) in of_joints.iter().enumerate() {
        all.push(format!(
            "robot.joint.{joint}.nominal={{{}}}",
            values.trim_end_matches(',')
        ));
    }
    all
}

/// Returns settings that limit torques and deflections to parts of the largest ones of a motion.
pub(crate) fn limits(peaks: &[[f64; 2]], torques: f64, deflections: f64) -> Vec<String> {
    (peaks.iter().enumerate())
        .map(|(joint, [torque, deflection])| {
            format!(
                "robot.joint.{joint}.limits={{torque_nm={}, deflection_rad={}}}",
                torques * torque,
                deflections * deflection
            )
        })
        .collect()
}

/// Returns the largest torques and deflections of the paper's reference, per joint.
pub(crate) fn paper_peaks() -> Vec<[f64; 2]> {
    let paper = excite(&demo_session(&[]), ExciteMethod::Paper, None);
    peaks(&paper.expect("the paper's motion"))
}

/// Returns the largest torques and deflections of a simulated motion, per joint.
fn peaks(excited: &Excited) -> Vec<[f64; 2]> {
    let simulation = &excited.simulation;
    let largest =
        |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |a: f64, x| a.max(x.abs()));
    (0..simulation.link.len())
        .map(|joint| {
            let pairs = simulation.motor[joint].iter().zip(&simulation.link[joint]);
            [
                largest(&mut simulation.torque[joint].iter().copied()),
                largest(&mut pairs.map(|(phi, q)| phi - q)),
            ]
        })
        .collect()
}

pub(crate) fn run(runs: u64) {
    let paper = excite(&demo_session(&[]), ExciteMethod::Paper, None).expect("the paper's motion");
    let peaks = peaks(&paper);
    for (words, torques, deflections) in [
        ("equal peaks", 1.0, 1.0),
        ("twice the torque and deflection", 2.0, 2.0),
        ("twice the torque, no limit of deflection", 2.0, 1e3),
    ] {
        let set = limits(&peaks, torques, deflections);
        let session = demo_session(&set);
        let started = std::time::Instant::now();
        let found = excite(&session, ExciteMethod::Optimal, None).expect("a motion");
        let time = started.elapsed().as_secs_f64();
        let (before, after) = (errors(&paper), errors(&found));
        let ratios: Vec<f64> = before.iter().zip(&after).map(|(a, b)| a / b).collect();
        println!(
            "{words}: standard errors smaller by {:.3} in the geometric mean, joint2.link_viscous {:.2}, least {:.3}; {time:.0} s",
            mean_ratio(&before, &after),
            ratios[6],
            ratios.iter().fold(f64::INFINITY, |a, b| a.min(*b))
        );
        let all: Vec<String> = ratios.iter().map(|ratio| format!("{ratio:.2}")).collect();
        println!("  {}", all.join(" "));
        let text = format!(
            "the demo's arm, {words}: standard errors of the paper's reference over those of the designed motion"
        );
        let ratio = mean_ratio(&before, &after);
        Figure::higher(words, &text, ratio, "times").note();
        if torques < 1.5 && runs > 0 {
            spread(&session, &found, runs);
        }
        for seed in 2..=3 {
            let mut set = set.clone();
            set.push(format!("excite.seed={seed}"));
            let other = excite(&demo_session(&set), ExciteMethod::Optimal, None).expect("a motion");
            println!(
                "  seed {seed}: objective {:+.1} %, errors {:+.1} %",
                100.0 * (other.excitation.search.objective - found.excitation.search.objective),
                100.0 * (mean_ratio(&errors(&other), &after) - 1.0)
            );
        }
    }
}

/// Returns the experiment with another reference.
pub(crate) fn with_reference(reference: &str) -> String {
    let (before, after) = demo::EXPERIMENT
        .split_once("[controller.reference]")
        .expect("a reference");
    let (_, after) = after.split_once("\n]\n").expect("the end of the sines");
    format!("{before}{reference}{after}")
}

/// Identifies the true robot from a simulated log.
pub(crate) fn identified(text: &str, seed: u64) -> Identified {
    let twin = session(text, &[], demo::TRUTH);
    let mut log = Vec::new();
    let recording = twin.twin(None, None).expect("a twin").with_seed(seed);
    recording.write(&mut log, &mut Unheard).expect("a log");
    let log = String::from_utf8(log).expect("text");
    let set = [
        "identify.estimator=prediction-error",
        "identify.laws=declared",
    ]
    .map(str::to_owned);
    let session = session(text, &set, &log);
    session.identify(&mut Unheard).expect("an estimate")
}

/// Compares the spread of refined estimates from simulated logs of a motion with its promise.
fn spread(session: &Session, found: &Excited, runs: u64) {
    let text = with_reference(&reference(session, found));
    let estimates: Vec<Vec<f64>> = (0..runs)
        .into_par_iter()
        .map(|seed| {
            let found = identified(&text, seed + 1);
            let parameters = &found.identification.results[0].parameters;
            parameters
                .iter()
                .map(|parameter| parameter.value.unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    let mut ratios = Vec::new();
    for (
        k,
        Promised {
            name,
            standard_error,
            ..
        },
    ) in found.excitation.promise.iter().enumerate()
    {
        let mean = estimates.iter().map(|estimate| estimate[k]).sum::<f64>() / runs as f64;
        let square: f64 = estimates
            .iter()
            .map(|estimate| (estimate[k] - mean).powi(2))
            .sum();
        let ratio = (square / (runs - 1) as f64).sqrt() / standard_error;
        println!("  {name}: observed over promised spread {ratio:.2}");
        ratios.push(ratio);
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "  {runs} runs: median {:.2}, {:.2} to {:.2}",
        ratios[ratios.len() / 2],
        ratios[0],
        ratios[ratios.len() - 1]
    );
    let text = format!(
        "the same, {runs} simulated runs: observed over promised scatter, median of the parameters"
    );
    let median = ratios[ratios.len() / 2];
    Figure::neutral("scatter", &text, median, "").note();
}
