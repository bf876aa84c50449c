//! A TrueType font with a few glyphs, built byte by byte.

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

fn cmap() -> Vec<u8> {
    let mut groups = Vec::new();
    let mut mapped: Vec<(u32, u32)> = (1..)
        .zip(&GLYPHS[1..])
        .map(|(i, g)| (g.2.into(), i))
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

/// The font file.
pub fn bytes() -> Vec<u8> {
    let mut glyf = Vec::new();
    let mut loca = vec![0; 4];
    for (contours, ..) in GLYPHS {
        glyf.extend(glyph(contours));
        loca.extend((glyf.len() as u32).to_be_bytes());
    }
    let hmtx = GLYPHS.iter().flat_map(|g| be16(&[g.1, 0])).collect();
    let tables: [(&[u8; 4], Vec<u8>); 8] = [
        (b"cmap", cmap()),
        (b"glyf", glyf),
        (b"head", head()),
        (b"hhea", hhea()),
        (b"hmtx", hmtx),
        (b"kern", kern()),
        (b"loca", loca),
        (b"maxp", maxp()),
    ];
    let mut file = vec![0, 1, 0, 0];
    file.extend(be16(&[tables.len() as u16, 128, 3, 0]));
    let mut offset = 12 + 16 * tables.len();
    for (tag, table) in &tables {
        file.extend(*tag);
        file.extend([0; 4]);
        file.extend((offset as u32).to_be_bytes());
        file.extend((table.len() as u32).to_be_bytes());
        offset += table.len().next_multiple_of(4);
    }
    for (_, table) in tables {
        file.extend(&table);
        file.resize(file.len().next_multiple_of(4), 0);
    }
    file
}
