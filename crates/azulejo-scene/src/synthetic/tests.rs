//! The documented properties of the scenes: closed, consistently oriented, of the requested size.

use super::*;
use std::collections::HashMap;

/// In a closed, consistently oriented surface every directed edge has its reverse.
fn check_closed(mesh: &Mesh) {
    check_all_closed([mesh]);
}

/// The same of a surface that several meshes share.
fn check_all_closed<'a>(meshes: impl IntoIterator<Item = &'a Mesh>) {
    let mut ids: HashMap<[u64; 3], usize> = HashMap::new();
    let mut edges: HashMap<(usize, usize), i32> = HashMap::new();
    let meshes = meshes.into_iter();
    for (mesh, face) in meshes.flat_map(|m| m.faces.iter().map(move |f| (m, f))) {
        let corner: Vec<usize> = face
            .iter()
            .map(|&v| {
                // Adding zero makes -0 and 0 the same corner.
                let key = mesh.positions[v as usize]
                    .to_array()
                    .map(|x| (x + 0.0).to_bits());
                let next = ids.len();
                *ids.entry(key).or_insert(next)
            })
            .collect();
        for k in 0..corner.len() {
            let (a, b) = (corner[k], corner[(k + 1) % corner.len()]);
            *edges.entry((a, b)).or_default() += 1;
            *edges.entry((b, a)).or_default() -= 1;
        }
    }
    assert!(edges.values().all(|&n| n == 0));
}

/// Volume by Gauss's theorem: positive if the fronts face outside.
fn volume(mesh: &Mesh) -> f64 {
    let cone = |f: usize| mesh.face_area_vector(f).dot(mesh.face_positions(f)[0]) / 3.0;
    (0..mesh.faces.len()).map(cone).sum()
}

fn mesh(object: &Object) -> &Mesh {
    match &object.shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("{} is not a mesh", object.name),
    }
}

#[test]
fn cube_is_closed_and_faces_inward() {
    let scene = cube_room();
    scene.validate().unwrap();
    check_closed(mesh(&scene.objects[0]));
    assert_eq!(volume(mesh(&scene.objects[0])), -1.0);
}

#[test]
fn room_is_closed_and_as_large_as_asked() {
    for target in [20_000, 200_000] {
        let scene = furnished_room(target);
        scene.validate().unwrap();
        let meshes = || scene.objects.iter().map(mesh);
        let count: usize = meshes().map(|m| m.faces.triangle_count()).sum();
        let ratio = count as f64 / target as f64;
        assert!(
            (0.9..1.1).contains(&ratio),
            "{count} triangles for {target}"
        );
        meshes().for_each(check_closed);
        assert!((volume(mesh(&scene.objects[0])) + 90.0).abs() < 1e-9);
        assert!(meshes().skip(1).all(|m| volume(m) > 0.0));
    }
}

#[test]
fn sphere_is_closed_and_as_large_as_asked() {
    let scene = displaced_sphere(30_000);
    scene.validate().unwrap();
    let mesh = mesh(&scene.objects[0]);
    check_closed(mesh);
    assert_eq!(mesh.faces.len(), 30_000);
    assert!(volume(mesh) > 3.0);
}

#[test]
fn cornell_box_looks_inward_and_blocks_outward() {
    for variant in [CornellVariant::Diffuse, CornellVariant::MirrorBlock] {
        let scene = cornell_box(variant);
        scene.validate().unwrap();
        assert_eq!(scene.objects.len(), 19);
        let middle = DVec3::new(278.0, 274.0, 280.0);
        for o in &scene.objects[..9] {
            let m = mesh(o);
            let inward = m.face_area_vector(0).dot(middle - m.positions[0]);
            assert!(inward > 0.0, "{}", o.name);
        }
        for block in [&scene.objects[9..14], &scene.objects[14..]] {
            let centre = block[0].bounds().centre() * DVec3::new(1.0, 0.5, 1.0);
            for o in block {
                let m = mesh(o);
                let outward = m.face_area_vector(0).dot(m.positions[0] - centre);
                assert!(outward > 0.0, "{}", o.name);
            }
        }
    }
}

fn meshes(scene: &Scene) -> impl Iterator<Item = &Mesh> {
    scene.objects.iter().map(mesh)
}

/// Numbers of triangles and of quadrilaterals; there is nothing else.
fn facets(scene: &Scene) -> (usize, usize) {
    let corners = |n: usize| {
        let faces = meshes(scene).flat_map(|m| m.faces.iter());
        faces.filter(|f| f.len() == n).count()
    };
    let count: usize = meshes(scene).map(|m| m.faces.len()).sum();
    assert_eq!(count, corners(3) + corners(4));
    (corners(3), corners(4))
}

/// Every facet is flat and convex: its corners turn the same way about its normal.
fn check_flat_and_convex(scene: &Scene) {
    for (object, mesh) in scene.objects.iter().map(|o| (o, mesh(o))) {
        for face in 0..mesh.faces.len() {
            let p = mesh.face_positions(face);
            let normal = mesh.face_area_vector(face).normalize();
            let size = p[0].distance(p[2]);
            for k in 0..p.len() {
                let (a, b) = (p[(k + 1) % p.len()] - p[k], p[(k + 2) % p.len()] - p[k]);
                let place = || format!("{} {face}: {p:?}", object.name);
                assert!(normal.dot(b).abs() < 1e-9 * size, "{}", place());
                assert!(a.cross(b).dot(normal) > 1e-6 * size * size, "{}", place());
            }
        }
    }
}

