//! The text format: `begin brdf`, one statement per line, `end brdf`; or a model on one line as in
//! a GRF file.
//!
//! ```text
//! begin brdf
//!   version 1
//!   model cook_torrance
//!   diffuse (0.10, 0.08, 0.05)
//!   param m 0.2
//!   fresnel conductor eta (0.16, 0.42, 1.56) k (3.5, 2.4, 1.9)
//! end brdf
//! ```
//!
//! Words, numbers, lists and comments are those of GRF. `docs/formats/brdf.md` has the grammar.

use super::inline::{self, InlineError, InlineResult, MOST_PARTS, ModelMarks, WeightedModel};
use super::{LoadedBrdf, measured};
use crate::reading::cursor::TextCursor;
use crate::reading::files::beside;
use crate::reading::lexer::Lexer;
use crate::reading::text::decoded_text;
use crate::reading::warnings::Warnings;
use crate::{Files, ReadError};
use azulejo_scene::brdf::{Content, Description, Model, ModelInfo, Parameter, Value, find};
use std::io::{self, Write};
use std::sync::Arc;

/// Maximum depth of nested blocks.
const DEEPEST: usize = 16;

/// The words that begin a statement.
const STATEMENTS: &str =
    "version, model, diffuse, specular, param, fresnel, wavelengths, weight, begin or end";

/// Reads a file.
///
/// # Errors
/// The first error, with its line; for an unknown name, the most similar known one.
pub fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<LoadedBrdf, ReadError> {
    let text = decoded_text(bytes);
    let mut reader = BrdfTextReader {
        lexer: Lexer::new(&text),
        name,
        files,
        layers: 0,
        warnings: Warnings::default(),
        failed: None,
    };
    let read = reader.file();
    let (warnings, failed) = (reader.warnings, reader.failed);
    let description =
        read.map_err(|trouble| failed.unwrap_or_else(|| error(&text, name, trouble)))?;
    Ok(LoadedBrdf {
        content: Content::Text(description),
        warnings: warnings.finish(name),
    })
}

fn error(text: &str, name: &str, trouble: InlineError) -> ReadError {
    TextCursor::new(text).error(name, trouble.offset, trouble.found, trouble.expected)
}

struct BrdfTextReader<'a> {
    lexer: Lexer<'a>,
    name: &'a str,
    files: &'a dyn Files,
    /// Number of models read.
    layers: usize,
    warnings: Warnings,
    /// An error in a file that it refers to.
    failed: Option<ReadError>,
}

/// The content of a block.
#[derive(Default)]
struct BrdfBlock {
    start: usize,
    kind: BlockType,
    weight: f64,
    parameters: Vec<(Parameter, usize)>,
    layers: Vec<WeightedModel>,
}

#[derive(Default)]
enum BlockType {
    #[default]
    None,
    Model(String, usize),
    Layered,
    Measured(Description),
}

