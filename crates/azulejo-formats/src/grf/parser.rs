//! Parser state and helpers common to all parts of the grammar: position, errors, known names.

use super::brdf::GrfReflection;
use super::document::{BoxedError, GrfBlock, GrfName, GrfSources, NameKind, SourcePosition};
use super::layout::{GrfLayout, NameLayout};
use crate::reading::cursor::{Locator, line_around};
use crate::reading::lexer::{BadNumber, Lexer};
use crate::reading::warnings::Warnings;
use crate::{Files, Position};
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

pub(super) type ParseResult<T> = Result<T, BoxedError>;

/// Maximum depth of nested blocks and includes: sufficient for any practical scene, and few enough
/// for the smallest stack of a thread.
const DEEPEST: usize = 256;

/// Parses one file; an included file gets its own parser.
pub(super) struct GrfParser<'a, 's, 'f> {
    pub lexer: Lexer<'a>,
    pub file: u32,
    pub shared: &'s mut SharedParserState<'f>,
    locator: Locator,
}

/// State shared by all files of a document.
pub(super) struct SharedParserState<'f> {
    pub files: &'f dyn Files,
    pub sources: GrfSources,
    pub warnings: Warnings,
    pub depth: usize,
    /// Current depth of nested solids.
    pub solid_depth: usize,
    pub includes: usize,
    pub included_bytes: usize,
    /// Every distinct brdf of the document, by its text.
    pub reflections: HashMap<String, Arc<GrfReflection>>,
    /// The number of those that are neither diffuse nor mirrors.
    pub models: usize,
    /// Where everything stands, if a layout is requested.
    pub layout: Option<Box<GrfLayout>>,
    /// The greatest depth so far.
    pub deepest: usize,
    /// The files included so far, by path.
    known_includes: HashMap<String, KnownInclude>,
    names: HashSet<GrfName>,
    scopes: Vec<ParseScope>,
}

/// An included file that has been read.
pub(super) struct KnownInclude {
    pub blocks: Arc<Vec<GrfBlock>>,
    /// Levels of blocks inside of it.
    pub levels: usize,
    /// What it defines, and the names that it leaves open.
    names: ParseScope,
}

/// The names of one list of blocks.
#[derive(Clone, Default)]
struct ParseScope {
    defined: HashSet<(NameKind, GrfName)>,
    /// Names used, but not defined yet: a definition may still follow in this list or an enclosing
    /// one.
    pending: HashMap<(NameKind, GrfName), PendingName>,
}

/// The first use of a name without a definition.
#[derive(Clone)]
struct PendingName {
    place: SourcePosition,
    offset: usize,
    source_line: Option<String>,
}

/// How far before an error its line may begin to be shown: lines are kept for many names that
/// turn out to be defined.
const LONGEST_LINE: usize = 10_000;

/// Longest line kept for each unresolved name of an included file.
const KEPT_LINE: usize = 200;

impl<'f> SharedParserState<'f> {
    pub fn new(files: &'f dyn Files) -> SharedParserState<'f> {
        SharedParserState {
            files,
            sources: GrfSources::default(),
            warnings: Warnings::default(),
            depth: 0,
            solid_depth: 0,
            includes: 0,
            included_bytes: 0,
            reflections: HashMap::new(),
            models: 0,
            layout: None,
            deepest: 0,
            known_includes: HashMap::new(),
            names: HashSet::new(),
            scopes: vec![ParseScope::default()],
        }
    }

    /// The shared copy of a name.
    pub fn intern(&mut self, name: &str) -> GrfName {
        if let Some(known) = self.names.get(name) {
            return known.clone();
        }
        let new = GrfName::from(name);
        self.names.insert(new.clone());
        new
    }
}

impl<'a, 's, 'f> GrfParser<'a, 's, 'f> {
    pub fn new(
        text: &'a str,
        file: u32,
        shared: &'s mut SharedParserState<'f>,
    ) -> GrfParser<'a, 's, 'f> {
        GrfParser {
            lexer: Lexer::new(text),
            file,
            shared,
            locator: Locator::default(),
        }
    }

