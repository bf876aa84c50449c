//! Formats that are recognized by their first bytes.

use super::{Detection, EMPTY, Format};
use crate::reading::text::decoded;

/// Bytes of a file that are examined for magic bytes.
pub(super) const LOOKED_AT: usize = 1 << 16;

/// Formats that begin with magic bytes.
pub(super) fn known_mark(bytes: &[u8]) -> Option<Detection> {
    use Format::*;
    const MARKS: [(&[u8], Detection); 28] = [
        (b"\x89PNG", Err("a PNG picture")),
        (b"\xff\xd8\xff", Err("a JPEG picture")),
        (b"GIF8", Err("a GIF picture")),
        (b"\x76\x2f\x31\x01", Err("an OpenEXR picture")),
        (b"#?RADIANCE", Err("a Radiance picture")),
        (b"IESNA", Ok(Photometry)),
        (b"IES:LM-63", Ok(Photometry)),
        // Other archives than packages are told by what is in them.
        (b"PK\x03\x04", Ok(ThreeMf)),
        (b"%PDF", Err("a PDF document")),
        (b"BLENDER", Err("a Blender file; export it as glTF")),
        (b"Kaydara FBX", Err("an FBX model; export it as glTF")),
        (b"AC10", Err("a DWG drawing; export it as DXF")),
        (b"; FBX", Err("an FBX model; export it as glTF")),
        (b"//Maya ASCII", Err("a Maya scene; export it as glTF")),
        (b"ISO-10303-21;", Err("a STEP or IFC model")),
        (b"#usda", Err("a USD scene; export it as glTF")),
        (b"\x7fELF", Err("a program")),
        (b"AutoCAD Binary DXF", Ok(Dxf)),
        (b"glTF", Ok(Gltf)),
        (b"$MeshFormat", Ok(Gmsh)),
        (b"# vtk DataFile", Ok(Vtk)),
        (b"ply\n", Ok(Ply)),
        (b"ply\r", Ok(Ply)),
        (b"ply ", Ok(Ply)),
        (b"#VRML", Ok(Vrml)),
        (b"#X3D", Ok(Vrml)),
        (b"#Inventor V1.0 ascii", Ok(Vrml)),
        (b"#Inventor V2", Ok(Vrml)),
    ];
    if bytes.is_empty() {
        return Some(Err(EMPTY));
    }
    // Marks of text formats may be in UTF-16, or behind a byte-order mark.
    let text = decoded(&bytes[..bytes.len().min(LOOKED_AT)]);
    let mark = MARKS.iter().find(|(mark, _)| text.starts_with(mark));
    // The others are told by numbers at their start; TIFF comes last, as it shares some with 3DS.
    mark.map(|(_, format)| *format)
        .or_else(|| is_openflight(bytes).then_some(Ok(OpenFlight)))
        .or_else(|| is_3ds(bytes).then_some(Ok(Studio3ds)))
        .or_else(|| is_binary_stl(bytes).then_some(Ok(Stl)))
        .or_else(|| is_tiff(bytes).then_some(Err("a TIFF picture")))
}

/// A header record: opcode 1 and a length that occurs in some revision.
fn is_openflight(bytes: &[u8]) -> bool {
    matches!(bytes, [0, 1, high, low, ..]
        if (128..=1024).contains(&u16::from_be_bytes([*high, *low])))
}

/// The main chunk, followed by a chunk that may come first in it.
fn is_3ds(bytes: &[u8]) -> bool {
    let first = |at: usize| Some(u16::from_le_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]));
    first(0) == Some(0x4d4d) && matches!(first(6), None | Some(0x0002 | 0x3d3d | 0x3d3e | 0xb000))
}

/// Either byte order; behind 3DS, with which one of them shares its first bytes.
fn is_tiff(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MM\0*") || bytes.starts_with(b"II*\0")
}

/// 80 arbitrary bytes, a count, and 50 bytes for each triangle. Some writers append a few bytes,
/// some begin the 80 bytes like the text format, and a few used the other byte order.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let length = bytes.len() as u64;
    let expected = |count: u32| 84 + 50 * u64::from(count);
    let fits = |e: u64| e == length || (e > 84 && e < length && length - e < 50);
    let count = bytes.get(80..84).and_then(|b| b.try_into().ok());
    count.is_some_and(|c| {
        fits(expected(u32::from_le_bytes(c))) || expected(u32::from_be_bytes(c)) == length
    })
}
