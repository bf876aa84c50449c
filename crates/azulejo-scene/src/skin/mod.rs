//! Polygons that stand for exact shapes.
//!
//! | module | what it answers |
//! |---|---|
//! | `flat` | a plane figure as polygons, whatever its contours do |
//! | `facet` | the faces of prisms, primitives, patches and meshes |
//! | `cut` | what set operations leave of faces |
//! | `meet` | where two triangles cross |
//! | `builder` | one mesh of all |

mod builder;
mod cut;
mod facet;
mod flat;
mod meet;
#[cfg(test)]
mod tests;

use crate::{Exact, Leaf, Mesh, Object, Scene, Shape, Solid};
use builder::Builder;
use facet::{Facet, Flats, facets};
use std::borrow::Cow;

/// Positions nearer than this share of a shape's size are one.
const SAME: f64 = 1e-9;
/// A skin of more faces is made again, more coarsely.
const MOST_FACES: usize = 1 << 19;
/// How much more coarsely, and how often.
const COARSER: f64 = 4.0;
const TRIALS: u32 = 6;

impl Exact {
    /// Polygons whose chords leave the surface by at most `chord_error` world units, > 0, or by a
    /// 50th of a solid's size if that is less. A bent face may be a quadrilateral.
    ///
    /// Closed where the solids are, front outside, with normals at the corners: smooth along a
    /// curve, creased where it turns by 30° or more and around caps. Materials are the leaves'.
    /// Set operations are those of the polygons: their cuts lie where the polygons cross. Skins of
    /// more than half a million faces are made more coarsely, by up to 4⁶ times the error asked
    /// for.
    pub fn tessellate(&self, chord_error: f64) -> Mesh {
        let size = self.bounds().diagonal();
        if !(size > 0.0 && size.is_finite() && chord_error > 0.0) {
            return Mesh::default();
        }
        let most = |trial: u32| {
            if trial < TRIALS {
                MOST_FACES
            } else {
                usize::MAX
            }
        };
        let error = |trial: u32| chord_error * COARSER.powi(trial as i32);
        let skin = |trial: u32| Skin::of(self, error(trial), SAME * size, most(trial));
        (0..=TRIALS).find_map(skin).unwrap_or_default()
    }
}

/// A skin while it is made.
struct Skin {
    chord_error: f64,
    builder: Builder,
    flats: Flats,
    most: usize,
}

impl Skin {
    /// `None` if it would have more than `most` faces.
    fn of(exact: &Exact, chord_error: f64, same: f64, most: usize) -> Option<Mesh> {
        let mut skin = Skin {
            chord_error,
            builder: Builder::new(same),
            flats: Flats::default(),
            most,
        };
        skin.add_all(&exact.solids)?;
        Some(skin.builder.finish())
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
    /// The scene with polygons in the place of its [`Shape::Exact`] objects; itself if it has none.
    ///
    /// `chord_error` is relative to each object's size, > 0.
    pub fn faceted(&self, chord_error: f64) -> Cow<'_, Scene> {
        self.faceted_by(|exact| chord_error * exact.bounds().diagonal())
    }

    /// The scene with polygons in the place of its [`Shape::Exact`] objects, itself if it has
    /// none. `chord_error` says how far chords may leave each, world units, > 0.
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
