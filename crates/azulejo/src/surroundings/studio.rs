//! A studio: a floor and three lamps around a model in which nothing shines.

use azulejo_scene::math::{Aabb, Frame};
use azulejo_scene::{Camera, Material, Mesh, Object, Primitive, Rgb, Scene, Shape, Units};
use glam::DVec3;

/// A lamp of a photographer's studio, by where it stands as seen from the middle of the model.
struct StudioLamp {
    name: &'static str,
    /// Degrees to the right of the viewer's direction toward the model, seen from above.
    azimuth: f64,
    /// Degrees above the horizon.
    elevation: f64,
    /// Edge of the square lamp, relative to the size of the model.
    size: f64,
    /// Radiance.
    radiance: Rgb,
}

/// Key, fill and rim light: from the left and above, weaker and larger from the right, and from
/// behind. Their colours are those of lamps, not quite white.
const LAMPS: [StudioLamp; 3] = [
    StudioLamp {
        name: "key light",
        azimuth: -40.0,
        elevation: 45.0,
        size: 0.9,
        radiance: Rgb::new(22.0, 21.0, 19.5),
    },
    StudioLamp {
        name: "fill light",
        azimuth: 60.0,
        elevation: 25.0,
        size: 1.4,
        radiance: Rgb::new(3.8, 4.1, 4.5),
    },
    StudioLamp {
        name: "rim light",
        azimuth: 160.0,
        elevation: 50.0,
        size: 0.7,
        radiance: Rgb::new(13.0, 13.0, 13.5),
    },
];

/// Distance of the lamps from the middle of the model, relative to its size.
const DISTANCE: f64 = 2.2;

/// Half of the edge of the floor, relative to the size of the model.
const FLOOR: f64 = 6.0;

/// Faces along each edge of the floor.
const FLOOR_CELLS: u32 = 64;

/// How much smaller faces are in the middle of the floor than at its edges: the power to which
/// their places are raised.
const GRADING: f64 = 2.0;

/// Gap between the model and the floor, relative to the size of the model: faces that lie on it
/// would flicker.
const GAP: f64 = 1e-4;

/// A studio around a model of these bounds: the floor, the lamps, and the camera `studio`, which
/// sees the model. `None` around a model without extent. Everything else of the scene is default.
pub fn studio(bounds: Aabb, units: Units) -> Option<Scene> {
    let size = bounds.diagonal();
    if bounds.is_empty() || size <= 0.0 || !size.is_finite() {
        return None;
    }
    let up = units.up.axis();
    // A room's light in lux, so that the numbers of photometric scenes are everyday ones.
    let brightness = if units.photometric { 100.0 } else { 1.0 };
    let centre = bounds.centre();
    let bottom = bounds.min.dot(up) - GAP * size;
    let ground = centre + up * (bottom - centre.dot(up));
    // The view of the model alone, as that of all would show the floor for the most part.
    let mut view = Camera::framing(bounds, 1.0, up);
    view.name = "studio".into();
    let viewer = (view.eye - view.target).normalize_or(DVec3::X);
    let mut scene = Scene {
        units,
        cameras: vec![view],
        ..Scene::default()
    };
    let front = (viewer - up * viewer.dot(up)).normalize_or(DVec3::X);
    let right = up.cross(front);
    let floor = scene.add_material(Material::diffuse("studio floor", Rgb::grey(0.5)));
    let half = FLOOR * size;
    let floor = graded_floor(ground, (half * front, half * up.cross(front)), floor);
    scene
        .objects
        .push(Object::new("studio floor", Shape::Mesh(floor)));
    for lamp in &LAMPS {
        let (sin, cos) = lamp.azimuth.to_radians().sin_cos();
        let (high, level) = lamp.elevation.to_radians().sin_cos();
        let toward = level * (cos * front + sin * right) + high * up;
        let material = Material::emitter(lamp.name, lamp.radiance * brightness);
        let material = scene.add_material(material);
        let frame = Frame::from_normal(-toward);
        let edge = lamp.size * size;
        let (x, y) = (edge * frame.x, edge * frame.y);
        let corner = centre + DISTANCE * size * toward - 0.5 * (x + y);
        let lamp = facing_sheet(lamp.name, corner, (x, y), -toward, material);
        scene.objects.push(lamp);
    }
    Some(scene)
}

/// A square with the half edges `x` and `y`, whose front faces x × y, of faces that are small in the
/// middle, where the shadows fall.
fn graded_floor(centre: DVec3, (x, y): (DVec3, DVec3), material: u32) -> Mesh {
    let place = |k: u32| {
        let t = 2.0 * f64::from(k) / f64::from(FLOOR_CELLS) - 1.0;
        t.abs().powf(GRADING).copysign(t)
    };
    let row = FLOOR_CELLS + 1;
    let point = |k: u32| centre + place(k % row) * x + place(k / row) * y;
    let mut floor = Mesh {
        positions: (0..row * row).map(point).collect(),
        ..Mesh::default()
    };
    for cell in 0..FLOOR_CELLS * FLOOR_CELLS {
        let first = cell % FLOOR_CELLS + cell / FLOOR_CELLS * row;
        floor.push_face(&[first, first + 1, first + row + 1, first + row], material);
    }
    floor
}

/// A parallelogram that faces `toward`.
fn facing_sheet(
    name: &str,
    corner: DVec3,
    (x, y): (DVec3, DVec3),
    toward: DVec3,
    material: u32,
) -> Object {
    let (x, y) = if x.cross(y).dot(toward) > 0.0 {
        (x, y)
    } else {
        (y, x)
    };
    let sheet = Primitive::parallelogram(corner, x, y, material);
    Object::new(name, Shape::Primitive(sheet))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_studio_is_below_and_around_the_model() {
        let bounds = Aabb::around([DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)]);
        let scene = studio(bounds, Units::default()).unwrap();
        scene.validate().unwrap();
        assert!(scene.has_light() && scene.cameras.len() == 1);
        let floor = scene.objects[0].bounds();
        assert!(floor.max.y < bounds.min.y && floor.size().x > 10.0);
        for lamp in &scene.objects[1..] {
            assert!(lamp.bounds().min.y > bounds.min.y, "{}", lamp.name);
        }
        assert_eq!(studio(Aabb::EMPTY, Units::default()), None);
    }
}
