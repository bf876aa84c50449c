//! Blocks: the outer grammar.

use super::document::{
    AreaLight, BlockKind, BoxedError, DefinitionBody, GrfBlock, GrfDefinition, GrfDocument,
    GrfSource, NameKind, ObjectNotes, SourcePosition, TransformStep,
};
use super::extension::Extension;
use super::layout::{GrfLayout, IncludeLayout, ObjectLayout};
use super::parser::{GrfParser, ParseResult, SharedParserState};
use crate::reading::lexer::Lexer;
use crate::reading::text::decoded_text;
use crate::{Files, ReadError, Warning};
use std::sync::Arc;

/// Maximum depth of nested includes.
const DEEPEST_INCLUDE: usize = 64;
/// Maximum number of includes in all: ten lines can include more than any memory holds.
const MOST_INCLUDES: usize = 10_000;
/// Maximum size of all included files together, bytes.
const MOST_INCLUDED_BYTES: usize = 1 << 30;

impl GrfDocument {
    /// Parses a file and its includes.
    ///
    /// `name` is the file's name in messages; includes are requested from `files` by their path
    /// relative to the file's folder.
    ///
    /// # Errors
    /// The first syntax error: file, line, column, what was found and what was expected.
    pub fn parse(
        bytes: &[u8],
        name: &str,
        files: &dyn Files,
    ) -> Result<(GrfDocument, Vec<Warning>), ReadError> {
        let parsed = GrfDocument::parse_with(bytes, name, files, None)?;
        Ok((parsed.document, parsed.warnings))
    }

    /// The same, with the places of everything if there is a `layout` to record them.
    pub(super) fn parse_with(
        bytes: &[u8],
        name: &str,
        files: &dyn Files,
        layout: Option<Box<GrfLayout>>,
    ) -> Result<PlacedDocument, ReadError> {
        let text = decoded_text(bytes);
        let mut shared = SharedParserState::new(files);
        shared.layout = layout;
        if let Some(layout) = &mut shared.layout {
            layout.texts.push(text.clone().into_owned());
        }
        let file = shared.sources.push(GrfSource {
            shown: name.to_owned(),
            path: name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned(),
            parent: None,
        });
        let mut parser = GrfParser::new(&text, file, &mut shared);
        let comments = parser.lexer.leading_comments();
        let blocks = parser.file().map_err(|fail| *fail)?;
        parser.check_names().map_err(|fail| *fail)?;
        let warnings = shared.warnings.finish(shared.sources.shown(0));
        let document = GrfDocument {
            comments,
            blocks,
            sources: shared.sources,
        };
        Ok(PlacedDocument {
            document,
            layout: shared.layout.unwrap_or_default(),
            warnings,
        })
    }
}

/// A document, and where its parts stand if a layout was requested.
pub(super) struct PlacedDocument {
    pub document: GrfDocument,
    pub layout: Box<GrfLayout>,
    pub warnings: Vec<Warning>,
}

/// The words that may follow `end`, and the name of the block in messages.
pub(super) struct BlockEnd {
    pub words: &'static [&'static str],
    pub is_required: bool,
}

impl BlockEnd {
    pub const fn optional(words: &'static [&'static str]) -> BlockEnd {
        BlockEnd {
            words,
            is_required: false,
        }
    }

    pub const fn required(words: &'static [&'static str]) -> BlockEnd {
        BlockEnd {
            words,
            is_required: true,
        }
    }
}

const TRANSFORM: BlockEnd = BlockEnd::optional(&["transform"]);
const DEFINITIONS: BlockEnd = BlockEnd::optional(&["def"]);
const LIGHT: BlockEnd = BlockEnd::optional(&["light"]);
const PARAMS: BlockEnd = BlockEnd::optional(&["params"]);

/// All words that may follow `end`, to detect a wrong one.
const CLOSERS: [&str; 10] = [
    "mesh",
    "light",
    "faces",
    "vertices",
    "vertexs",
    "def",
    "transform",
    "params",
    "ext",
    "brdf",
];

impl<'a> GrfParser<'a, '_, '_> {
    /// Reads a whole file.
    fn file(&mut self) -> ParseResult<Vec<GrfBlock>> {
        let blocks = self.blocks()?;
        match self.lexer.peek() {
            None => Ok(blocks),
            Some(_) => Err(self.unexpected("a block; no block is open that this could end")),
        }
    }

