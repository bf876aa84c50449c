//! From the objects of a file to those of the scene.

use super::emissivity::{ConstructionSide, InputConstructions};
use super::input::{InputObject, InputText, key};
use super::openings::{CutFailure, CutSurface, cut};
use super::place::InputPlaces;
use super::surfaces::{InputSurfaces, SurfaceOpening, ZoneSurface};
use super::zones::InputZones;
use crate::reading::options::Budget;
use crate::reading::warnings::Warnings;
use crate::surface::cut::MOST_HOLES;
use crate::surface::mean_plane::MeanPlane;
use crate::surface::weld::Welder;
use crate::{ReadError, ReadOptions};
use azulejo_scene::{MaterialId, Mesh, Object, Scene, Shape, Sidedness, Units, Up, Zone};
use glam::DVec3;
use std::collections::HashMap;
use std::sync::Arc;

/// Surfaces whose corners are nearer to each other than this, relative to their size, are the two sides
/// of one wall.
const SAME_PLACE: f64 = 1e-6;

/// Most openings of a surface that are compared with those of its other side.
const MOST_COMPARED: usize = 256;

/// Makes the scene.
///
/// # Errors
/// Numbers that are missing or none, and surfaces with too many openings.
pub(super) fn build(
    objects: &[InputObject<'_>],
    file: InputText<'_>,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Scene, ReadError> {
    let places = InputPlaces::read(objects, file)?;
    let constructions = InputConstructions::read(objects, file)?;
    let surfaces = InputSurfaces::read(objects, &places, file, warnings)?;
    let zones = InputZones::read(objects, &surfaces, &constructions, file, warnings)?;
    let mut builder = EnergyPlusBuilder {
        file,
        warnings,
        budget: Budget::new(options),
        places: &places,
        constructions,
        zones,
        scene: Scene::default(),
        cut: HashMap::new(),
    };
    for (number, surface) in surfaces.list.iter().enumerate() {
        builder.surface(number, surface, &surfaces)?;
    }
    for orphan in &surfaces.orphans {
        builder.opening(orphan, None, &WallSides::default());
    }
    let mut scene = builder.scene;
    scene.units = Units {
        metres_per_unit: Some(1.0),
        up: Up::Z,
        ..Units::default()
    };
    Ok(scene)
}

struct EnergyPlusBuilder<'a, 'w> {
    file: InputText<'a>,
    warnings: &'w mut Warnings,
    budget: Budget,
    places: &'a InputPlaces,
    constructions: InputConstructions,
    zones: InputZones,
    scene: Scene,
    /// Surfaces between zones that are done, by number: their other sides get the same polygons.
    cut: HashMap<usize, CutSurface>,
}

/// The enclosures before and behind a wall.
#[derive(Default)]
struct WallSides {
    inner: Option<Arc<Zone>>,
    /// The zone behind, where that has no surface of its own in the file.
    has_back: bool,
    behind: Option<Arc<Zone>>,
}

impl EnergyPlusBuilder<'_, '_> {
    fn warn(&mut self, object: &InputObject<'_>, message: &str) {
        self.file.warn(self.warnings, object.at, message);
    }

    /// Adds a surface and its openings.
    fn surface(
        &mut self,
        number: usize,
        surface: &ZoneSurface<'_>,
        all: &InputSurfaces<'_>,
    ) -> Result<(), ReadError> {
        let object = surface.object;
        let construction = object.text("construction_name");
        if self.constructions.is_open(construction) {
            self.warn(object, "air boundary between zones: left open");
            return Ok(());
        }
        let other = other_side(number, surface, all);
        let known = other.and_then(|other| self.cut.get(&other));
        let faces = match known {
            Some(cut) => reversed(&cut.faces),
            None => self.cut(number, surface, other.is_some())?,
        };
        if faces.is_empty() {
            self.warn(object, "surface that its openings cover entirely: left out");
        }
        let name = match construction {
            "" if surface.is_shading() => "shading",
            "" => "no construction",
            name => name,
        };
        if surface.is_shading() {
            let material = self.material(name, ConstructionSide::Inner, false);
            self.scene.materials[material as usize].sidedness = Sidedness::Two;
            self.object(&object.name, faces, material, None);
        } else {
            let has_back = self.has_implied_back(object, all);
            let outside = object.text("outside_boundary_condition_object");
            let sides = WallSides {
                inner: self.zones.of(surface),
                has_back,
                behind: has_back.then(|| self.zones.named(outside)).flatten(),
            };
            self.wall(&object.name, name, faces, &sides, false);
            for opening in &surface.openings {
                let behind = other.map(|other| &all.list[other]);
                self.opening(opening, behind, &sides);
            }
        }
        Ok(())
    }

    /// Whether the surface names the zone behind it instead of a surface there, so that its other side is
    /// one more surface.
    fn has_implied_back(&mut self, object: &InputObject<'_>, all: &InputSurfaces<'_>) -> bool {
        let condition = object.key("outside_boundary_condition");
        let outside = object.key("outside_boundary_condition_object");
        let is_surface = all.numbers.contains_key(&outside);
        if self.places.has_zone(&outside) && !is_surface {
            return outside != object.key("zone_name");
        }
        if matches!(condition.as_str(), "zone" | "space") {
            let message = "surface whose other side is in a zone that is not in the file: one side is \
                           read";
            self.warn(object, message);
        }
        false
    }

    fn material(
        &mut self,
        construction: &str,
        side: ConstructionSide,
        is_glass: bool,
    ) -> MaterialId {
        let scene = &mut self.scene;
        self.constructions
            .material(scene, construction, side, is_glass)
    }

    /// Adds polygons as they are seen from inside of their zone and, if so, from the zone behind.
    fn wall(
        &mut self,
        name: &str,
        construction: &str,
        faces: Vec<Vec<DVec3>>,
        sides: &WallSides,
        is_glass: bool,
    ) {
        let inner = self.material(construction, ConstructionSide::Inner, is_glass);
        self.object(name, reversed(&faces), inner, sides.inner.clone());
        if sides.has_back {
            let outer = self.material(construction, ConstructionSide::Outer, is_glass);
            // The name that EnergyPlus gives it.
            self.object(&format!("iz-{name}"), faces, outer, sides.behind.clone());
        }
    }

    /// The polygons of a surface without its openings, counter-clockwise from outside.
    fn cut(
        &mut self,
        number: usize,
        surface: &ZoneSurface<'_>,
        is_kept: bool,
    ) -> Result<Vec<Vec<DVec3>>, ReadError> {
        let object = surface.object;
        let openings: Vec<&[DVec3]> = surface.openings.iter().map(|o| &*o.corners).collect();
        let pieces = cut(&surface.corners, &openings, &mut self.budget);
        let pieces = pieces.map_err(|failure| match failure {
            CutFailure::Exhausted(exhausted) => exhausted.error(self.file.name),
            CutFailure::TooComplex => {
                let found = format!("{} openings in one surface", openings.len());
                let expected = format!("at most {MOST_HOLES}, side by side");
                self.file.error(object.at, found, expected)
            }
        })?;
        if pieces.has_overlaps {
            let message = "openings that overlap or extend beyond their surface: cut out where they \
                           lie within";
            self.warn(object, message);
        }
        if pieces.has_distant_openings {
            let message = "openings outside of the plane of their surface: cut out where they lie \
                           before it";
            self.warn(object, message);
        }
        let faces = pieces.faces.clone();
        if is_kept {
            self.cut.insert(number, pieces);
        }
        Ok(faces)
    }

    /// Adds an opening, with the corners of the one that it shares with the surface behind.
    fn opening(
        &mut self,
        opening: &SurfaceOpening<'_>,
        behind: Option<&ZoneSurface<'_>>,
        sides: &WallSides,
    ) {
        let object = opening.object;
        let is_glass = match object.layout.surface_type {
            "" => object.key("surface_type") != "door",
            known => known != "Door",
        };
        let construction = match object.text("construction_name") {
            "" => "no construction",
            name => name,
        };
        let outside = object.key("outside_boundary_condition_object");
        let behind = behind.into_iter().flat_map(|behind| &behind.openings);
        let mut behind = behind.filter(|other| key(&other.object.name) == outside);
        let corners = match behind.next() {
            // The earlier of the two is the model.
            Some(other) if other.object.at < object.at => {
                let turned = reversed(std::slice::from_ref(&other.corners));
                let is_same = is_same_place(&turned[0], &opening.corners);
                if is_same {
                    turned[0].clone()
                } else {
                    opening.corners.clone()
                }
            }
            _ => opening.corners.clone(),
        };
        self.wall(&object.name, construction, vec![corners], sides, is_glass);
    }

    fn object(
        &mut self,
        name: &str,
        faces: Vec<Vec<DVec3>>,
        material: MaterialId,
        zone: Option<Arc<Zone>>,
    ) {
        if faces.is_empty() || !self.budget.keeps() {
            return;
        }
        let mut welder = Welder::new(faces.iter().map(Vec::len).sum());
        let mut mesh = Mesh::default();
        for face in faces {
            let corners: Vec<u32> = face.iter().map(|&p| welder.index(p)).collect();
            mesh.push_face(&corners, material);
        }
        mesh.positions = welder.positions;
        self.scene.objects.push(Object {
            zone,
            ..Object::new(name, Shape::Mesh(mesh))
        });
    }
}

/// The surface of the other zone that is the other side of this one, in the same place.
fn other_side(number: usize, surface: &ZoneSurface<'_>, all: &InputSurfaces<'_>) -> Option<usize> {
    let named = surface.object.key("outside_boundary_condition_object");
    let other = *all.numbers.get(&named).filter(|&&other| other != number)?;
    let turned = reversed(std::slice::from_ref(&all.list[other].corners));
    let is_same = is_same_place(&turned[0], &surface.corners);
    let others = &all.list[other].openings;
    let has_same_openings = others.len() == surface.openings.len()
        && others.len() <= MOST_COMPARED
        && surface.openings.iter().all(|opening| {
            let turned = reversed(std::slice::from_ref(&opening.corners));
            let mut others = others.iter();
            others.any(|other| is_same_place(&turned[0], &other.corners))
        });
    (is_same && has_same_openings).then_some(other)
}

/// Polygons with their fronts turned.
fn reversed(polygons: &[Vec<DVec3>]) -> Vec<Vec<DVec3>> {
    let turned = polygons.iter().map(|p| p.iter().rev().copied().collect());
    turned.collect()
}

/// Whether two polygons have the same corners in the same order, wherever they begin.
fn is_same_place(a: &[DVec3], b: &[DVec3]) -> bool {
    let within = SAME_PLACE * MeanPlane::of(a).radius;
    let starts = (0..b.len()).filter(|&k| a[0].distance(b[k]) <= within);
    let mut starts = starts.take(4);
    a.len() == b.len()
        && starts.any(|k| {
            let turned = b.iter().cycle().skip(k);
            a.iter().zip(turned).all(|(p, q)| p.distance(*q) <= within)
        })
}
