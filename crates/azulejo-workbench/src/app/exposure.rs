//! The exposure of the modes that display light.

use super::{App, IrradianceRange};
use crate::view::ModelView;

impl App {
    /// Range of the irradiance that is shown: that of the lightmap, or of vertices.
    pub fn shown_range(&self) -> Option<IrradianceRange> {
        match self.lightmap.shown_in(self.view.shading) {
            Some(shown) => shown.range,
            None => self.lighting.range,
        }
    }

    /// The exposure at which typical irradiance on a grey surface appears as a bright mid-tone; 1
    /// without irradiance.
    pub fn auto_exposure(&self) -> f64 {
        let usual = self.shown_range().map_or(0.0, |r| r.usual);
        if usual > 0.0 {
            0.6 * std::f64::consts::PI / (0.5 * usual)
        } else {
            1.0
        }
    }

    /// The exposure of a view: its own, or the automatic one.
    pub fn exposure(&self, view: &ModelView) -> f64 {
        view.exposure.unwrap_or_else(|| self.auto_exposure())
    }
}
