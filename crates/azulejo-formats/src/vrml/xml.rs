//! X3D in XML, as a tree of nodes.
//!
//! Elements become nodes, attributes fields; a child element is the value of the field named by its
//! `containerField` or implied by its type. The numbers of large fields are parsed at once,
//! everything else keeps its text until it is accessed.

use super::builder::{VrmlSceneBuilder, VrmlSource};
use super::classic::holds_integers;
use super::names::NameScopes;
use super::tree::{
    FieldValue, MOST_DEPTH, NodeBuilder, Prototype, VrmlDocument, VrmlField, VrmlNode,
    parsed_integers, parsed_numbers,
};
use crate::ReadError;
use crate::reading::text::{shortened, text};
use crate::reading::xml::crowded_element;
use roxmltree::{Node as Element, ParsingOptions};
use std::collections::HashMap;
use std::rc::Rc;

/// Parses a file.
///
/// # Errors
/// Malformed XML, if not even the elements before the error can be used; no element `Scene`; more
/// nodes than the options allow.
pub(super) fn parse(
    builder: &mut VrmlSceneBuilder,
    source: &Rc<VrmlSource>,
) -> Result<VrmlDocument, ReadError> {
    let text = text(&source.bytes);
    if let Some(at) = text.find("<!ENTITY") {
        // One entity may expand to a megabyte and be referenced a million times.
        let name = &*source.name;
        let found = "XML that declares entities of its own";
        return Err(ReadError::at_byte(
            name,
            at as u64,
            found,
            "X3D without entity declarations",
        ));
    }
    if let Some((at, found)) = crowded_element(&text) {
        let expected = "elements as the nodes of X3D";
        return Err(ReadError {
            position: source.position(at),
            ..ReadError::whole(&*source.name, found, expected)
        });
    }
    let whole = roxmltree::Document::parse_with_options(&text, options());
    let broken = match &whole {
        Ok(xml) => return read(builder, source, xml),
        Err(e) => XmlError::new(&text, e),
    };
    let repaired = repaired(&text[..broken.at]).unwrap_or_default();
    match roxmltree::Document::parse_with_options(&repaired, options()) {
        Ok(xml) if scene(&xml).is_some() => {
            let what = format!("{}: only what precedes it is read", broken.what);
            builder.warn(source, broken.at, what);
            read(builder, source, &xml)
        }
        _ => Err(ReadError {
            position: source.position(broken.at),
            ..ReadError::whole(&*source.name, broken.what, "well-formed XML")
        }),
    }
}

/// The element that holds all nodes.
fn scene<'a, 'i>(xml: &'a roxmltree::Document<'i>) -> Option<Element<'a, 'i>> {
    let mut elements = xml.root_element().descendants();
    elements.find(|e| is(*e, "Scene"))
}

/// Whether an element has this local name, in any namespace.
fn is(element: Element, name: &str) -> bool {
    element.is_element() && element.tag_name().name() == name
}

/// X3D files begin with a document type declaration.
fn options<'a>() -> ParsingOptions<'a> {
    ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    }
}

/// An XML syntax error.
struct XmlError {
    /// The byte offset.
    at: usize,
    what: String,
}

impl XmlError {
    fn new(text: &str, e: &roxmltree::Error) -> XmlError {
        let message = e.to_string();
        // The crate's messages end with the position; at the end of the text they have none.
        let what = message
            .rsplit_once(" at ")
            .map_or(&*message, |(what, _)| what);
        let place = e.pos();
        let at = match (place.row, place.col) {
            (1, 1) => text.len(),
            (row, column) => offset(text, row, column),
        };
        XmlError {
            at,
            what: format!("malformed XML ({what})"),
        }
    }
}

/// The byte offset of a line and column, both counted from 1.
fn offset(text: &str, row: u32, column: u32) -> usize {
    let before: usize = text
        .split_inclusive('\n')
        .take(row as usize - 1)
        .map(str::len)
        .sum();
    let line = &text[before..];
    let inside = line.char_indices().nth(column as usize - 1);
    before + inside.map_or(line.len(), |(i, _)| i)
}

