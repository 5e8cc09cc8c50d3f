//! Composes the report of a designed controller: margins, vibrations, shaper, and the simulations that prove it.

use std::fmt::Write;

use sprung_method::control::{
    Banded, ControlDesign, ControlPictures, Controlled, LoopCurve, Motors, PoleInPose,
    ShaperDesign, Timed, WithDraws,
};

use super::document::{
    Badge, Block, Document, Figure, Layout, Line, Panel, Section, Series, Style, Tone,
};
use super::numbers::{or_dash, short, significant};
use super::rows::rows;
use super::section::{origin_of_design, section};

/// Styles of the curves of one panel.
const STYLES: [Style; 2] = [Style::First, Style::Second];

/// Composes the report of a designed controller.
///
/// - `command`: the command that made the report; `experiment`: the text of the experiment file.
#[must_use]
pub fn compose_control(controlled: &Controlled, command: &str, experiment: &str) -> Document {
    let Controlled { design, pictures } = controlled;
    let mut sections = vec![loops(design, pictures), vibrations(design, pictures)];
    sections.extend(design.shaper.as_ref().map(shaper));
    sections.push(moves(design, pictures));
    sections.extend(tracking(design, pictures));
    sections.push(origin_of_design(
        "gains",
        &design.assumed,
        Block::Code(gains(design)),
        command,
        experiment,
    ));
    Document {
        title: design.robot.clone(),
        subtitle: subtitle(design),
        generator: design.generator.clone(),
        verdict: Some(badge(design)),
        summary: summary(design),
        reason: design
            .bandwidth
            .as_ref()
            .map_or_else(String::new, |bandwidth| {
                format!(
                    "The largest bandwidth that keeps the margins is {} Hz: {}.",
                    numbers(&bandwidth.largest_hz),
                    bandwidth.limited_by
                )
            }),
        what_to_do: what_to_do(design),
        sections,
        ..Document::default()
    }
}

fn numbers(all: &[f64]) -> String {
    let all: Vec<String> = all.iter().map(|value| significant(*value, 3)).collect();
    all.join(", ")
}

fn subtitle(design: &ControlDesign) -> String {
    let controller = &design.controller;
    let kind = match controller.feedback.as_str() {
        "state-feedback" => "State feedback",
        "pd" => "PD control of the motors",
        "link-damping" => "Control that damps the links",
        _ => "Declared controller",
    };
    let ahead = match (
        controller.has_feedforward,
        controller.friction_compensation_speed_rad_per_s,
    ) {
        (true, Some(_)) => " with the torques of the model and compensation of friction",
        (true, None) => " with the torques of the model",
        (false, _) => "",
    };
    format!(
        "{kind}{ahead}, period {} ms",
        short(1e3 * controller.period_s, 4)
    )
}

fn badge(design: &ControlDesign) -> Badge {
    let unusable = design.verdict.as_deref() == Some("unusable");
    match (unusable, design.proof.moves.limit_cycles) {
        (true, _) => Badge::new(Tone::Bad, "From unusable values"),
        (false, 0) => Badge::new(Tone::Good, "Stable for every robot of the posterior"),
        (false, _) => Badge::new(Tone::Doubtful, "Stable, with limit cycles"),
    }
}

fn summary(design: &ControlDesign) -> String {
    let least = |all: &mut dyn Iterator<Item = f64>| all.fold(f64::INFINITY, f64::min);
    let gain = least(
        &mut design
            .loops
            .iter()
            .filter_map(|margins| Some(margins.gain_db?.worst)),
    );
    let phase = least(&mut design.loops.iter().map(|margins| margins.phase_deg.worst));
    let robots = if design.draws == 0 {
        "the given values".to_owned()
    } else {
        format!("{} robots of the posterior", design.draws)
    };
    let bandwidth = design
        .bandwidth
        .as_ref()
        .map_or_else(String::new, |bandwidth| {
            format!(" The bandwidth is {} Hz.", numbers(&bandwidth.used_hz))
        });
    format!(
        "In {} poses and for {robots}, every motor's loop keeps at least {} dB and {}°.{bandwidth}",
        design.poses.len(),
        significant(gain, 2),
        significant(phase, 2)
    )
}

fn what_to_do(design: &ControlDesign) -> String {
    let export = "Copy controller.toml into the experiment to simulate it, or write its code with sprung export --format c \
                  --control control.json.";
    let shaper = if design.shaper.is_some() {
        " Feed the desired motion through the shaper."
    } else {
        ""
    };
    format!("{export}{shaper} Begin on the robot with a part of the bandwidth.")
}

