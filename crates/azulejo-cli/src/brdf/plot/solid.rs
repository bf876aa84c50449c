//! A lobe as a solid, in a view from the side.

use super::{Panel, PlotSubject, brightness, in_order, label, percent, power, power_words, seen};
use crate::drawing::{COLORS, Drawing, FAINT, INK, RgbImage, TextAnchor};
use crate::failure::Failure;
use azulejo_scene::Brdf;
use azulejo_scene::math::Frame;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Angle of incidence in degrees, the same in all plots so that they can be compared.
const INCIDENCE: f64 = 45.0;

/// Rings about the specular direction, and points of each.
const RINGS: usize = 120;
const SECTORS: usize = 180;

/// Pixels of the image are means of this many by this many samples.
const FINE: usize = 3;

/// Half the length of an axis label.
const LABEL: f64 = 32.0;

/// The direction of the viewer: azimuth, and angle above the surface, degrees.
const VIEW: [f64; 2] = [-106.0, 24.0];

/// Draws the panel.
pub fn draw(subject: &PlotSubject, panel: Panel, sheet: &mut Drawing) -> Result<(), Failure> {
    // Evaluate the lobes of all models first, because one scale is common to them.
    let phi = subject.phi;
    let light = super::polar::in_plane(-INCIDENCE.to_radians(), phi);
    let bodies = subject
        .models
        .iter()
        .map(|brdf| values(subject, brdf, light));
    let bodies = bodies.collect::<Result<Vec<_>, _>>()?;
    let lobe_values = || bodies.iter().flatten().flatten().map(|(_, f)| *f);
    let power = power(lobe_values().collect());
    let most = lobe_values().fold(0.0, f64::max);
    // Where no model has a lobe, the panel shows mirrors alone.
    let about = if most > 0.0 {
        format!(
            "radius: {}, 1/sr; up to {}",
            power_words(power),
            label(most)
        )
    } else {
        "perfect mirror".to_owned()
    };
    panel.head(&format!("Lobe for light from {INCIDENCE}°"), &about, sheet);
    // Bodies stand side by side, each over the largest value of all, so that their sizes compare.
    let parts = panel.parts(bodies.len());
    for ((brdf, body), part) in std::iter::zip(&subject.models, bodies).zip(parts) {
        let grown = |(w, f): (DVec3, f64)| {
            if most > 0.0 {
                w * (f / most).powf(power)
            } else {
                DVec3::ZERO
            }
        };
        let body: Vec<Vec<DVec3>> = body
            .into_iter()
            .map(|ring| ring.into_iter().map(grown).collect())
            .collect();
        // The body is a picture of pixels; light and labels are drawn over it.
        let view = LobeView::new(part.size);
        let pixels = view.picture(&body, phi, subject.scale);
        sheet.image(part.at, part.size, pixels);
        view.light(
            part.at,
            light,
            seen(brightness(brdf.mirror(light.z))),
            sheet,
        );
        view.axes(part.at, &body, sheet);
    }
    Ok(())
}

/// Directions all over the hemisphere with f_r cos there, in rings about the specular direction.
fn values(
    subject: &PlotSubject,
    brdf: &Brdf,
    light: DVec3,
) -> Result<Vec<Vec<(DVec3, f64)>>, Failure> {
    let axis = DVec3::new(-light.x, -light.y, light.z);
    let frame = Frame::from_normal(axis);
    in_order(subject, "lobe", RINGS + 1, |ring| {
        let share = ring as f64 / RINGS as f64;
        let sector = |k: usize| {
            let turn = TAU * k as f64 / SECTORS as f64;
            let side = frame.to_world(DVec3::new(turn.cos(), turn.sin(), 0.0));
            // The extent above the surface of the great circle towards `side`.
            let reach = axis.z.atan2(-side.z).min(PI);
            // Denser around the axis, where the lobe may be narrow.
            let (sin, cos) = (0.9999 * reach * share.powf(2.2)).sin_cos();
            let w = axis * cos + side * sin;
            (w, brightness(brdf.eval(w, light)) * w.z)
        };
        (0..SECTORS).map(sector).collect()
    })
}

/// A camera that looks at the origin from far away.
struct LobeView {
    right: DVec3,
    up: DVec3,
    toward: DVec3,
    /// Units of the drawing for a length of 1.
    zoom: f64,
    size: DVec2,
}

