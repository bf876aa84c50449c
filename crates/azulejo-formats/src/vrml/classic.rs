//! VRML97 and X3D in the classic encoding, as a tree of nodes.
//!
//! A syntax error loses only the enclosing node: the rest of that node is skipped by matching
//! brackets, with a warning. Of a truncated file, everything before the end is kept.

use super::builder::{VrmlSceneBuilder, VrmlSource};
use super::lexer::VrmlLexer;
use super::names::NameScopes;
use super::tree::{
    FieldValue, MOST_DEPTH, NodeBuilder, Prototype, VrmlDocument, VrmlField, VrmlNode, parsed_flag,
};
use crate::ReadError;
use crate::reading::text::{shortened, text};
use std::collections::HashMap;
use std::rc::Rc;

/// Parses a file.
///
/// # Errors
/// The file has content but no node, or more nodes than the options allow.
pub(super) fn parse(
    builder: &mut VrmlSceneBuilder,
    source: &Rc<VrmlSource>,
) -> Result<VrmlDocument, ReadError> {
    let mut parser = ClassicParser {
        lexer: VrmlLexer::new(&source.bytes),
        source,
        builder,
        known: HashMap::new(),
        names: NameScopes::new(),
        depth: 0,
        metres: None,
    };
    let mut roots = Vec::new();
    let start = parser.lexer;
    parser.statements(&mut roots)?;
    let document = VrmlDocument {
        roots,
        protos: parser.names.into_protos(),
        metres: parser.metres,
    };
    let holds_nothing = document.roots.is_empty() && document.protos.is_empty();
    if holds_nothing && !start.clone().at_end() {
        return Err(start
            .clone()
            .error(&source.name, "a node such as \"Group { }\""));
    }
    Ok(document)
}

struct ClassicParser<'a, 's, 'f> {
    lexer: VrmlLexer<'a>,
    source: &'a Rc<VrmlSource>,
    builder: &'s mut VrmlSceneBuilder<'f>,
    /// Interned words, so that all fields of the same name share it.
    known: HashMap<&'a [u8], Rc<str>>,
    names: NameScopes,
    depth: u32,
    metres: Option<f64>,
}

/// Whether a word is an access type, which declares a field of a prototype or script.
fn is_access(word: &[u8]) -> bool {
    matches!(
        word,
        b"field"
            | b"exposedField"
            | b"eventIn"
            | b"eventOut"
            | b"initializeOnly"
            | b"inputOutput"
            | b"inputOnly"
            | b"outputOnly"
    )
}

/// Whether a field holds integers, of which there may be many.
pub(super) fn holds_integers(field: &str) -> bool {
    field == "index" || field.ends_with("Index")
}

impl<'a> ClassicParser<'a, '_, '_> {
    #[cold]
    fn warn(&mut self, at: usize, message: impl Into<String>) {
        self.builder.warn(self.source, at, message);
    }

    fn intern(&mut self, word: &'a [u8]) -> Rc<str> {
        let known = self.known.entry(word);
        known.or_insert_with(|| text(word).into()).clone()
    }

    /// Reads a required name.
    fn name(&mut self) -> Option<Rc<str>> {
        match self.lexer.word() {
            Some(word) => Some(self.intern(word)),
            None => {
                self.unexpected("a name");
                None
            }
        }
    }

    #[cold]
    fn unexpected(&mut self, expected: &str) {
        let (found, at) = (self.lexer.found(), self.lexer.offset());
        self.warn(at, format!("found {found}, expected {expected}"));
    }

    /// Takes a required bracket.
    fn expect(&mut self, mark: u8) -> bool {
        let is_there = self.lexer.take(mark);
        if !is_there {
            self.unexpected(&format!("\"{}\"", mark as char));
        }
        is_there
    }

    /// Reads nodes and statements up to the end of the file.
    fn statements(&mut self, into: &mut Vec<Rc<VrmlNode>>) -> Result<(), ReadError> {
        while let Some(next) = self.lexer.peek() {
            let at = self.lexer.offset();
            match next {
                b'{' | b'[' => {
                    self.warn(at, "bracket without a node: skipped with its content");
                    self.lexer.skip_token();
                    self.lexer.skip_to_close();
                }
                b'}' | b']' | b'"' => {
                    self.warn(at, "bracket or string instead of a node: skipped");
                    self.lexer.skip_token();
                }
                _ => self.statement(into)?,
            }
        }
        Ok(())
    }

