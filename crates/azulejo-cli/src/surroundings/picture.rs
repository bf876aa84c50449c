//! Pictures of the surroundings.

use crate::failure::Failure;
use crate::session::Session;
use azulejo::models::read_bytes;
use azulejo_formats::read_picture;
use azulejo_scene::{Environment, Image, Projection, Scene, Texture, TextureId};
use std::path::Path;

/// Reads a picture of the surroundings, and adds it to the scene's textures.
pub fn environment(
    scene: &mut Scene,
    path: &Path,
    session: &mut Session,
) -> Result<Environment, Failure> {
    let bytes = read_bytes(path)?;
    let name = path.display();
    let is_hdr = bytes.starts_with(b"#?") || bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]);
    if !is_hdr {
        return Err(Failure::Failed(format!(
            "{name}: holds no radiance, expected an .hdr or .exr picture"
        )));
    }
    let mut image = read_picture(&bytes).map_err(|e| Failure::Failed(format!("{name}: {e}")))?;
    let projection = match (image.width, image.height) {
        (width, height) if width == height => Projection::AngularMap,
        (width, height) if width == 2 * height => Projection::Equirectangular,
        (width, height) => {
            return Err(Failure::Failed(format!(
                "{name}: {width} × {height} pixels, expected a picture twice as wide as high \
                 (equirectangular) or a square (angular map)"
            )));
        }
    };
    clean(&mut image, path, session);
    let texture = scene.textures.len() as TextureId;
    scene.textures.push(Texture {
        path: path.to_string_lossy().into_owned(),
        image: Some(image),
        ..Texture::default()
    });
    Ok(Environment::picture(texture, projection, scene.units.up))
}

/// Makes pixels that are no light black, and says how many.
fn clean(image: &mut Image, path: &Path, session: &mut Session) {
    let mut wrong = 0;
    for pixel in &mut image.pixels {
        if !pixel.iter().all(|v| *v >= 0.0 && v.is_finite()) {
            wrong += 1;
            *pixel = pixel.map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 });
        }
    }
    let name = path.display();
    if wrong > 0 {
        session.note(&format!(
            "{name}: {wrong} pixels are negative or not finite: taken as 0"
        ));
    }
    if image.pixels.iter().flatten().all(|&v| v == 0.0) {
        session.note(&format!("{name}: all pixels are black"));
    }
}
