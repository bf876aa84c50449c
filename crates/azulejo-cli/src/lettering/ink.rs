//! Rasterization of figures to grey pixels.

use azulejo_scene::Figure;
use azulejo_scene::figure::{Segment, crossings};
use glam::DVec2;

/// A grey image, initially white.
#[derive(Debug)]
pub struct GreyCanvas {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Fraction of each pixel that is covered with ink, rows from the top.
    ink: Vec<f32>,
}

/// Scan lines per row of pixels. Coverage along them is exact.
const LINES: usize = 8;

impl GreyCanvas {
    /// A white image.
    pub fn new(size: [usize; 2]) -> GreyCanvas {
        GreyCanvas {
            size,
            ink: vec![0.0; size[0] * size[1]],
        }
    }

    /// Fills a figure with its origin at `at`, in pixels from the top left; `scale` is in pixels per
    /// unit of the figure, whose y axis points up.
    pub fn draw(&mut self, figure: &Figure, at: DVec2, scale: f64) {
        let bounds = figure.bounds();
        if bounds.min.x > bounds.max.x {
            return;
        }
        let row = |y: f64| ((at.y - scale * y).max(0.0) as usize).min(self.size[1]);
        let (top, bottom) = (row(bounds.max.y), row(bounds.min.y) + 1);
        for line in LINES * top..LINES * bottom.min(self.size[1]) {
            let y = (line as f64 + 0.5) / LINES as f64;
            for [from, to] in spans(figure, (at.y - y) / scale) {
                self.ink_span(line / LINES, at.x + scale * from, at.x + scale * to);
            }
        }
    }

    fn ink_span(&mut self, row: usize, from: f64, to: f64) {
        let width = self.size[0];
        let (from, to) = (from.clamp(0.0, width as f64), to.clamp(0.0, width as f64));
        let pixels = &mut self.ink[row * width..][..width];
        for (x, ink) in pixels
            .iter_mut()
            .enumerate()
            .take(to.ceil() as usize)
            .skip(from as usize)
        {
            let covered = to.min(x as f64 + 1.0) - from.max(x as f64);
            *ink += (covered / LINES as f64) as f32;
        }
    }

    /// Three sRGB bytes per pixel.
    pub fn rgb(&self) -> Vec<u8> {
        let byte = |ink: &f32| {
            let light = 1.0 - f64::from(ink.clamp(0.0, 1.0));
            // Coverage is linear in light, as in halftone print.
            let encoded = match light {
                l if l <= 0.003_130_8 => 12.92 * l,
                l => 1.055 * l.powf(1.0 / 2.4) - 0.055,
            };
            [(255.0 * encoded).round() as u8; 3]
        };
        self.ink.iter().flat_map(byte).collect()
    }
}

/// The intervals of the horizontal line at `y` inside of a figure, from left to right.
fn spans(figure: &Figure, y: f64) -> Vec<[f64; 2]> {
    let mut hits = Vec::new();
    for segment in figure.segments() {
        intersect(&segment, y, &mut hits);
    }
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut winding = 0;
    let mut spans = Vec::new();
    for pair in hits.windows(2) {
        winding += pair[0].1;
        if figure.rule.is_inside(winding) {
            spans.push([pair[0].0, pair[1].0]);
        }
    }
    spans
}

/// Adds the crossings of a curve with the line, with 1 for upward and −1 for downward.
fn intersect(segment: &Segment, y: f64, hits: &mut Vec<(f64, i32)>) {
    match *segment {
        Segment::Line([a, b]) => {
            let sense = i32::from(b.y >= y) - i32::from(a.y >= y);
            if sense != 0 {
                hits.push((a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)), sense));
            }
        }
        Segment::Cubic(points) => {
            let crossings = crossings(points.map(|p| p.y - y)).into_iter().flatten();
            hits.extend(crossings.map(|(t, sense)| (segment.at(t).x, sense)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ink(figure: &Figure, at: DVec2, scale: f64) -> Vec<f32> {
        let mut paper = GreyCanvas::new([3, 2]);
        paper.draw(figure, at, scale);
        paper.ink
    }

    fn polygon(corners: &[(f64, f64)]) -> Figure {
        Figure::polygon(corners.iter().map(|&p| DVec2::from(p)))
    }

    #[test]
    fn pixels_are_covered_in_part() {
        let square = polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        let check = |at: (f64, f64), scale: f64, expected: [f32; 6]| {
            assert_eq!(ink(&square, at.into(), scale), expected, "{at:?}");
        };
        check((1.0, 1.0), 1.0, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        check((0.5, 1.5), 1.0, [0.25, 0.25, 0.0, 0.25, 0.25, 0.0]);
        check((-9.0, 9.0), 99.0, [1.0; 6]);
        check((5.0, 1.0), 1.0, [0.0; 6]);
    }

    #[test]
    fn holes_stay_white() {
        let mut ring = polygon(&[(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0)]);
        let hole = polygon(&[(1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0)]);
        ring.contours.extend(hole.contours);
        let coverage = ink(&ring, DVec2::new(0.0, 2.0), 1.0);
        assert_eq!(coverage, [1.0, 1.0, 1.0, 1.0, 0.0, 1.0]);
    }

    #[test]
    fn half_coverage_is_half_of_the_light() {
        let mut paper = GreyCanvas::new([2, 1]);
        paper.ink = vec![0.5, 1.0];
        assert_eq!(paper.rgb(), [188, 188, 188, 0, 0, 0]);
    }
}
