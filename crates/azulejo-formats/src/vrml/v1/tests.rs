//! Tests of VRML 1.0.

use crate::surface::phong::{Angle, Highlight};
use crate::vrml::read;
use crate::{Files, Loaded, Lod, Memory, ReadOptions};
use azulejo_scene::{LightKind, Material, Mesh, Object, Opacity, Rgb, Shape};
use glam::{DVec2, DVec3};
use proptest::prelude::*;

fn read_with(body: &str, files: &dyn Files, options: &ReadOptions) -> Loaded {
    let text = format!("#VRML V1.0 ascii\n{body}");
    let loaded = read(text.as_bytes(), "a.wrl", files, options).unwrap();
    loaded.scene.validate().unwrap();
    loaded
}

fn loaded(body: &str) -> Loaded {
    read_with(body, &Memory::new(), &ReadOptions::default())
}

/// Name, kind and box of an object.
fn summary(object: &Object) -> String {
    let kind = match &object.shape {
        Shape::Mesh(mesh) => format!("{} faces", mesh.faces.len()),
        Shape::Primitive(p) => format!("{:?}", p.kind),
        Shape::Exact(_) | Shape::Instance(_) => "exact or shared".to_owned(),
    };
    let bounds = object.bounds();
    let point = |p: DVec3| {
        // Adding zero turns -0 into 0.
        let [x, y, z] = p.to_array().map(|x| (x * 100.0).round() / 100.0 + 0.0);
        format!("{x} {y} {z}")
    };
    let (min, max) = (point(bounds.min), point(bounds.max));
    format!("{}: {kind} from {min} to {max}", object.name)
}

/// Checks the objects of some nodes, without warnings.
fn check(body: &str, expected: &[&str]) {
    let loaded = loaded(body);
    let objects: Vec<String> = loaded.scene.objects.iter().map(summary).collect();
    assert_eq!(objects, expected, "{body}");
    assert_eq!(loaded.warnings, [], "{body}");
}

/// Checks that some warning of these nodes contains a text, with its count.
fn check_warning(body: &str, expected: &str, count: usize) {
    let warnings = loaded(body).warnings;
    let warning = warnings.iter().find(|w| w.message.contains(expected));
    assert_eq!(
        warning.map(|w| w.count),
        Some(count),
        "{body}: {warnings:?}"
    );
}

fn mesh(loaded: &Loaded, object: usize) -> &Mesh {
    match &loaded.scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?} is not a mesh"),
    }
}

/// The material of a face or a solid.
fn material(loaded: &Loaded, object: usize, face: usize) -> &Material {
    let id = match &loaded.scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh.face_materials[face],
        Shape::Primitive(p) => p.material,
        Shape::Exact(_) | Shape::Instance(_) => {
            unreachable!("VRML has primitives and meshes only")
        }
    };
    &loaded.scene.materials[id as usize]
}

/// Two squares in the plane z = 0, side by side.
const SQUARES: &str = "Coordinate3 { point [ 0 0 0, 1 0 0, 2 0 0, 0 1 0, 1 1 0, 2 1 0 ] }
    DEF squares IndexedFaceSet { coordIndex [ 0, 1, 4, 3, -1, 1, 2, 5, 4, -1 ] } ";

#[test]
fn solids_are_exact() {
    check(
        "DEF a Group { DEF b Cube { width 4 } Sphere {} }",
        &[
            "a/b: Cuboid from -2 -1 -1 to 2 1 1",
            "a: Sphere from -1 -1 -1 to 1 1 1",
        ],
    );
    check(
        "Cylinder { radius 2 height 6 parts ALL } Cone { bottomRadius 2 parts (SIDES | BOTTOM) }",
        &[
            ": Cylinder from -2 -3 -2 to 2 3 2",
            ": Cone { top: 0.0 } from -2 -1 -2 to 2 1 2",
        ],
    );
    // Negative lengths are taken as positive.
    check(
        "Cube { depth -3 }",
        &[": Cuboid from -1 -1 -1.5 to 1 1 1.5"],
    );
}

