//! Any bytes as a suite of experiments: it is read, or refused with a message.
#![no_main]

use azulejo_cli::experiment::suite::Source;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let path = std::env::temp_dir().join(format!("azulejo-fuzz-{}.toml", std::process::id()));
    std::fs::write(&path, bytes).expect("a temporary folder");
    if let Err(failure) = Source::read(&path) {
        assert!(!failure.to_string().is_empty());
    }
});
