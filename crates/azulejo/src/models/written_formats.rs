//! The formats that models are written in.

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
    /// A file that refers to images, relative to its folder.
    Pictured(fn(&Scene, &[String], &mut dyn Write) -> io::Result<()>),
}

/// Files by name.
pub(super) type NamedFiles = Vec<(String, Vec<u8>)>;

/// All formats; the first is that of standard output.
pub static FORMATS: [WrittenFormat; 12] = [
    WrittenFormat {
        name: "GRF",
        extension: "grf",
        is_single: false,
        writer: ModelWriter::Pictured(grf::write_with_pictures),
        keeps_light: true,
        losses: grf::losses,
    },
    WrittenFormat {
        name: "OBJ",
        extension: "obj",
        is_single: false,
        writer: ModelWriter::Two("mtl", obj::write),
        keeps_light: false,
        losses: obj::losses,
    },
    WrittenFormat {
        name: "glTF",
        extension: "glb",
        is_single: true,
        writer: ModelWriter::One(gltf::write),
        keeps_light: true,
        losses: gltf::losses,
    },
    WrittenFormat {
        name: "glTF",
        extension: "gltf",
        is_single: true,
        writer: ModelWriter::Two("bin", gltf::write_json),
        keeps_light: true,
        losses: gltf::losses,
    },
    WrittenFormat {
        name: "PLY",
        extension: "ply",
        is_single: true,
        writer: ModelWriter::One(ply::write),
        keeps_light: true,
        losses: ply::losses,
    },
    WrittenFormat {
        name: "SFF",
        extension: "sff",
        is_single: false,
        writer: ModelWriter::Several(sff::write),
        keeps_light: false,
        losses: sff::losses,
    },
    WrittenFormat {
        name: "View3D",
        extension: "vs3",
        is_single: false,
        writer: ModelWriter::One(view3d::write),
        keeps_light: false,
        losses: view3d::losses,
    },
    WrittenFormat {
        name: "VRML97",
        extension: "wrl",
        is_single: false,
        writer: ModelWriter::Pictured(vrml::write),
        keeps_light: false,
        losses: vrml::losses,
    },
    WrittenFormat {
        name: "X3D",
        extension: "x3d",
        is_single: false,
        writer: ModelWriter::Pictured(vrml::write_x3d),
        keeps_light: false,
        losses: vrml::losses,
    },
    WrittenFormat {
        name: "STL",
        extension: "stl",
        is_single: true,
        writer: ModelWriter::One(stl::write),
        keeps_light: false,
        losses: stl::losses,
    },
    WrittenFormat {
        name: "DXF",
        extension: "dxf",
        is_single: false,
        writer: ModelWriter::One(dxf::write),
        keeps_light: false,
        losses: dxf::losses,
    },
    WrittenFormat {
        name: "3MF",
        extension: "3mf",
        is_single: false,
        writer: ModelWriter::One(three_mf::write),
        keeps_light: false,
        losses: three_mf::losses,
    },
];

/// GRF without extensions.
pub(super) static PLAIN_GRF: WrittenFormat = WrittenFormat {
    name: "plain GRF",
    extension: "grf",
    is_single: false,
    writer: ModelWriter::Pictured(grf::write_plain),
    keeps_light: true,
    losses: grf::plain_losses,
};

impl WrittenFormat {
    /// Whether it is text, in which numbers may have fewer digits.
    pub fn is_text(&self) -> bool {
        !matches!(self.extension, "glb" | "gltf" | "ply" | "stl" | "3mf")
    }

    /// Whether a model is one file, which may be compressed.
    fn is_alone(&self) -> bool {
        matches!(self.writer, ModelWriter::One(_) | ModelWriter::Pictured(_))
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
