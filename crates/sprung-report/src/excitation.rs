//! Composes the report of a designed experiment: its promise, its limits, its curves.

use sprung_method::excite::{Excitation, Excited, LimitUsed, Limited, Promised};

use super::document::{Badge, Block, Document, Section, Tone};
use super::motion;
use super::numbers::{dash_if_none, finite_or_dash, short, significant};
use super::promise;
use super::rows::rows;
use super::section::{origin_of_design, section};
use super::verdict::as_sentence;

/// Composes the report of a designed experiment.
///
/// - `command`: the command that made the report; `experiment`: the text of the experiment file.
#[must_use]
pub fn compose_excitation(excited: &Excited, command: &str, experiment: &str) -> Document {
    let excitation = &excited.excitation;
    let mut sections = vec![
        promise::section_of(excitation),
        limits(&excitation.limits),
        motion::section_of(excited),
    ];
    sections.extend(motion::arm(excited));
    sections.extend(motion::hold_out(excited));
    sections.extend(motion::slow(excited));
    sections.push(origin_of_design(
        "search",
        &excitation.assumed,
        Block::KeyValues(search(excitation)),
        command,
        experiment,
    ));
    Document {
        title: excitation.robot.clone(),
        subtitle: subtitle(excitation),
        generator: excitation.generator.clone(),
        verdict: Some(badge(excitation)),
        summary: summary(&excitation.promise),
        reason: reason(excitation),
        what_to_do: what_to_do(excitation),
        sections,
        ..Document::default()
    }
}

