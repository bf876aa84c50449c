//! Clocks: those of [`std::time`], or in a web page, where those stop the program, the same of the browser.

#[cfg(not(target_arch = "wasm32"))]
pub use std::time::*;
#[cfg(target_arch = "wasm32")]
pub use web_time::*;
