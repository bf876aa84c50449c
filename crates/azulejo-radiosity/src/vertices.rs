//! The gather points of a scene's vertices, and the irradiance on them.
//!
//! A face may be lit from either side. Irradiance is stored for the front, so a face that does not
//! emit and receives more light on its back is reversed: models whose faces point outwards are lit
//! all the same. Meshes that are kept as given are not reversed, but get the light of the brighter
//! side. Exact shapes have an outside, which is always the front; their proxy polygons are never
//! reversed.

use crate::gather::Gathering;
use azulejo_factors::row::side;
use azulejo_factors::{Patches, RefinedShape};
use azulejo_scene::{Irradiance, Mesh, ObjectIrradiance, Rgb, Scene, Shape, SurfaceLight};
use azulejo_trace::{GatherPoint, Gathered};

/// The points to gather at, one per display vertex of the patches.
pub struct Targets {
    /// One per display vertex.
    pub points: Vec<GatherPoint>,
    /// Whether the point is on the back of its faces.
    is_turned: Vec<bool>,
    /// For each object whether it gets light on its given vertices.
    is_kept: Vec<bool>,
}

/// Chooses the brighter side of every display vertex of the scene as given, exact shapes included;
/// `incident` is irradiance per side of the patches.
pub fn targets(scene: &Scene, patches: &Patches, incident: &[Rgb], keep_mesh: bool) -> Targets {
    let is_mesh = |o: &azulejo_scene::Object| matches!(o.shape, Shape::Mesh(_));
    let mut targets = Targets {
        points: Vec::new(),
        is_turned: Vec::new(),
        is_kept: scene
            .objects
            .iter()
            .map(|o| keep_mesh && is_mesh(o))
            .collect(),
    };
    for (index, vertex) in patches.vertices().iter().enumerate() {
        let around = patches.patches_at(index);
        let sum = |front: bool| -> f64 {
            around
                .iter()
                .map(|&p| patches.area(p as usize) * incident[side(p, front) as usize].mean())
                .sum()
        };
        let may_turn = around.iter().all(|&p| {
            let m = &scene.materials[patches.material(p as usize) as usize];
            !m.is_emitter() && m.dielectric.is_none()
        });
        let is_mesh = is_mesh(&scene.objects[vertex.object as usize]);
        let turned = may_turn && is_mesh && sum(false) > sum(true);
        let normal = if turned {
            -vertex.normal
        } else {
            vertex.normal
        };
        targets.points.push(GatherPoint {
            position: vertex.gather,
            normal,
            key: index as u32,
        });
        targets.is_turned.push(turned);
    }
    targets
}

/// Irradiance of all display vertices; standard errors, or none.
struct VertexValues<'a> {
    irradiance: &'a [Rgb],
    error: &'a [Rgb],
}

impl Targets {
    /// The area for which each point stands: a corner's share of the patches around it, square scene
    /// units.
    pub fn areas(&self, patches: &Patches) -> Vec<f64> {
        let of_patch = |&p: &u32| {
            let p = p as usize;
            patches.area(p) / patches.corner_vertices(p).len() as f64
        };
        let of_vertex = |v: usize| patches.patches_at(v).iter().map(of_patch).sum();
        (0..self.points.len()).map(of_vertex).collect()
    }

    /// The irradiance gathered at the points, on the objects of the divided scene.
    pub fn irradiance(&self, scene: &Scene, patches: &Patches, found: &Gathering) -> Irradiance {
        let means = found.gathered.iter().map(Gathered::mean);
        let values: Vec<Rgb> = means.map(positive).collect();
        let light = VertexValues {
            irradiance: &values,
            error: &found.standard_errors(),
        };
        self.of_objects(scene, patches, &light)
    }

