//! The functions that the page calls.

use crate::bits;
use azulejo::formats::grf;
use azulejo_workbench::app::{App, Severity, UserDirs};
use azulejo_workbench::command::Command;
use azulejo_workbench::document::Example;
use azulejo_workbench::lab::LabLink;
use azulejo_workbench::platform;
use azulejo_workbench::preferences::Preferences;
use azulejo_workbench::script::{self, ScriptPlayer};
use azulejo_workbench::ui::{Viewport, Workbench};
use azulejo_workbench::words::Language;
use eframe::{WebOptions, WebRunner, egui};
use serde_json::json;
use std::any::Any;
use std::cell::RefCell;
use std::sync::{Arc, Mutex};
use wasm_bindgen::prelude::*;
use web_sys::{HtmlCanvasElement, UrlSearchParams};

type Outcome = Arc<Mutex<Option<Result<(), String>>>>;

thread_local! {
    static RUNNER: RefCell<Option<WebRunner>> = const { RefCell::new(None) };
    /// Of the script that was played last.
    static OUTCOME: RefCell<Option<Outcome>> = const { RefCell::new(None) };
}

/// The window, which the page's functions find again.
struct PageWindow(Workbench, egui::Context);

impl eframe::App for PageWindow {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.0.ui(ui, frame);
    }

    fn logic(&mut self, context: &egui::Context, frame: &mut eframe::Frame) {
        self.0.logic(context, frame);
    }

    fn persist_egui_memory(&self) -> bool {
        false
    }

    fn as_any_mut(&mut self) -> Option<&mut dyn Any> {
        Some(self)
    }
}

/// Shows the workbench on a canvas. `query` is what follows the `?` of the page's address: `open=cornell`,
/// `open=mirror` or `open=letters` opens an example, `lab=3` a lesson, `lang=es` sets the language.
///
/// # Errors
/// The browser has neither WebGPU nor WebGL 2.
#[wasm_bindgen]
pub async fn start(canvas: HtmlCanvasElement, query: String) -> Result<(), JsValue> {
    let runner = WebRunner::new();
    report_panics();
    let app = app(&query, &UrlSearchParams::new_with_str(&query)?);
    let open = move |context: &eframe::CreationContext<'_>| {
        let viewport = Viewport::of_window(context).map_err(|loss| loss.0.to_string())?;
        let window = Workbench::in_window(app, viewport, context);
        Ok(Box::new(PageWindow(window, context.egui_ctx.clone())) as Box<dyn eframe::App>)
    };
    runner
        .start(canvas, WebOptions::default(), Box::new(open))
        .await?;
    RUNNER.set(Some(runner));
    Ok(())
}

fn app(text: &str, query: &UrlSearchParams) -> App {
    let preferences = Preferences {
        language: language(query),
        ..Preferences::default()
    };
    let dirs = UserDirs {
        recovery: Some(platform::RECOVERY.into()),
        ..UserDirs::default()
    };
    let mut app = App::new(preferences, dirs, Arc::new(|| ()));
    let examples = [
        ("cornell", Example::CornellBox),
        ("mirror", Example::MirrorBlock),
        ("letters", Example::SolidText),
    ];
    if let Some(name) = query.get("open") {
        match examples.into_iter().find(|(known, _)| *known == name) {
            Some((_, example)) => app.execute(Command::OpenExample(example)),
            None => {
                let known = examples.map(|(name, _)| name).join(", ");
                app.report(
                    Severity::Error,
                    format!("?open={name}: expected one of {known}"),
                );
            }
        }
    }
    match LabLink::from_query(text) {
        Ok(link) => app.follow(link),
        Err(why) => app.report(Severity::Error, why),
    }
    app
}

/// The language that the address asks for, or else that of the browser.
fn language(query: &UrlSearchParams) -> Language {
    let browser = || web_sys::window()?.navigator().language();
    let name = query.get("lang").or_else(browser).unwrap_or_default();
    match name.get(..2) {
        Some("es") => Language::Spanish,
        Some("pt") => Language::Portuguese,
        _ => Language::English,
    }
}

/// Tells the page about a panic, after which the program does not go on; a worker's panic is the end of its job.
fn report_panics() {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let text = info.payload_as_str().unwrap_or("unknown");
        let place = info.location().map(ToString::to_string).unwrap_or_default();
        let text = format!("internal error: {text} ({place}); please report it");
        if platform::is_worker() {
            return platform::post(platform::WorkerMessage::Ended(Some(text)));
        }
        before(info);
        let global = js_sys::global();
        let failed = js_sys::Reflect::get(&global, &"azulejoFailed".into());
        if let Ok(failed) = failed.and_then(|f| f.dyn_into::<js_sys::Function>()) {
            let _ = failed.call1(&global, &text.into());
        }
    }));
}

