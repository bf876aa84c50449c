//! Item buffers of the processor, against rays and closed forms.

use super::*;
use crate::lambert::{point_to_polygon, polygon_vector};
use crate::sampling::uniform;
use glam::dvec3;

const LIST: Beyond = Beyond::List;
const WINDOWS: Beyond = Beyond::Windows {
    cut: 1e-7,
    depth: 1000,
    windows: u32::MAX,
};

fn up_from(eye: DVec3) -> View {
    View {
        eye,
        normal: DVec3::Z,
        turn: 0.3,
    }
}

/// A world of polygons, one patch each.
fn world(polygons: &[Vec<DVec3>]) -> World {
    let facets = (0u32..).zip(polygons).flat_map(|(patch, p)| {
        let facet = move |k: usize| Facet {
            corners: [p[0], p[k], p[k + 1]],
            patch,
        };
        (1..p.len() - 1).map(facet)
    });
    World {
        triangles: facets.collect(),
        patches: polygons.len() as u32,
        up: DVec3::Z,
        ..World::default()
    }
}

/// The cube 0..1: floor, ceiling, and walls at y = 0, x = 1, y = 1, x = 0, fronts inwards.
fn cube() -> Vec<Vec<DVec3>> {
    let at = |p: [u8; 3]| DVec3::from(p.map(f64::from));
    let faces: [[[u8; 3]; 4]; 6] = [
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
        [[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]],
        [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]],
        [[1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0]],
        [[1, 1, 0], [1, 1, 1], [0, 1, 1], [0, 1, 0]],
        [[0, 1, 0], [0, 1, 1], [0, 0, 1], [0, 0, 0]],
    ];
    faces.map(|f| f.map(at).to_vec()).to_vec()
}

/// Turns some patches into mirrors, each with a plane of its own.
fn with_mirrors(mut world: World, mirrors: &[(u32, f64)]) -> World {
    world.mirror_of = vec![NO_MIRROR; world.patches as usize];
    for &(patch, reflectance) in mirrors {
        let facet = world.triangles.iter().find(|t| t.patch == patch);
        let [a, b, c] = facet.expect("the patch has facets").corners;
        world.mirror_of[patch as usize] = world.mirrors.len() as u32;
        world.mirrors.push(Mirror {
            point: a,
            normal: (b - a).cross(c - a).normalize(),
            reflectance: Rgb::grey(reflectance),
        });
    }
    world
}

fn see(world: &World, view: View, resolution: u32, mirrors: Beyond) -> Seen {
    let settings = Settings {
        resolution,
        mirrors,
    };
    let drawing = Processor.load(world, &settings).expect("never fails");
    let mut seen = drawing.draw(&[view]).expect("never fails");
    seen.remove(0)
}

fn share(seen: &Seen, side: u32, order: u8) -> f64 {
    let entry = seen
        .shares
        .iter()
        .find(|s| (s.side, s.order) == (side, order));
    entry.map_or(0.0, |s| s.weight.r)
}

/// All shares of the first level.
fn total(seen: &Seen) -> f64 {
    let straight = seen.shares.iter().filter(|s| s.order == 0);
    straight.map(|s| s.weight.r).sum::<f64>() + (seen.escaped[0] + seen.escaped[1]).mean()
}

#[test]
fn inside_a_cube_every_wall_has_its_share() {
    let polygons = cube();
    for (k, eye) in [dvec3(0.5, 0.5, 1e-6), dvec3(0.21, 0.87, 1e-6)]
        .into_iter()
        .enumerate()
    {
        for (n, tolerance) in [(32, 0.02), (128, 0.004), (512, 0.001)] {
            let seen = see(&world(&polygons), up_from(eye), n, LIST);
            assert!((total(&seen) - 1.0).abs() < 1e-12, "{k}: {}", total(&seen));
            assert_eq!(seen.escaped, [Rgb::BLACK; 2]);
            for (patch, polygon) in (0..).zip(&polygons) {
                let truth = point_to_polygon(eye, DVec3::Z, polygon);
                let factor = share(&seen, 2 * patch, 0);
                assert!(
                    (factor - truth).abs() < tolerance,
                    "{n} {patch}: {factor} {truth}"
                );
            }
        }
    }
}

