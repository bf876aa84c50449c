//! Positions in double precision, far-away scenes, and rays that leave surfaces.

use crate::{Random, scene, triangle_mesh};
use azulejo_scene::math::{Frame, Ray};
use azulejo_scene::{Primitive, Shape, synthetic};
use azulejo_trace::{KernelHit, Tracer};
use glam::DVec3;

#[test]
fn resolved_points_lie_on_the_triangle_and_on_the_ray() {
    let mut random = Random(5);
    for shift in [DVec3::ZERO, DVec3::new(5e5, 4.6e6, 200.0)] {
        let triangle = [0; 3].map(|_| shift + 10.0 * random.point());
        let tracer = Tracer::new(&scene([triangle_mesh(&[triangle])]));
        let [a, b, c] = triangle;
        let normal = (b - a).cross(c - a).normalize();
        for _ in 0..2000 {
            let (r, s) = (0.5 + 0.5 * random.next(), 0.5 + 0.5 * random.next());
            let to =
                a + 0.98 * (r * (1.0 - s) * (b - a) + r * s * (c - a)) + 1e-3 * (b + c - 2.0 * a);
            let from = shift + 40.0 * random.unit();
            let ray = Ray::new(from, 0.3 * (to - from));
            if normal.dot(ray.direction.normalize()).abs() < 0.05 {
                continue;
            }
            let hit = tracer.hit(&ray).expect("aimed at the inside");
            // 1e-12 of the coordinates' own rounding, times the slant.
            let digits = 1e-14 * (1.0 + shift.length()) / 0.05;
            assert!(normal.dot(hit.position - a).abs() < digits, "off the plane");
            assert!((hit.position - to).length() < 10.0 * digits, "off the ray");
            assert!((hit.t - 1.0 / 0.3).abs() < 10.0 * digits, "t = {}", hit.t);
            let again = a + hit.u * (b - a) + hit.v * (c - a);
            assert!((again - hit.position).length() < digits, "u, v");
            assert_eq!(hit.entering, hit.normal.dot(ray.direction) < 0.0);
            assert!((hit.normal - normal).length() < 1e-9);
        }
    }
}

#[test]
fn a_far_room_is_hit_where_the_near_one_is() {
    let near = synthetic::furnished_room(6000);
    let shift = DVec3::new(4.0e5, 5.5e6, 1000.0);
    let mut far = near.clone();
    for object in &mut far.objects {
        if let Shape::Mesh(mesh) = &mut object.shape {
            mesh.positions.iter_mut().for_each(|p| *p += shift);
        }
    }
    let (near, far) = (Tracer::new(&near), Tracer::new(&far));
    let mut random = Random(8);
    let mut differing = 0;
    for _ in 0..20_000 {
        let from = DVec3::new(3.0, 2.5, 1.5) + random.point() * DVec3::new(2.9, 2.4, 1.4);
        let ray = Ray::new(from, random.unit());
        let a = near.hit(&ray).expect("the room is closed");
        let moved = Ray::new(from + shift, ray.direction);
        let b = far.hit(&moved).expect("the far room is closed");
        // Rounding of positions by 1e-9 may choose the neighbour at an edge.
        differing += usize::from((a.t - b.t).abs() > 1e-6);
    }
    assert!(differing < 10, "{differing} of 20000");
}

/// A cube at 10,000 sizes made near walls as coarse as itself: rays began 2% of a room's size off them.
#[test]
fn what_is_far_away_does_not_coarsen_a_room() {
    let alone = synthetic::furnished_room(6000);
    let mut with_cube = alone.clone();
    let corner = DVec3::new(4.0e4, -3.0e4, 2.0e4);
    let mut cube = synthetic::cube_room().objects.swap_remove(0);
    if let Shape::Mesh(mesh) = &mut cube.shape {
        mesh.positions.iter_mut().for_each(|p| *p += corner);
    }
    with_cube.objects.push(cube);
    let (alone, with_cube) = (Tracer::new(&alone), Tracer::new(&with_cube));
    let mut random = Random(9);
    let mut differing = 0;
    for _ in 0..20_000 {
        let from = DVec3::new(3.0, 2.5, 1.5) + random.point() * DVec3::new(2.9, 2.4, 1.4);
        let ray = Ray::new(from, random.unit());
        let a = alone.hit(&ray).expect("the room is closed");
        let b = with_cube.hit(&ray).expect("the room is still closed");
        differing += usize::from((a.t - b.t).abs() > 1e-5);
        let step = (with_cube.leaving(b.position, b.normal) - b.position).length();
        assert!(step < 3e-5, "{step}");
        // Into the cube, from within the room's walls as if there were none.
        let aim = corner + 0.5 * (DVec3::ONE + 0.8 * random.point());
        let from = corner + 1e3 * random.unit();
        let hit = with_cube.hit(&Ray::new(from, aim - from));
        let hit = hit.expect("aimed at the cube");
        assert!(hit.position.distance(aim) < 2.0, "{hit:?}");
    }
    assert!(differing < 10, "{differing} of 20000");
}

