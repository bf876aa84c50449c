//! The summary of a command, as text and as JSON.

use serde_json::{Map, Value};
use std::borrow::Cow;
use std::io::{self, Write};

/// Results in order, each with a label and text, a key and a JSON value, or both.
#[derive(Debug, Default)]
pub struct Report {
    lines: Vec<ReportLine>,
    values: Map<String, Value>,
}

#[derive(Debug)]
enum ReportLine {
    Labelled(String, String),
    Plain(String),
}

impl Report {
    /// Adds a result to the text and to the JSON.
    pub fn fact(
        &mut self,
        key: &str,
        value: impl Into<Value>,
        label: &str,
        words: impl Into<String>,
    ) {
        self.value(key, value);
        self.line(label, words);
    }

    /// Adds a result to the JSON only.
    pub fn value(&mut self, key: &str, value: impl Into<Value>) {
        self.values.insert(key.to_owned(), value.into());
    }

    /// Adds a line to the text only.
    pub fn line(&mut self, label: &str, words: impl Into<String>) {
        self.lines
            .push(ReportLine::Labelled(label.to_owned(), words.into()));
    }

    /// Adds a line without label to the text only.
    pub fn plain(&mut self, words: impl Into<String>) {
        self.lines.push(ReportLine::Plain(words.into()));
    }

    /// Writes the text: labels and values in two aligned columns.
    pub fn write_lines(&self, out: &mut dyn Write) -> io::Result<()> {
        let label_width = |line: &ReportLine| match line {
            ReportLine::Labelled(label, _) => label.chars().count(),
            ReportLine::Plain(_) => 0,
        };
        let width = self.lines.iter().map(label_width).max().unwrap_or(0);
        for line in &self.lines {
            match line {
                ReportLine::Labelled(label, words) => writeln!(out, "{label:<width$}  {words}")?,
                ReportLine::Plain(words) => writeln!(out, "{words}")?,
            }
        }
        Ok(())
    }

    /// Writes one JSON object on a line of its own.
    pub fn write_json(self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{}", Value::Object(self.values))
    }
}

/// A cell of CSV, in quotes where RFC 4180 wants them.
pub fn csv_cell(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\"")).into()
    } else {
        text.into()
    }
}

/// A JSON number, or null for infinities and NaN.
pub fn number(x: f64) -> Value {
    serde_json::Number::from_f64(x).map_or(Value::Null, Value::Number)
}

/// JSON numbers.
pub fn numbers<const N: usize>(xs: [f64; N]) -> Value {
    Value::Array(xs.map(number).to_vec())
}

/// A count with thousands separators: `1,234,567`.
pub fn count(n: impl TryInto<u64>) -> String {
    let digits = n.try_into().unwrap_or(u64::MAX).to_string();
    let mut out = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A number to four digits, without exponent where that is short: `0.0123`, `15.6`, `1.200e-9`.
pub fn short(x: f64) -> String {
    let magnitude = x.abs();
    if magnitude != 0.0 && !(1e-4..1e7).contains(&magnitude) {
        return format!("{x:.3e}");
    }
    let decimals = (3 - magnitude.max(1e-4).log10().floor() as i32).clamp(0, 7) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A number with its standard error, to two digits of it: `300.00 ± 0.12`; without one, as [`short`].
pub fn with_error(x: f64, error: f64) -> String {
    let is_error = error.is_finite() && error > 0.0;
    // Errors below the last digits that numbers have are not said.
    if !is_error || error < 1e-9 * x.abs() {
        return short(x);
    }
    let decimals = (1 - error.log10().floor() as i32).clamp(0, 9) as usize;
    if (x.abs() >= 1e9) || (error < 1e-8) {
        return format!("{x:.3e} ± {error:.1e}");
    }
    format!("{x:.decimals$} ± {error:.decimals$}")
}

/// Three numbers: `(0.5, 1, 2)`.
pub fn triple(xs: [f64; 3]) -> String {
    let [x, y, z] = xs.map(short);
    format!("({x}, {y}, {z})")
}

/// A share in per cent: `1.25%`.
pub fn percent(share: f64) -> String {
    // A negative zero would show its sign.
    format!("{}%", short(100.0 * share + 0.0))
}

/// Seconds: `0.153 s`, `2 min 5 s`.
pub fn seconds(s: f64) -> String {
    if s < 120.0 {
        // Clocks are not reliable below milliseconds.
        return format!("{} s", short((s * 1e3).round() * 1e-3));
    }
    let whole = s.round() as u64;
    match whole / 3600 {
        0 => format!("{} min {} s", whole / 60, whole % 60),
        hours => format!("{hours} h {} min", whole % 3600 / 60),
    }
}

/// Bytes: `12.5 MiB`.
pub fn bytes(n: u64) -> String {
    let mut value = n as f64;
    for unit in ["B", "KiB", "MiB", "GiB"] {
        if value < 1024.0 {
            return format!("{} {unit}", short(value));
        }
        value /= 1024.0;
    }
    format!("{} TiB", short(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(count(0usize), "0");
        assert_eq!(count(999u32), "999");
        assert_eq!(count(1_234_567u64), "1,234,567");
        for (x, want) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.012345, "0.01235"),
            (15.6, "15.6"),
            (-278.0, "-278"),
            (123456.7, "123457"),
            (1.2e-9, "1.200e-9"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(x), want);
        }
        assert_eq!(percent(0.0125), "1.25%");
        assert_eq!(seconds(3e-6), "0 s");
        assert_eq!(seconds(0.1234), "0.123 s");
        assert_eq!(seconds(125.2), "2 min 5 s");
        assert_eq!(seconds(7260.0), "2 h 1 min");
        assert_eq!(bytes(13_107_200), "12.5 MiB");
    }

    #[test]
    fn columns_are_aligned_and_json_is_one_object() {
        let mut report = Report::default();
        report.fact("faces", 6, "faces", "6");
        report.fact("area", number(f64::NAN), "total area", "?");
        report.plain("whatever");
        let mut text = Vec::new();
        report.write_lines(&mut text).unwrap();
        assert_eq!(
            String::from_utf8(text).unwrap(),
            "faces       6\ntotal area  ?\nwhatever\n"
        );
        let mut json = Vec::new();
        report.write_json(&mut json).unwrap();
        assert_eq!(
            String::from_utf8(json).unwrap(),
            "{\"area\":null,\"faces\":6}\n"
        );
    }
}
