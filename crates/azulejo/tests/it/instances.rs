//! A mesh in many places is lit and seen as its copies are.

use azulejo::factors::PatchSize;
use azulejo::radiosity::{Engine, FirstPass, solve};
use azulejo::render::{ReferencePass, SecondPass, radiance, reference_radiance};
use azulejo::scene::math::Ray;
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{
    Attribute, Image, Material, Mesh, Object, Opacity, OpacityChannel, OpacityMode, OpacityPicture,
    Relief, ReliefKind, Rgb, Scene, Shape, SharedMesh, Texture,
};
use azulejo::trace::{Progress, Tracer};
use glam::{DAffine3, DQuat, DVec2, DVec3};

/// A pyramid of four sides around the z axis, with texture coordinates and normals that lean outward.
fn pyramid(materials: [u32; 4]) -> Mesh {
    let base = [DVec3::NEG_X, DVec3::NEG_Y, DVec3::X, DVec3::Y];
    let mut mesh = Mesh::default();
    let (mut normals, mut uvs) = (Vec::new(), Vec::new());
    for (k, material) in materials.into_iter().enumerate() {
        let corners = [base[k], base[(k + 1) % 4], 1.5 * DVec3::Z];
        let first = mesh.positions.len() as u32;
        let outward = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize();
        for (corner, uv) in corners
            .into_iter()
            .zip([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]])
        {
            mesh.positions.push(corner);
            normals.push((outward + 0.3 * corner.normalize()).normalize());
            uvs.push(DVec2::from_array(uv));
        }
        mesh.push_face(&[first, first + 1, first + 2], material);
    }
    mesh.normals = Some(Attribute::per_vertex(normals));
    mesh.uvs = Some(Attribute::per_vertex(uvs));
    mesh
}

/// A picture of stripes; its alpha has holes.
fn stripes() -> Image {
    let pixel = |k: u32| {
        let (x, y) = (k % 16, k / 16);
        [0.2 + 0.6 * f32::from(x % 4 < 2), 0.5, 0.1 + 0.05 * y as f32]
    };
    let mut image = Image::opaque(16, 16, (0..256).map(pixel).collect());
    image.alpha = Some((0..256).map(|k| f32::from((k / 32) % 2 == 0)).collect());
    image
}

/// The Cornell box with pyramids: textured, with holes, of gloss, of relief, and lamps; each stands
/// somewhere else, stretched and mirrored.
fn garden() -> Scene {
    let mut scene = cornell_box(CornellVariant::Diffuse);
    scene.textures.push(Texture {
        path: "stripes.png".into(),
        image: Some(stripes()),
        ..Texture::default()
    });
    let plain = scene.add_material(Material::diffuse("plain", Rgb::new(0.7, 0.5, 0.3)));
    let picture = scene.add_material(Material {
        textures: vec![0],
        ..Material::diffuse("picture", Rgb::WHITE)
    });
    let holes = scene.add_material(Material {
        opacity: Some(Opacity {
            constant: 1.0,
            picture: Some(OpacityPicture {
                texture: 0,
                channel: OpacityChannel::Alpha,
            }),
            mode: OpacityMode::Mask { cutoff: 0.5 },
        }),
        ..Material::diffuse("holes", Rgb::grey(0.6))
    });
    let relief = scene.add_material(Material {
        relief: Some(Relief {
            texture: 0,
            kind: ReliefKind::Normals { scale: 0.5 },
        }),
        ..Material::diffuse("relief", Rgb::grey(0.8))
    });
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::new(3.0, 4.0, 6.0)));
    let screen = scene.add_material(Material {
        emission_picture: Some(0),
        ..Material::emitter("screen", Rgb::grey(4.0))
    });
    let mut shared = SharedMesh::new(pyramid([plain, picture, holes, relief]));
    let mut lamps = SharedMesh::new(pyramid([lamp, plain, screen, plain]));
    let place = |at: [f64; 3], size: [f64; 3], turn: f64| {
        let turn = DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(-1.2);
        DAffine3::from_scale_rotation_translation(DVec3::from(size), turn, DVec3::from(at))
    };
    let places = [
        place([150.0, 60.0, 100.0], [60.0, 60.0, 60.0], 0.3),
        place([400.0, 200.0, 80.0], [90.0, 40.0, 60.0], 2.0),
        place([100.0, 400.0, 250.0], [-50.0, 50.0, 80.0], 4.0),
        place([280.0, 250.0, 60.0], [30.0, -80.0, -60.0], 1.0),
    ];
    for placed in places.map(|p| shared.placed(p).unwrap()) {
        scene
            .objects
            .push(Object::new("pyramid", Shape::Instance(placed)));
    }
    let places = [
        place([450.0, 420.0, 100.0], [30.0, 20.0, 10.0], 0.5),
        place([300.0, 400.0, 50.0], [-10.0, 25.0, 30.0], 1.5),
    ];
    for placed in places.map(|p| lamps.placed(p).unwrap()) {
        scene
            .objects
            .push(Object::new("lamp", Shape::Instance(placed)));
    }
    scene.validate().unwrap();
    scene
}

