//! Any text as a suite of experiments: it is read, or refused with a message.
#![no_main]

use azulejo_cli::parsers::parse_suite;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Err(message) = parse_suite(text) {
        assert!(!message.is_empty());
    }
});