/// The nearest facet in front of the viewpoint: its distance and side.
fn cast(world: &World, eye: DVec3, direction: DVec3) -> Option<(f64, u32)> {
    let meet = |facet: &Facet| {
        let [a, b, c] = facet.corners.map(|p| p - eye);
        let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|n| n.dot(direction));
        let area = (b - a).cross(c - a);
        let t = area.dot(a) / area.dot(direction);
        let is_inside = weights.iter().all(|&w| w >= 0.0) || weights.iter().all(|&w| w <= 0.0);
        let side = 2 * facet.patch + u32::from(area.dot(direction) > 0.0);
        (is_inside && t > 0.0 && t.is_finite()).then_some((t, side))
    };
    let hits = world.triangles.iter().filter_map(meet);
    hits.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
}

/// Shares by order and side, with rays through the centres of pixels.
fn cast_all(world: &World, view: View, resolution: u32) -> (Vec<f64>, f64) {
    let cube = Hemicube::new(resolution);
    let [x, y, z] = view.axes();
    let mut shares = vec![0.0; 2 * world.patches as usize];
    let mut escaped = 0.0;
    for (p, &weight) in (0..).zip(cube.weights()) {
        let d = cube.direction(p);
        match cast(world, view.eye, d.x * x + d.y * y + d.z * z) {
            Some((_, side)) => shares[side as usize] += f64::from(weight),
            None => escaped += f64::from(weight),
        }
    }
    (shares, escaped)
}

/// Triangles of all sizes around the viewpoint, through its horizon and its faces' planes.
fn clutter(seed: u32, count: u32) -> World {
    let random = |words: [u32; 3]| {
        let at = |k| 2.0 * f64::from(uniform(&[seed, words[0], words[1], words[2], k])) - 1.0;
        dvec3(at(0), at(1), at(2))
    };
    let triangle = |k: u32| {
        let middle = random([k, 0, 0]);
        let size = 1.5 * f64::from(uniform(&[seed, k])).powi(3) + 0.01;
        (1..4).map(|c| middle + size * random([k, c, 1])).collect()
    };
    let triangles: Vec<Vec<DVec3>> = (0..count).map(triangle).collect();
    world(&triangles)
}

