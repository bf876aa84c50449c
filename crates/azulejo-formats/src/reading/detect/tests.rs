use super::marks::LOOKED_AT;
use super::*;
use flate2::write::GzEncoder;
use std::io::Write;

fn check(bytes: &[u8], expected: Result<Format, &str>) {
    let format = detect(bytes).map_err(|e| e.looks_like);
    assert_eq!(format, expected, "{}", bytes.escape_ascii());
}

#[test]
fn models() {
    check(b"# a comment\r\n\r\n  v 1 2 3", Ok(Format::Obj));
    check(b"\xef\xbb\xbfmtllib a.mtl\n", Ok(Format::Obj));
    check(b"o db\r\0\0v 1 2 3", Ok(Format::Obj));
    check(b"\xfe\xff\0o\0 \x001\0\n", Ok(Format::Obj));
    check(b"what is this\nf 1 2 3", Ok(Format::Obj));
    check(b"Begin Mesh\n", Ok(Format::Grf));
    check(b"// Wannabe Amazing\n", Ok(Format::Grf));
    check(b"def a = rgb (1,1,1)", Ok(Format::Grf));
    check(b"include\"a.grf\"", Ok(Format::Grf));
    check(b"light begin", Ok(Format::Grf));
    check(b"MM\x06\0\0\0", Ok(Format::Studio3ds));
    check(b"MM\xff\0\0\0\x02\0", Ok(Format::Studio3ds));
    check(b"\0\x01\x01\x44TheHeader", Ok(Format::OpenFlight));
    check(b"ply\nformat ascii 1.0", Ok(Format::Ply));
    check(b"solid cube\nfacet", Ok(Format::Stl));
    check(&[b' '; 84].map(|_| 0), Ok(Format::Stl));
    check(b"{ \"asset\": {} }", Ok(Format::Gltf));
    check(b"{\"asset\":{}}", Ok(Format::Gltf));
    check(b"glTF\x02\0\0\0", Ok(Format::Gltf));
    check(b"#VRML V2.0 utf8", Ok(Format::Vrml));
    check(
        b"<?xml version='1.0'?>\n<X3D profile='Full'>",
        Ok(Format::Vrml),
    );
    check(b"  0\nSECTION\n", Ok(Format::Dxf));
    check(b"999\nv 1 2 3\n0\nSECTION\n", Ok(Format::Dxf));
    check(b"AutoCAD Binary DXF\r\n\x1a\0", Ok(Format::Dxf));
    check(b"# a room\nm white =\n", Ok(Format::Mgf));
    check(b"o room\nv a =\n\tp 1 2 3\n", Ok(Format::Mgf));
    check(b"o cube\no cube\n", Ok(Format::Obj));
    check(
        b"view\n1 1 5 - eye\n0 0 0\n0 1 0\n30 30\nlight\n0 0 0\n1 1 1\nlights\n",
        Ok(Format::Sff),
    );
    check(
        b"% a scene\nlight point 4 3 1\nsphere 0 0 0 1",
        Ok(Format::Scn),
    );
    check(b"eye 5 2 2\n", Ok(Format::Scn));
    check(b"background light_sky_blue\n", Ok(Format::Scn));
    check(b"csg subtraction begin\n", Ok(Format::Scn));
}

#[test]
fn meshes_for_computations() {
    check(b"$MeshFormat\n4.1 1 8\n\x01\0\0\0", Ok(Format::Gmsh));
    check(
        b"$Comments\nby me\n$EndComments\n$MeshFormat\n2.2 0 8\n",
        Ok(Format::Gmsh),
    );
    check(b"$NOD\n4\n", Ok(Format::Gmsh));
    check(
        b"$ a comment of Nastran\nGRID,1\n",
        Err("text in no known format"),
    );
    check(b"OFF\n8 6 0\n", Ok(Format::Off));
    check(b"# by hand\nOFF 8 6 0\n", Ok(Format::Off));
    for word in [
        "COFF",
        "NOFF",
        "STOFF",
        "STCNOFF",
        "4OFF",
        "nOFF",
        "OFF BINARY",
        "OFF # a cube",
    ] {
        check(format!("{word}\n8 6 0\n").as_bytes(), Ok(Format::Off));
    }
    check(b"OFF we go\n", Err("text in no known format"));
    check(b"SCOFF\n", Err("text in no known format"));
    assert_eq!(recognize(b"8 6 0\n0 0 0\n", "a.off"), Ok(Format::Off));
    check(
        b"# vtk DataFile Version 3.0\nv 1 2 3\nBINARY\n",
        Ok(Format::Vtk),
    );
    check(
        b"<?xml version='1.0'?>\n<VTKFile type='PolyData'>",
        Ok(Format::Vtk),
    );
    check(b"<VTKFile><X3D>", Ok(Format::Vtk));
}

