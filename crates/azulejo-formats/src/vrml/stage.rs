//! What the files of one model become together, whatever versions of VRML they are in.

use super::look::Looks;
use super::tree::Document;
use crate::reading::options::Budget;
use crate::reading::text::{decoded, shortened};
use crate::reading::warnings::Warnings;
use crate::reading::{cursor, files, gzip};
use crate::surface::gloss::Gloss;
use crate::surface::materials::Materials;
use crate::surface::textures::Textures;
use crate::{Files, Loaded, Position, ReadError, ReadOptions};
use azulejo_scene::{MaterialId, Mesh, Object, Primitive, PrimitiveKind, Scene, Shape, Units};
use glam::DAffine3;
use std::collections::HashMap;
use std::rc::Rc;

/// How many files may stand inside one another.
const MOST_NESTED: usize = 32;

/// Longest path of names of an object; of what is longer, the end is kept.
const MOST_NAME: usize = 200;

/// A text file of the model, kept for saying where in it something stands.
#[derive(Debug)]
pub(super) struct Source {
    /// Its name in messages.
    pub name: String,
    /// Its name as the model's folder knows it.
    pub path: String,
    /// Its text, unpacked, in UTF-8 or near it.
    pub bytes: Vec<u8>,
}

/// A file that was asked for.
pub(super) enum Opened {
    /// It has not been read before.
    New(Rc<Source>),
    /// It has, and is a tree of nodes.
    Known(Rc<Document>),
}

impl Source {
    /// The model itself, whose name in messages may tell folders that its own does not know.
    pub fn model(name: &str, bytes: &[u8]) -> Source {
        Source {
            name: name.to_owned(),
            path: in_own_folder(name),
            bytes: decoded(bytes).into_owned(),
        }
    }

    /// Line and column of a byte.
    pub fn position(&self, offset: usize) -> Position {
        cursor::position(&self.bytes, offset)
    }

    /// Whether it is X3D, in whatever encoding.
    pub fn is_x3d(&self) -> bool {
        !self.bytes.starts_with(b"#VRML")
    }

    /// Whether it is X3D of version 4 or later.
    pub fn is_x3d_4(&self) -> bool {
        // XML says so among the attributes of its first element.
        let text = &self.bytes;
        let head = &text[..text.len().min(4096)];
        let holds = |mark: &[u8]| head.windows(mark.len()).any(|w| w == mark);
        text.starts_with(b"#X3D V4")
            || text.starts_with(b"<") && (holds(b"version=\"4") || holds(b"version='4"))
    }
}

/// Where in the world, and under what name, something is placed.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    /// The transformations on the way here.
    pub world_from_object: DAffine3,
    /// The names on the way here, joined by `/`.
    path: String,
}

impl Frame {
    /// The frame inside a group, which may have a name.
    pub fn named(&self, name: Option<&str>) -> Frame {
        Frame {
            path: self.name(name),
            ..*self
        }
    }

    /// The frame inside a transformation.
    pub fn moved(mut self, map: DAffine3) -> Frame {
        self.world_from_object *= map;
        self
    }

    /// The name of an object here, which may have one of its own.
    pub fn name(&self, own: Option<&str>) -> String {
        let joined = match own.filter(|name| !name.is_empty()) {
            None => return self.path.clone(),
            Some(name) if self.path.is_empty() => shortened(name),
            Some(name) => format!("{}/{}", self.path, shortened(name)),
        };
        // Without a limit, names could take far more memory than the file that nests them.
        let cut = joined.len().saturating_sub(MOST_NAME);
        let start = (cut..).find(|i| joined.is_char_boundary(*i));
        joined[start.unwrap_or(0)..].to_owned()
    }
}

/// The scene under construction, and what reading it takes.
pub(super) struct Stage<'a> {
    pub files: &'a dyn Files,
    pub options: &'a ReadOptions,
    /// Objects, lights, cameras, background and fog. Materials and textures come at the end.
    pub scene: Scene,
    pub materials: Materials,
    pub gloss: Gloss,
    pub textures: Textures,
    pub warnings: Warnings,
    budget: Budget,
    /// The model's name in messages.
    model: String,
    /// Bytes that files named by the model may still have.
    bytes_left: u64,
    pub looks: Looks,
    /// Files that were read, by name.
    documents: HashMap<String, Rc<Document>>,
    /// The files that are being read, the model itself first.
    open: Vec<String>,
}

