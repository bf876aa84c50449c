//! Text to nodes.

use super::node::{Document, Form, IGNORED_FIELDS, Kind, Node, NodeId, Value};
use crate::ReadError;
use crate::reading::text::{shortened, text};
use crate::vrml::lexer::Lexer;
use crate::vrml::stage::{Source, Stage};
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::collections::HashMap;

/// How deep nodes may stand inside one another.
const MOST_NESTED: usize = 256;

/// Reads all nodes of a file.
///
/// # Errors
/// Text without a single node, and nodes nested too deep.
pub(super) fn parse<'a>(stage: &mut Stage, source: &'a Source) -> Result<Document<'a>, ReadError> {
    let mut parser = Parser {
        lexer: Lexer::new(&source.bytes),
        source,
        stage,
        nodes: Vec::new(),
        names: HashMap::new(),
        open: Vec::new(),
    };
    let roots = parser.roots()?;
    Ok(Document {
        nodes: parser.nodes,
        roots,
    })
}

struct Parser<'a, 's, 'f> {
    lexer: Lexer<'a>,
    source: &'a Source,
    stage: &'s mut Stage<'f>,
    nodes: Vec<Node<'a>>,
    /// The latest node of each name, once it has ended: a node cannot be used inside itself.
    names: HashMap<&'a [u8], NodeId>,
    /// The nodes around the place that is read, each with its name.
    open: Vec<Option<&'a [u8]>>,
}

impl<'a> Parser<'a, '_, '_> {
    #[cold]
    fn warn(&mut self, at: usize, message: impl Into<String>) {
        self.stage.warn(self.source, at, message);
    }

    /// Where the next token begins.
    fn here(&mut self) -> usize {
        self.lexer.skip_blanks();
        self.lexer.offset()
    }

    fn roots(&mut self) -> Result<Vec<NodeId>, ReadError> {
        let mut roots = Vec::new();
        let start = self.lexer;
        while !self.lexer.at_end() {
            let at = self.here();
            match self.lexer.word() {
                Some(word) if self.begins_node(word) => roots.extend(self.node(at, word)?),
                Some(word) => self.stray(at, word),
                None => {
                    let found = self.lexer.found();
                    self.warn(at, format!("{found} outside all nodes: skipped"));
                    self.lexer.skip_token();
                }
            }
        }
        match roots.is_empty() {
            true => Err(start.clone().error(&self.source.name, "a node")),
            false => Ok(roots),
        }
    }

    #[cold]
    fn stray(&mut self, at: usize, word: &[u8]) {
        let word = shortened(&text(word));
        self.warn(at, format!("\"{word}\" where a node could be: skipped"));
    }

    /// Whether a word that has been taken begins a node.
    fn begins_node(&mut self, word: &[u8]) -> bool {
        matches!(word, b"DEF" | b"USE") || self.lexer.peek() == Some(b'{')
    }

    /// The rest of a node that begins with `word` at `at`; `None`, with a warning, if it turns
    /// out to be none.
    fn node(&mut self, at: usize, word: &'a [u8]) -> Result<Option<NodeId>, ReadError> {
        match word {
            b"USE" => Ok(self.used(at)),
            b"DEF" => {
                let (Some(name), Some(type_name)) = (self.lexer.word(), self.lexer.word()) else {
                    self.warn(at, "DEF without a name and a node: skipped");
                    return Ok(None);
                };
                if type_name == b"USE" {
                    // Not allowed, but it is clear what is meant.
                    let known = self.used(at);
                    self.names.extend(known.map(|known| (name, known)));
                    return Ok(known);
                }
                let id = self.define(at, type_name, Some(name))?;
                self.names.extend(id.map(|id| (name, id)));
                Ok(id)
            }
            type_name => self.define(at, type_name, None),
        }
    }

    /// The node that USE names.
    fn used(&mut self, at: usize) -> Option<NodeId> {
        let name = self.lexer.word().unwrap_or_default();
        if let Some(&known) = self.names.get(name) {
            return Some(known);
        }
        let shown = shortened(&text(name));
        let why = match self.open.contains(&Some(name)) {
            true => "stands inside the node of that name",
            false => "names no node before it",
        };
        self.warn(at, format!("USE {shown} {why}: skipped"));
        None
    }

