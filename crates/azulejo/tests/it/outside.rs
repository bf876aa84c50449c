//! Light from outside in pictures: both passes against the reference, and what the camera sees.

use azulejo::radiosity::{FirstPass, solve};
use azulejo::render::{
    FinalGather, ReferencePass, SecondPass, radiance, reference, reference_radiance, render,
};
use azulejo::scene::brdf::Description;
use azulejo::scene::math::Ray;
use azulejo::scene::sky::{Sky, direction_from};
use azulejo::scene::{
    Backplate, BackplateFit, Brdf, Camera, Environment, Image, Light, LightKind, Material, Mesh,
    Object, Primitive, Rgb, Scene, SceneBackground, Shape, Texture, Up,
};
use azulejo::trace::{Progress, Tracer};
use glam::DVec3;
use std::sync::Arc;

fn polygon(scene: &mut Scene, positions: [DVec3; 4], material: u32) {
    let mut mesh = Mesh {
        positions: positions.to_vec(),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
}

fn camera(eye: DVec3, target: DVec3, degrees: f64) -> Camera {
    Camera {
        name: String::new(),
        eye,
        target,
        up: DVec3::Y,
        vertical_fov: degrees.to_radians(),
        size: None,
    }
}

fn light(scene: &mut Scene, kind: LightKind) {
    let name = String::new();
    scene.lights.push(Light { name, kind });
}

/// A clear sky with its sun in the south.
fn daylight(scene: &mut Scene) {
    let toward = direction_from(std::f64::consts::PI, 0.7);
    let sky = Sky::cie(12, toward, 3.0).unwrap().with_ground(0.2, 5.0);
    light(
        scene,
        LightKind::Environment(Environment::sky(sky, Up::Z, 0.0)),
    );
    light(
        scene,
        LightKind::Directional {
            direction: -toward,
            irradiance: Rgb::new(8.0, 7.0, 6.0),
            half_angle: 0.02,
        },
    );
}

/// A floor, glossy or not, with a mirror ball and a wall.
fn yard(floor: Material) -> Scene {
    let mut scene = Scene::default();
    scene.units.up = Up::Z;
    let floor = scene.add_material(floor);
    let wall = scene.add_material(Material::diffuse("wall", Rgb::new(0.7, 0.5, 0.3)));
    let mirror = scene.add_material(Material::mirror("mirror", Rgb::grey(0.9)));
    let square = [(-6.0, -6.0), (6.0, -6.0), (6.0, 6.0), (-6.0, 6.0)];
    polygon(
        &mut scene,
        square.map(|(x, y)| DVec3::new(x, y, 0.0)),
        floor,
    );
    let upright = [(-6.0, 0.0), (6.0, 0.0), (6.0, 4.0), (-6.0, 4.0)];
    polygon(
        &mut scene,
        upright.map(|(x, z)| DVec3::new(x, 2.0, z)),
        wall,
    );
    let ball = Primitive::sphere(DVec3::new(1.5, 0.0, 1.0), 0.9, mirror);
    scene
        .objects
        .push(Object::new("ball", Shape::Primitive(ball)));
    daylight(&mut scene);
    scene
}

/// Both passes and the reference see the same along rays to several places.
fn check(mut scene: Scene, rays: &[(DVec3, DVec3)]) {
    let given = scene.clone();
    let tracer = Tracer::new(&given);
    let progress = Progress::new();
    let first = FirstPass {
        error: Some(0.01),
        ..FirstPass::default()
    };
    let solved = solve(&given, &tracer, &first, &progress).unwrap();
    scene.set_irradiance(solved.irradiance);
    let rays: Vec<Ray> = rays
        .iter()
        .map(|&(from, to)| Ray::new(from, (to - from).normalize()))
        .collect();
    let share = if azulejo_testing::is_thorough() { 1 } else { 4 };
    let second = SecondPass {
        samples_per_pixel: 1024 / share,
        gather: FinalGather::Everywhere(64),
        ..SecondPass::default()
    };
    let options = ReferencePass {
        samples_per_pixel: 16_384 / share,
        ..ReferencePass::default()
    };
    let again = Tracer::new(&scene);
    let seen = radiance(&scene, &again, &rays, &second, &progress).unwrap();
    let truth = reference_radiance(&given, &tracer, &rays, &options, &progress).unwrap();
    for ((seen, (truth, error)), ray) in seen.iter().zip(&truth).zip(&rays) {
        for k in 0..3 {
            let margin = 4.0 * error[k] + 0.02 * truth[k];
            assert!(
                (seen[k] - truth[k]).abs() < margin,
                "{ray:?}: {seen:?}, {truth:?} ± {error:?}"
            );
        }
    }
}

fn places() -> Vec<(DVec3, DVec3)> {
    let eye = DVec3::new(0.0, -8.0, 3.0);
    [
        DVec3::new(-2.0, -2.0, 0.0),
        DVec3::new(-1.0, 1.5, 0.0),
        DVec3::new(-2.0, 2.0, 2.0),
        // The ball, which shows the yard and the sky.
        DVec3::new(1.5, 0.0, 1.0),
        DVec3::new(1.2, 0.0, 1.6),
    ]
    .map(|to| (eye, to))
    .to_vec()
}

#[test]
fn passes_and_reference_agree_by_daylight() {
    check(yard(Material::diffuse("floor", Rgb::grey(0.5))), &places());
}

#[test]
fn glossy_floors_show_sky_and_sun() {
    for model in ["phong kd=0.3 ks=0.5 n=40", "phong kd=0.2 ks=0.6 n=5000"] {
        let description: Description = model.parse().unwrap();
        let brdf = Arc::new(Brdf::new(description).unwrap());
        check(yard(Material::with_brdf("floor", brdf)), &places());
    }
}

/// A room with a tinted window to the south, through which the sun falls on the floor.
fn room_with_a_window(floor: Material) -> Scene {
    let mut scene = Scene::default();
    scene.units.up = Up::Z;
    let floor = scene.add_material(floor);
    let walls = scene.add_material(Material::diffuse("walls", Rgb::new(0.6, 0.5, 0.4)));
    let mut pane = Material::pane("pane", 1.5);
    pane.dielectric.as_mut().unwrap().transmittance = Rgb::new(0.7, 0.9, 0.8);
    let pane = scene.add_material(pane);
    let level = |z: f64| {
        [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(|(x, y)| DVec3::new(x, y, z))
    };
    polygon(&mut scene, level(0.0), floor);
    polygon(&mut scene, level(3.0), walls);
    // A part of a wall, from one place on the ground to another, between two heights.
    let upright = |scene: &mut Scene, from: (f64, f64), to: (f64, f64), z: (f64, f64), material| {
        let corners = [(from, z.0), (to, z.0), (to, z.1), (from, z.1)];
        let corners = corners.map(|((x, y), z)| DVec3::new(x, y, z));
        polygon(scene, corners, material);
    };
    upright(&mut scene, (2.0, -2.0), (2.0, 2.0), (0.0, 3.0), walls);
    upright(&mut scene, (2.0, 2.0), (-2.0, 2.0), (0.0, 3.0), walls);
    upright(&mut scene, (-2.0, 2.0), (-2.0, -2.0), (0.0, 3.0), walls);
    for (x, z, material) in [
        ((-2.0, 2.0), (0.0, 1.0), walls),
        ((-2.0, 2.0), (2.5, 3.0), walls),
        ((-2.0, -1.0), (1.0, 2.5), walls),
        ((1.0, 2.0), (1.0, 2.5), walls),
        ((-1.0, 1.0), (1.0, 2.5), pane),
    ] {
        upright(&mut scene, (x.0, -2.0), (x.1, -2.0), z, material);
    }
    daylight(&mut scene);
    scene
}

/// Places on the floor in the sun and out of it, a wall and the ceiling, from within and from outside.
#[test]
fn the_sun_falls_through_windows() {
    let (within, outside) = (DVec3::new(1.5, 1.5, 1.6), DVec3::new(0.5, -6.0, 2.0));
    let places = [
        (within, DVec3::new(0.0, 0.5, 0.0)),
        (within, DVec3::new(-1.7, -1.7, 0.0)),
        (within, DVec3::new(-2.0, 0.3, 1.5)),
        (within, DVec3::new(0.0, 0.0, 3.0)),
        (outside, DVec3::new(-0.4, 0.0, 0.0)),
        (outside, DVec3::new(0.2, 2.0, 1.7)),
    ];
    let gloss: Description = "phong kd=0.3 ks=0.5 n=40".parse().unwrap();
    let gloss = Arc::new(Brdf::new(gloss).unwrap());
    let matt = Material::diffuse("floor", Rgb::grey(0.5));
    check(room_with_a_window(matt), &places);
    let glossy = Material::with_brdf("floor", gloss);
    check(room_with_a_window(glossy), &places[..2]);
}

/// Where there is nothing, a camera sees the sky, or the background instead, in both renderers.
#[test]
fn a_camera_sees_the_sky_and_its_sun_or_the_background() {
    let mut scene = yard(Material::diffuse("floor", Rgb::grey(0.5)));
    let above = DVec3::new(0.0, -8.0, 9.0);
    let toward = direction_from(std::f64::consts::PI, 0.7);
    let up = (above, above + DVec3::new(0.3, 0.2, 1.0));
    let into_sun = (above, above + toward);
    let LightKind::Environment(sky) = scene.lights[0].kind else {
        unreachable!("the sky comes first")
    };
    let expected = sky.radiance((up.1 - up.0).normalize(), None);
    let along = |scene: &Scene| {
        let rays = [up, into_sun].map(|(from, to)| Ray::new(from, (to - from).normalize()));
        let (tracer, progress) = (Tracer::new(scene), Progress::new());
        radiance(scene, &tracer, &rays, &SecondPass::default(), &progress).unwrap()
    };
    let found = along(&scene);
    assert!((found[0].g / expected.g - 1.0).abs() < 1e-5, "{found:?}");
    let disc = 7.0 / (std::f64::consts::PI * 0.02f64.sin().powi(2));
    assert!(
        found[1].g > disc && found[1].g < 1.01 * disc,
        "{found:?}, {disc}"
    );
    let flipped = Environment::sky(Sky::uniform(4.0), Up::Z, 0.0);
    for (background, expected) in [
        (SceneBackground::Color(Rgb::new(0.0, 0.5, 1.0)), 0.5),
        (SceneBackground::Environment(flipped), 4.0),
    ] {
        scene.background = Some(background);
        let seen = along(&scene);
        assert!(seen.iter().all(|s| s.g == expected), "{seen:?}");
        let tracer = Tracer::new(&scene);
        let eye = camera(above, above + DVec3::Z + 0.1 * DVec3::Y, 20.0);
        let one = ReferencePass {
            size: (2, 2),
            samples_per_pixel: 2,
            ..ReferencePass::default()
        };
        let image = reference(&scene, &tracer, &eye, &one, &Progress::new()).unwrap();
        assert!(
            image
                .image
                .pixels
                .iter()
                .all(|p| f64::from(p[1]) == expected)
        );
    }
}

/// A backplate fills the image in its corners, in both renderers; mirrors show it where they lead back
/// into the image, and what is outside elsewhere.
#[test]
fn a_backplate_fills_the_image_behind_the_scene() {
    let [red, green, blue, white] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]];
    let picture = Image::opaque(2, 2, vec![red, green, blue, white]);
    let ambient = LightKind::Ambient {
        radiance: Rgb::grey(0.125),
    };
    let scene = |mirror: bool| {
        let mut scene = Scene::default();
        scene.textures.push(Texture {
            image: Some(picture.clone()),
            ..Texture::default()
        });
        scene.background = Some(SceneBackground::Backplate(Backplate {
            texture: 0,
            fit: BackplateFit::Scaled,
            radiance: 4.0,
        }));
        scene.lights.push(Light {
            name: String::new(),
            kind: ambient.clone(),
        });
        if mirror {
            let id = scene.add_material(Material {
                mirror: Rgb::WHITE,
                ..Material::default()
            });
            // Across the view: it leads everything back behind the camera.
            let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
            polygon(&mut scene, corners.map(|(x, y)| DVec3::new(x, y, -1.0)), id);
        }
        scene.validate().unwrap();
        scene
    };
    let eye = camera(DVec3::ZERO, -DVec3::Z, 60.0);
    let size = (2, 2);
    for mirror in [false, true] {
        let scene = scene(mirror);
        let tracer = Tracer::new(&scene);
        let options = SecondPass {
            size,
            samples_per_pixel: 64,
            ..SecondPass::default()
        };
        let seen = render(&scene, &tracer, &eye, &options, &Progress::new()).unwrap();
        let options = ReferencePass {
            size,
            samples_per_pixel: 64,
            ..ReferencePass::default()
        };
        let traced = reference(&scene, &tracer, &eye, &options, &Progress::new()).unwrap();
        for image in [seen, traced.image] {
            let pixels: Vec<[f32; 3]> = image.pixels;
            if mirror {
                assert!(pixels.iter().flatten().all(|&c| c == 0.125), "{pixels:?}");
                continue;
            }
            // The corners of the picture dominate those of the image.
            assert!(pixels[0][0] > 2.0 && pixels[0][1] < 1.0, "{pixels:?}");
            assert!(pixels[1][1] > 2.0 && pixels[1][0] < 1.0, "{pixels:?}");
            assert!(pixels[2][2] > 2.0 && pixels[2][0] < 1.0, "{pixels:?}");
            assert!(pixels[3].iter().all(|&c| c > 2.0), "{pixels:?}");
        }
    }
}

/// The same bits whatever the number of threads.
#[test]
fn daylight_does_not_depend_on_threads() {
    let scene = yard(Material::diffuse("floor", Rgb::grey(0.5)));
    let picture = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let tracer = Tracer::new(&scene);
            let options = SecondPass {
                size: (24, 16),
                samples_per_pixel: 2,
                gather: FinalGather::Everywhere(8),
                ..SecondPass::default()
            };
            let eye = camera(DVec3::new(0.0, -8.0, 3.0), DVec3::Z, 50.0);
            render(&scene, &tracer, &eye, &options, &Progress::new()).unwrap()
        })
    };
    assert_eq!(picture(1), picture(3));
}
