//! The editor as the user operates it: by roles and labels of its widgets.

use super::*;
use azulejo::scene::Brdf;
use azulejo::scene::brdf::MODELS;
use azulejo_testing::Need;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::time::{Duration, Instant};

/// A document with one material, and all responses that changed it.
struct EditorFixture {
    editor: BrdfEditor,
    material: Arc<Material>,
    others: Vec<Arc<Material>>,
    light: PreviewLight,
    language: Language,
    answers: Vec<EditorResponse>,
}

impl EditorFixture {
    fn new(material: Material) -> EditorFixture {
        EditorFixture {
            editor: BrdfEditor::default(),
            material: Arc::new(material),
            others: Vec::new(),
            light: PreviewLight::studio(),
            language: Language::English,
            answers: Vec::new(),
        }
    }

    fn ui(&mut self, ui: &mut Ui) {
        let shown = EditorInput {
            key: 1,
            material: &self.material,
            others: &self.others,
            light: &self.light,
            is_photometric: false,
        };
        let answers = self.editor.ui(ui, self.language, &shown);
        for answer in &answers {
            if let EditorResponse::Change { material, .. } = answer {
                self.material = Arc::new(material.clone());
            }
        }
        self.answers.extend(answers);
    }

    /// The description in the document.
    fn text(&self) -> String {
        self.material
            .brdf
            .as_ref()
            .map_or(String::new(), |b| b.description().to_string())
    }

    fn finished(&self) -> Vec<bool> {
        let finished = |a: &EditorResponse| match a {
            EditorResponse::Change { is_finished, .. } => Some(*is_finished),
            _ => None,
        };
        self.answers.iter().filter_map(finished).collect()
    }
}

fn parse_material(text: &str) -> Material {
    let brdf = Brdf::new(text.parse().unwrap()).unwrap();
    Material::with_brdf("subject", Arc::new(brdf))
}

fn harness(bench: EditorFixture) -> Harness<'static, EditorFixture> {
    Harness::builder()
        .with_size(egui::vec2(420.0, 1400.0))
        .with_max_steps(16)
        .build_ui_state(|ui, bench: &mut EditorFixture| bench.ui(ui), bench)
}

/// Runs frames until a condition holds; the editor's threads may be slow.
fn until(
    harness: &mut Harness<'static, EditorFixture>,
    what: &str,
    mut holds: impl FnMut(&Harness<'static, EditorFixture>) -> bool,
) {
    let start = Instant::now();
    while !holds(harness) {
        assert!(start.elapsed() < Duration::from_secs(60), "{what}");
        std::thread::sleep(Duration::from_millis(2));
        harness.step();
    }
}

/// Opens a list and chooses an entry.
fn choose(harness: &mut Harness<'static, EditorFixture>, list: &str, entry: &str) {
    harness.get_by_role_and_label(Role::ComboBox, list).click();
    harness.run_steps(3);
    harness.get_by_role_and_label(Role::Button, entry).click();
    harness.run_steps(4);
}

/// Types a number into a field.
fn enter(harness: &mut Harness<'static, EditorFixture>, field: &str, number: &str) {
    harness
        .get_by_role_and_label(Role::SpinButton, field)
        .focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text(number.to_owned()));
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
}

#[test]
fn another_model_keeps_what_both_have() {
    let mut harness = harness(EditorFixture::new(parse_material(
        "blinn kd = 0.1 ks = 0.5 n = 30",
    )));
    harness.run_steps(3);
    choose(&mut harness, "Model", "Lewis (modified Phong)");
    until(&mut harness, "Lewis", |h| {
        h.state().text().starts_with("lewis")
    });
    assert_eq!(harness.state().text(), "lewis kd = 0.1 ks = 0.5 n = 30");
    assert_eq!(harness.state().finished().last(), Some(&true));
}