fn pair(value: &WithDraws, digits: usize) -> [String; 2] {
    [
        significant(value.identified, digits),
        significant(value.worst, digits),
    ]
}

/// Composes the section about margins with Bode plots.
fn loops(design: &ControlDesign, pictures: &ControlPictures) -> Section {
    let table = rows(&design.loops)
        .text("Loop of", |margins| &margins.joint)
        .number("gain margin [dB]", |margins| {
            or_dash(margins.gain_db.map(|gain| gain.identified), 3)
        })
        .number("worst robot [dB]", |margins| {
            or_dash(margins.gain_db.map(|gain| gain.worst), 3)
        })
        .number("phase margin [°]", |margins| {
            significant(margins.phase_deg.identified, 3)
        })
        .number("worst robot [°]", |margins| {
            significant(margins.phase_deg.worst, 3)
        })
        .number("crossover [Hz]", |margins| {
            or_dash(Some(margins.crossover_hz).filter(|hz| *hz > 0.0), 3)
        })
        .table("");
    let mut blocks = vec![Block::Table(table)];
    blocks.extend(pictures.loops.iter().map(bode).map(Block::Figure));
    section(
        "loops",
        "Margins",
        "Each loop is opened at one motor while the others stay closed, with sampling and velocity estimators, in all poses. \
         The worst robot is the worst over all robots and poses.",
        blocks,
    )
}

/// Returns the Bode plot of a loop, gain above phase, with the margins of the identified robot.
fn bode(curve: &LoopCurve) -> Figure {
    let panel = |band: &Banded, y_label: String, line: f64, marks: Vec<Line>| {
        let mut series = banded(band, "identified robot", Style::First);
        let limit = vec![Some(line); curve.hz.len()];
        series.insert(0, Series::new("limit of stability", Style::Error, limit));
        Panel {
            y_label,
            x: curve.hz.clone(),
            series,
            marks,
            ..Panel::default()
        }
    };
    let (gain, phase) = (&curve.gain_db, &curve.phase_deg);
    let mark = |at, text| Line { at, text };
    let gain_marks = crossings(&curve.hz, &phase.identified, -180.0, &gain.identified)
        .map(|(hz, db)| mark(hz, format!("gain margin {} dB", significant(-db, 2))));
    let phase_marks =
        crossings(&curve.hz, &gain.identified, 0.0, &phase.identified).map(|(hz, degrees)| {
            let margin = significant(180.0 + degrees, 2);
            mark(
                hz,
                format!("phase margin {margin}° at {} Hz", significant(hz, 2)),
            )
        });
    Figure {
        id: format!("bode-{}", curve.joint),
        caption: format!(
            "Open loop of {} with the loops of the others closed, in the middle of the workspace: the identified robot and its \
             margins, and the lowest and the highest value over robots of the posterior.",
            curve.joint
        ),
        x_label: "frequency [Hz]".to_owned(),
        logarithmic: true,
        layout: Layout::Half,
        panels: vec![
            panel(
                gain,
                format!("{} gain [dB]", curve.joint),
                0.0,
                gain_marks.collect(),
            ),
            panel(
                phase,
                format!("{} phase [°]", curve.joint),
                -180.0,
                phase_marks.collect(),
            ),
        ],
    }
}

/// Returns where a curve crosses a level: the frequency, and the value of another curve there.
fn crossings<'a>(
    hz: &'a [f64],
    curve: &'a [f64],
    level: f64,
    other: &'a [f64],
) -> impl Iterator<Item = (f64, f64)> + 'a {
    (1..hz.len()).filter_map(move |k| {
        let (before, after) = (curve[k - 1] - level, curve[k] - level);
        (before * after < 0.0).then(|| {
            let part = before / (before - after);
            let between = |a: f64, b: f64| a + part * (b - a);
            let at = between(hz[k - 1].ln(), hz[k].ln()).exp();
            (at, between(other[k - 1], other[k]))
        })
    })
}

/// Returns a curve and the two ends of its band.
fn banded(band: &Banded, name: &str, style: Style) -> Vec<Series> {
    let series = |name: String, values: &[f64], style| {
        let values = values
            .iter()
            .map(|value| value.is_finite().then_some(*value));
        Series::new(name, style, values.collect())
    };
    let mut all = Vec::new();
    if band.low != band.high {
        for (end, values) in [("lowest", &band.low), ("highest", &band.high)] {
            all.push(series(format!("{name}, {end}"), values, Style::Reference));
        }
    }
    all.push(series(name.to_owned(), &band.identified, style));
    all
}

