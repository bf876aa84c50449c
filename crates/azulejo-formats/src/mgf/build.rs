//! The scene under construction: named groups, each with a mesh of the faces directly inside it.

use super::sharing::{FrameId, RepeatedOrigin, WORLD};
use crate::surface::gloss::Gloss;
use crate::surface::materials::Materials;
use crate::surface::repeated::RepeatedMeshes;
use azulejo_scene::math::area_vector;
use azulejo_scene::{
    Attribute, Light, Material, MaterialId, Mesh, Object, Primitive, Scene, Shape, Units, Up,
};
use glam::DVec3;
use std::collections::HashMap;

/// Longest name of an object; objects nested more deeply share a name.
const LONGEST_NAME: usize = 255;

/// A corner of a face, in the coordinates of its group's mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct MgfCorner {
    /// Corners with different keys must not share a vertex of the mesh: the revision of the file's
    /// vertex, and the serial number of the current transform.
    pub key: (u64, u64),
    pub position: DVec3,
    /// Unit shading normal.
    pub normal: Option<DVec3>,
}

/// A scene under construction.
#[derive(Debug)]
pub(super) struct MgfBuilder {
    scene: Scene,
    materials: Materials,
    pub gloss: Gloss,
    repeated: RepeatedMeshes,
    path: String,
    groups: Vec<MgfObject>,
    /// Whether objects and lights are kept.
    keeps: bool,
}

/// An open group.
#[derive(Debug, Default)]
struct MgfObject {
    /// Length of the path outside of the group.
    path_length: usize,
    /// The coordinates in which its mesh is built.
    frame: FrameId,
    /// Its faces, and the index of the object reserved for them.
    draft: Option<Box<(usize, ObjectFaces)>>,
}

impl MgfBuilder {
    /// An empty scene and its outermost group.
    pub fn new(keeps: bool) -> MgfBuilder {
        MgfBuilder {
            scene: Scene {
                units: Units {
                    metres_per_unit: Some(1.0),
                    up: Up::Z,
                    photometric: true,
                },
                ..Scene::default()
            },
            materials: Materials::default(),
            gloss: Gloss::default(),
            repeated: RepeatedMeshes::default(),
            path: String::new(),
            groups: vec![MgfObject::default()],
            keeps,
        }
    }

    /// Whether a face would begin an object.
    pub fn begins_object(&self) -> bool {
        self.groups.last().is_none_or(|group| group.draft.is_none())
    }

    /// The coordinates of the innermost group's mesh.
    pub fn group_frame(&self) -> FrameId {
        self.groups.last().map_or(WORLD, |group| group.frame)
    }

    /// Whether there are no objects and no lights yet.
    pub fn is_empty(&self) -> bool {
        self.scene.objects.is_empty() && self.scene.lights.is_empty()
    }

    /// Index of a material.
    pub fn material(&mut self, material: Material) -> MaterialId {
        self.materials.index(material)
    }

    /// Opens a group; an empty name adds nothing to the path.
    pub fn open(&mut self, name: &str, frame: FrameId) {
        self.groups.push(MgfObject {
            path_length: self.path.len(),
            frame,
            draft: None,
        });
        if !name.is_empty() && self.path.len() + name.len() < LONGEST_NAME {
            if !self.path.is_empty() {
                self.path.push('/');
            }
            self.path.push_str(name);
        }
    }

    /// Closes the innermost group.
    pub fn close(&mut self) {
        if let Some(group) = self.groups.pop() {
            self.path.truncate(group.path_length);
            self.place(group.draft);
        }
    }

    /// Stores a group's faces in the object reserved for them.
    fn place(&mut self, draft: Option<Box<(usize, ObjectFaces)>>) {
        if let Some((object, draft)) = draft.map(|d| *d) {
            let origin = draft.origin;
            let mut mesh = draft.finish();
            self.suppress_inner_emission(&mut mesh);
            self.scene.objects[object].shape = self.shape_of(mesh, origin);
        }
    }

