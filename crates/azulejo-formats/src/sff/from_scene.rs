//! Converts a scene to a document, with a font of all extruded figures.

use super::document::*;
use super::lights;
use super::{coons, shapes, textures};
use crate::surface::model::{color, model_of, number, slope};
use azulejo_scene::math::Aabb;
use azulejo_scene::rtrace::{Rtrace, RtraceSource, RtraceTexture};
use azulejo_scene::{
    BicubicPatch, Camera, Faces, Figure, Font, Glyph, LightKind, Material, MaterialId, Mesh,
    Primitive, PrimitiveKind, Prism, Rgb, Scene, Shape, Solid,
};
use glam::{DAffine3, DMat3, DMat4, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Radius of a cone's apex, relative to that of its base: SFF does not allow radius 0.
const POINT: f64 = 1e-6;

/// Height of the flat cones that close a cone.
const FLAT: f64 = 0.001;

/// The document of a scene and the glyphs of its text; `stem` begins the names of the font's files.
pub(super) fn document(scene: &Scene, stem: &str) -> (SffDocument, Font) {
    let rtrace = scene.rtrace.as_deref();
    let mut writer = SffWriter {
        scene,
        rtrace,
        stem,
        document: SffDocument::default(),
        font: Font::default(),
        glyphs: HashMap::new(),
        number: 0,
    };
    match rtrace {
        Some(rtrace) => writer.rtrace_numbers(rtrace),
        None => writer.physical_numbers(),
    }
    for (index, object) in scene.objects.iter().enumerate() {
        writer.object(index, &object.shape);
    }
    (writer.document, writer.font)
}

/// Whether an object represents an RTRACE light.
pub(super) fn is_light_emitter(scene: &Scene, shape: &Shape) -> bool {
    let known = scene.rtrace.as_ref().map(|r| r.materials.len());
    matches!((shape, known), (Shape::Primitive(p), Some(known)) if p.material as usize >= known)
}

struct SffWriter<'s> {
    scene: &'s Scene,
    rtrace: Option<&'s Rtrace>,
    stem: &'s str,
    document: SffDocument,
    font: Font,
    /// Names of figures by their addresses, which prisms share.
    glyphs: HashMap<*const Figure, String>,
    /// The number of objects so far, members included.
    number: u32,
}

