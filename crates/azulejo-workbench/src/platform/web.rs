//! A page in a browser: files in memory, and workers instead of threads.
//!
//! A worker is the program once more, with a copy of all the memory of the page: a job that was boxed here
//! is run there, as a process that was forked would. Nothing of its input has to be written and read. Its
//! results come back as bytes.

mod files;

pub use files::*;

use azulejo::formats::disk;
use azulejo::trace::time::Instant;
use azulejo::trace::{Measure, Progress};
use js_sys::{Array, ArrayBuffer, Object, Reflect, Uint8Array, WebAssembly};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Duration;
use wasm_bindgen::closure::Closure;
use wasm_bindgen::{JsCast, JsValue};
use web_sys::{MessageEvent, Worker, WorkerOptions, WorkerType};

/// Whether the workbench is a page in a browser.
pub const IS_PAGE: bool = true;

/// Where the page keeps the program of its workers, beside itself.
const WORKER: &str = "./worker.js";

/// The interval of reports of progress.
const INTERVAL: Duration = Duration::from_millis(100);

/// There is no folder of the user.
pub fn home() -> Option<PathBuf> {
    None
}

/// The folder in which relative paths begin.
pub fn current_folder() -> Option<PathBuf> {
    Some(PathBuf::from("/"))
}

/// Does nothing: neither pages nor workers may sleep.
pub fn sleep(_: Duration) {}

/// Does nothing: the browser chooses.
pub fn lower_priority() {}

/// A job of a worker.
pub type WorkerJob = Box<dyn FnOnce() + Send>;

/// What a worker says, received by the page.
pub enum WorkerMessage {
    /// How far it is.
    Progress(ProgressReport),
    /// A result.
    Output(Vec<u8>),
    /// It has ended, with an error message if it failed.
    Ended(Option<String>),
}

/// How far a worker is.
pub struct ProgressReport {
    stage: String,
    done: f64,
    total: f64,
    measures: Vec<Measure>,
}

impl ProgressReport {
    /// Shows it in the progress of the page.
    pub fn show(&self, progress: &Progress) {
        progress.begin(&self.stage, self.total as u64);
        // The job itself was cancelled, if it was.
        let _ = progress.advance(self.done as u64);
        self.measures.iter().for_each(|m| progress.measured(*m));
    }
}

type Listener = Rc<dyn Fn(WorkerMessage)>;

/// Workers, and jobs that wait for one. All are on the one thread of the page; each worker has a copy.
#[derive(Default)]
struct Workers {
    waiting: HashMap<u64, (WorkerJob, Listener)>,
    running: HashMap<u64, RunningWorker>,
}

struct RunningWorker {
    worker: Worker,
    _on_message: Closure<dyn FnMut(MessageEvent)>,
    _on_error: Closure<dyn FnMut(JsValue)>,
}

thread_local! {
    static WORKERS: RefCell<Workers> = RefCell::default();
    /// Whether this is a worker, and when it last reported its progress.
    static WORKER_SINCE: Cell<Option<Instant>> = const { Cell::new(None) };
}

/// Whether this is a worker.
pub fn is_worker() -> bool {
    WORKER_SINCE.get().is_some()
}

/// Starts a worker for a job after a while in which it may be cancelled; `listen` gets what it says.
pub fn start_worker(
    id: u64,
    after: Duration,
    job: WorkerJob,
    listen: impl Fn(WorkerMessage) + 'static,
) {
    WORKERS.with_borrow_mut(|all| all.waiting.insert(id, (job, Rc::new(listen))));
    let begin = Closure::once_into_js(move || begin(id));
    let after = after.as_millis() as i32;
    let window = web_sys::window();
    let set = window.map(|w| {
        w.set_timeout_with_callback_and_timeout_and_arguments_0(begin.unchecked_ref(), after)
    });
    if !matches!(set, Some(Ok(_))) {
        end(id, Some("cannot start a worker".into()));
    }
}

/// Ends a worker at once.
pub fn end_worker(id: u64) {
    let (waiting, running) =
        WORKERS.with_borrow_mut(|all| (all.waiting.remove(&id), all.running.remove(&id)));
    drop(waiting);
    if let Some(running) = running {
        running.worker.terminate();
    }
}

/// Ends a worker that says that it has ended, or that has failed.
fn end(id: u64, why: Option<String>) {
    let listener = WORKERS.with_borrow(|all| Some(Rc::clone(&all.waiting.get(&id)?.1)));
    end_worker(id);
    if let Some(listener) = listener {
        listener(WorkerMessage::Ended(why));
    }
}

