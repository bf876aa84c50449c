//! Recipes: files of rules by the names of materials and objects, and of lights, cameras,
//! background and fog, that are applied to a model each time it is read. `docs/recipes.md` describes
//! the file.
//!
//! ```
//! use azulejo::recipe::Recipe;
//! use azulejo::scene::synthetic::cube_room;
//!
//! let path = std::env::temp_dir().join(format!("azulejo-doc-{}.toml", std::process::id()));
//! std::fs::write(&path, "[[material]]\nname = \"*\"\ndiffuse = 0.25\n\n[[object]]\nname = \"moon\"\nmirror = 1\n")?;
//! let mut room = cube_room();
//! let outcome = Recipe::read(&path)?.apply(&mut room)?;
//! assert!(room.materials.iter().all(|m| m.diffuse.r == 0.25));
//! assert!(outcome.unmatched[0].contains("\"moon\" matches no object"));
//! std::fs::remove_file(path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod additions;
mod beside;
mod rules;
mod surface;
mod tables;

pub use beside::{note_recipes, noted_recipes};

use crate::files::Refused;
use azulejo_scene::Scene;
use std::fmt;
use std::path::Path;
use surface::{RuleTarget, SurfaceRule};
use tables::{RecipeSource, RecipeTables};

/// A recipe that has been read. Two are equal if their files are.
#[derive(Debug)]
pub struct Recipe {
    tables: RecipeTables,
    source: RecipeSource,
}

impl PartialEq for Recipe {
    fn eq(&self, other: &Recipe) -> bool {
        self.source == other.source
    }
}

/// What is worth saying after a recipe has been applied.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecipeOutcome {
    /// The rules that matched nothing, with their places.
    pub unmatched: Vec<String>,
    /// The materials that would have reflected more than arrives, and were scaled down.
    pub limited: Vec<String>,
}

/// Why a recipe could not be read or applied.
#[derive(Debug)]
#[non_exhaustive]
pub enum RecipeError {
    /// The file could not be read or written.
    File(Refused),
    /// What is wrong in it, with file, line and column.
    Content(String),
}

impl fmt::Display for RecipeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RecipeError::File(refused) => refused.fmt(f),
            RecipeError::Content(message) => f.write_str(message),
        }
    }
}

impl std::error::Error for RecipeError {}

impl Recipe {
    /// Reads a recipe.
    ///
    /// # Errors
    /// [`RecipeError`]: no such file, or its content is not a recipe.
    pub fn read(path: &Path) -> Result<Recipe, RecipeError> {
        let (tables, source) = RecipeSource::read(path)?;
        Ok(Recipe { tables, source })
    }

    /// The file it was read from.
    pub fn path(&self) -> &Path {
        &self.source.path
    }

    /// Applies the recipe to a valid scene, which stays valid. Materials and objects keep their
    /// order; what is new comes after them.
    ///
    /// # Errors
    /// [`RecipeError::Content`]: a value out of range, a rule for the materials of a solid. The
    /// scene may then have been changed in part.
    pub fn apply(&self, scene: &mut Scene) -> Result<RecipeOutcome, RecipeError> {
        let mut outcome = RecipeOutcome::default();
        // Materials first: what objects get is a copy of what materials have become.
        for (tables, target) in [
            (&self.tables.material, RuleTarget::Material),
            (&self.tables.object, RuleTarget::Object),
        ] {
            for table in tables {
                let rule = SurfaceRule::new(table, target, &self.source)?;
                let matched = match target {
                    RuleTarget::Material => rules::change_materials(&rule, scene),
                    RuleTarget::Object => rules::change_objects(&rule, scene)?,
                };
                if matched == 0 {
                    outcome.unmatched.push(rule.place(&format!(
                        "the rule {} matches no {}",
                        rule.words,
                        target.word()
                    )));
                }
            }
        }
        additions::add(&self.tables, scene, &self.source)?;
        let file = self.path().display();
        for material in &mut scene.materials {
            if !material.limit_reflectance() {
                outcome.limited.push(format!(
                    "{file}: the material \"{}\" would reflect more than arrives: scaled down",
                    material.name
                ));
            }
        }
        let valid = scene.validate();
        valid.map_err(|e| RecipeError::Content(format!("{file}: not a valid scene: {e}")))?;
        Ok(outcome)
    }
}
