//! Parses chunks into lists of the file's content.

use super::MAIN;
use super::chunk::{Chunk, ChunkWalker, name, vector};
use super::keyframer::{self, KeyframerNode};
use super::material::MaterialDefinition;
use crate::reading::bytes::Bytes;
use crate::reading::warnings::Warnings;
use crate::surface::gloss::Gloss;
use azulejo_scene::Rgb;
use glam::DVec3;

/// The content of a file, before objects are placed.
#[derive(Debug, Default)]
pub(super) struct Studio3dsModel<'a> {
    pub materials: Vec<MaterialDefinition>,
    pub meshes: Vec<RawMesh<'a>>,
    pub lights: Vec<RawLight>,
    pub cameras: Vec<RawCamera>,
    pub nodes: Vec<KeyframerNode>,
    pub background: Option<Rgb>,
}

/// A mesh whose lists are still bytes.
#[derive(Debug, Default)]
pub(super) struct RawMesh<'a> {
    pub name: String,
    pub at: u64,
    /// 12 bytes each.
    pub vertices: &'a [u8],
    /// 8 bytes each.
    pub uvs: &'a [u8],
    /// 8 bytes each.
    pub faces: &'a [u8],
    /// 4 bytes for each face.
    pub smoothing: &'a [u8],
    pub face_materials: Vec<MaterialFaces<'a>>,
    /// Three axes and an origin.
    pub frame: Option<[f64; 12]>,
}

/// The faces of one material.
#[derive(Debug)]
pub(super) struct MaterialFaces<'a> {
    pub material: String,
    /// 2 bytes each.
    pub faces: &'a [u8],
    pub at: u64,
}

/// A light.
#[derive(Debug)]
pub(super) struct RawLight {
    pub name: String,
    pub position: DVec3,
    pub intensity: Rgb,
    pub spot: Option<SpotCone>,
}

/// The cone of a spotlight.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpotCone {
    pub target: DVec3,
    /// Full angle of full intensity, degrees.
    pub hot_spot: f64,
    /// Full angle beyond which the intensity is zero, degrees.
    pub fall_off: f64,
}

/// A camera.
#[derive(Debug)]
pub(super) struct RawCamera {
    pub name: String,
    pub at: u64,
    pub position: DVec3,
    pub target: DVec3,
    /// Degrees, clockwise.
    pub bank: f64,
    /// Focal length, millimetres.
    pub lens: f64,
}

pub(super) struct Studio3dsParser<'a, 'w> {
    walker: ChunkWalker<'w>,
    model: Studio3dsModel<'a>,
}

impl<'a, 'w> Studio3dsParser<'a, 'w> {
    /// A parser in its initial state. `file` is the file's name in messages.
    pub fn new(file: &'w str) -> Studio3dsParser<'a, 'w> {
        Studio3dsParser {
            walker: ChunkWalker {
                file,
                warnings: Warnings::default(),
                gloss: Gloss::default(),
            },
            model: Studio3dsModel::default(),
        }
    }

    /// The content and the collected warnings.
    pub fn finish(self) -> (Studio3dsModel<'a>, ChunkWalker<'w>) {
        (self.model, self.walker)
    }

    /// Reads a whole file.
    pub fn file(&mut self, mut bytes: Bytes<'a>) {
        let Some(main) = self.walker.next(&mut bytes) else {
            return;
        };
        if bytes.left() > 0 {
            let message = format!("{} bytes after the model: skipped", bytes.left());
            self.walker.warn(bytes.offset(), message);
        }
        debug_assert_eq!(main.id, MAIN);
        let mut body = main.body;
        while let Some(chunk) = self.walker.next(&mut body) {
            match chunk.id {
                // Versions are redundant.
                0x0002 | 0x0001 => {}
                0x3d3d => self.editor(chunk),
                0xb000 => {
                    let nodes = keyframer::read(&mut self.walker, &chunk);
                    self.model.nodes.extend(nodes);
                }
                _ => self.walker.skipped(&chunk, ""),
            }
        }
    }

    fn editor(&mut self, chunk: Chunk<'a>) {
        let (mut background, mut is_used) = (None, false);
        let mut body = chunk.body;
        while let Some(mut chunk) = self.walker.next(&mut body) {
            match chunk.id {
                0xafff => {
                    let definition = MaterialDefinition::read(&mut self.walker, &chunk);
                    if definition.name.is_empty() {
                        self.walker.skipped(&chunk, "material without a name")
                    } else {
                        self.model.materials.push(definition)
                    }
                }
                0x4000 => self.object(chunk),
                0x0100 => self.master_scale(&mut chunk),
                0x1200 => background = self.walker.color(&chunk),
                0x1201 => is_used = true,
                0x2100 => self.ambient_light(&chunk),
                _ => self.setting(&chunk),
            }
        }
        self.model.background = background.filter(|_| is_used).or(self.model.background);
    }

