//! Receivers with the place of their triangles in a lightmap.

use crate::Receiver;
use crate::layout::Layout;

/// The surfaces of a lightmap, and where they lie in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Atlas {
    /// The surfaces.
    pub receivers: Vec<Receiver>,
    /// Where their triangles lie.
    pub layout: Layout,
    /// Of each chart whether its back receives; empty if none does.
    pub turned: Vec<bool>,
}

impl Atlas {
    /// Whether a chart receives on its back.
    pub fn is_turned(&self, chart: u32) -> bool {
        self.turned.get(chart as usize).copied().unwrap_or(false)
    }
}
