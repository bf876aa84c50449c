//! Steps that bake lightmaps, save and show them.

use super::fields::{number, one_of, path, percent, split, unless, variant, whole};
use super::step::{ScriptStep, StepResult, command, commands};
use crate::bake::{BakeSettings, LightmapFile};
use crate::command::Command;
use crate::ui::lightmap::LightmapView;
use azulejo::formats::gltf::patch::Convention;
use azulejo::lightmap::{BakedLight, BakedSides};

/// The step of this first word; `None` if it is about something else.
pub(super) fn parse(word: &str, rest: &str) -> Option<StepResult> {
    Some(match word {
        "bake" => bake(rest),
        "save-lightmap" => path(word, rest).map(|path| {
            let extension = path.extension().map(|e| e.to_ascii_lowercase());
            let what = if extension.is_some_and(|e| e == "exr") {
                LightmapFile::Irradiance
            } else {
                LightmapFile::Model
            };
            command(Command::SaveLightmap(what, path))
        }),
        "save-error-map" => path(word, rest)
            .map(|path| command(Command::SaveLightmap(LightmapFile::StandardError, path))),
        "lightmap" => unless("none", rest, page).map(ScriptStep::ShowLightmap),
        _ => return None,
    })
}

/// `bake`, `bake size=512 error=5%`: with these settings; others keep their values.
fn bake(text: &str) -> StepResult {
    // Applied once before the script runs, so that mistakes are reported at its start.
    let mut settings = BakeSettings::default();
    (text.split_whitespace()).try_for_each(|option| set(&mut settings, option))?;
    let text = text.to_owned();
    Ok(commands(move |app| {
        let mut settings = app.lightmap.settings;
        (text.split_whitespace()).try_for_each(|option| set(&mut settings, option))?;
        Ok(vec![Command::SetBake(settings), Command::Bake])
    }))
}

/// Changes settings by an option such as `size=512`.
fn set(settings: &mut BakeSettings, option: &str) -> Result<(), String> {
    let (key, value) = option.split_once('=').unwrap_or((option, ""));
    match key {
        "size" => match whole(value, 8192)? {
            few @ ..16 => return Err(format!("a page of {few} texels, expected 16 to 8192")),
            size => (settings.size, settings.texels_per_metre) = (size, None),
        },
        "texels-per-metre" => match number(value)? {
            density if density > 0.0 => settings.texels_per_metre = Some(density),
            density => return Err(format!("{density} texels per metre, expected more than 0")),
        },
        "error" => settings.error = percent(value, 0.1)?,
        "light" => settings.light = one(key, value, &LIGHTS)?,
        "sides" => settings.sides = one(key, value, &SIDES)?,
        "as" => settings.convention = one(key, value, &CONVENTIONS)?,
        other => {
            return Err(format!(
                "bake \"{other}\", expected size, texels-per-metre, error, light, sides or as"
            ));
        }
    }
    Ok(())
}

const LIGHTS: [(&str, BakedLight); 3] = [
    ("total", BakedLight::Total),
    ("indirect", BakedLight::Indirect),
    ("direct", BakedLight::Direct),
];

const SIDES: [(&str, Option<BakedSides>); 4] = [
    ("usual", None),
    ("front", Some(BakedSides::Front)),
    ("brighter", Some(BakedSides::Brighter)),
    ("both", Some(BakedSides::Both)),
];

const CONVENTIONS: [(&str, Convention); 3] = [
    ("moz", Convention::Moz),
    ("mx", Convention::Mx),
    ("plain", Convention::Plain),
];

/// What one of some words stands for.
fn one<T: Copy>(key: &str, value: &str, words: &[(&str, T)]) -> Result<T, String> {
    one_of(key, value, words, |(word, _)| word.to_owned()).map(|(_, meaning)| meaning)
}

/// `VIEW`, `VIEW PAGE`: what the window with the lightmap shows.
fn page(text: &str) -> Result<(LightmapView, u32), String> {
    let (view, page) = split(text);
    let view = variant("lightmap view", view)?;
    let page = if page.is_empty() {
        1
    } else {
        whole(page, 65_536)?
    };
    Ok((view, page))
}
