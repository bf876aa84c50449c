//! `brdf`: a file, or a model with its parameters.

use super::entries::GrfEntries;
use super::parser::{GrfParser, ParseResult};
use crate::FileError;
use crate::brdf::inline::{self, InlineError, WeightedModel};
use crate::surface::model::color;
use azulejo_scene::brdf::{BrdfError, Description, Model, find};
use azulejo_scene::{Brdf, Rgb};
use std::sync::Arc;

/// Maximum number of distinct models in a document, diffuse surfaces and mirrors apart. Each may
/// take milliseconds to construct, but only a few bytes of a file.
const MOST_MODELS: usize = 1 << 12;

/// By how much the reflectances of a diffuse surface and a mirror may exceed 1 after rounding in a
/// file.
const ROUNDING: f64 = 1e-6;

/// A reflection model as given in the file, and the brdf constructed from it.
#[derive(Clone, Debug)]
pub(super) struct GrfReflection {
    pub description: Description,
    /// `None` if a diffuse reflectance and a mirror represent it.
    pub brdf: Option<Arc<Brdf>>,
}

impl From<&Arc<Brdf>> for GrfReflection {
    fn from(brdf: &Arc<Brdf>) -> GrfReflection {
        GrfReflection {
            description: brdf.description().clone(),
            brdf: Some(brdf.clone()),
        }
    }
}

/// Reflectances of surfaces that need no model.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PlainReflectance {
    pub diffuse: Rgb,
    pub mirror: Rgb,
}

/// The reflectances of a description that consists of diffuse and mirror reflection.
pub(super) fn plain(description: &Description) -> Option<PlainReflectance> {
    let mut sum = PlainReflectance::default();
    let mut add = |weight: f64, model: &Model| {
        match find(&model.name).ok()?.name {
            "diffuse" => sum.diffuse += weight * color(model, "kd").unwrap_or(Rgb::BLACK),
            "specular" => sum.mirror += weight * color(model, "ks").unwrap_or(Rgb::WHITE),
            _ => return None,
        }
        Some(())
    };
    match description {
        Description::Model(model) => add(1.0, model)?,
        Description::Combination(parts) => {
            parts
                .iter()
                .try_for_each(|(weight, model)| add(*weight, model))?;
        }
        Description::File { .. } => return None,
    }
    Some(sum)
}

/// Whether a description defines a diffuse reflectance, by which a colour beside it is multiplied.
pub(super) fn has_diffuse(description: &Description) -> bool {
    let says = |model: &Model| color(model, "kd").is_some() || model.name == "specular";
    match description {
        Description::Model(model) => says(model),
        Description::Combination(parts) => parts.iter().any(|(_, model)| says(model)),
        Description::File { content, .. } => content.is_some(),
    }
}

impl<'a> GrfParser<'a, '_, '_> {
    /// Reads what follows `brdf`.
    pub fn brdf(&mut self) -> ParseResult<Arc<GrfReflection>> {
        let offset = self.lexer.skip_blank();
        let mut ahead = self.lexer;
        match ahead.word() {
            Some(word) if inline::is_model(word) || inline::at_parameter(ahead) => {
                let parsed = inline::description(&mut self.lexer);
                let (description, parts) = parsed.map_err(|t| self.trouble(t))?;
                self.reflection(offset, description, &parts)
            }
            _ => {
                let path = self.file_name()?;
                self.brdf_file(offset, path)
            }
        }
    }

    #[cold]
    fn trouble(&mut self, trouble: InlineError) -> super::document::BoxedError {
        self.fail(trouble.offset, trouble.found, trouble.expected)
    }

    /// The shared instance of a description.
    fn reflection(
        &mut self,
        offset: usize,
        description: Description,
        parts: &[WeightedModel],
    ) -> ParseResult<Arc<GrfReflection>> {
        let text = description.to_string();
        if let Some(known) = self.shared.reflections.get(&text) {
            return Ok(known.clone());
        }
        let made = match plain(&description) {
            Some(plain) => {
                self.check_plain(offset, plain, parts)?;
                None
            }
            None => Some(self.made(offset, &description, parts)?),
        };
        Ok(self.keep(text, description, made))
    }

