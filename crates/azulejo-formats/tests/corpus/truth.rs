//! The table of reference counts from other programs.

use std::collections::BTreeMap;
use std::path::Path;

/// All files, by path.
pub struct Table(Vec<Row>);

/// One file: cells by column name, and the notes of the manifest.
pub struct Row {
    cells: BTreeMap<String, String>,
    note: String,
}

impl Table {
    /// Reads `TRUTH.tsv` and the notes of `MANIFEST.tsv`.
    pub fn read(corpus: &Path) -> Table {
        let manifest = rows(&corpus.join("MANIFEST.tsv"));
        let note = |path: &str| {
            let row = manifest.iter().find(|r| r["path"] == path);
            row.and_then(|r| r.get("note")).cloned().unwrap_or_default()
        };
        let truth = rows(&corpus.join("TRUTH.tsv")).into_iter();
        Table(
            truth
                .map(|cells| Row {
                    note: note(&cells["path"]),
                    cells,
                })
                .collect(),
        )
    }

    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.0.iter()
    }
}

fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(path).expect("a readable table");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split('\t').collect();
    lines
        .map(|line| {
            let cells = line.split('\t').map(str::to_owned);
            header.iter().map(|h| (*h).to_owned()).zip(cells).collect()
        })
        .collect()
}

impl Row {
    /// Where the file is in the corpus.
    pub fn path(&self) -> &str {
        &self.cells["path"]
    }

    /// Whether the file is damaged, so that it must be rejected or warned about.
    pub fn is_invalid(&self) -> bool {
        self.note.contains("INVALID")
    }

    /// A count, if the column has one.
    pub fn count(&self, column: &str) -> Option<usize> {
        self.cells.get(column)?.parse().ok()
    }

    /// A bounding box; `column` is the prefix of `_bbox_min` and `_bbox_max`.
    pub fn bounds(&self, column: &str) -> Option<[[f64; 3]; 2]> {
        let corner = |end: &str| -> Option<[f64; 3]> {
            let text = self.cells.get(&format!("{column}_bbox_{end}"))?;
            let numbers: Vec<f64> = text.split(' ').filter_map(|w| w.parse().ok()).collect();
            numbers.try_into().ok()
        };
        Some([corner("min")?, corner("max")?])
    }
}
