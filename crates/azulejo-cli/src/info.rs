//! `info`: what is in a model.

use super::failure::Failure;
use super::input::{self, ClockArgs, InputArgs};
use super::inventory::Inventory;
use super::luminaires;
use super::pass::power_unit;
use super::report::{Report, count, number, numbers, short, triple};
use super::session::Session;
use azulejo::output::Output;
use azulejo_scene::math::Aabb;
use azulejo_scene::{
    LightKind, MaterialId, Mesh, Object, PlacedMesh, PrimitiveKind, Rgb, Scene, Shape, Up,
};
use clap::{Args, ValueEnum, ValueHint};
use glam::DVec3;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;
use std::path::PathBuf;
use std::sync::Arc;

/// `info`
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Print one row for each model instead: size, objects, materials, vertices, faces, size as GRF and
    /// their ratio, as Table 1 of the paper on GRF
    #[arg(long, conflicts_with = "lights")]
    pub table: bool,
    /// Format of the table
    #[arg(
        long,
        value_name = "FORMAT",
        default_value = "text",
        requires = "table"
    )]
    pub format: TableFormat,
    /// Write a polar plot of the luminaires (.svg), the aim downwards
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "table")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub clock: ClockArgs,
    #[command(flatten)]
    pub input: InputArgs,
}

/// `info --format`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TableFormat {
    /// Aligned columns
    Text,
    /// Values separated by commas, sizes in bytes
    Csv,
    /// A table in Markdown
    Markdown,
}

/// Examples below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo info room.3ds
  azulejo info drawing.dxf --strict
  azulejo info --table *.3ds *.obj --format markdown
  azulejo info f.npz
  azulejo info downlight.ies -o polar.svg
  azulejo info room.grf --json | python3 -m json.tool";

/// Objects listed in the text; the JSON has all of them.
const LISTED: usize = 20;

/// The properties of one object.
#[derive(Default)]
struct ObjectSummary<'s> {
    kind: &'static str,
    /// The parts of an exact shape, other than a primitive.
    inventory: Option<Inventory<'s>>,
    /// Number of different materials.
    materials: usize,
    vertices: usize,
    faces: usize,
    triangles: usize,
    area: f64,
    /// Inside a closed mesh; negative if its fronts are inside, as those of a room.
    volume: Option<f64>,
    /// Emitted power per channel, W; `None` for an object that does not emit.
    power: Option<Rgb>,
    solved: bool,
}

/// Runs `info`.
pub fn run(args: &InfoArgs, session: &mut Session) -> Result<Report, Failure> {
    session.list_warnings();
    let output = args.output.as_deref().map(Output::check).transpose()?;
    session.claim_stdout(output.as_ref().is_some_and(Output::is_stdout))?;
    let scene = input::read_all(&args.input, args.clock, session)?;
    // The mean of a picture is near enough here to what shines of it.
    let scene = scene.with_even_emission().unwrap_or(scene);
    let parts: Vec<ObjectSummary<'_>> = scene.objects.iter().map(|o| part(&scene, o)).collect();
    let mut report = Report::default();
    source(&args.input, session, &mut report);
    contents(&scene, &parts, &mut report);
    extent(&scene, &parts, &mut report);
    lights(&scene, &parts, &mut report);
    luminaires::describe(&scene, &mut report);
    if let Some(output) = output {
        let plot = luminaires::plot(&scene);
        let plot =
            plot.ok_or_else(|| Failure::failed("--output: there is no luminaire to plot"))?;
        output.write(session.progress(), |out| out.write_all(plot.as_bytes()))?;
        let path = output.path().display().to_string();
        report.fact("output", path.clone(), "wrote", path);
    }
    viewpoints(&scene, &mut report);
    let solved = scene.is_solved();
    let mapped = (scene.objects.iter())
        .filter(|o| scene.is_lightmapped(&o.shape))
        .count();
    let words = match (mapped, solved) {
        (0, true) => "stored on the vertices".to_owned(),
        (0, false) => "not solved yet".to_owned(),
        (mapped, _) => format!("in lightmaps, of {mapped} of {} objects", parts.len()),
    };
    report.fact("solved", solved, "irradiance", words);
    report.value("lightmapped_objects", mapped);
    inverted(&scene, &mut report);
    if session.json() {
        list(&scene, &parts, &mut report);
    }
    for row in table(&scene, &parts) {
        report.plain(row);
    }
    skipped(session, &mut report);
    Ok(report)
}