#[test]
fn open_and_flat_solids_are_polygons() {
    let loaded = loaded(
        "Material { emissiveColor 1 1 1 } Cylinder { parts SIDES } Cylinder { parts (TOP|BOTTOM) }
         Cone { parts BOTTOM } Cube { width 0 } Sphere {}",
    );
    let tube = mesh(&loaded, 0);
    let area = 4.0 * std::f64::consts::PI;
    assert!((tube.area() / area - 1.0).abs() < 0.01, "{}", tube.area());
    assert!(tube.normals.is_some() && tube.uvs.is_none());
    for face in 0..tube.faces.len() {
        let out = tube.face_positions(face)[0] * DVec3::new(1.0, 0.0, 1.0);
        assert!(tube.face_area_vector(face).dot(out) > 0.0);
    }
    let ends = mesh(&loaded, 1);
    assert_eq!((ends.bounds().min.y, ends.bounds().max.y), (-1.0, 1.0));
    assert!((ends.area() / (0.5 * area) - 1.0).abs() < 0.01);
    assert!((0..ends.faces.len()).all(|f| {
        let y = ends.face_positions(f)[0].y;
        ends.face_area_vector(f).y * y > 0.0
    }));
    assert_eq!(mesh(&loaded, 2).bounds().max.y, -1.0);
    assert_eq!(mesh(&loaded, 3).faces.len(), 6);
    // Open shapes are visible from both sides and emit from both.
    assert!(material(&loaded, 0, 0).emits_back && !material(&loaded, 4, 0).emits_back);
}

#[test]
fn parts_of_solids_have_materials() {
    let loaded = loaded(
        "Material { diffuseColor [ 1 0 0, 0 1 0, 0 0 1, 1 1 0, 1 0 1, 0 1 1 ] }
         MaterialBinding { value PER_PART } Cube {} Cylinder {} Sphere {}
         MaterialBinding { value PER_FACE } Cube {}",
    );
    let color_toward = |object: usize, direction: DVec3| {
        let mesh = mesh(&loaded, object);
        let faces = 0..mesh.faces.len();
        let face = faces.max_by(|&a, &b| {
            let along = |f| mesh.face_area_vector(f).normalize().dot(direction);
            along(a).total_cmp(&along(b))
        });
        material(&loaded, object, face.unwrap()).diffuse.to_array()
    };
    assert_eq!(color_toward(0, DVec3::Z), [1.0, 0.0, 0.0]);
    assert_eq!(color_toward(0, -DVec3::Z), [0.0, 1.0, 0.0]);
    assert_eq!(color_toward(0, -DVec3::X), [0.0, 0.0, 1.0]);
    assert_eq!(color_toward(0, DVec3::X), [1.0, 1.0, 0.0]);
    assert_eq!(color_toward(0, DVec3::Y), [1.0, 0.0, 1.0]);
    assert_eq!(color_toward(0, -DVec3::Y), [0.0, 1.0, 1.0]);
    assert_eq!(color_toward(1, DVec3::X), [1.0, 0.0, 0.0]);
    assert_eq!(color_toward(1, DVec3::Y), [0.0, 1.0, 0.0]);
    assert_eq!(color_toward(1, -DVec3::Y), [0.0, 0.0, 1.0]);
    for object in [2, 3] {
        assert_eq!(
            material(&loaded, object, 0).diffuse.to_array(),
            [1.0, 0.0, 0.0]
        );
    }
}

#[test]
fn groups_keep_what_they_should() {
    let moved = "Translation { translation 5 0 0 }";
    let at = |x: i32| format!(": Cuboid from {} -1 -1 to {} 1 1", x - 1, x + 1);
    let check = |body: &str, x: i32| check(body, &[&at(x)]);
    check(&format!("Separator {{ {moved} }} Cube {{}}"), 0);
    check(&format!("TransformSeparator {{ {moved} }} Cube {{}}"), 0);
    check(&format!("WWWAnchor {{ name \"x\" {moved} }} Cube {{}}"), 0);
    check(&format!("Group {{ {moved} }} Cube {{}}"), 5);
    check(&format!("Switch {{ whichChild 0 {moved} }} Cube {{}}"), 5);
    check(&format!("LOD {{ {moved} }} {moved} Cube {{}}"), 10);
    let loaded = loaded(
        "TransformSeparator { Material { diffuseColor 1 0 0 } } Cube {}
         Separator { Material { diffuseColor 0 1 0 } } Cube {}",
    );
    for object in [0, 1] {
        assert_eq!(
            material(&loaded, object, 0).diffuse,
            Rgb::new(1.0, 0.0, 0.0)
        );
    }
}

#[test]
fn switches() {
    let body = |which: &str| format!("Switch {{ {which} Cube {{}} Sphere {{}} }}");
    let cube = ": Cuboid from -1 -1 -1 to 1 1 1";
    let sphere = ": Sphere from -1 -1 -1 to 1 1 1";
    check(&body("whichChild 0"), &[cube]);
    check(&body("whichChild 1"), &[sphere]);
    check(&body("whichChild -3"), &[cube, sphere]);
    check_warning(&body(""), "no child selected", 1);
    check_warning(&body("whichChild 2"), "no child selected", 1);
    let cameras = "DEF Cameras Switch { PerspectiveCamera {} DEF b PerspectiveCamera {} } Cube {}";
    assert_eq!(loaded(cameras).scene.cameras[1].name, "Cameras/b");
}

