//! The gather points of a scene's vertices, and the irradiance on them.
//!
//! A face may be lit from either side, or from both: [`StoredSides`](crate::StoredSides) says which
//! light is stored. Where it is that of the back alone, the face is reversed, on the mesh as given
//! too, so that irradiance always belongs to the front. Exact shapes have an outside, which is
//! always the front; their proxy polygons are never reversed.

use crate::first_pass::FirstPass;
use crate::gathering::Gathering;
use crate::sides::{SideChoice, choose, is_mesh};
use crate::system::RadiositySolution;
use azulejo_factors::row::side;
use azulejo_factors::{FaceId, Patches, RefinedShape};
use azulejo_scene::SurfaceLight;
use azulejo_scene::{
    BackIrradiance, Irradiance, Mesh, Object, ObjectIrradiance, Rgb, Scene, Shape,
};
use azulejo_trace::{GatherPoint, Gathered};
use std::collections::HashMap;

/// The points to gather at: one per display vertex of the patches, and after them one for each
/// display vertex of which both sides are needed.
pub struct Targets {
    /// The points; irradiance and errors are in their order.
    pub points: Vec<GatherPoint>,
    /// One per display vertex.
    vertices: Vec<VertexPoints>,
    /// What each patch stores.
    choices: Vec<SideChoice>,
    /// For each object whether it gets light on its given vertices.
    is_kept: Vec<bool>,
}

/// The points of a display vertex.
#[derive(Clone, Copy, Debug)]
struct VertexPoints {
    /// Whether its own point, of its own index, is on the side of its normal.
    is_along: bool,
    /// Index of the point on the other side, if there is one.
    other: Option<u32>,
}

/// Chooses the sides of every display vertex of the scene as given, exact shapes included.
pub fn targets(
    scene: &Scene,
    patches: &Patches,
    found: &RadiositySolution,
    pass: &FirstPass,
) -> Targets {
    let keep_mesh = pass.keep_mesh;
    let choices = choose(scene, patches, found, pass.sides, keep_mesh);
    let mut targets = Targets {
        points: Vec::new(),
        vertices: Vec::new(),
        is_kept: scene
            .objects
            .iter()
            .zip(0..)
            .map(|(o, object)| is_kept(o, object, patches, keep_mesh))
            .collect(),
        choices,
    };
    let mut others = Vec::new();
    for (index, vertex) in patches.vertices().iter().enumerate() {
        let needed = targets.needed(patches, index);
        let is_along = needed[0] >= needed[1];
        let point = |is_along: bool, key: usize| GatherPoint {
            position: vertex.gather,
            normal: if is_along {
                vertex.normal
            } else {
                -vertex.normal
            },
            key: key as u32,
        };
        targets.points.push(point(is_along, index));
        let other = needed.iter().all(|&area| area > 0.0).then(|| {
            let key = patches.vertices().len() + others.len();
            others.push(point(!is_along, key));
            key as u32
        });
        targets.vertices.push(VertexPoints { is_along, other });
    }
    targets.points.extend(others);
    targets
}

/// Whether an object gets light on its given vertices. An instance does where its faces are as fine as
/// the patches: it stays one of many.
fn is_kept(object: &Object, index: u32, patches: &Patches, keep_mesh: bool) -> bool {
    let is_whole = |mesh: &Mesh| patches.patches_of(index).len() <= mesh.faces.triangle_count();
    match &object.shape {
        Shape::Instance(instance) => keep_mesh || is_whole(&instance.mesh),
        _ => keep_mesh && is_mesh(object),
    }
}

/// Irradiance of all points; standard errors, or none.
struct PointValues<'a> {
    irradiance: &'a [Rgb],
    error: &'a [Rgb],
}

impl PointValues<'_> {
    fn at(&self, point: usize) -> (Rgb, Rgb) {
        let error = self.error.get(point).copied().unwrap_or(Rgb::BLACK);
        (self.irradiance[point], error)
    }
}

