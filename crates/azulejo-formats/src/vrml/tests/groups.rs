//! Groups, names, nested files, and nodes other than shapes in groups.

use super::*;
use azulejo_scene::{LightKind, Rgb, SceneBackground};

const BOX: &str = "Shape { appearance Appearance { material Material { } } geometry Box { } }";

#[test]
fn transformations_and_names() {
    let text = format!(
        "DEF house Transform {{ translation 10 0 0 children [
           DEF room Group {{ children DEF table {BOX} }}
           Transform {{ rotation 0 0 9 1.5707963267948966 scale 1 2 -3 center 1 0 0 children USE table }}
         ] }}
         USE room"
    );
    check(
        &text,
        &[
            "house/room/table: Cuboid, 9 -1 -1 to 11 1 1",
            "house/table: Cuboid, 9 -2 -3 to 13 0 3",
            "room/table: Cuboid, -1 -1 -1 to 1 1 1",
        ],
    );
}

#[test]
fn shapes_used_again_share_their_mesh() {
    let heights = "0 1 0 2 0 ".repeat(5);
    let hill = format!(
        "DEF hill Shape {{ appearance Appearance {{ material Material {{ }} }} geometry DEF grid ElevationGrid {{ xDimension 5 zDimension 5 height [ {heights} ] }} }}"
    );
    let text = format!(
        "{hill} Transform {{ translation 9 0 0 children DEF both Group {{ children [ USE hill {BOX} ] }} }}
         Transform {{ scale -2 1 1 children USE both }}
         Shape {{ appearance Appearance {{ material Material {{ diffuseColor 1 0 0 }} }} geometry USE grid }}"
    );
    let (scene, warnings) = load(&text);
    assert_eq!((scene.objects.len(), warnings.len()), (6, 0));
    let is_instance = |o: &azulejo_scene::Object| matches!(o.shape, Shape::Instance(_));
    let instances: Vec<bool> = scene.objects.iter().map(is_instance).collect();
    // The mirrored one and the red one are the only ones of their meshes.
    assert_eq!(instances, [true, true, false, false, false, false]);
    assert_eq!(scene.shared_meshes().len(), 1);
    let boxes: Vec<(f64, f64)> = [0, 1, 3, 5]
        .map(|k| scene.objects[k].bounds())
        .map(|b| (b.min.x, b.max.x))
        .to_vec();
    assert_eq!(boxes, [(0.0, 4.0), (9.0, 13.0), (-8.0, 0.0), (0.0, 4.0)]);
    let up = |k: usize| {
        let placed = scene.objects[k].shape.placed_mesh().unwrap();
        placed.face_area_vector(0).y
    };
    assert!([0, 1, 3, 5].iter().all(|&k| up(k) > 0.0));
}

#[test]
fn scale_along_an_orientation() {
    let text = format!(
        "Transform {{ scale 3 1 1 scaleOrientation 0 1 0 1.5707963267948966 children {BOX} }}"
    );
    check(&text, &[": Cuboid, -1 -1 -3 to 1 1 3"]);
}

#[test]
fn the_latest_definition_of_a_name_counts() {
    let text = format!("DEF a {BOX} DEF a {} USE a", shape("Sphere { radius 2 }"));
    let objects = [
        "a: Cuboid, -1 -1 -1 to 1 1 1",
        "a: Sphere, -2 -2 -2 to 2 2 2",
        "a: Sphere, -2 -2 -2 to 2 2 2",
    ];
    check(&text, &objects);
}

#[test]
fn a_node_is_not_inside_itself() {
    let text = format!("DEF a Group {{ children [ {BOX} USE a ] }}");
    let warning = ":2:104: USE of \"a\", which no complete node before it defines: skipped";
    check_lossy(&text, &["a: Cuboid, -1 -1 -1 to 1 1 1"], &[warning]);
}

#[test]
fn switches_show_what_they_choose() {
    let text = |n: i32| {
        format!(
            "Switch {{ whichChoice {n} choice [ {BOX} {} ] }}",
            shape("Sphere { }")
        )
    };
    let hidden = ":2:1: child of a Switch that is not selected: skipped";
    check_lossy(&text(1), &[": Sphere, -1 -1 -1 to 1 1 1"], &[hidden]);
    let (scene, warnings) = load(&text(-1));
    assert!(
        scene.objects.is_empty() && warnings[0].ends_with("(2 times)"),
        "{warnings:?}"
    );
}

