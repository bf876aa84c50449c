//! Any bytes as a typeface, and text set in it: what is converted must be written and read.
#![no_main]

use azulejo_formats::outline::ppf;
use azulejo_formats::outline::typeface::Typeface;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(typeface) = Typeface::read(bytes, "fuzz.ttf", 0) else {
        return;
    };
    for text in ["AVo ffi é", "אבג ab", "ببب"] {
        let _ = typeface.setting().line(text, 0.01);
    }
    let characters = typeface.characters();
    if let Ok(converted) = typeface.convert(characters.into_iter().take(100)) {
        let mut font = Vec::new();
        ppf::write(&converted.font, &mut font).expect("names and numbers have a spelling");
        let (read, _) = ppf::read(&font, "again.ppf").expect("what is written is read");
        assert_eq!(read, converted.font);
    }
});
