//! What commands are asked, and what is read from their answers, in the units of the original.

use super::commands::{Measure, PosedCommand};
use super::compare::Quantity;
use super::dice::Dice;
use super::scenes::PosedScene;
use super::site::{Site, adaptation};
use super::survey::{Original, Partition};
use azulejo::models;
use azulejo_formats::picture::exr::{self, ChannelValues};
use azulejo_scene::{Camera, Image, Scene, Shape, WrapMode};
use azulejo_trace::Progress;
use glam::{DAffine3, DVec2, DVec3};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// A question to a command about a file.
pub struct Inquiry<'a> {
    /// The command.
    pub command: &'a PosedCommand,
    /// The original scene.
    pub posed: &'a PosedScene,
    /// Its elements.
    pub original: &'a Original,
    /// The file.
    pub site: &'a Site,
    /// Folder of inputs and outputs.
    pub folder: &'a Path,
    /// Groups of elements whose values are compared.
    pub groups: &'a Partition,
    /// Seed of the command's random numbers.
    pub seed: u64,
}

/// Size of a scene over the longest edge of a patch.
const PATCHES_ACROSS: f64 = 8.0;
const SOLID_PATCHES_ACROSS: f64 = 10.0;

/// RMS error of row sums that the analytic engine reaches, unless it is told otherwise.
const ANALYTIC_ERROR: f64 = 5e-5;

/// Error of the area of an exact shape, relative to it.
const SOLID_AREA: f64 = 5e-4;

/// Faces around a vertex.
const AROUND: f64 = 6.0;

/// Points of a probe.
const POINTS: usize = 12;

/// Blocks of a picture along each side.
const BLOCKS: usize = 4;

/// Radiance that is seen inside of closed shapes in even light of 1: rays slip in at edges.
const LEAK: f64 = 3e-4;

/// First words of the names of quantities of objects as wholes.
const VOLUME: &str = "volume";
const INSIDE_OUT: &str = "inside out";

type Parsed<T> = Result<T, String>;

/// The entries of a matrix between two groups, weighted by area.
struct FactorSum<'a> {
    /// The group and the side from which light leaves.
    row: (usize, &'a str),
    factor: f64,
    square: f64,
    entries: usize,
}

impl FactorSum<'_> {
    fn quantity(&self, name: String, area: f64) -> Quantity {
        // Errors of entries that stand for one pair are the same.
        let joint = if self.entries > 1 { 2.0 } else { 1.0 };
        Quantity {
            name,
            value: self.factor / area,
            error: (joint * self.square).sqrt() / area,
            bias: 0.0,
            span: 1.0,
            family: Some(2 * self.row.0 + usize::from(self.row.1 == "back")),
        }
    }
}

