//! The nodes of VRML97 and X3D, whichever encoding they come in.
//!
//! Values have the types that their text shows, not those that the standard gives their fields:
//! so nodes that nobody knows are read like all others, and are skipped by name when the scene
//! is built.

use super::builder::VrmlSource;
use super::lexer::VrmlLexer;
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::rc::Rc;

/// How deep nodes may stand inside one another, `USE` and prototypes included.
pub(super) const MOST_DEPTH: u32 = 200;

/// A node with its fields.
#[derive(Debug)]
pub(super) struct VrmlNode {
    /// Its type: `Transform`, or the name of a prototype.
    pub kind: Rc<str>,
    /// Its name by `DEF`.
    pub name: Option<Rc<str>>,
    /// The prototype that it is an instance of.
    pub proto: Option<Rc<Prototype>>,
    /// The file in which it stands, and at which byte.
    pub source: Rc<VrmlSource>,
    pub at: usize,
    fields: Vec<VrmlField>,
    /// Levels of nodes from this one down, itself included.
    depth: u32,
    /// Whether a field of this node, or of one below it, is to come from a prototype's instance.
    is_open: bool,
}

/// A field of a node.
#[derive(Clone, Debug)]
pub(super) struct VrmlField {
    /// Its name.
    pub name: Rc<str>,
    /// What it holds.
    pub value: FieldValue,
}

/// What a field holds. Large values are shared, because instances of prototypes copy fields.
#[derive(Clone, Debug)]
pub(super) enum FieldValue {
    /// One number or many.
    Numbers(Rc<Vec<f64>>),
    /// Indices.
    Integers(Rc<Vec<i32>>),
    /// `TRUE` or `FALSE`.
    Flag(bool),
    /// One string or many.
    Strings(Rc<Vec<String>>),
    /// An attribute of XML, whose type only shows when someone asks.
    Text(Rc<str>),
    /// One node or many; none is `NULL`.
    Nodes(Vec<Rc<VrmlNode>>),
    /// What the instance of the prototype gives this field of its interface.
    Is(Rc<str>),
}

/// A prototype: what an instance of it stands for.
#[derive(Debug)]
pub(super) struct Prototype {
    /// Its name.
    pub name: Rc<str>,
    /// The fields of its instances, with their values where these say nothing.
    pub interface: Vec<VrmlField>,
    /// Its nodes; the first is what an instance shows.
    pub body: Vec<Rc<VrmlNode>>,
    /// Where it is defined, if that is another file.
    pub urls: Vec<String>,
}

/// A file, read.
#[derive(Debug, Default)]
pub(super) struct VrmlDocument {
    /// The nodes that stand in nothing else.
    pub roots: Vec<Rc<VrmlNode>>,
    /// The prototypes that do.
    pub protos: Vec<Rc<Prototype>>,
    /// Length of the unit in metres.
    pub metres: Option<f64>,
}

/// A node under construction.
pub(super) struct NodeBuilder {
    pub kind: Rc<str>,
    pub name: Option<Rc<str>>,
    pub proto: Option<Rc<Prototype>>,
    pub source: Rc<VrmlSource>,
    pub at: usize,
    pub fields: Vec<VrmlField>,
}

impl NodeBuilder {
    /// The node; `None` if nodes are too deep in it.
    pub fn finish(self) -> Option<Rc<VrmlNode>> {
        let nodes = || self.fields.iter().flat_map(|f| f.value.nodes());
        let proto = self.proto.iter().flat_map(|proto| &proto.body);
        let depth = 1 + nodes().chain(proto).map(|n| n.depth).max().unwrap_or(0);
        let is_field = |f: &VrmlField| matches!(f.value, FieldValue::Is(_));
        let is_open = self.fields.iter().any(is_field) || nodes().any(|n| n.is_open);
        (depth <= MOST_DEPTH).then(|| {
            Rc::new(VrmlNode {
                kind: self.kind,
                name: self.name,
                proto: self.proto,
                source: self.source,
                at: self.at,
                fields: self.fields,
                depth,
                is_open,
            })
        })
    }
}

