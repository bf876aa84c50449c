use super::*;
use crate::app::App;
use crate::command::Command;
use crate::document::{SceneDocument, Solution, SurfacePick};
use crate::first_pass::{EngineChoice, LightSettings, PatchFormFactors};
use crate::jobs::JobKind;
use crate::words::Language;
use azulejo::factors::EngineUsed;
use azulejo::factors::form_factors::{Factor, GroupFactor};
use azulejo::radiosity::gather::{ErrorParts, QuarterError};
use azulejo::radiosity::{EnergyBalance, Method, Report};
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{Irradiance, Mesh, ObjectIrradiance, Rgb, Shape};
use azulejo::trace::{Measure, Measured};
use egui::{Key, Role, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::DVec3;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The tab alone, with the commands it issued.
struct LightTabFixture {
    app: App,
    asked: Vec<Command>,
    pins: bool,
}

fn cornell() -> App {
    let mut app = App::quiet();
    app.document = SceneDocument::of_scene(cornell_box(CornellVariant::Diffuse), None);
    app
}

fn bench(app: App) -> Harness<'static, LightTabFixture> {
    let bench = LightTabFixture {
        app,
        asked: Vec::new(),
        pins: false,
    };
    let draw = |ui: &mut Ui, bench: &mut LightTabFixture| {
        bench.app.poll();
        let mut cx = PanelContext {
            is_covered: false,
            app: &bench.app,
            language: bench.app.preferences.language,
            gesture: None,
            commands: Vec::new(),
        };
        bench.pins |= show(ui, &mut cx);
        let commands = cx.commands;
        for target in commands {
            bench.asked.push(target.clone());
            bench.app.execute(target);
        }
    };
    Harness::builder()
        .with_size(Vec2::new(380.0, 1400.0))
        .build_ui_state(draw, bench)
}

/// Adds a solution with a report, as if it had been solved.
fn solved(app: &mut App, balance: EnergyBalance) {
    let report = Report {
        method: Method::Matrix,
        engine_used: EngineUsed {
            name: "rays".into(),
            device: "built-in kernel".into(),
            notes: vec!["glass bends light".into()],
        },
        patches: 1_234,
        points: 56_789,
        patch_rays: 1_000_000,
        refined_rows: 17,
        patch_error: 0.012,
        point_rays: 64,
        bytes: 3 << 20,
        iterations: 9,
        residual: 1.5e-4,
        balance,
        balance_error: 0.0,
        error: 0.027,
        error_each: 0.12,
        error_parts: ErrorParts {
            noise: 0.025,
            discretization: 0.01,
            interpolation: 0.0,
        },
        quarters: [QuarterError::default(); 4],
        path_traced: 0.25,
        rays_needed: 1.0,
        interpolated: 0.0,
    };
    let document = app.document.clone();
    let scene = document.scene();
    let dark = scene
        .objects
        .iter()
        .map(|object| ObjectIrradiance::Vertices {
            irradiance: vec![Rgb::BLACK; positions(&object.shape)],
            error: Vec::new(),
            back: None,
            turned: Vec::new(),
        });
    let dark = Irradiance {
        objects: dark.collect(),
    };
    let solution = Solution::new(document, scene, dark, Some(report));
    app.lighting.solution = Some(Arc::new(solution));
    app.lighting.is_current = true;
}

fn positions(shape: &Shape) -> usize {
    match shape {
        Shape::Mesh(mesh) => mesh.positions.len(),
        _ => unreachable!("the box is all polygons"),
    }
}

fn balance(absorbed: f64) -> EnergyBalance {
    EnergyBalance {
        emitted: Rgb::grey(100.0),
        absorbed: Rgb::grey(absorbed),
        escaped: Rgb::grey(8.0),
        cut: Rgb::grey(1.0),
    }
}

/// Adds three measures of each kind with these values.
fn measured(app: &mut App, values: [f64; 3]) {
    let began = Instant::now();
    app.lighting.began = Some(began);
    for (k, value) in values.into_iter().enumerate() {
        let at = began + Duration::from_millis(40 + 300 * k as u64);
        let residual = Measure::Residual {
            replicate: k as u32 % 2,
            iteration: 1 + k as u32,
            value,
        };
        let measures = [residual, Measure::PatchError(value), Measure::Error(value)];
        let measures = measures.map(|measure| Measured { at, measure });
        app.lighting.measures.extend(measures);
    }
}

