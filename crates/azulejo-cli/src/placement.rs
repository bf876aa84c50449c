//! `--place FILE:translate=1,0,2,rotate=0,90,0,scale=2`: the placement of a model.

use super::surroundings::args::{Site, site};
use super::values;
use azulejo::luminaire::PlacedLuminaire;
use azulejo_scene::Up;
use azulejo_scene::math::Aabb;
use glam::{DAffine3, DMat3, DVec3};
use std::path::Path;

/// The placement of a model, with overrides of its axis, unit and name.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// The file as given on the command line.
    pub file: String,
    /// The steps in order, in the scene's axes and unit.
    pub steps: Vec<PlacementStep>,
    /// Its up axis, overriding that of the file or format.
    pub up: Option<Up>,
    /// Its unit in metres, overriding that of the file.
    pub unit: Option<f64>,
    /// The name of its branch.
    pub name: Option<String>,
}

/// One step of a placement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlacementStep {
    /// An affine map.
    Map(DAffine3),
    /// Scales to this largest side, and stands the model on the origin.
    Fit(f64),
}

impl Placement {
    /// The map of all steps, for a model with `bounds` in a scene with the up axis `up`.
    pub fn scene_from_model(&self, bounds: Aabb, up: Up) -> DAffine3 {
        let mut map = DAffine3::IDENTITY;
        for step in &self.steps {
            let next = match *step {
                PlacementStep::Map(next) => next,
                PlacementStep::Fit(side) => fit(mapped(bounds, &map), side, up),
            };
            map = next * map;
        }
        map
    }

    /// Whether it applies to the file at `path`, by its path or its name.
    pub fn is_about(&self, path: &Path) -> bool {
        Path::new(&self.file) == path || path.file_name().is_some_and(|n| n == &*self.file)
    }
}

/// The value of `--place`.
#[derive(Clone, Debug, PartialEq)]
pub enum PlaceArg {
    /// A model in the scene.
    Model(Placement),
    /// The scene on Earth.
    Site(Site),
}

/// Parses `FILE:key=value,...` or `LAT,LON`.
pub fn place(text: &str) -> Result<PlaceArg, String> {
    match site(text) {
        Some(site) => site.map(PlaceArg::Site),
        None => parse(text).map(PlaceArg::Model),
    }
}

/// Parses `FILE@X,Y,Z[,TILT,ROTATE,SPIN][,lm=..][,cct=..][,set=..]`. The file name may contain `@`.
pub fn luminaire(text: &str) -> Result<PlacedLuminaire, String> {
    let expected = "expected FILE@X,Y,Z, as in downlight.ies@2,1.5,2.8";
    let (file, place) = text.rsplit_once('@').ok_or(expected)?;
    let mut lamp = PlacedLuminaire::of(file);
    let mut numbers = Vec::new();
    for piece in place.split(',') {
        match piece.split_once('=') {
            None => numbers.push(values::number(piece.trim())?),
            Some(("lm", value)) => lamp.lumens = Some(values::number(value)?),
            Some(("cct", value)) => lamp.temperature = Some(values::number(value)?),
            Some(("set", value)) => {
                let set = value
                    .parse()
                    .map_err(|_| format!("\"{value}\" is no lamp set, expected 1, 2, ..."))?;
                lamp.lamp_set = Some(set);
            }
            Some((key, _)) => return Err(format!("unknown \"{key}\", expected lm, cct or set")),
        }
    }
    let (position, angles) = numbers.split_at_checked(3).ok_or(expected)?;
    lamp.position = DVec3::from_slice(position);
    match *angles {
        [] => {}
        [tilt] => lamp.tilt = tilt,
        [tilt, rotation] => (lamp.tilt, lamp.rotation) = (tilt, rotation),
        [tilt, rotation, spin] => {
            (lamp.tilt, lamp.rotation, lamp.spin) = (tilt, rotation, spin);
        }
        _ => {
            return Err(format!(
                "{} numbers, expected X,Y,Z,TILT,ROTATE,SPIN",
                numbers.len()
            ));
        }
    }
    Ok(lamp)
}

/// Parses `FILE:key=value,...`. A value extends over commas to the next key; the file name may
/// contain colons.
pub fn parse(text: &str) -> Result<Placement, String> {
    let (file, how) = KEYS
        .iter()
        .filter_map(|key| text.find(&format!(":{key}=")))
        .min()
        .map(|at| (&text[..at], &text[at + 1..]))
        .ok_or_else(|| {
            format!(
                "expected FILE:{}=..., as in chair.obj:translate=1,0,2",
                KEYS[0]
            )
        })?;
    let mut placement = Placement {
        file: file.to_owned(),
        steps: Vec::new(),
        up: None,
        unit: None,
        name: None,
    };
    for (key, value) in entries(how)? {
        placement.set(key, &value)?;
    }
    Ok(placement)
}

/// The keys with which entries start.
const KEYS: [&str; 7] = ["translate", "rotate", "scale", "fit", "up", "unit", "name"];