/// Makes the worker of a job that still waits.
fn begin(id: u64) {
    let listener = WORKERS.with_borrow(|all| Some(Rc::clone(&all.waiting.get(&id)?.1)));
    let Some(listener) = listener else {
        return;
    };
    if let Err(why) = try_begin(id, listener) {
        end(id, Some(format!("cannot start a worker: {}", text(&why))));
        return;
    }
    // It is the worker that runs it. Here it is dropped.
    WORKERS.with_borrow_mut(|all| all.waiting.remove(&id));
}

fn try_begin(id: u64, listener: Listener) -> Result<(), JsValue> {
    let options = WorkerOptions::new();
    options.set_type(WorkerType::Module);
    let worker = Worker::new_with_options(WORKER, &options)?;
    let on_message = {
        let listener = Rc::clone(&listener);
        Closure::new(move |event: MessageEvent| {
            let message = read(&event.data());
            let has_ended = matches!(message, Some(WorkerMessage::Ended(_)));
            if let Some(message) = message {
                listener(message);
            }
            if has_ended {
                end_later(id);
            }
        })
    };
    let on_error = Closure::new(move |event: JsValue| {
        let why = Reflect::get(&event, &"message".into()).ok();
        let why = why.and_then(|w| w.as_string()).unwrap_or_default();
        let why = if why.contains("memory") {
            "there is not enough memory; make the model or the number of patches smaller".to_owned()
        } else {
            format!("internal error: {why}; please report it")
        };
        listener(WorkerMessage::Ended(Some(why)));
        end_later(id);
    });
    worker.set_onmessage(Some(on_message.as_ref().unchecked_ref()));
    worker.set_onerror(Some(on_error.as_ref().unchecked_ref()));
    // Whatever the copy of the memory holds, it holds the waiting job.
    let memory: WebAssembly::Memory = wasm_bindgen::memory().unchecked_into();
    let buffer: ArrayBuffer = memory.buffer().unchecked_into();
    let copy = buffer.slice(0);
    let message = Object::new();
    Reflect::set(&message, &"module".into(), &wasm_bindgen::module())?;
    Reflect::set(&message, &"memory".into(), &copy)?;
    // JavaScript's objects are not in memory, which knows them by their numbers; the page tells which ones every worker
    // has itself.
    let global = js_sys::global();
    let references = Reflect::get(&global, &"azulejoReferences".into())?;
    let references = references.dyn_into::<js_sys::Function>()?.call0(&global)?;
    Reflect::set(&message, &"references".into(), &references)?;
    Reflect::set(&message, &"id".into(), &JsValue::from_f64(id as f64))?;
    worker.post_message_with_transfer(&message, &Array::of1(&copy))?;
    let running = RunningWorker {
        worker,
        _on_message: on_message,
        _on_error: on_error,
    };
    WORKERS.with_borrow_mut(|all| all.running.insert(id, running));
    Ok(())
}

/// A closure must not be dropped while it runs.
fn end_later(id: u64) {
    let end = Closure::once_into_js(move || end_worker(id));
    if let Some(window) = web_sys::window() {
        let _ = window.set_timeout_with_callback(end.unchecked_ref());
    }
}

/// Runs a job in a worker, which has the memory of the page at the time when it was made.
pub fn run_in_worker(id: u64) {
    let job = WORKERS.with(|all| {
        let mut all = all.borrow_mut();
        // What is running in the page is of no concern here.
        std::mem::forget(std::mem::take(&mut all.running));
        all.waiting.remove(&id)
    });
    WORKER_SINCE.set(Some(Instant::now()));
    if let Some((job, listener)) = job {
        std::mem::forget(listener);
        job();
    }
}

/// Sends a message from a worker to its page.
pub fn post(message: WorkerMessage) {
    let post = || -> Result<(), JsValue> {
        let object = Object::new();
        let set = |key: &str, value: &JsValue| Reflect::set(&object, &key.into(), value).map(drop);
        for path in disk::take_written() {
            if let Ok(bytes) = disk::read(&path) {
                let file = Array::of2(
                    &path.to_string_lossy().as_ref().into(),
                    &Uint8Array::from(&bytes[..]),
                );
                send(&Array::of2(&"file".into(), &file))?;
            }
        }
        match message {
            WorkerMessage::Output(bytes) => set("output", &Uint8Array::from(&bytes[..]))?,
            WorkerMessage::Ended(why) => set("ended", &why.unwrap_or_default().into())?,
            WorkerMessage::Progress(report) => {
                set("stage", &report.stage.into())?;
                set("done", &report.done.into())?;
                set("total", &report.total.into())?;
                let measures = report.measures.iter().map(pack_measure);
                set("measures", &measures.collect::<Array>())?;
            }
        }
        send(&object)
    };
    // A page that is gone hears nothing.
    let _ = post();
}

