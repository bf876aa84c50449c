use super::tests::{cuboid, hit, mesh, patch_edges, scene};
use super::*;
use azulejo_scene::{Mesh, Object, PrimitiveKind, Shape, synthetic};
use glam::{DAffine3, DMat3, DQuat, DVec2};
use proptest::prelude::*;

/// A rectangle in z = 0 whose front looks up.
fn floor(low: DVec2, high: DVec2) -> Mesh {
    let p = |x, y| DVec3::new(x, y, 0.0);
    let corners = [
        p(low.x, low.y),
        p(high.x, low.y),
        p(high.x, high.y),
        p(low.x, high.y),
    ];
    mesh(&corners, &[&[0, 1, 2, 3]])
}

fn moved(mut mesh: Mesh, by: &DAffine3) -> Mesh {
    mesh.positions
        .iter_mut()
        .for_each(|p| *p = by.transform_point3(*p));
    mesh
}

/// A box of a size, turned about z by an angle, its lower corner at a place.
fn block(size: DVec3, angle: f64, at: DVec3) -> Mesh {
    let turn = DAffine3::from_rotation_translation(DQuat::from_rotation_z(angle), at);
    moved(cuboid(size), &turn)
}

/// Whether a point of the floor is below a block that stands on it; `None` within `margin` of
/// its sides.
fn is_below(p: DVec3, size: DVec3, angle: f64, at: DVec3, margin: f64) -> Option<bool> {
    let local = DQuat::from_rotation_z(-angle) * (p - at);
    let depth = local
        .x
        .min(size.x - local.x)
        .min(local.y.min(size.y - local.y));
    (depth.abs() > margin).then_some(depth > 0.0)
}

const SAMPLES: [(f64, f64); 9] = [
    (0.02, 0.02),
    (0.5, 0.03),
    (0.97, 0.02),
    (0.03, 0.5),
    (0.5, 0.5),
    (0.97, 0.5),
    (0.02, 0.97),
    (0.5, 0.97),
    (0.98, 0.98),
];

/// Expects that no patch of object 0 has points of both kinds; returns the areas of both.
fn sides_of(patches: &Patches, kind: impl Fn(DVec3) -> Option<bool>) -> [f64; 2] {
    let mut areas = [0.0; 2];
    for i in patches.patches_of(0) {
        let points = SAMPLES.map(|(u, v)| patches.sample(i, u, v).position);
        let kinds: Vec<bool> = points.iter().filter_map(|&p| kind(p)).collect();
        let below = kinds.iter().filter(|k| **k).count();
        assert!(
            below == 0 || below == kinds.len(),
            "patch {i} lies across: {kinds:?}"
        );
        areas[usize::from(below > 0)] += patches.area(i);
    }
    areas
}

/// Expects what every division of object 0 must keep to.
fn check_division(scene: &Scene, patches: &Patches, size: f64) {
    let Shape::Mesh(given) = &scene.objects[0].shape else {
        unreachable!("made as a mesh");
    };
    let sum: f64 = patches.patches_of(0).map(|i| patches.area(i)).sum();
    assert!((sum / given.area() - 1.0).abs() < 1e-9, "{sum}");
    for i in patches.patches_of(0) {
        let polygon = patches.polygon(i).expect("flat");
        assert!(patch_edges(&polygon).all(|(p, q)| p.distance(q) <= 1.5 * size));
        for (u, v) in [(0.1, 0.2), (0.5, 0.5), (0.8, 0.9)] {
            let p = patches.sample(i, u, v).position;
            let face = patches.face(i).face;
            let (t, u, v) = hit(given, face as usize, p);
            assert_eq!(patches.locate(0, face, t, u, v) as usize, i);
        }
    }
    for (v, vertex) in patches.vertices().iter().enumerate() {
        assert!(!patches.patches_at(v).is_empty());
        let near = |i: &u32| patches.corner_vertices(*i as usize).contains(&(v as u32));
        assert!(patches.patches_at(v).iter().all(near));
        assert!(vertex.gather.distance(vertex.position) <= 2e-3 * size);
    }
    let RefinedShape::Mesh(refined) = patches.refined(0, scene) else {
        panic!("became a surface");
    };
    let mut again = scene.clone();
    again.objects[0].shape = Shape::Mesh(refined);
    again.validate().expect("valid");
}

