//! A GRF file as text, into which the light of its solved scene is written without touching anything
//! else.

use super::document::{BlockKind, GrfBlock, GrfDocument};
use super::layout::{GrfLayout, ObjectLayout};
use super::parse::joined;
use super::placement::{OuterTransform, affine, is_mirror, reverse_faces};
use super::solids::{skin, skin_block};
use super::text_edit::{TextEdit, after_blank, edited, end_of_statement, line_end};
use super::write::{GrfOutput, back_irradiance, irradiance_error, rgb, surface_light};
use crate::reading::text::{decoded_text, encoded_like};
use crate::{Files, ReadError};
use azulejo_scene::{BackIrradiance, Mesh, Object, Rgb, Scene, Shape};
use glam::DAffine3;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::io::{self, BufWriter};
use std::ops::Range;

/// A GRF file, kept byte for byte with the places of its parts.
///
/// [`lit`](GrfText::lit) returns the same text with the irradiance of a solved scene: `irad` before
/// each vertex, and what else carries light as extensions behind its object. Comments, white space,
/// spellings, names, transforms, parameters and unknown extensions stay.
#[derive(Debug)]
pub struct GrfText {
    name: String,
    bytes: Vec<u8>,
    document: GrfDocument,
    layout: Box<GrfLayout>,
}

/// What [`GrfText::lit`] returns.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LitText {
    /// The file with its light, in the encoding it had.
    pub bytes: Vec<u8>,
    /// Included files with surfaces, which now stand in the text instead of their `include`, because
    /// each use of a part has light of its own.
    pub unfolded: BTreeSet<String>,
    /// Number of objects with light on backs, which is in `ext irad_back`.
    pub backs: usize,
    /// Number of exact shapes and primitives, whose light is in `ext skin` and `ext surface_light`.
    pub exact: usize,
}

/// Why light cannot be written into a text.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NotLiteral {
    /// The objects of the scene are not those of the file: faces turned or divided, objects added.
    OtherScene,
    /// The text has bytes that its encoding does not allow, which would change, or gets letters from
    /// an included file that it cannot express.
    Encoding,
    /// The text would be read differently; which it should not be.
    Changed(String),
}

impl fmt::Display for NotLiteral {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotLiteral::OtherScene => {
                f.write_str("the objects of the solved scene are not those of the file")
            }
            NotLiteral::Encoding => f.write_str(
                "the text cannot be written again in its encoding: save the file as UTF-8 first",
            ),
            NotLiteral::Changed(what) => write!(f, "the text with light would be another: {what}"),
        }
    }
}

impl std::error::Error for NotLiteral {}

/// The replacements in each file, by its index.
type FileEdits = BTreeMap<u32, Vec<TextEdit>>;

impl GrfText {
    /// Parses a file and its includes, as [`GrfDocument::parse`] does.
    ///
    /// # Errors
    /// The first syntax error.
    pub fn parse(bytes: Vec<u8>, name: &str, files: &dyn Files) -> Result<GrfText, ReadError> {
        let places = Some(Box::default());
        let parsed = GrfDocument::parse_with(&bytes, name, files, places)?;
        Ok(GrfText {
            name: name.to_owned(),
            bytes,
            document: parsed.document,
            layout: parsed.layout,
        })
    }

    /// The bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Whether the file names other files, relative to its folder.
    pub fn names_files(&self) -> bool {
        !self.layout.names.is_empty()
    }

    /// The text with the irradiance of the solved scene, which was read from it and has kept its
    /// vertices and faces.
    ///
    /// `irad` and the extensions that carry light are added, replaced, or removed where the scene has
    /// none. Standard errors are written where the file had them. An include with surfaces gives way
    /// to the included text, with its comments; its file stays as it is. The result is parsed again
    /// and compared, so light is not lost unnoticed.
    ///
    /// # Errors
    /// [`NotLiteral`].
    pub fn lit(&self, scene: &Scene, files: &dyn Files) -> Result<LitText, NotLiteral> {
        if encoded_like(&self.bytes, &decoded_text(&self.bytes)).as_deref() != Some(&self.bytes) {
            return Err(NotLiteral::Encoding);
        }
        // Each use of an included part has light of its own.
        let scene = &*scene.unfolded();
        let mut blocks = Vec::new();
        collect(&self.document.blocks, None, &mut blocks);
        let objects = &scene.objects;
        if blocks.len() != objects.len() || self.layout.objects.len() != objects.len() {
            return Err(NotLiteral::OtherScene);
        }
        let mut lit = LitText::default();
        let mut edits = FileEdits::new();
        for ((block, place), object) in blocks.iter().zip(&self.layout.objects).zip(objects) {
            if !is_same(block, object) {
                return Err(NotLiteral::OtherScene);
            }
            let source = LightSource {
                scene,
                object,
                shared: shared_by(block.kind, object),
                outer: block.outer,
                text: &self.layout.texts[place.file as usize],
                place,
            };
            source.edits(edits.entry(place.file).or_default(), &mut lit);
        }
        edits.retain(|_, list| !list.is_empty());
        let text = self.file_text(0, &mut edits, &mut lit);
        lit.bytes = encoded_like(&self.bytes, &text).ok_or(NotLiteral::Encoding)?;
        self.check(&lit.bytes, scene, files)?;
        Ok(lit)
    }

