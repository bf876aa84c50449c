//! What pages of reports have in common, and how they are written beside their plots.

use super::{ChartSpec, page_style, svg};
use crate::drawing::escaped;
use crate::failure::Failure;
use crate::machine_info::MachineInfo;
use azulejo::output::{Output, commit};
use azulejo_trace::Progress;
use std::fmt;
use std::io::Write;
use std::path::Path;

/// The beginning of a page; the title is HTML.
pub fn page_head(title: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>{title}</title>\n<style>\n{}</style></head>\n<body>\n<h1>{title}</h1>\n",
        page_style()
    )
}

/// The machine, as a table.
pub fn machine_table(machine: &MachineInfo, out: &mut impl fmt::Write) -> fmt::Result {
    out.write_str("<h2>Measured on</h2>\n<table class=\"facts\">\n")?;
    for (name, words) in machine.lines() {
        writeln!(out, "<tr><th>{name}</th><td>{}</td></tr>", escaped(&words))?;
    }
    out.write_str("</table>\n")
}

/// All plots, with links to their files; `remark` ends the caption of each.
pub fn plots(
    figures: &[ChartSpec],
    remark: impl Fn(&ChartSpec) -> &'static str,
    out: &mut impl fmt::Write,
) -> fmt::Result {
    if figures.is_empty() {
        return Ok(());
    }
    out.write_str("<h2>Plots</h2>\n<div class=\"plots\">\n")?;
    for figure in figures {
        writeln!(
            out,
            "<figure>{}<figcaption>{} against {}{} <a href=\"{}.svg\">SVG</a></figcaption></figure>",
            svg(figure),
            figure.y.label,
            figure.x.label,
            remark(figure),
            figure.name,
        )?;
    }
    out.write_str("</div>\n")
}

/// Writes the files of a report and its plots into a folder; replaces those of an earlier one
/// together or not at all.
pub fn write_report(
    folder: &Path,
    mut files: Vec<(String, String)>,
    figures: &[ChartSpec],
    progress: &Progress,
) -> Result<(), Failure> {
    let plots = figures.iter().map(|f| (format!("{}.svg", f.name), svg(f)));
    files.extend(plots);
    let mut drafts = Vec::new();
    for (name, text) in files {
        let mut draft = Output::check(&folder.join(name))?.draft()?;
        let written = draft.write_all(text.as_bytes());
        written.map_err(|e| draft.error(e))?;
        drafts.push(draft);
    }
    Ok(commit(drafts, progress)?)
}
