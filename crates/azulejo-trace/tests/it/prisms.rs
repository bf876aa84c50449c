//! Extruded figures against boxes, flattened figures and themselves.

use crate::{Random, scene};
use azulejo_scene::math::Ray;
use azulejo_scene::{
    Contour, Curve, Exact, Figure, FillRule, Primitive, PrimitiveKind, Prism, Shape, Solid,
};
use azulejo_trace::Tracer;
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::sync::Arc;

pub(crate) fn prism(figure: Figure, world_from_figure: DAffine3) -> Solid {
    Solid::Prism(Prism {
        figure: Arc::new(figure),
        world_from_figure,
        material: 0,
        bevel: None,
    })
}

pub(crate) fn exact(solids: Vec<Solid>) -> Shape {
    Shape::Exact(Exact::new(solids))
}

pub(crate) fn tracer(solids: Vec<Solid>) -> Tracer {
    let scene = scene([exact(solids)]);
    assert_eq!(scene.validate(), Ok(()));
    Tracer::new(&scene)
}

pub(crate) fn rectangle() -> Figure {
    Figure::polygon([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from))
}

/// The letter D of Costa 1992, about one unit high.
pub(crate) fn letter_d() -> Figure {
    let v = |x: f64, y: f64| DVec2::new(x, y) / 23.0;
    let line = |x, y| Curve::Line { start: v(x, y) };
    let outer = vec![
        line(0.0, 0.0),
        line(0.0, 23.0),
        Curve::Cubic {
            start: v(8.0, 23.0),
            control1: v(25.0, 21.0),
            control2: v(23.0, 0.0),
        },
        line(8.0, 0.0),
    ];
    let hole = vec![Curve::Cubic {
        start: v(6.0, 15.0),
        control1: v(4.0, -6.0),
        control2: v(23.0, 17.0),
    }];
    Figure {
        contours: vec![Contour { curves: outer }, Contour { curves: hole }],
        rule: FillRule::EvenOdd,
    }
}

/// A ring of smooth waves, `count` curves long: no straight piece.
pub(crate) fn gear(count: usize) -> Figure {
    let at = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / (3 * count) as f64;
        let radius = 1.0 + 0.2 * (7.0 * angle).sin();
        radius * DVec2::from_angle(angle)
    };
    let curves = (0..count).map(|k| Curve::Cubic {
        start: at(3 * k),
        control1: at(3 * k + 1),
        control2: at(3 * k + 2),
    });
    Figure {
        contours: vec![Contour {
            curves: curves.collect(),
        }],
        rule: FillRule::EvenOdd,
    }
}

/// `figure` with its curves replaced by chords.
pub(crate) fn flat(figure: &Figure, tolerance: f64) -> Figure {
    let contours = figure.flatten(tolerance).into_iter();
    Figure {
        contours: contours.flat_map(|c| Figure::polygon(c).contours).collect(),
        rule: figure.rule,
    }
}

pub(crate) fn maps() -> [DAffine3; 4] {
    let oblique = DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(2.0, 0.1, 0.0),
            DVec3::new(0.3, 1.5, 0.2),
            DVec3::new(0.5, 0.4, 0.8),
        ),
        translation: DVec3::new(500.0, 600.0, 700.0),
    };
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    [
        DAffine3::IDENTITY,
        mirror,
        oblique,
        oblique * mirror * DAffine3::from_translation(DVec3::new(0.2, 0.0, -3.0)),
    ]
}

/// Rays about the box of a tracer, many of them aimed at it, some along its axes.
pub(crate) fn rays(tracer: &Tracer, count: usize) -> Vec<Ray> {
    let mut random = Random(7);
    let bounds = tracer.bounds();
    let ray = |k: usize| {
        let from = bounds.centre() + 0.9 * random.point() * bounds.size();
        let to = bounds.centre() + 0.6 * random.point() * bounds.size();
        let direction = match k % 8 {
            0 => random.unit(),
            1 => DVec3::AXES[k / 8 % 3],
            _ => to - from,
        };
        Ray::new(from, direction)
    };
    (0..count).map(ray).collect()
}

