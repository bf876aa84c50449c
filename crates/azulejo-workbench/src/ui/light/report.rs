//! The solver's report: engine, patches, rays, time and memory.

use super::super::panel_context::PanelContext;
use super::{percent, row};
use crate::ui::viewport::number;
use azulejo::radiosity::{Method, Report};
use egui::{Grid, RichText, Ui};

pub fn show(ui: &mut Ui, cx: &PanelContext, report: &Report) {
    let grid = Grid::new("report").num_columns(2).spacing([12.0, 2.0]);
    grid.show(ui, |ui| rows(ui, cx, report));
    for note in &report.engine_used.notes {
        let text = RichText::new(format!("ℹ {note}")).small();
        ui.add(egui::Label::new(text).wrap());
    }
}

fn rows(ui: &mut Ui, cx: &PanelContext, report: &Report) {
    if !report.engine_used.name.is_empty() {
        let text = format!(
            "{} ({})",
            report.engine_used.name, report.engine_used.device
        );
        row(ui, cx.tr("Engine"), "", text);
    }
    let patches = count(report.patches as u64);
    let text = match report.method {
        Method::Matrix => {
            let rows = cx.tr("of form factors");
            format!("{patches}, {} {rows}", bytes(report.bytes))
        }
        Method::Stochastic => format!("{patches}, {}", cx.tr("without a matrix")),
        Method::Paths => format!("{patches}, {}", cx.tr("without radiosity")),
    };
    row(ui, cx.tr("Patches"), "", text);
    let gathered = report.points as u64 * u64::from(report.point_rays);
    let (patches, points) = (cx.tr("from patches"), cx.tr("from points"));
    let text = format!(
        "{} {patches}, {} {points}",
        count(report.patch_rays),
        count(gathered)
    );
    row(ui, cx.tr("Rays"), "", text);
    let about = cx.tr("Vertices at which light was gathered.");
    row(ui, cx.tr("Points"), about, count(report.points as u64));
    let residual = cx.tr("residual");
    let text = format!(
        "{}, {residual} {}",
        report.iterations,
        number(report.residual)
    );
    row(ui, cx.tr("Bounces"), "", text);
    if report.method == Method::Matrix {
        let mut text = percent(report.patch_error);
        if report.refined_rows > 0 {
            let refined = cx.tr("rows refined");
            text += &format!(", {} {refined}", count(report.refined_rows as u64));
        }
        let about = cx.tr("Estimated relative error of the patches' radiosity.");
        row(ui, cx.tr("Error of patches"), about, text);
    }
    let about = cx.tr("Estimated relative error of irradiance at the points.");
    row(ui, cx.tr("Estimated error"), about, percent(report.error));
}

/// A count with thin spaces between thousands, as is common to all languages of the window.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

fn bytes(n: usize) -> String {
    let n = n as f64;
    match n {
        n if n < 1024.0 => format!("{n:.0} B"),
        n if n < 1048576.0 => format!("{:.1} KiB", n / 1024.0),
        n if n < 1073741824.0 => format!("{:.1} MiB", n / 1048576.0),
        n => format!("{:.2} GiB", n / 1073741824.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_sizes_can_be_read() {
        assert_eq!(count(7), "7");
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(count(123_456), "123\u{202f}456");
        assert_eq!(bytes(1000), "1000 B");
        assert_eq!(bytes(3 << 19), "1.5 MiB");
    }
}
