//! Strategies for arbitrary valid exact shapes.

use super::round_trip::{a_mesh, direction, number, primitive_kind, small_point};
use super::*;
use azulejo_scene::{
    Attribute, Bevel, BevelEnds, BevelProfile, BicubicPatch, Contour, Csg, Curve, Exact, Figure,
    FillRule, MaterialId, Operation, Primitive, PrimitiveKind, Prism, Solid, TextFrame,
};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use std::sync::Arc;

/// For each prism of a scene, the index of its figure, in order of first use.
pub(super) fn shared_figures(scene: &Scene) -> Vec<usize> {
    let mut known: Vec<*const Figure> = Vec::new();
    let mut numbers = Vec::new();
    for object in &scene.objects {
        let Shape::Exact(exact) = &object.shape else {
            continue;
        };
        for leaf in exact.leaves() {
            if let azulejo_scene::Leaf::Prism(prism) = leaf {
                let pointer = Arc::as_ptr(&prism.figure);
                let number = known.iter().position(|&k| k == pointer);
                numbers.push(number.unwrap_or(known.len()));
                if number.is_none() {
                    known.push(pointer);
                }
            }
        }
    }
    numbers
}

fn flat_point() -> impl Strategy<Value = DVec2> {
    [number(), number()].prop_map(DVec2::from_array)
}

fn curve() -> impl Strategy<Value = Curve> {
    prop_oneof![
        flat_point().prop_map(|start| Curve::Line { start }),
        [flat_point(), flat_point(), flat_point()].prop_map(|[start, control1, control2]| {
            Curve::Cubic {
                start,
                control1,
                control2,
            }
        }),
    ]
}

fn figure() -> impl Strategy<Value = Arc<Figure>> {
    let contour = vec(curve(), 0..5).prop_map(|curves| Contour { curves });
    (vec(contour, 0..3), any::<bool>()).prop_map(|(contours, winds)| {
        let rule = if winds {
            FillRule::NonZero
        } else {
            FillRule::EvenOdd
        };
        Arc::new(Figure { contours, rule })
    })
}

fn map() -> impl Strategy<Value = DAffine3> {
    [small_point(), small_point(), small_point(), small_point()]
        .prop_map(|[x, y, z, translation]| DAffine3 {
            matrix3: DMat3::from_cols(x, y, z),
            translation,
        })
        .prop_filter("flat", super::super::solids::has_inverse)
}

/// Mostly axis-aligned frames, and arbitrary ones.
fn frame() -> impl Strategy<Value = TextFrame> {
    let plain = Just((DVec3::X, DVec3::Y, DVec3::NEG_Z));
    let axes = prop_oneof![plain, (direction(), direction(), direction())];
    (small_point(), axes, 0.01..9.0)
        .prop_map(|(origin, (progression, up, extrusion), scale)| TextFrame {
            origin,
            progression,
            up,
            extrusion,
            scale: DVec3::splat(scale),
        })
        .prop_filter("flat", |f| {
            super::super::solids::has_inverse(&f.world_from_glyph(DVec2::ZERO))
        })
}

type Figures = Vec<Arc<Figure>>;

fn bevel() -> impl Strategy<Value = Option<Arc<Bevel>>> {
    let round = prop_oneof![Just(BevelProfile::Chamfer), Just(BevelProfile::Round)];
    let ends = prop_oneof![Just(BevelEnds::Front), Just(BevelEnds::Both)];
    let bevel = (round, 1e-6..9.0, 1e-6..0.5, ends).prop_map(|(profile, inset, depth, ends)| {
        Arc::new(Bevel {
            profile,
            inset,
            depth,
            ends,
        })
    });
    option::of(bevel)
}

fn prism(figures: Figures, materials: u32) -> impl Strategy<Value = Solid> {
    (any::<prop::sample::Index>(), map(), 0..materials, bevel()).prop_map(
        move |(figure, world_from_figure, material, bevel)| {
            Solid::Prism(Prism {
                figure: Arc::clone(figure.get(&figures)),
                world_from_figure,
                material,
                bevel,
            })
        },
    )
}

/// Glyphs of one line, with typical origins.
fn text(figures: Figures, materials: u32) -> impl Strategy<Value = Vec<Solid>> {
    let pen = [-900..9000i32, -3..3i32].prop_map(|p| DVec2::from(p.map(|n| f64::from(n) / 100.0)));
    let glyphs = vec((any::<prop::sample::Index>(), pen), 1..6);
    (frame(), glyphs, 0..materials, bevel()).prop_map(move |(frame, glyphs, material, bevel)| {
        let prism = |(figure, pen): (prop::sample::Index, DVec2)| {
            Solid::Prism(Prism {
                figure: Arc::clone(figure.get(&figures)),
                world_from_figure: frame.world_from_glyph(pen),
                material,
                bevel: bevel.clone(),
            })
        };
        glyphs.into_iter().map(prism).collect()
    })
}

