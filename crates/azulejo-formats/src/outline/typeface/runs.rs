//! Text in the order in which it is seen, divided into what is shaped at once.

use std::ops::Range;
use unicode_bidi::{BidiInfo, Level};
use unicode_script::{Script, UnicodeScript};

/// Text that is shaped at once: one script, one direction, one size.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    pub bytes: Range<usize>,
    pub script: Script,
    pub is_rtl: bool,
}

/// A paragraph with the levels of Unicode's bidirectional algorithm (UAX #9), one for each byte.
#[derive(Debug)]
pub(super) struct BidiParagraph {
    levels: Vec<Level>,
    base: Level,
}

impl BidiParagraph {
    /// Resolves the levels; the first strong letter decides where the paragraph begins.
    pub fn new(text: &str) -> BidiParagraph {
        let bidi = BidiInfo::new(text, None);
        let base = bidi.paragraphs.first().map_or(Level::ltr(), |p| p.level);
        BidiParagraph {
            levels: bidi.levels,
            base,
        }
    }

    /// Whether the paragraph begins at the right.
    pub fn is_rtl(&self) -> bool {
        self.base.is_rtl()
    }

    /// The runs of one of its lines from left to right, where `text` is the paragraph; sizes change at the
    /// `cuts`, which are sorted.
    pub fn runs(&self, text: &str, line: Range<usize>, cuts: &[usize]) -> Vec<Run> {
        let levels = self.levels_of(text, &line);
        let stretches = levels.chunk_by(|a, b| a == b);
        let ends = stretches.clone().scan(line.start, |end, stretch| {
            *end += stretch.len();
            Some(*end)
        });
        let stretches: Vec<(Level, usize)> = stretches.map(|s| s[0]).zip(ends).collect();
        let of_stretches: Vec<Level> = stretches.iter().map(|s| s.0).collect();
        let mut runs = Vec::new();
        for k in BidiInfo::reorder_visual(&of_stretches) {
            let (level, end) = stretches[k];
            let start = k
                .checked_sub(1)
                .map_or(line.start, |before| stretches[before].1);
            let mut inner = script_runs(text, start..end, level.is_rtl(), cuts);
            if level.is_rtl() {
                inner.reverse();
            }
            runs.extend(inner);
        }
        runs
    }

    /// The levels of a line. Blanks at its end have that of the paragraph (rule L1).
    fn levels_of(&self, text: &str, line: &Range<usize>) -> Vec<Level> {
        let mut levels = self.levels[line.clone()].to_vec();
        let inked = text[line.clone()].trim_end().len();
        levels[inked..].fill(self.base);
        levels
    }
}

/// Splits text where the script or the size changes. Characters without a script of their own, such as blanks and
/// accents, belong to the preceding run, at the start to the following one.
fn script_runs(text: &str, bytes: Range<usize>, is_rtl: bool, cuts: &[usize]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (at, c) in text[bytes.clone()].char_indices() {
        let at = bytes.start + at;
        let script = c.script();
        let is_own = ![Script::Common, Script::Inherited, Script::Unknown].contains(&script);
        let continued = runs.last_mut().filter(|_| cuts.binary_search(&at).is_err());
        match continued {
            Some(run) if is_own && run.script == Script::Common => run.script = script,
            Some(run) if !is_own || run.script == script => {}
            _ => runs.push(Run {
                bytes: at..at,
                script: if is_own { script } else { Script::Common },
                is_rtl,
            }),
        }
        if let Some(run) = runs.last_mut() {
            run.bytes.end = at + c.len_utf8();
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The texts of runs, those from right to left in brackets.
    fn shown(text: &str, runs: Vec<Run>) -> Vec<String> {
        let shown = |run: Run| {
            if run.is_rtl {
                format!("[{}]", &text[run.bytes])
            } else {
                text[run.bytes].to_owned()
            }
        };
        runs.into_iter().map(shown).collect()
    }

    fn check(text: &str, expected: &[&str]) {
        let runs = BidiParagraph::new(text).runs(text, 0..text.len(), &[]);
        assert_eq!(shown(text, runs), expected);
    }

    #[test]
    fn runs_are_in_visual_order() {
        check("", &[]);
        check("Luz, 12.", &["Luz, 12."]);
        check("Luz Φως свет", &["Luz ", "Φως ", "свет"]);
        check("ab אבג cd", &["ab ", "[אבג]", " cd"]);
        check("אב 12 ג", &["[ ג]", "12", "[אב ]"]);
        check("אב عر", &["[عر]", "[אב ]"]);
        check("e\u{301}", &["e\u{301}"]);
        check("שלום 123 abc", &["abc", "[ ]", "123", "[שלום ]"]);
    }

    #[test]
    fn lines_are_ordered_each_by_itself() {
        let text = "אב גד abc ef";
        let paragraph = BidiParagraph::new(text);
        let seen = |line: Range<usize>| shown(text, paragraph.runs(text, line, &[]));
        assert!(paragraph.is_rtl());
        assert_eq!(seen(0..5), ["[אב ]"]);
        // The blank at the end of the line is at its left, as it ends a paragraph from right to left.
        assert_eq!(seen(5..14), ["[ ]", "abc", "[גד ]"]);
        assert_eq!(seen(14..16), ["ef"]);
    }

    #[test]
    fn sizes_divide_runs() {
        let text = "abc אבג";
        let runs = BidiParagraph::new(text).runs(text, 0..text.len(), &[1, 6]);
        assert_eq!(shown(text, runs), ["a", "bc ", "[בג]", "[א]"]);
    }
}