impl<'a> Stage<'a> {
    /// An empty scene.
    pub fn new(model: &str, files: &'a dyn Files, options: &'a ReadOptions) -> Stage<'a> {
        let units = Units {
            // ISO/IEC 14772-1, 4.4.5: the unit of length is the metre.
            metres_per_unit: Some(1.0),
            ..Units::default()
        };
        Stage {
            files,
            options,
            scene: Scene {
                units,
                ..Scene::default()
            },
            materials: Materials::default(),
            gloss: Gloss::default(),
            textures: Textures::default(),
            warnings: Warnings::default(),
            budget: Budget::new(options),
            model: model.to_owned(),
            bytes_left: options.most_unpacked,
            looks: Looks::default(),
            documents: HashMap::new(),
            open: vec![in_own_folder(model)],
        }
    }

    /// Counts a warning about the byte `at` of a file.
    #[cold]
    pub fn warn(&mut self, source: &Source, at: usize, message: impl Into<String>) {
        self.warn_many(source, at, message, 1);
    }

    /// Counts a warning about the byte `at` of a file `count` times, which may be 0.
    pub fn warn_many(
        &mut self,
        source: &Source,
        at: usize,
        message: impl Into<String>,
        count: usize,
    ) {
        self.warnings
            .add_many(&source.name, message.into(), count, || source.position(at));
    }

    /// Takes what is about to be made from what the model may unfold to.
    ///
    /// # Errors
    /// Nothing is left.
    pub fn spend(&mut self, elements: u64) -> Result<(), ReadError> {
        let exhausted = |e: crate::reading::options::Exhausted| e.error(&self.model);
        self.budget.spend(elements).map_err(exhausted)
    }

    /// Puts a mesh into the world and makes it an object. `mesh` is in object coordinates, its
    /// materials are final, and [`Stage::spend`] has been asked.
    pub fn place_mesh(&mut self, frame: &Frame, own_name: Option<&str>, mut mesh: Mesh) -> Placed {
        if mesh.faces.is_empty() {
            return Placed::Nothing;
        }
        mesh.transform(&frame.world_from_object);
        if !mesh.positions.iter().all(|p| p.is_finite()) {
            return Placed::Nowhere;
        }
        self.push(frame, own_name, Shape::Mesh(mesh))
    }

    /// Puts an exact shape into the world, which `object_from_unit` makes of the unit primitive.
    /// Where the world flattens it, nothing is placed: what is flat has no inside.
    pub fn place_primitive(
        &mut self,
        frame: &Frame,
        own_name: Option<&str>,
        kind: PrimitiveKind,
        object_from_unit: DAffine3,
        material: MaterialId,
    ) -> Placed {
        let map = frame.world_from_object * object_from_unit;
        let volume = map.matrix3.determinant();
        if !map.is_finite() || !volume.is_normal() || !map.inverse().is_finite() {
            return Placed::Nowhere;
        }
        let primitive = Primitive::new(kind, map, material);
        self.push(frame, own_name, Shape::Primitive(primitive))
    }

    fn push(&mut self, frame: &Frame, own_name: Option<&str>, shape: Shape) -> Placed {
        let object = Object::new(frame.name(own_name), shape);
        self.scene.objects.push(object);
        Placed::Object
    }

    /// Opens the first of `urls` that can be had, beside the file that names it, unpacked. What
    /// stands behind `#` is not looked at. `None`, with a warning, if there is none, or if it is
    /// one of the files inside which this one stands. Call [`Stage::close`] when it is read.
    pub fn open(&mut self, from: &Source, at: usize, urls: &[String]) -> Option<Opened> {
        let mut why = "it names no file".to_owned();
        for url in urls {
            let file = url.split('#').next().unwrap_or_default();
            let name = files::beside(&from.path, local(file));
            match self.read(&name) {
                Ok(opened) => {
                    self.open.push(name);
                    return Some(opened);
                }
                Err(problem) => why = format!("\"{}\": {problem}", shortened(file)),
            }
        }
        self.warn(from, at, format!("a file is not there: {why}"));
        None
    }

    /// Keeps what a file holds, in case it is asked for again.
    pub fn know(&mut self, source: &Source, document: &Rc<Document>) {
        self.documents.insert(source.path.clone(), document.clone());
    }

    /// Whether the model's own file is read, and none inside it.
    pub fn is_outermost(&self) -> bool {
        self.open.len() == 1
    }

    /// The file that was opened last is read.
    pub fn close(&mut self) {
        self.open.pop();
    }

    fn read(&mut self, name: &str) -> Result<Opened, String> {
        if self.open.iter().any(|open| open == name) {
            return Err("the file is inside itself".into());
        }
        if self.open.len() >= MOST_NESTED {
            return Err(format!("more than {MOST_NESTED} files inside one another"));
        }
        if let Some(document) = self.documents.get(name) {
            return Ok(Opened::Known(document.clone()));
        }
        let packed = self.files.read(name).map_err(|e| e.to_string())?;
        let options = ReadOptions {
            most_unpacked: self.bytes_left,
            ..*self.options
        };
        let bytes = gzip::unpacked(&packed, name, &options).map_err(|e| e.found.to_string())?;
        match self.bytes_left.checked_sub(bytes.len() as u64) {
            Some(left) => self.bytes_left = left,
            None => return Err("the files of the model are too large together".into()),
        }
        Ok(Opened::New(Rc::new(Source {
            name: name.to_owned(),
            path: name.to_owned(),
            bytes: decoded(&bytes).into_owned(),
        })))
    }

    /// The finished scene.
    pub fn finish(mut self, model: &str) -> Loaded {
        self.scene.materials = self.materials.into_list();
        self.scene.textures = self.textures.into_list();
        if self.scene.objects.is_empty() {
            self.warnings
                .add_whole(model, "there is no geometry in this model");
        }
        Loaded {
            scene: self.scene,
            warnings: self.warnings.finish(model),
        }
    }
}

