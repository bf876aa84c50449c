//! NumPy's `.npy`: arrays of numbers with a short header.
//!
//! Format: *NEP 1, A Simple File Format for NumPy Arrays*. Read: versions 1 to 3, f32 and f64,
//! either byte order, C and Fortran order. Written: version 1, little-endian, C order.

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
    let count = shape.iter().try_fold(1usize, |n, &s| n.checked_mul(s));
    let width = width_of(descr)?;
    let expected = count.and_then(|n| n.checked_mul(width));
    if expected != Some(data.len()) {
        return Err(format!(
            "{} bytes of data for shape {shape:?} of {descr}: the file is cut short or too long",
            data.len()
        ));
    }
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
        let said = read(bytes).unwrap_err();
        assert!(said.contains(expected), "{said}");
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
