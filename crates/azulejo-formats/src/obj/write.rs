//! Writes scenes as OBJ and MTL.

use crate::surface::gloss::is_repainted;
use crate::surface::losses::LossList;
use crate::surface::model::gltf_mr;
use crate::surface::phong::{Angle, Highlight};
use crate::surface::tessellate::{exact_counts, mesh_of};
use azulejo_scene::{
    Attribute, Material, Mesh, Object, OpacityMode, PictureChannel, Relief, ReliefKind, Rgb, Scene,
    Texture, TextureId, WrapMode,
};
use std::collections::HashSet;
use std::fmt;
use std::io::{self, BufWriter, Write};

/// Writes a scene as a model, `obj`, and its materials, `mtl`; `mtl_name` is the file name by
/// which the model refers to its materials.
///
/// Numbers are the shortest that read back to the same value. Exact primitives become polygons.
/// [`losses`] lists what else the format cannot represent.
///
/// # Errors
/// Errors of `obj` and `mtl`.
pub fn write(
    scene: &Scene,
    mtl_name: &str,
    obj: &mut dyn Write,
    mtl: &mut dyn Write,
) -> io::Result<()> {
    let names = unique_names(&scene.materials);
    let mut mtl = BufWriter::new(mtl);
    for (material, name) in scene.materials.iter().zip(&names) {
        write_material(scene, material, name, &mut mtl)?;
    }
    mtl.flush()?;
    let mut model = Model {
        out: BufWriter::new(obj),
        materials: &names,
        material: None,
        smoothing: None,
        positions: 1,
        uvs: 1,
        normals: 1,
    };
    writeln!(model.out, "# azulejo\nmtllib {}", one_line(mtl_name))?;
    for object in &scene.objects {
        model.object(object)?;
    }
    model.out.flush()
}

/// What [`write()`] would omit from a scene or change, as text: "2 lights".
pub fn losses(scene: &Scene) -> Vec<String> {
    let [primitives, solids] = exact_counts(scene);
    let is_odd_wrap = |t: &&Texture| t.wrap[0] != t.wrap[1] || t.wrap[0] == WrapMode::Mirror;
    LossList::new(scene)
        .meshes(
            |m| !m.irradiance.is_empty(),
            "meshes whose irradiance is not written",
        )
        .count(primitives, "exact primitives that become polygons")
        .count(solids, "exact shapes that become polygons")
        .materials(
            |m| m.textures.len() > 1,
            "materials of which only the first picture is kept",
        )
        .materials(
            |m| m.brdf.is_some() && model(m).is_none(),
            "reflection models",
        )
        .materials(
            |m| model(m).is_some_and(|model| model.is_approximate(m)),
            "reflection models that MTL can only approximate",
        )
        .materials(
            |m| {
                let opacity = m.opacity.as_ref();
                opacity.is_some_and(|o| o.mode != OpacityMode::Blend || m.dielectric.is_some())
            },
            "masks that become shares of opacity, or opacities of glass that are left out",
        )
        .count(
            scene.textures.iter().filter(is_odd_wrap).count(),
            "textures that are mirrored, or clamped along one axis, and will repeat",
        )
        .materials(is_odd_glass, "dielectrics that MTL cannot describe exactly")
        .finish()
}

/// MTL's glass is denser than its surroundings and follows the Fresnel equations alone.
fn is_odd_glass(m: &Material) -> bool {
    let plain = m.diffuse.is_black() && m.mirror == Rgb::WHITE;
    m.dielectric
        .is_some_and(|g| g.ior <= 1.0 || g.thin || !plain)
}

/// State of writing an OBJ file. Indices count through the whole file, from 1.
struct Model<'a> {
    out: BufWriter<&'a mut dyn Write>,
    materials: &'a [String],
    material: Option<u32>,
    /// `None` before the first `s`, which says nothing.
    smoothing: Option<u32>,
    positions: usize,
    uvs: usize,
    normals: usize,
}