fn read(
    builder: &mut VrmlSceneBuilder,
    source: &Rc<VrmlSource>,
    xml: &roxmltree::Document,
) -> Result<VrmlDocument, ReadError> {
    let Some(scene) = scene(xml) else {
        return Err(ReadError::whole(
            &*source.name,
            "XML without a Scene element",
            "the Scene element of X3D",
        ));
    };
    let mut reader = X3dParser {
        source,
        builder,
        known: HashMap::new(),
        names: NameScopes::new(),
        depth: 0,
    };
    let mut roots = Vec::new();
    for child in scene.children().filter(Element::is_element) {
        roots.extend(reader.statement(child)?);
    }
    let mut elements = xml.root_element().descendants();
    let unit = elements.find(|e| is(*e, "unit") && e.attribute("category") == Some("length"));
    let factor = unit.and_then(|e| e.attribute("conversionFactor"));
    Ok(VrmlDocument {
        roots: roots.into_iter().map(|(_, node)| node).collect(),
        protos: reader.names.into_protos(),
        metres: factor.and_then(|f| parsed_numbers(f).first().copied()),
    })
}

struct X3dParser<'a, 's, 'f> {
    source: &'a Rc<VrmlSource>,
    builder: &'s mut VrmlSceneBuilder<'f>,
    /// Interned words, so that all fields of the same name share it.
    known: HashMap<String, Rc<str>>,
    names: NameScopes,
    depth: u32,
}

/// A node, and the field of its parent that contains it.
type ContainedNode = (Rc<str>, Rc<VrmlNode>);

