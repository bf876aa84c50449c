//! The words of a file.

use crate::ReadError;
use crate::reading::words::Words;
use azulejo_scene::{Faces, Rgb};
use glam::{DVec2, DVec3};

/// The lists of a file as they stand there.
#[derive(Debug, Default)]
pub(super) struct OffLists {
    pub positions: Vec<DVec3>,
    /// Normals of the vertices, or empty.
    pub normals: Vec<DVec3>,
    /// Colours of the vertices, or empty.
    pub colors: Vec<Rgb>,
    /// Texture coordinates of the vertices, or empty.
    pub uvs: Vec<DVec2>,
    pub faces: Faces,
    pub face_colors: Vec<Option<Rgb>>,
    /// Faces of one or two corners, which other programs show as points and lines.
    pub lines: usize,
    /// Faces with an index into a table of colours, which only Geomview has.
    pub indexed: usize,
    /// Faces with more after their corners than a colour.
    pub surplus: usize,
    /// Lines after the last face.
    pub rest: usize,
}

/// What the first word says of the vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct OffHeader {
    has_normals: bool,
    has_colors: bool,
    has_uvs: bool,
}

/// Reads a file word by word; a `#` begins a comment.
pub(super) struct OffParser<'a> {
    words: Words<'a>,
    lists: OffLists,
}

