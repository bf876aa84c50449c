//! Mirrors of a table put into a scene, before its factors are computed.

use super::{MaterialTable, Properties, TableError};
use azulejo_scene::{Material, MaterialId, Rgb, Scene, Shape};
use std::collections::HashMap;

impl MaterialTable {
    /// Gives the surfaces of a scene the reflectances of a record in one band, and nothing else: they are
    /// opaque, do not shine and have no reflection model. Faces with different records have different
    /// materials afterwards, with the names they had. Meshes are no longer shared.
    ///
    /// # Errors
    /// The names of objects that have no record.
    ///
    /// # Panics
    /// If there is no such band.
    pub fn paint(&self, scene: &mut Scene, band: usize) -> Result<(), TableError> {
        // Objects that share a mesh may have different records.
        scene.unfold();
        let records = &self.bands[band].records;
        // Make one new material for each old one with each of its records.
        let old = std::mem::take(&mut scene.materials);
        let mut painter = Painter {
            records,
            old: &old,
            new: Vec::new(),
            known: HashMap::new(),
        };
        let mut missing = std::collections::BTreeSet::new();
        for object in &mut scene.objects {
            let name = &object.name;
            let mut material = |face: Option<usize>, id: MaterialId| {
                // The name of a face counts before that of its object, and this before that of the material.
                let mut names: Vec<String> = Vec::new();
                names.extend(face.map(|face| format!("{name}/{face}")));
                names.extend([name.clone(), old[id as usize].name.clone()]);
                match self.names.record(&names) {
                    Some(record) => painter.paint(id, record),
                    None => {
                        missing.insert(name.clone());
                        0
                    }
                }
            };
            match &mut object.shape {
                Shape::Mesh(mesh) => {
                    let faces = mesh.face_materials.iter_mut().enumerate();
                    faces.for_each(|(face, id)| *id = material(Some(face), *id));
                }
                Shape::Primitive(primitive) => {
                    primitive.material = material(None, primitive.material)
                }
                Shape::Exact(exact) => exact.map_materials(&mut |id| material(None, id)),
                Shape::Instance(_) => {}
            }
        }
        scene.materials = painter.new;
        // Name all objects without a record together.
        if missing.is_empty() {
            return Ok(());
        }
        Err(TableError::without_record(&missing, "the emissivity"))
    }

    /// Whether surfaces reflect the same share as mirrors in all bands.
    pub fn has_same_mirrors(&self) -> bool {
        self.mirror_sets().len() == 1
    }

    /// The first band of each set of mirror reflectances: the bands whose factors have to be computed.
    pub fn mirror_sets(&self) -> Vec<usize> {
        let mirrors = |band: usize| self.bands[band].records.iter().map(|p| p.mirror);
        let mut sets: Vec<usize> = Vec::new();
        for band in 0..self.bands.len() {
            if !sets.iter().any(|&of| mirrors(of).eq(mirrors(band))) {
                sets.push(band);
            }
        }
        sets
    }
}

/// Materials of records, each made once.
struct Painter<'a> {
    records: &'a [Properties],
    old: &'a [Material],
    new: Vec<Material>,
    known: HashMap<(MaterialId, usize), MaterialId>,
}

impl Painter<'_> {
    fn paint(&mut self, id: MaterialId, record: usize) -> MaterialId {
        let (new, old, records) = (&mut self.new, self.old, self.records);
        *self.known.entry((id, record)).or_insert_with(|| {
            let Properties { emissivity, mirror } = records[record];
            let diffuse = (1.0 - emissivity - mirror).max(0.0);
            let mut material = Material::diffuse(&old[id as usize].name, Rgb::grey(diffuse));
            material.mirror = Rgb::grey(mirror);
            new.push(material);
            new.len() as MaterialId - 1
        })
    }
}
