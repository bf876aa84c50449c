//! The note beside a model that says which recipes belong to it.
//!
//! `room.obj` has its note in `room.obj.recipes.toml`, one key: `recipes`, a list of files. Paths
//! within the model's folder are relative to it, so that folder can be moved as a whole.

use super::RecipeError;
use crate::files::Refused;
use crate::output::{Output, OutputError};
use azulejo_formats::disk as fs;
use azulejo_trace::Progress;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

const REMARK: &str = "# Recipes that azulejo's workbench applies when it reads this model.\n";

#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RecipeNote {
    recipes: Vec<PathBuf>,
}

/// The file of the note of a model.
fn note_path(model: &Path) -> PathBuf {
    let mut name = model.file_name().unwrap_or_default().to_owned();
    name.push(".recipes.toml");
    model.with_file_name(name)
}

/// The recipes that are noted beside a model, in the order of their application; none without a
/// note.
///
/// # Errors
/// [`RecipeError`]: the note cannot be read, or is not one.
pub fn noted_recipes(model: &Path) -> Result<Vec<PathBuf>, RecipeError> {
    let path = note_path(model);
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(refused("read", path, error)),
    };
    let note: RecipeNote = toml::from_str(&text).map_err(|e| {
        let message = e.message().trim_end();
        RecipeError::Content(format!("{}: {message}", path.display()))
    })?;
    let folder = model.parent().unwrap_or(Path::new(""));
    Ok(note.recipes.iter().map(|r| folder.join(r)).collect())
}

/// Notes beside a model which recipes belong to it. Without any, the note is removed.
///
/// # Errors
/// [`RecipeError::File`]: the folder may not be written, or a path is not Unicode.
pub fn note_recipes(model: &Path, recipes: &[PathBuf]) -> Result<(), RecipeError> {
    let path = note_path(model);
    if recipes.is_empty() {
        return match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(refused("remove", path, error))
            }
            _ => Ok(()),
        };
    }
    let folder = model.parent().unwrap_or(Path::new(""));
    let relative = |recipe: &PathBuf| recipe.strip_prefix(folder).unwrap_or(recipe).to_owned();
    let note = RecipeNote {
        recipes: recipes.iter().map(relative).collect(),
    };
    let text = toml::to_string(&note)
        .map_err(|e| refused("write", path.clone(), io::Error::other(e.to_string())))?;
    let output = Output::check(&path).map_err(not_written)?;
    let text = format!("{REMARK}{text}");
    let written = output.write(&Progress::new(), |file| file.write_all(text.as_bytes()));
    written.map_err(not_written)
}

fn refused(deed: &'static str, path: PathBuf, error: io::Error) -> RecipeError {
    RecipeError::File(Refused { deed, path, error })
}

fn not_written(error: OutputError) -> RecipeError {
    match error {
        OutputError::File(refused) => RecipeError::File(refused),
        other => RecipeError::Content(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recipes_are_noted_beside_the_model_and_found_again() {
        let folder = std::env::temp_dir().join(format!("azulejo-note-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let model = folder.join("room.obj");
        assert_eq!(noted_recipes(&model).unwrap(), [] as [PathBuf; 0]);
        let recipes = [
            folder.join("studio.toml"),
            PathBuf::from("/else/where.toml"),
        ];
        note_recipes(&model, &recipes).unwrap();
        let text = fs::read_to_string(folder.join("room.obj.recipes.toml")).unwrap();
        assert!(text.contains("\"studio.toml\""), "{text}");
        assert_eq!(noted_recipes(&model).unwrap(), recipes);
        note_recipes(&model, &[]).unwrap();
        note_recipes(&model, &[]).unwrap();
        assert_eq!(noted_recipes(&model).unwrap(), [] as [PathBuf; 0]);
        fs::write(folder.join("room.obj.recipes.toml"), "recipes = 3").unwrap();
        let message = noted_recipes(&model).unwrap_err().to_string();
        assert!(message.contains("room.obj.recipes.toml: "), "{message}");
        fs::remove_dir_all(folder).unwrap();
    }
}
