//! A description being edited, and the model built from it in the background.

use super::background::{BackgroundWorker, LatestResult};
use super::reflection::{MaterialReflection, is_same_description, is_same_model};
use super::theme::{notice, problem};
use crate::words::Language;
use azulejo::scene::brdf::{BrdfError, Description};
use azulejo::scene::{Brdf, Material};
use azulejo::trace::{Cancelled, Progress};
use egui::{Context, Ui};
use std::sync::Arc;
use std::time::Duration;

/// A frame waits this long for a model, so that most changes appear at once.
const WAIT: Duration = Duration::from_millis(12);

/// A description being edited.
pub(super) struct ModelDraft {
    /// It may be invalid; the document then keeps the last valid one.
    pub description: Description,
    /// The model in the document.
    taken: Arc<Brdf>,
    making: LatestResult<DraftKey, Result<BuiltModel, BrdfError>>,
    worker: BackgroundWorker,
}

/// A model limited to reflect no more than it receives, and its albedo before that.
#[derive(Clone)]
struct BuiltModel {
    brdf: Arc<Brdf>,
    /// Largest hemispherical albedo of the description over the channels.
    reflected: f64,
}

#[derive(Clone)]
struct DraftKey(Description);

impl PartialEq for DraftKey {
    fn eq(&self, other: &DraftKey) -> bool {
        is_same_description(&self.0, &other.0)
    }
}

fn make(
    key: &DraftKey,
    _: &Progress,
    show: &mut dyn FnMut(Result<BuiltModel, BrdfError>),
) -> Result<(), Cancelled> {
    show(Brdf::new(key.0.clone()).map(|brdf| BuiltModel {
        reflected: brdf.mean_reflectance().max_channel(),
        brdf: Arc::new(brdf).limited(),
    }));
    Ok(())
}

impl ModelDraft {
    pub fn new(taken: Arc<Brdf>) -> ModelDraft {
        ModelDraft {
            description: taken.description().clone(),
            taken,
            making: LatestResult::default(),
            worker: BackgroundWorker::new("brdf model"),
        }
    }

    /// Whether this is a draft of the model in the document, rather than of an earlier one.
    pub fn is_of(&self, brdf: &Arc<Brdf>) -> bool {
        is_same_model(Some(&self.taken), Some(brdf))
    }

    /// A new model that the document does not have yet.
    pub fn made(&mut self, ctx: &Context) -> Option<Arc<Brdf>> {
        let key = DraftKey(self.description.clone());
        self.making.ask(&key, make, &self.worker, ctx);
        self.making.wait(WAIT);
        let (DraftKey(made_of), made) = self.making.found()?;
        let made = made.as_ref().ok()?;
        if is_same_description(made_of, self.taken.description()) {
            return None;
        }
        self.taken = made.brdf.clone();
        Some(made.brdf.clone())
    }

    /// Whether the model is still being built.
    pub fn is_busy(&self) -> bool {
        self.making
            .of(&DraftKey(self.description.clone()))
            .is_none()
    }

    /// Displays an error of the description, or a notice about its limitation.
    pub fn show_status(&self, ui: &mut Ui, language: Language) {
        match self.making.of(&DraftKey(self.description.clone())) {
            None => {
                ui.spinner();
            }
            Some(Err(wrong)) => {
                let kept = language.tr("The last valid model is kept.");
                problem(ui, &format!("{} {kept}", problem_words(language, wrong)));
            }
            Some(Ok(made)) if made.reflected > 1.0 + 1e-3 => {
                let words =
                    language.tr("This model reflects more than it receives: hemispherical albedo");
                let scaled = language.tr("scaled down to");
                let share = 100.0 / made.reflected;
                notice(
                    ui,
                    &format!(
                        "{words} {:.0} %; {scaled} {share:.1} %.",
                        100.0 * made.reflected
                    ),
                );
            }
            Some(Ok(_)) => {}
        }
    }
}

/// The error in the language of the window, as far as it is translated.
fn problem_words(language: Language, problem: &BrdfError) -> String {
    match problem {
        BrdfError::Range {
            name,
            value,
            least,
            most,
        } => {
            let (is, between) = (language.tr("is"), language.tr("it must be between"));
            let and = language.tr("and");
            format!("{name} {is} {value}; {between} {least} {and} {most}.")
        }
        BrdfError::Missing { name, .. } => format!("{} {name}.", language.tr("Missing:")),
        BrdfError::Energy { what, sum } => {
            let more = language.tr("more than 1 would reflect more than it receives.");
            format!("{what} = {}: {more}", (1e6 * sum).round() / 1e6)
        }
        other => format!("{other}."),
    }
}

/// Whether two materials are the same; models are compared by address.
pub(super) fn is_same_material(a: &Material, b: &Material) -> bool {
    let rest = |m: &Material| {
        (
            m.emission,
            m.emission_picture,
            m.emits_back,
            m.finish,
            m.relief,
            m.lightmap,
        )
    };
    MaterialReflection::of(a) == MaterialReflection::of(b)
        && rest(a) == rest(b)
        && a.name == b.name
        && a.textures == b.textures
}