    pub fn place(&mut self, offset: usize) -> SourcePosition {
        let (line, column) = self.locator.locate(self.lexer.text(), offset);
        SourcePosition {
            file: self.file,
            line,
            column,
        }
    }

    /// An error at an offset.
    #[cold]
    pub fn fail(
        &mut self,
        offset: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> BoxedError {
        let place = self.place(offset);
        let mut fail = self.shared.sources.fail(place, found, expected);
        fail.source_line = line_around(self.lexer.text().as_bytes(), offset, LONGEST_LINE);
        fail
    }

    /// An error about the next token.
    #[cold]
    pub fn unexpected(&mut self, expected: impl Into<String>) -> BoxedError {
        let offset = self.lexer.skip_blank();
        self.fail(offset, self.lexer.describe(), expected)
    }

    /// A warning at an offset.
    #[cold]
    pub fn warn(&mut self, offset: usize, message: impl Into<String>) {
        let SharedParserState {
            sources, warnings, ..
        } = &mut *self.shared;
        let (locator, text) = (&mut self.locator, self.lexer.text());
        let file = sources.shown(self.file);
        warnings.add(file, message.into(), || {
            let (line, column) = locator.locate(text, offset);
            Position::Line(line, column)
        });
    }

    pub fn expect(&mut self, mark: u8) -> ParseResult<()> {
        if self.lexer.eat(mark) {
            Ok(())
        } else {
            Err(self.unexpected(format!("`{}`", char::from(mark))))
        }
    }

    pub fn expect_word(&mut self, keyword: &str) -> ParseResult<()> {
        if self.lexer.eat_word(keyword) {
            Ok(())
        } else {
            Err(self.unexpected(format!("`{keyword}`")))
        }
    }

    /// An identifier.
    pub fn identifier(&mut self) -> ParseResult<GrfName> {
        match self.lexer.word() {
            Some(word) => Ok(self.shared.intern(word)),
            None => Err(self.unexpected("a name: letters, digits, `_`, `$`")),
        }
    }

    /// A file name.
    pub fn file_name(&mut self) -> ParseResult<&'a str> {
        let start = self.lexer.skip_blank();
        let Some(name) = self.lexer.file_name() else {
            return Err(self.unexpected("a file name, \"in double quotes\" on one line"));
        };
        if let Some(layout) = &mut self.shared.layout {
            layout.names.push(NameLayout {
                file: self.file,
                range: start..self.lexer.pos(),
                name: name.to_owned(),
            });
        }
        Ok(name)
    }

    pub fn number(&mut self) -> ParseResult<f64> {
        self.lexer
            .number()
            .map_err(|bad| self.bad_number(bad, "a number"))
    }

    pub fn index(&mut self) -> ParseResult<u32> {
        self.lexer
            .index()
            .map_err(|bad| self.bad_number(bad, "the index of a vertex, an integer from 0"))
    }

    #[cold]
    fn bad_number(&mut self, bad: BadNumber, expected: &str) -> BoxedError {
        match bad {
            BadNumber::TooLarge => self.unexpected(format!("{expected} that is not so large")),
            BadNumber::Missing | BadNumber::Malformed => self.unexpected(expected),
        }
    }

    /// Reads the comma between two numbers; a blank is accepted, too.
    fn comma(&mut self) -> ParseResult<()> {
        let end = self.lexer.pos();
        if self.lexer.eat(b',') {
            return Ok(());
        }
        let next = self.lexer.skip_blank();
        if next == end || !self.lexer.at_number() {
            return Err(self.unexpected("`,`"));
        }
        self.warn(next, "missing comma between two numbers");
        Ok(())
    }

    fn numbers<const N: usize>(&mut self) -> ParseResult<[f64; N]> {
        self.expect(b'(')?;
        let mut numbers = [0.0; N];
        for (k, number) in numbers.iter_mut().enumerate() {
            if k > 0 {
                self.comma()?;
            }
            *number = self.number()?;
        }
        self.expect(b')')?;
        Ok(numbers)
    }

    /// `( x , y , z )`
    pub fn vector3(&mut self) -> ParseResult<DVec3> {
        self.numbers().map(DVec3::from_array)
    }

