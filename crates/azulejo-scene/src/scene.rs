//! The scene: objects, materials, lights, cameras, units.

use crate::math::Aabb;
use crate::{Camera, Irradiance, Light, Material, MaterialId, ObjectIrradiance, Shape, Texture};

/// Everything that is there, as plain data. [`Scene::validate`] says what may be assumed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// What has a surface, lamps with area included.
    pub objects: Vec<Object>,
    /// What objects refer to by [`MaterialId`].
    pub materials: Vec<Material>,
    /// What materials refer to by [`TextureId`](crate::TextureId).
    pub textures: Vec<Texture>,
    /// Lights without area.
    pub lights: Vec<Light>,
    /// Viewpoints that the file brings.
    pub cameras: Vec<Camera>,
    /// What the numbers mean.
    pub units: Units,
}

/// A named shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Name in the file; may be empty, need not be unique.
    pub name: String,
    /// Its geometry, placed in the world.
    pub shape: Shape,
}

/// What a scene's numbers mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Length of one scene unit in metres, > 0.
    pub metres_per_unit: f64,
    /// Whether light is in cd/m² and lux instead of W/(sr·m²) and W/m². azulejo computes alike.
    pub photometric: bool,
}

impl Default for Units {
    fn default() -> Units {
        Units {
            metres_per_unit: 1.0,
            photometric: false,
        }
    }
}

impl Object {
    /// A named shape.
    pub fn new(name: impl Into<String>, shape: Shape) -> Object {
        Object {
            name: name.into(),
            shape,
        }
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Aabb {
        match &self.shape {
            Shape::Mesh(mesh) => mesh.bounds(),
            Shape::Primitive(primitive) => primitive.bounds(),
        }
    }
}

impl Scene {
    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        (self.materials.len() - 1) as MaterialId
    }

    /// The smallest box around all objects.
    pub fn bounds(&self) -> Aabb {
        self.objects
            .iter()
            .fold(Aabb::EMPTY, |b, o| b.union(o.bounds()))
    }

    /// Whether anything shines: an emitting surface, or a light that is not black.
    pub fn has_light(&self) -> bool {
        use crate::LightKind::*;
        let shines = |m: MaterialId| {
            self.materials
                .get(m as usize)
                .is_some_and(Material::is_emitter)
        };
        let lamp = |o: &Object| match &o.shape {
            Shape::Mesh(mesh) => mesh.face_materials.iter().any(|&m| shines(m)),
            Shape::Primitive(p) => shines(p.material),
        };
        let light = |l: &Light| match l.kind {
            Point { intensity, .. } | Spot { intensity, .. } => !intensity.is_black(),
            Directional { irradiance, .. } => !irradiance.is_black(),
            Ambient { radiance } => !radiance.is_black(),
        };
        self.objects.iter().any(lamp) || self.lights.iter().any(light)
    }

    /// Whether every surface that can show irradiance carries it.
    pub fn is_solved(&self) -> bool {
        let solved = |o: &Object| match &o.shape {
            Shape::Mesh(mesh) => {
                mesh.faces.is_empty() || mesh.irradiance.len() == mesh.positions.len()
            }
            Shape::Primitive(p) => p.light.is_some(),
        };
        !self.objects.is_empty() && self.objects.iter().all(solved)
    }

    /// Writes what the first pass found onto the objects.
    ///
    /// # Panics
    /// If `irradiance` was solved for another scene (object count or vertex count differ).
    pub fn set_irradiance(&mut self, irradiance: Irradiance) {
        assert_eq!(
            irradiance.objects.len(),
            self.objects.len(),
            "irradiance of another scene"
        );
        for (object, light) in self.objects.iter_mut().zip(irradiance.objects) {
            match (&mut object.shape, light) {
                (Shape::Mesh(mesh), ObjectIrradiance::Refined(refined)) => *mesh = *refined,
                (Shape::Mesh(mesh), ObjectIrradiance::Vertices { irradiance, error }) => {
                    assert_eq!(
                        irradiance.len(),
                        mesh.positions.len(),
                        "irradiance of another mesh"
                    );
                    mesh.irradiance = irradiance;
                    mesh.irradiance_error = error;
                }
                (Shape::Primitive(p), ObjectIrradiance::Surface(light)) => p.light = Some(light),
                _ => panic!("irradiance of another kind of shape"),
            }
        }
    }

    /// Appends another scene's content: the paper's "add" as against "new".
    ///
    /// Lengths are not converted; the first scene's units stay.
    pub fn merge(&mut self, other: Scene) {
        let (materials, textures) = (self.materials.len() as u32, self.textures.len() as u32);
        self.textures.extend(other.textures);
        self.materials
            .extend(other.materials.into_iter().map(|mut m| {
                m.textures.iter_mut().for_each(|t| *t += textures);
                m
            }));
        self.objects.extend(other.objects.into_iter().map(|mut o| {
            match &mut o.shape {
                Shape::Mesh(mesh) => mesh.face_materials.iter_mut().for_each(|m| *m += materials),
                Shape::Primitive(p) => p.material += materials,
            }
            o
        }));
        self.lights.extend(other.lights);
        self.cameras.extend(other.cameras);
    }
}