    /// Reads the length of one unit. No chunk states the measure, so it cannot be used.
    fn master_scale(&mut self, chunk: &mut Chunk<'a>) {
        let scale = self.walker.data(chunk, Bytes::f32_le);
        if scale.is_some_and(|s| s != 1.0) {
            let message = "master scale other than 1 (chunk 0100), whose unit is unknown: ignored";
            self.walker.warn(chunk.at, message);
        }
    }

    fn ambient_light(&mut self, chunk: &Chunk<'a>) {
        let color = self.walker.color(chunk);
        if color.is_some_and(|c| !c.is_black()) {
            let what = "ambient light, which approximates light that azulejo computes";
            self.walker.skipped(chunk, what);
        }
    }

    /// Handles settings of the editor, which do not affect the scene, and unsupported settings that
    /// would.
    fn setting(&mut self, chunk: &Chunk<'a>) {
        match chunk.id {
            // Mesh version, construction plane, shadow maps, viewports, and fog and backgrounds
            // without the chunk that enables them.
            0x0001 | 0x3d3e | 0x1400..=0x1500 | 0x3000..=0x3090 | 0x7001..=0x7020 => {}
            0x1100 | 0x1300 | 0x2200 | 0x2300 | 0x2302 => {}
            0x1101 => self.walker.skipped(chunk, "background image"),
            0x1301 => self.walker.skipped(chunk, "background gradient"),
            0x2201 => self.walker.skipped(chunk, "fog"),
            0x2301 => self.walker.skipped(chunk, "layered fog"),
            0x2303 => self.walker.skipped(chunk, "distance cue"),
            _ => self.walker.skipped(chunk, ""),
        }
    }

    /// Reads a named object: a mesh, a light or a camera, with flags.
    fn object(&mut self, mut chunk: Chunk<'a>) {
        let name = name(&mut chunk.body);
        let start = (self.model.meshes.len(), self.model.lights.len());
        let mut is_hidden = false;
        let mut body = chunk.body;
        while let Some(chunk) = self.walker.next(&mut body) {
            match chunk.id {
                0x4010 => is_hidden = true,
                0x4011 | 0x4014 | 0x4016 => {}
                0x4012 => self.walker.skipped(&chunk, "object that casts no shadow"),
                0x4013 => self.walker.skipped(&chunk, "matte object"),
                0x4015 => self.walker.skipped(&chunk, "external process on an object"),
                0x4017 => self
                    .walker
                    .skipped(&chunk, "object that receives no shadow"),
                0x4100 => self.mesh(chunk, name.clone()),
                0x4600 => self.light(chunk, name.clone()),
                0x4700 => self.camera(chunk, name.clone()),
                _ => self.walker.skipped(&chunk, ""),
            }
        }
        if is_hidden && start != (self.model.meshes.len(), self.model.lights.len()) {
            self.walker.warn(chunk.at, "hidden object: skipped");
            self.model.meshes.truncate(start.0);
            self.model.lights.truncate(start.1);
        }
    }

    fn mesh(&mut self, chunk: Chunk<'a>, name: String) {
        let mut mesh = RawMesh {
            name,
            at: chunk.at,
            ..RawMesh::default()
        };
        let mut body = chunk.body;
        while let Some(mut chunk) = self.walker.next(&mut body) {
            match chunk.id {
                0x4110 => mesh.vertices = self.walker.list(&mut chunk, 12, "vertices"),
                0x4120 => self.faces(&mut mesh, chunk),
                0x4140 => mesh.uvs = self.walker.list(&mut chunk, 8, "texture coordinates"),
                0x4160 => mesh.frame = self.walker.data(&mut chunk, vector),
                // Vertex flags and wire colours belong to the editor; texture projections are
                // contained in the texture coordinates.
                0x4111 | 0x4165 | 0x4170 => {}
                0x4181 | 0x4182 => self.walker.skipped(&chunk, "external process on a mesh"),
                _ => self.walker.skipped(&chunk, ""),
            }
        }
        if mesh.faces.is_empty() {
            self.walker.warn(mesh.at, "mesh without faces: skipped")
        } else {
            self.model.meshes.push(mesh)
        }
    }

