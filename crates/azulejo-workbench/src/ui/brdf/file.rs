//! Reading and writing files of reflection models.

use azulejo::formats::brdf::{self, text};
use azulejo::formats::{Files, Folder};
use azulejo::scene::brdf::{BrdfError, Content, Description};
use azulejo::scene::{Brdf, Material};
use std::path::Path;
use std::sync::Arc;

/// A reflection model read from a file.
#[derive(Clone, Debug)]
pub struct ModelFile {
    /// Its description; measured data keep the name of the file.
    pub description: Description,
    /// What was skipped or repaired, one text each.
    pub warnings: Vec<String>,
}

/// Parses the bytes of a file at `path`: azulejo's text format, a GRF line, or measured data of
/// MERL or RGL. Files that it refers to are searched beside it.
///
/// # Errors
///
/// What was found and what was expected, with the position.
pub fn apply_file(bytes: &[u8], path: &Path) -> Result<ModelFile, String> {
    let name = path.file_name().unwrap_or(path.as_os_str());
    let files: &dyn Files = &Folder::of_model(path);
    let name = name.to_string_lossy();
    let read = brdf::read(bytes, &name, files).map_err(|error| error.to_string())?;
    let description = match read.content {
        Content::Text(description) => description,
        content => Description::File {
            path: path.to_string_lossy().into_owned(),
            content: Some(Arc::new(content)),
        },
    };
    Ok(ModelFile {
        description,
        warnings: read.warnings.iter().map(ToString::to_string).collect(),
    })
}

/// The material with another reflection model; its name, textures and emission stay.
///
/// # Errors
///
/// Why the description is not a valid model.
pub fn with_description(
    material: &Material,
    description: Description,
) -> Result<Material, BrdfError> {
    let brdf = Brdf::new(description)?;
    Ok(with_brdf(material, Arc::new(brdf)))
}

/// The material with a reflection model that has been built.
pub(super) fn with_brdf(material: &Material, brdf: Arc<Brdf>) -> Material {
    Material {
        emission: material.emission,
        emission_picture: material.emission_picture,
        emits_back: material.emits_back,
        textures: material.textures.clone(),
        opacity: material.opacity,
        relief: material.relief,
        lightmap: material.lightmap,
        ..Material::with_brdf(material.name.clone(), brdf)
    }
}

/// A description in the text format.
///
/// # Errors
///
/// Why it cannot be written in that format.
pub(super) fn saved(description: &Description) -> Result<String, String> {
    let mut bytes = Vec::new();
    text::write(description, &mut bytes).map_err(|error| error.to_string())?;
    String::from_utf8(bytes).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::Rgb;

    #[test]
    fn what_is_saved_is_read_again() {
        for model in azulejo::scene::brdf::MODELS {
            for example in model.examples {
                let description: Description = example.parse().unwrap();
                let text = saved(&description).unwrap();
                let read = apply_file(text.as_bytes(), Path::new("a.brdf")).unwrap();
                assert_eq!(
                    Brdf::new(read.description),
                    Brdf::new(description),
                    "{example}"
                );
            }
        }
    }

    #[test]
    fn bad_files_say_why() {
        let error = apply_file(
            b"begin brdf\n  model wood\nend brdf\n",
            Path::new("x/a.brdf"),
        );
        let error = error.unwrap_err();
        assert!(
            error.contains("a.brdf") && error.contains("wood"),
            "{error}"
        );
    }

    #[test]
    fn a_new_model_leaves_the_rest() {
        let mut old = Material::emitter("lamp", Rgb::grey(3.0));
        old.textures = vec![4];
        let new = with_description(&old, "lewis ks = 1 n = 20".parse().unwrap()).unwrap();
        assert_eq!(
            (new.name.as_str(), new.emission, &new.textures[..]),
            ("lamp", Rgb::grey(3.0), &[4][..])
        );
        assert!(new.brdf.is_some());
        assert!(with_description(&old, "lewis n = -1".parse().unwrap()).is_err());
    }
}
