//! Files that controllers take.

use std::fmt::Write;

use sprung_core::chain::JointKind;
use sprung_method::excite::{Approach, Series, Trajectory};
use sprung_model::Model;

/// Rest between approach and motion, s.
pub(super) const REST_S: f64 = 0.5;

/// Returns the samples of a motion at the period of the controller: approach, rest, motion.
pub(super) fn samples(
    model: &Model,
    series: &Series,
    duration: f64,
    approach: Option<&Approach>,
    period: f64,
) -> Trajectory {
    let n = model.joint_count();
    let mut trajectory = Trajectory {
        joints: model.joints().to_vec(),
        turns: (0..n)
            .map(|joint| model.kind(joint) == JointKind::Revolute)
            .collect(),
        position: vec![Vec::new(); n],
        velocity: vec![Vec::new(); n],
        acceleration: vec![Vec::new(); n],
        time_s: Vec::new(),
    };
    let before = approach.map_or(0.0, |approach| {
        ((approach.duration + REST_S) / period).ceil() * period
    });
    let first = (before / period).round() as usize;
    let count = first + (duration / period).round() as usize;
    for k in 0..=count {
        let time = k as f64 * period;
        trajectory.time_s.push(rounded(time, 9));
        for joint in 0..n {
            let at = match approach {
                Some(approach) if k < first => approach.at(joint, time),
                _ => series.at(joint, time - before),
            };
            trajectory.position[joint].push(rounded(at[0], 9));
            trajectory.velocity[joint].push(rounded(at[1], 9));
            trajectory.acceleration[joint].push(rounded(at[2], 9));
        }
    }
    // Rounding must not leave a last velocity.
    for list in trajectory
        .velocity
        .iter_mut()
        .chain(&mut trajectory.acceleration)
    {
        for end in [0, count] {
            list[end] = 0.0;
        }
    }
    trajectory
}

fn rounded(x: f64, digits: i32) -> f64 {
    let scale = 10.0_f64.powi(digits);
    let value = (x * scale).round() / scale;
    if value == 0.0 { 0.0 } else { value }
}

/// Returns a motion as CSV.
pub(super) fn csv(trajectory: &Trajectory) -> String {
    let mut text = "t_s".to_owned();
    for (joint, turns) in trajectory.joints.iter().zip(&trajectory.turns) {
        let unit = if *turns { "rad" } else { "m" };
        let _ = write!(
            text,
            ",{joint}_position_{unit},{joint}_velocity_{unit}_per_s,{joint}_acceleration_{unit}_per_s2"
        );
    }
    text.push('\n');
    for (t, time) in trajectory.time_s.iter().enumerate() {
        let _ = write!(text, "{time}");
        for joint in 0..trajectory.joints.len() {
            let _ = write!(
                text,
                ",{},{},{}",
                trajectory.position[joint][t],
                trajectory.velocity[joint][t],
                trajectory.acceleration[joint][t]
            );
        }
        text.push('\n');
    }
    text
}

/// Returns the number of samples between points of a message: polynomials of degree five between the points differ from
/// the motion by less than `part` of its largest velocity and acceleration.
pub(super) fn spacing(trajectory: &Trajectory, part: f64) -> usize {
    let mut step = 64.min(trajectory.time_s.len().max(2) - 1);
    while step > 1 {
        if is_close(trajectory, step, part) {
            return step;
        }
        step /= 2;
    }
    1
}

fn is_close(trajectory: &Trajectory, step: usize, part: f64) -> bool {
    let last = trajectory.time_s.len() - 1;
    for joint in 0..trajectory.joints.len() {
        let most = |list: &[f64]| list.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let limits = [
            most(&trajectory.velocity[joint]),
            most(&trajectory.acceleration[joint]),
        ];
        let mut from = 0;
        while from < last {
            let to = (from + step).min(last);
            let length = trajectory.time_s[to] - trajectory.time_s[from];
            let end = |t: usize| {
                [
                    trajectory.position[joint][t],
                    trajectory.velocity[joint][t],
                    trajectory.acceleration[joint][t],
                ]
            };
            for t in from..=to {
                let found = quintic(
                    end(from),
                    end(to),
                    length,
                    trajectory.time_s[t] - trajectory.time_s[from],
                );
                let off = [
                    (found[1] - trajectory.velocity[joint][t]).abs(),
                    (found[2] - trajectory.acceleration[joint][t]).abs(),
                ];
                if off[0] > part * limits[0] + 1e-7 || off[1] > part * limits[1] + 1e-5 {
                    return false;
                }
            }
            from = to;
        }
    }
    true
}

