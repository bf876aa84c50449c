use super::*;
use azulejo_scene::{Attribute, Material, Mesh, Object, PrimitiveKind, Rgb, Shape};
use glam::{DAffine3, DMat3, DVec2};
use proptest::prelude::*;
use std::collections::HashMap;
use std::f64::consts::PI;

pub(super) fn scene(shapes: Vec<Shape>) -> Scene {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("white", Rgb::grey(0.7)));
    scene
        .objects
        .extend(shapes.into_iter().map(|s| Object::new("", s)));
    scene
}

pub(super) fn mesh(positions: &[DVec3], faces: &[&[u32]]) -> Mesh {
    let mut mesh = Mesh {
        positions: positions.to_vec(),
        ..Mesh::default()
    };
    faces.iter().for_each(|f| mesh.push_face(f, 0));
    mesh
}

/// A polygon in a tilted plane.
fn polygon(outline: &[(f64, f64)]) -> Mesh {
    let (x, y) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 1.0, 0.0));
    let points: Vec<DVec3> = outline.iter().map(|p| p.0 * x + p.1 * y).collect();
    let ring: Vec<u32> = (0..points.len() as u32).collect();
    mesh(&points, &[&ring])
}

pub(super) fn cuboid(size: DVec3) -> Mesh {
    let p: Vec<DVec3> = (0..8)
        .map(|k| {
            size * DVec3::new(
                f64::from(k & 1),
                f64::from(k >> 1 & 1),
                f64::from(k >> 2 & 1),
            )
        })
        .collect();
    let faces: [&[u32]; 6] = [
        &[0, 4, 6, 2],
        &[1, 3, 7, 5],
        &[0, 1, 5, 4],
        &[2, 6, 7, 3],
        &[0, 2, 3, 1],
        &[4, 5, 7, 6],
    ];
    mesh(&p, &faces)
}

/// A sphere of quadrilaterals with triangles at the poles.
fn globe(around: u32, up: u32) -> Mesh {
    let mut points = vec![-DVec3::Z];
    for j in 1..up {
        let polar = PI * (f64::from(j) / f64::from(up) - 0.5);
        for i in 0..around {
            let azimuth = 2.0 * PI * f64::from(i) / f64::from(around);
            let r = polar.cos();
            points.push(DVec3::new(
                r * azimuth.cos(),
                r * azimuth.sin(),
                polar.sin(),
            ));
        }
    }
    points.push(DVec3::Z);
    let last = points.len() as u32 - 1;
    let at = |i: u32, j: u32| 1 + (j - 1) * around + i % around;
    let mut globe = mesh(&points, &[]);
    for i in 0..around {
        globe.push_face(&[0, at(i + 1, 1), at(i, 1)], 0);
        globe.push_face(&[at(i, up - 1), at(i + 1, up - 1), last], 0);
        for j in 1..up - 1 {
            let ring = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            globe.push_face(&ring, 0);
        }
    }
    globe
}

fn primitive(kind: PrimitiveKind) -> Shape {
    let map = DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(2.0, 0.1, 0.0),
            DVec3::new(0.3, 1.5, 0.2),
            DVec3::new(0.0, 0.4, 0.8),
        ),
        translation: DVec3::new(5.0, 6.0, 7.0),
    };
    Shape::Primitive(Primitive::new(kind, map, 0))
}

const KINDS: [PrimitiveKind; 6] = [
    PrimitiveKind::Sphere,
    PrimitiveKind::Cylinder,
    PrimitiveKind::Cone { top: 0.0 },
    PrimitiveKind::Cone { top: 0.5 },
    PrimitiveKind::Cuboid,
    PrimitiveKind::Square,
];

fn l_shape() -> Mesh {
    polygon(&[(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.3), (0., 2.3)])
}

fn ngon(n: u32) -> Mesh {
    let corner = |k: u32| {
        let angle = 2.0 * PI * f64::from(k) / f64::from(n);
        (angle.cos(), 0.7 * angle.sin())
    };
    polygon(&(0..n).map(corner).collect::<Vec<_>>())
}