    /// Reads blocks up to `end` or the end of the file, neither of which is consumed.
    fn blocks(&mut self) -> ParseResult<Vec<GrfBlock>> {
        let mut blocks = Vec::new();
        let mut named: Option<(usize, ObjectNotes)> = None;
        loop {
            let offset = self.lexer.skip_blank();
            if self.empty_statement(offset) {
                continue;
            }
            // Determined before the block is read: locating is fast in ascending order.
            let place = self.place(offset);
            let Some(word) = self.lexer.peek_word() else {
                if self.lexer.peek().is_none() {
                    break;
                }
                return Err(self.unexpected("a block"));
            };
            if word.eq_ignore_ascii_case("end") {
                break;
            }
            if word.eq_ignore_ascii_case("ext") {
                match self.extension(blocks.last_mut())? {
                    Extension::Block(mut kind) => {
                        self.record(&mut kind);
                        push(&mut blocks, place, *kind, &mut named);
                    }
                    Extension::Names(notes) => named = Some((offset, *notes)),
                    Extension::Noted => self.record_note(offset),
                }
                continue;
            }
            let mut kind = self.block(offset)?;
            self.record(&mut kind);
            push(&mut blocks, place, kind, &mut named);
        }
        if let Some((offset, _)) = named {
            self.warn(offset, "`ext object` without an object after it");
        }
        Ok(blocks)
    }

    /// Records the place of a block that makes an object, after it was read.
    fn record(&mut self, kind: &mut BlockKind) {
        let (file, end) = (self.file, self.lexer.pos());
        if let Some(layout) = &mut self.shared.layout {
            let vertices = std::mem::take(&mut layout.open_vertices);
            let faces = std::mem::take(&mut layout.open_faces);
            if kind.notes_mut().is_some() {
                layout.objects.push(ObjectLayout {
                    file,
                    end,
                    vertices,
                    faces,
                    notes: Vec::new(),
                });
            }
        }
    }

    /// Records a text whose vocabulary is open.
    pub fn record_opaque(&mut self, start: usize, end: usize) {
        if let Some(layout) = &mut self.shared.layout {
            layout.opaque.push((self.file, start..end));
        }
    }

    /// Records the place of an extension that belongs to the object before it.
    fn record_note(&mut self, offset: usize) {
        let end = self.lexer.pos();
        if let Some(layout) = &mut self.shared.layout {
            layout.open_vertices.clear();
            layout.open_faces.clear();
            let mut note = Lexer::new(&self.lexer.text()[offset..end]);
            note.eat_word("ext");
            let name = note.word().unwrap_or("").to_ascii_lowercase();
            if let Some(object) = layout.objects.last_mut() {
                object.notes.push((name, offset..end));
            }
        }
    }

    /// `;`, and the `.` that ends the rules on the grammar pages.
    fn empty_statement(&mut self, offset: usize) -> bool {
        if self.lexer.eat(b'.') {
            self.warn(offset, "single `.`: skipped");
            return true;
        }
        self.lexer.eat(b';')
    }

    fn block(&mut self, offset: usize) -> ParseResult<BlockKind> {
        let lexer = &mut self.lexer;
        if lexer.eat_word("begin") {
            if at_mesh(*lexer) {
                lexer.eat_word("mesh");
                return self.mesh(offset, false);
            }
            return self.scope(offset, Vec::new());
        }
        if lexer.eat_word("mesh") {
            let is_light = lexer.eat_word("light");
            self.expect_word("begin")?;
            return self.mesh(offset, is_light);
        }
        if lexer.eat_word("light") {
            return self.area_light(offset);
        }
        if lexer.eat_word("include") {
            return self.include(offset);
        }
        if lexer.eat_word("transform") {
            return self.transform(offset);
        }
        if lexer.eat_word("def") {
            return self.definitions(offset);
        }
        if lexer.eat_word("params") {
            return self.params(offset);
        }
        Err(self.unexpected(
            "a block: `begin mesh`, `mesh light`, `light`, `include`, `transform`, `def`, `params` or `ext`",
        ))
    }

    /// Reads nested blocks, after `begin`, and the matching `end`.
    fn nested(
        &mut self,
        offset: usize,
        definitions: &[GrfDefinition],
        ending: &BlockEnd,
    ) -> ParseResult<Vec<GrfBlock>> {
        self.enter(offset)?;
        self.open_scope();
        self.define_all(offset, definitions);
        let blocks = self.blocks()?;
        self.end(offset, ending)?;
        self.close_scope();
        self.leave();
        Ok(blocks)
    }

