//! Meshes: vertex lists and face lists, which make up nearly all of a file.

use super::document::{AppearanceChange, BlockKind, MeshBlock, NameKind, VertexColumn, VertexList};
use super::layout::{IrradLayout, VertexLayout};
use super::parse::BlockEnd;
use super::parser::{GrfParser, ParseResult};
use azulejo_scene::Rgb;

const MESH: BlockEnd = BlockEnd::optional(&["mesh"]);
const MESH_LIGHT: BlockEnd = BlockEnd::optional(&["mesh", "light"]);
const VERTICES: BlockEnd = BlockEnd::optional(&["vertices", "vertexs"]);
const FACES: BlockEnd = BlockEnd::optional(&["faces"]);

/// Maximum number of vertices of a mesh.
const MOST_VERTICES: usize = 1 << 31;
/// Maximum number of corners of a mesh, which are counted in 32 bits.
const MOST_CORNERS: usize = u32::MAX as usize;

/// A mesh that is being read.
#[derive(Default)]
pub(super) struct OpenMesh {
    pub block: MeshBlock,
    /// The largest index of its faces, with the offset.
    largest: Option<(u32, usize)>,
}

/// Whether a word opens or ends a vertex list.
pub(super) fn is_vertices(word: &str) -> bool {
    word.eq_ignore_ascii_case("vertices") || word.eq_ignore_ascii_case("vertexs")
}

