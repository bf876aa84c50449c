//! The nodes of VRML97 and X3D, in any encoding.
//!
//! Values have the types that their text shows, not those that the standard gives their fields, so
//! unknown nodes are read like all others, and are skipped by name when the scene is built.

use super::builder::VrmlSource;
use super::lexer::VrmlLexer;
use azulejo_scene::Rgb;
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::cell::OnceCell;
use std::collections::HashMap;
use std::rc::Rc;

/// Maximum depth of nested nodes, `USE` and prototypes included.
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
    /// The file that contains it.
    pub source: Rc<VrmlSource>,
    pub at: usize,
    fields: Vec<VrmlField>,
    /// Height of the tree below this node, itself included.
    depth: u32,
    /// Whether a field of this node, or of one below it, has an `IS` that an instance of the
    /// prototype must resolve.
    is_open: bool,
}

/// A field of a node.
#[derive(Clone, Debug)]
pub(super) struct VrmlField {
    pub name: Rc<str>,
    pub value: FieldValue,
}

/// The value of a field. Large values are shared, because instances of prototypes copy fields.
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
    /// An XML attribute, whose type is determined on access.
    Text(Rc<str>),
    /// One node or many; `NULL` is an empty list.
    Nodes(Vec<Rc<VrmlNode>>),
    /// `IS`: the value that an instance of the prototype gives to this field of its interface.
    Is(Rc<str>),
}

/// A prototype definition.
#[derive(Debug)]
pub(super) struct Prototype {
    /// Its name.
    pub name: Rc<str>,
    /// The fields of its instances, with their default values.
    pub interface: Vec<VrmlField>,
    /// Its nodes; the first one is displayed.
    pub body: Vec<Rc<VrmlNode>>,
    /// The URLs of its definition, if that is in another file.
    pub urls: Vec<String>,
    /// Indices into `interface` by name, once they are needed.
    defaults: OnceCell<HashMap<Rc<str>, usize>>,
}

/// A parsed file.
#[derive(Debug, Default)]
pub(super) struct VrmlDocument {
    /// The top-level nodes.
    pub roots: Vec<Rc<VrmlNode>>,
    /// The top-level prototypes.
    pub protos: Vec<Rc<Prototype>>,
    /// Length of the unit in metres, if the file defines one.
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
    /// The node; `None` if it is nested too deeply.
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
    /// The nodes, if the value consists of nodes.
    fn nodes(&self) -> &[Rc<VrmlNode>] {
        match self {
            FieldValue::Nodes(nodes) => nodes,
            _ => &[],
        }
    }

    /// Whether the value may consist of nodes: an empty list has no type.
    pub fn is_nodes(&self) -> bool {
        match self {
            FieldValue::Nodes(_) => true,
            FieldValue::Text(text) => text.trim().is_empty(),
            _ => false,
        }
    }

    /// The numbers, if the value consists of numbers.
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

    /// The integers, if the value consists of integers.
    pub fn integers(&self) -> Option<Cow<'_, [i32]>> {
        match self {
            FieldValue::Numbers(numbers) => Some(numbers.iter().map(|&n| n as i32).collect()),
            FieldValue::Integers(integers) => Some(Cow::Borrowed(integers)),
            FieldValue::Text(text) => Some(Cow::Owned(parsed_integers(text))),
            _ => None,
        }
    }

    /// The strings, if the value consists of strings. In XML, a single string may be unquoted.
    pub fn strings(&self) -> Option<Cow<'_, [String]>> {
        match self {
            FieldValue::Strings(strings) => Some(Cow::Borrowed(strings)),
            FieldValue::Text(text) => Some(Cow::Owned(parsed_strings(text))),
            _ => None,
        }
    }

    /// The flag, if the value is one.
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

/// The numbers in an XML attribute; NaN for every word that is not a number.
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

