//! Rendered images, checked by pixel on every installed driver.

use super::*;
use crate::variants::all;
use crate::view::Shading;
use azulejo::render::{Tone, srgb_from_linear};
use azulejo::scene::{
    Attribute, BackplateFit, Camera, Fog, Image, Material, Mesh, Primitive, Rgb, SurfaceGrid,
};
use azulejo_testing::Need;
use glam::{DAffine3, DVec2, DVec3};
use std::sync::{Mutex, PoisonError};

/// Drivers are tested one after the other: OpenGL contexts do not run well in parallel.
static GATE: Mutex<()> = Mutex::new(());

/// Runs a test on each graphics API that has a driver.
fn on_each_driver(test: impl Fn(&mut Renderer)) {
    let _gate = GATE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut tried = 0;
    for backends in [wgpu::Backends::VULKAN, wgpu::Backends::GL] {
        let Ok(card) = HeadlessDevice::open(backends) else {
            continue;
        };
        tried += 1;
        let mut renderer = Renderer::new(card.device, card.queue).expect("shaders are taken");
        test(&mut renderer);
    }
    let outcome = if tried > 0 {
        Ok(())
    } else {
        Err("no graphics driver")
    };
    let _ = azulejo_testing::require(Need::Gpu, outcome);
}

/// A camera on the z axis looking along it; the image spans 2 × 2 world units at z = 0.
fn camera(distance: f64) -> Camera {
    Camera {
        name: String::new(),
        eye: DVec3::new(0.0, 0.0, distance),
        target: DVec3::ZERO,
        up: DVec3::Y,
        vertical_fov: 2.0 * (1.0 / distance).atan(),
        size: None,
    }
}

/// A square around the z axis that faces +z, with texture coordinates.
fn square(half: f64, z: f64, material: u32) -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mut mesh = Mesh {
        positions: corners
            .map(|(x, y)| DVec3::new(half * x, half * y, z))
            .to_vec(),
        uvs: Some(Attribute::per_vertex(
            corners
                .map(|(x, y)| DVec2::new(0.5 + 0.5 * x, 0.5 + 0.5 * y))
                .to_vec(),
        )),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    mesh
}

fn sphere() -> Mesh {
    let ball = Primitive::sphere(DVec3::ZERO, 0.8, 0);
    ball.tessellate(&[SurfaceGrid { nu: 64, nv: 32 }])
}

const BLACK: Background = Background::Color([0; 3]);
const SIZE: [u32; 2] = [64, 64];

fn draw(renderer: &mut Renderer, frame: &ViewportFrame) -> PixelBuffer {
    renderer.draw(frame).expect("an image");
    renderer.read().expect("pixels")
}

/// Draws one mesh from distance 4, after applying `change` to the frame.
fn draw_one(
    renderer: &mut Renderer,
    mesh: &Mesh,
    materials: &[&Material],
    change: impl Fn(&mut ViewportFrame),
) -> PixelBuffer {
    let drawn = [DrawnMesh::new(1, mesh)];
    let camera = camera(4.0);
    let mut frame = ViewportFrame::new(SIZE, &camera, &drawn, materials);
    frame.background = BLACK;
    change(&mut frame);
    renderer.forget();
    draw(renderer, &frame)
}

fn assert_near(found: [u8; 3], expected: [u8; 3], tolerance: u8, what: &str) {
    let is_near = found
        .iter()
        .zip(expected)
        .all(|(a, b)| a.abs_diff(b) <= tolerance);
    assert!(is_near, "{what}: {found:?}, expected {expected:?}");
}

fn byte(linear: f64) -> u8 {
    (255.0 * srgb_from_linear(linear)).round() as u8
}

#[test]
fn a_sphere_covers_its_disc_in_all_modes_of_faces() {
    let white = Material::diffuse("", Rgb::grey(0.8));
    // Ratio of half the apparent angle of the sphere to half the field of view.
    let apparent = (0.8f64 / 4.0).asin().tan() / 0.25;
    let expected = std::f64::consts::PI * (32.0 * apparent).powi(2);
    on_each_driver(|renderer| {
        for shading in [
            Shading::Flat,
            Shading::Gouraud,
            Shading::Irradiance,
            Shading::Normals,
        ] {
            let pixels = draw_one(renderer, &sphere(), &[&white], |f| {
                f.shading = shading;
                f.antialiasing = false;
            });
            let covered = pixels.rgba.chunks(4).filter(|p| p[..3] != [0; 3]).count();
            let error = (covered as f64 / expected - 1.0).abs();
            assert!(error < 0.03, "{shading:?}: {covered} of {expected}");
        }
    });
}

