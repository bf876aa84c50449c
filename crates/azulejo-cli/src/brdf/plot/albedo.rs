//! The albedo against the angle of incidence, with the parts of the model.

use super::{Panel, PlotSubject, brightness, in_order, label, round_below};
use crate::drawing::{Color, Drawing, FAINT, GRID, INK, TextAnchor};
use crate::failure::Failure;
use azulejo_scene::{Brdf, Rgb};
use glam::DVec2;
use std::f64::consts::FRAC_PI_4;

/// Number of angles.
const ANGLES: usize = 46;

/// The largest of them, degrees.
const LAST: f64 = 89.0;

/// The parts from bottom to top, with their colours.
const PARTS: [(&str, Color); 4] = [
    ("diffuse", [190, 190, 190]),
    ("rough", [240, 213, 150]),
    ("glossy", [158, 203, 226]),
    ("mirror, or nearly", [233, 196, 218]),
];

/// Colours of the channels' lines, where they differ.
const CHANNELS: [(&str, Color); 3] = [
    ("R", [190, 60, 40]),
    ("G", [0, 120, 90]),
    ("B", [30, 80, 180]),
];

/// Channels that differ by less are one line.
const NEAR: f64 = 0.015;

/// The albedo at one angle.
struct AlbedoRow {
    /// Angle of incidence.
    degrees: f64,
    /// Of each part.
    parts: [f64; 4],
    /// Of all of them.
    all: Rgb,
}

/// The axes.
struct AlbedoChart {
    /// Lower left corner.
    origin: DVec2,
    size: DVec2,
    /// The value at the top.
    most: f64,
}

/// Draws the panel.
pub fn draw(subject: &PlotSubject, panel: Panel, sheet: &mut Drawing) -> Result<(), Failure> {
    panel.head(
        "Albedo against angle",
        "directional albedo: share of the incident light that is reflected",
        sheet,
    );
    let rows = |brdf: &Brdf| {
        in_order(subject, "albedo", ANGLES, |k| {
            reflected(brdf, k, subject.phi)
        })
    };
    let first = rows(subject.models[0])?;
    let second = subject.models.get(1).map(|brdf| rows(brdf)).transpose()?;
    let rows = first.iter().chain(second.iter().flatten());
    let most = rows.map(|r| r.all.max_channel()).fold(1.0, f64::max);
    let chart = AlbedoChart {
        origin: panel.at + DVec2::new(38.0, panel.size.y - 38.0),
        size: DVec2::new(panel.size.x - 52.0, panel.size.y - 92.0),
        most: 1.04 * most.min(8.0),
    };
    chart.areas(&first, sheet);
    chart.axes(sheet);
    chart.lines(&first, &[], sheet);
    if let Some(second) = &second {
        chart.lines(second, &[6.0, 4.0], sheet);
    }
    legend(&first, &panel, sheet);
    Ok(())
}

fn reflected(brdf: &Brdf, k: usize, phi: f64) -> AlbedoRow {
    let degrees = LAST * k as f64 / (ANGLES - 1) as f64;
    // For anisotropic models halfway between the axes, unless requested otherwise.
    let phi = if phi == 0.0 { FRAC_PI_4 } else { phi };
    let wo = super::polar::in_plane(degrees.to_radians(), phi);
    let parts = [
        brdf.diffuse(),
        brdf.matt().albedo(wo),
        brdf.glossy().albedo(wo),
        brdf.narrow().albedo(wo),
    ];
    AlbedoRow {
        degrees,
        parts: parts.map(brightness),
        all: parts.into_iter().sum(),
    }
}

fn has_part(rows: &[AlbedoRow], part: usize) -> bool {
    rows.iter().any(|r| r.parts[part] > 0.0)
}

