//! Characters by the names of their glyphs.

use azulejo_scene::{Encoding, Font};
use read_fonts::ps::agl;

/// ASCII characters used for typographic ones that have no glyph of their own: the
/// reverse of Adobe's list, because PPF fonts draw quotes and minus signs.
const STAND_INS: [(u32, &str); 5] = [
    (0x27, "quoteright"),
    (0x2d, "hyphen"),
    (0x2d, "minus"),
    (0x60, "quoteleft"),
    (0x7e, "tilde"),
];

/// The encoding of a font without one, by the Adobe Glyph List: `eacute` is `é`, and
/// `uni20AC` is `€`. Variants, such as `A.swash`, are used only for letters that have no
/// plain glyph.
pub fn encoding_of(font: &Font) -> Encoding {
    let mut encoding = Encoding::default();
    let (plain, variants): (Vec<&String>, Vec<&String>) =
        font.glyphs.keys().partition(|name| !name.contains('.'));
    for name in plain.into_iter().chain(variants) {
        if let Some(character) = agl::name_to_char(name) {
            let entry = encoding.names.entry(u32::from(character));
            entry.or_insert_with(|| name.clone());
        }
    }
    for (code, name) in STAND_INS {
        if font.glyphs.contains_key(name) {
            let entry = encoding.names.entry(code);
            entry.or_insert_with(|| name.to_owned());
        }
    }
    encoding
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Figure, Glyph};

    #[test]
    fn glyph_names_determine_characters() {
        let names = [
            "A",
            "A.swash",
            "B.alt",
            "eacute",
            "uni20AC",
            "minus",
            "Clave_sol",
        ];
        let glyph = |n: &str| (n.to_owned(), Glyph::new(Figure::default()));
        let font = Font {
            glyphs: names.map(glyph).into(),
        };
        let encoding: Vec<(char, String)> = encoding_of(&font)
            .names
            .into_iter()
            .map(|(code, name)| (char::from_u32(code).unwrap(), name))
            .collect();
        let expected = [
            ('-', "minus"),
            ('A', "A"),
            ('B', "B.alt"),
            ('é', "eacute"),
            ('€', "uni20AC"),
            ('−', "minus"),
        ];
        assert_eq!(encoding, expected.map(|(c, n)| (c, n.to_owned())));
    }
}
