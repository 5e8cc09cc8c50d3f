//! `sprung simulate`: simulates a log with the digital twin.

use sprung::session::{Parameters, Session};

use crate::args::Simulate;
use crate::exit_code::{ExitCode, Failure};
use crate::output::{Output, results_folder};
use crate::record::write_log;
use crate::terminal::Terminal;

pub(crate) fn run(args: &Simulate) -> Result<ExitCode, Failure> {
    let common = &args.common;
    let terminal = Terminal::new(common.voice, common.json);
    let session = Session::open(&args.experiment, &common.overrides)?;
    let parameters = (args.parameters.as_deref())
        .map(Parameters::open)
        .transpose()?;
    let twin = session.twin(args.run.as_deref(), parameters.as_ref())?;

    let mut output = Output::new(&results_folder(&session, common))?.keeping(session.inputs());
    let path = write_log(&twin, &mut output, terminal)?;
    output.commit()?;
    terminal.json(&serde_json::json!({ "log": path }));
    terminal.say(format!("log: {}", path.display()));
    Ok(ExitCode::Done)
}