impl BrdfTextReader<'_> {
    fn file(&mut self) -> InlineResult<Description> {
        let (description, parts) = if self.lexer.eat_word("begin") {
            self.whole()?
        } else {
            inline::description(&mut self.lexer)?
        };
        if !matches!(description, Description::File { .. }) {
            let brdf = inline::made(&description, &parts)?;
            for doubt in inline::doubts(&brdf) {
                self.warn(0, doubt);
            }
        }
        match self.lexer.peek() {
            None => Ok(description),
            Some(_) => Err(inline::unexpected(self.lexer, "the end of the file")),
        }
    }

    fn warn(&mut self, offset: usize, message: impl Into<String>) {
        let text = TextCursor::new(self.lexer.text());
        self.warnings
            .add(self.name, message.into(), || text.position(offset));
    }

    /// Reads the outermost block, after its `begin`.
    fn whole(&mut self) -> InlineResult<(Description, Vec<WeightedModel>)> {
        let block = self.block(0)?;
        let weight = block.weight;
        if let BlockType::Measured(file) = block.kind {
            return Ok((file, Vec::new()));
        }
        let is_layered = matches!(block.kind, BlockType::Layered);
        let mut parts = self.parts(block)?;
        if let ([part], false) = (&mut parts[..], is_layered || weight != 1.0) {
            part.weight = 1.0;
            return Ok((Description::Model(part.model.clone()), parts));
        }
        let sum = parts.iter().map(|p| (p.weight, p.model.clone())).collect();
        Ok((Description::Combination(sum), parts))
    }

    /// Reads a block after `begin`, up to its `end brdf`.
    fn block(&mut self, depth: usize) -> InlineResult<BrdfBlock> {
        let mut block = BrdfBlock {
            start: self.lexer.skip_blank(),
            weight: 1.0,
            ..BrdfBlock::default()
        };
        if !self.lexer.eat_word("brdf") {
            return Err(inline::unexpected(self.lexer, "`brdf`"));
        }
        loop {
            let mut ahead = self.lexer;
            let offset = ahead.skip_blank();
            let Some(word) = ahead.word() else {
                return Err(inline::unexpected(self.lexer, STATEMENTS));
            };
            let before = std::mem::replace(&mut self.lexer, ahead);
            match word.to_ascii_lowercase().as_str() {
                "version" => self.version()?,
                "model" => self.model(&mut block)?,
                "diffuse" => self.parameter(&mut block, "kd", offset)?,
                "specular" => self.parameter(&mut block, "ks", offset)?,
                "wavelengths" => self.parameter(&mut block, "lambda", offset)?,
                "param" => self.named(&mut block)?,
                "fresnel" => self.fresnel(&mut block)?,
                "weight" => block.weight = self.weight()?,
                "begin" => self.layer(&mut block, depth)?,
                "end" => {
                    self.lexer.eat_word("brdf");
                    return Ok(block);
                }
                _ => return Err(inline::unexpected(before, STATEMENTS)),
            }
        }
    }

    fn version(&mut self) -> InlineResult<()> {
        let before = self.lexer;
        match inline::number(&mut self.lexer, "the version 1")? {
            1.0 => Ok(()),
            _ => Err(inline::unexpected(before, "the version 1")),
        }
    }

    fn weight(&mut self) -> InlineResult<f64> {
        let before = self.lexer;
        let weight = inline::number(&mut self.lexer, "a weight from 0 to 1")?;
        if weight >= 0.0 {
            return Ok(weight);
        }
        Err(inline::unexpected(before, "a weight from 0 to 1"))
    }

    /// Reads `model name`, `model layered` or `model measured "file"`.
    fn model(&mut self, block: &mut BrdfBlock) -> InlineResult<()> {
        let before = self.lexer;
        let offset = self.lexer.skip_blank();
        if !matches!(block.kind, BlockType::None) {
            return Err(inline::unexpected(before, "one `model` in a block"));
        }
        let Some(name) = self.lexer.word() else {
            return Err(inline::unexpected(before, "the name of a reflection model"));
        };
        block.kind = match name.to_ascii_lowercase().as_str() {
            "layered" => BlockType::Layered,
            "measured" => BlockType::Measured(self.measured()?),
            _ => BlockType::Model(name.to_owned(), offset),
        };
        Ok(())
    }

    /// Reads measured data from another file; if that is missing, the surface is black.
    fn measured(&mut self) -> InlineResult<Description> {
        let offset = self.lexer.skip_blank();
        // An unquoted name could contain a quote, and could not be written again.
        let path = (self.lexer.peek() == Some(b'"')).then(|| self.lexer.file_name());
        let Some(path) = path.flatten() else {
            let expected = "a file name, \"in double quotes\"";
            return Err(inline::unexpected(self.lexer, expected));
        };
        let file = beside(self.name, path);
        let content = match self.files.read(&file) {
            Err(problem) => {
                self.warn(offset, format!("brdf \"{path}\" skipped: {problem}"));
                None
            }
            Ok(bytes) => match measured(&bytes, &file) {
                Some(Ok(read)) => {
                    self.warnings.extend(read.warnings);
                    Some(Arc::new(read.content))
                }
                Some(Err(error)) => {
                    self.failed = Some(error);
                    return Err(inline::unexpected(self.lexer, "measured data"));
                }
                None => {
                    return Err(InlineError {
                        offset,
                        found: format!("the file \"{path}\""),
                        expected: "measured data: MERL .binary or RGL .bsdf".to_owned(),
                    });
                }
            },
        };
        Ok(Description::File {
            path: file,
            content,
        })
    }

    /// Reads a statement that is a parameter with another name.
    fn parameter(&mut self, block: &mut BrdfBlock, name: &str, offset: usize) -> InlineResult<()> {
        let value = inline::value(&mut self.lexer)?;
        self.push(block, name, value, offset)
    }

    /// Reads `param name value`; a `=` in between is accepted.
    fn named(&mut self, block: &mut BrdfBlock) -> InlineResult<()> {
        let offset = self.lexer.skip_blank();
        let Some(name) = self.lexer.word() else {
            return Err(inline::unexpected(self.lexer, "the name of a parameter"));
        };
        self.lexer.eat(b'=');
        self.parameter(block, name, offset)
    }

    /// Reads `fresnel conductor eta v k v`, `dielectric eta n`, `schlick f0 v tint v`, `metal name`
    /// or `constant F v`.
    fn fresnel(&mut self, block: &mut BrdfBlock) -> InlineResult<()> {
        let before = self.lexer;
        let offset = self.lexer.skip_blank();
        let kind = self.lexer.word().unwrap_or_default().to_ascii_lowercase();
        let names: &[&str] = match kind.as_str() {
            "metal" => {
                let value = inline::value(&mut self.lexer)?;
                return self.push(block, "metal", value, offset);
            }
            "conductor" => &["eta", "k"],
            "dielectric" => &["eta"],
            "schlick" => &["f0", "tint"],
            "constant" => &["F"],
            _ => {
                let kinds = "conductor, dielectric, schlick, metal or constant";
                return Err(inline::unexpected(before, kinds));
            }
        };
        let mut count = 0;
        while let Some(name) = self.one_of(names) {
            let value = inline::value(&mut self.lexer)?;
            self.push(block, name, value, offset)?;
            count += 1;
        }
        match count {
            0 => Err(inline::unexpected(self.lexer, format!("`{}`", names[0]))),
            _ => Ok(()),
        }
    }

    fn one_of<'n>(&mut self, names: &[&'n str]) -> Option<&'n str> {
        names.iter().copied().find(|name| self.lexer.eat_word(name))
    }

    fn push(
        &mut self,
        block: &mut BrdfBlock,
        name: &str,
        value: Value,
        offset: usize,
    ) -> InlineResult<()> {
        // No model has this many parameters: the error is reported at the end.
        if block.parameters.len() <= MOST_PARTS {
            let name = name.to_owned();
            block.parameters.push((Parameter { name, value }, offset));
        }
        Ok(())
    }

    /// Reads a block inside a layered one.
    fn layer(&mut self, block: &mut BrdfBlock, depth: usize) -> InlineResult<()> {
        if !matches!(block.kind, BlockType::Layered) {
            let expected = "`model layered` before a nested block";
            return Err(inline::unexpected(self.lexer, expected));
        }
        if depth + 1 >= DEEPEST {
            let expected = format!("at most {DEEPEST} nested levels");
            return Err(inline::unexpected(self.lexer, expected));
        }
        let layer = self.block(depth + 1)?;
        let (weight, start) = (layer.weight, layer.start);
        if matches!(layer.kind, BlockType::Measured(_)) {
            return Err(InlineError {
                offset: start,
                found: "measured data as a layer".to_owned(),
                expected: "models only in layers, and measured data in a separate file".into(),
            });
        }
        for mut part in self.parts(layer)? {
            part.weight *= weight;
            block.layers.push(part);
        }
        Ok(())
    }

    /// The models of a complete block, with the weights inside it.
    fn parts(&mut self, block: BrdfBlock) -> InlineResult<Vec<WeightedModel>> {
        // A layered block already has its models; parameters belong to one of them.
        let (name, offset) = match block.kind {
            BlockType::Model(name, offset) => (name, offset),
            BlockType::Layered if block.parameters.is_empty() => return Ok(block.layers),
            BlockType::Layered => {
                let (parameter, offset) = &block.parameters[0];
                return Err(InlineError {
                    offset: *offset,
                    found: format!("`{}` of layers", parameter.name),
                    expected: "parameters inside the blocks of the layers".to_owned(),
                });
            }
            BlockType::None | BlockType::Measured(_) => {
                return Err(InlineError {
                    offset: block.start,
                    found: "a block without `model`".to_owned(),
                    expected: "`model` and the name of a reflection model".to_owned(),
                });
            }
        };
        // The limit is for the layers of all levels together.
        self.layers += 1;
        if self.layers > MOST_PARTS {
            return Err(InlineError {
                offset: block.start,
                found: "one more layer".to_owned(),
                expected: format!("at most {MOST_PARTS} layers"),
            });
        }
        let mut marks = ModelMarks {
            name: offset,
            parameters: Vec::new(),
        };
        // Files may state wavelengths and a Fresnel term for any model: drop those that this one lacks.
        let known = find(&name).ok();
        let mut model = Model {
            name,
            parameters: Vec::new(),
        };
        for (parameter, offset) in block.parameters {
            if let Some(info) = known.filter(|info| is_beside(info, &parameter.name)) {
                let what = match &*parameter.name {
                    "lambda" => "wavelengths",
                    _ => "Fresnel term",
                };
                self.warn(offset, format!("`{}` has no {what}: ignored", info.name));
                continue;
            }
            marks.parameters.push(offset);
            model.parameters.push(parameter);
        }
        Ok(vec![WeightedModel {
            weight: 1.0,
            model,
            marks,
        }])
    }
}

