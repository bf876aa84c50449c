//! What covers each pixel, by name: for mattes in compositors.

use crate::film::{Film, Lens, Tile};
use azulejo_scene::{Camera, Exact, Scene, Shape, Solid};
use azulejo_trace::medium::Leg;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, KernelHit, KernelRay, Progress, Surfaces, Tracer};
use rayon::prelude::*;
use std::collections::HashMap;

/// Most names that a pixel keeps.
const RANKS: usize = 6;

/// Camera rays of a pixel, so that coverage is neither coarse nor takes as long as the picture.
const LEAST_SAMPLES: u32 = 16;
const MOST_SAMPLES: u32 = 64;

/// Names, and what of them covers each pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Matte {
    /// All names, each once.
    pub names: Vec<String>,
    /// For each pixel the indices of at most six names with their coverage, 0..=1, the largest first; what is left has
    /// coverage 0. The sum is 1, less where the pixel sees the background or more names.
    pub ranks: Vec<[(u32, f32); RANKS]>,
}

/// What covers the pixels of a picture, in three ways.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mattes {
    /// Objects, where those of several solids are taken apart: the letters of a text are `text/1` and so on.
    pub objects: Matte,
    /// Whole objects.
    pub assets: Matte,
    /// Materials.
    pub materials: Matte,
}

/// Finds the mattes of a picture of `width × height` pixels, by the image's own filter; `samples` is the number of
/// camera rays per pixel, of which 16 at least and 64 at most are used.
///
/// The surfaces that the camera sees first; mirrors and glass count as surfaces. `tracer` must have been made from
/// `scene`. Counts pixels on `progress`. The result depends on neither irradiance nor threads.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
///
/// # Panics
/// If the picture has 2³² pixels or more.
pub fn mattes(
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    (width, height): (u32, u32),
    samples: u32,
    progress: &Progress,
) -> Result<Mattes, Cancelled> {
    let film = Film::new((width, height), hash(&[0x3a77e]));
    let finder = MatteFinder {
        surfaces: Surfaces::new(scene, tracer),
        tracer,
        lens: Lens::new(camera, f64::from(width) / f64::from(height)),
        film,
        samples: samples.clamp(LEAST_SAMPLES, MOST_SAMPLES),
        names: SceneNames::new(scene),
    };
    progress.begin("mattes", u64::from(width) * u64::from(height));
    let tile = |scratch: &mut MatteScratch, tile: Tile| {
        let pixels: Vec<u32> = tile.pixels(width).collect();
        let ranks = pixels.iter().map(|&p| finder.pixel(p, scratch)).collect();
        progress.advance(pixels.len() as u64)?;
        Ok(ranks)
    };
    let tiles = film.tiles().into_par_iter();
    let parts: Result<Vec<Vec<PixelRanks>>, Cancelled> =
        tiles.map_init(MatteScratch::default, tile).collect();
    Ok(finder.assembled(&parts?))
}

/// Ranks of one pixel: of objects, assets and materials.
type PixelRanks = [[(u32, f32); RANKS]; 3];

/// Working memory of one thread.
#[derive(Default)]
struct MatteScratch {
    rays: Vec<KernelRay>,
    hits: Vec<KernelHit>,
}

/// Names of all things, each once, and which belongs to what.
struct SceneNames {
    objects: NameList,
    assets: NameList,
    materials: NameList,
    /// Of each object: the name of the whole, and the name of each leaf, or one for all.
    of_object: Vec<(u32, Vec<u32>)>,
    of_material: Vec<u32>,
}

/// Names by their numbers.
#[derive(Default)]
struct NameList {
    names: Vec<String>,
    known: HashMap<String, u32>,
}

impl NameList {
    /// Things of one name are one.
    fn number(&mut self, name: String) -> u32 {
        let next = self.names.len() as u32;
        *self.known.entry(name).or_insert_with_key(|name| {
            self.names.push(name.clone());
            next
        })
    }
}

