//! Small scenes whose images can be computed by hand.

use super::*;
use azulejo_scene::rtrace::*;
use azulejo_scene::{
    Attribute, Csg, Exact, Material, Mesh, Object, Operation, Primitive, PrimitiveKind, Rgb, Scene,
    Shape, Solid,
};
use glam::{DAffine3, DVec3};

/// A surface that reflects diffusely.
fn matte(color: Rgb) -> RtraceSurface {
    RtraceSurface {
        color,
        diffuse: Rgb::WHITE,
        phong: 3.0,
        diffuse_factor: Rgb::WHITE,
        ..RtraceSurface::default()
    }
}

/// Seen from (0, 0, 8) toward the origin, so that colours at distance 8 fade to 0.8; the field of
/// view is very narrow.
fn scene(surfaces: Vec<RtraceSurface>, objects: Vec<Shape>) -> Scene {
    let mut scene = Scene::default();
    for _ in &surfaces {
        scene.add_material(Material::diffuse("", Rgb::grey(0.5)));
    }
    let material = |surface| RtraceMaterial {
        surface,
        ior: 1.0,
        ..RtraceMaterial::default()
    };
    scene.objects = objects.into_iter().map(|s| Object::new("", s)).collect();
    scene.rtrace = Some(Box::new(Rtrace {
        eye: DVec3::new(0.0, 0.0, 8.0),
        up: DVec3::Y,
        half_angles: [1e-5; 2],
        background: Rgb::new(0.2, 0.4, 0.6),
        materials: (0..surfaces.len() as u32).map(material).collect(),
        surfaces,
        ..Rtrace::default()
    }));
    scene
}

fn numbers(scene: &mut Scene) -> &mut Rtrace {
    scene.rtrace.as_mut().unwrap()
}

/// A square of side 2 across the z axis.
fn wall(z: f64, material: u32) -> Shape {
    let mut mesh = Mesh {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| DVec3::new(x, y, z))
            .to_vec(),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    Shape::Mesh(mesh)
}

fn lamp(position: DVec3, brightness: f64) -> RtraceLight {
    RtraceLight {
        position,
        brightness: Rgb::grey(brightness),
        fades: [true, true, false],
        kind: RtraceLightKind::Point,
    }
}

fn rendered(scene: &Scene, options: &Options, size: (u32, u32)) -> Image {
    scene.validate().unwrap();
    let rtrace = scene.rtrace.as_ref().unwrap();
    let view = View::of(rtrace, size);
    render(scene, rtrace, &view, options, &Progress::new()).unwrap()
}

/// Checks the colour in the middle of the image.
fn check(scene: &Scene, options: &Options, expected: [f64; 3]) {
    let image = rendered(scene, options, (2, 2));
    let corner = |k: usize| f64::from(image.pixels[0][k]);
    for (k, expected) in expected.into_iter().enumerate() {
        assert!(
            (corner(k) - expected).abs() < 1e-3,
            "channel {k}: {} instead of {expected}",
            corner(k)
        );
    }
}

#[test]
fn light_fades_with_its_way_but_not_with_its_square() {
    let mut scene = scene(vec![matte(Rgb::new(0.5, 1.0, 1.0))], vec![wall(0.0, 0)]);
    numbers(&mut scene).ambient = Rgb::grey(0.25);
    numbers(&mut scene).lights = vec![lamp(DVec3::new(0.0, 0.0, 32.0), 0.5)];
    // The lamp fades to 8 / (8 + 32 / 4), but its blue does not fade.
    let lit = [0.5 * (0.25 + 0.25), 0.25 + 0.25, 0.25 + 0.5];
    for model in [Model::Phong, Model::Strauss] {
        let options = Options {
            model,
            ..Options::default()
        };
        check(&scene, &options, lit.map(|v| 0.8 * v));
    }
    numbers(&mut scene).lights[0].position.z = -32.0;
    check(&scene, &Options::default(), [0.1, 0.2, 0.2]);
}