    /// `( u , v )`
    pub fn vector2(&mut self) -> ParseResult<DVec2> {
        self.numbers().map(DVec2::from_array)
    }

    /// `( x , y )` or `( x , y , z )`
    pub fn vector2_or_3(&mut self) -> ParseResult<(DVec2, Option<f64>)> {
        self.expect(b'(')?;
        let x = self.number()?;
        self.comma()?;
        let pair = DVec2::new(x, self.number()?);
        if self.lexer.eat(b')') {
            return Ok((pair, None));
        }
        self.comma()?;
        let z = self.number()?;
        self.expect(b')')?;
        Ok((pair, Some(z)))
    }

    /// `( r , g , b )` of light or colour: negative values become 0.
    pub fn rgb(&mut self) -> ParseResult<Rgb> {
        let offset = self.lexer.skip_blank();
        let rgb = Rgb::from(self.numbers()?);
        Ok(self.not_negative(offset, rgb))
    }

    pub fn not_negative(&mut self, offset: usize, rgb: Rgb) -> Rgb {
        if rgb.r >= 0.0 && rgb.g >= 0.0 && rgb.b >= 0.0 {
            return rgb;
        }
        self.warn(offset, "negative colour or light: read as 0");
        rgb.map(|x| x.max(0.0))
    }

    /// Enters a nested block or include.
    pub fn enter(&mut self, offset: usize) -> ParseResult<()> {
        self.shared.depth += 1;
        self.check_levels(offset, 0)
    }

    /// Rejects `more` nested blocks if they exceed the greatest depth.
    pub fn check_levels(&mut self, offset: usize, more: usize) -> ParseResult<()> {
        let depth = self.shared.depth + more;
        self.shared.deepest = self.shared.deepest.max(depth);
        if depth <= DEEPEST {
            return Ok(());
        }
        Err(self.fail(
            offset,
            "one more nested block",
            format!("at most {DEEPEST} nested levels"),
        ))
    }

    pub fn leave(&mut self) {
        self.shared.depth -= 1;
    }

    pub fn open_scope(&mut self) {
        self.shared.scopes.push(ParseScope::default());
    }

    /// Ends a list of blocks: names that it used without defining them must come from an enclosing
    /// list.
    pub fn close_scope(&mut self) {
        let Some(closed) = self.shared.scopes.pop() else {
            return;
        };
        let Some(outer) = self.shared.scopes.last_mut() else {
            return;
        };
        for (key, pending) in closed.pending {
            if !closed.defined.contains(&key) && !outer.defined.contains(&key) {
                outer.pending.entry(key).or_insert(pending);
            }
        }
    }

    /// The blocks of a file that was included before, if no layout is requested; its names are
    /// defined here, too.
    pub fn known_include(&mut self, path: &str) -> Option<(Arc<Vec<GrfBlock>>, usize)> {
        let known = self.shared.known_includes.get(path)?;
        let (blocks, levels) = (known.blocks.clone(), known.levels);
        let names = known.names.clone();
        self.take_names(names, None);
        Some((blocks, levels))
    }

    /// Ends the scope of an included file, whose names hold in the list that includes it, and keeps the
    /// file for other includes. `levels` are those of blocks inside of it.
    pub fn close_include(
        &mut self,
        offset: usize,
        path: String,
        blocks: &Arc<Vec<GrfBlock>>,
        levels: usize,
    ) {
        let names = self.shared.scopes.pop().unwrap_or_default();
        if self.shared.layout.is_none() {
            let known = KnownInclude {
                blocks: blocks.clone(),
                levels,
                names: names.clone(),
            };
            self.shared.known_includes.insert(path, known);
        }
        self.take_names(names, Some(offset));
    }

    /// Adds names to the current list; definitions that it has already are reported at `offset`.
    fn take_names(&mut self, names: ParseScope, offset: Option<usize>) {
        for (key, pending) in names.pending {
            let scope = self.innermost();
            if !names.defined.contains(&key) && !scope.defined.contains(&key) {
                scope.pending.entry(key).or_insert(pending);
            }
        }
        for (kind, name) in names.defined {
            match offset {
                Some(offset) => self.define(offset, kind, &name),
                None => {
                    self.innermost().defined.insert((kind, name));
                }
            }
        }
    }