impl GrfParser<'_, '_, '_> {
    /// Reads the content of a mesh and its `end`.
    pub fn mesh(&mut self, offset: usize, is_light: bool) -> ParseResult<BlockKind> {
        let mut mesh = OpenMesh::default();
        mesh.block.is_light = is_light;
        loop {
            if self.lexer.eat_word("begin") {
                self.mesh_list(&mut mesh)?;
                continue;
            }
            let at = self.lexer.skip_blank();
            if is_light && self.lexer.eat_word("rgb") {
                mesh.block.radiance = Some(self.rgb()?);
            } else if let Some(change) = self.change()? {
                if mesh.block.faces.is_empty() {
                    mesh.block.head.push(change);
                } else {
                    self.warn(at, "`use` after the faces of a mesh has no effect: skipped");
                }
            } else if self.lexer.eat(b';') {
            } else if self.at_end() {
                break;
            } else {
                let expected = "`begin vertices`, `begin faces`, `use`, or `end mesh`";
                return Err(self.unexpected(expected));
            }
        }
        self.check_indices(&mesh)?;
        self.end(offset, if is_light { &MESH_LIGHT } else { &MESH })?;
        Ok(BlockKind::Mesh(Box::new(mesh.block)))
    }

    /// At `end`, and at the end of the file, which [`end`](GrfParser::end) reports.
    pub fn at_end(&mut self) -> bool {
        self.lexer.peek().is_none()
            || self
                .lexer
                .peek_word()
                .is_some_and(|word| word.eq_ignore_ascii_case("end"))
    }

    /// Reads a list of a mesh, after `begin`.
    pub fn mesh_list(&mut self, mesh: &mut OpenMesh) -> ParseResult<()> {
        let offset = self.lexer.skip_blank();
        if self.lexer.peek_word().is_some_and(is_vertices) {
            self.lexer.word();
            return self.vertices(offset, &mut mesh.block.vertices);
        }
        if self.lexer.eat_word("faces") {
            return self.faces(offset, mesh);
        }
        Err(self.unexpected("`vertices` or `faces`"))
    }

    pub fn check_indices(&mut self, mesh: &OpenMesh) -> ParseResult<()> {
        let count = mesh.block.vertices.positions.len();
        match mesh.largest {
            Some((index, at)) if index as usize >= count => Err(self.fail(
                at,
                format!("vertex {index} of a mesh with {count} vertices"),
                match count {
                    0 => "a vertex list that contains it".to_owned(),
                    _ => format!("an index from 0 to {}", count - 1),
                },
            )),
            _ => Ok(()),
        }
    }

    fn vertices(&mut self, offset: usize, vertices: &mut VertexList) -> ParseResult<()> {
        let mut irradiance = None;
        loop {
            match self.lexer.peek() {
                Some(b'(') => {
                    let start = self.lexer.skip_blank();
                    let position = self.vector3()?;
                    if let Some(layout) = &mut self.shared.layout {
                        layout.open_vertices.push(VertexLayout {
                            position: start,
                            irradiance: irradiance.take(),
                        });
                    }
                    if vertices.positions.len() >= MOST_VERTICES {
                        return Err(self.unexpected("at most 2^31 vertices in a mesh"));
                    }
                    vertices.positions.push(position);
                }
                Some(b';') => {
                    self.lexer.eat(b';');
                }
                Some(_) if !self.at_end() => {
                    let place = self.vertex_attribute(vertices)?;
                    irradiance = irradiance.or(place);
                }
                _ => return self.end(offset, &VERTICES),
            }
        }
    }

    /// Reads an attribute; returns the place of `irad`.
    fn vertex_attribute(&mut self, vertices: &mut VertexList) -> ParseResult<Option<IrradLayout>> {
        let offset = self.lexer.skip_blank();
        let vertex = vertices.positions.len();
        if self.lexer.eat_word("normal") {
            let normal = self.vector3()?;
            self.set(&mut vertices.normals, vertex, normal, offset);
        } else if self.lexer.eat_word("irad") {
            let vector = self.lexer.skip_blank();
            let irradiance = self.rgb()?;
            self.set(&mut vertices.irradiance, vertex, irradiance, offset);
            return Ok(Some(IrradLayout {
                keyword: offset,
                vector,
                end: self.lexer.pos(),
            }));
        } else if self.lexer.eat_word("uv") {
            let uv = self.vector2()?;
            self.set(&mut vertices.uvs, vertex, uv, offset);
        } else if self.lexer.eat_word("rgb") {
            let color = self.rgb()?;
            self.set(&mut vertices.colors, vertex, color, offset);
        } else if self.lexer.eat_word("use") {
            self.color_word()?;
            let name = self.used(NameKind::Color)?;
            // The column holds a placeholder, so that the attribute counts as present.
            self.set(&mut vertices.colors, vertex, Rgb::WHITE, offset);
            vertices.named_colors.push((vertex as u32, name));
        } else {
            return Err(self.unexpected(
                "a vertex (`normal`, `irad`, `uv`, `rgb` or `use color`, and `(x, y, z)`), or `end vertices`",
            ));
        }
        Ok(None)
    }

    fn color_word(&mut self) -> ParseResult<()> {
        if self.lexer.eat_word("colour") || self.lexer.eat_word("rgb") {
            return Ok(());
        }
        self.expect_word("color")
    }

    fn set<T: Copy + Default>(
        &mut self,
        column: &mut VertexColumn<T>,
        vertex: usize,
        value: T,
        offset: usize,
    ) {
        if column.get(vertex).is_some() {
            self.warn(
                offset,
                "a vertex has the same attribute twice: the first one is used",
            );
        } else {
            column.push(vertex, value);
        }
    }

    fn faces(&mut self, offset: usize, mesh: &mut OpenMesh) -> ParseResult<()> {
        loop {
            match self.lexer.peek() {
                Some(b'(') => self.face_in_brackets(mesh)?,
                Some(b'0'..=b'9') => self.counted_face(mesh)?,
                Some(b';') => {
                    self.lexer.eat(b';');
                }
                Some(_) if !self.at_end() => {
                    let Some(change) = self.change()? else {
                        return Err(self.unexpected(
                            "a face `(i, j, k, ...)`, `rgb`, `brdf`, `texture`, `use`, or `end faces`",
                        ));
                    };
                    let face = mesh.block.faces.len() as u32;
                    mesh.block.changes.push((face, change));
                }
                _ => return self.end(offset, &FACES),
            }
        }
    }

    /// A change of the appearance of the faces that follow; `None` if something else comes next.
    fn change(&mut self) -> ParseResult<Option<AppearanceChange>> {
        let word = self.lexer.peek_word().unwrap_or("");
        let is = |list: &[&str]| list.iter().any(|w| word.eq_ignore_ascii_case(w));
        if is(&["rgb", "brdf", "texture"]) {
            return self.body().map(|body| Some(AppearanceChange::Set(body)));
        }
        if !is(&["use"]) {
            return Ok(None);
        }
        self.lexer.word();
        let kind = if self.lexer.eat_word("brdf") {
            NameKind::Brdf
        } else if self.lexer.eat_word("texture") {
            NameKind::Texture
        } else if self.lexer.eat_word("color")
            || self.lexer.eat_word("colour")
            || self.lexer.eat_word("rgb")
        {
            NameKind::Color
        } else {
            return Err(self.unexpected("`color`, `brdf` or `texture`"));
        };
        let name = self.used(kind)?;
        Ok(Some(AppearanceChange::Use(kind, name)))
    }

    /// `(i, j, k, ...)`
    fn face_in_brackets(&mut self, mesh: &mut OpenMesh) -> ParseResult<()> {
        let start = self.lexer.skip_blank();
        self.record_face(start);
        self.expect(b'(')?;
        let first = mesh.block.faces.corners.len();
        loop {
            self.corner(mesh)?;
            if self.lexer.eat(b',') {
                continue;
            }
            if self.lexer.eat(b')') {
                break;
            }
            let next = self.lexer.skip_blank();
            if !self.lexer.at_number() {
                return Err(self.unexpected("`,` or `)`"));
            }
            self.warn(next, "missing comma between two numbers");
        }
        self.close_face(mesh, first, start)
    }

    /// `n i1 i2 ... in`
    fn counted_face(&mut self, mesh: &mut OpenMesh) -> ParseResult<()> {
        let start = self.lexer.skip_blank();
        self.record_face(start);
        let count = self
            .lexer
            .index()
            .map_err(|_| self.unexpected("the number of a face's corners"))?;
        let first = mesh.block.faces.corners.len();
        for k in 0..count {
            if k > 0 {
                self.lexer.eat(b',');
            }
            self.corner(mesh)?;
        }
        self.close_face(mesh, first, start)
    }

    fn record_face(&mut self, start: usize) {
        if let Some(layout) = &mut self.shared.layout {
            layout.open_faces.push(start);
        }
    }

    fn corner(&mut self, mesh: &mut OpenMesh) -> ParseResult<()> {
        let at = self.lexer.skip_blank();
        let index = self.index()?;
        if mesh.largest.is_none_or(|(most, _)| index > most) {
            mesh.largest = Some((index, at));
        }
        mesh.block.faces.corners.push(index);
        Ok(())
    }

    fn close_face(&mut self, mesh: &mut OpenMesh, first: usize, start: usize) -> ParseResult<()> {
        let end = mesh.block.faces.corners.len();
        if end - first < 3 {
            return Err(self.fail(
                start,
                format!("a face with {} corners", end - first),
                "a face with at least 3 corners",
            ));
        }
        if end > MOST_CORNERS {
            return Err(self.unexpected("at most 2^32 corners in a mesh"));
        }
        mesh.block.faces.starts.push(end as u32);
        Ok(())
    }
}
