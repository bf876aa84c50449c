//! Any bytes as a typeface, packed or not, and text set in it: what is converted must be written and read.
#![no_main]

use azulejo_formats::outline::ppf;
use azulejo_formats::outline::typeface::{FontFace, Layout, Setting, StyledText, Typeface, vary};
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
    let (_, _) = (typeface.features(), typeface.instance());
    let mut fonts = [FontFace::Typeface(typeface)];
    let _ = vary(
        &mut fonts,
        &["wght=500".parse().expect("an axis and its value")],
    );
    let layout = Layout {
        spacing: 0.0,
        width: Some(2.0),
    };
    let text = StyledText::plain("AVo 😀 ab");
    let _ = Setting::new(&fonts, &[]).paragraph(text, &layout);
});
