//! `azulejo-workbench`: the window.

use azulejo_workbench::app::{App, UserDirs};
use azulejo_workbench::command::Command;
use azulejo_workbench::ending::EndRequest;
use azulejo_workbench::lab::{LabLink, Lesson};
use azulejo_workbench::preferences::{Preferences, SMALLEST_WINDOW};
use azulejo_workbench::script::{self, ScriptPlayer, ScriptStep};
use azulejo_workbench::ui::{Rescued, Viewport, Workbench};
use azulejo_workbench::words::Language;
use clap::Parser;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};

/// View and light models, solve and render them
#[derive(Debug, Parser)]
#[command(name = "azulejo-workbench", version)]
struct Arguments {
    /// Models to open, in any format that azulejo reads
    files: Vec<PathBuf>,
    /// Runs a script with one step per line; the window stays open unless a step is `quit`
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    /// Writes a PNG screenshot of the window after the script, or after loading, and quits
    #[arg(long, value_name = "FILE")]
    screenshot: Option<PathBuf>,
    /// Opens a lesson of the lab by its number, 1 to 8, with its scene
    #[arg(long, value_name = "NUMBER")]
    lab: Option<Lesson>,
    /// Language of the window: en, es, pt
    #[arg(long, value_name = "CODE")]
    language: Option<Language>,
    /// Neither reads nor writes preferences and recovery copies
    #[arg(long)]
    no_preferences: bool,
}

/// How often the window is reopened after a device loss.
const MAX_REOPENS: u32 = 3;

/// Holds the app and a script until a window takes them.
type AppSlot = RefCell<Option<(App, Option<ScriptPlayer>)>>;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            print_error(&why);
            ExitCode::FAILURE
        }
    }
}

#[allow(clippy::print_stderr)]
fn print_error(why: &str) {
    eprintln!("azulejo-workbench: {why}");
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let player = player(arguments)?;
    let outcome = player.as_ref().map(ScriptPlayer::outcome);
    let ending = EndRequest::default();
    ending.listen()?;
    let app = app(arguments);
    windows(app, player, |slot, rescue| window(slot, rescue, &ending))?;
    report_kept(&ending)?;
    match outcome {
        None => Ok(()),
        Some(outcome) => match outcome.lock().ok().and_then(|o| o.clone()) {
            Some(result) => result,
            None => Err("the window was closed before the script ended".into()),
        },
    }
}

/// Says where the unsaved changes are after a signal has ended the window.
fn report_kept(ending: &EndRequest) -> Result<(), String> {
    match ending.kept() {
        None | Some(Ok(None)) => Ok(()),
        Some(Ok(Some(path))) => {
            let path = path.display();
            print_error(&format!("unsaved changes are kept in {path}"));
            Ok(())
        }
        Some(Err(why)) => Err(format!("unsaved changes could not be kept: {why}")),
    }
}

/// The script, with the steps that the command line adds to it.
fn player(arguments: &Arguments) -> Result<Option<ScriptPlayer>, String> {
    let mut steps = Vec::new();
    let mut name = String::from("the command line");
    if let Some(path) = &arguments.script {
        name = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|e| format!("{name}: {e}"))?;
        steps = script::parse(&text, &name)?;
    } else if arguments.screenshot.is_none() {
        return Ok(None);
    }
    let quits = matches!(steps.last(), Some((_, ScriptStep::Quit)));
    if quits {
        steps.pop();
    }
    let last = steps.last().map_or(0, |(line, _)| *line);
    if let Some(path) = &arguments.screenshot {
        steps.push((last, ScriptStep::Wait(None)));
        steps.push((last, ScriptStep::Wait(Some(0.3))));
        steps.push((last, ScriptStep::Screenshot(path.clone())));
    }
    if quits || arguments.screenshot.is_some() {
        steps.push((last, ScriptStep::Quit));
    }
    Ok(Some(ScriptPlayer::new(steps, &name)))
}

fn app(arguments: &Arguments) -> App {
    let dirs = if arguments.no_preferences {
        UserDirs::default()
    } else {
        UserDirs::of_system()
    };
    let mut dirs = dirs;
    let (preferences, window_error) = match &dirs.preferences {
        Some(path) => Preferences::load(path),
        None => (Preferences::default(), None),
    };
    if window_error.is_some() {
        // A typo in a preferences file is not a reason to overwrite it: the user may want to correct
        // it.
        dirs.preferences = None;
    }
    let mut app = App::new(preferences, dirs, Arc::new(|| ()));
    if let Some(why) = window_error {
        app.report(azulejo_workbench::app::Severity::Warning, why);
    }
    if !arguments.files.is_empty() {
        app.execute(Command::Open(arguments.files.clone()));
    }
    app.follow(LabLink {
        lesson: arguments.lab,
        language: arguments.language,
    });
    app
}

/// Opens the window with `open`, and opens it again with the same app when the graphics device is
/// lost.
///
/// After a panic the toolkit cannot open another window, and if none opens at all the user cannot
/// be asked: then the document is written as a recovery copy for the next start.
fn windows(
    app: App,
    player: Option<ScriptPlayer>,
    mut open: impl FnMut(&AppSlot, Sender<Box<Rescued>>) -> Result<(), String>,
) -> Result<(), String> {
    let mut work = (app, player);
    for _ in 0..=MAX_REOPENS {
        // Outside of everything that may panic.
        let slot = AppSlot::new(Some(work));
        let (rescue, rescued) = channel::<Box<Rescued>>();
        let opened = catch_unwind(AssertUnwindSafe(|| open(&slot, rescue)));
        let fell = opened.is_err();
        let result = opened.unwrap_or_else(|_| Err("the window crashed before it opened".into()));
        if let Some((app, _)) = slot.into_inner() {
            let why = result.err().unwrap_or_else(|| "no window".into());
            return Err(open_failure(app, why));
        }
        match rescued.try_recv() {
            Err(_) => return result,
            Ok(left) if fell => return Err(keep(left.app)),
            Ok(left) => work = (left.app, left.player),
        }
        let text = "the graphics device was lost; the window was opened again";
        work.0
            .report(azulejo_workbench::app::Severity::Warning, text);
    }
    Err(keep(work.0))
}

