//! Tests of the format as a whole.

mod brdfs;
mod errors;
mod exact_shapes;
mod hostile;
mod instances;
mod literal;
mod plain;
mod round_trip;
mod rules;
mod solids;
mod tools;

use super::{GrfDocument, read, write};
use crate::{Loaded, Memory};
use azulejo_scene::{Mesh, Scene, Shape};

/// A cube in the style of the original paper: a header of comments, a list that opens as `vertexs`
/// and closes as `vertices`, faces with four corners. The numbers are our own.
const CUBE: &str = "\
// Wannabe Amazing 1.0, 21/11/2001
// Canvas: 640 x 480, background (0.0, 0.0, 0.0)
// Components: 1
// Cube, size 2.0
// Vertices: 8, faces: 6
// Bounding box: (-1.0, -1.0, -1.0) (1.0, 1.0, 1.0)
begin mesh
  begin vertexs
    irad (0.5, 0.5, 0.5) (-1.0, -1.0, -1.0)
    irad (0.5, 0.5, 0.5) ( 1.0, -1.0, -1.0)
    irad (0.5, 0.5, 0.5) ( 1.0,  1.0, -1.0)
    irad (0.5, 0.5, 0.5) (-1.0,  1.0, -1.0)
    irad (1.0, 0.75, 0.5) (-1.0, -1.0,  1.0)
    irad (1.0, 0.75, 0.5) ( 1.0, -1.0,  1.0)
    irad (1.0, 0.75, 0.5) ( 1.0,  1.0,  1.0)
    irad (1.0, 0.75, 0.5) (-1.0,  1.0,  1.0)
  end vertices
  begin faces
    rgb (1.0, 0.0, 0.0)
    (0, 3, 2, 1)
    (4, 5, 6, 7)
    rgb (0.0, 0.0, 1.0)
    (0, 1, 5, 4)
    (1, 2, 6, 5)
    (2, 3, 7, 6)
    (3, 0, 4, 7)
  end faces
end mesh
";

/// A file with every block and statement of the format.
const EVERYTHING: &str = r#"// A head.
params begin view (0, 0, 1) dependent 3 end params
ext units begin metres_per_unit = 0.01 photometric = true end ext
ext camera begin name = "front" eye = (0, -4, 1) target = (0, 0, 1) up = (0, 0, 1) fov = 45 size = 640 480 end ext
ext light begin name = "bulb" kind = point position = (0, 0, 2) intensity = (1, 2, 3) end ext
ext weather begin rain = "a \" b" end nothing end ext
def paper = texture "paper.png" def red = rgb (1, 0, 0)
def shiny = brdf phong n = 20 ks = 0.2 kd = (0.4, 0.5, 0.6) matt = brdf diffuse kd = 0.5
begin
  ext material begin of = matt name = "matt paint" emission = (0, 0, 1) end ext
  transform scale (2, 2, 2) rotation (0, 0, 90) translation (1, 0, 0) begin
    ext object begin name = "panel" end ext
    begin mesh use brdf shiny
      begin vertexs
        normal (0, 0, 1) irad (1, 2, 3) uv (0, 0) rgb (1, 1, 1) (0, 0, 0)
        normal (0, 0, 1) irad (1, 2, 3) uv (1, 0) use color red (1, 0, 0)
        normal (0, 0, 1) irad (1, 2, 3) uv (1, 1) rgb (1, 1, 1) (1, 1, 0)
      end vertices
      begin faces use texture paper texture "dirt.png" (0, 1, 2) use color red 3 2 1 0 end faces
    end mesh
    ext irad_error begin values = (0, 0, 0) (0.5, 0, 0) (0, 0, 0) end ext
    ext smoothing begin groups = 1 2 end ext
  end transform
  mesh light begin rgb (5, 5, 5)
    begin vertices (0, 0, 3) (1, 0, 3) (0, 1, 3) end vertices
    begin faces (0, 2, 1) end faces
  end light
  light begin rgb (9, 8, 7) (0, 0, 4) (0, 1, 0) (1, 0, 0) end light
  ext surface_light begin grids = 1 1 irradiance = (1, 1, 1) (2, 2, 2) (3, 3, 3) (4, 4, 4) end ext
  ext primitive begin kind = cone top = 0.5 map = 1 0 0 0 1 0 0 0 1 5 5 5 material = matt end ext
  ;
end def
"#;

fn scene(text: &str) -> Scene {
    loaded(text).scene
}

fn loaded(text: &str) -> Loaded {
    read(text.as_bytes(), "test.grf", &Memory::new()).unwrap_or_else(|e| panic!("{e}"))
}

fn warnings(text: &str) -> Vec<String> {
    let warnings = loaded(text).warnings;
    warnings.iter().map(ToString::to_string).collect()
}

fn mesh(scene: &Scene, object: usize) -> &Mesh {
    match &scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("object {object} is a primitive"),
    }
}

/// A mesh with one triangle, with `before_face` before its face.
fn triangle(before_face: &str) -> String {
    format!(
        "begin mesh begin vertices (0,0,0) (1,0,0) (0,1,0) end vertices \
         begin faces {before_face} (0, 1, 2) end faces end mesh"
    )
}

fn written(scene: &Scene) -> String {
    let mut out = Vec::new();
    write(scene, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn document(text: &str) -> GrfDocument {
    GrfDocument::parse(text.as_bytes(), "test.grf", &Memory::new())
        .unwrap_or_else(|e| panic!("{e}"))
        .0
}

fn document_text(document: &GrfDocument) -> String {
    let mut out = Vec::new();
    document.write(&mut out).unwrap();
    String::from_utf8(out).unwrap()
}