impl SffWriter<'_> {
    fn rtrace_numbers(&mut self, rtrace: &Rtrace) {
        let document = &mut self.document;
        document.view = SffView {
            eye: rtrace.eye,
            target: rtrace.look,
            up: rtrace.up,
            angles: rtrace.half_angles.map(degrees),
            place: SffPosition::default(),
        };
        document.background = rtrace.background;
        document.ambient = rtrace.ambient;
        document.lights.clone_from(&rtrace.lights);
        let record = |s: &azulejo_scene::rtrace::RtraceSurface| SurfaceRecord {
            color: s.color,
            is_emitter: s.is_emitter,
            is_unshadowed: s.is_unshadowed,
            source: s.source,
        };
        document.surfaces = rtrace.surfaces.iter().map(record).collect();
    }

    fn physical_numbers(&mut self) {
        let scene = self.scene;
        let view = view(scene);
        let unit = |c: Rgb| c.map(|v| v.clamp(0.0, 1.0));
        let ambient = scene.lights.iter().map(|light| match light.kind {
            LightKind::Ambient { radiance } => radiance,
            _ => Rgb::BLACK,
        });
        self.document.ambient = unit(ambient.sum());
        self.document.background =
            unit(scene.background.and_then(|b| b.color()).unwrap_or_default());
        let lights = scene.lights.iter();
        let lights = lights.filter_map(|light| lights::rtrace_light(&light.kind, &view));
        self.document.lights = lights.collect();
        self.document.surfaces = scene.materials.iter().map(surface).collect();
        self.document.view = view;
    }

    fn object(&mut self, index: usize, shape: &Shape) {
        if is_light_emitter(self.scene, shape) {
            return;
        }
        match shape {
            Shape::Mesh(mesh) => {
                let corners = self
                    .rtrace
                    .and_then(|r| r.corner_surfaces.get(&(index as u32)));
                match corners {
                    Some(surfaces) => self.mixed(mesh, surfaces),
                    None => self.mesh(mesh),
                }
            }
            Shape::Instance(instance) => self.mesh(&instance.to_mesh()),
            Shape::Primitive(p) => self.primitive(p),
            Shape::Exact(exact) => self.solids(&exact.solids),
        }
    }

    /// Adds solids in their order; consecutive prisms or patches of one material form one record.
    fn solids(&mut self, solids: &[Solid]) {
        let together = |a: &Solid, b: &Solid| match (a, b) {
            (Solid::Prism(a), Solid::Prism(b)) => a.material == b.material,
            (Solid::Patch(a), Solid::Patch(b)) => a.material == b.material,
            _ => false,
        };
        for group in solids.chunk_by(together) {
            match &group[0] {
                Solid::Prism(_) => self.text(group),
                Solid::Patch(_) => self.patches(group),
                Solid::Primitive(p) => self.primitive(p),
                Solid::Mesh(mesh) => self.mesh(mesh),
                Solid::Shell(pieces) => {
                    self.push(RecordKind::ListBegin {
                        appearance: RecordAppearance::default(),
                    });
                    self.solids(pieces);
                    self.push(RecordKind::ListEnd);
                }
                Solid::Csg(csg) => {
                    self.push(RecordKind::CsgBegin {
                        appearance: RecordAppearance::default(),
                        operation: csg.operation,
                    });
                    self.solids(&csg.left);
                    self.push(RecordKind::CsgNext);
                    self.solids(&csg.right);
                    self.push(RecordKind::CsgEnd);
                }
            }
        }
    }

    fn push(&mut self, kind: RecordKind) {
        let begins = matches!(
            kind,
            RecordKind::Object { .. } | RecordKind::CsgBegin { .. } | RecordKind::ListBegin { .. }
        );
        self.number += u32::from(begins);
        let place = SffPosition::default();
        self.document.objects.push(SffRecord { place, kind });
    }

    fn transform(&mut self, map: &DAffine3) {
        let matrix = Box::new(DMat4::from(*map));
        self.push(RecordKind::Transform { object: 0, matrix });
    }

    /// Adds a record with a material and its textures.
    fn leaf(&mut self, geometry: SffGeometry, material: MaterialId) {
        let appearance = self.appearance(material);
        self.push(RecordKind::Object {
            appearance,
            geometry,
        });
        let Some(shading) = self.rtrace.and_then(|r| r.materials.get(material as usize)) else {
            return;
        };
        for texture in &shading.inline_textures {
            self.push(RecordKind::Texture(texture_record(texture, 0)));
        }
        for texture in &shading.section_textures {
            let kind = RecordKind::Texture(texture_record(texture, self.number));
            let place = SffPosition::default();
            self.document.textures.push(SffRecord { place, kind });
        }
    }

    fn appearance(&self, material: MaterialId) -> RecordAppearance {
        if let Some(rtrace) = self.rtrace {
            let known = rtrace.materials.get(material as usize);
            return known.map_or(
                RecordAppearance {
                    surface: 1,
                    refraction: 1.0,
                },
                |m| RecordAppearance {
                    surface: m.surface + 1,
                    refraction: m.ior,
                },
            );
        }
        let glass = self.scene.materials[material as usize].dielectric;
        RecordAppearance {
            surface: material + 1,
            refraction: glass.map_or(1.0, |g| g.ior.clamp(1.0, 300.0)),
        }
    }

    fn primitive(&mut self, p: &Primitive) {
        let map = &p.world_from_object;
        let (m, t) = (map.matrix3, map.translation);
        match p.kind {
            PrimitiveKind::Sphere => {
                let radius = m.x_axis.x;
                let same = Primitive::sphere(t, radius, p.material).world_from_object == *map;
                let (centre, radius) = if same {
                    (t, radius)
                } else {
                    (DVec3::ZERO, 1.0)
                };
                self.leaf(SffGeometry::Sphere { centre, radius }, p.material);
                self.transform_unless(same && radius > 0.0, map);
            }
            PrimitiveKind::Cuboid => {
                let half = 0.5 * DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
                let again = shapes::cuboid(t + half, half, 0).world_from_object;
                let same = again == *map && half.min_element() > 0.0;
                let unit = DVec3::splat(0.5);
                let (centre, half) = if same { (t + half, half) } else { (unit, unit) };
                self.leaf(SffGeometry::Cuboid { centre, half }, p.material);
                self.transform_unless(same, map);
            }
            PrimitiveKind::Tube { top } => {
                let (cone, same) = cone(p, top);
                self.leaf(SffGeometry::Cone(cone), p.material);
                self.transform_unless(same, map);
            }
            PrimitiveKind::Cone { top } => self.closed_cone(p, top),
            PrimitiveKind::Cylinder => self.closed_cone(p, 1.0),
            PrimitiveKind::Square => {
                let corners = [t, t + m.x_axis, t + m.x_axis + m.y_axis, t + m.y_axis];
                let mut faces = Faces::default();
                faces.push(&[0, 1, 2, 3]);
                let vertices = corners.to_vec();
                let data = PolygonData { faces, vertices };
                self.leaf(SffGeometry::Polygons(here(data)), p.material);
            }
        }
    }

    fn transform_unless(&mut self, same: bool, map: &DAffine3) {
        if !same {
            self.transform(map);
        }
    }

    /// Adds a list of the lateral surface and of flat cones over its ends.
    fn closed_cone(&mut self, p: &Primitive, top: f64) {
        let (side, same) = cone(p, top);
        self.push(RecordKind::ListBegin {
            appearance: RecordAppearance::default(),
        });
        self.transform_unless(same, &p.world_from_object);
        self.leaf(SffGeometry::Cone(side), p.material);
        let axis = (side.apex - side.base).normalize_or_zero();
        let ends = [
            (side.base, side.base_radius, -axis),
            (side.apex, side.apex_radius, axis),
        ];
        for (base, base_radius, outward) in ends {
            if base_radius <= POINT * side.base_radius {
                continue;
            }
            let cap = SffCone {
                base,
                base_radius,
                apex: base + FLAT.min(0.01 * base_radius) * outward,
                apex_radius: POINT * base_radius,
            };
            self.leaf(SffGeometry::Cone(cap), p.material);
        }
        self.push(RecordKind::ListEnd);
    }

    fn patches(&mut self, group: &[Solid]) {
        let mut data = PatchData::default();
        let mut material = 0;
        let mut others = Vec::new();
        for solid in group {
            let Solid::Patch(patch) = solid else { continue };
            material = patch.material;
            match coons::points(patch) {
                Some(points) => {
                    let start = data.vertices.len() as u32;
                    data.patches.push(std::array::from_fn(|k| start + k as u32));
                    data.vertices.extend(points);
                }
                None => others.push(patch),
            }
        }
        if !data.patches.is_empty() {
            self.leaf(SffGeometry::Patches(here(data)), material);
        }
        if !others.is_empty() {
            let triangles = others.into_iter().flat_map(tessellated).collect();
            self.triangles(triangles, material);
        }
    }

    fn triangles(&mut self, corners: Vec<[(DVec3, DVec3); 3]>, material: MaterialId) {
        let surfaces = Vec::new();
        let data = TriangleData { corners, surfaces };
        self.leaf(SffGeometry::Triangles(here(data)), material);
    }

    /// Adds a mesh as one record per material.
    fn mesh(&mut self, mesh: &Mesh) {
        let mut materials = mesh.face_materials.clone();
        materials.sort_unstable();
        materials.dedup();
        for material in materials {
            let has_material = |f: &usize| mesh.face_materials[*f] == material;
            let faces: Vec<usize> = (0..mesh.faces.len()).filter(has_material).collect();
            match &mesh.normals {
                Some(normals) => {
                    let triangles = faces.iter().flat_map(|&f| fan(mesh, normals, f)).collect();
                    self.triangles(triangles, material);
                }
                None => {
                    let data = polygons(mesh, &faces);
                    self.leaf(SffGeometry::Polygons(here(data)), material);
                }
            }
        }
    }

    /// Adds triangles with surfaces at their corners.
    fn mixed(&mut self, mesh: &Mesh, corner_surfaces: &[[u32; 3]]) {
        let Some(normals) = &mesh.normals else {
            return self.mesh(mesh);
        };
        let faces = 0..mesh.faces.len();
        let data = TriangleData {
            corners: faces.flat_map(|f| fan(mesh, normals, f)).collect(),
            surfaces: corner_surfaces.iter().map(|s| s.map(|s| s + 1)).collect(),
        };
        let material = mesh.face_materials.first().copied().unwrap_or(0);
        let geometry = SffGeometry::Triangles(here(data));
        let start = self.document.objects.len();
        self.leaf(geometry, material);
        if let RecordKind::Object { appearance, .. } = &mut self.document.objects[start].kind {
            appearance.surface = 0;
        }
    }

    /// Adds a text block of prisms, each at its own position.
    fn text(&mut self, group: &[Solid]) {
        let mut commands = vec![
            TextCommandKind::Spacing(0.0),
            TextCommandKind::Font(format!("{}.ppf", self.stem)),
            TextCommandKind::Encoding(format!("{}.ppe", self.stem)),
        ];
        let settings = commands.len();
        let mut set = DMat3::ZERO;
        let mut material = 0;
        for solid in group {
            let Solid::Prism(prism) = solid else { continue };
            material = prism.material;
            let Some(name) = self.glyph(prism) else {
                continue;
            };
            let m = prism.world_from_figure.matrix3;
            if m != set {
                set = m;
                let axes = [m.x_axis, m.y_axis, m.z_axis];
                let scale = DVec3::from(axes.map(DVec3::length));
                commands.push(TextCommandKind::Scale(scale));
                let axes = axes.map(DVec3::normalize_or_zero);
                commands.push(TextCommandKind::Orientation(axes));
            }
            let origin = prism.world_from_figure.translation;
            commands.push(TextCommandKind::At(origin, format!("/{name}/")));
        }
        if commands.len() == settings {
            return;
        }
        let place = SffPosition::default();
        let placed = |kind| TextCommand { place, kind };
        let commands = commands.into_iter().map(placed).collect();
        self.leaf(SffGeometry::Text(RecordData::Here(commands)), material);
    }

    /// The glyph name of a prism's figure; `None` if the figure is empty.
    fn glyph(&mut self, prism: &Prism) -> Option<String> {
        let key = Arc::as_ptr(&prism.figure);
        if let Some(known) = self.glyphs.get(&key) {
            return Some(known.clone());
        }
        let mut figure = Figure::clone(&prism.figure);
        figure.contours.retain(|c| !c.curves.is_empty());
        if figure.contours.is_empty() {
            return None;
        }
        let name = format!("g{}", self.glyphs.len() + 1);
        self.font.glyphs.insert(name.clone(), Glyph::new(figure));
        self.glyphs.insert(key, name.clone());
        Some(name)
    }
}

