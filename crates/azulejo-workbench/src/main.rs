//! `azulejo-workbench`: the window.

use azulejo_workbench::app::{App, Places};
use azulejo_workbench::command::Command;
use azulejo_workbench::preferences::Preferences;
use azulejo_workbench::script::{self, Player, Step};
use azulejo_workbench::ui::{Rescued, Workbench};
use clap::Parser;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::channel;

/// See models, give them light, watch it settle, save it.
#[derive(Debug, Parser)]
#[command(name = "azulejo-workbench", version)]
struct Arguments {
    /// Models to open, of any format that azulejo reads
    files: Vec<PathBuf>,
    /// Plays a list of steps, one a line, and ends
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    /// Writes a picture of the window as PNG when the script, or the loading, is done, and ends
    #[arg(long, value_name = "FILE")]
    screenshot: Option<PathBuf>,
    /// Neither reads nor writes preferences and copies for recovery
    #[arg(long)]
    no_preferences: bool,
}

/// How often a window is opened again that could not stay.
const MOST_FALLS: u32 = 3;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            complain(&why);
            ExitCode::FAILURE
        }
    }
}

#[allow(clippy::print_stderr)]
fn complain(why: &str) {
    eprintln!("azulejo-workbench: {why}");
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let player = player(arguments)?;
    let outcome = player.as_ref().map(Player::outcome);
    let app = app(arguments);
    windows(app, player)?;
    match outcome {
        None => Ok(()),
        Some(outcome) => match outcome.lock().ok().and_then(|o| o.clone()) {
            Some(result) => result,
            None => Err("the window was closed before the script ended".into()),
        },
    }
}

/// The script, and what the command line adds to it.
fn player(arguments: &Arguments) -> Result<Option<Player>, String> {
    let mut steps = Vec::new();
    let mut name = String::from("the command line");
    if let Some(path) = &arguments.script {
        name = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|e| format!("{name}: {e}"))?;
        steps = script::parse(&text, &name)?;
    } else if arguments.screenshot.is_none() {
        return Ok(None);
    }
    let quits = matches!(steps.last(), Some((_, Step::Quit)));
    if quits {
        steps.pop();
    }
    let last = steps.last().map_or(0, |(line, _)| *line);
    if let Some(path) = &arguments.screenshot {
        steps.push((last, Step::Wait(None)));
        steps.push((last, Step::Wait(Some(0.3))));
        steps.push((last, Step::Screenshot(path.clone())));
    }
    if quits || arguments.screenshot.is_some() {
        steps.push((last, Step::Quit));
    }
    Ok(Some(Player::new(steps, &name)))
}

fn app(arguments: &Arguments) -> App {
    let places = match arguments.no_preferences {
        true => Places::default(),
        false => Places::of_system(),
    };
    let mut places = places;
    let (preferences, trouble) = match &places.preferences {
        Some(path) => Preferences::load(path),
        None => (Preferences::default(), None),
    };
    if trouble.is_some() {
        // A slip in a file that a person wrote is theirs to mend, and no reason to write over it.
        places.preferences = None;
    }
    let mut app = App::new(preferences, places, Arc::new(|| ()));
    if let Some(why) = trouble {
        app.tell(azulejo_workbench::app::Level::Warning, why);
    }
    if !arguments.files.is_empty() {
        app.execute(Command::Open(arguments.files.clone()));
    }
    app
}

/// Opens the window; and again, with all that was worked on, when the graphics card is lost.
///
/// Where something panics the toolkit cannot open another one: then what was worked on is written
/// for the next start.
fn windows(app: App, player: Option<Player>) -> Result<(), String> {
    let (mut app, mut player) = (app, player);
    for _ in 0..=MOST_FALLS {
        let (rescue, rescued) = channel::<Box<Rescued>>();
        let opened = catch_unwind(AssertUnwindSafe(|| window(app, player, rescue)));
        let left = rescued.try_recv().ok();
        match (opened, left) {
            (Ok(result), None) => return result,
            (Err(_), None) => return Err("the window fell before it was open".into()),
            (Err(_), Some(left)) => return Err(keep(left.app)),
            (Ok(_), Some(left)) => (app, player) = (left.app, left.player),
        }
        let text = "the graphics card was lost, and the window was opened again";
        app.tell(azulejo_workbench::app::Level::Warning, text);
    }
    Err(keep(app))
}

/// Writes what was worked on for the next start; says so.
fn keep(mut app: App) -> String {
    let kept = app.keep_for_next_start();
    // Ending in good order would take the copy away.
    std::mem::forget(app);
    match kept {
        Ok(Some(path)) => format!(
            "something went wrong in the window; what was worked on is kept in {}",
            path.display()
        ),
        Ok(None) => "something went wrong in the window; all was saved".into(),
        Err(why) => format!("something went wrong in the window, and no copy could be kept: {why}"),
    }
}

fn window(
    app: App,
    player: Option<Player>,
    rescue: std::sync::mpsc::Sender<Box<Rescued>>,
) -> Result<(), String> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("azulejo")
            .with_title("azulejo")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([480.0, 320.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        run_and_return: true,
        persist_window: false,
        ..eframe::NativeOptions::default()
    };
    let open = move |context: &eframe::CreationContext<'_>| {
        let mut window = Workbench::in_window(app, context).map_err(|loss| loss.0.to_string())?;
        window.rescue_to(rescue);
        if let Some(player) = player {
            window.play(player);
        }
        Ok(Box::new(window) as Box<dyn eframe::App>)
    };
    eframe::run_native("azulejo", options, Box::new(open)).map_err(|e| trouble(&e))
}

/// Why there is no window, and what to do.
fn trouble(error: &eframe::Error) -> String {
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
