//! Findings in a GRF file that reading it repairs, skips or does not mind.

use super::document::{BlockKind, GrfBlock, GrfDocument, MeshBlock};
use super::layout::{GrfLayout, ObjectLayout};
use super::load_textures;
use super::parse::PlacedDocument;
use crate::reading::cursor::position;
use crate::{Files, Loaded, Position, ReadError, Warning};
use azulejo_scene::math::area_vector;
use glam::DVec3;
use std::fmt;

/// By how much the length of a normal may differ from 1.
const UNIT: f64 = 5e-4;

/// Something that should be mended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LintFinding {
    /// The file, as given or as included.
    pub file: String,
    /// Where it first occurs.
    pub position: Position,
    /// The name of the rule.
    pub rule: &'static str,
    /// What was found.
    pub message: String,
    /// How often.
    pub count: usize,
}

impl fmt::Display for LintFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (file, position) = (&self.file, self.position);
        write!(f, "{file}{position}: [{}] {}", self.rule, self.message)?;
        if self.count > 1 {
            write!(f, " ({} times)", self.count)?;
        }
        Ok(())
    }
}

/// What should be mended in a file and in those that it includes, in the order of its text.
///
/// A file that cannot be read has one finding, `syntax` or `missing-include`.
pub fn lint(bytes: &[u8], name: &str, files: &dyn Files) -> Vec<LintFinding> {
    match read(bytes, name, files) {
        Ok(findings) => findings,
        Err(error) => {
            let is_missing = error.found.starts_with("the include");
            vec![LintFinding {
                rule: if is_missing {
                    "missing-include"
                } else {
                    "syntax"
                },
                position: error.position,
                message: format!("found {}, expected {}", error.found, error.expected),
                file: error.file,
                count: 1,
            }]
        }
    }
}

fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<Vec<LintFinding>, ReadError> {
    let places = Some(Box::default());
    let PlacedDocument {
        document,
        layout,
        mut warnings,
    } = GrfDocument::parse_with(bytes, name, files, places)?;
    let mut loaded: Loaded = document.resolve()?;
    load_textures(&mut loaded, name, files);
    warnings.append(&mut loaded.warnings);
    // Those have better places below.
    warnings.retain(|w| !w.message.starts_with("face without area"));
    let mut linter = Linter {
        document: &document,
        layout: &layout,
        findings: warnings.into_iter().map(finding).collect(),
    };
    linter.unused_definitions();
    linter.unknown_extensions(&document.blocks);
    let mut meshes = Vec::new();
    collect(&document.blocks, &mut meshes);
    let layout = linter.layout;
    for (mesh, place) in meshes.into_iter().zip(&layout.objects) {
        if let Some(mesh) = mesh {
            linter.mesh(mesh, place);
        }
    }
    let mut findings = linter.findings;
    let order = |f: &LintFinding| match f.position {
        Position::Whole => (0, 0),
        Position::Line(line, column) => (line, column),
        Position::Byte(_) => (0, 1),
    };
    findings.sort_by_key(|f| (f.file != name, f.file.clone(), order(f)));
    Ok(findings)
}

/// The finding of a warning, whose words tell the rule.
fn finding(warning: Warning) -> LintFinding {
    const RULES: [(&str, &str); 17] = [
        ("missing comma", "missing-comma"),
        ("single `.`", "stray-dot"),
        ("defined twice", "defined-twice"),
        ("has no key", "unknown-key"),
        ("negative", "negative-light"),
        ("reflectance above 1", "energy"),
        ("has the albedo", "energy"),
        ("reflect more", "energy"),
        ("reflects more", "energy"),
        ("not reciprocal", "reciprocity"),
        ("exceed 1", "energy"),
        ("same attribute twice", "attribute-twice"),
        ("has no effect", "no-effect"),
        ("without an object", "no-effect"),
        ("vertex without", "missing-attribute"),
        ("kept apart", "shared-vertices"),
        ("skipped:", "missing-file"),
    ];
    let is = |(words, _): &&(&str, &str)| warning.message.contains(words);
    LintFinding {
        rule: RULES.iter().find(is).map_or("warning", |(_, rule)| rule),
        file: warning.file,
        position: warning.position,
        message: warning.message,
        count: warning.count,
    }
}

