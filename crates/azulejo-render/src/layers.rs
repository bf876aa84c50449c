//! What the camera sees at each pixel beside light: for compositors, and for the filter.

use crate::film::{Film, Lens, Tile};
use crate::render_scene::RenderScene;
use azulejo_scene::{Camera, Image, Rgb, Scene, Shape};
use azulejo_trace::medium::Leg;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, KernelHit, KernelRay, Progress, Tracer};
use glam::DVec3;
use rayon::prelude::*;

/// Depth where a pixel sees no surface: what compositors take as far away.
pub const NO_DEPTH: f32 = 1e10;

/// Camera rays of a pixel: for the mean of what is antialiased.
const MOST_SAMPLES: u32 = 64;

/// The surfaces that the camera sees first, pixel by pixel; mirrors and glass count as surfaces.
///
/// Albedo and normal are means over the pixel by the image's own filter. Depth and indices belong to
/// the ray through the middle of the pixel: a mean of two of them would be a third surface.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureLayers {
    /// Mean reflectance, diffuse, glossy and mirrored together, 0..=1; white for glass, black where
    /// there is no surface.
    pub albedo: Image,
    /// Standard error of the albedo, which edges and textures within a pixel cause.
    pub albedo_error: Image,
    /// Shading normal in world coordinates, on the side that is seen; shorter than 1 where a pixel
    /// sees several, zero where it sees none.
    pub normal: Image,
    /// Standard error of the normal's coordinates.
    pub normal_error: Image,
    /// Distance from the plane through the eye, along the camera's viewing direction, scene units;
    /// [`NO_DEPTH`] without a surface.
    pub depth: Vec<f32>,
    /// Number of the object, from 1; 0 without a surface.
    pub object: Vec<u32>,
    /// Number of the material, from 1; 0 without a surface.
    pub material: Vec<u32>,
    /// Number of the leaf of an exact shape, from 1: in a text, of the letter. 0 for all else.
    pub glyph: Vec<u32>,
}

/// Finds the layers of a picture of `width × height` pixels; `samples` is the number of camera rays
/// per pixel, of which 64 at most are used.
///
/// `tracer` must have been made from `scene`. Counts pixels on `progress`. The result depends on
/// neither irradiance nor threads.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
///
/// # Panics
/// If the picture has 2³² pixels or more.
pub fn picture_layers(
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    (width, height): (u32, u32),
    samples: u32,
    progress: &Progress,
) -> Result<PictureLayers, Cancelled> {
    let film = Film::new((width, height), hash(&[0x1a7e5]));
    let finder = LayerFinder {
        scene: RenderScene::new(scene, tracer),
        lens: Lens::new(camera, f64::from(width) / f64::from(height)),
        eye: camera.eye,
        forward: camera.axes().2,
        samples: samples.clamp(1, MOST_SAMPLES),
        film,
    };
    progress.begin("layers", u64::from(width) * u64::from(height));
    let tile = |hits: &mut Vec<KernelHit>, tile: Tile| {
        let pixels: Vec<u32> = tile.pixels(width).collect();
        let layer_pixels = pixels.iter().map(|&p| finder.pixel(p, hits)).collect();
        progress.advance(pixels.len() as u64)?;
        Ok(layer_pixels)
    };
    let tiles = film.tiles().into_par_iter();
    let parts: Result<Vec<Vec<LayerPixel>>, Cancelled> = tiles.map_init(Vec::new, tile).collect();
    Ok(assemble(&film, &parts?))
}

/// Looks at the surfaces of one scene.
struct LayerFinder<'a> {
    scene: RenderScene<'a>,
    lens: Lens,
    eye: DVec3,
    forward: DVec3,
    samples: u32,
    film: Film,
}

/// Means and standard errors over a pixel, and what is in its middle.
struct LayerPixel {
    albedo: [Rgb; 2],
    normal: [Rgb; 2],
    depth: f32,
    ids: [u32; 3],
}

/// Sums of a value and of its square.
#[derive(Default)]
struct LayerSpread([Rgb; 2]);

impl LayerSpread {
    fn add(&mut self, value: Rgb) {
        self.0[0] += value;
        self.0[1] += value * value;
    }

