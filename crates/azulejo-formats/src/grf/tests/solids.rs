//! Exact shapes: semantics, error messages, hostile files.

use super::*;
use crate::ReadOptions;
use azulejo_scene::{Bevel, BevelEnds, BevelProfile, Exact, Leaf, Operation, Rgb, Solid};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// A square of side 1 and a lens of two curves.
pub(super) const FIGURES: &str = "\
ext figure begin name = square
contour begin line (0, 0) line (1, 0) line (1, 1) line (0, 1) end contour
end ext
ext figure begin rule = non_zero name = lens
contour begin cubic (0, 0) (0.2, 0.5) (0.8, 0.5) cubic (1, 0) (0.8, -0.5) (0.2, -0.5) end contour
end ext
";

/// Every type of solid, in every syntax.
pub(super) const SOLIDS: &str = r#"def gold = brdf diffuse kd = (0.8, 0.6, 0.2) stone = brdf diffuse kd = 0.5
begin
ext define begin name = stud material = stone
  primitive begin kind = cylinder map = 0.1 0 0 0 0.1 0 0 0 0.2 0 0 0 end primitive
  instance begin of = cap map = 1 0 0 0 1 0 0 0 1 0 0 0.2 end instance
end ext
ext define begin name = cap primitive begin kind = sphere map = 0.1 0 0 0 0.1 0 0 0 0.1 0 0 0 end primitive end ext
ext object begin name = "title" end ext
ext text begin string = "[] \"" material = gold origin = (1, 2, 3) scale = (2, 2, 0.5)
  square (0, 0) lens (1.25, 0) square (1, 1, 1)
end ext
ext prism begin figure = lens map = 1 0 0 0 1 0 0.2 0 1 5 0 0 end ext
transform rotation (0, 90, 0) translation (0, 0, 4) begin
  ext csg begin operation = difference material = stone
    left begin primitive begin kind = box map = 4 0 0 0 4 0 0 0 1 0 0 0 end primitive end left
    right begin
      text begin material = gold map = 1 0 0 0 1 0 0 0 1 0.5 0.5 0.5 square (0, 0) lens (1.5, 0) end text
      csg begin operation = union
        left begin instance begin of = stud end instance end left
        right begin shell begin
          primitive begin kind = tube map = 1 0 0 0 1 0 0 0 1 0 0 0 end primitive
          mesh begin smoothing = 1
            begin vertices (0,0,0) (1,0,0) (0,1,0) end vertices begin faces (0,1,2) end faces
          end mesh
        end shell end right
      end csg
    end right
  end ext
  ext instance begin of = stud map = 2 0 0 0 2 0 0 0 2 0 0 0 end ext
end transform
ext solids begin material = gold
  patch begin points =
    (0,0,0) (1,0,0) (2,0,0) (3,0,0) (0,1,0) (1,1,1) (2,1,1) (3,1,0)
    (0,2,0) (1,2,1) (2,2,1) (3,2,0) (0,3,0) (1,3,0) (2,3,0) (3,3,0)
  end patch
  prism begin figure = square map = 1 0 0 0 1 0 0 0 1 0 0 0 material = stone end prism
end ext
ext skin begin leaves = 1 0 normals = (0, 0, 1) corners = 0 0 0 0 0 0
  begin vertices irad (1, 2, 3) (0,0,0) irad (1, 2, 3) (1,0,0) irad (1, 2, 3) (0,1,0) end vertices
  begin faces (0,1,2) (0,2,1) end faces
end ext
"#;

fn with_figures(text: &str) -> String {
    format!("{FIGURES}{text}")
}

fn sample() -> String {
    format!("{FIGURES}{SOLIDS}end def\n")
}

fn exact(scene: &Scene, object: usize) -> &Exact {
    match &scene.objects[object].shape {
        Shape::Exact(exact) => exact,
        _ => panic!("object {object} is not exact"),
    }
}

fn kinds(exact: &Exact) -> Vec<&'static str> {
    let kind = |leaf: &Leaf<'_>| match leaf {
        Leaf::Primitive(_) => "primitive",
        Leaf::Prism(_) => "prism",
        Leaf::Patch(_) => "patch",
        Leaf::Mesh(_) => "mesh",
    };
    exact.leaves().iter().map(kind).collect()
}