#[test]
fn levels_of_detail() {
    let levels = [1, 2, 3]
        .map(|r| shape(&format!("Sphere {{ radius {r} }}")))
        .join(" ");
    let text = format!("#VRML V2.0 utf8\nLOD {{ range [ 5 10 ] level [ {levels} Group {{ }} ] }}");
    let check = |lod, expected: &[f64]| {
        let (scene, _) = load_with(&text, &Memory::new(), &with_lod(lod));
        let radius = |o: &azulejo_scene::Object| o.bounds().max.x;
        let radii: Vec<f64> = scene.objects.iter().map(radius).collect();
        assert_eq!(radii, expected, "{lod:?}");
    };
    check(Lod::Finest, &[1.0]);
    check(Lod::Coarsest, &[3.0]);
    check(Lod::Distance(4.0), &[1.0]);
    check(Lod::Distance(5.0), &[2.0]);
    check(Lod::Distance(99.0), &[3.0]);
    check(Lod::All, &[1.0, 2.0, 3.0]);
}

#[test]
fn files_inside_files() {
    let model = "#VRML V2.0 utf8\nDEF a Inline { url [ \"none.wrl\" \"parts/a.wrl\" ] } USE a";
    let files = Memory::new()
        .with("parts/a.wrl", format!("#X3D V3.3 utf8\nPROFILE Full UNIT length inch 0.5\nInline {{ url \"b.x3d\" }} Inline {{ url \"../model.wrl\" }} {BOX}"))
        .with("parts/b.x3d", "<X3D><Scene><Shape DEF='ball'><Sphere/></Shape></Scene></X3D>");
    let (scene, warnings) = load_with(model, &files, &ReadOptions::default());
    let half = [
        "a/ball: Sphere, -0.5 -0.5 -0.5 to 0.5 0.5 0.5",
        "a: Cuboid, -0.5 -0.5 -0.5 to 0.5 0.5 0.5",
    ];
    assert_eq!(described(&scene), [half, half].concat());
    assert!(
        warnings[1].contains("\"../model.wrl\": the file includes itself (2 times)"),
        "{warnings:?}"
    );
}

#[test]
fn what_is_wrong_with_a_file_inside_is_a_warning() {
    let model =
        format!("#VRML V2.0 utf8\nInline {{ url \"a.wrl\" }} Inline {{ url \"b.x3d\" }} {BOX}");
    let files = Memory::new()
        .with("a.wrl", "solid\n")
        .with("b.x3d", "<X3D><Scene");
    let (scene, warnings) = load_with(&model, &files, &ReadOptions::default());
    assert_eq!(scene.objects.len(), 1);
    assert!(
        warnings[0].contains("a.wrl:1:1: found \"solid\""),
        "{warnings:?}"
    );
    assert!(warnings[1].contains("b.x3d"), "{warnings:?}");
}

#[test]
fn units() {
    let metres = |text: &str| load(text).0.units.metres_per_unit;
    assert_eq!(metres(BOX), Some(1.0));
    assert_eq!(
        metres(&format!("#X3D V3.3 utf8\nUNIT length foot 0.3048\n{BOX}")),
        Some(0.3048)
    );
    let xml = "<X3D><head><unit category='length' name='foot' conversionFactor='0.3048'/></head><Scene/></X3D>";
    assert_eq!(metres(xml), Some(0.3048));
}

#[test]
fn lights() {
    let text = "Transform { translation 0 5 0 children [
        DEF lamp PointLight { intensity 2 color 1 0.5 0 attenuation 0 0 1 }
        SpotLight { direction 0 -2 0 cutOffAngle 1 beamWidth 0.5 location 1 0 0 }
        DirectionalLight { ambientIntensity 0.5 } PointLight { on FALSE } ] }";
    let (scene, warnings) = load(text);
    let kinds: Vec<LightKind> = scene.lights.iter().map(|l| l.kind.clone()).collect();
    assert_eq!(scene.lights[0].name, "lamp");
    assert_eq!(
        kinds,
        [
            LightKind::Point {
                position: DVec3::new(0.0, 5.0, 0.0),
                intensity: Rgb::new(2.0, 1.0, 0.0),
            },
            LightKind::Spot {
                position: DVec3::new(1.0, 5.0, 0.0),
                direction: DVec3::NEG_Y,
                intensity: Rgb::WHITE,
                inner: 0.5,
                outer: 1.0,
            },
            LightKind::Directional {
                direction: DVec3::NEG_Z,
                irradiance: Rgb::WHITE,
                half_angle: 0.0
            },
        ]
    );
    expect_warnings(
        &warnings,
        &[
            ":3:17: attenuation and radius of lights",
            ":5:9: ambientIntensity of a light",
            ":5:9: DirectionalLight limited to its group",
            ":5:51: PointLight with on FALSE",
            ": the model contains no geometry",
        ],
    );
}