#[test]
fn what_misses_shows_the_background_as_it_is() {
    let empty = scene(vec![matte(Rgb::WHITE)], vec![]);
    check(&empty, &Options::default(), [0.2, 0.4, 0.6]);
}

#[test]
fn emitters_show_their_colour_by_the_cosine() {
    let mut surface = matte(Rgb::new(0.5, 0.25, 1.0));
    surface.is_emitter = true;
    let mut scene = scene(vec![surface], vec![wall(0.0, 0)]);
    check(&scene, &Options::default(), [0.4, 0.2, 0.8]);
    numbers(&mut scene).eye = DVec3::new(0.0, 8.0 * 0.8, 8.0 * 0.6);
    check(&scene, &Options::default(), [0.24, 0.12, 0.48]);
}

#[test]
fn mirrors_of_plastic_are_coloured_and_of_metal_white() {
    let mut surface = RtraceSurface {
        color: Rgb::new(1.0, 0.5, 0.5),
        specular: Rgb::grey(0.5),
        phong: 3.0,
        ..RtraceSurface::default()
    };
    let phong = Options {
        model: Model::Phong,
        ..Options::default()
    };
    let scene_of = |surface| scene(vec![surface], vec![wall(0.0, 0)]);
    check(&scene_of(surface), &phong, [0.08, 0.08, 0.12]);
    surface.metal = Rgb::WHITE;
    check(&scene_of(surface), &phong, [0.08, 0.16, 0.24]);
    // Strauss's model has it the other way around.
    check(&scene_of(surface), &Options::default(), [0.08, 0.08, 0.12]);
    let cut = Options {
        cut: 0.6,
        ..Options::default()
    };
    check(&scene_of(surface), &cut, [0.0; 3]);
    let shallow = Options {
        depth: 1,
        ..Options::default()
    };
    check(&scene_of(surface), &shallow, [0.0; 3]);
}

#[test]
fn glass_casts_full_shadow_or_filters_once() {
    let glass = RtraceSurface {
        transparency: Rgb::new(0.5, 0.25, 0.0),
        ..matte(Rgb::WHITE)
    };
    let ball = Primitive::sphere(DVec3::new(4.0, 0.0, 4.0), 1.0, 1);
    let mut scene = scene(
        vec![matte(Rgb::WHITE), glass],
        vec![wall(0.0, 0), Shape::Primitive(ball)],
    );
    numbers(&mut scene).lights = vec![lamp(DVec3::new(8.0, 0.0, 8.0), 1.0)];
    let with = |shadows| Options {
        shadows,
        ..Options::default()
    };
    check(&scene, &with(Shadows::Opaque), [0.0; 3]);
    let far = 128f64.sqrt();
    let lit = 0.8 * 0.5f64.sqrt() * 8.0 / (8.0 + 0.25 * far);
    check(
        &scene,
        &with(Shadows::Filtered),
        [0.5 * lit, 0.25 * lit, 0.0],
    );
    numbers(&mut scene).surfaces[0].is_unshadowed = true;
    let blue = 0.8 * 0.5f64.sqrt();
    check(&scene, &with(Shadows::Opaque), [lit, lit, blue]);
}

#[test]
fn lights_shine_through_glass_in_the_last_mode() {
    let glass = RtraceSurface {
        transparency: Rgb::grey(0.5),
        ..matte(Rgb::WHITE)
    };
    let mut scene = scene(vec![glass], vec![wall(0.0, 0)]);
    numbers(&mut scene).background = Rgb::BLACK;
    numbers(&mut scene).lights = vec![lamp(DVec3::new(0.0, 0.0, -8.0), 1.0)];
    let with = |shadows| Options {
        shadows,
        ..Options::default()
    };
    check(&scene, &with(Shadows::Filtered), [0.0; 3]);
    check(&scene, &with(Shadows::Transmitted), [0.64, 0.64, 0.8]);
}

