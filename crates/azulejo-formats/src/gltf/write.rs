//! Writes scenes as glTF.

use super::container::{BIN, write_glb};
use super::image_based;
use super::irradiance;
use super::json_parts::{factor_and_strength, named};
use super::local_origin::local_origin;
use super::pack::Pack;
use super::write_image_based;
use super::write_material::{Materials, MattSurfaces};
use super::write_mesh::{self, WrittenMesh};
use azulejo_scene::{
    Camera, Light, LightKind, Mesh, MeshInstance, Object, Scene, Shape, Units, Up,
};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use std::io::{self, Write};
use std::sync::Arc;

/// Distance of the near plane of cameras in metres, which glTF requires.
const NEAR: f64 = 0.01;

/// Writes a scene as one binary file, GLB.
///
/// One node per object, with triangles in single precision; instances share their mesh, and what a lit
/// mesh has beside its irradiance. If the scene is not in metres or
/// not y up, a root node converts it. Where single precision would change what is far from the origin,
/// positions are relative to a point near it, and the node, or the root node for all, has the translation. Sheets with light on both sides are written twice
/// ([`Scene::split_sides`]). [`losses`](super::losses) lists what the format cannot
/// represent.
///
/// # Errors
/// Errors of `out`, and a scene that needs more than 4 GiB.
pub fn write(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    write_with(scene, MattSurfaces::default(), out)
}

/// As [`write()`], with a choice of how the file describes matt surfaces.
///
/// # Errors
/// As [`write()`].
pub fn write_with(scene: &Scene, matt: MattSurfaces, out: &mut dyn Write) -> io::Result<()> {
    let scene = &*scene.split_sides();
    let mut document = Document::of(scene, matt)?;
    let mut json = document.json(None)?;
    let mut bin = std::mem::take(&mut document.pack.bin);
    json.resize(json.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let bin = (!bin.is_empty()).then_some((BIN, &bin[..]));
    let chunks = [(*b"JSON", &json[..])].into_iter().chain(bin);
    write_glb(&chunks.collect::<Vec<_>>(), out)?;
    out.flush()
}

/// Writes a scene as two files: JSON, and a file `bin_name` beside it with numbers and
/// textures. Otherwise like [`write()`].
///
/// # Errors
/// Errors of `json` and `bin`.
pub fn write_json(
    scene: &Scene,
    bin_name: &str,
    json: &mut dyn Write,
    bin: &mut dyn Write,
) -> io::Result<()> {
    let scene = &*scene.split_sides();
    let document = Document::of(scene, MattSurfaces::default())?;
    json.write_all(&document.json(Some(bin_name))?)?;
    bin.write_all(&document.pack.bin)?;
    json.flush()?;
    bin.flush()
}

/// State of writing a file.
struct Document<'a> {
    scene: &'a Scene,
    /// What all that has a place is relative to: the translation of the root node.
    origin: DVec3,
    pack: Pack,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    cameras: Vec<Value>,
    lights: Vec<Value>,
    /// The extension of light from all around.
    around: Option<Value>,
    materials: Materials,
    /// Shared meshes, with the index of the mesh without irradiance.
    shared: HashMap<*const Mesh, (Option<WrittenMesh>, Option<usize>)>,
}

