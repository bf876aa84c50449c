//! The page of the report: introduction, machine, plots, tables, and explanations.

use super::super::record::{RunRecord, TaskOutcome, TaskRecord, TruthRecord};
use super::super::suite::Suite;
use super::tables::{RepeatedRun, repeated, short, truths};
use crate::charts::{ChartSpec, machine_table, page_head, plots};
use crate::drawing::escaped;
use crate::machine_info::MachineInfo;
use std::fmt::Write;

/// The content of the page.
pub struct Page<'a> {
    /// The suite, with title and introduction.
    pub suite: &'a Suite,
    /// The machine.
    pub machine: &'a MachineInfo,
    /// The results.
    pub records: &'a [&'a TaskRecord],
    /// The plots.
    pub figures: &'a [ChartSpec],
}

/// Errors above this, in standard errors, are marked.
const FAR: f64 = 4.0;

impl Page<'_> {
    /// The page as one file.
    pub fn html(&self) -> String {
        let mut out = String::new();
        // Writing to a string does not fail.
        let _ = self.write(&mut out);
        out
    }

    fn write(&self, out: &mut String) -> std::fmt::Result {
        let title = escaped(&self.suite.title);
        out.push_str(&page_head(&title));
        for paragraph in self.suite.about.trim().split("\n\n") {
            writeln!(out, "<p>{}</p>", escaped(paragraph))?;
        }
        machine_table(self.machine, out)?;
        plots(self.figures, bars, out)?;
        self.slopes(out)?;
        self.runs(out)?;
        self.answers(out)?;
        self.skipped(out)?;
        self.failures(out)?;
        out.push_str(READING);
        out.push_str("</body></html>\n");
        Ok(())
    }

    /// The fitted exponents of all plots with logarithmic axes.
    fn slopes(&self, out: &mut String) -> std::fmt::Result {
        let fits = self.figures.iter().flat_map(|figure| {
            let fit = move |s| Some((figure, s, figure.growth(s)?));
            figure.series.iter().filter_map(fit)
        });
        let fits: Vec<_> = fits.collect();
        if fits.is_empty() {
            return Ok(());
        }
        out.push_str(
            "<details><summary>Fitted slopes</summary>\n<p>The exponent n of y = c xⁿ by least squares of the \
             logarithms of the means, and its standard error from their scatter about the line.</p>\n\
             <div class=\"wide\"><table><thead><tr><th>scene</th><th>y</th><th>x</th><th>line</th>\
             <th class=\"n\">points</th><th class=\"n\">n</th><th class=\"n\">±</th></tr></thead><tbody>\n",
        );
        for (figure, series, growth) in fits {
            writeln!(
                out,
                "<tr><th>{}</th><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td>\
                 <td class=\"n\">{:.3}</td><td class=\"n\">{}</td></tr>",
                escaped(&figure.title),
                figure.y.label,
                figure.x.label,
                escaped(&series.name),
                series.points.len(),
                growth.exponent,
                growth.error.map_or("–".to_owned(), |e| format!("{e:.3}")),
            )?;
        }
        out.push_str("</tbody></table></div></details>\n");
        Ok(())
    }

    fn runs(&self, out: &mut String) -> std::fmt::Result {
        let rows = repeated(self.records);
        let mut scene = "";
        for row in &rows {
            if scene.is_empty() {
                out.push_str(
                    "<h2>Results</h2>\n<p>Means over repetitions, ± the standard deviation of one; n is their number.</p>\n",
                );
            }
            if row.run.scene != scene {
                if !scene.is_empty() {
                    out.push_str("</tbody></table></div>\n");
                }
                scene = &row.run.scene;
                let facets = row.run.facets;
                writeln!(out, "<h3>{}</h3>\n<p>{facets} facets</p>", escaped(scene))?;
                table_head(out, COLUMNS.iter().map(|c| (c.0, c.1)))?;
            }
            write_row(out, row)?;
        }
        if !rows.is_empty() {
            out.push_str("</tbody></table></div>\n");
        }
        Ok(())
    }

    fn answers(&self, out: &mut String) -> std::fmt::Result {
        // The records of one setting follow each other, so each name is left once.
        let truths = truths(self.records);
        let mut settings: Vec<&str> = truths.iter().map(|t| t.setting.as_str()).collect();
        settings.dedup();
        if settings.is_empty() {
            return Ok(());
        }
        out.push_str("<h2>Known solutions</h2>\n");
        summary_of_truths(out, &truths, &settings)?;
        out.push_str(
            "<p>The error is the engine's solution minus the exact one; σ is the error in units of the \
             engine's standard error, after subtracting the uncertainty of the exact solution.</p>\n",
        );
        // Cases stand in the order of their first solution, whichever setting it is from.
        let mut cases: Vec<&TruthRecord> = Vec::new();
        for truth in &truths {
            if !cases.iter().any(|c| c.case == truth.case) {
                cases.push(truth);
            }
        }
        // The head has two lines, since each setting has a group of four columns.
        out.push_str("<div class=\"wide\"><table><thead><tr><th rowspan=\"2\">case</th><th rowspan=\"2\" class=\"n\">exact</th>");
        for name in &settings {
            write!(
                out,
                "<th colspan=\"4\" class=\"group\">{}</th>",
                escaped(name)
            )?;
        }
        out.push_str("</tr><tr>");
        for _ in &settings {
            out.push_str("<th class=\"n group\">solution</th><th class=\"n\">error</th><th class=\"n\">±</th><th class=\"n\">σ</th>");
        }
        out.push_str("</tr></thead><tbody>\n");
        // A setting without a solution of a case leaves its columns empty.
        for case in cases {
            write!(
                out,
                "<tr><th title=\"{} ({})\">{}</th><td class=\"n\">{:.10}</td>",
                escaped(&case.words),
                escaped(&case.source),
                escaped(&case.case),
                case.truth
            )?;
            for name in &settings {
                let answer = truths
                    .iter()
                    .find(|t| t.case == case.case && t.setting == *name);
                write_answer(out, answer.copied())?;
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</tbody></table></div>\n");
        Ok(())
    }

    fn skipped(&self, out: &mut String) -> std::fmt::Result {
        let skipped = self.records.iter().filter_map(|r| match &r.outcome {
            TaskOutcome::Skipped { task, reason } => Some((task, reason)),
            _ => None,
        });
        // One line for all tasks that lack the same.
        let mut reasons: Vec<(&String, Vec<&String>)> = Vec::new();
        for (task, reason) in skipped {
            match reasons.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, tasks)) => tasks.push(task),
                None => reasons.push((reason, vec![task])),
            }
        }
        if reasons.is_empty() {
            return Ok(());
        }
        out.push_str("<h2>Not available here</h2>\n<p>Optional engines that this machine or this build lacks. They are tried again by the next run.</p>\n<dl>\n");
        for (reason, tasks) in reasons {
            writeln!(out, "<dt>{}</dt><dd><ul>", escaped(reason))?;
            for task in tasks {
                writeln!(out, "<li>{}</li>", escaped(task))?;
            }
            out.push_str("</ul></dd>\n");
        }
        out.push_str("</dl>\n");
        Ok(())
    }

    fn failures(&self, out: &mut String) -> std::fmt::Result {
        let mut is_first = true;
        for record in self.records {
            let TaskOutcome::Failure { task, reason } = &record.outcome else {
                continue;
            };
            if std::mem::take(&mut is_first) {
                out.push_str(
                    "<h2>Failed tasks</h2>\n<p>They are repeated by the next run.</p>\n<ul>\n",
                );
            }
            writeln!(
                out,
                "<li><b>{}</b>: {}</li>",
                escaped(task),
                escaped(reason)
            )?;
        }
        if !is_first {
            out.push_str("</ul>\n");
        }
        Ok(())
    }
}

