//! Whether a model is a room, and where a lamp hangs in it.

use azulejo_scene::math::{Aabb, Frame, Ray};
use azulejo_scene::{Camera, Scene, Sidedness, Units};
use azulejo_trace::{Hit, Surfaces, Tracer};
use glam::DVec3;
use std::f64::consts::PI;

/// The inside of a room: a place in its air, and the free space around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// A place from which the walls are seen.
    pub centre: DVec3,
    /// The ceiling above it; `None` for a court, open to the sky.
    pub ceiling: Option<DVec3>,
    /// The floor below it.
    pub floor: DVec3,
    /// A square panel under the ceiling that nothing cuts: its centre and its edge.
    pub lamp: (DVec3, f64),
}

/// Directions in which a place looks around.
const DIRECTIONS: u32 = 192;

/// Share of the directions in which the front of a surface is seen, from a place in a room. One side
/// of six may be open, or the roof.
const SEEN: f64 = 0.6;

/// The same share among the directions near the horizontal: a place over open country sees nothing
/// there, however much of the ground it sees.
const WALLS: f64 = 0.55;

/// A wall is one of the room, and not of what stands in it, if it is at least this share of the way
/// to the end of the model.
const FAR: f64 = 0.5;

/// Share of the directions that end at such walls. The cabin of a car is surrounded, too, but by a
/// small part of the car.
const SEEN_FAR: f64 = 0.45;

/// Share of the backs among what is seen of the model from outside: walls without thickness, which
/// make a room of a flat with many.
const BACKS: f64 = 0.6;

/// Edge of the lamp, relative to the smaller side of the room.
const LAMP: f64 = 0.3;

/// Distance of the lamp from the ceiling, relative to the height of the room.
const DROP: f64 = 0.04;

/// Share of the directions around one in which nothing may be seen of a side that is not open.
const OPEN: f64 = 0.6;

/// Vertical field of view within, degrees.
const WIDE: f64 = 62.0;

impl Room {
    /// The room that a model is, if it is one: a place within the model from which one sees the
    /// fronts of walls all around. A closed solid is none, as from within it only backs are seen.
    ///
    /// None either is what one looks through from one side to the other, nor a shell of faces with two sides that all face
    /// inward, if the file's camera sees it from outside,
    /// or has none and the shell is empty: there the order of corners means nothing.
    ///
    /// `tracer` is that of the scene; its bounds are finite.
    pub fn find(scene: &Scene, tracer: &Tracer) -> Option<Room> {
        let bounds = tracer.bounds();
        if bounds.is_empty() || !bounds.diagonal().is_finite() {
            return None;
        }
        let up = scene.units.up.axis();
        if is_for_outside(scene, tracer) {
            return None;
        }
        let needed = if shows_backs(tracer, up) {
            0.0
        } else {
            SEEN_FAR
        };
        let mut best: Option<(f64, DVec3)> = None;
        for place in places(bounds, up) {
            let score = outlook(tracer, place, up, needed);
            // The places come from the middle outward; another one has to be clearly better.
            if score > 0.0 && best.is_none_or(|(known, _)| score > known + 0.05) {
                best = Some((score, place));
            }
        }
        let (_, centre) = best?;
        let hit = |direction: DVec3| tracer.hit(&Ray::new(centre, direction));
        let floor = hit(-up).map(|hit| hit.position)?;
        let ceiling = hit(up).map(|hit| hit.position);
        // What one looks through is a frame or a tunnel.
        let is_open = |direction| openness(tracer, centre, direction, up) > OPEN;
        let mut ways = level_directions(up).take(8);
        if ways.any(|direction| is_open(direction) && is_open(-direction)) {
            return None;
        }
        Some(Room {
            centre,
            ceiling,
            floor,
            lamp: lamp(tracer, centre, (floor, ceiling), up),
        })
    }

    /// Height of the room, or of its walls.
    pub fn height(&self) -> f64 {
        (self.ceiling.unwrap_or(self.lamp.0) - self.floor).length()
    }

