use super::read;
use crate::reader_tests::check_warnings;
use crate::{Loaded, Memory, ReadError, ReadOptions};
use azulejo_scene::{Mesh, Object, Shape, Up};
use glam::DVec3;
use proptest::prelude::*;

fn try_load(bytes: &[u8]) -> Result<Loaded, ReadError> {
    let files = Memory::new();
    let loaded = read(
        bytes,
        "a.vtk",
        &files,
        &ReadOptions::in_proportion(bytes.len()),
    )?;
    loaded.scene.validate().unwrap();
    Ok(loaded)
}

fn load(text: &str) -> Loaded {
    try_load(text.as_bytes()).unwrap_or_else(|e| panic!("{e}"))
}

fn check_error(text: &str, expected: &str) {
    let error = try_load(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(error.lines().next(), Some(expected));
}

fn meshes(loaded: &Loaded) -> Vec<&Mesh> {
    fn mesh(object: &Object) -> &Mesh {
        match &object.shape {
            Shape::Mesh(mesh) => mesh,
            _ => unreachable!("VTK has meshes only"),
        }
    }
    loaded.scene.objects.iter().map(mesh).collect()
}

/// Names of objects with their numbers of faces.
fn objects(loaded: &Loaded) -> Vec<(&str, usize)> {
    let names = loaded.scene.objects.iter().map(|o| o.name.as_str());
    std::iter::zip(names, meshes(loaded).iter().map(|m| m.faces.len())).collect()
}

/// The volume within all faces, positive if they look outwards.
fn volume(loaded: &Loaded) -> f64 {
    let of_mesh = |mesh: &&Mesh| -> f64 {
        let faces = 0..mesh.faces.len();
        let flux = faces.map(|f| mesh.face_area_vector(f).dot(mesh.face_positions(f)[0]));
        flux.sum::<f64>() / 3.0
    };
    meshes(loaded).iter().map(of_mesh).sum()
}

const CUBE: &str = "POINTS 8 double\n0 0 0 1 0 0 1 1 0 0 1 0\n0 0 1 1 0 1 1 1 1 0 1 1\n";

/// A legacy file of cells between the corners of a cube, each a type and points.
fn legacy(cells: &[(u8, &[u32])], behind: &str) -> String {
    let size: usize = cells.iter().map(|(_, points)| points.len() + 1).sum();
    let mut text = format!(
        "# vtk DataFile Version 3.0\nany title\nASCII\nDATASET UNSTRUCTURED_GRID\n{CUBE}CELLS {} {size}\n",
        cells.len()
    );
    let words = |points: &[u32]| -> String { points.iter().map(|p| format!(" {p}")).collect() };
    for (_, points) in cells {
        text += &format!("{}{}\n", points.len(), words(points));
    }
    text += &format!("CELL_TYPES {}\n", cells.len());
    for (kind, _) in cells {
        text += &format!("{kind}\n");
    }
    text + behind
}

#[test]
fn kinds_of_surfaces() {
    let cells: [(u8, &[u32]); 8] = [
        (5, &[0, 2, 1]),
        (9, &[4, 5, 6, 7]),
        (7, &[0, 1, 5, 4]),
        (8, &[0, 1, 3, 2]),
        (22, &[0, 2, 1, 7, 7, 7]),
        (28, &[4, 5, 6, 7, 0, 0, 0, 0, 0]),
        (36, &[0, 1, 5, 4, 7, 7, 7, 7]),
        (6, &[0, 1, 3, 2]),
    ];
    let loaded = load(&legacy(&cells, ""));
    let faces: Vec<Vec<DVec3>> = {
        let mesh = meshes(&loaded)[0];
        (0..mesh.faces.len())
            .map(|f| mesh.face_positions(f))
            .collect()
    };
    let plain: [(u8, &[u32]); 9] = [
        (7, &[0, 2, 1]),
        (7, &[4, 5, 6, 7]),
        (7, &[0, 1, 5, 4]),
        (7, &[0, 1, 2, 3]),
        (7, &[0, 2, 1]),
        (7, &[4, 5, 6, 7]),
        (7, &[0, 1, 5, 4]),
        (7, &[0, 1, 3]),
        (7, &[3, 1, 2]),
    ];
    let plain = load(&legacy(&plain, ""));
    let mesh = meshes(&plain)[0];
    let expected: Vec<Vec<DVec3>> = (0..9).map(|f| mesh.face_positions(f)).collect();
    assert_eq!(faces, expected);
    assert_eq!(objects(&loaded), [("surfaces", 9)]);
    assert_eq!(loaded.scene.units.up, Up::Z);
    check_warnings(
        &loaded,
        &["a.vtk: cell of second or higher order: read as flat, between its corners (2 times)"],
    );
}

#[test]
fn kinds_of_volumes() {
    let check = |kind: u8, points: &[u32], faces: usize, expected: f64| {
        let loaded = load(&legacy(&[(kind, points)], ""));
        assert_eq!(objects(&loaded), [("surfaces", faces)], "{kind}");
        let is = volume(&loaded);
        assert!((is - expected).abs() < 1e-12, "{is} in {kind}");
    };
    check(10, &[0, 1, 3, 4], 4, 1.0 / 6.0);
    check(14, &[0, 1, 2, 3, 4], 5, 1.0 / 3.0);
    check(13, &[0, 1, 3, 4, 5, 7], 5, 0.5);
    // The order that VTK's own manual shows.
    check(13, &[0, 3, 1, 4, 7, 5], 5, 0.5);
    check(12, &[0, 1, 2, 3, 4, 5, 6, 7], 6, 1.0);
    check(11, &[0, 1, 3, 2, 4, 5, 7, 6], 6, 1.0);
    check(24, &[0, 1, 3, 4, 7, 7, 7, 7, 7, 7], 4, 1.0 / 6.0);
    let faces = [
        6, 4, 0, 3, 2, 1, 4, 4, 5, 6, 7, 4, 0, 1, 5, 4, 4, 1, 2, 6, 5, 4, 2, 3, 7, 6, 4, 3, 0, 4, 7,
    ];
    check(42, &faces, 6, 1.0);
    // A prism has two of its sides in common with a polyhedron.
    let two: [(u8, &[u32]); 2] = [(13, &[0, 1, 3, 4, 5, 7]), (42, &faces)];
    assert_eq!(objects(&load(&legacy(&two, ""))), [("surfaces", 7)]);
}

#[test]
fn columns_have_sides() {
    for corners in [5u32, 6] {
        let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(corners);
        let ring = |z: u32| (0..corners).map(move |k| (angle(k).cos(), angle(k).sin(), z));
        let points: String = (0..2)
            .flat_map(ring)
            .map(|(x, y, z)| format!("{x} {y} {z}\n"))
            .collect();
        let cell: Vec<u32> = (0..2 * corners).collect();
        let count = 2 * corners;
        let text = legacy(&[(10 + corners as u8, &cell)], "")
            .replace(CUBE, &format!("POINTS {count} double\n{points}"));
        let loaded = load(&text);
        assert_eq!(objects(&loaded), [("surfaces", corners as usize + 2)]);
        let expected = f64::from(corners) / 2.0 * angle(1).sin();
        assert!((volume(&loaded) - expected).abs() < 1e-12);
        assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    }
}

#[test]
fn cells_are_skipped_with_a_count() {
    let cells: [(u8, &[u32]); 6] = [
        (3, &[0, 1]),
        (10, &[0, 1, 3, 4]),
        (5, &[0, 1, 2]),
        (99, &[0, 1, 2]),
        (5, &[0, 1, 8]),
        (5, &[0, 1, 1]),
    ];
    let loaded = load(&legacy(&cells, ""));
    assert_eq!(objects(&loaded), [("surfaces", 1)]);
    check_warnings(
        &loaded,
        &[
            "a.vtk: point or line cell: skipped, as it has no area",
            "a.vtk: volume cell: skipped, as the file has cells that are surfaces",
            "a.vtk: cell of an unknown type: skipped",
            "a.vtk: face with fewer than three different corners: skipped",
            "a.vtk: face with a corner that does not exist: skipped",
        ],
    );
    check_error(
        &legacy(&[(10, &[0, 1, 3, 4]), (99, &[0, 1, 2])], ""),
        "a.vtk: found a cell of the type 99, expected tetrahedra, pyramids, prisms, hexahedra or polyhedra, \
         as the boundary of volumes needs all of them",
    );
    let short = load(&legacy(
        &[(10, &[0, 1, 3]), (10, &[0, 1, 3, 4]), (42, &[1, 9])],
        "",
    ));
    assert_eq!(objects(&short), [("surfaces", 4)]);
    assert_eq!(
        short.warnings[1].to_string(),
        "a.vtk: volume cell with too few points: skipped (2 times)"
    );
    let twice: [(u8, &[u32]); 2] = [(10, &[0, 1, 3, 4]), (10, &[0, 1, 3, 4])];
    check_warnings(
        &load(&legacy(&twice, "")),
        &[
            "a.vtk: volumes without a boundary: each face belongs to two of them or more",
            "a.vtk: no faces: the scene is empty",
        ],
    );
}

#[test]
fn an_array_of_cells_divides_them() {
    let cells: [(u8, &[u32]); 3] = [(5, &[0, 2, 1]), (5, &[0, 3, 2]), (5, &[4, 5, 6])];
    let check = |behind: &str, expected: &[(&str, usize)], warnings: &[&str]| {
        let loaded = load(&legacy(&cells, behind));
        assert_eq!(objects(&loaded), expected, "{behind}");
        check_warnings(&loaded, warnings);
    };
    let by_patch = [("patchID 7", 2), ("patchID -1", 1)];
    check(
        "CELL_DATA 3\nSCALARS patchID int 1\nLOOKUP_TABLE default\n7 7 -1\n",
        &by_patch,
        &[],
    );
    check(
        "CELL_DATA 3\nSCALARS patchID int\nLOOKUP_TABLE default\n7 7 -1\n",
        &by_patch,
        &[],
    );
    // Names decide over the order of arrays, and other arrays are passed.
    let skipped = |count| format!("a.vtk: array of points or cells: skipped ({count} times)");
    check(
        "POINT_DATA 8\nVECTORS U float\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n\
         CELL_DATA 3\nFIELD FieldData 4\nregionId 1 3 int\n1 2 3\nMETADATA\nINFORMATION 0\n\n\
         name 1 3 string\nfloor%20slab\nlid\nfloor%20slab\nT 1 3 float\n1 nan 3\n\
         both 2 3 vtkIdType\n1 2 3 4 5 6\nCOLOR_SCALARS c 3\n0 0 0 1 1 1 0 0 0\n\
         LOOKUP_TABLE t 2\n0 0 0 1 1 1 1 1\n",
        &[("floor slab", 2), ("lid", 1)],
        &[&skipped(4)],
    );
    // Numbers that are not whole name nothing.
    let whole = [("surfaces", 3)];
    check(
        "CELL_DATA 3\nSCALARS group float\nLOOKUP_TABLE default\n1 1 2\n",
        &whole,
        &[],
    );
    check(
        "CELL_DATA 2\nSCALARS group int\nLOOKUP_TABLE default\n1 1\n",
        &whole,
        &["a.vtk: cell array that has not one value for each cell: not used"],
    );
    // Those of points neither.
    check(
        "POINT_DATA 3\nSCALARS group int\nLOOKUP_TABLE default\n1 1 2\n",
        &whole,
        &["a.vtk: array of points or cells: skipped"],
    );
    // Copies of another piece's cells, and hidden ones.
    check(
        "CELL_DATA 3\nSCALARS vtkGhostType unsigned_char\nLOOKUP_TABLE default\n1 0 32\n",
        &[("surfaces", 1)],
        &["a.vtk: cell that another piece has, or that is hidden: skipped (2 times)"],
    );
    let volumes: [(u8, &[u32]); 2] = [(13, &[0, 1, 3, 4, 5, 7]), (13, &[1, 2, 3, 5, 6, 7])];
    let loaded = load(&legacy(
        &volumes,
        "CELL_DATA 2\nSCALARS MaterialIds int\nLOOKUP_TABLE default\n3 4\n",
    ));
    assert_eq!(
        objects(&loaded),
        [("MaterialIds 3", 4), ("MaterialIds 4", 4)]
    );
}

#[test]
fn errors_of_legacy_files_say_where() {
    let text = legacy(&[(5, &[0, 2, 1])], "");
    let changed = |from: &str, to: &str| text.replace(from, to);
    check_error(
        &changed("ASCII", "TEXT"),
        "a.vtk:3:1: found \"TEXT\", expected ASCII or BINARY on the third line",
    );
    check_error(
        &changed("UNSTRUCTURED_GRID", "STRUCTURED_GRID"),
        "a.vtk:4:9: found a data set of the kind STRUCTURED_GRID, expected DATASET POLYDATA or DATASET \
         UNSTRUCTURED_GRID (in ParaView: the filter Extract Surface)",
    );
    check_error(
        &changed("double", "quad"),
        "a.vtk:5:10: found \"quad\", expected a type of numbers, as float",
    );
    check_error(
        &changed("1 1 1", "1 x 1"),
        "a.vtk:7:13: found \"x\", expected a number",
    );
    check_error(
        &changed("POINTS 8", "POINTS 9"),
        "a.vtk:8:1: found \"CELLS\", expected a number",
    );
    check_error(
        &changed("CELL_TYPES 1\n5", "CELL_TYPES 2\n5 5"),
        "a.vtk:11:1: found 2 types of cells, expected 1, as there are cells",
    );
    check_error(
        &changed("CELLS 1", "CELLS 2"),
        "a.vtk:9:1: found 1 cells, expected 2, as stated",
    );
    check_error(
        &changed("3 0 2 1", "4 0 2 1"),
        "a.vtk:9:1: found a cell of 4 points, with 3 integers left, expected no more than there are",
    );
    check_error(
        &changed("CELL_TYPES", "TYPES"),
        "a.vtk:10:1: found \"TYPES\", expected a keyword of legacy VTK files",
    );
    check_error(
        &changed("CELL_TYPES 1\n5\n", "CELL_TYPES 1\n"),
        "a.vtk:11:1: found the end of the file after 0 values, expected 1 values",
    );
    check_error(
        &changed("CELL_TYPES 1\n5\n", ""),
        "a.vtk:10:1: found the end of the file, expected CELL_TYPES, without which cells of an unstructured \
         grid are unknown",
    );
    check_error(
        &format!("{text}CELL_DATA 18446744073709551615\nVECTORS a double\n1"),
        "a.vtk:14:1: found more numbers than a file can have, expected fewer",
    );
    check_error(
        "# vtk DataFile Version 5.1\n\nASCII\nDATASET POLYDATA\nPOLYGONS 2 3\nOFFSETS int\n0 4\nCONNECTIVITY int\n0 1 2\n",
        "a.vtk:6:1: found a cell of the points 0 to 4, expected offsets up to 3 in ascending order",
    );
}

#[test]
fn fields_before_the_data_set_do_not_nest() {
    let many = "FIELD a 0\n".repeat(200_000);
    let text = legacy(&[(5, &[0, 2, 1])], "").replace("DATASET", &format!("{many}DATASET"));
    assert_eq!(objects(&load(&text)), [("surfaces", 1)]);
}

/// A file in XML with one piece for each list of tetrahedra, which have points of their own.
fn xml(pieces: &[(&str, &str)], kind: u8) -> String {
    let piece = |(points, cells): &(&str, &str)| {
        let size = if kind == 5 { 3 } else { 4 };
        let count = cells.split_whitespace().count() / size;
        let points_count = points.split_whitespace().count() / 3;
        let offsets: String = (1..=count).map(|k| format!("{} ", size * k)).collect();
        format!(
            "<Piece NumberOfPoints='{points_count}' NumberOfCells='{count}'>\n<Points>\
             <DataArray type='Float64' NumberOfComponents='3' format='ascii'>{points}</DataArray></Points>\n\
             <Cells><DataArray type='Int32' Name='connectivity'>{cells}</DataArray>\n\
             <DataArray type='Int32' Name='offsets'>{offsets}</DataArray>\n\
             <DataArray type='UInt8' Name='types'>{}</DataArray></Cells>\n</Piece>\n",
            format!("{kind} ").repeat(count)
        )
    };
    let pieces: String = pieces.iter().map(piece).collect();
    format!(
        "<?xml version='1.0'?>\n<VTKFile type='UnstructuredGrid' byte_order='LittleEndian'>\n\
         <UnstructuredGrid>\n{pieces}</UnstructuredGrid>\n</VTKFile>\n"
    )
}

#[test]
fn pieces_share_points_by_their_places() {
    let (one, other) = ("0 0 0  1 0 0  0 1 0  0 0 1", "1 0 0  0 1 0  -0 0 1  1 1 1");
    let loaded = load(&xml(&[(one, "0 1 2 3"), (other, "0 1 2 3")], 10));
    assert_eq!(objects(&loaded), [("piece 1", 3), ("piece 2", 3)]);
    // A corner of the cube, and half of what is left of it behind it.
    assert!((volume(&loaded) - 1.0 / 2.0).abs() < 1e-12);
    let loaded = load(&xml(&[(one, "0 1 2 0 1 3"), (other, "0 1 2")], 5));
    assert_eq!(objects(&loaded), [("piece 1", 2), ("piece 2", 1)]);
    assert_eq!(meshes(&loaded)[1].positions[2], DVec3::Z);
    check_warnings(&loaded, &[]);
    // A point that the piece lacks is not the next one's.
    let loaded = load(&xml(&[(one, "0 1 4 0 1 3"), (other, "0 1 2")], 5));
    assert_eq!(objects(&loaded), [("piece 1", 1), ("piece 2", 1)]);
}

#[test]
fn errors_of_xml_say_where() {
    let text = xml(&[("0 0 0 1 0 0 0 1 0", "0 1 2")], 5);
    assert_eq!(objects(&load(&text)), [("surfaces", 1)]);
    let changed = |from: &str, to: &str| text.replace(from, to);
    let arrays = "(in ParaView: the filter Extract Surface)";
    check_error(
        &changed("type='UnstructuredGrid'", "type='ImageData'"),
        &format!(
            "a.vtk:2:1: found a data set of the type \"ImageData\", expected UnstructuredGrid (.vtu) or PolyData (.vtp) {arrays}"
        ),
    );
    check_error(
        &changed("type='UnstructuredGrid'", "type='PPolyData'"),
        "a.vtk:2:1: found a data set of the type \"PPolyData\", expected UnstructuredGrid (.vtu) or PolyData \
         (.vtp): this file only lists such files, give one of these",
    );
    let zlib = "vtkZLibDataCompressor or none: save the file again with ZLib (ParaView: Compressor Type; VTK: \
                SetCompressorTypeToZLib; meshio: compression=\"zlib\")";
    // Text is never compressed.
    let lz4 = "compressor='vtkLZ4DataCompressor' byte_order=";
    let text_alone = load(&changed("byte_order=", lz4));
    assert_eq!(objects(&text_alone), [("surfaces", 1)]);
    check_error(
        &changed("byte_order=", lz4).replace("'ascii'", "'binary'"),
        &format!("a.vtk:2:1: found data compressed by vtkLZ4DataCompressor, expected {zlib}"),
    );
    check_error(
        &changed("byte_order=", "header_type='Int8' byte_order="),
        "a.vtk:2:1: found header_type \"Int8\", expected UInt32 or UInt64",
    );
    check_error(
        &changed("NumberOfPoints='3'", "NumberOfPoints='4'"),
        "a.vtk:5:9: found 9 coordinates, expected three for each of 4 points",
    );
    check_error(
        &changed(">0 1 2<", ">0 1 x<"),
        "a.vtk:6:56: found \"x\", expected a number",
    );
    check_error(
        &changed(">3 <", ">4 <"),
        "a.vtk:6:1: found a cell of the points 0 to 4, expected offsets up to 3 in ascending order",
    );
    check_error(
        &changed(">5 <", ">5 5<"),
        "a.vtk:6:1: found 2 types of cells, expected 1, as there are offsets",
    );
    check_error(
        &changed("format='ascii'", "format='appended' offset='0'"),
        "a.vtk:5:9: found an appended array, expected the element AppendedData",
    );
    check_error(
        &changed("format='ascii'", "format='text'"),
        "a.vtk:5:9: found the format \"text\", expected ascii, binary or appended",
    );
    check_error(
        &changed("format='ascii'", "format='binary'"),
        "a.vtk:5:9: found fewer bytes than an array states, or characters that are not base64, expected a complete file",
    );
    check_error(
        &changed("Float64", "Real"),
        "a.vtk:5:9: found the type \"Real\", expected a type of numbers, as Float64",
    );
    check_error(
        &changed("</Piece>", "</piece>"),
        "a.vtk:9:1: found malformed XML (expected 'Piece' tag, not 'piece'), expected well-formed XML",
    );
    check_error("<a/>", "a.vtk:1:1: found the element a, expected VTKFile");
}

/// Many arrays that share the same bytes must not fill memory.
#[test]
fn shared_bytes_are_limited() {
    let points = "<Piece NumberOfPoints='300'><Points><DataArray type='Float32' format='appended' offset='0'/>\
                  </Points></Piece>";
    let file = |pieces: usize| {
        let mut bytes = format!(
            "<VTKFile type='PolyData' byte_order='BigEndian'><PolyData>{}</PolyData>\
             <AppendedData encoding='raw'>\n _",
            points.repeat(pieces)
        )
        .into_bytes();
        bytes.extend(3600u32.to_be_bytes());
        bytes.extend([0; 3600]);
        bytes.extend(b"\n</AppendedData></VTKFile>");
        bytes
    };
    assert!(try_load(&file(4)).is_ok());
    let error = try_load(&file(5)).unwrap_err().to_string();
    assert!(
        error.contains("arrays that share their bytes more than 4 times"),
        "{error}"
    );
}

/// A few bytes may decompress to many.
#[test]
fn compressed_arrays_are_limited() {
    use flate2::{Compression, write::ZlibEncoder};
    use std::io::Write;
    let file = |count: usize| {
        let mut packer = ZlibEncoder::new(Vec::new(), Compression::best());
        packer.write_all(&vec![0; count]).unwrap();
        let packed = packer.finish().unwrap();
        let mut bytes = b"<VTKFile type='UnstructuredGrid' compressor='vtkZLibDataCompressor'>\
            <UnstructuredGrid><Piece><Cells><DataArray type='UInt8' Name='types' format='appended' \
            offset='0'/></Cells></Piece></UnstructuredGrid><AppendedData encoding='raw'>_"
            .to_vec();
        let sizes = [1, count as u32, 0, packed.len() as u32];
        bytes.extend(sizes.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(packed);
        bytes
    };
    let error = |count| try_load(&file(count)).unwrap_err().to_string();
    let few = error(1000);
    assert!(few.contains("1000 types of cells, expected 0"), "{few}");
    let many = error(100_000);
    assert!(
        many.contains("arrays that decompress to more bytes than allowed"),
        "{many}"
    );
}

/// Faces of a polyhedron that repeat the same points, of which there are many.
#[test]
fn large_polyhedra_take_no_quadratic_time() {
    let points: String = (0..200_000).map(|k| format!("{} ", k % 8)).collect();
    let cell = format!("3 200000 {points} 200000 {points} 3 0 1 4\n");
    let count = cell.split_whitespace().count();
    let text = legacy(&[(42, &[])], "");
    let text = text.replace(
        "CELLS 1 1\n0\n",
        &format!("CELLS 1 {}\n{count} {cell}", count + 1),
    );
    assert!(try_load(text.as_bytes()).is_ok());
    let thin = "3 0 1 2 ".repeat(200_000);
    let text = legacy(&[(42, &[])], "");
    let text = text.replace(
        "CELLS 1 1\n0\n",
        &format!("CELLS 1 800002\n800001 200000 {thin}\n"),
    );
    assert!(try_load(text.as_bytes()).is_ok());
}

#[test]
fn entities_are_refused() {
    let text = "<!DOCTYPE a [<!ENTITY b 'c'>]><VTKFile type='PolyData'/>";
    assert!(try_load(text.as_bytes()).is_err());
}

proptest! {
    #[test]
    fn any_words_are_harmless(text in "(CELLS|POINTS|CELL_TYPES|CELL_DATA|SCALARS|FIELD|int|float|string|[0-9 \n-]){0,60}") {
        let start = "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n";
        let _ = try_load([start, &text].concat().as_bytes());
        let binary = start.replace("ASCII", "BINARY");
        let _ = try_load([&binary, &*text].concat().as_bytes());
    }
}

/// VTK writes an active array of unsigned bytes or bools in text as shares of 255.
#[test]
fn groups_as_shares_of_one() {
    let file = |values: &str| {
        format!(
            "# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n\
             POLYGONS 4 9\nOFFSETS vtktypeint64\n0 3 6 9\nCONNECTIVITY vtktypeint64\n0 1 2 0 1 2 0 1 2\n\
             CELL_DATA 3\nCOLOR_SCALARS object 1\n{values}\n"
        )
    };
    let loaded = load(&file("0 0.00392157 0.996078"));
    assert_eq!(
        objects(&loaded),
        [("object 0", 1), ("object 1", 1), ("object 254", 1)]
    );
}
