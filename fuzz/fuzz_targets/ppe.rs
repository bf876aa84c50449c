//! Any bytes as a PPE encoding: what is read must come back the same after writing, but for names
//! with blanks in them, which no font has.
#![no_main]

use azulejo_formats::outline::ppe;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok((encoding, _)) = ppe::read(bytes, "fuzz.ppe") else {
        return;
    };
    let mut again = Vec::new();
    if ppe::write(&encoding, &mut again).is_ok() {
        let (read, _) = ppe::read(&again, "again.ppe").expect("what is written is read");
        assert_eq!(encoding, read);
    }
});
