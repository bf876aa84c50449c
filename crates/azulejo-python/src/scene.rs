//! Scenes, from arrays and as arrays.

use crate::arrays::{colours, triples, vectors};
use crate::brdf;
use crate::choices;
use crate::error::refused;
use crate::page;
use azulejo::periods::Periods;
use azulejo_scene::sky::SUN_HALF_ANGLE;
use azulejo_scene::{
    Exact, Faces, Light, LightKind, MOST_FACE_CORNERS, Material, MaterialId, Mesh, Object, Rgb,
    Scene, Shape, Units,
};
use azulejo_trace::Tracer;
use glam::DVec3;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// A scene with its tracer, which is made when it is first needed.
#[pyclass(frozen, module = "pyazulejo._pyazulejo")]
pub struct NativeScene {
    /// The scene.
    pub scene: Arc<Scene>,
    tracer: Arc<OnceLock<Tracer>>,
    warnings: Vec<String>,
}

/// A scene for a thread of its own.
#[derive(Clone)]
pub struct SharedScene {
    /// The scene.
    pub scene: Arc<Scene>,
    tracer: Arc<OnceLock<Tracer>>,
}

impl SharedScene {
    /// The tracer of the scene.
    pub fn tracer(&self) -> &Tracer {
        self.tracer.get_or_init(|| Tracer::new(&self.scene))
    }

    /// The same, of the scene repeated without end.
    pub fn repeated(&self, periods: Option<Periods>) -> PyResult<Cow<'_, Tracer>> {
        let Some(periods) = periods else {
            return Ok(Cow::Borrowed(self.tracer()));
        };
        let repeated = periods.repeated(self.tracer().clone());
        let repeated = repeated.map_err(|e| refused(format_args!("periodic: {e}")))?;
        Ok(Cow::Owned(repeated))
    }
}

/// A mesh: name, vertices, where faces start among corners, corners, material.
type MeshArrays<'py> = (
    String,
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray1<'py, u32>,
    PyReadonlyArray1<'py, u32>,
    MaterialId,
);

/// A material: name, diffuse and mirror reflectance, emitted radiance, whether the back emits too,
/// reflection model.
type MaterialNumbers = (String, [f64; 3], [f64; 3], [f64; 3], bool, Option<String>);

/// A mesh with light: vertices, where faces start, corners, irradiance, its standard error.
type LitArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
    Option<Bound<'py, PyArray2<f64>>>,
    Option<Bound<'py, PyArray2<f64>>>,
);

impl NativeScene {
    /// A valid scene with what its reader reported.
    pub fn new(scene: Scene, warnings: Vec<String>) -> NativeScene {
        NativeScene {
            scene: Arc::new(scene),
            tracer: Arc::default(),
            warnings,
        }
    }

    /// What the reader reported.
    pub fn warnings_of_reader(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The same for a thread of its own.
    pub fn shared(&self) -> SharedScene {
        SharedScene {
            scene: self.scene.clone(),
            tracer: self.tracer.clone(),
        }
    }
}

/// The sun, of the direction toward it and the irradiance of what faces it.
fn sun_light((toward, irradiance): ([f64; 3], [f64; 3])) -> PyResult<Light> {
    let toward = DVec3::from_array(toward).try_normalize();
    let toward = toward.ok_or_else(|| refused("sun: its direction is zero, or too long"))?;
    Ok(Light {
        name: "sun".to_owned(),
        kind: LightKind::Directional {
            direction: -toward,
            irradiance: Rgb::from(irradiance),
            half_angle: SUN_HALF_ANGLE,
        },
    })
}

#[pymethods]
impl NativeScene {
    /// A scene of meshes. Arrays are copied.
    #[staticmethod]
    fn from_meshes(
        meshes: Vec<MeshArrays<'_>>,
        materials: Vec<MaterialNumbers>,
        sky: Option<[f64; 3]>,
        sun: Option<([f64; 3], [f64; 3])>,
        up: &str,
        unit: Option<f64>,
    ) -> PyResult<NativeScene> {
        let mut scene = Scene {
            units: Units {
                metres_per_unit: unit,
                up: choices::up(up)?,
                photometric: false,
            },
            ..Scene::default()
        };
        for numbers in materials {
            scene.add_material(material(numbers)?);
        }
        for mesh in &meshes {
            scene.objects.push(object(mesh)?);
        }
        if let Some(sky) = sky {
            let radiance = Rgb::from(sky);
            let kind = LightKind::Ambient { radiance };
            let name = "sky".to_owned();
            scene.lights.push(Light { name, kind });
        }
        scene.lights.extend(sun.map(sun_light).transpose()?);
        scene.validate().map_err(refused)?;
        Ok(NativeScene::new(scene, Vec::new()))
    }

    /// Names of the objects.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.scene.objects.iter().map(|o| o.name.clone()).collect()
    }

