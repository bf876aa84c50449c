//! What every part of the parser needs: where it stands, what went wrong, which names are known.

use super::brdf::Reflection;
use super::document::{Fail, Kind, Name, Place, Sources};
use crate::reading::cursor::{Locator, line_around};
use crate::reading::lexer::{BadNumber, Lexer};
use crate::reading::warnings::Warnings;
use crate::{Files, Position};
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

pub(super) type Parsed<T> = Result<T, Fail>;

/// Blocks and includes that may stand inside each other. Enough for any scene that a person or
/// an exporter makes; few enough for the smallest stack of a thread.
const DEEPEST: usize = 256;

/// Reads one file; an included file gets its own.
pub(super) struct Parser<'a, 's, 'f> {
    pub lexer: Lexer<'a>,
    pub file: u32,
    pub shared: &'s mut Shared<'f>,
    locator: Locator,
}

/// What all files of a document share.
pub(super) struct Shared<'f> {
    pub files: &'f dyn Files,
    pub sources: Sources,
    pub warnings: Warnings,
    pub depth: usize,
    /// Solids inside solids.
    pub solid_depth: usize,
    pub includes: usize,
    pub included_bytes: usize,
    /// Every brdf of the document once, by its text.
    pub reflections: HashMap<String, Arc<Reflection>>,
    /// How many of them are more than matt or a mirror.
    pub models: usize,
    names: HashSet<Name>,
    scopes: Vec<Scope>,
}

/// The names of one list of blocks.
#[derive(Default)]
struct Scope {
    defined: HashSet<(Kind, Name)>,
    /// Used, and not defined yet: a definition may still follow in this list or outside it.
    pending: HashMap<(Kind, Name), Pending>,
}

/// The first use of a name without definition.
struct Pending {
    place: Place,
    offset: usize,
    source_line: Option<String>,
}

/// How far before an error its line may begin to be shown; many errors are prepared for nothing.
const LONGEST_LINE: usize = 10_000;

/// Longest line that is kept for each unknown name of an included file.
const KEPT_LINE: usize = 200;

