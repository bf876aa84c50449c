//! Form factors with a description of their rows.

mod cells;
mod clusters;
mod groups;
mod joined;
mod outside;
#[cfg(test)]
pub(crate) mod tests;

pub use azulejo_factors::GroupBy;
pub use cells::CellMesh;
pub use clusters::{ClusterError, ClusterOptions};
pub use groups::{Groups, unique};

use azulejo_factors::form_factors::{PreparedPlan, RowRemainder, SkyFactors};
use azulejo_factors::hierarchy::FactorOperator;
use azulejo_factors::{FaceId, FormFactors};
use azulejo_scene::{MaterialId, Rgb, Scene, Up, Zone};
use std::sync::Arc;

/// Form factors and what is known of their rows, without the scene that they come from.
#[derive(Clone, Debug, Default)]
pub struct Enclosure {
    /// The matrix, and what is known of its rows.
    pub factors: FormFactors,
    /// The matrix where it is not the `exchange` of `factors`, which then has no rows, but in blocks or
    /// wherever else. What needs single pairs, such as groups and files of other programs, is for whole
    /// matrices.
    pub elsewhere: Option<Arc<dyn FactorOperator>>,
    /// Its rows.
    pub rows: RowTable,
    /// Light from outside (sun, sky, pictures of the surroundings) on each row; `None` if there is
    /// none.
    pub outside: Option<Vec<OutsideLight>>,
    /// What rows see of the patches of the sky, if it was asked for.
    pub sky: Option<SkyFactors>,
}

/// Light on a row from outside, straight and by way of one flat mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutsideLight {
    /// Mean irradiance, W/m² per channel.
    pub irradiance: Rgb,
    /// Its standard error.
    pub error: Rgb,
}

/// What is known of the rows of a matrix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowTable {
    /// A name for each row, all different: of its group, or `object/face`, with the patch's number
    /// within its face if there are several, and `(back)` for backs.
    pub names: Vec<String>,
    /// Whether rows are groups of patches.
    pub are_groups: bool,
    /// Names of the objects that [`FormFactors::faces`] counts; not empty, need not differ.
    pub objects: Vec<String>,
    /// Names of the materials that [`FormFactors::materials`] counts; not empty, need not differ.
    pub materials: Vec<String>,
    /// The zone of each object, where the model has zones; else empty.
    pub zones: Vec<Option<Arc<Zone>>>,
    /// Diffuse reflectance of each row, 0..1 per channel; means by area for groups.
    pub diffuse: Vec<Rgb>,
    /// The polygons that rows consist of.
    pub cells: CellMesh,
    /// Length of a unit in metres; `None` if unknown.
    pub metres_per_unit: Option<f64>,
    /// The axis that points away from the ground.
    pub up: Up,
    /// The faces of which groups have patches, each with its group, in order; a face is listed once
    /// for each of its groups. Empty if rows are patches, or it is not known.
    pub grouped_faces: Vec<(FaceId, u32)>,
}

impl Enclosure {
    /// Describes the rows of a matrix that was computed from `plan` for `scene`. Its rows must be
    /// those of the plan: neither grouped nor reordered.
    ///
    /// # Panics
    /// If the matrix has another number of rows than the plan.
    pub fn new(plan: &PreparedPlan, scene: &Scene, factors: FormFactors) -> Enclosure {
        assert_eq!(plan.rows(), factors.len(), "the rows of the plan");
        let named = |kind: &str, i: usize, name: &str| match name {
            "" => format!("{kind} {i}"),
            name => name.to_owned(),
        };
        let objects = scene.objects.iter().enumerate();
        let materials = scene.materials.iter().enumerate();
        let diffuse = |&m: &MaterialId| scene.materials[m as usize].diffuse;
        let mut rows = RowTable {
            names: Vec::new(),
            are_groups: false,
            objects: objects.map(|(i, o)| named("object", i, &o.name)).collect(),
            materials: materials
                .map(|(i, m)| named("material", i, &m.name))
                .collect(),
            zones: if scene.objects.iter().any(|o| o.zone.is_some()) {
                scene.objects.iter().map(|o| o.zone.clone()).collect()
            } else {
                Vec::new()
            },
            diffuse: factors.materials.iter().map(diffuse).collect(),
            cells: CellMesh::new((0..plan.rows()).map(|i| plan.outline(i))),
            metres_per_unit: scene.units.metres_per_unit,
            up: scene.units.up,
            grouped_faces: Vec::new(),
        };
        rows.names = rows.patch_names(&factors);
        Enclosure {
            factors,
            elsewhere: None,
            rows,
            outside: None,
            sky: None,
        }
    }

