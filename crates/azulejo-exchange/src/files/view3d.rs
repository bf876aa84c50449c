//! View3D's output.

use super::{FactorFiles, FactorFormat, FileOptions};
use crate::enclosure::Enclosure;
use azulejo_factors::FormFactors;
use azulejo_formats::view3d::{FactorHeader, MatrixLayout, write_factors};
use std::io::{self, Write};

/// What View3D's output says besides the matrix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View3dTable {
    /// Its header.
    pub header: FactorHeader,
    /// The emissivity of each row.
    pub emissivities: Vec<f64>,
}

pub(super) fn prepare<'a>(
    format: FactorFormat,
    enclosure: &'a Enclosure,
    options: &FileOptions,
) -> FactorFiles<'a> {
    let layout = match format {
        FactorFormat::View3dBinary => MatrixLayout::Binary,
        _ => MatrixLayout::Text,
    };
    let table = options.view3d.clone().unwrap_or_else(|| View3dTable {
        header: FactorHeader {
            layout,
            ..FactorHeader::default()
        },
        emissivities: enclosure.absorptances(),
    });
    FactorFiles::single(move |out| write(&enclosure.factors, &table, out))
}

/// Writes a matrix in View3D's format.
///
/// # Errors
/// Those of writing.
pub fn write(factors: &FormFactors, table: &View3dTable, out: &mut dyn Write) -> io::Result<()> {
    let blocks = factors.blocks().into_iter();
    let rows = blocks.flat_map(|block| factors.rows(block));
    let whole = |row: Vec<(u32, f64, f32)>| {
        let mut whole = vec![0.0; factors.len()];
        row.iter().for_each(|&(j, f, _)| whole[j as usize] = f);
        Ok(whole)
    };
    let rows = rows.map(whole);
    write_factors(table.header, &factors.areas, rows, &table.emissivities, out)
}
