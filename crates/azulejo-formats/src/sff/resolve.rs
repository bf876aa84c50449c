//! A document as a scene.

use super::document::*;
use super::lights::{self, Lamp};
use super::shapes::{self, Under};
use super::textures::{Surroundings, TextureFiles};
use super::tree::{Node, NodeKind, Tree};
use super::typeset::{Desk, Typesetter};
use super::{block, data, lines::Lines, surfaces};
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

type Read<T> = Result<T, ReadError>;

/// The scene of a document, valid in the sense of [`Scene::validate`].
///
/// # Errors
/// Whatever a record says that cannot be, with its place.
pub(crate) fn resolve(
    document: &Document,
    sources: &mut Sources,
    files: &dyn Files,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Read<Scene> {
    let tree = Tree::new(document, sources, warnings)?;
    let mut resolver = Resolver {
        files,
        budget: Budget::new(options),
        sources,
        warnings,
        surfaces: document.surfaces.iter().map(surfaces::derived).collect(),
        gloss: Gloss::default(),
        looks: HashMap::new(),
        chains: Chains::default(),
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
        resolver.object(
            &tree,
            root,
            DAffine3::IDENTITY,
            Given::default().with(root, node),
        )?;
    }
    resolver.forgive_translated(document);
    resolver.lamps(document);
    let name = resolver.sources.name(0).to_owned();
    let scene = resolver.finish(document);
    match scene.validate() {
        Ok(()) => Ok(scene),
        // What the checks on the way leave: numbers so large or small that they leave nothing.
        Err(e) => Err(ReadError::whole(
            name,
            e.to_string(),
            "numbers of ordinary size",
        )),
    }
}

/// What the operations around an object decide for it: the outermost that says anything does.
#[derive(Clone, Copy, Default)]
struct Given {
    surface: Option<u32>,
    refraction: Option<f64>,
    /// The object whose textures count.
    textured: Option<usize>,
}

impl Given {
    fn with(self, index: usize, node: &Node) -> Given {
        let look = node.look;
        let textured = !node.inline_textures.is_empty() || !node.section_textures.is_empty();
        Given {
            surface: self.surface.or((look.surface > 0).then_some(look.surface)),
            refraction: (self.refraction).or((look.refraction > 0.0).then_some(look.refraction)),
            textured: self.textured.or(textured.then_some(index)),
        }
    }
}

/// Everything that tells two materials apart: the surface, the bits of the index of refraction and
/// the number of the textures.
type LookKey = (u32, u64, Option<usize>);

/// A set operation or list whose members are being made.
struct Frame {
    node: usize,
    map: DAffine3,
    given: Given,
    sides: [Vec<Solid>; 2],
}

struct Resolver<'r, 's> {
    files: &'r dyn Files,
    budget: Budget,
    sources: &'r mut Sources<'s>,
    warnings: &'r mut Warnings,
    surfaces: Vec<RtraceSurface>,
    gloss: Gloss,
    looks: HashMap<LookKey, MaterialId>,
    chains: Chains,
    typesetter: Typesetter,
    texture_files: TextureFiles,
    /// How many objects of each kind have a name.
    names: HashMap<&'static str, usize>,
    scene: Scene,
    rtrace: Rtrace,
    /// The surfaces at the corners of the mesh that was made last, if they differ.
    corner_surfaces: Option<Vec<[u32; 3]>>,
}

impl Resolver<'_, '_> {
    fn view(&mut self, document: &Document) -> Read<()> {
        let view = &document.view;
        let gaze = view.look - view.eye;
        if !lights::spans(gaze, view.up) {
            let found = "an eye, a point to look at and an up that do not span a plane";
            let expected = "two different points, and an up that is not along the view";
            return Err(self.sources.error(view.place, found, expected));
        }
        let [horizontal, vertical] = view.angles.map(f64::to_radians);
        let aspect = horizontal.tan() / vertical.tan();
        self.scene.cameras.push(Camera {
            name: String::new(),
            eye: view.eye,
            target: view.look,
            up: view.up,
            vertical_fov: 2.0 * vertical,
            size: Some(((256.0 * aspect).round().clamp(1.0, 16384.0) as u32, 256)),
        });
        let up = view.up.abs();
        if up.z > up.y && up.z > up.x {
            self.scene.units.up = Up::Z;
        }
        self.rtrace.eye = view.eye;
        self.rtrace.look = view.look;
        self.rtrace.up = view.up;
        self.rtrace.half_angles = [horizontal, vertical];
        Ok(())
    }

    fn spend(&mut self, elements: usize, place: Place) -> Read<()> {
        let name = self.sources.name(place.file);
        (self.budget.spend(elements as u64)).map_err(|e| e.error(name))
    }

    fn warn(&mut self, place: Place, message: impl Into<String>) {
        let sources = &*self.sources;
        let position = || sources.position(place);
        self.warnings
            .add(sources.name(place.file), message.into(), position);
    }

    /// Adds an object, or the members of a list, which is one object only to a set operation.
    fn object(&mut self, tree: &Tree, index: usize, map: DAffine3, given: Given) -> Read<()> {
        let node = &tree.nodes[index];
        if let NodeKind::List(members) = &node.kind
            && self.closed_cone(tree, members, given)?.is_none()
        {
            let map = map * node.map;
            for &member in members {
                let given = given.with(member, &tree.nodes[member]);
                self.object(tree, member, map, given)?;
            }
            return Ok(());
        }
        let mut solids = self.solids(tree, index, map, given)?;
        let is_exact = match &node.kind {
            NodeKind::Leaf(Geometry::Text(_) | Geometry::Patches(_)) | NodeKind::Csg(..) => true,
            NodeKind::Leaf(_) | NodeKind::List(_) => false,
        };
        let kind = kind_of(node, &solids);
        let shape = match solids.pop() {
            None => {
                self.warn(node.place, "an object without any shape: left out");
                return Ok(());
            }
            Some(Solid::Primitive(primitive)) if !is_exact => Shape::Primitive(primitive),
            Some(Solid::Mesh(mesh)) if !is_exact => Shape::Mesh(mesh),
            Some(last) => {
                solids.push(last);
                Shape::Exact(Exact::new(solids))
            }
        };
        if let Some(corners) = self.corner_surfaces.take() {
            let number = self.scene.objects.len() as u32;
            self.rtrace.corner_surfaces.insert(number, corners);
        }
        let count = self.names.entry(kind).or_default();
        *count += 1;
        let name = format!("{kind} {count}");
        self.scene.objects.push(Object::new(name, shape));
        Ok(())
    }

    /// The solids of an object, placed.
    ///
    /// Members follow their operation, so that one pass over them is enough; what nests deeply
    /// waits in a list of its own, not on the stack.
    fn solids(
        &mut self,
        tree: &Tree,
        root: usize,
        map: DAffine3,
        given: Given,
    ) -> Read<Vec<Solid>> {
        let mut open: Vec<Frame> = Vec::new();
        let mut done = Vec::new();
        let mut index = root;
        loop {
            while let Some(frame) = open.pop_if(|frame| tree.nodes[frame.node].end == index) {
                let node = frame.node;
                let solids = self.closed(tree, frame)?;
                match open.last_mut() {
                    Some(around) => self.join(tree, around, node, solids)?,
                    None => done = solids,
                }
            }
            if index == tree.nodes[root].end {
                return Ok(done);
            }
            let node = &tree.nodes[index];
            self.spend(8, node.place)?;
            let (map, given) = match open.last() {
                Some(around) => (around.map, around.given.with(index, node)),
                None => (map, given),
            };
            let map = map * node.map;
            match self.whole(tree, node, &map, given)? {
                Some(solids) => {
                    match open.last_mut() {
                        Some(around) => self.join(tree, around, index, solids)?,
                        None => done = solids,
                    }
                    index = node.end;
                }
                None => {
                    open.push(Frame {
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

    /// The solids of an object that can be made without its members.
    fn whole(
        &mut self,
        tree: &Tree,
        node: &Node,
        map: &DAffine3,
        given: Given,
    ) -> Read<Option<Vec<Solid>>> {
        match &node.kind {
            NodeKind::Leaf(geometry) => {
                let mut solids = self.leaf(tree, node, geometry, map, given)?;
                let is_placed = matches!(geometry, Geometry::Triangles(_));
                if *map != DAffine3::IDENTITY && !is_placed {
                    solids.iter_mut().for_each(|s| s.transform(map));
                }
                Ok(Some(solids))
            }
            NodeKind::List(members) => {
                let cone = self.closed_cone(tree, members, given)?;
                Ok(cone.map(|(cone, material)| {
                    let mut cone = shapes::cone(&cone, true, material);
                    cone.world_from_object = *map * cone.world_from_object;
                    vec![Solid::Primitive(cone)]
                }))
            }
            NodeKind::Csg(..) => Ok(None),
        }
    }

    /// Adds the solids of a member to what is around it.
    fn join(
        &mut self,
        tree: &Tree,
        around: &mut Frame,
        member: usize,
        solids: Vec<Solid>,
    ) -> Read<()> {
        let node = &tree.nodes[member];
        if self.corner_surfaces.take().is_some() {
            let said = "a mesh of several surfaces inside of another object: one is used";
            self.warn(node.place, said);
        }
        let is_csg = matches!(tree.nodes[around.node].kind, NodeKind::Csg(..));
        if is_csg && !solids.iter().all(is_closed) {
            let found = "an open shape in a set operation: it has no inside";
            let expected = "closed ones, or a list (67) of pieces that close it together";
            return Err(self.sources.error(node.place, found, expected));
        }
        around.sides[node.side].extend(solids);
        Ok(())
    }

    /// What a set operation or list becomes when it has all of its members.
    fn closed(&mut self, tree: &Tree, frame: Frame) -> Read<Vec<Solid>> {
        let node = &tree.nodes[frame.node];
        let [left, right] = frame.sides;
        let NodeKind::Csg(operation, _) = node.kind else {
            let is_one = left.len() == 1 && is_closed(&left[0]);
            return Ok(match left.is_empty() || is_one {
                true => left,
                false => vec![Solid::Shell(left)],
            });
        };
        if left.is_empty() || right.is_empty() {
            let found = "a set operation with nothing on one side";
            return Err(self.sources.error(node.place, found, "solids on both"));
        }
        let csg = Csg {
            operation,
            left,
            right,
        };
        Ok(vec![Solid::Csg(Box::new(csg))])
    }

    /// The one cone or cylinder that the members of a list are together, and its material.
    fn closed_cone(
        &mut self,
        tree: &Tree,
        members: &[usize],
        given: Given,
    ) -> Read<Option<(Cone, MaterialId)>> {
        let nodes = || members.iter().map(|&m| (m, &tree.nodes[m]));
        let cones: Option<Vec<Cone>> = nodes()
            .map(|(_, node)| match node.kind {
                NodeKind::Leaf(Geometry::Cone(cone)) if node.map == DAffine3::IDENTITY => {
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
            let this = self.material(tree, given.with(member, node), node.place)?;
            if *material.get_or_insert(this) != this {
                return Ok(None);
            }
        }
        Ok(material.map(|material| (cone, material)))
    }

    /// The solids of one record. Triangles are placed by `map`, everything else is not yet.
    fn leaf(
        &mut self,
        tree: &Tree,
        node: &Node,
        geometry: &Geometry,
        map: &DAffine3,
        given: Given,
    ) -> Read<Vec<Solid>> {
        let place = node.place;
        if let Geometry::Triangles(placed) = geometry
            && given.surface.is_none()
        {
            return self.mixed(tree, placed, map, given, place);
        }
        let material = self.material(tree, given, place)?;
        let primitive = |p: Primitive| vec![Solid::Primitive(p)];
        Ok(match geometry {
            Geometry::Sphere { centre, radius } => {
                primitive(Primitive::sphere(*centre, *radius, material))
            }
            Geometry::Cuboid { centre, half } => {
                primitive(shapes::cuboid(*centre, *half, material))
            }
            Geometry::Cone(cone) => primitive(shapes::cone(cone, false, material)),
            Geometry::Patches(placed) => {
                let data = self.data(&placed.data, place, data::patches)?;
                self.spend(8 * data.patches.len(), place)?;
                let patches = shapes::patches(&data, under(placed), material);
                patches.map(Solid::Patch).collect()
            }
            Geometry::Polygons(placed) => {
                let data = self.data(&placed.data, place, data::polygons)?;
                self.spend(data.faces.corners.len() + data.vertices.len(), place)?;
                let mesh = shapes::polygons(&data, under(placed), material);
                some_faces(mesh)
            }
            Geometry::Triangles(placed) => {
                let read = |lines: &mut Lines| data::triangles(lines, node.look.surface == 0);
                let data = self.data(&placed.data, place, read)?;
                self.spend(6 * data.corners.len(), place)?;
                some_faces(shapes::triangles(&data, under(placed), map, material).0)
            }
            Geometry::Text(data) => {
                let commands = self.commands(data, place)?;
                let mut desk = Desk {
                    files: self.files,
                    sources: self.sources,
                    warnings: self.warnings,
                    budget: &mut self.budget,
                };
                let prisms = self.typesetter.run(&commands, material, &mut desk)?;
                prisms.into_iter().map(Solid::Prism).collect()
            }
        })
    }

    /// Triangles whose corners have surfaces of their own. What they reflect diffusely stands in
    /// the colours of the vertices; what they mirror is the mean.
    fn mixed(
        &mut self,
        tree: &Tree,
        placed: &Placed<TriangleData>,
        map: &DAffine3,
        given: Given,
        place: Place,
    ) -> Read<Vec<Solid>> {
        let data = self.data(&placed.data, place, |lines| data::triangles(lines, true))?;
        self.spend(6 * data.corners.len(), place)?;
        let used = || data.surfaces.iter().flatten();
        let Some(&first) = used().next() else {
            return Ok(Vec::new());
        };
        let known = self.surfaces.len() as u32;
        if let Some(odd) = used().find(|s| !(1..=known).contains(*s)) {
            return Err(self.no_surface(*odd, place));
        }
        let surface = |s: u32| &self.surfaces[s as usize - 1];
        let mirror: Rgb = used().map(|s| surfaces::mirror(surface(*s))).sum();
        let mirror = (mirror / used().count() as f64).map(|m| m.clamp(0.0, 1.0));
        let left = Rgb::WHITE - mirror;
        let given = Given {
            surface: Some(first),
            ..given
        };
        let lobe = surfaces::lobe(surface(first).phong, mirror, Rgb::BLACK);
        let mut material = Material {
            mirror,
            ..Material::diffuse(format!("surfaces {first}…"), left)
        };
        if !mirror.is_black() {
            let made = self.gloss.cover(&mut material, lobe);
            material.diffuse = left;
            if let Err(message) = made {
                self.warn(place, message);
            }
        }
        let of_rtrace = self.rtrace_material(tree, given, place)?;
        let material = self.push_material(material, of_rtrace);
        let (mut mesh, corners) = shapes::triangles(&data, under(placed), map, material);
        mesh.colors = vec![Rgb::BLACK; mesh.positions.len()];
        for (face, surfaces) in mesh.faces.iter().zip(&corners) {
            for (&vertex, &s) in face.iter().zip(surfaces) {
                let s = &self.surfaces[s as usize];
                mesh.colors[vertex as usize] = limited(s.diffuse * s.color, left);
            }
        }
        self.corner_surfaces = Some(corners);
        Ok(vec![Solid::Mesh(mesh)])
    }

    /// The data of a record, which may stand in a file of their own.
    fn data<'d, T: Clone>(
        &mut self,
        data: &'d Data<T>,
        place: Place,
        read: impl FnOnce(&mut Lines) -> Read<T>,
    ) -> Read<Cow<'d, T>> {
        match data {
            Data::Here(data) => Ok(Cow::Borrowed(data)),
            Data::File(name) => {
                let (path, bytes) = self.open(name, place)?;
                let file = self.sources.next();
                let mut lines = Lines::new(&bytes, &path, file, self.warnings);
                lines.skip_remarks();
                read(&mut lines).map(Cow::Owned)
            }
        }
    }

    /// The commands of a text block. Its file stays known for messages about its commands.
    fn commands<'d>(
        &mut self,
        data: &'d Data<Vec<TextCommand>>,
        place: Place,
    ) -> Read<Cow<'d, [TextCommand]>> {
        match data {
            Data::Here(commands) => Ok(Cow::Borrowed(commands)),
            Data::File(name) => {
                let (path, bytes) = self.open(name, place)?;
                let file = self.sources.next();
                let commands = block::read(&mut Lines::new(&bytes, &path, file, self.warnings))?;
                self.sources.add(&path, bytes);
                Ok(Cow::Owned(commands))
            }
        }
    }

    fn open(&mut self, name: &str, place: Place) -> Read<(String, Vec<u8>)> {
        let of = self.sources.name(place.file);
        let opened = open_beside(self.files, of, name).map_err(|e| {
            let found = format!("\"{}\", which cannot be read: {e}", shortened(name));
            self.sources.error(place, found, "a file beside the scene")
        })?;
        // Many records may name one file.
        let (path, bytes) = opened;
        self.spend(bytes.len() / 16, place)?;
        Ok((path, into_decoded(bytes)))
    }

    fn no_surface(&self, surface: u32, place: Place) -> ReadError {
        let expected = format!("one of the surfaces, 1 to {}", self.surfaces.len());
        self.sources
            .error(place, format!("surface {surface}"), expected)
    }

    /// The material of a look; equal looks have one.
    fn material(&mut self, tree: &Tree, given: Given, place: Place) -> Read<MaterialId> {
        let surface = given.surface.unwrap_or(0);
        let ior = given.refraction.unwrap_or(1.0).max(1.0);
        let Some(numbers) = (surface as usize).checked_sub(1) else {
            return Err(self.no_surface(surface, place));
        };
        let Some(numbers) = self.surfaces.get(numbers).copied() else {
            return Err(self.no_surface(surface, place));
        };
        let chain = given.textured.map(|node| self.chains.number(tree, node));
        let key = (surface, ior.to_bits(), chain);
        if let Some(&known) = self.looks.get(&key) {
            return Ok(known);
        }
        if surfaces::is_dimmed(&numbers) {
            let said = "a surface that lets less than half of the light through: opaque but for the look of RTRACE";
            self.warn(place, said);
        }
        let of_rtrace = self.rtrace_material(tree, given, place)?;
        let name = format!("surface {surface}");
        let (material, made) = surfaces::material(&numbers, ior, name, &mut self.gloss);
        if let Err(message) = made {
            self.warn(place, message);
        }
        let id = self.push_material(material, of_rtrace);
        self.looks.insert(key, id);
        Ok(id)
    }

    fn push_material(&mut self, material: Material, of_rtrace: RtraceMaterial) -> MaterialId {
        self.rtrace.materials.push(of_rtrace);
        self.scene.add_material(material)
    }

    fn rtrace_material(&mut self, tree: &Tree, given: Given, place: Place) -> Read<RtraceMaterial> {
        let mut material = RtraceMaterial {
            surface: given.surface.unwrap_or(1) - 1,
            ior: given.refraction.unwrap_or(1.0).max(1.0),
            ..RtraceMaterial::default()
        };
        let Some(node) = given.textured.map(|k| &tree.nodes[k]) else {
            return Ok(material);
        };
        // Each is as large as a few vertices.
        let count = node.inline_textures.len() + node.section_textures.len();
        self.spend(4 * count, place)?;
        let mut around = Surroundings {
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
        self.warn(place, "textures: only the look of RTRACE shows them");
        Ok(material)
    }

    /// scn2sff wrote random flags onto surfaces that only textures name.
    fn forgive_translated(&mut self, document: &Document) {
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
                let said =
                    "signs of a surface that only textures name, which scn2sff made: left out";
                self.warnings.add_whole(self.sources.name(0), said);
            }
        }
    }

    /// Lights, and bodies in the place of those that have area; these stand last.
    fn lamps(&mut self, document: &Document) {
        for (k, light) in document.lights.iter().enumerate() {
            let material = self.scene.materials.len() as MaterialId;
            match lights::physical(light, &document.view, material) {
                Lamp::Lights(kinds) => {
                    let lights = kinds.into_iter().map(|kind| lights::named(k + 1, kind));
                    self.scene.lights.extend(lights);
                }
                Lamp::Body(body, radiance) => {
                    self.scene.add_material(lights::shining(k + 1, radiance));
                    let name = format!("light {}", k + 1);
                    let object = Object::new(name, Shape::Primitive(body));
                    self.scene.objects.push(object);
                }
            }
        }
    }

    fn finish(self, document: &Document) -> Scene {
        let mut scene = self.scene;
        scene.background = Some(document.background);
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

/// A colour that, times what is left beside a mirror, is this reflectance or as near as can be.
fn limited(reflectance: Rgb, left: Rgb) -> Rgb {
    let share = |k: usize| {
        let share = reflectance[k] / left[k].max(1e-9);
        share.clamp(0.0, 1.0)
    };
    Rgb::from([0, 1, 2].map(share))
}

fn under<T>(placed: &Placed<T>) -> Under {
    Under {
        origin: placed.origin,
        scale: placed.scale,
    }
}

fn some_faces(mesh: azulejo_scene::Mesh) -> Vec<Solid> {
    match mesh.faces.is_empty() {
        true => Vec::new(),
        false => vec![Solid::Mesh(mesh)],
    }
}

/// Whether a solid has an inside.
fn is_closed(solid: &Solid) -> bool {
    match solid {
        Solid::Primitive(p) => {
            !matches!(p.kind, PrimitiveKind::Tube { .. } | PrimitiveKind::Square)
        }
        Solid::Patch(_) => false,
        Solid::Mesh(mesh) => mesh.is_closed(),
        Solid::Prism(_) | Solid::Shell(_) | Solid::Csg(_) => true,
    }
}

/// The word in an object's name.
fn kind_of(node: &Node, solids: &[Solid]) -> &'static str {
    match &node.kind {
        NodeKind::Csg(..) => "csg",
        NodeKind::Leaf(Geometry::Text(_)) => "text",
        NodeKind::Leaf(Geometry::Patches(_)) => "patches",
        NodeKind::Leaf(_) | NodeKind::List(_) => match solids {
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

/// Everything that tells two lists of textures apart.
type ChainKey = (Vec<u64>, Vec<String>);

/// The textures of objects, equal lists with one number.
#[derive(Default)]
struct Chains {
    /// By the object that has them.
    of_nodes: HashMap<usize, usize>,
    known: HashMap<ChainKey, usize>,
}

impl Chains {
    /// The number of an object's textures.
    fn number(&mut self, tree: &Tree, node: usize) -> usize {
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

fn chain_key(node: &Node) -> ChainKey {
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