    /// A mesh as a shape: one that others may share, if arrays or includes repeat it.
    fn shape_of(&mut self, mesh: Mesh, origin: Option<RepeatedOrigin>) -> Shape {
        match origin {
            Some(origin) => self
                .repeated
                .place(mesh, origin.statement, &origin.world_from_frame),
            None => Shape::Mesh(mesh),
        }
    }

    /// Two-sided emitters that enclose a volume emit outwards only: their inward emission is never
    /// visible and would count as power.
    fn suppress_inner_emission(&mut self, mesh: &mut Mesh) {
        let shines_in = |m: &MaterialId| self.materials.get(*m).emits_back;
        let is_lamp: Vec<bool> = mesh.face_materials.iter().map(shines_in).collect();
        if !is_lamp.contains(&true) || !encloses(mesh, &is_lamp) {
            return;
        }
        for (material, _) in mesh.face_materials.iter_mut().zip(is_lamp).filter(|f| f.1) {
            let outward = Material {
                emits_back: false,
                ..self.materials.get(*material).clone()
            };
            *material = self.materials.index(outward);
        }
    }

    /// Adds a face of three or more corners to the innermost group. `origin` is that of its mesh if the
    /// face is the first.
    pub fn face(
        &mut self,
        corners: &[MgfCorner],
        material: MaterialId,
        origin: Option<RepeatedOrigin>,
    ) {
        if !self.keeps {
            return;
        }
        let group = self.groups.last_mut().expect("the outermost group is open");
        let announced = group.draft.get_or_insert_with(|| {
            // Objects are ordered by their first faces, even if groups nest.
            let object = Object::new(self.path.clone(), Shape::Mesh(Mesh::default()));
            self.scene.objects.push(object);
            let faces = ObjectFaces {
                origin,
                ..ObjectFaces::default()
            };
            Box::new((self.scene.objects.len() - 1, faces))
        });
        announced.1.face(corners, material);
    }

    /// Adds a mesh with one material as an object of its own; the material in the mesh is ignored.
    pub fn solid(&mut self, mut mesh: Mesh, material: MaterialId, origin: Option<RepeatedOrigin>) {
        if !self.keeps {
            return;
        }
        mesh.face_materials.fill(material);
        let shape = self.shape_of(mesh, origin);
        self.shape(shape);
    }

    /// Adds an exact primitive as an object of its own.
    pub fn primitive(&mut self, primitive: Primitive) {
        self.shape(Shape::Primitive(primitive));
    }

    fn shape(&mut self, shape: Shape) {
        if self.keeps {
            let object = Object::new(self.path.clone(), shape);
            self.scene.objects.push(object);
        }
    }

    /// Adds a light without area, named after the path.
    pub fn light(&mut self, kind: azulejo_scene::LightKind) {
        if self.keeps {
            let name = self.path.clone();
            self.scene.lights.push(Light { name, kind });
        }
    }

    /// The scene, after closing every group.
    pub fn finish(mut self) -> Scene {
        while !self.groups.is_empty() {
            self.close();
        }
        drop(self.repeated);
        self.scene.unfold_single_instances();
        self.scene.materials = self.materials.into_list();
        self.scene
    }
}

/// The faces of a group.
#[derive(Debug, Default)]
struct ObjectFaces {
    /// Where they come from, if they may be repeated.
    origin: Option<RepeatedOrigin>,
    mesh: Mesh,
    known: HashMap<(u64, u64), u32>,
    /// Shading normal of each vertex that has one.
    normals: Vec<Option<DVec3>>,
    /// How each face is shaded.
    shading: Vec<FaceShading>,
}

/// How a face is shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FaceShading {
    /// With its geometric normal.
    Flat,
    /// With its vertex normals.
    Smooth,
    /// With the opposite vertex normals, which point to the back.
    Turned,
}

impl ObjectFaces {
    fn face(&mut self, corners: &[MgfCorner], material: MaterialId) {
        let indices: Vec<u32> = corners.iter().map(|c| self.vertex(c)).collect();
        self.mesh.push_face(&indices, material);
        self.shading.push(shading(corners));
    }

