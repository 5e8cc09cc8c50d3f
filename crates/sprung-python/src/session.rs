//! Experiments: check, identify, validate, simulate, excite, control, sample, export.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use sprung::export::{Form, Format};
use sprung::log::{Arrays, Input, LogSource};
use sprung::session::{
    Disk, ExciteRequest, ExportRequest, Files, Parameters, QuantityArrays, ReadIdentification,
    SampleRequest, SessionError, WatchRequest,
};
use sprung::watch::WatchEvent;

use crate::arrays;
use crate::control::{Designed, design, watch_of};
use crate::dynamics::Dynamics;
use crate::errors::{exception, wrong_input};
use crate::excite::{Excited, Source, Values, method};
use crate::results::{Checked, Identified, Validated, Watched, file};
use crate::runner::Run;
use crate::sample::Drawn;
use crate::servo::{IdentifiedServo, ServoCheck};

type Named<'py> = Vec<(String, Bound<'py, PyAny>)>;

/// Name of the demo of a position servo, and its files.
const SERVO: &str = "demo-servo";
const SERVO_EXPERIMENT: &str = include_str!("../../../examples/servo-pendulum/experiment.toml");
const SERVO_TRUTH: &str = include_str!("../../../examples/servo-pendulum/truth.toml");

/// An experiment, its robot's equations, and access to its files.
#[pyclass(frozen, module = "sprung._sprung")]
pub(crate) struct Session {
    inner: Arc<sprung::session::Session>,
}

/// Logs in memory, and the session that knows their columns.
struct InMemory {
    session: Arc<sprung::session::Session>,
    logs: Vec<Arrays>,
}

/// Logs in memory that an experiment reads, and its session.
type Loaded = (Arc<sprung::session::Session>, Vec<LogSource<'static>>);

impl InMemory {
    fn sources(logs: Vec<Arrays>) -> Vec<LogSource<'static>> {
        (logs.into_iter())
            .map(|arrays| LogSource::arrays(format!("arrays {}", arrays.digest()), arrays))
            .collect()
    }
}

impl Session {
    pub(crate) fn shared(&self) -> Arc<sprung::session::Session> {
        Arc::clone(&self.inner)
    }

    fn of(py: Python<'_>, made: Result<sprung::session::Session, SessionError>) -> PyResult<Self> {
        made.map(|inner| Self {
            inner: Arc::new(inner),
        })
        .map_err(|error| exception(py, &error))
    }

    /// Returns the session, and logs in memory if there are any.
    fn given(
        &self,
        py: Python<'_>,
        logs: Option<Vec<Named<'_>>>,
    ) -> PyResult<(Arc<sprung::session::Session>, Option<Vec<Arrays>>)> {
        Ok(match logs {
            None => (Arc::clone(&self.inner), None),
            Some(logs) => {
                let InMemory { session, logs } = self.in_memory(py, logs)?;
                (session, Some(logs))
            }
        })
    }

    /// Takes arrays as logs with the payloads of the files that they replace.
    fn loaded(&self, py: Python<'_>, logs: Vec<Named<'_>>) -> PyResult<Loaded> {
        let payloads = self.inner.payloads(logs.len());
        let payloads = payloads.map_err(|error| exception(py, &error))?;
        let InMemory { session, logs } = self.in_memory(py, logs)?;
        let sources = InMemory::sources(logs).into_iter().zip(payloads);
        let loaded = sources.map(|(source, payload)| source.carrying(payload));
        Ok((session, loaded.collect()))
    }