impl LobeView {
    fn new(size: DVec2) -> LobeView {
        let [around, above] = VIEW.map(f64::to_radians);
        let toward = DVec3::new(
            above.cos() * around.cos(),
            above.cos() * around.sin(),
            above.sin(),
        );
        let right = DVec3::Z.cross(toward).normalize();
        LobeView {
            right,
            up: toward.cross(right),
            toward,
            zoom: (0.43 * size.x).min(0.66 * size.y),
            size,
        }
    }

    /// Where the origin is.
    fn center(&self) -> DVec2 {
        DVec2::new(0.5 * self.size.x, self.size.y - 0.48 * self.zoom)
    }

    fn place(&self, p: DVec3) -> DVec2 {
        self.center() + self.zoom * DVec2::new(p.dot(self.right), -p.dot(self.up))
    }

    /// The incident light and its perfect specular reflection.
    fn light(&self, at: DVec2, light: DVec3, mirrored: f64, sheet: &mut Drawing) {
        let place = |p: DVec3| at + self.place(p);
        let [from, to] = [1.12, 0.04].map(|t| place(light * t));
        let along = (to - from).normalize();
        sheet.line(vec![from, to - 4.0 * along], INK, 1.6);
        let side = 3.5 * along.perp();
        let back = to - 8.0 * along;
        sheet.polygon(vec![to, back + side, back - side], INK);
        sheet.text(from - 8.0 * along, TextAnchor::Middle, 11.0, INK, "light");
        if mirrored > 0.0 {
            let away = DVec3::new(-light.x, -light.y, light.z);
            let ends = [DVec3::ZERO, away].map(place);
            sheet.dashed(ends.to_vec(), COLORS[1], 1.8, &[1.5, 2.5]);
            let behind = ends[1] + DVec2::new(0.0, -5.0);
            let words = format!("mirror: {}", percent(mirrored));
            sheet.text(behind, TextAnchor::Middle, 10.0, COLORS[1], &words);
        }
    }

    /// Labels of the axes, where the body leaves room.
    fn axes(&self, at: DVec2, body: &[Vec<DVec3>], sheet: &mut Drawing) {
        let names = if self.zoom > 120.0 {
            ["tangent", "bitangent"]
        } else {
            ["t", "b"]
        };
        for (axis, name) in [DVec3::X, DVec3::Y].into_iter().zip(names) {
            let tip = self.place(1.12 * axis);
            let is_covered = |p: &DVec3| self.place(*p).distance(tip) < LABEL;
            if !body.iter().flatten().any(is_covered) {
                let at = at + tip + DVec2::new(0.0, 4.0);
                sheet.text(at, TextAnchor::Middle, 10.0, FAINT, name);
            }
        }
    }

    fn picture(&self, body: &[Vec<DVec3>], phi: f64, scale: f64) -> RgbImage {
        let size = (self.size * scale).round().max(DVec2::ONE);
        let fine = scale * FINE as f64;
        let mut canvas = LobeCanvas {
            width: size.x as usize * FINE,
            height: size.y as usize * FINE,
            pixels: Vec::new(),
        };
        canvas.pixels = vec![(f64::NEG_INFINITY, [255.0; 3]); canvas.width * canvas.height];
        self.floor(&mut canvas, fine, phi);
        for rings in body.windows(2) {
            for k in 0..SECTORS {
                let next = (k + 1) % SECTORS;
                let [a, b] = [rings[0][k], rings[0][next]];
                let [c, d] = [rings[1][next], rings[1][k]];
                for corners in [[a, b, c], [a, c, d]] {
                    self.triangle(corners, fine, &mut canvas);
                }
            }
        }
        canvas.reduced()
    }