/// Display vertices of object 0 at a point.
fn shown_at(patches: &Patches, p: DVec3) -> Vec<u32> {
    patches
        .vertices_of(0)
        .filter(|&v| patches.vertices()[v].position.distance(p) < 1e-9)
        .map(|v| v as u32)
        .collect()
}

fn room_with(blocks: Vec<Mesh>) -> Scene {
    let ground = floor(DVec2::splat(-2.0), DVec2::splat(2.0));
    let shapes = [ground]
        .into_iter()
        .chain(blocks)
        .map(Shape::Mesh)
        .collect();
    scene(shapes)
}

#[test]
fn no_patch_lies_across_the_base_of_a_box() {
    let (extent, at) = (DVec3::new(1.0, 0.7, 0.5), DVec3::new(-0.3, -0.4, 0.0));
    for angle in [0.0, 0.3] {
        let scene = room_with(vec![block(extent, angle, at)]);
        for size in [5.0, 1.0, 0.4, 0.11] {
            let patches = Patches::new(&scene, PatchSize::Edge(size));
            check_division(&scene, &patches, size);
            let areas = sides_of(&patches, |p| is_below(p, extent, angle, at, 1e-9));
            assert!((areas[1] - 0.7).abs() < 1e-9, "{areas:?} at {size}");
            // Each corner of the base, on either side.
            let corner = at + DQuat::from_rotation_z(angle) * DVec3::new(1.0, 0.7, 0.0);
            let shown = shown_at(&patches, corner);
            assert_eq!(shown.len(), 2, "at {size}");
            let below = |v: &u32| {
                let gather = patches.vertices()[*v as usize].gather;
                is_below(gather, extent, angle, at, 1e-12).expect("off the line")
            };
            assert_ne!(below(&shown[0]), below(&shown[1]));
        }
    }
}

#[test]
fn coarse_patches_ignore_details() {
    let scene = room_with(vec![block(DVec3::new(0.1, 0.1, 0.5), 0.2, DVec3::ZERO)]);
    let count = |size| {
        Patches::new(&scene, PatchSize::Edge(size))
            .patches_of(0)
            .len()
    };
    assert_eq!(count(f64::INFINITY), 1);
    assert_eq!(count(5.0), 1);
    assert!(count(2.0) > 4);
}

#[test]
fn crossing_squares_are_cut_through() {
    let ground = floor(DVec2::splat(-1.0), DVec2::splat(1.0));
    let turn = DAffine3::from_mat3(DMat3::from_rotation_x(1.1));
    let wall = moved(floor(DVec2::new(-1.5, -0.6), DVec2::new(1.2, 0.8)), &turn);
    let scene = scene(vec![Shape::Mesh(ground), Shape::Mesh(wall)]);
    for size in [3.0, 0.3, 0.07] {
        let patches = Patches::new(&scene, PatchSize::Edge(size));
        check_division(&scene, &patches, size);
        let areas = sides_of(&patches, |p| (p.y.abs() > 1e-9).then_some(p.y > 0.0));
        assert!((areas[0] - 2.0).abs() < 1e-9 && (areas[1] - 2.0).abs() < 1e-9);
        // From border to border, so that even the ends are two.
        for x in [-1.0, 1.0] {
            assert_eq!(shown_at(&patches, DVec3::new(x, 0.0, 0.0)).len(), 2);
        }
        let above = patches.patches_of(1).filter(|&i| patches.centre(i).z > 0.0);
        let area: f64 = above.map(|i| patches.area(i)).sum();
        // The wall reaches beyond the floor, where it is not cut.
        assert!((area - 2.7 * 0.8).abs() < 0.2 * size, "{area} at {size}");
    }
}