/// Heading, explanation and value of a column of results.
type Column = (&'static str, &'static str, fn(&RepeatedRun) -> Option<f64>);

/// A measure of a matrix, where there is one.
fn if_matrix(run: &RunRecord, measure: f64) -> Option<f64> {
    (run.entries > 0).then_some(measure)
}

const COLUMNS: [Column; 14] = [
    ("samples", "rays or pixels per row", |r| {
        r.mean(|r| (r.samples > 0.0).then_some(r.samples))
    }),
    ("time, s", "form factors, wall-clock time", |r| {
        r.mean(|r| Some(r.seconds))
    }),
    ("CPU, s", "form factors, CPU time of all threads", |r| {
        r.mean(|r| Some(r.cpu_seconds))
    }),
    ("MiB", "peak memory of the process", |r| {
        r.mean(|r| r.peak_bytes.map(|b| b as f64 / f64::from(1 << 20)))
    }),
    ("row error", "mean of Σ|X − R|/ΣR over rows", |r| {
        r.mean(|r| r.row_error_mean)
    }),
    ("largest", "largest of them", |r| {
        r.mean(|r| r.row_error_max)
    }),
    (
        "stated",
        "mean row error, as estimated by the engine",
        |r| r.mean(|r| r.row_error_stated),
    ),
    ("B error", "mean of |B/B_ref − 1| over facets", |r| {
        r.mean(|r| r.b_error_mean)
    }),
    ("largest", "largest of them", |r| r.mean(|r| r.b_error_max)),
    (
        "closure",
        "root mean square deviation of row sums from 1",
        |r| r.mean(|r| if_matrix(r, r.closure_rms)),
    ),
    (
        "moved",
        "share of the matrix moved to enforce closure",
        |r| r.mean(|r| if_matrix(r, r.moved)),
    ),
    (
        "reciprocity",
        "largest |A_i X_ij − A_j X_ji|, relative to the mean entry of the row",
        |r| r.mean(|r| if_matrix(r, r.reciprocity)),
    ),
    ("energy", "unaccounted power, relative", |r| {
        r.mean(|r| r.energy)
    }),
    ("solve, s", "solution of B = M + ρXB", |r| {
        r.mean(|r| if_matrix(r, r.solve_seconds))
    }),
];

