//! `sprung excite`: designs an experiment.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sprung::estimate::Verdict;
use sprung::excite::{Excitation, Excited};
use sprung::model::short;
use sprung::report::{compose_excitation, significant};
use sprung::session::{
    ExciteMethod, ExciteRequest, Parameters, Session, excitation_files, find_identification,
};

use crate::args::{Excite, Method};
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::{Folder, results_folder};
use crate::results::{write_html, write_json};
use crate::terminal::{Grid, Terminal, complain, dash};

/// Files that a design writes.
const EXCITATION_FILE: &str = "excitation.json";
const REPORT_FILE: &str = "excitation.html";
const FILES: [&str; 7] = [
    EXCITATION_FILE,
    "trajectory.csv",
    "trajectory.yaml",
    "hold-out.csv",
    "slow.csv",
    "reference.toml",
    REPORT_FILE,
];

/// Part of a limit from which a line of the terminal names it, percent.
const NEAR_PERCENT: f64 = 90.0;

pub(crate) fn run(args: &Excite) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let session = Session::open(&args.experiment, &common.overrides)?;
    let parameters = values(terminal, args, &session)?;
    let request = ExciteRequest {
        method: match args.method {
            Method::Optimal => ExciteMethod::Optimal,
            Method::Paper => ExciteMethod::Paper,
            Method::Random => ExciteMethod::Random,
        },
        is_warm_up: args.warm_up,
        from_log: absolute("--from-log", args.from_log.as_deref())?,
        reference: absolute("--reference", args.reference.as_deref())?,
    };
    let inputs = session
        .inputs()
        .into_iter()
        .chain(args.parameters.clone())
        .chain(args.from_log.clone())
        .chain(args.reference.clone());
    let folder = Folder::new(&results_folder(&session, common), inputs, &FILES)?;
    let stop = stop_on_interrupt();
    let is_stopped = || stop.load(Ordering::Relaxed);
    let excited = terminal.follow_until(is_stopped, "designing", |progress| {
        session.excite(&request, parameters.as_ref(), progress)
    })?;

    let mut output = folder.output()?;
    for (name, text) in excitation_files(&session, &excited) {
        output.text(name, &text)?;
    }
    for (name, value) in [
        ("hold-out.csv", &excited.hold_out),
        ("slow.csv", &excited.slow),
    ] {
        if value.is_none() {
            output.outdates(name);
        }
    }
    write_json(&mut output, EXCITATION_FILE, &excited.excitation)?;
    let document = compose_excitation(&excited, &command_line(), session.text());
    let report = write_html(&mut output, REPORT_FILE, &document)?;
    output.commit()?;

    terminal.json(&excited.excitation);
    say(terminal, &excited, is_stopped());
    terminal.say(format!("\nreport: {}", report.display()));
    Ok(ExitCode::Done)
}

/// Returns the values of the robot: those of the flag, or of the identification in the results folder. A first motion takes the
/// nominal values.
fn values(
    terminal: Terminal,
    args: &Excite,
    session: &Session,
) -> Result<Option<Parameters>, Failure> {
    if let Some(file) = &args.parameters {
        return Ok(Some(Parameters::open(file)?));
    }
    let (chosen, usual) = (
        results_folder(session, &args.common),
        session.results_folder(),
    );
    let file = find_identification(&chosen, &usual).ok();
    let Some(file) = file.filter(|_| !args.warm_up) else {
        return Ok(None);
    };
    let found = Parameters::open(&file)?;
    let result = (found.identification.as_ref()).and_then(|found| found.results.first());
    let is_unusable = result.is_some_and(|result| result.verdict == Verdict::Unusable);
    let shown = file.display();
    if is_unusable {
        terminal.say(format!(
            "the nominal values are used, because the verdict on {shown} is unusable"
        ));
        return Ok(None);
    }
    terminal.say(format!(
        "the values of {shown} are used; --parameters chooses others"
    ));
    Ok(Some(found))
}

/// Returns the path of a flag's file, which does not depend on the experiment's folder.
fn absolute(flag: &str, file: Option<&Path>) -> Result<Option<PathBuf>, Failure> {
    file.map(std::path::absolute)
        .transpose()
        .map_err(|error| Failure::file(format!("the folder of {flag} is not known: {error}")))
}

/// Returns a flag that the first interrupt of the user sets; the second one ends the program.
#[expect(
    clippy::exit,
    reason = "the second interrupt ends the program as one without a handler does"
)]
fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    // Without a handler an interrupt ends the program, and earlier results stay.
    let _ = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        complain(
            "the search stops, and its best motion is judged; press Ctrl-C again to end without results",
        );
    });
    stop
}

fn say(terminal: Terminal, excited: &Excited, is_stopped: bool) {
    let excitation = &excited.excitation;
    let motion = &excitation.motion;
    let highest = motion.harmonics.last().copied().unwrap_or(1) as f64 * motion.base_frequency_hz;
    terminal.say(format!(
        "{}: {} s, {} to {} Hz, {}{}",
        excitation.robot,
        significant(motion.duration_s, 4),
        significant(motion.base_frequency_hz, 3),
        significant(highest, 3),
        if excitation.is_certified {
            "every limit holds"
        } else {
            "limits are broken"
        },
        if is_stopped { ", search stopped" } else { "" }
    ));
    if motion.approach_s > 0.0 {
        terminal.say(format!(
            "approach from start_rad: {} s before the motion",
            significant(motion.approach_s, 3)
        ));
    } else {
        let poses: Vec<String> = (motion.joints.iter())
            .map(|joint| significant(joint.start_rad, 4))
            .collect();
        terminal.say(format!(
            "the motion starts at [{}] rad (m)",
            poses.join(", ")
        ));
    }
    let near: Vec<String> = (excitation.limits.iter())
        .filter(|limit| limit.used_percent >= NEAR_PERCENT)
        .map(|limit| {
            let joint = limit
                .joint
                .as_deref()
                .map_or(String::new(), |name| format!(" of {name}"));
            format!(
                "{}{joint} {} %",
                limit.quantity,
                significant(limit.used_percent, 3)
            )
        })
        .collect();
    if !near.is_empty() {
        terminal.say(format!("limits in use: {}", near.join(", ")));
    }
    terminal.table(&promise_table(excitation));
    for parameter in excitation.undetermined() {
        terminal.say(format!(
            "{} is not determined: {}",
            short(&parameter.name),
            parameter
                .cure
                .as_deref()
                .unwrap_or("its standard error exceeds its value")
        ));
    }
    if let Some(slow) = &excitation.slow {
        terminal.say(format!(
            "slow motion for friction: {} s, slow.csv",
            significant(slow.duration_s, 4)
        ));
    }
    for more in &excitation.more {
        terminal.say(format!(
            "{}: standard errors times {}",
            more.what,
            significant(more.factor, 3)
        ));
    }
    for assumed in &excitation.assumed {
        terminal.say(format!("assumed: {assumed}"));
    }
}

fn promise_table(excitation: &Excitation) -> Grid {
    let header = ["parameter", "unit", "value", "± s.e.", "%"];
    let mut table = Grid::new(header, 2).divided(3, 2);
    for promised in &excitation.promise {
        let error = promised.is_determined.then_some(promised.standard_error);
        table.add_row(vec![
            short(&promised.name).into_owned(),
            promised.unit.clone(),
            significant(promised.value, 5),
            dash(error, 2),
            dash(
                promised.relative_percent.filter(|_| promised.is_determined),
                2,
            ),
        ]);
    }
    table
}