    /// A camera at the height of eyes, wide, as one cannot step back: it looks into an open side, from one step back, or else from far on the
    /// side with the widest view. A window or a door is no open side.
    pub fn camera(&self, tracer: &Tracer, units: Units) -> Camera {
        let up = units.up.axis();
        let eyes = self.floor + up * (0.55 * self.height());
        let middle = tracer.bounds().centre();
        let middle = middle + up * (eyes - middle).dot(up);
        let (mut widest, mut most_open) = ((0.0, DVec3::ZERO), (OPEN, None));
        for direction in level_directions(up) {
            if let Some(hit) = tracer.hit(&Ray::new(eyes, direction)) {
                let reach = 0.92 * (hit.position - eyes).length();
                if reach > 1.001 * widest.0 {
                    widest = (reach, direction);
                }
            }
            for place in [middle, eyes] {
                let share = openness(tracer, place, direction, up);
                if share > most_open.0 {
                    most_open = (share, Some((place, direction)));
                }
            }
        }
        let (place, reach, direction) = match most_open.1 {
            Some((place, direction)) => {
                // A step back from where the model ends: as far as its middle, or more if it is shallow and wide.
                let depth = exit(tracer.bounds(), place, direction);
                let across = 0.5 * tracer.bounds().size().dot(direction.cross(up).abs());
                (place, depth + 0.8 * depth.max(across), direction)
            }
            None => (eyes, widest.0, widest.1),
        };
        let ahead = place - up * (0.13 * self.height()) - 0.5 * reach * direction;
        Camera {
            name: String::new(),
            eye: place + reach * direction,
            target: ahead,
            up,
            vertical_fov: WIDE.to_radians(),
            size: None,
        }
    }
}

/// Sixteen directions along the ground; those of the second half are opposite to those of the first.
fn level_directions(up: DVec3) -> impl Iterator<Item = DVec3> {
    let around = Frame::from_normal(up);
    (0..16).map(move |step| {
        let (sin, cos) = (f64::from(step) * PI / 8.0).sin_cos();
        cos * around.x + sin * around.y
    })
}

/// Share of the directions near one, within 30 degrees to either side and 15 up and down, in which nothing is seen.
fn openness(tracer: &Tracer, place: DVec3, direction: DVec3, up: DVec3) -> f64 {
    let beside = direction.cross(up);
    let ways = (-3..=3).flat_map(|i| (-1..=1).map(move |j| (f64::from(i), f64::from(j))));
    let missed = ways.filter(|(i, j)| {
        let way = direction + i / 3.0 * 30_f64.to_radians().tan() * beside;
        let way = way + j * 15_f64.to_radians().tan() * up;
        tracer.hit(&Ray::new(place, way.normalize())).is_none()
    });
    missed.count() as f64 / 21.0
}

/// Places that may lie in the air of a room, from the middle of the model outward.
fn places(bounds: Aabb, up: DVec3) -> Vec<DVec3> {
    let (size, around) = (bounds.size(), Frame::from_normal(up));
    let half = |axis: DVec3| 0.5 * size.dot(axis.abs()) * axis;
    let (x, y, z) = (half(around.x), half(around.y), half(up));
    let mut places = Vec::new();
    for reach in [0.0, 0.45] {
        for height in [0.0, -0.4, 0.35] {
            for (i, j) in [
                (0, 0),
                (1, 0),
                (-1, 0),
                (0, 1),
                (0, -1),
                (1, 1),
                (-1, 1),
                (1, -1),
                (-1, -1),
            ] {
                let is_middle = (i, j) == (0, 0);
                if is_middle == (reach == 0.0) {
                    let level = f64::from(i) * x + f64::from(j) * y;
                    places.push(bounds.centre() + reach * level + height * z);
                }
            }
        }
    }
    places
}

/// Whether one sees mostly backs of the model from outside, from all around.
fn shows_backs(tracer: &Tracer, up: DVec3) -> bool {
    let bounds = tracer.bounds();
    let away = bounds.diagonal();
    let (mut backs, mut hits) = (0, 0);
    for k in 0..DIRECTIONS {
        let direction = spread(k, up);
        let ray = Ray::new(bounds.centre() - away * direction, direction);
        if let Some(hit) = tracer.hit(&ray) {
            hits += 1;
            backs += u32::from(!hit.entering);
        }
    }
    f64::from(backs) > BACKS * f64::from(hits)
}

