//! Blocks: the outer grammar.

use super::document::{
    AreaLight, Block, BlockKind, Body, Definition, Document, Kind, MeshBlock, ObjectNotes, Place,
    Source, Step,
};
use super::extension::Extension;
use super::parser::{Parsed, Parser, Shared};
use crate::reading::lexer::Lexer;
use crate::reading::text::decoded_text;
use crate::{Files, ReadError, Warning};

/// Includes inside includes.
const DEEPEST_INCLUDE: usize = 64;
/// Includes in all: a file of ten lines can ask for more than fit into the world.
const MOST_INCLUDES: usize = 10_000;
/// Bytes of all included files together.
const MOST_INCLUDED_BYTES: usize = 1 << 30;

impl Document {
    /// Reads a file and what it includes.
    ///
    /// `name` is what messages call the file; includes are asked from `files` by their path
    /// from the file's folder.
    ///
    /// # Errors
    /// The first thing that is not GRF: file, line, column, what was found and what expected.
    pub fn parse(
        bytes: &[u8],
        name: &str,
        files: &dyn Files,
    ) -> Result<(Document, Vec<Warning>), ReadError> {
        let text = decoded_text(bytes);
        let mut shared = Shared::new(files);
        let file = shared.sources.push(Source {
            shown: name.to_owned(),
            path: name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned(),
            parent: None,
        });
        let mut parser = Parser::new(&text, file, &mut shared);
        let comments = parser.lexer.leading_comments();
        let blocks = parser.file().map_err(|fail| *fail)?;
        parser.check_names().map_err(|fail| *fail)?;
        let warnings = shared.warnings.finish(shared.sources.shown(0));
        let document = Document {
            comments,
            blocks,
            sources: shared.sources,
        };
        Ok((document, warnings))
    }
}

/// What may follow `end`, and how the block that it ends is called in messages.
pub(super) struct Ending {
    pub words: &'static [&'static str],
    pub is_required: bool,
}

impl Ending {
    pub const fn optional(words: &'static [&'static str]) -> Ending {
        Ending {
            words,
            is_required: false,
        }
    }

    pub const fn required(words: &'static [&'static str]) -> Ending {
        Ending {
            words,
            is_required: true,
        }
    }
}

const TRANSFORM: Ending = Ending::optional(&["transform"]);
const DEFINITIONS: Ending = Ending::optional(&["def"]);
const LIGHT: Ending = Ending::optional(&["light"]);
const PARAMS: Ending = Ending::optional(&["params"]);

/// Words that may follow `end` somewhere, so that a wrong one is noticed.
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

impl<'a> Parser<'a, '_, '_> {
    /// A whole file.
    fn file(&mut self) -> Parsed<Vec<Block>> {
        let blocks = self.blocks()?;
        match self.lexer.peek() {
            None => Ok(blocks),
            Some(_) => Err(self.unexpected("a block; no block is open that this could end")),
        }
    }

