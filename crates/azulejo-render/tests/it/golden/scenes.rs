//! The scenes of the golden pictures, each of one feature: a floor, sun and sky, and something on
//! the floor. They carry no irradiance; final gathers find the light.

use azulejo_formats::outline::ppf;
use azulejo_scene::brdf::{Brdf, Description};
use azulejo_scene::{
    Attribute, Camera, Csg, Exact, Fog, Image, Light, LightKind, Material, MaterialId, Mesh,
    Object, Operation, Primitive, PrimitiveKind, Rgb, Scene, Shape, Solid, TextFrame, Texture,
};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, dvec2, dvec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A checked floor around the origin in y = 0 under sun and sky, and a camera in front of it.
fn stage() -> (Scene, Camera) {
    let mut scene = Scene::default();
    let checks = texture(&mut scene, 2, |x, y| {
        if (x + y) % 2 == 0 {
            [0.7, 0.7, 0.65]
        } else {
            [0.25, 0.3, 0.4]
        }
    });
    let mut floor = Material::diffuse("floor", Rgb::WHITE);
    floor.textures = vec![checks];
    let floor = scene.add_material(floor);
    let (corner, side) = (dvec3(-3.0, 0.0, -3.0), 6.0);
    sheet(
        &mut scene,
        corner,
        side * DVec3::Z,
        side * DVec3::X,
        4.0,
        floor,
    );
    scene.lights.push(Light {
        name: "sun".into(),
        kind: LightKind::Directional {
            direction: dvec3(-0.5, -1.0, -0.6).normalize(),
            irradiance: Rgb::new(3.2, 3.0, 2.6),
            half_angle: 0.0,
        },
    });
    scene.lights.push(Light {
        name: "sky".into(),
        kind: LightKind::Ambient {
            radiance: Rgb::new(0.25, 0.32, 0.45),
        },
    });
    let camera = Camera {
        name: String::new(),
        eye: dvec3(0.0, 1.8, 4.5),
        target: dvec3(0.0, 0.6, 0.0),
        up: DVec3::Y,
        vertical_fov: 0.6,
        size: None,
    };
    (scene, camera)
}

/// A picture of `n` × `n` pixels, linear.
fn texture(scene: &mut Scene, n: u32, color: impl Fn(u32, u32) -> [f32; 3]) -> u32 {
    let pixels = (0..n * n).map(|k| color(k % n, k / n)).collect();
    scene.textures.push(Texture {
        path: "made.png".into(),
        image: Some(Image {
            width: n,
            height: n,
            pixels,
            alpha: None,
        }),
        ..Texture::default()
    });
    scene.textures.len() as u32 - 1
}

