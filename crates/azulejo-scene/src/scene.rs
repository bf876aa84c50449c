//! The scene: objects, materials, lights, cameras, units.

use crate::math::Aabb;
use crate::{
    Camera, Irradiance, Light, Material, MaterialId, ObjectIrradiance, Rgb, Rtrace, Shape, Texture,
};
use glam::DVec3;

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
    /// What a viewer sees where there is no surface. It gives no light: see
    /// [`LightKind::Ambient`](crate::LightKind::Ambient) for surroundings that do.
    pub background: Option<Rgb>,
    /// What hides far surfaces from a viewer. It takes no light away from surfaces.
    pub fog: Option<Fog>,
    /// What the numbers mean.
    pub units: Units,
    /// The numbers of an SFF or SCN scene that only RTRACE's own shading reads.
    pub rtrace: Option<Box<Rtrace>>,
}

/// Fog, as VRML has it: a colour that surfaces fade into with their distance from the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fog {
    /// Radiance of what is far away, W/(sr·m²).
    pub color: Rgb,
    /// Distance at which nothing is seen any more, scene units, > 0.
    pub visibility: f64,
    /// Whether surfaces fade exponentially, as in real fog, and not linearly.
    pub exponential: bool,
}

impl Fog {
    /// Share of a surface's light that comes through from `distance` away, 0..=1.
    ///
    /// ISO/IEC 14772-1:1997, 6.19, table 6.2: (V − d)/V, or e^(−d/(V − d)).
    pub fn transmittance(&self, distance: f64) -> f64 {
        let left = self.visibility - distance;
        match (left > 0.0, self.exponential) {
            (false, _) => 0.0,
            (true, true) => (-distance / left).exp(),
            (true, false) => left / self.visibility,
        }
    }
}

/// A named shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Name in the file, need not be unique. Where a file nests its objects, the path through
    /// its named groups: `house/kitchen/table`.
    pub name: String,
    /// Its geometry, placed in the world.
    pub shape: Shape,
}

/// What a scene's numbers mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Units {
    /// Length of one scene unit in metres, > 0; `None` when nobody says. One metre is assumed
    /// then.
    pub metres_per_unit: Option<f64>,
    /// The axis that points away from the ground.
    pub up: Up,
    /// Whether light is in cd/m² and lux instead of W/(sr·m²) and W/m². azulejo computes alike.
    pub photometric: bool,
}

/// The axis that points away from the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// As in most formats for pictures.
    #[default]
    Y,
    /// As in most formats for building and making.
    Z,
}

impl Up {
    /// The unit vector.
    pub fn axis(self) -> DVec3 {
        match self {
            Up::Y => DVec3::Y,
            Up::Z => DVec3::Z,
        }
    }
}

impl Units {
    /// Length of one scene unit in metres; 1 when nobody says.
    pub fn metres(&self) -> f64 {
        self.metres_per_unit.unwrap_or(1.0)
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
            Shape::Exact(exact) => exact.bounds(),
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
            Shape::Exact(exact) => exact.leaves().iter().any(|l| shines(l.material())),
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
            Shape::Exact(exact) => exact.skin.is_some(),
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
                (Shape::Exact(exact), ObjectIrradiance::Refined(skin)) => exact.skin = Some(skin),
                _ => panic!("irradiance of another kind of shape"),
            }
        }
    }

    /// Appends another scene's content: the paper's "add" as against "new".
    ///
    /// Nothing is converted ([`Scene::adapted`] does that before); units, background and fog
    /// of this scene stay, and if it has no background or fog, the other's are taken. RTRACE's
    /// numbers are kept only where one of the two scenes is empty.
    pub fn merge(&mut self, other: Scene) {
        if self.objects.is_empty() && self.materials.is_empty() {
            self.rtrace = other.rtrace;
        } else if !other.objects.is_empty() {
            self.rtrace = None;
        }
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
                Shape::Exact(exact) => exact.map_materials(&mut |m| m + materials),
            }
            o
        }));
        self.lights.extend(other.lights);
        self.cameras.extend(other.cameras);
        self.background = self.background.or(other.background);
        self.fog = self.fog.or(other.fog);
    }
}
