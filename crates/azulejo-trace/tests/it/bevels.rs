//! Bevelled prisms against closed forms and against their definition.

use crate::csg::{csg, surfaces};
use crate::prisms::{flat, gear, letter_d, maps, rays, rectangle, tracer};
use azulejo_scene::math::{Ray, normal_matrix};
use azulejo_scene::rim::Rim;
use azulejo_scene::{Bevel, BevelEnds, BevelProfile, Figure, FillRule, Operation, Prism, Solid};
use azulejo_trace::KernelRay;
use glam::{DAffine3, DVec2, DVec3};
use std::sync::Arc;

const PROFILES: [BevelProfile; 2] = [BevelProfile::Chamfer, BevelProfile::Round];

fn bevel(profile: BevelProfile, inset: f64, depth: f64, ends: BevelEnds) -> Bevel {
    Bevel {
        profile,
        inset,
        depth,
        ends,
    }
}

fn bevelled(figure: &Figure, world_from_figure: DAffine3, bevel: Bevel) -> Solid {
    Solid::Prism(Prism {
        figure: Arc::new(figure.clone()),
        world_from_figure,
        material: 0,
        bevel: Some(Arc::new(bevel)),
    })
}

/// A letter of straight lines with reflex corners, and with a foot narrower than most bevels.
fn letter_e() -> Figure {
    let corners = [
        (0.0, 0.0),
        (0.7, 0.0),
        (0.7, 0.2),
        (0.25, 0.2),
        (0.25, 0.4),
        (0.6, 0.45),
        (0.6, 0.5),
        (0.25, 0.55),
        (0.25, 0.8),
        (0.72, 0.8),
        (0.7, 1.0),
        (0.0, 1.0),
    ];
    Figure::polygon(corners.map(DVec2::from))
}

/// Contours that cross and overlap.
fn overlapping(rule: FillRule) -> Figure {
    let mut figure = letter_d();
    let aside = |s: azulejo_scene::figure::Segment| s.start() + DVec2::new(0.05, -0.07);
    let corners: Vec<DVec2> = letter_e().segments().map(aside).collect();
    // Around the same way as the other outline, so that both together are a union.
    figure
        .contours
        .extend(Figure::polygon(corners.into_iter().rev()).contours);
    figure.rule = rule;
    figure
}

/// The definition, by the distance from chords of the border.
struct Definition {
    chords: Figure,
    border: Vec<[DVec2; 2]>,
    bevel: Bevel,
    figure_from_world: DAffine3,
}

impl Definition {
    fn new(figure: &Figure, map: DAffine3, bevel: Bevel) -> Definition {
        let chords = flat(figure, 1e-5);
        Definition {
            border: border(&chords),
            chords,
            bevel,
            figure_from_world: map.inverse(),
        }
    }

    /// Above 0 inside, below 0 outside; near the surface about the distance from it in figure space.
    fn value(&self, world: DVec3) -> f64 {
        let p = self.figure_from_world.transform_point3(world);
        let xy = p.truncate();
        let distances = self.border.iter().map(|[a, b]| {
            let way = b - a;
            let share = (way.dot(xy - a) / way.length_squared()).clamp(0.0, 1.0);
            (a + share * way).distance(xy)
        });
        let distance = distances.fold(f64::INFINITY, f64::min);
        let signed = if self.chords.contains(xy) {
            distance
        } else {
            -distance
        };
        (signed - self.bevel.setback(p.z)).min(p.z).min(1.0 - p.z)
    }
}

/// The parts of chords with the inside on one side alone.
fn border(chords: &Figure) -> Vec<[DVec2; 2]> {
    let pieces = Rim::new(chords).pieces;
    pieces
        .iter()
        .map(|p| [p.segment.start(), p.segment.end()])
        .collect()
}

