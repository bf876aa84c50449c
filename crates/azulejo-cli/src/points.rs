//! Points and rays from files, and rows of numbers to files.

use super::failure::Failure;
use azulejo::models;
use azulejo::output::Output;
use azulejo_factors::PointNormal;
use azulejo_formats::numpy::npy::{self, Array};
use azulejo_scene::math::Ray;
use azulejo_trace::Progress;
use glam::DVec3;
use std::path::Path;

/// Reads points and their normals: text, `.npy` n×6, or two `.npy` of n×3.
///
/// Normals are normalized.
pub fn read_points(points: &Path, normals: Option<&Path>) -> Result<Vec<PointNormal>, Failure> {
    let bytes = models::read_bytes(points)?;
    match normals {
        Some(path) => {
            let rows = paired(
                named(points, table(&bytes, 3))?,
                named(path, table(&models::read_bytes(path)?, 3))?,
                path,
            )?;
            named(points, points_of(&rows))
        }
        None => named(points, parse_points(&bytes)),
    }
}

/// Parses points with normals: text, or `.npy` n×6. Normals are normalized.
///
/// # Errors
/// What is wrong, and in which line or row.
pub fn parse_points(bytes: &[u8]) -> Result<Vec<PointNormal>, String> {
    points_of(&table(bytes, 6)?)
}

/// Rows of six numbers as points.
fn points_of(rows: &[f64]) -> Result<Vec<PointNormal>, String> {
    let point =
        |(i, row): (usize, &[f64])| point_normal(row).map_err(|e| format!("point {i}: {e}"));
    rows.chunks_exact(6).enumerate().map(point).collect()
}

fn named<T>(path: &Path, result: Result<T, String>) -> Result<T, Failure> {
    result.map_err(|e| Failure::Failed(format!("{}: {e}", path.display())))
}

/// Reads points with or without normals, all alike: text, or `.npy` n×3 or n×6. Normals are normalized.
pub fn read_places(path: &Path) -> Result<Vec<(DVec3, Option<DVec3>)>, Failure> {
    named(path, parse_places(&models::read_bytes(path)?))
}

fn parse_places(bytes: &[u8]) -> Result<Vec<(DVec3, Option<DVec3>)>, String> {
    let bare = match table(bytes, 3) {
        Ok(rows) => rows,
        // The message is of what has normals, unless nothing has.
        Err(bare) => match parse_points(bytes) {
            Ok(points) => {
                let with_normal = points.into_iter().map(|p| (p.position, Some(p.normal)));
                return Ok(with_normal.collect());
            }
            Err(_) if table(bytes, 6).is_err() => {
                return Err(format!("{bare} (or 6, with a normal)"));
            }
            Err(message) => return Err(message),
        },
    };
    let position = |(i, row): (usize, &[f64])| {
        let position = DVec3::from_slice(row);
        let is_finite = position.is_finite().then_some((position, None));
        is_finite.ok_or_else(|| format!("point {i}: the position is not finite"))
    };
    bare.chunks_exact(3).enumerate().map(position).collect()
}

/// Points and normals side by side.
fn paired(points: Vec<f64>, normals: Vec<f64>, path: &Path) -> Result<Vec<f64>, Failure> {
    if points.len() != normals.len() {
        return named(
            path,
            Err(format!(
                "{} normals for {} points",
                normals.len() / 3,
                points.len() / 3
            )),
        );
    }
    let pairs = points.chunks_exact(3).zip(normals.chunks_exact(3));
    Ok(pairs.flat_map(|(p, n)| [p, n].concat()).collect())
}

fn point_normal(row: &[f64]) -> Result<PointNormal, String> {
    let (position, normal) = (DVec3::from_slice(row), DVec3::from_slice(&row[3..]));
    match normal.try_normalize() {
        Some(normal) if position.is_finite() => Ok(PointNormal { position, normal }),
        Some(_) => Err("the position is not finite".into()),
        None => Err("the normal is zero or not finite".into()),
    }
}

/// Rows of `columns` numbers, as `.npy` or text.
fn table(bytes: &[u8], columns: usize) -> Result<Vec<f64>, String> {
    if !bytes.starts_with(b"\x93NUMPY") {
        return text_table(bytes, columns);
    }
    let Array { shape, values } = npy::read(bytes)?;
    match shape[..] {
        [_, n] if n == columns => Ok(values),
        [_, 3] if columns == 6 => Err("n x 3 points need --normals FILE.npy".into()),
        _ => Err(format!("the shape is {shape:?}, expected (n, {columns})")),
    }
}

