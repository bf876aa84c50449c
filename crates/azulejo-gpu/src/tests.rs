//! Cards against closed forms and the processor.

use crate::{Backend, Card, Reduction};
use azulejo_scene::Rgb;
use azulejo_testing::Need;
use azulejo_trace::item_buffer::{
    Beyond, Device, Facet, Mirror, NO_MIRROR, Seen, Settings, Share, View, World,
};
use glam::DVec3;

/// One card for each interface that works on this machine. Records a skip if none does.
fn by_interface() -> Vec<(Backend, Card)> {
    let cards: Vec<_> = [Backend::Vulkan, Backend::Gl]
        .into_iter()
        .filter_map(|backend| Some((backend, Card::open(backend).ok()?)))
        .collect();
    let cards = if cards.is_empty() {
        Err("no graphics driver")
    } else {
        Ok(cards)
    };
    azulejo_testing::require(Need::Gpu, cards).unwrap_or_default()
}

/// The cards alone.
fn found() -> Vec<Card> {
    by_interface().into_iter().map(|(_, card)| card).collect()
}

/// The same, for both places of summation.
fn cards() -> Vec<Card> {
    let ways = [Reduction::ReadBack, Reduction::Compute];
    let both = |card: Card| ways.map(|way| card.clone().reducing(way));
    found().into_iter().flat_map(both).collect()
}

/// A room 0..1 in all directions; walls x = 0, x = 1, y = 0, … of `n` × `n` patches each, which
/// face inwards.
fn room(n: u32) -> World {
    let mut world = World {
        up: DVec3::Z,
        ..World::default()
    };
    let at = |k: u32| f64::from(k) / f64::from(n);
    for wall in 0..6 {
        let (axis, is_far) = (wall / 2, wall % 2 == 1);
        let corner = |u: f64, v: f64| {
            let mut p = DVec3::ZERO;
            p[axis] = if is_far { 1.0 } else { 0.0 };
            p[(axis + 1) % 3] = u;
            p[(axis + 2) % 3] = v;
            p
        };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let mut quad =
                [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| corner(at(i + a), at(j + b)));
            if is_far {
                quad.reverse();
            }
            let patch = world.patches;
            world
                .triangles
                .extend([[0, 1, 2], [0, 2, 3]].map(|t| Facet {
                    corners: t.map(|k| quad[k]),
                    patch,
                }));
            world.patches += 1;
        }
    }
    world
}

fn mirror_wall(world: &mut World, wall: u32, reflectance: Rgb) {
    let per_wall = world.patches / 6;
    if world.mirror_of.is_empty() {
        world.mirror_of = vec![NO_MIRROR; world.patches as usize];
    }
    let axis = (wall / 2) as usize;
    let mut normal = DVec3::ZERO;
    normal[axis] = 1.0;
    for patch in wall * per_wall..(wall + 1) * per_wall {
        world.mirror_of[patch as usize] = world.mirrors.len() as u32;
    }
    world.mirrors.push(Mirror {
        point: normal * f64::from(wall % 2),
        normal,
        reflectance,
    });
}

const FLOOR: View = View {
    eye: DVec3::new(0.5, 0.5, 1e-6),
    normal: DVec3::Z,
    turn: 0.3,
};

fn windows(resolution: u32) -> Settings {
    Settings {
        resolution,
        mirrors: Beyond::Windows {
            cut: 0.0,
            depth: 100,
            windows: u32::MAX,
        },
    }
}

fn draw(card: &Card, world: &World, settings: &Settings, views: &[View]) -> Vec<Seen> {
    let buffers = card.load(world, settings).expect("loads");
    buffers.draw(views).expect("draws")
}

/// Share of one wall at one order.
fn wall(seen: &Seen, per_wall: u32, wall: u32, order: u8) -> f64 {
    let is_it = |side: u32| side.is_multiple_of(2) && side / 2 / per_wall == wall;
    let shares = seen
        .shares
        .iter()
        .filter(|s| is_it(s.side) && s.order == order);
    shares.map(|s| s.weight.r).sum()
}

