//! The canonical layout of a GRF file: its own words, comments and numbers, with other blanks.

use super::document::GrfDocument;
use super::layout::GrfLayout;
use crate::reading::text::{decoded_text, encoded_like};
use crate::{FileError, Files, ReadError};
use std::ops::Range;

/// Blanks per nested block.
const INDENT: usize = 2;

/// No file at all: a file is formatted alone.
struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &str) -> Result<Vec<u8>, FileError> {
        Err(FileError::Missing)
    }
}

/// A file in the canonical layout, in its encoding, with LF as line ends: one vertex, face or
/// statement a line, blocks indented, one blank between words, none inside brackets, at most one
/// empty line. Nothing but blanks changes; comments stay where they are, and so do the texts of
/// parameters and unknown extensions. Included files are not read.
///
/// # Errors
/// The first syntax error, or letters that the file's encoding cannot give back.
pub fn formatted(bytes: &[u8], name: &str) -> Result<Vec<u8>, ReadError> {
    let layout = GrfLayout {
        is_alone: true,
        ..GrfLayout::default()
    };
    let parsed = GrfDocument::parse_with(bytes, name, &NoFiles, Some(Box::new(layout)))?;
    let text = decoded_text(bytes);
    let layout = parsed.layout;
    let names = layout.names.iter().map(|n| n.range.clone());
    let opaque = layout.opaque.iter().map(|(_, range)| range.clone());
    let mut whole: Vec<Range<usize>> = names.chain(opaque).filter(|r| !r.is_empty()).collect();
    whole.sort_by_key(|r| r.start);
    let mut printer = TokenPrinter::default();
    for token in tokens(&text, &whole) {
        printer.token(&token);
    }
    encoded_like(bytes, &printer.finish())
        .ok_or_else(|| ReadError::whole(name, "letters beyond Latin-1", "a text in UTF-8"))
}

/// A piece of text without blanks around it.
#[derive(Clone, Debug, PartialEq)]
struct TextToken<'a> {
    text: &'a str,
    /// Line ends before it.
    lines: usize,
    is_comment: bool,
    /// A file name, or the text of an open vocabulary.
    is_whole: bool,
}

fn tokens<'a>(text: &'a str, whole: &[Range<usize>]) -> Vec<TextToken<'a>> {
    let mut out = Vec::new();
    let mut whole = whole.iter().peekable();
    let (mut at, mut lines) = (0, 0);
    while let Some(first) = text[at..].chars().next() {
        if is_blank(first) {
            let is_pair = text[at..].starts_with("\r\n");
            lines += usize::from(matches!(first, '\n' | '\r') && !is_pair);
            at += first.len_utf8();
            continue;
        }
        let is_comment = text[at..].starts_with("//");
        let known = whole.next_if(|r| r.start == at).map(|r| r.end);
        let end = match known {
            Some(end) => end,
            None if is_comment => at + text[at..].find(['\n', '\r']).unwrap_or(text.len() - at),
            None if first == '"' => at + string_length(&text[at..]),
            None if "(),=;".contains(first) => at + 1,
            None => at + word_length(&text[at..]),
        };
        out.push(TextToken {
            text: text[at..end].trim_end_matches(is_blank),
            lines,
            is_comment: is_comment && known.is_none(),
            is_whole: known.is_some(),
        });
        (at, lines) = (end, 0);
    }
    out
}

/// The blanks of the grammar: those of other alphabets may be part of names.
fn is_blank(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\n' | '\r' | '\x0b' | '\x0c')
}

/// The length of a text in quotes, with them.
fn string_length(text: &str) -> usize {
    let mut is_escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            '"' if !is_escaped => return at + 1,
            '\n' | '\r' => return at,
            _ => is_escaped = c == '\\' && !is_escaped,
        }
    }
    text.len()
}

