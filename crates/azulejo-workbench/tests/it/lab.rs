//! The lessons of the lab, done as their steps say: what the window then shows is the number that each calls right.

use crate::window::*;
use azulejo_testing::closed_forms::{opposed, parallel};
use azulejo_workbench::app::App;
use azulejo_workbench::command::Command;
use azulejo_workbench::document::SurfacePick;
use azulejo_workbench::first_pass::EngineChoice;
use azulejo_workbench::lab::{LabLink, Lesson, Verdict};
use azulejo_workbench::ui::PanelTab;
use azulejo_workbench::words::Language;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use glam::DVec3;

/// A window with the scene of a lesson, and with the tab that its steps open.
fn begun(lesson: Lesson, tab: PanelTab) -> TestWindow {
    let mut window = window(App::quiet());
    let show = Command::ShowLab(Some(lesson));
    window.state_mut().app.execute(show);
    window.state_mut().tab = tab;
    window.run();
    click(&mut window, "Open the scene");
    wait(&mut window);
    window
}

/// Clicks an object in the shading mode "Form factors of a patch": the window without a graphics device has no picture
/// to click into.
fn pick(window: &mut TestWindow, name: &str, position: DVec3, normal: DVec3) {
    let app = &mut window.state_mut().app;
    let item = app.document.objects.iter().find(|o| o.name == name);
    let item = item.expect("an object of this name").id;
    app.execute(Command::FormFactorsFrom(SurfacePick {
        item,
        position,
        normal,
    }));
    wait(window);
    check_no_error(window);
}

/// The number at the beginning of a text.
fn number(text: &str) -> f64 {
    let end = text.find(|c: char| !c.is_ascii_digit() && !".-e".contains(c));
    let number = text[..end.unwrap_or(text.len())].parse();
    number.unwrap_or_else(|_| panic!("no number in \"{text}\""))
}

/// The texts of the window, in their order.
fn texts(window: &TestWindow) -> Vec<String> {
    let all = window.query_all_by_role(Role::Label);
    let texts = all.filter_map(|n| {
        let node = n.accesskit_node();
        node.value().or(node.label())
    });
    texts.collect()
}

/// The text after this one.
fn after(window: &TestWindow, name: &str) -> String {
    let texts = texts(window);
    let at = texts.iter().position(|text| text == name);
    let at = at.unwrap_or_else(|| panic!("no \"{name}\" in {texts:#?}"));
    texts[at + 1].clone()
}

/// The form factor to an object, and its standard error if there is one, as the table shows them.
fn shown_factor(window: &TestWindow, row: usize) -> (f64, Option<f64>) {
    let texts = texts(window);
    let mut found = texts
        .iter()
        .filter(|text| text.starts_with("0.") && !text.ends_with('%'));
    let cell = found.nth(row).expect("a form factor");
    let mut parts = cell.split(" ± ");
    let value = number(parts.next().unwrap());
    (value, parts.next().map(number))
}

/// Types an answer, and checks what is said about it.
fn answers(window: &mut TestWindow, lesson: Lesson, answer: f64, expected: Verdict) {
    let typed = format!("{answer:.6}");
    assert_eq!(lesson.check(&typed), expected, "{lesson:?}: {answer}");
    find(window, Role::TextInput, "Your answer").focus();
    window.run();
    press(window, Modifiers::COMMAND, Key::A);
    type_text(window, &typed);
    click(window, "Check");
    let said = match expected {
        Verdict::Right => "Right, within",
        Verdict::Wrong => "Not yet.",
        Verdict::Unreadable => "This is not a number.",
    };
    assert!(says(window, said), "{lesson:?}: {answer}");
}

#[test]
fn the_form_factor_of_two_squares() {
    let lesson = Lesson::FormFactor;
    let mut window = begun(lesson, PanelTab::Light);
    pick(&mut window, "lower", DVec3::ZERO, DVec3::Y);
    let (near, error) = shown_factor(&window, 0);
    assert!((near - opposed(1.0, 1.0, 1.0)).abs() < 1e-6 && error.is_none());
    // By rays it has an error, within which it is the same.
    let app = &mut window.state_mut().app;
    app.lighting.settings.engine = EngineChoice::Rays;
    pick(&mut window, "lower", DVec3::ZERO, DVec3::Y);
    let (by_rays, error) = shown_factor(&window, 0);
    let error = error.expect("an error");
    assert!(
        (by_rays - near).abs() < 3.0 * error && error < 2e-3,
        "{by_rays} ± {error}"
    );
    answers(&mut window, lesson, near, Verdict::Wrong);
    window.state_mut().app.lighting.settings.engine = EngineChoice::Auto;
    find(&window, Role::Link, "upper").click();
    window.run();
    window.state_mut().tab = PanelTab::Object;
    window.run();
    set(&mut window, "Position y", 2.0);
    window.state_mut().tab = PanelTab::Light;
    pick(&mut window, "lower", DVec3::ZERO, DVec3::Y);
    let (far, _) = shown_factor(&window, 0);
    answers(&mut window, lesson, far, Verdict::Right);
    let truth = opposed(1.0, 1.0, 2.0);
    assert!((lesson.known_answer().value - truth).abs() < 1e-4 * truth);
}

