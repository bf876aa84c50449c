//! Light in the text of a file.

use super::solids::{FIGURES, SOLIDS};
use super::*;
use crate::grf::{GrfText, LitText, NotLiteral};
use azulejo_scene::{BackIrradiance, Rgb, SurfaceGrid, SurfaceLight, VertexLight};
use glam::DVec3;

/// Gives every object of a scene some irradiance, `level` and more.
fn lit(mut scene: Scene, level: f64) -> Scene {
    for object in &mut scene.objects {
        match &mut object.shape {
            Shape::Mesh(mesh) => {
                let count = mesh.positions.len();
                mesh.irradiance = (0..count).map(|v| Rgb::grey(v as f64 + level)).collect();
                mesh.irradiance_error = vec![Rgb::grey(0.01); count];
            }
            Shape::Instance(instance) => {
                let count = instance.mesh.positions.len();
                instance.light = Some(Box::new(VertexLight {
                    irradiance: (0..count).map(|v| Rgb::grey(v as f64 + level)).collect(),
                    error: vec![Rgb::grey(0.01); count],
                    back: None,
                }));
            }
            Shape::Primitive(p) => {
                let grids = vec![SurfaceGrid { nu: 1, nv: 2 }; p.kind.parts()];
                p.light = Some(Box::new(SurfaceLight {
                    irradiance: vec![Rgb::grey(level); 6 * grids.len()],
                    grids,
                    error: Vec::new(),
                }));
            }
            Shape::Exact(exact) => {
                let materials: Vec<_> = exact.leaves().iter().map(|l| l.material()).collect();
                let mut skin = Mesh {
                    positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
                    irradiance: vec![Rgb::new(1.0, 2.0, level); 3],
                    ..Mesh::default()
                };
                for material in materials {
                    skin.push_face(&[0, 1, 2], material);
                }
                exact.proxy = Some(Box::new(skin));
            }
        }
    }
    scene
}

fn text_with(files: &Memory, text: impl AsRef<[u8]>) -> GrfText {
    GrfText::parse(text.as_ref().to_vec(), "test.grf", files).unwrap_or_else(|e| panic!("{e}"))
}

fn scene_with(files: &Memory, text: &[u8]) -> Scene {
    read(text, "test.grf", files)
        .unwrap_or_else(|e| panic!("{e}"))
        .scene
}

/// The text with light of this level.
fn written_in_place(files: &Memory, text: &[u8], level: f64) -> LitText {
    let solved = lit(scene_with(files, text), level);
    text_with(files, text)
        .lit(&solved, files)
        .unwrap_or_else(|e| panic!("{e}"))
}

/// The text without its light, as its blanks are.
fn without_light(text: &[u8]) -> String {
    let mut rest = String::from_utf8(text.to_vec()).unwrap();
    while let Some(start) = rest.find("irad (") {
        let end = start + rest[start..].find(')').unwrap() + 1;
        rest.replace_range(start..end + 1, "");
    }
    rest
}

#[test]
fn only_irad_is_added() {
    let files = Memory::new();
    let text = "// mine\r\nparams begin view (0,0,1) dependent  3 end params\r\next weather begin rain end ext\r\n\
        def  wall = rgb (.50, 5e-1, 0.5f) // paint\r\nbegin transform scale (1,1,1.0)\r\nbegin\r\n  begin mesh \
        USE color wall\tbegin vertexs\r\n (0 ,0,0)// first\r\n  normal (0,0,1) uv (0, 1)   (1.,0,0) (0,1,00)\r\n \
        end vertices begin faces 3 0 1 2 end end mesh\r\nend\r\nend def   ";
    let once = written_in_place(&files, text.as_bytes(), 0.5).bytes;
    assert_eq!(without_light(&once), text);
    let lit_text = String::from_utf8(once.clone()).unwrap();
    assert!(
        lit_text.contains(" irad (0.5, 0.5, 0.5) (0 ,0,0)// first"),
        "{lit_text}"
    );
    assert!(
        lit_text.contains("uv (0, 1)   irad (1.5, 1.5, 1.5) (1.,0,0) irad"),
        "{lit_text}"
    );
    // Solved again: other numbers in the same places.
    let again = written_in_place(&files, &once, 0.25).bytes;
    assert_eq!(without_light(&again), text);
    assert_eq!(written_in_place(&files, &again, 0.5).bytes, once);
    assert_eq!(
        mesh(&scene_with(&files, &again), 0).irradiance[1],
        Rgb::grey(1.25)
    );
}

