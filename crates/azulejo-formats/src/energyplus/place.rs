//! Coordinates: where zones lie, how they and the building are turned, where lists of vertices begin.

use super::classes::InputClass;
use super::input::{InputObject, InputText, key};
use crate::ReadError;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;

/// The corner that a list of vertices begins with, seen from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum StartingCorner {
    #[default]
    UpperLeft,
    LowerLeft,
    LowerRight,
    UpperRight,
}

/// What `GlobalGeometryRules`, `Building` and the zones say about coordinates.
#[derive(Debug, Default)]
pub(super) struct InputPlaces {
    starting_corner: StartingCorner,
    is_clockwise: bool,
    /// Whether vertices are given in the world's coordinates, and not in those of zones.
    is_world: bool,
    /// The same for corners of rectangles.
    has_world_rectangles: bool,
    /// By how much the building is turned clockwise, degrees.
    building_north: f64,
    zones: HashMap<String, ZonePlace>,
}

#[derive(Clone, Copy, Debug)]
struct ZonePlace {
    /// By how much the zone is turned clockwise in the building, degrees.
    north: f64,
    origin: DVec3,
}

/// What the coordinates of a surface refer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum InputFrame<'k> {
    /// The site, however the building is turned.
    Site,
    Building,
    /// A zone by its key.
    Zone(&'k str),
}

impl InputPlaces {
    /// Collects them from all objects.
    ///
    /// # Errors
    /// Malformed numbers.
    pub fn read(
        objects: &[InputObject<'_>],
        file: InputText<'_>,
    ) -> Result<InputPlaces, ReadError> {
        let mut places = InputPlaces::default();
        for object in objects {
            match object.layout.class {
                InputClass::Rules => places.rules(object),
                InputClass::Building => {
                    places.building_north = object.number_or("north_axis", 0.0, file)?;
                }
                InputClass::Zone => {
                    let number = |field: &str| object.number_or(field, 0.0, file);
                    let zone = ZonePlace {
                        north: number("direction_of_relative_north")?,
                        origin: DVec3::new(
                            number("x_origin")?,
                            number("y_origin")?,
                            number("z_origin")?,
                        ),
                    };
                    places.zones.insert(key(&object.name), zone);
                }
                _ => {}
            }
        }
        Ok(places)
    }

    fn rules(&mut self, object: &InputObject<'_>) {
        self.starting_corner = match object.key("starting_vertex_position").as_str() {
            "lowerleftcorner" | "llc" => StartingCorner::LowerLeft,
            "lowerrightcorner" | "lrc" => StartingCorner::LowerRight,
            "upperrightcorner" | "urc" => StartingCorner::UpperRight,
            _ => StartingCorner::UpperLeft,
        };
        let direction = object.key("vertex_entry_direction");
        self.is_clockwise = matches!(direction.as_str(), "clockwise" | "cw");
        // "World", "WCS", "WorldCoordinateSystem", "Absolute"; all others are relative.
        let is_world = |field: &str| object.key(field).starts_with(['w', 'a']);
        self.is_world = is_world("coordinate_system");
        self.has_world_rectangles = is_world("rectangular_surface_coordinate_system");
    }

    /// Whether a zone is known.
    pub fn has_zone(&self, zone: &str) -> bool {
        self.zones.contains_key(zone)
    }

    /// Vertices as the file lists them, counter-clockwise from outside and in the world.
    pub fn outline(&self, vertices: &[DVec3], frame: InputFrame<'_>) -> Vec<DVec3> {
        let map = if self.is_world {
            DAffine3::IDENTITY
        } else {
            self.world_from(frame)
        };
        let mut corners: Vec<DVec3> = vertices.iter().map(|&p| map.transform_point3(p)).collect();
        if self.is_clockwise && corners.len() > 1 {
            // The first one stays the first.
            corners[1..].reverse();
        }
        corners
    }

    /// The index of the lower left corner of an outline with this number of corners.
    pub fn lower_left(&self, corners: usize) -> usize {
        match self.starting_corner {
            StartingCorner::UpperLeft => 1,
            StartingCorner::LowerLeft => 0,
            StartingCorner::LowerRight => corners.saturating_sub(1),
            StartingCorner::UpperRight => 2,
        }
    }

    /// The corners of a rectangle from the upper left one on, counter-clockwise from outside.
    ///
    /// The corner where it starts is the lower left one; its azimuth is that of its outward normal,
    /// clockwise from north.
    pub fn rectangle(&self, rectangle: &InputRectangle, frame: InputFrame<'_>) -> [DVec3; 4] {
        let (map, turned) = if self.has_world_rectangles {
            (DAffine3::IDENTITY, 0.0)
        } else {
            (self.world_from(frame), self.clockwise(frame))
        };
        let [sin, cos] = sin_cos(rectangle.azimuth + turned);
        let [sin_tilt, cos_tilt] = sin_cos(rectangle.tilt);
        let along = rectangle.length * DVec3::new(-cos, sin, 0.0);
        let up = rectangle.height * DVec3::new(-cos_tilt * sin, -cos_tilt * cos, sin_tilt);
        let start = map.transform_point3(rectangle.start);
        [start + up, start, start + along, start + along + up]
    }

    /// By how much a frame is turned clockwise, degrees.
    fn clockwise(&self, frame: InputFrame<'_>) -> f64 {
        match frame {
            InputFrame::Site => 0.0,
            InputFrame::Building => self.building_north,
            InputFrame::Zone(zone) => {
                let zone = self.zones.get(zone).map_or(0.0, |zone| zone.north);
                self.building_north + zone
            }
        }
    }

    fn world_from(&self, frame: InputFrame<'_>) -> DAffine3 {
        match frame {
            InputFrame::Site => DAffine3::IDENTITY,
            InputFrame::Building => turned(self.building_north),
            InputFrame::Zone(zone) => {
                let building = turned(self.building_north);
                self.zones.get(zone).map_or(building, |zone| {
                    building * DAffine3::from_translation(zone.origin) * turned(zone.north)
                })
            }
        }
    }
}

/// A rectangle by its lower left corner, seen from outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct InputRectangle {
    /// Degrees clockwise from north.
    pub azimuth: f64,
    /// Degrees from up.
    pub tilt: f64,
    pub start: DVec3,
    pub length: f64,
    pub height: f64,
}

/// A turn clockwise seen from above.
fn turned(degrees: f64) -> DAffine3 {
    let [sin, cos] = sin_cos(degrees);
    DAffine3::from_mat3(DMat3::from_cols(
        DVec3::new(cos, -sin, 0.0),
        DVec3::new(sin, cos, 0.0),
        DVec3::Z,
    ))
}

/// Sine and cosine of an angle in degrees, exact for multiples of 90, so that walls of turned buildings
/// remain aligned.
fn sin_cos(degrees: f64) -> [f64; 2] {
    match degrees.rem_euclid(360.0) {
        0.0 => [0.0, 1.0],
        90.0 => [1.0, 0.0],
        180.0 => [0.0, -1.0],
        270.0 => [-1.0, 0.0],
        other => [other.to_radians().sin(), other.to_radians().cos()],
    }
}