#[test]
fn all_kinds() {
    let scene = scene(&sample());
    let list = |object| kinds(exact(&scene, object));
    assert_eq!(list(0), ["prism"; 3]);
    assert_eq!(list(1), ["prism"]);
    let members = [
        "primitive",
        "prism",
        "prism",
        "primitive",
        "primitive",
        "primitive",
        "mesh",
    ];
    assert_eq!(list(2), members);
    assert_eq!(list(3), ["primitive"; 2]);
    assert_eq!(list(4), ["patch", "prism"]);
    assert_eq!(scene.objects[0].name, "title");
    let Solid::Csg(csg) = &exact(&scene, 2).solids[0] else {
        panic!("a set operation")
    };
    assert_eq!(csg.operation, Operation::Difference);
    assert_eq!((csg.left.len(), csg.right.len()), (1, 3));
}

#[test]
fn glyphs_stand_where_their_pens_are() {
    let scene = scene(&sample());
    let prisms = exact(&scene, 0).leaves();
    let corners = prisms.iter().map(|leaf| match leaf {
        Leaf::Prism(p) => p.world_from_figure.transform_point3(DVec3::ONE),
        _ => panic!("a prism"),
    });
    // The letters are scaled by two and extend half a unit away from the viewer.
    let expected = [(3.0, 4.0, 2.5), (5.5, 4.0, 2.5), (3.0, 3.0, 0.5)];
    assert_eq!(corners.collect::<Vec<_>>(), expected.map(DVec3::from));
}

#[test]
fn figures_are_shared_by_name() {
    let scene = scene(&sample());
    let prism = |object: usize, leaf: usize| match exact(&scene, object).leaves()[leaf] {
        Leaf::Prism(p) => Arc::clone(&p.figure),
        _ => panic!("a prism"),
    };
    assert!(Arc::ptr_eq(&prism(0, 0), &prism(0, 2)));
    assert!(Arc::ptr_eq(&prism(0, 1), &prism(1, 0)));
    assert!(Arc::ptr_eq(&prism(0, 0), &prism(2, 1)));
    assert!(!Arc::ptr_eq(&prism(0, 0), &prism(0, 1)));
    assert!(prism(0, 1).contains(DVec2::new(0.5, 0.1)));
}

#[test]
fn materials_come_from_around() {
    let scene = scene(&sample());
    let names = |object: usize| {
        let leaves = exact(&scene, object).leaves();
        let name = |leaf: &Leaf<'_>| scene.materials[leaf.material() as usize].name.clone();
        leaves.iter().map(name).collect::<Vec<_>>()
    };
    assert_eq!(names(0), ["gold"; 3]);
    assert_eq!(names(1), [""]);
    // The studs have their own material, and the ball on them has none.
    assert_eq!(
        names(2),
        ["stone", "gold", "gold", "stone", "", "stone", "stone"]
    );
    assert_eq!(names(4), ["gold", "stone"]);
}

#[test]
fn a_skin_is_light() {
    let scene = scene(&sample());
    let shape = exact(&scene, 4);
    let skin = shape.proxy.as_ref().unwrap();
    assert_eq!(skin.irradiance, [Rgb::new(1.0, 2.0, 3.0); 3]);
    assert_eq!(
        skin.face_materials,
        [1, 0].map(|l| shape.leaves()[l].material())
    );
    assert!(exact(&scene, 0).proxy.is_none() && !scene.is_solved());
}

#[test]
fn a_document_keeps_definitions_and_strings() {
    let text = document_text(&document(&sample()));
    for kept in [
        "ext define begin name = stud material = stone\n",
        "instance begin of = cap map = 1 0 0 0 1 0 0 0 1 0 0 0.2 end instance\n",
        "ext text begin string = \"[] \\\"\" map = 2 0 0 0 2 0 0 0 -0.5 1 2 3 material = gold\n",
        "square (0, 0)\nlens (1.25, 0)\nsquare (1, 1, 1)\nend ext\n",
        "cubic (0, 0) (0.2, 0.5) (0.8, 0.5)\n",
        "ext skin begin\nleaves = 1 0\n",
    ] {
        assert!(text.contains(kept), "{kept}\n{text}");
    }
    assert_eq!(document_text(&document(&text)), text);
    assert_eq!(scene(&text), scene(&sample()));
}