#[test]
fn levels_of_detail() {
    let body = "LOD { range [ 10, 20 ] Cube {} Sphere {} Info {} }";
    let check = |lod, expected: &[&str]| {
        let options = ReadOptions {
            lod,
            ..ReadOptions::default()
        };
        let loaded = read_with(body, &Memory::new(), &options);
        let kinds = loaded.scene.objects.iter().map(|o| match &o.shape {
            Shape::Primitive(p) => format!("{:?}", p.kind),
            Shape::Exact(_) | Shape::Instance(_) => "exact or shared".to_owned(),
            Shape::Mesh(_) => "mesh".to_owned(),
        });
        assert_eq!(kinds.collect::<Vec<_>>(), expected, "{lod:?}");
    };
    check(Lod::Finest, &["Cuboid"]);
    check(Lod::Coarsest, &["Sphere"]);
    check(Lod::All, &["Cuboid", "Sphere"]);
    check(Lod::Distance(9.0), &["Cuboid"]);
    check(Lod::Distance(10.0), &["Sphere"]);
    check(Lod::Distance(99.0), &[]);
}

#[test]
fn transformations() {
    let quarter = std::f64::consts::FRAC_PI_2;
    check(
        &format!("Rotation {{ rotation 0 0 2 {quarter} }} Cube {{ width 6 }}"),
        &[": Cuboid from -1 -3 -1 to 1 3 1"],
    );
    check(
        "Scale { scaleFactor 2 3 -4 } Translation { translation 1 1 1 } Cube {}",
        &[": Cuboid from 0 0 -8 to 4 6 0"],
    );
    // The last row of a matrix is the translation, and rows apply to the coordinates.
    check(
        "MatrixTransform { matrix 1 0.5 0 0  0 1 0 0  0 0 1 0  3 0 0 1 } Cube {}",
        &[": Cuboid from 2 -1.5 -1 to 4 1.5 1"],
    );
    check(
        &format!(
            "Transform {{ translation 10 0 0 center 1 0 0 scaleFactor 2 1 1
             rotation 0 0 1 {quarter} scaleOrientation 0 0 1 {quarter} }} Cube {{}}"
        ),
        &[": Cuboid from 9 -2 -1 to 13 0 1"],
    );
}

/// Inventor 2.1 puts the vertices of a shape into the shape.
#[test]
fn vertices_of_a_shape_itself() {
    let own = "vertexProperty DEF p VertexProperty { vertex [ 0 0 0, 2 0 0, 2 2 0 ] \
               normal [ 0 0 1, 0 1 0, 1 0 0 ] texCoord [ 0 0, 1 0, 1 1 ] normalBinding PER_VERTEX_INDEXED \
               materialBinding OVERALL }";
    let around = "Coordinate3 { point [ 0 0 5, 1 0 5, 1 1 5 ] }";
    let body = format!(
        "{around} IndexedFaceSet {{ {own} coordIndex [ 0 1 2 -1 ] }} IndexedFaceSet {{ coordIndex [ 0 1 2 -1 ] }} \
         IndexedFaceSet {{ vertexProperty USE p coordIndex [ 2 1 0 -1 ] }}"
    );
    let own = ": 1 faces from 0 0 0 to 2 2 0";
    check(&body, &[own, ": 1 faces from 0 0 5 to 1 1 5", own]);
    let normals = mesh(&loaded(&body), 0).normals.clone().expect("its own");
    assert_eq!(normals.values[1], DVec3::Y);
    // What is not read is named.
    let colored = "IndexedFaceSet { vertexProperty VertexProperty { vertex [ 0 0 0, 2 0 0, 2 2 0 ] orderedRGBA 0xff0000ff } \
                   coordIndex [ 0 1 2 -1 ] }";
    check_warning(colored, "VertexProperty.orderedRGBA is ignored", 1);
}

