//! Parses text into nodes.

use super::node::{IGNORED_FIELDS, NodeId, V1Document, V1FieldType, V1Node, V1NodeKind, V1Value};
use crate::ReadError;
use crate::reading::text::{shortened, text};
use crate::vrml::builder::{VrmlSceneBuilder, VrmlSource};
use crate::vrml::lexer::VrmlLexer;
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::collections::HashMap;

/// Maximum depth of nested nodes.
const MOST_NESTED: usize = 256;

/// Parses all nodes of a file.
///
/// # Errors
/// Text without a single node, and nodes nested too deeply.
pub(super) fn parse<'a>(
    builder: &mut VrmlSceneBuilder,
    source: &'a VrmlSource,
) -> Result<V1Document<'a>, ReadError> {
    let mut parser = V1Parser {
        lexer: VrmlLexer::new(&source.bytes),
        source,
        builder,
        nodes: Vec::new(),
        names: HashMap::new(),
        open: Vec::new(),
    };
    let roots = parser.roots()?;
    Ok(V1Document {
        nodes: parser.nodes,
        roots,
    })
}

struct V1Parser<'a, 's, 'f> {
    lexer: VrmlLexer<'a>,
    source: &'a VrmlSource,
    builder: &'s mut VrmlSceneBuilder<'f>,
    nodes: Vec<V1Node<'a>>,
    /// The latest node of each name, once it is complete: a node cannot be used inside itself.
    names: HashMap<&'a [u8], NodeId>,
    /// The enclosing nodes, each with its name.
    open: Vec<Option<&'a [u8]>>,
}

impl<'a> V1Parser<'a, '_, '_> {
    #[cold]
    fn warn(&mut self, at: usize, message: impl Into<String>) {
        self.builder.warn(self.source, at, message);
    }