/// Returns position, velocity and acceleration of the polynomial of degree five between two points.
fn quintic(from: [f64; 3], to: [f64; 3], length: f64, time: f64) -> [f64; 3] {
    let [p, v, a] = from;
    let h = length;
    let moved = to[0] - p - v * h - 0.5 * a * h * h;
    let turned = to[1] - v - a * h;
    let bent = to[2] - a;
    let c3 = (10.0 * moved - 4.0 * turned * h + 0.5 * bent * h * h) / h.powi(3);
    let c4 = (-15.0 * moved + 7.0 * turned * h - bent * h * h) / h.powi(4);
    let c5 = (6.0 * moved - 3.0 * turned * h + 0.5 * bent * h * h) / h.powi(5);
    let t = time;
    [
        p + v * t + 0.5 * a * t * t + c3 * t.powi(3) + c4 * t.powi(4) + c5 * t.powi(5),
        v + a * t + 3.0 * c3 * t * t + 4.0 * c4 * t.powi(3) + 5.0 * c5 * t.powi(4),
        a + 6.0 * c3 * t + 12.0 * c4 * t * t + 20.0 * c5 * t.powi(3),
    ]
}

/// Returns a motion as a ROS 2 message `trajectory_msgs/msg/JointTrajectory` in YAML.
pub(super) fn yaml(trajectory: &Trajectory, step: usize) -> String {
    let list = |values: &[Vec<f64>], t: usize| -> String {
        let all: Vec<String> = values.iter().map(|series| float(series[t])).collect();
        all.join(", ")
    };
    let names: Vec<String> = trajectory
        .joints
        .iter()
        .map(|name| format!("\"{name}\""))
        .collect();
    let mut text = format!("joint_names: [{}]\npoints:\n", names.join(", "));
    let last = trajectory.time_s.len() - 1;
    let mut t = 0;
    loop {
        let nanoseconds = (trajectory.time_s[t] * 1e9).round() as u64;
        let _ = write!(
            text,
            "- positions: [{}]\n  velocities: [{}]\n  accelerations: [{}]\n  time_from_start: {{sec: {}, nanosec: {}}}\n",
            list(&trajectory.position, t),
            list(&trajectory.velocity, t),
            list(&trajectory.acceleration, t),
            nanoseconds / 1_000_000_000,
            nanoseconds % 1_000_000_000
        );
        if t == last {
            return text;
        }
        t = (t + step).min(last);
    }
}

/// Returns a number that YAML reads as a floating-point number.
fn float(x: f64) -> String {
    let text = x.to_string();
    if text.contains('.') {
        text
    } else {
        format!("{text}.0")
    }
}

/// Returns the motion as the reference of a controller in an experiment file.
pub(super) fn toml(series: &Series, model: &Model, duration: f64) -> String {
    let reference = series.reference(model);
    let list = |values: &[f64]| -> String {
        let all: Vec<String> = values.iter().map(|value| float(*value)).collect();
        all.join(", ")
    };
    let mut text = format!(
        "# A motion of {duration} s that begins and ends at rest, designed by sprung excite.\n[controller.reference]\n"
    );
    let any = |values: &[f64]| values.iter().any(|value| *value != 0.0);
    if any(&reference.centre_deg) {
        let _ = writeln!(text, "centre_deg = [{}]", list(&reference.centre_deg));
    }
    if any(&reference.centre_m) {
        let _ = writeln!(text, "centre_m = [{}]", list(&reference.centre_m));
    }
    text.push_str("sines = [\n");
    for sine in &reference.sines {
        let amplitude = if sine.amplitude_m == 0.0 {
            format!("amplitude_deg = {}", float(sine.amplitude_deg))
        } else {
            format!("amplitude_m = {}", float(sine.amplitude_m))
        };
        let _ = writeln!(
            text,
            "  {{ joint = \"{}\", {amplitude}, frequency_hz = {}, phase_deg = {} }},",
            sine.joint,
            float(sine.frequency_hz),
            float(sine.phase_deg)
        );
    }
    text.push_str("]\n");
    text
}
