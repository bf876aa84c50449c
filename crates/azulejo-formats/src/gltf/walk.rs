//! Converts the nodes of a scene to objects, lights and cameras in the world.

use super::accessor::Data;
use super::image_based;
use super::instances::{InstanceLists, InstanceTransform};
use super::irradiance::{self, StoredIrradiance};
use super::lightmap;
use super::material::{GltfLightmap, Surfaces};
use super::mesh::{GltfMeshBuilder, Pose};
use super::messages::GltfMessages;
use super::nodes::{MOST_LEVELS, Tree, children, is_usable};
use super::origin::{Faces, ObjectOrigin, ObjectPlace, OriginRecorder};
use super::skin::Joints;
use crate::reading::options::Budget;
use crate::reading::text::shortened;
use crate::surface::single::CoarseCoordinates;
use crate::{ReadError, ReadOptions};
use azulejo_scene::{Camera, Light, LightKind, Mesh, Object, Rgb, Scene, Shape, SharedMesh, Units};
use glam::DAffine3;
use gltf_json::extensions::scene::khr_lights_punctual::{self, Type};
use gltf_json::validation::Checked;
use gltf_json::{Index, Node, Root};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI};

/// Bytes of an object's own data that count as one element of the budget.
const BYTES_PER_ELEMENT: usize = 100;

/// Cost in elements of an object without vertices.
const ELEMENTS_PER_OBJECT: u64 = 10;

/// Cost in elements of the transform of an instance, whose parts are read before they are joined.
const ELEMENTS_PER_MAP: u64 = 3;

/// Cost in elements of visiting a node, for the time it takes: a few nodes can
/// be visited millions of times.
const ELEMENTS_PER_NODE: u64 = 16;

/// Longest path that becomes an object's name, in bytes.
const MOST_PATH: usize = 1000;

/// A scene under construction.
pub(super) struct GltfWalk<'w, 'a> {
    data: &'a Data<'a>,
    tree: &'w Tree,
    surfaces: Surfaces<'a>,
    /// How each mesh stores its irradiance, if it has any.
    irradiance: Vec<Option<StoredIrradiance>>,
    budget: Budget,
    messages: &'w mut GltfMessages,
    scene: Scene,
    /// The meshes that look the same at all their nodes, with what they take of the budget: every
    /// place takes as much, since the first pass divides them all. `None` where there is nothing to see,
    /// or nothing is kept.
    shared: HashMap<usize, (u64, Option<(SharedMesh, Faces)>)>,
    /// Meshes whose positions are far from the origin of their own coordinates.
    coarse: CoarseCoordinates,
    /// Where the objects come from, if that is wanted.
    origins: Option<OriginRecorder>,
    file: &'w str,
}

/// The ancestors of the current node.
#[derive(Clone, Copy)]
struct NodePlacement<'p> {
    world: DAffine3,
    /// Names of the ancestors.
    path: &'p str,
    level: usize,
}

impl<'w, 'a> GltfWalk<'w, 'a> {
    /// An empty scene.
    pub fn new(
        data: &'a Data<'a>,
        tree: &'w Tree,
        surfaces: Surfaces<'a>,
        options: &ReadOptions,
        messages: &'w mut GltfMessages,
        origins: Option<OriginRecorder>,
        file: &'w str,
    ) -> GltfWalk<'w, 'a> {
        GltfWalk {
            data,
            tree,
            surfaces,
            irradiance: data.root.meshes.iter().map(irradiance::of).collect(),
            budget: Budget::new(options),
            messages,
            scene: Scene::default(),
            shared: HashMap::new(),
            coarse: CoarseCoordinates::default(),
            origins,
            file,
        }
    }

