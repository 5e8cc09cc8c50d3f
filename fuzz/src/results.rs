//! Files of results, which people exchange and edit.

use std::path::Path;
use std::sync::OnceLock;

use sprung::control::ControlDesign;
use sprung::demo;
use sprung::export::{Form, Format};
use sprung::log::Input;
use sprung::progress::Unheard;
use sprung::session::{
    ExportRequest, Parameters, SampleRequest, Session, compare_files, read_control, read_watch,
};
use sprung::watch::Watch;

use crate::written;

/// Reads an identification or a validation, compares it with itself, exports the robot and draws others.
pub fn read_identification(data: &[u8]) {
    let one = written("one/identification.json", data);
    let other = written("other/identification.json", data);
    let _ = compare_files(&[&one, &other], &mut Unheard);
    if let Ok(parameters) = Parameters::open(&one) {
        export(&one, &parameters, Code::default());
        let request = SampleRequest {
            count: 2,
            accept_unusable: true,
            ..SampleRequest::default()
        };
        let _ = session().sample(&parameters, &request);
    }
}

/// Reads values in TOML and exports the robot with them.
pub fn read_parameters(data: &[u8]) {
    let file = written("parameters.toml", data);
    if let Ok(parameters) = Parameters::open(&file) {
        export(&file, &parameters, Code::default());
    }
}

/// Reads a design of a controller and exports it as code, with the true values of the demo.
pub fn read_design(data: &[u8]) {
    let file = written("control.json", data);
    if let Ok(design) = read_control(&file) {
        export(
            &file,
            truth(),
            Code {
                control: Some(&design),
                watch: None,
            },
        );
    }
}

/// Reads a watch and exports its observer as code, with the true values of the demo.
pub fn read_observer(data: &[u8]) {
    let file = written("watch.json", data);
    if let Ok(watch) = read_watch(&file) {
        export(
            &file,
            truth(),
            Code {
                control: None,
                watch: Some(&watch),
            },
        );
    }
}

/// What code contains beside the robot.
#[derive(Clone, Copy, Default)]
struct Code<'a> {
    control: Option<&'a ControlDesign>,
    watch: Option<&'a Watch>,
}

/// Returns the true values of the demo.
///
/// # Panics
///
/// If they are wrong; they do not depend on the input.
fn truth() -> &'static Parameters {
    static TRUTH: OnceLock<Parameters> = OnceLock::new();
    TRUTH.get_or_init(|| {
        Parameters::open(&written("truth.toml", demo::TRUTH.as_bytes())).expect("it is right")
    })
}

/// Exports the robot in one of the formats; all of them would make the target slow.
fn export(file: &Path, parameters: &Parameters, code: Code) {
    let length = std::fs::metadata(file).map_or(0, |own| own.len() as usize);
    let forms = [Form::Flexible, Form::Rigid];
    let request = ExportRequest {
        file,
        format: Format::ALL[length % Format::ALL.len()],
        form: forms[length / Format::ALL.len() % forms.len()],
        set: 0,
        control: code.control,
        watch: code.watch,
    };
    let _ = session().export(parameters, &request);
}

/// Returns the session of the demo, without its log.
fn session() -> &'static Session {
    static SESSION: OnceLock<Session> = OnceLock::new();
    SESSION.get_or_init(|| {
        let no_log = |_: &Path| -> std::io::Result<Box<dyn Input>> {
            Err(std::io::ErrorKind::NotFound.into())
        };
        Session::read("demo", demo::EXPERIMENT, &[], no_log).expect("the demo is right")
    })
}
