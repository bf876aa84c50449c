//! `ext figure`: contours of lines and cubic curves.

use super::super::document::{BlockKind, BoxedError, NameKind};
use super::super::entries::GrfEntries;
use super::super::parse::BlockEnd;
use super::super::parser::{GrfParser, ParseResult};
use super::super::write::{GrfOutput, pair};
use super::FigureBlock;
use azulejo_scene::{Contour, Curve, Figure, FillRule};
use std::io::{self, Write};
use std::sync::Arc;

const CONTOUR: BlockEnd = BlockEnd::required(&["contour"]);
const EXTENSION: BlockEnd = BlockEnd::required(&["ext"]);

impl<'a> GrfParser<'a, '_, '_> {
    /// Reads a figure, after `ext figure begin`.
    pub fn figure(&mut self, offset: usize) -> ParseResult<BlockKind> {
        let mut entries = GrfEntries::new("`ext figure`", offset);
        let mut contours = Vec::new();
        self.entries_and(&mut entries, |parser| parser.contour(&mut contours))?;
        self.end(offset, &EXTENSION)?;
        let name = self.defined_name(&mut entries, NameKind::Figure)?;
        let rules = [
            ("even_odd", FillRule::EvenOdd),
            ("non_zero", FillRule::NonZero),
        ];
        let rule = self.take_choice(&mut entries, "rule", &rules)?;
        let rule = rule.unwrap_or(FillRule::EvenOdd);
        self.warn_of_rest(&entries);
        contours.shrink_to_fit();
        Ok(BlockKind::Figure(FigureBlock {
            name,
            figure: Arc::new(Figure { contours, rule }),
        }))
    }

    /// Reads `contour begin ... end contour`, if that comes next.
    fn contour(&mut self, contours: &mut Vec<Contour>) -> ParseResult<bool> {
        let offset = self.lexer.skip_blank();
        if !self.lexer.eat_word("contour") {
            return Ok(false);
        }
        self.expect_word("begin")?;
        let mut curves = Vec::new();
        loop {
            if self.lexer.eat_word("line") {
                let start = self.vector2()?;
                curves.push(Curve::Line { start });
            } else if self.lexer.eat_word("cubic") {
                curves.push(Curve::Cubic {
                    start: self.vector2()?,
                    control1: self.vector2()?,
                    control2: self.vector2()?,
                });
            } else if self.at_end() {
                break;
            } else {
                return Err(self.not_a_curve());
            }
        }
        self.end(offset, &CONTOUR)?;
        curves.shrink_to_fit();
        contours.push(Contour { curves });
        Ok(true)
    }

    #[cold]
    fn not_a_curve(&mut self) -> BoxedError {
        self.unexpected(
            "`line (x, y)`, `cubic` with its start and two control points, or `end contour`",
        )
    }
}

/// Writes a figure, one curve per line.
pub(in crate::grf) fn figure(out: &mut GrfOutput<'_>, block: &FigureBlock) -> io::Result<()> {
    write!(out, "ext figure begin name = {}", block.name)?;
    if block.figure.rule == FillRule::NonZero {
        out.write_all(b" rule = non_zero")?;
    }
    out.write_all(b"\n")?;
    for contour in &block.figure.contours {
        out.write_all(b"contour begin\n")?;
        contour.curves.iter().try_for_each(|c| curve(out, c))?;
        out.write_all(b"end contour\n")?;
    }
    out.write_all(b"end ext\n")
}

fn curve(out: &mut GrfOutput<'_>, curve: &Curve) -> io::Result<()> {
    match *curve {
        Curve::Line { start } => writeln!(out, "line {}", pair(start)),
        Curve::Cubic {
            start,
            control1,
            control2,
        } => writeln!(
            out,
            "cubic {} {} {}",
            pair(start),
            pair(control1),
            pair(control2)
        ),
    }
}
