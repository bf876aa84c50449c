//! What each request asks for: titles, names and extensions.

use crate::app::App;
use crate::bake::LightmapFile;
use crate::command::FileRequest;
use crate::library::slug;
use crate::ui::panel_context::PanelContext;
use std::path::PathBuf;

/// Extensions of readable models, for the file dialog; the format is detected from the content.
const MODELS: [&str; 35] = [
    "3ds", "dxf", "obj", "flt", "wrl", "vrml", "x3d", "x3dv", "mgf", "gltf", "glb", "ply", "stl",
    "3mf", "sff", "scn", "grf", "vs3", "msh", "off", "vtk", "vtu", "vtp", "bdf", "nas", "dat",
    "fem", "blk", "inp", "foam", "json", "jsonl", "idf", "epjson", "gz",
];

/// The extension added to a name without one.
pub fn default_extension(what: FileRequest) -> Option<&'static str> {
    match what {
        FileRequest::SaveAs => Some("grf"),
        FileRequest::SaveRender => Some("png"),
        FileRequest::SaveLightmap(what) => Some(what.extension()),
        FileRequest::SaveBrdf => Some("brdf"),
        FileRequest::SaveProbes | FileRequest::SaveTaskPlane => Some("csv"),
        _ => None,
    }
}

/// The name that is proposed to save under, from that of the document and, for a reflection model,
/// that of its material; none to open a file.
pub fn proposed_name(what: FileRequest, stem: &str, app: &App) -> String {
    match what {
        FileRequest::SaveAs => format!("{stem}.grf"),
        FileRequest::Export => format!("{stem}.glb"),
        FileRequest::SaveRender => format!("{stem}.png"),
        FileRequest::SaveLightmap(what) => lightmap_name(stem, what),
        FileRequest::SaveProbes => format!("{stem}-probes.csv"),
        FileRequest::SaveTaskPlane => format!("{stem}-task-plane.csv"),
        FileRequest::SaveBrdf => brdf_name(app),
        _ => String::new(),
    }
}

/// The name that is proposed for a reflection model: that of its material.
fn brdf_name(app: &App) -> String {
    let id = app.selection.material;
    let material = id.and_then(|id| app.document.materials.get(id as usize));
    let name = material.map_or(String::new(), |m| slug(&m.name));
    let name = if name.is_empty() { "material" } else { &name };
    format!("{name}.brdf")
}

/// The name that is proposed: another one than that of the model, which would be replaced.
fn lightmap_name(stem: &str, what: LightmapFile) -> String {
    let part = match what {
        LightmapFile::Model => "baked",
        LightmapFile::Irradiance => "irradiance",
        LightmapFile::StandardError => "error",
    };
    format!("{stem}-{part}.{}", what.extension())
}

/// Whether the request is for a file to write.
pub fn saves(what: FileRequest) -> bool {
    matches!(
        what,
        FileRequest::SaveAs
            | FileRequest::Export
            | FileRequest::SaveRender
            | FileRequest::SaveLightmap(_)
            | FileRequest::SaveBrdf
            | FileRequest::SaveProbes
            | FileRequest::SaveTaskPlane
    )
}

/// Whether several files may be chosen.
pub fn takes_many(what: FileRequest) -> bool {
    matches!(what, FileRequest::Open | FileRequest::Add)
}

/// The extensions of the files that the dialog lists; empty for all files.
pub fn extensions(what: FileRequest) -> &'static [&'static str] {
    match what {
        FileRequest::Open | FileRequest::Add | FileRequest::SaveAs | FileRequest::Export => &MODELS,
        FileRequest::Recipe => &["toml"],
        FileRequest::Environment(_) => &["hdr", "exr"],
        FileRequest::Backplate => &["png", "jpg", "jpeg", "hdr"],
        FileRequest::SaveRender => &["png", "exr", "hdr"],
        FileRequest::SaveLightmap(LightmapFile::Model) => &["glb", "gltf"],
        FileRequest::SaveLightmap(_) => &["exr"],
        FileRequest::Outline => &["svg", "dxf", "pdf"],
        FileRequest::SaveProbes | FileRequest::SaveTaskPlane => &["csv"],
        FileRequest::Font | FileRequest::LoadBrdf | FileRequest::SaveBrdf => &[],
    }
}

/// The title of the dialog.
pub fn title(what: FileRequest, cx: &PanelContext) -> &'static str {
    match what {
        FileRequest::Open => cx.tr("Open models"),
        FileRequest::Add => cx.tr("Add models"),
        FileRequest::SaveAs => cx.tr("Save as GRF"),
        FileRequest::Export => cx.tr("Export a copy"),
        FileRequest::SaveRender => cx.tr("Save the image"),
        FileRequest::SaveLightmap(LightmapFile::Model) => cx.tr("Save the model with its lightmap"),
        FileRequest::SaveLightmap(LightmapFile::Irradiance) => cx.tr("Save the irradiance"),
        FileRequest::SaveLightmap(LightmapFile::StandardError) => cx.tr("Save the standard error"),
        FileRequest::Backplate => cx.tr("Choose a background image"),
        FileRequest::Recipe => cx.tr("Choose a recipe"),
        FileRequest::Environment(_) => cx.tr("Choose an environment map"),
        FileRequest::Font => cx.tr("Choose a font"),
        FileRequest::Outline => cx.tr("Choose a drawing to extrude"),
        FileRequest::LoadBrdf => cx.tr("Load a reflection model"),
        FileRequest::SaveBrdf => cx.tr("Save the reflection model"),
        FileRequest::SaveProbes => cx.tr("Save the probes"),
        FileRequest::SaveTaskPlane => cx.tr("Save the task plane"),
    }
}

/// What the dialog asks for.
#[derive(Clone, Debug)]
#[cfg_attr(
    target_arch = "wasm32",
    expect(dead_code, reason = "a browser asks in its own way")
)]
pub struct NativeFileRequest {
    pub title: String,
    /// Whether a file is written.
    pub saves: bool,
    /// Whether several files may be chosen.
    pub many: bool,
    /// The folder in which it opens.
    pub folder: Option<PathBuf>,
    /// The proposed name.
    pub name: String,
    /// Names of file types, each with its extensions; `*` for all files.
    pub types: Vec<(String, Vec<String>)>,
}

/// How a dialog was left.
#[derive(Clone, Debug, PartialEq)]
pub enum FileAnswer {
    /// Files were chosen.
    Chosen(Vec<PathBuf>),
    /// The user chose none.
    Cancelled,
    /// The desktop's dialog did not open, or the user would rather type a path.
    Failed,
}