/// The ground of a town reaches 10,000 times as far as a house on it.
#[test]
fn a_plain_does_not_coarsen_what_stands_on_it() {
    let mut town = synthetic::furnished_room(6000);
    let slope = DVec3::new(0.01, -0.02, 1.0);
    let on_ground =
        |x: f64, y: f64| DVec3::new(3e4 * x, 3e4 * y, -0.5 - 3e4 * (slope.x * x + slope.y * y));
    let [a, b, c, d] = [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)].map(|(x, y)| on_ground(x, y));
    let ground = triangle_mesh(&[[a, b, c], [a, c, d]]);
    town.objects
        .push(azulejo_scene::Object::new("ground", ground));
    let tracer = Tracer::new(&town);
    let normal = slope.normalize();
    let mut random = Random(11);
    for k in 0..20_000 {
        // Beside the house, on the common edge and within the triangles.
        let x = 3e-3 * random.next();
        let y = if k % 2 == 0 { x } else { 3e-3 * random.next() };
        let place = on_ground(x, y);
        let from = place + DVec3::new(0.0, 0.0, -1.0);
        let hit = tracer.hit(&Ray::new(from, place - from)).expect("no gap");
        assert!(
            (hit.t - 1.0).abs() < 1e-9 && hit.position.distance(place) < 1e-6,
            "{hit:?}"
        );
        let origin = tracer.leaving(place, -normal);
        assert!(origin.distance(place) < 1e-3);
        let level = random.unit();
        let steep = [1e-6, 1e-3, 0.5][k % 3];
        let way = level - level.dot(normal) * normal - steep * normal;
        assert_eq!(tracer.hit(&Ray::new(origin, way)), None);
    }
}

/// Rays that leave a surface, from level to steep, must not hit the item that they leave.
fn check_leaving(tracer: &Tracer, hit_from: impl Fn(&mut Random) -> Ray, flat: bool) {
    let mut random = Random(21);
    let mut rays = Vec::new();
    let mut own = Vec::new();
    for _ in 0..60_000 {
        let Some(hit) = tracer.hit(&hit_from(&mut random)) else {
            continue;
        };
        let side = if random.next() > 0.0 {
            hit.normal
        } else {
            -hit.normal
        };
        let inside = !flat && side.dot(hit.normal) < 0.0;
        if inside {
            // From inside a ball every ray rightly hits the ball again.
            continue;
        }
        let frame = Frame::from_normal(side);
        let level = random.unit().with_z(0.0).normalize_or_zero();
        let steepness = [0.0, 1e-9, 1e-6, 1e-3, 0.1, 1.0][rays.len() % 6];
        let direction = frame.to_world(level.with_z(steepness));
        let origin = tracer.leaving(hit.position, side);
        rays.push(tracer.kernel_ray(&Ray::new(origin, direction)));
        own.push(hit.item);
    }
    assert!(rays.len() > 1000, "{} rays", rays.len());
    let mut hits: Vec<KernelHit> = Vec::new();
    tracer.closest(&rays, &mut hits);
    let met = hits
        .iter()
        .zip(&own)
        .filter(|(h, item)| h.item == **item)
        .count();
    assert_eq!(met, 0, "of {}", rays.len());
}

#[test]
fn leaving_a_triangle_never_meets_it_again() {
    let mut random = Random(2);
    for size in [1e-3, 1.0, 1e3] {
        for shift in [DVec3::ZERO, size * DVec3::new(3e4, 2e5, -1e3)] {
            let triangles: Vec<[DVec3; 3]> = (0..40)
                .map(|_| [0; 3].map(|_| shift + size * random.point()))
                .collect();
            let tracer = Tracer::new(&scene([triangle_mesh(&triangles)]));
            let aim = |r: &mut Random| {
                let t = triangles[((r.next() + 1.0) * 20.0) as usize % 40];
                let to = (t[0] + t[1] + t[2]) / 3.0;
                let from = to + 3.0 * size * r.unit();
                Ray::new(from, to + 0.1 * size * r.point() - from)
            };
            check_leaving(&tracer, aim, true);
        }
    }
}

#[test]
fn leaving_a_slanted_sliver_never_meets_it_again() {
    let slope = DVec3::new(0.3, 0.4, 0.5);
    let sliver = [DVec3::ZERO, 100.0 * slope, 100.0 * slope + 0.01 * DVec3::X];
    let tracer = Tracer::new(&scene([triangle_mesh(&[sliver])]));
    let aim = |r: &mut Random| {
        let to = (0.5 + 0.5 * r.next()) * 100.0 * slope + 0.003 * DVec3::X;
        let from = to + 50.0 * r.unit();
        Ray::new(from, to - from)
    };
    check_leaving(&tracer, aim, true);
}

#[test]
fn leaving_a_ball_never_meets_it_again() {
    for radius in [1e-2, 1.0, 1e4] {
        let centre = radius * DVec3::new(100.0, 20.0, -3.0);
        let ball = Primitive::sphere(centre, radius, 0);
        let tracer = Tracer::new(&scene([Shape::Primitive(ball)]));
        let aim = |r: &mut Random| {
            let from = centre + 3.0 * radius * r.unit();
            Ray::new(from, centre + 0.9 * radius * r.point() - from)
        };
        check_leaving(&tracer, aim, false);
    }
}

#[test]
fn leaving_moves_by_what_it_says() {
    let tracer = Tracer::new(&synthetic::cube_room());
    let moved = tracer.leaving(DVec3::new(0.5, 0.5, 0.0), DVec3::Z);
    let expected = 16.0 * f64::from(f32::EPSILON) * 0.5;
    assert!((moved.z / expected - 1.0).abs() < 1e-12, "{}", moved.z);
}
