//! Numbers of arrays in the types of VTK.

use crate::reading::words::Words;

/// A type of the numbers in an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VtkType {
    /// An integer, with its size in bytes.
    Signed(usize),
    /// A non-negative integer, with its size in bytes.
    Unsigned(usize),
    /// A floating-point number, with its size in bytes.
    Real(usize),
    /// Eight values of 0 or 1 in a byte.
    Bit,
    /// Texts.
    Text,
}

impl VtkType {
    /// The type of a legacy file, by its name.
    pub fn of_legacy(name: &str) -> Option<VtkType> {
        Some(match name.to_ascii_lowercase().as_str() {
            "bit" => VtkType::Bit,
            "char" | "signed_char" => VtkType::Signed(1),
            "unsigned_char" => VtkType::Unsigned(1),
            "short" => VtkType::Signed(2),
            "unsigned_short" => VtkType::Unsigned(2),
            // Ids are written with four bytes, whatever they have in memory.
            "int" | "vtkidtype" => VtkType::Signed(4),
            "unsigned_int" => VtkType::Unsigned(4),
            "long" | "vtktypeint64" => VtkType::Signed(8),
            "unsigned_long" | "vtktypeuint64" => VtkType::Unsigned(8),
            "float" => VtkType::Real(4),
            "double" => VtkType::Real(8),
            "string" | "utf8_string" => VtkType::Text,
            _ => return None,
        })
    }

    /// The type of an XML file, by its name.
    pub fn of_xml(name: &str) -> Option<VtkType> {
        Some(match name {
            "Int8" => VtkType::Signed(1),
            "Int16" => VtkType::Signed(2),
            "Int32" => VtkType::Signed(4),
            "Int64" => VtkType::Signed(8),
            "UInt8" => VtkType::Unsigned(1),
            "UInt16" => VtkType::Unsigned(2),
            "UInt32" => VtkType::Unsigned(4),
            "UInt64" => VtkType::Unsigned(8),
            "Float32" => VtkType::Real(4),
            "Float64" => VtkType::Real(8),
            "Bit" => VtkType::Bit,
            "String" => VtkType::Text,
            _ => return None,
        })
    }

    /// Bytes of `count` numbers; `None` if there are too many. Those of texts are at least as many.
    pub fn bytes(self, count: usize) -> Option<usize> {
        match self {
            VtkType::Signed(bytes) | VtkType::Unsigned(bytes) | VtkType::Real(bytes) => {
                count.checked_mul(bytes)
            }
            VtkType::Bit => Some(count.div_ceil(8)),
            VtkType::Text => Some(count),
        }
    }
}

/// The content of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum VtkValues {
    Integers(Vec<i64>),
    Reals(Vec<f64>),
    Texts(Vec<String>),
}

impl VtkValues {
    /// Decodes at most `most` numbers in either byte order.
    pub fn decode(kind: VtkType, bytes: &[u8], most: usize, is_big: bool) -> VtkValues {
        let word = |raw: &[u8]| {
            let places = raw.iter();
            let add = |sum, &byte: &u8| sum << 8 | u64::from(byte);
            if is_big {
                places.fold(0, add)
            } else {
                places.rev().fold(0, add)
            }
        };
        let integers = |of: usize, extend: fn(u64, u32) -> i64| {
            let spare = 64 - 8 * of as u32;
            let numbers = bytes.chunks_exact(of).map(|raw| extend(word(raw), spare));
            VtkValues::Integers(numbers.collect())
        };
        match kind {
            VtkType::Signed(of) => integers(of, |w, spare| (w << spare) as i64 >> spare),
            // Numbers beyond those of any point count as none.
            VtkType::Unsigned(of) => integers(of, |w, _| i64::try_from(w).unwrap_or(-1)),
            VtkType::Real(4) => {
                let numbers = bytes
                    .chunks_exact(4)
                    .map(|raw| f32::from_bits(word(raw) as u32));
                VtkValues::Reals(numbers.map(f64::from).collect())
            }
            VtkType::Real(_) => {
                let numbers = bytes.chunks_exact(8).map(|raw| f64::from_bits(word(raw)));
                VtkValues::Reals(numbers.collect())
            }
            VtkType::Bit => {
                let bits = bytes
                    .iter()
                    .flat_map(|b| (0..8).rev().map(move |k| b >> k & 1));
                VtkValues::Integers(bits.take(most).map(i64::from).collect())
            }
            VtkType::Text => VtkValues::Texts(split_texts(bytes)),
        }
    }

    /// Reads all words as numbers; those of texts are the codes of their bytes.
    ///
    /// # Errors
    /// The offset of a word that is not a number, in the words.
    pub fn parse(kind: VtkType, words: &mut Words) -> Result<VtkValues, usize> {
        match kind {
            VtkType::Real(_) => {
                let mut numbers = Vec::new();
                while let Some(number) = next_real(words) {
                    numbers.push(number?);
                }
                Ok(VtkValues::Reals(numbers))
            }
            _ => {
                let mut numbers = Vec::new();
                while let Some(number) = next_integer(words) {
                    numbers.push(number?);
                }
                if kind == VtkType::Text {
                    let bytes: Vec<u8> = numbers.iter().map(|&n| n as u8).collect();
                    return Ok(VtkValues::Texts(split_texts(&bytes)));
                }
                Ok(VtkValues::Integers(numbers))
            }
        }
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            VtkValues::Integers(values) => values.len(),
            VtkValues::Reals(values) => values.len(),
            VtkValues::Texts(values) => values.len(),
        }
    }

    /// The values as coordinates.
    pub fn into_reals(self) -> Vec<f64> {
        match self {
            VtkValues::Integers(values) => values.into_iter().map(|v| v as f64).collect(),
            VtkValues::Reals(values) => values,
            VtkValues::Texts(_) => Vec::new(),
        }
    }

    /// The values as integers; none if they are not.
    pub fn into_integers(self) -> Vec<i64> {
        match self {
            VtkValues::Integers(values) => values,
            _ => Vec::new(),
        }
    }
}

/// The next word as a number; `None` at the end.
///
/// # Errors
/// Its offset, if it is not a number.
pub(super) fn next_real(words: &mut Words) -> Option<Result<f64, usize>> {
    words.skip_blanks();
    let start = words.offset();
    (!words.at_end()).then(|| words.number().map_err(|_| start))
}

/// The next word as an integer; `None` at the end.
///
/// # Errors
/// Its offset, if it is not a number.
pub(super) fn next_integer(words: &mut Words) -> Option<Result<i64, usize>> {
    let word = words.word()?;
    let word_text = std::str::from_utf8(word).unwrap_or_default();
    // Numbers beyond those of any point count as none.
    let large = || word_text.parse::<u64>().ok().map(|_| -1);
    let number = word_text.parse().ok().or_else(large);
    Some(number.ok_or(words.offset() - word.len()))
}

/// Texts that each end with a zero byte.
fn split_texts(bytes: &[u8]) -> Vec<String> {
    let bytes = bytes.strip_suffix(b"\0").unwrap_or(bytes);
    let texts = bytes.split(|&b| b == 0);
    texts
        .map(|t| String::from_utf8_lossy(t).into_owned())
        .collect()
}
