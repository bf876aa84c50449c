//! A drawing as it stands in its file: layers, and blocks with their surfaces in the blocks'
//! own coordinates, nothing of it placed yet.

use super::color::{Color, FOREGROUND, Paint};
use super::ids::{AppearanceId, BlockId, LayerId};
use super::surfaces::Surfaces;
use azulejo_scene::{Camera, Light};
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// One file.
#[derive(Debug)]
pub(super) struct DxfDrawing {
    /// Its name.
    pub file: String,
    /// Metres per unit, if the file says so.
    pub metres_per_unit: Option<f64>,
    /// Layers, in the order in which they are first named.
    pub layers: Vec<Layer>,
    /// What entities look like.
    pub appearances: Vec<Appearance>,
    /// The model space, and the blocks in the order in which they are first named.
    pub blocks: Vec<DxfBlock>,
    /// MATERIALs by their handles.
    pub finishes: HashMap<u64, Finish>,
    /// Views in perspective.
    pub cameras: Vec<Camera>,
}

/// A layer.
#[derive(Debug)]
pub(super) struct Layer {
    /// Its name; `0` is the one that stands in for another inside of blocks.
    pub name: String,
    /// The colour of what is drawn on it in the layer's colour.
    pub paint: Paint,
    /// Handle of its MATERIAL, or 0.
    pub finish: u64,
    /// Hidden; blocks that are placed on it show what they have on other layers.
    pub is_off: bool,
    /// Hidden, with all that is in blocks placed on it.
    pub is_frozen: bool,
}

impl Layer {
    /// A layer that nobody has described.
    pub fn new(name: String) -> Layer {
        Layer {
            name,
            paint: FOREGROUND,
            finish: 0,
            is_off: false,
            is_frozen: false,
        }
    }

    /// Whether entities on it stand on the layer of their block's INSERT.
    pub fn is_zero(&self) -> bool {
        self.name == "0"
    }
}

/// What decides the material of an entity.
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
    /// That of the INSERT which places the entity's block.
    ByBlock,
    /// The drawing's default: the colour alone counts.
    Plain,
    /// A described one.
    Described {
        /// Its name.
        name: String,
        /// Its own colour, if it has one and not that of the entity.
        paint: Option<Paint>,
        /// Multiplies the colour, 0..=1.
        factor: f64,
        /// Index of refraction, if one can see through it.
        ior: Option<f64>,
    },
}

/// What a block holds.
#[derive(Debug, Default)]
pub(super) struct DxfBlock {
    /// Its name; the model space and anonymous blocks have none.
    pub name: String,
    /// The point that an INSERT places.
    pub base: DVec3,
    /// Whether its definition has been read.
    pub is_defined: bool,
    /// The file that holds its content, if it is an external reference.
    pub external: Option<String>,
    /// Its surfaces.
    pub surfaces: Surfaces,
    /// Its lights, with the layer of each.
    pub lights: Vec<(LayerId, Light)>,
    /// The blocks placed in it.
    pub inserts: Vec<Insert>,
}

/// A block placed once, or in rows and columns.
#[derive(Debug)]
pub(super) struct Insert {
    /// Which block.
    pub block: BlockId,
    /// What its parts look like that leave it to the INSERT.
    pub appearance: AppearanceId,
    /// Turns and scales the block.
    pub matrix: DMat3,
    /// Where the block's base point goes.
    pub origin: DVec3,
    /// From one column to the next.
    pub column_step: DVec3,
    /// From one row to the next.
    pub row_step: DVec3,
    /// Number of columns, 1 or more.
    pub columns: u32,
    /// Number of rows, 1 or more.
    pub rows: u32,
    /// Where it stands in the file.
    pub offset: usize,
    /// Whether its block cannot be placed.
    pub is_refused: bool,
}

impl Insert {
    /// How many times the block is placed.
    pub fn count(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }
}
