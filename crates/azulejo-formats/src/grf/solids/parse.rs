//! Parses solids: extensions with nested members.

use super::super::document::{BlockKind, BoxedError, GrfName, MeshBlock, NameKind, ObjectNotes};
use super::super::entries::{EntryValue, GrfEntries, Taken};
use super::super::mesh::OpenMesh;
use super::super::parse::BlockEnd;
use super::super::parser::{GrfParser, ParseResult};
use super::{
    CsgBlock, DEEPEST, ExactBlock, GlyphBlock, GlyphOrigin, SolidBlock, SolidDefinition, SolidKind,
    TextBlock, has_inverse,
};
use azulejo_scene::{Attribute, Operation, TextFrame};
use glam::{DAffine3, DVec2, DVec3};

const EXTENSION: BlockEnd = BlockEnd::required(&["ext"]);
const LEFT: BlockEnd = BlockEnd::required(&["left"]);
const RIGHT: BlockEnd = BlockEnd::required(&["right"]);

/// The solid keywords.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SolidKeyword {
    Primitive,
    Prism,
    Text,
    Patch,
    Mesh,
    Shell,
    Csg,
    Instance,
}

/// The keywords and ends of solids. The word after `end` is required, because it might begin the
/// next member.
const FORMS: [(&str, SolidKeyword, BlockEnd); 8] = [
    (
        "primitive",
        SolidKeyword::Primitive,
        BlockEnd::required(&["primitive"]),
    ),
    ("prism", SolidKeyword::Prism, BlockEnd::required(&["prism"])),
    ("text", SolidKeyword::Text, BlockEnd::required(&["text"])),
    ("patch", SolidKeyword::Patch, BlockEnd::required(&["patch"])),
    ("mesh", SolidKeyword::Mesh, BlockEnd::required(&["mesh"])),
    ("shell", SolidKeyword::Shell, BlockEnd::required(&["shell"])),
    ("csg", SolidKeyword::Csg, BlockEnd::required(&["csg"])),
    (
        "instance",
        SolidKeyword::Instance,
        BlockEnd::required(&["instance"]),
    ),
];

/// The solids that can be extensions of their own. Primitives and meshes are objects of other
/// types.
const EXTENSIONS: [&str; 6] = ["prism", "text", "patch", "shell", "csg", "instance"];

/// Whether an extension with this lower-case name is one solid or a list of them.
pub(in crate::grf) fn is_solid(extension: &str) -> bool {
    extension == "solids" || EXTENSIONS.contains(&extension)
}

fn form(word: &str) -> Option<&'static (&'static str, SolidKeyword, BlockEnd)> {
    FORMS
        .iter()
        .find(|(name, ..)| word.eq_ignore_ascii_case(name))
}

impl<'a> GrfParser<'a, '_, '_> {
    /// Reads `ext name begin`, for a name with [`is_solid`].
    pub fn exact(&mut self, name: &str, offset: usize) -> ParseResult<BlockKind> {
        let mut notes = ObjectNotes::default();
        let solids = match form(name) {
            Some((_, form, _)) => {
                let entries = GrfEntries::new(format!("`ext {name}`"), offset);
                vec![self.solid(*form, entries, &EXTENSION)?]
            }
            None => {
                let mut entries = GrfEntries::new("`ext solids`", offset);
                let solids = self.members(&mut entries, &EXTENSION)?;
                notes.material = self.take_name(&mut entries, "material", NameKind::Brdf)?;
                self.warn_of_rest(&entries);
                solids
            }
        };
        Ok(BlockKind::Exact(Box::new(ExactBlock {
            solids,
            skin: None,
            notes,
        })))
    }

    /// Reads a definition, after `ext define begin`.
    pub fn solid_definition(&mut self, offset: usize) -> ParseResult<BlockKind> {
        let mut entries = GrfEntries::new("`ext define`", offset);
        let solids = self.members(&mut entries, &EXTENSION)?;
        let name = self.defined_name(&mut entries, NameKind::Solid)?;
        let material = self.take_name(&mut entries, "material", NameKind::Brdf)?;
        self.warn_of_rest(&entries);
        Ok(BlockKind::Define(Box::new(SolidDefinition {
            name,
            material,
            solids,
        })))
    }

