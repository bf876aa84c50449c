//! The compiled half of the Python package `pyazulejo`.
//!
//! What users see is written in Python (`python/pyazulejo`): names, documentation, and the checks of
//! what they pass. Here are arrays that have been checked, on their way into the libraries and back.
//! Long work runs without the interpreter, see `work`.

mod arrays;
mod brdf;
mod camera;
mod choices;
mod compressed;
mod error;
mod exchange;
mod factor_files;
mod form_factors;
mod geometry;
mod light;
mod lightmap;
mod materials;
mod page;
mod picture;
mod points;
mod reading;
mod scene;
mod work;

use pyo3::prelude::*;

/// The compiled half of pyazulejo: use the package, not this.
#[pymodule]
mod _pyazulejo {
    #[pymodule_export]
    use super::brdf::evaluate_brdf;
    #[pymodule_export]
    use super::compressed::{
        NativeCompressedFactors, compute_compressed_factors, load_compressed_factors,
    };
    #[pymodule_export]
    use super::error::AzulejoError;
    #[pymodule_export]
    use super::exchange::{NativeThermalSolution, band_fractions, solve_exchange};
    #[pymodule_export]
    use super::factor_files::{foreign_form_factors, load_form_factors, save_form_factors};
    #[pymodule_export]
    use super::form_factors::{NativeFormFactors, compute_form_factors};
    #[pymodule_export]
    use super::light::{probe_irradiance, solve_light};
    #[pymodule_export]
    use super::lightmap::{NativeLightmap, bake_lightmap};
    #[pymodule_export]
    use super::materials::NativeMaterials;
    #[pymodule_export]
    use super::picture::{render_image, tone_map};
    #[pymodule_export]
    use super::points::compute_point_factors;
    #[pymodule_export]
    use super::reading::load_scene;
    #[pymodule_export]
    use super::scene::NativeScene;
    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