/// Runs a job in a worker.
#[wasm_bindgen]
pub fn run_job(id: f64) {
    platform::run_in_worker(id as u64);
}

/// Works on the window, if it is open and not at work itself.
fn with_window<T>(work: impl FnOnce(&mut Workbench) -> T) -> Option<T> {
    RUNNER.with_borrow(|runner| {
        let mut window = runner.as_ref()?.app_mut::<PageWindow>()?;
        // Nothing else wakes a window whose user does nothing.
        window.1.request_repaint();
        Some(work(&mut window.0))
    })
}

/// Puts a file into the page as if it had been dropped; with `opens` it is opened, too.
#[wasm_bindgen]
pub fn put_file(name: &str, bytes: Vec<u8>, opens: bool) -> Result<(), JsValue> {
    if opens {
        platform::put_dropped(name, bytes);
        with_window(|_| ());
        return Ok(());
    }
    let path = std::path::Path::new("/").join(name);
    azulejo::formats::disk::write(path, bytes).map_err(|e| e.to_string().into())
}

/// The bytes of a file of the page, such as one that was saved.
#[wasm_bindgen]
pub fn get_file(path: &str) -> Option<Vec<u8>> {
    azulejo::formats::disk::read(path).ok()
}

/// Plays a script of the workbench, whose steps `docs/workbench/scripts.md` lists.
///
/// # Errors
/// A step that is not understood.
#[wasm_bindgen]
pub fn play(text: &str) -> Result<(), JsValue> {
    let steps = script::parse(text, "the page")?;
    let player = ScriptPlayer::new(steps, "the page");
    OUTCOME.set(Some(player.outcome()));
    with_window(|window| window.play(player)).ok_or("the window is not open")?;
    Ok(())
}

/// How the script ended: nothing while it runs, `""` if it succeeded, else its error.
#[wasm_bindgen]
pub fn outcome() -> Option<String> {
    let outcome = OUTCOME.with_borrow(Clone::clone)?;
    let outcome = outcome.lock().ok()?.clone()?;
    Some(outcome.err().unwrap_or_default())
}

/// Whether there are changes that are not saved.
#[wasm_bindgen]
pub fn is_changed() -> bool {
    with_window(|window| window.app.is_changed()).unwrap_or_default()
}

/// The scene with its light, as GRF.
#[wasm_bindgen]
pub fn scene() -> Option<Vec<u8>> {
    with_window(|window| {
        let app = &window.app;
        let (scene, _) = app.document.lit_scene(app.lighting.solution.as_deref());
        let mut bytes = Vec::new();
        grf::write(&scene, &mut bytes).ok()?;
        Some(bytes)
    })?
}

/// [`bits`] of a scene in GRF, by their names: `form_factors`, `solution`, `picture`.
///
/// # Errors
/// Those of the function, or there is none of this name.
#[wasm_bindgen]
pub fn bits_of(name: &str, text: &[u8]) -> Result<Vec<u8>, JsValue> {
    let bytes = match name {
        "form_factors" => bits::form_factors(text),
        "solution" => bits::solution(text),
        "picture" => bits::picture(text),
        _ => Err(format!("there is no `{name}`")),
    };
    bytes.map_err(JsValue::from)
}

/// The state of the workbench, as JSON: for tests, since a canvas has no elements.
#[wasm_bindgen]
pub fn state() -> Option<String> {
    with_window(|window| {
        let app = &window.app;
        let report = app
            .lighting
            .solution
            .as_ref()
            .and_then(|s| s.report.as_ref());
        let jobs: Vec<String> = app.jobs().iter().map(|j| format!("{:?}", j.kind)).collect();
        let progress: Vec<String> = app.jobs().iter().map(|j| j.progress.stage()).collect();
        let messages: Vec<&str> = app.messages.iter().map(|m| m.text.as_str()).collect();
        let range = app.lighting.range.map(|r| [r.low, r.high, r.usual]);
        json!({
            "objects": app.document.objects.len(),
            "faces": app.document.face_count(),
            "jobs": jobs,
            "stages": progress,
            "messages": messages,
            "failure": app.failure,
            "error": report.map(|r| r.error),
            "range": range,
            "samples": app.render.as_ref().map(|r| r.samples),
            "changed": app.is_changed(),
            "playing": window.is_playing(),
        })
        .to_string()
    })
}