/// The light that is absorbed, with the reflectances of the mirrors, escapes or was cut.
fn balance(world: &World, seen: &Seen) -> Rgb {
    let kept = |side: u32| match world.mirror_of.get(side as usize / 2) {
        _ if world.is_bent.get(side as usize / 2) == Some(&true) => Rgb::WHITE,
        Some(&m) if m != NO_MIRROR => Rgb::WHITE - world.mirrors[m as usize].reflectance,
        _ => Rgb::WHITE,
    };
    let shares = seen.shares.iter();
    let absorbed = shares.map(|s| s.weight * kept(s.side));
    absorbed.fold(Rgb::BLACK, |a, b| a + b) + seen.escaped[0] + seen.escaped[1] + seen.cut
}

fn assert_close(value: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{what}: {value}, expected {expected}"
    );
}

#[test]
fn an_eye_in_the_middle_of_the_floor_sees_five_walls() {
    let world = room(3);
    for card in cards() {
        let seen = &draw(&card, &world, &windows(128), &[FLOOR])[0];
        // Point to parallel rectangle, four quarters: Howell's B-3.
        let (x, y) = (0.5f64, 0.5f64);
        let (a, b) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
        let quarter = (x / a * (y / a).atan() + y / b * (x / b).atan()) / std::f64::consts::TAU;
        let name = card.name();
        assert_close(wall(seen, 9, 5, 0), 4.0 * quarter, 1e-3, &name);
        for side in 0..4 {
            assert_close(wall(seen, 9, side, 0), 0.25 - quarter, 1e-3, &name);
        }
        assert_close(balance(&world, seen).r, 1.0, 1e-6, &name);
        assert!(
            seen.shares.iter().all(|s| s.side.is_multiple_of(2)),
            "{name}: a back is seen"
        );
    }
}

/// Random boxes, seen from inside, fronts outwards.
fn clutter(count: u32) -> World {
    let mut world = room(2);
    let number = |k: u32, d: u32| f64::from(azulejo_trace::sampling::uniform(&[k, d]));
    for k in 0..count {
        let at = DVec3::new(number(k, 0), number(k, 1), number(k, 2));
        let edge = |d| (DVec3::new(number(k, d), number(k, d + 1), number(k, d + 2)) - 0.5) * 0.2;
        world.triangles.push(Facet {
            corners: [at, at + edge(3), at + edge(6)],
            patch: world.patches,
        });
        world.patches += 1;
    }
    world
}

/// Views from all over the room.
fn views(count: u32) -> Vec<View> {
    let number = |k: u32, d: u32| f64::from(azulejo_trace::sampling::uniform(&[k, d]));
    let view = |k| View {
        eye: 0.1 + 0.8 * DVec3::new(number(k, 10), number(k, 11), number(k, 12)),
        normal: DVec3::new(number(k, 13), number(k, 14), number(k, 15) + 0.1).normalize(),
        turn: 6.0 * number(k, 16),
    };
    (0..count).map(view).collect()
}

/// Views from the walls of the room, ever closer to its edges.
fn views_near_edges() -> Vec<View> {
    let view = |k: i32| View {
        eye: DVec3::new(0.3, 0.6 * 10f64.powi(-k), 4e-6),
        normal: DVec3::Z,
        turn: f64::from(k),
    };
    (0..6).map(view).collect()
}

/// Sum of differences of shares.
fn difference(a: &Seen, b: &Seen) -> f64 {
    let mut sums = std::collections::BTreeMap::new();
    for (seen, sign) in [(a, 1.0), (b, -1.0)] {
        for s in &seen.shares {
            *sums.entry((s.side, s.order)).or_insert(0.0) += sign * s.weight.mean();
        }
    }
    sums.values().map(|d: &f64| d.abs()).sum()
}