/// Every shape with a division method of its own.
fn specimens() -> Vec<(&'static str, Mesh)> {
    vec![
        ("square", polygon(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)])),
        (
            "kite",
            polygon(&[(0., 0.), (2., 0.1), (2.3, 2.2), (-0.2, 1.9)]),
        ),
        (
            "trapezoid",
            polygon(&[(0., 0.), (5.56, 0.), (3.43, 2.27), (2.13, 2.27)]),
        ),
        ("triangle", polygon(&[(0., 0.), (1., 0.), (0.4, 0.9)])),
        ("long triangle", polygon(&[(0., 0.), (3., 0.), (0.4, 0.9)])),
        ("needle", polygon(&[(0., 0.), (4., 0.), (0.1, 0.02)])),
        (
            "strip",
            polygon(&[(0., 0.), (4., 0.), (4., 0.01), (0., 0.01)]),
        ),
        (
            "uneven strip",
            polygon(&[(0., 0.), (4., 0.), (2.5, 0.03), (0., 0.03)]),
        ),
        ("L", l_shape()),
        ("pentagon", ngon(5)),
        ("disc", ngon(37)),
        (
            "arrow",
            polygon(&[(0., 0.), (2., -1.), (0.7, 0.), (2., 1.)]),
        ),
        (
            "keyhole",
            polygon(&[
                (0., 0.),
                (3., 0.),
                (3., 3.),
                (0., 3.),
                (0., 0.),
                (1., 1.),
                (1., 2.),
                (2., 2.),
                (2., 1.),
                (1., 1.),
            ]),
        ),
        ("cube", cuboid(DVec3::new(1.0, 2.0, 0.7))),
        ("globe", globe(11, 6)),
        (
            "bent",
            mesh(
                &[DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.8), DVec3::Y],
                &[&[0, 1, 2, 3]],
            ),
        ),
    ]
}

const SIZES: [f64; 4] = [f64::INFINITY, 0.9, 0.23, 0.05];

fn for_each_specimen(mut f: impl FnMut(&str, &Scene, &Mesh, &Patches, f64)) {
    for (name, mesh) in specimens() {
        let scene = scene(vec![Shape::Mesh(mesh.clone())]);
        for size in SIZES {
            let patches = Patches::new(&scene, PatchSize::Edge(size));
            f(name, &scene, &mesh, &patches, size);
        }
    }
}

fn triangle_positions(mesh: &Mesh, face: usize, t: [u32; 3]) -> [DVec3; 3] {
    let ring = mesh.faces.get(face);
    t.map(|k| mesh.positions[ring[k as usize] as usize])
}

#[test]
fn areas_add_up_to_the_triangles_of_each_face() {
    for_each_specimen(|name, _, mesh, patches, size| {
        for face in 0..mesh.faces.len() {
            let expected: f64 = mesh
                .triangulate(face)
                .iter()
                .map(|&t| area_vector(&triangle_positions(mesh, face, t)).length())
                .sum();
            let id = FaceId {
                object: 0,
                face: face as u32,
            };
            let sum: f64 = patches.patches_of_face(id).map(|i| patches.area(i)).sum();
            assert!(
                (sum - expected).abs() < 1e-9 * expected,
                "{name} at {size}: {sum} for {expected}"
            );
        }
    });
}

pub(super) fn patch_edges(polygon: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
    let n = polygon.len();
    (0..n).map(move |k| (polygon[k], polygon[(k + 1) % n]))
}

#[test]
fn edges_keep_to_the_size() {
    for_each_specimen(|name, _, _, patches, size| {
        for i in 0..patches.len() {
            let irregular = matches!(
                patches.cells[patches.owner[i] as usize],
                Cells::Irregular(_)
            );
            let most = if irregular {
                1.5 * size
            } else {
                size * (1.0 + 1e-9)
            };
            let polygon = patches.polygon(i).expect("flat");
            for (p, q) in patch_edges(&polygon) {
                assert!(p.distance(q) <= most, "{name} at {size}: {}", p.distance(q));
            }
        }
    });
}

#[test]
fn patches_keep_the_front_of_their_face() {
    for_each_specimen(|name, _, mesh, patches, size| {
        for i in 0..patches.len() {
            let vector = area_vector(&patches.polygon(i).expect("flat"));
            assert!(vector.dot(patches.normal(i)) > 0.0, "{name} at {size}");
            let face = mesh.face_area_vector(patches.face(i).face as usize);
            assert!(vector.dot(face) > 0.0, "{name} at {size}");
        }
    });
}

