//! Builds the scene from the parsed lists: materials, and objects as placed by the keyframer.

use super::chunk::ChunkWalker;
use super::keyframer::{self, KeyframerNode, NodeTarget, PlacedNode};
use super::material::{DEFAULT_REFLECTANCE, TextureMap};
use super::mesh::{self, MaterialTable};
use super::parse::{RawCamera, RawLight, RawMesh, Studio3dsModel};
use crate::reading::options::Budget;
use crate::reading::text::shortened;
use crate::surface::textures::Textures;
use crate::{Files, ReadError};
use azulejo_scene::math::Aabb;
use azulejo_scene::{
    Camera, Light, LightKind, Material, MaterialId, Mesh, Object, Opacity, OpacityChannel,
    OpacityPicture, Rgb, Scene, Shape, Units, Up,
};
use glam::{DAffine3, DQuat, DVec3};
use std::collections::HashMap;

/// How near the pivot must be to its node, relative to the size of the mesh, for the local frame to be taken as lost.
const AT_NODE: f64 = 0.01;

/// Displacements below this, relative to the magnitude of the numbers, are attributed to rounding:
/// the stored vertices stay unchanged. Single precision has 6e-8, and a matrix sums several such
/// errors.
const ROUNDING: f64 = 1e-5;

/// Aspect ratio of 3D Studio's images.
const ASPECT: f64 = 4.0 / 3.0;

/// Views steeper than this, as the sine, use y as the up vector.
const UPRIGHT: f64 = 0.999_999;

/// Smallest field of view, and difference of the largest from 180, degrees.
const MOST_ZOOM: f64 = 0.01;

pub(super) struct Studio3dsBuilder<'b> {
    pub files: &'b dyn Files,
    pub walker: ChunkWalker<'b>,
    pub budget: Budget,
}

/// The keyframer's nodes, placed in the world.
struct PlacedNodes<'n> {
    nodes: &'n [KeyframerNode],
    placed: Vec<PlacedNode>,
    by_name: HashMap<(NodeTarget, &'n str), Vec<usize>>,
}

impl PlacedNodes<'_> {
    /// The nodes of an object.
    fn of<'a>(&'a self, kind: NodeTarget, name: &'a str) -> &'a [usize] {
        self.by_name.get(&(kind, name)).map_or(&[], Vec::as_slice)
    }

    /// The node of an object that can have only one.
    fn first<'a>(
        &'a self,
        kind: NodeTarget,
        name: &'a str,
    ) -> Option<(&'a KeyframerNode, &'a PlacedNode)> {
        let first = *self.of(kind, name).first()?;
        Some((&self.nodes[first], &self.placed[first]))
    }

    /// The position of a light or camera, if the keyframer has one.
    fn point(&self, kind: NodeTarget, name: &str) -> Option<DVec3> {
        let (_, placed) = self.first(kind, name)?;
        let point = placed.world_from_node.translation;
        (placed.has_position && point.is_finite()).then_some(point)
    }
}

