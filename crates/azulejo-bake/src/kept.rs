//! A layout of texture coordinates that surfaces have already.

use crate::Receiver;
use crate::check::chart_numbers;
use crate::layout::{Layout, ReceiverLayout};
use crate::seams::seams;
use azulejo_trace::Tracer;

/// The layout of coordinates as they are: charts are triangles that meet at edges with equal coordinates.
/// `coordinates` has `uvs` and `pages` of each receiver; triangles on pages that do not exist, without area
/// and with unusable coordinates have no chart. Light is made equal along edges that are not creases, and at which
/// `tracer` finds nothing standing.
pub fn kept_layout(
    receivers: &[Receiver],
    coordinates: Vec<ReceiverLayout>,
    pages: Vec<[u32; 2]>,
    crease: f64,
    tracer: Option<&Tracer>,
) -> Layout {
    let mut layout = Layout {
        pages,
        receivers: coordinates,
        charts: 0,
    };
    for (receiver, of_receiver) in receivers.iter().zip(&mut layout.receivers) {
        of_receiver.charts.clear();
        let is_visible = receiver.visible_triangles();
        of_receiver.cuts = seams(receiver, &is_visible, crease, tracer);
    }
    let (numbers, count) = chart_numbers(receivers, &layout);
    for (of_receiver, charts) in layout.receivers.iter_mut().zip(numbers) {
        of_receiver.charts = charts;
    }
    layout.charts = count;
    layout
}
