//! Converts a document to a scene.

use super::SffResult;
use super::document::*;
use super::lights::{self, SffLight};
use super::shapes::{self, ScaleShift};
use super::textures::{TextureContext, TextureFiles};
use super::tree::{SffNode, SffNodeKind, SffTree};
use super::typeset::{TypesetContext, Typesetter};
use super::{block, data, lines::SffLines, surfaces};
use crate::reading::files::open_beside;
use crate::reading::options::Budget;
use crate::reading::text::{into_decoded, shortened};
use crate::reading::warnings::Warnings;
use crate::surface::gloss::Gloss;
use crate::{Files, ReadError, ReadOptions};
use azulejo_scene::rtrace::{Rtrace, RtraceMaterial, RtraceSurface};
use azulejo_scene::{
    Camera, Csg, Exact, Light, LightKind, Material, MaterialId, Object, Primitive, PrimitiveKind,
    Rgb, Scene, Shape, Solid, Up,
};
use glam::DAffine3;
use std::borrow::Cow;
use std::collections::HashMap;

/// The scene of a document, valid in the sense of [`Scene::validate`].
///
/// # Errors
/// Invalid records, with their positions.
pub(crate) fn resolve(
    document: &SffDocument,
    sources: &mut SffSources,
    files: &dyn Files,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> SffResult<Scene> {
    let tree = SffTree::new(document, sources, warnings)?;
    let mut resolver = SffResolver {
        tree: &tree,
        files,
        budget: Budget::new(options),
        sources,
        warnings,
        surfaces: document.surfaces.iter().map(surfaces::derived).collect(),
        gloss: Gloss::default(),
        known_materials: HashMap::new(),
        chains: TextureChains::default(),
        typesetter: Typesetter::default(),
        texture_files: TextureFiles::default(),
        names: HashMap::new(),
        scene: Scene::default(),
        rtrace: Rtrace::default(),
        corner_surfaces: None,
    };
    resolver.view(document)?;
    resolver.scene.objects.reserve(tree.roots.len());
    for &root in &tree.roots {
        let node = &tree.nodes[root];
        let given = InheritedAttributes::default().with(root, node);
        resolver.object(root, DAffine3::IDENTITY, given)?;
    }
    resolver.clear_texture_flags(document);
    resolver.add_lights(document);
    let name = resolver.sources.name(0).to_owned();
    let scene = resolver.finish(document);
    match scene.validate() {
        Ok(()) => Ok(scene),
        // Remaining errors are numbers so large or small that the scene degenerates.
        Err(e) => Err(ReadError::whole(
            name,
            e.to_string(),
            "numbers of ordinary magnitude",
        )),
    }
}

/// Attributes that enclosing operations set for an object: the outermost one takes precedence.
#[derive(Clone, Copy, Default)]
struct InheritedAttributes {
    surface: Option<u32>,
    refraction: Option<f64>,
    /// The object whose textures apply.
    textured: Option<usize>,
}

impl InheritedAttributes {
    fn with(self, index: usize, node: &SffNode) -> InheritedAttributes {
        let appearance = node.appearance;
        let textured = !node.inline_textures.is_empty() || !node.section_textures.is_empty();
        InheritedAttributes {
            surface: self
                .surface
                .or((appearance.surface > 0).then_some(appearance.surface)),
            refraction: (self.refraction)
                .or((appearance.refraction > 0.0).then_some(appearance.refraction)),
            textured: self.textured.or(textured.then_some(index)),
        }
    }
}

/// Everything that distinguishes two materials: the surface, the bits of the index of refraction
/// and the index of the textures.
type SffMaterialKey = (u32, u64, Option<usize>);

/// A set operation or list whose members are being converted.
struct OpenOperation {
    node: usize,
    map: DAffine3,
    given: InheritedAttributes,
    sides: [Vec<Solid>; 2],
}

struct SffResolver<'r, 's> {
    tree: &'r SffTree<'r>,
    files: &'r dyn Files,
    budget: Budget,
    sources: &'r mut SffSources<'s>,
    warnings: &'r mut Warnings,
    surfaces: Vec<RtraceSurface>,
    gloss: Gloss,
    known_materials: HashMap<SffMaterialKey, MaterialId>,
    chains: TextureChains,
    typesetter: Typesetter,
    texture_files: TextureFiles,
    /// The number of named objects of each type.
    names: HashMap<&'static str, usize>,
    scene: Scene,
    rtrace: Rtrace,
    /// The surfaces at the corners of the latest mesh, if they differ.
    corner_surfaces: Option<Vec<[u32; 3]>>,
}

impl SffResolver<'_, '_> {
    fn view(&mut self, document: &SffDocument) -> SffResult<()> {
        let view = &document.view;
        let direction = view.target - view.eye;
        if !lights::spans(direction, view.up) {
            let found = "an eye, a target and an up vector that do not span a plane";
            let expected =
                "two different points, and an up vector that is not parallel to the view";
            return Err(self.sources.error(view.place, found, expected));
        }
        let [horizontal, vertical] = view.angles.map(f64::to_radians);
        let aspect = horizontal.tan() / vertical.tan();
        self.scene.cameras.push(Camera {
            name: String::new(),
            eye: view.eye,
            target: view.target,
            up: view.up,
            vertical_fov: 2.0 * vertical,
            size: Some(((256.0 * aspect).round().clamp(1.0, 16384.0) as u32, 256)),
        });
        let up = view.up.abs();
        if up.z > up.y && up.z > up.x {
            self.scene.units.up = Up::Z;
        }
        self.rtrace.eye = view.eye;
        self.rtrace.look = view.target;
        self.rtrace.up = view.up;
        self.rtrace.half_angles = [horizontal, vertical];
        Ok(())
    }

    fn spend(&mut self, elements: usize, place: SffPosition) -> SffResult<()> {
        let name = self.sources.name(place.file);
        (self.budget.spend(elements as u64)).map_err(|e| e.error(name))
    }

    fn warn(&mut self, place: SffPosition, message: impl Into<String>) {
        let sources = &*self.sources;
        let position = || sources.position(place);
        self.warnings
            .add(sources.name(place.file), message.into(), position);
    }

    /// Adds an object, or the members of a list, which is a single object only within a set
    /// operation.
    fn object(&mut self, index: usize, map: DAffine3, given: InheritedAttributes) -> SffResult<()> {
        // Dissolve a list, unless its members are the parts of one closed cone.
        let node = &self.tree.nodes[index];
        if let SffNodeKind::List(members) = &node.kind
            && self.closed_cone(members, given)?.is_none()
        {
            let map = map * node.map;
            for &member in members {
                let given = given.with(member, &self.tree.nodes[member]);
                self.object(member, map, given)?;
            }
            return Ok(());
        }
        // A lone primitive or mesh becomes an object of that kind, everything else an exact shape.
        let mut solids = self.solids(index, map, given)?;
        let is_exact = match &node.kind {
            SffNodeKind::Leaf(SffGeometry::Text(_) | SffGeometry::Patches(_))
            | SffNodeKind::Csg(..) => true,
            SffNodeKind::Leaf(_) | SffNodeKind::List(_) => false,
        };
        let kind = kind_name(node, &solids);
        let shape = match solids.pop() {
            None => {
                self.warn(node.place, "object without any shape: skipped");
                return Ok(());
            }
            Some(Solid::Primitive(primitive)) if !is_exact => Shape::Primitive(primitive),
            Some(Solid::Mesh(mesh)) if !is_exact => Shape::Mesh(*mesh),
            Some(last) => {
                solids.push(last);
                Shape::Exact(Exact::new(solids))
            }
        };
        // The surfaces of corners are stored by the number that the object receives.
        if let Some(corners) = self.corner_surfaces.take() {
            let number = self.scene.objects.len() as u32;
            self.rtrace.corner_surfaces.insert(number, corners);
        }
        // Objects are numbered within their kind, even those that are not kept.
        let count = self.names.entry(kind).or_default();
        *count += 1;
        let name = format!("{kind} {count}");
        if self.budget.keeps() {
            self.scene.objects.push(Object::new(name, shape));
        }
        Ok(())
    }

    /// The solids of an object, transformed.
    ///
    /// Members follow their operation, so that a single pass suffices; nested operations are kept
    /// in an explicit stack.
    fn solids(
        &mut self,
        root: usize,
        map: DAffine3,
        given: InheritedAttributes,
    ) -> SffResult<Vec<Solid>> {
        let mut open: Vec<OpenOperation> = Vec::new();
        let mut done = Vec::new();
        let mut index = root;
        loop {
            // Close the operations that end before this object: several may end at once.
            while let Some(frame) = open.pop_if(|frame| self.tree.nodes[frame.node].end == index) {
                let node = frame.node;
                let solids = self.closed(frame)?;
                match open.last_mut() {
                    Some(around) => self.join(around, node, solids)?,
                    None => done = solids,
                }
            }
            if index == self.tree.nodes[root].end {
                return Ok(done);
            }
            let node = &self.tree.nodes[index];
            self.spend(8, node.place)?;
            // An object inherits the transform and the attributes of what is around it.
            let (map, given) = match open.last() {
                Some(around) => (around.map, around.given.with(index, node)),
                None => (map, given),
            };
            let map = map * node.map;
            // Either an object is complete without its members, which are skipped, or its members come next.
            match self.whole(node, &map, given)? {
                Some(solids) => {
                    match open.last_mut() {
                        Some(around) => self.join(around, index, solids)?,
                        None => done = solids,
                    }
                    index = node.end;
                }
                None => {
                    open.push(OpenOperation {
                        node: index,
                        map,
                        given,
                        sides: Default::default(),
                    });
                    index += 1;
                }
            }
        }
    }

    /// The solids of an object that do not depend on its members.
    fn whole(
        &mut self,
        node: &SffNode,
        map: &DAffine3,
        given: InheritedAttributes,
    ) -> SffResult<Option<Vec<Solid>>> {
        match &node.kind {
            SffNodeKind::Leaf(geometry) => {
                let mut solids = self.leaf(node, geometry, map, given)?;
                let is_placed = matches!(geometry, SffGeometry::Triangles(_));
                if *map != DAffine3::IDENTITY && !is_placed {
                    solids.iter_mut().for_each(|s| s.transform(map));
                }
                Ok(Some(solids))
            }
            SffNodeKind::List(members) => {
                let cone = self.closed_cone(members, given)?;
                Ok(cone.map(|(cone, material)| {
                    let mut cone = shapes::cone(&cone, true, material);
                    cone.world_from_object = *map * cone.world_from_object;
                    vec![Solid::Primitive(cone)]
                }))
            }
            SffNodeKind::Csg(..) => Ok(None),
        }
    }

    /// Adds the solids of a member to the enclosing operation.
    fn join(
        &mut self,
        around: &mut OpenOperation,
        member: usize,
        solids: Vec<Solid>,
    ) -> SffResult<()> {
        let node = &self.tree.nodes[member];
        if self.corner_surfaces.take().is_some() {
            let message = "mesh with several surfaces inside another object: a single one is used";
            self.warn(node.place, message);
        }
        let is_csg = matches!(self.tree.nodes[around.node].kind, SffNodeKind::Csg(..));
        if is_csg && !solids.iter().all(|solid| solid.open_part().is_none()) {
            let found = "an open shape in a set operation, which has no interior";
            let expected = "closed shapes, or a list (67) of pieces that close it together";
            return Err(self.sources.error(node.place, found, expected));
        }
        around.sides[node.side].extend(solids);
        Ok(())
    }

    /// The result of a set operation or list once all of its members are converted.
    fn closed(&mut self, frame: OpenOperation) -> SffResult<Vec<Solid>> {
        let node = &self.tree.nodes[frame.node];
        let [left, right] = frame.sides;
        let SffNodeKind::Csg(operation, _) = node.kind else {
            let is_one = left.len() == 1 && left[0].open_part().is_none();
            return Ok(if left.is_empty() || is_one {
                left
            } else {
                vec![Solid::Shell(left)]
            });
        };
        if left.is_empty() || right.is_empty() {
            let found = "a set operation with an empty side";
            return Err(self
                .sources
                .error(node.place, found, "solids on both sides"));
        }
        let csg = Csg {
            operation,
            left,
            right,
        };
        Ok(vec![Solid::Csg(Box::new(csg))])
    }

    /// The single cone or cylinder that the members of a list form together, and its material.
    fn closed_cone(
        &mut self,
        members: &[usize],
        given: InheritedAttributes,
    ) -> SffResult<Option<(SffCone, MaterialId)>> {
        let nodes = || members.iter().map(|&m| (m, &self.tree.nodes[m]));
        let cones: Option<Vec<SffCone>> = nodes()
            .map(|(_, node)| match node.kind {
                SffNodeKind::Leaf(SffGeometry::Cone(cone)) if node.map == DAffine3::IDENTITY => {
                    Some(*cone)
                }
                _ => None,
            })
            .collect();
        let Some(cone) = cones.and_then(|c| shapes::closed_cone(&c)) else {
            return Ok(None);
        };
        let mut material = None;
        for (member, node) in nodes() {
            let this = self.material(given.with(member, node), node.place)?;
            if *material.get_or_insert(this) != this {
                return Ok(None);
            }
        }
        Ok(material.map(|material| (cone, material)))
    }

    /// The solids of one record. Triangles are transformed by `map`, everything else is not yet.
    fn leaf(
        &mut self,
        node: &SffNode,
        geometry: &SffGeometry,
        map: &DAffine3,
        given: InheritedAttributes,
    ) -> SffResult<Vec<Solid>> {
        let place = node.place;
        // Triangles without a surface, of their own or around them, have one at each corner.
        if let SffGeometry::Triangles(placed) = geometry
            && given.surface.is_none()
        {
            return self.mixed(placed, map, given, place);
        }
        let material = self.material(given, place)?;
        let primitive = |p: Primitive| vec![Solid::Primitive(p)];
        Ok(match geometry {
            SffGeometry::Sphere { centre, radius } => {
                primitive(Primitive::sphere(*centre, *radius, material))
            }
            SffGeometry::Cuboid { centre, half } => {
                primitive(shapes::cuboid(*centre, *half, material))
            }
            SffGeometry::Cone(cone) => primitive(shapes::cone(cone, false, material)),
            SffGeometry::Patches(placed) => {
                let data = self.data(&placed.data, place, data::patches)?;
                self.spend(8 * data.patches.len(), place)?;
                let patches = shapes::patches(&data, under(placed), material);
                patches.map(Solid::Patch).collect()
            }
            SffGeometry::Polygons(placed) => {
                let data = self.data(&placed.data, place, data::polygons)?;
                self.spend(data.faces.corners.len() + data.vertices.len(), place)?;
                let mesh = shapes::polygons(&data, under(placed), material);
                some_faces(mesh)
            }
            SffGeometry::Triangles(placed) => {
                // A record without a surface lists those of the corners, even where one around it prevails.
                let read =
                    |lines: &mut SffLines| data::triangles(lines, node.appearance.surface == 0);
                let data = self.data(&placed.data, place, read)?;
                self.spend(6 * data.corners.len(), place)?;
                some_faces(shapes::triangles(&data, under(placed), map, material).0)
            }
            SffGeometry::Text(data) => {
                let commands = self.commands(data, place)?;
                let mut context = TypesetContext {
                    files: self.files,
                    sources: self.sources,
                    warnings: self.warnings,
                    budget: &mut self.budget,
                };
                let prisms = self.typesetter.run(&commands, material, &mut context)?;
                prisms.into_iter().map(Solid::Prism).collect()
            }
        })
    }

    /// Triangles whose corners have surfaces of their own. Their diffuse reflectances become vertex
    /// colours; specular ones are averaged.
    fn mixed(
        &mut self,
        placed: &PlacedData<TriangleData>,
        map: &DAffine3,
        given: InheritedAttributes,
        place: SffPosition,
    ) -> SffResult<Vec<Solid>> {
        let data = self.data(&placed.data, place, |lines| data::triangles(lines, true))?;
        self.spend(6 * data.corners.len(), place)?;
        // Surfaces are counted from 1, and all must exist.
        let used = || data.surfaces.iter().flatten();
        let Some(&first) = used().next() else {
            return Ok(Vec::new());
        };
        let known = self.surfaces.len() as u32;
        if let Some(odd) = used().find(|s| !(1..=known).contains(*s)) {
            return Err(self.no_surface(*odd, place));
        }
        // A material has one mirror: the mean over all corners. The rest is left for diffuse reflection.
        let surface = |s: u32| &self.surfaces[s as usize - 1];
        let mirror: Rgb = used().map(|s| surfaces::mirror(surface(*s))).sum();
        let mirror = (mirror / used().count() as f64).map(|m| m.clamp(0.0, 1.0));
        let left = Rgb::WHITE - mirror;
        let given = InheritedAttributes {
            surface: Some(first),
            ..given
        };
        let lobe = surfaces::lobe(surface(first).phong, mirror, Rgb::BLACK);
        let mut material = Material {
            mirror,
            ..Material::diffuse(format!("surfaces {first}…"), left)
        };
        // A lobe brings its own diffuse reflectance, but here the vertex colours multiply the rest.
        if !mirror.is_black() {
            let made = self.gloss.cover(&mut material, lobe);
            material.diffuse = left;
            if let Err(message) = made {
                self.warn(place, message);
            }
        }
        let shading = self.rtrace_material(given, place)?;
        let material = self.push_material(material, shading);
        let (mut mesh, corners) = shapes::triangles(&data, under(placed), map, material);
        // Express the diffuse reflectance of each corner as a share of that rest.
        mesh.colors = vec![Rgb::BLACK; mesh.positions.len()];
        for (face, surfaces) in mesh.faces.iter().zip(&corners) {
            for (&vertex, &s) in face.iter().zip(surfaces) {
                let s = &self.surfaces[s as usize];
                mesh.colors[vertex as usize] = limited(s.diffuse * s.color, left);
            }
        }
        self.corner_surfaces = Some(corners);
        Ok(vec![Solid::Mesh(Box::new(mesh))])
    }

    /// The data of a record, which may be in a separate file.
    fn data<'d, T: Clone>(
        &mut self,
        data: &'d RecordData<T>,
        place: SffPosition,
        read: impl FnOnce(&mut SffLines) -> SffResult<T>,
    ) -> SffResult<Cow<'d, T>> {
        match data {
            RecordData::Here(data) => Ok(Cow::Borrowed(data)),
            RecordData::File(name) => {
                let (path, bytes) = self.open(name, place)?;
                let file = self.sources.next();
                let mut lines = SffLines::new(&bytes, &path, file, self.warnings);
                lines.skip_remarks();
                read(&mut lines).map(Cow::Owned)
            }
        }
    }

    /// The commands of a text block. Its file is kept for messages about its commands.
    fn commands<'d>(
        &mut self,
        data: &'d RecordData<Vec<TextCommand>>,
        place: SffPosition,
    ) -> SffResult<Cow<'d, [TextCommand]>> {
        match data {
            RecordData::Here(commands) => Ok(Cow::Borrowed(commands)),
            RecordData::File(name) => {
                let (path, bytes) = self.open(name, place)?;
                let file = self.sources.next();
                let commands = block::read(&mut SffLines::new(&bytes, &path, file, self.warnings))?;
                self.sources.add(&path, bytes);
                Ok(Cow::Owned(commands))
            }
        }
    }

    fn open(&mut self, name: &str, place: SffPosition) -> SffResult<(String, Vec<u8>)> {
        let of = self.sources.name(place.file);
        let opened = open_beside(self.files, of, name).map_err(|e| {
            let found = format!("\"{}\", which cannot be read: {e}", shortened(name));
            self.sources.error(place, found, "a file beside the scene")
        })?;
        // Many records may refer to one file.
        let (path, bytes) = opened;
        self.spend(bytes.len() / 16, place)?;
        Ok((path, into_decoded(bytes)))
    }

    fn no_surface(&self, surface: u32, place: SffPosition) -> ReadError {
        let expected = format!("one of the surfaces, 1 to {}", self.surfaces.len());
        self.sources
            .error(place, format!("surface {surface}"), expected)
    }

    /// The material of an appearance; equal appearances share one.
    fn material(
        &mut self,
        given: InheritedAttributes,
        place: SffPosition,
    ) -> SffResult<MaterialId> {
        let surface = given.surface.unwrap_or(0);
        let ior = given.refraction.unwrap_or(1.0).max(1.0);
        let Some(numbers) = (surface as usize).checked_sub(1) else {
            return Err(self.no_surface(surface, place));
        };
        let Some(numbers) = self.surfaces.get(numbers).copied() else {
            return Err(self.no_surface(surface, place));
        };
        let chain = given
            .textured
            .map(|node| self.chains.number(self.tree, node));
        let key = (surface, ior.to_bits(), chain);
        if let Some(&known) = self.known_materials.get(&key) {
            return Ok(known);
        }
        if surfaces::is_dimmed(&numbers) {
            let message = "surface that transmits less than half of the light: opaque except in RTRACE's own shading";
            self.warn(place, message);
        }
        let shading = self.rtrace_material(given, place)?;
        let name = format!("surface {surface}");
        let (material, made) = surfaces::material(&numbers, ior, name, &mut self.gloss);
        if let Err(message) = made {
            self.warn(place, message);
        }
        let id = self.push_material(material, shading);
        self.known_materials.insert(key, id);
        Ok(id)
    }

    fn push_material(&mut self, material: Material, shading: RtraceMaterial) -> MaterialId {
        self.rtrace.materials.push(shading);
        self.scene.add_material(material)
    }

    fn rtrace_material(
        &mut self,
        given: InheritedAttributes,
        place: SffPosition,
    ) -> SffResult<RtraceMaterial> {
        let mut material = RtraceMaterial {
            surface: given.surface.unwrap_or(1) - 1,
            ior: given.refraction.unwrap_or(1.0).max(1.0),
            ..RtraceMaterial::default()
        };
        let Some(node) = given.textured.map(|k| &self.tree.nodes[k]) else {
            return Ok(material);
        };
        // Each is as large as a few vertices.
        let count = node.inline_textures.len() + node.section_textures.len();
        self.spend(4 * count, place)?;
        let mut around = TextureContext {
            files: self.files,
            sources: self.sources,
            warnings: self.warnings,
            surfaces: self.surfaces.len() as u32,
        };
        let lists = [
            (&node.inline_textures, &mut material.inline_textures),
            (&node.section_textures, &mut material.section_textures),
        ];
        for (records, textures) in lists {
            for record in records {
                textures.extend(self.texture_files.texture(record, &mut around)?);
            }
        }
        self.warn(place, "textures: only visible in RTRACE's own shading");
        Ok(material)
    }

    /// scn2sff wrote random flags for surfaces that only textures use.
    fn clear_texture_flags(&mut self, document: &SffDocument) {
        if !document.is_translated {
            return;
        }
        let mut worn: Vec<bool> = vec![false; self.surfaces.len()];
        let corners = self.rtrace.corner_surfaces.values().flatten().flatten();
        let used = self
            .rtrace
            .materials
            .iter()
            .map(|m| &m.surface)
            .chain(corners);
        used.for_each(|&s| worn[s as usize] = true);
        for (surface, _) in self.surfaces.iter_mut().zip(worn).filter(|(_, worn)| !worn) {
            if surface.is_emitter || surface.is_unshadowed {
                (surface.is_emitter, surface.is_unshadowed) = (false, false);
                let message =
                    "signs written by scn2sff for a surface that only textures use: ignored";
                self.warnings.add_whole(self.sources.name(0), message);
            }
        }
    }

    /// Adds the lights, and emitters for those with area; these come last.
    fn add_lights(&mut self, document: &SffDocument) {
        for (k, light) in document.lights.iter().enumerate() {
            let material = self.scene.materials.len() as MaterialId;
            match lights::physical(light, &document.view, material) {
                SffLight::Lights(kinds) => {
                    let lights = kinds.into_iter().map(|kind| lights::named(k + 1, kind));
                    self.scene.lights.extend(lights);
                }
                SffLight::Body(body, radiance) => {
                    self.scene
                        .add_material(lights::emitter_material(k + 1, radiance));
                    let name = format!("light {}", k + 1);
                    let object = Object::new(name, Shape::Primitive(body));
                    self.scene.objects.push(object);
                }
            }
        }
    }

    fn finish(self, document: &SffDocument) -> Scene {
        let mut scene = self.scene;
        scene.background = Some(document.background.into());
        if !document.ambient.is_black() {
            scene.lights.push(Light {
                name: "ambient".into(),
                kind: LightKind::Ambient {
                    radiance: document.ambient,
                },
            });
        }
        scene.rtrace = Some(Box::new(Rtrace {
            background: document.background,
            ambient: document.ambient,
            lights: document.lights.clone(),
            surfaces: self.surfaces,
            ..self.rtrace
        }));
        scene
    }
}