/// Rays along each edge of a camera's picture.
const LOOKS: u32 = 12;

/// Share of the back of faces with two sides in the view of a camera, and of an empty shell in that of all around it.
const OUTSIDE: f64 = 0.9;

/// Whether backs of faces with two sides are what the model shows to those outside, where the file's first camera stands
/// or, if there is none, because the faces hide nothing.
fn is_for_outside(scene: &Scene, tracer: &Tracer) -> bool {
    let surfaces = Surfaces::new(scene, tracer);
    let is_shown_back =
        |hit: &Hit| !hit.entering && surfaces.material(hit.item).sidedness == Sidedness::Two;
    let (mut hits, mut backs) = (0, 0);
    let mut look = |hit: Option<Hit>, other: Option<Hit>| {
        hits += u32::from(hit.is_some());
        let is_alone = |hit: &Hit| other.is_none_or(|other| hit.item == other.item);
        backs += u32::from(hit.is_some_and(|hit| is_shown_back(&hit) && is_alone(&hit)));
    };
    let bounds = tracer.bounds();
    match scene.cameras.first() {
        Some(camera) => camera_rays(camera).for_each(|ray| look(tracer.hit(&ray), None)),
        None => (0..DIRECTIONS).for_each(|k| {
            let direction = spread(k, scene.units.up.axis());
            let outward = Ray::new(bounds.centre(), direction);
            let inward = Ray::new(outward.at(bounds.diagonal()), -direction);
            look(tracer.hit(&inward), tracer.hit(&outward));
        }),
    }
    f64::from(backs) > OUTSIDE * f64::from(hits)
}

/// Rays through a grid of a square picture.
fn camera_rays(camera: &Camera) -> impl Iterator<Item = Ray> {
    let place = |k: u32| (f64::from(k) + 0.5) / f64::from(LOOKS);
    (0..LOOKS * LOOKS).map(move |k| camera.ray(place(k % LOOKS), place(k / LOOKS), 1.0))
}

/// The share of directions in which a place sees fronts; 0 if it is not in a room, or if fewer than
/// `needed` of them are near the end of the model.
fn outlook(tracer: &Tracer, place: DVec3, up: DVec3, needed: f64) -> f64 {
    let bounds = tracer.bounds();
    let (mut seen, mut walls, mut level, mut far) = (0, 0, 0, 0);
    for k in 0..DIRECTIONS {
        let direction = spread(k, up);
        let is_level = direction.dot(up).abs() < 0.5;
        let hit = tracer.hit(&Ray::new(place, direction));
        let is_front = hit.is_some_and(|hit| hit.entering);
        let reach = hit.map_or(0.0, |hit| (hit.position - place).length());
        let is_far = reach >= FAR * exit(bounds, place, direction);
        far += u32::from(is_front && is_far);
        seen += u32::from(is_front);
        level += u32::from(is_level);
        walls += u32::from(is_front && is_level);
    }
    let share = f64::from(seen) / f64::from(DIRECTIONS);
    let is_room = share >= SEEN
        && f64::from(walls) >= WALLS * f64::from(level)
        && f64::from(far) >= needed * f64::from(DIRECTIONS);
    if is_room { share } else { 0.0 }
}

/// Direction `k` of many that are spread evenly over the sphere: a Fibonacci lattice.
fn spread(k: u32, up: DVec3) -> DVec3 {
    let golden = PI * (3.0 - 5f64.sqrt());
    let height = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(DIRECTIONS);
    let (sin, cos) = (golden * f64::from(k)).sin_cos();
    let radius = (1.0 - height * height).sqrt();
    Frame::from_normal(up).to_world(DVec3::new(radius * cos, radius * sin, height))
}

