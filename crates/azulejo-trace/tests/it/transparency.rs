//! Surfaces through which light passes, against known shares.

use azulejo_scene::math::Ray;
use azulejo_scene::{
    Attribute, Image, Material, Mesh, Object, Opacity, OpacityChannel, OpacityMode, OpacityPicture,
    Primitive, Rgb, Scene, Shape, Texture,
};
use azulejo_trace::sampling::uniform;
use azulejo_trace::{KernelHit, KernelRay, Tracer};
use glam::{DVec2, DVec3};

/// A checkerboard of 8 × 8 fields of 8 × 8 pixels, half of them clear.
fn checkerboard() -> Texture {
    let is_clear = |k: u32| (k % 64 / 8 + k / 64 / 8).is_multiple_of(2);
    let alpha = (0..64 * 64).map(|k| if is_clear(k) { 0.0 } else { 1.0 });
    Texture {
        path: "board.png".into(),
        image: Some(Image::opaque(64, 64, vec![[1.0; 3]; 64 * 64]).with_alpha(alpha.collect())),
        ..Texture::default()
    }
}

fn mask() -> Opacity {
    Opacity {
        constant: 1.0,
        picture: Some(OpacityPicture {
            texture: 0,
            channel: OpacityChannel::Alpha,
        }),
        mode: OpacityMode::Mask { cutoff: 0.5 },
    }
}

/// A material with an opacity.
fn cloth(opacity: Opacity) -> Material {
    Material {
        opacity: Some(opacity),
        ..Material::diffuse("cloth", Rgb::grey(0.5))
    }
}

/// Unit squares at these heights, each of its material, with the picture once over each.
fn sheets(list: Vec<(f64, Material)>) -> Scene {
    let mut scene = Scene::default();
    scene.textures.push(checkerboard());
    for (z, material) in list {
        let material = scene.add_material(material);
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut mesh = Mesh {
            positions: corners.map(|[x, y]| DVec3::new(x, y, z)).to_vec(),
            uvs: Some(Attribute::per_vertex(
                corners.map(|[x, y]| DVec2::new(x, y)).to_vec(),
            )),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], material);
        scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
    }
    scene.validate().unwrap();
    scene
}

/// Rays from above straight down to z = 0, all over the squares.
fn rays(tracer: &Tracer, count: u32) -> Vec<KernelRay> {
    let ray = |k: u32| {
        let [x, y] = [0, 1].map(|d| f64::from(uniform(&[7, k, d])));
        let from = DVec3::new(x, y, 4.0);
        tracer.kernel_ray(&Ray::new(from, -DVec3::Z))
    };
    (0..count).map(ray).collect()
}

/// The share of the light that passes these sheets: as computed, and by rays that stop by chance.
#[track_caller]
fn check(list: Vec<(f64, Material)>, expected: f64) {
    let tracer = Tracer::new(&sheets(list));
    let rays = rays(&tracer, 20_000);
    let (mut shares, mut hits, mut blocked) = (Vec::new(), Vec::new(), Vec::new());
    tracer.transmittance(&rays, &mut shares);
    tracer.closest(&rays, &mut hits);
    tracer.any(&rays, &mut blocked);
    let count = rays.len() as f64;
    let mean = shares.iter().map(|s| s.mean()).sum::<f64>() / count;
    // Where a mask is, the share is 0 or 1, and its mean has the spread of the rays.
    let spread = (expected * (1.0 - expected) / count).sqrt();
    assert!(
        (mean - expected).abs() <= 4.0 * spread + 1e-9,
        "{mean} of {expected}"
    );
    let free = hits.iter().filter(|hit| !hit.is_hit()).count() as f64 / count;
    assert!(
        (free - expected).abs() <= 4.0 * spread + 1e-9,
        "{free} of {expected}"
    );
    // Both kinds of query decide alike, ray by ray, and one by one as in a batch.
    for (k, ray) in rays.iter().enumerate() {
        assert_eq!(hits[k].is_hit(), blocked[k]);
        if k % 100 == 0 {
            let mut alone = Vec::new();
            tracer.closest(&[*ray], &mut alone);
            assert_eq!(alone[0], hits[k]);
        }
    }
}

#[test]
fn sheets_pass_their_share() {
    let blend = |opacity: f64| cloth(Opacity::constant(opacity));
    check(vec![(1.0, blend(0.3))], 0.7);
    check(vec![(1.0, blend(0.5)), (2.0, blend(0.5))], 0.25);
    check(vec![(1.0, blend(0.0)), (2.0, blend(0.0))], 1.0);
    check(vec![(1.0, blend(1.0))], 0.0);
    check(vec![(1.0, cloth(mask()))], 0.5);
    check(vec![(1.0, cloth(mask())), (2.0, blend(0.5))], 0.25);
    check(
        vec![
            (1.0, Material::diffuse("wall", Rgb::WHITE)),
            (2.0, blend(0.5)),
        ],
        0.0,
    );
    // As shares, the picture's edges are soft, and the mean is the same.
    let soft = Opacity {
        constant: 0.8,
        mode: OpacityMode::Blend,
        ..mask()
    };
    check(vec![(1.0, cloth(soft))], 0.6);
}

