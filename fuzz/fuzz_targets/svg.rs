//! Any bytes as a drawing in SVG, DXF or PDF: its figures must make a valid scene, and polygons.
#![no_main]

use azulejo_formats::outline::Filled;
use azulejo_formats::{FontFile, Memory, ReadOptions, read_drawing};
use azulejo_scene::{Exact, Material, Object, Prism, Scene, Shape, Solid};
use libfuzzer_sys::fuzz_target;
use std::sync::Arc;

/// A font of a few letters for its texts.
fn font() -> Memory {
    Memory::new().with_font(FontFile {
        name: "tiny.ttf".into(),
        bytes: include_bytes!("../seeds/fonts/tiny.ttf").to_vec(),
        face: 0,
    })
}

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let Ok(drawing) = read_drawing(bytes, "fuzz", &font(), &options) else {
        return;
    };
    for shape in drawing
        .shapes
        .iter()
        .filter(|s| s.figure.curve_count() < 1000)
    {
        let size = shape.figure.bounds().size().max_element();
        shape.figure.tiling(1e-3 * size);
    }
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