/// Counts how often each edge is used in each direction, by the bits of its ends.
pub(super) fn edge_uses(patches: &Patches) -> HashMap<[u64; 6], (u32, u32)> {
    let mut uses = HashMap::new();
    for i in 0..patches.len() {
        for (p, q) in patch_edges(&patches.polygon(i).expect("flat")) {
            let (a, b) = (p.to_array(), q.to_array());
            let (forward, [a, b]) = if a < b {
                (true, [a, b])
            } else {
                (false, [b, a])
            };
            let key = [a[0], a[1], a[2], b[0], b[1], b[2]].map(f64::to_bits);
            let entry: &mut (u32, u32) = uses.entry(key).or_default();
            if forward {
                entry.0 += 1;
            } else {
                entry.1 += 1;
            }
        }
    }
    uses
}

#[test]
fn closed_meshes_stay_closed() {
    for mesh in [cuboid(DVec3::new(1.1, 2.03, 0.7)), globe(11, 6)] {
        for size in [0.9, 0.31, 0.1, 0.037] {
            let scene = scene(vec![Shape::Mesh(mesh.clone())]);
            let patches = Patches::new(&scene, PatchSize::Edge(size));
            for (edge, uses) in edge_uses(&patches) {
                assert_eq!(uses, (1, 1), "{:?} at {size}", edge.map(f64::from_bits));
            }
        }
    }
}

#[test]
fn faces_of_different_objects_share_points() {
    // Each face of the cube is an object with vertices of its own, one of them triangulated.
    let cube = cuboid(DVec3::new(1.1, 2.03, 0.7));
    let alone = |f: usize| mesh(&cube.face_positions(f), &[&[0, 1, 2, 3]]);
    let mut shapes: Vec<Shape> = (0..5).map(|f| Shape::Mesh(alone(f))).collect();
    shapes.push(Shape::Mesh(mesh(
        &cube.face_positions(5),
        &[&[0, 1, 2], &[2, 3, 0]],
    )));
    for size in [0.5, 0.1, 0.033] {
        let patches = Patches::new(&scene(shapes.clone()), PatchSize::Edge(size));
        for uses in edge_uses(&patches).values() {
            assert_eq!(*uses, (1, 1), "at {size}");
        }
    }
}

/// The tracer's representation of a point of a face: triangle and weights.
pub(super) fn hit(mesh: &Mesh, face: usize, p: DVec3) -> (u32, f32, f32) {
    let mut best = (0, 0.0, 0.0, f64::NEG_INFINITY);
    for (k, t) in (0..).zip(mesh.triangulate(face)) {
        let [a, b, c] = triangle_positions(mesh, face, t);
        let n = (b - a).cross(c - a);
        let (u, v) = (
            (p - a).cross(c - a).dot(n) / n.length_squared(),
            (b - a).cross(p - a).dot(n) / n.length_squared(),
        );
        let least = u.min(v).min(1.0 - u - v);
        if least > best.3 {
            best = (k, u, v, least);
        }
    }
    (best.0, best.1 as f32, best.2 as f32)
}

#[test]
fn locate_finds_what_sample_gave() {
    for_each_specimen(|name, _, mesh, patches, size| {
        let stride = (patches.len() / 500).max(1);
        for i in (0..patches.len()).step_by(stride) {
            for (u1, u2) in [(0.05, 0.08), (0.5, 0.6), (0.93, 0.2), (0.3, 0.94)] {
                let face = patches.face(i);
                let p = patches.sample(i, u1, u2).position;
                let (t, u, v) = hit(mesh, face.face as usize, p);
                let patch = patches.locate(0, face.face, t, u, v);
                assert_eq!(patch as usize, i, "{name} at {size}, {u1} {u2}");
            }
        }
    });
}

/// Points of a face whose corners are not in one plane to the last digit lie on its triangles, so that rays
/// from there do not start behind them.
#[test]
fn points_lie_on_the_triangles_of_bent_faces() {
    for bend in [9e-6, -9e-6] {
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, bend), DVec3::Y],
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], 0);
        let scene = scene(vec![Shape::Mesh(mesh.clone())]);
        for size in [0.0, 0.3] {
            let patches = Patches::new(&scene, PatchSize::Edge(size));
            assert_eq!(patches.len() == 1, size == 0.0);
            for i in 0..patches.len() {
                for (u1, u2) in [(0.05, 0.08), (0.5, 0.6), (0.93, 0.2), (0.3, 0.94)] {
                    let p = patches.sample(i, u1, u2).position;
                    let height = mesh.triangulate(0).into_iter().map(|t| {
                        let [a, b, c] = t.map(|k| mesh.positions[k as usize]);
                        (b - a).cross(c - a).normalize().dot(p - a).abs()
                    });
                    let height = height.fold(f64::INFINITY, f64::min);
                    assert!(height < 1e-12, "{bend} {size} {i}: {height}");
                    check_above(&patches, i, [u1, u2]);
                }
            }
        }
    }
}

