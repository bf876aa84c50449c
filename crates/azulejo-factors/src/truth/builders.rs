//! Building blocks of the scenes.

use super::{Case, CaseKind, PatchGroup, Question, Truth};
use crate::patch::PatchSize;
use azulejo_scene::math::Frame;
use azulejo_scene::{Material, Mesh, Object, Primitive, PrimitiveKind, Rgb, Scene, Shape};
use glam::{DAffine3, DQuat, DVec3, dvec3};
use std::borrow::Cow;
use std::f64::consts::PI;

/// A surface that emits nothing, for questions about form factors.
pub const GREY: GreySurface = GreySurface {
    diffuse: 0.5,
    mirror: 0.0,
    exitance: 0.0,
};

/// A perfect mirror: two of them make what is between them infinite.
pub const PERFECT_MIRROR: GreySurface = GreySurface {
    diffuse: 0.0,
    mirror: 1.0,
    exitance: 0.0,
};

/// Grey reflectances and the emitted exitance.
#[derive(Clone, Copy)]
pub struct GreySurface {
    pub diffuse: f64,
    pub mirror: f64,
    pub exitance: f64,
}

impl GreySurface {
    pub fn mirror(mirror: f64) -> GreySurface {
        GreySurface {
            diffuse: 0.0,
            mirror,
            ..GREY
        }
    }

    pub fn matt(diffuse: f64, exitance: f64) -> GreySurface {
        GreySurface {
            diffuse,
            mirror: 0.0,
            exitance,
        }
    }

    fn material(self) -> Material {
        Material {
            diffuse: Rgb::grey(self.diffuse),
            mirror: Rgb::grey(self.mirror),
            emission: Rgb::grey(self.exitance / PI),
            ..Material::default()
        }
    }
}

/// Builds a scene object by object.
#[derive(Default)]
pub struct SceneBuilder {
    pub scene: Scene,
}

impl SceneBuilder {
    fn add(&mut self, shape: impl FnOnce(u32) -> Shape, material: Material) -> PatchGroup {
        let material = self.scene.add_material(material);
        self.scene.objects.push(Object::new("", shape(material)));
        PatchGroup::of((self.scene.objects.len() - 1) as u32)
    }

    pub fn polygon(&mut self, corners: &[DVec3], surface: GreySurface) -> PatchGroup {
        self.polygon_of(corners, surface.material())
    }

    pub fn polygon_of(&mut self, corners: &[DVec3], material: Material) -> PatchGroup {
        let mesh = |material| {
            let mut mesh = Mesh {
                positions: corners.to_vec(),
                ..Mesh::default()
            };
            mesh.push_face(&(0..corners.len() as u32).collect::<Vec<_>>(), material);
            Shape::Mesh(mesh)
        };
        self.add(mesh, material)
    }

    /// An element: a square so small that its form factor differs from a point's by about 1e-8.
    pub fn element(&mut self, position: DVec3, normal: DVec3) -> PatchGroup {
        let frame = Frame::from_normal(normal);
        let corner = |(x, y): (f64, f64)| position + frame.to_world(1e-4 * dvec3(x, y, 0.0));
        self.polygon(
            &[(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)].map(corner),
            GREY,
        )
    }

    pub fn sphere(&mut self, centre: DVec3, radius: f64, surface: GreySurface) -> PatchGroup {
        let shape = |m| Shape::Primitive(Primitive::sphere(centre, radius, m));
        self.add(shape, surface.material())
    }

    /// The wall of a cylinder about the z direction, open at its ends.
    pub fn tube(&mut self, foot: DVec3, radius: f64, height: f64) -> PatchGroup {
        let shape = turned(PrimitiveKind::Tube { top: 1.0 }, foot, radius, height);
        self.add(shape, GREY.material())
    }

    /// A closed cylinder about the z direction, with the parts wall, bottom, top.
    pub fn cylinder(&mut self, foot: DVec3, radius: f64, height: f64) -> PatchGroup {
        let shape = turned(PrimitiveKind::Cylinder, foot, radius, height);
        self.add(shape, GREY.material())
    }

    /// An exact disk facing up or down: an end of a short cylinder, the rest of which is invisible
    /// from the front of the disk.
    pub fn disk(&mut self, centre: DVec3, radius: f64, up: bool) -> PatchGroup {
        let height = 0.1 * radius;
        let foot = if up {
            centre - height * DVec3::Z
        } else {
            centre
        };
        self.cylinder(foot, radius, height)
            .face(if up { 2 } else { 1 })
    }

