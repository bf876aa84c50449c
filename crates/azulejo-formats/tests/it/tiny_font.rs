//! TrueType fonts with a few glyphs, built byte by byte: plain, variable, in colours, and packed as on the web.

/// Points of a contour, and whether they are on the curve or control points.
type Points = &'static [(i16, i16, bool)];

const BOX: Points = &[
    (50, 0, true),
    (50, 700, true),
    (450, 700, true),
    (450, 0, true),
];
const TRIANGLE: Points = &[(0, 0, true), (300, 700, true), (600, 0, true)];
/// Four off-curve points: the curve passes through the midpoints between them.
const ROUND: Points = &[
    (0, 0, false),
    (0, 600, false),
    (600, 600, false),
    (600, 0, false),
];
const ROUND_HOLE: Points = &[
    (150, 150, false),
    (450, 150, false),
    (450, 450, false),
    (150, 450, false),
];
const SHIFTED_BOX: Points = &[
    (250, 100, true),
    (250, 500, true),
    (650, 500, true),
    (650, 100, true),
];

/// Contours, advance and character of each glyph; the first is the missing glyph.
const GLYPHS: [(&[Points], u16, char); 6] = [
    (&[BOX], 500, '\0'),
    (&[], 250, ' '),
    (&[TRIANGLE], 600, 'A'),
    (&[BOX, SHIFTED_BOX], 700, 'X'),
    (&[ROUND, ROUND_HOLE], 700, 'o'),
    (&[BOX], 500, 'א'),
];

/// `A` and `o` are 100 units closer.
const KERNING: [(u16, u16, i16); 1] = [(2, 4, -100)];

fn be16(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_be_bytes()).collect()
}