    /// Reads `end`, and the word after it if it belongs to it.
    pub fn end(&mut self, opened: usize, ending: &BlockEnd) -> ParseResult<()> {
        let start = self.lexer.skip_blank();
        if !self.lexer.eat_word("end") {
            let expected = self.expected_end(opened, ending);
            return Err(self.unexpected(expected));
        }
        let word = self.lexer.peek_word().unwrap_or("");
        let is = |list: &[&str]| list.iter().any(|w| word.eq_ignore_ascii_case(w));
        let belongs = is(ending.words) && (ending.is_required || !starts_block(self.lexer));
        if belongs {
            self.lexer.word();
        } else if ending.is_required || (is(&CLOSERS) && !starts_block(self.lexer)) {
            let found = match word {
                "" => "`end`".to_owned(),
                _ => format!("`end {word}`"),
            };
            let expected = self.expected_end(opened, ending);
            return Err(self.fail(start, found, expected));
        }
        Ok(())
    }

    fn expected_end(&mut self, opened: usize, ending: &BlockEnd) -> String {
        let line = self.place(opened).line;
        let word = ending.words.first().map_or("", |w| w);
        format!("`end {word}` for the block that begins in line {line}")
    }

    /// Reads a scope, after its definitions and `begin`, or after `begin` alone.
    fn scope(&mut self, offset: usize, definitions: Vec<GrfDefinition>) -> ParseResult<BlockKind> {
        let blocks = self.nested(offset, &definitions, &DEFINITIONS)?;
        Ok(BlockKind::Definitions {
            definitions,
            blocks: Some(blocks),
        })
    }

    fn define_all(&mut self, offset: usize, definitions: &[GrfDefinition]) {
        for definition in definitions {
            self.define(offset, definition.body.kind(), &definition.name);
        }
    }

    /// Reads definitions, after `def`: `id = body`, more of them, and the blocks in which they
    /// hold.
    fn definitions(&mut self, offset: usize) -> ParseResult<BlockKind> {
        let mut definitions = Vec::new();
        loop {
            let at = self.lexer.skip_blank();
            let name = self.identifier()?;
            self.expect(b'=')?;
            let body = self.body()?;
            self.record_definition(at, body.kind(), &name);
            definitions.push(GrfDefinition { name, body });
            if !self.lexer.eat_word("def") && !at_definition(self.lexer) {
                break;
            }
        }
        let mut ahead = self.lexer;
        if ahead.eat_word("begin") && !at_mesh(ahead) {
            self.lexer = ahead;
            return self.scope(offset, definitions);
        }
        self.define_all(offset, &definitions);
        Ok(BlockKind::Definitions {
            definitions,
            blocks: None,
        })
    }

    /// `texture file`, `rgb (r, g, b)`, or `brdf` with a file or a model.
    pub fn body(&mut self) -> ParseResult<DefinitionBody> {
        if self.lexer.eat_word("texture") {
            let path = self.file_name()?;
            return Ok(DefinitionBody::Texture(self.shared.intern(path)));
        }
        if self.lexer.eat_word("rgb") {
            return self.rgb().map(DefinitionBody::Color);
        }
        if self.lexer.eat_word("brdf") {
            return self.brdf().map(DefinitionBody::Brdf);
        }
        Err(self.unexpected("`texture`, `rgb` or `brdf`"))
    }

    /// Reads an area light, after `light`.
    fn area_light(&mut self, offset: usize) -> ParseResult<BlockKind> {
        self.expect_word("begin")?;
        let mut radiance = self.optional_rgb()?;
        let start = self.lexer.skip_blank();
        // Brackets around the region: a vector cannot begin with `( (`.
        let mut ahead = self.lexer;
        let is_bracketed = ahead.eat(b'(') && ahead.eat(b'(');
        if is_bracketed {
            self.expect(b'(')?;
        }
        let [corner, a, b] = [self.vector3()?, self.vector3()?, self.vector3()?];
        if is_bracketed {
            self.expect(b')')?;
        }
        radiance = self.optional_rgb()?.or(radiance);
        if !super::has_area(a, b) {
            return Err(self.fail(
                start,
                "a light without area",
                "a corner and two edges that span a parallelogram",
            ));
        }
        self.end(offset, &LIGHT)?;
        Ok(BlockKind::AreaLight(Box::new(AreaLight {
            corner,
            edges: [a, b],
            radiance,
            notes: ObjectNotes::default(),
        })))
    }

    pub fn optional_rgb(&mut self) -> ParseResult<Option<azulejo_scene::Rgb>> {
        if self.lexer.eat_word("rgb") {
            self.rgb().map(Some)
        } else {
            Ok(None)
        }
    }