fn here<T>(data: T) -> Box<PlacedData<T>> {
    Box::new(PlacedData {
        origin: DVec3::ZERO,
        scale: DVec3::ONE,
        data: RecordData::Here(data),
    })
}

/// The record of a cone's lateral surface, and whether it is in its final position; otherwise it is
/// a unit cone that needs a transform.
fn cone(p: &Primitive, top: f64) -> (SffCone, bool) {
    let m = p.world_from_object.matrix3;
    let radius = m.x_axis.length();
    let base = p.world_from_object.translation;
    let placed = SffCone {
        base,
        base_radius: radius,
        apex: base + m.z_axis,
        apex_radius: top.max(POINT) * radius,
    };
    let is_closed = !matches!(p.kind, PrimitiveKind::Tube { .. });
    let again = shapes::cone(&placed, is_closed, p.material);
    if again.world_from_object == p.world_from_object && again.kind == p.kind {
        return (placed, true);
    }
    let unit = SffCone {
        base: DVec3::ZERO,
        base_radius: 1.0,
        apex: DVec3::Z,
        apex_radius: top.max(POINT),
    };
    (unit, false)
}

fn texture_record(texture: &RtraceTexture, object: u32) -> Box<TextureRecord> {
    let (number, values) = textures::numbers(&texture.kind);
    Box::new(TextureRecord {
        place: SffPosition::default(),
        object,
        matrix: texture.matrix,
        kind: TextureKind { number, values },
        file: texture.file.clone(),
    })
}

