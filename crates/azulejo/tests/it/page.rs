//! Pages of scenes with light on their vertices.

use azulejo::bake::web_page::{self, PageLightmap, PageMesh, PageModel};
use azulejo::page::{least_size, of_scene};
use azulejo::scene::synthetic::cube_room;
use azulejo::scene::{
    BackIrradiance, Faces, Material, Mesh, Object, Primitive, Rgb, Scene, Shape, Sidedness,
};
use glam::DVec3;

/// A square of the plane z = 0 as a quadrilateral, with this irradiance at its corners.
fn square(light: [f64; 4]) -> Mesh {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    Mesh {
        positions: corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec(),
        faces: Faces {
            starts: vec![0, 4],
            corners: vec![0, 1, 2, 3],
        },
        face_materials: vec![0],
        irradiance: light.map(Rgb::grey).to_vec(),
        irradiance_error: light.map(|e| Rgb::grey(0.1 * e)).to_vec(),
        ..Mesh::default()
    }
}

fn scene(meshes: Vec<Mesh>) -> Scene {
    let object = |mesh| Object::new("square", Shape::Mesh(mesh));
    Scene {
        materials: vec![Material::default()],
        objects: meshes.into_iter().map(object).collect(),
        ..Scene::default()
    }
}

fn written(model: &PageModel) -> usize {
    let mut page = Vec::new();
    web_page::write(model, &mut page).unwrap();
    page.len()
}

/// What a bilinear filter reads of values of a map at a place.
fn bilinear(map: &PageLightmap, values: &[[f32; 3]], place: [f64; 2]) -> f64 {
    let x = place[0] * f64::from(map.width) - 0.5;
    let y = place[1] * f64::from(map.height) - 0.5;
    let (left, top) = (x.floor(), y.floor());
    let at = |dx: f64, dy: f64| {
        let column = (left + dx).clamp(0.0, f64::from(map.width - 1));
        let row = (top + dy).clamp(0.0, f64::from(map.height - 1));
        f64::from(values[(row * f64::from(map.width) + column) as usize][0])
    };
    let (s, t) = (x - left, y - top);
    (1.0 - t) * ((1.0 - s) * at(0.0, 0.0) + s * at(1.0, 0.0))
        + t * ((1.0 - s) * at(0.0, 1.0) + s * at(1.0, 1.0))
}

/// Checks that the light at some points of a triangle is a linear function of their positions.
fn check_linear(mesh: &PageMesh, map: &PageLightmap, light: impl Fn([f32; 3]) -> f64) {
    for corners in mesh.indices.chunks(3) {
        for weights in [
            [1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.2, 0.5, 0.3],
            [0.6, 0.1, 0.3],
        ] {
            let sum = |values: &dyn Fn(usize) -> f32| -> f64 {
                let terms = corners.iter().zip(weights);
                terms.map(|(&c, w)| w * f64::from(values(c as usize))).sum()
            };
            let place = [0, 1].map(|k| sum(&|c| mesh.lightmap_uvs[c][k]));
            let position = [0, 1, 2].map(|k| sum(&|c| mesh.positions[c][k]) as f32);
            let expected = light(position);
            let found = bilinear(map, &map.irradiance, place);
            assert!(
                (found - expected).abs() < 1e-4 * expected,
                "{found} {expected}"
            );
            let error = bilinear(map, &map.standard_error, place);
            assert!((error - 0.1 * expected).abs() < 1e-4 * expected, "{error}");
        }
    }
}

#[test]
fn light_of_vertices_is_linear_between_them() {
    // 2 + x + 3y: the fourth texel of each triangle is its continuation.
    let squares = vec![square([2.0, 3.0, 6.0, 5.0]); 5];
    let model = of_scene(&scene(squares)).unwrap();
    assert_eq!((model.meshes.len(), model.lightmaps.len()), (5, 1));
    for mesh in &model.meshes {
        assert_eq!(mesh.indices.len(), 6);
        let light = |[x, y, _]: [f32; 3]| 2.0 + f64::from(x) + 3.0 * f64::from(y);
        check_linear(mesh, &model.lightmaps[0], light);
    }
    assert!(written(&model) > 0);
}

#[test]
fn what_has_no_light_is_plain() {
    let dark = Mesh {
        irradiance: Vec::new(),
        irradiance_error: Vec::new(),
        ..square([0.0; 4])
    };
    let model = of_scene(&scene(vec![square([1.0; 4]), dark.clone()])).unwrap();
    let lit: Vec<bool> = (model.meshes.iter())
        .map(|m| !m.lightmap_uvs.is_empty())
        .collect();
    assert_eq!(lit, [true, false]);
    let plain = of_scene(&scene(vec![dark])).unwrap();
    assert!(plain.lightmaps.is_empty() && plain.note.contains("plain"));
    // Without places of their own in a lightmap, triangles share vertices.
    assert_eq!(plain.meshes[0].positions.len(), 4);
    assert!(written(&plain) > 0);
    assert!(written(&of_scene(&Scene::default()).unwrap()) > 0);
}

/// Both sides of a sheet show their own light, and neither is seen from the other.
#[test]
fn sheets_have_two_sides() {
    let mut sheet = square([1.0; 4]);
    sheet.back = Some(Box::new(BackIrradiance {
        irradiance: vec![Some(Rgb::grey(4.0)); 4],
        error: vec![Rgb::grey(0.4); 4],
    }));
    let mut sheet = scene(vec![sheet]);
    sheet.materials[0].sidedness = Sidedness::Two;
    let model = of_scene(&sheet).unwrap();
    let triangles: usize = model.meshes.iter().map(|m| m.indices.len() / 3).sum();
    assert_eq!(triangles, 4);
    assert!(
        model
            .meshes
            .iter()
            .all(|m| !model.materials[m.material as usize].double_sided)
    );
    let map = &model.lightmaps[0];
    let count = |value: f32| map.irradiance.iter().filter(|e| e[0] == value).count();
    assert_eq!((count(1.0), count(4.0)), (8, 8));
}

#[test]
fn exact_shapes_become_polygons() {
    let mut ball = scene(Vec::new());
    let sphere = Primitive::sphere(DVec3::ZERO, 1.0, 0);
    ball.objects
        .push(Object::new("ball", Shape::Primitive(sphere)));
    let model = of_scene(&ball).unwrap();
    assert!(model.meshes[0].indices.len() > 300 && model.lightmaps.is_empty());
    assert!(least_size(&ball) < written(&model) as u64);
}

/// The least size is no more than the size, whatever is shown.
#[test]
fn the_size_is_known_from_below() {
    let room = cube_room();
    assert_eq!(least_size(&room), 6 * 12);
    assert!(least_size(&room) < written(&of_scene(&room).unwrap()) as u64);
}