/// The length of a word, number or other run of characters.
fn word_length(text: &str) -> usize {
    let ends = |(at, c): (usize, char)| {
        let is_end = is_blank(c) || "(),=;\"".contains(c) || text[at..].starts_with("//");
        (is_end && at > 0).then_some(at)
    };
    text.char_indices().find_map(ends).unwrap_or(text.len())
}

/// What is inside a `begin`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BlockContent {
    /// Blocks.
    Blocks,
    /// The lists of a mesh.
    Mesh,
    Vertices,
    Faces,
    /// An area light, parameters, or an extension: laid out as written.
    Written,
}

#[derive(Debug)]
struct OpenBlock {
    content: BlockContent,
    /// Whether anything of it stands on a line of its own.
    has_lines: bool,
}

#[derive(Debug, Default)]
struct TokenPrinter {
    out: String,
    open: Vec<OpenBlock>,
    brackets: usize,
    /// The last words in lower case, the latest last; comments do not count.
    last: [String; 3],
    after_comment: bool,
    /// A vertex attribute whose vector follows.
    is_attribute: bool,
    /// A vertex is complete.
    is_item_over: bool,
    /// Corners of a counted face still to come.
    corners: usize,
    /// The word before the open bracket made this a value, not a position.
    in_attribute: bool,
    /// An `end` was printed, whose word may follow.
    after_end: bool,
}

impl TokenPrinter {
    fn content(&self) -> BlockContent {
        self.open.last().map_or(BlockContent::Blocks, |b| b.content)
    }

    fn token(&mut self, token: &TextToken<'_>) {
        if token.is_comment {
            let is_own = token.lines > 0 || self.out.is_empty();
            self.separate(if is_own { token.lines.clamp(1, 2) } else { 0 }, " ");
            self.out.push_str(token.text);
            self.after_comment = true;
            self.mark_lines(is_own);
            return;
        }
        let word = token.text.to_ascii_lowercase();
        let is_end = word == "end" && self.brackets == 0 && !token.is_whole && self.last[2] != "=";
        let closed = if is_end { self.open.pop() } else { None };
        let forced = match &closed {
            Some(block) => block.has_lines,
            None => self.starts_line(token, &word),
        };
        let mut lines = token.lines.min(2);
        if self.is_tail(&word) && !self.after_comment {
            lines = 0;
        }
        if forced || self.after_comment {
            lines = lines.max(1);
        }
        // No empty line after `begin` or before `end`.
        let after_begin = self.last[2] == "begin" && !self.after_comment;
        if lines == 2 && (is_end || after_begin) {
            lines = 1;
        }
        let blank = self.blank(&word);
        self.mark_lines(lines > 0);
        self.separate(lines, blank);
        self.out.push_str(token.text);
        self.after_comment = false;
        self.follow(token, &word);
        self.after_end = is_end;
        self.last.rotate_left(1);
        self.last[2] = word;
    }

    /// Whether a word belongs behind `end` or into brackets, whatever the line.
    fn is_tail(&self, word: &str) -> bool {
        let names_block = [
            "mesh",
            "light",
            "def",
            "transform",
            "params",
            "ext",
            "vertices",
            "vertexs",
            "faces",
        ];
        self.after_end && names_block.contains(&word)
            || matches!(word, "," | ")" | ";" | "=")
            || matches!(&*self.last[2], "(" | "=") && self.content() != BlockContent::Written
    }

    /// Whether a token begins a line wherever it stands.
    fn starts_line(&self, token: &TextToken<'_>, word: &str) -> bool {
        if self.brackets > 0 || token.is_whole || self.is_tail(word) {
            return false;
        }
        let last = &*self.last[2];
        match self.content() {
            BlockContent::Blocks => match word {
                "begin" => {
                    !matches!(last, "mesh" | "light" | "params" | ")") && self.last[1] != "ext"
                }
                "mesh" | "light" => !matches!(last, "begin" | "mesh" | "ext"),
                "include" | "transform" | "params" | "def" | "ext" => last != "ext",
                _ => false,
            },
            BlockContent::Mesh => match word {
                "begin" | "use" => true,
                "rgb" | "brdf" | "texture" => last != "use",
                _ => false,
            },
            BlockContent::Vertices => self.is_item_over || self.opens_list(last),
            BlockContent::Faces => match word {
                "rgb" | "brdf" | "texture" => last != "use",
                "use" => true,
                // A face, or the value of a colour or of a parameter.
                "(" => !self.is_attribute && last != "=",
                _ => self.corners == 0 && last != "=" && word.parse::<usize>().is_ok(),
            },
            BlockContent::Written => false,
        }
    }

