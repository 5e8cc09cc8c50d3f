//! `sprung watch`: watches a running robot with its identified model.

use sprung::session::{Parameters, Session, WatchRequest, find_identification};
use sprung::watch::{Watch, Watched};

use super::begin::refuse_refining;
use crate::args;
use crate::exit_code::{ExitCode, Failure};
use crate::output::{Folder, results_folder};
use crate::results::write_json;
use crate::terminal::Terminal;

/// Names of the files of a watch.
const WATCH_FILE: &str = "watch.json";
const CURVES_FILE: &str = "watch.csv";
const FILES: [&str; 2] = [WATCH_FILE, CURVES_FILE];

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
    let inputs = session.inputs().into_iter().chain([file.clone()]);
    let folder = Folder::new(&path, inputs, &FILES)?;
    let request = WatchRequest {
        false_alarms_per_h: args.false_alarms_per_h,
        accept_unusable: args.accept_unusable,
        ..WatchRequest::default()
    };
    let found = terminal.follow("watching", |progress| {
        session.watch(&parameters, &args.log, &request, &mut |_| (), progress)
    })?;
    let Watched { watch, curves } = &found;
    let mut output = folder.output()?;
    write_json(&mut output, WATCH_FILE, watch)?;
    output.text(CURVES_FILE, &curves.to_csv("curve"))?;
    output.commit()?;
    terminal.json(watch);
    terminal.say(said(watch));
    Ok(if watch.events.is_empty() {
        ExitCode::Done
    } else {
        ExitCode::Unusable
    })
}

fn said(watch: &Watch) -> String {
    let lines = watch.events.iter().map(|event| format!("{}: {}", event.log, event.finding.text));
    lines.collect::<Vec<_>>().join("\n")
}
