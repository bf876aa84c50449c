//! `info --table`: several models in rows, as Table 1 of *Wannabe Amazing* (2001).

use super::failure::Failure;
use super::info::{InfoArgs, TableFormat};
use super::input::{self, ClockArgs, InputArgs};
use super::report::{Report, bytes, count, csv_cell, number};
use super::session::Session;
use super::surroundings::args::SurroundingsArgs;
use azulejo_formats::grf;
use azulejo_scene::{MaterialId, Scene, Shape};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::Path;

/// The headings, and whether a column is numbers.
const COLUMNS: [(&str, bool); 8] = [
    ("model", false),
    ("source", true),
    ("objects", true),
    ("materials", true),
    ("vertices", true),
    ("faces", true),
    ("GRF", true),
    ("ratio", true),
];

/// One model.
struct ModelRow {
    name: String,
    /// Bytes of the file; those that it refers to do not count.
    source: u64,
    objects: usize,
    /// Materials that any surface has.
    materials: usize,
    vertices: usize,
    faces: usize,
    /// Bytes as GRF.
    grf: u64,
}

/// Runs `info --table`; the second result is the end of the command after its report.
pub fn run(
    args: &InfoArgs,
    session: &mut Session,
) -> Result<(Report, Result<(), Failure>), Failure> {
    session.list_warnings();
    let mut rows = Vec::new();
    let mut failures = Vec::new();
    for path in &args.input.scenes {
        match row(path, &args.input, session) {
            Ok(row) => rows.push(row),
            Err(Failure::Failed(words)) => failures.push(words),
            Err(other) => return Err(other),
        }
    }
    let mut report = Report::default();
    let lines = match args.format {
        TableFormat::Text => aligned(&rows),
        TableFormat::Csv => separated(&rows),
        TableFormat::Markdown => markdown(&rows),
    };
    lines.into_iter().for_each(|line| report.plain(line));
    let values: Vec<Value> = rows.iter().map(ModelRow::value).collect();
    report.value("models", values);
    report.value("failures", failures.clone());
    let end = if failures.is_empty() {
        Ok(())
    } else {
        Err(Failure::Failed(failures.join("\nerror: ")))
    };
    Ok((report, end))
}

fn row(path: &Path, input: &InputArgs, session: &mut Session) -> Result<ModelRow, Failure> {
    if path == Path::new("-") {
        return Err(Failure::misuse(
            "--table needs files: a stream has no size of its own",
        ));
    }
    let source = path.metadata();
    let one = InputArgs {
        scenes: vec![path.to_owned()],
        lights: None,
        lamp: Vec::new(),
        outside: SurroundingsArgs::default(),
        reading: input.reading.clone(),
    };
    let scene = input::read_all(&one, ClockArgs::default(), session)?;
    let mut size = CountedBytes(0);
    grf::write(&scene, &mut size).map_err(|e| Failure::file("measure", path, &e))?;
    let mut row = ModelRow {
        name: path.display().to_string(),
        source: source.map_err(|e| Failure::file("read", path, &e))?.len(),
        objects: scene.objects.len(),
        materials: used_materials(&scene),
        vertices: 0,
        faces: 0,
        grf: size.0,
    };
    for object in &scene.objects {
        if let Some(mesh) = object.shape.mesh() {
            row.vertices += mesh.positions.len();
            row.faces += mesh.faces.len();
        }
    }
    Ok(row)
}

fn used_materials(scene: &Scene) -> usize {
    let mut used: BTreeSet<MaterialId> = BTreeSet::new();
    for object in &scene.objects {
        match &object.shape {
            Shape::Mesh(mesh) => used.extend(&mesh.face_materials),
            Shape::Instance(instance) => used.extend(&instance.mesh.face_materials),
            Shape::Primitive(p) => used.extend([p.material]),
            Shape::Exact(exact) => used.extend(exact.leaves().iter().map(|l| l.material())),
        }
    }
    used.len()
}

/// Counts what is written, and keeps nothing.
struct CountedBytes(u64);

impl Write for CountedBytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl ModelRow {
    fn ratio(&self) -> f64 {
        self.grf as f64 / self.source.max(1) as f64
    }

    fn counts(&self) -> [usize; 4] {
        [self.objects, self.materials, self.vertices, self.faces]
    }

    /// For people.
    fn cells(&self) -> Vec<String> {
        let mut cells = vec![self.name.clone(), bytes(self.source)];
        cells.extend(self.counts().map(count));
        cells.extend([bytes(self.grf), format!("{:.2}", self.ratio())]);
        cells
    }

    fn value(&self) -> Value {
        json!({
            "model": self.name,
            "source_bytes": self.source,
            "objects": self.objects,
            "materials": self.materials,
            "vertices": self.vertices,
            "faces": self.faces,
            "grf_bytes": self.grf,
            "ratio": number(self.ratio()),
        })
    }
}

fn aligned(rows: &[ModelRow]) -> Vec<String> {
    let head = COLUMNS.map(|(name, _)| name.to_owned()).to_vec();
    let cells: Vec<Vec<String>> = std::iter::once(head)
        .chain(rows.iter().map(ModelRow::cells))
        .collect();
    let width = |k: usize| {
        cells
            .iter()
            .map(|c| c[k].chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths: Vec<usize> = (0..COLUMNS.len()).map(width).collect();
    let line = |row: &Vec<String>| {
        let padded = row.iter().enumerate().map(|(k, cell)| {
            let width = widths[k];
            if COLUMNS[k].1 {
                format!("{cell:>width$}")
            } else {
                format!("{cell:<width$}")
            }
        });
        padded.collect::<Vec<_>>().join("  ")
    };
    cells.iter().map(line).collect()
}

fn markdown(rows: &[ModelRow]) -> Vec<String> {
    let line = |cells: Vec<String>| format!("| {} |", cells.join(" | "));
    let head = line(COLUMNS.map(|(name, _)| name.to_owned()).to_vec());
    let rule = COLUMNS.map(|(_, is_number)| if is_number { "---:" } else { "---" });
    let rule = line(rule.map(str::to_owned).to_vec());
    let body = rows.iter().map(|row| {
        let cells = row.cells().into_iter();
        line(cells.map(|cell| cell.replace('|', "\\|")).collect())
    });
    [head, rule].into_iter().chain(body).collect()
}

/// CSV (RFC 4180), with sizes in bytes.
fn separated(rows: &[ModelRow]) -> Vec<String> {
    let head = "model,source_bytes,objects,materials,vertices,faces,grf_bytes,ratio".to_owned();
    let body = rows.iter().map(|row| {
        let name = csv_cell(&row.name);
        let [objects, materials, vertices, faces] = row.counts();
        let (source, grf, ratio) = (row.source, row.grf, row.ratio());
        format!("{name},{source},{objects},{materials},{vertices},{faces},{grf},{ratio:.4}")
    });
    std::iter::once(head).chain(body).collect()
}