/// The blocks of objects in their order, `None` for all but meshes.
fn collect<'d>(blocks: &'d [GrfBlock], out: &mut Vec<Option<&'d MeshBlock>>) {
    for block in blocks {
        match &block.kind {
            BlockKind::Mesh(mesh) => out.push(Some(mesh)),
            BlockKind::AreaLight(_)
            | BlockKind::Primitive(_)
            | BlockKind::Exact(_)
            | BlockKind::MeshInstance(_) => {
                out.push(None);
            }
            BlockKind::Include { blocks, .. } => collect(blocks, out),
            BlockKind::Transform { blocks, .. }
            | BlockKind::Definitions {
                blocks: Some(blocks),
                ..
            } => collect(blocks, out),
            _ => {}
        }
    }
}

struct Linter<'d> {
    document: &'d GrfDocument,
    layout: &'d GrfLayout,
    findings: Vec<LintFinding>,
}

impl Linter<'_> {
    /// Adds a finding that occurs at these offsets.
    fn add(
        &mut self,
        file: u32,
        rule: &'static str,
        offsets: &[usize],
        message: impl Into<String>,
    ) {
        let Some(&first) = offsets.first() else {
            return;
        };
        let text = &self.layout.texts[file as usize];
        self.findings.push(LintFinding {
            file: self.document.sources.shown(file).to_owned(),
            position: position(text.as_bytes(), first),
            rule,
            message: message.into(),
            count: offsets.len(),
        });
    }

    fn unused_definitions(&mut self) {
        let layout = self.layout;
        for (file, offset, kind, name) in &layout.definitions {
            if !layout.uses.contains(&(*kind, name.clone())) {
                let message = format!("the {} `{name}` is not used", kind.word());
                self.add(*file, "unused-definition", &[*offset], message);
            }
        }
    }

    fn unknown_extensions(&mut self, blocks: &[GrfBlock]) {
        for block in blocks {
            match &block.kind {
                BlockKind::Unknown { name, .. } => self.findings.push(LintFinding {
                    file: self.document.sources.shown(block.place.file).to_owned(),
                    position: block.place.position(),
                    rule: "unknown-extension",
                    message: format!("azulejo does not know `ext {name}`, and keeps it"),
                    count: 1,
                }),
                BlockKind::Include { blocks, .. } => self.unknown_extensions(blocks),
                BlockKind::Transform { blocks, .. }
                | BlockKind::Definitions {
                    blocks: Some(blocks),
                    ..
                } => self.unknown_extensions(blocks),
                _ => {}
            }
        }
    }

    fn mesh(&mut self, mesh: &MeshBlock, place: &ObjectLayout) {
        let vertices = &mesh.vertices;
        let count = vertices.positions.len().min(place.vertices.len());
        let at = |v: usize| place.vertices[v].position;
        let has_other_length = |v: &usize| {
            let normal: Option<DVec3> = vertices.normals.get(*v);
            normal.is_some_and(|n| (n.length() - 1.0).abs() > UNIT)
        };
        let odd: Vec<usize> = (0..count).filter(has_other_length).map(at).collect();
        self.add(
            place.file,
            "normal-length",
            &odd,
            "a normal whose length is not 1",
        );
        let mut is_used = vec![false; vertices.positions.len()];
        let (mut flat, mut repeated) = (Vec::new(), Vec::new());
        for (corners, &offset) in mesh.faces.iter().zip(&place.faces) {
            corners.iter().for_each(|&v| is_used[v as usize] = true);
            let ring: Vec<DVec3> = corners
                .iter()
                .map(|&v| vertices.positions[v as usize])
                .collect();
            let next = corners.iter().cycle().skip(1);
            if corners.iter().zip(next).any(|(a, b)| a == b) {
                repeated.push(offset);
            } else if area_vector(&ring) == DVec3::ZERO {
                flat.push(offset);
            }
        }
        let file = place.file;
        self.add(file, "degenerate-face", &flat, "a face without area");
        let message = "a face that names a vertex twice in a row";
        self.add(file, "repeated-corner", &repeated, message);
        let unused: Vec<usize> = (0..count).filter(|&v| !is_used[v]).map(at).collect();
        self.add(file, "unused-vertex", &unused, "a vertex that no face uses");
    }
}