    /// Reads the default scene; if none is declared the first, and without scenes all nodes. The origins
    /// of its objects come with it if they are wanted, else an empty list.
    ///
    /// # Errors
    /// Nodes nested too deeply, and a file that expands to more than allowed.
    pub fn scene(mut self) -> Result<(Scene, Vec<ObjectOrigin>), ReadError> {
        let root = self.root();
        let chosen = root.scene.map_or(0, |s| s.value());
        for (i, scene) in root.scenes.iter().enumerate() {
            if i != chosen {
                let name = shortened(scene.name.as_deref().unwrap_or("without a name"));
                let message = format!("scene {name}: skipped, another scene is read");
                self.messages.of(&message, || format!("scenes[{i}]"));
            }
        }
        let start = NodePlacement {
            world: DAffine3::IDENTITY,
            path: "",
            level: 0,
        };
        match root.scenes.get(chosen) {
            Some(scene) => {
                for node in &scene.nodes {
                    self.node(node.value(), start)?;
                }
            }
            None => {
                for node in self.tree.roots() {
                    self.node(node, start)?;
                }
            }
        }
        self.surroundings(chosen);
        // The length of a mesh's own unit depends on the nodes where it is.
        if let Some(message) = self.coarse.message(&Units::default()) {
            self.messages.whole_many(&message, self.coarse.count);
        }
        self.shared.clear();
        self.scene.unfold_single_instances();
        (self.scene.materials, self.scene.textures) = self.surfaces.finish();
        let origins = self.origins.map(OriginRecorder::finish);
        Ok((self.scene, origins.unwrap_or_default()))
    }

    /// The image-based light of the scene.
    fn surroundings(&mut self, scene: usize) {
        let root = self.root();
        let lights = root.extensions.as_ref();
        let lights = lights.and_then(|e| e.others.get(image_based::NAME)?.get("lights"));
        let own = root.scenes.get(scene).and_then(|s| s.extensions.as_ref());
        let own = own.and_then(|e| e.others.get(image_based::NAME));
        let Some(number) = own.and_then(|e| e.get("light")?.as_u64()) else {
            return;
        };
        let at = || format!("{}.lights[{number}]", image_based::NAME);
        let Some(light) = lights.and_then(|l| l.get(number as usize)) else {
            return self.messages.of("image-based light that is not there", at);
        };
        let generator = root.asset.generator.as_deref();
        let is_ours = generator.is_some_and(|g| g.starts_with("azulejo "));
        match image_based::read(light, is_ours, &mut self.surfaces) {
            Ok(kind) => {
                let name = light.get("name").and_then(|n| n.as_str());
                let name = joined("", name.unwrap_or(""));
                self.scene.lights.push(Light { name, kind });
            }
            Err(why) => {
                let message = format!("image-based light not used: {why}");
                self.messages.of(&message, at);
            }
        }
    }