/// Hemicubes stand on the triangles that item buffers draw, which may be divided along the other diagonal.
fn check_above(patches: &Patches, i: usize, [u1, u2]: [f64; 2]) {
    let facets = PatchFacets::new(patches);
    for p in [
        facets.sample(i, u1, u2).position,
        facets.above(i, patches.centre(i)),
    ] {
        let height = facets.of(i).into_iter().filter_map(|[a, b, c]| {
            let normal = (b - a).cross(c - a);
            let is_inside =
                |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) > -1e-12;
            (is_inside(a, b) && is_inside(b, c) && is_inside(c, a))
                .then(|| normal.normalize().dot(p - a).abs())
        });
        let height = height.fold(0.0, f64::max);
        assert!(height < 1e-12, "{i}: {height}");
    }
}

#[test]
fn locate_on_primitives() {
    for kind in KINDS {
        let scene = scene(vec![primitive(kind)]);
        let patches = Patches::new(&scene, PatchSize::Edge(0.3));
        let Shape::Primitive(shape) = &scene.objects[0].shape else {
            unreachable!("made as a primitive");
        };
        for i in 0..patches.len() {
            for (u1, u2) in [(0.1, 0.2), (0.5, 0.5), (0.9, 0.85)] {
                let p = patches.sample(i, u1, u2).position;
                let local = shape.world_from_object.inverse().transform_point3(p);
                let (part, u, v) = kind.locate(local);
                let patch = patches.locate(0, part as u32, 0, u as f32, v as f32);
                assert_eq!(patch as usize, i, "{kind:?} {u} {v}");
            }
        }
    }
}

#[test]
fn locate_is_total() {
    let mut shapes: Vec<Shape> = specimens().into_iter().map(|s| Shape::Mesh(s.1)).collect();
    shapes.extend(KINDS.map(primitive));
    let scene = scene(shapes);
    let patches = Patches::new(&scene, PatchSize::Edge(0.3));
    let odd = [
        -1e30,
        -1e-6,
        0.0,
        0.5,
        1.0,
        1.00001,
        3.0,
        f32::INFINITY,
        f32::NAN,
    ];
    for object in (0..=scene.objects.len() as u32).chain([u32::MAX]) {
        for face in [0, 1, 5, 1000, u32::MAX] {
            for triangle in [0, 1, 7, u32::MAX] {
                for (u, v) in odd.iter().flat_map(|u| odd.map(|v| (*u, v))) {
                    let patch = patches.locate(object, face, triangle, u, v);
                    assert!((patch as usize) < patches.len());
                }
            }
        }
    }
}

#[test]
fn samples_are_uniform_by_area() {
    let n = 64;
    let grid = (0..n * n).map(|k| {
        let at = |i: usize| (i as f64 + 0.5) / n as f64;
        (at(k % n), at(k / n))
    });
    let check = |name: &str, patches: &Patches, i: usize| {
        let points: Vec<PatchPoint> = grid.clone().map(|(a, b)| patches.sample(i, a, b)).collect();
        let count = points.len() as f64;
        let weight: f64 = points.iter().map(|p| p.weight).sum::<f64>() / count;
        assert!(
            (weight - 1.0).abs() < 2e-3,
            "{name} patch {i}: mean weight {weight}"
        );
        if patches.polygon(i).is_some() {
            let mean = points.iter().map(|p| p.position).sum::<DVec3>() / count;
            let off = mean.distance(patches.centre(i)) / patches.diameter(i);
            assert!(off < 1e-3, "{name} patch {i}: centroid off by {off}");
        }
    };
    for (name, mesh) in specimens() {
        let patches = Patches::new(&scene(vec![Shape::Mesh(mesh)]), PatchSize::Edge(0.7));
        (0..patches.len())
            .step_by(7)
            .for_each(|i| check(name, &patches, i));
    }
    for kind in KINDS {
        let patches = Patches::new(&scene(vec![primitive(kind)]), PatchSize::Edge(0.7));
        (0..patches.len())
            .step_by(3)
            .for_each(|i| check(&format!("{kind:?}"), &patches, i));
    }
}

