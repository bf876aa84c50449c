//! A studio for a model in which nothing shines: a floor that curves up around it (a cyclorama) and three lamps, or a
//! lamp under the ceiling of a room.

use super::Room;
use azulejo_scene::math::{Aabb, Frame};
use azulejo_scene::{
    Camera, Material, Mesh, Object, Primitive, Rgb, Scene, Shape, Sidedness, Units,
};
use azulejo_trace::Tracer;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

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

/// Elevations of a lamp that are tried, each ten degrees higher, so that the camera does not see it.
const HIGHER: u32 = 4;

/// Width of a wide picture over its height.
const WIDE: f64 = 16.0 / 9.0;

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

/// Radiance of what is seen above the cyclorama: that of its upper edge, about, so that the model stands out, and not
/// black.
const BACKDROP: Rgb = Rgb::new(0.02, 0.022, 0.026);

/// Reflectance of floor and cyclorama: a grey that is darker than most models.
const GREY: f64 = 0.5;

/// Profile of the cyclorama, relative to the size of the model: radius of the level floor, of the cove in which it
/// curves up, and height of the wall above that. Lamps and the studio's camera are within.
const FLOOR: f64 = 3.0;
const COVE: f64 = 2.0;
const WALL: f64 = 1.5;

/// Faces of the cyclorama: around, and along each part of its profile.
const SECTORS: u32 = 64;
const FLOOR_RINGS: u32 = 28;
const COVE_RINGS: u32 = 10;
const WALL_RINGS: u32 = 3;

/// How much smaller faces are in the middle of the floor than at its edges: the power to which
/// their distances are raised.
const GRADING: f64 = 1.6;

/// Gap between the model and the floor, relative to the size of the model: faces that lie on it
/// would flicker.
const GAP: f64 = 1e-4;

/// Most that a paint reflects: fresh white.
const PAINT: f64 = 0.9;

/// Radiance of the lamp of a room: that of a panel, not quite white.
const PANEL: Rgb = Rgb::new(21.0, 20.5, 19.5);

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
        None => around(scene.main_bounds(), units, scene.cameras.first()),
    }
}

/// Limits the diffuse reflectances of a scene to 90% of what its mirrors and highlights leave, and returns how
/// many materials reflected more: models often say white for what no paint is, and light between such surfaces that
/// touch never ends.
pub fn limit_paint(scene: &mut Scene) -> usize {
    let mut limited = 0;
    for material in &mut scene.materials {
        let specular = material.mirror + material.mean_glossy();
        let most = specular.map(|s| PAINT * (1.0 - s).max(0.0));
        let paint = Rgb::from([0, 1, 2].map(|k| material.diffuse[k].min(most[k])));
        limited += usize::from(paint != material.diffuse);
        material.diffuse = paint;
    }
    limited
}