#[test]
fn a_kind_of_surface_becomes_another() {
    let mut harness = harness(EditorFixture::new(Material::diffuse(
        "wall",
        Rgb::new(0.8, 0.4, 0.2),
    )));
    harness.run_steps(3);
    choose(&mut harness, "Surface", "Reflection model");
    assert_eq!(harness.state().text(), "diffuse kd = (0.8, 0.4, 0.2)");
    choose(&mut harness, "Surface", "Glass");
    assert!(harness.state().material.dielectric.is_some());
    enter(&mut harness, "Refractive index", "2.4");
    assert_eq!(
        harness.state().material.dielectric.map(|g| g.ior),
        Some(2.4)
    );
    harness
        .get_by_role_and_label(Role::CheckBox, "Thin pane")
        .click();
    harness.run_steps(2);
    assert_eq!(
        harness.state().material.dielectric.map(|g| g.thin),
        Some(true)
    );
    choose(&mut harness, "Surface", "Reflection model");
    assert_eq!(
        harness.state().text(),
        "diffuse kd = (0.8, 0.4, 0.2)",
        "what was left comes back"
    );
    choose(&mut harness, "Surface", "Mirror");
    assert_eq!(harness.state().material.mirror, Rgb::new(0.8, 0.4, 0.2));
    choose(&mut harness, "Surface", "Matt surface");
    assert_eq!(
        harness.state().material.diffuse,
        Rgb::new(0.8, 0.4, 0.2),
        "the colour is kept all the way"
    );
}

#[test]
fn varnish_gives_the_colour_back() {
    let red = Rgb::new(0.8, 0.1, 0.05);
    let mut harness = harness(EditorFixture::new(Material::diffuse("wall", red)));
    harness.run_steps(3);
    choose(&mut harness, "Surface", "Reflection model");
    choose(
        &mut harness,
        "Model",
        "Smooth varnish: what a dielectric's surface mirrors",
    );
    until(&mut harness, "varnish", |h| {
        h.state().text().starts_with("fresnel_dielectric")
    });
    choose(&mut harness, "Surface", "Matt surface");
    assert_eq!(harness.state().material.diffuse, red);
}

#[test]
fn a_slider_moves_by_keyboard() {
    let mut harness = harness(EditorFixture::new(parse_material(
        "gltf_mr base = 0.5 roughness = 0.5",
    )));
    harness.run_steps(3);
    harness
        .get_by_role_and_label(Role::Slider, "Metallic")
        .focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(3);
    until(&mut harness, "a change", |h| {
        h.state().text().contains("metallic")
    });
    let finished = harness.state().finished();
    assert_eq!(finished.last(), Some(&true), "{finished:?}");
}

#[test]
fn numbers_are_typed() {
    let mut harness = harness(EditorFixture::new(parse_material("lewis ks = 0.5 n = 20")));
    harness.run_steps(3);
    enter(&mut harness, "Exponent (n)", "123.5");
    until(&mut harness, "the number", |h| {
        h.state().text() == "lewis ks = 0.5 n = 123.5"
    });
    // Defaults that were not changed are not written.
    assert_eq!(
        harness.state().answers.len(),
        1,
        "{:?}",
        harness.state().answers
    );
}

#[test]
fn what_is_impossible_is_said_and_the_last_good_model_stays() {
    let mut harness = harness(EditorFixture::new(parse_material("lewis ks = 0.5 n = 20")));
    harness.run_steps(3);
    enter(&mut harness, "Specular reflectance (ks)", "1.5");
    let error = "ks is 1.5; it must be between 0 and 1.";
    until(&mut harness, "an error", |h| {
        h.query_by_label_contains(error).is_some()
    });
    assert_eq!(harness.state().text(), "lewis ks = 0.5 n = 20");
    assert!(harness.state().answers.is_empty());
    enter(&mut harness, "Specular reflectance (ks)", "0.7");
    until(&mut harness, "a good model", |h| {
        h.state().text() == "lewis ks = 0.7 n = 20"
    });
    assert!(harness.query_by_label_contains("must be between").is_none());
}

