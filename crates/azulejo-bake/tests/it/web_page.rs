//! The page as a file: its size, its repeatability, and what it does with hostile texts.

use crate::room::{Room, lamp_light};
use azulejo_bake::web_page::{self, PageModel};
use azulejo_scene::random::split_mix64;

fn page(model: &PageModel) -> Vec<u8> {
    let mut bytes = Vec::new();
    web_page::write(model, &mut bytes).expect("a valid model");
    bytes
}

/// The room at 1024² is under 2 MB, viewer and standard errors included, and the same bytes every time.
#[test]
fn a_room_is_small_and_repeatable() {
    let model = Room::cornell().page(1024, lamp_light);
    let bytes = page(&model);
    assert!(bytes.len() < 2_000_000, "{} bytes", bytes.len());
    assert!(bytes == page(&model));
}

/// As small with the noise of a solution: 1% in each texel, and more than the goal's error.
#[test]
fn a_noisy_room_is_small() {
    let mut model = Room::cornell().page(1024, lamp_light);
    let mut state = 1;
    let map = &mut model.lightmaps[0];
    for (texel, error) in map.irradiance.iter_mut().zip(&mut map.standard_error) {
        let sum: f64 = (0..12).map(|_| split_mix64(&mut state)).sum();
        let noise = 1.0 + 0.01 * (sum - 6.0) as f32;
        *texel = texel.map(|x| x * noise);
        *error = texel.map(|x| x * 0.01 * (1.0 + 0.1 * (noise - 1.0) * 100.0));
    }
    let bytes = page(&model);
    assert!(bytes.len() < 2_000_000, "{} bytes", bytes.len());
}

/// No text of the model ends an element or starts one.
#[test]
fn hostile_texts_stay_texts() {
    let hostile = "</script><script>alert(1)</script><!--<script>{{program}}\u{2028}\0\"'&amp;]]>";
    let mut model = Room::cornell().page(64, lamp_light);
    let plain = String::from_utf8(page(&model)).unwrap();
    model.title = hostile.into();
    model.note = hostile.into();
    model.meshes[0].name = hostile.into();
    model.materials[0].name = hostile.into();
    model.cameras[0].name = hostile.into();
    let page = String::from_utf8(page(&model)).unwrap();
    for tag in ["<script", "</script", "<!--", "offerHook(started)"] {
        let count = |text: &str| text.matches(tag).count();
        assert_eq!(count(&page), count(&plain), "{tag}");
    }
    let head = page.split("id=\"head\">").nth(1).unwrap();
    let head: serde_json::Value =
        serde_json::from_str(head.split("</script>").next().unwrap()).unwrap();
    assert_eq!(head["meshes"][0]["name"], hostile);
    assert_eq!(head["note"], hostile);
}
