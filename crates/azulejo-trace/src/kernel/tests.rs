//! The tree against brute force, on every instruction set of this machine.

use super::bvh::{Bvh, BvhNode, WIDTH};
use super::portable::Portable;
use super::prepared_ray::PreparedRay;
use super::simd::InstructionSet;
use super::traversal::{Instructions, OtherShapes};
use super::triangle::{PACKET, PacketHits};
use super::{KernelHit, KernelRay};
use crate::Tracer;
use azulejo_scene::math::Ray;
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape, synthetic};
use glam::DVec3;
use proptest::prelude::*;

fn instruction_sets() -> Vec<InstructionSet> {
    let mut sets = vec![InstructionSet::Portable];
    if InstructionSet::detect() != InstructionSet::Portable {
        sets.push(InstructionSet::detect());
    }
    sets
}

fn mesh_scene(triangles: &[[DVec3; 3]]) -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let mut mesh = Mesh::default();
    for t in triangles {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(t);
        mesh.push_face(&[first, first + 1, first + 2], grey);
    }
    scene.objects.push(Object::new("soup", Shape::Mesh(mesh)));
    scene
}

/// Tests every triangle of every packet.
fn brute_force(bvh: &Bvh, ray: &KernelRay) -> KernelHit {
    let mut hit = KernelHit::before(ray.t_max.next_down());
    let Some(prepared) = PreparedRay::new(ray) else {
        return KernelHit::NOTHING;
    };
    let mut hits = PacketHits::default();
    for packet in &bvh.packets {
        let mask = Portable.triangles(&prepared, packet, hit.t, &mut hits);
        for lane in (0..PACKET).filter(|lane| mask >> lane & 1 == 1) {
            if hit.is_after(hits.t[lane], packet.items[lane]) {
                let uv = [hits.u[lane], hits.v[lane]];
                hit = KernelHit::on_surface(hits.t[lane], packet.items[lane], uv);
            }
        }
    }
    if hit.is_hit() {
        hit
    } else {
        KernelHit::NOTHING
    }
}

/// Hits are bit-identical by brute force and by the tree with every instruction set, for single
/// rays and for batches.
fn check_against_brute_force(tracer: &Tracer, rays: &[KernelRay]) {
    let expected: Vec<KernelHit> = rays.iter().map(|r| brute_force(&tracer.bvh, r)).collect();
    let scene = tracer.kernel_scene();
    for set in instruction_sets() {
        let mut hits = vec![KernelHit::NOTHING; rays.len()];
        set.closest(&scene, rays, &mut hits);
        let mut blocked = vec![false; rays.len()];
        set.any(&scene, rays, &mut blocked);
        for (k, ray) in rays.iter().enumerate() {
            assert_eq!(hits[k], expected[k], "{set:?} {ray:?}");
            assert_eq!(blocked[k], expected[k].is_hit(), "{set:?} {ray:?}");
            let mut alone = [KernelHit::NOTHING];
            set.closest(&scene, &rays[k..=k], &mut alone);
            assert_eq!(alone[0], expected[k], "{set:?} alone {ray:?}");
        }
    }
}

/// Random numbers in −1..1, from a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        2.0 * azulejo_scene::random::split_mix64(&mut self.0) - 1.0
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

#[derive(Clone, Copy, Debug)]
enum SoupShape {
    Even,
    Slivers,
    Coplanar,
    Duplicates,
    Sizes,
}

fn triangles(soup: SoupShape, count: usize, random: &mut Random) -> Vec<[DVec3; 3]> {
    let triangle = |k: usize| {
        let (a, b, c) = (random.point(), random.point(), random.point());
        match soup {
            SoupShape::Even => [a, a + 0.2 * b, a + 0.2 * c],
            SoupShape::Slivers => [a, a + b, a + b + 1e-5 * c],
            SoupShape::Coplanar => [a, a + 0.3 * b, a + 0.3 * c].map(|p| p.with_z(0.0)),
            SoupShape::Duplicates => {
                let cell = DVec3::new((k % 4) as f64, (k / 4 % 4) as f64, 0.0);
                [cell, cell + DVec3::X, cell + DVec3::Y + 0.5 * DVec3::Z]
            }
            SoupShape::Sizes => {
                let size = (-6.0 * random.next().abs()).exp2().powi(4);
                [a, a + size * b, a + size * c]
            }
        }
    };
    (0..count).map(triangle).collect()
}