#[test]
fn words_decide_only_where_they_are_statements() {
    // Numbers that are not finite are for the reader to refuse.
    for number in ["nan", "-NaN", "inf", "+Infinity", ".5", "-1"] {
        let line = format!("v {number} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        check(line.as_bytes(), Ok(Format::Obj));
    }
    check(b"v nano =\n p 1 2 3", Ok(Format::Mgf));
    check(b"v info\nm dark\n", Ok(Format::Mgf));
    check(b"i \"a b.mgf\"\n", Err("text in no known format"));
    check(b"i lamp.mgf -t 0 0 1 -a 3 -rz 5", Ok(Format::Mgf));
    check(b"ies lamp.ies -m 2", Ok(Format::Mgf));
    check(b"rd .5\n", Ok(Format::Mgf));
    check(b"I am a letter.\n", Err("text in no known format"));
    check(b"c'est la vie\n", Err("text in no known format"));
    // Nastran, in which a deck of cards begins like a mesh.
    let deck = b"$ a deck\nSOL 101\nCEND\nBEGIN BULK\nGRID,1,,0.,0.,0.\nENDDATA\n";
    check(deck, Ok(Format::Nastran));
    check(b"INCLUDE 'a.bdf'\nGRID,1\n", Err("text in no known format"));
    check(b"begin\n// a comment\nmesh\n", Ok(Format::Grf));
    check(b"begin // one\n", Ok(Format::Grf));
    check(b"begin reading here\n", Err("text in no known format"));
    check(b"light (0,0,0) (1,0,0) (0,1,0) end light", Ok(Format::Grf));
    check(b"light reading\n", Err("text in no known format"));
    check(b"transform\nscale (1,1,1)", Ok(Format::Grf));
}

#[test]
fn json_is_told_by_its_names() {
    check(
        b"{\"type\": \"CityJSON\", \"CityObjects\": {\"asset\": 1}}",
        Ok(Format::CityJson),
    );
    check(
        b"{\"type\": \"FeatureCollection\", \"features\": []}",
        Err("JSON that is not glTF, CityJSON or epJSON"),
    );
    check(
        b"{\"a\": [{\"asset\": 1}], \"\\\"asset\": 2}",
        Err("JSON that is not glTF, CityJSON or epJSON"),
    );
    check(
        b"{\"extras\": {\"CityObjects\": []},\n\"asset\"\n: {}}",
        Ok(Format::Gltf),
    );
    check(b"{\"scenes\": [", Ok(Format::Gltf));
    check(
        b"{\"asset",
        Err("JSON that is not glTF, CityJSON or epJSON"),
    );
}

/// Comments at the start, of every format that has them.
#[test]
fn comments_may_be_of_any_length() {
    let long = |start: &str, end: &str| {
        let line = format!("{start} v of a long comment {end}\n");
        line.repeat(3 * LOOKED_AT / line.len())
    };
    for (comment, model, format) in [
        (long("#", ""), "v 1 2 3\n", Format::Obj),
        (long("#", ""), "v a =\n p 1 2 3\n", Format::Mgf),
        (long("//", ""), "begin mesh\n", Format::Grf),
        (long("999\n", ""), "0\nSECTION\n", Format::Dxf),
        (long("!", ""), "F 3\nV 1 0 0 0\n", Format::View3d),
        (long("%", ""), "sphere 0 0 0 1\n", Format::Scn),
        (long("<!--", "-->"), "<X3D>", Format::Vrml),
        (long("<!--", "-->"), "<VTKFile>", Format::Vtk),
        (long("#", ""), "OFF\n", Format::Off),
        ("\n".repeat(2 * LOOKED_AT), "v 1 2 3\n", Format::Obj),
    ] {
        let text = comment + model;
        check(text.as_bytes(), Ok(format));
        let mut packer = GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packer.write_all(text.as_bytes()).unwrap();
        check(&packer.finish().unwrap(), Ok(format));
    }
}

#[test]
fn white_space_is_a_scene_without_blocks() {
    assert_eq!(recognize(b"\n", "a.grf"), Ok(Format::Grf));
    let prose = b"# About\n\no and xf are words here.\n";
    assert!(recognize(prose, "a.mgf").is_ok());
    let refused = recognize(prose, "README.md").unwrap_err();
    assert_eq!(refused.looks_like, "a text document");
    assert!(recognize(b"", "a.grf").is_err() && recognize(b"\n", "a.obj").is_err());
}

#[test]
fn other_formats_are_named() {
    check(b"MM\0*\0\0\0\x08", Err("a TIFF picture"));
    check(
        b"; FBX 7.3.0 project file\n",
        Err("an FBX model; export it as glTF"),
    );
    check(b"ISO-10303-21;\nHEADER;\n", Err("a STEP or IFC model"));
    check(b"", Err("an empty file"));
    check(b" \n\t\n", Err("only white space"));
    check(b"\x89PNG\r\n\x1a\n", Err("a PNG picture"));
    check(b"\x1f\x8b\x08", Err("an empty file"));
    check(
        b"MM\x07\0\0\0\x01\x01",
        Err("binary data in no known format"),
    );
    check(
        b"<?xml version='1.0'?>\n<COLLADA/>",
        Err("XML that is neither X3D nor VTK"),
    );
    check(
        b"newmtl a\nKd 1 1 1",
        Err("a material library (MTL); give the OBJ that names it"),
    );
    check(b"Dear diary", Err("text in no known format"));
    check(b"\x02\x00\x03", Err("binary data in no known format"));
}

#[test]
fn input_of_solvers() {
    for line in [
        "GRID,1,,0.,0.,0.",
        "grid,1,,",
        "GRID           1       0-1.23456-1.23456-1.23456",
        "GRID*                  1                             0.0             0.0",
        "CQUAD4\t1\t1\t1\t2\t3\t4",
        "PSHELL         1       1      .1",
        "begin bulk",
        "$ grid of a room\nSOL 101\nCEND\nTITLE = o db\n  SPC = 1\nCTRIA3,1,1,1,2,3",
    ] {
        check(line.as_bytes(), Ok(Format::Nastran));
    }
    for line in [
        "Grid 5 is wide",
        "GRID",
        "grid 1 2 3",
        "GRID,1",
        "GRIDS,1,2,3",
        "begin the bulk",
    ] {
        check(line.as_bytes(), Err("text in no known format"));
    }
    for text in ["INCLUDE mesh.bdf\n", "SOL 101\nINCLUDE 'a.bdf'\n"] {
        assert_eq!(recognize(text.as_bytes(), "a.BDF.gz"), Ok(Format::Nastran));
    }
    for text in [
        "*HEADING\nv 1 2 3\n",
        "** made by hand\n\n*Node, nset=a\n1,0,0,0\n",
        "  *physical constants, absolute zero=0\n",
    ] {
        check(text.as_bytes(), Ok(Format::Abaqus));
    }
    check(b"*KEYWORD\n*NODE\n", Err("text in no known format"));
    check(b"* a list\n*NODE\n", Err("text in no known format"));
    let banner = "/*---- C++ ----*\\\n| v 1 2 3 //\n\\*----*/\n";
    for text in [
        "FoamFile\n{\n version 2.0;\n}\n// * * //\n",
        &[banner, "// more\nFoamFile {"].concat(),
    ] {
        check(text.as_bytes(), Ok(Format::OpenFoam));
    }
    check(banner.as_bytes(), Err("text in no known format"));
    assert_eq!(recognize(b"", "case/case.foam"), Ok(Format::OpenFoam));
    assert!(recognize(b"", "case.bdf").is_err());
}

#[test]
fn input_of_energyplus() {
    check(b"Version,25.1;\nZone, Z;", Ok(Format::EnergyPlus));
    check(
        b"! a comment, and more;\n\n  VERSION,\n  9.2; ! Version\n  Timestep, 4;\nOutput:Variable, *,\n x, y;\nbuildingsurface:detailed,",
        Ok(Format::EnergyPlus),
    );
    check(b"{\"Wall:Exterior\": {}}", Ok(Format::EnergyPlus));
    check(b"{\"globalgeometryrules\": {}}", Ok(Format::EnergyPlus));
    // Everyday words in other JSON.
    let other = "JSON that is not glTF, CityJSON or epJSON";
    check(b"{\"Zone\": 1, \"Building\": 2}", Err(other));
    // Lists and sentences.
    check(b"name, area\nZone, 3\n", Err("text in no known format"));
    check(
        b"Dear reader, this\nZone, is;",
        Err("text in no known format"),
    );
    check(
        b"Version,25.1;\nSchedule, x;",
        Err("text in no known format"),
    );
    let by_name = recognize(b"Version,25.1;\nSchedule, x;", "a.IDF");
    assert_eq!(by_name, Ok(Format::EnergyPlus));
}