/// The same worlds by the card and by the processor; pixels on edges may differ.
#[test]
fn the_processor_sees_the_same() {
    let mut mirrored = clutter(300);
    mirror_wall(&mut mirrored, 1, Rgb::grey(0.8));
    mirror_wall(&mut mirrored, 2, Rgb::new(0.9, 0.5, 0.1));
    let mut bent = mirrored.clone();
    bent.is_bent = (0..bent.patches).map(|p| p % 7 == 3).collect();
    let list = Settings {
        resolution: 50,
        mirrors: Beyond::List,
    };
    let cases = [
        ("plain", clutter(300), windows(64), views(11)),
        ("mirrors", mirrored.clone(), windows(64), views(11)),
        ("bent", bent.clone(), windows(32), views(11)),
        ("list", bent, list, views(11)),
        ("edges", mirrored, windows(64), views_near_edges()),
        ("long facets", room(1), windows(64), views_near_edges()),
    ];
    for card in cards() {
        for (case, world, settings, views) in &cases {
            let results = draw(&card, world, settings, views);
            let processor = azulejo_trace::item_buffer::Processor.load(world, settings);
            let expected = processor.and_then(|p| p.draw(views)).expect("never fails");
            for (k, (a, b)) in results.iter().zip(&expected).enumerate() {
                let name = format!("{} {case} {k}", card.name());
                let off = difference(a, b);
                assert!(off < 0.01, "{name}: {off}");
                if settings.mirrors != Beyond::List {
                    assert_close(balance(world, a).g, 1.0, 1e-6, &name);
                }
                assert_close(a.cut.g, b.cut.g, 1e-3, &name);
                let (some, all) = (a.specular.len() as f64, b.specular.len() as f64);
                assert_close(some, all, 0.02 * all + 2.0, &name);
            }
        }
    }
}

#[test]
fn neighbours_threads_and_repetition_change_nothing() {
    let mut world = clutter(100);
    mirror_wall(&mut world, 4, Rgb::new(0.7, 0.5, 0.2));
    let settings = windows(16);
    for card in cards() {
        let buffers = card.load(&world, &settings).expect("loads");
        // More than one batch, so that several tiles and atlases are used.
        let views = views(2 * buffers.batch() as u32 + 3);
        let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let draw = |threads| {
            let pool = pool(threads).expect("threads start");
            pool.install(|| buffers.draw(&views)).expect("draws")
        };
        let one = draw(1);
        assert_eq!(one, draw(3), "{}", card.name());
        let last = views.len() - 1;
        let alone = buffers.draw(&views[last..]).expect("draws");
        assert_eq!(one[last], alone[0], "{}", card.name());
    }
}

#[test]
fn many_threads_may_draw_at_once() {
    let world = clutter(30);
    for card in cards() {
        let buffers = card.load(&world, &windows(16)).expect("loads");
        let views = views(24);
        let expected = buffers.draw(&views).expect("draws");
        use rayon::prelude::*;
        let one = |v: &View| {
            buffers
                .draw(std::slice::from_ref(v))
                .expect("draws")
                .remove(0)
        };
        let results: Vec<Seen> = views.par_iter().map(one).collect();
        assert_eq!(results, expected, "{}", card.name());
    }
}

#[test]
fn both_ways_to_add_up_agree() {
    let mut world = clutter(200);
    mirror_wall(&mut world, 0, Rgb::grey(0.5));
    // A hole, for light to escape.
    world.triangles.retain(|t| t.patch != 5);
    for pair in cards().chunks_exact(2) {
        let [a, b] = [0, 1].map(|k| draw(&pair[k], &world, &windows(64), &views(9)));
        for (a, b) in a.iter().zip(&b) {
            let off = difference(a, b);
            assert!(off < 1e-6, "{}: {off}", pair[0].name());
            for way in 0..2 {
                let (a, b) = (a.escaped[way].r, b.escaped[way].r);
                assert_close(a, b, 1e-6, "escaped");
            }
        }
    }
}