#[test]
fn what_is_nearer_hides_what_is_farther_in_any_order() {
    let (red, green) = (
        Material::emitter("", Rgb::new(1.0, 0.0, 0.0)),
        Material::emitter("", Rgb::new(0.0, 1.0, 0.0)),
    );
    let (near, far) = (square(0.3, 0.5, 0), square(0.9, -0.5, 1));
    let camera = camera(4.0);
    on_each_driver(|renderer| {
        for order in [[&near, &far], [&far, &near]] {
            let drawn = [DrawnMesh::new(1, order[0]), DrawnMesh::new(2, order[1])];
            renderer.forget();
            let pixels = draw(
                renderer,
                &ViewportFrame::new(SIZE, &camera, &drawn, &[&red, &green]),
            );
            assert_near(pixels.color(32, 32), [255, 0, 0], 1, "near");
            assert_near(pixels.color(12, 32), [0, 255, 0], 1, "far");
        }
    });
}

#[test]
fn light_is_exposed_and_toned_as_the_second_pass_does() {
    let mut mesh = square(0.8, 0.0, 0);
    mesh.irradiance = vec![Rgb::new(1.0, 2.0, 100.0); 4];
    let mut grey = Material::diffuse("", Rgb::grey(0.5));
    grey.emission = Rgb::new(0.1, 0.0, 0.0);
    let radiance = grey.emission + 0.5 / std::f64::consts::PI * mesh.irradiance[0];
    on_each_driver(|renderer| {
        for tone in [Tone::Linear, Tone::Reinhard, Tone::Filmic] {
            let pixels = draw_one(renderer, &mesh, &[&grey], |f| {
                f.shading = Shading::Irradiance;
                f.tone = tone;
                f.exposure = 0.7;
            });
            let expected = tone.map(0.7 * radiance).to_array().map(byte);
            assert_near(pixels.color(32, 32), expected, 2, &format!("{tone:?}"));
        }
    });
}

#[test]
fn what_is_not_solved_is_hatched_and_an_emitter_is_bright() {
    let (white, lamp) = (
        Material::diffuse("", Rgb::grey(0.8)),
        Material::emitter("", Rgb::grey(5.0)),
    );
    on_each_driver(|renderer| {
        let pixels = draw_one(renderer, &square(0.9, 0.0, 0), &[&white, &lamp], |f| {
            f.shading = Shading::Irradiance;
        });
        let row: Vec<u8> = (16..48).map(|x| pixels.color(x, 32)[0]).collect();
        let (least, most) = (row.iter().min(), row.iter().max());
        assert!(least < most && most < Some(&200), "{row:?}");
        for shading in [Shading::Irradiance, Shading::Gouraud, Shading::Flat] {
            let lamp = draw_one(renderer, &square(0.9, 0.0, 1), &[&white, &lamp], |f| {
                f.shading = shading;
                f.tone = Tone::Linear;
            });
            assert_near(lamp.color(32, 32), [255; 3], 1, "lamp");
        }
    });
}

#[test]
fn false_colours_are_those_of_the_map() {
    let mut mesh = square(0.9, 0.0, 0);
    mesh.irradiance = vec![Rgb::new(30.0, 0.0, 0.0); 4];
    let white = Material::default();
    on_each_driver(|renderer| {
        for map in all() {
            let mut scale = ColorScale {
                map,
                quantity: ColorScalar::Mean,
                high: 40.0,
                ..ColorScale::default()
            };
            let linear = draw_one(renderer, &mesh, &[&white], |f| {
                (f.shading, f.scale) = (Shading::FalseColor, scale);
            });
            assert_near(
                linear.color(32, 32),
                map.color(0.25),
                2,
                &format!("{map:?}"),
            );
            (scale.low, scale.high, scale.is_logarithmic) = (0.1, 1000.0, true);
            let logarithmic = draw_one(renderer, &mesh, &[&white], |f| {
                (f.shading, f.scale) = (Shading::FalseColor, scale);
            });
            assert_near(
                logarithmic.color(32, 32),
                map.color(0.5),
                2,
                &format!("{map:?}"),
            );
        }
    });
}