#[test]
fn areas_of_primitives_are_those_of_the_exact_surface() {
    let check = |kind: PrimitiveKind, expected: f64| {
        let shape = Shape::Primitive(Primitive::new(kind, DAffine3::IDENTITY, 0));
        let patches = Patches::new(&scene(vec![shape]), PatchSize::Edge(0.5));
        let sum: f64 = (0..patches.len()).map(|i| patches.area(i)).sum();
        assert!((sum / expected - 1.0).abs() < 1e-9, "{kind:?}: {sum}");
    };
    check(PrimitiveKind::Sphere, 4.0 * PI);
    check(PrimitiveKind::Cylinder, 4.0 * PI);
    check(PrimitiveKind::Cone { top: 0.0 }, PI * (1.0 + 2f64.sqrt()));
    check(PrimitiveKind::Cuboid, 6.0);
    check(PrimitiveKind::Square, 1.0);
}

fn least_angle(polygon: &[DVec3]) -> f64 {
    let n = polygon.len();
    (0..n)
        .map(|k| {
            let (next, before) = (polygon[(k + 1) % n], polygon[(k + n - 1) % n]);
            (next - polygon[k]).angle_between(before - polygon[k])
        })
        .fold(PI, f64::min)
        .to_degrees()
}

#[test]
fn irregular_patches_are_no_slivers() {
    let check = |name: &str, mesh: Mesh, size: f64| {
        let sharpest = least_angle(&mesh.face_positions(0)).min(15.0);
        let patches = Patches::new(&scene(vec![Shape::Mesh(mesh)]), PatchSize::Edge(size));
        for i in 0..patches.len() {
            let angle = least_angle(&patches.polygon(i).expect("flat"));
            assert!(
                angle >= 0.9 * sharpest,
                "{name} at {size}: {angle}° of {sharpest}°"
            );
        }
    };
    for (name, mesh) in specimens() {
        let even = [
            "kite",
            "trapezoid",
            "triangle",
            "long triangle",
            "L",
            "pentagon",
            "arrow",
            "disc",
        ];
        if even.contains(&name) {
            for size in [0.3, 0.17, 0.1, 0.043, 0.02] {
                check(name, mesh.clone(), size);
            }
        }
    }
}

#[test]
fn long_thin_faces_are_divided_along_their_length() {
    let check = |outline: &[(f64, f64)], size: f64, most: usize| {
        let mesh = polygon(outline);
        let patches = Patches::new(&scene(vec![Shape::Mesh(mesh)]), PatchSize::Edge(size));
        assert!(patches.len() <= most, "{} patches", patches.len());
    };
    check(&[(0., 0.), (4., 0.), (4., 0.01), (0., 0.01)], 0.1, 40);
    check(&[(0., 0.), (4., 0.), (0.1, 0.02)], 0.1, 81);
}

#[test]
fn small_faces_stay_whole() {
    let mesh = globe(30, 12);
    let faces = mesh.faces.len();
    let scene = scene(vec![Shape::Mesh(mesh)]);
    for size in [
        PatchSize::Edge(0.5),
        PatchSize::Edge(f64::NAN),
        PatchSize::Count(10),
    ] {
        assert_eq!(Patches::new(&scene, size).len(), faces);
    }
}

#[test]
fn fine_figures_leave_patches_for_the_room() {
    let figure = globe(30, 12);
    let faces = figure.faces.len();
    let floor = polygon(&[(-50., -50.), (50., -50.), (50., 50.), (-50., 50.)]);
    let scene = scene(vec![Shape::Mesh(figure), Shape::Mesh(floor)]);
    let floor_patches = |size| {
        let patches = Patches::new(&scene, size);
        patches.len() - faces
    };
    let added = floor_patches(PatchSize::Count(300));
    assert!((120..180).contains(&added), "half of 300: {added}");
    let even = floor_patches(PatchSize::Squares(300));
    // The figure crosses the floor, which divides it further.
    assert!((300..700).contains(&even), "{even}");
}