#[test]
fn facing_mirrors_come_to_an_end() {
    let mut world = room(1);
    mirror_wall(&mut world, 0, Rgb::new(1.0, 0.9, 0.5));
    mirror_wall(&mut world, 1, Rgb::new(1.0, 0.8, 0.5));
    let settings = Settings {
        resolution: 32,
        mirrors: Beyond::Windows {
            cut: 0.0,
            depth: 8,
            windows: u32::MAX,
        },
    };
    for card in cards() {
        let seen = &draw(&card, &world, &settings, &[FLOOR])[0];
        let name = card.name();
        let sum = balance(&world, seen);
        for (k, sum) in [sum.r, sum.g, sum.b].into_iter().enumerate() {
            assert_close(sum, 1.0, 1e-6, &format!("{name}, channel {k}"));
        }
        assert!(
            seen.cut.r > 1e-4 && seen.cut.b < 1e-2 * seen.cut.r,
            "{name}: {:?}",
            seen.cut
        );
        assert!(seen.escaped[0].r + seen.escaped[1].r < 1e-3, "{name}");
    }
}

#[test]
fn only_mirrors_and_a_mirror_that_faces_itself() {
    let mut world = room(2);
    for wall in 0..6 {
        mirror_wall(&mut world, wall, Rgb::grey(0.6));
    }
    for card in cards() {
        let seen = &draw(&card, &world, &windows(16), &[FLOOR])[0];
        assert_close(balance(&world, seen).r, 1.0, 1e-6, &card.name());
    }
    // The viewpoint in the mirror's own plane, and a world of the mirror alone.
    let mut alone = room(1);
    mirror_wall(&mut alone, 4, Rgb::grey(0.6));
    alone.triangles.retain(|t| t.patch == 4);
    for card in cards() {
        for height in [0.0, 1e-6] {
            let view = View {
                eye: DVec3::new(0.5, 0.5, height),
                ..FLOOR
            };
            let seen = &draw(&card, &alone, &windows(16), &[view])[0];
            assert_close(seen.escaped[0].r, 1.0, 1e-6, &card.name());
            assert!(seen.shares.is_empty(), "{}", card.name());
        }
    }
}

/// 100,000 facets in all directions, each a mirror of its own.
#[test]
fn countless_mirrors_come_to_an_end() {
    let mut world = World {
        up: DVec3::Z,
        ..World::default()
    };
    let number = |k: u32, d: u32| f64::from(azulejo_trace::sampling::uniform(&[k, d])) - 0.5;
    for k in 0..100_000 {
        let out = DVec3::new(number(k, 0), number(k, 1), number(k, 2)).normalize();
        let edge = |d| DVec3::new(number(k, d), number(k, d + 1), number(k, d + 2)) * 0.02;
        let corners = [out, out + edge(3), out + edge(6)];
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        world.triangles.push(Facet { corners, patch: k });
        world.mirrors.push(Mirror {
            point: out,
            normal: normal.normalize(),
            reflectance: Rgb::grey(0.9),
        });
    }
    world.patches = 100_000;
    world.mirror_of = (0..100_000).collect();
    let settings = Settings {
        resolution: 48,
        mirrors: Beyond::Windows {
            cut: 1e-7,
            depth: 1000,
            windows: 500,
        },
    };
    let view = View {
        eye: DVec3::ZERO,
        ..FLOOR
    };
    for card in cards() {
        let seen = &draw(&card, &world, &settings, &[view])[0];
        assert_close(balance(&world, seen).r, 1.0, 1e-6, &card.name());
        assert!(seen.cut.r != 0.0, "{}: nothing was cut", card.name());
        assert!(seen.cut.r.abs() < 0.02, "{}: {:?}", card.name(), seen.cut);
    }
}

