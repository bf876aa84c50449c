//! Recipes: applied to the open document, noted beside its model, and applied again when the model is
//! imported anew.

use super::files::absolute;
use super::{App, Severity};
use crate::document::Edit;
use azulejo::recipe::{Recipe, RecipeError, note_recipes, noted_recipes};
use azulejo::scene::Scene;
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl App {
    pub(super) fn apply_recipe(&mut self, path: PathBuf) {
        self.asking = None;
        match Recipe::read(&absolute(path)) {
            Ok(recipe) => self.edit(&Edit::ApplyRecipe(Arc::new(recipe)), None),
            Err(why) => self.report(Severity::Error, why.to_string()),
        }
    }

    /// Makes the notes beside the models say what the document says. Undo and redo do this, too.
    pub(super) fn update_recipe_notes(&mut self) {
        let mut problems = Vec::new();
        for model in &self.document.source_files {
            let noted = self.noted_recipes.entry(model.path.clone()).or_default();
            if *noted != model.recipes {
                noted.clone_from(&model.recipes);
                problems.extend(note_recipes(&model.path, &model.recipes).err());
            }
        }
        for why in problems {
            self.report(Severity::Warning, why.to_string());
        }
    }
}

/// The recipes of a model, and what is worth saying about them.
#[derive(Default)]
pub(super) struct ImportedRecipes {
    /// Their files, whether they could be applied or not.
    pub recipes: Vec<PathBuf>,
    /// Those that were applied.
    pub notes: Vec<String>,
    /// What was wrong with them.
    pub warnings: Vec<String>,
}

impl ImportedRecipes {
    /// Applies the recipes that are noted beside a model to what was read of it. One that fails
    /// leaves the scene as the others made it.
    pub fn apply(model: &Path, scene: &mut Scene) -> ImportedRecipes {
        let mut imported = ImportedRecipes::default();
        match noted_recipes(model) {
            Ok(recipes) => imported.recipes = recipes,
            Err(why) => imported.warnings.push(why.to_string()),
        }
        for path in imported.recipes.clone() {
            match imported.apply_one(&path, scene) {
                Ok(()) => imported.notes.push(path.display().to_string()),
                Err(why) => imported.warnings.push(why.to_string()),
            }
        }
        imported
    }

    fn apply_one(&mut self, path: &Path, scene: &mut Scene) -> Result<(), RecipeError> {
        let recipe = Recipe::read(path)?;
        let mut enriched = scene.clone();
        let outcome = recipe.apply(&mut enriched)?;
        *scene = enriched;
        self.warnings.extend(outcome.limited);
        self.warnings.extend(outcome.unmatched);
        Ok(())
    }
}