impl Model<'_> {
    fn object(&mut self, object: &Object) -> io::Result<()> {
        let mesh = mesh_of(object);
        let name = one_line(&object.name);
        writeln!(self.out, "{}", format!("o {name}").trim_end())?;
        self.vertices(&mesh)?;
        for face in 0..mesh.faces.len() {
            self.face(&mesh, face)?;
        }
        self.positions += mesh.positions.len();
        self.uvs += mesh.uvs.as_ref().map_or(0, |a| a.values.len());
        self.normals += mesh.normals.as_ref().map_or(0, |a| a.values.len());
        Ok(())
    }

    fn vertices(&mut self, mesh: &Mesh) -> io::Result<()> {
        for (v, p) in mesh.positions.iter().enumerate() {
            write!(self.out, "v {}", Numbers(&p.to_array()))?;
            match mesh.colors.get(v) {
                Some(color) => writeln!(self.out, " {}", Numbers(&color.to_array()))?,
                None => writeln!(self.out)?,
            }
        }
        for uv in mesh.uvs.iter().flat_map(|a| &a.values) {
            writeln!(self.out, "vt {}", Numbers(&uv.to_array()))?;
        }
        for n in mesh.normals.iter().flat_map(|a| &a.values) {
            writeln!(self.out, "vn {}", Numbers(&n.to_array()))?;
        }
        Ok(())
    }

    fn face(&mut self, mesh: &Mesh, face: usize) -> io::Result<()> {
        let material = mesh.face_materials[face];
        if self.material != Some(material) {
            self.material = Some(material);
            writeln!(self.out, "usemtl {}", self.materials[material as usize])?;
        }
        let smoothing = mesh.smoothing_group(face);
        let is_said = self.smoothing.is_some() || !mesh.smoothing.is_empty();
        if is_said && self.smoothing.replace(smoothing) != Some(smoothing) {
            writeln!(self.out, "s {smoothing}")?;
        }
        write!(self.out, "f")?;
        for corner in mesh.faces.corner_range(face) {
            let vertex = mesh.faces.corners[corner];
            let uv = index(mesh.uvs.as_ref(), self.uvs, corner, vertex);
            let normal = index(mesh.normals.as_ref(), self.normals, corner, vertex);
            write!(self.out, " {}", self.positions + vertex as usize)?;
            match (uv, normal) {
                (None, None) => Ok(()),
                (Some(t), None) => write!(self.out, "/{t}"),
                (None, Some(n)) => write!(self.out, "//{n}"),
                (Some(t), Some(n)) => write!(self.out, "/{t}/{n}"),
            }?;
        }
        writeln!(self.out)
    }
}

/// Index in the file of a corner's value, whose list begins at `base`.
fn index<T>(list: Option<&Attribute<T>>, base: usize, corner: usize, vertex: u32) -> Option<usize> {
    let corners = &list?.corners;
    let local = corners.as_ref().map_or(vertex, |index| index[corner]);
    Some(base + local as usize)
}

/// What MTL can represent of a reflection model.
#[derive(Clone, Copy)]
enum MtlModel {
    Highlight(Highlight),
    /// Base colour, metalness and roughness.
    Rough(Rgb, f64, f64),
}

fn model(m: &Material) -> Option<MtlModel> {
    let highlight = Highlight::of(m).filter(|_| m.mirror.is_black());
    let rough = || gltf_mr(m).map(|(base, metallic, rough)| MtlModel::Rough(base, metallic, rough));
    highlight.map(MtlModel::Highlight).or_else(rough)
}

impl MtlModel {
    /// Whether reading back yields another model, or another diffuse reflectance.
    fn is_approximate(self, m: &Material) -> bool {
        match self {
            MtlModel::Highlight(highlight) => highlight.angle == Angle::Mirrored,
            MtlModel::Rough(..) => m.finish.is_none() && is_repainted(m),
        }
    }
}