#[test]
fn pixels_show_what_rays_meet() {
    for seed in 0..12 {
        let world = clutter(seed, 3 + 7 * seed * seed);
        let at = |k| f64::from(uniform(&[seed, 99, k])) - 0.5;
        let view = View {
            eye: 0.4 * dvec3(at(0), at(1), at(2)),
            normal: dvec3(at(3), at(4), at(5)).normalize(),
            turn: at(6),
        };
        let (shares, escaped) = cast_all(&world, view, 48);
        let seen = see(&world, view, 48, LIST);
        let difference =
            |(side, &truth): (usize, &f64)| (share(&seen, side as u32, 0) - truth).abs();
        let off: f64 = shares.iter().enumerate().map(difference).sum();
        let escape = (seen.escaped[0] + seen.escaped[1]).mean();
        // One of the largest pixels has 5e-4.
        assert!(
            off < 1e-3 && (escape - escaped).abs() < 1e-3,
            "{seed}: {off}"
        );
        assert!((total(&seen) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_side_is_the_one_that_shows() {
    let mut ceiling = vec![cube()[1].clone()];
    let front = see(&world(&ceiling), up_from(dvec3(0.5, 0.5, 0.2)), 16, LIST);
    ceiling[0].reverse();
    let back = see(&world(&ceiling), up_from(dvec3(0.5, 0.5, 0.2)), 16, LIST);
    assert!(share(&front, 0, 0) > 0.3 && share(&front, 1, 0) == 0.0);
    assert_eq!(share(&back, 1, 0), share(&front, 0, 0));
}

#[test]
fn of_facets_in_one_plane_the_lowest_patch_is_seen() {
    let view = View {
        normal: dvec3(0.1, -0.3, 1.0).normalize(),
        ..up_from(dvec3(0.3, 0.4, 0.1))
    };
    // The same square divided differently, tilted, and back to back.
    let tilt = |p: DVec3| dvec3(p.x, p.y, 1.0 + 0.37 * p.x - 0.21 * p.y);
    let square = [(0., 0.), (0., 1.), (1., 1.), (1., 0.)].map(|(x, y)| tilt(dvec3(x, y, 0.0)));
    let turned = [1, 2, 3, 0].map(|k| square[k]).to_vec();
    let reversed = [3, 2, 1, 0].map(|k| square[k]).to_vec();
    let alone = see(&world(&[square.to_vec()]), view, 64, LIST);
    for others in [[turned.clone(), reversed.clone()], [reversed, turned]] {
        let [a, b] = others;
        let seen = see(&world(&[square.to_vec(), a, b]), view, 64, LIST);
        assert_eq!(seen, alone);
    }
}

#[test]
fn what_cannot_be_drawn_is_left_out() {
    let good = cube();
    let expected = see(&world(&good), up_from(dvec3(0.4, 0.5, 1e-6)), 32, LIST);
    let mut bad = world(&good);
    let corner = dvec3(0.5, 0.5, 0.5);
    for corners in [
        [DVec3::NAN, DVec3::X, DVec3::Y],
        [DVec3::INFINITY, DVec3::X, DVec3::Y],
        [corner; 3],
        [corner, corner + DVec3::X, corner + 0.5 * DVec3::X],
    ] {
        bad.triangles.push(Facet { corners, patch: 0 });
    }
    bad.triangles.push(Facet {
        corners: [corner, corner + DVec3::X, corner + DVec3::Y],
        patch: 6,
    });
    let seen = see(&bad, up_from(dvec3(0.4, 0.5, 1e-6)), 32, LIST);
    assert_eq!(seen, expected);
}

#[test]
fn an_empty_world_lets_everything_escape() {
    let empty = World {
        up: DVec3::Z,
        ..World::default()
    };
    let seen = see(&empty, up_from(DVec3::ZERO), 16, WINDOWS);
    assert!((seen.escaped[0].mean() - 1.0).abs() < 1e-6 && seen.shares.is_empty());
    let sideways = View {
        normal: DVec3::X,
        ..up_from(DVec3::ZERO)
    };
    let seen = see(&empty, sideways, 64, WINDOWS);
    assert!((seen.escaped[0].mean() - 0.5).abs() < 0.01);
    let nowhere = View {
        normal: DVec3::NAN,
        ..sideways
    };
    assert!((total(&see(&world(&cube()), nowhere, 16, LIST)) - 1.0).abs() < 1e-6);
}

#[test]
fn far_from_the_origin_the_same_is_seen() {
    let eye = dvec3(0.21, 0.87, 1e-5);
    let near = see(&world(&cube()), up_from(eye), 64, LIST);
    let far = dvec3(4e5, 5e6, 100.0);
    let moved: Vec<Vec<DVec3>> = cube()
        .iter()
        .map(|f| f.iter().map(|p| p + far).collect())
        .collect();
    let seen = see(&world(&moved), up_from(eye + far), 64, LIST);
    for (a, b) in seen.shares.iter().zip(&near.shares) {
        assert!((a.weight.r - b.weight.r).abs() < 1e-3 && a.side == b.side);
    }
}

#[test]
fn mirrors_are_listed() {
    let world = with_mirrors(world(&cube()), &[(1, 0.8)]);
    let eye = dvec3(0.3, 0.6, 1e-6);
    let seen = see(&world, up_from(eye), 64, LIST);
    let listed: f64 = seen.specular.iter().map(|p| p.weight.r).sum();
    assert!((listed - share(&seen, 2, 0)).abs() < 1e-6 && listed > 0.2);
    for p in &seen.specular {
        let hit = p.origin + p.distance * p.direction;
        assert!((hit.z - 1.0).abs() < 1e-4 && p.side == 2 && p.order == 0);
        assert!((p.origin - eye).length() < 1e-12);
    }
}

#[test]
fn a_window_shows_the_mirror_image() {
    // A mirror on one wall of a cube: its image is the other half of a longer box.
    let world = with_mirrors(world(&cube()), &[(3, 0.5)]);
    let eye = dvec3(0.3, 0.6, 1e-6);
    for (n, tolerance) in [(64, 0.01), (256, 0.002)] {
        let seen = see(&world, up_from(eye), n, WINDOWS);
        for (patch, polygon) in (0..).zip(&cube()) {
            let image: Vec<DVec3> = polygon
                .iter()
                .rev()
                .map(|p| dvec3(2.0 - p.x, p.y, p.z))
                .collect();
            let truth = match patch {
                3 => 0.0,
                _ => 0.5 * point_to_polygon(eye, DVec3::Z, &image),
            };
            let factor = share(&seen, 2 * patch, 1);
            assert!(
                (factor - truth).abs() < tolerance,
                "{n} {patch}: {factor} {truth}"
            );
        }
        assert!(seen.shares.iter().all(|s| s.order < 2 && s.side % 2 == 0));
        assert_eq!((seen.cut, seen.escaped), (Rgb::BLACK, [Rgb::BLACK; 2]));
    }
}

/// Σ shares (1 − ρ) + escaped + cut.
fn telescoped(world: &World, seen: &Seen) -> f64 {
    let kept = |s: &Share| {
        let mirror = world.mirror_of.get((s.side / 2) as usize);
        let mirror = mirror.and_then(|&m| world.mirrors.get(m as usize));
        s.weight.r * (1.0 - mirror.map_or(0.0, |m| m.reflectance.r))
    };
    seen.shares.iter().map(kept).sum::<f64>() + seen.cut.r + seen.escaped[0].r + seen.escaped[1].r
}

#[test]
fn nothing_is_lost_between_mirrors() {
    let view = View {
        normal: dvec3(0.2, 0.1, 1.0).normalize(),
        ..up_from(dvec3(0.3, 0.6, 0.2))
    };
    let check = |mirrors: &[(u32, f64)], beyond: Beyond, cut: std::ops::Range<f64>| {
        let world = with_mirrors(world(&cube()), mirrors);
        let seen = see(&world, view, 32, beyond);
        let sum = telescoped(&world, &seen);
        assert!((sum - 1.0).abs() < 1e-12, "{mirrors:?}: {sum}");
        assert!(cut.contains(&seen.cut.r), "{mirrors:?}: cut {}", seen.cut.r);
    };
    check(&[(2, 0.8), (4, 0.8)], WINDOWS, -1e-6..1e-6);
    check(&[(2, 1.0), (4, 1.0), (5, 0.5)], WINDOWS, 0.0..1e-3);
    let few = Beyond::Windows {
        cut: 1e-7,
        depth: 2,
        windows: u32::MAX,
    };
    check(&[(2, 0.8), (4, 0.8)], few, 1e-3..0.5);
    let none = Beyond::Windows {
        cut: 1e-7,
        depth: 0,
        windows: u32::MAX,
    };
    check(&[(2, 0.8), (4, 0.8)], none, 0.1..0.5);
    // Only mirrors: light that is not cut is absorbed by them; perfect ones absorb nothing.
    check(&[0, 1, 2, 3, 4, 5].map(|p| (p, 0.7)), WINDOWS, -1e-6..1e-6);
    let shallow = Beyond::Windows {
        cut: 1e-7,
        depth: 40,
        windows: u32::MAX,
    };
    check(&[0, 1, 2, 3, 4, 5].map(|p| (p, 1.0)), shallow, 0.999..1.001);
    check(&[(3, 0.0)], WINDOWS, 0.0..1e-9);
}

/// A row of pairs of mirrors that face each other, each with its own plane.
#[test]
fn very_many_mirrors_end() {
    let count = 20_000;
    let strip = |k: u32| {
        let (x, tilt) = (
            f64::from(k / 2) / f64::from(count / 2),
            1e-3 * f64::from(k % 7),
        );
        let w = 2.0 / f64::from(count);
        let wall = [(0.0, 0.0), (0.0, 1.0), (w, 1.0), (w, 0.0)];
        let at = |(dx, z): (f64, f64)| dvec3(x + dx, tilt * z, z);
        let front: Vec<DVec3> = wall.into_iter().map(at).collect();
        match k % 2 {
            0 => front,
            _ => front
                .iter()
                .rev()
                .map(|p| dvec3(p.x, 1.0 - p.y, p.z))
                .collect(),
        }
    };
    let strips: Vec<Vec<DVec3>> = (0..count).map(strip).collect();
    let mirrors: Vec<(u32, f64)> = (0..count).map(|k| (k, 0.9)).collect();
    let mut world = world(&strips);
    world.mirror_of = (0..count).collect();
    for (k, _) in &mirrors {
        let [a, b, c] = world.triangles[2 * *k as usize].corners;
        let normal = (b - a).cross(c - a).normalize();
        world.mirrors.push(Mirror {
            point: a,
            normal,
            reflectance: Rgb::grey(0.9),
        });
    }
    let seen = see(&world, up_from(dvec3(0.5, 0.5, 0.1)), 16, WINDOWS);
    assert!((telescoped(&world, &seen) - 1.0).abs() < 1e-12);
    assert!(seen.escaped[0].r > 0.1);
}

#[test]
fn mirrors_of_different_reflectance_in_one_plane_do_not_see_each_other() {
    let at = |x: f64, y: f64| dvec3(x, y, 1.0);
    let half = |x: f64| vec![at(x, 0.0), at(x, 1.0), at(x + 0.5, 1.0), at(x + 0.5, 0.0)];
    let floor = cube()[0].clone();
    let world = with_mirrors(
        world(&[half(0.0), half(0.5), floor]),
        &[(0, 0.5), (1, 0.25)],
    );
    let seen = see(&world, up_from(dvec3(0.5, 0.5, 0.1)), 64, WINDOWS);
    let image = cube()[0]
        .iter()
        .rev()
        .map(|&p| p + 2.0 * DVec3::Z)
        .collect::<Vec<_>>();
    let truth = 0.375 * point_to_polygon(dvec3(0.5, 0.5, 0.1), DVec3::Z, &image);
    let floor = share(&seen, 4, 1);
    assert!(
        (floor - truth).abs() < 2e-3 && share(&seen, 0, 1) == 0.0,
        "{floor} {truth}"
    );
    assert!((telescoped(&world, &seen) - 1.0).abs() < 1e-12);
}

#[test]
fn bent_patches_are_listed_behind_windows_too() {
    let mut world = with_mirrors(world(&cube()), &[(3, 0.5)]);
    world.is_bent = vec![false, true, false, false, false, false];
    let seen = see(&world, up_from(dvec3(0.5, 0.5, 1e-6)), 64, WINDOWS);
    for order in [0, 1] {
        let of_order = seen.specular.iter().filter(|p| p.order == order);
        let listed: f64 = of_order.map(|p| p.weight.r).sum();
        assert!(listed > 0.01 && (listed - share(&seen, 2, order)).abs() < 1e-6);
    }
    for p in &seen.specular {
        let hit = p.origin + p.distance * p.direction;
        assert!(
            (hit.z - 1.0).abs() < 1e-4 && (0.0..=1.0).contains(&hit.x),
            "{p:?}"
        );
        assert!(p.order == 0 || (p.origin.x - 1.0).abs() < 1e-5);
    }
}

#[test]
fn threads_and_neighbours_change_nothing() {
    let world = with_mirrors(clutter(3, 60), &[(0, 0.6), (1, 0.9), (2, 0.4)]);
    let view = |k: u32| View {
        turn: f64::from(k),
        ..up_from(dvec3(0.01 * f64::from(k), 0.0, -0.2))
    };
    let views: Vec<View> = (0..24).map(view).collect();
    let settings = Settings {
        resolution: 24,
        mirrors: WINDOWS,
    };
    let drawing = Processor.load(&world, &settings).expect("never fails");
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let draw = |threads| {
        pool(threads)
            .expect("threads start")
            .install(|| drawing.draw(&views))
    };
    let one = draw(1);
    assert_eq!(one, draw(4));
    let alone: Vec<Seen> = views.iter().map(|&v| see(&world, v, 24, WINDOWS)).collect();
    assert_eq!(one, Ok(alone));
}

/// Error of single shares falls with the resolution.
#[test]
fn error_falls_with_the_resolution() {
    let window = [(0.2, 0.3), (0.25, 0.7), (0.8, 0.75), (0.7, 0.2)];
    let polygon: Vec<DVec3> = window
        .iter()
        .map(|&(x, y)| dvec3(x, y, 0.4 + 0.1 * x))
        .collect();
    let world = world(std::slice::from_ref(&polygon));
    let error = |n: u32| {
        let squared = |k: u32| {
            let at = |d| f64::from(uniform(&[k, d]));
            let view = View {
                eye: dvec3(at(0), at(1), 0.0),
                normal: DVec3::Z,
                turn: 7.0 * at(2),
            };
            let truth = polygon_vector(view.eye, &polygon).z.abs();
            let seen = see(&world, view, n, LIST);
            let factor: f64 = seen.shares.iter().map(|s| s.weight.r).sum();
            (factor - truth).powi(2)
        };
        ((0..40).map(squared).sum::<f64>() / 40.0).sqrt()
    };
    let errors = [16, 64, 256].map(error);
    // Slanted outlines: pixels^(−3/4), a factor of 8 for 16 times the pixels.
    assert!(
        errors[1] < errors[0] / 5.0 && errors[2] < errors[1] / 5.0,
        "{errors:?}"
    );
}