#[test]
fn a_large_light_has_half_shadows_and_a_small_one_has_not() {
    let mut scene = scene(
        vec![matte(Rgb::WHITE)],
        vec![wall(0.0, 0), {
            let map = DAffine3::from_scale_rotation_translation(
                DVec3::new(2.0, 8.0, 0.1),
                glam::DQuat::IDENTITY,
                DVec3::new(0.02, -4.0, 16.0),
            );
            Shape::Primitive(Primitive::new(PrimitiveKind::Cuboid, map, 0))
        }],
    );
    // A wall hides just over half of the lamp.
    let mut light = lamp(DVec3::new(0.0, 0.0, 32.0), 1.0);
    let red = |scene: &Scene| rendered(scene, &Options::default(), (2, 2)).pixels[0][0];
    light.kind = RtraceLightKind::Extended {
        radius: 1.0,
        samples: 32,
    };
    numbers(&mut scene).lights = vec![light];
    assert!((red(&scene) - 0.4 * 0.5).abs() < 0.04, "{}", red(&scene));
    light.kind = RtraceLightKind::Planar {
        edges: [2.0 * DVec3::X, DVec3::ZERO],
        samples: [64, 0],
    };
    numbers(&mut scene).lights = vec![light];
    assert!((red(&scene) - 0.4 * 0.5).abs() < 0.04, "{}", red(&scene));
    light.kind = RtraceLightKind::Extended {
        radius: 0.001,
        samples: 32,
    };
    numbers(&mut scene).lights = vec![light];
    assert!((red(&scene) - 0.4).abs() < 1e-5);
}

#[test]
fn a_box_keeps_the_floor_that_it_shares_with_a_polygon() {
    let (mut red, mut blue) = (
        matte(Rgb::new(1.0, 0.0, 0.0)),
        matte(Rgb::new(0.0, 0.0, 1.0)),
    );
    red.is_emitter = true;
    blue.is_emitter = true;
    for z in [0.0, 0.1, 1.0 / 3.0, 0.7] {
        let map = DAffine3::from_translation(DVec3::new(-0.5, -0.5, z - 1.0));
        let block = Shape::Primitive(Primitive::new(PrimitiveKind::Cuboid, map, 1));
        let shapes = vec![wall(z, 0), block];
        let mut shared = scene(vec![red, blue], shapes);
        numbers(&mut shared).half_angles = [0.01; 2];
        let image = rendered(&shared, &Options::default(), (16, 16));
        assert!(image.pixels.iter().all(|p| p[0] == 0.0 && p[2] > 0.7));
    }
}

#[test]
fn bodies_of_lamps_are_not_there() {
    let mut scene = scene(vec![matte(Rgb::WHITE); 2], vec![wall(1.0, 1)]);
    numbers(&mut scene).materials.pop();
    check(&scene, &Options::default(), [0.2, 0.4, 0.6]);
}

#[test]
fn normals_and_surfaces_run_between_corners() {
    let mut mesh = Mesh {
        positions: vec![
            DVec3::new(-3.0, -1.0, 0.0),
            DVec3::new(3.0, -1.0, 0.0),
            DVec3::new(0.0, 2.0, 0.0),
        ],
        normals: Some(Attribute::per_vertex(vec![
            DVec3::new(-0.6, 0.0, 0.8),
            DVec3::new(0.6, 0.0, 0.8),
            DVec3::Z,
        ])),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2], 0);
    let surfaces = [
        Rgb::new(0.9, 0.0, 0.0),
        Rgb::new(0.0, 0.9, 0.0),
        Rgb::new(0.0, 0.0, 0.9),
    ];
    let mut scene = scene(surfaces.map(matte).to_vec(), vec![Shape::Mesh(mesh)]);
    numbers(&mut scene)
        .corner_surfaces
        .insert(0, vec![[0, 1, 2]]);
    numbers(&mut scene).ambient = Rgb::WHITE;
    // The middle of the image is on the triangle.
    check(&scene, &Options::default(), [0.24; 3]);
    numbers(&mut scene).ambient = Rgb::BLACK;
    numbers(&mut scene).lights = vec![lamp(DVec3::new(6e4, 0.0, 8e4), 1.0)];
    let red = 0.24 * 0.8 * 8.0 / (8.0 + 2.5e4);
    check(&scene, &Options::default(), [red, red, 0.24 * 0.8]);
}

