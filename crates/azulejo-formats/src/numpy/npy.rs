//! NumPy's `.npy`: arrays of numbers with a short header.
//!
//! Format: *NEP 1, A Simple File Format for NumPy Arrays*. [`read`]: versions 1 to 3, f32 and f64,
//! either byte order, C and Fortran order; [`StoredArray`]: integers and strings too. Written:
//! version 1, little-endian, C order.

use ::exr::prelude::f16;
use std::io::{self, Write};

const MAGIC: &[u8] = b"\x93NUMPY";

/// An array of real numbers in C order (last index fastest).
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Length along each axis.
    pub shape: Vec<usize>,
    /// `shape[0] × shape[1] × …` values.
    pub values: Vec<f64>,
}

/// Reads an array of f32 or f64.
///
/// # Errors
/// What was found and what was expected.
pub fn read(bytes: &[u8]) -> Result<Array, String> {
    let (header, data) = split_header(bytes)?;
    let descr = quoted(entry(header, "descr")?)?;
    let fortran = match entry(header, "fortran_order")? {
        v if v.starts_with("True") => true,
        v if v.starts_with("False") => false,
        v => return Err(format!("fortran_order is {}", excerpt(v))),
    };
    let shape = shape_of(entry(header, "shape")?)?;
    let width = width_of(descr)?;
    check_length(data, &shape, descr, Some(width))?;
    let big_endian = descr.starts_with('>');
    let values = data
        .chunks_exact(width)
        .map(|c| decode(c, big_endian))
        .collect();
    Ok(if fortran && shape.len() > 1 {
        from_fortran(shape, values)
    } else {
        Array { shape, values }
    })
}

/// Makes sure that there are as many bytes as elements of this shape and width take; `None` is a width that no
/// memory has.
fn check_length(
    data: &[u8],
    shape: &[usize],
    descr: &str,
    width: Option<usize>,
) -> Result<(), String> {
    let count = shape.iter().try_fold(1usize, |n, &s| n.checked_mul(s));
    let expected = count.zip(width).and_then(|(n, w)| n.checked_mul(w));
    if expected == Some(data.len()) {
        return Ok(());
    }
    Err(format!(
        "{} bytes of data for shape {shape:?} of {descr}: the file is cut short or too long",
        data.len()
    ))
}

/// The header's dictionary as text, and the bytes after it.
fn split_header(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    let cut = || "the header is cut short".to_string();
    let rest = bytes
        .strip_prefix(MAGIC)
        .ok_or("this is not an .npy file (it does not begin with \\x93NUMPY)")?;
    let (version, rest) = rest.split_first_chunk::<2>().ok_or_else(cut)?;
    let (length, rest) = match version[0] {
        1 => {
            let (n, rest) = rest.split_first_chunk().ok_or_else(cut)?;
            (usize::from(u16::from_le_bytes(*n)), rest)
        }
        2 | 3 => {
            let (n, rest) = rest.split_first_chunk().ok_or_else(cut)?;
            (u32::from_le_bytes(*n) as usize, rest)
        }
        v => return Err(format!(".npy version {v}, expected 1 to 3")),
    };
    let (header, data) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| "the header is not text".to_string())?;
    Ok((header, data))
}

/// The text after a key of the header's dictionary.
fn entry<'a>(header: &'a str, key: &str) -> Result<&'a str, String> {
    ['\'', '"']
        .iter()
        .find_map(|q| header.split_once(&format!("{q}{key}{q}")))
        .and_then(|(_, after)| after.trim_start().strip_prefix(':'))
        .map(str::trim_start)
        .ok_or_else(|| format!("the header has no \"{key}\""))
}

fn quoted(text: &str) -> Result<&str, String> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'));
    quote
        .and_then(|q| text[1..].split_once(q))
        .map(|(inside, _)| inside)
        .ok_or_else(|| {
            format!(
                "the element type is {}, expected f4 or f8 (a structured array?)",
                excerpt(text)
            )
        })
}

fn excerpt(text: &str) -> String {
    text.chars().take(40).collect()
}

fn width_of(descr: &str) -> Result<usize, String> {
    match descr.strip_prefix(['<', '>', '=', '|']) {
        Some("f4") => Ok(4),
        Some("f8") => Ok(8),
        _ => Err(format!(
            "elements are \"{descr}\", expected \"<f4\" or \"<f8\" (use .astype(\"f8\"))"
        )),
    }
}

fn shape_of(text: &str) -> Result<Vec<usize>, String> {
    let bad = || format!("the shape is {}, expected (n, 3)", excerpt(text));
    let inside = text
        .strip_prefix('(')
        .and_then(|t| t.split_once(')'))
        .ok_or_else(bad)?
        .0;
    inside
        .split(',')
        .map(str::trim)
        .filter(|t| !t.is_empty())
        .map(|t| t.parse().map_err(|_| bad()))
        .collect()
}

