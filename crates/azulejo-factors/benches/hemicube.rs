//! Hemicubes per second on the processor, compared with rays.
//!
//! `cargo bench -p azulejo-factors --bench hemicube -- [rooms] [mirrors]`; both without arguments.
#![allow(clippy::print_stdout, reason = "a benchmark prints its table")]

#[path = "drawing/mod.rs"]
mod drawing;

use azulejo_trace::item_buffer::Processor;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let has = |word: &str| words.iter().any(|w| w == word);
    if has("rooms") || !has("mirrors") {
        drawing::print_table(&[&Processor]);
    }
    if has("mirrors") || !has("rooms") {
        drawing::print_mirrors(&[&Processor]);
    }
}
