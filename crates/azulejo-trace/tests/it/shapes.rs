//! Exact primitives against closed forms and tessellations; instances against copies.

use crate::{Random, scene, triangle_mesh};
use azulejo_scene::math::Ray;
use azulejo_scene::{Object, Primitive, PrimitiveKind, Shape, SharedMesh, synthetic};
use azulejo_trace::{Hit, Tracer};
use glam::{DAffine3, DMat3, DQuat, DVec3};

const KINDS: [PrimitiveKind; 8] = [
    PrimitiveKind::Sphere,
    PrimitiveKind::Cylinder,
    PrimitiveKind::Cone { top: 0.0 },
    PrimitiveKind::Cone { top: 0.4 },
    PrimitiveKind::Tube { top: 1.0 },
    PrimitiveKind::Tube { top: 0.4 },
    PrimitiveKind::Cuboid,
    PrimitiveKind::Square,
];

fn skewed(mirror: f64) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(2.0 * mirror, 0.1, 0.0),
            DVec3::new(0.3, 1.5, 0.2),
            DVec3::new(0.0, 0.4, 0.8),
        ),
        translation: DVec3::new(500.0, 600.0, 700.0),
    }
}

#[test]
fn a_sphere_is_met_where_the_formula_says() {
    let (centre, radius) = (DVec3::new(3.0, -2.0, 7.0), 2.5);
    let ball = Primitive::sphere(centre, radius, 0);
    let tracer = Tracer::new(&scene([Shape::Primitive(ball)]));
    let mut random = Random(4);
    for _ in 0..20_000 {
        let from = centre + 4.0 * random.point();
        let ray = Ray::new(from, random.unit());
        let o = from - centre;
        let (b, c) = (o.dot(ray.direction), o.length_squared() - radius * radius);
        let discriminant = b * b - c;
        if discriminant.abs() < 1e-4 || c.abs() < 1e-4 {
            continue;
        }
        let root = discriminant.max(0.0).sqrt();
        let expected = [-b - root, -b + root].into_iter().find(|&t| t > 0.0);
        let expected = expected.filter(|_| discriminant > 0.0);
        let hit = tracer.hit(&ray);
        assert_eq!(hit.is_some(), expected.is_some(), "{ray:?}");
        assert_eq!(tracer.occluded(&ray), expected.is_some(), "{ray:?}");
        if let (Some(hit), Some(t)) = (hit, expected) {
            assert!((hit.t - t).abs() < 1e-9, "{} {t}", hit.t);
            assert!((hit.normal - (hit.position - centre) / radius).length() < 1e-9);
            assert_eq!(hit.entering, c > 0.0);
        }
    }
}

#[test]
fn primitives_agree_with_their_tessellations() {
    for kind in KINDS {
        for mirror in [1.0, -1.0] {
            let exact = Primitive::new(kind, skewed(mirror), 0);
            let mesh = exact.tessellate(&exact.grids(1e-4, f64::INFINITY));
            let tracers = [Shape::Primitive(exact), Shape::Mesh(mesh)];
            let [exact, mesh] = tracers.map(|s| Tracer::new(&scene([s])));
            check_same_surface(&exact, &mesh, &format!("{kind:?} {mirror}"));
        }
    }
}

/// The same surface up to chords of 1e-4; near silhouettes the two may differ.
fn check_same_surface(exact: &Tracer, mesh: &Tracer, name: &str) {
    let mut random = Random(6);
    let bounds = exact.bounds();
    let (mut both, mut differing) = (0, 0);
    for _ in 0..4000 {
        let from = bounds.centre() + 1.5 * random.point() * bounds.size();
        let to = bounds.centre() + 0.5 * random.point() * bounds.size();
        let ray = Ray::new(from, to - from);
        match (exact.hit(&ray), mesh.hit(&ray)) {
            (None, None) => {}
            (Some(a), Some(b)) if (a.position - b.position).length() < 0.05 => {
                both += 1;
                differing += usize::from(a.entering != b.entering);
                let slant = a.normal.dot(ray.direction.normalize()).abs().max(0.02);
                differing += usize::from((a.position - b.position).length() > 1e-3 / slant);
            }
            _ => differing += 1,
        }
    }
    assert!(both > 100, "{name}: {both} hits");
    assert!(differing <= 20, "{name}: {differing} of 4000 differ");
}

#[test]
fn parts_and_parameters_lead_back_to_the_point() {
    for kind in KINDS {
        let primitive = Primitive::new(kind, skewed(1.0), 0);
        let tracer = Tracer::new(&scene([
            triangle_mesh(&[[DVec3::ZERO, DVec3::X, DVec3::Y]]),
            Shape::Primitive(primitive.clone()),
        ]));
        let mut random = Random(9);
        for part in 0..kind.parts() {
            let (u, v) = (0.5 + 0.4 * random.next(), 0.5 + 0.4 * random.next());
            let aim = primitive.point(part, u, v);
            let ray = Ray::new(aim.position + 0.3 * aim.normal, -aim.normal);
            let hit = tracer.hit(&ray).expect("aimed at the part");
            assert_eq!(
                (hit.object, hit.face, hit.item),
                (1, part as u32, 1 + part as u32)
            );
            let item = tracer.item(hit.item);
            assert!(item.is_primitive && item.face == part as u32 && item.object == 1);
            assert!(
                (hit.u - u).abs() < 1e-6 && (hit.v - v).abs() < 1e-6,
                "{kind:?} {part}"
            );
            assert!(
                (hit.position - aim.position).length() < 1e-9,
                "{kind:?} {part}"
            );
            assert!(hit.entering);
        }
    }
}

