//! Surfaces and their openings as polygons in the world.

use super::classes::InputClass;
use super::input::{InputObject, InputText, key};
use super::place::{InputFrame, InputPlaces, InputRectangle};
use crate::ReadError;
use crate::reading::warnings::Warnings;
use azulejo_scene::math::area_vector;
use glam::DVec3;
use std::collections::HashMap;

/// A surface of a zone, or one that shades.
#[derive(Debug)]
pub(super) struct ZoneSurface<'o> {
    pub object: &'o InputObject<'o>,
    /// Counter-clockwise from outside.
    pub corners: Vec<DVec3>,
    /// Which of them is the lower left one.
    lower_left: usize,
    /// The key of its zone.
    zone: String,
    pub openings: Vec<SurfaceOpening<'o>>,
}

/// A window or a door.
#[derive(Debug)]
pub(super) struct SurfaceOpening<'o> {
    pub object: &'o InputObject<'o>,
    /// Counter-clockwise from outside.
    pub corners: Vec<DVec3>,
}

/// All surfaces of a file.
#[derive(Debug, Default)]
pub(super) struct InputSurfaces<'o> {
    pub list: Vec<ZoneSurface<'o>>,
    /// Openings whose surface is not in the file.
    pub orphans: Vec<SurfaceOpening<'o>>,
    /// Numbers of surfaces by their keys.
    pub numbers: HashMap<String, usize>,
}

/// Sine of the slope beyond which a roof faces down, or a floor up: ten degrees from upright.
const TURNED: f64 = 0.17;

impl ZoneSurface<'_> {
    /// Whether it only shades.
    pub fn is_shading(&self) -> bool {
        !matches!(
            self.object.layout.class,
            InputClass::Detailed | InputClass::Rectangle
        )
    }

    /// The lower left corner with the directions to the right and up, seen from outside.
    fn base(&self) -> (DVec3, DVec3, DVec3) {
        let count = self.corners.len();
        let start = self.corners[self.lower_left % count];
        let normal = area_vector(&self.corners).normalize_or_zero();
        let level = DVec3::Z.cross(normal);
        let right = if level.length() > 1e-6 {
            level.normalize()
        } else {
            (self.corners[(self.lower_left + 1) % count] - start).normalize_or_zero()
        };
        (start, right, normal.cross(right))
    }
}

impl<'o> InputSurfaces<'o> {
    /// Collects the surfaces, and then their openings.
    ///
    /// # Errors
    /// Numbers that are missing or none.
    pub fn read(
        objects: &'o [InputObject<'o>],
        places: &InputPlaces,
        file: InputText<'_>,
        warnings: &mut Warnings,
    ) -> Result<InputSurfaces<'o>, ReadError> {
        let mut surfaces = InputSurfaces::default();
        let mut reader = SurfaceReader {
            places,
            file,
            warnings,
        };
        // Shading of zones refers to surfaces, which may follow.
        for is_first in [true, false] {
            for object in objects {
                let is_late = object.layout.class == InputClass::ZoneShading;
                if is_first == is_late {
                    continue;
                }
                if let Some(surface) = reader.surface(object, &surfaces)? {
                    let number = surfaces.list.len();
                    surfaces.numbers.entry(key(&object.name)).or_insert(number);
                    surfaces.list.push(surface);
                }
            }
        }
        for object in objects {
            reader.opening(object, &mut surfaces)?;
        }
        Ok(surfaces)
    }

    /// The surface that a field names.
    fn named(&self, name: &str) -> Option<usize> {
        self.numbers.get(&key(name)).copied()
    }
}

struct SurfaceReader<'a, 'w> {
    places: &'a InputPlaces,
    file: InputText<'a>,
    warnings: &'w mut Warnings,
}

impl SurfaceReader<'_, '_> {
    fn warn(&mut self, object: &InputObject<'_>, message: &str) {
        self.file.warn(self.warnings, object.at, message);
    }

