//! The scenes that are changed.

use super::dice::Dice;
use super::known_factors::cases;
use azulejo::models;
use azulejo_factors::form_factors::Plan;
use azulejo_factors::{FormFactorOptions, PatchSize};
use azulejo_scene::synthetic::{self, CornellVariant};
use azulejo_scene::{
    Light, LightKind, Material, MaterialId, Mesh, Object, Rgb, Scene, Shape, Units,
};
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// A scene with a name.
#[derive(Clone, Debug)]
pub struct PosedScene {
    /// Its name in tables and in names of poses.
    pub name: String,
    /// The scene; its objects are called `part0`, `part1` and so on.
    pub scene: Scene,
    /// Whether no two faces lie in one place, whichever way they look.
    is_apart: bool,
}

/// What a scene is, as far as commands need to know.
#[derive(Clone, Copy, Debug)]
pub struct SceneTraits {
    /// Faces of meshes.
    pub faces: usize,
    /// Whether all shapes are meshes.
    pub is_polygonal: bool,
    /// Whether there are mirrors, glass or reflection models.
    pub is_specular: bool,
    /// Whether there is light.
    pub is_lit: bool,
    /// Whether some of it is from lights without area.
    pub has_lights: bool,
    /// Whether faces have a place of their own, so that both of their sides do.
    pub is_apart: bool,
}

/// A family of scenes, drawn from with equal chance.
pub type SceneFamily = Vec<PosedScene>;

/// Most faces of a model of the corpus, and most bytes of its file.
const MODEL_FACES: usize = 200;
const MODEL_BYTES: u64 = 60_000;

/// Models of the corpus, and most of one format.
const MODELS: usize = 30;
const MODELS_OF_A_FORMAT: usize = 4;

/// All families: made by formulas, with known answers, of the folder `examples`, and of the corpus if it takes part
/// and is there.
pub fn families(has_corpus: bool) -> Vec<SceneFamily> {
    let corpus = if has_corpus { corpus() } else { Vec::new() };
    let families = [made(), known(), examples(), corpus];
    families.into_iter().filter(|f| !f.is_empty()).collect()
}

impl PosedScene {
    fn new(name: impl Into<String>, scene: Scene) -> PosedScene {
        PosedScene {
            name: name.into(),
            scene: plain(scene),
            is_apart: true,
        }
    }

    /// What it is.
    pub fn traits(&self) -> SceneTraits {
        let meshes = self.scene.objects.iter().map(|o| o.shape.mesh());
        let is_matt = |m: &Material| m.mirror.is_black() && m.dielectric.is_none();
        let mut materials = self.scene.materials.iter();
        SceneTraits {
            faces: meshes.clone().flatten().map(|m| m.faces.len()).sum(),
            is_polygonal: meshes.clone().all(|m| m.is_some()),
            is_specular: materials.any(|m| !is_matt(m) || m.brdf.is_some()),
            is_lit: self.scene.has_light(),
            has_lights: !self.scene.lights.is_empty(),
            is_apart: self.is_apart,
        }
    }
}

/// Scenes made here and by `azulejo_scene::synthetic`.
fn made() -> SceneFamily {
    let mut scenes = vec![
        PosedScene::new("cube", sides_apart(&synthetic::cube_room(), 6)),
        PosedScene::new("open box", sides_apart(&synthetic::cube_room(), 5)),
        PosedScene::new("cube as one", synthetic::cube_room()),
        PosedScene::new("squares", squares()),
        PosedScene::new("L room", l_room()),
        PosedScene::new("prism", prism(6)),
        PosedScene::new("duct", prism(3)),
        PosedScene::new("sheet", sheet()),
        PosedScene::new("ball", synthetic::displaced_sphere(160)),
        PosedScene::new("cubes", synthetic::cube_array(2, 1)),
        PosedScene::new("table", synthetic::room_with_table(136)),
        PosedScene::new("mirrors", synthetic::cornell_thesis_at(4, 0.01)),
    ];
    let boxes = [
        ("cornell", CornellVariant::Diffuse),
        ("mirror block", CornellVariant::MirrorBlock),
    ];
    let boxes = boxes.map(|(name, variant)| PosedScene::new(name, synthetic::cornell_box(variant)));
    scenes.extend(boxes);
    scenes
}

/// The cases whose form factors are known.
fn known() -> SceneFamily {
    let scenes = cases().into_iter();
    let scenes = scenes.map(|case| PosedScene::new(format!("truth {}", case.id), case.scene));
    scenes.filter(|s| s.traits().faces <= MODEL_FACES).collect()
}

/// The models in the folder `examples` of the project.
fn examples() -> SceneFamily {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
    let files = files_below(Path::new(folder), 1).into_iter();
    // The screen of box.vs3 is two sheets back to back: with two sides each, four in one place.
    let is_model = |path: &PathBuf| path.extension().is_some_and(|e| e == "grf");
    files.filter(is_model).filter_map(|p| model(&p)).collect()
}

