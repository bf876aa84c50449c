//! The scene: objects, materials, lights, cameras.

use crate::math::Aabb;
use crate::{
    Backplate, Camera, Environment, Irradiance, Light, LightKind, Material, MaterialId, Mesh,
    ObjectIrradiance, Rgb, Rtrace, Shape, Texture, TextureId, Units, VertexLight,
};
use std::sync::Arc;

/// A scene as plain data. [`Scene::validate`] documents and checks its invariants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Objects with a surface, area lights included.
    pub objects: Vec<Object>,
    /// Materials, to which objects refer by [`MaterialId`].
    pub materials: Vec<Material>,
    /// Textures, to which materials refer by [`TextureId`](crate::TextureId).
    pub textures: Vec<Texture>,
    /// Lights without area.
    pub lights: Vec<Light>,
    /// Cameras defined by the file.
    pub cameras: Vec<Camera>,
    /// What a camera sees where there is no surface. It does not illuminate the scene: see
    /// [`LightKind::Ambient`](crate::LightKind::Ambient) and
    /// [`LightKind::Environment`](crate::LightKind::Environment) for surroundings that do.
    pub background: Option<SceneBackground>,
    /// Fog between the camera and surfaces. It does not attenuate the light that surfaces receive.
    pub fog: Option<Fog>,
    /// Length unit, up axis and photometric unit.
    pub units: Units,
    /// Parameters of an SFF or SCN scene that only RTRACE's own shading uses.
    pub rtrace: Option<Box<Rtrace>>,
}

/// What a camera sees where there is no surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SceneBackground {
    /// The same radiance everywhere, W/(sr·m²).
    Color(Rgb),
    /// A radiance by direction.
    Environment(Environment),
    /// A picture that is fixed to the image.
    Backplate(Backplate),
}

impl SceneBackground {
    /// Its radiance, if it is the same everywhere.
    pub fn color(&self) -> Option<Rgb> {
        match *self {
            SceneBackground::Color(color) => Some(color),
            SceneBackground::Environment(_) | SceneBackground::Backplate(_) => None,
        }
    }

    /// The picture that it shows, if any.
    pub fn texture(&self) -> Option<TextureId> {
        match self {
            SceneBackground::Color(_) => None,
            SceneBackground::Environment(environment) => environment.texture(),
            SceneBackground::Backplate(plate) => Some(plate.texture),
        }
    }

    /// The same, with its texture numbered anew, if it shows one.
    #[must_use]
    pub fn with_texture(self, number: impl Fn(TextureId) -> TextureId) -> SceneBackground {
        match self {
            SceneBackground::Environment(environment) => {
                SceneBackground::Environment(environment.with_texture(number))
            }
            SceneBackground::Backplate(plate) => SceneBackground::Backplate(Backplate {
                texture: number(plate.texture),
                ..plate
            }),
            color @ SceneBackground::Color(_) => color,
        }
    }
}

impl From<Rgb> for SceneBackground {
    fn from(color: Rgb) -> SceneBackground {
        SceneBackground::Color(color)
    }
}

/// Fog, as VRML has it: a colour that surfaces fade into with their distance from the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fog {
    /// Radiance of the fog where it hides everything, W/(sr·m²).
    pub color: Rgb,
    /// Distance at which nothing is visible any more, scene units, > 0.
    pub visibility: f64,
    /// Whether surfaces fade exponentially, as in real fog, and not linearly.
    pub exponential: bool,
}

impl Fog {
    /// Fraction of a surface's radiance that is transmitted over `distance`, 0..=1.
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
    /// The enclosure that its surface belongs to, if the file says so; objects of one share it.
    pub zone: Option<Arc<Zone>>,
}

/// A zone of a building: surfaces that exchange thermal radiation with each other alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Zone {
    /// Name in the file.
    pub name: String,
    /// Surfaces without a place, such as furniture: the name and the area of each, in square metres.
    pub masses: Vec<(String, f64)>,
}

impl Object {
    /// A named shape.
    pub fn new(name: impl Into<String>, shape: Shape) -> Object {
        Object {
            name: name.into(),
            shape,
            zone: None,
        }
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Aabb {
        self.shape.bounds()
    }
}

/// Size of an object that may be left out of [`Scene::main_bounds`], relative to that of the scene.
const TINY: f64 = 0.04;

/// Most size of what remains, relative to that of the scene.
const MAIN: f64 = 0.6;

impl Scene {
    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: Material) -> MaterialId {
        self.materials.push(material);
        (self.materials.len() - 1) as MaterialId
    }

    /// The names of the zones of its objects, in the order of first appearance.
    pub fn zones(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for zone in self.objects.iter().filter_map(|o| o.zone.as_ref()) {
            if !names.contains(&&*zone.name) {
                names.push(&zone.name);
            }
        }
        names
    }

