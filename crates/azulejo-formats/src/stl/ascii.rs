//! The ASCII format.

use super::{StlSolid, default_material};
use crate::ReadError;
use crate::reading::text::{shortened, text};
use crate::reading::warnings::Warnings;
use crate::reading::words::Words;
use azulejo_scene::Scene;
use glam::DVec3;

/// Minimum length in bytes of a facet as programs write it, which limits the reserved memory.
const SHORTEST_FACET: usize = 90;

/// Reads text that begins with `solid`.
pub(super) fn read(bytes: &[u8], file: &str, warnings: &mut Warnings) -> Result<Scene, ReadError> {
    let mut reader = StlAsciiParser {
        words: Words::new(bytes, file),
        file,
        length: bytes.len(),
        warnings,
        scene: Scene::default(),
        solid: None,
        corners: Vec::new(),
    };
    reader.statements()?;
    Ok(reader.scene)
}

struct StlAsciiParser<'a> {
    words: Words<'a>,
    file: &'a str,
    length: usize,
    warnings: &'a mut Warnings,
    scene: Scene,
    solid: Option<StlSolid>,
    /// Vertices of the current facet.
    corners: Vec<DVec3>,
}

impl StlAsciiParser<'_> {
    fn statements(&mut self) -> Result<(), ReadError> {
        while let Some(word) = self.words.word() {
            self.statement(word, word)?;
        }
        if self.solid.is_some() {
            let at = self.length;
            self.warn_at(
                at,
                "the file ends inside a solid: what precedes the end is kept",
            );
            self.end_solid();
        }
        if !self.scene.objects.is_empty() {
            self.scene.add_material(default_material());
        }
        Ok(())
    }

    #[cold]
    fn warn_at(&mut self, at: usize, message: impl Into<String>) {
        let words = self.words;
        self.warnings
            .add(self.file, message.into(), || words.position(at));
    }

    /// Handles a statement: its keyword, and the word that the file has for it.
    fn statement(&mut self, keyword: &[u8], word: &[u8]) -> Result<(), ReadError> {
        match keyword {
            b"vertex" => self.vertex()?,
            b"facet" | b"outer" | b"loop" | b"endfacet" => {}
            b"normal" => self.normal(),
            b"endloop" => self.end_loop(),
            b"solid" => self.begin_solid(),
            b"endsolid" => {
                self.words.rest_of_line();
                self.end_solid();
            }
            _ if keyword.iter().any(u8::is_ascii_uppercase) => {
                self.statement(&keyword.to_ascii_lowercase(), word)?;
            }
            _ => {
                let at = self.words.offset() - word.len();
                let shown = shortened(&text(word));
                self.warn_at(
                    at,
                    format!("\"{shown}\" is not an STL keyword: line skipped"),
                );
                self.words.rest_of_line();
            }
        }
        Ok(())
    }

    fn begin_solid(&mut self) {
        if self.solid.is_some() {
            let at = self.words.offset();
            self.warn_at(
                at,
                "solid without an end: it ends where the next one begins",
            );
            self.end_solid();
        }
        let name = text(self.words.rest_of_line()).into_owned();
        let left = self.length - self.words.offset();
        // A file with many small solids must not reserve memory for the whole file in each of them.
        let expected = if self.scene.objects.is_empty() {
            left / (2 * SHORTEST_FACET)
        } else {
            0
        };
        self.solid = Some(StlSolid::new(name, expected));
    }

    fn end_solid(&mut self) {
        if !self.corners.is_empty() {
            self.end_loop();
        }
        match self.solid.take() {
            Some(solid) if solid.faces.is_empty() => {
                let at = self.words.offset();
                self.warn_at(at, "solid without facets: skipped");
            }
            Some(solid) => solid.finish(&mut self.scene),
            None => {}
        }
    }

    /// Normals are computed from the vertices; writers omit them, or write zeros or worse.
    fn normal(&mut self) {
        for _ in 0..3 {
            self.words.word();
        }
    }

    #[inline]
    fn vertex(&mut self) -> Result<(), ReadError> {
        let (x, y, z) = (
            self.words.number()?,
            self.words.number()?,
            self.words.number()?,
        );
        self.corners.push(DVec3::new(x, y, z));
        Ok(())
    }

    fn end_loop(&mut self) {
        let solid = self
            .solid
            .get_or_insert_with(|| StlSolid::new(String::new(), 0));
        if let Err(problem) = solid.facet(&self.corners, 0) {
            let at = self.words.offset();
            self.warn_at(at, problem);
        }
        self.corners.clear();
    }
}
