//! Automatic exposure of views with a background.

use crate::film::Lens;
use crate::tone::auto_exposure;
use azulejo_scene::{Camera, Image, Scene};
use azulejo_trace::{KernelRay, Tracer};
use rayon::prelude::*;

/// Share of the pixels that surfaces must show for the exposure to be theirs.
const LEAST_SHARE: f64 = 0.02;

/// An exposure as by [`auto_exposure`], of what the camera sees of surfaces alone: beside a bright sky a
/// model would be black, and before a dark one overexposed. Where hardly any surface is in view, or there is no
/// background, it is that of the whole image.
///
/// `image` is the view of `camera`; `tracer` must have been made from `scene`.
pub fn auto_exposure_of_surfaces(
    image: &Image,
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
) -> f64 {
    let has_background = scene.background.is_some() || scene.environments().next().is_some();
    if !has_background || image.pixels.is_empty() {
        return auto_exposure(image);
    }
    let pixels = surface_pixels(image, tracer, camera);
    if (pixels.len() as f64) < LEAST_SHARE * image.pixels.len() as f64 {
        return auto_exposure(image);
    }
    auto_exposure(&Image::opaque(pixels.len() as u32, 1, pixels))
}

/// The share, 0..=1, of the pixels with a surface at their centre that are black; `None` if no pixel has one.
pub fn black_share_of_surfaces(image: &Image, tracer: &Tracer, camera: &Camera) -> Option<f64> {
    let pixels = surface_pixels(image, tracer, camera);
    let black = pixels
        .iter()
        .filter(|pixel| pixel.iter().all(|&value| value <= 0.0));
    let share = black.count() as f64 / pixels.len() as f64;
    (!pixels.is_empty()).then_some(share)
}

/// The pixels at whose centre `camera` sees a surface, row by row.
fn surface_pixels(image: &Image, tracer: &Tracer, camera: &Camera) -> Vec<[f32; 3]> {
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    let lens = Lens::new(camera, width / height);
    let row = |y: usize| {
        let middle = |x: u32| {
            let place = (f64::from(x) + 0.5, y as f64 + 0.5);
            tracer.kernel_ray(&lens.ray((place.0 / width, place.1 / height)))
        };
        let rays: Vec<KernelRay> = (0..image.width).map(middle).collect();
        let mut hits = Vec::new();
        tracer.closest(&rays, &mut hits);
        let row = &image.pixels[y * image.width as usize..][..image.width as usize];
        let seen = row.iter().zip(&hits).filter(|(_, hit)| hit.is_hit());
        seen.map(|(pixel, _)| *pixel).collect::<Vec<_>>()
    };
    let rows: Vec<Vec<[f32; 3]>> = (0..image.height as usize)
        .into_par_iter()
        .map(row)
        .collect();
    rows.concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Material, Object, Primitive, Rgb, SceneBackground, Shape};
    use glam::DVec3;

    /// A sphere in the middle, a quarter of the width, of luminance 1 before a background.
    #[test]
    fn a_background_does_not_change_the_exposure_of_surfaces() {
        let mut scene = Scene::default();
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        let ball = Primitive::sphere(DVec3::ZERO, 1.0, grey);
        scene
            .objects
            .push(Object::new("ball", Shape::Primitive(ball)));
        let tracer = Tracer::new(&scene);
        let camera = Camera {
            name: String::new(),
            eye: DVec3::new(0.0, 0.0, 8.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: 1.0,
            size: None,
        };
        let lens = Lens::new(&camera, 1.0);
        let view = |beyond: f32| {
            let pixel = |k: u32| {
                let place = [k % 64, k / 64].map(|i| (f64::from(i) + 0.5) / 64.0);
                let is_ball = tracer.hit(&lens.ray((place[0], place[1]))).is_some();
                [if is_ball { 1.0 } else { beyond }; 3]
            };
            Image::opaque(64, 64, (0..64 * 64).map(pixel).collect())
        };
        let alone = auto_exposure(&view(0.0));
        assert_ne!(auto_exposure(&view(50.0)), alone);
        for beyond in [0.0, 0.01, 50.0] {
            scene.background = Some(SceneBackground::Color(Rgb::grey(f64::from(beyond))));
            let image = view(beyond);
            let exposure = auto_exposure_of_surfaces(&image, &scene, &tracer, &camera);
            assert!(
                (exposure / alone - 1.0).abs() < 1e-9,
                "{exposure} of {alone}"
            );
        }
        // Looking away from it, there is only the background.
        let away = Camera {
            target: DVec3::new(0.0, 0.0, 20.0),
            ..camera
        };
        let image = view(50.0);
        let exposure = auto_exposure_of_surfaces(&image, &scene, &tracer, &away);
        assert_eq!(exposure, auto_exposure(&image));
    }
}