/// Rays from random points to random points, to points of triangles, and along axes.
fn rays(tracer: &Tracer, triangles: &[[DVec3; 3]], random: &mut Random) -> Vec<KernelRay> {
    let mut ray = |k: usize| {
        let from = 2.0 * random.point();
        let [a, b, c] = triangles[k % triangles.len()];
        let direction = match k % 5 {
            0 => random.point(),
            1 => a - from,
            2 => 0.5 * (a + b) - from,
            3 => (a + b + c) / 3.0 - from,
            _ => DVec3::AXES[k % 3],
        };
        let (t_min, t_max) = if k.is_multiple_of(7) {
            (0.2, 0.9)
        } else {
            (0.0, f64::INFINITY)
        };
        tracer.kernel_ray(&Ray {
            t_min,
            t_max,
            ..Ray::new(from, direction)
        })
    };
    (0..200).map(&mut ray).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn tree_agrees_with_brute_force(
        seed in any::<u64>(),
        count in 1usize..600,
        kind in prop_oneof![
            Just(SoupShape::Even),
            Just(SoupShape::Slivers),
            Just(SoupShape::Coplanar),
            Just(SoupShape::Duplicates),
            Just(SoupShape::Sizes),
        ],
    ) {
        let mut random = Random(seed);
        let triangles = triangles(kind, count, &mut random);
        let tracer = Tracer::new(&mesh_scene(&triangles));
        check_against_brute_force(&tracer, &rays(&tracer, &triangles, &mut random));
    }
}

#[test]
fn a_room_agrees_with_brute_force() {
    let scene = synthetic::furnished_room(6000);
    let tracer = Tracer::new(&scene);
    let mut random = Random(3);
    let inside = |p: DVec3| DVec3::new(3.0, 2.5, 1.5) + p * DVec3::new(2.9, 2.4, 1.4);
    let rays: Vec<KernelRay> = (0..1000)
        .map(|_| Ray::between(inside(random.point()), inside(random.point())))
        .map(|ray| tracer.kernel_ray(&ray))
        .collect();
    check_against_brute_force(&tracer, &rays);
}

#[test]
fn axis_parallel_rays_are_not_led_astray() {
    // With products of zero and infinity these rays would hit every box.
    let node = BvhNode {
        planes: [[[0.25; WIDTH], [0.5; WIDTH]]; 3],
        children: [0; WIDTH],
    };
    let check = |origin: [f32; 3], direction: [f32; 3], meets: bool| {
        let ray = KernelRay {
            origin,
            t_min: 0.0,
            direction,
            t_max: f32::INFINITY,
        };
        let prepared = PreparedRay::new(&ray).unwrap();
        let numbers = [prepared.inverse, prepared.near_offset, prepared.far_offset];
        assert!(
            numbers.iter().flatten().all(|x| x.is_finite()),
            "{prepared:?}"
        );
        let mut near = [0.0; WIDTH];
        let mask = Portable.boxes(&prepared, &node, f32::MAX, &mut near);
        assert_eq!(mask, if meets { 0xff } else { 0 }, "{ray:?}");
    };
    for zero in [0.0, -0.0] {
        check([0.3, 0.3, 1.0], [zero, zero, -1.0], true);
        check([0.25, 0.5, 1.0], [zero, zero, -1.0], true);
        check([0.0, 0.3, 1.0], [zero, zero, -1.0], false);
        check([0.3, 0.6, 1.0], [zero, zero, -1.0], false);
        check([0.3, 1.0, 0.3], [zero, -2.0, zero], true);
        check([1.0, 0.0, 0.3], [-1.0, zero, zero], false);
    }
    // The image's middle column and row run along the axis when the width is odd.
    let scene = synthetic::displaced_sphere(3000);
    let tracer = Tracer::new(&scene);
    let size = 41;
    let at = |k: i32| f64::from(2 * k + 1 - size) / f64::from(size);
    let pixel = |k: i32| DVec3::new(at(k % size), at(k / size), -2.0);
    let rays: Vec<KernelRay> = (0..size * size)
        .map(|k| tracer.kernel_ray(&Ray::new(DVec3::new(0.0, 0.0, 3.0), pixel(k))))
        .collect();
    assert!(
        rays.iter()
            .any(|r| r.direction[0] == 0.0 && r.direction[1] == 0.0)
    );
    check_against_brute_force(&tracer, &rays);
}

#[test]
fn the_tree_does_not_depend_on_threads() {
    let scene = synthetic::furnished_room(120_000);
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| Tracer::new(&scene))
    };
    let (one, eight) = (build(1), build(8));
    let same = |a: &BvhNode, b: &BvhNode| a.planes == b.planes && a.children == b.children;
    assert_eq!(one.bvh.nodes.len(), eight.bvh.nodes.len());
    assert!(
        one.bvh
            .nodes
            .iter()
            .zip(&eight.bvh.nodes)
            .all(|(a, b)| same(a, b))
    );
    let items = |t: &Tracer| {
        t.bvh
            .packets
            .iter()
            .flat_map(|p| p.items)
            .collect::<Vec<u32>>()
    };
    assert_eq!(items(&one), items(&eight));
}

#[test]
fn any_hit_of_other_shapes_respects_the_range() {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let ball = azulejo_scene::Primitive::sphere(DVec3::ZERO, 1.0, 0);
    scene
        .objects
        .push(Object::new("ball", Shape::Primitive(ball)));
    let tracer = Tracer::new(&scene);
    let ray = tracer.kernel_ray(&Ray::new(DVec3::new(0.0, 0.0, 3.0), -DVec3::Z));
    assert!(tracer.others.any(0, &ray, 2.0) && !tracer.others.any(0, &ray, 1.9));
}

