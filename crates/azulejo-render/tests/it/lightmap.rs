//! Lightmaps seen along rays.

use crate::{assert_close, mesh_of, polygon, radiance_along};
use azulejo_render::{FinalGather, SecondPass};
use azulejo_scene::{
    Attribute, Image, IrradiancePicture, Material, Object, Relief, ReliefKind, Rgb, Scene, Shape,
    SharedMesh, Sidedness, Texture, WrapMode,
};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::PI;

const REFLECTANCE: f64 = 0.5;
const SCALE: f64 = 40.0;
/// Texels of the lightmap, the upper row first.
const TEXELS: [f32; 4] = [1.0, 0.0, 0.25, 0.5];

/// The unit square, on which a lightmap of 2 × 2 texels lies.
fn square(sidedness: Sidedness) -> Scene {
    let mut scene = Scene::default();
    scene.textures.push(Texture {
        path: "light".into(),
        image: Some(Image::opaque(
            2,
            2,
            TEXELS.map(|t| [t, t, 0.5 * t]).to_vec(),
        )),
        // A lightmap does not go on beyond its edges, whatever its texture does.
        wrap: [WrapMode::Repeat; 2],
    });
    let lit = scene.add_material(Material {
        lightmap: Some(IrradiancePicture {
            texture: 0,
            scale: SCALE,
        }),
        sidedness,
        ..Material::diffuse("lit", Rgb::grey(REFLECTANCE))
    });
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let object = polygon(&mut scene, &corners, lit);
    let uvs = corners.map(|c| DVec2::new(c.x, c.y)).to_vec();
    mesh_of(&mut scene, object).lightmap_uvs = Some(Attribute::per_vertex(uvs));
    scene
}

/// ρE/π at a point of the square, by the bilinear formula.
fn expected(x: f64, y: f64) -> Rgb {
    let share = |t: f64| (2.0 * t - 0.5).clamp(0.0, 1.0);
    let (right, up) = (share(x), share(y));
    let [a, b, c, d] = TEXELS.map(f64::from);
    let texel = up * ((1.0 - right) * a + right * b) + (1.0 - up) * ((1.0 - right) * c + right * d);
    let light = REFLECTANCE * SCALE * texel / PI;
    Rgb::new(light, light, 0.5 * light)
}

/// Rays from above or below to points of the square.
fn down(height: f64, points: &[(f64, f64)]) -> Vec<(DVec3, DVec3)> {
    let ray = |&(x, y): &(f64, f64)| (DVec3::new(x, y, height), DVec3::new(x, y, 0.0));
    points.iter().map(ray).collect()
}

const SEEN: [(f64, f64); 7] = [
    (0.25, 0.75),
    (0.75, 0.75),
    (0.5, 0.5),
    (0.4, 0.3),
    (0.02, 0.97),
    (0.99, 0.6),
    (0.6, 0.01),
];

#[test]
fn texels_are_interpolated() {
    let scene = square(Sidedness::Two);
    assert!(scene.is_solved());
    for gather in [
        FinalGather::Unknown,
        FinalGather::Uneven(16),
        FinalGather::Everywhere(16),
    ] {
        let options = SecondPass {
            gather,
            ..SecondPass::default()
        };
        let found = radiance_along(&scene, &down(1.0, &SEEN), &options);
        for (&(x, y), found) in SEEN.iter().zip(found) {
            assert_close(found, expected(x, y), 1e-4);
        }
    }
}

/// One texel is that of both sides, except where the file says that there is one side.
#[test]
fn backs_of_sheets_show_the_same() {
    for (sidedness, share) in [
        (Sidedness::Two, 1.0),
        (Sidedness::Unsaid, 1.0),
        (Sidedness::One, 0.0),
    ] {
        let scene = square(sidedness);
        let found = radiance_along(&scene, &down(-1.0, &SEEN), &SecondPass::default());
        for (&(x, y), found) in SEEN.iter().zip(found) {
            assert_close(found, expected(x, y) * share, 1e-4);
        }
    }
}

