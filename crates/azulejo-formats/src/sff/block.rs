//! Text blocks: commands that place strings in space.

use super::SffResult;
use super::document::{SffPosition, TextCommand, TextCommandKind};
use super::lines::SffLines;
use crate::ReadError;
use crate::reading::text::{quoted, text};
use glam::DVec3;

/// The commands, each with its number of numbers.
const COMMANDS: [(&str, usize); 6] = [
    ("SPACING", 1),
    ("SCALE", 3),
    ("ORIENTATION", 9),
    ("FONT", 0),
    ("ENCODING", 0),
    ("AT", 3),
];

const EXPECTED: &str = "SPACING, SCALE, ORIENTATION, FONT, ENCODING or AT";

/// Reads commands up to an empty line.
pub(super) fn read(lines: &mut SffLines) -> SffResult<Vec<TextCommand>> {
    let mut commands = Vec::new();
    while let Some((place, word)) = next_word(lines) {
        let upper = word.to_ascii_uppercase();
        let known = COMMANDS.iter().find(|(name, _)| name.as_bytes() == upper);
        let Some(&(name, count)) = known else {
            return Err(unknown(lines, place, word));
        };
        let numbers = numbers(lines, place, name, count)?;
        let point = |k: usize| DVec3::new(numbers[k], numbers[k + 1], numbers[k + 2]);
        let kind = match name {
            "SPACING" => TextCommandKind::Spacing(numbers[0]),
            "SCALE" => TextCommandKind::Scale(point(0)),
            "ORIENTATION" => TextCommandKind::Orientation([point(0), point(3), point(6)]),
            "FONT" => TextCommandKind::Font(file_name(lines, place, name)?),
            "ENCODING" => TextCommandKind::Encoding(file_name(lines, place, name)?),
            _ => TextCommandKind::At(point(0), string(lines, place)?),
        };
        commands.push(TextCommand { place, kind });
    }
    Ok(commands)
}

/// The next word of the block and its position; `None` at the block's end, which is consumed.
fn next_word<'a>(lines: &mut SffLines<'a, '_>) -> Option<(SffPosition, &'a [u8])> {
    reach_word(lines).then(|| {
        let place = lines.place();
        (place, lines.words().word().unwrap_or_default())
    })
}

/// Skips line ends and comments up to the next word; `false` at an empty line, which is consumed.
fn reach_word(lines: &mut SffLines) -> bool {
    loop {
        if !lines.rest_is_blank() {
            if lines.words().peek() != Some(b'#') {
                return true;
            }
            lines.words().rest_of_line();
        } else if lines.at_end() || lines.words().starts_line() {
            lines.section_ends();
            return false;
        } else {
            lines.words().rest_of_line();
        }
    }
}

fn unknown(lines: &SffLines, place: SffPosition, word: &[u8]) -> ReadError {
    let upper = word.to_ascii_uppercase();
    let glued = COMMANDS.iter().find(|(name, _)| {
        let behind = upper.strip_prefix(name.as_bytes());
        behind.is_some_and(|rest| rest.starts_with(b"-"))
    });
    match glued {
        Some((name, _)) => {
            let rest = text(&word[name.len() + 1..]);
            lines.error(place, quoted(word), format!("a blank: {name} {rest}"))
        }
        None => lines.error(place, quoted(word), EXPECTED),
    }
}

/// The numbers of a command. The error is reported at the command, whose line must be corrected.
fn numbers(
    lines: &mut SffLines,
    place: SffPosition,
    name: &str,
    count: usize,
) -> SffResult<[f64; 9]> {
    let mut numbers = [0.0; 9];
    for (k, value) in numbers.iter_mut().take(count).enumerate() {
        let is_there = reach_word_in_block(lines) && lines.number_follows();
        if !is_there {
            let found = format!("{name} with {k} numbers");
            let expected = match name {
                "ORIENTATION" => "9: progression, up and extrusion, three numbers each".to_owned(),
                _ => format!("{count}"),
            };
            return Err(lines.error(place, found, expected));
        }
        *value = lines.number()?;
    }
    Ok(numbers)
}

/// As [`reach_word`], but an empty line is not consumed.
fn reach_word_in_block(lines: &mut SffLines) -> bool {
    let before = *lines.words();
    let is_there = reach_word(lines);
    if !is_there {
        *lines.words() = before;
    }
    is_there
}

fn file_name(lines: &mut SffLines, place: SffPosition, name: &str) -> SffResult<String> {
    if !reach_word_in_block(lines) {
        return Err(lines.error(place, name, format!("{name} and a file name")));
    }
    let word = lines.words().word().unwrap_or_default();
    Ok(text(word).into_owned())
}

/// The text between two quotes on one line.
fn string(lines: &mut SffLines, place: SffPosition) -> SffResult<String> {
    let expected = "a string in quotes, \"…\", on one line";
    if !reach_word_in_block(lines) || lines.words().peek() != Some(b'"') {
        return Err(lines.error(place, "AT without a string", expected));
    }
    let words = lines.words();
    let line = words.line_ahead();
    let closed = line[1..].iter().position(|&b| b == b'"');
    let Some(length) = closed else {
        let at = lines.place();
        return Err(lines.error(at, "a string without its closing quote", expected));
    };
    let string = text(&line[1..=length]).into_owned();
    *words = words.from(words.offset() + length + 2);
    Ok(string)
}