/// From the camera to a grid of points.
fn rays() -> Vec<Ray> {
    let eye = DVec3::new(278.0, 273.0, -800.0);
    let to = |k: u32| {
        let (x, y) = (f64::from(k % 6), f64::from(k / 6));
        DVec3::new(40.0 + 95.0 * x, 40.0 + 95.0 * y, 0.0)
    };
    (0..36)
        .map(|k| Ray::new(eye, (to(k) - eye).normalize()))
        .collect()
}

/// Irradiance of all vertices of meshes, with standard errors.
fn irradiances(scene: &Scene) -> Vec<(Rgb, Rgb)> {
    let meshes = scene.objects.iter().filter_map(|o| o.shape.placed_mesh());
    meshes
        .flat_map(|m| {
            let pairs = m.irradiance.iter().zip(m.irradiance_error);
            pairs.map(|(e, s)| (*e, *s)).collect::<Vec<_>>()
        })
        .collect()
}

fn assert_alike(a: &[(Rgb, Rgb)], b: &[(Rgb, Rgb)]) {
    assert_eq!(a.len(), b.len());
    assert!(!a.is_empty());
    for (k, ((a, s), (b, t))) in a.iter().zip(b).enumerate() {
        for c in 0..3 {
            let margin = 5.0 * s[c].hypot(t[c]) + 0.01 * b[c];
            assert!(
                (a[c] - b[c]).abs() <= margin,
                "{k}: {a:?} ± {s:?}, {b:?} ± {t:?}"
            );
        }
    }
}

#[test]
fn both_passes_and_the_reference_see_instances_as_their_copies() {
    let shared = garden();
    let copies = shared.unfolded().into_owned();
    let progress = Progress::new();
    let truths = [&shared, &copies].map(|scene| {
        let pass = ReferencePass {
            samples_per_pixel: 256,
            ..ReferencePass::default()
        };
        reference_radiance(scene, &Tracer::new(scene), &rays(), &pass, &progress).unwrap()
    });
    assert_alike(&truths[0], &truths[1]);
    for engine in [Engine::default(), Engine::Particles] {
        let solved = [&shared, &copies].map(|scene| {
            let pass = FirstPass {
                engine: engine.clone(),
                rays: Some(512),
                size: PatchSize::Count(800),
                keep_mesh: true,
                ..FirstPass::default()
            };
            let found = solve(scene, &Tracer::new(scene), &pass, &progress).unwrap();
            let mut lit = scene.clone();
            lit.set_irradiance(found.irradiance);
            lit.validate().unwrap();
            lit
        });
        assert!(solved[0].has_instances());
        assert_alike(&irradiances(&solved[0]), &irradiances(&solved[1]));
        let seen = solved.map(|scene| {
            let pass = SecondPass {
                samples_per_pixel: 256,
                ..SecondPass::default()
            };
            let tracer = Tracer::new(&scene);
            radiance(&scene, &tracer, &rays(), &pass, &progress).unwrap()
        });
        for (k, (a, b)) in seen[0].iter().zip(&seen[1]).enumerate() {
            let off = (*a - *b).map(f64::abs).max_channel();
            assert!(off <= 0.1 * b.max_channel() + 1e-3, "ray {k}: {a:?} {b:?}");
        }
    }
}