fn type_into(harness: &mut Harness<LightTabFixture>, field: &str, text: &str) {
    harness
        .get_by_role_and_label(Role::SpinButton, field)
        .focus();
    harness.run_ok();
    harness
        .get_by_role_and_label(Role::SpinButton, field)
        .type_text(text);
    harness.run_ok();
    harness.key_press(Key::Enter);
    harness.run_ok();
}

fn click(harness: &mut Harness<LightTabFixture>, role: Role, name: &str) {
    harness.get_by_role_and_label(role, name).click();
    harness.run_steps(3);
}

#[test]
fn settings_are_typed() {
    let mut harness = bench(cornell());
    type_into(&mut harness, "Patches", "321");
    type_into(&mut harness, "Target error", "12.5");
    type_into(&mut harness, "Time limit", "7.5");
    click(&mut harness, Role::CheckBox, "Limit bounces");
    type_into(&mut harness, "Limit bounces", "5");
    click(&mut harness, Role::ComboBox, "Engine");
    click(&mut harness, Role::Button, "Rays");
    let expected = LightSettings {
        engine: EngineChoice::Rays,
        patches: 321,
        error: 0.125,
        time: Some(7.5),
        bounces: Some(5),
        keep_mesh: false,
    };
    assert_eq!(harness.state().app.lighting.settings, expected);
    click(&mut harness, Role::CheckBox, "Time limit");
    click(&mut harness, Role::CheckBox, "Limit bounces");
    let settings = harness.state().app.lighting.settings;
    assert_eq!((settings.time, settings.bounces), (None, None));
}

#[test]
fn the_solver_is_started_held_and_stopped() {
    let mut app = cornell();
    app.lighting.settings.patches = 20_000;
    app.lighting.settings.error = 0.001;
    let mut harness = bench(app);
    harness.get_by_label("Not solved yet.");
    for (name, state) in [
        ("Start", "Converging:"),
        ("Pause", "Paused after"),
        ("Resume", "Converging:"),
        ("Stop", "Stopped early: a rough solution."),
    ] {
        click(&mut harness, Role::Button, name);
        // Without a first solution there is nothing to display yet.
        let is_dark = harness.state().app.lighting.solution.is_none();
        let state = if name == "Stop" && is_dark {
            "Not solved yet."
        } else {
            state
        };
        harness.get_by_label_contains(state);
    }
    let commands = &harness.state().asked;
    let expected = [
        Command::Solve,
        Command::Pause,
        Command::Resume,
        Command::StopSolving,
    ];
    assert_eq!(*commands, expected);
    assert!(!harness.state().app.is_busy(JobKind::Solve));
}

#[test]
fn nothing_that_shines_cannot_be_started() {
    let mut harness = bench(App::quiet());
    harness.get_by_label_contains("There is no light source");
    click(&mut harness, Role::Button, "Start");
    assert_eq!(harness.state().asked, []);
}

#[test]
fn whatever_is_measured_is_plotted() {
    for values in [
        [1.0, 0.1, 0.01],
        [0.0; 3],
        [f64::NAN; 3],
        [1.0, f64::NAN, 0.0],
        [f64::INFINITY, 1e-300, 1e300],
        [0.5; 3],
    ] {
        let mut app = cornell();
        measured(&mut app, values);
        app.lighting.measures.truncate(9);
        let mut harness = bench(app);
        harness.run_ok();
        let is_shown = values.iter().any(|v| *v > 0.0 && v.is_finite());
        for words in ["Residual against bounces", "Estimated error against time"] {
            let plot = harness.query_by_role_and_label(Role::Image, words);
            assert_eq!(plot.is_some(), is_shown, "{words}: {values:?}");
        }
    }
}

#[test]
fn terms_are_explained_with_the_mouse_and_with_the_keyboard() {
    let mut app = cornell();
    measured(&mut app, [1.0, 0.1, 0.01]);
    solved(&mut app, balance(90.0));
    let mut harness = bench(app);
    harness.run_ok();
    for (term, words) in [
        ("Patch", "Piece of a surface"),
        ("Residual", "What one more bounce"),
        ("Independent estimates", "estimated several times"),
        ("Energy balance", "All emitted light"),
    ] {
        let name = format!("Help: {term}");
        assert!(harness.query_by_label_contains(words).is_none(), "{words}");
        click(&mut harness, Role::Button, &name);
        harness.get_by_label_contains(words);
        harness.key_press(Key::Escape);
        harness.run_steps(3);
        assert!(harness.query_by_label_contains(words).is_none(), "{words}");
        harness.get_by_role_and_label(Role::Button, &name).focus();
        harness.run_steps(2);
        harness.key_press(Key::Enter);
        harness.run_steps(3);
        harness.get_by_label_contains(words);
        harness.key_press(Key::Escape);
        harness.run_steps(3);
    }
}

