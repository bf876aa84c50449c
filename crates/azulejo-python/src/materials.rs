//! Tables of emissivities.

use crate::error::{file_error, refused};
use crate::scene::NativeScene;
use azulejo_exchange::SpectralRange;
use azulejo_exchange::thermal::tables::{MaterialTable, NumberRecord, TableError};
use azulejo_scene::Scene;
use pyo3::prelude::*;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

/// What surfaces emit and reflect, by name and band.
#[pyclass(frozen, module = "pyazulejo._pyazulejo")]
pub struct NativeMaterials {
    /// The table.
    pub table: Arc<MaterialTable>,
    /// The file that it is from, as the beginning of sentences.
    pub place: String,
}

impl NativeMaterials {
    /// A sentence about it.
    pub fn refuse(&self, error: impl std::fmt::Display) -> PyErr {
        refused(format_args!("{}{error}", self.place))
    }
}

#[pymethods]
impl NativeMaterials {
    /// A table of a file: CSV, TSV or TOML.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<NativeMaterials> {
        let place = format!("{}: ", path.display());
        let bytes = fs::read(&path).map_err(|e| file_error(e, &path))?;
        let text = String::from_utf8(bytes);
        let text = text.map_err(|_| refused(format_args!("{place}not a text in UTF-8")))?;
        let table_error = |e: TableError| refused(format_args!("{place}{e}"));
        Ok(NativeMaterials {
            table: Arc::new(MaterialTable::read(&text).map_err(table_error)?),
            place,
        })
    }

    /// A table of numbers by name and column.
    #[staticmethod]
    fn from_numbers(records: Vec<NumberRecord>) -> PyResult<NativeMaterials> {
        Ok(NativeMaterials {
            table: Arc::new(MaterialTable::from_numbers(&records).map_err(refused)?),
            place: String::new(),
        })
    }

    /// The bands as columns name them; of grey surfaces an empty text.
    #[getter]
    fn bands(&self) -> Vec<String> {
        let name = |band: &azulejo_exchange::thermal::tables::TableBand| match band.range {
            SpectralRange::Thermal => String::new(),
            range => range.to_string(),
        };
        self.table.bands.iter().map(name).collect()
    }

    /// The scene with the reflectances of this table.
    fn paint(&self, scene: &NativeScene) -> PyResult<NativeScene> {
        if !self.table.has_same_mirrors() {
            return Err(self.refuse(
                "mirror reflectances differ from band to band; compute one matrix for each set of them, \
                 with materials of that set alone, and pass all of them to exchange",
            ));
        }
        let mut painted = Scene::clone(&scene.scene);
        let done = self.table.paint(&mut painted, 0);
        done.map_err(|e| self.refuse(e))?;
        Ok(NativeScene::new(painted, scene.warnings_of_reader()))
    }
}
