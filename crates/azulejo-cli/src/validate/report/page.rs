//! The page: summary, engines, plots, tables of all checks, and what they mean.

use super::super::args::ValidateArgs;
use super::super::engines::CheckedEngines;
use super::super::record::{CheckOutcome, CheckRecord, ValidationPart};
use super::super::{ValidationResults, closed_forms};
use crate::charts::{ChartSpec, machine_table, page_head, plots};
use crate::drawing::escaped;
use crate::machine_info::MachineInfo;
use crate::report::{seconds, short};
use std::fmt::Write;

/// The content of the page.
pub struct ValidationPage<'a> {
    /// The arguments.
    pub args: &'a ValidateArgs,
    /// What came out.
    pub results: &'a ValidationResults,
    /// The engines, with those that are not here.
    pub engines: &'a CheckedEngines,
    /// The machine.
    pub machine: &'a MachineInfo,
    /// The plots.
    pub figures: &'a [ChartSpec],
}

/// What the parts check, and when a check passes.
const ABOUT: &str = include_str!("about.html");

impl ValidationPage<'_> {
    /// The page as one file.
    pub fn html(&self) -> String {
        let mut out = String::new();
        // Writing to a string does not fail.
        let _ = self.write(&mut out);
        out
    }

    fn write(&self, out: &mut String) -> std::fmt::Result {
        let title = format!("Validation of azulejo {}", env!("CARGO_PKG_VERSION"));
        out.push_str(&page_head(&title));
        self.verdict(out)?;
        self.parts(out)?;
        self.engines(out)?;
        self.peers(out)?;
        machine_table(self.machine, out)?;
        plots(self.figures, |_| ".", out)?;
        out.push_str(ABOUT);
        for part in ValidationPart::ALL {
            self.table(part, out)?;
        }
        out.push_str("</body></html>\n");
        Ok(())
    }

    fn verdict(&self, out: &mut String) -> std::fmt::Result {
        let number = |outcome| self.results.total(outcome);
        let (failed, all) = (number(CheckOutcome::Failed), self.results.records.len());
        let words = match failed {
            0 => format!("All {all} checks passed"),
            _ => format!("<b class=\"far\">{failed} of {all} checks failed</b>"),
        };
        let outlying = match number(CheckOutcome::Outlying) {
            0 => String::new(),
            n => format!(
                "; {n} of them are estimates beyond {} standard errors, no more than chance allows",
                closed_forms::FAR
            ),
        };
        let outlying = if failed == 0 { outlying } else { String::new() };
        let effort = if self.args.full {
            ""
        } else {
            " <code>--full</code> has eight times the rays, and more pixels and repetitions."
        };
        writeln!(
            out,
            "<p>{words}{outlying}. It took {}.{effort} The numbers are also in \
             <a href=\"results.csv\">results.csv</a> and <a href=\"results.json\">results.json</a>.</p>",
            seconds(self.results.seconds)
        )
    }

    fn parts(&self, out: &mut String) -> std::fmt::Result {
        out.push_str(
            "<table><thead><tr><th>part</th><th class=\"n\">passed</th><th class=\"n\">outlying</th>\
             <th class=\"n\">failed</th><th class=\"n\">time</th></tr></thead><tbody>\n",
        );
        for part in ValidationPart::ALL {
            let records = self.of(part);
            if records.is_empty() {
                continue;
            }
            let number = |outcome| self.results.number(part, outcome);
            let failed = number(CheckOutcome::Failed);
            writeln!(
                out,
                "<tr><th><a href=\"#{}\">{part}</a></th><td class=\"n\">{}</td><td class=\"n\">{}</td>\
                 <td class=\"n{}\">{failed}</td><td class=\"n\">{}</td></tr>",
                anchor(part),
                number(CheckOutcome::Passed),
                number(CheckOutcome::Outlying),
                if failed > 0 { " far" } else { "" },
                seconds(records.iter().map(|r| r.seconds).sum()),
            )?;
        }
        out.push_str("</tbody></table>\n");
        Ok(())
    }

    /// One line for each engine: the closed forms it computed.
    fn engines(&self, out: &mut String) -> std::fmt::Result {
        out.push_str(
            "<h2>Engines</h2>\n<p>The closed forms by each engine.</p>\n<table><thead><tr><th>engine</th>\
             <th class=\"n\">cases</th><th class=\"n\">within 4 σ or their bound</th>\
             <th class=\"n\">median relative error</th><th class=\"n\">largest</th><th class=\"n\">time</th>\
             </tr></thead><tbody>\n",
        );
        for engine in &self.engines.engines {
            let records = self.of(ValidationPart::ClosedForms).into_iter();
            // Not the number of outlying ones, whose expected value is 0.
            let is_ours = |r: &&CheckRecord| r.engine == engine.name && r.expected != 0.0;
            let records: Vec<&CheckRecord> = records.filter(is_ours).collect();
            if records.is_empty() {
                continue;
            }
            let relative = |r: &&CheckRecord| (r.deviation() / r.expected).abs();
            let mut errors: Vec<f64> = records.iter().map(relative).collect();
            errors.sort_by(f64::total_cmp);
            let passed = records.iter().filter(|r| r.outcome == CheckOutcome::Passed);
            writeln!(
                out,
                "<tr><th>{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
                 <td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
                engine.name,
                records.len(),
                passed.count(),
                short(errors[errors.len() / 2]),
                short(errors[errors.len() - 1]),
                seconds(records.iter().map(|r| r.seconds).sum()),
            )?;
        }
        out.push_str("</tbody></table>\n");
        for (name, why) in &self.engines.missing {
            writeln!(out, "<p>Not checked here: {name}. {}</p>", escaped(why))?;
        }
        Ok(())
    }

    /// One line for each program that answered closed forms, after ours with the same ones.
    fn peers(&self, out: &mut String) -> std::fmt::Result {
        let Some(peers) = &self.results.peers else {
            return Ok(());
        };
        out.push_str(
            "<h2>Other programs</h2>\n<p>Closed forms between whole triangles and quadrilaterals, some with others in \
             between, by programs that are installed here, and the same ones by azulejo. Of the engines it is the time on \
             the clock.</p>\n<table><thead><tr><th>program</th><th class=\"n\">cases</th>\
             <th class=\"n\">relative error, RMS</th><th class=\"n\">largest</th><th class=\"n\">time</th></tr></thead>\
             <tbody>\n",
        );
        let most = (peers.answered.iter()).max_by_key(|peer| peer.answers.len());
        let engines = self.engines.engines.iter();
        let ours = engines.filter_map(|e| Some(most?.of_engine(e.name, &self.results.records)));
        for answers in ours.collect::<Vec<_>>().iter().chain(&peers.answered) {
            if answers.answers.is_empty() {
                continue;
            }
            let [typical, largest] = answers.errors();
            writeln!(
                out,
                "<tr><th>{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
                 <td class=\"n\">{}</td></tr>",
                escaped(&answers.program),
                answers.answers.len(),
                short(typical),
                short(largest),
                seconds(answers.seconds),
            )?;
        }
        out.push_str("</tbody></table>\n");
        for (name, why) in &peers.missing {
            writeln!(out, "<p>Not asked: {name}. {}</p>", escaped(why))?;
        }
        Ok(())
    }

    fn of(&self, part: ValidationPart) -> Vec<&CheckRecord> {
        let records = self.results.records.iter();
        records.filter(|r| r.part == part).collect()
    }

    /// All checks of a part: what failed first, then the engines in their order.
    fn table(&self, part: ValidationPart, out: &mut String) -> std::fmt::Result {
        let mut records = self.of(part);
        if records.is_empty() {
            return Ok(());
        }
        records.sort_by_key(|r| match r.outcome {
            CheckOutcome::Failed => 0,
            CheckOutcome::Outlying => 1,
            CheckOutcome::Passed => 2,
        });
        writeln!(
            out,
            "<h2 id=\"{}\">All checks of {part}</h2>\n<details><summary>{} checks</summary>\n\
             <div class=\"wide\"><table><thead><tr><th>check</th><th>engine</th><th>what</th>\
             <th class=\"n\">found</th><th class=\"n\">expected</th><th class=\"n\">found − expected</th>\
             <th class=\"n\">σ</th><th class=\"n\">bound</th><th>unit</th><th>result</th><th>note</th></tr>\
             </thead><tbody>",
            anchor(part),
            records.len()
        )?;
        records.iter().try_for_each(|r| row(r, out))?;
        out.push_str("</tbody></table></div></details>\n");
        Ok(())
    }
}

