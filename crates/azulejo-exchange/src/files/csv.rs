//! The matrix as CSV.

use super::text::csv_field;
use crate::enclosure::{Enclosure, entry_of};
use azulejo_factors::FaceId;
use std::borrow::Cow;
use std::io::{self, Write};

/// Columns of the separate orders of reflection.
const ORDERS: &str =
    ",direct,direct_error,one_mirror,one_mirror_error,more_mirrors,more_mirrors_error";

/// Writes one line per entry: between patches i, j, F_ij, its standard error, and patch i's area,
/// object, face and side; between groups their names, F, its standard error and the area of the
/// first. Light that leaves the scene is on lines with `sky` and `ground` in place of j, light that ends on
/// sides without a row on lines with `hidden`; what the sky's patches have of `sky`, on lines with `sky:1` and on; light from outside, in W/m² and not a share, on lines with `irradiance`.
///
/// # Errors
/// Those of writing.
pub fn write(enclosure: &Enclosure, out: &mut dyn Write) -> io::Result<()> {
    let factors = &enclosure.factors;
    let orders = 0..factors.orders.len();
    // Groups have names, rows of patches numbers and faces.
    let columns = if enclosure.rows.are_groups {
        "from,to,f,std_error,area_from"
    } else {
        "i,j,f_ij,std_error,area_i,object_i,face_i,side_i"
    };
    out.write_all(columns.as_bytes())?;
    writeln!(out, "{}", if orders.is_empty() { "" } else { ORDERS })?;
    // Prepare some rows at a time, to limit the memory.
    for block in factors.blocks() {
        let parts: Vec<_> = orders
            .clone()
            .map(|o| factors.rows_of_order(o, block.clone()))
            .collect();
        for (k, row) in factors.rows(block.clone()).iter().enumerate() {
            let i = block.start + k;
            for &(j, f, e) in row {
                start(enclosure, i, &name(enclosure, j as usize), f, e.into(), out)?;
                for part in &parts {
                    let (_, f, e) = entry_of(&part[k], j);
                    write!(out, ",{f},{e}")?;
                }
                writeln!(out)?;
            }
            // Write what reaches no column on lines of its own, with empty columns of orders.
            let rest = &factors.rest[i];
            let away = [
                ("sky", rest.sky, rest.sky_error),
                ("ground", rest.ground, rest.ground_error),
                ("hidden", rest.hidden, rest.hidden_error),
            ];
            for (name, share, error) in away.into_iter().filter(|(_, share, _)| *share > 0.0) {
                start(enclosure, i, name, share, error, out)?;
                writeln!(out, "{}", ",,".repeat(orders.len()))?;
            }
            let of_sky = enclosure
                .sky
                .as_ref()
                .map(|sky| (sky.row(i), sky.row_errors(i)));
            let (shares, errors) = of_sky.unwrap_or_default();
            let patches = shares.iter().zip(errors).enumerate().skip(1);
            for (k, (&share, &error)) in patches.filter(|(_, (share, _))| **share > 0.0) {
                let name = format!("sky:{k}");
                start(enclosure, i, &name, share.into(), error.into(), out)?;
                writeln!(out, "{}", ",,".repeat(orders.len()))?;
            }
            if let Some(rows) = &enclosure.outside {
                let (value, error) = (rows[i].irradiance.mean(), rows[i].error.mean());
                start(enclosure, i, "irradiance", value, error, out)?;
                writeln!(out, "{}", ",,".repeat(orders.len()))?;
            }
        }
    }
    Ok(())
}

/// The columns of every table.
fn start(
    enclosure: &Enclosure,
    i: usize,
    to: &str,
    share: f64,
    error: f64,
    out: &mut dyn Write,
) -> io::Result<()> {
    let factors = &enclosure.factors;
    let (from, area) = (name(enclosure, i), factors.areas[i]);
    // Errors are stored in single precision, and printed with no more digits.
    let error = error as f32;
    write!(out, "{from},{to},{share},{error},{area}")?;
    if !enclosure.rows.are_groups {
        let FaceId { object, face } = factors.faces[i];
        let side = if factors.is_back[i] { "back" } else { "front" };
        write!(out, ",{object},{face},{side}")?;
    }
    Ok(())
}

/// The name of a row in a table.
fn name(enclosure: &Enclosure, i: usize) -> Cow<'_, str> {
    if enclosure.rows.are_groups {
        csv_field(&enclosure.rows.names[i])
    } else {
        i.to_string().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::enclosure::tests::two_squares;

    fn check(names: Option<&[String]>, separate: bool, expected: &str) {
        let mut enclosure = two_squares();
        if !separate {
            enclosure.factors.orders.clear();
        }
        if let Some(names) = names {
            enclosure.rows.names = names.to_vec();
            enclosure.rows.are_groups = true;
        }
        let mut text = Vec::new();
        write(&enclosure, &mut text).unwrap();
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }

    #[test]
    fn one_line_per_entry() {
        check(
            None,
            false,
            "i,j,f_ij,std_error,area_i,object_i,face_i,side_i\n\
             0,1,0.25,0.125,2,0,3,front\n0,sky,0.75,0.0625,2,0,3,front\n\
             1,0,0.5,0.25,1,1,0,back\n1,sky,0.5,0.0625,1,1,0,back\n",
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