    /// Reads a transform, after `transform`.
    fn transform(&mut self, offset: usize) -> ParseResult<BlockKind> {
        let mut steps = Vec::new();
        loop {
            if self.lexer.eat_word("scale") {
                steps.push(TransformStep::Scale(self.vector3()?));
            } else if self.lexer.eat_word("rotation") {
                steps.push(TransformStep::Rotation(self.vector3()?));
            } else if self.lexer.eat_word("translation") {
                steps.push(TransformStep::Translation(self.vector3()?));
            } else if !steps.is_empty() && self.lexer.eat_word("begin") {
                break;
            } else {
                let or_begin = if steps.is_empty() { "" } else { " or `begin`" };
                return Err(
                    self.unexpected(format!("`scale`, `rotation`, `translation`{or_begin}"))
                );
            }
        }
        let blocks = self.nested(offset, &[], &TRANSFORM)?;
        Ok(BlockKind::Transform { steps, blocks })
    }

    /// Reads parameters, after `params`. Their text is kept verbatim, because their vocabulary is
    /// open.
    fn params(&mut self, offset: usize) -> ParseResult<BlockKind> {
        self.expect_word("begin")?;
        let start = self.lexer.skip_blank();
        loop {
            let here = self.lexer.skip_blank();
            match self.lexer.peek_word() {
                Some(word) if word.eq_ignore_ascii_case("end") => {
                    let text = self.lexer.text()[start..here].trim_end().to_owned();
                    self.record_opaque(start, start + text.len());
                    self.end(offset, &PARAMS)?;
                    return Ok(BlockKind::Params(text));
                }
                Some(word) if word.eq_ignore_ascii_case("view") => {
                    self.lexer.word();
                    self.vector3()?;
                }
                _ => {
                    if !self.lexer.skip_any() {
                        return Err(self.unexpected("parameters, and `end params`"));
                    }
                }
            }
        }
    }

    /// Reads an include, after `include`.
    fn include(&mut self, offset: usize) -> ParseResult<BlockKind> {
        let at = self.lexer.skip_blank();
        let name = self.file_name()?;
        let blocks = self.included(offset, at, name)?;
        let name = name.to_owned();
        Ok(BlockKind::Include { name, blocks })
    }

    /// The blocks of the file `name`, whose name is at `at`; a file that was included before is not
    /// read again.
    fn included(
        &mut self,
        offset: usize,
        at: usize,
        name: &str,
    ) -> ParseResult<Arc<Vec<GrfBlock>>> {
        if self.is_alone() {
            return Ok(Arc::default());
        }
        let here = self.shared.sources.get(self.file);
        let path = joined(here.map_or("", |s| &s.path), name);
        self.check_include(at, &path)?;
        self.shared.includes += 1;
        if self.shared.includes > MOST_INCLUDES {
            return Err(self.too_many_includes(at));
        }
        if let Some((blocks, levels)) = self.known_include(&path) {
            self.check_levels(offset, levels)?;
            return Ok(blocks);
        }
        let bytes = self.shared.files.read(&path).map_err(|problem| {
            let found = format!("the include \"{path}\": {problem}");
            self.fail(at, found, "a file that can be read")
        })?;
        self.shared.included_bytes = self.shared.included_bytes.saturating_add(bytes.len());
        if self.shared.included_bytes > MOST_INCLUDED_BYTES {
            return Err(self.too_many_includes(at));
        }
        self.included_text(offset, at, path, &decoded_text(&bytes))
    }

    /// Parses the text of an included file, in which the depth of nested blocks is counted anew, so that
    /// other includes of the same file know it.
    fn included_text(
        &mut self,
        offset: usize,
        at: usize,
        path: String,
        text: &str,
    ) -> ParseResult<Arc<Vec<GrfBlock>>> {
        let (depth, deepest) = (self.shared.depth, self.shared.deepest);
        self.shared.deepest = depth;
        self.enter(offset)?;
        let line = self.place(at).line;
        let file = self.shared.sources.push(GrfSource {
            shown: path.clone(),
            path: path.clone(),
            parent: Some((self.file, line)),
        });
        if let Some(layout) = &mut self.shared.layout {
            layout.texts.push(text.to_owned());
            layout.includes.push(IncludeLayout {
                file: self.file,
                range: offset..self.lexer.pos(),
                target: file,
            });
        }
        self.open_scope();
        let mut inner = GrfParser::new(text, file, self.shared);
        let blocks = Arc::new(inner.file()?);
        inner.keep_open_lines();
        self.leave();
        let levels = self.shared.deepest - depth;
        self.shared.deepest = self.shared.deepest.max(deepest);
        self.close_include(at, path, &blocks, levels);
        Ok(blocks)
    }