    /// Reads keys, solids, and the end.
    fn members(
        &mut self,
        entries: &mut GrfEntries<'a>,
        ending: &BlockEnd,
    ) -> ParseResult<Vec<SolidBlock>> {
        let mut solids = Vec::new();
        self.entries_and(entries, |parser| parser.member(&mut solids))?;
        self.end(entries.offset, ending)?;
        Ok(solids)
    }

    /// Reads `kind begin ... end kind`, if that comes next.
    fn member(&mut self, solids: &mut Vec<SolidBlock>) -> ParseResult<bool> {
        let offset = self.lexer.skip_blank();
        let Some((name, form, ending)) = self.lexer.peek_word().and_then(form) else {
            return Ok(false);
        };
        self.lexer.word();
        self.expect_word("begin")?;
        self.shared.solid_depth += 1;
        if self.shared.solid_depth > DEEPEST {
            return Err(self.fail(
                offset,
                "one more nested solid",
                format!("at most {DEEPEST} nested levels"),
            ));
        }
        let entries = GrfEntries::new(format!("`{name}`"), offset);
        solids.push(self.solid(*form, entries, ending)?);
        self.shared.solid_depth -= 1;
        Ok(true)
    }

    /// Reads the content of a solid and its end.
    fn solid(
        &mut self,
        form: SolidKeyword,
        mut entries: GrfEntries<'a>,
        ending: &BlockEnd,
    ) -> ParseResult<SolidBlock> {
        let place = self.place(entries.offset);
        let kind = match form {
            SolidKeyword::Shell => SolidKind::Shell(self.members(&mut entries, ending)?),
            SolidKeyword::Csg => self.csg(&mut entries, ending)?,
            SolidKeyword::Text => self.text(&mut entries, ending)?,
            SolidKeyword::Mesh => SolidKind::Mesh(self.polygons(&mut entries, ending)?),
            SolidKeyword::Primitive
            | SolidKeyword::Prism
            | SolidKeyword::Patch
            | SolidKeyword::Instance => {
                self.entries_and(&mut entries, |_| Ok(false))?;
                self.end(entries.offset, ending)?;
                self.simple(form, &mut entries)?
            }
        };
        let material = self.take_name(&mut entries, "material", NameKind::Brdf)?;
        self.warn_of_rest(&entries);
        Ok(SolidBlock {
            place,
            material,
            kind,
        })
    }
}

impl<'a> GrfParser<'a, '_, '_> {
    fn simple(
        &mut self,
        form: SolidKeyword,
        entries: &mut GrfEntries<'a>,
    ) -> ParseResult<SolidKind> {
        match form {
            SolidKeyword::Prism => {
                let figure = self.needed_name(entries, "figure", NameKind::Figure)?;
                let map = self.take_map(entries)?;
                let map = self.required(entries, "map", map)?;
                let bevel = self.take_bevel(entries)?;
                Ok(SolidKind::Prism(figure, Box::new(map), bevel))
            }
            SolidKeyword::Patch => self.patch(entries),
            SolidKeyword::Instance => {
                let of = self.needed_name(entries, "of", NameKind::Solid)?;
                let map = self.take_map(entries)?;
                Ok(SolidKind::Instance(of, map.map(Box::new)))
            }
            _ => {
                let (kind, map) = self.unit_primitive(entries)?;
                Ok(SolidKind::Primitive(kind, Box::new(map)))
            }
        }
    }