#[test]
fn viewpoints_background_and_fog() {
    let text = format!(
        "{BOX}
        Transform {{ translation 1 0 0 scale 2 2 2 children [
          Viewpoint {{ orientation 0 1 0 1.5707963267948966 description \"side\" fieldOfView 1 }}
          Fog {{ color 0.5 0.5 0.5 visibilityRange 10 fogType \"EXPONENTIAL\" }} ] }}
        Background {{ skyColor [ 0 0 1, 0 1 1 ] skyAngle 1.5 frontUrl \"a.png\" }} Background {{ }}
        NavigationInfo {{ }} WorldInfo {{ title \"box\" }}"
    );
    let (scene, warnings) = load(&text);
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.vertical_fov), ("side", 1.0));
    assert!((camera.eye - DVec3::new(1.0, 0.0, 20.0)).length() < 1e-12);
    assert!((camera.target - camera.eye - DVec3::NEG_X).length() < 1e-12);
    let Some(SceneBackground::Environment(sky)) = scene.background else {
        panic!("a gradient is not a colour: {:?}", scene.background)
    };
    let picture = scene.textures[sky.texture().unwrap() as usize]
        .image
        .as_ref();
    assert_eq!(sky.radiance(DVec3::NEG_Y, picture), Rgb::new(0.0, 1.0, 1.0));
    assert!(sky.radiance(DVec3::Y, picture).g < 0.01);
    let fog = scene.fog.unwrap();
    assert!((fog.visibility - 20.0).abs() < 1e-12 && fog.exponential);
    expect_warnings(
        &warnings,
        &[
            ":6:9: picture \"a.png\" is not used",
            ":6:80: Background after the first",
            ":7:9: headlight of NavigationInfo",
        ],
    );
}

#[test]
fn what_is_skipped_is_named() {
    let text = format!(
        "{BOX} DEF t TimeSensor {{ }} TimeSensor {{ }}
         Script {{ field SFNode n USE t eventIn SFTime go eventOut MFString out
                   field MFString s [ \"a\" \"}}\" ] url \"javascript: {{ [ \" directOutput TRUE }}
         ROUTE t.time TO t.startTime
         New {{ things [ Thing {{ size 1 2 3 }} ] on FALSE words [ \"a\" ] at [ TRUE FALSE ] none NULL }}
         Shape {{ geometry Text {{ string \"hello\" }} }} Billboard {{ children USE t }}"
    );
    let warnings = [
        ":5:10: ROUTE: skipped",
        ":2:81: node TimeSensor: skipped (3 times)",
        ":3:10: node Script: skipped",
        ":6:10: node New: skipped",
        ":7:27: text \"hello\": no font to set it in",
        ":7:53: Billboard: kept in its original orientation",
    ];
    check_lossy(&text, &[": Cuboid, -1 -1 -1 to 1 1 1"], &warnings);
}

#[test]
fn xml_is_read_like_the_classic_encoding() {
    let xml = "<?xml version='1.0' encoding='UTF-8'?>
        <!DOCTYPE X3D PUBLIC 'ISO//Web3D//DTD X3D 3.0//EN' 'http://www.web3d.org/specifications/x3d-3.0.dtd'>
        <X3D profile='Full' version='3.3'><Scene>
          <Transform DEF='a' translation='1, 2, 3'>
            <Shape DEF='s'><Appearance><Material DEF='red' diffuseColor='1 0 0'/></Appearance>
              <IndexedFaceSet coordIndex='0 1 2 -1' solid='false'><Coordinate point='0 0 0, 1 0 0, 0 1 0'/></IndexedFaceSet>
            </Shape>
            <Group><Shape USE='s'/></Group>
          </Transform>
          <Switch whichChoice='0'><Shape><Appearance><Material USE='red'/></Appearance><Cone height='4'/></Shape></Switch>
          <Viewpoint description='front' position='0 0 5'/>
        </Scene></X3D>";
    let classic = "#X3D V3.3 utf8
        PROFILE Full COMPONENT Geometry3D:4 META \"title\" \"a\"
        DEF a Transform { translation 1 2 3 children [
          DEF s Shape { appearance Appearance { material DEF red Material { diffuseColor 1 0 0 } }
            geometry IndexedFaceSet { coordIndex [ 0 1 2 -1 ] solid FALSE coord Coordinate { point [ 0 0 0, 1 0 0, 0 1 0 ] } } }
          Group { children USE s } ] }
        Switch { whichChoice 0 children [ Shape { appearance Appearance { material USE red } geometry Cone { height 4 } } ] }
        Viewpoint { description \"front\" position 0 0 5 }";
    let ((from_xml, messages), (from_classic, _)) = (load(xml), load(classic));
    assert_eq!(messages, [""; 0]);
    assert_eq!(from_xml, from_classic);
    assert_eq!(
        described(&from_xml),
        [
            "a/s: 3 vertices 1 faces, 1 2 3 to 2 3 3",
            "a/s: 3 vertices 1 faces, 1 2 3 to 2 3 3",
            ": Cone { top: 0.0 }, -1 -2 -1 to 1 2 1",
        ]
    );
}
