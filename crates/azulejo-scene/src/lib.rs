//! The scene: geometry, materials, lights, cameras and images as plain data.
//!
//! A [`Scene`] is plain data with public fields. Readers (in `azulejo-formats`) build it, the first
//! pass stores irradiance at its vertices, the second pass renders it. Everything a renderer may
//! assume is documented at and checked by one function, [`Scene::validate`].
//!
//! Conventions: geometry is `f64` in scene units ([`Units`] has their length), images are `f32`,
//! radiometric quantities are linear RGB ([`Rgb`]). Faces are counter-clockwise seen from their
//! front. Transforms are named `world_from_object`, so that products read by cancelling.
//!
//! ```
//! use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
//! use glam::DVec3;
//!
//! let mut scene = Scene::default();
//! let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.7)));
//! let mut mesh = Mesh::default();
//! mesh.positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
//! mesh.push_face(&[0, 1, 2], white);
//! scene.objects.push(Object::new("triangle", Shape::Mesh(mesh)));
//! scene.validate().unwrap();
//! ```

mod backplate;
mod bevel;
pub mod brdf;
mod camera;
mod containment;
pub mod content;
mod content_bytes;
mod coordinates;
mod crossings;
mod enclosure;
pub mod environment;
pub mod figure;
pub mod fresnel;
pub mod harmonics;
mod image;
mod instance;
mod irradiance;
mod light;
mod lightmap;
mod material;
pub mod math;
mod mesh;
mod opacity;
mod patch;
mod photometric_web;
mod primitive;
mod prism;
mod proxy;
pub mod quadrature;
pub mod random;
mod rgb;
pub mod rim;
mod rounding;
pub mod rtrace;
mod scene;
mod shape;
mod sides;
pub mod sky;
mod solid;
mod surface_maps;
pub mod synthetic;
mod text;
mod transform;
mod tree;
mod triangles;
mod triangulate;
mod unfolding;
mod units;
mod validate;

pub use backplate::{Backplate, BackplateFit};
pub use bevel::{Bevel, BevelClimb, BevelEnds, BevelProfile};
pub use brdf::Brdf;
pub use camera::Camera;
pub use coordinates::{CoordinateDigits, CoordinateRounding, PositionHistory};
pub use environment::{Environment, EnvironmentSource, Projection};
pub use figure::{Contour, Curve, Figure, FillRule};
pub use image::{Image, Texture, TextureId, WrapMode};
pub use instance::{MeshInstance, PlacedMesh, SharedMesh};
pub use irradiance::{Irradiance, ObjectIrradiance};
pub use light::{Light, LightKind};
pub use material::{Dielectric, Material, MaterialId, Sidedness};
pub use mesh::{Attribute, BackIrradiance, Faces, Mesh, VertexLight};
pub use opacity::{Opacity, OpacityChannel, OpacityMap, OpacityMode, OpacityPicture};
pub use patch::BicubicPatch;
pub use photometric_web::{PhotometricWeb, WebType};
pub use primitive::{Primitive, PrimitiveKind, SurfaceGrid, SurfaceLight, SurfacePoint};
pub use prism::Prism;
pub use proxy::Tiling;
pub use rgb::Rgb;
pub use rounding::rounded_number;
pub use rtrace::Rtrace;
pub use scene::{Fog, Object, Scene, SceneBackground, Zone};
pub use shape::Shape;
pub use solid::{Csg, Exact, FigureBounds, Leaf, Operation, Solid};
pub use surface_maps::{
    FinishMaps, IrradiancePicture, NumberMap, NumberPicture, PictureChannel, Relief, ReliefKind,
};
pub use text::{Align, Encoding, Font, Glyph, Letter, Line, PlacedGlyph, TextError, TextFrame};
pub use tree::{MeshTriangle, OnTriangle, TriangleTree};
pub use triangulate::MOST_FACE_CORNERS;
pub use units::{Units, Up};
pub use validate::Invalid;
