//! Charts that are thinner than the texels that they lie in.
//!
//! Such a chart covers a small part of its texels, or nothing that coordinates in single precision can tell from
//! nothing. Widened to one whole texel it has the same light, and viewers find it.

use crate::layout::Layout;
use glam::DVec2;
use std::collections::BTreeSet;

/// Width of charts that are widened, texels.
const THIN: f64 = 0.5;

/// What charts on a page occupy.
#[derive(Clone, Copy)]
struct ChartBox {
    low: DVec2,
    high: DVec2,
    triangles: u32,
}

/// Widens charts on a page that are thinner than half a texel along an axis to the texel in their middle. It is one of
/// those around which the padding is, so that charts come no nearer to one another.
pub(crate) fn widen(layout: &mut Layout, members: &BTreeSet<usize>, page: u32, first_chart: u32) {
    let size = layout.pages[page as usize].map(f64::from);
    let size = DVec2::from_array(size);
    let empty = ChartBox {
        low: DVec2::INFINITY,
        high: DVec2::NEG_INFINITY,
        triangles: 0,
    };
    let mut boxes = vec![empty; (layout.charts - first_chart) as usize];
    for &r in members {
        let of_receiver = &layout.receivers[r];
        for (uvs, &chart) in of_receiver.uvs.iter().zip(&of_receiver.charts) {
            let place = chart.wrapping_sub(first_chart) as usize;
            let Some(of_chart) = boxes.get_mut(place) else {
                continue;
            };
            of_chart.triangles += 1;
            for uv in uvs {
                let corner = DVec2::from_array(uv.map(f64::from)) * size;
                of_chart.low = of_chart.low.min(corner);
                of_chart.high = of_chart.high.max(corner);
            }
        }
    }
    for &r in members {
        let of_receiver = &mut layout.receivers[r];
        for (uvs, &chart) in of_receiver.uvs.iter_mut().zip(&of_receiver.charts) {
            let place = chart.wrapping_sub(first_chart) as usize;
            if let Some(of_chart) = boxes.get(place) {
                (0..2).for_each(|axis| of_chart.widen(uvs, axis, size[axis]));
            }
        }
    }
}

impl ChartBox {
    /// Widens a triangle of the chart along an axis.
    fn widen(&self, uvs: &mut [[f32; 2]; 3], axis: usize, size: f64) {
        let (low, width) = (self.low[axis], self.high[axis] - self.low[axis]);
        if width >= THIN {
            return;
        }
        let texel = (low + 0.5 * width).floor().clamp(0.0, size - 1.0);
        if width > 0.0 {
            for uv in uvs {
                let share = (f64::from(uv[axis]) * size - low) / width;
                uv[axis] = ((texel + share) / size) as f32;
            }
        } else if self.triangles == 1 {
            // Where nothing is left of its shape, any will do: the middle corner goes to the other side.
            let across = 1 - axis;
            let mut order = [0, 1, 2];
            order.sort_by(|&a, &b| uvs[a][across].total_cmp(&uvs[b][across]));
            for (place, &corner) in order.iter().enumerate() {
                let share = if place == 1 { 1.0 } else { 0.0 };
                uvs[corner][axis] = ((texel + share) / size) as f32;
            }
        }
    }
}