fn subtitle(excitation: &Excitation) -> String {
    let kind = match (excitation.method.as_str(), excitation.is_warm_up) {
        (_, true) => "Designed first motion",
        ("paper", false) => "Reference of the paper",
        _ => "Designed experiment",
    };
    let joints = excitation.motion.joints.len();
    format!(
        "{kind}: {}, {joints} joint{}",
        motion::length_and_band(&excitation.motion),
        plural(joints)
    )
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

fn badge(excitation: &Excitation) -> Badge {
    if excitation.is_certified {
        Badge::new(Tone::Good, "Every limit holds")
    } else {
        Badge::new(Tone::Bad, "Not certified")
    }
}

/// Returns the promise of the motion, in a sentence.
fn summary(promise: &[Promised]) -> String {
    let determined = promise
        .iter()
        .filter(|promised| promised.is_determined)
        .count();
    let open = promise.len() - determined;
    let undetermined = format!(
        "{} parameter{} undetermined.",
        if open == 0 {
            "no".to_owned()
        } else {
            open.to_string()
        },
        if open > 1 { "s stay" } else { " stays" }
    );
    match median(promise) {
        Some(percent) => format!(
            "The motion promises a median relative standard error of {} % over {determined} \
             determined parameter{}; {undetermined}",
            significant(percent, 2),
            plural(determined)
        ),
        None => as_sentence(&undetermined),
    }
}

/// Returns the median of the relative standard errors of determined parameters, percent.
fn median(promise: &[Promised]) -> Option<f64> {
    let determined = promise.iter().filter(|promised| promised.is_determined);
    let mut all: Vec<f64> = determined
        .filter_map(|promised| promised.relative_percent)
        .collect();
    all.sort_by(f64::total_cmp);
    let upper = all.get(all.len() / 2)?;
    let lower = all.get(all.len().saturating_sub(1) / 2)?;
    Some(0.5 * (lower + upper))
}

fn reason(excitation: &Excitation) -> String {
    if !excitation.is_certified {
        return largest(&excitation.limits).map_or_else(String::new, |limit| {
            format!(
                "The motion uses {} % of the limit of the {} of {}.",
                significant(limit.used_percent, 3),
                limit.quantity,
                owner(limit)
            )
        });
    }
    if excitation.is_warm_up {
        "The parameters of the robot are unknown, so the first motion is small.".to_owned()
    } else {
        String::new()
    }
}

fn what_to_do(excitation: &Excitation) -> String {
    if !excitation.is_certified {
        "Do not run this motion. Widen the limits if the robot allows it, or design a motion within \
         them."
    } else if excitation.is_warm_up {
        "Run this motion, run sprung identify on its log, and design the next motion with the \
         identified parameters."
    } else if excitation.slow.is_some() {
        "Run this motion, the slow motion and the validation motion. Run sprung identify on the \
         first two logs and sprung validate on the third."
    } else if excitation.hold_out.is_some() {
        "Run this motion and the validation motion. Run sprung identify on the first log and sprung \
         validate on the second."
    } else {
        "Run this motion, and run sprung identify on its log."
    }
    .to_owned()
}

fn largest(limits: &[LimitUsed]) -> Option<&LimitUsed> {
    limits
        .iter()
        .max_by(|a, b| a.used_percent.total_cmp(&b.used_percent))
}

fn owner(limit: &LimitUsed) -> &str {
    limit.joint.as_deref().unwrap_or("the tool")
}

/// Composes the section about limits, the most used one first.
fn limits(limits: &[LimitUsed]) -> Section {
    let mut sorted: Vec<&LimitUsed> = limits.iter().collect();
    sorted.sort_by(|a, b| b.used_percent.total_cmp(&a.used_percent));
    let limit =
        |at: Option<f64>| dash_if_none(at.filter(|at| at.is_finite()).map(|at| short(at, 4)));
    let table = rows(sorted)
        .text("Joint", |used| used.joint.as_deref().unwrap_or("tool"))
        .text("quantity", |used| &used.quantity)
        .text("unit", |used| &used.unit)
        .number("lowest", |used| limit(used.lowest))
        .number("highest", |used| limit(used.highest))
        .number("used [%]", |used| significant(used.used_percent, 3))
        .number("at [s]", |used| significant(used.time_s, 4))
        .text("shown", |used| &used.shown)
        .toned(|used| {
            if used.used_percent > 100.0 {
                Tone::Bad
            } else {
                Tone::Neutral
            }
        })
        .table("");
    let height = if limits
        .iter()
        .any(|limit_used| limit_used.quantity == Limited::Height.word())
    {
        " A height uses 0 % from one metre above the floor, and 100 % at the floor."
    } else {
        ""
    };
    section(
        "limits",
        "Limits",
        &format!(
            "\"Between samples\": a bound of the motion proves the limit at every time. \
             \"Simulated\": the simulated loop keeps the limit at every period of the controller. \
             Times count from the beginning of the motion, after an approach.{height}"
        ),
        if limits.is_empty() {
            vec![Block::Paragraph("The experiment has no limits.".to_owned())]
        } else {
            vec![Block::Table(table)]
        },
    )
}

fn search(excitation: &Excitation) -> Vec<(String, String)> {
    let search = &excitation.search;
    let objectives = search.objectives.iter();
    let objectives: Vec<String> = objectives
        .map(|objective| significant(*objective, 4))
        .collect();
    let motion = &excitation.motion;
    let condition = excitation.links_condition_number;
    let mut pairs = vec![
        ("Method", excitation.method.clone()),
        ("Objective", excitation.objective.clone()),
        (
            "Objective of the motion (logarithm of standard errors)",
            finite_or_dash(Some(search.objective), 4),
        ),
        ("Objectives of all searches", objectives.join(", ")),
        (
            "Condition number of the information about the links",
            condition.map_or_else(String::new, |condition| significant(condition, 3)),
        ),
        ("Largest number of steps", search.steps.to_string()),
        ("Seed", search.seed.to_string()),
        (
            "Lowest frequency",
            format!("{} Hz", short(motion.base_frequency_hz, 4)),
        ),
        ("Number of frequencies", motion.harmonics.len().to_string()),
        ("Number of periods", motion.periods.to_string()),
    ];
    pairs.retain(|(_, value)| !value.is_empty());
    pairs
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value))
        .collect()
}

#[cfg(test)]
mod tests {
    use sprung_method::excite::{
        JointMotion, More, MotionResult, SearchResult, Simulation, Skeleton, Trajectory,
    };

    use super::*;
    use crate::document::{Figure, Table};
    use crate::render;

    fn promised(name: &str, relative_percent: f64, cure: Option<&str>) -> Promised {
        Promised {
            name: name.to_owned(),
            unit: "N·m/rad".to_owned(),
            value: 50.0,
            standard_error: 0.5 * relative_percent,
            relative_percent: Some(relative_percent),
            is_determined: cure.is_none(),
            cure: cure.map(str::to_owned),
        }
    }

    fn limit(joint: &str, what: Limited, half: f64, used_percent: f64) -> LimitUsed {
        LimitUsed {
            joint: Some(joint.to_owned()),
            quantity: what.word().to_owned(),
            unit: what.unit().to_owned(),
            lowest: Some(-half),
            highest: Some(half),
            used_percent,
            time_s: 1.25,
            shown: "between samples".to_owned(),
        }
    }