/// A display vertex's share of the patches around it, square scene units.
pub(crate) fn vertex_area(patches: &Patches, vertex: usize) -> f64 {
    let share = |&p: &u32| {
        let p = p as usize;
        patches.area(p) / patches.corner_vertices(p).len() as f64
    };
    patches.patches_at(vertex).iter().map(share).sum()
}

impl Targets {
    /// The area for which each point stands: a corner's share of the patches around it, square scene
    /// units; on both sides if both have a point.
    pub fn areas(&self, patches: &Patches) -> Vec<f64> {
        let mut areas = vec![0.0; self.points.len()];
        for (vertex, points) in self.vertices.iter().enumerate() {
            areas[vertex] = vertex_area(patches, vertex);
            if let Some(other) = points.other {
                areas[other as usize] = areas[vertex];
            }
        }
        areas
    }

    /// The irradiance gathered at the points, on the objects of the divided scene.
    pub fn irradiance(&self, scene: &Scene, patches: &Patches, found: &Gathering) -> Irradiance {
        let means = found.gathered.iter().map(Gathered::mean);
        let values: Vec<Rgb> = means.map(positive).collect();
        let light = PointValues {
            irradiance: &values,
            error: &found.standard_errors(),
        };
        self.of_objects(scene, patches, &light)
    }

    /// The irradiance interpolated from the sides of patches, weighted by area at each vertex:
    /// coarse, without highlights or contact shadows, and without errors. `incident` is irradiance
    /// per side of the patches.
    pub fn interpolated(&self, scene: &Scene, patches: &Patches, incident: &[Rgb]) -> Irradiance {
        let at = |vertex: usize, is_along: bool| {
            let around = patches.patches_at(vertex).iter();
            let (mut sum, mut areas) = (Rgb::BLACK, 0.0);
            for &p in around {
                let area = patches.area(p as usize);
                let front = is_aligned(patches, p, vertex) == is_along;
                sum += incident[side(p, front) as usize] * area;
                areas += area;
            }
            if areas > 0.0 {
                positive(sum / areas)
            } else {
                Rgb::BLACK
            }
        };
        let mut values = vec![Rgb::BLACK; self.points.len()];
        for (vertex, points) in self.vertices.iter().enumerate() {
            values[vertex] = at(vertex, points.is_along);
            if let Some(other) = points.other {
                values[other as usize] = at(vertex, !points.is_along);
            }
        }
        let light = PointValues {
            irradiance: &values,
            error: &[],
        };
        self.of_objects(scene, patches, &light)
    }

    /// Area of the patches around a display vertex that need it on the side of its normal, and of
    /// those that need the other one.
    fn needed(&self, patches: &Patches, vertex: usize) -> [f64; 2] {
        let mut needed = [0.0; 2];
        for &p in patches.patches_at(vertex) {
            let is_along = self.is_along(patches, p, vertex);
            let area = patches.area(p as usize);
            needed[usize::from(!is_along)] += area;
            if self.choices[p as usize].both {
                // Too little to decide which side is the vertex's own.
                needed[usize::from(is_along)] += 1e-3 * area;
            }
        }
        needed
    }

    /// Whether the stored side of a patch is that of the normal at one of its vertices.
    fn is_along(&self, patches: &Patches, patch: u32, vertex: usize) -> bool {
        is_aligned(patches, patch, vertex) != self.choices[patch as usize].is_turned
    }

    /// The point of a vertex on a side.
    fn point(&self, vertex: usize, is_along: bool) -> Option<usize> {
        let points = self.vertices[vertex];
        if points.is_along == is_along {
            Some(vertex)
        } else {
            points.other.map(|p| p as usize)
        }
    }

    fn of_objects(&self, scene: &Scene, patches: &Patches, light: &PointValues) -> Irradiance {
        let of_object = |(object, o): (usize, &Object)| match &o.shape {
            Shape::Mesh(mesh) if self.is_kept[object] => {
                self.given(patches, object as u32, mesh, light)
            }
            Shape::Instance(instance) if self.is_kept[object] => {
                self.given(patches, object as u32, &instance.mesh, light)
            }
            _ => self.refined(scene, patches, object as u32, light),
        };
        Irradiance {
            objects: scene.objects.iter().enumerate().map(of_object).collect(),
        }
    }