impl X3dParser<'_, '_, '_> {
    #[cold]
    fn warn(&mut self, element: Element, message: impl Into<String>) {
        self.builder
            .warn(self.source, element.range().start, message);
    }

    fn intern(&mut self, word: &str) -> Rc<str> {
        if let Some(known) = self.known.get(word) {
            return known.clone();
        }
        let new: Rc<str> = word.into();
        self.known.insert(word.to_owned(), new.clone());
        new
    }

    /// Reads a node or another statement.
    fn statement(&mut self, element: Element) -> Result<Option<ContainedNode>, ReadError> {
        match element.tag_name().name() {
            "ROUTE" => self.warn(element, "ROUTE: skipped, animation is not supported"),
            "IMPORT" | "EXPORT" => self.warn(element, "IMPORT or EXPORT of a name: skipped"),
            "ProtoDeclare" => self.proto(element)?,
            "ExternProtoDeclare" => self.extern_proto(element),
            "ProtoInstance" => {
                let kind = element.attribute("name").unwrap_or_default();
                return self.node(element, kind);
            }
            kind => return self.node(element, kind),
        }
        Ok(None)
    }

    fn node(&mut self, element: Element, kind: &str) -> Result<Option<ContainedNode>, ReadError> {
        let field = element.attribute("containerField");
        let field = self.intern(field.unwrap_or(container(kind)));
        if let Some(name) = element.attribute("USE") {
            return Ok(self.reference(element, name).map(|node| (field, node)));
        }
        self.builder.spend(1)?;
        if self.depth == MOST_DEPTH {
            self.too_deep(element);
            return Ok(None);
        }
        self.depth += 1;
        let mut fields = self.attributes(element);
        self.children(element, &mut fields)?;
        self.depth -= 1;
        let name = element.attribute("DEF").map(|name| self.intern(name));
        let kind = self.intern(kind);
        let draft = NodeBuilder {
            proto: self.names.proto(&kind),
            kind,
            name: name.clone(),
            source: self.source.clone(),
            at: element.range().start,
            fields,
        };
        let Some(node) = draft.finish() else {
            self.too_deep(element);
            return Ok(None);
        };
        if let Some(name) = name {
            self.names.define(name, node.clone());
        }
        Ok(Some((field, node)))
    }

    fn too_deep(&mut self, element: Element) {
        let message = format!("node nested more than {MOST_DEPTH} deep: skipped");
        self.warn(element, message);
    }

    fn reference(&mut self, element: Element, name: &str) -> Option<Rc<VrmlNode>> {
        let node = self.names.node(name);
        if node.is_none() {
            let name = shortened(name);
            let message =
                format!("USE of \"{name}\", which no complete node before it defines: skipped");
            self.warn(element, message);
        }
        node
    }

    fn attributes(&mut self, element: Element) -> Vec<VrmlField> {
        let is_field = |name: &str| {
            !matches!(
                name,
                "DEF" | "USE" | "containerField" | "class" | "id" | "style"
            )
        };
        let attributes = element.attributes().filter(|a| is_field(a.name()));
        let fields = attributes.map(|a| VrmlField {
            name: self.intern(a.name()),
            value: value(a.name(), a.value()),
        });
        fields.collect()
    }

    /// Reads the child elements of a node: nodes, and the parts of a prototype.
    fn children(&mut self, element: Element, fields: &mut Vec<VrmlField>) -> Result<(), ReadError> {
        let mut nodes = ContainedNodes::default();
        for child in element.children().filter(Element::is_element) {
            match child.tag_name().name() {
                "IS" => self.connections(child, fields),
                "fieldValue" | "field" => fields.extend(self.given(child)?),
                _ => {
                    if let Some((name, node)) = self.statement(child)? {
                        nodes.add(name, node);
                    }
                }
            }
        }
        fields.extend(nodes.into_fields());
        Ok(())
    }

    /// `<connect nodeField="…" protoField="…"/>`
    fn connections(&mut self, element: Element, fields: &mut Vec<VrmlField>) {
        for connect in element.children().filter(Element::is_element) {
            let ends = (
                connect.attribute("nodeField"),
                connect.attribute("protoField"),
            );
            if let (Some(name), Some(of)) = ends {
                let value = FieldValue::Is(self.intern(of));
                let name = self.intern(name);
                fields.push(VrmlField { name, value });
            }
        }
    }

    /// A field of a prototype or of its instance, with its value, if any.
    fn given(&mut self, element: Element) -> Result<Option<VrmlField>, ReadError> {
        let Some(name) = element.attribute("name") else {
            return Ok(None);
        };
        let is_node = |e: Element| e.attribute("type").is_some_and(|t| t.ends_with("Node"));
        let value = match element.attribute("value") {
            Some(text) => FieldValue::Text(text.into()),
            None => {
                let mut nodes = Vec::new();
                for child in element.children().filter(Element::is_element) {
                    nodes.extend(self.statement(child)?.map(|(_, node)| node));
                }
                if nodes.is_empty() && !is_node(element) {
                    return Ok(None);
                }
                FieldValue::Nodes(nodes)
            }
        };
        let name = self.intern(name);
        Ok(Some(VrmlField { name, value }))
    }

    fn proto(&mut self, element: Element) -> Result<(), ReadError> {
        let child = |name: &str| element.children().find(|e| is(*e, name));
        if self.depth == MOST_DEPTH {
            self.too_deep(element);
            return Ok(());
        }
        self.depth += 1;
        let mut interface = Vec::new();
        for field in child("ProtoInterface").iter().flat_map(Element::children) {
            if field.is_element() {
                interface.extend(self.given(field)?);
            }
        }
        self.names.enter();
        let mut body = Vec::new();
        for node in child("ProtoBody").iter().flat_map(Element::children) {
            if node.is_element() {
                body.extend(self.statement(node)?.map(|(_, node)| node));
            }
        }
        self.names.leave();
        self.depth -= 1;
        let name = self.intern(element.attribute("name").unwrap_or_default());
        self.names
            .define_proto(Prototype::new(name, interface, body));
        Ok(())
    }

    fn extern_proto(&mut self, element: Element) {
        let urls = element.attribute("url").map(|url| value("url", url));
        let urls = urls.as_ref().and_then(FieldValue::strings);
        let name = self.intern(element.attribute("name").unwrap_or_default());
        self.names.define_proto(Prototype::elsewhere(
            name,
            urls.unwrap_or_default().into_owned(),
        ));
    }
}

/// The children of a node by the field that contains them, in the order in which the fields appear.
#[derive(Default)]
struct ContainedNodes {
    lists: Vec<(Rc<str>, Vec<Rc<VrmlNode>>)>,
    /// Index into `lists`; a search among them would be quadratic where each child has its own field.
    known: HashMap<Rc<str>, usize>,
}

impl ContainedNodes {
    fn add(&mut self, name: Rc<str>, node: Rc<VrmlNode>) {
        let at = *self.known.entry(name.clone()).or_insert_with(|| {
            self.lists.push((name, Vec::new()));
            self.lists.len() - 1
        });
        self.lists[at].1.push(node);
    }

    fn into_fields(self) -> impl Iterator<Item = VrmlField> {
        self.lists.into_iter().map(|(name, nodes)| VrmlField {
            name,
            value: FieldValue::Nodes(nodes),
        })
    }
}