/// The name of a part in addresses.
fn anchor(part: ValidationPart) -> String {
    part.to_string().replace(' ', "-")
}

fn row(record: &CheckRecord, out: &mut String) -> std::fmt::Result {
    let error = record.standard_error;
    let class = match record.outcome {
        CheckOutcome::Passed => "",
        CheckOutcome::Outlying | CheckOutcome::Failed => " class=\"far\"",
    };
    writeln!(
        out,
        "<tr><th>{}</th><td>{}</td><td title=\"{}\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
         <td class=\"n\">{:.1e}</td><td class=\"n\">{}</td><td class=\"n\">{:.1e}</td><td>{}</td>\
         <td{class}>{}</td><td>{}</td></tr>",
        escaped(&record.subject),
        record.engine,
        escaped(&record.source),
        escaped(&record.description),
        value(record.found),
        value(record.expected),
        record.deviation(),
        error.map_or("–".to_owned(), |e| format!("{e:.1e}")),
        record.bound,
        record.unit,
        format!("{:?}", record.outcome).to_lowercase(),
        escaped(&record.note),
    )
}

/// A number with ten digits, without trailing zeros.
fn value(x: f64) -> String {
    let text = match x.abs() {
        0.0 => return "0".to_owned(),
        m if (1e-3..1e7).contains(&m) => format!("{x:.10}"),
        _ => return format!("{x:.6e}"),
    };
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
