//! One model part: its objects, by their ids, and what is to be built.

use super::package::Package;
use super::properties::{Palette, PropertyGroup, PropertyGroups, color, groups};
use crate::reading::cursor::position;
use crate::reading::text::{shortened, text};
use crate::reading::warnings::Warnings;
use crate::reading::xml::crowded_element;
use crate::{Position, ReadError};
use azulejo_scene::{Attribute, MaterialId, Mesh, Rgb, SharedMesh};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// The namespaces of what is read, by the ends of their names: core, materials, production.
const KNOWN: [&str; 3] = [
    "/3dmanufacturing/core/2015/02",
    "/3dmanufacturing/material/2015/02",
    "/3dmanufacturing/production/2015/06",
];

/// A model part.
pub(super) struct ModelPart {
    /// Length of its unit, metres.
    pub metres: f64,
    pub objects: HashMap<u32, PartObject>,
    /// What is to be built.
    pub items: Vec<Placement>,
}

/// An object of a part.
pub(super) struct PartObject {
    pub name: String,
    pub content: PartContent,
}

pub(super) enum PartContent {
    Mesh(Box<SharedMesh>),
    Components(Vec<Placement>),
}

/// An object in its place.
#[derive(Clone)]
pub(super) struct Placement {
    /// Name of its part, if that is another.
    pub part: Option<String>,
    pub object: u32,
    pub map: DAffine3,
    /// Where it is named.
    pub position: Position,
}

/// Reads the elements of one part.
pub(super) struct PartReader<'r, 'a> {
    pub package: &'r mut Package<'a>,
    pub warnings: &'r mut Warnings,
    /// The name of the file with that of the part.
    pub file: String,
    pub text: String,
    translucent: usize,
}

impl<'r, 'a> PartReader<'r, 'a> {
    /// A reader for the bytes of a part.
    pub fn new(
        package: &'r mut Package<'a>,
        warnings: &'r mut Warnings,
        file: String,
        bytes: &[u8],
    ) -> PartReader<'r, 'a> {
        PartReader {
            package,
            warnings,
            file,
            text: text(bytes).into_owned(),
            translucent: 0,
        }
    }

    /// Reads the part; its materials are added to `palette`.
    ///
    /// # Errors
    /// XML that is not well-formed, numbers that are none, and triangles of vertices that do not exist.
    pub fn read(mut self, palette: &mut Palette) -> Result<ModelPart, ReadError> {
        let source = std::mem::take(&mut self.text);
        if let Some((at, found)) = crowded_element(&source) {
            let error = ReadError::whole(&*self.file, found, "elements as 3MF has them");
            let position = position(source.as_bytes(), at);
            return Err(ReadError { position, ..error });
        }
        let document = Document::parse(&source).map_err(|e| {
            let (message, place) = (e.to_string(), e.pos());
            // The crate's messages end with the position.
            let what = message
                .rsplit_once(" at ")
                .map_or(&*message, |(what, _)| what);
            let found = format!("malformed XML ({what})");
            ReadError::at_line(
                &*self.file,
                &source,
                place.row,
                place.col,
                found,
                "well-formed XML",
            )
        })?;
        let root = document.root_element();
        if root.tag_name().name() != "model" {
            let found = format!("the element \"{}\"", shortened(root.tag_name().name()));
            return Err(self.error(root, found, "model"));
        }
        let part = self.model(root, palette)?;
        let message = "translucent colours: opaque".to_owned();
        self.warnings
            .add_many(&self.file, message, self.translucent, || Position::Whole);
        Ok(part)
    }