fn send(message: &JsValue) -> Result<(), JsValue> {
    let global = js_sys::global();
    let post = Reflect::get(&global, &"postMessage".into())?;
    let post: js_sys::Function = post.dyn_into()?;
    post.call1(&global, message).map(drop)
}

/// Reports the progress of a worker, not too often.
pub fn report(progress: &Progress) {
    let Some(last) = WORKER_SINCE.get() else {
        return;
    };
    if last.elapsed() < INTERVAL {
        return;
    }
    WORKER_SINCE.set(Some(Instant::now()));
    post_progress(progress);
}

/// Reports the progress of a worker.
pub fn post_progress(progress: &Progress) {
    post(WorkerMessage::Progress(ProgressReport {
        stage: progress.stage(),
        done: progress.done() as f64,
        total: progress.total() as f64,
        measures: progress.take_measures().iter().map(|m| m.measure).collect(),
    }));
}

fn pack_measure(measure: &Measure) -> JsValue {
    let numbers: &[f64] = match *measure {
        Measure::Residual {
            replicate,
            iteration,
            value,
        } => &[0.0, replicate.into(), iteration.into(), value],
        Measure::PatchError(error) => &[1.0, error],
        Measure::Error(error) => &[2.0, error],
        Measure::OutOfReach {
            error,
            seconds,
            rays,
        } => &[3.0, error, seconds, rays],
        _ => &[],
    };
    numbers
        .iter()
        .map(|x| JsValue::from(*x))
        .collect::<Array>()
        .into()
}

fn read_measure(numbers: &[f64]) -> Option<Measure> {
    Some(match *numbers {
        [0.0, replicate, iteration, value] => Measure::Residual {
            replicate: replicate as u32,
            iteration: iteration as u32,
            value,
        },
        [1.0, error] => Measure::PatchError(error),
        [2.0, error] => Measure::Error(error),
        [3.0, error, seconds, rays] => Measure::OutOfReach {
            error,
            seconds,
            rays,
        },
        _ => return None,
    })
}

/// Reads what a worker sent; a file that it wrote is written here, too.
fn read(message: &JsValue) -> Option<WorkerMessage> {
    if let Some(pair) = message.dyn_ref::<Array>() {
        let file: Array = pair.get(1).dyn_into().ok()?;
        let (path, bytes) = (file.get(0).as_string()?, Uint8Array::new(&file.get(1)));
        // Renamed, it is among the files that were saved.
        let draft = "/.received";
        let _ = disk::write(draft, bytes.to_vec());
        let _ = disk::rename(draft, path);
        return None;
    }
    let get = |key: &str| Reflect::get(message, &key.into()).ok();
    let found = |key: &str| get(key).filter(|v| !v.is_undefined());
    if let Some(bytes) = found("output") {
        return Some(WorkerMessage::Output(Uint8Array::new(&bytes).to_vec()));
    }
    if let Some(why) = found("ended") {
        let why = why.as_string().filter(|why| !why.is_empty());
        return Some(WorkerMessage::Ended(why));
    }
    let measures: Array = get("measures")?.dyn_into().ok()?;
    let numbers = |measure: JsValue| -> Vec<f64> {
        Array::from(&measure)
            .iter()
            .filter_map(|x| x.as_f64())
            .collect()
    };
    Some(WorkerMessage::Progress(ProgressReport {
        stage: get("stage")?.as_string()?,
        done: get("done")?.as_f64()?,
        total: get("total")?.as_f64()?,
        measures: measures
            .iter()
            .filter_map(|m| read_measure(&numbers(m)))
            .collect(),
    }))
}

/// The text of an error of the browser.
pub fn text(error: &JsValue) -> String {
    let message = Reflect::get(error, &"message".into()).ok();
    let message = message.and_then(|m| m.as_string());
    message
        .or_else(|| error.as_string())
        .unwrap_or_else(|| "unknown".into())
}
