//! A first look at a scene that has no camera: from outside, or from within where the light is.

use azulejo_scene::math::{Aabb, Ray};
use azulejo_scene::{Camera, Scene};
use azulejo_trace::sampling::{hash, uniform};
use azulejo_trace::{GatherPoint, Gatherer, Surfaces, Tracer};
use glam::DVec3;
use std::f64::consts::TAU;

/// Rays across and down the view from outside, and from each place within all around.
const RAYS: u32 = 16;

/// Where so much of the surfaces seen from outside is lit, nothing else is looked for.
const LIT: f64 = 0.5;

/// Share of the directions from a place within that must end at surfaces: a room may have windows,
/// or lack a wall.
const ENCLOSED: f64 = 0.8;

/// How much more of what is seen must be lit from within than from outside.
const BETTER: f64 = 1.3;

/// Places within that are tried along each axis.
const PLACES: u32 = 6;

/// Directions around the horizon in which a place within may look.
const WAYS: u32 = 24;

/// Vertical field of view of interiors, degrees: wider than from outside, as photographers do.
const WITHIN: f64 = 62.0;

/// Seeds the rays.
const SEED: u32 = 0xf1e5;

/// A camera that shows something: the whole scene from outside, or, where little light reaches what
/// is seen from there and more is within, as in a room, a view from a place inside.
/// `aspect` is the width of the image over its height.
pub fn first_view(scene: &Scene, tracer: &Tracer, aspect: f64) -> Camera {
    let up = scene.units.up.axis();
    let bounds = scene.bounds();
    let outside = Camera::framing(bounds, aspect, up);
    let look = FirstLook {
        gatherer: Gatherer::new(Surfaces::new(scene, tracer)),
        tracer,
        up,
    };
    if bounds.is_empty() || !scene.has_light() {
        return outside;
    }
    match look.lit_share(&outside, aspect) {
        lit if lit >= LIT => outside,
        lit => look.within(bounds, BETTER * lit).unwrap_or(outside),
    }
}

struct FirstLook<'a> {
    gatherer: Gatherer<'a>,
    tracer: &'a Tracer,
    up: DVec3,
}

/// What rays see.
struct SeenAround {
    /// Share of the rays that end at lit surfaces.
    lit: f64,
    /// Share of the rays that end at all.
    enclosed: f64,
    /// Mean distance of what they see.
    distance: f64,
}

impl SeenAround {
    /// Share of the surfaces that are lit; 1 if there are none.
    fn lit_share(&self) -> f64 {
        if self.enclosed > 0.0 {
            self.lit / self.enclosed
        } else {
            1.0
        }
    }
}

impl FirstLook<'_> {
    /// Share of the surfaces seen by a camera that are lit, or shine; 1 if it sees none.
    fn lit_share(&self, camera: &Camera, aspect: f64) -> f64 {
        let middle = |k: u32| (f64::from(k) + 0.5) / f64::from(RAYS);
        let ray = |k: u32| camera.ray(middle(k % RAYS), middle(k / RAYS), aspect);
        let rays: Vec<Ray> = (0..RAYS * RAYS).map(ray).collect();
        let seen = self.see(&rays);
        seen.lit_share()
    }

    /// What rays see, by direct light alone.
    fn see(&self, rays: &[Ray]) -> SeenAround {
        let kernel_rays: Vec<_> = rays.iter().map(|r| self.tracer.kernel_ray(r)).collect();
        let mut hits = Vec::new();
        self.tracer.closest(&kernel_rays, &mut hits);
        let surfaces = self.gatherer.surfaces();
        let (mut points, mut shining, mut distance) = (Vec::new(), 0, 0.0);
        for (index, ((ray, kernel_ray), hit)) in
            rays.iter().zip(&kernel_rays).zip(&hits).enumerate()
        {
            if !hit.is_hit() {
                continue;
            }
            let at = self.tracer.resolve(ray, hit);
            distance += at.position.distance(ray.origin);
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
        let share = |count: usize| count as f64 / rays.len() as f64;
        SeenAround {
            lit: share(lit.min(points.len())),
            enclosed: share(points.len()),
            distance: distance / points.len().max(1) as f64,
        }
    }

    /// A view from within: from the place that sees most lit surfaces far away, back against the
    /// wall behind it. `None` if nowhere more than the share `least` of what is seen is lit.
    fn within(&self, bounds: Aabb, least: f64) -> Option<Camera> {
        let places = (0..PLACES.pow(3)).map(|k| {
            let part = |axis: u32| {
                let cell = k / PLACES.pow(axis) % PLACES;
                let jitter = f64::from(uniform(&[SEED, k, axis]));
                (f64::from(cell) + 0.25 + 0.5 * jitter) / f64::from(PLACES)
            };
            bounds.min + bounds.size() * DVec3::new(part(0), part(1), part(2))
        });
        let scored = places.enumerate().map(|(k, place)| {
            let seen = self.see(&self.around(place, k as u32));
            let is_room = seen.enclosed >= ENCLOSED && seen.lit_share() > least;
            let score = seen.lit * seen.enclosed * seen.distance;
            (if is_room { score } else { 0.0 }, place)
        });
        let best = scored.max_by(|a, b| a.0.total_cmp(&b.0));
        let (_, place) = best.filter(|(score, _)| *score > 0.0)?;
        let (x, y) = self.up.any_orthonormal_pair();
        let ways: Vec<DVec3> = (0..WAYS)
            .map(|k| TAU * f64::from(k) / f64::from(WAYS))
            .map(|angle| angle.cos() * x + angle.sin() * y)
            .collect();
        // Toward where most is seen, and not out of the room, from as far back as there is room, which a wall
        // that is missing gives.
        let seen = |way: DVec3| self.free(place, way).unwrap_or(0.0);
        let back = |way: DVec3| self.free(place, -way).unwrap_or(0.5 * bounds.diagonal());
        let (_, way) = ways
            .iter()
            .map(|&way| (seen(way) + 0.9 * back(way), way))
            .filter(|(_, way)| seen(*way) > 0.0)
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        let eye = place - 0.9 * back(way) * way;
        let target = place + 0.5 * seen(way) * way - 0.08 * seen(way) * self.up;
        (eye.distance(target) > 0.0).then(|| Camera {
            name: String::new(),
            eye,
            target,
            up: self.up,
            vertical_fov: WITHIN.to_radians(),
            size: None,
        })
    }

    /// Rays from a place in all directions.
    fn around(&self, place: DVec3, key: u32) -> Vec<Ray> {
        let ray = |k: u32| {
            let u = |d: u32| f64::from(uniform(&[hash(&[SEED, key]), k, d]));
            let z = 1.0 - 2.0 * (f64::from(k) + u(0)) / f64::from(4 * RAYS);
            let across = (1.0 - z * z).max(0.0).sqrt();
            let angle = TAU * u(1);
            Ray::new(
                place,
                DVec3::new(across * angle.cos(), across * angle.sin(), z),
            )
        };
        (0..4 * RAYS).map(ray).collect()
    }

    /// How far one can go from a place in a unit direction; `None` if there is no end.
    fn free(&self, place: DVec3, way: DVec3) -> Option<f64> {
        let ray = Ray::new(place, way);
        let mut hits = Vec::new();
        self.tracer
            .closest(&[self.tracer.kernel_ray(&ray)], &mut hits);
        let is_hit = hits[0].is_hit();
        is_hit.then(|| self.tracer.resolve(&ray, &hits[0]).position.distance(place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::synthetic::cube_room;
    use azulejo_scene::{Light, LightKind, Rgb};

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
