//! Test cases: scenes with a question whose answer is known, to judge every engine by.
//!
//! [`cases`] returns 68: pairs of polygons from Howell's catalogue, elements, curved bodies,
//! infinite strips and prisms (cells between perfect mirrors), occluders, plane and curved mirrors,
//! dielectrics, and whole radiosity systems. Each has a scene, a [`Question`] about its form
//! factors, and a [`Truth`]: a closed formula where there is one, else a constant with its digits
//! and origin. [`Case::ask`] computes the form factors by an engine; [`Case::answer`] derives the
//! answer from given form factors, with the standard error that follows from theirs.
//!
//! | module | content |
//! |---|---|
//! | `formulas`, `quadrature` | the closed forms, independent of the engines |
//! | `polygons`, `bodies`, `specular`, `systems` | the cases |
//! | `catalogue/` | more cases: closed forms over ranges of their parameters |
//! | `builders` | construction of the scenes |
//! | `poses` | the same cases turned, moved and rounded |
//! | `answers` | from form factors to the answer and its standard error |

mod answers;
mod bodies;
mod builders;
mod catalogue;
pub mod formulas;
mod polygons;
mod poses;
mod quadrature;
mod specular;
mod systems;

use crate::patch::PatchSize;
pub use answers::Answer;
use azulejo_scene::Scene;
pub use catalogue::catalogue;
pub use poses::Pose;
use std::borrow::Cow;

/// A scene and a question about its form factors, with the known answer.
#[derive(Clone, Debug)]
pub struct Case {
    /// Short name, unique.
    pub id: Cow<'static, str>,
    /// Description for reports.
    pub description: String,
    /// Source of the truth: a number of Howell's catalogue, a rule, a theorem.
    pub source: &'static str,
    /// The capability of an engine that it tests.
    pub kind: CaseKind,
    /// The scene; faces stay whole unless `size` divides them.
    pub scene: Scene,
    /// How finely the scene has to be divided, so that its areas are those of the question.
    pub size: PatchSize,
    /// The question.
    pub question: Question,
    /// The known answer.
    pub truth: Truth,
}

/// The difficulty of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseKind {
    /// Unoccluded polygons.
    Polygons,
    /// Polygons with occluders.
    Shadow,
    /// Plane mirrors, including those that make a cell infinite.
    Mirrors,
    /// Curved bodies, as exact primitives.
    Curved,
    /// Refraction.
    Glass,
}

/// A question about a scene.
#[derive(Clone, Debug)]
pub enum Question {
    /// The extended form factor from one group of patches to another.
    Factor {
        /// Where the light leaves.
        from: PatchGroup,
        /// Where it arrives.
        to: PatchGroup,
    },
    /// The radiosity of a group, W/m², if each group has one radiosity all over.
    Radiosity {
        /// All groups that emit or reflect diffusely.
        groups: Vec<EnclosureSurface>,
        /// The group in question, as an index into `groups`.
        of: usize,
    },
    /// The net flux of a group, B − H, W/m².
    Flux {
        /// All groups that emit or reflect diffusely.
        groups: Vec<EnclosureSurface>,
        /// The group in question, as an index into `groups`; its reflectance is not 0.
        of: usize,
    },
}

/// Some patches, seen from one side.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchGroup {
    /// Index among the scene's objects.
    pub object: u32,
    /// One face of the object; `None` for all.
    pub face: Option<u32>,
    /// Whether the backs of the patches are meant, as in hollow bodies.
    pub back: bool,
    /// Only patches whose centre lies between these angles about the z axis, in turns.
    pub turns: Option<[f64; 2]>,
}

/// A group of an enclosure, with its emission and reflectance.
#[derive(Clone, Debug)]
pub struct EnclosureSurface {
    /// The patches.
    pub group: PatchGroup,
    /// Emitted exitance, W/m².
    pub exitance: f64,
    /// Diffuse reflectance.
    pub reflectance: f64,
}

/// A known answer.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    /// The value.
    pub value: f64,
    /// Absolute uncertainty: rounding, digits, and what the scene simplifies.
    pub error: f64,
    /// How it was obtained.
    pub provenance: Provenance,
}

/// How a truth was obtained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Provenance {
    /// A closed formula, evaluated.
    Formula,
    /// An integral of a closed formula, evaluated to rounding.
    Quadrature,
    /// A number from elsewhere, with this many significant digits.
    Constant {
        /// Number of digits.
        digits: u32,
        /// Its source.
        origin: &'static str,
    },
}

impl Truth {
    /// The value of a formula; it loses a few of its sixteen digits.
    fn formula(value: f64) -> Truth {
        Truth {
            value,
            error: 1e-13 * value.abs(),
            provenance: Provenance::Formula,
        }
    }

    /// The value of an integral.
    fn quadrature(value: f64) -> Truth {
        Truth {
            error: 1e-12 * value.abs(),
            provenance: Provenance::Quadrature,
            ..Truth::formula(value)
        }
    }

    /// A constant with this many significant digits.
    fn constant(value: f64, digits: u32, origin: &'static str) -> Truth {
        let first = value.abs().log10().floor() as i32;
        Truth {
            value,
            error: 0.5 * 10f64.powi(first + 1 - digits as i32),
            provenance: Provenance::Constant { digits, origin },
        }
    }

    /// The same with a relative error for what the scene simplifies.
    fn but_for(self, relative: f64) -> Truth {
        Truth {
            error: self.error + relative * self.value.abs(),
            ..self
        }
    }
}

impl PatchGroup {
    /// All fronts of an object.
    pub fn of(object: u32) -> PatchGroup {
        PatchGroup {
            object,
            face: None,
            back: false,
            turns: None,
        }
    }

    /// One face of it.
    pub fn face(self, face: u32) -> PatchGroup {
        PatchGroup {
            face: Some(face),
            ..self
        }
    }

    /// Its inside.
    pub fn inside(self) -> PatchGroup {
        PatchGroup { back: true, ..self }
    }

    /// The part between two angles about the z axis, in turns.
    pub fn between(self, from: f64, to: f64) -> PatchGroup {
        PatchGroup {
            turns: Some([from, to]),
            ..self
        }
    }
}

/// All cases, in a fixed order.
pub fn cases() -> Vec<Case> {
    [
        polygons::cases(),
        bodies::cases(),
        specular::cases(),
        systems::cases(),
    ]
    .concat()
}