#[test]
fn the_ends_of_a_fin_are_shared() {
    let stand = DAffine3::from_mat3(DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2));
    let fin = moved(floor(DVec2::new(-0.5, 0.0), DVec2::new(0.5, 0.4)), &stand);
    let scene = room_with(vec![fin]);
    let patches = Patches::new(&scene, PatchSize::Edge(0.25));
    check_division(&scene, &patches, 0.25);
    let count = |x: f64| shown_at(&patches, DVec3::new(x, 0.0, 0.0)).len();
    assert_eq!([-0.5, -0.25, 0.0, 0.25, 0.5].map(count), [1, 2, 2, 2, 1]);
    for v in shown_at(&patches, DVec3::ZERO) {
        assert!(patches.vertices()[v as usize].gather.y.abs() > 1e-6);
    }
}

#[test]
fn a_block_may_stand_over_the_edge() {
    let (extent, at) = (DVec3::new(1.0, 1.2, 0.5), DVec3::new(1.4, -0.5, 0.0));
    for (angle, at) in [(0.0, at), (0.0, DVec3::new(1.0, 0.3, 0.0)), (0.4, at)] {
        let scene = room_with(vec![block(extent, angle, at)]);
        for size in [3.0, 0.5, 0.13] {
            let patches = Patches::new(&scene, PatchSize::Edge(size));
            check_division(&scene, &patches, size);
            let areas = sides_of(&patches, |p| is_below(p, extent, angle, at, 1e-9));
            assert!(areas[1] > 0.3, "{areas:?} at {size}");
        }
    }
}

#[test]
fn walls_part_the_floors_beside_them() {
    // Two floors and a wall on their common edge, all sharing its vertices.
    let p = DVec3::new;
    let points = [
        p(0., 0., 0.),
        p(1., 0., 0.),
        p(2., 0., 0.),
        p(2., 1., 0.),
        p(1., 1., 0.),
        p(0., 1., 0.),
        p(1., 0., 1.),
        p(1., 1., 1.),
    ];
    let without: [&[u32]; 2] = [&[0, 1, 4, 5], &[1, 2, 3, 4]];
    let with = [without[0], without[1], &[1, 4, 7, 6]];
    let check = |faces: &[&[u32]], expected: usize| {
        let scene = scene(vec![Shape::Mesh(mesh(&points, faces))]);
        let patches = Patches::new(&scene, PatchSize::Edge(0.5));
        let on_floor = |v: &u32| patches.vertices()[*v as usize].normal.z.abs() > 0.9;
        for y in [0.0, 0.5, 1.0] {
            let shown = shown_at(&patches, p(1.0, y, 0.0));
            assert_eq!(
                shown.iter().filter(|v| on_floor(v)).count(),
                expected,
                "at {y}"
            );
        }
        let given = patches.given_vertices(0, 1);
        let angle: f64 = given
            .iter()
            .filter(|g| on_floor(&g.display))
            .map(|g| g.weight)
            .sum();
        assert!((angle - std::f64::consts::PI).abs() < 1e-9);
    };
    check(&without, 1);
    check(&with, 2);
}