    fn keep(
        &mut self,
        text: String,
        description: Description,
        brdf: Option<Arc<Brdf>>,
    ) -> Arc<GrfReflection> {
        let reflection = Arc::new(GrfReflection { description, brdf });
        self.shared.reflections.insert(text, reflection.clone());
        reflection
    }

    /// A sum of a diffuse surface and a mirror may have a weight of 1 for both.
    fn check_plain(
        &mut self,
        offset: usize,
        plain: PlainReflectance,
        parts: &[WeightedModel],
    ) -> ParseResult<()> {
        inline::check(parts).map_err(|t| self.trouble(t))?;
        let sum = (plain.diffuse + plain.mirror).max_channel();
        if sum <= 1.0 + ROUNDING {
            return Ok(());
        }
        let what = "a reflectance".to_owned();
        let (found, expected) = inline::in_words(&BrdfError::Energy { what, sum });
        Err(self.fail(offset, found, expected))
    }

    fn made(
        &mut self,
        offset: usize,
        description: &Description,
        parts: &[WeightedModel],
    ) -> ParseResult<Arc<Brdf>> {
        if self.shared.models == MOST_MODELS {
            let expected = format!("at most {MOST_MODELS} distinct ones");
            return Err(self.fail(offset, "one more reflection model", expected));
        }
        self.shared.models += 1;
        let made = inline::made(description, parts).map_err(|t| self.trouble(t))?;
        for doubt in inline::doubts(&made) {
            self.warn(offset, doubt);
        }
        Ok(made)
    }

    /// The brdf file that an extension names.
    pub fn take_brdf_file(
        &mut self,
        entries: &mut GrfEntries<'a>,
    ) -> ParseResult<Option<Arc<GrfReflection>>> {
        let offset = entries.offset;
        match self.take_text(entries, "brdf_file")? {
            Some(path) => self.brdf_file(offset, &path).map(Some),
            None => Ok(None),
        }
    }

    /// The content of a brdf file; `None`, with a warning, if it cannot be read.
    fn brdf_file(&mut self, offset: usize, name: &str) -> ParseResult<Arc<GrfReflection>> {
        let here = self.shared.sources.get(self.file);
        let path = match here {
            Some(source) if source.path.contains('/') => super::parse::joined(&source.path, name),
            _ => name.to_owned(),
        };
        if self.is_alone() {
            return Ok(Arc::new(GrfReflection {
                description: Description::File {
                    path,
                    content: None,
                },
                brdf: None,
            }));
        }
        let key = format!("\"{path}\"");
        if let Some(known) = self.shared.reflections.get(&key) {
            return Ok(known.clone());
        }
        let content = match self.shared.files.read(&path) {
            Ok(bytes) => Some(self.brdf_content(offset, &path, &bytes)?),
            Err(problem) => {
                self.warn(offset, missing(&path, &problem));
                None
            }
        };
        let description = Description::File { path, content };
        let brdf = self.made(offset, &description, &[])?;
        Ok(self.keep(key, description, Some(brdf)))
    }

    fn brdf_content(
        &mut self,
        offset: usize,
        path: &str,
        bytes: &[u8],
    ) -> ParseResult<Arc<azulejo_scene::brdf::Content>> {
        match crate::brdf::read(bytes, path, self.shared.files) {
            Ok(read) => {
                for warning in read.warnings {
                    self.warn(offset, format!("{warning}"));
                }
                Ok(Arc::new(read.content))
            }
            Err(mut error) => {
                let line = self.place(offset).line;
                let mut chain = self.fail(offset, "", "").included_from;
                let shown = self.shared.sources.get(self.file).map(|s| s.shown.clone());
                chain.push((shown.unwrap_or_default(), line));
                error.included_from = chain;
                Err(Box::new(error))
            }
        }
    }
}

fn missing(path: &str, problem: &FileError) -> String {
    format!("brdf \"{path}\" skipped, its surface is diffuse: {problem}")
}