/// Polygons with the vertices that they use, or with all if they use the last one.
fn polygons(mesh: &Mesh, faces: &[usize]) -> PolygonData {
    let last = mesh.positions.len() as u32;
    let corners = || faces.iter().flat_map(|&f| mesh.faces.get(f));
    let whole = faces.len() == mesh.faces.len() && corners().any(|v| v + 1 == last);
    let mut data = PolygonData::default();
    if whole {
        data.vertices.clone_from(&mesh.positions);
        data.faces.clone_from(&mesh.faces);
        return data;
    }
    let mut numbers = HashMap::new();
    for &face in faces {
        let number = |v: &u32| {
            *numbers.entry(*v).or_insert_with(|| {
                data.vertices.push(mesh.positions[*v as usize]);
                data.vertices.len() as u32 - 1
            })
        };
        let face: Vec<u32> = mesh.faces.get(face).iter().map(number).collect();
        data.faces.push(&face);
    }
    data
}

/// The triangles of a face with their normals.
fn fan(
    mesh: &Mesh,
    normals: &azulejo_scene::Attribute<DVec3>,
    face: usize,
) -> Vec<[(DVec3, DVec3); 3]> {
    let corners = mesh.faces.get(face);
    let start = mesh.faces.corner_range(face).start;
    let corner = |k: usize| {
        let vertex = corners[k];
        (
            mesh.positions[vertex as usize],
            normals.at(start + k, vertex),
        )
    };
    if corners.len() == 3 {
        return vec![[corner(0), corner(1), corner(2)]];
    }
    let triangles = mesh.triangulate(face).into_iter();
    triangles.map(|t| t.map(|k| corner(k as usize))).collect()
}

