//! Cameras and point lights from a small JSON file, for models whose format has neither.
//!
//! ```json
//! { "camera": { "eye": [0, 1, 5], "target": [0, 1, 0], "up": [0, 1, 0],
//!               "vfov_deg": 40, "width": 640, "height": 480 },
//!   "point_lights": [ { "position": [0, 2, 0], "intensity": [10, 10, 10] } ] }
//! ```
//!
//! `up` may be missing (default: y), and so may `width` and `height`. Everything else in the file
//! is ignored, so that it may hold notes and other programs' data.

use crate::ReadError;
use crate::reading::text::decoded;
use azulejo_scene::{Camera, Light, LightKind, Rgb};
use glam::DVec3;
use serde_json::Value;

/// Reads the camera of the file; `name` is used in messages.
///
/// # Errors
/// Malformed JSON, no `camera`, a field that is missing or not a number, or a camera without a
/// valid view: `eye` = `target`, `up` along the view direction, a field of view outside
/// 0..180 degrees.
pub fn read(bytes: &[u8], name: &str) -> Result<Camera, ReadError> {
    let file = File::parse(bytes, name)?;
    let camera = file.member(&file.value, "camera")?;
    let up = match camera.get("up") {
        Some(_) => file.vector(camera, "up")?,
        None => DVec3::Y,
    };
    let camera = Camera {
        name: file.value["name"].as_str().unwrap_or_default().to_owned(),
        eye: file.vector(camera, "eye")?,
        target: file.vector(camera, "target")?,
        up,
        vertical_fov: file.number(camera, "vfov_deg")?.to_radians(),
        size: file.size(camera)?,
    };
    let (right, up, forward) = camera.axes();
    if !(right.is_finite() && up.is_finite() && forward.is_finite()) {
        return Err(file.error("eye, target and up that do not span a plane", "a view"));
    }
    if !(camera.vertical_fov > 0.0 && camera.vertical_fov < std::f64::consts::PI) {
        return Err(file.error("a \"vfov_deg\" outside 0..180", "an angle in degrees"));
    }
    Ok(camera)
}

/// Reads the point lights of the file, often none. Intensities are in W/sr.
///
/// # Errors
/// Malformed JSON, a field that is missing or not a number, a negative intensity.
pub fn read_lights(bytes: &[u8], name: &str) -> Result<Vec<Light>, ReadError> {
    let file = File::parse(bytes, name)?;
    let lights = match &file.value["point_lights"] {
        Value::Null => &[],
        Value::Array(lights) => lights.as_slice(),
        _ => return Err(file.error("\"point_lights\" that is not a list", "a list")),
    };
    let light = |value: &Value| {
        let intensity = file.vector(value, "intensity")?;
        if intensity.min_element() < 0.0 {
            return Err(file.error("a negative \"intensity\"", "numbers >= 0"));
        }
        Ok(Light {
            name: value["name"].as_str().unwrap_or_default().to_owned(),
            kind: LightKind::Point {
                position: file.vector(value, "position")?,
                intensity: Rgb::from(intensity.to_array()),
            },
        })
    };
    lights.iter().map(light).collect()
}

/// A parsed file with its name for messages.
struct File<'a> {
    name: &'a str,
    value: Value,
}