#[test]
fn a_drag_is_one_step() {
    let mut harness = harness(EditorFixture::new(parse_material(
        "gltf_mr base = 0.5 roughness = 0.5",
    )));
    harness.run_steps(3);
    let slider = harness
        .get_by_role_and_label(Role::Slider, "Roughness")
        .rect();
    harness.drag_at(slider.center());
    for k in 0..6 {
        harness.hover_at(slider.center() + egui::vec2(5.0 * k as f32, 0.0));
        harness.run_steps(1);
    }
    let dragged = harness.state().finished();
    assert!(
        dragged.len() > 2 && dragged.iter().all(|f| !f),
        "{dragged:?}"
    );
    harness.drop_at(slider.center() + egui::vec2(25.0, 0.0));
    until(&mut harness, "the end", |h| {
        h.state().finished().last() == Some(&true)
    });
    harness.run_steps(5);
    let finished = harness.state().finished();
    assert_eq!(finished.iter().filter(|f| **f).count(), 1, "{finished:?}");
}

#[test]
fn the_document_wins_over_the_editor() {
    let mut harness = harness(EditorFixture::new(parse_material("lewis ks = 0.5 n = 20")));
    harness.run_steps(3);
    enter(&mut harness, "Exponent (n)", "-3");
    harness.state_mut().material = Arc::new(parse_material("blinn ks = 0.5 n = 8"));
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("must be between").is_none());
    assert_eq!(harness.state().text(), "blinn ks = 0.5 n = 8");
}

#[test]
fn models_are_added_and_removed() {
    let mut harness = harness(EditorFixture::new(parse_material("lewis ks = 0.5 n = 20")));
    harness.run_steps(3);
    harness.get_by_label("Add a model").click();
    harness.run_steps(3);
    let sum =
        "combination weight = 0.5 lewis ks = 0.5 n = 20 weight = 0.5 diffuse kd = (0.8, 0.5, 0.3)";
    until(&mut harness, "a sum", |h| h.state().text() == sum);
    enter(&mut harness, "Weight 2", "0.75");
    until(&mut harness, "an error", |h| {
        h.query_by_label_contains("more than 1").is_some()
    });
    enter(&mut harness, "Weight 1", "0.25");
    until(&mut harness, "weights", |h| {
        h.state().text().starts_with("combination weight = 0.25")
    });
    harness.get_by_label("Remove model 1").click();
    harness.run_steps(3);
    until(&mut harness, "one model", |h| {
        h.state().text() == "diffuse kd = (0.8, 0.5, 0.3)"
    });
}

#[test]
fn files_are_asked_for() {
    let mut harness = harness(EditorFixture::new(parse_material("lewis ks = 0.5 n = 20")));
    harness.run_steps(3);
    harness.get_by_label("Load…").click();
    harness.run_steps(2);
    harness.get_by_label("Save…").click();
    harness.run_steps(2);
    let [EditorResponse::Load, EditorResponse::Save(text)] = &harness.state().answers[..] else {
        panic!("{:?}", harness.state().answers);
    };
    let read = apply_file(text.as_bytes(), std::path::Path::new("a.brdf")).unwrap();
    assert_eq!(read.description.to_string(), "lewis ks = 0.5 n = 20");
}

#[test]
fn metals_are_chosen_by_name() {
    let mut harness = harness(EditorFixture::new(parse_material(
        "ggx_smith ax = 0.2 eta = 1.5",
    )));
    harness.run_steps(3);
    choose(&mut harness, "Fresnel", "Metal");
    until(&mut harness, "gold", |h| {
        h.state().text() == "ggx_smith ax = 0.2 metal = gold"
    });
    choose(&mut harness, "Metal", "titanium");
    until(&mut harness, "titanium", |h| {
        h.state().text() == "ggx_smith ax = 0.2 metal = titanium"
    });
}

#[test]
fn two_models_are_compared() {
    let mut bench = EditorFixture::new(parse_material("lewis ks = 0.5 n = 20"));
    bench.others = vec![
        bench.material.clone(),
        Arc::new(Material::diffuse("plaster", Rgb::grey(0.8))),
    ];
    let mut harness = harness(bench);
    harness.run_steps(3);
    choose(&mut harness, "Compare with", "   plaster");
    until(&mut harness, "a difference", |h| {
        h.query_by_label_contains("Largest difference").is_some()
    });
    let spheres = harness.get_all_by_label_contains("Sphere of the material");
    assert_eq!(spheres.count(), 2);
    assert!(
        harness.state().answers.is_empty(),
        "to look changes nothing"
    );
}