/// Numbers separated by blanks or commas, one row per line; `#` starts a comment.
fn text_table(bytes: &[u8], columns: usize) -> Result<Vec<f64>, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "neither text nor .npy".to_string())?;
    let mut values = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let content = line.split('#').next().unwrap_or("");
        let words = content
            .split([' ', '\t', ',', '\r'])
            .filter(|w| !w.is_empty());
        let before = values.len();
        for word in words {
            let number = word.parse::<f64>().map_err(|_| {
                let word: String = word.chars().take(40).collect();
                format!("line {}: found \"{word}\", expected a number", i + 1)
            })?;
            values.push(number);
        }
        let count = values.len() - before;
        if count != 0 && count != columns {
            return Err(format!(
                "line {}: found {count} numbers, expected {columns}",
                i + 1
            ));
        }
    }
    Ok(values)
}

/// Reads rays: eight little-endian f32 each, origin, tmin, direction, tmax.
pub fn read_rays(path: &Path) -> Result<Vec<Ray>, Failure> {
    let bytes = models::read_bytes(path)?;
    named(path, parse_rays(&bytes))
}

/// Parses rays: eight little-endian f32 each, origin, tmin, direction, tmax.
///
/// # Errors
/// What is wrong, and in which ray.
pub fn parse_rays(bytes: &[u8]) -> Result<Vec<Ray>, String> {
    let (records, rest) = bytes.as_chunks::<32>();
    if !rest.is_empty() {
        return Err(format!(
            "{} bytes, expected a multiple of 32 (eight f32 per ray)",
            bytes.len()
        ));
    }
    let one = |(i, record): (usize, &[u8; 32])| ray(record).map_err(|e| format!("ray {i}: {e}"));
    records.iter().enumerate().map(one).collect()
}

fn ray(record: &[u8; 32]) -> Result<Ray, String> {
    let (words, _) = record.as_chunks::<4>();
    let number = |i: usize| f64::from(f32::from_le_bytes(words[i]));
    let ray = Ray {
        origin: DVec3::new(number(0), number(1), number(2)),
        direction: DVec3::new(number(4), number(5), number(6)),
        t_min: number(3),
        t_max: number(7),
    };
    if !ray.origin.is_finite() {
        return Err("the origin is not finite".into());
    }
    if !ray.direction.is_finite() || ray.direction == DVec3::ZERO {
        return Err("the direction is zero or not finite".into());
    }
    if ray.t_min.is_nan() || ray.t_min < 0.0 || ray.t_max.is_nan() {
        return Err(format!(
            "t runs from {} to {}, expected 0 <= tmin and tmax a number",
            ray.t_min, ray.t_max
        ));
    }
    Ok(ray)
}

/// Writes rows of `columns` numbers, as `.npy` if that is the extension, otherwise as text.
pub fn write_rows(
    output: &Output,
    columns: usize,
    values: &[f64],
    progress: &Progress,
) -> Result<(), Failure> {
    let is_npy = output
        .path()
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("npy"));
    output.write(progress, |out| {
        if is_npy {
            return npy::write(&[values.len() / columns, columns], values, out);
        }
        for row in values.chunks_exact(columns) {
            let words: Vec<String> = row.iter().map(f64::to_string).collect();
            writeln!(out, "{}", words.join(" "))?;
        }
        Ok(())
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refuse(text: &str, expected: &str) {
        let error = table(text.as_bytes(), 6).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }

    #[test]
    fn text_is_rows_of_numbers() {
        let text = "# desk\n0 0 1  0 0 1\r\n\n1,2,3,0,1,0 # door\n";
        let values = table(text.as_bytes(), 6).unwrap();
        assert_eq!(
            values,
            [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 0.0, 1.0, 0.0]
        );
        refuse("1 2 3\n", "line 1: found 3 numbers, expected 6");
        refuse("\n1 2 x 4 5 6\n", "line 2: found \"x\"");
    }

    #[test]
    fn normals_become_unit_or_are_refused() {
        let row = [0.0, 0.0, 0.0, 0.0, 3.0, 4.0];
        let normal = point_normal(&row).unwrap().normal;
        assert!((normal - DVec3::new(0.0, 0.6, 0.8)).length() < 1e-15);
        assert!(point_normal(&[0.0; 6]).is_err());
        assert!(point_normal(&[f64::NAN, 0.0, 0.0, 0.0, 0.0, 1.0]).is_err());
    }

    fn bytes(ray: [f32; 8]) -> Vec<u8> {
        ray.iter().flat_map(|x| x.to_le_bytes()).collect()
    }

    #[test]
    fn rays_are_eight_floats() {
        let good = bytes([1.0, 2.0, 3.0, 0.5, 0.0, 0.0, 1.0, f32::INFINITY]);
        let read = parse_rays(&good).unwrap();
        assert_eq!(read[0].at(2.0), DVec3::new(1.0, 2.0, 5.0));
        assert_eq!((read[0].t_min, read[0].t_max), (0.5, f64::INFINITY));
        assert!(parse_rays(&good[..31]).unwrap_err().contains("31 bytes"));
        for bad in [
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            [f32::NAN, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0],
            [0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 1.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, f32::NAN],
        ] {
            assert!(
                parse_rays(&bytes(bad)).unwrap_err().contains("ray 0"),
                "{bad:?}"
            );
        }
    }
}