fn table_head<'a>(
    out: &mut String,
    columns: impl Iterator<Item = (&'a str, &'a str)>,
) -> std::fmt::Result {
    out.push_str("<div class=\"wide\"><table><thead><tr><th>engine</th>");
    for (name, title) in columns {
        write!(out, "<th class=\"n\" title=\"{title}\">{name}</th>")?;
    }
    out.push_str(
        "<th class=\"n\" title=\"repetitions\">n</th><th>engine used</th></tr></thead><tbody>\n",
    );
    Ok(())
}

fn write_row(out: &mut String, row: &RepeatedRun) -> std::fmt::Result {
    let class = if row.is_reference {
        " class=\"reference\""
    } else {
        ""
    };
    write!(out, "<tr{class}><th>{}</th>", escaped(&row.run.setting))?;
    for (name, _, value) in COLUMNS {
        let text = value(row).map_or("–".to_owned(), short);
        let spread = match name {
            "time, s" => row.deviation(|r| Some(r.seconds)),
            "CPU, s" => row.deviation(|r| Some(r.cpu_seconds)),
            "row error" => row.deviation(|r| r.row_error_mean),
            "B error" => row.deviation(|r| r.b_error_mean),
            _ => None,
        };
        let spread = spread.map_or(String::new(), |s| format!(" ± {}", short(s)));
        write!(out, "<td class=\"n\">{text}{spread}</td>")?;
    }
    let RunRecord {
        ran, device, notes, ..
    } = row.run;
    writeln!(
        out,
        "<td class=\"n\">{}</td><td title=\"{}\">{}</td></tr>",
        row.count(),
        escaped(&notes.join("; ")),
        escaped(&format!("{ran} ({device})"))
    )
}

/// One line for each engine: the number of solutions within 4 σ, and their errors.
fn summary_of_truths(
    out: &mut String,
    truths: &[&TruthRecord],
    settings: &[&str],
) -> std::fmt::Result {
    out.push_str(
        "<table><thead><tr><th>engine</th><th class=\"n\">cases</th><th class=\"n\">within 4 σ</th>\
         <th class=\"n\">median |error|</th><th class=\"n\">largest |error|</th><th class=\"n\">time, s</th>\
         <th>engine used</th></tr></thead><tbody>\n",
    );
    for name in settings {
        let mine: Vec<&&TruthRecord> = truths.iter().filter(|t| t.setting == **name).collect();
        let is_near = |t: &&&&TruthRecord| t.standard_errors.is_some_and(|s| s <= FAR);
        let near = mine.iter().filter(is_near).count();
        let mut off: Vec<f64> = mine.iter().map(|t| (t.value - t.truth).abs()).collect();
        off.sort_by(f64::total_cmp);
        let mut ran: Vec<&str> = mine.iter().map(|t| t.ran.as_str()).collect();
        ran.sort_unstable();
        ran.dedup();
        writeln!(
            out,
            "<tr><th>{}</th><td class=\"n\">{}</td><td class=\"n\">{near}</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td></tr>",
            escaped(name),
            mine.len(),
            off.get(off.len() / 2).map_or("–".to_owned(), |x| short(*x)),
            off.last().map_or("–".to_owned(), |x| short(*x)),
            short(mine.iter().map(|t| t.seconds).sum()),
            escaped(&ran.join(", ")),
        )?;
    }
    out.push_str("</tbody></table>\n");
    Ok(())
}

fn write_answer(out: &mut String, answer: Option<&TruthRecord>) -> std::fmt::Result {
    let Some(t) = answer else {
        out.push_str("<td class=\"group\"></td><td></td><td></td><td></td>");
        return Ok(());
    };
    let is_far = t.standard_error.is_some() && t.standard_errors.is_none_or(|s| s > FAR);
    let sigma = t
        .standard_errors
        .map_or("∞".to_owned(), |s| format!("{s:.1}"));
    let (sigma, error) = match t.standard_error {
        Some(error) => (sigma, format!("{error:.1e}")),
        None => ("–".to_owned(), "–".to_owned()),
    };
    write!(
        out,
        "<td class=\"n group\">{:.10}</td><td class=\"n\">{:.1e}</td><td class=\"n\">{error}</td>\
         <td class=\"n{}\">{sigma}</td>",
        t.value,
        t.value - t.truth,
        if is_far { " far" } else { "" },
    )
}

/// What the bars and slopes of a plot mean.
fn bars(figure: &ChartSpec) -> &'static str {
    if figure.has_spread() {
        ". Bars: standard deviation between repetitions."
    } else {
        "."
    }
}

/// Explanations of the numbers.
const READING: &str = include_str!("reading.html");