impl Inquiry<'_> {
    /// The arguments of the command; writes the files that it needs.
    pub fn arguments(&self) -> Parsed<Vec<String>> {
        let size = self.original.size() * self.site.scale();
        let patches = if self.posed.traits().is_polygonal {
            PATCHES_ACROSS
        } else {
            SOLID_PATCHES_ACROSS
        };
        let patch_size = format!("--patch-size {}", size / patches);
        // Rows are those of undivided faces; exact shapes need some division.
        let rows = if self.posed.traits().is_polygonal {
            "--patch-size 0".to_owned()
        } else {
            patch_size.clone()
        };
        let seed = self.seed;
        let words = match self.command.measure {
            Measure::Factors { by_object } => {
                let by = if by_object { "--by object" } else { "" };
                format!("form-factors -o factors.csv --no-journal {rows} {by} --seed {seed}")
            }
            Measure::Exchange => {
                self.write("optics.csv", "name,eps,rho_s\n*,0.8,0\n")?;
                let by = "--by object --lump";
                format!("exchange --materials optics.csv -o heat.csv {rows} {by} --seed {seed}")
            }
            Measure::Solve => {
                format!("solve -o solved.grf --sides front {patch_size} --seed {seed}")
            }
            Measure::Probe => {
                self.write("points.txt", &self.points())?;
                format!("probe --points points.txt -o light.txt {patch_size} --seed {seed}")
            }
            Measure::Bake => format!(
                "bake -o baked.glb --lightmap light.exr --error-map error.exr --float \
                 --double-sided front --no-split-contacts {patch_size} --seed {seed}"
            ),
            Measure::Render => {
                let view = self.view();
                format!("render -o image.exr --layers error {view} {patch_size} --seed {seed}")
            }
            Measure::Info => "info".to_owned(),
        };
        let mut arguments: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
        let file = self.site.path.file_name().unwrap_or_default();
        arguments.push(file.to_string_lossy().into_owned());
        arguments.extend(self.command.options.iter().cloned());
        arguments.extend(self.site.options.iter().cloned());
        arguments.push("--json".to_owned());
        Ok(arguments)
    }

    /// Reads the answer.
    pub fn answer(&self, printed: &str) -> Parsed<Vec<Quantity>> {
        let report: Value = serde_json::from_str(printed).map_err(|e| e.to_string())?;
        match self.command.measure {
            Measure::Factors { by_object } => self.factors(by_object),
            Measure::Exchange => self.conductances(),
            Measure::Solve => self.solved(&report),
            Measure::Probe => self.probed(&report),
            Measure::Bake => self.baked(&report),
            Measure::Render => self.rendered(&report),
            Measure::Info => Ok(self.described(&report)),
        }
    }

    fn write(&self, name: &str, content: &str) -> Parsed<()> {
        std::fs::write(self.folder.join(name), content).map_err(|e| format!("{name}: {e}"))
    }

    fn text(&self, name: &str) -> Parsed<String> {
        std::fs::read_to_string(self.folder.join(name)).map_err(|e| format!("{name}: {e}"))
    }

    /// Points a little above surfaces, and normals.
    fn points(&self) -> String {
        let mut dice = Dice::new(0, &self.posed.name);
        let mut lines = String::new();
        for _ in 0..POINTS {
            let element = dice.below(self.original.objects.len());
            let place = [dice.unit(), dice.unit()];
            let on_surface = self.original.point_on(element, place);
            let bounds = self.original.bounds;
            let (point, normal) = on_surface.unwrap_or_else(|| {
                let at = DVec3::new(dice.unit(), dice.unit(), dice.unit());
                (bounds.min + at * bounds.size(), dice.direction())
            });
            let point = point + 0.01 * self.original.size() * normal;
            let point = self.site.map.transform_point3(point);
            let normal = self
                .site
                .map
                .transform_vector3(normal)
                .normalize_or(DVec3::Z);
            let numbers = [point, normal].map(|v| v.to_array()).concat();
            let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
            lines += &(words.join(" ") + "\n");
        }
        lines
    }

    /// The camera's options.
    fn view(&self) -> String {
        let bounds = self.original.bounds;
        let at = |x: f64, y: f64, z: f64| bounds.min + DVec3::new(x, y, z) * bounds.size();
        let inside = Camera {
            name: String::new(),
            eye: at(0.3, 0.4, 0.35),
            target: at(0.8, 0.55, 0.6),
            up: DVec3::new(0.1, 1.0, 0.2),
            vertical_fov: 1.4,
            size: None,
        };
        let above = Camera {
            eye: bounds.centre() + bounds.diagonal() * DVec3::new(0.35, 0.6, 0.45),
            target: bounds.centre(),
            ..inside.clone()
        };
        // Within a flat scene there is nothing to see.
        let is_flat = bounds.size().min_element() < 0.05 * bounds.diagonal();
        let own = self.posed.scene.cameras.first();
        let camera = own.unwrap_or(if is_flat { &above } else { &inside });
        let map = &self.site.map;
        let words = |v: DVec3| format!("{},{},{}", v.x, v.y, v.z);
        format!(
            "--from={} --at={} --up={} --fov {}",
            words(map.transform_point3(camera.eye)),
            words(map.transform_point3(camera.target)),
            words(map.transform_vector3(camera.up).normalize_or(DVec3::Y)),
            camera.vertical_fov.to_degrees()
        )
    }

    /// The group of an object's faces, by its name; `None` if others were added to it.
    fn group_of_name(&self, name: &str) -> Option<usize> {
        let place = |name: &str| self.site.names.iter().position(|n| n == name);
        let object = place(name).or_else(|| place(without_number(name)?))?;
        if self.site.has_added(object) {
            return None;
        }
        let element = self.site.object_elements(object).next()?;
        Some(self.groups.of(element))
    }

    fn factors(&self, by_object: bool) -> Parsed<Vec<Quantity>> {
        let text = self.text("factors.csv")?;
        let lines: Vec<Vec<&str>> = text
            .lines()
            .skip(1)
            .map(|l| l.split(',').collect())
            .collect();
        // The group and side of each row.
        let mut rows: HashMap<&str, (usize, &str)> = HashMap::new();
        for line in &lines {
            let numbered = without_number(line[0]).unwrap_or(line[0]);
            let (group, side) = match (by_object, numbered.strip_suffix(" (back)")) {
                (false, _) => (self.group_of_face(line), line.get(7).copied().unwrap_or("")),
                (true, Some(name)) => (self.group_of_name(name), "back"),
                (true, None) => (self.group_of_name(line[0]), "front"),
            };
            if let Some(group) = group {
                rows.insert(line[0], (group, side));
            }
        }
        let areas = self.group_areas();
        let mut sums: BTreeMap<String, FactorSum> = BTreeMap::new();
        let mut reported: BTreeMap<(usize, &str), BTreeMap<&str, f64>> = BTreeMap::new();
        let is_analytic =
            self.command.name.contains("analytic") || self.command.name.contains("auto");
        for line in &lines {
            let Some(&(from, side)) = rows.get(line[0]) else {
                continue;
            };
            let number = |k: usize| {
                let word = line.get(k).copied().unwrap_or("");
                word.parse::<f64>()
                    .map_err(|_| format!("factors.csv: {}", line.join(",")))
            };
            let [factor, error, area] = [number(2)?, number(3)?, number(4)?];
            reported
                .entry((from, side))
                .or_default()
                .insert(line[0], area);
            let to = match rows.get(line[1]) {
                _ if line[1] == "irradiance" => continue,
                Some((to, side)) => format!("{to}{side}"),
                None => "outside".to_owned(),
            };
            let stated = if is_analytic {
                ANALYTIC_ERROR.hypot(error)
            } else {
                error
            };
            let entry = sums.entry(format!("F {from}{side} to {to}"));
            let sum = entry.or_insert(FactorSum {
                row: (from, side),
                factor: 0.0,
                square: 0.0,
                entries: 0,
            });
            sum.factor += area * factor;
            sum.square += (area * stated).powi(2);
            sum.entries += 1;
        }
        let quantity = |(name, sum): (String, FactorSum)| {
            let stated: f64 = reported[&sum.row].values().sum();
            let known = areas.get(&sum.row.0).copied().unwrap_or(0.0);
            sum.quantity(name, if known > 0.0 { known } else { stated })
        };
        Ok(sums.into_iter().map(quantity).collect())
    }

    fn group_of_face(&self, line: &[&str]) -> Option<usize> {
        let index = |k: usize| line.get(k)?.parse::<usize>().ok();
        let elements = self.site.elements.faces.get(index(5)?)?.get(index(6)?)?;
        self.groups.of_all(elements)
    }

    /// The area of each group in the units of the file, by the original.
    fn group_areas(&self) -> HashMap<usize, f64> {
        let mut areas = HashMap::new();
        for (element, area) in self.original.areas.iter().enumerate() {
            *areas.entry(self.groups.of(element)).or_insert(0.0) +=
                area * self.site.scale().powi(2);
        }
        areas
    }

    fn conductances(&self) -> Parsed<Vec<Quantity>> {
        let text = self.text("heat.csv")?;
        let area: f64 = self.original.areas.iter().sum();
        let mut outside: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        let mut quantities = Vec::new();
        for line in text.lines().skip(1) {
            let words: Vec<&str> = line.split(',').collect();
            let number = |k: usize| {
                let number = words.get(k).and_then(|w| w.parse::<f64>().ok());
                number.ok_or_else(|| format!("heat.csv: {line}"))
            };
            let [value, error] = [number(2)?, number(3)?].map(|x| x / self.site.square_metres());
            let Some(from) = self.group_of_name(words[0]) else {
                continue;
            };
            let to = self.group_of_name(words[1]);
            // Parts of an object exchange heat only where a format made them objects.
            if to == Some(from) {
                continue;
            }
            if let Some(to) = to {
                quantities.push(Quantity {
                    name: format!("GR {} {}", from.min(to), from.max(to)),
                    value,
                    error,
                    bias: 0.0,
                    span: area,
                    family: Some(from),
                });
            } else {
                let sum = outside.entry(from).or_default();
                *sum = [sum[0] + value, sum[1].hypot(error)];
            }
        }
        quantities.extend(outside.into_iter().map(|(from, [value, error])| Quantity {
            name: format!("GR {from} outside"),
            value,
            error,
            bias: 0.0,
            span: area,
            family: Some(from),
        }));
        Ok(quantities)
    }

    fn solved(&self, report: &Value) -> Parsed<Vec<Quantity>> {
        let scene = read(&self.folder.join("solved.grf"))?;
        let mut means = Means::new(self, &scene, &self.site.map);
        for (object, shape) in scene.objects.iter().map(|o| &o.shape).enumerate() {
            let Shape::Mesh(mesh) = shape else {
                continue;
            };
            for face in 0..mesh.faces.len() {
                let corners = mesh.faces.get(face).iter().map(|&v| v as usize);
                let mean = |values: &[azulejo_scene::Rgb]| {
                    let values = corners.clone().filter_map(|v| values.get(v));
                    let sum: f64 = values.map(|e| e.to_array().iter().sum::<f64>()).sum();
                    sum / corners.len() as f64
                };
                let value = [mean(&mesh.irradiance), mean(&mesh.irradiance_error)];
                means.add(object, face, mesh.face_area_vector(face).length(), value);
            }
        }
        let share = number(report, "error_discretization");
        let mut quantities = means.quantities(share);
        quantities.extend(self.balance(report));
        Ok(quantities)
    }

    /// What becomes of the light.
    fn balance(&self, report: &Value) -> Vec<Quantity> {
        let sum = |key: &str| -> f64 {
            let numbers = report[key].as_array().into_iter().flatten();
            numbers.filter_map(Value::as_f64).sum()
        };
        let emitted = sum("emitted");
        // What arrives from the sky is itself an estimate, and a double gets its own.
        if emitted <= 0.0 || self.posed.traits().has_lights {
            return Vec::new();
        }
        // The balance is that of the patches, of which a few lamps may send all light.
        let noise = number(report, "error_noise") / number(report, "points").max(1.0).sqrt();
        let error = noise.max(number(report, "patch_error"));
        let share = |key: &str| Quantity {
            name: format!("{key} share"),
            value: sum(key) / emitted,
            error,
            bias: number(report, "error_discretization"),
            span: 1.0,
            family: None,
        };
        let power = emitted / self.site.square_metres();
        let power = Quantity {
            // Lamps that are curved have the area of samples.
            bias: if self.posed.traits().is_polygonal {
                0.0
            } else {
                1e-4 * power
            },
            ..Quantity::exact("emitted power", power)
        };
        vec![share("absorbed"), share("escaped"), power]
    }

    fn probed(&self, report: &Value) -> Parsed<Vec<Quantity>> {
        let text = self.text("light.txt")?;
        let mut quantities = Vec::new();
        for (k, line) in text.lines().enumerate() {
            let numbers: Vec<f64> = line
                .split_whitespace()
                .filter_map(|w| w.parse().ok())
                .collect();
            if numbers.len() != 6 {
                return Err(format!("light.txt: {line}"));
            }
            quantities.push(Quantity {
                name: format!("E at point {k}"),
                value: numbers[..3].iter().sum(),
                error: numbers[3..].iter().sum(),
                bias: 0.0,
                span: 0.0,
                family: None,
            });
        }
        Ok(with_common_errors(
            quantities,
            [0.0, number(report, "error_discretization")],
        ))
    }

    fn baked(&self, report: &Value) -> Parsed<Vec<Quantity>> {
        let scene = read(&self.folder.join("baked.glb"))?;
        let picture = |name: &str| {
            let path = self.folder.join(name);
            let bytes = std::fs::read(&path).map_err(|e| format!("{name}: {e}"))?;
            exr::read(&bytes).map_err(|e| format!("{name}: {e}"))
        };
        let (light, error) = (picture("light.exr")?, picture("error.exr")?);
        let map = adaptation(self.site.units, scene.units) * self.site.map;
        let mut means = Means::new(self, &scene, &map);
        for (object, shape) in scene.objects.iter().map(|o| &o.shape).enumerate() {
            let Some(placed) = shape.placed_mesh() else {
                continue;
            };
            for face in 0..placed.mesh.faces.len() {
                let corners = placed.mesh.faces.corner_range(face);
                let uvs: Option<Vec<DVec2>> = corners.map(|c| placed.mesh.lightmap_uv(c)).collect();
                if let Some(uvs) = uvs.filter(|uvs| uvs.len() == 3) {
                    let area = placed.face_area_vector(face).length();
                    means.add(object, face, area, [&light, &error].map(|i| over(i, &uvs)));
                }
            }
        }
        Ok(means.quantities(number(report, "error")))
    }

    fn rendered(&self, report: &Value) -> Parsed<Vec<Quantity>> {
        let bytes = std::fs::read(self.folder.join("image.exr")).map_err(|e| e.to_string())?;
        let ((width, height), channels) = exr::read_channels(&bytes).map_err(|e| e.to_string())?;
        let (width, height) = (width as usize, height as usize);
        let channel = |name: &str| -> Parsed<&Vec<f32>> {
            let channel = channels.iter().find(|c| c.name == name).map(|c| &c.values);
            match channel {
                Some(ChannelValues::Float(values)) => Ok(values),
                _ => Err(format!("image.exr has no channel {name}")),
            }
        };
        let mirrors = self.site.map.matrix3.determinant() < 0.0;
        let mut blocks = vec![[0.0f64; 2]; BLOCKS * BLOCKS];
        for (color, error) in [("R", "error.R"), ("G", "error.G"), ("B", "error.B")] {
            let (color, error) = (channel(color)?, channel(error)?);
            let mut squares = vec![0.0f64; blocks.len()];
            for (k, (&value, &error)) in color.iter().zip(error).enumerate() {
                let (x, y) = (k % width, k / width);
                let x = if mirrors { width - 1 - x } else { x };
                let block = y * BLOCKS / height * BLOCKS + x * BLOCKS / width;
                blocks[block][0] += f64::from(value);
                squares[block] += f64::from(error).powi(2);
            }
            // Colours of a pixel have the same samples, so that their errors add up.
            for (block, square) in blocks.iter_mut().zip(squares) {
                block[1] += square.sqrt();
            }
        }
        let pixels = (width * height / blocks.len()) as f64;
        let blocks = blocks
            .iter()
            .enumerate()
            .map(|(k, [value, error])| Quantity {
                name: format!("L in block {} {}", k % BLOCKS, k / BLOCKS),
                value: value / pixels,
                error: error / pixels,
                bias: if self.posed.traits().has_lights {
                    LEAK
                } else {
                    0.0
                },
                span: 0.0,
                family: None,
            });
        let is_reference = self.command.name.contains("reference");
        let shares = if is_reference {
            [0.0; 2]
        } else {
            ["error_noise", "error_discretization"].map(|key| number(report, key))
        };
        Ok(with_common_errors(blocks.collect(), shares))
    }

    fn described(&self, report: &Value) -> Vec<Quantity> {
        let square = self.site.scale().powi(2);
        let mut areas: BTreeMap<usize, f64> = BTreeMap::new();
        let mut objects: BTreeMap<usize, Vec<&str>> = BTreeMap::new();
        let mut volumes = Vec::new();
        let list = report["object_list"].as_array().into_iter().flatten();
        for (k, object) in list.enumerate() {
            let Some(element) = self.site.object_elements(k).next() else {
                continue;
            };
            if self.site.has_added(k) {
                continue;
            }
            let group = self.groups.of(element);
            *areas.entry(group).or_default() +=
                object["area"].as_f64().unwrap_or(f64::NAN) / square;
            let name = object["name"].as_str().unwrap_or_default();
            objects.entry(group).or_default().push(name);
            if let Some(volume) = object["volume"].as_f64() {
                let volume = volume / (square * self.site.scale());
                // Of all corners moved outwards.
                let bias = 2.0 * areas[&group] * self.site.moved;
                volumes.push(Quantity {
                    bias,
                    ..Quantity::exact(format!("{VOLUME} {group}"), volume)
                });
            }
        }
        let inverted = report["inverted"].as_array().into_iter().flatten();
        let inverted: BTreeSet<&str> = inverted.filter_map(Value::as_str).collect();
        let area = |(group, area): (&usize, &f64)| Quantity {
            // Areas of exact shapes are those of polygons that approach them.
            error: if self.original.areas[*group] > 0.0 {
                0.0
            } else {
                SOLID_AREA * area
            },
            ..Quantity::exact(format!("area {group}"), *area)
        };
        let mut quantities: Vec<Quantity> = areas.iter().map(area).collect();
        // Where objects were joined, others than before may be closed.
        let mut single = objects.iter().filter(|(group, names)| {
            let elements = 0..self.original.objects.len();
            let own = elements.filter(|&e| self.groups.of(e) == **group);
            let parts: BTreeSet<usize> = own.map(|e| self.original.objects[e]).collect();
            names.len() == 1 && parts.len() == 1
        });
        let is_whole = single.clone().count() == objects.len();
        // Not all formats keep the lamps and cameras without which an empty room looks like a body that is inside out.
        let has_cameras = report["cameras"].as_array().is_some_and(|c| !c.is_empty());
        let has = |kind: &str| report["lights"][kind].as_u64() > Some(0);
        let is_furnished = has_cameras || has("point") || has("spot");
        let verdict = |(group, names): (&usize, &Vec<&str>)| Quantity {
            span: 0.0,
            ..Quantity::exact(
                format!("{INSIDE_OUT} {group}"),
                f64::from(u8::from(names.iter().any(|n| inverted.contains(n)))),
            )
        };
        if is_whole && is_furnished == self.original.is_furnished {
            quantities.extend(single.by_ref().map(verdict));
            quantities.extend(volumes);
        }
        quantities
    }
}

