//! What shines in a scene, in the form in which direct light is computed from it.

use super::tiles::{Tile, merged};
use crate::Surfaces;
use crate::lambert::{ArrayPolygon, mirror_polygon};
use azulejo_scene::math::area_vector;
use azulejo_scene::{LightKind, Material, Mesh, Primitive, PrimitiveKind, Rgb, Shape};
use glam::DVec3;

use crate::follow::Via;

/// More lamps than this are left to the rays of the hemisphere: their formulas would cost more.
const MOST_LAMPS: usize = 1024;

/// More pairs of a lamp and a mirror than this are left to the rays.
const MOST_IMAGES: usize = 256;

/// Nobody tries to make windows of so many mirrors.
const MOST_TILES: usize = 4096;

/// A flat convex surface that emits from its front.
pub struct Lamp {
    /// Corners, counter-clockwise from the front.
    pub polygon: ArrayPolygon,
    /// Emitted radiance, W/(sr·m²).
    pub radiance: Rgb,
}

/// A curved part of a primitive that emits from its outside, and from its inside if `emits_back`.
pub struct Globe<'a> {
    /// The primitive.
    pub primitive: &'a Primitive,
    /// Which of its parts.
    pub part: usize,
    /// Emitted radiance, W/(sr·m²).
    pub radiance: Rgb,
    /// Whether the inside emits too.
    pub emits_back: bool,
    /// Its middle and the square of a radius around it, for rough estimates.
    pub centre: DVec3,
    /// See `centre`.
    pub radius2: f64,
}

/// A flat convex mirror, and the lamps as it shows them.
pub struct Window {
    /// Corners of the mirror.
    pub polygon: ArrayPolygon,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// Reflectance.
    pub reflectance: Rgb,
    /// Mirror image of each lamp, in the order of the lamps.
    pub images: Vec<ArrayPolygon>,
}

/// Everything whose direct light is computed by formula and shadow rays instead of being met by
/// chance.
pub struct Emitters<'a> {
    /// Flat lamps.
    pub lamps: Vec<Lamp>,
    /// Curved lamps.
    pub globes: Vec<Globe<'a>>,
    /// Flat mirrors in which lamps and lights are seen.
    pub windows: Vec<Window>,
    /// Point, spot and directional lights.
    pub lights: Vec<LightKind>,
    /// Radiance of the surroundings, from all [`LightKind::Ambient`] lights.
    pub ambient: Rgb,
    /// Per item: whether it belongs to a window.
    is_window: Vec<bool>,
}