    /// A node from its `{` on.
    fn define(
        &mut self,
        at: usize,
        type_name: &'a [u8],
        name: Option<&'a [u8]>,
    ) -> Result<Option<NodeId>, ReadError> {
        if !self.lexer.take(b'{') {
            self.stray(at, type_name);
            return Ok(None);
        }
        if self.open.len() == MOST_NESTED {
            let expected = format!("nodes nested at most {MOST_NESTED} deep");
            return Err(self.lexer.error(&self.source.name, &expected));
        }
        let mut node = Node {
            kind: Kind::named(type_name),
            type_name,
            name: name.map(text),
            at,
            fields: Vec::new(),
            children: Vec::new(),
            has_shapes: false,
        };
        self.open.push(name);
        self.body(&mut node)?;
        self.open.pop();
        node.fields.shrink_to_fit();
        node.children.shrink_to_fit();
        let mut inside = node.children.iter().map(|c| &self.nodes[*c as usize]);
        node.has_shapes = node.kind.is_shape() || inside.any(|child| child.has_shapes);
        self.judge(&node);
        self.nodes.push(node);
        Ok(Some(self.nodes.len() as NodeId - 1))
    }

    /// Says what will become of a node that is not understood.
    fn judge(&mut self, node: &Node) {
        let name = shortened(&text(node.type_name));
        if node.kind == Kind::Unknown {
            let what = match node.children.is_empty() {
                true => "skipped",
                false => "what is inside is read as in a Separator",
            };
            self.warn(node.at, format!("node {name} is not known: {what}"));
        } else if !node.kind.is_group() && !node.children.is_empty() {
            self.warn(node.at, format!("nodes inside {name}: skipped"));
        }
    }

    /// Fields and nodes up to the `}`.
    fn body(&mut self, node: &mut Node<'a>) -> Result<(), ReadError> {
        loop {
            let at = self.here();
            if self.lexer.take(b'}') {
                return Ok(());
            }
            if let Some(word) = self.lexer.word() {
                self.statement(at, word, node)?;
            } else if self.lexer.at_end() {
                self.warn(at, "the file ends inside a node");
                return Ok(());
            } else {
                let found = self.lexer.found();
                self.warn(at, format!("{found} where a field could be: skipped"));
                self.lexer.skip_token();
            }
        }
    }

    /// A field or a node inside a node, behind its first word.
    fn statement(
        &mut self,
        at: usize,
        word: &'a [u8],
        node: &mut Node<'a>,
    ) -> Result<(), ReadError> {
        let mut known = node.kind.fields().iter();
        if let Some(&(name, form)) = known.find(|(name, _)| name.as_bytes() == word) {
            let value = self.value(name, form);
            // Inventor marks values that are not to be used.
            if !self.lexer.take_word(b"~") {
                node.fields.retain(|(other, _)| *other != name);
                node.fields.push((name, value));
            }
        } else if self.begins_node(word) {
            node.children.extend(self.node(at, word)?);
        } else if word == b"fields" && self.lexer.take(b'[') {
            // The values say themselves what type they are of.
            self.lexer.skip_to_close();
        } else if word == b"isA" {
            let names = self.words();
            if node.kind == Kind::Unknown {
                let kinds = names.iter().map(|name| Kind::named(name.as_bytes()));
                node.kind = kinds
                    .into_iter()
                    .find(|k| *k != Kind::Unknown)
                    .unwrap_or(node.kind);
            }
        } else if word == b"alternateRep" && node.kind == Kind::Unknown {
            // The value is a node, which the next turn finds.
        } else {
            self.skip_field(at, word, node);
        }
        Ok(())
    }

    /// Passes the value of a field that is not known. Without its type only its look helps: all
    /// numbers, or one of anything else.
    fn skip_field(&mut self, at: usize, word: &[u8], node: &Node) {
        // The fields of an unknown node are not worth a warning each.
        if node.kind != Kind::Unknown && !IGNORED_FIELDS.contains(&word) {
            let (node, field) = (text(node.type_name), text(word));
            let shown = shortened(&format!("{node}.{field}"));
            self.warn(at, format!("field {shown} is not used"));
        }
        match self.lexer.peek() {
            Some(b'[') => {
                self.lexer.take(b'[');
                self.lexer.skip_to_close();
            }
            Some(b'(') => drop(self.words()),
            Some(b'"') => drop(self.lexer.string()),
            _ if self.lexer.at_number() => while self.lexer.number().is_some() {},
            Some(b'}') | None => {}
            _ => self.skip_word_or_node(),
        }
    }

    fn skip_word_or_node(&mut self) {
        let word = self.lexer.word();
        if word == Some(b"DEF") {
            self.lexer.word();
            self.lexer.word();
        } else if word == Some(b"USE") {
            self.lexer.word();
        } else if word.is_none() {
            self.lexer.skip_token();
        }
        if self.lexer.take(b'{') {
            self.lexer.skip_to_close();
        }
    }

