//! Form factors with known answers: scenes with a question, to judge every engine by.
//!
//! [`cases`] returns 68 that test one capability each: pairs of polygons from Howell's catalogue, elements,
//! curved bodies, infinite strips and prisms (cells between perfect mirrors), occluders, plane mirrors,
//! dielectrics, and whole radiosity systems. [`series`] returns closed forms over ranges of their parameters,
//! whose names end with these. [`Case::ask`] computes the form factors by an engine, and `answers` derives
//! the answer from them, with the standard error that follows from theirs.

mod answers;

pub use answers::Answer;
use azulejo_factors::PatchSize;
use azulejo_scene::{Material, Mesh, Object, Primitive, PrimitiveKind, Rgb, Scene, Shape};
use glam::{DAffine3, DQuat, DVec3, dvec3};
use serde::{Deserialize, Deserializer};
use std::f64::consts::PI;

/// A scene and a question about its form factors, with the known answer.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Short name, unique.
    pub id: String,
    /// Description for reports.
    pub description: String,
    /// Source of the truth: a number of Howell's catalogue, a rule, a theorem.
    pub source: String,
    /// The capability of an engine that it tests.
    pub kind: CaseKind,
    /// The scene; faces stay whole unless `size` divides them.
    #[serde(rename = "surfaces", deserialize_with = "scene")]
    pub scene: Scene,
    /// How finely the scene has to be divided, so that its areas are those of the question.
    #[serde(rename = "edge", default = "whole", deserialize_with = "largest_edge")]
    pub size: PatchSize,
    /// The question.
    pub question: Question,
    /// The known answer.
    pub truth: Truth,
}

/// The difficulty of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CaseKind {
    /// Unoccluded polygons.
    Polygons,
    /// Polygons with occluders.
    Shadow,
    /// Plane mirrors, including those that make a cell infinite.
    Mirrors,
    /// Curved bodies, as exact primitives.
    Curved,
    /// Refraction.
    Glass,
}

/// A question about a scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Question {
    /// The extended form factor from one group of patches to another.
    Factor {
        /// Where the light leaves.
        from: PatchGroup,
        /// Where it arrives.
        to: PatchGroup,
    },
    /// The radiosity of a group, W/m², if each group has one radiosity all over.
    Radiosity {
        /// All groups that emit or reflect diffusely.
        groups: Vec<EnclosureSurface>,
        /// The group in question, as an index into `groups`.
        of: usize,
    },
    /// The net flux of a group, B − H, W/m².
    Flux {
        /// All groups that emit or reflect diffusely.
        groups: Vec<EnclosureSurface>,
        /// The group in question, as an index into `groups`; its reflectance is not 0.
        of: usize,
    },
}

/// Some patches, seen from one side.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PatchGroup {
    /// Index among the scene's objects.
    pub object: u32,
    /// One face of the object; `None` for all.
    pub face: Option<u32>,
    /// Whether the backs of the patches are meant, as in hollow bodies.
    #[serde(default)]
    pub inside: bool,
    /// Only patches whose centre lies between these angles about the z axis, in turns.
    pub turns: Option<[f64; 2]>,
}

/// A group of an enclosure, with its emission and reflectance.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnclosureSurface {
    /// The patches.
    pub group: PatchGroup,
    /// Emitted exitance, W/m².
    pub exitance: f64,
    /// Diffuse reflectance.
    pub reflectance: f64,
}

/// A known answer.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// The value.
    pub value: f64,
    /// Absolute uncertainty: rounding, digits, and what the scene simplifies.
    pub error: f64,
    /// Significant digits of a number from elsewhere; `None` of formulas.
    pub digits: Option<u32>,
    /// How it was computed, if not by evaluating a formula.
    pub origin: Option<String>,
}

impl Case {
    /// The source of the truth with how it was computed.
    pub fn provenance(&self) -> String {
        match (self.truth.digits, &self.truth.origin) {
            (Some(digits), Some(origin)) => format!("{}: {digits} digits, {origin}", self.source),
            (None, Some(origin)) => format!("{}, {origin}", self.source),
            _ => self.source.clone(),
        }
    }
}

/// The cases that test one capability each, in a fixed order.
pub fn cases() -> Vec<Case> {
    let files = [
        include_str!("../../../data/form-factors/polygons.toml"),
        include_str!("../../../data/form-factors/bodies.toml"),
        include_str!("../../../data/form-factors/specular.toml"),
        include_str!("../../../data/form-factors/systems.toml"),
    ];
    files.into_iter().flat_map(read).collect()
}