    fn vertex(&mut self, corner: &MgfCorner) -> u32 {
        *self.known.entry(corner.key).or_insert_with(|| {
            self.mesh.positions.push(corner.position);
            self.normals.push(corner.normal);
            (self.normals.len() - 1) as u32
        })
    }

    fn finish(self) -> Mesh {
        let mut mesh = self.mesh;
        let all = |shading| self.shading.iter().all(|&s| s == shading);
        mesh.normals = if all(FaceShading::Flat) {
            None
        } else if all(FaceShading::Smooth) {
            // Every vertex belongs to a face, and every corner of a smooth face has a normal.
            let normals = self.normals.iter().map(|n| n.unwrap_or(DVec3::Z));
            Some(Attribute::per_vertex(normals.collect()))
        } else {
            Some(corner_normals(&mesh, &self.normals, &self.shading))
        };
        mesh
    }
}

/// A face is smooth if all its corners have normals; these must end up on its front.
fn shading(corners: &[MgfCorner]) -> FaceShading {
    let outline: Vec<DVec3> = corners.iter().map(|c| c.position).collect();
    let front = area_vector(&outline);
    let mut behind = true;
    for corner in corners {
        let Some(normal) = corner.normal else {
            return FaceShading::Flat;
        };
        behind &= normal.dot(front) < 0.0;
    }
    if behind {
        FaceShading::Turned
    } else {
        FaceShading::Smooth
    }
}

/// Whether the flagged faces are the closed surface of a body, seen from outside: each edge is used
/// equally often in both directions, and the body has a positive volume.
fn encloses(mesh: &Mesh, faces: &[bool]) -> bool {
    let mut walks: HashMap<(u32, u32), i64> = HashMap::new();
    let (mut volume, mut area) = (0.0, 0.0);
    let origin = mesh.bounds().centre();
    for face in (0..mesh.faces.len()).filter(|&f| faces[f]) {
        let polygon = mesh.faces.get(face);
        for (k, &a) in polygon.iter().enumerate() {
            let b = polygon[(k + 1) % polygon.len()];
            let edge = (a.min(b), a.max(b));
            *walks.entry(edge).or_default() += i64::from(b > a) - i64::from(a > b);
        }
        let front = mesh.face_area_vector(face);
        volume += front.dot(mesh.positions[polygon[0] as usize] - origin) / 3.0;
        area += front.length();
    }
    // A two-sided sheet made of two faces has no volume beyond rounding.
    walks.values().all(|&net| net == 0) && volume > 1e-9 * area.powf(1.5)
}

