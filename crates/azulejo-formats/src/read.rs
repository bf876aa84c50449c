//! Models and drawings of any supported format: recognized once, then read by the format's
//! own reader.

#[cfg(feature = "pdf")]
use crate::outline::pdf;
use crate::outline::{Drawing, svg};
use crate::reading::detect::{EXPECTED, Format, detect, recognize};
use crate::reading::gzip;
use crate::reading::options::counted_first;
use crate::reading::text::decoded;
use crate::surface::unpainted::darken_unpainted;
use crate::{
    FileError, Files, FontFile, FontRequest, Loaded, Position, ReadError, ReadOptions, Warning,
};
use crate::{
    abaqus, cityjson, dxf, energyplus, gltf, gmsh, grf, mgf, nastran, obj, off, openflight,
};
use crate::{openfoam, photometry, ply, scn, sff, stl, studio3ds, three_mf, view3d, vrml, vtk};
use azulejo_scene::{Mesh, Scene, Shape};
use std::cell::RefCell;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

/// Reads a model: its bytes, its name, the files that it names, and options.
type FormatReader = fn(&[u8], &str, &dyn Files, &ReadOptions) -> Result<Loaded, ReadError>;

impl Format {
    /// The name of the format as users know it.
    pub fn name(self) -> &'static str {
        self.name_and_reader().0
    }

    /// The function that reads it.
    fn reader(self) -> FormatReader {
        self.name_and_reader().1
    }

    fn name_and_reader(self) -> (&'static str, FormatReader) {
        match self {
            Format::Grf => ("GRF", grf::read_with),
            Format::Obj => ("Wavefront OBJ", obj::read_with),
            Format::Studio3ds => ("3DS", studio3ds::read),
            Format::Dxf => ("DXF", dxf::read),
            Format::OpenFlight => ("OpenFlight", openflight::read),
            Format::Vrml => ("VRML or X3D", vrml::read),
            Format::Mgf => ("MGF", mgf::read),
            Format::Gltf => ("glTF", gltf::read),
            Format::Ply => ("PLY", ply::read),
            Format::Stl => ("STL", stl::read),
            Format::Sff => ("SFF", sff::read),
            Format::Scn => ("SCN", scn::read),
            Format::View3d => ("View3D", view3d::read),
            Format::Gmsh => ("gmsh", gmsh::read),
            Format::Off => ("OFF", off::read),
            Format::Vtk => ("VTK", vtk::read),
            Format::Nastran => ("NASTRAN bulk data", nastran::read),
            Format::Abaqus => ("Abaqus or CalculiX input", abaqus::read),
            Format::OpenFoam => ("OpenFOAM", openfoam::read),
            Format::CityJson => ("CityJSON", cityjson::read),
            Format::EnergyPlus => ("EnergyPlus", energyplus::read),
            Format::Photometry => ("photometric file (IES LM-63, EULUMDAT)", photometry::read),
            Format::ThreeMf => ("3MF", three_mf::read),
        }
    }
}

/// A model and the format that it was recognized as.
#[derive(Clone, Debug)]
pub struct RecognizedModel {
    /// The model; valid in the sense of [`Scene::validate`], in the axes and the unit of its file.
    pub scene: Scene,
    /// What was skipped, repaired or guessed.
    pub warnings: Vec<Warning>,
    /// The format of the file.
    pub format: Format,
    /// The other files that were read for it, by their names relative to its folder, sorted.
    pub files: Vec<String>,
}

/// Files, with the names of those that were read.
struct ListedFiles<'a> {
    files: &'a dyn Files,
    names: RefCell<BTreeSet<String>>,
}

impl Files for ListedFiles<'_> {
    fn read(&self, name: &str) -> Result<Vec<u8>, FileError> {
        let bytes = self.files.read(name)?;
        self.names.borrow_mut().insert(name.to_owned());
        Ok(bytes)
    }

    fn font(&self, request: &FontRequest) -> Option<FontFile> {
        self.files.font(request)
    }
}

/// Reads a model in any supported format, compressed with gzip or not. `name` is used in messages;
/// `files` provides the files that the model names, relative to the model's folder.
///
/// # Errors
/// An unknown format, and the errors of the format's own reader.
pub fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<RecognizedModel, ReadError> {
    read_with(bytes, name, files, &ReadOptions::default())
}