/// The integers in an XML attribute; other words are skipped.
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
    /// The value of a field; of several with the same name, the last.
    pub fn value(&self, name: &str) -> Option<&FieldValue> {
        let mut fields = self.fields.iter().rev();
        fields.find(|f| *f.name == *name).map(|f| &f.value)
    }

    /// All fields, in the order of the file.
    pub fn fields(&self) -> &[VrmlField] {
        &self.fields
    }

    /// The numbers of a field; empty if absent.
    pub fn numbers(&self, name: &str) -> Cow<'_, [f64]> {
        let numbers = self.value(name).and_then(FieldValue::numbers);
        numbers.unwrap_or_default()
    }

    /// The indices of a field; empty if absent.
    pub fn integers(&self, name: &str) -> Cow<'_, [i32]> {
        let integers = self.value(name).and_then(FieldValue::integers);
        integers.unwrap_or_default()
    }

    /// The strings of a field; empty if absent.
    pub fn strings(&self, name: &str) -> Cow<'_, [String]> {
        let strings = self.value(name).and_then(FieldValue::strings);
        strings.unwrap_or_default()
    }

    /// Whether a field is `TRUE`; `default` if absent.
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

    /// The number in a field.
    pub fn number(&self, name: &str, default: f64) -> f64 {
        let [number] = self.array(name, [default]);
        number
    }

    /// The vector in a field.
    pub fn vector(&self, name: &str, default: DVec3) -> DVec3 {
        self.array(name, default.to_array()).into()
    }

    /// The colour in a field, clamped to 0..=1.
    pub fn color(&self, name: &str, default: Rgb) -> Rgb {
        Rgb::from(self.array(name, default.to_array())).map(|x| x.clamp(0.0, 1.0))
    }

    /// The 2D points in a field.
    pub fn points2(&self, name: &str) -> Vec<DVec2> {
        let numbers = self.numbers(name);
        numbers.chunks_exact(2).map(DVec2::from_slice).collect()
    }

    /// The nodes of a field as in the file: instances of prototypes are not unfolded.
    pub fn nodes(&self, name: &str) -> &[Rc<VrmlNode>] {
        self.value(name).map(FieldValue::nodes).unwrap_or_default()
    }

    /// This node with every `IS` for which `value_of` has a value replaced; the node itself if
    /// there is no `IS` in or below it. Adds the number of new nodes to `made`. `None` if nodes
    /// become nested too deeply.
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

/// Red, green and blue, clamped to 0..=1; NaN becomes 0.
pub(super) fn limited(color: Rgb) -> Rgb {
    color.map(|x| if x > 0.0 { x.min(1.0) } else { 0.0 })
}

/// Numbers grouped by three.
pub(super) fn triples(numbers: &[f64]) -> Vec<DVec3> {
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

impl Prototype {
    /// A prototype with its definition.
    pub fn new(name: Rc<str>, interface: Vec<VrmlField>, body: Vec<Rc<VrmlNode>>) -> Prototype {
        Prototype {
            name,
            interface,
            body,
            urls: Vec::new(),
            defaults: OnceCell::new(),
        }
    }

    /// A prototype that is defined in one of these files.
    pub fn elsewhere(name: Rc<str>, urls: Vec<String>) -> Prototype {
        Prototype {
            urls,
            ..Prototype::new(name, Vec::new(), Vec::new())
        }
    }

    /// The node that an instance displays: the first node of the body, with the instance's fields.
    pub fn unfold(&self, instance: &VrmlNode, made: &mut u64) -> Option<Rc<VrmlNode>> {
        let body = self.body.first()?;
        if !body.is_open {
            return Some(body.clone());
        }
        // By name: a search for each connected field would be quadratic.
        let defaults = self.defaults.get_or_init(|| {
            let fields = self.interface.iter().enumerate().rev();
            fields.map(|(k, f)| (f.name.clone(), k)).collect()
        });
        let fields = instance.fields.iter();
        let given: HashMap<&str, _> = fields.map(|f| (&*f.name, &f.value)).collect();
        *made += instance.fields.len() as u64 / 8;
        let value_of = |name: &str| {
            let default = || Some(&self.interface[*defaults.get(name)?].value);
            given.get(name).copied().or_else(default).cloned()
        };
        body.instance(&value_of, made)
    }
}