/// All surfaces along random rays come in and go out by turns, lie where the definition changes its sign, face
/// outwards, and none of them is missing.
fn check(name: &str, figure: &Figure, map: DAffine3, bevel: Bevel) {
    let tracer = tracer(vec![bevelled(figure, map, bevel)]);
    let definition = Definition::new(figure, map, bevel);
    let size = tracer.bounds().diagonal();
    let (mut met, mut sloping) = (0, 0);
    for (k, ray) in rays(&tracer, 600).into_iter().enumerate() {
        let direction = ray.direction.normalize();
        let ray = Ray::new(ray.origin - 2.0 * size * direction, direction);
        let found = surfaces(&tracer, &ray);
        assert_eq!(!found.is_empty(), tracer.occluded(&ray), "{name} {ray:?}");
        assert_eq!(found.len() % 2, 0, "{name} {ray:?}");
        let away = |hit: &azulejo_trace::Hit| (hit.position - ray.origin).dot(direction);
        for (n, hit) in found.iter().enumerate() {
            assert_eq!(
                hit.entering,
                n % 2 == 0,
                "{name} ray {k}, surface {n}: {hit:?}"
            );
            let off = definition.value(hit.position);
            assert!(
                off.abs() < 3e-5,
                "{name} ray {k}, surface {n}: off by {off} at {hit:?}"
            );
            let [before, behind] =
                [1e-4, -1e-4].map(|step| hit.position + step * size * hit.normal);
            let values = [before, behind].map(|p| definition.value(p));
            assert!(
                values[0] < 0.0 && values[1] > values[0],
                "{name} ray {k}: {values:?} {hit:?}"
            );
            assert_eq!(
                hit.normal.dot(direction) < 0.0,
                hit.entering,
                "{name} ray {k}: {hit:?}"
            );
            let normal = normal_matrix(definition.figure_from_world.inverse().matrix3.inverse())
                * hit.normal;
            let [across, up] = [normal.truncate().length(), normal.z.abs()];
            sloping += usize::from(across > 1e-3 * up && up > 1e-3 * across);
        }
        met += found.len();
        for step in 0..24 {
            let t = size * (1.0 + 3.0 * (f64::from(step) + 0.5) / 24.0);
            let value = definition.value(ray.origin + t * direction);
            let before = found.iter().filter(|h| away(h) < t).count();
            let is_near = found.iter().any(|h| (away(h) - t).abs() < 1e-4 * size);
            if value.abs() > 1e-4 && !is_near {
                assert_eq!(
                    value > 0.0,
                    before % 2 == 1,
                    "{name} ray {k} at {t}: {value} {found:?}"
                );
            }
        }
    }
    assert!(
        met > 200 && sloping > 20,
        "{name}: {met} surfaces, {sloping} of bevels"
    );
}

#[test]
fn bevels_are_where_their_definition_says() {
    let figures = [
        ("D", letter_d()),
        ("E", letter_e()),
        ("gear", gear(40)),
        ("overlapping", overlapping(FillRule::NonZero)),
        ("crossing", overlapping(FillRule::EvenOdd)),
    ];
    for (name, figure) in &figures {
        for profile in PROFILES {
            // The last is wider than all stems.
            for (k, (inset, depth, ends)) in [
                (0.03, 0.05, BevelEnds::Front),
                (0.06, 0.5, BevelEnds::Both),
                (0.4, 0.3, BevelEnds::Both),
            ]
            .into_iter()
            .enumerate()
            {
                let name = format!("{name} {profile:?} {inset}");
                check(
                    &name,
                    figure,
                    maps()[(k + 1) % 4],
                    bevel(profile, inset, depth, ends),
                );
            }
        }
    }
}