#[test]
fn face_sets() {
    check(SQUARES, &["squares: 2 faces from 0 0 0 to 2 1 0"]);
    let body = "ShapeHints { vertexOrdering CLOCKWISE shapeType SOLID }".to_owned() + SQUARES;
    let turned = loaded(&body);
    assert_eq!(mesh(&turned, 0).face_area_vector(0), -DVec3::Z);
    assert!(!material(&turned, 0, 0).emits_back);
    check_warning("IndexedFaceSet { coordIndex [ 0 1 2 ] }", "out of range", 1);
    check_warning(
        "IndexedFaceSet { coordIndex [ 0 0 ] }",
        "fewer than three",
        1,
    );
    check_warning("IndexedFaceSet {}", "without faces", 1);
    check_warning("IndexedFaceSet {}", "no geometry", 1);
    let far = "Scale { scaleFactor 1e300 1e300 1e300 } Scale { scaleFactor 1e300 1 1 }".to_owned();
    check_warning(&(far.clone() + SQUARES), "overflowing transformation", 1);
    check_warning(&(far + "Sphere {}"), "overflowing transformation", 1);
}

#[test]
fn material_bindings() {
    let materials =
        "Material { diffuseColor [ 1 0 0, 0 1 0, 0 0 1 ] emissiveColor [ 0 0 0, 1 1 1 ] }";
    let check = |binding: &str, index: &str, expected: [usize; 2]| {
        let set = SQUARES.replace("-1 ] }", &format!("-1 ] {index} }}"));
        let loaded = loaded(&format!(
            "{materials} MaterialBinding {{ value {binding} }} {set}"
        ));
        let colors = [0, 1].map(|face| {
            let color = material(&loaded, 0, face).diffuse.to_array();
            color.iter().position(|c| *c == 1.0).unwrap()
        });
        assert_eq!(colors, expected, "{binding}");
        assert!(mesh(&loaded, 0).colors.is_empty());
        assert_eq!(loaded.warnings, []);
        assert_eq!(material(&loaded, 0, 1).is_emitter(), expected[1] > 0);
    };
    check("DEFAULT", "", [0, 0]);
    check("OVERALL", "", [0, 0]);
    check("PER_PART", "", [0, 1]);
    check("PER_FACE", "", [0, 1]);
    check("PER_PART_INDEXED", "materialIndex [ 2, 1 ]", [2, 1]);
    check("PER_FACE_INDEXED", "materialIndex [ 1, 2 ]", [1, 2]);
    check("PER_FACE_INDEXED", "materialIndex -1", [0, 1]);
}

#[test]
fn materials_of_vertices() {
    let materials = "Material { diffuseColor [ 1 0 0, 0 1 0, 0 0 1, 1 1 0, 1 0 1, 0 1 1 ] }";
    let body =
        |binding: &str| format!("{materials} MaterialBinding {{ value {binding} }} {SQUARES}");
    let indexed = loaded(&body("PER_VERTEX_INDEXED"));
    let mesh_of = |loaded| mesh(loaded, 0).clone();
    assert_eq!(mesh_of(&indexed).colors[5].to_array(), [0.0, 1.0, 1.0]);
    assert_eq!(mesh_of(&indexed).positions.len(), 6);
    assert_eq!(material(&indexed, 0, 0).diffuse, Rgb::WHITE);
    // In the order of the corners eight colours are needed, and shared points differ.
    let in_order = loaded(&body("PER_VERTEX"));
    assert_eq!(mesh_of(&in_order).positions.len(), 8);
    assert_eq!(in_order.warnings[0].count, 2);
    let more = body("PER_VERTEX_INDEXED").replace("} Mat", "transparency [ 0 0.5 ] } Mat");
    check_warning(&more, "in more than diffuseColor", 1);
    // Equal colours are merged.
    let same = body("PER_VERTEX_INDEXED")
        .replace("1 0 0, 0 1 0, 0 0 1, 1 1 0, 1 0 1, 0 1 1", "1 0 0, 1 0 0");
    let same = loaded(&same);
    assert!(mesh_of(&same).colors.is_empty());
    assert_eq!(material(&same, 0, 0).diffuse, Rgb::new(1.0, 0.0, 0.0));
}

#[test]
fn what_materials_mean() {
    let body = |fields: &str| format!("DEF m Material {{ {fields} }} Cube {{}}");
    let of = |fields: &str| material(&loaded(&body(fields)), 0, 0).clone();
    assert_eq!(material(&loaded("Cube {}"), 0, 0).diffuse, Rgb::grey(0.8));
    assert_eq!(of("").name, "m");
    assert_eq!(of("emissiveColor 1 2 3").emission, Rgb::new(1.0, 2.0, 3.0));
    assert_eq!(
        of("emissiveColor 1 2 3 diffuseColor []").diffuse,
        Rgb::BLACK
    );
    let mirror = of("diffuseColor 1 1 1 mirror 0.25");
    assert_eq!(
        (mirror.diffuse, mirror.mirror),
        (Rgb::grey(0.75), Rgb::grey(0.25))
    );
    let glossy = of("specularColor 0.5 0.5 0.5 shininess 0.5");
    let highlight = Highlight::of(&glossy).unwrap();
    assert_eq!((highlight.angle, highlight.n), (Angle::Half, 64.0));
    assert!((highlight.ks.r - 0.5).abs() < 1e-12);
    let bright = "specularColor 1 1 1 shininess 0";
    check_warning(&body(bright), "more light than it receives", 1);
    let see_through = of("transparency 0.75");
    assert_eq!(see_through.opacity, Some(Opacity::constant(0.25)));
    check_warning(&body("transparency 1"), "invisible", 1);
    check_warning(&body("reflSpecular 0 0 0"), "Material.reflSpecular", 1);
}

