//! `brdf plot`: a sheet with four plots of a model.

mod albedo;
mod patches;
mod polar;
mod solid;
mod sphere;

use super::args::PlotArgs;
use super::model;
use crate::drawing::{Drawing, FAINT, INK, TextAnchor, palette, raster};
use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use azulejo::output::Output;
use azulejo_scene::Brdf;
use azulejo_scene::brdf::{Description, find};
use azulejo_trace::Progress;
use glam::DVec2;
use rayon::prelude::*;
use std::path::Path;

/// Width and height of the sheet.
const SHEET: DVec2 = DVec2::new(960.0, 758.0);

/// Space around and between the panels.
const MARGIN: f64 = 24.0;

/// Top of the panels, below the title.
const TOP: f64 = 92.0;

/// Size of a panel.
const PANEL: DVec2 = DVec2::new(
    0.5 * (SHEET.x - 3.0 * MARGIN),
    0.5 * (SHEET.y - TOP - 2.0 * MARGIN - 12.0),
);

/// Number of characters of a description that fit in a line.
const LONGEST: usize = 138;

/// The models to plot, and options.
struct PlotSubject<'a> {
    /// The model, and the one it is compared with.
    models: Vec<&'a Brdf>,
    /// Angles of incidence, radians.
    angles: Vec<f64>,
    /// Azimuth of the plane of incidence, radians.
    phi: f64,
    /// Pixels per unit, for rasterized parts.
    scale: f64,
    progress: &'a Progress,
}

/// A part of the sheet.
#[derive(Clone, Copy)]
struct Panel {
    /// Upper left corner.
    at: DVec2,
    size: DVec2,
}

#[derive(Clone, Copy)]
enum PlotFormat {
    Svg,
    Png,
}

/// Runs `brdf plot`.
pub fn run(args: &PlotArgs, session: &mut Session) -> Result<Report, Failure> {
    let format = format_of(&args.output)?;
    let output = Output::check(&args.output)?;
    session.claim_stdout(output.is_stdout())?;
    let brdf = model::read(&args.model, session)?;
    let other = args.compare.as_deref();
    let other = other
        .map(|text| model::read_text(text, session))
        .transpose()?;
    let sheet = session.with_progress(|progress| {
        sheet(&PlotSubject {
            models: [&brdf].into_iter().chain(&other).collect(),
            angles: args.angles.iter().map(|a| a.to_radians()).collect(),
            phi: args.phi.to_radians(),
            scale: f64::from(args.width) / SHEET.x,
            progress,
        })
    })?;
    write(&sheet, format, args.width, &output, session.progress())?;
    let mut report = Report::default();
    let path = args.output.display().to_string();
    let words = format!("{path}: {}", model::words(&brdf));
    report.fact("output", path, "wrote", words);
    report.value("model", model::words(&brdf));
    Ok(report)
}

fn format_of(path: &Path) -> Result<PlotFormat, Failure> {
    if path == Path::new("-") {
        return Ok(PlotFormat::Svg);
    }
    match path.extension() {
        Some(e) if e.eq_ignore_ascii_case("svg") => Ok(PlotFormat::Svg),
        Some(e) if e.eq_ignore_ascii_case("png") => Ok(PlotFormat::Png),
        _ => Err(Failure::Misuse(format!(
            "{}: unknown image format, expected .svg or .png",
            path.display()
        ))),
    }
}

fn write(
    sheet: &Drawing,
    format: PlotFormat,
    width: u32,
    output: &Output,
    progress: &Progress,
) -> Result<(), Failure> {
    let written = match format {
        PlotFormat::Svg => {
            let text = sheet.svg();
            output.write(progress, |out| out.write_all(text.as_bytes()))
        }
        PlotFormat::Png => {
            let pixels = raster::rasterize(sheet, width);
            let pixels = pixels.ok_or_else(|| Failure::failed("the image is too large"))?;
            output.write(progress, |out| {
                let palette::IndexedImage { palette, indices } = palette::reduce(&pixels);
                let (width, height) = (pixels.width, pixels.height);
                azulejo_formats::picture::png::write_indexed(width, height, &palette, &indices, out)
            })
        }
    };
    Ok(written?)
}

fn sheet(subject: &PlotSubject) -> Result<Drawing, Failure> {
    let mut sheet = Drawing::on_white(SHEET.x, SHEET.y);
    head(subject, &mut sheet);
    let panel = |column: f64, row: f64| Panel {
        at: DVec2::new(MARGIN, TOP) + DVec2::new(column, row) * (PANEL + MARGIN),
        size: PANEL,
    };
    polar::draw(subject, panel(0.0, 0.0), &mut sheet);
    solid::draw(subject, panel(1.0, 0.0), &mut sheet)?;
    albedo::draw(subject, panel(0.0, 1.0), &mut sheet)?;
    sphere::draw(subject, panel(1.0, 1.0), &mut sheet)?;
    Ok(sheet)
}