#[test]
fn a_square_extruded_is_a_box() {
    for map in maps() {
        let as_prism = tracer(vec![prism(rectangle(), map)]);
        let cuboid = Primitive::new(PrimitiveKind::Cuboid, map, 0);
        let as_box = Tracer::new(&scene([Shape::Primitive(cuboid)]));
        let mut hits = 0;
        for ray in rays(&as_prism, 20_000) {
            let (a, b) = (as_prism.hit(&ray), as_box.hit(&ray));
            assert_eq!(as_prism.occluded(&ray), a.is_some(), "{ray:?}");
            assert_eq!(a.is_some(), b.is_some(), "{ray:?} {a:?} {b:?}");
            if let (Some(a), Some(b)) = (a, b) {
                hits += 1;
                assert!((a.t - b.t).abs() < 1e-9, "{ray:?} {a:?} {b:?}");
                assert!((a.normal - b.normal).length() < 1e-9, "{a:?} {b:?}");
                assert_eq!(a.entering, b.entering, "{a:?} {b:?}");
            }
        }
        assert!(hits > 5000, "{hits}");
    }
}

/// The same hits up to what chords leave out.
fn check_against_chords(figure: &Figure, map: DAffine3) {
    let curved = tracer(vec![prism(figure.clone(), map)]);
    let chords = tracer(vec![prism(flat(figure, 1e-6), map)]);
    let (mut hits, mut differing) = (0, 0);
    for ray in rays(&curved, 20_000) {
        let (a, b) = (curved.hit(&ray), chords.hit(&ray));
        assert_eq!(curved.occluded(&ray), a.is_some(), "{ray:?}");
        match (a, b) {
            (Some(a), Some(b)) => {
                hits += 1;
                let slant = a.normal.dot(ray.direction.normalize()).abs().max(1e-3);
                let same = (a.position - b.position).length() < 1e-5 / slant;
                differing += usize::from(!same || a.entering != b.entering);
            }
            (None, None) => {}
            _ => differing += 1,
        }
    }
    assert!(
        hits > 2000 && differing <= 4,
        "{hits} hits, {differing} differ"
    );
}

#[test]
fn curves_are_met_where_their_chords_are() {
    for map in maps() {
        check_against_chords(&letter_d(), map);
        check_against_chords(&gear(100), map);
    }
    for rule in [FillRule::EvenOdd, FillRule::NonZero] {
        let mut overlapping = letter_d();
        overlapping.contours.extend(rectangle().contours);
        overlapping.contours.extend(gear(12).contours);
        check_against_chords(
            &Figure {
                rule,
                ..overlapping
            },
            maps()[2],
        );
    }
}

/// Follows a ray through all surfaces; it must come in and go out by turns.
fn check_in_and_out(tracer: &Tracer, ray: &Ray, starts_inside: bool) -> usize {
    let mut expected = !starts_inside;
    let (mut from, mut met) = (*ray, 0);
    while let Some(hit) = tracer.hit(&from) {
        assert_eq!(hit.entering, expected, "surface {met} of {ray:?}: {hit:?}");
        let forward = if hit.entering {
            -hit.normal
        } else {
            hit.normal
        };
        from.origin = tracer.leaving(hit.position, forward);
        expected = !expected;
        met += 1;
        assert!(met < 1000, "{ray:?}");
    }
    assert!(expected, "{ray:?} never left");
    met
}

#[test]
fn what_enters_leaves() {
    for map in maps() {
        for figure in [letter_d(), gear(40), rectangle()] {
            let tracer = tracer(vec![prism(figure.clone(), map)]);
            let bounds = tracer.bounds();
            let mut met = 0;
            for ray in rays(&tracer, 5000) {
                let outside = ray.origin - bounds.diagonal() * 3.0 * ray.direction.normalize();
                // Through a corner or tangent to a curve the surfaces are too near each other to
                // be followed one by one; thousands of random rays hit none.
                met += check_in_and_out(&tracer, &Ray::new(outside, ray.direction), false);
            }
            assert!(met > 2000, "{met}");
        }
    }
}

#[test]
fn rays_through_joints_and_along_edges_keep_their_turns() {
    let d = letter_d();
    let tracer = tracer(vec![prism(d.clone(), DAffine3::IDENTITY)]);
    let joints: Vec<DVec2> = d.segments().map(|s| s.start()).collect();
    let mut random = Random(3);
    for &a in &joints {
        for &b in &joints {
            if a == b {
                continue;
            }
            for z in [0.25, 0.5] {
                let (a, b) = (a.extend(z), b.extend(z));
                let from = a - 2.0 * (b - a);
                // Whatever is hit there, it is hit by closest and by any alike.
                let ray = Ray::new(from, b - a);
                assert_eq!(tracer.hit(&ray).is_some(), tracer.occluded(&ray), "{ray:?}");
                let beside = Ray::new(from + 1e-3 * random.point(), b - a);
                let beside_hit = tracer.hit(&beside);
                assert_eq!(beside_hit.is_some(), tracer.occluded(&beside));
            }
        }
    }
}