/// Irradiance on vertices comes first.
#[test]
fn vertices_come_before_texels() {
    let mut scene = square(Sidedness::Two);
    mesh_of(&mut scene, 0).irradiance = vec![Rgb::grey(PI); 4];
    assert!(!scene.has_lightmap() && scene.is_solved());
    let found = radiance_along(&scene, &down(1.0, &SEEN), &SecondPass::default());
    for found in found {
        assert_close(found, Rgb::grey(REFLECTANCE), 1e-5);
    }
}

#[test]
fn instances_show_the_lightmap_of_their_mesh() {
    let mut scene = square(Sidedness::Two);
    let mesh = mesh_of(&mut scene, 0).clone();
    scene.objects.clear();
    let mut shared = SharedMesh::new(mesh);
    let mirrored = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let maps = [
        DAffine3::IDENTITY,
        DAffine3::from_translation(5.0 * DVec3::X),
        mirrored,
    ];
    for map in maps {
        let instance = Shape::Instance(shared.placed(map).unwrap());
        scene.objects.push(Object::new("", instance));
    }
    for map in maps {
        let rays = down(1.0, &SEEN).into_iter();
        let at = |(from, to)| (map.transform_point3(from), map.transform_point3(to));
        let rays: Vec<_> = rays.map(at).collect();
        let found = radiance_along(&scene, &rays, &SecondPass::default());
        for (&(x, y), found) in SEEN.iter().zip(found) {
            assert_close(found, expected(x, y), 1e-4);
        }
    }
}

/// A mirror shows the lightmap, and a surface without one the light that comes from it: above the middle of a
/// large plane of radiance L everywhere, E = πL.
#[test]
fn other_surfaces_see_the_light() {
    let mut scene = square(Sidedness::Two);
    if let Some(image) = &mut scene.textures[0].image {
        image.pixels = vec![[1.0; 3]; 4];
    }
    mesh_of(&mut scene, 0).positions.iter_mut().for_each(|p| {
        *p = (*p - DVec3::new(0.5, 0.5, 0.0)) * 1e4;
    });
    let light = REFLECTANCE * SCALE / PI;
    let mirror = scene.add_material(Material::mirror("mirror", Rgb::grey(0.5)));
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    // Both face down, one unit above the plane.
    for (material, x) in [(mirror, 0.0), (grey, 3.0)] {
        let at = DVec3::new(x, 0.0, 1.0);
        let corners = [
            at,
            at + DVec3::Y,
            at + DVec3::new(1.0, 1.0, 0.0),
            at + DVec3::X,
        ];
        polygon(&mut scene, &corners, material);
    }
    let up = |x: f64| (DVec3::new(x + 0.5, 0.5, 0.5), DVec3::new(x + 0.5, 0.5, 1.0));
    let options = SecondPass {
        samples_per_pixel: 16,
        ..SecondPass::default()
    };
    let found = radiance_along(&scene, &[up(0.0), up(3.0)], &options);
    assert_close(found[0], Rgb::grey(0.5 * light), 1e-4);
    assert_close(found[1], Rgb::grey(0.5 * light), 0.02 * light);
}

/// The light of a lightmap does not depend on relief.
#[test]
fn reliefs_show_the_same() {
    let mut scene = square(Sidedness::Two);
    scene.textures.push(Texture {
        path: "normals".into(),
        image: Some(Image::opaque(1, 1, vec![[0.8, 0.2, 0.6]])),
        ..Texture::default()
    });
    scene.materials[0].relief = Some(Relief {
        texture: 1,
        kind: ReliefKind::Normals { scale: 1.0 },
    });
    let mesh = mesh_of(&mut scene, 0);
    mesh.uvs = mesh.lightmap_uvs.clone();
    let found = radiance_along(&scene, &down(1.0, &SEEN), &SecondPass::default());
    for (&(x, y), found) in SEEN.iter().zip(found) {
        assert_close(found, expected(x, y), 1e-4);
    }
}

/// Lamps with a lightmap emit, too.
#[test]
fn lamps_with_a_lightmap_emit() {
    let mut scene = square(Sidedness::Two);
    scene.materials[0].emission = Rgb::grey(3.0);
    let found = radiance_along(&scene, &down(1.0, &SEEN), &SecondPass::default());
    for (&(x, y), found) in SEEN.iter().zip(found) {
        assert_close(found, expected(x, y) + Rgb::grey(3.0), 1e-4);
    }
}