fn mirrors(scene: &Scene) -> usize {
    let is_mirror = |&&m: &&MaterialId| scene.materials[m as usize].is_specular();
    let of = |m: &Mesh| m.face_materials.iter().filter(is_mirror).count();
    meshes(scene).map(of).sum()
}

#[test]
fn room_with_table_is_one_closed_mesh_of_about_as_many_facets() {
    for (asked, least, most) in [
        (1, 136, 136),
        (500, 480, 520),
        (2_000, 1_950, 2_050),
        (5_000, 4_900, 5_100),
        (20_000, 19_800, 20_200),
    ] {
        let scene = room_with_table(asked);
        scene.validate().unwrap();
        let (triangles, quads) = facets(&scene);
        assert!(
            triangles == 0 && (least..=most).contains(&quads),
            "{quads} for {asked}"
        );
        check_closed(mesh(&scene.objects[0]));
        check_flat_and_convex(&scene);
        let things =
            2.0 * 1.0 * 0.05 + 4.0 * 0.08 * 0.08 * 0.7 + 0.6 * 0.5 * 0.9 + 0.5 * 0.45 * 0.5;
        assert!((volume(mesh(&scene.objects[0])) + 30.0 - things).abs() < 1e-9);
    }
}

#[test]
fn cornell_thesis_has_the_facets_and_mirrors_of_the_thesis() {
    for (asked, quads, expected) in [
        (0, 12_826, 0),
        (16, 12_826, 16),
        (32, 12_826, 32),
        (64, 12_826, 64),
        (65, 15_826, 65),
        (1_500, 15_826, 1_500),
        (usize::MAX, 15_826, 1_500),
    ] {
        let scene = cornell_thesis(asked);
        assert_eq!(facets(&scene), (96, quads), "{asked}");
        assert_eq!(mirrors(&scene), expected);
    }
}

#[test]
fn cornell_thesis_is_closed_at_any_detail() {
    for (mirrors, detail) in [(64, 0.01), (1_500, 0.3), (20, 1.0), (0, 2.0)] {
        let scene = cornell_thesis_at(mirrors, detail);
        scene.validate().unwrap();
        check_flat_and_convex(&scene);
        meshes(&scene).for_each(check_closed);
        let volumes: Vec<f64> = meshes(&scene).map(volume).collect();
        assert!((volumes[0] + 8.0).abs() < 1e-9);
        assert!(volumes[1..].iter().all(|&v| v > 0.0), "{volumes:?}");
    }
}

#[test]
fn street_has_the_facets_of_the_thesis() {
    let scene = street();
    assert_eq!(facets(&scene), (0, 61_795));
    let sky = mesh(&scene.objects[0]);
    assert_eq!(sky.faces.len(), 2_407);
    let sun = sky
        .face_materials
        .iter()
        .filter(|&&m| scene.materials[m as usize].name == "sun");
    assert_eq!(sun.count(), 10);
    let mean = sky.area() / 2_407.0;
    let off = |f| (sky.face_area_vector(f).length() / mean - 1.0).abs();
    let worst = (0..2_407).map(off).fold(0.0, f64::max);
    assert!(worst < 0.12, "{worst}");
    assert!(
        (300..1_200).contains(&mirrors(&scene)),
        "{}",
        mirrors(&scene)
    );
}

#[test]
fn street_is_closed_at_any_detail() {
    for detail in [0.02, 0.1, 0.5, 1.0, 1.7] {
        let scene = street_with_detail(detail);
        scene.validate().unwrap();
        check_flat_and_convex(&scene);
        check_all_closed(meshes(&scene));
        // The air under a dome of 100 m: less than a hemisphere, more than its inner cylinder.
        let air = -meshes(&scene).map(volume).sum::<f64>();
        assert!((1.2e6..2.1e6).contains(&air), "{air}");
        let count = facets(&scene).1 as f64 / 61_795.0;
        assert!(
            (0.5 * detail..2.0 * detail).contains(&count),
            "{count} for {detail}"
        );
    }
}

#[test]
fn an_array_of_cubes_covers_a_quarter() {
    let scene = cube_array(3, 2);
    scene.validate().unwrap();
    assert_eq!(scene.objects.len(), 1 + 9);
    let area_vectors = |k: usize| {
        let mesh = mesh(&scene.objects[k]);
        (0..mesh.faces.len()).map(move |f| mesh.face_area_vector(f))
    };
    let area = |k: usize| area_vectors(k).map(DVec3::length).sum::<f64>();
    // 6 × 6 units of ground of which 9 are built on, seen from above.
    let seen: DVec3 = area_vectors(0).sum();
    assert!((area(0) - 27.0).abs() < 1e-12 && (seen.z - 27.0).abs() < 1e-12);
    for k in 1..10 {
        // Five sides; without the base, the sum of the area vectors is that of the roof.
        let outward: DVec3 = area_vectors(k).sum();
        assert!((area(k) - 5.0).abs() < 1e-12 && (outward - DVec3::Z).length() < 1e-12);
        let middle = mesh(&scene.objects[k]).positions.iter().sum::<DVec3>();
        let middle = middle / mesh(&scene.objects[k]).positions.len() as f64;
        let mesh = mesh(&scene.objects[k]);
        let is_outward = |f: usize| {
            let corner = mesh.face_positions(f)[0];
            mesh.face_area_vector(f).dot(corner - middle) > 0.0
        };
        assert!((0..mesh.faces.len()).all(is_outward));
    }
}