#[test]
fn bounces_in_an_energy_balance() {
    let lesson = Lesson::EnergyBalance;
    let mut window = begun(lesson, PanelTab::Light);
    find(&window, Role::CheckBox, "Limit bounces").click();
    window.run();
    let mut measured = Vec::new();
    for bounces in [0.0, 1.0, 2.0, 4.0] {
        set(&mut window, "Limit bounces", bounces);
        click(&mut window, "Start");
        wait(&mut window);
        let missing = number(&after(&window, "Unaccounted"));
        let expected = 100.0 * 0.6f64.powf(bounces + 1.0);
        assert!(
            (missing / expected - 1.0).abs() < 0.02,
            "{bounces}: {missing} {expected}"
        );
        measured.push(missing);
    }
    answers(&mut window, lesson, measured[2], Verdict::Wrong);
    answers(&mut window, lesson, measured[3], Verdict::Right);
    let known = lesson.known_answer().value;
    assert!((known - 100.0 * 0.6f64.powi(5)).abs() < 1e-9);
}

#[test]
fn an_area_by_reciprocity() {
    let lesson = Lesson::Reciprocity;
    let mut window = begun(lesson, PanelTab::Light);
    pick(&mut window, "square", DVec3::ZERO, DVec3::Y);
    let (there, _) = shown_factor(&window, 0);
    pick(&mut window, "sheet", DVec3::new(0.2, 0.5, -0.6), DVec3::Z);
    let (back, _) = shown_factor(&window, 0);
    answers(&mut window, lesson, back / there, Verdict::Wrong);
    answers(&mut window, lesson, there / back, Verdict::Right);
    // Half the cross product of the diagonals.
    let [a, b] = [[1.25, 0.8], [-0.9, 1.1]];
    let area = 0.5 * f64::abs(a[0] * b[1] - a[1] * b[0]);
    assert!((lesson.known_answer().value - area).abs() < 1e-9, "{area}");
}

#[test]
fn rays_against_hemicubes() {
    let lesson = Lesson::Engines;
    let mut window = begun(lesson, PanelTab::Light);
    pick(&mut window, "floor", DVec3::new(250.0, 0.0, 50.0), DVec3::Y);
    // It does not settle while the engines run.
    find(&window, Role::Button, "Compare engines").click();
    wait(&mut window);
    let runs = window.state().app.lighting.engine_runs.clone();
    let error = |engine, samples| {
        let found = runs
            .iter()
            .find(|r| (r.engine, r.samples) == (engine, samples));
        100.0 * found.expect("such a run").error
    };
    let (few, many) = (
        error(EngineChoice::Rays, 256),
        error(EngineChoice::Rays, 65_536),
    );
    // The table has them in three digits.
    for shown in [few, many] {
        let digits = (2 - shown.log10().floor() as i32).max(0) as usize;
        assert!(says(&window, &format!("{shown:.digits$} %")), "{shown}");
    }
    answers(&mut window, lesson, few, Verdict::Wrong);
    answers(&mut window, lesson, few / many, Verdict::Right);
    // Of hemicubes sixteen times the pixels change nothing.
    let cube = |pixels: u32| error(EngineChoice::Hemicube, 48 * pixels * pixels);
    assert!((cube(256) / cube(64) - 1.0).abs() < 0.1 && cube(256) > 10.0 * many);
}

#[test]
fn a_mirror_and_its_image() {
    let lesson = Lesson::Mirror;
    let mut window = begun(lesson, PanelTab::Light);
    let seen = |window: &mut TestWindow, row| {
        pick(window, "lower", DVec3::ZERO, DVec3::Y);
        shown_factor(window, row).0
    };
    let with_mirror = seen(&mut window, 0);
    find(&window, Role::Link, "mirror").click();
    window.run();
    press(&mut window, Modifiers::NONE, Key::Delete);
    let direct = seen(&mut window, 0);
    assert!((direct - opposed(1.0, 1.0, 1.0)).abs() < 1e-6);
    find(&window, Role::Link, "upper").click();
    window.run();
    press(&mut window, Modifiers::COMMAND, Key::D);
    window.state_mut().tab = PanelTab::Object;
    window.run();
    set(&mut window, "Position x", -1.0);
    set(&mut window, "Position y", 1.0);
    set(&mut window, "Position z", 0.0);
    window.state_mut().tab = PanelTab::Light;
    let image = seen(&mut window, 1);
    let truth = parallel([0.0, 1.0], [0.0, 1.0], [-1.0, 0.0], [0.0, 1.0], 1.0);
    assert!((image - truth).abs() < 1e-6, "{image} {truth}");
    answers(
        &mut window,
        lesson,
        (with_mirror - direct) / direct,
        Verdict::Wrong,
    );
    answers(
        &mut window,
        lesson,
        (with_mirror - direct) / image,
        Verdict::Right,
    );
}