/// The value of an attribute, parsed at once if it may hold many numbers.
fn value(field: &str, text: &str) -> FieldValue {
    match field {
        "point" | "vector" | "color" | "height" | "spine" | "crossSection" | "image" => {
            FieldValue::Numbers(Rc::new(parsed_numbers(text)))
        }
        _ if holds_integers(field) => FieldValue::Integers(Rc::new(parsed_integers(text))),
        _ => FieldValue::Text(text.into()),
    }
}

/// The default container fields, ISO/IEC 19776-1, 6.2, each with the nodes that it is for; it is `children`
/// for all others.
const CONTAINERS: [(&str, &str); 16] = [
    ("appearance", "Appearance"),
    (
        "material",
        "Material TwoSidedMaterial PhysicalMaterial UnlitMaterial",
    ),
    (
        "texture",
        "ImageTexture PixelTexture MovieTexture MultiTexture ComposedCubeMapTexture ImageCubeMapTexture \
         GeneratedCubeMapTexture ComposedTexture3D ImageTexture3D PixelTexture3D RenderedTexture",
    ),
    (
        "textureTransform",
        "TextureTransform MultiTextureTransform TextureTransform3D TextureTransformMatrix3D",
    ),
    ("textureProperties", "TextureProperties"),
    ("lineProperties", "LineProperties"),
    ("pointProperties", "PointProperties"),
    ("fillProperties", "FillProperties"),
    ("coord", "Coordinate CoordinateDouble GeoCoordinate"),
    ("color", "Color ColorRGBA"),
    ("normal", "Normal"),
    (
        "texCoord",
        "TextureCoordinate MultiTextureCoordinate TextureCoordinateGenerator TextureCoordinate3D \
         TextureCoordinate4D",
    ),
    ("fontStyle", "FontStyle ScreenFontStyle"),
    (
        "geometry",
        "Arc2D ArcClose2D Box Circle2D Cone Cylinder Disk2D ElevationGrid Extrusion GeoElevationGrid \
         IndexedFaceSet IndexedLineSet IndexedQuadSet IndexedTriangleFanSet IndexedTriangleSet \
         IndexedTriangleStripSet LineSet NurbsPatchSurface NurbsSweptSurface NurbsSwungSurface \
         NurbsTrimmedSurface NurbsCurve PointSet Polyline2D Polypoint2D QuadSet Rectangle2D Sphere Text \
         TriangleFanSet TriangleSet TriangleSet2D TriangleStripSet",
    ),
    ("shaders", "ComposedShader PackagedShader ProgramShader"),
    (
        "metadata",
        "MetadataBoolean MetadataDouble MetadataFloat MetadataInteger MetadataSet MetadataString",
    ),
];

/// The default container field of a node.
fn container(kind: &str) -> &'static str {
    let holds = |nodes: &str| nodes.split(' ').any(|node| node == kind);
    let field = CONTAINERS.iter().find(|(_, nodes)| holds(nodes));
    field.map_or("children", |(field, _)| field)
}

/// A truncated text without its incomplete last tag and with the open elements closed. `None` if
/// there are none.
fn repaired(text: &str) -> Option<String> {
    let (kept, open) = open_elements(text)?;
    let mut repaired = text[..kept].to_owned();
    for name in open.iter().rev() {
        repaired.push_str("</");
        repaired.push_str(name);
        repaired.push('>');
    }
    Some(repaired)
}

/// The end of the last complete tag, and the elements that are open there.
fn open_elements(text: &str) -> Option<(usize, Vec<&str>)> {
    let mut open = Vec::new();
    let (mut at, mut kept) = (0, 0);
    while let Some(start) = text[at..].find('<').map(|i| at + i) {
        let rest = &text[start..];
        let Some(length) = tag_length(rest) else {
            break;
        };
        let tag = &rest[..length];
        at = start + length;
        if tag.starts_with("</") {
            open.pop();
        } else if !tag.starts_with("<!") && !tag.starts_with("<?") && !tag.ends_with("/>") {
            let name = tag[1..]
                .split(|c: char| c.is_whitespace() || c == '>')
                .next()?;
            open.push(name);
        }
        kept = at;
    }
    (!open.is_empty()).then_some((kept, open))
}

/// Length in bytes of the tag, comment or section at the start of a text.
fn tag_length(text: &str) -> Option<usize> {
    for (start, end) in [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")] {
        if text.starts_with(start) {
            return text.find(end).map(|i| i + end.len());
        }
    }
    let mut quote = None;
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (None, '>') => return Some(i + 1),
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if q == c => quote = None,
            _ => {}
        }
    }
    None
}
