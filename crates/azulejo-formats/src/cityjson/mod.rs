//! CityJSON 1.0, 1.1 and 2.0, `.json`, and CityJSONSeq, `.jsonl`.
//!
//! The surfaces of each city object are divided by their semantic types: those of each type become an
//! object of the scene. `docs/formats/cityjson.md` has the details.

mod appearance;
mod document;
mod geometry;
mod levels;
mod objects;
mod rings;
#[cfg(test)]
mod tests;

use crate::reading::json::{self, Json};
use crate::reading::options::{Budget, check_length};
use crate::reading::text::decoded_text;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};
use appearance::CityMaterials;
use azulejo_scene::{Scene, Units, Up};
use document::{CityDocument, CityFile, CityHeader};
use objects::CityReader;

/// Reads a model. `name` is used in messages; pictures, the only files that CityJSON names, are not read.
///
/// # Errors
/// Malformed JSON, another type of document, coordinates that are not numbers, vertices that do not
/// exist, and more elements than `options` allow.
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let text = decoded_text(bytes);
    let file = CityFile { text: &text, name };
    let values = json::values(&text, name)?;
    let mut reader = CityReader {
        file,
        lod: options.lod,
        warnings: Warnings::default(),
        budget: Budget::new(options),
        materials: CityMaterials::default(),
        scene: Scene::default(),
    };
    documents(&mut reader, &values)?;
    if reader.scene.objects.is_empty() && options.keeps {
        let message = "no surfaces: the scene is empty";
        reader.warnings.add_whole(name, message);
    }
    reader.scene.units = Units {
        metres_per_unit: Some(1.0),
        up: Up::Z,
        ..Units::default()
    };
    Ok(Loaded {
        scene: reader.scene,
        warnings: reader.warnings.finish(name),
    })
}

/// The whole model, or in a sequence the header and then the features.
fn documents<'a>(reader: &mut CityReader<'a>, values: &[Json<'a>]) -> Result<(), ReadError> {
    let header = CityHeader::read(values[0], reader.file, &mut reader.warnings)?;
    for (number, &value) in values.iter().enumerate() {
        let document = match number {
            0 => CityDocument::read(value, &header, reader.file)?,
            _ => CityDocument::feature(value, &header, reader.file)?,
        };
        reader.document(&document, &header)?;
    }
    Ok(())
}