#[test]
fn one_point_is_a_plot_too() {
    let mut app = cornell();
    measured(&mut app, [0.3; 3]);
    app.lighting.measures.truncate(3);
    let mut harness = bench(app);
    harness.run_ok();
    harness.get_by_role_and_label(Role::Image, "Estimated error against time");
}

#[test]
fn the_balance_is_shown_with_a_caution_where_it_does_not_add_up() {
    for (absorbed, lost, cautions) in [(90.0, "1.0 %", false), (60.0, "31 %", true)] {
        let mut app = cornell();
        solved(&mut app, balance(absorbed));
        let mut harness = bench(app);
        harness.run_ok();
        harness.get_by_label("100 W");
        harness.get_by_role_and_label(Role::Meter, "Escaped 8.0 %");
        harness.get_by_role_and_label(Role::Meter, &format!("Unaccounted {lost}"));
        let caution = harness.query_by_label_contains("does not close");
        assert_eq!(caution.is_some(), cautions);
        harness.get_by_label("rays (built-in kernel)");
        harness.get_by_label_contains("3.0 MiB");
        harness.get_by_label_contains("glass bends light");
        harness.get_by_label_contains("Done: error 2.7 %");
    }
}

#[test]
fn old_light_says_so() {
    let mut app = cornell();
    solved(&mut app, balance(91.0));
    app.lighting.is_current = false;
    bench(app).get_by_label("This light is from an earlier state of the model.");
}

#[test]
fn probes_are_pinned_measured_and_removed() {
    let mut app = cornell();
    let item = app.document.objects[0].id;
    for _ in 0..2 {
        app.execute(Command::AddProbe(SurfacePick {
            item,
            position: app.document.objects[0].bounds().centre(),
            normal: DVec3::Y,
        }));
    }
    let mut harness = bench(app);
    click(&mut harness, Role::Button, "Pin a probe");
    assert!(harness.state().pins);
    click(&mut harness, Role::Button, "Remove probe 1");
    let left: Vec<u64> = (harness.state().app.probes.iter())
        .map(|p| p.number)
        .collect();
    assert_eq!(left, [2]);
    click(&mut harness, Role::Button, "Measure exactly");
    assert_eq!(
        harness.state().asked,
        [Command::RemoveProbe(1), Command::MeasureProbes]
    );
    click(&mut harness, Role::Button, "Remove probe 2");
    harness.get_by_label_contains("No probes yet");
}

#[test]
fn form_factors_are_listed_by_object() {
    let mut app = cornell();
    let ids: Vec<_> = app.document.objects.iter().map(|i| i.id).collect();
    let found = |value| GroupFactor {
        factor: Factor { value, error: 0.01 },
        estimates: None,
    };
    app.lighting.form_factors = Some(PatchFormFactors {
        number: 1,
        pick: SurfacePick {
            item: ids[0],
            position: DVec3::ZERO,
            normal: DVec3::Y,
        },
        patches: Arc::new(Mesh::default()),
        factors: Vec::new(),
        sum: 0.75,
        objects: vec![(ids[1], found(0.5)), (ids[2], found(0.25))],
    });
    let mut harness = bench(app);
    harness.run_ok();
    harness.get_by_label("Sum 0.7500; 25 % leaves the scene");
    harness.get_by_label("0.5000 ± 0.0100");
    let name = harness
        .state()
        .app
        .document
        .name(ids[1])
        .unwrap()
        .to_owned();
    click(&mut harness, Role::Link, &probes::shortened(&name));
    assert_eq!(harness.state().app.selection.ids, [ids[1]]);
}

#[test]
fn every_language_fits_the_panel() {
    for language in Language::ALL {
        let mut app = cornell();
        app.preferences.language = language;
        solved(&mut app, balance(60.0));
        measured(&mut app, [1.0, 0.1, 0.01]);
        app.task_plane.is_added = true;
        let mut harness = bench(app);
        harness.run_ok();
        let roles = [
            Role::Label,
            Role::Button,
            Role::CheckBox,
            Role::Image,
            Role::Meter,
        ];
        let nodes = roles.map(|role| harness.query_all_by_role(role));
        let width = nodes.into_iter().flatten().map(|n| n.rect().right());
        let widest = width.fold(0.0, f32::max);
        assert!(widest <= 380.5, "{language:?}: {widest}");
    }
}
