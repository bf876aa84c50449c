//! Question marks that explain the terms of the method.

use crate::words::Language;
use egui::{Button, Popup, Ui};

/// Width of an explanation.
const WIDTH: f32 = 280.0;

/// A term that students may not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HelpTerm {
    Residual,
    Replicate,
    StandardError,
    FormFactor,
    Patch,
    EnergyBalance,
}

impl HelpTerm {
    fn title(self, language: Language) -> &'static str {
        match self {
            HelpTerm::Residual => language.tr("Residual"),
            HelpTerm::Replicate => language.tr("Independent estimates"),
            HelpTerm::StandardError => language.tr("Standard error"),
            HelpTerm::FormFactor => language.tr("Form factor"),
            HelpTerm::Patch => language.tr("Patch"),
            HelpTerm::EnergyBalance => language.tr("Energy balance"),
        }
    }

    fn explanation(self, language: Language) -> &'static str {
        match self {
            HelpTerm::Residual => language.tr(
                "What one more bounce would still change, relative to the light found so far. It falls with each bounce.",
            ),
            HelpTerm::Replicate => language.tr(
                "Form factors are estimated several times, independently of one another, and the light is solved with each estimate. How far the results differ gives the estimated error.",
            ),
            HelpTerm::StandardError => language.tr(
                "Standard deviation of an estimate, written after ±. The true value lies within two standard errors in about 95 of 100 cases.",
            ),
            HelpTerm::FormFactor => language.tr(
                "Fraction of the diffuse light leaving one patch that arrives at another surface, directly or by way of mirrors and glass.",
            ),
            HelpTerm::Patch => language.tr(
                "Piece of a surface for which the solver computes one radiosity on each side. Smaller patches resolve finer shadows and take longer.",
            ),
            HelpTerm::EnergyBalance => language.tr(
                "All emitted light is absorbed, leaves the scene or is cut off; of lights without area, what misses all surfaces does not count. A difference is an error of the solution: noise, or the light of bounces beyond a limit.",
            ),
        }
    }
}

/// Draws a question mark, which explains the term while the pointer is over it, and after a click
/// or Enter until the next one.
pub(super) fn mark(ui: &mut Ui, language: Language, term: HelpTerm) {
    let (title, explanation) = (term.title(language), term.explanation(language));
    let name = format!("{}: {title}", language.tr("Help"));
    let button = ui.add(Button::new("?").small());
    let button = button.on_hover_text(explanation).accessible_name(name);
    Popup::from_toggle_button_response(&button)
        .width(WIDTH)
        .show(|ui| {
            ui.set_max_width(WIDTH);
            ui.strong(title);
            ui.label(explanation);
        });
}