/// Exact shapes have their share of the area, as the polygons have that stand for them.
#[test]
fn squares_divide_exact_shapes_as_they_do_meshes() {
    let exact = |kind| Primitive::new(kind, DAffine3::from_scale(DVec3::splat(3.0)), 0);
    for kind in [
        PrimitiveKind::Square,
        PrimitiveKind::Cuboid,
        PrimitiveKind::Sphere,
        PrimitiveKind::Cylinder,
    ] {
        let scene = scene(vec![Shape::Primitive(exact(kind))]);
        let patches = Patches::new(&scene, PatchSize::Squares(900)).len();
        // The cells of a sphere are narrow at its poles.
        assert!((800..1_500).contains(&patches), "{kind:?}: {patches}");
    }
}

/// A million details must not hide in the tolerance of the count what the floor lacks.
#[test]
fn floors_get_their_share_beside_any_number_of_details() {
    let pyramid = |k: u32| {
        let at = DVec3::new(f64::from(k % 100), f64::from(k / 100), 1.0);
        let ends = [DVec3::ZERO, 0.1 * DVec3::X, 0.1 * DVec3::Y, 0.1 * DVec3::Z];
        let corners = ends.map(|p| at + p);
        mesh(&corners, &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]])
    };
    let floor = || polygon(&[(-50., -50.), (150., -50.), (150., 150.), (-50., 150.)]);
    for details in [0, 10, 60, 500, 10_000] {
        let mut shapes: Vec<Shape> = (0..details).map(|k| Shape::Mesh(pyramid(k))).collect();
        shapes.push(Shape::Mesh(floor()));
        let patches = Patches::new(&scene(shapes), PatchSize::Count(400));
        let floor_patches = patches.patches_of(details).len();
        // Half of 400 is left at least, and everything that the details do not use.
        let expected = 200.max(400usize.saturating_sub(4 * details as usize));
        let off = floor_patches as f64 / expected as f64 - 1.0;
        assert!(
            off.abs() < 0.1,
            "{details} details, {floor_patches} patches"
        );
    }
}

/// One region of this many corners would take a minute.
#[test]
fn faces_of_many_corners_are_divided_by_their_triangles() {
    let n = 20_000;
    let spike = |k: u32| {
        let angle = 2.0 * PI * f64::from(k) / f64::from(n);
        let reach = if k.is_multiple_of(2) { 1.0 } else { 0.7 };
        (reach * angle.cos(), reach * angle.sin())
    };
    let saw = polygon(&(0..n).map(spike).collect::<Vec<_>>());
    let expected = saw.area();
    let scene = scene(vec![Shape::Mesh(saw)]);
    let patches = Patches::new(&scene, PatchSize::Count(1000));
    let sum: f64 = (0..patches.len()).map(|i| patches.area(i)).sum();
    assert!((sum / expected - 1.0).abs() < 1e-6, "{sum} of {expected}");
    let whole = 0..patches.len();
    let face = FaceId { object: 0, face: 0 };
    assert_eq!(patches.patches_of_face(face), whole);
    assert!(whole.len() < 22_000, "{} patches", whole.len());
}

#[test]
fn counts_come_near() {
    let check = |name: &str, scene: &Scene, count: usize| {
        let got = Patches::new(scene, PatchSize::Count(count)).len();
        let off = got as f64 / count as f64 - 1.0;
        assert!(off.abs() < 0.1, "{name}: {got} for {count}");
    };
    let mut shapes: Vec<Shape> = specimens().into_iter().map(|s| Shape::Mesh(s.1)).collect();
    shapes.extend(KINDS.map(primitive));
    let mixed = scene(shapes);
    let trapezoid = scene(vec![Shape::Mesh(specimens().swap_remove(2).1)]);
    for count in [3000, 10_000, 100_000] {
        check("all", &mixed, count);
        check("trapezoid", &trapezoid, count);
    }
}

#[test]
fn a_cube_has_creases() {
    let check = |mesh: Mesh, expected: usize| {
        let patches = Patches::new(&scene(vec![Shape::Mesh(mesh)]), PatchSize::Edge(2.0));
        assert_eq!(patches.vertices().len(), expected);
    };
    let cube = || cuboid(DVec3::ONE);
    check(cube(), 24);
    check(
        Mesh {
            smoothing: vec![0; 6],
            ..cube()
        },
        24,
    );
    // One group around the sides, none on the lids: 8 for the sides, 4 for each lid.
    check(
        Mesh {
            smoothing: vec![1, 1, 1, 1, 0, 0],
            ..cube()
        },
        16,
    );
    let outward = |p: &DVec3| (*p - DVec3::splat(0.5)).normalize();
    let normals = Attribute::per_vertex(cube().positions.iter().map(outward).collect());
    check(
        Mesh {
            normals: Some(normals),
            ..cube()
        },
        8,
    );
}