    fn value(&mut self, name: &str, form: Form) -> Value<'a> {
        match form {
            Form::Exactly(count) => Value::Numbers(self.exactly(name, count)),
            Form::Numbers => {
                let mut list = self.list(name, |[x]| x);
                keep_one_of_equals(&mut list);
                Value::Numbers(list)
            }
            Form::Integers => Value::Integers(self.integers(name)),
            Form::Vectors => Value::Vectors(self.list(name, DVec3::from_array)),
            Form::Vectors2 => Value::Vectors2(self.list(name, DVec2::from_array)),
            Form::Colors => {
                let mut list = self.list(name, |[r, g, b]| Rgb::new(r, g, b).map(finite));
                keep_one_of_equals(&mut list);
                Value::Colors(list)
            }
            Form::Words => Value::Words(self.words()),
            Form::Image => Value::Numbers(self.image()),
        }
    }

    fn exactly(&mut self, name: &str, count: usize) -> Vec<f64> {
        let at = self.here();
        let in_brackets = self.lexer.take(b'[');
        let mut numbers = Vec::with_capacity(count);
        self.lexer.numbers(count, &mut numbers);
        if numbers.len() < count {
            self.warn(at, format!("{name} with too few numbers: not used"));
        } else if numbers.iter().any(|n| !n.is_finite()) {
            self.warn(at, format!("{name} with a number that is none: not used"));
        }
        if in_brackets {
            self.lexer.skip_to_close();
        }
        numbers
    }

    /// One value of `N` numbers, or any number of them in brackets.
    fn list<const N: usize, T>(&mut self, name: &str, make: impl Fn([f64; N]) -> T) -> Vec<T> {
        let mut list = Vec::new();
        let in_brackets = self.lexer.take(b'[');
        loop {
            while let Some(value) = self.tuple(name) {
                list.push(make(value));
                if !in_brackets {
                    return list;
                }
            }
            if !in_brackets || self.closes(name) {
                list.shrink_to_fit();
                return list;
            }
        }
    }

    /// `N` numbers; `None` if none comes next or they end too early.
    #[inline]
    fn tuple<const N: usize>(&mut self, name: &str) -> Option<[f64; N]> {
        let mut tuple = [0.0; N];
        for (k, number) in tuple.iter_mut().enumerate() {
            match self.lexer.number() {
                Some(value) => *number = value,
                None => {
                    if k > 0 {
                        let at = self.here();
                        self.warn(
                            at,
                            format!("the last value of {name} is cut short: skipped"),
                        );
                    }
                    return None;
                }
            }
        }
        Some(tuple)
    }

    fn integers(&mut self, name: &str) -> Vec<i32> {
        let mut list = Vec::new();
        if !self.lexer.take(b'[') {
            list.extend(self.lexer.integer());
            return list;
        }
        loop {
            self.lexer.integers(&mut list);
            if self.closes(name) {
                list.shrink_to_fit();
                return list;
            }
        }
    }

    /// Whether a list ends here; otherwise passes what does not belong into it.
    fn closes(&mut self, name: &str) -> bool {
        let at = self.here();
        match self.lexer.peek() {
            Some(b']') => self.lexer.take(b']'),
            // A bracket was forgotten, or the file ends.
            Some(b'}') | None => {
                self.warn(at, format!("{name} has no end"));
                true
            }
            Some(_) => {
                let found = self.lexer.found();
                self.warn(at, format!("{found} among the values of {name}: skipped"));
                self.lexer.skip_token();
                false
            }
        }
    }

    /// A word or a string, several strings in brackets, or words in parentheses.
    fn words(&mut self) -> Vec<Cow<'a, str>> {
        let mut words = Vec::new();
        let (open, close) = match self.lexer.peek() {
            Some(b'[') => (b'[', b']'),
            Some(b'(') => (b'(', b')'),
            _ => {
                words.extend(self.one_word());
                while self.lexer.take(b'|') {
                    words.extend(self.one_word());
                }
                return words;
            }
        };
        self.lexer.take(open);
        while !self.lexer.take(close) && !matches!(self.lexer.peek(), Some(b'}') | None) {
            match self.one_word() {
                Some(word) => words.push(word),
                None if self.lexer.take(b'|') => {}
                None => {
                    self.lexer.skip_token();
                }
            }
        }
        words
    }

    fn one_word(&mut self) -> Option<Cow<'a, str>> {
        if let Some(string) = self.lexer.string() {
            return Some(string);
        }
        let word = self.lexer.word_until(|b| matches!(b, b'(' | b')' | b'|'));
        word.map(text)
    }

    fn image(&mut self) -> Vec<f64> {
        let mut numbers = self.exactly("image", 3);
        if let [width, height, _] = *numbers {
            // Negative sizes become 0, and no file has room for the largest.
            let pixels = (width as usize).saturating_mul(height as usize);
            self.lexer.numbers(pixels, &mut numbers);
        }
        numbers
    }
}

/// A list of equal values says no more than one of them, and costs more wherever it is used.
fn keep_one_of_equals<T: PartialEq>(list: &mut Vec<T>) {
    if list.windows(2).all(|pair| pair[0] == pair[1]) {
        list.truncate(1);
    }
    list.shrink_to_fit();
}

fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}
