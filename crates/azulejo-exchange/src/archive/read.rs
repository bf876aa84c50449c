//! Reading archives.

use super::{BLOCKS, ORDERS, VERSION};
use crate::enclosure::{CellMesh, Enclosure, OutsideLight, RowTable, unique};
use azulejo_factors::form_factors::{Exchange, ExchangeAreas, RowRemainder, SkyFactors};
use azulejo_factors::{EngineUsed, FaceId, FormFactors};
use azulejo_formats::numpy::npy::StoredArray;
use azulejo_formats::numpy::npz::NpzReader;
use azulejo_scene::sky::SkyDivision;
use azulejo_scene::{Rgb, Up, Zone};
use glam::DVec3;
use std::collections::BTreeMap;
use std::fmt;
use std::io::{Read, Seek};
use std::sync::Arc;

/// What is wrong with an archive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArchiveError(pub(super) String);

impl fmt::Display for ArchiveError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ArchiveError {}

impl From<String> for ArchiveError {
    fn from(words: String) -> ArchiveError {
        ArchiveError(words)
    }
}

/// What was read.
#[derive(Clone, Debug, Default)]
pub struct ReadEnclosure {
    /// The enclosure.
    pub enclosure: Enclosure,
    /// Names of the arrays of the archive, in its order.
    pub arrays: Vec<String>,
    /// Whether factors are stored in 32 bits.
    pub is_single: bool,
    /// Largest difference of A_i X_ij and A_j X_ji of a pair, as a share of the smaller area, before
    /// their mean was taken: rounding in archives of azulejo.
    pub asymmetry: f64,
}

/// Reads an archive: one that [`write`](super::write) wrote, or any that SciPy can load with an array
/// `areas` beside it. What else is missing gets names by number, no errors and no geometry. Arrays
/// may together expand to at most `budget` bytes.
///
/// # Errors
/// The array, what was found and what was expected.
pub fn read(file: impl Read + Seek, budget: u64) -> Result<ReadEnclosure, ArchiveError> {
    Arrays::open(NpzReader::new(file, budget)?)?.enclosure()
}

/// The enclosure of an open archive.
impl Arrays<'_> {
    pub(super) fn enclosure(mut self) -> Result<ReadEnclosure, ArchiveError> {
        let archive = &mut self;
        let arrays = archive.npz.names();
        let entries = archive.entries()?;
        let areas = archive.areas()?;
        let mut whole = archive.exchange(&entries, &areas, "data", "std_error")?;
        let mut orders = Vec::new();
        if ORDERS
            .iter()
            .all(|[values, _]| arrays.iter().any(|name| name == values))
        {
            for [values, errors] in ORDERS {
                orders.push(archive.exchange(&entries, &areas, values, errors)?.exchange);
            }
            // The sum of the orders must be the whole to the last bit.
            whole.exchange = ExchangeAreas::sum_of(&orders);
        }
        let factors = archive.factors(areas, whole.exchange, orders)?;
        let rows = archive.row_table(&factors)?;
        Ok(ReadEnclosure {
            enclosure: Enclosure {
                factors,
                rows,
                outside: archive.outside()?,
                sky: archive.sky()?,
                elsewhere: None,
            },
            arrays,
            is_single: whole.is_single,
            asymmetry: whole.asymmetry,
        })
    }
}

/// Where entries are.
struct Entries {
    starts: Vec<usize>,
    columns: Vec<u32>,
}

/// A pair of arrays, as exchange areas.
struct ReadMatrix {
    exchange: ExchangeAreas,
    asymmetry: f64,
    is_single: bool,
}

/// The arrays of an archive.
pub(super) struct Arrays<'a> {
    pub npz: NpzReader<'a>,
    pub rows: usize,
}

