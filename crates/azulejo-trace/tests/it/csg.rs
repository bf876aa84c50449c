//! Set operations against closed forms and against membership of points; the shapes they take.

use crate::Random;
use crate::prisms::{exact, letter_d, prism, tracer};
use azulejo_scene::math::Ray;
use azulejo_scene::{
    BicubicPatch, Csg, Mesh, Operation, Primitive, PrimitiveKind, Prism, Scene, Shape, Solid,
    synthetic,
};
use azulejo_trace::{Hit, Tracer};
use glam::{DAffine3, DQuat, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

pub(crate) fn csg(operation: Operation, left: Vec<Solid>, right: Vec<Solid>) -> Solid {
    Solid::Csg(Box::new(Csg {
        operation,
        left,
        right,
    }))
}

fn primitive(kind: PrimitiveKind, map: DAffine3) -> Solid {
    Solid::Primitive(Primitive::new(kind, map, 0))
}

fn ball(centre: DVec3, radius: f64) -> Solid {
    Solid::Primitive(Primitive::sphere(centre, radius, 0))
}

/// The cube −1..=1.
fn cube() -> Solid {
    let map = DAffine3::from_translation(-DVec3::ONE) * DAffine3::from_scale(DVec3::splat(2.0));
    primitive(PrimitiveKind::Cuboid, map)
}

fn mesh_of(solid: &Solid) -> Solid {
    let Solid::Primitive(p) = solid else {
        unreachable!("made of a primitive");
    };
    let mut mesh = p.tessellate(&p.grids(2e-5, f64::INFINITY));
    // Corners where the tessellation comes round again are the same but for rounding.
    let weld = |x: f64| (x * 1e9).round() * 1e-9;
    mesh.positions
        .iter_mut()
        .for_each(|p| *p = p.to_array().map(weld).into());
    Solid::Mesh(Box::new(mesh))
}

/// Negative inside; near a surface, the distance from it.
type Distance = fn(DVec3) -> f64;

/// All surfaces along a ray, each left by [`Tracer::leaving`].
pub(crate) fn surfaces(tracer: &Tracer, ray: &Ray) -> Vec<Hit> {
    let mut found: Vec<Hit> = Vec::new();
    let mut from = *ray;
    while let Some(hit) = tracer.hit(&from) {
        let forward = if hit.entering {
            -hit.normal
        } else {
            hit.normal
        };
        from.origin = tracer.leaving(hit.position, forward);
        found.push(hit);
        assert!(found.len() < 1000, "{ray:?}");
    }
    found
}

/// Surfaces of a solid come in and out by turns, lie where its signed distance (or any function
/// with its sign) is zero, and the outside is where the normal points.
fn check(name: &str, solid: Solid, distance: Distance) {
    let tracer = tracer(vec![solid]);
    let mut random = Random(17);
    let mut met = 0;
    for _ in 0..4000 {
        let target = 1.2 * random.point();
        let direction = random.unit();
        let ray = Ray::new(target - 8.0 * direction, direction);
        assert_eq!(tracer.hit(&ray).is_some(), tracer.occluded(&ray), "{name}");
        let found = surfaces(&tracer, &ray);
        assert_eq!(found.len() % 2, 0, "{name} {ray:?} {found:?}");
        for (k, hit) in found.iter().enumerate() {
            assert_eq!(hit.entering, k % 2 == 0, "{name} {ray:?} {found:?}");
            let step = 1e-4 * hit.normal;
            let near = [-1.0, 1.0].map(|side| distance(hit.position + side * step));
            assert!(distance(hit.position).abs() < 2e-3, "{name} {hit:?}");
            // At an edge the normal of one surface may lead into the other.
            if near.iter().all(|d| d.abs() > 9e-5) {
                met += 1;
                assert!(near[0] < 0.0 && near[1] > 0.0, "{name} {near:?} {hit:?}");
            }
        }
    }
    assert!(met > 200, "{name}: {met} surfaces");
}

fn in_cube(p: DVec3) -> f64 {
    p.abs().max_element() - 1.0
}

fn in_ball(p: DVec3) -> f64 {
    p.length() - 1.2
}

#[test]
fn operations_of_ball_and_cube() {
    let pair = || (vec![cube()], vec![ball(DVec3::ZERO, 1.2)]);
    let (a, b) = pair();
    check("union", csg(Operation::Union, a, b), |p| {
        in_cube(p).min(in_ball(p))
    });
    let (a, b) = pair();
    check("difference", csg(Operation::Difference, a, b), |p| {
        in_cube(p).max(-in_ball(p))
    });
    let (a, b) = pair();
    check("other difference", csg(Operation::Difference, b, a), |p| {
        in_ball(p).max(-in_cube(p))
    });
    let (a, b) = pair();
    check("intersection", csg(Operation::Intersection, a, b), |p| {
        in_ball(p).max(in_cube(p))
    });
}

#[test]
fn operations_nest() {
    // A shell of a ball with a bar in it, cut in half: (ball − (ball' − bar)) ∩ lower half.
    let bar = DAffine3::from_scale(DVec3::new(0.3, 0.3, 4.0))
        * DAffine3::from_translation(-0.5 * DVec3::ONE);
    let hollow = csg(
        Operation::Difference,
        vec![ball(DVec3::ZERO, 0.9)],
        vec![primitive(PrimitiveKind::Cuboid, bar)],
    );
    let shell = csg(
        Operation::Difference,
        vec![ball(DVec3::ZERO, 1.2)],
        vec![hollow],
    );
    let below = DAffine3::from_translation(DVec3::new(-2.0, -2.0, -4.0))
        * DAffine3::from_scale(DVec3::splat(4.0));
    let half = primitive(PrimitiveKind::Cuboid, below);
    check(
        "nested",
        csg(Operation::Intersection, vec![shell], vec![half]),
        |p| {
            let bar = (p.x.abs().max(p.y.abs()) - 0.15).max(p.z.abs() - 2.0);
            let hollow = (p.length() - 0.9).max(-bar);
            in_ball(p).max(-hollow).max(p.z)
        },
    );
}

#[test]
fn a_letter_cut_out_of_a_block() {
    let map = DAffine3::from_translation(DVec3::new(-0.5, -0.5, 0.5));
    let block = DAffine3::from_translation(DVec3::new(-1.0, -1.0, 0.0))
        * DAffine3::from_scale(DVec3::new(2.0, 2.0, 1.0));
    let cut = csg(
        Operation::Difference,
        vec![primitive(PrimitiveKind::Cuboid, block)],
        vec![prism(letter_d(), map)],
    );
    let tracer = tracer(vec![cut]);
    let d = letter_d();
    let mut random = Random(8);
    for _ in 0..5000 {
        let p = DVec2::new(random.next(), random.next());
        let hit = tracer.hit(&Ray::new(p.extend(3.0), -DVec3::Z));
        let hit = hit.expect("the block or the bottom of the cut");
        let in_letter = d.contains(p + DVec2::splat(0.5));
        assert_eq!(hit.face, u32::from(in_letter));
        assert!((hit.position.z - if in_letter { 0.5 } else { 1.0 }).abs() < 1e-9);
        assert!(
            hit.entering && (hit.normal - DVec3::Z).length() < 1e-9,
            "{hit:?}"
        );
    }
}

#[test]
fn a_page_of_letters_cut_out_of_a_slab() {
    let pen = |k: usize| DVec2::new((k % 20) as f64, (k / 20) as f64) * 1.1;
    let figure = Arc::new(letter_d());
    let letter = |k: usize| {
        Solid::Prism(Prism {
            figure: Arc::clone(&figure),
            world_from_figure: DAffine3::from_translation(pen(k).extend(0.5)),
            material: 0,
            bevel: None,
        })
    };
    let slab = DAffine3::from_translation(DVec3::new(-1.0, -1.0, 0.0))
        * DAffine3::from_scale(DVec3::new(24.0, 18.0, 1.0));
    let cut = csg(
        Operation::Difference,
        vec![primitive(PrimitiveKind::Cuboid, slab)],
        (0..300).map(letter).collect(),
    );
    let tracer = tracer(vec![cut]);
    let mut random = Random(8);
    for _ in 0..5000 {
        let k = (150.0 * (random.next() + 1.0)) as usize % 300;
        let p = DVec2::new(0.5 + 0.45 * random.next(), 0.5 + 0.5 * random.next());
        let from = (pen(k) + p).extend(3.0);
        let hit = tracer.hit(&Ray::new(from, -DVec3::Z)).expect("the slab");
        let expected = if figure.contains(p) { k as u32 + 1 } else { 0 };
        assert_eq!(hit.face, expected, "{p}");
        assert!(hit.entering && (hit.normal - DVec3::Z).length() < 1e-9);
    }
}

#[test]
fn meshes_are_solids_whichever_way_their_faces_are_turned() {
    let round = mesh_of(&ball(DVec3::ZERO, 1.2));
    let cut = |mesh: Solid| csg(Operation::Difference, vec![cube()], vec![mesh]);
    check("mesh", cut(round.clone()), |p| in_cube(p).max(-in_ball(p)));
    let Solid::Mesh(mut mesh) = round else {
        unreachable!()
    };
    let mut turned = Mesh::default();
    turned.positions.append(&mut mesh.positions);
    for (k, face) in mesh.faces.iter().enumerate() {
        let mut face = face.to_vec();
        if k % 3 == 0 {
            face.reverse();
        }
        turned.push_face(&face, 0);
    }
    check("turned", cut(Solid::Mesh(Box::new(turned))), |p| {
        in_cube(p).max(-in_ball(p))
    });
}

#[test]
fn a_shell_of_open_pieces_is_a_solid() {
    let sides: Vec<Solid> = (0..6)
        .map(|k| {
            let turn = match k {
                0..4 => DQuat::from_rotation_y(f64::from(k) * FRAC_PI_2),
                4 => DQuat::from_rotation_x(FRAC_PI_2),
                _ => DQuat::from_rotation_x(-FRAC_PI_2),
            };
            // Every other piece faces inward.
            let flip = if k % 2 == 0 { PI } else { 0.0 };
            let map = DAffine3::from_quat(turn)
                * DAffine3::from_translation(DVec3::Z)
                * DAffine3::from_quat(DQuat::from_rotation_x(flip))
                * DAffine3::from_scale_rotation_translation(
                    DVec3::splat(2.0),
                    DQuat::IDENTITY,
                    DVec3::new(-1.0, -1.0, 0.0),
                );
            primitive(PrimitiveKind::Square, map)
        })
        .collect();
    let shell = Solid::Shell(sides);
    let cut = csg(
        Operation::Difference,
        vec![shell],
        vec![ball(DVec3::ZERO, 1.2)],
    );
    check("shell", cut, |p| in_cube(p).max(-in_ball(p)));
}

#[test]
fn the_deepest_nesting_that_is_allowed_works() {
    // Balls of falling size, each cut out of the one before: rings of matter and nothing.
    let mut solid = ball(DVec3::ZERO, 0.01);
    for k in 1..=255 {
        let shell = ball(DVec3::ZERO, 0.01 * f64::from(k + 1));
        solid = csg(Operation::Difference, vec![shell], vec![solid]);
    }
    let tracer = tracer(vec![solid]);
    assert_eq!(tracer.item_count(), 256);
    let ray = Ray::new(DVec3::new(-3.0, 0.001, 0.0), DVec3::X);
    let found = surfaces(&tracer, &ray);
    assert_eq!(found.len(), 512);
    assert!(
        found
            .iter()
            .enumerate()
            .all(|(k, hit)| hit.entering == (k % 2 == 0))
    );
}

#[test]
fn a_tube_with_lids_is_a_can() {
    // The lids are squares that reach over the rim: what sticks out has no thickness.
    let lid = |z: f64| {
        let map = DAffine3::from_translation(DVec3::new(-1.5, -1.5, z));
        primitive(
            PrimitiveKind::Square,
            map * DAffine3::from_scale(DVec3::new(3.0, 3.0, 1.0)),
        )
    };
    let tube = primitive(PrimitiveKind::Tube { top: 1.0 }, DAffine3::IDENTITY);
    let can = Solid::Shell(vec![tube, lid(0.0), lid(1.0)]);
    let cut = csg(
        Operation::Intersection,
        vec![can],
        vec![ball(DVec3::ZERO, 0.9)],
    );
    check("can", cut, |p| (p.length() - 0.9).max(-p.z).max(p.z - 1.0));
}

#[test]
fn an_empty_result_is_never_met() {
    let apart = csg(
        Operation::Intersection,
        vec![ball(-3.0 * DVec3::X, 1.0)],
        vec![ball(3.0 * DVec3::X, 1.0)],
    );
    let inside = csg(
        Operation::Difference,
        vec![ball(DVec3::ZERO, 1.0)],
        vec![cube()],
    );
    let itself = csg(Operation::Difference, vec![cube()], vec![cube()]);
    let tracer = tracer(vec![apart, inside, itself]);
    assert_eq!(tracer.item_count(), 6);
    let mut random = Random(1);
    for _ in 0..5000 {
        let ray = Ray::new(4.0 * random.point(), random.unit());
        assert_eq!(tracer.hit(&ray), None);
        assert!(!tracer.occluded(&ray));
    }
}

#[test]
fn solids_that_touch_are_one() {
    let box_at = |x: f64| {
        let map = DAffine3::from_translation(DVec3::new(x, 0.0, 0.0))
            * DAffine3::from_scale(DVec3::new(0.7, 1.0, 1.0));
        primitive(PrimitiveKind::Cuboid, map)
    };
    let row = csg(Operation::Union, vec![box_at(0.1)], vec![box_at(0.1 + 0.7)]);
    let tracer = tracer(vec![row]);
    let mut random = Random(6);
    for _ in 0..2000 {
        let from = DVec3::new(-1.0, 0.5 + 0.4 * random.next(), 0.5 + 0.4 * random.next());
        let ray = Ray::new(from, DVec3::new(1.0, 0.01 * random.next(), 0.0));
        assert_eq!(surfaces(&tracer, &ray).len(), 2, "{ray:?}");
    }
}

/// A bump over the unit square.
fn bump() -> BicubicPatch {
    let row = |v: usize| {
        [0, 1, 2, 3].map(|u| {
            let height = if (1..3).contains(&u) && (1..3).contains(&v) {
                1.0
            } else {
                0.0
            };
            DVec3::new(u as f64 / 3.0, v as f64 / 3.0, height)
        })
    };
    BicubicPatch {
        points: Box::new([0, 1, 2, 3].map(row)),
        material: 0,
    }
}

#[test]
fn a_patch_is_met_where_its_triangles_are() {
    let patch = bump();
    let mut mesh = Mesh::default();
    let n = 200;
    for j in 0..=n {
        for i in 0..=n {
            let at = |k: u32| f64::from(k) / f64::from(n);
            mesh.positions.push(patch.at(at(i), at(j)).0);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let corner = |di: u32, dj: u32| (j + dj) * (n + 1) + i + di;
            mesh.push_face(&[corner(0, 0), corner(1, 0), corner(1, 1)], 0);
            mesh.push_face(&[corner(0, 0), corner(1, 1), corner(0, 1)], 0);
        }
    }
    let exact = tracer(vec![Solid::Patch(patch)]);
    let flat = Tracer::new(&crate::scene([Shape::Mesh(mesh)]));
    let mut random = Random(4);
    let (mut hits, mut differing) = (0, 0);
    for _ in 0..10_000 {
        let target = DVec3::splat(0.5) + 0.6 * random.point();
        let ray = Ray::new(target - 2.0 * random.unit(), target);
        let ray = Ray::new(ray.origin, target - ray.origin);
        let (a, b) = (exact.hit(&ray), flat.hit(&ray));
        assert_eq!(exact.occluded(&ray), a.is_some());
        match (a, b) {
            (Some(a), Some(b)) if (a.position - b.position).length() < 1e-3 => {
                hits += 1;
                differing += usize::from(a.entering != b.entering);
                let (p, du, dv) = bump().at(a.u, a.v);
                assert!((p - a.position).length() < 1e-9);
                assert!((du.cross(dv).normalize() - a.normal).length() < 1e-9);
            }
            (None, None) => {}
            _ => differing += 1,
        }
    }
    assert!(hits > 2000 && differing < 30, "{hits} {differing}");
}

#[test]
fn exact_shapes_and_meshes_share_a_scene() {
    let mut both: Scene = synthetic::cube_room();
    let small = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.2),
        DQuat::IDENTITY,
        DVec3::splat(0.4),
    );
    let solid = csg(
        Operation::Difference,
        vec![primitive(PrimitiveKind::Cuboid, small)],
        vec![ball(DVec3::splat(0.5), 0.12)],
    );
    let before = Tracer::new(&both).item_count();
    both.objects
        .push(azulejo_scene::Object::new("cut", exact(vec![solid])));
    let tracer = Tracer::new(&both);
    assert_eq!(tracer.item_count(), before + 2);
    let hit = tracer.hit(&Ray::new(DVec3::new(0.5, 0.5, 0.05), DVec3::Z));
    // Through the ball's hole into it, to its far side and out again: nothing is left there.
    let hit = hit.expect("the far wall");
    assert!(
        hit.item < before && (hit.position.z - 1.0).abs() < 1e-6,
        "{hit:?}"
    );
    let hit = tracer.hit(&Ray::new(DVec3::splat(0.5), DVec3::ONE));
    let hit = hit.expect("the corner that is left, from inside the hole");
    assert_eq!((hit.item, hit.face, hit.entering), (before + 1, 1, true));
}