    /// The text of a file after its edits, with the included files that are edited too.
    fn file_text(&self, file: u32, edits: &mut FileEdits, lit: &mut LitText) -> String {
        let text = &self.layout.texts[file as usize];
        let mut here = edits.remove(&file).unwrap_or_default();
        let end = line_end(text);
        let mut gone: Vec<Range<usize>> = Vec::new();
        for include in self.layout.includes.iter().filter(|i| i.file == file) {
            if !self.is_edited(include.target, edits) {
                continue;
            }
            let path = self.path(include.target).to_owned();
            let content = self.file_text(include.target, edits, lit);
            let content = content.trim_end();
            here.push(TextEdit {
                range: include.range.clone(),
                text: format!(
                    "// from here: include \"{path}\"{end}{content}{end}// to here: \"{path}\"{end}"
                ),
            });
            lit.unfolded.insert(path);
            gone.push(include.range.clone());
        }
        if file != 0 {
            // The name of an include that was replaced is gone with it.
            let stays = |e: &TextEdit| !gone.iter().any(|r| r.contains(&e.range.start));
            here.extend(self.renamed(file).filter(stays));
        }
        here.sort_by_key(|e| e.range.start);
        edited(text, &here)
    }

    /// Whether a file or one that it includes is edited.
    fn is_edited(&self, file: u32, edits: &FileEdits) -> bool {
        let mut inner = self.layout.includes.iter().filter(|i| i.file == file);
        edits.contains_key(&file) || inner.any(|i| self.is_edited(i.target, edits))
    }

    fn path(&self, file: u32) -> &str {
        (self.document.sources.get(file)).map_or("", |source| &source.path)
    }

    /// The file names of an included file, for the folder of the outermost one.
    fn renamed(&self, file: u32) -> impl Iterator<Item = TextEdit> {
        let path = self.path(file);
        let names = self.layout.names.iter().filter(move |n| n.file == file);
        let named = names.map(move |n| (n, joined(path, &n.name)));
        let changed = named.filter(move |(n, path)| path != &n.name);
        changed.map(|(n, path)| TextEdit {
            range: n.range.clone(),
            text: format!("\"{path}\""),
        })
    }

    /// Reads the text with light again and compares it with the solved scene.
    fn check(&self, bytes: &[u8], solved: &Scene, files: &dyn Files) -> Result<(), NotLiteral> {
        let changed = |e: ReadError| NotLiteral::Changed(e.to_string());
        let (document, _) = GrfDocument::parse(bytes, &self.name, files).map_err(changed)?;
        let mut again = document.resolve().map_err(changed)?.scene;
        let mut before = self.document.resolve().map_err(changed)?.scene;
        if again.objects.len() != solved.objects.len() {
            return Err(NotLiteral::Changed("objects".to_owned()));
        }
        for (read, lit) in again.objects.iter().zip(&solved.objects) {
            if !has_light_of(&read.shape, &lit.shape) {
                let what = format!("the light of the object \"{}\"", lit.name);
                return Err(NotLiteral::Changed(what));
            }
        }
        again.objects.iter_mut().for_each(darken);
        before.objects.iter_mut().for_each(darken);
        if again == before {
            Ok(())
        } else {
            Err(NotLiteral::Changed("more than light".to_owned()))
        }
    }
}

/// A block that makes an object, with the transforms around it.
struct ObjectBlock<'d> {
    kind: &'d BlockKind,
    outer: OuterTransform,
}

