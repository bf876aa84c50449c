//! A first look at a scene that has no camera: from outside, or into the room that it is.

use crate::Room;
use azulejo_scene::math::Ray;
use azulejo_scene::{Camera, Scene};
use azulejo_trace::{GatherPoint, Gatherer, Surfaces, Tracer};

/// Rays across and down a view.
const RAYS: u32 = 16;

/// How much more of the view of a room must be lit than of the view from outside.
const BETTER: f64 = 1.3;

/// Seeds the rays.
const SEED: u32 = 0xf1e5;

/// A camera that shows something: the whole scene from outside, or, if it is a room of which more is lit than one sees
/// from there, that of the room. `aspect` is the width of the image over its height.
pub fn first_view(scene: &Scene, tracer: &Tracer, aspect: f64) -> Camera {
    let outside = Camera::framing(scene.main_bounds(), aspect, scene.units.up.axis());
    if scene.bounds().is_empty() || !scene.has_light() {
        return outside;
    }
    let look = FirstLook {
        gatherer: Gatherer::new(Surfaces::new(scene, tracer)),
        tracer,
    };
    let room = Room::find(scene, tracer).map(|room| room.camera(tracer, scene.units));
    let lit = |camera: &Camera| look.lit_share(camera, aspect);
    match room {
        Some(room) if lit(&room) > BETTER * lit(&outside) => room,
        _ => outside,
    }
}

struct FirstLook<'a> {
    gatherer: Gatherer<'a>,
    tracer: &'a Tracer,
}

impl FirstLook<'_> {
    /// Share of a camera's picture in which surfaces are lit by direct light, or shine.
    fn lit_share(&self, camera: &Camera, aspect: f64) -> f64 {
        let middle = |k: u32| (f64::from(k) + 0.5) / f64::from(RAYS);
        let ray = |k: u32| camera.ray(middle(k % RAYS), middle(k / RAYS), aspect);
        let rays: Vec<Ray> = (0..RAYS * RAYS).map(ray).collect();
        let kernel_rays: Vec<_> = rays.iter().map(|r| self.tracer.kernel_ray(r)).collect();
        let mut hits = Vec::new();
        self.tracer.closest(&kernel_rays, &mut hits);
        let surfaces = self.gatherer.surfaces();
        let (mut points, mut shining) = (Vec::new(), 0);
        for (index, ((ray, kernel_ray), hit)) in
            rays.iter().zip(&kernel_rays).zip(&hits).enumerate()
        {
            if !hit.is_hit() {
                continue;
            }
            let at = self.tracer.resolve(ray, hit);
            let front = surfaces.is_front(kernel_ray, hit);
            let emitted = surfaces.emitted(hit, front);
            shining += usize::from(!emitted.is_black());
            points.push(GatherPoint {
                position: at.position,
                normal: if front { at.normal } else { -at.normal },
                key: index as u32,
            });
        }
        let ambient = !self.gatherer.ambient().is_black();
        let light = self.gatherer.direct(&points, 1, SEED);
        let lit = light.iter().filter(|l| !l.whole().mean().is_black());
        // The light of uniform surroundings comes by other rays; what is seen from outside has it.
        let lit = if ambient {
            points.len()
        } else {
            lit.count() + shining
        };
        lit.min(points.len()) as f64 / rays.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::synthetic::cube_room;
    use azulejo_scene::{Light, LightKind, Rgb};
    use glam::DVec3;

    fn view(scene: &Scene) -> Camera {
        first_view(scene, &Tracer::new(scene), 1.5)
    }

    #[test]
    fn closed_rooms_are_seen_from_within() {
        let mut room = cube_room();
        room.lights.push(Light {
            name: "lamp".into(),
            kind: LightKind::Point {
                position: DVec3::new(0.4, 0.8, 0.5),
                intensity: Rgb::WHITE,
            },
        });
        let camera = view(&room);
        let bounds = room.bounds();
        assert!(bounds.min.cmplt(camera.eye).all() && camera.eye.cmplt(bounds.max).all());
        let (right, up, forward) = camera.axes();
        assert!(right.is_finite() && up.is_finite() && forward.is_finite());
        // The same at every call.
        assert_eq!(view(&room), camera);
    }

    /// Where a wall is missing, one looks away from there.
    #[test]
    fn open_rooms_are_looked_into() {
        for missing in [0, 4] {
            let mut room = cube_room();
            let bounds = room.bounds();
            let azulejo_scene::Shape::Mesh(mesh) = &mut room.objects[0].shape else {
                unreachable!("a room of polygons")
            };
            let whole = std::mem::take(mesh);
            mesh.positions = whole.positions.clone();
            for face in (0..whole.faces.len()).filter(|&f| f != missing) {
                mesh.push_face(whole.faces.get(face), whole.face_materials[face]);
            }
            room.lights.push(Light {
                name: "lamp".into(),
                kind: LightKind::Point {
                    position: bounds.centre(),
                    intensity: Rgb::WHITE,
                },
            });
            let camera = view(&room);
            let outside = Camera::framing(bounds, 1.5, room.units.up.axis());
            assert_ne!(camera, outside);
            let ray = Ray::new(camera.eye, (camera.target - camera.eye).normalize());
            assert!(Tracer::new(&room).hit(&ray).is_some(), "{camera:?}");
        }
    }

    #[test]
    fn what_is_lit_from_outside_is_seen_from_there() {
        let mut scene = cube_room();
        let up = scene.units.up.axis();
        let outside = Camera::framing(scene.bounds(), 1.5, up);
        scene.lights.push(Light {
            name: "from the viewer".into(),
            kind: LightKind::Point {
                position: outside.eye,
                intensity: Rgb::WHITE,
            },
        });
        assert_eq!(view(&scene), outside);
        // In the dark nothing is better than the view from outside.
        scene.lights.clear();
        assert_eq!(view(&scene), outside);
    }
}