/// A parallelogram, front toward `across × along`, over which textures repeat.
fn sheet(
    scene: &mut Scene,
    corner: DVec3,
    across: DVec3,
    along: DVec3,
    repeats: f64,
    material: MaterialId,
) {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let uvs = corners.map(|(u, v)| repeats * dvec2(u, v)).to_vec();
    let mut mesh = Mesh {
        positions: corners
            .map(|(u, v)| corner + u * across + v * along)
            .to_vec(),
        uvs: Some(Attribute::per_vertex(uvs)),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
}

fn add(scene: &mut Scene, primitive: Primitive) {
    let shape = Shape::Primitive(primitive);
    scene.objects.push(Object::new("primitive", shape));
}

fn ball(scene: &mut Scene, centre: DVec3, radius: f64, material: MaterialId) {
    add(scene, Primitive::sphere(centre, radius, material));
}

/// An axis-aligned box between two corners.
fn block(min: DVec3, max: DVec3, material: MaterialId) -> Primitive {
    let map = DAffine3 {
        matrix3: DMat3::from_diagonal(max - min),
        translation: min,
    };
    Primitive::new(PrimitiveKind::Cuboid, map, material)
}

/// A cylinder from `foot`, as long as `axis`.
fn cylinder(foot: DVec3, axis: DVec3, radius: f64, material: MaterialId) -> Primitive {
    let map = DAffine3::from_scale_rotation_translation(
        dvec3(radius, radius, axis.length()),
        DQuat::from_rotation_arc(DVec3::Z, axis.normalize()),
        foot,
    );
    Primitive::new(PrimitiveKind::Cylinder, map, material)
}

/// Three panels: a picture with up and right, the same with vertex colours, and two pictures
/// multiplied.
pub fn textures() -> (Scene, Camera) {
    let (mut scene, camera) = stage();
    // Red below, green on the left above, blue on the right above.
    let flag = texture(&mut scene, 2, |x, y| match (x, y) {
        (0, 0) => [0.1, 0.7, 0.1],
        (1, 0) => [0.1, 0.2, 0.8],
        _ => [0.8, 0.1, 0.1],
    });
    let stripes = texture(&mut scene, 8, |_, y| {
        [if y % 2 == 0 { 1.0 } else { 0.2 }; 3]
    });
    let mut panel = |textures: Vec<u32>, x: f64| {
        let mut material = Material::diffuse("panel", Rgb::grey(0.9));
        material.textures = textures;
        let material = scene.add_material(material);
        let corner = dvec3(x - 0.45, 0.1, -0.3);
        sheet(
            &mut scene,
            corner,
            0.9 * DVec3::X,
            1.2 * DVec3::Y,
            1.0,
            material,
        );
        scene.objects.len() - 1
    };
    panel(vec![flag], -1.0);
    let colored = panel(vec![flag], 0.0);
    panel(vec![flag, stripes], 1.0);
    if let Shape::Mesh(mesh) = &mut scene.objects[colored].shape {
        let yellow = Rgb::new(1.0, 0.8, 0.1);
        mesh.colors = vec![Rgb::WHITE, Rgb::WHITE, yellow, Rgb::grey(0.1)];
    }
    (scene, camera)
}

/// A ball of few faces around `centre`, with the ball's own normals or without any.
fn faceted_ball(centre: DVec3, radius: f64, has_normals: bool, material: MaterialId) -> Mesh {
    const AROUND: u32 = 10;
    const RINGS: u32 = 6;
    let normal = |ring: u32, k: u32| {
        let (sin, cos) = (PI * f64::from(ring) / f64::from(RINGS)).sin_cos();
        let (z, x) = (TAU * f64::from(k) / f64::from(AROUND)).sin_cos();
        dvec3(sin * x, cos, sin * z)
    };
    let normals: Vec<DVec3> = (0..=RINGS)
        .flat_map(|ring| (0..AROUND).map(move |k| normal(ring, k)))
        .collect();
    let mut mesh = Mesh {
        positions: normals.iter().map(|n| centre + radius * *n).collect(),
        normals: has_normals.then(|| Attribute::per_vertex(normals)),
        ..Mesh::default()
    };
    for ring in 0..RINGS {
        for k in 0..AROUND {
            let [a, b] = [k, (k + 1) % AROUND].map(|k| ring * AROUND + k);
            let [c, d] = [a, b].map(|v| v + AROUND);
            let face = [a, b, d, c];
            // Quadrangles at the poles have lost an edge.
            let corners = match ring {
                0 => &[a, d, c][..],
                r if r + 1 == RINGS => &[a, b, c],
                _ => &face,
            };
            mesh.push_face(corners, material);
        }
    }
    mesh
}

/// The same polygons without and with normals, as glossy paint and as mirrors.
pub fn normals() -> (Scene, Camera) {
    let (mut scene, camera) = stage();
    let paint = scene.add_material(Material::with_brdf(
        "paint",
        brdf("ward kd = 0.4 ks = 0.3 ax = 0.2 ay = 0.2"),
    ));
    let chrome = scene.add_material(Material::mirror("chrome", Rgb::grey(0.85)));
    for (x, y, has_normals, material) in [
        (-0.65, 0.45, false, paint),
        (0.65, 0.45, true, paint),
        (-0.65, 1.4, false, chrome),
        (0.65, 1.4, true, chrome),
    ] {
        let mesh = faceted_ball(dvec3(x, y, 0.0), 0.45, has_normals, material);
        scene.objects.push(Object::new("ball", Shape::Mesh(mesh)));
    }
    (scene, camera)
}

/// A glass ball, a green glass block and a thin pane before a red ball.
pub fn glass() -> (Scene, Camera) {
    let (mut scene, camera) = stage();
    let clear = scene.add_material(Material::dielectric("clear", 1.5));
    let mut green = Material::dielectric("green", 1.5);
    if let Some(dielectric) = &mut green.dielectric {
        dielectric.transmittance = Rgb::new(0.4, 0.9, 0.5);
    }
    let green = scene.add_material(green);
    let pane = scene.add_material(Material::pane("pane", 1.5));
    let red = scene.add_material(Material::diffuse("red", Rgb::new(0.7, 0.1, 0.08)));
    ball(&mut scene, dvec3(-0.75, 0.55, 0.4), 0.5, clear);
    add(
        &mut scene,
        block(dvec3(0.25, 0.05, 0.1), dvec3(0.75, 1.0, 0.5), green),
    );
    ball(&mut scene, dvec3(0.0, 0.4, -0.9), 0.4, red);
    ball(&mut scene, dvec3(1.3, 0.4, -0.6), 0.4, red);
    let corner = dvec3(0.95, 0.02, 0.3);
    sheet(
        &mut scene,
        corner,
        dvec3(0.7, 0.0, -0.3),
        1.3 * DVec3::Y,
        1.0,
        pane,
    );
    (scene, camera)
}

/// Two standing mirrors, one of them golden, that show each other and a ball.
pub fn mirror() -> (Scene, Camera) {
    let (mut scene, camera) = stage();
    let silver = scene.add_material(Material::mirror("silver", Rgb::grey(0.9)));
    let gold = scene.add_material(Material::mirror("gold", Rgb::new(0.9, 0.7, 0.3)));
    let blue = scene.add_material(Material::diffuse("blue", Rgb::new(0.1, 0.2, 0.7)));
    let left = dvec3(-1.5, 0.05, 0.4);
    sheet(
        &mut scene,
        left,
        dvec3(1.3, 0.0, -1.0),
        1.5 * DVec3::Y,
        1.0,
        silver,
    );
    let right = dvec3(0.2, 0.05, -0.6);
    sheet(
        &mut scene,
        right,
        dvec3(1.3, 0.0, 1.0),
        1.5 * DVec3::Y,
        1.0,
        gold,
    );
    ball(&mut scene, dvec3(0.1, 0.35, 0.5), 0.35, blue);
    ball(&mut scene, dvec3(0.75, 0.25, 0.9), 0.25, silver);
    (scene, camera)
}

fn brdf(text: &str) -> Arc<Brdf> {
    let description: Description = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
    Arc::new(Brdf::new(description).unwrap_or_else(|e| panic!("{text}: {e}")))
}

/// Three models on balls, over a glossy slab, under a lamp with an area.
pub fn gloss() -> (Scene, Camera) {
    let (mut scene, camera) = stage();
    let models = [
        "cook_torrance kd = 0.1 ks = 0.6 m = 0.3 metal = copper",
        "ward kd = 0.1 ks = 0.5 ax = 0.05 ay = 0.3",
        "phong kd = 0.3 ks = 0.3 n = 60",
    ];
    for (k, model) in models.into_iter().enumerate() {
        let material = scene.add_material(Material::with_brdf("gloss", brdf(model)));
        let centre = dvec3(k as f64 - 1.0, 0.5, 0.0);
        ball(&mut scene, centre, 0.42, material);
    }
    let slab = brdf("ward kd = 0.2 ks = 0.4 ax = 0.08 ay = 0.08");
    let slab = scene.add_material(Material::with_brdf("slab", slab));
    add(
        &mut scene,
        block(dvec3(-1.6, 0.0, -0.6), dvec3(1.6, 0.06, 1.0), slab),
    );
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::new(9.0, 8.0, 6.0)));
    let corner = dvec3(-0.6, 2.4, 0.5);
    sheet(
        &mut scene,
        corner,
        1.2 * DVec3::X,
        0.5 * DVec3::Z,
        1.0,
        lamp,
    );
    (scene, camera)
}