    fn too_many_includes(&mut self, at: usize) -> BoxedError {
        self.fail(
            at,
            "one more include",
            format!("at most {MOST_INCLUDES} includes with {MOST_INCLUDED_BYTES} bytes in all"),
        )
    }

    /// Rejects cyclic and deeply nested includes.
    fn check_include(&mut self, at: usize, path: &str) -> ParseResult<()> {
        let chain = || self.shared.sources.chain(self.file);
        let depth = chain().count();
        if chain().any(|source| source.path == path) {
            return Err(self.fail(
                at,
                format!("an include of \"{path}\", which is being included already"),
                "includes without a cycle",
            ));
        }
        if depth > DEEPEST_INCLUDE {
            return Err(self.fail(
                at,
                "an include inside an include",
                format!("at most {DEEPEST_INCLUDE} nested levels"),
            ));
        }
        Ok(())
    }
}

/// Adds a block; an object gets the attributes of a preceding `ext object`.
fn push(
    blocks: &mut Vec<GrfBlock>,
    place: SourcePosition,
    mut kind: BlockKind,
    named: &mut Option<(usize, ObjectNotes)>,
) {
    if let Some(notes) = kind.notes_mut()
        && let Some((_, given)) = named.take()
    {
        notes.name = given.name;
        notes.material = given.material.or(notes.material.take());
    }
    blocks.push(GrfBlock { place, kind });
}

impl DefinitionBody {
    pub fn kind(&self) -> NameKind {
        match self {
            DefinitionBody::Texture(_) => NameKind::Texture,
            DefinitionBody::Color(_) => NameKind::Color,
            DefinitionBody::Brdf(_) => NameKind::Brdf,
        }
    }
}

/// Whether `begin` is followed by a mesh, rather than by a list of blocks that starts with `mesh
/// light`.
fn at_mesh(mut ahead: Lexer<'_>) -> bool {
    ahead.eat_word("mesh") && !ahead.eat_word("light")
}

/// Whether `id =` and a body follow: one more definition of the same `def`.
fn at_definition(mut ahead: Lexer<'_>) -> bool {
    ahead.word().is_some() && ahead.eat(b'=')
}

/// Whether the text after `end` begins the next block instead of naming what ends.
fn starts_block(mut ahead: Lexer<'_>) -> bool {
    if ahead.eat_word("mesh") {
        return ahead.eat_word("light") && ahead.eat_word("begin") && at_lists(ahead);
    }
    if ahead.eat_word("light") {
        return ahead.eat_word("begin") && at_region(ahead);
    }
    if ahead.eat_word("transform") {
        let next = ahead.peek_word().unwrap_or("");
        return ["scale", "rotation", "translation"]
            .iter()
            .any(|w| next.eq_ignore_ascii_case(w));
    }
    ahead.eat_word("def") && at_definition(ahead)
}

/// Whether the body of a `mesh light` follows: `[rgb v3] begin vertices`.
fn at_lists(mut ahead: Lexer<'_>) -> bool {
    skip_rgb(&mut ahead);
    ahead.eat_word("begin") && ahead.peek_word().is_some_and(super::mesh::is_vertices)
}

/// Whether the body of an area light follows: `[rgb v3] (`.
fn at_region(mut ahead: Lexer<'_>) -> bool {
    skip_rgb(&mut ahead);
    ahead.eat(b'(')
}

fn skip_rgb(ahead: &mut Lexer<'_>) {
    if ahead.eat_word("rgb") && ahead.eat(b'(') {
        while ahead.number().is_ok() {
            ahead.eat(b',');
        }
        ahead.eat(b')');
    }
}

/// The path of a file named in another file, relative to the folder of the outermost file.
///
/// `..` is resolved against folders that are part of the path; where it leads further up it is
/// kept, and [`Files`] decides.
pub(super) fn joined(from: &str, name: &str) -> String {
    let name = name.replace('\\', "/");
    if name.starts_with('/') || name.contains(':') {
        return name;
    }
    let folder = from.rfind('/').map_or("", |end| &from[..end]);
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(name.split('/')) {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|p| *p != "..") => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::joined;

    #[test]
    fn includes_are_relative_to_their_file() {
        assert_eq!(joined("room.grf", "lamp.grf"), "lamp.grf");
        assert_eq!(joined("a/b/c.grf", "..\\d.grf"), "a/d.grf");
        assert_eq!(joined("a.grf", "../d.grf"), "../d.grf");
        assert_eq!(joined("a.grf", "/etc/passwd"), "/etc/passwd");
    }
}