    fn model(&mut self, root: Node, palette: &mut Palette) -> Result<ModelPart, ReadError> {
        self.say_extensions(root);
        let unit = root.attribute("unit").unwrap_or("millimeter");
        let known = super::UNITS.iter().find(|(name, _)| *name == unit);
        let Some(&(_, metres)) = known else {
            let found = format!("the unit \"{}\"", shortened(unit));
            let expected = "micron, millimeter, centimeter, inch, foot or meter";
            return Err(self.error(root, found, expected));
        };
        let mut part = ModelPart {
            metres,
            objects: HashMap::new(),
            items: Vec::new(),
        };
        let named =
            |name: &'static str| move |n: &Node| n.is_element() && n.tag_name().name() == name;
        for resources in root.children().filter(named("resources")) {
            let groups = groups(resources, self, palette)?;
            for object in resources.children().filter(named("object")) {
                let id = self.id(object, "id")?;
                let read = self.object(object, id, &groups, palette)?;
                part.objects.insert(id, read);
            }
        }
        for item in root
            .children()
            .filter(named("build"))
            .flat_map(|b| b.children())
        {
            if item.is_element() && item.tag_name().name() == "item" {
                part.items.push(self.placement(item)?);
            }
        }
        Ok(part)
    }

    /// Names extensions without which the model is not what it should be.
    fn say_extensions(&mut self, root: Node) {
        let prefixes = root.attribute("requiredextensions").unwrap_or_default();
        for prefix in prefixes.split_whitespace() {
            let name = root.lookup_namespace_uri(Some(prefix)).unwrap_or(prefix);
            if !KNOWN.iter().any(|known| name.ends_with(known)) {
                let name = shortened(name);
                self.warn(
                    root,
                    format!("the extension {name}, which the model requires, is not read"),
                );
            }
        }
    }

    fn object(
        &mut self,
        node: Node,
        id: u32,
        groups: &PropertyGroups,
        palette: &mut Palette,
    ) -> Result<PartObject, ReadError> {
        let name = match node.attribute("name") {
            Some(name) if !name.trim().is_empty() => name.to_owned(),
            _ => format!("object {id}"),
        };
        let child = |name: &str| {
            let mut children = node.children();
            children.find(|n| n.is_element() && n.tag_name().name() == name)
        };
        let content = if let Some(mesh) = child("mesh") {
            let mesh = self.mesh(node, mesh, groups, palette)?;
            PartContent::Mesh(Box::new(SharedMesh::new(mesh)))
        } else {
            let mut list = Vec::new();
            let components = child("components").into_iter().flat_map(|c| c.children());
            for component in components.filter(|n| n.tag_name().name() == "component") {
                list.push(self.placement(component)?);
            }
            PartContent::Components(list)
        };
        Ok(PartObject { name, content })
    }

    fn placement(&mut self, node: Node) -> Result<Placement, ReadError> {
        // The attribute of the production extension, in its namespace.
        let part = node.attributes().find(|a| a.name() == "path");
        let map = match node.attribute("transform") {
            None => DAffine3::IDENTITY,
            Some(text) => {
                let numbers: Option<Vec<f64>> =
                    text.split_whitespace().map(|w| w.parse().ok()).collect();
                let numbers =
                    numbers.filter(|list| list.len() == 12 && list.iter().all(|x| x.is_finite()));
                let Some(m) = numbers else {
                    let found = format!("the transform \"{}\"", shortened(text));
                    return Err(self.error(node, found, "twelve numbers"));
                };
                // Rows of a matrix that points are multiplied with from the left.
                let row = |k: usize| DVec3::new(m[k], m[k + 1], m[k + 2]);
                DAffine3 {
                    matrix3: DMat3::from_cols(row(0), row(3), row(6)),
                    translation: row(9),
                }
            }
        };
        Ok(Placement {
            part: part.map(|a| a.value().to_owned()),
            object: self.id(node, "objectid")?,
            map,
            position: place(node),
        })
    }

