//! `sprung control`: designs a controller and proves it.

use sprung::control::{ControlDesign, Motors, WithDraws};
use sprung::report::{compose_control, significant};
use sprung::session::controller_toml;

use super::begin::Opened;
use crate::args::Control;
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::results::{write_html, write_json};
use crate::terminal::{Grid, Terminal, dash};

/// Files that a design writes.
const CONTROL_FILE: &str = "control.json";
const CONTROLLER_FILE: &str = "controller.toml";
const REPORT_FILE: &str = "control.html";
const FILES: [&str; 3] = [CONTROL_FILE, CONTROLLER_FILE, REPORT_FILE];

pub(crate) fn run(args: &Control) -> Result<ExitCode, Failure> {
    let opened = Opened::new(
        &args.experiment,
        &args.common,
        (args.parameters.as_deref(), args.accept_refining),
        |_| Ok(()),
    )?;
    let folder = Folder::new(&opened.path, opened.inputs(), &FILES)?;
    let Opened {
        session,
        terminal,
        parameters,
        ..
    } = opened;
    let controlled = terminal.follow("designing", |progress| {
        session.control(&parameters, args.accept_unusable, progress)
    })?;
    let design = &controlled.design;

    let mut output = folder.output()?;
    write_json(&mut output, CONTROL_FILE, design)?;
    output.text(CONTROLLER_FILE, &controller_toml(design))?;
    let document = compose_control(&controlled, &command_line(), session.text());
    let report = write_html(&mut output, REPORT_FILE, &document)?;
    output.commit()?;

    terminal.json(design);
    say(terminal, design);
    terminal.say(format!("\nreport: {}", report.display()));
    Ok(ExitCode::Done)
}

fn numbers(all: &[f64]) -> String {
    let all: Vec<String> = all.iter().map(|value| significant(*value, 3)).collect();
    all.join(", ")
}

fn say(terminal: Terminal, design: &ControlDesign) {
    let controller = &design.controller;
    terminal.say(format!(
        "{}: {} every {} ms, stable in {} poses for the identified robot and {} robots of its posterior",
        design.robot,
        controller.feedback,
        significant(1e3 * controller.period_s, 4),
        design.poses.len(),
        design.draws,
    ));
    if let Some(verdict) = &design.verdict {
        terminal.say(format!("verdict of the values: {verdict}"));
    }
    if let Some(bandwidth) = &design.bandwidth {
        terminal.say(format!(
            "bandwidth {} Hz; the largest that keeps the margins is {} Hz: {}",
            numbers(&bandwidth.used_hz),
            numbers(&bandwidth.largest_hz),
            bandwidth.limited_by
        ));
    }
    terminal.table(&gains_table(design));
    terminal.table(&loops_table(design));
    terminal.table(&vibrations_table(design));
    if let Some(shaper) = &design.shaper {
        let modes: Vec<String> = (shaper.modes.iter())
            .map(|mode| {
                format!(
                    "{} impulses at {} Hz",
                    mode.impulses,
                    significant(mode.centre_hz, 3)
                )
            })
            .collect();
        terminal.say(format!(
            "input shaper: {}, delay {} s, leaves at most {} % of the vibration",
            modes.join(" and "),
            significant(shaper.delay_s, 3),
            significant(shaper.largest_percent, 2)
        ));
    }
    let proof = &design.proof;
    for tracking in &proof.tracking {
        let declared = tracking.declared_rad.map_or_else(String::new, |rms| {
            format!(", [controller] {}", significant(rms, 3))
        });
        terminal.say(format!(
            "{} follows the reference within {} rad rms (worst robot {}{declared})",
            tracking.joint,
            significant(tracking.designed_rad.identified, 3),
            significant(tracking.designed_rad.worst, 3)
        ));
    }
    let moves = &proof.moves;
    let vibration = |value: &WithDraws| {
        format!(
            "{} rad (worst robot {})",
            significant(value.identified, 2),
            significant(value.worst, 2)
        )
    };
    let shaped = design.shaper.as_ref().map_or_else(String::new, |_| {
        format!(", with the shaper {}", vibration(&moves.shaped_rad))
    });
    terminal.say(format!(
        "moves of {} s leave vibrations of {}{shaped}; limit cycles in {} of {} robots",
        significant(moves.duration_s, 3),
        vibration(&moves.unshaped_rad),
        moves.limit_cycles,
        proof.robots
    ));
    for assumed in &design.assumed {
        terminal.say(format!("assumed: {assumed}"));
    }
}

/// Returns the gains of each motor on the errors of its own joint.
fn gains_table(design: &ControlDesign) -> Grid {
    let header = [
        "gain, N·m (N) per",
        "link, rad (m)",
        "motor, rad (m)",
        "link, rad/s (m/s)",
        "motor, rad/s (m/s)",
    ];
    let mut table = Grid::new(header, 1);
    let n = design.joints.len();
    for (at, (name, row)) in design
        .joints
        .iter()
        .zip(&design.controller.gain)
        .enumerate()
    {
        let own =
            (0..4).map(|signal| significant(row.get(signal * n + at).copied().unwrap_or(0.0), 4));
        table.add_row(std::iter::once(name.clone()).chain(own));
    }
    table
}

fn loops_table(design: &ControlDesign) -> Grid {
    let header = [
        "loop",
        "gain margin, dB",
        "worst robot",
        "phase margin, °",
        "worst robot",
        "crossover, Hz",
    ];
    let mut table = Grid::new(header, 1);
    for row in &design.loops {
        let gain = |of: fn(&WithDraws) -> f64| dash(row.gain_db.as_ref().map(of), 3);
        table.add_row(vec![
            row.joint.clone(),
            gain(|value| value.identified),
            gain(|value| value.worst),
            significant(row.phase_deg.identified, 3),
            significant(row.phase_deg.worst, 3),
            dash(Some(row.crossover_hz).filter(|hz| *hz > 0.0), 3),
        ]);
    }
    table
}

fn vibrations_table(design: &ControlDesign) -> Grid {
    let header = [
        "vibration",
        "motors",
        "Hz",
        "95 % of robots and poses",
        "damping",
        "95 %",
    ];
    let mut table = Grid::new(header, 2);
    let ends =
        |[low, high]: [f64; 2]| format!("{} – {}", significant(low, 3), significant(high, 3));
    for row in &design.vibrations {
        table.add_row(vec![
            row.name.clone(),
            match row.motors {
                Motors::Free => "free",
                Motors::Held => "held",
                Motors::Controlled => "controlled",
            }
            .to_owned(),
            significant(row.all.hz, 4),
            ends(row.all.hz_95),
            significant(row.all.damping, 2),
            ends(row.all.damping_95),
        ]);
    }
    table
}
