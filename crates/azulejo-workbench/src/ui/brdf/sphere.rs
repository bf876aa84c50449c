//! A sphere of the material on a tiled floor, rendered progressively in the background.

use super::light::{PreviewLamp, PreviewLight};
use super::reflection::MaterialReflection;
use azulejo::render::{ReferencePass, Tone, reference, tone_map};
use azulejo::scene::{
    Camera, Image, Light, LightKind, Material, Mesh, Object, Primitive, PrimitiveKind, Rgb, Scene,
    Shape,
};
use azulejo::trace::{Cancelled, Progress, Tracer};
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Paths per pixel of successive passes; the images are averaged.
const PASSES: [u32; 6] = [2, 2, 4, 8, 16, 32];

/// Distance of the lamps in radii of the sphere.
const LAMP_DISTANCE: f64 = 40.0;

/// Range of half the apparent angle of lamps, radians: a point would be invisible in a mirror, and
/// a distant square cannot fill the sky.
const ANGLES: [f64; 2] = [0.035, 0.8];

/// Identifies an image of the sphere.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SphereKey {
    optics: MaterialReflection,
    emission: Rgb,
    light: PreviewLight,
    /// Width and height, pixels.
    side: u32,
}

/// An image of the sphere.
#[derive(Clone, Debug)]
pub(super) struct SphereImage {
    /// Width and height, pixels.
    pub side: usize,
    /// sRGB, rows from the top.
    pub rgb: Vec<u8>,
    /// Paths per pixel so far.
    pub samples: u32,
}

impl SphereKey {
    /// Without any light, that of a studio is used.
    pub fn new(material: &Material, light: &PreviewLight, side: u32) -> SphereKey {
        let light = if light.is_dark() {
            PreviewLight::studio()
        } else {
            light.clone()
        };
        SphereKey {
            optics: MaterialReflection::of(material),
            emission: material.emission,
            light,
            side,
        }
    }
}

/// Renders the sphere.
pub(super) fn draw(
    key: &SphereKey,
    progress: &Progress,
    show: &mut dyn FnMut(SphereImage),
) -> Result<(), Cancelled> {
    draw_passes(key, &PASSES, progress, show)
}

/// Renders the sphere in passes of the given numbers of paths per pixel.
pub(super) fn draw_passes(
    key: &SphereKey,
    passes: &[u32],
    progress: &Progress,
    show: &mut dyn FnMut(SphereImage),
) -> Result<(), Cancelled> {
    let scene = scene(key);
    let tracer = Tracer::new(&scene);
    let mut sum = Image::new(key.side, key.side);
    let mut samples = 0;
    for (seed, &count) in (0..).zip(passes) {
        let pass = ReferencePass {
            clamp: None,
            size: (key.side, key.side),
            samples_per_pixel: count,
            seed,
            max_depth: 24,
        };
        let pass = reference(&scene, &tracer, &camera(), &pass, progress)?;
        for (sum, value) in sum.pixels.iter_mut().zip(&pass.image.pixels) {
            (0..3).for_each(|c| sum[c] += value[c] * count as f32);
        }
        samples += count;
        // A white surface that faces all lamps is nearly white.
        let exposure = 1.1 * PI / key.light.strength() / f64::from(samples);
        show(SphereImage {
            side: key.side as usize,
            rgb: tone_map(&sum, exposure, Tone::Filmic),
            samples,
        });
    }
    Ok(())
}

fn camera() -> Camera {
    Camera {
        name: String::new(),
        eye: DVec3::new(0.0, 1.9, 5.6),
        target: DVec3::new(0.0, 0.96, 0.0),
        up: DVec3::Y,
        vertical_fov: 25f64.to_radians(),
        size: None,
    }
}