#[test]
fn rays_along_the_extrusion_meet_planes_alone() {
    let map = maps()[2];
    let d = letter_d();
    let tracer = tracer(vec![prism(d.clone(), map)]);
    let mut random = Random(5);
    let mut inside = 0;
    for _ in 0..2000 {
        let p = DVec2::new(0.5 + 0.6 * random.next(), 0.5 + 0.6 * random.next());
        let from = map.transform_point3(p.extend(-2.0));
        let ray = Ray::new(from, map.matrix3.z_axis);
        let hit = tracer.hit(&ray);
        assert_eq!(hit.is_some(), d.contains(p), "{p}");
        if let Some(hit) = hit {
            inside += 1;
            assert_eq!((hit.triangle, hit.entering), (0, true));
            assert!(
                (hit.t - 2.0).abs() < 1e-4 && (hit.u - p.x).abs() < 1e-4,
                "{hit:?}"
            );
            let back = Ray::new(map.transform_point3(p.extend(0.5)), ray.direction);
            let hit = tracer.hit(&back).expect("from inside");
            assert_eq!((hit.triangle, hit.entering), (1, false));
        }
    }
    assert!(inside > 300);
}

#[test]
fn rays_in_the_planes_meet_the_sides() {
    let tracer = tracer(vec![prism(rectangle(), DAffine3::IDENTITY)]);
    for z in [0.0, 1.0] {
        let ray = Ray::new(DVec3::new(-1.0, 0.5, z), DVec3::X);
        let hit = tracer.hit(&ray).expect("the rim belongs to the prism");
        assert_eq!((hit.t, hit.entering), (1.0, true));
        assert!(tracer.occluded(&ray));
    }
    for z in [-0.001, 1.001] {
        let ray = Ray::new(DVec3::new(-1.0, 0.5, z), DVec3::X);
        assert!(tracer.hit(&ray).is_none() && !tracer.occluded(&ray));
    }
}

#[test]
fn no_ray_leaves_the_hole_of_a_letter_but_through_its_planes() {
    // From inside of the hole every ray that stays between the planes hits the letter.
    let d = letter_d();
    let tracer = tracer(vec![prism(d.clone(), DAffine3::IDENTITY)]);
    let centre = DVec2::new(8.5, 10.0) / 23.0;
    assert!(!d.contains(centre));
    let corners: Vec<DVec2> = d.segments().map(|s| s.start()).collect();
    let mut random = Random(9);
    for k in 0..50_000 {
        let from = (centre + 0.02 * DVec2::new(random.next(), random.next())).extend(0.5);
        let direction = if k % 3 == 0 {
            corners[k / 3 % corners.len()].extend(0.5) - from
        } else {
            DVec2::from_angle(3.2 * random.next()).extend(0.01 * random.next())
        };
        let ray = Ray::new(from, direction);
        assert!(tracer.occluded(&ray), "{ray:?}");
        assert!(tracer.hit(&ray).is_some_and(|h| h.entering), "{ray:?}");
    }
}

#[test]
fn rays_that_leave_a_surface_do_not_meet_it_again() {
    for map in maps() {
        let tracer = tracer(vec![prism(gear(40), map)]);
        let mut random = Random(21);
        let mut left = 0;
        for ray in rays(&tracer, 5000) {
            let Some(hit) = tracer.hit(&ray) else {
                continue;
            };
            // Away from a convex point nothing is in the way for a tiny distance.
            let side = if hit.entering {
                hit.normal
            } else {
                -hit.normal
            };
            let from = tracer.leaving(hit.position, side);
            let mut direction = random.unit();
            if direction.dot(side) < 0.0 {
                direction = -direction;
            }
            let near = Ray {
                t_max: 1e-5 * tracer.bounds().diagonal(),
                ..Ray::new(from, direction)
            };
            left += 1;
            assert!(!tracer.occluded(&near), "{hit:?} {near:?}");
        }
        assert!(left > 1000);
    }
}