    fn innermost(&mut self) -> &mut ParseScope {
        // The outermost scope is closed at the end of the outermost file only.
        let scopes = &mut self.shared.scopes;
        if scopes.is_empty() {
            scopes.push(ParseScope::default());
        }
        let last = scopes.len() - 1;
        &mut scopes[last]
    }

    /// Defines a name in the current list of blocks.
    pub fn define(&mut self, offset: usize, kind: NameKind, name: &GrfName) {
        if !self.innermost().defined.insert((kind, name.clone())) {
            self.warn(
                offset,
                format!("`{name}` is defined twice: the last definition is used"),
            );
        }
    }

    /// Records the place of a definition.
    pub fn record_definition(&mut self, offset: usize, kind: NameKind, name: &GrfName) {
        let file = self.file;
        if let Some(layout) = &mut self.shared.layout {
            let entry = (file, offset, kind, name.clone());
            layout.definitions.push(entry);
        }
    }

    /// Reads the name after `use color|brdf|texture`, which must be defined in an enclosing scope.
    pub fn used(&mut self, kind: NameKind) -> ParseResult<GrfName> {
        let offset = self.lexer.skip_blank();
        let name = self.identifier()?;
        self.note_use(offset, kind, &name);
        Ok(name)
    }

    pub fn note_use(&mut self, offset: usize, kind: NameKind, name: &GrfName) {
        let key = (kind, name.clone());
        if let Some(layout) = &mut self.shared.layout {
            layout.uses.insert(key.clone());
        }
        let is_known = self.innermost().pending.contains_key(&key)
            || self
                .shared
                .scopes
                .iter()
                .rev()
                .any(|s| s.defined.contains(&key));
        if is_known {
            return;
        }
        let pending = PendingName {
            place: self.place(offset),
            offset,
            source_line: None,
        };
        self.innermost().pending.insert(key, pending);
    }

    /// Keeps the lines of unresolved names of this file, because its text is about to be dropped.
    pub fn keep_open_lines(&mut self) {
        let (text, file) = (self.lexer.text(), self.file);
        for pending in self.innermost().pending.values_mut() {
            if pending.place.file == file && pending.source_line.is_none() {
                let line = line_around(text.as_bytes(), pending.offset, KEPT_LINE);
                pending.source_line = line.filter(|line| line.len() <= KEPT_LINE);
            }
        }
    }

    /// Whether other files are left alone.
    pub fn is_alone(&self) -> bool {
        self.shared.layout.as_ref().is_some_and(|l| l.is_alone)
    }

    /// At the end of the outermost file, checks that every name is defined.
    pub fn check_names(&mut self) -> ParseResult<()> {
        let scope = std::mem::take(self.innermost());
        let open = scope
            .pending
            .into_iter()
            .filter(|(key, _)| !scope.defined.contains(key))
            .min_by_key(|(_, p)| (p.place.file, p.offset));
        let Some(((kind, name), pending)) = open.filter(|_| !self.is_alone()) else {
            return Ok(());
        };
        let (word, maker) = (kind.word(), kind.maker());
        let mut fail = self.shared.sources.fail(
            pending.place,
            format!("`{name}`, which no enclosing `{maker}` defines as a {word}"),
            format!("a {word} that is defined in this block or an enclosing one"),
        );
        fail.source_line = if pending.place.file == self.file {
            line_around(self.lexer.text().as_bytes(), pending.offset, LONGEST_LINE)
        } else {
            pending.source_line
        };
        Err(fail)
    }
}

impl NameKind {
    /// The statement that defines names of this type.
    fn maker(self) -> &'static str {
        match self {
            NameKind::Texture | NameKind::Color | NameKind::Brdf => "def",
            NameKind::Figure => "ext figure",
            NameKind::Solid => "ext define",
        }
    }

    /// The keyword after `use`, also used in messages.
    pub fn word(self) -> &'static str {
        match self {
            NameKind::Texture => "texture",
            NameKind::Color => "color",
            NameKind::Brdf => "brdf",
            NameKind::Figure => "figure",
            NameKind::Solid => "solid",
        }
    }
}
