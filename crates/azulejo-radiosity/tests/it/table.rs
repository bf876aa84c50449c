//! Reader of the reference table of form factors.

use glam::DVec3;
use std::path::PathBuf;

/// One row of the table; the lists stay empty where its geometry is given in words alone.
#[derive(Clone, Debug)]
pub struct Row {
    pub id: String,
    pub value: f64,
    /// Significant digits that the value is good for.
    pub digits: i32,
    pub p1: Vec<DVec3>,
    pub p2: Vec<DVec3>,
    pub occluders: Vec<Vec<DVec3>>,
    pub mirrors: Vec<Mirror>,
    /// The surface element in place of `p1`: its position and normal.
    pub point_normal: Option<(DVec3, DVec3)>,
}

/// A perfect mirror with its reflectance.
#[derive(Clone, Debug)]
pub struct Mirror {
    pub rho_s: f64,
    pub polygon: Vec<DVec3>,
}

impl Row {
    /// Half a unit of the last good digit, relative to the value.
    pub fn tolerance(&self) -> f64 {
        0.5 * 10_f64.powi(1 - self.digits)
    }

    /// Whether the row is two polygons, or an element and a polygon, with nothing about them.
    pub fn is_bare(&self) -> bool {
        let from = self.point_normal.is_some() || !self.p1.is_empty();
        from && !self.p2.is_empty() && self.occluders.is_empty() && self.mirrors.is_empty()
    }
}

/// All rows, or `None` (with a word on standard error) where the reference data is not there.
pub fn rows() -> Option<Vec<Row>> {
    let Some(data) = std::env::var_os("AZULEJO_DATA") else {
        eprintln!("skipped: AZULEJO_DATA is not set");
        return None;
    };
    let path = PathBuf::from(data).join("reference/view_factors.tsv");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Some(
        text.lines()
            .skip(1)
            .map(|line| row(line).unwrap_or_else(|| panic!("bad row: {line}")))
            .collect(),
    )
}

fn row(line: &str) -> Option<Row> {
    let fields: Vec<&str> = line.split('\t').collect();
    let mut row = Row {
        id: fields.first()?.to_string(),
        value: fields.get(3)?.parse().ok()?,
        digits: fields.get(4)?.parse().ok()?,
        p1: Vec::new(),
        p2: Vec::new(),
        occluders: Vec::new(),
        mirrors: Vec::new(),
        point_normal: None,
    };
    for part in fields[2].split("; ") {
        // The list of corners follows the last sign: `MIRROR rho_s=0.8=(0,0,0) ...`.
        let Some((name, list)) = part.rsplit_once('=') else {
            continue;
        };
        match name {
            "P1" => row.p1 = points(list)?,
            "P2" => row.p2 = points(list)?,
            "OCC" => row.occluders.push(points(list)?),
            "p=(0,0,0) n" => row.point_normal = Some((DVec3::ZERO, points(list)?[0])),
            _ => {
                if let Some(rho_s) = name.strip_prefix("MIRROR rho_s=") {
                    row.mirrors.push(Mirror {
                        rho_s: rho_s.parse().ok()?,
                        polygon: points(list)?,
                    });
                }
            }
        }
    }
    // Mirrors in words: only the rows' ids know them, so their polygons are of no use alone.
    let in_words = fields[2].contains("mirror ") || fields[2].contains("mirrors ");
    if in_words {
        row.p1.clear();
        row.p2.clear();
    }
    Some(row)
}

fn points(list: &str) -> Option<Vec<DVec3>> {
    list.split_whitespace().map(point).collect()
}

fn point(text: &str) -> Option<DVec3> {
    let inner = text.strip_prefix('(')?.strip_suffix(')')?;
    let numbers: Vec<f64> = inner
        .split(',')
        .map(|n| n.parse().ok())
        .collect::<Option<_>>()?;
    Some(DVec3::from_array(numbers.try_into().ok()?))
}

#[test]
fn a_row_is_read() {
    let mirrored = row("m\twords\tP1=(0,0,0) (1,0,0) (0,1,0); P2=(0,0,1) (0,1,1) (1,0,1.5); MIRROR rho_s=0.8=(0,0,0) (0,1,0) (0,0,1)\t0.25\t8\ta\tb").unwrap();
    assert_eq!(mirrored.p2[2], DVec3::new(1.0, 0.0, 1.5));
    assert_eq!(
        (mirrored.mirrors[0].rho_s, mirrored.mirrors[0].polygon.len()),
        (0.8, 3)
    );
    assert_eq!(
        (mirrored.value, mirrored.digits, mirrored.is_bare()),
        (0.25, 8, false)
    );
    let element =
        row("e\twords\tp=(0,0,0) n=(0,0,1); P2=(0,0,1) (0,1,1) (1,1,1)\t0.1\t15\ta\tb").unwrap();
    assert_eq!(element.point_normal, Some((DVec3::ZERO, DVec3::Z)));
    assert!(element.is_bare() && element.tolerance() == 0.5e-14);
}