/// A lamp under the ceiling, or at the top of a court: as large as suits the room, and smaller and
/// lower where beams or walls are in its way.
fn lamp(
    tracer: &Tracer,
    centre: DVec3,
    (floor, ceiling): (DVec3, Option<DVec3>),
    up: DVec3,
) -> (DVec3, f64) {
    let bounds = tracer.bounds();
    let around = Frame::from_normal(up);
    let reach = |direction: DVec3| match tracer.hit(&Ray::new(centre, direction)) {
        Some(hit) => (hit.position - centre).length(),
        None => exit(bounds, centre, direction),
    };
    let width = |axis: DVec3| reach(axis) + reach(-axis);
    let mut edge = LAMP * width(around.x).min(width(around.y));
    let top = ceiling.unwrap_or(centre + up * exit(bounds, centre, up));
    let height = (top - floor).length();
    let mut drop = DROP * height;
    for _ in 0..4 {
        let middle = top - drop * up;
        let is_free = [
            (0.5, 0.5),
            (-0.5, 0.5),
            (0.5, -0.5),
            (-0.5, -0.5),
            (0.0, 0.0),
        ]
        .iter()
        .all(|&(i, j)| {
            let corner = middle + edge * (i * around.x + j * around.y);
            let way = corner - centre;
            let hit = tracer.hit(&Ray::new(centre, way.normalize_or(up)));
            hit.is_none_or(|hit| (hit.position - centre).length() > way.length())
        });
        if is_free {
            break;
        }
        (edge, drop) = (0.7 * edge, 1.5 * drop);
    }
    (top - drop * up, edge)
}

