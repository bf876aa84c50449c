//! The matrix as CSV.

use super::NamedMatrix;
use azulejo_factors::FaceId;
use std::borrow::Cow;
use std::io::{self, Write};

/// Columns of the separate orders of reflection.
const ORDERS: &str =
    ",direct,direct_error,one_mirror,one_mirror_error,more_mirrors,more_mirrors_error";

/// Writes one line per entry: between patches i, j, F_ij, its standard error, and patch i's area,
/// object, face and side; between groups their names, F, its standard error and the area of the
/// first. Light that leaves the scene is on lines with `sky` and `ground` in place of j; light from
/// outside, which is no share but W/m², on lines with `irradiance`.
pub fn write(matrix: &NamedMatrix, out: &mut dyn Write) -> io::Result<()> {
    let factors = matrix.factors;
    let orders = 0..factors.orders.len();
    out.write_all(match matrix.names {
        None => b"i,j,f_ij,std_error,area_i,object_i,face_i,side_i",
        Some(_) => b"from,to,f,std_error,area_from",
    })?;
    writeln!(out, "{}", if orders.is_empty() { "" } else { ORDERS })?;
    for block in factors.blocks() {
        let parts: Vec<_> = orders
            .clone()
            .map(|o| factors.rows_of_order(o, block.clone()))
            .collect();
        for (k, row) in factors.rows(block.clone()).iter().enumerate() {
            let i = block.start + k;
            for &(j, f, e) in row {
                start(matrix, i, &matrix.name(j as usize), f, e.into(), out)?;
                for part in &parts {
                    let (_, f, e) = super::entry_of(&part[k], j);
                    write!(out, ",{f},{e}")?;
                }
                writeln!(out)?;
            }
            let rest = &factors.rest[i];
            let away = [
                ("sky", rest.sky, rest.sky_error),
                ("ground", rest.ground, rest.ground_error),
            ];
            for (name, share, error) in away.into_iter().filter(|(_, share, _)| *share > 0.0) {
                start(matrix, i, name, share, error, out)?;
                writeln!(out, "{}", ",,".repeat(orders.len()))?;
            }
            if let Some(rows) = matrix.outside {
                let (value, error) = (rows[i].mean().mean(), rows[i].standard_error().mean());
                start(matrix, i, "irradiance", value, error, out)?;
                writeln!(out, "{}", ",,".repeat(orders.len()))?;
            }
        }
    }
    Ok(())
}

/// The columns of every table.
fn start(
    matrix: &NamedMatrix,
    i: usize,
    to: &str,
    share: f64,
    error: f64,
    out: &mut dyn Write,
) -> io::Result<()> {
    let factors = matrix.factors;
    let (from, area) = (matrix.name(i), factors.areas[i]);
    // Errors are stored in single precision, and printed with no more digits.
    let error = error as f32;
    write!(out, "{from},{to},{share},{error},{area}")?;
    if matrix.names.is_none() {
        let FaceId { object, face } = factors.faces[i];
        let side = if factors.is_back[i] { "back" } else { "front" };
        write!(out, ",{object},{face},{side}")?;
    }
    Ok(())
}

impl NamedMatrix<'_> {
    /// The name of a row in a table.
    fn name(&self, i: usize) -> Cow<'_, str> {
        match self.names {
            None => i.to_string().into(),
            Some(names) => quoted(&names[i]),
        }
    }
}

/// A name quoted according to RFC 4180.
fn quoted(name: &str) -> Cow<'_, str> {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\"")).into()
    } else {
        name.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form_factors::tests::two_squares;

    fn check(names: Option<&[String]>, separate: bool, expected: &str) {
        let mut factors = two_squares();
        if !separate {
            factors.orders.clear();
        }
        let mut text = Vec::new();
        let matrix = NamedMatrix {
            factors: &factors,
            names,
            outside: None,
        };
        write(&matrix, &mut text).unwrap();
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }

    #[test]
    fn one_line_per_entry() {
        check(
            None,
            false,
            "i,j,f_ij,std_error,area_i,object_i,face_i,side_i\n\
             0,1,0.25,0.125,2,0,3,front\n0,sky,0.75,0.0625,2,0,3,front\n\
             1,0,0.5,0.25,1,7,0,back\n1,sky,0.5,0.0625,1,7,0,back\n",
        );
    }

    #[test]
    fn groups_by_name_and_orders_apart() {
        let names = ["floor".to_owned(), "a \"b\", c".to_owned()];
        check(
            Some(&names),
            true,
            "from,to,f,std_error,area_from,direct,direct_error,one_mirror,one_mirror_error,\
             more_mirrors,more_mirrors_error\n\
             floor,\"a \"\"b\"\", c\",0.25,0.125,2,0.125,0.0625,0.125,0.0625,0,0\n\
             floor,sky,0.75,0.0625,2,,,,,,\n\
             \"a \"\"b\"\", c\",floor,0.5,0.25,1,0.25,0.125,0.25,0.125,0,0\n\
             \"a \"\"b\"\", c\",sky,0.5,0.0625,1,,,,,,\n",
        );
    }
}
