//! `sprung export`: writes an identified robot for simulators and controllers.

use std::path::Path;

use serde::Serialize;
use sprung::export::{Earlier, Exported, Form, Proof, Said, earlier};
use sprung::session::{Disk, ExportRequest, Files, Usability, read_control, read_watch};

use super::begin::Opened;
use crate::args::Export;
use crate::exit_code::{ExitCode, Failure};
use crate::output::Folder;
use crate::terminal::{Grid, Terminal};

/// What `--json` prints.
#[derive(Serialize)]
struct Summary<'a> {
    files: &'a [String],
    said: &'a [Said],
    proof: Proof,
}

pub(crate) fn run(args: &Export) -> Result<ExitCode, Failure> {
    let format = args.format;
    let opened = Opened::new(
        &args.experiment,
        &args.common,
        (args.parameters.as_deref(), args.accept_refining),
        |session| session.allow_export(format),
    )?;
    let form = if args.rigid {
        Form::Rigid
    } else {
        Form::Flexible
    };
    let control = args.control.as_deref().map(read_control).transpose()?;
    let watch = args.watch.as_deref().map(read_watch).transpose()?;
    let codes = args.control.iter().chain(&args.watch).cloned();
    let folder = Folder::new(&opened.path, opened.inputs().chain(codes), format.files())?;
    let Opened {
        session,
        terminal,
        path,
        file,
        parameters,
    } = opened;
    if !args.force {
        for file in format.files() {
            refuse_edited(&path.join(file))?;
        }
    }
    let request = ExportRequest {
        file: &file,
        format,
        form,
        set: 0,
        control: control.as_ref(),
        watch: watch.as_ref(),
    };
    let found = session.export(&parameters, &request)?;
    let mut output = folder.output()?;
    let mut files = Vec::new();
    for (file, text) in format.files().iter().zip(&found.texts) {
        files.push(output.text(file, text)?.display().to_string());
    }
    output.commit()?;

    terminal.json(&Summary {
        files: &files,
        said: &found.said,
        proof: found.proof,
    });
    say(terminal, &found);
    terminal.say(format!("\n{}: {}", format.name(), files.join(", ")));
    let usability = parameters.identification.as_ref().map(Usability::from);
    if usability == Some(Usability::Unusable) {
        terminal.say("The verdict on these parameters is unusable: do not rely on this file.");
    }
    Ok(usability.map_or(ExitCode::Done, ExitCode::from))
}

/// Refuses to replace a file that somebody edited or that no export wrote.
fn refuse_edited(file: &Path) -> Result<(), Failure> {
    let text = match Disk.text(file) {
        Ok(text) => text,
        // No export of sprung, whatever it is.
        Err(error) if error.kind() == std::io::ErrorKind::InvalidData => String::new(),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(error) => {
            let name = file.display();
            return Err(Failure::file(format!(
                "cannot read the earlier {name}: {error}"
            )));
        }
    };
    let what = match earlier(&text) {
        Earlier::Unchanged => return Ok(()),
        Earlier::Edited => "was edited since sprung export wrote it",
        Earlier::Foreign => "was not written by sprung export",
    };
    Err(Failure::usage(format!(
        "{} {what}; replace it with --force, or choose a folder with --out",
        file.display()
    )))
}

fn say(terminal: Terminal, found: &Exported) {
    let header = ["what", "how", "note"];
    let mut table = Grid::new(header, 3);
    for row in &found.said {
        table.add_row([
            row.what.clone(),
            row.how.word().to_owned(),
            row.note.clone(),
        ]);
    }
    terminal.table(&table);
    let Proof {
        states,
        inverse_dynamics,
        mass_matrix,
        accelerations,
    } = found.proof;
    terminal.say(format!(
        "\nread back: at {states} random states inverse dynamics, mass matrix and accelerations differ from the \
         identified model by at most {inverse_dynamics:.0e}, {mass_matrix:.0e} and {accelerations:.0e} (relative)"
    ));
}
