//! The lab: eight lessons on light, each with a scene, a question, and a number to find with the controls of the
//! window.
//!
//! The texts are data, one file per language in the folder `lab` of this crate. Labels of the window stand there in
//! braces, as in `{Solve}`, and are shown as the window has them. Tests do what the steps of each lesson say, and find
//! the number that the lesson calls right.

mod link;
mod scenes;
#[cfg(test)]
mod tests;
mod texts;

pub use link::LabLink;
pub use texts::LessonTexts;
pub(crate) use texts::{TextPiece, pieces};

use crate::document::SceneDocument;
use crate::first_pass::{EngineChoice, LightSettings};
use crate::variants::all;
use crate::view::Shading;
use clap::ValueEnum;

/// A lesson, in the order of their numbers from 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Lesson {
    /// The form factor between two squares.
    #[default]
    FormFactor,
    /// What bounces add to an energy balance.
    EnergyBalance,
    /// An area by reciprocity.
    Reciprocity,
    /// Hemicubes against rays: error against time.
    Engines,
    /// A mirror and the image in it.
    Mirror,
    /// A rough surface by wave optics and by facets, at grazing angles.
    Grazing,
    /// An exact letter and its mesh.
    Letter,
    /// The standard error of independent estimates.
    ErrorBar,
}

/// The number that a lesson asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownAnswer {
    /// Its value.
    pub value: f64,
    /// The unit that follows it; empty without one.
    pub unit: &'static str,
    /// Largest relative deviation of an answer that counts as right.
    pub tolerance: f64,
}

impl KnownAnswer {
    /// The value in four digits with its unit.
    pub fn shown(&self) -> String {
        let digits = (3 - self.value.abs().log10().floor() as i32).clamp(0, 6) as usize;
        let number = format!("{:.digits$}", self.value);
        format!("{number} {}", self.unit).trim_end().to_owned()
    }
}

/// What an answer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Right within the tolerance.
    Right,
    /// Another number.
    Wrong,
    /// Not a number.
    Unreadable,
}

/// The lab, as far as it is not the window's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LabState {
    /// Whether it is shown.
    pub is_open: bool,
    /// The lesson that is shown, or was last.
    pub lesson: Lesson,
}

/// Watts of the lamp of the lesson on bounces.
const POWER: f64 = 100.0;

impl Lesson {
    /// Number of lessons.
    pub const COUNT: usize = 8;

    /// Its number, from 1.
    pub fn number(self) -> usize {
        self as usize + 1
    }

    /// The lesson of a number from 1; `None` if there is no such lesson.
    pub fn from_number(number: usize) -> Option<Lesson> {
        all().find(|lesson: &Lesson| lesson.number() == number)
    }

    /// The number that is asked for, from closed forms; tests compare it with these, and with what the window shows.
    pub fn known_answer(self) -> KnownAnswer {
        let (value, unit, tolerance) = match self {
            // Howell's C-11 for squares of side 1 at distance 2.
            Lesson::FormFactor => (0.068_59, "", 0.02),
            // The fifth power of the reflectance, of 100 W.
            Lesson::EnergyBalance => (POWER * scenes::WALLS.powi(5), "W", 0.03),
            Lesson::Reciprocity => (scenes::sheet_area(), "m²", 0.02),
            // By the program itself; independent random rays would give the square root of 256, 16.
            Lesson::Engines => (35.9, "", 0.03),
            Lesson::Mirror => (scenes::MIRROR, "", 0.02),
            // 0.9 exp(−(4πσ cos θ/λ)²) at 80 degrees.
            Lesson::Grazing => (54.04, "%", 0.02),
            // The area of a ring between circles over that of one between octagons: π / (4 sin 45°).
            Lesson::Letter => (1.110_7, "", 0.005),
            // Student's t with three degrees of freedom for 95.45%, over 2.
            Lesson::ErrorBar => (1.654, "", 0.02),
        };
        KnownAnswer {
            value,
            unit,
            tolerance,
        }
    }

    /// What a typed answer is. The decimal point may be a comma, and the unit may follow.
    pub fn check(self, typed: &str) -> Verdict {
        let known = self.known_answer();
        let typed = typed.trim();
        let number = typed.strip_suffix(known.unit).unwrap_or(typed);
        let number = number.trim_end().replace(',', ".");
        match number.parse::<f64>() {
            Ok(x) if !x.is_finite() => Verdict::Unreadable,
            Ok(x) if (x - known.value).abs() <= known.tolerance * known.value => Verdict::Right,
            Ok(_) => Verdict::Wrong,
            Err(_) => Verdict::Unreadable,
        }
    }

    /// A new document with its scene.
    pub fn document(self) -> SceneDocument {
        SceneDocument::of_scene(scenes::scene(self), None)
    }

    /// The settings of the solver with which it begins.
    pub fn settings(self) -> LightSettings {
        let usual = LightSettings::default();
        // Whole faces are patches where form factors between them are asked for.
        let whole = LightSettings {
            patches: 1,
            ..usual
        };
        match self {
            Lesson::FormFactor | Lesson::Reciprocity | Lesson::Engines | Lesson::Mirror => whole,
            Lesson::ErrorBar => LightSettings {
                engine: EngineChoice::Hemicube,
                ..whole
            },
            Lesson::EnergyBalance => LightSettings {
                engine: EngineChoice::Analytic,
                patches: 150,
                error: 0.01,
                ..usual
            },
            Lesson::Grazing | Lesson::Letter => usual,
        }
    }

    /// The shading mode with which it begins.
    pub fn shading(self) -> Shading {
        match self {
            Lesson::FormFactor
            | Lesson::Reciprocity
            | Lesson::Engines
            | Lesson::Mirror
            | Lesson::ErrorBar => Shading::FormFactors,
            Lesson::EnergyBalance | Lesson::Grazing | Lesson::Letter => Shading::Gouraud,
        }
    }
}
