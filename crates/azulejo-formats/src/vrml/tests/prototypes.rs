//! Prototypes.

use super::*;

#[test]
fn fields_of_an_instance_come_first_then_those_of_the_interface() {
    let text = format!(
        "PROTO Ball [ field SFFloat size 2 exposedField SFNode look NULL eventIn SFTime go ] {{
           DEF b Shape {{ appearance IS look geometry Sphere {{ radius IS size }} }}
           Group {{ children {} }}
         }}
         DEF x Ball {{ look Appearance {{ material Material {{ }} }} }}
         Ball {{ size 3 look Appearance {{ material Material {{ }} }} }}",
        shape("Box { }")
    );
    let objects = [
        "x/b: Sphere, -2 -2 -2 to 2 2 2",
        "b: Sphere, -3 -3 -3 to 3 3 3",
    ];
    check(&text, &objects);
}

#[test]
fn prototypes_inside_prototypes() {
    let text = format!(
        "PROTO Pair [ field SFFloat size 1 ] {{
           PROTO One [ field SFFloat radius 5 field SFVec3f at 0 0 0 ] {{
             Transform {{ translation IS at children {} }}
           }}
           Group {{ children [ One {{ radius IS size }} One {{ at 4 0 0 }} ] }}
         }}
         Pair {{ size 2 }} One {{ }}",
        shape("Sphere { radius IS radius }")
    );
    let objects = [": Sphere, -2 -2 -2 to 2 2 2", ": Sphere, -1 -5 -5 to 9 5 5"];
    check_lossy(&text, &objects, &[":8:26: node One: skipped"]);
}

#[test]
fn prototypes_of_other_files() {
    let files = Memory::new().with(
        "lib/parts.wrl",
        format!(
            "#VRML V2.0 utf8\nPROTO A [ field SFFloat r 1 ] {{ {} }} PROTO B [ ] {{ {} }}",
            shape("Sphere { radius IS r }"),
            shape("Box { }")
        ),
    );
    let text = "#VRML V2.0 utf8
        EXTERNPROTO Any [ field SFFloat r ] [ \"none.wrl\" \"lib/parts.wrl\" ]
        EXTERNPROTO Brick [ ] \"lib/parts.wrl#B\"
        EXTERNPROTO Lost [ exposedField SFFloat r eventIn SFTime t ] \"lib/parts.wrl#C\"
        Any { r 2 } Brick { } Lost { }";
    let (scene, warnings) = load_with(text, &files, &ReadOptions::default());
    let objects = [": Sphere, -2 -2 -2 to 2 2 2", ": Cuboid, -1 -1 -1 to 1 1 1"];
    assert_eq!(described(&scene), objects);
    expect_warnings(
        &warnings,
        &[":5:31: Lost, a prototype that stands for nothing"],
    );
}

#[test]
fn in_xml() {
    let text = "<X3D version='3.3'><Scene>
        <ProtoDeclare name='Ball'>
          <ProtoInterface>
            <field name='size' type='SFFloat' accessType='initializeOnly' value='2'/>
            <field name='look' type='SFNode' accessType='initializeOnly'><Appearance><Material/></Appearance></field>
          </ProtoInterface>
          <ProtoBody><Shape>
            <IS><connect nodeField='appearance' protoField='look'/></IS>
            <Sphere><IS><connect nodeField='radius' protoField='size'/></IS></Sphere>
          </Shape></ProtoBody>
        </ProtoDeclare>
        <ProtoInstance name='Ball' DEF='x'/>
        <ProtoInstance name='Ball'><fieldValue name='size' value='3'/></ProtoInstance>
        <ExternProtoDeclare name='Gone' url='\"gone.x3d#A\"'/>
        <ProtoInstance name='Gone'/>
      </Scene></X3D>";
    let objects = [
        "x: Sphere, -2 -2 -2 to 2 2 2",
        ": Sphere, -3 -3 -3 to 3 3 3",
    ];
    let warnings = [
        ":15:9: file cannot be read: \"gone.x3d\"",
        ":15:9: Gone, a prototype that stands for nothing",
    ];
    check_lossy(text, &objects, &warnings);
}

#[test]
fn prototypes_do_not_stand_for_themselves() {
    let file = |other: &str| {
        format!(
            "#VRML V2.0 utf8\nEXTERNPROTO Q [ ] \"{other}\"\nPROTO P [ ] {{ Q {{ }} }}\nPROTO R [ ] {{ Group {{ children [ Q {{ }} Q {{ }} ] }} }}"
        )
    };
    let files = Memory::new()
        .with("a.wrl", file("b.wrl#P"))
        .with("b.wrl", file("a.wrl#P"));
    let text = "#VRML V2.0 utf8\nEXTERNPROTO P [ ] \"a.wrl#P\" P { }";
    let (_, warnings) = load_with(text, &files, &ReadOptions::default());
    assert!(warnings[0].contains("stands for itself"), "{warnings:?}");
    let files = Memory::new()
        .with("a.wrl", file("b.wrl#R"))
        .with("b.wrl", file("a.wrl#R"));
    let text = "#VRML V2.0 utf8\nEXTERNPROTO P [ ] \"a.wrl#R\" P { }";
    let tight = ReadOptions {
        most_elements: 10_000,
        ..ReadOptions::default()
    };
    let error = crate::vrml::read(text.as_bytes(), "a", &files, &tight).unwrap_err();
    assert!(error.to_string().contains("more than 10000"), "{error}");
}