/// Whether anything is met is decided without looking for what is met first: both must agree, also on parts of a ray
/// that begin or end inside, where contours cross, coincide or cancel each other, and between bevels.
#[test]
fn anything_is_met_exactly_where_a_first_thing_is() {
    let mut twice = letter_d();
    twice.contours.extend(letter_d().contours);
    let figures = [letter_d(), letter_e(), gear(40), twice]
        .into_iter()
        .chain([FillRule::NonZero, FillRule::EvenOdd].map(overlapping));
    for (k, figure) in figures.enumerate() {
        let plain = crate::prisms::prism(figure.clone(), maps()[k % 4]);
        let round = bevel(PROFILES[k % 2], 0.05, 0.2, BevelEnds::Both);
        for solid in [plain, bevelled(&figure, maps()[k % 4], round)] {
            let tracer = tracer(vec![solid]);
            let parts: Vec<KernelRay> = rays(&tracer, 20_000)
                .iter()
                .enumerate()
                .map(|(k, ray)| KernelRay {
                    t_min: 0.1 * (k % 7) as f32,
                    t_max: 0.5 + 0.2 * (k % 11) as f32,
                    ..tracer.kernel_ray(ray)
                })
                .collect();
            let (mut hits, mut blocked) = (Vec::new(), Vec::new());
            tracer.closest(&parts, &mut hits);
            tracer.any(&parts, &mut blocked);
            let met = hits.iter().filter(|h| h.is_hit()).count();
            assert!((500..19_500).contains(&met) || k == 3, "{k}: {met}");
            for (j, (hit, blocked)) in hits.iter().zip(&blocked).enumerate() {
                assert_eq!(
                    hit.is_hit(),
                    *blocked,
                    "figure {k}, ray {j}: {:?}",
                    parts[j]
                );
            }
        }
    }
}

/// The distance of a bevelled unit square's surface along a ray from outside: the last of the entries into
/// half-spaces and, for a round one, by the cylinders' quadratic equations.
#[test]
fn squares_have_planes_and_cylinders_at_their_edges() {
    let (b, map) = (0.2, DAffine3::IDENTITY);
    for profile in PROFILES {
        let tracer = tracer(vec![bevelled(
            &rectangle(),
            map,
            bevel(profile, b, b, BevelEnds::Both),
        )]);
        let mut sloping = 0;
        for ray in rays(&tracer, 20_000) {
            let Some(hit) = tracer.hit(&ray) else {
                continue;
            };
            let p = hit.position;
            // Each coordinate's distance from its nearest face of the cube, and the direction there.
            let [x, y, z] = p.to_array().map(|c| c.min(1.0 - c));
            let outward = |c: f64| if c < 0.5 { -1.0 } else { 1.0 };
            let side = x.min(y);
            let normal = if x < y {
                DVec3::X * outward(p.x)
            } else {
                DVec3::Y * outward(p.y)
            };
            let plane = DVec3::Z * outward(p.z);
            if z >= b || side >= b {
                let (off, expected) = if z >= b { (side, normal) } else { (z, plane) };
                let is_edge = (z - b).abs() < 1e-6 || (side - b).abs() < 1e-6;
                assert!(off.abs() < 1e-12, "{hit:?}");
                assert!(
                    is_edge || (hit.normal - expected).length() < 1e-9,
                    "{hit:?}"
                );
                continue;
            }
            sloping += 1;
            let (off, expected) = match profile {
                BevelProfile::Chamfer => (side + z - b, normal + plane),
                BevelProfile::Round => (
                    (b - side).hypot(b - z) - b,
                    (b - side) * normal + (b - z) * plane,
                ),
            };
            assert!(off.abs() < 1e-12, "{profile:?} {off} {hit:?}");
            let is_mitre = (x - y).abs() < 1e-9;
            let turned = (hit.normal - expected.normalize()).length();
            assert!(is_mitre || turned < 1e-6, "{profile:?} {turned} {hit:?}");
        }
        assert!(sloping > 1000, "{sloping}");
    }
}

