//! Indices of blocks, layers and appearances of a drawing.

/// Index of a layer in `DxfDrawing::layers`.
pub(super) type LayerId = u32;

/// Index of an appearance in `DxfDrawing::appearances`, used by meshes of a block as material index.
pub(super) type AppearanceId = u32;

/// Index of a block in `DxfDrawing::blocks`.
pub(super) type BlockId = u32;

/// The model space, which is the drawing itself.
pub(super) const MODEL_SPACE: BlockId = 0;
