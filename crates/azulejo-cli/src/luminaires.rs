//! Luminaires of a scene: flux, beam and polar plot.

use crate::drawing::escaped;
use crate::report::{Report, number, short};
use azulejo::luminaire::kinds::{LuminaireKind, PLANES, beam_angle, round_step};
use azulejo_scene::Scene;
use serde_json::json;
use std::f64::consts::PI;
use std::fmt::Write;

/// Adds a line for each kind of luminaire.
pub fn describe(scene: &Scene, report: &mut Report) {
    let kinds = LuminaireKind::of(scene);
    if kinds.is_empty() {
        return;
    }
    let metres = scene.units.metres();
    let square = metres * metres;
    let [power, intensity] = if scene.units.photometric {
        ["lm", "cd"]
    } else {
        ["W", "W/sr"]
    };
    let mut list = Vec::new();
    for kind in &kinds {
        let flux = kind.scale * square * kind.web.sphere_integral();
        let most = kind.scale * square * kind.web.most();
        let profiles = PLANES.map(|(_, axis)| kind.profile(axis));
        let [beams, fields] =
            [0.5, 0.1].map(|share| profiles.each_ref().map(|p| beam_angle(p, share)));
        let points = match kind.lights {
            1 => String::new(),
            n => format!(", as {n} points"),
        };
        let words = format!(
            "{}: {} {power}, {} {intensity} at most{points}; beam {:.0}° × {:.0}° (half), field {:.0}° × {:.0}° (a tenth)",
            kind.name,
            short(flux),
            short(most),
            beams[0],
            beams[1],
            fields[0],
            fields[1],
        );
        report.line("luminaire", words);
        list.push(json!({
            "name": kind.name,
            "flux": number(flux),
            "intensity_most": number(most),
            "points": kind.lights,
            "beam_degrees": beams.map(number),
            "field_degrees": fields.map(number),
        }));
    }
    report.value("luminaires", list);
}

/// Width of the plot of a kind, and the radius of its largest circle, pixels.
const WIDTH: f64 = 420.0;
const RADIUS: f64 = 170.0;

/// Polar plots of all kinds of luminaires of a scene, as SVG, the aim downwards; `None` if it has none.
pub fn plot(scene: &Scene) -> Option<String> {
    let kinds = LuminaireKind::of(scene);
    if kinds.is_empty() {
        return None;
    }
    let metres = scene.units.metres();
    let unit = if scene.units.photometric {
        "cd"
    } else {
        "W/sr"
    };
    let (width, height) = (WIDTH * kinds.len() as f64, WIDTH + 40.0);
    let mut out = String::new();
    // Writing to a string does not fail.
    let _ = write!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    for (k, kind) in kinds.iter().enumerate() {
        let _ = panel(kind, k as f64 * WIDTH, (metres * metres, unit), &mut out);
    }
    out.push_str("</svg>\n");
    Some(out)
}

fn panel(
    kind: &LuminaireKind,
    left: f64,
    (square, unit): (f64, &str),
    out: &mut String,
) -> std::fmt::Result {
    let (cx, cy) = (left + WIDTH / 2.0, 30.0 + WIDTH / 2.0);
    // The largest circle is a round number, with four rings.
    let most = kind.scale * square * kind.web.most();
    let step = round_step(most / 4.0);
    let full = step * (most / step).ceil().max(1.0);
    let at = |angle: f64, value: f64| {
        let (sin, cos) = angle.sin_cos();
        let r = RADIUS * value / full;
        [cx + r * sin, cy + r * cos]
    };
    writeln!(
        out,
        "<text x=\"{cx}\" y=\"18\" text-anchor=\"middle\" font-size=\"14\">{}, {} {}</text>",
        escaped(kind.name),
        short(kind.scale * square * kind.web.sphere_integral()),
        if unit == "cd" { "lm" } else { "W" },
    )?;
    for ring in 1..=(full / step).round() as u32 {
        let value = step * f64::from(ring);
        let r = RADIUS * value / full;
        writeln!(
            out,
            "<circle cx=\"{cx}\" cy=\"{cy}\" r=\"{r:.1}\" fill=\"none\" stroke=\"#cccccc\"/>\n\
             <text x=\"{:.1}\" y=\"{:.1}\" fill=\"#666666\">{}</text>",
            cx + 3.0,
            cy + r - 3.0,
            short(value),
        )?;
    }
    for k in 0..12 {
        let angle = f64::from(k) * PI / 6.0;
        let [x, y] = at(angle, full);
        let [tx, ty] = at(angle, 1.09 * full);
        let degrees = if k <= 6 { 30 * k } else { 360 - 30 * k };
        writeln!(
            out,
            "<path d=\"M{cx} {cy}L{x:.1} {y:.1}\" stroke=\"#dddddd\"/>\n\
             <text x=\"{tx:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#666666\">{degrees}°</text>",
            ty + 4.0,
        )?;
    }
    let strokes = [
        "stroke=\"#c0392b\"",
        "stroke=\"#2456a4\" stroke-dasharray=\"6 4\"",
    ];
    for ((name, axis), (k, stroke)) in PLANES.into_iter().zip(strokes.into_iter().enumerate()) {
        let mut path = String::new();
        for (angle, intensity) in kind.profile(axis) {
            let [x, y] = at(angle, square * intensity);
            write!(
                path,
                "{}{x:.1} {y:.1}",
                if path.is_empty() { 'M' } else { 'L' }
            )?;
        }
        let (x, y) = (left + 14.0, WIDTH + 14.0 + 18.0 * k as f64);
        writeln!(
            out,
            "<path d=\"{path}Z\" fill=\"none\" stroke-width=\"2\" {stroke}/>\n\
             <path d=\"M{x} {y}h28\" stroke-width=\"2\" {stroke}/>\n\
             <text x=\"{}\" y=\"{}\">{name}</text>",
            x + 34.0,
            y + 4.0,
        )?;
    }
    writeln!(
        out,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"#666666\">{unit}</text>",
        left + WIDTH - 14.0,
        WIDTH + 32.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Light, LightKind, PhotometricWeb, Rgb, WebType};
    use glam::{DMat3, DVec3};
    use std::sync::Arc;

    fn scene() -> Scene {
        // Straight down 100 cd, linear to nothing at 60 degrees in the plane of 0 degrees and at 30 in that of 90.
        let values = vec![100.0, 50.0, 0.0, 100.0, 0.0, 0.0];
        let web = PhotometricWeb::new(WebType::C, [&[0.0, 30.0, 60.0], &[0.0, 90.0]], values);
        let kind = LightKind::Luminaire {
            position: DVec3::ZERO,
            world_from_web: DMat3::IDENTITY,
            scale: Rgb::WHITE,
            web: Arc::new(web.unwrap()),
        };
        let light = |name: &str| Light {
            name: name.to_owned(),
            kind: kind.clone(),
        };
        Scene {
            lights: vec![light("a"), light("a"), light("b <c>")],
            ..Scene::default()
        }
    }

    #[test]
    fn plots_show_every_kind_once() {
        let text = plot(&scene()).unwrap();
        assert!(text.contains("b &lt;c&gt;") && text.matches("C90 – C270").count() == 2);
        assert_eq!(plot(&Scene::default()), None);
    }
}
