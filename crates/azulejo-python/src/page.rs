//! Web pages that show scenes.

use crate::error::refused;
use crate::work::{self, WorkOptions};
use azulejo::bake::web_page::{self, PageModel};
use pyo3::prelude::*;

/// What a page says of itself: its title, and what is added to its note.
pub type Words = (String, String);

/// A page as HTML, in a thread of its own.
///
/// # Errors
/// Those of `page`.
pub fn html(
    py: Python<'_>,
    page: impl FnOnce() -> PyResult<Vec<u8>> + Send + 'static,
) -> PyResult<String> {
    let bytes = work::run(py, &WorkOptions::new(None, None), move |_| page())?;
    String::from_utf8(bytes).map_err(refused)
}

/// The page of a model as HTML, if it is not larger than permitted.
///
/// # Errors
/// It cannot be written, or is larger than that.
pub fn written(model: PageModel, (title, more): Words, most: Option<u64>) -> PyResult<Vec<u8>> {
    let note = format!("{} {more}", model.note).trim().to_owned();
    let model = PageModel {
        title,
        note,
        ..model
    };
    let mut page = Vec::new();
    web_page::write(&model, &mut page).map_err(refused)?;
    check_size(page.len() as u64, most)?;
    Ok(page)
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
