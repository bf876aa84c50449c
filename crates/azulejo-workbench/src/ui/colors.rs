//! Display colours.

use azulejo::render::srgb_from_linear;
use azulejo::scene::{Material, Rgb};
use egui::{Color32, Ui};

/// The display colour of linear light in 0..=1.
pub fn color(light: Rgb) -> Color32 {
    let byte = |x: f64| (255.0 * srgb_from_linear(x.clamp(0.0, 1.0))).round() as u8;
    Color32::from_rgb(byte(light.r), byte(light.g), byte(light.b))
}

/// One colour for a material: its emission, or else its total reflectance.
pub fn swatch(material: &Material) -> Color32 {
    if material.is_emitter() {
        let most = material.emission.max_channel().max(f64::MIN_POSITIVE);
        return color(material.emission / most);
    }
    color(material.diffuse + material.mirror + material.mean_glossy())
}

/// Line colours for all kinds of colour vision (Okabe and Ito 2008), adapted to the theme.
pub fn lines(ui: &Ui) -> [Color32; 5] {
    let rgb = |[r, g, b]: [u8; 3]| Color32::from_rgb(r, g, b);
    if ui.visuals().dark_mode {
        [
            [86, 180, 233],
            [230, 159, 0],
            [0, 178, 130],
            [219, 141, 182],
            [240, 228, 66],
        ]
    } else {
        [
            [0, 114, 178],
            [213, 94, 0],
            [0, 138, 100],
            [187, 90, 145],
            [176, 117, 0],
        ]
    }
    .map(rgb)
}