#[test]
fn tessellated_floors_are_cut_across_their_seams() {
    let mut ground = Mesh::default();
    for (x, y) in (0..=4).flat_map(|y| (0..=4).map(move |x| (x, y))) {
        ground
            .positions
            .push(DVec3::new(f64::from(x) - 2.0, f64::from(y) - 2.0, 0.0));
    }
    for (x, y) in (0..4).flat_map(|y| (0..4).map(move |x| (x, y))) {
        let k = 5 * y + x;
        ground.push_face(&[k, k + 1, k + 6, k + 5], 0);
    }
    let (extent, at) = (DVec3::new(1.3, 1.7, 0.5), DVec3::new(-0.9, -0.8, 0.0));
    let block = block(extent, 0.25, at);
    let scene = scene(vec![Shape::Mesh(ground), Shape::Mesh(block)]);
    for size in [2.0, 0.4] {
        let patches = Patches::new(&scene, PatchSize::Edge(size));
        check_division(&scene, &patches, size);
        // Lines go round corners of faces that they pass within a fiftieth of the size.
        let areas = sides_of(&patches, |p| is_below(p, extent, 0.25, at, 0.02 * size));
        assert!(
            (areas[1] - 1.3 * 1.7).abs() < 0.02 * size,
            "{areas:?} at {size}"
        );
        // Every edge inside is used from both sides, at the seams of the faces too.
        let open = tests::edge_uses(&patches)
            .into_iter()
            .filter(|e| e.1 != (1, 1));
        let z_zero =
            open.filter(|(edge, _)| [2, 5].iter().all(|&k| f64::from_bits(edge[k]) == 0.0));
        let inside = z_zero.filter(|(edge, _)| {
            let p = edge.map(f64::from_bits);
            p[0].abs().max(p[1].abs()) < 2.0 - 1e-9 && p[3].abs().max(p[4].abs()) < 2.0 - 1e-9
        });
        // The bottom of the block lies in the same plane and has other edges.
        let is_of_block = |e: &[u64; 6]| {
            let p = e.map(f64::from_bits);
            let middle = DVec3::new(p[0] + p[3], p[1] + p[4], 0.0) / 2.0;
            is_below(middle, extent, 0.25, at, 1e-9) != Some(false)
        };
        assert_eq!(
            inside.filter(|(edge, _)| !is_of_block(edge)).count(),
            0,
            "at {size}"
        );
    }
}

#[test]
fn far_from_the_origin_contacts_are_found() {
    let (extent, at) = (DVec3::new(1.0, 0.7, 0.5), DVec3::new(-0.3, -0.4, 0.0));
    let turn = DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(0.4);
    let far = DAffine3::from_rotation_translation(turn, DVec3::new(1e5, -2e5, 1.5e5));
    let shapes = [
        floor(DVec2::splat(-2.0), DVec2::splat(2.0)),
        block(extent, 0.3, at),
    ];
    let scene = scene(shapes.map(|m| Shape::Mesh(moved(m, &far))).to_vec());
    let patches = Patches::new(&scene, PatchSize::Edge(0.3));
    let areas = sides_of(&patches, |p| {
        is_below(far.inverse().transform_point3(p), extent, 0.3, at, 1e-6)
    });
    assert!((areas[1] - 0.7).abs() < 1e-6, "{areas:?}");
}

#[test]
fn exact_shapes_stand_on_floors() {
    let map = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.5, 0.5, 1.0),
        DQuat::IDENTITY,
        DVec3::new(0.1, 0.2, 0.0),
    );
    let shape = Primitive::new(PrimitiveKind::Cylinder, map, 0);
    let bounds = shape.bounds();
    let mut scene = room_with(Vec::new());
    let up = DAffine3::from_translation(DVec3::new(0.0, 0.0, -bounds.min.z)) * map;
    let standing = Primitive::new(PrimitiveKind::Cylinder, up, 0);
    scene
        .objects
        .push(Object::new("", Shape::Primitive(standing)));
    let patches = Patches::new(&scene, PatchSize::Edge(0.2));
    check_division(&scene, &patches, 0.2);
    let middle = DVec3::new(0.1, 0.2, 0.0);
    let areas = sides_of(&patches, |p| {
        let off = p.distance(middle) - 0.5;
        (off.abs() > 0.01).then_some(off < 0.0)
    });
    assert!(
        (areas[1] / (std::f64::consts::PI * 0.25) - 1.0).abs() < 0.03,
        "{areas:?}"
    );
}