#[test]
fn isolines_lie_where_bands_meet() {
    let mut mesh = square(1.0, 0.0, 0);
    mesh.irradiance = [0.0, 1.0, 1.0, 0.0].map(Rgb::grey).to_vec();
    let scale = ColorScale {
        bands: 4,
        ..ColorScale::default()
    };
    on_each_driver(|renderer| {
        let pixels = draw_one(renderer, &mesh, &[], |f| {
            (f.shading, f.scale) = (Shading::FalseColor, scale);
        });
        let t = |x: u32| (f64::from(x) + 0.5) / 64.0;
        let differs = |x: u32| {
            let plain = scale.map.color(t(x));
            let color = pixels.color(x, 20);
            color.iter().zip(plain).any(|(a, b)| a.abs_diff(b) > 30)
        };
        for x in [8, 24, 40, 56] {
            assert!(!differs(x), "{x} {:?}", pixels.color(x, 20));
        }
        for x in [16, 32, 48] {
            assert!(
                differs(x) || differs(x - 1),
                "{x} {:?}",
                pixels.color(x, 20)
            );
        }
    });
}

#[test]
fn hidden_lines_hide_and_lines_do_not() {
    let mut mesh = square(0.9, 0.5, 0);
    let behind = square(0.5, -0.5, 0);
    mesh.positions.extend(&behind.positions);
    mesh.uvs = None;
    mesh.push_face(&[4, 5, 6, 7], 0);
    let inked = |pixels: &PixelBuffer| {
        let middle = (16..48).flat_map(|y| (16..48).map(move |x| (x, y)));
        middle.filter(|&(x, y)| pixels.color(x, y)[0] > 60).count()
    };
    on_each_driver(|renderer| {
        let count = |renderer: &mut Renderer, shading| {
            inked(&draw_one(renderer, &mesh, &[], |f| f.shading = shading))
        };
        assert!(count(renderer, Shading::Lines) > 60);
        assert_eq!(count(renderer, Shading::HiddenLines), 0);
        // The four corners of the hidden square, three pixels wide.
        assert_eq!(count(renderer, Shading::Points), 4 * 9);
    });
}

#[test]
fn lines_are_seen_on_the_faces_that_they_bound() {
    on_each_driver(|renderer| {
        let pixels = draw_one(renderer, &sphere(), &[], |f| {
            f.shading = Shading::HiddenLines;
            f.size = [256, 256];
        });
        let bright = pixels.rgba.chunks(4).filter(|p| p[0] > 60).count();
        // About a thousand edges of ten pixels each are visible.
        assert!((5_000..25_000).contains(&bright), "{bright}");
    });
}

#[test]
fn far_from_the_origin_nothing_shakes() {
    let white = Material::diffuse("", Rgb::grey(0.8));
    let near = sphere();
    let mut far = near.clone();
    let materials = [&white];
    let offset = DVec3::new(4_321_000.25, -9_876_543.5, 1_234_567.75);
    far.positions.iter_mut().for_each(|p| *p += offset);
    on_each_driver(|renderer| {
        let here = draw_one(renderer, &near, &[&white], |_| {});
        let mut there = camera(4.0);
        (there.eye, there.target) = (there.eye + offset, there.target + offset);
        let drawn = [DrawnMesh::new(7, &far)];
        let mut frame = ViewportFrame::new(SIZE, &there, &drawn, &materials);
        frame.background = BLACK;
        assert_same(&draw(renderer, &frame), &here);
        // The same by the object's placement.
        let mut placed = DrawnMesh::new(8, &near);
        placed.world_from_object = DAffine3::from_translation(offset);
        let drawn = [placed];
        let mut frame = ViewportFrame::new(SIZE, &there, &drawn, &materials);
        frame.background = BLACK;
        assert_same(&draw(renderer, &frame), &here);
    });
}

/// Images that differ only by rounding.
fn assert_same(a: &PixelBuffer, b: &PixelBuffer) {
    let outliers = a
        .rgba
        .iter()
        .zip(&b.rgba)
        .filter(|(x, y)| x.abs_diff(**y) > 4);
    let count = outliers.count();
    assert!(count < 20, "{count} bytes differ");
}

