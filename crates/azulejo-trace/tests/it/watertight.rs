//! No ray leaves a closed room; nothing hostile stops the tracer.

use crate::{Random, scene, triangle_mesh};
use azulejo_scene::math::Ray;
use azulejo_scene::{Scene, Shape, synthetic};
use azulejo_trace::{KernelRay, Tracer};
use glam::DVec3;

/// Rays from inside to everywhere, and exactly to vertices and to points of edges.
fn check_closed(scene: &Scene, centre: DVec3, reach: DVec3, random_rays: usize) {
    let tracer = Tracer::new(scene);
    let mut random = Random(11);
    let mut rays: Vec<KernelRay> = Vec::new();
    let mut shoot = |random: &mut Random, to: Option<DVec3>| {
        let from = centre + random.point() * reach;
        let direction = to.map_or_else(|| random.unit(), |to| to - from);
        rays.push(tracer.kernel_ray(&Ray::new(from, direction)));
    };
    for _ in 0..random_rays {
        shoot(&mut random, None);
    }
    for object in &scene.objects {
        let Shape::Mesh(mesh) = &object.shape else {
            continue;
        };
        for face in 0..mesh.faces.len() {
            let corners = mesh.face_positions(face);
            for k in 0..corners.len() {
                let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
                let part = 0.5 + 0.5 * random.next();
                shoot(&mut random, Some(a));
                shoot(&mut random, Some(0.5 * (a + b)));
                shoot(&mut random, Some(a + part * (b - a)));
                shoot(
                    &mut random,
                    Some(0.5 * (a + corners[(k + 2) % corners.len()])),
                );
            }
        }
    }
    let mut hits = Vec::new();
    tracer.closest(&rays, &mut hits);
    let escaped = hits.iter().filter(|h| !h.is_hit()).count();
    assert_eq!(escaped, 0, "of {} rays", rays.len());
    let mut blocked = Vec::new();
    tracer.any(&rays, &mut blocked);
    assert!(blocked.iter().all(|&b| b));
}

#[test]
fn no_ray_escapes_from_a_cube() {
    check_closed(
        &synthetic::cube_room(),
        DVec3::splat(0.5),
        DVec3::splat(0.49),
        200_000,
    );
}

#[test]
fn no_ray_escapes_from_a_tessellated_room() {
    let mut scene = synthetic::furnished_room(60_000);
    // The walls alone, so that nothing stands before them.
    scene.objects.truncate(1);
    let centre = scene.bounds().centre();
    check_closed(&scene, centre, 0.49 * scene.bounds().size(), 1_000_000);
}

#[test]
fn no_ray_escapes_from_a_bent_shell() {
    let scene = synthetic::displaced_sphere(12_000);
    check_closed(&scene, DVec3::ZERO, DVec3::splat(0.3), 500_000);
}

#[test]
fn no_ray_escapes_from_rooms_streets_and_boxes() {
    let air = DVec3::new;
    let room = synthetic::room_with_table(2_000);
    check_closed(&room, air(2.0, 1.5, 1.7), air(1.9, 1.4, 0.7), 200_000);
    let thesis = synthetic::cornell_thesis_at(20, 0.2);
    check_closed(&thesis, air(0.0, -0.5, 1.3), air(0.9, 0.3, 0.1), 200_000);
    let street = synthetic::street_with_detail(0.2);
    check_closed(&street, air(0.0, 0.0, 9.0), air(55.0, 4.0, 8.0), 200_000);
}

#[test]
fn a_camera_of_odd_width_loses_nothing_along_the_axes() {
    // A regular grid seen exactly along the axis: every ray of the middle row and column runs
    // within planes of boxes and through edges of triangles.
    let tracer = Tracer::new(&synthetic::cube_room());
    let size = 801;
    let at = |k: i32| f64::from(2 * k + 1 - size) / f64::from(size);
    for axis in 0..3 {
        let (mut rays, mut hits) = (Vec::new(), Vec::new());
        for k in 0..size * size {
            let mut direction = DVec3::ONE;
            (direction[axis], direction[(axis + 1) % 3]) = (at(k % size), at(k / size));
            rays.push(tracer.kernel_ray(&Ray::new(DVec3::splat(0.5), direction)));
        }
        tracer.closest(&rays, &mut hits);
        assert!(
            hits.iter().all(|h| h.is_hit() && h.t <= 0.5 + 1e-6),
            "axis {axis}"
        );
    }
}

#[test]
fn hostile_rays_miss() {
    let tracer = Tracer::new(&synthetic::cube_room());
    let centre = DVec3::splat(0.5);
    let check = |origin: DVec3, direction: DVec3, t_min: f64, t_max: f64| {
        let ray = Ray {
            origin,
            direction,
            t_min,
            t_max,
        };
        assert_eq!(tracer.hit(&ray), None, "{ray:?}");
        assert!(!tracer.occluded(&ray), "{ray:?}");
    };
    let infinity = f64::INFINITY;
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        check(centre.with_y(bad), DVec3::X, 0.0, infinity);
        check(centre, DVec3::Z.with_x(bad), 0.0, infinity);
    }
    check(centre, DVec3::X, f64::NAN, infinity);
    check(centre, DVec3::X, 0.0, f64::NAN);
    check(centre, DVec3::X, 0.4, 0.4);
    check(centre, DVec3::X, 0.6, infinity);
    check(centre, DVec3::X, 0.0, 0.5);
    check(centre, DVec3::X, -2.0, -1.0);
    check(centre, DVec3::ZERO, 0.0, infinity);
    check(centre, 1e-40 * DVec3::X, 0.0, infinity);
    assert!(tracer.occluded(&Ray::new(centre, DVec3::X)));
    assert!(tracer.occluded(&Ray::new(centre, 1e-12 * DVec3::X)));
    assert!(tracer.occluded(&Ray::new(centre, 1e12 * DVec3::X)));
}

#[test]
fn hostile_vertices_are_left_out() {
    let good = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let ray = Ray::new(DVec3::new(0.2, 0.2, 1.0), -DVec3::Z);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let broken = [DVec3::splat(bad), DVec3::X, DVec3::Y];
        let tracer = Tracer::new(&scene([triangle_mesh(&[broken, good, broken])]));
        let hit = tracer.hit(&ray).expect("the good triangle is there");
        assert_eq!((hit.face, tracer.item_count()), (1, 3));
        assert_eq!(tracer.bounds().max, DVec3::new(1.0, 1.0, 0.0));
    }
    let flat = [[DVec3::ONE; 3], [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]];
    assert_eq!(Tracer::new(&scene([triangle_mesh(&flat)])).hit(&ray), None);
}

#[test]
fn extreme_sizes_keep_their_hits() {
    for size in [1e-30, 1e-12, 1.0, 1e12, 1e30, 1e200] {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| size * p);
        let tracer = Tracer::new(&scene([triangle_mesh(&[triangle])]));
        let from = size * DVec3::new(0.2, 0.2, 1.0);
        let hit = tracer.hit(&Ray::new(from, -size * DVec3::Z));
        let t = hit.expect("a hit at every size").t;
        assert!((t - 1.0).abs() < 1e-12, "size {size}: {t}");
    }
}

#[test]
fn many_copies_of_one_triangle_build_and_answer_with_the_first() {
    let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let tracer = Tracer::new(&scene([triangle_mesh(&vec![triangle; 50_000])]));
    let hit = tracer.hit(&Ray::new(DVec3::new(0.2, 0.2, 1.0), -DVec3::Z));
    assert_eq!(hit.expect("a hit").item, 0);
}
