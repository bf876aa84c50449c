//! Areas of exact shapes, without a mesh of all their prisms.

use super::facet::{FlatFigureCache, facets, outline_length};
use super::mesh_of;
use crate::math::area_vector;
use crate::{Bevel, Exact, Figure, Leaf, MaterialId, Prism, Solid};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

impl Exact {
    /// The area of the polygons that [`tessellate`](Exact::tessellate) returns for the same error,
    /// by material, square world units.
    ///
    /// Prisms of one figure that differ in position only are tessellated once, so text of any
    /// length takes the time of its alphabet. The areas agree up to rounding, and up to chord errors
    /// where the mesh would have more than half a million faces.
    pub fn areas(&self, chord_error: f64) -> BTreeMap<MaterialId, f64> {
        let size = self.bounds().diagonal();
        let mut tally = AreaTally {
            chord_error,
            prisms: HashMap::new(),
            flats: FlatFigureCache::default(),
            rest: Vec::new(),
            areas: BTreeMap::new(),
        };
        if !(size > 0.0 && size.is_finite() && chord_error > 0.0) {
            return tally.areas;
        }
        self.solids.iter().for_each(|s| tally.add(s));
        let rest = mesh_of(tally.rest.iter().copied(), chord_error, size);
        for (face, &material) in rest.face_materials.iter().enumerate() {
            *tally.areas.entry(material).or_default() += rest.face_area_vector(face).length();
        }
        tally.areas
    }
}

impl Exact {
    /// The length of the outlines of all prisms, where contours overlap that of their union, along chords that deviate
    /// by at most `chord_error` > 0, world units.
    pub fn outline_length(&self, chord_error: f64) -> f64 {
        let mut known: HashMap<PrismKey, f64> = HashMap::new();
        let mut flats = FlatFigureCache::default();
        let leaves = self.leaves().into_iter();
        let lengths = leaves.map(|leaf| match leaf {
            Leaf::Prism(prism) => *known
                .entry(prism_key(prism))
                .or_insert_with(|| outline_length(prism, chord_error, &mut flats)),
            Leaf::Primitive(_) | Leaf::Patch(_) | Leaf::Mesh(_) => 0.0,
        });
        lengths.sum()
    }
}

/// A prism without its position: the figure, the bevel, and the bits of the map's axes.
type PrismKey = (*const Figure, Option<*const Bevel>, [u64; 9]);

fn prism_key(prism: &Prism) -> PrismKey {
    let axes = prism.world_from_figure.matrix3.to_cols_array();
    let bevel = prism.bevel.as_ref().map(Arc::as_ptr);
    (Arc::as_ptr(&prism.figure), bevel, axes.map(f64::to_bits))
}

/// The areas found so far.
struct AreaTally<'a> {
    chord_error: f64,
    prisms: HashMap<PrismKey, f64>,
    flats: FlatFigureCache,
    /// Solids whose areas are those of their mesh.
    rest: Vec<&'a Solid>,
    areas: BTreeMap<MaterialId, f64>,
}

impl<'a> AreaTally<'a> {
    fn add(&mut self, solid: &'a Solid) {
        match solid {
            Solid::Prism(prism) => {
                let area = self.prism(prism);
                *self.areas.entry(prism.material).or_default() += area;
            }
            Solid::Shell(pieces) => pieces.iter().for_each(|s| self.add(s)),
            Solid::Primitive(_) | Solid::Patch(_) | Solid::Mesh(_) | Solid::Csg(_) => {
                self.rest.push(solid);
            }
        }
    }

    fn prism(&mut self, prism: &Prism) -> f64 {
        let (error, flats) = (self.chord_error, &mut self.flats);
        *self.prisms.entry(prism_key(prism)).or_insert_with(|| {
            // At the origin, so that the area does not depend on which prism came first.
            let mut at_origin = prism.clone();
            at_origin.world_from_figure.translation = DVec3::ZERO;
            let faces = facets(Leaf::Prism(&at_origin), error, flats);
            let area = |corners: &[(DVec3, DVec3)]| {
                let points: Vec<DVec3> = corners.iter().map(|c| c.0).collect();
                area_vector(&points).length()
            };
            faces.iter().map(|f| area(&f.corners)).sum()
        })
    }
}
