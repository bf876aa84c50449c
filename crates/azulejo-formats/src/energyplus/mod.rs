//! EnergyPlus, `.idf` and `.epJSON`: the surfaces of a building.
//!
//! Every surface becomes an object of its name whose front faces into its zone, without the openings,
//! which are objects of their own. `docs/formats/energyplus.md` has the details.

mod classes;
mod emissivity;
mod epjson;
mod idf;
mod input;
mod model;
mod openings;
mod place;
mod surfaces;
#[cfg(test)]
mod tests;
mod zones;

use crate::reading::options::check_length;
use crate::reading::text::decoded_text;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};
use input::InputText;

/// Reads a model. `name` is used in messages; EnergyPlus files refer to no others with surfaces.
///
/// # Errors
/// Malformed JSON, coordinates that are not numbers, and surfaces with too many openings.
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let text = decoded_text(bytes);
    let file = InputText { text: &text, name };
    let mut warnings = Warnings::default();
    let objects = if text.trim_start().starts_with('{') {
        epjson::read(file)?
    } else {
        idf::read(file, &mut warnings)?
    };
    let scene = model::build(&objects, file, options, &mut warnings)?;
    if scene.objects.is_empty() && options.keeps {
        warnings.add_whole(name, "no surfaces: the scene is empty");
    }
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}
