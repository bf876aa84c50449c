//! Frame times of the BRDF editor while a parameter is dragged and everything that depends on it
//! is recomputed in the background.
//!
//! Prints the median and the maximum of 200 frames for each model, in milliseconds of wall-clock
//! time: layout, text and tessellation of the widgets, without drawing them on a GPU. An argument
//! selects the models whose name contains it.

use azulejo::scene::brdf::MODELS;
use azulejo::scene::{Brdf, Material};
use azulejo_workbench::ui::brdf::{BrdfEditor, EditorInput, EditorResponse, PreviewLight};
use azulejo_workbench::words::Language;
use egui_kittest::Harness;
use std::sync::Arc;
use std::time::{Duration, Instant};

const FRAMES: usize = 200;

fn main() {
    let filter = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    for model in MODELS {
        if filter
            .as_ref()
            .is_none_or(|w| model.name.contains(w.as_str()))
        {
            report(model.name, &frames(model.examples[0]));
        }
    }
}

#[allow(clippy::print_stdout)] // A bench speaks to people.
fn report(name: &str, sorted: &[Duration]) {
    let ms = |d: &Duration| 1e3 * d.as_secs_f64();
    let (middle, worst) = (ms(&sorted[sorted.len() / 2]), ms(&sorted[sorted.len() - 1]));
    println!("{name:24} median {middle:6.2} ms   worst {worst:6.2} ms");
}

/// Times of all frames in ascending order. The document's material changes in every frame.
fn frames(example: &str) -> Vec<Duration> {
    let light = PreviewLight::studio();
    let mut material = made(example, 0);
    let mut editor = BrdfEditor::default();
    let mut took = Vec::new();
    let mut frame = 0;
    let mut harness = Harness::builder()
        .with_size(egui::vec2(420.0, 1200.0))
        .build_ui(|ui| {
            let shown = EditorInput {
                key: 1,
                material: &material,
                others: &[],
                light: &light,
                is_photometric: false,
            };
            let start = Instant::now();
            let answers = editor.ui(ui, Language::English, &shown);
            took.push(start.elapsed());
            assert!(!answers.iter().any(|a| matches!(a, EditorResponse::Save(_))));
            frame += 1;
            material = made(example, frame);
        });
    harness.run_steps(FRAMES);
    drop(harness);
    took.sort();
    took
}

/// The model added to a matt one, with a weight that changes from frame to frame.
fn made(example: &str, frame: usize) -> Arc<Material> {
    let weight = 0.4 + 1e-4 * frame as f64;
    let text = format!("combination weight = {weight} diffuse kd = 0.5 weight = 0.5 {example}");
    let brdf = text.parse().map(Brdf::new);
    let Ok(Ok(brdf)) = brdf else {
        panic!("an example of the table makes no model: {text}");
    };
    Arc::new(Material::with_brdf("subject", Arc::new(brdf)))
}
