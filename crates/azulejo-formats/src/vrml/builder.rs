//! The scene under construction, shared by all files of a model, whatever their version of VRML.

use super::appearance::AppearanceCache;
use super::solid::PlacedPrimitive;
use super::tree::{VrmlDocument, VrmlNode};
#[cfg(feature = "fonts")]
use crate::outline::letters::Letters;
use crate::reading::options::Budget;
use crate::reading::text::{decoded, shortened};
use crate::reading::warnings::Warnings;
use crate::reading::{cursor, files, gzip};
use crate::surface::gloss::Gloss;
use crate::surface::materials::Materials;
use crate::surface::repeated::RepeatedMeshes;
use crate::surface::textures::Textures;
use crate::{Files, Loaded, Position, ReadError, ReadOptions};
use azulejo_scene::{MaterialId, Mesh, Object, Primitive, PrimitiveKind, Scene, Shape, Units};
use glam::DAffine3;
use std::collections::HashMap;
use std::rc::Rc;

/// Maximum depth of nested files.
const MOST_NESTED: usize = 32;

/// Maximum length of an object's path of names; of a longer one, the end is kept.
const MOST_NAME: usize = 200;

/// A text file of the model, kept to report positions in it.
#[derive(Debug)]
pub(super) struct VrmlSource {
    /// The name used in messages.
    pub name: String,
    /// The name relative to the model's folder.
    pub path: String,
    /// The text, decompressed, UTF-8 or close to it.
    pub bytes: Vec<u8>,
}

/// The result of opening a file.
pub(super) enum OpenedFile {
    /// The file has not been read before.
    New(Rc<VrmlSource>),
    /// The file has been read, and this is its tree of nodes.
    Known(Rc<VrmlDocument>),
}

impl VrmlSource {
    /// The model itself. Its name in messages may include folders that its path must not have.
    pub fn model(name: &str, bytes: &[u8]) -> VrmlSource {
        VrmlSource {
            name: name.to_owned(),
            path: in_own_folder(name),
            bytes: decoded(bytes).into_owned(),
        }
    }

    /// Line and column of a byte offset.
    pub fn position(&self, offset: usize) -> Position {
        cursor::position(&self.bytes, offset)
    }

    /// Whether the file is X3D, in any encoding.
    pub fn is_x3d(&self) -> bool {
        !self.bytes.starts_with(b"#VRML")
    }

    /// Whether the file is X3D, version 4 or later.
    pub fn is_x3d_4(&self) -> bool {
        // In XML, the version is an attribute of the root element.
        let text = &self.bytes;
        let head = &text[..text.len().min(4096)];
        let holds = |mark: &[u8]| head.windows(mark.len()).any(|w| w == mark);
        text.starts_with(b"#X3D V4")
            || text.starts_with(b"<") && (holds(b"version=\"4") || holds(b"version='4"))
    }
}

/// Transformation and name path of a node.
#[derive(Clone, Debug, Default)]
pub(super) struct VrmlPlacement {
    /// The product of the transformations above the node.
    pub world_from_object: DAffine3,
    /// The names of the nodes above, joined by `/`.
    path: String,
}

impl VrmlPlacement {
    /// The placement inside a group, which may have a name.
    pub fn named(&self, name: Option<&str>) -> VrmlPlacement {
        VrmlPlacement {
            path: self.name(name),
            ..*self
        }
    }

    /// The placement inside a transformation node.
    pub fn moved(mut self, map: DAffine3) -> VrmlPlacement {
        self.world_from_object *= map;
        self
    }

    /// The name of an object at this placement, which may have a name of its own.
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

/// The scene under construction and the state of the readers.
pub(super) struct VrmlSceneBuilder<'a> {
    pub files: &'a dyn Files,
    pub options: &'a ReadOptions,
    /// Objects, lights, cameras, background and fog. Materials and textures are added at the end.
    pub scene: Scene,
    pub materials: Materials,
    pub gloss: Gloss,
    pub textures: Textures,
    repeated: RepeatedMeshes,
    #[cfg(feature = "fonts")]
    pub letters: Letters<'a>,
    pub warnings: Warnings,
    budget: Budget,
    /// The model's name in messages.
    model: String,
    /// Remaining budget in bytes for files that the model refers to.
    bytes_left: u64,
    pub appearances: AppearanceCache,
    /// Files that were read, by name.
    documents: HashMap<String, Rc<VrmlDocument>>,
    /// The files being read, the model itself first.
    open: Vec<String>,
}

