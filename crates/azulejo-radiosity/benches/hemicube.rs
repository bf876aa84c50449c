//! Hemicubes per second of the processor, beside rays.
//!
//! `cargo bench -p azulejo-radiosity --bench hemicube`
#![allow(clippy::print_stdout, reason = "a benchmark prints its table")]

#[path = "drawing/mod.rs"]
mod drawing;

use azulejo_trace::item_buffer::Processor;

fn main() {
    drawing::print_table(&[&Processor]);
}
