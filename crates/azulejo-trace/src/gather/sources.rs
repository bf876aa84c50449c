//! Which lights, and which mirror images of them, the direct light is computed from.

use super::light_clusters::LightClusters;
use crate::Surfaces;
use crate::follow::Via;
use crate::lambert::{ArrayPolygon, mirror_polygon};
use crate::lights::{CurvedEmitter, FlatEmitter, FlatFace, Lights, Tile, flat_faces, merged};
use azulejo_scene::{Material, Rgb};
use glam::DVec3;

/// More lamps than this are left to the rays of the hemisphere: their formulas would cost more.
const MOST_LAMPS: usize = 1024;

/// More pairs of a lamp and a mirror than this are left to the rays.
const MOST_IMAGES: usize = 256;

/// The number of mirrors from which no windows are made.
const MOST_TILES: usize = 4096;

/// How an emitter is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmitterForm {
    /// A flat polygon that emits evenly.
    Flat,
    /// A curved surface that emits evenly.
    Curved,
    /// A surface that emits a picture.
    Pictured,
}

/// A flat convex mirror, and the lamps as it shows them.
pub struct Window {
    /// Corners of the mirror.
    pub polygon: ArrayPolygon,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// Reflectance.
    pub reflectance: Rgb,
    /// Mirror image of each flat emitter, in their order.
    pub images: Vec<ArrayPolygon>,
}

/// The sources of direct light: the light that formulas and shadow rays find, so that paths which
/// find it by chance must not count it.
pub struct DirectSources {
    has_flat: bool,
    has_curved: bool,
    /// Flat mirrors in which lamps and lights are seen.
    pub windows: Vec<Window>,
    /// Per item: whether it belongs to a window.
    is_window: Vec<bool>,
    count: usize,
    /// The flat emitters in groups if they are many, and the lights without area if those are.
    pub(super) clusters: Option<LightClusters>,
}

impl DirectSources {
    /// Decides what of the lights of a scene is direct light, and finds their mirror images.
    pub fn new(surfaces: &Surfaces, lights: &Lights) -> DirectSources {
        let sides: usize = lights.flat().iter().map(FlatEmitter::sides).sum();
        let has_flat = (1..=MOST_LAMPS).contains(&sides);
        let has_curved = (1..=MOST_LAMPS).contains(&lights.curved.len());
        let mut sources = DirectSources {
            has_flat,
            has_curved,
            windows: Vec::new(),
            is_window: vec![false; surfaces.tracer.item_count() as usize],
            count: 0,
            clusters: None,
        };
        let points = lights.delta.len() + lights.outside.suns.len();
        let flat = if has_flat { sides } else { 0 } + points;
        sources.collect_windows(surfaces, lights, flat);
        sources.clusters = LightClusters::new(sources.flat(lights), &lights.delta);
        let curved = sources.curved(lights).len();
        sources.count = flat * (1 + sources.windows.len()) + curved;
        sources
    }

    /// The flat emitters among the sources: all or none.
    pub fn flat<'l>(&self, lights: &'l Lights) -> &'l [FlatEmitter] {
        if self.has_flat { lights.flat() } else { &[] }
    }

    /// The curved emitters among the sources: all or none.
    pub fn curved<'l, 'a>(&self, lights: &'l Lights<'a>) -> &'l [CurvedEmitter<'a>] {
        if self.has_curved { &lights.curved } else { &[] }
    }

    /// Whether one flat emitter that sends light to one side is all that formulas and shadow rays find, apart from
    /// pictures and environments.
    pub fn is_lone_lamp(&self, lights: &Lights) -> bool {
        self.count == 1 && self.flat(lights).len() == 1
    }

    /// Whether the direct light counts what emitters of that form send `via` this way.
    pub fn counts_direct(&self, form: EmitterForm, via: Via) -> bool {
        let is_flat = form == EmitterForm::Flat;
        match via {
            Via::Direct => match form {
                EmitterForm::Flat => self.has_flat,
                EmitterForm::Curved => self.has_curved,
                EmitterForm::Pictured => true,
            },
            Via::Mirror(mirror) => is_flat && self.has_flat && self.is_window[mirror as usize],
            Via::Many => false,
        }
    }

    /// The groups of lights, if lights without area are so many that even to list them costs more than rays.
    pub(super) fn groups_alone(&self, lights: &Lights) -> Option<&LightClusters> {
        let clusters = self.clusters.as_ref();
        clusters.filter(|_| lights.delta.len() > MOST_LAMPS)
    }

    /// Number of lamps, lights, and images of both.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Makes windows of the mirrors, unless they would show too many images of `sources` lamps
    /// and lights.
    fn collect_windows(&mut self, surfaces: &Surfaces, lights: &Lights, sources: usize) {
        // An image has one brightness, so that only mirrors of one reflectance make windows.
        let is_mirror =
            |m: &Material| !m.mirror.is_black() && m.dielectric.is_none() && !m.mirror_varies();
        let most = MOST_IMAGES.checked_div(sources).unwrap_or(0);
        if most == 0 {
            return;
        }
        let mut tiles = Vec::new();
        flat_faces(surfaces.scene, is_mirror, |face| {
            if tiles.len() < MOST_TILES {
                tiles.push(tile(face));
            }
        });
        if tiles.len() == MOST_TILES {
            return;
        }
        let windows = merged(tiles);
        if windows.len() <= most {
            let flat = self.flat(lights);
            self.windows = windows.into_iter().map(|w| window(w.tile, flat)).collect();
            let is_marked =
                |i| surfaces.flat_normal(i).is_some() && is_mirror(surfaces.material(i));
            self.is_window = (0..surfaces.tracer.item_count()).map(is_marked).collect();
        }
    }
}

fn tile(face: FlatFace) -> Tile<Rgb> {
    Tile {
        polygon: face.polygon,
        normal: face.normal,
        property: face.material.mirror,
    }
}

fn window(tile: Tile<Rgb>, lamps: &[FlatEmitter]) -> Window {
    let image = |lamp: &FlatEmitter| mirror_polygon(&lamp.polygon, tile.polygon[0], tile.normal);
    Window {
        images: lamps.iter().map(image).collect(),
        polygon: tile.polygon,
        normal: tile.normal,
        reflectance: tile.property,
    }
}
