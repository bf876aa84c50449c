//! Web pages that show scenes.

use crate::error::refused;
use crate::work::{self, WorkOptions};
use azulejo::bake::web_page::{self, PageModel};
use pyo3::prelude::*;

/// The page of a model, as HTML with a title and a note, if it is not larger than permitted.
///
/// # Errors
/// Those of `model`, which gets the permitted size; the page is larger than that.
pub fn html(
    py: Python<'_>,
    (title, note): (String, String),
    most: Option<u64>,
    model: impl FnOnce(Option<u64>) -> PyResult<PageModel> + Send + 'static,
) -> PyResult<String> {
    work::run(py, &WorkOptions::new(None, None), move |_| {
        let model = PageModel {
            title,
            note,
            ..model(most)?
        };
        let mut page = Vec::new();
        web_page::write(&model, &mut page).map_err(refused)?;
        check_size(page.len() as u64, most)?;
        String::from_utf8(page).map_err(refused)
    })
}

/// Refuses a page of so many bytes or more.
pub fn check_size(bytes: u64, most: Option<u64>) -> PyResult<()> {
    let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    match most.filter(|most| bytes > *most) {
        None => Ok(()),
        Some(most) => Err(refused(format_args!(
            "its page would take about {:.1} MiB or more, and the limit is {:.1} MiB",
            mebibytes(bytes),
            mebibytes(most)
        ))),
    }
}