#[test]
fn badges_say_what_models_keep() {
    let check = |model: &str, expected: [&str; 2]| {
        let mut harness = harness(EditorFixture::new(parse_material(model)));
        for words in expected {
            until(&mut harness, words, |h| {
                h.query_by_label_contains(words).is_some()
            });
        }
    };
    check(
        "lewis kd = 0.5 ks = 0.5 n = 20",
        ["reciprocal", "energy conserved, albedo at most"],
    );
    check(
        "phong kd = 0.3 ks = 0.4 n = 10",
        ["not reciprocal", "energy"],
    );
}

#[test]
fn light_is_given_and_coloured() {
    let mut harness = harness(EditorFixture::new(Material::diffuse(
        "lamp",
        Rgb::grey(0.5),
    )));
    harness.run_steps(3);
    enter(&mut harness, "Emission", "10");
    assert_eq!(harness.state().material.emission, Rgb::grey(10.0));
    enter(&mut harness, "Emission colour B", "0.5");
    assert_eq!(harness.state().material.emission, Rgb::new(10.0, 10.0, 5.0));
    enter(&mut harness, "Emission", "0");
    enter(&mut harness, "Emission", "2");
    assert_eq!(
        harness.state().material.emission,
        Rgb::new(2.0, 2.0, 1.0),
        "the colour is kept"
    );
}

#[test]
fn every_model_is_shown_and_stays_as_it_is() {
    // All examples where tests are thorough, else the first of each model.
    let most = if azulejo_testing::is_thorough() {
        usize::MAX
    } else {
        1
    };
    for model in MODELS {
        for example in model.examples.iter().take(most) {
            let mut harness = harness(EditorFixture::new(parse_material(example)));
            harness.run_steps(3);
            assert!(
                harness.state().answers.is_empty(),
                "{example}: {:?}",
                harness.state().answers
            );
            assert!(
                harness
                    .query_by_role_and_label(Role::ComboBox, "Model")
                    .is_some()
            );
        }
    }
}

/// Whether images of the window can be drawn here.
fn has_driver() -> bool {
    use azulejo::gpu::{Backend, Card};
    let card = Card::open(Backend::Vulkan).or_else(|_| Card::open(Backend::Gl));
    let card = card.map_err(|_| "no graphics driver");
    azulejo_testing::require(Need::Gpu, card).is_some()
}

/// The editor with all results, in a panel of a window.
fn drawn(bench: EditorFixture, theme: egui::Theme, height: f32) -> Harness<'static, EditorFixture> {
    let mut harness = Harness::builder()
        .with_size(egui::vec2(420.0, height))
        .with_theme(theme)
        .with_max_steps(16)
        .wgpu()
        .build_ui_state(|ui, bench: &mut EditorFixture| bench.ui(ui), bench);
    harness.run_steps(3);
    until(&mut harness, "the end of all work", |h| {
        !h.state().editor.is_busy()
    });
    harness.run_steps(3);
    harness
}

#[test]
fn the_editor_looks_as_it_did() {
    if !has_driver() {
        return;
    }
    let mut bench = EditorFixture::new(parse_material(
        "cook_torrance kd = 0.1 ks = 0.6 m = 0.3 metal = copper",
    ));
    bench.others = vec![Arc::new(Material::diffuse("plaster", Rgb::grey(0.8)))];
    bench.editor.view.has_others = false;
    let mut harness = drawn(bench, egui::Theme::Dark, 1040.0);
    // Monte Carlo noise does not belong in a snapshot.
    let sphere = harness
        .get_by_label_contains("Sphere of the material")
        .rect();
    harness.mask(sphere);
    // Drivers round differently at edges.
    let options = egui_kittest::SnapshotOptions::new()
        .threshold(1.5)
        .max_failed_pixels(300);
    harness.snapshot_options("brdf_editor", &options);
}