    /// Reads a node, a reference to one, a prototype, or a statement about the file. A word comes
    /// next.
    fn statement(&mut self, into: &mut Vec<Rc<VrmlNode>>) -> Result<(), ReadError> {
        let at = self.lexer.offset();
        let word = self.lexer.word().unwrap_or_default();
        match word {
            b"DEF" => {
                let Some(name) = self.name() else {
                    return Ok(());
                };
                let at = self.lexer.offset();
                match self.lexer.word() {
                    Some(kind) => into.extend(self.node(kind, Some(name), at)?),
                    None => self.unexpected("a node type"),
                }
            }
            b"USE" => into.extend(self.reference()),
            b"NULL" => {}
            b"PROTO" => self.proto()?,
            b"EXTERNPROTO" => self.extern_proto()?,
            b"ROUTE" => self.route(at),
            b"PROFILE" | b"COMPONENT" => drop(self.lexer.word()),
            b"META" => {
                self.lexer.string();
                self.lexer.string();
            }
            b"UNIT" => self.unit(),
            b"IMPORT" | b"EXPORT" => self.import(at),
            kind => into.extend(self.node(kind, None, at)?),
        }
        Ok(())
    }

    /// `from.event TO to.event`
    fn route(&mut self, at: usize) {
        self.lexer.word();
        if self.lexer.take_word(b"TO") {
            self.lexer.word();
        }
        self.warn(at, "ROUTE: skipped, animation is not supported");
    }

    /// `category name factor`
    fn unit(&mut self) {
        let category = self.lexer.word();
        self.lexer.word();
        let factor = self.lexer.number();
        if category == Some(b"length") {
            self.metres = factor;
        }
    }

    /// `inline.name AS name` or `name AS name`
    fn import(&mut self, at: usize) {
        self.lexer.word();
        if self.lexer.take_word(b"AS") {
            self.lexer.word();
        }
        self.warn(at, "IMPORT or EXPORT of a name: skipped");
    }

    fn reference(&mut self) -> Option<Rc<VrmlNode>> {
        let at = self.lexer.offset();
        let name = self.name()?;
        let node = self.names.node(&name);
        if node.is_none() {
            let name = shortened(&name);
            let message =
                format!("USE of \"{name}\", which no complete node before it defines: skipped");
            self.warn(at, message);
        }
        node
    }

    /// Reads the node whose type has been taken. `None`, with a warning, if it is not a node.
    fn node(
        &mut self,
        kind: &'a [u8],
        name: Option<Rc<str>>,
        at: usize,
    ) -> Result<Option<Rc<VrmlNode>>, ReadError> {
        let kind = self.intern(kind);
        if !self.lexer.take(b'{') {
            let kind = shortened(&kind);
            self.unexpected(&format!("\"{{\" after \"{kind}\""));
            return Ok(None);
        }
        self.builder.spend(1)?;
        if self.depth == MOST_DEPTH {
            self.too_deep(at);
            self.lexer.skip_to_close();
            return Ok(None);
        }
        self.depth += 1;
        let fields = self.body(&kind)?;
        self.depth -= 1;
        let draft = NodeBuilder {
            proto: self.names.proto(&kind),
            kind,
            name: name.clone(),
            source: self.source.clone(),
            at,
            fields,
        };
        let node = draft.finish();
        match (&node, name) {
            (Some(node), Some(name)) => self.names.define(name, node.clone()),
            (None, _) => self.too_deep(at),
            _ => {}
        }
        Ok(node)
    }

    fn too_deep(&mut self, at: usize) {
        let message = format!("node nested more than {MOST_DEPTH} deep: skipped");
        self.warn(at, message);
    }

    /// Reads the fields of a node, up to its closing bracket.
    fn body(&mut self, kind: &str) -> Result<Vec<VrmlField>, ReadError> {
        let mut fields = Vec::new();
        loop {
            match self.lexer.peek() {
                None => {
                    let at = self.lexer.offset();
                    self.warn(
                        at,
                        "the file ends inside a node: what precedes the end is used",
                    );
                    return Ok(fields);
                }
                Some(b'}') => {
                    self.lexer.take(b'}');
                    return Ok(fields);
                }
                Some(b'{' | b'[' | b']' | b'"') => {
                    let kind = shortened(kind);
                    let what = format!("a field of {kind}; the rest of the node is skipped");
                    self.unexpected(&what);
                    self.lexer.skip_to_close();
                    return Ok(fields);
                }
                Some(_) => self.field(&mut fields)?,
            }
        }
    }