/// The blocks that make objects, in the order of the objects.
fn collect<'d>(blocks: &'d [GrfBlock], outer: OuterTransform, out: &mut Vec<ObjectBlock<'d>>) {
    for block in blocks {
        match &block.kind {
            BlockKind::Mesh(_)
            | BlockKind::AreaLight(_)
            | BlockKind::Primitive(_)
            | BlockKind::Exact(_) => out.push(ObjectBlock {
                kind: &block.kind,
                outer,
            }),
            BlockKind::Transform { steps, blocks } => {
                let map = outer.unwrap_or(DAffine3::IDENTITY) * affine(steps);
                collect(blocks, Some(map), out);
            }
            BlockKind::Include { blocks, .. } => collect(blocks, outer, out),
            BlockKind::Definitions {
                blocks: Some(blocks),
                ..
            } => collect(blocks, outer, out),
            _ => {}
        }
    }
}

/// Whether an object is that of a block, with the same vertices and faces.
fn is_same(block: &ObjectBlock<'_>, object: &Object) -> bool {
    match (block.kind, &object.shape) {
        (BlockKind::Mesh(given), Shape::Mesh(mesh)) => {
            let mut faces = Cow::Borrowed(&given.faces);
            if is_mirror(block.outer) {
                reverse_faces(faces.to_mut());
            }
            let count = mesh.positions.len();
            let copies = shared_by(block.kind, object);
            for corner in &mut faces.to_mut().corners {
                if let Some(copy) = (*corner as usize).checked_sub(count) {
                    *corner = copies.get(copy).copied().unwrap_or(*corner);
                }
            }
            given.vertices.positions.len() == count + copies.len()
                && *faces == mesh.faces
                && (mesh.irradiance.is_empty() || mesh.irradiance.len() == count)
        }
        (BlockKind::AreaLight(_) | BlockKind::Primitive(_), Shape::Primitive(_))
        | (BlockKind::Exact(_), Shape::Exact(_)) => true,
        _ => false,
    }
}

/// The originals of the copies at the end of a block's vertices, if its object shares them.
fn shared_by<'d>(block: &'d BlockKind, object: &Object) -> &'d [u32] {
    match (block, &object.shape) {
        (BlockKind::Mesh(given), Shape::Mesh(mesh))
            if given.vertices.positions.len() != mesh.positions.len() =>
        {
            &given.notes.shared
        }
        _ => &[],
    }
}

/// The light of a mesh, with that of copies of its vertices.
fn copied_light(mesh: &Mesh, shared: &[u32]) -> Mesh {
    let with_copies = |list: &[Rgb]| -> Vec<Rgb> {
        let copies = shared.iter().filter_map(|&v| list.get(v as usize));
        list.iter().chain(copies).copied().collect()
    };
    Mesh {
        irradiance: with_copies(&mesh.irradiance),
        irradiance_error: with_copies(&mesh.irradiance_error),
        back: mesh.back.as_deref().map(|back| {
            let copies = shared.iter().map(|&v| back.irradiance[v as usize]);
            Box::new(BackIrradiance {
                irradiance: back.irradiance.iter().copied().chain(copies).collect(),
                error: with_copies(&back.error),
            })
        }),
        ..Mesh::default()
    }
}

/// An object with light, and the text of its block.
struct LightSource<'a> {
    scene: &'a Scene,
    object: &'a Object,
    /// The originals of the copies at the end of the text's vertices.
    shared: &'a [u32],
    outer: OuterTransform,
    text: &'a str,
    place: &'a ObjectLayout,
}

