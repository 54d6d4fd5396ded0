//! Work in parts, on threads, while the thread that asked for it listens for Ctrl-C and tells of progress.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::available_parallelism;
use std::time::Duration;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::queries::FEW;

/// So often is Python asked whether to go on: Ctrl-C has a tenth of a second.
const WATCH: Duration = Duration::from_millis(40);

/// A part of the work, and how many rays it is.
pub(crate) struct Task<'a> {
    pub(crate) rays: usize,
    pub(crate) work: Box<dyn FnOnce() + Send + 'a>,
}

/// On how many threads, and whom to tell.
pub(crate) struct Watch<'py> {
    pub(crate) py: Python<'py>,
    /// All processors where there is no number.
    pub(crate) threads: Option<usize>,
    /// Called with how many rays are done, and of how many.
    pub(crate) progress: Option<Py<PyAny>>,
    /// Set where Python has been interrupted: one ray may take a while, where it has many hits.
    pub(crate) is_stopped: AtomicBool,
}

/// Pools by number of threads. Their threads do not live on in a forked child, which gets pools of its own.
static POOLS: Mutex<Pools> = Mutex::new(Pools { process: 0, of_threads: BTreeMap::new() });

/// How many threads are as many as processors: asked once, as it reads files.
static PROCESSORS: OnceLock<usize> = OnceLock::new();

struct Pools {
    process: u32,
    of_threads: BTreeMap<usize, Arc<ThreadPool>>,
}

/// How many threads that is.
pub(crate) fn number(threads: Option<usize>) -> PyResult<usize> {
    match threads {
        Some(0) => Err(PyValueError::new_err("threads must be at least 1, not 0")),
        Some(threads) => Ok(threads),
        None => Ok(*PROCESSORS.get_or_init(|| available_parallelism().map_or(1, usize::from))),
    }
}

fn pool(threads: Option<usize>) -> PyResult<Arc<ThreadPool>> {
    let threads = number(threads)?;
    let mut pools = POOLS.lock().unwrap_or_else(PoisonError::into_inner);
    if pools.process != std::process::id() {
        pools.process = std::process::id();
        // To end their threads would be to wait for what the parent alone has.
        std::mem::forget(std::mem::take(&mut pools.of_threads));
    }
    if let Some(pool) = pools.of_threads.get(&threads) {
        return Ok(Arc::clone(pool));
    }
    let name = |thread| format!("trisect-{thread}");
    let pool = ThreadPoolBuilder::new().num_threads(threads).thread_name(name).build();
    let pool = pool.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    Ok(Arc::clone(pools.of_threads.entry(threads).or_insert(Arc::new(pool))))
}

/// Does all parts, in any order; few rays where they are, as to wake a thread takes longer.
///
/// # Errors
/// Where Python has been interrupted, or the one who is told of progress raises: what is begun is finished, and the
/// rest is left undone.
pub(crate) fn all(watch: &Watch, tasks: Vec<Task<'_>>) -> PyResult<()> {
    let total = tasks.iter().map(|task| task.rays).sum::<usize>();
    let progress = watch.progress.as_ref();
    let tell = |py: Python, done: usize| match progress {
        Some(progress) => progress.call1(py, (done, total)).map(drop),
        None => Ok(()),
    };
    if total < FEW {
        for task in tasks {
            (task.work)();
        }
        return tell(watch.py, total);
    }
    let pool = pool(watch.threads)?;
    let (done, is_stopped) = (AtomicUsize::new(0), &watch.is_stopped);
    watch.py.detach(|| {
        pool.in_place_scope(|scope| {
            let (finished, wait) = channel::<()>();
            scope.spawn(|_| {
                let _finished = finished;
                tasks.into_par_iter().with_max_len(1).for_each(|task| {
                    if !is_stopped.load(Ordering::Relaxed) {
                        (task.work)();
                        done.fetch_add(task.rays, Ordering::Relaxed);
                    }
                });
            });
            let listened = listen(&wait, |py| tell(py, done.load(Ordering::Relaxed)));
            is_stopped.store(listened.is_err(), Ordering::Relaxed);
            listened.map(drop)
        })
    })?;
    watch.py.check_signals()?;
    tell(watch.py, total)
}

/// Does one long piece of work on the threads of a pool. Where Python is interrupted it goes on, unheeded, to its end.
///
/// # Errors
/// Where Python has been interrupted.
pub(crate) fn apart<T: Send + 'static>(
    py: Python,
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let pool = pool(threads)?;
    py.detach(|| {
        let (finished, wait) = channel();
        pool.spawn(move || {
            let done: Result<T, Box<dyn Any + Send>> = catch_unwind(AssertUnwindSafe(work));
            // Nobody waits any more where Python was interrupted.
            let _ = finished.send(done);
        });
        match listen(&wait, |_| Ok(()))? {
            Some(Ok(done)) => Ok(done),
            Some(Err(_)) | None => Err(PyRuntimeError::new_err("a thread of trisect panicked")),
        }
    })
}

/// Runs what cannot be interrupted in a pool.
pub(crate) fn within<T: Send>(
    py: Python,
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let pool = pool(threads)?;
    Ok(py.detach(|| pool.install(work)))
}

/// Waits for what is sent; nothing where the sender is gone.
fn listen<T>(
    wait: &Receiver<T>,
    mut tell: impl FnMut(Python) -> PyResult<()>,
) -> PyResult<Option<T>> {
    loop {
        match wait.recv_timeout(WATCH) {
            Ok(sent) => return Ok(Some(sent)),
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
            Err(RecvTimeoutError::Timeout) => Python::attach(|py| {
                py.check_signals()?;
                tell(py)
            })?,
        }
    }
}
