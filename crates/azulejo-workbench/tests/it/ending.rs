//! Signals end the window and keep what is unsaved.

use crate::window::TestFolder;
use azulejo_testing::Need;
use azulejo_workbench::gpu::HeadlessDevice;
use azulejo_workbench::recovery::Recovery;
use std::process::{Command, Stdio};
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
        let patience = Duration::from_secs(60);
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