/// Leaves out volumes and verdicts on what is inside out if only one of two descriptions has verdicts: in the other
/// file objects are parts of what they were, which are not closed.
pub fn keep_comparable(expected: &mut Vec<Quantity>, found: &mut Vec<Quantity>) {
    let has_verdicts = |quantities: &[Quantity]| {
        let mut names = quantities.iter().map(|q| &q.name);
        names.any(|name| name.starts_with(INSIDE_OUT))
    };
    if has_verdicts(expected) != has_verdicts(found) {
        let is_area = |q: &Quantity| !q.name.starts_with(VOLUME) && !q.name.starts_with(INSIDE_OUT);
        expected.retain(is_area);
        found.retain(is_area);
    }
}

/// A number of a report; 0 if it has none.
fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().unwrap_or(0.0)
}

fn read(path: &Path) -> Parsed<Scene> {
    let model = models::read(path, &models::Reading::default(), &Progress::new());
    Ok(model.map_err(|e| e.to_string())?.scene)
}

/// Adds a standard error and a systematic one to each, which are shares of the mean, and gives all the largest
/// as span.
fn with_common_errors(mut quantities: Vec<Quantity>, [noise, bias]: [f64; 2]) -> Vec<Quantity> {
    let mean = quantities.iter().map(|q| q.value).sum::<f64>() / quantities.len().max(1) as f64;
    let largest = quantities.iter().map(|q| q.value.abs()).fold(0.0, f64::max);
    for quantity in &mut quantities {
        quantity.error = quantity.error.hypot(noise * mean);
        quantity.bias += bias * mean;
        quantity.span = largest;
    }
    quantities
}

