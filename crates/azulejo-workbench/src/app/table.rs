//! Tables as CSV files (RFC 4180).

use super::files::with_default_extension;
use super::{App, JobResult};
use std::borrow::Cow;
use std::path::PathBuf;

/// The text of a CSV file.
pub(super) struct CsvTable(String);

impl CsvTable {
    /// A table with a row of headings.
    pub fn new(headings: &[&str]) -> CsvTable {
        let mut table = CsvTable(String::new());
        table.row(headings.iter().map(|h| Cow::from(*h)));
        table
    }

    /// Adds a row.
    pub fn row<'a>(&mut self, cells: impl IntoIterator<Item = Cow<'a, str>>) {
        let cells: Vec<_> = cells.into_iter().map(quoted).collect();
        self.0 += &cells.join(",");
        self.0 += "\r\n";
    }
}

/// A number, or nothing.
pub(super) fn cell(number: Option<f64>) -> Cow<'static, str> {
    Cow::from(number.map_or(String::new(), |x| x.to_string()))
}

/// A cell in quotes where it has commas, quotes or ends of lines; quotes are doubled.
fn quoted(cell: Cow<'_, str>) -> Cow<'_, str> {
    if cell.contains([',', '"', '\n', '\r']) {
        Cow::from(format!("\"{}\"", cell.replace('"', "\"\"")))
    } else {
        cell
    }
}

impl App {
    /// Writes a table in the background: the whole file, or nothing of it.
    pub(super) fn save_table(&mut self, path: PathBuf, table: CsvTable) {
        let path = with_default_extension(path, "csv");
        let Some(output) = self.output(&path) else {
            return;
        };
        let note = format!("{}: {}", path.display(), self.tr("saved"));
        self.start_saving(path, move |progress, outbox| {
            output
                .write(progress, |out| out.write_all(table.0.as_bytes()))
                .map_err(|e| e.to_string())?;
            outbox.send(JobResult::Note(note));
            Ok(())
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_end_a_cell_is_quoted() {
        let mut table = CsvTable::new(&["name", "E"]);
        table.row([Cow::from("left, \"old\" wall"), cell(Some(0.25))]);
        table.row([Cow::from("floor"), cell(None)]);
        let expected = "name,E\r\n\"left, \"\"old\"\" wall\",0.25\r\nfloor,\r\n";
        assert_eq!(table.0, expected);
    }
}