#[test]
fn bad_worlds_are_drawn_without_their_bad_parts() {
    let good = room(1);
    let mut bad = good.clone();
    let corner = DVec3::splat(0.5);
    let mut add = |corners: [DVec3; 3], patch| bad.triangles.push(Facet { corners, patch });
    add([corner, corner + DVec3::X, DVec3::NAN], 0);
    add([corner, corner + DVec3::X, DVec3::INFINITY], 0);
    add([corner, corner, corner + DVec3::X], 0);
    add([corner, corner + 0.1, corner + 0.2], 0);
    add(
        [corner, corner + 0.1 * DVec3::X, corner + 0.1 * DVec3::Y],
        77,
    );
    bad.mirror_of = vec![9; 6];
    bad.is_bent = vec![false];
    for card in cards() {
        let [expected, found] = [&good, &bad].map(|w| draw(&card, w, &windows(32), &[FLOOR]));
        assert_eq!(found, expected, "{}", card.name());
        let nowhere = View {
            eye: DVec3::NAN,
            normal: DVec3::NAN,
            turn: 0.0,
        };
        let seen = &draw(&card, &good, &windows(32), &[nowhere])[0];
        assert_close(balance(&good, seen).r, 1.0, 1e-6, &card.name());
        let empty = World {
            up: DVec3::Z,
            ..World::default()
        };
        let seen = &draw(&card, &empty, &windows(32), &[FLOOR])[0];
        assert_close(seen.escaped[0].r, 1.0, 1e-6, &card.name());
        assert_eq!(draw(&card, &good, &windows(32), &[]), []);
    }
}

/// Of two coincident facets the lower patch is visible, with its own side.
#[test]
fn coincident_facets_have_an_order() {
    let mut world = room(1);
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.3, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.5));
    let [a, b, c] = corners;
    world.triangles.push(Facet {
        corners: [a, b, c],
        patch: 7,
    });
    world.triangles.push(Facet {
        corners: [b, a, c],
        patch: 6,
    });
    world.patches = 8;
    for card in cards() {
        let seen = &draw(&card, &world, &windows(64), &[FLOOR])[0];
        let share = |side| seen.shares.iter().filter(move |s| s.side == side);
        assert_eq!(share(12).count(), 1, "{}", card.name());
        assert_eq!(
            share(13).chain(share(14)).chain(share(15)).count(),
            0,
            "{}",
            card.name()
        );
    }
}

#[test]
fn listed_pixels_are_where_things_are() {
    let mut world = room(1);
    mirror_wall(&mut world, 1, Rgb::grey(0.5));
    world.is_bent = vec![false, false, true, false, false, false];
    // Large and far from the origin, as maps are.
    let (scale, offset) = (250.0, DVec3::new(4e5, 5e6, 100.0));
    for facet in &mut world.triangles {
        facet.corners = facet.corners.map(|c| scale * c + offset);
    }
    world.mirrors[0].point = scale * world.mirrors[0].point + offset;
    let view = View {
        eye: scale * DVec3::new(0.4, 0.3, 1e-6) + offset,
        ..FLOOR
    };
    for card in cards() {
        let seen = &draw(&card, &world, &windows(64), &[view])[0];
        let name = card.name();
        for order in [0, 1] {
            let of_order = seen.specular.iter().filter(|p| p.order == order);
            let listed: f64 = of_order.map(|p| p.weight.r).sum();
            let shares = seen
                .shares
                .iter()
                .filter(|s| s.side == 4 && s.order == order);
            let shared: f64 = shares.map(|s| s.weight.r).sum();
            assert_close(listed, shared, 1e-6, &name);
            assert!(listed > 0.01, "{name}");
        }
        for p in &seen.specular {
            let hit = (p.origin + p.distance * p.direction - offset) / scale;
            assert_close(hit.y, 0.0, 1e-4, &name);
            assert!(hit.x > -1e-3 && hit.x < 1.001, "{name}: {hit}");
            let start = (p.origin - offset) / scale;
            assert!(
                p.order == 0 || (start.x - 1.0).abs() < 1e-4,
                "{name}: {start}"
            );
        }
    }
}

