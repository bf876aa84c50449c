//! Letters and where they stand: from the data folder, or made up.

use azulejo_formats::outline::ppf;
use azulejo_formats::{Folder, obj};
use azulejo_scene::{
    Bevel, BevelEnds, BevelProfile, Camera, Contour, Curve, Exact, Figure, FillRule, Material,
    Object, Primitive, Prism, Rgb, Scene, Shape, Solid,
};
use glam::{DAffine3, DVec2, DVec3};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The folder of scenes and fonts, if there is one.
pub fn data() -> Option<PathBuf> {
    std::env::var_os("AZULEJO_DATA").map(PathBuf::from)
}

/// Letters over a floor, before a wall, under a lamp.
pub struct Page {
    /// A line of text, or a page.
    pub name: String,
    /// World units of an em.
    pub size: f64,
    /// World units of the extrusion.
    pub depth: f64,
    /// Glyphs by name, and where they begin.
    pub placed: Vec<(String, DVec2)>,
    /// Outlines by name, in ems.
    pub outlines: BTreeMap<String, Arc<Figure>>,
    eye: DVec3,
    target: DVec3,
}

/// How wide bevels are, in ems: a fifth of a stem.
const BEVEL: f64 = 0.02;

/// Edges of both ends of letters that are so many ems deep.
pub fn bevel(profile: BevelProfile, depth: f64) -> Bevel {
    Bevel {
        profile,
        inset: BEVEL,
        depth: BEVEL / depth,
        ends: BevelEnds::Both,
    }
}

/// Where light comes from.
pub struct Lights {
    /// The small one.
    pub point: DVec3,
    /// A corner and two edges of the square lamp.
    pub area: [DVec3; 3],
}

impl Page {
    /// Both of them.
    pub const NAMES: [&'static str; 2] = ["s4", "s4page"];

    /// The page of this name, or one like it.
    pub fn load(name: &str) -> Page {
        let file = data().map(|d| d.join("scenes").join(format!("{name}.json")));
        let text = file.and_then(|f| std::fs::read(f).ok());
        let value = text.and_then(|t| serde_json::from_slice::<Value>(&t).ok());
        match value {
            Some(value) => Page::from_json(name, &value),
            None => Page::made_up(name),
        }
    }

    fn from_json(name: &str, value: &Value) -> Page {
        let prisms = &value["prisms"];
        let point = |v: &Value| DVec3::new(number(&v[0]), number(&v[1]), number(&v[2]));
        let outlines = prisms["outlines"].as_object().into_iter().flatten();
        let instances = prisms["instances"].as_array().into_iter().flatten();
        Page {
            name: name.to_owned(),
            size: number(&prisms["size"]),
            depth: number(&prisms["depth"]),
            placed: instances
                .map(|i| (string(&i[0]), DVec2::new(number(&i[1]), number(&i[2]))))
                .collect(),
            outlines: outlines
                .map(|(k, v)| (k.clone(), Arc::new(figure(v))))
                .collect(),
            eye: point(&value["camera"]["eye"]),
            target: point(&value["camera"]["target"]),
        }
    }

    /// As many letters at about the same places; every one a ring with waves.
    fn made_up(name: &str) -> Page {
        let is_line = name == "s4";
        let (columns, rows, size) = if is_line {
            (17, 1, 1.0)
        } else {
            (77, 16, 0.22)
        };
        let width = 9.4;
        let pitch = width / f64::from(columns);
        let pen = |k: i32| {
            let row = f64::from(k / columns);
            DVec2::new(f64::from(k % columns) * pitch, 0.3 + 0.26 * row)
        };
        let place = |k: i32| (((k % 31) as u8 + b'A').to_string(), pen(k));
        let outline = |k: u8| {
            (
                (k + b'A').to_string(),
                Arc::new(wavy_ring(3 + k as usize % 8)),
            )
        };
        Page {
            name: name.to_owned(),
            size,
            depth: 0.3 * size,
            placed: (0..columns * rows).map(place).collect(),
            outlines: (0..31).map(outline).collect(),
            eye: DVec3::new(0.5 * width - 1.2, 2.6, 9.6),
            target: DVec3::new(0.5 * width, if is_line { 0.55 } else { 2.3 }, 0.0),
        }
    }

    /// Number of letters.
    pub fn glyphs(&self) -> usize {
        self.placed.len()
    }

    /// Where it is seen from.
    pub fn camera(&self) -> Camera {
        Camera {
            name: String::new(),
            eye: self.eye,
            target: self.target,
            up: DVec3::Y,
            vertical_fov: 35f64.to_radians(),
            size: Some((1280, 720)),
        }
    }

    /// Its lights.
    pub fn lights(&self) -> Lights {
        let (x, height) = (self.target.x, if self.size < 0.5 { 8.0 } else { 6.0 });
        Lights {
            point: DVec3::new(x + 4.0, 5.0, 6.0),
            area: [
                DVec3::new(x - 3.0, height - 1e-3, 2.0),
                2.0 * DVec3::X,
                2.0 * DVec3::Z,
            ],
        }
    }

    /// The scene with its letters as prisms.
    pub fn exact(&self) -> Scene {
        self.prisms(None)
    }

    /// The scene with its letters as prisms with round edges, front and back.
    pub fn bevelled(&self) -> Scene {
        self.prisms(Some(Arc::new(bevel(
            BevelProfile::Round,
            self.depth / self.size,
        ))))
    }

    fn prisms(&self, bevel: Option<Arc<Bevel>>) -> Scene {
        let mut scene = self.surroundings();
        let prism = |(name, pen): &(String, DVec2)| {
            let scale = DVec3::new(self.size, self.size, self.depth);
            Solid::Prism(Prism {
                figure: Arc::clone(&self.outlines[name]),
                world_from_figure: DAffine3::from_translation(pen.extend(0.0))
                    * DAffine3::from_scale(scale),
                material: 0,
                bevel: bevel.clone(),
            })
        };
        let exact = Exact::new(self.placed.iter().map(prism).collect());
        scene.objects.push(Object::new("text", Shape::Exact(exact)));
        scene
    }

    /// The scene with its letters as polygons: those of the data folder, or about as many.
    pub fn polygons(&self) -> Scene {
        let file = data().map(|d| d.join("scenes").join(format!("{}.obj", self.name)));
        let read = file.and_then(|file| read_obj(&file));
        read.unwrap_or_else(|| self.exact().faceted(1e-4).into_owned())
    }

    /// Floor, wall and lamp.
    fn surroundings(&self) -> Scene {
        let mut scene = Scene::default();
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.7)));
        let x = self.target.x;
        let mut add = |name: &str, corner: DVec3, edges: [DVec3; 2]| {
            let p = Primitive::parallelogram(corner, edges[0], edges[1], grey);
            scene.objects.push(Object::new(name, Shape::Primitive(p)));
        };
        let corner = DVec3::new(x - 12.0, 0.0, -3.0);
        add("floor", corner, [15.0 * DVec3::Z, 24.0 * DVec3::X]);
        add("wall", corner, [24.0 * DVec3::X, 12.0 * DVec3::Y]);
        let [corner, a, b] = self.lights().area;
        add("lamp", corner + 1e-3 * DVec3::Y, [a, b]);
        scene
    }
}