    fn faces(&mut self, mesh: &mut RawMesh<'a>, mut chunk: Chunk<'a>) {
        mesh.faces = self.walker.list(&mut chunk, 8, "faces");
        let count = mesh.faces.len() / 8;
        let mut body = chunk.body;
        while let Some(mut chunk) = self.walker.next(&mut body) {
            match chunk.id {
                0x4130 => mesh.face_materials.push(MaterialFaces {
                    material: name(&mut chunk.body),
                    faces: self.walker.list(&mut chunk, 2, "faces of a material"),
                    at: chunk.at,
                }),
                0x4150 => {
                    let there = count.min(chunk.body.left() / 4);
                    let message = "smoothing groups missing from a truncated list";
                    self.walker.warn_many(chunk.at, message, count - there);
                    mesh.smoothing = chunk.body.take(4 * there).unwrap_or_default();
                }
                0x4190 => self.walker.skipped(&chunk, "box map of materials"),
                _ => self.walker.skipped(&chunk, ""),
            }
        }
    }

    fn light(&mut self, mut chunk: Chunk<'a>, name: String) {
        let Some(position) = self.walker.data(&mut chunk, vector) else {
            return;
        };
        let mut light = RawLight {
            name,
            position: DVec3::from(position),
            intensity: Rgb::WHITE,
            spot: None,
        };
        let (mut multiplier, mut is_off) = (1.0, false);
        let mut body = chunk.body;
        while let Some(mut entry) = self.walker.next(&mut body) {
            match entry.id {
                0x0010..=0x0013 => {
                    let color = self.walker.color_value(&mut entry);
                    light.intensity = color.unwrap_or(light.intensity);
                }
                0x4610 => light.spot = self.spot(entry),
                0x4620 => is_off = true,
                0x465b => multiplier = self.walker.data(&mut entry, Bytes::f32_le).unwrap_or(1.0),
                // Light falls off with the square of the distance, and every light casts shadows.
                0x4625 => self.walker.skipped(&entry, "range of a light"),
                0x4654 => self.walker.skipped(&entry, "objects excluded from a light"),
                0x4627..=0x4630 | 0x4641 | 0x4658..=0x465a => {}
                _ => self.walker.skipped(&entry, ""),
            }
        }
        light.intensity *= f64::from(multiplier);
        let has_cone = |s: &SpotCone| !s.hot_spot.is_nan() && !s.fall_off.is_nan();
        let is_light = multiplier >= 0.0
            && light.intensity.is_finite()
            && light.position.is_finite()
            && light.spot.as_ref().is_none_or(has_cone);
        if is_off {
            self.walker.warn(chunk.at, "light that is off: skipped");
        } else if !is_light {
            self.walker.warn(
                chunk.at,
                "light with a negative colour or a position that is not finite: skipped",
            );
        } else {
            self.model.lights.push(light);
        }
    }

    fn spot(&mut self, mut chunk: Chunk<'a>) -> Option<SpotCone> {
        let [x, y, z, hot_spot, fall_off] = self.walker.data(&mut chunk, vector)?;
        let mut body = chunk.body;
        while let Some(chunk) = self.walker.next(&mut body) {
            match chunk.id {
                0x4651 => self
                    .walker
                    .skipped(&chunk, "rectangular spotlight, taken as round"),
                0x4652 => self.walker.skipped(&chunk, "overshoot of a spotlight"),
                0x4653 => self
                    .walker
                    .skipped(&chunk, "image projected by a spotlight"),
                // Display of cones, shadow maps, roll and aspect of rectangles.
                0x4630 | 0x4641 | 0x4650 | 0x4656..=0x4658 => {}
                _ => self.walker.skipped(&chunk, ""),
            }
        }
        Some(SpotCone {
            target: DVec3::new(x, y, z),
            hot_spot,
            fall_off,
        })
    }

    fn camera(&mut self, mut chunk: Chunk<'a>, name: String) {
        let Some([px, py, pz, tx, ty, tz, bank, lens]) = self.walker.data(&mut chunk, vector)
        else {
            return;
        };
        self.model.cameras.push(RawCamera {
            name,
            at: chunk.at,
            position: DVec3::new(px, py, pz),
            target: DVec3::new(tx, ty, tz),
            bank,
            lens,
        });
        let mut body = chunk.body;
        while let Some(chunk) = self.walker.next(&mut body) {
            match chunk.id {
                0x4710 => {}
                0x4720 => self
                    .walker
                    .skipped(&chunk, "near and far range of a camera"),
                _ => self.walker.skipped(&chunk, ""),
            }
        }
    }
}
