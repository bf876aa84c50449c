//! The lighting of the preview sphere.

use azulejo::scene::{Light, LightKind, Material, Object, PrimitiveKind, Rgb, Scene, Shape, Up};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Limit on the number of lamps; the others are replaced by ambient light.
const MAX_LAMPS: usize = 6;

/// The lighting of the preview sphere: the lights of a scene as seen from one point, or a studio.
/// The y axis points up.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviewLight {
    /// Distant lamps.
    pub lamps: Vec<PreviewLamp>,
    /// Radiance from all other directions, W/(sr·m²).
    pub ambient: Rgb,
}

/// A distant disc-shaped lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewLamp {
    /// Unit vector toward it.
    pub toward: DVec3,
    /// Irradiance on a surface that faces it, W/m².
    pub irradiance: Rgb,
    /// Half its apparent angle, radians; 0 for lights without area.
    pub half_angle: f64,
}

impl PreviewLight {
    /// A large lamp on the left and a dim sky.
    pub fn studio() -> PreviewLight {
        PreviewLight {
            lamps: vec![PreviewLamp {
                toward: DVec3::new(-0.5, 0.75, 0.6).normalize(),
                irradiance: Rgb::grey(PI),
                half_angle: 0.2,
            }],
            ambient: Rgb::grey(0.25),
        }
    }

    /// The lights of a scene as seen from `at`: lights without area, and emissive objects as one
    /// lamp each, without occlusion. Visits all faces of the scene, so the result should be cached.
    pub fn of_scene(scene: &Scene, at: DVec3) -> PreviewLight {
        let mut light = PreviewLight {
            lamps: Vec::new(),
            ambient: Rgb::BLACK,
        };
        scene.lights.iter().for_each(|l| light.add(l, at));
        let emitters = scene.objects.iter().filter_map(|o| emitter(scene, o, at));
        light.lamps.extend(emitters);
        light
            .lamps
            .retain(|l| l.irradiance.max_channel() > 0.0 && l.toward.is_finite());
        if scene.units.up == Up::Z {
            light
                .lamps
                .iter_mut()
                .for_each(|l| l.toward = y_up(l.toward));
        }
        light.reduced()
    }

    fn add(&mut self, light: &Light, at: DVec3) {
        let (toward, irradiance) = match light.kind {
            LightKind::Ambient { radiance } => {
                self.ambient += radiance;
                return;
            }
            // The preview shows balls without surroundings to mirror.
            LightKind::Environment(_) => return,
            LightKind::Directional {
                direction,
                irradiance,
                ..
            } => (-direction, irradiance),
            LightKind::Point { position, .. }
            | LightKind::Spot { position, .. }
            | LightKind::Luminaire { position, .. } => {
                let toward = (position - at).normalize_or(DVec3::Y);
                let square = position.distance_squared(at).max(f64::MIN_POSITIVE);
                (toward, light.kind.intensity_toward(-toward) / square)
            }
        };
        self.lamps.push(PreviewLamp {
            toward,
            irradiance,
            half_angle: 0.0,
        });
    }

    /// Keeps the brightest lamps; the others become ambient light.
    fn reduced(mut self) -> PreviewLight {
        let brightness = |l: &PreviewLamp| l.irradiance.luminance();
        self.lamps
            .sort_by(|a, b| brightness(b).total_cmp(&brightness(a)));
        let rest = self.lamps.split_off(self.lamps.len().min(MAX_LAMPS));
        self.ambient += rest.iter().map(|l| l.irradiance).sum::<Rgb>() / (4.0 * PI);
        self
    }

    /// Whether there is no light.
    pub fn is_dark(&self) -> bool {
        let has_light = self.strength() > 0.0;
        !has_light
    }

    /// Luminance of the irradiance on a surface that faces all lamps, W/m².
    pub(super) fn strength(&self) -> f64 {
        let lamps: Rgb = self.lamps.iter().map(|l| l.irradiance).sum();
        (lamps + self.ambient * PI).luminance()
    }
}

fn y_up(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.z, -v.y)
}

/// Light from an object at a point: area over squared distance, summed over its parts.
#[derive(Default)]
struct LampSum {
    irradiance: Rgb,
    /// Directions weighted with solid angles.
    toward: DVec3,
    /// Solid angle, sr.
    angle: f64,
}

impl LampSum {
    /// Adds an area of solid angle `angle`, sr.
    fn add(&mut self, toward: DVec3, angle: f64, radiance: Rgb) {
        self.irradiance += radiance * angle;
        self.toward += toward * angle;
        self.angle += angle;
    }

    fn lamp(self) -> Option<PreviewLamp> {
        let toward = self.toward.try_normalize()?;
        let cos = 1.0 - self.angle.min(TAU) / TAU;
        Some(PreviewLamp {
            toward,
            irradiance: self.irradiance,
            half_angle: cos.acos(),
        })
    }
}

