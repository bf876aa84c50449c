//! Signals end the window and keep what is unsaved.

use crate::window::TestFolder;
use azulejo_testing::Need;
use azulejo_workbench::app::{App, UserDirs};
use azulejo_workbench::command;
use azulejo_workbench::document::NewShapeKind;
use azulejo_workbench::ending::EndRequest;
use azulejo_workbench::gpu::HeadlessDevice;
use azulejo_workbench::preferences::Preferences;
use azulejo_workbench::recovery::Recovery;
use azulejo_workbench::ui::Workbench;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A window that is killed has saved its work, and says so.
#[test]
fn a_signal_ends_the_window_and_keeps_its_work() {
    let card = HeadlessDevice::open(wgpu::Backends::all()).map_err(|_| "no graphics driver");
    let display = ["DISPLAY", "WAYLAND_DISPLAY"].into_iter();
    let display = display.filter_map(std::env::var_os).next();
    let display = display.ok_or("neither DISPLAY nor WAYLAND_DISPLAY is set");
    let needs = (
        azulejo_testing::require(Need::Gpu, card),
        azulejo_testing::require(Need::Display, display),
    );
    if let (None, _) | (_, None) = needs {
        return;
    }
    for signal in ["TERM", "INT", "HUP"] {
        let folder = TestFolder::new(&format!("signal-{signal}"));
        let picture = folder.path("ready.png");
        let script = format!("action Box\nscreenshot {}\n", picture.display());
        std::fs::write(folder.path("steps.txt"), script).unwrap();
        let mut window = Command::new(env!("CARGO_BIN_EXE_azulejo-workbench"))
            .arg("--script")
            .arg(folder.path("steps.txt"))
            .env("XDG_DATA_HOME", folder.path("data"))
            .env("XDG_CONFIG_HOME", folder.path("config"))
            .env("XDG_CACHE_HOME", folder.path("cache"))
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let begin = Instant::now();
        let patience = Duration::from_secs(300);
        while !picture.exists() {
            assert!(window.try_wait().unwrap().is_none(), "no window opened");
            assert!(begin.elapsed() < patience, "no screenshot");
            std::thread::sleep(Duration::from_millis(50));
        }
        // The script ends in the frame after its last step.
        std::thread::sleep(Duration::from_millis(500));
        let id = window.id().to_string();
        let kill = Command::new("kill").args(["-s", signal, &id]).status();
        assert!(kill.unwrap().success());
        assert_eq!(window.wait().unwrap().code(), Some(0), "SIG{signal}");
        let kept = Recovery::new(folder.path("data/azulejo/recovery"));
        assert_eq!(kept.recoverable().len(), 1, "SIG{signal}");
    }
}

fn app_in(folder: &TestFolder) -> App {
    let preferences = Preferences {
        autosave: 0,
        ..Preferences::default()
    };
    let dirs = UserDirs {
        recovery: Some(folder.path("recovery")),
        ..UserDirs::default()
    };
    App::new(preferences, dirs, Arc::new(|| ()))
}

#[test]
fn a_request_to_end_leaves_unsaved_changes_for_the_next_start() {
    let folder = TestFolder::new("ended");
    let mut app = app_in(&folder);
    app.execute(command::Command::AddShape(NewShapeKind::Cuboid));
    let request = EndRequest::default();
    let mut window = egui_kittest::Harness::builder().build_ui_state(
        |ui, window: &mut Workbench| window.show(ui),
        Workbench::new(app),
    );
    window.state_mut().end_on(request.clone());
    window.run_steps(2);
    assert_eq!(request.kept(), None);
    assert!(app_in(&folder).recoverable().is_empty());
    request.ask();
    window.run_steps(3);
    let copy = request.kept().unwrap().unwrap().unwrap();
    drop(window);
    let mut next = app_in(&folder);
    assert_eq!(next.recoverable().len(), 1);
    next.execute(command::Command::Recover(copy));
    let begin = Instant::now();
    while !next.jobs().is_empty() {
        assert!(
            begin.elapsed() < Duration::from_secs(300),
            "it does not open"
        );
        std::thread::sleep(Duration::from_millis(1));
        next.poll();
    }
    assert_eq!(next.document.objects.len(), 1);
    assert!(next.is_changed());
}
