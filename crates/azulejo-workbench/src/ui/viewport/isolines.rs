//! The values written on the isolines of false colours.

use super::legend::short;
use super::texture::{DrawStamp, ViewportTexture};
use crate::gpu::{Background, ColorScale, Overlay, PixelBuffer, ViewportFrame};
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Vec2};
use std::time::Duration;

/// Pixels of the view per pixel of the values, along each axis.
const COARSENESS: u32 = 3;
/// Labels of one value.
const MAX_OF_VALUE: usize = 3;
/// Distance between labels, and between labels of one value, points.
const APART: f32 = 52.0;
const APART_OF_VALUE: f32 = 260.0;
/// How much neighbouring pixels of one surface differ at most, as a share of the scale: a greater
/// step is the edge of a surface, and no isoline.
const MAX_STEP: f64 = 0.06;
/// Pixels around a label that all have to show light.
const CLEAR: u32 = 4;
/// How long the view must be still before values are read back.
const REST: Duration = Duration::from_millis(200);

/// Places of labels, kept while the picture is the same.
#[derive(Default)]
pub struct IsolineLabels {
    /// The picture last drawn, and whether its labels have been placed.
    last: Option<(DrawStamp, bool)>,
    /// Places, as shares of the width and the height, with their texts.
    labels: Vec<(Vec2, String)>,
}

impl IsolineLabels {
    /// Draws the labels of a picture once it has been still for a moment.
    pub fn show(
        &mut self,
        painter: &Painter,
        (rect, clip): (Rect, Rect),
        screen: &mut ViewportTexture,
        stamp: &DrawStamp,
        frame: &ViewportFrame,
    ) {
        if frame.scale.bands == 0 {
            return;
        }
        match &mut self.last {
            Some((last, is_placed)) if last == stamp => {
                if !*is_placed {
                    *is_placed = true;
                    self.labels = place(screen, frame, rect.size());
                }
            }
            _ => {
                self.last = Some((stamp.clone(), false));
                self.labels.clear();
                painter.ctx().request_repaint_after(REST);
            }
        }
        let painter = painter.with_clip_rect(clip);
        for (at, text) in &self.labels {
            label(&painter, rect.min + *at * rect.size(), text);
        }
    }
}

fn label(painter: &Painter, at: Pos2, text: &str) {
    let galley = painter.layout_no_wrap(text.into(), FontId::proportional(11.0), Color32::WHITE);
    let place = Align2::CENTER_CENTER.anchor_size(at, galley.size());
    let back = place.expand2(Vec2::new(3.0, 0.0));
    painter.rect_filled(back, 3.0, Color32::from_black_alpha(150));
    painter.galley(place.min, galley, Color32::WHITE);
}

fn place(screen: &mut ViewportTexture, frame: &ViewportFrame, points: Vec2) -> Vec<(Vec2, String)> {
    let frame = ViewportFrame {
        size: frame.size.map(|n| (n / COARSENESS).max(8)),
        background: Background::Color([0, 0, 0]),
        overlay: Overlay::none(),
        antialiasing: false,
        is_values: true,
        ..frame.clone()
    };
    match screen.values(&frame) {
        Ok(pixels) => places(&ValueGrid::new(&pixels), &frame.scale, points),
        // The picture itself reports what is wrong with the device.
        Err(_) => Vec::new(),
    }
}

/// Positions on the colour scale, 0 to 1, by pixel; `None` where there is no light.
struct ValueGrid {
    width: u32,
    height: u32,
    values: Vec<Option<f64>>,
}

impl ValueGrid {
    fn new(pixels: &PixelBuffer) -> ValueGrid {
        let decode = |p: &[u8]| {
            let value = f64::from(u16::from_be_bytes([p[0], p[1]])) / 65_535.0;
            (p[2] > 127).then_some(value)
        };
        ValueGrid {
            width: pixels.width,
            height: pixels.height,
            values: pixels.rgba.chunks_exact(4).map(decode).collect(),
        }
    }

    fn at(&self, x: u32, y: u32) -> Option<f64> {
        let index = y as usize * self.width as usize + x as usize;
        self.values.get(index).copied().flatten()
    }