    fn root(&self) -> &'a Root {
        self.data.root
    }

    fn spend(&mut self, elements: u64) -> Result<(), ReadError> {
        let spent = self.budget.spend(elements);
        spent.map_err(|exhausted| exhausted.error(self.file))
    }

    fn node(&mut self, index: usize, placement: NodePlacement) -> Result<(), ReadError> {
        let Some(node) = self.root().nodes.get(index) else {
            return Ok(());
        };
        if placement.level == MOST_LEVELS {
            let found = format!("nodes nested more than {MOST_LEVELS} deep");
            return Err(ReadError::whole(self.file, found, "fewer levels"));
        }
        self.spend(ELEMENTS_PER_NODE)?;
        if is_hidden(node) {
            let message = "hidden node: left out with its children";
            self.messages.of(message, || format!("nodes[{index}]"));
            return Ok(());
        }
        let world = placement.world * self.tree.parent_from_node(index);
        if !is_usable(&world) {
            let message = "node with an unusable transform: left out with its children";
            self.messages.of(message, || format!("nodes[{index}]"));
            return Ok(());
        }
        let own = node.name.as_deref().unwrap_or("");
        let path = joined(placement.path, own);
        let here = NodePlacement {
            world,
            path: &path,
            level: placement.level + 1,
        };
        self.content(index, node, here)?;
        for child in children(node) {
            self.node(child, here)?;
        }
        Ok(())
    }

    /// The content of a node itself.
    fn content(
        &mut self,
        index: usize,
        node: &'a Node,
        placement: NodePlacement,
    ) -> Result<(), ReadError> {
        if let Some(mesh) = node.mesh {
            self.mesh(index, node, mesh.value(), placement)?;
        }
        if let Some(camera) = node.camera {
            self.camera(camera, placement);
        }
        let extension = node.extensions.as_ref();
        if let Some(light) = extension.and_then(|e| e.khr_lights_punctual.as_ref()) {
            self.light(light.light, placement);
        }
        Ok(())
    }

    /// The name of the content of a node: the path of the nodes' names, with the content's own name
    /// appended if the node has none.
    fn name(&self, node: &Node, own: Option<&str>, placement: NodePlacement) -> String {
        match node.name.as_deref() {
            Some(name) if !name.is_empty() => placement.path.to_owned(),
            _ => joined(placement.path, own.unwrap_or("")),
        }
    }

    fn mesh(
        &mut self,
        index: usize,
        node: &'a Node,
        mesh: usize,
        placement: NodePlacement,
    ) -> Result<(), ReadError> {
        let Some(json) = self.root().meshes.get(mesh) else {
            return Ok(());
        };
        let joints = self.joints(index, node)?;
        let weights = node.weights.as_deref().or(json.weights.as_deref());
        let pose = Pose {
            weights: weights.unwrap_or_default(),
            joints: joints.as_ref(),
        };
        let name = self.name(node, json.name.as_deref(), placement);
        let has_irradiance = self.irradiance.get(mesh).copied().flatten().is_some();
        let lightmap = self.lightmap(index, node);
        // Irradiance belongs to one place, a pose and a lightmap of its own to one node.
        let is_own = joints.is_some() || !pose.weights.is_empty() || lightmap.is_some();
        if !is_own && !has_irradiance {
            return self.shared_mesh(index, node, mesh, name, placement);
        }
        let before = self.budget.left();
        let built = self.built(mesh, pose, lightmap)?;
        let each = before - self.budget.left();
        if !self.budget.keeps() {
            self.instances(index, node, each)?;
        }
        let Some(built) = built else {
            return Ok(());
        };
        let mut place = ObjectPlace {
            node: index,
            instance: None,
            mesh,
        };
        match self.instances(index, node, each)? {
            None if joints.is_some() => self.object(place, name, built, &DAffine3::IDENTITY),
            None => self.object(place, name, built, &placement.world),
            Some(maps) => {
                for (i, map) in maps.into_iter().enumerate() {
                    let world = placement.world * map;
                    place.instance = Some(i);
                    self.object(place, name.clone(), built.clone(), &world)?;
                }
                Ok(())
            }
        }
    }

    /// The lightmap that a node has for itself.
    fn lightmap(&mut self, index: usize, node: &Node) -> Option<GltfLightmap> {
        let extensions = node.extensions.as_ref();
        let extension = extensions.and_then(|e| e.others.get(lightmap::OF_NODES))?;
        let named = lightmap::of_node(extension, self.root());
        let (lightmap, problem) = self.surfaces.lightmap(named);
        if let Some(problem) = problem {
            self.messages.of(&problem, || format!("nodes[{index}]"));
        }
        lightmap
    }

    /// A mesh, and the origins of its faces if they are wanted.
    fn built(
        &mut self,
        mesh: usize,
        pose: Pose,
        lightmap: Option<GltfLightmap>,
    ) -> Result<Option<(Mesh, Faces)>, ReadError> {
        let mut builder = GltfMeshBuilder {
            data: self.data,
            surfaces: &mut self.surfaces,
            budget: &mut self.budget,
            messages: &mut *self.messages,
            irradiance: self.irradiance.get(mesh).copied().flatten(),
            lightmap,
            mesh,
            primitive: 0,
            origins: self.origins.is_some().then(Vec::new),
        };
        let built = builder.mesh(pose);
        let faces = builder.origins.take().map(Into::into);
        let built = built.map_err(|e| e.error(self.file))?;
        if let Some(mesh) = &built {
            self.coarse.add_read(mesh);
        }
        Ok(built.map(|mesh| (mesh, faces)))
    }

    /// The instances of a mesh without a pose at a node.
    fn shared_mesh(
        &mut self,
        index: usize,
        node: &'a Node,
        mesh: usize,
        name: String,
        placement: NodePlacement,
    ) -> Result<(), ReadError> {
        let each = if let Some((each, _)) = self.shared.get(&mesh) {
            let each = *each;
            self.spend(each)?;
            each
        } else {
            let pose = Pose {
                weights: &[],
                joints: None,
            };
            let before = self.budget.left();
            let built = self.built(mesh, pose, None)?;
            let each = before - self.budget.left();
            let built = built.map(|(mesh, faces)| (SharedMesh::new(mesh), faces));
            self.shared.insert(mesh, (each, built));
            each
        };
        let maps = self.instances(index, node, each)?;
        let is_instanced = maps.is_some();
        let maps = maps.unwrap_or_else(|| vec![DAffine3::IDENTITY]);
        for (i, map) in maps.into_iter().enumerate() {
            let place = ObjectPlace {
                node: index,
                instance: is_instanced.then_some(i),
                mesh,
            };
            self.instance(place, name.clone(), &(placement.world * map))?;
        }
        Ok(())
    }

    fn instance(
        &mut self,
        place: ObjectPlace,
        name: String,
        world: &DAffine3,
    ) -> Result<(), ReadError> {
        let Some((_, Some((shared, faces)))) = self.shared.get_mut(&place.mesh) else {
            return self.spend(ELEMENTS_PER_OBJECT);
        };
        let faces = faces.clone();
        let placed = shared.placed(*world);
        if let Some(placed) = placed.filter(|_| is_usable(world)) {
            self.spend(ELEMENTS_PER_OBJECT + (name.len() / BYTES_PER_ELEMENT) as u64)?;
            self.push(place, name, Shape::Instance(placed), world, &faces);
            return Ok(());
        }
        let mesh = Mesh::clone(shared.mesh());
        self.object(place, name, (mesh, faces), world)
    }

    /// Adds an object at `world`, which its shape has taken into account.
    fn push(
        &mut self,
        place: ObjectPlace,
        name: String,
        shape: Shape,
        world: &DAffine3,
        faces: &Faces,
    ) {
        let root = self.root();
        if let Some(origins) = &mut self.origins {
            let mirrored = world.matrix3.determinant() < 0.0;
            origins.push(root, place, mirrored, faces);
        }
        self.scene.objects.push(Object::new(name, shape));
    }

    /// The joints of a node's mesh, if it is skinned.
    fn joints(&mut self, index: usize, node: &Node) -> Result<Option<Joints>, ReadError> {
        let Some(skin) = node.skin else {
            return Ok(None);
        };
        let count = self.root().get(skin).map_or(0, |s| s.joints.len());
        self.spend(ELEMENTS_PER_NODE * count as u64)?;
        let joints = Joints::of(skin, self.data, self.tree);
        Ok(joints
            .map_err(|fault| {
                let message = format!("skin left out: {fault}");
                self.messages.of(&message, || format!("nodes[{index}]"));
            })
            .ok())
    }

    fn object(
        &mut self,
        place: ObjectPlace,
        name: String,
        (mut mesh, faces): (Mesh, Faces),
        world: &DAffine3,
    ) -> Result<(), ReadError> {
        if !is_usable(world) {
            self.messages
                .whole("instance with an unusable transform: left out");
            return Ok(());
        }
        self.spend(ELEMENTS_PER_OBJECT + (name.len() / BYTES_PER_ELEMENT) as u64)?;
        if !self.budget.keeps() {
            return Ok(());
        }
        if *world != DAffine3::IDENTITY {
            mesh.transform(world);
        }
        self.push(place, name, Shape::Mesh(mesh), world, &faces);
        Ok(())
    }

    /// The transforms of a node's instances by `EXT_mesh_gpu_instancing`, if it has any; `each` is what
    /// an instance expands to. If nothing is kept, the instances are counted, and there are none.
    ///
    /// # Errors
    /// More instances than allowed, before any of them is read.
    fn instances(
        &mut self,
        index: usize,
        node: &Node,
        each: u64,
    ) -> Result<Option<Vec<DAffine3>>, ReadError> {
        let Some(lists) = InstanceLists::of(node) else {
            return Ok(None);
        };
        let transforms = match lists.count(self.data) {
            Err(fault) => Err(fault),
            Ok(count) => {
                let cost = each.saturating_add(ELEMENTS_PER_OBJECT + ELEMENTS_PER_MAP);
                self.spend(cost.saturating_mul(count as u64))?;
                if self.budget.keeps() {
                    lists.transforms(self.data)
                } else {
                    Ok(Vec::new())
                }
            }
        };
        Ok(match transforms {
            Ok(transforms) => Some(transforms.iter().map(InstanceTransform::map).collect()),
            Err(fault) => {
                let message = format!("instances left out: {fault}");
                self.messages.of(&message, || format!("nodes[{index}]"));
                None
            }
        })
    }

    fn camera(&mut self, index: Index<gltf_json::Camera>, placement: NodePlacement) {
        let Some(json) = self.root().get(index) else {
            return;
        };
        let at = || format!("cameras[{index}]");
        let Some(perspective) = &json.perspective else {
            self.messages.of("orthographic camera: skipped", at);
            return;
        };
        let eye = placement.world.translation;
        let axes = placement.world.matrix3;
        let (Some(forward), Some(up)) =
            ((-axes.z_axis).try_normalize(), axes.y_axis.try_normalize())
        else {
            self.messages
                .of("camera without a viewing direction: skipped", at);
            return;
        };
        let camera = Camera {
            name: named(placement, json.name.as_deref()),
            eye,
            // Far from the origin a step of one would be lost in rounding.
            target: eye + forward * (1e-3 * eye.length()).max(1.0),
            up,
            vertical_fov: perspective.yfov.into(),
            size: None,
        };
        let (right, up, forward) = camera.axes();
        let sees = camera.vertical_fov > 0.0 && camera.vertical_fov < PI;
        if sees && right.is_finite() && up.is_finite() && forward.is_finite() {
            self.scene.cameras.push(camera);
        } else {
            self.messages
                .of("camera without a usable view: skipped", at);
        }
    }

    fn light(&mut self, index: Index<khr_lights_punctual::Light>, placement: NodePlacement) {
        let Some(json) = self.root().get(index) else {
            return;
        };
        let at = || format!("lights[{index}]");
        if json.range.is_some() {
            self.messages.of(
                "range of a light: not used, light falls off with the inverse square of the distance",
                at,
            );
        }
        let Some(kind) = kind_of(json, &placement.world) else {
            self.messages.of("light without a direction: skipped", at);
            return;
        };
        let name = named(placement, json.name.as_deref());
        self.scene.lights.push(Light { name, kind });
    }
}

