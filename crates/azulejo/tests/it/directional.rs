//! Where the light of lightmaps comes from, beside light on surfaces that are tilted.

use crate::lightmap::{baked, options};
use azulejo::lightmap::{BakeOptions, Baked, BakedLight, BakedSides, bake, direction_errors};
use azulejo::scene::harmonics::{SunAndSky, Y00, Y1};
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{Material, Mesh, Object, Rgb, Scene, Shape, Up};
use azulejo::trace::{Progress, Tracer};
use glam::{DQuat, DVec3};

fn directional(light: BakedLight, size: u32) -> BakeOptions {
    BakeOptions {
        is_directional: true,
        light,
        sides: BakedSides::Front,
        ..options(size, 0.01)
    }
}

/// A lit room with a small plate in its middle, whose normal this is: the last object.
fn room_with_plate(normal: DVec3) -> Scene {
    let mut scene = cornell_box(CornellVariant::Diffuse);
    let bounds = scene.bounds();
    let centre = 0.5 * (bounds.min + bounds.max);
    let half = 0.01 * bounds.diagonal();
    let turn = DQuat::from_rotation_arc(DVec3::Z, normal);
    let corner = |x: f64, y: f64| centre + turn * (half * DVec3::new(x, y, 0.0));
    let corners = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    let material = scene.add_material(Material::diffuse("plate", Rgb::grey(0.5)));
    let mut mesh = Mesh {
        positions: corners.to_vec(),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    scene.objects.push(Object::new("plate", Shape::Mesh(mesh)));
    scene
}

/// The mean irradiance of the plate, and the mean coefficients of the radiance above it.
fn plate(normal: DVec3, light: BakedLight) -> (Rgb, [Rgb; 4]) {
    let scene = room_with_plate(normal);
    let object = scene.objects.len() as u32 - 1;
    let options = directional(light, 8);
    let tracer = Tracer::new(&scene);
    let baked = bake(&scene, &tracer, &[object], &options, &Progress::new()).unwrap();
    let harmonics = baked.harmonics.as_ref().unwrap();
    (
        baked.lightmap.mean(),
        harmonics.each_ref().map(|lightmap| lightmap.mean()),
    )
}

/// The irradiance of a tilted normal by what is known of light above another, per channel.
fn tilted(irradiance: Rgb, coefficients: [Rgb; 4], normal: DVec3, tilted: DVec3) -> Rgb {
    let of_channel = |c: usize| {
        let [l00, y, z, x] = coefficients.map(|coefficient| coefficient[c]);
        let vector = DVec3::new(x, y, z) / Y1;
        let light = SunAndSky::new(vector / (l00 / Y00), normal);
        irradiance[c] * light.irradiance(tilted, normal) / light.irradiance(normal, normal)
    };
    Rgb::from([0, 1, 2].map(of_channel))
}

/// The difference of two values over the second, per channel.
fn relative(found: Rgb, truth: Rgb) -> Rgb {
    Rgb::from([0, 1, 2].map(|c| found[c] / truth[c] - 1.0))
}

/// Directions show the irradiance of a surface that is tilted by 15° within 5% of what it is when it is baked so.
#[test]
fn tilted_normals_have_the_light_of_tilted_surfaces() {
    for light in [BakedLight::Total, BakedLight::Direct] {
        let up = match cornell_box(CornellVariant::Diffuse).units.up {
            Up::Y => DVec3::Y,
            Up::Z => DVec3::Z,
        };
        // Not towards the lamp, so that tilts matter.
        let normal = (up + DVec3::new(0.5, 0.3, 0.2)).normalize();
        let (irradiance, coefficients) = plate(normal, light);
        let beside = normal.any_orthonormal_vector();
        for axis in [beside, -beside, normal.cross(beside)] {
            let other = DQuat::from_axis_angle(axis, 15_f64.to_radians()) * normal;
            let (truth, _) = plate(other, light);
            let found = tilted(irradiance, coefficients, normal, other);
            let off = relative(found, truth);
            assert!(
                off.map(f64::abs).max_channel() < 0.05,
                "{light:?}: {found:?} {truth:?}"
            );
            // Without directions it would be off by more.
            let flat = relative(irradiance, truth);
            assert!(light != BakedLight::Direct || flat.mean().abs() > 2.0 * off.mean().abs());
        }
    }
}

/// Directions of parts of the light add up.
#[test]
fn directions_of_parts_add_up() {
    let parts = [BakedLight::Total, BakedLight::Direct, BakedLight::Indirect];
    let [whole, direct, indirect] = parts.map(|light| plate(DVec3::X, light).1);
    let scale = whole[0].mean();
    for k in 0..4 {
        let off = (whole[k] - direct[k] - indirect[k]) / scale;
        assert!(off.map(f64::abs).max_channel() < 0.02, "{k}: {off:?}");
    }
}

/// The component of the vector irradiance along the normal is the irradiance, at every texel.
#[test]
fn vector_irradiance_is_irradiance_along_the_normal() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let Baked {
        lightmap,
        harmonics,
        atlas,
        ..
    } = baked(&scene, &directional(BakedLight::Total, 64));
    let harmonics = harmonics.unwrap();
    let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
    for (r, receiver) in atlas.receivers.iter().enumerate() {
        let layout = &atlas.layout.receivers[r];
        for t in 0..receiver.triangles.len() {
            let normal = receiver.area_vector(t).normalize();
            let page = layout.pages[t] as usize;
            let uv = [0, 1].map(|k| {
                let of_corners = layout.uvs[t].map(|uv| f64::from(uv[k]));
                of_corners.iter().sum::<f64>() / 3.0
            });
            let [y, z, x] = [1, 2, 3].map(|k| harmonics[k].pages[page].bilinear(uv) / Y1);
            let along = x * normal.x + y * normal.y + z * normal.z;
            let irradiance = lightmap.pages[page].bilinear(uv);
            squares += ((along - irradiance) * (along - irradiance)).mean();
            sum += irradiance.mean();
            count += 1.0;
        }
    }
    let off = f64::sqrt(squares / count) / (sum / count);
    assert!(off < 0.08, "{off}");
    // What is stated of the coefficients is of that size.
    let [radiance, direction] = direction_errors(&harmonics);
    assert!(radiance > 1e-4 && radiance < 0.1, "{radiance}");
    assert!(direction > 1e-4 && direction < 0.2, "{direction}");
}
