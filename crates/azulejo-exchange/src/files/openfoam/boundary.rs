//! Reading of `polyMesh/boundary`: names, faces and groups of patches.

use azulejo_formats::ReadError;

/// A patch of a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BoundaryPatch {
    /// Its name.
    pub name: String,
    /// Number of its faces.
    pub faces: usize,
    /// Number of its first face among those of the mesh.
    pub start_face: usize,
    /// The groups that it belongs to.
    pub groups: Vec<String>,
}

/// A token: punctuation, or a word or text without its quotation marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FoamToken<'a> {
    Mark(char),
    Word(&'a str),
}

/// A text with the place of what was read last.
struct Lexer<'a> {
    file: &'a str,
    text: &'a str,
    /// Bytes that are read, and where the last token began.
    position: usize,
    last: usize,
}

/// Reads the patches of `polyMesh/boundary`, in order.
///
/// # Errors
/// [`ReadError`] with line and column: no list of dictionaries, or a patch without a number of faces.
pub fn read_boundary(bytes: &[u8], file: &str) -> Result<Vec<BoundaryPatch>, ReadError> {
    let Ok(text) = std::str::from_utf8(bytes) else {
        let expected = "a list of patches as text; unpack .gz files first";
        return Err(ReadError::whole(file, "bytes that are not text", expected));
    };
    let mut lexer = Lexer {
        file,
        text,
        position: 0,
        last: 0,
    };
    let mut token = lexer.expect("a list of patches")?;
    if token == FoamToken::Word("FoamFile") {
        lexer.expect_mark('{')?;
        lexer.skip_block()?;
        token = lexer.expect("a list of patches")?;
    }
    // The number of patches, which need not be there, and reserves nothing.
    if matches!(token, FoamToken::Word(w) if w.parse::<usize>().is_ok()) {
        token = lexer.expect("(")?;
    }
    if token != FoamToken::Mark('(') {
        return Err(lexer.error("( at the begin of the patches"));
    }
    let mut patches = Vec::new();
    loop {
        match lexer.expect("a patch or )")? {
            FoamToken::Mark(')') => return Ok(patches),
            FoamToken::Word(name) => patches.push(lexer.patch(name)?),
            FoamToken::Mark(_) => return Err(lexer.error("the name of a patch")),
        }
    }
}

impl<'a> Lexer<'a> {
    fn error(&self, expected: &str) -> ReadError {
        let before = &self.text[..self.last];
        let line = before.matches('\n').count() as u32 + 1;
        let start = before.rfind('\n').map_or(0, |at| at + 1);
        let column = before[start..].chars().count() as u32 + 1;
        let rest = &self.text[self.last..];
        let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
        let word = match &rest[..end] {
            "" => "the end of the file".to_owned(),
            word => word.chars().take(40).collect(),
        };
        ReadError::at_line(self.file, self.text, line, column, word, expected)
    }

    /// Skips blanks and comments.
    fn skip_blanks(&mut self) {
        loop {
            let rest = self.text[self.position..].trim_start();
            let end = if rest.starts_with("//") {
                rest.find('\n').unwrap_or(rest.len())
            } else if let Some(comment) = rest.strip_prefix("/*") {
                comment.find("*/").map_or(rest.len(), |at| at + 4)
            } else {
                self.position = self.text.len() - rest.len();
                return;
            };
            self.position = self.text.len() - rest.len() + end;
        }
    }

    fn next(&mut self) -> Option<FoamToken<'a>> {
        self.skip_blanks();
        self.last = self.position;
        let rest = &self.text[self.position..];
        let first = rest.chars().next()?;
        if matches!(first, '{' | '}' | '(' | ')' | ';') {
            self.position += 1;
            return Some(FoamToken::Mark(first));
        }
        if let Some(quoted) = rest.strip_prefix('"') {
            let length = quoted.find('"').unwrap_or(quoted.len());
            self.position = (self.position + length + 2).min(self.text.len());
            return Some(FoamToken::Word(&quoted[..length]));
        }
        let is_end = |c: char| c.is_whitespace() || matches!(c, '{' | '}' | '(' | ')' | ';' | '"');
        let length = rest.find(is_end).unwrap_or(rest.len());
        self.position += length;
        Some(FoamToken::Word(&rest[..length]))
    }

    fn expect(&mut self, expected: &str) -> Result<FoamToken<'a>, ReadError> {
        self.next().ok_or_else(|| self.error(expected))
    }

    fn expect_mark(&mut self, mark: char) -> Result<(), ReadError> {
        match self.expect(&mark.to_string())? {
            FoamToken::Mark(symbol) if symbol == mark => Ok(()),
            _ => Err(self.error(&mark.to_string())),
        }
    }

    /// Skips the rest of a dictionary whose brace is read, with those inside of it.
    fn skip_block(&mut self) -> Result<(), ReadError> {
        let mut depth = 1;
        while depth > 0 {
            match self.expect("}")? {
                FoamToken::Mark('{') => depth += 1,
                FoamToken::Mark('}') => depth -= 1,
                _ => {}
            }
        }
        Ok(())
    }

    /// Reads the dictionary of a patch.
    fn patch(&mut self, name: &str) -> Result<BoundaryPatch, ReadError> {
        self.expect_mark('{')?;
        let (mut faces, mut start_face) = (None, 0);
        let mut groups = Vec::new();
        loop {
            match self.expect("an entry or }")? {
                FoamToken::Word("nFaces") => faces = Some(self.number()?),
                FoamToken::Word("startFace") => start_face = self.number()?,
                FoamToken::Word("inGroups") => groups = self.words()?,
                FoamToken::Word(_) => self.skip_entry()?,
                FoamToken::Mark('}') => break,
                FoamToken::Mark(_) => return Err(self.error("an entry or }")),
            }
        }
        Ok(BoundaryPatch {
            name: name.to_owned(),
            faces: faces.ok_or_else(|| self.error("nFaces in the patch before"))?,
            start_face,
            groups,
        })
    }

    fn number(&mut self) -> Result<usize, ReadError> {
        let token = self.expect("a number")?;
        let number = match token {
            FoamToken::Word(word) => word.parse().ok(),
            FoamToken::Mark(_) => None,
        };
        let number = number.ok_or_else(|| self.error("a number"))?;
        self.expect_mark(';')?;
        Ok(number)
    }

    /// Words of a list up to a semicolon: `1(wall)`, `List<word> 1(wall)` or `(wall)`.
    fn words(&mut self) -> Result<Vec<String>, ReadError> {
        let (mut words, mut is_inside) = (Vec::new(), false);
        loop {
            match self.expect(";")? {
                FoamToken::Mark(';') => return Ok(words),
                FoamToken::Mark('(') => is_inside = true,
                FoamToken::Mark(')') => is_inside = false,
                FoamToken::Word(word) if is_inside => words.push(word.to_owned()),
                FoamToken::Word(_) => {}
                FoamToken::Mark(_) => return Err(self.error(";")),
            }
        }
    }

    /// Skips the value of an entry: up to a semicolon, or a dictionary.
    fn skip_entry(&mut self) -> Result<(), ReadError> {
        loop {
            match self.expect(";")? {
                FoamToken::Mark(';') => return Ok(()),
                FoamToken::Mark('{') => return self.skip_block(),
                FoamToken::Mark('}') => return Err(self.error(";")),
                _ => {}
            }
        }
    }
}