    /// Whether all pixels around one show light of the same surface.
    fn is_clear(&self, x: u32, y: u32) -> bool {
        if x < CLEAR || y < CLEAR || x + CLEAR >= self.width || y + CLEAR >= self.height {
            return false;
        }
        let around = y - CLEAR..=y + CLEAR;
        around.into_iter().all(|row| {
            (x - CLEAR..x + CLEAR).all(|column| {
                let pair = self.at(column, row).zip(self.at(column + 1, row));
                pair.is_some_and(|(a, b)| (a - b).abs() < MAX_STEP)
            })
        })
    }

    /// Pixels where the value `level` lies between a pixel and the one to the right or below.
    fn crossings(&self, level: f64) -> Vec<(u32, u32)> {
        let crosses = |a: f64, b: f64| (a - level) * (b - level) <= 0.0 && a != b;
        let mut pixels = Vec::new();
        for y in 0..self.height.saturating_sub(1) {
            for x in 0..self.width.saturating_sub(1) {
                let Some(here) = self.at(x, y) else { continue };
                let next = [self.at(x + 1, y), self.at(x, y + 1)];
                let is_crossed = next.iter().flatten().any(|&b| crosses(here, b));
                if is_crossed && self.is_clear(x, y) {
                    pixels.push((x, y));
                }
            }
        }
        pixels
    }
}

/// Places of the labels as shares of the picture, whose size is `points`.
fn places(grid: &ValueGrid, scale: &ColorScale, points: Vec2) -> Vec<(Vec2, String)> {
    let whole = Vec2::new(grid.width as f32, grid.height as f32);
    let mut placed: Vec<(Vec2, String)> = Vec::new();
    for shown in scale.ticks() {
        let level = scale.fraction(shown / scale.display);
        if !(0.01..=0.99).contains(&level) {
            continue;
        }
        let text = short(shown);
        let mut places: Vec<Vec2> = (grid.crossings(level).into_iter())
            .map(|(x, y)| Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / whole)
            .collect();
        // From the middle of the picture outward.
        let from_middle = |at: &Vec2| ((*at - Vec2::splat(0.5)) * points).length();
        places.sort_by(|a, b| from_middle(a).total_cmp(&from_middle(b)));
        let mut count = 0;
        for at in places {
            let is_apart = placed.iter().all(|(other, name)| {
                let distance = ((at - *other) * points).length();
                distance > if *name == text { APART_OF_VALUE } else { APART }
            });
            if is_apart && count < MAX_OF_VALUE {
                placed.push((at, text.clone()));
                count += 1;
            }
        }
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values that rise from left to right on the left half; nothing at the right.
    fn ramp() -> ValueGrid {
        let (width, height) = (100, 60);
        let value = |k: u32| {
            let x = k % width;
            (x < 50).then(|| f64::from(x) / 49.0)
        };
        ValueGrid {
            width,
            height,
            values: (0..width * height).map(value).collect(),
        }
    }

    #[test]
    fn labels_lie_on_the_lines_of_their_values() {
        let scale = ColorScale {
            bands: 4,
            ..ColorScale::default()
        };
        let labels = places(&ramp(), &scale, Vec2::new(800.0, 480.0));
        assert!(labels.len() >= 3, "{labels:?}");
        for (at, text) in &labels {
            let value: f32 = text.parse().unwrap();
            let expected = (49.0 * value + 0.5) / 100.0;
            assert!((at.x - expected).abs() < 0.02, "{text} at {at}");
        }
        for (k, (a, _)) in labels.iter().enumerate() {
            for (b, _) in &labels[k + 1..] {
                assert!(((*a - *b) * Vec2::new(800.0, 480.0)).length() > APART);
            }
        }
    }

    #[test]
    fn packed_values_are_read_back() {
        let pixels = PixelBuffer {
            width: 2,
            height: 1,
            rgba: vec![128, 0, 255, 255, 255, 255, 0, 255],
        };
        let grid = ValueGrid::new(&pixels);
        let value = grid.at(0, 0).unwrap();
        assert!((value - 0.5).abs() < 1e-4, "{value}");
        assert_eq!(grid.at(1, 0), None);
    }
}
