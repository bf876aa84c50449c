//! Proxy meshes: polygons that replace exact shapes in the first pass.
//!
//! | module | content |
//! |---|---|
//! | `bevelled` | plane figures whose points have the heights of a bevel |
//! | `areas` | areas without a mesh of all prisms |
//! | `flat_figure` | plane figures as polygons, also where contours cross or overlap |
//! | `figure_sets` | what is inside several plane figures, with their curves |
//! | `facet` | the faces of prisms, primitives, patches and meshes |
//! | `cut` | set operations on faces |
//! | `triangle_pair` | intersection of two triangles |
//! | `uncrossed` | edges divided where they cross |
//! | `builder` | the mesh under construction |

mod areas;
mod bevelled;
mod builder;
mod cut;
mod facet;
mod figure_sets;
mod flat_figure;
#[cfg(test)]
mod tests;
mod triangle_pair;
mod uncrossed;

pub(crate) use flat_figure::FlatFigure;
pub use flat_figure::Tiling;

use crate::{Exact, Leaf, Mesh, Object, Scene, Shape, Solid};
use builder::ProxyMeshBuilder;
use facet::{Facet, FlatFigureCache, facets};
use std::borrow::Cow;

/// Positions nearer than this fraction of a shape's size are merged.
const SAME: f64 = 1e-9;
/// A proxy mesh with more faces is rebuilt with a larger chord error.
const MOST_FACES: usize = 1 << 19;
/// Factor by which the chord error grows, and how often it may.
const COARSER: f64 = 4.0;
const TRIALS: u32 = 6;

impl Exact {
    /// Polygons whose chords deviate from the surface by at most `chord_error` world units, > 0, or
    /// a 50th of a solid's size if that is less. Curved parts may have quadrilaterals.
    ///
    /// Closed where the solids are, front outside, with normals at the corners: smooth along a
    /// curve, creased where it turns by 30° or more and at the edges of caps. Materials are the
    /// leaves'. Set operations are applied to the polygons: cuts lie where the polygons cross.
    /// Meshes of more than half a million faces are rebuilt with a larger error, up to 4⁶ times the
    /// requested one.
    pub fn tessellate(&self, chord_error: f64) -> Mesh {
        let size = self.bounds().diagonal();
        if !(size > 0.0 && size.is_finite() && chord_error > 0.0) {
            return Mesh::default();
        }
        mesh_of(self.solids.iter(), chord_error, size)
    }

    /// A mesh for each solid, as [`tessellate`](Exact::tessellate), but never coarser than requested. `None` if one has
    /// more than `most` faces.
    pub fn tessellate_each(&self, chord_error: f64, most: usize) -> Option<Vec<Mesh>> {
        let mut flats = FlatFigureCache::default();
        let mut meshes = Vec::with_capacity(self.solids.len());
        for solid in &self.solids {
            let size = solid.bounds().diagonal();
            if !(size > 0.0 && size.is_finite() && chord_error > 0.0) {
                meshes.push(Mesh::default());
                continue;
            }
            let mut mesher = ProxyMesher {
                chord_error,
                builder: ProxyMeshBuilder::new(SAME * size),
                flats,
                most,
            };
            mesher.add(solid)?;
            meshes.push(mesher.builder.finish());
            flats = mesher.flats;
        }
        Some(meshes)
    }
}

/// The polygons of solids, with a chord error so large that there are not too many. `size` is that
/// of the whole shape.
fn mesh_of<'a>(
    solids: impl Iterator<Item = &'a Solid> + Clone,
    chord_error: f64,
    size: f64,
) -> Mesh {
    let most = |trial: u32| {
        if trial < TRIALS {
            MOST_FACES
        } else {
            usize::MAX
        }
    };
    let error = |trial: u32| chord_error * COARSER.powi(trial as i32);
    let mesh =
        |trial: u32| ProxyMesher::mesh(solids.clone(), error(trial), SAME * size, most(trial));
    (0..=TRIALS).find_map(mesh).unwrap_or_default()
}

/// A proxy mesh under construction.
struct ProxyMesher {
    chord_error: f64,
    builder: ProxyMeshBuilder,
    flats: FlatFigureCache,
    most: usize,
}

impl ProxyMesher {
    /// `None` if it would have more than `most` faces.
    fn mesh<'a>(
        mut solids: impl Iterator<Item = &'a Solid>,
        chord_error: f64,
        same: f64,
        most: usize,
    ) -> Option<Mesh> {
        let mut mesher = ProxyMesher {
            chord_error,
            builder: ProxyMeshBuilder::new(same),
            flats: FlatFigureCache::default(),
            most,
        };
        solids.try_for_each(|s| mesher.add(s))?;
        Some(mesher.builder.finish())
    }

    fn add_all(&mut self, solids: &[Solid]) -> Option<()> {
        solids.iter().try_for_each(|s| self.add(s))
    }

    fn add(&mut self, solid: &Solid) -> Option<()> {
        self.builder.begin_solid();
        match solid {
            Solid::Primitive(p) => self.add_leaf(Leaf::Primitive(p)),
            Solid::Prism(p) => self.add_leaf(Leaf::Prism(p)),
            Solid::Patch(p) => self.add_leaf(Leaf::Patch(p)),
            Solid::Mesh(m) => self.add_leaf(Leaf::Mesh(m)),
            Solid::Shell(pieces) => return self.add_all(pieces),
            Solid::Csg(csg) => {
                let error = self.chord_error;
                let flats = &mut self.flats;
                cut::cut(csg, |leaf| facets(leaf, error, flats), &mut self.builder);
            }
        }
        (self.builder.faces() <= self.most).then_some(())
    }

    fn add_leaf(&mut self, leaf: Leaf) {
        for Facet { corners, material } in facets(leaf, self.chord_error, &mut self.flats) {
            self.builder.push(&corners, material);
        }
    }
}

impl Scene {
    /// The scene with its [`Shape::Exact`] objects replaced by polygons; itself if it has none.
    ///
    /// `chord_error` is relative to each object's size, > 0.
    pub fn faceted(&self, chord_error: f64) -> Cow<'_, Scene> {
        self.faceted_by(|exact| chord_error * exact.bounds().diagonal())
    }

    /// The scene with its [`Shape::Exact`] objects replaced by polygons; itself if it has none.
    /// `chord_error` returns the largest deviation of chords from each, world units, > 0.
    pub fn faceted_by(&self, chord_error: impl Fn(&Exact) -> f64) -> Cow<'_, Scene> {
        let is_exact = |o: &Object| matches!(o.shape, Shape::Exact(_));
        if !self.objects.iter().any(is_exact) {
            return Cow::Borrowed(self);
        }
        let mut scene = self.clone();
        for object in &mut scene.objects {
            if let Shape::Exact(exact) = &object.shape {
                object.shape = Shape::Mesh(exact.tessellate(chord_error(exact)));
            }
        }
        Cow::Owned(scene)
    }
}
