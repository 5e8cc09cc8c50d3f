//! `sprung watch`: watches a running robot with its identified model.

use std::path::{Path, PathBuf};

use sprung::report::compose_watch;
use sprung::session::WatchRequest;
use sprung::watch::{Watch, WatchEvent, Watched};

use super::begin::Opened;
use crate::args;
use crate::command_line::command_line;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::results::{write_html, write_json};
use crate::terminal::{Grid, dash};

/// Names of the files of a watch.
const WATCH_FILE: &str = "watch.json";
const CURVES_FILE: &str = "watch.csv";
const REPORT_FILE: &str = "watch.html";
const FILES: [&str; 3] = [WATCH_FILE, CURVES_FILE, REPORT_FILE];

pub(crate) fn run(args: &args::Watch) -> Result<ExitCode, Failure> {
    let opened = Opened::new(
        &args.experiment,
        &args.common,
        (args.parameters.as_deref(), args.accept_refining),
        |_| Ok(()),
    )?;
    let logs = files(&args.log)?;
    let watched = logs.iter().filter(|log| log.as_os_str() != "-").cloned();
    let folder = Folder::new(&opened.path, opened.inputs().chain(watched), &FILES)?;
    let Opened {
        session,
        terminal,
        parameters,
        ..
    } = opened;
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
            Failure::file(format!("cannot read {}: {error}", path.display()))
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
            return Err(Failure::file(message));
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
    let mut grid = Grid::new(header, 1);
    for joint in &watch.joints {
        grid.add_row([joint.joint.clone(), dash(joint.typical_threshold_nm, 3)]);
    }
    grid
}
