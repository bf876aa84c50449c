//! Any bytes as a page of a PDF: its figures must make a valid scene.
#![no_main]

use azulejo_formats::ReadOptions;
use azulejo_formats::outline::{Filled, pdf};
use azulejo_scene::{Exact, Material, Object, Prism, Scene, Shape, Solid};
use libfuzzer_sys::fuzz_target;
use std::sync::Arc;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let Ok(drawing) = pdf::read(bytes, "fuzz", &options) else {
        return;
    };
    let mut scene = Scene::default();
    scene.add_material(Material::default());
    let prism = |shape: Filled| {
        Solid::Prism(Prism {
            figure: Arc::new(shape.figure),
            world_from_figure: Default::default(),
            material: 0,
            bevel: None,
        })
    };
    let solids = drawing.shapes.into_iter().map(prism).collect();
    let shape = Shape::Exact(Exact::new(solids));
    scene.objects.push(Object::new("drawing", shape));
    scene.validate().expect("a reader gives valid figures");
});
