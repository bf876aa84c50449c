//! The polygons that remain after subtracting subsurfaces from their bases.

use super::document::{SurfaceKind, View3dDocument, View3dSurface};
use crate::surface::cut::{MOST_HOLES, without};
use crate::surface::mean_plane::MeanPlane;
use crate::{Position, ReadError, Warning};
use azulejo_scene::{Material, MaterialId, Mesh, Object, Rgb, Scene, Shape, Units, Up};
use glam::DVec3;
use std::collections::HashMap;

/// A document as polygons that do not overlap, and the rows of View3D's matrix for it.
///
/// Rows are the surfaces S and M in their order, except those that are combined with others.
#[derive(Clone, Debug, Default)]
pub struct View3dModel {
    /// The polygons, z up, without a unit. Surfaces with the same name form one object; the last
    /// object, `obstructions`, is black and contains what only blocks: O, and the areas of M and N.
    pub scene: Scene,
    /// The row of each face of each object; `None` for what only blocks.
    pub rows: Vec<Vec<Option<u32>>>,
    /// The name of each row.
    pub names: Vec<String>,
    /// The emissivity of each row, that of its first part.
    pub emissivities: Vec<f64>,
    /// Rows that are masks.
    pub masks: Vec<CoveringMask>,
    /// Lines of surfaces whose subsurfaces overlap.
    overlaps: Vec<u32>,
}

/// A mask: it sees only what it covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveringMask {
    /// Its row.
    pub row: u32,
    /// The row of the surface that it covers.
    pub covers: u32,
    /// Its area.
    pub area: f64,
}

impl View3dModel {
    /// Subtracts all subsurfaces from their bases. `name` is used in messages.
    ///
    /// # Errors
    /// More than 4,096 surfaces in one base, or too many overlapping ones.
    pub fn new(document: &View3dDocument, name: &str) -> Result<View3dModel, ReadError> {
        let row_of = RowIndices::new(document);
        let mut builder = View3dModelBuilder::default();
        let mut model = View3dModel {
            names: row_of.each(document, |s| s.name.clone()),
            emissivities: row_of.each(document, |s| s.emissivity),
            ..View3dModel::default()
        };
        let mut held: Vec<Vec<usize>> = vec![Vec::new(); document.surfaces.len()];
        for (k, surface) in document.surfaces.iter().enumerate() {
            if surface.base > 0 {
                held[surface.base as usize - 1].push(k);
            }
        }
        for (k, surface) in document.surfaces.iter().enumerate() {
            let corners = document.corners(surface);
            let outline = |&h: &usize| document.corners(&document.surfaces[h]);
            let holes: Vec<Vec<DVec3>> = held[k].iter().map(outline).collect();
            let pieces =
                without(&corners, &holes).ok_or_else(|| too_complex(surface, &holes, name))?;
            if overlap(&corners, &holes, &pieces) {
                model.overlaps.push(surface.line);
            }
            if surface.kind == SurfaceKind::Mask {
                model.masks.push(CoveringMask {
                    row: row_of.rows[k].unwrap_or_default(),
                    covers: row_of.rows[surface.base as usize - 1].unwrap_or_default(),
                    area: MeanPlane::of(&corners).area,
                });
            }
            let row = row_of.rows[k].filter(|_| surface.kind == SurfaceKind::Radiating);
            pieces.iter().for_each(|p| builder.add(surface, row, p));
        }
        (model.scene, model.rows) = builder.finish();
        Ok(model)
    }

    /// A warning about overlapping subsurfaces, if any; `file` is used in the message.
    pub fn warning(&self, file: &str) -> Option<Warning> {
        let message = "surfaces in one base overlap: their common part counts twice";
        self.overlaps.first().map(|&line| Warning {
            file: file.to_owned(),
            position: Position::Line(line, 1),
            message: message.to_owned(),
            count: self.overlaps.len(),
        })
    }
}

/// The error for a surface that is too complex.
fn too_complex(surface: &View3dSurface, holes: &[Vec<DVec3>], name: &str) -> ReadError {
    let found = match holes.len() {
        n if n > MOST_HOLES => format!("{n} surfaces with this one as their base"),
        n => format!("{n} surfaces in one base that overlap too much"),
    };
    let expected = format!("at most {MOST_HOLES}, side by side: divide the base");
    ReadError {
        position: Position::Line(surface.line, 1),
        ..ReadError::whole(name, found, expected)
    }
}

