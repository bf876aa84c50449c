//! Parts of glTF's JSON shared by nodes, lights, cameras and materials.

use azulejo_scene::Rgb;
use serde_json::{Map, Value, json};

/// An object with a name, unless the name is empty.
pub(super) fn named(name: &str) -> Map<String, Value> {
    let mut json = Map::new();
    if !name.is_empty() {
        json.insert("name".into(), json!(name));
    }
    json
}

/// A colour as a factor, whose largest channel is 1, and a strength.
pub(super) fn factor_and_strength(colour: Rgb) -> (Rgb, f64) {
    let most = colour.max_channel();
    if most > 0.0 {
        (colour.map(|c| c / most), most)
    } else {
        (Rgb::WHITE, 0.0)
    }
}
