//! Steps `material ...`: what the selected material becomes.

use super::fields::{name, number, one_of, path, split, vector};
use super::selected::{material_named, selected, selected_material};
use crate::app::App;
use crate::command::{Command, Selection};
use crate::document::Edit;
use crate::library::{LIBRARY, slug};
use crate::ui::brdf::with_description;
use crate::ui::giving;
use azulejo::scene::brdf::Description;
use azulejo::scene::{Dielectric, Material, Rgb};
use glam::DVec3;
use std::path::PathBuf;

/// What a step `material ...` does.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialStep {
    /// `new NAME`: adds a material and assigns it to the selection.
    New(String),
    /// `use NAME`: assigns an existing material to the selected objects or faces.
    Use(String),
    /// `rename NAME`.
    Rename(String),
    /// `brdf DESCRIPTION`: sets the reflection model.
    Brdf(String),
    /// `load FILE`: loads a reflection model.
    Load(PathBuf),
    /// `color R G B`: makes it diffuse with a linear colour.
    Color(DVec3),
    /// `mirror R G B`: makes it a mirror of this reflectance.
    Mirror(DVec3),
    /// `glass IOR`, `glass IOR thin`: makes it the surface of glass, or a whole pane.
    Glass(f64, bool),
    /// `library NAME`: gives it the reflection of a material of the library.
    Library(usize),
    /// `emit R G B`: sets the emission, W/(sr·m²) or cd/m².
    Emit(DVec3),
}

/// Parses what follows `material`.
pub(super) fn parse(text: &str) -> Result<MaterialStep, String> {
    let (word, rest) = split(text);
    Ok(match word {
        "new" => MaterialStep::New(rest.to_owned()),
        "use" => MaterialStep::Use(name("material use", rest)?),
        "rename" => MaterialStep::Rename(name("material rename", rest)?),
        "brdf" => MaterialStep::Brdf(rest.to_owned()),
        "load" => MaterialStep::Load(path("material load", rest)?),
        "color" => MaterialStep::Color(vector(rest)?),
        "mirror" => MaterialStep::Mirror(vector(rest)?),
        "glass" => {
            let (ior, thin) = match rest.strip_suffix("thin") {
                Some(ior) => (ior.trim(), true),
                None => (rest, false),
            };
            MaterialStep::Glass(number(ior)?, thin)
        }
        "library" => MaterialStep::Library(library_index(rest)?),
        "emit" => MaterialStep::Emit(vector(rest)?),
        other => {
            return Err(format!(
                "material \"{other}\", expected new, use, rename, brdf, load, color, mirror, glass, \
                 library or emit"
            ));
        }
    })
}

/// The place of a material of the library by its name.
fn library_index(name: &str) -> Result<usize, String> {
    let places: Vec<usize> = (0..LIBRARY.len()).collect();
    one_of("material of the library", &slug(name), &places, |k| {
        LIBRARY[k].script_name()
    })
}

impl MaterialStep {
    /// The commands of the step; loading a reflection model is the window's.
    pub(super) fn commands(self, app: &App) -> Result<Vec<Command>, String> {
        let changed = |change: &dyn Fn(&mut Material)| {
            let (id, mut material) = selected_material(app)?;
            change(&mut material);
            Ok(vec![Command::Edit(Edit::SetMaterial(id, material), None)])
        };
        match self {
            MaterialStep::New(name) => {
                let white = Material::diffuse(name, Rgb::grey(0.7));
                let new = app.document.materials.len() as u32;
                let mut commands = vec![Command::Edit(Edit::AddMaterial(white), None)];
                commands.extend(assign(app, new)?);
                Ok(commands)
            }
            MaterialStep::Use(name) => assign(app, material_named(app, &name)?),
            MaterialStep::Rename(name) => changed(&|m| m.name.clone_from(&name)),
            MaterialStep::Brdf(text) => {
                let description: Description = text.parse().map_err(|e| format!("{e}"))?;
                let (id, old) = selected_material(app)?;
                let new = with_description(&old, description).map_err(|e| e.to_string())?;
                Ok(vec![Command::Edit(Edit::SetMaterial(id, new), None)])
            }
            MaterialStep::Load(path) => Err(format!("{} is loaded by the window", path.display())),
            MaterialStep::Color(c) => changed(&|m| {
                let plain = Material::diffuse(m.name.clone(), Rgb::from(c.to_array()));
                replace_reflection(m, plain);
            }),
            MaterialStep::Mirror(c) => changed(&|m| {
                let mut plain = Material::diffuse(m.name.clone(), Rgb::BLACK);
                plain.mirror = Rgb::from(c.to_array());
                replace_reflection(m, plain);
            }),
            MaterialStep::Glass(ior, thin) => changed(&|m| {
                let mut glass = Material::diffuse(m.name.clone(), Rgb::BLACK);
                glass.mirror = Rgb::WHITE;
                glass.dielectric = Some(Dielectric {
                    ior,
                    transmittance: Rgb::WHITE,
                    thin,
                });
                replace_reflection(m, glass);
            }),
            MaterialStep::Library(index) => {
                let (id, _) = selected_material(app)?;
                let entry = LIBRARY
                    .get(index)
                    .ok_or("the library has no such material")?;
                Ok(giving(app, entry, id, app.preferences.language))
            }
            MaterialStep::Emit(c) => changed(&|m| m.emission = Rgb::from(c.to_array())),
        }
    }
}

/// Makes a material another one that emits what it emitted.
fn replace_reflection(material: &mut Material, mut new: Material) {
    new.emission = material.emission;
    new.emits_back = material.emits_back;
    *material = new;
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