    /// The surface, with circles and the axes.
    fn floor(&self, canvas: &mut LobeCanvas, fine: f64, phi: f64) {
        for y in 0..canvas.height {
            for x in 0..canvas.width {
                let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / fine - self.center();
                let flat = at / self.zoom;
                // The point of the surface that is visible there.
                let up = -flat.y / self.up.truncate().length();
                let forward = DVec2::new(-self.toward.x, -self.toward.y).normalize();
                let p = flat.x * self.right.truncate() + up * forward;
                let r = p.length();
                if r > 1.0 {
                    continue;
                }
                // Half the width of a line, in lengths of the body.
                let half = 0.6 / self.zoom;
                let plane = DVec2::new(-phi.sin(), phi.cos());
                let is_line = [0.25, 0.5, 0.75, 1.0].iter().any(|c| (r - c).abs() < half)
                    || [DVec2::X, DVec2::Y, plane]
                        .iter()
                        .any(|n| p.dot(*n).abs() < half);
                let grey = if is_line { 205.0 } else { 243.0 };
                canvas.pixels[y * canvas.width + x].1 = [grey, grey, grey];
            }
        }
    }

    fn triangle(&self, corners: [DVec3; 3], fine: f64, canvas: &mut LobeCanvas) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let Some(normal) = normal.try_normalize() else {
            return;
        };
        let normal = if normal.dot(self.toward) < 0.0 {
            -normal
        } else {
            normal
        };
        let shade = shade(normal, self);
        let flat = corners.map(|c| fine * self.place(c));
        let area = (flat[1] - flat[0]).perp_dot(flat[2] - flat[0]);
        if area.abs() < 1e-9 {
            return;
        }
        let low = flat[0].min(flat[1]).min(flat[2]).max(DVec2::ZERO);
        let most = DVec2::new(canvas.width as f64, canvas.height as f64) - 1.0;
        let high = flat[0].max(flat[1]).max(flat[2]).min(most);
        for y in low.y as usize..=high.y.max(0.0) as usize {
            for x in low.x as usize..=high.x.max(0.0) as usize {
                let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let weight = |k: usize| {
                    let (a, b) = (flat[(k + 1) % 3], flat[(k + 2) % 3]);
                    (b - a).perp_dot(p - a) / area
                };
                let weights = [0, 1, 2].map(weight);
                // Slightly more than the triangle, so that no pixel between two is missed.
                if weights.iter().any(|w| *w < -1e-6) {
                    continue;
                }
                let point: DVec3 = std::iter::zip(corners, weights).map(|(c, w)| c * w).sum();
                let depth = point.dot(self.toward);
                let pixel = &mut canvas.pixels[y * canvas.width + x];
                if depth > pixel.0 {
                    let ink = if self.is_line(point) { 0.72 } else { 1.0 };
                    *pixel = (depth, shade.map(|c| c * ink));
                }
            }
        }
    }

    /// Whether a grid line passes here: every 15 degrees of the angle to the normal, 30 of azimuth.
    fn is_line(&self, point: DVec3) -> bool {
        let r = point.length();
        if r * self.zoom < 12.0 {
            return false;
        }
        let half = 0.45 / (r * self.zoom);
        let near = |angle: f64, step: f64, half: f64| {
            let off = angle.rem_euclid(step);
            off.min(step - off) < half
        };
        let theta = (point.z / r).clamp(-1.0, 1.0).acos();
        let phi = point.y.atan2(point.x);
        near(theta, PI / 12.0, half) || near(phi, PI / 6.0, half / theta.sin().max(0.05))
    }
}

/// Blue, lit from above the viewer's right shoulder.
fn shade(normal: DVec3, view: &LobeView) -> [f64; 3] {
    let lamp = (view.toward + 0.3 * view.right + 0.9 * view.up).normalize();
    let light = 0.42 + 0.58 * normal.dot(lamp).max(0.0);
    COLORS[0].map(|c| (f64::from(c) * 0.75 + 70.0) * light)
}

struct LobeCanvas {
    width: usize,
    height: usize,
    /// Nearness to the viewer, and colour.
    pixels: Vec<(f64, [f64; 3])>,
}

impl LobeCanvas {
    /// Means of blocks.
    fn reduced(&self) -> RgbImage {
        let (width, height) = (self.width / FINE, self.height / FINE);
        let mut rgb = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0; 3];
                for k in 0..FINE * FINE {
                    let at = (y * FINE + k / FINE) * self.width + x * FINE + k % FINE;
                    let color = self.pixels[at].1;
                    (0..3).for_each(|c| sum[c] += color[c]);
                }
                rgb.extend(sum.map(|s| (s / (FINE * FINE) as f64).round() as u8));
            }
        }
        RgbImage {
            width: width as u32,
            height: height as u32,
            rgb,
        }
    }
}