/// Embree's triangles compared with ours, mixed with our own shapes.
mod embree {
    use super::*;
    use crate::Kernel;
    use crate::embree::Embree;
    use azulejo_scene::Primitive;
    use azulejo_testing::Need;

    fn loaded() -> Option<Kernel> {
        azulejo_testing::require(Need::Embree, Embree::load(None)).map(Kernel::Embree)
    }

    /// Hits agree up to rounding. Of two triangles at the same distance either is correct, and so
    /// are hit and miss where a ray passes an edge within rounding, which may happen to a few rays.
    fn check_alike(scene: &Scene, kernel: &Kernel, rays: impl Fn(&Tracer) -> Vec<KernelRay>) {
        let (ours, theirs) = (Tracer::new(scene), Tracer::with_kernel(scene, kernel));
        assert_eq!((ours.kernel(), &theirs.kernel()), (Kernel::Own, kernel));
        let rays = rays(&ours);
        let (mut a, mut b) = (Vec::new(), Vec::new());
        ours.closest(&rays, &mut a);
        theirs.closest(&rays, &mut b);
        let (mut blocked, mut other) = (Vec::new(), Vec::new());
        ours.any(&rays, &mut blocked);
        theirs.any(&rays, &mut other);
        let near = |x: f32, y: f32| (x - y).abs() <= 2e-4 * x.abs().max(1e-2);
        let differ = |k: &usize| {
            let (a, b) = (&a[*k], &b[*k]);
            let alike = match (a.is_hit(), b.is_hit()) {
                (true, true) => near(a.t, b.t),
                (hit, other) => hit == other,
            };
            !alike || blocked[*k] != other[*k] || other[*k] != b.is_hit()
        };
        let apart: Vec<usize> = (0..rays.len()).filter(differ).collect();
        assert!(
            apart.len() * 400 <= rays.len(),
            "{} of {} differ, as {:?}: {:?} and {:?}",
            apart.len(),
            rays.len(),
            rays[apart[0]],
            a[apart[0]],
            b[apart[0]]
        );
    }

    #[test]
    fn it_hits_what_we_hit() {
        let Some(kernel) = loaded() else { return };
        for (seed, kind) in [
            (1, SoupShape::Even),
            (2, SoupShape::Even),
            (3, SoupShape::Coplanar),
        ] {
            let mut random = Random(seed);
            let soup = triangles(kind, 2000, &mut random);
            let mut scene = mesh_scene(&soup);
            for radius in [0.2, 0.4] {
                let ball = Primitive::sphere(random.point(), radius, 0);
                scene
                    .objects
                    .push(Object::new("ball", Shape::Primitive(ball)));
            }
            // Rays towards corners and edges of the soup are left out: there either result is
            // correct.
            let inside = |k: &usize| ![1, 2].contains(&(k % 5));
            check_alike(&scene, &kernel, |tracer| {
                let all = (0..10).map(|part| rays(tracer, &soup, &mut Random(seed + part)));
                let all: Vec<KernelRay> = all.flatten().collect();
                (0..all.len()).filter(inside).map(|k| all[k]).collect()
            });
        }
    }

    #[test]
    fn rays_that_hit_nothing_hit_nothing() {
        let Some(kernel) = loaded() else { return };
        let tracer = Tracer::with_kernel(&synthetic::cube_room(), &kernel);
        let good = tracer.kernel_ray(&Ray::new(DVec3::splat(0.5), DVec3::X));
        assert!(tracer.kernel_name().starts_with("Embree "));
        let nan = f32::NAN;
        let bad = [
            KernelRay {
                t_max: 0.5,
                t_min: 0.5,
                ..good
            },
            KernelRay {
                origin: [nan, 0.0, 0.0],
                ..good
            },
            KernelRay {
                direction: [0.0; 3],
                ..good
            },
            KernelRay {
                direction: [f32::INFINITY, 0.0, 0.0],
                ..good
            },
            KernelRay { t_min: nan, ..good },
        ];
        let (mut hits, mut blocked) = (Vec::new(), Vec::new());
        tracer.closest(&bad, &mut hits);
        tracer.any(&bad, &mut blocked);
        assert!(hits.iter().all(|h| *h == KernelHit::NOTHING), "{hits:?}");
        assert!(blocked.iter().all(|b| !b), "{blocked:?}");
        let empty = Tracer::with_kernel(&Scene::default(), &kernel);
        assert!(!empty.occluded(&Ray::new(DVec3::ZERO, DVec3::X)));
        let (hit, short) = (tracer.hit(&Ray::new(DVec3::splat(0.5), DVec3::X)), good);
        assert!((hit.expect("a wall").t - 0.5).abs() < 1e-6);
        let short = KernelRay {
            t_max: 0.49,
            ..short
        };
        tracer.closest(&[short], &mut hits);
        assert!(!hits[0].is_hit());
    }
}