    fn motion() -> MotionResult {
        let joint = |name: &str| JointMotion {
            joint: name.to_owned(),
            centre_rad: 0.0,
            start_rad: 0.0,
            sine_rad: vec![0.5, 0.1],
            cosine_rad: vec![0.0, 0.0],
        };
        MotionResult {
            duration_s: 10.0,
            approach_s: 1.0,
            base_frequency_hz: 0.1,
            harmonics: vec![1, 40],
            periods: 1,
            joints: vec![joint("shoulder"), joint("elbow")],
        }
    }

    /// Samples over an approach of 2 s and a motion of 10 s.
    fn trajectory() -> Trajectory {
        let time_s: Vec<f64> = (0..=12_000).map(|k| 1e-3 * f64::from(k)).collect();
        let wave = |size: f64| vec![time_s.iter().map(|t| size * t.sin()).collect(); 2];
        Trajectory {
            joints: vec!["shoulder".to_owned(), "elbow".to_owned()],
            turns: vec![true, false],
            position: wave(0.5),
            velocity: wave(1.0),
            acceleration: wave(3.0),
            time_s,
        }
    }

    fn excited() -> Excited {
        let time_s: Vec<f64> = (0..=1000).map(|k| 0.01 * f64::from(k)).collect();
        let wave = |size: f64| time_s.iter().map(|t| size * t.cos()).collect::<Vec<f64>>();
        let excitation = Excitation {
            format: 1,
            generator: "sprung 0.1.0".to_owned(),
            robot: "arm".to_owned(),
            method: "optimal".to_owned(),
            objective: "d-optimal".to_owned(),
            is_warm_up: false,
            is_certified: true,
            motion: motion(),
            hold_out: Some(motion()),
            slow: Some(motion()),
            limits: vec![
                limit("elbow", Limited::Velocity, 4.0, 25.0),
                limit("shoulder", Limited::Position, 0.51, 98.0),
            ],
            promise: vec![
                promised("shoulder.stiffness", 1.0, None),
                promised("elbow.stiffness", 3.0, None),
                promised(
                    "link2.mx",
                    250.0,
                    Some("a base tilted by 29° divide its standard error by 4.0"),
                ),
            ],
            more: vec![More {
                what: "the motion twice".to_owned(),
                factor: 0.707,
                undetermined: 1,
            }],
            links_condition_number: Some(12.5),
            assumed: vec!["motor encoders with 65536 counts".to_owned()],
            search: SearchResult {
                seed: 7,
                steps: 100,
                objectives: vec![-3.25, -3.125],
                objective: -3.25,
            },
        };
        Excited {
            excitation,
            simulation: Simulation {
                link: vec![wave(0.5), wave(0.5)],
                motor: vec![wave(0.52), wave(0.5)],
                torque: vec![wave(12.0), wave(5.0)],
                time_s: time_s.clone(),
            },
            trajectory: trajectory(),
            hold_out: Some(trajectory()),
            slow: Some(trajectory()),
            skeleton: Some(Skeleton {
                parents: vec![None, Some(0), Some(1)],
                points: (time_s.iter())
                    .map(|t| {
                        vec![
                            [0.0, 0.0, 0.4],
                            [0.3 * t.cos(), 0.3 * t.sin(), 0.7],
                            [0.5, 0.1, 0.6],
                        ]
                    })
                    .collect(),
                time_s,
            }),
        }
    }

    fn composed(excited: &Excited) -> Document {
        compose_excitation(excited, "sprung excite", "[robot]")
    }

    fn tables(document: &Document, id: &str) -> Vec<Table> {
        let blocks = document.sections.iter().filter(|section| section.id == id);
        let blocks = blocks.flat_map(|block| &block.blocks);
        blocks.filter_map(Block::table).cloned().collect()
    }

    fn figures(document: &Document) -> Vec<&Figure> {
        let blocks = document.sections.iter().flat_map(|section| &section.blocks);
        blocks.filter_map(Block::figure).collect()
    }