/// The mean of a picture over a triangle of texture coordinates, with v upwards: sum of its channels.
fn over(image: &Image, uvs: &[DVec2]) -> f64 {
    /// Points along each side.
    const STEPS: u32 = 5;
    let (mut sum, mut count) = (0.0, 0);
    for i in 0..STEPS {
        for j in 0..STEPS - i {
            let at = |k: u32| (f64::from(k) + 1.0 / 3.0) / f64::from(STEPS);
            let uv = uvs[0] + at(i) * (uvs[1] - uvs[0]) + at(j) * (uvs[2] - uvs[0]);
            let texel = image.sample_wrapped(uv, [WrapMode::Clamp; 2]);
            sum += texel.iter().map(|&t| f64::from(t)).sum::<f64>();
            count += 1;
        }
    }
    sum / f64::from(count)
}

/// Means over groups of elements.
struct Means<'a> {
    inquiry: &'a Inquiry<'a>,
    elements: super::survey::FaceElements,
    /// Sums of area, of value and error times area, and of the squares of the latter.
    sums: BTreeMap<usize, [f64; 4]>,
}

impl<'a> Means<'a> {
    /// Over the groups of an inquiry; the scene is at its map.
    fn new(inquiry: &'a Inquiry, scene: &Scene, map: &DAffine3) -> Means<'a> {
        let bounds = scene.bounds();
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        // What is written may have 32 bits.
        let rounding = f64::from(f32::EPSILON) * largest / map.matrix3.determinant().abs().cbrt();
        let reach = 1e-6 * inquiry.original.size() + 2.0 * (inquiry.site.moved + rounding);
        Means {
            inquiry,
            elements: inquiry.original.find(scene, map, reach),
            sums: BTreeMap::new(),
        }
    }

    fn add(&mut self, object: usize, face: usize, area: f64, [value, error]: [f64; 2]) {
        let elements = &self.elements.faces[object][face];
        if let Some(group) = self.inquiry.groups.of_all(elements) {
            let sum = self.sums.entry(group).or_default();
            let noise = area * error;
            let added = [area, area * value, noise, noise * noise];
            *sum = [0, 1, 2, 3].map(|k| sum[k] + added[k]);
        }
    }

    /// The means; `share` is an RMS error over all of the surface, relative to its mean, of which a small
    /// part may have more.
    fn quantities(&self, share: f64) -> Vec<Quantity> {
        let total = |k: usize| self.sums.values().map(|sum| sum[k]).sum::<f64>();
        let (area, mean) = (total(0), total(1) / total(0));
        let value = |sum: &[f64; 4]| sum[1] / sum[0];
        let largest = self.sums.values().map(value).fold(0.0, f64::max);
        let quantity = |(group, sum): (&usize, &[f64; 4])| Quantity {
            name: format!("mean E of {group}"),
            value: value(sum),
            // Errors of faces around a vertex are the same.
            error: sum[2].min((AROUND * sum[3]).sqrt()) / sum[0],
            bias: share * mean * (area / sum[0]).sqrt(),
            span: largest,
            family: None,
        };
        self.sums.iter().map(quantity).collect()
    }
}

/// A name without the number of its row, which follows the names that several objects share.
fn without_number(name: &str) -> Option<&str> {
    let (name, number) = name.rsplit_once(" #")?;
    number.bytes().all(|b| b.is_ascii_digit()).then_some(name)
}
