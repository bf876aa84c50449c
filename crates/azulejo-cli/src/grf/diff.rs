//! `grf diff`: what two scenes contain, compared.

use super::super::failure::Failure;
use super::super::input;
use super::super::input::{ClockArgs, InputArgs, ReadingArgs};
use super::super::report::{Report, count, number, percent, short};
use super::super::session::Session;
use super::super::surroundings::args::SurroundingsArgs;
use super::args::DiffArgs;
use azulejo_scene::{Mesh, Object, Rgb, Scene, Shape};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// Runs `grf diff`; the second result is the end of the command after its report.
pub fn run(
    args: &DiffArgs,
    session: &mut Session,
) -> Result<(Report, Result<(), Failure>), Failure> {
    if !(args.tolerance >= 0.0 && args.tolerance.is_finite()) {
        return Err(Failure::misuse("--tolerance: expected a number from 0"));
    }
    let mut read = |path: &Path| {
        let input = InputArgs {
            scenes: vec![path.to_owned()],
            lights: None,
            lamp: Vec::new(),
            outside: SurroundingsArgs::default(),
            reading: ReadingArgs {
                place: Vec::new(),
                ..args.reading.clone()
            },
        };
        input::read_all(&input, ClockArgs::default(), session)
    };
    let (one, other) = (read(&args.one)?, read(&args.other)?);
    let mut differences = Differences::default();
    differences.whole(&one, &other);
    let size = one.bounds().diagonal().max(other.bounds().diagonal());
    let size = if size.is_finite() { size } else { 1.0 };
    differences.objects(&one, &other, args.tolerance * size);
    let report = differences.report();
    let is_equal = differences.lines.is_empty();
    Ok((
        report,
        if is_equal {
            Ok(())
        } else {
            Err(Failure::Found)
        },
    ))
}

#[derive(Default)]
struct Differences {
    /// What differs: the kind of change, what changed, and how.
    lines: Vec<(&'static str, String, String)>,
    light: LightDifference,
}

/// How irradiance differs at vertices that both scenes have.
#[derive(Default)]
struct LightDifference {
    vertices: usize,
    /// The largest difference of a channel, and the object.
    most: f64,
    place: String,
    /// Sums over vertices, of the squared difference of means and of the mean.
    squares: f64,
    sum: f64,
}

impl Differences {
    fn add(&mut self, kind: &'static str, what: impl Into<String>, how: impl Into<String>) {
        self.lines.push((kind, what.into(), how.into()));
    }

    fn changed<T: PartialEq>(&mut self, what: &str, one: &T, other: &T, how: String) {
        if one != other {
            self.add("changed", what, how);
        }
    }

    /// Everything but objects.
    fn whole(&mut self, one: &Scene, other: &Scene) {
        self.changed("units", &one.units, &other.units, String::new());
        let (a, b) = (&one.background, &other.background);
        self.changed("background", a, b, String::new());
        self.changed("fog", &one.fog, &other.fog, String::new());
        self.list("camera", &one.cameras, &other.cameras, |c| &c.name);
        self.list("light", &one.lights, &other.lights, |l| &l.name);
        self.list("material", &one.materials, &other.materials, |m| &m.name);
        let paths = |s: &Scene| {
            s.textures
                .iter()
                .map(|t| t.path.clone())
                .collect::<Vec<_>>()
        };
        self.list("texture", &paths(one), &paths(other), |path| path);
    }

    /// Lists that are compared place by place.
    fn list<T: PartialEq>(
        &mut self,
        what: &str,
        one: &[T],
        other: &[T],
        name: impl Fn(&T) -> &String,
    ) {
        let named = |k: usize, item: &T| match &**name(item) {
            "" => format!("{what} {}", k + 1),
            name => format!("{what} \"{name}\""),
        };
        for (k, (a, b)) in one.iter().zip(other).enumerate() {
            if a != b {
                let (a, b) = (named(k, a), named(k, b));
                let how = if a == b {
                    String::new()
                } else {
                    format!("now {b}")
                };
                self.add("changed", a, how);
            }
        }
        for (k, item) in one.iter().enumerate().skip(other.len()) {
            self.add("removed", named(k, item), "");
        }
        for (k, item) in other.iter().enumerate().skip(one.len()) {
            self.add("added", named(k, item), "");
        }
    }

    fn objects(&mut self, one: &Scene, other: &Scene, tolerance: f64) {
        let mut waiting: BTreeMap<&str, Vec<(usize, &Object)>> = BTreeMap::new();
        for (index, object) in other.objects.iter().enumerate().rev() {
            let same = waiting.entry(&object.name).or_default();
            same.push((index, object));
        }
        for (index, object) in one.objects.iter().enumerate() {
            let name = described(object, index);
            match waiting.get_mut(&*object.name).and_then(Vec::pop) {
                None => self.add("removed", name, ""),
                Some((_, same)) => {
                    let mut how = Vec::new();
                    shapes(&object.shape, &same.shape, tolerance, &mut how);
                    if materials(one, &object.shape) != materials(other, &same.shape) {
                        how.push("other materials".to_owned());
                    }
                    if !how.is_empty() {
                        self.add("changed", name.clone(), how.join(", "));
                    }
                    self.light(&name, &object.shape, &same.shape);
                }
            }
        }
        for &(index, object) in waiting.values().flatten() {
            self.add("added", described(object, index), "");
        }
        let light = &self.light;
        if light.most > 0.0 {
            let rms = (light.squares / light.vertices as f64).sqrt();
            let mean = light.sum / light.vertices as f64;
            let words = format!(
                "by {} at most, in {}; RMS {} of the mean, over {} vertices",
                short(light.most),
                light.place,
                percent(rms / mean.max(f64::MIN_POSITIVE)),
                count(light.vertices)
            );
            self.add("changed", "irradiance", words);
        }
    }