impl<'a> OffParser<'a> {
    pub fn new(bytes: &'a [u8], file: &'a str) -> OffParser<'a> {
        OffParser {
            words: Words::new(bytes, file),
            lists: OffLists::default(),
        }
    }

    /// Reads the whole file.
    pub fn read(mut self) -> Result<OffLists, ReadError> {
        let header = self.header()?;
        let vertices = self.count("a number of vertices")?;
        let faces = self.count("a number of faces")?;
        // Nothing depends on the number of edges, which programs omit.
        self.words.skip_spaces();
        if !self.is_line_end() {
            self.count("a number of edges")?;
        }
        let channels = if header.has_colors {
            self.channels(header)
        } else {
            0
        };
        for _ in 0..vertices {
            self.vertex(header, channels)?;
        }
        for _ in 0..faces {
            self.face()?;
        }
        while self.skip_comments() {
            self.words.rest_of_line();
            self.lists.rest += 1;
        }
        Ok(self.lists)
    }

    /// Passes blanks and comments; whether a word follows.
    fn skip_comments(&mut self) -> bool {
        self.words.skip_blanks();
        while self.words.peek() == Some(b'#') {
            self.words.rest_of_line();
            self.words.skip_blanks();
        }
        !self.words.at_end()
    }

    /// Whether nothing but a comment follows on the line.
    fn is_line_end(&self) -> bool {
        self.words.at_line_end() || self.words.peek() == Some(b'#')
    }

    /// The first word, which may be missing.
    fn header(&mut self) -> Result<OffHeader, ReadError> {
        self.skip_comments();
        let start = self.words.offset();
        let word = self.words.word().unwrap_or_default();
        if word.first().is_some_and(u8::is_ascii_digit) && !word.ends_with(b"OFF") {
            self.words = self.words.from(start);
            return Ok(OffHeader::default());
        }
        let words = self.words;
        let refuse = |found: &str, expected: &str| Err(words.error_with(start, found, expected));
        let Some(kinds) = word.strip_suffix(b"OFF") else {
            return Err(self.words.error(start, "OFF"));
        };
        let mut header = OffHeader::default();
        let mut rest = kinds;
        // The letters stand in this order, each at most once.
        for (mark, flag) in [
            (&b"ST"[..], &mut header.has_uvs),
            (b"C", &mut header.has_colors),
            (b"N", &mut header.has_normals),
        ] {
            if let Some(others) = rest.strip_prefix(mark) {
                (*flag, rest) = (true, others);
            }
        }
        match rest {
            b"" => {}
            b"4" | b"n" | b"4n" => {
                let found = "vertices of more than three coordinates";
                return refuse(found, "vertices in space (OFF)");
            }
            _ => return Err(self.words.error(start, "OFF, COFF, NOFF, CNOFF or STOFF")),
        }
        self.words.skip_spaces();
        if self.words.line_ahead().starts_with(b"BINARY") {
            return refuse("a binary OFF file", "OFF as text, which all programs write");
        }
        Ok(header)
    }

    fn count(&mut self, expected: &str) -> Result<u64, ReadError> {
        self.skip_comments();
        let start = self.words.offset();
        let word = std::str::from_utf8(self.words.word().unwrap_or_default()).ok();
        let count = word.and_then(|w| w.parse().ok());
        count.ok_or_else(|| self.words.error(start, expected))
    }

    /// A number that is finite.
    fn number(&mut self, expected: &str) -> Result<f64, ReadError> {
        self.skip_comments();
        let start = self.words.offset();
        match self.words.number() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.words.error(start, expected)),
        }
    }

    /// How many numbers the colour of a vertex has: four, but some programs write three, which the length
    /// of the first line tells.
    fn channels(&mut self, header: OffHeader) -> usize {
        self.skip_comments();
        let line = self.words.line_ahead();
        let line = line.split(|&b| b == b'#').next().unwrap_or_default();
        let words = line
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty());
        let others = 3 + 3 * usize::from(header.has_normals) + 2 * usize::from(header.has_uvs);
        if words.count() == others + 3 { 3 } else { 4 }
    }

    fn vertex(&mut self, header: OffHeader, channels: usize) -> Result<(), ReadError> {
        let position = self.vector("a coordinate of a vertex")?;
        self.lists.positions.push(position);
        if header.has_normals {
            let normal = self.vector("a coordinate of a normal")?;
            self.lists.normals.push(normal);
        }
        if channels > 0 {
            let mut color = OffColor::default();
            for _ in 0..channels {
                self.skip_comments();
                let start = self.words.offset();
                self.number("a colour of a vertex")?;
                color.push(self.words.from(start).word().unwrap_or_default());
            }
            self.lists.colors.push(color.value());
        }
        if header.has_uvs {
            let (u, v) = (self.number("u")?, self.number("v")?);
            self.lists.uvs.push(DVec2::new(u, v));
        }
        Ok(())
    }

    fn vector(&mut self, expected: &str) -> Result<DVec3, ReadError> {
        let mut axis = || self.number(expected);
        Ok(DVec3::new(axis()?, axis()?, axis()?))
    }

    fn face(&mut self) -> Result<(), ReadError> {
        let count = self.count("a number of corners")?;
        let start = self.lists.faces.corners.len();
        for _ in 0..count {
            self.skip_comments();
            let at = self.words.offset();
            let vertex = self.count("the number of a vertex")?;
            if vertex >= self.lists.positions.len() as u64 {
                let (found, most) = (format!("vertex {vertex}"), self.lists.positions.len());
                let expected = format!("one of the {most} vertices, from 0");
                return Err(self.words.error_with(at, found, expected));
            }
            self.lists.faces.corners.push(vertex as u32);
        }
        let color = self.face_color()?;
        if count < 3 {
            self.lists.lines += 1;
            self.lists.faces.corners.truncate(start);
            return Ok(());
        }
        let end = self.lists.faces.corners.len() as u32;
        self.lists.faces.starts.push(end);
        self.lists.face_colors.push(color);
        Ok(())
    }

    /// What follows the corners of a face on its line.
    fn face_color(&mut self) -> Result<Option<Rgb>, ReadError> {
        let (mut color, mut count) = (OffColor::default(), 0);
        loop {
            self.words.skip_spaces();
            if self.is_line_end() {
                break;
            }
            let start = self.words.offset();
            self.number("a colour of a face")?;
            color.push(self.words.from(start).word().unwrap_or_default());
            count += 1;
        }
        match count {
            0 => Ok(None),
            1 => {
                self.lists.indexed += 1;
                Ok(None)
            }
            3 | 4 => Ok(Some(color.value())),
            _ => {
                self.lists.surplus += 1;
                Ok(None)
            }
        }
    }
}

/// The words of a colour: integers are shares of 255, all others of 1.
#[derive(Clone, Copy, Debug, Default)]
struct OffColor {
    channels: [f64; 4],
    count: usize,
    is_real: bool,
}

impl OffColor {
    fn push(&mut self, word: &[u8]) {
        let is_integer = word.iter().all(u8::is_ascii_digit);
        self.is_real |= !is_integer;
        let text = std::str::from_utf8(word).unwrap_or_default();
        if let Some(channel) = self.channels.get_mut(self.count) {
            *channel = text.parse().unwrap_or(0.0);
        }
        self.count += 1;
    }

    /// Red, green and blue; the fourth number is an opacity, which is not used.
    fn value(self) -> Rgb {
        let one = if self.is_real { 1.0 } else { 255.0 };
        let [r, g, b, _] = self.channels.map(|c| (c / one).clamp(0.0, 1.0));
        Rgb::new(r, g, b)
    }
}
