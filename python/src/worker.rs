//! A world on a thread of its own. An app of Bevy stays on the thread on which it was made, while
//! Python may call from any thread, and is to be free while the engine solves.

use std::num::NonZero;
use std::sync::mpsc::{self, Sender};
use std::thread::{self, ThreadId, available_parallelism};

use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;

use crate::errors::{Error, engine_error};
use crate::model::Model;

/// Stack of the thread, bytes, as in the program.
const STACK: usize = 8 << 20;

type Job = Box<dyn FnOnce(&mut Model) + Send>;

/// A thread with a [`Model`].
pub struct Worker {
    jobs: Sender<Job>,
    thread: ThreadId,
}

impl Worker {
    /// Starts a thread, which makes its model, with at most this number of threads for its solves.
    pub fn start(
        py: Python,
        threads: Option<usize>,
        make: impl FnOnce() -> Result<Model, Error> + Send + 'static,
    ) -> PyResult<Self> {
        let cores = available_parallelism().map_or(1, NonZero::get);
        let threads = threads.map_or(cores, |threads| threads.clamp(1, cores));
        let (jobs, todo) = mpsc::channel::<Job>();
        let (made, answer) = mpsc::channel();
        let work = move || {
            let pool = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build();
            let pool = match pool {
                Ok(pool) => pool,
                Err(error) => {
                    let _ = made.send(Err(Error::Engine(error.to_string())));
                    return;
                }
            };
            pool.install(move || {
                let mut model = match make() {
                    Ok(model) => model,
                    Err(error) => {
                        let _ = made.send(Err(error));
                        return;
                    }
                };
                let _ = made.send(Ok(thread::current().id()));
                for job in todo {
                    job(&mut model);
                }
            });
        };
        let name = thread::Builder::new().name("clastic".to_owned());
        name.spawn(work).map_err(|error| engine_error(&error.to_string()))?;
        let thread = match py.detach(move || answer.recv()) {
            Ok(made) => made.map_err(|error| error.raise(py))?,
            Err(_) => return Err(stopped()),
        };
        Ok(Self { jobs, thread })
    }

    /// Does something with the model while Python's lock is free.
    pub fn call<T: Send + 'static>(
        &self,
        py: Python,
        job: impl FnOnce(&mut Model) -> T + Send + 'static,
    ) -> PyResult<T> {
        if thread::current().id() == self.thread {
            return Err(engine_error(
                "a function of loads cannot use the simulation that calls it; it has all it needs in its \
                 argument",
            ));
        }
        let (done, answer) = mpsc::channel();
        let job = Box::new(move |model: &mut Model| {
            let _ = done.send(job(model));
        });
        self.jobs.send(job).map_err(|_| stopped())?;
        py.detach(move || answer.recv()).map_err(|_| stopped())
    }

    /// As [`call`](Self::call), for what may fail.
    pub fn attempt<T: Send + 'static>(
        &self,
        py: Python,
        job: impl FnOnce(&mut Model) -> Result<T, Error> + Send + 'static,
    ) -> PyResult<T> {
        self.call(py, job)?.map_err(|error| error.raise(py))
    }
}

fn stopped() -> PyErr {
    engine_error("the engine has stopped; standard error has its message")
}