impl<'f> Shared<'f> {
    pub fn new(files: &'f dyn Files) -> Shared<'f> {
        Shared {
            files,
            sources: Sources::default(),
            warnings: Warnings::default(),
            depth: 0,
            solid_depth: 0,
            includes: 0,
            included_bytes: 0,
            reflections: HashMap::new(),
            models: 0,
            names: HashSet::new(),
            scopes: vec![Scope::default()],
        }
    }

    /// The one copy of a name.
    pub fn intern(&mut self, name: &str) -> Name {
        if let Some(known) = self.names.get(name) {
            return known.clone();
        }
        let new = Name::from(name);
        self.names.insert(new.clone());
        new
    }
}

impl<'a, 's, 'f> Parser<'a, 's, 'f> {
    pub fn new(text: &'a str, file: u32, shared: &'s mut Shared<'f>) -> Parser<'a, 's, 'f> {
        Parser {
            lexer: Lexer::new(text),
            file,
            shared,
            locator: Locator::default(),
        }
    }

    pub fn place(&mut self, offset: usize) -> Place {
        let (line, column) = self.locator.locate(self.lexer.text(), offset);
        Place {
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
    ) -> Fail {
        let place = self.place(offset);
        let mut fail = self.shared.sources.fail(place, found, expected);
        fail.source_line = line_around(self.lexer.text().as_bytes(), offset, LONGEST_LINE);
        fail
    }

    /// An error about what comes next.
    #[cold]
    pub fn unexpected(&mut self, expected: impl Into<String>) -> Fail {
        let offset = self.lexer.skip_blank();
        self.fail(offset, self.lexer.describe(), expected)
    }

    /// Something mended or skipped at an offset.
    #[cold]
    pub fn warn(&mut self, offset: usize, message: impl Into<String>) {
        let Shared {
            sources, warnings, ..
        } = &mut *self.shared;
        let (locator, text) = (&mut self.locator, self.lexer.text());
        let file = sources.shown(self.file);
        warnings.add(file, message.into(), || {
            let (line, column) = locator.locate(text, offset);
            Position::Line(line, column)
        });
    }

    pub fn expect(&mut self, wanted: u8) -> Parsed<()> {
        if self.lexer.eat(wanted) {
            Ok(())
        } else {
            Err(self.unexpected(format!("`{}`", char::from(wanted))))
        }
    }

    pub fn expect_word(&mut self, keyword: &str) -> Parsed<()> {
        if self.lexer.eat_word(keyword) {
            Ok(())
        } else {
            Err(self.unexpected(format!("`{keyword}`")))
        }
    }

    /// An identifier.
    pub fn identifier(&mut self) -> Parsed<Name> {
        match self.lexer.word() {
            Some(word) => Ok(self.shared.intern(word)),
            None => Err(self.unexpected("a name: letters, digits, `_`, `$`")),
        }
    }

    /// A file name.
    pub fn file_name(&mut self) -> Parsed<&'a str> {
        match self.lexer.file_name() {
            Some(name) => Ok(name),
            None => Err(self.unexpected("a file name, \"in double quotes\" on one line")),
        }
    }

    pub fn number(&mut self) -> Parsed<f64> {
        self.lexer
            .number()
            .map_err(|bad| self.bad_number(bad, "a number"))
    }

    pub fn index(&mut self) -> Parsed<u32> {
        self.lexer
            .index()
            .map_err(|bad| self.bad_number(bad, "the index of a vertex, a whole number from 0"))
    }

    #[cold]
    fn bad_number(&mut self, bad: BadNumber, expected: &str) -> Fail {
        match bad {
            BadNumber::TooLarge => self.unexpected(format!("{expected} that is not so large")),
            BadNumber::Missing | BadNumber::Malformed => self.unexpected(expected),
        }
    }

    /// The comma between two numbers, for which a blank is accepted.
    fn comma(&mut self) -> Parsed<()> {
        let end = self.lexer.pos();
        if self.lexer.eat(b',') {
            return Ok(());
        }
        let next = self.lexer.skip_blank();
        if next == end || !self.lexer.at_number() {
            return Err(self.unexpected("`,`"));
        }
        self.warn(next, "a comma is missing between two numbers");
        Ok(())
    }

    fn numbers<const N: usize>(&mut self) -> Parsed<[f64; N]> {
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
    pub fn vector3(&mut self) -> Parsed<DVec3> {
        self.numbers().map(DVec3::from_array)
    }

    /// `( u , v )`
    pub fn vector2(&mut self) -> Parsed<DVec2> {
        self.numbers().map(DVec2::from_array)
    }

    /// `( x , y )` or `( x , y , z )`
    pub fn vector2_or_3(&mut self) -> Parsed<(DVec2, Option<f64>)> {
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

    /// `( r , g , b )` of light or colour: what is negative becomes 0.
    pub fn rgb(&mut self) -> Parsed<Rgb> {
        let offset = self.lexer.skip_blank();
        let rgb = Rgb::from(self.numbers()?);
        Ok(self.not_negative(offset, rgb))
    }

    pub fn not_negative(&mut self, offset: usize, rgb: Rgb) -> Rgb {
        if rgb.r >= 0.0 && rgb.g >= 0.0 && rgb.b >= 0.0 {
            return rgb;
        }
        self.warn(offset, "a colour or light is negative; read as 0");
        rgb.map(|x| x.max(0.0))
    }

    /// Goes one block or include deeper.
    pub fn enter(&mut self, offset: usize) -> Parsed<()> {
        self.shared.depth += 1;
        if self.shared.depth <= DEEPEST {
            return Ok(());
        }
        Err(self.fail(
            offset,
            "one more block inside a block",
            format!("at most {DEEPEST} inside each other"),
        ))
    }

    pub fn leave(&mut self) {
        self.shared.depth -= 1;
    }

    pub fn open_scope(&mut self) {
        self.shared.scopes.push(Scope::default());
    }

    /// Ends a list of blocks: names that it used and did not define must come from outside.
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

    fn innermost(&mut self) -> &mut Scope {
        // The outermost scope is never closed before the end of the outermost file.
        let scopes = &mut self.shared.scopes;
        if scopes.is_empty() {
            scopes.push(Scope::default());
        }
        let last = scopes.len() - 1;
        &mut scopes[last]
    }

    /// Makes a name known in the list of blocks that is being read.
    pub fn define(&mut self, offset: usize, kind: Kind, name: &Name) {
        if !self.innermost().defined.insert((kind, name.clone())) {
            self.warn(
                offset,
                format!("`{name}` is defined twice; the last definition holds"),
            );
        }
    }

    /// Reads the name after `use color|brdf|texture`, which must be defined somewhere around.
    pub fn used(&mut self, kind: Kind) -> Parsed<Name> {
        let offset = self.lexer.skip_blank();
        let name = self.identifier()?;
        self.note_use(offset, kind, &name);
        Ok(name)
    }

    pub fn note_use(&mut self, offset: usize, kind: Kind, name: &Name) {
        let key = (kind, name.clone());
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
        let pending = Pending {
            place: self.place(offset),
            offset,
            source_line: None,
        };
        self.innermost().pending.insert(key, pending);
    }

    /// Keeps the lines of names that this file leaves open, because its text is about to go.
    pub fn keep_open_lines(&mut self) {
        let (text, file) = (self.lexer.text(), self.file);
        for pending in self.innermost().pending.values_mut() {
            if pending.place.file == file && pending.source_line.is_none() {
                let line = line_around(text.as_bytes(), pending.offset, KEPT_LINE);
                pending.source_line = line.filter(|line| line.len() <= KEPT_LINE);
            }
        }
    }

    /// At the end of the outermost file: every name must have been defined.
    pub fn check_names(&mut self) -> Parsed<()> {
        let scope = std::mem::take(self.innermost());
        let open = scope
            .pending
            .into_iter()
            .filter(|(key, _)| !scope.defined.contains(key))
            .min_by_key(|(_, p)| (p.place.file, p.offset));
        let Some(((kind, name), pending)) = open else {
            return Ok(());
        };
        let (word, maker) = (kind.word(), kind.maker());
        let mut fail = self.shared.sources.fail(
            pending.place,
            format!("`{name}`, which no `{maker}` around it makes a {word}"),
            format!("a {word} that is defined in this block or around it"),
        );
        fail.source_line = if pending.place.file == self.file {
            line_around(self.lexer.text().as_bytes(), pending.offset, LONGEST_LINE)
        } else {
            pending.source_line
        };
        Err(fail)
    }
}

impl Kind {
    /// What defines names of this kind.
    fn maker(self) -> &'static str {
        match self {
            Kind::Texture | Kind::Color | Kind::Brdf => "def",
            Kind::Figure => "ext figure",
            Kind::Solid => "ext define",
        }
    }

    /// The keyword after `use`, and what messages call it.
    pub fn word(self) -> &'static str {
        match self {
            Kind::Texture => "texture",
            Kind::Color => "color",
            Kind::Brdf => "brdf",
            Kind::Figure => "figure",
            Kind::Solid => "solid",
        }
    }
}