fn glyph(contours: &[Points]) -> Vec<u8> {
    if contours.is_empty() {
        return Vec::new();
    }
    let points: Vec<_> = contours.iter().copied().flatten().collect();
    let mut bytes = be16(&[contours.len() as u16, 0, 0, 1000, 1000]);
    let mut last = 0;
    for contour in contours {
        last += contour.len() as u16;
        bytes.extend(be16(&[last - 1]));
    }
    bytes.extend(be16(&[0]));
    bytes.extend(points.iter().map(|p| u8::from(p.2)));
    for axis in [|p: &(i16, i16, bool)| p.0, |p: &(i16, i16, bool)| p.1] {
        let mut at = 0;
        for point in &points {
            bytes.extend((axis(point) - at).to_be_bytes());
            at = axis(point);
        }
    }
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

fn head() -> Vec<u8> {
    let mut table = vec![0; 54];
    table[..4].copy_from_slice(&[0, 1, 0, 0]);
    table[12..16].copy_from_slice(&0x5f0f_3cf5u32.to_be_bytes());
    table[18..20].copy_from_slice(&1000u16.to_be_bytes());
    table[51] = 1;
    table
}

fn hhea() -> Vec<u8> {
    let mut table = vec![0; 36];
    table[..4].copy_from_slice(&[0, 1, 0, 0]);
    table[4..6].copy_from_slice(&800u16.to_be_bytes());
    table[35] = GLYPHS.len() as u8;
    table
}

fn maxp() -> Vec<u8> {
    let mut table = vec![0; 32];
    table[..6].copy_from_slice(&[0, 1, 0, 0, 0, GLYPHS.len() as u8]);
    table
}

fn cmap(characters: [char; 5]) -> Vec<u8> {
    let mut groups = Vec::new();
    let mut mapped: Vec<(u32, u32)> = (1..)
        .zip(characters)
        .map(|(i, c)| (u32::from(c), i))
        .collect();
    mapped.sort_unstable();
    for (code, glyph) in &mapped {
        groups.extend([*code, *code, *glyph].iter().flat_map(|v| v.to_be_bytes()));
    }
    let mut table = be16(&[0, 1, 3, 10, 0, 12, 12, 0]);
    table.extend((16 + groups.len() as u32).to_be_bytes());
    table.extend([0; 4]);
    table.extend((mapped.len() as u32).to_be_bytes());
    table.extend(groups);
    table
}

fn kern() -> Vec<u8> {
    let length = 14 + 6 * KERNING.len() as u16;
    let mut table = be16(&[0, 1, 0, length, 1, KERNING.len() as u16, 6, 0, 0]);
    for (left, right, value) in KERNING {
        table.extend(be16(&[left, right, value as u16]));
    }
    table
}

/// A table and its tag.
type Table = (&'static [u8; 4], Vec<u8>);

/// The tables of a font with these characters for the glyphs after the first, and others beside them, by their tags.
fn tables(characters: [char; 5], others: Vec<Table>) -> Vec<Table> {
    let mut glyf = Vec::new();
    let mut loca = vec![0; 4];
    for (contours, ..) in GLYPHS {
        glyf.extend(glyph(contours));
        loca.extend((glyf.len() as u32).to_be_bytes());
    }
    let hmtx = GLYPHS.iter().flat_map(|g| be16(&[g.1, 0])).collect();
    let plain: [Table; 8] = [
        (b"cmap", cmap(characters)),
        (b"glyf", glyf),
        (b"head", head()),
        (b"hhea", hhea()),
        (b"hmtx", hmtx),
        (b"kern", kern()),
        (b"loca", loca),
        (b"maxp", maxp()),
    ];
    let mut tables = others;
    tables.extend(plain);
    tables.sort();
    tables
}

/// A font that begins at a byte of its file.
fn font_at(start: usize, tables: &[Table]) -> Vec<u8> {
    let mut file = vec![0, 1, 0, 0];
    file.extend(be16(&[tables.len() as u16, 128, 3, 0]));
    let mut offset = start + 12 + 16 * tables.len();
    for (tag, table) in tables {
        file.extend(*tag);
        file.extend([0; 4]);
        file.extend((offset as u32).to_be_bytes());
        file.extend((table.len() as u32).to_be_bytes());
        offset += table.len().next_multiple_of(4);
    }
    for (_, table) in tables {
        file.extend(table);
        file.resize(file.len().next_multiple_of(4), 0);
    }
    file
}

const CHARACTERS: [char; 5] = [
    GLYPHS[1].2,
    GLYPHS[2].2,
    GLYPHS[3].2,
    GLYPHS[4].2,
    GLYPHS[5].2,
];

/// The font file.
pub fn bytes() -> Vec<u8> {
    font_at(0, &tables(CHARACTERS, Vec::new()))
}

/// The same outlines for other characters.
pub fn with_characters(characters: [char; 5]) -> Vec<u8> {
    font_at(0, &tables(characters, Vec::new()))
}

/// The same font with names of its glyphs: `blank`, `A`, `X`, `o`, `alef`.
pub fn named() -> Vec<u8> {
    let names = [".notdef", "blank", "A", "X", "o", "alef"];
    let mut post = vec![0, 2, 0, 0];
    post.resize(32, 0);
    post.extend(be16(&[6, 258, 259, 260, 261, 262, 263]));
    for name in names {
        post.push(name.len() as u8);
        post.extend(name.bytes());
    }
    font_at(0, &tables(CHARACTERS, vec![(b"post", post)]))
}

/// A font whose `A` is twice as wide at `wght=900`; its axis goes from 100, the default, to 900.
pub fn variable() -> Vec<u8> {
    let fixed = |value: u16| be16(&[value, 0]);
    let mut fvar = be16(&[1, 0, 16, 2, 1, 20, 0, 8]);
    fvar.extend(b"wght");
    fvar.extend([fixed(100), fixed(100), fixed(900)].concat());
    fvar.extend(be16(&[0, 256]));
    // Three points of the triangle and four of the metrics: those at its right move.
    let mut moves = be16(&[1, 8, 17, 0x2000]);
    moves.extend([0, 0x46]);
    moves.extend(be16(&[0, 300, 600, 0, 600, 0, 0]));
    moves.push(0x86);
    let mut gvar = be16(&[1, 0, 1, 1, 0, 48, 6, 1, 0, 50]);
    let end = moves.len() as u32;
    let offsets = [0, 0, 0, end, end, end, end];
    gvar.extend(offsets.iter().flat_map(|o| o.to_be_bytes()));
    gvar.extend(be16(&[0x4000]));
    gvar.extend(moves);
    font_at(
        0,
        &tables(CHARACTERS, vec![(b"fvar", fvar), (b"gvar", gvar)]),
    )
}

/// A palette of red, green, and half transparent blue; the bytes of entries are blue, green, red and opacity.
fn cpal() -> Vec<u8> {
    let mut table = be16(&[0, 3, 1, 3, 0, 14, 0]);
    table.extend([0, 0, 255, 255, 0, 255, 0, 255, 255, 0, 0, 128]);
    table
}

/// A font whose `A` is a red triangle below a box in the colour of the text.
pub fn colored() -> Vec<u8> {
    let colr = be16(&[0, 1, 0, 14, 0, 20, 2, 2, 0, 2, 2, 0, 0, 0xffff]);
    // The second layer is the missing glyph, a box.
    font_at(
        0,
        &tables(CHARACTERS, vec![(b"COLR", colr), (b"CPAL", cpal())]),
    )
}

/// A font of COLR version 1: its `A` paints itself, its `X` is a triangle in a gradient from red to green, its `o` a
/// half transparent blue triangle that is moved by 100 units.
pub fn painted() -> Vec<u8> {
    let mut colr = be16(&[1, 0, 0, 0, 0, 0, 0, 0, 34, 0, 0, 0, 0, 0, 0, 0, 0]);
    // Three glyphs and the offsets of their paints from this list.
    colr.extend(be16(&[0, 3, 2, 0, 22, 3, 0, 25, 4, 0, 62]));
    colr.extend([11, 0, 2]);
    // A glyph, its paint six bytes on: a linear gradient, its colours sixteen bytes on.
    colr.extend([10, 0, 0, 6, 0, 2, 4, 0, 0, 16]);
    colr.extend(be16(&[0, 0, 600, 0, 0, 700]));
    colr.extend([0, 0, 2]);
    colr.extend(be16(&[0, 0, 0x4000, 0x4000, 1, 0x4000]));
    // A shift, a glyph, and a colour.
    colr.extend([
        14, 0, 0, 8, 0, 100, 0, 0, 10, 0, 0, 6, 0, 2, 2, 0, 2, 0x40, 0,
    ]);
    font_at(
        0,
        &tables(CHARACTERS, vec![(b"COLR", colr), (b"CPAL", cpal())]),
    )
}

/// A collection of the plain font, and one with `B` instead of `A`.
pub fn collection() -> Vec<u8> {
    let mut file = b"ttcf\0\x01\0\0\0\0\0\x02".to_vec();
    let first = tables(CHARACTERS, Vec::new());
    let second = tables([' ', 'B', 'X', 'o', 'א'], Vec::new());
    let start = 20;
    let middle = start + font_at(start, &first).len();
    file.extend(
        [start, middle]
            .iter()
            .flat_map(|at| (*at as u32).to_be_bytes()),
    );
    file.extend(font_at(start, &first));
    file.extend(font_at(middle, &second));
    file
}

/// The plain font as WOFF, with the tables that `pack` makes smaller.
pub fn woff(pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let tables = tables(CHARACTERS, Vec::new());
    let mut header = b"wOFF\0\x01\0\0".to_vec();
    let mut data = Vec::new();
    let mut entries = Vec::new();
    for (tag, table) in &tables {
        let packed = Some(pack(table)).filter(|p| p.len() < table.len());
        let stored = packed.as_ref().unwrap_or(table);
        let offset = 44 + 20 * tables.len() + data.len();
        entries.extend(*tag);
        for value in [offset, stored.len(), table.len(), 0] {
            entries.extend((value as u32).to_be_bytes());
        }
        data.extend(stored);
        data.resize(data.len().next_multiple_of(4), 0);
    }
    header.extend(((44 + entries.len() + data.len()) as u32).to_be_bytes());
    header.extend(be16(&[tables.len() as u16, 0]));
    header.extend((bytes().len() as u32).to_be_bytes());
    header.resize(44, 0);
    [header, entries, data].concat()
}

/// The plain font as WOFF2, its outlines as they are and brotli's stream without compression.
pub fn woff2() -> Vec<u8> {
    /// Tags that have a number.
    const KNOWN: [&[u8; 4]; 8] = [
        b"cmap", b"head", b"hhea", b"hmtx", b"maxp", b"name", b"OS/2", b"post",
    ];
    let tables = tables(CHARACTERS, Vec::new());
    let mut entries = Vec::new();
    for (tag, table) in &tables {
        let known = KNOWN.iter().position(|known| known == tag);
        match (*tag, known) {
            (b"glyf", _) => entries.push(10 | 3 << 6),
            (b"loca", _) => entries.push(11 | 3 << 6),
            (_, Some(number)) => entries.push(number as u8),
            _ => entries.extend([&[63], &tag[..]].concat()),
        }
        if table.len() > 127 {
            entries.push(0x80 | (table.len() >> 7) as u8);
        }
        entries.push(table.len() as u8 & 0x7f);
    }
    let plain: Vec<u8> = tables.iter().flat_map(|t| t.1.clone()).collect();
    // A window of 64 KiB, one block that is not compressed, and an empty last one.
    let start = (plain.len() as u32 - 1) << 4 | 1 << 20;
    let stream = [&start.to_le_bytes()[..3], &plain, &[3]].concat();
    let mut header = b"wOF2\0\x01\0\0".to_vec();
    let total = (48 + entries.len() + stream.len()).next_multiple_of(4);
    header.extend((total as u32).to_be_bytes());
    header.extend(be16(&[tables.len() as u16, 0]));
    header.extend((bytes().len() as u32).to_be_bytes());
    header.extend((stream.len() as u32).to_be_bytes());
    header.resize(48, 0);
    let mut file = [header, entries, stream].concat();
    file.resize(total, 0);
    file
}
