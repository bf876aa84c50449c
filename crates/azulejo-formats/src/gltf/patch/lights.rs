//! Lights that were baked, which must not shine a second time.

use super::json::Json;
use super::types::LightsMode;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::HashMap;

/// The extension with the lights.
pub const LIGHTS: &str = "KHR_lights_punctual";

/// Lists of lights, and the member of the mark with what they were: for each light that was dimmed its number, and
/// its intensity, `null` if it had none. Pictures of the surroundings are lights, too.
const DIMMED: [(&str, &str); 2] = [
    ("baked", LIGHTS),
    ("baked_surroundings", "EXT_lights_image_based"),
];

/// Dims or removes the lights, says in the mark what they were, and returns whether some went dark. Surroundings are
/// dimmed in either case.
pub fn change<'s>(json: &mut Json<'s>, mode: LightsMode, mark: &mut Json<'s>) -> bool {
    let dimmed: &[(&str, &str)] = match mode {
        LightsMode::Keep => &[],
        LightsMode::Dim => &DIMMED,
        LightsMode::Remove => &DIMMED[1..],
    };
    for (member, extension) in dimmed {
        let mut baked = Json::List(Vec::new());
        for_each(json, extension, |i, light| {
            let old = light.get("intensity").cloned();
            if old.as_ref().and_then(Json::number) != Some(0.0) {
                light.key("intensity").set(json!(0));
                baked.push(Json::List(vec![
                    i.into(),
                    old.unwrap_or(Value::Null.into()),
                ]));
            }
        });
        if !baked.list().is_empty() {
            mark.key(member).set(baked);
        }
    }
    if mode == LightsMode::Remove {
        for i in 0..json.entries("nodes").len() {
            if json.entries("nodes")[i]
                .find(&["extensions", LIGHTS])
                .is_some()
            {
                json.key("nodes").at(i).key("extensions").remove(LIGHTS);
            }
        }
    }
    mode == LightsMode::Remove || dimmed.iter().any(|(member, _)| mark.get(member).is_some())
}

/// Gives lights that are still dark their old intensity.
pub fn brighten(json: &mut Json, mark: &Json) {
    for (member, extension) in DIMMED {
        let baked = mark.entries(member).iter().map(Json::list);
        let baked = baked.filter_map(|b| Some((b.first()?.index()?, b.get(1))));
        let baked: HashMap<usize, Option<&Json>> = baked.collect();
        for_each(json, extension, |i, light| {
            let is_dark = light.get("intensity").and_then(Json::number) == Some(0.0);
            let Some(old) = baked.get(&i).filter(|_| is_dark) else {
                return;
            };
            // Earlier versions had the number in a text.
            let spelled =
                old.map(|old| old.text().map_or_else(|| old.to_string(), Cow::into_owned));
            match spelled.filter(|old| serde_json::from_str::<f64>(old).is_ok()) {
                Some(old) => light.key("intensity").set(Json::Scalar(old.into())),
                None => light.remove("intensity"),
            }
        });
    }
}

fn for_each<'s>(
    json: &mut Json<'s>,
    extension: &str,
    mut change: impl FnMut(usize, &mut Json<'s>),
) {
    let steps = ["extensions", extension, "lights"];
    let count = json.find(&steps).map_or(0, |list| list.list().len());
    for i in 0..count {
        let lights = steps.iter().fold(&mut *json, |json, step| json.key(step));
        change(i, lights.at(i));
    }
}