#[test]
fn small_limits_split_the_world_or_are_named() {
    let world = clutter(3000);
    let limits = |limits: wgpu::Limits| wgpu::Limits {
        max_buffer_size: 64 << 10,
        max_storage_buffer_binding_size: 32 << 10,
        max_uniform_buffer_binding_size: 16 << 10,
        max_texture_dimension_2d: 256,
        ..limits
    };
    for (backend, card) in by_interface() {
        let narrow = Card::open_within(backend, limits).expect("opens as well");
        let settings = windows(32);
        let [expected, found] =
            [&card, &narrow].map(|card| draw(card, &world, &settings, &views(5)));
        assert_eq!(found, expected, "{}", card.name());
        // Clusters of hardware would not fit into such buffers.
        let hardware = Card::open_within(backend, limits).expect("opens as well");
        let hardware = hardware.taken_for_hardware().reducing(Reduction::ReadBack);
        let read_back = card.clone().reducing(Reduction::ReadBack);
        let [expected, found] =
            [&read_back, &hardware].map(|card| draw(card, &world, &settings, &views(5)));
        assert_eq!(found, expected, "{}", card.name());
        let error = narrow
            .load(&world, &windows(128))
            .err()
            .expect("too large")
            .to_string();
        assert!(
            error.contains("128 × 384") && error.contains("256"),
            "{error}"
        );
    }
}

#[test]
fn a_lost_card_says_so_and_stays_lost() {
    let world = clutter(50);
    for card in found() {
        let buffers = card.load(&world, &windows(32)).expect("loads");
        assert!(buffers.draw(&views(3)).is_ok());
        card.destroy();
        for _again in 0..2 {
            let error = buffers.draw(&views(3)).expect_err("lost").to_string();
            assert!(error.contains("lost"), "{error}");
        }
        assert!(card.load(&world, &windows(32)).is_err());
    }
}

/// The device is lost while other threads draw.
#[test]
fn a_card_may_be_lost_midway() {
    let world = clutter(500);
    for card in found() {
        let buffers = card.load(&world, &windows(64)).expect("loads");
        let views = views(40);
        let error = std::thread::scope(|scope| {
            let drawing = scope.spawn(|| (0..10_000).find_map(|_| buffers.draw(&views).err()));
            std::thread::sleep(std::time::Duration::from_millis(100));
            card.destroy();
            drawing.join().expect("no panic")
        });
        let error = error.expect("lost").to_string();
        assert!(error.contains("lost"), "{error}");
    }
}

/// A tilted mirror on a wall in the same plane: the wall is not visible in the mirror from any
/// distance. With a step that does not grow with the distance, all of the mirror would show the
/// wall at 100.
#[test]
fn far_mirrors_do_not_show_the_wall_that_they_hang_on() {
    let normal = DVec3::new(0.3, -0.5, 0.8).normalize();
    let [x, y, _] = View {
        eye: DVec3::ZERO,
        normal,
        turn: 0.7,
    }
    .axes();
    let mut world = World {
        up: DVec3::Z,
        patches: 2,
        mirror_of: vec![0, NO_MIRROR],
        mirrors: vec![Mirror {
            point: DVec3::ZERO,
            normal,
            reflectance: Rgb::WHITE,
        }],
        ..World::default()
    };
    for (patch, half) in [(0, 0.7), (1, 1.0)] {
        let corner = |u: f64, v: f64| half * (u * x + v * y);
        let quad = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let facet = |t: [usize; 3]| Facet {
            corners: t.map(|k| quad[k]),
            patch,
        };
        world.triangles.extend([[0, 1, 2], [0, 2, 3]].map(facet));
    }
    let towards = (normal + 0.4 * x).normalize();
    for card in cards() {
        for distance in [0.01, 1.0, 100.0] {
            let view = View {
                eye: distance * towards,
                normal: -towards,
                turn: 0.3,
            };
            let seen = &draw(&card, &world, &windows(512), &[view])[0];
            let share = |patch: u32, order: u8| -> f64 {
                let of = |s: &&Share| s.side / 2 == patch && s.order == order;
                seen.shares.iter().filter(of).map(|s| s.weight.r).sum()
            };
            let name = format!("{} from {distance}", card.name());
            assert!(share(0, 0) > 0.0, "{name}: no mirror is seen");
            assert_eq!(share(0, 1) + share(1, 1), 0.0, "{name}");
        }
    }
}
