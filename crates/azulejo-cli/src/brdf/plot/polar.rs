//! Lobes in the plane of incidence, for several angles.

use super::{
    Panel, PlotSubject, brightness, label, percent, power, power_words, round_below, seen,
};
use crate::drawing::{COLORS, Color, Drawing, FAINT, GRID, INK, TextAnchor};
use azulejo_scene::Brdf;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Dashes of the model, and of the one it is compared with.
const DASHES: [&[f64]; 2] = [&[], &[5.0, 3.0]];

/// One line.
struct PolarLobe {
    /// Angles to the normal in the plane of incidence, and f_r cos there.
    points: Vec<(f64, f64)>,
    /// Angle of incidence.
    angle: f64,
    /// Reflectance of the perfect mirror.
    mirrored: f64,
    color: Color,
    dashes: &'static [f64],
}

/// The position of the half circle, and the scale of its radius.
struct PolarAxes {
    center: DVec2,
    radius: f64,
    /// The value at the radius.
    top: f64,
    power: f64,
}

/// Draws the panel.
pub fn draw(subject: &PlotSubject, panel: Panel, sheet: &mut Drawing) {
    let lobes = lobes(subject);
    let values = || lobes.iter().flat_map(|l| l.points.iter().map(|p| p.1));
    let most = values().fold(0.0, f64::max);
    let radius = 0.5 * panel.size.x - 48.0;
    let dial = PolarAxes {
        center: panel.at + DVec2::new(0.5 * panel.size.x, panel.size.y - 24.0),
        radius: radius.min(panel.size.y - 92.0),
        top: if most > 0.0 { most } else { 1.0 },
        power: power(values().collect()),
    };
    let has_mirror = lobes.iter().any(|l| l.mirrored > 0.0);
    let about = if has_mirror {
        "straight lines: perfect mirror reflection"
    } else {
        "light comes from the left"
    };
    let about = format!("radius: {}, 1/sr; {about}", power_words(dial.power));
    panel.head("Lobes in the plane of incidence", &about, sheet);
    dial.grid(sheet);
    if most > 0.0 {
        dial.rings(sheet);
    }
    if !has_mirror {
        dial.degrees(sheet);
    }
    for lobe in lobes.iter().rev() {
        dial.lobe(lobe, sheet);
    }
    for lobe in &lobes[..subject.angles.len()] {
        dial.arrow(lobe, sheet);
    }
}

fn lobes(subject: &PlotSubject) -> Vec<PolarLobe> {
    let models = std::iter::zip(&subject.models, DASHES);
    let model_lobes = |(brdf, dashes): (&&Brdf, &'static [f64])| -> Vec<PolarLobe> {
        let angles = subject.angles.iter().zip(COLORS.iter().cycle());
        let lobe = |(&angle, &color): (&f64, &Color)| PolarLobe {
            points: points(brdf, angle, subject.phi),
            angle,
            mirrored: seen(brightness(brdf.mirror(angle.cos()))),
            color,
            dashes,
        };
        angles.map(lobe).collect()
    };
    models.flat_map(model_lobes).collect()
}

/// A direction in the plane of incidence; its angle to the normal is negative on the light's side.
pub fn in_plane(angle: f64, phi: f64) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// The curve of a lobe, sampled more densely around the specular direction, where it may be narrow.
fn points(brdf: &Brdf, incidence: f64, phi: f64) -> Vec<(f64, f64)> {
    let wide = (-359..360).map(|k| f64::from(k) * FRAC_PI_2 / 360.0);
    let close = (-160..=160).map(|k: i32| {
        let t = f64::from(k) / 160.0;
        incidence + 0.25 * t * t.abs()
    });
    // The specular direction itself is left out: where the half vector is the normal, some anisotropic
    // models are discontinuous.
    let is_drawn = |a: &f64| a.abs() < 0.9999 * FRAC_PI_2 && (a - incidence).abs() > 1e-9;
    let mut angles: Vec<f64> = wide.chain(close).filter(is_drawn).collect();
    angles.sort_by(f64::total_cmp);
    let wi = in_plane(-incidence, phi);
    let value = |a: f64| brightness(brdf.eval(in_plane(a, phi), wi)) * a.cos();
    angles.into_iter().map(|a| (a, value(a))).collect()
}

