use super::*;
use crate::app::Severity;
use crate::command::Command;
use crate::document::{Edit, SurfacePick};
use crate::view::LightUnit;
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{Material, Rgb};
use azulejo::trace::Measure;
use glam::{DAffine3, DVec3};

/// Longer than any job of a test takes, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

fn cornell() -> App {
    let mut app = App::quiet();
    app.document = SceneDocument::of_scene(cornell_box(CornellVariant::Diffuse), None);
    app.execute(Command::SetLight(LightSettings {
        patches: 200,
        error: 0.2,
        ..LightSettings::default()
    }));
    app
}

fn wait_until(app: &mut App, what: &str, is_so: impl Fn(&App) -> bool) {
    let begin = Instant::now();
    loop {
        app.poll();
        if is_so(app) {
            return;
        }
        assert!(begin.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn solve(app: &mut App) {
    app.execute(Command::Solve);
    wait_until(app, "the solver does not end", |a| a.jobs().is_empty());
    assert_eq!(app.messages, []);
}

/// A point of the floor that the lamp illuminates, seen from above.
fn on_the_floor(app: &App) -> SurfacePick {
    let bounds = app.document.bounds(None);
    let floor = app
        .document
        .objects
        .iter()
        .find(|i| i.name.contains("floor"));
    let up = app.document.units.up.axis();
    SurfacePick {
        item: floor.expect("a Cornell box has a floor").id,
        position: bounds.min + bounds.size() * DVec3::new(0.8, 0.0, 0.2),
        normal: up,
    }
}

#[test]
fn light_arrives_with_its_measures() {
    let mut app = cornell();
    solve(&mut app);
    let lighting = &app.lighting;
    assert!(lighting.is_current && !lighting.is_paused);
    let report = lighting.solution.as_ref().and_then(|s| s.report.as_ref());
    assert!(report.is_some_and(|r| r.error <= 0.2), "{report:?}");
    assert!(lighting.range.is_some_and(|r| r.usual > 0.0));
    let has = |test: fn(&Measure) -> bool| lighting.measures.iter().any(|m| test(&m.measure));
    assert!(has(|m| matches!(m, Measure::Residual { .. })));
    assert!(has(|m| matches!(m, Measure::Error(_))));
    let took = lighting.stopwatch.elapsed();
    assert!(took > Duration::ZERO && took <= PATIENCE);
    assert_eq!(
        took,
        app.lighting.stopwatch.elapsed(),
        "the stopwatch is still running"
    );
}

#[test]
fn an_edit_makes_light_old_and_undo_makes_it_true_again() {
    let mut app = cornell();
    solve(&mut app);
    let first = app.document.objects[0].id;
    let shift = DAffine3::from_translation(DVec3::X);
    app.execute(Command::Edit(Edit::SetPlacement(first, shift), None));
    assert!(!app.lighting.is_current && app.lighting.solution.is_some());
    app.execute(Command::Undo);
    assert!(app.lighting.is_current);
}

#[test]
fn the_solver_rests_goes_on_and_stops() {
    let mut app = cornell();
    app.execute(Command::SetLight(LightSettings {
        patches: 20_000,
        error: 0.001,
        ..LightSettings::default()
    }));
    app.execute(Command::Solve);
    let works = |a: &App| a.jobs().first().is_some_and(|j| j.progress.done() > 0);
    wait_until(&mut app, "it does not begin", works);
    app.execute(Command::Pause);
    assert!(app.lighting.is_paused && app.jobs()[0].progress.is_paused());
    let held = app.lighting.stopwatch.elapsed();
    std::thread::sleep(Duration::from_millis(20));
    app.poll();
    assert_eq!(app.lighting.stopwatch.elapsed(), held);
    assert!(app.is_busy(JobKind::Solve));
    app.execute(Command::Resume);
    assert!(!app.lighting.is_paused && !app.jobs()[0].progress.is_paused());
    app.execute(Command::Pause);
    app.execute(Command::StopSolving);
    assert!(!app.is_busy(JobKind::Solve) && !app.lighting.is_paused);
    assert_eq!(app.messages, []);
}

#[test]
fn time_left_is_guessed_from_the_share_that_is_done() {
    let mut lighting = Lighting::default();
    assert_eq!(lighting.time_left(0.5), None);
    lighting.stage = Some(("bounces".into(), Duration::ZERO));
    lighting.stopwatch.before = Duration::from_secs(6);
    assert_eq!(lighting.time_left(0.0), None);
    assert_eq!(lighting.time_left(f64::NAN), None);
    assert_eq!(lighting.time_left(0.75), Some(Duration::from_secs(2)));
    assert_eq!(lighting.time_left(1.0), Some(Duration::ZERO));
}

#[test]
fn what_cannot_be_lit_is_a_message() {
    let mut app = cornell();
    for material in 0..app.document.materials.len() as u32 {
        let black = Material::diffuse("black", Rgb::BLACK);
        app.execute(Command::Edit(Edit::SetMaterial(material, black), None));
    }
    app.execute(Command::Solve);
    assert!(app.jobs().is_empty());
    let last = app.messages.last().expect("a message");
    assert!(last.level == Severity::Error && last.text.contains("no light source"));
    // Errors that only the solver detects arrive as messages of its job.
    let mut app = App::quiet();
    let material = Material::emitter("lamp", Rgb::WHITE);
    app.document.materials.push(Arc::new(material));
    app.execute(Command::Edit(
        Edit::AddLight(crate::document::NewLight {
            kind: crate::document::NewLightKind::Point,
            at: DVec3::ONE,
            toward: DVec3::ZERO,
        }),
        None,
    ));
    app.execute(Command::Solve);
    wait_until(&mut app, "it does not fail", |a| a.jobs().is_empty());
    let text = &app.messages.last().expect("a message").text;
    assert!(text.contains("no surface"), "{text}");
}

#[test]
fn probes_read_the_solution_and_measure_the_place_itself() {
    let mut app = cornell();
    let pick = on_the_floor(&app);
    app.execute(Command::AddProbe(pick));
    let site = app.probes[0].site.clone().expect("the floor is there");
    assert!(site.paint.is_front && site.light.is_none());
    solve(&mut app);
    let site = app.probes[0].site.clone().expect("the floor is there");
    let (light, error) = site.light.expect("it is lit");
    assert!(light.luminance() > 0.0 && error.is_some());
    app.execute(Command::MeasureProbes);
    wait_until(&mut app, "it is not measured", |a| a.jobs().is_empty());
    let measured = app.probes[0].measured.expect("an estimate").value;
    let ratio = measured.luminance() / light.luminance();
    assert!((0.6..1.6).contains(&ratio), "{ratio}");
    check_table_of(&mut app, light, measured);
    // The move takes the surface away from the probe and invalidates the measurement.
    let away = DAffine3::from_translation(DVec3::splat(1e4));
    app.execute(Command::Edit(Edit::SetPlacement(pick.item, away), None));
    assert!(app.probes[0].site.is_none() && app.probes[0].measured.is_none());
    app.execute(Command::Undo);
    assert!(
        app.probes[0]
            .site
            .as_ref()
            .is_some_and(|s| s.light.is_some())
    );
    app.execute(Command::RemoveProbe(app.probes[0].number));
    assert!(app.probes.is_empty());
}

/// Saves the table of one probe in lux, and checks its numbers.
fn check_table_of(app: &mut App, light: Rgb, measured: Rgb) {
    let name = format!("azulejo-probes-{}", std::process::id());
    let path = std::env::temp_dir().join(name);
    app.view.light_unit = LightUnit::Photometric;
    app.execute(Command::SaveProbes(path.clone()));
    wait_until(app, "it is not saved", |a| a.jobs().is_empty());
    let path = path.with_extension("csv");
    let text = std::fs::read_to_string(&path).expect("a table");
    let _ = std::fs::remove_file(path);
    let rows: Vec<Vec<&str>> = text
        .split_terminator("\r\n")
        .map(|row| row.split(',').collect())
        .collect();
    assert_eq!(rows.len(), 2, "{text}");
    assert_eq!((rows[0].len(), rows[1].len()), (14, 14));
    assert_eq!((rows[1][0], rows[1][1], rows[1][13]), ("1", "floor", "lx"));
    for (column, expected) in [(9, light), (11, measured)] {
        let irradiance: f64 = rows[1][column].parse().expect("a number");
        let expected = 179.0 * expected.luminance();
        assert!(
            (irradiance / expected - 1.0).abs() < 1e-9,
            "{irradiance} {expected}"
        );
    }
    app.view.light_unit = LightUnit::Document;
}

#[test]
fn another_document_has_no_probes() {
    let mut app = cornell();
    let pick = on_the_floor(&app);
    app.execute(Command::AddProbe(pick));
    app.execute(Command::New);
    app.execute(Command::Discard);
    assert!(app.probes.is_empty());
}

#[test]
fn the_back_of_a_surface_has_no_light_of_its_own() {
    let mut app = cornell();
    solve(&mut app);
    let pick = on_the_floor(&app);
    app.execute(Command::AddProbe(SurfacePick {
        normal: -pick.normal,
        ..pick
    }));
    assert!(
        app.probes[0]
            .site
            .as_ref()
            .is_some_and(|s| !s.paint.is_front)
    );
}

#[test]
fn what_a_patch_sees_is_summed_by_object() {
    let mut app = cornell();
    let pick = on_the_floor(&app);
    app.execute(Command::FormFactorsFrom(pick));
    wait_until(&mut app, "it sees nothing", |a| a.jobs().is_empty());
    let seen = app.lighting.form_factors.as_ref().expect("form factors");
    let sum: f64 = seen.objects.iter().map(|o| o.1.factor.value).sum();
    assert!((sum - seen.sum).abs() < 1e-9, "{sum} {}", seen.sum);
    assert!(seen.objects.is_sorted_by_key(|o| -o.1.factor.value));
    assert!(seen.objects.len() > 3 && sum > 0.5 && sum < 1.05, "{sum}");
}