#[test]
fn rays_along_the_extrusion_meet_the_bevel_at_its_height() {
    let figure = letter_d();
    for profile in PROFILES {
        let shape = bevel(profile, 0.05, 0.3, BevelEnds::Both);
        let definition = Definition::new(&figure, DAffine3::IDENTITY, shape);
        let tracer = tracer(vec![bevelled(&figure, DAffine3::IDENTITY, shape)]);
        let mut met = 0;
        for k in 0..2000 {
            let p = DVec2::new(f64::from(k % 47) / 46.0, f64::from(k / 47) / 42.0);
            let found = surfaces(&tracer, &Ray::new(p.extend(-2.0), DVec3::Z));
            if figure.contains(p) && definition.value(p.extend(0.5)) > 1e-3 {
                assert_eq!(found.len(), 2, "{p}");
                let [low, high] = [0, 1].map(|k: usize| found[k].position.z);
                assert!(
                    (low + high - 1.0).abs() < 1e-4,
                    "{profile:?} {p} {low} {high}"
                );
                assert!(definition.value(found[0].position).abs() < 3e-5);
                met += 1;
            }
        }
        assert!(met > 300, "{met}");
    }
}

#[test]
fn lines_in_the_surface_and_through_seams_keep_their_turns() {
    for profile in PROFILES {
        let shape = bevel(profile, 0.1, 0.2, BevelEnds::Both);
        let tracer = tracer(vec![bevelled(&letter_e(), DAffine3::IDENTITY, shape)]);
        let corners: Vec<DVec2> = letter_e().segments().map(|s| s.start()).collect();
        for &a in &corners {
            for &b in &corners {
                for (za, zb) in [(0.0, 0.2), (0.2, 0.2), (0.2, 0.8), (0.1, 0.1), (0.05, 0.3)] {
                    let (a, b) = (a.extend(za), b.extend(zb));
                    if a == b {
                        continue;
                    }
                    let ray = Ray::new(a - 3.0 * (b - a), b - a);
                    assert_eq!(tracer.hit(&ray).is_some(), tracer.occluded(&ray), "{ray:?}");
                }
            }
        }
        // In the plane of a chamfer, and in parallel ones just above and below.
        for shift in [-1e-9, -1e-16, 0.0, 1e-16, 1e-9] {
            let ray = Ray::new(DVec3::new(-1.0, 0.05 + shift, 0.1), DVec3::X);
            assert_eq!(tracer.hit(&ray).is_some(), tracer.occluded(&ray), "{ray:?}");
        }
    }
}

#[test]
fn set_operations_cut_and_join_bevelled_prisms() {
    let map = maps()[2];
    let shape = bevel(BevelProfile::Round, 0.05, 0.2, BevelEnds::Both);
    let other = map * DAffine3::from_translation(DVec3::new(0.3, 0.1, 0.4));
    let operands = [(letter_d(), map), (letter_e(), other)];
    for operation in [
        Operation::Union,
        Operation::Difference,
        Operation::Intersection,
    ] {
        let [left, right] = [0, 1].map(|k| vec![bevelled(&operands[k].0, operands[k].1, shape)]);
        let tracer = tracer(vec![csg(operation, left, right)]);
        let [a, b] = [0, 1].map(|k| Definition::new(&operands[k].0, operands[k].1, shape));
        let value = |p: DVec3| match operation {
            Operation::Union => a.value(p).max(b.value(p)),
            Operation::Difference => a.value(p).min(-b.value(p)),
            Operation::Intersection => a.value(p).min(b.value(p)),
        };
        let size = tracer.bounds().diagonal();
        let mut met = 0;
        for ray in rays(&tracer, 3000) {
            let ray = Ray::new(
                ray.origin - 3.0 * size * ray.direction.normalize(),
                ray.direction,
            );
            for (n, hit) in surfaces(&tracer, &ray).iter().enumerate() {
                assert_eq!(hit.entering, n % 2 == 0, "{operation:?} {ray:?}");
                assert!(value(hit.position).abs() < 3e-5, "{operation:?} {hit:?}");
                met += 1;
            }
        }
        assert!(met > 200, "{operation:?} {met}");
    }
}
