//! One face of a hemicube, or its part within a window: the parameters for the card, and the facets
//! to draw.

use crate::atlas::{Atlas, Rectangle};
use crate::mesh::{Cone, Mesh};
use azulejo_trace::item_buffer::HemicubeView;
use std::ops::Range;

/// Words of `Face` in draw.wgsl.
pub const WORDS: usize = 36;

/// Facets nearer to the viewpoint than this along a face's axis are clipped; in local coordinates,
/// below the rounding of single precision.
const NEAREST: f32 = 1e-8;

/// A face, or a part of one, to be drawn.
pub struct FaceDrawing {
    /// `Face` in draw.wgsl.
    pub words: [u32; WORDS],
    pub viewport: Rectangle,
    pub scissor: Rectangle,
    /// Ranges of facets that may be visible in it.
    pub facets: Vec<Range<u32>>,
}

/// A range of columns and rows of a face.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaceRegion {
    pub columns: Range<u32>,
    pub rows: Range<u32>,
}

impl FaceRegion {
    /// An empty range.
    pub const EMPTY: FaceRegion = FaceRegion {
        columns: Range {
            start: u32::MAX,
            end: 0,
        },
        rows: Range {
            start: u32::MAX,
            end: 0,
        },
    };

    /// All columns and rows of a face.
    pub fn whole(resolution: u32, face: usize) -> FaceRegion {
        FaceRegion {
            columns: 0..resolution,
            rows: 0..if face == 0 {
                resolution
            } else {
                resolution / 2
            },
        }
    }

    /// Grows to include a pixel.
    pub fn add(&mut self, column: u32, row: u32) {
        let grow = |range: &mut Range<u32>, k: u32| {
            *range = range.start.min(k)..range.end.max(k + 1);
        };
        grow(&mut self.columns, column);
        grow(&mut self.rows, row);
    }
}

/// A part of a face of `view`. `window` is its number in the atlas.
pub fn face_drawing(
    mesh: &Mesh,
    atlas: &Atlas,
    view: &HemicubeView,
    (tile, face): (u32, usize),
    region: &FaceRegion,
    window: u32,
) -> FaceDrawing {
    let axes = view.face_axes(face);
    let is_top = face == 0;
    let viewport = atlas.face(tile, face);
    let [left, top, ..] = viewport;
    // Edges of pixels, as u and v.
    let scale = 2.0 / f64::from(atlas.resolution);
    let low = if is_top { -1.0 } else { 0.0 };
    let u = |column: u32| scale * f64::from(column) - 1.0;
    let v = |row: u32| scale * f64::from(row) + low;
    let borders = [
        u(region.columns.start),
        u(region.columns.end),
        v(region.rows.start),
        v(region.rows.end),
    ];
    let cone = Cone::new(view.eye, &axes, borders, view.begin.as_ref());
    let eye = view.eye.as_vec3();
    let rest = (view.eye - eye.as_dvec3()).as_vec3();
    let begin = view.begin_nearness(&axes);
    let [x, y, w] = axes.map(|a| a.as_vec3());
    // Without a mirror the world begins at the viewpoint.
    let [a, b, c] = begin.map_or([0.0, 0.0, f32::MAX], |b| b.map(|x| x as f32));
    // Rows increase downwards in the texture, y upwards in clip space.
    let rows = if is_top { [0.0, -1.0] } else { [1.0, -2.0] };
    let numbers = [
        [eye.x, eye.y, eye.z, 0.0],
        [rest.x, rest.y, rest.z, 0.0],
        [x.x, x.y, x.z, 0.0],
        [y.x, y.y, y.z, 0.0],
        [w.x, w.y, w.z, 0.0],
        [a, b, c, 0.0],
        [left as f32, top as f32, scale as f32, low as f32],
        [rows[0], rows[1], NEAREST, NEAREST],
    ];
    let mut words = [0; WORDS];
    for (word, number) in words.iter_mut().zip(numbers.as_flattened()) {
        *word = number.to_bits();
    }
    words[32..34].copy_from_slice(&[window, view.mirror]);
    FaceDrawing {
        words,
        viewport,
        scissor: [
            left + region.columns.start,
            top + region.rows.start,
            region.columns.len() as u32,
            region.rows.len() as u32,
        ],
        facets: mesh.in_cone(&cone),
    }
}