impl Studio3dsBuilder<'_> {
    /// The scene of a file.
    ///
    /// # Errors
    /// Instances that unfold to more than allowed.
    pub fn scene(&mut self, model: &Studio3dsModel<'_>) -> Result<Scene, ReadError> {
        let mut scene = Scene {
            background: model.background.map(azulejo_scene::SceneBackground::Color),
            units: Units {
                up: Up::Z,
                ..Units::default()
            },
            ..Scene::default()
        };
        let table = self.materials(model, &mut scene);
        let nodes = self.nodes(&model.nodes)?;
        self.meshes(model, &table, &nodes, &mut scene)?;
        if uses(&scene, table.default) {
            scene.add_material(Material::diffuse("default", DEFAULT_REFLECTANCE));
        }
        for raw in &model.lights {
            let light = self.light(raw, &nodes);
            scene.lights.push(light);
        }
        for raw in &model.cameras {
            scene.cameras.extend(self.camera(raw, &nodes));
        }
        Ok(scene)
    }

    /// Materials of the file in their order, then those that are referred to but not defined.
    fn materials(&mut self, model: &Studio3dsModel<'_>, scene: &mut Scene) -> MaterialTable {
        let mut table = MaterialTable::default();
        let mut textures = Textures::default();
        for definition in &model.materials {
            let mut material = definition.material(&mut self.walker);
            if let Some(map) = &definition.map {
                self.picture(map, definition.at, &mut textures, &mut material);
            }
            if let Some(map) = &definition.opacity_map {
                self.opacity(map, definition.at, &mut textures, &mut material);
            }
            // One set of coordinates serves both maps.
            let map = definition.map.as_ref().or(definition.opacity_map.as_ref());
            let transform = map.and_then(TextureMap::transform);
            let of_opacity = definition.opacity_map.as_ref();
            if of_opacity.is_some_and(|m| m.transform() != transform) {
                let message = "opacity map placed otherwise than the texture map: placed as that";
                self.walker.warn(definition.at, message);
            }
            table.transforms.push(transform);
            table.are_flat.push(definition.is_flat);
            let id = scene.add_material(material);
            let earlier = table.by_name.insert(definition.name.clone(), id);
            if earlier.is_some() {
                let message = "material with the name of an earlier one: the later one is used";
                self.walker.warn(definition.at, message);
            }
        }
        self.undefined_materials(model, scene, &mut table);
        scene.textures = textures.into_list();
        table.default = scene.materials.len() as MaterialId;
        table
    }

    fn picture(
        &mut self,
        map: &TextureMap,
        at: u64,
        textures: &mut Textures,
        material: &mut Material,
    ) {
        let (id, problem) = textures.index("", &map.file, self.files);
        let id = textures.wrapped(id, map.wrap());
        material.textures.push(id);
        if let Some(problem) = problem {
            self.walker.warn(at, problem);
        }
        if textures.is_loaded(id) {
            // 3D Studio's textures replace the colour, they do not multiply it.
            material.diffuse = Rgb::WHITE;
        }
    }

    /// The brightness of a map multiplies the opacity.
    fn opacity(
        &mut self,
        map: &TextureMap,
        at: u64,
        textures: &mut Textures,
        material: &mut Material,
    ) {
        let (texture, problem) = textures.index("", &map.file, self.files);
        let texture = textures.wrapped(texture, map.wrap());
        let opacity = material.opacity.unwrap_or(Opacity::constant(1.0));
        material.opacity = Some(Opacity {
            picture: Some(OpacityPicture {
                texture,
                channel: OpacityChannel::Luminance,
            }),
            ..opacity
        });
        if let Some(problem) = problem {
            self.walker.warn(at, problem);
        }
    }

    /// Adds grey materials for the names that meshes use but the file does not define.
    fn undefined_materials(
        &mut self,
        model: &Studio3dsModel<'_>,
        scene: &mut Scene,
        table: &mut MaterialTable,
    ) {
        for list in model.meshes.iter().flat_map(|m| &m.face_materials) {
            if table.by_name.contains_key(&list.material) {
                continue;
            }
            let shown = shortened(&list.material);
            let message = format!("undefined material \"{shown}\": grey with reflectance 0.5");
            self.walker.warn(list.at, message);
            let grey = Material::diffuse(list.material.clone(), DEFAULT_REFLECTANCE);
            table
                .by_name
                .insert(list.material.clone(), scene.add_material(grey));
        }
    }

    fn nodes<'n>(&mut self, nodes: &'n [KeyframerNode]) -> Result<PlacedNodes<'n>, ReadError> {
        let file = self.walker.file;
        let placed = keyframer::place(nodes, &mut self.walker, &mut self.budget);
        let mut by_name: HashMap<_, Vec<usize>> = HashMap::new();
        for (i, node) in nodes.iter().enumerate() {
            by_name
                .entry((node.kind, node.name.as_str()))
                .or_default()
                .push(i);
        }
        Ok(PlacedNodes {
            nodes,
            placed: placed.map_err(|e| e.error(file))?,
            by_name,
        })
    }

    fn meshes(
        &mut self,
        model: &Studio3dsModel<'_>,
        table: &MaterialTable,
        nodes: &PlacedNodes<'_>,
        scene: &mut Scene,
    ) -> Result<(), ReadError> {
        let mut alike: HashMap<&str, usize> = HashMap::new();
        for raw in &model.meshes {
            *alike.entry(&raw.name).or_default() += 1;
        }
        let mut seen: HashMap<&str, usize> = HashMap::new();
        for raw in &model.meshes {
            let nth = seen.entry(&raw.name).or_default();
            let of_name = nodes.of(NodeTarget::Mesh, &raw.name);
            let own = match alike[raw.name.as_str()] {
                1 => of_name,
                // Meshes with the same name share the nodes of that name, in their order.
                _ => of_name.get(*nth..=*nth).unwrap_or_default(),
            };
            *nth += 1;
            self.instances(raw, own, table, nodes, scene)?;
        }
        if scene.objects.is_empty() {
            self.walker.warn(0, "no faces: the scene is empty");
        }
        Ok(())
    }

    /// Adds one object for each node of a mesh; a mesh without nodes becomes one as stored.
    fn instances(
        &mut self,
        raw: &RawMesh<'_>,
        own: &[usize],
        table: &MaterialTable,
        nodes: &PlacedNodes<'_>,
        scene: &mut Scene,
    ) -> Result<(), ReadError> {
        let stored = mesh::mesh(raw, table, &mut self.walker);
        if stored.faces.is_empty() {
            self.walker.warn(raw.at, "mesh without faces: skipped");
            return Ok(());
        }
        if own.is_empty() {
            scene
                .objects
                .push(Object::new(raw.name.clone(), Shape::Mesh(stored)));
            return Ok(());
        }
        for &node in own {
            if nodes.nodes[node].is_hidden {
                self.walker
                    .warn(nodes.nodes[node].at, "hidden node: skipped");
                continue;
            }
            let placed = &nodes.placed[node];
            let elements =
                stored.positions.len() + stored.faces.corners.len() + placed.path.len() / 16;
            let spent = self.budget.spend(elements as u64);
            spent.map_err(|e| e.error(self.walker.file))?;
            if !self.budget.keeps() {
                continue;
            }
            let mut mesh = stored.clone();
            if let Some(map) = self.placement(raw, &stored, placed) {
                mesh.transform(&map);
            }
            scene
                .objects
                .push(Object::new(placed.path.clone(), Shape::Mesh(mesh)));
        }
        Ok(())
    }

    /// The transform of a mesh from its stored position; `None` if there is none.
    fn placement(
        &mut self,
        raw: &RawMesh<'_>,
        stored: &Mesh,
        placed: &PlacedNode,
    ) -> Option<DAffine3> {
        if !placed.has_position {
            return None;
        }
        let frame = raw.frame.map(keyframer::world_from_mesh);
        if frame == Some(None) {
            self.walker.warn(
                raw.at,
                "mesh whose local frame is singular: placed as stored",
            );
            return None;
        }
        let bounds = Aabb::around(stored.positions.iter().copied());
        let frame = match frame.flatten() {
            Some(frame) if frame != DAffine3::IDENTITY => frame,
            _ => lost_frame(bounds, placed).unwrap_or(DAffine3::IDENTITY),
        };
        let pivot = DAffine3::from_translation(-placed.pivot);
        let map = placed.world_from_node * pivot * frame.inverse();
        let ends = [bounds.min, bounds.max].map(|p| map.transform_point3(p));
        if !(map.is_finite() && ends[0].is_finite() && ends[1].is_finite()) {
            self.walker.warn(
                raw.at,
                "node whose transform overflows: mesh placed as stored",
            );
            return None;
        }
        moves(&map, bounds).then_some(map)
    }

    fn light(&mut self, raw: &RawLight, nodes: &PlacedNodes<'_>) -> Light {
        let position = nodes
            .point(NodeTarget::Light, &raw.name)
            .unwrap_or(raw.position);
        let intensity = raw.intensity;
        let kind = match raw.spot {
            None => LightKind::Point {
                position,
                intensity,
            },
            Some(spot) => {
                let target = nodes
                    .point(NodeTarget::SpotTarget, &raw.name)
                    .unwrap_or(spot.target);
                let half = |full: f64| 0.5 * full.clamp(0.0, 360.0).to_radians();
                let outer = half(spot.fall_off);
                LightKind::Spot {
                    position,
                    direction: (target - position).try_normalize().unwrap_or(DVec3::NEG_Z),
                    intensity,
                    inner: half(spot.hot_spot).min(outer),
                    outer,
                }
            }
        };
        Light {
            name: raw.name.clone(),
            kind,
        }
    }

    fn camera(&mut self, raw: &RawCamera, nodes: &PlacedNodes<'_>) -> Option<Camera> {
        let eye = nodes
            .point(NodeTarget::Camera, &raw.name)
            .unwrap_or(raw.position);
        let target = nodes
            .point(NodeTarget::CameraTarget, &raw.name)
            .unwrap_or(raw.target);
        let Some(forward) = (target - eye).try_normalize() else {
            self.walker
                .warn(raw.at, "camera without a viewing direction: skipped");
            return None;
        };
        let node = nodes
            .first(NodeTarget::Camera, &raw.name)
            .map(|(node, _)| node);
        let roll = node.and_then(|n| n.roll).unwrap_or(raw.bank);
        let upright = if forward.z.abs() > UPRIGHT {
            DVec3::Y
        } else {
            DVec3::Z
        };
        let turn = DQuat::from_axis_angle(forward, roll.to_radians());
        Some(Camera {
            name: raw.name.clone(),
            eye,
            target,
            up: if roll.is_finite() {
                turn * upright
            } else {
                upright
            },
            vertical_fov: self.vertical_fov(raw, node),
            size: None,
        })
    }

    /// Converts the horizontal field of view, which is 2400 / lens degrees: this is 3D Studio's own
    /// rule, and agrees with the keyframer's value in files that have both.
    fn vertical_fov(&mut self, raw: &RawCamera, node: Option<&KeyframerNode>) -> f64 {
        let mut horizontal = node
            .and_then(|n| n.field_of_view)
            .unwrap_or(2400.0 / raw.lens);
        if !(MOST_ZOOM..=180.0 - MOST_ZOOM).contains(&horizontal) {
            self.walker
                .warn(raw.at, "camera with an invalid field of view: 45 degrees");
            horizontal = 45.0;
        }
        2.0 * ((0.5 * horizontal.to_radians()).tan() / ASPECT).atan()
    }
}