#[test]
fn light_that_is_gone_leaves_the_text() {
    let files = Memory::new();
    let dark = text_with(&files, CUBE).lit(&lit(scene(CUBE), 1.0), &files);
    let mut none = scene(CUBE);
    match &mut none.objects[0].shape {
        Shape::Mesh(mesh) => mesh.irradiance.clear(),
        _ => panic!("a mesh"),
    }
    let bare = text_with(&files, dark.unwrap().bytes)
        .lit(&none, &files)
        .unwrap();
    assert_eq!(
        String::from_utf8(bare.bytes).unwrap(),
        without_light(CUBE.as_bytes())
    );
}

#[test]
fn everything_takes_its_light() {
    let files = Memory::new();
    let text = EVERYTHING.as_bytes();
    let result = written_in_place(&files, text, 3.0);
    let solved = lit(scene(EVERYTHING), 3.0);
    let mut again = scene_with(&files, &result.bytes);
    // Errors are replaced where there were some; the lamps' faces had none.
    let Shape::Mesh(lamp) = &mut again.objects[1].shape else {
        panic!("a mesh")
    };
    assert!(lamp.irradiance_error.is_empty());
    lamp.irradiance_error = vec![Rgb::grey(0.01); 3];
    assert_eq!(again, solved);
    assert_eq!((result.exact, result.backs), (2, 0));
    let lit_text = String::from_utf8(result.bytes).unwrap();
    for kept in [
        "rotation (0, 0, 90)",
        "end nothing end ext",
        "dependent 3",
        "def paper = texture",
    ] {
        assert!(lit_text.contains(kept), "{kept}: {lit_text}");
    }
}

#[test]
fn exact_shapes_get_skins_and_backs_an_extension() {
    let files = Memory::new();
    let text = format!("// Letters.\n{FIGURES}{SOLIDS}end def\n");
    let once = written_in_place(&files, text.as_bytes(), 1.0);
    assert!(once.exact > 0);
    let twice = written_in_place(&files, &once.bytes, 1.0);
    assert_eq!(twice.bytes.len(), once.bytes.len());
    // A comment beside a block stays there.
    let text = format!("{} // the floor\n;", triangle(""));
    let mut solved = lit(scene(&text), 1.0);
    if let Shape::Mesh(mesh) = &mut solved.objects[0].shape {
        mesh.back = Some(Box::new(BackIrradiance {
            irradiance: vec![Some(Rgb::grey(2.0)), None, None],
            error: Vec::new(),
        }));
    }
    let lit = text_with(&files, &text).lit(&solved, &files).unwrap();
    assert_eq!(lit.backs, 1);
    let lit_text = String::from_utf8(lit.bytes).unwrap();
    assert!(
        lit_text.contains("// the floor\next irad_back begin\nvertices = 0\n"),
        "{lit_text}"
    );
    assert!(lit_text.ends_with("end ext\n;"), "{lit_text}");
}

#[test]
fn each_use_of_a_part_gets_its_own_light() {
    let part = "// a chair\nbegin mesh use texture wood begin vertices (0,0,0) (1,0,0) (0,1,0) end \
        begin faces texture \"grain.png\" (0,1,2) end end // legs";
    let files = Memory::new()
        .with("parts/chair.grf", part)
        .with("colors.grf", "def wood = texture \"wood.png\"");
    let text = "include \"colors.grf\"\ntransform scale (2,2,2) begin include \"parts/chair.grf\" end\n\
        include  \"parts/chair.grf\" // the second\n";
    let result = written_in_place(&files, text.as_bytes(), 1.0);
    assert_eq!(
        result.unfolded.iter().collect::<Vec<_>>(),
        ["parts/chair.grf"]
    );
    let lit_text = String::from_utf8(result.bytes.clone()).unwrap();
    assert!(
        lit_text.starts_with("include \"colors.grf\"\ntransform"),
        "{lit_text}"
    );
    assert_eq!(lit_text.matches("// a chair").count(), 2);
    assert_eq!(lit_text.matches("texture \"parts/grain.png\"").count(), 2);
    assert!(lit_text.contains(" // the second\n"));
    let again = scene_with(&files, &result.bytes);
    assert_eq!(again.objects.len(), 2);
    assert_eq!(
        written_in_place(&files, &result.bytes, 1.0).bytes,
        result.bytes
    );
}

