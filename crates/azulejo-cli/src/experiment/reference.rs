//! The reference that runs are compared with: some rows of its matrix and its radiosities, stored
//! in the report's folder as NumPy arrays.

use crate::failure::Failure;
use crate::matrix_metrics::SparseRow;
use azulejo::output::Output;
use azulejo_formats::numpy::npy;
use azulejo_scene::Rgb;
use azulejo_trace::Progress;
use std::path::{Path, PathBuf};

/// Some rows of a matrix and all radiosities.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferenceData {
    /// Indices of the rows, ascending.
    pub indices: Vec<usize>,
    /// The rows.
    pub rows: Vec<SparseRow>,
    /// B of all rows, W/m².
    pub radiosity: Vec<Rgb>,
}

/// Indices of `count` rows among `all`, evenly spread.
pub fn spread(all: usize, count: usize) -> Vec<usize> {
    let count = count.min(all);
    (0..count)
        .map(|k| (2 * k + 1) * all / (2 * count))
        .collect()
}

impl ReferenceData {
    /// Writes it as `NAME-rows.npy`, triples of row, column and form factor, and `NAME-b.npy`, three
    /// channels for each row.
    pub fn write(&self, folder: &Path, name: &str, progress: &Progress) -> Result<(), Failure> {
        let entry = |(&i, row): (&usize, &SparseRow)| {
            let triple = move |&(j, x): &(u32, f64)| [i as f64, f64::from(j), x];
            row.iter().flat_map(triple).collect::<Vec<f64>>()
        };
        let triples: Vec<f64> = self
            .indices
            .iter()
            .zip(&self.rows)
            .flat_map(entry)
            .collect();
        let b: Vec<f64> = self
            .radiosity
            .iter()
            .flat_map(|b| [b.r, b.g, b.b])
            .collect();
        let [rows_path, radiosity_path] = paths(folder, name);
        for (path, values) in [(rows_path, triples), (radiosity_path, b)] {
            let shape = [values.len() / 3, 3];
            Output::check(&path)?.write(progress, |out| npy::write(&shape, &values, out))?;
        }
        Ok(())
    }

    /// Reads the files of [`write`](ReferenceData::write), with `count` rows.
    pub fn read(folder: &Path, name: &str, count: usize) -> Result<ReferenceData, Failure> {
        let [rows_path, radiosity_path] = paths(folder, name);
        let (triples, b) = (read_triples(&rows_path)?, read_triples(&radiosity_path)?);
        let indices = spread(b.len(), count);
        let mut rows = vec![SparseRow::new(); indices.len()];
        for [i, j, x] in triples {
            if let Ok(k) = indices.binary_search(&(i as usize)) {
                rows[k].push((j as u32, x));
            }
        }
        Ok(ReferenceData {
            indices,
            rows,
            radiosity: b.into_iter().map(|[r, g, b]| Rgb::new(r, g, b)).collect(),
        })
    }
}

fn paths(folder: &Path, name: &str) -> [PathBuf; 2] {
    ["rows", "b"].map(|what| folder.join(format!("{name}-{what}.npy")))
}

fn read_triples(path: &Path) -> Result<Vec<[f64; 3]>, Failure> {
    let bytes = std::fs::read(path).map_err(|e| Failure::file("read", path, &e))?;
    let array =
        npy::read(&bytes).map_err(|e| Failure::failed(format_args!("{}: {e}", path.display())))?;
    let (triples, _) = array.values.as_chunks();
    Ok(triples.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_spread_evenly() {
        assert_eq!(spread(10, 5), [1, 3, 5, 7, 9]);
        assert_eq!(spread(3, 256), [0, 1, 2]);
        assert_eq!(spread(0, 4), [0usize; 0]);
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = std::env::temp_dir().join(format!("azulejo-reference-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let reference = ReferenceData {
            indices: vec![0, 2],
            rows: vec![vec![(1, 0.25), (3, 1e-9)], Vec::new()],
            radiosity: vec![Rgb::WHITE, Rgb::new(1.0, 2.0, 3.0), Rgb::BLACK, Rgb::WHITE],
        };
        let spread_rows = ReferenceData {
            indices: spread(4, 2),
            ..reference
        };
        spread_rows.write(&folder, "r", &Progress::new()).unwrap();
        assert_eq!(ReferenceData::read(&folder, "r", 2).unwrap(), spread_rows);
        assert!(ReferenceData::read(&folder, "other", 2).is_err());
        std::fs::remove_dir_all(folder).unwrap();
    }
}