#[test]
fn faces_show_numbers_of_their_own() {
    let mut mesh = square(0.5, 0.0, 0);
    mesh.uvs = None;
    mesh.positions = [
        (-1.0, -1.0),
        (0.0, -1.0),
        (1.0, -1.0),
        (1.0, 1.0),
        (0.0, 1.0),
        (-1.0, 1.0),
    ]
    .map(|(x, y)| DVec3::new(x, y, 0.0))
    .to_vec();
    mesh.faces = Default::default();
    mesh.face_materials.clear();
    mesh.push_face(&[0, 1, 4, 5], 0);
    mesh.push_face(&[1, 2, 3, 4], 1);
    let values = [0.25, 0.75];
    let camera = camera(4.0);
    on_each_driver(|renderer| {
        let mut drawn = DrawnMesh::new(3, &mesh);
        drawn.face_values = Some(FaceValues {
            key: 1,
            values: &values,
        });
        let drawn = [drawn];
        let mut frame = ViewportFrame::new(SIZE, &camera, &drawn, &[]);
        frame.shading = Shading::FormFactors;
        let pixels = draw(renderer, &frame);
        let map = frame.scale.map;
        assert_near(pixels.color(16, 30), map.color(0.25), 2, "left");
        assert_near(pixels.color(48, 30), map.color(0.75), 2, "right");
        // The irradiance of faces is the mean of their corners.
        let mut lit = mesh.clone();
        lit.irradiance = [0.0, 1.0, 3.0, 3.0, 1.0, 0.0].map(Rgb::grey).to_vec();
        let white = Material::diffuse("", Rgb::WHITE);
        let pixels = draw_one(renderer, &lit, &[&white, &white], |f| {
            (f.shading, f.tone) = (Shading::Patches, Tone::Linear);
        });
        for (x, mean) in [(16, 0.5), (48, 2.0)] {
            let expected = [byte(mean / std::f64::consts::PI); 3];
            assert_near(pixels.color(x, 30), expected, 2, "patch");
        }
    });
}

#[test]
fn nothing_is_seen_through_numbers() {
    let glass = Material::dielectric("", 1.5);
    let mut mesh = square(0.9, 0.0, 0);
    mesh.irradiance = vec![Rgb::grey(1.0); 4];
    on_each_driver(|renderer| {
        for shading in [Shading::FalseColor, Shading::Patches, Shading::FormFactors] {
            let pixels = draw_one(renderer, &mesh, &[&glass], |f| f.shading = shading);
            let opacities = pixels.rgba.chunks_exact(4).map(|p| p[3]);
            assert!(opacities.into_iter().all(|a| a == 255), "{shading:?}");
        }
    });
}

#[test]
fn glass_behind_glass_looks_the_same_in_any_order() {
    let tinted = |r, b| {
        let mut glass = Material::dielectric("", 1.5);
        glass.emission = Rgb::new(r, 0.0, b);
        glass
    };
    let materials = [tinted(1.0, 0.0), tinted(0.0, 1.0)];
    let materials: Vec<&Material> = materials.iter().collect();
    let (near, far) = (square(0.9, 0.5, 0), square(0.9, -0.5, 1));
    let camera = camera(4.0);
    on_each_driver(|renderer| {
        let [near, far] = [DrawnMesh::new(1, &near), DrawnMesh::new(2, &far)];
        let mut drawn = |objects: [DrawnMesh; 2]| {
            let frame = ViewportFrame::new(SIZE, &camera, &objects, &materials);
            draw(renderer, &frame).color(32, 32)
        };
        let shown = drawn([near, far]);
        assert_eq!(shown, drawn([far, near]));
        // The nearer one, which is red, covers some of the farther one.
        assert!(shown[0] > shown[2] && shown[2] > 60, "{shown:?}");
    });
}