    /// The scene with the objects of one zone alone.
    #[must_use]
    pub fn of_zone(&self, name: &str) -> Scene {
        let is_in = |o: &&Object| o.zone.as_ref().is_some_and(|zone| zone.name == name);
        Scene {
            objects: self.objects.iter().filter(is_in).cloned().collect(),
            ..self.clone()
        }
    }

    /// The smallest box around all objects.
    pub fn bounds(&self) -> Aabb {
        self.objects
            .iter()
            .fold(Aabb::EMPTY, |b, o| b.union(o.bounds()))
    }

    /// The smallest box around what a picture of the whole should show: without objects that are tiny and so far away
    /// that everything else would be small, such as parts that were forgotten beside a model.
    pub fn main_bounds(&self) -> Aabb {
        let all = self.bounds();
        let boxes = self.objects.iter().map(Object::bounds);
        let is_large = |b: &Aabb| b.diagonal() > TINY * all.diagonal();
        let main = boxes.filter(is_large).fold(Aabb::EMPTY, Aabb::union);
        if !main.is_empty() && main.diagonal() < MAIN * all.diagonal() {
            main
        } else {
            all
        }
    }

    /// All environments: those that give light, and that of the background.
    pub fn environments(&self) -> impl Iterator<Item = &Environment> {
        let lights = self.lights.iter().filter_map(|light| match &light.kind {
            LightKind::Environment(environment) => Some(environment),
            _ => None,
        });
        let background = match &self.background {
            Some(SceneBackground::Environment(environment)) => Some(environment),
            _ => None,
        };
        lights.chain(background)
    }

    /// The pictures around the scene: of environments and of the background. One may come twice.
    pub fn surrounding_pictures(&self) -> impl Iterator<Item = TextureId> {
        let plate = match &self.background {
            Some(SceneBackground::Backplate(plate)) => Some(plate.texture),
            _ => None,
        };
        self.environments()
            .filter_map(Environment::texture)
            .chain(plate)
    }

    /// Emitted radiance of the front of each material, W/(sr·m²): times the mean of the picture, where
    /// there is one. For those who need no more, and for surfaces without texture coordinates.
    pub fn mean_emissions(&self) -> Vec<Rgb> {
        let mean = |material: &Material| match material.emission_picture {
            Some(_) if !material.is_emitter() => Rgb::BLACK,
            Some(id) => {
                let texture = self.textures.get(id as usize);
                material.emission * texture.map_or(Rgb::BLACK, Texture::mean)
            }
            None => material.emission,
        };
        self.materials.iter().map(mean).collect()
    }

    /// The scene with the mean of each picture of emission in its place, for formats without such pictures;
    /// `None` if it has none.
    pub fn with_even_emission(&self) -> Option<Scene> {
        if self.materials.iter().all(|m| m.emission_picture.is_none()) {
            return None;
        }
        let mut even = self.clone();
        for (material, mean) in even.materials.iter_mut().zip(self.mean_emissions()) {
            material.emission = mean;
            material.emission_picture = None;
        }
        Some(even)
    }

    /// Whether there is a light source: an emitting surface, or a light that is not black.
    pub fn has_light(&self) -> bool {
        let shines = |m: MaterialId| {
            self.materials
                .get(m as usize)
                .is_some_and(Material::is_emitter)
        };
        let any_shines = |mesh: &Mesh| mesh.face_materials.iter().any(|&m| shines(m));
        if self.shared_meshes().into_iter().any(|m| any_shines(m)) {
            return true;
        }
        let lamp = |o: &Object| match &o.shape {
            Shape::Mesh(mesh) => any_shines(mesh),
            Shape::Instance(_) => false,
            Shape::Primitive(p) => shines(p.material),
            Shape::Exact(exact) => exact.leaves().iter().any(|l| shines(l.material())),
        };
        let light = |l: &Light| !l.kind.strength().is_black();
        self.objects.iter().any(lamp) || self.lights.iter().any(light)
    }

    /// Whether every surface that can show irradiance carries it. A scene with a lightmap is solved, too: it may
    /// lack the lamps whose light that holds, so that the first pass would find less. What has no lightmap there
    /// gets light from what has one.
    pub fn is_solved(&self) -> bool {
        if self.has_lightmap() {
            return true;
        }
        let solved = |o: &Object| match &o.shape {
            Shape::Mesh(mesh) => {
                mesh.faces.is_empty() || mesh.irradiance.len() == mesh.positions.len()
            }
            Shape::Instance(i) => i.mesh.faces.is_empty() || i.light.is_some(),
            Shape::Primitive(p) => p.light.is_some() || self.reflects_nothing(p.material),
            Shape::Exact(exact) => exact.proxy.is_some(),
        };
        !self.objects.is_empty() && self.objects.iter().all(solved)
    }

    /// Whether a material has no reflection that irradiance could describe, as a lamp's.
    fn reflects_nothing(&self, material: MaterialId) -> bool {
        let known = self.materials.get(material as usize);
        known.is_some_and(|m| m.diffuse.is_black() && m.brdf.is_none() && m.is_emitter())
    }

