//! Free-form surfaces as polygons.

use super::region::{Loops, cells};
use super::surface::{FreeFormSurface, Lines, Refused, Sample, Technique};
use crate::reading::options::Budget;
use azulejo_scene::{Attribute, Faces, MaterialId, Mesh};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Distance from a pole, where the parameters do not span a plane, at which its normal is
/// evaluated instead: a share of the surface.
const BESIDE_A_POLE: f64 = 1e-3;

/// The polygons of a surface over a rectangle of its parameters, or over the region that `loops`
/// leave of it. Normals are those of the surface.
pub(super) fn tessellate(
    surface: &FreeFormSurface,
    range: [f64; 4],
    technique: Technique,
    loops: impl FnOnce(&Lines, &mut Budget) -> Result<Loops, Refused>,
    budget: &mut Budget,
) -> Result<Patch, Refused> {
    let lines = surface.lines(range, technique, budget)?;
    let mut patch = Patch {
        middle: DVec2::new(range[0].midpoint(range[1]), range[2].midpoint(range[3])),
        ..Patch::default()
    };
    let loops = loops(&lines, budget)?;
    if loops.is_empty() {
        patch.grid(surface, &lines, budget)?;
    } else {
        patch.trimmed(surface, &lines, loops, budget)?;
    }
    let finite = |v: &DVec3| v.is_finite();
    if patch.positions.iter().all(finite) && patch.uvs.iter().all(|t| t.is_finite()) {
        Ok(patch)
    } else {
        Err("points that are not finite".into())
    }
}

/// Polygons of one surface, with all attributes per vertex.
#[derive(Debug, Default)]
pub(super) struct Patch {
    /// Parameters of the centre.
    middle: DVec2,
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    uvs: Vec<DVec2>,
    faces: Faces,
}

impl Patch {
    fn grid(
        &mut self,
        surface: &FreeFormSurface,
        lines: &Lines,
        budget: &mut Budget,
    ) -> Result<(), Refused> {
        let (width, height) = (lines.u.len() as u64, lines.v.len() as u64);
        budget.spend(width * height * (4 + surface.cost()))?;
        let columns: Vec<_> = lines.u.iter().map(|&u| (u, surface.u.at(u))).collect();
        for &v in &lines.v {
            let row = surface.v.at(v);
            for (u, column) in &columns {
                let at = DVec2::new(*u, v);
                self.push(surface, at, surface.sample(column, &row, at));
            }
        }
        let width = width as u32;
        for row in 1..height as u32 {
            for column in 1..width {
                let far = row * width + column;
                self.faces
                    .push(&[far - width - 1, far - width, far, far - 1]);
            }
        }
        Ok(())
    }

    fn trimmed(
        &mut self,
        surface: &FreeFormSurface,
        lines: &Lines,
        loops: Loops,
        budget: &mut Budget,
    ) -> Result<(), Refused> {
        let polygons = cells(loops, &lines.u, &lines.v, budget)?;
        let mut known = HashMap::new();
        for polygon in polygons {
            budget.spend(polygon.len() as u64 * (1 + surface.cost()))?;
            let corner = |&p: &DVec2| {
                *known
                    .entry(p.to_array().map(|x| (x + 0.0).to_bits()))
                    .or_insert_with(|| self.vertex(surface, p))
            };
            let corners: Vec<u32> = polygon.iter().map(corner).collect();
            self.faces.push(&corners);
        }
        Ok(())
    }

    /// Adds the point of the surface at parameters, and returns its index.
    fn vertex(&mut self, surface: &FreeFormSurface, at: DVec2) -> u32 {
        self.push(surface, at, surface.at(at.x, at.y))
    }

    fn push(&mut self, surface: &FreeFormSurface, at: DVec2, sample: Sample) -> u32 {
        let normal = normal(&sample).or_else(|| {
            let inward = at + BESIDE_A_POLE * (self.middle - at);
            normal(&surface.at(inward.x, inward.y))
        });
        self.positions.push(sample.position);
        self.uvs.push(sample.uv);
        // Where a surface has no area, any unit vector will do.
        self.normals.push(normal.unwrap_or(DVec3::Z));
        (self.positions.len() - 1) as u32
    }

    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Adds the polygons to a mesh that contains no others.
    pub fn add_to(self, mesh: &mut Mesh, material: MaterialId) {
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(self.positions);
        let normals = mesh.normals.get_or_insert_with(Attribute::default);
        normals.values.extend(self.normals);
        let uvs = mesh.uvs.get_or_insert_with(Attribute::default);
        uvs.values.extend(self.uvs);
        for face in self.faces.iter() {
            let corners: Vec<u32> = face.iter().map(|v| base + v).collect();
            mesh.push_face(&corners, material);
        }
    }
}

/// Unit normal on the side from which v is left of u; `None` if the parameters do not span a plane.
fn normal(sample: &Sample) -> Option<DVec3> {
    let scaled = |d: DVec3| d / d.abs().max_element();
    let across = scaled(sample.du).cross(scaled(sample.dv));
    // Directions a millionth of a degree apart are equal within rounding.
    (across.length_squared() > 1e-16)
        .then(|| across.try_normalize())
        .flatten()
}