impl FieldValue {
    /// The nodes, if it holds any.
    fn nodes(&self) -> &[Rc<VrmlNode>] {
        match self {
            FieldValue::Nodes(nodes) => nodes,
            _ => &[],
        }
    }

    /// Whether it may hold nodes: an empty list has no type.
    pub fn is_nodes(&self) -> bool {
        match self {
            FieldValue::Nodes(_) => true,
            FieldValue::Text(text) => text.trim().is_empty(),
            _ => false,
        }
    }

    /// The numbers, if it holds any.
    pub fn numbers(&self) -> Option<Cow<'_, [f64]>> {
        match self {
            FieldValue::Numbers(numbers) => Some(Cow::Borrowed(numbers)),
            FieldValue::Integers(integers) => {
                Some(integers.iter().map(|&i| f64::from(i)).collect())
            }
            FieldValue::Text(text) => Some(Cow::Owned(parsed_numbers(text))),
            _ => None,
        }
    }

    /// The integers, if it holds any.
    pub fn integers(&self) -> Option<Cow<'_, [i32]>> {
        match self {
            FieldValue::Numbers(numbers) => Some(numbers.iter().map(|&n| n as i32).collect()),
            FieldValue::Integers(integers) => Some(Cow::Borrowed(integers)),
            FieldValue::Text(text) => Some(Cow::Owned(parsed_integers(text))),
            _ => None,
        }
    }

    /// The strings, if it holds any. In XML, one string may do without quotes.
    pub fn strings(&self) -> Option<Cow<'_, [String]>> {
        match self {
            FieldValue::Strings(strings) => Some(Cow::Borrowed(strings)),
            FieldValue::Text(text) => Some(Cow::Owned(parsed_strings(text))),
            _ => None,
        }
    }

    /// True or false, if it is.
    pub fn flag(&self) -> Option<bool> {
        match self {
            FieldValue::Flag(flag) => Some(*flag),
            FieldValue::Text(text) => parsed_flag(text.trim().as_bytes()),
            _ => None,
        }
    }
}

/// `TRUE` of the classic encodings, or `true` of XML.
pub(super) fn parsed_flag(word: &[u8]) -> Option<bool> {
    match word {
        b"TRUE" | b"true" | b"True" => Some(true),
        b"FALSE" | b"false" | b"False" => Some(false),
        _ => None,
    }
}

/// The numbers in an attribute of XML; NaN for every word that is none.
pub(super) fn parsed_numbers(text: &str) -> Vec<f64> {
    let (mut lexer, mut numbers) = (VrmlLexer::new(text.as_bytes()), Vec::new());
    loop {
        lexer.numbers(usize::MAX, &mut numbers);
        if !lexer.skip_token() {
            return numbers;
        }
        numbers.push(f64::NAN);
    }
}

/// The integers in an attribute of XML; words that are none are left out.
pub(super) fn parsed_integers(text: &str) -> Vec<i32> {
    let (mut lexer, mut integers) = (VrmlLexer::new(text.as_bytes()), Vec::new());
    loop {
        lexer.integers(&mut integers);
        if !lexer.skip_token() {
            return integers;
        }
    }
}

fn parsed_strings(text: &str) -> Vec<String> {
    let mut lexer = VrmlLexer::new(text.as_bytes());
    let mut strings = Vec::new();
    while let Some(string) = lexer.string() {
        strings.push(string.into_owned());
    }
    if strings.is_empty() {
        strings.push(text.trim().to_owned());
    }
    strings
}

impl VrmlNode {
    /// What a field holds; of two that have the name, the last.
    pub fn value(&self, name: &str) -> Option<&FieldValue> {
        let mut fields = self.fields.iter().rev();
        fields.find(|f| *f.name == *name).map(|f| &f.value)
    }

    /// All fields, in the order of the file.
    pub fn fields(&self) -> &[VrmlField] {
        &self.fields
    }