/// One f32 or f64, by the length of `bytes`.
fn decode(bytes: &[u8], big_endian: bool) -> f64 {
    let mut little = [0; 8];
    let little = &mut little[..bytes.len()];
    little.copy_from_slice(bytes);
    if big_endian {
        little.reverse();
    }
    match *little {
        [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
        [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
        _ => f64::NAN,
    }
}

/// Reorders values from Fortran order, in which the first index varies fastest.
fn from_fortran(shape: Vec<usize>, values: Vec<f64>) -> Array {
    let mut out = vec![0.0; values.len()];
    let mut index = vec![0; shape.len()];
    for value in values {
        let at = index.iter().zip(&shape).fold(0, |at, (i, n)| at * n + i);
        out[at] = value;
        for (i, n) in index.iter_mut().zip(&shape) {
            *i += 1;
            if *i < *n {
                break;
            }
            *i = 0;
        }
    }
    Array { shape, values: out }
}

/// An array of any type that NumPy stores, decoded element by element when it is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredArray {
    shape: Vec<usize>,
    kind: ElementKind,
    big_endian: bool,
    /// The file; elements begin at `start`.
    bytes: Vec<u8>,
    start: usize,
}

/// What elements are, with their bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ElementKind {
    Float(usize),
    Signed(usize),
    Unsigned(usize),
    /// Characters in UTF-32.
    Unicode(usize),
    /// Bytes, taken as UTF-8.
    Bytes(usize),
}

impl ElementKind {
    fn new(descr: &str) -> Option<ElementKind> {
        let kind = descr.strip_prefix(['<', '>', '=', '|'])?;
        let width: usize = kind.get(1..)?.parse().ok()?;
        match (kind.as_bytes()[0], width) {
            (b'f', 2 | 4 | 8) => Some(ElementKind::Float(width)),
            (b'i', 1 | 2 | 4 | 8) => Some(ElementKind::Signed(width)),
            (b'u' | b'b', 1 | 2 | 4 | 8) => Some(ElementKind::Unsigned(width)),
            (b'U', _) => Some(ElementKind::Unicode(width)),
            (b'S' | b'a', _) => Some(ElementKind::Bytes(width)),
            _ => None,
        }
    }

    fn width(self) -> Option<usize> {
        match self {
            ElementKind::Unicode(letters) => letters.checked_mul(4),
            ElementKind::Float(n)
            | ElementKind::Signed(n)
            | ElementKind::Unsigned(n)
            | ElementKind::Bytes(n) => Some(n),
        }
    }
}

impl StoredArray {
    /// Reads the header, and compares the length of the data with it. Arrays of more than one axis
    /// must be in C order.
    ///
    /// # Errors
    /// What was found and what was expected.
    pub fn new(bytes: Vec<u8>) -> Result<StoredArray, String> {
        let (header, data) = split_header(&bytes)?;
        let descr = quoted(entry(header, "descr")?)?;
        let kind = ElementKind::new(descr)
            .ok_or_else(|| format!("elements are \"{descr}\", expected numbers or strings"))?;
        let shape = shape_of(entry(header, "shape")?)?;
        if shape.len() > 1 && entry(header, "fortran_order")?.starts_with("True") {
            let message = "the array is in Fortran order, expected C order (np.ascontiguousarray)";
            return Err(message.to_owned());
        }
        check_length(data, &shape, descr, kind.width())?;
        Ok(StoredArray {
            big_endian: descr.starts_with('>'),
            start: bytes.len() - data.len(),
            shape,
            kind,
            bytes,
        })
    }