    /// Reads a field with its value, or a statement, which may occur among fields. A word comes
    /// next.
    fn field(&mut self, fields: &mut Vec<VrmlField>) -> Result<(), ReadError> {
        let at = self.lexer.offset();
        let word = self.lexer.word().unwrap_or_default();
        match word {
            b"PROTO" => return self.proto(),
            b"EXTERNPROTO" => return self.extern_proto(),
            b"ROUTE" => self.route(at),
            _ if is_access(word) => fields.extend(self.declaration(word)?),
            _ => {
                let name = self.intern(word);
                let value = self.value(&name)?;
                fields.extend(value.map(|value| VrmlField { name, value }));
            }
        }
        Ok(())
    }

    /// Reads a field of a prototype or script, after its access type.
    fn declaration(&mut self, access: &[u8]) -> Result<Option<VrmlField>, ReadError> {
        // The type is evident from the value.
        self.lexer.word();
        let Some(name) = self.name() else {
            return Ok(None);
        };
        let is_event = matches!(
            access,
            b"eventIn" | b"eventOut" | b"inputOnly" | b"outputOnly"
        );
        if is_event && self.lexer.peek_word() != Some(b"IS") {
            return Ok(None);
        }
        let value = self.value(&name)?;
        Ok(value.map(|value| VrmlField { name, value }))
    }

    /// Reads the value of a field; `None` if there is none.
    fn value(&mut self, field: &str) -> Result<Option<FieldValue>, ReadError> {
        match self.lexer.peek() {
            Some(b'[') => {
                self.lexer.take(b'[');
                return self.list(field).map(Some);
            }
            Some(b'"') => {
                let string = self.lexer.string().unwrap_or_default();
                return Ok(Some(FieldValue::Strings(Rc::new(vec![
                    string.into_owned(),
                ]))));
            }
            None | Some(b'{' | b'}' | b']') => return Ok(None),
            _ => {}
        }
        if let Some(numbers) = self.numbers(field) {
            return Ok(Some(numbers));
        }
        let word = self.lexer.peek_word().unwrap_or_default();
        if let Some(flag) = parsed_flag(word) {
            self.lexer.word();
            return Ok(Some(FieldValue::Flag(flag)));
        }
        if word == b"IS" {
            self.lexer.word();
            return Ok(self.name().map(FieldValue::Is));
        }
        let mut nodes = Vec::new();
        self.statement(&mut nodes)?;
        Ok(Some(FieldValue::Nodes(nodes)))
    }

    /// Reads the numbers that come next, without brackets; `None` if there are none.
    fn numbers(&mut self, field: &str) -> Option<FieldValue> {
        if holds_integers(field) {
            let mut integers = Vec::new();
            self.lexer.integers(&mut integers);
            return (!integers.is_empty()).then(|| FieldValue::Integers(Rc::new(integers)));
        }
        let mut numbers = Vec::new();
        self.lexer.numbers(usize::MAX, &mut numbers);
        (!numbers.is_empty()).then(|| FieldValue::Numbers(Rc::new(numbers)))
    }

    /// Reads the values up to the closing bracket of a list, whose opening bracket has been taken.
    /// The first value determines their type.
    fn list(&mut self, field: &str) -> Result<FieldValue, ReadError> {
        let value = match self.lexer.peek() {
            Some(b'"') => self.strings(),
            Some(b']') => FieldValue::Nodes(Vec::new()),
            _ => match self.number_list(field) {
                Some(numbers) => numbers,
                None => return self.node_list(),
            },
        };
        self.expect(b']');
        Ok(value)
    }

    fn strings(&mut self) -> FieldValue {
        let mut strings = Vec::new();
        while let Some(string) = self.lexer.string() {
            strings.push(string.into_owned());
        }
        FieldValue::Strings(Rc::new(strings))
    }