    /// The mean of `n` values and its standard error.
    fn mean(&self, n: u32) -> [Rgb; 2] {
        let n = f64::from(n);
        let mean = self.0[0] / n;
        let variance = (self.0[1] / n - mean * mean) / (n - 1.0).max(1.0);
        [mean, variance.map(|v| v.max(0.0).sqrt())]
    }
}

impl LayerFinder<'_> {
    fn pixel(&self, index: u32, hits: &mut Vec<KernelHit>) -> LayerPixel {
        let tracer = self.scene.tracer();
        let pixel = self.film.pixel(index);
        let ray = |at| tracer.kernel_ray(&self.lens.ray(at));
        let middle = ray(pixel.middle());
        let all = (0..self.samples).map(|sample| ray(pixel.position(sample)));
        let rays: Vec<KernelRay> = all.chain([middle]).collect();
        tracer.closest(&rays, hits);
        for (ray, hit) in rays.iter().zip(hits.iter_mut()) {
            *hit = Leg::from(*ray).hit(self.scene.surfaces(), hit).0;
        }
        let (mut albedo, mut normal) = (LayerSpread::default(), LayerSpread::default());
        for (ray, hit) in rays.iter().zip(hits.iter()).take(self.samples as usize) {
            let [reflectance, direction] = self.surface(ray, hit);
            albedo.add(reflectance);
            normal.add(direction);
        }
        let (depth, ids) = self.middle(&middle, &hits[self.samples as usize]);
        LayerPixel {
            albedo: albedo.mean(self.samples),
            normal: normal.mean(self.samples),
            depth,
            ids,
        }
    }

    /// Albedo and normal at a hit; black without.
    fn surface(&self, ray: &KernelRay, hit: &KernelHit) -> [Rgb; 2] {
        if !hit.is_hit() {
            return [Rgb::BLACK; 2];
        }
        let material = self.scene.surfaces().material(hit.item);
        let normal = self.scene.interaction(ray, hit).shading_normal;
        let albedo = if material.dielectric.is_some() {
            Rgb::WHITE
        } else {
            self.scene.interpolator.reflectance(hit, material) + material.mirror
        };
        [albedo.map(|x| x.min(1.0)), Rgb::from(normal.to_array())]
    }

    /// Depth, and the numbers of object, material and leaf.
    fn middle(&self, ray: &KernelRay, hit: &KernelHit) -> (f32, [u32; 3]) {
        if !hit.is_hit() {
            return (NO_DEPTH, [0; 3]);
        }
        let (surfaces, tracer) = (self.scene.surfaces(), self.scene.tracer());
        let item = surfaces.item(hit.item);
        let at = tracer.resolve(&tracer.world_ray(ray), hit).position;
        let shape = &surfaces.scene.objects[item.object as usize].shape;
        let is_exact = matches!(shape, Shape::Exact(_));
        let leaf = if is_exact { item.face + 1 } else { 0 };
        let depth = (at - self.eye).dot(self.forward) as f32;
        let material = surfaces.material_id(hit.item) + 1;
        (depth, [item.object + 1, material, leaf])
    }
}

fn assemble(film: &Film, parts: &[Vec<LayerPixel>]) -> PictureLayers {
    let image = |of: &dyn Fn(&LayerPixel) -> Rgb| {
        let values = |part: &Vec<LayerPixel>| part.iter().map(|p| of(p).to_f32()).collect();
        let parts: Vec<Vec<[f32; 3]>> = parts.iter().map(values).collect();
        film.assemble(&parts)
    };
    let count = film.width as usize * film.height as usize;
    let mut layers = PictureLayers {
        albedo: image(&|p| p.albedo[0]),
        albedo_error: image(&|p| p.albedo[1]),
        normal: image(&|p| p.normal[0]),
        normal_error: image(&|p| p.normal[1]),
        depth: vec![NO_DEPTH; count],
        object: vec![0; count],
        material: vec![0; count],
        glyph: vec![0; count],
    };
    for (tile, part) in film.tiles().iter().zip(parts) {
        for (pixel, layer) in tile.pixels(film.width).zip(part) {
            let k = pixel as usize;
            layers.depth[k] = layer.depth;
            [layers.object[k], layers.material[k], layers.glyph[k]] = layer.ids;
        }
    }
    layers
}