impl File<'_> {
    fn parse<'a>(bytes: &[u8], name: &'a str) -> Result<File<'a>, ReadError> {
        let bytes = &*decoded(bytes);
        let value = serde_json::from_slice(bytes).map_err(|e| {
            let (line, column) = (e.line() as u32, e.column() as u32);
            let text = String::from_utf8_lossy(bytes);
            // The message repeats its position at the end.
            let message = e.to_string();
            let why = message.split(" at line ").next().unwrap_or_default();
            let found = format!("malformed JSON ({why})");
            ReadError::at_line(name, &text, line, column.max(1), found, "a JSON file")
        })?;
        Ok(File { name, value })
    }

    fn error(&self, found: impl Into<String>, expected: &str) -> ReadError {
        ReadError::whole(self.name, found, expected)
    }

    fn member<'v>(&self, object: &'v Value, key: &str) -> Result<&'v Value, ReadError> {
        object.get(key).ok_or_else(|| {
            let expected = "{\"camera\": {\"eye\", \"target\", \"vfov_deg\"}, \"point_lights\": [{\"position\", \"intensity\"}]}";
            self.error(format!("no \"{key}\""), expected)
        })
    }

    fn number(&self, object: &Value, key: &str) -> Result<f64, ReadError> {
        let value = self.member(object, key)?;
        value
            .as_f64()
            .ok_or_else(|| self.error(format!("a \"{key}\" that is not a number"), "a number"))
    }

    fn vector(&self, object: &Value, key: &str) -> Result<DVec3, ReadError> {
        let numbers: Option<Vec<f64>> = self
            .member(object, key)?
            .as_array()
            .and_then(|list| list.iter().map(Value::as_f64).collect());
        match numbers.as_deref() {
            Some(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
            _ => Err(self.error(
                format!("a \"{key}\" that is not a list of three numbers"),
                "[x, y, z]",
            )),
        }
    }

    /// Width and height, if both are present.
    fn size(&self, camera: &Value) -> Result<Option<(u32, u32)>, ReadError> {
        if camera.get("width").is_none() && camera.get("height").is_none() {
            return Ok(None);
        }
        let pixels = |key| {
            let count = camera[key].as_u64().and_then(|n| u32::try_from(n).ok());
            count.filter(|n| *n > 0).ok_or_else(|| {
                self.error(format!("no \"{key}\" in whole pixels"), "both, or neither")
            })
        };
        Ok(Some((pixels("width")?, pixels("height")?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = r#"{ "name": "s", "other": [1, {}], "camera": { "eye": [0, 1, 5],
        "target": [0, 1, 0], "up": [0, 1, 0], "vfov_deg": 90, "width": 64, "height": 48 },
        "point_lights": [ { "position": [1, 2, 3], "intensity": [4, 5, 6] } ] }"#;

    #[test]
    fn a_whole_file() {
        let camera = read(WHOLE.as_bytes(), "c.json").unwrap();
        assert_eq!((camera.name.as_str(), camera.size), ("s", Some((64, 48))));
        assert_eq!(camera.eye, DVec3::new(0.0, 1.0, 5.0));
        assert!((camera.vertical_fov - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        let lights = read_lights(WHOLE.as_bytes(), "c.json").unwrap();
        let LightKind::Point {
            position,
            intensity,
        } = lights[0].kind
        else {
            panic!("a point light")
        };
        assert_eq!((position.z, intensity.g), (3.0, 5.0));
    }

    fn check(from: &str, to: &str, expected: &str) {
        let text = WHOLE.replacen(from, to, 1);
        let lights = read_lights(text.as_bytes(), "c.json").map(|_| ());
        let both = read(text.as_bytes(), "c.json").map(|_| ()).and(lights);
        let message = both.map_or_else(|e| e.to_string(), |()| "fine".into());
        assert!(message.starts_with(expected), "{message}");
    }

    #[test]
    fn missing_or_invalid_fields_are_reported() {
        check(r#""up": [0, 1, 0],"#, "", "fine");
        check(r#""width": 64, "height": 48"#, r#""far": 1"#, "fine");
        check("camera", "kamera", "c.json: found no \"camera\"");
        check(
            "[0, 1, 5]",
            "[0, 1]",
            "c.json: found a \"eye\" that is not a list of three",
        );
        check("[0, 1, 5]", "[0, 1, 0]", "c.json: found eye, target and up");
        check("90", "180", "c.json: found a \"vfov_deg\" outside");
        check("64", "0", "c.json: found no \"width\"");
        check("[4, 5", "[-4, 5", "c.json: found a negative");
        check(
            "[0, 1, 5]",
            "[0, 1 5]",
            "c.json:1:59: found malformed JSON (expected `,` or `]`)",
        );
        check("[0, 1, 5]", "[0, 1, 1e999]", "c.json:1:");
    }
}