    /// The matrix, wherever it is.
    pub fn operator(&self) -> &dyn FactorOperator {
        self.elsewhere.as_deref().unwrap_or(&self.factors)
    }

    /// Σ_j X_ij of each row, as [`FormFactors::row_sums`].
    pub fn row_sums(&self) -> Vec<f64> {
        match &self.elsewhere {
            None => self.factors.row_sums(),
            Some(matrix) => matrix.sums(),
        }
    }

    /// What each row lacks of 1, as [`FormFactors::residuals`].
    pub fn residuals(&self) -> Vec<f64> {
        if self.elsewhere.is_none() {
            return self.factors.residuals();
        }
        let ended = self.operator().apply(&self.factors.ends);
        let residual = |(ended, rest): (f64, &RowRemainder)| {
            if ended > 0.0 {
                1.0 - ended - rest.sum()
            } else {
                0.0
            }
        };
        ended
            .into_iter()
            .zip(&self.factors.rest)
            .map(residual)
            .collect()
    }

    /// Standard error of the sum of each row, as [`FormFactors::noise_of_sums`].
    pub fn noise_of_sums(&self) -> Vec<f64> {
        if self.elsewhere.is_none() {
            return self.factors.noise_of_sums();
        }
        let variances = self.operator().variance_lanes(&vec![1.0; self.len()], 1);
        let rows = variances.iter().zip(&self.factors.areas);
        rows.map(|(v, &a)| if a > 0.0 { v.max(0.0).sqrt() / a } else { 0.0 })
            .collect()
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.factors.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.factors.is_empty()
    }

    /// Mirror reflectance ρ_s of each row with which its factors were computed, 0..1.
    pub fn mirror_reflectances(&self) -> Vec<f64> {
        self.factors.ends.iter().map(|end| 1.0 - end).collect()
    }

    /// Share of the light on each row that its material absorbs, the mean of the channels, 0..1.
    pub fn absorptances(&self) -> Vec<f64> {
        let rows = self.rows.diffuse.iter().zip(&self.factors.ends);
        rows.map(|(diffuse, ends)| (ends - diffuse.mean()).max(0.0))
            .collect()
    }

    /// Length of a unit in metres; 1 if unknown.
    pub fn metres_per_unit(&self) -> f64 {
        self.rows.metres_per_unit.unwrap_or(1.0)
    }
}

impl RowTable {
    /// The name of the object of a face.
    pub fn object(&self, face: FaceId) -> &str {
        &self.objects[face.object as usize]
    }

    /// The zone of a face; `None` if it is in none, or it is not known.
    pub fn zone(&self, face: FaceId) -> Option<&Arc<Zone>> {
        self.zones.get(face.object as usize)?.as_ref()
    }

    /// Names of patches: `object/face`, with the number of the patch where a face has several.
    fn patch_names(&self, factors: &FormFactors) -> Vec<String> {
        let key = |i: usize| (factors.faces[i], factors.is_back[i]);
        let mut counts = std::collections::HashMap::new();
        (0..factors.len()).for_each(|i| *counts.entry(key(i)).or_insert(0usize) += 1);
        let mut seen = std::collections::HashMap::new();
        let name = |i: usize| {
            let (face, is_back) = key(i);
            let place = seen.entry(key(i)).or_insert(0usize);
            *place += 1;
            let mut name = format!("{}/{}", self.object(face), face.face);
            if counts[&key(i)] > 1 {
                name += &format!(".{}", *place - 1);
            }
            if is_back {
                name += " (back)";
            }
            name
        };
        unique((0..factors.len()).map(name).collect())
    }
}

/// The entry of a column in a row with ascending columns, or zeros.
pub(crate) fn entry_of(row: &[(u32, f64, f32)], column: u32) -> (u32, f64, f32) {
    let position = row.binary_search_by_key(&column, |&(j, ..)| j);
    position.map_or((column, 0.0, 0.0), |k| row[k])
}
