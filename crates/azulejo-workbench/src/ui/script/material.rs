//! Steps `material ...`: what the selected material becomes.

use super::fields::{name, number, one_of, path, split, vector};
use super::selected::{material_named, selected, selected_material};
use super::step::{ScriptStep, StepResult, commands};
use crate::app::App;
use crate::command::{Command, Selection};
use crate::document::Edit;
use crate::library::{LIBRARY, slug};
use crate::ui::brdf::with_description;
use crate::ui::giving;
use azulejo::scene::brdf::Description;
use azulejo::scene::{Dielectric, Material, Rgb};

/// Parses what follows `material`.
pub(super) fn parse(text: &str) -> StepResult {
    let (word, rest) = split(text);
    Ok(match word {
        "new" => {
            let white = Material::diffuse(rest, Rgb::grey(0.7));
            commands(|app| {
                let new = app.document.materials.len() as u32;
                let add = Command::Edit(Edit::AddMaterial(white), None);
                Ok([add].into_iter().chain(assign(app, new)?).collect())
            })
        }
        "use" => {
            let name = name("material use", rest)?;
            commands(move |app| assign(app, material_named(app, &name)?))
        }
        "rename" => {
            let name = name("material rename", rest)?;
            changed(|material| material.name = name)
        }
        "brdf" => {
            let text = rest.to_owned();
            commands(move |app| {
                let description: Description = text.parse().map_err(|e| format!("{e}"))?;
                let (id, old) = selected_material(app)?;
                let new = with_description(&old, description).map_err(|e| e.to_string())?;
                Ok(vec![Command::Edit(Edit::SetMaterial(id, new), None)])
            })
        }
        "load" => ScriptStep::LoadBrdf(path("material load", rest)?),
        "color" => {
            let diffuse = Rgb::from(vector(rest)?.to_array());
            reflecting(move |name| Material::diffuse(name, diffuse))
        }
        "mirror" => {
            let mirror = Rgb::from(vector(rest)?.to_array());
            reflecting(move |name| Material::mirror(name, mirror))
        }
        "glass" => {
            let (ior, thin) = match rest.strip_suffix("thin") {
                Some(ior) => (ior.trim(), true),
                None => (rest, false),
            };
            let glass = Dielectric {
                ior: number(ior)?,
                transmittance: Rgb::WHITE,
                thin,
            };
            reflecting(move |name| Material {
                dielectric: Some(glass),
                ..Material::mirror(name, Rgb::WHITE)
            })
        }
        "library" => {
            let entry = &LIBRARY[library_index(rest)?];
            commands(move |app| {
                let (id, _) = selected_material(app)?;
                Ok(giving(app, entry, id, app.preferences.language))
            })
        }
        "emit" => {
            let emission = Rgb::from(vector(rest)?.to_array());
            changed(move |material| material.emission = emission)
        }
        other => {
            return Err(format!(
                "material \"{other}\", expected new, use, rename, brdf, load, color, mirror, glass, \
                 library or emit"
            ));
        }
    })
}

/// A step that changes the selected material.
fn changed(change: impl FnOnce(&mut Material) + 'static) -> ScriptStep {
    commands(|app| {
        let (id, mut material) = selected_material(app)?;
        change(&mut material);
        Ok(vec![Command::Edit(Edit::SetMaterial(id, material), None)])
    })
}

/// A step that makes the selected material another one of its name, which emits what it emitted.
fn reflecting(make: impl FnOnce(String) -> Material + 'static) -> ScriptStep {
    changed(|material| {
        *material = Material {
            emission: material.emission,
            emits_back: material.emits_back,
            ..make(material.name.clone())
        };
    })
}

/// The place of a material of the library by its name.
fn library_index(name: &str) -> Result<usize, String> {
    let places: Vec<usize> = (0..LIBRARY.len()).collect();
    one_of("material of the library", &slug(name), &places, |k| {
        LIBRARY[k].script_name()
    })
}

/// Assigns a material to the selected faces or objects, and selects it.
fn assign(app: &App, material: u32) -> Result<Vec<Command>, String> {
    let selection = &app.selection;
    let edit = match &selection.faces {
        Some((id, faces)) => Edit::AssignFaces(*id, faces.clone(), material),
        None => Edit::Assign(selected(app)?, material),
    };
    let select = Command::Select(Selection {
        material: Some(material),
        ..selection.clone()
    });
    Ok(vec![Command::Edit(edit, None), select])
}