#[test]
fn a_section_cuts_what_is_drawn_and_what_is_picked() {
    let white = Material::diffuse("", Rgb::WHITE);
    let (near, far) = (square(0.9, 0.5, 0), square(0.9, -0.5, 0));
    let camera = camera(4.0);
    let objects = [DrawnMesh::new(1, &near), DrawnMesh::new(2, &far)];
    let section = Some((DVec3::Z, 0.0));
    let cut = Cutaway {
        hides_backs: false,
        section,
    };
    let ray = azulejo::scene::math::Ray::new(DVec3::new(0.1, 0.1, 4.0), DVec3::NEG_Z);
    assert_eq!(
        Cutaway::default().pick(&objects, &ray).map(|h| h.object),
        Some(0)
    );
    let hit = cut.pick(&objects, &ray).expect("the far one");
    assert_eq!((hit.object, hit.distance), (1, 4.5));
    // From behind, what is nearer is kept, and beyond the plane there is nothing.
    let away = azulejo::scene::math::Ray::new(DVec3::new(0.1, 0.1, -0.2), DVec3::Z);
    assert!(cut.pick(&objects, &away).is_none());
    on_each_driver(|renderer| {
        let mut drawn = |objects: &[DrawnMesh], section| {
            let materials = [&white];
            let frame = ViewportFrame::new(SIZE, &camera, objects, &materials);
            draw(renderer, &ViewportFrame { section, ..frame })
        };
        let image = drawn(&objects, section);
        let alone = drawn(&objects[1..], None);
        let differ = image
            .rgba
            .iter()
            .zip(&alone.rgba)
            .filter(|(a, b)| a.abs_diff(**b) > 2);
        assert!(differ.count() < 40, "the near square is cut away");
    });
}

#[test]
fn fog_takes_its_share_at_a_distance() {
    let white = Material::diffuse("", Rgb::WHITE);
    let mut mesh = square(0.9, 0.0, 0);
    mesh.irradiance = vec![Rgb::grey(std::f64::consts::PI * 0.5); 4];
    on_each_driver(|renderer| {
        for exponential in [true, false] {
            let fog = Fog {
                color: Rgb::new(0.0, 0.0, 0.6),
                visibility: 10.0,
                exponential,
            };
            let pixels = draw_one(renderer, &mesh, &[&white], |f| {
                (f.shading, f.tone, f.fog) = (Shading::Irradiance, Tone::Linear, Some(fog));
            });
            let through = fog.transmittance(4.0);
            let expected = through * Rgb::grey(0.5) + (1.0 - through) * fog.color;
            let expected = expected.to_array().map(byte);
            assert_near(pixels.color(32, 32), expected, 2, "fog");
        }
    });
}

/// Red above blue, with more green in the right half.
fn flag() -> Image {
    Image {
        width: 2,
        height: 2,
        pixels: vec![
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 1.0, 1.0],
        ],
        alpha: None,
    }
}

#[test]
fn textures_stand_upright() {
    let mut paper = Material::emitter("", Rgb::BLACK);
    (paper.diffuse, paper.textures) = (Rgb::WHITE, vec![0]);
    let flag = flag();
    let textures = [TextureSource {
        key: 5,
        image: Some(&flag),
    }];
    let camera = camera(4.0);
    let mesh = square(0.8, 0.0, 0);
    on_each_driver(|renderer| {
        let drawn = [DrawnMesh::new(1, &mesh)];
        let materials = [&paper];
        let mut frame = ViewportFrame::new(SIZE, &camera, &drawn, &materials);
        (frame.shading, frame.textures) = (Shading::Textured, &textures);
        let pixels = draw(renderer, &frame);
        let bright = |x, y| pixels.color(x, y).map(|c| c > 128);
        assert_eq!(bright(20, 20), [true, false, false]);
        assert_eq!(bright(44, 20), [true, true, false]);
        assert_eq!(bright(20, 44), [false, false, true]);
        assert_eq!(bright(44, 44), [false, true, true]);
    });
}