/// Composes the section about vibrations with the poles over the workspace.
fn vibrations(design: &ControlDesign, pictures: &ControlPictures) -> Section {
    let ends =
        |[low, high]: [f64; 2]| format!("{} – {}", significant(low, 3), significant(high, 3));
    let table = rows(&design.vibrations)
        .text("Vibration", |vibration| &vibration.name)
        .text("motors", |vibration| vibration.motors.words())
        .number("Hz", |vibration| significant(vibration.all.hz, 4))
        .number("95 %", |vibration| ends(vibration.all.hz_95))
        .number("damping", |vibration| significant(vibration.all.damping, 2))
        .number("95 %", |vibration| ends(vibration.all.damping_95))
        .marked(|vibration| {
            vibration.motors == Motors::Controlled && vibration.all.damping < 0.1
        })
        .table(
            "Natural frequency and damping ratio: the median over the poses, and the interval that holds 95 % of all robots \
             in all poses. control.json has them for each pose.",
        );
    let mut blocks = vec![Block::Table(table)];
    if !pictures.poles.is_empty() {
        blocks.push(Block::Figure(poles(&pictures.poles)));
    }
    section(
        "vibrations",
        "Vibrations",
        "Motors free: the resonance of a spring between motor and link. Motors held: the links on their springs, which is also \
         the vibration while dry friction holds the motors. Loop closed: with this controller.",
        blocks,
    )
}

/// Damping ratios of the lines among the poles.
const DAMPINGS: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.7];

/// Number of points of such a line.
const POINTS: usize = 60;