/// A box with rounded normals that all point to one side and up.
fn soft_box(tilt: DVec3) -> Mesh {
    let map = DAffine3::from_translation(DVec3::splat(-0.5));
    let cuboid = Primitive::new(PrimitiveKind::Cuboid, map, 1);
    let mut mesh = cuboid.tessellate(&cuboid.grids(1.0, f64::INFINITY));
    let normals = &mut mesh.normals.as_mut().unwrap().values;
    normals
        .iter_mut()
        .for_each(|n| *n = (*n + tilt).normalize());
    mesh
}

#[test]
fn what_is_cut_away_leaves_its_surface_and_its_normals() {
    let mut paint = matte(Rgb::new(1.0, 0.5, 0.0));
    paint.is_emitter = true;
    let cut = |hole: Solid| {
        let block = Primitive::sphere(DVec3::ZERO, 1.0, 0);
        let csg = Csg {
            operation: Operation::Difference,
            left: vec![Solid::Primitive(block)],
            right: vec![hole],
        };
        Shape::Exact(Exact::new(vec![Solid::Csg(Box::new(csg))]))
    };
    let check_hole = |hole, expected: f64| {
        let shape = cut(hole);
        let scene = scene(vec![matte(Rgb::WHITE), paint], vec![shape]);
        check(&scene, &Options::default(), [expected, 0.5 * expected, 0.0]);
    };
    let lens = Solid::Primitive(Primitive::sphere(DVec3::Z, 1.0, 1));
    check_hole(lens, 8.0 / (8.0 + 0.25 * 8.0));
    // The floor of a square hole, where normals are tilted as if it were smooth.
    let mut soft = soft_box(0.75 * DVec3::X);
    soft.transform(&DAffine3::from_translation(DVec3::new(0.1, 0.2, 0.6)));
    check_hole(Solid::Mesh(Box::new(soft)), 0.8 * 8.0 / (8.0 + 0.25 * 7.9));
}

#[test]
fn lines_between_corners_break_unless_all_objects_count() {
    let mut surface = matte(Rgb::WHITE);
    surface.is_emitter = true;
    // Smaller than a pixel, in the middle of the only one; a wall behind half of it.
    let mut half = wall(-1.0, 0);
    if let Shape::Mesh(mesh) = &mut half {
        mesh.positions.iter_mut().for_each(|p| p.x += 1.0);
    }
    let ball = Shape::Primitive(Primitive::sphere(DVec3::ZERO, 0.03, 1));
    let mut red = surface;
    red.color = Rgb::new(1.0, 0.0, 0.0);
    let mut scene = scene(vec![surface, red], vec![half, ball]);
    numbers(&mut scene).background = Rgb::BLACK;
    numbers(&mut scene).half_angles = [0.01; 2];
    let with = |mode, all_objects| Options {
        antialiasing: Antialiasing {
            mode,
            levels: 3,
            threshold: 0.02,
            all_objects,
        },
        ..Options::default()
    };
    let red_over_blue = |options| {
        let pixel = rendered(&scene, &options, (1, 1)).pixels[0];
        pixel[0] - pixel[2]
    };
    use AntialiasingMode::*;
    assert_eq!(red_over_blue(with(Adaptive, false)), 0.0);
    assert_eq!(red_over_blue(with(SemiAdaptive, false)), 0.0);
    assert!(red_over_blue(with(Adaptive, true)) > 0.0);
    assert!(red_over_blue(with(Fixed, false)) > 0.0);
}

