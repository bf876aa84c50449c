//! Tables as records, whatever their format.

use super::TableError;

/// What is said under one name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NamedRecord {
    pub name: String,
    /// Where it is: `line 3`, or the table's name.
    pub place: String,
    pub fields: Vec<(String, TableCell)>,
}

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum TableCell {
    Number(f64),
    Text(String),
}

impl NamedRecord {
    /// The number of a column, if there is one.
    pub fn number(&self, column: &str) -> Result<Option<f64>, TableError> {
        match self.field(column) {
            None => Ok(None),
            Some(TableCell::Number(x)) if x.is_finite() => Ok(Some(*x)),
            Some(TableCell::Number(x)) => Err(self.wrong(column, x, "a finite number")),
            Some(TableCell::Text(text)) => {
                Err(self.wrong(column, format_args!("\"{text}\""), "a number"))
            }
        }
    }

    fn field(&self, column: &str) -> Option<&TableCell> {
        let mut fields = self.fields.iter();
        fields.find(|(c, _)| c == column).map(|(_, cell)| cell)
    }

    /// An error about one of its values.
    pub fn wrong(
        &self,
        column: &str,
        found: impl std::fmt::Display,
        expected: impl std::fmt::Display,
    ) -> TableError {
        let NamedRecord { name, place, .. } = self;
        TableError::new(format_args!(
            "{place}: {column} of \"{name}\" is {found}, expected {expected}"
        ))
    }
}

/// Reads a table: TOML if a line begins with `[`, else values divided by tabs, semicolons or commas,
/// whichever the first line has, under a header. Columns without a value are left out.
pub(super) fn records(text: &str) -> Result<Vec<NamedRecord>, TableError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.lines().any(|line| line.trim_start().starts_with('[')) {
        return from_toml(text);
    }
    from_lines(text)
}

fn from_toml(text: &str) -> Result<Vec<NamedRecord>, TableError> {
    let tables: toml::Table = text
        .parse()
        .map_err(|e: toml::de::Error| TableError::new(e.to_string().trim_end()))?;
    let record = |(name, value): (String, toml::Value)| {
        let toml::Value::Table(fields) = value else {
            return Err(TableError::new(format_args!(
                "\"{name}\" is not a table, expected [\"{name}\"] and values below it"
            )));
        };
        let field = |(column, value): (String, toml::Value)| {
            let cell = match value {
                toml::Value::Float(x) => TableCell::Number(x),
                toml::Value::Integer(x) => TableCell::Number(x as f64),
                toml::Value::Boolean(x) => TableCell::Number(f64::from(u8::from(x))),
                other => TableCell::Text(other.to_string()),
            };
            (column, cell)
        };
        Ok(NamedRecord {
            place: format!("[\"{name}\"]"),
            fields: fields.into_iter().map(field).collect(),
            name,
        })
    };
    tables.into_iter().map(record).collect()
}

fn from_lines(text: &str) -> Result<Vec<NamedRecord>, TableError> {
    let mut lines = text.lines().enumerate();
    let is_content = |line: &str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let header = lines.find(|(_, line)| is_content(line));
    let Some((_, header)) = header else {
        return Err(TableError::new(
            "the table is empty, expected a header with `name`",
        ));
    };
    // The header says what divides values, and which of them is the name.
    let delimiter = ['\t', ';', ','].into_iter().find(|&d| header.contains(d));
    let delimiter = delimiter.unwrap_or(',');
    let columns = split(header, delimiter);
    let key = columns.iter().position(|c| c.eq_ignore_ascii_case("name"));
    let Some(key) = key else {
        return Err(TableError::new(format_args!(
            "the header is \"{}\", expected a column `name`",
            header.trim()
        )));
    };
    let mut records = Vec::new();
    for (number, line) in lines.filter(|(_, line)| is_content(line)) {
        let place = format!("line {}", number + 1);
        let cells = split(line, delimiter);
        // A line of another length would put values into wrong columns.
        if cells.len() != columns.len() {
            return Err(TableError::new(format_args!(
                "{place}: {} values, expected {}, one for each column of the header",
                cells.len(),
                columns.len()
            )));
        }
        // An empty cell is a value that is not given.
        let fields = columns.iter().zip(&cells).enumerate();
        let fields = fields.filter(|(k, (_, cell))| *k != key && !cell.is_empty());
        records.push(NamedRecord {
            name: cells[key].clone(),
            place,
            fields: fields
                .map(|(_, (c, cell))| (c.clone(), value(cell)))
                .collect(),
        });
    }
    Ok(records)
}

fn value(cell: &str) -> TableCell {
    match cell.parse() {
        Ok(number) => TableCell::Number(number),
        Err(_) => TableCell::Text(cell.to_owned()),
    }
}

/// The values of a line; those in quotation marks may contain the delimiter, and two marks for one.
fn split(line: &str, delimiter: char) -> Vec<String> {
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if is_quoted && letters.peek() == Some(&'"') => {
                letters.next();
                cell.push('"');
            }
            '"' => is_quoted = !is_quoted,
            _ if letter == delimiter && !is_quoted => {
                cells.push(cell.trim().to_owned());
                cell.clear();
            }
            _ => cell.push(letter),
        }
    }
    cells.push(cell.trim().to_owned());
    cells
}