/// Writes a block of MTL.
pub(super) fn write_material(
    scene: &Scene,
    m: &Material,
    name: &str,
    out: &mut dyn Write,
) -> io::Result<()> {
    let model = model(m);
    let kd = match model {
        Some(MtlModel::Rough(base, ..)) => m.finish.map_or(base, |f| f.base),
        // Readers without glass, and Blender, show `Kd`, which is black otherwise.
        _ if m.dielectric.is_some() => m.dielectric.map_or(Rgb::BLACK, |glass| glass.transmittance),
        _ => smooth_metal(m).map_or(m.diffuse, |(base, _)| base),
    };
    writeln!(out, "newmtl {name}\nKd {}", Numbers(&kd.to_array()))?;
    if m.is_emitter() {
        writeln!(out, "Ke {}", Numbers(&m.emission.to_array()))?;
        write_map("map_Ke", "", m.emission_picture, scene, out)?;
    }
    write_surface(scene, m, model, out)?;
    if let Some(opacity) = m.opacity {
        if opacity.constant < 1.0 {
            writeln!(out, "d {}", Numbers(&[opacity.constant]))?;
        }
        write_map("map_d", "", opacity.picture.map(|p| p.texture), scene, out)?;
    }
    if let Some(relief) = &m.relief {
        write_relief(scene, relief, out)?;
    }
    write_map("map_Kd", "", m.textures.first().copied(), scene, out)?;
    writeln!(out)
}

/// What a surface does with light that it does not reflect diffusely, and its `illum`.
fn write_surface(
    scene: &Scene,
    m: &Material,
    model: Option<MtlModel>,
    out: &mut dyn Write,
) -> io::Result<()> {
    if let Some(glass) = m.dielectric {
        let transmittance = glass.transmittance.to_array();
        let (transmittance, ior) = (Numbers(&transmittance), [glass.ior]);
        let ior = Numbers(&ior);
        return writeln!(out, "Tf {transmittance}\nNi {ior}\nPm 0\nPr 0\nillum 7");
    }
    match model {
        Some(MtlModel::Rough(_, metallic, roughness)) => {
            let own = (metallic, roughness);
            let (metallic, roughness) = m.finish.map_or(own, |f| (f.metallic, f.roughness));
            let (metallic, roughness) = ([metallic], [roughness]);
            let (metallic, roughness) = (Numbers(&metallic), Numbers(&roughness));
            writeln!(out, "Pm {metallic}\nPr {roughness}\nillum 2")?;
            write_finish(scene, m, out)
        }
        _ if !m.mirror.is_black() => {
            writeln!(out, "Ks {}", Numbers(&m.mirror.to_array()))?;
            match smooth_metal(m) {
                Some((_, share)) => writeln!(out, "Pm {}\nPr 0\nillum 3", Numbers(&[share])),
                // For Blender, a smooth coat; without `Pr` it is the mirror of `illum` 3 for us.
                None if m.diffuse.max_channel() >= m.mirror.max_channel() => {
                    writeln!(out, "Ns 1000\nPm 0\nillum 3")
                }
                None => writeln!(out, "Ns 1000\nillum 3"),
            }
        }
        Some(MtlModel::Highlight(highlight)) => {
            let highlight = highlight.around_normal();
            let (ks, ns) = (highlight.ks.to_array(), [highlight.n]);
            let (ks, ns) = (Numbers(&ks), Numbers(&ns));
            writeln!(out, "Ks {ks}\nNs {ns}\nillum 2")
        }
        None => writeln!(out, "illum 1"),
    }
}

/// Base colour and metallic share that describe a mirror over a matt surface to the last bit: programs that do not
/// know `illum` 3 see the mirror, too. `None` if there are none.
fn smooth_metal(m: &Material) -> Option<(Rgb, f64)> {
    if m.mirror.is_black() || m.brdf.is_some() || !m.textures.is_empty() {
        return None;
    }
    let base = m.diffuse + m.mirror;
    let share = m.mirror.max_channel() / base.max_channel();
    // As it is read.
    let is_same = (base * (1.0 - share), base * share) == (m.diffuse, m.mirror);
    (is_same && base.max_channel() <= 1.0).then_some((base, share))
}