/// Like [`read`], with options.
///
/// # Errors
/// As [`read`].
pub fn read_with(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<RecognizedModel, ReadError> {
    let bytes = &*gzip::unpacked(bytes, name, options)?;
    let format = recognize(bytes, name)
        .map_err(|unrecognized| ReadError::whole(name, unrecognized.looks_like, EXPECTED))?;
    let read = format.reader();
    let listed = ListedFiles {
        files,
        names: RefCell::default(),
    };
    let loaded = counted_first(bytes.len(), options, |options| {
        read(bytes, name, &listed, options)
    })?;
    let (mut scene, mut warnings) = (loaded.scene, loaded.warnings);
    // A GRF file keeps its vertices, in which its light is stored, and the reflectances of that light.
    if format != Format::Grf {
        warnings.extend(divide_crossing_faces(&mut scene, name));
        if options.darkens_unpainted {
            warnings.extend(darken_unpainted(&mut scene, name));
        }
    }
    scene.join_sides();
    Ok(RecognizedModel {
        scene,
        warnings,
        format,
        files: listed.names.into_inner().into_iter().collect(),
    })
}

/// Divides the faces whose edges cross, and says how many there were.
fn divide_crossing_faces(scene: &mut Scene, name: &str) -> Option<Warning> {
    let mut count = 0;
    for object in &mut scene.objects {
        if let Shape::Mesh(mesh) = &mut object.shape {
            count += mesh.divide_crossing_faces();
        }
    }
    count += divide_in_shared_meshes(scene);
    (count > 0).then(|| Warning {
        file: name.to_owned(),
        position: Position::Whole,
        message: "face whose edges cross: divided where they do, its inside by the even-odd rule"
            .to_owned(),
        count,
    })
}

/// Divides the faces of shared meshes once for all their instances; meshes with light at a place stay as
/// they are. The number of faces counts each instance.
fn divide_in_shared_meshes(scene: &mut Scene) -> usize {
    let instances = scene.objects.iter_mut();
    let instances: Vec<_> = instances
        .filter_map(|object| match &mut object.shape {
            Shape::Instance(instance) => Some(instance),
            _ => None,
        })
        .collect();
    let lit = instances.iter().filter(|i| i.light.is_some());
    let lit: HashSet<*const Mesh> = lit.map(|i| Arc::as_ptr(&i.mesh)).collect();
    let mut divided: HashMap<*const Mesh, (usize, Arc<Mesh>)> = HashMap::new();
    for instance in &instances {
        let address = Arc::as_ptr(&instance.mesh);
        if !lit.contains(&address) {
            divided.entry(address).or_insert_with(|| {
                let mut mesh = Mesh::clone(&instance.mesh);
                match mesh.divide_crossing_faces() {
                    0 => (0, instance.mesh.clone()),
                    count => (count, Arc::new(mesh)),
                }
            });
        }
    }
    let mut count = 0;
    for instance in instances {
        if let Some((mesh_count, mesh)) = divided.get(&Arc::as_ptr(&instance.mesh)) {
            instance.mesh = mesh.clone();
            count += mesh_count;
        }
    }
    count
}

/// Reads an SVG, DXF or PDF drawing, recognized by its content. `name` is used in messages; `files` provides the fonts of
/// texts in SVG and DXF. PDF needs the feature `pdf`.
///
/// # Errors
/// Another format, a page of a drawing that has none, and the errors of [`svg::read`], [`dxf::read_figures`] and
/// `pdf::read`.
pub fn read_drawing(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Drawing, ReadError> {
    const EXPECTED: &str = "a drawing in SVG, DXF or PDF";
    let bytes = &*decoded(bytes);
    let is_svg = svg::is_svg(bytes);
    #[cfg(feature = "pdf")]
    if !is_svg && pdf::is_pdf(bytes) {
        return counted_first(bytes.len(), options, |options| {
            pdf::read(bytes, name, options)
        });
    }
    if let Some(page) = options.page {
        let found = format!("page {page} of a file that is no PDF");
        return Err(ReadError::whole(name, found, "a name without a page"));
    }
    if is_svg {
        return counted_first(bytes.len(), options, |options| {
            svg::read(bytes, name, files, options)
        });
    }
    match detect(bytes) {
        Ok(Format::Dxf) => counted_first(bytes.len(), options, |options| {
            dxf::read_figures(bytes, name, files, options)
        }),
        Ok(other) => {
            let found = format!("a model in {}", other.name());
            Err(ReadError::whole(name, found, EXPECTED))
        }
        Err(unrecognized) => Err(ReadError::whole(name, unrecognized.looks_like, EXPECTED)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::{ppe, ppf};
    use crate::{Memory, brdf, camera_json};
    use azulejo_scene::{BackIrradiance, Material, Mesh, Object, Rgb, Sidedness};
    use glam::DVec3;

    /// The text as UTF-8 with a byte-order mark, and as UTF-16 in both byte orders with and without one.
    fn encodings(text: &str) -> [Vec<u8>; 5] {
        let utf16 = |text: &str, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(bytes).collect()
        };
        let marked = format!("\u{feff}{text}");
        [
            marked.clone().into_bytes(),
            utf16(&marked, u16::to_le_bytes),
            utf16(&marked, u16::to_be_bytes),
            utf16(text, u16::to_le_bytes),
            utf16(text, u16::to_be_bytes),
        ]
    }

    fn check<T: PartialEq + std::fmt::Debug>(text: &str, read: impl Fn(&[u8]) -> T) {
        let plain = read(text.as_bytes());
        for bytes in encodings(text) {
            assert_eq!(read(&bytes), plain, "{:?} of {text}", &bytes[..8]);
        }
    }

    /// A small model in every format that has a text form, with its file name.
    const MODELS: [(Format, &str, &str); 25] = [
        (
            Format::Grf,
            "a.grf",
            "// \u{e9}\nbegin mesh begin vertices (0,0,0) (1,0,0) (0,1,0) end begin faces (0,1,2) end end",
        ),
        (
            Format::Obj,
            "a.obj",
            "o caf\u{e9}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        ),
        (
            Format::Mgf,
            "a.mgf",
            "# caf\u{e9}\nv a =\n p 0 0 0\nv b =\n p 1 0 0\nv c =\n p 0 1 0\nf a b c\n",
        ),
        (Format::Mgf, "b.mgf", "i a.mgf\n"),
        (Format::Grf, "b.grf", "include \"a.grf\"\n"),
        (Format::Scn, "a.scn", "sphere 0 0 0 1\n"),
        (Format::Scn, "b.scn", "#include \"a.scn\"\nsphere 2 0 0 1\n"),
        (
            Format::View3d,
            "a.vs3",
            "T one \u{e9}\nF 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 0 1 0\nS 1 1 2 3 0 0 0 .5 low\nEnd\n",
        ),
        (
            Format::Nastran,
            "a.bdf",
            "$ Femap Property 1 : caf\u{e9}\nGRID,1,,0.\nGRID,2,,1.\nGRID,3,,0.,1.\nCTRIA3,1,1,1,2,3\n",
        ),
        (
            Format::Abaqus,
            "a.inp",
            "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n*ELEMENT,TYPE=S3,ELSET=caf\u{e9}\n1,1,2,3\n",
        ),
        (
            Format::Ply,
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        ),
        (
            Format::Stl,
            "a.stl",
            "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
        ),
        (
            Format::Dxf,
            "a.dxf",
            "0\nSECTION\n2\nENTITIES\n0\n3DFACE\n10\n0\n20\n0\n30\n0\n11\n1\n21\n0\n31\n0\n12\n0\n22\n1\n32\n0\n0\nENDSEC\n0\nEOF\n",
        ),
        (
            Format::Vrml,
            "a.wrl",
            "#VRML V2.0 utf8\nDEF caf\u{e9} Shape { geometry Box {} }\n",
        ),
        (Format::Vrml, "b.wrl", "#VRML V1.0 ascii\nCube {}\n"),
        (
            Format::Vrml,
            "a.x3d",
            "<X3D><Scene><Shape><Box/></Shape></Scene></X3D>",
        ),
        (
            Format::CityJson,
            "a.city.json",
            "{\"type\":\"CityJSON\",\"version\":\"2.0\",\"CityObjects\":{\"caf\u{e9}\":{\"type\":\"Building\",\"geometry\":[{\"type\":\"MultiSurface\",\"lod\":\"2\",\"boundaries\":[[[0,1,2]]]}]}},\"vertices\":[[0,0,0],[1,0,0],[0,1,0]]}",
        ),
        (
            Format::EnergyPlus,
            "a.idf",
            "! caf\u{e9}\nVersion,25.1;\nBuilding, caf\u{e9};\nZone, Z;\nWall:Exterior, W, C, Z, , 180, 90, 0, 0, 0, 4, 3;\n",
        ),
        (
            Format::EnergyPlus,
            "a.epJSON",
            "{\"Wall:Exterior\":{\"caf\u{e9}\":{\"zone_name\":\"Z\",\"length\":4,\"height\":3}}}",
        ),
        (Format::Gltf, "a.gltf", "{\"asset\":{\"version\":\"2.0\"}}"),
        (
            Format::Sff,
            "a.sff",
            "view\n0 0 10\n0 0 0\n0 1 0\n30 20\ncolors\n.1 .2 .3\n.1 .1 .1\n",
        ),
        (
            Format::Gmsh,
            "a.msh",
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"caf\u{e9}\"\n$EndPhysicalNames\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n",
        ),
        (
            Format::Off,
            "a.off",
            "OFF # caf\u{e9}\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        ),
        (
            Format::Vtk,
            "a.vtk",
            "# vtk DataFile Version 3.0\ncaf\u{e9}\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n",
        ),
        (
            Format::Vtk,
            "a.vtp",
            "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"0\"/></PolyData></VTKFile>",
        ),
    ];

    /// A sheet of a quadrilateral and a triangle with light on both sides, and a triangle with light
    /// on its front.
    fn sheets() -> Scene {
        let mut scene = Scene::default();
        let paper = Material {
            sidedness: Sidedness::Two,
            ..Material::diffuse("paper", Rgb::grey(0.5))
        };
        scene.add_material(paper);
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (2.0, 0.5)];
        let apart = [(5.0, 0.0), (6.0, 0.0), (5.0, 1.0)];
        let mut mesh = Mesh {
            positions: outline
                .iter()
                .chain(&apart)
                .map(|&(x, y)| at(x, y))
                .collect(),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], 0);
        mesh.push_face(&[1, 4, 2], 0);
        mesh.push_face(&[5, 6, 7], 0);
        let light = |first: u32| (first..first + 8).map(|k| Rgb::grey(f64::from(k)));
        mesh.irradiance = light(1).collect();
        mesh.back = Some(Box::new(BackIrradiance {
            irradiance: light(20).map(Some).take(5).chain([None; 3]).collect(),
            error: Vec::new(),
        }));
        scene.objects.push(Object::new("sheets", Shape::Mesh(mesh)));
        scene.validate().unwrap();
        scene
    }

    /// The light on front and back at a point of a mesh.
    fn light_at(mesh: &Mesh, place: DVec3) -> (f64, Option<f64>) {
        let near = |p: &DVec3| p.distance(place) < 1e-6;
        let v = mesh
            .positions
            .iter()
            .position(near)
            .expect("a vertex there");
        let back = mesh.back.as_ref().and_then(|b| b.irradiance[v]);
        (mesh.irradiance[v].mean(), back.map(Rgb::mean))
    }

    #[test]
    fn both_sides_of_sheets_come_back_from_every_format() {
        let given = sheets();
        let Shape::Mesh(mesh) = &given.objects[0].shape else {
            unreachable!("the scene is a mesh")
        };
        let split = given.split_sides();
        type Writer = fn(&Scene, &mut dyn std::io::Write) -> std::io::Result<()>;
        let files: [(&str, Writer, &Scene); 5] = [
            ("a.grf", grf::write, &given),
            ("a.grf", grf::write, &split),
            ("a.glb", gltf::write, &given),
            ("a.ply", ply::write, &given),
            ("a.glb", gltf::write, &split),
        ];
        for (name, write, scene) in files {
            let mut bytes = Vec::new();
            write(scene, &mut bytes).unwrap();
            let again = read(&bytes, name, &Memory::new()).unwrap().scene;
            again.validate().unwrap();
            let Shape::Mesh(read) = &again.objects[0].shape else {
                panic!("{name}: a mesh")
            };
            assert!(
                (read.area() - mesh.area()).abs() < 1e-6,
                "{name}: {}",
                read.area()
            );
            for (v, &p) in mesh.positions.iter().enumerate() {
                let (front, back) = light_at(read, p);
                assert!(
                    (front - mesh.irradiance[v].mean()).abs() < 1e-4,
                    "{name}: {front}"
                );
                let expected = mesh.back.as_ref().unwrap().irradiance[v].map(Rgb::mean);
                assert_eq!(back.is_some(), expected.is_some(), "{name}: {p}");
                let off = back.unwrap_or(0.0) - expected.unwrap_or(0.0);
                assert!(off.abs() < 1e-4, "{name}: {back:?}");
            }
            if name != "a.ply" {
                let of = |face: usize| {
                    let id = read.face_materials[face];
                    again.materials[id as usize].sidedness
                };
                let double = (0..read.faces.len()).filter(|&f| read.has_back(f));
                assert!(double.map(of).all(|s| s == Sidedness::Two), "{name}");
            }
        }
    }

    #[test]
    fn models_in_every_encoding_of_text() {
        for (format, name, text) in MODELS {
            // The files that a model includes are in the same encoding as the model.
            let read = |bytes: &[u8], k: Option<usize>| {
                let files = MODELS.iter().fold(Memory::new(), |files, (_, name, text)| {
                    let bytes =
                        k.map_or_else(|| text.as_bytes().to_vec(), |k| encodings(text)[k].clone());
                    files.with(*name, bytes)
                });
                let read = read(bytes, name, &files);
                read.map(|model| (model.format, model.scene, model.warnings))
            };
            let plain = read(text.as_bytes(), None);
            match &plain {
                Ok((detected, ..)) => assert_eq!(*detected, format, "{name}"),
                Err(error) => panic!("{error}"),
            }
            for (k, bytes) in encodings(text).iter().enumerate() {
                assert_eq!(read(bytes, Some(k)), plain, "{name}, encoding {k}");
            }
        }
    }

    #[test]
    fn other_text_in_every_encoding() {
        let options = ReadOptions::default();
        check("/caf\u{e9} 1 4 l 0 0 l 1 0 l 1 1 l 0 1\n", |b| {
            ppf::read(b, "a.ppf")
        });
        check("65/A\n66/caf\u{e9}\n", |b| ppe::read(b, "a.ppe"));
        check("phong n = 20 ks = 0.2 kd = 0.4", |b| {
            let read = brdf::read(b, "a.brdf", &Memory::new());
            read.map(|loaded| (loaded.content, loaded.warnings))
        });
        check(
            "{\"camera\":{\"eye\":[0,0,5],\"target\":[0,0,0],\"vfov_deg\":40}}",
            |b| camera_json::read(b, "a.json"),
        );
        for drawing in [
            "<svg xmlns=\"http://www.w3.org/2000/svg\"><rect width=\"2\" height=\"1\"/></svg>",
            "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n10\n0\n20\n0\n40\n1\n0\nENDSEC\n0\nEOF\n",
        ] {
            check(drawing, |b| {
                let read = read_drawing(b, "a", &Memory::new(), &options);
                read.map(|drawing| (drawing.shapes, drawing.warnings))
            });
        }
        check("newmtl caf\u{e9}\nKd .1 .2 .3\n", |library| {
            let files = Memory::new().with("a.mtl", library);
            let text = "mtllib a.mtl\nusemtl caf\u{e9}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
            let Loaded { scene, warnings } = obj::read(text.as_bytes(), "a.obj", &files).unwrap();
            assert_eq!(warnings, []);
            scene
        });
    }

    #[test]
    fn bow_ties_are_divided() {
        let text = "v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 2 0\nf 1 2 3 4\n";
        let model = read(text.as_bytes(), "a.obj", &Memory::new()).unwrap();
        assert!(model.warnings[0].message.contains("edges cross"));
        let Shape::Mesh(mesh) = &model.scene.objects[0].shape else {
            panic!("a mesh")
        };
        assert_eq!((mesh.faces.len(), mesh.area()), (2, 2.0));
        model.scene.validate().unwrap();
    }

    #[test]
    fn bow_ties_of_instances_are_divided_once() {
        let bow_ties = "f a b c d\n".repeat(20);
        let text = format!(
            "v a =\np 0 0 0\nv b =\np 2 2 0\nv c =\np 2 0 0\nv d =\np 0 2 0\nm m =\nrd .5\n\
             xf -a 3 -t 5 0 0\n{bow_ties}xf\n"
        );
        let model = read(text.as_bytes(), "a.mgf", &Memory::new()).unwrap();
        model.scene.validate().unwrap();
        assert_eq!(model.warnings[0].count, 60);
        let meshes = model.scene.shared_meshes();
        assert_eq!((meshes.len(), meshes[0].faces.len()), (1, 40));
    }

    #[test]
    fn the_byte_order_mark_is_not_a_column() {
        for text in ["\u{feff}v x", "v x"] {
            let error = obj::read(text.as_bytes(), "a.obj", &Memory::new()).unwrap_err();
            assert_eq!(error.position, Position::Line(1, 3));
            assert_eq!(error.source_line.as_deref(), Some("v x"));
        }
    }
}