fn scene(key: &SphereKey) -> Scene {
    let mut scene = Scene::default();
    let tiles =
        [0.55, 0.25].map(|grey| scene.add_material(Material::diffuse("tile", Rgb::grey(grey))));
    let material = scene.add_material(key.material());
    let place = DAffine3::from_translation(DVec3::Y) * DAffine3::from_rotation_x(-FRAC_PI_2);
    let mut add = |name: &str, shape| scene.objects.push(Object::new(name, shape));
    add("sphere", primitive(PrimitiveKind::Sphere, place, material));
    add("floor", Shape::Mesh(floor(tiles)));
    for lamp in &key.light.lamps {
        add_lamp(&mut scene, lamp);
    }
    let radiance = key.light.ambient;
    scene.lights.push(Light {
        name: "sky".to_owned(),
        kind: LightKind::Ambient { radiance },
    });
    scene
}

impl SphereKey {
    fn material(&self) -> Material {
        Material {
            emission: self.emission,
            ..self.optics.material()
        }
    }
}

fn primitive(kind: PrimitiveKind, world_from_object: DAffine3, material: u32) -> Shape {
    Shape::Primitive(Primitive {
        kind,
        world_from_object,
        material,
        light: None,
    })
}

fn floor(tiles: [u32; 2]) -> Mesh {
    const HALF: i32 = 7;
    let mut mesh = Mesh::default();
    for x in -HALF..HALF {
        for z in -HALF..HALF {
            let first = mesh.positions.len() as u32;
            let corners = [[0, 0], [0, 1], [1, 1], [1, 0]];
            let place = |[dx, dz]: [i32; 2]| DVec3::new((x + dx).into(), 0.0, (z + dz).into());
            mesh.positions.extend(corners.map(place));
            let tile = tiles[(x + z).rem_euclid(2) as usize];
            mesh.push_face(&[first, first + 1, first + 2, first + 3], tile);
        }
    }
    mesh
}

/// A square that faces the sphere, with the lamp's radiance.
fn add_lamp(scene: &mut Scene, lamp: &PreviewLamp) {
    let angle = lamp.half_angle.clamp(ANGLES[0], ANGLES[1]);
    let solid = TAU * (1.0 - angle.cos());
    let material = scene.add_material(Material::emitter("lamp", lamp.irradiance / solid));
    let side = LAMP_DISTANCE * solid.sqrt();
    let front = -lamp.toward;
    let across = front.any_orthonormal_vector();
    let matrix = DMat3::from_cols(across * side, front.cross(across) * side, front);
    let corner = DVec3::Y + lamp.toward * LAMP_DISTANCE - 0.5 * (matrix.x_axis + matrix.y_axis);
    let place = DAffine3::from_mat3_translation(matrix, corner);
    let shape = primitive(PrimitiveKind::Square, place, material);
    scene.objects.push(Object::new("lamp", shape));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(material: &Material, light: &PreviewLight) -> SphereImage {
        let (progress, mut image) = (Progress::new(), None);
        let key = SphereKey::new(material, light, 48);
        let stopped = draw(&key, &progress, &mut |picture| {
            image.get_or_insert(picture);
            progress.cancel();
        });
        assert!(stopped.is_err(), "cancelled after its first image");
        image.unwrap()
    }

    /// The centre of the sphere.
    fn middle(picture: &SphereImage) -> [u8; 3] {
        let at = 3 * (picture.side / 2 * picture.side + picture.side / 2);
        [0, 1, 2].map(|c| picture.rgb[at + c])
    }

    #[test]
    fn a_sphere_has_its_colour_under_any_light() {
        let red = Material::diffuse("", Rgb::new(0.7, 0.05, 0.05));
        let mut light = PreviewLight::studio();
        let [r, g, _] = middle(&first(&red, &light));
        assert!(r > 80 && r > 2 * g, "{r} {g}");
        // A thousand times the light gets a thousandth of the exposure.
        light.ambient *= 1000.0;
        light.lamps[0].irradiance *= 1000.0;
        let [bright, _, _] = middle(&first(&red, &light));
        assert!(bright.abs_diff(r) < 4, "{bright} {r}");
    }

    #[test]
    fn what_is_drawn_is_a_valid_scene() {
        let mut light = PreviewLight::studio();
        light.lamps[0].half_angle = 0.0;
        for material in [
            Material::dielectric("", 1.5),
            Material::mirror("", Rgb::WHITE),
        ] {
            let problems = scene(&SphereKey::new(&material, &light, 8)).validate();
            assert!(problems.is_ok(), "{problems:?}");
        }
    }
}