#[test]
fn transmittances_are_products_to_the_digit() {
    let blend = |opacity: f64| cloth(Opacity::constant(opacity));
    let tracer = Tracer::new(&sheets(vec![(1.0, blend(0.3)), (2.0, blend(0.5))]));
    let mut shares = Vec::new();
    tracer.transmittance(&rays(&tracer, 100), &mut shares);
    let is_right = |s: &Rgb| (s.g - 0.35).abs() < 1e-12 && s.r == s.g && s.g == s.b;
    assert!(shares.iter().all(is_right), "{shares:?}");
}

/// A hit is on a field of the board that is there, of the nearest sheet whose field is.
#[test]
fn masks_stop_rays_where_they_are() {
    let tracer = Tracer::new(&sheets(vec![(1.0, cloth(mask())), (0.5, cloth(mask()))]));
    assert!(tracer.has_see_through());
    let field = |k: f64| (8.0 * k).floor() as i32;
    let inside = |k: f64| (8.0 * k - (8.0 * k).round()).abs() > 0.1;
    for k in 0..2000 {
        let [x, y] = [0, 1].map(|d| f64::from(uniform(&[3, k, d])));
        if !inside(x) || !inside(y) {
            continue;
        }
        let hit = tracer.hit(&Ray::new(DVec3::new(x, y, 4.0), -DVec3::Z));
        // Rows count from the top of the picture.
        let is_there = (field(x) + field(1.0 - y)) % 2 != 0;
        assert_eq!(
            hit.map(|h| h.position.z),
            is_there.then_some(1.0),
            "{x} {y}"
        );
    }
}

/// A sphere is crossed twice; what emits, and what has no opacity, stays opaque.
#[test]
fn shapes_without_pictures() {
    let passed = |material: Material| {
        let mut scene = Scene::default();
        scene.textures.push(checkerboard());
        let material = scene.add_material(material);
        let sphere = Primitive::sphere(DVec3::ZERO, 1.0, material);
        scene
            .objects
            .push(Object::new("ball", Shape::Primitive(sphere)));
        let tracer = Tracer::new(&scene);
        let ray = tracer.kernel_ray(&Ray::new(DVec3::new(0.1, 0.2, 3.0), -DVec3::Z));
        let mut shares = Vec::new();
        tracer.transmittance(&[ray], &mut shares);
        (shares[0].mean(), tracer.has_see_through())
    };
    assert_eq!(passed(cloth(Opacity::constant(0.5))), (0.25, true));
    // A mask's picture needs coordinates, so that without them it is opaque.
    assert_eq!(passed(cloth(mask())), (0.0, false));
    assert_eq!(passed(Material::diffuse("wall", Rgb::WHITE)), (0.0, false));
    let mut lamp = cloth(Opacity::constant(0.5));
    lamp.emission = Rgb::WHITE;
    assert_eq!(passed(lamp), (0.0, false));
}

/// A hundred sheets, one close behind the other, hide nothing at random: a miss stays a miss.
#[test]
fn many_sheets() {
    let list = (0..100).map(|k| (f64::from(k) * 1e-4, cloth(Opacity::constant(0.02))));
    let expected = 0.98f64.powi(100);
    check(list.collect(), expected);
    let tracer = Tracer::new(&sheets(vec![(1.0, cloth(Opacity::constant(0.5)))]));
    let mut hits = Vec::new();
    let aside = Ray::new(DVec3::new(3.0, 3.0, 4.0), -DVec3::Z);
    tracer.closest(&[tracer.kernel_ray(&aside)], &mut hits);
    assert_eq!(hits, [KernelHit::NOTHING]);
}

/// Panes stop all rays but those of shadow tests, which pass by Fresnel's equations.
#[test]
fn panes_pass_light_and_stop_rays() {
    let tint = Rgb::new(0.9, 0.5, 0.2);
    let mut tinted = Material::pane("tinted", 1.5);
    tinted.dielectric.as_mut().unwrap().transmittance = tint;
    let clear = Material::pane("clear", 1.5);
    let scene = sheets(vec![(1.0, tinted), (2.0, clear), (0.5, clear_body())]);
    let tracer = Tracer::new(&scene);
    assert!(!tracer.has_see_through());
    let ray = |direction: DVec3| {
        let from = DVec3::new(0.5, 0.5, 1.2) - direction;
        tracer.kernel_ray(&Ray::new(from, direction))
    };
    // Straight down each pane passes (1 − R)/(1 + R) with R = 4%; at 45° by both polarizations.
    let (sin, cos) = std::f64::consts::FRAC_PI_4.sin_cos();
    let inside = (1.0 - sin * sin / 2.25f64).sqrt();
    let [s, p] = [(1.0, 1.5), (1.5, 1.0)]
        .map(|(near, far)| ((near * cos - far * inside) / (near * cos + far * inside)).powi(2));
    let slanted = 0.5 * ((1.0 - s) / (1.0 + s) + (1.0 - p) / (1.0 + p));
    let straight = ray(-DVec3::Z);
    let aside = ray(DVec3::new(sin, 0.0, -cos));
    let mut shares = Vec::new();
    tracer.transmittance(&[straight, aside], &mut shares);
    let expected = [(0.96f64 / 1.04).powi(2), slanted];
    for ((share, expected), name) in shares.iter().zip(expected).zip(["down", "aside"]) {
        let found = *share - tint * expected;
        assert!(
            found.map(f64::abs).max_channel() < 1e-6,
            "{name}: {share:?} of {expected}"
        );
    }
    let mut hits = Vec::new();
    tracer.closest(&[straight], &mut hits);
    assert!(hits[0].is_hit());
}

/// A body that does not refract.
fn clear_body() -> Material {
    Material::dielectric("air", 1.0)
}