/// Returns the poles in the complex plane with lines of equal damping.
fn poles(all: &[PoleInPose]) -> Figure {
    let place = |pole: &PoleInPose| {
        let damping = pole.damping.clamp(-1.0, 1.0);
        (
            -damping * pole.hz,
            pole.hz * (1.0 - damping * damping).sqrt(),
        )
    };
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let left = most(&mut all.iter().map(|pole| -place(pole).0));
    let top = most(&mut all.iter().map(|pole| place(pole).1));
    // Lines end at the border of the poles.
    let line = |damping: f64| {
        let slope = (1.0 - damping * damping).sqrt() / damping;
        let end = left.min(top / slope);
        (0..=POINTS).map(move |k| {
            let x = -end * k as f64 / POINTS as f64;
            (x, -slope * x)
        })
    };
    let mut points: Vec<(f64, f64, usize)> = (all.iter())
        .map(|pole| {
            (
                place(pole).0,
                place(pole).1,
                usize::from(pole.is_identified),
            )
        })
        .collect();
    for (k, damping) in DAMPINGS.into_iter().enumerate() {
        points.extend(line(damping).map(|(x, y)| (x, y, k + 2)));
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let series = |name: &str, which: usize, style| {
        let of_curve = |(_, y, curve): &(f64, f64, usize)| (*curve == which).then_some(*y);
        Series::new(name, style, points.iter().map(of_curve).collect())
    };
    let mut curves: Vec<Series> = (DAMPINGS.iter().enumerate())
        .map(|(k, damping)| series(&format!("damping ratio {damping}"), k + 2, Style::Reference))
        .collect();
    curves.push(series("robots of the posterior", 0, Style::Cloud));
    curves.push(series("identified robot", 1, Style::Cloud));
    Figure {
        id: "poles".to_owned(),
        caption: "Poles of the closed loop in all poses, divided by 2π; a point is a pole of one robot in one pose. Lines from the \
                  right to the left have the damping ratios 0.05, 0.1, 0.2, 0.4 and 0.7."
            .to_owned(),
        x_label: "real part [Hz]".to_owned(),
        layout: Layout::Stack,
        panels: vec![Panel {
            y_label: "imaginary part [Hz]".to_owned(),
            x: points.iter().map(|point| point.0).collect(),
            series: curves,
            ..Panel::default()
        }],
        ..Figure::default()
    }
}

fn shaper(design: &ShaperDesign) -> Section {
    let impulses = rows(&design.impulses)
        .number("time [s]", |impulse| significant(impulse.time_s, 4))
        .number("part of the command", |impulse| {
            significant(impulse.amplitude, 4)
        })
        .table("Impulses of the whole shaper.");
    let modes: Vec<String> = (design.modes.iter())
        .map(|mode| {
            format!(
                "{} impulses for {} Hz with damping ratio {}",
                mode.impulses,
                significant(mode.centre_hz, 3),
                significant(mode.damping, 2)
            )
        })
        .collect();
    section(
        "shaper",
        "Input shaper",
        &format!(
            "{}. It delays the motion by {} s and leaves at most {} % of the vibration of 95 % of the robots and poses.",
            modes.join(" and "),
            significant(design.delay_s, 3),
            significant(design.largest_percent, 2)
        ),
        vec![Block::Table(impulses)],
    )
}

/// Returns a figure of simulated motions, one panel per joint.
fn figure(id: &str, caption: &str, timed: &Timed, what: &str) -> Figure {
    let panel = |link_curves: &sprung_method::control::LinkCurves| {
        let curves = link_curves
            .curves
            .iter()
            .filter(|(_, band)| !band.identified.is_empty());
        Panel {
            y_label: format!("{} {what} [rad]", link_curves.joint),
            x: timed.time_s.clone(),
            series: (curves.zip(STYLES))
                .flat_map(|((name, band), style)| banded(band, name, style))
                .map(|series| fitting(series, timed.time_s.len()))
                .collect(),
            ..Panel::default()
        }
    };
    Figure::over_time(id, caption, Layout::Grid, timed.joints.iter().map(panel))
}

/// Returns a curve with as many values as the time.
fn fitting(mut series: Series, length: usize) -> Series {
    series.values.resize(length, None);
    series
}

fn moves(design: &ControlDesign, pictures: &ControlPictures) -> Section {
    let moves = &design.proof.moves;
    let [unshaped, worst] = pair(&moves.unshaped_rad, 2);
    let [shaped, worst_shaped] = pair(&moves.shaped_rad, 2);
    let mut lead = format!(
        "Simulated moves of {} s from rest to rest in different poses. Afterwards the links deviate from their rest by at most \
         {unshaped} rad (worst robot {worst})",
        significant(moves.duration_s, 3)
    );
    if design.shaper.is_some() {
        let _ = write!(
            lead,
            ", with the shaper by {shaped} rad (worst robot {worst_shaped})"
        );
    }
    lead += ".";
    if moves.limit_cycles > 0 {
        let _ = write!(
            lead,
            " {} of {} robots go on moving: a limit cycle.",
            moves.limit_cycles, design.proof.robots
        );
    }
    section(
        "moves",
        "Steps and moves",
        &lead,
        vec![
            Block::Figure(figure(
                "move",
                "Links in a move: the distance from the end. The identified robot, and the band of the simulated robots.",
                &pictures.moves,
                "from the end",
            )),
            Block::Figure(figure(
                "step",
                "Links after a small step of the desired position.",
                &pictures.step,
                "from the end",
            )),
        ],
    )
}

fn tracking(design: &ControlDesign, pictures: &ControlPictures) -> Option<Section> {
    let all = &design.proof.tracking;
    if all.is_empty() {
        return None;
    }
    let table = rows(all)
        .text("Link", |tracking| &tracking.joint)
        .number("[controller] [rad]", |tracking| {
            or_dash(tracking.declared_rad, 3)
        })
        .number("designed [rad]", |tracking| {
            significant(tracking.designed_rad.identified, 3)
        })
        .number("worst robot [rad]", |tracking| {
            significant(tracking.designed_rad.worst, 3)
        })
        .table("");
    let caption = "Errors of the links on the reference after the first second.";
    Some(section(
        "tracking",
        "Tracking",
        "Root mean square errors of the links on the reference of the experiment. The model in the controller is that of the \
         identified robot; the simulated robots differ from it as the posterior allows.",
        vec![
            Block::Table(table),
            Block::Figure(figure("errors", caption, &pictures.tracking, "error")),
        ],
    ))
}

fn gains(design: &ControlDesign) -> String {
    let rows: Vec<String> = (design.controller.gain.iter())
        .map(|row| {
            let row: Vec<String> = row.iter().map(|gain| significant(*gain, 5)).collect();
            format!("[{}]", row.join(", "))
        })
        .collect();
    format!(
        "gain on the errors of link positions, motor positions, link velocities and motor velocities\n{}",
        rows.join("\n")
    )
}