/// Extruded letters that stand on the floor.
pub fn text() -> (Scene, Camera) {
    let (mut scene, camera) = stage();
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/fonts/dejavu-serif.ppf"
    );
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let (font, _) = ppf::read(&bytes, path).expect("the example's font");
    let red = scene.add_material(Material::diffuse("red", Rgb::new(0.7, 0.15, 0.1)));
    let frame = TextFrame {
        origin: dvec3(-1.3, 0.02, 0.1),
        progression: DVec3::X,
        up: DVec3::Y,
        extrusion: DVec3::NEG_Z,
        scale: dvec3(1.35, 1.35, 0.3),
    };
    let mut pen = 0.0;
    let mut solids = Vec::new();
    for name in ["g", "ampersand", "B"] {
        let glyph = &font.glyphs[name];
        solids.push(Solid::Prism(azulejo_scene::Prism {
            figure: Arc::clone(&glyph.figure),
            world_from_figure: frame.world_from_glyph(DVec2::new(pen, 0.25)),
            material: red,
            bevel: None,
        }));
        pen += glyph.advance + 0.05;
    }
    let shape = Shape::Exact(Exact::new(solids));
    scene.objects.push(Object::new("letters", shape));
    (scene, camera)
}

/// Difference, intersection and union, with another material where the right operand cuts.
pub fn csg() -> (Scene, Camera) {
    let (mut scene, camera) = stage();
    let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.75)));
    let orange = scene.add_material(Material::diffuse("orange", Rgb::new(0.8, 0.4, 0.05)));
    let cube = |x: f64| block(dvec3(x - 0.4, 0.05, -0.4), dvec3(x + 0.4, 0.85, 0.4), white);
    let sphere = |x: f64, r: f64| Primitive::sphere(dvec3(x, 0.45, 0.0), r, orange);
    let drill = cylinder(dvec3(-1.0, 0.45, -1.0), 2.0 * DVec3::Z, 0.2, orange);
    let corner = Primitive::sphere(dvec3(-0.6, 0.85, 0.4), 0.3, orange);
    let mut operate = |operation, left: Primitive, right: Vec<Primitive>| {
        let csg = Csg {
            operation,
            left: vec![Solid::Primitive(left)],
            right: right.into_iter().map(Solid::Primitive).collect(),
        };
        let exact = Exact::new(vec![Solid::Csg(Box::new(csg))]);
        scene.objects.push(Object::new("csg", Shape::Exact(exact)));
    };
    operate(Operation::Difference, cube(-1.0), vec![drill, corner]);
    operate(Operation::Intersection, cube(0.1), vec![sphere(0.1, 0.5)]);
    operate(Operation::Union, cube(1.1), vec![sphere(1.1, 0.5)]);
    (scene, camera)
}

/// Columns that fade with their distance.
pub fn fog() -> (Scene, Camera) {
    let (mut scene, camera) = stage();
    let red = scene.add_material(Material::diffuse("red", Rgb::new(0.7, 0.15, 0.1)));
    for k in 0..5 {
        let z = 1.5 - 1.5 * f64::from(k);
        for x in [-0.9, 0.9] {
            add(
                &mut scene,
                cylinder(dvec3(x, 0.0, z), 1.2 * DVec3::Y, 0.15, red),
            );
        }
    }
    let color = Rgb::new(0.5, 0.55, 0.6);
    scene.fog = Some(Fog {
        color,
        visibility: 12.0,
        exponential: true,
    });
    scene.background = Some(color.into());
    (scene, camera)
}