#[test]
fn a_page_of_letters_is_short() {
    let glyphs: String = (0..1232)
        .map(|k| {
            let name = if k % 3 == 0 { "lens" } else { "square" };
            format!("{name} ({}, {}) ", f64::from(k % 44) * 0.617, -(k / 44))
        })
        .collect();
    let text = format!("ext text begin scale = 0.35 origin = (-4, 3, 0.1) {glyphs} end ext");
    let scene = scene(&with_figures(&text));
    assert_eq!(exact(&scene, 0).solids.len(), 1232);
    let text = written(&scene);
    assert_eq!(text.matches("contour begin").count(), 2);
    assert!(text.len() < 1232 * 18, "{} bytes", text.len());
    assert!(text.contains("\nf1 (0.617, 0)\n"), "{}", &text[..600]);
    assert_eq!(super::scene(&text), scene);
}

#[test]
fn a_mirrored_shape_keeps_its_front() {
    let square = "primitive begin kind = parallelogram map = 1 0 0 0 1 0 0 0 1 0 0 0 end primitive";
    let text = format!("transform scale (-2, 1, 1) begin ext solids begin {square} end ext end");
    let scene = scene(&text);
    let leaves = exact(&scene, 0).leaves();
    let Leaf::Primitive(p) = leaves[0] else {
        panic!("a primitive")
    };
    assert_eq!(p.point(0, 0.5, 0.5).normal, DVec3::Z);
    assert_eq!(p.point(0, 0.5, 0.5).position, DVec3::new(-1.0, 0.5, 0.0));
}

fn check(text: &str, expected: &str) {
    let text = with_figures(text);
    let Err(error) = read(text.as_bytes(), "test.grf", &Memory::new()) else {
        panic!("read without error: {text}")
    };
    let message = error.to_string();
    assert_eq!(message.lines().next().unwrap_or(""), expected, "{text}");
}

/// Where the texts of these tests begin.
const AT: &str = "test.grf:7";

#[test]
fn names_that_lead_nowhere() {
    check(
        "ext prism begin figure = disc map = 1 0 0 0 1 0 0 0 1 0 0 0 end ext",
        &format!(
            "{AT}:26: found `disc`, which no enclosing `ext figure` defines as a figure, expected a figure that is defined in this block or an enclosing one"
        ),
    );
    check(
        "ext text begin square (0, 0) disc (1, 0) end ext",
        &format!(
            "{AT}:30: found `disc`, which no enclosing `ext figure` defines as a figure, expected a figure that is defined in this block or an enclosing one"
        ),
    );
    check(
        "ext instance begin of = stud end ext",
        &format!(
            "{AT}:25: found `stud`, which no enclosing `ext define` defines as a solid, expected a solid that is defined in this block or an enclosing one"
        ),
    );
    check(
        "ext prism begin map = 1 0 0 0 1 0 0 0 1 0 0 0 end ext",
        &format!("{AT}:1: found `ext prism` without `figure`, expected `figure = ...` in it"),
    );
}

#[test]
fn instances_in_a_circle() {
    let define = |name: &str, of: &str| {
        format!("ext define begin name = {name} instance begin of = {of} end instance end ext\n")
    };
    let circle = [("a", "b"), ("b", "c"), ("c", "a")].map(|(n, of)| define(n, of));
    check(
        &circle.concat(),
        "test.grf:9:27: found an instance of `a` inside of `a`, expected instances without a cycle",
    );
    check(
        &define("a", "a"),
        &format!(
            "{AT}:27: found an instance of `a` inside of `a`, expected instances without a cycle"
        ),
    );
}