    #[test]
    fn the_report_says_what_the_motion_promises() {
        let document = composed(&excited());
        let ids: Vec<&str> = document
            .sections
            .iter()
            .map(|section| section.id.as_str())
            .collect();
        assert_eq!(
            ids,
            [
                "promise", "limits", "motion", "arm", "hold-out", "slow", "settings"
            ]
        );
        assert_eq!(
            document.subtitle,
            "Designed experiment: 10 s, 0.1 to 4 Hz, 2 joints"
        );
        assert_eq!(
            document.summary,
            "The motion promises a median relative standard error of 2.0 % over 2 determined \
             parameters; 1 parameter stays undetermined."
        );
        assert_eq!(document.verdict.unwrap().tone, Tone::Good);
    }

    #[test]
    fn an_undetermined_parameter_has_its_cure() {
        let document = composed(&excited());
        let tables = tables(&document, "promise");
        let [undetermined, more, parameters] = &tables[..] else {
            panic!("three tables")
        };
        let cure = "A base tilted by 29° divide its standard error by 4.0.";
        assert_eq!(undetermined.rows[0].cells, ["link2.mx", "250 %", cure]);
        assert_eq!(more.rows[0].cells, ["the motion twice", "0.707", "1"]);
        assert_eq!(
            parameters.headings,
            [(0, "shoulder".to_owned()), (1, "elbow".to_owned())]
        );
        assert_eq!(parameters.rows[2].tone, Tone::Doubtful);
    }

    #[test]
    fn a_motion_that_determines_all_has_no_list_of_cures() {
        let mut excited = excited();
        excited.excitation.promise.pop();
        let document = composed(&excited);
        assert_eq!(tables(&document, "promise").len(), 2);
        assert!(
            document
                .summary
                .ends_with("no parameter stays undetermined.")
        );
        excited.excitation.promise.clear();
        assert_eq!(
            composed(&excited).summary,
            "No parameter stays undetermined."
        );
    }

    #[test]
    fn the_most_used_limit_comes_first_and_a_broken_one_decides() {
        let mut excited = excited();
        let [table] = &tables(&composed(&excited), "limits")[..] else {
            panic!("one table")
        };
        let used: Vec<&str> = table.rows.iter().map(|row| row.cells[5].as_str()).collect();
        assert_eq!(used, ["98.0", "25.0"]);
        excited.excitation.limits[0].used_percent = 140.0;
        excited.excitation.is_certified = false;
        let document = composed(&excited);
        assert_eq!(document.verdict.unwrap().tone, Tone::Bad);
        assert_eq!(
            document.reason,
            "The motion uses 140 % of the limit of the velocity of elbow."
        );
    }

    #[test]
    fn curves_have_few_points_their_units_and_the_limits_that_are_near() {
        let document = composed(&excited());
        let figures = figures(&document);
        let ids: Vec<&str> = figures.iter().map(|figure| figure.id.as_str()).collect();
        assert_eq!(
            ids,
            [
                "position",
                "velocity",
                "acceleration",
                "deflection",
                "torque",
                "hold-out-position",
                "slow-position"
            ]
        );
        let [shoulder, elbow] = &figures[0].panels[..] else {
            panic!("two panels")
        };
        assert_eq!(shoulder.x.len(), 1000);
        assert_eq!(shoulder.x.last(), Some(&12.0));
        assert_eq!(shoulder.series[1].values[0], Some(0.51));
        assert!((shoulder.marks[0].at - 2.0).abs() < 1e-9);
        assert_eq!(elbow.y_label, "elbow position [m]");
        // The velocity of the elbow uses a quarter of its limit, whose line would cover it.
        assert_eq!(figures[1].panels[1].series[1].values[0], None);
        assert_eq!(figures[1].panels[1].note, "25 % of limit");
        // The elbow has no spring.
        assert_eq!(figures[3].panels.len(), 1);
    }

    #[test]
    fn only_a_page_with_an_arm_has_its_script() {
        let mut excited = excited();
        let script = "class ArmView";
        let page = render(&composed(&excited)).unwrap();
        assert_eq!(page.matches(script).count(), 1);
        assert_eq!(page.matches("<div data-skeleton>").count(), 1);
        let data = page.split_once("\"skeletons\":[").unwrap().1;
        let frames = data.split_once("\"points\":[[").unwrap().1;
        let frames = frames.split_once("]]").unwrap().0;
        assert_eq!(frames.matches("],[").count() + 1, 300);
        assert!(frames.starts_with("0,0,4000,3000,0,7000,"), "{frames:.60}");
        excited.skeleton = None;
        let page = render(&composed(&excited)).unwrap();
        assert!(!page.contains(script) && !page.contains("\"skeletons\""));
    }
}