    /// The offset of the next token.
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
                    let token = self.lexer.found();
                    self.warn(at, format!("{token} outside all nodes: skipped"));
                    self.lexer.skip_token();
                }
            }
        }
        if roots.is_empty() {
            Err(start.clone().error(&self.source.name, "a node"))
        } else {
            Ok(roots)
        }
    }

    #[cold]
    fn stray(&mut self, at: usize, word: &[u8]) {
        let word = shortened(&text(word));
        self.warn(at, format!("\"{word}\" instead of a node: skipped"));
    }

    /// Whether a word that has been taken begins a node.
    fn begins_node(&mut self, word: &[u8]) -> bool {
        matches!(word, b"DEF" | b"USE") || self.lexer.peek() == Some(b'{')
    }

    /// Reads the rest of a node that begins with `word` at `at`; `None`, with a warning, if it is
    /// not a node.
    fn node(&mut self, at: usize, word: &'a [u8]) -> Result<Option<NodeId>, ReadError> {
        match word {
            b"USE" => Ok(self.used(at)),
            b"DEF" => {
                let (Some(name), Some(type_name)) = (self.lexer.word(), self.lexer.word()) else {
                    self.warn(at, "DEF without a name and a node: skipped");
                    return Ok(None);
                };
                if type_name == b"USE" {
                    // Not allowed, but the meaning is clear.
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

    /// The node that USE refers to.
    fn used(&mut self, at: usize) -> Option<NodeId> {
        let name = self.lexer.word().unwrap_or_default();
        if let Some(&known) = self.names.get(name) {
            return Some(known);
        }
        let shown = shortened(&text(name));
        let why = if self.open.contains(&Some(name)) {
            "refers to the node that contains it"
        } else {
            "refers to no node before it"
        };
        self.warn(at, format!("USE {shown} {why}: skipped"));
        None
    }

    /// Reads a node from its `{` on.
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
        let mut node = V1Node {
            kind: V1NodeKind::named(type_name),
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
        self.warn_unsupported(&node);
        self.nodes.push(node);
        Ok(Some(self.nodes.len() as NodeId - 1))
    }

    /// Warns about a node that is not supported.
    fn warn_unsupported(&mut self, node: &V1Node) {
        let name = shortened(&text(node.type_name));
        if node.kind == V1NodeKind::Unknown {
            let what = if node.children.is_empty() {
                "skipped"
            } else {
                "its content is read as in a Separator"
            };
            self.warn(node.at, format!("unknown node {name}: {what}"));
        } else if !node.kind.is_group() && node.children.iter().any(|c| !self.is_property(*c)) {
            self.warn(node.at, format!("nodes inside {name}: skipped"));
        }
    }

    /// Whether a node holds the vertices of the shape that it is inside.
    fn is_property(&self, node: NodeId) -> bool {
        self.nodes[node as usize].kind == V1NodeKind::VertexProperty
    }

    /// Reads fields and nodes up to the `}`.
    fn body(&mut self, node: &mut V1Node<'a>) -> Result<(), ReadError> {
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
                let token = self.lexer.found();
                self.warn(at, format!("{token} instead of a field: skipped"));
                self.lexer.skip_token();
            }
        }
    }

    /// Reads a field or a child node, after its first word.
    fn statement(
        &mut self,
        at: usize,
        word: &'a [u8],
        node: &mut V1Node<'a>,
    ) -> Result<(), ReadError> {
        if let Some((name, form)) = node.kind.field(word) {
            let value = self.value(name, form);
            // Inventor marks values that are to be ignored.
            if !self.lexer.take_word(b"~") {
                node.fields.retain(|(other, _)| *other != name);
                node.fields.push((name, value));
            }
        } else if self.begins_node(word) {
            node.children.extend(self.node(at, word)?);
        } else if word == b"fields" && self.lexer.take(b'[') {
            // The type is evident from the values.
            self.lexer.skip_to_close();
        } else if word == b"isA" {
            let names = self.words();
            if node.kind == V1NodeKind::Unknown {
                let kinds = names.iter().map(|name| V1NodeKind::named(name.as_bytes()));
                node.kind = kinds
                    .into_iter()
                    .find(|k| *k != V1NodeKind::Unknown)
                    .unwrap_or(node.kind);
            }
        } else if (word == b"alternateRep" && node.kind == V1NodeKind::Unknown)
            || (word == b"vertexProperty" && node.kind == V1NodeKind::IndexedFaceSet)
        {
            // The value is a node, which the next iteration reads.
        } else {
            self.skip_field(at, word, node);
        }
        Ok(())
    }

    /// Skips the value of an unknown field. Its type is unknown, too, so the tokens decide: all
    /// numbers, or one of anything else.
    fn skip_field(&mut self, at: usize, word: &[u8], node: &V1Node) {
        // The fields of an unknown node do not deserve a warning each.
        if node.kind != V1NodeKind::Unknown && !IGNORED_FIELDS.contains(&word) {
            let (node, field) = (text(node.type_name), text(word));
            let shown = shortened(&format!("{node}.{field}"));
            self.warn(at, format!("field {shown} is ignored"));
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

    fn value(&mut self, name: &str, form: V1FieldType) -> V1Value<'a> {
        match form {
            V1FieldType::Exactly(count) => V1Value::Numbers(self.exactly(name, count)),
            V1FieldType::Numbers => {
                let mut list = self.list(name, |[x]| x);
                keep_one_of_equals(&mut list);
                V1Value::Numbers(list)
            }
            V1FieldType::Integers => V1Value::Integers(self.integers(name)),
            V1FieldType::Vectors => V1Value::Vectors(self.list(name, DVec3::from_array)),
            V1FieldType::Vectors2 => V1Value::Vectors2(self.list(name, DVec2::from_array)),
            V1FieldType::Colors => {
                let mut list = self.list(name, |[r, g, b]| Rgb::new(r, g, b).map(finite));
                keep_one_of_equals(&mut list);
                V1Value::Colors(list)
            }
            V1FieldType::Words => V1Value::Words(self.words()),
            V1FieldType::Image => V1Value::Numbers(self.image()),
        }
    }

    fn exactly(&mut self, name: &str, count: usize) -> Vec<f64> {
        let at = self.here();
        let in_brackets = self.lexer.take(b'[');
        let mut numbers = Vec::with_capacity(count);
        self.lexer.numbers(count, &mut numbers);
        if numbers.len() < count {
            self.warn(at, format!("{name} with too few numbers: ignored"));
        } else if numbers.iter().any(|n| !n.is_finite()) {
            self.warn(at, format!("{name} with an invalid number: ignored"));
        }
        if in_brackets {
            self.lexer.skip_to_close();
        }
        numbers
    }

    /// One tuple of `N` numbers, or any number of them in brackets.
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

    /// `N` numbers; `None` if none comes next or there are too few.
    #[inline]
    fn tuple<const N: usize>(&mut self, name: &str) -> Option<[f64; N]> {
        let mut tuple = [0.0; N];
        for (k, number) in tuple.iter_mut().enumerate() {
            match self.lexer.number() {
                Some(value) => *number = value,
                None => {
                    if k > 0 {
                        let at = self.here();
                        self.warn(at, format!("incomplete last value of {name}: skipped"));
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

    /// Whether a list ends here; otherwise skips what does not belong in it.
    fn closes(&mut self, name: &str) -> bool {
        let at = self.here();
        match self.lexer.peek() {
            Some(b']') => self.lexer.take(b']'),
            // The closing bracket is missing, or the file ends.
            Some(b'}') | None => {
                self.warn(at, format!("{name} without a closing bracket"));
                true
            }
            Some(_) => {
                let token = self.lexer.found();
                self.warn(at, format!("{token} among the values of {name}: skipped"));
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
            // Negative sizes become 0, and the largest exceed any file.
            let pixels = (width as usize).saturating_mul(height as usize);
            self.lexer.numbers(pixels, &mut numbers);
        }
        numbers
    }
}

/// A list of equal values means the same as one of them, and costs more wherever it is used.
fn keep_one_of_equals<T: PartialEq>(list: &mut Vec<T>) {
    if list.windows(2).all(|pair| pair[0] == pair[1]) {
        list.truncate(1);
    }
    list.shrink_to_fit();
}

fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}