#[test]
fn gather_positions_lie_on_their_patch_and_off_other_walls() {
    let size = DVec3::new(1.0, 2.0, 0.7);
    let scene = scene(vec![Shape::Mesh(cuboid(size))]);
    let patches = Patches::new(&scene, PatchSize::Edge(0.2));
    for (v, vertex) in patches.vertices().iter().enumerate() {
        let adjoining = patches.patches_at(v);
        assert!(!adjoining.is_empty());
        for axis in 0..3 {
            let (g, n) = (vertex.gather[axis], vertex.normal[axis]);
            if n.abs() > 0.5 {
                assert_eq!(g, vertex.position[axis], "stays on its wall");
            } else {
                assert!(
                    g > 5e-5 && g < size[axis] - 5e-5,
                    "off the other walls: {g}"
                );
            }
        }
        for &i in adjoining {
            assert!(patches.normal(i as usize).dot(vertex.normal) > 0.999);
        }
    }
}

#[test]
fn given_vertices_of_a_cube() {
    let scene = scene(vec![Shape::Mesh(cuboid(DVec3::ONE))]);
    let patches = Patches::new(&scene, PatchSize::Edge(0.3));
    for v in 0..8 {
        let shown = patches.given_vertices(0, v);
        assert_eq!(shown.len(), 3);
        for g in shown {
            assert!((g.weight - PI / 2.0).abs() < 1e-12);
            let Shape::Mesh(mesh) = &scene.objects[0].shape else {
                unreachable!("made as a mesh");
            };
            let at = patches.vertices()[g.display as usize].position;
            assert_eq!(at, mesh.positions[v as usize]);
        }
    }
    assert!(patches.given_vertices(0, 8).is_empty());
    assert!(patches.given_vertices(1, 0).is_empty());
}

#[test]
fn refined_meshes_are_valid_and_carry_everything() {
    for_each_specimen(|name, scene, given, patches, size| {
        let mut scene = scene.clone();
        let mut dressed = given.clone();
        // A linear function of position, which every interpolation reproduces.
        let value = |p: DVec3| DVec2::new(p.x + 2.0 * p.y, p.z - p.x);
        dressed.uvs = Some(Attribute {
            values: given
                .faces
                .corners
                .iter()
                .map(|&v| value(given.positions[v as usize]))
                .collect(),
            corners: Some((0..given.faces.corners.len() as u32).collect()),
        });
        dressed.colors = given
            .positions
            .iter()
            .map(|p| Rgb::grey(p.x + 5.0))
            .collect();
        scene.objects[0].shape = Shape::Mesh(dressed);
        let RefinedShape::Mesh(mesh) = patches.refined(0, &scene) else {
            panic!("{name} became a surface");
        };
        assert_eq!(mesh.faces.len(), patches.len());
        assert_eq!(mesh.positions.len(), patches.vertices().len());
        let uvs = mesh.uvs.clone().expect("kept");
        for (corner, &v) in mesh.faces.corners.iter().enumerate() {
            let p = mesh.positions[v as usize];
            assert!(
                uvs.at(corner, v).distance(value(p)) < 1e-6,
                "{name} at {size}"
            );
            assert!(
                (mesh.colors[v as usize].r - p.x - 5.0).abs() < 1e-6,
                "{name}"
            );
        }
        scene.objects[0].shape = Shape::Mesh(mesh);
        scene.validate().expect(name);
    });
}

#[test]
fn refined_primitives_are_grids_of_the_display_vertices() {
    for kind in KINDS {
        let scene = scene(vec![primitive(kind)]);
        let patches = Patches::new(&scene, PatchSize::Edge(0.4));
        let RefinedShape::Surface(grids) = patches.refined(0, &scene) else {
            panic!("{kind:?} became a mesh");
        };
        let Shape::Primitive(shape) = &scene.objects[0].shape else {
            unreachable!("made as a primitive");
        };
        let mesh = shape.tessellate(&grids);
        let shown: Vec<DVec3> = patches.vertices().iter().map(|v| v.position).collect();
        assert_eq!(mesh.positions, shown);
        assert_eq!(mesh.faces.len(), patches.len());
    }
}