    /// The irradiance interpolated from the sides of patches, weighted by area at each vertex:
    /// coarse, without highlights or contact shadows, and without errors.
    pub fn interpolated(&self, scene: &Scene, patches: &Patches, incident: &[Rgb]) -> Irradiance {
        let at = |(vertex, &is_turned): (usize, &bool)| {
            let around = patches.patches_at(vertex).iter();
            let (mut sum, mut areas) = (Rgb::BLACK, 0.0);
            for &p in around {
                let area = patches.area(p as usize);
                sum += incident[side(p, !is_turned) as usize] * area;
                areas += area;
            }
            if areas > 0.0 {
                positive(sum / areas)
            } else {
                Rgb::BLACK
            }
        };
        let values: Vec<Rgb> = self.is_turned.iter().enumerate().map(at).collect();
        let light = VertexValues {
            irradiance: &values,
            error: &[],
        };
        self.of_objects(scene, patches, &light)
    }

    fn of_objects(&self, scene: &Scene, patches: &Patches, light: &VertexValues) -> Irradiance {
        let of_object = |(object, o): (usize, &azulejo_scene::Object)| match &o.shape {
            Shape::Mesh(mesh) if self.is_kept[object] => given(patches, object as u32, mesh, light),
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
        light: &VertexValues,
    ) -> ObjectIrradiance {
        let range = patches.vertices_of(object);
        let values = light.irradiance[range.clone()].to_vec();
        let errors = light.error.get(range.clone()).unwrap_or(&[]).to_vec();
        match patches.refined(object, scene) {
            RefinedShape::Mesh(mut mesh) => {
                turn_faces(&mut mesh, &self.is_turned[range]);
                mesh.irradiance = values;
                mesh.irradiance_error = errors;
                ObjectIrradiance::Refined(Box::new(mesh))
            }
            RefinedShape::Surface(grids) => ObjectIrradiance::Surface(SurfaceLight {
                grids,
                irradiance: values,
                error: errors,
            }),
        }
    }
}

/// Irradiance on the given vertices: where a crease gives a vertex several display vertices, their
/// mean by corner angle.
fn given(patches: &Patches, object: u32, mesh: &Mesh, light: &VertexValues) -> ObjectIrradiance {
    let (mut irradiance, mut error) = (Vec::new(), Vec::new());
    for vertex in 0..mesh.positions.len() as u32 {
        let shown = patches.given_vertices(object, vertex);
        let total: f64 = shown.iter().map(|g| g.weight).sum();
        let mean = |values: &[Rgb]| -> Rgb {
            let sum: Rgb = shown
                .iter()
                .map(|g| values[g.display as usize] * g.weight)
                .sum();
            if total > 0.0 { sum / total } else { Rgb::BLACK }
        };
        irradiance.push(mean(light.irradiance));
        if !light.error.is_empty() {
            error.push(mean(light.error));
        }
    }
    ObjectIrradiance::Vertices { irradiance, error }
}

/// The estimate of a visible fraction may fall slightly below zero.
fn positive(e: Rgb) -> Rgb {
    e.map(|x| x.max(0.0))
}

/// Reverses the faces whose vertices are lit on the back, with their normals.
fn turn_faces(mesh: &mut Mesh, is_turned: &[bool]) {
    let turned = |corners: &[u32]| {
        2 * corners.iter().filter(|&&v| is_turned[v as usize]).count() > corners.len()
    };
    for face in 0..mesh.faces.len() {
        let range = mesh.faces.corner_range(face);
        if turned(&mesh.faces.corners[range.clone()]) {
            mesh.faces.corners[range.clone()].reverse();
            let indices = [
                mesh.normals.as_mut().and_then(|a| a.corners.as_mut()),
                mesh.uvs.as_mut().and_then(|a| a.corners.as_mut()),
            ];
            for corners in indices.into_iter().flatten() {
                corners[range.clone()].reverse();
            }
        }
    }
    if let Some(normals) = mesh.normals.as_mut().filter(|n| n.corners.is_none()) {
        for (n, _) in normals
            .values
            .iter_mut()
            .zip(is_turned)
            .filter(|(_, t)| **t)
        {
            *n = -*n;
        }
    }
}