#[test]
fn shapes_that_cannot_be() {
    let csg = |left: &str, right: &str| {
        format!(
            "ext csg begin operation = union left begin {left} end left right begin {right} end right end ext"
        )
    };
    let sphere = "primitive begin kind = sphere map = 1 0 0 0 1 0 0 0 1 0 0 0 end primitive";
    let tube = "primitive begin kind = tube map = 1 0 0 0 1 0 0 0 1 0 0 0 end primitive";
    check(
        &csg(sphere, ""),
        &format!(
            "{AT}:1: found `ext csg` without a solid on its right side, expected `right begin`, solids and `end right` in it"
        ),
    );
    check(
        &csg(tube, sphere),
        &format!(
            "{AT}:44: found a tube in a set operation, which is open and has no interior, expected closed solids; open pieces that close together are a `shell`"
        ),
    );
    check(
        &csg("text begin end text", sphere),
        &format!(
            "{AT}:44: found an empty side of a set operation: texts or instances without solids, expected solids on both sides"
        ),
    );
    check(
        "ext prism begin figure = lens map = 1 0 0 0 1 0 1 0 0 0 0 0 end ext",
        &format!(
            "{AT}:37: found `map` of 12 numbers, expected 12 numbers, the images of the x, y and z axes and of the origin, that form an invertible map"
        ),
    );
    check(
        "ext text begin scale = 0 lens (0, 0) end ext",
        &format!(
            "{AT}:1: found a text with a singular frame, expected `progression`, `up` and `extrusion` in three directions, and a `scale` without 0"
        ),
    );
    check(
        "ext text begin up = (0, 0, 0) lens (0, 0) end ext",
        &format!("{AT}:1: found `up` of length 0, expected a non-zero vector"),
    );
    check(
        &format!("transform scale (1, 0, 1) begin ext solids begin {sphere} end ext end"),
        &format!(
            "{AT}:33: found a shape that transforms flatten, or that overflows, expected invertible transforms"
        ),
    );
    check(
        "ext patch begin points = (0, 0, 0) end ext",
        &format!(
            "{AT}:26: found `points` of 1 triple, expected 16 control points (x, y, z), row by row"
        ),
    );
}

#[test]
fn figures_and_skins_that_cannot_be() {
    check(
        "ext figure begin name = x contour begin arc (0, 0) end contour end ext",
        &format!(
            "{AT}:41: found the word `arc`, expected `line (x, y)`, `cubic` with its start and two control points, or `end contour`"
        ),
    );
    check(
        "ext figure begin name = x rule = odd end ext",
        &format!("{AT}:34: found `odd`, expected `even_odd` or `non_zero`"),
    );
    let prism = "ext prism begin figure = lens map = 1 0 0 0 1 0 0 0 1 0 0 0 end ext\n";
    let skin = |keys: &str| {
        format!(
            "{prism}ext skin begin {keys} begin vertices (0,0,0) (1,0,0) (0,1,0) end vertices begin faces (0,1,2) end faces end ext"
        )
    };
    check(
        &skin("leaves = 1"),
        &format!(
            "{AT}:1: found a skin with solid 1 on a shape with 1 solids, expected the index of an existing solid"
        ),
    );
    check(
        &skin("leaves = 0 0"),
        "test.grf:8:25: found `leaves` of 2 numbers, expected 1 integers, one per face",
    );
    check(
        &skin("normals = (0, 0, 1) corners = 0 1 0"),
        "test.grf:8:26: found normal 1 of 1, expected an index of one of the `normals`",
    );
    check(
        "ext skin begin end ext",
        &format!("{AT}:1: found `ext skin`, expected its exact shape immediately before it"),
    );
}

#[test]
fn bevels_have_a_profile_and_a_size() {
    let prism = |keys: &str| {
        format!("ext prism begin {keys} figure = lens map = 1 0 0 0 1 0 0 0 1 0 0 0 end ext")
    };
    let bevel = |keys: &str| {
        let scene = scene(&with_figures(&prism(keys)));
        match &exact(&scene, 0).solids[0] {
            Solid::Prism(prism) => prism.bevel.as_deref().copied(),
            other => panic!("{other:?}"),
        }
    };
    let chamfer = Bevel {
        profile: BevelProfile::Chamfer,
        inset: 0.1,
        depth: 0.75,
        ends: BevelEnds::Front,
    };
    assert_eq!(bevel(""), None);
    assert_eq!(
        bevel("bevel = chamfer bevel_size = 0.1 0.75"),
        Some(chamfer)
    );
    let round = Bevel {
        profile: BevelProfile::Round,
        depth: 0.5,
        ends: BevelEnds::Both,
        ..chamfer
    };
    assert_eq!(
        bevel("bevel_ends = both bevel = round bevel_size = 0.1 0.5"),
        Some(round)
    );
    check(
        &prism("bevel = flat"),
        &format!("{AT}:25: found `flat`, expected `chamfer` or `round`"),
    );
    check(
        &prism("bevel = round"),
        &format!(
            "{AT}:1: found `ext prism` without `bevel_size`, expected `bevel_size = ...` in it"
        ),
    );
    check(
        &prism("bevel = round bevel_size = 0.1"),
        &format!("{AT}:44: found `bevel_size` of 1 number, expected two numbers"),
    );
    check(
        &prism("bevel = round bevel_ends = both bevel_size = 0.1 0.6"),
        &format!(
            "{AT}:62: found a bevel of size 0.1 0.6, expected an inset above 0, and a depth above 0 and at most 1, or 0.5 with `bevel_ends = both`"
        ),
    );
}