/// The keys with their values, which may contain commas.
fn entries(how: &str) -> Result<Vec<(&str, String)>, String> {
    let mut entries: Vec<(&str, String)> = Vec::new();
    for piece in how.split(',') {
        match (piece.split_once('='), entries.last_mut()) {
            (Some((key, value)), _) => entries.push((key.trim(), value.trim().to_owned())),
            (None, Some((_, value))) => {
                value.push(',');
                value.push_str(piece.trim());
            }
            (None, None) => return Err(format!("\"{piece}\" has no key")),
        }
    }
    Ok(entries)
}

impl Placement {
    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        let step = match key {
            "translate" => PlacementStep::Map(DAffine3::from_translation(values::vector(value)?)),
            "rotate" => PlacementStep::Map(DAffine3::from_mat3(rotation(values::vector(value)?))),
            "scale" => PlacementStep::Map(DAffine3::from_scale(scale(value)?)),
            "fit" => match values::not_negative(value)? {
                0.0 => return Err("fit is 0, expected more than 0".into()),
                side => PlacementStep::Fit(side),
            },
            "up" => {
                self.up = Some(values::axis(value)?);
                return Ok(());
            }
            "unit" => {
                self.unit = Some(values::unit(value)?);
                return Ok(());
            }
            "name" => {
                self.name = Some(value.to_owned());
                return Ok(());
            }
            other => return Err(format!("unknown \"{other}\", expected {}", KEYS.join(", "))),
        };
        self.steps.push(step);
        Ok(())
    }
}

/// The bounds of a box under a map.
fn mapped(bounds: Aabb, map: &DAffine3) -> Aabb {
    if bounds.is_empty() {
        return bounds;
    }
    let end = |high: bool| if high { bounds.max } else { bounds.min };
    let corner = |k: u32| {
        let [x, y, z] = [k & 1 != 0, k & 2 != 0, k & 4 != 0].map(end);
        map.transform_point3(DVec3::new(x.x, y.y, z.z))
    };
    Aabb::around((0..8).map(corner))
}

/// Scales a box to a largest side and moves the centre of its base to the origin.
fn fit(bounds: Aabb, side: f64, up: Up) -> DAffine3 {
    let largest = bounds.size().max_element();
    if bounds.is_empty() || largest <= 0.0 {
        return DAffine3::IDENTITY;
    }
    let up = up.axis();
    let ground = bounds.centre() - up * (0.5 * bounds.size().dot(up));
    let scale = DAffine3::from_scale(DVec3::splat(side / largest));
    scale * DAffine3::from_translation(-ground)
}

/// Rotations about x, then y, then z, in degrees, as GRF's `rotation`.
fn rotation(degrees: DVec3) -> DMat3 {
    let [x, y, z] = degrees.to_array().map(f64::to_radians);
    DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x)
}

fn scale(value: &str) -> Result<DVec3, String> {
    let factors = match values::number(value) {
        Ok(factor) => DVec3::splat(factor),
        Err(_) => values::vector(value)?,
    };
    if factors.to_array().contains(&0.0) {
        Err("scale is 0, expected another number".into())
    } else {
        Ok(factors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_applied_in_order() {
        let place = parse("a:b.obj:scale=2,rotate=0,0,90,translate=1,0,0").unwrap();
        assert_eq!(place.file, "a:b.obj");
        let map = place.scene_from_model(Aabb::EMPTY, Up::Y);
        let moved = map.transform_point3(DVec3::X);
        assert!(
            (moved - DVec3::new(1.0, 2.0, 0.0)).length() < 1e-15,
            "{moved}"
        );
        let place = parse("a.obj:translate=1,0,0,scale=2,3,4").unwrap();
        let map = place.scene_from_model(Aabb::EMPTY, Up::Y);
        let moved = map.transform_point3(DVec3::ZERO);
        assert_eq!(moved, DVec3::new(2.0, 0.0, 0.0));
    }

    #[test]
    fn models_fit() {
        let place = parse("a.obj:rotate=90,0,0,fit=2,translate=5,0,0").unwrap();
        let bounds = Aabb::around([DVec3::ZERO, DVec3::new(10.0, 1.0, 20.0)]);
        let placed = mapped(bounds, &place.scene_from_model(bounds, Up::Y));
        assert!(
            (placed.min - DVec3::new(4.5, 0.0, -0.05)).length() < 1e-12,
            "{placed:?}"
        );
        assert!(
            (placed.max - DVec3::new(5.5, 2.0, 0.05)).length() < 1e-12,
            "{placed:?}"
        );
    }

    #[test]
    fn axis_unit_and_name() {
        let place = parse("a.3ds:up=y,unit=cm,name=lamp").unwrap();
        assert_eq!((place.up, place.unit), (Some(Up::Y), Some(0.01)));
        assert_eq!(place.name.as_deref(), Some("lamp"));
        assert!(place.is_about(Path::new("models/a.3ds")));
        assert!(!place.is_about(Path::new("models/b.3ds")));
    }

    #[test]
    fn errors_are_reported() {
        for (text, message) in [
            ("a.obj", "expected FILE:"),
            ("a.obj:move=1,2,3", "expected FILE:"),
            ("a.obj:scale=0", "scale is 0"),
            ("a.obj:fit=0", "fit is 0"),
            ("a.obj:translate=1,2", "2 numbers"),
            ("a.obj:up=x", "not an up axis"),
            ("a.obj:scale=1,turn=3", "unknown \"turn\""),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