impl LightSource<'_> {
    fn edits(&self, edits: &mut Vec<TextEdit>, lit: &mut LitText) {
        match &self.object.shape {
            Shape::Mesh(mesh) => {
                let mesh = &copied_light(mesh, self.shared);
                self.vertices(mesh, edits);
                let errors = &mesh.irradiance_error;
                let errors = (self.note("irad_error").is_some() && !errors.is_empty())
                    .then(|| block_text(|out| irradiance_error(out, errors)));
                self.set_note("irad_error", errors, edits);
                let back = mesh.back.as_deref();
                let back = back.map(|b| block_text(|out| back_irradiance(out, b)));
                lit.backs += usize::from(back.as_ref().is_some_and(|b| !b.is_empty()));
                self.set_note("irad_back", back, edits);
            }
            // There are none in an unfolded scene.
            Shape::Instance(_) => {}
            Shape::Primitive(primitive) => {
                let material = &self.scene.materials[primitive.material as usize];
                let is_black = material.diffuse.is_black() && material.brdf.is_none();
                // Light on a lamp that reflects nothing is of no use.
                let is_needed = !is_black || self.note("surface_light").is_some();
                let light = primitive.light.as_ref().filter(|_| is_needed);
                let light = light.map(|l| block_text(|out| surface_light(out, l)));
                lit.exact += usize::from(light.is_some());
                self.set_note("surface_light", light, edits);
            }
            Shape::Exact(exact) => {
                let block = skin_block(exact, self.outer);
                let block = block.map(|s| block_text(|out| skin(out, &s)));
                lit.exact += usize::from(block.is_some());
                self.set_note("skin", block, edits);
            }
        }
    }

    /// `irad` before each vertex; none where the mesh has no light.
    fn vertices(&self, mesh: &Mesh, edits: &mut Vec<TextEdit>) {
        for (v, place) in self.place.vertices.iter().enumerate() {
            let light = mesh.irradiance.get(v);
            edits.extend(match (light, place.irradiance) {
                (Some(e), Some(old)) => Some(TextEdit {
                    range: old.vector..old.end,
                    text: rgb(*e).to_string(),
                }),
                (Some(e), None) => Some(TextEdit {
                    range: place.position..place.position,
                    text: format!("irad {} ", rgb(*e)),
                }),
                (None, Some(old)) => Some(TextEdit {
                    range: old.keyword..after_blank(self.text, old.end),
                    text: String::new(),
                }),
                (None, None) => None,
            });
        }
    }

    /// The last extension of a name behind the block.
    fn note(&self, name: &str) -> Option<&Range<usize>> {
        let mut notes = self.place.notes.iter().rev();
        notes.find(|(n, _)| n == name).map(|(_, range)| range)
    }

    /// Replaces, adds or removes the extension of a name; an empty text is none.
    fn set_note(&self, name: &str, text: Option<String>, edits: &mut Vec<TextEdit>) {
        let end = line_end(self.text);
        let text = text.filter(|t| !t.is_empty());
        let text = text.map(|t| t.trim_end().replace('\n', end));
        let old = self.note(name).cloned();
        edits.extend(match (text, old) {
            (Some(text), Some(range)) => Some(TextEdit { range, text }),
            (Some(text), None) => {
                let (at, rest) = end_of_statement(self.text, self.place.end);
                let after = if rest { end } else { "" };
                Some(TextEdit {
                    range: at..at,
                    text: format!("{end}{text}{after}"),
                })
            }
            (None, Some(range)) => Some(TextEdit {
                range: range.start..after_blank(self.text, range.end),
                text: String::new(),
            }),
            (None, None) => None,
        });
    }
}

/// What a part of the writer writes.
fn block_text(write: impl FnOnce(&mut GrfOutput<'_>) -> io::Result<()>) -> String {
    let mut bytes: Vec<u8> = Vec::new();
    {
        let sink: &mut dyn io::Write = &mut bytes;
        let mut out = BufWriter::new(sink);
        // A vector takes everything; the text is compared when it is read again.
        let _ = write(&mut out).and_then(|()| io::Write::flush(&mut out));
    }
    String::from_utf8(bytes).unwrap_or_default()
}

/// Whether a shape that was read has the light of the solved one.
fn has_light_of(read: &Shape, solved: &Shape) -> bool {
    match (read, solved) {
        (Shape::Mesh(read), Shape::Mesh(solved)) => has_same_mesh_light(read, solved),
        (Shape::Primitive(read), Shape::Primitive(solved)) => {
            read.light.is_none() || read.light == solved.light
        }
        (Shape::Exact(read), Shape::Exact(solved)) => match (&read.proxy, &solved.proxy) {
            (Some(read), Some(solved)) => has_same_mesh_light(read, solved),
            (read, solved) => read.is_none() == solved.is_none(),
        },
        _ => false,
    }
}

fn has_same_mesh_light(read: &Mesh, solved: &Mesh) -> bool {
    let values = |m: &Mesh| {
        let back = m.back.as_ref().map(|b| b.irradiance.clone());
        back.filter(|b| b.iter().any(Option::is_some))
    };
    read.irradiance == solved.irradiance && values(read) == values(solved)
}

/// Removes light from an object, and the proxy that carries it.
fn darken(object: &mut Object) {
    match &mut object.shape {
        Shape::Mesh(mesh) => {
            mesh.irradiance.clear();
            mesh.irradiance_error.clear();
            mesh.back = None;
        }
        Shape::Instance(instance) => instance.light = None,
        Shape::Primitive(primitive) => primitive.light = None,
        Shape::Exact(exact) => exact.proxy = None,
    }
}