/// The error message for a window that never opened; its document is kept as a recovery copy.
fn open_failure(app: App, why: String) -> String {
    if app.is_changed() {
        format!("{why}\n{}", keep(app))
    } else {
        why
    }
}

/// Writes a recovery copy for the next start; returns a message about it.
fn keep(mut app: App) -> String {
    let kept = app.save_recovery_now();
    // A normal shutdown would delete the copy.
    std::mem::forget(app);
    match kept {
        Ok(Some(path)) => format!(
            "the window crashed; a recovery copy is kept in {}",
            path.display()
        ),
        Ok(None) => "the window crashed; there were no unsaved changes".into(),
        Err(why) => format!("the window crashed, and no recovery copy could be written: {why}"),
    }
}

fn window(slot: &AppSlot, rescue: Sender<Box<Rescued>>, ending: &EndRequest) -> Result<(), String> {
    let place = slot
        .borrow()
        .as_ref()
        .map(|(app, _)| app.preferences.window);
    let place = place.unwrap_or_default();
    let mut viewport = egui::ViewportBuilder::default();
    if let Some(position) = place.position {
        viewport = viewport.with_position(position.map(|points| points as f32));
    }
    let options = eframe::NativeOptions {
        viewport: viewport
            .with_app_id("azulejo")
            .with_title("azulejo")
            .with_inner_size(place.size)
            .with_clamp_size_to_monitor_size(true)
            .with_maximized(place.is_maximized)
            .with_min_inner_size(SMALLEST_WINDOW)
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        run_and_return: true,
        persist_window: false,
        ..eframe::NativeOptions::default()
    };
    let ending = ending.clone();
    let open = move |context: &eframe::CreationContext<'_>| {
        let viewport = Viewport::of_window(context).map_err(|loss| loss.0.to_string())?;
        // As the last step, so that an error before leaves the app in the slot.
        let (app, player) = slot.take().ok_or("the window was opened twice")?;
        let mut window = Workbench::in_window(app, viewport, context);
        window.rescue_to(rescue);
        let egui = context.egui_ctx.clone();
        ending.wake_with(Arc::new(move || egui.request_repaint()));
        window.end_on(ending);
        if let Some(player) = player {
            window.play(player);
        }
        Ok(Box::new(window) as Box<dyn eframe::App>)
    };
    eframe::run_native("azulejo", options, Box::new(open)).map_err(|e| window_error(&e))
}

/// Why no window opened, and what to do about it.
fn window_error(error: &eframe::Error) -> String {
    let advice = match error {
        eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => {
            "A window needs a display: run it on a desktop, or in a virtual one (xvfb-run), with \
             the libraries that windows need (Debian and Ubuntu: apt install libxkbcommon-x11-0 \
             libxcursor1 libxi6 libxrandr2 libx11-xcb1)."
        }
        eframe::Error::Wgpu(_) => {
            "Install a graphics driver: the card's own, or Mesa's, which also draws on machines \
             without a card (Debian and Ubuntu: apt install mesa-vulkan-drivers libvulkan1 \
             libegl1 libgl1-mesa-dri)."
        }
        _ => "",
    };
    let error = error.to_string();
    format!("no window: {}. {advice}", error.trim_end_matches('.'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_workbench::command::Command;
    use azulejo_workbench::document::NewShapeKind;

    /// Runs the window loop with a changed document; checks its error message and the number of
    /// recovery copies.
    fn check(
        name: &str,
        open: impl FnMut(&AppSlot, Sender<Box<Rescued>>) -> Result<(), String>,
        expected: &str,
        copies: usize,
    ) {
        let folder = format!("azulejo-windows-{name}-{}", std::process::id());
        let folder = std::env::temp_dir().join(folder);
        let dirs = UserDirs {
            preferences: None,
            recovery: Some(folder.clone()),
            thumbnails: None,
        };
        let mut app = App::new(Preferences::default(), dirs, Arc::new(|| ()));
        app.execute(Command::AddShape(NewShapeKind::Cuboid));
        let result = windows(app, None, open).unwrap_err();
        assert!(result.contains(expected), "{result}");
        let kept = std::fs::read_dir(&folder).into_iter().flatten().flatten();
        let kept = kept.filter(|e| e.path().extension().is_some_and(|e| e == "grf"));
        assert_eq!(kept.count(), copies);
        let _ = std::fs::remove_dir_all(folder);
    }

    #[test]
    fn what_was_worked_on_outlives_windows_that_do_not_open() {
        check("none", |_, _| Err("no display".into()), "no display", 1);
        check("panic", |_, _| panic!("on purpose"), "is kept in", 1);
        let mut windows = 0;
        let lost_once = |slot: &AppSlot, rescue: Sender<Box<Rescued>>| {
            windows += 1;
            if windows == 2 {
                return Err("no card".into());
            }
            let (app, player) = slot.take().ok_or("empty")?;
            Workbench::new(app).rescue_to(rescue);
            drop(player);
            Ok(())
        };
        check("lost", lost_once, "no card", 1);
        let falls = |slot: &AppSlot, rescue: Sender<Box<Rescued>>| {
            let (app, _) = slot.take().ok_or("empty")?;
            Workbench::new(app).rescue_to(rescue);
            panic!("on purpose")
        };
        check("fell", falls, "is kept in", 1);
    }
}