#[test]
fn normal_bindings() {
    let normals = "ShapeHints { creaseAngle 0 } Normal { vector [ 0 0 1, 1 0 0, 0 2 0, 0 0 1, 1 0 0, 0 1 0, 0 0 1, 1 0 0 ] }";
    let check = |binding: &str, index: &str, expected: [DVec3; 2]| {
        let set = SQUARES.replace("-1 ] }", &format!("-1 ] {index} }}"));
        let loaded = loaded(&format!(
            "{normals} NormalBinding {{ value {binding} }} {set}"
        ));
        let mesh = mesh(&loaded, 0);
        let normals = mesh.normals.as_ref().unwrap();
        // The corners at points 4 of the first and 5 of the second square.
        let actual = [2, 6].map(|corner| normals.at(corner, mesh.faces.corners[corner]));
        assert_eq!(actual, expected, "{binding}");
        assert_eq!(loaded.warnings, []);
    };
    check("DEFAULT", "", [DVec3::X, DVec3::Y]);
    check("OVERALL", "", [DVec3::Z, DVec3::Z]);
    check("PER_FACE", "", [DVec3::Z, DVec3::X]);
    check(
        "PER_FACE_INDEXED",
        "normalIndex [ 2, 0 ]",
        [DVec3::Y, DVec3::Z],
    );
    check("PER_VERTEX", "", [DVec3::Y, DVec3::Z]);
    check(
        "PER_VERTEX_INDEXED",
        "normalIndex [ 0 0 1 0 -1 0 0 2 0 ]",
        [DVec3::X, DVec3::Y],
    );
    let few = normals
        .replace("0 0 1, 1 0 0 ]", "]")
        .replace("0 1 0, ]", "]")
        + SQUARES;
    check_warning(&few, "too few normals", 1);
    assert_eq!(mesh(&loaded(&few), 0).normals, None);
}

#[test]
fn creases_are_smooth_by_default_in_vrml_alone() {
    let roof = "Coordinate3 { point [ 0 0 0, 1 0 0, 0 1 0, -1 0 -0.3 ] }
        IndexedFaceSet { coordIndex [ 0, 1, 2, -1, 0, 2, 3 ] }";
    let smooth = |header: &str, hints: &str| {
        let text = format!("{header}\n{hints} {roof}");
        let loaded = read(
            text.as_bytes(),
            "a",
            &Memory::new(),
            &ReadOptions::default(),
        )
        .unwrap();
        let normals = mesh(&loaded, 0).normals.clone();
        normals.is_some_and(|n| n.at(0, 0) == n.at(3, 0))
    };
    let (vrml, inventor) = ("#VRML V1.0 ascii", "#Inventor V2.1 ascii");
    assert!(smooth(vrml, "") && smooth(vrml, "ShapeHints {}"));
    assert!(!smooth(vrml, "ShapeHints { creaseAngle 0.2 }"));
    assert!(!smooth(inventor, "") && !smooth(inventor, "ShapeHints {}"));
    assert!(smooth(inventor, "ShapeHints { creaseAngle 0.5 }"));
}

