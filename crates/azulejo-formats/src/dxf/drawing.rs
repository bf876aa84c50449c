//! The content of a drawing file: layers, and blocks with their surfaces in the blocks'
//! own coordinates, before any INSERT is applied.

use super::color::{Color, FOREGROUND, Paint};
use super::ids::{AppearanceId, BlockId, LayerId};
use super::surfaces::Surfaces;
use azulejo_scene::{Camera, Light};
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// The content of one file.
#[derive(Debug)]
pub(super) struct DxfDrawing {
    /// Its file name.
    pub file: String,
    /// Metres per unit, if the file defines it.
    pub metres_per_unit: Option<f64>,
    /// Layers, in the order in which they are first named.
    pub layers: Vec<Layer>,
    /// Appearances of entities.
    pub appearances: Vec<Appearance>,
    /// The model space, and the blocks in the order in which they are first named.
    pub blocks: Vec<DxfBlock>,
    /// MATERIALs by their handles.
    pub finishes: HashMap<u64, Finish>,
    /// Perspective views.
    pub cameras: Vec<Camera>,
}

/// A layer.
#[derive(Debug)]
pub(super) struct Layer {
    /// Its name; inside blocks, `0` stands for the layer of the INSERT.
    pub name: String,
    /// The colour of entities with colour by layer.
    pub paint: Paint,
    /// Handle of its MATERIAL, or 0.
    pub finish: u64,
    /// Off; blocks inserted on it still show their entities on other layers.
    pub is_off: bool,
    /// Frozen; blocks inserted on it are hidden, too.
    pub is_frozen: bool,
}

impl Layer {
    /// A layer without an entry in the layer table.
    pub fn new(name: String) -> Layer {
        Layer {
            name,
            paint: FOREGROUND,
            finish: 0,
            is_off: false,
            is_frozen: false,
        }
    }

    /// Whether entities on it belong to the layer of their block's INSERT.
    pub fn is_zero(&self) -> bool {
        self.name == "0"
    }
}

/// What determines the material of an entity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Appearance {
    /// Its layer.
    pub layer: LayerId,
    /// Its colour.
    pub color: Color,
    /// Handle of its MATERIAL, or 0 for that of its layer.
    pub finish: u64,
}

/// A MATERIAL.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Finish {
    /// That of the entity's layer.
    ByLayer,
    /// That of the INSERT that instantiates the entity's block.
    ByBlock,
    /// The drawing's default: only the colour matters.
    Plain,
    /// An explicit material.
    Described {
        /// Its name.
        name: String,
        /// Its own colour, unless it uses that of the entity.
        paint: Option<Paint>,
        /// Factor of the colour, 0..=1.
        factor: f64,
        /// Index of refraction, if it is transparent.
        ior: Option<f64>,
    },
}

/// The content of a block.
#[derive(Debug, Default)]
pub(super) struct DxfBlock {
    /// Its name; empty for the model space and anonymous blocks.
    pub name: String,
    /// The base point, which an INSERT moves to its insertion point.
    pub base: DVec3,
    /// Whether its definition has been read.
    pub is_defined: bool,
    /// The file with its content, if it is an external reference.
    pub external: Option<String>,
    /// Its surfaces.
    pub surfaces: Surfaces,
    /// Its lights, with the layer of each.
    pub lights: Vec<(LayerId, Light)>,
    /// The INSERTs in it.
    pub inserts: Vec<Insert>,
}

/// An instance of a block, or an array of instances.
#[derive(Debug)]
pub(super) struct Insert {
    /// The block.
    pub block: BlockId,
    /// Appearance of entities with colour or material by block.
    pub appearance: AppearanceId,
    /// Rotates and scales the block.
    pub matrix: DMat3,
    /// Insertion point of the block's base point.
    pub origin: DVec3,
    /// Offset from one column to the next.
    pub column_step: DVec3,
    /// Offset from one row to the next.
    pub row_step: DVec3,
    /// Number of columns, 1 or more.
    pub columns: u32,
    /// Number of rows, 1 or more.
    pub rows: u32,
    /// Its offset in the file.
    pub offset: usize,
    /// Whether its block cannot be instantiated.
    pub is_refused: bool,
}

impl Insert {
    /// Number of instances.
    pub fn count(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }
}