#[test]
fn bad_geometry_gives_no_patches_and_no_panic() {
    let far = DVec3::splat(1e300);
    let odd = mesh(
        &[
            DVec3::ZERO,
            DVec3::X,
            2.0 * DVec3::X,
            DVec3::NAN,
            far,
            -far,
            DVec3::Y,
            DVec3::X + DVec3::Y,
        ],
        &[
            &[0, 1, 2],
            &[0, 0, 0],
            &[0, 1, 3],
            &[0, 4, 5],
            &[4, 5, 6],
            &[0, 1, 6, 7],
            &[0, 1, 7, 6, 0],
            &[0, 1, 0, 1],
        ],
    );
    for size in [
        PatchSize::Count(1000),
        PatchSize::Edge(0.1),
        PatchSize::Edge(0.0),
    ] {
        let patches = Patches::new(&scene(vec![Shape::Mesh(odd.clone())]), size);
        for i in 0..patches.len() {
            assert!(patches.area(i) > 0.0 && patches.area(i).is_finite());
            assert!((patches.normal(i).length() - 1.0).abs() < 1e-9);
        }
        let degenerate = FaceId { object: 0, face: 0 };
        assert!(patches.patches_of_face(degenerate).is_empty());
    }
    for empty in [Scene::default(), scene(vec![Shape::Mesh(Mesh::default())])] {
        let patches = Patches::new(&empty, PatchSize::Count(100));
        assert!(patches.is_empty());
        assert_eq!(patches.locate(0, 0, 0, 0.1, 0.1), 0);
    }
}

#[test]
fn the_same_scene_gives_the_same_bits() {
    let shapes = || specimens().into_iter().map(|s| Shape::Mesh(s.1)).collect();
    let divide = || Patches::new(&scene(shapes()), PatchSize::Count(5000));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let (one, many) = (pool.expect("a thread").install(divide), divide());
    assert_eq!(one.corners, many.corners);
    assert_eq!(one.vertices, many.vertices);
}

#[test]
fn tiny_sizes_stop_at_the_cap() {
    let square = polygon(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)]);
    let scene = scene(vec![Shape::Mesh(square)]);
    let outline = Outline::new(&scene);
    let contacts = Contacts::new(&outline);
    let division = Division::new(&outline, &contacts, PatchSize::Edge(1e-30));
    let count: usize = division.cells.iter().map(Cells::len).sum();
    assert!(
        count <= divide::MAX_PATCHES && count > divide::MAX_PATCHES / 4,
        "{count}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Star-shaped polygons: convex, concave, with short and long sides.
    #[test]
    fn any_star_is_tiled_and_located(
        radii in prop::collection::vec(0.2f64..2.0, 3..12),
        size in 0.05f64..1.5,
        u in prop::collection::vec((0.03f64..0.97, 0.03f64..0.97), 20),
    ) {
        let n = radii.len() as f64;
        let corner = |(k, r): (usize, &f64)| {
            let angle = 2.0 * PI * k as f64 / n;
            (r * angle.cos(), r * angle.sin())
        };
        let star = polygon(&radii.iter().enumerate().map(corner).collect::<Vec<_>>());
        let expected = star.area();
        let scene = scene(vec![Shape::Mesh(star.clone())]);
        let patches = Patches::new(&scene, PatchSize::Edge(size));
        let sum: f64 = (0..patches.len()).map(|i| patches.area(i)).sum();
        prop_assert!((sum / expected - 1.0).abs() < 1e-9);
        for i in 0..patches.len() {
            for (p, q) in patch_edges(&patches.polygon(i).expect("flat")) {
                prop_assert!(p.distance(q) <= 1.5 * size, "{} at {size}", p.distance(q));
            }
        }
        for (k, (u1, u2)) in u.into_iter().enumerate() {
            let i = (k * 7919) % patches.len();
            let p = patches.sample(i, u1, u2).position;
            let (t, u, v) = hit(&star, 0, p);
            prop_assert_eq!(patches.locate(0, 0, t, u, v) as usize, i);
        }
    }
}