/// Distance from a place within `bounds` to where a ray leaves them.
fn exit(bounds: Aabb, place: DVec3, direction: DVec3) -> f64 {
    let mut least = f64::INFINITY;
    for axis in 0..3 {
        let d = direction[axis];
        let end = if d > 0.0 {
            bounds.max[axis]
        } else {
            bounds.min[axis]
        };
        if d != 0.0 {
            least = least.min((end - place[axis]) / d);
        }
    }
    if least.is_finite() {
        least.max(0.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::synthetic::cube_room;
    use azulejo_scene::{Material, Mesh, Object, Primitive, PrimitiveKind, Rgb, Scene, Shape, Up};
    use glam::DAffine3;

    fn find(scene: &Scene) -> Option<Room> {
        Room::find(scene, &Tracer::new(scene))
    }

    fn solid(kind: PrimitiveKind) -> Scene {
        let mut scene = Scene::default();
        let material = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
        let primitive = Primitive::new(kind, DAffine3::IDENTITY, material);
        let shape = Shape::Primitive(primitive);
        scene.objects.push(Object::new("solid", shape));
        scene
    }

    #[test]
    fn a_closed_solid_is_no_room() {
        for kind in [
            PrimitiveKind::Cuboid,
            PrimitiveKind::Sphere,
            PrimitiveKind::Cylinder,
        ] {
            assert_eq!(find(&solid(kind)), None, "{kind:?}");
        }
        assert_eq!(find(&Scene::default()), None);
    }

    #[test]
    fn faces_that_look_inward_are_a_room_with_a_lamp_under_its_ceiling() {
        let scene = cube_room();
        let room = find(&scene).unwrap();
        let top = room.ceiling.unwrap();
        let up = scene.units.up.axis();
        let (lamp, edge) = room.lamp;
        let gap = (top - lamp).dot(up);
        assert!(gap > 0.0 && gap < 0.1 * room.height(), "{gap}");
        assert!(edge > 0.1 && edge < 0.5, "{edge}");
        let Camera { eye, target, .. } = room.camera(&Tracer::new(&scene), scene.units);
        let bounds = scene.bounds();
        assert!(
            bounds.min.cmplt(eye).all() && eye.cmplt(bounds.max).all(),
            "{eye}"
        );
        assert!((target - eye).length() > 0.5);
    }

    /// The room without these of its faces.
    fn room_without(faces: &[usize]) -> Mesh {
        let scene = cube_room();
        let walls = scene.objects[0].shape.mesh().unwrap();
        let mut open = Mesh {
            positions: walls.positions.clone(),
            ..Mesh::default()
        };
        for k in (0..walls.faces.len()).filter(|k| !faces.contains(k)) {
            open.push_face(walls.faces.get(k), 0);
        }
        open
    }

    /// Adds a wall at this x, seen from within, with a hole from `low` to `high` of its width and height.
    fn add_window(mesh: &mut Mesh, x: f64, [low, high]: [f64; 2]) {
        let ring = [0.0, low, high, 1.0];
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            if (i, j) != (1, 1) {
                let first = mesh.positions.len() as u32;
                for (y, z) in [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)] {
                    mesh.positions.push(DVec3::new(x, ring[y], ring[z]));
                }
                let mut corners = [0, 1, 2, 3].map(|k| first + k);
                if x == 0.0 {
                    corners.reverse();
                }
                mesh.push_face(&corners, 0);
            }
        }
    }

    fn scene_of(mesh: Mesh) -> Scene {
        let mut scene = cube_room();
        scene.objects[0].shape = Shape::Mesh(mesh);
        scene
    }

    /// The room without a wall is seen head on through it; one with a window from within.
    #[test]
    fn open_sides_are_looked_through_and_windows_are_not() {
        let view = |mesh: Mesh| {
            let scene = scene_of(mesh);
            let room = find(&scene).unwrap();
            room.camera(&Tracer::new(&scene), scene.units).eye
        };
        // The walls at x = 0 and x = 1, and those at z.
        for (face, axis, is_high) in [(0, 0, false), (1, 0, true), (4, 2, false), (5, 2, true)] {
            let eye = view(room_without(&[face]));
            let beyond = if is_high { eye[axis] - 1.0 } else { -eye[axis] };
            assert!(beyond > 0.2, "{face}: {eye}");
            assert!((eye[2 - axis] - 0.5).abs() < 1e-6, "{face}: {eye}");
        }
        let mut window = room_without(&[1]);
        add_window(&mut window, 1.0, [1.0 / 3.0, 2.0 / 3.0]);
        let eye = view(window);
        assert!(
            eye.cmpgt(DVec3::ZERO).all() && eye.cmplt(DVec3::ONE).all(),
            "{eye}"
        );
    }

    #[test]
    fn what_one_looks_through_is_no_room() {
        let mut one = room_without(&[1]);
        add_window(&mut one, 1.0, [0.15, 0.85]);
        assert!(find(&scene_of(one)).is_some());
        let mut both = room_without(&[0, 1]);
        for x in [0.0, 1.0] {
            add_window(&mut both, x, [0.15, 0.85]);
        }
        assert_eq!(find(&scene_of(both)), None);
    }

    /// A pillar in the middle does not make a solid of the room, nor does the room's direction
    /// of up.
    #[test]
    fn what_stands_in_the_middle_does_not_hide_the_room() {
        for up in [Up::Y, Up::Z] {
            let mut scene = cube_room();
            scene.units.up = up;
            let map = DAffine3::from_scale_rotation_translation(
                DVec3::splat(0.3),
                glam::DQuat::IDENTITY,
                DVec3::splat(0.35),
            );
            let pillar = Primitive::new(PrimitiveKind::Cuboid, map, 0);
            let shape = Shape::Primitive(pillar);
            scene.objects.push(Object::new("pillar", shape));
            let room = find(&scene).unwrap();
            let middle = room.centre - DVec3::splat(0.5);
            assert!(middle.abs().max_element() > 0.15, "{middle}");
        }
    }

    /// The seats of an open car are surrounded by its body, which is not a room.
    #[test]
    fn a_hollow_in_a_solid_is_no_room() {
        let mut scene = solid(PrimitiveKind::Cuboid);
        // A small room within a large solid, from the same centre.
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.3),
            glam::DQuat::IDENTITY,
            DVec3::splat(0.35),
        );
        scene.merge(cube_room().transformed(&map));
        assert_eq!(find(&scene), None);
    }

    #[test]
    fn open_country_is_no_room() {
        let mut scene = solid(PrimitiveKind::Cuboid);
        let far = DAffine3::from_scale_rotation_translation(
            DVec3::new(20.0, 20.0, 1.0),
            glam::DQuat::IDENTITY,
            DVec3::new(-10.0, -10.0, 0.0),
        );
        let ground = Primitive::new(PrimitiveKind::Square, far, 0);
        scene.units.up = Up::Z;
        let shape = Shape::Primitive(ground);
        scene.objects.push(Object::new("ground", shape));
        assert_eq!(find(&scene), None);
    }
}