/// The local frame of a mesh whose file lost it, in which pivots count from the middle of the mesh's box, where 3D Studio
/// begins its frames: that is so if the pivot is where the node is. Without it such models fall apart.
fn lost_frame(bounds: Aabb, placed: &PlacedNode) -> Option<DAffine3> {
    let pivot = bounds.centre() + placed.pivot;
    let away = (placed.world_from_node.translation - pivot).length();
    let is_at_node = away <= AT_NODE * bounds.diagonal();
    is_at_node.then(|| DAffine3::from_translation(bounds.centre()))
}

/// Whether a map moves any corner of a box by more than rounding.
fn moves(map: &DAffine3, bounds: Aabb) -> bool {
    let size = bounds.min.abs().max(bounds.max.abs()).max_element();
    let moved = (0..8).map(|corner| {
        let pick = |axis: usize| {
            let end = if corner >> axis & 1 == 0 {
                bounds.min
            } else {
                bounds.max
            };
            end[axis]
        };
        let p = DVec3::new(pick(0), pick(1), pick(2));
        (map.transform_point3(p) - p).abs().max_element()
    });
    moved.fold(0.0, f64::max) > ROUNDING * size
}

/// Whether any face has this material.
fn uses(scene: &Scene, material: MaterialId) -> bool {
    scene.objects.iter().any(|o| match &o.shape {
        Shape::Mesh(mesh) => mesh.face_materials.contains(&material),
        Shape::Instance(instance) => instance.mesh.face_materials.contains(&material),
        Shape::Primitive(p) => p.material == material,
        Shape::Exact(_) => false,
    })
}