    /// Stores the irradiance that the first pass computed in the objects.
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
            store_irradiance(&mut object.shape, light);
        }
    }

    /// Appends another scene's content.
    ///
    /// Nothing is converted ([`Scene::adapted`] does that before); units, background and fog
    /// of this scene stay, and if it has no background or fog, the other's are taken. RTRACE's
    /// parameters are kept only if one of the two scenes is empty.
    pub fn merge(&mut self, mut other: Scene) {
        let (materials, textures) = (self.materials.len() as u32, self.textures.len() as u32);
        let renumber =
            |mesh: &mut Mesh| mesh.face_materials.iter_mut().for_each(|m| *m += materials);
        if materials > 0 {
            other.change_shared_meshes(renumber);
        }
        if self.objects.is_empty() && self.materials.is_empty() {
            self.rtrace = other.rtrace;
        } else if !other.objects.is_empty() {
            self.rtrace = None;
        }
        self.textures.extend(other.textures);
        self.materials
            .extend(other.materials.into_iter().map(|mut m| {
                m.renumber_pictures(textures);
                m
            }));
        self.objects.extend(other.objects.into_iter().map(|mut o| {
            match &mut o.shape {
                Shape::Mesh(mesh) => renumber(mesh),
                // Its mesh has been renumbered.
                Shape::Instance(_) => {}
                Shape::Primitive(p) => p.material += materials,
                Shape::Exact(exact) => exact.map_materials(&mut |m| m + materials),
            }
            o
        }));
        let number = |texture: TextureId| texture + textures;
        let lights = other.lights.into_iter().map(|l| l.with_texture(number));
        self.lights.extend(lights);
        self.cameras.extend(other.cameras);
        let background = other.background.map(|b| b.with_texture(number));
        self.background = self.background.or(background);
        self.fog = self.fog.or(other.fog);
    }
}

/// Stores the irradiance that the first pass computed in a shape; panics if it is another's.
fn store_irradiance(shape: &mut Shape, light: ObjectIrradiance) {
    match (shape, light) {
        (Shape::Exact(exact), ObjectIrradiance::Refined(proxy)) => exact.proxy = Some(proxy),
        (Shape::Primitive(p), ObjectIrradiance::Surface(light)) => p.light = Some(Box::new(light)),
        (shape @ (Shape::Mesh(_) | Shape::Instance(_)), ObjectIrradiance::Refined(mesh)) => {
            *shape = Shape::Mesh(*mesh);
        }
        (
            shape,
            ObjectIrradiance::Vertices {
                irradiance,
                error,
                back,
                turned,
            },
        ) => {
            let light = VertexLight {
                irradiance,
                error,
                back,
            };
            store_vertex_light(shape, light, &turned);
        }
        _ => panic!("irradiance of another kind of shape"),
    }
}

/// Stores irradiance on the vertices of a mesh, and turns over the faces, in ascending order, whose back it is for.
fn store_vertex_light(shape: &mut Shape, light: VertexLight, turned: &[u32]) {
    match shape {
        Shape::Mesh(mesh) => {
            mesh.set_light(light);
            mesh.turn_faces(|f| turned.binary_search(&(f as u32)).is_ok());
        }
        Shape::Instance(instance) => {
            let fits = light.irradiance.len() == instance.mesh.positions.len();
            // Other instances share its faces.
            assert!(fits && turned.is_empty(), "irradiance of another mesh");
            instance.light = Some(Box::new(light));
        }
        Shape::Primitive(_) | Shape::Exact(_) => panic!("irradiance of another kind of shape"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Primitive, PrimitiveKind};
    use glam::{DAffine3, DVec3};

    fn boxes(boxes: &[(DVec3, f64)]) -> Scene {
        let mut scene = Scene::default();
        for &(place, size) in boxes {
            let map = DAffine3::from_translation(place) * DAffine3::from_scale(DVec3::splat(size));
            let cuboid = Primitive::new(PrimitiveKind::Cuboid, map, 0);
            let object = Object::new("box", Shape::Primitive(cuboid));
            scene.objects.push(object);
        }
        scene
    }

    #[test]
    fn what_is_tiny_and_far_away_is_not_in_the_main_bounds() {
        let model = (DVec3::ZERO, 1.0);
        let stray = (DVec3::splat(20.0), 0.1);
        let scene = boxes(&[model, stray]);
        assert_eq!(scene.main_bounds(), boxes(&[model]).bounds());
        // Nearby, larger, or one of many that are all small, it counts.
        for counted in [
            vec![model, (DVec3::splat(1.2), 0.02)],
            vec![model, (DVec3::splat(20.0), 1.0)],
            vec![stray, (DVec3::ZERO, 0.1), (DVec3::X, 0.1)],
        ] {
            let scene = boxes(&counted);
            assert_eq!(scene.main_bounds(), scene.bounds(), "{counted:?}");
        }
        assert!(Scene::default().main_bounds().is_empty());
    }
}