impl SceneNames {
    fn new(scene: &Scene) -> SceneNames {
        let (mut objects, mut assets, mut materials) = (
            NameList::default(),
            NameList::default(),
            NameList::default(),
        );
        let named = |name: &str, kind: &str, k: usize| match name {
            "" => format!("{kind} {}", k + 1),
            name => name.to_owned(),
        };
        let of_object = scene.objects.iter().enumerate().map(|(k, object)| {
            let name = named(&object.name, "object", k);
            let leaves = match &object.shape {
                Shape::Exact(exact) if exact.solids.len() > 1 => {
                    let part = |n: usize| objects.number(format!("{name}/{n}"));
                    let numbers: Vec<u32> = (1..=exact.solids.len()).map(part).collect();
                    solids_of_leaves(exact)
                        .map(|solid| numbers[solid])
                        .collect()
                }
                _ => vec![objects.number(name.clone())],
            };
            (assets.number(name), leaves)
        });
        let of_object = of_object.collect();
        let all = scene.materials.iter().enumerate();
        let of_material = all
            .map(|(k, m)| materials.number(named(&m.name, "material", k)))
            .collect();
        SceneNames {
            objects,
            assets,
            materials,
            of_object,
            of_material,
        }
    }
}

/// Which solid each leaf belongs to.
fn solids_of_leaves(exact: &Exact) -> impl Iterator<Item = usize> + '_ {
    let leaves = |(k, solid): (usize, &Solid)| std::iter::repeat_n(k, solid.leaves().len());
    exact.solids.iter().enumerate().flat_map(leaves)
}

/// Looks at the surfaces of one scene.
struct MatteFinder<'a> {
    surfaces: Surfaces<'a>,
    tracer: &'a Tracer,
    lens: Lens,
    film: Film,
    samples: u32,
    names: SceneNames,
}

impl MatteFinder<'_> {
    fn pixel(&self, index: u32, scratch: &mut MatteScratch) -> PixelRanks {
        let pixel = self.film.pixel(index);
        let ray = |sample| {
            self.tracer
                .kernel_ray(&self.lens.ray(pixel.position(sample)))
        };
        scratch.rays.clear();
        scratch.rays.extend((0..self.samples).map(ray));
        self.tracer.closest(&scratch.rays, &mut scratch.hits);
        let seen = scratch.rays.iter().zip(&scratch.hits);
        let seen: Vec<[u32; 3]> = seen.filter_map(|(ray, hit)| self.seen(ray, hit)).collect();
        [0, 1, 2].map(|kind| self.ranked(seen.iter().map(|numbers| numbers[kind])))
    }

    /// The numbers of object, asset and material that a ray sees.
    fn seen(&self, ray: &KernelRay, hit: &KernelHit) -> Option<[u32; 3]> {
        let (hit, _) = Leg::from(*ray).hit(&self.surfaces, hit);
        if !hit.is_hit() {
            return None;
        }
        let item = self.surfaces.item(hit.item);
        let (asset, leaves) = &self.names.of_object[item.object as usize];
        // Only objects of several solids have a name for each leaf.
        let object = match leaves.as_slice() {
            [one] => *one,
            many => many[item.face as usize],
        };
        let material = self.surfaces.material_id(hit.item) as usize;
        Some([object, *asset, self.names.of_material[material]])
    }

    /// The most frequent numbers, and their shares of all samples.
    fn ranked(&self, numbers: impl Iterator<Item = u32>) -> [(u32, f32); RANKS] {
        let mut counts: Vec<(u32, u32)> = Vec::new();
        for number in numbers {
            match counts.iter_mut().find(|(known, _)| *known == number) {
                Some((_, count)) => *count += 1,
                None => counts.push((number, 1)),
            }
        }
        counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut ranks = [(0, 0.0); RANKS];
        for (rank, (number, count)) in ranks.iter_mut().zip(counts) {
            *rank = (number, count as f32 / self.samples as f32);
        }
        ranks
    }

    fn assembled(self, parts: &[Vec<PixelRanks>]) -> Mattes {
        let width = self.film.width;
        let count = width as usize * self.film.height as usize;
        let mut all = [(); 3].map(|()| vec![[(0, 0.0); RANKS]; count]);
        for (tile, part) in self.film.tiles().iter().zip(parts) {
            for (pixel, ranks) in tile.pixels(width).zip(part) {
                for (kind, ranks) in all.iter_mut().zip(ranks) {
                    kind[pixel as usize] = *ranks;
                }
            }
        }
        let [objects, assets, materials] = all;
        let matte = |list: NameList, ranks| Matte {
            names: list.names,
            ranks,
        };
        Mattes {
            objects: matte(self.names.objects, objects),
            assets: matte(self.names.assets, assets),
            materials: matte(self.names.materials, materials),
        }
    }
}
