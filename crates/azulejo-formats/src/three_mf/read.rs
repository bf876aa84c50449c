//! Reads packages.

use super::package::Package;
use super::part::{ModelPart, PartContent, PartReader, Placement};
use super::properties::Palette;
use crate::reading::options::Budget;
use crate::reading::text::{shortened, text};
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};
use azulejo_scene::{MeshInstance, Object, Scene, Shape, Units, Up};
use glam::DAffine3;
use roxmltree::Document;
use std::collections::HashMap;
use std::rc::Rc;

/// How deep components may nest.
const DEEPEST: usize = 64;

/// Corners from which repeated meshes are shared, as elsewhere.
const LEAST_SHARED: usize = 64;

/// Reads a model. `name` is used in messages; all that a package refers to is inside of it.
///
/// # Errors
/// Damaged archives, parts that expand to more than the options allow, malformed XML, objects that contain themselves,
/// numbers that are none, and references to what does not exist.
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let mut warnings = Warnings::default();
    let mut package = Package::new(bytes, name, options)?;
    let root = root_part(&mut package, name)?;
    let mut builder = PackageBuilder {
        package,
        name,
        root: Rc::from(root),
        parts: HashMap::new(),
        palette: Palette::default(),
        budget: Budget::new(options),
        warnings: &mut warnings,
        path: Vec::new(),
    };
    let mut scene = builder.scene()?;
    if scene.objects.is_empty() && options.keeps {
        warnings.add_whole(name, "nothing is to be built: the scene is empty");
    }
    scene.unfold_single_instances();
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// The name of the part with the model: by the relationships of the package, else the usual one.
fn root_part(package: &mut Package, file: &str) -> Result<String, ReadError> {
    let relations = package.part("_rels/.rels")?.unwrap_or_default();
    let relations = text(&relations).into_owned();
    let is_crowded = crate::reading::xml::crowded_element(&relations).is_some();
    let document = Document::parse(&relations).ok().filter(|_| !is_crowded);
    let target = document.as_ref().and_then(|xml| {
        let mut all = xml.root_element().children();
        let model = all.find(|n| n.attribute("Type").is_some_and(|t| t.ends_with("/3dmodel")))?;
        model.attribute("Target").map(str::to_owned)
    });
    let root = target.or_else(|| package.ending(".model"));
    root.ok_or_else(|| {
        let expected = "a 3MF package; unpack other archives first";
        ReadError::whole(file, "a ZIP archive without a 3D model", expected)
    })
}

/// A scene under construction.
struct PackageBuilder<'a, 'w> {
    package: Package<'a>,
    name: &'a str,
    root: Rc<str>,
    parts: HashMap<Rc<str>, Rc<ModelPart>>,
    palette: Palette,
    budget: Budget,
    warnings: &'w mut Warnings,
    /// The objects around the one that is placed.
    path: Vec<(Rc<str>, u32)>,
}

impl PackageBuilder<'_, '_> {
    fn scene(&mut self) -> Result<Scene, ReadError> {
        let root = Rc::clone(&self.root);
        let part = self.part(&root)?;
        for item in &part.items {
            self.place(&root, item, &DAffine3::IDENTITY, "")?;
        }
        self.palette.scene.units = Units {
            metres_per_unit: Some(part.metres),
            up: Up::Z,
            photometric: false,
        };
        let mut scene = std::mem::take(&mut self.palette.scene);
        scene.textures = std::mem::take(&mut self.palette.textures).into_list();
        Ok(scene)
    }

    /// A part, read once.
    fn part(&mut self, name: &Rc<str>) -> Result<Rc<ModelPart>, ReadError> {
        if let Some(part) = self.parts.get(name) {
            return Ok(Rc::clone(part));
        }
        let Some(bytes) = self.package.part(name)? else {
            let found = format!("no part \"{}\"", shortened(name));
            return Err(ReadError::whole(
                self.name,
                found,
                "the part that the model refers to",
            ));
        };
        let file = format!("{}/{}", self.name, shortened(name.trim_start_matches('/')));
        let reader = PartReader::new(&mut self.package, self.warnings, file, &bytes);
        let part = Rc::new(reader.read(&mut self.palette)?);
        self.parts.insert(Rc::clone(name), Rc::clone(&part));
        Ok(part)
    }

    /// Places an object; `around` is the name of the object that contains it, with a slash.
    fn place(
        &mut self,
        part_name: &Rc<str>,
        placement: &Placement,
        parent: &DAffine3,
        around: &str,
    ) -> Result<(), ReadError> {
        self.spend(1 + around.len() as u64 / 64)?;
        let part_name = match &placement.part {
            Some(name) => Rc::from(name.as_str()),
            None => Rc::clone(part_name),
        };
        let part = self.part(&part_name)?;
        let id = placement.object;
        let key = (Rc::clone(&part_name), id);
        let fail = |found: String, expected: &str| ReadError {
            position: placement.position,
            ..ReadError::whole(self.name, found, expected)
        };
        if self.path.contains(&key) {
            let found = format!("object {id}, which is a component of itself");
            return Err(fail(found, "components without circles"));
        }
        if self.path.len() == DEEPEST {
            let found = format!("components that nest more than {DEEPEST} deep");
            return Err(fail(found, "fewer levels"));
        }
        let Some(object) = part.objects.get(&id) else {
            let found = format!("object {id}, which does not exist");
            return Err(fail(found, "the id of an object"));
        };
        let map = *parent * placement.map;
        let name = format!("{around}{}", object.name);
        match &object.content {
            PartContent::Mesh(shared) => {
                let mesh = shared.mesh();
                self.spend((mesh.positions.len() + mesh.faces.corners.len()) as u64)?;
                if !self.budget.keeps() || mesh.faces.is_empty() {
                    return Ok(());
                }
                let placed = (**shared)
                    .clone()
                    .placed(map)
                    .filter(MeshInstance::is_finite);
                let shape = match placed {
                    Some(instance) if mesh.faces.corners.len() >= LEAST_SHARED => {
                        Shape::Instance(instance)
                    }
                    Some(instance) => Shape::Mesh(instance.to_mesh()),
                    None => {
                        let message =
                            "a transform that flattens an object or is too large: skipped";
                        let position = placement.position;
                        self.warnings
                            .add(self.name, message.to_owned(), || position);
                        return Ok(());
                    }
                };
                self.palette.scene.objects.push(Object::new(name, shape));
            }
            PartContent::Components(list) => {
                self.path.push(key);
                for component in list {
                    self.place(&part_name, component, &map, &format!("{name}/"))?;
                }
                self.path.pop();
            }
        }
        Ok(())
    }

    fn spend(&mut self, elements: u64) -> Result<(), ReadError> {
        self.budget.spend(elements).map_err(|e| e.error(self.name))
    }
}