fn read_obj(file: &Path) -> Option<Scene> {
    let bytes = std::fs::read(file).ok()?;
    let loaded = obj::read(&bytes, &file.to_string_lossy(), &Folder::of_model(file)).ok()?;
    Some(loaded.scene)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(0.0)
}

fn string(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// A figure from contours of `["M", x, y]`, `["L", x, y]` and `["Q", cx, cy, x, y]`.
fn figure(contours: &Value) -> Figure {
    let contours = contours.as_array().into_iter().flatten();
    Figure {
        contours: contours.map(contour).collect(),
        rule: FillRule::EvenOdd,
    }
}

fn contour(steps: &Value) -> Contour {
    let point = |step: &Value, k: usize| DVec2::new(number(&step[k]), number(&step[k + 1]));
    let mut curves = Vec::new();
    let mut at = DVec2::ZERO;
    let mut first = DVec2::ZERO;
    for step in steps.as_array().into_iter().flatten() {
        let end = match step[0].as_str() {
            Some("M") => {
                first = point(step, 1);
                first
            }
            Some("Q") => {
                let (control, end) = (point(step, 1), point(step, 3));
                curves.push(Curve::Cubic {
                    start: at,
                    control1: at + (control - at) * (2.0 / 3.0),
                    control2: end + (control - end) * (2.0 / 3.0),
                });
                end
            }
            _ => {
                curves.push(Curve::Line { start: at });
                point(step, 1)
            }
        };
        at = end;
    }
    if at != first {
        curves.push(Curve::Line { start: at });
    }
    Contour { curves }
}

/// A ring whose edges have `waves` waves.
fn wavy_ring(waves: usize) -> Figure {
    let contour = |radius: f64, count: usize| {
        let at = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / (3 * count) as f64;
            let r = radius * (1.0 + 0.15 * (waves as f64 * angle).sin());
            DVec2::new(0.27, 0.3) + r * DVec2::from_angle(angle)
        };
        let curves = (0..count).map(|k| Curve::Cubic {
            start: at(3 * k),
            control1: at(3 * k + 1),
            control2: at(3 * k + 2),
        });
        Contour {
            curves: curves.collect(),
        }
    };
    Figure {
        contours: vec![contour(0.22, 2 * waves), contour(0.12, waves)],
        rule: FillRule::EvenOdd,
    }
}

/// Every glyph of every font: those of the data folder, or rings of all kinds.
pub fn fonts() -> Vec<(String, Vec<Arc<Figure>>)> {
    let folder = data().map(|d| d.join("corpus/sff/fonts"));
    let files = folder.and_then(|f| std::fs::read_dir(f).ok());
    let mut files: Vec<PathBuf> = (files.into_iter().flatten().flatten())
        .map(|entry| entry.path())
        .collect();
    files.sort();
    let fonts: Vec<_> = files.iter().filter_map(|file| font(file)).collect();
    if fonts.is_empty() {
        let rings = (1..40).map(|waves| Arc::new(wavy_ring(waves)));
        return vec![("rings".to_owned(), rings.collect())];
    }
    fonts
}

fn font(file: &Path) -> Option<(String, Vec<Arc<Figure>>)> {
    let name = file.file_name()?.to_string_lossy().into_owned();
    let (font, _) = ppf::read(&std::fs::read(file).ok()?, &name).ok()?;
    let figures = font.glyphs.into_values().map(|g| g.figure);
    Some((name, figures.filter(|f| f.curve_count() > 0).collect()))
}