    fn refined(
        &self,
        scene: &Scene,
        patches: &Patches,
        object: u32,
        light: &PointValues,
    ) -> ObjectIrradiance {
        match patches.refined(object, scene) {
            RefinedShape::Mesh(mesh) => {
                let mut sided = SidedMesh::new(self, patches, object, mesh);
                sided.set_irradiance(light);
                ObjectIrradiance::Refined(Box::new(sided.mesh))
            }
            RefinedShape::Surface(grids) => {
                let range = patches.vertices_of(object);
                ObjectIrradiance::Surface(SurfaceLight {
                    grids,
                    irradiance: light.irradiance[range.clone()].to_vec(),
                    error: light.error.get(range).unwrap_or(&[]).to_vec(),
                })
            }
        }
    }

    /// Irradiance on the given vertices: where a crease gives a vertex several display vertices,
    /// their mean by corner angle.
    fn given(
        &self,
        patches: &Patches,
        object: u32,
        mesh: &Mesh,
        light: &PointValues,
    ) -> ObjectIrradiance {
        let has_back = patches.patches_of(object).any(|p| self.choices[p].both);
        let mut back = BackIrradiance::default();
        let (mut irradiance, mut error) = (Vec::new(), Vec::new());
        for vertex in 0..mesh.positions.len() as u32 {
            let shown = patches.given_vertices(object, vertex);
            let mean = |point: &dyn Fn(usize) -> Option<usize>| {
                let (mut sum, mut total) = ([Rgb::BLACK; 2], 0.0);
                for g in shown {
                    if let Some(point) = point(g.display as usize) {
                        let (e, error) = light.at(point);
                        sum = [sum[0] + e * g.weight, sum[1] + error * g.weight];
                        total += g.weight;
                    }
                }
                (total > 0.0).then(|| sum.map(|s| s / total))
            };
            let [e, se] = mean(&Some).unwrap_or_default();
            irradiance.push(e);
            error.push(se);
            if has_back {
                let other = mean(&|v| self.vertices[v].other.map(|p| p as usize));
                back.irradiance.push(other.map(|o| o[0]));
                back.error.push(other.unwrap_or_default()[1]);
            }
        }
        if light.error.is_empty() {
            (error, back.error) = (Vec::new(), Vec::new());
        }
        ObjectIrradiance::Vertices {
            irradiance,
            error,
            back: has_back.then(|| Box::new(back)),
            turned: self.turned_faces(patches, object, mesh.faces.len() as u32),
        }
    }

    /// The given faces most of whose area is turned.
    fn turned_faces(&self, patches: &Patches, object: u32, count: u32) -> Vec<u32> {
        let is_turned = |&face: &u32| {
            let signed = |p: usize| {
                let area = patches.area(p);
                if self.choices[p].is_turned {
                    area
                } else {
                    -area
                }
            };
            let parts = patches.patches_of_face(FaceId { object, face });
            parts.map(signed).sum::<f64>() > 0.0
        };
        (0..count).filter(is_turned).collect()
    }
}

/// Whether a patch faces the way of the normal of its vertex, which the file may give otherwise. At
/// the tip of a smooth cone they may be at more than a right angle.
fn is_aligned(patches: &Patches, patch: u32, vertex: usize) -> bool {
    let normal = patches.vertices()[vertex].normal;
    patches.normal(patch as usize).dot(normal) > -0.5
}

/// A divided mesh with the sides that its patches store.
struct SidedMesh<'a> {
    targets: &'a Targets,
    mesh: Mesh,
    /// For each vertex its display vertex, whether it is on the side of the normal there, and
    /// whether the other side is stored, too.
    vertices: Vec<SidedVertex>,
}