    /// Whether the last word opened the list that we are in.
    fn opens_list(&self, last: &str) -> bool {
        self.last[1] == "begin" && matches!(last, "vertices" | "vertexs" | "faces")
    }

    fn blank(&self, word: &str) -> &'static str {
        let tight = matches!(word, "," | ")" | ";") || self.last[2] == "(";
        if tight { "" } else { " " }
    }

    fn mark_lines(&mut self, on_own_line: bool) {
        if on_own_line {
            self.open.iter_mut().for_each(|b| b.has_lines = true);
        }
    }

    /// Ends the line this often, or adds a blank.
    fn separate(&mut self, lines: usize, blank: &str) {
        if self.out.is_empty() {
            return;
        }
        if lines == 0 {
            self.out.push_str(blank);
            return;
        }
        self.out.extend(std::iter::repeat_n('\n', lines));
        let depth = self.open.len() + self.brackets;
        self.out.extend(std::iter::repeat_n(' ', INDENT * depth));
    }

    /// Updates the state after a token.
    fn follow(&mut self, token: &TextToken<'_>, word: &str) {
        if token.is_whole {
            return;
        }
        self.is_item_over = false;
        match word {
            "begin" => {
                let content = self.opened();
                let has_lines = content != BlockContent::Written;
                self.open.push(OpenBlock { content, has_lines });
            }
            // The list says what it is only after its `begin`.
            "vertices" | "vertexs" | "faces" if self.last[2] == "begin" => {
                if let Some(block) = self.open.last_mut().filter(|_| !self.after_end) {
                    block.content = match (block.content, word) {
                        (BlockContent::Written, _) => BlockContent::Written,
                        (_, "faces") => BlockContent::Faces,
                        _ => BlockContent::Vertices,
                    };
                }
            }
            "mesh" if self.last[2] == "begin" => {
                if let Some(block) = self.open.last_mut() {
                    block.content = BlockContent::Mesh;
                }
            }
            "(" => {
                self.brackets += 1;
                self.in_attribute = std::mem::take(&mut self.is_attribute);
            }
            ")" => {
                self.brackets = self.brackets.saturating_sub(1);
                self.is_item_over = self.content() == BlockContent::Vertices && !self.in_attribute;
            }
            "normal" | "irad" | "uv" | "rgb" => {
                self.is_attribute = self.last[2] != "use";
            }
            _ => self.count_corner(word),
        }
    }

    /// Follows faces written as `n i1 ... in`.
    fn count_corner(&mut self, word: &str) {
        if self.content() != BlockContent::Faces || self.brackets > 0 || self.last[2] == "=" {
            return;
        }
        match word.parse() {
            Ok(_) if self.corners > 0 => self.corners -= 1,
            Ok(count) => self.corners = count,
            Err(_) => {}
        }
    }

    /// The content of the block that the last words open.
    fn opened(&self) -> BlockContent {
        if self.content() == BlockContent::Written {
            return BlockContent::Written;
        }
        match (&*self.last[1], &*self.last[2]) {
            ("ext", _) | (_, "params") => BlockContent::Written,
            ("mesh", "light") | (_, "mesh") => BlockContent::Mesh,
            (_, "light") => BlockContent::Written,
            _ => BlockContent::Blocks,
        }
    }

    fn finish(mut self) -> String {
        if !self.out.is_empty() {
            self.out.push('\n');
        }
        self.out
    }
}