    /// Length along each axis.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        self.bytes.len()
    }

    /// Whether elements are real numbers of 32 bits or less.
    pub fn is_single(&self) -> bool {
        matches!(self.kind, ElementKind::Float(2 | 4))
    }

    /// Element `i` in C order as a real number; NaN for strings.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn number(&self, i: usize) -> f64 {
        let bytes = self.element(i);
        match self.kind {
            ElementKind::Float(2) => f16::from_le_bytes(first(&bytes)).to_f64(),
            ElementKind::Float(4) => f64::from(f32::from_le_bytes(first(&bytes))),
            ElementKind::Float(_) => f64::from_le_bytes(bytes),
            ElementKind::Signed(_) | ElementKind::Unsigned(_) => self.integer(i) as f64,
            ElementKind::Unicode(_) | ElementKind::Bytes(_) => f64::NAN,
        }
    }

    /// Element `i` in C order as an integer: real numbers are cut, strings are 0, and numbers beyond
    /// 2^63 − 1 are that.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn integer(&self, i: usize) -> i64 {
        let bytes = self.element(i);
        match self.kind {
            ElementKind::Signed(width) => {
                let unused = 64 - 8 * width as u32;
                i64::from_le_bytes(bytes) << unused >> unused
            }
            ElementKind::Unsigned(_) => {
                i64::try_from(u64::from_le_bytes(bytes)).unwrap_or(i64::MAX)
            }
            ElementKind::Float(_) => self.number(i) as i64,
            _ => 0,
        }
    }

    /// The bytes of a number, the lowest first, padded with zeros.
    fn element(&self, i: usize) -> [u8; 8] {
        let width = self.kind.width().unwrap_or(0).min(8);
        let at = self.start + i * self.kind.width().unwrap_or(0);
        let mut bytes = [0; 8];
        bytes[..width].copy_from_slice(&self.bytes[at..at + width]);
        if self.big_endian {
            bytes[..width].reverse();
        }
        bytes
    }

    /// All elements as real numbers; `None` for strings.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        let is_number = !matches!(self.kind, ElementKind::Unicode(_) | ElementKind::Bytes(_));
        is_number.then(|| (0..self.len()).map(|i| self.number(i)).collect())
    }

    /// All elements as integers; `None` if they are none.
    pub fn integers(&self) -> Option<Vec<i64>> {
        let is_integer = matches!(self.kind, ElementKind::Signed(_) | ElementKind::Unsigned(_));
        is_integer.then(|| (0..self.len()).map(|i| self.integer(i)).collect())
    }

    /// All elements as strings, without the zeros at their ends; `None` for numbers.
    pub fn texts(&self) -> Option<Vec<String>> {
        let width = self.kind.width()?;
        let data = &self.bytes[self.start..];
        let element = |i: usize| &data[i * width..(i + 1) * width];
        let code = |b: &[u8]| {
            let bytes: [u8; 4] = first(b);
            let code = if self.big_endian {
                u32::from_be_bytes(bytes)
            } else {
                u32::from_le_bytes(bytes)
            };
            char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER)
        };
        let text = |i: usize| -> String {
            match self.kind {
                ElementKind::Unicode(_) => element(i).chunks_exact(4).map(code).collect(),
                _ => String::from_utf8_lossy(element(i)).into_owned(),
            }
        };
        let is_text = matches!(self.kind, ElementKind::Unicode(_) | ElementKind::Bytes(_));
        let trimmed = |i: usize| text(i).trim_end_matches('\0').to_owned();
        is_text.then(|| (0..self.len()).map(trimmed).collect())
    }
}

/// The first bytes of a longer list.
fn first<const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(&bytes[..N]);
    out
}

/// A type of number that `.npy` can hold.
pub trait Element: Copy {
    /// NumPy's name for it.
    const DESCR: &'static str;
    /// Little-endian bytes.
    fn write(self, out: &mut dyn Write) -> io::Result<()>;
}

macro_rules! element {
    ($type:ty, $descr:literal) => {
        impl Element for $type {
            const DESCR: &'static str = $descr;
            fn write(self, out: &mut dyn Write) -> io::Result<()> {
                out.write_all(&self.to_le_bytes())
            }
        }
    };
}

element!(f32, "<f4");
element!(f64, "<f8");
element!(i32, "<i4");
element!(i64, "<i8");
element!(u16, "<u2");
element!(u32, "<u4");

/// Writes an array in C order; the length of `values` is the product of `shape`.
pub fn write<T: Element>(shape: &[usize], values: &[T], out: &mut dyn Write) -> io::Result<()> {
    write_header(T::DESCR, shape, out)?;
    values.iter().try_for_each(|v| v.write(out))
}

/// Writes a scalar byte string, as `np.save(np.array(b"csr"))` does.
pub fn write_bytes(text: &[u8], out: &mut dyn Write) -> io::Result<()> {
    write_header(&format!("|S{}", text.len()), &[], out)?;
    out.write_all(text)
}

/// Writes an array of strings, padded to the longest: `<U`, UTF-32 with trailing zeros.
pub fn write_texts(texts: &[String], out: &mut dyn Write) -> io::Result<()> {
    let width = texts.iter().map(|t| t.chars().count()).max().unwrap_or(0);
    // NumPy has no strings of width 0.
    let width = width.max(1);
    write_header(&format!("<U{width}"), &[texts.len()], out)?;
    for text in texts {
        let letters = text.chars().map(u32::from).chain(std::iter::repeat(0));
        letters
            .take(width)
            .try_for_each(|letter| out.write_all(&letter.to_le_bytes()))?;
    }
    Ok(())
}