/// The pictures of metalness and roughness.
fn write_finish(scene: &Scene, m: &Material, out: &mut dyn Write) -> io::Result<()> {
    let Some(finish) = &m.finish else {
        return Ok(());
    };
    let pictures = [
        ("map_Pm", finish.metallic_picture),
        ("map_Pr", finish.roughness_picture),
    ];
    for (keyword, picture) in pictures {
        let options = match picture.map(|p| p.channel) {
            Some(PictureChannel::Green) => "-imfchan g ",
            Some(PictureChannel::Blue) => "-imfchan b ",
            _ => "",
        };
        write_map(keyword, options, picture.map(|p| p.texture), scene, out)?;
    }
    Ok(())
}

/// A relief: normals as `norm`, heights as `map_Bump`.
fn write_relief(scene: &Scene, relief: &Relief, out: &mut dyn Write) -> io::Result<()> {
    let (keyword, factor) = match relief.kind {
        ReliefKind::Normals { scale } => ("norm", scale),
        ReliefKind::Heights { slope } => ("map_Bump", slope),
    };
    let options = match factor {
        1.0 => String::new(),
        factor => format!("-bm {} ", Numbers(&[factor])),
    };
    write_map(keyword, &options, Some(relief.texture), scene, out)
}

/// The statement of a picture, if there is one.
fn write_map(
    keyword: &str,
    options: &str,
    texture: Option<TextureId>,
    scene: &Scene,
    out: &mut dyn Write,
) -> io::Result<()> {
    let Some(texture) = texture.map(|id| &scene.textures[id as usize]) else {
        return Ok(());
    };
    let clamp = match texture.wrap {
        [WrapMode::Clamp, WrapMode::Clamp] => "-clamp on ",
        _ => "",
    };
    let path = one_line(&texture.path);
    writeln!(out, "{keyword} {options}{clamp}{path}")
}

/// Numbers separated by blanks, each the shortest that reads back to the same value.
struct Numbers<'a>(&'a [f64]);

impl fmt::Display for Numbers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, x) in self.0.iter().enumerate() {
            let blank = if i > 0 { " " } else { "" };
            // Without an exponent 1e300 would fill four lines.
            if *x == 0.0 || (1e-5..1e16).contains(&x.abs()) {
                write!(f, "{blank}{x}")?;
            } else {
                write!(f, "{blank}{x:e}")?;
            }
        }
        Ok(())
    }
}

/// A name in a form that reads back unchanged from one line: without control
/// characters, blanks around it, what would begin a comment, or continue the line.
fn one_line(name: &str) -> String {
    let printable: String = name
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    let mut line = printable.trim().replace(" #", "_#");
    if line.ends_with('\\') {
        line.pop();
        line.push('_');
    }
    line
}

