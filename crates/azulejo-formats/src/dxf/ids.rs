//! Indices that blocks, layers and appearances of a drawing have.

/// Index of a layer in `DxfDrawing::layers`.
pub(super) type LayerId = u32;

/// Index of an appearance in `DxfDrawing::appearances`. The meshes of a block carry it in place of materials.
pub(super) type AppearanceId = u32;

/// Index of a block in `DxfDrawing::blocks`.
pub(super) type BlockId = u32;

/// The block that is the drawing itself.
pub(super) const MODEL_SPACE: BlockId = 0;
