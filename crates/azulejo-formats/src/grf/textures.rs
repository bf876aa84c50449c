//! Pixels of textures.

use crate::picture::PixelBudget;
use crate::{Files, Loaded, Position, Warning};
use azulejo_scene::Image;

/// Loads the images of a scene's textures that are not loaded yet, in any format of [`picture`](crate::picture),
/// recognized by their content. An image that cannot be read stays without pixels, with a warning
/// under `name`, the model's name in messages.
pub fn load_textures(loaded: &mut Loaded, name: &str, files: &dyn Files) {
    let mut budget = PixelBudget::default();
    for texture in &mut loaded.scene.textures {
        if texture.image.is_some() {
            continue;
        }
        match picture(&texture.path, files, &mut budget) {
            Ok(image) => texture.image = Some(image),
            Err(problem) => loaded.warnings.push(Warning {
                file: name.to_owned(),
                position: Position::Whole,
                message: format!("texture \"{}\" skipped: {problem}", texture.path),
                count: 1,
            }),
        }
    }
}

fn picture(path: &str, files: &dyn Files, budget: &mut PixelBudget) -> Result<Image, String> {
    let bytes = files.read(path).map_err(|e| e.to_string())?;
    budget.decode(&bytes)
}