impl<'a> Arrays<'a> {
    /// Opens an archive of a layout that is known.
    pub fn open(npz: NpzReader<'a>) -> Result<Arrays<'a>, ArchiveError> {
        let mut archive = Arrays { npz, rows: 0 };
        let version = archive.whole("version")?;
        if version.is_some_and(|v| v > VERSION as f64) {
            return Err(ArchiveError(format!(
                "version: the layout is of a newer azulejo ({}), expected at most {VERSION}",
                version.unwrap_or_default()
            )));
        }
        Ok(archive)
    }

    /// The layout of the matrix: `csr`, or `blocks` between clusters.
    pub fn format(&mut self) -> Result<String, ArchiveError> {
        Ok(self.texts("format")?.unwrap_or_default().concat())
    }

    /// Notes the number of rows.
    pub fn read_shape(&mut self) -> Result<(), ArchiveError> {
        let shape = self.required("shape")?;
        let (rows, columns) = match shape.len() {
            2 => (shape.integer(0), shape.integer(1)),
            _ => (-1, -1),
        };
        if rows != columns || !(0..=i64::from(u32::MAX / 2)).contains(&rows) {
            let message = format!("shape: {rows} × {columns}, expected a square matrix");
            return Err(ArchiveError(message));
        }
        self.rows = rows as usize;
        Ok(())
    }

    pub fn required(&mut self, name: &str) -> Result<StoredArray, ArchiveError> {
        let array = self.npz.array(name)?;
        array.ok_or_else(|| {
            let has = self.npz.names().join(", ");
            ArchiveError(format!("there is no array \"{name}\" (there are: {has})"))
        })
    }

    /// A number of the whole archive.
    pub fn whole(&mut self, name: &str) -> Result<Option<f64>, ArchiveError> {
        let array = self.npz.array(name)?;
        Ok(array.filter(|a| a.len() == 1).map(|a| a.number(0)))
    }

    /// A list of numbers, `each` for every row; `None` if there is no such array.
    pub fn list(&mut self, name: &str, each: usize) -> Result<Option<Vec<f64>>, ArchiveError> {
        let Some(array) = self.npz.array(name)? else {
            return Ok(None);
        };
        let numbers = array.numbers().filter(|n| n.len() == each * self.rows);
        let numbers = numbers.ok_or_else(|| {
            ArchiveError(format!(
                "{name}: its shape is {:?}, expected {each} numbers for each of {} rows",
                array.shape(),
                self.rows
            ))
        })?;
        match numbers.iter().find(|x| x.is_infinite()) {
            Some(x) => Err(ArchiveError(format!(
                "{name}: {x}, expected finite numbers"
            ))),
            None => Ok(Some(numbers)),
        }
    }

    /// A list of numbers for each row; zeros if there is no such array.
    fn numbers(&mut self, name: &str) -> Result<Vec<f64>, ArchiveError> {
        Ok(self.list(name, 1)?.unwrap_or_else(|| vec![0.0; self.rows]))
    }

    pub fn texts(&mut self, name: &str) -> Result<Option<Vec<String>>, ArchiveError> {
        let Some(array) = self.npz.array(name)? else {
            return Ok(None);
        };
        let texts = array.texts();
        texts
            .map(Some)
            .ok_or_else(|| ArchiveError(format!("{name}: numbers, expected strings")))
    }

    /// The places of entries, checked.
    fn entries(&mut self) -> Result<Entries, ArchiveError> {
        let format = self.format()?;
        if format == BLOCKS {
            let message = "format: the matrix is compressed into blocks between clusters, of which there are no \
                           single entries: exchange, info, and form-factors --by read it";
            return Err(ArchiveError(message.to_owned()));
        }
        if format != "csr" {
            return Err(ArchiveError(format!(
                "format: \"{format}\", expected \"csr\" (scipy.sparse.save_npz of a csr_array)"
            )));
        }
        self.read_shape()?;
        let starts = self.required("indptr")?.integers().unwrap_or_default();
        let indices = self.required("indices")?;
        let ascends = starts.is_sorted() && starts.first() == Some(&0);
        let ends = starts.last().copied() == Some(indices.len() as i64);
        if starts.len() != self.rows + 1 || !ascends || !ends {
            let message = "indptr: not the starts of rows, from 0 to the number of entries";
            return Err(ArchiveError(message.to_owned()));
        }
        let column = |i: usize| u32::try_from(indices.integer(i)).ok();
        let is_column = |c: Option<u32>| c.filter(|&c| (c as usize) < self.rows);
        let columns: Option<Vec<u32>> = (0..indices.len()).map(|i| is_column(column(i))).collect();
        Ok(Entries {
            starts: starts.into_iter().map(|s| s as usize).collect(),
            columns: columns.ok_or_else(|| {
                ArchiveError(format!("indices: beyond the {} columns", self.rows))
            })?,
        })
    }

    pub fn areas(&mut self) -> Result<Vec<f64>, ArchiveError> {
        let Some(areas) = self.list("areas", 1)? else {
            let message = "there is no array \"areas\", the area of each row, without which factors are not \
                           reciprocal";
            return Err(ArchiveError(message.to_owned()));
        };
        match areas.iter().find(|a| a.is_nan() || **a < 0.0) {
            Some(area) => Err(ArchiveError(format!("areas: {area}, expected 0 or more"))),
            None => Ok(areas),
        }
    }

    /// Exchange areas of one pair of arrays, each the mean of both directions.
    fn exchange(
        &mut self,
        entries: &Entries,
        areas: &[f64],
        values: &str,
        errors: &str,
    ) -> Result<ReadMatrix, ArchiveError> {
        let data = self.required(values)?;
        let spread = self.npz.array(errors)?;
        let count = entries.columns.len();
        let is_aligned = spread.as_ref().is_none_or(|s| s.len() == count);
        if data.len() != count || !is_aligned {
            return Err(ArchiveError(format!(
                "{values}, {errors}: not one number for each of {count} indices"
            )));
        }
        if let Some(i) = (0..count).find(|&i| !data.number(i).is_finite()) {
            let message = format!(
                "{values}[{i}] is {}, expected a finite number",
                data.number(i)
            );
            return Err(ArchiveError(message));
        }
        let error = |i: usize| spread.as_ref().map_or(0.0, |s| s.number(i));
        let (exchange, asymmetry) = symmetric(entries, areas, |i| (data.number(i), error(i)));
        Ok(ReadMatrix {
            exchange,
            asymmetry,
            is_single: data.is_single(),
        })
    }

    pub fn factors(
        &mut self,
        areas: Vec<f64>,
        exchange: ExchangeAreas,
        orders: Vec<ExchangeAreas>,
    ) -> Result<FormFactors, ArchiveError> {
        let n = self.rows;
        // Read the shares of each row's light that reach no column, zeros where there are none.
        let shares = [
            "sky",
            "sky_error",
            "ground",
            "ground_error",
            "hidden",
            "hidden_error",
            "cut",
            "lost",
        ];
        let mut columns = Vec::new();
        for name in shares {
            columns.push(self.numbers(name)?);
        }
        let rest = |i: usize| RowRemainder {
            sky: columns[0][i],
            sky_error: columns[1][i],
            ground: columns[2][i],
            ground_error: columns[3][i],
            hidden: columns[4][i],
            hidden_error: columns[5][i],
            cut: columns[6][i],
            lost: columns[7][i],
        };
        // What a column does not mirror ends there, so that mirror reflectances have to be shares.
        let mirrors = self.numbers("rho_s")?;
        if let Some(i) = mirrors.iter().position(|m| !(0.0..=1.0).contains(m)) {
            let message = format!("rho_s[{i}] is {}, expected 0 to 1", mirrors[i]);
            return Err(ArchiveError(message));
        }
        let unseen = self.npz.array("unseen")?.and_then(|a| a.numbers());
        let [object, face] = [0, 1].map(|k| self.pair("patch_face", k));
        let (object, face) = (object?, face?);
        let faces = (0..n).map(|i| FaceId {
            object: object[i],
            face: face[i],
        });
        // Arrays that the archive lacks stand for zeros, or for nothing known.
        Ok(FormFactors {
            exchange,
            orders,
            faces: faces.collect(),
            materials: self
                .numbers("material")?
                .iter()
                .map(|&m| m as u32)
                .collect(),
            is_back: self
                .numbers("patch_back")?
                .iter()
                .map(|&b| b != 0.0)
                .collect(),
            rest: (0..n).map(rest).collect(),
            ends: mirrors.iter().map(|m| 1.0 - m).collect(),
            row_errors: self.numbers("row_error")?,
            unseen: unseen.filter(|u| u.len() == n).unwrap_or_default(),
            is_closed: self.whole("closed")?.is_some_and(|c| c != 0.0),
            rays: self.whole("rays")?.unwrap_or_default() as u64,
            engine_used: EngineUsed {
                name: self.texts("engine")?.unwrap_or_default().concat(),
                ..EngineUsed::default()
            },
            areas,
            ..FormFactors::default()
        })
    }

    /// One of two columns of whole numbers; zeros if there is no such array.
    fn pair(&mut self, name: &str, column: usize) -> Result<Vec<u32>, ArchiveError> {
        let numbers = self.list(name, 2)?;
        let numbers = numbers.unwrap_or_else(|| vec![0.0; 2 * self.rows]);
        Ok(numbers
            .iter()
            .skip(column)
            .step_by(2)
            .map(|&x| x as u32)
            .collect())
    }

    pub fn outside(&mut self) -> Result<Option<Vec<OutsideLight>>, ArchiveError> {
        let light = self.list("irradiance", 3)?;
        let errors = self.list("irradiance_error", 3)?;
        Ok(light.map(|light| {
            let errors = errors.unwrap_or_else(|| vec![0.0; light.len()]);
            let pairs = light.chunks_exact(3).zip(errors.chunks_exact(3));
            let row = |(e, s): (&[f64], &[f64])| OutsideLight {
                irradiance: Rgb::new(e[0], e[1], e[2]),
                error: Rgb::new(s[0], s[1], s[2]),
            };
            pairs.map(row).collect()
        }))
    }

    /// What rows see of the patches of the sky; `None` if that is not there.
    pub fn sky(&mut self) -> Result<Option<SkyFactors>, ArchiveError> {
        let Some(words) = self.texts("sky_division")? else {
            return Ok(None);
        };
        let failed = |e: String| ArchiveError(format!("sky_division: {e}"));
        let division: SkyDivision = words.concat().parse().map_err(failed)?;
        let north = self.whole("sky_north")?.unwrap_or_default();
        let count = division.count();
        let Some(shares) = self.list("sky_patches", count)? else {
            return Ok(None);
        };
        let errors = self.list("sky_patches_error", count)?;
        let errors = errors.unwrap_or_else(|| vec![0.0; shares.len()]);
        let single = |numbers: Vec<f64>| numbers.into_iter().map(|x| x as f32).collect();
        Ok(Some(SkyFactors {
            division,
            north,
            shares: single(shares),
            errors: single(errors),
        }))
    }

    pub fn row_table(&mut self, factors: &FormFactors) -> Result<RowTable, ArchiveError> {
        let n = self.rows;
        let numbered = || (0..n).map(|i| i.to_string()).collect();
        let names = self.texts("names")?.unwrap_or_else(numbered);
        if names.len() != n {
            let message = format!("names: {}, expected one for each of {n} rows", names.len());
            return Err(ArchiveError(message));
        }
        let grouped_faces = self.grouped_faces()?;
        let objects = factors.faces.iter().map(|f| f.object);
        let objects = objects.chain(grouped_faces.iter().map(|(f, _)| f.object));
        let materials = factors.materials.iter().copied();
        let diffuse = self.list("diffuse", 3)?;
        let diffuse = diffuse.unwrap_or_else(|| vec![0.0; 3 * n]);
        let colour = |c: &[f64]| Rgb::new(c[0], c[1], c[2]);
        let up = self.texts("up")?.unwrap_or_default().concat();
        let length = self.whole("metres_per_unit")?;
        Ok(RowTable {
            names: unique(names),
            are_groups: self.whole("groups")?.is_some_and(|g| g != 0.0),
            objects: self.counted("object_names", "object", objects.max())?,
            materials: self.counted("material_names", "material", materials.max())?,
            zones: self.zones()?,
            diffuse: diffuse.chunks_exact(3).map(colour).collect(),
            cells: self.cells()?,
            metres_per_unit: length.filter(|l| l.is_finite() && *l > 0.0),
            up: if up == "z" { Up::Z } else { Up::Y },
            grouped_faces,
        })
    }

    /// The zone of each object; none if there are no zones.
    fn zones(&mut self) -> Result<Vec<Option<Arc<Zone>>>, ArchiveError> {
        let of_objects = self.texts("object_zones")?.unwrap_or_default();
        let [of, names] = ["mass_zones", "mass_names"].map(|name| self.texts(name));
        let areas = self
            .npz
            .array("mass_areas")?
            .and_then(|array| array.numbers());
        let masses = of?.unwrap_or_default().into_iter();
        let masses = masses.zip(
            names?
                .unwrap_or_default()
                .into_iter()
                .zip(areas.unwrap_or_default()),
        );
        let masses: Vec<_> = masses.collect();
        let zone = |name: &String| {
            let of_zone = masses.iter().filter(|(zone, _)| zone == name);
            Arc::new(Zone {
                name: name.clone(),
                masses: of_zone.map(|(_, mass)| mass.clone()).collect(),
            })
        };
        let zones: BTreeMap<&String, Arc<Zone>> = of_objects.iter().map(|n| (n, zone(n))).collect();
        let of_object = |name: &String| (!name.is_empty()).then(|| zones[name].clone());
        Ok(of_objects.iter().map(of_object).collect())
    }

    /// The faces of groups; none if there is no such array.
    fn grouped_faces(&mut self) -> Result<Vec<(FaceId, u32)>, ArchiveError> {
        let Some(array) = self.npz.array("group_faces")? else {
            return Ok(Vec::new());
        };
        let integers = array.integers().unwrap_or_default();
        let face = |f: &[i64]| {
            let [object, face, group] = [0, 1, 2].map(|k| u32::try_from(f[k]).ok());
            let group = group.filter(|&g| (g as usize) < self.rows);
            let (object, face) = (object?, face?);
            Some((FaceId { object, face }, group?))
        };
        let faces: Option<Vec<_>> = integers.chunks_exact(3).map(face).collect();
        faces.ok_or_else(|| {
            let message = "group_faces: expected an object, a face and a row, all counted from 0";
            ArchiveError(message.to_owned())
        })
    }

    /// Names of what rows count, up to the largest number; by number where there are none.
    fn counted(
        &mut self,
        name: &str,
        kind: &str,
        largest: Option<u32>,
    ) -> Result<Vec<String>, ArchiveError> {
        let needed = largest.map_or(0, |m| m as usize + 1);
        match self.texts(name)? {
            Some(names) if names.len() >= needed => Ok(names),
            Some(names) => Err(ArchiveError(format!(
                "{name}: {} names, but a row is of {kind} {}",
                names.len(),
                needed - 1
            ))),
            None if needed > self.rows.max(1) => Err(ArchiveError(format!(
                "there is no array \"{name}\", but a row is of {kind} {}",
                needed - 1
            ))),
            None => Ok((0..needed).map(|i| format!("{kind} {i}")).collect()),
        }
    }

    /// The polygons of rows; none if there are no `points`.
    fn cells(&mut self) -> Result<CellMesh, ArchiveError> {
        let Some(points) = self.npz.array("points")? else {
            return Ok(CellMesh::default());
        };
        let points = points.numbers().unwrap_or_default();
        let point = |p: &[f64]| DVec3::new(p[0], p[1], p[2]);
        let mut integers = |name: &str| -> Result<Vec<u32>, ArchiveError> {
            let array = self.required(name)?.integers().unwrap_or_default();
            let numbers: Result<Vec<u32>, _> = array.into_iter().map(u32::try_from).collect();
            numbers.map_err(|_| ArchiveError(format!("{name}: a number below 0 or too large")))
        };
        let cells = CellMesh {
            points: points.chunks_exact(3).map(point).collect(),
            corners: integers("cell_corners")?,
            starts: integers("cell_starts")?,
            rows: integers("cell_rows")?,
        };
        if cells.is_valid(self.rows) {
            return Ok(cells);
        }
        let message = "points, cell_corners, cell_starts, cell_rows: they do not fit together";
        Err(ArchiveError(message.to_owned()))
    }
}

/// Exchange areas of a matrix that comes as compressed sparse rows, of which row i has the entries
/// `starts[i]..starts[i + 1]`: the mean of both directions of each pair, and their largest difference as
/// a share of the smaller area.
///
/// # Panics
/// If the lists do not fit together, or a column is beyond the rows.
pub fn reciprocal(
    starts: &[usize],
    columns: &[u32],
    values: &[f64],
    areas: &[f64],
) -> (ExchangeAreas, f64) {
    let entries = Entries {
        starts: starts.to_vec(),
        columns: columns.to_vec(),
    };
    symmetric(&entries, areas, |k| (values[k], 0.0))
}

/// Exchange areas from rows of factors and errors, each the mean of both directions, and their largest
/// difference as a share of the smaller area.
fn symmetric(
    entries: &Entries,
    areas: &[f64],
    entry: impl Fn(usize) -> (f64, f64),
) -> (ExchangeAreas, f64) {
    let starts = &entries.starts;
    let mut upper: Vec<Vec<Exchange>> = vec![Vec::new(); areas.len()];
    // Both directions of a pair come to the row of the smaller number; entries that a file has twice
    // add up, as in SciPy.
    for i in 0..areas.len() {
        for k in starts[i]..starts[i + 1] {
            let j = entries.columns[k] as usize;
            let (value, error) = entry(k);
            // Orders of reflection have zeros where only another one has an entry.
            if value == 0.0 && error == 0.0 {
                continue;
            }
            let weight = if i == j { 1.0 } else { 0.5 };
            upper[i.min(j)].push(Exchange {
                column: i.max(j) as u32,
                value: weight * areas[i] * value,
                // The errors of both directions are one and the same.
                error: (weight * areas[i] * error) as f32,
            });
        }
    }
    let mut asymmetry: f64 = 0.0;
    let rows = upper.into_iter().enumerate().map(|(i, mut row)| {
        row.sort_by_key(|e| e.column);
        let merged = row.chunk_by(|a, b| a.column == b.column).map(|same| {
            let j = same[0].column as usize;
            let value: f64 = same.iter().map(|e| e.value).sum();
            // Without its counterpart an entry differs from it by all of its value.
            let other = match same {
                [one, two] if i != j => (one.value - two.value).abs() * 2.0,
                [one] if i != j => one.value * 2.0,
                _ => 0.0,
            };
            let smaller = areas[i].min(areas[j]).max(f64::MIN_POSITIVE);
            asymmetry = asymmetry.max(other.abs() / smaller);
            Exchange {
                value,
                error: same.iter().map(|e| e.error).sum(),
                ..same[0]
            }
        });
        merged.collect()
    });
    let exchange = ExchangeAreas::from_rows(rows.collect());
    (exchange, asymmetry)
}