/// Draws the legend of the parts that occur.
fn legend(rows: &[AlbedoRow], panel: &Panel, sheet: &mut Drawing) {
    let mut at = panel.at + DVec2::new(38.0, 46.0);
    for (k, (name, color)) in PARTS.into_iter().enumerate() {
        if !has_part(rows, k) {
            continue;
        }
        let corners = [(0.0, -9.0), (12.0, -9.0), (12.0, 1.0), (0.0, 1.0)];
        sheet.polygon(corners.map(|c| at + DVec2::from(c)).to_vec(), color);
        sheet.text(
            at + DVec2::new(17.0, 0.0),
            TextAnchor::Start,
            11.0,
            INK,
            name,
        );
        at.x += 34.0 + 6.4 * name.len() as f64;
    }
}

impl AlbedoChart {
    fn at(&self, degrees: f64, value: f64) -> DVec2 {
        let share = DVec2::new(degrees / 90.0, -(value / self.most).min(1.0));
        self.origin + self.size * share
    }

    fn areas(&self, rows: &[AlbedoRow], sheet: &mut Drawing) {
        for (k, (_, color)) in PARTS.into_iter().enumerate() {
            if !has_part(rows, k) {
                continue;
            }
            let up_to =
                |r: &AlbedoRow, count: usize| self.at(r.degrees, r.parts[..count].iter().sum());
            let below = rows.iter().map(|r| up_to(r, k));
            let above = rows.iter().rev().map(|r| up_to(r, k + 1));
            sheet.polygon(below.chain(above).collect(), color);
        }
    }

    fn axes(&self, sheet: &mut Drawing) {
        let step = round_below(0.26 * self.most);
        let mut value = 0.0;
        while value <= self.most {
            let ends = [self.at(0.0, value), self.at(90.0, value)];
            sheet.line(ends.to_vec(), GRID, 1.0);
            let at = ends[0] + DVec2::new(-6.0, 4.0);
            sheet.text(at, TextAnchor::End, 11.0, FAINT, &label(value));
            value += step;
        }
        let ends = [self.at(0.0, 1.0), self.at(90.0, 1.0)];
        sheet.dashed(ends.to_vec(), [213, 94, 0], 1.2, &[2.0, 3.0]);
        for degrees in [0, 15, 30, 45, 60, 75, 90] {
            let foot = self.at(degrees.into(), 0.0);
            sheet.line(vec![foot, foot + DVec2::new(0.0, 4.0)], INK, 1.0);
            let at = foot + DVec2::new(0.0, 16.0);
            sheet.text(at, TextAnchor::Middle, 11.0, FAINT, &format!("{degrees}°"));
        }
        sheet.line(vec![self.at(0.0, 0.0), self.at(90.0, 0.0)], INK, 1.2);
        let at = self.at(45.0, 0.0) + DVec2::new(0.0, 32.0);
        sheet.text(at, TextAnchor::Middle, 11.0, FAINT, "angle of incidence");
    }

    /// One line, or three where the channels differ.
    fn lines(&self, rows: &[AlbedoRow], dashes: &'static [f64], sheet: &mut Drawing) {
        let line = |of: &dyn Fn(&AlbedoRow) -> f64| -> Vec<DVec2> {
            rows.iter().map(|r| self.at(r.degrees, of(r))).collect()
        };
        let colored = |r: &AlbedoRow| (0..3).any(|c| (r.all[c] - r.all.mean()).abs() > NEAR);
        if !rows.iter().any(colored) {
            sheet.dashed(line(&|r| brightness(r.all)), INK, 2.0, dashes);
            return;
        }
        for (channel, (name, color)) in CHANNELS.into_iter().enumerate() {
            let points = line(&|r| r.all[channel]);
            // Side by side, since the lines may start at the same point.
            let start = points[0] + DVec2::new(4.0 + 11.0 * channel as f64, -4.0);
            sheet.dashed(points, color, 2.0, dashes);
            if dashes.is_empty() {
                sheet.text(start, TextAnchor::Start, 11.0, color, name);
            }
        }
    }
}
