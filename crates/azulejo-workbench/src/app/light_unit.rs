//! The unit in which light is shown: that of the document, or one that converts.

use super::App;
use crate::view::LightUnit;
use azulejo::scene::Rgb;

/// Luminous efficacy of white light by which watts and lumens are converted, lm/W: that of Radiance.
pub const EFFICACY: f64 = 179.0;

/// Names of the units that are shown, and the factor from the numbers of the document to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownUnit {
    /// Factor from the numbers of the document.
    pub factor: f64,
    /// Whether lumens are shown.
    is_photometric: bool,
}

impl ShownUnit {
    /// The unit of the view.
    pub fn of(app: &App) -> ShownUnit {
        let stored = app.document.units.photometric;
        let is_photometric = match app.view.light_unit {
            LightUnit::Document => stored,
            LightUnit::Radiometric => false,
            LightUnit::Photometric => true,
        };
        ShownUnit {
            factor: match (stored, is_photometric) {
                (false, true) => EFFICACY,
                (true, false) => 1.0 / EFFICACY,
                _ => 1.0,
            },
            is_photometric,
        }
    }

    fn name(self, radiometric: &'static str, photometric: &'static str) -> &'static str {
        if self.is_photometric {
            photometric
        } else {
            radiometric
        }
    }

    /// The unit of irradiance or illuminance.
    pub fn irradiance(self) -> &'static str {
        self.name("W/m²", "lx")
    }

    /// The unit of radiance or luminance.
    pub fn radiance(self) -> &'static str {
        self.name("W/(sr·m²)", "cd/m²")
    }

    /// The unit of flux.
    pub fn flux(self) -> &'static str {
        self.name("W", "lm")
    }

    /// A colour in this unit.
    pub fn rgb(self, light: Rgb) -> Rgb {
        light * self.factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn showing_lux_converts_the_numbers_and_keeps_the_document() {
        let mut app = App::quiet();
        let as_stored = ShownUnit::of(&app);
        assert_eq!((as_stored.factor, as_stored.irradiance()), (1.0, "W/m²"));
        app.view.light_unit = LightUnit::Photometric;
        let lux = ShownUnit::of(&app);
        assert_eq!((lux.factor, lux.irradiance()), (179.0, "lx"));
        assert_eq!((lux.radiance(), lux.flux()), ("cd/m²", "lm"));
        assert!(!app.document.units.photometric);
        app.document.units.photometric = true;
        assert_eq!(ShownUnit::of(&app).factor, 1.0);
        app.view.light_unit = LightUnit::Radiometric;
        let watts = ShownUnit::of(&app);
        assert!((watts.factor * 179.0 - 1.0).abs() < 1e-12);
        assert_eq!(watts.rgb(Rgb::grey(179.0)).r, 1.0);
    }
}
