//! A studio for a model in which nothing shines: a floor and three lamps around it, or a lamp under
//! the ceiling of a room.

use super::Room;
use azulejo_scene::math::{Aabb, Frame};
use azulejo_scene::{Camera, Material, Mesh, Object, Primitive, Rgb, Scene, Shape, Units};
use azulejo_trace::Tracer;
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

/// The name of the floor of a studio.
pub const STUDIO_FLOOR: &str = "studio floor";

/// The name of the lamp of a room.
const CEILING_LIGHT: &str = "ceiling light";

/// Whether an object of this name is a part of a studio, and not of the model in it.
pub fn is_studio_part(name: &str) -> bool {
    name == STUDIO_FLOOR || name == CEILING_LIGHT || LAMPS.iter().any(|lamp| lamp.name == name)
}

/// Distance of the lamps from the middle of the model, relative to its size.
const DISTANCE: f64 = 2.2;

/// Radiance of what is seen beyond the floor: darker than that in the light of the lamps, so that the model
/// stands out, and not black.
const BACKDROP: Rgb = Rgb::new(0.02, 0.022, 0.026);

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

/// Radiance of the lamp of a room: that of a panel, not quite white.
const PANEL: Rgb = Rgb::new(21.0, 20.5, 19.5);

/// Vertical field of view in a room, degrees: wide, as one cannot step back.
const ROOM_VIEW: f64 = 62.0;

/// A room's light in lux, so that the numbers of photometric scenes are everyday ones.
fn brightness(units: Units) -> f64 {
    if units.photometric { 100.0 } else { 1.0 }
}

/// A studio for the scene of this tracer: lamps, a floor unless the model is a [`Room`] or the scene's first camera
/// looks from below it, and the camera `studio`, which sees the model. `None` for a model without extent. Everything else of the
/// scene is default.
pub fn studio(scene: &Scene, tracer: &Tracer) -> Option<Scene> {
    let units = scene.units;
    match Room::find(scene, tracer) {
        Some(room) => Some(in_room(&room, tracer, units)),
        None => around(tracer.bounds(), units, scene.cameras.first()),
    }
}

/// A lamp under the ceiling, and a camera within.
fn in_room(room: &Room, tracer: &Tracer, units: Units) -> Scene {
    let up = units.up.axis();
    let (eye, target) = room.view(tracer, units);
    let mut scene = Scene {
        units,
        cameras: vec![Camera {
            name: "studio".into(),
            eye,
            target,
            up,
            vertical_fov: ROOM_VIEW.to_radians(),
            size: None,
        }],
        ..Scene::default()
    };
    let material = Material::emitter(CEILING_LIGHT, PANEL * brightness(units));
    let material = scene.add_material(material);
    let (centre, edge) = room.lamp;
    let frame = Frame::from_normal(-up);
    let (x, y) = (edge * frame.x, edge * frame.y);
    let corner = centre - 0.5 * (x + y);
    let lamp = facing_sheet(CEILING_LIGHT, corner, (x, y), -up, material);
    scene.objects.push(lamp);
    scene
}

/// A floor below a model of these bounds, unless it would hide it from `viewed_by`, and three lamps around it.
fn around(bounds: Aabb, units: Units, viewed_by: Option<&Camera>) -> Option<Scene> {
    let size = bounds.diagonal();
    if bounds.is_empty() || size <= 0.0 || !size.is_finite() {
        return None;
    }
    let up = units.up.axis();
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
    scene.background = Some((BACKDROP * brightness(units)).into());
    let front = (viewer - up * viewer.dot(up)).normalize_or(DVec3::X);
    let right = up.cross(front);
    if viewed_by.is_none_or(|camera| camera.eye.dot(up) > bottom) {
        let grey = scene.add_material(Material::diffuse(STUDIO_FLOOR, Rgb::grey(0.5)));
        let half = FLOOR * size;
        let floor = graded_floor(ground, (half * front, half * up.cross(front)), grey);
        let floor = Object::new(STUDIO_FLOOR, Shape::Mesh(floor));
        scene.objects.push(floor);
    }
    for lamp in &LAMPS {
        let (sin, cos) = lamp.azimuth.to_radians().sin_cos();
        let (high, level) = lamp.elevation.to_radians().sin_cos();
        let toward = level * (cos * front + sin * right) + high * up;
        let material = Material::emitter(lamp.name, lamp.radiance * brightness(units));
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

    /// The studio of a box of this size.
    fn studio_of(size: DVec3) -> Option<Scene> {
        let mut scene = Scene::default();
        let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
        let map = glam::DAffine3::from_scale(size);
        let cuboid = Primitive::new(azulejo_scene::PrimitiveKind::Cuboid, map, white);
        let shape = Shape::Primitive(cuboid);
        scene.objects.push(Object::new("box", shape));
        studio(&scene, &Tracer::new(&scene))
    }

    #[test]
    fn a_studio_is_below_and_around_the_model() {
        let size = DVec3::new(1.0, 2.0, 3.0);
        let scene = studio_of(size).unwrap();
        scene.validate().unwrap();
        assert!(scene.has_light() && scene.cameras.len() == 1);
        let floor = scene.objects[0].bounds();
        assert!(floor.max.y < 0.0 && floor.size().x > 10.0);
        for lamp in &scene.objects[1..] {
            assert!(lamp.bounds().min.y > 0.0, "{}", lamp.name);
            // Outside of the model, as far as its size.
            let away = (lamp.bounds().centre() - 0.5 * size).length();
            assert!(away > size.length(), "{}", lamp.name);
        }
        assert_eq!(
            studio(&Scene::default(), &Tracer::new(&Scene::default())),
            None
        );
    }

    /// A model that is drawn with another axis up is seen from below.
    #[test]
    fn a_camera_below_the_model_sees_it_without_a_floor() {
        let mut scene = azulejo_scene::synthetic::cube_room();
        scene.materials[0].sidedness = azulejo_scene::Sidedness::Two;
        for (height, objects) in [(3.0, 4), (-3.0, 3)] {
            let mut camera = Camera::framing(scene.bounds(), 1.0, scene.units.up.axis());
            camera.eye += (height - camera.eye.dot(camera.up)) * camera.up;
            scene.cameras = vec![camera];
            let added = studio(&scene, &Tracer::new(&scene)).unwrap();
            assert_eq!(added.objects.len(), objects, "{height}");
        }
    }

    #[test]
    fn the_lamp_of_a_room_hangs_within_it_and_shines_down() {
        let room = azulejo_scene::synthetic::cube_room();
        let scene = studio(&room, &Tracer::new(&room)).unwrap();
        scene.validate().unwrap();
        let [lamp] = &scene.objects[..] else {
            panic!("{} objects", scene.objects.len())
        };
        let (lamp, bounds) = (lamp.bounds(), room.bounds());
        let up = room.units.up.axis();
        let below = (bounds.max - lamp.max).dot(up);
        assert!(below > 0.0 && below < 0.1, "{below}");
        assert!(bounds.min.cmplt(lamp.min).all() && lamp.max.cmplt(bounds.max).all());
        let camera = &scene.cameras[0];
        assert!(bounds.min.cmplt(camera.eye).all() && camera.eye.cmplt(bounds.max).all());
    }
}