/// The colour whose product with `left`, the share beside the mirror, is closest to this
/// reflectance.
fn limited(reflectance: Rgb, left: Rgb) -> Rgb {
    let share = |k: usize| {
        let share = reflectance[k] / left[k].max(1e-9);
        share.clamp(0.0, 1.0)
    };
    Rgb::from([0, 1, 2].map(share))
}

fn under<T>(placed: &PlacedData<T>) -> ScaleShift {
    ScaleShift {
        origin: placed.origin,
        scale: placed.scale,
    }
}

fn some_faces(mesh: azulejo_scene::Mesh) -> Vec<Solid> {
    if mesh.faces.is_empty() {
        Vec::new()
    } else {
        vec![Solid::Mesh(Box::new(mesh))]
    }
}

/// The type in an object's name.
fn kind_name(node: &SffNode, solids: &[Solid]) -> &'static str {
    match &node.kind {
        SffNodeKind::Csg(..) => "csg",
        SffNodeKind::Leaf(SffGeometry::Text(_)) => "text",
        SffNodeKind::Leaf(SffGeometry::Patches(_)) => "patches",
        SffNodeKind::Leaf(_) | SffNodeKind::List(_) => match solids {
            [Solid::Primitive(p)] => match p.kind {
                PrimitiveKind::Sphere => "sphere",
                PrimitiveKind::Cuboid => "box",
                PrimitiveKind::Tube { .. } => "tube",
                PrimitiveKind::Cylinder => "cylinder",
                _ => "cone",
            },
            _ => "mesh",
        },
    }
}

