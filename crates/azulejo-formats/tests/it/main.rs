//! Readers and writers on whole files.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod mgf;
mod obj;
mod openflight;
mod sff;
mod table_1;
#[cfg(feature = "fonts")]
mod tiny_font;
#[cfg(feature = "fonts")]
mod typeface;

/// The folder of shared models and scenes, if this machine has it.
fn data() -> Option<std::path::PathBuf> {
    let folder = std::env::var_os("AZULEJO_DATA").map(Into::into);
    if folder.is_none() {
        eprintln!("skipped: AZULEJO_DATA is not set");
    }
    folder
}