/// A lamp under the ceiling, and a camera within.
fn in_room(room: &Room, tracer: &Tracer, units: Units) -> Scene {
    let up = units.up.axis();
    let camera = Camera {
        name: "studio".into(),
        ..room.camera(tracer, units)
    };
    let mut scene = Scene {
        units,
        cameras: vec![camera],
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

/// A floor below a model of these bounds that curves up around it, unless it would hide it from `viewed_by`, and three
/// lamps, placed as that camera sees the model.
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
    let front = level_front(viewed_by.unwrap_or(&view), up);
    let right = up.cross(front);
    let mut scene = Scene {
        units,
        cameras: vec![view],
        ..Scene::default()
    };
    scene.background = Some((BACKDROP * brightness(units)).into());
    if viewed_by.is_none_or(|camera| camera.eye.dot(up) > bottom) {
        let mut grey = Material::diffuse(STUDIO_FLOOR, Rgb::grey(GREY));
        // Cameras outside of it look through.
        grey.sidedness = Sidedness::One;
        let grey = scene.add_material(grey);
        let floor = cyclorama(ground, size, (front, right, up), grey);
        let floor = Object::new(STUDIO_FLOOR, Shape::Mesh(floor));
        scene.objects.push(floor);
    }
    let view = viewed_by
        .cloned()
        .unwrap_or_else(|| scene.cameras[0].clone());
    for lamp in &LAMPS {
        let material = Material::emitter(lamp.name, lamp.radiance * brightness(units));
        let material = scene.add_material(material);
        let at = |elevation| LampPlace::new(lamp, elevation, (centre, size), (front, right, up));
        // Higher where the camera would see it.
        let higher = (0..HIGHER).map(|k| at(lamp.elevation + 10.0 * f64::from(k)));
        let hidden = higher.clone().find(|place| !place.is_in_view(&view));
        let LampPlace {
            corner,
            x,
            y,
            toward,
        } = hidden.unwrap_or_else(|| at(lamp.elevation));
        scene
            .objects
            .push(facing_sheet(lamp.name, corner, (x, y), -toward, material));
    }
    Some(scene)
}

/// The square of a lamp that faces the model.
struct LampPlace {
    corner: DVec3,
    x: DVec3,
    y: DVec3,
    /// Direction from the model.
    toward: DVec3,
}

impl LampPlace {
    /// At an elevation in degrees, from the middle of a model of this size, by the axes of the viewer.
    fn new(
        lamp: &StudioLamp,
        elevation: f64,
        (centre, size): (DVec3, f64),
        (front, right, up): (DVec3, DVec3, DVec3),
    ) -> LampPlace {
        let (sin, cos) = lamp.azimuth.to_radians().sin_cos();
        let (high, level) = elevation.to_radians().sin_cos();
        let toward = level * (cos * front + sin * right) + high * up;
        let frame = Frame::from_normal(-toward);
        let edge = lamp.size * size;
        let (x, y) = (edge * frame.x, edge * frame.y);
        let corner = centre + DISTANCE * size * toward - 0.5 * (x + y);
        LampPlace {
            corner,
            x,
            y,
            toward,
        }
    }

    /// Whether a corner is in a wide picture of the camera.
    fn is_in_view(&self, camera: &Camera) -> bool {
        let (right, up, forward) = camera.axes();
        let half = (0.5 * camera.vertical_fov).tan();
        let corners = [DVec3::ZERO, self.x, self.y, self.x + self.y];
        corners.iter().any(|&edge| {
            let way = self.corner + edge - camera.eye;
            let depth = way.dot(forward);
            let is_within = |axis: DVec3, most: f64| way.dot(axis).abs() < most * half * depth;
            depth > 0.0 && is_within(right, WIDE) && is_within(up, 1.0)
        })
    }
}

/// The horizontal direction, unit length, from what a camera looks at toward the camera; where it looks straight down,
/// toward the lower edge of its picture.
fn level_front(camera: &Camera, up: DVec3) -> DVec3 {
    let level = |v: DVec3| v - up * v.dot(up);
    let backward = level((camera.eye - camera.target).normalize_or_zero());
    if backward.length() > 0.05 {
        return backward.normalize();
    }
    level(-camera.up).normalize_or(Frame::from_normal(up).x)
}

/// A level floor around `centre` for a model of `size`, which curves up to a wall all around, seen from within. Faces
/// are small in the middle, where the shadows fall.
fn cyclorama(centre: DVec3, size: f64, (x, y, up): (DVec3, DVec3, DVec3), material: u32) -> Mesh {
    let mut floor = Mesh::default();
    for (radius, height) in profile() {
        for sector in 0..SECTORS {
            let (sin, cos) = (TAU * f64::from(sector) / f64::from(SECTORS)).sin_cos();
            let outward = cos * x + sin * y;
            floor
                .positions
                .push(centre + size * (radius * outward + height * up));
        }
    }
    let rings = floor.positions.len() as u32 / SECTORS;
    for (ring, sector) in (1..rings).flat_map(|ring| (0..SECTORS).map(move |s| (ring, s))) {
        let (inner, outer) = ((ring - 1) * SECTORS, ring * SECTORS);
        let next = (sector + 1) % SECTORS;
        floor.push_face(
            &[inner + sector, outer + sector, outer + next, inner + next],
            material,
        );
    }
    let middle: Vec<u32> = (0..SECTORS).collect();
    floor.push_face(&middle, material);
    // All of it is one smooth surface.
    floor.smoothing = vec![1; floor.face_materials.len()];
    floor.take_group_normals();
    floor
}

/// Radius and height of the rings of a [`cyclorama`], relative to the size of the model.
fn profile() -> impl Iterator<Item = (f64, f64)> {
    let share = |k: u32, of: u32| f64::from(k) / f64::from(of);
    let floor = (1..=FLOOR_RINGS).map(move |k| (FLOOR * share(k, FLOOR_RINGS).powf(GRADING), 0.0));
    let cove = (1..=COVE_RINGS).map(move |k| {
        let (sin, cos) = (FRAC_PI_2 * share(k, COVE_RINGS)).sin_cos();
        (FLOOR + COVE * sin, COVE * (1.0 - cos))
    });
    let wall = (1..=WALL_RINGS).map(move |k| (FLOOR + COVE, COVE + WALL * share(k, WALL_RINGS)));
    floor.chain(cove).chain(wall)
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
        let Shape::Mesh(floor) = &scene.objects[0].shape else {
            panic!("a mesh")
        };
        // It faces inward everywhere: up in the middle, level at its end.
        let above = 0.5 * size + DVec3::Y * size.length();
        for face in 0..floor.faces.len() {
            let corner = floor.positions[floor.faces.get(face)[0] as usize];
            let inward = (above - corner).dot(floor.face_area_vector(face));
            assert!(inward > 0.0, "face {face}");
        }
        let bounds = floor.bounds();
        assert!(bounds.min.y < 0.0 && bounds.size().x > 2.0 * DISTANCE * size.length());
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
        scene.materials[0].sidedness = Sidedness::Two;
        for (height, objects) in [(3.0, 4), (-3.0, 3)] {
            let mut camera = Camera::framing(scene.bounds(), 1.0, scene.units.up.axis());
            camera.eye += (height - camera.eye.dot(camera.up)) * camera.up;
            scene.cameras = vec![camera];
            let added = studio(&scene, &Tracer::new(&scene)).unwrap();
            assert_eq!(added.objects.len(), objects, "{height}");
        }
    }

    /// Lamps stand as the file's camera sees the model, and where it does not see them.
    #[test]
    fn lamps_are_beside_what_the_camera_sees() {
        for eye in [
            DVec3::new(3.0, 0.5, 0.5),
            DVec3::new(-9.0, 2.0, 0.5),
            DVec3::new(0.5, 0.1, -4.0),
        ] {
            let mut scene = azulejo_scene::synthetic::cube_room();
            scene.materials[0].sidedness = Sidedness::Two;
            let mut camera = Camera::framing(scene.bounds(), 1.0, scene.units.up.axis());
            let up = camera.up;
            camera.target = scene.bounds().centre();
            camera.eye = eye;
            scene.cameras = vec![camera.clone()];
            let added = studio(&scene, &Tracer::new(&scene)).unwrap();
            let lamps = added.objects.iter().filter(|o| o.name != STUDIO_FLOOR);
            let (right, upward, forward) = camera.axes();
            for lamp in lamps {
                let way = lamp.bounds().centre() - camera.eye;
                let half = (0.5 * camera.vertical_fov).tan() * way.dot(forward);
                let is_seen =
                    half > 0.0 && way.dot(right).abs() < half && way.dot(upward).abs() < half;
                assert!(!is_seen, "{eye}: {}", lamp.name);
                let from_model = lamp.bounds().centre() - camera.target;
                let is_left = from_model.dot(right) < 0.0;
                assert_eq!(is_left, lamp.name == "key light", "{eye}: {}", lamp.name);
                assert!(from_model.dot(up) > 0.0);
            }
        }
    }

    #[test]
    fn no_paint_reflects_all() {
        let mut scene = Scene::default();
        let white = scene.add_material(Material::diffuse("white", Rgb::WHITE));
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        let mut half = Material::diffuse("half a mirror", Rgb::grey(0.5));
        half.mirror = Rgb::grey(0.5);
        let half = scene.add_material(half);
        assert_eq!(limit_paint(&mut scene), 2);
        let diffuse = |m: u32| scene.materials[m as usize].diffuse;
        assert_eq!(diffuse(white), Rgb::grey(0.9));
        assert_eq!(diffuse(grey), Rgb::grey(0.5));
        assert_eq!(diffuse(half), Rgb::grey(0.45));
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