/// The files and their formats; in the JSON a single name if there is one file.
fn source(input: &InputArgs, session: &Session, report: &mut Report) {
    let files: Vec<String> = input
        .scenes
        .iter()
        .map(|p| p.display().to_string())
        .collect();
    let formats: Vec<&str> = session.formats().iter().map(|f| f.name()).collect();
    report.line("file", files.join(", "));
    report.line("format", formats.join(", "));
    match (&files[..], &formats[..]) {
        ([file], [format]) => {
            report.value("file", file.clone());
            report.value("format", *format);
        }
        _ => {
            report.value("file", files);
            report.value("format", formats);
        }
    }
}

/// What the readers skipped or repaired; the JSON has it in `warnings`.
fn skipped(session: &Session, report: &mut Report) {
    if session.listed().is_empty() {
        return;
    }
    report.plain("");
    report.plain("skipped or repaired");
    session
        .listed()
        .iter()
        .for_each(|w| report.plain(w.clone()));
}

fn part<'s>(scene: &'s Scene, object: &'s Object) -> ObjectSummary<'s> {
    match &object.shape {
        Shape::Mesh(_) | Shape::Instance(_) => {
            let placed = object.shape.placed_mesh();
            placed.map_or_else(ObjectSummary::default, |placed| ObjectSummary {
                solved: !placed.irradiance.is_empty() || scene.is_lightmapped(&object.shape),
                ..mesh_part(scene, &placed)
            })
        }
        Shape::Exact(exact) => {
            let areas = exact.areas(1e-3 * exact.bounds().diagonal());
            let power = areas.iter().map(|(&m, a)| emission(scene, m) * (PI * a));
            let power: Rgb = power.sum();
            let inventory = Inventory::of(exact);
            let materials: Vec<MaterialId> = exact.leaves().iter().map(|l| l.material()).collect();
            ObjectSummary {
                kind: inventory.kind(exact),
                inventory: Some(inventory),
                materials: different(&materials),
                area: areas.values().sum(),
                power: (!power.is_black()).then_some(power),
                solved: exact.proxy.is_some(),
                ..ObjectSummary::default()
            }
        }
        Shape::Primitive(p) => {
            let emitted = emission(scene, p.material);
            let area = p.area();
            ObjectSummary {
                kind: kind_name(p.kind),
                materials: 1,
                area,
                power: (!emitted.is_black()).then_some(emitted * (PI * area)),
                solved: p.light.is_some(),
                ..ObjectSummary::default()
            }
        }
    }
}

/// The properties of a mesh but for its light.
fn mesh_part<'s>(scene: &Scene, placed: &PlacedMesh) -> ObjectSummary<'s> {
    let mesh = placed.mesh;
    let mut power = Rgb::BLACK;
    let mut area = 0.0;
    for (face, &m) in mesh.face_materials.iter().enumerate() {
        let a = placed.face_area_vector(face).length();
        area += a;
        power += emission(scene, m) * (PI * a);
    }
    let mut materials = mesh.face_materials.iter();
    let emits = materials.any(|&m| !emission(scene, m).is_black());
    let map = placed.world_from_mesh();
    ObjectSummary {
        kind: if map.is_some() { "instance" } else { "mesh" },
        materials: different(&mesh.face_materials),
        vertices: mesh.positions.len(),
        faces: mesh.faces.len(),
        triangles: mesh.faces.triangle_count(),
        area,
        volume: mesh
            .enclosed_volume()
            .map(|volume| volume * map.map_or(1.0, |map| map.matrix3.determinant())),
        power: emits.then_some(power),
        ..ObjectSummary::default()
    }
}