impl<'a> Emitters<'a> {
    /// Collects the lamps, mirrors and lights of a scene.
    pub fn new(surfaces: &Surfaces<'a>) -> Emitters<'a> {
        let count = surfaces.tracer.item_count() as usize;
        let mut found = Emitters {
            lamps: Vec::new(),
            globes: Vec::new(),
            windows: Vec::new(),
            lights: Vec::new(),
            ambient: Rgb::BLACK,
            is_window: vec![false; count],
        };
        found.collect_lights(surfaces);
        found.collect_lamps(surfaces);
        found.collect_globes(surfaces);
        found.collect_windows(surfaces);
        found
    }

    /// Whether the direct light counts what emitters send `via` this way.
    pub fn counts_direct(&self, is_flat: bool, via: Via) -> bool {
        match via {
            Via::Direct if is_flat => !self.lamps.is_empty(),
            Via::Direct => !self.globes.is_empty(),
            Via::Mirror(mirror) => {
                is_flat && !self.lamps.is_empty() && self.is_window[mirror as usize]
            }
            Via::Many => false,
        }
    }

    /// Lamps, lights, and the images of both.
    pub fn sources(&self) -> usize {
        let flat = self.lamps.len() + self.lights.len();
        flat * (1 + self.windows.len()) + self.globes.len()
    }

    fn collect_lights(&mut self, surfaces: &Surfaces) {
        for light in &surfaces.scene.lights {
            match light.kind {
                LightKind::Ambient { radiance } => self.ambient += radiance,
                kind => self.lights.push(kind),
            }
        }
    }

    fn collect_lamps(&mut self, surfaces: &Surfaces) {
        let mut lamps = Vec::new();
        flat_faces(surfaces, Material::is_emitter, |polygon, _, material| {
            if lamps.len() <= MOST_LAMPS {
                let radiance = material.emission;
                if material.emits_back {
                    let mut back = ArrayPolygon::default();
                    polygon.iter().rev().for_each(|&corner| back.push(corner));
                    let polygon = back;
                    lamps.push(Lamp { polygon, radiance });
                }
                lamps.push(Lamp { polygon, radiance });
            }
        });
        if lamps.len() <= MOST_LAMPS {
            self.lamps = lamps;
        }
    }

    fn collect_globes(&mut self, surfaces: &Surfaces<'a>) {
        let mut globes = Vec::new();
        for object in &surfaces.scene.objects {
            let Shape::Primitive(primitive) = &object.shape else {
                continue;
            };
            let material = &surfaces.scene.materials[primitive.material as usize];
            let (radiance, emits_back) = (material.emission, material.emits_back);
            if radiance.is_black()
                || matches!(
                    primitive.kind,
                    PrimitiveKind::Cuboid | PrimitiveKind::Square
                )
            {
                continue;
            }
            let bounds = primitive.bounds();
            let (centre, radius2) = (bounds.centre(), (0.5 * bounds.diagonal()).powi(2) / 3.0);
            let parts = 0..primitive.kind.parts();
            globes.extend(parts.map(|part| Globe {
                primitive,
                part,
                radiance,
                emits_back,
                centre,
                radius2,
            }));
        }
        if globes.len() <= MOST_LAMPS {
            self.globes = globes;
        }
    }

    fn collect_windows(&mut self, surfaces: &Surfaces) {
        let is_mirror = |m: &Material| !m.mirror.is_black() && m.dielectric.is_none();
        let sources = self.lamps.len() + self.lights.len();
        let most = MOST_IMAGES.checked_div(sources).unwrap_or(0);
        if most == 0 {
            return;
        }
        let mut tiles = Vec::new();
        flat_faces(surfaces, is_mirror, |polygon, normal, material| {
            if tiles.len() < MOST_TILES {
                let reflectance = material.mirror;
                tiles.push(Tile {
                    polygon,
                    normal,
                    reflectance,
                });
            }
        });
        if tiles.len() == MOST_TILES {
            return;
        }
        let windows = merged(&tiles);
        if windows.len() <= most {
            self.windows = windows.into_iter().map(|w| self.window(w)).collect();
            let is_marked =
                |i| surfaces.flat_normal(i).is_some() && is_mirror(surfaces.material(i));
            self.is_window = (0..surfaces.tracer.item_count()).map(is_marked).collect();
        }
    }

    fn window(&self, tile: Tile) -> Window {
        let image = |lamp: &Lamp| mirror_polygon(&lamp.polygon, tile.polygon[0], tile.normal);
        Window {
            images: self.lamps.iter().map(image).collect(),
            polygon: tile.polygon,
            normal: tile.normal,
            reflectance: tile.reflectance,
        }
    }
}

/// Visits the flat convex polygons of every surface whose material is `wanted`: whole faces
/// where they are flat and convex, else their triangles.
fn flat_faces(
    surfaces: &Surfaces,
    wanted: impl Fn(&Material) -> bool,
    mut visit: impl FnMut(ArrayPolygon, DVec3, &Material),
) {
    let materials = &surfaces.scene.materials;
    for object in &surfaces.scene.objects {
        match &object.shape {
            Shape::Mesh(mesh) => {
                for face in 0..mesh.faces.len() {
                    let material = &materials[mesh.face_materials[face] as usize];
                    if wanted(material) {
                        for polygon in convex_pieces(mesh, face) {
                            let normal = area_vector(&polygon).normalize_or_zero();
                            if normal != DVec3::ZERO {
                                visit(polygon, normal, material);
                            }
                        }
                    }
                }
            }
            // Curved as a rule: its light is met by rays.
            Shape::Exact(_) => {}
            Shape::Primitive(p) => {
                let material = &materials[p.material as usize];
                if wanted(material)
                    && matches!(p.kind, PrimitiveKind::Cuboid | PrimitiveKind::Square)
                {
                    for part in 0..p.kind.parts() {
                        visit(
                            part_polygon(p, part),
                            p.point(part, 0.5, 0.5).normal,
                            material,
                        );
                    }
                }
            }
        }
    }
}

/// A flat part of a primitive as a polygon.
fn part_polygon(p: &Primitive, part: usize) -> ArrayPolygon {
    let corner = |(u, v)| p.point(part, u, v).position;
    let polygon: ArrayPolygon = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .into_iter()
        .map(corner)
        .collect();
    if area_vector(&polygon).dot(p.point(part, 0.5, 0.5).normal) < 0.0 {
        return polygon.iter().rev().copied().collect();
    }
    polygon
}

/// A face as one polygon if it is flat and convex, else as its triangles.
fn convex_pieces(mesh: &Mesh, face: usize) -> Vec<ArrayPolygon> {
    let corners = mesh.face_positions(face);
    if is_flat_and_convex(&corners) {
        return vec![corners.into_iter().collect()];
    }
    let triangle = |t: [u32; 3]| t.iter().map(|&k| corners[k as usize]).collect();
    mesh.triangulate(face).into_iter().map(triangle).collect()
}

/// Whether all corners lie in one plane, to 1e-6 of the polygon's size, and turn one way.
fn is_flat_and_convex(polygon: &[DVec3]) -> bool {
    let area = area_vector(polygon);
    let normal = area.normalize_or_zero();
    let size = area.length().sqrt();
    let n = polygon.len();
    n <= ArrayPolygon::INLINE
        && normal != DVec3::ZERO
        && (0..n).all(|k| {
            let (a, b, c) = (polygon[k], polygon[(k + 1) % n], polygon[(k + 2) % n]);
            (b - polygon[0]).dot(normal).abs() <= 1e-6 * size
                && (b - a).cross(c - b).dot(normal) >= 0.0
        })
}
