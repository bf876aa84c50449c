//! Truths: scenes with a question whose answer is known, to judge any engine by.
//!
//! [`cases`] has 68 of them: pairs of polygons from Howell's catalogue, elements, curved bodies,
//! infinite strips and prisms (cells between perfect mirrors), occluders, plane and curved mirrors,
//! dielectrics, and whole systems of radiosity. Each is a scene, a [`Question`] about its form
//! factors, and a [`Truth`]: a closed formula wherever there is one, else a constant with its
//! digits and its origin. [`Case::ask`] has an engine answer; [`Case::answer`] reads the answer out
//! of form factors that are there already, with the standard error that theirs make.
//!
//! | module | what it holds |
//! |---|---|
//! | `formulas`, `quadrature` | the closed forms, independent of the engines |
//! | `polygons`, `bodies`, `specular`, `systems` | the cases |
//! | `builders` | how their scenes are built |
//! | `answers` | from form factors to the answer and its standard error |

mod answers;
mod bodies;
mod builders;
pub mod formulas;
mod polygons;
mod quadrature;
mod specular;
mod systems;

use crate::patch::PatchSize;
pub use answers::Answer;
use azulejo_scene::Scene;

/// A scene, a question about its form factors, and the answer.
#[derive(Clone, Debug)]
pub struct Case {
    /// Short name, unique.
    pub id: &'static str,
    /// What it is, in words.
    pub description: String,
    /// Where the truth comes from: a number of Howell's catalogue, a rule, a theorem.
    pub source: &'static str,
    /// What an engine needs to be able to do.
    pub kind: CaseKind,
    /// The scene; faces stay as they are unless `size` divides them.
    pub scene: Scene,
    /// How finely the scene has to be divided, for its areas to be those of the question.
    pub size: PatchSize,
    /// What is asked.
    pub question: Question,
    /// The answer.
    pub truth: Truth,
}

/// What makes a case difficult.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseKind {
    /// Polygons that nothing stands between.
    Polygons,
    /// Polygons before and behind others.
    Shadow,
    /// Plane mirrors, also those that make a cell infinite.
    Mirrors,
    /// Curved bodies, as exact primitives.
    Curved,
    /// Refraction.
    Glass,
}

/// What is asked of a scene.
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
        /// All that emits or reflects diffusely.
        groups: Vec<EnclosureSurface>,
        /// The group that is asked for, among `groups`.
        of: usize,
    },
    /// The power per area that leaves a group less what arrives, B − H, W/m².
    Flux {
        /// All that emits or reflects diffusely.
        groups: Vec<EnclosureSurface>,
        /// The group that is asked for, among `groups`; its reflectance is not 0.
        of: usize,
    },
}

/// Some patches, seen from one side.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchGroup {
    /// Index among the scene's objects.
    pub object: u32,
    /// One face of the object, or all.
    pub face: Option<u32>,
    /// Whether it is the backs that are meant: hollow bodies.
    pub back: bool,
    /// Only patches whose centre stands at an angle about the z axis from the first of these to
    /// the second, in turns.
    pub turns: Option<[f64; 2]>,
}

/// A group that emits or reflects.
#[derive(Clone, Debug)]
pub struct EnclosureSurface {
    /// Which patches.
    pub group: PatchGroup,
    /// Emitted exitance, W/m².
    pub exitance: f64,
    /// Diffuse reflectance.
    pub reflectance: f64,
}

/// A known answer.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    /// The number.
    pub value: f64,
    /// How far it may be from the truth of the scene, absolute: rounding, digits, and what the scene
    /// simplifies.
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
    /// A number with so many significant digits, found elsewhere.
    Constant {
        /// Digits.
        digits: u32,
        /// By what means.
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

    /// A constant that is good for so many significant digits.
    fn constant(value: f64, digits: u32, origin: &'static str) -> Truth {
        let first = value.abs().log10().floor() as i32;
        Truth {
            value,
            error: 0.5 * 10f64.powi(first + 1 - digits as i32),
            provenance: Provenance::Constant { digits, origin },
        }
    }

    /// With what the scene simplifies, relative.
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