/// Coincident faces are compared with others once, and all of them get the lines.
#[test]
fn coincident_faces_share_their_contacts() {
    let (extent, at) = (DVec3::new(1.0, 0.7, 0.5), DVec3::new(-0.3, -0.4, 0.0));
    let below = || floor(DVec2::splat(-2.0), DVec2::splat(2.0));
    let mut meshes = vec![below(), below(), block(extent, 0.3, at)];
    // Among this many a limit of the pairs would leave out the block, and the time would be minutes.
    let mut many = floor(DVec2::splat(5.0), DVec2::splat(6.0));
    let ring = many.faces.get(0).to_vec();
    (0..200_000).for_each(|_| many.push_face(&ring, 0));
    meshes.push(many);
    let scene = scene(meshes.into_iter().map(Shape::Mesh).collect());
    let outline = Outline::new(&scene);
    let contacts = Contacts::new(&outline);
    assert!(contacts.of(0).len() >= 4);
    assert_eq!(contacts.of(0), contacts.of(1));
    let patches = Patches::new(&scene, PatchSize::Edge(0.3));
    let areas = sides_of(&patches, |p| is_below(p, extent, 0.3, at, 1e-6));
    assert!((areas[1] - 0.7).abs() < 1e-6, "{areas:?}");
}

#[test]
fn the_same_contacts_give_the_same_bits() {
    let scene = synthetic::cornell_box(synthetic::CornellVariant::Diffuse);
    let divide = || Patches::new(&scene, PatchSize::Count(2500));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let (one, many) = (pool.expect("a thread").install(divide), divide());
    assert_eq!(one.corners, many.corners);
    assert_eq!(one.vertices, many.vertices);
    let off = one.len() as f64 / 2500.0 - 1.0;
    assert!(off.abs() < 0.1, "{} patches", one.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Boxes dropped anywhere on a floor, through each other and over its edge.
    #[test]
    fn any_boxes_on_a_floor(
        places in prop::collection::vec(
            (-2.2f64..2.0, -2.2f64..2.0, 0.05f64..1.5, 0.05f64..1.5, 0.0f64..6.3, -0.2f64..0.0),
            1..7,
        ),
        size in 0.08f64..1.5,
    ) {
        let boxes: Vec<(DVec3, f64, DVec3)> = places
            .iter()
            .map(|&(x, y, w, d, angle, z)| {
                // Some stand on the floor, some go through it.
                let z = if z > -0.1 { 0.0 } else { z };
                (DVec3::new(w, d, 0.5), angle, DVec3::new(x, y, z))
            })
            .collect();
        let scene = room_with(boxes.iter().map(|&(s, a, p)| block(s, a, p)).collect());
        let patches = Patches::new(&scene, PatchSize::Edge(size));
        check_division(&scene, &patches, size);
        // Beyond what snapping may move and the loops that are dropped, a patch is below a box or
        // beside it.
        for &(extent, angle, at) in &boxes {
            if extent.truncate().min_element() > 0.1 * size {
                sides_of(&patches, |p| is_below(p, extent, angle, at, 0.08 * size));
            }
        }
    }
}

/// Two boxes of nearly one outline, whose lines merge: found by `any_boxes_on_a_floor`.
#[test]
fn outlines_that_nearly_coincide() {
    let size = 1.385_489_551_021_544_1;
    let boxes = [
        (
            DVec3::new(0.704_178_622_187_833_9, 0.436_634_811_523_549_44, 0.5),
            4.172_135_131_919_162,
            DVec3::new(1.656_826_427_503_621_3, 0.786_741_427_670_032_9, 0.0),
        ),
        (
            DVec3::new(0.948_548_485_094_693_4, 0.497_040_704_777_324_65, 0.5),
            3.975_620_687_545_102,
            DVec3::new(1.669_736_645_366_094_5, 1.002_072_272_413_721_4, 0.0),
        ),
    ];
    let scene = room_with(boxes.iter().map(|&(s, a, p)| block(s, a, p)).collect());
    let patches = Patches::new(&scene, PatchSize::Edge(size));
    check_division(&scene, &patches, size);
    for (extent, angle, at) in boxes {
        sides_of(&patches, |p| is_below(p, extent, angle, at, 0.06 * size));
    }
}
