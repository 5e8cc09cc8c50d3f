//! `sprung watch`: watches a running robot with its identified model.

use std::path::{Path, PathBuf};

use sprung::report::compose_watch;
use sprung::session::{Parameters, Session, WatchRequest, find_identification};
use sprung::watch::{Watch, WatchEvent, Watched};

use super::begin::refuse_refining;
use crate::args;
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::{Folder, results_folder};
use crate::results::{write_html, write_json};
use crate::terminal::{Grid, Terminal, dash};

/// Names of the files of a watch.
const WATCH_FILE: &str = "watch.json";
const CURVES_FILE: &str = "watch.csv";
const REPORT_FILE: &str = "watch.html";
const FILES: [&str; 3] = [WATCH_FILE, CURVES_FILE, REPORT_FILE];

pub(crate) fn run(args: &args::Watch) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let session = Session::open(&args.experiment, &common.overrides)?;
    let path = results_folder(&session, common);
    let file = match &args.parameters {
        Some(file) => file.clone(),
        None => find_identification(&path, &session.results_folder())?,
    };
    let parameters = Parameters::open(&file)?;
    refuse_refining(&parameters, &file, args.accept_refining)?;
    let logs = files(&args.log)?;
    let inputs = session.inputs().into_iter().chain([file.clone()]);
    let watched = logs.iter().filter(|log| log.as_os_str() != "-").cloned();
    let folder = Folder::new(&path, inputs.chain(watched), &FILES)?;
    let request = WatchRequest {
        false_alarms_per_h: args.false_alarms_per_h,
        accept_unusable: args.accept_unusable,
        follow_s: args.follow,
        ..WatchRequest::default()
    };
    // Who pipes a log in waits for each event.
    let is_live = args.follow.is_some() || args.log.iter().any(|log| log == Path::new("-"));
    let mut tell = |event: &WatchEvent| {
        if is_live {
            terminal.say(line(event));
        }
    };
    let found = terminal.follow("watching", |progress| {
        session.watch(&parameters, &logs, &request, &mut tell, progress)
    })?;
    let Watched { watch, curves } = &found;
    let mut output = folder.output()?;
    write_json(&mut output, WATCH_FILE, watch)?;
    output.text(CURVES_FILE, &curves.to_csv("curve"))?;
    let document = compose_watch(watch, curves, &command_line());
    let report = write_html(&mut output, REPORT_FILE, &document)?;
    output.commit()?;
    terminal.json(watch);
    if !is_live {
        for event in &watch.events {
            terminal.say(line(event));
        }
    }
    terminal.table(&thresholds(watch));
    terminal.say(format!("\nreport: {}", report.display()));
    terminal.say(watch.sentence());
    Ok(if watch.events.is_empty() {
        ExitCode::Done
    } else {
        ExitCode::Unusable
    })
}

/// Returns the logs; those of a folder in the order of their names. A bag of ROS 2 is a folder and one log.
fn files(given: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut all = Vec::new();
    for path in given {
        if !path.is_dir() || path.join("metadata.yaml").is_file() {
            all.push(path.clone());
            continue;
        }
        let unreadable = |error: std::io::Error| {
            Failure::new(
                ExitCode::File,
                format!("cannot read {}: {error}", path.display()),
            )
        };
        let entries = std::fs::read_dir(path).map_err(unreadable)?;
        let mut of_folder: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.is_file())
            .collect();
        if of_folder.is_empty() {
            let message = format!(
                "{} has no files; give the folder of the logs",
                path.display()
            );
            return Err(Failure::new(ExitCode::File, message));
        }
        of_folder.sort();
        all.extend(of_folder);
    }
    Ok(all)
}

fn line(event: &WatchEvent) -> String {
    format!(
        "{}: {} ({})",
        event.log, event.finding.text, event.finding.code
    )
}

fn thresholds(watch: &Watch) -> Grid {
    let header = ["joint", "contacts from, N·m (N)"];
    let mut grid = Grid::new(header.map(str::to_owned).into(), 1);
    for joint in &watch.joints {
        grid.add_row([joint.joint.clone(), dash(joint.typical_threshold_nm, 3)]);
    }
    grid
}