/// Closed forms over ranges of parameters: rectangles and wedges, infinite strips and cylinders, disks,
/// finite cylinders, spheres, and elements. None of them is among [`cases`].
pub fn series() -> Vec<Case> {
    let files = [
        include_str!("../../../data/form-factors/series-flat.toml"),
        include_str!("../../../data/form-factors/series-infinite.toml"),
        include_str!("../../../data/form-factors/series-curved.toml"),
    ];
    files.into_iter().flat_map(read).collect()
}

/// The cases of a file that is part of the program.
fn read(text: &str) -> Vec<Case> {
    #[derive(Deserialize)]
    struct CaseFile {
        case: Vec<Case>,
    }
    let file: CaseFile = toml::from_str(text).expect("tests have read this file");
    file.case
}

/// A surface of a scene, an object of its own; all that emit nothing and are not mirrors reflect the half.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseSurface {
    shape: CaseShape,
    #[serde(default = "half")]
    diffuse: f64,
    #[serde(default)]
    mirror: f64,
    /// Emitted, W/m².
    #[serde(default)]
    exitance: f64,
    /// Refractive index of a body of glass.
    glass: Option<f64>,
    /// Refractive index of a thin pane.
    pane: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum CaseShape {
    /// Corners, counter-clockwise from the front.
    Polygon(Vec<[f64; 3]>),
    Sphere {
        centre: [f64; 3],
        radius: f64,
    },
    /// The wall of a cylinder about the z direction, open at its ends.
    Tube {
        foot: [f64; 3],
        radius: f64,
        height: f64,
    },
    /// A closed cylinder about the z direction, with the faces wall, bottom, top.
    Cylinder {
        foot: [f64; 3],
        radius: f64,
        height: f64,
    },
}

fn half() -> f64 {
    0.5
}

fn whole() -> PatchSize {
    PatchSize::Edge(0.0)
}

fn largest_edge<'de, D: Deserializer<'de>>(deserializer: D) -> Result<PatchSize, D::Error> {
    f64::deserialize(deserializer).map(PatchSize::Edge)
}

fn scene<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Scene, D::Error> {
    let mut scene = Scene::default();
    for surface in Vec::<CaseSurface>::deserialize(deserializer)? {
        let material = scene.add_material(surface.material());
        let shape = surface.shape.placed(material);
        scene.objects.push(Object::new("", shape));
    }
    Ok(scene)
}

impl CaseSurface {
    fn material(&self) -> Material {
        match (self.glass, self.pane) {
            (Some(index), _) => Material::dielectric("glass", index),
            (_, Some(index)) => Material::pane("pane", index),
            _ => Material {
                diffuse: Rgb::grey(self.diffuse),
                mirror: Rgb::grey(self.mirror),
                emission: Rgb::grey(self.exitance / PI),
                ..Material::default()
            },
        }
    }
}

impl CaseShape {
    fn placed(self, material: u32) -> Shape {
        match self {
            CaseShape::Polygon(corners) => {
                let mut mesh = Mesh {
                    positions: corners.into_iter().map(DVec3::from_array).collect(),
                    ..Mesh::default()
                };
                let ring: Vec<u32> = (0..mesh.positions.len() as u32).collect();
                mesh.push_face(&ring, material);
                Shape::Mesh(mesh)
            }
            CaseShape::Sphere { centre, radius } => {
                Shape::Primitive(Primitive::sphere(centre.into(), radius, material))
            }
            CaseShape::Tube {
                foot,
                radius,
                height,
            } => {
                let kind = PrimitiveKind::Tube { top: 1.0 };
                upright(kind, foot, [radius, height], material)
            }
            CaseShape::Cylinder {
                foot,
                radius,
                height,
            } => upright(PrimitiveKind::Cylinder, foot, [radius, height], material),
        }
    }
}

fn upright(kind: PrimitiveKind, foot: [f64; 3], size: [f64; 2], material: u32) -> Shape {
    let [radius, height] = size;
    let scale = dvec3(radius, radius, height);
    let map = DAffine3::from_scale_rotation_translation(scale, DQuat::IDENTITY, foot.into());
    Shape::Primitive(Primitive::new(kind, map, material))
}
