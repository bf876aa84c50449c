//! `render --layers`: a picture of many layers, for compositors.

use super::args::LayerName;
use azulejo_formats::picture::cryptomatte;
use azulejo_formats::picture::exr::{ChannelValues, NamedChannel};
use azulejo_render::{Matte, Mattes, MeasuredImage, PictureLayers};
use azulejo_scene::Image;

/// What the file says of its channels.
const COMMENTS: &str = "Linear radiance, W/(sr m2). Z is the distance from the plane through the \
    eye along the viewing direction, in scene units, 1e10 where nothing is seen; N is in world \
    coordinates. objectId, materialId and glyphId count from 1, 0 is none. Z and the ids belong to \
    the middle of the pixel and are not antialiased. direct + indirect is the image before any \
    denoising; error is its standard error.";

/// The requested layers, in the order of [`LayerName::EACH`].
pub fn chosen(names: &[LayerName]) -> Vec<LayerName> {
    let is_chosen = |name: &LayerName| names.contains(name) || names.contains(&LayerName::All);
    LayerName::EACH.into_iter().filter(is_chosen).collect()
}

/// Adds the channels of mattes, and what the file has to say of them.
pub fn add_mattes(
    mattes: &Mattes,
    channels: &mut Vec<NamedChannel>,
    texts: &mut Vec<(String, String)>,
) {
    let Mattes {
        objects,
        assets,
        materials,
    } = mattes;
    for (layer, Matte { names, ranks }) in [
        ("CryptoObject", objects),
        ("CryptoAsset", assets),
        ("CryptoMaterial", materials),
    ] {
        channels.extend(cryptomatte::channels(layer, names, ranks));
        texts.extend(cryptomatte::attributes(layer, names));
    }
}

/// Whether any of the requested layers needs direct light apart from the rest.
pub fn tell_direct_light(names: Option<&[LayerName]>) -> bool {
    let is_apart = |name: &LayerName| matches!(name, LayerName::Direct | LayerName::Indirect);
    names.is_some_and(|names| chosen(names).iter().any(is_apart))
}

/// The words of the file's comments.
pub fn comments(measured: &MeasuredImage, is_clamped: bool) -> String {
    if is_clamped {
        let share = measured.removed;
        return format!("{COMMENTS} A clamp removed the share {share:.3e} of the light.");
    }
    COMMENTS.to_owned()
}

/// The channels of a picture, `image`, and of the requested layers.
pub fn channels(
    image: &Image,
    measured: &MeasuredImage,
    seen: &PictureLayers,
    names: &[LayerName],
) -> Vec<NamedChannel> {
    let mut channels = colors("", "RGB", image);
    for name in chosen(names) {
        channels.extend(match name {
            LayerName::All | LayerName::Cryptomatte => Vec::new(),
            LayerName::Albedo => colors("albedo.", "RGB", &seen.albedo),
            LayerName::Normal => colors("N.", "XYZ", &seen.normal),
            LayerName::Depth => vec![channel("Z", ChannelValues::Float(seen.depth.clone()))],
            LayerName::Object => vec![indices("objectId", &seen.object)],
            LayerName::Material => vec![indices("materialId", &seen.material)],
            LayerName::Glyph => vec![indices("glyphId", &seen.glyph)],
            LayerName::Direct => colors("direct.", "RGB", &measured.direct),
            LayerName::Indirect => colors("indirect.", "RGB", &measured.indirect),
            LayerName::Error => colors("error.", "RGB", &measured.error),
        });
    }
    channels
}

fn channel(name: &str, values: ChannelValues) -> NamedChannel {
    NamedChannel {
        name: name.to_owned(),
        values,
    }
}

fn indices(name: &str, values: &[u32]) -> NamedChannel {
    channel(name, ChannelValues::Index(values.to_vec()))
}

/// The three channels of an image, each by a letter after the layer's name.
fn colors(layer: &str, letters: &str, image: &Image) -> Vec<NamedChannel> {
    let one = |(k, letter): (usize, char)| {
        let values = image.pixels.iter().map(|pixel| pixel[k]).collect();
        channel(&format!("{layer}{letter}"), ChannelValues::Float(values))
    };
    letters.chars().enumerate().map(one).collect()
}