    /// Area of each object.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let areas: Vec<f64> = self.scene.objects.iter().map(|o| area(&o.shape)).collect();
        areas.into_pyarray(py)
    }

    /// Number of faces of each object; 0 for exact shapes.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let count = |o: &Object| o.shape.mesh().map_or(0, |m| m.faces.len() as i64);
        let counts: Vec<i64> = self.scene.objects.iter().map(count).collect();
        counts.into_pyarray(py)
    }

    /// Name, diffuse and mirror reflectance, emission, whether the back emits, and reflection model of
    /// each material.
    #[getter]
    fn materials(&self) -> Vec<MaterialNumbers> {
        let numbers = |m: &Material| {
            let model = m.brdf.as_ref().map(|b| b.description().to_string());
            let [diffuse, mirror, emission] = [m.diffuse, m.mirror, m.emission].map(Rgb::to_array);
            (
                m.name.clone(),
                diffuse,
                mirror,
                emission,
                m.emits_back,
                model,
            )
        };
        self.scene.materials.iter().map(numbers).collect()
    }

    /// What the reader skipped or repaired.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Whether its surfaces carry light.
    #[getter]
    fn is_solved(&self) -> bool {
        self.scene.is_solved()
    }

    /// The up axis.
    #[getter]
    fn up(&self) -> &'static str {
        match self.scene.units.up {
            azulejo_scene::Up::Y => "y",
            azulejo_scene::Up::Z => "z",
        }
    }

    /// Metres of a unit of length, if they are known.
    #[getter]
    fn unit(&self) -> Option<f64> {
        self.scene.units.metres_per_unit
    }

    /// The smallest box around the scene: its low and its high corner.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bounds = self.scene.bounds();
        triples(py, [bounds.min.to_array(), bounds.max.to_array()])
    }

    /// The page that shows it with the light of its vertices, as HTML.
    fn html(&self, py: Python<'_>, words: page::Words, most: Option<u64>) -> PyResult<String> {
        let scene = self.scene.clone();
        page::html(py, move || {
            page::check_size(azulejo::page::least_size(&scene), most)?;
            let model = azulejo::page::of_scene(&scene).map_err(refused)?;
            page::written(model, words, most)
        })
    }

    /// The mesh of an object, with its light.
    fn mesh<'py>(&self, py: Python<'py>, object: usize) -> PyResult<LitArrays<'py>> {
        let name = |o: &Object| format!("object {object} \"{}\" has no mesh: it is exact", o.name);
        let given = (self.scene.objects.get(object))
            .ok_or_else(|| refused(format_args!("there is no object {object}")))?;
        let placed = given.shape.placed_mesh();
        let placed = placed.ok_or_else(|| refused(name(given)))?;
        let vertices = 0..placed.mesh.positions.len() as u32;
        let Faces { starts, corners } = placed.mesh.faces.clone();
        let light = |values: &[Rgb]| {
            (!values.is_empty())
                .then(|| colours(py, values))
                .transpose()
        };
        Ok((
            triples(py, vertices.map(|v| placed.position(v).to_array()))?,
            starts.into_pyarray(py),
            corners.into_pyarray(py),
            light(placed.irradiance)?,
            light(placed.irradiance_error)?,
        ))
    }
}

fn material(
    (name, diffuse, mirror, emission, emits_back, model): MaterialNumbers,
) -> PyResult<Material> {
    let plain = Material {
        diffuse: diffuse.into(),
        mirror: mirror.into(),
        ..Material::default()
    };
    let surface = match model {
        Some(text) => Material::with_brdf("", Arc::new(brdf::model(&text)?)),
        None => plain,
    };
    Ok(Material {
        name,
        emission: emission.into(),
        emits_back,
        ..surface
    })
}

fn object((name, vertices, starts, corners, material): &MeshArrays) -> PyResult<Object> {
    let wrong = |what: &str| refused(format_args!("mesh \"{name}\": {what}"));
    let (starts, corners) = (starts.as_array().to_vec(), corners.as_array().to_vec());
    let is_whole = starts.first() == Some(&0) && starts.last() == Some(&(corners.len() as u32));
    if !is_whole || u32::try_from(corners.len()).is_err() {
        return Err(wrong("its faces do not add up to its corners"));
    }
    let lengths = || starts.windows(2).map(|w| w[1].checked_sub(w[0]));
    if let Some(face) = lengths().position(|n| n.is_none_or(|n| n < 3)) {
        return Err(wrong(&format!("face {face} has fewer than three corners")));
    }
    let is_vast = |n: Option<u32>| n.is_some_and(|n| n as usize > MOST_FACE_CORNERS);
    if let Some(face) = lengths().position(is_vast) {
        return Err(wrong(&format!(
            "face {face} has more than {MOST_FACE_CORNERS} corners: divide it"
        )));
    }
    let mesh = Mesh {
        positions: vectors(vertices)?,
        face_materials: vec![*material; starts.len() - 1],
        faces: Faces { starts, corners },
        ..Mesh::default()
    };
    Ok(Object::new(name.clone(), Shape::Mesh(mesh)))
}

/// Chord error of the polygons from which areas of exact shapes are estimated, as a share of their size.
const ROUGH: f64 = 1e-3;

fn area(shape: &Shape) -> f64 {
    let polygons = |exact: &Exact| -> f64 {
        exact
            .areas(ROUGH * exact.bounds().diagonal())
            .values()
            .sum()
    };
    match shape {
        Shape::Mesh(_) | Shape::Instance(_) => shape.placed_mesh().map_or(0.0, |m| m.area()),
        Shape::Primitive(primitive) => primitive.area(),
        Shape::Exact(exact) => polygons(exact),
    }
}