#[test]
fn parts_of_parts_are_unfolded_where_they_have_surfaces() {
    let files = Memory::new()
        .with(
            "parts/set.grf",
            "include \"chair.grf\" include \"more/colors.grf\"\ninclude \"chair.grf\"",
        )
        .with("parts/chair.grf", triangle("texture \"a.png\""))
        .with("parts/more/colors.grf", "def red = rgb (1, 0, 0)");
    let text = "include \"parts/set.grf\"";
    let result = written_in_place(&files, text.as_bytes(), 1.0);
    let names: Vec<&str> = result.unfolded.iter().map(String::as_str).collect();
    assert_eq!(names, ["parts/chair.grf", "parts/set.grf"]);
    let lit_text = String::from_utf8(result.bytes.clone()).unwrap();
    assert!(
        lit_text.contains("\ninclude \"parts/more/colors.grf\"\n")
            || lit_text.contains(" include \"parts/more/colors.grf\"\n"),
        "{lit_text}"
    );
    assert_eq!(lit_text.matches("texture \"parts/a.png\"").count(), 2);
    assert_eq!(scene_with(&files, &result.bytes).objects.len(), 2);
}

#[test]
fn the_encoding_is_kept() {
    let files = Memory::new();
    let text = format!("// silla de niño\n{}", triangle(""));
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let bytes = written_in_place(&files, &latin, 1.0).bytes;
    assert!(bytes.starts_with(b"// silla de ni\xf1o\n"));
    let wide: Vec<u8> = [0xff, 0xfe]
        .into_iter()
        .chain(text.encode_utf16().flat_map(u16::to_le_bytes))
        .collect();
    let bytes = written_in_place(&files, &wide, 1.0).bytes;
    assert!(bytes.starts_with(&wide[..20]) && bytes.len() > wide.len());
    let marked = format!("\u{feff}{text}");
    assert!(
        written_in_place(&files, marked.as_bytes(), 1.0)
            .bytes
            .starts_with(b"\xef\xbb\xbf//")
    );
    // Half of a pair, which no text could give back.
    let mut broken = wide.clone();
    broken[6..8].copy_from_slice(&[0x00, 0xd8]);
    let solved = lit(scene_with(&files, &broken), 1.0);
    let refused = text_with(&files, &broken).lit(&solved, &files);
    assert_eq!(refused, Err(NotLiteral::Encoding));
}

#[test]
fn another_scene_is_refused() {
    let files = Memory::new();
    let text = text_with(&files, CUBE);
    let mut other = scene(CUBE);
    other.objects.push(other.objects[0].clone());
    for other in [other, scene(&triangle("")), Scene::default()] {
        assert_eq!(text.lit(&other, &files), Err(NotLiteral::OtherScene));
    }
}

/// Vertices that are several in the text and one in the scene.
#[test]
fn copies_of_vertices_get_the_light_of_their_original() {
    let files = Memory::new();
    let text = "begin mesh begin vertices normal (0,0,1) (0,0,0) normal (0,0,1) (1,0,0) normal (0,0,1) (0,1,0) \
        normal (1,0,0) (0,0,0) end vertices begin faces (0,1,2) (3,2,1) end faces end mesh\n\
        ext shared begin vertices = 0 end ext";
    assert_eq!(mesh(&scene(text), 0).positions.len(), 3);
    let once = written_in_place(&files, text.as_bytes(), 5.0).bytes;
    assert_eq!(without_light(&once), text);
    assert_eq!(
        String::from_utf8(once)
            .unwrap()
            .matches("irad (5, 5, 5)")
            .count(),
        2
    );
}