/// Title, description and publication.
fn head(subject: &PlotSubject, sheet: &mut Drawing) {
    let first = subject.models[0];
    let left = |y: f64| DVec2::new(MARGIN, y);
    sheet.text(left(34.0), TextAnchor::Start, 21.0, INK, &title(first));
    let mut words = shortened(&model::words(first));
    if let Some(other) = subject.models.get(1) {
        let other = shortened(&model::words(other));
        sheet.text(
            left(72.0),
            TextAnchor::Start,
            12.0,
            INK,
            &format!("dashed: {other}"),
        );
        words = format!("solid: {words}");
    }
    sheet.text(left(55.0), TextAnchor::Start, 12.0, INK, &words);
    let paper = paper(first);
    let foot = DVec2::new(MARGIN, SHEET.y - 12.0);
    sheet.text(foot, TextAnchor::Start, 10.5, FAINT, &shortened(paper));
}

fn title(brdf: &Brdf) -> String {
    match brdf.description() {
        Description::Model(model) => match find(&model.name) {
            Ok(info) => info.title.to_owned(),
            Err(_) => model.name.clone(),
        },
        Description::Combination(_) => "Combination".to_owned(),
        Description::File { path, .. } => path.clone(),
    }
}

fn paper(brdf: &Brdf) -> &'static str {
    match brdf.description() {
        Description::Model(model) => find(&model.name).map_or("", |info| info.paper),
        _ => "",
    }
}

fn shortened(words: &str) -> String {
    if words.chars().count() <= LONGEST {
        return words.to_owned();
    }
    let start: String = words.chars().take(LONGEST - 3).collect();
    start + "..."
}

impl Panel {
    /// Adds the title of the panel, and a description below.
    fn head(&self, title: &str, about: &str, sheet: &mut Drawing) {
        let at = |y: f64| self.at + DVec2::new(0.0, y);
        sheet.text(at(12.0), TextAnchor::Start, 14.0, INK, title);
        sheet.text(at(29.0), TextAnchor::Start, 11.0, FAINT, about);
    }

    /// The area below the heading, in equal parts from left to right.
    fn parts(&self, count: usize) -> Vec<Panel> {
        let width = self.size.x / count as f64;
        let part = |k: usize| Panel {
            at: self.at + DVec2::new(k as f64 * width, 36.0),
            size: DVec2::new(width, self.size.y - 36.0),
        };
        (0..count).map(part).collect()
    }
}

/// `count` values, computed in parallel, in order.
fn in_order<T: Send>(
    subject: &PlotSubject,
    stage: &str,
    count: usize,
    value: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>, Failure> {
    subject.progress.begin(stage, count as u64);
    let one = |k: usize| {
        subject.progress.advance(1)?;
        Ok(value(k))
    };
    (0..count).into_par_iter().map(one).collect()
}

/// The plotted value of a colour: its luminance.
fn brightness(value: azulejo_scene::Rgb) -> f64 {
    value.luminance()
}

/// The power of f_r cos that is plotted: the cube root if peaks would hide everything else. The
/// cosine is included because f_r alone is unbounded at grazing angles for many models.
fn power(mut values: Vec<f64>) -> f64 {
    values.retain(|v| *v > 0.0);
    values.sort_by(f64::total_cmp);
    let (Some(middle), Some(most)) = (values.get(values.len() / 2), values.last()) else {
        return 1.0;
    };
    if *most > 8.0 * middle { 1.0 / 3.0 } else { 1.0 }
}

/// The power in words, for headings.
fn power_words(power: f64) -> &'static str {
    if power < 1.0 {
        "cube root of f_r·cos"
    } else {
        "f_r·cos"
    }
}

/// The largest of 1, 2, 5 times a power of ten that is not above `x`.
fn round_below(x: f64) -> f64 {
    let decade = 10f64.powf(x.log10().floor());
    let steps = [5.0, 2.0, 1.0].map(|s| s * decade);
    steps
        .into_iter()
        .find(|s| *s <= x * (1.0 + 1e-9))
        .unwrap_or(decade)
}

/// A share, or 0 if it would be printed as 0.0%.
fn seen(share: f64) -> f64 {
    if share < 5e-4 { 0.0 } else { share }
}

/// A share, to a decimal.
fn percent(share: f64) -> String {
    format!("{:.1}%", 100.0 * share)
}

/// A number on an axis.
fn label(x: f64) -> String {
    crate::report::short(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_are_round() {
        for (x, expected) in [(1.0, 1.0), (0.32, 0.2), (70.0, 50.0), (1999.0, 1000.0)] {
            assert!((round_below(x) / expected - 1.0).abs() < 1e-9, "{x}");
        }
    }

    #[test]
    fn peaks_are_drawn_by_their_roots() {
        assert_eq!(power(vec![0.3, 0.32, 0.31]), 1.0);
        assert_eq!(power(vec![0.3, 0.32, 100.0]), 1.0 / 3.0);
        assert_eq!(power(vec![0.0]), 1.0);
    }
}