    fn mesh(
        &mut self,
        object: Node,
        node: Node,
        groups: &PropertyGroups,
        palette: &mut Palette,
    ) -> Result<Mesh, ReadError> {
        let mut reader = MeshReader {
            groups,
            usual: [self.index(object, "pid")?, self.index(object, "pindex")?],
            corners: HashMap::new(),
            mesh: Mesh::default(),
            uvs: Vec::new(),
            uv_corners: Vec::new(),
        };
        let mut vertices = Vec::new();
        for list in node.children().filter(Node::is_element) {
            match list.tag_name().name() {
                "vertices" => {
                    for v in list.children().filter(Node::is_element) {
                        let x = self.number(v, "x")?;
                        vertices.push(DVec3::new(x, self.number(v, "y")?, self.number(v, "z")?));
                    }
                }
                "triangles" => {
                    for t in list.children().filter(Node::is_element) {
                        reader.triangle(t, &vertices, self, palette)?;
                    }
                }
                // Sets only group triangles for editors.
                "trianglesets" => {}
                other => self.warn(list, format!("\"{other}\" of a mesh is not read: skipped")),
            }
        }
        Ok(reader.finish())
    }

    /// A number that has to be there.
    pub fn number(&self, node: Node, name: &str) -> Result<f64, ReadError> {
        let text = node.attribute(name).unwrap_or_default();
        let number = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| {
            let found = format!("{name}=\"{}\"", shortened(text));
            self.error(node, found, "a number")
        })
    }

    /// An id that has to be there.
    pub fn id(&self, node: Node, name: &str) -> Result<u32, ReadError> {
        self.index(node, name)?.ok_or_else(|| {
            let found = format!("\"{}\" without {name}", node.tag_name().name());
            self.error(node, found, "a whole number")
        })
    }

    /// A whole number, if it is there.
    fn index(&self, node: Node, name: &str) -> Result<Option<u32>, ReadError> {
        let Some(text) = node.attribute(name) else {
            return Ok(None);
        };
        let number = text.trim().parse().ok().map(Some);
        number.ok_or_else(|| {
            let found = format!("{name}=\"{}\"", shortened(text));
            self.error(node, found, "a whole number")
        })
    }

    /// A colour as linear light; grey if it is missing.
    pub fn color(&mut self, node: Node, name: &str) -> Result<Rgb, ReadError> {
        let text = node.attribute(name).unwrap_or("#BCBCBC");
        let Some((color, is_translucent)) = color(text) else {
            let found = format!("{name}=\"{}\"", shortened(text));
            return Err(self.error(node, found, "a colour as in #e8a030"));
        };
        self.translucent += usize::from(is_translucent);
        Ok(color)
    }

    fn error(&self, node: Node, found: impl Into<String>, expected: &str) -> ReadError {
        ReadError {
            position: place(node),
            ..ReadError::whole(&*self.file, found, expected)
        }
    }

    pub fn warn(&mut self, node: Node, message: String) {
        self.warnings.add(&self.file, message, || place(node));
    }
}

/// Line and column of an element.
fn place(node: Node) -> Position {
    let at = node.document().text_pos_at(node.range().start);
    Position::Line(at.row, at.col)
}

/// A vertex with its colour, as bits.
type ColoredVertex = (u32, [u64; 3]);

/// A mesh under construction.
struct MeshReader<'g> {
    groups: &'g PropertyGroups,
    /// Group and index of triangles that name none.
    usual: [Option<u32>; 2],
    corners: HashMap<ColoredVertex, u32>,
    mesh: Mesh,
    uvs: Vec<DVec2>,
    uv_corners: Vec<u32>,
}

/// What a triangle looks like.
struct TriangleLook {
    material: MaterialId,
    colors: [Rgb; 3],
    uvs: Option<[DVec2; 3]>,
}