impl<'a> VrmlSceneBuilder<'a> {
    /// An empty scene.
    pub fn new(
        model: &str,
        files: &'a dyn Files,
        options: &'a ReadOptions,
    ) -> VrmlSceneBuilder<'a> {
        let units = Units {
            // ISO/IEC 14772-1, 4.4.5: the unit of length is the metre.
            metres_per_unit: Some(1.0),
            ..Units::default()
        };
        VrmlSceneBuilder {
            files,
            options,
            scene: Scene {
                units,
                ..Scene::default()
            },
            materials: Materials::default(),
            gloss: Gloss::default(),
            textures: Textures::default(),
            repeated: RepeatedMeshes::default(),
            #[cfg(feature = "fonts")]
            letters: Letters::new(files),
            warnings: Warnings::default(),
            budget: Budget::new(options),
            model: model.to_owned(),
            bytes_left: options.most_unpacked,
            appearances: AppearanceCache::default(),
            documents: HashMap::new(),
            open: vec![in_own_folder(model)],
        }
    }

    /// Adds a warning about the byte `at` of a file.
    #[cold]
    pub fn warn(&mut self, source: &VrmlSource, at: usize, message: impl Into<String>) {
        self.warn_many(source, at, message, 1);
    }

    /// Adds a warning about a node.
    #[cold]
    pub fn warn_node(&mut self, node: &VrmlNode, message: impl Into<String>) {
        self.warn_many(&node.source, node.at, message, 1);
    }

    /// Adds a warning about the byte `at` of a file with a count, which may be 0.
    pub fn warn_many(
        &mut self,
        source: &VrmlSource,
        at: usize,
        message: impl Into<String>,
        count: usize,
    ) {
        self.warnings
            .add_many(&source.name, message.into(), count, || source.position(at));
    }

    /// Takes `elements` from the budget of what the model may unfold to.
    ///
    /// # Errors
    /// The budget is exhausted.
    pub fn spend(&mut self, elements: u64) -> Result<(), ReadError> {
        let exhausted = |e: crate::reading::options::Exhausted| e.error(&self.model);
        self.budget.spend(elements).map_err(exhausted)
    }

    /// Takes the vertices of a primitive's polygons from the budget; returns the polygons, or `None` if they are
    /// only counted.
    ///
    /// # Errors
    /// The budget is exhausted.
    pub fn polygons(
        &mut self,
        solid: &PlacedPrimitive,
        materials: &[MaterialId],
    ) -> Result<Option<Mesh>, ReadError> {
        self.spend(solid.vertex_count())?;
        Ok(self.budget.keeps().then(|| solid.polygons(materials)))
    }

    /// Adds a mesh as an object; those of a node that is used several times share one. `mesh` is in object
    /// coordinates, of the node at the byte `at` of `source`, its materials are final, and
    /// [`VrmlSceneBuilder::spend`] has been called for it.
    pub fn place_mesh(
        &mut self,
        frame: &VrmlPlacement,
        own_name: Option<&str>,
        (source, at): (&VrmlSource, usize),
        mesh: Mesh,
    ) -> ShapeOutcome {
        if mesh.faces.is_empty() {
            return ShapeOutcome::NoFaces;
        }
        if !self.budget.keeps() {
            // Not even to find equal ones.
            return ShapeOutcome::Object;
        }
        let text = source.bytes[at.min(source.bytes.len())..].as_ptr();
        let shape = self.repeated.place(mesh, text, &frame.world_from_object);
        if let Shape::Mesh(mesh) = &shape
            && !mesh.positions.iter().all(|p| p.is_finite())
        {
            return ShapeOutcome::Degenerate;
        }
        self.push(frame, own_name, shape)
    }

    /// Adds an exact shape; `object_from_unit` maps the unit primitive to the object. Nothing is
    /// added if the transformation is singular: a flattened primitive has no interior.
    pub fn place_primitive(
        &mut self,
        frame: &VrmlPlacement,
        own_name: Option<&str>,
        kind: PrimitiveKind,
        object_from_unit: DAffine3,
        material: MaterialId,
    ) -> ShapeOutcome {
        let map = frame.world_from_object * object_from_unit;
        let volume = map.matrix3.determinant();
        if !map.is_finite() || !volume.is_normal() || !map.inverse().is_finite() {
            return ShapeOutcome::Degenerate;
        }
        let primitive = Primitive::new(kind, map, material);
        self.push(frame, own_name, Shape::Primitive(primitive))
    }

    fn push(
        &mut self,
        frame: &VrmlPlacement,
        own_name: Option<&str>,
        shape: Shape,
    ) -> ShapeOutcome {
        if self.budget.keeps() {
            let object = Object::new(frame.name(own_name), shape);
            self.scene.objects.push(object);
        }
        ShapeOutcome::Object
    }

    /// Opens the first of `urls` that exists, relative to the file that names it, and decompresses
    /// it. A fragment after `#` is ignored. `None`, with a warning, if none exists or if the file
    /// is already open. Call [`VrmlSceneBuilder::close`] once it has been read.
    pub fn open(&mut self, from: &VrmlSource, at: usize, urls: &[String]) -> Option<OpenedFile> {
        let mut why = "no file name given".to_owned();
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
        self.warn(from, at, format!("file cannot be read: {why}"));
        None
    }

    /// Caches the content of a file in case it is referenced again.
    pub fn remember(&mut self, source: &VrmlSource, document: &Rc<VrmlDocument>) {
        self.documents.insert(source.path.clone(), document.clone());
    }

    /// Whether the model's own file is being read, not one nested in it.
    pub fn is_outermost(&self) -> bool {
        self.open.len() == 1
    }

    /// Marks the file opened last as read.
    pub fn close(&mut self) {
        self.open.pop();
    }

    fn read(&mut self, name: &str) -> Result<OpenedFile, String> {
        if self.open.iter().any(|open| open == name) {
            return Err("the file includes itself".into());
        }
        if self.open.len() >= MOST_NESTED {
            return Err(format!("files nested more than {MOST_NESTED} deep"));
        }
        if let Some(document) = self.documents.get(name) {
            return Ok(OpenedFile::Known(document.clone()));
        }
        let packed = self.files.read(name).map_err(|e| e.to_string())?;
        let options = ReadOptions {
            most_unpacked: self.bytes_left,
            ..*self.options
        };
        let bytes = gzip::unpacked(&packed, name, &options).map_err(|e| e.found.to_string())?;
        match self.bytes_left.checked_sub(bytes.len() as u64) {
            Some(left) => self.bytes_left = left,
            None => return Err("the files of the model exceed the size limit together".into()),
        }
        Ok(OpenedFile::New(Rc::new(VrmlSource {
            name: name.to_owned(),
            path: name.to_owned(),
            bytes: decoded(&bytes).into_owned(),
        })))
    }

    /// The finished scene.
    pub fn finish(mut self, model: &str) -> Loaded {
        drop(self.repeated);
        self.scene.unfold_single_instances();
        self.scene.materials = self.materials.into_list();
        self.scene.textures = self.textures.into_list();
        if self.scene.objects.is_empty() {
            self.warnings
                .add_whole(model, "the model contains no geometry");
        }
        Loaded {
            scene: self.scene,
            warnings: self.warnings.finish(model),
        }
    }
}

