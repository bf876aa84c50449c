//! Any bytes as a model of whichever format they are recognized to be, packed or not, under names
//! that leave the choice to the content and names that do not: what is read must be valid.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, detect, read_with, recognize};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let detected = detect(bytes);
    let options = ReadOptions::in_proportion(bytes.len());
    for name in ["fuzz", "fuzz.vs3", "fuzz.scn", "fuzz.off", "fuzz.sff.gz"] {
        let recognized = recognize(bytes, name);
        if name == "fuzz" {
            assert_eq!(
                recognized, detected,
                "a name without an extension decides nothing"
            );
        }
        let loaded = read_with(bytes, name, &Memory::new(), &options);
        if let Ok(loaded) = loaded {
            loaded
                .scene
                .validate()
                .expect("a reader gives valid scenes");
        }
    }
});