/// Whether the area removed by holes is smaller than their own, by more than rounding and
/// tolerances.
fn overlap(whole: &[DVec3], holes: &[Vec<DVec3>], pieces: &[Vec<DVec3>]) -> bool {
    let area =
        |polygons: &[Vec<DVec3>]| polygons.iter().map(|p| MeanPlane::of(p).area).sum::<f64>();
    let whole = MeanPlane::of(whole).area;
    whole - area(pieces) < area(holes) - 1e-4 * whole
}

/// The row of each surface.
struct RowIndices {
    rows: Vec<Option<u32>>,
    /// The first surface of each row.
    first: Vec<usize>,
}

impl RowIndices {
    fn new(document: &View3dDocument) -> RowIndices {
        let (mut rows, mut first): (Vec<Option<u32>>, Vec<usize>) = Default::default();
        for (k, surface) in document.surfaces.iter().enumerate() {
            let row = match (surface.kind, surface.combined as usize) {
                (SurfaceKind::Null | SurfaceKind::Obstruction, _) => None,
                (_, 0) => {
                    first.push(k);
                    Some(first.len() as u32 - 1)
                }
                (_, root) => rows[root - 1],
            };
            rows.push(row);
        }
        RowIndices { rows, first }
    }

    fn each<T>(&self, document: &View3dDocument, of: impl Fn(&View3dSurface) -> T) -> Vec<T> {
        let surfaces = self.first.iter().map(|&k| &document.surfaces[k]);
        surfaces.map(of).collect()
    }
}

/// The object of surfaces without a name.
const UNNAMED: &str = "surfaces";
/// The object of what only blocks.
const BLOCKING: &str = "obstructions";

#[derive(Default)]
struct View3dModelBuilder {
    scene: Scene,
    rows: Vec<Vec<Option<u32>>>,
    /// Objects by name, and their vertices.
    objects: HashMap<String, usize>,
    meshes: Vec<(String, Mesh)>,
    vertices: Vec<HashMap<[u64; 3], u32>>,
    materials: HashMap<u64, MaterialId>,
    blocking: Vec<Vec<DVec3>>,
}

impl View3dModelBuilder {
    fn add(&mut self, surface: &View3dSurface, row: Option<u32>, corners: &[DVec3]) {
        if row.is_none() {
            self.blocking.push(corners.to_vec());
            return;
        }
        let name = match surface.name.as_str() {
            "" => UNNAMED,
            name => name,
        };
        let material = self.material(surface.emissivity);
        self.add_face(name, row, corners, material);
    }

    /// Grey surfaces reflect what they do not absorb, and absorb as much as they emit (Kirchhoff).
    fn material(&mut self, emissivity: f64) -> MaterialId {
        let scene = &mut self.scene;
        let new = || {
            let name = format!("emissivity {emissivity}");
            scene.add_material(Material::diffuse(name, Rgb::grey(1.0 - emissivity)))
        };
        *self
            .materials
            .entry(emissivity.to_bits())
            .or_insert_with(new)
    }

    fn add_face(&mut self, name: &str, row: Option<u32>, corners: &[DVec3], material: MaterialId) {
        let object = match self.objects.get(name) {
            Some(&object) => object,
            None => {
                self.objects.insert(name.to_owned(), self.meshes.len());
                self.meshes.push((name.to_owned(), Mesh::default()));
                self.vertices.push(HashMap::new());
                self.rows.push(Vec::new());
                self.meshes.len() - 1
            }
        };
        let mesh = &mut self.meshes[object].1;
        let known = &mut self.vertices[object];
        let index = |p: &DVec3| {
            let next = mesh.positions.len() as u32;
            *known
                .entry((*p + DVec3::ZERO).to_array().map(f64::to_bits))
                .or_insert_with(|| {
                    mesh.positions.push(*p);
                    next
                })
        };
        let corners: Vec<u32> = corners.iter().map(index).collect();
        mesh.push_face(&corners, material);
        self.rows[object].push(row);
    }

    fn finish(mut self) -> (Scene, Vec<Vec<Option<u32>>>) {
        if !self.blocking.is_empty() {
            let black = self
                .scene
                .add_material(Material::diffuse("obstruction", Rgb::BLACK));
            // A surface may have the same name; then both form one object, which is harmless.
            for corners in std::mem::take(&mut self.blocking) {
                self.add_face(BLOCKING, None, &corners, black);
            }
        }
        let object = |(name, mesh)| Object::new(name, Shape::Mesh(mesh));
        self.scene.objects = self.meshes.into_iter().map(object).collect();
        self.scene.units = Units {
            up: Up::Z,
            ..Units::default()
        };
        (self.scene, self.rows)
    }
}