#[test]
fn backgrounds_fill_the_picture_as_told() {
    let flag = flag();
    let picture = TextureSource {
        key: 9,
        image: Some(&flag),
    };
    let image = |fit| Background::Image {
        picture,
        fit,
        gain: 1.0,
        around: [9, 99, 9],
    };
    let camera = camera(4.0);
    on_each_driver(|renderer| {
        let mut at = |background, x, y| {
            let mut frame = ViewportFrame::new(SIZE, &camera, &[], &[]);
            frame.background = background;
            draw(renderer, &frame).color(x, y)
        };
        assert_eq!(at(Background::Color([1, 2, 3]), 5, 60), [1, 2, 3]);
        let gradient = Background::Gradient {
            lower: [0; 3],
            upper: [200; 3],
        };
        assert_near(at(gradient, 3, 15), [152; 3], 2, "gradient");
        assert_near(
            at(image(BackplateFit::Scaled), 16, 16),
            [255, 0, 0],
            40,
            "scaled",
        );
        assert_near(
            at(image(BackplateFit::Scaled), 48, 48),
            [0, 255, 255],
            40,
            "scaled",
        );
        assert_near(
            at(image(BackplateFit::Centered), 3, 3),
            [9, 99, 9],
            1,
            "centred",
        );
        assert_near(
            at(image(BackplateFit::Centered), 31, 31),
            [255, 0, 0],
            2,
            "centred",
        );
        assert_near(
            at(image(BackplateFit::Tiled), 0, 0),
            [255, 0, 0],
            2,
            "tiled",
        );
        assert_near(
            at(image(BackplateFit::Tiled), 2, 3),
            [0, 0, 255],
            2,
            "tiled",
        );
    });
}

#[test]
fn marks_lie_on_top_or_behind() {
    let white = Material::diffuse("", Rgb::WHITE);
    let mesh = square(0.9, 0.0, 0);
    let mut overlay = Overlay::default();
    let ink = OverlayStyle::new([255, 0, 0], 6.0);
    let (left, right) = (DVec3::new(-0.8, 0.0, -0.5), DVec3::new(0.8, 0.0, -0.5));
    overlay.line(left, right, ink);
    let (up, down) = (DVec3::new(0.0, 0.8, -0.5), DVec3::new(0.0, -0.8, -0.5));
    overlay.line(up, down, OverlayStyle::new([0, 0, 255], 6.0).on_top());
    // From behind the camera to behind the square: clipped, not mirrored.
    overlay.line(DVec3::new(0.0, 0.5, 9.0), DVec3::new(0.0, 0.5, 0.1), ink);
    on_each_driver(|renderer| {
        let drawn = [DrawnMesh::new(1, &mesh)];
        let (camera, materials) = (camera(4.0), [&white]);
        let mut frame = ViewportFrame::new(SIZE, &camera, &drawn, &materials);
        frame.overlay = &overlay;
        let pixels = draw(renderer, &frame);
        assert_eq!(pixels.color(32, 40), [0, 0, 255]);
        let [r, g, b] = pixels.color(14, 31);
        assert!(r == g && g == b && r > 100, "hidden: {r} {g} {b}");
        assert_eq!(pixels.color(31, 4), [255, 0, 0], "toward the eye");
    });
}

#[test]
fn backs_are_red_or_left_out_also_in_a_mirror() {
    let mesh = square(0.9, 0.0, 0);
    let camera = camera(4.0);
    let flip = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let turn = DAffine3::from_rotation_y(std::f64::consts::PI);
    on_each_driver(|renderer| {
        let mut shows = |place: DAffine3, hides_backs: bool| {
            let mut drawn = DrawnMesh::new(1, &mesh);
            drawn.world_from_object = place;
            let drawn = [drawn];
            let mut frame = ViewportFrame::new(SIZE, &camera, &drawn, &[]);
            (frame.shading, frame.background) = (Shading::Normals, BLACK);
            frame.hides_backs = hides_backs;
            let pixels = draw(renderer, &frame);
            pixels.color(32, 32)
        };
        assert_near(shows(DAffine3::IDENTITY, true), [128, 128, 255], 2, "front");
        assert_near(shows(turn, true), [0; 3], 0, "turned away");
        let [r, g, _] = shows(turn, false);
        assert!(r > 150 && g < 50, "red");
        // The front of a mirrored object is where its normals point: away from the camera here.
        assert_near(shows(flip, true), [0; 3], 0, "mirrored");
        assert_near(
            shows(flip * turn, true),
            [128, 128, 255],
            2,
            "mirrored and turned",
        );
    });
}