impl MeshReader<'_> {
    fn triangle(
        &mut self,
        node: Node,
        vertices: &[DVec3],
        reader: &mut PartReader,
        palette: &mut Palette,
    ) -> Result<(), ReadError> {
        let mut corners = [0; 3];
        for (corner, name) in corners.iter_mut().zip(["v1", "v2", "v3"]) {
            *corner = reader.id(node, name)?;
            if *corner as usize >= vertices.len() {
                let found = format!("{name}=\"{corner}\"");
                let expected = format!("the number of one of {} vertices", vertices.len());
                return Err(reader.error(node, found, &expected));
            }
        }
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            reader.warn(
                node,
                "triangle that uses a vertex twice: skipped".to_owned(),
            );
            return Ok(());
        }
        let look = self.look(node, reader, palette)?;
        let numbers = [0, 1, 2].map(|k| {
            let color = look.colors[k];
            let key = (corners[k], color.to_array().map(f64::to_bits));
            let mesh = &mut self.mesh;
            *self.corners.entry(key).or_insert_with(|| {
                mesh.positions.push(vertices[corners[k] as usize]);
                mesh.colors.push(color);
                mesh.positions.len() as u32 - 1
            })
        });
        self.mesh.push_face(&numbers, look.material);
        // The first coordinates are those of triangles without.
        let first = self.uvs.len() as u32 + 1;
        self.uv_corners.extend(match look.uvs {
            Some(uvs) => {
                self.uvs.extend(uvs);
                [first, first + 1, first + 2]
            }
            None => [0; 3],
        });
        Ok(())
    }

    fn look(
        &mut self,
        node: Node,
        reader: &mut PartReader,
        palette: &mut Palette,
    ) -> Result<TriangleLook, ReadError> {
        let own = reader.index(node, "pid")?;
        let first = reader.index(node, "p1")?;
        let (group, first) = match (own, first) {
            (_, None) => (self.usual[0], self.usual[1]),
            (own, first) => (own.or(self.usual[0]), first),
        };
        let plain = |material| TriangleLook {
            material,
            colors: [Rgb::WHITE; 3],
            uvs: None,
        };
        let (Some(id), Some(first)) = (group, first) else {
            return Ok(plain(palette.plain()));
        };
        let second = reader.index(node, "p2")?.unwrap_or(first);
        let third = reader.index(node, "p3")?.unwrap_or(first);
        let indices = [first, second, third].map(|k| k as usize);
        let missing = || format!("property {first} of group {id} does not exist: grey");
        Ok(match self.groups.get(&id) {
            Some(PropertyGroup::Materials(list)) if first as usize >= list.len() => {
                reader.warn(node, missing());
                plain(palette.plain())
            }
            Some(PropertyGroup::Materials(list)) => {
                if indices != [indices[0]; 3] {
                    let what = "triangle that blends materials: has that of its first corner";
                    reader.warn(node, what.to_owned());
                }
                plain(list[indices[0]])
            }
            Some(PropertyGroup::Colors(list)) if indices.iter().all(|k| *k < list.len()) => {
                let colors = indices.map(|k| list[k]);
                if colors == [colors[0]; 3] {
                    plain(palette.painted(colors[0]))
                } else {
                    TriangleLook {
                        colors,
                        ..plain(palette.white())
                    }
                }
            }
            Some(PropertyGroup::Texture(material, uvs))
                if indices.iter().all(|k| *k < uvs.len()) =>
            {
                TriangleLook {
                    uvs: Some(indices.map(|k| uvs[k])),
                    ..plain(*material)
                }
            }
            Some(PropertyGroup::Unknown) => plain(palette.plain()),
            _ => {
                reader.warn(node, missing());
                plain(palette.plain())
            }
        })
    }

    fn finish(mut self) -> Mesh {
        if self.mesh.colors.iter().all(|c| *c == Rgb::WHITE) {
            self.mesh.colors.clear();
        }
        if !self.uvs.is_empty() {
            self.uvs.insert(0, DVec2::ZERO);
            self.mesh.uvs = Some(Attribute {
                values: self.uvs,
                corners: Some(self.uv_corners),
            });
        }
        self.mesh
    }
}