    fn patch(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<SolidKind> {
        let entry = self.needed(entries, "points")?;
        match &entry.value {
            EntryValue::Vectors(list) if list.len() == 16 => {
                let point = |k: usize| DVec3::from_array(list[k]);
                let row = |r: usize| std::array::from_fn(|c| point(4 * r + c));
                Ok(SolidKind::Patch(Box::new(std::array::from_fn(row))))
            }
            _ => Err(self.wrong(&entry, "16 control points (x, y, z), row by row")),
        }
    }

    /// `map = ...`, which must be invertible.
    fn take_map(&mut self, entries: &mut GrfEntries<'a>) -> Taken<DAffine3> {
        let Some(entry) = entries.take("map") else {
            return Ok(None);
        };
        match entry.value.map().filter(has_inverse) {
            Some(map) => Ok(Some(map)),
            None => Err(self.not_a_map(&entry)),
        }
    }
}

impl<'a> GrfParser<'a, '_, '_> {
    fn csg(&mut self, entries: &mut GrfEntries<'a>, ending: &BlockEnd) -> ParseResult<SolidKind> {
        let (mut left, mut right) = (Vec::new(), Vec::new());
        self.entries_and(entries, |parser| {
            Ok(parser.side(&LEFT, &mut left)? || parser.side(&RIGHT, &mut right)?)
        })?;
        self.end(entries.offset, ending)?;
        for (side, solids) in [("left", &left), ("right", &right)] {
            if solids.is_empty() {
                return Err(self.without_side(entries, side));
            }
        }
        let operation = self.operation(entries)?;
        Ok(SolidKind::Csg(Box::new(CsgBlock {
            operation,
            left,
            right,
        })))
    }

    fn operation(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<Operation> {
        let operations = [
            ("union", Operation::Union),
            ("difference", Operation::Difference),
            ("intersection", Operation::Intersection),
        ];
        let operation = self.take_choice(entries, "operation", &operations)?;
        self.required(entries, "operation", operation)
    }

    #[cold]
    fn without_side(&mut self, entries: &GrfEntries<'_>, side: &str) -> BoxedError {
        self.fail(
            entries.offset,
            format!("{} without a solid on its {side} side", entries.title),
            format!("`{side} begin`, solids and `end {side}` in it"),
        )
    }

    /// Reads `left begin ... end left`, if that comes next.
    fn side(&mut self, ending: &BlockEnd, solids: &mut Vec<SolidBlock>) -> ParseResult<bool> {
        let offset = self.lexer.skip_blank();
        if !self.lexer.eat_word(ending.words[0]) {
            return Ok(false);
        }
        self.expect_word("begin")?;
        while self.member(solids)? {}
        self.end(offset, ending)?;
        Ok(true)
    }
}

impl<'a> GrfParser<'a, '_, '_> {
    fn text(&mut self, entries: &mut GrfEntries<'a>, ending: &BlockEnd) -> ParseResult<SolidKind> {
        let mut glyphs = Vec::new();
        self.entries_and(entries, |parser| parser.glyph(&mut glyphs))?;
        self.end(entries.offset, ending)?;
        glyphs.shrink_to_fit();
        let map = match self.take_map(entries)? {
            Some(map) => map,
            None => self.frame(entries)?,
        };
        Ok(SolidKind::Text(Box::new(TextBlock {
            string: self.take_text(entries, "string")?,
            map,
            bevel: self.take_bevel(entries)?,
            glyphs,
        })))
    }

    /// Reads `figure (x, y)` or `figure (x, y, z)`, if a name and a bracket come next.
    fn glyph(&mut self, glyphs: &mut Vec<GlyphBlock>) -> ParseResult<bool> {
        let mut ahead = self.lexer;
        if ahead.word().is_none() || !ahead.eat(b'(') {
            return Ok(false);
        }
        let figure = self.used(NameKind::Figure)?;
        let pen = match self.vector2_or_3()? {
            (pen, None) => GlyphOrigin::Along(pen),
            (pen, Some(z)) => GlyphOrigin::At(pen.extend(z)),
        };
        glyphs.push(GlyphBlock { figure, pen });
        Ok(true)
    }