    /// Takes arrays as logs, by the names of columns or of quantities.
    fn in_memory(&self, py: Python<'_>, logs: Vec<Named<'_>>) -> PyResult<InMemory> {
        let by_quantity = (logs.first()).is_some_and(|first| {
            (self.inner).is_by_quantity(first.iter().map(|(name, _)| name.as_str()))
        });
        let session = self.inner.without_files();
        let mut in_memory = InMemory {
            session: Arc::new(session.clone()),
            logs: Vec::new(),
        };
        for log in logs {
            if !by_quantity {
                in_memory.logs.push(arrays::log(py, log)?);
                continue;
            }
            let mut quantities = Vec::new();
            for (name, array) in log {
                let arrays = arrays::arrays(&array)?;
                quantities.push(QuantityArrays { name, arrays });
            }
            let with = session.with_quantities(quantities);
            let (session, arrays) = with.map_err(|error| exception(py, &error))?;
            in_memory.session = Arc::new(session);
            in_memory.logs.push(arrays);
        }
        Ok(in_memory)
    }
}

#[pymethods]
impl Session {
    /// Reads an experiment from disk.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        let made = py.detach(|| sprung::session::Session::open(&path, &overrides));
        Self::of(py, made)
    }

    /// Reads an experiment from text; paths in it are relative to a folder.
    #[staticmethod]
    fn read(
        py: Python<'_>,
        name: &str,
        text: &str,
        overrides: Vec<String>,
        folder: PathBuf,
    ) -> PyResult<Self> {
        let made = py.detach(|| sprung::session::Session::read_in(name, text, &overrides, folder));
        Self::of(py, made)
    }

    /// Reads the experiment of a demo.
    ///
    /// - `name`: `demo`, or `demo-servo` for a position servo.
    #[staticmethod]
    fn demo(py: Python<'_>, name: &str, overrides: Vec<String>) -> PyResult<Self> {
        let (text, truth) = match name {
            SERVO => (SERVO_EXPERIMENT, SERVO_TRUTH),
            _ => (sprung::demo::EXPERIMENT, sprung::demo::TRUTH),
        };
        let files = move |path: &Path| -> std::io::Result<Box<dyn Input>> {
            if path == Path::new("truth.toml") {
                return Ok(Box::new(Cursor::new(truth.as_bytes())));
            }
            Disk.open(path)
        };
        let made = sprung::session::Session::read(name, text, &overrides, files);
        Self::of(py, made)
    }

    #[getter]
    fn text(&self) -> &str {
        self.inner.text()
    }

    #[getter]
    fn robot(&self) -> &str {
        &self.inner.experiment().robot.name
    }

    #[getter]
    fn joints(&self) -> Vec<String> {
        self.inner.model().joints().to_vec()
    }

    /// Names and units of the parameters.
    #[getter]
    fn parameters(&self) -> Vec<(String, String)> {
        (self.inner.model().parameters().iter())
            .map(|parameter| (parameter.name.clone(), parameter.unit.to_owned()))
            .collect()
    }

    #[getter]
    fn log_columns(&self) -> Vec<String> {
        self.inner.log_columns()
    }

    #[getter]
    fn results_folder(&self) -> PathBuf {
        self.inner.results_folder()
    }

    /// Files that the experiment names, and its own.
    #[getter]
    fn inputs(&self) -> Vec<PathBuf> {
        self.inner.inputs()
    }

    #[getter]
    fn validations(&self) -> Vec<String> {
        let runs = &self.inner.experiment().validate;
        runs.iter().map(|run| run.name.clone()).collect()
    }

    #[getter]
    fn is_servo(&self) -> bool {
        self.inner.is_servo()
    }

    /// Tells what the logs of a position servo, or arrays, determine; returns the text of
    /// `servo-check.json`.
    fn check_servo(
        &self,
        py: Python<'_>,
        logs: Option<Vec<Named<'_>>>,
        run: Run,
    ) -> PyResult<String> {
        // The payloads of a servo's logs belong to the files that the experiment names.
        let (_, logs) = self.given(py, logs)?;
        let session = Arc::clone(&self.inner);
        let (parameters, findings) = run.work(py, move |progress| match logs {
            None => session.check_servo(progress),
            Some(logs) => session.check_servo_with(&mut InMemory::sources(logs), progress),
        })?;
        Ok(file(&ServoCheck::new(parameters, findings)))
    }

    /// Identifies a position servo from the logs of the experiment, or from arrays.
    fn identify_servo(
        &self,
        py: Python<'_>,
        logs: Option<Vec<Named<'_>>>,
        run: Run,
    ) -> PyResult<IdentifiedServo> {
        let text = self.inner.text().to_owned();
        // The payloads of a servo's logs belong to the files that the experiment names.
        let (_, logs) = self.given(py, logs)?;
        let session = Arc::clone(&self.inner);
        let found = run.work(py, move |progress| match logs {
            None => session.identify_servo(progress),
            Some(logs) => session.identify_servo_with(&mut InMemory::sources(logs), progress),
        })?;
        Ok(IdentifiedServo::new(found, text))
    }

    /// Simulates the twin of a position servo; returns the path and the columns of each log.
    fn simulate_servo<'py>(
        &self,
        py: Python<'py>,
        identified: Option<&IdentifiedServo>,
        seed: Option<u64>,
        run: Run,
    ) -> PyResult<Vec<(PathBuf, Bound<'py, PyDict>)>> {
        let session = Arc::clone(&self.inner);
        let parameters = identified.map(|identified| Parameters::from(identified.found()));
        let logs = run.work(py, move |progress| {
            let mut twin = session.servo_twin(parameters.as_ref())?;
            if let Some(seed) = seed {
                twin = twin.with_seed(seed);
            }
            let files = twin.files().to_vec();
            let mut logs = Vec::new();
            for (index, file) in files.into_iter().enumerate() {
                let mut csv = Vec::new();
                twin.write(index, &mut csv, progress)?;
                logs.push((file, csv));
            }
            Ok(logs)
        })?;
        (logs.into_iter())
            .map(|(file, csv)| Ok((file, arrays::columns_by_name(py, &csv)?)))
            .collect()
    }

    /// Returns the true parameters of the twin of a position servo.
    fn truth_of_servo(&self, py: Python<'_>) -> PyResult<BTreeMap<String, f64>> {
        let twin = self.inner.servo_twin(None);
        twin.map(|twin| twin.truth())
            .map_err(|error| exception(py, &error))
    }

    /// Checks the logs of the experiment, or arrays.
    fn check(&self, py: Python<'_>, logs: Option<Vec<Named<'_>>>, run: Run) -> PyResult<Checked> {
        let text = self.inner.text().to_owned();
        let checked = match logs {
            None => {
                let session = Arc::clone(&self.inner);
                run.work(py, move |progress| session.check(progress))
            }
            Some(logs) => {
                let (session, mut logs) = self.loaded(py, logs)?;
                run.work(py, move |progress| session.check_with(&mut logs, progress))
            }
        };
        Ok(Checked::new(checked?, text))
    }

    /// Returns the session with the laws of earlier identifications.
    fn with_laws_from(
        &self,
        py: Python<'_>,
        earlier: Vec<PyRef<'_, Identified>>,
    ) -> PyResult<Self> {
        let earlier: Vec<ReadIdentification> = (earlier.iter())
            .map(|identified| ReadIdentification {
                path: PathBuf::from("laws_from"),
                identification: identified.found().identification.clone(),
            })
            .collect();
        Self::of(py, self.inner.with_laws_from(&earlier))
    }

    /// Identifies the parameters from the logs of the experiment, or from arrays.
    fn identify(
        &self,
        py: Python<'_>,
        logs: Option<Vec<Named<'_>>>,
        run: Run,
    ) -> PyResult<Identified> {
        let text = self.inner.text().to_owned();
        let given = match logs {
            None => None,
            Some(logs) => Some(self.loaded(py, logs)?),
        };
        let session = Arc::clone(&self.inner);
        let (found, seconds) = run.work(py, move |progress| {
            let begin = Instant::now();
            let found = match given {
                None => session.identify(progress),
                Some((session, mut logs)) => session.identify_with(&mut logs, progress),
            }?;
            Ok((found, begin.elapsed().as_secs_f64()))
        })?;
        Ok(Identified::new(found, text).after(seconds))
    }

    /// Validates an identification on the runs of the experiment, on arrays, or on files.
    fn validate(
        &self,
        py: Python<'_>,
        identified: &Identified,
        logs: Option<Vec<Named<'_>>>,
        files: Option<Vec<PathBuf>>,
        run: Run,
    ) -> PyResult<Validated> {
        let found = identified.found();
        let parameters = Parameters::from(found.identification.clone());
        let validated = match logs {
            None => {
                let session = match files {
                    None => Arc::clone(&self.inner),
                    Some(files) => Arc::new(self.inner.with_run_files(files)),
                };
                run.work(py, move |progress| session.validate(&parameters, progress))
            }
            Some(logs) => {
                let InMemory { session, logs } = self.in_memory(py, logs)?;
                let session = Arc::new(session.with_runs(logs.len()));
                run.work(py, move |progress| {
                    let mut sources: Vec<Vec<LogSource<'_>>> = (InMemory::sources(logs)
                        .into_iter())
                    .map(|source| vec![source])
                    .collect();
                    session.validate_with(&parameters, &mut sources, progress)
                })
            }
        };
        let text = self.inner.text().to_owned();
        Ok(Validated::new(
            validated?,
            Arc::clone(identified.shared()),
            text,
        ))
    }

    /// Watches arrays or files with an identification.
    ///
    /// - `identified`: an identification and the index of its result; `healthy`: arrays in place of the logs of the experiment.
    /// - `request`: false alarms per hour, and whether an unusable result is taken.
    #[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
    fn watch(
        &self,
        py: Python<'_>,
        identified: (PyRef<'_, Identified>, usize),
        logs: Option<Vec<Named<'_>>>,
        files: Option<Vec<PathBuf>>,
        healthy: Option<Vec<Named<'_>>>,
        request: (f64, bool),
        run: Run,
    ) -> PyResult<Watched> {
        let (identified, set) = identified;
        let parameters = Parameters::from(identified.found().identification.clone());
        let request = WatchRequest {
            false_alarms_per_h: request.0,
            accept_unusable: request.1,
            set,
            follow_s: None,
        };
        let (session, watched) = self.given(py, logs)?;
        let (_, healthy) = self.given(py, healthy)?;
        let found = run.work(py, move |progress| {
            let mut healthy = healthy.map(InMemory::sources);
            let tell = &mut |_: &WatchEvent| ();
            match watched {
                None => {
                    let files = files.unwrap_or_default();
                    session.watch(&parameters, &files, &request, tell, progress)
                }
                Some(watched) => {
                    let mut watched = InMemory::sources(watched);
                    let given = (healthy.as_deref_mut(), &mut *watched);
                    session.watch_with(&parameters, given, &request, tell, progress)
                }
            }
        })?;
        Ok(Watched::new(found))
    }

    /// Simulates the twin; returns its columns by name.
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        validation: Option<String>,
        values: Option<Values<'_>>,
        seed: Option<u64>,
        run: Run,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (session, source) = (Arc::clone(&self.inner), values.map(Source::from));
        let csv = run.work(py, move |progress| {
            let parameters = source.map(Source::read).transpose()?;
            let mut twin = session.twin(validation.as_deref(), parameters.as_ref())?;
            if let Some(seed) = seed {
                twin = twin.with_seed(seed);
            }
            let mut csv = Vec::new();
            twin.write(&mut csv, progress)?;
            Ok(csv)
        })?;
        arrays::columns_by_name(py, &csv)
    }

    /// Returns the true parameters of the twin.
    fn truth(&self, py: Python<'_>) -> PyResult<BTreeMap<String, f64>> {
        let twin = self.inner.twin(None, None);
        twin.map(|twin| twin.truth())
            .map_err(|error| exception(py, &error))
    }

    /// Designs an experiment: a motion within the limits of the robot, and what it promises.
    fn excite(
        &self,
        py: Python<'_>,
        method: &str,
        warm_up: bool,
        parameters: Option<Values<'_>>,
        files: (Option<PathBuf>, Option<PathBuf>),
        run: Run,
    ) -> PyResult<Excited> {
        let (from_log, reference) = files;
        let request = ExciteRequest {
            method: self::method(py, method)?,
            is_warm_up: warm_up,
            from_log,
            reference,
        };
        let (session, source) = (Arc::clone(&self.inner), parameters.map(Source::from));
        let excited = run.work(py, move |progress| {
            let parameters = source.map(Source::read).transpose()?;
            session.excite(&request, parameters.as_ref(), progress)
        })?;
        Ok(Excited::new(Arc::clone(&self.inner), excited))
    }

    /// Designs a controller, and proves it on robots from the posterior.
    fn control(
        &self,
        py: Python<'_>,
        parameters: Values<'_>,
        accept_unusable: bool,
        run: Run,
    ) -> PyResult<Designed> {
        let source = Source::from(parameters);
        let session = Arc::clone(&self.inner);
        let controlled = run.work(py, move |progress| {
            session.control(&source.read()?, accept_unusable, progress)
        })?;
        Ok(Designed::new(Arc::clone(&self.inner), controlled))
    }

    /// Draws robots from the posterior of one result of an identification.
    fn sample(
        &self,
        py: Python<'_>,
        identified: &Identified,
        set: usize,
        draws: (usize, u64),
        accept_unusable: bool,
        run: Run,
    ) -> PyResult<Drawn> {
        let (count, seed) = draws;
        let request = SampleRequest {
            count,
            seed,
            set,
            accept_unusable,
        };
        let session = Arc::clone(&self.inner);
        let parameters = Parameters::from(identified.found().identification.clone());
        let samples = run.work(py, move |_| session.sample(&parameters, &request))?;
        Ok(Drawn::new(samples))
    }

    /// Returns the robot with the parameters of one result of an identification.
    fn dynamics(&self, py: Python<'_>, identified: &Identified, set: usize) -> PyResult<Dynamics> {
        let parameters = Parameters::from(identified.found().identification.clone());
        let made = self.inner.dynamics(&parameters, set);
        made.map(Dynamics::new)
            .map_err(|error| exception(py, &error))
    }

    /// Writes an identified robot for simulators and controllers; returns texts by file name.
    ///
    /// - `identified`: an identification and the index of its result.
    /// - `rigid`: whether rigid joints replace springs; `beside`: texts of `control.json` and of `watch.json`.
    #[expect(clippy::too_many_arguments, reason = "Python gives them by name")]
    fn export(
        &self,
        py: Python<'_>,
        identified: (PyRef<'_, Identified>, usize),
        format: &str,
        rigid: bool,
        beside: (Option<String>, Option<String>),
        file: PathBuf,
        run: Run,
    ) -> PyResult<Vec<(String, String)>> {
        let format = format_of(py, format)?;
        let ((identified, set), (control, watch)) = (identified, beside);
        let watch = watch.map(|text| watch_of(py, &text)).transpose()?;
        let control = control.map(|text| design(py, &text)).transpose()?;
        let session = Arc::clone(&self.inner);
        let parameters = Parameters::from(identified.found().identification.clone());
        let exported = run.work(py, move |_| {
            let request = ExportRequest {
                file: &file,
                format,
                form: form(rigid),
                set,
                control: control.as_ref(),
                watch: watch.as_ref(),
            };
            session.export(&parameters, &request)
        })?;
        let names = format.files().iter().map(|name| (*name).to_owned());
        Ok(names.zip(exported.texts).collect())
    }
}

pub(crate) fn format_of(py: Python<'_>, word: &str) -> PyResult<Format> {
    Format::of_word(word).ok_or_else(|| {
        let text = format!("the format \"{word}\" is not known");
        let remedy = format!("give one of {}", Format::ALL.map(Format::word).join(", "));
        wrong_input(py, "format", &text, &remedy)
    })
}

pub(crate) fn form(rigid: bool) -> Form {
    if rigid { Form::Rigid } else { Form::Flexible }
}
