//! Bodies of glass that touch other surfaces, or into which these reach: all but glass lies in air.

use azulejo_scene::math::{Frame, Ray};
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo_trace::follow::{Event, Path, Scratch, follow};
use azulejo_trace::sampling::{cosine_hemisphere, sobol};
use azulejo_trace::{Surfaces, Tracer};
use glam::DVec3;

/// The faces of a box, outward.
fn faces(scene: &mut Scene, low: DVec3, high: DVec3, material: u32, inward: bool) {
    let corner = |k: usize| {
        DVec3::from_array(std::array::from_fn(|a| {
            if k >> a & 1 == 1 { high[a] } else { low[a] }
        }))
    };
    let mut mesh = Mesh {
        positions: (0..8).map(corner).collect(),
        ..Mesh::default()
    };
    for mut face in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        if inward {
            face.reverse();
        }
        mesh.push_face(&face, material);
    }
    scene.objects.push(Object::new("box", Shape::Mesh(mesh)));
}

/// A room with a block of glass whose underside is at that height, and a core in it if it has one.
fn room(height: f64, transmittance: f64, has_core: bool) -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let mut glass = Material::dielectric("glass", 1.5);
    glass.dielectric.as_mut().unwrap().transmittance = Rgb::grey(transmittance);
    let glass = scene.add_material(glass);
    let [low, high] = [DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 3.0)];
    faces(&mut scene, low, high, grey, true);
    let foot = DVec3::new(-0.6, -0.6, height);
    let head = foot + DVec3::new(1.2, 1.2, 1.0);
    faces(&mut scene, foot, head, glass, false);
    if has_core {
        let foot = DVec3::new(-0.2, -0.2, height.max(0.0) + 0.3);
        faces(&mut scene, foot, foot + 0.3, grey, false);
    }
    scene
}

/// What becomes of a cosine-distributed path that leaves a square of half-width 0.5 around a point: shares of surfaces
/// but glass, of what is absorbed, escaped or cut, and of the same square opposite.
fn shares(scene: &Scene, centre: DVec3, normal: DVec3, count: u32) -> ([f64; 3], f64) {
    let tracer = Tracer::new(scene);
    let surfaces = Surfaces::new(scene, &tracer);
    let frame = Frame::from_normal(normal);
    let start = |k: u32| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|d| f64::from(sobol(k, d, d as u32 + 1)));
        let at = centre + (a - 0.5) * frame.x + (b - 0.5) * frame.y;
        let direction = frame.to_world(cosine_hemisphere(c, d));
        let ray = Ray::new(tracer.leaving(at, normal), direction);
        Path::new(
            tracer.kernel_ray(&ray),
            k,
            Rgb::grey(1.0 / f64::from(count)),
        )
    };
    let mut paths: Vec<Path> = (0..count).map(start).collect();
    let (mut sums, mut opposite) = ([0.0; 3], 0.0);
    follow(
        &surfaces,
        &mut paths,
        &mut Scratch::default(),
        7,
        |path, event| {
            let weight = path.weight.g;
            match event {
                Event::Surface { hit, .. } if surfaces.material(hit.item).dielectric.is_none() => {
                    sums[0] += weight;
                    let ray = tracer.world_ray(&path.leg.ray);
                    let at = tracer.resolve(&ray, &hit);
                    let is_square = at.position.truncate().abs().max_element() <= 0.5;
                    if is_square && at.normal.z * normal.z < -0.5 {
                        opposite += weight;
                    }
                }
                Event::Surface { .. } => {}
                Event::Absorbed => sums[1] += weight,
                Event::Escape | Event::Cut => sums[2] += weight,
            }
        },
    );
    (sums, opposite)
}

const FLOOR: (DVec3, DVec3) = (DVec3::ZERO, DVec3::Z);
const CEILING: (DVec3, DVec3) = (DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z);

/// Heights of the underside: above the floor, on it, by less than rays are moved off, and below.
const HEIGHTS: [f64; 5] = [0.01, 1e-6, 0.0, -1e-6, -0.01];

#[test]
fn no_power_is_lost_at_glass_that_touches_other_surfaces() {
    for height in HEIGHTS {
        for (transmittance, has_core) in [(1.0, false), (1.0, true), (0.6, false), (0.6, true)] {
            let scene = room(height, transmittance, has_core);
            for (centre, normal) in [FLOOR, CEILING] {
                let ([kept, absorbed, lost], _) = shares(&scene, centre, normal, 2_000);
                let case = format!("{height}, {transmittance}, {has_core}: {normal}");
                // What glass absorbs is known of both ways that a path might take: it is right on average.
                let allowed = if transmittance < 1.0 { 0.01 } else { 1e-3 };
                assert!(
                    (kept + absorbed - 1.0).abs() < allowed,
                    "{case}: {kept} + {absorbed}"
                );
                assert!(lost < 1e-3, "{case}: {lost} lost");
                assert_eq!(absorbed > 0.01, transmittance < 1.0, "{case}: {absorbed}");
            }
        }
    }
}

#[test]
fn a_floor_under_glass_sees_what_it_sees_through_a_gap() {
    for transmittance in [1.0, 0.7] {
        let mut seen = Vec::new();
        for height in HEIGHTS {
            let scene = room(height, transmittance, false);
            for (centre, normal) in [FLOOR, CEILING] {
                seen.push(shares(&scene, centre, normal, 100_000).1);
            }
        }
        // The squares are as large, so that by reciprocity all are the same.
        let first = seen[0];
        let same = seen.iter().all(|share| (share / first - 1.0).abs() < 0.04);
        assert!(first > 0.005 && same, "{transmittance}: {seen:?}");
    }
}