impl PolarAxes {
    /// The point at an angle to the normal and a fraction of the radius.
    fn at(&self, angle: f64, share: f64) -> DVec2 {
        self.center + self.radius * share * DVec2::new(angle.sin(), -angle.cos())
    }

    fn share(&self, value: f64) -> f64 {
        (value / self.top).max(0.0).powf(self.power)
    }

    fn ring(&self, share: f64, color: Color, sheet: &mut Drawing) {
        let arc = (-60..=60).map(|k| self.at(f64::from(k) * PI / 120.0, share));
        sheet.line(arc.collect(), color, 1.0);
    }

    fn grid(&self, sheet: &mut Drawing) {
        for k in -3..=3 {
            let angle = f64::from(k) * PI / 6.0;
            sheet.line(vec![self.center, self.at(angle, 1.0)], GRID, 1.0);
        }
        self.ring(1.0, GRID, sheet);
        let floor = [-FRAC_PI_2, FRAC_PI_2].map(|a| self.at(a, 1.04));
        sheet.line(floor.to_vec(), INK, 1.2);
    }

    /// Labels of the angles to the normal, where there is room.
    fn degrees(&self, sheet: &mut Drawing) {
        for k in 1..=2 {
            let angle = f64::from(k) * PI / 6.0;
            let at = self.at(angle, 1.0) + DVec2::new(9.0 * angle.sin(), -7.0 * angle.cos());
            sheet.text(at, TextAnchor::Start, 10.0, FAINT, &format!("{}°", 30 * k));
        }
    }

    /// Rings at round values.
    fn rings(&self, sheet: &mut Drawing) {
        let mut value = round_below(self.top);
        let mut last = 2.0;
        let mut shown = 0;
        while shown < 4 && value > 1e-6 * self.top {
            let share = self.share(value);
            if share < 0.12 {
                break;
            }
            if last - share > 0.14 {
                self.ring(share, GRID, sheet);
                let at = self.center + DVec2::new(self.radius * share, 13.0);
                sheet.text(at, TextAnchor::Middle, 10.0, FAINT, &label(value));
                last = share;
                shown += 1;
            }
            value = round_below(value * 0.51);
        }
    }

    fn lobe(&self, lobe: &PolarLobe, sheet: &mut Drawing) {
        let mut line: Vec<DVec2> = vec![self.center];
        let places = lobe.points.iter().map(|&(a, f)| self.at(a, self.share(f)));
        for place in places {
            if line.last().is_none_or(|last| last.distance(place) > 0.6) {
                line.push(place);
            }
        }
        line.push(self.center);
        sheet.dashed(line, lobe.color, 1.8, lobe.dashes);
        if lobe.mirrored > 0.0 {
            self.mirrored(lobe, sheet);
        }
    }

    /// Perfect specular reflection has no finite f_r: a line with its reflectance.
    fn mirrored(&self, lobe: &PolarLobe, sheet: &mut Drawing) {
        let end = self.at(lobe.angle, 1.0);
        let dashes = if lobe.dashes.is_empty() {
            &[1.5, 2.5][..]
        } else {
            lobe.dashes
        };
        sheet.dashed(vec![self.center, end], lobe.color, 1.8, dashes);
        if lobe.dashes.is_empty() {
            let at = end + DVec2::new(5.0, 8.0 * lobe.angle.sin() - 2.0);
            let words = percent(lobe.mirrored);
            sheet.text(at, TextAnchor::Start, 10.0, lobe.color, &words);
        }
    }

    /// The direction of the light, and its angle.
    fn arrow(&self, lobe: &PolarLobe, sheet: &mut Drawing) {
        let (from, to) = (self.at(-lobe.angle, 1.13), self.at(-lobe.angle, 1.02));
        let along = (to - from).normalize();
        let side = along.perp();
        sheet.line(vec![from, to - 4.0 * along], lobe.color, 2.0);
        let head = [
            to,
            to - 7.0 * along + 3.5 * side,
            to - 7.0 * along - 3.5 * side,
        ];
        sheet.polygon(head.to_vec(), lobe.color);
        let at = from - 9.0 * along + DVec2::new(0.0, 4.0);
        let degrees = format!("{}°", label(lobe.angle.to_degrees()));
        let anchor = if lobe.angle < 0.2 {
            TextAnchor::Middle
        } else {
            TextAnchor::End
        };
        sheet.text(at, anchor, 11.0, lobe.color, &degrees);
    }
}