/// Writes the header, after which the data follows in C order.
pub fn write_header(descr: &str, shape: &[usize], out: &mut dyn Write) -> io::Result<()> {
    let axes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let shape = match shape.len() {
        0 | 1 => axes.trim_end().to_owned(),
        _ => axes.trim_end_matches(", ").to_owned(),
    };
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
    // The data starts at a multiple of 64 bytes, so that it can be mapped into memory.
    let unpadded = MAGIC.len() + 4 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    header.push('\n');
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&(header.len() as u16).to_le_bytes())?;
    out.write_all(header.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(dictionary: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((dictionary.len() as u16).to_le_bytes());
        bytes.extend(dictionary.as_bytes());
        bytes.extend(data);
        bytes
    }

    fn check(dictionary: &str, data: &[u8], expected: &[f64]) {
        let array = read(&file(dictionary, data)).unwrap();
        assert_eq!(array.values, expected, "{dictionary}");
    }

    fn refuse(bytes: &[u8], expected: &str) {
        let error = read(bytes).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }

    #[test]
    fn what_is_written_reads_back() {
        let values = [1.5, -2.0, 3e-300, 4.0, 5.0, 6.0];
        let mut bytes = Vec::new();
        write(&[2, 3], &values, &mut bytes).unwrap();
        assert_eq!((bytes.len() - 48) % 64, 0);
        let array = read(&bytes).unwrap();
        assert_eq!((array.shape, &array.values[..]), (vec![2, 3], &values[..]));
        let mut bytes = Vec::new();
        write(&[2], &[1.5f32, 2.5], &mut bytes).unwrap();
        assert_eq!(read(&bytes).unwrap().values, [1.5, 2.5]);
    }

    fn stored(descr: &str, shape: &str, data: &[u8]) -> StoredArray {
        let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
        StoredArray::new(file(&header, data)).unwrap()
    }

    #[test]
    fn stored_arrays_have_all_types() {
        let halves = stored("<f2", "(3,)", &[0x00, 0x3c, 0x00, 0xc0, 0x01, 0x00]);
        assert_eq!(halves.numbers().unwrap(), [1.0, -2.0, f64::powi(2.0, -24)]);
        let bytes = stored("|i1", "(2,)", &[0xff, 5]);
        assert_eq!(bytes.integers().unwrap(), [-1, 5]);
        assert_eq!(stored("|b1", "(2,)", &[1, 0]).integers().unwrap(), [1, 0]);
        let large = stored(">i4", "(1,)", &[0xff, 0xff, 0xff, 0xfe]);
        assert_eq!((large.integer(0), large.number(0)), (-2, -2.0));
        let texts = stored("|S3", "(2,)", b"ab\0cde");
        assert_eq!(texts.texts().unwrap(), ["ab", "cde"]);
        assert!(texts.numbers().is_none() && bytes.texts().is_none());
        let wide = stored(">U2", "(1,)", &[0, 0, 0, 0xe4, 0, 0, 0, 0]);
        assert_eq!(wide.texts().unwrap(), ["ä"]);
        let structured = "{'descr': '<c16', 'fortran_order': False, 'shape': (0,), }";
        let refused = StoredArray::new(file(structured, &[])).unwrap_err();
        assert!(refused.contains("numbers or strings"), "{refused}");
        let endless =
            "{'descr': '<U99999999999999999999', 'fortran_order': False, 'shape': (9,), }";
        assert!(StoredArray::new(file(endless, &[])).is_err());
    }

    #[test]
    fn orders_of_bytes_and_axes() {
        let floats: Vec<u8> = [1f32, 2.0, 3.0, 4.0, 5.0, 6.0]
            .iter()
            .flat_map(|x| x.to_be_bytes())
            .collect();
        let fortran = "{'descr': '>f4', 'fortran_order': True, 'shape': (2, 3), }\n";
        check(fortran, &floats, &[1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
        let plain = "{\"shape\": (6,), \"fortran_order\": False, \"descr\": \">f4\"}\n";
        check(plain, &floats, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }

    #[test]
    fn bad_files_say_what_is_wrong() {
        refuse(b"", "not an .npy file");
        refuse(b"\x93NUMPY\x01\x00\xff\xff{", "cut short");
        refuse(b"\x93NUMPY\x09\x00", "version 9");
        let head = |descr: &str, shape: &str| {
            file(
                &format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}"),
                &[0; 24],
            )
        };
        refuse(&head("'<i8'", "(3,)"), "expected \"<f4\"");
        refuse(&head("[('x', '<f8')]", "(3,)"), "structured");
        refuse(&head("'<f8'", "(4,)"), "24 bytes of data");
        refuse(
            &head("'<f8'", "(99999999999, 99999999999, 99999999999)"),
            "24 bytes",
        );
        refuse(&head("'<f8'", "3"), "the shape is 3");
        refuse(&file("{}", &[]), "no \"descr\"");
    }
}