/// Everything that distinguishes two lists of textures.
type TextureChainKey = (Vec<u64>, Vec<String>);

/// The textures of objects; equal lists share an index.
#[derive(Default)]
struct TextureChains {
    /// By the object that has them.
    of_nodes: HashMap<usize, usize>,
    known: HashMap<TextureChainKey, usize>,
}

impl TextureChains {
    /// The index of an object's textures.
    fn number(&mut self, tree: &SffTree, node: usize) -> usize {
        if let Some(&known) = self.of_nodes.get(&node) {
            return known;
        }
        let next = self.known.len();
        let key = chain_key(&tree.nodes[node]);
        let number = *self.known.entry(key).or_insert(next);
        self.of_nodes.insert(node, number);
        number
    }
}

fn chain_key(node: &SffNode) -> TextureChainKey {
    let (mut numbers, mut files) = (Vec::new(), Vec::new());
    for records in [&node.inline_textures, &node.section_textures] {
        numbers.push(records.len() as u64);
        for record in records {
            numbers.push(u64::from(record.kind.number));
            let matrix = record.matrix.to_cols_array();
            let values = record.kind.values.iter().chain(&matrix);
            numbers.extend(values.map(|v| v.to_bits()));
            files.push(record.file.clone());
        }
    }
    (numbers, files)
}
