//! The workbench as a page in a browser.
//!
//! `page/` has the page itself; `tool/` makes a folder of static files of both. What a page does differently is in
//! `platform` of `azulejo-workbench`; here are only the functions that the page and its workers call.

#![cfg(target_arch = "wasm32")]

mod bits;
mod page;

pub use page::*;