#[test]
fn edges_are_divided_and_the_rest_is_not() {
    let mut surface = matte(Rgb::WHITE);
    surface.is_emitter = true;
    let mut scene = scene(vec![surface], vec![wall(0.0, 0)]);
    numbers(&mut scene).background = Rgb::BLACK;
    numbers(&mut scene).half_angles = [0.2; 2];
    let with = |levels, threshold| Options {
        antialiasing: Antialiasing {
            levels,
            threshold,
            ..Antialiasing::default()
        },
        ..Options::default()
    };
    let mean = |options| {
        let image = rendered(&scene, &options, (9, 9));
        image.pixels.iter().map(|p| f64::from(p[0])).sum::<f64>() / 81.0
    };
    // The wall's share of the image, emitted with nearly its full cosine.
    let truth = (0.8 * (1.0 / (8.0 * 0.2f64.tan())).powi(2)) * 0.988;
    let error = |levels| (mean(with(levels, 0.02)) - truth).abs();
    assert!(
        error(3) < 0.01 && error(3) < error(0),
        "{} {}",
        error(3),
        error(0)
    );
    assert_eq!(mean(with(3, 0.99)), mean(with(0, 0.02)));
    assert!(mean(with(3, -0.5)) != mean(with(0, 0.02)));
}

/// Two balls over a wall, with all that is random.
fn random_scene() -> (Scene, Options) {
    let shiny = RtraceSurface {
        specular: Rgb::grey(0.3),
        transparency: Rgb::grey(0.4),
        ..matte(Rgb::new(0.9, 0.8, 0.7))
    };
    let ball = |x, m| Shape::Primitive(Primitive::sphere(DVec3::new(x, 0.1, 1.5), 0.4, m));
    let mut scene = scene(
        vec![matte(Rgb::grey(0.6)), shiny],
        vec![wall(0.0, 0), ball(-0.4, 1), ball(0.5, 0)],
    );
    numbers(&mut scene).half_angles = [0.12; 2];
    let mut light = lamp(DVec3::new(3.0, 4.0, 5.0), 0.8);
    light.kind = RtraceLightKind::Extended {
        radius: 1.0,
        samples: 4,
    };
    numbers(&mut scene).lights = vec![light];
    let options = Options {
        ambient_depth: 2,
        ambient_samples: 4,
        shadows: Shadows::Filtered,
        antialiasing: Antialiasing {
            levels: 1,
            ..Antialiasing::default()
        },
        ..Options::default()
    };
    (scene, options)
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (scene, options) = random_scene();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| rendered(&scene, &options, (24, 20)))
    };
    assert_eq!(with(1), with(8));
}

#[test]
fn ambient_rays_see_the_background_where_it_is_open() {
    let mut scene = scene(vec![matte(Rgb::grey(0.5))], vec![wall(0.0, 0)]);
    numbers(&mut scene).ambient = Rgb::WHITE;
    let gathered = Options {
        ambient_depth: 1,
        ..Options::default()
    };
    check(&scene, &gathered, [0.08, 0.16, 0.24]);
    check(&scene, &Options::default(), [0.4; 3]);
}

#[test]
fn drawing_stops_when_it_is_cancelled() {
    let (scene, options) = random_scene();
    let rtrace = scene.rtrace.as_ref().unwrap();
    let progress = Progress::new();
    progress.cancel();
    let view = View::of(rtrace, (10, 10));
    assert_eq!(
        render(&scene, rtrace, &view, &options, &progress),
        Err(Cancelled)
    );
    let empty = View::of(rtrace, (0, 10));
    let image = render(&scene, rtrace, &empty, &options, &progress).unwrap();
    assert!(image.pixels.is_empty());
}

#[test]
fn bytes_are_linear_and_stay_within() {
    let mut image = Image::new(1, 2);
    image.pixels = vec![[0.0, 0.5, 1.0], [-1.0, 7.0, 0.002]];
    assert_eq!(bytes(&image), [0, 128, 255, 0, 255, 1]);
}
