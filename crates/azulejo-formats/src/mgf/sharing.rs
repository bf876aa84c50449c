//! Meshes that arrays and included files repeat: stored once, and placed for each instance.
//!
//! The content of an array is read again for each of its instances, since definitions in it may change
//! what the next one is. Its meshes are built in the coordinates of the content, where all instances are
//! equal to the last bit, and become instances of one mesh where they are ([`repeated`]).
//!
//! [`repeated`]: crate::surface::repeated

use crate::surface::repeated::TextAddress;
use glam::DAffine3;

/// Coordinates in which meshes are built: the world, and inside it those of the content of each open
/// instance of an array or file.
#[derive(Debug)]
pub(super) struct ContentFrames {
    /// The world, then one frame inside the other.
    frames: Vec<ContentFrame>,
}

/// The coordinates of an array's or file's content, in one instance.
#[derive(Clone, Copy, Debug)]
struct ContentFrame {
    outer_from_frame: DAffine3,
    world_from_frame: DAffine3,
}

/// Index of a frame among [`ContentFrames`].
pub(super) type FrameId = usize;

/// The coordinates of the world.
pub(super) const WORLD: FrameId = 0;

impl ContentFrames {
    /// Only the world.
    pub fn new() -> ContentFrames {
        let world = ContentFrame {
            outer_from_frame: DAffine3::IDENTITY,
            world_from_frame: DAffine3::IDENTITY,
        };
        ContentFrames {
            frames: vec![world],
        }
    }

    /// Begins a frame inside `outer`, and ends those that were there; `None` if no mesh can be placed by
    /// its map, which flattens or overflows.
    pub fn enter(
        &mut self,
        outer: FrameId,
        outer_from_frame: DAffine3,
        world_from_frame: DAffine3,
    ) -> Option<FrameId> {
        let size = world_from_frame.matrix3.determinant();
        let is_usable = size != 0.0 && size.is_finite() && world_from_frame.is_finite();
        if !is_usable || !outer_from_frame.is_finite() {
            return None;
        }
        self.frames.truncate(outer + 1);
        self.frames.push(ContentFrame {
            outer_from_frame,
            world_from_frame,
        });
        Some(self.frames.len() - 1)
    }

    /// The map of a frame to the world.
    pub fn world_from(&self, frame: FrameId) -> DAffine3 {
        self.frames[frame].world_from_frame
    }

    /// The map from a frame to one that it is in.
    pub fn outer_from(&self, outer: FrameId, frame: FrameId) -> DAffine3 {
        let between = self.frames[outer + 1..=frame].iter();
        between.fold(DAffine3::IDENTITY, |map, f| map * f.outer_from_frame)
    }
}

/// Which statement made a mesh that others may be equal to, and the place of this one.
#[derive(Clone, Copy, Debug)]
pub(super) struct RepeatedOrigin {
    pub statement: TextAddress,
    pub world_from_frame: DAffine3,
}