    fn light(&mut self, name: &str, one: &Shape, other: &Shape) {
        let (a, b) = (irradiance(one), irradiance(other));
        if a.len() != b.len() {
            if a.is_empty() || b.is_empty() {
                let how = if a.is_empty() { "added" } else { "removed" };
                self.add(how, format!("irradiance of {name}"), "");
            }
            return;
        }
        for (a, b) in a.iter().zip(&b) {
            let difference = a.to_array().into_iter().zip(b.to_array());
            let most = difference.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if most > self.light.most {
                (self.light.most, self.light.place) = (most, name.to_owned());
            }
            self.light.vertices += 1;
            self.light.squares += (a.mean() - b.mean()).powi(2);
            self.light.sum += a.mean();
        }
    }

    fn report(&self) -> Report {
        let mut report = Report::default();
        for (kind, what, how) in &self.lines {
            let words = if how.is_empty() {
                what.clone()
            } else {
                format!("{what}: {how}")
            };
            report.line(kind, words);
        }
        let value = |(kind, what, how): &(&str, String, String)| json!({ "change": kind, "what": what, "how": how });
        let lines: Vec<Value> = self.lines.iter().map(value).collect();
        report.value("differences", lines);
        report.value("irradiance_most", number(self.light.most));
        report
    }
}

fn described(object: &Object, index: usize) -> String {
    match &*object.name {
        "" => format!("object {}", index + 1),
        name => format!("object \"{name}\""),
    }
}

/// How two shapes differ, light and materials apart.
fn shapes(one: &Shape, other: &Shape, tolerance: f64, how: &mut Vec<String>) {
    match (one, other) {
        (Shape::Mesh(a), Shape::Mesh(b)) => meshes(a, b, tolerance, how),
        (Shape::Mesh(a), Shape::Instance(b)) => meshes(a, &b.to_mesh(), tolerance, how),
        (Shape::Instance(a), Shape::Mesh(b)) => meshes(&a.to_mesh(), b, tolerance, how),
        (Shape::Instance(a), Shape::Instance(b)) => {
            meshes(&a.to_mesh(), &b.to_mesh(), tolerance, how);
        }
        (Shape::Primitive(a), Shape::Primitive(b)) => {
            if (a.kind, a.world_from_object) != (b.kind, b.world_from_object) {
                how.push("another primitive".to_owned());
            }
        }
        (Shape::Exact(a), Shape::Exact(b)) => {
            if a.solids != b.solids {
                how.push("other solids".to_owned());
            }
        }
        _ => how.push("another kind of shape".to_owned()),
    }
}

fn meshes(a: &Mesh, b: &Mesh, tolerance: f64, how: &mut Vec<String>) {
    let (vertices, faces) = (
        [a.positions.len(), b.positions.len()],
        [a.faces.len(), b.faces.len()],
    );
    for ([one, other], what) in [(vertices, "vertices"), (faces, "faces")] {
        if one != other {
            how.push(format!("{} {what}, then {}", count(one), count(other)));
        }
    }
    if vertices[0] == vertices[1] {
        let apart = a.positions.iter().zip(&b.positions);
        let most = apart.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        if most > tolerance {
            how.push(format!("vertices moved by up to {}", short(most)));
        }
    }
    if faces[0] == faces[1] && a.faces != b.faces {
        how.push("other corners".to_owned());
    }
    if a.normals.is_some() != b.normals.is_some() {
        how.push("normals on one side only".to_owned());
    }
    if a.uvs.is_some() != b.uvs.is_some() {
        how.push("texture coordinates on one side only".to_owned());
    }
    if a.colors != b.colors {
        how.push("other colours".to_owned());
    }
}

/// The materials of a shape by name, in the order of its faces.
fn materials<'s>(scene: &'s Scene, shape: &Shape) -> Vec<&'s str> {
    let ids = match shape {
        Shape::Mesh(mesh) => mesh.face_materials.clone(),
        Shape::Instance(instance) => instance.mesh.face_materials.clone(),
        Shape::Primitive(p) => vec![p.material],
        Shape::Exact(exact) => exact.leaves().iter().map(|l| l.material()).collect(),
    };
    let name = |id: u32| scene.materials.get(id as usize).map_or("", |m| &*m.name);
    ids.into_iter().map(name).collect()
}

fn irradiance(shape: &Shape) -> Vec<Rgb> {
    match shape {
        Shape::Mesh(mesh) => mesh.irradiance.clone(),
        Shape::Instance(instance) => {
            (instance.light.as_ref()).map_or_else(Vec::new, |l| l.irradiance.clone())
        }
        Shape::Primitive(p) => p
            .light
            .as_ref()
            .map_or_else(Vec::new, |l| l.irradiance.clone()),
        Shape::Exact(exact) => exact
            .proxy
            .as_ref()
            .map_or_else(Vec::new, |m| m.irradiance.clone()),
    }
}