    /// The map given by the keys of a [`TextFrame`].
    fn frame(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<DAffine3> {
        let origin = self.take_point(entries, "origin")?;
        let frame = TextFrame {
            origin: origin.unwrap_or_default(),
            progression: self.take_direction(entries, "progression", DVec3::X)?,
            up: self.take_direction(entries, "up", DVec3::Y)?,
            extrusion: self.take_direction(entries, "extrusion", DVec3::NEG_Z)?,
            scale: self.take_scale(entries)?,
        };
        let map = frame.world_from_glyph(DVec2::ZERO);
        if has_inverse(&map) {
            return Ok(map);
        }
        Err(self.fail(
            entries.offset,
            "a text with a singular frame",
            "`progression`, `up` and `extrusion` in three directions, and a `scale` without 0",
        ))
    }

    fn take_direction(
        &mut self,
        entries: &mut GrfEntries<'a>,
        key: &str,
        default: DVec3,
    ) -> ParseResult<DVec3> {
        let direction = self.take_point(entries, key)?.unwrap_or(default);
        match super::super::unit(direction) {
            Some(unit) => Ok(unit),
            None => Err(self.fail(
                entries.offset,
                format!("`{key}` of length 0"),
                "a non-zero vector",
            )),
        }
    }

    /// One scale for all directions, or one for each.
    fn take_scale(&mut self, entries: &mut GrfEntries<'a>) -> ParseResult<DVec3> {
        let Some(entry) = entries.take("scale") else {
            return Ok(DVec3::ONE);
        };
        match &entry.value {
            EntryValue::Numbers(n) if n.len() == 1 => Ok(DVec3::splat(n[0])),
            EntryValue::Vectors(v) if v.len() == 1 => Ok(DVec3::from_array(v[0])),
            _ => Err(self.wrong(&entry, "one number or (x, y, z)")),
        }
    }
}

impl<'a> GrfParser<'a, '_, '_> {
    /// Vertices and faces without appearance, and the keys that describe them further.
    pub fn polygons(
        &mut self,
        entries: &mut GrfEntries<'a>,
        ending: &BlockEnd,
    ) -> ParseResult<Box<MeshBlock>> {
        let mut open = OpenMesh::default();
        self.entries_and(entries, |parser| {
            let is_list = parser.lexer.eat_word("begin");
            if is_list {
                parser.mesh_list(&mut open)?;
            }
            Ok(is_list)
        })?;
        self.check_indices(&open)?;
        self.end(entries.offset, ending)?;
        let mut mesh = Box::new(open.block);
        if !mesh.changes.is_empty() {
            return Err(self.fail(
                entries.offset,
                format!("{} with appearances before its faces", entries.title),
                "vertices and faces only: its material is given outside of them",
            ));
        }
        let (vertices, faces) = (mesh.vertices.positions.len(), mesh.faces.len());
        if entries.has("irad_error") {
            mesh.notes.irradiance_error = self.rgb_list(entries, "irad_error", vertices)?;
        }
        if entries.has("smoothing") {
            mesh.notes.smoothing = self.counts(entries, "smoothing", (faces, "face"))?;
        }
        if entries.has("normals") {
            let corners = mesh.faces.corners.len();
            mesh.notes.normals = Some(Box::new(self.corner_normals(entries, corners)?));
        }
        Ok(mesh)
    }

    /// `normals`, a list, and `corners`, the index of each corner's normal.
    fn corner_normals(
        &mut self,
        entries: &mut GrfEntries<'a>,
        corners: usize,
    ) -> ParseResult<Attribute<DVec3>> {
        let entry = self.needed(entries, "normals")?;
        let EntryValue::Vectors(list) = &entry.value else {
            return Err(self.wrong(&entry, "vectors (x, y, z)"));
        };
        let unit = |v: &[f64; 3]| super::super::unit(DVec3::from_array(*v));
        let Some(values) = list.iter().map(unit).collect::<Option<Vec<_>>>() else {
            return Err(self.fail(entry.offset, "a normal of length 0", "non-zero vectors"));
        };
        let at = entry.offset;
        let indices = self.counts(entries, "corners", (corners, "corner"))?;
        if let Some(index) = indices.iter().find(|&&i| i as usize >= values.len()) {
            return Err(self.fail(
                at,
                format!("normal {index} of {}", values.len()),
                "an index of one of the `normals`",
            ));
        }
        Ok(Attribute {
            values,
            corners: Some(indices),
        })
    }

    /// The name that an extension defines.
    pub fn defined_name(
        &mut self,
        entries: &mut GrfEntries<'a>,
        kind: NameKind,
    ) -> ParseResult<GrfName> {
        let (word, offset) = self.needed_word(entries, "name")?;
        let name = self.shared.intern(word);
        self.define(offset, kind, &name);
        self.record_definition(offset, kind, &name);
        Ok(name)
    }
}