#[test]
fn many_contours_make_one_figure() {
    // A page as one figure: letters with holes, side by side.
    let mut page = Figure::default();
    for k in 0..40 {
        let pen = DVec2::new(f64::from(k % 8), f64::from(k / 8)) * 1.2;
        for mut contour in letter_d().contours {
            for curve in &mut contour.curves {
                match curve {
                    Curve::Line { start } => *start += pen,
                    Curve::Cubic {
                        start,
                        control1,
                        control2,
                    } => {
                        for p in [start, control1, control2] {
                            *p += pen;
                        }
                    }
                }
            }
            page.contours.push(contour);
        }
    }
    let tracer = tracer(vec![prism(page.clone(), DAffine3::IDENTITY)]);
    let mut random = Random(31);
    let mut inside = 0;
    for ray in rays(&tracer, 20_000) {
        let from = tracer.world_ray(&tracer.kernel_ray(&ray)).origin;
        let starts_inside = (0.0..=1.0).contains(&from.z) && page.contains(from.truncate());
        let direction = random.unit();
        let hit = tracer.hit(&Ray::new(from, direction));
        inside += usize::from(starts_inside);
        assert!(hit.is_some() || !starts_inside, "{from}");
        assert!(
            hit.is_none_or(|h| h.entering != starts_inside),
            "{from} {hit:?}"
        );
    }
    assert!(inside > 1000);
}

#[test]
fn figures_of_nothing_are_not_met() {
    let point = Figure::polygon([DVec2::ONE; 3]);
    let stroke = Figure::polygon([DVec2::ZERO, DVec2::ONE, DVec2::ZERO]);
    let lens = Figure {
        contours: vec![Contour {
            curves: vec![Curve::Cubic {
                start: DVec2::ZERO,
                control1: DVec2::X,
                control2: DVec2::X,
            }],
        }],
        rule: FillRule::NonZero,
    };
    let hollow = Figure {
        contours: vec![Contour::default()],
        rule: FillRule::EvenOdd,
    };
    let solids: Vec<Solid> = [Figure::default(), point, stroke, lens, hollow]
        .map(|figure| prism(figure, DAffine3::IDENTITY))
        .into();
    let tracer = tracer(solids);
    assert_eq!(tracer.item_count(), 5);
    assert_eq!((tracer.item(3).object, tracer.item(3).face), (0, 3));
    let mut random = Random(2);
    for _ in 0..5000 {
        let ray = Ray::new(3.0 * random.point(), random.unit());
        assert_eq!(tracer.hit(&ray).is_some(), tracer.occluded(&ray));
    }
}

#[test]
fn leaves_name_their_objects() {
    let row: Vec<Solid> = (0..5)
        .map(|k| {
            let map = DAffine3::from_translation(DVec3::new(2.0 * f64::from(k), 0.0, 0.0));
            prism(rectangle(), map)
        })
        .collect();
    let above = prism(letter_d(), DAffine3::from_translation(5.0 * DVec3::Y));
    let scene = scene([exact(row), exact(vec![above])]);
    let tracer = Tracer::new(&scene);
    for k in 0..5 {
        let from = DVec3::new(2.0 * f64::from(k) + 0.5, 0.5, 3.0);
        let hit = tracer.hit(&Ray::new(from, -DVec3::Z)).expect("above one");
        assert_eq!((hit.object, hit.face, hit.item), (0, k as u32, k as u32));
        assert_eq!((hit.triangle, hit.normal), (1, DVec3::Z));
    }
    let hit = tracer.hit(&Ray::new(DVec3::new(0.1, 5.5, 3.0), -DVec3::Z));
    let hit = hit.expect("the stem");
    assert_eq!((hit.object, hit.face, hit.item), (1, 0, 5));
    assert!(!tracer.item(hit.item).is_primitive);
}

#[test]
fn a_figure_of_a_million_curves_is_met_at_once() {
    let count = 1_000_000;
    let figure = gear(count);
    let tracer = tracer(vec![prism(figure, DAffine3::IDENTITY)]);
    let start = std::time::Instant::now();
    let mut hits = 0;
    for ray in rays(&tracer, 20_000) {
        hits += usize::from(tracer.hit(&ray).is_some());
    }
    assert!(hits > 5000, "{hits}");
    assert!(
        start.elapsed().as_secs_f64() < 50.0,
        "{:?}",
        start.elapsed()
    );
}