impl<'a> Document<'a> {
    fn of(scene: &'a Scene, matt: MattSurfaces) -> io::Result<Document<'a>> {
        let mut pack = Pack::default();
        let mut document = Document {
            scene,
            origin: local_origin(scene),
            materials: Materials::of(scene, matt, &mut pack)?,
            pack,
            meshes: Vec::new(),
            nodes: Vec::new(),
            cameras: Vec::new(),
            lights: Vec::new(),
            around: None,
            shared: HashMap::new(),
        };
        let images = &mut document.materials.images;
        document.around = write_image_based::write(scene, &mut document.pack, images)?;
        let scale = irradiance::scale(scene);
        for object in &scene.objects {
            match &object.shape {
                Shape::Instance(instance) if !is_sheared(&instance.world_from_mesh) => {
                    document.instance(&object.name, instance, scale);
                }
                _ => document.object(object, scale),
            }
        }
        for light in &scene.lights {
            document.light(light);
        }
        for camera in &scene.cameras {
            document.camera(camera);
        }
        Ok(document)
    }

    fn object(&mut self, object: &Object, scale: f64) {
        let photometric = self.scene.units.photometric;
        let mut node = named(&object.name);
        if let Some((mut mesh, origin)) = write_mesh::mesh(
            object,
            self.origin,
            scale,
            photometric,
            &mut self.materials,
            &mut self.pack,
        ) {
            if !object.name.is_empty() {
                mesh["name"] = json!(object.name);
            }
            node.insert("mesh".into(), json!(self.meshes.len()));
            self.meshes.push(mesh);
            translate(&mut node, origin);
        }
        self.nodes.push(node.into());
    }

    /// A node for an instance: all share what does not depend on the place.
    fn instance(&mut self, name: &str, instance: &MeshInstance, scale: f64) {
        let photometric = self.scene.units.photometric;
        let key = Arc::as_ptr(&instance.mesh);
        if !self.shared.contains_key(&key) {
            let written = WrittenMesh::new(
                &instance.mesh,
                DVec3::ZERO,
                &mut self.materials,
                &mut self.pack,
            );
            self.shared.insert(key, (written, None));
        }
        let mut node = named(name);
        if let Some((Some(written), unlit)) = self.shared.get_mut(&key) {
            let light = instance.light.as_deref();
            let light = light.map_or(&[][..], |l| &l.irradiance);
            let index = match *unlit {
                Some(index) if light.is_empty() => index,
                _ => {
                    let lit = written.lit(light, scale, photometric, &mut self.pack);
                    self.meshes.push(lit);
                    self.meshes.len() - 1
                }
            };
            if light.is_empty() {
                *unlit = Some(index);
            }
            node.insert("mesh".into(), json!(index));
            let map = DMat4::from(placed(instance, self.origin, written.origin));
            if map != DMat4::IDENTITY {
                node.insert("matrix".into(), json!(map.to_cols_array()));
            }
        }
        self.nodes.push(node.into());
    }

    fn light(&mut self, light: &Light) {
        let size = self.scene.units.metres();
        let (kind, colour, position, direction) = match light.kind.without_web() {
            // glTF's falloff uses distances in metres.
            LightKind::Point {
                position,
                intensity,
            } => ("point", intensity * (size * size), Some(position), None),
            LightKind::Spot {
                position,
                direction,
                intensity,
                ..
            } => {
                let candela = intensity * (size * size);
                ("spot", candela, Some(position), Some(direction))
            }
            LightKind::Directional {
                direction,
                irradiance,
                ..
            } => ("directional", irradiance, None, Some(direction)),
            LightKind::Luminaire { .. } | LightKind::Ambient { .. } | LightKind::Environment(_) => {
                return;
            }
        };
        let (factor, strength) = factor_and_strength(colour);
        let mut json = named(&light.name);
        json.insert("type".into(), json!(kind));
        json.insert("color".into(), json!(factor.to_array()));
        json.insert("intensity".into(), json!(strength));
        if let LightKind::Spot { inner, outer, .. } = light.kind {
            json.insert("spot".into(), cone(inner, outer));
        }
        let mut node = named(&light.name);
        let place = position.map_or(DVec3::ZERO, |p| p - self.origin);
        set_transform(&mut node, place, direction, self.scene.units.up.axis());
        let extension = json!({ "KHR_lights_punctual": { "light": self.lights.len() } });
        node.insert("extensions".into(), extension);
        self.nodes.push(node.into());
        self.lights.push(json.into());
    }

    fn camera(&mut self, camera: &Camera) {
        let mut perspective = json!({ "yfov": camera.vertical_fov, "znear": NEAR });
        if let Some((width, height)) = camera.size {
            perspective["aspectRatio"] = json!(f64::from(width) / f64::from(height));
        }
        let mut json = named(&camera.name);
        json.insert("type".into(), json!("perspective"));
        json.insert("perspective".into(), perspective);
        let mut node = named(&camera.name);
        let forward = (camera.target - camera.eye).normalize();
        let eye = camera.eye - self.origin;
        set_transform(&mut node, eye, Some(forward), camera.up);
        node.insert("camera".into(), json!(self.cameras.len()));
        self.nodes.push(node.into());
        self.cameras.push(json.into());
    }

    /// The JSON text; `bin_name` is the file with the numbers, if they are not in a GLB.
    fn json(&self, bin_name: Option<&str>) -> io::Result<Vec<u8>> {
        let mut nodes = self.nodes.clone();
        let mut roots: Vec<usize> = (0..nodes.len()).collect();
        if let Some(mut above) = root_node(&self.scene.units, self.origin)
            && !nodes.is_empty()
        {
            above["children"] = json!(roots);
            roots = vec![nodes.len()];
            nodes.push(above);
        }
        let mut root = Map::new();
        let mut buffer = json!({ "byteLength": self.pack.bin.len() });
        if let Some(name) = bin_name {
            buffer["uri"] = json!(super::uri::escaped(name));
        }
        let buffers = Vec::from_iter((!self.pack.bin.is_empty()).then_some(buffer));
        let lists = [
            ("buffers", &buffers),
            ("bufferViews", &self.pack.views),
            ("accessors", &self.pack.accessors),
            ("meshes", &self.meshes),
            ("materials", &self.materials.list),
            ("textures", &self.materials.textures),
            ("images", &self.materials.images),
            ("samplers", &self.materials.samplers),
            ("cameras", &self.cameras),
            ("nodes", &nodes),
        ];
        // glTF does not allow empty lists.
        for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            root.insert(name.into(), json!(list));
        }
        if !roots.is_empty() {
            let mut scene = json!({ "nodes": roots });
            if self.around.is_some() {
                scene["extensions"] = json!({ (image_based::NAME): { "light": 0 } });
            }
            root.insert("scenes".into(), json!([scene]));
            root.insert("scene".into(), json!(0));
        }
        root.insert("asset".into(), asset(&self.scene.units));
        let mut used: Vec<&str> = self.materials.extensions.iter().copied().collect();
        let mut extensions = Map::new();
        if !self.lights.is_empty() {
            used.push("KHR_lights_punctual");
            let lights = json!({ "lights": self.lights });
            extensions.insert("KHR_lights_punctual".into(), lights);
        }
        if let Some(around) = &self.around {
            used.push(image_based::NAME);
            extensions.insert(image_based::NAME.into(), around.clone());
        }
        if !extensions.is_empty() {
            root.insert("extensions".into(), extensions.into());
        }
        if !used.is_empty() {
            root.insert("extensionsUsed".into(), json!(used));
        }
        Ok(serde_json::to_vec(&root)?)
    }
}

