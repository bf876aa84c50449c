//! Units and axes of scenes.

use glam::DVec3;

/// Units and axes of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Units {
    /// Length of one scene unit in metres, > 0; `None` if unknown. One metre is then
    /// assumed.
    pub metres_per_unit: Option<f64>,
    /// The axis that points away from the ground.
    pub up: Up,
    /// Whether light is in cd/m² and lux instead of W/(sr·m²) and W/m². The computation is the same.
    pub photometric: bool,
}

/// The axis that points away from the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// +y, as in most formats for rendering.
    #[default]
    Y,
    /// +z, as in most formats for architecture and manufacturing.
    Z,
}

impl Up {
    /// The unit vector.
    pub fn axis(self) -> DVec3 {
        match self {
            Up::Y => DVec3::Y,
            Up::Z => DVec3::Z,
        }
    }
}

impl Units {
    /// Length of one scene unit in metres; 1 if unknown.
    pub fn metres(&self) -> f64 {
        self.metres_per_unit.unwrap_or(1.0)
    }
}
