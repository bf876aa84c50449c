//! Scenes of exact shapes: letters in space, and what set operations make.

use super::add;
use azulejo::formats::ReadError;
use azulejo::formats::outline::{ppe, ppf};
use azulejo::scene::{
    Camera, Csg, Encoding, Exact, Font, Material, MaterialId, Object, Operation, Primitive,
    PrimitiveKind, Rgb, Scene, Shape, Solid, TextFrame,
};
use glam::{DAffine3, DMat3, DVec3};
use std::error::Error;

/// The typeface that comes with the examples, and its encoding.
fn typeface() -> Result<(Font, Encoding), ReadError> {
    let font = azulejo::typeface::DEJAVU_SERIF;
    let encoding = azulejo::typeface::LATIN;
    let (font, _) = ppf::read(font, "dejavu-serif.ppf")?;
    let (encoding, _) = ppe::read(encoding, "latin.ppe")?;
    Ok((font, encoding))
}

/// The prisms of a line, `depth` deep and turned toward +z, the middle of its foot at `middle`.
fn line(
    text: &str,
    middle: DVec3,
    depth: f64,
    material: MaterialId,
) -> Result<Vec<Solid>, Box<dyn Error>> {
    let (font, encoding) = typeface()?;
    let glyphs = font.lay_out(text, &encoding, 0.02)?;
    let ends = glyphs.iter().map(|g| g.pen.x + g.figure.bounds().max.x);
    let width = ends.fold(0.0, f64::max);
    let frame = TextFrame {
        origin: middle - 0.5 * width * DVec3::X,
        progression: DVec3::X,
        up: DVec3::Y,
        extrusion: DVec3::NEG_Z,
        scale: DVec3::new(1.0, 1.0, depth),
    };
    let prisms = frame.prisms(&glyphs, material);
    Ok(prisms.into_iter().map(Solid::Prism).collect())
}

fn add_solids(scene: &mut Scene, name: &str, solids: Vec<Solid>) {
    let shape = Shape::Exact(Exact::new(solids));
    scene.objects.push(Object::new(name, shape));
}

fn camera(eye: DVec3, target: DVec3) -> Camera {
    Camera {
        name: "front".into(),
        eye,
        target,
        up: DVec3::Y,
        vertical_fov: 30f64.to_radians(),
        size: Some((640, 360)),
    }
}

/// A word of solid letters over a polished floor, under a lamp with area.
pub fn title() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::default();
    let wall = scene.add_material(Material::diffuse("wall", Rgb::new(0.84, 0.82, 0.78)));
    let blue = scene.add_material(Material::diffuse("blue glaze", Rgb::new(0.05, 0.17, 0.6)));
    let floor = scene.add_material(Material {
        mirror: Rgb::grey(0.55),
        ..Material::diffuse("polished floor", Rgb::new(0.2, 0.19, 0.18))
    });
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::new(16.0, 15.0, 13.0)));
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    for (name, corner, edge1, edge2, material) in [
        ("floor", -5.0 * x - 2.0 * z, 9.0 * z, 10.0 * x, floor),
        ("wall", -5.0 * x - 2.0 * z, 10.0 * x, 5.0 * y, wall),
        (
            "lamp",
            -2.2 * x + 3.2 * y + 1.4 * z,
            1.8 * x,
            z - 0.6 * y,
            lamp,
        ),
    ] {
        let sheet = Primitive::parallelogram(corner, edge1, edge2, material);
        add(&mut scene, name, sheet);
    }
    let letters = line("azulejo", DVec3::new(0.0, 0.4, 0.0), 0.35, blue)?;
    add_solids(&mut scene, "title", letters);
    let view = camera(DVec3::new(0.7, 1.2, 4.6), DVec3::new(0.0, 0.5, 0.0));
    scene.cameras.push(view);
    Ok(scene)
}

/// A block into which the word is cut, and a die that is less than a box and more than a ball.
pub fn csg() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::default();
    let mut diffuse =
        |name, r, g, b| scene.add_material(Material::diffuse(name, Rgb::new(r, g, b)));
    let ground = diffuse("ground", 0.5, 0.48, 0.45);
    let stone = diffuse("stone", 0.7, 0.68, 0.62);
    let gilt = diffuse("gilt", 0.75, 0.5, 0.15);
    let clay = diffuse("clay", 0.65, 0.3, 0.2);
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::grey(18.0)));
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let sheet = Primitive::parallelogram(-6.0 * x - 4.0 * z, 10.0 * z, 12.0 * x, ground);
    add(&mut scene, "ground", sheet);
    let sheet = Primitive::parallelogram(-6.0 * x - 2.0 * z, 12.0 * x, 6.0 * y, ground);
    add(&mut scene, "wall", sheet);
    let sheet = Primitive::parallelogram(DVec3::new(-2.5, 5.0, 3.0), 3.0 * x, z - 0.5 * y, lamp);
    add(&mut scene, "lamp", sheet);
    add_solids(&mut scene, "tablet", vec![tablet(stone, gilt)?]);
    let die = die(DVec3::new(2.6, 0.5, 1.0), clay, gilt);
    add_solids(&mut scene, "die", vec![die]);
    let view = camera(DVec3::new(0.6, 2.6, 7.4), DVec3::new(0.5, 0.6, 0.0));
    scene.cameras.push(view);
    Ok(scene)
}

fn block(centre: DVec3, size: DVec3, material: MaterialId) -> Solid {
    let map = DAffine3::from_mat3_translation(DMat3::from_diagonal(size), centre - 0.5 * size);
    Solid::Primitive(Primitive::new(PrimitiveKind::Cuboid, map, material))
}

/// A block less the word, a quarter of a unit deep.
fn tablet(stone: MaterialId, gilt: MaterialId) -> Result<Solid, Box<dyn Error>> {
    // A hair in front of the block, so that the cut has no skin over it.
    let letters = line("azulejo", DVec3::new(0.0, 0.6, 0.301), 0.25, gilt)?;
    let size = DVec3::new(5.0, 1.8, 0.6);
    Ok(Solid::Csg(Box::new(Csg {
        operation: Operation::Difference,
        left: vec![block(DVec3::new(0.0, 0.9001, 0.0), size, stone)],
        right: letters,
    })))
}

/// A box and a ball, as much of both as they share, less a hole through each pair of sides.
fn die(centre: DVec3, clay: MaterialId, gilt: MaterialId) -> Solid {
    let ball = Solid::Primitive(Primitive::sphere(centre, 0.66, clay));
    let rounded = Solid::Csg(Box::new(Csg {
        operation: Operation::Intersection,
        left: vec![block(centre, DVec3::ONE, clay)],
        right: vec![ball],
    }));
    let hole = |axis: DVec3| {
        let (side, other) = axis.any_orthonormal_pair();
        let columns = DMat3::from_cols(0.25 * side, 0.25 * other, 1.4 * axis);
        let map = DAffine3::from_mat3_translation(columns, centre - 0.7 * axis);
        Solid::Primitive(Primitive::new(PrimitiveKind::Cylinder, map, gilt))
    };
    Solid::Csg(Box::new(Csg {
        operation: Operation::Difference,
        left: vec![rounded],
        right: [DVec3::X, DVec3::Y, DVec3::Z].map(hole).to_vec(),
    }))
}