/// Materials are identified by name alone, so each gets a unique one.
fn unique_names(materials: &[Material]) -> Vec<String> {
    let mut taken = HashSet::new();
    materials
        .iter()
        .map(|m| {
            let mut name = one_line(&m.name);
            if name.is_empty() {
                name = "material".to_owned();
            }
            let numbered = (2..).map(|i| format!("{name}_{i}"));
            let is_free = |free: &String| taken.insert(free.clone());
            std::iter::once(name.clone())
                .chain(numbered)
                .find(is_free)
                .unwrap_or(name)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::gloss::Gloss;
    use crate::{Memory, obj};
    use azulejo_scene::Shape;
    use azulejo_scene::{
        Dielectric, Light, LightKind, Opacity, OpacityChannel, OpacityPicture, Primitive,
    };
    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    fn written(scene: &Scene) -> (Vec<u8>, Vec<u8>) {
        let (mut obj, mut mtl) = (Vec::new(), Vec::new());
        write(scene, "the materials.mtl", &mut obj, &mut mtl).unwrap();
        (obj, mtl)
    }

    fn read_back(scene: &Scene) -> Scene {
        let (obj, mtl) = written(scene);
        let files = Memory::new().with("the materials.mtl", mtl);
        let loaded = obj::read(&obj, "scene.obj", &files).unwrap();
        loaded.scene.validate().unwrap();
        loaded.scene
    }

    fn share() -> impl Strategy<Value = Rgb> {
        [0.0..=0.5, 0.0..=0.5, 0.0..=0.5f64].prop_map(Rgb::from)
    }

    fn surface() -> impl Strategy<Value = Material> {
        let mirror = (share(), share()).prop_map(|(diffuse, mirror)| Material {
            diffuse,
            mirror,
            ..Material::default()
        });
        let glass = (1.01..3.0f64, share()).prop_map(|(ior, transmittance)| Material {
            mirror: Rgb::WHITE,
            dielectric: Some(Dielectric {
                ior,
                transmittance,
                thin: false,
            }),
            ..Material::default()
        });
        let glossy = (share(), share(), 1.0..1e4f64).prop_map(|(kd, ks, n)| {
            let mut glossy = Material::diffuse("", kd);
            let highlight = Highlight::half(n, ks);
            let _ = Gloss::default().highlight(&mut glossy, highlight);
            glossy
        });
        let rough = (share(), 0.0..=1.0f64, 0.01..0.99f64).prop_map(|(base, metal, rough)| {
            let mut surface = Material::default();
            let made = Gloss::default().metallic_roughness(&mut surface, base, metal, rough);
            made.unwrap();
            surface
        });
        let texture = share().prop_map(|kd| Material {
            diffuse: kd,
            textures: vec![0],
            ..Material::default()
        });
        let emitter = share().prop_map(|c| Material::emitter("", c * 100.0));
        let sheer = (share(), 0.0..1.0f64, any::<bool>()).prop_map(|(kd, opacity, is_pictured)| {
            let picture = OpacityPicture {
                texture: 0,
                channel: OpacityChannel::Luminance,
            };
            Material {
                opacity: Some(Opacity {
                    picture: is_pictured.then_some(picture),
                    ..Opacity::constant(opacity)
                }),
                // Textures are numbered by their first use.
                textures: if is_pictured { vec![0] } else { Vec::new() },
                ..Material::diffuse("", kd)
            }
        });
        prop_oneof![mirror, glass, glossy, rough, texture, emitter, sheer]
    }

    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![-1e3..1e3, prop::num::f64::NORMAL, Just(0.0), Just(-0.0)]
    }

    fn vector() -> impl Strategy<Value = DVec3> {
        [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from)
    }

    fn unit() -> impl Strategy<Value = DVec3> {
        [-1.0..1.0, -1.0..1.0, 0.1..1.0].prop_map(|v| DVec3::from(v).normalize())
    }

    /// Faces whose every vertex is used, with values per corner that no vertex list could hold.
    fn mesh() -> impl Strategy<Value = Mesh> {
        let faces = prop::collection::vec((3usize..7, 0u32..4, 0u32..3), 1..5);
        let extras = (any::<bool>(), any::<bool>(), any::<bool>());
        (faces, extras).prop_flat_map(|(faces, (normals, uvs, colors))| {
            let corners: usize = faces.iter().map(|f| f.0).sum();
            let count = |is_given, n| if is_given { n } else { 0 };
            (
                prop::collection::vec(vector(), corners),
                prop::collection::vec(unit(), count(normals, 2 * corners)),
                prop::collection::vec((coordinate(), coordinate()), count(uvs, corners)),
                prop::collection::vec(share(), count(colors, corners)),
            )
                .prop_map(move |lists| assembled(&faces, lists))
        })
    }

    type Lists = (Vec<DVec3>, Vec<DVec3>, Vec<(f64, f64)>, Vec<Rgb>);

    fn assembled(faces: &[(usize, u32, u32)], (positions, normals, uvs, colors): Lists) -> Mesh {
        let mut mesh = Mesh {
            positions,
            colors,
            ..Mesh::default()
        };
        for &(corners, material, smoothing) in faces {
            let first = mesh.faces.corners.len() as u32;
            mesh.push_face(&Vec::from_iter(first..first + corners as u32), material);
            mesh.smoothing.push(smoothing);
        }
        if mesh.smoothing.iter().all(|s| *s == 0) {
            mesh.smoothing.clear();
        }
        // The first face's vertices are used again with second normals.
        let again: Vec<u32> = mesh.faces.get(0).to_vec();
        mesh.push_face(&again, 0);
        if !mesh.smoothing.is_empty() {
            mesh.smoothing.push(0);
        }
        if !normals.is_empty() {
            let used = mesh.faces.corners.len();
            mesh.normals = Some(Attribute {
                values: normals[..used].to_vec(),
                corners: Some((0..used as u32).collect()),
            });
        }
        if !uvs.is_empty() {
            mesh.uvs = Some(Attribute::per_vertex(
                uvs.into_iter().map(DVec2::from).collect(),
            ));
        }
        mesh
    }

    fn scene() -> impl Strategy<Value = Scene> {
        let materials = prop::collection::vec(surface(), 4);
        let name = "[a-zA-Z#][a-z #áñ漢]{0,8}";
        let objects = prop::collection::vec((name, mesh()), 1..4);
        (materials, objects).prop_map(|(mut materials, mut objects)| {
            // The format cannot take back what it has said.
            if objects.iter().any(|(_, mesh)| !mesh.smoothing.is_empty()) {
                for (_, mesh) in &mut objects {
                    mesh.smoothing.resize(mesh.faces.len(), 0);
                }
            }
            for (i, m) in materials.iter_mut().enumerate() {
                m.name = format!("m {i}");
            }
            let texture = Texture {
                path: "maps/a b.png".into(),
                wrap: [WrapMode::Clamp; 2],
                ..Texture::default()
            };
            let textured = materials.iter().any(|m| !m.textures.is_empty());
            Scene {
                materials,
                textures: Vec::from_iter(textured.then_some(texture)),
                objects: objects
                    .into_iter()
                    .map(|(name, mesh)| Object::new(one_line(&name), Shape::Mesh(mesh)))
                    .collect(),
                ..Scene::default()
            }
        })
    }

    /// Replaces a highlight whose numbers differ only by rounding.
    fn keep_rounded(material: &mut Material, known: &Material) {
        if let (Some(a), Some(b)) = (Highlight::of(material), Highlight::of(known)) {
            let far = (a.ks - b.ks).map(f64::abs).max_channel();
            if a.n == b.n && far <= 1e-12 * b.ks.max_channel() {
                material.brdf.clone_from(&known.brdf);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn written_scenes_are_read_back(scene in scene()) {
            prop_assert_eq!(scene.validate(), Ok(()));
            prop_assert_eq!(losses(&scene), Vec::<String>::new());
            let mut back = read_back(&scene);
            for (material, known) in back.materials.iter_mut().zip(&scene.materials) {
                keep_rounded(material, known);
            }
            prop_assert_eq!(back, scene);
        }
    }

    #[test]
    fn names_that_no_line_can_hold() {
        let mut scene = Scene::default();
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            ..Mesh::default()
        };
        for (i, name) in ["", "a", "a", "a_2", " b\n#c\\"].into_iter().enumerate() {
            scene.add_material(Material::diffuse(name, Rgb::grey(i as f64 / 10.0)));
            mesh.push_face(&[0, 1, 2], i as u32);
        }
        for name in ["", "", "x\ry \\"] {
            scene
                .objects
                .push(Object::new(name, Shape::Mesh(mesh.clone())));
        }
        let back = read_back(&scene);
        let names: Vec<&str> = back.materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["material", "a", "a_2", "a_2_2", "b_#c_"]);
        let names: Vec<&str> = back.objects.iter().map(|o| o.name.as_str()).collect();
        assert_eq!(names, ["", "", "x y _"]);
        assert_eq!(back.objects[2].shape, Shape::Mesh(mesh));
    }

    #[test]
    fn primitives_become_polygons_and_losses_are_reported() {
        let mut scene = Scene::default();
        let white = scene.add_material(Material::diffuse("white", Rgb::grey(0.5)));
        let ball = Primitive::sphere(DVec3::ZERO, 2.0, white);
        scene
            .objects
            .push(Object::new("ball", Shape::Primitive(ball)));
        scene.lights.push(Light {
            name: String::new(),
            kind: LightKind::Ambient {
                radiance: Rgb::WHITE,
            },
        });
        let back = read_back(&scene);
        let Shape::Mesh(mesh) = &back.objects[0].shape else {
            panic!("OBJ has meshes only")
        };
        let area = 16.0 * std::f64::consts::PI;
        assert!((mesh.area() / area - 1.0).abs() < 0.01, "{}", mesh.area());
        let expected = [
            "1 lights without area",
            "1 exact primitives that become polygons",
        ];
        assert_eq!(losses(&scene), expected);
    }

    /// What Blender 5.3 shows as a mirror and as glass, and what is read back as the same.
    #[test]
    fn mirrors_and_glass_are_not_black_elsewhere() {
        let check = |material: Material, expected: &[&str]| {
            let mut scene = Scene::default();
            let id = scene.add_material(Material {
                name: "m".into(),
                ..material
            });
            let mut mesh = Mesh {
                positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
                ..Mesh::default()
            };
            mesh.push_face(&[0, 1, 2], id);
            scene.objects.push(Object::new("o", Shape::Mesh(mesh)));
            let (obj, mtl) = written(&scene);
            let text = String::from_utf8(mtl.clone()).unwrap();
            let lines = text.lines().skip(1).filter(|line| !line.is_empty());
            assert_eq!(lines.collect::<Vec<_>>(), expected);
            let files = Memory::new().with("the materials.mtl", mtl);
            let loaded = obj::read(&obj, "a.obj", &files).unwrap();
            assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
            assert_eq!(loaded.scene.materials, scene.materials);
        };
        let mirror = |diffuse, mirror| Material {
            diffuse,
            mirror,
            ..Material::default()
        };
        check(
            mirror(Rgb::BLACK, Rgb::new(0.9, 0.5, 0.25)),
            &[
                "Kd 0.9 0.5 0.25",
                "Ks 0.9 0.5 0.25",
                "Pm 1",
                "Pr 0",
                "illum 3",
            ],
        );
        check(
            mirror(Rgb::grey(0.5), Rgb::new(0.25, 0.125, 0.0)),
            &[
                "Kd 0.5 0.5 0.5",
                "Ks 0.25 0.125 0",
                "Ns 1000",
                "Pm 0",
                "illum 3",
            ],
        );
        check(
            mirror(Rgb::grey(0.5), Rgb::grey(0.5)),
            &["Kd 1 1 1", "Ks 0.5 0.5 0.5", "Pm 0.5", "Pr 0", "illum 3"],
        );
        let glass = Material {
            mirror: Rgb::WHITE,
            dielectric: Some(Dielectric {
                ior: 1.5,
                transmittance: Rgb::new(0.5, 1.0, 0.75),
                thin: false,
            }),
            ..Material::default()
        };
        check(
            glass,
            &[
                "Kd 0.5 1 0.75",
                "Tf 0.5 1 0.75",
                "Ni 1.5",
                "Pm 0",
                "Pr 0",
                "illum 7",
            ],
        );
    }

    #[test]
    fn a_full_disk_is_an_error() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::StorageFull.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        assert!(write(&Scene::default(), "a.mtl", &mut Full, &mut Vec::new()).is_err());
    }
}