#[test]
fn textures() {
    let picture = "Texture2 { image 1 2 3 0xff0000 0x0000ff }";
    let check = |body: &str, corner: usize, expected: DVec2| {
        let loaded = loaded(&format!("{picture} {body}"));
        assert_eq!(loaded.warnings, [], "{body}");
        let mesh = mesh(&loaded, 0);
        let uv = mesh
            .uvs
            .as_ref()
            .unwrap()
            .at(corner, mesh.faces.corners[corner]);
        assert!((uv - expected).length() < 1e-12, "{body}: {uv}");
        assert_eq!(material(&loaded, 0, 0).textures, [0]);
        let image = loaded.scene.textures[0].image.as_ref().unwrap();
        assert_eq!(image.pixel(0, 1), [1.0, 0.0, 0.0]);
    };
    check(SQUARES, 2, DVec2::new(0.5, 0.5));
    let points = "TextureCoordinate2 { point [ 0 0, 1 0, 0 1, 0 2, 0.5 0.25 ] }";
    let first = SQUARES.replace("-1, 1, 2, 5, 4, -1", "-1");
    check(&format!("{points} {first}"), 2, DVec2::new(0.5, 0.25));
    let indexed = first.replace("-1 ] }", "-1 ] textureCoordIndex [ 0 1 2 3 -1 ] }");
    check(&format!("{points} {indexed}"), 2, DVec2::new(0.0, 1.0));
    let turned = "Texture2Transform { scaleFactor 2 1 rotation 1.5707963267948966 center 1 0 translation 0 3 }";
    check(
        &format!("{points} {turned} {indexed}"),
        2,
        DVec2::new(0.0, 1.0),
    );
    // The front of a cube is upright, and so is the texture around a cylinder.
    let cube = loaded(&format!("{picture} Cube {{}}"));
    let mesh = mesh(&cube, 0);
    for (p, uv) in mesh
        .positions
        .iter()
        .zip(&mesh.uvs.as_ref().unwrap().values)
        .skip(20)
    {
        assert_eq!(*uv, 0.5 * (p.truncate() + 1.0));
    }
    let round = loaded(&format!("{picture} Cylinder {{}}"));
    let tube = self::mesh(&round, 0);
    let uvs = &tube.uvs.as_ref().unwrap().values;
    let left = tube.positions.iter().position(|p| p.x < -0.99).unwrap();
    assert!((uvs[left].x - 0.25).abs() < 0.02, "{}", uvs[left]);
}

#[test]
fn pictures_that_are_not_there() {
    check_warning("Texture2 { filename wood.png } Cube {}", "wood.png", 1);
    let wood = loaded("Texture2 { filename wood.png wrapS CLAMP } Cube {} Texture2 {} Sphere {}");
    assert_eq!(wood.scene.textures[0].path, "wood.png");
    assert_eq!(material(&wood, 0, 0).textures, [0]);
    assert!(material(&wood, 1, 0).textures.is_empty());
    check_warning(
        "Texture2 { image 2 2 3 0 } Cube {}",
        "fewer pixels than its size",
        1,
    );
    // One node is one texture, however often it is used.
    let body = "DEF t Texture2 { image 1 1 1 255 } Cube {} USE t Cube {}";
    assert_eq!(loaded(body).scene.textures.len(), 1);
}

#[test]
fn lights_and_cameras() {
    let loaded = loaded(
        "DEF sky Info { string \"no colour\" } DEF BackgroundColor Info { string \"0.1 0.2 0.3\" }
         Translation { translation 0 1 0 } Rotation { rotation 1 0 0 -1.5707963267948966 }
         DEF lamp PointLight { location 0 0 2 color 1 0.5 0 intensity 2 }
         SpotLight { cutOffAngle 0.5 } DirectionalLight { intensity 3 } PointLight { on FALSE }
         DEF view PerspectiveCamera { position 0 0 4 heightAngle 0.6 } OrthographicCamera {} Cube {}",
    );
    let scene = &loaded.scene;
    assert_eq!(scene.background, Some(Rgb::new(0.1, 0.2, 0.3).into()));
    assert_eq!(scene.units.metres_per_unit, Some(1.0));
    let near = |a: DVec3, b: DVec3| (a - b).length() < 1e-12;
    let [lamp, spot, sun] = scene.lights.as_slice() else {
        panic!("{:?}", scene.lights)
    };
    assert_eq!(lamp.name, "lamp");
    let LightKind::Point {
        position,
        intensity,
    } = lamp.kind
    else {
        panic!("{lamp:?}")
    };
    assert!(near(position, DVec3::new(0.0, 3.0, 0.0)));
    assert_eq!(intensity, Rgb::new(2.0, 1.0, 0.0));
    let LightKind::Spot {
        direction, outer, ..
    } = spot.kind
    else {
        panic!("{spot:?}")
    };
    assert!(near(direction, -DVec3::Y) && outer == 0.5);
    assert!(matches!(sun.kind, LightKind::Directional { irradiance, .. } if irradiance.r == 3.0));
    let camera = &scene.cameras[0];
    assert!(near(camera.eye, DVec3::new(0.0, 5.0, 0.0)) && near(camera.target, DVec3::ZERO));
    assert!(near(camera.up, -DVec3::Z) && camera.vertical_fov == 0.6 && camera.name == "view");
    let messages: Vec<&str> = loaded.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(
        messages,
        [
            "light with on FALSE: skipped",
            "OrthographicCamera is not supported: skipped"
        ]
    );
}