/// Number of cells along each side of a patch that SFF cannot represent.
const CELLS: u32 = 16;

/// A patch as triangles with its exact normals.
fn tessellated(patch: &BicubicPatch) -> Vec<[(DVec3, DVec3); 3]> {
    let corner = |i: u32, j: u32| {
        let (u, v) = (
            f64::from(i) / f64::from(CELLS),
            f64::from(j) / f64::from(CELLS),
        );
        let (p, du, dv) = patch.at(u, v);
        (p, du.cross(dv).try_normalize().unwrap_or(DVec3::Z))
    };
    let cells = (0..CELLS).flat_map(|j| (0..CELLS).map(move |i| (i, j)));
    let two = |(i, j)| {
        let [a, b, c, d] =
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| corner(i, j));
        [[a, b, c], [a, c, d]]
    };
    cells.flat_map(two).collect()
}

/// A view of a scene: its first camera, or a front view.
fn view(scene: &Scene) -> SffView {
    let framing = || {
        let bounds = if scene.objects.is_empty() {
            Aabb::around([DVec3::ZERO, DVec3::ONE])
        } else {
            scene.bounds()
        };
        Camera::framing(bounds, 1.0, scene.units.up.axis())
    };
    let camera = scene.cameras.first().cloned().unwrap_or_else(framing);
    let vertical = 0.5 * camera.vertical_fov;
    let (width, height) = camera.size.unwrap_or((1, 1));
    let horizontal = (vertical.tan() * f64::from(width) / f64::from(height)).atan();
    SffView {
        eye: camera.eye,
        target: camera.target,
        up: camera.up,
        angles: [horizontal, vertical].map(|a| degrees(a).clamp(0.5, 89.5)),
        place: SffPosition::default(),
    }
}

/// A material as a surface: Kd and Ks are its reflectances, its colour is white or its emission.
fn surface(material: &Material) -> SurfaceRecord {
    if let Some(strauss) = strauss(material) {
        return strauss;
    }
    let glass = material.dielectric;
    let transparency = glass.map_or(Rgb::BLACK, |g| unit(g.transmittance));
    let is_emitter = material.is_emitter();
    SurfaceRecord {
        color: if is_emitter {
            unit(material.emission)
        } else {
            Rgb::WHITE
        },
        is_emitter,
        is_unshadowed: false,
        source: RtraceSource::Phong {
            diffuse: material.diffuse,
            // The reflectance of glass depends on the angle, SFF's share does not.
            specular: if glass.is_some() {
                Rgb::grey(0.05)
            } else {
                specular(material)
            },
            phong: exponent(material),
            metal: 0.0,
            transparency,
        },
    }
}

fn unit(color: Rgb) -> Rgb {
    color.map(|v| v.clamp(0.0, 1.0))
}

/// The specular reflectance of a material, exact or approximate: for a lobe, at normal incidence.
fn specular(material: &Material) -> Rgb {
    let lobe = model_of(material).filter(|m| m.name == "lewis");
    let ks = lobe.and_then(|m| color(m, "ks"));
    ks.unwrap_or_else(|| unit(material.mirror + material.mean_glossy()))
}

/// The exponent of a Phong lobe about as wide as a material's lobe.
fn exponent(material: &Material) -> f64 {
    let Some(model) = model_of(material).filter(|_| material.glossy().is_some()) else {
        return 100.0;
    };
    let exponent = number(model, "n").filter(|_| model.name == "lewis");
    // Angles to the mirrored direction are about twice those to the half vector.
    let near = || 0.25 * (2.0 / slope(model).powi(2) - 2.0);
    exponent.unwrap_or_else(near).clamp(3.0, 300.0)
}

/// A surface of the second type, which uses Strauss' model.
fn strauss(material: &Material) -> Option<SurfaceRecord> {
    let model = model_of(material).filter(|m| m.name == "strauss")?;
    let grey = |name: &str| Rgb::grey(number(model, name).unwrap_or(0.0));
    Some(SurfaceRecord {
        color: color(model, "color")?,
        is_emitter: false,
        is_unshadowed: false,
        source: RtraceSource::Strauss {
            smooth: grey("smoothness"),
            metal: grey("metalness"),
            transparency: grey("transparency"),
        },
    })
}

/// Degrees that convert back to exactly this angle, if there are any within rounding.
pub(super) fn degrees(radians: f64) -> f64 {
    let near = radians.to_degrees();
    let mut around = [near, near.next_up(), near.next_down()].into_iter();
    around.find(|d| d.to_radians() == radians).unwrap_or(near)
}