    /// Reads numbers in brackets. A word among them counts as NaN.
    fn number_list(&mut self, field: &str) -> Option<FieldValue> {
        let mut value = self.numbers(field)?;
        loop {
            let at = self.lexer.offset();
            if matches!(self.lexer.peek(), None | Some(b'{' | b'}' | b'[' | b']')) {
                break;
            }
            self.lexer.skip_token();
            self.warn(at, "word or string in a list of numbers: taken as NaN");
            match &mut value {
                FieldValue::Numbers(numbers) => {
                    let numbers = Rc::make_mut(numbers);
                    numbers.push(f64::NAN);
                    self.lexer.numbers(usize::MAX, numbers);
                }
                FieldValue::Integers(integers) => self.lexer.integers(Rc::make_mut(integers)),
                _ => {}
            }
        }
        // The lists can be as long as the file and live until the scene is built, so release spare
        // capacity.
        match &mut value {
            FieldValue::Numbers(numbers) => Rc::make_mut(numbers).shrink_to_fit(),
            FieldValue::Integers(integers) => Rc::make_mut(integers).shrink_to_fit(),
            _ => {}
        }
        Some(value)
    }

    /// Reads nodes in brackets, or flags, of which the last one counts.
    fn node_list(&mut self) -> Result<FieldValue, ReadError> {
        let (mut nodes, mut flag) = (Vec::new(), None);
        loop {
            match self.lexer.peek() {
                None => break,
                Some(b']') => {
                    self.lexer.take(b']');
                    break;
                }
                Some(b'{' | b'}' | b'[' | b'"') => {
                    self.unexpected("a node or \"]\"");
                    break;
                }
                Some(_) => match parsed_flag(self.lexer.peek_word().unwrap_or_default()) {
                    Some(value) => {
                        self.lexer.word();
                        flag = Some(value);
                    }
                    None => self.statement(&mut nodes)?,
                },
            }
        }
        Ok(flag.map_or(FieldValue::Nodes(nodes), FieldValue::Flag))
    }

    /// `name [ interface ] { body }`
    fn proto(&mut self) -> Result<(), ReadError> {
        let at = self.lexer.offset();
        let Some(name) = self.name() else {
            return Ok(());
        };
        let interface = self.interface()?;
        if !self.expect(b'{') {
            return Ok(());
        }
        if self.depth == MOST_DEPTH {
            self.too_deep(at);
            self.lexer.skip_to_close();
            return Ok(());
        }
        self.depth += 1;
        self.names.enter();
        let body = self.proto_body()?;
        self.names.leave();
        self.depth -= 1;
        self.names
            .define_proto(Prototype::new(name, interface, body));
        Ok(())
    }

    fn proto_body(&mut self) -> Result<Vec<Rc<VrmlNode>>, ReadError> {
        let mut body = Vec::new();
        loop {
            match self.lexer.peek() {
                None => return Ok(body),
                Some(b'}') => {
                    self.lexer.take(b'}');
                    return Ok(body);
                }
                Some(b'{' | b'[' | b']' | b'"') => {
                    self.unexpected("a node; the rest of the prototype is skipped");
                    self.lexer.skip_to_close();
                    return Ok(body);
                }
                Some(_) => self.statement(&mut body)?,
            }
        }
    }

    /// `name [ interface ] urls`
    fn extern_proto(&mut self) -> Result<(), ReadError> {
        let Some(name) = self.name() else {
            return Ok(());
        };
        // The defining file also gives the defaults of its fields.
        self.interface()?;
        let urls = match self.value("url")? {
            Some(FieldValue::Strings(urls)) => urls.to_vec(),
            _ => Vec::new(),
        };
        self.names.define_proto(Prototype::elsewhere(name, urls));
        Ok(())
    }

    /// `[ access type name value … ]`
    fn interface(&mut self) -> Result<Vec<VrmlField>, ReadError> {
        let mut fields = Vec::new();
        if !self.expect(b'[') {
            return Ok(fields);
        }
        loop {
            match self.lexer.peek_word() {
                Some(word) if is_access(word) => {
                    self.lexer.word();
                    if word_begins_external(self.lexer) {
                        self.lexer.word();
                        self.lexer.word();
                        continue;
                    }
                    fields.extend(self.declaration(word)?);
                }
                _ => break,
            }
        }
        if !self.lexer.take(b']') {
            self.unexpected("a field of the prototype or \"]\"");
            self.lexer.skip_to_close();
        }
        Ok(fields)
    }
}

/// Whether `type name` has no value, as in the interface of an `EXTERNPROTO`.
fn word_begins_external(mut ahead: VrmlLexer) -> bool {
    ahead.word();
    ahead.word();
    match ahead.peek_word() {
        None => ahead.peek() == Some(b']'),
        Some(word) => is_access(word),
    }
}