/// Small models of the folder `corpus` in `AZULEJO_DATA`, in even light.
fn corpus() -> SceneFamily {
    let Some(data) = std::env::var_os("AZULEJO_DATA") else {
        return Vec::new();
    };
    let folder = Path::new(&data).join("corpus");
    let mut files = files_below(&folder, 8);
    Dice::new(0, "corpus").shuffle(&mut files);
    let mut scenes = Vec::new();
    let mut counts = std::collections::HashMap::<_, usize>::new();
    for path in files {
        let is_small = std::fs::metadata(&path).is_ok_and(|m| m.len() <= MODEL_BYTES);
        let format = path.extension().map(|e| e.to_ascii_lowercase());
        let count = counts.entry(format).or_default();
        if !is_small || *count == MODELS_OF_A_FORMAT {
            continue;
        }
        let Some(mut posed) = model(&path) else {
            continue;
        };
        let traits = posed.traits();
        if traits.is_polygonal && (2..=MODEL_FACES).contains(&traits.faces) {
            *count += 1;
            posed.scene = in_even_light(posed.scene);
            scenes.push(posed);
        }
        if scenes.len() == MODELS {
            break;
        }
    }
    scenes
}

/// Files of a folder and of those in it, in the order of their names.
fn files_below(folder: &Path, depth: usize) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|e| e.path()).collect();
    paths.sort();
    let mut files = Vec::new();
    for path in paths {
        match path.is_dir() {
            true if depth > 1 => files.extend(files_below(&path, depth - 1)),
            true => {}
            false => files.push(path),
        }
    }
    files
}

/// A model, named by its folder and file; `None` if it cannot be read.
fn model(path: &Path) -> Option<PosedScene> {
    let model = models::read(path, &models::Reading::default(), &Progress::new()).ok()?;
    let file = path.file_name()?.to_string_lossy().into_owned();
    let folder = path.parent().and_then(Path::file_name)?.to_string_lossy();
    let mut posed = PosedScene::new(format!("{folder}/{file}"), model.scene);
    posed.scene.validate().ok()?;
    posed.is_apart = !has_flaws(&posed.scene, true);
    (!has_flaws(&posed.scene, false)).then_some(posed)
}

/// Whether faces overlap in one plane: which of them light meets is then chance, and another in each pose.
fn has_flaws(scene: &Scene, two_sided: bool) -> bool {
    let options = FormFactorOptions {
        size: PatchSize::FlatWhole(256),
        two_sided,
        ..FormFactorOptions::default()
    };
    let tracer = Tracer::new(scene);
    Plan::new(scene, &tracer, &options).is_ok_and(|plan| !plan.flaws().is_empty())
}

/// Without pictures and stored light, with a name for each object and a mesh for each instance.
fn plain(mut scene: Scene) -> Scene {
    scene.unfold();
    scene.rtrace = None;
    scene.background = None;
    scene.textures.clear();
    let is_kept = |light: &Light| !matches!(light.kind, LightKind::Environment(_));
    scene.lights.retain(is_kept);
    for (k, object) in scene.objects.iter_mut().enumerate() {
        object.name = format!("part{k}");
        match &mut object.shape {
            Shape::Mesh(mesh) => *mesh = bare(std::mem::take(mesh)),
            Shape::Primitive(p) => p.light = None,
            Shape::Exact(exact) => exact.proxy = None,
            Shape::Instance(_) => {}
        }
    }
    for (k, material) in scene.materials.iter_mut().enumerate() {
        *material = Material {
            name: format!("material{k}"),
            diffuse: material.diffuse,
            mirror: material.mirror,
            dielectric: material.dielectric,
            emission: material.emission,
            emits_back: material.emits_back,
            brdf: material.brdf.clone(),
            ..Material::default()
        };
    }
    scene
}

/// Positions, normals and faces alone.
fn bare(mesh: Mesh) -> Mesh {
    Mesh {
        positions: mesh.positions,
        normals: mesh.normals,
        faces: mesh.faces,
        face_materials: mesh.face_materials,
        ..Mesh::default()
    }
}

/// Matt and grey, below the same radiance all around.
fn in_even_light(mut scene: Scene) -> Scene {
    for material in &mut scene.materials {
        *material = Material::diffuse(material.name.clone(), Rgb::grey(0.5));
    }
    scene.lights = vec![Light {
        name: "sky".into(),
        kind: LightKind::Ambient {
            radiance: Rgb::grey(1.0),
        },
    }];
    scene
}

/// An object for each of the first faces of the first object.
fn sides_apart(scene: &Scene, count: usize) -> Scene {
    let mut apart = Scene {
        objects: Vec::new(),
        ..scene.clone()
    };
    if let Some(mesh) = scene.objects.first().and_then(|o| o.shape.mesh()) {
        for face in 0..count.min(mesh.faces.len()) {
            add_face(&mut apart, &mesh.face_positions(face), 0);
        }
    }
    apart
}

