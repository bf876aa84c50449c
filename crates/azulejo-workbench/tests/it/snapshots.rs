//! Snapshots of the whole window, drawn by a driver without a screen.

use crate::window::*;
use azulejo_testing::Need;
use azulejo_workbench::app::App;
use azulejo_workbench::bake::BakeSettings;
use azulejo_workbench::command::Command;
use azulejo_workbench::document::NewLightKind;
use azulejo_workbench::first_pass::{EngineChoice, LightSettings};
use azulejo_workbench::gpu::HeadlessDevice;
use azulejo_workbench::lab::LabLink;
use azulejo_workbench::ui::lightmap::LightmapView;
use azulejo_workbench::ui::{PanelTab, Viewport, Workbench};
use azulejo_workbench::variants::script_name;
use azulejo_workbench::view::Shading;
use egui_kittest::{Harness, SnapshotOptions};

/// Drivers and font rasterizers round and blend differently: this detects missing, displaced or
/// recoloured parts, not shades.
fn tolerance() -> SnapshotOptions {
    SnapshotOptions::new()
        .threshold(2.0)
        .max_failed_pixels(1_500usize)
}

/// A window with a graphics device, or `None` without a driver.
fn drawn(app: App) -> Option<TestWindow> {
    let card = HeadlessDevice::open(wgpu::Backends::all()).map_err(|_| "no graphics driver");
    azulejo_testing::require(Need::Gpu, card)?;
    let mut window = Harness::builder()
        .with_size([800.0, 520.0])
        .with_max_steps(200)
        .wgpu()
        .build_eframe(|context| {
            let viewport = Viewport::of_window(context).expect("a card that draws");
            Workbench::in_window(app, viewport, context)
        });
    window.state_mut().app.messages.clear();
    window.run();
    Some(window)
}

fn look(app: &mut App, shading: Shading) {
    let mut view = app.view.clone();
    view.shading = shading;
    app.execute(Command::SetView(Box::new(view)));
}

#[test]
fn a_model_is_shown() {
    let mut app = opened("cornell.grf");
    look(&mut app, Shading::Gouraud);
    if let Some(mut window) = drawn(app) {
        window.snapshot_options("gouraud", &tolerance());
    }
}

#[test]
fn its_light_is_shown_in_false_colours_with_a_legend() {
    let mut app = opened("cornell.grf");
    app.execute(Command::SetLight(LightSettings {
        engine: EngineChoice::Analytic,
        patches: 300,
        error: 0.1,
        // What is done before a deadline depends on how fast the machine is.
        time: None,
        ..LightSettings::default()
    }));
    app.execute(Command::Solve);
    while !app.jobs().is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(1));
        app.poll();
    }
    look(&mut app, Shading::FalseColor);
    app.view.false_color.range = Some((0.0, 4.0));
    if let Some(mut window) = drawn(app) {
        window.state_mut().tab = PanelTab::View;
        window.run();
        window.snapshot_options("false-colours", &tolerance());
    }
}

#[test]
fn the_panel_of_a_sky_is_shown() {
    let mut app = opened("cornell.grf");
    app.execute(Command::AddLight(NewLightKind::Sun));
    app.execute(Command::AddLight(NewLightKind::Sky));
    look(&mut app, Shading::Gouraud);
    if let Some(mut window) = drawn(app) {
        window.snapshot_options("sky", &tolerance());
    }
}

#[test]
fn the_polar_plot_of_a_luminaire_is_shown() {
    let folder = TestFolder::new("polar");
    if let Some(mut window) = drawn(with_luminaire(&folder)) {
        window.snapshot_options("luminaire", &tolerance());
    }
}

#[test]
fn a_lightmap_is_shown_beside_the_model() {
    let mut app = opened("cornell.grf");
    app.execute(Command::SetBake(BakeSettings {
        size: 128,
        error: 0.1,
        ..BakeSettings::default()
    }));
    app.execute(Command::Bake);
    while !app.jobs().is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(1));
        app.poll();
    }
    let result = app.lightmap.result.as_mut();
    let result = result
        .and_then(std::sync::Arc::get_mut)
        .expect("it is baked");
    result.time = std::time::Duration::from_secs(2);
    if let Some(mut window) = drawn(app) {
        window.snapshot_options("lightmap", &tolerance());
        for view in [LightmapView::Charts, LightmapView::Error] {
            window.state_mut().lightmap.view.quantity = view;
            window.run();
            let name = format!("lightmap-{}", script_name(view));
            window.snapshot_options(name, &tolerance());
        }
        window.state_mut().lightmap.is_open = false;
        look(&mut window.state_mut().app, Shading::FalseColor);
        window.run();
        window.snapshot_options("lightmap-viewport", &tolerance());
    }
}

#[test]
fn the_dialog_for_a_lightmap_is_shown() {
    if let Some(mut window) = drawn(opened("cornell.grf")) {
        press(&mut window, egui::Modifiers::NONE, egui::Key::F9);
        window.snapshot_options("bake", &tolerance());
    }
}

#[test]
fn a_lesson_is_shown_beside_its_scene() {
    let mut app = App::quiet();
    app.follow(LabLink::from_query("?lab=3&lang=es").expect("a link"));
    if let Some(mut window) = drawn(app) {
        window.snapshot_options("lab", &tolerance());
    }
}