#[test]
fn what_is_selected_has_a_line_around_it_and_keeps_its_colour() {
    let white = Material::diffuse("", Rgb::WHITE);
    let mesh = sphere();
    let camera = camera(4.0);
    on_each_driver(|renderer| {
        let mut drawn = |selected: bool, faces: &[u32]| {
            let mut drawn = DrawnMesh::new(1, &mesh);
            (drawn.is_selected, drawn.selected_faces) = (selected, faces);
            let drawn = [drawn];
            draw(
                renderer,
                &ViewportFrame::new(SIZE, &camera, &drawn, &[&white]),
            )
        };
        let faces: Vec<u32> = (0..mesh.faces.len() as u32).collect();
        let plain = drawn(false, &[]);
        let orange = |pixels: &PixelBuffer| {
            let pixels = pixels.rgba.chunks_exact(4);
            pixels.filter(|p| p[0] > 240 && p[2] < 40).count()
        };
        assert_eq!(orange(&plain), 0);
        for marked in [drawn(true, &[]), drawn(false, &faces)] {
            assert_eq!(marked.color(33, 33), plain.color(33, 33));
            let count = orange(&marked);
            // Two pixels wide around a ball.
            assert!((150..500).contains(&count), "{count}");
        }
        // Indices of missing faces are ignored.
        assert_eq!(orange(&drawn(false, &[u32::MAX])), 0);
    });
}

#[test]
fn both_drivers_draw_the_same() {
    let white = Material::diffuse("", Rgb::new(0.9, 0.6, 0.3));
    let textures = Mutex::new(Vec::new());
    on_each_driver(|renderer| {
        let pixels = draw_one(renderer, &sphere(), &[&white], |_| {});
        textures.lock().expect("one thread").push(pixels);
    });
    if let [vulkan, gl] = &textures.into_inner().expect("one thread")[..] {
        let differ = vulkan
            .rgba
            .iter()
            .zip(&gl.rgba)
            .filter(|(a, b)| a.abs_diff(**b) > 3);
        let count = differ.count();
        assert!(count < 40, "{count} bytes differ");
    }
}

#[test]
fn only_what_changed_is_brought_again() {
    let mut mesh = sphere();
    mesh.irradiance = vec![Rgb::WHITE; mesh.positions.len()];
    let camera = camera(4.0);
    on_each_driver(|renderer| {
        let mut bytes = |shading, key, light_key| {
            let mut drawn = DrawnMesh::new(key, &mesh);
            drawn.light_key = light_key;
            let drawn = [drawn];
            let mut frame = ViewportFrame::new(SIZE, &camera, &drawn, &[]);
            frame.shading = shading;
            renderer.draw(&frame).expect("an image");
            renderer.statistics().bytes_loaded
        };
        // At the poles the grid has a vertex that no face uses.
        let vertices = mesh.positions.len() as u64 - 2;
        let triangles = mesh.faces.triangle_count() as u64;
        let total_bytes = bytes(Shading::Gouraud, 1, 1);
        assert_eq!(total_bytes, 16 * vertices + 12 * triangles);
        assert_eq!(bytes(Shading::Gouraud, 1, 1), 0);
        assert_eq!(bytes(Shading::Irradiance, 1, 1), 8 * vertices);
        assert_eq!(bytes(Shading::Irradiance, 1, 2), 8 * vertices);
        assert_eq!(bytes(Shading::Irradiance, 2, 2), total_bytes + 8 * vertices);
    });
}

#[test]
fn errors_say_what_to_do_and_are_no_end() {
    let camera = camera(4.0);
    on_each_driver(|renderer| {
        let too_large = ViewportFrame::new([1 << 20, 10], &camera, &[], &[]);
        let error = renderer.draw(&too_large).expect_err("too large");
        assert!(
            error
                .to_string()
                .contains("1048576 x 10 pixels is too large"),
            "{error}"
        );
        let fine = ViewportFrame::new([0, 0], &camera, &[], &[]);
        renderer.draw(&fine).expect("one pixel");
        assert_eq!(renderer.read().map(|p| p.rgba.len()), Ok(4));
    });
    let missing = GpuError::Missing { found: Vec::new() };
    assert!(missing.to_string().contains("mesa-vulkan-drivers"));
}

#[test]
fn a_lost_device_is_an_error() {
    let camera = camera(4.0);
    on_each_driver(|renderer| {
        renderer.destroy();
        let frame = ViewportFrame::new(SIZE, &camera, &[], &[]);
        let error = (0..3).find_map(|_| renderer.draw(&frame).err());
        assert!(matches!(error, Some(GpuError::Lost { .. })), "{error:?}");
    });
}