fn add_face(scene: &mut Scene, corners: &[DVec3], material: MaterialId) {
    let mut mesh = Mesh {
        positions: corners.to_vec(),
        ..Mesh::default()
    };
    let ring: Vec<u32> = (0..corners.len() as u32).collect();
    mesh.push_face(&ring, material);
    scene.objects.push(Object::new("", Shape::Mesh(mesh)));
}

/// Two unit squares, one above the other, that face each other.
fn squares() -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let square =
        |z: f64| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, z));
    let mut above = square(1.0);
    above.reverse();
    add_face(&mut scene, &square(0.0), grey);
    add_face(&mut scene, &above, grey);
    scene
}

/// A closed prism over a polygon, counter-clockwise from above, seen from inside: floor, ceiling, walls.
fn room(outline: &[[f64; 2]], height: f64) -> Scene {
    let mut scene = Scene {
        units: Units {
            metres_per_unit: Some(1.0),
            ..Units::default()
        },
        ..Scene::default()
    };
    let grey = scene.add_material(Material::diffuse("grey", Rgb::new(0.7, 0.6, 0.5)));
    let at = |[x, y]: [f64; 2], z: f64| DVec3::new(x, y, z);
    let floor: Vec<DVec3> = outline.iter().map(|&p| at(p, 0.0)).collect();
    let ceiling: Vec<DVec3> = outline.iter().rev().map(|&p| at(p, height)).collect();
    add_face(&mut scene, &floor, grey);
    add_face(&mut scene, &ceiling, grey);
    for (k, &p) in outline.iter().enumerate() {
        let q = outline[(k + 1) % outline.len()];
        let wall = [at(q, 0.0), at(p, 0.0), at(p, height), at(q, height)];
        add_face(&mut scene, &wall, grey);
    }
    scene
}

/// A room with a corner cut out of it, so that two walls are hidden from others, and a lamp.
fn l_room() -> Scene {
    let outline = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 2.0],
        [2.0, 2.0],
        [2.0, 5.0],
        [0.0, 5.0],
    ];
    let mut scene = room(&outline, 2.5);
    let lamp = scene.add_material(Material {
        emission: Rgb::new(10.0, 9.0, 7.0),
        ..Material::diffuse("lamp", Rgb::BLACK)
    });
    let corners = [[0.5, 3.5], [0.5, 4.5], [1.5, 4.5], [1.5, 3.5]];
    let corners = corners.map(|[x, y]| DVec3::new(x, y, 2.4));
    add_face(&mut scene, &corners, lamp);
    scene
}

/// A regular prism, seen from inside.
fn prism(sides: u32) -> Scene {
    let corner = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(sides);
        [angle.cos(), angle.sin()]
    };
    let outline: Vec<[f64; 2]> = (0..sides).map(corner).collect();
    room(&outline, 1.5)
}

/// A room that a sheet without thickness divides in part, with a lamp on one side.
fn sheet() -> Scene {
    let mut scene = room(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]], 2.0);
    let at = |y: f64, z: f64| DVec3::new(1.25, y, z);
    let corners = [at(0.25, 0.0), at(2.0, 0.0), at(2.0, 1.5), at(0.25, 1.5)];
    add_face(&mut scene, &corners, 0);
    let lamp = scene.add_material(Material {
        emission: Rgb::grey(5.0),
        ..Material::diffuse("lamp", Rgb::BLACK)
    });
    let corners = [[2.0, 0.5], [2.0, 1.5], [2.5, 1.5], [2.5, 0.5]];
    let corners = corners.map(|[x, y]| DVec3::new(x, y, 1.9));
    add_face(&mut scene, &corners, lamp);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_valid_and_differ_in_name() {
        let scenes: Vec<PosedScene> = [made(), known()].concat();
        let mut names: Vec<&str> = scenes.iter().map(|s| s.name.as_str()).collect();
        for posed in &scenes {
            posed.scene.validate().unwrap();
        }
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), scenes.len());
    }

    /// Rooms are seen from inside.
    #[test]
    fn rooms_face_inwards() {
        for (scene, volume) in [(l_room(), 35.0), (prism(6), 1.5 * 1.5 * 3f64.sqrt())] {
            let mut whole = Mesh::default();
            for object in scene.objects.iter().filter(|o| {
                let mesh = o.shape.mesh().unwrap();
                mesh.face_materials[0] == 0
            }) {
                let first = whole.positions.len() as u32;
                let mesh = object.shape.mesh().unwrap();
                whole.positions.extend(&mesh.positions);
                let ring: Vec<u32> = mesh.faces.get(0).iter().map(|v| v + first).collect();
                whole.push_face(&ring, 0);
            }
            let enclosed = whole.enclosed_volume().unwrap();
            assert!((enclosed + volume).abs() < 1e-9, "{enclosed} {volume}");
        }
    }
}
