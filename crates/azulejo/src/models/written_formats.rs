//! The formats that models are written in.

use ModelWriter::{One, Pictured, Several, Solid, Two};
use azulejo_formats::{dxf, gltf, grf, obj, ply, sff, stl, three_mf, view3d, vrml};
use azulejo_scene::{Material, Scene};
use std::io::{self, Write};
use std::path::Path;

/// A format that scenes can be written in.
#[derive(Debug)]
pub struct WrittenFormat {
    /// Its name.
    pub name: &'static str,
    /// Its extension in lower case, without the dot.
    pub extension: &'static str,
    /// Whether it can store the irradiance on the vertices.
    pub keeps_light: bool,
    /// Whether it stores light as numbers of 32 bits.
    pub(super) is_single: bool,
    pub(super) writer: ModelWriter,
    losses: fn(&Scene) -> Vec<String>,
}

#[derive(Debug)]
pub(super) enum ModelWriter {
    /// One file.
    One(fn(&Scene, &mut dyn Write) -> io::Result<()>),
    /// A file and another with this extension, to which it refers.
    Two(
        &'static str,
        fn(&Scene, &str, &mut dyn Write, &mut dyn Write) -> io::Result<()>,
    ),
    /// A file and others to which it refers, whose names start with its own.
    Several(fn(&Scene, &str, &mut dyn Write) -> io::Result<NamedFiles>),
    /// One file of closed polygons, whose chords deviate by so much from exact solids.
    Solid(fn(&Scene, Option<f64>, &mut dyn Write) -> io::Result<()>),
    /// A file that refers to images, relative to its folder.
    Pictured(fn(&Scene, &[String], &mut dyn Write) -> io::Result<()>),
}

/// Files by name.
pub(super) type NamedFiles = Vec<(String, Vec<u8>)>;

/// All formats; the first is that of standard output.
pub static FORMATS: [WrittenFormat; 12] = [
    format(
        "GRF",
        "grf",
        Pictured(grf::write_with_pictures),
        grf::losses,
    )
    .keeping_light(),
    format("OBJ", "obj", Two("mtl", obj::write), obj::losses),
    format("glTF", "glb", One(gltf::write), gltf::losses)
        .keeping_light()
        .single(),
    format("glTF", "gltf", Two("bin", gltf::write_json), gltf::losses)
        .keeping_light()
        .single(),
    format("PLY", "ply", One(ply::write), ply::losses)
        .keeping_light()
        .single(),
    format("SFF", "sff", Several(sff::write), sff::losses),
    format("View3D", "vs3", One(view3d::write), view3d::losses),
    format("VRML97", "wrl", Pictured(vrml::write), vrml::losses),
    format("X3D", "x3d", Pictured(vrml::write_x3d), vrml::losses),
    format("STL", "stl", Solid(stl::write_within), stl::losses).single(),
    format("DXF", "dxf", One(dxf::write), dxf::losses),
    format(
        "3MF",
        "3mf",
        Solid(three_mf::write_within),
        three_mf::losses,
    ),
];

/// A format that keeps no light and has numbers of 64 bits.
const fn format(
    name: &'static str,
    extension: &'static str,
    writer: ModelWriter,
    losses: fn(&Scene) -> Vec<String>,
) -> WrittenFormat {
    WrittenFormat {
        name,
        extension,
        keeps_light: false,
        is_single: false,
        writer,
        losses,
    }
}

/// GRF without extensions.
pub(super) static PLAIN_GRF: WrittenFormat = format(
    "plain GRF",
    "grf",
    Pictured(grf::write_plain),
    grf::plain_losses,
)
.keeping_light();

impl WrittenFormat {
    const fn keeping_light(self) -> WrittenFormat {
        WrittenFormat {
            keeps_light: true,
            ..self
        }
    }

    const fn single(self) -> WrittenFormat {
        WrittenFormat {
            is_single: true,
            ..self
        }
    }

    /// Whether it is text, in which numbers may have fewer digits.
    pub fn is_text(&self) -> bool {
        !matches!(self.extension, "glb" | "gltf" | "ply" | "stl" | "3mf")
    }

    /// Whether meshes have normals that other programs use.
    pub(super) fn has_normals(&self) -> bool {
        matches!(
            self.extension,
            "obj" | "glb" | "gltf" | "ply" | "wrl" | "x3d"
        )
    }

    /// Whether spheres and other exact shapes stay what they are.
    pub(super) fn has_exact_shapes(&self) -> bool {
        !matches!(self.extension, "obj" | "ply" | "dxf")
    }

    /// Whether all exact shapes stay what they are.
    pub(super) fn keeps_outlines(&self) -> bool {
        matches!(self.name, "GRF" | "SFF")
    }

    /// Whether it is for printers, which need closed surfaces.
    pub(super) fn is_for_printers(&self) -> bool {
        matches!(self.writer, Solid(_))
    }

    /// Whether a model is one file, which may be compressed.
    fn is_alone(&self) -> bool {
        matches!(self.writer, One(_) | Pictured(_) | Solid(_))
    }

    /// What of a scene the format cannot represent, as text; empty if nothing is lost.
    pub fn losses(&self, scene: &Scene) -> Vec<String> {
        let mut losses = (self.losses)(scene);
        if !self.keeps_surface_pictures() {
            let materials = |lost: fn(&Material) -> bool| {
                let count = scene.materials.iter().filter(|m| lost(m)).count();
                (count > 0).then_some(count)
            };
            let emitted = materials(|m| m.emission_picture.is_some());
            losses.extend(emitted.map(|n| format!("{n} pictures of emission, whose mean shines")));
            let others = materials(|m| m.finish.is_some() || m.relief.is_some());
            losses
                .extend(others.map(|n| format!("{n} materials with pictures of finish or relief")));
        }
        let mapped = scene.objects.iter();
        let mapped = mapped.filter(|o| scene.is_lightmapped(&o.shape)).count();
        if mapped > 0 && !matches!(self.extension, "glb" | "gltf") {
            losses.push(format!("{mapped} lightmaps, and with them their light"));
        }
        losses
    }

    /// Whether it has pictures of emission, metalness, roughness and relief.
    pub(super) fn keeps_surface_pictures(&self) -> bool {
        matches!(self.name, "GRF" | "OBJ") || matches!(self.extension, "glb" | "gltf")
    }
}

/// The format of a path's extension, regardless of case, with `.gz` behind it or not; GRF for `-`,
/// standard output.
pub fn by_extension(path: &Path) -> Option<&'static WrittenFormat> {
    if is_gzip(path) {
        let format = by_extension(path.file_stem().map(Path::new)?)?;
        return format.is_alone().then_some(format);
    }
    match path.extension().and_then(|e| e.to_str()) {
        None if path == Path::new("-") => FORMATS.first(),
        None => None,
        Some(extension) => FORMATS
            .iter()
            .find(|f| f.extension.eq_ignore_ascii_case(extension)),
    }
}

/// Whether a file is to be compressed.
pub(super) fn is_gzip(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.is_some_and(|e| e.eq_ignore_ascii_case("gz"))
}

/// The extensions of some formats, for a message.
pub(super) fn extensions(which: fn(&WrittenFormat) -> bool) -> String {
    let some = FORMATS.iter().filter(|f| which(f));
    let names: Vec<String> = some.map(|f| format!(".{}", f.extension)).collect();
    names.join(", ")
}