/// Whether a map shears, which glTF does not allow in a node: its nodes turn and scale alone.
fn is_sheared(map: &DAffine3) -> bool {
    let DMat3 {
        x_axis: x,
        y_axis: y,
        z_axis: z,
    } = map.matrix3;
    let pairs = [(x, y), (y, z), (z, x)];
    pairs
        .iter()
        .any(|(a, b)| a.dot(*b).abs() > 1e-9 * a.length() * b.length())
}

/// The generator, and the unit of light.
fn asset(units: &Units) -> Value {
    json!({
        "version": "2.0",
        "generator": concat!("azulejo ", env!("CARGO_PKG_VERSION")),
        "extras": { "azulejo": { "photometric": units.photometric } },
    })
}

/// The node that moves a scene to its place, and rotates and scales it to metres and y up, if necessary.
fn root_node(units: &Units, origin: DVec3) -> Option<Value> {
    let mut node = Map::new();
    let turned = match units.up {
        Up::Y => origin,
        Up::Z => DVec3::new(origin.x, origin.z, -origin.y),
    };
    translate(&mut node, turned * units.metres());
    if units.up == Up::Z {
        let turn = json!([-FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2]);
        node.insert("rotation".into(), turn);
    }
    if units.metres() != 1.0 {
        let scale = [units.metres(); 3];
        node.insert("scale".into(), json!(scale));
    }
    (!node.is_empty()).then(|| node.into())
}

/// Moves a node, unless by nothing.
fn translate(node: &mut Map<String, Value>, by: DVec3) {
    if by != DVec3::ZERO {
        node.insert("translation".into(), json!(by.to_array()));
    }
}

/// The map of an instance whose mesh is written relative to `mesh_origin`, in a scene relative to `origin`.
fn placed(instance: &MeshInstance, origin: DVec3, mesh_origin: DVec3) -> DAffine3 {
    let mut map = instance.world_from_mesh;
    if mesh_origin != DVec3::ZERO {
        map.translation = map.transform_point3(mesh_origin);
    }
    map.translation -= origin;
    map
}

/// Sets the transform of a node whose content faces its −z axis.
fn set_transform(
    node: &mut Map<String, Value>,
    position: DVec3,
    direction: Option<DVec3>,
    up: DVec3,
) {
    translate(node, position);
    let Some(forward) = direction else { return };
    let right = forward.cross(up).try_normalize();
    let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
    let axes = DMat3::from_cols(right, right.cross(forward), -forward);
    let rotation = DQuat::from_mat3(&axes).normalize();
    node.insert("rotation".into(), json!(rotation.to_array()));
}

/// Angles of a spot light. In glTF they are below a right angle, the inner less than the outer.
fn cone(inner: f64, outer: f64) -> Value {
    let outer = outer.clamp(1e-6, FRAC_PI_2);
    let inner = inner.min(outer * (1.0 - 1e-6));
    json!({ "innerConeAngle": inner, "outerConeAngle": outer })
}