fn primitive(materials: u32) -> impl Strategy<Value = Solid> {
    (primitive_kind(), map(), 0..materials)
        .prop_map(|(kind, map, material)| Solid::Primitive(Primitive::new(kind, map, material)))
}

fn patch(materials: u32) -> impl Strategy<Value = Solid> {
    (vec(small_point(), 16), 0..materials).prop_map(|(points, material)| {
        let row = |r: usize| std::array::from_fn(|c| points[4 * r + c]);
        Solid::Patch(BicubicPatch {
            points: Box::new(std::array::from_fn(row)),
            material,
        })
    })
}

fn tetrahedron(materials: u32) -> impl Strategy<Value = Solid> {
    let points = [small_point(), small_point(), small_point(), small_point()];
    (points, 0..materials).prop_map(|(positions, material)| {
        let mut mesh = Mesh {
            positions: positions.to_vec(),
            ..Mesh::default()
        };
        for face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
            mesh.push_face(&face, material);
        }
        Solid::Mesh(Box::new(mesh))
    })
}

fn any_mesh(materials: u32) -> impl Strategy<Value = Solid> {
    (mesh_of(materials), 0..materials).prop_map(|(mut mesh, material)| {
        mesh.face_materials.fill(material);
        Solid::Mesh(Box::new(mesh))
    })
}

/// A mesh whose normals may be stored per corner.
fn mesh_of(materials: u32) -> impl Strategy<Value = Mesh> {
    let normals = vec(direction(), 1..5);
    let index = any::<prop::sample::Index>();
    (a_mesh(materials), normals, any::<bool>(), index).prop_map(
        |(shape, values, by_corner, index)| {
            let Shape::Mesh(mut mesh) = shape else {
                unreachable!("a mesh was asked for")
            };
            // Exact shapes carry the light of their outside.
            mesh.back = None;
            if by_corner {
                let corners = 0..mesh.faces.corners.len();
                let value = |k: usize| ((k + index.index(7)) % values.len()) as u32;
                mesh.normals = Some(Attribute {
                    corners: Some(corners.map(value).collect()),
                    values,
                });
            }
            mesh
        },
    )
}

/// Closed solids for set operations, several at a time.
fn closed(figures: Figures, materials: u32) -> BoxedStrategy<Vec<Solid>> {
    let is_closed = |solid: &Solid| solid.open_part().is_none();
    let primitive = primitive(materials).prop_filter("open", is_closed);
    let one = prop_oneof![
        prism(figures.clone(), materials),
        primitive,
        tetrahedron(materials)
    ];
    let any_piece = prop_oneof![patch(materials), any_mesh(materials)];
    let leaf = prop_oneof![one.prop_map(|s| vec![s]), text(figures, materials)];
    leaf.prop_recursive(4, 24, 4, move |inner| {
        let shell = (inner.clone(), vec(any_piece.clone(), 0..2))
            .prop_map(|(solids, open)| vec![Solid::Shell([solids, open].concat())]);
        let operation = prop_oneof![
            Just(Operation::Union),
            Just(Operation::Difference),
            Just(Operation::Intersection)
        ];
        let csg = (operation, inner.clone(), inner).prop_map(|(operation, left, right)| {
            vec![Solid::Csg(Box::new(Csg {
                operation,
                left,
                right,
            }))]
        });
        prop_oneof![shell, csg]
    })
    .boxed()
}

fn solids(materials: u32) -> impl Strategy<Value = Vec<Solid>> {
    vec(figure(), 1..4).prop_flat_map(move |figures| {
        let one = |s| vec![s];
        let tube = map().prop_map(|m| PrimitiveKind::Tube { top: 0.5 }.at(m));
        let some = prop_oneof![
            3 => closed(figures.clone(), materials),
            2 => text(figures, materials),
            1 => patch(materials).prop_map(one),
            1 => any_mesh(materials).prop_map(one),
            1 => primitive(materials).prop_map(one),
            1 => tube.prop_map(one),
        ];
        vec(some, 0..4).prop_map(|lists| lists.concat())
    })
}

/// A primitive of the first material.
trait At {
    fn at(self, map: DAffine3) -> Solid;
}

impl At for PrimitiveKind {
    fn at(self, map: DAffine3) -> Solid {
        Solid::Primitive(Primitive::new(self, map, 0))
    }
}

/// A shape, possibly with a skin, with the materials of its solids.
pub(super) fn exact(materials: u32) -> impl Strategy<Value = Shape> {
    (solids(materials), option::of(mesh_of(materials))).prop_map(|(solids, skin)| {
        let mut exact = Exact::new(solids);
        let materials: Vec<MaterialId> = exact.leaves().iter().map(|l| l.material()).collect();
        if let Some(mut skin) = skin.filter(|_| !materials.is_empty()) {
            for m in &mut skin.face_materials {
                *m = materials[*m as usize % materials.len()];
            }
            exact.proxy = Some(Box::new(skin));
        }
        Shape::Exact(exact)
    })
}
