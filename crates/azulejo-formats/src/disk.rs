//! The files of the machine: those of [`std::fs`], or in a web page, which has none, files in memory.
//!
//! Whoever reads or writes a file that a user names does it through this module; nothing else needs to know
//! where it runs. In a page, files that are dropped are [written](self::write) here before they are opened,
//! and what is saved is found here by the page that offers it as a download.

#[cfg(not(target_arch = "wasm32"))]
pub use std::fs::*;

#[cfg(any(test, target_arch = "wasm32"))]
#[cfg_attr(
    not(target_arch = "wasm32"),
    allow(dead_code, reason = "its tests take a part")
)]
mod in_memory;
#[cfg(target_arch = "wasm32")]
pub use in_memory::*;