#[test]
fn what_is_not_understood_is_named() {
    let text = "ext prism begin figure = lens colour = red map = 1 0 0 0 1 0 0 0 1 0 0 0 end ext";
    assert_eq!(
        warnings(&with_figures(text)),
        ["test.grf:7:40: `ext prism` has no key `colour`: skipped"]
    );
    check(
        "ext shell begin lamp begin end lamp end ext",
        &format!(
            "{AT}:17: found the word `lamp`, expected `end ext` for the block that begins in line 7"
        ),
    );
}

/// `depth` nested set operations.
fn nest(depth: usize) -> String {
    let sphere = "primitive begin kind = sphere map = 1 0 0 0 1 0 0 0 1 0 0 0 end primitive";
    let open = format!("csg begin operation = union right begin {sphere} end right left begin ");
    format!(
        "ext solids begin {} {sphere} {} end ext",
        open.repeat(depth),
        "end left end csg ".repeat(depth)
    )
}

#[test]
fn the_deepest_nesting_is_read_and_written() {
    let blocks = "transform scale (1,1,1) begin ".repeat(255);
    let text = format!("{blocks} {} {}", nest(255), "end ".repeat(255));
    let scene = scene(&text);
    assert_eq!(exact(&scene, 0).leaves().len(), 256);
    assert_eq!(super::scene(&written(&scene)), scene);
    let reason = "at most 256 nested levels";
    check_hostile(&nest(300), reason);
    check_hostile(&nest(100_000), reason);
    check_hostile(&"ext csg begin left begin ".repeat(100_000), "expected");
}

fn check_hostile(text: &str, reason: &str) {
    let options = ReadOptions::in_proportion(text.len());
    let error = super::super::read_with(text.as_bytes(), "test.grf", &Memory::new(), &options);
    let message = error.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains(reason), "{message}");
}

#[test]
fn instances_that_double() {
    let prism = "prism begin figure = square map = 1 0 0 0 1 0 0 0 1 0 0 0 end prism";
    let mut text = with_figures(&format!("ext define begin name = d0 {prism} end ext\n"));
    for k in 0..64 {
        let copy = format!("instance begin of = d{k} end instance ");
        text += &format!("ext define begin name = d{} {copy}{copy} end ext\n", k + 1);
    }
    check_hostile(
        &text,
        "instances, arrays or curves that expand to more than",
    );
}

/// A chain of definitions, in reverse order: each one is converted while the previous one waits for
/// it.
#[test]
fn a_chain_of_definitions() {
    let chain: String = (0..20_000)
        .map(|k| {
            let next = k + 1;
            format!(
                "ext define begin name = d{k} instance begin of = d{next} end instance end ext\n"
            )
        })
        .collect();
    let end = "ext define begin name = d20000 end ext";
    check_hostile(&format!("{chain}{end}"), "at most 256 nested levels");
}

#[test]
fn a_figure_of_a_million_curves() {
    let curves = "line (0, 0) cubic (1, 0) (1, 1) (0, 1) ".repeat(500_000);
    let figure = format!("ext figure begin name = x contour begin {curves} end contour end ext\n");
    let glyphs = "x (0, 0) ".repeat(100_000);
    let scene = scene(&format!("{figure} ext text begin {glyphs} end ext"));
    let exact = exact(&scene, 0);
    assert_eq!(exact.solids.len(), 100_000);
    let Solid::Prism(prism) = &exact.solids[0] else {
        panic!("a prism")
    };
    assert_eq!(prism.figure.curve_count(), 1_000_000);
}
