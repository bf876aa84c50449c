//! Rows combined into groups.

use super::{CellMesh, Enclosure, OutsideLight, RowTable};
use azulejo_factors::form_factors::SkyFactors;
use azulejo_factors::{FaceId, FormFactors, GroupBy, hierarchy};
use azulejo_scene::Rgb;
use azulejo_trace::{Cancelled, Progress};
use std::collections::HashMap;

/// A group for each row, and a name for each group.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Groups {
    /// The group of each row; rows without one are dropped.
    pub of_rows: Vec<Option<u32>>,
    /// The name of each group.
    pub names: Vec<String>,
}

impl Enclosure {
    /// The groups of all rows, numbered by first appearance. Back sides are groups of their own.
    pub fn groups(&self, by: GroupBy) -> Groups {
        let (factors, rows) = (&self.factors, &self.rows);
        let name = |i: usize| {
            let face = factors.faces[i];
            match by {
                GroupBy::Face => format!("{}/{}", rows.object(face), face.face),
                GroupBy::Object => rows.object(face).to_owned(),
                GroupBy::Material => rows.materials[factors.materials[i] as usize].clone(),
            }
        };
        let key = |i: usize| by.key(factors.faces[i], factors.materials[i]);
        let (mut numbers, mut names) = (HashMap::new(), Vec::new());
        let group = |i: usize| {
            let is_back = factors.is_back[i];
            let number = numbers.entry((key(i), is_back)).or_insert_with(|| {
                names.push(name(i) + if is_back { " (back)" } else { "" });
                names.len() as u32 - 1
            });
            Some(*number)
        };
        let of_rows = (0..self.len()).map(group).collect();
        Groups {
            of_rows,
            names: unique(names),
        }
    }

    /// The enclosure between groups of rows: see [`FormFactors::grouped`](azulejo_factors::FormFactors::grouped).
    ///
    /// # Panics
    /// If there is not one group for each row, or a group without a name.
    pub fn grouped(&self, groups: &Groups) -> Enclosure {
        Enclosure {
            factors: self.factors.grouped(&groups.of_rows, groups.names.len()),
            rows: self.rows.grouped(groups, &self.factors),
            outside: self.mean_outside(groups),
            sky: self.mean_sky(groups),
            elsewhere: None,
        }
    }

    /// The same, wherever the matrix is: see [`hierarchy::grouped`].
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// As [`grouped`](Enclosure::grouped).
    pub fn gathered(&self, groups: &Groups, progress: &Progress) -> Result<Enclosure, Cancelled> {
        let Some(matrix) = &self.elsewhere else {
            return Ok(self.grouped(groups));
        };
        let (of_rows, count) = (&groups.of_rows, groups.names.len());
        let factors = hierarchy::grouped(&**matrix, &self.factors, of_rows, count, progress)?;
        Ok(Enclosure {
            factors,
            rows: self.rows.grouped(groups, &self.factors),
            outside: self.mean_outside(groups),
            sky: self.mean_sky(groups),
            elsewhere: None,
        })
    }

    /// Light from outside on each group; `None` if there is none.
    pub fn mean_outside(&self, groups: &Groups) -> Option<Vec<OutsideLight>> {
        let rows = self.outside.as_ref()?;
        let count = groups.names.len();
        Some(mean_light(
            rows,
            &self.factors.areas,
            &groups.of_rows,
            count,
        ))
    }
}

impl Enclosure {
    /// What each group sees of the patches of the sky.
    fn mean_sky(&self, groups: &Groups) -> Option<SkyFactors> {
        let sky = self.sky.as_ref()?;
        Some(sky.grouped(&self.factors.areas, &groups.of_rows, groups.names.len()))
    }
}

impl RowTable {
    fn grouped(&self, groups: &Groups, factors: &FormFactors) -> RowTable {
        let areas = &factors.areas;
        let mut diffuse = vec![(Rgb::BLACK, 0.0); groups.names.len()];
        for ((value, area), group) in self.diffuse.iter().zip(areas).zip(&groups.of_rows) {
            if let Some(group) = group {
                let (sum, whole) = &mut diffuse[*group as usize];
                *sum += *value * *area;
                *whole += area;
            }
        }
        let mean = |(sum, whole): (Rgb, f64)| sum / whole.max(f64::MIN_POSITIVE);
        RowTable {
            names: groups.names.clone(),
            are_groups: true,
            objects: self.objects.clone(),
            materials: self.materials.clone(),
            zones: self.zones.clone(),
            diffuse: diffuse.into_iter().map(mean).collect(),
            cells: self.cells.grouped(&groups.of_rows),
            metres_per_unit: self.metres_per_unit,
            up: self.up,
            grouped_faces: self.faces_of(groups, factors),
        }
    }

    fn faces_of(&self, groups: &Groups, factors: &FormFactors) -> Vec<(FaceId, u32)> {
        let group = |row: usize| *groups.of_rows.get(row)?;
        let patch = |(row, &face)| Some((face, group(row)?));
        let grouped = |&(face, row): &(FaceId, u32)| Some((face, group(row as usize)?));
        let mut faces: Vec<(FaceId, u32)> = if self.are_groups {
            self.grouped_faces.iter().filter_map(grouped).collect()
        } else {
            let faces = factors.faces.iter().enumerate();
            faces.filter_map(patch).collect()
        };
        faces.sort_unstable();
        faces.dedup();
        faces
    }
}

impl CellMesh {
    /// The cells of rows that have a group, as cells of that group.
    fn grouped(&self, groups: &[Option<u32>]) -> CellMesh {
        let mut mesh = CellMesh {
            points: self.points.clone(),
            starts: vec![0],
            ..CellMesh::default()
        };
        for (i, &row) in self.rows.iter().enumerate() {
            if let Some(group) = groups[row as usize] {
                mesh.corners.extend(self.cell(i));
                mesh.starts.push(mesh.corners.len() as u32);
                mesh.rows.push(group);
            }
        }
        mesh
    }
}

/// Means over groups of rows, by area. The positions at which rows were lit are independent, and so
/// are their errors.
fn mean_light(
    rows: &[OutsideLight],
    areas: &[f64],
    groups: &[Option<u32>],
    count: usize,
) -> Vec<OutsideLight> {
    let mut sums = vec![(0.0, OutsideLight::default()); count];
    for ((row, &area), group) in rows.iter().zip(areas).zip(groups) {
        if let Some(group) = group {
            let (whole, sum) = &mut sums[*group as usize];
            *whole += area;
            sum.irradiance += row.irradiance * area;
            sum.error += row.error * row.error * (area * area);
        }
    }
    let mean = |(whole, sum): (f64, OutsideLight)| {
        let whole = whole.max(f64::MIN_POSITIVE);
        OutsideLight {
            irradiance: sum.irradiance / whole,
            error: sum.error.map(f64::sqrt) / whole,
        }
    };
    sums.into_iter().map(mean).collect()
}

/// Makes names unique by appending the row's number to duplicates.
pub fn unique(names: Vec<String>) -> Vec<String> {
    let mut uses: HashMap<&str, usize> = HashMap::new();
    for name in &names {
        *uses.entry(name).or_default() += 1;
    }
    let is_shared: Vec<bool> = names.iter().map(|n| uses[n.as_str()] > 1).collect();
    let rows = names.into_iter().zip(is_shared).enumerate();
    rows.map(|(i, (name, is_shared))| {
        if is_shared {
            format!("{name} #{i}")
        } else {
            name
        }
    })
    .collect()
}