    /// Mirrors at the ends z = 0 and z = 1 of a cell with the corners of its section: they make
    /// what is between them infinite.
    pub fn ends(&mut self, section: &[(f64, f64)]) {
        let at = |z: f64| move |&(x, y): &(f64, f64)| dvec3(x, y, z);
        let low: Vec<DVec3> = section.iter().map(at(0.0)).collect();
        let high: Vec<DVec3> = section.iter().rev().map(at(1.0)).collect();
        self.polygon(&low, PERFECT_MIRROR);
        self.polygon(&high, PERFECT_MIRROR);
    }

    /// A wall of such a cell, facing left of the direction from `from` to `to`.
    pub fn wall(&mut self, from: (f64, f64), to: (f64, f64), surface: GreySurface) -> PatchGroup {
        let at = |(x, y): (f64, f64), z: f64| dvec3(x, y, z);
        self.polygon(
            &[at(from, 0.0), at(from, 1.0), at(to, 1.0), at(to, 0.0)],
            surface,
        )
    }

    /// The scene with the question of a form factor.
    pub fn asks(self, from: PatchGroup, to: PatchGroup) -> CaseBuilder {
        self.about(Question::Factor { from, to })
    }

    /// The scene with any question.
    pub fn about(self, question: Question) -> CaseBuilder {
        CaseBuilder {
            scene: self.scene,
            question,
        }
    }
}

fn turned(kind: PrimitiveKind, foot: DVec3, radius: f64, height: f64) -> impl Fn(u32) -> Shape {
    let scale = dvec3(radius, radius, height);
    let map = DAffine3::from_scale_rotation_translation(scale, DQuat::IDENTITY, foot);
    move |material| Shape::Primitive(Primitive::new(kind, map, material))
}

/// A scene with its question.
pub struct CaseBuilder {
    scene: Scene,
    question: Question,
}

impl CaseBuilder {
    /// The case with its known answer.
    pub fn case(
        self,
        id: impl Into<Cow<'static, str>>,
        source: &'static str,
        kind: CaseKind,
        description: impl Into<String>,
        truth: Truth,
    ) -> Case {
        Case {
            id: id.into(),
            description: description.into(),
            source,
            kind,
            scene: self.scene,
            size: PatchSize::Edge(0.0),
            question: self.question,
            truth,
        }
    }
}

/// Points in the plane z.
pub fn plane(z: f64, corners: &[(f64, f64)]) -> Vec<DVec3> {
    corners.iter().map(|&(x, y)| dvec3(x, y, z)).collect()
}

/// The rectangle x × y in the plane z, facing up or down.
pub fn rectangle(x: [f64; 2], y: [f64; 2], z: f64, up: bool) -> Vec<DVec3> {
    let mut corners = plane(z, &[(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]);
    if !up {
        corners.reverse();
    }
    corners
}

/// The rectangle y × z in the plane x, facing +x.
pub fn upright(x: f64, y: [f64; 2], z: [f64; 2]) -> Vec<DVec3> {
    [(y[0], z[0]), (y[1], z[0]), (y[1], z[1]), (y[0], z[1])]
        .map(|(y, z)| dvec3(x, y, z))
        .to_vec()
}

/// The unit square at height z.
pub fn square(z: f64, up: bool) -> Vec<DVec3> {
    rectangle([0.0, 1.0], [0.0, 1.0], z, up)
}

/// The faces z = 0, z = 1, x = 0, x = 1, y = 0, y = 1 of the unit cube, facing inward, added as
/// objects in this order.
pub fn cube(builder: &mut SceneBuilder, surfaces: [GreySurface; 6]) -> [PatchGroup; 6] {
    let turned = |mut polygon: Vec<DVec3>| {
        polygon.reverse();
        polygon
    };
    let across = |y: f64| {
        [(0., 0.), (0., 1.), (1., 1.), (1., 0.)]
            .map(|(x, z)| dvec3(x, y, z))
            .to_vec()
    };
    let unit = [0.0, 1.0];
    let faces = [
        square(0.0, true),
        square(1.0, false),
        upright(0.0, unit, unit),
        turned(upright(1.0, unit, unit)),
        across(0.0),
        turned(across(1.0)),
    ];
    std::array::from_fn(|k| builder.polygon(&faces[k], surfaces[k]))
}
