//! Reads every file of the corpus, and compares it column by column with counts from other programs
//! and plain counts: `cargo test -p azulejo-formats --test corpus [-- PART-OF-A-PATH...]`.
//!
//! A program of its own and not part of `it`, because its output is as important as its result: one
//! table with a line per file. [`rules`] defines which columns each format is compared with and
//! where and why azulejo differs; a difference that no rule explains is a failure, and so is a rule
//! that is no longer needed.

#![allow(clippy::print_stdout, reason = "the table is what it is for")]

mod counts;
mod rules;
mod truth;

use azulejo_formats::{Folder, ReadError, RecognizedModel, grf};
use counts::Counts;
use rules::{Exception, Expected, Quantity, Rules};
use std::path::Path;
use std::process::ExitCode;
use truth::{Row, Table};

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if words.iter().any(|w| w == "--list") {
        return ExitCode::SUCCESS;
    }
    let Some(data) = azulejo_testing::data() else {
        return ExitCode::SUCCESS;
    };
    let corpus = data.join("corpus");
    let parts: Vec<&str> = words
        .iter()
        .map(String::as_str)
        .filter(|w| !w.starts_with('-'))
        .collect();
    let wanted = |path: &str| parts.is_empty() || parts.iter().any(|part| path.contains(part));
    let lines: Vec<Line> = Table::read(&corpus)
        .rows()
        .filter(|row| wanted(row.path()))
        .filter_map(|row| Some(check(&corpus, row, rules::of(row.path())?)))
        .collect();
    print(&lines);
    if lines.iter().all(|line| line.result != Outcome::Differs) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// The result for a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Every compared column agrees.
    Same,
    /// Some differ, and a rule explains why azulejo is right.
    Explained,
    /// Rejected, as expected.
    Refused,
    /// An unexplained difference.
    Differs,
}

/// One file.
struct Line {
    path: String,
    result: Outcome,
    counts: Option<Counts>,
    warnings: usize,
    source_bytes: u64,
    grf_bytes: Option<u64>,
    reasons: Vec<String>,
}

fn check(corpus: &Path, row: &Row, rules: &Rules) -> Line {
    let path = row.path();
    let exceptions: Vec<&Exception> = rules.about(path).collect();
    let file = corpus.join(path);
    let mut line = Line {
        path: path.to_owned(),
        result: Outcome::Same,
        counts: None,
        warnings: 0,
        source_bytes: std::fs::metadata(&file).map_or(0, |m| m.len()),
        grf_bytes: None,
        reasons: Vec::new(),
    };
    match read(&file, rules.allowed(path).map(|folder| corpus.join(folder))) {
        Err(error) => line.refused(&error, row, &exceptions),
        Ok(loaded) => line.accepted(&loaded, row, rules, &exceptions),
    }
    line
}

fn read(path: &Path, allowed: Option<std::path::PathBuf>) -> Result<RecognizedModel, ReadError> {
    let bytes = std::fs::read(path).expect("a readable file");
    let name = path.file_name().expect("a file name").to_string_lossy();
    let mut folder = Folder::of_model(path);
    if let Some(allowed) = allowed {
        folder = folder.allow(allowed);
    }
    azulejo_formats::read(&bytes, &name, &folder)
}

impl Line {
    fn say(&mut self, result: Outcome, reason: impl Into<String>) {
        // One unexplained difference outweighs all explained ones.
        if self.result != Outcome::Differs {
            self.result = result;
        }
        self.reasons.push(reason.into());
    }

    fn refused(&mut self, error: &ReadError, row: &Row, exceptions: &[&Exception]) {
        let said = error.to_string();
        let said = said.lines().next().unwrap_or_default().to_owned();
        let meant = |e: &&&Exception| e.expected == Expected::Refused;
        match exceptions.iter().find(meant) {
            Some(e) => self.say(Outcome::Refused, format!("{}: {said}", e.why)),
            None if row.is_invalid() => self.say(Outcome::Refused, said),
            None => self.say(Outcome::Differs, said),
        }
    }

    fn accepted(
        &mut self,
        loaded: &RecognizedModel,
        row: &Row,
        rules: &Rules,
        exceptions: &[&Exception],
    ) {
        let counts = Counts::of(&loaded.scene);
        self.warnings = loaded.warnings.len();
        if let Err(invalid) = loaded.scene.validate() {
            self.say(Outcome::Differs, format!("an invalid scene: {invalid}"));
        }
        if self.warnings == 0 && (row.is_invalid() || loaded.scene.objects.is_empty()) {
            let what = "nothing said about a file that is damaged or without surfaces";
            self.say(Outcome::Differs, what);
        }
        for (quantity, columns) in rules.compared {
            let exception = exceptions.iter().find(|e| e.quantity == *quantity);
            self.compare(&counts, row, *quantity, columns, exception.copied());
        }
        if exceptions.iter().any(|e| e.expected == Expected::Refused) {
            self.say(Outcome::Differs, "was to be refused");
        }
        self.grf_bytes = Some(grf_size(loaded));
        self.counts = Some(counts);
    }

    fn compare(
        &mut self,
        counts: &Counts,
        row: &Row,
        quantity: Quantity,
        columns: &[&str],
        exception: Option<&Exception>,
    ) {
        let plain = rules::agrees(counts, row, quantity, columns);
        match (exception, plain) {
            (None, Ok(())) => {}
            (None, Err(how)) => self.say(Outcome::Differs, how),
            (Some(e), Ok(())) => {
                let why = e.why;
                self.say(Outcome::Differs, format!("needs no exception: {why}"));
            }
            (Some(e), Err(how)) => match e.holds(counts, row) {
                Ok(()) => self.say(Outcome::Explained, format!("{how}: {}", e.why)),
                Err(how) => self.say(Outcome::Differs, how),
            },
        }
    }
}

/// Size of the scene as GRF, the last column of Table 1 of *Wannabe Amazing* (2001).
fn grf_size(loaded: &RecognizedModel) -> u64 {
    let mut written = Vec::new();
    grf::write(&loaded.scene, &mut written).expect("memory takes all");
    written.len() as u64
}

fn print(lines: &[Line]) {
    println!(
        "{:9} {:>7} {:>8} {:>8} {:>9} {:>8} {:>9} {:>9}  file",
        "", "objects", "vertices", "faces", "triangles", "warnings", "source", "as GRF"
    );
    for line in lines {
        let result = match line.result {
            Outcome::Same => "ok",
            Outcome::Explained => "explained",
            Outcome::Refused => "refused",
            Outcome::Differs => "DIFFERS",
        };
        let cells = match &line.counts {
            Some(c) => [c.objects, c.vertices, c.faces, c.triangles].map(|n| n.to_string()),
            None => [const { String::new() }; 4],
        };
        let [objects, vertices, faces, triangles] = cells;
        let size = |bytes: u64| format!("{:.1}K", bytes as f64 / 1024.0);
        println!(
            "{result:9} {objects:>7} {vertices:>8} {faces:>8} {triangles:>9} {:>8} {:>9} {:>9}  {}",
            line.warnings,
            size(line.source_bytes),
            line.grf_bytes.map(size).unwrap_or_default(),
            line.path,
        );
        for reason in &line.reasons {
            println!("{:9}   {reason}", "");
        }
    }
    let count = |result| lines.iter().filter(|l| l.result == result).count();
    println!(
        "{} files: {} ok, {} explained, {} refused, {} differ",
        lines.len(),
        count(Outcome::Same),
        count(Outcome::Explained),
        count(Outcome::Refused),
        count(Outcome::Differs),
    );
}