/// Normals for a mesh whose faces are shaded differently.
fn corner_normals(
    mesh: &Mesh,
    normals: &[Option<DVec3>],
    shading: &[FaceShading],
) -> Attribute<DVec3> {
    let mut attribute = Attribute {
        values: Vec::new(),
        corners: Some(Vec::with_capacity(mesh.faces.corners.len())),
    };
    let mut known: HashMap<(u32, bool), u32> = HashMap::new();
    let Attribute { values, corners } = &mut attribute;
    let corners = corners.get_or_insert_default();
    for (face, &shading) in shading.iter().enumerate() {
        let polygon = mesh.faces.get(face);
        if shading == FaceShading::Flat {
            let flat = mesh.face_area_vector(face).try_normalize();
            values.push(flat.unwrap_or(DVec3::Z));
            corners.extend(vec![(values.len() - 1) as u32; polygon.len()]);
            continue;
        }
        let turned = shading == FaceShading::Turned;
        corners.extend(polygon.iter().map(|&v| {
            *known.entry((v, turned)).or_insert_with(|| {
                let normal = normals[v as usize].unwrap_or(DVec3::Z);
                values.push(if turned { -normal } else { normal });
                (values.len() - 1) as u32
            })
        }));
    }
    attribute
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::Rgb;

    fn corner(key: u64, x: f64, y: f64, normal: Option<DVec3>) -> MgfCorner {
        MgfCorner {
            key: (key, 0),
            position: DVec3::new(x, y, 0.0),
            normal,
        }
    }

    fn triangle(first: u64, normal: Option<DVec3>) -> [MgfCorner; 3] {
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
            .map(|(x, y)| corner(first + x as u64 + 2 * y as u64, x, y, normal))
    }

    fn meshes(faces: &[[MgfCorner; 3]]) -> Mesh {
        let mut builder = MgfBuilder::new(true);
        let grey = builder.material(Material::diffuse("", Rgb::grey(0.5)));
        for face in faces {
            builder.face(face, grey, None);
        }
        let mut scene = builder.finish();
        scene.validate().unwrap();
        match scene.objects.remove(0).shape {
            Shape::Mesh(mesh) => mesh,
            _ => unreachable!("faces make meshes"),
        }
    }

    #[test]
    fn vertices_are_shared_by_key() {
        let mesh = meshes(&[triangle(0, None), triangle(0, None), triangle(9, None)]);
        assert_eq!((mesh.positions.len(), mesh.faces.len()), (6, 3));
        assert_eq!(mesh.normals, None);
    }

    #[test]
    fn normals_belong_to_vertices_where_they_can() {
        let up = Some(DVec3::Z);
        let mesh = meshes(&[triangle(0, up), triangle(9, up)]);
        assert_eq!(mesh.normals, Some(Attribute::per_vertex(vec![DVec3::Z; 6])));
        let mesh = meshes(&[
            triangle(0, up),
            triangle(9, None),
            triangle(20, Some(-DVec3::Z)),
        ]);
        let normals = mesh.normals.unwrap();
        assert_eq!(normals.corners.unwrap(), [0, 1, 2, 3, 3, 3, 4, 5, 6]);
        assert_eq!(normals.values, [DVec3::Z; 7]);
    }

    #[test]
    fn lamps_that_enclose_a_body_shine_outward() {
        let check = |faces: &[[u64; 3]], expected: bool| {
            let mut builder = MgfBuilder::new(true);
            let lamp = Material {
                emits_back: true,
                ..Material::emitter("", Rgb::WHITE)
            };
            let lamp = builder.material(lamp);
            for face in faces {
                let corners = face.map(|k| MgfCorner {
                    key: (k, 0),
                    position: [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z][k as usize],
                    normal: None,
                });
                builder.face(&corners, lamp, None);
            }
            let scene = builder.finish();
            let Shape::Mesh(mesh) = &scene.objects[0].shape else {
                panic!("a mesh")
            };
            for &material in &mesh.face_materials {
                assert_eq!(scene.materials[material as usize].emits_back, expected);
            }
        };
        check(&[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], false);
        // Inside out, open, and a sheet with two sides.
        check(&[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], true);
        check(&[[0, 2, 1], [0, 1, 3], [0, 3, 2]], true);
        check(&[[0, 2, 1], [0, 1, 2]], true);
    }

    #[test]
    fn groups_nest_and_keep_their_order() {
        let mut builder = MgfBuilder::new(true);
        let grey = builder.material(Material::diffuse("", Rgb::grey(0.5)));
        builder.open("house", WORLD);
        builder.face(&triangle(0, None), grey, None);
        builder.open("", WORLD);
        builder.open("room", WORLD);
        builder.face(&triangle(0, None), grey, None);
        builder.close();
        builder.close();
        builder.face(&triangle(3, None), grey, None);
        builder.open(&"long".repeat(100), WORLD);
        builder.primitive(Primitive::sphere(DVec3::ZERO, 1.0, grey));
        let scene = builder.finish();
        let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
        assert_eq!(names, ["house", "house/room", "house"]);
        let Shape::Mesh(mesh) = &scene.objects[0].shape else {
            panic!("a mesh")
        };
        assert_eq!(mesh.faces.len(), 2);
    }
}
