//! Runs a verb on a thread of its own, while the calling thread listens to Python.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use sprung::progress::{Answer, Listener, Progress};
use sprung::session::SessionError;

use crate::errors::{defect, exception};

/// Time between two looks at the signals and the progress.
const LOOK: Duration = Duration::from_millis(50);

/// Progress and stop signal, shared by both threads.
#[derive(Default)]
struct Shared {
    latest: Mutex<Option<Progress>>,
    stop: AtomicBool,
}

struct Heard(Arc<Shared>);

impl Listener for Heard {
    fn hear(&mut self, progress: Progress) -> Answer {
        let mut latest = self.0.latest.lock().unwrap_or_else(PoisonError::into_inner);
        *latest = Some(progress);
        if self.0.stop.load(Ordering::Relaxed) {
            Answer::Stop
        } else {
            Answer::GoOn
        }
    }
}

/// Settings of a run.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Run {
    /// Number of threads; 0 for one per processor.
    threads: usize,
    /// Receives the phase, the work done and the total; stops the run if it returns `False`.
    progress: Option<Py<PyAny>>,
}

impl Run {
    /// Runs a verb without the lock of the interpreter.
    ///
    /// Threads of a pool do not survive a fork, so each run has its own pool. After Ctrl-C the call
    /// returns at once; the verb ends at its next question to the listener and its result is lost.
    ///
    /// # Errors
    ///
    /// The exception of the verb, of the callback, or of a signal.
    pub(crate) fn work<T: Send + 'static>(
        &self,
        py: Python<'_>,
        verb: impl FnOnce(&mut dyn Listener) -> Result<T, SessionError> + Send + 'static,
    ) -> PyResult<T> {
        let shared = Arc::new(Shared::default());
        let (send, receive) = channel();
        let (threads, mut heard) = (self.threads, Heard(Arc::clone(&shared)));
        std::thread::Builder::new()
            .name("sprung".to_owned())
            .spawn(move || {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let result = match pool {
                    Ok(pool) => pool.install(|| verb(&mut heard)),
                    Err(_) => verb(&mut heard),
                };
                // The caller may have left after Ctrl-C.
                let _ = send.send(result);
            })?;
        let receive = Mutex::new(receive);
        loop {
            let waited = py.detach(|| {
                let receive = receive.lock().unwrap_or_else(PoisonError::into_inner);
                receive.recv_timeout(LOOK)
            });
            match waited {
                Ok(result) => {
                    self.tell(py, &shared)?;
                    return result.map_err(|error| exception(py, &error));
                }
                Err(RecvTimeoutError::Disconnected) => return Err(defect()),
                Err(RecvTimeoutError::Timeout) => {
                    let go_on = py.check_signals().and_then(|()| self.tell(py, &shared));
                    if go_on.is_err() {
                        shared.stop.store(true, Ordering::Relaxed);
                    }
                    if !go_on? {
                        shared.stop.store(true, Ordering::Relaxed);
                    }
                }
            }
        }
    }

    /// Tells the callback the latest progress; returns whether the run continues.
    fn tell(&self, py: Python<'_>, shared: &Shared) -> PyResult<bool> {
        let Some(callback) = &self.progress else {
            return Ok(true);
        };
        let latest = {
            let mut latest = shared.latest.lock().unwrap_or_else(PoisonError::into_inner);
            latest.take()
        };
        let Some(progress) = latest else {
            return Ok(true);
        };
        let arguments = (progress.phase.word(), progress.done, progress.total);
        let answer = callback.call1(py, arguments)?;
        Ok(!matches!(answer.extract::<bool>(py), Ok(false)))
    }
}