    /// Blocks up to `end` or the end of the file, neither of which is read.
    fn blocks(&mut self) -> Parsed<Vec<Block>> {
        let mut blocks = Vec::new();
        let mut named: Option<(usize, ObjectNotes)> = None;
        loop {
            let offset = self.lexer.skip_blank();
            if self.empty_statement(offset) {
                continue;
            }
            // Taken before the inside of the block is read: places are quick in ascending order.
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
                    Extension::Block(kind) => push(&mut blocks, place, *kind, &mut named),
                    Extension::Names(notes) => named = Some((offset, *notes)),
                    Extension::Noted => {}
                }
                continue;
            }
            let kind = self.block(offset)?;
            push(&mut blocks, place, kind, &mut named);
        }
        if let Some((offset, _)) = named {
            self.warn(offset, "an `ext object` names nothing: no object follows");
        }
        Ok(blocks)
    }

    /// `;`, and the `.` that the grammar pages set behind their rules.
    fn empty_statement(&mut self, offset: usize) -> bool {
        if self.lexer.eat(b'.') {
            self.warn(offset, "a lone `.` was skipped");
            return true;
        }
        self.lexer.eat(b';')
    }

    fn block(&mut self, offset: usize) -> Parsed<BlockKind> {
        let lexer = &mut self.lexer;
        if lexer.eat_word("begin") {
            if at_mesh(*lexer) {
                lexer.eat_word("mesh");
                return self.mesh(offset).map(BlockKind::Mesh);
            }
            return self.scope(offset, Vec::new());
        }
        if lexer.eat_word("mesh") {
            let is_light = lexer.eat_word("light");
            self.expect_word("begin")?;
            return if is_light {
                self.mesh_light(offset).map(BlockKind::Mesh)
            } else {
                self.mesh(offset).map(BlockKind::Mesh)
            };
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

    /// `begin` was read: blocks, and the `end` that fits.
    fn nested(
        &mut self,
        offset: usize,
        definitions: &[Definition],
        ending: &Ending,
    ) -> Parsed<Vec<Block>> {
        self.enter(offset)?;
        self.open_scope();
        self.define_all(offset, definitions);
        let blocks = self.blocks()?;
        self.end(offset, ending)?;
        self.close_scope();
        self.leave();
        Ok(blocks)
    }

    /// `end`, and the word behind it if it belongs here.
    pub fn end(&mut self, opened: usize, ending: &Ending) -> Parsed<()> {
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

    fn expected_end(&mut self, opened: usize, ending: &Ending) -> String {
        let line = self.place(opened).line;
        let word = ending.words.first().map_or("", |w| w);
        format!("`end {word}` for the block that begins in line {line}")
    }

    /// `begin` was read after definitions, or alone.
    fn scope(&mut self, offset: usize, definitions: Vec<Definition>) -> Parsed<BlockKind> {
        let blocks = self.nested(offset, &definitions, &DEFINITIONS)?;
        Ok(BlockKind::Definitions {
            definitions,
            blocks: Some(blocks),
        })
    }

    fn define_all(&mut self, offset: usize, definitions: &[Definition]) {
        for definition in definitions {
            self.define(offset, definition.body.kind(), &definition.name);
        }
    }

    /// `def` was read: `id = body`, more of them, and the blocks in which they hold.
    fn definitions(&mut self, offset: usize) -> Parsed<BlockKind> {
        let mut definitions = Vec::new();
        loop {
            let name = self.identifier()?;
            self.expect(b'=')?;
            let body = self.body()?;
            definitions.push(Definition { name, body });
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
    pub fn body(&mut self) -> Parsed<Body> {
        if self.lexer.eat_word("texture") {
            let path = self.file_name()?;
            return Ok(Body::Texture(self.shared.intern(path)));
        }
        if self.lexer.eat_word("rgb") {
            return self.rgb().map(Body::Color);
        }
        if self.lexer.eat_word("brdf") {
            return self.brdf().map(Body::Brdf);
        }
        Err(self.unexpected("`texture`, `rgb` or `brdf`"))
    }

    /// `light` was read.
    fn area_light(&mut self, offset: usize) -> Parsed<BlockKind> {
        self.expect_word("begin")?;
        let mut radiance = self.optional_rgb()?;
        let start = self.lexer.skip_blank();
        // Brackets around the region: `( (` can't begin a vector.
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

    pub fn optional_rgb(&mut self) -> Parsed<Option<azulejo_scene::Rgb>> {
        if self.lexer.eat_word("rgb") {
            self.rgb().map(Some)
        } else {
            Ok(None)
        }
    }

    /// `transform` was read.
    fn transform(&mut self, offset: usize) -> Parsed<BlockKind> {
        let mut steps = Vec::new();
        loop {
            if self.lexer.eat_word("scale") {
                steps.push(Step::Scale(self.vector3()?));
            } else if self.lexer.eat_word("rotation") {
                steps.push(Step::Rotation(self.vector3()?));
            } else if self.lexer.eat_word("translation") {
                steps.push(Step::Translation(self.vector3()?));
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

    /// `params` was read. What stands inside is kept as text, because its words are open.
    fn params(&mut self, offset: usize) -> Parsed<BlockKind> {
        self.expect_word("begin")?;
        let start = self.lexer.skip_blank();
        loop {
            let here = self.lexer.skip_blank();
            match self.lexer.peek_word() {
                Some(word) if word.eq_ignore_ascii_case("end") => {
                    let text = self.lexer.text()[start..here].trim_end().to_owned();
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

    /// `include` was read.
    fn include(&mut self, offset: usize) -> Parsed<BlockKind> {
        let at = self.lexer.skip_blank();
        let name = self.file_name()?;
        let here = self.shared.sources.get(self.file);
        let path = joined(here.map_or("", |s| &s.path), name);
        self.check_include(at, &path)?;
        let bytes = self.shared.files.read(&path).map_err(|problem| {
            self.fail(
                at,
                format!("the include \"{path}\": {problem}"),
                "a file that can be read",
            )
        })?;
        self.shared.includes += 1;
        self.shared.included_bytes = self.shared.included_bytes.saturating_add(bytes.len());
        if self.shared.includes > MOST_INCLUDES || self.shared.included_bytes > MOST_INCLUDED_BYTES
        {
            return Err(self.fail(
                at,
                "one include more",
                format!("at most {MOST_INCLUDES} includes and {MOST_INCLUDED_BYTES} bytes in them"),
            ));
        }
        self.enter(offset)?;
        let line = self.place(at).line;
        let file = self.shared.sources.push(Source {
            shown: path.clone(),
            path,
            parent: Some((self.file, line)),
        });
        let text = decoded_text(&bytes);
        let mut inner = Parser::new(&text, file, self.shared);
        let blocks = inner.file()?;
        inner.keep_open_lines();
        self.leave();
        Ok(BlockKind::Include {
            name: name.to_owned(),
            blocks,
        })
    }

    /// Refuses circles and towers of includes.
    fn check_include(&mut self, at: usize, path: &str) -> Parsed<()> {
        let chain = || self.shared.sources.chain(self.file);
        let depth = chain().count();
        if chain().any(|source| source.path == path) {
            return Err(self.fail(
                at,
                format!("an include of \"{path}\", which leads here"),
                "includes that do not go round in a circle",
            ));
        }
        if depth > DEEPEST_INCLUDE {
            return Err(self.fail(
                at,
                "an include inside an include",
                format!("at most {DEEPEST_INCLUDE} inside each other"),
            ));
        }
        Ok(())
    }

    /// `mesh light begin` was read.
    fn mesh_light(&mut self, offset: usize) -> Parsed<Box<MeshBlock>> {
        let mesh = MeshBlock {
            is_light: true,
            ..MeshBlock::default()
        };
        self.mesh_body(offset, mesh)
    }

    /// `begin mesh` was read.
    fn mesh(&mut self, offset: usize) -> Parsed<Box<MeshBlock>> {
        self.mesh_body(offset, MeshBlock::default())
    }
}

/// Adds a block; an object takes what the `ext object` before it says.
fn push(
    blocks: &mut Vec<Block>,
    place: Place,
    mut kind: BlockKind,
    named: &mut Option<(usize, ObjectNotes)>,
) {
    if let Some(notes) = kind.notes_mut()
        && let Some((_, given)) = named.take()
    {
        notes.name = given.name;
        notes.material = given.material.or(notes.material.take());
    }
    blocks.push(Block { place, kind });
}

impl Body {
    pub fn kind(&self) -> Kind {
        match self {
            Body::Texture(_) => Kind::Texture,
            Body::Color(_) => Kind::Color,
            Body::Brdf(_) => Kind::Brdf,
        }
    }
}

/// Whether after `begin` a mesh follows, rather than a list of blocks of which the first is
/// `mesh light`.
fn at_mesh(mut ahead: Lexer<'_>) -> bool {
    ahead.eat_word("mesh") && !ahead.eat_word("light")
}

/// Whether `id =` and a body follow: one more definition under the same `def`.
fn at_definition(mut ahead: Lexer<'_>) -> bool {
    ahead.word().is_some() && ahead.eat(b'=')
}

/// Whether what follows `end` begins the next block instead of saying what ends.
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

/// The path of a file that another file names, from the folder of the outermost file.
///
/// `..` is taken back against folders that the path already went into; where it leads further
/// out it stays, for [`Files`] to judge.
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