/// The kind of a light in the world, if its direction is valid.
fn kind_of(json: &khr_lights_punctual::Light, world: &DAffine3) -> Option<LightKind> {
    let intensity = Rgb::from(json.color.map(f64::from)) * f64::from(json.intensity);
    let intensity = intensity.map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 });
    let position = world.translation;
    let direction = || (-world.matrix3.z_axis).try_normalize();
    match &json.type_ {
        Checked::Valid(Type::Point) => Some(LightKind::Point {
            position,
            intensity,
        }),
        Checked::Valid(Type::Directional) => Some(LightKind::Directional {
            direction: direction()?,
            irradiance: intensity,
            half_angle: 0.0,
        }),
        Checked::Valid(Type::Spot) => {
            let cone = json.spot.as_ref()?;
            let outer = f64::from(cone.outer_cone_angle).clamp(0.0, FRAC_PI_2);
            Some(LightKind::Spot {
                position,
                direction: direction()?,
                intensity,
                inner: f64::from(cone.inner_cone_angle).clamp(0.0, outer),
                outer,
            })
        }
        Checked::Invalid => None,
    }
}

/// The name of a light or a camera: the path of the nodes' names, or else its own.
fn named(placement: NodePlacement, own: Option<&str>) -> String {
    match placement.path {
        "" => joined("", own.unwrap_or("")),
        path => path.to_owned(),
    }
}

/// `KHR_node_visibility`.
fn is_hidden(node: &Node) -> bool {
    let extensions = node.extensions.as_ref();
    let visibility = extensions.and_then(|e| e.others.get("KHR_node_visibility"));
    visibility.and_then(|v| v.get("visible")?.as_bool()) == Some(false)
}

/// A path with a name appended. A path that is too long starts again from the name.
fn joined(path: &str, name: &str) -> String {
    let end = name.floor_char_boundary(MOST_PATH.min(name.len()));
    let name = &name[..end];
    match (path, name) {
        (path, "") => path.to_owned(),
        ("", name) => name.to_owned(),
        (path, name) if path.len() + name.len() >= MOST_PATH => name.to_owned(),
        (path, name) => format!("{path}/{name}"),
    }
}
