//! Any bytes as a PPF font: what is read must come back the same after writing.
#![no_main]

use azulejo_formats::outline::ppf;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok((font, _)) = ppf::read(bytes, "fuzz.ppf") else {
        return;
    };
    let mut again = Vec::new();
    ppf::write(&font, &mut again).expect("what was read has a spelling");
    let (read, _) = ppf::read(&again, "again.ppf").expect("what is written is read");
    assert_eq!(font, read);
});