#[derive(Clone, Copy)]
struct SidedVertex {
    display: usize,
    is_along: bool,
    has_back: bool,
}

impl<'a> SidedMesh<'a> {
    /// Turns the faces that store their backs. A vertex between faces that store different sides
    /// becomes two.
    fn new(targets: &'a Targets, patches: &Patches, object: u32, mesh: Mesh) -> SidedMesh<'a> {
        let range = patches.vertices_of(object);
        let own = |display: usize| SidedVertex {
            display,
            is_along: targets.vertices[display].is_along,
            has_back: false,
        };
        let mut sided = SidedMesh {
            targets,
            mesh,
            vertices: range.clone().map(own).collect(),
        };
        let mut second: HashMap<usize, u32> = HashMap::new();
        for (face, patch) in patches.patches_of(object).enumerate() {
            let choice = targets.choices[patch];
            for corner in sided.mesh.faces.corner_range(face) {
                let first = sided.mesh.faces.corners[corner] as usize;
                let display = range.start + first;
                let is_along = targets.is_along(patches, patch as u32, display);
                let vertex = if sided.vertices[first].is_along == is_along {
                    first
                } else {
                    *second
                        .entry(first)
                        .or_insert_with(|| sided.push_copy(first, display, is_along))
                        as usize
                };
                sided.mesh.faces.corners[corner] = vertex as u32;
                sided.vertices[vertex].has_back |= choice.both;
            }
            if choice.is_turned {
                sided.mesh.reverse_face(face);
            }
        }
        sided.turn_normals();
        sided
    }

    /// Appends a vertex on the other side of another.
    fn push_copy(&mut self, first: usize, display: usize, is_along: bool) -> u32 {
        let mesh = &mut self.mesh;
        mesh.positions.push(mesh.positions[first]);
        if !mesh.colors.is_empty() {
            mesh.colors.push(mesh.colors[first]);
        }
        if let Some(normals) = &mut mesh.normals {
            normals.values.push(normals.values[first]);
        }
        if let Some(uvs) = mesh.uvs.as_mut().filter(|uvs| uvs.corners.is_none()) {
            uvs.values.push(uvs.values[first]);
        }
        self.vertices.push(SidedVertex {
            display,
            is_along,
            has_back: false,
        });
        self.vertices.len() as u32 - 1
    }

    /// Normals on the side of the faces.
    fn turn_normals(&mut self) {
        let Some(normals) = &mut self.mesh.normals else {
            return;
        };
        for (n, v) in normals.values.iter_mut().zip(&self.vertices) {
            if !v.is_along {
                *n = -*n;
            }
        }
    }

    fn set_irradiance(&mut self, light: &PointValues) {
        let known = |v: &SidedVertex, is_along: bool| {
            let point = self.targets.point(v.display, is_along);
            point.map(|p| light.at(p))
        };
        let fronts = self.vertices.iter().map(|v| known(v, v.is_along));
        let (irradiance, error): (Vec<Rgb>, Vec<Rgb>) =
            fronts.map(Option::unwrap_or_default).unzip();
        let has_errors = !light.error.is_empty();
        if self.vertices.iter().any(|v| v.has_back) {
            let backs = self
                .vertices
                .iter()
                .map(|v| known(v, !v.is_along).filter(|_| v.has_back));
            let backs: Vec<Option<(Rgb, Rgb)>> = backs.collect();
            let error = backs.iter().map(|b| b.unwrap_or_default().1);
            self.mesh.back = Some(Box::new(BackIrradiance {
                irradiance: backs.iter().map(|b| b.map(|b| b.0)).collect(),
                error: if has_errors {
                    error.collect()
                } else {
                    Vec::new()
                },
            }));
        }
        self.mesh.irradiance = irradiance;
        self.mesh.irradiance_error = if has_errors { error } else { Vec::new() };
    }
}

/// The estimate of a visible fraction may fall slightly below zero.
fn positive(e: Rgb) -> Rgb {
    e.map(|x| x.max(0.0))
}