    /// The numbers of a field; empty if it has none.
    pub fn numbers(&self, name: &str) -> Cow<'_, [f64]> {
        let numbers = self.value(name).and_then(FieldValue::numbers);
        numbers.unwrap_or_default()
    }

    /// The indices of a field; empty if it has none.
    pub fn integers(&self, name: &str) -> Cow<'_, [i32]> {
        let integers = self.value(name).and_then(FieldValue::integers);
        integers.unwrap_or_default()
    }

    /// The strings of a field; empty if it has none.
    pub fn strings(&self, name: &str) -> Cow<'_, [String]> {
        let strings = self.value(name).and_then(FieldValue::strings);
        strings.unwrap_or_default()
    }

    /// Whether a field is `TRUE`; `default` if it does not say.
    pub fn flag(&self, name: &str, default: bool) -> bool {
        let flag = self.value(name).and_then(FieldValue::flag);
        flag.unwrap_or(default)
    }

    /// The first numbers of a field; `default` if there are too few or one is not finite.
    pub fn array<const N: usize>(&self, name: &str, default: [f64; N]) -> [f64; N] {
        let numbers = self.numbers(name);
        let array = numbers.first_chunk::<N>().copied();
        let finite = array.filter(|a| a.iter().all(|x| x.is_finite()));
        finite.unwrap_or(default)
    }

    /// The one number of a field.
    pub fn number(&self, name: &str, default: f64) -> f64 {
        let [number] = self.array(name, [default]);
        number
    }

    /// The vector of a field.
    pub fn vector(&self, name: &str, default: DVec3) -> DVec3 {
        self.array(name, default.to_array()).into()
    }

    /// The colour of a field, limited to 0..=1.
    pub fn color(&self, name: &str, default: Rgb) -> Rgb {
        Rgb::from(self.array(name, default.to_array())).map(|x| x.clamp(0.0, 1.0))
    }

    /// The points in a plane of a field.
    pub fn points2(&self, name: &str) -> Vec<DVec2> {
        let numbers = self.numbers(name);
        numbers.chunks_exact(2).map(DVec2::from_slice).collect()
    }

    /// The nodes of a field, as they stand: instances of prototypes are not unfolded.
    pub fn nodes(&self, name: &str) -> &[Rc<VrmlNode>] {
        self.value(name).map(FieldValue::nodes).unwrap_or_default()
    }

    /// This node with every field that `value_of` knows in place of its `IS`; itself if there is
    /// none in or below it. Counts the nodes that are made into `made`. `None` if nodes become
    /// too deep.
    pub fn instance(
        self: &Rc<VrmlNode>,
        value_of: &dyn Fn(&str) -> Option<FieldValue>,
        made: &mut u64,
    ) -> Option<Rc<VrmlNode>> {
        if !self.is_open {
            return Some(self.clone());
        }
        *made += 1;
        let mut fields = Vec::with_capacity(self.fields.len());
        for field in &self.fields {
            let value = match &field.value {
                FieldValue::Is(name) => value_of(name),
                FieldValue::Nodes(nodes) => {
                    let instances = nodes.iter().map(|n| n.instance(value_of, made));
                    Some(FieldValue::Nodes(instances.collect::<Option<_>>()?))
                }
                value => Some(value.clone()),
            };
            let name = field.name.clone();
            fields.extend(value.map(|value| VrmlField { name, value }));
        }
        NodeBuilder {
            kind: self.kind.clone(),
            name: self.name.clone(),
            proto: self.proto.clone(),
            source: self.source.clone(),
            at: self.at,
            fields,
        }
        .finish()
    }
}

/// Red, green and blue, limited to 0..=1; NaN becomes 0.
pub(super) fn limited(color: Rgb) -> Rgb {
    color.map(|x| if x > 0.0 { x.min(1.0) } else { 0.0 })
}

/// Numbers by threes.
pub(super) fn triples(numbers: &[f64]) -> Vec<DVec3> {
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

impl Prototype {
    /// What an instance shows: the first node of the body, with the instance's fields in it.
    pub fn unfold(&self, instance: &VrmlNode, made: &mut u64) -> Option<Rc<VrmlNode>> {
        let value_of = |name: &str| {
            let default = || self.interface.iter().find(|f| *f.name == *name);
            let given = instance.value(name);
            given.or_else(|| default().map(|f| &f.value)).cloned()
        };
        self.body.first()?.instance(&value_of, made)
    }
}
