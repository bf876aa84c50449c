//! A description while it is changed, and the model that is made of it in the background.

use super::latest::{Latest, Worker};
use super::optics::{Optics, is_same_description, is_same_model};
use super::theme::{notice, problem};
use crate::words::Language;
use azulejo::scene::brdf::{BrdfError, Description};
use azulejo::scene::{Brdf, Material};
use azulejo::trace::{Cancelled, Progress};
use egui::{Context, Ui};
use std::sync::Arc;
use std::time::Duration;

/// A frame waits as long for a model, so that most changes are there at once.
const WAIT: Duration = Duration::from_millis(12);

/// What a person makes of a model.
pub(super) struct Draft {
    /// May be impossible; the document then keeps the last one that was not.
    pub description: Description,
    /// The model that the document has.
    taken: Arc<Brdf>,
    making: Latest<Key, Result<Made, BrdfError>>,
    worker: Worker,
}

/// A model that reflects no more than arrives, and what it was before.
#[derive(Clone)]
struct Made {
    brdf: Arc<Brdf>,
    /// Share of even light that the description reflects, of the channel that reflects most.
    reflected: f64,
}

#[derive(Clone)]
struct Key(Description);

impl PartialEq for Key {
    fn eq(&self, other: &Key) -> bool {
        is_same_description(&self.0, &other.0)
    }
}

fn make(
    key: &Key,
    _: &Progress,
    show: &mut dyn FnMut(Result<Made, BrdfError>),
) -> Result<(), Cancelled> {
    show(Brdf::new(key.0.clone()).map(|brdf| Made {
        reflected: brdf.mean_reflectance().max_channel(),
        brdf: Arc::new(brdf).limited(),
    }));
    Ok(())
}

impl Draft {
    pub fn new(taken: Arc<Brdf>) -> Draft {
        Draft {
            description: taken.description().clone(),
            taken,
            making: Latest::default(),
            worker: Worker::new("brdf model"),
        }
    }

    /// Whether it is a draft of what the document has, and not of what it had.
    pub fn is_of(&self, brdf: &Arc<Brdf>) -> bool {
        is_same_model(Some(&self.taken), Some(brdf))
    }

    /// A model that the document does not have yet.
    pub fn made(&mut self, ctx: &Context) -> Option<Arc<Brdf>> {
        let key = Key(self.description.clone());
        self.making.ask(&key, make, &self.worker, ctx);
        self.making.wait(WAIT);
        let (Key(made_of), made) = self.making.found()?;
        let made = made.as_ref().ok()?;
        if is_same_description(made_of, self.taken.description()) {
            return None;
        }
        self.taken = made.brdf.clone();
        Some(made.brdf.clone())
    }

    /// Whether what becomes of the description is not known yet.
    pub fn is_busy(&self) -> bool {
        self.making.of(&Key(self.description.clone())).is_none()
    }

    /// Says what is wrong with the description, or what becomes of it.
    pub fn say(&self, ui: &mut Ui, language: Language) {
        match self.making.of(&Key(self.description.clone())) {
            None => {
                ui.spinner();
            }
            Some(Err(wrong)) => {
                let kept = language.say("The last possible model is kept.");
                problem(ui, &format!("{} {kept}", problem_words(language, wrong)));
            }
            Some(Ok(made)) if made.reflected > 1.0 + 1e-3 => {
                let words = language.say("This model reflects more than arrives: of even light");
                let scaled = language.say("scaled down to");
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

/// What is wrong, in the person's language as far as it is common.
fn problem_words(language: Language, problem: &BrdfError) -> String {
    match problem {
        BrdfError::Range {
            name,
            value,
            least,
            most,
        } => {
            let (is, between) = (language.say("is"), language.say("it must be between"));
            let and = language.say("and");
            format!("{name} {is} {value}; {between} {least} {and} {most}.")
        }
        BrdfError::Missing { name, .. } => format!("{} {name}.", language.say("Missing:")),
        BrdfError::Energy { what, sum } => {
            let more = language.say("more than 1 would reflect more than arrives.");
            format!("{what} = {}: {more}", (1e6 * sum).round() / 1e6)
        }
        other => format!("{other}."),
    }
}

/// Whether two materials are the same; models by what they are in memory.
pub(super) fn is_same_material(a: &Material, b: &Material) -> bool {
    let rest = |m: &Material| (m.emission, m.emits_back);
    Optics::of(a) == Optics::of(b)
        && rest(a) == rest(b)
        && a.name == b.name
        && a.textures == b.textures
}