/// The radiance that a material emits, of both sides together.
fn emission(scene: &Scene, material: MaterialId) -> Rgb {
    let material = &scene.materials[material as usize];
    material.emission_from(true) + material.emission_from(false)
}

fn different(materials: &[MaterialId]) -> usize {
    materials.iter().collect::<HashSet<_>>().len()
}

fn kind_name(kind: PrimitiveKind) -> &'static str {
    match kind {
        PrimitiveKind::Sphere => "sphere",
        PrimitiveKind::Cylinder => "cylinder",
        PrimitiveKind::Cone { .. } => "cone",
        PrimitiveKind::Tube { .. } => "tube",
        PrimitiveKind::Cuboid => "box",
        PrimitiveKind::Square => "parallelogram",
    }
}

fn contents(scene: &Scene, parts: &[ObjectSummary<'_>], report: &mut Report) {
    let sum = |f: fn(&ObjectSummary<'_>) -> usize| parts.iter().map(f).sum::<usize>();
    let count_of = |kind: &str| parts.iter().filter(|p| p.kind == kind).count();
    let instances = count_of("instance");
    let exact = parts.len() - count_of("mesh") - instances;
    let shared = scene.shared_meshes().len();
    let mut words = count(parts.len());
    if exact > 0 {
        words += &format!(", {} of them exact shapes", count(exact));
    }
    if instances > 0 {
        let meshes = if shared == 1 { "mesh" } else { "meshes" };
        let (instances, shared) = (count(instances), count(shared));
        words += &format!(", {instances} of them instances of {shared} {meshes}");
    }
    report.fact("objects", parts.len(), "objects", words);
    report.value("exact_shapes", exact);
    report.value("instances", instances);
    report.value("shared_meshes", shared);
    figures(scene, parts, report);
    for (key, n) in [
        ("materials", scene.materials.len()),
        ("textures", scene.textures.len()),
        ("vertices", sum(|p| p.vertices)),
        ("faces", sum(|p| p.faces)),
        ("triangles", sum(|p| p.triangles)),
    ] {
        report.fact(key, n, key, count(n));
    }
}

/// The solids of exact shapes and the figures that they share.
fn figures(scene: &Scene, parts: &[ObjectSummary<'_>], report: &mut Report) {
    let mut totals = Inventory::default();
    for (object, part) in scene.objects.iter().zip(parts) {
        if let (Shape::Exact(exact), Some(inventory)) = (&object.shape, &part.inventory) {
            totals.add(inventory, exact);
        }
    }
    if totals.prisms > 0 {
        let [prisms, figures, curves] = [totals.prisms, totals.figures(), totals.curves].map(count);
        let words = format!("{prisms} of {figures} different figures, {curves} curves");
        report.line("prisms", words);
    }
    report.value("solids", totals.solids);
    report.value("prisms", totals.prisms);
    report.value("figures", totals.figures());
    report.value("curves", totals.curves);
}

fn extent(scene: &Scene, parts: &[ObjectSummary<'_>], report: &mut Report) {
    let Aabb { min, max } = scene.bounds();
    let light = if scene.units.photometric {
        "cd/m² and lux"
    } else {
        "W/(sr·m²) and W/m²"
    };
    let length = match scene.units.metres_per_unit {
        Some(metres) => format!("1 unit is {} m", short(metres)),
        None => "lengths without unit, taken as m".into(),
    };
    let up = match scene.units.up {
        Up::Y => "y",
        Up::Z => "z",
    };
    report.line("units", format!("{length}; {up} is up; light in {light}"));
    report.value("metres_per_unit", scene.units.metres_per_unit.map(number));
    report.value("up", up);
    report.value("photometric", scene.units.photometric);
    if scene.bounds().is_empty() {
        report.fact("bounds", Value::Null, "bounds", "empty");
    } else {
        let (min, max) = (min.to_array(), max.to_array());
        let words = format!("{} to {}", triple(min), triple(max));
        let value = json!({ "min": numbers(min), "max": numbers(max) });
        report.fact("bounds", value, "bounds", words);
    }
    // Adding zero, because the sum of nothing is -0.
    let area = parts.iter().map(|p| p.area).sum::<f64>() + 0.0;
    report.fact(
        "area",
        number(area),
        "area",
        format!("{} square units", short(area)),
    );
}

fn lights(scene: &Scene, parts: &[ObjectSummary<'_>], report: &mut Report) {
    // Objects that emit are lamps with an area; the power is theirs alone.
    let lamps: Vec<&ObjectSummary<'_>> = parts.iter().filter(|p| p.power.is_some()).collect();
    let power: Rgb = lamps.iter().filter_map(|p| p.power).sum();
    // Count the other lights by their kind.
    let mut kinds = [
        ("point", 0),
        ("spot", 0),
        ("directional", 0),
        ("ambient", 0),
        ("environment", 0),
        ("luminaire", 0),
    ];
    for light in &scene.lights {
        let kind = match light.kind {
            LightKind::Point { .. } => 0,
            LightKind::Spot { .. } => 1,
            LightKind::Directional { .. } => 2,
            LightKind::Ambient { .. } => 3,
            LightKind::Environment(_) => 4,
            LightKind::Luminaire { .. } => 5,
        };
        kinds[kind].1 += 1;
    }
    // The line names only the kinds that the scene has; the JSON has all of them.
    let mut words: Vec<String> = Vec::new();
    if !lamps.is_empty() {
        let n = count(lamps.len());
        let unit = power_unit(scene.units);
        words.push(format!(
            "{n} with area, {} {unit}",
            triple(power.to_array())
        ));
    }
    let named = kinds.iter().filter(|(_, n)| *n > 0);
    words.extend(named.map(|(name, n)| format!("{} {name}", count(*n))));
    let words = if words.is_empty() {
        "none".into()
    } else {
        words.join("; ")
    };
    report.line("lights", words);
    let mut value = json!({ "area": lamps.len(), "area_power": numbers(power.to_array()) });
    for (name, n) in kinds {
        value[name] = json!(n);
    }
    report.value("lights", value);
}

/// Closed meshes whose front is inside, with nothing in there that could see it.
fn inverted(scene: &Scene, report: &mut Report) {
    let boxes: Vec<Aabb> = scene.objects.iter().map(Object::bounds).collect();
    let things = enclosable(scene, &boxes);
    let is_room = |k: usize| {
        let within = AABB::from_corners(boxes[k].min.to_array(), boxes[k].max.to_array());
        let mut inside = things.locate_in_envelope(&within);
        inside.any(|thing| thing.data != Some(k))
    };
    let is_inside_out = |mesh: &Mesh| mesh.enclosed_volume().is_some_and(|volume| volume < 0.0);
    // Each shared mesh once.
    let shared = scene.shared_meshes().into_iter();
    let shared: HashMap<*const Mesh, bool> = shared
        .map(|mesh| (Arc::as_ptr(mesh), is_inside_out(mesh)))
        .collect();
    let is_turned = |object: &Object| match &object.shape {
        Shape::Mesh(mesh) => is_inside_out(mesh),
        Shape::Instance(instance) => shared[&Arc::as_ptr(&instance.mesh)],
        Shape::Primitive(_) | Shape::Exact(_) => false,
    };
    let turned = scene.objects.iter().enumerate();
    let names: Vec<&str> = turned
        .filter(|(k, object)| is_turned(object) && !is_room(*k))
        .map(|(_, object)| object.name.as_str())
        .collect();
    if !names.is_empty() {
        let words = format!(
            "{} closed and {} front is inside, with nothing else there: turned inside out, or an empty room: {}",
            if names.len() == 1 {
                "a mesh is"
            } else {
                "meshes are"
            },
            if names.len() == 1 { "its" } else { "their" },
            quoted(&names)
        );
        report.line("inverted", words);
    }
    report.value("inverted", names);
}

/// What may be inside of an object: the boxes of all objects, by their numbers, cameras and lights.
fn enclosable(
    scene: &Scene,
    boxes: &[Aabb],
) -> RTree<GeomWithData<Rectangle<[f64; 3]>, Option<usize>>> {
    let entry = |min: DVec3, max: DVec3, object| {
        GeomWithData::new(
            Rectangle::from_corners(min.to_array(), max.to_array()),
            object,
        )
    };
    let objects = boxes.iter().enumerate().filter(|(_, b)| !b.is_empty());
    let lights = scene.lights.iter().filter_map(|l| l.kind.position());
    let places = scene.cameras.iter().map(|c| c.eye).chain(lights);
    let objects = objects.map(|(k, b)| entry(b.min, b.max, Some(k)));
    RTree::bulk_load(objects.chain(places.map(|p| entry(p, p, None))).collect())
}

fn viewpoints(scene: &Scene, report: &mut Report) {
    let names: Vec<&str> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    let words = match names.len() {
        0 => "none".to_owned(),
        n => format!("{}: {}", count(n), quoted(&names)),
    };
    report.line("cameras", words);
    report.value("cameras", names);
}

fn quoted(names: &[&str]) -> String {
    let mut words: Vec<String> = names
        .iter()
        .take(LISTED)
        .map(|n| format!("\"{n}\""))
        .collect();
    if names.len() > LISTED {
        words.push("…".into());
    }
    words.join(", ")
}

/// Every object, for the JSON alone: it takes twice the memory of an object.
fn list(scene: &Scene, parts: &[ObjectSummary<'_>], report: &mut Report) {
    let list = scene.objects.iter().zip(parts).map(|(object, part)| {
        let mut value = json!({
            "name": object.name,
            "kind": part.kind,
            "materials": part.materials,
            "vertices": part.vertices,
            "faces": part.faces,
            "triangles": part.triangles,
            "area": number(part.area),
            "volume": part.volume.map(number),
            "emits": part.power.is_some(),
            "solved": part.solved,
        });
        if let Some(inventory) = &part.inventory {
            value["content"] = json!(inventory.words());
            value["solids"] = json!(inventory.solids);
            value["operations"] = json!(inventory.operations);
            value["prisms"] = json!(inventory.prisms);
            value["figures"] = json!(inventory.figures());
            value["curves"] = json!(inventory.curves);
        }
        value
    });
    report.value("object_list", list.collect::<Vec<_>>());
}

/// The first objects as rows of aligned columns under a heading.
fn table(scene: &Scene, parts: &[ObjectSummary<'_>]) -> Vec<String> {
    if parts.is_empty() {
        return Vec::new();
    }
    let shown = scene.objects.iter().zip(parts).take(LISTED);
    let names: Vec<String> = shown.clone().map(|(o, _)| shortened(&o.name)).collect();
    let width = names
        .iter()
        .map(|n| n.chars().count())
        .max()
        .unwrap_or(0)
        .max(6);
    let row = |name: &str, kind: &str, rest: [&str; 5]| {
        let [vertices, faces, triangles, area, volume] = rest;
        format!(
            "{name:<width$}  {kind:<13} {vertices:>11} {faces:>11} {triangles:>11} {area:>12} {volume:>12}"
        )
    };
    let heading = row(
        "object",
        "kind",
        ["vertices", "faces", "triangles", "area", "volume"],
    );
    let mut rows = vec![String::new(), heading];
    rows.extend(shown.zip(&names).map(|((_, p), name)| {
        let counts = [p.vertices, p.faces, p.triangles].map(count);
        let [v, f, t] = &counts;
        let mark = if p.power.is_some() { " lamp" } else { "" };
        let content = p.inventory.as_ref().map(Inventory::words);
        let content = content.map_or_else(String::new, |words| format!("  {words}"));
        let volume = p.volume.map_or_else(String::new, short);
        let row = row(name, p.kind, [v, f, t, &short(p.area), &volume]);
        (row + mark + &content).trim_end().to_owned()
    }));
    if parts.len() > LISTED {
        rows.push(format!("… and {} more", count(parts.len() - LISTED)));
    }
    rows
}

/// A name that fits a column and a line.
fn shortened(name: &str) -> String {
    let clean = |c: char| if c.is_control() { ' ' } else { c };
    if name.chars().count() <= 32 {
        return name.chars().map(clean).collect();
    }
    name.chars().take(31).map(clean).chain(['…']).collect()
}
