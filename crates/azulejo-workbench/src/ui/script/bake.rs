//! Steps that bake lightmaps, save and show them.

use super::fields::{number, path, split, whole};
use crate::app::App;
use crate::bake::{BakeSettings, LightmapFile};
use crate::command::Command;
use crate::ui::lightmap::LightmapView;
use azulejo::formats::gltf::patch::Convention;
use azulejo::lightmap::{BakedLight, BakedSides};
use std::path::PathBuf;

/// What a step about lightmaps does.
#[derive(Clone, Debug, PartialEq)]
pub enum BakeStep {
    /// `bake`, `bake size=512 error=5%`: bakes with these settings, and otherwise those of before.
    Bake(Vec<BakeOption>),
    /// `save-lightmap FILE`: the model as `.glb` or `.gltf`, or irradiance as `.exr`.
    Save(PathBuf),
    /// `save-error-map FILE`: the standard error as `.exr`.
    SaveErrorMap(PathBuf),
    /// `lightmap VIEW`, `lightmap VIEW PAGE`, `lightmap none`: what the window with it shows.
    Show(Option<(LightmapView, u32)>),
}

/// An option of `bake`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BakeOption {
    /// `size=512`
    Size(u32),
    /// `texels-per-metre=20`
    Density(f64),
    /// `error=5%`
    Error(f64),
    /// `light=total`, `indirect`, `direct`
    Light(BakedLight),
    /// `sides=usual`, `front`, `brighter`
    Sides(Option<BakedSides>),
    /// `as=moz`, `mx`, `plain`
    Convention(Convention),
}

/// The step of this first word; `None` if it is about something else.
pub(super) fn parse(word: &str, rest: &str) -> Option<Result<BakeStep, String>> {
    Some(match word {
        "bake" => {
            let options: Result<Vec<_>, _> = rest.split_whitespace().map(option).collect();
            options.map(BakeStep::Bake)
        }
        "save-lightmap" => path(word, rest).map(BakeStep::Save),
        "save-error-map" => path(word, rest).map(BakeStep::SaveErrorMap),
        "lightmap" => show(rest),
        _ => return None,
    })
}

fn option(text: &str) -> Result<BakeOption, String> {
    let (key, value) = text.split_once('=').unwrap_or((text, ""));
    Ok(match key {
        "size" => match whole(value, 8192)? {
            few @ ..16 => return Err(format!("a page of {few} texels, expected 16 to 8192")),
            size => BakeOption::Size(size),
        },
        "texels-per-metre" => match number(value)? {
            density if density > 0.0 => BakeOption::Density(density),
            density => return Err(format!("{density} texels per metre, expected more than 0")),
        },
        "error" => {
            let percent = value.strip_suffix('%').and_then(|t| t.parse().ok());
            let valid = percent.filter(|p: &f64| (0.1..=100.0).contains(p));
            let error =
                valid.ok_or_else(|| format!("\"{value}\" is not an error, expected as in 5%"))?;
            BakeOption::Error(error / 100.0)
        }
        "light" => BakeOption::Light(one(
            key,
            value,
            &[
                ("total", BakedLight::Total),
                ("indirect", BakedLight::Indirect),
                ("direct", BakedLight::Direct),
            ],
        )?),
        "sides" => BakeOption::Sides(one(
            key,
            value,
            &[
                ("usual", None),
                ("front", Some(BakedSides::Front)),
                ("brighter", Some(BakedSides::Brighter)),
                ("both", Some(BakedSides::Both)),
            ],
        )?),
        "as" => BakeOption::Convention(one(
            key,
            value,
            &[
                ("moz", Convention::Moz),
                ("mx", Convention::Mx),
                ("plain", Convention::Plain),
            ],
        )?),
        other => {
            return Err(format!(
                "bake \"{other}\", expected size, texels-per-metre, error, light, sides or as"
            ));
        }
    })
}

/// One of some words.
fn one<T: Copy>(key: &str, value: &str, all: &[(&str, T)]) -> Result<T, String> {
    let found = all.iter().find(|(word, _)| *word == value);
    found.map(|(_, one)| *one).ok_or_else(|| {
        let words: Vec<&str> = all.iter().map(|(word, _)| *word).collect();
        format!("{key} \"{value}\", expected {}", words.join(", "))
    })
}

fn show(text: &str) -> Result<BakeStep, String> {
    if text == "none" {
        return Ok(BakeStep::Show(None));
    }
    let (view, page) = split(text);
    let names = LightmapView::ALL.map(|view| (view.script_name(), view));
    let view = one("lightmap", view, &names).map_err(|e| format!("{e}, none"))?;
    let page = match page {
        "" => 1,
        page => whole(page, 65_536)?,
    };
    Ok(BakeStep::Show(Some((view, page))))
}

impl BakeStep {
    /// The commands of the step.
    pub(super) fn commands(self, app: &App) -> Result<Vec<Command>, String> {
        Ok(match self {
            BakeStep::Bake(options) => {
                let mut settings = app.lightmap.settings;
                options.into_iter().for_each(|one| one.set(&mut settings));
                vec![Command::SetBake(settings), Command::Bake]
            }
            BakeStep::Save(path) => {
                let is_exr = path
                    .extension()
                    .is_some_and(|e| e.eq_ignore_ascii_case("exr"));
                let what = if is_exr {
                    LightmapFile::Irradiance
                } else {
                    LightmapFile::Model
                };
                vec![Command::SaveLightmap(what, path)]
            }
            BakeStep::SaveErrorMap(path) => {
                vec![Command::SaveLightmap(LightmapFile::StandardError, path)]
            }
            BakeStep::Show(_) => return Err("a step of the window".to_owned()),
        })
    }
}

impl BakeOption {
    fn set(self, settings: &mut BakeSettings) {
        match self {
            BakeOption::Size(size) => {
                (settings.size, settings.texels_per_metre) = (size, None);
            }
            BakeOption::Density(density) => settings.texels_per_metre = Some(density),
            BakeOption::Error(error) => settings.error = error,
            BakeOption::Light(light) => settings.light = light,
            BakeOption::Sides(sides) => settings.sides = sides,
            BakeOption::Convention(convention) => settings.convention = convention,
        }
    }
}