/// The result of adding a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub(super) enum ShapeOutcome {
    /// It was added as an object.
    Object,
    /// It has no faces.
    NoFaces,
    /// Its transformation is singular or overflows.
    Degenerate,
}

/// A file name without its folders.
fn in_own_folder(name: &str) -> String {
    let name = name.rsplit(['/', '\\']).next();
    name.unwrap_or_default().to_owned()
}

/// A file name without the scheme of a local URL.
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
        let frame = VrmlPlacement::default().named(Some("house")).named(None);
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
        let mut builder = VrmlSceneBuilder::new("/models/m.wrl", &files, &options);
        let model = VrmlSource::model("/models/m.wrl", b"");
        let urls = ["none.wrl", "file:parts/a.wrl#x"].map(String::from);
        let Some(OpenedFile::New(a)) = builder.open(&model, 0, &urls) else {
            panic!("a file that was not read before");
        };
        assert_eq!((a.name.as_str(), &a.bytes[..]), ("parts/a.wrl", &b"a"[..]));
        assert!(builder.open(&a, 0, &["../b.wrl".into()]).is_some());
        builder.close();
        assert!(builder.open(&a, 0, &["a.wrl".into()]).is_none());
        assert!(builder.open(&a, 0, &[]).is_none());
        let warnings = builder.finish("m.wrl").warnings;
        assert!(
            warnings[0].message.contains("includes itself"),
            "{warnings:?}"
        );
        assert!(warnings[1].message.contains("no file name"), "{warnings:?}");
    }
}