    /// The surface that an object is; `None` for other classes and what must be skipped.
    fn surface<'o>(
        &mut self,
        object: &'o InputObject<'o>,
        known: &InputSurfaces<'o>,
    ) -> Result<Option<ZoneSurface<'o>>, ReadError> {
        // The class tells whether coordinates are relative to the site, the building or a zone.
        let zone = self.zone(object, known);
        let frame = match object.layout.class {
            InputClass::SiteShading => InputFrame::Site,
            InputClass::BuildingShading => InputFrame::Building,
            InputClass::RectangularShading if object.layout.surface_type == "Site" => {
                InputFrame::Site
            }
            InputClass::RectangularShading => InputFrame::Building,
            InputClass::Detailed | InputClass::Rectangle | InputClass::ZoneShading => {
                InputFrame::Zone(&zone)
            }
            InputClass::Skipped(message) => {
                self.warn(object, message);
                return Ok(None);
            }
            _ => return Ok(None),
        };
        // Outlines begin at the corner that the file's rules name, rectangles at the upper left one.
        let (mut corners, mut lower_left) = if object.layout.has_vertices() {
            let corners = self.places.outline(&object.vertices, frame);
            let lower_left = self.places.lower_left(corners.len());
            (corners, lower_left)
        } else {
            let rectangle = self.rectangle(object)?;
            (self.places.rectangle(&rectangle, frame).to_vec(), 1)
        };
        if !self.is_polygon(object, &corners) {
            return Ok(None);
        }
        // EnergyPlus corrects roofs and floors that are upside down, too.
        if faces_the_wrong_way(object, &corners) {
            self.warn(
                object,
                "roof that faces down, or floor that faces up: turned",
            );
            corners.reverse();
            // What was the lower right corner is the lower left one from the other side.
            let count = corners.len();
            lower_left = (2 * count - 2 - lower_left % count) % count;
        }
        Ok(Some(ZoneSurface {
            object,
            corners,
            lower_left,
            zone,
            openings: Vec::new(),
        }))
    }

    /// The key of the zone of a surface.
    fn zone(&mut self, object: &InputObject<'_>, known: &InputSurfaces<'_>) -> String {
        match object.layout.class {
            InputClass::Detailed | InputClass::Rectangle => {
                let zone = object.key("zone_name");
                if !self.places.has_zone(&zone) {
                    self.warn(object, "surface of a zone that is not in the file");
                }
                zone
            }
            InputClass::ZoneShading => {
                let base = known.named(object.text("base_surface_name"));
                if base.is_none() {
                    self.warn(object, "shading of a surface that is not in the file");
                }
                base.map_or(String::new(), |base| known.list[base].zone.clone())
            }
            _ => String::new(),
        }
    }

    fn rectangle(&self, object: &InputObject<'_>) -> Result<InputRectangle, ReadError> {
        let number = |field: &str| object.number(field, self.file);
        let (azimuth, tilt) = match object.layout.surface_type {
            "Floor" => (0.0, 180.0),
            "Roof" | "Ceiling" => (0.0, 0.0),
            _ => (0.0, 90.0),
        };
        let second = object.layout.field("width").unwrap_or("height");
        Ok(InputRectangle {
            azimuth: object.number_or("azimuth_angle", azimuth, self.file)?,
            tilt: object.number_or("tilt_angle", tilt, self.file)?,
            start: DVec3::new(
                object.number_or("starting_x_coordinate", 0.0, self.file)?,
                object.number_or("starting_y_coordinate", 0.0, self.file)?,
                object.number_or("starting_z_coordinate", 0.0, self.file)?,
            ),
            length: number("length")?,
            height: number(second)?,
        })
    }

    /// Whether corners make a surface; if not, it is skipped.
    fn is_polygon(&mut self, object: &InputObject<'_>, corners: &[DVec3]) -> bool {
        if corners.len() < 3 {
            self.warn(object, "surface of fewer than three vertices: skipped");
            return false;
        }
        // Areas and lengths of what is read must be finite, too.
        let limit = 1e100;
        if !corners.iter().all(|p| p.abs().max_element() < limit) {
            self.warn(object, "surface of vertices that are too large: skipped");
            return false;
        }
        true
    }

    /// Adds an opening to its surface.
    fn opening<'o>(
        &mut self,
        object: &'o InputObject<'o>,
        surfaces: &mut InputSurfaces<'o>,
    ) -> Result<(), ReadError> {
        let class = object.layout.class;
        let is_rectangle = class == InputClass::RectangularOpening;
        if class != InputClass::Opening && !is_rectangle {
            return Ok(());
        }
        // Frames and multipliers do not change the polygon.
        let base = surfaces.named(object.text("building_surface_name"));
        if !object.text("frame_and_divider_name").is_empty() {
            self.warn(object, "frame of an opening: part of its surface");
        }
        if object.number_or("multiplier", 1.0, self.file)? != 1.0 {
            self.warn(object, "opening with a multiplier: one is read");
        }
        // A rectangle is placed on its surface, which must be known; an outline stands for itself.
        let corners = match base.map(|base| &surfaces.list[base]) {
            None if is_rectangle => {
                self.warn(
                    object,
                    "opening on a surface that is not in the file: skipped",
                );
                return Ok(());
            }
            Some(base) if is_rectangle => self.on_surface(object, base)?,
            base => {
                let zone = base.map_or("", |base| &base.zone);
                let frame = InputFrame::Zone(zone);
                self.places.outline(&object.vertices, frame)
            }
        };
        if !self.is_polygon(object, &corners) {
            return Ok(());
        }
        let opening = SurfaceOpening { object, corners };
        // An opening whose surface is missing is kept by itself.
        match base {
            Some(base) => surfaces.list[base].openings.push(opening),
            None => {
                self.warn(
                    object,
                    "opening of a surface that is not in the file: in no surface",
                );
                surfaces.orphans.push(opening);
            }
        }
        Ok(())
    }

    /// The corners of an opening given on its surface.
    fn on_surface(
        &self,
        object: &InputObject<'_>,
        surface: &ZoneSurface<'_>,
    ) -> Result<Vec<DVec3>, ReadError> {
        let number = |field: &str| object.number(field, self.file);
        let (start, right, up) = surface.base();
        let x = object.number_or("starting_x_coordinate", 0.0, self.file)?;
        let z = object.number_or("starting_z_coordinate", 0.0, self.file)?;
        let start = start + x * right + z * up;
        let (right, up) = (number("length")? * right, number("height")? * up);
        Ok(vec![start + up, start, start + right, start + right + up])
    }
}

/// Whether a roof faces down or a floor up: EnergyPlus turns such surfaces, too.
fn faces_the_wrong_way(object: &InputObject<'_>, corners: &[DVec3]) -> bool {
    let kind = match object.layout.surface_type {
        "" => object.key("surface_type"),
        known => key(known),
    };
    let upward = area_vector(corners).normalize_or_zero().z;
    match kind.as_str() {
        "floor" => upward > TURNED,
        "roof" | "ceiling" => upward < -TURNED,
        _ => false,
    }
}
