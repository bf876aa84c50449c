//! X3D's sets of triangles and quadrilaterals, with and without an index.

use super::builder::VrmlSceneBuilder;
use super::shape::SurfaceFields;
use super::tree::VrmlNode;
use crate::ReadError;
use std::borrow::Cow;
use std::f64::consts::PI;

/// How corners form faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CornerOrder {
    /// Faces with this many corners each.
    Each(usize),
    /// Triangles around the first corner.
    Fan,
    /// A triangle strip, every second triangle reversed.
    Strip,
}

/// How a node lists its corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleLayout {
    order: CornerOrder,
    /// The field with the index, or for fans and strips without one, the field with their corner
    /// counts.
    list: Option<&'static str>,
    indexed: bool,
}

/// The layout of a node type; `None` if it is not a triangle or quadrilateral set.
pub(super) fn layout(kind: &str) -> Option<TriangleLayout> {
    let (order, list) = match kind {
        "TriangleSet" => (CornerOrder::Each(3), None),
        "QuadSet" => (CornerOrder::Each(4), None),
        "TriangleFanSet" => (CornerOrder::Fan, Some("fanCount")),
        "TriangleStripSet" => (CornerOrder::Strip, Some("stripCount")),
        "IndexedTriangleSet" => (CornerOrder::Each(3), Some("index")),
        "IndexedQuadSet" => (CornerOrder::Each(4), Some("index")),
        "IndexedTriangleFanSet" => (CornerOrder::Fan, Some("index")),
        "IndexedTriangleStripSet" => (CornerOrder::Strip, Some("index")),
        _ => return None,
    };
    Some(TriangleLayout {
        order,
        list,
        indexed: kind.starts_with("Indexed"),
    })
}

/// The polygons of a node.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn surface<'n>(
    builder: &mut VrmlSceneBuilder,
    node: &'n VrmlNode,
    layout: TriangleLayout,
) -> Result<SurfaceFields<'n>, ReadError> {
    let (positions, is_shared) = builder.coordinates(node)?;
    let list = layout.list.map(|field| node.integers(field));
    let list = list.unwrap_or_default();
    // A strip has one triangle per corner, and an index has three corners and an end marker for
    // each of them.
    let most = 4 * if layout.indexed {
        list.len()
    } else {
        positions.len()
    };
    builder.spend(most as u64)?;
    let mut faces = TriangleCorners::default();
    match (layout.order, layout.indexed) {
        (CornerOrder::Each(corners), true) => faces.each(&list, corners),
        (CornerOrder::Each(corners), false) => faces.each(&counting(0, positions.len()), corners),
        (order, true) => {
            for run in list.split(|i| *i < 0) {
                faces.run(run, order);
            }
        }
        (order, false) => faces.counted(&list, positions.len(), order),
    }
    let message = format!(
        "corner of {} after the last complete face: skipped",
        node.kind
    );
    builder.warn_many(&node.source, node.at, message, faces.lost);
    let mut surface = SurfaceFields::new(node, positions, Cow::Owned(faces.coord_index));
    surface.is_shared = is_shared;
    // These nodes have no creaseAngle: faces that share a vertex are smooth.
    let shares = layout.indexed || !matches!(layout.order, CornerOrder::Each(_));
    let smooth = shares && node.flag("normalPerVertex", true);
    surface.crease_angle = if smooth { PI } else { 0.0 };
    builder.attributes(node, &mut surface)?;
    if let Some(colors) = &mut surface.colors {
        // ISO/IEC 19775-1, 11.4: colorPerVertex is ignored and always TRUE.
        colors.binding = super::faces::Binding::PerVertexIndexed;
    }
    Ok(surface)
}

/// The corners read so far.
#[derive(Default)]
struct TriangleCorners {
    coord_index: Vec<i32>,
    /// Number of corners that form no face.
    lost: usize,
}

fn counting(start: usize, count: usize) -> Vec<i32> {
    (start..start + count).map(|i| i as i32).collect()
}

impl TriangleCorners {
    fn push(&mut self, face: &[i32]) {
        self.coord_index.extend_from_slice(face);
        self.coord_index.push(-1);
    }

    /// Faces with a fixed number of corners. The end marker −1 is not allowed here, but common.
    fn each(&mut self, index: &[i32], corners: usize) {
        let index: Vec<i32> = index.iter().copied().filter(|i| *i >= 0).collect();
        let faces = index.chunks_exact(corners);
        self.lost += faces.remainder().len();
        faces.for_each(|face| self.push(face));
    }

    /// A fan or a strip.
    fn run(&mut self, run: &[i32], order: CornerOrder) {
        if run.len() < 3 {
            self.lost += run.len();
        }
        for k in 2..run.len() {
            match order {
                CornerOrder::Fan => self.push(&[run[0], run[k - 1], run[k]]),
                _ if k % 2 == 0 => self.push(&run[k - 2..=k]),
                _ => self.push(&[run[k - 1], run[k - 2], run[k]]),
            }
        }
    }

    /// Fans or strips with the given corner counts, over all positions in their order.
    fn counted(&mut self, counts: &[i32], positions: usize, order: CornerOrder) {
        let mut start = 0;
        for &count in counts {
            let count = usize::try_from(count).unwrap_or(0).min(positions - start);
            self.run(&counting(start, count), order);
            start += count;
        }
        self.lost += positions - start;
    }
}