/// What became of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub(super) enum Placed {
    /// It is an object.
    Object,
    /// It has no faces.
    Nothing,
    /// Its transformations flatten it or lead beyond the numbers.
    Nowhere,
}

/// A file's name without the folders before it.
fn in_own_folder(name: &str) -> String {
    let name = name.rsplit(['/', '\\']).next();
    name.unwrap_or_default().to_owned()
}

/// A file's name without the scheme of a local URL.
fn local(url: &str) -> &str {
    let rest = url.strip_prefix("file:").unwrap_or(url);
    let rest = rest.strip_prefix("//").unwrap_or(rest);
    rest.strip_prefix("./").unwrap_or(rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Memory;

    #[test]
    fn names_stay_short() {
        let frame = Frame::default().named(Some("house")).named(None);
        assert_eq!(frame.name(Some("table")), "house/table");
        assert_eq!(frame.name(None), "house");
        let mut deep = frame;
        for _ in 0..1000 {
            deep = deep.named(Some(&"ü".repeat(500)));
        }
        assert!(deep.name(None).len() <= MOST_NAME);
    }

    #[test]
    fn files_are_opened_once_inside_one_another() {
        let files = Memory::new().with("parts/a.wrl", "a").with("b.wrl", "b");
        let options = ReadOptions::default();
        let mut stage = Stage::new("/models/m.wrl", &files, &options);
        let model = Source::model("/models/m.wrl", b"");
        let urls = ["none.wrl", "file:parts/a.wrl#x"].map(String::from);
        let Some(Opened::New(a)) = stage.open(&model, 0, &urls) else {
            panic!("a file that was not read before");
        };
        assert_eq!((a.name.as_str(), &a.bytes[..]), ("parts/a.wrl", &b"a"[..]));
        assert!(stage.open(&a, 0, &["../b.wrl".into()]).is_some());
        stage.close();
        assert!(stage.open(&a, 0, &["a.wrl".into()]).is_none());
        assert!(stage.open(&a, 0, &[]).is_none());
        let warnings = stage.finish("m.wrl").warnings;
        assert!(
            warnings[0].message.contains("inside itself"),
            "{warnings:?}"
        );
        assert!(
            warnings[1].message.contains("names no file"),
            "{warnings:?}"
        );
    }
}
