//! The page of the reference, from the table.

use std::fmt::Write as _;

use super::feature::Feature;
use super::table::{Answer, PAIRS, Reason, row};
use super::task::{Language, Task};

const INTRODUCTION: &str = "\
<!-- `cargo xtask docs` writes this page from the table in the code; a test fails if it is stale. -->
# What works with what

sprung refuses a combination only by the tables of this page. The message of a refusal names the sensor or property, the
task, and what to use instead; `code` of the error in Python is the code below. `sprung explain CODE` prints the reason and
an example.

";

/// Returns the page.
#[must_use]
pub fn what_works() -> String {
    let mut page = INTRODUCTION.to_owned();
    // Writes to a text do not fail.
    let _ = features_and_tasks(&mut page);
    let _ = refusals(&mut page);
    let _ = pairs(&mut page);
    let _ = languages(&mut page);
    page
}

fn features_and_tasks(page: &mut String) -> std::fmt::Result {
    writeln!(
        page,
        "## Sensors, logs and tasks\n\nA combination works if its cell is empty.\n"
    )?;
    let tasks = Task::ALL.map(heading);
    writeln!(page, "| | {} |", tasks.join(" | "))?;
    writeln!(page, "|---|{}", ":-:|".repeat(Task::COUNT))?;
    for feature in Feature::ALL.into_iter().filter(|one| is_in_table(*one)) {
        let cells = row(feature).map(|answer| match answer {
            Answer::Works => "",
            Answer::Refused(_) => "no",
        });
        writeln!(page, "| {} | {} |", feature.name(), cells.join(" | "))?;
    }
    writeln!(
        page,
        "\nA position servo has an estimator of its own; `estimator` in `[identify]` has no effect on it.\n"
    )
}

/// Returns a short name of a task for the head of a column.
fn heading(task: Task) -> String {
    match task {
        Task::Identify(estimator) => format!("`{}`", estimator.name()),
        Task::ExportRobot => "export of robots".to_owned(),
        Task::ExportCode => "export of code".to_owned(),
        Task::Dynamics => "dynamics".to_owned(),
        Task::Check | Task::Validate | Task::Simulate | Task::Compare => {
            format!("`{}`", task.name())
        }
    }
}

/// Returns whether a feature is a row of the first table; the others occur in pairs only.
fn is_in_table(feature: Feature) -> bool {
    match feature {
        Feature::LinkEncoder
        | Feature::DeflectionSensor
        | Feature::TorqueSensor
        | Feature::TorqueSensorAlone
        | Feature::Gyroscope
        | Feature::Accelerometer
        | Feature::MotorOnly
        | Feature::Servo
        | Feature::Covariates
        | Feature::KnownPayload
        | Feature::UnknownPayload
        | Feature::CoupledTransmission => true,
        Feature::ClosedForm
        | Feature::SpringsFromMotor
        | Feature::SeveralJoints
        | Feature::FlexibleJoint
        | Feature::SlidingJoint
        | Feature::OpenColumns
        | Feature::CubicSpring
        | Feature::LoadFriction => false,
    }
}

fn refusals(page: &mut String) -> std::fmt::Result {
    writeln!(page, "## Tasks that do not work\n")?;
    writeln!(
        page,
        "| code | with | tasks | why | instead |\n|---|---|---|---|---|"
    )?;
    for feature in Feature::ALL {
        let answers = row(feature);
        let mut told: Vec<Reason> = Vec::new();
        for answer in answers {
            let Answer::Refused(reason) = answer else {
                continue;
            };
            if told.contains(&reason) {
                continue;
            }
            told.push(reason);
            let is_refused = |task: &Task| answers[task.place()] == Answer::Refused(reason);
            let tasks: Vec<String> = Task::ALL
                .into_iter()
                .filter(is_refused)
                .map(heading)
                .collect();
            writeln!(
                page,
                "| `{}` | {} | {} | {} | {} |",
                reason.code,
                feature.name(),
                tasks.join(", "),
                reason.why,
                reason.instead
            )?;
        }
    }
    writeln!(page)
}

fn pairs(page: &mut String) -> std::fmt::Result {
    writeln!(page, "## What does not go together\n")?;
    writeln!(
        page,
        "| code | with | and | why | instead |\n|---|---|---|---|---|"
    )?;
    let mut told = Vec::new();
    for pair in &PAIRS {
        let code = pair.reason.code;
        if told.contains(&code) {
            continue;
        }
        told.push(code);
        let alike = || PAIRS.iter().filter(|other| other.reason.code == code);
        writeln!(
            page,
            "| `{code}` | {} | {} | {} | {} |",
            each_once(alike().map(|pair| pair.one.name()), " or "),
            each_once(alike().map(|pair| pair.other.name()), " or "),
            pair.reason.why,
            each_once(alike().map(|pair| pair.reason.instead), "; ")
        )?;
    }
    writeln!(page)
}

/// Joins texts, each of them once.
fn each_once<'a>(texts: impl Iterator<Item = &'a str>, between: &str) -> String {
    let mut all: Vec<&str> = Vec::new();
    for text in texts {
        if !all.contains(&text) {
            all.push(text);
        }
    }
    all.join(between)
}

fn languages(page: &mut String) -> std::fmt::Result {
    writeln!(page, "## Tasks and languages\n")?;
    let heads = Language::ALL.map(Language::name);
    writeln!(page, "| | {} |", heads.join(" | "))?;
    writeln!(page, "|---|{}", "---|".repeat(heads.len()))?;
    let mut before = Vec::new();
    for task in Task::ALL {
        let calls = Language::ALL.map(|language| match task.call(language) {
            Some(call) => format!("`{call}`"),
            None => "no".to_owned(),
        });
        let name = match task {
            Task::Identify(_) => "identify".to_owned(),
            Task::Check
            | Task::Validate
            | Task::Simulate
            | Task::Compare
            | Task::ExportRobot
            | Task::ExportCode
            | Task::Dynamics => heading(task).replace('`', ""),
        };
        if before.contains(&name) {
            continue;
        }
        writeln!(page, "| {name} | {} |", calls.join(" | "))?;
        let of_servo = Language::ALL.map(|language| match task.call_of_servo(language) {
            Some(call) => format!("`{call}`"),
            None => "no".to_owned(),
        });
        if of_servo.iter().any(|call| call != "no") {
            writeln!(
                page,
                "| {name}, position servo | {} |",
                of_servo.join(" | ")
            )?;
        }
        before.push(name);
    }
    Ok(())
}