#[test]
fn rough_metal_at_grazing_angles() {
    let lesson = Lesson::Grazing;
    let mut window = begun(lesson, PanelTab::Material);
    let materials = window.state().app.document.materials.clone();
    let mirrored = |name: &str, degrees: f64| {
        let material = materials.iter().find(|m| m.name == name);
        let cos = degrees.to_radians().cos();
        100.0 * material.expect("a plate").mirror_at(cos).luminance()
    };
    // What the plot writes at the dotted ray.
    let shown = (10.0 * mirrored("waves", 80.0)).round() / 10.0;
    answers(&mut window, lesson, mirrored("waves", 45.0), Verdict::Wrong);
    answers(&mut window, lesson, shown, Verdict::Right);
    assert!((mirrored("waves", 78.320) - 45.0).abs() < 0.1);
    assert!([45.0, 80.0].iter().all(|&d| mirrored("facets", d) < 1e-9));
    let phase = 4.0 * std::f64::consts::PI * 0.18 * 80f64.to_radians().cos() / 0.55;
    let known = lesson.known_answer();
    assert!((known.value - 90.0 * (-phase * phase).exp()).abs() < 0.1);
}

#[test]
fn an_error_bar_of_four_estimates() {
    let lesson = Lesson::ErrorBar;
    let mut window = begun(lesson, PanelTab::Light);
    pick(&mut window, "lower", DVec3::ZERO, DVec3::Y);
    let (_, error) = shown_factor(&window, 0);
    let found = window.state().app.lighting.form_factors.clone().unwrap();
    let (_, found) = found.objects[0];
    let estimates = found.estimates.expect("independent estimates");
    let mean = estimates.iter().sum::<f64>() / 4.0;
    let squares: f64 = estimates.iter().map(|e| (e - mean).powi(2)).sum();
    let naive = (squares / 3.0).sqrt() / 2.0;
    assert!((error.expect("an error") / found.factor.error - 1.0).abs() < 0.05);
    answers(&mut window, lesson, 1.0, Verdict::Wrong);
    answers(
        &mut window,
        lesson,
        found.factor.error / naive,
        Verdict::Right,
    );
}

#[test]
fn a_letter_and_its_mesh() {
    let lesson = Lesson::Letter;
    let mut window = begun(lesson, PanelTab::Object);
    let mut flux = Vec::new();
    for name in ["exact", "mesh"] {
        let app = &mut window.state_mut().app;
        let id = app
            .document
            .objects
            .iter()
            .find(|o| o.name == name)
            .unwrap()
            .id;
        let selection = azulejo_workbench::command::Selection::one(id);
        app.execute(Command::Select(selection));
        window.run();
        let field = labels(&window)
            .into_iter()
            .find(|l| l.starts_with("SpinButton Flux"));
        let field = field.unwrap_or_else(|| panic!("{:#?}", labels(&window)));
        let label = field.strip_prefix("SpinButton ").unwrap().to_owned();
        let node = find(&window, Role::SpinButton, &label);
        flux.push(node.accesskit_node().numeric_value().unwrap_or(f64::NAN));
    }
    answers(&mut window, lesson, flux[1] / flux[0], Verdict::Wrong);
    answers(&mut window, lesson, flux[0] / flux[1], Verdict::Right);
}

/// Every letter of all lessons can be drawn: a missing one is a panic in tests.
#[test]
fn every_lesson_is_shown_in_every_language() {
    let mut window = window(App::quiet());
    for language in Language::ALL {
        for lesson in (1..).map_while(Lesson::from_number) {
            let app = &mut window.state_mut().app;
            app.preferences.language = language;
            app.execute(Command::ShowLab(Some(lesson)));
            window.run();
            // Once open, an answer stays open in other languages.
            let show = language.tr("Show the answer");
            let header = find(&window, Role::DisclosureTriangle, show);
            if language == Language::English {
                header.click_accesskit();
                window.run();
            }
            assert!(says(&window, &lesson.texts(language).title));
            let known = lesson.known_answer().shown();
            assert!(says(&window, &known), "{known}");
        }
    }
}

#[test]
fn a_link_opens_a_lesson_in_its_language() {
    let mut app = App::quiet();
    app.follow(LabLink::from_query("?lab=3&lang=es").unwrap());
    let window = window(app);
    assert!(says(&window, "Abrir la escena"));
    let names: Vec<&str> = (window.state().app.document.objects.iter())
        .map(|o| o.name.as_str())
        .collect();
    assert_eq!(names, ["square", "sheet"]);
    assert!(!window.state().app.is_changed());
}