#[test]
fn nodes_are_used_again() {
    check(
        "DEF a Separator { Translation { translation 2 0 0 } DEF b Cube {} } USE a USE b",
        &[
            "a/b: Cuboid from 1 -1 -1 to 3 1 1",
            "a/b: Cuboid from 1 -1 -1 to 3 1 1",
            "b: Cuboid from -1 -1 -1 to 1 1 1",
        ],
    );
    // The latest definition before the use applies.
    check(
        "Switch { DEF c Info {} } DEF c Sphere {} USE c",
        &["c: Sphere from -1 -1 -1 to 1 1 1"; 2],
    );
    check_warning("Cube {} USE nobody", "USE nobody refers to no node", 1);
    check_warning(
        "DEF a Group { Cube {} USE a }",
        "USE a refers to the node that contains it",
        1,
    );
}

#[test]
fn files_inside_files() {
    let files = Memory::new()
        .with(
            "parts/b.wrl",
            "#VRML V1.0 ascii\nDEF box Cube {} WWWInline { name \"c.wrl\" }",
        )
        .with(
            "parts/c.wrl",
            "#VRML V1.0 ascii\nSphere {} WWWInline { name \"../a.wrl\" }",
        );
    let body = "Translation { translation 5 0 0 } Material { diffuseColor 1 0 0 }
        DEF b WWWInline { name \"parts/b.wrl\" bboxSize 1 1 1 } WWWInline { name \"\" } Cube {}
        WWWInline { name none.wrl }";
    let loaded = read_with(body, &files, &ReadOptions::default());
    let objects: Vec<String> = loaded.scene.objects.iter().map(summary).collect();
    let expected = [
        "b/box: Cuboid from 4 -1 -1 to 6 1 1",
        "b: Sphere from 4 -1 -1 to 6 1 1",
        ": Cuboid from 4 -1 -1 to 6 1 1",
    ];
    assert_eq!(objects, expected);
    assert_eq!(material(&loaded, 0, 0).diffuse, Rgb::grey(0.8));
    assert_eq!(loaded.warnings.len(), 2, "{:?}", loaded.warnings);
}

#[test]
fn unknown_nodes_and_fields() {
    let cube = [": Cuboid from -1 -1 -1 to 1 1 1"];
    let square = "MySquare { fields [ SFFloat side, MFString isA ] isA [ \"Their\", \"Cube\" ] side 3 width 6 }";
    let model = loaded(square);
    assert_eq!(
        summary(&model.scene.objects[0]),
        ": Cuboid from -3 -1 -1 to 3 1 1"
    );
    check_warning(square, "MySquare.side", 1);
    let check = |body: &str, warning: &str| {
        let model = loaded(body);
        let objects: Vec<String> = model.scene.objects.iter().map(summary).collect();
        assert_eq!(objects, cube, "{body}");
        assert!(
            model.warnings[0].message.contains(warning),
            "{body}: {:?}",
            model.warnings
        );
    };
    let inside = "unknown node Selection: its content is read as in a Separator";
    check(
        "Selection { policy SINGLE Translation { translation 5 0 0 } } Cube {}",
        inside,
    );
    check("Selection { Cube {} }", inside);
    check(
        "Wheel { a 1 2 3 b [ 1 ] c \"}\" d TRUE e Disc { x 1 } f (A | B) } Cube {}",
        "unknown node Wheel: skipped",
    );
    check("Odd { alternateRep Cube {} }", "Odd");
    check(
        "Cube { spin DEF e Engine { f [ 2 ] } grow USE e shape Round } ",
        "Cube.spin",
    );
    check("Cube { width 7 ~ on } ", "Cube.on");
    check("Cube { Sphere {} }", "nodes inside Cube");
    check(
        "AsciiText { string [ \"a\" ] justification LEFT } FontStyle {} Cube {}",
        "text \"a\": no font",
    );
    check(
        "PointSet {} IndexedLineSet { coordIndex [ 0 1 ] } Cube {}",
        "PointSet",
    );
}

#[test]
fn text_that_is_not_right() {
    let cube = [": Cuboid from -1 -1 -1 to 1 1 1"];
    let check = |body: &str, warning: &str| {
        let model = loaded(body);
        let objects: Vec<String> = model.scene.objects.iter().map(summary).collect();
        assert_eq!(objects, cube, "{body}");
        assert!(
            model.warnings.iter().any(|w| w.message.contains(warning)),
            "{body}: {:?}",
            model.warnings
        );
    };
    check("Cube {} }", "outside all nodes");
    check("and then Cube {}", "instead of a node");
    check("Group { Cube {", "ends inside a node");
    check("Cube { width }", "too few numbers");
    check("Cube { ] }", "instead of a field");
    check("Cube {} Coordinate3 { point [ 0 0 0 1 1 ] }", "incomplete");
    check(
        "Cube {} Coordinate3 { point [ 0 0 0, oh, 1 1 1 ] }",
        "among the values of point",
    );
    check("Cube {} Coordinate3 { point [ 0 0 0 }", "without a closing");
    check("Cube {} DEF", "DEF without a name");
    check(
        "MaterialBinding { value PER_DAY } Cube {}",
        "unknown binding PER_DAY",
    );
    check(
        "MatrixTransform { matrix 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1 } Cube {}",
        "not affine",
    );
    check(
        "DEF BackgroundColor Info { string \"blue\" } Cube {}",
        "not a colour",
    );
    check("Cube { width nan }", "an invalid number");
}

#[test]
fn what_cannot_be_read() {
    let check = |text: &str, expected: &str| {
        let error = read(
            text.as_bytes(),
            "a.wrl",
            &Memory::new(),
            &ReadOptions::default(),
        );
        let error = error.unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    check(
        "#VRML V1.0 ascii\n",
        "found the end of the file, expected a node",
    );
    check(
        "#VRML V1.0 ascii\nI am no model",
        "found \"I\", expected a node",
    );
    let deep = format!("#VRML V1.0 ascii\n{}", "Group {".repeat(300));
    check(&deep, "nested at most 256 deep");
    // Each group contains the previous one twice: a billion cubes from thirty lines.
    let doubled = (1..30).map(|i| format!("DEF g{i} Group {{ USE g{0} USE g{0} }}", i - 1));
    let doubled: String = doubled.collect();
    let text = format!("#VRML V1.0 ascii\nSwitch {{ DEF g0 Cube {{}} {doubled} }} USE g29");
    let options = ReadOptions {
        most_elements: 10_000,
        ..ReadOptions::default()
    };
    let error = read(text.as_bytes(), "a.wrl", &Memory::new(), &options).unwrap_err();
    assert!(error.to_string().contains("more than 10000"), "{error}");
}

#[test]
fn groups_may_use_each_other_deeper_than_a_stack() {
    let chain = (1..20_000).map(|i| format!("DEF g{i} Separator {{ USE g{} }}\n", i - 1));
    let text = format!(
        "Switch {{ DEF g0 Cube {{}} {} }} USE g19999",
        chain.collect::<String>()
    );
    let model = loaded(&text);
    assert_eq!(model.scene.objects.len(), 1);
    assert!(model.scene.objects[0].name.len() <= 200);
}

proptest! {
    #[test]
    fn anything_is_read_or_refused(words in prop::collection::vec(prop::sample::select(WORDS), 0..60)) {
        let text = format!("#VRML V1.0 ascii\n{}", words.join(" "));
        let options = ReadOptions { most_elements: 10_000, ..ReadOptions::default() };
        if let Ok(loaded) = read(text.as_bytes(), "a.wrl", &Memory::new(), &options) {
            prop_assert!(loaded.scene.validate().is_ok(), "{}", text);
        }
    }
}

const WORDS: &[&str] = &[
    "{",
    "}",
    "{",
    "}",
    "[",
    "]",
    "0",
    "1",
    "-1",
    "2.5",
    "1e300",
    "nan",
    "\"s\"",
    "DEF",
    "USE",
    "a",
    "b",
    "Separator",
    "Group",
    "Switch",
    "whichChild",
    "LOD",
    "range",
    "Coordinate3",
    "point",
    "IndexedFaceSet",
    "coordIndex",
    "[ 0 1 2 -1 ]",
    "[ 0 0 0 1 0 0 0 1 0 ]",
    "materialIndex",
    "Normal",
    "vector",
    "NormalBinding",
    "value",
    "PER_VERTEX",
    "PER_FACE_INDEXED",
    "Material",
    "diffuseColor",
    "emissiveColor",
    "MaterialBinding",
    "Cube",
    "width",
    "Sphere",
    "radius",
    "Cylinder",
    "parts",
    "SIDES",
    "Cone",
    "Translation",
    "translation",
    "MatrixTransform",
    "matrix",
    "Texture2",
    "image",
    "SpotLight",
    "direction",
    "PerspectiveCamera",
    "orientation",
    "isA",
    "#\n",
    "Separator {",
    "Cube {",
    "IndexedFaceSet {",
    "Material {",
    "Scale { scaleFactor 0 1 -1 }",
];