/// Whether a file may contain this for any model, although this one does not use it.
fn is_beside(info: &'static ModelInfo, name: &str) -> bool {
    let general = ["lambda", "eta", "k", "f0", "tint", "metal", "F"];
    general.contains(&name) && !info.all_parameters().any(|p| p.is_called(name))
}

/// Writes a description: [`read`] returns it bit by bit.
///
/// # Errors
/// Those of `out`; a file name with quotes or line ends, which the format cannot represent.
pub fn write(description: &Description, out: &mut dyn Write) -> io::Result<()> {
    match description {
        Description::Model(model) => block(out, model, None, ""),
        Description::Combination(parts) => {
            out.write_all(b"begin brdf\n  version 1\n  model layered\n")?;
            for (weight, model) in parts {
                block(out, model, Some(*weight), "  ")?;
            }
            out.write_all(b"end brdf\n")
        }
        Description::File { path, .. } if path.contains(['"', '\n', '\r']) => {
            let problem = format!("a file name that cannot be quoted: {path:?}");
            Err(io::Error::new(io::ErrorKind::InvalidInput, problem))
        }
        Description::File { path, .. } => writeln!(
            out,
            "begin brdf\n  version 1\n  model measured \"{path}\"\nend brdf"
        ),
    }
}

fn block(out: &mut dyn Write, model: &Model, weight: Option<f64>, margin: &str) -> io::Result<()> {
    writeln!(out, "{margin}begin brdf")?;
    match weight {
        Some(weight) => writeln!(out, "{margin}  weight {weight:?}")?,
        None => writeln!(out, "{margin}  version 1")?,
    }
    writeln!(out, "{margin}  model {}", model.name)?;
    for Parameter { name, value } in &model.parameters {
        let statement = match name.as_str() {
            "kd" => "diffuse".to_owned(),
            "ks" => "specular".to_owned(),
            _ => format!("param {name}"),
        };
        match value {
            Value::Number(x) => writeln!(out, "{margin}  {statement} {x:?}")?,
            Value::Color(c) => {
                writeln!(
                    out,
                    "{margin}  {statement} ({:?}, {:?}, {:?})",
                    c.r, c.g, c.b
                )?;
            }
            Value::Word(word) => writeln!(out, "{margin}  {statement} {word}")?,
        }
    }
    writeln!(out, "{margin}end brdf")
}