#[test]
fn a_ray_through_the_rim_of_a_cylinder_is_not_lost() {
    let can = Primitive::new(PrimitiveKind::Cylinder, DAffine3::IDENTITY, 0);
    let tracer = Tracer::new(&scene([Shape::Primitive(can)]));
    for k in 0..1000 {
        let (sin, cos) = (f64::from(k) * 0.01).sin_cos();
        let rim = DVec3::new(cos, sin, 1.0);
        let from = DVec3::new(0.1, 0.2, 0.4);
        assert!(tracer.hit(&Ray::new(from, rim - from)).is_some(), "{k}");
    }
}

/// Three instances of a mesh over a floor, and the same with a mesh for each.
fn instanced_and_unfolded() -> (Tracer, Tracer) {
    let bumpy = synthetic::displaced_sphere(1200);
    let mesh = bumpy.objects[0].shape.mesh().expect("a mesh").clone();
    let mut shared = SharedMesh::new(mesh);
    let maps = [
        DAffine3::from_translation(DVec3::new(-2.0, 0.0, 0.0)),
        DAffine3::from_scale_rotation_translation(
            DVec3::new(0.5, 2.0, 1.0),
            DQuat::from_rotation_x(0.7),
            DVec3::new(2.0, 1.0, 0.5),
        ),
        DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0))
            * DAffine3::from_translation(3.0 * DVec3::Y),
    ];
    let floor = triangle_mesh(&[[
        DVec3::new(-9.0, -9.0, -2.0),
        DVec3::new(9.0, -9.0, -2.0),
        DVec3::new(0.0, 9.0, -2.0),
    ]]);
    let mut instanced = scene([floor]);
    for map in maps {
        let instance = shared.placed(map).expect("invertible");
        let shape = Shape::Instance(instance);
        instanced.objects.push(Object::new("bumpy", shape));
    }
    instanced.validate().expect("a valid scene");
    let unfolded = Tracer::new(&instanced.unfolded());
    (Tracer::new(&instanced), unfolded)
}

#[test]
fn instances_agree_with_the_unfolded_scene() {
    let (instanced, unfolded) = instanced_and_unfolded();
    // The third instance has a mesh of its own, because it is mirrored.
    assert!(instanced.prototype_count() < instanced.item_count());
    assert_eq!(instanced.item_count(), unfolded.item_count());
    let mut random = Random(12);
    let (mut hits, mut differing) = (0, 0);
    for _ in 0..20_000 {
        let ray = Ray::new(
            6.0 * random.point(),
            3.0 * random.point() - 6.0 * random.point(),
        );
        let (a, b) = (instanced.hit(&ray), unfolded.hit(&ray));
        assert_eq!(instanced.occluded(&ray), a.is_some());
        let same = |a: &Hit, b: &Hit| {
            (a.t - b.t).abs() < 1e-5 && a.normal.dot(b.normal) > 1.0 - 1e-5 && a.item == b.item
        };
        match (a, b) {
            (Some(a), Some(b)) if same(&a, &b) => hits += 1,
            (None, None) => {}
            _ => differing += 1,
        }
        if let Some(a) = a {
            let item = instanced.item(a.item);
            assert_eq!((item.object, item.face), (a.object, a.face));
            assert_eq!(instanced.is_instanced(a.item), a.object > 0);
        }
    }
    assert!(
        hits > 4000 && differing < 20,
        "{hits} hits, {differing} differ"
    );
}

#[test]
fn batches_with_instances_answer_as_single_rays_do() {
    let (placed, _) = instanced_and_unfolded();
    let mut random = Random(13);
    let rays: Vec<Ray> = (0..500)
        .map(|_| Ray::new(6.0 * random.point(), random.unit()))
        .collect();
    let kernel: Vec<_> = rays.iter().map(|r| placed.kernel_ray(r)).collect();
    let (mut hits, mut blocked) = (Vec::new(), vec![true; 3]);
    placed.closest(&kernel, &mut hits);
    placed.any(&kernel, &mut blocked);
    assert_eq!((hits.len(), blocked.len()), (500, 500));
    for ((ray, hit), blocked) in rays.iter().zip(&hits).zip(blocked) {
        let alone = placed.hit(ray);
        assert_eq!(alone.is_some(), hit.is_hit());
        assert_eq!(blocked, hit.is_hit());
        if let Some(alone) = alone {
            assert_eq!(alone, placed.resolve(ray, hit));
        }
    }
}