fn emitter(scene: &Scene, object: &Object, at: DVec3) -> Option<PreviewLamp> {
    let material = |id: u32| scene.materials.get(id as usize).filter(|m| m.is_emitter());
    let mut sum = LampSum::default();
    if let Some(mesh) = object.shape.placed_mesh() {
        for (face, &id) in mesh.mesh.face_materials.iter().enumerate() {
            let Some(material) = material(id) else {
                continue;
            };
            let corners = mesh.face_positions(face);
            let centre = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
            flat(&mut sum, centre - at, mesh.face_area_vector(face), material);
        }
    }
    match &object.shape {
        Shape::Mesh(_) | Shape::Instance(_) => {}
        Shape::Primitive(p) if p.kind == PrimitiveKind::Square => {
            let place = p.world_from_object;
            let area = place.matrix3.x_axis.cross(place.matrix3.y_axis);
            let centre = place.transform_point3(DVec3::new(0.5, 0.5, 0.0));
            flat(&mut sum, centre - at, area, material(p.material)?);
        }
        Shape::Primitive(p) => round(&mut sum, object, at, material(p.material)?),
        Shape::Exact(exact) => {
            let leaves = exact.leaves();
            let shining = leaves.iter().find_map(|l| material(l.material()))?;
            round(&mut sum, object, at, shining);
        }
    }
    sum.lamp()
}

/// Adds a flat part at `away` relative to the point; the length of `area` is its area.
fn flat(sum: &mut LampSum, away: DVec3, area: DVec3, material: &Material) {
    let square = away.length_squared().max(area.length() / TAU);
    let toward = away.normalize_or(DVec3::Y);
    let facing = -toward.dot(area);
    if facing > 0.0 || material.emits_back {
        sum.add(
            toward,
            facing.abs() / square.max(f64::MIN_POSITIVE),
            material.emission,
        );
    }
}

/// Adds a body about as wide as its bounding box.
fn round(sum: &mut LampSum, object: &Object, at: DVec3, material: &Material) {
    let bounds = object.bounds();
    let radius = bounds.diagonal() / 12f64.sqrt();
    let away = bounds.centre() - at;
    let square = away.length_squared().max(radius * radius);
    let angle = PI * radius * radius / square.max(f64::MIN_POSITIVE);
    sum.add(away.normalize_or(DVec3::Y), angle, material.emission);
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::{Mesh, Primitive};
    use glam::DAffine3;

    fn light(kind: LightKind) -> Light {
        Light {
            name: String::new(),
            kind,
        }
    }

    #[test]
    fn lights_fall_with_the_square_of_the_distance() {
        let position = DVec3::new(0.0, 2.0, 0.0);
        let point = LightKind::Point {
            position,
            intensity: Rgb::grey(8.0),
        };
        let sky = LightKind::Ambient {
            radiance: Rgb::grey(0.5),
        };
        let scene = Scene {
            lights: vec![light(point), light(sky)],
            ..Scene::default()
        };
        let light = PreviewLight::of_scene(&scene, DVec3::ZERO);
        let lamp = PreviewLamp {
            toward: DVec3::Y,
            irradiance: Rgb::grey(2.0),
            half_angle: 0.0,
        };
        assert_eq!(
            light,
            PreviewLight {
                lamps: vec![lamp],
                ambient: Rgb::grey(0.5)
            }
        );
        assert!(
            !light.is_dark() && PreviewLight::of_scene(&Scene::default(), DVec3::ZERO).is_dark()
        );
    }

    /// A square of side 1, 10 above the point, facing down, as a primitive or a mesh.
    fn under(shape: Shape, up: Up) -> PreviewLight {
        let mut scene = Scene {
            objects: vec![Object::new("lamp", shape)],
            ..Scene::default()
        };
        scene.units.up = up;
        scene.add_material(Material::emitter("", Rgb::grey(50.0)));
        PreviewLight::of_scene(&scene, DVec3::new(0.5, 0.0, 0.5))
    }

    #[test]
    fn areas_shine_as_their_solid_angle_says() {
        let place =
            DAffine3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y, DVec3::new(0.0, 10.0, 0.0));
        let square = Primitive {
            kind: PrimitiveKind::Square,
            world_from_object: place,
            material: 0,
            light: None,
        };
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut mesh = Mesh {
            positions: corners.map(|[x, z]| DVec3::new(x, 10.0, z)).to_vec(),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], 0);
        for shape in [Shape::Primitive(square), Shape::Mesh(mesh)] {
            let light = under(shape.clone(), Up::Y);
            let [lamp] = light.lamps[..] else {
                panic!("{light:?}")
            };
            assert!((lamp.irradiance.r - 0.5).abs() < 1e-3, "{lamp:?}");
            assert!((lamp.toward - DVec3::Y).length() < 1e-9);
            // Where z is up, what is along y is in front.
            let turned = under(shape, Up::Z).lamps[0].toward;
            assert!((turned - DVec3::NEG_Z).length() < 1e-9);
        }
    }

    #[test]
    fn what_is_not_kept_as_a_lamp_becomes_ambient() {
        let sun = |irradiance| {
            light(LightKind::Directional {
                direction: DVec3::NEG_Y,
                irradiance: Rgb::grey(irradiance),
                half_angle: 0.0,
            })
        };
        let lights = (1..=8).map(|k| sun(f64::from(k))).collect();
        let light = PreviewLight::of_scene(
            &Scene {
                lights,
                ..Scene::default()
            },
            DVec3::ZERO,
        );
        assert_eq!(
            (light.lamps.len(), light.lamps[0].irradiance.r),
            (MAX_LAMPS, 8.0)
        );
        assert!((light.ambient.r - 3.0 / (4.0 * PI)).abs() < 1e-12);
    }
}
